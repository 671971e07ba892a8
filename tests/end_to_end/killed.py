"""Builds that are killed: the same command carries on, and the end is that of a build left alone.

Kill moments, victims and ranks are drawn with a seed that is printed: CARILLON_KILL_SEED=N repeats
them. CARILLON_KILLS=50 is what the label `slow` runs; without it there are five.
"""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

import h5py
from interrupted import SAMPLES, TASKS, InterruptedTest, alive, descendants, program, recorded, wait_for
from program import CARILLON, run_json
from same import hashes

KILLS = int(os.environ.get("CARILLON_KILLS", "5"))
SEED = int(os.environ.get("CARILLON_KILL_SEED", str(random.SystemRandom().randrange(10**6))))


def rank_of(pid, number):
    """The process of one rank of the mpirun `pid`."""
    for child in descendants(pid):
        try:
            parent = pathlib.Path(f"/proc/{child}/stat").read_text().rsplit(")", 1)[1].split()[1]
            environment = pathlib.Path(f"/proc/{child}/environ").read_bytes().split(b"\0")
        except OSError:
            continue  # a mesher that has ended
        if int(parent) == pid and b"OMPI_COMM_WORLD_RANK=%d" % number in environment:
            return child
    raise AssertionError(f"no rank {number} below {pid}")


def rests_in_a_task(output, pid, rank):
    """Stops the process of a rank; lets it go on where it has no task just then."""
    os.kill(pid, signal.SIGSTOP)
    time.sleep(0.01)  # it may be on the other core
    try:
        note = (output / "running" / f"rank-{rank:05}").read_text()
    except OSError:
        note = ""  # not begun, or over
    if note.partition("\n")[0]:
        return True
    os.kill(pid, signal.SIGCONT)
    return False


class Killed(InterruptedTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        assert cls.summary["samples"] == SAMPLES and cls.summary["tasks_run"] == TASKS, cls.summary
        begin = time.monotonic()
        run_json("--cache", "", "build", cls.config, "-o", cls.folder / "timed", ranks=2)
        cls.seconds = time.monotonic() - begin
        cls.expected = hashes(cls.whole)
        cls.random = random.Random(SEED)
        print(f"seed {SEED} (CARILLON_KILL_SEED), {KILLS} kills of a build of {cls.seconds:.1f} s")

    def command(self, output, ranks):
        command = [CARILLON, "--cache", "", "build", str(self.config), "-o", str(output)]
        if ranks:
            command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
        return command

    def finish_and_compare(self, output, done_before):
        summary = run_json("--cache", "", "build", self.config, "-o", output, ranks=2)
        self.assertEqual(summary["tasks_run"], TASKS - len(done_before))
        self.assertEqual(hashes(output), self.expected)
        # No task was done again that the journal knew of.
        self.assertEqual(set(recorded(output).values()), {1})
        self.assertEqual(len(recorded(output)), TASKS)
        trace = json.loads((output / "trace.json").read_text())
        self.assertEqual(trace["effects"]["noise"]["calls"], SAMPLES)
        self.assertEqual(trace["effects"]["voxels"]["calls"], 6)

    def test_killed_at_random_moments(self):
        victims = []
        for number in range(KILLS):
            ranks = self.random.choice([None, 2, 2, 3])
            victim = self.random.choice(["mpirun", "rank", "tree"]) if ranks else "tree"
            moment = self.random.uniform(0, 1.1 * self.seconds)
            victims.append(victim)
            with self.subTest(number=number, seed=SEED, ranks=ranks, victim=victim,
                              moment=round(moment, 3)):
                output = self.folder / f"kill-{number}"
                process = subprocess.Popen(self.command(output, ranks), stdout=subprocess.DEVNULL,
                                           stderr=subprocess.DEVNULL)
                time.sleep(moment)
                family = descendants(process.pid)
                # A mesher that is killed costs its object alone: quarantine.py.
                below = [p for p in family if p != process.pid and program(p) == "carillon"]
                targets = {"mpirun": [process.pid], "tree": family,
                           "rank": [self.random.choice(below)] if below else family}[victim]
                for pid in targets:
                    try:
                        os.kill(pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
                process.wait(timeout=30)
                # The others notice by themselves.
                self.assertTrue(wait_for(lambda: not any(map(alive, family)), 10),
                                [p for p in family if alive(p)])
                self.finish_and_compare(output, recorded(output))
                shutil.rmtree(output)

    def interrupted_in(self, name, done):
        """A folder as a build leaves it that is killed when `done` tasks are in the journal."""
        output = self.folder / name
        process = subprocess.Popen(self.command(output, None), stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        journal = output / "journal.jsonl"
        wait_for(lambda: journal.exists() and journal.read_text().count("\n") >= done, 60)
        process.kill()
        process.wait()
        return output

    def test_killed_between_a_shard_and_its_line(self):
        for name, cut in (("no-line", lambda text: text[:text.rindex("\n", 0, -1) + 1]),
                          ("half-a-line", lambda text: text[:-20])):
            with self.subTest(name):
                output = self.folder / name
                shutil.copytree(self.whole, output)
                journal = output / "journal.jsonl"
                journal.write_text(cut(journal.read_text()))
                self.finish_and_compare(output, recorded(output))

    def test_killed_before_the_trace(self):
        output = self.folder / "no-trace"
        shutil.copytree(self.whole, output)
        old = json.loads((output / "trace.json").read_text())
        (output / "trace.json").unlink()
        self.finish_and_compare(output, recorded(output))
        trace = json.loads((output / "trace.json").read_text())
        for key in ("stages", "effects", "tasks"):
            self.assertEqual(trace[key], old[key])

    def test_leftovers_are_cleaned_up(self):
        output = self.interrupted_in("leftovers", 7)
        for name in (".index.host.123.0.tmp.h5", "samples/.bar-000-0000.vm.99.12.tmp.h5",
                     ".dataset.a.b.1.1.tmp.json"):
            (output / name).write_bytes(b"half")
        self.finish_and_compare(output, recorded(output))

    def test_the_index_opens_while_a_build_runs(self):
        output = self.folder / "watched"
        process = subprocess.Popen(self.command(output, 2), stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        self.addCleanup(process.kill)
        # The second rank rests in a task until the index knows of samples: the build cannot end
        # before, however slow the machine is.
        self.assertTrue(wait_for(lambda: recorded(output), 60))
        resting = rank_of(process.pid, 1)
        self.assertTrue(wait_for(lambda: rests_in_a_task(output, resting, 1), 60))
        seen = [0]
        while process.poll() is None:
            if resting and seen[-1] > 0:
                os.kill(resting, signal.SIGCONT)
                resting = None
            if (output / "index.h5").exists():
                try:
                    with h5py.File(output / "index.h5") as index:
                        keys = index["key"].asstr()[()] if "key" in index else []
                        if len(keys):
                            self.assertEqual(len(index["audio"][-1]), 11025)
                        self.assertEqual(len(set(keys)), len(keys))
                except FileNotFoundError:
                    continue  # between exists() and open there may be a rename
                shards = {key.split("/")[0] for key in keys}
                self.assertLessEqual({f"samples/{s}-0000" for s in shards}, set(recorded(output)))
                self.assertGreaterEqual(len(keys), seen[-1])
                if len(keys) != seen[-1]:
                    seen.append(len(keys))
            time.sleep(0.02)
        self.assertEqual(process.returncode, 0)
        self.assertTrue(0 < seen[1] < SAMPLES, seen)  # something, before all of it
        self.assertEqual(hashes(output), self.expected)

    def test_a_second_build_says_who_holds_the_folder(self):
        output = self.folder / "held"
        output.mkdir()
        with open(output / ".lock", "w") as lock:
            holder = subprocess.Popen(["flock", "-x", "-F", str(lock.name), "sleep", "60"])
            time.sleep(0.3)
            begin = time.monotonic()
            result = subprocess.run(self.command(output, None), capture_output=True, text=True,
                                    timeout=60)
            waited = time.monotonic() - begin
            holder.kill()
            holder.wait()
        self.assertEqual(result.returncode, 2)
        self.assertLess(waited, 20)
        self.assertIn(f"process {holder.pid} on ", result.stderr)


if __name__ == "__main__":
    unittest.main()
