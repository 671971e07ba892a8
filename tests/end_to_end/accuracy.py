"""Pitch targets and the accuracy ladder, on bodies that take no time."""
import json
import pathlib
import subprocess
import sys
import unittest

import h5py

from program import CONFIGS, FolderTest, run, run_json

LADDER = """
modes: 6
orders: [2, 3]
sizes: [2.2, 1.5]
tolerances: [1e-12, 1e-6]
pitch_cents: [30, 3]
max_elements: 20000
repeats: {below: 0.05 s, most: 2}
objects:
  - shape: bar
    parameters: {length: 120 mm, width: 20 mm, height: 10 mm}
    orders: [1, 2, 3]
    reference_size: 0.7
  - shape: ring
    parameters: {radius: 50 mm, inner_radius: 30 mm, height: 15 mm}
  - mesh: missing.ply
    optional: true
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
        for value in ("0", "-5", "nan"):
            self.assertEqual(run("modes", *self.body, "--pitch-cents", value).returncode, 2)

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


class Ladder(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        config = cls.folder / "ladder.yaml"
        config.write_text(LADDER)
        cls.output = cls.folder / "out"
        cls.result = run("accuracy", config, "-o", cls.output)
        cls.document = json.loads((cls.output / "accuracy.json").read_text())

    def bodies(self):
        return self.document["objects"][:2]

    def test_errors_fall_with_the_order(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        for body, orders in zip(self.bodies(), ([1, 2, 3], [2, 3])):
            rungs = body["rungs"][:2 * len(orders)]
            self.assertEqual([r["order"] for r in rungs], [p for p in orders for _ in range(2)])
            finer = [r["worst_cents"] for r in rungs[1::2]]
            for below, above in zip(finer, finer[1:]):
                self.assertGreater(below, 1.5 * above)

    def test_references_are_far_better_than_rungs(self):
        bar, ring = self.bodies()
        self.assertEqual(bar["reference"]["solver"], "tetrahedra")
        self.assertEqual(ring["reference"]["solver"], "fourier")
        for body in (bar, ring):
            self.assertLess(body["reference"]["estimated_worst_cents"], 0.1)

    def test_estimates_are_near_the_truth(self):
        for body in self.bodies():
            for rung in body["rungs"]:
                if rung["worst_cents"] > 0.2:
                    self.assertGreater(rung["estimated_worst_cents"] / rung["worst_cents"], 0.5)
                    self.assertLess(rung["estimated_worst_cents"] / rung["worst_cents"], 3)

    def test_the_front_is_one(self):
        for body in self.bodies():
            front = [body["rungs"][i] for i in body["front"]]
            for a, b in zip(front, front[1:]):
                self.assertLess(a["seconds"], b["seconds"])
                self.assertGreater(a["worst_cents"], b["worst_cents"])
            for rung in body["rungs"]:
                self.assertTrue(any(f["seconds"] <= rung["seconds"]
                                    and f["worst_cents"] <= rung["worst_cents"] for f in front))

    def test_targets_are_met_in_truth(self):
        for body in self.bodies():
            self.assertEqual([c["asked_cents"] for c in body["chosen"]], [30, 3])
            for choice in body["chosen"]:
                self.assertTrue(choice["met"], choice)
                rung = body["rungs"][choice["rung"]]
                self.assertLess(rung["worst_cents"], 2 * choice["asked_cents"])
                self.assertGreaterEqual(choice["search_seconds"], choice["seconds"])

    def test_a_missing_file_is_passed_over(self):
        self.assertIn("missing.ply", self.document["objects"][2]["failure"])
        self.assertIn("missing.ply", self.result.stdout)

    def test_it_is_drawn(self):
        if "no picture" in self.result.stderr:
            self.assertIn("matplotlib", self.result.stderr)
            self.skipTest(self.result.stderr)
        self.assertEqual((self.output / "accuracy.png").read_bytes()[1:4], b"PNG")
        self.assertIn("half the error costs", (self.output / "accuracy.svg").read_text())

    def test_a_python_without_matplotlib_is_told(self):
        result = subprocess.run([sys.executable, "-S", "-E", SCRIPT, self.output / "accuracy.json"],
                                capture_output=True, text=True, timeout=60)
        if result.returncode == 0:
            self.skipTest("matplotlib is part of this Python itself")
        self.assertEqual(result.returncode, 4)
        self.assertIn("matplotlib", result.stderr)

    def test_ranks_wait_for_the_first(self):
        config = self.write("short.yaml", "modes: 3\norders: [2]\nsizes: [2.2]\npitch_cents: [200]\n"
                            "objects: [{shape: ring}]\n")
        document = run_json("accuracy", config, "-o", self.folder / "short", ranks=2)
        self.assertEqual(document["machine"]["ranks"], 1)
        both = run_json("accuracy", config, "-o", self.folder / "both", "--set", "ranks=all",
                        ranks=2)
        self.assertEqual(both["machine"]["ranks"], 2)

    def test_mistakes_are_named(self):
        result = run("accuracy", self.write("bad.yaml", "objects: [{shape: bowel}]\n"))
        self.assertEqual(result.returncode, 2)
        self.assertIn("bowl", result.stderr)
        needed = self.write("needed.yaml", "objects: [{mesh: none.ply}]\n")
        self.assertEqual(run("accuracy", needed, "-o", self.folder / "needed").returncode, 2)

    def test_the_ready_configuration_reads(self):
        result = run("accuracy", CONFIGS / "accuracy.yaml", "--set", "nonsense=1")
        self.assertIn("--set nonsense=1: nonsense: unknown key", result.stderr)


if __name__ == "__main__":
    unittest.main()
