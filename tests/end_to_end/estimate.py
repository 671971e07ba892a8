"""estimate: a strike of known material, and what is heard of it from another one assumed."""
import json
import os
import struct
import unittest
import wave
from pathlib import Path

import numpy
from program import FolderTest, run, run_json

# Object and where it is struck; each is solved once for all tests.
BOWL = ("bowl:radius=60mm,wall=3mm", "--order", "2")
BOWL_POINT = ("--at", "0.06,0,0.05")
TILE = ("tile:length=12cm,width=9cm,thickness=6mm", "--order", "2")
TILE_POINT = ("--at", "5cm,3cm,1cm")


def read_float_wav(path):
    """Rate and samples of a mono file of 32-bit floats."""
    data = path.read_bytes()
    place = 12
    while data[place:place + 4] != b"data":
        if data[place:place + 4] == b"fmt ":
            kind, channels, rate = struct.unpack_from("<HHI", data, place + 8)
        place += 8 + struct.unpack_from("<I", data, place + 4)[0]
    size = struct.unpack_from("<I", data, place + 4)[0]
    assert kind in (3, 0xFFFE) and channels == 1
    return rate, numpy.frombuffer(data[place + 8:place + 8 + size], "<f4")


def write_wav(path, rate, samples):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes(numpy.round(32767 * samples).astype("<i2").tobytes())


class Struck(FolderTest):
    def strike(self, name, body, point, material, *arguments):
        path = self.folder / name
        run_json("strike", *body, *point, "-m", material, "-o", path, *arguments)
        return path

    def assert_near(self, found, truth, fraction):
        self.assertLess(abs(found / truth - 1), fraction, f"{found} instead of {truth}")


class Hybrid(Struck):
    """The papers' metric, which needs the point struck."""

    def estimate(self, *arguments):
        return run_json("estimate", *arguments, "--metric", "hybrid")

    def test_steel_bowl_is_found_from_glass(self):
        clip = self.strike("bowl.wav", BOWL, BOWL_POINT, "steel")
        found = self.estimate(clip, *BOWL, *BOWL_POINT, "-m", "glass", "--poisson-ratio",
                         "0.29", "--density", "7850")
        self.assert_near(found["youngs_modulus_pa"], 2.0e11, 0.01)
        self.assert_near(found["specific_modulus_m2_per_s2"], 2.0e11 / 7850, 0.01)
        self.assert_near(found["parameters"]["alpha1"], 5, 0.1)
        self.assert_near(found["parameters"]["alpha2"], 3e-8, 0.1)
        self.assertGreater(found["recording_match"] * found["candidate_match"], 0.7)
        # The assumed object was solved once, and is not solved again for another recording of it.
        self.assertEqual(found["calls"]["solve"], 1)
        again = self.estimate(clip, *BOWL, *BOWL_POINT, "-m", "glass", "--poisson-ratio",
                         "0.29", "--density", "7850")
        self.assertNotIn("solve", again["calls"])
        self.assertEqual(again["parameters"], found["parameters"])

    def test_glass_tile_is_found_from_poissons_ratio_alone(self):
        clip = self.strike("tile.wav", TILE, TILE_POINT, "glass")
        again = self.folder / "again.wav"
        found = self.estimate(clip, *TILE, *TILE_POINT, "--poisson-ratio", "0.2", "-o", again)
        self.assert_near(found["specific_modulus_m2_per_s2"], 6.2e10 / 2600, 0.005)
        self.assert_near(found["parameters"]["alpha1"], 1, 0.1)
        self.assert_near(found["parameters"]["alpha2"], 1e-7, 0.05)
        self.assertNotIn("youngs_modulus_pa", found)
        self.assert_near(found["contact_time_s"], 2e-4, 0.1)
        # The estimate sounds like the recording, sample by sample before small errors of
        # frequency add up, and in level all through.
        rate, heard = read_float_wav(clip)
        again_rate, made = read_float_wav(again)
        self.assertEqual((rate, len(heard)), (again_rate, len(made)))
        begin = slice(0, rate // 50)
        self.assertGreater(numpy.corrcoef(heard[begin], made[begin])[0, 1], 0.9)
        self.assert_near(numpy.sqrt(numpy.mean(made ** 2)), numpy.sqrt(numpy.mean(heard ** 2)), 0.1)

    def test_wood_is_found_through_noise_with_a_hybrid_model(self):
        clip = self.strike("wood.wav", TILE, TILE_POINT, "wood", "--set",
                           "noise={kind: white, snr: 30}")
        found = self.estimate(clip, *TILE, *TILE_POINT, "-m", "ceramic", "--poisson-ratio",
                         "0.25", "--model", "hybrid")
        self.assert_near(found["specific_modulus_m2_per_s2"], 1.1e10 / 750, 0.02)
        alphas = [found["parameters"][f"alpha{k}"] for k in (1, 2, 3)]
        for frequency in (1500, 4000):
            eigenvalue = (2 * numpy.pi * frequency) ** 2
            self.assert_near(alphas[0] + alphas[1] * eigenvalue ** alphas[2],
                             60 + 2e-6 * eigenvalue, 0.2)

    def test_a_larger_body_is_taken_for_a_softer_one(self):
        larger = ("tile:length=12.12cm,width=9.09cm,thickness=6.06mm", "--order", "2")
        clip = self.strike("larger.wav", larger, TILE_POINT, "glass")
        found = self.estimate(clip, *TILE, *TILE_POINT, "--poisson-ratio", "0.2")
        self.assert_near(found["specific_modulus_m2_per_s2"], 6.2e10 / 2600 / 1.01 ** 2, 0.005)
        self.assertIn("1 % larger", found["remarks"][-1])

    def test_text_names_what_was_found(self):
        clip = self.strike("text.wav", TILE, TILE_POINT, "glass")
        result = run("estimate", clip, *TILE, *TILE_POINT, "--poisson-ratio", "0.2", "--density",
                     "2600", "--metric", "hybrid")
        self.assertEqual(result.returncode, 0, result.stderr)
        for words in ("specific modulus", "Young's modulus", "alpha1", "other minima", "search"):
            self.assertIn(words, result.stdout)
        ranks = run("estimate", clip, *TILE, *TILE_POINT, "--poisson-ratio", "0.2", "--density",
                    "2600", "--metric", "hybrid", "--json", ranks=2)
        self.assertEqual(ranks.returncode, 0, ranks.stderr)
        self.assertEqual(ranks.stdout.count("specific_modulus_error"), 1)


class Pitches(Struck):
    """The frequencies alone: wherever it was struck and heard."""

    def assert_holds(self, interval, truth):
        self.assertLess(interval[0], truth)
        self.assertGreater(interval[1], truth)

    def test_glass_tile_is_found_with_its_poissons_ratio(self):
        clip = self.strike("tile.wav", TILE, TILE_POINT, "glass")
        found = run_json("estimate", clip, *TILE, "--density", "2600")
        self.assertTrue(found["determined"])
        self.assert_near(found["specific_modulus_m2_per_s2"], 6.2e10 / 2600, 0.01)
        self.assert_near(found["youngs_modulus_pa"], 6.2e10, 0.01)
        self.assert_holds(found["confidence95"]["specific_modulus_m2_per_s2"], 6.2e10 / 2600)
        self.assert_holds(found["confidence95"]["poisson_ratio"], 0.2)
        # Against 70 GPa and the density that was given, with elements whose errors are in the interval.
        self.assert_holds(found["confidence95"]["frequency_scale"], (6.2e10 / 7.0e10) ** 0.5)
        self.assert_near(found["frequency_scale"], (6.2e10 / 7.0e10) ** 0.5, 0.005)
        self.assertIsNone(found["room_rt60_s"])
        self.assert_near(found["parameters"]["alpha1"], 1, 0.2)
        self.assert_near(found["parameters"]["alpha2"], 1e-7, 0.1)
        self.assert_holds(found["parameters"]["confidence95"]["alpha2"], 1e-7)
        self.assertNotIn("scale", found)

    def test_bowl_of_revolution_is_found_without_anything_known(self):
        # The axisymmetric solver's modes at nine Poisson's ratios.
        bowl = ("bowl:radius=60mm,wall=3mm", "--max-frequency", "12kHz")
        clip = self.strike("bowl.wav", bowl, BOWL_POINT, "steel")
        found = run_json("estimate", clip, *bowl)
        self.assert_holds(found["confidence95"]["specific_modulus_m2_per_s2"], 2.0e11 / 7850)
        self.assert_near(found["specific_modulus_m2_per_s2"], 2.0e11 / 7850, 0.02)
        self.assert_holds(found["confidence95"]["poisson_ratio"], 0.29)

    def test_two_microphones_in_a_room_are_joined(self):
        room = ("--set", "room={dimensions: [5, 4, 3], rt60: 0.4}", "--set",
                "noise={kind: white, snr: 40}")
        clips = [self.strike(f"{place[:1]}.wav", BOWL, ("--at", place), "steel", "--listener",
                             listener, *room)
                 for place, listener in (("0.06,0,0.05", "0.1,0.2,0.45"), ("0,0.06,0.05", "-0.3,0,0.4"))]
        alone = run_json("estimate", clips[0], *BOWL, "--poisson-ratio", "0.29")
        joined = run_json("estimate", clips[0], *BOWL, clips[1], "--poisson-ratio", "0.29")
        self.assertGreaterEqual(len(joined["matches"]), len(alone["matches"]))
        self.assert_near(joined["room_rt60_s"], 0.4, 0.35)
        self.assert_holds(joined["parameters"]["confidence95"]["alpha1"], 5)
        self.assert_holds(joined["parameters"]["confidence95"]["alpha2"], 3e-8)
        text = run("estimate", clips[0], *BOWL, clips[1], "--poisson-ratio", "0.29").stdout
        self.assertRegex(text, r"frequency scale +[0-9.]+ of the assumed material's, 95 %: [0-9.]+ to [0-9.]+")
        self.assertIn("a room of RT60 about", text)
        self.assert_near(joined["specific_modulus_m2_per_s2"], 2.0e11 / 7850, 0.02)
        self.assert_holds(joined["confidence95"]["specific_modulus_m2_per_s2"], 2.0e11 / 7850)

    def test_what_is_not_determined_is_no_number_and_exit_code_3(self):
        # The sound of a bowl, and the mesh of a tile; then noise.
        bowl = self.strike("bowl.wav", BOWL, BOWL_POINT, "steel")
        noise = self.folder / "noise.wav"
        time = numpy.arange(44100) / 44100
        write_wav(noise, 44100, 0.1 * numpy.exp(-8 * time) *
                  numpy.random.default_rng(1).standard_normal(44100))
        for clip in (bowl, noise):
            result = run("estimate", clip, *TILE, "--poisson-ratio", "0.29", "--json")
            self.assertIn(result.returncode, (2, 3), result.stderr)
            if result.returncode == 2:  # nothing rings at all
                self.assertIn("no modes can be heard", result.stderr)
                continue
            found = json.loads(result.stdout)
            self.assertFalse(found["determined"])
            self.assertIsNone(found["specific_modulus_m2_per_s2"])
            self.assertIsNone(found["parameters"])
            self.assertEqual(found["matches"], [])
            self.assertIn("chance", found["undetermined"])
        text = run("estimate", bowl, *TILE, "--poisson-ratio", "0.29")
        self.assertEqual(text.returncode, 3, text.stderr)
        self.assertIn("not determined", text.stdout)
        self.assertNotIn("m^2/s^2", text.stdout)


@unittest.skipUnless(os.environ.get("CARILLON_TEST_DATA"),
                     "CARILLON_TEST_DATA names no folder of real recordings")
class RealBowl(FolderTest):
    """A ceramic bowl, its scanned mesh and two microphones: E / density is 2.8e7 m^2/s^2."""

    PARTIALS = (1682, 4168, 7361, 11150, 12327, 13397)  # [Hz]

    def test_either_microphone_tells_the_material(self):
        folder = Path(os.environ["CARILLON_TEST_DATA"]) / "real"
        for microphone in ("mic0", "mic3"):
            recording = folder / f"bowl_ceramic_{microphone}.wav"
            found = run_json("estimate", recording, folder / "bowl_ceramic.msh", "--order", "2")
            modulus = found["specific_modulus_m2_per_s2"]
            self.assertLess(abs(modulus / 2.8e7 - 1), 0.03, microphone)
            low, high = found["confidence95"]["specific_modulus_m2_per_s2"]
            self.assertLess(low, 2.8e7)
            self.assertGreater(high, 2.8e7)
            self.assertLess(high / low, 1.06)
            # Damping: of the six partials that are known of this bowl, the strongest feature near each
            # (the third is 23 dB below a burst beside it in microphone 3, and not found there).
            # Rayleigh's law is not the bowl's, and they end at 13.4 kHz where the matches end at
            # 19.6: the intervals are to overlap.
            features = run_json("features", recording, "--min-level", "-60")["features"]
            table = self.folder / "partials.csv"
            with table.open("w") as file:
                file.write("frequency_hz,decay_rate_per_s\n")
                for partial in self.PARTIALS:
                    near = [one for one in features if abs(one["frequency_hz"] / partial - 1) < 0.006]
                    if not near:
                        self.assertEqual((microphone, partial), ("mic3", 7361))
                        continue
                    one = max(near, key=lambda feature: feature["snr_db"])
                    file.write(f"{one['frequency_hz']},{one['decay_rate_per_s']}\n")
            fitted = run_json("fit", "--features", table, "--estimator", "least_squares")["parameters"]
            for name in ("alpha1", "alpha2"):
                low, high = found["parameters"]["confidence95"][name]
                fitted_low, fitted_high = fitted["confidence95"][name]
                self.assertLess(low, fitted_high, (microphone, name))
                self.assertGreater(high, fitted_low, (microphone, name))


class Refused(FolderTest):
    def refuse(self, *arguments):
        result = run("estimate", *arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        return result.stderr

    def test_what_cannot_be_estimated_is_named(self):
        silent = self.folder / "silent.wav"
        write_wav(silent, 44100, numpy.zeros(44100))
        nu = ("--poisson-ratio", "0.2")
        self.assertIn("no modes can be heard", self.refuse(silent, *TILE, *TILE_POINT, *nu))
        hybrid = ("--metric", "hybrid")
        self.assertIn("Poisson's ratio cannot be heard",
                      self.refuse(silent, *TILE, *TILE_POINT, *hybrid))
        self.assertIn("--at", self.refuse(silent, *TILE, *nu, *hybrid))
        self.assertIn("one recording", self.refuse(silent, *TILE, silent, *TILE_POINT, *nu, *hybrid))
        self.assertIn("--metric hybrid", self.refuse(silent, *TILE, *nu, "-o", "again.wav"))
        self.assertIn("--at", self.refuse(silent, *TILE, *nu, "--direction", "0,0,1"))
        self.assertIn("loudness", self.refuse(silent, *TILE, *nu, "--metric", "loudness"))
        self.assertIn("1 channel", self.refuse(silent, *TILE, *TILE_POINT, *nu, "--channel", "2"))
        self.assertIn("raleigh", self.refuse(silent, *TILE, *TILE_POINT, *nu, "--model", "raleigh"))
        self.assertIn("speed", self.refuse(silent, *TILE, *TILE_POINT, *nu, "--heard", "speed"))
        self.assertIn("Poisson", self.refuse(silent, *TILE, *TILE_POINT, "--poisson-ratio", "0.7"))
        self.assertIn("none.wav", self.refuse("none.wav", *TILE, *TILE_POINT, *nu))

    def test_a_body_without_modes_in_the_band(self):
        rate = 44100
        time = numpy.arange(rate) / rate
        clip = sum(numpy.exp(-10 * time) * numpy.cos(2 * numpy.pi * f * time) / 8
                   for f in (900, 2100, 3700, 5500))
        path = self.folder / "tones.wav"
        write_wav(path, rate, clip)
        tiny = ("tile:length=4mm,width=4mm,thickness=3mm", "--order", "2")
        self.assertIn("no mode in its band",
                      self.refuse(path, *tiny, "--at", "0,0,0", "--poisson-ratio", "0.2"))


if __name__ == "__main__":
    unittest.main()
