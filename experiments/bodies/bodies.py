"""How often a controller falls on bodies other than the one it was trained on.

Draws bodies whose masses, inertias, springs, dampers and friction are each up to a share larger or smaller, lets the
controller move each of them for 20 s at every command, and prints the falls with Wilson's 95 % interval.

    python experiments/bodies/bodies.py [--controller FILE] [--share 0.1] [--bodies 25]
"""

from __future__ import annotations

import argparse
import math

import numpy as np

import gaitshift

VARIED = (
    "hip_mass_kg",
    "thigh_mass_kg",
    "tibia_mass_kg",
    "foot_mass_kg",
    "hip_inertia_kg_m2",
    "thigh_inertia_kg_m2",
    "tibia_inertia_kg_m2",
    "foot_inertia_kg_m2",
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
    parser.add_argument("--bodies", type=int, default=25, help="how many bodies are drawn")
    parser.add_argument("--seed", type=int, default=1, help="draws the bodies")
    arguments = parser.parse_args()
    controller = gaitshift.Controller.load(arguments.controller)
    rng = np.random.default_rng(arguments.seed)
    factors = rng.uniform(1 - arguments.share, 1 + arguments.share, (arguments.bodies, len(VARIED)))
    all_falls = 0
    print("ω_v   falls  gaits of the others")
    for omega_v in COMMANDS:
        falls, gaits = 0, {}
        for row in factors:
            body = {name: controller.body[name] * factor for name, factor in zip(VARIED, row, strict=True)}
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
