"""`carillon export-faust`: programs compiled by Faust and g++, against the sounds of `carillon
strike`, and against the closed form of their own numbers."""
import pathlib
import re
import shutil
import subprocess
import unittest

import msh_files
import numpy
from program import FolderTest, run, run_json

DRIVER = pathlib.Path(__file__).with_name("faust_driver.cpp.in")
POLYPHONIC = pathlib.Path(__file__).with_name("faust_polyphonic.cpp.in")
BLOCK = ["block:length=240mm,width=90mm,height=25mm", "--order", "2", "--element-size", "40 mm"]
AT = ["--at", "0.12,0.02,0.018"]
STRIKE = ["0:gate=1", "300:gate=0"]
SECONDS = 0.3


def read_wav(path):
    content = path.read_bytes()
    begin = content.index(b"data")
    size = int.from_bytes(content[begin + 4:begin + 8], "little")
    return numpy.frombuffer(content[begin + 8:begin + 8 + size], "<f4").astype(float)


def level(values, reference):
    """Largest magnitude over that of a reference [dB]."""
    return 20 * numpy.log10(max(numpy.abs(values).max(), 1e-300) / numpy.abs(reference).max())


def numbers_of(program, table):
    """Of a table of a program."""
    (body,) = re.findall(rf"^{table} = waveform{{\n(.*?)}};", program, re.M | re.S)
    return numpy.array([float(number) for number in re.sub(r"//.*", "", body).split(",")])


def modes_of(program):
    """(lambda, gains at the vertices) of the modes of a program."""
    eigenvalues = numbers_of(program, "eigenvalues")
    gains = numbers_of(program, "gains").reshape(-1, len(eigenvalues))
    return list(zip(eigenvalues.tolist(), gains.T.tolist()))


def peak_frequency(sound, rate, near):
    """Of the strongest partial within a fourth of a frequency [Hz]: the top of a parabola through the
    logarithms of a spectrum that a Gaussian window makes one."""
    count = len(sound)
    window = numpy.exp(-0.5 * ((numpy.arange(count) - count / 2) / (count / 12))**2)
    spectrum = numpy.log(numpy.abs(numpy.fft.rfft(sound * window)))
    low, high = int(0.75 * near * count / rate), int(near / 0.75 * count / rate)
    top = low + int(numpy.argmax(spectrum[low:high]))
    assert low < top < high - 1, "no partial"
    left, middle, right = spectrum[top - 1:top + 2]
    return (top + 0.5 * (left - right) / (left - 2 * middle + right)) * rate / count


@unittest.skipUnless(shutil.which("faust") and shutil.which("g++"), "no faust or no g++")
class Instruments(FolderTest):
    def export(self, name, *arguments):
        path = self.folder / f"{name}.dsp"
        run_json("export-faust", *arguments, "-o", path)
        return path

    def compile(self, program, options=("-double",), real="double"):
        binary = program.with_suffix("." + real)
        code = program.with_suffix(f".{real}.cpp")
        subprocess.run(["faust", "-lang", "cpp", *options, "-a", DRIVER, "-o", code, program],
                       check=True, cwd=self.folder, timeout=200)
        subprocess.run(["g++", "-O1", f"-DFAUSTFLOAT={real}", code, "-o", binary], check=True,
                       timeout=200)
        return binary

    def play(self, binary, *events, rate=44100, seconds=SECONDS, late=None):
        """What a program plays, from when its answer to the first sample is due."""
        if late is None:
            late = len(modes_of(binary.with_suffix(".dsp").read_text()))
        answer = subprocess.run([binary, str(rate), str(round(rate * seconds) + late), *events],
                                check=True, capture_output=True, timeout=100)
        played = numpy.frombuffer(answer.stdout)
        self.assertEqual(numpy.abs(played[:late]).max(initial=0), 0)
        return played[late:]

    def strike(self, *arguments, rate=44100):
        path = self.folder / "strike.wav"
        run_json("strike", *arguments, "--max-frequency", "20 kHz", "--sample-rate", rate,
                 "--seconds", f"{SECONDS} s", "-o", path)
        return read_wav(path)

    def expect_equal(self, played, sound, decibels=-120):
        self.assertEqual(len(played), len(sound))
        self.assertGreater(numpy.abs(sound).max(), 0)
        self.assertLess(level(played - sound, sound), decibels)

    def test_sounds_as_strike_does(self):
        body = [*BLOCK, "-m", "ceramic"]
        binary = self.compile(self.export("default", *body, *AT, "--at", "0.07,0.05,0.025"))
        for rate in (22050, 44100, 96000):  # at the first, not all modes lie below half of it
            self.expect_equal(self.play(binary, *STRIKE, rate=rate),
                              self.strike(*body, *AT, rate=rate))
        self.expect_equal(self.play(binary, "0:vertex=1", *STRIKE),
                          self.strike(*body, "--at", "0.07,0.05,0.025"))
        # A contact within a sample, of whole samples, and longer than a mode's period.
        for contact in ("0.01 ms", "1 ms", "2.37 ms"):
            self.expect_equal(
                self.play(binary, f"0:contact time={contact.split()[0]}", "0:impulse=0.05",
                          "0:level=-20", *STRIKE),
                self.strike(*body, *AT, "--contact-time", contact, "--impulse", "0.05 N s",
                            "--gain", "0.1"))

    def test_a_note_has_its_pitch(self):
        """freq, gain and gate, as polyphonic players set them."""
        self.export("notes", *BLOCK, "-m", "steel", *AT)
        binary = self.compile(self.folder / "notes.dsp")
        for freq in (220, 440.5, 1234.5):
            played = self.play(binary, f"0:freq={freq}", "0:contact time=1", "0:t60_factor=5", *STRIKE,
                               seconds=2)
            self.assertLess(abs(1200 * numpy.log2(peak_frequency(played, 44100, freq) / freq)), 0.5)
            size = self.play(binary, f"0:freq={freq}", "0:contact time=1", "0:t60_factor=5",
                             "0:size=2", *STRIKE, seconds=2)
            self.assertLess(abs(1200 * numpy.log2(2 * peak_frequency(size, 44100, freq / 2) / freq)), 0.5)
        loud = self.play(binary, *STRIKE)
        self.expect_equal(self.play(binary, "0:gain=0.25", *STRIKE), 0.25 * loud)
        # A gate that stays open strikes once, one that opens again strikes again, as it then is.
        self.expect_equal(self.play(binary, "0:gate=1"), loud)
        twice = self.play(binary, "0:gate=1", "30:gate=0", "1000:gain=0.5", "1000:gate=1")
        late = numpy.concatenate([numpy.zeros(1000), loud[:-1000]])
        self.expect_equal(twice, loud + 0.5 * late)

    def test_pitch_is_that_of_a_stiffer_material(self):
        """And t60_factor and hardness are what they are called."""
        material = "youngs_modulus=%g,poisson_ratio=0.2,density=2500,alpha1=%g,alpha2=%g"
        program = self.export("pitch", *BLOCK, "-m", material % (7e10, 6, 1e-7), *AT)
        own = float(re.search(r"freq/(\S+?)/size", program.read_text())[1])
        binary = self.compile(program)
        count = ("--max-modes", str(len(modes_of(program.read_text()))))
        self.expect_equal(
            self.play(binary, f"0:freq={0.8 * own!r}", *STRIKE),
            self.strike(*BLOCK, "-m", material % (0.64 * 7e10, 6, 1e-7), *AT, *count), -100)
        self.expect_equal(self.play(binary, "0:t60_factor=2.5", *STRIKE),
                          self.strike(*BLOCK, "-m", material % (7e10, 6 / 2.5, 4e-8), *AT))
        # Hertz: the contact of a body of E* lasts as E*^(-2/5).
        self.expect_equal(self.play(binary, "0:hardness=0.1", *STRIKE),
                          self.strike(*BLOCK, "-m", material % (7e10, 6, 1e-7), *AT,
                                      "--contact-time", f"{0.2 * 10**0.4!r} ms"))

    def test_names_the_mode_of_its_pitch(self):
        found = run_json("modes", *BLOCK, "-m", "steel")["modes"]
        export = lambda *more: run_json("export-faust", *BLOCK, "-m", "steel", *AT, *more, "-o",
                                        self.folder / "named.dsp")
        self.assertAlmostEqual(export("--pitch-mode", "3")["pitch_hz"], found[2]["frequency_hz"], 6)
        # On the middle plane of the bending: the first mode that is heard there is another one.
        body = [*BLOCK, "-m", "steel", "--at", "0,0,0.0125", "-o", self.folder / "middle.dsp"]
        pitch = run_json("export-faust", *body)["pitch_hz"]
        gains = [abs(gains[0]) for _, gains in modes_of((self.folder / "middle.dsp").read_text())]
        first = next(i for i, gain in enumerate(gains) if gain > 0.01 * max(gains))
        self.assertAlmostEqual(pitch, found[first]["frequency_hz"], 6)

    def test_is_played_by_the_polyphonic_architecture(self):
        """Faust's own: a key is a frequency, a velocity a gain."""
        program = self.export("keys", *BLOCK, "-m", "steel", *AT)
        late = len(modes_of(program.read_text()))
        code, binary = self.folder / "keys.cpp", self.folder / "keys"
        subprocess.run(["faust", "-lang", "cpp", "-double", "-a", POLYPHONIC, "-o", code, program],
                       check=True, timeout=100)
        subprocess.run(["g++", "-O1", "-DFAUSTFLOAT=double", code, "-o", binary], check=True,
                       timeout=200)
        played = self.play(binary, "64:57=100", "6400:69=50", late=0)
        single = self.compile(program)
        expected = [
            numpy.concatenate([numpy.zeros(at + late), self.play(
                single, f"0:freq={freq}", f"0:gain={velocity / 127!r}", *STRIKE)])[:len(played)]
            for at, freq, velocity in ((64, 220, 100), (6400, 440, 50))]
        self.expect_equal(played, sum(expected))

    def test_compiles_quickly(self):
        """Of each mode of a program Faust writes few lines: no solution over a step, which is long."""
        lines = []
        for modes in ("10", "20"):
            program = self.export(f"lines{modes}", *BLOCK, "-m", "sterling_plastic", "--max-modes",
                                  modes)
            code = program.with_suffix(".cpp")
            subprocess.run(["faust", "-lang", "cpp", "-o", code, program], check=True, timeout=100)
            lines.append(len(code.read_text().splitlines()))
        self.assertLess((lines[1] - lines[0]) / 10, 20)

    def test_draws_the_point_that_strike_draws(self):
        body = [*BLOCK, "-m", "steel", "--seed", "7"]
        self.expect_equal(self.play(self.compile(self.export("drawn", *body)), *STRIKE),
                          self.strike(*body))

    def test_is_a_resonator_for_other_programs(self):
        """One sample as high as the rate is an ideal impulse; responses add up."""
        body = [*BLOCK, "-m", "glass", *AT]
        program = self.export("glass", *body)
        sound = self.strike(*body, "--contact-time", "0", "--impulse", "1 N s")
        self.expect_equal(self.play(self.compile(program), "0:input=44100"), sound)
        other = self.write("other.dsp", 'process = component("glass.dsp").object(0);\n')
        late = len(modes_of(program.read_text()))
        played = self.play(self.compile(other), "0:input=44100", "100:input=-22050", late=late)
        twice = sound - 0.5 * numpy.concatenate([numpy.zeros(100), sound[:-100]])
        self.expect_equal(played, twice)

    def test_size_and_damping_are_those_of_the_body(self):
        alphas = "youngs_modulus=7e10,poisson_ratio=0.2,density=2500,alpha1=%g,alpha2=%g"
        binary = self.compile(self.export("sizes", *BLOCK, "-m", alphas % (6, 1e-7), *AT))
        double = ["block:length=480mm,width=180mm,height=50mm", "--order", "2", "--element-size",
                  "80 mm", "-m", alphas % (6, 1e-7), "--at", "0.24,0.04,0.036"]
        # Of the larger object more modes lie in the band; the program has those of the smaller.
        count = len(modes_of((self.folder / "sizes.dsp").read_text()))
        self.expect_equal(self.play(binary, "0:size=2", *STRIKE),
                          self.strike(*double, "--max-modes", str(count)), -100)
        # Light, heavy and above critical damping: a mode of 2 pi 15 kHz has d = 1.3e5 1/s.
        for alpha1, alpha2 in ((0.06, 1e-9), (600, 1e-6), (6, 3e-5)):
            self.expect_equal(
                self.play(binary, f"0:alpha1={alpha1}", f"0:alpha2={1e9 * alpha2}", *STRIKE),
                self.strike(*BLOCK, "-m", alphas % (alpha1, alpha2), *AT))

    def test_other_damping(self):
        elastic = "youngs_modulus=7e10,poisson_ratio=0.2,density=2500,damping="
        for number, damping in enumerate(("hybrid,alpha1=3.9,alpha2=1e-8,alpha3=1.03",
                                          "power,alpha1=0.003,alpha2=0.45",
                                          "caughey,alpha1=5,alpha2=1e-7,alpha3=2e-18",
                                          "6 + 1e-7*lambda + 0.001*sqrt(lambda)")):
            body = [*BLOCK, "-m", elastic + damping, *AT]
            self.expect_equal(self.play(self.compile(self.export(f"damping{number}", *body)),
                                        *STRIKE), self.strike(*body))

    def test_body_of_two_materials(self):
        bar = self.write("bar.msh", msh_files.msh_4(*msh_files.two_part_bar()))
        for number, right in enumerate(("wood", "sterling_plastic_hybrid")):
            body = [bar, "-m", f"left=steel,right={right}", "--at", "0,0.01,0.02"]
            self.expect_equal(self.play(self.compile(self.export(f"two{number}", *body)), *STRIKE),
                              self.strike(*body))

    def test_single_precision(self):
        body = [*BLOCK, "-m", "ceramic", *AT]
        binary = self.compile(self.export("single", *body), (), "float")
        self.expect_equal(self.play(binary, *STRIKE), self.strike(*body), -70)

    def test_no_setting_makes_it_grow(self):
        """A bank at rest stays so; one that rings loses energy, whatever is set meanwhile."""
        program = self.export("extremes", *BLOCK, "-m", "ceramic", "--points", "3")
        labels = re.findall(r'(?:hslider|nentry)\("(?:v:\w+/)?(?:\[\d\])?([^"\[]*).*?", (\S+), '
                            r'(\S+), (\S+), ', program.read_text())
        self.assertEqual({label[0] for label in labels},
                         {"freq", "gain", "contact time", "hardness", "impulse", "vertex", "size",
                          "alpha1", "alpha2", "t60_factor", "level"})
        for binary in (self.compile(program), self.compile(program, (), "float")):
            self.assertEqual(numpy.abs(self.play(binary)).max(), 0)
            for label, _, low, high in labels:
                for value in (low, high, 0, 1e9):
                    played = self.play(binary, f"0:{label}={value}", *STRIKE)
                    self.assertTrue(numpy.isfinite(played).all(), (label, value))
            moved = [f"{sample}:{label}={(low, high)[(sample // 64 + number) % 2]}"
                     for sample in range(320, 6000, 64)
                     for number, (label, _, low, high) in enumerate(labels)
                     if label in ("size", "alpha1", "alpha2", "freq", "t60_factor")]
            played = numpy.abs(self.play(binary, *STRIKE, *moved))
            # The state's norm is bounded by that after the strike: the sum of all modes' amplitudes.
            bound = 0.02 * sum(max(map(abs, gains)) for _, gains in modes_of(program.read_text()))
            self.assertLess(played[320:].max(), bound)
            self.assertLess(played[6000:].max(), played[:300].max())

    def test_loudest_modes(self):
        body = [*BLOCK, "-m", "ceramic", *AT]
        everything = modes_of(self.export("all", *body).read_text())
        kept = modes_of(self.export("loudest", *body, "--loudest", "5").read_text())
        omega = numpy.sqrt([one[0] for one in everything])
        decay = (6 + 1e-7 * omega**2) / 2
        # Fourier transform of (1 - cos(2 pi t / T)) / T over 0 to T.
        x = omega * 2e-4 / (2 * numpy.pi)
        force = numpy.sinc(x) / (1 - x**2)
        energy = ((numpy.array([one[1][0] for one in everything]) * force)**2 *
                  -numpy.expm1(-2 * decay * 0.2) / decay)
        loudest = sorted(numpy.argsort(-energy)[:5])
        self.assertEqual([one[0] for one in kept], [everything[i][0] for i in loudest])

    def test_points_are_far_apart(self):
        found = run_json("export-faust", *BLOCK, "-m", "steel", "--points", "8",
                         "--max-modes", "3", "-o", self.folder / "points.dsp")
        places = numpy.array(found["positions_m"])
        apart = numpy.linalg.norm(places[:, None] - places[None], axis=2)
        self.assertGreater(apart[numpy.triu_indices(8, 1)].min(), 0.04)
        for place in places - [0, 0, 0.0125]:  # on the block's faces
            self.assertAlmostEqual(max(numpy.abs(place) / [0.12, 0.045, 0.0125]), 1, 6)

    def test_says_what_is_wrong(self):
        for arguments, said in ((("--at", "0,0,0", "--points", "2"), "--points"),
                                (("--contact-time", "0"), "ideal impulse"),
                                (("--contact-time", "0.1 us"), "last 1 us to 1 s"),
                                (("--contact-time", "2 s"), "last 1 us to 1 s"),
                                (("--impulse", "0"), "--impulse"), (("--gain", "0"), "--gain"),
                                (("--at", "0,0"), "2 values instead of three"),
                                (("--max-frequency", "100 Hz"), "no mode"),
                                (("--pitch-mode", "1000"), "--pitch-mode")):
            result = run("export-faust", *BLOCK, "-m", "steel", *arguments, "-o",
                         self.folder / "wrong.dsp")
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(said, result.stderr)
            self.assertFalse((self.folder / "wrong.dsp").exists())

    def test_what_rank_0_alone_finds_wrong_ends_all(self):
        result = run("export-faust", *BLOCK, "-m", "steel", "--max-frequency", "100 Hz", "-o",
                     self.folder / "wrong.dsp", ranks=2)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("no mode", result.stderr)
        self.assertNotIn("MPI_ABORT", result.stderr)


if __name__ == "__main__":
    unittest.main()
