"""The synthetic validation of damping fits: what `carillon evaluate` finds, as h5py and SciPy see it,
whatever was killed on the way and on however many ranks."""
import csv
import json
import shutil
import signal
import subprocess
import unittest

import h5py
import numpy
import scipy.stats
from browser import expect_report
from interrupted import wait_for
from program import CARILLON, FolderTest, run, run_json
from same import hashes

CONFIG = """
name: small
seed: 3
sweep:
  keys:
    effects:
      named:
        clean: {noise: "off", room: "off", tail: "off"}
        noise and room: {noise: auto, room: auto, tail: auto}
materials_file: own.yaml
materials: [one, two]
objects:
  - {shape: bar, count: 2, parameters: {length: [20 cm, 25 cm], width: 2 cm, height: 8 mm}}
  - {shape: tile, parameters: {length: 16 cm, width: 12 cm, thickness: 6 mm}}
modes: {max_modes: 15, order: 2, element_size: 20 mm, max_frequency: 7 kHz}
strikes: {per_object: 5}
audio: {seconds: 0.4 s, sample_rate: 16 kHz}
supports:
  contacts: [{kind: finger, count: 1, pool: 4, force: [0.1 N, 1 N]}]
listeners: [{position: [0, 0, 0.5]}]
radiation: {damps_modes: false}
room: {dimensions: [4 m, 3 m, 2.5 m], rt60: 0.2 s, count: 2}
noise: {kind: white, snr: 40 dB}
split: {validation: 0, test: 0}
evaluate:
  damping:
    sound_counts: [1, 3, 5]
    draws: 8
    draws_from: [object, material]
    features: {extractors: [esprit, truth]}
"""
OWN = """
one: {youngs_modulus: 70 GPa, poisson_ratio: 0.2, density: 2500, alpha1: 5, alpha2: 1.0e-7}
two: {youngs_modulus: 200 GPa, poisson_ratio: 0.3, density: 7800, alpha1: 2, alpha2: 3.0e-8}
"""
TRUTH = {"one": (5, 1e-7), "two": (2, 3e-8)}
ESTIMATORS = ["mixture", "emg", "emg_relative", "least_squares", "lower_bound"]
# The order of these, or the seconds in them, are the run's.
OWN_FILES = ("damping-trace.json", "damping-fits.jsonl", "damping.png")
PLACE = ("condition", "features", "from", "material", "sounds", "parameter")


def findings(output):
    """What equal evaluations share."""
    return {name: digest for name, digest in hashes(output).items()
            if not name.endswith(OWN_FILES)}


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def errors_of_fits(output):
    """Relative errors, recomputed from the table of fits: place and estimator -> draw by draw."""
    errors = {}
    for row in rows(output / "evaluation" / "damping-fits.csv"):
        for i, parameter in enumerate(("alpha1", "alpha2")):
            truth = TRUTH[row["material"]][i]
            error = (float(row[parameter]) - truth) / truth if row[parameter] else numpy.nan
            for material in (row["material"], "all"):
                place = (row["condition"], row["features"], row["from"], material,
                         int(row["sounds"]), parameter)
                errors.setdefault((place, row["estimator"]), []).append(error)
    return {key: numpy.array(values) for key, values in errors.items()}


class Evaluate(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.write(cls, "small.yaml", CONFIG)
        cls.write(cls, "own.yaml", OWN)
        cls.output = cls.folder / "out"
        cls.found = run_json("evaluate", cls.config, "-o", cls.output, ranks=2)

    def test_says_what_it_did(self):
        self.assertEqual(self.found["conditions"], ["clean", "noise and room"])
        self.assertEqual(self.found["estimators"], ESTIMATORS)
        self.assertEqual(self.found["parameters"], ["alpha1", "alpha2"])
        self.assertEqual(self.found["failures"], [])
        # Two sources of features, three objects, two datasets; the true modes of both datasets are
        # the same, and so are their fits: 3 of 4 pairs, 2 materials, 2 kinds of sets, 3 numbers.
        self.assertEqual(self.found["tasks_run"], {"features": 12, "fits": 48})
        for stage in ("features", "fits", "tables"):
            self.assertGreater(self.found["timing"][f"{stage}_s"], 0)
        stored = json.loads((self.output / "evaluation" / "damping.json").read_text())
        for name in ("output", "tasks_run", "timing", "interrupted"):
            del self.found[name]
        self.assertEqual(self.found, stored)
        self.assertTrue((self.output / "evaluation" / "damping.svg").exists())

    def test_its_report(self):
        expect_report(self, self.output, ["accuracy", "samples", "gallery", "damping-0"])

    def test_errors_are_those_of_the_fits(self):
        recomputed = errors_of_fits(self.output)
        stored = rows(self.output / "evaluation" / "damping-errors.csv")
        self.assertEqual(len(stored), len(recomputed))
        self.assertEqual(len(stored), 2 * 2 * 2 * 3 * 3 * 2 * 5)
        for row in stored:
            place = tuple(int(row[n]) if n == "sounds" else row[n] for n in PLACE)
            errors = recomputed[place, row["estimator"]]
            good = errors[numpy.isfinite(errors)]
            self.assertEqual(int(row["fits"]), len(errors))
            self.assertEqual(int(row["failed"]), len(errors) - len(good))
            if len(good) == 0:
                self.assertEqual(row["median"], "")
                continue
            sizes = abs(good)
            for name, value in (("median", numpy.median(sizes)), ("mean", numpy.mean(sizes)),
                                ("lower_quartile", numpy.quantile(sizes, 0.25)),
                                ("upper_quartile", numpy.quantile(sizes, 0.75)),
                                ("bias", numpy.median(good))):
                self.assertAlmostEqual(float(row[name]) / value, 1, 9, (place, name))
            self.assertLessEqual(float(row["median95_low"]), float(row["median"]))
            self.assertGreaterEqual(float(row["median95_high"]), float(row["median"]))

    def test_significance_is_scipys(self):
        recomputed = errors_of_fits(self.output)
        families = {}
        for row in rows(self.output / "evaluation" / "damping-tests.csv"):
            place = tuple(int(row[n]) if n == "sounds" else row[n] for n in PLACE)
            a, b = (abs(recomputed[place, row[n]]) for n in ("first", "second"))
            both = numpy.isfinite(a) & numpy.isfinite(b)
            a, b = a[both], b[both]
            self.assertEqual(int(row["pairs"]), len(a))
            if len(a) < 2:  # the room hides nearly all modes of some objects
                self.assertEqual(place[0], "noise and room")
                families.setdefault((*place[:3], place[3] == "all", *place[4:]), []).append(row)
                continue
            self.assertAlmostEqual(float(row["median_difference"]), numpy.median(a - b), 9)
            if numpy.any(a != b):
                exact = numpy.all(a != b) and len(set(abs(a - b))) == len(a) and len(a) <= 50
                wilcoxon = scipy.stats.wilcoxon(a, b, mode="exact" if exact else "approx")
                self.assertAlmostEqual(float(row["signed_rank_p"]), wilcoxon.pvalue, 7, place)
            logs = [numpy.log(numpy.maximum(x, numpy.finfo(float).eps)) for x in (a, b)]
            welch = scipy.stats.ttest_ind(*logs, equal_var=False)
            self.assertAlmostEqual(float(row["welch_p"]), welch.pvalue, 7, place)
            family = (*place[:3], place[3] == "all", *place[4:])
            families.setdefault(family, []).append(row)
        for members in families.values():
            for name in ("signed_rank_p", "welch_p"):
                ordered = sorted((row for row in members if row[name]),
                                 key=lambda row: float(row[name]))
                least = 0
                for k, row in enumerate(ordered):
                    least = max(least, min(1, (len(ordered) - k) * float(row[name])))
                    self.assertAlmostEqual(float(row[name + "_holm"]), least, 9)

    def test_true_modes_are_the_material_and_the_support(self):
        checked = 0
        for path in (self.output / "evaluation" / "features").glob("*.h5"):
            with h5py.File(path) as file:
                if not file.attrs["sounds"].startswith("truth/clean"):
                    continue
                shard = self.output / "effects=clean" / (
                    file.attrs["sounds"].split("/", 2)[2].split("+")[0] + ".h5")
                with h5py.File(shard) as stored:
                    gains = dict(zip(stored["key"].asstr()[:], stored["support_damping"][:]))
                ends = numpy.cumsum(file["features"][:])
                for key, begin, end in zip(file["key"].asstr()[:], ends - file["features"][:], ends):
                    d = file["decay_rate"][begin:end]
                    eigenvalue = (2 * numpy.pi * file["frequency"][begin:end]) ** 2 + d ** 2
                    alpha1, alpha2 = TRUTH[key.split("/")[1]]
                    gain = d - (alpha1 + alpha2 * eigenvalue) / 2
                    self.assertGreater(min(gain), -1e-9)
                    self.assertAlmostEqual(max(gain), gains[key], 9)
                    checked += 1
        self.assertEqual(checked, 30)

    def test_counts_what_was_found(self):
        counts = {}
        for path in (self.output / "evaluation" / "features").glob("*.h5"):
            with h5py.File(path) as file:
                source, condition = file.attrs["sounds"].split("/")[:2]
                counts.setdefault((condition, source), []).extend(file["features"][:])
        document = json.loads((self.output / "evaluation" / "damping.json").read_text())
        for row in document["found_features"]:
            found = counts[row["condition"], row["features"]]
            self.assertEqual(row["sounds"], len(found))
            self.assertEqual(row["median_per_sound"], numpy.median(found))
            # Features are not looked for; true modes that the room masks are there, and marked.
            masked = row["condition"] != "clean" and row["features"] == "truth"
            (self.assertGreater if masked else self.assertEqual)(row["reverberant_fraction"], 0)
        self.assertEqual(len(document["found_features"]), 4)

    def test_no_feature_decays_faster_than_its_room(self):
        checked = 0
        for path in (self.output / "evaluation" / "features").glob("*.h5"):
            with h5py.File(path) as file:
                source, condition, shard = file.attrs["sounds"].split("/", 2)
                if source != "esprit" or condition == "clean":
                    continue
                with h5py.File(self.output / "effects=noiseandroom" /
                               (shard.split("+")[0] + ".h5")) as stored:
                    rooms = dict(zip(stored["key"].asstr()[:], stored["room_rt60"][:]))
                ends = numpy.cumsum(file["features"][:])
                for key, begin, end in zip(file["key"].asstr()[:], ends - file["features"][:], ends):
                    frequency, d = file["frequency"][begin:end], file["decay_rate"][begin:end]
                    octave = numpy.clip(numpy.round(numpy.log2(frequency / 125)), 0, 7).astype(int)
                    limit = numpy.log(1000) / rooms[key][octave]
                    self.assertTrue(numpy.all(d < limit))
                    self.assertFalse(numpy.any(file["reverberant"][begin:end]))
                    checked += end - begin
        self.assertGreater(checked, 0)

    def test_a_body_that_fails_is_left_out(self):
        self.write("bad.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 0 0\n3 0 1 2\n")
        config = self.write("bad.yaml", CONFIG.replace(
            "objects:", "objects:\n  - {mesh: bad.off, length: 10 cm}"))
        output = self.folder / "bad"
        result = run("evaluate", config, "-o", output, "--json", "--set", "sweep=", "--set",
                     "effects={noise: off, room: off, tail: off}", "--set",
                     "evaluate.damping.features.extractors=truth")
        self.assertEqual(result.returncode, 3, result.stderr)
        found = json.loads(result.stdout)
        self.assertEqual(found["found_features"][0]["sounds"], 30)
        self.assertTrue(all(row["failed"] == 0 for row in found["errors"] if row["sounds"] > 1))

    def test_one_rank_finds_the_same(self):
        alone = self.folder / "alone"
        run_json("evaluate", self.config, "-o", alone)
        self.assertGreater(len(findings(alone)), 20)
        self.assertEqual(findings(alone), findings(self.output))

    def test_goes_on_after_a_kill_and_computes_nothing_twice(self):
        output = self.folder / "killed"
        features = output / "evaluation" / "features"
        process = subprocess.Popen([CARILLON, "--quiet", "evaluate", str(self.config), "-o",
                                    str(output)], stdout=subprocess.DEVNULL)
        wait_for(lambda: len(list(features.glob("[!.]*.h5"))) >= 2, 60)
        process.send_signal(signal.SIGKILL)
        process.wait()
        kept = {path: path.stat().st_mtime_ns for path in features.glob("[!.]*.h5")}
        again = run_json("evaluate", self.config, "-o", output)
        # What was written last may not have been recorded yet.
        unrecorded = again["tasks_run"]["features"] - (12 - len(kept))
        self.assertIn(unrecorded, (0, 1))
        changed = [path for path, modified in kept.items() if path.stat().st_mtime_ns != modified]
        self.assertEqual(len(changed), unrecorded)
        self.assertEqual(findings(output), findings(self.output))

    def test_goes_on_after_an_interrupt(self):
        output = self.folder / "interrupted"
        shutil.copytree(self.output, output)
        shutil.rmtree(output / "evaluation")
        # So many draws that it does not end by itself before.
        process = subprocess.Popen([CARILLON, "evaluate", str(self.config), "-o", str(output),
                                    "--set", "evaluate.damping.draws=20000"],
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        wait_for(lambda: len(list((output / "evaluation").glob("features/[!.]*.h5"))) >= 1, 60)
        process.send_signal(signal.SIGINT)
        text = process.communicate(timeout=30)[0]
        self.assertEqual(process.returncode, 130)
        self.assertIn("interrupted: run the same command to go on", text)
        run_json("evaluate", self.config, "-o", output)
        self.assertEqual(findings(output), findings(self.output))

    def test_done_is_done_and_more_draws_need_no_features(self):
        before = findings(self.output)
        again = run_json("evaluate", self.config, "-o", self.output)
        self.assertEqual(again["tasks_run"], {"features": 0, "fits": 0})
        self.assertEqual(findings(self.output), before)
        other = self.folder / "other"
        shutil.copytree(self.output, other)
        fewer = run_json("evaluate", self.config, "-o", other, "--set", "evaluate.damping.draws=4",
                         "--set", "evaluate.damping.sound_counts=[3]")
        self.assertEqual(fewer["tasks_run"], {"features": 0, "fits": 16})
        # Features that the room hides are looked for and fitted when asked for.
        kept = run_json("evaluate", self.config, "-o", other, "--set",
                        "evaluate.damping.features.reverberant=keep")
        self.assertEqual(kept["tasks_run"]["features"], 6)
        for row in kept["found_features"]:
            hidden = row["condition"] != "clean"
            (self.assertGreater if hidden else self.assertEqual)(row["reverberant_fraction"], 0)
        stored = json.loads((self.output / "evaluation" / "damping.json").read_text())
        for condition, equal in (("clean", True), ("noise and room", False)):
            medians = [[row["median"] for row in document["errors"] if row["features"] == "esprit"
                        and row["condition"] == condition] for document in (stored, kept)]
            self.assertEqual(medians[0] == medians[1], equal, condition)
        fewer = run_json("evaluate", self.config, "-o", other, "--set", "evaluate.damping.draws=4",
                         "--set", "evaluate.damping.sound_counts=[3]")
        self.assertEqual(fewer["tasks_run"], {"features": 0, "fits": 0})
        # The first draws stay what they were.
        def fits(output):
            return [row for row in rows(output / "evaluation" / "damping-fits.csv")
                    if row["sounds"] == "3" and int(row["draw"]) < 4]
        self.assertEqual(fits(other), fits(self.output))

    def test_the_rooms_likelihood_finds_more_in_rooms_and_is_esprit_without_one(self):
        output = self.folder / "likelihood"
        shutil.copytree(self.output, output)
        document = run_json("evaluate", self.config, "-o", output, "--set",
                            "evaluate.damping.features.extractors=[esprit, room_likelihood]")
        self.assertEqual(document["tasks_run"]["features"], 3)  # a shard of each object, in rooms
        count = {(row["condition"], row["features"]): row["median_per_sound"] for row in document["found_features"]}
        self.assertEqual(count["clean", "room_likelihood"], count["clean", "esprit"])
        # Medians of two or three modes are often equal; so many are there, and so fast:
        rates = {name: [] for name in ("esprit", "room_likelihood")}
        for path in output.glob("**/*.h5"):
            with h5py.File(path) as file:
                if file.attrs.get("extractor") in rates and file.attrs["sounds"].split("/")[1] == "noise and room":
                    rates[file.attrs["extractor"]] += file["decay_rate"][:].tolist()
        room_rate = numpy.log(1000) / 0.2
        self.assertGreater(len(rates["room_likelihood"]), len(rates["esprit"]))
        self.assertGreater(sum(rate > room_rate for rate in rates["room_likelihood"]), 5)
        self.assertEqual(sum(rate > room_rate for rate in rates["esprit"]), 0)
        medians = {name: [row["median"] for row in document["errors"]
                          if (row["condition"], row["features"]) == ("clean", name)]
                   for name in ("esprit", "room_likelihood")}
        self.assertEqual(medians["esprit"], medians["room_likelihood"])

    def test_a_dataset_alone_is_evaluated_and_build_and_plan_leave_it_alone(self):
        output = self.folder / "single"
        single = ("--set", "sweep=", "--set", "effects={noise: off, room: off, tail: off}")
        found = run_json("evaluate", self.config, "-o", output, *single,
                         "--set", "evaluate.damping.features.extractors=truth")
        self.assertEqual(found["conditions"], ["small"])
        built = run_json("build", self.config, "-o", output, *single)
        self.assertEqual(built["tasks_run"], 0)
        self.assertEqual(run("plan", self.config).returncode, 0)
        self.assertEqual(run("check", output).returncode, 0)

    def test_text_is_for_people(self):
        result = run("evaluate", self.config, "-o", self.output)
        self.assertEqual(result.returncode, 0)
        for words in ("noise and room, features: esprit, sounds of one object", "least_squares",
                      "5 sounds", "alpha1: emg against least_squares: ahead in",
                      "damping-errors.csv"):
            self.assertIn(words, result.stdout)

    def test_names_what_is_wrong_before_anything_is_built(self):
        line = CONFIG.split("\n").index("  damping:") + 3
        cases = {
            ("    draws: 8", "    draw: 8"):
                f'small-wrong.yaml:{line}:5: evaluate.damping.draw: unknown key; did you mean '
                '"draws"?',
            ("  damping:", "  dampings:"):
                'evaluate.dampings: unknown key; did you mean "damping"?',
            ("sound_counts: [1, 3, 5]", "sound_counts: [1, 30]"):
                "30 sounds cannot be drawn of 5, the strikes of each object",
            ("sound_counts: [1, 3, 5]\n    draws: 8\n    draws_from: [object, material]",
             "sound_counts: [1, 300]\n    draws_from: [material]"):
                "300 sounds cannot be drawn of 15, the sounds of a material",
            ("extractors: [esprit, truth]", "explained: 99.99"): "is a fraction, 1 at most",
            ("extractors: [esprit, truth]", "extractors: [espirt]"): 'unknown value "espirt"',
            ("    draws: 8", "    model: hybrid"): "one is damped by rayleigh",
        }
        for (old, new), message in cases.items():
            wrong = self.write("small-wrong.yaml", CONFIG.replace(old, new))
            result = run("evaluate", wrong, "-o", self.folder / "wrong")
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(message, result.stderr)
            self.assertFalse((self.folder / "wrong").exists())
        nothing = self.write("nothing.yaml", CONFIG[:CONFIG.index("evaluate:")])
        result = run("evaluate", nothing)
        self.assertEqual(result.returncode, 2)
        self.assertIn("evaluate: says what is to be found out, and is missing", result.stderr)
        self.write("own.yaml", OWN.replace("alpha1: 2", "alpha1: 0"))
        result = run("evaluate", self.config, "-o", self.folder / "wrong")
        self.write("own.yaml", OWN)
        self.assertEqual(result.returncode, 2)
        self.assertIn("alpha1 of two is 0", result.stderr)


if __name__ == "__main__":
    unittest.main()
