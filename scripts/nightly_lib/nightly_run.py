"""One nightly run: every benchmark several times with the calibration load in between, held against
earlier nightly runs; what seems slower is looked at twice."""
import collections
import shutil
import statistics
from dataclasses import dataclass, field

from nightly_lib import benchmarks, boards, calibration, history, measures, verdicts

Settings = collections.namedtuple(
    "Settings", "program ranks repeats timeout folder remote machine program_hash")


@dataclass
class Outcome:
    """A benchmark of this run."""
    benchmark: benchmarks.Benchmark
    output: object            # folder of its last repetition
    ok: bool = True
    message: str = ""
    seconds: float = 0.0
    takes: list = field(default_factory=list)
    loads: list = field(default_factory=list)   # seconds of the calibration load
    looks: list = field(default_factory=list)   # measures of each look
    verdicts: dict = field(default_factory=dict)  # name -> (Measure, Verdict, past)

    def spectra(self):
        return self.takes[-1].spectra if self.takes else {}


def look(outcome, settings, nominal):
    """Repetitions of a benchmark, and their measures. The first that fails ends it.

    nominal: seconds that the calibration load took on the first nightly run, or None on that one. Times
    are told as its processors would have taken.
    """
    begin, takes, loads = len(outcome.takes), outcome.takes, outcome.loads
    log = settings.folder / f"{outcome.benchmark.name}.log"
    loads.append(calibration.measure(settings.ranks))
    first_load = len(loads) - 1
    for _ in range(settings.repeats):
        shutil.rmtree(outcome.output, ignore_errors=True)
        words = benchmarks.command(outcome.benchmark, outcome.output, settings.program,
                                   settings.ranks)
        run = benchmarks.run(words, log, settings.timeout)
        outcome.seconds += run.seconds
        if not run.ok:
            outcome.ok, outcome.message = False, run.message
            return
        boards.write(settings.program, outcome, log)
        try:
            takes.append(measures.collect(run, outcome.output, settings.remote))
        except (OSError, KeyError, TypeError, ValueError) as error:
            outcome.ok, outcome.message = False, f"unreadable results: {error!r}"
            return
        loads.append(calibration.measure(settings.ranks))
    load = statistics.median(loads[first_load:])
    outcome.looks.append(measures.combine(takes[begin:], (nominal or load) / load))


def judge(outcomes, records, settings):
    """Fills the verdicts of every benchmark that ran; noise is pooled over all of them."""
    rows = []
    for outcome in outcomes:
        if outcome.ok:
            past = history.Past(records, settings.machine, outcome.benchmark.name,
                                outcome.benchmark.hash)
            same = past.rows and _same_program(past.rows[-1][2], outcome, settings)
            rows += [(outcome, one) for one in history.series(
                past, _of_all_looks(outcome.looks), outcome.spectra(), same)]
    found = verdicts.judge([one for _, one in rows])
    for outcome in outcomes:
        outcome.verdicts = {}
    for (outcome, one), verdict in zip(rows, found):
        outcome.verdicts[one.measure.name] = (one.measure, verdict, one.past)


def _of_all_looks(looks):
    """The least of times and memory: every look must find a change for the worse."""
    found = dict(looks[0])
    for other in looks[1:]:
        for name, measure in other.items():
            if measure.kind in verdicts.NOISY and name in found:
                if measure.value < found[name].value:
                    found[name] = measure
            else:
                found[name] = measure
    return found


def suspects(outcomes):
    """Benchmarks with a time or memory that seems to have grown."""
    return [outcome for outcome in outcomes
            if any(verdict.word in verdicts.ALARMS and measure.kind in verdicts.NOISY
                   for measure, verdict, _ in outcome.verdicts.values())]


def _same_program(last, outcome, settings):
    return (last["program"] == settings.program_hash
            and last["libraries"] == outcome.takes[-1].versions)


def nominal_load(records, machine):
    """The calibration load of the first nightly run on such processors; None before."""
    for record in records:
        if record.get("machine") == machine and record.get("calibration_s"):
            return record["calibration_s"]
    return None


def run_benchmarks(chosen, records, settings, look=look):
    """Every benchmark, judged; a second look at those that seem slower.

    look: fills one more look of an outcome, as the function of that name does.
    """
    nominal = nominal_load(records, settings.machine)
    outcomes = [Outcome(one, settings.folder / one.name) for one in chosen]
    for outcome in outcomes:
        look(outcome, settings, nominal)
        nominal = nominal or (statistics.median(outcome.loads) if outcome.looks else None)
    judge(outcomes, records, settings)
    again = suspects(outcomes)
    for outcome in again:
        look(outcome, settings, nominal)
    if again:
        judge(outcomes, records, settings)
    return outcomes, nominal


def record_of(outcomes, records, settings):
    """What the history keeps: runs, and spectra that it does not have yet."""
    known = {key for record in records for key in record.get("spectra", {})}
    spectra, runs = {}, []
    for outcome in outcomes:
        row = {"name": outcome.benchmark.name, "hash": outcome.benchmark.hash, "ok": outcome.ok,
               "seconds": round(outcome.seconds, 3), "message": outcome.message}
        if outcome.ok:
            keys = {}
            for label, spectrum in outcome.spectra().items():
                keys[label], digits = history.spectrum_key(spectrum)
                if keys[label] not in known:
                    spectra[keys[label]] = digits
            row |= {"program": settings.program_hash, "libraries": outcome.takes[-1].versions,
                    "load_s": outcome.loads, "spectra": keys,
                    "measures": {name: {"kind": measure.kind, "unit": measure.unit,
                                        "value": _kept(outcome, measure), "verdict": verdict.word}
                                 for name, (measure, verdict, _) in outcome.verdicts.items()}}
        runs.append(row)
    return {"runs": runs, "spectra": spectra}


def _kept(outcome, measure):
    """Of several looks the mean, so that second looks do not make the baseline faster."""
    values = [look[measure.name].value for look in outcome.looks if measure.name in look]
    if measure.kind in verdicts.NOISY and values and measure.value is not None:
        return statistics.mean(values)
    return measure.value
