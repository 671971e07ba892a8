"""What `carillon export` publishes: the data card of the Hugging Face Hub, tables whose types are the same in every
part, Lhotse's manifests; the lines of docs/exports.md that read them; whose the outputs are."""
import contextlib
import fnmatch
import io
import json
import shutil
import struct
import tarfile
import unittest
import wave

import h5py
import numpy
import pandas
import yaml
from program import FolderTest, docs_block, run, run_json

try:
    import pyarrow
except ImportError:
    pyarrow = None

# A shape and a material whose names are digits; a damping model with a parameter that the other has not.
CONFIG = """
name: published
dataset: {creator: [A, B], license: ODbL-1.0, description: "Bars: a few", cite_as: "A and B"}
seed: 4
materials_file: own.yaml
materials: ["0012", curved]
objects:
  - {mesh: 007.obj}
  - {shape: tile, count: 2}
modes: {max_modes: 6, order: 2, element_size: 25 mm, max_frequency: 6 kHz}
strikes: {per_object: 8}
audio: {seconds: 0.05 s, sample_rate: 22050 Hz, dtype: int16, gain: 100}
listeners:
  - {position: [0, 0, 0.8 m]}
  - {position: [0.5 m, 0, 0.8 m]}
mel: {bands: 16, frames: 5}
voxels: {resolution: 8}
split: {validation: 0.3, test: 0.3}
"""
OWN = """
"0012": {youngs_modulus: 100 GPa, poisson_ratio: 0.34, density: 8500, alpha1: 5, alpha2: 2e-8 s}
curved: {youngs_modulus: 70 GPa, poisson_ratio: 0.3, density: 2700,
         damping: {model: caughey, alpha1: 3, alpha2: 1e-8 s, alpha3: 1e-19}}
"""
# A block of 200 x 30 x 20 mm.
BLOCK = "".join(f"v {0.2 * (k & 1)} {0.03 * (k >> 1 & 1)} {0.02 * (k >> 2)}\n" for k in range(8)) + "".join(
    f"f {face}\n" for face in ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"))
JSON_TYPES = {"string": str, "int64": int, "float64": float}


def read_lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def read_card(folder):
    """Header and text of README.md."""
    before, header, text = (folder / "README.md").read_text().split("---\n", 2)
    assert before == ""
    return yaml.safe_load(header), text


class Published(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.write(cls, "own.yaml", OWN)
        cls.write(cls, "007.obj", BLOCK)
        cls.dataset = cls.folder / "dataset"
        run_json("build", cls.write(cls, "small.yaml", CONFIG), "-o", cls.dataset)
        cls.wav = cls.export("smoke-wav", "--format", "wav", "--split", "split_strike")
        cls.card, cls.text = read_card(cls.wav)
        cls.tables = {path.parent.name: read_lines(path)
                      for path in cls.wav.glob("*/metadata.jsonl")}
        cls.index = h5py.File(cls.dataset / "index.h5")

    @classmethod
    def tearDownClass(cls):
        cls.index.close()
        super().tearDownClass()

    @classmethod
    def export(cls, name, *arguments, dataset=None):
        run_json("export", dataset or cls.dataset, "-o", cls.folder / name, *arguments)
        return cls.folder / name

    def features(self):
        """Types by name, without the sound's."""
        listed = self.card["dataset_info"]["features"]
        self.assertEqual(listed[0], {"name": "audio", "dtype": "audio"})
        return {feature["name"]: feature["dtype"] for feature in listed[1:]}

    def run_docs(self, *words):
        """What the blocks of docs/exports.md with these words leave behind."""
        names = {}
        with contextlib.chdir(self.folder):
            for word in words:
                exec(docs_block("exports.md", "python", word), names)
        return names

    def test_values_have_the_types_of_the_header(self):
        self.assertEqual(set(self.tables), {"train", "validation", "test"})
        types = self.features()
        self.assertEqual(set(types.values()), set(JSON_TYPES))
        for part, rows in self.tables.items():
            for values in rows:
                self.assertEqual(list(values), ["file_name", *types], part)
                for name, dtype in types.items():
                    if values[name] is not None:
                        self.assertIs(type(values[name]), JSON_TYPES[dtype], name)
                self.assertEqual(values["size"], 1.0)
        self.assertEqual({name for rows in self.tables.values() for values in rows
                          for name, value in values.items() if value is None}, {"alpha3"})

    def test_pandas_finds_the_same_types_in_every_part(self):
        parts = self.run_docs("import pandas")["parts"]
        self.assertEqual(set(parts), set(self.tables))
        types = {"file_name": "object", **self.features()}
        for part, table in parts.items():
            self.assertEqual({name: str(dtype) for name, dtype in table.dtypes.items()}, types, part)
            self.assertEqual(list(table["id"]), [row["id"] for row in self.tables[part]])
            numpy.testing.assert_array_equal(table["impulse"],
                                             [row["impulse"] for row in self.tables[part]])

    def test_types_hold_where_a_part_has_no_value(self):
        result = run("export", self.dataset, "--format", "wav", "--split", "material", "-o",
                     self.folder / "by-material")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("0012 has no value of alpha3, which other parts have", result.stderr)
        card, _ = read_card(self.folder / "by-material")
        types = {one["name"]: one["dtype"] for one in card["dataset_info"]["features"]}
        found = [pandas.read_json(self.folder / "by-material" / part / "metadata.jsonl", lines=True, dtype=types,
                                  convert_dates=False).dtypes for part in ("0012", "curved")]
        self.assertEqual(str(found[0]["alpha3"]), "float64")
        pandas.testing.assert_series_equal(*found)
        # Of the usual parts each has its value: nothing to be said.
        again = run("export", self.dataset, "--format", "wav", "-o", self.folder / "quiet")
        self.assertNotIn("no value of", again.stderr)

    def test_digits_stay_texts(self):
        shards = self.export("digits", "--format", "webdataset")
        told = [row for rows in self.tables.values() for row in rows]
        for path in shards.glob("*.tar"):
            with tarfile.open(path) as tar:
                told += [json.loads(tar.extractfile(name).read()) for name in tar.getnames()
                         if name.endswith(".json")]
        self.assertEqual(len(told), 2 * len(self.index["id"]))
        ids = dict(zip(self.index["key"].asstr()[:], self.index["id"][:]))
        for values in told:
            self.assertEqual(values["id"], str(ids[values["key"]]))
        self.assertLessEqual({"007", "tile-000"}, {values["shape"] for values in told})
        self.assertEqual({values["material"] for values in told}, {"0012", "curved"})

    def test_header_for_the_hub(self):
        self.assertEqual(self.card["license"], "odbl")
        self.assertEqual(self.card["pretty_name"], "published")
        self.assertEqual(self.card["task_categories"], ["audio-classification"])
        self.assertEqual(self.card["size_categories"], ["n<1K"])
        (config,) = self.card["configs"]
        paths = [str(path.relative_to(self.wav)) for path in self.wav.rglob("*") if path.is_file()]
        self.assertEqual([entry["split"] for entry in config["data_files"]],
                         ["train", "validation", "test"])
        for entry in config["data_files"]:
            found = fnmatch.filter(paths, entry["path"])
            self.assertEqual(len(found), 1 + len(self.tables[entry["split"]]))

    def test_header_of_tar_files(self):
        shards = self.export("tar", "--format", "webdataset", "--with", "mel", "voxels", "impulse")
        card, _ = read_card(shards)
        features = {one["name"]: one for one in card["dataset_info"]["features"]}
        with tarfile.open(next(shards.glob("train-*.tar"))) as tar:
            key = tar.getnames()[0].removesuffix(".wav")
            members = {name.removeprefix(key + "."): tar.extractfile(name).read()
                       for name in tar.getnames() if name.startswith(key + ".")}
        self.assertEqual(set(features), {*members, "__key__", "__url__"})
        self.assertEqual({one["name"]: one["dtype"] for one in features["json"]["struct"]},
                         self.features())
        self.assertEqual(list(json.loads(members["json"])), list(self.features()))
        for name in ("mel.npy", "voxels.npy", "impulse.npy"):
            array, feature = numpy.load(io.BytesIO(members[name])), features[name]
            for _ in range(array.ndim):
                feature = feature["sequence"]
            self.assertEqual(feature if array.ndim else feature["dtype"], str(array.dtype), name)
        self.assertEqual(card["configs"][0]["data_files"][0],
                         {"split": "train", "path": "train-*.tar"})

    def test_card_tells_what_the_dataset_is(self):
        self.assertIn("\n# published\n\nBars: a few\n", self.text)
        lines = self.text.splitlines()
        for part, rows in self.tables.items():
            shapes = len({row["shape"] for row in rows})
            self.assertIn(f"| {part} | {len(rows)} | {shapes} |", lines)
        counts = [sum(row["material"] == "0012" for row in self.tables[part])
                  for part in ("train", "validation", "test")]
        self.assertIn("| 0012 | {} | {} | {} |".format(*counts), lines)
        table = self.text.split("## Columns\n")[1].splitlines()
        for name, column in self.index.items():
            if isinstance(column, h5py.Group) or column[:1].size > 16:
                continue
            (line,) = [one for one in table if one.startswith((f"| `{name}` |", f"| `{name}_x`"))]
            unit = column.attrs["unit"]
            self.assertEqual(line.split(" | ")[2], unit)
        self.assertIn("| `impulse` | float64 | N s | of the contact force", self.text)
        self.assertIn("`position_x`, `position_y`, `position_z`", self.text)
        self.assertIn("Do not mix `split_shape` and `split_strike`", self.text)
        self.assertIn("carillon export published --format wav --split split_strike", self.text)
        self.assertIn(json.loads((self.dataset / "dataset.json").read_text())["configuration"],
                      self.text)
        self.assertIn("does not extend to what is made with it", self.text)
        for words in ("\nODbL-1.0.\n", "Made by A, B.", "To be cited as:\n\n```\nA and B\n```\n",
                      "| 0012 | 1e+11 | 0.34 | 8500 |", "| tile | 2 | tile-000, tile-001 |"):
            self.assertIn(words, self.text)

    def test_licences_as_the_hub_names_them(self):
        copy = self.folder / "licences"
        shutil.copytree(self.dataset, copy)
        path = copy / "dataset.json"
        said = json.loads(path.read_text())
        for given, expected in (
                ("", {"license": "unknown"}), ("CC-BY-4.0", {"license": "cc-by-4.0"}),
                ("GPL-3.0-or-later", {"license": "gpl-3.0"}),
                ("https://creativecommons.org/licenses/by-nc/4.0/", {"license": "cc-by-nc-4.0"}),
                ("https://creativecommons.org/publicdomain/zero/1.0/", {"license": "cc0-1.0"}),
                ("Ask the author", {"license": "other", "license_name": "ask-the-author"}),
                ("https://example.org/terms", {"license": "other", "license_name": "see-link",
                                               "license_link": "https://example.org/terms"})):
            said["about"]["license"] = given
            path.write_text(json.dumps(said))
            output = self.export("licensed", "--format", "webdataset", dataset=copy)
            card, text = read_card(output)
            self.assertEqual({name: value for name, value in card.items() if "license" in name},
                             expected)
            self.assertIn(f"{given}.\n" if given else "None was given.", text)
            shutil.rmtree(output)

    def test_events_of_clips(self):
        output = self.export("clips", "--format", "lhotse", "--split", "split_strike")
        keys = self.index["key"].asstr()[:]
        seen = []
        for part, rows in self.tables.items():
            recordings = read_lines(output / f"recordings_{part}.jsonl")
            for recording, event, row in zip(recordings, read_lines(
                    output / f"supervisions_{part}.jsonl"), rows, strict=True):
                expect_recording(self, output, recording)
                expect_event(self, event, recording)
                self.assertEqual((event["start"], event["duration"]), (0, recording["duration"]))
                self.assertEqual(event["channel"], [0, 1])
                self.assertEqual(event["text"], f"{row['shape']} of {row['material']}")
                self.assertEqual(event["custom"], {k: v for k, v in row.items() if k != "file_name"})
                seen.append(recording["id"])
        self.assertEqual(sorted(seen), sorted(keys))
        card, text = read_card(output)
        self.assertEqual(card["license"], "odbl")
        self.assertNotIn("configs", card)
        self.assertIn("supervisions_PART.jsonl", text)
        self.assertEqual((output / "train" / "metadata.jsonl").read_bytes(),
                         (self.wav / "train" / "metadata.jsonl").read_bytes())
        described = json.loads((output / "croissant.json").read_text())["distribution"]
        self.assertLessEqual({"README.md", "recordings_test.jsonl", "supervisions_train.jsonl"},
                             {file["@id"] for file in described})

    @unittest.skipUnless(pyarrow, "Parquet needs pyarrow")
    def test_parquet_by_the_lines_of_the_docs(self):
        from pyarrow import parquet
        self.run_docs("import pandas", "to_parquet")
        folder = self.folder / "smoke-parquet"
        card, _ = read_card(folder)
        self.assertNotIn("configs", card)
        for part, rows in self.tables.items():
            table = parquet.read_table(folder / "data" / f"{part}-00000-of-00001.parquet")
            self.assertEqual(table.column_names, ["audio", *self.features()])
            for sound, row in zip(table["audio"].to_pylist(), rows, strict=True):
                self.assertEqual(sound["bytes"], (self.wav / part / row["file_name"]).read_bytes())


def expect_recording(test, output, recording):
    """The fields of Lhotse's Recording; what they say is what the file holds."""
    test.assertEqual(set(recording), {"id", "sources", "sampling_rate", "num_samples", "duration",
                                      "channel_ids"})
    (source,) = recording["sources"]
    test.assertEqual(set(source), {"type", "channels", "source"})
    test.assertEqual(source["type"], "file")
    with wave.open(str(output / source["source"])) as clip:
        test.assertEqual(clip.getnframes(), recording["num_samples"])
        test.assertEqual(clip.getframerate(), recording["sampling_rate"])
        test.assertEqual(list(range(clip.getnchannels())), source["channels"])
    test.assertEqual(recording["channel_ids"], source["channels"])
    test.assertAlmostEqual(recording["duration"],
                           recording["num_samples"] / recording["sampling_rate"], 12)


def expect_event(test, event, recording):
    """The fields of Lhotse's SupervisionSegment, and what its validation asks."""
    test.assertEqual(set(event), {"id", "recording_id", "start", "duration", "channel", "text",
                                  "custom"})
    test.assertEqual(event["recording_id"], recording["id"])
    test.assertGreater(event["duration"], 0)
    test.assertGreaterEqual(event["start"], 0)
    test.assertLessEqual(event["start"] + event["duration"], recording["duration"] + 1e-9)
    channels = event["channel"] if isinstance(event["channel"], list) else [event["channel"]]
    test.assertLessEqual(set(channels), set(recording["channel_ids"]))


SCENE = """
name: dropped
seed: 3
objects:
  - {shape: tile, name: plate, materials: [ceramic],
     parameters: {length: 200 mm, width: 200 mm, thickness: 20 mm}}
  - {shape: sphere, name: ball, materials: [steel, glass], parameters: {radius: 10 mm}}
modes: {max_modes: 4, order: 1, element_size: 30 mm}
audio: {sample_rate: 16 kHz, seconds: 0.4 s, dtype: int16, gain: 0.02}
listeners: [{position: [0, -0.3 m, 0.2 m]}]
recording: {shift: [0 s, 2 ms]}
motion:
  simulations: 5
  kept_strikes: 20
  ground: {material: wood}
  bodies:
    - {object: plate, at: [0, 0, 15 mm]}
    - {object: ball, at: [0, [-20 mm, 20 mm], 60 mm], velocity: [0, 0, [-1 m/s, -0.5 m/s]]}
split: {validation: 0.2, test: 0.2}
"""


class Events(FolderTest):
    """Strikes of simulations as events of their recordings."""

    def test_strikes_are_events(self):
        dataset, output = self.folder / "dropped", self.folder / "events"
        run_json("build", self.write("scene.yaml", SCENE), "-o", dataset)
        run_json("export", dataset, "--format", "lhotse", "-o", output, ranks=2)
        with h5py.File(dataset / "index.h5") as index:
            rows = {key: row for row, key in enumerate(index["key"].asstr()[:])}
            columns = {name: index[name][()] for name in index
                       if name.startswith("strike") or name == "recording_shift"}
            bodies = [json.loads(text) for text in index["bodies"].asstr()[:]]
        events, recordings = [], {}
        for path in output.glob("recordings_*.jsonl"):
            recordings |= {one["id"]: one for one in read_lines(path)}
            events += read_lines(output / path.name.replace("recordings", "supervisions"))
        self.assertEqual(set(recordings), set(rows))
        for recording in recordings.values():
            expect_recording(self, output, recording)
        self.assertEqual(len({event["id"] for event in events}), len(events))
        self.assertTrue(any("shapes" in event["custom"] and None in event["custom"]["shapes"]
                            for event in events))  # of the ground
        for key, row in rows.items():
            own = [event for event in events if event["recording_id"] == key]
            shift, seconds = columns["recording_shift"][row], recordings[key]["duration"]
            times = columns["strike_time"][row] + shift
            heard = numpy.flatnonzero(times <= seconds - 1 / 16000)
            self.assertGreater(len(heard), 0)
            numpy.testing.assert_array_equal([event["start"] for event in own], times[heard])
            for event, k in zip(own, heard, strict=True):
                expect_event(self, event, recordings[key])
                custom = event["custom"]
                self.assertEqual(custom["strike"], k)
                self.assertEqual(event["duration"], min(
                    max(columns["strike_duration"][row, k], 1 / 16000), seconds - event["start"]))
                self.assertEqual(custom["speed"], columns["strike_speed"][row, k])
                self.assertEqual(custom["impulse"], list(columns["strike_impulse"][row, k]))
                self.assertEqual(custom["point"], list(columns["strike_point"][row, k]))
                pair = [bodies[row][b] for b in columns["strike_bodies"][row, k]]
                self.assertEqual(custom["bodies"], [body["name"] for body in pair])
                self.assertEqual(custom["materials"], [body["material"] for body in pair])
                self.assertEqual(custom["shapes"], [body.get("shape") for body in pair])
                self.assertEqual(event["text"], " on ".join(
                    f"{body['name']} of {body['material']}" for body in pair))


class Instruments(FolderTest):
    """Instruments and models say that they are their makers' own."""

    OBJECT = ("bar", "-m", "steel", "--order", "1", "--element-size", "30 mm")

    def test_faust(self):
        path = self.folder / "bar.dsp"
        run_json("export-faust", *self.OBJECT, "--max-modes", "3", "-o", path)
        text = path.read_text()
        self.assertIn("// This instrument is its maker's own", text)
        self.assertIn('declare license "its maker\'s own; what Carillon puts into it is CC0-1.0";', text)

    def test_gltf(self):
        path = self.folder / "bar.glb"
        run_json("export-gltf", *self.OBJECT, "--modes", "2", "-o", path)
        content = path.read_bytes()
        (length,) = struct.unpack_from("<I", content, 12)
        document = json.loads(content[20:20 + length])
        self.assertTrue(document["asset"]["copyright"].startswith("its maker's own"))


if __name__ == "__main__":
    unittest.main()
