"""`carillon identify` on sounds that were held out and on others; scenes with what was heard; sounds
of one's own as training data."""
import unittest
import wave

import h5py
import numpy
from program import CONFIGS, FolderTest, run, run_json

CONFIG = """
name: heard
seed: 4
materials: [steel, wood]
objects:
  - {shape: bar, count: 2}
  - {shape: tile, count: 2}
  - {shape: block, count: 2}
modes: {max_modes: 20, order: 2, element_size: 20 mm, max_frequency: 9 kHz}
strikes: {per_object: 30}
audio: {seconds: 0.5 s, sample_rate: 22050 Hz}
mel: {bands: 32, frames: 12}
split: {validation: 0.2, test: 0.2}
train:
  epochs: 30
  batch: 16
  tasks:
    which: {column: shape}
    some: {column: shape, except: {family: [block]}}
    kind: {column: family, split_column: split_strike, except: [block]}
    material: {column: material, split_column: split_strike}
  methods:
    isnn-a: {filters: 8, units: 32, kernel: [16, 4], learning_rate: 0.003}
"""


def write_wav(path, samples, rate=22050):
    path.parent.mkdir(parents=True, exist_ok=True)
    scaled = samples / (numpy.abs(samples).max() or 1) * 0.9
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((scaled * 32767).astype("<i2").tobytes())


class Identify(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        config = cls.write(cls, "heard.yaml", CONFIG)
        cls.output = cls.folder / "out"
        cls.found = run_json("train", config, "-o", cls.output, ranks=2)
        cls.models = cls.output / "evaluation" / "models"
        with h5py.File(cls.output / "index.h5") as file:
            cls.shape = file["shape"].asstr()[:]
            cls.family = file["family"].asstr()[:]
            cls.material = file["material"].asstr()[:]
            cls.test = numpy.flatnonzero(file["split_strike"].asstr()[:] == "test")
            cls.audio = file["audio"][:]
        rng = numpy.random.default_rng(1)
        cls.noise = cls.folder / "noise.wav"
        write_wav(cls.noise, rng.standard_normal(22050))
        cls.clips = []
        for row in cls.test[:24]:
            path = cls.folder / "clips" / f"{row}.wav"
            # Recordings begin before the strike, in other formats.
            write_wav(path, numpy.concatenate([numpy.zeros(3000), cls.audio[row]]))
            cls.clips.append(path)

    def identify(self, *arguments):
        return run_json("identify", *arguments, "--models", self.output)

    def test_hears_what_was_held_out(self):
        clips = self.identify(*self.clips)["clips"]
        self.assertEqual([clip["file"] for clip in clips], [str(path) for path in self.clips])
        right = {"which": 0, "material": 0}
        known = 0
        for clip, row in zip(clips, self.test):
            tasks = clip["tasks"]
            self.assertEqual(set(tasks), {"which", "some", "kind", "material"})
            for task, truth in (("which", self.shape), ("material", self.material)):
                right[task] += tasks[task]["class"] == truth[row]
                known += tasks[task]["known"]
            for task in tasks.values():
                self.assertTrue(task["knows_of_others"])
                self.assertAlmostEqual(sum(task["classes"].values()), 1, 9)
                self.assertEqual(max(task["classes"], key=task["classes"].get), task["class"])
                self.assertEqual(task["classes"][task["class"]], task["confidence"])
        line = next(line for line in self.found["trainings"] if line["task"]["name"] == "which")
        self.assertGreater(right["which"] / len(clips), line["test_accuracy"] - 0.2)
        self.assertGreater(right["material"] / len(clips), 0.85)
        self.assertGreater(known / (2 * len(clips)), 0.7)

    def test_noise_and_silence_are_none_of_these(self):
        silence = self.folder / "silence.wav"
        write_wav(silence, numpy.zeros(22050))
        for clip in self.identify(self.noise, silence)["clips"]:
            self.assertFalse(any(task["known"] for task in clip["tasks"].values()), clip["file"])
        result = run("identify", self.noise, "-m", self.models)
        self.assertEqual(result.stdout.count("none of these"), 4, result.stdout)
        result = run("identify", self.noise, "-m", self.models, "--task", "which", "kind")
        self.assertEqual(result.stdout.count("none of these"), 2, result.stdout)

    def test_trainings_tell_how_sure_they_are(self):
        for line in self.found["trainings"]:
            trial = line["recognition"]
            self.assertLess(trial["calibration_error"], 0.2)  # some 70 samples
            kinds = {"white", "pink", "brown", "hum", "babble"}
            left_out = {"left_out"} if line["task"]["name"] in ("some", "kind") else set()
            self.assertEqual(set(trial["unknown"]), kinds | left_out)
            areas = {name: trial["unknown"][name]["auroc"] for name in kinds}
            self.assertGreater(min(areas.values()), 0.75, (line["key"], areas))
            self.assertGreater(sum(areas.values()) / len(areas), 0.9, (line["key"], areas))
        kind = next(line for line in self.found["trainings"] if line["task"]["name"] == "kind")
        self.assertEqual(kind["classes"], ["bar", "tile"])
        self.assertEqual(kind["recognition"]["unknown"]["left_out"]["sounds"],
                         sum(self.family == "block"))

    def test_puts_what_it_heard_into_a_scene(self):
        scene = CONFIGS / "dominoes.yaml"
        longer = self.folder / "longer.yaml"
        clip = self.clips[0]
        heard = run_json("identify", clip, "-m", self.models, "--scene", scene, "--at",
                         "0.1 m,-5 cm,0.2 m", "--output", longer)["clips"][0]["tasks"]
        before, after = scene.read_text().splitlines(), longer.read_text().splitlines()
        added = [line for line in after if line not in before]
        self.assertEqual(len(added), 2, added)
        self.assertEqual([line for line in after if line in before], before)
        self.assertIn(f"name: recognised-{heard['which']['class']}", added[0])
        self.assertIn(heard["material"]["class"], added[0])
        self.assertIn("at: [0.1, -0.05, 0.2]", added[1])
        plan = run("plan", longer)
        self.assertEqual(plan.returncode, 0, plan.stderr)
        again = run("identify", clip, "-m", self.models, "--scene", longer, "--at", "0,0,1")
        self.assertEqual(again.returncode, 2)
        self.assertIn("already", again.stderr)
        # What the network of all shapes refuses, one that knows fewer does not put in.
        unsure = [clip["file"] for clip in self.identify(*self.clips)["clips"]
                  if not clip["tasks"]["which"]["known"]]
        for clip in [self.noise, *unsure[:3]]:
            refused = run("identify", clip, "-m", self.models, "--task", "which", "some",
                          "material", "--scene", longer, "--at", "0,0,1")
            self.assertEqual(refused.returncode, 2)
            self.assertIn("the shape is none of those", refused.stderr)

    def test_says_what_is_wrong(self):
        for arguments, said in (
                ((self.noise, "-m", self.folder / "clips"), "no trained network"),
                ((self.noise, "-m", self.models, "--method", "voxnet"), "voxnet"),
                ((self.noise, "-m", self.models, "--task", "size"), "of the task size"),
                ((self.folder / "none.wav", "-m", self.models), "none.wav"),
                ((self.noise, "-m", self.models, "--at", "0,0,1"), "--scene"),
                ((self.noise, "-m", self.models, "--scene", CONFIGS / "dominoes.yaml", "--at",
                  "1,2"), "2 values instead of three")):
            result = run("identify", *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(said, result.stderr)
        broken = self.folder / "broken"
        (broken / "a").mkdir(parents=True)
        source = next(self.models.rglob("recognition")).parent
        for name in ("training.json", "model", "recognition"):
            (broken / "a" / name).write_bytes((source / name).read_bytes())
        recognition = broken / "a" / "recognition"
        recognition.write_bytes(recognition.read_bytes()[:-100])
        result = run("identify", self.noise, "-m", broken)
        self.assertEqual(result.returncode, 2)
        self.assertIn("cut short", result.stderr)

    def test_sounds_of_ones_own_train_and_are_evaluated(self):
        # Blocks have few modes: their sounds are alike, and those are kept in one part.
        for row in numpy.flatnonzero(self.family != "block"):
            write_wav(self.folder / "own" / self.material[row] /
                      f"{self.shape[row]}_{row}.wav", self.audio[row])
        config = self.write("own.yaml", """
name: own
recordings: {folder: own, names: "{material}/{shape}_*.wav", seconds: 0.5 s, sample_rate: 22050 Hz,
             split: {validation: 0.2, test: 0.2}}
train:
  epochs: 30
  batch: 16
  tasks: {material: {column: material, split_column: split_strike}}
  methods:
    nearest-neighbour-a: {}
    isnn-a: {filters: 8, units: 32, kernel: [16, 4], learning_rate: 0.003}
evaluate: {classification: {}}
""")
        found = run_json("evaluate", config, "-o", self.folder / "own-out", ranks=2)
        for line in found["rows"]:
            self.assertGreater(line["accuracy"]["mean"], 0.85, line["method"])
            self.assertGreater(line["samples"], 25)
        clip = run_json("identify", self.clips[0], "-m", self.folder / "own-out")["clips"][0]
        self.assertEqual(clip["tasks"]["material"]["class"], self.material[self.test[0]])
        self.assertNotEqual(self.family[self.test[0]], "block")
        refused = run("identify", self.clips[0], "-m", self.folder / "own-out", "--scene",
                      CONFIGS / "dominoes.yaml", "--at", "0,0,1")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("no network tells the shape", refused.stderr)
        # The dataset beside them, as one set; what both have, in one part.
        both = ["--set", f"train.with={{data: {self.output}, name: made}}", "--set",
                "train.tasks={origin: {column: dataset, split_column: split_strike}}"]
        joined = run_json("evaluate", config, "-o", self.folder / "both-out", *both)["rows"]
        self.assertEqual({line["dataset"] for line in joined}, {"joined"})
        self.assertEqual(joined[0]["classes"], ["made", "own"])
        self.assertEqual(len(joined[0]["recalls"]), 2)
        voxels = run("train", config, "-o", self.folder / "own-out", "--set",
                     "train.methods={voxnet: {}}")
        self.assertEqual(voxels.returncode, 2)
        self.assertIn("has no voxels", voxels.stderr)


if __name__ == "__main__":
    unittest.main()
