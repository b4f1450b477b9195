"""The knob turned slowly: gaits and speeds of controllers over stairs of the command, up and down.

    python experiments/knob/knob.py shipped runs/fast-7/controller.safetensors --out out/knob

The command rises from -0.5 to 4 in steps of 0.02, each held for 10 s, and another motion comes down from 4. The first 4 s of a
stair are left out. After a fall a fresh motion begins on the next stair from the default start. For each controller and
direction it prints

- the commands at which it walks, runs and falls;
- `gap`: the widest range of Froude numbers between the slowest walk and the fastest run at which no stair is;

and how much lower running ends on the way down than it begins on the way up (`hysteresis`), by the lower ends of the widest
range of running each way. With --out every stair goes into
a CSV file.
"""

from __future__ import annotations

import argparse
import csv
import itertools
from pathlib import Path

import gaitshift

FIELDS = ("omega_v", "gait", "froude", "double_support", "flight", "survived_s")


def on_stairs(controller: gaitshift.Controller, commands: list[float], hold_s: float) -> list[dict]:
    """A row for each command; what fell has the gait "fallen"."""
    period_s = controller.control_period_s
    rows: list[dict] = []
    while len(rows) < len(commands):
        # A recording lasts an hour at most; then the next begins.
        rest = commands[len(rows) :][: max(1, int(3600 // hold_s))]
        profile = []
        for k, omega_v in enumerate(rest):
            profile += [(k * hold_s, omega_v), ((k + 1) * hold_s - period_s, omega_v)]
        motion = controller.record(profile, len(rest) * hold_s)
        columns = dict(motion.items())
        time_s = columns["time_s"]
        for k, omega_v in enumerate(rest):
            here = (k * hold_s <= time_s + 1e-9) & (time_s + 1e-9 < (k + 1) * hold_s)
            if here.sum() < round(hold_s / period_s):
                # The fall is this stair's; nothing else of it is a steady motion.
                rows.append({"omega_v": omega_v, "gait": "fallen", "survived_s": float(here.sum()) * period_s})
                break
            part = {name: values[here] for name, values in columns.items()}
            part["time_s"] = part["time_s"] - part["time_s"][0]
            metadata = motion.metadata | {"fell": False, "ended_by": "time limit"}
            summary = gaitshift.Recording(metadata, part).summary(settling_time_s=0.4 * hold_s)
            rows.append({"omega_v": omega_v} | {name: summary.get(name) for name in FIELDS[1:]})
    return rows


def blocks(rows: list[dict], gait: str, step: float) -> list[tuple[float, float]]:
    """The ranges of neighbouring commands with this gait."""
    found: list[tuple[float, float]] = []
    for omega_v in sorted(row["omega_v"] for row in rows if row["gait"] == gait):
        if found and omega_v - found[-1][1] < 1.5 * step:
            found[-1] = (found[-1][0], omega_v)
        else:
            found.append((omega_v, omega_v))
    return found


def words(ranges: list[tuple[float, float]]) -> str:
    return ", ".join(f"{a:g}" if a == b else f"{a:g} to {b:g}" for a, b in ranges) or "nowhere"


def widest_gap(rows: list[dict]) -> tuple[float, float] | None:
    """The widest range of Froude numbers without a stair, between a walk and a run."""
    walks = [row["froude"] for row in rows if row["gait"] == "walking"]
    runs = [row["froude"] for row in rows if row["gait"] == "running"]
    if not walks or not runs:
        return None
    between = sorted(
        row["froude"] for row in rows if min(walks) <= (row.get("froude") or -1.0) <= max(runs)
    )
    return max(itertools.pairwise(between), key=lambda pair: pair[1] - pair[0], default=None)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("controllers", nargs="+", help="files or names")
    parser.add_argument("--out", type=Path, help="folder for a CSV file of every controller and direction")
    parser.add_argument("--lowest", type=float, default=-0.5, help="lowest command")
    parser.add_argument("--highest", type=float, default=4.0, help="highest command")
    parser.add_argument("--step", type=float, default=0.02, help="from stair to stair")
    parser.add_argument("--hold-s", type=float, default=10.0, help="how long each is held")
    arguments = parser.parse_args()
    count = round((arguments.highest - arguments.lowest) / arguments.step)
    up = [round(arguments.lowest + k * arguments.step, 9) for k in range(count + 1)]
    for name in arguments.controllers:
        controller = gaitshift.Controller.load(name)
        onsets = []
        for direction, commands in (("up", up), ("down", up[::-1])):
            rows = on_stairs(controller, commands, arguments.hold_s)
            gap = widest_gap(rows)
            runs = blocks(rows, "running", arguments.step)
            onsets.append(max(runs, key=lambda block: block[1] - block[0], default=(None,))[0])
            print(f"{name}, {direction}:")
            for gait in ("walking", "running", "fallen"):
                print(f"  {gait:8} at {words(blocks(rows, gait, arguments.step))}")
            if gap:
                print(f"  gap      from Fr {gap[0]:.2f} to {gap[1]:.2f}")
            if arguments.out:
                arguments.out.mkdir(parents=True, exist_ok=True)
                stem = name.strip("/").replace("/", "_").removesuffix(".safetensors")
                with (arguments.out / f"{stem}_{direction}.csv").open("w", newline="") as file:
                    writer = csv.DictWriter(file, FIELDS)
                    writer.writeheader()
                    writer.writerows(rows)
        if None not in onsets:
            print(f"  hysteresis {onsets[0] - onsets[1]:+.2f}: running begins at {onsets[0]:g} and ends at {onsets[1]:g}")


if __name__ == "__main__":
    main()
