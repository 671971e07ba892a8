"""Objects that are played: through the pipe, in real time, by text, keys and OSC."""
import json
import os
import pathlib
import pty
import random
import signal
import socket
import struct
import subprocess
import termios
import time
import unittest
import wave

import numpy
from program import CARILLON, LONG, TIMEOUT_FACTOR, FolderTest, run

RATE = 44100
# Of 59 or 60 modes each.
SHAPES = ("bowl:radius=150mm", "plate:radius=200mm", "bowl", "plate")
FEW = ("-m", "steel", "--max-modes", "60")


def samples_of(path):
    """Of a WAV file of 32-bit floats."""
    data = pathlib.Path(path).read_bytes()
    return numpy.frombuffer(data[data.index(b"data") + 8:], "<f4").astype(float)


def outcome(errors):
    """The JSON that a played command ends with."""
    return json.loads([line for line in errors.splitlines() if line.startswith("{")][-1])


def osc(address, *values):
    """A message of OSC 1.0."""
    def text(word):
        return word.encode() + b"\0" * (4 - len(word) % 4)
    types, body = ",", b""
    for value in values:
        if isinstance(value, str):
            types, body = types + "s", body + text(value)
        elif isinstance(value, int):
            types, body = types + "i", body + struct.pack(">i", value)
        else:
            types, body = types + "f", body + struct.pack(">f", value)
    return text(address) + text(types) + body


class Play(FolderTest):
    def play(self, *words, events="", check=0):
        """Samples and outcome of what is played to a pipe."""
        done = subprocess.run([CARILLON, "play", *map(str, words), "-o", "-", "--json"], input=events.encode(),
                              capture_output=True, cwd=self.folder, timeout=200 * TIMEOUT_FACTOR)
        errors = done.stderr.decode()
        self.assertEqual(done.returncode, check, errors)
        return numpy.frombuffer(done.stdout, "<f4").astype(float), outcome(errors), errors

    def strike(self, shape, *words, seconds=2):
        """What carillon strike gives, at the object's own place."""
        result = run("strike", shape, *FEW, "--seconds", f"{seconds} s", *words, "-o", "one.wav", cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return samples_of(self.folder / "one.wav")

    def equal(self, played, expected, peak=None):
        peak = peak or abs(expected).max()
        self.assertGreater(peak, 0)
        self.assertLess(abs(played - expected).max(), 1e-6 * peak)

    def test_200_objects_in_real_time_are_the_offline_sum(self):
        seconds = 60 if LONG else 5
        draw = random.Random(3)
        contacts = ("0.2 ms", "1.5 ms", "0.7 ms", "0.4 ms")
        ringing = [self.strike(s, "--contact-time", c, "--impulse", "1", seconds=seconds) for s, c in zip(SHAPES, contacts)]
        names, times = [], {}
        for i in range(200):
            shape = SHAPES[i % 4]
            times[shape] = times.get(shape, 0) + 1
            names.append(shape if times[shape] == 1 else f"{shape}-{times[shape]}")
        strikes = [(draw.randrange(RATE // 2), i) for i in range(200)]
        strikes += [(draw.randrange(RATE * (seconds - 1)), draw.randrange(200)) for _ in range(60 * seconds)]
        expected, lines = numpy.zeros(RATE * seconds), []
        for first, i in sorted(strikes):
            contact, impulse = contacts[i % 4], draw.uniform(0.001, 0.02)
            expected[first:] += impulse * ringing[i % 4][:len(expected) - first]
            lines.append(f"{first / RATE!r} strike {names[i]} impulse {impulse!r} contact {contact.replace(' ', '')}")
        sound, told, errors = self.play(*[SHAPES[i % 4] for i in range(200)], *FEW, "--seconds", seconds, "--latency",
                                        "300ms", events="\n".join(lines) + "\n")
        self.assertIn("latency: 305.80 ms", errors)
        self.equal(sound, expected)
        self.assertEqual((told["events"], told["late_events"], told["refused"]), (len(lines), 0, 0))
        if TIMEOUT_FACTOR == 1:
            self.assertEqual(told["dropouts"], 0, told)
            self.assertLess(told["processor_s"], 0.7 * seconds, told)

    def test_10000_events_in_a_block_and_files_are_the_same(self):
        one = self.strike("bell", "--impulse", "1e-6", "--contact-time", "1ms", seconds=1)
        lines = "0 strike bell impulse 1e-6 contact 1ms\n" * 10000
        sound, told, _ = self.play("bell", *FEW, "--seconds", 1, "--pace", "none", events=lines)
        self.equal(sound, 10000 * one)
        self.assertEqual((told["events"], told["late_events"]), (10000, 0))
        self.write("lines.txt", lines)
        result = run("play", "bell", *FEW, "--events", "lines.txt", "--seconds", "1", "-o", "all.wav", cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        numpy.testing.assert_array_equal(samples_of(self.folder / "all.wav"), sound)
        result = run("play", "bell", *FEW, "--events", "lines.txt", "--seconds", "1", "-o", "all.wav", "--format", "s16",
                     "--gain", "10", cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        with wave.open(str(self.folder / "all.wav")) as file:
            whole = numpy.frombuffer(file.readframes(RATE), "<i2")
        numpy.testing.assert_allclose(whole, 10 * 32768 * sound, atol=0.51)

    def test_supports_and_hands(self):
        finger = ("--set", "supports.contacts=[{kind: finger, at: [0.03, 0, -0.02], force: 20}]")
        held, free = self.strike("bell", *finger, seconds=1), self.strike("bell", seconds=1)
        self.assertGreater(abs(held - free).max(), 1e-3 * abs(free).max())
        sound, _, errors = self.play("bell", *FEW, *finger, "--seconds", 1, "--pace", "none", events="0 strike bell\n")
        self.assertIn("supports", errors)
        self.equal(sound, held)
        sound, _, _ = self.play("bell", *FEW, *finger, "--seconds", 1, "--pace", "none",
                                events="0 support bell 0 off\n0 strike bell\n0.5 support 0 0 on\n")
        self.equal(sound[:RATE // 2], free[:RATE // 2])
        after = slice(3 * RATE // 4, None)
        self.assertLess(abs(sound[after]).max(), 0.99 * abs(free[after]).max())
        # The end comes when it is asked for, also after silence.
        late, told, _ = self.play("bell", *FEW, "--pace", "none", events="0 strike 0\n0 damp 0 500\n1.5 stop\n")
        self.assertGreaterEqual(told["seconds"], 1.5)
        self.assertEqual(abs(late[RATE:]).max(), 0)
        # A hand that adds d takes exp(-d t) from every mode.
        damped, _, _ = self.play("bell", *FEW, "--seconds", 1, "--pace", "none", events="0 strike bell\n0.5 damp * 100\n")
        self.equal(damped[:RATE // 2], free[:RATE // 2])
        self.assertLess(abs(damped[-RATE // 4:]).max(), 1e-4 * abs(free).max())

    def test_objects_on_springs(self):
        feet = ("--set", "supports.contacts=[{kind: rubber, at: [-0.03, 0, -0.02, 0.03, 0, -0.02]}, {kind: soil, lowest: true}]")
        held = self.strike("bell", *feet, seconds=0.5)
        sound, _, errors = self.play("bell", *FEW, *feet, "--seconds", 0.5, "--pace", "none", events="0 strike bell\n")
        self.assertRegex(errors, "heard live: .*supports")
        self.equal(sound, held)

    def test_lines_that_are_wrong_are_told_by_number(self):
        sound, told, errors = self.play("bell", *FEW, "--seconds", 0.2, "--pace", "none", check=3, events=(
            "0 strike bell\n\n# a word\nrubbish\n0.1 strike bel\n0.1 support bell 3 on\n0.1 strike 7\n"
            "0.1 strike bell position 5 5 5\n" + "x" * 10000 + "\n0.1 strike 0"))
        self.assertEqual((told["events"], told["refused"]), (2, 6))
        for part in ("events:4:", "events:5: there is no object \"bel\"; did you mean \"bell\"?", "events:6:", "events:7:",
                     "events:8:", "events:9:"):
            self.assertIn(part, errors)
        self.assertGreater(abs(sound).max(), 0)

    def test_what_cannot_be_played_is_refused(self):
        for words, part in (((), "nothing to play"), (("bell", "--pace", "none"), "does not apply"),
                            (("bell", "--latency", "20 s", "-o", "-"), "--latency"),
                            (("bell", "bell", "--max-objects", "1", "-o", "-"), "2 objects are more than 1"),
                            (("bell", "-o", "x.wav", "--device", "0"), "both"),
                            (("bell", "--events", "nowhere.txt", "-o", "-"), "nowhere.txt")):
            result = run("play", *words, cwd=self.folder)
            self.assertEqual(result.returncode, 2, words)
            self.assertIn(part, result.stderr)

    def test_a_device_that_is_not_there(self):
        listed = run("play", "--device", "list")
        if listed.returncode == 0:
            self.skipTest("there is a sound device")
        self.assertEqual(listed.returncode, 2)
        self.assertNotIn("ALSA lib", listed.stderr)
        played = run("play", "bell", *FEW, "--device", "default", cwd=self.folder)
        self.assertEqual(played.returncode, 2)
        for result in (listed, played):
            self.assertRegex(result.stderr, "no sound device|PortAudio")
            self.assertIn("hint:", result.stderr)

    def test_a_reader_that_is_slow_and_one_that_goes(self):
        words = [CARILLON, "play", "bell", *FEW, "-o", "-", "--json", "--seconds", "1.2"]
        process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   cwd=self.folder)
        process.stdin.write(b"0 strike bell\n")
        process.stdin.close()
        process.stdout.read(4)
        time.sleep(1.5)
        rest = process.stdout.read()
        told = outcome(process.stderr.read().decode())
        self.assertEqual(process.wait(), 0)
        self.assertEqual(len(rest) + 4, 4 * round(1.2 * RATE))
        self.assertGreater(told["dropouts"], 0)
        self.assertGreater(told["behind_s"], 0.5)
        process.stdout.close()
        process.stderr.close()
        process = subprocess.Popen(words[:-2], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   cwd=self.folder)
        process.stdin.write(b"0 strike bell\n")
        process.stdin.flush()
        process.stdout.read(4096)
        process.stdout.close()
        told = outcome(process.stderr.read().decode())
        self.assertEqual(process.wait(), 0)
        self.assertTrue(told["reader_closed"])
        process.stdin.close()
        process.stderr.close()

    def at_a_terminal(self, act):
        """Exit code and samples of what is played from a terminal's keys; its settings are as before."""
        ours, theirs = pty.openpty()
        before = termios.tcgetattr(theirs)
        process = subprocess.Popen([CARILLON, "play", "bell", "bar", *FEW, "-o", "-"],
                                   stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=self.folder,
                                   start_new_session=True)
        first = process.stdout.read(4096)
        for _ in range(100):
            if termios.tcgetattr(theirs)[3] & termios.ICANON == 0:
                break
            time.sleep(0.02)
        self.assertEqual(termios.tcgetattr(theirs)[3] & (termios.ICANON | termios.ECHO), 0)
        act(ours, process)
        sound = numpy.frombuffer(first + process.stdout.read(), "<f4")
        errors = process.stderr.read().decode()
        code = process.wait(timeout=30)
        self.assertEqual(termios.tcgetattr(theirs), before)
        for stream in (process.stdout, process.stderr):
            stream.close()
        os.close(ours)
        os.close(theirs)
        return code, sound, errors

    def test_keys_strike_and_the_terminal_is_as_before(self):
        def strike(ours, _):
            os.write(ours, b"1")
            time.sleep(0.3)
            os.write(ours, b" \x1b")
        code, sound, errors = self.at_a_terminal(strike)
        self.assertEqual(code, 0, errors)
        self.assertIn("keys:", errors)
        self.assertGreater(abs(sound).max(), 0)
        for sent, expected in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            code, _, errors = self.at_a_terminal(lambda ours, process, sent=sent: process.send_signal(sent))
            self.assertEqual(code, expected, errors)

    def test_osc_strikes_and_malformed_packets_are_counted(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        process = subprocess.Popen([CARILLON, "play", "bell", *FEW, "-o", "-", "--json", "--osc", str(port), "--seconds",
                                    "20"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   cwd=self.folder)
        first = process.stdout.read(4096)
        if not first and b"liblo" in process.stderr.read():
            self.skipTest("built without liblo")
        bundle = osc("/damp", "bell", 5.0)
        packets = [osc("/strike", "bell", 0.0096, -0.0277, 0.0596, 0.02, 0.001), osc("/strike", 0),
                   b"#bundle\0" + bytes(8) + struct.pack(">i", len(bundle)) + bundle]
        bad = [b"", b"\0", b"/strike", osc("/strike", "bell")[:-3], osc("/strike", "nobody"), osc("/nothing", 1),
               osc("/support", "bell", 0, "on"), osc("/strike", "bell", 1.0), os.urandom(500),
               b"#bundle\0" + bytes(8) + struct.pack(">i", 4000), osc("/damp", "bell", float("nan"))]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for packet in packets + bad:
                sender.sendto(packet, ("127.0.0.1", port))
            time.sleep(0.3)
            sender.sendto(osc("/stop"), ("127.0.0.1", port))
        sound = numpy.frombuffer(first + process.stdout.read(), "<f4")
        told = outcome(process.stderr.read().decode())
        self.assertEqual(process.wait(timeout=30), 0)
        self.assertEqual((told["events"], told["refused"]), (len(packets) + 1, len(bad)))
        self.assertLess(len(sound), 10 * RATE)
        self.assertGreater(abs(sound).max(), 0)
        process.stdout.close()
        process.stderr.close()

    def test_a_configuration_is_played_in_all_its_materials(self):
        self.write("two.yaml", """
name: two
seed: 1
materials: [steel, glass]
objects:
  - {shape: bar}
  - {shape: bell, materials: [iron]}
modes: {max_modes: 20}
audio: {seconds: 1 s}
strikes: {impulse: 20 mN s, contact_time: 1 ms}
listeners: [{position: [0, 0, 1]}, {position: [0, 1, 0.5]}]
room: {dimensions: [5, 4, 3], rt60: 0.4}
""")
        sound, told, errors = self.play("two.yaml", "--seconds", 0.5, "--pace", "none",
                                        events="0 strike 0\n0.1 strike 1\n0.2 strike 2\n")
        self.assertEqual((told["objects"], len(sound)), (3, RATE))
        self.assertIn("heard live: ", errors)
        self.assertRegex(errors, r"not heard live: .*room")
        self.assertGreater(abs(sound[0::2]).max(), 0)
        self.assertGreater(abs(sound[0::2] - sound[1::2]).max(), 0)
        result = run("play", "two.yaml", "--max-objects", "2", "-o", "-", cwd=self.folder)
        self.assertEqual(result.returncode, 2)
        self.assertIn("3 objects are more than 2", result.stderr)


if __name__ == "__main__":
    unittest.main()
