"""What `solver:` asks for is what the dataset says was done."""
import json
import unittest

import h5py
from program import FolderTest, run_json

# Between what the matrices of SMALL take and what their factor would take beside them.
LIMIT = "10 MiB"
SMALL = """
objects:
  - shape: tile
    parameters: {length: 100 mm, width: 80 mm, thickness: 6 mm}
    materials: [steel]
modes: {max_modes: 8, order: 2, element_size: 20 mm}
strikes: {per_object: 1}
audio: {seconds: 0.1 s}
"""


class Solver(FolderTest):
    def build(self, name, *settings):
        output = self.folder / name
        overrides = [word for setting in settings for word in ("--set", setting)]
        summary = run_json("build", self.write("small.yaml", SMALL), "-o", output, *overrides)
        with h5py.File(output / "modes" / "tile-000.h5") as file:
            certificate = dict(file["set-000/certificate"].attrs)
            errors = file["set-000/pitch_errors"][()]
            request = json.loads(file.attrs["request"])["options"]
        with h5py.File(output / "index.h5") as index:
            self.assertEqual(index["pitch_error"].attrs["unit"], "cent")
            self.assertEqual(index["pitch_error"][0], errors.max())
        return summary, certificate, request, output

    def test_certificates_name_the_solvers(self):
        for settings, eigen_solver, linear_solver in (
                ([], "block_lanczos", "direct"),
                (["solver.eigen_solver=krylov_schur", "solver.linear_solver=iterative"],
                 "krylov_schur", "iterative"),
                (["solver.memory_limit=" + LIMIT], "lobpcg", "iterative")):
            _, certificate, _, _ = self.build(f"{eigen_solver}-{len(str(settings))}", *settings)
            self.assertEqual(certificate["eigen_solver"], eigen_solver, settings)
            self.assertEqual(certificate["linear_solver"], linear_solver, settings)
            self.assertEqual(certificate["count_verified"], linear_solver == "direct", settings)

    def test_missed_pitch_targets_leave_a_trace(self):
        summary, _, _, output = self.build("missed", "solver.pitch_cents=0.01",
                                           "modes.max_elements=300")
        self.assertEqual(summary["missed_pitch_targets"], ["tile-000"])
        self.assertEqual(summary["failed_tasks"], 0)
        dataset = json.loads((output / "dataset.json").read_text())
        self.assertEqual(dataset["missed_pitch_targets"], ["tile-000"])
        target = dataset["shapes"][0]["pitch_target"]
        self.assertFalse(target["met"])
        self.assertGreater(target["reached_cents"], 0.01)
        with h5py.File(output / "index.h5") as index:
            self.assertAlmostEqual(index["pitch_error"][0], target["reached_cents"], 9)
        self.assertEqual(json.loads((output / "trace.json").read_text())["missed_pitch_targets"], 1)

    def test_descriptions_hold_the_setting_that_was_kept(self):
        summary, _, request, output = self.build("met", "solver.pitch_cents=1")
        self.assertEqual(summary["missed_pitch_targets"], [])
        shape = json.loads((output / "dataset.json").read_text())["shapes"][0]
        self.assertTrue(shape["pitch_target"]["met"])
        self.assertLessEqual(shape["pitch_target"]["reached_cents"], 1)
        self.assertEqual(shape["request"]["options"], request)
        with h5py.File(output / "modes" / "tile-000.h5") as file:
            report = json.loads(file.attrs["pitch_target"])
        self.assertGreater(len(report["steps"]), 1)
        chosen = report["steps"][report["chosen"]]
        self.assertEqual(request["order"], chosen["order"])
        self.assertEqual(request["element_size"], chosen["element_size_m"])

    def test_versions_name_every_library_of_the_solve(self):
        output = self.build("versions")[3]
        versions = json.loads((output / "dataset.json").read_text())["versions"]
        for library in ("petsc", "slepc", "metis", "cholmod", "mumps", "blas"):
            self.assertRegex(versions[library], r"\d", library)


if __name__ == "__main__":
    unittest.main()
