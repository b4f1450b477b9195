"""Contract: experiments/full_runs/seeds.py shows of a run the kept controller and the last, once where they are the same; a
motion that falls has no figures, and of changes only those count that lead from the one gait to the other."""

import json

import pytest
from conftest import experiment_script

SINGLE_SUPPORT = "correlation_single_support"


@pytest.fixture(scope="module")
def script():
    return experiment_script("full_runs/seeds.py")


def motion(asked, gait, froude, fell=False):
    row = {"asked": asked, "gait": gait, "froude": froude, "fell": fell, "cost_of_transport": 0.25}
    row |= {"kinetic_potential_correlation": -0.5, f"kinetic_potential_{SINGLE_SUPPORT}": 0.75}
    return row | {f"elastic_kinetic_{SINGLE_SUPPORT}": None}


def change(before, after, *tries):
    tried = [{"survived": survived, "gait_before": b, "gait_after": a} for survived, b, a in tries]
    return {"gaits": [before, after], "tries": tried}


def run(folder, best_step, evaluations):
    (folder / "report.json").write_text(json.dumps({"best_step": best_step}))
    lines = [json.dumps(evaluation) for evaluation in evaluations]
    (folder / "evaluations.jsonl").write_text("\n".join(lines) + "\n")
    return folder


def test_the_kept_controller_and_the_last(script, tmp_path):
    up = change("walking", "running", (True, "walking", "running"), (True, "mixed", "running"), (False, "walking", "running"))
    down = change("running", "walking", (True, "running", "walking"), (True, "running", "mixed"))
    walk, between = motion("walking", "walking", 0.25), motion(None, "mixed", 0.5)
    good = {"step": 250_000, "met": 30, "rows": [walk, between, motion("running", "running", 1.0)], "changes": [down, up]}
    fall = {"step": 500_000, "met": 3, "changes": [up, down]}
    fall["rows"] = [motion("walking", "mixed", 0.75), between, motion("running", "fallen", 2.0, fell=True)]
    kept, last = script.rows_of(run(tmp_path, 250_000, [good, fall]))
    assert kept == [
        "best, 0.25M",
        "30",
        "walks: 0.25, 0.25, -0.50",
        "runs: 1.00, 0.25, 0.75, –",
        "1, 1",
        "0.25 to 1.00",
        "none",
    ]
    assert last[:4] == ["last, 0.50M", "3", "neither: 0.75, 0.25, -0.50", "falls"]
    # A Froude number of a motion that falls is none.
    assert last[5:] == ["0.50 to 0.75", "1"]


def test_one_row_where_the_last_is_kept(script, tmp_path):
    fall = motion("walking", "fallen", None, fell=True), motion("running", "fallen", None, fell=True)
    changes = [change("walking", "running"), change("running", "walking")]
    (row,) = script.rows_of(run(tmp_path, 250_000, [{"step": 250_000, "met": 0, "rows": fall, "changes": changes}]))
    assert row == ["best and last, 0.25M", "0", "falls", "falls", "0, 0", "–", "2"]
