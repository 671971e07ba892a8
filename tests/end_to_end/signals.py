"""SIGTERM, SIGINT and exit codes: out at once, nothing lost, no noise."""
import json
import os
import signal
import subprocess
import time
import unittest

import h5py
from interrupted import CONFIG, SAMPLES, TASKS, InterruptedTest, descendants, recorded, wait_for
from program import CARILLON, TIMEOUT_FACTOR, FolderTest, run_json
from same import hashes

# Half a second is promised (docs/guide.md); a busy machine may take longer to let a process run.
ALLOWED_S = 1.5 * TIMEOUT_FACTOR


class Signals(InterruptedTest):
    def start(self, output, ranks=None, json_output=True):
        command = [CARILLON, "--cache", "", "build", str(self.config), "-o", str(output)]
        command += ["--json"] if json_output else []
        if ranks:
            command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def wait_for_tasks(self, output, tasks):
        self.assertTrue(wait_for(lambda: len(recorded(output)) >= tasks, 120))

    def go_on(self, output, done):
        summary = run_json("--cache", "", "build", self.config, "-o", output)
        self.assertEqual(summary["tasks_run"], TASKS - len(done))
        self.assertEqual(hashes(output), hashes(self.whole))
        self.assertEqual(set(recorded(output).values()), {1})

    def test_a_build_is_out_at_once_with_130(self):
        spoke = 0
        for name, sent, tasks in (("first", signal.SIGTERM, 1), ("later", signal.SIGTERM, 8),
                                  ("ctrl-c", signal.SIGINT, 3)):
            with self.subTest(name):
                output = self.folder / name
                process = self.start(output)
                self.wait_for_tasks(output, tasks)
                begin = time.monotonic()
                process.send_signal(sent)
                out, _ = process.communicate(timeout=60)
                took = time.monotonic() - begin
                print(f"{name}: {took:.3f} s", flush=True)
                self.assertEqual(process.returncode, 130)
                self.assertLess(took, ALLOWED_S)
                done = recorded(output)
                if not out:
                    # The grace was over before a busy machine let it speak; nothing else is lost.
                    self.go_on(output, done)
                    continue
                spoke += 1
                summary = json.loads(out)
                self.assertTrue(summary["interrupted"])
                self.assertEqual(summary["tasks_run"], len(done),
                                 (output / "journal.jsonl").read_text()[-2000:])
                shards = [task for task in done if task.startswith("samples/")]
                with h5py.File(output / "index.h5") as index:
                    keys = index["key"].asstr()[()] if "key" in index else []
                self.assertEqual(summary["samples"], len(keys))
                self.assertEqual(len(keys), SAMPLES // 6 * len(shards))
                description = json.loads((output / "dataset.json").read_text())
                self.assertEqual(description["samples"], len(keys))
                self.assertEqual(json.loads((output / "failures.json").read_text()), [])
                self.go_on(output, done)
        self.assertGreater(spoke, 0)

    def test_before_the_first_task(self):
        for delay in (0, 0.05, 0.2, 1):
            output = self.folder / f"early-{delay}"
            process = self.start(output)
            time.sleep(delay)
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=60)
            # Before main() begins, which a busy machine puts off, nobody can answer but the system.
            self.assertIn(process.returncode, (130, -signal.SIGTERM) if delay < 1 else (130,))

    def test_every_rank_leaves_when_mpirun_is_told_to(self):
        output = self.folder / "told"
        process = self.start(output, ranks=2)
        self.wait_for_tasks(output, 3)
        family = descendants(process.pid)
        begin = time.monotonic()
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        print(f"mpirun: {time.monotonic() - begin:.3f} s, exit {process.returncode}", flush=True)
        self.assertNotEqual(process.returncode, 0)
        self.assertTrue(wait_for(lambda: len(descendants(family[1])) == 1, 5))
        self.go_on(output, recorded(output))

    def test_one_rank_that_is_told_ends_all(self):
        output = self.folder / "one"
        process = self.start(output, ranks=2)
        self.wait_for_tasks(output, 3)
        os.kill(descendants(process.pid)[1], signal.SIGTERM)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.go_on(output, recorded(output))

    def test_sigusr1_finishes_the_tasks_that_run(self):
        output = self.folder / "patient"
        process = self.start(output, ranks=2)
        self.wait_for_tasks(output, 3)
        process.send_signal(signal.SIGUSR1)
        out, err = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 130, err)
        self.assertEqual(json.loads(out[:out.rindex("}") + 1])["tasks_run"], len(recorded(output)))
        self.go_on(output, recorded(output))


class ExitCodes(FolderTest):
    def test_failed_tasks_come_through_mpirun_after_finalize(self):
        self.write("soup.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n")
        config = self.write("broken.yaml", CONFIG.replace(
            "objects:", "objects:\n  - {mesh: soup.obj, name: broken}"))
        result = subprocess.run(
            ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "2", CARILLON, "--cache", "",
             "build", str(config), "-o", str(self.folder / "broken")],
            capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, 3, result.stderr)
        # What mpirun says of ranks that left without MPI_Finalize, were killed or aborted.
        for noise in ("MPI_ABORT", "finalize", "noticed that process", "on signal"):
            self.assertNotIn(noise, result.stdout + result.stderr)


if __name__ == "__main__":
    unittest.main()
