"""Energy levels of one symmetry class, and their wave functions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..base.display import screen
from ..base.numbers import whole
from .state import Shape, State
from .symmetry import SymmetryClass


@dataclass(frozen=True)
class Levels:
    """The lowest levels of a symmetry class (m, l): Psi = e^(i m phi + i l psi) f.

    E (levels,), ascending; error (levels,): the larger of the change from a smaller basis and rounding; converged
    (levels,): error below the tolerance asked for. labels (levels, 2): quantum numbers of the factors `names`,
    ("alpha", "beta") or ("r", "vartheta"); both None where the body does not separate. functions: size of the largest
    basis; method: one sentence on the method, with boundary conditions; describe: shape, quantum numbers and separation
    constants of level k, for `state`.
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
    describe: Callable[[int], tuple[Shape, dict[str, int], dict[str, float]]] = field(repr=False)

    def __repr__(self) -> str:
        return screen(self)

    def state(self, k: int) -> State:
        """Return the wave function of level k, counted from 0; raises TypeError or ValueError for what is no level."""
        if whole("k", k, 0) >= self.E.size:
            raise ValueError(f"k must be below the number of levels {self.E.size}, got {k}")
        shape, numbers, constants = self.describe(int(k))
        return State(SymmetryClass(self.m, self.l), shape, numbers, float(self.E[k]), constants, self.hbar)


def level_scale(E: np.ndarray) -> np.ndarray:
    """Return what errors of levels are relative to: |E|, or the mean spacing where E is next to 0."""
    return np.maximum(np.abs(E), (E[-1] - E[0]) / max(E.size - 1, 1))
