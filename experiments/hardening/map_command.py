"""Gives a controller's commands another meaning: what it hears is a piecewise linear function of ω_v.

A layer before its network does so, which passes on all other observations as they are; a mean of a network and its mirror image
remains one. So the controller can leave out commands
at which it withstands less, and go from one gait to the other at a command of its own. At commands beyond the first and last
point the function is constant. Needs PyTorch and safetensors beside the package, and takes a second:

    pip install torch safetensors
    python experiments/hardening/map_command.py --controller out/slow/25.safetensors --out out/mapped.safetensors \\
        --points 0.3:0,0.31:0.9,3.5:1.3
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import torch
from policy_gradient import OBSERVATION_MIRROR, OMEGA_V, command_line, read
from safetensors.torch import save_file


def mapped(file: dict[str, torch.Tensor], points: np.ndarray) -> dict[str, torch.Tensor]:
    """The network with the layer before it; a row of the points is a scaled command and what becomes of it."""
    command, heard = points.T
    bends = torch.tensor(np.diff(np.diff(heard) / np.diff(command), prepend=0.0, append=0.0))
    others = [place for place in range(14) if place != OMEGA_V]
    passed = 2 * len(others)  # each observation as two units, since a unit is never negative
    before, bias = torch.zeros(passed + len(bends), 14), torch.zeros(passed + len(bends))
    before[range(0, passed, 2), others] = 1.0
    before[range(1, passed, 2), others] = -1.0
    before[passed:, OMEGA_V] = 1.0
    bias[passed:] = torch.tensor(-command)
    first = file["layers.0.weight"]
    after = torch.zeros(first.shape[0], passed + len(bends))
    after[:, :passed:2] = first[:, others]
    after[:, 1:passed:2] = -first[:, others]
    after[:, passed:] = torch.outer(first[:, OMEGA_V].double(), bends)
    layers = {"layers.0.weight": before, "layers.0.bias": bias, "layers.1.weight": after}
    half = first.shape[0] // 2
    if torch.equal(first[half:], first[:half, OBSERVATION_MIRROR]):  # a mean of a network and its mirror image, as it remains
        layers["layers.0.weight"] = torch.cat([before, before[:, OBSERVATION_MIRROR]])
        layers["layers.0.bias"] = bias.repeat(2)
        layers["layers.1.weight"] = torch.block_diag(after[:half], after[:half])
    layers["layers.1.bias"] = file["layers.0.bias"] + first[:, OMEGA_V] * float(heard[0])
    for name, tensor in file.items():
        layer, _, kind = name.partition(".")[2].partition(".")
        if name.startswith("output."):
            layers[name] = tensor
        elif int(layer) > 0:
            layers[f"layers.{int(layer) + 1}.{kind}"] = tensor
    return layers


def commands(text: str) -> np.ndarray:
    points = np.array([[float(part) for part in pair.split(":")] for pair in text.split(",")])
    if points.shape[1:] != (2,) or len(points) < 2 or (np.diff(points[:, 0]) <= 0).any():
        raise argparse.ArgumentTypeError("give two or more, with rising ω_v")
    return points


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--controller", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True, help="the file to be written")
    parser.add_argument(
        "--points", type=commands, required=True, metavar="OMEGA_V:HEARD,...",
        help="in s/m, two or more, with rising ω_v; write --points=-0.2:0 where the first is negative",
    )
    arguments = parser.parse_args()
    metadata, file = read(arguments.controller)
    description = json.loads(metadata["gaitshift"])
    if description["network"]["layer_norm"]:
        raise SystemExit(f"{arguments.controller}: its first layer is normalised, so nothing can be put before it")
    layers = mapped(file, arguments.points * description["observation_scale"][OMEGA_V])
    description["network"]["hidden"].insert(0, len(layers["layers.0.bias"]))
    description["provenance"] |= {"command": command_line()}
    metadata |= {"gaitshift": json.dumps(description)}
    save_file({name: tensor.contiguous() for name, tensor in layers.items()}, arguments.out, metadata)


if __name__ == "__main__":
    main()
