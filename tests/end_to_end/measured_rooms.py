"""Dry sounds in rooms: measured responses of two rates in a folder, and simulated rooms; disjoint over the
splits, the same on any number of ranks, and again by `regenerate`."""
import json
import shutil
import unittest

import h5py
import numpy
import scipy.io.wavfile
import scipy.signal
from program import FolderTest, run, run_json
from same import hashes

RATE, SAMPLES, FILES = 16000, 4800, 14
CONFIG = """
name: rooms
seed: 5
objects:
  - shape: bar
    count: 6
    parameters: {length: [10 cm, 12 cm], width: [2 cm, 3 cm], height: [8 mm, 12 mm]}
    materials: [steel]
modes: {max_modes: 12, max_frequency: 6 kHz, order: 2, max_elements: 6000}
audio: {seconds: 0.3 s, sample_rate: 16 kHz}
strikes: {per_object: 12}
split: {validation: 0.3, test: 0.3}
room: ROOM
"""
MEASURED = "{input: dry, responses: responses}"
SIMULATED = "{input: dry, dimensions: [[3, 6], [3, 5], 2.5], rt60: [0.2 s, 0.4 s], count: 2}"


def response(number):
    """At 16 or 44.1 kHz: silence, a direct sound of some level, and a decay."""
    rate = RATE if number % 2 == 0 else 44100
    random = numpy.random.default_rng(number)
    time = numpy.arange(int(0.4 * rate)) / rate
    tail = 0.1 * random.standard_normal(time.size) * 10 ** (-3 * time / (0.2 + 0.02 * number))
    tail[:int(0.004 * rate)] = 0
    tail[0] = 1
    return rate, numpy.concatenate([numpy.zeros(50 * number), (0.1 + 0.05 * number) * tail])


class Rooms(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        responses = cls.folder / "responses" / "deep"
        responses.mkdir(parents=True)
        for number in range(FILES):
            rate, samples = response(number)
            scipy.io.wavfile.write(responses / f"{number:02}.wav", rate, samples.astype("float32"))
        cls.outputs = {}
        for name, room in (("measured", MEASURED), ("simulated", SIMULATED), ("dry", None)):
            text = CONFIG.replace("room: ROOM\n", f"room: {room}\n" if room else "")
            cls.outputs[name] = cls.build(name, text)

    @classmethod
    def build(cls, name, text, *options, **more):
        (cls.folder / f"{name}.yaml").write_text(text)
        output = cls.folder / (name + "".join(str(n) for n in more.values()))
        run_json("build", cls.folder / f"{name}.yaml", "-o", output, *options, **more)
        return output

    def columns(self, name, *wanted):
        with h5py.File(self.outputs[name] / "index.h5") as index:
            return [index[c].asstr()[()] if h5py.check_string_dtype(index[c].dtype) else index[c][()]
                    for c in wanted]

    def test_the_measured_sound_is_the_dry_one_convolved_with_its_response(self):
        files, channels, wet = self.columns("measured", "room_response", "room_response_channel", "audio")
        (dry,) = self.columns("dry", "audio")
        self.assertEqual(set(channels), {1})
        rates = set()
        for name, heard, sound in zip(files, wet, dry):
            rate, samples = response(int(name[5:7]))
            rates.add(rate)
            if rate != RATE:
                continue
            cut = samples[numpy.argmax(abs(samples) > 0):].astype("float32").astype(float)
            cut /= numpy.sqrt(numpy.sum(cut[:40] ** 2))
            expected = scipy.signal.fftconvolve(sound.astype(float), cut)[:SAMPLES]
            numpy.testing.assert_allclose(heard, expected, atol=1e-6 * abs(expected).max())
        self.assertEqual(rates, {RATE, 44100})

    def test_another_rate_gives_the_same_room(self):
        """By energy over time: the response of 44.1 kHz, brought to 16 kHz by other means."""
        files, wet = self.columns("measured", "room_response", "audio")
        (dry,) = self.columns("dry", "audio")
        compared = 0
        for name, heard, sound in zip(files, wet, dry):
            rate, samples = response(int(name[5:7]))
            if rate == RATE:
                continue
            cut = scipy.signal.resample_poly(samples[numpy.argmax(abs(samples) > 0):], 160, 441)
            cut /= numpy.sqrt(numpy.sum(cut[:40] ** 2))
            expected = scipy.signal.fftconvolve(sound.astype(float), cut)[:SAMPLES]
            for part in (slice(0, 800), slice(800, 2400), slice(2400, None)):
                ratio = numpy.sum(heard[part].astype(float) ** 2) / numpy.sum(expected[part] ** 2)
                self.assertLess(abs(10 * numpy.log10(ratio)), 1, name)
            compared += 1
        self.assertGreater(compared, 0)

    def test_parts_of_either_split_share_no_response(self):
        for split in ("split_shape", "split_strike"):
            files, parts = self.columns("measured", "room_response", split)
            self.assertGreater(len(set(parts)), 1)
            of_file = {}
            for file, part in zip(files, parts):
                self.assertEqual(of_file.setdefault(file, part), part, file)
        report = run_json("check", self.outputs["measured"])
        found = {c["name"]: c for c in report["checks"]}
        self.assertEqual(found["rooms"]["verdict"], "pass", found["rooms"])
        self.assertIn("measured responses", found["rooms"]["text"])
        self.assertEqual(found["configuration"]["verdict"], "pass", found["configuration"])

    def test_simulated_rooms_of_dry_sounds(self):
        numbers, sources, listeners, times = self.columns(
            "simulated", "room", "room_source", "room_listener", "room_rt60")
        self.assertGreater(len(set(numbers)), 4)
        self.assertTrue((numpy.linalg.norm(sources - listeners, axis=1) >= 0.5).all())
        self.assertTrue((times[:, 3] >= 0.2 - 1e-9).all() and (times[:, 3] <= 0.4 + 1e-9).all())
        with h5py.File(self.outputs["simulated"] / "index.h5") as index:
            self.assertEqual(index["audio"].attrs["unit"], "m/s")
            self.assertEqual(index["audio"].shape[1:], (SAMPLES,))
            self.assertEqual(index["tail_level"].shape[1:], (1,))
        found = {c["name"]: c for c in run_json("check", self.outputs["simulated"])["checks"]}
        self.assertEqual(found["rooms"]["verdict"], "pass", found["rooms"])

    def test_two_ranks_make_the_same_bytes(self):
        for name in ("measured", "simulated"):
            text = (self.folder / f"{name}.yaml").read_text()
            self.assertEqual(hashes(self.build(name, text, ranks=2)), hashes(self.outputs[name]), name)

    def test_the_trace_tells_what_ran(self):
        for name, effects, others in (("measured", {"response"}, {"room", "tail", "radiation"}),
                                      ("simulated", {"room", "tail"}, {"response", "radiation"})):
            trace = json.loads((self.outputs[name] / "trace.json").read_text())["effects"]
            for effect in effects:
                self.assertEqual(trace[effect]["calls"], 72, effect)
            self.assertFalse(others & set(trace))

    def test_regenerate(self):
        for name in ("measured", "simulated"):
            report = run_json("regenerate", self.outputs[name], "--sample", 3, "--sample", 50)
            self.assertTrue(all(s["identical"] for s in report["samples"]), report)
        moved = self.folder / "elsewhere"
        moved.mkdir()
        shutil.copytree(self.outputs["measured"], moved / "measured")
        report = run_json("regenerate", moved / "measured", "--inputs", self.folder, "--sample", 7)
        self.assertTrue(report["samples"][0]["identical"], report)
        (moved / "measured" / "trace.json").unlink()  # which knows where the configuration lay
        result = run("regenerate", moved / "measured", "--sample", 7, cwd=moved)
        self.assertEqual(result.returncode, 2)
        self.assertIn("responses", result.stderr)
        self.assertIn("--inputs", result.stderr)

    def test_a_changed_response_is_told(self):
        copy = self.folder / "changed"
        copy.mkdir()
        shutil.copytree(self.folder / "responses", copy / "responses")
        shutil.copytree(self.outputs["measured"], copy / "measured")
        (copy / "measured" / "trace.json").unlink()  # which knows where the configuration lay
        rate, samples = response(4)
        samples[-1] += 0.001
        scipy.io.wavfile.write(copy / "responses" / "deep" / "04.wav", rate, samples.astype("float32"))
        found = {c["name"]: c for c in json.loads(
            run("check", copy / "measured", "--json", cwd=copy).stdout)["checks"]}
        self.assertNotEqual(found["configuration"]["verdict"], "pass", found["configuration"])

    def test_one_file_serves_all_parts_and_a_folder_of_one_none(self):
        alone = self.folder / "alone"
        alone.mkdir()
        rate, samples = response(2)
        scipy.io.wavfile.write(alone / "hall.wav", rate, samples.astype("float32"))
        text = CONFIG.replace("ROOM", "{input: dry, responses: alone/hall.wav}")
        output = self.build("one", text)
        with h5py.File(output / "index.h5") as index:
            self.assertEqual(set(index["room_response"].asstr()[()]), {"hall.wav"})
        found = {c["name"]: c for c in run_json("check", output)["checks"]}
        self.assertEqual(found["rooms"]["verdict"], "note", found["rooms"])
        (self.folder / "few.yaml").write_text(CONFIG.replace("ROOM", "{input: dry, responses: alone}"))
        result = run("plan", self.folder / "few.yaml")
        self.assertEqual(result.returncode, 2)
        for word in ("few.yaml:13", "room.responses", "1 response for 9 parts", "one file"):
            self.assertIn(word, result.stderr)

    def test_the_plan_says_what_runs(self):
        plan = run_json("plan", self.folder / "measured.yaml")
        effects = {e["name"]: e for e in plan["effects"]}
        self.assertTrue(effects["response"]["enabled"])
        self.assertIn("for the dry sound", effects["response"]["reason"])
        self.assertFalse(effects["room"]["enabled"])
        self.assertIn("measured", effects["room"]["reason"])


if __name__ == "__main__":
    unittest.main()
