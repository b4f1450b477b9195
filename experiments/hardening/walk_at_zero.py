"""Searches a walk at ω_v = 0 that bears stronger pushes, by what is added to a controller's commands.

Added to the command of each leg, before the tanh, is a function of the angle between the legs, one while the leg swings
forward and one while it goes back, and a linear function of the observations: 14 and 13 numbers, the same for both legs.
CMA-ES (Hansen 2016) looks for those with the fewest falls under pushes forward and backward, before `--steps` up, with a
`--latency` and on a `--raised` body. All these begin with states of the walk itself, or random starts, that are drawn anew in
each generation; a walk with too little double support, or faster than `--speed`, counts as worse. All of it becomes units of
the controller's own network, which are silent at other commands. What comes out can be shaped again, until map_command.py has
put a layer before it.

OUT gets a controller every five generations, of the mean that CMA-ES has come to; log.csv, in which a row is of the mean
that the generation begins with; and search.pickle, from which the same command goes on. Needs PyTorch, safetensors and cma
beside the package; a generation takes about 35 s of two cores, with steps, a latency and a raised body 80 s and more:

    pip install torch safetensors cma
    before=controllers/robust/shaped-when-fast.safetensors
    python experiments/hardening/walk_at_zero.py --controller $before --out out/walk
    python experiments/hardening/falls.py robust out/walk/40.safetensors

After a push backward, and at a step, the hip is slower than it ever is in the walk, so that what fades from a speed on leaves
the walk as it is. Then falls are few, and with `--hard` those states are looked for first from which it falls now, or comes to
a stand before a step:

    python experiments/hardening/walk_at_zero.py --controller out/walk/40.safetensors --out out/slow --slower-than 0.3 \
        --hard 3000 --deviation 0.1 --pushes=-200:1,-250:1,-300:1 --steps 0.02:1,0.03:1

After a push forward it is faster (`--faster-than 1.35`). So it is after a run; therefore every third undisturbed motion
begins with one. `--begin-with` goes on from the numbers of another search.
"""

from __future__ import annotations

import argparse
import csv
import json
import multiprocessing
import pickle
import time
from pathlib import Path

import cma
import numpy as np
import torch
from hard_cases import COORDINATES, STEP_AT_M, VELOCITIES, Case, as_controller, falls
from policy_gradient import OMEGA_V, Actor
from torch import nn

import gaitshift

# Places among the observations.
SPEED, RIGHT_PHI, LEFT_PHI = 0, 7, 9  # each leg's angular velocity stands behind its angle
KNOTS_RAD = (-0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45)  # of the leg's angle less the other's; constant beyond
OBSERVED = 13  # all but the command
STATE = COORDINATES + VELOCITIES
NUMBERS = 2 * len(KNOTS_RAD) + OBSERVED
UNITS = 16  # of each half of the network and layer, all but a few of them used
CLOSES = 0.6  # per rad/s: how fast the function of a swinging leg ends as it goes back, and the reverse
FADES = 20.0  # per m/s: how fast all of it fades beyond a speed
ENDS, ENDS_WITHIN = 0.2, 20.0  # |ω_v| in s/m up to which it is added, and how fast it ends beyond, per s/m

STARTS, LONG_S, SETTLED_S = 27, 18.0, 6.0  # undisturbed motions, how long, and from when on they are a walk
AFTER_A_RUN = ((0.0, 2.0), (1.6, 2.0), (2.0, 0.0))  # s and s/m; in every third of them
LAST, EVERY = 1400, 112  # control periods at their end, and between two that are pushed: a walk may change speed for long
UP, OVER = 260, 800  # control periods that it has to stay up from the push on, and has to get over a step
AHEAD_M = (0.45, 0.96)  # how far before a step's face the hip is at first, over a whole step of the walk
LATE, LATE_S = 54, 16.0  # motions with a latency, and how long
RAISED, RAISED_S = 108, 6.0  # the same on a raised body
HARD, OTHERS = 40, 120  # states, of those with `--hard` from which it fell at first and of others
MEASURED = ("speed_m_per_s", "double_support", "flight")
LEAST_DOUBLE_SUPPORT = 0.08  # share of the time, as flight
NO_WALK, LACKING, LARGE = 30.0, 20.0, 0.002  # what it costs not to walk, too much speed and so on, and numbers far from 0


class Shaped(Actor):
    """A controller whose walk at 0 is shaped by values at the knots, those of a swinging leg first, and a linear function of
    the scaled observations."""

    def __init__(self, path: Path, values: np.ndarray, slower_than: float = np.inf, faster_than: float = -np.inf) -> None:
        super().__init__(path)
        before, self.before = self.layers, self.file
        units = before[0].bias.shape[0]
        self.units, wide = units, units + UNITS
        self.layers = nn.ModuleList([nn.Linear(14, wide), nn.Linear(wide, wide), nn.Linear(wide, 2)]).requires_grad_(False)
        first, second, output = self.layers
        for layer, old in zip(self.layers, before):
            layer.weight.zero_()[: old.weight.shape[0], : old.weight.shape[1]] = old.weight.detach()
            layer.bias.zero_()[: old.bias.shape[0]] = old.bias.detach()
        apart, faster, command = torch.zeros(3, 14)
        for row, behind in ((apart, 0), (faster, 1)):
            row[RIGHT_PHI + behind] = 1 / self.scale[RIGHT_PHI + behind]
            row[LEFT_PHI + behind] = -1 / self.scale[LEFT_PHI + behind]
        command[OMEGA_V] = 1 / self.scale[OMEGA_V]
        knots = torch.tensor(KNOTS_RAD)
        hinges = slice(units, units + len(knots))
        first.weight[hinges], first.bias[hinges] = apart, -knots
        back, forward, above, below = range(hinges.stop, hinges.stop + 4)
        first.weight[back], first.weight[forward] = -faster, faster
        first.weight[above], first.weight[below] = command, -command
        first.bias[[above, below]] = -ENDS
        quick, slow = below + 1, below + 2
        for unit, sign, limit in ((quick, 1, slower_than), (slow, -1, faster_than)):
            if np.isfinite(limit):
                first.weight[unit, SPEED], first.bias[unit] = sign / self.scale[SPEED], -sign * limit
        # What a function has of either sign is a unit's of its own, since a unit is never negative.
        swinging, going_back = np.split(values[:-OBSERVED], 2)
        for pair, at_knots, ends in ((units, swinging, back), (units + 2, going_back, forward)):
            bends = np.diff(np.diff(at_knots) / np.diff(KNOTS_RAD), prepend=0.0, append=0.0)
            for unit, sign in ((pair, 1), (pair + 1, -1)):
                second.weight[unit, hinges] = torch.tensor(sign * bends, dtype=torch.float32)
                second.bias[unit] = float(sign * at_knots[0])
                second.weight[unit, ends] = -CLOSES
        linear = slow + 1
        for unit, sign in ((linear, 1), (linear + 1, -1)):
            first.weight[unit, :OBSERVED] = torch.tensor(sign * values[-OBSERVED:], dtype=torch.float32)
            second.weight[unit, unit] = 1.0
        for pair in (units, units + 2, linear):
            closed_by = torch.tensor([-ENDS_WITHIN, -ENDS_WITHIN, -FADES, -FADES])
            second.weight[pair : pair + 2, [above, below, quick, slow]] = closed_by
            output.weight[0, pair : pair + 2] = torch.tensor([2.0, -2.0])  # of one half, which is half of the mean

    def save(self, path: Path, seed: int) -> None:
        """Writes it as a controller, whose network is as wide as it has become."""
        description = json.loads(self.metadata["gaitshift"])
        wide = self.units + UNITS
        description["network"]["hidden"] = [2 * wide, 2 * wide]
        self.metadata = self.metadata | {"gaitshift": json.dumps(description)}
        output = self.before["output.weight"]
        rows = torch.zeros(output.shape[0], 2 * wide)
        rows[:, : self.units], rows[:, wide : wide + self.units] = output.split(self.units, 1)
        self.file = self.before | {
            "layers.0.weight": torch.zeros(2 * wide, self.before["layers.0.weight"].shape[1]),
            "layers.0.bias": torch.zeros(2 * wide),
            "layers.1.weight": torch.zeros(2 * wide, 2 * wide),
            "layers.1.bias": torch.zeros(2 * wide),
            "output.weight": rows,
        }
        super().save(path, seed)


def facing(case: Case, starts: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The same states, before the step where the case has one."""
    starts = starts.copy()
    if case.step_up_m:
        starts[:, 0] = STEP_AT_M - rng.uniform(*AHEAD_M, len(starts))
    return starts


def share_of_falls(actor: Actor, starts: int, duration_s: float, seed: int, **conditions: dict[str, float]) -> float:
    """Of motions at 0 from random starts, under such conditions."""
    controller = as_controller(actor)
    motions = (controller.record(0.0, duration_s, seed=seed + start, **conditions) for start in range(starts))
    return float(np.mean([motion.summary()["fell"] for motion in motions]))


class Task:
    """What a candidate is judged by."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.controller, self.speed = arguments.controller, arguments.speed
        self.slower_than, self.faster_than = arguments.slower_than, arguments.faster_than
        self.cases = [(Case(0.0, forward_n), weight) for forward_n, weight in arguments.pushes]
        self.cases += [(Case(0.0, step_up_m=up_m), weight) for up_m, weight in arguments.steps]
        self.latency, self.raised = arguments.latency, arguments.raised
        # With `--hard`, of each case: states from which it fell at first, and others.
        self.found: list[tuple[np.ndarray, np.ndarray]] = []

    def shaped(self, values: np.ndarray) -> Shaped:
        return Shaped(self.controller, values, self.slower_than, self.faster_than)

    def walks(self, actor: Actor, seed: int, starts: int = STARTS) -> list[gaitshift.Recording]:
        """What it does from random starts when nothing disturbs it."""
        controller, commands = as_controller(actor), [0.0, 0.0, AFTER_A_RUN]
        return [controller.record(commands[start % 3], LONG_S, seed=seed + start) for start in range(starts)]

    def falls_late(self, actor: Actor, latency_s: float, seed: int) -> float:
        """Share of motions from random starts that fall when the actuators act late."""
        return share_of_falls(actor, LATE, LATE_S, seed, disturbance={"latency_s": latency_s})

    def falls_raised(self, actor: Actor, height_m: float, seed: int) -> float:
        """Share of motions from random starts that fall when the hip's mass is so far above its axis."""
        return share_of_falls(actor, RAISED, RAISED_S, seed, body={"hip_com_height_m": height_m})

    def starts(self, motions: list[gaitshift.Recording], rng: np.random.Generator, every: int = EVERY) -> np.ndarray:
        """States of the motions, positions and velocities side by side."""
        rows = [np.stack([motion[name] for name in STATE], 1)[-LAST:] for motion in motions]
        return np.concatenate([states[begin::every] for states, begin in zip(rows, rng.integers(every, size=len(rows)))])

    def find(self, case: Case, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """Of so many states of its walk those from which the controller falls now, or comes to a stand, and all others."""
        rng, actor, every = np.random.default_rng(seed), Actor(self.controller), 30
        starts = facing(case, self.starts(self.walks(actor, seed, count * every // LAST), rng, every), rng)
        fell = self.fell(actor, starts, case)
        return starts[fell], starts[~fell]

    def fell(self, actor: Actor, starts: np.ndarray, case: Case) -> np.ndarray:
        return falls(actor, starts, case, self.controller, OVER if case.step_up_m else UP)

    def share(self, actor: Actor, index: int, starts: np.ndarray, rng: np.random.Generator) -> float:
        """Share of the states from which it falls in a case."""
        case, _ = self.cases[index]
        if not self.found:
            return float(self.fell(actor, facing(case, starts, rng), case).mean())
        groups = self.found[index]
        drawn = [rows[rng.permutation(len(rows))[:most]] for rows, most in zip(groups, (HARD, OTHERS))]
        fell = self.fell(actor, np.concatenate(drawn), case)
        shares = [part.mean() if len(part) else 0.0 for part in np.split(fell, [len(drawn[0])])]
        return float(np.average(shares, weights=[len(rows) for rows in groups]))

    def cost(self, values: np.ndarray, seed: int) -> dict[str, float]:
        """The cost of a candidate, and what it is made of."""
        actor = self.shaped(values)
        motions = self.walks(actor, seed)
        summaries = [motion.summary(SETTLED_S) for motion in motions]
        no_walk = [summary["fell"] or summary["gait"] != "walking" for summary in summaries]
        if any(no_walk):
            return {"cost": NO_WALK + float(np.mean(no_walk))}
        mean = {name: float(np.mean([summary[name] for summary in summaries])) for name in MEASURED}
        rng = np.random.default_rng(seed)
        starts = self.starts(motions, rng)
        shares = {f"falls under {case}": self.share(actor, index, starts, rng) for index, (case, _) in enumerate(self.cases)}
        shares |= {f"falls {late_s:g} s late": self.falls_late(actor, late_s, seed) for late_s, _ in self.latency}
        shares |= {f"falls raised by {height_m:g} m": self.falls_raised(actor, height_m, seed) for height_m, _ in self.raised}
        cost = sum(weight * share for share, (_, weight) in zip(shares.values(), self.cases + self.latency + self.raised))
        too_fast = max(0.0, mean["speed_m_per_s"] - self.speed)
        lack = too_fast + max(0.0, LEAST_DOUBLE_SUPPORT - mean["double_support"]) + mean["flight"]
        return {"cost": cost + LACKING * lack + LARGE * float(np.square(values).sum())} | mean | shares


def with_weights(text: str) -> list[tuple[float, float]]:
    pairs = [[float(part) for part in pair.split(":")] for pair in text.split(",")]
    return [(size, weight) for size, weight in pairs]


def parsed(words: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--controller", type=Path, required=True, help="the controller whose walk is shaped")
    parser.add_argument("--out", type=Path, required=True, help="folder for the controllers and log.csv")
    parser.add_argument("--generations", type=int, default=40)
    parser.add_argument("--candidates", type=int, default=12, help="in each of them")
    parser.add_argument("--begin-with", type=Path, help="folder of a search for the same controller, to begin with its numbers")
    parser.add_argument("--deviation", type=float, default=0.06, help="of the numbers that are tried at first")
    parser.add_argument("--speed", type=float, default=0.7, help="greatest mean speed, in m/s")
    parser.add_argument(
        "--pushes", type=with_weights, metavar="N:WEIGHT,...", default="310:1,345:0.6,-320:0.8",
        help="forces for 0.1 s, forward if positive, and what a share of 1 that falls costs; write --pushes=-210:1 where the "
        "first is negative [default: %(default)s]",
    )
    parser.add_argument(
        "--steps", type=with_weights, metavar="M:WEIGHT,...", default=[], help="the same for steps up, of such heights"
    )
    parser.add_argument(
        "--latency", type=with_weights, metavar="S:WEIGHT,...", default=[], help="the same for motions whose actuators act late"
    )
    parser.add_argument(
        "--raised", type=with_weights, metavar="M:WEIGHT,...", default=[],
        help="the same for motions of a body whose hip has its mass so far above the axis",
    )
    parser.add_argument(
        "--slower-than", type=float, default=np.inf, help="what is added fades at speeds beyond, in m/s"
    )
    parser.add_argument("--faster-than", type=float, default=-np.inf, help="the same for speeds below")
    parser.add_argument(
        "--hard", type=int, default=0, metavar="STATES",
        help="estimate falls from states of the walk as it is, of which so many are tried first; needs such a limit",
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args(words)
    if arguments.hard and not np.isfinite([arguments.slower_than, arguments.faster_than]).any():
        parser.error("--hard: without --slower-than or --faster-than the walk itself changes, and its states with it")
    return arguments


def main() -> None:
    arguments = parsed()
    torch.set_num_threads(1)
    task = Task(arguments)
    task.shaped(np.zeros(NUMBERS))  # says here what is wrong with the controller, since a process of the pool would be lost
    arguments.out.mkdir(parents=True, exist_ok=True)
    state, log = arguments.out / "search.pickle", arguments.out / "log.csv"
    asked = {name: value for name, value in vars(arguments).items() if name not in ("out", "generations", "processes")}
    if state.exists():
        asked_before, search, task.found = pickle.loads(state.read_bytes())
        differences = ", ".join(f"--{name.replace('_', '-')}" for name in asked if asked[name] != asked_before[name])
        if differences:
            raise SystemExit(f"{arguments.out}: a search with another {differences}; go on with that, or give another --out")
    else:
        options = {"popsize": arguments.candidates, "seed": arguments.seed, "verbose": -9}
        begin = np.zeros(NUMBERS)
        if arguments.begin_with:
            begin = pickle.loads((arguments.begin_with / "search.pickle").read_bytes())[1].mean
        search = cma.CMAEvolutionStrategy(begin, arguments.deviation, options)
    columns = ["cost", *MEASURED, *(f"falls under {case}" for case, _ in task.cases)]
    columns += [f"falls {late_s:g} s late" for late_s, _ in task.latency]
    columns += [f"falls raised by {height_m:g} m" for height_m, _ in task.raised]
    with multiprocessing.Pool(arguments.processes) as pool:
        if arguments.hard and not task.found:
            looked_for = [(case, arguments.hard, arguments.seed) for case, _ in task.cases]
            task.found = pool.starmap(task.find, looked_for, chunksize=1)
            for (case, _), (fell, others) in zip(task.cases, task.found):
                print(f"falls at first, {case}: {len(fell)} of {len(fell) + len(others)}", flush=True)
        for generation in range(search.countiter + 1, arguments.generations + 1):
            began = time.monotonic()
            candidates, seed = search.ask(), 1_000_000 * arguments.seed + 1000 * generation
            measured = pool.starmap(task.cost, [(values, seed) for values in [*candidates, search.mean]], chunksize=1)
            search.tell(candidates, [each["cost"] for each in measured[:-1]])
            mean = {name: round(float(value), 4) for name, value in measured[-1].items()}
            begins = not log.exists()
            with log.open("a", newline="") as file:
                rows = csv.DictWriter(file, ["generation", "elapsed_s", "deviation", *columns])
                if begins:
                    rows.writeheader()
                elapsed_s, deviation = round(time.monotonic() - began), round(search.sigma, 4)
                rows.writerow({"generation": generation, "elapsed_s": elapsed_s, "deviation": deviation} | mean)
            told = ", ".join(f"{name} {value:g}" for name, value in mean.items())
            print(f"generation {generation} of {arguments.generations}: {told}", flush=True)
            if generation % 5 == 0 or generation == arguments.generations:
                task.shaped(search.mean).save(arguments.out / f"{generation}.safetensors", arguments.seed)
            state.write_bytes(pickle.dumps((asked, search, task.found)))  # last, so that what is not written yet is done again


if __name__ == "__main__":
    main()
