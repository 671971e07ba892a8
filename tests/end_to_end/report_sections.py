"""What `report` asks of a dataset's section: the worst first, what accuracy cost as the data says it, paper."""
import base64
import re
import shutil
import subprocess

import h5py
import numpy
from browser import needs_browser, show
from report_views import report_of


class Sections:
    """Tests of the pages that self.open() and show(self.driver, ...) show."""

    def stored_errors(self):
        """Error bars of all modes of the dataset: (cents, object, set, mode), the largest first."""
        found = []
        for path in (self.folder / "small" / "modes").glob("*.h5"):
            with h5py.File(path) as file:
                for name in [one for one in file if one.startswith("set-")]:
                    found += [(cents, path.stem, int(name[4:]), mode) for mode, cents in enumerate(file[name]["pitch_errors"])]
        return sorted(found, reverse=True)

    def test_the_worst_modes_are_those_of_the_files(self):
        (dataset,) = self.report["datasets"]
        stored = self.stored_errors()
        self.assertGreater(len(stored), 100)
        self.assertEqual([(m["cents"], m["object"], m["set"], m["in_set"]) for m in dataset["worst_modes"]], stored[:20])
        for mode in dataset["worst_modes"]:
            with h5py.File(self.folder / "small" / "modes" / f"{mode['object']}.h5") as file:
                eigenvalue = file[f"set-{mode['set']:03}/eigenvalues"][mode["in_set"]]
            self.assertLessEqual(mode["hertz"], 20000)
            if mode["size"] == 1 and mode["material"] in ("slack", "glass", "ceramic"):  # alone in their sets
                self.assertAlmostEqual(mode["hertz"], numpy.sqrt(eigenvalue) / 2 / numpy.pi, 6)
            elif mode["material"] in ("slack", "ceramic"):
                self.assertAlmostEqual(mode["hertz"] * mode["size"], numpy.sqrt(eigenvalue) / 2 / numpy.pi, 6)

    @needs_browser
    def test_the_worst_come_first_and_lead_to_the_gallery(self):
        self.open()
        (dataset,) = self.report["datasets"]
        table = "[...document.querySelectorAll('#dataset-0 [role=region]')].find((one) => one.getAttribute('aria-label').startsWith(arguments[0]))"
        rows = self.js(f"return [...({table}).querySelectorAll('tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))",
                       "The 20 modes")
        self.assertEqual([row[0] for row in rows], [mode["object"] for mode in dataset["worst_modes"]])
        shown = [float(re.search(r"[0-9.]+", row[2])[0]) for row in rows]
        numpy.testing.assert_allclose(shown, [mode["cents"] for mode in dataset["worst_modes"]], rtol=0.005)
        objects = self.report["gallery"]["objects"]
        followed = 0
        for row, mode in enumerate(dataset["worst_modes"][:8]):
            self.js(f"({table}).querySelectorAll('tbody a')[arguments[1]].click()", "The 20 modes", row)
            body = objects[int(self.js("return document.querySelector('.desk select').value"))]
            self.assertEqual(body["object"], mode["object"])
            chosen = self.js("return document.querySelector('.swing select').value")
            if mode["in_set"] - body["modes_below"] < len(body["gain_scales"]):
                self.assertEqual(int(chosen), mode["in_set"] - body["modes_below"])
                followed += 1
        self.assertGreater(followed, 4)
        # Objects: what cannot be read or has the largest error bar comes first.
        worst = self.js(f"return [...({table}).querySelectorAll('tbody tr')].map((row) => row.cells[0].textContent)", "Objects")
        cents = {shape["id"]: shape["pitch_error_cents"] or -1 for shape in dataset["shapes"]}
        self.assertEqual([cents[name] for name in worst], sorted(cents.values(), reverse=True))

    @needs_browser
    def test_what_accuracy_cost_is_drawn_where_the_data_says(self):
        for page, number, target in ((self.page, 6, False), (self.halves(), 2, True)):
            (dataset,) = report_of(page)["datasets"]
            show(self.driver, page)
            self.js("dispatchEvent(new Event('beforeprint'))")
            dots, line, rule = self.js("""
                const figure = [...document.querySelectorAll('#dataset-0 figure')].find((one) => one.textContent.includes('What accuracy cost'));
                const place = (mark) => { const box = mark.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; };
                const line = [...figure.querySelectorAll('svg text')].find((one) => one.textContent.startsWith('pitch target'));
                const rule = line && figure.querySelector('svg .target line').getBoundingClientRect().y;
                return [[...figure.querySelectorAll('svg .objects path')].map((dot) => [dot.__data__, ...place(dot)]), line?.textContent, rule];""")
            shapes = [shape for shape in dataset["shapes"] if shape["pitch_error_cents"] and shape["seconds"]]
            self.assertEqual(len(dots), number)
            self.assertEqual({index for index, _, _ in dots}, set(range(len(shapes))))
            data = numpy.log([[shapes[index][key] for key in ("seconds", "pitch_error_cents")] for index, _, _ in dots])
            for axis, sign in ((0, 1), (1, -1)):
                places = numpy.array([dot[1 + axis] for dot in dots])
                slope, offset = numpy.polyfit(data[:, axis], places, 1)
                self.assertGreater(sign * slope, 20)
                if number > 2:
                    self.assertLess(abs(slope * data[:, axis] + offset - places).max(), 0.6)
                if axis == 1 and target:
                    self.assertEqual(dataset["pitch_target_cents"], 5)
                    self.assertIn("5 cents", line)
                    self.assertAlmostEqual(slope * numpy.log(5) + offset, rule, delta=1)
            self.assertEqual(line is not None, target)

    @needs_browser
    def test_paper_is_light_and_nothing_is_cut(self):
        self.open(dark=True)
        made = self.driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": True, "paperWidth": 8.27, "paperHeight": 11.69})
        path = self.folder / "paper.pdf"
        path.write_bytes(base64.b64decode(made["data"]))
        if shutil.which("pdftoppm"):
            subprocess.run(["pdftoppm", "-r", "40", "-gray", path, self.folder / "paper"], check=True)
            for page in sorted(self.folder.glob("paper-*.pgm")):
                kind, width, height, _ = page.read_bytes().split(maxsplit=4)[:4]
                self.assertEqual(kind, b"P5")
                pixels = numpy.frombuffer(page.read_bytes()[-int(width) * int(height):], "u1")
                self.assertGreater((pixels > 200).mean(), 0.6, page.name)
        # As wide as paper, everything unfolded: no figure and no table is wider.
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 718, "height": 1000, "deviceScaleFactor": 1, "mobile": False})
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        self.js("dispatchEvent(new Event('beforeprint'))")
        wide = self.js("""
            const main = document.querySelector('main').getBoundingClientRect();
            return [...document.querySelectorAll('figure, figure svg, table, pre')]
              .filter((one) => one.getClientRects().length > 0)
              .map((one) => [one.outerHTML.slice(0, 80), one.getBoundingClientRect()])
              .filter(([, box]) => box.left < main.left - 2 || box.right > main.right + 2).map(([text]) => text);""")
        self.assertEqual(wide, [])
        folded = self.js("return [...document.querySelectorAll('details.small-print')].map((one) => one.open && one.getBoundingClientRect().height > 30)")
        self.assertGreater(len(folded), 2)
        self.assertTrue(all(folded))
        figures = self.js("return [...document.querySelectorAll('#dataset-0 figure')].map((one) => getComputedStyle(one).breakInside)")
        self.assertEqual(set(figures), {"avoid"})
