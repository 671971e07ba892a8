"""Bodies on groups of ranks, tasks within a node's memory, and what the trace tells of them."""
import hashlib
import json
import unittest

import h5py
import numpy
from program import LONG, FolderTest, of_memory, run, run_json

CONFIG = """
name: groups
materials: [steel]
ranks: {unknowns_per_rank: 1000, widest_group: 2}
objects:
  - shape: tile
    name: large
    parameters: {length: 200 mm, width: 190 mm, thickness: 8 mm}
  - shape: bar
    name: small
    count: 2
modes: {order: 2, element_size: 45 mm, max_modes: 8}
strikes: {per_object: 2}
audio: {seconds: 0.1 s}
"""
# Relative, of frequencies by groups of different widths.
TOLERANCE = 1e-8
ROW = {"task", "kind", "estimate_s", "seconds", "cpu_s", "rank", "width", "start_s"}


def sums(folder, names):
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


class Groups(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.outputs = {}
        for ranks in (1, 2, 3, 4):
            output = cls.folder / f"on-{ranks}"
            config = cls.write(cls, "groups.yaml", CONFIG)
            cls.outputs[ranks] = (output, run_json("--cache", "", "build", config, "-o", output,
                                                   ranks=ranks))

    def test_small_bodies_have_the_same_bits_on_any_number_of_ranks(self):
        names = [f"{kind}/small-{i:03}{end}.h5" for i in range(2)
                 for kind, end in (("modes", ""), ("samples", "-0000"))]
        expected = sums(self.outputs[1][0], names)
        for ranks in (2, 3, 4):
            self.assertEqual(sums(self.outputs[ranks][0], names), expected)

    @of_memory
    def test_estimated_memory_is_what_a_body_takes(self):
        # A solid object, a section, and a thin-walled one, whose modes are judged by other means.
        shapes = [("block", "tetrahedra"), ("cup", "axisymmetric"), ("bowl", "tetrahedra")]
        for shape, solver in shapes if LONG else shapes[:2]:
            config = self.write(f"{shape}.yaml", f"""
materials: [iron]
objects: [{{shape: {shape}, solver: {solver}}}]
modes: {{max_modes: 60}}
strikes: {{per_object: 1}}
audio: {{seconds: 0.1 s}}
""")
            plan = run_json("plan", config)
            run_json("--cache", "", "build", config, "-o", self.folder / shape)
            trace = json.loads((self.folder / shape / "trace.json").read_text())
            ratio = (trace["ranks"][0]["peak_memory_bytes"] /
                     plan["estimate"]["memory_bytes_per_rank"])
            self.assertTrue(0.6 < ratio < 1.5, f"{shape}: {ratio:.2f} times the estimate")

    def test_large_bodies_agree(self):
        def read(ranks):
            with h5py.File(self.outputs[ranks][0] / "modes" / "large-000.h5") as file:
                self.assertTrue(file["set-000/certificate"].attrs["complete_to_hz"] > 0)
                return file["set-000/eigenvalues"][()]
        alone = read(1)
        self.assertEqual(len(alone), 8)
        for ranks in (2, 3, 4):
            # Frequencies are square roots: half the error.
            numpy.testing.assert_allclose(read(ranks), alone, rtol=2 * TOLERANCE)

    def test_the_trace_has_every_task(self):
        for ranks, (output, summary) in self.outputs.items():
            self.assertEqual(summary["tasks_run"], 6)
            trace = json.loads((output / "trace.json").read_text())
            rows = {row["task"]: row for row in trace["tasks"]}
            self.assertEqual(len(rows), 6)
            for row in rows.values():
                self.assertLessEqual(ROW, set(row))
                self.assertGreater(row["cpu_s"], 0)
                self.assertLess(row["rank"], ranks)
            self.assertEqual(rows["modes/large-000"]["width"], min(2, ranks))
            self.assertEqual(rows["modes/large-000"]["kind"], "modes of groups")
            self.assertEqual(rows["samples/large-000-0000"]["width"], 1)
            self.assertEqual(rows["modes/small-001"]["width"], 1)
            self.assertEqual(len(trace["ranks"]), ranks)
            for rank in trace["ranks"]:
                self.assertGreater(rank["peak_memory_bytes"], 1e7)
            run_entry = trace["runs"][0]
            self.assertEqual(run_entry["run"], 1)
            self.assertEqual(run_entry["estimates"]["samples"]["tasks"], 3)
            self.assertTrue(0 < run_entry["busy_fraction"] <= 1)

    def test_the_plan_tells_of_groups(self):
        plan = run_json("plan", self.folder / "groups.yaml")
        self.assertEqual(plan["groups"], [{"ranks": 1, "tasks": 5}, {"ranks": 2, "tasks": 1}])

    def test_a_task_that_no_node_can_hold_is_a_failure_with_its_reason(self):
        output = self.folder / "narrow"
        result = run("build", self.folder / "groups.yaml", "-o", output, "--set",
                     "ranks.memory_per_node=100 MB", ranks=2)
        self.assertEqual(result.returncode, 3, result.stderr)
        failures = json.loads((output / "failures.json").read_text())
        self.assertEqual(len(failures), 3)
        for failure in failures:
            self.assertEqual(failure["kind"], "LimitError")
            self.assertIn("more than any node has", failure["message"])
            self.assertIn("ranks.memory_per_node", failure["hint"])
        # A node of another size goes on in the same folder.
        result = run("build", self.folder / "groups.yaml", "-o", output, "--retry-failed", ranks=2)
        self.assertEqual(result.returncode, 0, result.stderr)


if __name__ == "__main__":
    unittest.main()
