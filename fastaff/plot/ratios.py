"""Frequencies of a map by name, and the resonances among their ratios."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.numbers import text
from ..schemes.catalogue import ITERATION


def by_leading_lines(frequency_map: Any) -> bool:
    """Tell whether figures are of leading lines: of flows of three coordinates or more, but for a body's planes."""
    flow = hasattr(frequency_map, "leading") and frequency_map.scheme is not ITERATION
    return flow and frequency_map.nu_eta is None and len(frequency_map.names) > 2


def frequency(frequency_map: Any, name: str) -> np.ndarray:
    """Return one frequency (orbits,) of a map by name: a row of .names, `eta` or `gamma`; or a ratio of two:
    "beta/alpha"; NaN of orbits that have none. Of flows of three coordinates or more it is the leading line of that
    coordinate: the order of independent frequencies changes from orbit to orbit.
    """
    numerator, slash, denominator = text("frequency", name).partition("/")
    if slash:
        with np.errstate(all="ignore"):
            return frequency(frequency_map, numerator) / frequency(frequency_map, denominator)
    if name in frequency_map.names:
        row = frequency_map.names.index(name)
        nu, error = frequency_map.nu[row], frequency_map.error[row]
        if by_leading_lines(frequency_map):
            nu, error = frequency_map.leading[row], frequency_map.leading_error[row]
        return np.where(np.isfinite(error), nu, np.nan)
    if name in ("eta", "gamma") and frequency_map.nu_eta is not None:
        return frequency_map.nu_eta if name == "eta" else frequency_map.nu_gamma
    extra = ", eta, gamma" if frequency_map.nu_eta is not None else ""
    raise ValueError(f"frequency must be one of {', '.join(frequency_map.names)}{extra}, or a ratio a/b, got {name!r}")


def resonances_between(low: float, high: float, max_order: int) -> list[tuple[int, int, int]]:
    """Return the resonances m : n with low < m/n < high as lines (n, 0, -m) of a frequency map, of order m + n at
    most.
    """
    found = [
        (n, 0, -m)
        for n in range(1, max_order)
        for m in range(1, max_order - n + 1)
        if math.gcd(m, n) == 1 and low < m / n < high
    ]
    return sorted(found, key=lambda k: k[0] - k[2])


def on_line(frequency_map: Any, line: Sequence[int], *, x: str, y: str, tolerance: float, shown: Any = True) -> int:
    """Count the orbits, of those shown, with ``|k1 X + k2 Y + k0|`` < tolerance for the line (k1, k2, k0) of a map's
    plane.
    """
    X, Y = frequency(frequency_map, x), frequency(frequency_map, y)
    with np.errstate(all="ignore"):
        return int(np.count_nonzero((np.abs(line[0] * X + line[1] * Y + line[2]) < tolerance) & shown))
