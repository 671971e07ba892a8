"""A start reads each mesh file once, however many ranks and variants of a sweep there are."""
import ctypes
import json
import os
import struct
import unittest

from program import FolderTest, run, run_json
from small_dataset import write_obj

CONFIG = """
name: reads
objects:
  - mesh: meshes/*.obj
    length: 6 cm
materials: [steel]
strikes: {per_object: 1}
"""
SEEDS = """
sweep: {mode: grid, keys: {seed: [1, 2, 3, 4, 5]}}
"""


IN_OPEN, IN_CLOSE_NOWRITE = 0x20, 0x10


class Opened:
    """How often a file has been opened since, as the kernel (inotify) tells."""

    def __init__(self, path):
        self.libc = ctypes.CDLL(None, use_errno=True)
        self.queue = self.libc.inotify_init1(os.O_NONBLOCK)
        # The kernel joins events that are alike and follow each other: closing parts them.
        events = IN_OPEN | IN_CLOSE_NOWRITE
        if self.libc.inotify_add_watch(self.queue, str(path).encode(), events) < 0:
            raise unittest.SkipTest("no inotify")

    def count(self):
        header = struct.Struct("iIII")
        count = 0
        try:
            while data := os.read(self.queue, 1 << 16):
                while data:
                    _, event, _, name_length = header.unpack_from(data)
                    count += event & IN_OPEN != 0
                    data = data[header.size + name_length:]
        except BlockingIOError:
            return count


class MeshReads(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.meshes = cls.folder / "meshes"
        cls.meshes.mkdir()
        for number in range(3):
            write_obj(cls.meshes / f"block{number}.obj", [0.06, 0.03, 0.02 + 0.003 * number])
        cls.one = cls.write(cls, "one.yaml", CONFIG)
        cls.sweep = cls.write(cls, "sweep.yaml", CONFIG + SEEDS)

    def opened(self, *arguments, ranks=None):
        """The sum over two files, which two ranks share."""
        files = [Opened(self.meshes / f"block{number}.obj") for number in (0, 1)]
        run_json(*arguments, ranks=ranks)
        return sum(file.count() for file in files)

    def test_once_on_all_ranks(self):
        alone = self.opened("plan", self.one)
        self.assertGreater(alone, 0)
        self.assertEqual(self.opened("plan", self.one, ranks=3), alone)

    def test_once_for_all_variants(self):
        alone = self.opened("plan", self.one)
        # Once more for the names of what variants share.
        self.assertLessEqual(self.opened("plan", self.sweep), alone + 2)
        self.assertLessEqual(self.opened("plan", self.sweep, ranks=2), alone + 4)

    def test_ranks_plan_alike(self):
        plan = run_json("plan", self.one)
        self.assertEqual(plan["shapes"], 3)
        self.assertEqual(run_json("plan", self.one, ranks=2), plan)
        whole, part = (self.folder / name for name in ("whole", "part"))
        run_json("build", self.one, "-o", whole)
        run_json("build", self.one, "-o", part, ranks=3)
        one, three = (json.loads((f / "dataset.json").read_text()) for f in (whole, part))
        self.assertEqual(one["shapes"], three["shapes"])
        self.assertEqual(one["files"], three["files"])

    def test_errors_speak_of_the_configuration(self):
        for ranks in (None, 2):
            result = run("plan", self.one, "--set", "objects[0].mesh=none*.obj", ranks=ranks)
            self.assertEqual(result.returncode, 2)
            self.assertIn("objects[0].mesh: nothing matches", result.stderr)
            paths = self.write("paths.yaml", CONFIG + SEEDS.replace(
                "seed: [1, 2, 3, 4, 5]", "'objects[0].mesh': [meshes/block0.obj, none.obj]"))
            result = run("plan", paths, ranks=ranks)
            self.assertEqual(result.returncode, 2)
            self.assertIn("objects[0].mesh: nothing matches", result.stderr)
            self.assertIn("(sweep, variant ", result.stderr)

    def test_a_file_that_one_rank_cannot_read(self):
        bad = self.meshes / "zz.obj"  # EIO, for root too
        bad.symlink_to("/proc/self/mem")
        try:
            for ranks in (None, 2):
                result = run("plan", self.one, ranks=ranks)
                self.assertEqual(result.returncode, 2)
                self.assertEqual(result.stderr.count("zz.obj"), 1, result.stderr)
        finally:
            bad.unlink()


if __name__ == "__main__":
    unittest.main()
