"""What the kept and the last controller of recorded runs do: the table of docs/papers-methods.md, a run in two rows.

    python experiments/full_runs/seeds.py controllers/journal/seed-1 controllers/paper/seed-1

The motion at ω_v = 0 has the correlation of kinetic with potential energy over whole strides; that at the run's command has, in
single support, this one and that of elastic with kinetic energy. Needs Python 3.11, nothing else.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

GAITS = {"walking": "walks", "running": "runs", "standing": "stands"}


def number(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def motion(row: dict[str, Any], correlations: list[str]) -> str:
    if row["fell"]:
        return "falls"
    gait = GAITS.get(row["gait"], "neither")
    values = [row["froude"], row["cost_of_transport"], *(row[name] for name in correlations)]
    return f"{gait}: {', '.join(number(value) for value in values)}"


def changed(change: dict[str, Any]) -> int:
    """How many tries lead from the one gait to the other."""
    tries = change["tries"]
    return sum(t["survived"] and [t["gait_before"], t["gait_after"]] == change["gaits"] for t in tries)


def columns(evaluation: dict[str, Any], what: str) -> list[str]:
    rows = evaluation["rows"]
    slow = next(row for row in rows if row["asked"] == "walking")
    fast = next(row for row in rows if row["asked"] == "running")
    up, down = (next(c for c in evaluation["changes"] if c["gaits"][1] == gait) for gait in ("running", "walking"))
    froude = [row["froude"] for row in rows if not row["fell"] and row["froude"] is not None]
    fall = sum(row["fell"] for row in rows)
    return [
        f"{what}, {evaluation['step'] / 1e6:.2f}M",
        str(evaluation["met"]),
        motion(slow, ["kinetic_potential_correlation"]),
        motion(
            fast, ["kinetic_potential_correlation_single_support", "elastic_kinetic_correlation_single_support"]
        ),
        f"{changed(up)}, {changed(down)}",
        f"{number(min(froude))} to {number(max(froude))}" if froude else "–",
        str(fall) if fall else "none",
    ]


def rows_of(run: Path) -> list[list[str]]:
    report = json.loads((run / "report.json").read_text(encoding="utf-8"))
    lines = (run / "evaluations.jsonl").read_text(encoding="utf-8").splitlines()
    evaluations = [json.loads(line) for line in lines]
    best = next(e for e in evaluations if e["step"] == report["best_step"])
    last = evaluations[-1]
    if best is last:
        return [columns(best, "best and last")]
    return [columns(best, "best"), columns(last, "last")]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", type=Path, nargs="+", help="folders of recorded runs")
    runs = parser.parse_args().runs
    names = ["run", "controller", "criteria", "at 0: Fr, CoT, correlation", "at the top: Fr, CoT, correlations"]
    names += ["changes up, down", "Fr at all commands", "commands that fall"]
    print(f"| {' | '.join(names)} |\n|{' --- |' * len(names)}")
    for run in runs:
        for k, values in enumerate(rows_of(run)):
            print(f"| {' | '.join([str(run) if k == 0 else '', *values])} |")


if __name__ == "__main__":
    main()
