"""Frequencies against references computed in another way, within 5 cents.

The block, the plate and the bar: Rayleigh-Ritz with polynomials, below. The sphere: Lamb's
characteristic equation, below. Tables of $CARILLON_TEST_DATA, where they are, on top.
"""
import csv
import itertools
import math
import os
import pathlib
import unittest

import numpy
from program import FolderTest, run_json

DATA = os.environ.get("CARILLON_TEST_DATA")


def ritz_box(sides, young, poisson, density, degrees):
    """Flexible frequencies [Hz] of a free box by Ritz with products of Legendre polynomials.

    Visscher et al. 1991, J. Acoust. Soc. Am. 90, 2154. Legendre polynomials are orthogonal, so the
    mass matrix is diagonal; derivatives and their products are integrated by Gauss' rule. A
    polynomial of degrees (i, j, k) is in the basis when i / I + j / J + k / K <= 1.
    """
    half = numpy.array(sides) / 2
    top = max(degrees)
    nodes, weights = numpy.polynomial.legendre.leggauss(top + 2)
    eye = numpy.eye(top + 1)
    value = numpy.array([numpy.polynomial.legendre.legval(nodes, e) for e in eye])
    slope = numpy.array([numpy.polynomial.legendre.legval(
        nodes, numpy.polynomial.legendre.legder(e)) if i else 0 * nodes
        for i, e in enumerate(eye)])
    norm = numpy.sqrt((value**2 * weights).sum(axis=1))
    value, slope = value / norm[:, None], slope / norm[:, None]
    mass_1d = value * weights @ value.T
    dd, d0 = slope * weights @ slope.T, slope * weights @ value.T
    basis = numpy.array([powers for powers in itertools.product(*(range(d + 1) for d in degrees))
                         if sum(p / d for p, d in zip(powers, degrees)) <= 1 + 1e-12])

    def integral(a, b):
        """Integral of d_a u d_b v over the box, scaled to unit mass."""
        out = 1.0
        for axis in range(3):
            table = {(True, True): dd, (True, False): d0, (False, True): d0.T,
                     (False, False): mass_1d}[(a == axis, b == axis)]
            out = out * table[numpy.ix_(basis[:, axis], basis[:, axis])]
        return out / (half[a] * half[b])

    mu = young / (2 * (1 + poisson))
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    first = {(a, b): integral(a, b) for a in range(3) for b in range(3)}
    n = len(basis)
    stiffness = numpy.zeros((3 * n, 3 * n))
    for p in range(3):
        for q in range(3):
            block = lame * first[p, q] + mu * first[q, p]
            if p == q:
                block = block + mu * sum(first[a, a] for a in range(3))
            stiffness[p * n:(p + 1) * n, q * n:(q + 1) * n] = block
    values = numpy.linalg.eigvalsh((stiffness + stiffness.T) / 2) / density
    return numpy.sqrt(values[6:]) / (2 * math.pi)


def sphere_modes(radius, young, poisson, density, highest):
    """Flexible frequencies [Hz] of a free sphere with their multiplicities, by Lamb's equations."""
    shear = math.sqrt(young / (2 * (1 + poisson)) / density)
    ratio = math.sqrt((1 - 2 * poisson) / (2 * (1 - poisson)))  # shear speed / pressure speed

    def bessel(l, x):
        """Spherical Bessel functions j_l and j_{l+1} by the power series."""
        def series(order):
            term = x**order / math.prod(range(1, 2 * order + 2, 2))
            total, k = 0.0, 0
            while abs(term) > 1e-18 * abs(total) or k < 3:
                total += term
                k += 1
                term *= -x * x / (2 * k * (2 * order + 2 * k + 1))
            return total
        return series(l), series(l + 1)

    def torsional(l, eta):
        j, after = bessel(l, eta)
        return (l - 1) * j - eta * after

    def spheroidal(l, eta):
        xi = ratio * eta
        jx, jx1 = bessel(l, xi)
        je, je1 = bessel(l, eta)
        # Traction of the pressure and of the shear potential at the surface (Eringen & Suhubi
        # 1975, section 8.14).
        a = (l * l - l - eta**2 / 2) * jx + 2 * xi * jx1
        b = l * (l + 1) * ((l - 1) * je - eta * je1)
        c = (l - 1) * jx - xi * jx1
        d = (l * l - 1 - eta**2 / 2) * je + eta * je1
        return a * d - b * c if l else a

    found = []
    top = 2 * math.pi * highest * radius / shear
    grid = numpy.linspace(0.3, top, 4000)
    for l in range(12):
        for kind, function in (("T", torsional), ("S", spheroidal)):
            if kind == "T" and l == 0:
                continue
            values = [function(l, eta) for eta in grid]
            for low, high, f_low, f_high in zip(grid, grid[1:], values, values[1:]):
                if f_low * f_high >= 0:
                    continue
                for _ in range(80):
                    middle = (low + high) / 2
                    f_middle = function(l, middle)
                    low, high = (middle, high) if f_middle * f_low > 0 else (low, middle)
                found += [low * shear / radius / (2 * math.pi)] * (2 * l + 1)
    return sorted(found)


class References(FolderTest):
    def compare(self, modes, reference, count, bound):
        self.assertGreaterEqual(len(modes), count)
        worst = max(abs(1200 * math.log2(m["frequency_hz"] / f))
                    for m, f in zip(modes[:count], reference[:count]))
        print(f"{count} modes, worst {worst:.3f} cents")
        self.assertLess(worst, bound)

    def box(self, shape, sides, material, count, degrees, highest):
        young, poisson, density = material
        text = f"youngs_modulus={young},poisson_ratio={poisson},density={density}"
        result = run_json("modes", shape, "-m", text, "--max-frequency", highest)
        self.assertTrue(result["certificate"]["complete"])
        reference = ritz_box(sides, young, poisson, density, degrees)
        self.compare(result["modes"], reference, count, 5)
        return result

    def test_steel_block(self):
        self.box("block:length=50mm,width=30mm,height=20mm", (0.05, 0.03, 0.02),
                 (2.0e11, 0.29, 7850), 20, (14, 14, 14), "150 kHz")

    def test_audible_bar(self):
        # Twelve modes lie below 20 kHz.
        self.box("bar:length=200mm,width=15mm,height=10mm", (0.2, 0.015, 0.01), (7.0e10, 0.33, 2700),
                 12, (32, 12, 12), "20 kHz")

    def test_audible_plate(self):
        self.box("tile:length=100mm,width=100mm,thickness=5mm", (0.1, 0.1, 0.005),
                 (6.2e10, 0.20, 2600), 20, (20, 20, 6), "20 kHz")

    def test_steel_sphere(self):
        result = run_json("modes", "sphere:radius=50mm", "-m",
                          "youngs_modulus=2e11,poisson_ratio=0.29,density=7850",
                          "--max-frequency", "150 kHz", "--max-modes", "40")
        self.compare(result["modes"], sphere_modes(0.05, 2e11, 0.29, 7850, 60000), 20, 5)

    @unittest.skipUnless(DATA, "CARILLON_TEST_DATA is not set")
    def test_tables_made_by_others(self):
        cases = {
            "rpr_block_steel_20x30x50mm.csv": ("block:length=50mm,width=30mm,height=20mm",
                                               (2e11, 0.29, 7850), "150 kHz"),
            "rpr_bar_alu_10x15x200mm.csv": ("bar:length=200mm,width=15mm,height=10mm",
                                            (7e10, 0.33, 2700), "20 kHz"),
            "rpr_plate_glass_100x100x5mm.csv": ("tile:length=100mm,width=100mm,thickness=5mm",
                                                (6.2e10, 0.20, 2600), "20 kHz"),
        }
        for name, (shape, material, highest) in cases.items():
            with self.subTest(name):
                lines = (pathlib.Path(DATA) / "reference_modes" / name).read_text().splitlines()
                reference = [float(row["f_hz"]) for row in csv.DictReader(lines[1:])]
                text = "youngs_modulus={},poisson_ratio={},density={}".format(*material)
                modes = run_json("modes", shape, "-m", text, "--max-frequency",
                                 highest)["modes"]
                self.compare(modes, reference, min(20, len(modes)), 5)


if __name__ == "__main__":
    unittest.main()
