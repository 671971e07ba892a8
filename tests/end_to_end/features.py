"""features: what is heard in recordings, as tables and files, and beside an independent program."""
import csv
import math
import shutil
import struct
import subprocess
import unittest
import wave

import numpy
from program import FolderTest, run, run_json

RATE = 44100
# f [Hz], d [1/s], amplitude, phase
MODES = [(523, 8, 1, 0.3), (1480, 15, 0.7, 1), (3950, 60, 0.8, 2)]
# Two of these overlap: 3 Hz apart, lines 3 to 5 Hz wide.
CLOSE = [(1100, 8, 1, 0.3), (1190, 10, 0.8, 1), (1193, 13, 0.7, 2.5), (1260, 15, 0.9, 4)]


def strike(modes, numbers, seconds=1, onset=0.05, snr=60):
    """Sound and noise of a clip; the noise `snr` dB below the power of the first 100 ms."""
    t = numpy.arange(int(RATE * seconds)) / RATE
    sound = sum(a * numpy.exp(-d * t) * numpy.cos(2 * math.pi * f * t + p) for f, d, a, p in modes)
    power = numpy.mean(sound[:RATE // 10]**2)
    sound = numpy.concatenate([numpy.zeros(int(RATE * onset)), sound])
    return sound, numbers.normal(0, math.sqrt(power * 10**(-snr / 10)), len(sound))


def write_wav(path, *channels):
    """16 bits."""
    frames = numpy.column_stack(channels)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(len(channels))
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(numpy.round(numpy.clip(frames, -1, 1) * 32767).astype("<i2").tobytes())


def write_float_wav(path, samples):
    data = samples.astype("<f4").tobytes()
    head = struct.pack("<HHIIHH", 3, 1, RATE, 4 * RATE, 4, 32)
    path.write_bytes(b"RIFF" + struct.pack("<I", 36 + len(data)) + b"WAVEfmt " +
                     struct.pack("<I", len(head)) + head + b"data" + struct.pack("<I", len(data)) +
                     data)


def read_float_wav(path):
    """Samples of a file of 32-bit floats, which the module wave does not read."""
    data = path.read_bytes()
    at = 12
    while data[at:at + 4] != b"data":
        if data[at:at + 4] == b"fmt ":
            assert struct.unpack("<H", data[at + 8:at + 10])[0] == 3, "not of floats"
        at += 8 + struct.unpack("<I", data[at + 4:at + 8])[0]
    size = struct.unpack("<I", data[at + 4:at + 8])[0]
    return numpy.frombuffer(data[at + 8:at + 8 + size], "<f4")


class Features(FolderTest):
    def setUp(self):
        self.numbers = numpy.random.default_rng(4)

    def clip(self, name, modes=MODES, gain=0.3):
        path = self.folder / name
        sound, noise = strike(modes, self.numbers)
        write_wav(path, gain * (sound + noise))
        return path

    def expect_modes(self, features, modes=MODES, tolerance=0.01):
        self.assertEqual(len(features), len(modes))
        for feature, (f, d, _, _) in zip(features, modes):
            self.assertAlmostEqual(feature["frequency_hz"], f, delta=0.05)
            self.assertAlmostEqual(feature["decay_rate_per_s"] / d, 1, delta=tolerance)

    def test_json(self):
        result = run_json("features", self.clip("one.wav"))
        self.expect_modes(result["features"])
        for name in ("frequency_hz", "decay_rate_per_s", "amplitude", "phase_rad",
                     "frequency_error_hz", "decay_rate_error_per_s", "amplitude_error", "snr_db",
                     "reverberant", "channel"):
            self.assertIn(name, result["features"][0])
        for feature, (_, _, a, p) in zip(result["features"], MODES):
            self.assertAlmostEqual(feature["amplitude"] / (0.3 * a), 1, delta=0.02)
            self.assertAlmostEqual(math.remainder(feature["phase_rad"] - p, 2 * math.pi), 0,
                                   delta=0.6)  # of an onset found to a few samples
            self.assertGreater(feature["snr_db"], 20)
            self.assertFalse(feature["reverberant"])
        self.assertEqual(result["sample_rate_hz"], RATE)
        self.assertAlmostEqual(result["onset_s"], 0.05, delta=1e-3)
        self.assertAlmostEqual(result["begin_s"] - result["onset_s"], 0.003, delta=1e-4)
        self.assertGreater(result["energy_explained"], 0.999)
        self.assertEqual(result["clipped_samples"], 0)
        self.assertEqual(result["hums"], [])
        self.assertEqual(result["nothing"], "")
        self.assertEqual(len(result["files"]), 1)
        self.assertGreater(result["timing"]["features_s"], 0)

    def test_text_is_for_people(self):
        answer = run("features", self.clip("text.wav"))
        self.assertEqual(answer.returncode, 0, answer.stderr)
        for part in ("text.wav: 3 modes", "% of the energy", "f [Hz]", "SNR dB", "1480.0"):
            self.assertIn(part, answer.stdout)

    def test_stereo_of_two_gains_and_noises(self):
        path = self.folder / "stereo.wav"
        sound, noise = strike(MODES, self.numbers, snr=50)
        other = numpy.random.default_rng(5).permutation(noise)
        write_wav(path, 0.3 * (sound + noise), 0.12 * sound + 0.3 * other)
        both = run_json("features", path)["features"]
        self.expect_modes(both, tolerance=0.02)
        write_wav(path, 0.3 * (sound + noise))
        one = run_json("features", path)["features"]
        for two_channels, channel in zip(both, one):
            self.assertLess(two_channels["decay_rate_error_per_s"],
                            channel["decay_rate_error_per_s"])
            self.assertEqual(two_channels["channel"], 1)  # the louder

    def test_floats_above_full_scale(self):
        path = self.folder / "float.wav"
        sound, noise = strike(MODES, self.numbers)
        write_float_wav(path, 5 * (sound + noise))
        result = run_json("features", path)
        self.expect_modes(result["features"])
        self.assertEqual(result["clipped_samples"], 0)
        self.assertAlmostEqual(result["features"][0]["amplitude"], 5, delta=0.1)

    def test_table_is_what_fit_reads(self):
        one, two = self.clip("with, comma.wav"), self.clip("two.wav", CLOSE)
        table = self.folder / "table.csv"
        result = run_json("features", one, two, "--csv", table)
        with open(table, newline="", encoding="utf-8") as text:
            rows = list(csv.DictReader(text))
        heard = [(file["file"], feature) for file in result["files"]
                 for feature in file["features"]]
        self.assertEqual(len(rows), 7)
        for row, (file, feature) in zip(rows, heard):
            self.assertEqual(row["file"], file)
            self.assertAlmostEqual(float(row["frequency_hz"]) / feature["frequency_hz"], 1, 7)
            self.assertAlmostEqual(float(row["decay_rate_per_s"]) / feature["decay_rate_per_s"], 1,
                                   7)
        fit = run_json("fit", "--features", table)
        self.assertEqual(fit["points"], 7)
        for alpha in ("alpha1", "alpha2"):
            self.assertTrue(math.isfinite(fit["parameters"][alpha]))

    def test_residual(self):
        path, left = self.folder / "left.wav", self.folder / "residual.wav"
        sound, noise = strike(MODES, self.numbers, snr=40)
        write_wav(path, 0.3 * (sound + noise))
        result = run_json("features", path, "--residual", left)
        residual = read_float_wav(left)
        self.assertAlmostEqual(len(residual), (result["end_s"] - result["begin_s"]) * RATE, delta=1)
        begin = round(result["begin_s"] * RATE)
        truth = 0.3 * noise[begin:begin + len(residual)]
        # Three modes take 12 of 44,000 degrees of freedom with them.
        self.assertLess(numpy.std(residual - truth), 0.05 * numpy.std(truth))
        answer = run("features", path, path, "--residual", left)
        self.assertEqual(answer.returncode, 2)
        self.assertIn("--residual takes one recording", answer.stderr)

    def test_one_bad_file_among_good_ones(self):
        good, also = self.clip("good.wav"), self.clip("also.wav", CLOSE)
        bad = self.write("bad.wav", "no audio")
        silent = self.folder / "silent.wav"
        write_wav(silent, numpy.zeros(RATE))
        answer = run("features", good, bad, silent, also)
        self.assertEqual(answer.returncode, 3, answer.stderr)
        for part in ("good.wav: 3 modes", "bad.wav: 0 modes: ", "silent.wav: 0 modes: silent",
                     "also.wav: 4 modes"):
            self.assertIn(part, answer.stdout)
        # Alone it is an error, and silence is none.
        self.assertEqual(run("features", bad).returncode, 2)
        self.assertEqual(run("features", silent).returncode, 0)

    def test_rt60_marks_what_decays_faster_than_the_room(self):
        result = run_json("features", self.clip("room.wav"), "--rt60", "0.5 s")  # 13.8 1/s
        self.assertEqual([f["reverberant"] for f in result["features"]], [False, True, True])
        # By octave from 125 Hz on, the last one for all above.
        result = run_json("features", self.clip("room.wav"), "--rt60", "0.5 s, 0.5 s, 1 s, 0.2 s")
        self.assertEqual([f["reverberant"] for f in result["features"]], [True, False, True])

    def test_weak_modes_are_left_out(self):
        path = self.clip("weak.wav", [*MODES, (2600, 10, 0.003, 1)])
        frequencies = lambda *options: [
            f["frequency_hz"] for f in run_json("features", path, *options)["features"]]
        self.assertEqual(len(frequencies("--min-level", "-60")), 4)
        strong = frequencies()
        self.assertEqual(len(strong), 3)
        self.assertFalse(any(2500 < f < 2700 for f in strong))

    def test_peaks_of_spectrograms(self):
        # It ends where 99 % of the power is explained: no mode may be weak or short.
        modes = [*MODES[:2], (3950, 20, 1, 2)]
        path = self.clip("peaks.wav", modes)
        features = run_json("features", path, "--method", "peaks")["features"]
        self.assertEqual(len(features), 3)
        for feature, (f, d, _, _) in zip(features, modes):
            self.assertAlmostEqual(feature["frequency_hz"], f, delta=0.2)
            self.assertAlmostEqual(feature["decay_rate_per_s"] / d, 1, delta=0.03)
            self.assertIsNone(feature["decay_rate_error_per_s"])

    def test_options_out_of_range(self):
        path = self.clip("options.wav")
        for options in (["--min-frequency", "5 kHz", "--max-frequency", "1 kHz"],
                        ["--rt60", "-1 s"], ["--rt60", "1 s,,2 s"], ["--onset", "1 m"], ["--method", "guess"]):
            answer = run("features", path, *options)
            self.assertEqual(answer.returncode, 2, options)
            self.assertTrue(answer.stderr)

    @unittest.skipUnless(shutil.which("harminv"), "harminv is not installed (./scripts/setup)")
    def test_as_harminv_has_it(self):
        path = self.clip("close.wav", CLOSE)
        result = run_json("features", path)
        with wave.open(str(path)) as file:
            samples = numpy.frombuffer(file.readframes(file.getnframes()), "<i2") / 32768
        begin = round(result["begin_s"] * RATE)
        # Filter diagonalisation: other mathematics, and nothing of it is in the program.
        text = "\n".join(f"{sample:.9g}" for sample in samples[begin:begin + RATE // 2])
        answer = subprocess.run(["harminv", "-t", repr(1 / RATE), "1050-1310"], input=text,
                                capture_output=True, text=True, check=True, timeout=60)
        rows = list(csv.DictReader(answer.stdout.splitlines(), skipinitialspace=True))
        self.assertEqual(len(result["features"]), len(CLOSE))
        for feature, (f, _, _, _) in zip(result["features"], CLOSE):
            its = min(rows, key=lambda row: abs(float(row["frequency"]) - f))
            self.assertAlmostEqual(feature["frequency_hz"], float(its["frequency"]), delta=0.02)
            self.assertAlmostEqual(
                feature["decay_rate_per_s"] / float(its["decay constant"]), 1, delta=0.02)


if __name__ == "__main__":
    unittest.main()
