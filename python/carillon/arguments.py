"""Arguments as people give them: quantities with units, arrays, samples."""
from __future__ import annotations

import contextlib
import json
import math
import operator
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy
import numpy.typing
from carillon import _carillon
from carillon.errors import InputError

FloatArray = numpy.typing.NDArray[numpy.float64]
Quantity = float | str  #: a number in SI units, or a text with its unit: "5 mm"

#: Full scale of whole numbers, as WAV files store them.
_FULL_SCALE = {"int16": 2.0**15, "int32": 2.0**31}


def quantity(value: Quantity, dimension: str, name: str) -> float:
    """A number in SI units. Raises InputError, which names the argument."""
    if isinstance(value, str):
        return _carillon.quantity(value, dimension, name)
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be a number or a text with its unit, not {value!r}") from None
    if not math.isfinite(number):
        raise InputError(f"{name} is {number}")
    return number


def whole(value: Any, name: str, low: int = 0, high: int = 2**63 - 1) -> int:
    """A whole number within bounds; the library knows narrower ones of its options.

    Raises InputError, which names the argument.
    """
    try:
        number = operator.index(value)
    except TypeError:
        raise InputError(f"{name} must be a whole number, not {value!r}") from None
    if not low <= number <= high:
        raise InputError(f"{name}: {number} lies outside {low} to {high}")
    return number


def word(value: Any, name: str) -> str:
    """A text. Raises InputError, which names the argument."""
    if not isinstance(value, str):
        raise InputError(f"{name} must be a text, not {value!r}")
    return value


def mapping(value: Any, name: str) -> Mapping[str, Any]:
    """Keys and values; None: none. Raises InputError, which names the argument."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InputError(f"{name} must be a mapping of keys, not {value!r}")
    return value


def point(value: Any, name: str) -> list[float]:
    """x, y, z [m]. Raises InputError, which names the argument."""
    entries = list(value) if numpy.ndim(value) == 1 or isinstance(value, (list, tuple)) else []
    if len(entries) != 3:
        raise InputError(f"{name} must be three numbers x, y, z [m], not {value!r}")
    return [quantity(entry, "length", name) for entry in entries]


def quantity_text(value: Quantity) -> str:
    """As the command line takes it."""
    return value if isinstance(value, str) else repr(float(value))


def rt60_text(rt60: Quantity | Sequence[Quantity] | None) -> str | None:
    """Reverberation times, one or by octave, as the command line takes them."""
    if rt60 is None:
        return None
    times = [rt60] if isinstance(rt60, str) or numpy.ndim(rt60) == 0 else rt60
    return ",".join(quantity_text(time) for time in times)  # type: ignore[union-attr,arg-type]


def numbers(values: numpy.typing.ArrayLike, name: str) -> FloatArray:
    """Real numbers as an array of float64. Raises InputError, which names the argument."""
    array = numpy.asarray(values)
    if array.dtype.kind not in "fiu":
        raise InputError(f"{name} must be an array of real numbers, not of {array.dtype}")
    return array.astype(numpy.float64)


def indices(values: numpy.typing.ArrayLike, name: str) -> numpy.typing.NDArray[numpy.int64]:
    """Whole numbers. Raises InputError, which names the argument."""
    array = numpy.asarray(values)
    if array.dtype.kind not in "fiu" or (array.dtype.kind == "f" and (array != numpy.rint(array)).any()):
        raise InputError(f"{name} must be whole numbers")
    return array.astype(numpy.int64)


def samples(values: numpy.typing.ArrayLike, name: str) -> FloatArray:
    """Sound as float64, full scale 1; 16 and 32 bits are taken for parts of full scale.

    Raises InputError, which names the argument.
    """
    array = numpy.asarray(values)
    if array.dtype.kind in "iu":
        if array.dtype.name not in _FULL_SCALE:
            raise InputError(f"{name}: full scale of {array.dtype} is not known", "give floats, full scale 1")
        return array / _FULL_SCALE[array.dtype.name]
    return numbers(array, name)


def plain(value: Any) -> Any:
    """For `json.dumps`: numbers and arrays of NumPy, and paths."""
    if isinstance(value, (numpy.ndarray, numpy.generic)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Sequence):
        return list(value)
    raise InputError(f"{value!r} cannot stand in a configuration")


def given(values: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments that were given."""
    return {key: value for key, value in values.items() if value is not None}


def settings(**values: Any) -> str:
    """JSON of the arguments that were given."""
    return json.dumps(given(values), default=plain)


def joined(values: Mapping[str, Any], keys: Any, place: str) -> dict[str, Any]:
    """Arguments that were given and keys of a scene. Raises InputError where both say the same."""
    known, keys = given(values), mapping(keys, place)
    for key in known.keys() & keys.keys():
        raise InputError(f"{key} is an argument and a key of {place}", "give it once")
    return {**keys, **known}


def in_words_of(call: str, text: str, names: Mapping[str, str] | None = None) -> str:
    """What is said of a configuration that stands for arguments: of those, without lines and columns."""
    text = re.sub(rf"{re.escape(call)}:\d+:\d+", call, text)
    text = re.sub(rf"^{re.escape(call)}: (?:modes|solver)\.", f"{call}: ", text)
    for key, argument in (names or {}).items():
        text = re.sub(rf"\b{re.escape(key)}\b", argument, text)
    return text


@contextlib.contextmanager
def arguments_of(call: str, names: Mapping[str, str] | None = None) -> Iterator[None]:
    """Errors of a configuration that stands for arguments speak of those; `names` of keys that are called otherwise."""
    try:
        yield
    except InputError as error:
        raise type(error)(in_words_of(call, error.message, names), in_words_of(call, error.hint, names)) from None
