"""Strong isolated partials of a recording: peaks of a Fourier transform, frequencies and decay rates by regression
on the logarithm of a narrow band, and harminv. Nothing of the program is in it."""
import csv
import subprocess
import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.io import wavfile
from scipy.signal import fftconvolve, find_peaks
from scipy.signal.windows import blackman

STRONG = 20  # dB below the highest peak at most
ABOVE_FLOOR = 20  # dB above the median of the spectrum around, at least
RIVAL = 20  # dB: what is weaker than that beside a peak leaves it isolated
APART = 20  # Hz, and four bins: to the next rival, at least
WIDEST = 100  # Hz: distances above this make no filter shorter
MIN_FALL, MAX_FALL = 6, 30  # dB of the straight part, from 3 dB below the begin on
ABOVE_NOISE = 10  # dB: where it ends at last
STRAIGHT = 0.99  # of the variance of the logarithm of the envelope that a line explains, at least; what the
# phase varies by about a line is held to the same variance
HALVES = 0.15  # of the decay rate: by which its halves, and those of other channels, may differ from it


@dataclass
class Partial:
    """What is heard of one peak; `decay_rate` is None where `why` says so."""
    frequency: float  # Hz
    level: float  # dB below the highest peak
    decay_rate: float | None = None  # 1/s
    fall: float = 0  # dB of the straight part
    clear: float = 0  # Hz: that its band takes in
    why: str = ""
    harminv: tuple | None = None  # f [Hz], d [1/s]
    together: float | None = None  # 1/s, of all features about it


def read(path):
    """Sample rate and samples, channels as columns, full scale about 1."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # chunks that hold no samples
        rate, samples = wavfile.read(path)
    if samples.dtype == np.uint8:
        samples = samples.astype(float) - 128
    scale = {"uint8": 128, "int16": 2**15, "int32": 2**31}.get(samples.dtype.name, 1)
    return rate, samples.reshape(len(samples), -1) / scale


def spectrum_peaks(x, rate):
    """f [Hz] and level [dB] of the peaks, the floor under each [dB], and the width of a bin [Hz]."""
    n = len(x)
    rise = max(min(n // 20, round(0.005 * rate)), 1)
    window = np.cos(np.pi / 2 * (np.arange(n) + 0.5) / n)**2
    window[:rise] *= np.sin(np.pi / 2 * (np.arange(rise) + 0.5) / rise)**2
    padded = 8 * 2**int(np.ceil(np.log2(n)))
    power = 20 * np.log10(abs(np.fft.rfft((x - np.mean(x)) * window, padded)) + 1e-300)
    step = rate / padded
    # Medians of blocks of 1 kHz, wider than lines are, and straight lines between them.
    block = round(1000 / step)
    blocks = [np.median(power[k:k + block]) for k in range(0, len(power), block)]
    floor = np.interp(np.arange(len(power)), (np.arange(len(blocks)) + 0.5) * block, blocks)
    at = find_peaks(power)[0]
    at = at[(at > 20 / step) & (at < min(20e3, 0.475 * rate) / step)]
    left, middle, right = power[at - 1], power[at], power[at + 1]
    shift = 0.5 * (left - right) / (left - 2 * middle + right)
    return (at + shift) * step, middle - 0.25 * (left - right) * shift, floor[at], rate / n


def band(x, rate, frequency, length):
    """The band around a frequency, which becomes zero; every value is of samples of the recording alone, so
    that a damped sinusoid stays one."""
    taps = blackman(length)
    turned = x * np.exp(-2j * np.pi * frequency / rate * np.arange(len(x)))
    # A decay that ends in silence has no logarithm there.
    return fftconvolve(turned, taps / taps.sum(), mode="valid") + 1e-12


def straight_part(x, rate, frequency, clear):
    """Begin and values of the band from 3 dB below its begin on, while it is well above the noise."""
    length = min(round(3 / clear * rate), len(x) // 3) | 1
    values = band(x, rate, frequency, length)
    level = 20 * np.log10(abs(values))
    tail = max(len(level) // 10, 1)
    # What is left at the end, here or beside it: a slow one still rings.
    noise = min(20 * np.log10(np.median(abs(band(x, rate, frequency + beside, length)[-tail:])))
                for beside in (-1.5 * clear, 0, 1.5 * clear))
    top = np.max(level[:max(len(level) // 20, 1)])
    below = np.flatnonzero(level < top - 3)
    begin = below[0] if len(below) else len(level)
    low = np.flatnonzero(level[begin:] < max(noise + ABOVE_NOISE, top - 3 - MAX_FALL))
    return values[begin:begin + low[0] if len(low) else len(level)]


def decay(x, rate, partial):
    """Fills the decay rate of a partial and mends its frequency: the logarithm of a damped sinusoid is a straight line, its envelope's
    as its phase."""
    values = straight_part(x, rate, partial.frequency, partial.clear)
    partial.decay_rate, partial.why = None, "no 6 dB of decay above the noise"
    if len(values) < 20:
        return
    t = np.arange(len(values)) / rate
    logs = np.log(abs(values))
    lines = [np.polyfit(t, part, 1) for part in (logs, np.unwrap(np.angle(values)))]
    left = [part - np.polyval(line, t) for part, line in zip((logs, np.unwrap(np.angle(values))), lines)]
    slope = lines[0][0]
    partial.fall = -20 / np.log(10) * slope * t[-1]
    half = len(t) // 2
    halves = [np.polyfit(t[part], logs[part], 1)[0] for part in (slice(half), slice(half, None))]
    if partial.fall < MIN_FALL:
        return
    partial.why = "its decay is not straight"
    if np.var(left[0]) > (1 - STRAIGHT) * np.var(logs) or max(abs(s / slope - 1) for s in halves) > HALVES:
        return
    partial.why = "its phase is not straight"
    if np.var(left[1]) > (1 - STRAIGHT) * np.var(logs):
        return
    partial.decay_rate, partial.why = -slope, ""
    partial.frequency += lines[1][0] / (2 * np.pi)


def loud_part(x, rate):
    """Twice the time in which all but a thousandth of the energy has come, of 0.1 s at least: what comes
    after is noise for the most part."""
    energy = np.cumsum(x**2)
    end = np.searchsorted(energy, 0.999 * energy[-1])
    return x[:max(2 * end, round(0.1 * rate))]


def partials(channels, rate):
    """All strong peaks of the channel of most energy, the highest first, and the width of a bin [Hz]. A
    partial that its channels, as columns, do not agree on is not isolated."""
    loudest = (channels**2).sum(axis=0).argmax()
    x, others = channels[:, loudest], np.delete(channels, loudest, axis=1)
    f, level, floor, width = spectrum_peaks(loud_part(x, rate), rate)
    if len(f) == 0:
        return [], width
    highest = level.max()
    found = []
    for k in np.argsort(-level):
        if level[k] < highest - STRONG or level[k] < floor[k] + ABOVE_FLOOR:
            continue
        partial = Partial(float(f[k]), float(level[k] - highest))
        found.append(partial)
        rivals = np.abs(f[level > level[k] - RIVAL] - f[k])
        clear = min(rivals[rivals > 0], default=WIDEST)
        if clear < max(APART, 4 * width):
            partial.why = f"another {clear:.1f} Hz beside it"
            continue
        partial.clear = min(clear, WIDEST)
        decay(x, rate, partial)
        for other in others.T:
            again = replace(partial)
            decay(other, rate, again)
            if partial.decay_rate and (not again.decay_rate or
                                       abs(again.decay_rate / partial.decay_rate - 1) > HALVES):
                partial.decay_rate, partial.why = None, "its channels do not agree"
    return found, width


def harminv(x, rate, frequency):
    """f and d of the loudest at a frequency, in a band of 100 Hz, by filter diagonalisation; None if there is
    none."""
    part = x[:round(0.5 * rate)]
    text = "\n".join(f"{sample:.9g}" for sample in part / np.max(abs(part)))
    answer = subprocess.run(["harminv", "-t", repr(1 / rate), f"{frequency - 50:.3f}-{frequency + 50:.3f}"],
                            input=text, capture_output=True, text=True, timeout=600)
    rows = [(float(row["frequency"]), float(row["decay constant"]), float(row["amplitude"]))
            for row in csv.DictReader(answer.stdout.splitlines(), skipinitialspace=True)]
    near = [row for row in rows if abs(row[0] - frequency) < 5 and row[1] > 0]
    return max(near, key=lambda row: row[2]**2 / row[1])[:2] if near else None
