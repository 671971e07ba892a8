"""A scanned tube in elements too wide to follow its wall: straightened, pitches up to a
semitone sharp, and the estimates know. The volume is kept all the same."""
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
from program import FolderTest, run_json

BAND = ("--material", "steel", "--max-modes", "16", "--min-frequency", "0 Hz",
        "--max-frequency", "100 kHz")


def tube_off(radius, wall, length, around=192, along=24):
    """Triangles of a tube as an OFF file."""
    rings = [(radius, length * i / along) for i in range(along + 1)]
    rings += [(radius - wall, length * i / along) for i in range(along, -1, -1)]
    points = [(r * math.cos(2 * math.pi * k / around), r * math.sin(2 * math.pi * k / around), z)
              for r, z in rings for k in range(around)]
    faces = []
    for i in range(len(rings)):
        for k in range(around):
            here, above = i * around, (i + 1) % len(rings) * around
            next_one = (k + 1) % around
            faces.append((here + k, here + next_one, above + next_one))
            faces.append((here + k, above + next_one, above + k))
    lines = [f"OFF\n{len(points)} {len(faces)} 0"]
    lines += ["%.9g %.9g %.9g" % point for point in points]
    lines += ["3 %d %d %d" % face for face in faces]
    return "\n".join(lines) + "\n"


class CoarseScan(FolderTest):
    def test_estimates_know_straightened_elements(self):
        scan = self.write("tube.off", tube_off(0.03, 0.003, 0.08))
        truth = run_json("modes", "tube:radius=30mm,wall=3mm,length=80mm", "--solver", "axisymmetric",
                         *BAND)["modes"]
        # Straight facets of a hollow meet in inward edges that layers would go to.
        coarse = run_json("modes", scan, "--element-size", "28 mm", "--edge-layers", 0, *BAND)
        self.assertGreater(coarse["mesh"]["straightened"], 50)
        area_of_polygon = 192 / 2 * math.sin(2 * math.pi / 192)
        given = area_of_polygon * (0.03**2 - 0.027**2) * 0.08
        self.assertAlmostEqual(coarse["mesh"]["volume"] / given, 1, delta=1e-6)
        worst = 0
        for found, true in zip(coarse["modes"], truth, strict=True):
            error = abs(1200 * math.log2(found["frequency_hz"] / true["frequency_hz"]))
            worst = max(worst, error)
            self.assertGreater(found["pitch_error_cents"], 0.4 * error)
            self.assertLess(found["pitch_error_cents"], 3 * error + 10)
        self.assertGreater(worst, 60)

    def test_automatic_elements_follow_the_wall(self):
        scan = self.write("tube.off", tube_off(0.03, 0.003, 0.08))
        fine = run_json("modes", scan, *BAND)
        self.assertLessEqual(fine["mesh"]["straightened"], 2)
        self.assertLess(max(mode["pitch_error_cents"] for mode in fine["modes"]), 20)


if __name__ == "__main__":
    unittest.main()
