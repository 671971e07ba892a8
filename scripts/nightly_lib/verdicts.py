"""What became slower or less accurate beyond noise: a pure function of this run's values and earlier
nightly runs'. docs/nightly.md states the rule and its error rates; tests/end_to_end/nightly.py measures
them."""
import math
import statistics
from dataclasses import dataclass, field

LEARNING = 5       # nightly runs before times are judged
RECENT = 20        # nightly runs that this run is compared with
FIRST = 7          # nightly runs of a baseline that its beginning is taken from
LAST = 5           # nightly runs, with this run, that are compared with the beginning: slow drift
IMPROVED = 5       # nightly runs in a row after which an improvement is the new baseline by itself
FALSE_ALARMS = 1e-3   # wanted: nightly runs with a false alarm, if noise were normal and known
MIN_CHANGE = 0.05   # of a time: less is never told
MIN_SECONDS = 0.05  # likewise
PRIOR = 3             # degrees of freedom that the noise of other measures counts for
MIN_NOISE = 0.01    # of a time from run to run: none is assumed to be quieter
NOISY = ("time", "memory")
ALARMS = ("slower", "worse")
DIFFERS = "differs between repetitions"
FLAGGED = ("slower", "faster", "worse", "better")


@dataclass
class Measure:
    """One number of a nightly run.

    kind: time and memory (noisy; less is better), accuracy (an error; less is better), score (more is
    better), pitch (drift from the baseline in cents), count (failures; less is better), number (any
    change is wrong), bits (a hash), bytes. `tolerance` is the change that counts as none; measures of
    one `pool` are about equally noisy.
    """
    name: str
    kind: str
    unit: str
    value: float | str | None
    tolerance: float = 0.0
    pool: str = ""


@dataclass
class Series:
    """A measure with its earlier nightly runs, oldest first.

    past: (date, value, verdict) of comparable nightly runs. start: index of the first that belongs to the
    present baseline. note: said beside the verdict.
    """
    measure: Measure
    past: list = field(default_factory=list)
    start: int = 0
    note: str = ""

    def logs(self):
        return [math.log(value) for _, value, _ in self.past if _positive(value)]

    def baseline(self):
        """Values that this run is held against: without those that raised an alarm since it began."""
        since = self.past[self.start:]
        return [value for i, (_, value, verdict) in enumerate(since)
                if value is not None and (i == 0 or verdict not in FLAGGED)]


@dataclass
class Verdict:
    word: str                 # steady, slower, faster, worse, better, new or learning
    typical: float | str | None
    bound: float | None       # change that would have been told, in the measure's unit
    change: str


def _positive(value):
    return isinstance(value, (int, float)) and value > 0


def own_noise(logs):
    """Standard deviation of one nightly run's log value; None from fewer than 5 nightly runs.

    Median magnitude of the differences of successive nightly runs: steps and slow drift hardly change it.
    """
    if len(logs) < LEARNING:
        return None
    steps = [abs(b - a) for a, b in zip(logs, logs[1:])]
    return 1.4826 * statistics.median(steps) / math.sqrt(2)


def pooled_noise(series):
    """What a measure's noise is at least taken for, by pool: the median over its measures."""
    known = {}
    for one in series:
        noise = own_noise(one.logs()[-RECENT:]) if one.measure.kind in NOISY else None
        if noise is not None and _typical(one) >= MIN_SECONDS:
            known.setdefault(one.measure.pool, []).append(noise)
    return {pool: max(MIN_NOISE, statistics.median(found)) for pool, found in known.items()}


def _moderated(own, nightly_runs, pooled):
    """A measure's own noise, drawn to the others' as long as few nightly runs tell it (Smyth 2004)."""
    degrees = 0.4 * (nightly_runs - 1)  # what a median of magnitudes is worth against squares
    return math.sqrt((PRIOR * pooled**2 + degrees * own**2) / (PRIOR + degrees))


def _typical(one):
    values = [value for value in one.baseline() if _positive(value)]
    return statistics.median(values) if values else 0.0


def judge(series):
    """One Verdict for each of the nightly run's Series."""
    pooled = pooled_noise(series)
    count = max(1, sum(one.measure.kind in NOISY for one in series))
    factor = statistics.NormalDist().inv_cdf(1 - FALSE_ALARMS / count)
    return [_judge_noisy(one, pooled.get(one.measure.pool, MIN_NOISE), factor) if one.measure.kind in NOISY
            else _judge_exact(one) for one in series]


def _judge_noisy(one, pooled, factor):
    value, logs = one.measure.value, one.logs()
    baseline = [math.log(kept) for kept in one.baseline() if _positive(kept)]
    if not baseline and one.measure.value is not None:
        return Verdict("new", None, None, "")
    typical = math.exp(statistics.median(baseline[-RECENT:])) if baseline else None
    if value is None:
        return Verdict("worse", typical, None, "missing")
    change = math.log(max(value, 1e-12) / typical)
    words = f"{100 * math.expm1(change):+.1f} %"
    own = own_noise(logs[-RECENT:])
    if own is None:
        return Verdict("learning", typical, None, words)
    noise = max(pooled, _moderated(own, len(logs[-RECENT:]), pooled))
    bound = max(MIN_CHANGE, factor * noise * _spread_of_difference(len(baseline[-RECENT:])))
    limit = typical * math.exp(bound)
    if abs(value - typical) < MIN_SECONDS and one.measure.kind == "time":
        return Verdict("steady", typical, max(limit - typical, MIN_SECONDS), words)
    word = "slower" if change > bound else "faster" if change < -bound else "steady"
    if word == "steady":
        drift = _drift(one, factor * noise)
        if drift:
            return Verdict("slower", typical, limit - typical,
                           f"{100 * math.expm1(drift):+.1f} % by slow drift")
    if one.measure.kind == "memory":
        word = {"slower": "worse", "faster": "better"}.get(word, word)
    return Verdict(word, typical, limit - typical, words)


def _spread_of_difference(nightly_runs):
    """Standard deviation of (this run - median of so many nightly runs), where one nightly run's is 1."""
    variance_of_median = {1: 1.0, 2: 0.5}.get(nightly_runs, math.pi / 2 / nightly_runs)
    return math.sqrt(1 + variance_of_median)


def _drift(one, scaled_noise):
    """Logarithm by which the last nightly runs are above the first of the baseline; 0 within noise."""
    since = [math.log(value) for _, value, _ in one.past[one.start:] if _positive(value)]
    if len(since) < FIRST + LAST - 1:
        return 0.0
    last = since[-(LAST - 1):] + [math.log(one.measure.value)]
    rise = statistics.median(last) - statistics.median(since[:FIRST])
    spread = math.sqrt(math.pi / 2 * (1 / FIRST + 1 / LAST))
    return rise if rise > max(MIN_CHANGE, scaled_noise * spread) else 0.0


def _judge_exact(one):
    """Values that repeat: this run against the baseline's first nightly run."""
    measure, kept = one.measure, one.baseline()
    if not kept and measure.value is not None and measure.value != DIFFERS:
        return Verdict("new", None, None, "")
    typical = kept[0] if kept else None
    if measure.value is None:
        return Verdict("worse", typical, measure.tolerance, "missing")
    if measure.kind == "bits":
        return _judge_bits(one, kept[-1] if kept else None)
    if measure.kind == "pitch":
        typical = 0.0
    change = measure.value - typical
    words = f"{change:+.3g} {measure.unit}".rstrip()
    if abs(change) <= measure.tolerance or math.isclose(measure.value, typical, rel_tol=1e-9):
        return Verdict("steady", typical, measure.tolerance, words)
    bad = change < 0 if measure.kind == "score" else change > 0
    bad = bad or measure.kind in ("pitch", "number")
    return Verdict("worse" if bad else "better", typical, measure.tolerance, words)


def _judge_bits(one, typical):
    if one.measure.value == DIFFERS:
        return Verdict("worse", typical, None, DIFFERS)
    if one.measure.value == typical:
        return Verdict("steady", typical, None, "")
    return Verdict("steady" if one.note else "worse", typical, None,
                   one.note or "other bits from the same program")


def baseline_start(past, accepted):
    """Index of the first nightly run of a measure's baseline.

    past: (date, value, verdict); accepted: indices into past of the nightly runs after which somebody
    accepted the value. A change that was accepted begins where it was first told; so does an
    improvement that lasts.
    """
    start = 0
    for last in accepted:
        start = max(start, _first_of_run(past, last))
    good = ("faster", "better")
    if len(past) >= IMPROVED and all(row[2] in good for row in past[-IMPROVED:]):
        start = max(start, _first_of_run(past, len(past) - 1))
    else:
        start = max(start, _lasting(past, start))
    return start


def _first_of_run(past, last):
    first = last
    while first > 0 and past[last][2] in FLAGGED and past[first - 1][2] == past[last][2]:
        first -= 1
    return first


def _lasting(past, start):
    """Where the last run of so many improved nightly runs after `start` began; `start` if there is none."""
    run = 0
    for i in range(start, len(past)):
        run = run + 1 if past[i][2] in ("faster", "better") else 0
        if run == IMPROVED:
            start = i - IMPROVED + 1
    return start
