"""Functions of the angles eta and gamma of bodies with angular potentials: what e^(i m phi + i l psi) is for others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

POINTS = 1 << 20
"""Numbers of a table of waves at once."""


class AngleFunction(NamedTuple):
    """A real function of an angle, of mean square 1: coefficients of 1, sqrt2 cos(x), sqrt2 sin(x), sqrt2 cos(2 x), ...
    or, where it changes sign over 2 pi, of sqrt2 cos(x/2), sqrt2 sin(x/2), sqrt2 cos(3 x/2), ...
    """

    changes_sign: bool
    coefficients: tuple[float, ...]

    def __repr__(self) -> str:
        return f"a Fourier series of {len(self.coefficients)} waves"

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the values (...) at angles x (...)."""
        c = np.array(self.coefficients)
        flat = np.ravel(x)
        out = np.empty(flat.size)
        k = np.arange(c.size)
        waves = k // 2 + 0.5 if self.changes_sign else (k + 1) // 2
        sine = k % 2 == (1 if self.changes_sign else 0)
        front = np.sqrt(2) * c
        if not self.changes_sign:
            sine[0] = False
            front[0] = c[0]
        step = max(POINTS // c.size, 1)
        for start in range(0, flat.size, step):
            some = flat[start : start + step, None]
            out[start : start + step] = (
                np.cos(some * waves[~sine]) @ front[~sine] + np.sin(some * waves[sine]) @ front[sine]
            )
        return out.reshape(np.shape(x))

    def overlap(self, other: AngleFunction) -> float:
        """Return the mean over all angles of the product with another function."""
        if self.changes_sign != other.changes_sign:
            return 0.0
        return float(sum(a * b for a, b in zip(self.coefficients, other.coefficients, strict=False)))


class AngularClass(NamedTuple):
    """States of one level of eta and one of gamma: their numbers, from 0, their functions, and K = 2 mu c/hbar^2 of
    both separation constants, which take the place of a^2 = (m - l)^2/4 and b^2 = (m + l)^2/4.

    Source: Martens & Slawianowski, EQ2.1 with V_eta, V_gamma (the quantum problem is derived).
    """

    n_eta: int
    n_gamma: int
    eta: AngleFunction
    gamma: AngleFunction
    K: tuple[float, float]

    @property
    def a(self) -> float:
        """Return the effective angular momentum of the plane alpha, 0 where it is attractive."""
        return float(np.sqrt(max(self.K[0], 0.0)))

    @property
    def b(self) -> float:
        """Return the effective angular momentum of the plane beta, 0 where it is attractive."""
        return float(np.sqrt(max(self.K[1], 0.0)))

    @property
    def single_valued(self) -> bool:
        """Whether both functions have the period 2 pi: functions on GL(2,R) itself."""
        return not self.eta.changes_sign

    @property
    def labels(self) -> dict[str, int]:
        """Return no quantum numbers beside those of the coordinates."""
        return {}

    def turned(self, eta: np.ndarray, gamma: np.ndarray) -> np.ndarray:
        """Return the factor of Psi beside the amplitude."""
        return self.eta(eta) * self.gamma(gamma)

    def overlap(self, other: object) -> float:
        """Return the overlap of the functions of the angles."""
        if not isinstance(other, AngularClass):
            raise ValueError("other must be a state of a body with angular potentials, got one with m and l")
        return self.eta.overlap(other.eta) * self.gamma.overlap(other.gamma)


@dataclass(frozen=True, repr=False)
class AngularWaves:
    """Wave functions of a body with angular potentials: of each pair of angular levels the class and its `Waves`."""

    classes: tuple[tuple[AngularClass, Any], ...]

    def __repr__(self) -> str:
        return f"wave functions of {len(self.classes)} pairs of levels of eta and gamma"

    def symmetry(self, n: Sequence[int]) -> AngularClass:
        """Return the class of the state with quantum numbers n (4,)."""
        return self._pair(n)[0]

    def shape(self, n: Sequence[int]) -> Any:
        """Return the shape of the state with quantum numbers n (4,)."""
        return self._pair(n)[1].shape(n[:2])

    def _pair(self, n: Sequence[int]) -> tuple[AngularClass, Any]:
        """Return the class of quantum numbers n (4,) and its waves."""
        return next(pair for pair in self.classes if (pair[0].n_eta, pair[0].n_gamma) == (n[2], n[3]))
