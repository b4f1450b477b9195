"""Records what runs were found to do, so that `gaitshift reproduce --quick` judges the claims about them without training.

    gaitshift report --quick controllers/journal/* --out out/journal
    python experiments/full_runs/claims.py out/journal/report.json --experiment journal --runs "an update for every step" \
        --into crates/gaitshift-report/recorded/claims.json

Of each claim about the experiment the value of each seed is kept; verdicts are computed anew from them. Needs Python 3.11,
nothing else.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any


def recorded(report: dict[str, Any], experiment: str, runs: str) -> dict[str, Any]:
    seeds = next(e["seeds"] for e in report["experiments"] if e["name"] == experiment)
    own = [judged for judged in report["claims"] if judged["own"]["experiment"] == experiment]
    if len(own) == 0:
        raise SystemExit(f"no claim is about {experiment}")
    unmeasured = [judged["claim"] for judged in own if judged["own"]["verdict"] == "not_measured"]
    if unmeasured:
        raise SystemExit(f"not measured: {unmeasured[0]}; make the page of runs' folders, with what it is compared with")
    claims = {judged["claim"]: judged["own"]["seeds"] for judged in own}
    return {"name": experiment, "runs": runs, "seeds": seeds, "claims": claims}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("report", type=Path, help="report.json of a page of the runs")
    parser.add_argument("--experiment", required=True, help="the experiment whose claims are recorded")
    parser.add_argument("--runs", required=True, help="which runs these are, and how they learned, for the page")
    parser.add_argument("--into", type=Path, required=True, help="file of the recorded experiments; others in it stay")
    arguments = parser.parse_args()
    new = recorded(json.loads(arguments.report.read_text()), arguments.experiment, arguments.runs)
    kept = json.loads(arguments.into.read_text()) if arguments.into.exists() else []
    kept = [*(one for one in kept if one["name"] != new["name"]), new]
    arguments.into.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n")
    print(f"{new['name']}: {len(new['claims'])} claims of {len(new['seeds'])} seeds")


if __name__ == "__main__":
    main()
