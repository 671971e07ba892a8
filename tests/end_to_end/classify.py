"""What `carillon evaluate` finds out about classifiers: accuracies, intervals and confusions, held
against what the classifiers answered."""
import csv
import json
import unittest

import h5py
import numpy
from browser import expect_report
from program import CONFIGS, FolderTest, long, pictures, processor_seconds, run, run_json

CONFIG = """
name: told-apart
seed: 4
materials: [steel, wood]
objects:
  - {shape: bar, count: 5}
  - {shape: tile, count: 5}
modes: {max_modes: 20, order: 2, element_size: 20 mm, max_frequency: 7 kHz}
strikes: {per_object: 10}
audio: {seconds: 0.4 s, sample_rate: 22050 Hz}
mel: {bands: 32, frames: 12}
split: {validation: 0.2, test: 0.35}
train:
  epochs: 40
  batch: 16
  tasks:
    geometry: {column: family, split_column: split_strike}
    hardness: {column: material, split_column: split_shape}
  methods:
    nearest-neighbour-a: {}
    isnn-a: {filters: 8, units: 32, kernel: [16, 4], learning_rate: 0.003}
evaluate:
  classification: {seeds: [4, 5], published: {geometry: mn10o-geometry}}
"""


def answers(path):
    with h5py.File(path) as file:
        test = file["test"]
        return test["label"][:], test["scores"][:].argmax(1), test["object"][:]


def row(found, task, method, dataset=None):
    return next(row for row in found["rows"] if row["task"] == task and row["method"] == method
                and dataset in (None, row["dataset"]))


class Classify(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.write(cls, "apart.yaml", CONFIG)
        cls.output = cls.folder / "out"
        cls.found = run_json("evaluate", cls.config, "-o", cls.output, ranks=2)
        cls.evaluation = cls.output / "evaluation"

    def test_counts_what_was_answered(self):
        self.assertEqual(self.found["trained"], 6)  # neighbours know no seed
        for task in ("geometry", "hardness"):
            for method, seeds in (("nearest-neighbour-a", 1), ("isnn-a", 2)):
                line = row(self.found, task, method)
                files = sorted((self.evaluation / "models" / task / method).rglob("answers.h5"))
                self.assertEqual((len(files), len(line["seeds"])), (seeds, seeds))
                told = [answers(file) for file in files]
                fractions = [numpy.mean(truth == taken) for truth, taken, _ in told]
                self.assertAlmostEqual(line["accuracy"]["mean"], numpy.mean(fractions), 12)
                if seeds > 1:
                    self.assertAlmostEqual(line["accuracy"]["deviation"],
                                           numpy.std(fractions, ddof=1), 12)
                counts = numpy.zeros((2, 2), int)
                balanced = []
                for truth, taken, _ in told:
                    one = numpy.zeros((2, 2), int)
                    numpy.add.at(one, (truth, taken), 1)
                    balanced.append(numpy.mean(numpy.diag(one) / one.sum(1)))
                    counts += one
                self.assertEqual(line["confusion"], counts.tolist())
                numpy.testing.assert_allclose(line["recalls"], numpy.diag(counts) / counts.sum(1))
                self.assertAlmostEqual(line["balanced_accuracy"]["mean"], numpy.mean(balanced), 12)
                for name in ("accuracy", "balanced_accuracy"):
                    low, high = line[name]["interval95"]
                    self.assertLessEqual(0, low)
                    self.assertLessEqual(low, line[name]["mean"])
                    self.assertLessEqual(line[name]["mean"], high)
                    self.assertLessEqual(high, 1)

    def test_its_report(self):
        expect_report(self, self.output, ["accuracy", "classification-0"])

    def test_groups_are_what_was_held_out(self):
        geometry, hardness = (row(self.found, task, "isnn-a") for task in ("geometry", "hardness"))
        self.assertEqual(geometry["groups"] * 2, geometry["samples"])  # a strike in two materials
        self.assertEqual(hardness["groups"] * 20, hardness["samples"])
        # Few objects say less than many strikes.
        self.assertLess(hardness["groups"], 10)

    def test_rows_are_held_against_the_chosen_one_on_the_same_samples(self):
        for task in ("geometry", "hardness"):
            rows = [line for line in self.found["rows"] if line["task"] == task]
            (chosen,) = (line for line in rows if line["chosen"])
            self.assertEqual(chosen["validation_accuracy"],
                             max(line["validation_accuracy"] for line in rows))
            self.assertIsNone(chosen["difference"])
            (other,) = (line for line in rows if not line["chosen"])
            self.assertEqual(other["difference"]["from"], chosen["method"])
            self.assertAlmostEqual(other["difference"]["mean"],
                                   other["accuracy"]["mean"] - chosen["accuracy"]["mean"], 12)

    def test_says_how_sure_those_are_that_only_hear(self):
        for task in ("geometry", "hardness"):
            self.assertIsNone(row(self.found, task, "nearest-neighbour-a")["recognition"])
            told = row(self.found, task, "isnn-a")["recognition"]
            files = (self.evaluation / "models" / task / "isnn-a").rglob("training.json")
            seeds = [json.loads(file.read_text())["recognition"] for file in files]
            self.assertAlmostEqual(told["calibration_error"],
                                   numpy.mean([one["calibration_error"] for one in seeds]), 12)
            for kind, unknown in told["unknown"].items():
                areas = [one["unknown"][kind]["auroc"] for one in seeds]
                self.assertAlmostEqual(unknown["auroc"], numpy.mean(areas), 12)
                low, high = unknown["auroc95"]
                self.assertLessEqual(low, min(areas))
                self.assertGreaterEqual(high, max(areas))

    def test_learns(self):
        self.assertGreater(row(self.found, "geometry", "isnn-a")["accuracy"]["mean"], 0.6)
        self.assertGreater(row(self.found, "hardness", "isnn-a")["accuracy"]["mean"], 0.8)

    def test_tables(self):
        text = (self.evaluation / "classification.md").read_text()
        for said in ("geometry of told-apart", "43.35", "split_shape", "objects", "VGG16"):
            self.assertIn(said, text)
        with open(self.evaluation / "classification.csv", newline="") as file:
            lines = list(csv.DictReader(file))
        self.assertEqual(len(lines), 4)
        for line in lines:
            kept = row(self.found, line["task"], line["method"])
            self.assertAlmostEqual(float(line["accuracy"]), kept["accuracy"]["mean"], 9)
            theirs = kept["published"]
            self.assertEqual(line["published_set"], theirs["set"] if theirs else "")
        self.assertEqual(row(self.found, "geometry", "isnn-a")["published"],
                         {"set": "mn10o-geometry", "accuracy": 0.4335})
        self.assertTrue((self.evaluation / "classification.png").exists())

    def test_nothing_is_trained_twice(self):
        again = run_json("evaluate", self.config, "-o", self.output)
        self.assertEqual(again["trained"], 0)
        self.assertEqual(again["rows"], self.found["rows"])

    def test_a_dataset_that_is_there(self):
        train = CONFIG[CONFIG.index("train:"):]
        config = self.write("there.yaml", f"data: {self.output}\n{train}")
        found = run_json("evaluate", config, "-o", self.folder / "there",
                         "--set", "train.methods={nearest-neighbour-a: {}}")
        for task in ("geometry", "hardness"):
            self.assertEqual(row(found, task, "nearest-neighbour-a")["confusion"],
                             row(self.found, task, "nearest-neighbour-a")["confusion"])
        result = run("evaluate", config, "-o", self.folder / "there",
                     "--set", "evaluate={damping: {}}")
        self.assertEqual(result.returncode, 2)
        self.assertIn("is not known", result.stderr)

    def test_datasets_of_a_sweep(self):
        train = CONFIG.replace("count: 5", "count: 2").replace("  - {shape: tile, count: 2}\n",
                                                              "  - {shape: tile, count: 2}\nsweep:\n  mode: grid\n  keys: {strikes.per_object: [10, 12]}\n")
        train = train.replace("published: {geometry: mn10o-geometry}",
                              "published: {geometry: {\"10\": mn10o-geometry}}")
        config = self.write("sweep.yaml", train)
        found = run_json("evaluate", config, "-o", self.folder / "sweep",
                         "--set", "train.methods={nearest-neighbour-a: {}}", "--set",
                         "train.tasks={geometry: {column: family, split_column: split_strike}}", ranks=2)
        self.assertEqual([line["dataset"] for line in found["rows"]], ["10", "12"])
        self.assertEqual([line["published"] is not None for line in found["rows"]], [True, False])
        for line in found["rows"]:
            self.assertEqual(line["accuracy"]["deviation"], None)
        joined = run_json("evaluate", config, "-o", self.folder / "sweep", *(
            "--set", "train.methods={nearest-neighbour-a: {}}", "--set", "train.join=true", "--set",
            "evaluate.classification.published={}", "--set",
            "train.tasks={geometry: {column: family, split_column: split_strike},"
            " which: {column: dataset, split_column: split_strike}}"))
        self.assertEqual([line["dataset"] for line in joined["rows"]], ["joined", "joined"])
        self.assertEqual(joined["rows"][0]["samples"],
                         sum(line["samples"] for line in found["rows"]))
        self.assertEqual(joined["rows"][1]["classes"], ["10", "12"])

    def test_says_what_is_wrong_in_a_configuration(self):
        for override, said in (
                ("evaluate.classification.seeds=[1, 1]", "stands here twice"),
                ("evaluate.classification.seeds=[1.5]", "no whole number"),
                ("evaluate.classification.published={geometry: mn11}", "published"),
                ("evaluate.classification.published={weight: mn10o-geometry}", "has no \"weight\""),
                ("evaluate.classification.sets=2", "sets"),
                ("train.methods={voxnet: {dropout: 0.1}}", "dropout"),
                ("train.methods={isnn-a: {fused: 8}}", "fused"),
                ("evaluate.classify={}", "classify")):
            result = run("evaluate", self.config, "-o", self.output, "--set", override)
            self.assertEqual(result.returncode, 2, override)
            self.assertIn(said, result.stderr, override)


@long
@pictures
class SmokeConfig(FolderTest):
    def test_evaluates_in_a_minute(self):
        before = processor_seconds()
        found = run_json("evaluate", CONFIGS / "learning-smoke.yaml", "-o", self.folder / "out",
                         ranks=2)
        # Of each rank: 40 s on an idle machine; a neighbour on the same core makes them longer.
        self.assertLess((processor_seconds() - before) / 2, 90)
        least = {"geometry": {"nearest-neighbour-a": 0.6, "linear-svm-a": 0.3, "isnn-a": 0.6,
                              "isnn-av-bilinear": 0.6},
                 "material": {"nearest-neighbour-a": 0.6, "linear-svm-a": 0.4, "isnn-a": 0.7,
                              "isnn-av-bilinear": 0.4}}
        self.assertEqual(len(found["rows"]), 8)
        for line in found["rows"]:
            self.assertGreater(line["accuracy"]["mean"], least[line["task"]][line["method"]],
                               (line["task"], line["method"]))


if __name__ == "__main__":
    unittest.main()
