"""Stationary states on GL(2,R): Psi on matrices and in charts, densities, expectation values, overlaps.

    Psi = e^(i m phi + i l psi) A(x, y),    |Psi|^2 integrated with dx dy dz du = alpha beta dalpha dbeta deta dgamma is
    1.

A `State` is a symmetry class and a `Shape`, the real amplitude A over two invariants; the source of the shape does not
matter. The shape of separable bodies is a `Product` of two factors,

    A = (1/2 pi) f_alpha f_beta,    A = (sqrt2/pi) f_r f_vartheta.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked, first
from ...core.docstrings import inserts_parameters
from ...core.numbers import fits, listed, shown, whole
from ...core.numbers import function as a_function
from ...engine.packing import run_points
from ...results.display import screen
from ...results.result import Drawable
from ...runs.requirements import checked_chart
from ...systems.charts import ALPHA_BETA, CARTESIAN, R_VARTHETA, TWO_POLAR, Chart
from ..kernels.laguerre_jacobi import plane_radii, turn_planes
from .angle_states import AngularClass
from .factors import Factor
from .symmetry import SymmetryClass

CHUNK = 1 << 15
"""Points done at once: few enough for the arrays between factors and Psi to stay in the cache; larger ones halve the
speed.
"""


class Invariants(NamedTuple):
    """Two deformation invariants as coordinates of the quadrant alpha, beta >= 0.

    front: normalisation of product states of this chart; from_radii, to_radii: conversions; area: |d(alpha,
    beta)/d(invariants)|; ranges: least and largest value of both.
    """

    front: float
    from_radii: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
    to_radii: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
    area: float
    ranges: tuple[tuple[float, float], tuple[float, float]]


def _same(alpha: np.ndarray, beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return alpha, beta


def _to_r_vartheta(alpha: np.ndarray, beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return alpha * alpha + beta * beta, 2 * np.arctan2(beta, alpha)


def _from_r_vartheta(r: np.ndarray, vartheta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rho = np.sqrt(r)
    return rho * np.cos(vartheta / 2), rho * np.sin(vartheta / 2)


def _turned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return (x + y) / math.sqrt(2), (x - y) / math.sqrt(2)


_RADIUS = (0.0, math.inf)
_ANY = (-math.inf, math.inf)
INVARIANTS = {
    ALPHA_BETA.name: Invariants(1 / (2 * math.pi), _same, _same, 1.0, (_RADIUS, _RADIUS)),
    R_VARTHETA.name: Invariants(
        math.sqrt(2) / math.pi, _to_r_vartheta, _from_r_vartheta, 0.25, (_RADIUS, (0.0, math.pi))
    ),
    TWO_POLAR.name: Invariants(1.0, _turned, _turned, 1.0, (_ANY, _ANY)),
}


def invariants_of(chart: Any, among: tuple[Chart, ...] = (ALPHA_BETA, R_VARTHETA, TWO_POLAR)) -> Invariants:
    """Return the invariants of a chart; raises ValueError for one that is not among those given."""
    if getattr(chart, "name", None) not in [known.name for known in among]:
        raise ValueError(
            f"chart must be {listed(known.name for known in among)}, got {shown(getattr(chart, 'name', chart))}"
        )
    return INVARIANTS[chart.name]


def checked_invariants(x: ArrayLike, y: ArrayLike, chart: Chart) -> tuple[np.ndarray, np.ndarray]:
    """Return invariants of a chart as floats; raises ValueError or TypeError for values that are not finite, or outside
    of their ranges.
    """
    ranges = invariants_of(chart).ranges
    rows = []
    for letter, own, value, (least, most) in zip("xy", chart.names, (x, y), ranges, strict=False):
        name = f"{letter} ({own})"
        row = checked(name, value, ())
        outside = (row < least) | (row > most)
        if outside.any():
            index = first(outside)
            raise ValueError(
                f"{name} must lie in [{least:g}, {most:.3g}], got {row[index]}{f' at index {index}' if index else ''}"
            )
        rows.append(row)
    return rows[0], rows[1]


def _together(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y broadcast; raises ValueError where they do not."""
    try:
        first, second = (np.array(entry) for entry in np.broadcast_arrays(x, y))  # copies, which kernels may take
    except (ValueError, RuntimeError):
        raise ValueError(f"x and y must broadcast, got shapes {x.shape} and {y.shape}") from None
    return first, second


class Shape(Protocol):
    """The methods of a state's amplitude: values, and quadrature, over two invariants of its chart (ALPHA_BETA or
    R_VARTHETA).
    """

    @property
    def chart(self) -> Chart:
        """Return the chart of the invariants."""

    @property
    def degrees(self) -> tuple[int, int]:
        """Return the degrees in both invariants: n + 1 nodes are enough for the norm."""

    def __call__(self, x: np.ndarray, y: np.ndarray, /) -> np.ndarray:
        """Return A (...) at invariants x, y (...)."""

    def of_radii(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return A (...) at alpha, beta (...) >= 0."""

    def rule(self, orders: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return nodes x (i,), y (j,), weights (i, j): the integral of A^2 g over GL(2,R) is the sum of
        weight*A^2*g.
        """


class Product(NamedTuple):
    """The shape of a product of two factors, functions of the invariants of `chart`, each normalised in its own
    measure.
    """

    chart: Chart
    factors: tuple[Factor, Factor]

    @property
    def degrees(self) -> tuple[int, int]:
        """Return the degrees of the factors."""
        first, second = self.factors
        return first.degree, second.degree

    def __call__(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return A (...)."""
        product = self.factors[0](x) * INVARIANTS[self.chart.name].front
        product *= self.factors[1](y)
        return product

    def of_radii(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return A (...) at alpha, beta >= 0, without trigonometry."""
        if self.chart.name == ALPHA_BETA.name:
            return self(alpha, beta)
        first: Factor = self.factors[0]
        second: Any = self.factors[1]  # factors of vartheta have of_squares
        A = alpha * alpha
        B = beta * beta
        r = A + B
        product = first(r) * INVARIANTS[self.chart.name].front
        scale = 1 / np.where(r > 0, r, 1.0)
        product *= second.of_squares(B * scale, np.where(r > 0, A * scale, 1.0))
        return product

    def rule(self, orders: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the product of the factors' own rules."""
        (x, u), (y, v) = (factor.rule(order) for factor, order in zip(self.factors, orders, strict=True))
        return x, y, np.outer(u, v) / INVARIANTS[self.chart.name].front ** 2


@dataclass(frozen=True)
class State(Drawable):
    """Stationary state Psi = e^(i m phi + i l psi) A of one symmetry class: call it on matrices.

    The argument phi has the shape (2, 2, ...). For m + l odd, Psi has two values on a matrix; use ``at``. Psi is
    normalised. Signs: factors are positive near alpha = 0, beta = 0 and r = 0, or near the potential barrier. For a
    nonseparable body, the largest coefficient of A is positive.

    Attributes
    ----------
    symmetry : object
        Symmetry class, with the quantum numbers m and l, or, for angular potentials, with the functions of eta and
        gamma in place of e^(i m phi + i l psi).
    shape : object
        Amplitude A, a product of ``factors`` if the body separates.
    numbers : dict of int
        Quantum numbers by name.
    energy : float
        Energy.
    constants : dict of float
        Separation constants by name.
    hbar : float
        Planck's constant over 2 pi.

    References
    ----------
    Martens & Slawianowski, EQ4.3 and section 5 (the norms are derived).
    """

    symmetry: SymmetryClass | AngularClass
    shape: Shape
    numbers: dict[str, int]
    energy: float
    constants: dict[str, float]
    hbar: float

    def __repr__(self) -> str:
        return screen(self)

    def __post_init__(self) -> None:
        invariants_of(self.chart, (ALPHA_BETA, R_VARTHETA))

    @property
    def chart(self) -> Chart:
        """Chart of the amplitude, `ALPHA_BETA` or `R_VARTHETA`."""
        return self.shape.chart

    @property
    def labels(self) -> dict[str, int]:
        """Quantum numbers by name.

        They are n_alpha, n_beta or n_r, n_vartheta if the body separates, and m, l, or n_eta, n_gamma.
        """
        return self.numbers | self.symmetry.labels

    def __call__(self, phi: ArrayLike) -> np.ndarray:
        """Return Psi (...), complex, at matrices phi (2, 2, ...); of any determinant, also 0."""
        return self.planes(CARTESIAN.points_to_planes(checked("phi", phi, (2, 2)).reshape(4, *np.shape(phi)[2:])))

    def planes(self, planes: ArrayLike) -> np.ndarray:
        """Return Psi at points of the planes, the fastest way, without trigonometry.

        Parameters
        ----------
        planes : array_like, shape (4, ...)
            Rows a1, a2, b1, b2.

        Returns
        -------
        ndarray of complex, shape (...)
            Psi.
        """
        if not self.symmetry.single_valued:
            raise ValueError(
                "q must be coordinates where m + l is odd: Psi has two values on a matrix. Use at(q, ALPHA_BETA)."
            )
        rows = checked("planes", planes, (4,))
        if isinstance(self.symmetry, AngularClass):
            a1, a2, b1, b2 = rows
            amplitude = self._of_radii(np.hypot(a1, a2), np.hypot(b1, b2))
            return amplitude * self.symmetry.turned(np.arctan2(a2, a1), np.arctan2(b2, b1))
        flat = np.ascontiguousarray(rows.reshape(4, -1))
        out = np.empty(flat.shape[1], complex)
        m, l = self.symmetry
        for start in range(0, out.size, CHUNK):
            some = flat[:, start : start + CHUNK]
            radii = np.empty((2, some.shape[1]))
            run_points(plane_radii, (some, radii), some.shape[1])
            turned = some, radii, self._of_radii(radii[0], radii[1]), out[start : start + CHUNK]
            run_points(turn_planes, ((m - l) // 2, (m + l) // 2, *turned), some.shape[1])
        return out.reshape(rows.shape[1:])[()]

    def at(self, q: ArrayLike, chart: Chart = ALPHA_BETA) -> np.ndarray:
        """Return Psi at coordinates of a chart.

        Parameters
        ----------
        q : array_like, shape (4, ...)
            Coordinates, for example rows alpha, beta, eta, gamma. For m + l odd, the angles select one of the two
            values, and radii must not be negative.
        chart : Chart, default ALPHA_BETA
            Any chart.

        Returns
        -------
        ndarray of complex, shape (...)
            Psi.
        """
        rows = checked("q", q, (4,))
        planes = checked_chart(chart).points_to_planes(rows)
        if self.symmetry.single_valued:
            return self.planes(planes)
        eta, gamma = _angles(chart, rows)
        alpha = np.hypot(planes[0], planes[1])
        beta = np.hypot(planes[2], planes[3])
        if np.any(np.cos(eta) * planes[0] + np.sin(eta) * planes[1] < -0.5 * alpha) or np.any(
            np.cos(gamma) * planes[2] + np.sin(gamma) * planes[3] < -0.5 * beta
        ):
            raise ValueError("q must have radii >= 0 where m + l is odd")
        return self._of_radii(alpha, beta) * self.symmetry.turned(eta, gamma)

    @inserts_parameters
    def amplitude(self, x: ArrayLike, y: ArrayLike, chart: Chart | None = None) -> np.ndarray:
        """Return the real amplitude Psi e^(-i m phi - i l psi).

        Parameters
        ----------
        {invariant_values}
        {invariant_chart}

        Returns
        -------
        ndarray
            Amplitude.

        Raises
        ------
        ValueError
            If values are not invariants: negative radii, vartheta outside of [0, pi], or D1 < ``|D2|``.
        """
        own = self.chart if chart is None else chart
        first, second = _together(*checked_invariants(x, y, own))
        if own.name == self.chart.name:
            return self.shape(first, second)[()]
        alpha, beta = invariants_of(own).to_radii(first, second)
        if np.any((alpha < 0) | (beta < 0)):
            raise ValueError("x, y must have D1 >= |D2|, where every body is once")
        return self._of_radii(alpha, beta)[()]

    @inserts_parameters
    def density(self, x: ArrayLike, y: ArrayLike, chart: Chart | None = None) -> np.ndarray:
        """Return the probability density of two invariants.

        Parameters
        ----------
        {invariant_values}
        {invariant_chart}

        Returns
        -------
        ndarray
            Density per unit dx dy. Its integral is 1. In `TWO_POLAR` it is 0 outside of D1 >= ``|D2|``, the region that
            has every body once.

        Notes
        -----
        The density is ``|Psi|^2`` times 4 pi^2 alpha beta, (pi^2/2) r sin(vartheta), or 2 pi^2 (D1^2 - D2^2).

        References
        ----------
        Martens & Slawianowski, section 5 (the measure, integrated over both angles).
        """
        own_chart = self.chart if chart is None else chart
        chosen = invariants_of(own_chart)
        first, second = _together(*checked_invariants(x, y, own_chart))
        alpha, beta = chosen.to_radii(first, second)
        inside: Any = True
        if chosen is INVARIANTS[TWO_POLAR.name]:
            inside = (alpha >= 0) & (beta >= 0)
            alpha = np.where(inside, alpha, 0.0)
            beta = np.where(inside, beta, 0.0)
        own = self._of_radii(alpha, beta) if chosen is not INVARIANTS[self.chart.name] else self.shape(first, second)
        return np.where(inside, (2 * math.pi * own) ** 2 * alpha * beta * chosen.area, 0.0)[()]

    def norm(self, *, order: int | None = None) -> float:
        """Return the norm of Psi by quadrature.

        Parameters
        ----------
        order : int, optional
            Number of quadrature nodes of each factor. Default: n + 32.

        Returns
        -------
        float
            The norm.
        """
        return math.sqrt(float(np.real(self.expectation(lambda x, y: np.ones(np.shape(x)), order=order))))

    @inserts_parameters
    def expectation(
        self,
        function: Callable[[np.ndarray, np.ndarray], np.ndarray],
        *,
        chart: Chart | None = None,
        order: int | None = None,
    ) -> Any:
        """Return the expectation value of a function of two invariants by Gauss quadrature.

        Parameters
        ----------
        function : callable
            Function of two arrays, the invariants, that returns real or complex values.
        {invariant_chart}
        order : int, optional
            Number of quadrature nodes of each factor. Default: n + 32.

        Returns
        -------
        float or complex
            Expectation value.

        Raises
        ------
        ValueError
            If the chart or the order is not supported.

        Notes
        -----
        For closed-form factors the value is exact to round-off for polynomials of alpha^2 and beta^2, or r and cos
        vartheta, of degree up to 63. For other functions, raise `order` until the digits do not change.
        """
        chosen = invariants_of(self.chart if chart is None else chart)
        a_function("function", function)
        first, second, weights = self._rule(order, self.shape.degrees)
        alpha, beta = INVARIANTS[self.chart.name].to_radii(first, second)
        values = np.asarray(
            function(*(first, second) if chosen is INVARIANTS[self.chart.name] else chosen.from_radii(alpha, beta))
        )
        return np.sum(weights * self.shape(first, second) ** 2 * values).item()

    def overlap(self, other: State, *, order: int | None = None) -> float:
        """Return the overlap ``<self|other>``, 0 between different symmetry classes of one body.

        Parameters
        ----------
        other : State
            The other state.
        order : int, optional
            Number of quadrature nodes of each factor. Default: the larger n of both states + 32.

        Returns
        -------
        float
            The overlap.
        """
        if not isinstance(other, State):
            raise TypeError(f"other must be a State, got {type(other).__name__}")
        around = self.symmetry.overlap(other.symmetry)
        if around == 0.0:
            return 0.0
        first, second, weights = self._rule(order, (max(self.shape.degrees + other.shape.degrees),) * 2)
        theirs = other._of_radii(*INVARIANTS[self.chart.name].to_radii(first, second))
        return around * float(np.sum(weights * self.shape(first, second) * theirs))

    def _rule(self, order: int | None, degrees: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return meshes of both invariants and weights, `order` nodes each or 32 more than the degrees need."""
        first, second = (n + 32 if order is None else max(whole("order", order, 1), n + 1) for n in degrees)
        for size in (first, second):
            fits("order", 2 * size, size)
        fits("order", 4 * first, second)
        x, y, weights = self.shape.rule((first, second))
        return *np.meshgrid(x, y, indexing="ij"), weights

    def _of_radii(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return the amplitude at alpha, beta >= 0."""
        return self.shape.of_radii(alpha, beta)


def _angles(chart: Chart, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return eta, gamma, not reduced, from coordinates q (4, ...) of a chart with angles of space and body."""
    named = dict(zip(chart.names, q, strict=True))
    if "eta" in named:
        return named["eta"], named["gamma"]
    if "phi" in named:
        return named["phi"] - named["psi"], named["phi"] + named["psi"]
    if "Phi" in named:
        return (named["Phi"] + named["Psi"]) / 2, (named["Phi"] - named["Psi"]) / 2
    raise ValueError(
        "chart must have the angles eta and gamma, phi and psi, or Phi and Psi where m + l is odd, got "
        f"{shown(chart.name)}"
    )
