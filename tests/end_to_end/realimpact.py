"""`carillon realimpact`: what is known of made recordings is found in them, and what is wrong with a
folder is named.

With CARILLON_FIGURE=file.png in the environment the spectra of the radiated strikes are kept, too
(docs/realimpact.md)."""
import csv
import math
import os
import re
import shutil
import unittest

import numpy
from impact_folders import NORMAL, RATE, microphones, plate, ringing, write_folder
from program import FolderTest, draws_figures, run, run_json

SIZES = (0.16, 0.12, 0.005)
MESH = ("--order", "2", "--element-size", "2 cm")
# Up to the same mode: the stiffer object has it higher.
TRUE_SOLVE = (*MESH, "--max-frequency", "8 kHz")
SOLVE = (*MESH, "--max-frequency", "9 kHz")
# What the plate is made of, and what it is taken for.
TRUE = "youngs_modulus=6.5e10,poisson_ratio=0.25,density=2500,alpha1=12,alpha2=1.2e-7"
TAKEN = "youngs_modulus=8e10,poisson_ratio=0.25,density=2500,alpha1=5,alpha2=4e-8"
ALPHAS = (12, 1.2e-7)
MODULUS_RATIO = 6.5 / 8
SHIFT = 1200 * math.log2(math.sqrt(MODULUS_RATIO))
# Of the upper face, off its lines of symmetry.
VERTICES = (63 + 10, 63 + 22, 63 + 33, 63 + 43)
NOISE = 1e-3


def decay_of(eigenvalue):
    return 0.5 * (ALPHAS[0] + ALPHAS[1] * eigenvalue)


class MadeFolder(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.mesh = plate(*SIZES)
        cls.obj = cls.folder / "plate.obj"
        random = numpy.random.default_rng(1)
        place = cls.make_empty(cls.folder / "mesh-only")
        cls.obj = place / "transformed.obj"
        cls.modes = cls.folder / "modes.h5"
        cls.true_modes = run_json("modes", cls.obj, "-m", TRUE, *TRUE_SOLVE, "-o", cls.modes)["modes"]
        strikes = []
        for vertex in VERTICES:
            sounds = []
            for *_, position in microphones():
                delay = numpy.linalg.norm(position) / 343
                sound = 0.02 * ringing(cls.modes, cls.mesh[0][vertex], -NORMAL, decay_of, 0.7, delay)
                sounds.append(sound + NOISE * numpy.abs(sound).max() *
                              random.standard_normal(len(sound)))
            strikes.append((vertex, sounds))
        cls.object = cls.folder / "7_Plate"
        cls.place = write_folder(cls.object, cls.mesh, strikes)

    @classmethod
    def make_empty(cls, folder):
        return write_folder(folder, cls.mesh, [(VERTICES[0], [numpy.zeros(10)] * len(microphones()))])

    def expect_same(self, one, two, place="found"):
        """But for last digits, as two ranks add up in another order than one."""
        self.assertIs(type(one), type(two), place)
        if isinstance(one, dict):
            self.assertEqual(set(one), set(two), place)
            for name in one:
                if name == "evaluations":  # the search takes a step more or less for them
                    self.assertLess(abs(one[name] - two[name]), 0.05 * one[name], place)
                else:
                    self.expect_same(one[name], two[name], f"{place}.{name}")
        elif isinstance(one, list):
            self.assertEqual(len(one), len(two), place)
            for number, pair in enumerate(zip(one, two)):
                self.expect_same(*pair, f"{place}[{number}]")
        elif isinstance(one, float):
            self.assertTrue(math.isclose(one, two, rel_tol=1e-6, abs_tol=1e-10), (place, one, two))
        elif isinstance(one, str):
            number = r"-?\d+\.?\d*(?:e[+-]?\d+)?"
            self.assertEqual(re.sub(number, "", one), re.sub(number, "", two), place)
            self.expect_same([float(found) for found in re.findall(number, one)],
                             [float(found) for found in re.findall(number, two)], place)
        else:
            self.assertEqual(one, two, place)


class Contact(MadeFolder):
    """Recordings of the struck point itself, summed by NumPy: nothing is radiated."""

    def test_material_modes_decays_and_levels_are_found(self):
        found = run_json("realimpact", self.object, "-m", TAKEN, *SOLVE, "--radiation", "off", "-o",
                         self.folder / "report")
        fit = found["fit"]
        self.assertLess(abs(fit["specific_modulus_ratio"] / MODULUS_RATIO - 1), 0.002)
        self.assertLess(abs(fit["youngs_modulus_pa"] / 6.5e10 - 1), 0.002)
        self.assertLess(abs(fit["parameters"]["alpha1"] / ALPHAS[0] - 1), 0.1)
        self.assertLess(abs(fit["parameters"]["alpha2"] / ALPHAS[1] - 1), 0.02)
        for name, truth in zip(("alpha1", "alpha2"), ALPHAS):
            low, high = fit["parameters"]["confidence95"][name]
            self.assertLess(low, truth)
            self.assertGreater(high, truth)
            self.assertLess(high - low, 0.2 * truth)
        names = [variant["variant"] for variant in found["variants"]]
        self.assertEqual(names, ["as given", "scaled to the highest peak",
                                 "scaled to the lowest of ten", "fitted"])
        fitted = found["variants"][3]["modes"]
        self.assertGreater(fitted["recorded"], 4 * 8)
        self.assertGreater(fitted["matched"], 0.95 * fitted["recorded"])
        self.assertLess(fitted["distance_cents"]["nine_tenths"], 3)
        self.assertLess(abs(fitted["decay_ratio"]["median"] - 1), 0.02)
        self.assertLess(abs(fitted["decay_ratio"]["tenth"] - 1), 0.1)
        self.assertLess(fitted["level_error_db"]["median"], 0.5)
        self.assertLess(fitted["level_error_db"]["nine_tenths"], 1.5)
        self.assertGreater(fitted["matched"], 2 * fitted["matched_by_chance"])
        shift = 1200 * math.log2(found["variants"][3]["frequency_scale"]["median"])
        self.assertLess(abs(shift - SHIFT), 1)
        # The gain of the recorder is in no level, and is told.
        self.assertLess(abs(20 * math.log10(found["variants"][3]["gain"] / 0.02)), 1)
        # Hiner's spectra: with the fit the plate's modes are peaks.
        peaks = found["variants"][3]["peaks"]
        self.assertGreater(peaks["matched"], peaks["matched_by_chance"])
        self.assertLess(peaks["distance_cents"]["median"], 10)
        self.check_files(found)

    def check_files(self, found):
        report = self.folder / "report"
        with open(report / "modes.csv", encoding="utf-8") as file:
            lines = [line for line in csv.DictReader(file) if line["variant"] == "fitted"]
        pairs = [line for line in lines if line["recorded_hz"] and line["synthetic_hz"]]
        self.assertEqual(len(pairs), found["variants"][3]["modes"]["matched"])
        for line in pairs:
            cents = 1200 * math.log2(float(line["synthetic_hz"]) / float(line["recorded_hz"]))
            self.assertLess(abs(cents - float(line["pitch_cents"])), 0.05)
        with open(report / "spectra.csv", encoding="utf-8") as file:
            spectra = [line for line in csv.DictReader(file) if line["vertex"] == str(VERTICES[0])]
        self.assertEqual(len(spectra), 2970 // 2 + 1)
        # The same spectrum by NumPy, of the first microphone in front of the object.
        sound = numpy.load(self.place / "deconvolved_0db.npy")[1]
        n = 2 * numpy.pi * numpy.arange(2970) / 2970
        window = (0.35875 - 0.48829 * numpy.cos(n) + 0.14128 * numpy.cos(2 * n)
                  - 0.01168 * numpy.cos(3 * n))
        spectrum = 2 * numpy.abs(numpy.fft.rfft(window * sound[30:3000])) / window.sum()
        recorded = [float(line["recorded_db"]) for line in spectra]
        self.assertLess(numpy.abs(recorded - 20 * numpy.log10(spectrum)).max(), 0.01)
        # The fitted model's spectrum is that of the recording wherever that is above the noise.
        fitted = numpy.array([float(line["fitted_db"]) for line in spectra])
        loud = spectrum > 0.1 * spectrum.max()
        self.assertLess(numpy.abs(fitted - recorded)[loud].mean(), 1.5)
        self.assertTrue((report / f"vertex-{VERTICES[0]}-recorded.wav").exists())
        self.assertTrue((report / f"vertex-{VERTICES[0]}-fitted.wav").exists())

    def test_the_material_as_given_is_off_by_what_is_known(self):
        found = run_json("realimpact", self.object, "-m", TAKEN, *SOLVE, "--radiation", "off",
                         "--no-fit", "--widest", "40", "--vertex", VERTICES[1])
        self.assertNotIn("fit", found)
        self.assertEqual([v["vertex"] for v in found["vertices"]], [VERTICES[1]])
        truth = [mode["frequency_hz"] for mode in self.true_modes]
        # All modes are 180 cents too high: within 40 cents there is nothing but chance.
        strike = found["vertices"][0]["variants"][0]
        made = [mode["frequency_hz"] for mode in strike["synthetic_only"]]
        made += [pair["synthetic"]["frequency_hz"] for pair in strike["matched"]]
        for frequency in made:
            off = [1200 * math.log2(frequency / mode) + SHIFT for mode in truth]
            self.assertLess(min(map(abs, off)), 1)
        given = found["variants"][0]["modes"]
        self.assertLess(given["matched"], 0.4 * given["recorded"])
        self.assertLess(given["matched"], 2 * given["matched_by_chance"] + 2)
        for variant in (1, 2):
            scale = found["vertices"][0]["variants"][variant]["frequency_scale"]
            peak = scale * truth[0] / math.sqrt(MODULUS_RATIO)
            # The peak is one of the plate's modes, whichever is the highest.
            nearest = min(abs(1200 * math.log2(peak / mode)) for mode in truth)
            self.assertLess(nearest, 12)
        wide = run_json("realimpact", self.object, "-m", TAKEN, *SOLVE, "--radiation", "off",
                        "--no-fit", "--widest", "150", "--max-modes", "1")
        self.assertEqual(wide["modes"], 1)

    def test_a_stretch_is_of_the_same_time_at_every_rate(self):
        one = ("realimpact", self.object, "-m", TAKEN, *SOLVE, "--radiation", "off", "--no-fit",
               "--vertex", VERTICES[1])
        slow = run_json(*one, "--sample-rate", "24 kHz")
        self.assertEqual(slow["stretch_samples"], [15, 1500])
        found = run_json(*one, "--stretch", "60,2000", "-o", self.folder / "stretch")
        self.assertEqual(found["stretch_samples"], [60, 2000])
        lines = (self.folder / "stretch" / "spectra.csv").read_text().splitlines()
        self.assertEqual(len(lines), 1 + 1940 // 2 + 1)

    def test_the_papers_metric_finds_it_too(self):
        found = run_json("realimpact", self.object, "-m", TAKEN, *SOLVE, "--radiation", "off",
                         "--metric", "hybrid", "--vertex", VERTICES[1])
        self.assertLess(abs(found["fit"]["specific_modulus_ratio"] / MODULUS_RATIO - 1), 0.002)
        self.assertEqual(found["fit"]["metric"], "hybrid")
        self.assertNotIn("specific_modulus_95_m2_per_s2", found["fit"])

    def test_the_name_says_the_material(self):
        named = self.folder / "7_IronPlate"
        shutil.copytree(self.object, named)
        arguments = (*SOLVE, "--radiation", "off", "--no-fit", "--vertex", VERTICES[1])
        for place in (named, named / "preprocessed"):
            found = run_json("realimpact", place, *arguments)
            self.assertEqual((found["material"], found["object"]), ("iron", "7_IronPlate"))
        given = run_json("realimpact", named, "-m", "glass", *arguments)
        self.assertEqual(given["material"], "glass")
        result = run("realimpact", self.object, *arguments)
        self.assertEqual(result.returncode, 2)
        self.assertIn("7_Plate: the name does not say", result.stderr)
        self.assertIn("--material", result.stderr)

    def test_text_and_ranks(self):
        arguments = ("realimpact", self.place, "-m", TAKEN, *SOLVE, "--radiation", "off",
                     "--vertex", VERTICES[0], "--vertex", VERTICES[2])
        result = run(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        for words in ("as given", "scaled to the highest peak", "fitted", "by chance",
                      "specific modulus", "each vertex alone", "95 %:", "not physical"):
            self.assertIn(words, result.stdout)
        one, two = (run_json(*arguments, ranks=ranks) for ranks in (None, 2))
        for found in (one, two):
            del found["timing"]
        self.expect_same(one, two)

    def test_listeners(self):
        def rows(listener, *more):
            found = run_json("realimpact", self.object, "-m", TAKEN, *SOLVE, "--radiation", "off",
                             "--no-fit", "--listener", listener, *more)
            return [vertex["row"] for vertex in found["vertices"]]
        count = len(microphones())
        self.assertEqual(rows("nearest"), [1 + count * k for k in range(len(VERTICES))])
        chosen = [k for k, place in enumerate(microphones()) if place[:3] == (80, 333, 9)]
        self.assertEqual(rows("angle=80,distance=333,mic=9"),
                         [chosen[0] + count * k for k in range(len(VERTICES))])
        one = ("--vertex", VERTICES[2])
        self.assertEqual(rows("angle=40", *one), [7 + 2 * count])
        self.assertEqual(rows("13", *one), [13 + 2 * count])


class Radiated(MadeFolder):
    """Recordings of the pressure at a microphone, as `carillon strike` makes them."""

    def setUp(self):
        self.object = self.folder / "radiated"
        if self.object.exists():
            return
        strikes = []
        ear = microphones()[4]
        for vertex in VERTICES[:2]:
            clip = self.folder / f"strike-{vertex}.wav"
            at = ",".join(f"{x:.9g}" for x in self.mesh[0][vertex])
            run_json("strike", self.obj, "-m", TRUE, *TRUE_SOLVE, "--at", at, "--listener",
                     ",".join(f"{x:.9g}" for x in ear[3]), "--impulse", "1 N s", "--contact-time",
                     "0", "--seconds", "0.7 s", "--sample-rate", RATE, "--gain", "0.003",
                     "--set", "effects.click=off", "-o", clip)
            data = clip.read_bytes()
            sound = numpy.frombuffer(data[data.index(b"data") + 8:], "<f4").astype(float)
            strikes.append((vertex, [sound] * len(microphones())))
        write_folder(self.object, self.mesh, strikes)

    def test_levels_are_those_of_the_sound(self):
        found = run_json("realimpact", self.object, "-m", TAKEN, *SOLVE, "--listener",
                         "angle=0,distance=333,mic=7", "-o", self.folder / "radiated-out")
        fit = found["fit"]
        self.assertLess(abs(fit["specific_modulus_ratio"] / MODULUS_RATIO - 1), 0.002)
        # The material's own damping, without what is radiated.
        self.assertLess(abs(fit["parameters"]["alpha1"] / ALPHAS[0] - 1), 0.1)
        self.assertLess(abs(fit["parameters"]["alpha2"] / ALPHAS[1] - 1), 0.05)
        fitted = found["variants"][3]["modes"]
        self.assertLess(fitted["level_error_db"]["median"], 0.3)
        self.assertLess(fitted["level_error_db"]["nine_tenths"], 1)
        self.assertLess(abs(fitted["decay_ratio"]["median"] - 1), 0.02)
        self.assertLess(abs(20 * math.log10(found["variants"][3]["gain"] / 0.003)), 0.5)
        picture = self.folder / "radiated-out" / "spectra.png"
        if draws_figures():
            self.assertTrue(picture.exists())
        if "CARILLON_FIGURE" in os.environ:
            shutil.copy(picture, os.environ["CARILLON_FIGURE"])
        # What was reckoned at other frequencies is not told.
        for scaled in found["variants"][1:3]:
            self.assertTrue(scaled["frequencies_alone"])
            self.assertIsNotNone(scaled["modes"]["matched"])
            self.assertIsNone(scaled["modes"]["decay_ratio"]["median"])
            self.assertIsNone(scaled["modes"]["level_error_db"]["median"])
            self.assertIsNone(scaled["gain"])
        with open(self.folder / "radiated-out" / "modes.csv", encoding="utf-8") as file:
            lines = [line for line in csv.DictReader(file) if line["synthetic_hz"]]
        for line in lines:
            told = not line["variant"].startswith("scaled")
            for name in ("synthetic_decay_per_s", "synthetic_amplitude"):
                self.assertEqual(bool(line[name]), told, line)
        self.assertTrue(any(line["variant"].startswith("scaled") for line in lines))
        # A contact microphone hears other levels than a room does.
        contact = run_json("realimpact", self.object, "-m", TAKEN, *SOLVE, "--listener",
                           "angle=0,distance=333,mic=7", "--radiation", "off")
        self.assertGreater(contact["variants"][3]["modes"]["level_error_db"]["median"], 3)
        self.assertFalse(any(variant["frequencies_alone"] for variant in contact["variants"]))


class Refused(MadeFolder):
    def refuse(self, folder, *arguments, ranks=None):
        result = run("realimpact", folder, "-m", TAKEN, *SOLVE, *arguments, ranks=ranks)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        return result.stderr

    def changed(self, name, change):
        """A copy whose array `name` is another one."""
        copy = self.folder / "changed"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(self.object, copy)
        path = copy / "preprocessed" / f"{name}.npy"
        array = change(numpy.load(path))
        if array is None:
            path.unlink()
        else:
            numpy.save(path, array)
        return copy

    def test_what_is_wrong_with_a_folder_is_named(self):
        self.assertIn("no such folder", self.refuse(self.folder / "none"))
        self.assertIn("there is no deconvolved_0db.npy", self.refuse(self.folder))
        for name in ("vertexID", "vertexXYZ", "listenerXYZ"):
            self.assertIn(f"{name}.npy: no such file",
                          self.refuse(self.changed(name, lambda array: None)))
        rows = len(VERTICES) * len(microphones())
        self.assertIn(f"{rows - 1} rows, but there are {rows} recordings",
                      self.refuse(self.changed("micID", lambda array: array[:-1])))
        self.assertIn("recordings x 3 is expected",
                      self.refuse(self.changed("listenerXYZ", lambda array: array[:, :2])))
        self.assertIn("recordings x samples is expected",
                      self.refuse(self.changed("deconvolved_0db", lambda array: array[0])))
        self.assertIn("names vertex 126, but", self.refuse(
            self.changed("vertexID", lambda array: numpy.where(array == VERTICES[0], 126, array))))
        self.assertIn("names vertex -1, but",
                      self.refuse(self.changed("vertexID", lambda array: -1 + 0 * array)))
        self.assertIn("in the same coordinates, in metres",
                      self.refuse(self.changed("vertexXYZ", lambda array: 1000 * array)))
        self.assertIn("row 0 is not finite",
                      self.refuse(self.changed("listenerXYZ", lambda array: array * numpy.nan)))
        self.assertIn("big-endian",
                      self.refuse(self.changed("vertexXYZ", lambda array: array.astype(">f8"))))
        self.assertIn("ascontiguousarray", self.refuse(
            self.changed("vertexXYZ", lambda array: numpy.asfortranarray(array))))

    def test_what_is_wrong_with_a_recording_is_named(self):
        def spoilt(array):
            array[1, 5] = numpy.nan
            return array
        folder = self.changed("deconvolved_0db", spoilt)
        refused = self.refuse(folder, "--radiation", "off", "--vertex", VERTICES[0])
        self.assertIn("sample 5 of row 1 is not finite", refused)
        self.assertIn("name other vertices", refused)
        # The others are studied, as if they were alone.
        arguments = ("-m", TAKEN, *SOLVE, "--no-fit")
        found = run_json("realimpact", folder, *arguments)
        remarks = "\n".join(found["remarks"])
        self.assertIn(f"vertex {VERTICES[0]} is left out: ", remarks)
        self.assertIn("sample 5 of row 1 is not finite", remarks)
        others = run_json("realimpact", folder, *arguments,
                          *(word for vertex in VERTICES[1:] for word in ("--vertex", vertex)))
        self.expect_same(found["vertices"], others["vertices"])
        self.expect_same(found["variants"], others["variants"])

    def test_silence_is_named_by_all_ranks(self):
        refused = self.refuse(self.changed("deconvolved_0db", lambda array: 0 * array),
                              "--radiation", "off", ranks=2)
        self.assertIn("no recording can be compared: row", refused)
        self.assertIn("is silent", refused)
        self.assertNotIn("MPI_ABORT", refused)

    def test_a_cut_file_is_named(self):
        cut = self.changed("angle", lambda array: array)
        path = cut / "preprocessed" / "deconvolved_0db.npy"
        path.write_bytes(path.read_bytes()[:-4])
        self.assertIn("the file is not whole", self.refuse(cut))

    def test_what_cannot_be_chosen_is_named(self):
        self.assertIn("there are 0, 40, 80", self.refuse(self.object, "--listener", "angle=30"))
        self.assertIn("recordings 0 to 17", self.refuse(self.object, "--listener", "18"))
        self.assertIn("row: no such label", self.refuse(self.object, "--listener", "row=3"))
        self.assertIn("--vertex 5: it was not struck", self.refuse(self.object, "--vertex", "5"))
        self.assertIn("there is no angle.npy", self.refuse(
            self.changed("angle", lambda array: None), "--listener", "angle=0"))
        self.assertIn("raleigh", self.refuse(self.object, "--model", "raleigh"))
        for stretch, said in (("30", "FIRST,END"), ("30,40", "fewer than 16"),
                              ("-1,3000", "not samples")):
            self.assertIn(said, self.refuse(self.object, f"--stretch={stretch}"))


if __name__ == "__main__":
    unittest.main()
