"""Solutions of one-dimensional problems as factors of states: one factor for each problem and level."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..states.factors import AngleFactor, Factor, PlaneFactor, RadialFactor
from .elements import ElementFunction, Elements
from .jacobi_basis import IntervalFunction, ProblemEnds


class AngularFunction(NamedTuple):
    """f(vartheta), int f^2 sin(vartheta) dvartheta = 1."""

    function: IntervalFunction | ElementFunction

    @property
    def degree(self) -> int:
        """Return the degree of its polynomial."""
        return self.function.degree

    def __call__(self, vartheta: ArrayLike) -> np.ndarray:
        """Return f; 0 where V is infinite."""
        half = np.asarray(vartheta, float) / 2
        return self.of_squares(np.sin(half) ** 2, np.cos(half) ** 2)

    def of_squares(self, sine: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Return f of sin^2(vartheta/2) and cos^2(vartheta/2), each accurate where it is small."""
        f = self.function
        x = cosine - sine
        return f.at(2 * cosine if f.lo == -1 else x - f.lo, 2 * sine if f.hi == 1 else f.hi - x)

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return Gauss nodes and weights, exact for f^2 times polynomials of cos(vartheta) of degree < 2 (order -
        degree).
        """
        below, weights = self.function.rule(order)
        return angle_of(self.function.lo, self.function.hi, below), weights


def angle_of(lo: float, hi: float, below: np.ndarray) -> np.ndarray:
    """Return vartheta of x = cos(vartheta) = lo + below, in (lo, hi)."""
    above = hi - lo - below
    return 2 * np.arctan2(np.sqrt((1 - hi + above) / 2), np.sqrt((1 + lo + below) / 2))


class RadialFunction(NamedTuple):
    """f(q) of a radius in `dimension` dimensions, int f^2 q^(dimension - 1) dq = 1; as a function of r = q^2, int f^2 r
    dr = 1, for 4.
    """

    function: IntervalFunction | ElementFunction
    dimension: int

    @property
    def degree(self) -> int:
        """Return the degree of its polynomial."""
        return self.function.degree

    def __call__(self, coordinate: ArrayLike) -> np.ndarray:
        """Return f; 0 where V is infinite or f has decayed below rounding."""
        f = self.function
        power = -(self.dimension - 1) / 2
        coordinate = np.asarray(coordinate, float)
        q = coordinate if self.dimension == 2 else np.sqrt(coordinate)
        shift, rest = (power, 0.0) if f.lo == 0 else (0.0, power)
        values = f.at(q - f.lo, f.hi - q, shift) * np.maximum(q, f.lo) ** rest
        return values if self.dimension == 2 else values / np.sqrt(2)

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return Gauss nodes and weights, exact for f^2 times polynomials of q of degree < 2 (order - degree)."""
        below, weights = self.function.rule(order)
        q = self.function.lo + below
        return (q, weights * q) if self.dimension == 2 else (q * q, 2 * weights * q**3)


class FactorTable(Protocol):
    """Factors by problem and level."""

    def __call__(self, problem: int, level: int) -> Factor:
        """Return the normalised solution of one level of one problem."""


class IntervalFunctions(NamedTuple):
    """Solutions in one basis: coefficients (problems, n, levels) of the orthonormal polynomials."""

    interval: ProblemEnds
    coefficients: np.ndarray

    def one(self, problem: int, level: int) -> IntervalFunction:
        """Return one solution."""
        v = self.interval
        c = self.coefficients[problem, :, level]
        return IntervalFunction(v.lo, v.hi, float(v.e_lo[problem]), float(v.e_hi[problem]), c)


class ElementFunctions(NamedTuple):
    """Solutions on elements, those of each problem: coefficients (size, levels)."""

    lines: tuple[Elements, ...]
    coefficients: tuple[np.ndarray, ...]

    def one(self, problem: int, level: int) -> ElementFunction:
        """Return one solution."""
        return ElementFunction(self.lines[problem], self.coefficients[problem][:, level])


class RadialTable(NamedTuple):
    """Computed factors of a radius in `dimension` dimensions."""

    functions: IntervalFunctions | ElementFunctions
    dimension: int

    def __call__(self, problem: int, level: int) -> RadialFunction:
        """Return one factor."""
        return RadialFunction(self.functions.one(problem, level), self.dimension)


class AngularTable(NamedTuple):
    """Computed factors of vartheta."""

    functions: IntervalFunctions | ElementFunctions

    def __call__(self, problem: int, level: int) -> AngularFunction:
        """Return one factor."""
        return AngularFunction(self.functions.one(problem, level))


class OscillatorTable(NamedTuple):
    """Factors in closed form of oscillators in 2 or 4 dimensions: index s (problems,) and kappa."""

    dimension: int
    s: np.ndarray
    kappa: float

    def __call__(self, problem: int, level: int) -> Factor:
        """Return one factor."""
        factor = PlaneFactor if self.dimension == 2 else RadialFactor
        return factor(level, float(self.s[problem]), self.kappa)


class BarrierTable(NamedTuple):
    """Factors of vartheta in closed form: indices s_alpha, s_beta (problems,)."""

    s_alpha: np.ndarray
    s_beta: np.ndarray

    def __call__(self, problem: int, level: int) -> Factor:
        """Return one factor."""
        return AngleFactor(level, float(self.s_alpha[problem]), float(self.s_beta[problem]))


class Factors(NamedTuple):
    """Solutions of one-dimensional problems: values and their errors (problems, levels), their functions by problem and
    level, the size of the basis, `said` about the potential, and the amount by which values may be too high because of
    wells that are not excluded, if this is not in the error.
    """

    values: np.ndarray
    error: np.ndarray
    functions: FactorTable
    size: int
    said: str = ""
    lost: float = 0.0
