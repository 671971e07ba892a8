"""`carillon export-gltf`: files read back by Khronos' validator and by hand, against the surface and
the shapes that `carillon modes` stores."""
import json
import shutil
import struct
import subprocess
import unittest

import h5py
import msh_files
import numpy
from program import FolderTest, docs_block, run, run_json

BODY = ["bowl:radius=60mm,wall=4mm", "--order", "2", "--element-size", "20 mm"]
ABOUT_AXIS = BODY[:1]  # at the nodes of rings
VALIDATE = """
require("gltf-validator").validateBytes(new Uint8Array(require("fs").readFileSync(process.argv[1])))
  .then(report => console.log(JSON.stringify(report)));
"""


def mode_shapes():
    """The function of docs/python.md."""
    names = {}
    exec(compile(docs_block("python.md", "python", "def mode_shapes"), "docs", "exec"), names)
    return names["mode_shapes"]


class Glb:
    """A binary glTF file by its specification (Khronos, glTF 2.0, sections 3.6 and 4.4)."""

    def __init__(self, path):
        content = path.read_bytes()
        magic, version, length = struct.unpack("<4sII", content[:12])
        assert (magic, version, length) == (b"glTF", 2, len(content))
        chunks, begin = [], 12
        while begin < length:
            size, kind = struct.unpack("<I4s", content[begin:begin + 8])
            assert size % 4 == 0
            chunks.append((kind, content[begin + 8:begin + 8 + size]))
            begin += 8 + size
        (first, text), (second, self.buffer) = chunks
        assert (first, second) == (b"JSON", b"BIN\0")
        self.document = json.loads(text)

    def values(self, number):
        """An accessor's values, after its own promises were looked at."""
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        width = {"VEC3": 3, "SCALAR": 1}[accessor["type"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == 4 * width * accessor["count"]
        assert view["byteOffset"] + view["byteLength"] <= self.document["buffers"][0]["byteLength"]
        values = numpy.frombuffer(self.buffer, kind, width * accessor["count"],
                                  view["byteOffset"]).reshape(-1, width)
        for name, found in (("min", values.min(axis=0)), ("max", values.max(axis=0))):
            if name in accessor:
                assert numpy.array_equal(numpy.float32(accessor[name]), found)
        return values

    @property
    def mesh(self):
        return self.document["meshes"][0]

    def vertices(self, of="POSITION"):
        return self.values(self.mesh["primitives"][0]["attributes"][of])

    def ranged(self, number):
        return {"min", "max"} <= set(self.document["accessors"][number])

    def triangles(self):
        """Of each primitive: vertices' numbers."""
        lists = [self.values(one["indices"]).reshape(-1, 3) for one in self.mesh["primitives"]]
        assert max(one.max() for one in lists) < len(self.vertices())
        return lists


def to_gltf(vectors):
    return numpy.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1)


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]].astype(float) for k in range(3))
    return numpy.einsum("ij,ij->", a, numpy.cross(b, c)) / 6


class Models(FolderTest):
    def export(self, name, *arguments):
        path = self.folder / f"{name}.glb"
        found = run_json("export-gltf", *arguments, "-o", path)
        glb = Glb(path)
        self.assertEqual(found["vertices"], len(glb.vertices()))
        self.assertEqual(found["triangles"], sum(map(len, glb.triangles())))
        return glb

    def two_parts(self):
        return self.write("bar.msh", msh_files.msh_4(*msh_files.two_part_bar()))

    def test_shows_the_surface_and_the_modes(self):
        for arguments in (BODY, ABOUT_AXIS):
            with self.subTest(arguments=arguments):
                self.expect_surface_and_modes([*arguments, "-m", "ceramic"])

    def expect_surface_and_modes(self, arguments):
        glb = self.export("bowl", *arguments, "--modes", "6", "--amplitude", "0.1",
                          "--audio-modes", "0")  # more modes have a finer surface
        stored = self.folder / "modes.h5"
        run_json("modes", *arguments, "--max-modes", "6", "-o", stored)
        with h5py.File(stored) as file:
            nodes, shapes = file["surface/nodes"][:], mode_shapes()(file)
            eigenvalues = file["eigenvalues"][:]
            faces, order = file["surface/faces"][:], file["surface"].attrs["order"]
        expected = to_gltf(nodes).astype("f4")
        places = {tuple(place): number for number, place in enumerate(expected)}
        self.assertEqual(len(places), len(nodes))
        number = numpy.array([places[tuple(place)] for place in glb.vertices()])
        self.assertEqual(set(number), set(range(len(nodes))))
        (triangles,) = glb.triangles()
        self.assertEqual(len(triangles), len(faces) * order**2)
        self.assertTrue(glb.ranged(glb.mesh["primitives"][0]["attributes"]["POSITION"]))

        size = (nodes.max(axis=0) - nodes.min(axis=0)).max()
        extras = glb.mesh["extras"]
        targets = glb.mesh["primitives"][0]["targets"]
        self.assertEqual(len(targets), len(eigenvalues))
        self.assertEqual(len(extras["targetNames"]), len(targets))
        self.assertEqual(glb.mesh["weights"], [0.0] * len(targets))
        for mode, target in enumerate(targets):
            self.assertTrue(glb.ranged(target["POSITION"]))
            moved = glb.values(target["POSITION"]).astype(float)
            shape = to_gltf(shapes[mode].reshape(-1, 3).astype(float))[number]
            facts = extras["modes"][mode]
            numpy.testing.assert_allclose(moved, facts["metres_per_shape"] * shape,
                                          atol=1e-6 * 0.1 * size)
            self.assertAlmostEqual(numpy.linalg.norm(moved, axis=1).max() / size, 0.1, 6)
            self.assertAlmostEqual(facts["frequency_hz"],
                                   eigenvalues[mode]**0.5 / (2 * numpy.pi), 6)
            self.assertAlmostEqual(facts["decay_rate_per_s"], (6 + 1e-7 * eigenvalues[mode]) / 2,
                                   6)
            self.assertIn(f"{facts['frequency_hz']:.1f} Hz", extras["targetNames"][mode])

    def test_normals_are_those_of_the_triangles(self):
        glb = self.export("normals", *BODY, "-m", "ceramic", "--modes", "2", "--amplitude", "0.02")
        points, normals, (triangles,) = glb.vertices(), glb.vertices("NORMAL"), glb.triangles()
        numpy.testing.assert_allclose(numpy.linalg.norm(normals, axis=1), 1, atol=1e-6)
        self.assertGreater(volume(points, triangles), 0)
        target = glb.mesh["primitives"][0]["targets"][0]
        for weight in (0, 1):
            there = points + weight * glb.values(target["POSITION"]).astype(float)
            seen = normals + weight * glb.values(target["NORMAL"]).astype(float)
            a, b, c = (there[triangles[:, k]] for k in range(3))
            area = numpy.cross(b - a, c - a)
            area /= numpy.linalg.norm(area, axis=1)[:, None]
            for k in range(3):
                cosine = numpy.einsum("ij,ij->i", area, seen[triangles[:, k]])
                self.assertGreater(cosine.min(), 0.7)   # no corner looks elsewhere
                self.assertGreater(numpy.median(cosine), 0.98)

    def test_encloses_the_body(self):
        glb = self.export("block", "block:length=100mm,width=60mm,height=40mm")
        self.assertAlmostEqual(volume(glb.vertices(), glb.triangles()[0]) / 2.4e-4, 1, 6)
        extent = numpy.ptp(glb.vertices(), axis=0)
        numpy.testing.assert_allclose(extent, [0.1, 0.04, 0.06], rtol=1e-6)  # its height is along y
        normals = numpy.abs(glb.vertices("NORMAL"))
        numpy.testing.assert_allclose(normals.max(axis=1), 1, atol=1e-6)  # edges are kept
        self.assertNotIn("animations", glb.document)
        self.assertNotIn("targets", glb.mesh["primitives"][0])

    def test_swings_each_mode(self):
        glb = self.export("swings", *BODY, "-m", "glass", "--modes", "4", "--period", "2 s")
        count = len(glb.mesh["weights"])
        self.assertEqual(len(glb.document["animations"]), count)
        for mode, animation in enumerate(glb.document["animations"]):
            (sampler,), (channel,) = animation["samplers"], animation["channels"]
            self.assertEqual(channel["target"], {"node": 0, "path": "weights"})
            times = glb.values(sampler["input"])[:, 0]
            self.assertTrue(glb.ranged(sampler["input"]))
            weights = glb.values(sampler["output"]).reshape(len(times), count)
            expected = numpy.zeros_like(weights)
            expected[:, mode] = numpy.sin(numpy.pi * times)
            numpy.testing.assert_allclose(weights, expected, atol=1e-6)
            self.assertEqual(times[-1], 2)
            frequency = glb.mesh["extras"]["modes"][mode]["frequency_hz"]
            self.assertAlmostEqual(animation["extras"]["slowed_by"], 2 * frequency)

    def test_each_region_has_its_material(self):
        bar = self.two_parts()
        glb = self.export("parts", bar, "-m", "left=steel,right=wood", "--modes", "2",
                          "--pitch-cents", "off")
        self.assertEqual([one["name"] for one in glb.document["materials"]], ["steel", "wood"])
        looks = [one["pbrMetallicRoughness"] for one in glb.document["materials"]]
        self.assertEqual([one["metallicFactor"] for one in looks], [1, 0])
        self.assertEqual([one["name"] for one in glb.mesh["extras"]["materials"]],
                         ["steel", "wood"])
        middles = [glb.vertices()[triangles].mean(axis=1)[:, 0] for triangles in glb.triangles()]
        self.assertEqual([one["material"] for one in glb.mesh["primitives"]], [0, 1])
        self.assertLess(middles[0].max(), 0.1)
        self.assertGreater(middles[1].min(), 0.1)
        self.assertAlmostEqual(volume(glb.vertices(), numpy.concatenate(glb.triangles())) / 8e-5,
                               1, 5)
        plain = self.export("plain", bar)
        self.assertEqual([one["name"] for one in plain.document["materials"]], ["left", "right"])
        numpy.testing.assert_array_equal(plain.vertices(), glb.vertices())

    def test_axisymmetric_and_looks_alone(self):
        glb = self.export("turned", "bowl:radius=60mm,wall=4mm", "-m", "ceramic", "--solver",
                          "axisymmetric", "--modes", "2")
        self.assertGreater(volume(glb.vertices(), glb.triangles()[0]), 0)
        self.assertEqual(len(glb.mesh["weights"]), 2)
        glb = self.export("looks", *BODY, "-m", "iron", "--modes", "0")
        self.assertNotIn("weights", glb.mesh)
        self.assertEqual(glb.document["materials"][0]["name"], "iron")

    def test_khronos_validator_finds_nothing(self):
        if not (shutil.which("node") and shutil.which("npm")):
            self.skipTest("no node or no npm")
        there = subprocess.run(["npm", "install", "--prefix", self.folder, "gltf-validator"],
                               capture_output=True, text=True, timeout=120, check=False)
        if there.returncode != 0:
            self.skipTest("npm cannot get gltf-validator: " + there.stderr[-300:])
        self.export("valid-bowl", *BODY, "-m", "ceramic")
        self.export("valid-plain", *BODY)
        self.export("valid-parts", self.two_parts(), "-m", "left=steel,right=wood")
        for path in self.folder.glob("valid-*.glb"):
            report = json.loads(subprocess.run(["node", "-e", VALIDATE, path], cwd=self.folder,
                                               capture_output=True, check=True).stdout)
            self.assertEqual(report["info"]["version"], "2.0")
            # The validator does not know the extension, nor what of the file is for it alone.
            of_extension = ("UNSUPPORTED_EXTENSION", "UNUSED_OBJECT")
            rest = [message for message in report["issues"]["messages"]
                    if message["severity"] < 2 or message["code"] not in of_extension]
            self.assertEqual(rest, [], path)

    def test_says_what_is_wrong(self):
        for arguments, said in ((("--modes", "3"), "material"), (("--amplitude", "0"), "amplitude"),
                                (("--period", "0 s"), "period"), (("-m", "steeel"), "steel")):
            result = run("export-gltf", *BODY, *arguments, "-o", self.folder / "wrong.glb")
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(said, result.stderr)
            self.assertFalse((self.folder / "wrong.glb").exists())

    def test_what_rank_0_alone_finds_wrong_ends_all(self):
        file = self.write("file", "")
        result = run("export-gltf", *BODY, "-o", file / "wrong.glb", ranks=2)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(str(file), result.stderr)
        self.assertNotIn("MPI_ABORT", result.stderr)


if __name__ == "__main__":
    unittest.main()
