"""What one does with the page of `carillon report`: two runs compared, samples looked for, put in order, looked at
closely and heard, against the datasets' own files."""
import copy
import json
import re
import unittest

import h5py
import numpy
from browser import Keys, expect_access, expect_whole, look_through, needs_browser, press, show, start, there
from interrupted import wait_for
from program import FolderTest, run

CONFIG = """
name: first
seed: 5
materials: [steel, wood]
objects:
  - {shape: bar, count: 2}
  - {shape: tile}
modes: {max_modes: 12, order: 1, element_size: 20 mm, max_frequency: 15 kHz}
strikes: {per_object: 2}
audio: {seconds: 0.4 s, sample_rate: 44100 Hz}
"""
# The second has longer clips that are louder, an object that cannot be made, and other materials' damping.
CHANGES = ("name=second", "audio.seconds=0.6 s", "objects[0].count=3", "strikes.impulse=[20 mN s, 40 mN s]")
ACCURACY = {"mean": 0.8, "interval95": [0.7, 0.9], "deviation": None}
CLASSIFICATION = {
    "name": "told", "rows": [
        {"dataset": "d", "task": task, "method": "linear", "modalities": "audio", "samples": 50, "training_s": 2.0,
         "parameters": 10, "classes": ["a", "b"], "accuracy": ACCURACY} for task in ("material", "family")]}


def document(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content))


def t20(sound, rate):
    """Schroeder's backward integration, from -5 to -25 dB."""
    left = numpy.cumsum(sound[::-1].astype(float) ** 2)[::-1]
    level = 10 * numpy.log10(left / left[0] + 1e-30)
    return 3 * (numpy.argmax(level < -25) - numpy.argmax(level < -5)) / rate


class Page(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.folder / "first.yaml").write_text(CONFIG)
        for folder, changes in (("first", ()), ("second", CHANGES)):
            built = run("build", "first.yaml", "-o", folder, *[word for one in changes for word in ("--set", one)],
                        cwd=cls.folder)
            assert built.returncode == 0, built.stderr
        document(cls.folder / "first/evaluation/classification.json", CLASSIFICATION)
        better = copy.deepcopy(CLASSIFICATION)
        better["rows"][1]["accuracy"] = {"mean": 0.9, "interval95": [0.85, 0.95], "deviation": None}
        document(cls.folder / "second/evaluation/classification.json", better)
        (cls.folder / "second" / "failures.json").write_text(json.dumps(
            [{"task": "modes/x", "kind": "Error", "message": "it broke", "hint": "", "skipped": [], "reproduce": ""}]))
        cls.page = cls.folder / "report.html"
        made = run("report", "first", "second", "--sounds", "40", "-o", cls.page, cwd=cls.folder)
        assert made.returncode == 0, made.stderr
        cls.report = json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>',
                                          cls.page.read_text(), re.S)[1])
        cls.driver = start() if there() else None

    @classmethod
    def tearDownClass(cls):
        if cls.driver:
            cls.driver.quit()
        super().tearDownClass()

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def rows(self, where, caption):
        """Cells of the table of a caption."""
        return self.js("""
            const table = [...document.querySelectorAll(`${arguments[0]} table`)].find((one) => one.caption.textContent === arguments[1]);
            return [...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent));""", where, caption)

    def open(self, place="", **options):
        return show(self.driver, self.page.as_uri() + place, **options)

    COMPARED = "#compare?a=first&b=second"

    @needs_browser
    def test_a_comparison_tells_what_differs(self):
        driver = self.open(self.COMPARED)
        self.assertEqual({row[0]: row[1:] for row in self.rows("#compare", "Keys that differ")},
                         {"name": ["first", "second"], "audio.seconds": ["0.4", "0.6"], "objects[0].count": ["2", "3"],
                          "strikes.impulse": [json.dumps(value) for value in self.impulses()]})
        counts = {row[0]: row[1:] for row in self.rows("#compare", "Counts")}
        self.assertEqual(counts["sounds"], ["12", "16", "1.33"])
        self.assertEqual(counts["failed tasks"], ["0", "1", "–"])
        failed = self.rows("#compare", "Tasks that failed in one alone, or for another reason")
        self.assertEqual(failed, [["modes/x", "done", "it broke"]])
        traces = [json.loads((self.folder / name / "trace.json").read_text()) for name in ("first", "second")]
        stages = {row[0]: row for row in self.rows("#compare", "Stages, seconds on all ranks")}
        self.assertGreater(len(stages), 4)
        for name, row in stages.items():
            a, b = (trace["stages"].get(name, {}).get("seconds", 0) for trace in traces)
            if min(a, b) == 0:
                self.assertEqual((row[1] == "–", row[2] == "–", row[3]), (a == 0, b == 0, "–"))
            else:
                self.assertAlmostEqual(float(row[3].replace(",", "")), b / a, delta=0.006 * b / a)
        # Objects that both have; what is told apart with intervals.
        def drawn_figures():
            look_through(driver)
            return self.js("""
                return Object.fromEntries([...document.querySelectorAll('#compare figure:has(> h4)')].map((one) =>
                  [one.querySelector('h4').textContent, [one.querySelectorAll('circle').length, one.querySelector('figcaption').textContent]]));""")

        # A browser that is short of time draws late.
        self.assertTrue(wait_for(lambda: min(drawn_figures()[name][0] for name in ("Objects of both", "Told apart")) > 0, 30))
        drawn = drawn_figures()
        self.assertEqual(drawn["Objects of both"][0], 6)
        self.assertEqual(drawn["Told apart"][0], 4)
        self.assertIn("The second run is ahead in 1 of 2.", drawn["Told apart"][1])
        expect_whole(self, driver, 1280)
        for dark in (False, True):
            self.open(self.COMPARED, width=390, dark=dark)
            look_through(driver)
            expect_access(self, driver, 390)

    def impulses(self):
        found = [re.search(r"\n  impulse: \[(.*?), (.*?)\]", dataset["configuration"]) for dataset in self.report["datasets"]]
        return [[float(one) for one in match.groups()] for match in found]

    @needs_browser
    def test_a_comparison_has_the_sounds_of_the_same_keys(self):
        self.open(self.COMPARED)
        indices = [h5py.File(self.folder / name / "index.h5") for name in ("first", "second")]
        sounds = [dict(zip(index["key"].asstr(), index["audio"], strict=True)) for index in indices]
        keys = [sample["key"] for sample in self.report["datasets"][0]["heard"] if sample["key"] in sounds[1]]
        self.assertEqual(self.js("return [...document.querySelectorAll('#compare .pair h4')].map((one) => one.textContent)"), keys)
        self.assertEqual(self.js("return document.querySelectorAll('#compare audio').length"), 2 * len(keys))
        self.assertEqual(len(keys), 12)
        decays = 0
        for key in keys:
            told = {row[0]: row[1:] for row in self.rows("#compare", f"What differs between the two of {key}")}
            levels = [10 * numpy.log10(numpy.mean(one[key].astype(float) ** 2)) for one in sounds]
            for shown, level in zip(told["level"], [*levels, levels[1] - levels[0]], strict=True):
                self.assertAlmostEqual(float(shown.removesuffix(" dB")), level, delta=0.005 * abs(level) + 0.01)
            for shown, one in zip(told["reverberation time"], sounds, strict=False):
                if shown != "–":
                    decays += 1
                    self.assertAlmostEqual(float(shown.removesuffix(" s")), t20(one[key], 44100), delta=0.02 * t20(one[key], 44100))
            self.assertIn("impulse [N s]", told)
            self.assertNotIn("material", told)
        self.assertGreater(decays, 6)

    @needs_browser
    def test_a_comparison_is_chosen_linked_and_gone_back_from(self):
        self.open()
        self.assertEqual(self.js("return document.querySelectorAll('#compare table').length"), 0)
        self.js("document.querySelector('#compare button').focus()")
        press(self.driver, Keys.ENTER)
        self.assertTrue(wait_for(lambda: self.js("return document.querySelectorAll('#compare table').length") > 3, 10))
        self.assertEqual(self.js("return location.hash"), self.COMPARED)
        self.js("location.hash = '#compare?a=second&b=first'")
        self.assertTrue(wait_for(lambda: self.rows("#compare", "Counts")[0][1:3] == ["16", "12"], 10))
        self.assertEqual(self.js("return document.querySelector('#compare select').value"), "second")
        self.driver.back()
        self.assertTrue(wait_for(lambda: self.rows("#compare", "Counts")[0][1:3] == ["12", "16"], 10))
        self.open("#compare?a=first&b=third")
        self.assertIn("The page has no run third.", self.js("return document.querySelector('#compare').textContent"))
        self.open("#compare?a=first&b=first")
        self.assertIn("That is one run twice", self.js("return document.querySelector('#compare').textContent"))

    @needs_browser
    def test_samples_are_filtered_and_put_in_order(self):
        self.open()
        heard = [sample for dataset in self.report["datasets"] for sample in dataset["heard"]]
        shown = "return [...document.querySelectorAll('#samples .card h3')].map((one) => one.textContent)"
        self.assertEqual(self.js(shown), [sample["key"] for sample in heard])
        self.js("document.querySelector('#samples input[type=search]').focus()")
        press(self.driver, "WOOD strike-0001")
        wooden = [s["key"] for s in heard if "/wood/" in s["key"] and s["key"].endswith("1")]
        self.assertEqual(self.js(shown), wooden)
        self.assertIn(f"{len(wooden)} of {len(heard)} samples", self.js("return document.querySelector('#samples').textContent"))
        choose = "const menu = document.querySelector(`#samples select[name='${arguments[0]}']`); menu.value = arguments[1]; menu.onchange();"
        self.js(choose, "object", "tile-000")
        self.assertEqual(self.js(shown), [key for key in wooden if key.startswith("tile")])
        self.js(choose, "object", "")
        self.js(choose, "order", "impulse [N s]")
        impulse = {s["key"]: s["labels"]["impulse [N s]"] for s in self.report["datasets"][0]["heard"]}
        self.js(choose, "dataset", "first")
        self.assertEqual(len(set(impulse.values())), len(impulse))
        by_impulse = sorted({key for key in wooden if key in impulse}, key=impulse.get)
        self.assertEqual(self.js(shown), by_impulse)
        self.js("document.querySelector('#samples button[value=table]').click()")
        column = "return [...document.querySelectorAll('#samples tbody tr')].map((row) => row.cells[1].textContent)"
        self.assertEqual(self.js(column), by_impulse)
        head = "[...document.querySelectorAll('#samples th')].find((one) => one.textContent === arguments[0])"
        self.assertEqual(self.js(f"return {head}.getAttribute('aria-sort')", "impulse [N s]"), "ascending")
        self.js(f"{head}.querySelector('button').focus()", "impulse [N s]")
        press(self.driver, Keys.ENTER)
        self.assertEqual(self.js(column), by_impulse[::-1])
        self.assertEqual(self.js(f"return {head}.getAttribute('aria-sort')", "impulse [N s]"), "descending")
        self.js(f"{head}.querySelector('button').click()", "key")
        self.assertEqual(self.js(column), sorted(by_impulse))

    @needs_browser
    def test_a_sample_is_looked_at_closely(self):
        heard = self.report["datasets"][0]["heard"]
        number, sample = next((i, s) for i, s in enumerate(heard) if "/steel/" in s["key"])
        for width in (1280, 390):
            self.open(width=width)
            self.js("document.querySelectorAll('#samples button[aria-haspopup]')[arguments[0]].focus()", number)
            press(self.driver, Keys.ENTER)
            across = "return document.querySelector('dialog output').value"
            self.assertTrue(wait_for(lambda: self.js(across) == "0.4 s across", 20), self.js(across))
            expect_access(self, self.driver, width)
            press(self.driver, "+")
            self.assertTrue(wait_for(lambda: self.js(across) == "0.2 s across", 10), self.js(across))
            self.js("[...document.querySelectorAll('dialog button')].find((one) => one.textContent === 'Zoom in').focus()")
            press(self.driver, Keys.SPACE)
            self.assertTrue(wait_for(lambda: self.js(across) == "0.1 s across", 10), self.js(across))
            press(self.driver, "0")
            self.assertTrue(wait_for(lambda: self.js(across) == "0.4 s across", 10), self.js(across))
            self.assertTrue(wait_for(lambda: self.spectrogram() is not None, 10))
            # The brightest line is the strongest mode, where the axis says.
            with h5py.File(self.folder / "first" / "index.h5") as index:
                sound = index["audio"][list(index["key"].asstr()).index(sample["key"])]
            power = abs(numpy.fft.rfft(sound[:8192] * numpy.hanning(8192))) ** 2
            strongest = numpy.argmax(power) * 44100 / 8192
            drawn = self.spectrogram()
            row = drawn[:, drawn.shape[1] // 10].argmax()
            self.assertAlmostEqual(numpy.log2(60 * (22050 / 60) ** (1 - (row + 0.5) / len(drawn)) / strongest), 0, delta=0.1)
            played = self.driver.execute_async_script("""
                const [done] = arguments, audio = document.querySelector('dialog audio');
                audio.muted = true; audio.onended = () => done(audio.duration); audio.play().catch((error) => done(String(error)));""")
            self.assertAlmostEqual(played, 0.4, 3)
            self.js("document.querySelector('dialog button').click()")
            self.assertTrue(wait_for(lambda: self.js("return document.querySelector('dialog') === null"), 10))
            self.assertEqual([e for e in self.driver.get_log("browser") if e["level"] in ("SEVERE", "ERROR")], [])

    def spectrogram(self):
        """Brightness [rows, columns] of the spectrogram that is open; None where it is not drawn yet."""
        drawn = self.js("""
            const all = [...document.querySelector('dialog .stage').querySelectorAll('*')].map((one) => one.shadowRoot).filter(Boolean)
              .flatMap((root) => [...root.querySelectorAll('canvas')]).filter((one) => parseInt(one.style.height) > 100);
            if (all.length === 0) return null;
            const {width, height} = all[0];
            const pixels = all[0].getContext('2d').getImageData(0, 0, width, height).data;
            return [height, Array.from({length: width * height}, (_, i) => pixels[4 * i] + pixels[4 * i + 1] + pixels[4 * i + 2])];""")
        if drawn is None or max(drawn[1]) < 300:
            return None
        return numpy.reshape(drawn[1], (drawn[0], -1))


if __name__ == "__main__":
    unittest.main()
