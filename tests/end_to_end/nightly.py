"""`scripts/nightly`: nightly runs with a real slowdown, real cents and real crashes. Its rule has
nightly_rule.py."""
import json
import os
import pathlib
import shutil
import signal
import statistics
import subprocess
import sys
import unittest
import zlib

import numpy
from browser import expect_sections, there
from interrupted import wait_for
from program import CARILLON, FolderTest

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
from nightly_lib import history, verdicts  # noqa: E402

CONFIG = """
name: tiny
seed: 1
materials_file: own.yaml
materials: [one]
objects: [{shape: bar, parameters: {length: 20 cm, width: 2 cm, height: 1 cm}}]
modes: {max_modes: 10, order: 2, element_size: 10 mm, max_frequency: 12 kHz}
strikes: {per_object: 40}
audio: {seconds: 0.2 s, sample_rate: 22050 Hz}
mel: {bands: 64, frames: 25}
"""
MATERIAL = "one: {{youngs_modulus: {}, poisson_ratio: 0.3, density: 7800, alpha1: 2, alpha2: 3e-8}}\n"
# Before the program: nothing, more processor time in its share, another setting, or no end.
WRAPPER = """#!/usr/bin/env python3
import os, resource, subprocess, sys, time
extra = os.environ.get("EXTRA", "").split() if "build" in sys.argv else []
if "SLEEP" in os.environ and "build" in sys.argv:
    time.sleep(float(os.environ["SLEEP"]))
code = subprocess.run([os.environ["REAL"], *sys.argv[1:], *extra]).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
end = time.process_time() + float(os.environ.get("BURN", 0)) * (used.ru_utime + used.ru_stime)
while time.process_time() < end:
    pass
sys.exit(code)
"""


class NightlyRuns(FolderTest):
    def setUp(self):
        self.place = self.folder / self.id().rsplit(".", 1)[1]
        self.place.mkdir()
        (self.place / "tiny.yaml").write_text(CONFIG)
        (self.place / "own.yaml").write_text(MATERIAL.format(200e9))
        wrapper = self.place / "carillon"
        wrapper.write_text(WRAPPER)
        wrapper.chmod(0o755)
        self.history = self.place / "nightly_runs" / "history.jsonl"

    def start(self, *options, **environment):
        return subprocess.Popen(
            [sys.executable, SCRIPTS / "nightly", "--no-build", "-o", "nightly_runs", *options],
            cwd=self.place, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            env={**os.environ, "CARILLON": str(self.place / "carillon"), "REAL": CARILLON,
                 **environment})

    def run_once(self, code, *options, config="tiny.yaml", **environment):
        """What a nightly run prints, and its nightly.json. No code: one run alone may be called slower."""
        process = self.start(*options, config, **environment)
        out, err = process.communicate(timeout=300)
        if code is not None:
            self.assertEqual(process.returncode, code, out + err)
        found = max(self.place.glob("nightly_runs/*/nightly.json"), key=lambda one: one.stat().st_mtime_ns)
        return out, json.loads(found.read_text())

    def pretend_runs(self, number):
        """More nightly runs as the real ones, with noise as of a busy machine: that of a measure depends on
        its name alone, not on which others there are."""
        real, _ = history.read(self.history)
        quantiles = [statistics.NormalDist().inv_cdf((i + 0.5) / number) for i in range(number)]
        noise = {}
        for name, row in real[0]["runs"][0]["measures"].items():
            if row["kind"] in verdicts.NOISY:
                by_clock = name.startswith(("processor time", "modes of", "samples", "peak"))
                mixed = numpy.random.default_rng(zlib.crc32(name.encode())).permutation(quantiles)
                mean = numpy.mean([one["runs"][0]["measures"][name]["value"] for one in real])
                noise[name] = mean * numpy.exp((0.04 if by_clock else 0.15) * mixed)
        for i in range(number):
            record = json.loads(json.dumps(real[i % len(real)]))
            for name, values in noise.items():
                record["runs"][0]["measures"][name]["value"] = values[i]
            history.append(self.history, record)

    def words(self, found):
        return {row["name"]: row["verdict"] for row in found["measures"]
                if row["verdict"] not in ("steady", "learning", "new")}

    def test_tells_a_real_slowdown_and_real_cents_and_nothing_else(self):
        for _ in range(2):
            out, found = self.run_once(0)
            self.assertEqual((out, found["verdict"]), ("", "learning"))
        self.pretend_runs(20)
        _, found = self.run_once(0)
        self.assertEqual((found["nightly_runs"], found["verdict"]), (22, "fine"))
        self.assertLessEqual(set(self.words(found).values()), {"faster", "better"})

        # Neighbours change a run's time by a tenth from minute to minute, so that a fifth more would be
        # told most times, not always: nightly_rule.py asks how often that is.
        out, found = self.run_once(1, BURN="1.5")
        words = self.words(found)
        self.assertEqual(words.get("tiny: processor time"), "slower")
        self.assertNotIn("worse", words.values())
        self.assertIn("slower   tiny: processor time: +", out)
        row = next(row for row in found["measures"] if row["name"] == "tiny: processor time")
        self.assertLess(row["bound"] / row["typical"], 0.3)
        self.assertGreater(row["value"], row["typical"] + row["bound"])
        self.assertEqual(row["history"][-1], [found["date"], row["value"]])

        (self.place / "other.yaml").write_text(MATERIAL.format(200e9 * 2 ** (2 * 2 / 1200)))
        _, found = self.run_once(1, "--keep", "2", "--repeats", "1",
                                EXTRA=f"--set materials_file={self.place}/other.yaml")
        words = self.words(found)
        for name in ("tiny: bar-000 pitch", "tiny: material one pitch"):
            self.assertEqual(words.get(name), "worse")
            value = next(row["value"] for row in found["measures"] if row["name"] == name)
            self.assertAlmostEqual(value, 2, delta=0.01)
        self.assertEqual(words.get("tiny: files"), "worse")
        pages = sorted(self.place.glob("nightly_runs/*/report.html"), key=lambda one: one.stat().st_mtime_ns)
        if there() and pages:  # a program without npm writes none
            expect_sections(self, pages[-1], ["nightly-0", "dataset-0", "samples", "gallery"])
        kept = [path.parent for path in self.place.glob("nightly_runs/*/tiny/index.h5")]
        self.assertEqual(len(kept), 2)  # --keep
        self.assertEqual(len(list(self.place.glob("nightly_runs/*/nightly.json"))), 5)

        self.expect_accepting()

    def expect_accepting(self):
        """The cents above, accepted, are the new baseline; the old material is then two cents off."""
        accepted = self.start("--accept", "a softer alloy", "--measure", "*: * pitch",
                              "--measure", "*files")
        out, err = accepted.communicate(timeout=60)
        self.assertEqual(accepted.returncode, 0, err)
        self.assertIn("tiny: bar-000 pitch", out)
        _, found = self.run_once(None, "--repeats", "1",
                              EXTRA=f"--set materials_file={self.place}/other.yaml")
        self.assertNotIn("worse", self.words(found).values())
        _, found = self.run_once(1, "--repeats", "1")
        self.assertEqual(self.words(found).get("tiny: bar-000 pitch"), "worse")

    def test_survives_failures(self):
        shutil.copy(self.place / "tiny.yaml", self.place / "broken.yaml")
        with open(self.place / "broken.yaml", "a") as file:
            file.write("nonsense: 1\n")
        (self.place / "list.txt").write_text("# both\nbuild broken.yaml\nother: build tiny.yaml\n")
        quick = ("--repeats", "1", "--list", "list.txt")
        process = self.start(*quick)
        out, err = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 2, err)
        self.assertIn("FAILED   broken: ended with exit code 2", out)
        self.assertIn("nonsense", out)
        first, _ = history.read(self.history)
        self.assertEqual([(run["name"], run["ok"]) for run in first[0]["runs"]],
                         [("broken", False), ("other", True)])

        whole = self.history.read_bytes()
        self.history.write_bytes(whole + whole[:len(whole) // 2])  # a crash cut the second nightly run
        process = self.start(*quick)
        _, err = process.communicate(timeout=300)
        self.assertIn("1 lines cannot be read", err)
        self.assertTrue(self.history.read_bytes().startswith(whole))
        records, unreadable = history.read(self.history)
        self.assertEqual((len(records), unreadable), (2, 1))
        verdicts_of_other = {row["verdict"] for row in records[1]["runs"][1]["measures"].values()}
        self.assertIn("steady", verdicts_of_other)  # it knows the first nightly run

        out, found = self.run_once(2, "--timeout", "1", SLEEP="60")
        self.assertIn("took longer than 1 s", out)
        self.assertEqual(found["verdict"], "failed")
        out, _ = self.start("nowhere.yaml").communicate(timeout=60)
        self.assertEqual(history.read(self.history)[0][-1]["verdict"], "failed")

    def test_two_runs_do_not_overlap(self):
        first = self.start("tiny.yaml", SLEEP="120")
        try:
            wait_for(lambda: list(self.place.glob("nightly_runs/*/tiny.log")), 60)
            second = self.start("tiny.yaml")
            _, err = second.communicate(timeout=60)
            self.assertEqual(second.returncode, 2)
            self.assertIn("another nightly run is running", err)
            self.assertFalse(self.history.exists())
            first.send_signal(signal.SIGTERM)
            _, err = first.communicate(timeout=60)
            self.assertEqual(first.returncode, 2, err)
            self.assertIn("SIGTERM", history.read(self.history)[0][-1]["message"])
        finally:
            first.kill()
            first.communicate()


if __name__ == "__main__":
    unittest.main()
