"""The file of all nightly runs: one JSON object a line, appended and synced; docs/nightly.md has its keys."""
import contextlib
import fcntl
import fnmatch
import hashlib
import json
import os
import pathlib

from nightly_lib import measures
from nightly_lib.benchmarks import Unusable
from nightly_lib.verdicts import FLAGGED, Measure, Series, baseline_start

FORMAT = 1


def read(path):
    """All records, oldest first, and how many lines could not be read (a crash cuts the last one)."""
    records, unreadable = [], 0
    if not path.exists():
        return records, unreadable
    for line in path.read_bytes().split(b"\n"):
        if not line.strip():
            continue
        try:
            record = json.loads(line)
        except ValueError:
            unreadable += 1
            continue
        if record.get("format", 0) > FORMAT:
            raise Unusable(f"{path}: written by a newer scripts/nightly; use that one, or another "
                           "--history")
        records.append(record)
    return records, unreadable


def append(path, record):
    """Adds a record in one write, on disk when this returns; closes a line that a crash cut."""
    text = json.dumps({"format": FORMAT, **record}, allow_nan=False).encode() + b"\n"
    file = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
    try:
        size = os.fstat(file).st_size
        if size and os.pread(file, 1, size - 1) != b"\n":
            text = b"\n" + text
        if os.write(file, text) != len(text):
            raise OSError(f"{path}: written in part; is the disk full?")
        os.fsync(file)
    finally:
        os.close(file)
    folder = os.open(path.parent, os.O_RDONLY)
    os.fsync(folder)
    os.close(folder)


@contextlib.contextmanager
def locked(*paths):
    """Holds lock files until the end of the block; Unusable where another nightly run has one."""
    with contextlib.ExitStack() as stack:
        for path in sorted({str(pathlib.Path(path).resolve()) for path in paths}):
            file = stack.enter_context(open(path, "a"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise Unusable(f"another nightly run is running: it holds {path}") from error
        yield


def accept(path, reason, patterns):
    """Marks what the last nightly run told as accepted; returns the names of those measures."""
    records, _ = read(path)
    nightly_runs = [record for record in records if "runs" in record]
    if not nightly_runs:
        raise Unusable(f"{path}: no nightly run to accept")
    names = [f"{run['name']}: {name}" for run in nightly_runs[-1]["runs"]
             for name, row in run.get("measures", {}).items()
             if row["verdict"] in FLAGGED]
    names = [name for name in names
             if not patterns or any(fnmatch.fnmatchcase(name, one) for one in patterns)]
    if not names:
        raise Unusable("the last nightly run told no change" + (" of these measures" if patterns else ""))
    append(path, {"accept": reason, "nightly_run": nightly_runs[-1]["date"], "measures": names})
    return names


class Past:
    """What earlier nightly runs found of one benchmark on the same processors with the same ranks."""

    def __init__(self, records, machine, name, digest):
        self.rows = [(i, record["date"], run) for i, record in enumerate(records)
                     if record.get("machine") == machine for run in record.get("runs", [])
                     if run["name"] == name and run["hash"] == digest and run["ok"]]
        self.marks = [(i, set(record["measures"])) for i, record in enumerate(records)
                      if "accept" in record]
        self.spectra = {key: value for record in records
                        for key, value in record.get("spectra", {}).items()}
        self.name = name

    def of(self, measure):
        """(past, start) of a measure: its values, and the first of them of the present baseline."""
        rows = [(i, (date, run["measures"][measure]["value"], run["measures"][measure]["verdict"]))
                for i, date, run in self.rows if measure in run["measures"]]
        accepted = [max(k for k, (i, _) in enumerate(rows) if i < mark) for mark, names in self.marks
                    if f"{self.name}: {measure}" in names and rows and rows[0][0] < mark]
        past = [row for _, row in rows]
        return past, baseline_start(past, accepted)

    def reference(self, label):
        """The spectrum that drift is measured from; None on a first nightly run."""
        rows = [run["spectra"][label] for _, _, run in self.rows if label in run["spectra"]]
        _, start = self.of(f"{label} pitch")
        return self.spectra.get(rows[start]) if start < len(rows) else None

    def missing(self, found):
        """Measures of the last nightly run that this run lacks, without those whose end was accepted."""
        if not self.rows:
            return []
        i, _, run = self.rows[-1]
        gone = [Measure(name, row["kind"], row["unit"], None) for name, row in run["measures"].items()
                if name not in found]
        ended = {name for mark, names in self.marks if mark > i for name in names}
        return [one for one in gone if f"{self.name}: {one.name}" not in ended]


def series(past, found, spectra, same_program):
    """This run's measures of a benchmark with their earlier nightly runs.

    same_program: of the last nightly run's version, commit and libraries: only then do other bits tell
    that something is wrong.
    """
    found = dict(found)
    for label, spectrum in spectra.items():
        reference = past.reference(label)
        cents = measures.drift(spectrum, reference) if reference else 0.0
        found[f"{label} pitch"] = Measure(f"{label} pitch", "pitch", "cents", cents,
                                          measures.PITCH_TOLERANCE)
        modes = sum(map(len, spectrum))
        if modes > 1:
            found[f"{label} modes"] = Measure(f"{label} modes", "number", "modes", modes)
    result = []
    for measure in [*found.values(), *past.missing(found)]:
        rows, start = past.of(measure.name)
        note = "" if same_program or measure.kind != "bits" else "another program, other bits"
        result.append(Series(measure, rows, start, note))
    return result


def spectrum_key(spectrum):
    """Spectra are kept once, under this hash of their digits."""
    digits = [[float(f"{value:.10g}") for value in one] for one in spectrum]
    return hashlib.sha256(json.dumps(digits).encode()).hexdigest()[:16], digits
