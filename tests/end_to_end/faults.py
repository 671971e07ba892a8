"""Faults of files and disks: named in one line, and mended by computing again where that is possible."""
import os
import shutil
import subprocess
import unittest

from interrupted import TASKS, InterruptedTest, recorded
from program import CARILLON
from same import hashes

SHARD = "samples/tile-000-0000.h5"
MODES = "modes/tile-000.h5"


def flip(path, keep_time):
    times = path.stat()
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(bytes(data))
    if keep_time:
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


class Faults(InterruptedTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.expected = hashes(cls.whole)

    def build(self, output, ranks=None, settings=()):
        command = [CARILLON, "build", str(self.config), "-o", str(output)]
        for setting in settings:
            command += ["--set", setting]
        if ranks:
            command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
        return subprocess.run(command, capture_output=True, text=True, timeout=300)

    def mended(self, name, damage, told, tasks):
        """`damage` is done to a whole dataset; the next run says so and repairs it."""
        with self.subTest(name):
            output = self.folder / name
            shutil.copytree(self.whole, output)  # times of change are kept
            damage(output)
            result = self.build(output)
            self.assertEqual(result.returncode, 0, result.stderr)
            lines = [line for line in result.stderr.splitlines() if told in line]
            self.assertEqual(len(lines), 1, result.stderr)
            if tasks:
                self.assertIn(f"{tasks} tasks run", result.stdout)
            self.assertEqual(hashes(output), self.expected)
            again = self.build(output)
            self.assertNotIn("runs again", again.stderr)
            self.assertIn("nothing to do", again.stdout)
            shutil.rmtree(output)

    def test_files_that_are_damaged(self):
        again = "samples/tile-000-0000 runs again"
        self.mended("deleted", lambda o: (o / SHARD).unlink(), f"{SHARD} is missing: {again}", 1)
        self.mended("truncated", lambda o: os.truncate(o / SHARD, 1000),
                    f"{SHARD} has 1000 bytes instead of", 1)
        for keep_time in (False, True):
            self.mended(f"byte-{keep_time}", lambda o: flip(o / SHARD, keep_time),
                        f"{SHARD} has changed (its SHA-256 is not the listed one): {again}", 1)
        self.mended("modes", lambda o: flip(o / MODES, False),
                    f"{MODES} has changed (its SHA-256 is not the listed one): modes/tile-000 runs", 1)
        sound = next((self.whole / "sounds").rglob("*.wav")).relative_to(self.whole)
        self.mended("wav", lambda o: (o / sound).unlink(), f"{sound} is missing: samples/", 1)

    def test_what_is_made_from_the_shards_is_made_again(self):
        for name in ("index.h5", "dataset.json", "failures.json"):
            for damage in (lambda p: p.unlink(), lambda p: os.truncate(p, 1), lambda p: flip(p, True)):
                output = self.folder / "made"
                shutil.copytree(self.whole, output)
                damage(output / name)
                self.assertEqual(self.build(output).returncode, 0)
                self.assertEqual(hashes(output), self.expected)
                shutil.rmtree(output)

    def test_a_damaged_journal_costs_the_task_of_its_line(self):
        def damage(output):
            journal = output / "journal.jsonl"
            lines = journal.read_text().splitlines(keepends=True)
            lines[3] = "\0" * 20 + lines[3][20:]
            journal.write_text("".join(lines))
        self.mended("journal", damage, "journal.jsonl:4 was damaged", 1)

    def test_a_lost_configuration_is_written_again(self):
        self.mended("configuration", lambda o: (o / "configuration.yaml").unlink(),
                    "configuration.yaml is missing", 0)

    def test_results_of_another_configuration_are_not_taken_for_ours(self):
        output = self.folder / "other"
        shutil.copytree(self.whole, output)
        (output / "configuration.yaml").unlink()
        settings = ("strikes.impulse=[1 mN s, 2 mN s]", "strikes.per_object=1")
        result = self.build(output, settings=settings)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"{TASKS} tasks run", result.stdout)

    def expect_full(self, result, output, done):
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("cannot be written", result.stderr)
        self.assertIn("run the same command again", result.stderr)
        self.assertNotIn("terminate called", result.stderr)
        # A full disk is no failure of a task, and what was done before it is kept.
        self.assertEqual(self.build(output).returncode, 0)
        self.assertEqual(hashes(output), self.expected)
        self.assertEqual(set(recorded(output).values()), {1})
        self.assertGreaterEqual(len(recorded(output)), len(done))

    def fill(self, fraction, ranks):
        """A build on a disk that holds `fraction` of what it writes, and its end when there is room."""
        disk = self.folder / f"disk-{fraction}-{ranks}"
        disk.mkdir()
        kilobytes = int(fraction * sum(p.stat().st_size for p in self.whole.rglob("*.*"))) // 1024
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "none", str(disk)],
                          capture_output=True).returncode != 0:
            self.skipTest("mounting a small disk takes root")
        try:
            output = disk / "out"
            result = self.build(output, ranks)
            self.assertIn("No space left on device", result.stderr)
            self.assertEqual(list(output.rglob(".*tmp*")), [])
            subprocess.run(["mount", "-o", "remount,size=1g", str(disk)], check=True)
            self.expect_full(result, output, recorded(output))
        finally:
            subprocess.run(["umount", str(disk)], check=True)

    def test_a_full_disk(self):
        for fraction, ranks in ((0.5, 2), (0.8, None), (0.02, None)):
            with self.subTest(fraction=fraction, ranks=ranks):
                self.fill(fraction, ranks)

    def test_folders_that_cannot_be_written_to(self):
        (self.folder / "file").write_text("x")
        for output in (self.folder / "file", self.folder / "file" / "below"):
            result = self.build(output)
            self.assertEqual(result.returncode, 2)
            self.assertIn(f"{output}: ", result.stderr)
            self.assertIn("hint:", result.stderr)

    def test_a_read_only_disk(self):
        disk = self.folder / "read-only"
        shutil.copytree(self.whole, disk / "out")
        if subprocess.run(["mount", "--bind", str(disk), str(disk)],
                          capture_output=True).returncode != 0:
            self.skipTest("mounting takes root")
        try:
            subprocess.run(["mount", "-o", "remount,ro,bind", str(disk)], check=True)
            for ranks in (None, 2):
                result = self.build(disk / "out", ranks)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn("Read-only file system", result.stderr)
        finally:
            subprocess.run(["umount", str(disk)], check=True)


if __name__ == "__main__":
    unittest.main()
