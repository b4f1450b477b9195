"""Contract: experiments/open_choices/definition.py counts a walk by the papers' definition where nearly every step has double
support and there is next to no flight, a run the other way round, and only evaluations of the last phase."""

import json

import pytest
from conftest import experiment_script


@pytest.fixture(scope="module")
def script():
    return experiment_script("open_choices/definition.py")


def motion(asked, gait, **changes):
    walks = gait == "walking"
    row = {"asked": asked, "gait": gait, "fell": False, "speed_m_per_s": 1.0}
    row |= {"steps_with_double_support": float(walks), "double_support": 0.2 * walks}
    row |= {"steps_with_flight": float(not walks), "flight": 0.2 * (not walks)}
    return row | changes


def test_a_gait_is_told_by_its_phases(script):
    walk = motion("walking", "walking")
    assert script.has(walk, "double_support", "flight") and not script.has(walk, "flight", "double_support")
    # A swing foot that touches down on the way does not matter here.
    assert script.has(walk | {"gait": "mixed"}, "double_support", "flight")
    for changes in (
        {"fell": True},
        {"speed_m_per_s": 0.05},
        {"speed_m_per_s": None},
        {"flight": 0.02},
        {"steps_with_double_support": 0.9},
        {"steps_with_double_support": None},
    ):
        assert not script.has(walk | changes, "double_support", "flight"), changes


def test_only_the_last_phase_counts(script, tmp_path):
    (tmp_path / "config.toml").write_text("[[curriculum.phases]]\nsteps = 100\n[[curriculum.phases]]\nsteps = 300\n")
    walk, run = motion("walking", "walking"), motion("running", "running")
    scuffs = walk | {"gait": "mixed"}
    fall = run | {"gait": "fallen", "fell": True}
    evaluations = [(100, walk, run), (200, walk, run), (300, scuffs, run), (400, scuffs, fall)]
    lines = [json.dumps({"step": step, "rows": rows}) for step, *rows in evaluations]
    (tmp_path / "evaluations.jsonl").write_text("\n".join(lines) + "\n")
    assert script.counts(tmp_path) == (3, [1, 3, 1, 2])
