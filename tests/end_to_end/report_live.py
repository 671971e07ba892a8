"""The page of `carillon serve` while builds run: what it says of them without being read anew, the samples that
were made last, builds that are killed or deleted, and a service that goes and comes back."""
import base64
import contextlib
import functools
import http.server
import io
import json
import os
import shutil
import signal
import subprocess
import threading
import time
import unittest
import urllib.parse
import wave

import h5py
import numpy
from browser import expect_access, needs_browser, screen, show, start, there
from interrupted import descendants, wait_for
from program import CARILLON, NO_PICTURES, TIMEOUT_FACTOR, FolderTest, run
from server import Server

CONFIG = """
name: slow
seed: 3
materials: [steel, oak]
objects:
  - {shape: tile, count: 2, parameters: {length: [60 mm, 80 mm], width: 50 mm, thickness: 6 mm}}
modes: {max_modes: 6, order: 1, element_size: 20 mm}
strikes: {per_object: 3}
audio: {seconds: 0.2 s, sample_rate: 44100 Hz}
""" + ("" if NO_PICTURES else "camera: {width: 32, height: 24}\n")
SAMPLES = 12
# The first mesh is made at once, the others once the gate is gone.
MESHER = '#!/bin/sh\nmkdir "{gate}.first" 2>/dev/null || while [ -e "{gate}" ]; do sleep 0.05; done\nexec "{mesher}" "$@"\n'
CARD = "[...document.querySelectorAll('.build')].find((one) => one.textContent.includes(arguments[0]))"


class Live(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "slow.yaml"
        cls.config.write_text(CONFIG)
        cls.served = cls.folder / "served"
        built = run("build", cls.config, "-o", cls.served / "done", "--set", "name=done")
        assert built.returncode == 0, built.stderr
        cls.server = Server("served", cwd=cls.folder)
        cls.driver = start() if there() else None

    @classmethod
    def tearDownClass(cls):
        if cls.driver:
            cls.driver.quit()
        code, err = cls.server.stop()
        super().tearDownClass()
        assert code == 0, err

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def said(self, name):
        """What the page says of a build; "" where there is no card of it."""
        return self.js(f"return {CARD}?.innerText ?? ''", name)

    def expect_said(self, name, words, seconds=30):
        self.assertTrue(wait_for(lambda: words in self.said(name), seconds), (words, self.said(name)))

    def build(self, name, config=None):
        """A build on two ranks that has the samples of its first object, and waits for its second mesh."""
        gate = self.folder / f"gate-{name}"
        gate.touch()
        mesher = self.folder / f"mesher-{name}"
        mesher.write_text(MESHER.format(gate=gate, mesher=os.path.join(os.path.dirname(CARILLON), "carillon-mesh")))
        mesher.chmod(0o755)
        process = subprocess.Popen(
            ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "2", CARILLON, "--cache", "", "build", config or self.config,
             "-o", self.served / name, "--set", f"name={name}"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**os.environ, "CARILLON_MESH": str(mesher)})
        self.addCleanup(shutil.rmtree, self.served / name, ignore_errors=True)
        self.addCleanup(self.kill, process)
        self.addCleanup(gate.unlink, missing_ok=True)
        return process, gate

    def open(self, server=None, **options):
        show(self.driver, (server or self.server).url, **options)
        self.assertTrue(wait_for(lambda: "No build is under way" in self.js("return document.querySelector('#live').innerText"), 30))
        self.js("window.read = 'before'")

    def kill(self, process):
        for pid in descendants(process.pid) if process.poll() is None else []:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        process.communicate()

    def has_half(self, name):
        status = self.served / name / "status.json"
        return status.exists() and json.loads(status.read_text())["samples"]["done"] == SAMPLES // 2

    def test_the_newest_samples_are_those_of_the_newest_shards(self):
        folder = self.served / "done"
        names = [json.loads(line)["task"] for line in (folder / "journal.jsonl").read_text().splitlines()]
        shards = [name for name in names if name.startswith("samples/")][::-1]
        (dataset,) = [d for d in self.server.ask_json("/v1/datasets")[1]["datasets"] if d["folder"].endswith("done")]
        query = urllib.parse.urlencode({"folder": dataset["folder"], "count": 4})
        status, told = self.server.ask_json(f"/v1/newest?{query}")
        self.assertEqual((status, len(told["samples"])), (200, 4))
        expected = []
        for shard in shards:
            with h5py.File(folder / f"{shard}.h5") as file:
                expected += [(key.decode(), sound) for key, sound in zip(file["key"][-2:][::-1], file["audio"][-2:][::-1], strict=True)]
        for sample, (key, stored) in zip(told["samples"], expected, strict=True):
            self.assertEqual(sample["key"], key)
            with wave.open(io.BytesIO(base64.b64decode(sample["audio"]))) as clip:
                heard = numpy.frombuffer(clip.readframes(clip.getnframes()), "<i2") / 32768
            numpy.testing.assert_allclose(heard, 0.5 / abs(stored).max() * stored, atol=1 / 32768)
            self.assertEqual("picture" in sample, not NO_PICTURES)
            self.assertEqual(sample["labels"]["material"], key.split("/")[1])
        for query, status in (("", 404), ("folder=/etc", 404), ("folder=.", 404), ("folder=served/done/../done", 404),
                              ("folder=served/done&count=0", 400), ("folder=served/done&count=13", 400),
                              ("folder=served/done&count=2.5", 400), ("folder=served/done&count=1", 200)):
            self.assertEqual(self.server.ask(f"/v1/newest?{query}")[0], status, query)

    @needs_browser
    def test_a_build_is_told_of_from_its_beginning_to_its_end(self):
        self.open()
        process, gate = self.build("begins")
        self.expect_said("begins", "running")
        self.assertTrue(wait_for(lambda: self.has_half("begins"), 60))
        self.expect_said("begins", f"{SAMPLES // 2} of {SAMPLES}")
        self.expect_said("begins", "samples/s")
        self.expect_said("begins", "modes/tile-")  # what the second rank waits in
        self.expect_said("begins", "without a task")
        self.assertIn("2 ranks", self.said("begins"))
        share = self.js(f"return {CARD}.querySelector('progress').value", "begins")
        self.assertTrue(0 < share < 1, share)
        # Sounds of what is done.
        self.js(f"{CARD}.scrollIntoView({{behavior: 'instant'}})", "begins")
        heard = f"return [...{CARD}.querySelectorAll('.cards h3')].map((one) => one.textContent)"
        self.assertTrue(wait_for(lambda: len(self.js(heard, "begins")) == 4, 30))
        (shard,) = (self.served / "begins" / "samples").glob("*.h5")
        with h5py.File(shard) as file:
            self.assertEqual(self.js(heard, "begins"), [key.decode() for key in file["key"][-4:][::-1]])
        self.assertEqual(self.js(f"return {CARD}.querySelectorAll('.spectrogram canvas').length", "begins"), 4)
        # Nothing was read anew, and a page that nothing happens on asks for nothing.
        self.assertEqual(self.js("return window.read"), "before")
        asked = "return performance.getEntriesByType('resource').filter((one) => one.name.includes('newest')).map((one) => one.startTime)"
        times = self.js(asked)
        time.sleep(7)
        self.assertEqual(self.js(asked), times)
        self.assertGreaterEqual(min([b - a for a, b in zip(times, times[1:])] + [1e9]), 1000)
        for width in (1280, 390):
            for dark in (False, True):
                screen(self.driver, width, dark=dark)
                expect_access(self, self.driver, width)
        gate.unlink()
        process.communicate(timeout=60 * TIMEOUT_FACTOR)
        self.expect_said("begins", "It is done after")
        self.assertIn(f"{SAMPLES} of {SAMPLES}", self.said("begins"))
        self.assertEqual(self.js("return window.read"), "before")
        self.js(f"{CARD}.querySelector('.buttons button').click()", "begins")
        self.assertTrue(wait_for(lambda: self.js("return window.read ?? document.readyState") == "complete", 60))
        titles = self.js("return [...document.querySelectorAll('section h2')].map((one) => one.textContent)")
        self.assertIn("What was built: begins", titles)
        self.assertEqual(self.said("begins"), "")

    @needs_browser
    def test_builds_that_are_killed_or_deleted(self):
        self.open()
        process, _ = self.build("killed")
        self.expect_said("killed", "running")
        self.assertTrue(wait_for(lambda: self.has_half("killed"), 60))
        self.kill(process)
        self.expect_said("killed", "There is no word since", 60)
        self.assertIn("the build was killed", self.said("killed"))
        shutil.rmtree(self.served / "killed")
        self.expect_said("killed", "The folder was deleted.")
        # One that was done all the time, too.
        shutil.copytree(self.served / "done", self.served / "old")
        self.open()
        self.assertEqual(self.said("served/old"), "")
        shutil.rmtree(self.served / "old")
        self.expect_said("served/old", "The folder was deleted.")
        self.assertEqual(self.js("return window.read"), "before")

    @needs_browser
    def test_of_a_sweep_the_variant_is_heard_that_is_worked_on(self):
        config = self.write("sweep.yaml", CONFIG + "sweep: {mode: grid, keys: {audio.gain: [1, 2]}}\n")
        self.open()
        process, gate = self.build("sweep", config)
        self.expect_said("sweep", f"{SAMPLES} of {2 * SAMPLES}", 60)
        self.expect_said("sweep", "gain=1/modes/tile-")
        self.js(f"{CARD}.scrollIntoView({{behavior: 'instant'}})", "sweep")
        self.assertTrue(wait_for(lambda: self.js(f"return {CARD}.querySelectorAll('audio').length", "sweep") == 4, 30))
        gate.unlink()
        process.communicate(timeout=60 * TIMEOUT_FACTOR)
        self.expect_said("sweep", "It is done after")
        self.assertIn(f"{2 * SAMPLES} of {2 * SAMPLES}", self.said("sweep"))

    @needs_browser
    def test_a_failed_task_is_counted(self):
        (self.folder / "flat.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        failing = self.write("failing.yaml", CONFIG.replace("\nmodes:", "\n  - {mesh: flat.off, length: 10 cm, materials: [steel]}\nmodes:"))
        self.open()
        built = run("build", failing, "-o", self.served / "fails", "--set", "name=fails")
        self.assertEqual(built.returncode, 3, built.stderr)
        self.expect_said("fails", "but for 1 failed task")
        self.assertIn("3 samples", self.said("fails"))
        shutil.rmtree(self.served / "fails")

    @needs_browser
    def test_the_service_goes_and_comes_back(self):
        server = Server("served", cwd=self.folder)
        said = "return document.querySelector('#live [role=status]').innerText"
        try:
            self.open(server)
            server.stop()
            self.assertTrue(wait_for(lambda: "connection to the service is lost" in self.js(said), 30))
            server = Server("served", port=server.port, cwd=self.folder)
            self.assertTrue(wait_for(lambda: "No build is under way" in self.js(said), 60))
            self.assertEqual(self.js("return window.read"), "before")
        finally:
            server.stop()

    @needs_browser
    def test_a_token_is_passed_on(self):
        self.write("token", "0123456789abcdef\n")
        server = Server("served", "--token", "token", cwd=self.folder)
        try:
            self.assertEqual(server.ask("/v1/newest?folder=served/done")[0], 401)
            address = f"{server.url}/?token=0123456789abcdef"
            show(self.driver, address)
            self.assertTrue(wait_for(lambda: "No build is under way" in self.js("return document.querySelector('#live').innerText"), 30))
            process, gate = self.build("secret")
            self.expect_said("secret", "running")
            self.assertTrue(wait_for(lambda: self.has_half("secret"), 60))
            self.js(f"{CARD}.scrollIntoView({{behavior: 'instant'}})", "secret")
            self.assertTrue(wait_for(lambda: self.js(f"return {CARD}.querySelectorAll('audio').length", "secret") == 4, 30))
            gate.unlink()
            process.communicate(timeout=60 * TIMEOUT_FACTOR)
            self.expect_said("secret", "It is done after")
            self.js(f"{CARD}.querySelector('.buttons button').click()", "secret")
            self.assertTrue(wait_for(lambda: "What was built: secret" in self.js("return document.body.textContent"), 60))
        finally:
            server.stop()

    @needs_browser
    def test_a_page_on_another_server_says_that_nothing_is_known(self):
        run("report", self.served / "done", "-o", self.folder / "page.html")
        class Quiet(http.server.SimpleHTTPRequestHandler):
            def log_message(self, *_):
                pass

        answer = functools.partial(Quiet, directory=self.folder)
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), answer) as other:
            threading.Thread(target=other.serve_forever).start()
            try:
                show(self.driver, f"http://127.0.0.1:{other.server_port}/page.html")
                self.assertTrue(wait_for(lambda: "does not come from carillon serve" in self.js(
                    "return document.querySelector('#live').innerText"), 30))
            finally:
                other.shutdown()


if __name__ == "__main__":
    unittest.main()
