"""Meshes made by others ($CARILLON_TEST_DATA): each ends in modes or in a named reason."""
import json
import os
import pathlib
import unittest

import h5py
import numpy
from program import LONG, FolderTest, run

DATA = os.environ.get("CARILLON_TEST_DATA")
# What cannot be an object: no volume, nothing at all, or triangles without neighbours.
NO_BODIES = {"degenerate_flat", "edge_with_four_triangles", "triangle_soup_100", "empty"}


@unittest.skipUnless(DATA, "CARILLON_TEST_DATA is not set")
class RealMeshes(FolderTest):
    def chosen(self, kind):
        """A folder with the meshes of a kind; the large ones are for the slow test."""
        folder = self.folder / kind
        folder.mkdir()
        for path in pathlib.Path(DATA, "meshes", kind).iterdir():
            if LONG or path.stat().st_size < 300_000:
                (folder / path.name).symlink_to(path)
        return folder

    def test_every_mesh_ends_in_modes_or_in_a_reason(self):
        clean, dirty, edge = map(self.chosen, ("clean", "dirty", "format_edge"))
        config = self.write("real.yaml", f"""
name: real
materials: [ceramic]
objects:
  - mesh: {clean}/*
    name: clean
    length: 0.12 m
  - mesh: {dirty}/*
    name: dirty
    length: 0.12 m
  - mesh: {edge}/*
    name: edge
    length: 0.12 m
modes: {{order: 2, max_modes: 20, max_elements: 60000}}
audio: {{seconds: 0.3 s}}
strikes: {{per_object: 1}}
voxels: {{}}
camera: {{width: 128, height: 128}}
files: {{png: true}}
""")
        output = self.folder / "real"
        result = run("build", config, "-o", output, ranks=2, timeout=900)
        self.assertIn(result.returncode, (0, 3), result.stderr)
        failures = json.loads((output / "failures.json").read_text())
        for failure in failures:
            self.assertIn(failure["kind"], ("InputError", "SolverError"), failure)
            self.assertGreater(len(failure["message"]), 20, failure)
        failed = {f["task"].split("-", 1)[1] for f in failures}
        print("refused:", json.dumps({f["task"]: f["message"] for f in failures}, indent=2))
        self.assertLessEqual(NO_BODIES, failed)
        self.assertEqual({path.stem for path in clean.iterdir()} & failed, set())
        with h5py.File(output / "index.h5") as index:
            audio = index["audio"][()]
            self.assertTrue(numpy.isfinite(audio).all())
            self.assertTrue((numpy.abs(audio).max(axis=1) > 0).all())


if __name__ == "__main__":
    unittest.main()
