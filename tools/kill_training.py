#!/usr/bin/env python3
"""Kills training at random moments, resumes it each time, and compares the end with an uninterrupted run.

    tools/kill_training.py [--kills 100] [--seed 1] [--program target/release/gaitshift]

Every part of the run gets SIGKILL after a random time, most of them within a checkpoint: as soon as the folder
`checkpoint.new` or `checkpoint.old` appears, or a random fraction of a millisecond later. The run is small and writes a
checkpoint every 100 steps, so that most of its time passes in what a kill could damage. At the end controllers, logs, replay
buffer and agent must be those of the uninterrupted run, bit for bit; only columns that tell the wall-clock may differ.
"""

import argparse
import csv
import json
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent

EXPERIMENT = """
base = "fast"
name = "kills"
seed = 3
[[curriculum.phases]]
name = "first"
steps = 6000
omega_v = [-0.2, 3.0]
learner_end = {{ learning_rate = 1e-4, horizon = 60.0 }}
[[curriculum.phases]]
name = "second"
steps = {steps}
omega_v = [-0.2, 3.0]
learner = {{ rehearsal = 10.0 }}
[curriculum.phases.randomization]
share = 0.5
latency_s = [0.0, 0.015]
body = {{ friction = [0.6, 1.2] }}
[learner]
actor_hidden = [16]
critic_hidden = [16]
batch_size = 64
threads = 1
[training]
environments = 4
steps_per_update = 8
learning_starts = 500
metrics_interval_steps = 200
evaluation_interval_steps = 5000
checkpoint_interval_steps = 100
replay_capacity = 4000
[training.rehearsal]
states = 1000
"""

SAME = (
    "controller-last.safetensors",
    "controller.safetensors",
    "controller-walk.safetensors",
    "episodes.csv",
    "checkpoint/agent.safetensors",
    "checkpoint/replay.safetensors",
    "checkpoint/config.toml",
)


def without_clock(folder):
    """Logs without what tells the wall-clock."""
    with open(folder / "metrics.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    clock = rows[0].index("train/elapsed_s")
    metrics = [row[:clock] + row[clock + 1 :] for row in rows]
    text = (folder / "evaluations.jsonl").read_text(encoding="utf-8")
    evaluations = [json.loads(line) for line in text.splitlines()]
    for evaluation in evaluations:
        del evaluation["elapsed_s"]
    return metrics, evaluations


def appears(folder, process, limit_s):
    """Waits until a checkpoint is being written."""
    end = time.monotonic() + limit_s
    while process.poll() is None and time.monotonic() < end:
        if (folder / "checkpoint.new").exists() or (folder / "checkpoint.old").exists():
            return


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    parser.add_argument("--steps", type=int, default=20_000, help="length of the run; a longer one where it ends too early")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "target" / "release" / "gaitshift")
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    if not program.exists():
        sys.exit(f"error: there is no {program}; build it with `cargo build --release` or give --program")
    moments = random.Random(arguments.seed)

    with tempfile.TemporaryDirectory() as place:
        # Two places and one command: controllers name the command that made them.
        places = [pathlib.Path(place) / name for name in ("whole", "killed")]
        for own in places:
            own.mkdir()
            (own / "kills.toml").write_text(EXPERIMENT.format(steps=max(arguments.steps - 6000, 1)), encoding="utf-8")
        start = [program, "train", "kills.toml", "--out", "run"]
        whole, folder = (own / "run" for own in places)
        begin = time.monotonic()
        subprocess.run(start, cwd=places[0], check=True, capture_output=True)
        whole_s = time.monotonic() - begin

        kills, within, begun_anew, finished = 0, 0, 0, False
        # Short enough that as many kills fit into the run.
        longest_s = whole_s / arguments.kills
        while not finished:
            if (folder / "config.toml").exists():
                command = [program, "train", "--resume", "run"]
            else:
                # Killed before the run had begun: nothing to resume, nothing in the way.
                begun_anew += kills > 0
                command = start
            process = subprocess.Popen(command, cwd=places[1], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            if kills < arguments.kills:
                time.sleep(moments.uniform(0.0, longest_s))
                if moments.random() < 0.4:
                    appears(folder, process, 1.0)
                    time.sleep(moments.choice((0.0, moments.uniform(0.0, 0.002))))
                process.send_signal(signal.SIGKILL)
            message = process.communicate()[1].decode(errors="replace")
            if process.returncode == -signal.SIGKILL:
                kills += 1
                within += (folder / "checkpoint.new").exists() or (folder / "checkpoint.old").exists()
            elif process.returncode == 0:
                finished = True
            else:
                sys.exit(f"error: after {kills} kills, {command[1:]} failed:\n{message}")

        differ = [name for name in SAME if (whole / name).read_bytes() != (folder / name).read_bytes()]
        if without_clock(whole) != without_clock(folder):
            differ.append("metrics.csv or evaluations.jsonl")
        left = sorted(path.name for path in folder.iterdir() if path.name.endswith((".new", ".old")))
        if left:
            differ.append(f"left behind: {left}")
        print(
            f"{kills} kills, {within} of them within a checkpoint, {begun_anew} before the run had begun; "
            f"an uninterrupted run takes {whole_s:.1f} s"
        )
        if kills < arguments.kills:
            sys.exit("error: the run ended before all kills; give a greater --steps")
        if differ:
            sys.exit(f"error: these differ from the uninterrupted run: {', '.join(differ)}")
        print(f"the same bits: {', '.join(SAME)}; the same but for the wall-clock: metrics.csv, evaluations.jsonl")


if __name__ == "__main__":
    main()
