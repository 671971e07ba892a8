"""`carillon serve`: answers are those of the command line, bad requests get JSON, slow clients hold nobody up."""
import concurrent.futures
import contextlib
import http.client
import json
import pathlib
import shutil
import signal
import socket
import struct
import subprocess
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

import numpy
from program import CARILLON, TIMEOUT_FACTOR, FolderTest, run, run_json

CONFIG = """
name: small
seed: 4
materials: [steel]
objects:
  - {shape: bar, count: 2}
modes: {max_modes: 5, order: 2, element_size: 20 mm, max_frequency: 8 kHz}
strikes: {per_object: 2}
audio: {seconds: 0.1 s, sample_rate: 22050 Hz, gain: 100}
"""


def wav_bytes(samples, rate=44100):
    data = numpy.clip(samples * 32767, -32768, 32767).astype("<i2").tobytes()
    return (b"RIFF" + struct.pack("<I", 36 + len(data)) + b"WAVEfmt " +
            struct.pack("<IHHIIHH", 16, 1, 1, rate, 2 * rate, 2, 16) + b"data" + struct.pack("<I", len(data)) + data)


def ringing(seconds=1.0, pitch=1.0):
    t = numpy.arange(int(44100 * seconds)) / 44100
    generator = numpy.random.default_rng(3)
    sound = sum(a * numpy.exp(-d * t) * numpy.sin(2 * numpy.pi * pitch * f * t)
                for a, d, f in ((0.3, 8, 523), (0.2, 14, 1210), (0.1, 30, 2740)))
    return sound + 1e-4 * generator.standard_normal(len(t))


class Server:
    """A service that runs; `host:port` of it."""

    def __init__(self, *arguments, cwd, port=0):
        self.process = subprocess.Popen([CARILLON, "serve", *map(str, arguments), "--port", str(port)], cwd=cwd,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip().rstrip("/")
        if not self.url:
            raise AssertionError(self.process.communicate()[1])
        self.port = urllib.parse.urlsplit(self.url).port

    def ask(self, path, data=None, headers=None, method=None):
        request = urllib.request.Request(self.url + path, data, headers or {}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60 * TIMEOUT_FACTOR) as reply:
                return reply.status, reply.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    def ask_json(self, *arguments, **options):
        status, body = self.ask(*arguments, **options)
        return status, json.loads(body)

    def memory(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.split("VmRSS:")[1].split()[0]) * 1024

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        _, err = self.process.communicate(timeout=60 * TIMEOUT_FACTOR)
        return self.process.returncode, err


class Service(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.folder / "small.yaml").write_text(CONFIG)
        assert run("build", "small.yaml", cwd=cls.folder).returncode == 0
        cls.clip = wav_bytes(ringing())
        (cls.folder / "clip.wav").write_bytes(cls.clip)
        (cls.folder / "other.wav").write_bytes(wav_bytes(ringing(pitch=1.01)))
        cls.server = Server("small", "--longest-clip", "5", "--max-body", "2", cwd=cls.folder)

    @classmethod
    def tearDownClass(cls):
        code, err = cls.server.stop()
        super().tearDownClass()
        assert code == 0, err

    def test_answers_are_those_of_the_command_line(self):
        status, features = self.server.ask_json("/v1/features?max_features=2", self.clip)
        self.assertEqual(status, 200)
        known = run_json("features", "clip.wav", "--max-features", "2", cwd=self.folder)["files"][0]
        self.assertEqual(features["features"], known["features"])
        _, fit = self.server.ask_json("/v1/fit?model=power&estimator=least_squares", self.clip)
        known = run_json("fit", "clip.wav", "--model", "power", "--estimator", "least_squares", cwd=self.folder)
        self.assertEqual(fit["parameters"], known["parameters"])
        form = b"".join(
            b"--x\r\nContent-Disposition: form-data; name=\"%s\"; filename=\"../../etc/%s\"\r\n\r\n%s\r\n" %
            (name, name, (self.folder / file).read_bytes())
            for name, file in ((b"reference", "clip.wav"), (b"other", "other.wav"))) + b"--x--\r\n"
        status, compared = self.server.ask_json(
            "/v1/compare", form, {"Content-Type": "multipart/form-data; boundary=x"})
        self.assertEqual(status, 200, compared)
        known = run_json("compare", "clip.wav", "other.wav", cwd=self.folder)
        self.assertEqual(compared["matched"], known["matched"])
        self.assertEqual(compared["jnd"], known["jnd"])

    def test_the_page_and_the_datasets(self):
        status, page = self.server.ask("/")
        self.assertEqual(status, 200)
        self.assertIn(b'id="report"', page)
        _, told = self.server.ask_json("/v1/datasets")
        (dataset,) = told["datasets"]
        self.assertEqual((dataset["name"], dataset["state"]), ("small", "done"))
        _, health = self.server.ask_json("/v1/health")
        self.assertEqual((health["ready"], health["identify"]), (True, False))
        # Events tell how builds are.
        with contextlib.closing(http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=30)) as connection:
            connection.request("GET", "/v1/events")
            reply = connection.getresponse()
            self.assertEqual(reply.getheader("Content-Type"), "text/event-stream")
            event = json.loads(reply.fp.readline() and reply.fp.readline().removeprefix(b"data: "))
            self.assertEqual(event["builds"][0]["state"], "done")

    def test_bad_requests_get_json_with_the_words_of_the_command_line(self):
        long = wav_bytes(numpy.zeros(6 * 44100))
        cases = [
            ("/v1/features", b"", 400, "the request has no sound"),
            ("/v1/features", b"RIFFjunk", 400, "the recording"),
            ("/v1/features", long, 400, "the recording lasts 6 s, and 5 s are taken"),
            ("/v1/features?max_featurs=3", self.clip, 400, "max_featurs"),
            ("/v1/features?max_features=-1", self.clip, 400, "max_features"),
            ("/v1/features?max_frequency=high", self.clip, 400, "max_frequency"),
            ("/v1/fit?model=none", self.clip, 400, "none"),
            ("/v1/compare", self.clip, 400, 'no file "reference"'),
            ("/v1/identify", self.clip, 501, "no trained networks"),
            ("/v1/nothing", b"x", 404, "no such page"),
            ("/" + "x" * 2000, None, 414, "too long"),
            ("/../../etc/passwd", None, 404, "no such page"),
        ]
        for path, body, code, message in cases:
            with self.subTest(path=path[:40]):
                status, told = self.server.ask_json(path, body)
                self.assertEqual(status, code, told)
                self.assertIn(message, told["error"]["message"])
                self.assertNotIn("/tmp", json.dumps(told))
        status, told = self.server.ask_json("/v1/datasets", headers={"Host": "elsewhere.example"})
        self.assertEqual(status, 403, told)
        nothing = wav_bytes(numpy.zeros(0))
        form = b"".join(b"--x\r\nContent-Disposition: form-data; name=\"%s\"; filename=\"a\"\r\n\r\n%s\r\n" %
                        (name, nothing) for name in (b"reference", b"other")) + b"--x--\r\n"
        status, told = self.server.ask_json(
            "/v1/compare", form, {"Content-Type": "multipart/form-data; boundary=x"})
        self.assertIn(status, (200, 400), told)
        status, told = self.server.ask_json("/v1/features", bytes(3_000_000))
        self.assertEqual(status, 413, told)
        # Nothing to hear is an answer.
        self.assertIn("too short", self.server.ask_json("/v1/features", wav_bytes(numpy.zeros(0)))[1]["nothing"])
        # What went before has left nothing behind.
        self.assertEqual(self.server.ask("/v1/features", self.clip)[0], 200)

    def test_many_clients_at_once(self):
        expected = self.server.ask_json("/v1/features?max_features=2", self.clip)[1]["features"]
        with concurrent.futures.ThreadPoolExecutor(20) as pool:
            replies = list(pool.map(
                lambda _: self.server.ask_json("/v1/features?max_features=2", self.clip), range(60)))
        for status, told in replies:
            self.assertEqual((status, told.get("features")), (200, expected))

    def test_clients_that_hang_or_go_away_hold_nobody_up(self):
        head = b"POST /v1/features HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 100000\r\n\r\n"
        with contextlib.ExitStack() as stack:
            for text in [b"", b"GET ", head, head + self.clip[:2000]] * 8:
                client = stack.enter_context(socket.create_connection(("127.0.0.1", self.server.port)))
                client.sendall(text)
            start = time.monotonic()
            self.assertEqual(self.server.ask("/v1/features", self.clip)[0], 200)
            self.assertLess(time.monotonic() - start, 20 * TIMEOUT_FACTOR)
        # One that does not wait for its reply.
        with socket.create_connection(("127.0.0.1", self.server.port)) as client:
            client.sendall(head.replace(b"100000", str(len(self.clip)).encode()) + self.clip)
        self.assertEqual(self.server.ask("/v1/health")[0], 200)

    def test_malformed_requests(self):
        generator = numpy.random.default_rng(1)
        pieces = [b"GET / HTTP/1.1\r\n", b"POST /v1/features HTTP/1.1\r\n", b"Host: x\r\n", b"Content-Length: -1\r\n",
                  b"Content-Length: 99999999999999999999\r\n", b"Transfer-Encoding: chunked\r\n\r\nFFFFFFFFFFFFFFFFF\r\n",
                  b"Content-Type: multipart/form-data\r\n", b"\r\n", b"\0\0", b"%00%ff%", b"Range: bytes=-1-1\r\n",
                  b"Expect: 100-continue\r\n", self.clip[:64], b"Content-Encoding: gzip\r\n", b"PRI * HTTP/2.0\r\n\r\n"]
        for _ in range(300):
            text = b"".join(pieces[i] for i in generator.integers(0, len(pieces), generator.integers(1, 7)))
            with socket.create_connection(("127.0.0.1", self.server.port)) as client:
                client.settimeout(0.01)
                with contextlib.suppress(OSError):
                    client.sendall(text)
                    client.recv(1000)
        self.assertEqual(self.server.ask("/v1/features", self.clip)[0], 200)

    def test_a_token_is_asked_for(self):
        (self.folder / "token").write_text("0123456789abcdef\n")
        server = Server("small", "--token", "token", cwd=self.folder)
        try:
            self.assertEqual(server.ask("/v1/datasets")[0], 401)
            self.assertEqual(server.ask("/v1/health")[0], 200)
            for word in ("Bearer 0123456789abcdeX", "0123456789abcdef", "Bearer "):
                self.assertEqual(server.ask("/v1/datasets", headers={"Authorization": word})[0], 401)
            self.assertEqual(
                server.ask("/v1/datasets", headers={"Authorization": "Bearer 0123456789abcdef"})[0], 200)
            self.assertEqual(server.ask("/v1/datasets?token=0123456789abcdef")[0], 200)
        finally:
            self.assertEqual(server.stop()[0], 0)
        (self.folder / "short").write_text("1234\n")
        for words, message in [(["--host", "0.0.0.0"], "no token is asked for"),
                               (["--token", "short"], "its first line has 4 characters"),
                               (["--token", "none"], "none")]:
            result = run("serve", "small", *words, "--port", "0", cwd=self.folder)
            self.assertEqual(result.returncode, 2, result.stdout)
            self.assertIn(message, result.stderr)
        self.assertEqual(run("serve", "nothing", cwd=self.folder).returncode, 2)

    def test_a_dataset_may_go_while_it_is_served(self):
        shutil.copytree(self.folder / "small", self.folder / "gone")
        server = Server("gone", cwd=self.folder)
        try:
            with contextlib.closing(http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)) as connection:
                connection.request("GET", "/v1/events")
                events = connection.getresponse()
                self.assertIn(b"done", events.readline())
                shutil.rmtree(self.folder / "gone")
                told = b""
                while b"error" not in told:
                    told = events.readline()
            self.assertEqual(server.ask("/v1/datasets")[0], 400)
            self.assertEqual(server.ask("/")[0], 400)
            self.assertEqual(server.ask("/v1/features", self.clip)[0], 200)
        finally:
            self.assertEqual(server.stop()[0], 0)

    def test_a_signal_lets_what_is_under_way_end(self):
        server = Server("small", cwd=self.folder)
        long = wav_bytes(ringing(4))
        with concurrent.futures.ThreadPoolExecutor(1) as pool:
            reply = pool.submit(server.ask, "/v1/features", long)
            time.sleep(0.3)
            code, _ = server.stop()
            self.assertEqual(reply.result()[0], 200)
        self.assertEqual(code, 0)


if __name__ == "__main__":
    unittest.main()
