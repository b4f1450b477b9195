"""How often a controller falls on bodies other than the one it was trained on.

Draws bodies whose parameters are each up to a share larger or smaller, lets the controller move each of them for 20 s at
every command, and prints the falls with Wilson's 95 % interval. Two sets of parameters:

- `all`: masses, inertias, springs, dampers, friction and the distances of the segments' centres of mass;
- `segments`: masses, inertias and distances alone, as one may read them differently from a paper.

A foot's centre of mass further out than the sole is put at the sole. The commands, after `maturin develop`:

    python experiments/bodies/bodies.py --controller shipped
    python experiments/bodies/bodies.py --controller robust
    python experiments/bodies/bodies.py --controller robust --vary segments --share 0.2 --hip-com-m -0.05 0.1
"""

from __future__ import annotations

import argparse
import math

import numpy as np

import gaitshift

SEGMENTS = (
    "hip_mass_kg",
    "thigh_mass_kg",
    "tibia_mass_kg",
    "foot_mass_kg",
    "hip_inertia_kg_m2",
    "thigh_inertia_kg_m2",
    "tibia_inertia_kg_m2",
    "foot_inertia_kg_m2",
    "thigh_distance_m",
    "tibia_distance_m",
    "foot_distance_m",
)
ALL = (
    *SEGMENTS,
    "hip_stiffness_nm_per_rad",
    "hip_damping_nms_per_rad",
    "k1_n_per_m",
    "k2_n_per_m",
    "k3_n_per_m",
    "c1_ns_per_m",
    "c2_ns_per_m",
    "friction",
)
COMMANDS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5)


def wilson(falls: int, motions: int) -> tuple[float, float]:
    """The 95 % interval of a share."""
    z, share = 1.96, falls / motions
    middle = share + z * z / (2 * motions)
    half = z * math.sqrt(share * (1 - share) / motions + z * z / (4 * motions * motions))
    return (middle - half) / (1 + z * z / motions), (middle + half) / (1 + z * z / motions)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--controller", default="shipped", help="file or name")
    parser.add_argument("--share", type=float, default=0.1, help="how far each parameter may be off")
    parser.add_argument("--vary", choices=("all", "segments"), default="all", help="what differs")
    parser.add_argument("--hip-com-m", type=float, nargs=2, metavar=("LOW", "HIGH"),
                        help="draw the height of the hip's centre of mass over the axis from this range, in m")
    parser.add_argument("--bodies", type=int, default=25, help="how many bodies are drawn")
    parser.add_argument("--seed", type=int, default=1, help="draws the bodies")
    arguments = parser.parse_args()
    controller = gaitshift.Controller.load(arguments.controller)
    rng = np.random.default_rng(arguments.seed)
    varied = ALL if arguments.vary == "all" else SEGMENTS
    factors = rng.uniform(1 - arguments.share, 1 + arguments.share, (arguments.bodies, len(varied)))
    heights = rng.uniform(*(arguments.hip_com_m or [controller.body["hip_com_height_m"]] * 2), arguments.bodies)
    all_falls = 0
    print("ω_v   falls  gaits of the others")
    for omega_v in COMMANDS:
        falls, gaits = 0, {}
        for row, height in zip(factors, heights, strict=True):
            body = {name: controller.body[name] * factor for name, factor in zip(varied, row, strict=True)}
            body["foot_distance_m"] = min(body["foot_distance_m"], controller.body["leg_length_m"])
            body["hip_com_height_m"] = height
            summary = controller.record(omega_v, 20.0, body=body).summary()
            if summary["fell"]:
                falls += 1
            else:
                gaits[summary["gait"]] = gaits.get(summary["gait"], 0) + 1
        all_falls += falls
        print(f"{omega_v:3.1f}   {falls:5d}  {', '.join(f'{count} {gait}' for gait, count in sorted(gaits.items()))}")
    motions = len(COMMANDS) * arguments.bodies
    low, high = wilson(all_falls, motions)
    print(f"{all_falls} falls in {motions} motions: {all_falls / motions:.3f} ({low:.3f} to {high:.3f})")


if __name__ == "__main__":
    main()
