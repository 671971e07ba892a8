"""Simulations whose build is killed, or fails: what is left, and that the end is as if nothing had been."""
import json
import os
import signal
import subprocess
import unittest

from interrupted import descendants, recorded, wait_for
from moving_scene import MOVIE, SHAPES, SHARDS, SIMULATIONS, MovingTest, written
from program import CARILLON, run, run_json
from same import hashes


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
        """Each task was done once, each effect ran once a simulation, and the files are the same."""
        self.assertEqual(hashes(output), hashes(self.whole))
        self.assertEqual(set(recorded(output).values()), {1})
        self.assertEqual(len(recorded(output)), SHAPES + SHARDS)
        trace = json.loads((output / "trace.json").read_text())
        for effect in ("motion", "movie", "touch", "noise"):
            self.assertEqual(trace["effects"][effect]["calls"], SIMULATIONS, effect)
        self.assertTrue(run_json("check", output)["passed"])

    def test_killed_in_the_middle_of_its_simulations(self):
        for ranks in (None, 2):
            with self.subTest(ranks=ranks):
                output = self.folder / f"killed-{ranks}"
                # The first of three simulations of a shard has its movie, the shard is not written.
                movie = output / "movies" / f"simulation-0004{MOVIE}"
                self.kill_when(movie.exists, output, ranks=ranks)
                done = recorded(output)
                self.assertNotIn("samples/simulations-0001", done)
                self.assertFalse((output / "samples" / "simulations-0001.h5").exists())
                self.assertEqual(sum(task.startswith("modes/") for task in done), SHAPES)
                there = written(output, "samples", "modes")
                summary = run_json("build", self.config, "-o", output)
                self.assertEqual(summary["tasks_run"], SHAPES + SHARDS - len(done))
                now = written(output, "samples", "modes")
                self.assertEqual({name: now[name] for name in there}, there)
                self.assert_whole(output)

    def test_killed_while_simulations_are_added(self):
        output = self.folder / "both"
        run_json("build", self.config, "-o", output, "--set", "motion.simulations=2")
        # Within the shard that has two simulations and gets two more.
        self.kill_when((output / "movies" / f"simulation-0002{MOVIE}").exists, output)
        checked = run("check", output)
        self.assertEqual(checked.returncode, 3)
        self.assertIn(f"of {SIMULATIONS} planned samples", checked.stdout)
        run_json("build", self.config, "-o", output)
        self.assertEqual(hashes(output), hashes(self.whole))
        self.assertTrue(run_json("check", output)["passed"])

    def test_a_simulation_that_fails_leaves_nothing_of_its_shard(self):
        output = self.folder / "failed"
        result = run("build", self.config, "-o", output, "--set",
                     "motion.stylus.path[0].u=[20 mm, 380 mm]")
        self.assertEqual(result.returncode, 3)
        failures = json.loads((output / "failures.json").read_text())
        # Others of the shard were made before it.
        self.assertIn("simulation-0005", [f["sample"] for f in failures])
        self.assertIn("is not on the face of floor", failures[0]["message"])
        self.assertEqual([file for folder in ("sounds", "movies")
                          for file in (output / folder).rglob("*") if file.is_file()], [])
        checks = {c["name"]: c["verdict"] for c in run_json("check", output)["checks"]}
        self.assertEqual({name for name, verdict in checks.items() if verdict != "pass"},
                         {"counts", "failures", "pitches", "publication"})


if __name__ == "__main__":
    unittest.main()
