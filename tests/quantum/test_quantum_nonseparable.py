"""Spectra of bodies that do not separate: against separable ones solved as if they did not, and an independent plain
basis.
"""

import numpy as np
import pytest

from fastaff import Anharmonic, Body, Harmonic, Hyperelastic, NeoHookean, affine_body, univariate
from fastaff.quantum.solvers.nonseparable import plane_levels
from fastaff.quantum.solvers.separable import radial
from fastaff.quantum.solvers.singular_ends import NoGroundState
from fastaff.quantum.spectra.spectrum import spectrum
from fastaff.quantum.states.symmetry import SymmetryClass
from fastaff.systems.charts import ALPHA_BETA


@pytest.mark.parametrize(
    "potential", [Harmonic(1.4), Anharmonic(0.6), Hyperelastic(0.8)], ids=lambda p: type(p).__name__
)
@pytest.mark.parametrize(("m", "l"), [(0, 0), (1, -1), (3, 1), (2, 4)])
def test_separable_bodies_as_if_they_were_not(potential, m, l):
    body = Body(potential, 1.3)
    found = plane_levels(body, SymmetryClass(m, l), 60, 0.6, 1e-10)
    truth = spectrum(body, m=m, l=l, count=60, hbar=0.6).E
    np.testing.assert_allclose(found.E, truth, rtol=1e-10)
    assert np.all(np.abs(found.E - truth) <= 3 * found.error)
    assert found.converged.all()
    assert not found.separated


def plain_levels(potential, a, b, hbar, n, k, scale):
    """Lowest levels in products r^i-Laguerre x P_j(2 x - 1), by Gauss quadrature and the generalised eigenproblem:
    upper bounds.
    """
    from numpy.polynomial import laguerre, legendre
    from scipy.linalg import eigh

    t, w = laguerre.laggauss(90)
    r = t / scale
    L = laguerre.lagvander(t, n - 1)
    dL = np.stack([laguerre.lagval(t, laguerre.lagder(np.eye(n)[i])) if i else 0 * t for i in range(n)], axis=1)
    R, dR = L, scale * (dL - L / 2)  # e^(-t/2) goes into the weights
    y, v = legendre.leggauss(100)
    x, v = ((y + 1) / 2) ** 2, v * (y + 1) / 2  # x = s^2: nodes crowd at the wall
    P = legendre.legvander(2 * x - 1, k - 1)
    dP = np.stack(
        [2 * legendre.legval(2 * x - 1, legendre.legder(np.eye(k)[j])) if j else 0 * x for j in range(k)], axis=1
    )
    side = (1 - x) ** (b / 2) * (1 + x) ** (a / 2)
    X = (side * x)[:, None] * P
    slope = side * (1 + x * (a / 2 / (1 + x) - b / 2 / (1 - x)))
    dX = slope[:, None] * P + (side * x)[:, None] * dP

    def gram(f, g, weight):
        return (f * weight[:, None]).T @ g

    wr = w / scale
    X2, K = (
        gram(X, X, v),
        gram(dX, dX, v * (1 - x**2)) + gram(X, X, v * (b * b / (2 * (1 - x)) + a * a / (2 * (1 + x)))),
    )
    V = potential.value(np.outer(r, 1 + x) / 2, np.outer(r, 1 - x) / 2)
    potential_part = np.einsum("pi,pj,pq,qk,ql->ikjl", R, R, V * np.outer(wr * r, v), X, X, optimize=True).reshape(
        n * k, n * k
    )
    H = hbar**2 / 2 * 4 * (np.kron(gram(dR, dR, wr * r * r), X2) + np.kron(gram(R, R, wr), K)) + potential_part
    return eigh(H, np.kron(gram(R, R, wr * r), X2), eigvals_only=True)


@pytest.mark.parametrize(("m", "l"), [(0, 0), (2, 0), (1, -1)])
def test_neo_hookean_in_a_plain_basis(m, l):
    potential, c = NeoHookean(1.0, 2.0), SymmetryClass(m, l)
    found = spectrum(Body(potential), m=m, l=l, count=6, tolerance=1e-9)
    plain = [plain_levels(potential, c.a, c.b, 1.0, n, n, 2.0)[:6] for n in (12, 18)]
    bound = plain[1] - found.E
    assert np.all(bound > -1e-9 * found.E)  # Rayleigh-Ritz: above the levels
    assert np.all(np.abs(bound) <= 3e-6 * found.E)
    assert np.all(plain[1] <= plain[0] + 1e-10)
    assert found.converged.all()


def test_states_are_orthonormal_and_vanish_at_the_wall():
    found = spectrum(Body(NeoHookean(1.0, 2.0)), m=2, l=0, count=8, hbar=0.5, tolerance=1e-9)
    t, w = np.polynomial.legendre.leggauss(90)
    q, s = 4 * (1 + t), (1 + t) / 2
    v = np.arccos(s**2)
    Q, ANGLE = np.meshgrid(q, v, indexing="ij")
    weight = np.outer(4 * w * q**3, w / 2 * 2 * s) / 4  # alpha beta dalpha dbeta = rho^3 drho dx/4
    f = np.array(
        [
            2 * np.pi * found.state(k).amplitude(Q * np.cos(ANGLE / 2), Q * np.sin(ANGLE / 2), ALPHA_BETA)
            for k in range(8)
        ]
    )
    assert np.einsum("kij,lij,ij->kl", f, f, weight) == pytest.approx(np.eye(8), abs=1e-9)
    assert np.all(np.abs(found.state(0).amplitude([1.0, 0.5, 0.0], [1.0, 1.5, 0.0], ALPHA_BETA)) <= [1e-15, 0, 0])
    for k in range(8):
        state = found.state(k)
        assert state.norm() == pytest.approx(1, abs=1e-12)
        assert abs(state.overlap(found.state((k + 3) % 8))) < 1e-9
    ground = f[0][np.abs(f[0]) > 1e-4 * np.abs(f[0]).max()]
    assert np.ptp(np.sign(ground)) == 0  # no nodes


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("-(D1**2 + D2**2) + 0.1*D1*D2", NoGroundState, "large distance"),
        ("-1/(D1**2 + D2**2)**2 + D1**2 + D2**2 + D1*D2", NoGroundState, "phi = 0"),
        ("-log(D1**2 + D2**2 - 1) + D1**2 + D2**2", ValueError, "V|potential"),
    ],
)
def test_what_has_no_spectrum(text, error, words):
    with pytest.raises(error, match=words):
        spectrum(affine_body(text), m=0, l=0, count=2)


@pytest.mark.parametrize("c", [0.1, 0.45])
def test_weak_attraction_to_the_origin(c):
    """(0, 0) of rho^2/2 - c/rho^2, c < 1/2: E = 2 n + 1 + sqrt(1 - 2 c), as if it did not separate."""
    found = spectrum(affine_body("(D1**2 + D2**2)/2 - c/(D1**2 + D2**2)", c=c), m=0, l=0, count=2, tolerance=1e-8)
    np.testing.assert_allclose(found.E, 1 + np.sqrt(1 - 2 * c) + np.array([0, 2]), rtol=1e-11)


def test_errors_where_convergence_is_algebraic():
    """-c/rho is a cone at rho = 0, which weights of rho do not take: the truth is that of the radial equation alone, by
    `radial`.
    """
    found = spectrum(affine_body("rho**2/2 - c/rho", c=0.5), m=0, l=0, count=2, tolerance=1e-6)
    V = univariate(lambda r: r / 2 - 0.5 / np.sqrt(r))
    truth = radial("V", V, 4, np.zeros(1), 2, 1.0, 1.0, 1e-11).values[0]
    assert np.all(np.abs(found.E - truth) <= 3 * found.error)
    walls = affine_body("k/2*(D1**2 + D2**2) + c/(D1*D2)**2 + g*(D1 - D2)**4", k=1.0, c=0.5, g=0.05)
    coarse, fine = (spectrum(walls, m=0, l=0, count=4, tolerance=tolerance) for tolerance in (1e-4, 1e-6))
    assert fine.functions > 2 * coarse.functions
    assert np.all(np.abs(coarse.E - fine.E) <= coarse.error)


def test_a_potential_that_ends():
    """Morse potentials of both stretches end at De in narrow valleys: so many levels and no more."""
    morse = affine_body("De*(1 - exp(-a*(D1 - 1)))**2 + De*(1 - exp(-a*(D2 - 1)))**2", De=40.0, a=0.5)
    found = spectrum(morse, m=0, l=0, count=2, tolerance=1e-6)
    assert found.converged.all()
    assert 0 < found.E[0] < found.E[1] < 40
    with pytest.raises(NoGroundState, match=r"grows to 40\.\d* only .* count = 200"):
        spectrum(morse, m=0, l=0, count=200)
