"""Frequencies of a map by name, and the resonances among their ratios."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..analysis.frequencies.frequencies import FrequencyKind
from ..base.numbers import an_array, shown, text, whole
from ..schemes.catalogue import ITERATION

CAUGHT = 0.25
"""Share of a leading line by which that of a resonance's own swing may differ from it: of bananas in logarithmic
potentials it is 0.04 to 0.2, of harmonics in discs 0.27 to 0.52.
"""


def in_time(frequency_map: Any) -> bool:
    """Tell whether frequencies are those of a flow, in cycles per unit time: tunes of a map are modulo a turn."""
    return hasattr(frequency_map, "leading") and frequency_map.scheme is not ITERATION


def by_own_lines(frequency_map: Any) -> bool:
    """Tell whether figures are of the coordinates' own lines: of flows in time, but for a body's planes."""
    return in_time(frequency_map) and frequency_map.nu_eta is None


def harmonics(found: Any) -> np.ndarray:
    """Tell which leading lines (n, orbits) of regular orbits are but a harmonic of another coordinate's: leading_i =
    c nu_j with c > 1, where nu_j leads its own coordinate, and the own nu_i is far from it.

    The radius of an orbit in a galaxy has the line 2 nu_z, often its strongest. Orbits that a resonance has caught,
    such as bananas, have these lines too, but swing about them slowly: their nu_i is within `CAUGHT` of the leading
    one, which stays.
    """
    rows, orbits = np.arange(len(found.basis))[:, None], np.arange(found.basis.shape[2])
    size = np.abs(found.basis)
    source = size.argmax(axis=1)  # (n, orbits): the generator j of each row
    alone = np.count_nonzero(size, axis=1) == 1
    leads = alone & (source == rows) & (size.sum(axis=1) == 1)
    with np.errstate(all="ignore"):
        far = np.abs(found.nu / found.leading - 1) > CAUGHT
    multiple = alone & (size.sum(axis=1) > 1) & (source != rows)
    return multiple & leads[source, orbits] & far & (found.kind == FrequencyKind.INDEPENDENT)


def frequencies_of(found: Any, chosen: Any = None) -> np.ndarray:
    """Return the frequencies (n, orbits) that figures draw, NaN where there are none: those chosen, or the own line of
    each coordinate, `leading`, but `nu` where that is a harmonic; of maps, tunes and bodies `nu`.
    """
    if chosen is not None:
        values = an_array("frequencies", chosen)
        if values.shape != found.nu.shape or values.dtype.kind not in "iuf":
            example = "found.nu or found.leading" if in_time(found) else "found.nu"
            raise ValueError(f"frequencies must be an array {found.nu.shape}, such as {example}, got {shown(chosen)}")
        return np.where(np.isfinite(found.error), values, np.nan)
    nu = np.where(np.isfinite(found.error), found.nu, np.nan)
    if not by_own_lines(found):
        return nu
    leading = np.where(np.isfinite(found.leading_error), found.leading, np.nan)
    return np.where(harmonics(found), nu, leading)


def frequency(frequency_map: Any, name: str, frequencies: Any = None) -> np.ndarray:
    """Return one frequency (orbits,) of a map by name: a row of .names, `eta` or `gamma`; or a ratio of two:
    "beta/alpha"; NaN of orbits that have none.

    :Parameters: frequencies: (n, orbits) those of the coordinates, such as `freq.nu` or `freq.leading`. By default the
        leading line of each coordinate, as the order of independent frequencies changes from orbit to orbit; `nu` where
        that is a harmonic of another coordinate's own line and farther than a quarter from `nu` (the line 2 nu_z of a
        star's R), as well as for maps and bodies.

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
    raise ValueError(f"frequency must be one of {', '.join(frequency_map.names)}{extra}, or a ratio a/b, got {name!r}")


def resonances_between(low: float, high: float, max_order: int) -> list[tuple[int, int, int]]:
    """Return the resonances m : n with low < m/n < high as lines (n, 0, -m) of a frequency map, of order m + n at
    most.

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
    """Return resonance lines k1 X + k2 Y + k0 = 0 as integers: of a sequence of such triples, of one triple, or of a
    text "order<=5", which stands for all that cross a view ((x0, x1), (y0, y1)).

    The order is |k1| + |k2| of tunes, whose k0 is any integer, and with |k0| of ratios, where k . nu = 0; where there
    are no `turns` the k0 of frequencies is 0.
    """
    if not isinstance(lines, str):
        if not isinstance(lines, (Sequence, np.ndarray)):
            raise TypeError(f'lines must be triples (k1, k2, k0), or a text such as "order<=5", got {lines!r}')
        each = [lines] if len(lines) == 3 and all(np.ndim(k) == 0 for k in lines) else list(lines)
        if any(np.shape(line) != (3,) for line in each):
            raise ValueError(f'lines must be triples (k1, k2, k0), or a text such as "order<=5", got {lines!r}')
        return [tuple(whole("lines", k, -(10**6)) for k in line) for line in each]  # type: ignore[misc]
    found = re.fullmatch(r"\s*order\s*<=\s*(\d{1,2})\s*", lines)
    if found is None or not int(found[1]):
        raise ValueError(f'lines must be triples (k1, k2, k0), or a text such as "order<=5", got {lines!r}')
    order, ratios = int(found[1]), "/" in x and "/" in y
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
            raise ValueError(f"lines: more than {MOST_LINES} of {lines!r} cross the figure; a lower order, or limits=")
    return kept


def on_line(frequency_map: Any, line: Sequence[int], *, x: str, y: str, tolerance: float, shown: Any = True) -> int:
    """Count the orbits, of those shown, with ``|k1 X + k2 Y + k0|`` < tolerance for the line (k1, k2, k0) of a map's
    plane.

    Examples
    --------
    >>> freq = fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0)
    >>> fa.plot.on_line(freq, (1, 0, -1), x="y/x", y="x", tolerance=0.1)
    1
    """
    X, Y = frequency(frequency_map, x), frequency(frequency_map, y)
    with np.errstate(all="ignore"):
        return int(np.count_nonzero((np.abs(line[0] * X + line[1] * Y + line[2]) < tolerance) & shown))
