"""`carillon score`: anyone's answers for a dataset's test samples, and exports without their labels."""
import collections
import csv
import json
import random
import stat
import sys
import unittest

import h5py
import numpy
from browser import expect_report
from program import CONFIGS, FolderTest, run, run_json

CONFIG = """
name: small
seed: 4
materials: [steel, wood, glass]
objects:
  - {shape: bar, count: 8}
  - {shape: tile, count: 8}
modes: {max_modes: 10, order: 2, element_size: 20 mm, max_frequency: 12 kHz}
strikes: {per_object: 2}
audio: {seconds: 0.1 s, sample_rate: 22050 Hz, gain: 100}
mel: {bands: 16, frames: 5}
split: {validation: 0.2, test: 0.4}
"""
CLASSES = ["glass", "steel", "wood"]


def written(path, header, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    return path


class Score(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.folder / "small.yaml").write_text(CONFIG)
        assert run("build", "small.yaml", cwd=cls.folder).returncode == 0
        with h5py.File(cls.folder / "small/index.h5") as index:
            columns = ["key", "material", "shape", "split_shape"]
            rows = list(zip(*(index[name].asstr()[:] for name in columns)))
            alphas = numpy.stack([index["alpha1"][:], index["alpha2"][:]], axis=1)
        cls.test = [(key, material, shape) for key, material, shape, part in rows if part == "test"]
        cls.train = [key for key, _, _, part in rows if part == "train"]
        # The object that each key begins with, and its material's damping.
        cls.alphas = {key.rsplit("/", 1)[0]: alpha
                      for (key, _, _, part), alpha in zip(rows, alphas) if part == "test"}

    def score(self, *arguments):
        return run_json("score", "small", *arguments, cwd=self.folder)

    def refused(self, *arguments):
        result = run("score", "small", *arguments, cwd=self.folder)
        self.assertEqual(result.returncode, 2, result.stdout)
        return result.stderr

    def answers(self, name, answer_of):
        return written(self.folder / f"{name}.csv", ["sample", "class"],
                       [(key, answer_of(key, material)) for key, material, _ in self.test])

    def test_numbers_are_those_of_a_count_by_hand(self):
        generator = random.Random(1)
        answered = {key: generator.choice([material, *CLASSES]) for key, material, _ in self.test}
        self.answers("some", lambda key, _: answered[key])
        found = self.score("--task", "material", "--answers", "some.csv")
        entry = found["entries"][0]
        right = [answered[key] == material for key, material, _ in self.test]
        self.assertAlmostEqual(entry["accuracy"]["mean"], sum(right) / len(right))
        confusion = collections.Counter((material, answered[key]) for key, material, _ in self.test)
        self.assertEqual(entry["confusion"],
                         [[confusion[one, other] for other in CLASSES] for one in CLASSES])
        self.assertEqual(entry["groups"], len({shape for _, _, shape in self.test}))
        low, high = entry["accuracy"]["interval95"]
        self.assertTrue(low <= entry["accuracy"]["mean"] <= high)
        # The board is beside the dataset, for people and for programs.
        board = json.loads((self.folder / "small/evaluation/leaderboard-material.json").read_text())
        self.assertEqual(board["rows"], found["leaderboard"]["rows"])
        text = (self.folder / "small/evaluation/leaderboard-material.md").read_text()
        self.assertIn("some", text)

    def test_entries_are_ranked_and_told_apart(self):
        generator = random.Random(2)
        self.answers("perfect", lambda _, material: material)
        self.answers("constant", lambda *_: "steel")
        noisy = {key: material if generator.random() < 0.9 else "wood" for key, material, _ in self.test}
        self.answers("nearly", lambda key, _: noisy[key])
        found = self.score("--task", "material", "-o", "board", "--answers", "constant.csv",
                           "perfect.csv", "nearly.csv")
        rows = found["leaderboard"]["rows"]
        self.assertEqual([row["entry"] for row in rows], ["perfect", "nearly", "constant"])
        self.assertEqual([row["rank"] for row in rows], [1, 2, 3])
        self.assertTrue(rows[2]["told_apart"])
        self.assertAlmostEqual(rows[2]["difference"]["mean"],
                               rows[2]["measures"][0]["mean"] - 1)
        # An entry of the same name takes the other's place.
        self.answers("constant", lambda _, material: material)
        again = self.score("--task", "material", "-o", "board", "--answers", "constant.csv")
        self.assertEqual(len(again["leaderboard"]["rows"]), 3)
        self.assertEqual(again["leaderboard"]["rows"][0]["entry"], "constant")
        # Without answers the board is told as it stands.
        told = self.score("--task", "material", "-o", "board")
        self.assertEqual(told["entries"], [])
        self.assertEqual(told["leaderboard"]["rows"], again["leaderboard"]["rows"])

    def test_the_board_is_on_the_page(self):
        self.answers("one", lambda _, material: material)
        self.answers("two", lambda *_: "wood")
        self.score("--task", "material", "-o", "page", "--answers", "one.csv", "two.csv")
        expect_report(self, self.folder / "page", ["leaderboard"])

    def test_probabilities_are_held_against_how_often_they_are_right(self):
        def row(key, material, sure):
            return (key, *(sure if name == material else (1 - sure) / 2 for name in CLASSES))
        written(self.folder / "sure.csv", ["sample", *CLASSES],
                [row(key, material, 0.6) for key, material, _ in self.test])
        found = self.score("--task", "material", "-o", "sure", "--answers", "sure.csv")
        # All are right, and it says 60 %.
        self.assertAlmostEqual(found["entries"][0]["calibration_error"], 0.4, places=5)
        numpy.savez(self.folder / "arrays.npz", sample=[key for key, _, _ in self.test],
                    classes=CLASSES,
                    probabilities=[row(key, material, 0.6)[1:] for key, material, _ in self.test])
        arrays = self.score("--task", "material", "-o", "sure", "--answers", "arrays.npz")
        self.assertEqual(arrays["entries"][0]["confusion"], found["entries"][0]["confusion"])
        self.assertAlmostEqual(arrays["entries"][0]["calibration_error"], 0.4, places=5)

    def test_seeds_are_summed_up(self):
        rows = [(key, seed, material if seed < 3 or i % 2 else "wood")
                for i, (key, material, _) in enumerate(self.test) for seed in (1, 2, 3)]
        written(self.folder / "seeds.csv", ["sample", "seed", "class"], rows)
        found = self.score("--task", "material", "-o", "seeds", "--answers", "seeds.csv")
        self.assertEqual(found["entries"][0]["seeds"], [1, 2, 3])
        self.assertGreater(found["entries"][0]["accuracy"]["deviation"], 0)

    def test_what_is_wrong_with_answers_is_named(self):
        rows = [(key, material) for key, material, _ in self.test]
        cases = [
            (["sample", "class"], rows[1:], f"1 of {len(rows)} test samples have no answer"),
            (["sample", "class"], [*rows, rows[0]], "answered twice"),
            (["sample", "class"], [*rows, ("bar-999/steel/1/strike-0000", "steel")], "bar-999"),
            (["sample", "class"], [(rows[0][0], "stel"), *rows[1:]], 'did you mean "steel"?'),
            (["sample", "class"], [(rows[0][0], ""), *rows[1:]], "wrong.csv:2: nothing is no class"),
            (["sample", "answer"], rows, 'column "answer" is none of the classes'),
            (["class"], [row[1:] for row in rows], 'no column "sample"'),
            (["sample", "glass", "steel"], [(row[0], 1, 0) for row in rows], "none of wood"),
            (["sample", *CLASSES], [(row[0], 2, 1, 3) for row in rows], "probabilities sum to 6"),
            (["sample", *CLASSES], [(row[0], "nan", 0, 1) for row in rows], "no probability of glass"),
            (["sample", *CLASSES], [(row[0], -1, 1, 1) for row in rows], "no probability of glass"),
            (["sample", "seed", "class"], [(row[0], "x", row[1]) for row in rows], 'seed "x"'),
        ]
        for header, wrong, message in cases:
            written(self.folder / "wrong.csv", header, wrong)
            told = self.refused("--task", "material", "-o", "wrong", "--answers", "wrong.csv")
            self.assertIn(message, told)
        self.assertFalse((self.folder / "wrong").exists(), "nothing is kept of what is refused")
        self.assertIn("no such file", self.refused("--task", "material", "--answers", "none.csv"))
        self.assertIn("no column of texts", self.refused("--task", "matter", "--answers", "wrong.csv"))
        # Answers for what was learnt from are passed over, and that is said.
        written(self.folder / "more.csv", ["sample", "class"], [*rows, (self.train[0], "wood")])
        found = self.score("--task", "material", "-o", "more", "--answers", "more.csv")
        self.assertIn("1 answers for samples to learn from are passed over",
                      found["entries"][0]["notes"])

    def test_tasks_of_a_configuration(self):
        (self.folder / "tasks.yaml").write_text(
            "train: {tasks: {hard: {column: material, label_groups: {soft: [wood], hard: [steel, glass]}}}}\n")
        rows = [(key, "soft" if material == "wood" else "hard") for key, material, _ in self.test]
        written(self.folder / "groups.csv", ["sample", "class"], rows)
        found = self.score("--task", "hard", "--tasks", "tasks.yaml", "-o", "groups",
                           "--answers", "groups.csv")
        # Classes are not equally many: balanced accuracy ranks.
        measure = found["leaderboard"]["rows"][0]["measures"][0]
        self.assertEqual((measure["name"], measure["mean"]), ("balanced accuracy", 1))
        # The board knows the task from then on.
        self.assertEqual(self.score("--task", "hard", "-o", "groups")["leaderboard"]["rows"],
                         found["leaderboard"]["rows"])

    def test_damping_against_the_truth(self):
        rows = [(name, alpha[0], 1.1 * alpha[1]) for name, alpha in self.alphas.items()]
        written(self.folder / "fits.csv", ["object", "alpha1", "alpha2"], rows)
        exact = [(name, *alpha) for name, alpha in self.alphas.items()]
        written(self.folder / "exact.csv", ["object", "alpha1", "alpha2"], exact)
        found = self.score("--task", "damping", "--answers", "fits.csv", "exact.csv")
        rows = {row["entry"]: {one["name"]: one["mean"] for one in row["measures"]}
                for row in found["leaderboard"]["rows"]}
        self.assertAlmostEqual(rows["fits"]["alpha2 error"], 0.1, places=6)
        self.assertAlmostEqual(rows["fits"]["alpha1 error"], 0, places=6)
        self.assertTrue(0 < rows["fits"]["decay rate error"] < 0.1)
        self.assertAlmostEqual(rows["exact"]["decay rate error"], 0, places=6)
        self.assertEqual(found["leaderboard"]["rows"][0]["entry"], "exact")
        written(self.folder / "few.csv", ["object", "alpha1", "alpha2"], exact[1:])
        self.assertIn(exact[0][0], self.refused("--task", "damping", "--answers", "few.csv"))
        shape = exact[0][0].split("/")[0]
        written(self.folder / "few.csv", ["object", "alpha1", "alpha2"], [(shape, 1, 1e-7)])
        self.assertIn("is any of 3 objects", self.refused("--task", "damping", "--answers", "few.csv"))

    def test_modes_against_the_truth(self):
        # One material: what the modes file has is what sounds.
        (self.folder / "steel.yaml").write_text(
            CONFIG.replace("[steel, wood, glass]", "[steel]").replace("name: small", "name: steel"))
        self.assertEqual(run("build", "steel.yaml", cwd=self.folder).returncode, 0)
        frequencies, rates = {}, {}
        with h5py.File(self.folder / "steel/index.h5") as index:
            alpha1, alpha2 = index["alpha1"][0], index["alpha2"][0]
            for shape, path, part in zip(*(index["shapes"][name].asstr()[:]
                                           for name in ("shape", "modes_file", "split_shape"))):
                if part != "test":
                    continue
                with h5py.File(self.folder / "steel" / path) as file:
                    eigenvalues = file["set-000/eigenvalues"][:]
                frequencies[shape] = numpy.sqrt(eigenvalues) / 2 / numpy.pi
                rates[shape] = (alpha1 + alpha2 * eigenvalues) / 2

        def score(task, *files):
            found = run_json("score", "steel", "--task", task, "--answers", *files, cwd=self.folder)
            return {row["entry"]: {one["name"]: one["mean"] for one in row["measures"]}
                    for row in found["leaderboard"]["rows"]}

        written(self.folder / "sharp.csv", ["object", "frequency_hz"],
                [(name, f * 2 ** (10 / 1200)) for name in frequencies for f in frequencies[name]])
        written(self.folder / "first.csv", ["object", "frequency_hz"],
                [(name, frequencies[name][0]) for name in frequencies])
        rows = score("modes", "sharp.csv", "first.csv")
        self.assertAlmostEqual(rows["sharp"]["pitch error"], 10, delta=1e-3)
        self.assertEqual(rows["sharp"]["modes matched"], 1)
        self.assertEqual(rows["sharp"]["answers too many"], 0)
        self.assertEqual(rows["first"]["pitch error"], 100, "most modes have no answer")
        # The same modes' decay rates are damping, too; by a sample's name as well.
        written(self.folder / "rates.csv", ["sample", "frequency_hz", "decay_rate_per_s"],
                [(f"{name}/steel/1/strike-0000", f, d) for name in frequencies
                 for f, d in zip(frequencies[name], rates[name])])
        self.assertLess(score("damping", "rates.csv")["rates"]["decay rate error"], 1e-6)

    def test_an_export_without_labels_is_scored_by_its_seal(self):
        done = run_json("export", "small", "--format", "wav", "--hide", "test", "-o", "given",
                        cwd=self.folder)
        seal = self.folder / done["sealed"]
        self.assertEqual(stat.S_IMODE(seal.stat().st_mode), 0o600)
        secret = json.loads(seal.read_text())["secret"]
        given = self.folder / "given"
        table = [json.loads(line) for line in (given / "test/metadata.jsonl").read_text().splitlines()]
        names = [row["file_name"].removesuffix(".wav") for row in table]
        self.assertEqual(len(names), len(self.test))
        self.assertEqual(names, sorted(names), "neighbours would be of one object")
        for row in table:
            told = {name for name, value in row.items() if value is not None}
            self.assertEqual(told, {"file_name", "key", "split_shape"})
        self.assertEqual({path.stem for path in (given / "test").glob("*.wav")}, set(names))
        self.assertEqual(len({path.stat().st_mtime for path in (given / "test").glob("*.wav")}), 1)
        learnt = [json.loads(line) for line in (given / "train/metadata.jsonl").read_text().splitlines()]
        self.assertTrue(all(row["material"] in CLASSES for row in learnt))
        # Nothing in the export tells what it hides, or how to make it again.
        keys = [key for key, _, _ in self.test]
        for path in given.rglob("*"):
            if path.is_file() and path.suffix != ".wav":
                text = path.read_text()
                self.assertFalse([key for key in keys if key in text], path)
                self.assertNotIn(secret, text)
                self.assertNotIn("per_object", text)
        self.assertFalse((given / "dataset.json").exists())
        # A sound tells its owner who it is: the dataset has it.
        with h5py.File(self.folder / "small/index.h5") as index:
            sounds = {index["audio"][i].tobytes(): index["material"].asstr()[i]
                      for i in range(len(index["key"]))}
        answers = [(name, sounds[self.sound(given / "test" / f"{name}.wav").tobytes()]) for name in names]
        written(self.folder / "theirs.csv", ["sample", "class"], answers)
        found = run_json("score", "small", "--task", "material", "--sealed", seal, "-o", "sealed",
                         "--answers", "theirs.csv", cwd=self.folder)
        self.assertEqual(found["entries"][0]["accuracy"]["mean"], 1)
        self.assertIn("samples that small does not have",
                      self.refused("--task", "material", "--answers", "theirs.csv"))
        own = written(self.folder / "own.csv", ["sample", "class"], [row[:2] for row in self.test])
        self.assertIn("samples that small does not have",
                      self.refused("--task", "material", "--sealed", seal, "--answers", own))
        # Another export has a seal of its own.
        again = run_json("export", "small", "--format", "webdataset", "--hide", "test", "--with", "mel",
                         "-o", "shards", cwd=self.folder)
        self.assertNotEqual(json.loads((self.folder / again["sealed"]).read_text())["secret"], secret)
        for words, message in [(["--format", "lhotse"], "lhotse"),
                               (["--format", "webdataset", "--with", "alpha1"], "would tell")]:
            result = run("export", "small", "--hide", "test", *words, "-o", "told", cwd=self.folder)
            self.assertEqual(result.returncode, 2)
            self.assertIn(message, result.stderr)

    @staticmethod
    def sound(path):
        """Samples of a WAV file of 32-bit floating point, which Python's module does not read."""
        data = path.read_bytes()
        at = data.index(b"data")
        return numpy.frombuffer(data[at + 8:], "<f4")

    def test_nightly_runs_measure_entries(self):
        sys.path.insert(0, str(CONFIGS.parent / "scripts"))
        self.addCleanup(sys.path.pop, 0)
        from nightly_lib import measures
        written(self.folder / "nightly.csv", ["sample", "class"], [(key, "steel") for key, _, _ in self.test])
        board = self.score("--task", "material", "--answers", "nightly.csv", "-o", "nightly")["leaderboard"]
        found = measures.Collected()
        measures._leaderboard(found, board)
        measure = found.measures["small material nightly accuracy"]
        self.assertAlmostEqual(measure.value, sum(material == "steel" for _, material, _ in self.test) / len(self.test))
        self.assertEqual(measure.kind, "score")
        # What an evaluation has trained is in its own document.
        measures._leaderboard(found, {**board, "rows": [{**row, "trained_here": True, "entry": "x"} for row in board["rows"]]})
        self.assertEqual(len(found.measures), 1)


if __name__ == "__main__":
    unittest.main()
