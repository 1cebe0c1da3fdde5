"""Complete lists of bodies that bind few levels, against bases of oscillators."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import eval_genlaguerre, gammaln, roots_laguerre

from fastaff import Body, SeparableAlphaBeta, SeparableRVartheta
from fastaff.quantum import NoGroundState, all_levels
from fastaff.systems.models.functions import Zero

SIZE, NODES = 44, 160


class Line(NamedTuple):
    """-h exp(-(q/w)^power) of one variable."""

    h: float
    w: float
    power: float

    def value(self, q):
        return -self.h * np.exp(-((q / self.w) ** self.power))

    def slope(self, q):
        return -self.value(q) * self.power * q ** (self.power - 1) / self.w**self.power


class Bell(NamedTuple):
    """-h exp(-alpha^2/v^2 - beta^2/w^2), which separates in no chart but where v = w."""

    h: float
    v: float
    w: float

    def value(self, A, B):
        return -self.h * np.exp(-A / self.v**2 - B / self.w**2)

    def slopes(self, A, B):
        return -self.value(A, B) / self.v**2, -self.value(A, B) / self.w**2

    def margin(self, A, B):
        return np.ones_like(A * B)


def kinetic_and_bell(s, unit, scale, width, size=SIZE):
    """Return -unit (d^2/dx^2 - (s^2 - 1/4)/x^2) and exp(-x^2/width^2) in functions of oscillators.

    x^(s + 1/2) exp(-t/2) L_n^s(t), t = (x/scale)^2.
    """
    n = np.arange(size)
    kinetic = np.diag(2 * n + s + 1.0)
    beside = np.sqrt((n[1:]) * (n[1:] + s))
    kinetic += np.diag(beside, 1) + np.diag(beside, -1)
    # <exp(-c t)> with t' = (1 + c) t: a polynomial, exact by Gauss-Laguerre quadrature of the weight t^s e^-t.
    c = (scale / width) ** 2
    t, w = roots_laguerre(NODES)
    with np.errstate(under="ignore"):
        norm = np.exp((gammaln(n + 1) - gammaln(n + s + 1)) / 2)[:, None]
        table = norm * np.array([eval_genlaguerre(k, s, t / (1 + c)) for k in n]) * (t / (1 + c)) ** (s / 2)
        bell = (table * (w / (1 + c))) @ table.T
    return unit / scale**2 * kinetic, bell


def isotropic_truth(h, width, unit, below):
    """Levels of -h exp(-rho^2/width^2), J of four dimensions (J + 1)^2 times."""
    E = []
    for J in range(40):
        T, G = kinetic_and_bell(J + 1, unit, width, width, 80)
        found = eigh(T - h * G, eigvals_only=True)
        found = found[found < below]
        if not found.size:
            break
        E += list(np.repeat(found, (J + 1) ** 2))
    return np.sort(E)


def classes(solve, below):
    """Levels of all classes: a, b whole, each sign of both."""
    E = []
    for a in range(30):
        for b in range(30):
            found = solve(a, b)
            found = found[found < below]
            if not found.size:
                break
            E += list(np.repeat(found, (1 + (a > 0)) * (1 + (b > 0))))
        if b == 0:
            break
    return np.sort(E)


def drawn(rng):
    """A width, hbar, mu, and hbar^2/2 mu."""
    width, hbar, mu = 10 ** rng.uniform(-1, 1), rng.uniform(0.5, 1.0), rng.uniform(0.6, 2.0)
    return width, hbar, mu, hbar**2 / (2 * mu)


def agree(found, truth, below, doubt=1e-8):
    """Assert that the list is complete and its errors cover, up to the relative doubt of the truth."""
    assert len(found) == truth.size
    assert found.complete_below == below
    gap = np.abs(found.E - truth)
    assert np.all(gap <= found.error + doubt * np.abs(truth)), (gap.max(), found.error.max())


@pytest.mark.parametrize("seed", [*range(1, 12), 0])  # the last takes five times as long
def test_bells_of_rho(seed):
    rng = np.random.default_rng([71, seed])
    width, hbar, mu, unit = drawn(rng)
    depth = unit / width**2 * rng.uniform(6, 60)
    below = -depth * rng.uniform(0.04, 0.3)
    body = Body(SeparableRVartheta(Line(depth, width**2, 1.0), Zero()), mu)
    truth = isotropic_truth(depth, width, unit, below)
    agree(all_levels(body, max_energy=below, hbar=hbar), truth, below)


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 7, 0, 6])  # the last two take three to ten times as long
def test_bells_of_alpha_and_of_beta(seed):
    """-g exp(-alpha^2/v^2) - h exp(-beta^2/w^2): the continuum begins at the lower ground state of one side."""
    rng = np.random.default_rng([72, seed])
    v, hbar, mu, unit = drawn(rng)
    w = v * rng.uniform(0.5, 2)
    g, h = unit / v**2 * rng.uniform(4, 40), unit / w**2 * rng.uniform(4, 40)

    def side(depth, width, quantum):
        T, G = kinetic_and_bell(quantum, unit, width, width, 80)
        return eigh(T - depth * G, eigvals_only=True)

    E = side(g, v, 0)[0], side(h, w, 0)[0]
    end = min(E)
    below = end + rng.uniform(0.2, 0.9) * max(E)
    body = Body(SeparableAlphaBeta(Line(g, v, 2.0), Line(h, w, 2.0)), mu)
    truth = classes(lambda a, b: np.add.outer(side(g, v, a), side(h, w, b)).ravel(), below)
    agree(all_levels(body, max_energy=below, hbar=hbar), truth, below)
    with pytest.raises(NoGroundState):
        all_levels(body, max_energy=0.98 * end, hbar=hbar)


@pytest.mark.parametrize("seed", [0, 1, 2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 8))])
def test_bells_that_do_not_separate(seed):
    rng = np.random.default_rng([73, seed])
    v, hbar, mu, unit = drawn(rng)
    w = v * rng.uniform(0.6, 1.7)
    h = unit / (v * w) * rng.uniform(12, 45)
    below = -h * rng.uniform(0.15, 0.4)

    def solve(a, b):
        (T, G), (S, F) = kinetic_and_bell(a, unit, v, v, 36), kinetic_and_bell(b, unit, w, w, 36)
        H = np.kron(T, np.eye(36)) + np.kron(np.eye(36), S) - h * np.kron(G, F)
        return eigh(H, eigvals_only=True, subset_by_value=(-h, below))

    body = Body(Bell(h, v, w), mu)
    agree(all_levels(body, max_energy=below, hbar=hbar, tolerance=1e-6), classes(solve, below), below, 1e-7)
    with pytest.raises(NoGroundState):
        all_levels(body, max_energy=0.01 * h, hbar=hbar)
