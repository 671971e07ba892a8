"""Classifiers: what `carillon train` learns and keeps, whatever was killed on the way and on however
many ranks; what it refuses."""
import csv
import json
import shutil
import signal
import subprocess
import unittest

import h5py
import numpy
from interrupted import wait_for
from program import CARILLON, FolderTest, run, run_json

CONFIG = """
name: small
seed: 3
materials: [steel, wood]
objects:
  - {shape: bar, parameters: {length: 20 cm, width: 2 cm, height: 8 mm}}
  - {shape: tile, parameters: {length: 16 cm, width: 12 cm, thickness: 6 mm}}
  - {shape: block, count: 2}
modes: {max_modes: 20, order: 2, element_size: 20 mm, max_frequency: 7 kHz}
strikes: {per_object: 25}
audio: {seconds: 0.5 s, sample_rate: 22050 Hz}
mel: {bands: 32, frames: 12}
split: {validation: 0.2, test: 0.2}
train:
  seed: 2
  epochs: 15
  batch: 16
  tasks:
    geometry: {column: shape}
    hardness: {column: material, split_column: split_strike, label_groups: {soft: [wood], hard: [steel]}}
  methods:
    nearest-neighbour-a: {}
    linear-svm-a: {}
    isnn-a: {filters: 8, units: 32, kernel: [16, 4], learning_rate: 0.003}
    both: {branches: [isnn, image], fusion: add, filters: 4, units: 16, kernel: [8, 4], learning_rate: 0.003}
camera: {width: 64, height: 64}
"""

ONE_TASK = "train.tasks={geometry: {column: shape}}"


def training(found, key):
    return next(line for line in found["trainings"] if line["key"] == key)


def answers(line):
    """Labels and scores of the part that was held out for testing."""
    with h5py.File(f"{line['folder']}/answers.h5") as file:
        test = file["test"]
        return (test["key"].asstr()[:], test["label"][:], test["scores"][:],
                file["classes"].asstr()[:])


class Train(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.write(cls, "small.yaml", CONFIG)
        cls.output = cls.folder / "out"
        cls.found = run_json("train", cls.config, "-o", cls.output, ranks=2)

    def other(self, name):
        """A copy of the dataset, and a configuration that names it."""
        copy = self.folder / name
        shutil.copytree(self.output, copy, ignore=shutil.ignore_patterns("evaluation"))
        train = CONFIG[CONFIG.index("train:"):CONFIG.index("camera:")]
        config = self.write(f"{name}.yaml", f"data: {copy}\n{train}")
        return copy, config

    def test_learns_and_answers_for_what_was_held_out(self):
        self.assertEqual(len(self.found["trainings"]), 8)
        with h5py.File(self.output / "index.h5") as file:
            split = file["split_strike"].asstr()[:]
            key = file["key"].asstr()[:]
            labels = {"geometry": file["shape"].asstr()[:],
                      "hardness": ["soft" if m == "wood" else "hard"
                                   for m in file["material"].asstr()[:]]}
        for line in self.found["trainings"]:
            task = line["task"]["name"]
            expected = {k: l for k, l, s in zip(key, labels[task], split) if s == "test"}
            keys, label, scores, classes = answers(line)
            self.assertEqual({k: classes[c] for k, c in zip(keys, label)}, expected)
            self.assertEqual(list(classes), sorted(set(labels[task])))
            self.assertAlmostEqual(line["test_accuracy"],
                                   numpy.mean(scores.argmax(1) == label), 12)
            self.assertEqual(line["samples"]["test"], len(expected))
            self.assertGreater(line["test_accuracy"], 1.2 / len(classes), line["key"])
        self.assertGreater(training(self.found, "geometry/isnn-a/seed-2")["test_accuracy"], 0.7)

    def test_keeps_curves(self):
        line = training(self.found, "geometry/isnn-a/seed-2")
        with open(f"{line['folder']}/curves.csv", newline="") as file:
            curve = list(csv.DictReader(file))
        self.assertEqual(len(curve), line["epochs"])
        self.assertEqual({row["ranks"] for row in curve}, {"2"})
        losses = [float(row["validation_loss"]) for row in curve]
        self.assertEqual(numpy.argmin(losses) + 1, line["best_epoch"])
        self.assertLess(float(curve[-1]["train_loss"]), float(curve[0]["train_loss"]))

    def test_draws_curves(self):
        evaluation = self.output / "evaluation"
        kept = json.loads((evaluation / "trainings.json").read_text())
        self.assertEqual({line["key"] for line in kept["trainings"]},
                         {line["key"] for line in self.found["trainings"]})
        self.assertTrue((evaluation / "trainings.svg").exists())

    def test_is_not_trained_twice(self):
        again = run_json("train", self.config, "-o", self.output)
        self.assertTrue(all(line["was_there"] for line in again["trainings"]))
        for line in again["trainings"]:
            self.assertEqual(line["test_accuracy"],
                             training(self.found, line["key"])["test_accuracy"])

    def test_is_the_same_on_as_many_ranks(self):
        _, config = self.other("same")
        again = run_json("train", config, "-o", self.folder / "again", "--set", ONE_TASK, ranks=2)
        for line in again["trainings"]:
            first = training(self.found, line["key"])
            numpy.testing.assert_array_equal(answers(line)[2], answers(first)[2], line["key"])

    def test_learns_from_windows_of_files(self):
        """Memory for a few samples: files are read while the ranks sum up."""
        _, config = self.other("windows")
        found = run_json("train", config, "-o", self.folder / "windows-out", "--set",
                         "train.memory=32 KiB", "--set", ONE_TASK, ranks=2)
        for line in found["trainings"]:
            first = training(self.found, line["key"])
            if "nearest" in line["key"]:
                numpy.testing.assert_array_equal(answers(line)[2], answers(first)[2], line["key"])
            if "svm" in line["key"]:  # holds all that it learns from
                self.assertIn("which fill `memory`", line["remarks"][0])
                continue
            self.assertGreater(line["test_accuracy"], first["test_accuracy"] - 0.25, line["key"])
            self.assertGreater(line["test_accuracy"], 1.2 / len(line["classes"]), line["key"])

    def test_goes_on_after_it_was_stopped_and_on_other_ranks(self):
        _, config = self.other("stopped")
        output = self.folder / "stopped-out"
        command = [CARILLON, "train", config, "-o", output, "--set", "train.epochs=150",
                   "--set", "train.patience=150", "--set", "train.tasks={a: {column: shape}}",
                   "--set", "train.methods={isnn-a: {filters: 8, units: 32, kernel: [16, 4]}}"]
        process = subprocess.Popen([*map(str, command)], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        self.assertTrue(wait_for(lambda: list(output.rglob("checkpoint")), 100))
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(60), 130)
        made = list(output.rglob("checkpoint"))
        self.assertEqual(len(made), 1)
        header = json.loads(made[0].read_bytes().split(b"\n", 1)[0])["header"]
        stopped = len(header["epochs"])
        self.assertLess(stopped, 150)
        # The patience is no part of what is kept: it is the same training with the same end.
        result = run(*command[1:], "--json", ranks=2)
        self.assertEqual(result.returncode, 0, result.stderr)
        line = json.loads(result.stdout)["trainings"][0]
        with open(f"{line['folder']}/curves.csv", newline="") as file:
            ranks = [row["ranks"] for row in csv.DictReader(file)]
        self.assertEqual(ranks[:stopped], ["1"] * stopped)
        self.assertEqual(set(ranks[stopped:]), {"2"})
        self.assertTrue(any("goes on with 2 ranks" in remark for remark in line["remarks"]))

    def test_goes_on_to_the_same_bits(self):
        """On two ranks, from windows of files, with statistics of batches and dropout."""
        _, config = self.other("same-bits")
        arguments = ["train", config, "--set", "train.epochs=4", "--set", "train.patience=4",
                     "--set", "train.memory=1 MiB", "--set", "train.tasks={a: {column: shape}}",
                     "--set", "train.methods={soundnet5: {units: 16}}"]
        whole = run_json(*arguments, "-o", self.folder / "whole", ranks=2)["trainings"][0]
        output = self.folder / "in-parts"
        process = subprocess.Popen(
            ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "2", CARILLON,
             *map(str, arguments), "-o", str(output)],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.assertTrue(wait_for(lambda: list(output.rglob("checkpoint")), 100))
        process.send_signal(signal.SIGTERM)
        process.wait(60)
        self.assertFalse(list(output.rglob("training.json")))
        line = run_json(*arguments, "-o", output, ranks=2)["trainings"][0]
        with open(f"{line['folder']}/curves.csv", newline="") as file:
            self.assertEqual(len(list(csv.DictReader(file))), whole["epochs"])
        numpy.testing.assert_array_equal(answers(line)[2], answers(whole)[2])

    def test_refuses_nan_by_the_samples_name(self):
        for ranks in (1, 2):
            copy, config = self.other(f"nan{ranks}")
            shard = sorted((copy / "samples").glob("*.h5"))[-1]
            with h5py.File(shard, "r+") as file:
                row = list(file["split_strike"].asstr()[:]).index("train")
                key = file["key"].asstr()[row]
                file["mel"][row, 3, 4] = numpy.nan
            result = run("train", config, "-o", self.folder / f"nan-out{ranks}", ranks=ranks)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(key, result.stderr)

    def test_refuses_a_split_that_leaks(self):
        copy, config = self.other("leak")
        shard = sorted((copy / "samples").glob("*.h5"))[0]
        with h5py.File(shard, "r+") as file:
            row = list(file["split_strike"].asstr()[:]).index("test")
            file["split_strike"][row] = "train"
        result = run("train", config, "-o", self.folder / "leak-out")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("leaks", result.stderr)

    def test_searches_sizes_on_the_validation_samples(self):
        search = ["--search", "--set", "search={isnn-a: {task: geometry, keys: "
                  "{filters: [4, 8], learning_rate: [0.00001, 0.003]}}}"]
        output = self.folder / "searched"
        config = self.other("search")[1]
        found = run_json("train", config, "-o", output, *search, ranks=2)["searches"][0]
        trials = found["trials"]
        self.assertEqual((found["task"], len(trials)), ("geometry", 4))
        scores = [(-trial["validation_accuracy"], trial["validation_loss"]) for trial in trials]
        self.assertEqual(scores, sorted(scores))
        self.assertEqual(trials[0]["values"]["learning_rate"], "0.003")
        self.assertFalse(any("test" in key for trial in trials for key in trial))
        again = run_json("train", config, "-o", output, *search)["searches"][0]["trials"]
        self.assertTrue(all(trial["was_there"] for trial in again))
        self.assertEqual([trial["values"] for trial in again],
                         [trial["values"] for trial in trials])
        for override, said in (("search={isnn-b: {keys: {filters: [4]}}}", "has no \"isnn-b\""),
                               ("search={isnn-a: {keys: {filter: [4]}}}", "filter"),
                               ("search={isnn-a: {task: mass, keys: {filters: [4]}}}", "mass"),
                               ("search={isnn-a: {keys: {filters: []}}}", "no values"),
                               ("search=", "names no method"),
                               ("search={isnn-a: }", "names no keys")):
            result = run("train", config, "-o", output, "--search", "--set", override)
            self.assertEqual(result.returncode, 2, override)
            self.assertIn(said, result.stderr, override)

    def test_says_what_a_dataset_lacks(self):
        _, config = self.other("lacks")
        result = run("train", config, "-o", self.folder / "lacks-out",
                     "--set", "train.methods={voxnet: {}}")
        self.assertEqual(result.returncode, 2)
        self.assertIn("has no voxels", result.stderr)
        self.assertIn("voxels: {resolution: 30}", result.stderr)

    def test_learns_with_several_convolutions(self):
        _, config = self.other("deep")
        found = run_json("train", config, "-o", self.folder / "deep-out", "--device", "cpu", "--set", ONE_TASK, "--set",
                         "train.methods={isnn-a: {filters: [8, 16], kernel: [[8, 3], [3, 3]], units: 32, "
                         "learning_rate: 0.003}}")
        line = found["trainings"][0]
        self.assertEqual([layer["filters"] for layer in line["method"]["sizes"]["layers"]], [8, 16])
        self.assertGreater(line["test_accuracy"], 0.5)
        self.assertEqual(line["device"], "cpu")

    def test_prints_balanced_accuracies_where_classes_are_unequal(self):
        _, config = self.other("unequal")
        output = self.folder / "unequal-out"
        command = ["train", config, "-o", output, "--set", "train.tasks={geometry: {column: shape, label_groups: "
                   "{bar: [bar-000], other: [tile-000, block-000, block-001]}}}", "--set",
                   "train.methods={isnn-a: {epochs: 1, filters: 1, units: 1, kernel: [4, 2], learning_rate: 0.00001}}"]
        result = run(*command)
        self.assertEqual(result.returncode, 0, result.stderr)
        line = run_json(*command)["trainings"][0]
        self.assertNotEqual(line["test_balanced_accuracy"], line["test_accuracy"])
        self.assertRegex(result.stdout, "balanced +accuracy")
        self.assertRegex(result.stdout, f"{100 * line['test_balanced_accuracy']:.2f} % +"
                                        f"{100 * line['test_accuracy']:.2f} %")

    def test_says_where_there_is_no_graphics_card(self):
        found = run_json("train", self.config, "-o", self.output, "--device", "auto")
        if any(line["device"] == "cuda" for line in found["trainings"]):
            self.skipTest("there is one")
        _, config = self.other("cuda")
        result = run("train", config, "-o", self.folder / "cuda-out", "--device", "cuda")
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, "without CUDA|no graphics card")
        self.assertIn("--device cpu", result.stderr)

    def test_says_what_is_wrong_in_a_configuration(self):
        for override, said in (("train.methods={isn-a: {}}", "no classifier is known"),
                               ("train.methods={a: {branches: [ear]}}", "unknown value"),
                               ("train.methods={a: {branches: []}}", "names nothing"),
                               ("train.tasks={a: {column: shape, split_column: split_shape}}",
                                "whole shapes are held out"),
                               ("train.tasks={a: {column: weight}}", "no column of texts"),
                               ("train.methods={isnn-a: {filters: [8, 16], kernel: [[4, 2], [3, 3], [3, 3]]}}",
                                "filters: is of 2 convolutions, and `kernel` of 3"),
                               ("train.methods={isnn-a: {kernel: [[16, 4], [3]]}}", "a list of 2 values"),
                               ("train.methods={isnn-a: {filters: [8, 1.5]}}", "a whole number, or one for each"),
                               ("train.methods={isnn-a: {filters: [8, 16], kernel: [16, 4]}}",
                                "convolution 2 of isnn needs at least 17 bands"),
                               ("train.methods={linear-svm-a: {learning_rate: 1}}", "learning_rate: unknown key"),
                               ("train.methods={linear-svm-a: {cost: 0}}", "cost"),
                               ("train.device=gpu", "device"), ("train.batch=0", "batch"), ("train.memori=1 GiB", "memory")):
            result = run("train", self.config, "-o", self.output, "--set", override)
            self.assertEqual(result.returncode, 2, override)
            self.assertIn(said, result.stderr, override)


if __name__ == "__main__":
    unittest.main()
