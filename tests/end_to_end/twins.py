"""Bodies that look alike and sound different, folders of classes, and datasets that share solves."""
import unittest

import h5py
import numpy
from program import CONFIGS, FolderTest, run, run_json

# The sizes of each pair of families, and the wall of the hollow one.
PAIRS = {
    ("block", "box"): "length: 12 cm, width: 8 cm, height: 6 cm",
    ("cylinder", "can"): "radius: 3 cm, length: 10 cm",
    ("pebble", "bauble"): "length: 9 cm, width: 7 cm, height: 5 cm",
}
COMMON = """
materials: [ceramic]
modes: {max_modes: 12}
solver: {pitch_cents: off}
audio: {seconds: 0.1 s}
strikes: {per_object: 1}
voxels: {resolution: 30, fill: outer}
"""


COARSE = COMMON.replace("max_modes: 12", "max_modes: 12, order: 2, element_size: 5 cm")


class Twins(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        text = COMMON + "objects:\n"
        for (solid, hollow), sides in PAIRS.items():
            text += f"  - {{shape: {solid}, length: 40 cm, parameters: {{{sides}}}}}\n"
            text += f"  - {{shape: {hollow}, length: 40 cm, parameters: {{{sides}, wall: 3 mm}}}}\n"
        config = cls.folder / "twins.yaml"
        config.write_text(text)
        run_json("build", config, "-o", cls.folder / "twins")

    def read(self, family):
        with h5py.File(self.folder / "twins" / "modes" / f"{family}-000.h5") as file:
            eigenvalues = file["set-000/eigenvalues"][()]
            return file["voxels"][0] > 0, numpy.sqrt(eigenvalues) / (2 * numpy.pi)

    def test_sight_cannot_tell_them_and_sound_can(self):
        for solid, hollow in PAIRS:
            (seen, low), (other, high) = self.read(solid), self.read(hollow)
            common = numpy.sum(seen & other) / numpy.sum(seen | other)
            self.assertGreater(common, 0.98, solid)
            cents = 1200 * numpy.log2(high[0] / low[0])
            self.assertGreater(abs(cents), 300, (solid, low[0], high[0]))


def write_box(path, x, y, z):
    """As ModelNet does: counts on the line of the keyword."""
    path.parent.mkdir(parents=True, exist_ok=True)
    corners = [(x * (i & 1), y * (i >> 1 & 1), z * (i >> 2)) for i in range(8)]
    faces = ["0 2 1", "1 2 3", "4 5 6", "5 7 6", "0 1 4", "1 5 4", "2 6 3", "3 6 7", "0 4 2",
             "2 4 6", "1 3 5", "3 7 5"]
    path.write_text("OFF8 12 0\n" + "".join(f"{a} {b} {c}\n" for a, b, c in corners)
                    + "".join(f"3 {face}\n" for face in faces))


class ModelNet(FolderTest):
    def test_the_folders_split_holds(self):
        folder = self.folder / "boxes"
        for i in range(4):
            write_box(folder / "bed" / "train" / f"bed_{i}.off", 2, 1, 0.5 + 0.1 * i)
            write_box(folder / "desk" / "train" / f"desk_{i}.off", 1, 1, 1.2 + 0.1 * i)
        for name in ("bed", "desk"):
            write_box(folder / name / "test" / f"{name}_8.off", 1, 1.5, 2)
        # The same object in train and test: ModelNet's own affair.
        write_box(folder / "bed" / "test" / "bed_9.off", 2, 1, 0.5)
        config = self.write("modelnet.yaml", COARSE + "split: {validation: 0.3}\nobjects:\n"
                            "  - {modelnet: boxes, length: 20 cm}\n")
        output = self.folder / "modelnet"
        run_json("build", config, "-o", output, ranks=2)
        with h5py.File(output / "index.h5") as index:
            shapes, families, parts = (index[name].asstr()[()]
                                       for name in ("shape", "family", "split_shape"))
        self.assertEqual(len(shapes), 11)
        for shape, family, part in zip(shapes, families, parts):
            self.assertEqual(shape.split("_")[0], family)
            self.assertEqual(part == "test", int(shape.split("_")[1]) > 7, shape)
        self.assertTrue(run_json("check", output)["passed"])
        same = run("regenerate", output, "--sample", "0", "-o", self.folder / "again.wav")
        self.assertEqual(same.returncode, 0, same.stderr)


    def test_the_papers_furniture_is_ten_classes_in_four_variants(self):
        config = self.folder / "modelnet10.yaml"
        config.write_text((CONFIGS / config.name).read_text())
        for size, name in enumerate(["bathtub", "bed", "chair", "desk", "dresser", "monitor", "night_stand", "sofa", "table", "toilet"]):
            for part, number in (("train", 1), ("train", 2), ("test", 107)):
                write_box(self.folder / "ModelNet10" / name / part / f"{name}_{number:04}.off",
                          1, 1 + 0.1 * size, 2 + 0.05 * number)
        plan = run("plan", config)
        self.assertEqual(plan.returncode, 0, plan.stderr)
        self.assertIn("a sweep of 4 variants (grid), 120 samples", plan.stdout)
        self.assertIn("120 objects have 30 different meshes and 30 different solves", plan.stdout)


class SharedSolves(FolderTest):
    def test_variants_share_every_solve(self):
        config = self.write("sizes.yaml", COARSE.replace("[ceramic]", "[ceramic, wood]") + """
objects:
  - {shape: box, count: 2, length: 15 cm, sizes: [1], drawn_size: {mean: 0.5, deviation: 0.1}}
sweep:
  keys:
    variants:
      named:
        o: {material_choice: first, size_choice: first}
        osm: {material_choice: last, size_choice: last}
""")
        output = self.folder / "sizes"
        run_json("build", config, "-o", output)
        rows = {}
        for name in ("o", "osm"):
            with h5py.File(output / f"variants={name}" / "index.h5") as index:
                rows[name] = list(zip(index["material"].asstr()[()], index["size"][()]))
        self.assertEqual(rows["o"], [("ceramic", 1.0)] * 2)
        self.assertEqual([material for material, _ in rows["osm"]], ["wood"] * 2)
        self.assertEqual(len({size for _, size in rows["osm"]}), 2)
        for _, size in rows["osm"]:
            self.assertTrue(0.2 <= size <= 0.8 and size != 1)


if __name__ == "__main__":
    unittest.main()
