"""Files of ModelNet's make and quality: thin boards put together, open, non-manifold, inside out, in pieces,
their counts glued to the keyword. Each ends in modes or in a reason, and a network meets what is left."""
import collections
import json
import unittest

import h5py
import numpy
from program import CONFIGS, LONG, FolderTest, run, run_json

FACES = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2),
         (2, 4, 6), (1, 3, 5), (3, 7, 5)]


class Soup:
    """Triangles of boards, as furniture is drawn."""

    def __init__(self):
        self.vertices, self.faces = [], []

    def board(self, low, high, faces=FACES):
        first = len(self.vertices)
        for i in range(8):
            self.vertices.append([(low, high)[i >> axis & 1][axis] for axis in range(3)])
        self.faces += [tuple(first + corner for corner in face) for face in faces]
        return self


def legs(soup, width, depth, height, thick):
    for x in (0, width - thick):
        for y in (0, depth - thick):
            soup.board((x, y, 0), (x + thick, y + thick, height))
    return soup


# Of ModelNet10, drawn from boards; `d` differs from file to file. [same unit as the files, arbitrary]
CLASSES = {
    "bathtub": lambda d: (Soup().board((0, 0, 0), (60 + d, 30, 4)).board((0, 0, 3), (60 + d, 4, 20))
                          .board((0, 26, 3), (60 + d, 30, 20)).board((0, 0, 3), (4, 30, 20))
                          .board((56 + d, 0, 3), (60 + d, 30, 20))),
    "bed": lambda d: legs(Soup().board((0, 0, 10), (80 + d, 60, 20)).board((0, 0, 9), (5, 60, 45)), 80 + d, 60, 11, 5),
    "chair": lambda d: legs(Soup().board((0, 0, 20), (24, 24, 23)).board((0, 0, 22), (3, 24, 46 + d)), 24, 24, 21, 3),
    "desk": lambda d: (Soup().board((0, 0, 28), (60 + d, 30, 31)).board((0, 0, 0), (3, 30, 29))
                       .board((57 + d, 0, 0), (60 + d, 30, 29)).board((0, 27, 10), (60 + d, 30, 29))),
    "dresser": lambda d: (Soup().board((0, 0, 0), (40, 20, 45 + d)).board((2, -2, 3), (38, 1, 13))
                          .board((2, -2, 17), (38, 1, 27))),
    "monitor": lambda d: (Soup().board((0, 0, 12), (50 + d, 4, 42)).board((20, 1, 2), (30, 3, 14))
                          .board((14, -8, 0), (36, 12, 3))),
    "night_stand": lambda d: legs(Soup().board((0, 0, 8), (20, 20, 28 + d)), 20, 20, 9, 4),
    "sofa": lambda d: (Soup().board((0, 0, 0), (70 + d, 30, 14)).board((0, 24, 10), (70 + d, 32, 32))
                       .board((-6, 0, 0), (2, 32, 22)).board((68 + d, 0, 0), (76 + d, 32, 22))),
    "table": lambda d: legs(Soup().board((0, 0, 28), (50 + d, 34, 31)), 50 + d, 34, 29, 4),
    "toilet": lambda d: (Soup().board((0, 0, 0), (14, 20, 16)).board((-3, -3, 14), (17, 22, 20))
                         .board((-2, 18, 18), (16, 26, 38 + d))),
}


def opened(soup):
    """A board's face is missing, as where nobody looks."""
    del soup.faces[4:6]


def shared_by_three(soup):
    """A wall without thickness stands on an edge of a board: three faces meet there."""
    low, high = soup.vertices[0], soup.vertices[7]
    first = len(soup.vertices)
    soup.vertices += [[low[0], low[1], high[2] + 4], [high[0], low[1], high[2] + 4]]
    soup.faces += [(4, 5, first), (5, first + 1, first)]


def inside_out(soup):
    soup.faces = [face if i % 3 else face[::-1] for i, face in enumerate(soup.faces)]


def twice(soup):
    """Both sides of every face, and each corner once for each face."""
    soup.faces += [face[::-1] for face in soup.faces]
    soup.vertices = [soup.vertices[corner] for face in soup.faces for corner in face]
    soup.faces = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(soup.faces))]


def littered(soup):
    """Faces without area, corners that no face has, a crumb that floats."""
    soup.vertices += [[1e3, 1e3, 1e3], [0.5, 0.5, 0.5]]
    soup.faces += [(0, 0, 1), (0, 1, 1)]
    soup.board((5, 5, 60), (5.2, 5.2, 60.2))


DAMAGES = (lambda soup: None, opened, shared_by_three, inside_out, twice, littered)


def write_off(path, soup, style):
    """As they are found: counts behind the keyword, comments and empty lines, Windows' line ends, values in
    exponents."""
    counts = f"{len(soup.vertices)} {len(soup.faces)} 0"
    head = (f"OFF{counts}\n", f"OFF\n{counts}\n", f"OFF\n# drawn\n\n{counts}\n", f"OFF {counts}\r\n")[style]
    number = (lambda x: f"{x:g}") if style < 2 else (lambda x: f"{x:e}")
    end = "\r\n" if style == 3 else "\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes((head + "".join(" ".join(map(number, vertex)) + end for vertex in soup.vertices)
                      + "".join(f"3 {a} {b} {c}{end}" for a, b, c in soup.faces)).encode())


def number_of(shape):
    return int(shape.rsplit("_", 1)[1])


class Furniture(FolderTest):
    """Forty files of ten classes (`ctest -L slow`), or a dozen of three."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.classes = list(CLASSES) if LONG else ["chair", "monitor", "sofa"]
        cls.files = {}
        for c, name in enumerate(cls.classes):
            for number in range(4):
                soup = CLASSES[name](3.0 * number)
                damage = DAMAGES[(c + number) % len(DAMAGES)]
                damage(soup)
                part = "test" if number == 3 else "train"
                shape = f"{name}_{number:04}"
                write_off(cls.folder / "ModelNet10" / name / part / f"{shape}.off", soup, (c + number) % 4)
                cls.files[shape] = damage.__name__
        text = (CONFIGS / "modelnet10.yaml").read_text()
        cls.config = cls.folder / "modelnet10.yaml"
        entries = text[text.index("  - modelnet:"):text.index("\nmodes:")].split("  - modelnet:")[1:]
        kept = [entry for entry in entries if any(f"[{name}]" in entry for name in cls.classes)]
        anchors = ("per_class: &files 40", "length: &length 40 cm", "sizes: &sizes [1]")
        body = "".join("  - modelnet:" + entry for entry in kept)
        for anchor in anchors:
            key, value = anchor.split(": ", 1)
            name, plain = value.split(" ", 1)
            body = body.replace(f"{key}: {value}", f"{key}: {plain}").replace(f"*{name[1:]}", plain)
        cls.config.write_text(text[:text.index("  - modelnet:")] + body + text[text.index("\nmodes:"):])
        cls.settings = []
        for setting in ("modes.max_modes=12", "modes.order=2", "modes.max_elements=40000", "solver.pitch_cents=off",
                        "audio.seconds=0.25 s", "mel={bands: 32, frames: 12}",
                        "voxels={resolution: 16, turns: 12}", "split.validation=0.4", "limits.mesh_time=60 s"):
            cls.settings += ["--set", setting]
        cls.output = cls.folder / "sets"
        cls.built = run("build", cls.config, "-o", cls.output, *cls.settings, ranks=2, timeout=3600)

    def failures(self, variant):
        folder = self.output / f"variants={variant}"
        return {entry["task"].split("-", 1)[1].split(".")[0]: entry
                for entry in json.loads((folder / "failures.json").read_text())}

    def test_each_file_ends_in_modes_or_in_a_reason(self):
        self.assertIn(self.built.returncode, (0, 3), self.built.stderr)
        for variant in ("o", "os", "om", "osm"):
            failed = self.failures(variant)
            for failure in failed.values():
                self.assertIn(failure["kind"], ("InputError", "SolverError"), failure)
                self.assertGreater(len(failure["message"]), 20, failure)
            with h5py.File(self.output / f"variants={variant}" / "index.h5") as index:
                made = set(index["shape"].asstr()[()])
                parts = dict(zip(index["shape"].asstr()[()], index["split_shape"].asstr()[()]))
                self.assertEqual(index["shapes/voxels"].shape[1:], (12, 16, 16, 16))
                audio = index["audio"][()]
            self.assertTrue(numpy.isfinite(audio).all() and (numpy.abs(audio).max(axis=1) > 0).all())
            lost = collections.Counter(self.files[shape] for shape in self.files if shape not in made)
            print(variant, f"{len(made)} of {len(self.files)} sound; lost:", dict(lost))
            self.assertGreaterEqual(len(made), 0.9 * len(self.files), lost)
            for shape, part in parts.items():
                self.assertEqual(part == "test", number_of(shape) == 3, shape)

    def test_networks_learn_and_are_compared_with_the_papers(self):
        methods = "train.methods={isnn-a: {outliers: 0, kernel: [8, 2]}, voxnet: {}, isnn-av-bilinear: {kernel: [8, 2]}}"
        document = run_json("evaluate", self.config, "-o", self.output, *self.settings, "--set", methods,
                            "--set", "train.epochs=4", "--set", "evaluate.classification.seeds=[1]", ranks=2,
                            timeout=3600)
        text = json.dumps(document)
        for published in ("mn10o-geometry", "mn10os-geometry", "mn10om-geometry", "mn10osm-geometry"):
            self.assertIn(published, text)


if __name__ == "__main__":
    unittest.main()
