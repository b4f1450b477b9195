"""Ways to withstand pushes from where a controller falls, found by search, for `policy_gradient.py --ways`.

Of 800 states of its undisturbed motions at ω_v = 0, it finds those from which it falls under pushes of 30.5 and 29 N s
forward and 30 N s backward. For each, up to 40 a push, the cross-entropy method looks for offsets to the controller's
commands over 1.4 s, straight lines between knots 0.1 s apart, with which the body is up two seconds after the push began;
among these, for small ones. OUT is a NumPy file: `starts` (positions and velocities), `force_n`, `omega_v`, the `knots`,
and `observations` and `actions` of the control periods along each way. About 15 minutes of one core:

    python experiments/hardening/ways.py out/pg/40.safetensors out/ways.npz
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from hard_cases import Case, HardCases
from policy_gradient import Actor

import gaitshift

CASES = (Case(0.0, 305.0), Case(0.0, -300.0), Case(0.0, 290.0))
MOST = 40  # of a case
AT_ONCE = 8  # states that are searched side by side
KNOTS, KNOT = 15, 10  # knots of the offsets; control periods from one to the next
SAMPLES, ELITE, GENERATIONS = 96, 12, 25
DEVIATION, LEAST_DEVIATION, GREATEST_OFFSET = 0.35, 0.03, 1.5  # of the greatest force
UP = 200  # control periods that the body has to stay up
TIDY = 4  # generations after a way is found, in which it may become smaller
SIZE = 2.0  # cost of the mean square of the offsets, where a fall costs 1 to 2


def offsets_at(knots: np.ndarray, period: int) -> np.ndarray:
    """A row for each biped; 0 after the last knot."""
    place, share = divmod(period, KNOT)
    if place + 1 >= KNOTS:
        return np.zeros_like(knots[:, 0])
    share /= KNOT
    return (1 - share) * knots[:, place] + share * knots[:, place + 1]


class Search:
    """For ways under one case."""

    def __init__(self, cases: HardCases, case: Case, controller: Path) -> None:
        self.environment = cases.environment(case, AT_ONCE * SAMPLES)
        self.actor, self.case = Actor(controller), case

    def follow(self, starts: np.ndarray, knots: np.ndarray, periods: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For how many control periods each is up; observations and actions, [biped, control period, ...]."""
        count, room = len(starts), self.environment.num_envs
        starts, knots = (np.concatenate([rows, rows[:1].repeat(room - count, 0)]) for rows in (starts, knots))
        options = {"state": (starts[:, :11], starts[:, 11:]), "omega_v": np.full(room, self.case.omega_v)}
        observations, _ = self.environment.reset(seed=0, options=options)
        up, fallen = np.full(room, periods), np.zeros(room, bool)
        seen, done = np.zeros((periods, room, 14), np.float32), np.zeros((periods, room, 2), np.float32)
        for period in range(periods):
            seen[period] = observations
            done[period] = np.clip(self.actor.act(observations) + offsets_at(knots, period), -1, 1)
            observations, _, terminated, _, _ = self.environment.step(done[period])
            up[terminated & ~fallen] = period
            fallen |= terminated
            if fallen.all():
                break
            if terminated.any():
                self.environment.reset(options={**options, "reset_mask": terminated.copy()})
        return up[:count], seen[:, :count].swapaxes(0, 1), done[:, :count].swapaxes(0, 1)

    def ways(self, starts: np.ndarray, rng: np.random.Generator) -> list[np.ndarray | None]:
        """Knots for each of at most AT_ONCE starts; None where no way was found."""
        rows = starts[np.arange(AT_ONCE) % len(starts)].repeat(SAMPLES, 0)
        mean, deviation = np.zeros((AT_ONCE, KNOTS, 2)), np.full((AT_ONCE, KNOTS, 2), DEVIATION)
        best: list[np.ndarray | None] = [None] * AT_ONCE
        least = np.full(AT_ONCE, np.inf)
        since = np.zeros(AT_ONCE, int)
        for _ in range(GENERATIONS):
            knots = mean[:, None] + deviation[:, None] * rng.standard_normal((AT_ONCE, SAMPLES, KNOTS, 2))
            knots[:, 0] = mean
            knots = np.clip(knots, -GREATEST_OFFSET, GREATEST_OFFSET)
            up = self.follow(rows, knots.reshape(-1, KNOTS, 2), UP)[0].reshape(AT_ONCE, SAMPLES)
            cost = np.where(up < UP, 2 - up / UP, 0) + SIZE * (knots**2).mean((2, 3))
            for state in range(AT_ONCE):
                order = cost[state].argsort()
                if up[state, order[0]] >= UP and cost[state, order[0]] < least[state]:
                    best[state], least[state] = knots[state, order[0]].copy(), cost[state, order[0]]
                elite = knots[state, order[:ELITE]]
                mean[state], deviation[state] = elite.mean(0), np.maximum(elite.std(0), LEAST_DEVIATION)
                since[state] += best[state] is not None
            if (since[: len(starts)] > TIDY).all():
                break
        return best[: len(starts)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("controller", type=Path, help="whose falls are looked at; as for policy_gradient.py")
    parser.add_argument("out", type=Path, help="file for the ways")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    actor = Actor(arguments.controller)
    cases = HardCases(12, arguments.controller, rng, actor)
    motions = cases.motions(gaitshift.Controller.load(arguments.controller))
    found: dict[str, list[np.ndarray]] = {}
    for case in CASES:
        pool = motions[case.omega_v]
        starts = pool[rng.permutation(len(pool))]
        falls = starts[cases.falls(actor, starts, case)]
        print(f"{case}: falls from {len(falls)} of {len(starts)} states", flush=True)
        search = Search(cases, case, arguments.controller)
        for begin in range(0, min(len(falls), MOST), AT_ONCE):
            some = falls[begin : min(begin + AT_ONCE, MOST)]
            ways = search.ways(some, rng)
            chosen = [index for index, way in enumerate(ways) if way is not None]
            print(f"  ways from {len(chosen)} of {len(some)}", flush=True)
            if not chosen:
                continue
            knots = np.stack([way for way in ways if way is not None])
            _, seen, done = search.follow(some[chosen], knots, KNOTS * KNOT)
            columns = {"starts": some[chosen], "knots": knots, "observations": seen, "actions": done}
            columns |= {"force_n": np.full(len(chosen), case.forward_n), "omega_v": np.full(len(chosen), case.omega_v)}
            for name, rows in columns.items():
                found.setdefault(name, []).append(rows)
    if not found:
        raise SystemExit(f"{arguments.controller}: no way was found, or it falls nowhere; nothing is written")
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    np.savez(arguments.out, **{name: np.concatenate(rows) for name, rows in found.items()})  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
