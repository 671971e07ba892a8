"""Meshes as modellers and CAD programs write them: nodes, units, which way is up, colours, many files in
one entry, and files that are not read."""
import json
import os
import unittest

import h5py
import mesh_files
import numpy
from program import FolderTest, pictures, run, run_json

SIDES = numpy.array([0.12, 0.05, 0.02])
SOLVE = ("--material", "steel", "--order", "2")


def named(name, vertices, triangles, **transform):
    return {"name": name, "vertices": vertices, "triangles": triangles, **transform}


class Formats(FolderTest):
    """One block in each format rings as the same block in an OBJ file."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        vertices, triangles = mesh_files.block(SIDES)
        with open(cls.folder / "block.obj", "w") as file:
            for v in vertices:
                file.write("v %.9g %.9g %.9g\n" % tuple(v))
            for t in triangles:
                file.write("f %d %d %d\n" % tuple(t + 1))
        cls.vertices, cls.triangles = vertices, triangles
        cls.frequencies = cls.first_modes(cls.folder / "block.obj")

    @classmethod
    def first_modes(cls, path, *options):
        found = run_json("modes", path, *SOLVE, *options)
        return [mode["frequency_hz"] for mode in found["modes"][:6]]

    def check(self, path, *options):
        extent = run_json("inspect", path, *options)[0]["extent"]
        numpy.testing.assert_allclose(extent, SIDES, rtol=1e-5)
        # Vertices in single precision move a mode by less than that.
        numpy.testing.assert_allclose(self.first_modes(path, *options), self.frequencies, rtol=2e-3)

    def test_glb(self):
        mesh_files.write_glb(self.folder / "a.glb", [named("Body", self.vertices, self.triangles)])
        self.check(self.folder / "a.glb")

    def test_gltf_with_its_buffer_inside_or_beside(self):
        mesh_files.write_gltf(self.folder / "inside.gltf", [named("B", self.vertices, self.triangles)],
                              embedded=True)
        mesh_files.write_gltf(self.folder / "beside.gltf", [named("B", self.vertices, self.triangles)])
        self.check(self.folder / "inside.gltf")
        self.check(self.folder / "beside.gltf")

    def test_other_bytes_beside_a_gltf_are_another_mesh(self):
        for factor in (1, 0.5):
            mesh_files.write_gltf(self.folder / "changed.gltf",
                                  [named("B", self.vertices * factor, self.triangles)])
            text = json.loads((self.folder / "changed.gltf").read_text())
            for entry in text["accessors"]:
                entry.pop("min", None), entry.pop("max", None)
            (self.folder / "changed.gltf").write_text(json.dumps(text))
            low = self.first_modes(self.folder / "changed.gltf")[0]
            self.assertAlmostEqual(low * factor / self.frequencies[0], 1, delta=2e-3)

    def test_transforms_of_nodes(self):
        # Scaled by its node, mirrored (faces turn over), turned a quarter about the vertical axis, moved.
        half = 0.5 ** 0.5
        mesh_files.write_glb(self.folder / "moved.glb", [named(
            "Body", self.vertices[:, [1, 0, 2]] / [2, 2, 2], self.triangles, scale=[-2, 2, 2],
            rotation=[0, half, 0, half], translation=[3, 1, -7])])
        self.check(self.folder / "moved.glb")

    def test_collada_in_centimetres(self):
        for up, points in (("Z_UP", self.vertices), ("Y_UP", mesh_files.y_up(self.vertices))):
            mesh_files.write_dae(self.folder / "a.dae", points * 100, self.triangles, metre=0.01, up=up,
                                 translation=(10, 0, 5))
            self.check(self.folder / "a.dae")

    def test_x3d_in_millimetres(self):
        mesh_files.write_x3d(self.folder / "a.x3d", self.vertices * 1000, self.triangles, metre=0.001)
        self.check(self.folder / "a.x3d")

    def test_3mf_in_inches_and_in_its_own_millimetres(self):
        mesh_files.write_3mf(self.folder / "a.3mf", self.vertices / 0.0254, self.triangles, unit="inch")
        self.check(self.folder / "a.3mf")
        mesh_files.write_3mf(self.folder / "b.3mf", self.vertices * 1000, self.triangles, unit=None)
        self.check(self.folder / "b.3mf")

    def test_fbx_in_inches_with_y_or_z_up(self):
        for up, points in ((1, mesh_files.y_up(self.vertices)), (2, self.vertices)):
            mesh_files.write_fbx(self.folder / "a.fbx", points / 0.0254, self.triangles,
                                 centimetres=2.54, up=up)
            self.check(self.folder / "a.fbx")

    def test_a_unit_that_is_given_counts_more_than_the_file_s(self):
        mesh_files.write_dae(self.folder / "wrong.dae", self.vertices * 1000, self.triangles, metre=1)
        self.check(self.folder / "wrong.dae", "--unit", "mm")
        answer = run("modes", self.folder / "wrong.dae", *SOLVE)
        self.assertEqual(answer.returncode, 2)
        self.assertIn("--unit mm", answer.stderr)

    def test_nodes_are_told_and_one_can_be_named(self):
        path = self.folder / "two.glb"
        cone = mesh_files.lens(0.03, 0.05)
        mesh_files.write_glb(path, [named("Body", self.vertices, self.triangles),
                                    named("Lens", *cone, translation=[1, 0, 0])])
        nodes = run_json("inspect", path)[0]["nodes"]
        self.assertEqual([node["name"] for node in nodes], ["Body", "Lens"])
        numpy.testing.assert_allclose(nodes[0]["extent_m"], SIDES, rtol=1e-5)
        self.check(path, "--node", "Body")
        answer = run("modes", path, *SOLVE, "--node", "Bod")
        self.assertEqual(answer.returncode, 2)
        self.assertIn('did you mean "Body"?', answer.stderr)
        # Without the name all are one body, and that is said.
        answer = run("modes", path, *SOLVE, "--max-frequency", "3 kHz")
        self.assertIn("2 nodes of the file are one body: Body, Lens", answer.stderr)

    def test_msh_of_version_1(self):
        nodes = [(0.1 * x, 0.1 * y, 0.1 * z) for x, y, z in
                 ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))]
        text = "$NOD\n4\n" + "".join("%d %g %g %g\n" % (i + 1, *p) for i, p in enumerate(nodes))
        (self.folder / "old.msh").write_text(text + "$ENDNOD\n$ELM\n1\n1 4 1 1 4 1 2 3 4\n$ENDELM\n")
        modes = run_json("modes", self.folder / "old.msh", "--material", "steel", "--max-frequency", "80 kHz")
        self.assertGreater(len(modes["modes"]), 3)


class Refused(FolderTest):
    def test_kinds_that_are_not_read_are_answered_with_a_way(self):
        for name, words in (("a.blend", "glTF 2.0 (.glb)"), ("a.usdz", "Blender"), ("a.sldprt", "STEP"),
                            ("a.vtu", "meshio convert"), ("a.pcd", "points are no surface"),
                            ("a.skp", "export as glTF"), ("a.zip", "unpack")):
            (self.folder / name).write_bytes(b"something")
            answer = run("modes", self.folder / name, "--material", "steel")
            self.assertEqual(answer.returncode, 2, name)
            self.assertIn(words, answer.stderr)
            self.assertLess(len(answer.stderr.splitlines()), 5, answer.stderr)

    def test_damaged_files_are_input_errors(self):
        vertices, triangles = mesh_files.block(SIDES)
        mesh_files.write_glb(self.folder / "whole.glb", [named("Body", vertices, triangles)])
        mesh_files.write_3mf(self.folder / "whole.3mf", vertices, triangles)
        mesh_files.write_dae(self.folder / "whole.dae", vertices, triangles)
        for name in ("whole.glb", "whole.3mf", "whole.dae"):
            whole = (self.folder / name).read_bytes()
            for size in (0, 5, 30, len(whole) // 2, len(whole) - 40):
                path = self.folder / ("cut" + os.path.splitext(name)[1])
                path.write_bytes(whole[:size])
                answer = run("inspect", path)
                self.assertEqual(answer.returncode, 2, (name, size, answer.stderr))
                self.assertIn(str(path), answer.stderr)
        for name in ("a.step", "a.iges", "a.brep", "a.x3d", "a.fbx", "a.gltf"):
            (self.folder / name).write_text("no mesh at all")
            answer = run("inspect", self.folder / name)
            self.assertEqual(answer.returncode, 2, (name, answer.stderr))


BUILD = """
name: many
seed: 3
objects:
{objects}
modes: {{max_modes: 6, max_frequency: 9 kHz, order: 2, max_elements: 4000}}
audio: {{seconds: 0.1 s, sample_rate: 22050 Hz, gain: 0.05}}
strikes: {{per_object: 2}}
{more}
"""


class Datasets(FolderTest):
    def build(self, name, objects, more="", code=0):
        config = self.write(f"{name}.yaml", BUILD.format(objects=objects, more=more))
        answer = run("build", config, "-o", self.folder / name)
        self.assertEqual(answer.returncode, code, answer.stderr)
        return self.folder / name, answer

    def meshes(self, folder, count):
        """So many files, each another body, some in folders, with transforms, units and several nodes."""
        random = numpy.random.default_rng(1)
        for i in range(count):
            place = folder / ("a", "b/c", ".")[i % 3]
            place.mkdir(parents=True, exist_ok=True)
            sides = random.uniform(0.02, 0.1, 3)
            shape = mesh_files.block(sides) if i % 2 else mesh_files.lens(sides[0], sides[1])
            nodes = [named("Body", *shape)]
            if i % 4 == 1:
                # In centimetres, which its node makes metres.
                nodes = [named("Body", shape[0] * 100, shape[1], scale=[0.01, 0.01, 0.01],
                               translation=[1, 2, 3])]
            if i % 5 == 0:
                nodes.append(named("Lid", *mesh_files.block(sides / 2), translation=[0.3, 0, 0]))
            mesh_files.write_glb(place / f"body{i % 7}-{i}.glb", nodes)

    def test_twenty_files_are_a_dataset_by_one_command(self):
        self.meshes(self.folder / "meshes", 20)
        output, _ = self.build(
            "each", '  - {glob: "meshes/**/*.glb", nodes: each, materials: [steel]}')
        with h5py.File(output / "index.h5") as index:
            shapes = set(index["shape"].asstr()[:])
            self.assertEqual(index["audio"].shape[0], 2 * 24)  # four files have two nodes
        self.assertEqual(len(shapes), 24)
        self.assertIn("b-c-body1-1-Body", shapes)
        self.assertIn("body2-2-Body", shapes)
        self.assertIn("a-body0-0-Lid", shapes)
        self.assertEqual(run("check", output).returncode, 0)
        # What is stored is made again.
        sample = run_json("regenerate", output, "--sample", "a-body0-0-Lid/steel/1/strike-0001")
        self.assertTrue(sample["samples"][0]["identical"], sample)

    def test_a_table_of_files(self):
        self.meshes(self.folder / "table", 6)
        (self.folder / "table" / "objects.csv").write_text(
            "file,length,material,family,split,maker,price\n"
            "a/body0-0.glb,6 cm,glass,bowl,train,Anna,3.5\n"
            "b/c/body1-1.glb,,,plate,test,,\n"
            "body2-2.glb,70 mm,steel,plate,train,Otto,1\n"
            "missing.glb,,,plate,test,Otto,2\n"
            "a/body3-3.glb,,,,,,\n")
        output, answer = self.build("listed", "  - {manifest: table/objects.csv, materials: [steel]}",
                                    code=3)
        self.assertIn("objects.csv:5: ", answer.stderr)
        failures = json.loads((output / "failures.json").read_text())
        failed = failures["tasks"] if isinstance(failures, dict) else failures
        self.assertEqual(len({f["task"] for f in failed}), 1, failed)
        self.assertIn("objects.csv:5", failed[0]["message"])
        with h5py.File(output / "index.h5") as index:
            rows = {}
            for i, shape in enumerate(index["shape"].asstr()[:]):
                rows[shape] = {name: index[name].asstr()[i] for name in
                               ("material", "family", "split_shape", "label_maker", "label_price")}
        self.assertEqual(rows["body0-0"], {"material": "glass", "family": "bowl", "split_shape": "train",
                                           "label_maker": "Anna", "label_price": "3.5"})
        self.assertEqual(rows["body1-1"]["split_shape"], "test")
        self.assertEqual(rows["body1-1"]["material"], "steel")
        self.assertEqual(rows["body3-3"]["family"], "mesh")
        self.assertEqual(len(rows), 4)
        # From the folder alone, with the table that it keeps.
        (self.folder / "table" / "objects.csv").rename(self.folder / "table" / "away.csv")
        sample = run_json("regenerate", output, "--sample", "body2-2/steel/1/strike-0001")
        self.assertTrue(sample["samples"][0]["identical"], sample)

    def test_every_wrong_row_is_told(self):
        (self.folder / "wrong.csv").write_text(
            "file,length,unit,material,split\n"
            "a.glb,5 kg,,,\nb.glb,,,stel,\nc.glb,1 cm,mm,,\nd.blend,,,,\ne.glb,,,,training\nf.glb,,,,\n")
        config = self.write("wrong.yaml", BUILD.format(
            objects="  - {manifest: wrong.csv, materials: [steel]}", more=""))
        answer = run("plan", config)
        self.assertEqual(answer.returncode, 2)
        for words in ("5 of 6 rows are wrong", "wrong.csv:2: length", "wrong.csv:3: material",
                      'did you mean "steel"?', "wrong.csv:4: unit", "wrong.csv:5: file",
                      "wrong.csv:6: split"):
            self.assertIn(words, answer.stderr)

    @pictures
    def test_pictures_have_the_base_colour(self):
        block = mesh_files.block(SIDES)
        striped = mesh_files.png([[(230, 20, 20), (20, 20, 230)]])
        (self.folder / "looks").mkdir()
        mesh_files.write_glb(self.folder / "looks" / "red.glb", [named("B", *block)], colour=(0.9, 0.02, 0.02))
        mesh_files.write_glb(self.folder / "looks" / "striped.glb", [named("B", *block)], picture=striped)
        mesh_files.write_glb(self.folder / "looks" / "plain.glb", [named("B", *block)])
        output, _ = self.build("looks-set", "  - {glob: 'looks/*.glb', materials: [plastic]}",
                               more="camera: {width: 96, height: 96}")

        def reds_and_blues(name):
            with h5py.File(output / "modes" / f"{name}.h5") as file:
                picture = file["appearances/frame"][0, 0].astype(int)
            red = (picture[..., 0] > picture[..., 2] + 60).sum()
            blue = (picture[..., 2] > picture[..., 0] + 60).sum()
            return red, blue

        red, blue = reds_and_blues("red")
        self.assertGreater(red, 1000)
        self.assertEqual(blue, 0)
        red, blue = reds_and_blues("striped")
        self.assertGreater(red, 200)
        self.assertGreater(blue, 200)
        red, blue = reds_and_blues("plain")  # the material's own blue
        self.assertEqual(red, 0)
        self.assertGreater(blue, 300)


if __name__ == "__main__":
    unittest.main()
