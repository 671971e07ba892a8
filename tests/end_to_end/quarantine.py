"""Bodies that cannot be had cost their own task, with its reason and the command that shows it."""
import json
import os
import pathlib
import shlex
import shutil
import stat
import subprocess
import tempfile
import unittest

from program import CARILLON, FolderTest, of_memory, run, run_json
from same import hashes

# "bad" is the wide one: whoever breaks an object can tell it by its name or by its unknowns.
CONFIG = """
seed: 3
materials: [steel]
objects:
  - {shape: tile, name: good, parameters: {length: 60 mm, width: 50 mm, thickness: 6 mm}}
  - {shape: block, name: bad, parameters: {length: 200 mm, width: 80 mm, height: 20 mm}}
modes: {max_modes: 8, order: 2, element_size: 20 mm}
strikes: {per_object: 2}
audio: {seconds: 0.1 s}
"""
GOOD = ["modes/good-000", "samples/good-000-0000"]
BAD = ["modes/bad-000", "samples/bad-000-0000"]


class Quarantine(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "two objects.yaml"
        cls.config.write_text(CONFIG)
        cls.whole = cls.folder / "whole"
        run_json("build", cls.config, "-o", cls.whole)

    def build(self, name, *arguments, mesher=None, ranks=None, code=3):
        """A build without a cache, so that everything is done; its failures."""
        output = self.folder / name
        os.environ.pop("CARILLON_MESH", None)
        if mesher:
            os.environ["CARILLON_MESH"] = str(mesher)
        try:
            result = run("--cache", "", "build", self.config, "-o", output, *arguments,
                         ranks=ranks)
        finally:
            os.environ.pop("CARILLON_MESH", None)
        self.assertEqual(result.returncode, code, result.stderr)
        return output, json.loads((output / "failures.json").read_text())

    def mesher(self, ailment):
        """A mesher that falls ill over blocks and is sound over everything else."""
        sound = pathlib.Path(CARILLON).parent / "carillon-mesh"
        path = self.folder / f"mesher-{len(ailment)}"
        path.write_text(f'#!/bin/sh\ngrep -q block "$1" && {{ {ailment}; }}\n'
                        f'exec "{sound}" "$@"\n')
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return path

    def check_only_bad_failed(self, failures, stage, kind, message):
        self.assertEqual([f["task"] for f in failures], [BAD[0]])
        self.assertEqual(failures[0]["skipped"], [BAD[1]])
        self.assertEqual(failures[0]["stage"], stage)
        self.assertEqual(failures[0]["kind"], kind)
        self.assertIn(message, failures[0]["message"])

    def check_reproduces(self, failure, environment=None):
        """The recorded command, typed into a shell, says the same."""
        command = shlex.split(failure["reproduce"])
        self.assertEqual(command[0], "carillon")
        # What other tests solved must not spare it the trouble.
        cache = tempfile.mkdtemp(dir=self.folder)
        os_environment = dict(os.environ, CARILLON_CACHE=cache, **(environment or {}))
        result = subprocess.run([CARILLON, *command[1:], "-o", str(self.folder / "shown")],
                                capture_output=True, text=True, timeout=120, env=os_environment)
        self.assertEqual(result.returncode, 2, result.stderr)
        # The seconds until a crash differ from one time to the next.
        said = failure["message"].split(" after ")[0]
        self.assertIn(said, result.stderr)

    def check_is_whole(self, output):
        self.assertEqual(hashes(output), hashes(self.whole))

    def check_mesher(self, name, ailment, kind, message, *limits):
        mesher = self.mesher(ailment)
        output, failures = self.build(name, *limits, mesher=mesher, ranks=2)
        self.check_only_bad_failed(failures, "mesh", kind, message)
        self.check_reproduces(failures[0], {"CARILLON_MESH": str(mesher)})
        # The same command leaves it alone; --retry-failed does not.
        _, again = self.build(name, *limits, mesher=mesher)
        self.assertEqual(again, failures)
        output, mended = self.build(name, *limits, "--retry-failed", code=0)
        self.assertEqual(mended, [])
        return output

    def expect_no_failure(self, name, told, environment):
        """A node without something ends the run; whole by the same command once it is mended."""
        with self.subTest(name):
            output = self.folder / name
            command = [CARILLON, "--cache", "", "build", str(self.config), "-o", str(output)]
            for ranks in (["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "2"], []):
                result = subprocess.run([*ranks, *command], capture_output=True, text=True,
                                        timeout=120, env=dict(os.environ, **environment))
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(told, result.stderr)
                self.assertIn("hint:", result.stderr)
                self.assertNotIn('"ok":false', (output / "journal.jsonl").read_text())
            result = subprocess.run(command, capture_output=True, text=True, timeout=120)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.check_is_whole(output)

    def test_a_node_without_a_mesher_or_temporary_files(self):
        nowhere = str(self.folder / "nowhere")
        self.expect_no_failure("no temporary folder", f"{nowhere} is no folder",
                                  {"TMPDIR": nowhere, "OMPI_MCA_orte_tmpdir_base": "/tmp"})
        self.expect_no_failure("no mesher", f"CARILLON_MESH names {nowhere}",
                                  {"CARILLON_MESH": nowhere})
        text = self.folder / "text"
        text.write_text("no program")
        self.expect_no_failure("no program", f"{text}: cannot be started",
                                  {"CARILLON_MESH": str(text)})

    def test_a_full_temporary_folder(self):
        disk = self.folder / "small"
        disk.mkdir()
        # Room for a request, not for a mesh.
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8k", "none", str(disk)],
                          capture_output=True).returncode != 0:
            self.skipTest("mounting a small disk takes root")
        try:
            self.expect_no_failure("full", "the mesher cannot read or write its files",
                                      {"TMPDIR": str(disk), "OMPI_MCA_orte_tmpdir_base": "/tmp"})
        finally:
            subprocess.run(["umount", str(disk)], check=True)

    def test_a_failure_of_the_moment_is_tried_again(self):
        output, _ = self.build("moment", code=0)
        for name in (GOOD[0], GOOD[1]):
            (output / f"{name}.h5").unlink()
        journal = output / "journal.jsonl"
        done = next(e for e in map(json.loads, journal.read_text().splitlines())
                    if e["task"] == GOOD[0])
        failed = {"task": GOOD[0], "ok": False, "kind": "LimitError", "message": "no room",
                  "inputs": done["inputs"]}
        for entry, code in ((failed, 3), (dict(failed, lasting=False), 0)):
            with journal.open("a") as file:
                file.write(json.dumps(entry) + "\n")
            self.build("moment", code=code)
        self.check_is_whole(output)

    def test_a_mesher_that_crashes(self):
        output = self.check_mesher("crashed", "kill -SEGV $$", "SolverError",
                                   "the mesher crashed")
        self.check_is_whole(output)

    def test_a_mesher_that_hangs(self):
        self.check_mesher("hung", "exec sleep 100", "TimeError",
                          "meshing was stopped at the time limit of 3 s", "--set",
                          "limits.mesh_time=3 s")

    @of_memory
    def test_a_mesher_without_memory(self):
        output, failures = self.build("starved", "--set", "limits.mesh_memory=16 MiB")
        self.assertEqual([f["task"] for f in failures], [GOOD[0], BAD[0]])
        for failure in failures:
            self.assertEqual((failure["stage"], failure["kind"]), ("mesh", "MemoryError"))
            self.assertIn("needs more than the limit of", failure["message"])
        self.check_reproduces(failures[0])
        self.assertEqual(json.loads((output / "dataset.json").read_text())["samples"], 0)

    def test_a_solve_that_takes_too_long(self):
        for solver in ("block_lanczos", "krylov_schur"):
            setting = f"solver.eigen_solver={solver}"
            _, failures = self.build(f"late-{solver}", "--set", "limits.solve_time=1 ms",
                                     "--set", setting, ranks=2)
            self.assertEqual({f["task"] for f in failures}, {GOOD[0], BAD[0]})
            for failure in failures:
                self.assertEqual((failure["stage"], failure["kind"]), ("solve", "TimeError"))
                self.assertEqual(failure["message"],
                                 "the solve takes longer than the limit of 0.001 s")
            self.check_reproduces(failures[0])

    def test_a_limit_may_be_raised_over_the_same_folder(self):
        self.build("raised", "--set", "limits.solve_time=1 ms")
        output, failures = self.build("raised", "--retry-failed", code=0)
        self.assertEqual(failures, [])
        self.check_is_whole(output)

    @of_memory
    def test_a_solve_that_grows_too_large(self):
        # The bad object has 186,000 unknowns now, and its solve takes 1.2 GB.
        _, failures = self.build("grown", "--set", "modes.order=3", "--set",
                                 "modes.element_size=12 mm", "--set",
                                 "objects[1].parameters.height=40 mm", "--set",
                                 "limits.solve_memory=400 MiB", ranks=2)
        self.check_only_bad_failed(failures, "solve", "MemoryError",
                                   "the solve needs more than the limit of 400.0 MiB")
        self.check_reproduces(failures[0])

    def test_a_solve_without_memory(self):
        # Less than the process holds already: nothing is begun.
        _, failures = self.build("small", "--set", "limits.solve_memory=1 MiB", ranks=2)
        self.assertEqual({f["task"] for f in failures}, {GOOD[0], BAD[0]})
        for failure in failures:
            self.assertEqual((failure["stage"], failure["kind"]), ("solve", "MemoryError"))
            self.assertIn("the solve needs more than the limit of 1.0 MiB", failure["message"])
        self.check_reproduces(failures[0])

    def test_a_sound_that_takes_too_long(self):
        _, failures = self.build("slow", "--set", "limits.sample_time=1 us")
        self.assertEqual({f["task"] for f in failures}, {GOOD[1], BAD[1]})
        for failure in failures:
            self.assertEqual((failure["stage"], failure["kind"]), ("sound", "TimeError"))
            self.assertTrue(failure["sample"].endswith("strike-0000"))
            self.assertIn(failure["sample"], failure["reproduce"])
        self.check_reproduces(failures[0])

    def test_files_that_cannot_be_written(self):
        output = self.folder / "unwritable"
        output.mkdir()
        # A folder stands where a file should go.
        blocked = output / "modes" / "bad-000.h5"
        (blocked / "inside").mkdir(parents=True)
        _, failures = self.build("unwritable")
        self.check_only_bad_failed(failures, "write", "FileError", "bad-000.h5")
        self.assertTrue(failures[0]["reproduce"].startswith("carillon build "))
        shutil.rmtree(blocked)
        command = shlex.split(failures[0]["reproduce"])
        result = subprocess.run([CARILLON, *command[1:]], capture_output=True, text=True,
                                timeout=120)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.check_is_whole(output)

    def test_nothing_that_runs_is_left_behind(self):
        self.assertFalse((self.whole / "running").exists())

    def test_a_sweep_tries_what_its_variants_share_once(self):
        tries = self.folder / "tries"
        # The mesh is one for all of them, the solves are two.
        config = self.write("swept.yaml", CONFIG + "sweep: {keys: {modes.max_modes: [8, 7]}}\n")
        output = self.folder / "swept"
        os.environ["CARILLON_MESH"] = str(self.mesher(f"echo once >> '{tries}'; kill -SEGV $$"))
        try:
            for arguments, runs in ((), 2), ((), 0), (("--retry-failed",), 2):
                result = run("--cache", "", "build", config, "-o", output, "--json", *arguments,
                             ranks=2)
                self.assertEqual(result.returncode, 3, result.stderr)
                summary = json.loads(result.stdout)
                self.assertEqual(summary["failed_tasks"], 2)
                self.assertEqual([v["samples"] for v in summary["variants"]], [2, 2])
                if arguments:
                    self.assertEqual(summary["tasks_run"], runs)
        finally:
            del os.environ["CARILLON_MESH"]
        self.assertEqual(tries.read_text().split(), ["once"] * 2)  # one for each run that tried
        for count in (8, 7):
            failure, = json.loads((output / f"max_modes={count}" / "failures.json").read_text())
            self.assertEqual((failure["task"], failure["stage"]), (BAD[0], "mesh"))
            self.assertIn("--set sweep=", failure["reproduce"].replace("'", ""))
            self.assertIn(f"modes.max_modes={count}", failure["reproduce"])
        mended = run_json("--cache", "", "build", config, "-o", output, "--retry-failed")
        self.assertEqual([v["samples"] for v in mended["variants"]], [4, 4])


if __name__ == "__main__":
    unittest.main()
