"""Symmetry classes of wave functions: the spin and vorticity quanta m, l of e^(i m phi + i l psi) (layer L3)."""

from __future__ import annotations

import operator
from typing import Any, NamedTuple


class SymmetryClass(NamedTuple):
    """Wave functions e^(i m phi + i l psi) f(alpha, beta) = e^(i (m - l) eta/2 + i (m + l) gamma/2) f.

    a = |m - l|/2 and b = |m + l|/2 are the angular momenta of the planes alpha and beta, in units of hbar. A function on GL(2,R)
    itself has m + l even, so a and b are integers; with m + l odd it lives on the double covering.
    Source: Martens & Slawianowski, EQ4.1, EQ4.2; m + l even: derived from phi(phi + pi, psi + pi) = phi(phi, psi).
    """

    m: int
    l: int

    @property
    def a(self) -> float:
        """Return |m - l|/2."""
        return abs(self.m - self.l) / 2

    @property
    def b(self) -> float:
        """Return |m + l|/2."""
        return abs(self.m + self.l) / 2

    def alike(self) -> list[SymmetryClass]:
        """Return all classes with the same |m - l| and |m + l|, which have the same levels, itself among them."""
        m, l = self
        return sorted({SymmetryClass(*pair) for pair in ((m, l), (l, m), (-m, -l), (-l, -m))}, reverse=True)


def checked_class(m: Any, l: Any, single_valued: Any = True) -> SymmetryClass:
    """Return the class of the quantum numbers; whole floats are converted.

    Raises TypeError or ValueError for what is no whole number, ValueError for m + l odd where `single_valued`.
    """
    chosen = SymmetryClass(whole_quantum("m", m), whole_quantum("l", l))
    if single_valued and (chosen.m + chosen.l) % 2:
        raise ValueError(
            f"m + l must be even for single-valued wave functions on GL(2,R), got m = {m}, l = {l}; single_valued=False takes the covering"
        )
    return chosen


def whole_quantum(name: str, value: Any) -> int:
    """Return a quantum number as an int: ints, and floats that are whole."""
    try:
        if isinstance(value, bool):
            raise TypeError
        return operator.index(value)
    except TypeError:
        pass
    if getattr(value, "ndim", 0) == 0 and (isinstance(value, float) or getattr(getattr(value, "dtype", None), "kind", "") == "f"):
        number = float(value)
        if number.is_integer():
            return int(number)
        raise ValueError(f"{name} must be a whole number, got {value!r}")
    raise TypeError(f"{name} must be a whole number, got {value!r} ({type(value).__name__})")
