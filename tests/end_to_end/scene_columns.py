"""Simulations with every option that columns depend on: what is stored, and what the objects from files are."""
import json
import unittest
import wave

import h5py
import msh_files
import numpy
from moving_scene import BOXES, SHAPES, SHARDS, SIMULATIONS, MovingTest
from program import run, run_json
from same import hashes

SAMPLES, LISTENERS, STEPS, FRAMES = 6400, 2, 401, 5
BODIES = ["floor", "crate", "other", "top", "chime", "ball", "stylus"]
# Columns of rows wider than one value; the others are one value or text.
ROWS = {"audio": (LISTENERS, SAMPLES), "mel": (LISTENERS, 16, 9), "poses": (41, 7, 7),
        "energy": (41,), "left": (7,), "strike_time": (256,), "strike_speed": (256,),
        "strike_duration": (256,), "strike_bodies": (256, 2), "strike_point": (256, 3),
        "strike_normal": (256, 3), "strike_impulse": (256, 3), "touch": (STEPS, 3),
        "touch_tip": (STEPS, 3), "touch_hand": (STEPS, 3), "frames": (FRAMES, 30, 40, 3),
        "depth": (FRAMES, 30, 40), "masks": (FRAMES, 30, 40), "room_size": (3,),
        "room_source": (3,), "room_rt60": (8,), "tail_level": (LISTENERS,),
        "tail_join": (LISTENERS,)}


def slaney_mel(audio, bands, fft_size, hop, frames):
    """Mel power spectrogram as librosa defines it, of sound at 16 kHz, up to 8 kHz."""
    to_hz = lambda mel: mel * 200 / 3 if mel < 15 else 1000 * 6.4 ** ((mel - 15) / 27)
    top = 15 + 27 * numpy.log(8) / numpy.log(6.4)
    edges = [to_hz(mel) for mel in numpy.linspace(0, top, bands + 2)]
    bins = numpy.fft.rfftfreq(fft_size, 1 / 16000)
    filters = [2 / (high - low) * numpy.interp(bins, (low, middle, high), (0, 1, 0))
               for low, middle, high in zip(edges, edges[1:], edges[2:])]
    window = numpy.hanning(fft_size + 1)[:-1]
    padded = numpy.pad(audio, fft_size // 2)
    cut = numpy.stack([padded[k * hop:k * hop + fft_size] for k in range(frames)])
    return filters @ (abs(numpy.fft.rfft(window * cut)) ** 2).T


HANGING = """
objects: [{mesh: bar.msh, name: bar, materials: {left: steel, right: wood}}]
modes: {max_modes: 4, order: 1}
audio: {sample_rate: 22.05 kHz, seconds: 0.1 s}
motion:
  bodies: [{object: bar, at: [0, 0, 0.5 m]}]
  strings: [{body: bar, anchor: [0, 0, 1 m]}]
"""


class SceneColumns(MovingTest):
    def column(self, name):
        with h5py.File(self.whole / "index.h5") as index:
            return index[name][()]

    def casts(self):
        return [json.loads(text) for text in self.column("bodies")]

    def test_shapes_and_values_of_all_columns(self):
        self.assertEqual(self.summary["tasks_run"], SHAPES + SHARDS)
        with h5py.File(self.whole / "index.h5") as index:
            columns = {n: c[()] for n, c in index.items() if isinstance(c, h5py.Dataset)}
        self.assertEqual(columns["audio"].dtype, numpy.int16)
        for name, values in columns.items():
            self.assertEqual(values.shape, (SIMULATIONS, *ROWS.get(name, ())), name)
            if values.dtype.kind == "f" and name not in ("left", "too_fast_at"):
                unused = (numpy.arange(256) >= columns["strikes"][:, None]
                          if name.startswith("strike_") else numpy.array(False))
                finite = numpy.isfinite(values)
                numpy.testing.assert_array_equal(
                    finite, ~numpy.broadcast_to(unused.reshape(
                        unused.shape + (1,) * (values.ndim - unused.ndim)), values.shape), name)
        self.assertTrue(numpy.isnan(columns["left"]).all())
        self.assertTrue((columns["strikes"] > 0).all())
        self.assertLessEqual(set(columns["room"]), set(range(18)))

    def test_mel_is_that_of_each_listeners_sound(self):
        with h5py.File(self.whole / "index.h5") as index:
            stored, audio = index["mel"][()], index["audio"][()] / 32768
            options = {name: index["mel"].attrs[name] for name in ("fft_size", "hop")}
        for simulation in range(SIMULATIONS):
            for listener in range(LISTENERS):
                mel = slaney_mel(audio[simulation, listener], 16, frames=9, **options)
                # The column was made before rounding to 16 bits.
                numpy.testing.assert_allclose(stored[simulation, listener], mel, rtol=1e-3,
                                              atol=1e-4 * mel.max())

    def test_sound_files_hold_the_column(self):
        for simulation, audio in enumerate(self.column("audio")):
            with wave.open(str(self.whole / "sounds" / f"simulation-{simulation:04}.wav")) as file:
                self.assertEqual(file.getframerate(), 16000)
                stored = numpy.frombuffer(file.readframes(SAMPLES), "<i2")
            numpy.testing.assert_array_equal(stored.reshape(SAMPLES, LISTENERS).T, audio)

    def test_bodies_from_files_weigh_what_their_meshes_hold(self):
        materials = {m["name"]: m for m in run_json("list", "materials")}
        volume = {"top-top": 4 / 3 * 0.02 ** 3}
        for name, (length, lean) in BOXES.items():
            # A frustum's, by Simpson's rule, which is exact for it.
            sections = [(length - 2 * lean * z) * (1 - 2 * lean * z) for z in (0, 0.5, 1)]
            volume[f"crate-{name}"] = ((sections[0] + 4 * sections[1] + sections[2]) / 6
                                       * (0.05 / length) ** 3)
        drawn = set()
        for cast in self.casts():
            self.assertEqual([b["name"] for b in cast], BODIES)
            for body in cast[1:4]:
                density = materials[body["material"]]["density_kg_m3"]
                self.assertAlmostEqual(body["mass_kg"] / (density * volume[body["shape"]]), 1,
                                       delta=1e-6)
                drawn.add((body["name"], body["shape"], body["material"]))
        # Both files in both materials, for both of the objects that play them.
        self.assertLessEqual({shape for _, shape, _ in drawn}, set(volume))
        for body in ("crate", "other"):
            self.assertEqual(len({d[1] for d in drawn if d[0] == body}), 2)
            self.assertEqual(len({d[2] for d in drawn if d[0] == body}), 2)
        self.assertEqual({d[2] for d in drawn if d[0] == "top"}, {"glass", "wood"})

    def test_bodies_from_files_begin_where_they_are_put_and_are_seen(self):
        poses, masks = self.column("poses"), self.column("masks")
        for simulation, cast in enumerate(self.casts()):
            for number, place in ((1, (None, 0.04, 0.06)), (2, (0.06, None, 0.06))):
                # The files' corner at the origin is `at` less half the box.
                length = BOXES[cast[number]["shape"][-1]][0]
                half = numpy.array([length, 1, 1]) / 2 * 0.05 / length
                centre = poses[simulation, 0, number, :3] + half
                for axis, wanted in enumerate(place):
                    if wanted is not None:
                        self.assertAlmostEqual(centre[axis], wanted, delta=1e-9)
            self.assertLessEqual({1, 2, 3, 4}, set(numpy.unique(masks[simulation, 0])))
        self.assertEqual(set(numpy.unique(masks)), set(range(8)))

    def test_physical_groups_have_their_materials(self):
        (self.folder / "bar.msh").write_text(msh_files.msh_4(*msh_files.two_part_bar()))
        config, output = self.write("hanging.yaml", HANGING), self.folder / "hanging"
        run_json("build", config, "-o", output)
        with h5py.File(output / "index.h5") as index:
            body = json.loads(index["bodies"][0])[0]
            poses = index["poses"][0, :, 0]
        self.assertEqual(body["material"], "left=steel,right=wood")
        densities = {m["name"]: m["density_kg_m3"] for m in run_json("list", "materials")}
        self.assertAlmostEqual(body["mass_kg"], 0.1 * 0.02 ** 2 * (densities["steel"] +
                                                                   densities["wood"]), delta=1e-9)
        # Held by its middle it tips to the side of steel: about y, with the left end down.
        turn = 2 * poses[-1, 5]
        self.assertLess(turn, -0.02)
        self.assertLess(abs(poses[-1, [4, 6]]).max(), 1e-6)
        result = run("plan", config, "--set", "motion.bodies[0].materials=steel")
        self.assertEqual(result.returncode, 2)
        self.assertIn("leave this out", result.stderr)

    def test_the_string_holds_the_chime_and_the_ball_strikes(self):
        strikes = self.column("strike_bodies")
        names = [b["name"] for b in self.casts()[0]]
        chime, ball = names.index("chime"), names.index("ball")
        # Without strings it would fall 0.08 m in 0.13 s.
        self.assertTrue((self.column("poses")[:, :, chime, 2] > 0.06).all())
        self.assertTrue(any([chime, ball] in simulation.tolist() for simulation in strikes))

    def test_the_trace_has_what_the_plan_says_and_nothing_else(self):
        plan = run_json("plan", self.config)
        on = {e["name"] for e in plan["effects"] if e["enabled"]}
        self.assertEqual(on, {"damping", "supports", "radiation", "click", "room", "tail", "recording", "noise",
                              "motion", "lasting_contacts", "contact_damping", "touch", "movie",
                              "mel"})
        trace = json.loads((self.whole / "trace.json").read_text())
        self.assertEqual({name for name, e in trace["effects"].items() if e["calls"] > 0}, on)
        for name in ("motion", "touch", "movie", "noise", "room", "tail", "mel"):
            self.assertEqual(trace["effects"][name]["calls"], SIMULATIONS, name)

    def test_check_passes(self):
        report = run_json("check", self.whole)
        self.assertTrue(report["passed"])
        notes = {c["name"] for c in report["checks"] if c["verdict"] == "note"}
        self.assertEqual(notes, {"publication", "pitches"})  # the configuration says nothing of who made it

    def test_every_simulation_comes_again(self):
        simulations = [word for simulation in range(SIMULATIONS) for word in ("--sample", simulation)]
        report = run_json("regenerate", self.whole, *simulations)
        self.assertEqual([s["identical"] for s in report["samples"]], SIMULATIONS * [True])

    def test_a_simulation_with_one_thing_changed_tells_how_far_its_strikes_differ(self):
        report = run_json("regenerate", self.whole, "--sample", 1, "--set",
                          "motion.bodies[5].restitution=0.9")
        levels = {d["column"]: d.get("difference_db") for d in report["samples"][0]["differences"]}
        # Rows beyond the last strike are NaN.
        for column in ("poses", "strike_time", "strike_point", "strike_impulse", "audio"):
            self.assertIsInstance(levels[column], float, column)
        for column in ("room_size", "noise_source", "touch"):
            self.assertNotIn(column, levels)

    def test_a_preview_is_the_simulation_of_the_build(self):
        output = self.folder / "preview"
        result = run("preview", self.config, "--sample", "simulation-0006", "-o", output)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"simulation-0006: {self.column('strikes')[6]} strikes", result.stdout)
        movies = sorted(path.relative_to(output) for path in output.glob("movies/**/*.*"))
        self.assertTrue(movies)
        for movie in movies:
            self.assertEqual((output / movie).read_bytes(), (self.whole / movie).read_bytes())
        # Its WAV file holds floats.
        sound = numpy.frombuffer((output / "sound.wav").read_bytes()[-4 * LISTENERS * SAMPLES:],
                                 "<f4").reshape(SAMPLES, LISTENERS).T
        numpy.testing.assert_array_equal(numpy.rint(32768 * sound), self.column("audio")[6])

    def test_two_ranks_write_the_same_bytes(self):
        output = self.folder / "ranks"
        run_json("--cache", "", "build", self.config, "-o", output, ranks=2)
        self.assertEqual(hashes(output), hashes(self.whole))


if __name__ == "__main__":
    unittest.main()
