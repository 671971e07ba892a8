"""Clips of $CARILLON_TEST_DATA, what the program finds in them, and how that compares with their partials."""
import csv
import json
import os
import resource
import subprocess
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from recordings_lib import partials

LINE = 2  # Hz, and two bins: what is so near to a partial is of its line
FREQUENCY = 0.5  # Hz, or a bin
DECAY = 0.15
# Words of MANIFEST.csv for which the papers' table has a material under another name.
MATERIALS = {"metal(steel)": "steel", "metal(iron)": "iron", "wood(hard)": "wood", "wood(rosewood?)": "wood",
             "plastic(polycarbonate)": "polycarbonate"}


@dataclass
class Clip:
    path: Path
    material: str
    answer: dict = field(default_factory=dict)
    seconds: float = 0
    width: float = 0  # of a bin [Hz]
    partials: list = field(default_factory=list)
    rows: list = field(default_factory=list)  # of the table of features

    @property
    def features(self):
        return self.answer["features"]

    def matches(self):
        """(partial, feature or None) of the isolated ones."""
        return [(partial, self.feature_of(partial)) for partial in self.partials
                if partial.decay_rate is not None]

    def feature_of(self, partial):
        """The one of the highest spectrum, a / d, in the line of a partial."""
        line = max(LINE, 2 * self.width)
        near = [feature for feature in self.features if abs(feature["frequency_hz"] - partial.frequency) <= line]
        return max(near, key=lambda feature: feature["amplitude"] / feature["decay_rate_per_s"], default=None)

    def right_frequency(self, partial, frequency):
        return abs(frequency - partial.frequency) <= max(FREQUENCY, self.width)


def right_decay(partial, decay_rate):
    return abs(decay_rate / partial.decay_rate - 1) <= DECAY


def program():
    """The program: $CARILLON, else that of ./scripts/build."""
    built = Path(__file__).resolve().parents[2] / "build" / "carillon"
    found = os.environ.get("CARILLON") or (built if built.exists() else None)
    return str(found) if found else sys.exit("check_recordings: no carillon; ./scripts/build first")


def run(*arguments):
    """The answer of the program, and its processor time [s]."""
    used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    before = used()
    done = subprocess.run([program(), *map(str, arguments), "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        return {"error": done.stderr.strip().splitlines()[0]}, used() - before
    return json.loads(done.stdout), used() - before


def all_clips(words):
    """Those whose names have one of the words; all without any."""
    folder = os.environ.get("CARILLON_TEST_DATA")
    if not folder:
        sys.exit("check_recordings: CARILLON_TEST_DATA is not set")
    with open(Path(folder) / "recordings" / "MANIFEST.csv", newline="", encoding="utf-8") as text:
        clips = [Clip(Path(folder) / "recordings" / row["file"], MATERIALS.get(row["material"], row["material"]))
                 for row in csv.DictReader(text)]
    clips += [Clip(path, "ceramic") for path in sorted((Path(folder) / "real").glob("*.wav"))]
    return [clip for clip in clips if not words or any(word in clip.path.name for word in words)]


def line_together(clip, partial, rate, count):
    """Decay rate of all features about a partial together, by the regression that the partial had; None where
    it is not straight."""
    t = clip.answer["begin_s"] - clip.answer["onset_s"] + np.arange(count) / rate
    sound = np.zeros(count)
    for feature in clip.features:
        if abs(feature["frequency_hz"] - partial.frequency) < partial.clear:
            phase = 2 * np.pi * feature["frequency_hz"] * t + feature["phase_rad"]
            sound += feature["amplitude"] * np.exp(-feature["decay_rate_per_s"] * t) * np.cos(phase)
    again = replace(partial)
    partials.decay(sound, rate, again)
    return again.decay_rate


def analyse(clip, table):
    """Runs the program and the check on one clip; `table` takes the features."""
    clip.answer, clip.seconds = run("features", clip.path, "--csv", table)
    if "error" in clip.answer:
        sys.exit(f"check_recordings: {clip.path.name}: {clip.answer['error']}")
    clip.rows = table.read_text(encoding="utf-8").splitlines()
    rate, samples = partials.read(clip.path)
    rung = samples[round(clip.answer["begin_s"] * rate):round(clip.answer["end_s"] * rate)]
    # The second channel of a hammer's clips is its force.
    if clip.path.name.startswith("hammer"):
        rung = rung[:, :1]
    clip.partials, clip.width = partials.partials(rung, rate)
    x = rung[:, (rung**2).sum(axis=0).argmax()]
    for partial, feature in clip.matches():
        partial.harminv = partials.harminv(x, rate, partial.frequency)
        # Amplitudes of a feature are those of one channel.
        if rung.shape[1] == 1 and not (feature and right_decay(partial, feature["decay_rate_per_s"])):
            partial.together = line_together(clip, partial, rate, len(x))
