"""Records what later figures need of a training run, small enough to be kept with the project.

    python experiments/full_runs/record.py runs/journal-1 --into controllers/journal

The copy is a run's folder that `gaitshift report`, `gaitshift compare` and `gaitshift evaluate --controller` read like the
run itself: configuration, report, best and last controller as they are; evaluations and episodes with four significant
digits, without the energy account of each motion, and of each change of gait that was tried only how it went. `--name`
renames the experiment in the configuration, where a recipe's settings were run under another name. It cannot be resumed.
Needs Python 3.11, nothing else.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
from pathlib import Path
from typing import Any

import tomllib

AS_THEY_ARE = ["config.toml", "report.json", "controller.safetensors", "controller-last.safetensors"]
OF_A_TRY = ["survived", "survived_s", "gait_before", "gait_after", "steps_to_change"]


def rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, list):
        return [rounded(element) for element in value]
    if isinstance(value, dict):
        return {key: rounded(element) for key, element in value.items()}
    return value


def evaluation(line: str) -> str:
    whole = json.loads(line)
    for change in whole["changes"]:
        change["tries"] = [{key: tried[key] for key in OF_A_TRY} for tried in change["tries"]]
    for row in whole["rows"]:
        del row["energy_per_step"]
    # Scores order controllers: they keep all digits.
    return json.dumps(rounded(whole) | {"score": whole["score"]}, separators=(",", ":"))


def record(run: Path, into: Path, name: str | None = None) -> Path:
    text = (run / "config.toml").read_text()
    config = tomllib.loads(text)
    folder = into / f"seed-{config['seed']}"
    folder.mkdir(parents=True, exist_ok=True)
    for file in AS_THEY_ARE:
        shutil.copyfile(run / file, folder / file)
    if name is not None:
        (folder / "config.toml").write_text(text.replace(f'name = "{config["name"]}"', f'name = "{name}"', 1))
    lines = (run / "evaluations.jsonl").read_text().splitlines()
    (folder / "evaluations.jsonl").write_text("".join(evaluation(line) + "\n" for line in lines))
    with (run / "episodes.csv").open(newline="") as source, (folder / "episodes.csv").open("w", newline="") as target:
        rows = csv.DictReader(source)
        writer = csv.DictWriter(target, rows.fieldnames or [], lineterminator="\n")
        writer.writeheader()
        for row in rows:
            for column in ("omega_v", "total_reward", "distance_m"):
                row[column] = f"{float(row[column]):.4g}"
            writer.writerow(row)
    return folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("runs", type=Path, nargs="+", help="folders of finished runs")
    parser.add_argument("--into", type=Path, required=True, help="folder of the copies, each named after its seed")
    parser.add_argument("--name", help="of the experiment, in the place of the run's own")
    arguments = parser.parse_args()
    for run in arguments.runs:
        print(record(run, arguments.into, arguments.name))


if __name__ == "__main__":
    main()
