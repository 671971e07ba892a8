"""Simulations that are added to a dataset, and more objects for simulations to draw from."""
import json
import os
import pathlib
import unittest

import h5py
from moving_scene import MOVIE, SHARDS, SIMULATIONS, MovingTest, written
from program import run, run_json
from same import hashes


class SceneGrowth(MovingTest):
    def test_more_simulations(self):
        output = self.folder / "grown"
        run_json("build", self.config, "-o", output, "--set", "motion.simulations=3")
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
        self.assertEqual(set(now), {f"movies/simulation-{simulation:04}{MOVIE}" for simulation in range(SIMULATIONS)})
        self.assertEqual({name: now[name] for name in movies}, movies)
        new = [json.loads(line)["trace"]["effects"]
               for line in (output / "journal.jsonl").read_text().splitlines()[lines:]]
        self.assertEqual(sum(effects["motion"]["calls"] for effects in new), SIMULATIONS - 3)
        self.assertEqual(hashes(output), hashes(self.whole))
        self.assertTrue(run_json("check", output)["passed"])
        report = run_json("regenerate", output, "--sample", 2, "--sample", 3)
        self.assertEqual([s["identical"] for s in report["samples"]], [True, True])

    def test_more_to_draw_from(self):
        # Who plays is drawn anew then: all simulations are made again, but for the objects' modes.
        for name, settings, file in (("count", ["objects[3].count=3"], None),
                                     ("files", [], "c.obj")):
            with self.subTest(name):
                output, fresh = self.folder / name, self.folder / f"{name}-fresh"
                few = ["--set", "motion.simulations=2"]
                run_json("build", self.config, "-o", output, *few)
                if file:
                    text = (self.folder / "meshes" / "a.obj").read_text()
                    (self.folder / "meshes" / file).write_text(text.replace("1.7", "1.9"))
                more = [word for setting in settings for word in ("--set", setting)]
                summary = run_json("build", self.config, "-o", output, *few, *more)
                self.assertEqual(summary["tasks_run"], 2)  # the new object's modes, and the simulations
                run_json("build", self.config, "-o", fresh, *few, *more)
                self.assertEqual(hashes(output), hashes(fresh))
                self.assertTrue(run_json("check", output)["passed"])
                if file:
                    (self.folder / "meshes" / file).write_text(text.replace("1.7", "1.8"))
                    result = run("build", self.config, "-o", output, *few)
                    self.assertEqual(result.returncode, 2)
                    self.assertIn("built from other files", result.stderr)
                    (self.folder / "meshes" / file).unlink()

    def test_more_simulations_without_ffmpeg(self):
        # Frames instead of movies; with the program, those that are added are movies.
        programs = self.folder / "programs"
        programs.mkdir()
        for folder in os.environ["PATH"].split(":"):
            for program in pathlib.Path(folder).glob("*"):
                link = programs / program.name
                if program.name != "ffmpeg" and not link.is_symlink():
                    link.symlink_to(program)
        output = self.folder / "frames"
        path = os.environ["PATH"]
        os.environ["PATH"] = str(programs)
        try:
            run_json("build", self.config, "-o", output, "--set", "motion.simulations=1")
            run_json("build", self.config, "-o", output, "--set", "motion.simulations=2")
        finally:
            os.environ["PATH"] = path
        for simulation in range(2):
            names = {file.name for file in (output / "movies" / f"simulation-{simulation:04}").iterdir()}
            self.assertEqual(names, {f"frame_{k:05}.png" for k in range(5)} | {"sound.wav"})
        if MOVIE:
            run_json("build", self.config, "-o", output, "--set", "motion.simulations=3")
            self.assertEqual({file.name for file in (output / "movies").iterdir()},
                             {"simulation-0000", "simulation-0001", "simulation-0002.mp4"})
        self.assertTrue(run_json("check", output)["passed"])


if __name__ == "__main__":
    unittest.main()
