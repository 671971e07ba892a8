"""strike in scenes at the edges of what can be heard, and what the documents say of their keys."""
import json
import pathlib
import re
import unittest

import h5py
from program import FolderTest, run, run_json

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
BOWL = ("bowl:radius=60mm,wall=3mm", "-m", "ceramic", "--seconds", "0.05")


class Strike(FolderTest):
    def strike(self, *arguments, **options):
        return run_json("strike", *BOWL, *arguments, "-o", self.folder / "x.wav", **options)

    def test_listener_near_the_body_hears_it_without_a_click(self):
        near = ("--listener", "0,0,0.03")
        result = self.strike(*near)
        self.assertGreater(result["peak"], 0)
        self.assertEqual(result["record"]["click_peak"], 0)
        self.assertEqual(result["record"]["click_left_out"], 1)
        spoken = run("strike", *BOWL, *near, "-o", self.folder / "x.wav")
        self.assertEqual(spoken.returncode, 0)
        self.assertEqual(spoken.stderr.count("no click at 1 of 1 listeners"), 1, spoken.stderr)
        forced = run("strike", *BOWL, *near, "--set", "effects.click=on", "-o",
                     self.folder / "y.wav")
        self.assertEqual(forced.returncode, 2)
        self.assertIn("inside the sphere", forced.stderr)
        self.assertIn("move the listener away", forced.stderr)

    def test_modes_above_half_the_sample_rate_are_said(self):
        everything = len(run_json("modes", *BOWL[:3])["modes"])
        usual = self.strike("--sample-rate", "16000")
        self.assertEqual(usual["modes_above_nyquist"], 0)
        asked = ("--sample-rate", "16000", "--max-frequency", "20 kHz")
        result = self.strike(*asked)
        left_out = result["modes_above_nyquist"]
        self.assertGreater(left_out, 0)
        self.assertEqual(result["modes"], usual["modes"])
        self.assertEqual(result["modes"] + left_out, everything)
        spoken = run("strike", *BOWL, *asked, "-o", self.folder / "x.wav")
        self.assertIn(f"{left_out} modes above half the sample rate left out", spoken.stdout)


LITTLE = """
name: little
materials: [steel]
objects:
  - shape: tile
    parameters: {length: 10 cm, width: 8 cm, thickness: 6 mm}
modes: {max_modes: 8, order: 2, element_size: 20 mm}
audio: {seconds: 0.1 s, sample_rate: 16 kHz}
strikes: {per_object: 3}
split: {validation: 0, test: 0}
"""
# Of every effect that has a key of its own.
KEYS = """
mel: {bands: 20, frames: 5}
voxels: {resolution: 8}
camera: {width: 16, height: 16}
listeners: [{position: [0, 0, 1]}]
striker: {kind: metal}
supports: {contacts: [{kind: table, lowest: true}]}
room: {dimensions: [5, 4, 3], rt60: 0.4}
noise: {kind: white}
recording: {gain: 3 dB}
"""
SWITCHES = "effects: {%s}\n" % ", ".join(f"{name}: off" for name in ["mel", "voxels", "frames", "striker", "supports", "radiation", "click", "room", "tail", "noise", "recording"])


class Builds(FolderTest):
    """What is off is neither called nor stored, whether its key is there or not."""

    def build(self, name, text):
        out = self.folder / name
        run_json("build", self.write(f"{name}.yaml", text), "-o", out)
        trace = json.loads((out / "trace.json").read_text())
        stored = {}
        for path in sorted(out.glob("[ms]*/*.h5")):  # of the index, shards are all there is
            with h5py.File(path) as file:
                def add(name, item, shard=str(path.relative_to(out))):  # noqa: B008 -- of this round
                    if isinstance(item, h5py.Dataset):
                        stored[f"{shard}:{name}"] = repr(item[()].tolist())
                file.visititems(add)
        return {name: entry["calls"] for name, entry in trace["effects"].items()}, stored

    def test_effects_that_are_off_leave_nothing_behind(self):
        calls, stored = self.build("absent", LITTLE)
        self.assertEqual(set(calls), {"damping", "contact"})
        off_calls, off_stored = self.build("off", LITTLE + KEYS + SWITCHES)
        self.assertEqual(off_calls, calls)
        self.assertEqual(set(off_stored), set(stored))
        for name, values in stored.items():
            self.assertEqual(off_stored[name], values, name)

    def test_views_are_counted_where_they_are_on_and_change_no_sound(self):
        _, stored = self.build("without", LITTLE)
        views = "".join(line + "\n" for line in KEYS.splitlines()
                        if line.startswith(("mel", "voxels", "camera")))
        seen_calls, seen = self.build("views", LITTLE + views)
        self.assertEqual({name: seen_calls[name] for name in ("mel", "voxels", "frames")},
                         {"mel": 3, "voxels": 1, "frames": 1})
        for name, values in stored.items():
            self.assertEqual(seen[name], values, name)
        new = {name.split(":")[1] for name in set(seen) - set(stored)}
        self.assertEqual(new, {"mel", "voxels", "voxel_pitch", "voxel_origin", "frame"})


class Documents(unittest.TestCase):
    def test_a_key_stands_once_in_its_section(self):
        seen = set()
        section = ""
        for line in (DOCS / "configuration.md").read_text().splitlines():
            if line.startswith("## "):
                section = line
            if not line.startswith("| `"):
                continue
            for key in re.findall(r"`([^`]+)`", line.split("|")[1]):
                self.assertNotIn((section, key), seen)
                seen.add((section, key))
        self.assertGreater(len(seen), 100)


if __name__ == "__main__":
    unittest.main()
