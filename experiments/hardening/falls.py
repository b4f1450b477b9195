"""Of 144 motions at each of ω_v = 0, 1, 2 and 3, how many fall within 8 s of a push.

Twelve random starts, each pushed for 0.1 s at twelve times 0.1 s apart, more than a stride together. A line a push: its impulse
forward and up in N s, and the falls at each command. About two minutes of one core a controller:

    python experiments/hardening/falls.py robust controllers/robust/before-hardening.safetensors
    python experiments/hardening/falls.py robust --omega-v 0.5 1.5 2.5 3.5
"""

from __future__ import annotations

import argparse

import gaitshift

IMPULSES_N_S = ((25, 0), (30, 0), (35, 0), (-10, 0), (-20, 0), (-30, 0), (0, -10), (0, -20), (0, -30), (0, 40))
DURATION_S = 0.1
STARTS = range(1001, 1013)
TIMES_S = [6 + 0.1 * k for k in range(12)]
UP_S = 8.0


def fell(controller: gaitshift.Controller, omega_v: float, seed: int, impulse_n_s: tuple[float, float], time_s: float) -> bool:
    forward_n, up_n = (impulse / DURATION_S for impulse in impulse_n_s)
    push = {"forward_n": forward_n, "up_n": up_n, "start_s": time_s, "duration_s": DURATION_S}
    recording = controller.record(omega_v, time_s + UP_S, seed=seed, disturbance={"pushes": [push]})
    return recording.summary()["fell"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("controllers", nargs="+", help="shipped, robust, files or folders of runs")
    parser.add_argument("--omega-v", type=float, nargs="+", default=(0.0, 1.0, 2.0, 3.0), help="commands [default: 0 1 2 3]")
    arguments = parser.parse_args()
    for name in arguments.controllers:
        controller = gaitshift.Controller.load(name)
        print(name)
        for impulse in IMPULSES_N_S:
            falls = [sum(fell(controller, w, seed, impulse, t) for seed in STARTS for t in TIMES_S) for w in arguments.omega_v]
            print(f"{impulse[0]:4d} {impulse[1]:4d}   {' '.join(f'{n:4d}' for n in falls)}", flush=True)


if __name__ == "__main__":
    main()
