"""Maps of one turn as Taylor series, written as statements of `fastaff.iterated_map`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..core.numbers import listed, numbers

SIX = ("x", "px", "y", "py", "t", "pt")
POWERS = ("nx", "nxp", "ny", "nyp", "ndeltap", "nt")
MOST = 3000
"""Most coefficients of a map that is written and compiled."""

PART = 100
"""Most coefficients of one statement."""

Terms = dict[tuple[int, ...], float]
"""Coefficients of a series by the exponents of its variables."""


def of_columns(columns: Mapping[str, Any], name: str) -> list[Terms]:
    """Return the series of a table of coefficients, as MAD-X's map_table: coef, n_vector, the number of the series, and
    the exponents `POWERS`.
    """
    table = {f"{key}".lower(): value for key, value in columns.items()}
    missing = [entry for entry in ("coef", "n_vector", *POWERS) if entry not in table]
    if missing:
        raise ValueError(f"{name} must be a table of a map with coef, n_vector, {listed(POWERS)}: no {missing[0]}")
    rows = numbers(f"{name}['n_vector']", table["n_vector"]).astype(int) - 1
    found: list[Terms] = [{} for _ in SIX]
    powers = np.array([numbers(f"{name}[{entry!r}]", table[entry]) for entry in POWERS]).astype(int).T
    for row, power, value in zip(rows, powers, numbers(f"{name}['coef']", table["coef"]), strict=True):
        if not 0 <= row < len(SIX):
            raise ValueError(f"{name}['n_vector'] must be 1 to {len(SIX)}, got {row + 1}")
        found[row][tuple(power.tolist())] = float(value)
    return found


def turn(series: Sequence[Terms]) -> str:
    """Return the text of the map of x, px, y, py, of deviations from the closed orbit: the constants are that orbit.

    ValueError where the longitudinal variables do not stay at rest, as with cavities.
    """
    used: set[int] = set()
    for _ in SIX[4:]:
        rows = [*series[:4], *(series[k] for k in used if k < len(series))]
        used |= {k for row in rows for power in row for k in range(4, len(power)) if power[k]}
    if any(any(power[:4]) and not any(power[4:]) for k in used if k < len(series) for power in series[k]):
        raise ValueError("a map must leave the momentum as it is: switch cavities off, or track with icase=5")
    plain = [{power[:4]: value for power, value in row.items() if value and not any(power[4:])} for row in series[:4]]
    for row in plain:
        row.pop((0, 0, 0, 0), None)
    count = sum(map(len, plain))
    if not all(plain) or count > MOST:
        raise ValueError(f"text must be a map of 1 to {MOST} coefficients of x, px, y, py on momentum, got {count}")
    lines: dict[str, str] = {}
    for name, row in zip(SIX, plain, strict=False):
        terms = [f"({value!r})*{_monomial(power, lines)}" for power, value in row.items()]
        parts = {f"{name}_{k}_": " + ".join(terms[k : k + PART]) for k in range(0, len(terms), PART)}
        lines |= {**parts, f"{name}1": " + ".join(parts)}
    return "\n".join(f"{name} = {formula}" for name, formula in lines.items())


def _monomial(power: tuple[int, ...], lines: dict[str, str]) -> str:
    """Return the name of a product of variables, and add the product to `lines`."""
    last = max(k for k in range(4) if power[k])
    rest = tuple(n - (k == last) for k, n in enumerate(power))
    if not any(rest):
        return SIX[last]
    name = "m" + "_".join(map(str, power)) + "_"
    if name not in lines:
        before = _monomial(rest, lines)
        lines[name] = f"{before}*{SIX[last]}"
    return name
