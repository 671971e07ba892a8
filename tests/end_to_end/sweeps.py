"""A sweep as h5py and csv see it: every variant is the dataset that --set gives."""
import csv
import fcntl
import json
import os
import shutil
import signal
import subprocess
import time
import unittest

import h5py
import numpy
from interrupted import descendants, wait_for
from program import CARILLON, CONFIGS, FolderTest, run, run_json
from same import hashes

BASE = """
name: little
materials: [steel]
objects:
  - shape: tile
    parameters: {length: 100 mm, width: 80 mm, thickness: 6 mm}
  - shape: bar
    parameters: {length: 15 cm}
modes: {max_modes: 6, order: 2, element_size: 20 mm}
strikes: {per_object: 2}
audio: {seconds: 0.3 s}
listeners: [{position: [0, 0, 0.5]}]
room: {dimensions: [4 m, 3 m, 2.5 m], rt60: 0.4 s}
noise: {kind: white, snr: 30 dB}
"""
SWEEP = BASE + """
sweep:
  keys:
    modes.order: [1, 2]
    noise.snr: [20 dB, 40 dB]
"""
VARIANTS = ["order=1,snr=20dB", "order=1,snr=40dB", "order=2,snr=20dB", "order=2,snr=40dB"]
TASKS = 16


def ended_tasks(output):
    return sum(journal.read_text().count("\n") for journal in output.glob("*/journal.jsonl"))


def rows(path):
    with open(path, newline="") as file:
        return {row["variant"]: row for row in csv.DictReader(file)}


def calls(folder, stage):
    trace = json.loads((folder / "trace.json").read_text())
    return trace["stages"].get(stage, {}).get("calls", 0)


class Sweeps(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "sweep.yaml"
        cls.config.write_text(SWEEP)
        cls.output = cls.folder / "sweep"
        cls.summary = run_json("build", cls.config, "-o", cls.output, ranks=2)

    def test_every_variant_is_what_set_gives(self):
        self.assertEqual([v["variant"] for v in self.summary["variants"]], VARIANTS)
        for name, *settings in ((VARIANTS[0], "modes.order=1", "noise.snr=20 dB"),
                                (VARIANTS[3], "modes.order=2", "noise.snr=40 dB")):
            alone = self.folder / ("alone-" + name)
            overrides = [word for setting in settings for word in ("--set", setting)]
            run_json("--cache", "", "build", self.config, "-o", alone, "--set", "sweep=",
                     *overrides)
            here, there = hashes(alone), hashes(self.output / name)
            self.assertGreater(len(here), 6)
            self.assertEqual(here, there)

    def test_meshes_and_modes_are_made_once(self):
        # Two objects and two orders: four meshes and four sets; the other four are read.
        self.assertEqual(calls(self.output, "mesh"), 4)
        self.assertEqual(calls(self.output, "mesh from cache"), 4)
        self.assertEqual(calls(self.output, "modes from cache"), 4)
        solves = {name: calls(self.output / name, "solve") for name in VARIANTS}
        for order in (1, 2):
            pair = [n for name, n in solves.items() if name.startswith(f"order={order}")]
            self.assertEqual(min(pair), 0, solves)
            self.assertGreater(max(pair), 0, solves)
        plan = run_json("plan", self.config)
        self.assertEqual(plan["shared"], {"objects": 8, "meshes": 4, "solves": 4})

    def test_its_schedule_is_simulated(self):
        plan = run_json("plan", self.config, "--ranks", "1,2")["simulated"]
        alone = run_json("plan", self.config, "--set", "sweep=", "--ranks", 1)["simulated"]
        self.assertEqual(plan["tasks"]["count"], 4 * alone["tasks"]["count"])
        one, two = plan["schedules"]
        # Half of the eight objects are read from the cache, in 0.1 s at most.
        bodies = run_json("plan", self.config)["estimate"]
        self.assertAlmostEqual(one["shared_work_s"], bodies["rank_seconds"], 6)
        self.assertLess(two["makespan_s"], one["makespan_s"])
        real = [path for path in self.output.rglob("*") if path.is_file()
                and path.name not in (".lock", ".gitignore")
                and path.relative_to(self.output).parts[0] != "cache"]
        self.assertEqual(plan["files"]["count"], len(real), sorted(map(str, real)))
        # Replayed, all tasks are measured, and two ranks take what they took.
        traced = run_json("plan", self.config, "--ranks", 2, "--trace", self.output)["simulated"]
        self.assertEqual(traced["tasks"]["measured"], traced["tasks"]["count"])
        trace = json.loads((self.output / "trace.json").read_text())
        self.assertEqual(traced["last_run"], trace["runs"][-1])
        wall = sum(r["busy_s"] + r["idle_s"] - r["queued_s"] for r in trace["ranks"]) / 2
        print(f"{wall:.2f} s, simulated {traced['schedules'][0]['makespan_s']:.2f} s", flush=True)
        self.assertAlmostEqual(traced["schedules"][0]["makespan_s"] / wall, 1, delta=0.25)
        text = run("plan", self.config, "--ranks", "1,64").stdout
        self.assertIn("times for modes from cache", text)

    def test_the_table_says_what_is_in_the_datasets(self):
        table = rows(self.output / "sweep.csv")
        document = json.loads((self.output / "sweep.json").read_text())
        self.assertEqual(list(table), VARIANTS)
        for entry in document["variants"]:
            row = table[entry["variant"]]
            with h5py.File(self.output / entry["variant"] / "index.h5") as index:
                audio = index["audio"][()].astype(float)
                level = 10 * numpy.log10((audio**2).mean(axis=1))
                power = abs(numpy.fft.rfft(audio))**2
                centroid = (power * numpy.fft.rfftfreq(audio.shape[1], 1 / 44100)).sum(axis=1)
                for name, expected, tolerance in (
                        ("samples", len(audio), 0), ("modes_median", numpy.median(index["modes"]), 0),
                        ("pitch_error_worst_cents", index["pitch_error"][()].max(), 1e-4),
                        ("pitch_error_median_cents", numpy.median(index["pitch_error"]), 1e-4),
                        ("level_db_median", numpy.median(level), 1e-3),
                        ("peak_db_median", numpy.median(20 * numpy.log10(index["peak"])), 1e-3),
                        ("centroid_hz_median", numpy.median(centroid / power.sum(axis=1)), 1),
                        ("snr_db_median", numpy.median(index["noise_ratio"]), 1e-4)):
                    self.assertLessEqual(abs(float(row[name]) - expected),
                                         tolerance * max(1, abs(expected)), name)
                    self.assertAlmostEqual(entry[name], float(row[name]), delta=1e-4 * abs(expected))
            self.assertEqual(row["decay_s_median"], "", "a noise does not decay")
            self.assertEqual(row["noise.snr"], entry["values"]["noise.snr"])
        self.assertGreater(float(table[VARIANTS[0]]["pitch_error_worst_cents"]),
                           float(table[VARIANTS[2]]["pitch_error_worst_cents"]))

    def test_one_rank_another_cache_and_more_values_change_nothing(self):
        output = self.folder / "grown"
        config = self.write("half.yaml", SWEEP.replace("[20 dB, 40 dB]", "[40 dB]"))
        run_json("--cache", "", "build", config, "-o", output)
        self.assertTrue((output / "cache").is_dir(), "variants share, though no cache is kept")
        grown = run_json("--cache", "", "build", self.config, "-o", output)
        self.assertEqual(grown["tasks_run"], 8)
        there = {k: v for k, v in hashes(output).items() if not k.startswith("cache/")}
        self.assertEqual(there, hashes(self.output))
        again = run("build", self.config, "-o", output)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("nothing to do", again.stdout)

    def test_killed_and_resumed(self):
        output = self.folder / "killed"
        command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "2", CARILLON, "--cache",
                   str(self.folder / "cache-killed"), "build", str(self.config), "-o", str(output)]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for(lambda: ended_tasks(output) >= 3, 60)
        for pid in descendants(process.pid):
            os.kill(pid, signal.SIGKILL)
        process.wait()
        before = ended_tasks(output)
        rest = run_json("build", self.config, "-o", output, "--cache",
                        self.folder / "cache-killed", ranks=2)
        self.assertEqual(rest["tasks_run"], TASKS - before)
        self.assertEqual(hashes(output), hashes(self.output))

    def test_stopped_and_resumed(self):
        output, cache = self.folder / "stopped", self.folder / "cache-stopped"
        command = [CARILLON, "--cache", str(cache), "--json", "build", str(self.config), "-o",
                   str(output)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                   text=True)
        wait_for(lambda: ended_tasks(output) >= 3, 60)
        process.terminate()
        begin = time.monotonic()
        said = process.communicate(timeout=30)[0]
        self.assertEqual(process.returncode, 130)
        self.assertLess(time.monotonic() - begin, 5)  # half a second, and a busy machine
        before = ended_tasks(output)
        if said:  # on a busy machine the grace may end before the summary
            told = json.loads(said)
            self.assertEqual((told["interrupted"], told["failed_tasks"]), (True, 0))
            self.assertEqual(told["tasks_run"], before)
        self.assertFalse((output / "sweep.csv").exists(), "the table is that of a whole sweep")
        refused = run("build", self.config, "-o", output, "--set", "sweep=")
        self.assertEqual((refused.returncode, "holds a sweep" in refused.stderr), (2, True))
        rest = run_json("--cache", cache, "build", self.config, "-o", output)
        self.assertEqual(rest["tasks_run"], TASKS - before)
        self.assertEqual(hashes(output), hashes(self.output))

    def test_failures_of_one_variant_do_not_stop_the_others(self):
        config = self.write("few.yaml", BASE + "sweep:\n  keys: {modes.max_elements: [3, 1000]}\n")
        output = self.folder / "few"
        result = run("build", config, "-o", output, "--json", ranks=2)
        self.assertEqual(result.returncode, 3, result.stderr)
        bad, good = json.loads(result.stdout)["variants"]
        self.assertEqual((bad["samples"], bad["failed_tasks"]), (0, 2))
        self.assertEqual((good["samples"], good["failed_tasks"]), (4, 0))
        self.assertIsNone(bad["level_db_median"])
        failures = json.loads((output / "max_elements=3" / "failures.json").read_text())
        self.assertIn("--set 'modes.max_elements=3'", failures[0]["reproduce"])
        again = run("build", config, "-o", output)
        self.assertEqual((again.returncode, "nothing to do" in again.stdout), (3, True))

    def test_mistakes_are_found_before_anything_runs(self):
        for line, *texts in (("modes.ordr: [2]", "s.yaml:17:18", 'did you mean "order"'),
                             ("modes.order: [2, 7]", "s.yaml:17:22", "7 is out of range"),
                             ("room.rt60: [1 m]", "s.yaml:17:17", "units of a time"),
                             ("ranks.memory_per_node: [1 GB]", "s.yaml:17:5", "one for all")):
            config = self.write("s.yaml", BASE + "sweep:\n  keys:\n    " + line + "\n")
            for command in ("plan", "build"):
                result = run(command, config, "-o", self.folder / "none") \
                    if command == "build" else run(command, config)
                self.assertEqual(result.returncode, 2)
                for text in texts:
                    self.assertIn(text, result.stderr)
        self.assertFalse((self.folder / "none").exists())
        refused = run("build", self.config, "-o", self.output / VARIANTS[0])
        self.assertIn("holds a dataset", refused.stderr)
        refused = run("build", self.config, "-o", self.output, "--set", "sweep=")
        self.assertIn("holds a sweep", refused.stderr)
        refused = run("check", self.output)
        self.assertIn("name the folder of a variant", refused.stderr)

    def test_a_variant_is_not_built_while_its_sweep_is(self):
        output = self.folder / "held"
        shutil.copytree(self.output, output)
        with open(output / ".lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            refused = run("build", self.config, "-o", output / VARIANTS[0], "--set", "sweep=",
                          "--set", "modes.order=1", "--set", "noise.snr=20 dB")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("another build is writing", refused.stderr)

    def test_a_variant_is_a_dataset_like_any_other(self):
        variant = self.output / VARIANTS[1]
        self.assertEqual(run("check", variant).returncode, 0)
        again = run_json("regenerate", variant, "--sample", "3", "-o", self.folder / "again.wav")
        self.assertTrue(again["samples"][0]["identical"])

    def test_examples_are_planned(self):
        for name, variants in (("sweep-damping", 8), ("sweep-accuracy", 7)):
            plan = run_json("plan", CONFIGS / f"{name}.yaml")
            self.assertEqual(len(plan["variants"]), variants)
        listing = run("plan", CONFIGS / "sweep-damping.yaml").stdout
        self.assertIn("24 objects have 3 different meshes and 3 different solves", listing)


if __name__ == "__main__":
    unittest.main()
