"""Energy levels of one symmetry class, and their wave functions (layer L3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..scalars import whole


class FactorState(NamedTuple):
    """A product of two factors, functions of the coordinates in `names`, each normalised in its own measure.

    int f_alpha^2 alpha dalpha = int f_beta^2 beta dbeta = 1; int f_r^2 r dr = int f_vartheta^2 sin(vartheta) dvartheta = 1.
    """

    names: tuple[str, str]
    factors: tuple[Callable, Callable]

    def value(self, alpha: ArrayLike, beta: ArrayLike) -> np.ndarray:
        """Return f at alpha, beta >= 0, normalised int f^2 alpha beta dalpha dbeta = 1."""
        alpha, beta = np.asarray(alpha, float), np.asarray(beta, float)
        first, second = self.factors
        if self.names == ("alpha", "beta"):
            return first(alpha) * second(beta)
        return np.sqrt(8.0) * first(alpha**2 + beta**2) * second(2 * np.arctan2(beta, alpha))


@dataclass(frozen=True)
class Levels:
    """The lowest levels of a symmetry class (m, l): Psi = e^(i m phi + i l psi) f.

    E (levels,), ascending; error (levels,): the larger of the change from a smaller basis and rounding; converged (levels,): error below
    the tolerance asked for. labels (levels, 2): quantum numbers of the factors `names`, ("alpha", "beta") or ("r", "vartheta"); both None
    where the body does not separate. functions: size of the largest basis; method: one sentence on the method, with boundary conditions.
    """

    E: np.ndarray
    error: np.ndarray
    converged: np.ndarray
    labels: np.ndarray | None
    names: tuple[str, str] | None
    m: int
    l: int
    hbar: float
    functions: int
    method: str
    make_state: Callable[[int], Any] = field(repr=False)

    def state(self, k: int) -> Any:
        """Return the wave function f of level k, with `value(alpha, beta)`, int f^2 alpha beta dalpha dbeta = 1.

        Where the body separates a FactorState, with `factors`. Raises IndexError or TypeError for what is no level.
        """
        if whole("k", k, 0) >= self.E.size:
            raise IndexError(f"k must be below the number of levels {self.E.size}, got {k}")
        return self.make_state(k)


def level_scale(E: np.ndarray) -> np.ndarray:
    """Return what errors of levels are relative to: |E|, or the mean spacing where E is next to 0."""
    return np.maximum(np.abs(E), (E[-1] - E[0]) / max(E.size - 1, 1))
