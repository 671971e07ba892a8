"""compare: two sounds of one object, whose differences are known."""
import math
import unittest

import numpy
from estimate import write_wav
from features import RATE, read_float_wav, write_float_wav
from program import FolderTest, run, run_json

# f [Hz], d [1/s], amplitude, phase
BOWL = [(523, 8, 0.3, 0.3), (1480, 15, 0.4, 1), (3950, 60, 0.25, 2)]


def ringing(modes, seconds=1, onset=0.05, rate=RATE):
    """Damped sinusoids after silence, with a little noise that does not depend on them."""
    t = numpy.arange(int(rate * seconds)) / rate
    sound = sum(a * numpy.exp(-d * t) * numpy.cos(2 * math.pi * f * t + p) for f, d, a, p in modes)
    sound = numpy.concatenate([numpy.zeros(int(rate * onset)), sound])
    return sound + numpy.random.default_rng(8).normal(0, 1e-5, len(sound))


def changed(modes, cents=0.0, decay=1.0, level=0.0):
    return [(f * 2**(cents / 1200), d * decay, a * 10**(level / 20), p) for f, d, a, p in modes]


class Compare(FolderTest):
    def clip(self, name, samples):
        path = self.folder / name
        write_float_wav(path, samples)
        return path

    def compare(self, modes, *options, onset=0.05):
        reference = self.clip("reference.wav", ringing(BOWL))
        return run_json("compare", reference, self.clip("other.wav", ringing(modes, onset=onset)),
                        *options)

    def test_a_file_against_itself(self):
        path = self.clip("bowl.wav", ringing(BOWL))
        result = run_json("compare", path, path)
        self.assertEqual(len(result["matched"]), 3)
        for kind in ("pitch", "decay", "level"):
            self.assertEqual(result["jnd"][kind], {"mean": 0, "worst": 0})
        self.assertEqual(result["level_db"], 0)
        self.assertEqual(result["reference_matched_energy"], 1)
        self.assertEqual(result["other_matched_energy"], 1)
        self.assertIsNone(result["unmatched_energy_db"])
        self.assertEqual(result["loudness"], {"rms_sone_per_bark": 0, "fraction": 0})
        self.assertEqual(result["spectra"], {"convergence": 0, "log_magnitude": 0, "total": 0})
        self.assertEqual(result["reference"]["modes"], 3)
        self.assertGreater(result["reference"]["loudest_sone"], 1)
        self.assertGreater(result["timing"]["compare_s"], 0)

    def test_detuned_by_ten_cents(self):
        result = self.compare(changed(BOWL, cents=10))
        jnds = [mode["pitch_jnd"] for mode in result["matched"]]
        for jnd, expected in zip(jnds, (2, 2, 0.5), strict=True):  # the last one is short
            self.assertAlmostEqual(jnd, expected, delta=0.05)
        self.assertAlmostEqual(result["jnd"]["pitch"]["worst"], 2, delta=0.05)
        self.assertLess(result["jnd"]["level"]["worst"], 0.1)

    def test_decays_a_third_faster(self):
        result = self.compare(changed(BOWL, decay=1.33))
        for mode in result["matched"]:
            self.assertAlmostEqual(mode["decay_ratio"], 1.33, delta=0.01)
            self.assertAlmostEqual(mode["decay_jnd"], 1, delta=0.03)

    def test_quieter_and_later(self):
        result = self.compare(changed(BOWL, level=-6), onset=0.2)
        self.assertAlmostEqual(result["level_db"], -6, delta=0.05)
        self.assertAlmostEqual(result["jnd"]["level"]["mean"], 6, delta=0.1)
        self.assertAlmostEqual(result["other"]["onset_s"], 0.2, delta=1e-3)
        self.assertLess(result["jnd"]["pitch"]["worst"], 0.1)
        self.assertGreater(result["loudness"]["fraction"], 0.1)

    def test_a_mode_is_missing_and_one_is_new(self):
        result = self.compare([*BOWL[:2], (5200, 60, 0.25, 2)])
        self.assertEqual(len(result["matched"]), 2)
        self.assertAlmostEqual(result["reference_only"][0]["frequency_hz"], 3950, delta=0.5)
        self.assertAlmostEqual(result["other_only"][0]["frequency_hz"], 5200, delta=0.5)
        # From the end of the contact on, 3 ms after the onset.
        energies = [(a * math.exp(-0.003 * d))**2 / (4 * d) for _, d, a, _ in BOWL]
        fraction = sum(energies[:2]) / sum(energies)
        self.assertAlmostEqual(result["reference_matched_energy"], fraction, delta=1e-3)
        self.assertAlmostEqual(result["unmatched_energy_db"], 10 * math.log10(1 - fraction), delta=0.2)
        # Two tones 470 cents apart are the same if one says so.
        self.assertEqual(len(self.compare([*BOWL[:2], (5200, 60, 0.25, 2)], "--widest", "600")
                             ["matched"]), 3)

    def test_two_rates(self):
        reference = self.clip("reference.wav", ringing(BOWL))
        other = self.folder / "other.wav"
        write_wav(other, 96000, ringing(BOWL, rate=96000))  # of 16 bits
        result = run_json("compare", reference, other)
        self.assertEqual(result["sample_rate_hz"], RATE)
        self.assertEqual(result["other"]["sample_rate_hz"], 96000)
        self.assertLess(result["loudness"]["fraction"], 0.1)
        self.assertLess(result["jnd"]["pitch"]["worst"], 0.1)

    def test_a_body_of_a_stiffer_material(self):
        # Every mode goes with the root of Young's modulus, whatever the shape.
        paths = [self.folder / "soft.wav", self.folder / "stiff.wav"]
        for path, modulus in zip(paths, (7.2e10, 1.02 * 7.2e10)):
            run_json("strike", "bowl:radius=60mm,wall=3mm", "--order", "2", "-m",
                     f"youngs_modulus={modulus},poisson_ratio=0.19,density=2700,alpha1=5,"
                     "alpha2=3e-8", "--at", "0.06,0,0.05", "-o", path)
            self.assertGreater(len(read_float_wav(path)), 1000)
        result = run_json("compare", *paths)
        self.assertGreater(len(result["matched"]), 6)
        for mode in result["matched"]:
            self.assertAlmostEqual(mode["pitch_cents"], 600 * math.log2(1.02), delta=0.2)
        self.assertAlmostEqual(result["jnd"]["pitch"]["worst"], 120 * math.log2(1.02), delta=0.04)
        self.assertLess(result["jnd"]["decay"]["worst"], 0.3)
        self.assertGreater(result["reference_matched_energy"], 0.8)

    def test_silence(self):
        reference = self.clip("reference.wav", ringing(BOWL))
        silent = self.clip("silent.wav", numpy.zeros(RATE))
        result = run_json("compare", reference, silent)
        self.assertEqual(result["other"]["nothing"], "silent")
        self.assertEqual(result["reference_matched_energy"], 0)
        self.assertIsNone(result["level_db"])
        self.assertAlmostEqual(result["loudness"]["fraction"], math.sqrt(2), delta=1e-9)
        text = run("compare", reference, silent)
        self.assertEqual(text.returncode, 0, text.stderr)
        self.assertIn("silent.wav: no modes: silent", text.stdout)

    def test_text_is_for_people(self):
        reference = self.clip("reference.wav", ringing(BOWL))
        other = self.clip("other.wav", ringing(changed(BOWL[:2], cents=10)))
        answer = run("compare", reference, other)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        for part in ("reference.wav: ", "d ratio", "only in", "matched modes: 2 of 3 and 2",
                     "JND on average", "sone/Bark rms", "short-time spectra"):
            self.assertIn(part, answer.stdout)

    def test_what_cannot_be_compared(self):
        good = self.clip("reference.wav", ringing(BOWL))
        bad = self.write("bad.wav", "no audio")
        broken = ringing(BOWL)
        broken[4000] = math.nan
        for arguments, told in (((good, bad), "bad.wav"),
                                ((good,), "other"),
                                ((good, good, "--channel", "2"), "has 1 channel, not 2"),
                                ((good, good, "--widest", "-1"), "--widest"),
                                ((good, self.clip("nan.wav", broken)), "nan.wav: ")):
            answer = run("compare", *arguments)
            self.assertEqual(answer.returncode, 2, arguments)
            self.assertIn(told, answer.stderr)


if __name__ == "__main__":
    unittest.main()
