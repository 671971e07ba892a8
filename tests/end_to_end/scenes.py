"""Scenes that move, as datasets: simulations, their columns, and what the trace says of them."""
import json
import math
import unittest

import h5py
import numpy
from program import FolderTest, run, run_json

CONFIG = """
name: scene
seed: 3
objects:
  - {shape: tile, name: box, materials: [wood, ceramic],
     parameters: {length: 160 mm, width: 120 mm, thickness: 8 mm}}
  - {shape: sphere, name: ball, materials: [steel], parameters: {radius: 10 mm}}
modes: {max_modes: 12, order: 2, element_size: 15 mm}
audio: {sample_rate: 22.05 kHz, seconds: 0.8 s}
listeners: [{position: [0.2 m, -0.5 m, 0.3 m]}]
motion:
  simulations: 5
  ground: {material: wood, restitution: 0.5}
  bodies:
    - {object: box, at: [0, 0, 4 mm], friction: 0.6}
    - object: ball
      at: [[-5 mm, 5 mm], 0, [0.25 m, 0.35 m]]
      velocity: [0.1 m/s, 0, 0]
      restitution: 0.4
  camera: {width: 48, height: 32, rate: 10 Hz, eye: [0.4 m, -0.5 m, 0.3 m], target: [0, 0, 0.12 m]}
split: {validation: 0.2, test: 0.2}
"""
GRAVITY = 9.80665


class Scenes(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "scene.yaml"
        cls.config.write_text(CONFIG)
        cls.output = cls.folder / "scene"
        cls.summary = run_json("build", cls.config, "-o", cls.output)

    def index(self):
        return h5py.File(self.output / "index.h5")

    def test_the_ball_falls_and_strikes_as_galileo_has_it(self):
        with self.index() as index:
            self.assertEqual(index["audio"].shape, (5, 17640))
            for simulation in range(5):
                bodies = json.loads(index["bodies"][simulation])
                self.assertEqual([b["name"] for b in bodies], ["ground", "box", "ball"])
                self.assertIn(bodies[1]["material"], ("wood", "ceramic"))
                start = index["poses"][simulation, 0, 2, 2]
                height = start - 0.01 - 0.008  # of its lowest point over the box
                times = index["strike_time"][simulation]
                pairs = index["strike_bodies"][simulation]
                first = int(numpy.nanargmin(times))
                self.assertEqual(list(pairs[first]), [1, 2])
                self.assertAlmostEqual(times[first], math.sqrt(2 * height / GRAVITY), delta=1e-3)
                self.assertAlmostEqual(index["strike_speed"][simulation, first],
                                       math.sqrt(2 * GRAVITY * height), delta=0.01)
                # Nothing is heard before sound can have come from there (but for what
                # interpolation rings ahead, 0.3 % of the peak).
                audio = index["audio"][simulation]
                heard = numpy.flatnonzero(abs(audio) > 0.01 * abs(audio).max())[0] / 22050
                flight = numpy.linalg.norm(index["strike_point"][simulation, first] -
                                           [0.2, -0.5, 0.3]) / 343
                self.assertGreater(heard, times[first] + flight - 3e-4)
                self.assertLess(heard, times[first] + flight + 2e-3)

    def test_simulations_differ_and_energy_never_grows(self):
        with self.index() as index:
            starts = index["poses"][:, 0, 2, 2]
            self.assertEqual(len(set(starts)), 5)
            self.assertTrue(((starts >= 0.25) & (starts <= 0.35)).all())
            energy = index["energy"][()]
            self.assertTrue((energy.max(1) <= 1.01 * energy[:, 0]).all())

    def test_frames_depth_and_masks_agree(self):
        with self.index() as index:
            self.assertEqual(index["frames"].shape, (5, 9, 32, 48, 3))
            masks, depth = index["masks"][()], index["depth"][()]
            self.assertEqual(set(numpy.unique(masks)), {0, 1, 2})
            # The ball falls: lower in the picture, and the box stays where it is.
            rows = [numpy.nonzero(masks[0, k] == 2)[0].mean() for k in (0, 2)]
            self.assertGreater(rows[1], rows[0] + 2)
            self.assertTrue((depth[masks > 0] > 0.2).all())
            self.assertTrue((depth[masks > 0] < 1).all())

    def test_the_trace_has_what_the_plan_says_and_nothing_else(self):
        plan = run_json("plan", self.config)
        on = {e["name"] for e in plan["effects"] if e["enabled"]}
        trace = json.loads((self.output / "trace.json").read_text())
        self.assertEqual({name for name, e in trace["effects"].items() if e["calls"] > 0}, on)
        self.assertEqual(on, {"damping", "radiation", "click", "motion", "lasting_contacts",
                              "contact_damping", "movie"})
        self.assertEqual(trace["effects"]["motion"]["calls"], 5)
        reasons = {e["name"]: e["reason"] for e in plan["effects"]}
        self.assertIn("motion", reasons["striker"])

    def test_what_is_off_does_not_run(self):
        output = self.folder / "off"
        run_json("build", self.config, "-o", output, "--set", "effects.movie=off",
                 "--set", "effects.lasting_contacts=off", "--set", "effects.click=off")
        trace = json.loads((output / "trace.json").read_text())
        for name in ("movie", "lasting_contacts", "click"):
            self.assertNotIn(name, trace["effects"])
        with h5py.File(output / "index.h5") as index:
            self.assertNotIn("frames", index)

    def test_ranks_change_nothing(self):
        output = self.folder / "ranks"
        run_json("build", self.config, "-o", output, ranks=2)
        with self.index() as one, h5py.File(output / "index.h5") as two:
            for name in ("audio", "poses", "frames", "strike_impulse"):
                numpy.testing.assert_array_equal(one[name][()], two[name][()])

    def test_check_passes_and_simulations_come_again(self):
        self.assertEqual(run("check", self.output).returncode, 0)
        report = run_json("regenerate", self.output, "--sample", "3", "--sample", "simulation-0001")
        self.assertTrue(all(s["identical"] for s in report["samples"]))

    def test_more_simulations_leave_the_others_alone(self):
        output = self.folder / "grown"
        run_json("build", self.config, "-o", output, "--set", "motion.simulations=2")
        run_json("build", self.config, "-o", output)
        with self.index() as whole, h5py.File(output / "index.h5") as grown:
            numpy.testing.assert_array_equal(whole["audio"][()], grown["audio"][()])

    def test_preview_shows_one_simulation(self):
        output = self.folder / "preview"
        run_json("preview", self.config, "--sample", "simulation-0002", "-o", output)
        self.assertTrue((output / "sound.wav").is_file())
        self.assertTrue(list(output.glob("movies/simulation-0002*")))

    def test_an_image_is_the_map_it_was_made_from(self):
        parameters = {"size": 0.01, "depth": 0.001}
        image = self.folder / "pebbles.png"
        made = run_json("texture", "pebbles", "--seed", 3, "-o", image,
                        *[w for k, v in parameters.items() for w in ("--set", f"{k}={v}")])
        self.assertAlmostEqual(made["depth_m"], 0.001, delta=2e-4)
        ground = self.folder / "ground.yaml"
        ground.write_text(CONFIG.replace("ground: {material: wood, restitution: 0.5}", """ground:
    restitution: 0.5
    texture: TEXTURE""").replace("simulations: 5", "simulations: 1").replace(
            "at: [0, 0, 4 mm]", "fixed: true, at: [0.5 m, 0, 4 mm]"))  # out of the ball's way
        ends = []
        for name, texture in (
                ("map", f"{{map: pebbles, parameters: {json.dumps(parameters)}}}"),
                ("image", f"{{image: {image}, image_width: {made['width_m']}, "
                          f"depth: {made['depth_m']}}}"),
                ("none", "{map: pebbles, parameters: {depth: 1e-9}}")):
            config = self.folder / f"{name}.yaml"
            config.write_text(ground.read_text().replace("TEXTURE", texture))
            run_json("build", config, "-o", self.folder / name)
            with h5py.File(self.folder / name / "index.h5") as index:
                ends.append(index["poses"][0, :30, 2, :3])  # of the ball, to its first rebound
        numpy.testing.assert_allclose(ends[0], ends[1], atol=1e-4)
        # The dataset keeps its image; another one under the same name is another dataset.
        image.unlink()
        checked = run("check", self.folder / "image")
        self.assertEqual(checked.returncode, 0, checked.stderr + checked.stdout)
        self.assertEqual(run("regenerate", self.folder / "image", "--sample", 0).returncode, 0)
        run_json("texture", "pebbles", "--seed", 4, "-o", image, "--set", "size=10mm", "--set",
                 "depth=1mm")
        again = run("build", self.folder / "image.yaml", "-o", self.folder / "image")
        self.assertNotIn("nothing to do", again.stdout + again.stderr)
        # It is thrown another way than by a flat ground.
        self.assertGreater(abs(ends[0][-1] - ends[2][-1]).max(), 1e-3)

    def refused(self, *settings):
        words = [word for setting in settings for word in ("--set", setting)]
        result = run("plan", self.config, *words)
        self.assertEqual(result.returncode, 2)
        return result.stderr

    def test_slips_are_named(self):
        self.assertIn("ball", self.refused("motion.bodies[1].object=bal"))
        self.assertIn("not made of", self.refused("motion.bodies[1].materials=glass"))
        self.assertIn("brick", self.refused("motion.ground.texture.map=brik"))
        self.assertIn("goes with objects that are struck", self.refused("strikes.per_object=3"))
        self.assertIn("equivalent_sources", self.refused("radiation.model=monopole"))
        self.assertIn("restitution", self.refused("motion.bodies[0].restitution=2"))


if __name__ == "__main__":
    unittest.main()
