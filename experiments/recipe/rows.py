"""Rows of "Left out one at a time" in docs/leave-one-out.md, from the runs of a sweep.

    gaitshift sweep experiments/recipe/leave_one_out.toml
    python experiments/recipe/rows.py runs/leave-one-out/*

Each argument is a folder of runs, one for each seed, as `seed-7`; files are passed over. A row gives, seed by
seed: the criteria met by the kept controller and at the end; at which step the run first walks at the lowest
command and runs at the one where a run is asked; how many of the last twelve evaluations meet all but two
criteria; the share of training episodes of the last million steps that fall; of the kept controller, how many
of the motions from twelve random starts at each command fall, the greatest Froude number, the cost of transport
of the run, and at how many commands the step times of right and left differ by more than 5 %.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

HEADINGS = (
    "left out",
    "best",
    "last",
    "both gaits first at, M",
    "good of 12",
    "episodes that fall, %",
    "random starts that fall",
    "greatest Fr",
    "CoT of the run",
    "limps at",
)


def evaluations(run: Path) -> list[dict]:
    return [json.loads(line) for line in (run / "evaluations.jsonl").read_text().splitlines()]


def asymmetries(evaluation: dict) -> list[float]:
    return [row["step_time_asymmetry"] or 0.0 for row in evaluation["rows"]]


def kept(run: Path, made: list[dict]) -> dict:
    """The evaluation whose controller the run keeps."""
    step = json.loads((run / "report.json").read_text())["best_step"]
    return next(evaluation for evaluation in made if evaluation["step"] == step)


def has_both_gaits(evaluation: dict) -> bool:
    asked = [row for row in evaluation["rows"] if row["asked"]]
    return all(row["gait"] == row["asked"] and not row["fell"] for row in asked)


def falling_share(run: Path) -> float:
    """Share of the episodes that end in a fall, over the last million steps."""
    with (run / "episodes.csv").open() as file:
        episodes = [(int(row["step"]), row["ended"]) for row in csv.DictReader(file)]
    late = [ended for step, ended in episodes if step > episodes[-1][0] - 1_000_000]
    return sum(ended != "time limit" for ended in late) / len(late)


def random_falls(run: Path) -> int:
    command = ["gaitshift", "evaluate", "--controller", str(run / "controller.safetensors"), "--seed", "1..12", "--json"]
    rows = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)["rows"]
    return sum(row["fell"] for row in rows)


def of_run(run: Path) -> list[str]:
    made = evaluations(run)
    best = kept(run, made)
    both = next((f"{e['step'] / 1e6:.2f}" for e in made if has_both_gaits(e)), "–")
    good = sum(e["met"] >= len(e["checks"]) - 2 for e in made[-12:])
    ran = next((row for row in best["rows"] if row["asked"] == "running"), None)
    cost = f"{ran['cost_of_transport']:.3f}" if ran and ran["gait"] == "running" else "–"
    return [
        str(best["met"]),
        str(made[-1]["met"]),
        both,
        str(good),
        f"{100 * falling_share(run):.1f}",
        str(random_falls(run)),
        f"{max(row['froude'] or 0.0 for row in best['rows']):.2f}",
        cost,
        str(sum(a > 0.05 for a in asymmetries(best))),
    ]


def main() -> None:
    print("| " + " | ".join(HEADINGS) + " |")
    print("| " + " | ".join("---" for _ in HEADINGS) + " |")
    # A sweep's own tables lie beside its variants.
    for folder in filter(Path.is_dir, map(Path, sys.argv[1:])):
        runs = [run for run in folder.iterdir() if (run / "evaluations.jsonl").is_file()]
        runs.sort(key=lambda run: int(run.name.rpartition("-")[2]))
        columns = zip(*map(of_run, runs), strict=True)
        print(f"| {folder.name} | " + " | ".join(", ".join(column) for column in columns) + " |", flush=True)


if __name__ == "__main__":
    main()
