"""Simulated schedules: `plan --ranks` against real builds whose task times it replays."""
import json
import unittest

from program import FolderTest, run, run_json

CONFIG = """
name: replayed
materials: [steel, ceramic]
objects:
  - {shape: bar, count: 3}
  - {shape: tile}
modes: {max_modes: 20, max_frequency: 12 kHz, order: 2}
audio: {seconds: 0.5 s, sample_rate: 22050 Hz}
strikes: {per_object: 150}
mel: {bands: 32, frames: 9}
split: {validation: 0, test: 0}
"""
SHAPES, SHARDS = 4, 8


class Simulate(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "replayed.yaml"
        cls.config.write_text(CONFIG)
        cls.walls = {}
        for ranks in (1, 2, 4):
            run_json("--cache", "", "build", cls.config, "-o", cls.folder / f"on-{ranks}",
                     ranks=ranks)
            trace = json.loads((cls.folder / f"on-{ranks}" / "trace.json").read_text())
            # What other programs, or more ranks than cores, took is in no simulated time.
            cls.walls[ranks] = sum(one["busy_s"] + one["idle_s"] - one["queued_s"]
                                   for one in trace["ranks"]) / ranks

    def plan(self, *options, config=None):
        return run_json("plan", config or self.config, *options)["simulated"]

    def replayed(self, ranks):
        plan = self.plan("--ranks", ranks, "--trace", self.folder / f"on-{ranks}")
        self.assertEqual(plan["tasks"]["measured"], plan["tasks"]["count"])
        trace = json.loads((self.folder / f"on-{ranks}" / "trace.json").read_text())
        self.assertEqual(plan["last_run"], trace["runs"][-1])
        return plan["schedules"][0]

    def test_replayed_times_make_the_real_wall_time(self):
        for ranks in (1, 2):
            made = self.replayed(ranks)
            print(f"{ranks} ranks: {self.walls[ranks]:.2f} s, simulated {made['makespan_s']:.2f} s")
            self.assertAlmostEqual(made["makespan_s"] / self.walls[ranks], 1, delta=0.1)

    def test_four_ranks_are_reported(self):
        # More ranks than cores: what it shows is the order of tasks, not the machine.
        made = self.replayed(4)
        print(f"4 ranks: {self.walls[4]:.2f} s, simulated {made['makespan_s']:.2f} s")
        self.assertAlmostEqual(made["makespan_s"] / self.walls[4], 1, delta=0.4)

    def test_more_ranks_take_no_longer_down_to_the_longest_chain(self):
        plan = self.plan("--ranks", "1,2,4,64,4096", "--ranks-per-node", 64, "--trace",
                         self.folder / "on-1")
        schedules = plan["schedules"]
        spans = [one["makespan_s"] for one in schedules]
        for wider, narrower in zip(spans[1:], spans):
            self.assertLessEqual(wider, narrower * 1.05)
        for one in schedules:
            self.assertGreaterEqual(one["makespan_s"],
                                    max(one["shared_work_s"], one["longest_chain_s"]) - 1e-9)
            self.assertAlmostEqual(
                one["efficiency"] * one["ranks"] * one["makespan_s"],
                one["shared_work_s"] * one["ranks"], places=6)
        self.assertGreater(schedules[0]["efficiency"], 0.95)
        self.assertEqual(schedules[0]["limited_by"], "work")
        self.assertLess(schedules[-1]["efficiency"], 0.01)
        self.assertEqual(schedules[-1]["limited_by"], "longest chain")
        self.assertEqual([one["nodes"] for one in schedules], [1, 1, 1, 1, 64])

    def test_files_are_those_that_a_build_writes(self):
        files = self.plan("--ranks", 1)["files"]
        output = self.folder / "on-1"
        real = [path for path in output.rglob("*") if path.is_file() and path.name != ".lock"]
        self.assertEqual(files["count"], len(real))
        self.assertEqual((files["modes"], files["shards"]), (SHAPES, SHARDS))
        largest = max(path.stat().st_size for path in output.rglob("samples/*.h5"))
        self.assertLess(files["largest_shard_bytes"], 1.6 * largest)
        self.assertGreater(files["largest_shard_bytes"], largest / 1.6)

    def test_tasks_that_were_not_measured_take_the_ratio_of_their_kind(self):
        larger = self.plan("--ranks", 1, "--trace", self.folder / "on-1", "--set",
                           "strikes.per_object=300")
        # The modes and the first shard of each shape are the same pieces of work as before; the
        # second of 44 sounds is one of 256 now, and the third is new.
        self.assertEqual(larger["tasks"]["measured"], 2 * SHAPES)
        self.assertEqual(larger["tasks"]["count"], 4 * SHAPES)
        same = self.replayed(1)["shared_work_s"]
        journal = (self.folder / "on-1" / "journal.jsonl").read_text().splitlines()
        seconds = {entry["task"]: entry["seconds"] - entry["times"]["queued_s"]
                   for entry in map(json.loads, journal)}
        sounds = sum(s for task, s in seconds.items() if task.startswith("samples/"))
        self.assertAlmostEqual(larger["schedules"][0]["shared_work_s"], same + sounds,
                               delta=0.35 * sounds)

    def test_wrong_questions_are_answered(self):
        for options, words in ((["--ranks", "0"], "--ranks"), (["--ranks", "2,x"], "--ranks"),
                               (["--trace", "x"], "--ranks"),
                               (["--ranks", "2", "--trace", "nowhere"], "nowhere"),
                               (["--ranks", "2", "--trace", self.folder], "no finished task")):
            result = run("plan", self.config, *options)
            self.assertEqual(result.returncode, 2, result.stdout)
            self.assertIn(words, result.stderr)

    def test_nodes_have_the_memory_that_is_given(self):
        estimate = run_json("plan", self.config)["estimate"]["memory_bytes_per_rank"]
        # One object beside four ranks that hold what an idle one does.
        memory = f"ranks.memory_per_node={int(estimate + 3 * 1.3e8) + 1} B"
        free, tight = (self.plan("--ranks", 4, "--trace", self.folder / "on-1", *more)
                       ["schedules"][0] for more in ((), ("--set", memory)))
        self.assertEqual((free["refused_tasks"], free["memory_wait_s"]), (0, 0))
        self.assertEqual(tight["refused_tasks"], 0)
        self.assertEqual(tight["limited_by"], "memory of nodes")
        self.assertGreater(tight["makespan_s"], 1.5 * free["makespan_s"])
        self.assertLessEqual(tight["node_memory_bytes"], estimate + 1)
        text = run("plan", self.config, "--ranks", "4", "--set", "ranks.memory_per_node=1 MiB")
        self.assertIn("on 4 ranks 12 of 12 tasks are refused", text.stdout)

    def test_the_last_run_of_a_trace_is_told(self):
        text = run("plan", self.config, "--ranks", "2", "--trace", self.folder / "on-2").stdout
        self.assertRegex(text, r"the trace's last run: .* on 2 ranks, busy .* %.*, computing .* %")
        self.assertRegex(text, r"\nidle: rank 0 .* s, rank 1 .* s\n")

    def test_the_table_has_a_line_for_each_number_of_ranks(self):
        text = run("plan", self.config, "--ranks", "1,4096", "--ranks-per-node", "64").stdout
        lines = [line.split() for line in text.splitlines()]
        self.assertIn(["1", "1"], [words[:2] for words in lines])
        self.assertIn(["4096", "64"], [words[:2] for words in lines])


if __name__ == "__main__":
    unittest.main()
