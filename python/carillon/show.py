"""How results show themselves: tables in notebooks, plots where there is matplotlib."""
from __future__ import annotations

import html
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

from carillon.errors import CarillonWarning


def warn(texts: Iterable[str]) -> None:
    for text in texts:
        warnings.warn(text, CarillonWarning, stacklevel=3)


def table(head: Sequence[str], rows: Sequence[Sequence[str]], caption: str, longest: int = 12) -> str:
    """HTML of a table; rows in the middle of a long one are left out."""
    def line(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"
    shown = [line(row, "td") for row in rows]
    if len(shown) > longest:
        left_out = f'<tr><td colspan="{len(head)}">{len(shown) - longest} more</td></tr>'
        shown[longest // 2:len(shown) - longest // 2] = [left_out]
    return f"<table><caption>{html.escape(caption)}</caption>{line(head, 'th')}{''.join(shown)}</table>"


def axes(axes: Any, **options: Any) -> Any:
    """Those that were given, or new ones."""
    if axes is not None:
        return axes
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("plots need matplotlib: python3-matplotlib, or pip install matplotlib") from error
    return pyplot.figure(layout="constrained").add_subplot(**options)
