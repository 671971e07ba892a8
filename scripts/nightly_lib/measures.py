"""What one run of a benchmark left in its folder, as measures (docs/nightly.md lists them)."""
import hashlib
import json
import math
import statistics

import h5py
import numpy
from nightly_lib.verdicts import DIFFERS, Measure

PITCH_TOLERANCE = 0.1  # cents
BYTES_TOLERANCE = 0.01


class Collected:
    """Measures by name, and spectra: label -> lists of frequencies [Hz]. A material's is the speed
    sqrt(E / density), which every pitch is in proportion to."""

    def __init__(self):
        self.measures, self.spectra, self.versions = {}, {}, {}

    def add(self, name, kind, unit, value, tolerance=0.0, pool=""):
        self.measures[name] = Measure(name, kind, unit, value, tolerance, pool)

    def add_time(self, name, seconds, pool="processor"):
        """Adds to a time. Pool `stage`: not counted by a processor's clock, so noisier."""
        old = self.measures[name].value if name in self.measures else 0.0
        self.add(name, "time", "s", old + seconds, pool=pool)


def collect(run, output, remote):
    """Everything that is measured of a run; `remote`: its ranks are not this process's children."""
    found = Collected()
    resident = 0 if remote else run.resident
    if not remote:
        found.add_time("processor time", run.processor_s)
    failures = 0
    for path in sorted(output.rglob("dataset.json")):
        label = str(path.parent.relative_to(output))
        _dataset(found, path.parent, "" if label == "." else label + "/")
        failures += len(_read(path.parent / "failures.json"))
    if (output / "trace.json").exists():
        resident = max([resident * (not remote)] + [rank["peak_memory_bytes"] for rank in
                                                    _read(output / "trace.json")["ranks"]])
    for name, take in (("accuracy.json", _accuracy), ("evaluation/damping.json", _damping),
                       ("evaluation/classification.json", _classification)):
        if (output / name).exists():
            failures += take(found, _read(output / name))
    for path in sorted(output.rglob("evaluation/leaderboard-*.json")):
        _leaderboard(found, _read(path))
    found.add("failures", "count", "", failures)
    if resident:
        found.add("peak memory", "memory", "bytes", resident, pool="memory")
    return found


def _read(path):
    return json.loads(path.read_text())


def _dataset(found, folder, label):
    """Times, modes, bits and bytes of one dataset."""
    document = _read(folder / "dataset.json")
    found.versions = document["versions"]
    for line in (folder / "journal.jsonl").read_text().splitlines():
        _task(found, json.loads(line))
    for material in document["materials"]:
        speed = math.sqrt(material["youngs_modulus_pa"] / material["density_kg_m3"])
        found.spectra[f"{label}material {material['name']}"] = [[speed]]
    for path in sorted((folder / "modes").glob("*.h5")):
        with h5py.File(path) as file:
            sets = [file[name] for name in sorted(file) if name.startswith("set-")]
            found.spectra[label + path.stem] = [
                (numpy.sqrt(one["eigenvalues"][:]) / (2 * math.pi)).tolist() for one in sets]
            errors = [one["pitch_errors"][:].max() for one in sets
                      if "pitch_errors" in one and len(one["pitch_errors"])]
        if errors:
            worst = float(max(errors))
            found.add(f"{label}{path.stem} estimated error", "accuracy", "cents", worst,
                      max(PITCH_TOLERANCE, 0.01 * worst))
    files = sorted((one["path"], one["sha256"], one["bytes"]) for one in document["files"])
    bits = hashlib.sha256(repr([one[:2] for one in files]).encode()).hexdigest()[:16]
    found.add(f"{label}files", "bits", "", bits)
    size = sum(one[2] for one in files)
    found.add(f"{label}size", "bytes", "bytes", size, BYTES_TOLERANCE * size)


def _task(found, line):
    """A task's processor time; of its stages and effects what they took while no other program had
    the processors, if those were taken away evenly."""
    times = line.get("times")
    if not times or not line.get("ok"):
        return
    kind, name = line["task"].rsplit("/", 2)[-2:]
    found.add_time(f"modes of {name}" if kind == "modes" else "samples", times["cpu_s"])
    own = times["queued_s"] / max(1, times.get("width", 1))
    fraction = max(0.0, 1 - own / times["seconds"]) if times["seconds"] > 0 else 1.0
    for group in ("stages", "effects"):
        for stage, entry in line.get("trace", {}).get(group, {}).items():
            found.add_time(stage, entry["seconds"] * fraction, "stage")


def _accuracy(found, document):
    """True errors of every level, how well they were estimated, seconds of each object's levels."""
    failures = 0
    for body in document["objects"]:
        name, ratios = body["name"], []
        failures += bool(body.get("failure")) and not body.get("passed_over")
        if "reference" in body and "frequencies_hz" in body["reference"]:
            found.spectra[f"{name} reference"] = [body["reference"]["frequencies_hz"]]
        for level in body.get("levels", []):
            if "failure" in level or "worst_cents" not in level:
                continue
            label = (f"{name} order {level['order']}, size {level['size_factor'] or 'chosen'}, "
                     f"{level['element_size_m'] * 1e3:.3g} mm, {level['tolerance']:g}")
            worst = level["worst_cents"]
            found.add(f"{label} error", "accuracy", "cents", worst,
                      max(PITCH_TOLERANCE, 0.01 * worst))
            found.add_time(f"{name} levels", level["processor_seconds"])
            if worst > PITCH_TOLERANCE and level["estimated_worst_cents"] > 0:
                ratios.append(abs(math.log(level["estimated_worst_cents"] / worst)))
        if ratios:
            found.add(f"{name} estimate off by a factor", "accuracy", "",
                      math.exp(max(ratios)), 0.05 * math.exp(max(ratios)))
        for chosen in body.get("chosen", []):
            failures += "failure" in chosen
    return failures + _studies(found, document)


def _studies(found, document):
    """How far sounds with less and features of recordings are from what they should be."""
    sound, features = (document.get(key, {}) for key in ("sound", "features"))
    for level in sound.get("levels", []):
        found.add_time("sound levels", level["seconds"])
        if level["error_db"]:
            found.add(f"sound {level['key']} {level['value']} error", "accuracy", "dB",
                      level["error_db"], max(0.01, 0.01 * level["error_db"]))
    for level in features.get("levels", []):
        label = f"features {level['method']} {level['modes']} modes {level['snr_db']:g} dB"
        found.add_time(f"features {level['method']}", level["seconds"])
        found.add(f"{label} found", "score", "", level["found"], 0.01)
        for key in ("bounds_frequency", "bounds_decay_rate"):
            if level[key] is not None:
                found.add(f"{label} {key.removeprefix('bounds_').replace('_', ' ')} error",
                          "accuracy", "bounds", level[key], 0.05 * level[key])
    return ("failure" in sound) + ("failure" in features)


def _damping(found, document):
    """Median errors of all materials, from the largest sets."""
    largest = max(document["sounds"])
    for row in document["errors"]:
        if row["material"] == "all" and row["sounds"] == largest and row["median"] is not None:
            name = " ".join(str(row[key]) for key in
                            ("condition", "features", "from", "estimator", "parameter"))
            found.add(f"{name} error", "accuracy", "", row["median"], max(0.005, 0.05 * row["median"]))
    return len(document["failures"])


def _classification(found, document):
    """Accuracies; what is less than half of their interval is chance."""
    for row in document["rows"]:
        interval = row["accuracy"]["interval95"]
        found.add(f"{row['dataset']} {row['task']} {row['method']} accuracy", "score", "",
                  row["accuracy"]["mean"], (interval[1] - interval[0]) / 2 if interval else 0.05)
    return 0


def _leaderboard(found, board):
    """What others' answers were worth, by the measure that ranks; the run's own classifiers are in
    classification.json."""
    for row in board["rows"]:
        measure = row["measures"][0]
        if row["trained_here"] or measure["mean"] is None:
            continue
        interval = measure["interval95"]
        half = (interval[1] - interval[0]) / 2 if interval else 0.05 * abs(measure["mean"])
        found.add(f"{board['dataset']} {board['task']} {row['entry']} {measure['name']}",
                  "score" if board["more_is_better"] else "accuracy", measure["unit"].replace("%", ""),
                  measure["mean"], half)


def combine(takes, scale):
    """One Measure of several repetitions: medians of times, times `scale`; the worst of the rest."""
    measures = {}
    for name in {name: None for take in takes for name in take.measures}:
        rows = [take.measures.get(name) for take in takes]
        measure = next(row for row in rows if row)
        values = [row.value for row in rows if row]
        if measure.kind in ("time", "memory"):
            value = statistics.median(values) * (scale if measure.kind == "time" else 1.0)
        elif measure.kind == "bits":
            value = values[0] if len(set(values)) == 1 else DIFFERS
        else:
            value = min(values) if measure.kind == "score" else max(values)
        measures[name] = Measure(name, measure.kind, measure.unit, value, measure.tolerance,
                                 measure.pool)
    return measures


def drift(spectrum, reference):
    """Largest distance of a mode from the reference's of its rank, in cents."""
    return max((abs(1200 * math.log2(found / known)) for one, other in zip(spectrum, reference)
                for found, known in zip(one, other)), default=0.0)
