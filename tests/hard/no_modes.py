"""A body without a mode in the band: a legal result that says why it is empty."""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
import h5py
from program import FolderTest, run, run_json

BLOCK = "block:length=5mm,width=3mm,height=2mm"


class NoMode(FolderTest):
    def test_table_explains_itself(self):
        result = run("modes", BLOCK, "--material", "steel")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("no mode lies between 20 and 20000 Hz", result.stdout)
        self.assertIn("raise --max-frequency", result.stdout)
        self.assertIn("0 of the 0 modes in the band; complete to 20000.0 Hz", result.stdout)

    def test_json_is_empty_complete_and_explained(self):
        found = run_json("modes", BLOCK, "--material", "steel")
        self.assertEqual(found["modes"], [])
        certificate = found["certificate"]
        self.assertEqual(certificate["modes_in_band"], 0)
        self.assertEqual(certificate["modes_found"], 0)
        self.assertTrue(certificate["complete"])
        self.assertTrue(certificate["count_verified"])
        self.assertEqual(certificate["complete_to_hz"], 20000)
        self.assertEqual(certificate["rigid_modes"], 6)
        self.assertIn("raise --max-frequency", found["explanation"])

    def test_the_advice_leads_to_modes(self):
        found = run_json("modes", BLOCK, "--material", "steel", "--max-frequency", "400kHz")
        self.assertGreater(len(found["modes"]), 0)
        self.assertNotIn("explanation", found)

    def test_a_band_above_the_first_mode(self):
        lowest = run_json("modes", BLOCK, "--material", "steel", "--max-frequency", "400kHz")
        first = lowest["modes"][0]["frequency_hz"]
        # Between two modes of the block.
        second = lowest["modes"][1]["frequency_hz"]
        found = run_json("modes", BLOCK, "--material", "steel",
                         "--min-frequency", f"{first + 1} Hz", "--max-frequency", f"{second - 1} Hz")
        self.assertEqual(found["modes"], [])
        self.assertTrue(found["certificate"]["complete"])
        self.assertIn("no mode lies between", found["explanation"])

    def test_file_of_an_empty_set(self):
        path = self.folder / "none.h5"
        result = run("modes", BLOCK, "--material", "steel", "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        with h5py.File(path) as file:
            self.assertEqual(file["eigenvalues"].shape, (0,))
            self.assertEqual(file["shapes"].shape[0], 0)


if __name__ == "__main__":
    unittest.main()
