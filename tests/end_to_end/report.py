"""`carillon report`: the page's data against the dataset's own files, and the page itself in a headless
Chromium: no errors, no network, links and players that work, at a screen's width and a telephone's;
objects struck in the page sound as the dataset does."""
import base64
import io
import json
import shutil
import unittest
import wave

import h5py
import numpy
from browser import expect_whole, needs_browser, show, start, there
from program import FolderTest, run, run_json
from report_access import Access
from report_gallery import OWN, SLACK, Gallery
from report_sections import Sections
from report_views import Views, report_of

CONFIG = """
name: small
dataset: {description: A test's, creator: [A], license: CC-BY-4.0}
seed: 4
objects:
  - {shape: bar, count: 2, materials: [steel, wood]}
  - {shape: tile, materials: [glass]}
  - {shape: bowl, materials: [ceramic], sizes: [1, 1.5]}
  - {shape: disc, materials: [hard, soft], sizes: [1, 1.25]}
  - {shape: plate, materials: [slack], sizes: [1, 1.25]}
  - {mesh: broken.off, length: 10 cm, materials: [steel]}
materials_file: own.yaml
modes: {max_modes: 90, order: 2, element_size: 14 mm, max_frequency: 20 kHz}
strikes: {per_object: 3, impulse: [5 mN s, 50 mN s], contact_time: [0.1 ms, 0.5 ms], spread: 0}
audio: {seconds: 0.5 s, sample_rate: 44100 Hz}
mel: {bands: 16, frames: 5}
voxels: {resolution: 12}
camera: {width: 96, height: 64}
split: {validation: 0.3, test: 0.3}
"""
STUDY = """
name: study
modes: {max_modes: 4}
levels: {orders: [1, 2], element_size_factors: [2, 1.4]}
pitch_targets: [50]
objects: [{shape: tile}]
sound:
  object: {shape: tile}
  strike_count: 3
  mode_counts: [2, 5, 10]
  image_orders: [0, 1, 4]
  scene:
    listeners: [{position: [0.5, 0.2, 0.3]}]
    radiation: {model: monopole}
    room: {dimensions: [4 m, 3 m, 2.5 m], absorption: 0.3}
    effects: {tail: "off", click: "off"}
    audio: {seconds: 0.2 s, sample_rate: 22050 Hz}
features: {extractors: [esprit, peaks], mode_counts: [3], snr_levels: [50 dB], clips: 6, seconds: 0.5 s}
"""


def samples_of(text):
    """Samples [channels, samples] of a WAV file of 16 bits in base64, and its rate."""
    with wave.open(io.BytesIO(base64.b64decode(text))) as clip:
        frames = numpy.frombuffer(clip.readframes(clip.getnframes()), "<i2")
        return frames.reshape(-1, clip.getnchannels()).T / 32768, clip.getframerate()


class Report(FolderTest, Access, Gallery, Views, Sections):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "small.yaml"
        cls.config.write_text(CONFIG)
        (cls.folder / "own.yaml").write_text("".join(
            f"{name}: {{youngs_modulus: {own['youngs_modulus']}, density: {own['density']}, "
            f"poisson_ratio: 0.3, alpha1: {own['alphas'][0]}, alpha2: {own['alphas'][1]}}}\n"
            for name, own in OWN.items()) +
            "slack: {youngs_modulus: 4e9, density: 1200, poisson_ratio: 0.3, damping: hybrid, "
            f"alpha1: {SLACK['alpha1']}, alpha2: {SLACK['alpha2']}, alpha3: {SLACK['alpha3']}}}\n")
        (cls.folder / "broken.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        built = run("build", "small.yaml", cwd=cls.folder, ranks=2)
        assert built.returncode == 3, built.stderr  # the broken one fails
        (cls.folder / "study.yaml").write_text(STUDY)
        measured = run("accuracy", "study.yaml", "-o", "study", cwd=cls.folder)
        assert measured.returncode == 0, measured.stderr
        warnings = [{"task": "modes/tile-000", "message": f"doubt {number}"} for number in range(2)]
        (cls.folder / "small" / "warnings.json").write_text(json.dumps(warnings))
        cls.told = run_json("report", "small", "study", "-o", "report.html", cwd=cls.folder)
        cls.page = cls.folder / "report.html"
        cls.report = report_of(cls.page)
        cls.index = h5py.File(cls.folder / "small" / "index.h5")
        cls.driver = start() if there() else None

    @classmethod
    def tearDownClass(cls):
        if cls.driver:
            cls.driver.quit()
        super().tearDownClass()

    def test_what_was_built_is_what_the_folder_says(self):
        (dataset,) = self.report["datasets"]
        self.assertEqual([w["message"] for w in dataset["warnings"]], ["doubt 0", "doubt 1"])
        self.assertEqual(dataset["warned"], 2)
        stored = json.loads((self.folder / "small" / "dataset.json").read_text())
        trace = json.loads((self.folder / "small" / "trace.json").read_text())
        self.assertEqual(dataset["samples"], len(self.index["key"]))
        self.assertEqual([s["id"] for s in dataset["shapes"]], [s["id"] for s in stored["shapes"]])
        self.assertEqual(dataset["stages"], trace["stages"])
        self.assertEqual(dataset["about"]["license"], "CC-BY-4.0")
        self.assertEqual(sorted(t["task"] for t in dataset["tasks"]),
                         sorted(t["task"] for t in trace["tasks"]))
        for shape in dataset["shapes"]:
            path = self.folder / "small" / "modes" / f"{shape['id']}.h5"
            if shape["id"].startswith("broken"):
                self.assertIsNone(shape["modes"])
                continue
            with h5py.File(path) as file:
                sets = [file[name] for name in file if name.startswith("set-")]
                self.assertEqual(shape["modes"], max(len(s["eigenvalues"]) for s in sets))
                errors = numpy.concatenate([s["pitch_errors"][:] for s in sets])
                self.assertAlmostEqual(shape["pitch_error_cents"], errors.max())
                self.assertAlmostEqual(shape["median_pitch_error_cents"], numpy.median(errors))
        failed = json.loads((self.folder / "small" / "failures.json").read_text())
        self.assertEqual(dataset["failures"], failed)
        self.assertEqual(len(failed), 1)

    def test_figures_name_what_made_them(self):
        (dataset,), (study,) = self.report["datasets"], self.report["studies"]
        for made, words, ranks in ((dataset["made"], "build small.yaml", 2),
                                   (study["made"], "accuracy study.yaml -o study", 1)):
            self.assertIn(words, made["command"])
            self.assertEqual(made["ranks"], ranks)
            self.assertRegex(made["carillon"], r"^\d+\.\d+\.\d+(\+\S+)?$")
            self.assertTrue(made["processor"])

    def test_many_datasets_and_long_tables_are_cut_and_counted(self):
        many = self.folder / "many"
        for number in range(43):
            shutil.copytree(self.folder / "small", many / f"{number:02}",
                            ignore=shutil.ignore_patterns("cache", "pictures", "sounds"))
        path = many / "01" / "trace.json"
        trace = json.loads(path.read_text())
        trace["tasks"] = [{**trace["tasks"][0], "seconds": float(s)} for s in range(9000)]
        path.write_text(json.dumps(trace))
        path = many / "02" / "failures.json"
        path.write_text(json.dumps(500 * json.loads(path.read_text())))
        told = run_json("report", "many", "-o", "many.html", cwd=self.folder)
        self.assertIn("3 of 43 datasets are left out, after many/39", told["notes"][0])
        self.assertEqual(told["datasets"], 40)
        self.assertLess(told["bytes"], 15e6)
        datasets = report_of(self.folder / "many.html")["datasets"]
        self.assertEqual([len(d["heard"]) for d in datasets], 40 * [1])
        self.assertEqual(datasets[1]["tasks_run"], 9000)
        self.assertEqual([t["seconds"] for t in datasets[1]["tasks"]],
                         [float(s) for s in range(8900, 9000)])  # the longest
        self.assertEqual((datasets[2]["failed"], len(datasets[2]["failures"])), (500, 100))

    def test_effects_are_those_of_plan_and_trace(self):
        (dataset,) = self.report["datasets"]
        plan = run_json("plan", self.config, cwd=self.folder)
        on = {e["name"] for e in plan["effects"] if e["enabled"]}
        self.assertEqual({e["name"] for e in dataset["effects"] if e["enabled"]}, on)
        self.assertEqual({e["name"] for e in dataset["effects"] if e["calls"] > 0}, on)

    def test_samples_are_the_datasets(self):
        keys = list(self.index["key"].asstr())
        heard = self.report["datasets"][0]["heard"]
        self.assertEqual(len(heard), 12)
        for sample in heard:
            row = keys.index(sample["key"])
            (clip,), rate = samples_of(sample["audio"])
            stored = self.index["audio"][row]
            self.assertEqual(rate, 44100)
            gain = 0.5 / abs(stored).max()
            numpy.testing.assert_allclose(clip, gain * stored, atol=1 / 32768)
            self.assertAlmostEqual(sample["labels"]["played at [dB]"], 20 * numpy.log10(gain), 4)
            self.assertEqual(sample["labels"]["material"], self.index["material"].asstr()[row])
            shape = self.index["shape_index"][row]
            bits = numpy.frombuffer(base64.b64decode(sample["voxels"]["cells"]), "u1")
            cells = numpy.unpackbits(bits)[:12**3].reshape(12, 12, 12)
            numpy.testing.assert_array_equal(cells, self.index["shapes/voxels"][shape] > 0)
            self.assertTrue(base64.b64decode(sample["picture"]).startswith(b"\x89PNG"))

    def test_studys_fall_as_their_levels_rise(self):
        (study,) = self.report["studies"]
        for key in ("modes", "image order"):
            levels = [r for r in study["sound"]["levels"] if r["key"] == key]
            errors = [r["error_db"] for r in levels]
            self.assertGreater(len(errors), 2)
            self.assertEqual(errors[-1], 0)
            self.assertEqual(errors, sorted(errors, reverse=True), key)
            self.assertGreater(errors[0], 0.1)
            self.assertGreater(min(r["seconds"] for r in levels), 0)
        levels = {r["method"]: r for r in study["features"]["levels"]}
        # Maximum likelihood comes to the bound; 18 modes know it to a factor of 1.6 or so.
        self.assertEqual(levels["esprit"]["found"], 1)
        self.assertGreater(levels["esprit"]["bounds_frequency"], 0.5)
        self.assertLess(levels["esprit"]["bounds_frequency"], 1.8)
        self.assertLess(levels["esprit"]["bounds_decay_rate"], 1.8)
        self.assertGreater(levels["peaks"]["bounds_frequency"], levels["esprit"]["bounds_frequency"])

    def test_mistakes_are_named(self):
        gone = run("report", "nowhere", cwd=self.folder)
        self.assertEqual(gone.returncode, 2)
        self.assertIn("nowhere: no such folder", gone.stderr)
        (self.folder / "empty").mkdir(exist_ok=True)
        empty = run("report", "empty", cwd=self.folder)
        self.assertEqual(empty.returncode, 2)
        self.assertIn("nothing to report", empty.stderr)
        hurt = self.folder / "hurt" / "inside"
        hurt.mkdir(parents=True, exist_ok=True)
        (hurt / "dataset.json").write_text("{}")
        told = run_json("report", "hurt", "study", "-o", "hurt.html", cwd=self.folder)
        self.assertIn("hurt/inside cannot be shown", told["notes"][0])
        self.assertEqual(told["datasets"], 0)

    def test_what_is_damaged_costs_itself_alone(self):
        hurt = self.folder / "damaged"
        for name in ("accuracy.json", "nightly.json", "sweep.json", "evaluation/damping.json",
                     "evaluation/classification.json", "evaluation/transfer.json"):
            for text in ("{}", "{", '{"objects": 1, "measures": 1, "variants": 1, "rows": 1, "errors": 1}'):
                (hurt / name).parent.mkdir(parents=True, exist_ok=True)
                (hurt / name).write_text(text)
                told = run_json("report", "damaged/", "study/", "-o", "damaged.html",
                                cwd=self.folder)
                self.assertEqual(told["studies"] >= 1, True)
                if text != '{"objects": 1, "measures": 1, "variants": 1, "rows": 1, "errors": 1}':
                    self.assertIn(name.split("/")[-1], told["notes"][0])
            (hurt / name).unlink()
        # An object's modes cost the object.
        copy = self.folder / "small-copy"
        shutil.copytree(self.folder / "small", copy, dirs_exist_ok=True)
        (copy / "modes" / "tile-000.h5").write_bytes(b"nothing")
        told = run_json("report", copy, "-o", "copy.html", cwd=self.folder)
        self.assertEqual(told["datasets"], 1)
        self.assertEqual(told["objects"], 5)
        self.assertIn("tile-000 cannot be struck", told["notes"][0])

    @needs_browser
    def test_a_document_of_another_kind_leaves_the_rest_of_the_page(self):
        hurt = self.folder / "other"
        (hurt / "evaluation").mkdir(parents=True, exist_ok=True)
        (hurt / "evaluation" / "classification.json").write_text('{"rows": [{}]}')
        (hurt / "nightly.json").write_text('{"measures": [{}]}')
        run_json("report", hurt, "study", "-o", "other.html", cwd=self.folder)
        driver = show(self.driver, self.folder / "other.html")
        said = driver.execute_script("return document.querySelector('main').textContent")
        self.assertIn("cannot be drawn", said)
        titles = driver.execute_script(
            "return [...document.querySelectorAll('#accuracy h4')].map((title) => title.textContent)")
        self.assertTrue([t for t in titles if t.startswith("Modes")], titles)
        self.assertTrue([t for t in titles if t.startswith("Features")], titles)

    def test_a_page_stays_small(self):
        self.assertEqual(self.told["bytes"], self.page.stat().st_size)
        self.assertLess(self.told["bytes"], 15e6)

    def open(self, width=1280, dark=False):
        return show(self.driver, self.page, width, dark=dark)

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    @needs_browser
    def test_nothing_is_wrong_and_nothing_is_fetched(self):
        for width in (1280, 390):
            for dark in (False, True):
                driver = self.open(width, dark)
                self.assertGreaterEqual(expect_whole(self, driver, width), 7)

    @needs_browser
    def test_paper_has_what_is_folded_away_and_not_yet_seen(self):
        for number in range(4):  # more than three are folded
            copy = self.folder / "four" / str(number)
            shutil.copytree(self.folder / "small", copy,
                            ignore=shutil.ignore_patterns("cache", "pictures", "sounds"))
            (copy / "failures.json").write_text("[]")  # what has none stays closed
        run_json("report", "four", "study", "-o", "four.html", cwd=self.folder)
        driver = show(self.driver, self.folder / "four.html")
        charts = "return [...document.querySelectorAll('details .chart')].map((chart) => chart.querySelectorAll('svg').length)"
        self.assertEqual(min(driver.execute_script(charts)), 0)
        driver.execute_cdp_cmd("Page.printToPDF", {})
        folded = driver.execute_script(charts)
        self.assertGreater(len(folded), 7)
        self.assertGreater(min(folded), 0)
        pictures = driver.execute_script("return document.querySelectorAll('.spectrogram canvas').length")
        self.assertEqual(pictures, 12)

    @needs_browser
    def test_spectrograms_show_every_mode(self):
        driver = self.open()
        driver.execute_script("dispatchEvent(new Event('beforeprint'))")
        points = numpy.array([[0, 0, 4], [28, 16, 68], [79, 18, 123], [129, 37, 129], [181, 54, 122],
                              [229, 80, 100], [251, 135, 97], [254, 194, 135], [252, 253, 191]])
        fractions = numpy.linspace(0, 1, 801)
        magma = numpy.array([numpy.interp(8 * fractions, range(9), points[:, k]) for k in range(3)]).T
        for number, sample in enumerate(self.report["datasets"][0]["heard"][:4]):
            (clip,), rate = samples_of(sample["audio"])
            window = 0.5 - 0.5 * numpy.cos(2 * numpy.pi * numpy.arange(1024) / 1024)
            frames = numpy.lib.stride_tricks.sliding_window_view(clip, 1024)[::256] * window
            power = (abs(numpy.fft.rfft(frames)) ** 2)[:, :512]
            drawn = driver.execute_script("""
                const canvas = document.querySelectorAll('.spectrogram canvas')[arguments[0]];
                const {width, height} = canvas;
                return [width, height, Array.from(canvas.getContext('2d').getImageData(0, 0, width, height).data)]""", number)
            width, height, pixels = drawn
            pixels = numpy.reshape(pixels, (height, width, 4))[:, :, :3]
            ends = 60 * (rate / 2 / 60) ** (1 - numpy.arange(height + 1) / height) * 1024 / rate
            lines = 0
            for y in range(height):
                bins = numpy.arange(int(numpy.ceil(ends[y + 1])), min(int(ends[y]), 511) + 1)
                if len(bins) == 0:
                    continue
                level = 10 * numpy.log10(power[:, bins].max() / power.max() + 1e-30)
                brightest = pixels[y, pixels[y].sum(axis=1).argmax()]
                shown = 80 * (fractions[((magma - brightest) ** 2).sum(axis=1).argmin()] - 1)
                self.assertAlmostEqual(shown, max(level, -80), delta=0.5)
                lines += level > -60
            self.assertGreater(lines, 5)

    @needs_browser
    def test_every_link_leads_somewhere(self):
        self.open()
        links = self.js("return [...document.querySelectorAll('a')].map(a => a.getAttribute('href'))")
        self.assertGreater(len(links), 4)
        for link in links:
            self.assertTrue(link.startswith("#"), link)
            self.assertTrue(self.js("return document.querySelector(arguments[0]) !== null", link), link)

    @needs_browser
    def test_every_player_plays(self):
        self.open()
        played = self.driver.execute_async_script("""
            const done = arguments[0];
            Promise.all([...document.querySelectorAll('audio')].map(async (audio) => {
              audio.muted = true;
              await audio.play();
              await new Promise((ended) => { audio.onended = ended; });
              return audio.duration;
            })).then(done, (error) => done(String(error)));""")
        self.assertEqual(len(played), 12)
        for duration in played:
            self.assertAlmostEqual(duration, 0.5, 3)


if __name__ == "__main__":
    unittest.main()
