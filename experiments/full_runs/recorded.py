"""Records what runs were found to do, so that `gaitshift reproduce --quick` judges and shows them without training.

    gaitshift report --quick controllers/journal/* --out out/journal
    python experiments/full_runs/recorded.py out/journal/report.json --experiment journal --learner "papers' learner" \
        --as "journal, papers' learner" --runs "one update per step" --into crates/gaitshift-report/recorded

Of each claim about the experiment, or that it is set beside, the value of each seed is kept, and verdicts are computed anew
from them (claims.json); of each seed what figures over several controllers draw, with four significant digits: its steady
motions (motions.csv) and the course of its training (training.csv). With `--as` they are kept under another name beside the
experiment's runs with another learner, and the page gives them a column of their own. Needs Python 3.11, nothing else.
"""

from __future__ import annotations

import argparse
import csv
import json
from pathlib import Path
from typing import Any

OF_A_MOTION = [
    "omega_v",
    "gait",
    "froude",
    "double_support",
    "flight",
    "cost_of_transport",
    "energy_change_j",
    "energy_recovery",
]
OF_A_STRETCH = ["from_step", "to_step", "mean_return", "falls"]


def claims(report: dict[str, Any], experiment: str, runs: str) -> dict[str, Any]:
    seeds = next((e["seeds"] for e in report["experiments"] if e["name"] == experiment), None)
    if seeds is None:
        raise SystemExit(f"no run of {experiment} is on the page")
    own = {judged["claim"]: judged["own"] for judged in report["claims"] if judged["own"]["experiment"] == experiment}
    unmeasured = [claim for claim, finding in own.items() if finding["verdict"] == "not_measured"]
    if unmeasured:
        raise SystemExit(f"not measured: {unmeasured[0]}; make the page of runs' folders, with what it is compared with")
    beside = {
        judged["claim"]: finding
        for judged in report["claims"]
        for finding in judged["beside"]
        if finding["experiment"] == experiment and finding["verdict"] != "not_measured"
    }
    found = own or beside  # No experiment has both.
    if len(found) == 0:
        raise SystemExit(f"no claim is about {experiment}, or measured beside it")
    values = {claim: finding["seeds"] for claim, finding in found.items()}
    return {"name": experiment, "runs": runs, "seeds": seeds, "claims": values}


def cell(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def rows(name: str, study: dict[str, Any], key: str, columns: list[str]) -> list[dict[str, str]]:
    named = {"experiment": name, "seed": str(study["seed"])}
    return [named | {column: cell(row[column]) for column in columns} for row in study[key]]


def replace(path: Path, experiment: str, columns: list[str], new: list[dict[str, str]]) -> None:
    """Puts an experiment's rows into a table, after those of the others."""
    kept: list[dict[str, str]] = []
    if path.exists():
        with path.open(newline="", encoding="utf-8") as file:
            kept = [row for row in csv.DictReader(file) if row["experiment"] != experiment]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, ["experiment", "seed", *columns], lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept + new)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("report", type=Path, help="report.json of a page of the runs")
    parser.add_argument("--experiment", required=True, help="the experiment that is recorded")
    parser.add_argument("--learner", help="what the runs learned with, in a few words: the head of their column")
    parser.add_argument("--as", dest="name", help="keep them under this name, beside runs with another learner")
    parser.add_argument("--runs", required=True, help="which runs these are, and how they learned, for the page")
    parser.add_argument("--into", type=Path, required=True, help="folder of the recorded experiments; others in it stay")
    arguments = parser.parse_args()
    if arguments.name is not None and arguments.learner is None:
        parser.error("--as: say with --learner what they learned with")
    report = json.loads(arguments.report.read_text(encoding="utf-8"))
    new = claims(report, arguments.experiment, arguments.runs)
    if arguments.learner is not None:
        new["learner"] = arguments.learner
    if arguments.name is not None:
        new |= {"name": arguments.name, "repeats": arguments.experiment}
    file = arguments.into / "claims.json"
    kept = json.loads(file.read_text(encoding="utf-8")) if file.exists() else []
    kept = [*(one for one in kept if one["name"] != new["name"]), new]
    file.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    studies = [study for study in report["studies"] if study["group"] == arguments.experiment]
    for name, key, columns in [("motions", "steady", OF_A_MOTION), ("training", "course", OF_A_STRETCH)]:
        table = [row for study in studies for row in rows(new["name"], study, key, columns)]
        replace(arguments.into / f"{name}.csv", new["name"], columns, table)
    print(f"{new['name']}: {len(new['claims'])} claims of {len(new['seeds'])} seeds")


if __name__ == "__main__":
    main()
