"""Rows of "The screening" in docs/open-choices.md, from the runs of its sweep.

    gaitshift sweep experiments/open_choices/screening.toml
    python experiments/open_choices/rows.py runs/open-choices/*

Each argument is a folder of runs, one for each seed, as `seed-1`; files are passed over. A row gives the criteria
met by the kept controller, its step, its Froude numbers at the lowest and the highest command, with the gait where
it is not the one asked for; at how many evaluations from 3M steps on the
biped walks at the lowest command, runs at the highest, stays up at every command, and makes at least eight of ten
changes in both directions; and the criteria met at the end.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

FROM = 3_000_000
CHANGES = 8
NAMES = {"mixed": "neither", "walking": "walks", "running": "runs"}


def evaluations(run: Path) -> list[dict]:
    return [json.loads(line) for line in (run / "evaluations.jsonl").read_text().splitlines()]


def as_asked(row: dict) -> bool:
    return row["gait"] == row["asked"] and not row["fell"]


def froude(row: dict) -> str:
    if row["fell"]:
        return "falls"
    number = f"{row['froude']:.2f}"
    return number if as_asked(row) else f"{number} ({NAMES.get(row['gait'], row['gait'])})"


def succeeds(attempt: dict, gaits: list[str]) -> bool:
    return attempt["survived"] and [attempt["gait_before"], attempt["gait_after"]] == gaits


def changes(evaluation: dict) -> bool:
    made = [sum(succeeds(t, c["gaits"]) for t in c["tries"]) for c in evaluation["changes"]]
    return min(made) >= CHANGES


def row(folder: Path, run: Path) -> list[str]:
    made = evaluations(run)
    step = json.loads((run / "report.json").read_text())["best_step"]
    best = next(e for e in made if e["step"] == step)
    late = [e for e in made if e["step"] >= FROM]

    def ends(e: dict) -> list[dict]:
        return [r for r in e["rows"] if r["asked"]]

    def count(holds) -> str:
        return str(sum(bool(holds(e)) for e in late))

    return [
        folder.name,
        run.name.removeprefix("seed-"),
        str(best["met"]),
        f"{step / 1e6:.2f}M",
        ", ".join(froude(r) for r in ends(best)),
        f"{count(lambda e: as_asked(ends(e)[0]))} of {len(late)}",
        count(lambda e: as_asked(ends(e)[-1])),
        count(lambda e: not any(r["fell"] for r in e["rows"])),
        count(changes),
        str(made[-1]["met"]),
    ]


def main(folders: list[Path]) -> None:
    print("| level | seed | best, of 37 | at | Fr | walks | runs | upright | changes | last |")
    print("|" + " --- |" * 10)
    for folder in folders:
        for run in sorted(folder.glob("seed-*")):
            print("| " + " | ".join(row(folder, run)) + " |")


if __name__ == "__main__":
    main([Path(argument) for argument in sys.argv[1:]])
