"""One map, all modalities: a joint between bricks is at the same place in the picture, in the ball's way,
in the sound and under the stylus, within one texel and one step of the motion.

With CARILLON_FIGURE=file.png in the environment it is drawn, too (docs/scenes.md)."""
import os
import unittest

import h5py
import numpy
from program import FolderTest, run_json

DEPTH, RADIUS, STEP = 3e-3, 15e-3, 1e-3
TEXEL = 2 * (0.1075 + 0.010) / 512  # the map is two bricks with their joints wide
CONFIG = """
name: consistency
seed: 1
objects:
  - {shape: tile, name: floor, materials: [ceramic],
     parameters: {length: 430 mm, width: 130 mm, thickness: 30 mm}}
  - {shape: sphere, name: ball, materials: [steel], parameters: {radius: 15 mm}}
modes: {max_modes: 20, order: 2, element_size: 20 mm}
audio: {sample_rate: 44.1 kHz, seconds: 0.9 s}
listeners: [{position: [0, -0.4 m, 0.4 m]}]
motion:
  state_rate: 1 kHz
  bodies:
    - object: floor
      fixed: true
      at: [0, 0, -15 mm]
      friction: 0.7
      restitution: 0.1
      texture:
        map: brick
        parameters: {length: 107.5 mm, height: 65 mm, mortar: 10 mm, mortar_depth: 3 mm,
                     rounding: 0 mm, unevenness: 0 mm}
    - object: ball
      at: [-200 mm, -32.5 mm, 15 mm]
      velocity: [0.5 m/s, 0, 0]
      spin: [0, 33.3, 0]
      friction: 0.7
      restitution: 0.1
  stylus:
    body: floor
    path: [{u: 100 mm, v: 32.5 mm}, {u: 140 mm, v: 32.5 mm}]
    speed: 0.05 m/s
    radius: 0.5 mm
  camera: {eye: [0, -0.03251 m, 1 m], target: [0, -0.0325 m, 0], field_of_view: 3 deg,
           width: 1024, height: 124, rate: 1 Hz}
split: {validation: 0, test: 0}
"""
LISTENER = numpy.array([0, -0.4, 0.4])


class Consistency(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        config = cls.folder / "consistency.yaml"
        config.write_text(CONFIG)
        run_json("build", config, "-o", cls.folder / "out")
        with h5py.File(cls.folder / "out" / "index.h5") as index:
            cls.frame = index["frames"][0, 0]
            cls.depth = index["depth"][0, 0]
            cls.ball = index["poses"][0][:, 1, :3]
            times = index["strike_time"][0]
            there = ~numpy.isnan(times)
            cls.times = times[there]
            cls.points = index["strike_point"][0][there]
            cls.speeds = index["strike_speed"][0][there]
            cls.tip = index["touch_tip"][0]
            cls.force = index["touch"][0]
            cls.audio = index["audio"][0]
        cls.columns, cls.edges = cls.edges_in_the_picture()
        # The ball falls into each joint and strikes its far edge; weaker strikes are its hops.
        cls.hits = [k for k in range(len(cls.times)) if cls.speeds[k] > 0.15]

    @classmethod
    def edges_in_the_picture(cls):
        """Where the depth picture steps by half a joint, along the ball's line [m]."""
        rows, columns = cls.depth.shape
        pixel = 2 * numpy.tan(numpy.radians(1.5)) / rows
        x = (numpy.arange(columns) - (columns - 1) / 2) * pixel
        line = cls.depth[rows // 2]
        low = line - numpy.median(line) > DEPTH / 2
        steps = numpy.flatnonzero(low[1:] != low[:-1])
        return x, (x[steps] + x[steps + 1]) / 2

    def near(self, place, edge, speed):
        self.assertLess(abs(place - edge), TEXEL + speed * STEP,
                        f"{1e3 * place:.2f} mm, the edge is at {1e3 * edge:.2f} mm")

    def test_the_picture_has_the_joints_of_the_map(self):
        self.assertEqual(len(self.edges), 6)
        widths = self.edges[1::2] - self.edges[::2]
        self.assertTrue((abs(widths - 0.010) < 2 * TEXEL).all(), widths)  # of two edges
        self.assertTrue((abs(numpy.diff(self.edges[::2]) - 0.1175) < 2 * TEXEL).all())

    def test_the_ball_dips_at_the_near_edges(self):
        self.assertEqual(len(self.hits), 3)
        for hit, edge in zip(self.hits, self.edges[::2]):
            k = int(self.times[hit] / STEP)
            while self.ball[k, 2] < RADIUS - 5e-6:
                k -= 1
            self.near(self.ball[k, 0], edge, 0.5)

    def test_it_strikes_at_the_far_edges(self):
        for hit, edge in zip(self.hits, self.edges[1::2]):
            self.near(self.points[hit, 0], edge, 0.5)

    def test_the_sound_begins_with_the_strikes(self):
        for hit in self.hits:
            flight = numpy.linalg.norm(self.points[hit] - LISTENER) / 343
            first = int((self.times[hit] - 4e-3 + flight) * 44100)
            before = abs(self.audio[first - 200:first]).max()
            heard = abs(self.audio[first:first + 400])
            onset = numpy.flatnonzero(heard > 3 * before + 1e-4 * abs(self.audio).max())[0]
            self.assertLess(abs((first + onset) / 44100 - self.times[hit] - flight), STEP)

    def test_the_stylus_falls_and_is_pushed_at_the_edges(self):
        low = self.tip[:, 2] < -DEPTH / 2
        steps = numpy.flatnonzero(low[1:] != low[:-1])
        self.assertEqual(len(steps), 2)
        for step, edge in zip(steps, self.edges[:2]):
            self.near(self.tip[step, 0], edge, 0.05)
        # Nothing bears it as it falls in, and the far side pushes it back as it climbs out.
        pressed = self.force[:, 2] > 0
        lost = 20 + numpy.flatnonzero(pressed[20:-1] & ~pressed[21:])[0]
        # A tip of 0.5 mm leaves the near edge half a millimetre behind it.
        self.near(self.tip[lost, 0] - 0.5e-3, self.edges[0], 0.05)
        push = int(numpy.argmin(self.force[20:, 0])) + 20
        self.near(self.tip[push, 0], self.edges[1], 0.05)

    def test_figure(self):
        name = os.environ.get("CARILLON_FIGURE")
        if not name:
            self.skipTest("CARILLON_FIGURE=file.png draws it")
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(4, 1, figsize=(11, 7), sharex=True)
        x = 1e3 * self.columns
        rows = len(self.frame) // 2 * (x[1] - x[0])
        axes[0].imshow(self.frame, aspect="auto", extent=(x[0], x[-1], -32.5 - rows, -32.5 + rows))
        axes[0].axhline(-32.5, color="black", linewidth=0.5, linestyle=":")
        axes[0].set_ylabel("picture\n[mm]")
        axes[1].plot(1e3 * self.ball[:, 0], 1e3 * (self.ball[:, 2] - RADIUS))
        axes[1].set_ylabel("ball's way\n[mm]")
        delay = 0.57 / 343  # about
        ball_x = numpy.interp(numpy.arange(len(self.audio)) / 44100 - delay,
                              STEP * numpy.arange(len(self.ball)), self.ball[:, 0])
        axes[2].plot(1e3 * ball_x, self.audio, linewidth=0.5)
        axes[2].set_ylabel("sound, by the\nball's place [Pa]")
        axes[3].plot(1e3 * self.tip[:, 0], 1e3 * self.tip[:, 2], label="tip [mm]")
        axes[3].plot(1e3 * self.tip[:, 0], self.force[:, 0], linewidth=0.8, label="force along x [N]")
        axes[3].set_ylabel("stylus")
        axes[3].legend(loc="lower right", fontsize=8)
        axes[3].set_xlabel("x [mm]")
        for axis in axes:
            for edge in self.edges:
                axis.axvline(1e3 * edge, color="0.5", linewidth=0.6)
        axes[0].set_xlim(-205, 205)
        figure.tight_layout()
        figure.savefig(name, dpi=80)


if __name__ == "__main__":
    unittest.main()
