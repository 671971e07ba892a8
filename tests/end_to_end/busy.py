"""200 mixed objects keep two ranks busy until the last task begins; minutes on two cores.

What other programs take of the machine does not count: a rank that is ready to compute and waits
for a processor is not idle. Where they take most of it, nothing can be said.
"""
import json
import unittest

from program import CONFIGS, FolderTest, run

MIN_SHARE = 0.95


class Busy(FolderTest):
    def test_two_ranks_are_busy(self):
        output = self.folder / "mixed"
        result = run("--cache", "", "build", CONFIGS / "mixed.yaml", "-o", output, ranks=2,
                     timeout=3000)
        self.assertEqual(result.returncode, 0, result.stderr)
        print(result.stdout)
        trace = json.loads((output / "trace.json").read_text())
        self.assertEqual(len([t for t in trace["tasks"] if t["kind"] == "modes"]), 200)
        ranks = trace["ranks"]
        wall = sum(rank["busy_s"] + rank["idle_s"] for rank in ranks)
        taken = sum(rank["queued_s"] for rank in ranks) / wall
        if taken > 0.5:
            self.skipTest(f"other programs took {100 * taken:.0f} % of the processors")
        # Counted here anew from the tasks, not read from the program's own sum.
        last = max(task["start_s"] for task in trace["tasks"])
        cpu = between = 0
        for number in range(len(ranks)):
            done = 0
            for task in trace["tasks"]:
                if task["rank"] != number:
                    continue
                between += max(0, task["start_s"] - done)
                done = task["start_s"] + task["seconds"]
                cpu += task["cpu_s"] * min(1, (last - task["start_s"]) / task["seconds"])
            between += max(0, last - done)
        queued = sum(rank["queued_s"] for rank in ranks)
        between -= queued - sum(task["queued_s"] for task in trace["tasks"])
        for task in trace["tasks"]:
            late = 1 - min(1, (last - task["start_s"]) / task["seconds"])
            queued -= task["queued_s"] * late
        fraction = cpu / (cpu + max(0, between))
        self.assertAlmostEqual(fraction, trace["runs"][-1]["busy_fraction"], 3)
        # Strictly: whatever a task waits for counts as not busy.
        strict = cpu / (len(ranks) * last - queued)
        print(f"busy {fraction:.4f}, computing {strict:.4f}")
        self.assertAlmostEqual(strict, trace["runs"][-1]["computing_fraction"], 3)
        self.assertGreater(fraction, MIN_SHARE)
        # Where others take much, the mesher's process waits for a processor, and its rank for it.
        if taken < 0.05:
            self.assertGreater(strict, MIN_SHARE)


if __name__ == "__main__":
    unittest.main()
