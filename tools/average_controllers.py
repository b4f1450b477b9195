#!/usr/bin/env python3
"""Averages the weights of controllers of one run, all of the same shape.

    tools/average_controllers.py OUT.safetensors A.safetensors B.safetensors ...

The evaluations of a run swing; the mean of neighbouring controllers can be steadier than each of them.
Everything but the weights (task, body, provenance) is taken from the last file named, and the provenance says of how
many controllers it is the mean.
"""

import array
import json
import struct
import sys

KEY = "gaitshift"


def read(path):
    """Header and weights of a file."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack("<Q", data[:8])
    weights = array.array("f", data[8 + length :])
    if sys.byteorder == "big":
        weights.byteswap()
    return json.loads(data[8 : 8 + length]), weights


def write(path, header, weights):
    text = json.dumps(header, ensure_ascii=False, separators=(",", ":")).encode()
    # The format aligns what follows to eight bytes.
    text += b" " * (-len(text) % 8)
    if sys.byteorder == "big":
        weights.byteswap()
    with open(path, "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + weights.tobytes())


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    out, *paths = sys.argv[1:]
    sums, averaged, tensors = None, 0, None
    for path in paths:
        header, weights = read(path)
        metadata = header.pop("__metadata__")
        description = json.loads(metadata[KEY])
        averaged += description["provenance"].get("averaged_evaluations", 1)
        if tensors is not None and header != tensors:
            sys.exit(f"error: {path} has other tensors than {paths[0]}; name controllers of one run")
        tensors = header
        sums = list(weights) if sums is None else [a + b for a, b in zip(sums, weights)]
    description["provenance"]["averaged_evaluations"] = averaged
    metadata[KEY] = json.dumps(description, ensure_ascii=False, separators=(",", ":"))
    mean = array.array("f", (value / len(paths) for value in sums))
    write(out, {"__metadata__": metadata, **tensors}, mean)


if __name__ == "__main__":
    main()
