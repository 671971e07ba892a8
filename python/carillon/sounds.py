"""Sounds, their features, and what is found from them."""
from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy
import numpy.typing
from carillon import _carillon, arguments, show
from carillon.arguments import FloatArray, Quantity
from carillon.errors import InputError

if TYPE_CHECKING:
    from carillon.materials import Material
    from carillon.objects import Object


class Sound(numpy.ndarray[Any, numpy.dtype[numpy.float32]]):
    """Samples [samples] or [listeners, samples], float32, with their rate and how they came about.

    Parts of it keep the rate; one that leaves samples out has none (NaN).
    """

    rate: float  #: [Hz]
    document: dict[str, Any]  #: all that `carillon strike --json` prints: effects that ran, what was drawn

    def __new__(cls, samples: numpy.typing.ArrayLike, rate: float, document: Mapping[str, Any] | None = None) -> Sound:
        values = numpy.asarray(samples)
        if values.dtype != numpy.float32:
            values = arguments.samples(values, "samples")
        made = values.astype(numpy.float32, copy=False).view(cls)
        made.rate, made.document = rate, dict(document or {})
        return made

    def __array_finalize__(self, made_from: Any) -> None:
        self.rate = getattr(made_from, "rate", numpy.nan)
        self.document = getattr(made_from, "document", {})

    def __getitem__(self, key: Any) -> Any:
        part = super().__getitem__(key)
        if isinstance(part, Sound):
            keys = key if isinstance(key, tuple) else (key,)
            reaches_time = len(keys) == self.ndim or any(k is Ellipsis for k in keys) or numpy.ndim(keys[0]) > 1
            over_time = keys[-1] if keys and reaches_time else Ellipsis
            if over_time is not Ellipsis and not (isinstance(over_time, slice) and over_time.step in (None, 1)):
                part.rate = numpy.nan
        return part

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return array[()] if array.ndim == 0 else super().__array_wrap__(array, context)

    def __reduce__(self) -> Any:
        return Sound, (numpy.asarray(self), self.rate, self.document)

    @property
    def unit(self) -> str:
        """Of the values, before `gain`: m/s at the point that was struck, Pa at listeners."""
        return str(self.document.get("unit", ""))

    def save(self, path: str | os.PathLike[str]) -> None:
        """A WAV file of 32-bit floats, a channel for each listener."""
        if self.ndim not in (1, 2) or not self.rate > 0:
            raise InputError(f"{list(self.shape)} at {self.rate} Hz is no sound",
                             "a sound is [samples] or [listeners, samples]: Sound(samples, rate)")
        channels = numpy.ascontiguousarray(numpy.atleast_2d(numpy.asarray(self, numpy.float32)).T)
        _carillon.write_wav(os.fspath(path), channels, round(self.rate))

    def plot(self, axes: Any = None) -> Any:
        """The spectrogram of the first channel in dB, with matplotlib; returns the axes."""
        axes = show.axes(axes)
        first = numpy.atleast_2d(numpy.asarray(self))[0].astype(float)
        loudest = numpy.abs(first).max() or 1
        axes.specgram(first / loudest, NFFT=1024, noverlap=768, Fs=self.rate, vmin=-160, vmax=-40)
        axes.set(xlabel="time [s]", ylabel="frequency [Hz]")
        return axes

    def _repr_html_(self) -> str:
        """A player in a notebook."""
        try:
            from IPython.display import Audio
        except ImportError:
            return f"<pre>{self!r}</pre>"
        return str(Audio(numpy.asarray(self), rate=round(self.rate))._repr_html_())


def rate_of(sound: Any, rate: Quantity | None, name: str = "rate") -> float:
    """The rate that is given, or a Sound's own [Hz]."""
    known = rate if rate is not None else getattr(sound, "rate", None)
    if known is None:
        raise TypeError("the sample rate is missing: give it after the samples")
    return arguments.quantity(known, "frequency", name)


def _floats(entries: Iterable[Mapping[str, Any]], name: str) -> FloatArray:
    return numpy.array([numpy.nan if entry[name] is None else entry[name] for entry in entries], float)


@dataclasses.dataclass(frozen=True, repr=False, eq=False)
class Features:
    """Decaying tones of a sound, by frequency: a exp(-d t) cos(2 pi f t + phase), t from the onset.

    Errors are one standard deviation; NaN where a method gives none.
    """

    frequencies: FloatArray  #: [n] Hz, damped
    decay_rates: FloatArray  #: [n] 1/s
    amplitudes: FloatArray  #: [n] at the onset, full scale 1
    frequency_errors: FloatArray  #: [n] Hz
    decay_rate_errors: FloatArray  #: [n] 1/s
    amplitude_errors: FloatArray  #: [n]
    snrs: FloatArray  #: [n] dB
    reverberant: numpy.typing.NDArray[numpy.bool_]  #: [n] may be the room's: not to be relied on
    onset: float  #: s
    explained: float  #: fraction of the energy that the features make up
    remarks: list[str]  #: what was left out and why
    nothing: str  #: why there are no features; "" where there are
    document: dict[str, Any]  #: all that `carillon features --json` prints

    @classmethod
    def _from_json(cls, document: dict[str, Any]) -> Features:
        rows = document["features"]
        def column(name: str) -> FloatArray:
            return _floats(rows, name)
        return cls(frequencies=column("frequency_hz"), decay_rates=column("decay_rate_per_s"),
                   amplitudes=column("amplitude"), frequency_errors=column("frequency_error_hz"),
                   decay_rate_errors=column("decay_rate_error_per_s"), amplitude_errors=column("amplitude_error"),
                   snrs=column("snr_db"), reverberant=numpy.array([row["reverberant"] for row in rows], bool),
                   onset=document["onset_s"], explained=document["energy_explained"], remarks=document["remarks"],
                   nothing=document["nothing"], document=document)

    def __len__(self) -> int:
        return len(self.frequencies)

    def __repr__(self) -> str:
        if self.nothing:
            return f"<no features: {self.nothing}>"
        return (f"<{len(self)} features, {self.frequencies[0]:.1f} to {self.frequencies[-1]:.1f} Hz, "
                f"{100 * self.explained:.3g} % of the energy>")

    def plot(self, axes: Any = None) -> Any:
        """Decay rates over frequencies with their errors, with matplotlib; returns the axes."""
        axes = show.axes(axes)
        axes.errorbar(self.frequencies, self.decay_rates, self.decay_rate_errors, fmt="o", ms=4)
        axes.set(xlabel="frequency [Hz]", ylabel="decay rate [1/s]", xscale="log", yscale="log")
        return axes

    def _repr_html_(self) -> str:
        rows = [[f"{f:.2f}", f"{fe:.2g}", f"{d:.4g}", f"{de:.2g}", f"{a:.3g}", f"{snr:.1f}"] for f, fe, d, de, a, snr in
                zip(self.frequencies, self.frequency_errors, self.decay_rates, self.decay_rate_errors,
                    self.amplitudes, self.snrs)]
        caption = self.nothing or f"{len(self)} features, {100 * self.explained:.3g} % of the energy"
        return show.table(["f [Hz]", "+-", "d [1/s]", "+-", "amplitude", "SNR [dB]"], rows, caption)


def features(samples: numpy.typing.ArrayLike, rate: Quantity | None = None, *, method: str = "esprit",
             onset: Quantity | None = None, contact_time: Quantity | None = None,
             min_frequency: Quantity | None = None, max_frequency: Quantity | None = None,
             min_decay_rate: Quantity | None = None, rt60: Quantity | Sequence[Quantity] | None = None,
             min_level: Quantity | None = None, max_features: int | None = None,
             explained: Quantity | None = None) -> Features:
    """Modal features of a struck object's sound.

    samples: [samples] or [channels, samples], full scale 1; rate: [Hz], of a Sound its own.
    The options are those of `carillon features`; rt60: reverberation time of the room [s], one or by octave from
    125 Hz on.
    Raises InputError: a sample that is not finite, options out of range.
    """
    quantities = {"onset": onset, "contact_time": contact_time, "min_frequency": min_frequency,
                  "max_frequency": max_frequency, "min_decay_rate": min_decay_rate,
                  "explained": explained}
    texts = {name: arguments.quantity_text(value) for name, value in quantities.items() if value is not None}
    options = arguments.settings(
        method=arguments.word(method, "method"), rt60=arguments.rt60_text(rt60),
        max_features=None if max_features is None else arguments.whole(max_features, "max_features"),
        min_level=None if min_level is None else arguments.quantity(min_level, "level", "min_level"), **texts)
    found = _carillon.features(arguments.samples(samples, "samples"), rate_of(samples, rate), options)
    return Features._from_json(json.loads(found))


@dataclasses.dataclass(frozen=True, repr=False, eq=False)
class Fit:
    """A damping model fitted to features: c = 2 d as a function of lambda = omega^2."""

    model: str
    estimator: str
    formula: str  #: with its numbers
    parameters: dict[str, float]  #: alpha1, alpha2, ...
    confidence95: dict[str, tuple[float, float]]  #: of each, by profile likelihood; infinite where unbounded
    units: dict[str, str]
    sigma: float  #: of the Gaussian error of c [1/s]; of mixture and emg_relative as a fraction of the law's c
    eta: float  #: rate of the exponential excess of c [s]; infinite where there is none
    log_likelihood: float
    converged: bool
    remarks: list[str]
    document: dict[str, Any]  #: all that `carillon fit --json` prints

    @classmethod
    def _from_json(cls, document: dict[str, Any]) -> Fit:
        infinite = float("inf")
        parameters = dict(document["parameters"])
        intervals = {name: (-infinite if low is None else low, infinite if high is None else high)
                     for name, (low, high) in parameters.pop("confidence95", {}).items()}
        alphas = {name: value for name, value in parameters.items() if isinstance(value, (int, float))}
        return cls(document["model"], document["estimator"], document["formula"], alphas, intervals,
                   document["units"], document.get("sigma_per_s", document.get("sigma_of_c")),
                   infinite if document["eta_s"] is None else document["eta_s"], document["log_likelihood"],
                   document["converged"], document["remarks"], document)

    def __repr__(self) -> str:
        numbers = ", ".join(f"{name} = {value:.5g}" for name, value in self.parameters.items())
        return f"<{self.model} by {self.estimator}: {numbers}{'' if self.converged else ', not converged'}>"

    @property
    def curve(self) -> tuple[FloatArray, FloatArray]:
        """Frequencies [Hz] and the law's decay rates [1/s] there."""
        curve = self.document["fits"][self.estimator]["curve"]
        return (numpy.array(curve["frequency_hz"], float), numpy.array(curve["decay_rate_per_s"], float))

    def plot(self, axes: Any = None) -> Any:
        """The features and the law, with matplotlib; returns the axes."""
        axes = show.axes(axes)
        rows = self.document["features"]
        axes.plot(_floats(rows, "frequency_hz"), _floats(rows, "decay_rate_per_s"), "o", ms=4, label="features")
        numbers = ", ".join(f"{name} = {value:.4g}" for name, value in self.parameters.items())
        axes.plot(*self.curve, label=f"{self.model}, {self.estimator}: {numbers}")
        axes.set(xlabel="frequency [Hz]", ylabel="decay rate [1/s]", xscale="log", yscale="log")
        axes.legend()
        return axes

    def _repr_html_(self) -> str:
        rows = [[name, f"{value:.5g}", self.units.get(name, ""), "{:.4g} to {:.4g}".format(*self.confidence95[name])
                 if name in self.confidence95 else ""] for name, value in self.parameters.items()]
        return show.table(["", "value", "unit", "95 %"], rows, f"{self.estimator}: {self.formula}")


def fit(*features: Features | tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike], model: str = "rayleigh",
        estimator: str = "mixture") -> Fit:
    """A material's damping from features of its sounds, whatever held the object.

    features: as features() gives them, or pairs (frequencies [n] Hz, decay rates [n] 1/s); several are joined.
    model: rayleigh, caughey, caughey:N, power, hybrid, or a formula of lambda, omega, f and alpha1, alpha2, ...;
    several with commas between them, or all: the one of the lowest AIC is chosen (document["models"]).
    estimator: mixture (excess of two kinds, errors, outliers), emg, emg_relative, least_squares or lower_bound.
    Raises InputError: fewer features than can be fitted, an unknown model.
    """
    sources = [{"name": f"sound {i + 1}", "features": _rows_of(source, i)} for i, source in enumerate(features)]
    return Fit._from_json(json.loads(_carillon.fit(json.dumps(sources), arguments.word(model, "model"),
                                                   arguments.word(estimator, "estimator"))))


def _rows_of(source: Any, number: int) -> list[dict[str, Any]]:
    """Features of one sound as the library reads them."""
    if isinstance(source, Features):
        return list(source.document["features"])
    columns = [arguments.numbers(values, f"features {number + 1}") for values in source] if len(source) == 2 else []
    if len(columns) != 2 or any(column.ndim != 1 for column in columns) or len(columns[0]) != len(columns[1]):
        raise InputError(f"features {number + 1} are no pair (frequencies [n], decay rates [n])",
                         "fit((frequencies, decay_rates)), or fit(features(sound))")
    if not all(numpy.isfinite(column).all() for column in columns):
        raise InputError(f"features {number + 1}: a frequency or a decay rate is not finite", "leave it out")
    return [{"frequency_hz": f, "decay_rate_per_s": d} for f, d in zip(*(column.tolist() for column in columns))]


@dataclasses.dataclass(frozen=True, repr=False)
class Comparison:
    """Two sounds of one object: errors of modes, loudness and spectra."""

    level: float  #: energy of the other's over the reference's [dB]
    matched: list[dict[str, float]]  #: pairs of modes: cents, ratios, just-noticeable differences
    reference_only: list[dict[str, float]]
    other_only: list[dict[str, float]]
    jnd: dict[str, dict[str, float | None]]  #: of pitch, decay and level: `mean` and `worst`, weighted
    loudness_fraction: float  #: rms of the difference of specific loudness over the sounds' own
    spectral_distance: float
    document: dict[str, Any]  #: all that `carillon compare --json` prints

    def __repr__(self) -> str:
        pitch = self.jnd["pitch"]["worst"]
        worst = "" if pitch is None else f", pitch {pitch:.2g} just-noticeable differences at worst"
        return (f"<{len(self.matched)} modes matched, {len(self.reference_only)} and {len(self.other_only)} not"
                f"{worst}, loudness {100 * self.loudness_fraction:.2g} % apart>")

    def _repr_html_(self) -> str:
        def number(value: float | None) -> str:
            return "-" if value is None else f"{value:.2f}"
        rows = [[name, number(entry["mean"]), number(entry["worst"])] for name, entry in self.jnd.items()]
        caption = (f"{len(self.matched)} modes matched, {len(self.reference_only)} and {len(self.other_only)} not; "
                   f"just-noticeable differences")
        return show.table(["", "mean", "worst"], rows, caption)


def compare(reference: numpy.typing.ArrayLike, other: numpy.typing.ArrayLike, rate: Quantity | None = None,
            other_rate: Quantity | None = None, *, loudest_level: Quantity = 80, widest: float = 100,
            rt60: Quantity | Sequence[Quantity] | None = None) -> Comparison:
    """How different two sounds of one object are to a listener; docs/comparison.md says what the numbers mean.

    reference, other: [samples], full scale 1; rates [Hz], of Sounds their own.
    loudest_level: that the louder one's loudest moment is heard at [dB re 20 uPa]; widest: modes further apart
    than this are not the same [cents].
    """
    first = rate_of(reference, rate)
    second = rate_of(other, other_rate if other_rate is not None else getattr(other, "rate", first), "other_rate")
    document = json.loads(_carillon.compare(
        arguments.samples(reference, "the reference"), first, arguments.samples(other, "the other sound"), second,
        arguments.quantity(loudest_level, "level", "loudest_level"), float(widest),
        arguments.settings(rt60=arguments.rt60_text(rt60))))
    nan = float("nan")
    return Comparison(nan if document["level_db"] is None else document["level_db"], document["matched"],
                      document["reference_only"], document["other_only"], document["jnd"],
                      nan if document["loudness"]["fraction"] is None else document["loudness"]["fraction"],
                      document["spectra"]["total"], document)


@dataclasses.dataclass(frozen=True, repr=False, eq=False)
class Estimate:
    """What a struck object is made of, by recordings of it. What is not determined is None."""

    specific_modulus: float | None  #: E / density [m^2/s^2]
    specific_modulus_error: float  #: one standard error of its logarithm; infinite where it is not determined
    youngs_modulus: float | None  #: [Pa], where the density was given
    poisson_ratio: float | None  #: where all were tried
    model: str  #: the damping with its numbers
    parameters: dict[str, float]  #: of the damping; empty where it is not determined
    confidence95: dict[str, tuple[float, float]]  #: of what the metric of pitches determined, by name
    undetermined: str  #: why there is no specific modulus; "" where there is one
    remarks: list[str]  #: how well it is determined
    resynthesis: Sound | None  #: the recording made again from the estimate; of the hybrid metric alone
    document: dict[str, Any]  #: all that `carillon estimate --json` prints

    def __repr__(self) -> str:
        if self.specific_modulus is None:
            return f"<not determined: {self.undetermined}>"
        return (f"<E / density {self.specific_modulus:.5g} m^2/s^2 +- {100 * self.specific_modulus_error:.2g} %, "
                f"damping {self.model or 'not determined'}>")

    def _repr_html_(self) -> str:
        if self.specific_modulus is None:
            return show.table(["", ""], [["not determined", self.undetermined]], "")
        rows = [["E / density", f"{self.specific_modulus:.4g} m^2/s^2"]]
        if self.youngs_modulus is not None:
            rows.append(["E", f"{self.youngs_modulus:.4g} Pa"])
        rows += [[name, f"{value:.4g}"] for name, value in self.parameters.items()]
        return show.table(["", ""], rows, self.model)


def _interval(ends: Sequence[float | None]) -> tuple[float, float]:
    """Of JSON, where an end that nothing bounds is null."""
    low, high = ends
    return (-math.inf if low is None else low, math.inf if high is None else high)


def _estimate_of(document: dict[str, Any], resynthesis: Sound | None) -> Estimate:
    given = document["parameters"] or {}
    parameters = {name: value for name, value in given.items() if isinstance(value, (int, float))}
    intervals = {**document.get("confidence95", {}), **given.get("confidence95", {})}
    confidence95 = {name: _interval(ends) for name, ends in intervals.items()}
    error = document.get("specific_modulus_error")
    if "specific_modulus_m2_per_s2" in confidence95:
        low, high = confidence95["specific_modulus_m2_per_s2"]
        error = math.log(high / low) / (2 * 1.96)
    return Estimate(document["specific_modulus_m2_per_s2"], math.inf if error is None else error,
                    document.get("youngs_modulus_pa"), document.get("poisson_ratio"), document.get("model", ""),
                    parameters, confidence95, document.get("undetermined", ""), document["remarks"], resynthesis,
                    document)


def estimate(samples: numpy.typing.ArrayLike | Sequence[numpy.typing.ArrayLike], object: Object,
             at: Sequence[float] | FloatArray | None = None, rate: Quantity | None = None, *,
             metric: str = "pitches", material: str | Material = "", poisson_ratio: float | None = None,
             density: Quantity | None = None, direction: Sequence[float] | FloatArray | None = None,
             model: str = "rayleigh", heard: str = "velocity", contact_time: Quantity | None = None,
             onset: Quantity | None = None, rt60: Quantity | Sequence[Quantity] | None = None, starts: int = 8,
             seed: int = 1, **modes: Any) -> Estimate:
    """The material of a struck object from recordings of it and its shape.

    samples: [samples], or a list of several recordings of the object; at: point struck [m], None: unknown.
    metric: "pitches", of the frequencies alone, with intervals; "hybrid", the papers', of one recording, which needs
    `at` and a Poisson's ratio; contact_time, heard, starts and seed are its.
    poisson_ratio: of the object; None: the material's or, without one, all are tried; density: [kg/m^3], with which
    Young's modulus follows; heard: velocity, acceleration (microphones) or displacement;
    contact_time, onset: [s], None: sought.
    material: an assumed one whose modes are solved and rescaled; further arguments are those of Object.modes.
    Raises InputError: no modes can be heard, no Poisson's ratio.
    """
    from carillon.materials import material_text, stored_materials
    from carillon.objects import Object as AnyObject
    if not isinstance(object, AnyObject):
        raise InputError(f"object must be a carillon.Object, not {object!r}", "carillon.Object.load(path), or shape()")
    quantities = {"contact_time": contact_time, "onset": onset, "density": density, "poisson_ratio": poisson_ratio}
    texts = {name: arguments.quantity_text(value) for name, value in quantities.items() if value is not None}
    options = arguments.settings(
        metric=arguments.word(metric, "metric"), model=arguments.word(model, "model"),
        heard=arguments.word(heard, "heard"), rt60=arguments.rt60_text(rt60),
        starts=arguments.whole(starts, "starts"), seed=arguments.whole(seed, "seed", 0, 2**64 - 1), **texts)
    several = isinstance(samples, (list, tuple)) and len(samples) > 0 and numpy.ndim(samples[0]) > 0
    recordings: list[Any] = list(samples) if several else [samples]  # type: ignore[arg-type]
    rates = [rate_of(recording, rate) for recording in recordings]
    clips = [arguments.samples(recording, "the recording") for recording in recordings]
    point = None if at is None else arguments.numbers(at, "at")
    force = None if direction is None else arguments.numbers(direction, "direction")
    assumed = stored_materials(_carillon.assumed_materials(material_text(material), options))

    def solver(one: Material) -> Callable[[], Any]:
        return lambda: object.modes(one, **modes)._solved

    if metric == "hybrid" and len(clips) == 1:
        text, again = _carillon.estimate(solver(assumed[0]), clips[0], rates[0], point, force, options)
        return _estimate_of(json.loads(text), Sound(again, rates[0]))
    return _estimate_of(json.loads(_carillon.estimate_pitches([solver(one) for one in assumed], clips, rates, point,
                                                              force, options)), None)


def mel(samples: numpy.typing.ArrayLike, rate: Quantity | None = None, *, bands: int = 64, fft_size: int = 2048,
        hop: int = 1837, min_frequency: Quantity = 0, max_frequency: Quantity = 0,
        computed_bands: int | None = None,
        frames: int | None = None) -> numpy.typing.NDArray[numpy.float32]:
    """The mel power spectrogram that a dataset's `mel` holds (librosa's definition: Slaney scale and area norm).

    samples: [samples] or [n, samples]; max_frequency 0: half the rate. computed_bands are made smaller to `bands`,
    and the frames that the hop gives to `frames`, each the mean of what it covers.
    Returns [bands, frames] or [n, bands, frames], power, not normalised. Raises InputError.
    """
    clips = arguments.samples(samples, "samples")
    low, high = (arguments.quantity(value, "frequency", name) for name, value in
                 (("min_frequency", min_frequency), ("max_frequency", max_frequency)))
    bands, fft_size, hop = (arguments.whole(value, name, 1, 2**31 - 1) for name, value in
                            (("bands", bands), ("fft_size", fft_size), ("hop", hop)))
    computed = bands if computed_bands is None else arguments.whole(computed_bands, "computed_bands", bands, 2**31 - 1)
    kept = 0 if frames is None else arguments.whole(frames, "frames", 1, 2**31 - 1)
    made = _carillon.mel(clips, rate_of(samples, rate), computed, fft_size, hop, low, high, bands, kept)
    return made.squeeze(0) if clips.ndim == 1 else made
