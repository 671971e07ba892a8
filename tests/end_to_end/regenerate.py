"""carillon regenerate: the stored bytes again, or the same sample with one thing changed."""
import json
import shutil
import unittest

import h5py
import numpy
from program import FolderTest, run, run_json
from small_dataset import write_inputs


class Regenerate(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = write_inputs(cls.folder)
        cls.output = cls.folder / "small"
        run_json("build", cls.config, "-o", cls.output)
        with h5py.File(cls.output / "index.h5") as index:
            cls.keys = list(index["key"].asstr()[()])
            cls.ids = [int(i) for i in index["id"][()]]
            cls.audio = index["audio"][()]
            cls.noise = index["noise_source"].asstr()[()]
            cls.ratio = index["noise_ratio"][()]
            cls.active = numpy.stack([index["active_begin"][()], index["active_end"][()]], 1)

    def regenerate(self, folder, *samples, code=0, **options):
        words = [word for sample in samples for word in ("--sample", sample)]
        words += [word for key, value in options.get("set", {}).items()
                  for word in ("--set", f"{key}={value}")]
        result = run("regenerate", folder, *words, *options.get("more", ()), "--json",
                     ranks=options.get("ranks"), cwd=options.get("cwd"))
        self.assertEqual(result.returncode, code, result.stderr + result.stdout[-2000:])
        return json.loads(result.stdout) if code != 2 else result.stderr

    def copy(self):
        output = self.folder / self.id().rsplit(".", 1)[-1]
        shutil.copytree(self.output, output)
        return output

    def heard(self, name):
        """Samples of a WAV file of 32-bit floats."""
        data = (self.folder / name).read_bytes()
        return numpy.frombuffer(data[-4 * self.audio.shape[1]:], "<f4")

    def test_every_sample_by_row_key_and_id(self):
        names = [row if row % 3 == 0 else self.keys[row] if row % 3 == 1 else self.ids[row]
                 for row in range(len(self.keys))]
        report = self.regenerate(self.output, *names)
        self.assertEqual([s["key"] for s in report["samples"]], self.keys)
        for sample in report["samples"]:
            self.assertTrue(sample["stored"])
            self.assertTrue(sample["identical"], sample)
            self.assertEqual(sample["differences"], [])
        self.assertEqual((report["versions"], report["doubts"], report["modes"]), ({}, [], []))

    def test_ranks_and_words(self):
        report = self.regenerate(self.output, 5, ranks=2)
        self.assertTrue(report["samples"][0]["identical"])
        result = run("regenerate", self.output, "--sample", 5)
        self.assertEqual(result.returncode, 0)
        self.assertEqual(result.stdout, f"{self.keys[5]}: identical\n")

    def test_sounds(self):
        self.regenerate(self.output, 7, more=("-o", self.folder / "one.wav"))
        numpy.testing.assert_array_equal(self.heard("one.wav"), self.audio[7])
        report = self.regenerate(self.output, 7, 8, more=("-o", self.folder / "many"))
        for row, sample in zip((7, 8), report["samples"]):
            numpy.testing.assert_array_equal(self.heard(sample["wav"]), self.audio[row])

    def test_one_thing_changed(self):
        row = 9
        sounds = {}
        for name, change in (("louder", {"noise.snr": 0}), ("none", {"effects.noise": "off"})):
            report = self.regenerate(self.output, row, set=change,
                                     more=("-o", self.folder / f"{name}.wav"))
            sounds[name] = self.heard(f"{name}.wav").astype(float)
            if name != "louder":
                continue
            sample = report["samples"][0]
            self.assertEqual({d["column"] for d in sample["differences"]},
                             {"audio", "mel", "peak", "noise_ratio", "noise_level"})
            self.assertEqual(sample["record"]["noise_ratio"], 0)
            self.assertEqual(sample["record"]["noise_source"], self.noise[row])
        # The same noise, louder by the change of the ratio; and the ratio is what was asked for.
        quiet = self.audio[row] - sounds["none"]
        loud = sounds["louder"] - sounds["none"]
        factor = 10**(self.ratio[row] / 20)
        numpy.testing.assert_allclose(loud, factor * quiet, atol=2e-3 * numpy.abs(loud).max())
        begin, end = numpy.round(self.active[row] * 22050).astype(int)
        level = 10 * numpy.log10((sounds["none"][begin:end]**2).mean() /
                                 (loud[begin:end]**2).mean())
        self.assertAlmostEqual(level, 0, 2)

    def test_changed_audio_is_told_in_db(self):
        output = self.copy()
        row = 3
        with h5py.File(output / "samples" / "bar-000-0000.h5", "r+") as shard:
            stored = shard["audio"][row] * numpy.float32(1.01)
            shard["audio"][row] = stored
            shard["impulse"][row] *= 2
        sample = self.regenerate(output, row, code=3)["samples"][0]
        found = {d["column"]: d for d in sample["differences"]}
        self.assertEqual(set(found), {"audio", "impulse"})
        self.assertAlmostEqual(found["impulse"]["stored"], 2 * found["impulse"]["made"])
        difference = stored.astype(float) - self.audio[row]
        db = 10 * numpy.log10((difference**2).sum() / (stored.astype(float)**2).sum())
        self.assertAlmostEqual(found["audio"]["difference_db"], db, 9)
        text = run("regenerate", output, "--sample", row).stdout
        self.assertIn(f"audio: differs by {db:.1f} dB", text)

    def test_other_columns(self):
        output = self.copy()
        with h5py.File(output / "samples" / "bar-000-0000.h5", "r+") as shard:
            del shard["peak"]
            shard["strike"].attrs["unit"] = "m"
        found = self.regenerate(output, 0, code=3)["samples"][0]["differences"]
        self.assertEqual({d["column"] for d in found}, {"peak", "strike"})

    def test_other_versions_are_named(self):
        output = self.copy()
        path = output / "dataset.json"
        description = json.loads(path.read_text())
        description["versions"]["fftw"] = "fftw-2.0"
        path.write_text(json.dumps(description))
        versions = self.regenerate(output, 0)["versions"]
        self.assertEqual(set(versions), {"fftw"})
        self.assertEqual(versions["fftw"]["stored"], "fftw-2.0")

    def test_a_sample_that_is_not_stored(self):
        output = self.copy()
        (output / "samples" / "bar-001-0000.h5").unlink()
        key = next(key for key in self.keys if key.startswith("bar-001"))
        sample = self.regenerate(output, key, code=3)["samples"][0]
        self.assertFalse(sample["stored"])

    def test_modes_are_solved_again_where_they_must(self):
        output = self.copy()
        (output / "modes" / "bar-000.h5").unlink()
        report = self.regenerate(output, 0)
        self.assertEqual(report["modes"], [{"shape": "bar-000", "why": "modes/bar-000.h5 is missing"}])
        self.assertTrue(report["samples"][0]["identical"])
        report = self.regenerate(self.output, 0, set={"modes.max_frequency": "7 kHz"})
        self.assertEqual(report["modes"][0]["why"], "--set changes its modes")
        self.assertIn("modes", {d["column"] for d in report["samples"][0]["differences"]})

    def test_the_folder_alone(self):
        elsewhere = self.folder / "elsewhere"
        elsewhere.mkdir()
        inputs = elsewhere / "inputs"
        inputs.mkdir()
        output = elsewhere / "data"
        run_json("build", write_inputs(inputs), "-o", output)
        row = self.keys.index(next(key for key in self.keys if key.startswith("copy/")))
        # Neither meshes nor materials nor the configuration are there any more.
        shutil.rmtree(inputs / "meshes")
        (inputs / "own.yaml").unlink()
        (inputs / "small.yaml").unlink()
        self.assertTrue(self.regenerate("data", row, cwd=elsewhere)["samples"][0]["identical"])
        # Recordings are looked for, and told of where they are not found.
        (inputs / "noise").rename(self.folder / "moved-noise")
        error = self.regenerate(output, row, code=2)
        self.assertIn("noise", error)
        self.assertIn("--inputs", error)
        (self.folder / "again").mkdir()
        (self.folder / "moved-noise").rename(self.folder / "again" / "noise")
        report = self.regenerate(output, row, more=("--inputs", self.folder / "again"))
        self.assertTrue(report["samples"][0]["identical"])
        # Modes that are missing need the mesh.
        (output / "modes" / "copy.h5").unlink()
        error = self.regenerate(output, row, code=2, more=("--inputs", self.folder / "again"))
        self.assertIn("its mesh", error)

    def test_other_recordings_are_doubted(self):
        output = self.copy()
        other = self.folder / "other"
        shutil.copytree(self.folder / "noise", other / "noise")
        (other / "noise" / "b.wav").unlink()
        report = json.loads(run("regenerate", output, "--sample", 0, "--inputs", other,
                                "--json").stdout)
        self.assertEqual(len(report["doubts"]), 1)
        self.assertIn("not those that the dataset was built from", report["doubts"][0])

    def test_what_is_not_there(self):
        self.assertIn("did you mean bar-000/steel/1/strike-0000?",
                      self.regenerate(self.output, "bar-000/steel/1/strike-0009", code=2))
        self.assertIn("rows of index.h5 go from 0 to 59", self.regenerate(self.output, 60, code=2))
        self.assertIn("is no dataset", self.regenerate(self.folder, 0, code=2))
        self.assertIn("change something else", self.regenerate(
            self.output, 0, code=2, set={"objects[0].materials": "[glass]"}))


if __name__ == "__main__":
    unittest.main()
