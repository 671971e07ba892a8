"""One normal map, all modalities: nothing is deep there, and yet picture, ball, sound and stylus have the
joints of the bricks where the relief of the same bricks has them, within one texel and one step."""
import unittest

import h5py
import numpy
from consistency import CONFIG, DEPTH, LISTENER, RADIUS, STEP, TEXEL
from program import FolderTest, run_json

RATE, PRESS, STYLUS_SPEED = 44100, 1.0, 0.05
# Wood falls silent from one joint to the next, and with no roughness the map alone drives it.
NORMALS = CONFIG.replace("materials: [ceramic]", "materials: [wood]").replace(
    "map: brick", "map: brick\n        as: normals").replace(
        "motion:", "motion:\n  lasting_contacts: {roughness: 0}", 1)


def across(frames):
    """Places along the picture's columns [m]."""
    rows, columns = frames.shape[:2]
    return (numpy.arange(columns) - (columns - 1) / 2) * 2 * numpy.tan(numpy.radians(1.5)) / rows


class ConsistencyOfNormals(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.edges = cls.edges_of_the_relief()
        with cls.build("normals") as index:
            cls.frame, cls.depth = index["frames"][0, 0].astype(int), index["depth"][0, 0]
            cls.ball = index["poses"][0][:, 1, :3]
            cls.velocity = numpy.diff(cls.ball, axis=0) / STEP
            cls.times, cls.points = index["strike_time"][0], index["strike_point"][0]
            cls.tip, cls.force = index["touch_tip"][0], index["touch"][0]
            audio = index["audio"][0].astype(float)
        with cls.build("strikes", "effects.lasting_contacts=off") as index:
            cls.strikes = index["audio"][0].astype(float)
        cls.lasting = audio - cls.strikes
        cls.lines = cls.lines_of_the_picture()

    @classmethod
    def build(cls, name, *settings):
        config = cls.folder / f"{name}.yaml"
        config.write_text(NORMALS)
        words = [word for setting in settings for word in ("--set", setting)]
        run_json("build", config, "-o", cls.folder / name, *words)
        return h5py.File(cls.folder / name / "index.h5")

    @classmethod
    def edges_of_the_relief(cls):
        """Where the same bricks, as a relief, step down and up in the depth picture [m]."""
        with cls.build("relief", "motion.bodies[0].texture.as=relief", "audio.seconds=0.05") as index:
            depth = index["depth"][0, 0]
        x, line = across(depth), depth[depth.shape[0] // 2]
        low = line - numpy.median(line) > DEPTH / 2
        steps = numpy.flatnonzero(low[1:] != low[:-1])
        return (x[steps] + x[steps + 1]) / 2

    @classmethod
    def lines_of_the_picture(cls):
        """Where the shading of the bricks is another than most: begin, end [m] and whether it is
        darker, along a row of pixels that neither ball nor stylus stand in."""
        x, row = across(cls.frame), cls.frame[110]
        deviation = row - numpy.median(row, axis=0)
        there = numpy.flatnonzero((abs(deviation).max(1) > 6) & (abs(x) < 0.2))
        groups = numpy.split(there, numpy.flatnonzero(numpy.diff(x[there]) > 2.5e-3) + 1)
        return [(x[g[0]], x[g[-1]], deviation[g].sum() < 0) for g in groups]

    def assert_in(self, line, place, speed):
        begin, end, _ = line
        reach = TEXEL + speed * STEP
        self.assertTrue(begin - reach < place < end + reach,
                        f"{1e3 * place:.2f} mm, the line is {1e3 * begin:.2f} to {1e3 * end:.2f}")

    def step_of(self, place):
        """The step at which the ball's centre passes a place."""
        return int(numpy.flatnonzero(self.ball[:, 0] > place)[0])

    def test_the_picture_has_a_line_at_each_edge_and_no_depth(self):
        self.assertEqual(len(self.edges), 6)
        self.assertEqual(len(self.lines), 6)
        for (begin, end, _), edge in zip(self.lines, self.edges):
            self.assertLess(abs((begin + end) / 2 - edge), TEXEL)
        # Near edges lean away from the light, far ones towards it.
        self.assertEqual([dark for _, _, dark in self.lines], 3 * [True, False])
        bricks = self.depth[110][abs(across(self.depth)) < 0.2]
        self.assertLess(bricks.max() - bricks.min(), 1e-5)

    def test_the_ball_loses_its_support_at_near_edges(self):
        for line in self.lines[::2]:
            k = self.step_of(line[0] - 5e-3)
            self.assertAlmostEqual(self.ball[k, 2], RADIUS, delta=1e-6)
            while self.ball[k, 2] > RADIUS - 5e-6:
                k += 1
            self.assert_in(line, self.ball[k, 0], 0.5)
        # It falls as long as it is over the slope, 4 ms, and no joint takes it in.
        self.assertGreater(self.ball[:self.step_of(0.15), 2].min(), RADIUS - DEPTH / 20)

    def test_the_ball_is_thrown_up_and_back_at_far_edges(self):
        change = numpy.diff(self.velocity, axis=0)
        for line in self.lines[1::2]:
            k = self.step_of(line[0] - 5e-3)
            while change[k, 2] < 0.02:
                k += 1
            self.assertLess(change[k, 0], -1e-3)
            self.assert_in(line, self.ball[k + 1, 0], 0.5)

    def test_strikes_sound_where_near_edges_end(self):
        for line in self.lines[::2]:
            step = self.step_of(line[0] - 5e-3)
            hit = int(numpy.flatnonzero(self.times > step * STEP)[0])
            self.assert_in(line, self.points[hit, 0], 0.5)
            flight = numpy.linalg.norm(self.points[hit] - LISTENER) / 343
            first = int((self.times[hit] - 4e-3 + flight) * RATE)
            before = abs(self.strikes[first - 200:first]).max()
            heard = abs(self.strikes[first:first + 400])
            onset = numpy.flatnonzero(heard > 3 * before + 1e-2 * heard.max())[0]
            self.assertLess(abs((first + onset) / RATE - self.times[hit] - flight), STEP)

    def test_the_map_sounds_where_the_ball_meets_the_far_edge(self):
        # A ball of more than half a joint's width leaves one edge for the other in the middle.
        for near, far in zip(self.lines[::2], self.lines[1::2]):
            middle = (near[0] + near[1] + far[0] + far[1]) / 4
            flight = numpy.linalg.norm([middle - LISTENER[0], *(self.ball[0, 1:] - LISTENER[1:])]) / 343
            begin, end = (int((STEP * self.step_of(place) + flight) * RATE)
                          for place in (near[0] - 5e-3, far[0]))
            heard = abs(self.lasting[begin:end])
            onset = (begin + numpy.flatnonzero(heard > heard.max() / 3)[0]) / RATE - flight
            place = numpy.interp(onset, STEP * numpy.arange(len(self.ball)), self.ball[:, 0])
            self.assertLess(abs(place - middle), TEXEL + 0.5 * STEP)

    def test_the_stylus_is_pushed_along_the_slopes_alone(self):
        settled = numpy.arange(len(self.tip)) > 20
        for line, sign in zip(self.lines[:2], (1, -1)):
            pushed = numpy.flatnonzero(settled & (sign * self.force[:, 0] > 0.05 * PRESS))
            self.assert_in(line, self.tip[pushed[0], 0], STYLUS_SPEED)
            self.assert_in(line, self.tip[pushed[-1], 0], STYLUS_SPEED)
            # The force is slope times press: along the way it adds up to the height that is not there.
            way = numpy.gradient(self.tip[:, 0])
            height = (self.force[pushed, 0] * way[pushed]).sum() / PRESS
            self.assertAlmostEqual(height, sign * DEPTH, delta=0.1 * DEPTH)


if __name__ == "__main__":
    unittest.main()
