"""Anisotropic materials in a build and on the command line: their axes lie where the object says."""
import json
import unittest

import h5py
import numpy
from program import FolderTest, run, run_json

WOODS = """
crystal: {C11: 168 GPa, C12: 121 GPa, C44: 75 GPa, density: 8960}
cedar:
  stiffness:
    - [9 GPa, 0.3 GPa, 0.3 GPa, 0, 0, 0]
    - [0.3 GPa, 0.9 GPa, 0.4 GPa, 0, 0, 0]
    - [0.3 GPa, 0.4 GPa, 0.7 GPa, 0, 0, 0]
    - [0, 0, 0, 0.08 GPa, 0, 0]
    - [0, 0, 0, 0, 0.6 GPa, 0]
    - [0, 0, 0, 0, 0, 0.7 GPa]
  density: 380
  alpha1: 60
  alpha2: 2.0e-6
"""
BAR = "shape: bar, parameters: {length: 30 cm, width: 3 cm, height: 1 cm}"
CONFIG = f"""
name: woods
materials_file: woods.yaml
modes: {{order: 3, max_modes: 6}}
objects:
  - {{{BAR}, name: along, materials: [spruce, cedar, steel]}}
  - {{{BAR}, name: across, materials: [spruce, steel], material_axes: {{first: [0, 1, 0], second: [1, 0, 0]}}}}
strikes: {{per_object: 1}}
audio: {{seconds: 0.1 s}}
"""


class Anisotropy(FolderTest):
    def test_axes_and_materials_of_a_build(self):
        self.write("woods.yaml", WOODS)
        config = self.write("config.yaml", CONFIG)
        output = self.folder / "built"
        self.assertEqual(run_json("build", config, "-o", output, ranks=None)["failed_tasks"], 0)
        def first(shape, number):
            with h5py.File(output / "modes" / f"{shape}-000.h5") as modes:
                return numpy.sqrt(modes[f"set-{number:03}/eigenvalues"][0]) / (2 * numpy.pi)

        # Sets of spruce first, steel last.
        self.assertAlmostEqual(first("along", 2) / first("across", 1), 1, 9)
        # A slender bar bends with the modulus along it: E_R is 0.078 of E_L.
        self.assertAlmostEqual(first("across", 0) / first("along", 0), numpy.sqrt(0.078), delta=0.02)
        with h5py.File(output / "index.h5") as index:
            keys = [key.decode() for key in index["key"][()]]
        described = {m["name"]: m for m in json.loads((output / "dataset.json").read_text())["materials"]}
        self.assertAlmostEqual(described["cedar"]["stiffness_pa"][0][0], 9e9, delta=1)
        self.assertNotIn("stiffness_pa", described["steel"])
        again = run("regenerate", output, "--sample", keys[0])
        self.assertEqual(again.returncode, 0, again.stderr)
        # Turned otherwise it is another dataset.
        told = run("build", config, "-o", output, "--set", "objects[1].material_axes.first=[0, 0, 1]")
        self.assertNotIn("nothing to do", told.stdout)

    def test_what_is_no_solid(self):
        for text, wanted in (
                ("bad: {E1: 9 GPa, E2: 1 GPa, density: 380}", "E3"),
                ("bad: {C11: 1 GPa, C12: 2 GPa, C44: 1 GPa, density: 380}", "positive definite"),
                ("bad: {stiffness: [[1, 2], [2, 1]], density: 380}", "6 lists of 6 values"),
                (WOODS.replace("[0.3 GPa, 0.9 GPa", "[0.2 GPa, 0.9 GPa"), "symmetric")):
            self.write("woods.yaml", text)
            config = self.write("config.yaml", CONFIG.replace("cedar, ", ""))
            result = run("plan", config)
            self.assertEqual(result.returncode, 2, text)
            self.assertIn(wanted, result.stderr)
            self.assertIn("woods.yaml:", result.stderr)


if __name__ == "__main__":
    unittest.main()
