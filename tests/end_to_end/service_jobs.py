"""`carillon serve --jobs`: builds and scores queued on disk, cancelled, found again after a crash of the
service, handed to Slurm; configurations and answers that name nothing of the machine's."""
import json
import os
import pathlib
import resource
import signal
import stat
import time
import unittest
import urllib.parse

import h5py
from program import TIMEOUT_FACTOR, FolderTest, run, run_json
from same import hashes
from server import CONFIG, Server

SLOW = CONFIG.replace("count: 2", "count: 16").replace("name: small", "name: slow")
LABELLED = """
name: labelled
seed: 2
materials: [steel, glass]
objects: [{shape: bar, count: 12}]
modes: {max_modes: 5, order: 2, element_size: 20 mm, max_frequency: 8 kHz}
strikes: {per_object: 2}
audio: {seconds: 0.1 s, sample_rate: 22050 Hz, gain: 100}
"""
# What a controller would do, without one: each job runs at once, and squeue looks whether it does.
SLURM = {
    "sbatch": """
for word in "$@"; do
  case $word in
    --chdir=*) cd "${word#*=}" ;;
    --output=*) log=${word#*=} ;;
    --ntasks=*) export SLURM_NTASKS=${word#*=} ;;
    --export=*) rest=${word#*=ALL,}; export "${rest%%,*}" "${rest#*,}" ;;
    -*) ;;
    *) break ;;
  esac
  shift
done
echo "$@" >sbatch.txt
export SLURM_JOB_ID=77 SLURM_SUBMIT_DIR=$PWD
# Programs that the service asks have its signals blocked; what Slurm starts has not.
/usr/bin/python3 -c 'import os, signal, sys
signal.pthread_sigmask(signal.SIG_SETMASK, [])
os.setsid()
os.execvp("bash", ["bash", *sys.argv[1:]])' "$@" >>"$log" 2>&1 </dev/null &
echo $! >"$SLURM_PIDS/77"
echo 77
""",
    "squeue": 'kill -0 "$(cat "$SLURM_PIDS/77")" 2>/dev/null && echo RUNNING || echo COMPLETED\n',
    "scancel": 'echo "$@" >>"$SLURM_PIDS/cancelled"; kill "$(cat "$SLURM_PIDS/77")"\n',
    "srun": "exit 1\n",
}


class ServiceJobs(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.folder / "labelled.yaml").write_text(LABELLED)
        assert run("build", "labelled.yaml", cwd=cls.folder).returncode == 0
        (cls.folder / "alone.yaml").write_text(SLOW)
        assert run("build", "alone.yaml", "-o", "alone", cwd=cls.folder).returncode == 0

    def serve(self, *arguments, **options):
        server = Server("labelled", "--cache", "", "--jobs", self.id().split(".")[-1], "--ranks", "2", "--workers", "1",
                        *arguments, cwd=self.folder, **options)
        self.addCleanup(server.process.kill)
        return server

    def queue(self, server, configuration, **query):
        status, job = server.ask_json("/v1/jobs?" + urllib.parse.urlencode(query), configuration.encode())
        self.assertEqual(status, 202, job)
        return job["id"]

    def output(self, number):
        return self.folder / self.id().split(".")[-1] / f"{number:06}" / "dataset"

    def running(self, server, number, tasks=3):
        """The job's document when it has done some tasks."""
        end = time.monotonic() + 60 * TIMEOUT_FACTOR
        while True:
            job = server.job(number, ("running", "done", "failed"))
            self.assertEqual(job["state"], "running", job)
            if job.get("progress", {}).get("tasks", {}).get("done", 0) >= tasks:
                return job
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)

    def test_builds_run_one_after_another(self):
        server = self.serve()
        first = self.queue(server, SLOW)
        second = self.queue(server, CONFIG, command="build", ranks=1)
        self.running(server, first)
        self.assertEqual(server.job(second, ("queued",))["state"], "queued")
        job = server.job(first)
        self.assertEqual((job["state"], job["exit_code"], job["result"]["failed_tasks"]), ("done", 0, 0))
        self.assertEqual(job["progress"]["samples"], {"all": 32, "done": 32, "failed": 0})
        self.assertEqual(hashes(self.output(first)), hashes(self.folder / "alone"))
        self.assertEqual(server.job(second)["state"], "done")
        # They are served with the others, and on the page.
        _, told = server.ask_json("/v1/datasets")
        self.assertEqual({dataset["name"] for dataset in told["datasets"]}, {"labelled", "slow", "small"})
        self.assertIn(b"slow", server.ask("/")[1])
        _, told = server.ask_json("/v1/jobs")
        self.assertEqual([job["id"] for job in told["jobs"]], [second, first])
        self.assertEqual(server.stop()[0], 0)

    def test_cancelled(self):
        server = self.serve()
        first, second = self.queue(server, SLOW), self.queue(server, SLOW)
        self.running(server, first)
        for number in (second, first):
            self.assertEqual(server.ask_json(f"/v1/jobs/{number}", method="DELETE")[0], 200)
            self.assertEqual(server.job(number)["state"], "cancelled")
        self.assertFalse(self.output(second).exists())
        # A build keeps what it has done, as after Ctrl-C.
        self.assertEqual(run_json("status", self.output(first), cwd=self.folder)["state"], "interrupted")
        status, told = server.ask_json(f"/v1/jobs/{first}", method="DELETE")
        self.assertEqual((status, told["error"]["message"]), (400, f"job {first} is over"))
        for name in ("9", "0", "99999999999", "x"):
            self.assertEqual(server.ask(f"/v1/jobs/{name}")[0], 404)
        self.assertEqual(server.stop()[0], 0)

    def test_what_was_stopped_goes_on(self):
        server = self.serve()
        number = self.queue(server, SLOW)
        self.running(server, number)
        self.assertEqual(server.stop()[0], 0)
        server = self.serve()
        job = server.job(number)
        self.assertEqual((job["state"], job["starts"]), ("done", 1), job)
        self.assertEqual(hashes(self.output(number)), hashes(self.folder / "alone"))
        self.assertEqual(server.stop()[0], 0)

    def test_what_runs_is_found_again_when_the_service_was_killed(self):
        server = self.serve()
        number = self.queue(server, SLOW)
        self.running(server, number)
        server.process.kill()
        server.process.wait()
        server = self.serve()
        job = server.job(number)
        self.assertEqual((job["state"], job["exit_code"], job["starts"]), ("done", 0, 1), job)
        self.assertEqual(server.stop()[0], 0)

    def test_a_command_that_crashes(self):
        server = self.serve()
        number = self.queue(server, SLOW)
        self.running(server, number)
        # The ranks and their mpirun.
        (process,) = [json.loads((self.output(number).parent / "job.json").read_text())["process"]]
        group = process["pid"]
        for entry in pathlib.Path("/proc").glob("[0-9]*/stat"):
            fields = entry.read_text().rsplit(")", 1)[1].split()
            if int(fields[1]) == group:
                os.kill(int(entry.parent.name), signal.SIGKILL)
        job = server.job(number)
        self.assertEqual((job["state"], job["exit_code"]), ("failed", 128 + signal.SIGKILL), job)
        # The next one runs.
        self.assertEqual(server.job(self.queue(server, CONFIG))["state"], "done")
        self.assertEqual(server.stop()[0], 0)

    def test_what_is_wrong_with_a_configuration(self):
        server = self.serve("--max-jobs", "2")
        for text, message in [
            ("objects: [{file: /etc/passwd}]", "configuration.yaml:1:18"),
            ("objects: [{file: a/../../b.obj}]", "beyond the job's folder"),
            ("data: ~/elsewhere", "beyond the job's folder"),
            ('objects: [{glob: ".?/.?/*.obj", unit: m}]', "looks for no files"),
            ('objects: [{glob: "*.obj"}]', "configuration.yaml:1:12"),
            ("a: &a [x]\nb: [*a", "configuration.yaml"),
            ("", "no configuration"),
        ]:
            with self.subTest(text):
                status, told = server.ask_json("/v1/jobs", text.encode(), method="POST")
                self.assertEqual(status, 400, told)
                self.assertIn(message, told["error"]["message"])
        for query, message in [("command=status", 'command is "status"'), ("ranks=3", "from 1 to 2"),
                               ("output=x", 'no option "output"'), ("dataset=other", 'no dataset "other"')]:
            status, told = server.ask_json("/v1/jobs?" + query, CONFIG.encode())
            self.assertEqual(status, 400, told)
            self.assertIn(message, told["error"]["message"])
        # What the command itself says.
        job = server.job(self.queue(server, CONFIG.replace("steel", "stele")))
        self.assertEqual((job["state"], job["exit_code"]), ("failed", 2))
        self.assertIn("unknown material \"stele\"", job["errors"])
        self.queue(server, SLOW)
        self.queue(server, SLOW)
        status, told = server.ask_json("/v1/jobs", SLOW.encode())
        self.assertEqual((status, told["error"]["message"]), (400, "2 jobs wait already"))
        self.assertEqual(server.stop()[0], 0)

    def answers(self, dataset="labelled"):
        """Right ones for every other test sample, in the words of `carillon score`."""
        with h5py.File(self.folder / dataset / "index.h5") as index:
            test = [i for i, part in enumerate(index["split_shape"].asstr()[()]) if part == "test"]
            keys, materials = index["key"].asstr()[()], index["material"].asstr()[()]
        lines = [f"{keys[i]},{materials[i] if n % 2 else 'glass'}" for n, i in enumerate(test)]
        return "sample,class\n" + "\n".join(lines) + "\n"

    def test_scores_do_not_wait_for_builds(self):
        server = self.serve()
        build = self.queue(server, SLOW)
        self.running(server, build)
        status, job = server.ask_json("/v1/score?dataset=labelled&task=material&entry=mine", self.answers().encode())
        self.assertEqual((status, job["command"]), (202, "score"), job)
        done = server.job(job["id"])
        self.assertEqual(done["state"], "done", done)
        self.assertEqual([row["entry"] for row in done["result"]["leaderboard"]["rows"]], ["mine"])
        self.assertTrue((self.folder / "labelled/evaluation/leaderboard-material.json").exists())
        self.assertEqual(server.job(build, ("running", "done"))["state"], "running")
        # What the command says of wrong answers.
        status, job = server.ask_json("/v1/score?dataset=labelled&task=material&entry=half", b"sample,class\nx,steel\n")
        self.assertEqual(status, 202)
        failed = server.job(job["id"])
        self.assertEqual((failed["state"], failed["exit_code"]), ("failed", 2))
        self.assertIn("x", failed["errors"])
        for query, message in [("entry=x", "no task"), ("task=material", "no entry"),
                               ("task=material&entry=x&sealed=a", 'no seal "a"'),
                               ("task=material&entry=x&format=xls", 'format is "xls"')]:
            status, told = server.ask_json("/v1/score?dataset=labelled&" + query, b"sample,class\n")
            self.assertEqual(status, 400)
            self.assertIn(message, told["error"]["message"])
        # A name is a name, whatever it looks like.
        status, job = server.ask_json("/v1/score?dataset=labelled&task=material&entry=--output%3D/tmp", self.answers().encode())
        rows = server.job(job["id"])["result"]["leaderboard"]["rows"]
        self.assertEqual({row["entry"] for row in rows}, {"mine", "--output=/tmp"})
        self.assertEqual({path.name for path in (self.folder / "labelled/evaluation").iterdir()},
                         {"scores", *(f"leaderboard-material.{end}" for end in ("csv", "json", "md"))})
        server.ask(f"/v1/jobs/{build}", method="DELETE")
        self.assertEqual(server.stop()[0], 0)

    def test_one_service_a_queue(self):
        server = self.serve()
        result = run("serve", "--jobs", self.id().split(".")[-1], "--port", "0", cwd=self.folder)
        self.assertEqual(result.returncode, 2)
        self.assertIn("another service runs its jobs", result.stderr)
        self.assertEqual(server.stop()[0], 0)
        # Without a queue there are none.
        server = Server("labelled", "--workers", "1", cwd=self.folder)
        self.addCleanup(server.process.kill)
        for path in ("/v1/jobs", "/v1/score?task=material&entry=x"):
            self.assertEqual(server.ask(path, b"x")[0], 501)
        self.assertEqual(server.stop()[0], 0)

    def test_a_folder_that_takes_no_more(self):
        server = self.serve()
        folder = self.folder / self.id().split(".")[-1]
        # Something is where the next job's folder would be, as when a disk takes no more; it stays.
        (folder / "000001").write_text("mine")
        status, told = server.ask_json("/v1/jobs", CONFIG.encode())
        self.assertEqual(status, 507, told)
        self.assertIn("no folder could be made", told["error"]["message"])
        self.assertEqual((folder / "000001").read_text(), "mine")
        self.assertEqual(server.job(self.queue(server, CONFIG))["state"], "done")
        self.assertEqual(server.stop()[0], 0)

    def test_a_disk_that_fills(self):
        def small_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (4000, resource.RLIM_INFINITY))

        server = self.serve(before=small_files)
        status, told = server.ask_json("/v1/jobs", (CONFIG + "#" * 4000).encode())
        self.assertEqual(status, 507, told)
        self.assertEqual(server.ask_json("/v1/jobs")[1], {"jobs": []})
        # A job whose own files find no room fails, and says why; what there is room for goes on.
        failed = server.job(self.queue(server, CONFIG, ranks=1))
        self.assertEqual(failed["state"], "failed", failed)
        self.assertIn("cannot be written", failed["errors"])
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        self.assertEqual(server.job(self.queue(server, CONFIG))["state"], "done")
        self.assertEqual(server.stop()[0], 0)

    def test_clocks_that_jump(self):
        server = self.serve(environment={"LD_PRELOAD": os.environ["CLOCK_JUMPS"]})
        first, second = self.queue(server, SLOW), self.queue(server, CONFIG)
        self.running(server, first)
        self.assertEqual(server.ask(f"/v1/jobs/{first}", method="DELETE")[0], 200)
        self.assertEqual(server.job(first)["state"], "cancelled")
        job = server.job(second)
        self.assertEqual((job["state"], job["exit_code"]), ("done", 0), job)
        # They did jump.
        self.assertGreater(len({one[key][:7] for one in (server.job(first), job) for key in ("created", "ended")}), 1)
        self.assertEqual(server.stop()[0], 0)

    def test_what_was_cancelled_stays_cancelled(self):
        server = self.serve()
        number = self.queue(server, SLOW)
        self.running(server, number)
        path = self.output(number).parent / "job.json"
        self.assertEqual(server.ask(f"/v1/jobs/{number}", method="DELETE")[0], 200)
        self.assertTrue(json.loads(path.read_text())["cancelled"])
        server.process.kill()
        server.process.wait()
        server = self.serve()
        self.assertEqual(server.job(number)["state"], "cancelled")
        self.assertEqual(server.stop()[0], 0)

    def test_a_queue_answers_while_slurm_takes_its_time(self):
        folder = self.folder / "slow-slurm"
        folder.mkdir()
        for name, text in {**SLURM, "sbatch": "sleep 20; exit 1\n"}.items():
            (folder / name).write_text("#!/bin/bash\n" + text)
            (folder / name).chmod(0o755)
        server = self.serve("--launch", "slurm", environment={"PATH": f"{folder}:{os.environ['PATH']}"})
        number = self.queue(server, CONFIG)
        time.sleep(1)
        begin = time.monotonic()
        self.assertEqual(server.ask_json(f"/v1/jobs/{number}")[1]["state"], "queued")
        self.assertEqual(server.ask(f"/v1/jobs/{number}", method="DELETE")[0], 200)
        self.assertLess(time.monotonic() - begin, 10)
        self.assertEqual(server.job(number)["state"], "cancelled")
        self.assertEqual(server.stop()[0], 0)

    def test_slurm_runs_them(self):
        bin_folder = self.folder / "slurm"
        bin_folder.mkdir()
        for name, text in SLURM.items():
            (bin_folder / name).write_text("#!/bin/bash\n" + text)
            (bin_folder / name).chmod(0o755 | stat.S_IXUSR)
        environment = {"PATH": f"{bin_folder}:{os.environ['PATH']}", "SLURM_PIDS": str(bin_folder)}
        server = self.serve("--launch", "slurm", environment=environment)
        number = self.queue(server, CONFIG)
        job = server.job(number)
        self.assertEqual((job["state"], job["exit_code"]), ("done", 0), job)
        self.assertEqual(job["result"]["failed_tasks"], 0)
        words = (self.output(number).parent / "sbatch.txt").read_text()
        self.assertIn("job.sbatch build configuration.yaml --output dataset", words)
        number = self.queue(server, SLOW.replace("count: 16", "count: 60"))
        self.running(server, number)
        self.assertEqual(server.ask(f"/v1/jobs/{number}", method="DELETE")[0], 200)
        job = server.job(number)
        self.assertEqual(job["state"], "cancelled", job)
        self.assertIn("77", (bin_folder / "cancelled").read_text())
        self.assertEqual(server.stop()[0], 0)


if __name__ == "__main__":
    unittest.main()
