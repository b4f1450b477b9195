"""Contract: TensorBoard's own reader finds in a run's event file what metrics.csv and evaluations.jsonl say, every record
once, after the run was stopped and resumed too; and in a sweep's trials their settings, for its table of hyperparameters."""

import csv
import json

import numpy as np
from tensorboard.backend.event_processing.event_file_loader import EventFileLoader
from tensorboard.backend.event_processing.plugin_event_multiplexer import EventMultiplexer
from tensorboard.plugins.hparams import metadata


def test_tensorboard_reads_what_the_run_wrote(program, tiny, tmp_path):
    often = ["--set", "training.metrics_interval_steps=500", "--set", "training.checkpoint_interval_steps=1500"]
    program("train", tiny, *often, "--out", "run", "--steps", 2000, cwd=tmp_path)
    program("train", "--resume", "run", cwd=tmp_path)
    run = tmp_path / "run"
    first, *events = EventFileLoader(str(run / "events.out.tfevents.gaitshift")).Load()
    assert first.file_version == "brain.Event:2"
    scalars = {}
    for event in events:
        for value in event.summary.value:
            key = (event.step, value.tag)
            assert key not in scalars, key
            (scalars[key],) = value.tensor.float_val
    with open(run / "metrics.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["train/step"]) for row in rows] == list(range(500, 6001, 500))
    expected = {}
    for row in rows:
        step = int(row.pop("train/step"))
        expected |= {(step, tag): float(value) for tag, value in row.items()}
    for line in (run / "evaluations.jsonl").read_text().splitlines():
        evaluation = json.loads(line)
        step = evaluation["step"]
        expected[step, "evaluation/criteria_met"] = evaluation["met"]
        expected[step, "evaluation/score"] = evaluation["score"]
        for row in evaluation["rows"]:
            expected[step, f"evaluation/survived_s/{row['omega_v']:g}"] = row["survived_s"]
            if row["froude"] is not None:
                expected[step, f"evaluation/froude/{row['omega_v']:g}"] = row["froude"]
    assert scalars.keys() == expected.keys()
    for key, value in expected.items():
        assert scalars[key] == np.float32(value), key


def test_tensorboard_reads_the_settings_of_a_sweep(program, tiny, tmp_path):
    (tmp_path / "sweep.toml").write_text(
        f"""
name = "tiny"
experiment = "{tiny}"
seeds = [7]
[vary]
learner.learning_rate = [1e-3, 3e-4]
training.symmetry = ["none"]
"""
    )
    program("sweep", "sweep.toml", "--out", "runs", cwd=tmp_path)
    multiplexer = EventMultiplexer().AddRunsFromDirectory(str(tmp_path / "runs")).Reload()
    runs = multiplexer.PluginRunToTagToContent(metadata.PLUGIN_NAME)
    assert len(runs) == 2
    rates = set()
    for run, tags in runs.items():
        start = metadata.parse_session_start_info_plugin_data(tags[metadata.SESSION_START_INFO_TAG])
        settings = start.hparams
        assert not start.group_name, "runs of one group would share a row"
        assert set(settings) == {"variant", "seed", "learner.learning_rate", "training.symmetry"}
        assert settings["seed"].number_value == 7 and settings["training.symmetry"].string_value == "none"
        assert settings["variant"].string_value
        rates.add(settings["learner.learning_rate"].number_value)
        # Beside the scalars of the same run.
        assert multiplexer.Tensors(run, "evaluation/criteria_met")
    assert rates == {1e-3, 3e-4}
