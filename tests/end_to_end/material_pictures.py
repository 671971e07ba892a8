"""Frames that say the material: what they show of own materials, and that a network learns it from them."""
import pathlib
import shutil
import unittest

import h5py
import numpy
from msh_files import msh_4, two_part_bar
from program import FolderTest, pictures, run, run_json

OBJECTS = """
  - {shape: block, count: 8}
  - {shape: tile, count: 8}
  - {shape: disc, count: 8}
"""
CONFIG = f"""
name: pictures
seed: 5
materials: [wood, copper, plastic, granite]
objects: {OBJECTS}
modes: {{max_modes: 3, order: 2, element_size: 40 mm}}
strikes: {{per_object: 2}}
audio: {{seconds: 0.05 s, sample_rate: 22050 Hz}}
camera: {{width: 64, height: 64, views: 2}}
split: {{validation: 0.2, test: 0.3}}
train:
  seed: 1
  epochs: 60
  patience: 20
  batch: 8
  tasks:
    material: {{column: material}}
  methods:
    image: {{units: 32, learning_rate: 0.001}}
"""
OWN = """
red_paint: {youngs_modulus: 3 GPa, poisson_ratio: 0.35, density: 1200,
            appearance: {base_colour: [0.7, 0.01, 0.01], roughness: 0.9}}
rusty_steel: {youngs_modulus: 200 GPa, poisson_ratio: 0.29, density: 7850,
              appearance: {base_colour: [0.01, 0.01, 0.7], roughness: 0.9, metallic: 0}}
"""


@pictures
class MaterialPictures(FolderTest):
    def test_a_network_learns_the_material_of_objects_that_it_has_not_seen(self):
        found = run_json("train", self.write("pictures.yaml", CONFIG), "-o", self.folder / "set")
        line, = found["trainings"]
        self.assertGreater(line["samples"]["test"], 20)
        self.assertGreaterEqual(line["test_accuracy"], 0.9)

    def small(self, name, more, ranks=1):
        text = ("objects: [{shape: block}]\nmaterials: [red_paint, rusty_steel]\nmaterials_file: materials.yaml\n"
                "modes: {max_modes: 3, order: 2, element_size: 40 mm}\nstrikes: {per_object: 1}\n"
                f"audio: {{seconds: 0.05 s}}\nname: {name}\n{more}\n")
        self.write("materials.yaml", OWN)
        output = self.folder / name
        run_json("build", self.write(f"{name}.yaml", text), "-o", output, ranks=ranks)
        return output

    def halves(self, name, more, ranks=1):
        self.write("materials.yaml", OWN)
        self.write("bar.msh", msh_4(*two_part_bar()))
        text = ("objects: [{mesh: bar.msh, name: bar, materials: {left: red_paint, right: rusty_steel}}]\n"
                f"materials_file: materials.yaml\naudio: {{seconds: 0.1 s}}\nname: {name}\n{more}\n")
        output = self.folder / name
        run_json("build", self.write(f"{name}.yaml", text), "-o", output, ranks=ranks)
        return output

    def expect_halves(self, picture):
        red, blue = (picture[..., k].astype(int) > picture[..., 2 - k].astype(int) + 40 for k in (0, 2))
        self.assertGreater(red.sum(), 60)
        self.assertGreater(blue.sum(), 60)
        # Left is along x, which points to the right from -y.
        self.assertLess(numpy.nonzero(red)[1].max(), numpy.nonzero(blue)[1].min() + 3)

    def test_each_region_shows_its_material(self):
        # Quadratic elements; and what a pitch target chooses, of which the bar's mirror planes are used.
        for name, modes in (("quadratic", "{max_modes: 3, order: 2}"), ("target", "{max_modes: 3}")):
            output = self.halves(name, f"modes: {modes}\nstrikes: {{per_object: 1}}\n"
                                 "camera: {width: 96, height: 48, azimuth: -90 deg, elevation: 20 deg}")
            with self.subTest(name):
                view, = self.frames(output).popitem()[1]
                self.expect_halves(view)

    def test_each_region_shows_its_material_where_it_moves(self):
        output = self.halves("falling", "modes: {max_modes: 3, order: 1}\nmotion:\n"
                             "  bodies: [{object: bar, at: [-0.1, 0, 0.1]}]\n"
                             "  camera: {width: 96, height: 48, rate: 20 Hz, eye: [0, -0.35, 0.17],"
                             " target: [0, 0, 0.1]}")
        with h5py.File(output / "index.h5") as index:
            self.expect_halves(index["frames"][0, 0])

    def frames(self, output):
        with h5py.File(output / "index.h5") as index:
            of = dict(zip(index["appearances/material"].asstr()[:], index["appearances/frame"][:]))
        return {material: views.astype(int) for material, views in of.items()}

    def test_own_materials_show_what_they_state_from_every_side(self):
        own = self.frames(self.small("own", "camera: {width: 48, height: 48, views: [{}, {azimuth: 200 deg}, "
                                            "{elevation: 80 deg}]}"))
        self.assertEqual({views.shape for views in own.values()}, {(3, 48, 48, 3)})
        for material, channel, other in (("red_paint", 0, 2), ("rusty_steel", 2, 0)):
            for view in own[material]:
                coloured = view[..., channel] > view[..., other] + 40
                self.assertGreater(coloured.sum(), 150, material)
                self.assertEqual((view[..., other] > view[..., channel] + 40).sum(), 0)
        # The same outline in both materials, another one from each side.
        outlines = [[(view != view[:, :1]).any(-1) for view in own[m]] for m in ("red_paint", "rusty_steel")]
        numpy.testing.assert_array_equal(*outlines)
        self.assertTrue((outlines[0][0] != outlines[0][2]).any())
        # The first view is the one that there is without `views`.
        one = self.frames(self.small("one", "camera: {width: 48, height: 48}"))
        for material, views in one.items():
            numpy.testing.assert_array_equal(views[0], own[material][0])

    def test_checks_exports_and_old_datasets(self):
        output = self.small("kept", "camera: {width: 32, height: 32, views: 2}", ranks=2)
        self.assertEqual(run("check", output).returncode, 0)
        tars = self.folder / "tars"
        run("export", output, "--format", "webdataset", "--with", "frame", "-o", tars)
        self.assertTrue(list(tars.glob("*.tar")))
        old = pathlib.Path(shutil.copytree(output, self.folder / "old"))
        with h5py.File(old / "index.h5", "a") as index:
            index["shapes/frame"] = index["appearances/frame"][:1, 0]
            del index["appearances"], index["appearance_index"]
        config = self.write("old.yaml", f"data: {old}\ntrain: {{tasks: {{m: {{column: material, split_column: "
                                        "split_strike}}, methods: {image: {}}}\n")
        result = run("train", config, "-o", self.folder / "old-trained")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("older version", result.stderr)
        checked = run("check", old)
        self.assertNotEqual(checked.returncode, 0)
        self.assertIn("appearances", checked.stdout)


if __name__ == "__main__":
    unittest.main()
