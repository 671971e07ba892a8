"""examples/cpp, built and run with what `cmake --install` installed."""
import os
import pathlib
import re
import subprocess
import unittest

import numpy
from program import CARILLON, FolderTest, run, run_json

BUILD = pathlib.Path(CARILLON).parent
SOURCE = pathlib.Path(__file__).resolve().parents[2]
# A program of an AddressSanitizer's build must be linked with it too.
SANITIZED = "CARILLON_SANITIZE:STRING=\n" not in (BUILD / "CMakeCache.txt").read_text()


@unittest.skipIf(SANITIZED, "a library with sanitizers is for its own programs")
class Library(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.prefix, cls.examples = cls.folder / "installed", cls.folder / "examples"
        cls.make("cmake", "--install", BUILD, "--prefix", cls.prefix)
        # A project of its own: no file of the source tree is within its reach.
        (cls.folder / "source").mkdir()
        for file in (SOURCE / "examples" / "cpp").iterdir():
            (cls.folder / "source" / file.name).write_text(file.read_text())
        compiler = re.search("^CMAKE_CXX_COMPILER:[A-Z]+=(.*)$", (BUILD / "CMakeCache.txt").read_text(), re.M)
        cls.make("cmake", "-G", "Ninja", "-S", cls.folder / "source", "-B", cls.examples,
                 f"-DCMAKE_PREFIX_PATH={cls.prefix}", f"-DCMAKE_CXX_COMPILER={compiler[1]}",
                 "-DCMAKE_BUILD_TYPE=Release")
        cls.make("cmake", "--build", cls.examples, "--parallel", "2")

    @staticmethod
    def make(*words):
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode != 0:
            raise AssertionError(f"{words}:\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}")

    def example(self, *words):
        # The mesher is found beside the installed carillon.
        path = f"{self.prefix / 'bin'}:{os.environ['PATH']}"
        done = subprocess.run([self.examples / words[0], *words[1:]], cwd=self.folder, text=True,
                              capture_output=True, env={**os.environ, "PATH": path})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_headers_include_only_what_is_installed(self):
        headers = list((self.prefix / "include" / "carillon").rglob("*.hpp"))
        self.assertGreater(len(headers), 200)
        for header in headers:
            for name in re.findall('#include "([^"]+)"', header.read_text()):
                self.assertTrue((self.prefix / "include" / name).is_file(), f"{header}: {name}")

    def test_modes_of_triangles_in_memory_are_those_of_the_same_triangles_in_a_file(self):
        (self.folder / "wedge.obj").write_text(
            "v 0 0 0\nv 0.1 0 0\nv 0 0.06 0\nv 0 0 0.04\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        known = run_json("modes", self.folder / "wedge.obj", "-m", "glass", "--max-modes", "5",
                         "--max-frequency", "100 kHz", "--cache", "")["modes"]
        rows = [(float(f), float(c)) for f, c in
                re.findall(r"([\d.]+) Hz, within ([\d.e+-]+) cents", self.example("modes"))]
        self.assertEqual(len(rows), 5)
        for (frequency, cents), mode in zip(rows, known):
            self.assertAlmostEqual(frequency, mode["frequency_hz"], delta=0.006)
            self.assertAlmostEqual(cents, mode["pitch_error_cents"], delta=0.06 * cents)

    def test_a_sound_from_stored_modes_rings_at_their_frequencies(self):
        modes = run_json("modes", "bowl", "-m", "ceramic", "--max-modes", "8", "-o",
                         self.folder / "bowl.h5", "--cache", "")["modes"]
        self.example("sound", "bowl.h5", "ceramic", "bowl.wav")
        features = run_json("features", self.folder / "bowl.wav")["features"]
        loudest = max(features, key=lambda feature: feature["amplitude"])
        nearest = min(modes, key=lambda mode: abs(mode["frequency_hz"] - loudest["frequency_hz"]))
        self.assertLess(abs(1200 * numpy.log2(loudest["frequency_hz"] / nearest["frequency_hz"])), 2)

    def test_a_dataset_is_read(self):
        self.write("two.yaml", "objects: [{shape: bar}]\nmaterials: [steel, glass]\n"
                               "modes: {max_modes: 10}\nstrikes: {per_object: 3}\n")
        done = run("build", self.folder / "two.yaml", "--output", self.folder / "two")
        self.assertEqual(done.returncode, 0, done.stderr)
        said = self.example("dataset", self.folder / "two")
        self.assertRegex(said, r"glass +3 samples, loudest [\d.e-]+\nsteel +3 samples, loudest")


if __name__ == "__main__":
    unittest.main()
