"""The code of docs/python.md and docs/cpp.md, taken out of the pages and run: PyTorch with workers that are
forked and spawned, tar shards, NumPy, log-mel spectrograms, and the C interface of HDF5."""
import contextlib
import importlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import h5py
import numpy
from program import FolderTest, docs_block, run, run_json

try:
    import soundfile  # noqa: F401
    import torch
    from torch.utils.data import DataLoader
except ImportError:
    torch = None

CONFIG = """
name: smoke
seed: 4
materials: [steel, wood]
objects:
  - {shape: bar, count: 3}
  - {shape: tile, count: 3, sizes: [1, 1.5]}
modes: {max_modes: 8, order: 2, element_size: 25 mm, max_frequency: 6 kHz}
strikes: {per_object: 6}
audio: {seconds: 0.05 s, sample_rate: 22050 Hz}
mel: {bands: 16, frames: 5}
voxels: {resolution: 8}
split: {validation: 0.3, test: 0.3}
"""


class DatasetTest(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.dataset = cls.folder / "carillon-demo" / "smoke"  # where ./scripts/demo leaves it
        run_json("build", cls.write(cls, "small.yaml", CONFIG), "-o", cls.dataset)
        with h5py.File(cls.dataset / "index.h5") as index:
            cls.columns = {name: index[name][:] for name in ("audio", "mel", "id", "shape_index")}
            cls.columns |= {name: index[name].asstr()[:] for name in
                            ("key", "material", "shape", "split_shape", "split_strike")}
            cls.voxels = index["shapes/voxels"][:]
        cls.write(cls, "struck.py", docs_block("python.md", "python", "class Struck"))
        cls.write(cls, "shards.py", docs_block("python.md", "python", "class Shards"))
        sys.path.insert(0, str(cls.folder))

    @classmethod
    def tearDownClass(cls):
        sys.path.remove(str(cls.folder))
        super().tearDownClass()

    def rows(self, split, part):
        return numpy.flatnonzero(self.columns[split] == part)

    def run_block(self, code):
        """Names that a block leaves, run beside the dataset."""
        names = {}
        with contextlib.chdir(self.folder):
            exec(compile(code, "docs", "exec"), names)
        return names


class NumPy(DatasetTest):
    def test_reads_rows_and_bodies(self):
        names = self.run_block(docs_block("python.md", "python", "flatnonzero(index[\"split_shape\"].asstr()"
                                         "[:] == \"train\")"))
        train = self.rows("split_shape", "train")
        self.assertGreater(len(train), 0)
        numpy.testing.assert_array_equal(names["audio"], self.columns["audio"][train])
        self.assertEqual(list(names["materials"]), list(self.columns["material"][train]))
        numpy.testing.assert_array_equal(names["voxels"][names["shape_of"]],
                                         self.voxels[self.columns["shape_index"][train]])
        self.assertEqual(names["rate"], 22050)


@unittest.skipIf(torch is None, "needs Debian's python3-torch and python3-soundfile")
class Torch(DatasetTest):
    def struck(self, *arguments, **options):
        return importlib.import_module("struck").Struck(self.dataset, *arguments, **options)

    def expect_epochs(self, data, split, part, context, epochs=3):
        """Every row of a part comes once an epoch, in another order each time, with its label and bits."""
        rows = self.rows(split, part)
        by_sound = {self.columns["audio"][row].tobytes(): row for row in rows}
        self.assertEqual(len(by_sound), len(rows))
        torch.manual_seed(1)
        loader = DataLoader(data, batch_size=5, shuffle=True, num_workers=2, persistent_workers=True,
                            multiprocessing_context=context)
        orders = []
        for _ in range(epochs):
            order = []
            for audio, labels in loader:
                for clip, label in zip(audio.numpy(), labels):
                    row = by_sound[clip.tobytes()]
                    self.assertEqual(data.classes[label], self.columns["material"][row])
                    order.append(row)
            self.assertEqual(sorted(order), list(rows))
            orders.append(order)
        self.assertNotEqual(orders[0], orders[1])
        self.assertNotEqual(orders[1], orders[2])

    def test_workers_of_either_make_read_every_row_of_either_split(self):
        for split in ("split_shape", "split_strike"):
            for context in ("fork", "spawn"):
                with self.subTest(split=split, context=context):
                    self.expect_epochs(self.struck("train", split), split, "train", context)

    def test_parts_have_the_same_classes_and_no_row_in_common(self):
        parts = {part: self.struck(part) for part in ("train", "validation", "test")}
        for data in parts.values():
            self.assertGreater(len(data), 0)
            self.assertEqual(list(data.classes), ["steel", "wood"])
        self.assertEqual(sorted(numpy.concatenate([data.rows for data in parts.values()])),
                         list(range(len(self.columns["key"]))))

    def test_a_file_that_was_open_before_the_fork_does_no_harm(self):
        data = self.struck("train")
        first = data[0][0]
        self.assertGreater(importlib.import_module("struck").opened.cache_info().currsize, 0)
        for context in ("fork", "spawn"):
            self.expect_epochs(data, "split_shape", "train", context)
        numpy.testing.assert_array_equal(data[0][0], first)

    def test_a_forked_worker_has_an_open_file_of_its_own(self):
        struck = importlib.import_module("struck").Struck

        class Probe(struck):
            """Tells what was open when the worker came, and which process reads."""
            def __getitem__(self, i):
                inherited = [entry.name for entry in os.scandir("/proc/self/fd")
                             if os.path.realpath(entry.path).endswith(".h5")]
                super().__getitem__(i)
                return len(inherited), os.getpid()

        data = Probe(self.dataset)
        struck.__getitem__(data, 0)
        seen = {}
        for inherited, worker in DataLoader(data, batch_size=None, num_workers=2,
                                            multiprocessing_context="fork"):
            self.assertNotEqual(worker, os.getpid())
            seen.setdefault(worker, inherited)
        self.assertEqual(list(seen.values()), [0, 0])  # opened by the worker when it first read

    def test_other_columns(self):
        data = self.struck("test", label="shape", data="mel")
        for i, row in enumerate(self.rows("split_shape", "test")):
            numpy.testing.assert_array_equal(data[i][0], self.columns["mel"][row])
            self.assertEqual(data.classes[data[i][1]], self.columns["shape"][row])

    def test_the_loop_as_it_stands(self):
        names = self.run_block(docs_block("python.md", "python", "for audio, material in loader"))
        self.assertEqual(names["audio"].shape[1:], self.columns["audio"].shape[1:])
        del names["loader"]

    def test_log_mel(self):
        log_mel = self.run_block(docs_block("python.md", "python", "def log_mel"))["log_mel"]
        mel = self.columns["mel"].astype(float)
        loudest = mel.max(axis=(1, 2), keepdims=True)
        with numpy.errstate(divide="ignore"):
            expected = numpy.maximum(10 * numpy.log10(mel / loudest), -80)
        found = log_mel(torch.from_numpy(self.columns["mel"])).numpy()
        numpy.testing.assert_allclose(found, expected, atol=1e-4)
        self.assertEqual(found.max(), 0)
        self.assertTrue(numpy.isfinite(log_mel(torch.zeros(2, 4, 3))).all())
        louder = log_mel(torch.from_numpy(self.columns["mel"] * 100)).numpy()
        numpy.testing.assert_allclose(louder, found, atol=1e-4)

    def export(self, name, *arguments):
        """The training part's tar files of a dataset."""
        output = self.folder / f"{pathlib.Path(name).name}-webdataset"
        done = run("export", self.folder / name, "--format", "webdataset", *arguments, "-o", output)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [str(path) for path in output.glob("train-*.tar")]

    def test_tar_shards(self):
        paths = self.export("carillon-demo/smoke", "--with", "mel", "--per-shard", 9, "--split", "split_strike")
        self.assertGreater(len(paths), 3)
        shards = importlib.import_module("shards").Shards(paths)
        rows = {key: row for row, key in enumerate(self.columns["key"])}
        for context in ("fork", "spawn"):
            loader = DataLoader(shards, batch_size=None, num_workers=2, multiprocessing_context=context)
            seen = []
            for sample in loader:
                row = rows[sample["json"]["key"]]
                seen.append(row)
                numpy.testing.assert_array_equal(sample["wav"][:, 0], self.columns["audio"][row])
                numpy.testing.assert_array_equal(sample["mel.npy"], self.columns["mel"][row])
                self.assertEqual(sample["json"]["material"], self.columns["material"][row])
            self.assertEqual(sorted(seen), list(self.rows("split_strike", "train")))

    def test_16_bit_audio_is_1_at_full_scale_by_either_loader(self):
        run_json("build", self.folder / "small.yaml", "-o", self.folder / "int16",
                 "--set", "audio.dtype=int16")
        data = importlib.import_module("struck").Struck(self.folder / "int16")
        with h5py.File(self.folder / "int16" / "index.h5") as index:
            stored, keys = index["audio"][:], index["key"].asstr()[:]
        self.assertEqual(stored.dtype, numpy.int16)
        shards = importlib.import_module("shards").Shards(self.export("int16"))
        tarred = {sample["json"]["key"]: sample["wav"][:, 0] for sample in shards}
        self.assertEqual(set(tarred), set(keys[data.rows]))
        for i, row in enumerate(data.rows):
            expected = stored[row].astype("f4") / 32768
            numpy.testing.assert_array_equal(data[i][0].numpy(), expected)
            numpy.testing.assert_array_equal(tarred[keys[row]], expected)


class Cpp(DatasetTest):
    def compile(self):
        """The program of docs/cpp.md by the command in its first lines."""
        code = docs_block("cpp.md", "cpp", "int main")
        self.write("listen.cpp", code)
        command = re.search(r"^//\s+(g\+\+ .*)$", code, re.MULTILINE)[1]
        done = subprocess.run(["bash", "-c", command.replace("g++", "g++ -Wall -Wextra -Werror")],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    @unittest.skipUnless(shutil.which("g++") and shutil.which("pkg-config"), "needs g++ and pkg-config")
    def test_reads_sounds_and_labels(self):
        self.compile()
        index = self.dataset / "index.h5"
        for row in (0, 17, len(self.columns["key"]) - 1):
            done = subprocess.run([self.folder / "listen", index, str(row)], cwd="/", capture_output=True,
                                  text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            key, material, size, _, _, rate, _, *audio = done.stdout.split()
            self.assertEqual((key, material), (self.columns["key"][row], self.columns["material"][row]))
            self.assertEqual((int(size), float(rate)), (self.columns["audio"].shape[1], 22050))
            numpy.testing.assert_array_equal(numpy.float32(audio), self.columns["audio"][row, :4])
        for words, said in (((index, "100000"), "rows"), (("nowhere.h5", "0"), "nowhere.h5"), ((), "usage")):
            done = subprocess.run([self.folder / "listen", *words], capture_output=True, text=True)
            self.assertEqual(done.returncode, 1)
            self.assertIn(said, done.stderr)

    @unittest.skipUnless(shutil.which("cmake") and shutil.which("pkg-config"), "needs cmake and pkg-config")
    def test_compiles_with_cmake(self):
        place = self.folder / "with-cmake"
        place.mkdir()
        (place / "listen.cpp").write_text(docs_block("cpp.md", "cpp", "int main"))
        (place / "CMakeLists.txt").write_text(docs_block("cpp.md", "cmake", "project"))
        for words in (("cmake", "-S", ".", "-B", "build"), ("cmake", "--build", "build")):
            done = subprocess.run(words, cwd=place, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
        done = subprocess.run([place / "build" / "listen", self.dataset / "index.h5", "1"],
                              capture_output=True, text=True)
        self.assertEqual(done.stdout.split()[0], self.columns["key"][1])


if __name__ == "__main__":
    unittest.main()
