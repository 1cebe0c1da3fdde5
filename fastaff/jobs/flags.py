"""Values of flags as they are written: ranges LOW:HIGH, axes LOW:HIGH:N, grids N1xN2."""

from __future__ import annotations

import re

import numpy as np

from ..core.numbers import shown
from ..systems.formulas.number import number
from .wording import OptionError, option


def flags_of_axes(found: re.Match[str]) -> str:
    """Return the flags for ranges of rows that a sentence names as a dict."""
    return " ".join(f"{option('axes')} {name}=LOW:HIGH" for name in re.findall(r'"(\w+)":', found[1]) or ["NAME"])


def range_of(option: str, text: str | None) -> tuple[float, float] | None:
    """Return the ends of a range LOW:HIGH."""
    if text is None:
        return None
    low, colon, high = text.partition(":")
    try:
        ends = number("LOW", low), number("HIGH", high)
        if not (colon and ends[0] < ends[1]):
            raise ValueError
    except ValueError:
        raise OptionError(
            f"{option} must be LOW:HIGH with LOW < HIGH, for example 0.1:1.2, got {shown(text)}"
        ) from None
    return ends


def axis_of(name: str, text: str) -> np.ndarray:
    """Return the centres of the cells of an axis LOW:HIGH:N; a number alone is one cell."""
    ends, colon, count = text.rpartition(":")
    try:
        cells = int(count) if colon else 0
        low, high = range_of(f"{option('axes')} {name}", ends) or (0.0, 0.0)
        if cells < 1:
            raise ValueError
    except ValueError:
        raise OptionError(
            f"{option('axes')} {name} must be LOW:HIGH:N with LOW < HIGH and N at least 1, such as {name}=-1:1:40, "
            f"got {shown(text)}"
        ) from None
    return low + (high - low) * (np.arange(cells) + 0.5) / cells


def cells_of(text: str) -> tuple[int, int]:
    """Return the numbers of cells of a grid N1xN2."""
    first, cross, second = text.lower().partition("x")
    try:
        n1 = int(first)
        n2 = int(second if cross else first)
        if n1 < 1 or n2 < 1:
            raise ValueError
    except ValueError:
        raise OptionError.of(
            "{grid} must be N1xN2, whole numbers of at least 1 such as 40x40, got {text!r}", text=text
        ) from None
    return n1, n2
