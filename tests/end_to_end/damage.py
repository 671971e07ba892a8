"""Clean meshes that were damaged come back: within 1 % of volume and 20 cents of pitch."""
import math
import unittest

import numpy
from program import FolderTest, run_json


def torus(n=48, m=24, radius=0.05, tube=0.02):
    points = [((radius + tube * math.cos(v)) * math.cos(u),
               (radius + tube * math.cos(v)) * math.sin(u), tube * math.sin(v))
              for u in numpy.arange(n) * 2 * math.pi / n
              for v in numpy.arange(m) * 2 * math.pi / m]
    faces = []
    for i in range(n):
        for j in range(m):
            a, b = i * m + j, (i + 1) % n * m + j
            c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
            faces += [(a, b, c), (a, c, d)]
    return numpy.array(points), numpy.array(faces)


def revolved(profile, n=40):
    """A closed profile (r, z) that touches the axis at its ends, turned about z."""
    points, rings = [], []
    for r, z in profile:
        if r == 0:
            rings.append([len(points)] * n)
            points.append((0, 0, z))
        else:
            rings.append([len(points) + k for k in range(n)])
            points += [(r * math.cos(2 * math.pi * k / n), r * math.sin(2 * math.pi * k / n), z)
                       for k in range(n)]
    faces = []
    for low, high in zip(rings, rings[1:]):
        for k in range(n):
            a, b, c, d = low[k], low[(k + 1) % n], high[(k + 1) % n], high[k]
            faces += [f for f in ((a, b, c), (a, c, d)) if len(set(f)) == 3]
    return numpy.array(points), numpy.array(faces)


def bowl(outer=0.06, wall=0.006, steps=14):
    """A hemispherical bowl with a true wall, opening upwards."""
    angles = numpy.linspace(0, math.pi / 2, steps + 1)
    down = [(outer * math.sin(a), -outer * math.cos(a)) for a in angles]
    inner = outer - wall
    up = [(inner * math.sin(a), -inner * math.cos(a)) for a in angles[::-1]]
    profile = down + up
    profile[0], profile[-1] = (0, -outer), (0, -inner)
    return revolved(profile)


def pawn():
    """A solid turned object."""
    z = numpy.linspace(0, 0.1, 25)
    r = 0.02 + 0.008 * numpy.cos(z / 0.1 * 2 * math.pi)
    return revolved([(0, 0)] + list(zip(r, z)) + [(0, 0.1)])


def dropped(points, faces, random):
    keep = random.permutation(len(faces))[len(faces) // 100 + 1:]
    return points, faces[numpy.sort(keep)]


def flipped(points, faces, random):
    out = faces.copy()
    some = random.permutation(len(faces))[:len(faces) // 100 + 1]
    out[some] = out[some][:, ::-1]
    return points, out


def doubled(points, faces, random):
    some = random.permutation(len(faces))[:len(faces) // 100 + 1]
    return points, numpy.vstack([faces, faces[some]])


def seams_opened(points, faces, random):
    """Triangles on one side of a plane get vertices of their own, a hair away."""
    centre = points[faces].mean(axis=1)
    side = centre @ random.normal(size=3) > 0
    shifted = points + 1e-8 * random.normal(size=points.shape)
    out = faces.copy()
    out[side] += len(points)
    return numpy.vstack([points, shifted]), out


def write_off(path, points, faces):
    with open(path, "w") as file:
        file.write(f"OFF\n{len(points)} {len(faces)} 0\n")
        file.writelines("%.12g %.12g %.12g\n" % tuple(p) for p in points)
        file.writelines("3 %d %d %d\n" % tuple(f) for f in faces)
    return path


class Damage(FolderTest):
    def solve(self, name, points, faces, options):
        mesh = write_off(self.folder / f"{name}.off", points, faces)
        return run_json("modes", mesh, "-m", "steel", "--max-frequency", "60 kHz", "--max-modes", 12,
                        *options)

    def check(self, name, points, faces, *options):
        whole = self.solve(name, points, faces, options)
        self.assertEqual(whole["repair"]["actions"], [])
        for seed, damage in enumerate((dropped, flipped, doubled, seams_opened)):
            with self.subTest(shape=name, damage=damage.__name__):
                random = numpy.random.default_rng(seed)
                mended = self.solve(f"{name}-{damage.__name__}", *damage(points, faces, random),
                                    options)
                self.assertNotEqual(mended["repair"]["actions"], [])
                self.assertLess(abs(mended["mesh"]["volume"] / whole["mesh"]["volume"] - 1), 0.01)
                # A pair at the end is taken whole or left out, as exactly as the mesh has it.
                self.assertGreaterEqual(min(len(mended["modes"]), len(whole["modes"])), 8)
                for a, b in zip(mended["modes"], whole["modes"]):
                    cents = 1200 * math.log2(a["frequency_hz"] / b["frequency_hz"])
                    self.assertLess(abs(cents), 20)

    def test_torus(self):
        self.check("torus", *torus(), "--order", 2)

    def test_bowl(self):
        self.check("bowl", *bowl(), "--order", 2)

    def test_pawn(self):
        self.check("pawn", *pawn(), "--order", 2)


if __name__ == "__main__":
    unittest.main()
