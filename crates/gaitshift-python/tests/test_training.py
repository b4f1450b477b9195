"""Contract: a run from Python is the program's to the bit; stopped by callback, step, error or Ctrl-C it leaves a
checkpoint and goes on to the same bits; other threads go on meanwhile; a run's folder reads as frames and controllers, with
all its columns from the start on; what is wrong is one clear error."""

import logging
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import gaitshift

# What two equal runs have in common to the bit; logs have wall-clock columns too.
SAME = ["episodes.csv", "controller.safetensors", "controller-last.safetensors", "config.toml"]
LEARNER = ["checkpoint/agent.safetensors", "checkpoint/replay.safetensors"]


def assert_same(one, other, names):
    for name in names:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    ours, theirs = (gaitshift.Run(run).metrics.drop(columns="train/elapsed_s") for run in (one, other))
    assert ours.equals(theirs)


@pytest.fixture(scope="module")
def whole(tiny, tmp_path_factory):
    """A whole run, and what its callback was told."""
    told = []
    out = tmp_path_factory.mktemp("training") / "whole"
    settings = {"body": {"friction": np.float64(0.8)}, "training.metrics_interval_steps": 500}
    run = gaitshift.train(tiny, seed=3, out=out, set=settings, callback=told.append)
    return run, told


def test_it_is_the_programs_run_to_the_bit(whole, program, tiny, tmp_path):
    # The provenance in the controllers has the command: that of the program which makes the same ones.
    command = ["train", tiny, "--set", "body.friction=0.8", "--set", "training.metrics_interval_steps=500", "--seed", 3]
    program(*command, cwd=tmp_path)
    run, _ = whole
    assert run.finished
    assert_same(run.folder, tmp_path / "runs" / "tiny-run-3", SAME + LEARNER)


def test_the_callback_is_told_how_it_goes(whole):
    run, told = whole
    assert all(isinstance(progress, gaitshift.Progress) for progress in told)
    steps = [progress.step for progress in told]
    assert steps == sorted(steps) and steps[-1] == 6000
    assert {progress.total_steps for progress in told} == {6000}
    evaluations = [progress.evaluation for progress in told if progress.evaluation]
    assert [e["met"] for e in evaluations] == run.evaluations["met"].tolist()
    assert evaluations[0]["best"] and evaluations[0]["criteria"] == 39


def test_a_folder_reads_as_frames_and_controllers(whole):
    run, _ = whole
    assert list(run.metrics.index) == list(range(500, 6001, 500))
    assert {"learner/alpha", "reward/omega_v"} & set(run.metrics.columns)
    episodes = run.episodes
    assert len(episodes) > 10 and episodes["step"].is_monotonic_increasing
    assert list(run.evaluations.index) == [3000, 6000]
    assert run.evaluations["criteria"].tolist() == [39, 39]
    assert run.motions.groupby("step").size().tolist() == [8, 8]
    assert {"omega_v", "gait", "froude"} <= set(run.motions.columns)
    met = run.criteria.groupby("step")["met"].sum()
    assert met.tolist() == run.evaluations["met"].tolist()
    assert list(run.controllers) == [3000, 6000]
    step = int(run.evaluations["score"].idxmax())
    assert run.report["best_step"] == step
    assert run.best.onnx() == run.controllers[step].onnx()
    assert run.last.provenance["environment_steps"] == 6000
    assert run.config["body"]["friction"] == 0.8 and run.config["seed"] == 3
    assert repr(run).endswith("finished>")


def test_a_run_that_is_going_on_can_be_read(whole, tmp_path):
    # A line that is just being written is left out.
    run, _ = whole
    for name in ("config.toml", "metrics.csv", "episodes.csv", "evaluations.jsonl"):
        data = (run.folder / name).read_bytes()
        (tmp_path / name).write_bytes(data if name == "config.toml" else data[:-10])
    going = gaitshift.Run(tmp_path)
    assert len(going.metrics) == len(run.metrics) - 1
    assert len(going.episodes) == len(run.episodes) - 1
    assert list(going.evaluations.index) == [3000]
    assert going.report is None and not going.finished and not going.controllers
    with pytest.raises(FileNotFoundError, match="nothing has been evaluated yet"):
        _ = going.best


def test_before_the_first_evaluation_tables_have_their_columns(whole, tiny, tmp_path):
    run, _ = whole
    early = gaitshift.train(tiny, out=tmp_path / "run", steps=1000)
    for name in ("evaluations", "motions", "criteria", "metrics", "episodes"):
        assert list(getattr(early, name).columns) == list(getattr(run, name).columns), name
    assert early.motions.empty and early.criteria.empty
    # As docs/python.md has it; it was a KeyError.
    assert early.motions.pivot(index="step", columns="omega_v", values="gait").empty


def settings():
    return {"body.friction": 0.8, "training": {"metrics_interval_steps": 500}}


def test_stopped_by_callback_step_and_error_it_goes_on_to_the_same_bits(whole, tiny, tmp_path):
    out = tmp_path / "run"
    run = gaitshift.train(tiny, seed=3, out=out, set=settings(), callback=lambda p: p.step < 1500)
    assert not run.finished and 1500 <= run.report["step"] < 3000
    run.resume(steps=3500, threads=2)
    assert not run.finished and run.report["step"] >= 3500

    def fails(progress):
        raise ZeroDivisionError("in the callback")

    with pytest.raises(ZeroDivisionError, match="in the callback"):
        run.resume(callback=fails)
    assert not run.finished
    assert run.resume() is run
    assert run.finished
    whole_run, _ = whole
    assert_same(run.folder, whole_run.folder, SAME + LEARNER)


def test_none_from_the_callback_does_not_stop_it(tiny, tmp_path):
    run = gaitshift.train(tiny, out=tmp_path / "run", steps=2000, callback=lambda progress: None)
    assert run.report["step"] >= 2000


# What went wrong: only Python's own False stopped a run, so that a comparison of NumPy numbers did not.
@pytest.mark.parametrize("no", [np.False_, np.float64(1.0) < 0.0, 0, ""])
def test_whatever_is_false_but_none_stops_it(tiny, tmp_path, no):
    run = gaitshift.train(tiny, out=tmp_path / "run", steps=5000, callback=lambda progress: no)
    assert run.report["step"] < 3000


def test_an_answer_that_is_neither_true_nor_false_is_an_error(tiny, tmp_path):
    with pytest.raises(ValueError, match="truth value"):
        gaitshift.train(tiny, out=tmp_path / "run", callback=lambda progress: np.zeros(2))
    assert gaitshift.Run(tmp_path / "run").report["step"] < 3000


def test_ctrl_c_leaves_a_checkpoint(tiny, tmp_path):
    # What a shell starts in the background begins with Ctrl-C ignored, and so would the program started here.
    code = f"""
import signal
import gaitshift
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    gaitshift.train({str(tiny)!r}, seed=3, out="run", set={{"curriculum.phases": [
        {{"name": "long", "steps": 100_000_000, "omega_v": [-0.2, 0.2]}}]}},
        callback=lambda progress: print(progress.step, flush=True))
except KeyboardInterrupt:
    print("interrupted at", gaitshift.Run("run").report["step"])
"""
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        while int(process.stdout.readline()) < 2000:
            pass
        os.kill(process.pid, signal.SIGINT)
        said, _ = process.communicate(timeout=60)
    last = said.splitlines()[-1]
    assert last.startswith("interrupted at") and process.returncode == 0
    run = gaitshift.Run(tmp_path / "run")
    step = int(last.split()[-1])
    assert not run.finished and run.last.provenance["environment_steps"] == step
    # It goes on from there.
    assert run.resume(steps=step + 100).report["step"] >= step + 100


def test_other_threads_go_on_meanwhile(tiny, tmp_path):
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.002):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    gaitshift.train(tiny, out=tmp_path / "run", set={"training.evaluation_interval_steps": 10**9})
    done.set()
    thread.join()
    assert len(ticks) > 20


def test_evaluations_go_to_the_log(tiny, tmp_path, caplog):
    with caplog.at_level(logging.INFO, logger="gaitshift"):
        gaitshift.train(tiny, out=tmp_path / "run", steps=3000)
    assert "step 3000 of 6000" in caplog.text


@pytest.mark.parametrize(
    "arguments, error, words",
    [
        ({"experiment": "quick"}, ValueError, "no recipe `quick`"),
        ({"set": {"body.frictoin": 0.3}}, ValueError, "did you mean `friction`"),
        ({"set": {"body": {"friction": -1.0}}}, ValueError, "friction"),
        ({"set": {"body.friction": None}}, TypeError, "body.friction"),
        ({"set": {"body.friction": float("nan")}}, ValueError, "friction"),
        ({"threads": 0}, ValueError, "threads"),
        ({"seed": -1}, ValueError, "`seed` is -1"),
        ({"steps": 0.5}, ValueError, "`steps` is 0.5"),
        ({"callback": 3}, TypeError, "callable"),
    ],
)
def test_bad_arguments_are_named_and_nothing_is_written(tiny, tmp_path, arguments, error, words):
    with pytest.raises(error, match=words):
        gaitshift.train(**{"experiment": tiny, "out": tmp_path / "run", **arguments})
    assert not (tmp_path / "run").exists()


def test_bad_folders_are_named(whole, tiny, tmp_path):
    run, _ = whole
    with pytest.raises(ValueError, match="already holds a run"):
        gaitshift.train(tiny, out=run.folder)
    with pytest.raises(FileNotFoundError, match="is not a run's folder"):
        gaitshift.Run(tmp_path)
    (tmp_path / "config.toml").write_text('base = "fast"\n')
    with pytest.raises(ValueError, match="no checkpoint to resume from"):
        gaitshift.Run(tmp_path).resume()
    (tmp_path / "evaluations.jsonl").write_text("{\n")
    with pytest.raises(ValueError, match="line 1 is damaged"):
        _ = gaitshift.Run(tmp_path).evaluations


def test_without_pandas_the_error_says_what_to_install(whole, monkeypatch):
    run, _ = whole
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install 'crates/gaitshift-python\[pandas\]'"):
        _ = run.metrics
