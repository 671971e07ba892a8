"""Solves that take the whole run with them: given up after two attempts; what ran beside them is not."""
import json
import os
import pathlib
import signal
import subprocess
import time
import unittest

from interrupted import descendants
from program import CARILLON, FolderTest, run, run_json
from same import hashes

CONFIG = """
seed: 3
materials: [steel]
objects:
  - {shape: block, name: bad, parameters: {length: 200 mm, width: 80 mm, height: 20 mm}}
  - {shape: tile, name: good, count: 3, parameters: {length: 60 mm, width: 50 mm, thickness: 6 mm}}
modes: {max_modes: 8, order: 2, element_size: 20 mm}
strikes: {per_object: 2}
audio: {seconds: 0.1 s}
"""
BAD = "modes/bad-000"
# Unknowns of the bad object, and of no good one, are at least so many.
FROM = "1500"


def wait_for(what, seconds=60):
    """The first true answer of a question."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        answer = what()
        if answer:
            return answer
        time.sleep(0.02)
    raise AssertionError("waited in vain")


def open_files(pid):
    """Files that a process holds open."""
    try:
        links = list(pathlib.Path(f"/proc/{pid}/fd").iterdir())
        return [pathlib.Path(os.readlink(link)) for link in links]
    except OSError:
        return []  # it is gone, or one of them is closed


class Crash(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "four.yaml"
        cls.config.write_text(CONFIG)
        cls.shim = cls.folder / "fault.so"
        source = pathlib.Path(__file__).with_name("fault.c")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", cls.shim, source, "-ldl"], check=True)
        cls.whole = cls.folder / "whole"
        run_json("build", cls.config, "-o", cls.whole)

    def command(self, output, *arguments, ranks=None):
        command = [CARILLON, "--cache", "", "build", str(self.config), "-o", str(output),
                   "--quiet", *arguments]
        if ranks:
            command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
        return command

    def ill(self, fault):
        return dict(os.environ, LD_PRELOAD=str(self.shim), FAULT=fault, FAULT_FROM=FROM)

    def run_ill(self, output, fault, *arguments, ranks=None):
        return subprocess.run(self.command(output, *arguments, ranks=ranks), text=True,
                              capture_output=True, timeout=120, env=self.ill(fault))

    def attempts(self, output):
        lines = (output / "journal.jsonl").read_text().splitlines()
        return [e["attempt"] for e in map(json.loads, lines) if "attempt" in e]

    def failures(self, output):
        return json.loads((output / "failures.json").read_text())

    def test_a_crash_costs_the_run_twice(self):
        for fault, ranks in (("segv", 2), ("abort", None)):
            output = self.folder / fault
            for _ in range(2):
                result = self.run_ill(output, fault, ranks=ranks)
                self.assertNotIn(result.returncode, (0, 1, 2, 3, 130), result.stderr)
            result = self.run_ill(output, fault, ranks=ranks)
            self.assertEqual(result.returncode, 3, result.stderr)
            # What ran beside it was asked to stop.
            self.assertEqual(self.attempts(output), [BAD] * 2)
            failure, = self.failures(output)
            self.assertEqual((failure["task"], failure["stage"], failure["kind"]),
                             (BAD, "solve", "CrashError"))
            self.assertEqual(failure["message"], "the run ended while this task ran, twice")
            self.assertEqual(run_json("build", self.config, "-o", output, "--retry-failed",
                                      )["failed_tasks"], 0)
            self.assertEqual(hashes(output), hashes(self.whole))

    def test_a_sweep_dies_of_a_shared_solve_no_more_than_twice(self):
        config = self.write("swept.yaml", "name: four\n" + CONFIG +
                            "sweep: {keys: {strikes.per_object: [2, 1]}}\n")
        output = self.folder / "swept"
        command = [CARILLON, "--cache", "", "build", str(config), "-o", str(output), "--quiet"]
        codes = [subprocess.run(command, capture_output=True, timeout=120,
                                env=self.ill("segv")).returncode for _ in range(3)]
        self.assertNotIn(3, codes[:2])
        self.assertEqual(codes[2], 3)
        for count in (2, 1):
            failure, = self.failures(output / f"per_object={count}")
            self.assertEqual((failure["task"], failure["kind"]), (BAD, "CrashError"))
            self.assertEqual(len(failure["skipped"]), 1)
        self.assertFalse((output / "running").exists())
        # Whole again where the fault is mended.
        result = subprocess.run([*command, "--retry-failed"], capture_output=True, timeout=120)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(hashes(output / "per_object=2"), hashes(self.whole))

    def test_repeating_retry_failed_comes_to_an_end(self):
        output = self.folder / "repeated"
        codes = [self.run_ill(output, "segv", "--retry-failed").returncode for _ in range(3)]
        self.assertEqual(codes, [-signal.SIGSEGV, -signal.SIGSEGV, 3])
        self.assertEqual(self.attempts(output), [BAD] * 2)
        result = run("build", self.config, "-o", output, "--retry-failed")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(hashes(output), hashes(self.whole))

    def test_the_recorded_command_crashes_too(self):
        command = ["preview", str(self.config), "--sample", "bad-000/steel/1/strike-0000"]
        result = subprocess.run([CARILLON, "--cache", "", *command, "-o", self.folder / "shown"],
                                capture_output=True, timeout=120, env=self.ill("segv"))
        self.assertEqual(result.returncode, -signal.SIGSEGV)

    def test_a_hang_costs_the_run_once(self):
        output = self.folder / "hang"
        limit = ("--set", "limits.solve_time=2 s")
        result = self.run_ill(output, "hang", *limit, ranks=2)
        # As after a crash, job scripts run it again.
        self.assertEqual(result.returncode, 152, result.stderr)
        self.assertIn("the solve takes longer than the limit of 2 s", result.stderr)
        result = self.run_ill(output, "hang", *limit, ranks=2)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(self.attempts(output), [BAD])
        failure, = self.failures(output)
        self.assertEqual((failure["stage"], failure["kind"], failure["message"]),
                         ("solve", "TimeError", "the solve takes longer than the limit of 2 s"))

    def test_a_limit_that_one_rank_of_a_group_meets_reaches_the_other(self):
        output = self.folder / "fat"
        settings = ("limits.solve_memory=1 GiB", "ranks.unknowns_per_rank=1000",
                    "ranks.widest_group=2")
        result = self.run_ill(output, "fat", *(w for s in settings for w in ("--set", s)), ranks=2)
        self.assertEqual(result.returncode, 3, result.stderr)
        failure = next(f for f in self.failures(output) if f["task"] == BAD)
        self.assertEqual((failure["stage"], failure["kind"]), ("solve", "MemoryError"))
        self.assertIn("needs more than the limit of 1.0 GiB", failure["message"])

    def start(self, output, ranks):
        """A build whose solve of the bad object takes a while; returns once that has begun, with the
        numbers of its processes by task and stage."""
        process = subprocess.Popen(self.command(output, ranks=ranks), env=self.ill("20"),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   start_new_session=True)

        def solving():
            told = {}
            for pid in descendants(process.pid):
                for path in open_files(pid):
                    if path.parent != output / "running":
                        continue
                    line = path.read_text().split("\n")[0]
                    if line:
                        record = json.loads(line)
                        told[record["task"], record["stage"]] = pid
            return told if (BAD, "solve") in told else None
        return process, wait_for(solving)

    def kill_everything(self, output):
        process, told = self.start(output, ranks=2)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for pid in told.values():  # in groups of their own
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        wait_for(lambda: not any(pathlib.Path(f"/proc/{pid}").exists() for pid in told.values()))
        return {task for task, _ in told}

    def kill_the_rank_that_solves(self, output):
        process, told = self.start(output, ranks=2)
        os.kill(told[BAD, "solve"], signal.SIGKILL)
        self.assertNotEqual(process.wait(timeout=60), 0)
        return {BAD}

    def test_a_kill_costs_no_task(self):
        for kill in (self.kill_everything, self.kill_the_rank_that_solves):
            with self.subTest(kill.__name__):
                output = self.folder / kill.__name__
                running = kill(output)
                summary = run_json("build", self.config, "-o", output, ranks=2)
                self.assertEqual(summary["failed_tasks"], 0)
                self.assertLessEqual(set(self.attempts(output)), running)
                self.assertIn(BAD, self.attempts(output))
                self.assertEqual(hashes(output), hashes(self.whole))

    def test_what_two_kills_hit_is_given_up_alone(self):
        for kill in (self.kill_everything, self.kill_the_rank_that_solves):
            with self.subTest(kill.__name__):
                output = self.folder / f"{kill.__name__}-twice"
                kill(output)
                # Tried again alone, after all else.
                self.assertEqual(kill(output), {BAD})
                result = run("build", self.config, "-o", output)
                self.assertEqual(result.returncode, 3, result.stderr)
                failure, = self.failures(output)
                self.assertEqual((failure["task"], failure["stage"], failure["kind"]),
                                 (BAD, "solve", "CrashError"))
                self.assertIn("--retry-failed", failure["hint"])
                result = run("build", self.config, "-o", output, "--retry-failed")
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(hashes(output), hashes(self.whole))

    def test_whoever_is_asked_to_stop_has_no_attempt(self):
        output = self.folder / "asked"
        for ranks in (2, None, 2):
            process, _ = self.start(output, ranks=ranks)
            process.send_signal(signal.SIGTERM)
            process.wait(timeout=60)
        self.assertEqual(run_json("build", self.config, "-o", output)["failed_tasks"], 0)
        self.assertEqual(self.attempts(output), [])
        self.assertEqual(hashes(output), hashes(self.whole))


if __name__ == "__main__":
    unittest.main()
