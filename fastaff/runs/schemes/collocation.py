"""Collocation at Gauss's nodes: implicit, symplectic, reversible, for any equations. Data that checks itself."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isfinite

import numpy as np

from ...core.numbers import text, whole
from .conditions import MOST_ORDER, agree, moments, require


@dataclass(frozen=True)
class Collocation:
    """Define a symplectic collocation at symmetric nodes.

    Parameters
    ----------
    name : str
        Name of the scheme.
    order : int
        Order, which construction checks.
    source : str
        Publication.
    nodes : tuple of str
        Larger half of the nodes in (0, 1), as decimal numbers of 30 digits or more. The number of stages, twice their
        number, is a multiple of 4.
    sweeps : int, default 64
        Largest number of sweeps of the iteration over the stages.

    Raises
    ------
    TypeError
        If a value has a wrong type.
    ValueError
        If the nodes contradict the order, the scheme is not symplectic, or the number of stages is not a multiple of 4.

    Notes
    -----
    * Step of dz/dt = f(z): Y_i = z + sum_j m_ij L_j, L_i = h b_i f(Y_i); it ends at z + sum_i L_i.
    * Accuracy: the iteration converges to round-off, and steps are added with compensated summation. m_ij + m_ji = 1
      exactly, so quadratic invariants and the symplectic form are conserved to round-off.
    * Order: 2s with the s nodes of Gauss.
    * Cost: about eight sweeps a step.

    References
    ----------
    Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed. 2006, II.1.3 and IV.2; Antonana, Makazaga and
    Murua, Numer. Algorithms 76 (2017) 861.

    Examples
    --------
    >>> fa.schemes.GAUSS8.order, fa.schemes.GAUSS8.stages
    (8, 4)
    """

    name: str
    order: int
    source: str
    nodes: tuple[str, ...]
    sweeps: int = 64

    def __repr__(self) -> str:
        return self.name

    def __post_init__(self) -> None:
        text("name", self.name)
        text("source", self.source)
        whole("order", self.order, 1, MOST_ORDER)
        whole("sweeps", self.sweeps, 1, 10_000)
        s = self.stages
        c = self._nodes
        require(s % 4 == 0 and s > 0, self.name, f"the number of stages must be a multiple of 4, got {s}")
        require(all(0 < x < 1 for x in c) and sorted({*c}) == c, self.name, "nodes must grow from 1/2 to 1")
        b = self.b_array
        a = self.a_array
        require(bool(np.isfinite(a).all()) and all(map(isfinite, b)), self.name, "coefficients must be finite")
        found = moments(tuple(b), np.array(c, dtype=np.float64), self.order)
        require(
            agree(found, 1 / np.arange(1, self.order + 1), tuple(b)), self.name, f"nodes contradict order {self.order}"
        )
        exact = np.array([[float(x) for x in row] for row in self._products])
        require(bool(np.abs(a - exact).max() <= 4e-16), self.name, "the collocation is not symplectic")

    @cached_property
    def _nodes(self) -> list[Fraction]:
        upper = [Fraction(x) for x in self.nodes]
        return [1 - x for x in reversed(upper)] + upper

    @cached_property
    def _lagrange(self) -> list[list[Fraction]]:
        """Coefficients of the polynomials that are 1 at one node and 0 at the others, constants first."""
        found = []
        c = self._nodes
        for j, own in enumerate(c):
            polynomial = [Fraction(1)]
            for other in (*c[:j], *c[j + 1 :]):
                shifted = [Fraction(0), *polynomial]
                polynomial = [
                    (high - other * low) / (own - other)
                    for high, low in zip(shifted, [*polynomial, Fraction(0)], strict=True)
                ]
            found.append(polynomial)
        return found

    @cached_property
    def _weights(self) -> list[Fraction]:
        return [_integral(polynomial, Fraction(1)) for polynomial in self._lagrange]

    @cached_property
    def _products(self) -> list[list[Fraction]]:
        """The tableau over the weights, a_ij/b_j."""
        pairs = list(zip(self._lagrange, self._weights, strict=True))
        return [[_integral(polynomial, x) / b for polynomial, b in pairs] for x in self._nodes]

    @property
    def stages(self) -> int:
        """Slopes of a sweep."""
        return 2 * len(self.nodes)

    @property
    def evaluations(self) -> int:
        """Slopes per step, about: those of eight sweeps."""
        return 8 * self.stages

    @property
    def symplectic(self) -> bool:
        """Whether it is symplectic and reversible with equal steps: yes."""
        return True

    @property
    def adaptive(self) -> bool:
        """Whether it can control its step size: no."""
        return False

    @property
    def a_array(self) -> np.ndarray:
        """A fresh float64 array (stages, stages) m_ij = a_ij/b_j, with m_ij + m_ji = 1 exactly."""
        m = np.full((self.stages, self.stages), 0.5)
        for i in range(self.stages):
            for j in range(i):
                large = self._products[i][j] > Fraction(1, 2)
                m[i, j] = float(self._products[i][j]) if large else 1.0 - float(self._products[j][i])
                m[j, i] = 1.0 - m[i, j]
        return m

    @property
    def b_array(self) -> np.ndarray:
        """A fresh float64 array (stages,)."""
        return np.array([float(b) for b in self._weights])

    @cached_property
    def dense_array(self) -> np.ndarray:
        """A float64 array (stages, 2*stages): the states at the nodes from the L of the step before and of the nodes
        before, by the integral of the polynomial through their slopes.
        """
        s = self.stages
        c = np.array([float(x) for x in self._nodes])
        b = self.b_array
        x, w = np.polynomial.legendre.leggauss(s)
        found = np.zeros((s, 2 * s))
        for i in range(s):
            nodes = np.concatenate([c - 1, c[:i]])
            at = c[i] * (x + 1) / 2
            for j, own in enumerate(nodes):
                others = np.delete(nodes, j)
                values = np.prod((at[:, None] - others) / (own - others), axis=1)
                found[i, j] = c[i] / 2 * (w @ values) / b[j % s]
        return found


def _value(polynomial: list[Fraction], x: Fraction) -> Fraction:
    total = Fraction(0)
    for coefficient in reversed(polynomial):
        total = total * x + coefficient
    return total


def _integral(polynomial: list[Fraction], x: Fraction) -> Fraction:
    """Return the integral from 0 to x."""
    return x * _value([coefficient / (k + 1) for k, coefficient in enumerate(polynomial)], x)


SOURCE = (
    "Gauss's nodes; Kuntzmann 1961, Butcher 1964; Hairer, Lubich, Wanner 2006, II.1.3 and IV.2; Antonana, Makazaga and "
    "Murua, Numer. Algorithms 76 (2017) 861"
)

GAUSS8 = Collocation(
    name="GAUSS8",
    order=8,
    source=SOURCE,
    nodes=("0.6699905217924281324013328795516223436003", "0.9305681557970262876119732444464047525479"),
)

GAUSS16 = Collocation(
    name="GAUSS16",
    order=16,
    source=SOURCE,
    nodes=(
        "0.5917173212478249024697380711800919903334",
        "0.7627662049581644929088695245946231745210",
        "0.8983332387068133697957769682379152184186",
        "0.9801449282487681158417804342847364952141",
    ),
)
