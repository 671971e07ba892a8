"""The sound in glTF files (KHR_audio_rigid_bodies): what `carillon export-gltf` writes by that extension,
and files that sound as they say."""
import base64
import json
import struct
import unittest

import h5py
import numpy
from commands import read_float_wav
from models import Glb
from program import FolderTest, run, run_json

BLOCK = ["block:length=200mm,width=80mm,height=8mm", "-m", "steel", "--order", "2", "--element-size", "20 mm"]
EXTENSION = "KHR_audio_rigid_bodies"


def decibels(a, b):
    """Level of the difference below the first."""
    return 20 * numpy.log10(numpy.linalg.norm(a - b) / numpy.linalg.norm(a))


class SoundingModels(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.files = {}
        for points in ("corners", "nodes"):
            path = cls.folder / f"{points}.glb"
            made = run_json("export-gltf", *BLOCK, "--audio-points", points, "-o", path)
            assert made["audio_modes"] > 5, made
            cls.files[points] = path
        run_json("modes", *BLOCK, "--max-modes", "60", "-o", cls.folder / "modes.h5")
        cls.found = run_json("modes", *BLOCK, "--max-modes", "60")

    def model(self, points="nodes"):
        glb = Glb(self.files[points])
        self.assertEqual(glb.document["extensionsUsed"], [EXTENSION])
        self.assertNotIn("extensionsRequired", glb.document)
        extension = glb.document["extensions"][EXTENSION]
        self.assertEqual(glb.document["nodes"][0]["extensions"][EXTENSION], {"modalModel": 0})
        return glb, extension["modalModels"][0], extension

    def test_frequencies_and_decay_rates_are_the_damped_modes(self):
        glb, model, extension = self.model()
        frequencies = glb.values(model["frequencies"])[:, 0].astype(float)
        decay_rates = glb.values(model["decayRates"])[:, 0].astype(float)
        expected = sorted((mode["frequency_hz"], mode["decay_rate_per_s"]) for mode in self.found["modes"])
        damped = [numpy.sqrt(f**2 - (d / (2 * numpy.pi)) ** 2) for f, d in expected]
        self.assertEqual(len(frequencies), len(expected))
        order = numpy.argsort(frequencies)
        numpy.testing.assert_allclose(frequencies[order], damped, rtol=1e-6)
        numpy.testing.assert_allclose(decay_rates[order], [d for _, d in expected], rtol=1e-5)
        # By the material's alpha and beta as well: d = (alpha + beta omega^2) / 2.
        material = extension["acousticMaterials"][model["material"]]
        omega_squared = (2 * numpy.pi * frequencies) ** 2 + decay_rates**2
        numpy.testing.assert_allclose((material["alpha"] + material["beta"] * omega_squared) / 2, decay_rates,
                                      rtol=1e-5)

    def test_shapes_are_mass_normalised_at_the_surface(self):
        glb, model, _ = self.model()
        points = glb.values(model["positions"]).astype(float)
        shapes = glb.values(model["shapes"]).astype(float).reshape(-1, len(points), 3)
        with h5py.File(self.folder / "modes.h5") as file:
            nodes = file["surface/nodes"][:]
            stored = file["shapes"][:].reshape(len(shapes), len(nodes), 3)
            eigenvalues = file["eigenvalues"][:]
        turned = nodes[:, [0, 2, 1]] * [1, 1, -1]
        nearest = numpy.array([numpy.linalg.norm(turned - p, axis=1).argmin() for p in points])
        self.assertLess(numpy.linalg.norm(turned[nearest] - points, axis=1).max(), 1e-6)
        frequencies = glb.values(model["frequencies"])[:, 0].astype(float)
        for shape, frequency in zip(shapes, frequencies):
            mode = numpy.abs(numpy.sqrt(eigenvalues) / (2 * numpy.pi) - frequency).argmin()
            expected = stored[mode][nearest][:, [0, 2, 1]] * [1, 1, -1]
            numpy.testing.assert_allclose(shape, expected, atol=1e-5 * numpy.abs(expected).max())
        triangles = glb.values(model["indices"]).reshape(-1, 3)
        corners = points[triangles]
        volume = numpy.einsum("ij,ij->i", corners[:, 0], numpy.cross(corners[:, 1], corners[:, 2])).sum() / 6
        self.assertAlmostEqual(volume / 1.28e-4, 1, 5)

    def test_mass_properties_are_those_of_the_block(self):
        _, model, extension = self.model("corners")
        mass = extension["acousticMaterials"][0]["density"] * 1.28e-4
        properties = model["massProperties"]
        self.assertAlmostEqual(properties["mass"] / mass, 1, 6)
        sides = numpy.array([0.2, 0.08, 0.008]) ** 2
        expected = sorted(mass / 12 * (sides.sum() - side) for side in sides)
        numpy.testing.assert_allclose(sorted(properties["inertiaDiagonal"]), expected, rtol=1e-5)
        x, y, z, w = properties["inertiaOrientation"]
        turn = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        tensor = turn @ numpy.diag(properties["inertiaDiagonal"]) @ turn.T
        # The long side along x, the height along y.
        numpy.testing.assert_allclose(numpy.diag(tensor), [expected[0], expected[2], expected[1]], rtol=1e-5)

    def test_the_loudest_modes_come_first(self):
        glb, model, _ = self.model()
        points, triangles = (glb.values(model[name]) for name in ("positions", "indices"))
        corners = points.astype(float)[triangles.reshape(-1, 3)]
        area = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        size = numpy.linalg.norm(area, axis=1)
        frequencies, decay_rates = (glb.values(model[name])[:, 0].astype(float)
                                    for name in ("frequencies", "decayRates"))
        shapes = glb.values(model["shapes"]).astype(float).reshape(len(frequencies), len(points), 3)
        loudness = []
        for shape, frequency, decay_rate in zip(shapes, frequencies, decay_rates):
            mean = shape[triangles.reshape(-1, 3)].mean(axis=1)
            everywhere = (size * (mean**2).sum(axis=1)).sum()
            normal = ((mean * area).sum(axis=1) ** 2 / size).sum()
            pulse = 1 / (1 + (2 * frequency * 0.5e-3) ** 2)
            loudness.append(everywhere * normal * (2 * numpy.pi * frequency * pulse) ** 2 / decay_rate)
        self.assertTrue((numpy.diff(loudness) <= 1e-4 * numpy.abs(loudness[:-1])).all(), loudness)
        self.assertGreater(loudness[0] / loudness[-1], 10)

    def test_a_file_sounds_as_the_object_does(self):
        # At a corner of faces inside of the upper side, where shapes are what both have stored.
        glb, model, _ = self.model("corners")
        x, y, z = numpy.array([p for p in glb.values(model["positions"]).astype(float)
                               if abs(p[1] - 0.008) < 1e-6 and abs(p[0]) < 0.09 and abs(p[2]) < 0.03]).T
        best = (numpy.abs(x - 0.05) + numpy.abs(z - 0.02)).argmin()
        strike = ("--at", f"{x[best]},{-z[best]},{y[best]}", "--direction", "0,0,-1", "--seed", "3")
        run_json("strike", *BLOCK, "--max-modes", "60", *strike, "-o", self.folder / "solved.wav")
        solved = read_float_wav(self.folder / "solved.wav")
        for points, level in (("nodes", -80), ("corners", -80)):
            answer = run("strike", self.files[points], *strike, "-o", self.folder / "read.wav")
            self.assertEqual(answer.returncode, 0, answer.stderr)
            difference = decibels(solved, read_float_wav(self.folder / "read.wav"))
            self.assertLess(difference, level, points)

    def changed(self, name, change, points="corners"):
        """A copy whose JSON was changed."""
        content = self.files[points].read_bytes()
        size, = struct.unpack("<I", content[12:16])
        document = json.loads(content[20:20 + size])
        change(document)
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        path = self.folder / name
        body = struct.pack("<I4s", len(text), b"JSON") + text + content[20 + size:]
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
        return path

    def test_scale_of_a_node_is_another_size(self):
        path = self.changed("twice.glb", lambda d: d["nodes"][0].update(scale=[2, 2, 2], translation=[1, 2, 3]))
        twice = run_json("modes", path)["modes"]
        once = run_json("modes", self.files["corners"])["modes"]
        material = Glb(path).document["extensions"][EXTENSION]["acousticMaterials"][0]
        for a, b in zip(once, twice):
            self.assertAlmostEqual(b["frequency_hz"] / a["frequency_hz"], 0.5, 6)
            omega = 2 * numpy.pi * b["frequency_hz"]
            self.assertAlmostEqual(b["decay_rate_per_s"] / ((material["alpha"] + material["beta"] * omega**2) / 2),
                                   1, 5)
        uneven = self.changed("uneven.glb", lambda d: d["nodes"][0].update(scale=[1, 2, 1]))
        answer = run("modes", uneven)
        self.assertEqual(answer.returncode, 2)
        self.assertIn("not scaled alike", answer.stderr)

    def test_decay_rates_of_a_file_count_whatever_its_material_says(self):
        def forget(document):
            material = document["extensions"][EXTENSION]["acousticMaterials"][0]
            del material["alpha"], material["beta"]
        path = self.changed("bare.glb", forget)
        for a, b in zip(run_json("modes", self.files["corners"])["modes"], run_json("modes", path)["modes"]):
            self.assertAlmostEqual(a["decay_rate_per_s"], b["decay_rate_per_s"], 9)

    def test_a_material_that_is_given_has_the_mesh_solved(self):
        modes = run_json("modes", self.files["corners"], "-m", "glass", "--order", "2", "--max-modes", "4")
        self.assertEqual(modes["certificate"]["count_verified"], True)

    def test_a_file_of_another_program(self):
        """Two modes on a tetrahedron, written as text with the buffer inside."""
        data, views, accessors = b"", [], []

        def add(values, kind, component=5126):
            nonlocal data
            array = numpy.asarray(values, "<f4" if component == 5126 else "<u2")
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
            accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind,
                              "count": array.size // (3 if kind == "VEC3" else 1)})
            data += array.tobytes() + b"\0" * (-array.nbytes % 4)
            return len(accessors) - 1

        model = {"frequencies": add([880, 440], "SCALAR"), "decayRates": add([9, 4], "SCALAR"),
                 "positions": add([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], "VEC3"),
                 "shapes": add(numpy.eye(8, 3) + 1, "VEC3"),
                 "indices": add([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], "SCALAR", 5123)}
        document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0,
                    "nodes": [{"name": "Chime", "extensions": {EXTENSION: {"modalModel": 0}}}],
                    "extensionsUsed": [EXTENSION], "extensions": {EXTENSION: {"modalModels": [model]}},
                    "accessors": accessors, "bufferViews": views,
                    "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64,"
                                 + base64.b64encode(data).decode()}]}
        path = self.folder / "chime.gltf"
        path.write_text(json.dumps(document))
        modes = run_json("modes", path)["modes"]
        self.assertIsNone(run_json("modes", path)["certificate"])
        self.assertIn("nothing was solved", run("modes", path).stdout)
        self.assertEqual([round(mode["decay_rate_per_s"], 6) for mode in modes], [4, 9])
        self.assertAlmostEqual(modes[0]["frequency_hz"], numpy.hypot(440, 4 / (2 * numpy.pi)), 4)
        answer = run("strike", path, "-o", self.folder / "chime.wav")
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertGreater(numpy.abs(read_float_wav(self.folder / "chime.wav")).max(), 0)
        for change, words in ((lambda d: accessors[2].update(count=9), "ends beyond"),
                              (lambda d: model.pop("indices"), "triangles between its points"),
                              (lambda d: model.update(shapes=99), "accessor 99"),
                              (lambda d: d["nodes"][0].pop("extensions"), "no material")):
            changed = json.loads(json.dumps(document))
            accessors, model = changed["accessors"], changed["extensions"][EXTENSION]["modalModels"][0]
            change(changed)
            path.write_text(json.dumps(changed))
            answer = run("strike", path, "-o", self.folder / "chime.wav")
            self.assertEqual(answer.returncode, 2, answer.stderr)
            self.assertIn(words, answer.stderr)


if __name__ == "__main__":
    unittest.main()
