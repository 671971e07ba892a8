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
BLOCK = ["block:length=240mm,width=90mm,height=25mm", "--order", "2", "--element-size", "40 mm"]
AT = ["--at", "0.12,0.02,0.018"]
STRIKE = ["0:strike=1", "300:strike=0"]
SECONDS = 0.3


def read_wav(path):
    content = path.read_bytes()
    begin = content.index(b"data")
    size = int.from_bytes(content[begin + 4:begin + 8], "little")
    return numpy.frombuffer(content[begin + 8:begin + 8 + size], "<f4").astype(float)


def level(values, reference):
    """Largest magnitude over that of a reference [dB]."""
    return 20 * numpy.log10(max(numpy.abs(values).max(), 1e-300) / numpy.abs(reference).max())


def modes_of(program):
    """(lambda, gains) of the lines of a program."""
    lines = re.findall(r"^  mode\((\S+), .*?(?:waveform\{(.*?)\}\)|(\S+))\)[ ,]", program, re.M)
    return [(float(value), [float(one) for one in (many or single).split(",")])
            for value, many, single in lines]


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

    def play(self, binary, *events, rate=44100, seconds=SECONDS):
        answer = subprocess.run([binary, str(rate), str(round(rate * seconds)), *events],
                                check=True, capture_output=True, timeout=100)
        return numpy.frombuffer(answer.stdout)

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
        self.expect_equal(self.play(binary, "0:position=1", *STRIKE),
                          self.strike(*body, "--at", "0.07,0.05,0.025"))
        # A contact within a sample, of whole samples, and longer than a mode's period.
        for contact in ("0.01 ms", "1 ms", "2.37 ms"):
            self.expect_equal(
                self.play(binary, f"0:contact time={contact.split()[0]}", "0:impulse=0.05",
                          "0:gain=-20", *STRIKE),
                self.strike(*body, *AT, "--contact-time", contact, "--impulse", "0.05 N s",
                            "--gain", "0.1"))

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
        played = self.play(self.compile(other), "0:input=44100", "100:input=-22050")
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
                         {"contact time", "impulse", "position", "size", "alpha1", "alpha2",
                          "gain"})
        for binary in (self.compile(program), self.compile(program, (), "float")):
            self.assertEqual(numpy.abs(self.play(binary)).max(), 0)
            for label, _, low, high in labels:
                for value in (low, high, 0, 1e9):
                    played = self.play(binary, f"0:{label}={value}", *STRIKE)
                    self.assertTrue(numpy.isfinite(played).all(), (label, value))
            moved = [f"{sample}:{label}={(low, high)[(sample // 64 + number) % 2]}"
                     for sample in range(320, 6000, 64)
                     for number, (label, _, low, high) in enumerate(labels)
                     if label in ("size", "alpha1", "alpha2")]
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
                                (("--max-frequency", "100 Hz"), "no mode")):
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
