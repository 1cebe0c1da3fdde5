"""The operators of exactly solvable bodies as matrices in exact bases."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ...core.numbers import fits, whole
from ...systems.charts import ALPHA_BETA, R_VARTHETA
from ..exact.solvable_body import SolvableBody, solvable
from ..states.factors import quantum_number
from ..states.symmetry import checked_class


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
    model: Any, *, m: int, l: int, shells: int, hbar: float = 1.0, single_valued: bool = True
) -> Matrices:
    """Build H, H_alpha, H_beta, h_vartheta, K, L of one class (m, l) in the product basis f_alpha f_beta of the lowest
    shells.

    model: Harmonic, Anharmonic or another oscillator with walls, k alike in both planes; m, l as in `wavefunction`;
    shells >= 1: n_alpha + n_beta < shells; hbar > 0; single_valued as in `wavefunction`. Returns Matrices of (shells
    (shells + 1)/2)^2 entries, no truncation error: all of them keep n_alpha + n_beta. Raises ValueError or TypeError
    for wrong input.
    Formula: both planes are representations of su(1,1) with Bargmann indices (1 + s)/2, K_0 = n + (1 + s)/2, and
    h_vartheta = (2 hbar^2/mu) times the Casimir operator of their sum: tridiagonal in n_alpha, with eigenvalues
    e_vartheta.
    Source: Martens & Slawianowski, EQ2.2f and section 3 (K, L); the matrices are derived.
    """
    symmetry = checked_class(m, l, single_valued)
    solved = solvable(model, ALPHA_BETA, hbar)
    if solved.k[0] != solved.k[1]:
        raise ValueError(f"model must have the same k in both planes, got {solved.k}")
    shells = whole("shells", shells, 1)
    fits("shells", 8, shells * (shells + 1) // 2, shells * (shells + 1) // 2)
    n = np.array([(a, N - a) for N in range(shells) for a in range(N + 1)]).T
    s_alpha, s_beta = (float(s) for s in solved.indices(*symmetry))
    first, second = (n[i] + (1 + s) / 2 for i, s in enumerate((s_alpha, s_beta)))  # eigenvalues of K_0
    casimirs = (s_alpha**2 - 1) / 4 + (s_beta**2 - 1) / 4
    h = np.diag(4 * (casimirs + 2 * first * second))
    same = (n[0, 1:] == n[0, :-1] + 1) & (n.sum(0)[1:] == n.sum(0)[:-1])
    a = n[0, :-1] + 1.0
    b = n[1, :-1]
    coupling = -4 * np.sqrt(a * (a + s_alpha) * b * (b + s_beta)) * same
    h += np.diag(coupling, 1) + np.diag(coupling, -1)
    unit = np.eye(n.shape[1])
    half = solved.hbar**2 / (2 * solved.mu)
    E = solved.constants(n, *symmetry)
    return Matrices(
        labels=("n_alpha", "n_beta"),
        basis=n,
        H_alpha=np.diag(E[0]),
        H_beta=np.diag(E[1]),
        h_vartheta=half * h,
        k=solved.k[0],
        p_phi=solved.hbar * symmetry.m * unit,
        p_psi=solved.hbar * symmetry.l * unit,
    )


def oscillator_matrices(model: Any, *, quanta: int, hbar: float = 1.0) -> Matrices:
    """Build H, H_alpha, H_beta, h_vartheta, K, L, p_phi, p_psi of the harmonic body in the Cartesian number basis of
    R^4.

    model: Body(Harmonic(C), mu); quanta >= 0: all states n1 + n2 + n3 + n4 <= quanta of a1, a2, b1, b2, C(quanta + 4,
    4) of them; hbar > 0. Returns Matrices (complex), without truncation error: each is made of a_i^+ a_j, which keep
    the number of quanta. Raises ValueError or TypeError for wrong input.
    Formula: q_i p_j - q_j p_i = i hbar (a_j^+ a_i - a_i^+ a_j); h_vartheta = sum over i < j of their squares/(2 mu).
    Source: Martens & Slawianowski, EQ3.1 and EQ2.1b; the matrices are derived.
    """
    solved = solvable(model, ALPHA_BETA, hbar)
    if solved.k[0] != solved.k[1] or any(solved.walls):
        raise ValueError(f"model must be harmonic, without walls; got {type(model.potential).__name__}")
    top = whole("quanta", quanta, 0)
    fits("quanta", 32, math.comb(top + 4, 4), math.comb(top + 4, 4))
    states = sorted((n for n in product(range(top + 1), repeat=4) if sum(n) <= top), key=lambda n: (sum(n), n))
    place = {n: i for i, n in enumerate(states)}
    size = len(states)

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

    turns = {(i, j): 1j * solved.hbar * (hop(j, i) - hop(i, j)) for i in range(4) for j in range(i + 1, 4)}
    numbers = [np.array([float(n[i]) for n in states]) for i in range(4)]
    quantum = float(solved.quanta[0])
    h = sum((turn @ turn for turn in turns.values()), np.zeros((size, size))) / (2 * solved.mu)
    planes = [np.diag(quantum * (numbers[2 * i] + numbers[2 * i + 1] + 1)) for i in range(2)]
    p_eta = turns[0, 1]
    p_gamma = turns[2, 3]
    labels = ("n_a1", "n_a2", "n_b1", "n_b2")
    return Matrices(labels, np.array(states).T, planes[0], planes[1], h, solved.k[0], p_gamma + p_eta, p_gamma - p_eta)


class RadialMatrices(NamedTuple):
    """Matrices (size, size) in the basis f_r of one n_vartheta: H, and its two contributions H_r and h_vartheta/r."""

    H: np.ndarray
    H_r: np.ndarray
    h_over_r: np.ndarray


def radial_matrices(
    model: Any, *, m: int, l: int, n_vartheta: int, size: int, hbar: float = 1.0, single_valued: bool = True
) -> RadialMatrices:
    """Build H, H_r and h_vartheta/r between the states n_r < size of one n_vartheta: the last two are no constants of
    motion.

    model: one solvable in R_VARTHETA; m, l, single_valued as in `wavefunction`; n_vartheta >= 0; size >= 1; hbar > 0.
    Returns RadialMatrices: H is diagonal, so [H, H_r] of the whole operator is seen entry by entry, (E_i - E_j)
    (H_r)_ij. Raises ValueError or TypeError for wrong input.
    Formula: <n|1/r|n'> = (kappa/s) sqrt(prod of k/(k + s), k from the smaller n + 1 to the larger), s = 2 epsilon.
    Source: Martens & Slawianowski, the warning of section 5; the matrix elements are derived.
    """
    symmetry = checked_class(m, l, single_valued)
    solved = solvable(model, R_VARTHETA, hbar)
    fits("size", 8, whole("size", size, 1), size)
    n_v = quantum_number("n_vartheta", n_vartheta)
    states = np.arange(size)
    E, e = solved.constants(np.array([states, np.full_like(states, n_v)]), *symmetry)
    h_over_r = e[0] * inverse_r(solved, n_v, symmetry, states.size)
    return RadialMatrices(np.diag(E), np.diag(E) - h_over_r, h_over_r)


def inverse_r(model: SolvableBody, n_vartheta: int, symmetry: tuple[int, int], size: int) -> np.ndarray:
    """Return <n|1/r|n'> (size, size) between states f_r of one n_vartheta."""
    s = float(model.radial_index(n_vartheta, *symmetry))
    k = np.arange(1, size)
    ladder = np.concatenate([[0.0], np.cumsum(np.log(k / (k + s)))]) / 2
    larger = np.maximum.outer(np.arange(size), np.arange(size))
    smaller = np.minimum.outer(np.arange(size), np.arange(size))
    return model.kappa[0] / s * np.exp(ladder[larger] - ladder[smaller])
