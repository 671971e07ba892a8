"""examples/python, run with what `cmake --install` installed, beside the program on the same things; and a wheel."""
import os
import pathlib
import re
import subprocess
import sys
import unittest

from installed_module import BUILD, InstalledTest
from program import run, run_json

SOURCE = pathlib.Path(__file__).resolve().parents[2]


class Installed(InstalledTest):
    def example(self, name, *words):
        return self.python(SOURCE / "examples" / "python" / f"{name}.py", *words)

    def test_modes(self):
        self.write("wedge.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.06 0\nv 0 0 0.04\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        known = run_json("modes", self.folder / "wedge.obj", "-m", "glass", "--max-modes", "5", "--max-frequency",
                         "100 kHz", "--pitch-cents", "off", "--cache", "")["modes"]
        self.assertEqual(re.findall(r"([\d.]+) Hz", self.example("modes")),
                         [f"{mode['frequency_hz']:.2f}" for mode in known])

    def test_a_sound(self):
        modes = run_json("modes", "bowl", "-m", "ceramic", "--max-modes", "8", "-o", self.folder / "bowl.h5",
                         "--cache", "")["modes"]
        self.assertEqual(self.example("sound", "bowl.h5", "ceramic", "bowl.wav"),
                         f"bowl.wav: {len(modes)} of {len(modes)} modes sound\n")
        self.assertEqual(run_json("features", self.folder / "bowl.wav")["sample_rate_hz"], 44100)

    def test_a_dataset(self):
        self.write("two.yaml", "objects: [{shape: bar}]\nmaterials: [steel, glass]\n"
                               "modes: {max_modes: 10}\nstrikes: {per_object: 3}\n")
        done = run("build", self.folder / "two.yaml", "--output", self.folder / "two")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(self.example("dataset", "two"), r"glass +3 samples, loudest [\d.e-]+\nsteel +3 samples, loudest")

    def test_a_build_finds_the_program(self):
        said = self.python("-c", "import carillon as ca\n"
                                 "ds = ca.build({'objects': [{'shape': 'bar'}], 'materials': ['steel'], "
                                 "'modes': {'max_modes': 3}, 'strikes': {'per_object': 2}}, output='built')\n"
                                 "print(ds.samples, ca._carillon.program())")
        self.assertEqual(said, f"2 {self.prefix / 'bin' / 'carillon'}\n")

    def test_pip_installs_it(self):
        if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode != 0:
            self.skipTest("needs python3-pip")
        if subprocess.run([sys.executable, "-c", "import setuptools, wheel"], capture_output=True).returncode != 0:
            self.skipTest("needs python3-setuptools and python3-wheel")
        wheels = self.folder / "wheels"
        done = subprocess.run([sys.executable, "-m", "pip", "install", "--no-build-isolation", "--no-deps", "--no-index",
                               "--target", wheels, SOURCE], capture_output=True, text=True,
                              env={**os.environ, "CARILLON_BUILD": str(BUILD)})
        self.assertEqual(done.returncode, 0, done.stderr)
        said = self.python("-c", "import carillon as ca\n"
                                 "print(ca._carillon.program(), len(ca.shape('bar').modes('steel', max_modes=3)))",
                           modules=wheels)
        self.assertEqual(said, f"{wheels / 'carillon' / 'bin' / 'carillon'} 3\n")


if __name__ == "__main__":
    unittest.main()
