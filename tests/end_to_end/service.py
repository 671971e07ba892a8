"""`carillon serve`: answers are those of the command line, bad requests get JSON, slow clients hold nobody up."""
import concurrent.futures
import contextlib
import http.client
import json
import shutil
import socket
import time
import unittest

import numpy
from program import TIMEOUT_FACTOR, FolderTest, run, run_json
from server import CONFIG, Server, ringing, wav_bytes


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
        for headers in ({"Host": "elsewhere.example"}, {"Host": "127.elsewhere.example"}, {"Host": "127.0.0.1.example:80"},
                        {"Origin": "http://elsewhere.example"}, {"Origin": "null"}):
            status, told = self.server.ask_json("/v1/features", self.clip, headers=headers)
            self.assertEqual(status, 403, (headers, told))
        for headers in ({"Host": "localhost:1"}, {"Host": "[::1]:1"}, {"Origin": "http://127.0.0.1:8750"}):
            self.assertEqual(self.server.ask("/v1/features", self.clip, headers=headers)[0], 200, headers)
        # A page is not copied once for each range that is asked for.
        self.server.ask("/")
        before = self.server.memory()
        self.assertEqual(self.server.ask("/", headers={"Range": "bytes=" + "0-," * 300 + "0-"})[0], 416)
        self.assertLess(self.server.memory(), before + 50e6)
        # What is too large is refused before it comes.
        with contextlib.closing(http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)) as connection:
            connection.putrequest("POST", "/v1/features")
            connection.putheader("Content-Length", "100000000")
            connection.endheaders()
            self.assertEqual(connection.getresponse().status, 413)
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
        # Clients that are silent, or in the middle of their request, are not waited for.
        idle = [self.enterContext(socket.create_connection(("127.0.0.1", server.port))) for _ in range(4)]
        for client, text in zip(idle, [b"", b"GET ", b"POST /v1/features HTTP/1.1\r\nContent-Length: 9\r\n\r\nRIFF",
                                       b"GET /v1/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"]):
            client.sendall(text)
        self.assertIn(b"ready", idle[3].recv(1000) + idle[3].recv(1000))
        long = wav_bytes(ringing(4))
        with concurrent.futures.ThreadPoolExecutor(1) as pool:
            reply = pool.submit(server.ask, "/v1/features", long)
            time.sleep(0.3)
            begin = time.monotonic()
            code, _ = server.stop()
            self.assertLess(time.monotonic() - begin, 4 * TIMEOUT_FACTOR)
            self.assertEqual(reply.result()[0], 200)
        self.assertEqual(code, 0)


if __name__ == "__main__":
    unittest.main()
