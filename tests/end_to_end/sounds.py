"""strike in scenes at the edges of what can be heard, and what the documents say of their keys."""
import json
import pathlib
import re
import unittest
import warnings

import h5py
import numpy
import scipy.io.wavfile
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


class Force(FolderTest):
    """strike --force: a force in newtons over time."""

    def strike(self, *arguments):
        path = self.folder / "struck.wav"
        answer = run_json("strike", *BOWL, "--at", "0.06,0,0.05", *arguments, "-o", path)
        with warnings.catch_warnings():  # of chunks that are neither format nor data
            warnings.simplefilter("ignore", scipy.io.wavfile.WavFileWarning)
            rate, sound = scipy.io.wavfile.read(path)
        self.assertEqual(rate, 44100)
        return sound.astype(float), answer

    def force(self, name, samples, rate):
        path = self.folder / name
        scipy.io.wavfile.write(path, rate, numpy.asarray(samples, numpy.float32))
        return ("--force", path)

    def expect_equal(self, sound, expected, decibels):
        error = numpy.abs(sound - expected).max() / numpy.abs(expected).max()
        self.assertLess(error, 10**(decibels / 20))

    def test_of_the_usual_pulse_sounds_as_it_does(self):
        contact, rate, impulse = 5e-4, 384000, 0.03
        time = numpy.arange(round(contact * rate) + 1) / rate
        pulse = (1 - numpy.cos(2 * numpy.pi * time / contact)) / 2
        peak = 2 * impulse / contact
        expected, _ = self.strike("--impulse", f"{impulse} N s", "--contact-time", f"{contact} s")
        newtons = self.force("newtons.wav", peak * pulse, rate)  # beyond full scale
        sound, answer = self.strike(*newtons)
        self.expect_equal(sound, expected, -60)
        self.assertAlmostEqual(answer["impulse_ns"], impulse, 6)
        self.assertAlmostEqual(answer["contact_time_s"], contact, 6)
        scaled, _ = self.strike(*self.force("scaled.wav", 0.3 * pulse, rate),
                                "--force-peak", f"{peak} N")
        self.expect_equal(scaled, expected, -60)
        self.expect_equal(self.strike(*newtons, "--force-peak", "1 N")[0], expected / peak, -60)

    def test_at_another_rate_sounds_the_same(self):
        def half_sine(rate):
            return numpy.sin(numpy.pi * numpy.arange(round(1e-3 * rate)) / (1e-3 * rate))
        sounds = [self.strike(*self.force(f"{rate}.wav", half_sine(rate), rate))[0]
                  for rate in (96000, 192000, 384000)]
        self.expect_equal(sounds[0], sounds[2], -40)
        self.expect_equal(sounds[1], sounds[2], -52)  # a quarter of that error

    def test_of_one_sample_is_an_impulse(self):
        rate = 16 * 44100
        sound, answer = self.strike(*self.force("one.wav", [0] * 16 + [1], rate),
                                    "--force-peak", f"{0.02 * rate} N")
        self.assertAlmostEqual(answer["impulse_ns"], 0.02, 8)
        expected, _ = self.strike("--contact-time", "0", "--impulse", "0.02 N s")
        self.expect_equal(sound[2:], expected[1:-1], -45)

    def test_beyond_the_clip_and_in_time(self):
        """A force that pushes and pulls, longer than the clip; and two strikes are two sounds."""
        noise = numpy.random.default_rng(3).normal(size=9600)
        long, _ = self.strike(*self.force("long.wav", noise, 48000))
        short, _ = self.strike(*self.force("short.wav", noise[:4800], 48000))
        self.expect_equal(short, long, -120)  # the clip is 0.05 s
        late, _ = self.strike(*self.force("late.wav", [0] * 4410 + list(noise[:200]), 441000))
        once, _ = self.strike(*self.force("once.wav", [0] + list(noise[:200]), 441000))
        twice, _ = self.strike(*self.force("once.wav", [0] + list(noise[:200]), 441000), "--repeat",
                               "2", "--interval", "10 ms")
        gap = numpy.zeros(441)
        self.expect_equal(twice, once + numpy.concatenate([gap, once[:-441]]), -100)
        self.assertEqual(numpy.abs(late[:430]).max(), 0)

    def test_says_what_is_wrong(self):
        good = self.force("good.wav", [0, 1, 0], 48000)
        for arguments, said in (
                ((*good, "--impulse", "1 N s"), ("--force and --impulse",)),
                ((*good, "--contact-time", "1 ms"), ("--force and --contact-time",)),
                ((*good, "--set", "striker.kind=metal"), ("striker",)),
                ((*good, "--set", "effects.contact=off"), ("effects.contact",)),
                ((*good, "--force-peak", "0 N"), ("good.wav", "positive")),
                ((*good, "--force-peak", "20 Pa"), ("force",)),
                (("--force-peak", "20 N"), ("--force-peak", "--force")),
                (self.force("zero.wav", [0, 0, 0], 48000), ("zero.wav", "nothing would sound")),
                (self.force("two.wav", numpy.ones((9, 2)), 48000), ("two.wav", "2 channels")),
                (self.force("nan.wav", [0, numpy.nan, 0], 48000), ("nan.wav", "not finite")),
                (self.force("long.wav", numpy.ones(61000), 1000), ("long.wav", "60 s")),
                (("--force", self.folder / "none.wav"), ("none.wav",))):
            result = run("strike", *BOWL, *arguments, "-o", self.folder / "wrong.wav")
            self.assertEqual(result.returncode, 2, result.stderr)
            for word in said:
                self.assertIn(word, result.stderr)
            self.assertFalse((self.folder / "wrong.wav").exists())


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
        self.assertEqual(new, {"mel", "voxels", "voxel_pitch", "voxel_origin", "appearances/material",
                               "appearances/frame"})


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
