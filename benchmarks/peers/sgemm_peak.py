"""GFLOP of single-precision matrix products with NumPy's OpenBLAS, the machine's measured peak. Protocol: protocol.py.

    python benchmarks/peers/sgemm_peak.py --threads 1

Square matrices, of the size among SIZES that goes fastest here; a multiplication with its addition counts as 2 FLOP.
"""

import argparse
import time

from protocol import limit_threads, serve

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--threads", type=int, default=1)
arguments = parser.parse_args()
limit_threads(arguments.threads)

import numpy as np  # noqa: E402

SIZES = (512, 1024, 2048)


def product(size):
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, size, size), np.float32)
    out = np.empty_like(a)

    def work():
        np.matmul(a, b, out=out)
        return 2e-9 * size**3

    return work


def best_rate(work):
    """The greatest of several: what disturbs makes a product slower, never faster."""
    rates = []
    for _ in range(5):
        start = time.perf_counter()
        rates.append(work() / (time.perf_counter() - start))
    return max(rates)


serve(max(map(product, SIZES), key=best_rate))
