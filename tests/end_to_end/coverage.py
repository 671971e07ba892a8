"""estimate: how often its intervals of 95 % hold on made sounds, by scripts/bench_estimates."""
import json
import math
import os
import subprocess
import sys
import unittest

from program import CARILLON, CONFIGS, TIMEOUT_FACTOR, FolderTest

BENCH = CONFIGS.parent / "scripts" / "bench_estimates"


def fewest_by_chance(count, probability=0.95, chance=1e-3):
    """The most that may be asked for: of `count` intervals, fewer than so many hold with no more than the
    chance (binomial)."""
    below = 0.0
    for held in range(count + 1):
        below += math.comb(count, held) * probability ** held * (1 - probability) ** (count - held)
        if below > chance:
            return held
    return count


class Coverage(FolderTest):
    """Tiles and bowls of steel and glass, struck and heard at points that are drawn, in two of three cases
    in rooms, with noise."""

    def rows(self, *arguments):
        result = subprocess.run(
            [sys.executable, BENCH, "--coverage", "9", "--objects", "tile,bowl", "--materials",
             "steel,glass", "--jobs", "2", "--json", *arguments], capture_output=True, text=True,
            env={**os.environ, "CARILLON": CARILLON}, timeout=1200 * TIMEOUT_FACTOR)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def test_bound_is_that_of_the_binomial_distribution(self):
        # Of two coins neither shows heads once in four times; 0.95^3 is 0.857.
        self.assertEqual(fewest_by_chance(2, 0.5, 0.2), 0)
        self.assertEqual(fewest_by_chance(2, 0.5, 0.3), 1)
        self.assertEqual(fewest_by_chance(3, 0.95, 0.14), 2)
        self.assertEqual(fewest_by_chance(3, 0.95, 0.15), 3)
        # Intervals that hold in 65 % would pass once in seventeen times.
        self.assertEqual(fewest_by_chance(30), 24)

    def test_intervals_hold(self):
        rows = self.rows()
        self.assertEqual(len(rows), 36)
        stated = [row for row in rows if row["stated"]]
        self.assertGreaterEqual(len(stated), 24)
        for row in stated:
            self.assertLess(abs(row["off"]["E / density"]), 0.05, row)
        for quantity in ("E / density", "scale", "alpha1", "alpha2"):
            held = [row["holds"][quantity] for row in rows if quantity in row["holds"]]
            self.assertGreaterEqual(len(held), 15, quantity)
            self.assertGreaterEqual(sum(held), fewest_by_chance(len(held)), quantity)


if __name__ == "__main__":
    unittest.main()
