"""How loud the samples of each material of a dataset are.

    python3 dataset.py carillon-demo/smoke
"""
import sys

import carillon as ca
import numpy

if len(sys.argv) != 2:
    sys.exit("usage: dataset.py FOLDER")
dataset = ca.open(sys.argv[1])
materials = dataset["material"][:]

for material in sorted(set(materials)):
    rows = numpy.flatnonzero(materials == material)
    loudest = max(float(numpy.abs(dataset["audio"][row]).max()) for row in rows)
    print(f"{material:<24} {len(rows):4d} samples, loudest {loudest:.3g}")
