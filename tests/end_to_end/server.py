"""A service that tests ask, a dataset that it serves in a second, and sounds."""
import json
import os
import pathlib
import signal
import struct
import subprocess
import time
import urllib.error
import urllib.parse
import urllib.request

import numpy
from program import CARILLON, TIMEOUT_FACTOR

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

    def __init__(self, *arguments, cwd, port=0, environment=None, before=None):
        """environment: beside this process's; before: called in the child before the program is."""
        self.process = subprocess.Popen([CARILLON, "serve", *map(str, arguments), "--port", str(port)], cwd=cwd,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        env={**os.environ, **(environment or {})}, preexec_fn=before)
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
        """The most that the service itself has held [bytes]."""
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.split("VmHWM:")[1].split()[0]) * 1024

    def job(self, number, until=("done", "failed", "cancelled"), seconds=120):
        """A job's document once its state is one of these."""
        end = time.monotonic() + seconds * TIMEOUT_FACTOR
        while True:
            status, job = self.ask_json(f"/v1/jobs/{number}")
            if status == 200 and job["state"] in until:
                return job
            if time.monotonic() > end:
                raise AssertionError(job)
            time.sleep(0.05)

    def workers(self):
        children = pathlib.Path(f"/proc/{self.process.pid}/task").glob("*/children")
        pids = [int(pid) for listed in children for pid in listed.read_text().split()]
        return [pid for pid in pids if b"answer" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()]

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        _, err = self.process.communicate(timeout=60 * TIMEOUT_FACTOR)
        return self.process.returncode, err
