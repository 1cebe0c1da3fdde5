"""Runge-Kutta-Nyström schemes: explicit, of high order, for forces of the coordinates (and time) alone. Data that
checks itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from math import factorial, isfinite

import numpy as np

from ...core.numbers import reals, text, whole
from . import _dprkn12
from .conditions import MOST_ORDER, Rows, Weights, agree, moments, require, tableau, values


@dataclass(frozen=True)
class Nystrom:
    """Define an explicit Runge-Kutta-Nystrom tableau for H = T(p) + V(q), T quadratic.

    Parameters
    ----------
    name : str
        Name of the scheme.
    order : int
        Order, which construction checks.
    source : str
        Publication.
    a : tuple of tuple of float
        Row i has i entries.
    b : tuple of float
        Weights of the momenta, one for each stage.
    c : tuple of float
        Nodes, one for each stage: the first 0, the others positive.

    Raises
    ------
    TypeError
        If a value has a wrong type.
    ValueError
        If a row of `a` does not sum to c_i^2/2, or if weights contradict the order.

    Notes
    -----
    * Step: stage i has the force F_i at q + c_i h v(p + h sum_j a_ij/c_i F_j), with the velocities v(p) of T. A step
      ends at q + h v(p + h sum_j b_j (1 - c_j) F_j) and p + h sum_j b_j F_j, added with compensated summation.
    * Properties: neither symplectic nor reversible; energies drift by its error.
    * The test of the order covers quadratures and forces linear in the coordinates. It is necessary, not sufficient.

    Examples
    --------
    >>> fa.schemes.RKN12.order, fa.schemes.RKN12.stages
    (12, 17)
    """

    name: str
    order: int
    source: str
    a: Rows
    b: Weights
    c: Weights

    symplectic = False
    """Whether it is symplectic and reversible with equal steps."""

    adaptive = False
    """Whether it can control its step size."""

    nystrom = True
    """Whether its order holds only for T quadratic in p."""

    def __repr__(self) -> str:
        return self.name

    def __post_init__(self) -> None:
        text("name", self.name)
        text("source", self.source)
        whole("order", self.order, 1, MOST_ORDER)
        for what in ("b", "c"):
            object.__setattr__(self, what, reals(f"scheme {self.name}: {what}", getattr(self, what)))
        object.__setattr__(self, "a", tableau(f"scheme {self.name}: a", self.a))
        for condition, fault in (
            (len(self.a) == self.stages == len(self.c), "a, b and c must have one row or entry per stage"),
            (all(len(row) == i for i, row in enumerate(self.a)), "row i of a must have i entries (explicit)"),
            (all(map(isfinite, chain(*self.a, self.b, self.c))), "coefficients must be finite"),
            (self.c[0] == 0 and all(x > 0 for x in self.c[1:]), "nodes must be positive, the first 0"),
        ):
            require(condition, self.name, fault)
        b = np.array(self.b)
        c = np.array(self.c)
        powers = np.arange(self.order)
        for i, row in enumerate(self.a):
            require(agree(sum(row), c[i] ** 2 / 2, row), self.name, f"row {i} of a must sum to c[{i}]**2/2")
        found = moments(self.b, c, self.order)
        require(agree(found, 1 / (1 + powers), self.b), self.name, f"b contradicts the order {self.order}")
        a = np.array([[*row, *[0.0] * (self.stages - len(row))] for row in self.a])
        size = (float(np.abs(b) @ np.abs(a).sum(axis=1)),)
        inner = a @ c[:, None] ** powers - c[:, None] ** (powers + 2) / ((powers + 1) * (powers + 2))
        for k in powers[:-2]:
            defects = [(b * c**k) @ inner[:, : self.order - 2 - k]]  # for forces linear in q, with coefficients t^k
            moved = c**k
            for m in range(1, (self.order - 1 - k) // 2 + 1):  # for a linear force with a part t^k
                moved = a @ moved
                defects.append(np.array([b @ moved - factorial(k) / factorial(k + 1 + 2 * m)]))
            require(agree(np.concatenate(defects), 0.0, size), self.name, f"a contradicts the order {self.order}")

    @property
    def stages(self) -> int:
        """Forces in a step."""
        return len(self.b)

    @property
    def evaluations(self) -> int:
        """Forces per step."""
        return self.stages

    @property
    def increments(self) -> bool:
        """Whether steps are summed with carried rounding errors: yes."""
        return True

    @property
    def drift_array(self) -> np.ndarray:
        """A fresh float64 array of the nonzero values of a_ij/c_i, then of b_j (1 - c_j) and b_j."""
        return np.array([x for row in self._sums for x in row if x != 0.0], dtype=np.float64)

    @cached_property
    def terms(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of the forces in the sums of stages, of the drift and of the kick."""
        return tuple(tuple(j for j, x in enumerate(row) if x != 0.0) for row in self._sums)

    @cached_property
    def _sums(self) -> list[list[float]]:
        rows = [[x / node for x in row] for row, node in zip(self.a, self.c)]
        return [*rows, [x * (1 - node) for x, node in zip(self.b, self.c)], [*self.b]]

    @property
    def kick_array(self) -> np.ndarray:
        """A fresh float64 array (stages,) of the nodes."""
        return np.array(self.c, dtype=np.float64)


RKN12 = Nystrom(
    name="RKN12",
    order=12,
    source="Dormand, El-Mikkawy and Prince, IMA J. Numer. Anal. 7 (1987) 423, the formula of order 12 of RKN12(10)17; "
    "digits of the rationals in SciML's OrdinaryDiffEq.jl, which fulfil the conditions to 1e-50",
    a=tuple(map(values, _dprkn12.A)),
    b=values(_dprkn12.B),
    c=values(_dprkn12.C),
)
