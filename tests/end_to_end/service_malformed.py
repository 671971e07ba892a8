"""Requests that are broken in their bytes, their words or their sounds: each gets an answer or loses its
connection, no process ends, and the next good one is answered. CARILLON_LONG=1: ten thousand."""
import contextlib
import os
import socket
import unittest
import urllib.parse

import numpy
from program import TIMEOUT_FACTOR, FolderTest, run
from server import CONFIG, Server, ringing, wav_bytes

COUNT = 10_000 if os.environ.get("CARILLON_LONG") else 600
SEED = int(os.environ.get("CARILLON_SEED", "1"))
# Bytes that no library may trip over.
PIECES = [b"GET / HTTP/1.1\r\n", b"POST /v1/features HTTP/1.1\r\n", b"DELETE /v1/jobs/1 HTTP/1.1\r\n", b"Host: x\r\n",
          b"Content-Length: -1\r\n", b"Content-Length: 99999999999999999999\r\n", b"Content-Length: 10\r\n",
          b"Transfer-Encoding: chunked\r\n\r\nFFFFFFFFFFFFFFFFF\r\n", b"Transfer-Encoding: chunked\r\n\r\n-1\r\n",
          b"Content-Type: multipart/form-data\r\n", b"Content-Type: multipart/form-data; boundary=\r\n", b"\r\n", b"\0\0",
          b"%00%ff%", b"Range: bytes=-1-1\r\n", b"Range: bytes=9-1,,\r\n", b"Range: bytes=" + b"0-," * 300 + b"0-\r\n", b"Expect: 100-continue\r\n",
          b"Content-Encoding: gzip\r\n", b"Content-Encoding: br\r\n", b"PRI * HTTP/2.0\r\n\r\n", b"\xff\xfe\x00\x80"]
PATHS = ["features", "fit", "compare", "identify", "strike", "score", "jobs", "jobs/1", "jobs/-1", "datasets", "openapi.json",
         "../..", "%2e%2e/x", "features/..;"]
WORDS = ["max_features", "max_frequency", "onset", "method", "model", "estimator", "object", "material", "at", "seed", "task",
         "entry", "dataset", "command", "ranks", "as", "seconds", "sample_rate", "token", ""]
VALUES = ["", "1", "-1", "1e999", "nan", "inf", "0x10", "peaks", "bar-000", "bar:length=1e9", "bell", "steel", "a=b", "../x",
          "/etc/passwd", "\0", "\u00e9" * 300, "1,2", "1,2,3", "NaN,0,0", "build", "--help", "%", "9" * 400]


class Malformed(FolderTest):
    def setUp(self):
        (self.folder / "small.yaml").write_text(CONFIG)
        self.assertEqual(run("build", "small.yaml", cwd=self.folder).returncode, 0)
        self.server = Server("small", "--jobs", "jobs", "--max-jobs", "5", "--ranks", "1", "--longest-clip", "2",
                             "--time-limit", 60 * TIMEOUT_FACTOR, cwd=self.folder)
        self.addCleanup(self.server.process.kill)
        self.generator = numpy.random.default_rng(SEED)
        self.clip = wav_bytes(ringing(0.2))
        self.workers = sorted(self.server.workers())

    def one_of(self, things):
        return things[self.generator.integers(len(things))]

    def bytes(self):
        """Pieces of requests in any order."""
        return b"".join(self.one_of(PIECES) for _ in range(self.generator.integers(1, 7)))

    def body(self):
        """A sound, a form, a configuration or a table with some of its bytes changed, or its end cut off."""
        sound = b"--x\r\nContent-Disposition: form-data; name=\"reference\"\r\n\r\n" + self.clip + b"\r\n--x--\r\n"
        data = bytearray(self.one_of([self.clip, sound, CONFIG.encode(), b"sample,class\nbar-000/steel/1/strike-0000,steel\n",
                                      b"objects: &a [*a]\n", b"{" * 5000, b""]))
        for _ in range(self.generator.integers(0, 8) if data else 0):
            data[self.generator.integers(min(len(data), self.one_of([44, len(data)])))] = self.generator.integers(256)
        return bytes(data[:len(data) - self.generator.integers(0, len(data))] if data and self.generator.integers(3) == 0 else data)

    def request(self):
        """One that is read as HTTP, whatever it asks."""
        query = "&".join(f"{self.one_of(WORDS)}={urllib.parse.quote(self.one_of(VALUES), safe=self.one_of(['', '=/%']))}"
                         for _ in range(self.generator.integers(0, 4)))
        body = self.body()
        kind = self.one_of(["", "Content-Type: multipart/form-data; boundary=x\r\n", "Content-Type: application/json\r\n"])
        return (f"{self.one_of(['GET', 'POST', 'POST', 'DELETE', 'PUT'])} /v1/{self.one_of(PATHS)}?{query} HTTP/1.1\r\n"
                f"Host: 127.0.0.1\r\n{kind}Content-Length: {len(body)}\r\n\r\n").encode() + body

    def test_malformed_requests(self):
        for number in range(COUNT):
            text = self.bytes() if number % 3 == 0 else self.request()
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.server.port)) as client:
                client.settimeout(0.02 if number % 3 == 0 else self.one_of([0.02, 2.0]))
                client.sendall(text)
                client.recv(1000)
            if number % 100 == 99:
                self.assertIsNone(self.server.process.poll())
                self.assertEqual(self.server.ask("/v1/features", self.clip)[0], 200, f"{number} of seed {SEED}")
        # What computes has outlived them all, and the jobs among them are cancelled or were refused.
        self.assertEqual(sorted(self.server.workers()), self.workers)
        for job in self.server.ask_json("/v1/jobs")[1]["jobs"]:
            self.server.ask(f"/v1/jobs/{job['id']}", method="DELETE")
            self.server.job(job["id"])
        code, err = self.server.stop()
        self.assertEqual(code, 0, err)
        for sanitizer in ("ERROR: ", "runtime error: "):
            self.assertNotIn(sanitizer, err)


if __name__ == "__main__":
    unittest.main()
