"""Exactly solvable bodies.

Solvable are oscillators with walls V = k_alpha alpha^2/2 + c_alpha/alpha^2 + k_beta beta^2/2 + c_beta/beta^2 in (alpha,
beta), and V = k r/2 + c/r + (c_alpha/cos^2(vartheta/2) + c_beta/sin^2(vartheta/2))/r in (r, vartheta); `Harmonic` and
`Anharmonic` are both. With a breathing term they are solvable in (r, vartheta).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.numbers import positive
from ...systems.models.functions import Barriers, Oscillator, Spring
from ...tori.families import ALPHA_BETA_FAMILY, Family
from ...tori.separation import separate
from ..states.symmetry import action_quantum


class SolvableBody(NamedTuple):
    """An oscillator with walls in the chart of `family`: k, c of alpha and beta, the core c/r (r-vartheta only), mu,
    hbar.

    Source: Martens & Slawianowski, EQ3.1, EQa, EQb (section 5); walls elsewhere are derived, they only change the
    indices.
    """

    family: Family
    k: tuple[float, float]
    walls: tuple[float, float]
    core: float
    mu: float
    hbar: float
    breathing: float = 0.0

    @property
    def radial_mu(self) -> float:
        """mu (1 + c) of a breathing term c."""
        return self.mu * (1 + self.breathing)

    @property
    def kappa(self) -> tuple[float, float]:
        """sqrt(k mu)/hbar of alpha and beta."""
        first, second = (float(np.sqrt(k * self.radial_mu)) / self.hbar for k in self.k)
        return first, second

    @property
    def quanta(self) -> np.ndarray:
        """hbar omega of alpha and beta."""
        return self.hbar * np.sqrt(np.array(self.k) / self.radial_mu)

    def indices(self, m: ArrayLike, l: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return s_alpha = sqrt(((m - l)/2)^2 + 2 mu c_alpha/hbar^2) and s_beta, the exponents at alpha = 0 and beta =
        0.

        Raises ValueError if a wall attracts more than the centrifugal term repels.
        """
        spin = np.asarray(m, float)
        vorticity = np.asarray(l, float)
        squares = [
            ((spin + sign * vorticity) / 2) ** 2 + 2 * self.mu / self.hbar**2 * c
            for sign, c in zip((-1, 1), self.walls, strict=True)
        ]
        for square, c in zip(squares, self.walls, strict=True):
            if np.any(square < 0):
                raise ValueError(
                    f"model must have 2 mu c/hbar^2 >= -(m -+ l)^2/4 for each m, l, got a potential barrier c = {c}"
                )
        return np.sqrt(squares[0]), np.sqrt(squares[1])

    def angular_index(self, n_vartheta: ArrayLike, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return 2 n_vartheta + 1 + s_alpha + s_beta, the square root of 1 + 2 mu e_vartheta/hbar^2."""
        s_alpha, s_beta = self.indices(m, l)
        return 2 * np.asarray(n_vartheta) + 1 + s_alpha + s_beta

    def radial_index(self, n_vartheta: ArrayLike, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return 2 epsilon = sqrt(1 + 2 mu (e_vartheta + c)/hbar^2), the index of f_r, with mu (1 + c) for mu."""
        square = self.angular_index(n_vartheta, m, l) ** 2 + 2 * self.mu * self.core / self.hbar**2
        square = square + self.breathing * (square - 1)
        if np.any(square < 0):
            raise ValueError(f"model has a core c = {self.core} that attracts below any energy")
        return np.sqrt(square)

    def constants(self, n: np.ndarray, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return the rows E_alpha, E_beta, or E, e_vartheta, of n (2, ...): eigenvalues of the chart's constants of
        motion.
        """
        if self.family == ALPHA_BETA_FAMILY:
            s = self.indices(m, l)
            return np.array([quantum * (2 * n[i] + 1 + s[i]) for i, quantum in enumerate(self.quanta)])
        e = self.hbar**2 / (2 * self.mu) * (self.angular_index(n[1], m, l) ** 2 - 1)
        return np.array([self.quanta[0] * (2 * n[0] + 1 + self.radial_index(n[1], m, l)), e])

    def energy(self, n: np.ndarray, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return E of n (2, ...)."""
        constants = self.constants(n, m, l)
        return self.family.energy(constants)


def solvable(model: Any, chart: Any = None, hbar: Any = 1.0) -> SolvableBody:
    """Return `model` as an exactly solvable one in `chart` (None: the first in which it separates).

    Raises TypeError or ValueError for wrong input, ValueError for a body without closed-form states there.
    """
    separated = separate(model, chart)
    quantum = action_quantum(hbar, separated.mu)
    first, second = separated.functions
    name = type(model.potential).__name__
    if not separated.isotropic:
        raise ValueError(
            f"model must be isotropic for m and l to be quantum numbers, got {name} with angular potentials"
        )
    if isinstance(first, Oscillator) and isinstance(second, Oscillator):
        found = SolvableBody(separated.family, (first.k, second.k), (first.c, second.c), 0.0, separated.mu, quantum)
    elif isinstance(first, Spring) and isinstance(second, Barriers):
        walls = (second.c_alpha, second.c_beta)
        found = SolvableBody(
            separated.family, (first.k, first.k), walls, first.c, separated.mu, quantum, separated.breathing
        )
    else:
        raise ValueError(
            f"model must have closed-form states in the {separated.family.chart} chart, such as those of Harmonic and "
            f"Anharmonic, got {name}"
        )
    for k in found.k:
        positive("k (C) of the body", k)
    return found
