"""`carillon export`: WAV files with tables, and tar shards, read back by Python's own libraries; what
Croissant descriptions promise, of exports and of datasets."""
import fcntl
import fnmatch
import hashlib
import io
import json
import pathlib
import re
import shutil
import tarfile
import unittest
import wave

import h5py
import numpy
from msh_files import msh_4, two_part_bar
from program import FolderTest, run, run_json

CONFIG = """
name: small
dataset: {creator: [A, B], license: CC-BY-4.0, url: "https://example.org/small", version: 1.0.0}
seed: 4
materials: [steel, wood]
objects:
  - {shape: bar, count: 3}
  - {shape: tile, count: 2}
modes: {max_modes: 10, order: 2, element_size: 20 mm, max_frequency: 7 kHz}
strikes: {per_object: 8}
audio: {seconds: 0.1 s, sample_rate: 22050 Hz, dtype: int16, gain: 100}
listeners:
  - {position: [0, 0, 0.8 m]}
  - {position: [0.5 m, 0, 0.8 m]}
mel: {bands: 16, frames: 5}
voxels: {resolution: 8}
split: {validation: 0.3, test: 0.3}
"""


# An object called as a part of the split, of two materials, on three fingers.
ODD = """
name: odd
seed: 2
materials_file: own.yaml
objects: [{mesh: test.msh, materials: {left: steel, right: Messing-ä}}]
modes: {max_modes: 4, order: 2}
strikes: {per_object: 12}
supports: {contacts: [{kind: finger, count: 3, pool: 5}]}
audio: {seconds: 0.05 s, sample_rate: 22050 Hz, gain: 2}
split: {validation: 0.3, test: 0.3}
"""
OWN = "Messing-ä: {youngs_modulus: 100 GPa, poisson_ratio: 0.34, density: 8500, alpha2: 2e-8 s}\n"
ODD_MATERIAL = "left=steel,right=Messing-ä"


def hashes(folder):
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in folder.rglob("*") if path.is_file()}


def read_table(path):
    """The rows of a metadata.jsonl."""
    return [json.loads(line) for line in path.read_text().splitlines()]


def read_wav(file):
    """Samples [listeners, samples] as they are stored."""
    with wave.open(file) as clip:
        frames = numpy.frombuffer(clip.readframes(clip.getnframes()), "<i2")
        return frames.reshape(-1, clip.getnchannels()).T, clip.getframerate()


def ids(node):
    """Every `@id` that a description defines: of objects with more than the id alone."""
    if isinstance(node, dict):
        found = [node["@id"]] if "@id" in node and "@type" in node else []
        return found + [one for name, value in node.items() if name != "@context"
                        for one in ids(value)]
    return [one for value in node for one in ids(value)] if isinstance(node, list) else []


def references(node):
    if isinstance(node, dict):
        if set(node) == {"@id"}:
            return [node["@id"]]
        return [one for name, value in node.items() if name != "@context"
                for one in references(value)]
    return [one for value in node for one in references(value)] if isinstance(node, list) else []


class Exports(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        config = cls.write(cls, "small.yaml", CONFIG)
        cls.dataset = cls.folder / "dataset"
        run_json("build", config, "-o", cls.dataset)
        cls.index = h5py.File(cls.dataset / "index.h5")
        cls.keys = cls.index["key"].asstr()[:]
        cls.parts = cls.index["split_strike"].asstr()[:]

    @classmethod
    def tearDownClass(cls):
        cls.index.close()
        super().tearDownClass()

    def export(self, name, *arguments, ranks=None):
        output = self.folder / name
        found = run_json("export", self.dataset, "-o", output, "--split", "split_strike",
                         *arguments, ranks=ranks)
        self.assertEqual(found["samples"], len(self.keys))
        self.assertEqual(found["parts"], {part: sum(self.parts == part) for part in
                                          sorted(set(self.parts))})
        return output

    def expect_row(self, values, row):
        """What is told of a sample is what the dataset says."""
        self.assertEqual(values["key"], self.keys[row])
        self.assertEqual(values["material"], self.index["material"].asstr()[row])
        self.assertEqual(values["id"], str(self.index["id"][row]))
        for axis, name in enumerate("xyz"):
            self.assertEqual(values[f"position_{name}"], self.index["position"][row, axis])
        self.assertEqual(values["impulse"], self.index["impulse"][row])
        self.assertNotIn("audio", values)

    def expect_described(self, folder):
        """The description's files are there, its ids are unique, and what they refer to is there."""
        document = json.loads((folder / "croissant.json").read_text())
        self.assertEqual(document["conformsTo"], "http://mlcommons.org/croissant/1.1")
        self.assertEqual(document["name"], "small")
        self.assertEqual(document["license"], "https://spdx.org/licenses/CC-BY-4.0")
        self.assertEqual([one["name"] for one in document["creator"]], ["A", "B"])
        self.assertNotIn("datePublished", document)
        defined = ids(document["distribution"]) + ids(document["recordSet"])
        self.assertEqual(len(defined), len(set(defined)))
        self.assertLessEqual(set(references(document)), set(defined))
        for item in document["distribution"]:
            if item["@type"] == "cr:FileObject":
                content = (folder / item["contentUrl"]).read_bytes()
                self.assertEqual(item["sha256"], hashlib.sha256(content).hexdigest())
                self.assertEqual(item["contentSize"], f"{len(content)} B")
        return document

    def expect_joined(self, document, paths):
        """What its patterns and expressions make of paths are the dataset's keys."""
        sets = {item["@id"]: item for item in document["distribution"]}
        fields = {field["@id"]: field for record_set in document["recordSet"]
                  for field in record_set["field"]}
        sounds = fnmatch.filter(paths, sets["sounds"]["includes"])
        regex = fields["samples/key"]["source"]["transform"]["regex"]
        self.assertEqual(sorted(re.match(regex, path).group(1) for path in sounds),
                         sorted(self.keys))
        self.assertEqual(fields["samples/key"]["references"], {"@id": "labels/key"})
        self.assertEqual(fields["samples/audio"]["source"]["samplingRate"], 22050)
        self.assertIn("Pa times the gain of 100 1/Pa", fields["samples/audio"]["description"])
        self.assertTrue(fields["samples/impulse"]["description"].endswith("in N s"))
        self.assertEqual(sets["dataset.json"]["encodingFormat"], "application/json")
        self.assertEqual(fields["samples/material"]["source"], {"@id": "labels/material"})
        self.assertEqual([fields[f"labels/{name}"]["dataType"] for name in
                          ("material", "strike", "impulse")],
                         ["sc:Text", "sc:Integer", "sc:Float"])
        return fnmatch.filter(paths, sets["label-files"]["includes"]), fields

    def test_describes_wav_files(self):
        output = self.export("described-wav", "--format", "wav")
        document = self.expect_described(output)
        paths = [str(path.relative_to(output)) for path in output.rglob("*") if path.is_file()]
        self.assertEqual((output / "dataset.json").read_bytes(),
                         (self.dataset / "dataset.json").read_bytes())
        tables, fields = self.expect_joined(document, paths)
        self.assertEqual(len(tables), len(set(self.parts)))
        for table in tables:
            for name in list(read_table(output / table)[0])[1:]:
                self.assertEqual(fields[f"labels/{name}"]["source"]["extract"], {"column": name})

    def test_describes_tar_files(self):
        output = self.export("described-tar", "--format", "webdataset")
        document = self.expect_described(output)
        paths = []
        for path in output.glob("*.tar"):
            with tarfile.open(path) as tar:
                paths += tar.getnames()
                some = json.loads(tar.extractfile(tar.getnames()[1]).read())
        labels, fields = self.expect_joined(document, paths)
        self.assertEqual(len(labels), len(self.keys))
        for name in some:
            self.assertEqual(fields[f"labels/{name}"]["source"]["extract"],
                             {"jsonPath": f"$.{name}"})

    def test_describes_the_dataset(self):
        document = self.expect_described(self.dataset)
        files = {item["@id"] for item in document["distribution"]}
        self.assertLessEqual({str(path.relative_to(self.dataset)) for path in
                              self.dataset.rglob("*.h5")}, files)
        for field in document["recordSet"][0]["field"]:
            column = self.index[field["source"]["extract"]["column"]]
            shape = tuple(map(int, field.get("arrayShape", "0").split(",")))
            self.assertEqual(shape if field.get("isArray") else (), column.shape[1:])

    def test_tells_what_a_publication_lacks(self):
        def publication():
            checks = run_json("check", output)["checks"]
            return next(check for check in checks if check["name"] == "publication")

        config = self.write("said.yaml", CONFIG)
        output = self.folder / "said"
        run_json("build", config, "-o", output)
        self.assertEqual(publication()["verdict"], "note")
        self.assertIn("description, published", publication()["text"])
        shards = hashes(output / "samples")
        times = {path: path.stat().st_mtime_ns for path in output.rglob("samples/*.h5")}
        more = ["--set", "dataset.description=Bars and tiles", "--set",
                "dataset.published=2026-03-31"]
        run_json("build", config, "-o", output, *more)
        self.assertEqual(publication()["verdict"], "pass")
        document = json.loads((output / "croissant.json").read_text())
        self.assertEqual(document["description"], "Bars and tiles")
        self.assertEqual(document["datePublished"], "2026-03-31")
        self.assertEqual(hashes(output / "samples"), shards)
        self.assertEqual({path: path.stat().st_mtime_ns for path in times}, times)  # none anew
        # Another version puts it otherwise; what it says counts.
        document.update({"@context": {}, "conformsTo": "http://mlcommons.org/croissant/1.2"})
        (output / "croissant.json").write_text(json.dumps(document))
        self.assertEqual(publication()["verdict"], "pass")
        gone = document["recordSet"][0]["field"].pop()["name"]
        (output / "croissant.json").write_text(json.dumps(document))
        self.assertIn(f"croissant.json: column {gone}", run("check", output).stdout)
        (output / "croissant.json").write_text("{}")
        checked = run("check", output)
        self.assertEqual(checked.returncode, 3)
        self.assertIn("croissant.json does not say", checked.stdout)
        refused = run("build", config, "-o", output, "--set", "dataset.published=soon")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("is not a date", refused.stderr)
        refused = run("build", config, "-o", output, "--set", "dataset.url=example.org")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("is not an address on the web", refused.stderr)

    def test_wav_files_and_a_table_for_each_part(self):
        output = self.export("wav", "--format", "wav")
        seen = set()
        for part in sorted(set(self.parts)):
            for values in read_table(output / part / "metadata.jsonl"):
                row = list(self.keys).index(values["key"])
                self.assertEqual(self.parts[row], part)
                self.expect_row(values, row)
                samples, rate = read_wav(str(output / part / values["file_name"]))
                self.assertEqual(rate, 22050)
                numpy.testing.assert_array_equal(samples, self.index["audio"][row])
                seen.add(values["key"])
        self.assertEqual(seen, set(self.keys))
        self.assertEqual(len(list(output.rglob("*.wav"))), len(self.keys))
        self.assertEqual(hashes(self.export("wav-2", "--format", "wav", ranks=2)), hashes(output))

    def test_tar_files_of_shuffled_samples(self):
        arguments = ["--format", "webdataset", "--with", "mel", "voxels", "--per-shard", "7"]
        output = self.export("tar", *arguments)
        seen = []
        for path in sorted(output.glob("*.tar")):
            part, number = path.name.removesuffix(".tar").split("-")
            with tarfile.open(path) as tar:
                names = tar.getnames()
                self.assertLessEqual(len(names), 7 * 4)
                self.assertTrue(int(number) == 0 or len(names) > 0)
                keys = [name.removesuffix(".wav") for name in names[::4]]
                for i, key in enumerate(keys):  # a sample's files follow one another
                    self.assertEqual(names[4 * i:4 * i + 4],
                                     [key + "." + ending for ending in
                                      ("wav", "json", "mel.npy", "voxels.npy")])
                    row = list(self.keys).index(key)
                    self.assertEqual(self.parts[row], part)
                    read = [tar.extractfile(name).read() for name in names[4 * i:4 * i + 4]]
                    samples, _ = read_wav(io.BytesIO(read[0]))
                    numpy.testing.assert_array_equal(samples, self.index["audio"][row])
                    self.expect_row(json.loads(read[1]), row)
                    numpy.testing.assert_array_equal(numpy.load(io.BytesIO(read[2])),
                                                     self.index["mel"][row])
                    body = self.index["shape_index"][row]
                    numpy.testing.assert_array_equal(numpy.load(io.BytesIO(read[3])),
                                                     self.index["shapes/voxels"][body])
                self.assertTrue(all(member.mtime == 0 for member in tar.getmembers()))
                seen += keys
        self.assertEqual(sorted(seen), sorted(self.keys))
        self.assertNotEqual(seen, sorted(seen))
        self.assertEqual(hashes(self.export("tar-2", *arguments, ranks=2)), hashes(output))

    def test_fills_what_was_left_unfinished_and_nothing_else(self):
        output = self.export("again", "--format", "wav")
        full = hashes(output)
        refused = run("export", self.dataset, "--format", "wav", "-o", output)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("is not empty", refused.stderr)
        self.assertEqual(hashes(output), full)
        (output / ".unfinished-export").write_text("")
        next(output.rglob("*.wav")).unlink()
        self.assertEqual(hashes(self.export("again", "--format", "wav")), full)

    def copy(self, name):
        return pathlib.Path(shutil.copytree(self.dataset, self.folder / name))

    def test_refuses_what_is_not_whole(self):
        def refused(said, *arguments):
            output = self.folder / "not-whole"
            for ranks in (None, 2):
                result = run("export", copy, "--format", "webdataset", "-o", output, *arguments,
                             ranks=ranks)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(said, result.stderr)
                self.assertFalse(output.exists())

        copy = self.copy("lacking")
        (copy / "modes" / "bar-001.h5").unlink()
        refused("lacks files: modes/bar-001.h5", "--with", "voxels")
        shard = next(copy.glob("samples/*.h5"))
        shard.unlink()
        refused(f"lacks files: samples/{shard.name}")
        with open(copy / ".lock", "a") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            refused("is at work in")

    def test_counts_what_a_build_left_out(self):
        copy = self.copy("stopped")
        planned = run("export", copy, "--format", "wav", "-o", self.folder / "planned")
        self.assertEqual(planned.returncode, 0)
        self.assertNotIn("planned", planned.stderr)
        path = copy / "configuration.yaml"
        text = path.read_text()
        self.assertIn("per_object: 8", text)
        path.write_text(text.replace("per_object: 8", "per_object: 9"))
        stopped = run("export", copy, "--format", "wav", "-o", self.folder / "fewer", ranks=2)
        self.assertEqual(stopped.returncode, 0)
        self.assertEqual(stopped.stderr.count("has 80 of 90 planned samples"), 1)

    def test_says_what_is_wrong(self):
        for arguments, said in (
                ((self.folder, "--format", "wav"), "is no dataset"),
                ((self.dataset, "--format", "wav", "--split", "split_room"), "split_shape"),
                ((self.dataset, "--format", "wav", "--with", "mel"), "webdataset"),
                ((self.dataset, "--format", "webdataset", "--with", "smell"), "mel"),
                ((self.dataset, "--format", "webdataset", "--with", "material"), ".json"),
                ((self.dataset, "--format", "croissant"), "has a croissant.json already"),
                ((self.dataset, "--format", "zip"), "zip")):
            for ranks in (None, 2):
                result = run("export", *arguments, "-o", self.folder / "wrong", ranks=ranks)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(said, result.stderr)


class OddNames(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.write(cls, "own.yaml", OWN)
        cls.write(cls, "test.msh", msh_4(*two_part_bar()))
        cls.dataset = cls.folder / "odd"
        run_json("build", cls.write(cls, "odd.yaml", ODD), "-o", cls.dataset)
        with h5py.File(cls.dataset / "index.h5") as index:
            cls.keys = list(index["key"].asstr()[:])
            cls.columns = {name: index[name][:] for name in
                           ("position", "support_force", "support_index", "support_position")}

    def export(self, form):
        output = self.folder / form
        run_json("export", self.dataset, "--format", form, "-o", output, "--split", "split_strike")
        return output

    def expect_values(self, values):
        self.assertEqual(values["material"], ODD_MATERIAL)
        row = self.keys.index(values["key"])
        expected = {f"position_{name}": self.columns["position"][row, axis]
                    for axis, name in enumerate("xyz")}
        for i in range(3):
            expected[f"support_force_{i}"] = self.columns["support_force"][row, i]
            expected[f"support_index_{i}"] = self.columns["support_index"][row, i]
            for axis, name in enumerate("xyz"):
                expected[f"support_position_{i}_{name}"] = \
                    self.columns["support_position"][row, i, axis]
        self.assertEqual({name: values[name] for name in expected}, expected)
        self.assertNotIn("support_force_x", values)

    def test_tables_and_paths(self):
        output = self.export("wav")
        seen = []
        for table in output.glob("*/metadata.jsonl"):
            for values in read_table(table):
                self.expect_values(values)
                self.assertTrue((table.parent / values["file_name"]).exists())
                seen.append(values["key"])
        self.assertEqual(sorted(seen), sorted(self.keys))
        fields = {field["@id"]: field for records in
                  json.loads((output / "croissant.json").read_text())["recordSet"]
                  for field in records["field"]}
        self.assertIn("m/s times the gain of 2 s/m", fields["samples/audio"]["description"])
        self.assertTrue(fields["labels/support_force_2"]["description"].endswith("in N"))
        regex = fields["samples/key"]["source"]["transform"]["regex"]
        paths = [str(path.relative_to(output)) for path in output.rglob("*.wav")]
        self.assertTrue(any(path.startswith("train/test/") for path in paths))
        for above in ("", "data/"):
            self.assertEqual(sorted(re.match(regex, above + path).group(1) for path in paths),
                             sorted(self.keys))

    def test_tar_files(self):
        seen = []
        for path in self.export("webdataset").glob("*.tar"):
            with tarfile.open(path, encoding="utf-8") as tar:
                names = tar.getnames()
                for name in names[1::2]:
                    self.expect_values(json.loads(tar.extractfile(name).read()))
            seen += [name.removesuffix(".wav") for name in names[::2]]
        self.assertEqual(sorted(seen), sorted(self.keys))


if __name__ == "__main__":
    unittest.main()
