"""What docs/service.md shows of a service, and examples/service, as a reader would run them."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import h5py
from program import CONFIGS, DOCS, FolderTest, run
from score import CONFIG
from server import Server

ENTER = pathlib.Path(__file__).resolve().parents[2] / "examples/service/enter.py"


def transcripts():
    """Commands and what they print, by the blocks that have them."""
    for block in re.findall(r"^```\n(\$ .*?)^```", (DOCS / "service.md").read_text(), re.M | re.S):
        for part in re.split(r"^\$ ", block, flags=re.M)[1:]:
            command, _, output = part.partition("\n")
            yield command, output


class Documented(FolderTest):
    def test_transcripts(self):
        shutil.copy(CONFIGS / "smoke.yaml", self.folder)
        self.assertEqual(run("build", "smoke.yaml", "-o", "carillon-smoke", ranks=2, cwd=self.folder).returncode, 0)
        with h5py.File(self.folder / "carillon-smoke/index.h5") as index:
            rows = zip(*(index[name].asstr()[:] for name in ("key", "material", "split_shape")))
            lines = ["sample,class", *(f"{key},{material}" for key, material, part in rows if part == "test")]
        (self.folder / "answers.csv").write_text("\n".join(lines) + "\n")
        server = Server("carillon-smoke", "--jobs", "documented", "--ranks", "2", cwd=self.folder)
        self.addCleanup(server.process.kill)
        shown = list(transcripts())
        self.assertGreater(len(shown), 8)
        for command, output in shown:
            with self.subTest(command):
                done = subprocess.run(command.replace("http://127.0.0.1:8750", server.url), shell=True, cwd=self.folder,
                                      capture_output=True, text=True, timeout=200, check=True)
                pattern = re.escape(output).replace(r"\.\.\.", ".*")
                self.assertRegex(done.stdout, re.compile(r"\A" + pattern + r"\Z", re.S))
        self.assertEqual(server.job(2)["result"]["leaderboard"]["rows"][0]["entry"], "mine")
        self.assertIn(server.job(1)["state"], ("cancelled", "done"))  # it may have been too late
        self.assertEqual(server.stop()[0], 0)

    def test_a_network_of_ones_own(self):
        try:
            import soundfile  # noqa: F401
            import torch  # noqa: F401
        except ImportError as missing:
            self.skipTest(f"needs python3-torch and python3-soundfile: {missing}")
        (self.folder / "small.yaml").write_text(CONFIG.replace("seconds: 0.1 s", "seconds: 0.5 s"))
        self.assertEqual(run("build", "small.yaml", cwd=self.folder).returncode, 0)
        self.assertEqual(run("export", "small", "--format", "wav", "--hide", "test", cwd=self.folder).returncode, 0)
        server = Server("small", "--jobs", "queue", "--sealed", "small-wav-sealed.json", "--workers", "1", cwd=self.folder)
        self.addCleanup(server.process.kill)

        def enter(*words):
            return subprocess.run([sys.executable, ENTER, "small-wav", "--service", server.url, "--dataset", "small", *words],
                                  cwd=self.folder, capture_output=True, text=True, timeout=400)

        # What would tell the labels is not served by whoever knows them.
        for path in ("/", "/v1/strike?object=bar-000", "/v1/newest?folder=small"):
            self.assertEqual(server.ask(path)[0], 403, path)
        untrained = enter("--sealed", "small-wav-sealed.json", "--entry", "untrained", "--epochs", "0")
        self.assertEqual(untrained.returncode, 0, untrained.stderr)
        trained = enter("--sealed", "small-wav-sealed.json")
        self.assertEqual(trained.returncode, 0, trained.stderr)
        self.assertRegex(trained.stdout, r"\A 1\. small network +[\d.]+ % accuracy   <- this one\n 2\. untrained ")
        board = json.loads((self.folder / "small/evaluation/leaderboard-material.json").read_text())
        found = re.match(r" 1\. small network +([\d.]+)", trained.stdout)[1]
        self.assertAlmostEqual(100 * board["rows"][0]["measures"][0]["mean"], float(found), delta=0.06)
        # Materials differ in damping and pitch: three classes, and far from a third.
        self.assertGreater(float(found), 50)
        # Without the seal nobody knows the samples.
        self.assertNotEqual(enter().returncode, 0)
        self.assertEqual(server.stop()[0], 0)


if __name__ == "__main__":
    unittest.main()
