"""Contract: what experiments/full_runs/record.py keeps of a run is read like the run itself: the same controllers to the byte,
the same experiment, seed and best evaluation, evaluations and episodes with four significant digits, motions without their
account of the energy."""

import json

import numpy as np
import pytest
from conftest import experiment_script

import gaitshift


@pytest.fixture(scope="module")
def runs(tiny, tmp_path_factory):
    """A run, and what is kept of it."""
    folder = tmp_path_factory.mktemp("record")
    run = gaitshift.train(tiny, seed=3, out=folder / "run")
    return run, gaitshift.Run(experiment_script("full_runs/record.py").record(run.folder, folder / "kept"))


def test_the_copy_is_named_after_the_seed_and_cannot_be_resumed(runs):
    _, kept = runs
    assert kept.folder.name == "seed-3" and not (kept.folder / "checkpoint").exists()


def test_the_experiment_can_be_renamed(runs, tmp_path):
    kept = experiment_script("full_runs/record.py").record(runs[0].folder, tmp_path, "paper")
    ours, theirs = ((folder / "config.toml").read_text().splitlines() for folder in (runs[0].folder, kept))
    assert theirs[0] == 'name = "paper"' and theirs[1:] == ours[1:]


def test_controllers_configuration_and_report_are_the_runs(runs):
    for name in ("controller.safetensors", "controller-last.safetensors", "config.toml", "report.json"):
        assert (runs[0].folder / name).read_bytes() == (runs[1].folder / name).read_bytes(), name


def test_evaluations_and_episodes_are_the_same_to_four_digits(runs):
    run, kept = runs
    for name in ("evaluations", "motions", "criteria", "episodes"):
        ours, theirs = getattr(run, name), getattr(kept, name)
        ours = ours.drop(columns="energy_per_step", errors="ignore")
        assert list(ours.columns) == list(theirs.columns) and len(ours) == len(theirs) > 0, name
        for column in ours.select_dtypes("number"):
            np.testing.assert_allclose(theirs[column], ours[column], rtol=5e-4, err_msg=f"{name}: {column}")
        for column in ours.select_dtypes(exclude="number"):
            assert ours[column].equals(theirs[column]), f"{name}: {column}"
    # Scores choose the best controller.
    assert kept.evaluations["score"].tolist() == run.evaluations["score"].tolist()


def test_the_program_compares_it_like_the_run(runs, program):
    tables = [program("compare", run.folder, "--omega-v", 0, "--duration-s", 1, "--json") for run in runs]
    one, other = (json.loads(table)["runs"][0] for table in tables)
    one.pop("name"), other.pop("name"), one.pop("elapsed_s"), other.pop("elapsed_s")
    assert one == other
