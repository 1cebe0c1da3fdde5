"""The operators of the quantized body: as differential operators applied to functions, and as matrices in exact bases.

Differential operators are data, coefficients of derivatives in a chart, applied by central differences of order 8 to
any function of the coordinates: to check states, closed-form or numerical, against something that knows nothing of how
they were made.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.tori.separation import separate
from ..base.arrays import checked
from ..base.numbers import fits, positive, whole
from ..charts import ALPHA_BETA, ALPHA_BETA_PHI_PSI, CARTESIAN, EULER, R_VARTHETA, Chart
from .exact_levels import SolvableBody, solvable
from .factors import quantum_number
from .symmetry import checked_class

Coefficient = Callable[[np.ndarray], Any]

FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
OFFSETS = np.arange(-4, 5)


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
        points, h = checked("q", q, (4,)), positive("step", step)
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
)
LAPLACIANS = {chart.name: DifferentialOperator(chart, terms) for chart, terms in _DELTA}
"""The Laplace-Beltrami operator by the name of the chart. In EULER (Psi = -2 psi, cross term +2 cos(Theta) dPhi dPsi of
the metric) the mixed derivative has -2 cos(Theta); with Psi = +2 psi it is the +2 cos(Theta) of section 5, printed
there as 2 cot(Theta)."""


def laplacian(chart: Chart = ALPHA_BETA) -> DifferentialOperator:
    """Return the Laplace-Beltrami operator of GL(2,R) = R^4 in a chart.

    chart: CARTESIAN, ALPHA_BETA, ALPHA_BETA_PHI_PSI, R_VARTHETA or EULER.  Raises ValueError for others.
    Source: Martens & Slawianowski, section 5, the forms of Delta (2 cos(Theta) in the last, printed 2 cot(Theta)).
    """
    if getattr(chart, "name", None) not in LAPLACIANS:
        raise ValueError(f"chart must be one of {', '.join(LAPLACIANS)}, got {getattr(chart, 'name', chart)!r}")
    return LAPLACIANS[chart.name]


def hamiltonian_operator(body: Any, chart: Chart = ALPHA_BETA, *, hbar: float = 1.0) -> DifferentialOperator:
    """Return H = -(hbar^2/2 mu) Delta + V of a Body, separable or not, in a chart that `laplacian` takes.

    Raises ValueError or TypeError for wrong input.  Source: Martens & Slawianowski, section 5 (hbar^2, printed hbar).
    """
    quantum = positive("hbar", hbar)

    def potential(q: np.ndarray) -> np.ndarray:
        return body.potential_energy(*chart.points_to_planes(q))

    kinetic = laplacian(chart).scaled(-(quantum**2) / (2 * positive("mu of the body", body.mu)))
    return kinetic.plus(DifferentialOperator(chart, {(): potential}))


def constant_operators(body: Any, chart: Chart = ALPHA_BETA, *, hbar: float = 1.0) -> dict[str, DifferentialOperator]:
    """Return the operators that a separable body's chart comes with, by name.

    body: separable in `chart`; ALPHA_BETA: H_alpha, H_beta, p_phi, p_psi, which commute; R_VARTHETA: h_vartheta, H,
    p_phi, p_psi, which commute, and H_r, which does not; hbar > 0.  Returns a dict. Raises ValueError or TypeError for
    wrong input. Formulas: H_alpha = ((p_phi - p_psi)^2/(4 alpha^2) - hbar^2 (d^2 + d/alpha))/(2 mu) + V_alpha;
    h_vartheta = (p_phi^2 + 2 cos p_phi p_psi + p_psi^2)/(2 mu sin^2) - (2 hbar^2/mu) (d^2 + cot d) + V_vartheta; H =
    H_r + h_vartheta/r. Source: Martens & Slawianowski, section 5 (4 alpha^2, 4 beta^2 in H_alpha, H_beta, printed
    alpha^2, beta^2).
    """
    quantum, separated = positive("hbar", hbar), separate(body, chart)
    if not separated.isotropic or separated.family.code > 1:
        raise ValueError(
            f"chart must be alpha-beta or r-vartheta, and the body isotropic; got {separated.family.chart!r}"
        )
    (V_first, V_second), half = separated.functions, quantum**2 / (2 * separated.mu)
    delta = LAPLACIANS[separated.family.chart].terms
    if separated.family.code == 0:
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


def spin(
    function: Callable[[np.ndarray], np.ndarray], phi: ArrayLike, *, hbar: float = 1.0, step: float = 0.02
) -> np.ndarray:
    """Apply p_phi = (hbar/i) d/dphi, the generator of rotations of space, to a function of matrices.

    function(phi) of phi (2, 2, ...); phi: where; hbar, step > 0.  Returns (...), complex. Raises ValueError or
    TypeError for wrong input. Formula: differences of order 8 of function(O(x) phi).  Source: Martens & Slawianowski,
    section 5.
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
    matrices, h = checked("phi", phi, (2, 2)), positive("step", step)
    x = h * OFFSETS
    rotations = np.array([[np.cos(x), -np.sin(x)], [np.sin(x), np.cos(x)]])
    return -1j * positive("hbar", hbar) / h * np.tensordot(FIRST, function(turn(rotations, matrices)), axes=1)


@dataclass(frozen=True)
class Matrices:
    """Matrices (states, states) of H and its constants of motion in an exact basis, all Hermitian; commute[A, B] to
    rounding.

    basis (labels, states): quantum numbers of the basis, rows as `labels`. K, L: the constants of the elliptic chart
    with focus sqrt2, H = K + L, K = H_alpha + h_vartheta/2 - k/4.
    """

    labels: tuple[str, ...]
    basis: np.ndarray
    H_alpha: np.ndarray
    H_beta: np.ndarray
    h_vartheta: np.ndarray
    k: float
    p_phi: np.ndarray
    p_psi: np.ndarray

    @property
    def H(self) -> np.ndarray:
        """H = H_alpha + H_beta."""
        return self.H_alpha + self.H_beta

    @property
    def K(self) -> np.ndarray:
        """(h_kappa cos^2 lambda + h_lambda cosh^2 kappa)/(2 (cosh^2 kappa - cos^2 lambda)), no ordering to choose:
        factors commute.
        """
        return self.H_alpha + self.h_vartheta / 2 - self.k / 4 * np.eye(len(self.H_alpha))

    @property
    def L(self) -> np.ndarray:
        """H - K."""
        return self.H - self.K


def class_matrices(
    body: Any, *, m: int, l: int, shells: int, hbar: float = 1.0, single_valued: bool = True
) -> Matrices:
    """Build H, H_alpha, H_beta, h_vartheta, K, L of one class (m, l) in the product basis f_alpha f_beta of the lowest
    shells.

    body: Harmonic, Anharmonic or another oscillator with walls, k alike in both planes; m, l as in `wavefunction`;
    shells >= 1: n_alpha + n_beta < shells; hbar > 0; single_valued as in `wavefunction`. Returns Matrices of (shells
    (shells + 1)/2)^2 entries, no truncation error: all of them keep n_alpha + n_beta. Raises ValueError or TypeError
    for wrong input. Formula: both planes are representations of su(1,1) with Bargmann indices (1 + s)/2, K_0 = n + (1 +
    s)/2, and h_vartheta = (2 hbar^2/mu) times the Casimir operator of their sum: tridiagonal in n_alpha, with
    eigenvalues e_vartheta. Source: Martens & Slawianowski, EQ2.2f and section 3 (K, L); the matrices are derived.
    """
    symmetry, model = checked_class(m, l, single_valued), solvable(body, ALPHA_BETA, hbar)
    if model.k[0] != model.k[1]:
        raise ValueError(f"body must have the same k in both planes, got {model.k}")
    shells = whole("shells", shells, 1)
    fits("shells", 8, shells * (shells + 1) // 2, shells * (shells + 1) // 2)
    n = np.array([(a, N - a) for N in range(shells) for a in range(N + 1)]).T
    s_alpha, s_beta = (float(s) for s in model.indices(*symmetry))
    first, second = (n[i] + (1 + s) / 2 for i, s in enumerate((s_alpha, s_beta)))  # eigenvalues of K_0
    casimirs = (s_alpha**2 - 1) / 4 + (s_beta**2 - 1) / 4
    h = np.diag(4 * (casimirs + 2 * first * second))
    same = (n[0, 1:] == n[0, :-1] + 1) & (n.sum(0)[1:] == n.sum(0)[:-1])
    a, b = n[0, :-1] + 1.0, n[1, :-1]
    coupling = -4 * np.sqrt(a * (a + s_alpha) * b * (b + s_beta)) * same
    h += np.diag(coupling, 1) + np.diag(coupling, -1)
    unit, half = np.eye(n.shape[1]), model.hbar**2 / (2 * model.mu)
    E = model.constants(n, *symmetry)
    return Matrices(
        ("n_alpha", "n_beta"),
        n,
        np.diag(E[0]),
        np.diag(E[1]),
        half * h,
        model.k[0],
        model.hbar * symmetry.m * unit,
        model.hbar * symmetry.l * unit,
    )


def oscillator_matrices(body: Any, *, quanta: int, hbar: float = 1.0) -> Matrices:
    """Build H, H_alpha, H_beta, h_vartheta, K, L, p_phi, p_psi of the harmonic body in the Cartesian number basis of
    R^4.

    body: Body(Harmonic(C), mu); quanta >= 0: all states n1 + n2 + n3 + n4 <= quanta of a1, a2, b1, b2, C(quanta + 4, 4)
    of them; hbar > 0. Returns Matrices (complex), without truncation error: each is made of a_i^+ a_j, which keep the
    number of quanta. Raises ValueError or TypeError for wrong input. Formula: q_i p_j - q_j p_i = i hbar (a_j^+ a_i -
    a_i^+ a_j); h_vartheta = sum over i < j of their squares/(2 mu). Source: Martens & Slawianowski, EQ3.1 and EQ2.1b;
    the matrices are derived.
    """
    model = solvable(body, ALPHA_BETA, hbar)
    if model.k[0] != model.k[1] or any(model.walls):
        raise ValueError(f"body must be harmonic, without walls; got {type(body.potential).__name__}")
    top = whole("quanta", quanta, 0)
    fits("quanta", 32, math.comb(top + 4, 4), math.comb(top + 4, 4))
    states = sorted((n for n in product(range(top + 1), repeat=4) if sum(n) <= top), key=lambda n: (sum(n), n))
    place, size = {n: i for i, n in enumerate(states)}, len(states)

    def hop(i: int, j: int) -> np.ndarray:
        """a_i^+ a_j."""
        matrix = np.zeros((size, size))
        for column, n in enumerate(states):
            if n[j]:
                moved = list(n)
                weight = moved[j]
                moved[j] -= 1
                moved[i] += 1
                matrix[place[tuple(moved)], column] = np.sqrt(weight * moved[i])
        return matrix

    turns = {(i, j): 1j * model.hbar * (hop(j, i) - hop(i, j)) for i in range(4) for j in range(i + 1, 4)}
    numbers, quantum = [np.array([float(n[i]) for n in states]) for i in range(4)], float(model.quanta[0])
    h = sum((turn @ turn for turn in turns.values()), np.zeros((size, size))) / (2 * model.mu)
    planes = [np.diag(quantum * (numbers[2 * i] + numbers[2 * i + 1] + 1)) for i in range(2)]
    p_eta, p_gamma = turns[0, 1], turns[2, 3]
    labels = ("n_a1", "n_a2", "n_b1", "n_b2")
    return Matrices(labels, np.array(states).T, planes[0], planes[1], h, model.k[0], p_gamma + p_eta, p_gamma - p_eta)


class RadialMatrices(NamedTuple):
    """Matrices (size, size) in the basis f_r of one n_vartheta: H, and its two contributions H_r and h_vartheta/r."""

    H: np.ndarray
    H_r: np.ndarray
    h_over_r: np.ndarray


def radial_matrices(
    body: Any, *, m: int, l: int, n_vartheta: int, size: int, hbar: float = 1.0, single_valued: bool = True
) -> RadialMatrices:
    """Build H, H_r and h_vartheta/r between the states n_r < size of one n_vartheta: the last two are no constants of
    motion.

    body: one solvable in R_VARTHETA; m, l, single_valued as in `wavefunction`; n_vartheta >= 0; size >= 1; hbar > 0.
    Returns RadialMatrices: H is diagonal, so [H, H_r] of the whole operator is seen entry by entry, (E_i - E_j)
    (H_r)_ij. Raises ValueError or TypeError for wrong input. Formula: <n|1/r|n'> = (kappa/s) sqrt(prod of k/(k + s), k
    from the smaller n + 1 to the larger), s = 2 epsilon. Source: Martens & Slawianowski, the warning of section 5; the
    matrix elements are derived.
    """
    symmetry, model = checked_class(m, l, single_valued), solvable(body, R_VARTHETA, hbar)
    fits("size", 8, whole("size", size, 1), size)
    n_v, states = quantum_number("n_vartheta", n_vartheta), np.arange(size)
    E, e = model.constants(np.array([states, np.full_like(states, n_v)]), *symmetry)
    h_over_r = e[0] * inverse_r(model, n_v, symmetry, states.size)
    return RadialMatrices(np.diag(E), np.diag(E) - h_over_r, h_over_r)


def inverse_r(model: SolvableBody, n_vartheta: int, symmetry: tuple[int, int], size: int) -> np.ndarray:
    """Return <n|1/r|n'> (size, size) between states f_r of one n_vartheta."""
    s, k = float(model.radial_index(n_vartheta, *symmetry)), np.arange(1, size)
    ladder = np.concatenate([[0.0], np.cumsum(np.log(k / (k + s)))]) / 2
    larger, smaller = (
        np.maximum.outer(np.arange(size), np.arange(size)),
        np.minimum.outer(np.arange(size), np.arange(size)),
    )
    return model.kappa[0] / s * np.exp(ladder[larger] - ladder[smaller])
