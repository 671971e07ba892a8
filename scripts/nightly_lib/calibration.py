"""A load that never changes: its processor time says how fast this run's processors are.

usage: calibration.py    prints its seconds
Half of it multiplies matrices that fit the cache, half gathers numbers from all over 32 MiB, as
factors and sparse products do. A change of it is a change of every time: raise LOAD then.
"""
import os
import pathlib
import statistics
import subprocess
import sys
import time

LOAD = 1  # version of the load; nightly runs with another are not compared
SLICES = 5
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


def processor_seconds():
    """Of the median slice."""
    import numpy

    numbers = numpy.random.default_rng(1)
    matrix = numbers.standard_normal((400, 400))
    field = numbers.standard_normal(1 << 22)
    places = numbers.integers(0, 1 << 22, 1 << 20)
    times = []
    for _ in range(SLICES):
        start = time.process_time()
        product = matrix
        for _ in range(15):
            product = matrix @ product
            product /= abs(product[0, 0]) + 1.0
        for _ in range(2):
            field[places].sum()
        times.append(time.process_time() - start)
    return statistics.median(times)


def measure(processors):
    """Mean seconds of the load with one copy of it on each of so many processors at once."""
    copies = [subprocess.Popen([sys.executable, str(pathlib.Path(__file__).resolve())],
                               stdout=subprocess.PIPE, text=True, env={**os.environ, **ENVIRONMENT})
              for _ in range(processors)]
    seconds = []
    for copy in copies:
        text, _ = copy.communicate(timeout=600)
        if copy.returncode != 0:
            raise RuntimeError("the calibration load failed; does this Python have numpy?")
        seconds.append(float(text))
    return statistics.mean(seconds)


if __name__ == "__main__":
    print(processor_seconds())
