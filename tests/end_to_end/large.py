"""A block and a bowl of a million unknowns: 20 modes under 20 GiB in an hour on two cores."""
import math
import resource
import time
import unittest

from program import FolderTest, run_json

UNKNOWNS = 1_000_000
SECONDS = 3600
BYTES = 20 << 30


class Large(FolderTest):
    def solve(self, shape, size, max_frequency):
        """Modes at a size that gives the unknowns, and what they took."""
        start = time.monotonic()
        result = run_json("--cache", "", "modes", shape, "--material", "steel", "--order", 3,
                          "--element-size", size, "--max-elements", 1000000, "--max-modes", 20,
                          "--max-frequency", max_frequency, ranks=2, timeout=SECONDS)
        print(f"{shape}: {result['certificate']} {result['timing']} "
              f"{time.monotonic() - start:.0f} s, largest process "
              f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 2**20:.1f} GiB")
        return result

    def check(self, shape, size, coarse, max_frequency, max_cents):
        large = self.solve(shape, size, max_frequency)
        small = run_json("--cache", "", "modes", shape, "--material", "steel", "--order", 3,
                         "--element-size", coarse, "--max-modes", 20,
                         "--max-frequency", max_frequency, timeout=SECONDS)
        certificate = large["certificate"]
        self.assertGreater(certificate["unknowns"], UNKNOWNS)
        self.assertEqual(certificate["modes_found"], 20)
        self.assertEqual(certificate["rigid_modes"], 6)
        self.assertLess(certificate["max_residual"], 1e-7)
        for fine, rough in zip(large["modes"], small["modes"]):
            cents = 1200 * math.log2(rough["frequency_hz"] / fine["frequency_hz"])
            self.assertLess(abs(cents), max_cents)
        # Both ranks together: the largest process is at most half.
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024
        self.assertLess(2 * peak, BYTES)

    def test_block(self):
        self.check("block:length=50mm,width=30mm,height=20mm", "2.35 mm", "8 mm", "400 kHz", 1)

    def test_bowl(self):
        self.check("bowl:radius=60mm,wall=3mm", "4.9 mm", "8 mm", "100 kHz", 3)


if __name__ == "__main__":
    unittest.main()
