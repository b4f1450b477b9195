"""What every contestant of benchmarks/compare.py speaks, for the ones in Python.

A contestant starts, warms up and prints `ready`. For every line on its standard input, a number of seconds, it works
for about that long and prints one line {"count": N, "seconds": S}. At the end of its input it ends.
"""

import json
import os
import sys
import time


def limit_threads(threads):
    """Has the numerical libraries use so many threads. To be called before they are imported: they read it then."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = str(threads)
    # XLA takes the size of its pool of threads from NPROC. `intra_op_parallelism_threads=1`, often seen beside the flag
    # below, is no flag of XLA: without leading dashes it is passed over.
    os.environ["NPROC"] = str(threads)
    if threads == 1:
        os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} --xla_cpu_multi_thread_eigen=false".strip()


def serve(work):
    """Answers until the input ends. `work` takes some milliseconds and returns how much it did."""
    # Compiles, fills caches, and lets the processor reach the clock it keeps under load.
    start = time.perf_counter()
    while time.perf_counter() - start < 0.5:
        work()
    print("ready", flush=True)
    for line in sys.stdin:
        seconds, count, elapsed, start = float(line), 0, 0.0, time.perf_counter()
        while elapsed < seconds:
            count += work()
            elapsed = time.perf_counter() - start
        print(json.dumps({"count": count, "seconds": elapsed}), flush=True)
