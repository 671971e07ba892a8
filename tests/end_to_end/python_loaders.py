"""Datasets as Python and C read them: the module's loaders with workers that are forked and spawned, and the code of
docs/python.md and docs/cpp.md, taken out of the pages and run: NumPy, tar shards, log-mel spectrograms, the C
interface of HDF5."""
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
from program import CARILLON, NO_PICTURES, FolderTest, docs_block, pictures, run, run_json

sys.path.insert(0, str(pathlib.Path(CARILLON).parent / "python"))
try:
    import carillon as ca
except ImportError:
    ca = None
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
""" + ("" if NO_PICTURES else "camera: {width: 16, height: 16}\n")


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


@unittest.skipIf(ca is None, "the module was not built")
class Module(DatasetTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.opened = ca.open(cls.dataset)

    def test_rows_are_those_of_h5py_in_any_order(self):
        for name in ("audio", "mel", "id", "shape_index"):
            column, stored = self.opened[name], self.columns[name]
            self.assertEqual((column.shape, column.type), (stored.shape, str(stored.dtype)))
            for rows in (slice(None), slice(5, 40, 3), slice(None, None, -1), [7, 3, 3, 30], [], -1, 12,
                         self.columns["material"] == "wood"):
                numpy.testing.assert_array_equal(column[rows], stored[rows])
            for axes in ((3, 0), (slice(2, 9), 0), (slice(None), slice(0, 2)) if stored.ndim > 1 else (slice(None),),
                         ([[1, 2], [5, 0]],), ((0, 1),), ([0, 1], [0, 1]), (0, slice(None), [1, 2]), (numpy.array([4, 1]), slice(None)), (Ellipsis, 0), (-1,), ()):
                if len(axes) <= stored.ndim:
                    numpy.testing.assert_array_equal(column[axes], stored[axes])
            numpy.testing.assert_array_equal(column[numpy.array([[1, 2], [5, 0]])], stored[[[1, 2], [5, 0]]])
            self.assertEqual(type(column[3]), type(stored[3]))
        texts = self.opened["material"][:]
        texts[0] = "none"
        self.assertEqual(self.opened["material"][0], self.columns["material"][0])
        self.assertEqual(list(self.opened["key"][3:5]), list(self.columns["key"][3:5]))
        for name in ("split_shape", "split_strike"):
            numpy.testing.assert_array_equal(self.opened.rows("train", name.removeprefix("split_")),
                                             self.rows(name, "train"))
        self.assertEqual(self.opened.rate, 22050)
        self.assertEqual(self.opened["audio"].attributes["unit"], "m/s")
        how = {name: self.opened["mel"].attributes[name] for name in ("hop", "fft_size")}
        numpy.testing.assert_array_equal(
            ca.mel(self.opened["audio"][3], self.opened.rate, bands=16, **how), self.opened["mel"][3])

    def test_what_is_not_there_is_named(self):
        for call, error, words in ((lambda: self.opened["adio"], KeyError, r"it has \S+.*, audio,"),
                                   (lambda: self.opened["audio"][10000], IndexError, "10000 is out of bounds"),
                                   (lambda: self.opened["audio"][[0, -10000]], IndexError, "-10000 is out of bounds"),
                                   (lambda: self.opened["audio"][[True, False]], IndexError, "boolean index"),
                                   (lambda: self.opened.rows("tests"), ca.InputError, "train, validation, test"),
                                   (lambda: self.opened.rows("test", "room"), ca.InputError, "split of 'room'"),
                                   (lambda: ca.open(self.folder), ca.InputError, "no dataset")):
            with self.assertRaisesRegex(error, words):
                call()

    def test_a_dataset_stays_where_it_was_when_the_folder_changes(self):
        with contextlib.chdir(self.folder):
            opened = ca.open("carillon-demo/smoke")
        numpy.testing.assert_array_equal(opened["audio"][3], self.columns["audio"][3])

    def test_a_table_of_pandas(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("needs python3-pandas")
        table = self.opened.table()
        self.assertEqual(len(table), self.opened.samples)
        self.assertEqual(list(table["material"]), list(self.columns["material"]))
        self.assertNotIn("mel", table)

    @pictures
    def test_the_page(self):
        names = self.run_block(docs_block("python.md", "python", 'dataset["audio"][7]'))
        train = self.rows("split_shape", "train")
        self.assertEqual(list(names["materials"]), list(self.columns["material"][train]))
        numpy.testing.assert_array_equal(names["voxels"], self.voxels[self.columns["shape_index"][train]])
        self.assertEqual(names["frames"].shape, (len(train), 1, 16, 16, 3))


class Lost(DatasetTest):
    """A shard that is lost or cut off stops what would read it, and is named."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.shard = sorted(path.name for path in (cls.dataset / "samples").iterdir())[2]
        cls.gone, cls.short = cls.folder / "gone", cls.folder / "short"
        for folder in (cls.gone, cls.short):
            shutil.copytree(cls.dataset, folder)
        (cls.gone / "samples" / cls.shard).unlink()
        path = cls.short / "samples" / cls.shard
        path.write_bytes(path.read_bytes()[:path.stat().st_size // 2])

    def test_stops_the_commands(self):
        training = ("train: {epochs: 1, tasks: {material: {column: material}}, methods: {nearest-neighbour-a: {}}}\n"
                    "evaluate: {classification: {}}\n")
        for folder in (self.gone, self.short):
            learn = self.write(f"{folder.name}.yaml", f"data: {folder}\n{training}")
            commands = [("report", folder, "-o", self.folder / "page.html"),
                        ("export", folder, "--format", "wav", "-o", self.folder / f"{folder.name}-wav")]
            if (pathlib.Path(CARILLON).parent / "carillon-learn").exists():
                commands += [("train", learn, "-o", self.folder / "trained"),
                             ("evaluate", learn, "-o", self.folder / "evaluated")]
            for command in commands:
                with self.subTest(command=command[0], folder=folder.name):
                    done = run(*command)
                    self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                    self.assertIn(self.shard, done.stderr)

    def test_is_no_number_to_h5py(self):
        with h5py.File(self.gone / "index.h5") as index:
            lost = numpy.isnan(index["audio"][:]).all(1)
        numpy.testing.assert_array_equal(lost, self.columns["shape"] == self.shard.rpartition("-")[0])
        self.assertGreater(lost.sum(), 0)
        self.assertFalse(numpy.isnan(self.columns["audio"]).any())

    @unittest.skipIf(ca is None or torch is None, "needs the module and Debian's python3-torch")
    def test_stops_the_loader(self):
        for folder in (self.gone, self.short):
            dataset = ca.open(folder)
            with self.assertRaisesRegex(ca.FileError, re.escape(self.shard)):
                dataset["audio"][:]
            samples = dataset.torch("train", data="mel")
            samples.rows = samples._places = numpy.arange(dataset.samples, dtype=numpy.uint64)
            samples.labels = None
            for workers in (0, 1):
                with self.assertRaisesRegex(Exception, re.escape(self.shard)):
                    list(DataLoader(samples, 8, num_workers=workers))


@unittest.skipIf(ca is None or torch is None, "needs the module, and Debian's python3-torch and python3-soundfile")
class Torch(DatasetTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.opened = ca.open(cls.dataset)

    def struck(self, part="train", of="shape", **options):
        return ca.open(self.dataset).torch(part, of=of, **options)

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
                    self.expect_epochs(self.struck(of=split.removeprefix("split_")), split, "train", context)

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
        for context in ("fork", "spawn"):
            self.expect_epochs(data, "split_shape", "train", context)
        numpy.testing.assert_array_equal(data[0][0], first)

    def test_a_worker_opens_files_of_its_own(self):
        from carillon.torch_data import Samples

        class Probe(Samples):
            """Tells which process opened what it reads from."""
            def __getitem__(self, i):
                super().__getitem__(i)
                return self.dataset._process, os.getpid()

        data = Probe(ca.open(self.dataset), self.rows("split_shape", "train"), "material", "audio", None)
        self.assertEqual(data[0], (os.getpid(), os.getpid()))
        seen = [(int(opened), int(worker)) for opened, worker in
                DataLoader(data, batch_size=None, num_workers=2, multiprocessing_context="fork")]
        self.assertEqual({opened for opened, _ in seen}, {worker for _, worker in seen})
        self.assertNotIn(os.getpid(), {worker for _, worker in seen})

    def test_batches_that_are_read_in_one_go_are_those_of_single_samples(self):
        dataset = ca.open(self.dataset)
        for context in (None, "fork", "spawn"):
            workers = {} if context is None else {"num_workers": 2, "multiprocessing_context": context}
            pairs = [pair for batch in zip(*dataset.loader("test", batch_size=7, **workers)) for pair in batch]
            sounds, labels = torch.cat(pairs[:len(pairs) // 2]), torch.cat(pairs[len(pairs) // 2:])
            single = self.struck("test")
            self.assertEqual(len(sounds), len(single))
            for i, (sound, label) in enumerate(single[j] for j in range(len(single))):
                numpy.testing.assert_array_equal(sounds[i], sound)
                self.assertEqual(labels[i], label)
        numpy.testing.assert_array_equal(single[-1][0], single[len(single) - 1][0])
        self.assertEqual(sum(len(batch) for batch in dataset.loader("train", label=None)), len(self.struck()))
        train = dataset.loader("train", batch_size=5, drop_last=True)
        self.assertNotEqual(*(numpy.concatenate([m for _, m in train]).tolist() for _ in range(2)))

    def test_objects_columns_and_numbers_as_labels(self):
        voxels, shapes = ca.open(self.dataset).torch("test", data="shapes/voxels", label="shape_index")[[1, 0]]
        rows = self.rows("split_shape", "test")[[1, 0]]
        numpy.testing.assert_array_equal(voxels, self.voxels[self.columns["shape_index"][rows]])
        numpy.testing.assert_array_equal(shapes, self.columns["shape_index"][rows].astype(int))
        with self.assertRaisesRegex(ca.InputError, "holds texts"):
            self.struck(data="material")
        with self.assertRaisesRegex(ca.InputError, "no listener 3"):
            self.struck(listener=3)

    def test_numbers_as_labels_keep_their_fractions_and_whole_ones_their_digits(self):
        rows = self.rows("split_shape", "train")
        by_column = {name: self.opened[name][:] for name in ("impulse", "id", "position")}
        for name in ("impulse", "id"):
            samples = self.opened.torch(label=name)
            self.assertEqual(samples[1][1], by_column[name].view(samples.labels.numpy().dtype)[rows[1]])
            numpy.testing.assert_array_equal(samples[:][1].numpy().view(by_column[name].dtype), by_column[name][rows])
        numpy.testing.assert_array_equal(self.opened.torch(label="position")[2][1], by_column["position"][rows[2]])
        bodies = self.opened.torch(label="shapes/voxels")
        numpy.testing.assert_array_equal(bodies[3][1], self.voxels[self.columns["shape_index"][rows[3]]])

    def test_any_number_is_an_index(self):
        samples = self.opened.torch()
        for three in (numpy.int64(3), torch.tensor(3), numpy.array(3), 3 - len(samples)):
            self.assertTrue(torch.equal(samples[three][0], samples[3][0]))
        for some in (slice(2, 5), torch.tensor([2, 3, 4]), numpy.arange(2, 5), range(2, 5)):
            self.assertTrue(torch.equal(samples[some][0], torch.stack([samples[i][0] for i in (2, 3, 4)])))
        for wrong in (len(samples), -len(samples) - 1):
            with self.assertRaises(IndexError):
                samples[wrong]
        with self.assertRaises(IndexError):
            samples[1.5]

    def test_orders_can_be_repeated_and_given(self):
        def labels(**options):
            return [x for _, batch in self.opened.loader("train", "id", "mel", batch_size=5, **options)
                    for x in batch.numpy().view(numpy.uint64)]
        one, two, other = (labels(generator=torch.Generator().manual_seed(seed)) for seed in (1, 1, 2))
        self.assertEqual(one, two)
        self.assertNotEqual(one, other)
        rows = self.columns["id"][self.rows("split_shape", "train")]
        self.assertEqual(labels(sampler=[3, 0, 3]), [rows[i] for i in (3, 0, 3)])
        with self.assertRaisesRegex(ca.InputError, "both give the order"):
            self.opened.loader(sampler=[0], shuffle=True)

    def test_other_columns(self):
        data = self.struck("test", label="shape", data="mel")
        for i, row in enumerate(self.rows("split_shape", "test")):
            numpy.testing.assert_array_equal(data[i][0], self.columns["mel"][row])
            self.assertEqual(data.classes[data[i][1]], self.columns["shape"][row])

    def test_the_loop_as_it_stands(self):
        names = self.run_block(docs_block("python.md", "python", "for mel, material in loader"))
        self.assertEqual(names["mel"].shape[1:], self.columns["mel"].shape[1:])
        numpy.testing.assert_array_equal(names["sounds"], self.columns["audio"][self.rows("split_shape", "train")[0]])
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
        data = ca.open(self.folder / "int16").torch("train")
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
