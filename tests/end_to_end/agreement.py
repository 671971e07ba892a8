"""Both solvers on random bodies of revolution: they share the eigensolver alone, and give the same modes
within the sum of both error bars. CARILLON_BODIES says which bodies: 7-10, or 0-199 in the slow test."""
import math
import os
import random
import unittest

from program import LONG, FolderTest, run_json

TURNED = ("bell", "bowl", "cup", "cylinder", "disc", "plate", "ring", "tube", "vase")
MATERIALS = ("steel", "glass", "ceramic", "polycarbonate", "plastic", "iron")


def cents(a, b):
    return 1200 * math.log2(a / b)


def profile(random_number):
    """A closed outline as a user might measure it: radii [m] at heights, solid or with a wall."""
    heights = [0.02 * k for k in range(random_number.randint(2, 5))]
    radii = [random_number.uniform(0.012, 0.045) for _ in heights]
    outer = list(zip(radii, heights, strict=True))
    if random_number.random() < 0.5:
        return [(0, 0), *outer, (0, heights[-1])]
    wall = random_number.uniform(0.003, 0.008)
    return outer + [(radius - wall, height) for radius, height in reversed(outer)]


class Agreement(FolderTest):
    def body(self, number):
        """Its words on the command line."""
        random_number = random.Random(number)
        material = random_number.choice(MATERIALS)
        # One in four has an outline of its own.
        if random_number.random() < 0.25:
            rows = "".join(f"{radius:.6f},{height:.6f}\n" for radius, height in profile(random_number))
            return [self.write(f"profile-{number}.csv", "radius,height\n" + rows), "-m", material]
        shape = random_number.choice(TURNED)
        values = [f"{p['name']}={random_number.uniform(p['low_m'], p['high_m']):.5f}" for p in self.ranges[shape]]
        return [f"{shape}:" + ",".join(values), "-m", material]

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.ranges = {shape["name"]: shape["parameters"] for shape in run_json("list", "shapes")}

    def test_error_bars_hold_between_the_solvers(self):
        first, last = map(int, os.environ.get("CARILLON_BODIES", "0-199" if LONG else "7-10").split("-"))
        for number in range(first, last + 1):
            body = self.body(number)
            turned, solid = (run_json("modes", *body, "--max-modes", 16, "--solver", solver)
                             for solver in ("automatic", "tetrahedra"))
            self.assertEqual(turned["solver"]["name"], "axisymmetric", body)
            self.assertEqual(solid["solver"]["name"], "tetrahedra", body)
            # The mode at the band's top may be in one of the two alone.
            pairs = list(zip(turned["modes"], solid["modes"]))
            self.assertLessEqual(abs(len(turned["modes"]) - len(solid["modes"])), 2, body)
            worst = 0
            for k, (a, b) in enumerate(pairs):
                difference = abs(cents(a["frequency_hz"], b["frequency_hz"]))
                bar = a["pitch_error_cents"] + b["pitch_error_cents"]
                worst = max(worst, difference / bar)
                with self.subTest(body=" ".join(map(str, body)), number=number, mode=k + 1):
                    self.assertLessEqual(difference, bar)
            print(f"body {number}: {len(pairs)} modes, difference at most {worst:.2f} of both error bars,",
                  f"{solid['certificate']['unknowns']} unknowns, {' '.join(map(str, body))}", flush=True)


if __name__ == "__main__":
    unittest.main()
