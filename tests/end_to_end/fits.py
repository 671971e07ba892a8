"""fit: damping parameters from recordings and tables, and what it says when something is wrong."""
import csv
import json
import math
import pathlib
import subprocess
import sys
import unittest
import wave

import numpy
from program import FolderTest, run, run_json

PLOT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "plot_fit"
HEAD = "frequency_hz,decay_rate_per_s\n"


def drawn(count, seed=0):
    """Features of c = 10 + 4e-8 lambda [1/s] with errors and excess."""
    numbers = numpy.random.default_rng(seed)
    f = numbers.uniform(300, 10000, count)
    omega = 2 * math.pi * f
    d = (5 + 2e-8 * omega**2 + numbers.normal(0, 1, count) + numbers.exponential(10, count))
    return numpy.sqrt(omega**2 - d**2) / (2 * math.pi), d


def table(frequencies, rates):
    return HEAD + "".join(f"{f:.17g},{d:.17g}\n" for f, d in zip(frequencies, rates))


def write_wav(path, samples, rate=44100):
    """16-bit mono."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((numpy.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())


def strike(numbers, frequencies, rates, rate=44100):
    """One second of modes with random phases and amplitudes, from 0.1 s on, over faint noise."""
    t = numpy.arange(rate) / rate
    sound = numpy.zeros(rate)
    for f, d in zip(frequencies, rates):
        amplitude = numbers.uniform(0.3, 1)
        sound += amplitude * numpy.exp(-d * t) * numpy.cos(2 * math.pi * f * t + numbers.uniform(0, 6))
    sound = 0.7 * sound / numpy.abs(sound).max()
    return numpy.concatenate([numpy.zeros(rate // 10), sound]) + numbers.normal(0, 1e-4, rate + rate // 10)


class Recordings(FolderTest):
    def test_strikes_of_one_object_held_in_many_ways(self):
        numbers = numpy.random.default_rng(2)
        frequencies = 400 * 1.17 ** numpy.arange(20)
        material = 3 + 4e-9 * (2 * math.pi * frequencies) ** 2
        paths = []
        for number in range(8):
            rates = material + numbers.exponential(4, len(frequencies))
            paths.append(self.folder / f"strike-{number}.wav")
            write_wav(paths[-1], strike(numbers, frequencies, rates))
        silent = self.folder / "silent.wav"
        write_wav(silent, numpy.zeros(44100))
        broken = self.write("broken.wav", "no audio")
        answer = run("fit", *paths, silent, broken, "--estimator", "all", "--json")
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertIn("silent.wav: ", answer.stderr)
        self.assertIn("broken.wav: ", answer.stderr)
        result = json.loads(answer.stdout)
        self.assertGreater(result["points"], 140)
        self.assertLess(result["points"], 180)
        truth = lambda f: 3 + 4e-9 * (2 * math.pi * f) ** 2
        for name, tolerance in (("emg", 0.15), ("lower_bound", 0.15)):
            curve = result["fits"][name]["curve"]
            for f, d in zip(curve["frequency_hz"], curve["decay_rate_per_s"]):
                self.assertLess(abs(d / truth(f) - 1), tolerance, (name, f))
        squares = result["fits"]["least_squares"]["curve"]["decay_rate_per_s"]
        self.assertGreater(squares[0], 2 * truth(400))
        # The table that features writes leads to the same.
        table_path = self.folder / "strikes.csv"
        self.assertEqual(run("features", *paths, "--csv", table_path).returncode, 0)
        again = run_json("fit", "--features", table_path)
        for alpha in ("alpha1", "alpha2"):
            self.assertAlmostEqual(again["parameters"][alpha] / result["parameters"][alpha], 1, 3)

    def test_nothing_to_hear_is_told(self):
        silent = self.folder / "silent, twice.wav"
        write_wav(silent, numpy.zeros(44100))
        answer = run("fit", silent, silent)
        self.assertEqual(answer.returncode, 2)
        self.assertIn("no usable feature", answer.stderr)
        self.assertIn("silent, twice.wav: ", answer.stderr)
        # In a room that is known the reason is the same, and so are the checks.
        self.assertIn("silent, twice.wav: silent", run("fit", silent, "--rt60", "0.3").stderr)
        band = run("fit", silent, "--rt60", "0.3", "--min-frequency", "30 kHz", "--max-frequency", "40 kHz")
        self.assertIn("no mode can lie above", band.stderr)


class Fits(FolderTest):
    def test_every_estimator_by_its_names(self):
        f, d = drawn(300)
        path = self.write("mug.csv", table(f, d))
        result = run_json("fit", "--features", path, "--estimator", "all")
        self.assertEqual(set(result["fits"]),
                         {"mixture", "emg", "emg_relative", "least_squares", "lower_bound"})
        self.assertEqual(result["estimator"], "mixture")
        self.assertEqual(result["model_formula"], "c = alpha1 + alpha2 lambda")
        self.assertEqual(result["points"], 300)
        self.assertEqual(len(result["features"]), 300)
        self.assertTrue(result["converged"])
        alpha = result["parameters"]
        for name, truth in (("alpha1", 10), ("alpha2", 4e-8)):
            low, high = alpha["confidence95"][name]
            self.assertTrue(low < alpha[name] < high)
            self.assertTrue(low < truth < high, name)
        self.assertAlmostEqual(1 / result["eta_s"], 20, delta=4)
        self.assertAlmostEqual(sum(part["share"] for part in result["excess"]), 1)
        emg = result["fits"]["emg"]
        self.assertAlmostEqual(emg["sigma_per_s"], 2, delta=1)
        self.assertAlmostEqual(1 / emg["eta_s"], 20, delta=3)
        self.assertEqual(result["information"]["lowest_aic"], "emg")
        self.assertLess(result["timing"]["fit_s"], 5)
        # Least squares as NumPy has it.
        x = (2 * math.pi * f)**2 + d**2
        slope, intercept = numpy.polyfit(x, 2 * d, 1)
        squares = result["fits"]["least_squares"]["parameters"]
        self.assertAlmostEqual(squares["alpha1"] / intercept, 1, 6)
        self.assertAlmostEqual(squares["alpha2"] / slope, 1, 6)

    def test_tables_add_up_and_other_columns_do_not_count(self):
        f, d = drawn(60)
        whole = self.write("whole.csv", table(f, d))
        first = self.write("first.csv", table(f[:20], d[:20]))
        rows = "".join(f"\"x, y\",{b:.17g},{a:.17g},\n" for a, b in zip(f[20:], d[20:]))
        other = self.write("other.csv", "# a mug\n\nlabel, decay_rate_per_s, frequency_hz,note\n" +
                           rows)
        one = run_json("fit", "--features", whole)
        two = run_json("fit", "--features", first, "--features", other)
        self.assertEqual(one["parameters"], two["parameters"])
        self.assertEqual([s["features"] for s in two["sources"]], [20, 40])

    def test_errors_of_features_bound_sigma(self):
        f, d = drawn(100)
        d = 5 + 2e-8 * (2 * math.pi * f)**2  # on the curve
        rows = "".join(f"{a:.17g},{b:.17g},0.5\n" for a, b in zip(f, d))
        path = self.write("exact.csv", HEAD.strip() + ",decay_rate_error_per_s\n" + rows)
        result = run_json("fit", "--features", path, "--estimator", "emg")
        self.assertAlmostEqual(result["sigma_per_s"], 1, 6)  # of c
        self.assertIsNone(result["eta_s"])
        self.assertIn("the median error of the features", " ".join(result["remarks"]))

    def test_models(self):
        f, d = drawn(120)
        path = self.write("models.csv", table(f, d))
        for model, count in (("caughey", 3), ("caughey:4", 4), ("power", 2), ("hybrid", 3),
                             ("alpha1 + alpha2*sqrt(f)", 2)):
            result = run_json("fit", "--features", path, "--model", model, "--estimator", "all")
            for fit in result["fits"].values():
                alphas = [key for key in fit["parameters"] if key.startswith("alpha")]
                self.assertEqual(len(alphas), count)
                self.assertTrue(fit["converged"], model)

    def test_text_is_for_people(self):
        f, d = drawn(50)
        answer = run("fit", "--features", self.write("text.csv", table(f, d)))
        self.assertEqual(answer.returncode, 0, answer.stderr)
        for part in ("50 features of 1 file", "mixture: c = ", "95 %", "excess", "AIC"):
            self.assertIn(part, answer.stdout)

    def test_the_law_of_the_lowest_aic_is_chosen(self):
        f = 300 * 1.035 ** numpy.arange(110)
        numbers = numpy.random.default_rng(3)
        d = 3 + 0.02 * f**0.5 + numbers.exponential(0.2, len(f))
        path = self.write("root.csv", table(f, d))
        result = run_json("fit", "--features", path, "--model", "all")
        names = [entry["name"] for entry in result["models"]]
        self.assertEqual(names, ["rayleigh", "caughey", "power", "hybrid"])
        aic = {entry["name"]: entry["aic"] for entry in result["models"]}
        self.assertEqual(result["model"], min(aic, key=aic.get))
        self.assertIn(result["model"], ("hybrid", "power"))
        picture = self.folder / "laws.png"
        document = self.write("laws.json", json.dumps(result))
        subprocess.run([sys.executable, PLOT, document, picture], check=True)
        self.assertGreater(picture.stat().st_size, 10000)
        text = run("fit", "--features", path, "--model", "rayleigh, hybrid").stdout
        self.assertLess(text.index("hybrid "), text.index("rayleigh "))

    def test_a_law_that_turns_negative_is_told_and_not_chosen(self):
        f = numpy.geomspace(200, 9000, 80)
        # No features at the bottom of a valley: the formula overshoots there.
        f = numpy.concatenate([f[f < 700], f[f > 5000]])
        path = self.write("dip.csv", table(f, 0.3 + 4 * numpy.log(f / 1900)**2))
        formula = "alpha1 + alpha2*log(f) + alpha3*f"
        result = run_json("fit", "--features", path, "--model", formula, "--estimator", "least_squares")
        self.assertIn("the law is negative from", " ".join(result["remarks"]))
        both = run_json("fit", "--features", path, "--model", formula + ",rayleigh", "--estimator",
                        "least_squares")
        self.assertEqual(both["model"], "rayleigh")

    def test_an_aic_that_is_not_defined_is_not_printed(self):
        f, d = drawn(4)
        path = self.write("few.csv", table(f, d))
        for estimator in ("all", "least_squares", "mixture"):
            answer = run("fit", "--features", path, "--estimator", estimator)
            self.assertEqual(answer.returncode, 0, answer.stderr)
            self.assertNotRegex(answer.stdout, r"AIC (is )?-?(inf|nan)")
            self.assertNotIn("inf", answer.stdout)

    def test_a_room_hides_what_decays_faster(self):
        f, d = drawn(200)
        path = self.write("room.csv", table(f, d))
        result = run_json("fit", "--features", path, "--rt60", "0.2")
        self.assertEqual(result["points"], int((d < math.log(1000) / 0.2).sum()))

    def test_modes_faster_than_the_room_are_found_by_how_the_room_decays(self):
        numbers = numpy.random.default_rng(5)
        rate, rt60, law = 44100, 0.3, (8, 4e-8)  # the room's c is 46 1/s
        frequencies = numpy.array([700, 1300, 2100, 3000, 4100, 5200, 6300])
        t = numpy.arange(rate) / rate
        paths = []
        for k in range(6):
            f = frequencies * (1 + 0.03 * k)
            d = (law[0] + law[1] * (2 * math.pi * f)**2) / 2  # up to 44 1/s
            response = 0.02 * numpy.exp(-math.log(1000) / rt60 * t) * numpy.random.default_rng(k).normal(size=rate)
            response[0] = 1
            dry = sum(numpy.exp(-b * t) * numpy.cos(2 * math.pi * a * t + numbers.uniform(0, 6)) for a, b in zip(f, d))
            wet = numpy.fft.irfft(numpy.fft.rfft(dry, 2 * rate) * numpy.fft.rfft(response, 2 * rate))[:rate]
            wet = 0.5 * wet / numpy.abs(wet).max() + numbers.normal(0, 1e-4, rate)
            paths.append(self.folder / f"room{k}.wav")
            write_wav(paths[-1], numpy.concatenate([numbers.normal(0, 1e-4, 2000), wet]))
        known = run_json("fit", *paths, "--rt60", str(rt60))
        unknown = run_json("fit", *paths)
        self.assertGreater(known["points"], 25)
        self.assertGreater(sum(f["decay_rate_per_s"] > math.log(1000) / rt60 for f in known["features"]), 4)
        for alpha, true, within in (("alpha1", law[0], 0.15), ("alpha2", law[1], 0.1)):
            self.assertLess(abs(known["parameters"][alpha] / true - 1), within)
        # Without the room's time, what it makes of these modes is taken for them.
        known_off, unknown_off = (abs(found["parameters"]["alpha2"] / law[1] - 1) for found in (known, unknown))
        print(f"alpha2 is off by {known_off:.3f} with the room's time and {unknown_off:.3f} without", flush=True)
        self.assertGreater(unknown_off, 3 * known_off)

    def test_units_and_other_quantities(self):
        f, d = drawn(60)
        zeta = d / numpy.sqrt((2 * math.pi * f)**2 + d**2)
        rows = "".join(f"{a / 1000:.17g},{100 * z:.17g},{1000 * math.log(1000) / b:.17g}\n"
                       for a, z, b in zip(f, zeta, d))
        path = self.write("zeta.csv", "Frequency (kHz),zeta [%],T60 [ms]\n" + rows)
        one = run_json("fit", "--features", self.write("d.csv", table(f, d)))
        two = run_json("fit", "--features", path)
        for alpha in ("alpha1", "alpha2"):
            self.assertAlmostEqual(two["parameters"][alpha] / one["parameters"][alpha], 1, 6)

    def test_pictures_and_steps(self):
        f, d = drawn(80)
        path = self.write("picture.csv", table(f, d))
        steps = self.folder / "steps.csv"
        answer = run("fit", "--features", path, "--estimator", "all", "--history", steps, "--json")
        document = self.write("fit.json", answer.stdout)
        with open(steps, newline="", encoding="utf-8") as text:
            rows = list(csv.DictReader(text))
        emg = [row for row in rows if row["estimator"] == "emg"]
        self.assertEqual({row["start"] for row in emg}, set("01234567"))
        for name in ("log_likelihood", "gradient", "alpha1", "alpha2", "sigma", "eta"):
            self.assertTrue(math.isfinite(float(emg[-1][name])))
        picture = self.folder / "fit.png"
        subprocess.run([sys.executable, PLOT, document, picture, "--history", steps], check=True)
        self.assertGreater(picture.stat().st_size, 10000)

    def test_what_cannot_be_fitted_is_named(self):
        f, d = drawn(10)
        good = table(f, d)
        cases = [
            (HEAD + "440,6\nabc,7\n", [], ":3: frequency_hz is \"abc\""),
            (HEAD + "440,-6\n", [], ":2: decay_rate_per_s must be positive and finite, not -6"),
            (HEAD + "440,0\n", [], "must be positive"),
            (HEAD + "440,nan\n", [], "must be positive and finite, not nan"),
            (HEAD + "440\n", [], ":2: 1 values, but decay_rate_per_s"),
            ("pitch,d\n440,6\n", [], ":1: no column \"frequency_hz\""),
            (HEAD, [], "no usable feature"),
            (HEAD + "440,6\n", [], "1 feature, but rayleigh damping has 2 parameters"),
            (good, ["--model", "raleigh"], "did you mean \"rayleigh\""),
            (good, ["--model", "caughey:0"], "no Caughey series"),
            (good, ["--model", "6 + lambda"], "no number that could be fitted"),
            (good, ["--estimator", "mle"], "there is no estimator \"mle\""),
        ]
        for text, more, part in cases:
            answer = run("fit", "--features", self.write("bad.csv", text), *more)
            self.assertEqual(answer.returncode, 2, text)
            self.assertIn(part, answer.stderr)
        answer = run("fit", "--features", self.folder / "none.csv")
        self.assertEqual(answer.returncode, 2)
        self.assertIn("none.csv", answer.stderr)
        self.assertEqual(run("fit").returncode, 2)

    def test_a_table_without_lines_does_not_stop_the_others(self):
        empty = self.write("empty.csv", HEAD)
        f, d = drawn(30)
        answer = run("fit", "--features", empty, "--features", self.write("full.csv", table(f, d)))
        self.assertEqual(answer.returncode, 0)
        self.assertIn("empty.csv: the table has no lines", answer.stderr)


if __name__ == "__main__":
    unittest.main()
