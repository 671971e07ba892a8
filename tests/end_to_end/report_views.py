"""What `report` asks of how its objects are seen: each material in its look, modes that move as the modes files say,
two objects beside each other; by keyboard, and without WebGL."""
import base64
import json
import re
import time

import h5py
import numpy
from browser import needs_browser, show, there
from msh_files import msh_4, two_part_bar
from program import run, run_json

if there():
    from selenium.webdriver import ActionChains, Keys

HALVES = """
name: halves
objects: [{mesh: halves.msh, name: halves, materials: {left: red_paint, right: blue_paint}}, {shape: tile, materials: [glass]}]
materials_file: paints.yaml
modes: {max_modes: 14}
strikes: {per_object: 1}
audio: {seconds: 0.1 s}
camera: {width: 48, height: 48}
"""
PAINTS = """
red_paint: {youngs_modulus: 3 GPa, poisson_ratio: 0.35, density: 1200, alpha1: 5, alpha2: 1e-7,
            appearance: {base_colour: [0.7, 0.01, 0.01], roughness: 0.9}}
blue_paint: {youngs_modulus: 6 GPa, poisson_ratio: 0.35, density: 1200, alpha1: 9, alpha2: 1e-7,
             appearance: {base_colour: [0.01, 0.01, 0.7], roughness: 0.9}}
"""


def report_of(page):
    """What a page was made of."""
    return json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>', page.read_text(), re.S)[1])


def array(text, kind, columns):
    return numpy.frombuffer(base64.b64decode(text), kind).reshape(-1, columns)


class Views:
    """Tests of the pages that self.open() and show(self.driver, ...) show."""

    def choose(self, selector, value, which=0):
        self.js("const menu = document.querySelectorAll(arguments[0])[arguments[2]]; menu.value = arguments[1]; menu.onchange()",
                selector, str(value), which)

    def press(self, text, which=0):
        self.js("[...document.querySelectorAll('#gallery button')].filter((one) => one.textContent === arguments[0])[arguments[1]].click()",
                text, which)

    def viewer(self, which=0):
        viewer = self.driver.find_elements("css selector", ".viewer")[which]
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", viewer)
        return viewer

    def seen(self, which=0):
        """Pixels [height, width, 3] of an object's picture, once it is drawn."""
        canvas = self.viewer(which).find_element("css selector", "canvas")
        time.sleep(1)
        pixels = self.driver.execute_async_script("""
            const [png, done] = arguments;
            const picture = new Image();
            picture.onload = () => {
              const small = document.createElement('canvas');
              [small.width, small.height] = [160, Math.round(160 * picture.height / picture.width)];
              const context = small.getContext('2d');
              context.drawImage(picture, 0, 0, small.width, small.height);
              done([small.height, Array.from(context.getImageData(0, 0, small.width, small.height).data)]);
            };
            picture.src = `data:image/png;base64,${png}`;""", canvas.screenshot_as_base64)
        return numpy.reshape(pixels[1], (pixels[0], 160, 4))[:, :, :3]

    def differ(self, one, other):
        """Share of the pixels that are others."""
        return (abs(one - other).max(axis=2) > 12).mean()

    @classmethod
    def halves(cls):
        """A report of a bar whose halves are of two materials, made once."""
        page = cls.folder / "halves.html"
        if not page.exists():
            (cls.folder / "paints.yaml").write_text(PAINTS)
            (cls.folder / "halves.msh").write_text(msh_4(*two_part_bar()))
            (cls.folder / "halves.yaml").write_text(HALVES)
            built = run("build", "halves.yaml", cwd=cls.folder)
            assert built.returncode == 0, built.stderr
            run_json("report", "halves", "-o", page, cwd=cls.folder)
        return page

    @needs_browser
    def test_each_material_of_an_object_has_its_look(self):
        page = self.halves()
        body = report_of(page)["gallery"]["objects"][0]
        self.assertEqual([look["color"][0] > 0.5 for look in body["looks"]], [True, False])
        # Faces left of the middle are of the first, and each is there once.
        with h5py.File(self.folder / "halves" / "modes" / f"{body['object']}.h5") as file:
            regions = file["face_regions"][:]
        self.assertEqual([look["faces"] for look in body["looks"]], [sum(regions == 0), sum(regions == 1)])
        faces = array(body["faces"], "u4", len(body["lattice"]))
        middles = array(body["vertices"], "f4", 3)[faces][:, :, 0].mean(axis=1)
        parts = numpy.split(middles, [body["looks"][0]["faces"]])
        self.assertLess(parts[0].max(), 0.1001)
        self.assertGreater(parts[1].min(), 0.0999)
        show(self.driver, page)
        picture = self.seen()
        red, blue = (picture[..., k] > picture[..., 2 - k] + 40 for k in (0, 2))
        self.assertGreater(red.sum(), 200)
        self.assertGreater(blue.sum(), 200)
        self.assertLess(numpy.nonzero(red)[1].mean() + 20, numpy.nonzero(blue)[1].mean())

    def moved(self, vertices):
        return numpy.array([self.js("return window.carillon.drawn(arguments[0])", int(vertex)) for vertex in vertices])

    def drawn_twice(self):
        """Waits for two more of the screen's pictures: those that were asked for before are drawn by then."""
        self.driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")

    @needs_browser
    def test_a_mode_moves_as_its_modes_file_says_and_stops(self):
        self.open()
        objects = self.report["gallery"]["objects"]
        number, body = next((i, one) for i, one in enumerate(objects) if one["object"].startswith("bar"))
        self.choose(".desk select", number)
        rest = array(body["vertices"], "f4", 3).astype(float)
        with h5py.File(self.folder / "small" / "modes" / f"{body['object']}.h5") as file:
            nodes, shapes = file["set-000/surface/nodes"][:], file["set-000/shapes"][:]
        vertices = numpy.linspace(0, len(rest) - 1, 40).astype(int)
        at = [numpy.linalg.norm(nodes - rest[vertex], axis=1).argmin() for vertex in vertices]
        for mode in (0, 3):
            self.choose(".swing select", mode)
            self.viewer()
            stored = shapes[mode + body["modes_below"], at]
            largest = numpy.linalg.norm(shapes[mode + body["modes_below"]], axis=1).max()
            # All points move together, by the same multiple of what the file says.
            radius = numpy.linalg.norm(rest - (rest.max(axis=0) + rest.min(axis=0)) / 2, axis=1).max()
            multiples = set()
            # Software draws some frames a second at the best, and perhaps one in each period.
            until = time.monotonic() + 180
            while (len(multiples) < 5 or max(multiples) - min(multiples) < 0.05 * radius) and time.monotonic() < until:
                drawn = numpy.array(self.js("return arguments[0].map((vertex) => window.carillon.drawn(vertex))", vertices.tolist()))
                multiple = ((drawn - rest[vertices]) * stored).sum() / (stored**2).sum()
                numpy.testing.assert_allclose(drawn, rest[vertices] + multiple * stored, atol=0.01 * abs(multiple) * largest + 1e-9)
                multiples.add(round(multiple * largest, 5))
                time.sleep(0.1)
            self.assertGreaterEqual(len(multiples), 5)
            self.assertLess(max(map(abs, multiples)), 0.1201 * radius)
            self.assertGreater(max(multiples) - min(multiples), 0.05 * radius)
        self.press("Pause")
        self.drawn_twice()
        before, still = self.seen(), self.moved(vertices)
        time.sleep(0.5)
        numpy.testing.assert_array_equal(self.moved(vertices), still)
        self.assertEqual(self.differ(before, self.seen()), 0)
        self.press("Play")
        self.assertTrue(any(self.differ(before, self.seen()) > 0.01 for _ in range(30)))
        frequency = numpy.sqrt(array(body["eigenvalues"], "f8", 1)[3, 0]) / 2 / numpy.pi
        said = self.js("return document.querySelector('.swing .note').textContent")
        slower = float(re.search(r"([0-9.,]+) times as long", said)[1].replace(",", ""))
        self.assertAlmostEqual(slower / (1.25 * frequency), 1, 2)
        self.assertIn("cents (estimated)", said)
        self.assertRegex(said, r"T60 [0-9.]+ m?s")

    @needs_browser
    def test_nothing_moves_by_itself_where_motion_is_unwanted(self):
        self.open()
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-reduced-motion", "value": "reduce"}]})
        self.viewer()
        self.choose(".swing select", 1)
        rest = array(self.report["gallery"]["objects"][0]["vertices"], "f4", 3)
        still = self.moved(range(8))
        self.assertGreater(abs(still - rest[:8]).max(), 0)
        time.sleep(0.5)
        numpy.testing.assert_array_equal(self.moved(range(8)), still)
        self.press("Play")
        time.sleep(0.7)
        self.assertGreater(abs(self.moved(range(8)) - still).max(), 0)

    @needs_browser
    def test_two_objects_stand_beside_each_other(self):
        self.open()
        objects = self.report["gallery"]["objects"]
        frequencies = [numpy.sqrt(array(one["eigenvalues"], "f8", 1)[:, 0]) / 2 / numpy.pi for one in objects]
        self.press("Put a second object beside it")
        bar, disc = (next(i for i, one in enumerate(objects) if one["object"].startswith(name)) for name in ("bar", "disc"))
        for which, number in enumerate((bar, disc)):
            self.choose(".desk > div > p > select", number, which)
        # Each the other's nearest.
        a, b = frequencies[bar], frequencies[disc]
        cents = 1200 * numpy.log2(b[None, :] / a[:, None])
        expected = sorted(cents[i, j] for i, j in enumerate(abs(cents).argmin(axis=1)) if abs(cents[:, j]).argmin() == i)
        self.assertGreater(len(expected), 4)
        shown = "return [...document.querySelectorAll('#gallery tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))"
        rows = self.js(shown)
        found = sorted(float(row[2].replace("−", "-").split(" ")[0].replace(",", "")) for row in rows if row[2] != "–")
        numpy.testing.assert_allclose(found, expected, rtol=0.01, atol=0.6)
        self.assertEqual(len(rows), len(a) + len(b) - len(expected))
        self.assertIn("±", rows[0][3] + rows[0][4])
        # One object twice, twice as large: an octave below, mode by mode.
        self.choose(".desk > div > p > select", bar, 1)
        self.js("""
            const slider = [...document.querySelectorAll('.desk')].at(-1).querySelector('.controls label:nth-child(4) input');
            slider.value = Math.log(2 / 0.25) / Math.log(16);
            slider.dispatchEvent(new Event('input')); slider.dispatchEvent(new Event('change'));""")
        rows = self.js(shown)
        self.assertEqual({row[2] for row in rows}, {"−1200 cents"})
        self.assertEqual(len(rows), len(a))
        # Both are struck, each where it is clicked.
        for which in (0, 1):
            ActionChains(self.driver).move_to_element(self.viewer(which)).click().perform()
        messages = self.js("return [...document.querySelectorAll('.desk > div > [aria-live]')].map((one) => one.textContent)")
        for message in messages:
            self.assertRegex(message, r"Struck at \(.*\) mm: peak [0-9.]+ m/s")
        # Together, and each for itself.
        for link, other_turns in ((True, True), (False, False)):
            self.js("const box = document.querySelector('#gallery input[type=checkbox]'); if (box.checked !== arguments[0]) box.click()", link)
            before = self.seen(0), self.seen(1)
            self.viewer(0).send_keys(4 * Keys.ARROW_RIGHT)
            self.assertGreater(self.differ(before[0], self.seen(0)), 0.02)
            self.assertEqual(self.differ(before[1], self.seen(1)) > 0.02, other_turns)

    @needs_browser
    def test_an_object_is_turned_and_struck_by_keys_alone(self):
        self.open(390)
        focus = "return document.activeElement.className"
        for _ in range(200):
            ActionChains(self.driver).send_keys(Keys.TAB).perform()
            if self.js(focus) == "viewer":
                break
        self.assertEqual(self.js(focus), "viewer")
        before = self.seen()
        ActionChains(self.driver).send_keys(3 * Keys.ARROW_LEFT + 2 * Keys.ARROW_UP + "+").perform()
        self.assertGreater(self.differ(before, self.seen()), 0.02)
        self.assertIn("Not struck yet", self.js("return document.querySelector('.desk [aria-live]').textContent"))
        ActionChains(self.driver).send_keys(Keys.ENTER).perform()
        self.assertRegex(self.js("return document.querySelector('.desk [aria-live]').textContent"), "Struck at")
        self.assertRegex(self.js("return document.querySelector('.viewer canvas').getAttribute('aria-label')"),
                         rf"^{self.report['gallery']['objects'][0]['name']}, [0-9.]+ mm across")

    @needs_browser
    def test_without_webgl_objects_are_struck_by_a_button(self):
        script = self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": """
            const context = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
              return kind.startsWith('webgl') ? null : context.call(this, kind, ...more);
            };"""})
        try:
            self.open()
            self.assertIn("shows no WebGL", self.js("return document.querySelector('.viewer').textContent"))
            self.press("Strike anywhere")
            self.choose(".swing select", 1)
            self.assertIn("Struck at", self.js("return document.querySelector('.desk [aria-live]').textContent"))
            self.assertFalse(self.driver.find_elements("css selector", ".viewer canvas"))
        finally:
            self.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
