"""Symmetry classes of wave functions: the spin and vorticity quanta m, l of e^(i m phi + i l psi)."""

from __future__ import annotations

import operator
from typing import Any, NamedTuple

from ..base.numbers import flag, positive, shown

MOST = 10**6
"""Largest |m|, |l|: the squares of larger ones leave no digits for levels."""


class SymmetryClass(NamedTuple):
    """Wave functions e^(i m phi + i l psi) f(alpha, beta) = e^(i (m - l) eta/2 + i (m + l) gamma/2) f.

    a = |m - l|/2 and b = |m + l|/2 are the angular momenta of the planes alpha and beta, in units of hbar. A function
    on GL(2,R) itself has m + l even, so a and b are integers; with m + l odd it lives on the double covering. Source:
    Martens & Slawianowski, EQ4.1, EQ4.2; m + l even: derived from phi(phi + pi, psi + pi) = phi(phi, psi).
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
    for name, value in chosen._asdict().items():
        if abs(value) > MOST:
            raise ValueError(f"{name} must be at most {MOST} in size, got {shown(value)}")
    if flag("single_valued", single_valued) and (chosen.m + chosen.l) % 2:
        raise ValueError(
            f"m + l must be even for single-valued wave functions on GL(2,R), got m = {m}, l = {l}; "
            "single_valued=False takes the covering"
        )
    return chosen


def action_quantum(hbar: Any, mu: float = 1.0) -> float:
    """Return hbar > 0, whose hbar^2/mu is within the range of floats, with room for what is made of it."""
    quantum = positive("hbar", hbar)
    if not (1e-100 < quantum < 1e100 and 1e-200 < quantum * (quantum / mu) < 1e200):
        raise ValueError(
            f"hbar must lie between 1e-100 and 1e100, and hbar^2/mu between 1e-200 and 1e200; got {hbar!r} with mu = "
            f"{mu:g}"
        )
    return quantum


def whole_quantum(name: str, value: Any) -> int:
    """Return a quantum number as an int: ints, and floats that are whole."""
    try:
        if isinstance(value, bool):
            raise TypeError
        return operator.index(value)
    except TypeError:
        pass
    if getattr(value, "ndim", 0) == 0 and (
        isinstance(value, float) or getattr(getattr(value, "dtype", None), "kind", "") == "f"
    ):
        number = float(value)
        if number.is_integer():
            return int(number)
        raise ValueError(f"{name} must be a whole number, got {shown(value)}")
    raise TypeError(f"{name} must be a whole number, got {shown(value)} ({type(value).__name__})")
