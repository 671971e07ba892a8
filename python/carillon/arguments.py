"""Arguments as people give them: quantities with units, arrays, samples."""
from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy
import numpy.typing
from carillon import _carillon
from carillon.errors import ConfigError, InputError

FloatArray = numpy.typing.NDArray[numpy.float64]
Quantity = float | str  #: a number in SI units, or a text with its unit: "5 mm"

#: Full scale of whole numbers, as WAV files store them.
_FULL_SCALE = {"int16": 2.0**15, "int32": 2.0**31}


def quantity(value: Quantity, dimension: str, name: str) -> float:
    """A number in SI units. Raises InputError, which names the argument."""
    if isinstance(value, str):
        return _carillon.quantity(value, dimension, name)
    return float(value)


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
        raise InputError(f"{name} must be whole numbers, not of {array.dtype}")
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
    """For `json.dumps`: numbers and arrays of NumPy."""
    if isinstance(value, (numpy.ndarray, numpy.generic)):
        return value.tolist()
    if isinstance(value, Sequence):
        return list(value)
    raise TypeError(f"{value!r} cannot stand in a configuration")


def given(values: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments that were given."""
    return {key: value for key, value in values.items() if value is not None}


def settings(**values: Any) -> str:
    """JSON of the arguments that were given."""
    return json.dumps(given(values), default=plain)


def joined(values: Mapping[str, Any], keys: Mapping[str, Any], place: str) -> dict[str, Any]:
    """Arguments that were given and keys of a scene. Raises InputError where both say the same."""
    known = given(values)
    for key in known.keys() & keys.keys():
        raise InputError(f"{key} is an argument and a key of {place}", "give it once")
    return {**keys, **known}


@contextlib.contextmanager
def arguments_of(call: str) -> Iterator[None]:
    """Errors of a configuration that stands for arguments speak of those: without lines and columns."""
    try:
        yield
    except ConfigError as error:
        def plain_words(text: str) -> str:
            text = re.sub(rf"{re.escape(call)}:\d+:\d+", call, text)
            return re.sub(rf"^{re.escape(call)}: (?:modes|solver)\.", f"{call}: ", text)
        raise ConfigError(plain_words(error.message), plain_words(error.hint)) from None
