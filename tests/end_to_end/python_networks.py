"""Networks in Python: the scores of answers.h5 by NumPy and by PyTorch, from weights that any reader of
safetensors takes."""
import importlib
import importlib.util
import json
import pathlib
import unittest

import h5py
import numpy
from module_test import ModuleTest, ca
from program import run_json

models = importlib.import_module("carillon.models")  # where module_test says

CONFIG = """
name: small
seed: 3
materials: [steel, wood]
objects:
  - {shape: bar, parameters: {length: 20 cm, width: 2 cm, height: 8 mm}}
  - {shape: tile, parameters: {length: 16 cm, width: 12 cm, thickness: 6 mm}}
modes: {max_modes: 20, order: 2, element_size: 20 mm, max_frequency: 7 kHz}
strikes: {per_object: 12}
audio: {seconds: 0.5 s, sample_rate: 22050 Hz}
mel: {bands: 32, frames: 12}
voxels: {resolution: 12, fill: outer}
split: {validation: 0.2, test: 0.2}
train:
  seed: 2
  epochs: 2
  batch: 8
  tasks: {geometry: {column: shape}}
  methods:
    linear-svm-a: {}
    isnn-a: {filters: 4, units: 16, kernel: [16, 4]}
    voxnet: {units: 16}
    soundnet5: {units: 16}
    soundnet8: {units: 16}
    isnn-av-bilinear: {filters: 4, units: 16, kernel: [16, 4], fused: 8}
    multiplied: {branches: [isnn, voxnet], fusion: multiply, filters: 4, units: 16, kernel: [16, 4]}
    added: {branches: [isnn, soundnet5], fusion: add, filters: 4, units: 16, kernel: [16, 4]}
"""


class Networks(ModuleTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        config = cls.write(cls, "small.yaml", CONFIG)
        cls.output = cls.folder / "out"
        found = run_json("train", config, "-o", cls.output)
        cls.folders = {line["method"]["name"]: pathlib.Path(line["folder"]) for line in found["trainings"]}

    def answers(self, name):
        """Rows of the dataset that were tested, and what the program's scores of them are."""
        keys = list(ca.open(self.output)["key"][:])
        with h5py.File(self.folders[name] / "answers.h5") as file:
            rows = [keys.index(key) for key in file["test/key"].asstr()[:]]
            return rows, file["test/scores"][:], list(file["classes"].asstr()[:])

    def test_give_the_scores_of_the_program(self):
        by = [False] + [True] * (importlib.util.find_spec("torch") is not None)
        for name, folder in self.folders.items():
            network = models.load(folder)
            rows, expected, classes = self.answers(name)
            self.assertGreater(len(rows), 4)
            self.assertEqual(network.classes, classes)
            inputs = network.read(ca.open(self.output), rows)
            for torch in by:
                numpy.testing.assert_allclose(network.scores(*inputs, torch=torch), expected, atol=1e-4, err_msg=name)
            odds = network.probabilities(*inputs, torch=False)
            numpy.testing.assert_allclose(odds.sum(1), 1, rtol=1e-5)
            numpy.testing.assert_array_equal(odds.argmax(1), expected.argmax(1))

    def test_are_safetensors(self):
        """By the format's own description: a length, a header, values without gaps."""
        for name, folder in self.folders.items():
            data = (folder / "model.safetensors").read_bytes()
            length = int.from_bytes(data[:8], "little")
            self.assertEqual((8 + length) % 8, 0)
            header = json.loads(data[8:8 + length])
            self.assertEqual({type(value) for value in header.pop("__metadata__").values()}, {str})
            at = 0
            for entry in header.values():
                self.assertEqual(entry["dtype"], "F32")
                first, end = entry["data_offsets"]
                self.assertEqual((first, end - first), (at, 4 * int(numpy.prod(entry["shape"]))))
                at = end
            self.assertEqual(at, len(data) - 8 - length)
            training = json.loads((folder / "training.json").read_text())
            learnt = sum(int(numpy.prod(entry["shape"])) for key, entry in header.items() if "running" not in key)
            self.assertEqual(learnt, training["parameters"], name)

    def test_are_refused_where_they_are_damaged(self):
        whole = self.folders["isnn-a"] / "model.safetensors"
        data = whole.read_bytes()
        for name, changed in (("cut", data[:-4]), ("flipped", data[:-1] + bytes([data[-1] ^ 1])), ("none", data[:5])):
            path = self.folder / name
            path.write_bytes(changed)
            with self.assertRaisesRegex(ca.FileError, "cut short"):
                models.load(path)
        with self.assertRaisesRegex(ca.FileError, "evaluation/models"):
            models.load(self.folder / "nowhere")

    def test_say_what_they_take(self):
        network = models.load(self.folders["isnn-a"])
        with self.assertRaisesRegex(ca.InputError, "spectrogram"):
            network.scores(numpy.zeros((2, 3)))
        with self.assertRaisesRegex(ca.InputError, "no sample 10000"):
            network.read(self.output, [10000])
        self.assertEqual(network.scores(numpy.zeros((0, *network.inputs[0][1])), torch=False).shape, (0, 2))


if __name__ == "__main__":
    unittest.main()
