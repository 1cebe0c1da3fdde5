"""The operators of the quantized body, applied to functions.

They are data, coefficients of derivatives in a chart, applied by central differences of order 8 to
any function of the coordinates: to check states, closed-form or numerical, by a method that is independent of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.differences import FIRST, OFFSETS, SECOND
from ...core.numbers import listed, positive, shown
from ...systems.charts import (
    ALPHA_BETA,
    ALPHA_BETA_PHI_PSI,
    CARTESIAN,
    ELLIPTIC,
    EULER,
    POLAR_POLAR,
    R_VARTHETA,
    SPHERICAL,
    SPHERICAL_CARTESIAN,
    Chart,
)
from ...tori.families import ALPHA_BETA_FAMILY, ELLIPTIC_FAMILY
from ...tori.r4_charts import R4Separated
from ...tori.separation import separate_anywhere

Coefficient = Callable[[np.ndarray], Any]


class DifferentialOperator(NamedTuple):
    """A linear differential operator of order <= 2 in the coordinates of a chart.

    terms: coefficient(q), q (4, ...), of each derivative: (i, j) of d^2/dq_i dq_j (once for i != j), (i,) of d/dq_i, ()
    of 1.
    """

    chart: Chart
    terms: dict[tuple[int, ...], Coefficient]

    def __call__(self, function: Callable[[np.ndarray], np.ndarray], q: ArrayLike, *, step: float = 0.02) -> np.ndarray:
        """Return the operator applied to function(q), q (4, ...), at points q (4, ...): central differences, error
        O(step^8).
        """
        points = checked("q", q, (4,))
        h = positive("step", step)
        total: Any = 0.0
        for indices, coefficient in self.terms.items():
            total = total + coefficient(points) * _derivative(function, points, indices, h)
        return total

    def scaled(self, factor: Any) -> DifferentialOperator:
        """Return factor times the operator; factor: a number or a coefficient(q)."""
        weight: Coefficient = factor if callable(factor) else lambda q: factor
        return DifferentialOperator(self.chart, {k: _times(weight, c) for k, c in self.terms.items()})

    def plus(self, other: DifferentialOperator) -> DifferentialOperator:
        """Return the sum with an operator in the same chart."""
        terms = dict(self.terms)
        for k, c in other.terms.items():
            terms[k] = _sum(terms[k], c) if k in terms else c
        return DifferentialOperator(self.chart, terms)


def _times(first: Coefficient, second: Coefficient) -> Coefficient:
    return lambda q: first(q) * second(q)


def _sum(first: Coefficient, second: Coefficient) -> Coefficient:
    return lambda q: first(q) + second(q)


def _derivative(function: Callable, q: np.ndarray, indices: tuple[int, ...], h: float) -> np.ndarray:
    if not indices:
        return function(q)
    if len(indices) == 1:
        return _along(function, q, [(indices[0], 1)], FIRST, h) / h
    i, j = indices
    if i == j:
        return _along(function, q, [(i, 1)], SECOND, h) / h**2
    both, across = (_along(function, q, [(i, 1), (j, sign)], SECOND, h) for sign in (1, -1))
    return (both - across) / (4 * h**2)


def _along(
    function: Callable, q: np.ndarray, direction: list[tuple[int, int]], weights: np.ndarray, h: float
) -> np.ndarray:
    used = np.flatnonzero(weights)
    points = np.repeat(q[:, None], used.size, axis=1)
    for row, sign in direction:
        points[row] += (sign * h * OFFSETS[used]).reshape(-1, *(1,) * (q.ndim - 1))
    return np.tensordot(weights[used], function(points), axes=1)


def _one(q: np.ndarray) -> float:
    return 1.0


def _minus_one(q: np.ndarray) -> float:
    return -1.0


def _width(q: np.ndarray) -> np.ndarray:
    """Return 2 (cosh^2(kappa) - cos^2(lambda)), the scale of the elliptic chart, without cancellation."""
    return 2 * (np.sinh(q[0]) ** 2 + np.sin(q[1]) ** 2)


_DELTA: tuple[tuple[Chart, dict[tuple[int, ...], Coefficient]], ...] = (
    (CARTESIAN, {(i, i): _one for i in range(4)}),
    (
        ALPHA_BETA,
        {
            (0, 0): _one,
            (0,): lambda q: 1 / q[0],
            (1, 1): _one,
            (1,): lambda q: 1 / q[1],
            (2, 2): lambda q: q[0] ** -2.0,
            (3, 3): lambda q: q[1] ** -2.0,
        },
    ),
    (
        ALPHA_BETA_PHI_PSI,
        {
            (0, 0): _one,
            (0,): lambda q: 1 / q[0],
            (1, 1): _one,
            (1,): lambda q: 1 / q[1],
            (2, 2): lambda q: (q[0] ** -2.0 + q[1] ** -2.0) / 4,
            (3, 3): lambda q: (q[0] ** -2.0 + q[1] ** -2.0) / 4,
            (2, 3): lambda q: (q[1] ** -2.0 - q[0] ** -2.0) / 2,
        },
    ),
    (
        R_VARTHETA,
        {
            (0, 0): lambda q: 4 * q[0],
            (0,): lambda q: 8.0,
            (1, 1): lambda q: 4 / q[0],
            (1,): lambda q: 4 / (q[0] * np.tan(q[1])),
            (2, 2): lambda q: 1 / (q[0] * np.sin(q[1]) ** 2),
            (3, 3): lambda q: 1 / (q[0] * np.sin(q[1]) ** 2),
            (2, 3): lambda q: 2 * np.cos(q[1]) / (q[0] * np.sin(q[1]) ** 2),
        },
    ),
    (
        EULER,
        {
            (0, 0): _one,
            (0,): lambda q: 3 / q[0],
            (2, 2): lambda q: 4 / q[0] ** 2,
            (2,): lambda q: 4 / (q[0] ** 2 * np.tan(q[2])),
            (1, 1): lambda q: 4 / (q[0] * np.sin(q[2])) ** 2,
            (3, 3): lambda q: 4 / (q[0] * np.sin(q[2])) ** 2,
            (1, 3): lambda q: -8 * np.cos(q[2]) / (q[0] * np.sin(q[2])) ** 2,
        },
    ),
    (
        ELLIPTIC,
        {
            (0, 0): lambda q: 1 / _width(q),
            (0,): lambda q: 2 / (np.tanh(2 * q[0]) * _width(q)),
            (1, 1): lambda q: 1 / _width(q),
            (1,): lambda q: 2 / (np.tan(2 * q[1]) * _width(q)),
            (2, 2): lambda q: 1 / (2 * (np.cosh(q[0]) * np.cos(q[1])) ** 2),
            (3, 3): lambda q: 1 / (2 * (np.sinh(q[0]) * np.sin(q[1])) ** 2),
        },
    ),
    (
        SPHERICAL,
        {
            (0, 0): _one,
            (0,): lambda q: 3 / q[0],
            (1, 1): lambda q: q[0] ** -2.0,
            (1,): lambda q: 2 / (q[0] ** 2 * np.tan(q[1])),
            (2, 2): lambda q: (q[0] * np.sin(q[1])) ** -2.0,
            (2,): lambda q: -np.tan(q[2]) / (q[0] * np.sin(q[1])) ** 2,
            (3, 3): lambda q: (q[0] * np.sin(q[1]) * np.cos(q[2])) ** -2.0,
        },
    ),
    (
        SPHERICAL_CARTESIAN,
        {
            (0, 0): _one,
            (0,): lambda q: 2 / q[0],
            (1, 1): lambda q: q[0] ** -2.0,
            (1,): lambda q: 1 / (q[0] ** 2 * np.tan(q[1])),
            (2, 2): lambda q: (q[0] * np.sin(q[1])) ** -2.0,
            (3, 3): _one,
        },
    ),
    (
        POLAR_POLAR,
        {
            (0, 0): _one,
            (0,): lambda q: 1 / q[0],
            (1, 1): lambda q: q[0] ** -2.0,
            (2, 2): _one,
            (2,): lambda q: 1 / q[2],
            (3, 3): lambda q: q[2] ** -2.0,
        },
    ),
)
LAPLACIANS = {chart.name: DifferentialOperator(chart, terms) for chart, terms in _DELTA}
"""The Laplace-Beltrami operator by the name of the chart. In EULER (Psi = -2 psi, cross term +2 cos(Theta) dPhi dPsi of
the metric) the mixed derivative has -2 cos(Theta); with Psi = +2 psi it is the +2 cos(Theta) of section 5, printed
there as 2 cot(Theta)."""


def laplacian(chart: Chart = ALPHA_BETA) -> DifferentialOperator:
    """Return the Laplace-Beltrami operator of GL(2,R) = R^4 in a chart.

    chart: CARTESIAN, ALPHA_BETA, ALPHA_BETA_PHI_PSI, R_VARTHETA, EULER, ELLIPTIC, SPHERICAL, SPHERICAL_CARTESIAN or
    POLAR_POLAR.  Raises ValueError for others.
    Source: Martens & Slawianowski, section 5, the forms of Delta (2 cos(Theta) in EULER, printed 2 cot(Theta)); derived
    from the metrics of section 3 in the last four.
    """
    if getattr(chart, "name", None) not in LAPLACIANS:
        raise ValueError(f"chart must be one of {listed(LAPLACIANS)}, got {shown(getattr(chart, 'name', chart))}")
    return LAPLACIANS[chart.name]


def hamiltonian_operator(model: Any, chart: Chart = ALPHA_BETA, *, hbar: float = 1.0) -> DifferentialOperator:
    """Return H = -(hbar^2/2 mu) Delta + V of a Body, separable or not, in a chart that `laplacian` takes.

    Raises ValueError or TypeError for wrong input.  Source: Martens & Slawianowski, section 5 (hbar^2, printed hbar).
    """
    quantum = positive("hbar", hbar)

    def potential(q: np.ndarray) -> np.ndarray:
        return model.potential_energy(*chart.points_to_planes(q))

    kinetic = laplacian(chart).scaled(-(quantum**2) / (2 * positive("mu of the body", model.mu)))
    return kinetic.plus(DifferentialOperator(chart, {(): potential}))


def constant_operators(model: Any, chart: Chart = ALPHA_BETA, *, hbar: float = 1.0) -> dict[str, DifferentialOperator]:
    """Return the operators that a separable body's chart comes with, by name.

    model: separable in `chart`; ALPHA_BETA: H_alpha, H_beta, p_phi, p_psi, which commute; R_VARTHETA: h_vartheta, H,
    p_phi, p_psi, which commute, and H_r, which does not; ELLIPTIC: K, L, H, p_phi, p_psi, which commute; SPHERICAL,
    for potentials of r alone: H, L_4^2, L_3^2, p_nu, which commute; hbar > 0.  Returns a dict. Raises ValueError or
    TypeError for wrong input.
    Formulas: H_alpha = ((p_phi - p_psi)^2/(4 alpha^2) - hbar^2 (d^2 + d/alpha))/(2 mu) + V_alpha; h_vartheta = (p_phi^2
    + 2 cos p_phi p_psi + p_psi^2)/(2 mu sin^2) - (2 hbar^2/mu) (d^2 + cot d) + V_vartheta; H = H_r + h_vartheta/r; K =
    (cos^2(lambda) h_kappa + cosh^2(kappa) h_lambda)/(2 (cosh^2 - cos^2)), L = H - K.
    Source: Martens & Slawianowski, section 5 (4 alpha^2, 4 beta^2 in H_alpha, H_beta, printed alpha^2, beta^2); K and L
    of section 3 (corrected), quantized.
    """
    quantum = positive("hbar", hbar)
    separated = separate_anywhere(model, chart)
    if isinstance(separated, R4Separated):
        if not separated.family.whole:
            raise ValueError(
                "chart must be alpha-beta, r-vartheta, elliptic or spherical, got " + shown(separated.family.chart)
            )
        return _spherical_operators(separated, quantum)
    if not separated.isotropic:
        raise ValueError("model must be isotropic for p_phi and p_psi to be constants, got angular potentials")
    V_first, V_second = separated.functions
    half = quantum**2 / (2 * separated.mu)
    delta = LAPLACIANS[separated.family.chart].terms
    if separated.family == ELLIPTIC_FAMILY:
        turn = [DifferentialOperator(ELLIPTIC, {(3,): _one, (2,): sign}) for sign in (_one, _minus_one)]
        operators = _elliptic_operators(V_first, V_second, half)
    elif separated.family == ALPHA_BETA_FAMILY:
        plane = [
            DifferentialOperator(ALPHA_BETA, {k: c for k, c in delta.items() if set(k) <= {i, i + 2}}).scaled(-half)
            for i in range(2)
        ]
        turn = [DifferentialOperator(ALPHA_BETA, {(3,): _one, (2,): sign}) for sign in (_one, _minus_one)]
        operators = {
            "H_alpha": plane[0].plus(DifferentialOperator(ALPHA_BETA, {(): lambda q: V_first.value(q[0])})),
            "H_beta": plane[1].plus(DifferentialOperator(ALPHA_BETA, {(): lambda q: V_second.value(q[1])})),
        }
    else:
        radial = DifferentialOperator(R_VARTHETA, {k: c for k, c in delta.items() if k in ((0, 0), (0,))}).scaled(-half)
        shear = DifferentialOperator(R_VARTHETA, {k: c for k, c in delta.items() if k not in ((0, 0), (0,))})
        h = shear.scaled(lambda q: -half * q[0]).plus(
            DifferentialOperator(R_VARTHETA, {(): lambda q: V_second.value(q[1])})
        )
        H_r = radial.plus(DifferentialOperator(R_VARTHETA, {(): lambda q: V_first.value(q[0])}))
        operators = {"h_vartheta": h, "H_r": H_r, "H": H_r.plus(h.scaled(lambda q: 1 / q[0]))}
        turn = [DifferentialOperator(R_VARTHETA, {(i,): _one}) for i in (2, 3)]
    return operators | {"p_phi": turn[0].scaled(-1j * quantum), "p_psi": turn[1].scaled(-1j * quantum)}


def _elliptic_operators(V_kappa: Any, V_lambda: Any, half: float) -> dict[str, DifferentialOperator]:
    """Return K, L and H in the elliptic chart; half: hbar^2/(2 mu)."""
    h_kappa = DifferentialOperator(
        ELLIPTIC,
        {
            (0, 0): lambda q: -half,
            (0,): lambda q: -2 * half / np.tanh(2 * q[0]),
            (2, 2): lambda q: half / np.cosh(q[0]) ** 2,
            (3, 3): lambda q: -half / np.sinh(q[0]) ** 2,
            (): lambda q: V_kappa.value(q[0]),
        },
    )
    h_lambda = DifferentialOperator(
        ELLIPTIC,
        {
            (1, 1): lambda q: -half,
            (1,): lambda q: -2 * half / np.tan(2 * q[1]),
            (2, 2): lambda q: -half / np.cos(q[1]) ** 2,
            (3, 3): lambda q: -half / np.sin(q[1]) ** 2,
            (): lambda q: V_lambda.value(q[1]),
        },
    )

    def mixed(of_kappa: Coefficient, of_lambda: Coefficient) -> DifferentialOperator:
        return h_kappa.scaled(lambda q: of_kappa(q) / _width(q)).plus(
            h_lambda.scaled(lambda q: of_lambda(q) / _width(q))
        )

    return {
        "K": mixed(lambda q: np.cos(q[1]) ** 2, lambda q: np.cosh(q[0]) ** 2),
        "L": mixed(lambda q: np.sin(q[1]) ** 2, lambda q: -(np.sinh(q[0]) ** 2)),
        "H": mixed(_one, _one),
    }


def _spherical_operators(separated: R4Separated, hbar: float) -> dict[str, DifferentialOperator]:
    """Return H, the squares of the angular momenta of R^4 and of R^3, and p_nu, of a central body."""
    delta = LAPLACIANS[SPHERICAL.name].terms
    V = separated.body.potential

    def angular(rows: tuple[int, ...], lever: Coefficient) -> DifferentialOperator:
        terms = {k: c for k, c in delta.items() if k and set(k) <= set(rows)}
        return DifferentialOperator(SPHERICAL, terms).scaled(lambda q: -(hbar**2) * lever(q))

    kinetic = LAPLACIANS[SPHERICAL.name].scaled(-(hbar**2) / (2 * separated.mu))
    return {
        "H": kinetic.plus(DifferentialOperator(SPHERICAL, {(): lambda q: V.value(q[0] ** 2)})),
        "L_4^2": angular((1, 2, 3), lambda q: q[0] ** 2),
        "L_3^2": angular((2, 3), lambda q: (q[0] * np.sin(q[1])) ** 2),
        "p_nu": DifferentialOperator(SPHERICAL, {(3,): lambda q: -1j * hbar}),
    }


def spin(
    function: Callable[[np.ndarray], np.ndarray], phi: ArrayLike, *, hbar: float = 1.0, step: float = 0.02
) -> np.ndarray:
    """Apply p_phi = (hbar/i) d/dphi, the generator of rotations of space, to a function of matrices.

    function(phi) of phi (2, 2, ...); phi: where; hbar, step > 0.  Returns (...), complex. Raises ValueError or
    TypeError for wrong input.
    Formula: differences of order 8 of function(O(x) phi).  Source: Martens & Slawianowski, section 5.
    """
    return _generator(function, phi, hbar, step, lambda O, F: np.einsum("ijk,jl...->ilk...", O, F))


def vorticity(
    function: Callable[[np.ndarray], np.ndarray], phi: ArrayLike, *, hbar: float = 1.0, step: float = 0.02
) -> np.ndarray:
    """Apply p_psi = (hbar/i) d/dpsi, the generator of rotations of the material, to a function of matrices.

    Parameters, returns, raises as `spin`: function, phi, hbar, step.
    Formula: differences of order 8 of function(phi O(x)^T).  Source: Martens & Slawianowski, section 5.
    """
    return _generator(function, phi, hbar, step, lambda O, F: np.einsum("ij...,ljk->ilk...", F, O))


def _generator(function: Callable, phi: ArrayLike, hbar: float, step: float, turn: Callable) -> np.ndarray:
    matrices = checked("phi", phi, (2, 2))
    h = positive("step", step)
    x = h * OFFSETS
    rotations = np.array([[np.cos(x), -np.sin(x)], [np.sin(x), np.cos(x)]])
    return -1j * positive("hbar", hbar) / h * np.tensordot(FIRST, function(turn(rotations, matrices)), axes=1)
