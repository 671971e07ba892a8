"""Recordings as people make them, drawn from formulas: formats, bounces, double hits, clipping, automatic
gain, gates, lost samples. Each must give its modes and no other, and the remark that belongs to it."""
import ctypes
import ctypes.util
import math
import struct
import unittest
import wave

import numpy
from program import TIMEOUT_FACTOR, FolderTest, processor_seconds, run_json

RATE = 22050
# f [Hz], d [1/s], amplitude
BAR = [(523.4, 6, 0.37), (1441.7, 11, 0.27), (2826.3, 19, 0.2), (4671.9, 33, 0.12)]
PLATE = [(611.3, 7, 0.3), (1530.2, 12, 0.25), (3122.9, 25, 0.2), (5210.4, 45, 0.12)]
BELL = [(130.8, 0.085, 0.2), (261.9, 0.14, 0.16), (311.4, 0.19, 0.3), (392.9, 0.42, 0.08),
        (523.6, 0.75, 0.4), (784.2, 1.6, 0.22), (1047.5, 2.9, 0.15)]
ONSET = 0.02


def ring(modes, seconds, hits=((0, 1),), rate=RATE):
    """Struck at (time after the onset, level) each, by a force of three samples."""
    count = round(seconds * rate)
    sound = numpy.zeros(count)
    t = numpy.arange(count) / rate
    for at, level in hits:
        first = round((ONSET + at) * rate)
        if first < count:
            since = t[:count - first]
            sound[first:] += level * sum(a * numpy.exp(-d * since) * numpy.sin(2 * math.pi * f * since)
                                         for f, d, a in modes)
    return numpy.convolve(sound, [0.25, 0.5, 0.25])[:count]


def write_pcm(path, *channels, bits=16, rate=RATE, dither=None):
    """Full scale is 1; `dither` draws numbers, without them values are rounded."""
    frames = numpy.column_stack(channels) * (2**(bits - 1) - 1)
    if dither is not None:
        frames = frames + dither.uniform(-0.5, 0.5, frames.shape) + dither.uniform(-0.5, 0.5, frames.shape)
    limit = 2**(bits - 1)
    whole = numpy.clip(numpy.round(frames), -limit, limit - 1).astype("<i4")
    data = (whole + 128).astype("u1") if bits == 8 else whole.reshape(-1, 1).view("u1")[:, :bits // 8]
    with wave.open(str(path), "wb") as file:
        file.setnchannels(len(channels))
        file.setsampwidth(bits // 8)
        file.setframerate(rate)
        file.writeframes(data.tobytes())


def write_floats(path, samples, rate=RATE):
    """32 bits."""
    data = samples.astype("<f4").tobytes()
    head = struct.pack("<HHIIHH", 3, 1, rate, 4 * rate, 4, 32)
    path.write_bytes(b"RIFF" + struct.pack("<I", 36 + len(data)) + b"WAVEfmt " + struct.pack("<I", len(head)) +
                     head + b"data" + struct.pack("<I", len(data)) + data)


def write_by_libsndfile(path, samples, kind, rate=RATE):
    """kind: major format and encoding, as sndfile.h has them; False where the library cannot."""
    class Info(ctypes.Structure):
        _fields_ = [("frames", ctypes.c_int64), ("samplerate", ctypes.c_int), ("channels", ctypes.c_int),
                    ("format", ctypes.c_int), ("sections", ctypes.c_int), ("seekable", ctypes.c_int)]
    name = ctypes.util.find_library("sndfile")
    if not name:
        return False
    library = ctypes.CDLL(name)
    library.sf_open.restype = ctypes.c_void_p
    library.sf_writef_double.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64]
    library.sf_close.argtypes = [ctypes.c_void_p]
    info = Info(0, rate, 1, kind, 0, 0)
    file = library.sf_open(str(path).encode(), 0x20, ctypes.byref(info))
    if not file:
        return False
    data = numpy.ascontiguousarray(samples, float)
    library.sf_writef_double(file, data.ctypes.data, len(data))
    library.sf_close(file)
    return True


class Cases(FolderTest):
    def setUp(self):
        self.numbers = numpy.random.default_rng(7)

    def pcm(self, *channels, **options):
        path = self.folder / f"{self.id().split('.')[-1]}.wav"
        write_pcm(path, *channels, dither=self.numbers, **options)
        return path

    def expect(self, path, modes, *options, decay=0.02, remark=None):
        """Exactly these modes, and the remark or none at all."""
        result = run_json("features", path, *options)
        found = [(round(f["frequency_hz"], 2), round(f["decay_rate_per_s"], 3)) for f in result["features"]]
        self.assertEqual(len(found), len(modes), (found, result["remarks"], result["nothing"]))
        for (f, d), mode in zip(found, sorted(modes)):
            self.assertAlmostEqual(f, mode[0], delta=0.5)
            self.assertAlmostEqual(d / mode[1], 1, delta=decay, msg=f"{mode[0]} Hz: {d}")
        if remark:
            self.assertTrue(any(remark in text for text in result["remarks"]), result["remarks"])
        else:
            self.assertEqual(result["remarks"], [])
        return result


class Formats(Cases):
    def test_bits(self):
        for bits in (8, 16, 24, 32):
            with self.subTest(bits=bits):
                self.expect(self.pcm(ring(BAR, 0.7), bits=bits), BAR)

    def test_eight_bits_without_dither(self):
        path = self.folder / "rounded.wav"
        write_pcm(path, ring(PLATE, 0.9), bits=8)
        self.expect(path, PLATE)

    def test_24_bits_at_83_db_below_full_scale(self):
        sound = ring(PLATE, 0.9)
        self.expect(self.pcm(10**(-83 / 20) * sound / numpy.max(abs(sound)), bits=24), PLATE)

    def test_floats(self):
        path = self.folder / "floats.wav"
        write_floats(path, ring(BAR, 0.7) + self.numbers.normal(0, 1e-5, round(0.7 * RATE)))
        self.expect(path, BAR)

    def test_a_law(self):
        path = self.folder / "a-law.wav"
        # Noise 54 dB below the peak: steps of A-law without any are tones.
        sound = ring(BAR, 0.7) + self.numbers.normal(0, 0.002, round(0.7 * RATE))
        if not write_by_libsndfile(path, sound, 0x010011):
            self.skipTest("libsndfile cannot be loaded")
        self.expect(path, BAR)

    def test_ogg(self):
        path = self.folder / "vorbis.ogg"
        if not write_by_libsndfile(path, ring(BAR, 0.7), 0x200060):
            self.skipTest("libsndfile cannot be loaded, or has no Vorbis")
        result = run_json("features", path)
        self.assertEqual(len(result["features"]), len(BAR), [f["frequency_hz"] for f in result["features"]])
        for feature, (f, d, _) in zip(result["features"], BAR):
            self.assertAlmostEqual(feature["frequency_hz"], f, delta=0.5)
            self.assertAlmostEqual(feature["decay_rate_per_s"] / d, 1, delta=0.05)


class Strikes(Cases):
    def test_double_hits(self):
        for after, level in ((0.008, 1), (0.012, 1), (0.025, 0.5), (0.045, 1)):
            with self.subTest(after=after):
                path = self.pcm(ring(PLATE, 0.94, [(0, 1), (after, level)]))
                self.expect(path, PLATE, decay=0.05, remark="--onset takes another")

    def test_bounces_of_a_ball(self):
        hits = [(0, 1), (0.21, 0.6), (0.38, 0.4), (0.52, 0.25), (0.635, 0.15)]
        self.expect(self.pcm(ring(PLATE, 0.9, hits)), PLATE, remark="another strike or lost samples at 0.230 s")

    def test_soft_then_loud(self):
        for after in (0.04, 0.25):
            with self.subTest(after=after):
                path = self.pcm(ring(PLATE, 0.9, [(0, 0.2), (after, 1)]))
                result = self.expect(path, PLATE, remark="0.020 s")
                self.assertAlmostEqual(result["onset_s"], ONSET + after, delta=0.001)

    def test_the_second_of_three_strikes(self):
        path = self.pcm(ring(PLATE, 1.2, [(0, 1), (0.5, 0.5), (0.8, 0.7)]))
        result = self.expect(path, PLATE, "--onset", "0.52", remark="another strike")
        self.assertAlmostEqual(result["onset_s"], 0.52, delta=0.001)
        self.assertLess(result["end_s"], 0.82)

    def test_two_objects_at_once(self):
        both = [*BAR, *PLATE]
        self.expect(self.pcm(0.5 * (ring(BAR, 1) + ring(PLATE, 1))), both)

    def test_a_striker_that_rings_as_long(self):
        """A fork at the object's own second mode, 3 Hz beside it, and above all of its others."""
        fork = [(1527.2, 9, 0.15), (6271.0, 14, 0.1)]
        self.expect(self.pcm(0.8 * (ring(PLATE, 1) + ring(fork, 1))), [*PLATE, *fork])

    def test_talk_before_the_strike(self):
        sound = ring(PLATE, 1.32, [(0.6, 1)])
        talk = numpy.zeros(len(sound))
        t = numpy.arange(round(0.6 * RATE)) / RATE
        # Syllables: a buzz of 120 Hz under slow envelopes, and breath.
        buzz = sum(math.cos(k) / k * numpy.sin(2 * math.pi * 120 * k * (t + 0.002 * numpy.sin(15 * t)))
                   for k in range(1, 25))
        envelope = numpy.maximum(0, numpy.sin(2 * math.pi * 5 * t))
        talk[:len(t)] = 0.08 * envelope * (buzz + 0.3 * self.numbers.normal(0, 1, len(t)))
        result = self.expect(self.pcm(sound + talk), PLATE, decay=0.05, remark="struck before")
        self.assertAlmostEqual(result["onset_s"], 0.62, delta=0.002)


class Damage(Cases):
    def test_clipped_then_turned_down(self):
        sound = 2 * ring(PLATE, 0.9)
        path = self.folder / "clipped.wav"
        write_floats(path, 0.3 * numpy.clip(sound, -0.95, 0.95) + self.numbers.normal(0, 1e-5, len(sound)) *
                           (abs(sound) < 0.95))
        result = self.expect(path, PLATE, decay=0.05, remark="clipped")
        self.assertGreater(result["clipped_samples"], 3)

    def test_clipped_then_resampled(self):
        """44.1 to 24 kHz by a windowed sinc: tops are neither equal nor at full scale any more."""
        sound = numpy.clip(2 * ring(PLATE, 0.94, rate=44100), -0.95, 0.95)
        place = numpy.arange(round(0.92 * 24000)) * 44100 / 24000
        first = numpy.floor(place).astype(int) - 31
        taps = numpy.arange(64)
        padded = numpy.concatenate([numpy.zeros(32), sound, numpy.zeros(32)])
        distance = first[:, None] + taps - place[:, None]
        cut = 24000 / 44100
        kernel = cut * numpy.sinc(cut * distance) * numpy.cos(numpy.pi * distance / 66)**2
        resampled = (kernel * padded[first[:, None] + taps + 32]).sum(axis=1)
        self.expect(self.pcm(0.5 * resampled, rate=24000), PLATE, decay=0.05, remark="tops are limited")

    def test_automatic_gain(self):
        sound = ring(PLATE, 0.92)
        t = numpy.maximum(numpy.arange(len(sound)) / RATE - ONSET, 0)
        # 20 dB a second: 10^t, which takes ln 10 = 2.303 from every decay rate.
        self.expect(self.pcm(0.7 * sound * 10**t), [(f, d - math.log(10), a) for f, d, a in PLATE])

    def test_fade_out(self):
        sound = ring(PLATE, 0.92)
        left = numpy.clip((len(sound) - numpy.arange(len(sound))) / (0.4 * RATE), 0, 1)
        self.expect(self.pcm(sound * left), PLATE, decay=0.05)

    def test_noise_gate(self):
        sound = ring(PLATE, 0.92)
        path = self.folder / "gate.wav"
        sound[round(0.541 * RATE):] = 0
        write_pcm(path, sound)
        self.expect(path, PLATE, remark="0.541 s")

    def test_one_dead_channel(self):
        path = self.folder / "dead.wav"
        sound = ring(PLATE, 0.7)
        write_pcm(path, sound, numpy.zeros(len(sound)))
        self.expect(path, PLATE)

    def test_cut_before_it_has_decayed(self):
        self.expect(self.pcm(ring(PLATE, 0.1)), PLATE)

    def test_a_dropout(self):
        sound = ring(PLATE, 0.9)
        sound[round(0.3 * RATE):round(0.32 * RATE)] = 0
        path = self.folder / "dropout.wav"
        write_pcm(path, sound)
        self.expect(path, PLATE, remark="0.300 s")

    def test_lost_samples(self):
        sound = ring(PLATE, 0.9)
        at = round(0.25 * RATE)
        path = self.pcm(numpy.concatenate([sound[:at], sound[at + 77:]]))
        self.expect(path, PLATE, remark="lost samples at 0.250 s")

    def test_telephone(self):
        """8 kHz, a band of 300 to 3,400 Hz, A-law."""
        sound = ring(PLATE[:3], 0.7, rate=8000) + self.numbers.normal(0, 0.001, 5600)
        passed = numpy.zeros(len(sound))
        for k in range(1, len(sound)):
            passed[k] = 0.8 * (passed[k - 1] + sound[k] - sound[k - 1])  # from 300 Hz on
        path = self.folder / "telephone.wav"
        if not write_by_libsndfile(path, passed, 0x010011, 8000):
            self.skipTest("libsndfile cannot be loaded")
        self.expect(path, PLATE[:3], decay=0.05)

    def test_silence_with_one_click(self):
        sound = numpy.zeros(RATE)
        sound[RATE // 2] = 0.5
        for path in (self.pcm(sound), self.folder / "exact.wav"):
            if path.name == "exact.wav":
                write_pcm(path, sound)
            result = run_json("features", path)
            self.assertEqual(result["features"], [])
            self.assertTrue(result["nothing"])


class Bells(Cases):
    def test_eight_seconds_of_a_big_bell(self):
        path = self.pcm(0.6 * ring(BELL, 8, rate=8000), rate=8000)
        self.expect(path, BELL, remark="kept as modes")

    def test_a_minute_of_a_bell(self):
        path = self.pcm(0.6 * ring(BELL, 60, rate=44100), rate=44100)
        before = processor_seconds()
        self.expect(path, BELL, remark="kept as modes")
        used = processor_seconds() - before
        print(f"a minute of a bell: {used:.2f} s of processor time", flush=True)
        # 3 s on a quiet machine.
        self.assertLess(used, 9 * TIMEOUT_FACTOR)


if __name__ == "__main__":
    unittest.main()
