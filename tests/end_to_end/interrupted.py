"""A build of some seconds that other tests kill, stop and damage, and what they look at."""
import collections
import json
import pathlib
import time

from program import TIMEOUT_FACTOR, FolderTest, run_json

CONFIG = """
name: killed
seed: 4
materials: [steel, glass]
objects:
  - {shape: bar, count: 2, parameters: {length: [15 cm, 20 cm]}}
  - {shape: tile, count: 2}
  - {shape: block, count: 2}
modes: {max_modes: 10, max_frequency: 20 kHz, order: 2, element_size: 3 cm}
strikes: {per_object: 8}
audio: {seconds: 0.5 s, sample_rate: 22050 Hz}
listeners: [{position: [0.5, 0.3, 0.4]}]
radiation: {model: monopole}
room: {dimensions: [4 m, 3 m, 2.5 m], rt60: 0.4 s, count: 2}
noise: {kind: [white, pink], snr: [15 dB, 40 dB]}
mel: {bands: 16, frames: 9}
voxels: {resolution: 12}
files: {wav: true}
"""
TASKS = 12
SAMPLES = 6 * 2 * 8


def recorded(folder):
    """How often the journal says of each task that it is done; none where there is no journal."""
    path = folder / "journal.jsonl"
    text = path.read_text() if path.exists() else ""
    entries = [json.loads(line) for line in text[:text.rfind("\n") + 1].splitlines()]
    return collections.Counter(e["task"] for e in entries if e.get("ok"))


def descendants(pid):
    """Processes below `pid`, itself included, as far as they live."""
    children = collections.defaultdict(list)
    for status in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if fields[0] != "Z":
            children[int(fields[1])].append(int(status.parent.name))
    found, rest = [], [pid]
    while rest:
        one = rest.pop()
        found.append(one)
        rest += children[one]
    return found


def program(pid):
    """The name of what a process runs; "" where it is gone."""
    try:
        return pathlib.Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


def alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def wait_for(condition, seconds):
    end = time.monotonic() + seconds * TIMEOUT_FACTOR
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


class InterruptedTest(FolderTest):
    """Has the configuration in `config` and a build of it that was left alone in `whole`."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "little.yaml"
        cls.config.write_text(CONFIG)
        cls.whole = cls.folder / "whole"
        cls.summary = run_json("build", cls.config, "-o", cls.whole, ranks=2)
