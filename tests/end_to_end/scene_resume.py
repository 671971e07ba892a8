"""Takes whose build is killed, and takes that are added: the end is that of one build left alone."""
import json
import os
import signal
import subprocess
import unittest

import h5py
import numpy

from interrupted import descendants, recorded, wait_for
from moving_scene import SHAPES, SHARDS, TAKES, MovingTest
from program import CARILLON, run, run_json
from same import hashes


def written(folder, *parts):
    """When each file of these folders was written, and which one it is."""
    return {str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.stat().st_ino)
            for part in parts for path in folder.glob(f"{part}/*")}


class SceneResume(MovingTest):
    def kill_when(self, condition, output, *words, ranks=None):
        """Starts a build and kills all of it as soon as the condition holds."""
        command = [CARILLON, "build", str(self.config), "-o", str(output), *words]
        if ranks:
            command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.assertTrue(wait_for(lambda: process.poll() is not None or condition(), 60))
        family = descendants(process.pid)
        for pid in family:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.assertEqual(process.wait(timeout=30), -signal.SIGKILL)

    def assert_whole(self, output):
        """Each task was done once, each effect ran once a take, and the files are the same."""
        self.assertEqual(hashes(output), hashes(self.whole))
        self.assertEqual(set(recorded(output).values()), {1})
        self.assertEqual(len(recorded(output)), SHAPES + SHARDS)
        trace = json.loads((output / "trace.json").read_text())
        for effect in ("motion", "movie", "touch", "noise"):
            self.assertEqual(trace["effects"][effect]["calls"], TAKES, effect)
        self.assertTrue(run_json("check", output)["passed"])

    def test_killed_in_the_middle_of_its_takes(self):
        for ranks in (None, 2):
            with self.subTest(ranks=ranks):
                output = self.folder / f"killed-{ranks}"
                # The first of three takes of a shard has its movie, the shard is not written.
                self.kill_when((output / "movies" / "take-0004.mp4").exists, output, ranks=ranks)
                done = recorded(output)
                self.assertNotIn("samples/takes-0001", done)
                self.assertFalse((output / "samples" / "takes-0001.h5").exists())
                self.assertEqual(sum(task.startswith("modes/") for task in done), SHAPES)
                there = written(output, "samples", "modes")
                summary = run_json("build", self.config, "-o", output)
                self.assertEqual(summary["tasks_run"], SHAPES + SHARDS - len(done))
                now = written(output, "samples", "modes")
                self.assertEqual({name: now[name] for name in there}, there)
                self.assert_whole(output)

    def test_more_takes(self):
        output = self.folder / "grown"
        run_json("build", self.config, "-o", output, "--set", "motion.takes=3")
        with h5py.File(output / "index.h5") as index:
            old = {n: c[()] for n, c in index.items() if isinstance(c, h5py.Dataset)}
        movies = written(output, "movies")
        self.assertEqual(len(movies), 3)
        lines = len((output / "journal.jsonl").read_text().splitlines())
        summary = run_json("build", self.config, "-o", output, ranks=2)
        self.assertEqual(summary["tasks_run"], SHARDS)  # the first of them goes on
        with h5py.File(output / "index.h5") as index:
            for name, values in old.items():
                self.assertEqual(index[name][:3].tobytes() if values.dtype != object
                                 else list(index[name][:3]),
                                 values.tobytes() if values.dtype != object else list(values), name)
        now = written(output, "movies")
        self.assertEqual(set(now), {f"movies/take-{take:04}.mp4" for take in range(TAKES)})
        self.assertEqual({name: now[name] for name in movies}, movies)
        new = [json.loads(line)["trace"]["effects"]
               for line in (output / "journal.jsonl").read_text().splitlines()[lines:]]
        self.assertEqual(sum(effects["motion"]["calls"] for effects in new), TAKES - 3)
        self.assertEqual(hashes(output), hashes(self.whole))
        self.assertTrue(run_json("check", output)["passed"])
        report = run_json("regenerate", output, "--sample", 2, "--sample", 3)
        self.assertEqual([s["identical"] for s in report["samples"]], [True, True])

    def test_more_to_draw_from(self):
        # Who plays is drawn anew then: all takes are made again, but for the bodies' modes.
        for name, settings, file in (("count", ["objects[3].count=3"], None),
                                     ("files", [], "c.obj")):
            with self.subTest(name):
                output, fresh = self.folder / name, self.folder / f"{name}-fresh"
                few = ["--set", "motion.takes=2"]
                run_json("build", self.config, "-o", output, *few)
                if file:
                    text = (self.folder / "meshes" / "a.obj").read_text()
                    (self.folder / "meshes" / file).write_text(text.replace("1.7", "1.9"))
                more = [word for setting in settings for word in ("--set", setting)]
                summary = run_json("build", self.config, "-o", output, *few, *more)
                self.assertEqual(summary["tasks_run"], 2)  # the new body's modes, and the takes
                run_json("build", self.config, "-o", fresh, *few, *more)
                self.assertEqual(hashes(output), hashes(fresh))
                self.assertTrue(run_json("check", output)["passed"])
                if file:
                    (self.folder / "meshes" / file).write_text(text.replace("1.7", "1.8"))
                    result = run("build", self.config, "-o", output, *few)
                    self.assertEqual(result.returncode, 2)
                    self.assertIn("built from other files", result.stderr)
                    (self.folder / "meshes" / file).unlink()

    def test_killed_while_takes_are_added(self):
        output = self.folder / "both"
        run_json("build", self.config, "-o", output, "--set", "motion.takes=2")
        # Within the shard that has two takes and gets two more.
        self.kill_when((output / "movies" / "take-0002.mp4").exists, output)
        checked = run("check", output)
        self.assertEqual(checked.returncode, 3)
        self.assertIn(f"of {TAKES} planned samples", checked.stdout)
        run_json("build", self.config, "-o", output)
        self.assertEqual(hashes(output), hashes(self.whole))
        self.assertTrue(run_json("check", output)["passed"])

    def test_a_take_that_fails_leaves_nothing_of_its_shard(self):
        output = self.folder / "failed"
        result = run("build", self.config, "-o", output, "--set",
                     "motion.stylus.path[0].u=[20 mm, 380 mm]")
        self.assertEqual(result.returncode, 3)
        failures = json.loads((output / "failures.json").read_text())
        # Others of the shard were made before it.
        self.assertIn("take-0006", [f["sample"] for f in failures])
        self.assertIn("is not on the face of floor", failures[0]["message"])
        self.assertEqual(written(output, "sounds", "movies"), {})
        checks = {c["name"]: c["verdict"] for c in run_json("check", output)["checks"]}
        self.assertEqual({name for name, verdict in checks.items() if verdict != "pass"},
                         {"counts", "failures"})


if __name__ == "__main__":
    unittest.main()
