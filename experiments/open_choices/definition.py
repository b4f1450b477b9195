"""Both gaits by the criteria here, and by the papers' own definition.

The papers call a gait with double support a walk and one with flight a run (Alexander 1996). Here a walk or a run must also
be made of steps that alternate, of a swing foot that does not touch the ground in mid-swing, and of equal steps
(docs/learning.md). This counts, in the evaluations of recorded runs after the last phase began, at how many the motion at
ω_v = 0 walks and that at the run's command runs, by either.

    python experiments/open_choices/definition.py controllers/paper controllers/fast-learner/paper

Each folder holds the seeds of one recipe; one row of a table comes of each. Needs Python 3.11.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import tomllib

# As in the rule for gaits: the slowest motion, the least share of steps, and the most of the other gait's phase.
MOVES_M_PER_S = 0.1
STEPS = 0.95
FOREIGN = 0.01


def has(row: dict, wanted: str, excluded: str) -> bool:
    """Whether nearly every step has the wanted phase and the motion next to nothing of the excluded one."""
    steps, share = row[f"steps_with_{wanted}"], row[excluded]
    moves = not row["fell"] and (row["speed_m_per_s"] or 0.0) >= MOVES_M_PER_S
    return moves and steps is not None and share is not None and steps >= STEPS and share <= FOREIGN


def counts(run: Path) -> tuple[int, list[int]]:
    """How many evaluations there are in the last phase, and of these: walks, both gaits, by the criteria and by the papers."""
    phases = tomllib.loads((run / "config.toml").read_text(encoding="utf-8"))["curriculum"]["phases"]
    begins = sum(phase["steps"] for phase in phases[:-1])
    evaluations = [json.loads(line) for line in (run / "evaluations.jsonl").read_text(encoding="utf-8").splitlines()]
    late = [evaluation["rows"] for evaluation in evaluations if evaluation["step"] > begins]
    totals = [0, 0, 0, 0]
    for rows in late:
        slow = next(row for row in rows if row["asked"] == "walking")
        fast = next(row for row in rows if row["asked"] == "running")
        walks = slow["gait"] == "walking", has(slow, "double_support", "flight")
        runs = fast["gait"] == "running", has(fast, "flight", "double_support")
        met = (walks[0], walks[1], walks[0] and runs[0], walks[1] and runs[1])
        totals = [total + now for total, now in zip(totals, met, strict=True)]
    return len(late), totals


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path, help="each with the runs of one recipe: seed-1, seed-2, ...")
    folders = parser.parse_args().folders
    print("| runs | evaluations | walks at 0 | by the papers' definition | both gaits | by the papers' definition |")
    print("| --- | --- | --- | --- | --- | --- |")
    for folder in folders:
        runs = sorted(folder.glob("seed-*"))
        if not runs:
            parser.error(f"{folder} has no runs: expected folders such as {folder / 'seed-1'}")
        seeds = [counts(run) for run in runs]
        columns = [", ".join(str(totals[k]) for _, totals in seeds) for k in range(4)]
        late = ", ".join(str(evaluations) for evaluations in sorted({evaluations for evaluations, _ in seeds}))
        print(f"| {folder} | {late} | {' | '.join(columns)} |")


if __name__ == "__main__":
    main()
