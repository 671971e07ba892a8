"""How results show themselves: tables in notebooks, plots where there is matplotlib."""
from __future__ import annotations

import contextlib
import html
import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy
from carillon.errors import CarillonWarning, ConfigError


def plain(value: Any) -> Any:
    """For `json.dumps`: numbers and arrays of NumPy."""
    if isinstance(value, (numpy.ndarray, numpy.generic)):
        return value.tolist()
    if isinstance(value, Sequence):
        return list(value)
    raise TypeError(f"{value!r} cannot stand in a configuration")


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


def warn(texts: Iterable[str]) -> None:
    for text in texts:
        warnings.warn(text, CarillonWarning, stacklevel=4)


def table(head: Sequence[str], rows: Sequence[Sequence[str]], caption: str, longest: int = 12) -> str:
    """HTML of a table; rows in the middle of a long one are left out."""
    def line(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"
    shown = [line(row, "td") for row in rows]
    if len(shown) > longest:
        left_out = f'<tr><td colspan="{len(head)}">{len(shown) - longest} more</td></tr>'
        shown[longest // 2:len(shown) - longest // 2] = [left_out]
    return f"<table><caption>{html.escape(caption)}</caption>{line(head, 'th')}{''.join(shown)}</table>"


def axes(given: Any, **how: Any) -> Any:
    """Those that were given, or new ones."""
    if given is not None:
        return given
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("plots need matplotlib: python3-matplotlib, or pip install matplotlib") from error
    return pyplot.figure(layout="constrained").add_subplot(**how)
