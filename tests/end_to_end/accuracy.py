"""Pitch targets and the convergence study, on objects that take no time."""
import json
import pathlib
import shlex
import subprocess
import sys
import time
import unittest

import h5py
from program import CARILLON, CONFIGS, FolderTest, draws_figures, run, run_json

STUDY = """
modes: {max_modes: 6, max_elements: 20000}
levels:
  orders: [2, 3]
  element_size_factors: [2.2, 1.5]
  tolerances: [1e-12, 1e-6]
pitch_targets: [30, 3]
repeats: {below: 0.05 s, max_runs: 2}
objects:
  - shape: bar
    parameters: {length: 120 mm, width: 20 mm, height: 10 mm}
    levels: {orders: [1, 2, 3]}
    reference: {element_size_factor: 0.7}
  - shape: ring
    parameters: {radius: 50 mm, inner_radius: 30 mm, height: 15 mm}
  - mesh: missing.ply
    optional: true
"""
# An open sheet is no object; 700 elements are enough for order 4 and not for order 3, which targets
# begin with.
FAILING = """
modes: {max_modes: 4, max_elements: 700}
levels: {orders: [4], element_size_factors: [1]}
pitch_targets: [200]
repeats: {max_runs: 1}
objects:
  - mesh: sheet.off
  - shape: ring
"""
SHEET = """OFF
4 2 0
0 0 0
0.1 0 0
0.1 0.1 0
0 0.1 0
3 0 1 2
3 0 2 3
"""
# So coarse that every mode is more than an octave sharp.
COARSE = """
modes: {max_modes: 3}
levels: {orders: [1], element_size_factors: [3, 1]}
pitch_targets: [200]
repeats: {max_runs: 1}
objects:
  - shape: ring
    parameters: {radius: 80 mm, inner_radius: 60 mm, height: 4 mm}
"""
SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "plot_accuracy"


class PitchTarget(FolderTest):
    body = ("tile", "-m", "steel", "--max-modes", "8", "--order", "2", "--element-size", "45 mm")

    def test_refines_until_the_estimate_meets_it(self):
        first = run_json("modes", *self.body)
        target = 0.2 * max(mode["pitch_error_cents"] for mode in first["modes"])
        result = run_json("modes", *self.body, "--pitch-cents", target)
        report = result["pitch_target"]
        self.assertTrue(report["met"])
        self.assertIsNone(report["stopped_by"])
        self.assertEqual(report["asked_cents"], target)
        self.assertLessEqual(report["reached_cents"], target)
        self.assertEqual(report["reached_cents"],
                         max(mode["pitch_error_cents"] for mode in result["modes"]))
        self.assertGreater(len(report["steps"]), 1)
        self.assertEqual(report["steps"][0]["unknowns"], first["certificate"]["unknowns"])
        for step in report["steps"]:
            self.assertLessEqual({"order", "element_size_m", "unknowns", "seconds", "worst_cents"},
                                 set(step))

    def test_nothing_is_solved_twice(self):
        arguments = ("modes", *self.body, "--pitch-cents", 3)
        first = run_json(*arguments)
        second = run_json(*arguments)
        self.assertNotIn("solve_s", second["timing"])
        self.assertEqual(first["modes"], second["modes"])

    def test_a_loose_target_keeps_the_first_setting(self):
        result = run_json("strike", *self.body, "-o", self.folder / "tile.wav", "--pitch-cents", 5000)
        self.assertEqual(len(result["pitch_target"]["steps"]), 1)

    def test_the_table_names_errors_and_steps(self):
        text = run("modes", *self.body, "--pitch-cents", 3).stdout
        for words in ("error [cent]", "estimated pitch error: worst", "pitch target 3 cents: met",
                      "chosen"):
            self.assertIn(words, text)

    def test_ranks_choose_alike(self):
        arguments = ("--cache", "", "modes", *self.body, "--pitch-cents", 5)
        one = run_json(*arguments)["pitch_target"]
        two = run_json(*arguments, ranks=2)["pitch_target"]
        self.assertEqual([(s["order"], s["element_size_m"]) for s in one["steps"]],
                         [(s["order"], s["element_size_m"]) for s in two["steps"]])

    def test_a_target_that_is_none_is_refused(self):
        for value in ("0.001", "-5", "nan", "of"):
            self.assertEqual(run("modes", *self.body, "--pitch-cents", value).returncode, 2)

    def test_off_and_given_elements_keep_the_mesh(self):
        self.assertNotIn("pitch_target", run_json("modes", "tile", "-m", "steel", "--max-modes", 8,
                                                  "--pitch-cents", "off"))
        self.assertNotIn("pitch_target", run_json("modes", *self.body))
        target = run_json("modes", "tile", "-m", "steel", "--max-modes", 8)["pitch_target"]
        self.assertEqual(target["asked_cents"], 5)

    def test_a_budget_is_kept_and_named(self):
        arguments = ("modes", "tile", "-m", "steel", "--max-modes", 8, "--max-unknowns", 20000)
        result = run(*arguments, "--pitch-cents", 0.05, "--json")
        self.assertEqual(result.returncode, 3)
        report = json.loads(result.stdout)["pitch_target"]
        self.assertEqual(report["stopped_by"], "max_unknowns")
        self.assertIn("20000 unknowns", report["reason"])
        # A default that is missed is a warning.
        missed = run("modes", "tile:thickness=4mm,width=25cm,length=25cm", "-m", "steel", "--max-unknowns", 100)
        self.assertEqual(missed.returncode, 0)
        self.assertIn("is not met", missed.stderr)

    def test_a_build_refines_each_shape(self):
        config = self.write("build.yaml", "materials: [steel, glass]\nobjects: [{shape: tile}]\n"
                            "modes: {max_modes: 6, order: 2, element_size: 45 mm}\n"
                            "solver: {pitch_cents: 5}\n"
                            "strikes: {per_object: 1}\naudio: {seconds: 0.1 s}\n")
        summary = run_json("build", config, "-o", self.folder / "build")
        self.assertEqual(summary["failed_tasks"], 0)
        with h5py.File(self.folder / "build" / "modes" / "tile-000.h5") as file:
            report = json.loads(file.attrs["pitch_target"])
            worst = max(file[name]["pitch_errors"][:].max() for name in file if "set" in name)
        self.assertTrue(report["met"])
        self.assertLessEqual(worst, 5)
        self.assertNotIn("seconds", report["steps"][0])


class Study(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        config = cls.folder / "study.yaml"
        config.write_text(STUDY)
        cls.output = cls.folder / "out"
        cls.result = run("accuracy", config, "-o", cls.output)
        cls.document = json.loads((cls.output / "accuracy.json").read_text())

    def bodies(self):
        return self.document["objects"][:2]

    def test_errors_fall_with_the_order(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        for body, orders in zip(self.bodies(), ([1, 2, 3], [2, 3])):
            levels = body["levels"][:2 * len(orders)]
            self.assertEqual([r["order"] for r in levels], [p for p in orders for _ in range(2)])
            finer = [r["worst_cents"] for r in levels[1::2]]
            for below, above in zip(finer, finer[1:]):
                self.assertGreater(below, 1.5 * above)

    def test_references_are_far_better_than_levels(self):
        bar, ring = self.bodies()
        self.assertEqual(bar["reference"]["solver"], "tetrahedra")
        self.assertEqual(ring["reference"]["solver"], "axisymmetric")
        for body in (bar, ring):
            self.assertLess(body["reference"]["estimated_worst_cents"], 0.1)

    def test_estimates_are_near_the_truth(self):
        for body in self.bodies():
            for level in body["levels"]:
                if level["worst_cents"] > 0.2:
                    self.assertGreater(level["estimated_worst_cents"] / level["worst_cents"], 0.5)
                    self.assertLess(level["estimated_worst_cents"] / level["worst_cents"], 3)

    def test_the_front_is_one(self):
        for body in self.bodies():
            front = [body["levels"][i] for i in body["front"]]
            for a, b in zip(front, front[1:]):
                self.assertLess(a["seconds"], b["seconds"])
                self.assertGreater(a["worst_cents"], b["worst_cents"])
            for level in body["levels"]:
                self.assertTrue(any(f["seconds"] <= level["seconds"]
                                    and 0.999 * f["worst_cents"] <= level["worst_cents"]
                                    for f in front))

    def test_targets_are_met_in_truth(self):
        for body in self.bodies():
            self.assertEqual([c["asked_cents"] for c in body["chosen"]], [30, 3])
            for choice in body["chosen"]:
                self.assertTrue(choice["met"], choice)
                level = body["levels"][choice["level"]]
                self.assertLess(level["worst_cents"], 2 * choice["asked_cents"])
                self.assertGreaterEqual(choice["search_seconds"], choice["seconds"])

    def test_the_command_of_a_choice_chooses_the_same(self):
        choice = self.bodies()[1]["chosen"][1]
        program, *arguments = shlex.split(choice["command"])
        self.assertEqual(program, "carillon")
        report = run_json(*arguments)["pitch_target"]
        self.assertEqual(report["chosen"], choice["chosen"])
        for ours, theirs in zip(choice["steps"], report["steps"], strict=True):
            for key in ("order", "element_size_m", "unknowns"):
                self.assertEqual(ours[key], theirs[key])
            self.assertAlmostEqual(ours["worst_cents"] / theirs["worst_cents"], 1, places=4)

    def test_a_missing_file_is_passed_over(self):
        self.assertTrue(self.document["objects"][2]["passed_over"])
        self.assertIn("missing.ply", self.document["objects"][2]["failure"])
        self.assertIn("missing.ply", self.result.stdout)

    def test_it_is_drawn(self):
        if not draws_figures():
            self.skipTest("no Python that is tried has matplotlib")
        self.assertNotIn("no picture", self.result.stderr)
        self.assertEqual((self.output / "accuracy.png").read_bytes()[1:4], b"PNG")
        svg = (self.output / "accuracy.svg").read_text()
        for words in ("Half the error costs", "half the error: ", "6 modes, "):
            self.assertIn(words, svg)

    def test_a_python_without_matplotlib_is_told(self):
        result = subprocess.run([sys.executable, "-S", "-E", SCRIPT, self.output / "accuracy.json"],
                                capture_output=True, text=True, timeout=60)
        if result.returncode == 0:
            self.skipTest("matplotlib is part of this Python itself")
        self.assertEqual(result.returncode, 4)
        self.assertIn("matplotlib", result.stderr)

    def test_ranks_wait_for_the_first(self):
        config = self.write("short.yaml", "modes: {max_modes: 3}\n"
                            "levels: {orders: [2], element_size_factors: [2.2]}\n"
                            "pitch_targets: [200]\n"
                            "objects: [{shape: ring}]\n")
        document = run_json("accuracy", config, "-o", self.folder / "short", ranks=2)
        self.assertEqual(document["machine"]["ranks"], 1)
        both = run_json("accuracy", config, "-o", self.folder / "both", "--set", "all_ranks=true",
                        ranks=2)
        self.assertEqual(both["machine"]["ranks"], 2)

    def test_equal_elements_are_solved_once(self):
        config = self.write("equal.yaml", "modes: {max_modes: 3}\n"
                            "levels: {orders: [2], element_size_factors: [2.2, 2.2001]}\n"
                            "pitch_targets: [200]\nobjects: [{shape: ring}]\n")
        first, second = run_json("accuracy", config, "-o", self.folder / "equal")[
            "objects"][0]["levels"][:2]
        self.assertNotEqual(first["element_size_m"], second["element_size_m"])
        self.assertEqual(first["elements"], second["elements"])
        for key in ("frequencies_hz", "seconds", "stages", "runs"):
            self.assertEqual(first[key], second[key])

    def test_mistakes_are_named(self):
        result = run("accuracy", self.write("bad.yaml", "objects: [{shape: bowel}]\n"))
        self.assertEqual(result.returncode, 2)
        self.assertIn("bowl", result.stderr)
        needed = self.write("needed.yaml", "objects: [{mesh: none.ply}]\n")
        result = run("accuracy", needed, "-o", self.folder / "needed")
        self.assertEqual(result.returncode, 2)
        self.assertIn("needed.yaml:1:18: objects[0].mesh", result.stderr)
        self.assertFalse((self.folder / "needed").exists())

    def test_the_ready_configuration_reads(self):
        result = run("accuracy", CONFIGS / "accuracy.yaml", "--set", "nonsense=1")
        self.assertIn("--set nonsense=1: nonsense: unknown key", result.stderr)


class Failures(FolderTest):
    def test_what_was_measured_stays(self):
        self.write("sheet.off", SHEET)
        output = self.folder / "failing"
        result = run("accuracy", self.write("failing.yaml", FAILING), "-o", output)
        self.assertEqual(result.returncode, 3, result.stderr)
        sheet, ring = json.loads((output / "accuracy.json").read_text())["objects"]
        self.assertEqual(sheet["name"], "sheet")
        self.assertIn("bounds no body", sheet["failure"])
        self.assertFalse(sheet["passed_over"])
        # The target fails, and so does the automatic size of order 3; order 4 stands.
        self.assertNotIn("failure", ring)
        self.assertLess(ring["levels"][0]["worst_cents"], 5)
        self.assertEqual(ring["front"], [0])
        choice = ring["chosen"][0]
        self.assertEqual((choice["asked_cents"], choice["met"]), (200, False))
        self.assertIn("max_elements", choice["failure"])
        self.assertIn("--max-elements 700", choice["command"])
        self.assertIsNone(ring["levels"][1]["element_size_m"])
        self.assertIn("failed: the mesh needs", result.stdout)

    def test_a_level_without_every_mode_fails(self):
        output = self.folder / "coarse"
        result = run("accuracy", self.write("coarse.yaml", COARSE), "-o", output)
        self.assertEqual(result.returncode, 0, result.stderr)
        ring = json.loads((output / "accuracy.json").read_text())["objects"][0]
        # The third mode is half of a pair.
        self.assertEqual(ring["reference"]["modes"], 2)
        coarse, finer, chosen = ring["levels"]
        self.assertIn("finds 0 of the 2 modes", coarse["failure"])
        self.assertNotIn("worst_cents", coarse)
        self.assertGreater(coarse["seconds"], 0)
        self.assertEqual(coarse["size_factor"], 3)
        self.assertAlmostEqual(coarse["element_size_m"] / finer["element_size_m"], 3)
        self.assertNotIn(0, ring["front"])
        self.assertGreater(finer["worst_cents"], 100)
        self.assertLess(chosen["worst_cents"], 200)
        self.assertIn("finds 0 of the 2 modes", result.stdout)

    def test_what_is_done_is_written_while_the_rest_runs(self):
        output = self.folder / "long"
        config = self.write("long.yaml", "modes: {max_modes: 3}\n"
                            "levels: {orders: [3], element_size_factors: [1, 0.3]}\n"
                            "pitch_targets: [200]\nrepeats: {max_runs: 1}\n"
                            "objects: [{shape: ring, levels: {element_size_factors: [2]}}, {shape: bowl}]\n")
        with subprocess.Popen([CARILLON, "accuracy", config, "-o", output],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                deadline = time.monotonic() + 200
                while not (output / "accuracy.json").exists():
                    self.assertLess(time.monotonic(), deadline)
                    self.assertIsNone(process.poll())
                    time.sleep(0.02)
                document = json.loads((output / "accuracy.json").read_text())
            finally:
                process.kill()
        self.assertEqual([body["name"] for body in document["objects"]], ["ring"])
        self.assertFalse(document["finished"])


if __name__ == "__main__":
    unittest.main()
