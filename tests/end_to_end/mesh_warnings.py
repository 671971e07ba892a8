"""What is doubtful about files is said on the terminal, in warnings.json and by `check`."""
import json
import unittest

from program import FolderTest, run, run_json
from small_dataset import BOX, FACES


def write_boxes(path, *boxes):
    """An OBJ file of boxes between two corners each."""
    lines = []
    for low, high in boxes:
        lines += ["v %g %g %g" % tuple((low, high)[c][axis] for axis, c in enumerate(corner)) for corner in BOX]
    for number in range(len(boxes)):
        lines += ["f %d %d %d" % tuple(8 * number + i for i in face) for face in FACES]
    path.write_text("\n".join(lines) + "\n")


class MeshWarnings(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # A box in millimetres, and one whose cavity looks outward.
        outer = (0, 0, 0), (80, 40, 20)
        write_boxes(cls.folder / "plain.obj", outer)
        write_boxes(cls.folder / "hollow.obj", outer, ((4, 5, 5), (75, 35, 15)))
        # A sheet of 3 m, as far as the file says.
        write_boxes(cls.folder / "large.obj", ((0, 0, 0), (3, 1, 1)))
        cls.config = cls.write(cls, "warnings.yaml", """
name: warnings
materials: [steel]
modes: {order: 1, max_modes: 4}
objects:
  - {mesh: plain.obj, unit: mm}
  - {mesh: hollow.obj, unit: mm}
  - {mesh: large.obj}
strikes: {per_object: 1}
audio: {seconds: 0.1 s}
""")

    def test_a_build_says_what_is_doubtful(self):
        output = self.folder / "built"
        result = run("build", self.config, "-o", output)
        self.assertEqual(result.returncode, 0, result.stderr)
        warnings = json.loads((output / "warnings.json").read_text())
        self.assertEqual([w["task"] for w in warnings], ["modes/hollow", "modes/large"])
        self.assertIn("looks outward", warnings[0]["message"])
        self.assertIn("502.4 g", warnings[0]["message"])
        self.assertIn("335.2 g", warnings[0]["message"])
        self.assertIn("is the file in millimetres? Say unit: mm, or length: 3 mm", warnings[1]["message"])
        for warning in warnings:
            self.assertIn(warning["message"], result.stderr)
        self.assertIn(f"2 warnings: {output}/warnings.json", result.stdout)
        # A second run has nothing to do and still says it.
        again = run("build", self.config, "-o", output)
        self.assertIn("2 warnings", again.stdout)
        self.assertEqual(json.loads((output / "warnings.json").read_text()), warnings)
        checks = {c["name"]: c for c in run_json("check", output)["checks"]}
        self.assertEqual(checks["warnings"]["verdict"], "note")
        self.assertEqual(len(checks["warnings"]["items"]), 2)

    def test_a_command_says_it_in_options(self):
        for command in (["modes"], ["inspect"]):
            material = ["-m", "steel", "--max-modes", 2, "--order", 1] if command == ["modes"] else []
            result = run(*command, self.folder / "large.obj", *material)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("Say --unit mm, or --length 3mm", result.stderr + result.stdout)
        told = run_json("modes", self.folder / "plain.obj", "-m", "steel", "--unit", "mm", "--order", 1)
        self.assertAlmostEqual(told["mass_kg"], 0.08 * 0.04 * 0.02 * 7850, 9)
        self.assertEqual(told["warnings"], [])
        refused = run("modes", self.folder / "plain.obj", "-m", "steel")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("say --unit mm or --length 0.08m; --any-size lets it pass", refused.stderr)


if __name__ == "__main__":
    unittest.main()
