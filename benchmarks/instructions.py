"""Instructions of one update by what they are for, counted by callgrind: the same on every run, whatever the machine does.

    python benchmarks/instructions.py [--hidden 128]

Needs valgrind. Counts two runs, of 20 and of 40 updates, and takes the difference, so that what happens before and
after the updates drops out. Valgrind has AVX2 and FMA, so the same code is counted that runs. Instructions are not time: a
multiplication of eight numbers is one as a jump is.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from compare import ACTIONS, BATCH, Failure, build, flop_per_update, table

UPDATES = 20
# What a function is for, by the first pattern found in its name.
PARTS = [
    ("products of matrices", r"product::|sparse::|dense::"),
    ("marking zeros", r"pattern::"),
    ("Adam, targets, sums of gradients", r"adam::|optimiser::|add_up"),
    ("output layers and biases", r"output_layer::|sums::|tail_gradient|seed_sel|mask_sel"),
    ("copies of weights for the backward pass", r"refresh|transpose"),
    ("squashed Gaussian", r"gaussian::|run_loop"),
    ("drawing batches and noise", r"replay::|fill_normal|random::|Agent::update|mem(cpy|move)|xoshiro|ziggurat"),
]


def count(program, hidden, updates, folder):
    """Instructions by function."""
    out = Path(folder) / f"callgrind.{updates}"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", program, "--hidden", str(hidden),
               "--transitions", "20000", "--updates", str(updates)]
    try:
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise Failure(f"`{' '.join(command)}` failed:\n{done.stderr}")
        listing = subprocess.run(["callgrind_annotate", "--threshold=100", "--show-percs=no", str(out)],
                                 capture_output=True, text=True, check=True).stdout
    except FileNotFoundError as error:
        raise Failure(f"{error.filename} is not installed; it comes with valgrind (apt install valgrind)") from error
    found = Counter()
    for line in listing.splitlines():
        if match := re.match(r"\s*([\d,]+)\s+\S*?:(.*)", line):
            found[match[2]] += int(match[1].replace(",", ""))
    if not found:
        raise Failure("callgrind_annotate listed no functions")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hidden", type=int, default=128, help="units of each of the two hidden layers [default: 128]")
    parser.add_argument("--update-rate", metavar="PROGRAM", help="instead of building the example update_rate")
    arguments = parser.parse_args()
    program = arguments.update_rate or build("gaitshift-sac", "--example", "update_rate")
    with tempfile.TemporaryDirectory() as folder:
        few, many = (count(program, arguments.hidden, times * UPDATES, folder) for times in (1, 2))
    parts = Counter()
    for name in many:
        part = next((part for part, pattern in PARTS if re.search(pattern, name)), "the rest")
        parts[part] += (many[name] - few[name]) / UPDATES
    total, flop = sum(parts.values()), flop_per_update(arguments.hidden)
    print(f"One update, {arguments.hidden} units, batch {BATCH}, {ACTIONS} actions: {total / 1e6:.2f} million instructions, "
          f"{flop / 1e6:.1f} MFLOP, hence {flop / total:.2f} FLOP an instruction.\n")
    print(table(["part", "instructions", "share"], [
        [part, f"{amount:,.0f}", f"{100 * amount / total:.1f} %"] for part, amount in parts.most_common()
    ]))


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        sys.exit(f"error: {failure}")
