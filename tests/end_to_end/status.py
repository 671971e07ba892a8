"""How far a build is: status.json, `carillon status`, what is said and logged, and --on-finish."""
import datetime
import json
import os
import re
import signal
import subprocess
import time
import unittest

from interrupted import wait_for
from program import CARILLON, TIMEOUT_FACTOR, FolderTest, run, run_json

CONFIG = """
seed: 3
materials: [steel, oak]
objects:
  - {shape: tile, count: 2, parameters: {length: 60 mm, width: 50 mm, thickness: 6 mm}}
modes: {max_modes: 6, order: 1, element_size: 20 mm}
strikes: {per_object: 3}
audio: {seconds: 0.1 s}
"""
SAMPLES, OBJECTS, TASKS = 12, 2, 4
DATE = re.compile(r"^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d ")
# A mesher that works as long as its file is there.
WAITING = '#!/bin/sh\nwhile [ -e "{gate}" ]; do sleep 0.05; done\nexec "{mesher}" "$@"\n'


def written(output):
    return json.loads((output / "status.json").read_text())


class Status(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "two.yaml"
        cls.config.write_text(CONFIG)
        cls.done = cls.folder / "done"
        cls.built = run("build", cls.config, "-o", cls.done, "--verbose", "--log", cls.folder / "two.log")
        assert cls.built.returncode == 0, cls.built.stderr

    def held_mesher(self, gate):
        """A mesher that waits; it begins once the gate is gone."""
        gate.touch()
        path = self.folder / f"mesher-{gate.name}"
        path.write_text(WAITING.format(gate=gate, mesher=os.path.join(os.path.dirname(CARILLON), "carillon-mesh")))
        path.chmod(0o755)
        return path

    def start(self, output, gate, *options):
        """A build that waits for its first mesh."""
        environment = {**os.environ, "CARILLON_MESH": str(self.held_mesher(gate))}
        process = subprocess.Popen([CARILLON, "--cache", "", "build", str(self.config), "-o", str(output), *options],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        self.addCleanup(gate.unlink, missing_ok=True)
        self.assertTrue(wait_for(lambda: (output / "status.json").exists() and written(output)["state"] == "running"
                                 and any(path.stat().st_size > 0 for path in output.glob("running/rank-*")), 20))
        return process

    def test_a_build_that_is_done_says_so(self):
        status = written(self.done)
        self.assertEqual((status["state"], status["exit_code"], status["name"]), ("done", 0, "two"))
        self.assertEqual(status["samples"], {"all": SAMPLES, "done": SAMPLES, "failed": 0})
        self.assertEqual(status["objects"], {"all": OBJECTS, "done": OBJECTS, "failed": 0})
        self.assertEqual(status["tasks"]["done"], status["tasks"]["all"])
        files = json.loads((self.done / "dataset.json").read_text())["files"]
        self.assertEqual(status["bytes"], sum(file["bytes"] for file in files))
        self.assertEqual(status["fraction"], 1)
        self.assertAlmostEqual(status["samples_per_s"] * status["elapsed_s"], SAMPLES, 6)
        for name in ("started", "updated"):
            then = datetime.datetime.strptime(status[name], "%Y-%m-%dT%H:%M:%SZ")
            self.assertLess(abs((datetime.datetime.utcnow() - then).total_seconds()), 3600)
        self.assertEqual(run_json("status", self.done), status)
        told = run("status", self.done)
        self.assertIn("two: done after", told.stdout)
        self.assertIn(f"{SAMPLES} of {SAMPLES}", told.stdout)
        self.assertEqual(run("status", self.done, "--watch").returncode, 0)

    def test_nothing_to_do_leaves_it_as_it_is(self):
        before = (self.done / "status.json").read_bytes()
        self.assertEqual(run("build", self.config, "-o", self.done).returncode, 0)
        self.assertEqual((self.done / "status.json").read_bytes(), before)

    def test_a_build_that_runs_tells_how_far_it_is(self):
        output, gate = self.folder / "runs", self.folder / "gate"
        process = self.start(output, gate)
        status = run_json("status", output)
        self.assertEqual((status["state"], status["exit_code"]), ("running", None))
        self.assertEqual(status["samples"], {"all": SAMPLES, "done": 0, "failed": 0})
        # Nothing is known yet of how long it takes.
        self.assertEqual((status["remaining_s"], status["samples_per_s"], status["bytes"]), (None, None, 0))
        self.assertEqual(len(status["running"]), 1)
        self.assertTrue(status["running"][0]["task"].startswith("modes/tile-"))
        self.assertEqual(status["running"][0]["rank"], 0)
        self.assertIn("now        modes/tile-", run("status", output).stdout)
        # It says that it is alive though nothing happens.
        first = status["updated"]
        self.assertTrue(wait_for(lambda: written(output)["updated"] > first, 20))
        watching = subprocess.Popen([CARILLON, "status", str(output), "--watch", "--json"], stdout=subprocess.PIPE,
                                    text=True)
        self.assertEqual(json.loads(watching.stdout.readline())["state"], "running")
        gate.unlink()
        self.assertEqual(process.wait(timeout=60 * TIMEOUT_FACTOR), 0)
        *_, last = watching.communicate(timeout=10 * TIMEOUT_FACTOR)[0].strip().split("\n{")
        self.assertEqual(json.loads("{" + last.lstrip("{"))["state"], "done")
        self.assertEqual(watching.returncode, 0)

    def test_one_that_is_interrupted_or_killed(self):
        output, gate = self.folder / "ended", self.folder / "never"
        for number, state, code in ((signal.SIGTERM, "interrupted", 130), (signal.SIGKILL, "running", None)):
            notes = self.folder / f"notes-{number}"
            process = self.start(output, gate, "--on-finish",
                                 f'echo "$CARILLON_EXIT_CODE $CARILLON_OUTPUT" >"{notes}.new"; mv "{notes}.new" "{notes}"')
            process.send_signal(number)
            process.wait(timeout=30 * TIMEOUT_FACTOR)
            status = written(output)
            self.assertEqual((status["state"], status["exit_code"]), (state, code), number)
            self.assertTrue(wait_for(notes.exists, 20))
            self.assertEqual(notes.read_text(), f"{code or 137} {output}\n")
        # Of the killed one nobody has heard for long.
        status["updated"] = "2026-01-01T00:00:00Z"
        (output / "status.json").write_text(json.dumps(status))
        self.assertEqual(run_json("status", output)["state"], "lost")
        told = run("status", output, "--watch")
        self.assertIn("run the same command to go on", told.stdout)
        self.assertEqual(told.returncode, 1)
        # The next run goes on, and says so.
        gate.unlink()
        self.assertEqual(run("build", self.config, "-o", output).returncode, 0)
        self.assertEqual(written(output)["state"], "done")

    def test_failures_are_counted_and_told_at_once(self):
        bad = self.write("bad.yaml", CONFIG.replace("count: 2,", "name: good,").replace(
            "\nmodes:", "\n  - {mesh: nothing.obj, name: bad}\nmodes:"))
        (self.folder / "nothing.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        output = self.folder / "bad"
        result = run("build", bad, "-o", output, "--on-finish", 'echo "code $CARILLON_EXIT_CODE"')
        self.assertEqual(result.returncode, 3, result.stderr)
        status = written(output)
        self.assertEqual((status["state"], status["exit_code"]), ("done", 3))
        self.assertEqual(status["objects"], {"all": 2, "done": 1, "failed": 1})
        self.assertEqual(status["samples"], {"all": SAMPLES, "done": SAMPLES // 2, "failed": SAMPLES // 2})
        self.assertEqual(status["tasks"]["failed"], 1)
        self.assertRegex(result.stderr, r"(?m)^\S+ \S+ modes/bad-nothing failed: ")
        self.assertRegex(result.stderr, r"(?m)build  100 %.*1 task failed")
        self.assertEqual(result.stdout.splitlines()[-1], "code 3")

    def test_a_run_that_an_error_ends(self):
        output = self.folder / "broken"
        nowhere = self.folder / "nowhere"
        result = run("--cache", "", "build", self.config, "-o", output, environment={"CARILLON_MESH": str(nowhere)})
        self.assertEqual(result.returncode, 2)
        status = written(output)
        self.assertEqual((status["state"], status["exit_code"]), ("error", 2))
        self.assertIn(str(nowhere), status["error"])
        self.assertIn("ended by an error", run("status", output).stdout)

    def test_what_is_said_and_logged(self):
        lines = self.built.stderr.splitlines()
        self.assertTrue(all(DATE.match(line) for line in lines), lines)
        said = [DATE.sub("", line) for line in lines]
        # Each task with its time and rank, and how far it came, with units.
        self.assertEqual(sum(" on rank 0" in line for line in said), TASKS, said)
        self.assertRegex(said[-1], rf"^build  100 %  {SAMPLES} of {SAMPLES} samples  [0-9.]+ samples/s  {OBJECTS} of {OBJECTS} objects  "
                                   r"[0-9.]+ [kM]B  in [0-9.]+ m?s$")
        log = (self.folder / "two.log").read_text().splitlines()
        self.assertTrue(all(DATE.match(line) for line in log), log)
        logged = [DATE.sub("", line) for line in log]
        self.assertIn("carillon build", logged[0])
        for line in said + self.built.stdout.splitlines():
            self.assertIn(line, logged)
        quiet = run("build", self.config, "-o", self.folder / "quiet", "--quiet", "--log", self.folder / "quiet.log")
        self.assertEqual(quiet.stderr, "")
        self.assertEqual(sum(" on rank 0" in line for line in (self.folder / "quiet.log").read_text().splitlines()), TASKS)
        for ranks in (None, 2):
            both = run("build", self.config, "-o", self.folder / "no", "--quiet", "--verbose", ranks=ranks)
            self.assertEqual(both.returncode, 2)
            self.assertIn("--quiet and --verbose exclude each other", both.stderr)
            nowhere = run("build", self.config, "-o", self.folder / "no", "--log", self.folder / "none" / "log", ranks=ranks)
            self.assertEqual(nowhere.returncode, 2)
            self.assertIn("the log cannot be written: No such file", nowhere.stderr)
        self.assertFalse((self.folder / "no").exists())

    def test_ranks_and_sweeps(self):
        sweep = self.write("sweep.yaml", CONFIG + "sweep: {keys: {audio.gain: [1, 2]}}\n")
        output = self.folder / "sweep"
        started = time.monotonic()
        result = run("build", sweep, "-o", output, "--on-finish", 'echo "$CARILLON_OUTPUT"', ranks=2)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(str(output), result.stdout.splitlines()[-1])
        status = run_json("status", output)
        self.assertEqual((status["name"], status["state"], status["ranks"]), ("sweep", "done", 2))
        self.assertEqual(status["samples"]["done"], 2 * SAMPLES)
        self.assertEqual(status["objects"], {"all": 2 * OBJECTS, "done": 2 * OBJECTS, "failed": 0})
        self.assertLess(status["elapsed_s"], time.monotonic() - started)
        variant = next(path for path in output.iterdir() if (path / "dataset.json").exists())
        refused = run("status", variant)
        self.assertEqual(refused.returncode, 2)
        self.assertIn(f"carillon status {output}", refused.stderr)

    def test_folders_that_are_none(self):
        for folder, told in ((self.folder / "nowhere", "there is no such folder"),
                             (self.folder, "there is no status.json in it")):
            result = run("status", folder)
            self.assertEqual(result.returncode, 2)
            self.assertIn(told, result.stderr)
            self.assertIn("hint: name the folder that `carillon build` makes", result.stderr)
        damaged = self.folder / "damaged"
        damaged.mkdir()
        for text in ("", "{", "[]", "{}", '{"state": "running"}', '{"state": 3}', '{"state": "done"}'):
            (damaged / "status.json").write_text(text)
            result = run("status", damaged)
            self.assertEqual(result.returncode, 2, text)
            self.assertIn("status.json", result.stderr)

    def test_a_command_that_fails_or_is_not_there(self):
        for command, told in (("exit 7", "ended with code 7"), ("kill -9 $$", "was ended by signal 9"),
                              ("no-such-command", "ended with code 127")):
            result = run("list", "shapes", "--on-finish", command)
            self.assertEqual(result.returncode, 0)
            self.assertIn(f"the command of --on-finish {told}", result.stderr)


if __name__ == "__main__":
    unittest.main()
