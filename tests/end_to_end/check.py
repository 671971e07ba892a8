"""carillon check: an intact dataset passes, and each damage is found by the check that names it."""
import fcntl
import hashlib
import json
import shutil
import unittest

import h5py
import numpy
from program import FolderTest, run, run_json
from small_dataset import write_inputs


class Check(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = write_inputs(cls.folder)
        cls.config.write_text(cls.config.read_text() + "voxels: {resolution: 12}\n")
        cls.intact = cls.folder / "intact"
        run_json("build", cls.config, "-o", cls.intact)
        with h5py.File(cls.intact / "index.h5") as index:
            cls.rows = {name: index[name].asstr()[()] if h5py.check_string_dtype(index[name].dtype)
                        else index[name][()] for name in index if name not in ("shapes", "audio")}

    def setUp(self):
        self.output = self.folder / self.id().rsplit(".", 1)[-1]
        shutil.copytree(self.intact, self.output)

    def check(self, ranks=None):
        result = run("check", self.output, "--json", ranks=ranks)
        report = json.loads(result.stdout)
        self.assertEqual(result.returncode, 0 if report["passed"] else 3, result.stderr)
        return report

    def find(self, name, report=None):
        return next(c for c in (report or self.check())["checks"] if c["name"] == name)

    def list_again(self):
        """Enters every file's checksum as it is now, as a forger would."""
        path = self.output / "dataset.json"
        description = json.loads(path.read_text())
        for file in description["files"]:
            data = (self.output / file["path"]).read_bytes()
            file.update(sha256=hashlib.sha256(data).hexdigest(), bytes=len(data))
        path.write_text(json.dumps(description, indent=2))

    def expect(self, *failing, listed=True, may=()):
        """These checks fail and no other (but those that may); the first one's items as a text."""
        if listed:
            self.list_again()
        report = self.check()
        found = {c["name"] for c in report["checks"] if c["verdict"] == "fail"}
        self.assertEqual(found - set(may), set(failing), report)
        first = self.find(failing[0], report)
        self.assertTrue(first["text"] and first["remedy"])
        return "\n".join(first["items"])

    def shard(self, name="bar-000"):
        return h5py.File(self.output / "samples" / f"{name}-0000.h5", "r+")

    def two_rows(self, split):
        """Shards and rows of two samples in different parts of a split."""
        places = {}
        for row, part in enumerate(self.rows[split]):
            shape = self.rows["shape"][row]
            places.setdefault(part, (shape, row - list(self.rows["shape"]).index(shape)))
        self.assertGreater(len(places), 1)
        return list(places.values())[:2]

    def test_intact(self):
        report = self.check()
        self.assertEqual({c["name"] for c in report["checks"] if c["verdict"] != "pass"},
                         {"publication", "pitches"}, report)
        self.assertEqual(report["samples"], 60)
        self.assertEqual({c["name"] for c in report["checks"]}, {
            "configuration", "counts", "schema", "checksums", "description", "index", "ids", "values", "clipping",
            "silence", "split_shape", "split_strike", "rooms", "noise", "failures", "warnings", "pitches", "files", "publication"})
        self.assertIn("5 of them distinct", self.find("split_shape", report)["text"])
        self.assertEqual(report, self.check(ranks=2))

    def test_from_the_folder_alone(self):
        elsewhere = self.folder / "elsewhere"
        elsewhere.mkdir()
        shutil.move(self.output, elsewhere / "data")
        result = run("check", "data", cwd=elsewhere)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("checksums", result.stdout)

    def test_not_a_dataset(self):
        result = run("check", self.folder / "meshes")
        self.assertEqual(result.returncode, 2)
        self.assertIn("is no dataset", result.stderr)

    def test_changed_byte(self):
        path = self.output / "modes" / "bar-001.h5"
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1
        path.write_bytes(data)
        self.assertIn("modes/bar-001.h5", self.expect("checksums", listed=False))

    def test_lost_shard(self):
        (self.output / "samples" / "bar-002-0000.h5").unlink()
        self.assertIn("bar-002-0000.h5", self.expect("counts", "checksums", "index", listed=False))
        # The remedy that it names.
        run_json("build", self.config, "-o", self.output)
        self.assertTrue(self.check()["passed"])

    def test_truncated_shard(self):
        path = self.output / "samples" / "bar-002-0000.h5"
        path.write_bytes(path.read_bytes()[:-2000])
        self.assertIn("bar-002-0000.h5", self.expect("checksums", "schema", "index", listed=False))

    def test_unreadable_files(self):
        shard, modes = "samples/bar-002-0000.h5", "modes/bar-001.h5"
        # A file of no bytes whose reading fails (EIO), for root too.
        for name in (shard, modes, "failures.json", "journal.jsonl"):
            (self.output / name).unlink()
            (self.output / name).symlink_to("/proc/self/mem")
        path = self.output / "dataset.json"
        data = json.loads(path.read_text())
        for file in data["files"]:
            if file["path"] in (shard, modes):
                file["bytes"] = 0
        path.write_text(json.dumps(data))
        for ranks in (None, 2):
            report = self.check(ranks=ranks)
            items = self.find("checksums", report)["items"]
            for name in (shard, modes):
                self.assertTrue([i for i in items if i.startswith(f"{name} cannot be read")], items)
            failed = {c["name"] for c in report["checks"] if c["verdict"] == "fail"}
            self.assertEqual(failed, {"checksums", "schema", "index", "failures"})

    def test_a_folder_for_a_shard(self):
        path = self.output / "samples" / "bar-002-0000.h5"
        path.unlink()
        path.mkdir()
        items = self.expect("checksums", "counts", "index", listed=False)
        self.assertIn("bar-002-0000.h5 cannot be read: Is a directory", items)

    def test_lost_column(self):
        with self.shard() as shard:
            del shard["impulse"]
        self.assertIn("impulse: is missing", self.expect("schema", "index"))

    def test_foreign_column(self):
        with self.shard() as shard:
            shard["colour"] = shard["size"][()]
            shard["colour"].attrs["unit"] = "1"
        self.assertIn("colour: is no column", self.expect("schema", "index"))

    def test_other_type(self):
        with self.shard() as shard:
            values, unit = shard["gain"][()], shard["gain"].attrs["unit"]
            del shard["gain"]
            shard["gain"] = values.astype("float32")
            shard["gain"].attrs["unit"] = unit
        self.assertIn("gain: holds float32, not float64", self.expect("schema", "index"))

    def test_other_unit(self):
        with self.shard() as shard:
            shard["contact_time"].attrs["unit"] = "ms"
        self.assertIn('contact_time: is in "ms", not s', self.expect("schema", "index"))

    def test_rows_missing(self):
        with self.shard() as shard:
            values, unit = shard["room"][()], shard["room"].attrs["unit"]
            del shard["room"]
            shard["room"] = values[:-1]
            shard["room"].attrs["unit"] = unit
        self.assertIn("room: 11 rows, not 12", self.expect("schema", "index"))

    def test_index(self):
        with h5py.File(self.output / "index.h5", "r+") as index:
            index["shape_index"][3] = 2
        self.assertIn("row 3", self.expect("index"))
        (self.output / "index.h5").unlink()
        self.expect("index")

    def test_index_joined_otherwise(self):
        with h5py.File(self.output / "index.h5", "r+") as index:
            sources = index["room"].virtual_sources()
            layout = h5py.VirtualLayout(index["room"].shape, index["room"].dtype)
            row, last = 0, sources[-1]
            for source in [last, *sources[:-1]]:
                begin, end = source.vspace.get_select_bounds()
                count = end[0] - begin[0] + 1
                layout[row:row + count] = h5py.VirtualSource(source.file_name, "room", (count,))
                row += count
            del index["room"]
            index.create_virtual_dataset("room", layout)
            index["room"].attrs["unit"] = "1"
        self.assertIn("room: block 0", self.expect("index"))

    def test_index_of_other_bodies(self):
        def body_split(index):
            splits = index["shapes/split_shape"]
            splits[1] = "test" if splits.asstr()[1] != "test" else "train"
            return "shapes/split_shape: row 1"

        def family(index):
            index["shapes/family"][0] = "bell"
            return 'shapes/family: row 0 is bell, not bar'

        def modes_file(index):
            index["shapes/modes_file"][2] = "modes/bar-001.h5"
            return "shapes/modes_file: row 2"

        def voxels(index):
            values = index["shapes/voxels"][()]
            del index["shapes/voxels"]
            values[0, 3, 3, 3] ^= 1
            index["shapes/voxels"] = values
            return "shapes/voxels: joins 0 files"

        def pitch(index):
            values = index["shapes/voxel_pitch"][()]
            layout = h5py.VirtualLayout(values.shape, values.dtype)
            for row in range(len(values)):
                layout[row:row + 1] = h5py.VirtualSource("modes/bar-000.h5", "voxel_pitch", (1,))
            del index["shapes/voxel_pitch"]
            index.create_virtual_dataset("shapes/voxel_pitch", layout)
            return "shapes/voxel_pitch: block 1 is 1 rows of modes/bar-000.h5"

        def mel(index):
            index["mel"].attrs["unit"] = "dB"
            return 'mel@unit: is "dB"'

        def mel_definition(index):
            hop = index["mel"].attrs["hop"]
            index["mel"].attrs["hop"] = hop + 1
            return f"mel@hop: is {hop + 1}, not {hop}"

        def rate(index):
            del index.attrs["sample_rate_hz"]
            return "@sample_rate_hz: is missing"

        def foreign(index):
            index["shapes/colour"] = [1, 2]
            return "shapes/colour: does not belong there"

        for damage in (body_split, family, modes_file, voxels, pitch, mel, mel_definition, rate,
                       foreign):
            with self.subTest(damage.__name__):
                shutil.copy(self.intact / "index.h5", self.output / "index.h5")
                with h5py.File(self.output / "index.h5", "r+") as index:
                    item = damage(index)
                self.assertIn(item, self.expect("index"))
        run_json("build", self.config, "-o", self.output)  # the remedy that it names
        self.assertTrue(self.check()["passed"])

    def test_index_laid_out_otherwise(self):
        path = self.output / "index.h5"
        with h5py.File(path, "r+") as index:
            index["shapes/family"][0] = "bar"  # what stands there
        self.assertNotEqual(path.read_bytes(), (self.intact / "index.h5").read_bytes())
        self.assertTrue(self.check()["passed"])

    def test_description(self):
        def density(data):
            data["materials"][0]["density_kg_m3"] *= 1.01
            return "materials/0/density_kg_m3: is "

        def split(data):
            data["shapes"][2]["split_shape"] = "nowhere"
            return 'shapes/2/split_shape: is "nowhere", not "'

        def request(data):
            data["shapes"][0]["request"]["options"]["order"] = 4
            return "shapes/0/request/options/order: is 4, not 2"

        def variant(data):
            data["shapes"][1]["variants"].pop()
            return "shapes/1/variants/-: is missing"

        def seed(data):
            data["seed"] = 5
            return "seed: is 5, not 4"

        def versions(data):
            del data["versions"]
            return "versions: is missing"

        def unlisted(data):
            path = next(f["path"] for f in data["files"] if f["path"].startswith("modes/"))
            data["files"] = [f for f in data["files"] if f["path"] != path]
            return f"files: {path} is missing"

        for damage in (density, split, request, variant, seed, versions, unlisted):
            with self.subTest(damage.__name__):
                data = json.loads((self.intact / "dataset.json").read_text())
                item = damage(data)
                (self.output / "dataset.json").write_text(json.dumps(data))
                self.assertIn(item, self.expect("description", may=("files",)))
        run_json("build", self.config, "-o", self.output)  # the remedy that it names
        self.assertTrue(self.check()["passed"])

    def test_other_versions_are_noted(self):
        path = self.output / "dataset.json"
        data = json.loads(path.read_text())
        data["versions"]["fftw"] = "older"
        path.write_text(json.dumps(data))
        finding = self.find("description")
        self.assertEqual(finding["verdict"], "note", finding)
        self.assertIn('fftw: "older", here "', finding["items"][0])

    def test_published_without_a_journal(self):
        (self.output / "journal.jsonl").unlink()
        (self.output / "trace.json").unlink()
        self.assertTrue(self.check()["passed"])

    def test_doubled_id(self):
        with self.shard() as shard:
            shard["id"][1] = shard["id"][0]
        self.assertIn("one id", self.expect("ids"))

    def test_values(self):
        with self.shard() as shard:
            audio = shard["audio"][4]
            audio[100] = numpy.nan
            shard["audio"][4] = audio
            shard["impulse"][5] = numpy.inf
            shard["peak"][6] *= 1.5
        items = self.expect("values")
        for fault in ("audio holds nan", "impulse holds inf", "peak is"):
            self.assertIn(fault, items)

    def test_silence_is_listed(self):
        with self.shard() as shard:
            shard["audio"][4] = 0
            shard["peak"][4] = 0
        self.list_again()
        finding = self.find("silence")
        self.assertEqual(finding["verdict"], "note")
        self.assertEqual(finding["items"], [self.rows["key"][4]])

    def test_copies_in_two_parts(self):
        part = self.rows["split_shape"][list(self.rows["shape"]).index("copy")]
        other = "test" if part == "train" else "train"
        with self.shard("copy") as shard, h5py.File(self.output / "index.h5", "r+") as index:
            shard["split_shape"][:] = other
            index["split_shape"][self.rows["shape"] == "copy"] = other
        self.assertIn(f"block ({part}) and copy ({other}) are the same shape",
                      self.expect("split_shape", may=("rooms", "noise")))

    def test_shape_in_two_parts(self):
        with self.shard() as shard:
            shard["split_shape"][2] = "test" if self.rows["split_shape"][2] == "train" else "train"
        self.assertIn("bar-000 is in",
                      self.expect("split_shape", "index", may=("rooms", "noise")))

    def test_strike_in_two_parts(self):
        with self.shard() as shard:
            shard["split_strike"][2] = ("test" if self.rows["split_strike"][2] == "train"
                                        else "train")
        self.assertIn("strike 1 of bar-000 is in",
                      self.expect("split_strike", "index", may=("rooms", "noise")))

    def test_one_point_in_two_parts(self):
        parts = self.rows["split_strike"][:12:2]
        other = next(i for i, part in enumerate(parts) if part != parts[0])
        with self.shard() as shard:
            shard["position"][2 * other] = shard["position"][0]
            shard["position"][2 * other + 1] = shard["position"][0]
        self.assertIn("hit the same point", self.expect("split_strike"))

    def test_room_in_two_parts(self):
        for split in ("split_shape", "split_strike"):
            (one, i), (other, j) = self.two_rows(split)
            with self.shard(one) as shard:
                room = shard["room"][i]
            with self.shard(other) as shard:
                before = shard["room"][j]
                shard["room"][j] = room
            self.assertIn(f"room {room} is in split", self.expect("rooms"))
            with self.shard(other) as shard:
                shard["room"][j] = before

    def test_noise_in_two_parts(self):
        (one, i), (other, j) = self.two_rows("split_strike")
        with self.shard(one) as shard:
            name, stretch = shard["noise_source"].asstr()[i].split("; ")[0].rsplit(" ", 1)
        begin, duration = map(float, stretch.split("+"))
        text = f"{name} {begin + 0.6 * duration:.6f}+{duration:.6f}"
        with self.shard(other) as shard, h5py.File(self.output / "index.h5", "r+") as index:
            key = shard["key"].asstr()[j]
            shard["noise_source"][j] = text
            index["noise_source"][list(self.rows["key"]).index(key)] = text
        self.assertIn(name, self.expect("noise"))

    def test_failures(self):
        path = self.output / "failures.json"
        path.write_text('[{"task": "modes/bar-009", "message": "no"}]')
        self.assertIn("is no task", self.expect("failures"))
        path.write_text('[{"task": "samples/bar-000-0000", "message": "no"}]')
        self.assertIn("its file is listed", self.expect("failures"))

    def test_foreign_file(self):
        (self.output / "samples" / "bar-000-0000.h5.old").write_text("")
        self.assertIn("bar-000-0000.h5.old", self.expect("files"))

    def test_edited_configuration(self):
        path = self.output / "configuration.yaml"
        text = path.read_text()
        path.write_text(text.replace("seed: 4", "seed: 4  # of my own"))
        self.expect("configuration")
        path.write_text("objects: [")
        self.assertIn("configuration.yaml:1", self.expect("configuration"))
        path.write_text(text)
        description = self.output / "dataset.json"
        description.write_text(description.read_text().replace('"samples": 60', '"samples": 61'))
        self.assertIn("counts 61", self.expect("counts"))

    def test_changed_inputs_are_noted(self):
        path = self.output / "inputs" / "materials_file"
        path.write_text(path.read_text().replace("1800", "1900"))
        self.assertEqual(self.find("configuration")["verdict"], "note")

    def test_during_a_build(self):
        (self.output / "samples" / "bar-002-0000.h5").unlink()
        with (self.output / ".lock").open() as lock:
            fcntl.flock(lock, fcntl.LOCK_SH)
            report = self.check()
        self.assertTrue(report["building"])
        self.assertIn("a build is going on", self.find("counts", report)["text"])
        self.assertFalse(self.check()["building"])

    def test_clipping_is_counted(self):
        shutil.rmtree(self.output)
        run_json("build", self.config, "-o", self.output, "--set", "audio.dtype=int16", "--set",
                 "audio.gain=5", "--set", "objects[0].count=1")
        with h5py.File(self.output / "index.h5") as index:
            clipped = int((index["clipped"][()] > 0).sum())
        self.assertGreater(clipped, 0)
        finding = self.find("clipping")
        self.assertEqual(finding["verdict"], "note")
        self.assertEqual(len(finding["items"]), clipped)
        with self.shard() as shard:
            shard["clipped"][0] = 100000
        self.assertIn("clipped says 100000", self.expect("values"))


if __name__ == "__main__":
    unittest.main()
