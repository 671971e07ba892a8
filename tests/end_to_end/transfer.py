"""Classifiers that learn in one condition and are tested in another: `evaluate.transfer`; and what
spectrograms differ by: `evaluate.spectrograms`."""
import json
import pathlib
import unittest

import h5py
import numpy
from browser import expect_report
from estimate import write_wav
from program import FolderTest, run, run_json
from scipy.signal import correlate2d

CONFIG = """
name: elsewhere
seed: 4
materials: [steel, wood]
objects:
  - {shape: bar, count: 2}
  - {shape: tile, count: 2}
modes: {max_modes: 20, order: 2, element_size: 20 mm, max_frequency: 9 kHz}
strikes: {per_object: 25}
audio: {seconds: 0.4 s, sample_rate: 22050 Hz}
mel: {bands: 32, frames: 12}
split: {validation: 0.2, test: 0.2}
sweep:
  keys:
    effects:
      named:
        clean: {noise: "off"}
        noisy: {noise: auto}
noise: {kind: [white], snr: [0 dB, 6 dB]}
train:
  epochs: 40
  batch: 16
  tasks:
    object: {column: shape}
  methods:
    nearest-neighbour-a: {}
    isnn-a: {filters: 8, units: 32, kernel: [16, 4], learning_rate: 0.003}
evaluate:
  transfer: {target_dataset: noisy, mixes: {mixed_with: clean, fractions: [0, 0.25, 1]}}
  spectrograms: {max_sounds: 60}
"""


def read_safetensors(path):
    data = path.read_bytes()
    begin = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:begin])
    table = json.loads(header.pop("__metadata__")["carillon"])
    return table, {name: numpy.frombuffer(
        data[begin + one["data_offsets"][0]:begin + one["data_offsets"][1]],
        "float32").reshape(one["shape"]) for name, one in header.items()}


class Transfer(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.write(cls, "elsewhere.yaml", CONFIG)
        cls.output = cls.folder / "out"
        both = run_json("evaluate", cls.config, "-o", cls.output, ranks=2)
        cls.found, cls.spectrograms = both["transfer"], both["spectrograms"]

    def row(self, trained_on, fraction=None):
        return next(row for row in self.found["rows"] if row["trained_on"] == trained_on
                    and fraction in (None, row["fraction"]))

    def test_its_report(self):
        expect_report(self, self.output, ["sweep-0", "transfer-0"])

    def test_another_condition_is_harder_than_ones_own(self):
        row = self.row("clean")
        self.assertEqual(row["method"], "isnn-a")
        self.assertGreater(row["own"]["mean"], row["target"]["mean"] + 0.1)
        self.assertGreater(row["confusion_norm"], 0.1)
        self.assertEqual(row["compared_classes"], 4)
        self.assertGreater(row["sample_s"], 0)
        heard = row["heard"]
        self.assertEqual(heard["sounds"], 24)
        # Noise moves no pitch, and drowns what is soft.
        self.assertLess(heard["pitch_jnd"], 1)
        self.assertTrue(0.1 < heard["loudness_fraction"] < 1.42, heard)
        less = row["less_home"]
        home = self.row("noisy")
        self.assertEqual((home["kind"], home["fraction"], home["own"]), ("target", 1, None))
        self.assertGreater(home["sample_s"], 0)
        self.assertAlmostEqual(less["mean"], row["target"]["mean"] - home["target"]["mean"], 12)
        low, high = less["interval95"]
        self.assertLess(low, less["mean"])
        self.assertLess(less["mean"], high)
        self.assertEqual((self.found["against"], row["gain"]), ("clean", None))
        self.assertAlmostEqual(home["gain"]["mean"], -less["mean"], 12)
        # Beyond what chance makes of as few sounds.
        self.assertGreater(row["confusion_norm"], row["norm_by_chance"]["max"])
        self.assertLess(row["norm_by_chance"]["mean"], row["norm_by_chance"]["max"])

    def test_classes_count_alike_and_what_is_of_none_is_told(self):
        for row in self.found["rows"]:
            counts = row["target_confusion"]
            self.assertEqual(len(counts), len(row["classes"]))
            recalls = [of_class[c] / sum(of_class) for c, of_class in enumerate(counts) if sum(of_class)]
            self.assertAlmostEqual(row["target_balanced"]["mean"], sum(recalls) / len(recalls), 12)
            right = sum(of_class[c] for c, of_class in enumerate(counts)) / sum(map(sum, counts))
            self.assertAlmostEqual(row["target"]["mean"], right, 12)
            self.assertTrue(0 <= row["target_unknown"] <= 1)
        # A network that learnt without noise is not sure in noise.
        self.assertGreater(self.row("clean")["target_unknown"], self.row("noisy")["target_unknown"])

    def test_mixes_have_one_size_and_the_same_test(self):
        alone = [row for row in self.found["rows"] if row["trained_on"] == "target alone"]
        mixed = [row for row in self.found["rows"] if row["trained_on"] == "mixed"]
        self.assertEqual([row["fraction"] for row in alone], [0.25, 1])
        self.assertEqual([row["fraction"] for row in mixed], [0, 0.25])
        size = alone[1]["samples"]
        self.assertEqual({row["samples"] for row in mixed}, {size})
        self.assertEqual(alone[0]["samples"], round(size / 4))
        for row in alone + mixed:
            self.assertIsNone(row["own"])
        home = self.row("noisy")["target"]
        self.assertEqual(alone[1]["target"], home)  # learnt once
        self.assertIsNone(alone[1]["less_home"])    # of itself
        # As many steps, and no strike twice.
        records = {}
        for path in (self.output / "evaluation" / "transfer").rglob("training.json"):
            record = json.loads(path.read_text())
            records[record["key"].rsplit("/", 2)[0]] = (record, path.parent)
        self.assertEqual(records["25 % target alone"][0]["method"]["learning"]["epochs"], 160)
        self.assertEqual(records["25 % mixed"][0]["method"]["learning"]["epochs"], 40)
        # Where few are its own, others beside them help.
        self.assertGreater(mixed[1]["target"]["mean"], alone[0]["target"]["mean"] + 0.05)

    def test_answers_are_of_the_targets_own_test_samples(self):
        with h5py.File(next(self.output.glob("*noisy*/index.h5"))) as file:
            test = set(file["key"].asstr()[:][file["split_strike"].asstr()[:] == "test"])
        files = list((self.output / "evaluation" / "transfer").rglob("answers.h5"))
        self.assertEqual(len(files), 5)
        for path in files:
            with h5py.File(path) as file:
                keys = file["test"]["key"].asstr()[:]
            self.assertEqual({key[2:] for key in keys if key.startswith("1:")}, test)

    def test_files_and_pictures(self):
        folder = pathlib.Path(self.found["output"])
        for name in ("transfer.json", "transfer.md", "transfer.png", "spectrograms.json",
                     "spectrograms.png"):
            self.assertTrue((folder / name).exists(), name)
        text = (folder / "transfer.md").read_text()
        self.assertIn("clean", text)
        self.assertIn("25 %", text)
        self.assertIn("to a listener", text)

    def test_components_are_those_of_the_spectrograms(self):
        names = [dataset["name"] for dataset in self.spectrograms["datasets"]]
        self.assertEqual(names, ["clean", "noisy"])
        found = self.spectrograms["datasets"][0]["components"]
        with h5py.File(next(self.output.glob("*clean*/index.h5"))) as file:
            keys = list(file["key"].asstr()[:])
            rows = [keys.index(key) for key in found["keys"]]
            self.assertEqual(len(set(rows)), 60)
            mel = file["mel"][:][rows].astype(float).reshape(60, -1)
            material = file["material"].asstr()[:][rows]
        self.assertEqual(found["labels"], list(material))
        decibels = 10 * numpy.log10(numpy.maximum(mel / mel.max(1, keepdims=True), 1e-30))
        values = numpy.maximum(0, 1 + decibels / 60)
        values -= values.mean(0)
        strengths = numpy.linalg.svd(values, compute_uv=False) ** 2
        for k in range(2):
            component = found["components"][k]
            self.assertAlmostEqual(component["fraction"], strengths[k] / strengths.sum(), 4)
            picture = numpy.array(component["picture"]).ravel()
            along = values @ picture
            numpy.testing.assert_allclose(along, component["coordinates"], atol=0.02)

    def test_activations_are_the_convolution_of_the_sound(self):
        for dataset in self.spectrograms["datasets"]:
            self.assertEqual(len(dataset["band_hz"]), 32)
            # Frames of 0.4 s, the first about its first sample.
            self.assertEqual(len(dataset["frame_s"]), 12)
            self.assertEqual(dataset["frame_s"][0], 0)
            self.assertTrue(0.35 < dataset["frame_s"][-1] <= 0.4)
            found = dataset["activations"]
            sound = numpy.array(found["spectrogram"])
            path = next(self.output.glob(f"evaluation/models/*{dataset['name']}*/"
                                         "*/isnn-a/*/model.safetensors"))
            table, weights = read_safetensors(path)
            layer = next(layer for layer in table["branches"][0] if "weight" in layer)
            weight, bias = weights[layer["weight"]], weights[layer["bias"]]
            self.assertGreater(len(found["filters"]), 1)
            for one in found["filters"]:
                kernel = weight[one["filter"], 0]
                expected = correlate2d(sound, kernel, mode="valid") + bias[one["filter"]]
                numpy.testing.assert_allclose(one["picture"], numpy.maximum(expected, 0),
                                              atol=0.01)

    def test_excites_its_class(self):
        for dataset in self.spectrograms["datasets"]:
            self.assertEqual(len(dataset["exciting"]), 4)
            pictures = [numpy.array(one["picture"]) for one in dataset["exciting"]]
            for picture in pictures:
                self.assertEqual(picture.shape, (32, 12))
                # As strong as the sounds are, but for what the range from 0 to 1 takes away.
                fraction = (picture ** 2).mean() / dataset["components"]["mean_square"]
                self.assertTrue(0.5 < fraction < 1.01, fraction)
            self.assertGreater(numpy.abs(pictures[0] - pictures[3]).max(), 0.2)

    def test_a_target_from_elsewhere(self):
        clean, noisy = (next(self.output.glob(f"*{name}*/index.h5")).parent
                        for name in ("clean", "noisy"))
        train = CONFIG[CONFIG.index("train:"):CONFIG.index("evaluate:")]
        config = self.write("given.yaml", f"data: {clean}\n{train}evaluate:\n"
                            f"  transfer: {{data: {noisy}}}\n")
        found = run_json("evaluate", config, "-o", self.folder / "given")
        home, row = found["rows"]
        self.assertEqual((home["kind"], row["kind"]), ("target", "elsewhere"))
        self.assertEqual((row["trained_on"], found["target"]), ("given", "target"))
        self.assertGreater(row["own"]["mean"], row["target"]["mean"])

    def test_recordings_are_tested_whole(self):
        clean, noisy = (next(self.output.glob(f"*{name}*/index.h5")) for name in ("clean", "noisy"))
        with h5py.File(noisy) as file:
            shapes, clips = file["shape"].asstr()[:], file["audio"][:60]
            rate = int(file.attrs["sample_rate_hz"])
        for number, clip in enumerate(clips):
            path = self.folder / "recorded" / f"{shapes[number]}_{number}.wav"
            path.parent.mkdir(exist_ok=True)
            write_wav(path, rate, 0.9 * clip / abs(clip).max())
        train = CONFIG[CONFIG.index("train:"):CONFIG.index("evaluate:")]
        config = self.write("recorded.yaml", f"data: {clean.parent}\n{train}evaluate:\n  transfer: "
                            "{recordings: {folder: recorded, names: \"{shape}_*\"}}\n")
        found = run_json("evaluate", config, "-o", self.folder / "heard-in", "--set",
                         "train.epochs=2")
        (row,) = found["rows"]
        self.assertEqual((row["kind"], row["less_home"]), ("elsewhere", None))
        (path,) = (self.folder / "heard-in").rglob("answers.h5")
        with h5py.File(path) as file:
            keys = file["test"]["key"].asstr()[:]
        self.assertEqual(sum(key.startswith("1:") for key in keys), 60)

    def test_says_what_is_wrong_in_a_configuration(self):
        for override, said in (
                ("evaluate={transfer: {target_dataset: loud}}", "no dataset \"loud\""),
                ("evaluate={transfer: {target_dataset: noisy, methods: [voxnet]}}", "has no \"voxnet\""),
                ("evaluate={transfer: {target_dataset: noisy, mixes: {mixed_with: noisy}}}", "with itself"),
                ("evaluate={transfer: {target_dataset: noisy, against: noisy}}", "less_home"),
                ("evaluate={transfer: {target_dataset: noisy, mixes: {mixed_with: clean, fractions: [2]}}}",
                 "fractions"),
                ("evaluate={spectrograms: {method: nearest-neighbour-a}}", "method"),
                ("evaluate={spectrograms: {max_sounds: 1}}", "sounds")):
            result = run("evaluate", self.config, "-o", self.output, "--set", override)
            self.assertEqual(result.returncode, 2, override)
            self.assertIn(said, result.stderr, override)
        joined = run("evaluate", self.config, "-o", self.output, "--set", "train.join=true", "--set",
                     "evaluate={transfer: {target_dataset: noisy}}")
        self.assertEqual(joined.returncode, 2)
        self.assertIn("none is left", joined.stderr)


if __name__ == "__main__":
    unittest.main()
