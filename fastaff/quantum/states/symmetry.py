"""Symmetry classes of wave functions: the spin and vorticity quanta m, l of e^(i m phi + i l psi)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.numbers import flag, positive, real, shown, whole_numbers

MOST = 10**6
"""Largest |m|, |l|: the squares of larger ones leave no digits for levels."""


class SymmetryClass(NamedTuple):
    """Wave functions e^(i m phi + i l psi) f(alpha, beta) = e^(i (m - l) eta/2 + i (m + l) gamma/2) f.

    a = |m - l|/2 and b = |m + l|/2 are the angular momenta of the planes alpha and beta, in units of hbar. A function
    on GL(2,R) itself has m + l even, so a and b are integers; with m + l odd it lives on the double covering.
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

    @property
    def K(self) -> tuple[float, float]:
        """Return a^2 and b^2."""
        return self.a**2, self.b**2

    @property
    def single_valued(self) -> bool:
        """Whether m + l is even: functions on GL(2,R) itself."""
        return (self.m + self.l) % 2 == 0

    @property
    def labels(self) -> dict[str, int]:
        """Return the quantum numbers by name."""
        return {"m": self.m, "l": self.l}

    def turned(self, eta: np.ndarray, gamma: np.ndarray) -> np.ndarray:
        """Return the factor of Psi beside the amplitude."""
        return np.exp(0.5j * ((self.m - self.l) * eta + (self.m + self.l) * gamma))

    def overlap(self, other: object) -> float:
        """Return the overlap of the functions of the angles."""
        if not isinstance(other, SymmetryClass):
            raise ValueError("other must be a state with m and l, got one of a body with angular potentials")
        return float(self == other)

    def alike(self) -> list[SymmetryClass]:
        """Return all classes with the same |m - l| and |m + l|, which have the same levels, itself among them."""
        m, l = self
        return sorted({SymmetryClass(*pair) for pair in ((m, l), (l, m), (-m, -l), (-l, -m))}, reverse=True)


def checked_class(m: Any, l: Any, single_valued: Any = True) -> SymmetryClass:
    """Return the class of the quantum numbers; whole floats are converted.

    Raises TypeError or ValueError for values that are no whole numbers, ValueError for m + l odd where `single_valued`.
    """
    chosen = SymmetryClass(whole_quantum("m", m), whole_quantum("l", l))
    for name, value in chosen._asdict().items():
        if abs(value) > MOST:
            raise ValueError(f"{name} must be at most {MOST} in size, got {shown(value)}")
    check_parity(chosen.m, chosen.l, single_valued)
    return chosen


def check_parity(m: ArrayLike, l: ArrayLike, single_valued: Any) -> None:
    """Raise ValueError where m + l is odd and wave functions are to be `single_valued`: (phi + pi, psi + pi) is the
    same matrix.
    """
    spin = np.atleast_1d(m)
    vorticity = np.atleast_1d(l)
    odd = np.flatnonzero((spin + vorticity) % 2)
    if flag("single_valued", single_valued) and odd.size:
        raise ValueError(
            f"m + l must be even, got m = {spin[odd[0]]}, l = {vorticity[odd[0]]}. Use single_valued=False for "
            "functions on the double cover."
        )


def checked_numbers(n: Any, m: Any, l: Any, single_valued: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return quantum numbers n (2, levels) of two coordinates, m and l (levels,), for given ones that broadcast.

    Raises TypeError or ValueError for other than whole numbers, n < 0, different lengths, and as `check_parity`.
    """
    quanta = whole_numbers("n", n)
    spins = (whole_numbers("m", m), whole_numbers("l", l))
    if quanta.ndim not in (1, 2) or quanta.shape[0] != 2 or np.any(quanta < 0):
        raise ValueError(f"n must have shape (2,) or (2, levels) and be >= 0, got {shown(n)}")
    sizes = {q.size for q in (quanta[0], *spins)} - {1}
    if len(sizes) > 1 or spins[0].ndim > 1 or spins[1].ndim > 1:
        raise ValueError(
            f"n, m and l must be single or have the same number of levels, got {[q.shape for q in (quanta, *spins)]}"
        )
    n1, n2, spin, vorticity = np.broadcast_arrays(*(q.ravel() for q in (*quanta, *spins)))
    check_parity(spin, vorticity, single_valued)
    return np.array([n1, n2]), spin.copy(), vorticity.copy()


def refuse_spins(m: Any, l: Any) -> None:
    """Raise ValueError if m or l is given for a body with angular potentials."""
    for name, value in (("m", m), ("l", l)):
        if value is not None:
            raise ValueError(
                f"{name} must be None for a body with angular potentials, got {shown(value)}. Use n_eta, n_gamma."
            )


def action_quantum(hbar: Any, mu: float = 1.0) -> float:
    """Return hbar > 0 if hbar^2/mu is well within the range of floats, with room for products of it."""
    quantum = positive("hbar", hbar)
    if not (1e-100 < quantum < 1e100 and 1e-200 < quantum * (quantum / mu) < 1e200):
        raise ValueError(
            f"hbar must lie in [1e-100, 1e100] and hbar^2/mu in [1e-200, 1e200], got {shown(hbar)} with mu = {mu:g}"
        )
    return quantum


def whole_quantum(name: str, value: Any) -> int:
    """Return a quantum number as an int: ints, and floats that are whole."""
    try:
        number = real(name, value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, got {shown(value)} ({type(value).__name__})") from None
    if not number.is_integer():
        raise ValueError(f"{name} must be a whole number, got {shown(value)}")
    return int(number)
