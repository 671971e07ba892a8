#!/usr/bin/env python3
"""Writes textures_spline_reference.inc: values and derivatives of a tensor-product cubic B-spline by
SciPy, for textures_sampling_test.cpp.

usage: textures_spline_reference.py > textures_spline_reference.inc
"""
import numpy as np
from scipy.interpolate import BSpline

WIDTH, HEIGHT, TEXEL = 7, 5, 0.25
texels = [[-((i * 5 + j * 3 + i * j * 2) % 11) / 8 for i in range(WIDTH)] for j in range(HEIGHT)]


def basis(place, count, repeats, derivative):
    """Weights of the texels at a place, in texels."""
    weights = np.zeros(count)
    spline = BSpline.basis_element(np.arange(-2.0, 3.0), extrapolate=False).derivative(derivative)
    for k in range(-3 * count, 4 * count):
        x = place - 0.5 - k
        if -2 < x < 2:
            weights[k % count if repeats else min(max(k, 0), count - 1)] += spline(x)
    return weights


print("// u, v, repeats, height, du, dv, duu, duv, dvv; by textures_spline_reference.py")
for repeats in (1, 0):
    for u, v in [(0.8, 0.6), (0.0, 0.0), (1.7, 1.2), (-0.3, 2.9), (0.9, 0.01), (5.03, -1.9)]:
        row = []
        for du, dv in [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]:
            a = basis(u / TEXEL, WIDTH, repeats, du) / TEXEL**du
            b = basis(v / TEXEL, HEIGHT, repeats, dv) / TEXEL**dv
            row.append(b @ np.array(texels) @ a)
        print(f"{{{u}, {v}, {repeats}, " + ", ".join(f"{x:.14g}" for x in row) + "},")
