"""What `report` asks of the objects to strike: they sound as the dataset does."""
import base64
import re

import numpy
from browser import click, needs_browser

# Materials of its own that the dataset needs.
OWN = {"hard": {"youngs_modulus": 200e9, "density": 7800, "alphas": [5, 1e-7]},
       "soft": {"youngs_modulus": 90e9, "density": 2700, "alphas": [12, 4e-7]}}
# c = alpha1 + alpha2 lambda^alpha3, of an object with more modes than others.
SLACK = {"alpha1": 20, "alpha2": 2e-4, "alpha3": 0.6}


def mode_levels(clip, rate, frequencies):
    """Level of the spectrum [dB] at each mode's frequency: Blackman and Harris's window over the 50 ms that
    follow the first millisecond."""
    first, count = int(0.001 * rate), int(0.05 * rate)
    turns = 2 * numpy.pi * numpy.arange(count) / count
    window = sum(a * numpy.cos(k * turns) for k, a in enumerate((0.35875, -0.48829, 0.14128, -0.01168)))
    waves = numpy.exp(-2j * numpy.pi * numpy.outer(frequencies, numpy.arange(count)) / rate)
    return 20 * numpy.log10(abs(waves @ (window * clip[first:first + count])) + 1e-30)


def own_decay_rates(body, eigenvalues):
    """Of an object of the gallery, by the configuration's formulas."""
    if body["material"] == "slack":
        return (SLACK["alpha1"] + SLACK["alpha2"] * eigenvalues ** SLACK["alpha3"]) / 2
    alpha1, alpha2 = body["rayleigh"]
    return (alpha1 + alpha2 * eigenvalues) / 2


def strongest(levels, count):
    """Of as many modes at the most: further down there is what rounds in single precision."""
    order = numpy.argsort(-levels)[:count]
    return order[levels[order] > levels.max() - 80]


class Gallery:
    """Tests of a page that self.open() shows and self.js() asks; self.report and self.index are what it was
    made of."""

    @needs_browser
    def test_an_object_struck_in_the_page_sounds_as_in_the_dataset(self):
        self.open()
        keys = self.index["key"].asstr()[:]
        objects = self.report["gallery"]["objects"]
        self.assertEqual(len(objects), 6)
        counts, errors, compared = [], [], 0
        for number, body in enumerate(objects):
            eigenvalues = numpy.frombuffer(base64.b64decode(body["eigenvalues"]))
            decay = own_decay_rates(body, eigenvalues)
            ring = numpy.sqrt(eigenvalues - decay**2) / 2 / numpy.pi
            counts.append(len(ring))
            prefix = f"{body['object']}/{body['material']}/{body['size']:g}/"
            for row in [i for i, key in enumerate(keys) if key.startswith(prefix)]:
                stored, made = self.stored_and_struck(number, row)
                self.assertEqual(len(made), len(stored))
                level = mode_levels(stored, 44100, ring)
                found = mode_levels(made, 44100, ring)
                which = strongest(level, 20)
                compared += len(which)
                numpy.testing.assert_allclose(found[which], level[which], atol=1, err_msg=keys[row])
                # The strongest, which a listener hears first, is far closer.
                numpy.testing.assert_allclose(found[which[0]], level[which[0]], atol=0.2)
                errors.append(numpy.linalg.norm(made - stored) / numpy.linalg.norm(stored))
                self.assertLess(errors[-1], 0.02, keys[row])
        self.assertGreater(max(counts), 64)
        self.assertGreater(compared, 8 * len(errors))
        self.assertLess(numpy.median(errors), 0.001)

    def stored_and_struck(self, number, row, material=None, factor=1):
        """A sample of the dataset, and what an object, of another material and size, makes of its strike."""
        strike = {"object": number, "material": material, "size": factor,
                "position": [float(x) / factor for x in self.index["position"][row]],
                "impulse": float(self.index["impulse"][row]),
                "duration": float(self.index["contact_time"][row]), "sampleRate": 44100, "seconds": 0.5}
        made = self.js("return window.carillon.strike(arguments[0])", strike)
        return self.index["audio"][row].astype(float), numpy.array(made)

    @needs_browser
    def test_an_object_of_another_material_and_size_sounds_as_that_one_in_the_dataset(self):
        self.open()
        keys = self.index["key"].asstr()[:]
        objects = list(enumerate(self.report["gallery"]["objects"]))
        for shape, names in (("disc", OWN), ("plate", ["slack"])):
            number, body = next(one for one in objects if one[1]["object"].startswith(shape))
            others = [(name, size) for name in names for size in (1, 1.25)]
            others.remove((body["material"], body["size"]))
            self.assertEqual(len(others), 2 * len(names) - 1)
            for name, size in others:
                prefix = f"{body['object']}/{name}/{size:g}/"
                self.expect_alike(number, OWN.get(name), size / body["size"],
                                  [i for i, key in enumerate(keys) if key.startswith(prefix)])

    def expect_alike(self, number, material, factor, rows):
        """The whole waveform: frequencies, decay rates, levels and signs of all modes."""
        self.assertGreater(len(rows), 0)
        for row in rows:
            stored, made = self.stored_and_struck(number, row, material, factor)
            error = numpy.linalg.norm(made - stored) / numpy.linalg.norm(stored)
            self.assertLess(error, 0.02, self.index["key"].asstr()[row])

    @needs_browser
    def test_a_click_strikes_and_sliders_change_the_sound(self):
        self.open()
        self.js("document.querySelector('#gallery').scrollIntoView({behavior: 'instant'})")
        message = "return document.querySelector('.desk [aria-live]').textContent"
        self.assertIn("Not struck yet", self.js(message))
        canvas = self.driver.find_element("css selector", ".viewer canvas")
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", canvas)
        click(self.driver, canvas)
        struck = self.js(message)
        self.assertRegex(struck, r"Struck at \(.*\) mm: peak [0-9.]+ m/s")
        bars = self.js("return document.querySelectorAll('.desk .chart svg line').length")
        self.assertGreater(bars, 3)
        # Twice the impulse at the same place: twice the velocity.
        peak = float(re.search(r"peak ([0-9.]+)", struck).group(1))
        self.js("""
            const slider = [...document.querySelectorAll('.controls label')]
              .find((label) => label.textContent.startsWith('Impulse')).querySelector('input');
            slider.value = Math.log(0.04 / 1e-3) / Math.log(1e3);
            slider.dispatchEvent(new Event('input')); slider.dispatchEvent(new Event('change'));""")
        louder = float(re.search(r"peak ([0-9.]+)", self.js(message)).group(1))
        self.assertAlmostEqual(louder / peak, 2, 1)

    def move(self, label, fraction):
        """A slider to a fraction of its way."""
        self.js("""
            const slider = [...document.querySelectorAll('.controls label')]
              .find((one) => one.textContent.startsWith(arguments[0])).querySelector('input');
            slider.value = arguments[1];
            slider.dispatchEvent(new Event('input')); slider.dispatchEvent(new Event('change'));""",
                label, fraction)

    @needs_browser
    def test_what_the_browser_plays_is_what_was_set(self):
        self.open()
        self.js("""
            window.played = [];
            const start = AudioBufferSourceNode.prototype.start;
            AudioBufferSourceNode.prototype.start = function (...when) {
              window.played.push([this.buffer.sampleRate, Array.from(this.buffer.getChannelData(0))]);
              return start.apply(this, when);
            };""")
        select = "const menu = document.querySelector(arguments[0]); menu.value = arguments[1]; menu.onchange();"
        objects = self.report["gallery"]["objects"]
        disc = next(i for i, one in enumerate(objects) if one["object"].startswith("disc"))
        plate = next(i for i, one in enumerate(objects) if one["object"].startswith("plate"))
        presets = self.report["gallery"]["materials"]
        settings = [
            (disc, lambda: None),
            (disc, lambda: (self.move("Size", 0.7), self.move("Damping α₁", 0.6), self.move("Stiffness", 0.4))),
            (disc, lambda: self.js(select, ".controls select", "0")),
            (plate, lambda: (self.move("Damping", 0.7), self.move("Density", 0.6))),
            (plate, lambda: self.js(select, ".controls select", "1")),
        ]
        volumes = []
        for number, change in settings:
            self.js(select, ".desk select", str(number))
            self.js("[...document.querySelectorAll('.desk .buttons button')].find((one) => one.textContent === 'Strike anywhere').click()")
            change()
            heard = self.js("return window.carillon.heard()")
            rate, clip = self.js("return window.played.at(-1)")
            self.assertEqual(heard["object"], number)
            body = objects[number]
            strike = {**heard, "sampleRate": rate, "seconds": len(clip) / rate}
            if heard["alpha1"] is not None:
                strike["material"] = {"youngs_modulus": heard["stiffness"] * body["youngs_modulus"],
                                    "density": heard["density"] * body["density"],
                                    "alphas": [heard["alpha1"], heard["alpha2"]]}
                made = numpy.array(self.js("return window.carillon.strike(arguments[0])", strike))
                whole = len(clip) - round(0.011 * rate)  # its end is faded out
                difference = numpy.array(clip)[:whole] - heard["volume"] * made[:whole]
                self.assertLess(abs(difference).max(), 1e-4 * abs(made).max() * heard["volume"])
            self.assertGreater(max(map(abs, clip)), 0.01)
            self.assertLess(max(map(abs, clip)), 1)
            volumes.append(heard)
        for heard, preset, body in ((volumes[2], presets[0], objects[disc]), (volumes[4], presets[1], objects[plate])):
            self.assertAlmostEqual(heard["alpha1"], preset["alphas"][0])
            self.assertAlmostEqual(heard["stiffness"] * body["youngs_modulus"] / preset["youngs_modulus"], 1)
        self.assertNotEqual(volumes[1]["size"], 1)
        self.assertGreater(volumes[3]["damping"], 1)
