"""The Python module as a process: threads, Ctrl-C, MPI, and the builds that it starts."""
import json
import os
import signal
import subprocess
import sys
import threading
import time
import unittest

from module_test import BARS, MODULE, ModuleTest, ca
from program import run_json


class Process(ModuleTest):
    def test_other_threads_go_on_while_modes_are_solved(self):
        counted = 0
        ended = threading.Event()

        def count():
            nonlocal counted
            while not ended.wait(0.001):
                counted += 1
        thread = threading.Thread(target=count)
        thread.start()
        begin = time.monotonic()
        ca.shape("bowl").modes("ceramic", solver="tetrahedra", order=2, max_frequency="8 kHz")
        seconds = time.monotonic() - begin
        ended.set()
        thread.join()
        self.assertGreater(counted, 20 * seconds)

    def interrupted(self, solve, then):
        """A process that is interrupted two seconds into a solve: what it says of it, and how it ends."""
        script = ("import carillon as ca\n"
                  "print('begins', flush=True)\n"
                  "try:\n"
                  f"    {solve}\n"
                  "except KeyboardInterrupt:\n"
                  "    print('interrupted', flush=True)\n"
                  f"{then}\n")
        process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, env={**os.environ, "PYTHONPATH": str(MODULE), "CARILLON_CACHE": ""})
        self.addCleanup(process.kill)
        self.assertEqual(process.stdout.readline(), "begins\n")
        time.sleep(2)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.stdout.readline(), "interrupted\n")
        self.assertLess(time.monotonic() - begin, 2)
        watch = threading.Timer(120, process.kill)
        watch.start()
        self.addCleanup(watch.cancel)
        said, errors = process.stdout.read(), process.stderr.read()
        self.assertEqual((process.wait(), errors), (0, ""))
        process.stdout.close()
        process.stderr.close()
        return said, time.monotonic() - begin

    def test_ctrl_c_ends_a_solve_and_the_process_does_not_wait_for_it(self):
        said, seconds = self.interrupted(
            "ca.shape('bowl').modes('ceramic', solver='tetrahedra', order=4, element_size='3 mm', "
            "max_elements=10000000, memory_limit='64 GiB')", "print('ends')")
        self.assertEqual(said, "ends\n")
        self.assertLess(seconds, 10)

    def test_after_ctrl_c_the_next_call_works(self):
        said, _ = self.interrupted(
            "[ca.shape('bowl', radius=0.07 + i / 1000).modes('ceramic', solver='tetrahedra', order=2, "
            "element_size='5 mm') for i in range(100)]",
            "print(len(ca.shape('bar').modes('steel', max_modes=3)))")
        self.assertEqual(said, "3\n")

    def test_importing_starts_no_mpi_and_changes_no_environment(self):
        script = ("import os, signal\n"
                  "before = (dict(os.environ), [signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)])\n"
                  "import carillon as ca\n"
                  "modes = ca.shape('bar').modes('steel', max_modes=3)\n"
                  "modes.strike()\n"
                  "after = (dict(os.environ), [signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)])\n"
                  "assert before == after\n"
                  "import subprocess\n"
                  "inherited = subprocess.run(['env', '-0'], capture_output=True, text=True).stdout.split('\\0')\n"
                  "assert {line.partition('=')[0] for line in inherited} - {''} == set(os.environ), inherited\n")
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(MODULE)})
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))


class Builds(ModuleTest):
    def test_a_mapping_is_planned_as_its_file_is(self):
        path = self.write("bars.yaml", json.dumps(BARS))
        plan = ca.plan(BARS, ranks=[1, 4])
        known = run_json("plan", path, "--ranks", "1,4")
        for name in ("shapes", "samples", "tasks", "estimate"):
            self.assertEqual(plan.document[name], known[name], name)
        self.assertEqual(list(plan.effects), [effect["name"] for effect in known["effects"] if effect["enabled"]])
        self.assertEqual(plan.samples, 12)
        self.assertIn("12 samples", str(plan))
        with self.assertRaisesRegex(ca.ConfigError, "did you mean"):
            ca.plan({**BARS, "audo": {}})
        with self.assertRaisesRegex(ca.FileError, r"none\.yaml"):
            ca.plan("none.yaml")

    def test_a_mapping_is_built_as_its_file_is_on_any_ranks(self):
        ca.shape("bar").modes("steel", max_modes=3, pitch_cents="off")  # MPI runs in this process
        path = self.write("built.yaml", json.dumps(BARS))
        run_json("build", path, "-o", self.folder / "file")
        dataset = ca.build(BARS, ranks=2, output=self.folder / "mapping")
        self.assertEqual((self.folder / "mapping" / "index.h5").read_bytes(),
                         (self.folder / "file" / "index.h5").read_bytes())
        self.assertEqual((dataset.samples, dataset.failures), (12, []))
        again = ca.build(path, output=self.folder / "mapping")
        self.assertEqual(again.samples, 12)
        with self.assertRaisesRegex(ca.ConfigError, "did you mean"):
            ca.build({**BARS, "audo": {}}, output=self.folder / "none")
        with self.assertRaisesRegex(ca.InputError, "glas"):
            ca.build(BARS, output=self.folder / "none", set={"materials": ["glas"]})

    def test_answers_are_scored(self):
        several = {**BARS, "objects": [{"shape": "bar", "count": 6}], "materials": ["steel", "glass"],
                   "split": {"validation": 0.2, "test": 0.5}}
        dataset = ca.build(several, output=self.folder / "several")
        rows = dataset.rows("test")
        keys, materials = dataset["key"][rows], dataset["material"][rows]
        found = ca.score(dataset.folder, "material", {"sample": keys, "class": materials}, name="truth")
        self.assertEqual(found.entries[0]["accuracy"]["mean"], 1)
        self.assertEqual(found.rows[0]["entry"], "truth")
        self.assertIn("truth", str(found))
        sure = {"sample": keys, "glass": 0.8 * (materials == "glass") + 0.1,
                "steel": 0.9 - 0.8 * (materials == "glass")}
        again = ca.score(dataset.folder, "material", sure, name="sure")
        self.assertAlmostEqual(again.entries[0]["calibration_error"], 0.1, places=5)
        self.assertEqual([row["entry"] for row in again.rows], ["sure", "truth"])
        self.assertEqual(ca.score(dataset.folder, "material").rows, again.rows)
        with self.assertRaisesRegex(ca.InputError, "have no answer"):
            ca.score(dataset.folder, "material", {"sample": keys[1:], "class": materials[1:]}, name="few")
        with self.assertRaisesRegex(ca.InputError, "name"):
            ca.score(dataset.folder, "material", {"sample": keys, "class": materials})

    def test_a_sweep_gives_its_variants(self):
        sweep = {**BARS, "sweep": {"keys": {"audio.seconds": [0.02, 0.04]}}}
        plan = ca.plan(sweep)
        self.assertEqual(plan.samples, 24)
        self.assertIn("contact", plan.effects)
        made = ca.build(sweep, output=self.folder / "sweep")
        self.assertEqual([dataset["audio"].shape for dataset in made.values()], [(12, 882), (12, 1764)])

    def test_tasks_that_fail_are_warned_of(self):
        self.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        objects = [{"mesh": str(self.folder / "flat.obj")}]
        with self.assertWarnsRegex(ca.CarillonWarning, "tasks failed"):
            dataset = ca.build({**BARS, "objects": objects}, output=self.folder / "failed")
        self.assertEqual((dataset.samples, len(dataset.failures) > 0), (0, True))
        self.assertIn("no samples", repr(dataset))

    def test_a_build_says_what_it_warns_of_and_texts_are_texts(self):
        with self.assertWarnsRegex(ca.CarillonWarning, "raise audio.gain"):
            dataset = ca.build(BARS, output=self.folder / "no",
                               set={"name": "no", "audio.dtype": "int16", "audio.gain": 1e-12})
        self.assertEqual(dataset.description["name"], "no")


if __name__ == "__main__":
    unittest.main()
