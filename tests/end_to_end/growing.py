"""A configuration that only adds to an old one carries on in its folder: the end is that of a new
build, file by file, and what was there is not computed again."""
import json
import shutil
import subprocess
import unittest

import h5py
import numpy
from interrupted import recorded, wait_for
from program import CARILLON, FolderTest, run, run_json
from same import hashes

OBJECTS = ["{shape: bar, materials: [steel], parameters: {length: 15 cm}}",
           "{shape: tile, materials: [glass], sizes: [1, 1.5]}"]
BLOCK = "{shape: block, materials: [wood]}"


def text(objects, strikes):
    return f"""
name: growing
seed: 6
objects:
{"".join(f"  - {one}" + chr(10) for one in objects)}
modes: {{max_modes: 8, order: 2, element_size: 3 cm, max_frequency: 20 kHz}}
strikes: {{per_object: {strikes}}}
audio: {{seconds: 0.1 s, sample_rate: 22050 Hz}}
noise: {{kind: white, snr: [15 dB, 40 dB]}}
mel: {{bands: 8, frames: 5}}
voxels: {{resolution: 8}}
files: {{wav: true}}
"""


def rows(path):
    """Every column of an index by the samples' keys."""
    with h5py.File(path) as index:
        keys = list(index["key"].asstr()[()])
        return {name: dict(zip(keys, index[name].asstr()[()] if index[name].dtype == object
                               else index[name][()]))
                for name in index if isinstance(index[name], h5py.Dataset)}


class Growing(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "growing.yaml"
        cls.write_config(OBJECTS, 3)
        cls.small = cls.folder / "small"
        run_json("build", cls.config, "-o", cls.small)

    @classmethod
    def write_config(cls, objects, strikes):
        cls.config.write_text(text(objects, strikes))

    def grow(self, name, objects, strikes, tasks, made, same_values=True):
        """@param made  samples that are computed, as the new tasks' traces count them"""
        with self.subTest(name):
            output, fresh = self.folder / name, self.folder / f"{name}-fresh"
            shutil.copytree(self.small, output)
            before = recorded(output)
            self.write_config(objects, strikes)
            summary = run_json("build", self.config, "-o", output, ranks=2)
            expected = run_json("build", self.config, "-o", fresh, ranks=2)
            self.assertEqual(summary["tasks_run"], tasks)
            self.assertEqual(hashes(output), hashes(fresh))
            lines = (output / "journal.jsonl").read_text().splitlines()[sum(before.values()):]
            noise = [json.loads(line)["trace"]["effects"].get("noise") for line in lines]
            self.assertEqual(sum(n["calls"] for n in noise if n), made)
            trace = json.loads((output / "trace.json").read_text())
            self.assertEqual(trace["effects"]["noise"]["calls"], expected["samples"])
            # And by the values, as a reader of both sees them.
            old, new = rows(self.small / "index.h5"), rows(output / "index.h5")
            for column in old:
                for key, value in old[column].items():
                    if column in ("shape_index", "appearance_index"):
                        continue  # a row of shapes/ or appearances/, which may have more before it
                    if same_values or numpy.asarray(value).dtype.kind not in "f":
                        numpy.testing.assert_array_equal(value, new[column][key], column)
                    elif column == "audio":
                        numpy.testing.assert_allclose(value, new[column][key],
                                                      atol=1e-4 * abs(value).max())

    def test_more_strikes(self):
        # 9 samples are there; the shards of both objects are copied and go on.
        self.grow("strikes", OBJECTS, 5, tasks=2, made=2 * 1 + 2 * 2)

    def test_more_bodies(self):
        self.grow("bodies", [OBJECTS[0][:-1] + ", count: 2}", BLOCK, OBJECTS[1]], 3, tasks=4,
                  made=2 * 3)

    def test_more_materials_and_sizes(self):
        # The modes of an object serve all of its materials: that object is computed again as a whole.
        self.grow("materials", [OBJECTS[0].replace("[steel]", "[glass, steel]"), OBJECTS[1]], 3,
                  tasks=2, made=2 * 3, same_values=False)
        self.grow("sizes", [OBJECTS[0], OBJECTS[1].replace("1.5", "1.5, 2")], 3, tasks=2,
                  made=3 * 3, same_values=False)

    def test_everything_at_once_and_killed_on_the_way(self):
        output, fresh = self.folder / "all", self.folder / "all-fresh"
        shutil.copytree(self.small, output)
        lines = sum(recorded(output).values())
        self.write_config([OBJECTS[0], BLOCK, OBJECTS[1].replace("1.5", "1.5, 2")], 4)
        process = subprocess.Popen([CARILLON, "build", str(self.config), "-o", str(output)],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for(lambda: sum(recorded(output).values()) > lines + 1, 60)
        process.kill()
        process.wait()
        run_json("build", self.config, "-o", output)
        run_json("build", self.config, "-o", fresh)
        self.assertEqual(hashes(output), hashes(fresh))

    def test_more_files_that_match(self):
        folder = self.folder / "meshes"
        folder.mkdir()
        cube = ("OFF\n8 6 0\n0 0 0\n%s 0 0\n%s 1 0\n0 1 0\n0 0 1\n%s 0 1\n%s 1 1\n0 1 1\n"
                "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n")
        entry = "{mesh: 'meshes/*.off', name: read, length: 10 cm, materials: [steel]}"
        (folder / "b.off").write_text(cube % (("1.7",) * 4))
        self.write_config([entry], 2)
        output, fresh = self.folder / "files", self.folder / "files-fresh"
        run_json("build", self.config, "-o", output)
        (folder / "a.off").write_text(cube % (("2.3",) * 4))
        self.assertEqual(run_json("build", self.config, "-o", output)["tasks_run"], 2)
        run_json("build", self.config, "-o", fresh)
        self.assertEqual(hashes(output), hashes(fresh))
        (folder / "b.off").write_text(cube % (("1.8",) * 4))
        result = run("build", self.config, "-o", output)
        self.assertEqual(result.returncode, 2)
        self.assertIn("built from other files", result.stderr)

    def test_what_is_not_only_more_is_refused_with_the_difference(self):
        for objects, strikes, settings, told in (
                (OBJECTS, 2, [], "-   per_object: 3"),
                (OBJECTS[:1], 3, [], "-   - shape: tile"),
                (OBJECTS, 4, ["audio.seconds=0.2"], "+   seconds: 0.2  # s"),
                ([OBJECTS[0].replace("15 cm", "16 cm"), OBJECTS[1]], 3, [],
                 "-       length: 0.15  # m"),
                ([OBJECTS[0], OBJECTS[1].replace("1, 1.5", "1.5, 2")], 3, [], "-     sizes: [1, 1.5]")):
            with self.subTest(told):
                before = hashes(self.small)
                self.write_config(objects, strikes)
                overrides = [word for setting in settings for word in ("--set", setting)]
                result = run("build", self.config, "-o", self.small, *overrides)
                self.assertEqual(result.returncode, 2, result.stdout)
                self.assertIn(told, result.stderr)
                self.assertEqual(hashes(self.small), before)


if __name__ == "__main__":
    unittest.main()
