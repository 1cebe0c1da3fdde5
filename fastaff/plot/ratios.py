"""Frequencies of a map by name, and the resonances among their ratios."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core.numbers import an_array, listed, shown, text, whole
from ..frequencies.own_lines import in_time, own_lines


def frequencies_of(found: Any, chosen: Any = None) -> np.ndarray:
    """Return the frequencies (n, orbits) that figures draw, NaN where there are none: those chosen, or the dominant
    line of each coordinate, `dominant`, but `nu` where that is a harmonic; for maps, tunes and bodies `nu`.
    """
    if chosen is not None:
        values = an_array("frequencies", chosen)
        if values.shape != found.nu.shape or values.dtype.kind not in "iuf":
            example = "found.nu or found.dominant" if in_time(found) else "found.nu"
            raise ValueError(f"frequencies must be an array {found.nu.shape}, such as {example}, got {shown(chosen)}")
        return np.where(np.isfinite(found.error), values, np.nan)
    return own_lines(found)[0]


def frequency(frequency_map: Any, name: str, frequencies: Any = None) -> np.ndarray:
    """Return one frequency of the orbits of a map, or a ratio of two.

    Parameters
    ----------
    frequency_map : FrequencyMap or Tunes
        Frequencies of orbits.
    name : str
        Name of a row, ``"eta"`` or ``"gamma"``, or a ratio such as ``"beta/alpha"``.
    frequencies : array_like, shape (n, orbits), optional
        Frequencies of the coordinates, for example ``freq.nu`` or ``freq.dominant``. Default: the dominant line of each
        coordinate, because the order of independent frequencies changes from orbit to orbit. ``nu`` is used for maps
        and bodies. It is also used if the dominant line is a harmonic farther than a quarter from ``nu``. An example is
        the line 2 nu_z of a star's R.

    Returns
    -------
    ndarray, shape (orbits,)
        Values, NaN for orbits without one.

    Examples
    --------
    >>> freq = fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0)
    >>> fa.plot.frequency(freq, "y/x").round(6), fa.plot.frequency(freq, "y/x", freq.nu).round(6)
    (array([1.]), array([1.02611]))
    """
    numerator, slash, denominator = text("frequency", name).partition("/")
    if slash:
        with np.errstate(all="ignore"):
            return frequency(frequency_map, numerator, frequencies) / frequency(frequency_map, denominator, frequencies)
    if name in frequency_map.names:
        return frequencies_of(frequency_map, frequencies)[frequency_map.names.index(name)]
    if name in ("eta", "gamma") and frequency_map.nu_eta is not None:
        return frequency_map.nu_eta if name == "eta" else frequency_map.nu_gamma
    extra = ", eta, gamma" if frequency_map.nu_eta is not None else ""
    raise ValueError(
        f"frequency must be one of {listed(frequency_map.names)}{extra}, or a ratio a/b, got {shown(name)}. "
        "Axes may be energy, angular_momentum or radius too."
    )


def resonances_between(low: float, high: float, max_order: int) -> list[tuple[int, int, int]]:
    """Return the resonances m : n in a range of frequency ratios.

    Parameters
    ----------
    low, high : float
        Range low < m/n < high.
    max_order : int
        Largest order m + n.

    Returns
    -------
    list of tuple of int
        Lines (n, 0, -m) for `plot_frequency_map`.

    Examples
    --------
    >>> fa.plot.resonances_between(1.2, 1.6, 7)
    [(2, 0, -3), (3, 0, -4)]
    """
    found = [
        (n, 0, -m)
        for n in range(1, max_order)
        for m in range(1, max_order - n + 1)
        if math.gcd(m, n) == 1 and low < m / n < high
    ]
    return sorted(found, key=lambda k: k[0] - k[2])


MOST_LINES = 400
"""Resonance lines that a figure can hold."""


def lines_of(
    lines: Any, x: str, y: str, view: tuple[Sequence[float], Sequence[float]], *, turns: bool = True
) -> list[tuple[int, int, int]]:
    """Return resonance lines k1 X + k2 Y + k0 = 0 as integers, from a sequence of such triples, one triple, or a text
    "order<=5", which stands for all that cross a view ((x0, x1), (y0, y1)).

    The order is |k1| + |k2| for tunes, whose k0 is any integer, and |k1| + |k2| + |k0| for ratios, with k . nu = 0;
    without `turns` the k0 of frequencies is 0.
    """
    refused = (
        f"lines must be triples (k1, k2, k0), each for k1 * {x} + k2 * {y} + k0 = 0, or a text such as "
        f'"order<=5", got {lines!r}'
    )
    if not isinstance(lines, str):
        if not isinstance(lines, (Sequence, np.ndarray)):
            raise TypeError(refused)
        each = [lines] if len(lines) == 3 and all(np.ndim(k) == 0 for k in lines) else list(lines)
        if any(np.shape(line) != (3,) for line in each):
            raise ValueError(refused)
        return [tuple(whole("lines", k, -(10**6)) for k in line) for line in each]  # type: ignore[misc]
    found = re.fullmatch(r"\s*order\s*<=\s*(\d{1,2})\s*", lines)
    if found is None or not int(found[1]):
        raise ValueError(refused)
    order = int(found[1])
    ratios = "/" in x and "/" in y
    corners = [(u, v) for u in view[0] for v in view[1]]
    kept = []
    for k1, k2 in itertools.product(range(order + 1), range(-order, order + 1)):
        if not 0 < abs(k1) + abs(k2) <= order or (k1 == 0 and k2 < 0):
            continue
        value = [-(k1 * u + k2 * v) for u, v in corners]
        for k0 in range(math.ceil(min(value)), math.floor(max(value)) + 1):
            weight = abs(k1) + abs(k2) + (abs(k0) if ratios else 0)
            if weight <= order and math.gcd(k1, k2, k0) == 1 and (ratios or turns or k0 == 0):
                kept.append((k1, k2, k0))
        if len(kept) > MOST_LINES:
            raise ValueError(
                f"lines must be at most {MOST_LINES} in the figure, got more for {shown(lines)}. Try a lower order or "
                "limits=."
            )
    return kept


def on_line(frequency_map: Any, line: Sequence[int], *, x: str, y: str, tolerance: float, shown: Any = True) -> int:
    """Count the orbits close to a resonance line.

    Parameters
    ----------
    frequency_map : FrequencyMap or Tunes
        Frequencies of orbits.
    line : sequence of int
        Integers (k1, k2, k0) of the line k1 X + k2 Y + k0 = 0.
    x, y : str
        Names of the frequencies or ratios X and Y, as in `frequency`.
    tolerance : float
        Bound of ``|k1 X + k2 Y + k0|``.
    shown : array_like of bool, shape (orbits,), default True
        Orbits to count.

    Returns
    -------
    int
        Number of orbits.

    Examples
    --------
    >>> freq = fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0)
    >>> fa.plot.on_line(freq, (1, 0, -1), x="y/x", y="x", tolerance=0.1)
    1
    """
    X = frequency(frequency_map, x)
    Y = frequency(frequency_map, y)
    with np.errstate(all="ignore"):
        return int(np.count_nonzero((np.abs(line[0] * X + line[1] * Y + line[2]) < tolerance) & shown))
