"""Contract: a sweep on Ray ends in the bits of `gaitshift sweep`, with two workers killed in the middle and the whole stopped
and begun again; two nodes share the work; no trial begins from the start twice; what is wrong is one clear error.

Needs Ray (`pip install 'crates/gaitshift-python[ray]'`), which the other tests do not; left out where it is not installed."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import gaitshift

pytest.importorskip("ray.tune")

SWEEP = """
name = "on ray"
experiment = "./tiny.toml"
seeds = [1, 2, 3, 4]
[set.training]
checkpoint_interval_steps = 4000
evaluation_interval_steps = 40_000
[[set.curriculum.phases]]
name = "only"
steps = 80_000
omega_v = [-0.2, 0.2]
[vary]
body.friction = [0.5, 0.8, 1.0]
"""
NAMES = ["episodes.csv", "controller.safetensors", "controller-last.safetensors", "config.toml",
         "checkpoint/agent.safetensors", "checkpoint/replay.safetensors", "events.out.tfevents.a-settings"]  # fmt: skip


def parents():
    """The parent of every process."""
    found = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            found[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    return found


def workers(driver):
    """Processes below the driver that run a trial."""
    parent = parents()

    def is_below(pid):
        while pid in parent and pid != driver:
            pid = parent[pid]
        return pid == driver

    def name(pid):
        try:
            return (Path("/proc") / str(pid) / "cmdline").read_bytes()
        except OSError:
            return b""

    return [pid for pid in parent if is_below(pid) and b"ray::ImplicitFunc.train" in name(pid)]


def reports(storage):
    """What each trial reported, in order: step and process."""
    found = {}
    for file in sorted(storage.glob("*/result.json")):
        lines = [json.loads(line) for line in file.read_text().splitlines() if line.endswith("}")]
        found[file.parent.name] = [(line["step"], line["pid"]) for line in lines]
    return found


def start(folder):
    environment = {**os.environ, "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0", "PYTHONUNBUFFERED": "1"}
    command = [sys.executable, "-m", "gaitshift.ray", "sweep.toml"]
    with open(folder / "log", "ab") as log:
        return subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, env=environment)


def wait_until(holds, driver, seconds=300):
    for _ in range(10 * seconds):
        value = holds()
        if value:
            return value
        assert driver.poll() is None, "the sweep ended too early"
        time.sleep(0.1)
    raise AssertionError("it takes too long")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for workers in /proc")
def test_killed_and_begun_again_it_ends_in_the_bits_of_the_local_sweep(program, tiny, tmp_path):
    (tmp_path / "tiny.toml").write_bytes(tiny.read_bytes())
    (tmp_path / "sweep.toml").write_text(SWEEP)
    storage = tmp_path / "runs" / "on-ray-ray" / "on-ray"

    driver = start(tmp_path)
    killed = set()

    def kill_one():
        # In the middle: a trial that has reported more than its beginning and is not at its end.
        going = {pid for lines in reports(storage).values() for step, pid in lines[-1:] if 10 < step < 70_000}
        for pid in set(workers(driver.pid)) & going - killed:
            os.kill(pid, signal.SIGKILL)
            killed.add(pid)
            return True
        return False

    wait_until(kill_one, driver)
    wait_until(kill_one, driver)
    # The whole is stopped when some trials are finished and others are not.
    wait_until(lambda: sum(lines[-1][0] >= 80_000 for lines in reports(storage).values() if lines) >= 4, driver)
    driver.send_signal(signal.SIGINT)
    driver.wait(timeout=120)
    assert driver.returncode != 0

    driver = start(tmp_path)
    assert driver.wait(timeout=600) == 0, (tmp_path / "log").read_text()[-3000:]
    assert "going on with the sweep" in (tmp_path / "log").read_text()

    told = reports(storage)
    assert len(told) == 12 and len(killed) == 2
    for name, lines in told.items():
        steps = [step for step, _ in lines]
        assert steps[-1] >= 80_000, name
        # Each later process goes on from a checkpoint. Only a trial that was stopped before its first begins again.
        first = next(index for index, step in enumerate(steps) if step > 10)
        assert all(step > 10 for step in steps[first:]), (name, steps)
    resumed = [name for name, lines in told.items() if len({pid for _, pid in lines}) > 1]
    assert len(resumed) >= 2

    program("sweep", "sweep.toml", "--out", "local", cwd=tmp_path)
    folders = sorted(path.parent.relative_to(tmp_path / "local") for path in tmp_path.glob("local/*/*/report.json"))
    assert len(folders) == 12
    for folder in folders:
        ours, theirs = tmp_path / "runs" / "on-ray" / folder, tmp_path / "local" / folder
        for name in NAMES:
            assert (ours / name).read_bytes() == (theirs / name).read_bytes(), (folder, name)
    # The local program takes the folders for its own.
    table = json.loads(program("sweep", "sweep.toml", "--out", "runs/on-ray", "--table", "--json", cwd=tmp_path))
    assert table["variants"][0]["finished"] == 4
    assert table["variants"] == json.loads((tmp_path / "runs" / "on-ray" / "table.json").read_text())["variants"]


NODES = """
import json, sys, time
from pathlib import Path
from ray.cluster_utils import Cluster
from gaitshift.ray import sweep

nodes = int(sys.argv[1])
cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
for _ in range(nodes - 1):
    cluster.add_node(num_cpus=1)
start = time.monotonic()
sweep("sweep.toml", address=cluster.address, out=f"nodes-{nodes}")
took_s = time.monotonic() - start
spans = []
for file in Path(f"nodes-{nodes}-ray").glob("*/*/result.json"):
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    spans.append((lines[0]["timestamp"], lines[-1]["timestamp"]))
at_once = max(sum(first <= begun < last for first, last in spans) for begun, _ in spans)
cluster.shutdown()
print(json.dumps({"trials": len(spans), "at_once": at_once, "took_s": took_s}))
"""


def test_two_nodes_share_the_work(tiny, tmp_path):
    (tmp_path / "tiny.toml").write_bytes(tiny.read_bytes())
    few = SWEEP.replace("seeds = [1, 2, 3, 4]", "seeds = [1, 2]").replace("80_000", "100_000")
    (tmp_path / "sweep.toml").write_text(few)
    told = {}
    for nodes in (1, 2):
        command = [sys.executable, "-c", NODES, str(nodes)]
        result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert result.returncode == 0, result.stderr[-3000:]
        told[nodes] = json.loads(result.stdout.splitlines()[-1])
    print(f"\n{told[1]['trials']} trials: one node {told[1]['took_s']:.0f} s, two nodes {told[2]['took_s']:.0f} s")
    # One processor each, so several at once are several nodes.
    assert (told[1]["at_once"], told[2]["at_once"]) == (1, 2)
    for path in sorted((tmp_path / "nodes-1").glob("*/*/controller.safetensors")):
        assert path.read_bytes() == (tmp_path / "nodes-2" / path.relative_to(tmp_path / "nodes-1")).read_bytes()


def refused(folder, *arguments):
    command = [sys.executable, "-m", "gaitshift.ray", *arguments]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    errors = [line for line in result.stderr.splitlines() if line.startswith("error:")]
    assert len(errors) == 1 and "Traceback" not in result.stderr, result.stderr
    assert result.returncode == 2
    return errors[0]


def test_bad_input_is_one_clear_error(tiny, tmp_path):
    (tmp_path / "tiny.toml").write_bytes(tiny.read_bytes())
    (tmp_path / "sweep.toml").write_text(SWEEP)
    (tmp_path / "bad.toml").write_text(SWEEP.replace("friction", "frictoin"))
    assert "did you mean `friction`" in refused(tmp_path, "bad.toml")
    assert "none.toml" in refused(tmp_path, "none.toml")
    assert "no Ray cluster at 127.0.0.1:1" in refused(tmp_path, "sweep.toml", "--address", "127.0.0.1:1")
    kept = tmp_path / "runs" / "on-ray" / "ray-trials.json"
    trials = json.loads(kept.read_text())
    kept.write_text("[]")
    assert "another --out" in refused(tmp_path, "sweep.toml")
    # Runs of another program, which were replaced.
    kept.unlink()
    run = kept.parent / trials[1]["folder"]
    run.mkdir(parents=True)
    (run / "config.toml").write_text("")
    assert f"{trials[1]['folder']} holds a run of another sweep" in refused(tmp_path, "sweep.toml")
    assert not kept.exists()


def test_a_worker_of_another_version_says_so():
    from gaitshift.ray import train_trial

    trial = {"config": "", "command": "", "version": "0.0.0"}
    with pytest.raises(RuntimeError, match=rf"has gaitshift {gaitshift.__version__}, the sweep was begun with 0\.0\.0"):
        train_trial({"trial": trial})
