#!/usr/bin/env python3
"""Averages the weights of controllers of one run, all of the same shape.

    tools/average_controllers.py OUT.safetensors A.safetensors B.safetensors ...

The evaluations of a run swing; the mean of neighbouring controllers can be steadier than each of them.
Everything but the weights (task, body, provenance) is taken from the last file named.
"""

import array
import struct
import sys


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack("<Q", data[:8])
    weights = array.array("f", data[8 + length :])
    if sys.byteorder == "big":
        weights.byteswap()
    return data[: 8 + length], weights


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    out, *paths = sys.argv[1:]
    header, sums = None, None
    for path in paths:
        header, weights = read(path)
        if sums is not None and len(weights) != len(sums):
            sys.exit(f"error: {path} has {len(weights)} weights, {paths[0]} has {len(sums)}; name controllers of one run")
        sums = list(weights) if sums is None else [a + b for a, b in zip(sums, weights)]
    mean = array.array("f", (value / len(paths) for value in sums))
    if sys.byteorder == "big":
        mean.byteswap()
    with open(out, "wb") as file:
        file.write(header + mean.tobytes())


if __name__ == "__main__":
    main()
