"""Levels of many classes of a separable body: sums of levels of alpha and beta, or levels of r over those of vartheta.

A class is a pair of centres, K_alpha/alpha^2 + K_beta/beta^2 times hbar^2/2 mu: K = a^2, b^2 of the quantum numbers m
and l, or the levels of eta and gamma where these have potentials.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...systems.charts import ALPHA_BETA, R_VARTHETA, Chart
from ...tori.families import ALPHA_BETA_FAMILY, ELLIPTIC_FAMILY, R_VARTHETA_FAMILY, Family
from ..solvers.elliptic import elliptic_levels
from ..solvers.factor_tables import Factors, FactorTable
from ..solvers.separable import angular, radial
from ..solvers.singular_ends import radii, sampled
from ..states.level_table import Waves
from ..states.state import Product

SIDES = ("V_alpha", "V_beta")
NEAR = (1e-2, 1e-4, 1e-6)
"""Distances below the limit of a potential up to which its ground state is searched, in units of its depth."""
CLOSE = 1e-3
"""Step of a centre, relative to it, by which the slope of levels is measured."""
MOST_TIMES = 1e6
"""The same, in units of the centre's error, at most."""
SAFE = 2.0
"""Errors of levels in units of the first order: their slopes are those above the centre, and larger below."""


class Centres(NamedTuple):
    """The centres of classes and their errors (classes, 2)."""

    K: np.ndarray
    error: np.ndarray


@dataclass(frozen=True, repr=False)
class ProductWaves:
    """Products of factors: those of the second coordinate are solutions of one problem, rows[1] of `second`; those of
    the first of problem rows[0] + step*n of `first`, n the quantum number of the second.
    """

    chart: Chart
    first: FactorTable
    second: FactorTable
    rows: tuple[int, int]
    step: int

    def __repr__(self) -> str:
        return f"products of factors in {self.chart.name}"

    def shape(self, n: Sequence[int]) -> Product:
        """Return the shape of the state with quantum numbers n (2,)."""
        first = self.first(self.rows[0] + self.step * n[1], n[0])
        return Product(self.chart, (first, self.second(self.rows[1], n[1])))


class SolvedClass(NamedTuple):
    """Levels of one class: E, error (levels,), n, constants (2, levels), wave functions and the size of the basis."""

    E: np.ndarray
    error: np.ndarray
    n: np.ndarray
    constants: np.ndarray
    waves: Waves
    size: int
    said: str


def _alpha_beta(
    separated: Any, centres: Centres, levels: int, hbar: float, tolerance: float, limit: float
) -> list[SolvedClass]:
    """Sums E_alpha + E_beta of every pair of centres."""
    V_alpha, V_beta = separated.functions
    pairs = centres.K
    limits = _limits(separated, np.minimum(pairs.min(axis=0), 0.0), hbar, limit)
    count = min(levels, int(np.sqrt(2 * levels)) + 4)
    while True:
        sides = []
        for side, (name, V, below) in enumerate(zip(SIDES, (V_alpha, V_beta), limits, strict=True)):
            K, at, where = np.unique(pairs[:, side], return_index=True, return_inverse=True)

            def solve(K, name=name, V=V, below=below, count=count):
                return radial(name, V, 2, K, count, hbar, separated.mu, tolerance, limit=below)

            found = solve(K)
            sides.append((_with_error_of_centres(solve, found, K[:, None], centres.error[at, side][:, None]), where))
        (first, i), (second, j) = sides
        sums = first.values[i][:, :, None] + second.values[j][:, None, :]
        errors = first.error[i][:, :, None] + second.error[j][:, None, :]
        top = np.sort(sums.reshape(len(pairs), -1), axis=1)[:, min(levels, count * count) - 1]
        if count == levels or (count * count >= levels and np.all(top < np.minimum(sums[:, -1, 0], sums[:, 0, -1]))):
            break
        count = min(levels, 2 * count)
    found = []
    for p in range(len(pairs)):
        E, error, n = _merged(sums[p], errors[p], levels)
        constants = np.array([first.values[i[p], n[0]], second.values[j[p], n[1]]])
        waves = ProductWaves(ALPHA_BETA, first.functions, second.functions, (int(i[p]), int(j[p])), 0)
        found.append(
            SolvedClass(E, error, n, constants, waves, max(first.size, second.size), first.said or second.said)
        )
    return found


def _with_error_of_centres(solve: Callable, found: Factors, K: np.ndarray, error: np.ndarray) -> Factors:
    """Return the solutions with the errors (problems, sides) of the centres K in those of their values.

    The values of K + step are compared, the step a multiple of the error well above rounding, and below K: values grow
    as the root of a small K.
    """
    if not error.any():
        return found
    largest = np.maximum(error.max(axis=1, keepdims=True), 1e-300)
    times = np.clip(CLOSE * np.abs(K).min(axis=1, keepdims=True) / largest, 1.0, MOST_TIMES)
    moved = solve((K + times * error)[:, 0] if K.shape[1] == 1 else K + times * error)
    return found._replace(error=found.error + SAFE * np.abs(moved.values - found.values) / times)


def _limits(separated: Any, attracting: np.ndarray, hbar: float, limit: float) -> list[float]:
    """Return upper bounds of the energies of alpha and of beta if their sum is below `limit`.

    Each is the limit less the ground state of the other side, or less a lower bound of it. attracting: the lowest
    centre of each side that attracts, or 0 (2,).
    """
    if np.isinf(limit):
        return [limit, limit]
    y = radii(0.0, np.inf)
    unit = hbar**2 / (2 * separated.mu)
    sides = [sampled(V.value, y) + unit * K / y**2 for V, K in zip(separated.functions, attracting, strict=True)]
    low = [float(values.min()) for values in sides]
    for i, (name, V) in enumerate(zip(SIDES, separated.functions, strict=True)):
        bottom = low[i]
        threshold = float(sides[i][-1])
        for near in NEAR:
            top = min(limit - low[1 - i], bottom + (1 - near) * (threshold - bottom))
            if top <= low[i]:
                break
            ground = radial(name, V, 2, attracting[i : i + 1], 1, hbar, separated.mu, 1e-6, limit=top)
            low[i] = min(top, float((ground.values - ground.error)[0, 0]))
            if low[i] < top:
                break
    return [limit - low[1], limit - low[0]]


def _r_vartheta(
    separated: Any, centres: Centres, levels: int, hbar: float, tolerance: float, limit: float
) -> list[SolvedClass]:
    """Radial levels over each level of vartheta; e_vartheta of both bases give E of both."""
    V_r, V_vartheta = separated.functions
    mu = separated.mu
    pairs = centres.K
    n_r, n_v = (min(levels, int(factor * np.sqrt(levels)) + 4) for factor in (2.0, 1.0))
    while True:

        def solve(K, n_v=n_v):
            return angular("V_vartheta", V_vartheta, K[:, 0], K[:, 1], n_v, hbar, mu, 0.1 * tolerance)

        e = _with_error_of_centres(solve, solve(pairs), pairs, centres.error)
        radial_mu = separated.radial_mu
        fine, moved = (
            _over(V_r, values, n_r, hbar, radial_mu, tolerance, limit) for values in (e.values, e.values + e.error)
        )
        sums = fine.values.reshape(*e.values.shape, n_r).swapaxes(1, 2)
        errors = (fine.error + np.abs(moved.values - fine.values)).reshape(*e.values.shape, n_r).swapaxes(1, 2)
        errors = errors + (np.inf if e.lost else 0.0)
        top = np.sort(sums.reshape(len(pairs), -1), axis=1)[:, min(levels, n_r * n_v) - 1]
        few_r = n_r < levels and (n_r * n_v < levels or np.any(top >= sums[:, -1, 0]))
        few_v = n_v < levels and (n_r * n_v < levels or np.any(top >= sums[:, 0, -1]))
        if not (few_r or few_v):
            break
        n_r, n_v = (min(levels, int(1.5 * n) + 1) if few else n for n, few in ((n_r, few_r), (n_v, few_v)))
    found = []
    for p in range(len(pairs)):
        E, error, n = _merged(sums[p], errors[p], levels)
        constants = np.array([fine.values[p * n_v + n[1], n[0]], e.values[p, n[1]]])
        waves = ProductWaves(R_VARTHETA, fine.functions, e.functions, (p * n_v, p), 1)
        found.append(SolvedClass(E, error, n, constants, waves, max(e.size, fine.size), e.said or fine.said))
    return found


def _over(V_r: Any, e: np.ndarray, count: int, hbar: float, mu: float, tolerance: float, limit: float) -> Factors:
    """Return the radial levels over every e_vartheta."""
    K = 2 * mu * e.ravel() / hbar**2
    return radial("V_r + e_vartheta/r", V_r, 4, K, count, hbar, mu, tolerance, limit=limit)


def _elliptic(
    separated: Any, centres: Centres, levels: int, hbar: float, tolerance: float, limit: float
) -> list[SolvedClass]:
    """Solve both equations in kappa and lambda with common eigenvalues, one class after another."""
    V_kappa, V_lambda = separated.functions
    return [
        SolvedClass(*elliptic_levels(V_kappa, V_lambda, a, b, levels, hbar, separated.mu, tolerance, limit))
        for a, b in np.sqrt(centres.K).tolist()
    ]


OF_ANGLES: dict[Family, Callable] = {ALPHA_BETA_FAMILY: _alpha_beta, R_VARTHETA_FAMILY: _r_vartheta}
"""Solvers that take any centres, those of angular potentials too."""

SOLVED: dict[Family, Callable] = {**OF_ANGLES, ELLIPTIC_FAMILY: _elliptic}
"""Solvers of bodies without angular potentials."""


def _merged(sums: np.ndarray, errors: np.ndarray, levels: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the lowest values of a table, ascending, their errors, and their indices (2, levels)."""
    order = np.argsort(sums, axis=None, kind="stable")[:levels]
    n = np.stack(np.unravel_index(order, sums.shape))
    E = sums.ravel()[order]
    return E, errors.ravel()[order] + 16 * np.finfo(float).eps * np.abs(E), n
