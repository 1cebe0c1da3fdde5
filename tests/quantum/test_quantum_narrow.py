"""Levels of potentials with narrow features, against finite elements that know where the features are; sizes and flags
that are refused.
"""

import os
import signal
import threading

import numpy as np
import pytest
from numpy.polynomial import legendre
from own_models import Plain
from scipy.sparse import csr_matrix, diags, kron
from scipy.sparse.linalg import eigsh

import fastaff as fa
from fastaff import Body, Harmonic, Hyperelastic, NeoHookean, SeparableAlphaBeta, affine_body, univariate
from fastaff.quantum import coherent_packet, exact_levels, husimi, level_diagram, number_packet, spectrum, wavefunction
from fastaff.quantum.reference.matrices import class_matrices, oscillator_matrices
from fastaff.quantum.reference.rigid_tops import spherical_top
from fastaff.quantum.solvers.separable import angular, radial
from fastaff.systems.models import Oscillator


def mesh(lo, hi, features, base):
    """Edges of finite elements: `base` equal ones, and finer ones around features (place, width), by factors of two."""
    edges = list(np.linspace(lo, hi, base + 1))
    for place, width in features:
        edges += list(place + width * np.linspace(-5, 5, 11))
        edges += [
            place + sign * width * 5 * 2.0**k for k in range(60) for sign in (-1, 1) if width * 5 * 2.0**k < hi - lo
        ]
    edges = np.array(sorted(edge for edge in edges if lo <= edge <= hi))
    least = 0.3 * min([width for _, width in features] + [(hi - lo) / base])
    edges = edges[np.append(True, np.diff(edges) > least)]
    edges[-1] = hi
    return edges


def lagrange(edges, degree):
    """Values and slopes (points, functions), points and weights of Gauss rules, of continuous piecewise polynomials."""
    t, w = legendre.leggauss(degree + 4)
    nodes = np.cos(np.pi * np.arange(degree, -1, -1) / degree)
    inverse = np.linalg.inv(legendre.legvander(nodes, degree))
    slopes = [legendre.legval(t, legendre.legder(row)) if k else 0 * t for k, row in enumerate(np.eye(degree + 1))]
    values, slopes = legendre.legvander(t, degree) @ inverse, np.stack(slopes, axis=1) @ inverse
    h = np.diff(edges)
    shape = (h.size, t.size, degree + 1)
    column = np.broadcast_to((np.arange(h.size)[:, None] * degree + np.arange(degree + 1))[:, None, :], shape)
    row = np.broadcast_to(np.arange(h.size * t.size).reshape(h.size, t.size, 1), shape)

    def sparse(table):
        return csr_matrix(
            (np.broadcast_to(table, shape).ravel(), (row.ravel(), column.ravel())), (row.max() + 1, column.max() + 1)
        )

    x = edges[:-1, None] + h[:, None] * (1 + t) / 2
    return sparse(values), sparse(slopes * (2 / h)[:, None, None]), x.ravel(), (w * h[:, None] / 2).ravel()


def lowest(K, M, kept, count, guess):
    K, M = (matrix.tocsc()[kept][:, kept] for matrix in (K, M))
    return np.sort(eigsh(K, k=count, M=M, sigma=guess, return_eigenvectors=False))


def on_a_line(p, q, measure, edges, count, guess, degree=8):
    """Levels of -(p f')' + q f = lambda measure f, f = 0 at the last edge."""
    values, slopes, x, w = lagrange(edges, degree)
    K = slopes.T @ diags(w * p(x)) @ slopes + values.T @ diags(w * q(x)) @ values
    M = values.T @ diags(w * measure(x)) @ values
    return lowest(K, M, np.arange(K.shape[0] - 1), count, guess)


def in_polar_coordinates(V, edges, count, guess, degree=7):
    """Levels of m = l = 0, hbar = mu = 1 of V(alpha, beta), by finite elements in rho and atan(beta/alpha)."""
    (B0, D0, rho, u), (B1, D1, angle, w) = (lagrange(side, degree) for side in edges)
    q, v = (x.ravel() for x in np.meshgrid(rho, angle, indexing="ij"))
    measure = np.outer(u, w).ravel() * q**3 * np.sin(v) * np.cos(v)
    f, along, around = (kron(*pair).tocsr() for pair in ((B0, B1), (D0, B1), (B0, D1)))
    K = (along.T @ diags(measure) @ along + around.T @ diags(measure / q**2) @ around) / 2
    K = K + f.T @ diags(measure * V(q * np.cos(v), q * np.sin(v))) @ f
    kept = np.arange((B0.shape[1] - 1) * B1.shape[1])
    return lowest(K, f.T @ diags(measure) @ f, kept, count, guess)


def feature(kind, height, place, width):
    return {
        "Gauss": lambda x: height * np.exp(-(((x - place) / width) ** 2)),
        "Lorentz": lambda x: height / (1 + ((x - place) / width) ** 2),
        "step": lambda x: height * np.tanh((x - place) / width),
    }[kind]


KINDS = ("Gauss", "Lorentz", "step")


@pytest.mark.parametrize("seed", [*range(4), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(4, 24))])
def test_radial_equations_with_narrow_features(seed):
    rng = np.random.default_rng(100 + seed)
    kind, a, dimension = KINDS[seed % 3], int(rng.integers(0, 4)), int(rng.choice([2, 4]))
    width, place, hbar, mu = 10 ** rng.uniform(-3, 0), rng.uniform(0.3, 2.5), rng.uniform(0.4, 1.2), rng.uniform(0.5, 2)
    height = 10 ** rng.uniform(0, 2.5)
    height = -min(height, 3 / width) if rng.random() < 0.3 and kind != "step" else height
    bump, unit = feature(kind, height, place, width), hbar**2 / (2 * mu)

    def V(q):
        return 0.5 * q**2 + 0.1 * q**4 + bump(q)

    K = float(a * a if dimension == 2 else a * (a + 2))
    found = radial(
        "V", Plain(V if dimension == 2 else lambda r: V(np.sqrt(r))), dimension, np.array([K]), 8, hbar, mu, 1e-10
    )
    E, error = found.values[0], found.error[0]
    power = dimension - 1 + 2 * a  # f = q^a g
    guess = (E[0] - 0.3 * (E[-1] - E[0])) / unit
    # the wider one needs no more than equal elements; both see the truth to their rounding
    truth = unit * on_a_line(
        lambda q: q**power,
        lambda q: q**power * V(q) / unit,
        lambda q: q**power,
        mesh(0, 7.0, [(place, width)], 120),
        8,
        guess,
    )
    assert np.all(np.abs(E - truth) <= 3 * error + 3e-9 * np.abs(E).max())
    assert np.all(error <= 1e-9 * np.abs(E).max())
    tight = radial(
        "V", Plain(V if dimension == 2 else lambda r: V(np.sqrt(r))), dimension, np.array([K]), 9, hbar, mu, 1e-12
    )
    assert np.all(np.abs(E - tight.values[0, :8]) <= error + tight.error[0, :8])


@pytest.mark.parametrize(("width", "c"), [(0.3, 0.2), (0.012, -0.35), (0.002, 0.81)])
def test_angles_with_narrow_features(width, c):
    """In x = cos(vartheta), m = l = 0: -((1 - x^2) f')' + V f/4 = e f/4 for hbar = mu = 2 ... in units hbar = mu =
    1.
    """

    def V(x):
        return 40 * np.exp(-(((x - c) / width) ** 2)) + 3 * x

    found = angular("V", Plain(lambda v: V(np.cos(v))), np.zeros(1), np.zeros(1), 6, 1.0, 1.0, 1e-11)
    edges = mesh(-1.0, 1.0, [(c, width)], 30)
    values, slopes, x, w = lagrange(edges, 8)
    K = slopes.T @ diags(w * 2 * (1 - x**2)) @ slopes + values.T @ diags(w * V(x)) @ values
    truth = lowest(K, values.T @ diags(w) @ values, np.arange(K.shape[0]), 6, found.values[0, 0] - 1)
    assert np.abs(found.values[0] - truth).max() < 1e-8
    assert found.error.max() < 1e-9


def test_states_on_elements_are_normalised_and_solve_their_equation():
    def bump(q):
        return 0.5 * q * q + 6 / (1 + ((q - 1.2) / 0.02) ** 2)

    def slope(q):
        return q - 12 * (q - 1.2) / 0.02**2 / (1 + ((q - 1.2) / 0.02) ** 2) ** 2

    body = Body(SeparableAlphaBeta(univariate(bump, slope=slope), Oscillator(1.3)))
    found = spectrum(body, m=2, l=0, count=6)
    assert found.converged.all()
    states = [found.state(k) for k in range(6)]
    for k, state in enumerate(states):
        assert state.norm() == pytest.approx(1, abs=1e-10)
        assert abs(state.overlap(states[(k + 1) % 6], order=60)) < 1e-8
    q = np.linspace(0.4, 2.5, 9)
    f = next(state for state in states if state.numbers["n_alpha"] == 1).shape.factors[0]
    h, numbers = 1e-4, next(state for state in states if state.numbers["n_alpha"] == 1)
    second, first = (f(q + h) - 2 * f(q) + f(q - h)) / h**2, (f(q + h) - f(q - h)) / (2 * h)
    left = -(second + first / q - f(q) / q**2) / 2 + bump(q) * f(q)
    assert np.abs(left - numbers.constants["E_alpha"] * f(q)).max() < 1e-4 * np.abs(f(q)).max() * numbers.energy


RIDGE = "(D1**2 + D2**2)/2 + h*exp(-((D1**2 + D2**2 - c)/w)**2) + g*D1*D2"


@pytest.mark.parametrize(
    ("h", "c", "w", "g"),
    [
        (70.0, 3.1, 0.05, 0.2),
        pytest.param(300.0, 2.3, 0.006, -0.15, marks=pytest.mark.slow),
        pytest.param(-30.0, 5.0, 0.03, 0.3, marks=pytest.mark.slow),
    ],
)
def test_ridges_of_bodies_that_do_not_separate(h, c, w, g):
    found = spectrum(affine_body(RIDGE, h=h, c=c, w=w, g=g), m=0, l=0, count=6, tolerance=1e-7)
    rho = np.sqrt(c)

    def V(a, b):
        r = a * a + b * b
        return r / 2 + h * np.exp(-(((r - c) / w) ** 2)) + g * (a * a - b * b) / 2

    edges = mesh(0, 9, [(rho, w / (2 * rho))], 14), np.linspace(0, np.pi / 2, 5)
    truth = in_polar_coordinates(V, edges, 6, found.E[0] - 0.3)
    assert found.converged.all()
    assert "elements" in found.method
    assert np.all(np.abs(found.E - truth) <= found.error + 2e-9 * np.abs(truth))
    assert found.state(2).norm() == pytest.approx(1, abs=1e-8)
    assert abs(found.state(0).overlap(found.state(1))) < 1e-6


BUMP = "(D1**2 + D2**2)/2 + g*D1*D2 + h*exp(-((D1**2 + D2**2 - c)/w)**2 - ((D1*D2 - d)/w)**2)"


@pytest.mark.parametrize(
    ("h", "c", "d", "w"),
    [
        (90.0, 4.0, 0.7, 0.06),
        pytest.param(400.0, 3.3, -0.45, 0.012, marks=pytest.mark.slow),
        pytest.param(-60.0, 5.1, 1.3, 0.03, marks=pytest.mark.slow),
        pytest.param(700.0, 2.2, 0.1, 0.006, marks=pytest.mark.slow),
    ],
)
def test_isolated_bumps(h, c, d, w):
    """Narrow in both coordinates: no line of a grid need cross them."""
    found = spectrum(affine_body(BUMP, h=h, c=c, d=d, w=w, g=0.1), m=0, l=0, count=6, tolerance=1e-7)

    def V(a, b):
        r, s = a * a + b * b, (a * a - b * b) / 2
        return r / 2 + 0.1 * s + h * np.exp(-(((r - c) / w) ** 2) - ((s - d) / w) ** 2)

    half = np.arccos(2 * d / c) / 2
    edges = (
        mesh(0, 9, [(np.sqrt(c), w / (2 * np.sqrt(c)))], 14),
        mesh(0, np.pi / 2, [(half, w / (c * np.sin(2 * half)))], 5),
    )
    truth = in_polar_coordinates(V, edges, 6, found.E[0] - 0.3, degree=6)
    without = spectrum(affine_body(BUMP, h=0.0, c=c, d=d, w=w, g=0.1), m=0, l=0, count=6, tolerance=1e-9).E
    assert found.converged.all() or (h < 0 and found.error.max() < 1e-4)  # a hole takes more than there may be
    assert np.abs(found.E - without).max() > (1e3 if h > 0 else 100) * found.error.max()
    assert np.all(np.abs(found.E - truth) <= found.error + 1e-8 * np.abs(truth))


def test_what_cannot_be_resolved_counts_as_error():
    """Waves of V of length 3e-4, far more than panels: their part of V is in the error, and no level is called
    converged.
    """

    def V(q):
        return q * q / 2 + 0.3 * np.sin(2e4 * q)

    found = radial("V", Plain(V), 2, np.zeros(1), 4, 1.0, 1.0, 1e-10)
    assert np.all(found.error > 0.01)
    assert np.all(np.abs(found.values[0] - (2 * np.arange(4) + 1)) < found.error[0])  # waves so short average out


def test_smooth_bodies_keep_their_global_bases():
    for body in (Body(NeoHookean(1.0, 2.0)), affine_body("(D1**2 + D2**2)/2 + g*(D1*D2)**2", g=0.3)):
        assert "adiabatic" in spectrum(body, m=0, l=0, count=3, tolerance=1e-4).method
    for V in (lambda q: q**4, lambda q: q**2 / 2 + 0.3 / q**2, lambda q: np.cosh(q)):
        assert radial("V", Plain(V), 2, np.zeros(1), 6, 1.0, 1.0, 1e-10).size < 250


# --- wrong input -------------------------------------------------------------------------------------------------

OSCILLATOR = Body(Harmonic())
Z0 = np.array([1.0, 0.0, 0.2, 0.0, 0.1, 0.3, 0.2, 0.1])


@pytest.mark.parametrize("value", ["yes", 1, None, [True], 0.0])
@pytest.mark.parametrize(
    "call",
    [
        lambda flag: spectrum(OSCILLATOR, m=0, l=0, count=1, single_valued=flag),
        lambda flag: exact_levels(OSCILLATOR, n=(0, 0), m=0, l=0, single_valued=flag),
        lambda flag: exact_levels(OSCILLATOR, max_energy=3.0, single_valued=flag),
        lambda flag: exact_levels(OSCILLATOR, multiplets=2, single_valued=flag),
        lambda flag: wavefunction(OSCILLATOR, m=0, l=0, n=(0, 0), single_valued=flag),
        lambda flag: fa.quantum.all_levels(OSCILLATOR, multiplets=2, single_valued=flag),
        lambda flag: level_diagram(lambda C: Body(Harmonic(C)), [1.0], m=0, l=0, count=1, single_valued=flag),
        lambda flag: fa.quantum.revivals(OSCILLATOR, n=(2, 2), m=0, l=0, single_valued=flag),
    ],
)
def test_flags_are_true_or_false(call, value):
    with pytest.raises(TypeError, match="single_valued must be True or False"):
        call(value)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: spectrum(OSCILLATOR, m=1e300, l=0, count=1), "m must be at most"),
        (lambda: spectrum(OSCILLATOR, m=0, l=-(10**8), count=1), "l must be at most"),
        (lambda: spectrum(Body(Hyperelastic()), m=0, l=0, count=2, hbar=1e-300), "hbar"),
        (lambda: spectrum(Body(NeoHookean(1.0, 2.0)), m=0, l=0, count=2, hbar=1e300), "hbar"),
        (lambda: exact_levels(OSCILLATOR, n=(0, 0), m=0, l=0, hbar=1e-300), "hbar"),
        (lambda: fa.quantum.weyl_count(Body(Hyperelastic()), 6.0, m=0, l=0, hbar=1e-250), "hbar"),
        (lambda: spherical_top(1.0, j=1, hbar=1e-290), "hbar"),
        (lambda: spectrum(OSCILLATOR, m=0, l=0, count=10**13), r"count asks for"),
        (lambda: spectrum(Body(NeoHookean(1.0, 2.0)), m=0, l=0, count=10**9), "count = 1000000000 needs"),
        (lambda: exact_levels(OSCILLATOR, max_energy=1e7), r"max_energy asks for"),
        (lambda: exact_levels(OSCILLATOR, multiplets=10**13), r"multiplets asks for"),
        (lambda: exact_levels(OSCILLATOR, multiplets=2).multiplets(tolerance=1.5), "tolerance must be"),
        (lambda: wavefunction(OSCILLATOR, m=0, l=0, n=(10**13, 0)), r"n1 asks for"),
        (
            lambda: number_packet(OSCILLATOR, n=(5, 5), m=0, l=0, width=(1e7, 1e7)),
            r"width asks for",
        ),
        (
            lambda: class_matrices(OSCILLATOR, m=0, l=0, shells=10**6),
            r"shells asks for",
        ),
        (lambda: oscillator_matrices(OSCILLATOR, quanta=10**5), r"quanta asks for"),
        (lambda: coherent_packet(OSCILLATOR, Z0, width=1e6, count=20), "width"),
        (lambda: coherent_packet(OSCILLATOR, Z0, width=1e-9, count=20), "width"),
        (lambda: coherent_packet(OSCILLATOR, Z0, width=1e300, count=20), "width must lie between"),
        (
            lambda: wavefunction(OSCILLATOR, m=0, l=0, n=(0, 0)).expectation(lambda x, y: x, order=10**9),
            r"order asks for",
        ),
    ],
)
def test_numbers_out_of_reach(call, words):
    with pytest.raises(ValueError, match=words):
        call()


@pytest.mark.parametrize("state", [None, 3, "psi", np.ones(3), object()])
def test_husimi_takes_states(state):
    with pytest.raises(TypeError, match="state must be a State"):
        husimi(state)


@pytest.mark.race
def test_long_searches_stop_at_once():
    """Ctrl-C ends the elements of a body with an oblique ridge, and the thread that was at them."""
    body = affine_body("(D1**2 + D2**2)/2 + h*exp(-((alpha - c)/w)**2) + 0.1*D1*D2", h=30.0, c=1.3, w=0.07)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            spectrum(body, m=0, l=0, count=40, tolerance=1e-12)
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, before)
