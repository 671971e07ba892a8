"""Recordings made by others ($CARILLON_TEST_DATA): each ends in features and a fit, or in a named
reason. Some of different kinds; with CARILLON_LONG=1 all of them."""
import json
import math
import os
import pathlib
import unittest

from program import LONG, FolderTest, processor_seconds, run

DATA = os.environ.get("CARILLON_TEST_DATA")
KINDS = ["cowbell_sonicpi", "freepats_009_Glockenspiel_00",
         "freepats_013_Xylophone_04", "freepats_075_Claves_00", "freepats_081_Triangle_2_Open_00",
         "hammer_wood", "kit_WaterglassHi-Softest", "kit_WoodBlock-Hardest",
         "robot_ceramic-chopstick-ceramic-mug_1", "robot_polycarbonate-spoon-polycarbonate-cup_1",
         "robot_steel-fork-steel-bowl_1"]
MAX_SECONDS = 60  # of processor time, each


def recordings():
    folder = pathlib.Path(DATA) / "recordings"
    if LONG:
        return sorted(folder.glob("*.wav"))
    return [folder / f"{name}.wav" for name in KINDS]


@unittest.skipUnless(DATA, "CARILLON_TEST_DATA is not set")
class Recordings(FolderTest):
    def expect_sound(self, result):
        features = result["features"]
        self.assertTrue(features or result["nothing"], "neither features nor a reason")
        self.assertTrue(0 <= result["onset_s"] <= result["begin_s"])
        self.assertLessEqual(result["energy_explained"], 1)
        frequencies = [feature["frequency_hz"] for feature in features]
        self.assertEqual(frequencies, sorted(frequencies))
        for feature in features:
            f = feature["frequency_hz"]
            self.assertTrue(0 < f < 0.5 * result["sample_rate_hz"], f)
            for name in ("decay_rate_per_s", "amplitude"):
                self.assertTrue(math.isfinite(feature[name]) and feature[name] > 0, (f, name))
            # What is not known better than this is no feature.
            self.assertLess(feature["decay_rate_error_per_s"], feature["decay_rate_per_s"], f)

    def fitted(self, table):
        answer = run("fit", "--features", table, "--json")
        if answer.returncode == 0:
            parameters = json.loads(answer.stdout)["parameters"]
            for alpha in ("alpha1", "alpha2"):
                self.assertTrue(math.isfinite(parameters[alpha]) and parameters[alpha] >= 0)
            return f"c = {parameters['alpha1']:.3g} + {parameters['alpha2']:.3g} lambda"
        self.assertEqual(answer.returncode, 2, answer.stderr)
        self.assertRegex(answer.stderr, "carillon: .*[a-z]")
        return "no fit: " + answer.stderr.splitlines()[0].removeprefix("carillon: ")

    def test_every_recording_ends_in_a_fit_or_in_a_reason(self):
        table = self.folder / "table.csv"
        for path in recordings():
            with self.subTest(path.name):
                before = processor_seconds()
                answer = run("features", path, "--csv", table, "--json")
                self.assertEqual(answer.returncode, 0, answer.stderr)
                result = json.loads(answer.stdout)
                self.expect_sound(result)
                outcome = self.fitted(table) if result["features"] else result["nothing"]
                seconds = processor_seconds() - before
                print(f"{path.stem}: {len(result['features'])} features, "
                      f"{100 * result['energy_explained']:.1f} % of the energy, {outcome}; "
                      f"{seconds:.1f} s", flush=True)
                self.assertLess(seconds, MAX_SECONDS)


if __name__ == "__main__":
    unittest.main()
