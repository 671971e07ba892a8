"""What `solver:` asks for is what the dataset says was done."""
import json
import unittest

import h5py
from program import FolderTest, run, run_json

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

    def test_mirror_planes_are_used_unless_they_are_off(self):
        frequencies = {}
        for choice, planes in (("automatic", 2), ("off", 0)):
            _, certificate, _, output = self.build(choice, "modes.element_size=12 mm", "modes.order=3",
                                                   f"solver.mirror_planes={choice}")
            self.assertEqual(certificate["mirror_planes"], planes)
            self.assertEqual(certificate["count_verified"], 1)
            with h5py.File(output / "modes" / "tile-000.h5") as file:
                frequencies[choice] = file["set-000/eigenvalues"][()]
        for one, other in zip(frequencies["automatic"], frequencies["off"], strict=True):
            self.assertAlmostEqual(one / other, 1, 8)
        tile = ("tile:length=100mm,width=80mm,thickness=6mm", "-m", "steel", "--element-size", "12 mm")
        found = run_json("modes", *tile)["certificate"]
        self.assertEqual(found["mirror_planes"], 2)
        whole = run_json("modes", *tile, "--mirror-planes", "off")["certificate"]
        self.assertEqual(whole["mirror_planes"], 0)
        # Every unknown is in one class.
        self.assertEqual(found["unknowns"], whole["unknowns"])
        self.assertIn("in 4 classes of 2 mirror planes", run("modes", *tile).stdout)
        refused = run("modes", "bowl", "-m", "steel", "--solver", "axisymmetric", "--mirror-planes", "off")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--mirror-planes does not apply", refused.stderr)

    def test_options_of_petsc_are_heeded(self):
        tile = ("modes", "tile:length=100mm,width=80mm,thickness=6mm", "-m", "steel", "--element-size",
                "20 mm", "--mirror-planes", "off")

        def found(options):
            return run_json(*tile, environment={"PETSC_OPTIONS": options})

        log = self.folder / "log.txt"
        # One after the other: modes of other options are not those of the cache, what only prints
        # changes nothing.
        own = found("")
        logged = found(f"-log_view :{log}")
        stock = found("-eps_type krylovschur")
        other = found("-eps_type subspace")
        assembled = found("-st_pc_factor_mat_solver_type mumps")
        self.assertEqual(own["certificate"]["eigen_solver"], "block_lanczos")
        self.assertEqual(stock["certificate"]["eigen_solver"], "krylov_schur")
        self.assertEqual(other["certificate"]["eigen_solver"], "slepc")
        for one in (logged, stock, other, assembled):
            self.assertTrue(one["certificate"]["count_verified"])
            for a, b in zip(own["modes"], one["modes"], strict=True):
                self.assertAlmostEqual(a["frequency_hz"] / b["frequency_hz"], 1, 8)
        self.assertNotIn("EPSSolve", log.read_text())  # from the cache
        turned = run_json("modes", "vase", "-m", "steel",
                          environment={"PETSC_OPTIONS": "-eps_type krylovschur"})
        self.assertEqual(turned["solver"]["name"], "axisymmetric")
        self.assertEqual(turned["certificate"]["eigen_solver"], "krylov_schur")
        found(f"-log_view :{log} -eps_tol 1e-11")
        counts = {line.split()[0]: int(line.split()[1]) for line in log.read_text().splitlines()
                  if line.startswith(("EPSSolve", "MatCholFctrNum", "KSPMatSolve"))}
        self.assertEqual(counts["EPSSolve"], 1)
        self.assertEqual(counts["MatCholFctrNum"], 1)
        self.assertGreater(counts["KSPMatSolve"], 2)
        refused = run(*tile, environment={"PETSC_OPTIONS": "-eps_type nonsense"})
        self.assertEqual(refused.returncode, 2)
        self.assertIn("nonsense", refused.stderr)

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


DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="60mm" viewBox="0 0 40 60">
<rect x="10" y="5" width="2" height="50"/></svg>"""


class Drawings(FolderTest):
    """A wall of 2 by 50 mm, drawn away from the edge."""

    def test_an_outline_beside_the_axis_asks_for_it(self):
        drawing = self.write("wall.svg", DRAWING)
        asked = run("modes", drawing, "-m", "steel")
        self.assertEqual(asked.returncode, 2, asked.stderr)
        self.assertIn("from x = 10 to 12, and its axis is not given", asked.stderr)
        self.assertIn("--profile-axis", asked.stderr)
        config = self.write("wall.yaml", "objects: [{shape: turned, svg: wall.svg, materials: [steel]}]\n"
                                         "strikes: {per_object: 1}\n")
        planned = run("plan", config)
        self.assertNotEqual(planned.returncode, 0)
        self.assertIn("profile_axis", planned.stderr)
        self.assertNotIn("--profile-axis", planned.stderr)

    def test_its_axis_makes_it_a_rod_or_a_tube(self):
        drawing = self.write("wall.svg", DRAWING)
        mass = {}
        for axis in ("left", "x=0"):
            found = run_json("modes", drawing, "-m", "steel", "--profile-axis", axis, "--max-frequency", "9 kHz")
            self.assertEqual(found["solver"]["name"], "axisymmetric")
            mass[axis] = found["mass_kg"]
        self.assertAlmostEqual(mass["x=0"] / mass["left"], (12**2 - 10**2) / 2**2, 6)


if __name__ == "__main__":
    unittest.main()
