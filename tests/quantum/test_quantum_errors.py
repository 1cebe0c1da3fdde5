"""Errors of levels of bodies drawn at random cover the truth: of every basis, whatever the tolerance."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from own_models import Plain
from scipy.linalg import eigh, eigh_tridiagonal

from fastaff import affine_body
from fastaff.quantum.solvers.nonseparable import plane_levels
from fastaff.quantum.solvers.separable import angular, radial
from fastaff.quantum.states.symmetry import SymmetryClass


def oscillators(m, kappa, n, points):
    """Nodes in q^2, functions (n, points) of an oscillator there times the roots of their weights, and -Delta."""
    k = np.arange(points)
    x, v = eigh_tridiagonal(2 * k + 1 + m, np.sqrt(k[1:] * (k[1:] + m)))
    k = np.arange(n)
    off = np.sqrt(k[1:] * (k[1:] + m))
    return x / kappa, (v * np.sign(v[0]))[:n], kappa * (np.diag(2 * k + 1 + m) - np.diag(off, 1) - np.diag(off, -1))


def in_oscillators(V, a, b, hbar, mu, count, kappa, n=36):
    """Levels of V(alpha^2, beta^2) in products of oscillators of both planes; Rayleigh quotients as sums."""
    (A, F, K), (B, G, L) = (oscillators(m, kappa, n, 60) for m in (a, b))
    W = V(A[:, None], B)
    table = np.einsum("pi,qi,ij->pqj", F, F, W, optimize=True)
    H = np.einsum("pqj,rj,sj->prqs", table, G, G, optimize=True).reshape(n * n, n * n)
    unit = hbar**2 / (2 * mu)
    H += unit * (np.kron(K, np.eye(n)) + np.kron(np.eye(n), L))
    E = np.empty(count)
    for k, c in enumerate(eigh(H, subset_by_index=(0, count - 1))[1].T.reshape(count, n, n)):
        E[k] = (W * (F.T @ c @ G) ** 2).sum() + unit * ((c * (K @ c)).sum() + (c * (c @ L)).sum())
    return E


ISSUE = (1.332, 0.587, 1.0), (1.247, 0.795), (4, 0), 12


def drawn(seed):
    """(k, c, w), (mu, hbar), (m, l), levels."""
    rng = np.random.default_rng(seed)
    m = int(rng.integers(0, 4))
    l = m - 2 * int(rng.integers(0, 3))
    return (
        (rng.uniform(0.3, 1.5), rng.uniform(0.2, 1.3), rng.uniform(0.5, 2)),
        (rng.uniform(0.7, 1.5), rng.uniform(0.5, 1.1)),
        (m, l),
        int(rng.integers(3, 12)),
    )


@pytest.mark.parametrize("case", [ISSUE, *(pytest.param(drawn(s), marks=pytest.mark.slow) for s in range(6))])
def test_every_basis_of_smooth_bodies(case):
    (k, c, w), (mu, hbar), (m, l), count = case
    body = affine_body("k*((D1*D2)**2-c**2)**2/8+w*(D1**2+D2**2)/2", k=k, c=c, w=w)._replace(mu=mu)
    chosen, known = SymmetryClass(m, l), []
    plane_levels(body, chosen, count, hbar, 1e-10, known)

    def V(A, B):
        return k * (((A - B) / 2) ** 2 - c**2) ** 2 / 8 + w * (A + B) / 2

    rows = [in_oscillators(V, chosen.a, chosen.b, hbar, mu, count, scale / hbar) for scale in (2.6, 3.0)]
    truth, doubt = rows[0], 3 * np.abs(rows[0] - rows[1]) + 1e-13 * np.abs(rows[0])
    assert doubt[: (count + 1) // 2].max() < 1e-7
    assert len(known) > 2
    for table in known:
        assert np.all(np.abs(table.E - truth) <= table.error + doubt)


def graded(p, q, measure, lo, hi, both, count, degree=12):
    """Levels of -(p g')' + q g = E measure g, functions of the distances from both ends, on elements graded to them."""
    half = (lo + hi) / 2
    steps = (half - lo) * 0.3 ** np.arange(20, -1, -1.0)
    right = hi - steps[-2::-1] if both else np.linspace(half, hi, 12)[1:]
    edges = np.concatenate([[lo], lo + steps, right, [hi] if both else []])
    edges = np.unique(np.concatenate([edges, np.linspace(lo, hi, 15)]))
    t, w = legendre.leggauss(degree + 8)
    nodes = np.cos(np.pi * np.arange(degree, -1, -1) / degree)
    inverse = np.linalg.inv(legendre.legvander(nodes, degree))
    P = legendre.legvander(t, degree) @ inverse
    D = np.stack([legendre.legval(t, legendre.legder(row)) + 0 * t for row in np.eye(degree + 1)], axis=1) @ inverse
    size = (edges.size - 1) * degree + 1
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for e, h in enumerate(np.diff(edges)):
        at = edges[e] - lo + h * (1 + t) / 2, hi - edges[e + 1] + h * (1 - t) / 2
        some = slice(e * degree, (e + 1) * degree + 1)
        v = w * h / 2
        K[some, some] += (D * 2 / h).T @ ((v * p(*at))[:, None] * D * 2 / h) + P.T @ ((v * q(*at))[:, None] * P)
        M[some, some] += P.T @ ((v * measure(*at))[:, None] * P)
    K, M = K[:-1, :-1], M[:-1, :-1]
    d = 1 / np.sqrt(np.diag(K))
    inverse = eigh(
        M * d[:, None] * d, K * d[:, None] * d, eigvals_only=True, subset_by_index=(len(d) - count, len(d) - 1)
    )
    return 1 / inverse[::-1]


@pytest.mark.parametrize("seed", range(12))
def test_singular_ends_without_an_exponent(seed):
    """V ~ q^-power at 0, and ~ cos^-power at det phi = 0, at two tolerances."""
    rng = np.random.default_rng(seed)
    C, power, a, count = rng.uniform(0.2, 1.5), rng.uniform(0.3, 1.7), int(rng.integers(1, 4)), int(rng.integers(2, 7))

    def V(q):
        return 0.5 * q * q + C * q**-power

    def wall(v):
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(v < np.pi / 2, C * np.cos(v) ** -power, np.inf)

    if seed % 2:
        truth = graded(
            lambda q, y: q ** (1 + 2 * a),
            lambda q, y: 2 * q ** (1 + 2 * a) * V(q),
            lambda q, y: 2 * q ** (1 + 2 * a),
            *(0.0, 11.0, False, count),
        )
    else:

        def measure(x, y):
            return 2 * np.sin(x / 2) ** (2 * a + 1) * np.cos(x / 2)

        low = a / 2 * (a / 2 + 1)
        truth = 2 * graded(
            measure,
            lambda x, y: measure(x, y) * (low + C * np.sin(y) ** -power / 2),
            measure,
            *(0.0, np.pi / 2, True, count),
        )
    for tolerance in (1e-4, 1e-6):
        found = (
            radial("V", Plain(V), 2, np.array([float(a * a)]), count, 1.0, 1.0, tolerance)
            if seed % 2
            else angular("V", Plain(wall), np.zeros(1), np.array([a**2]), count, 1.0, 1.0, tolerance)
        )
        assert np.all(np.abs(found.values[0] - truth) <= found.error[0] + 1e-9 * truth)
