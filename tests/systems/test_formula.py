"""Models from formulas: against hand-written models, mpmath, conserved quantities; their symmetry, domains, cache and
pickles.

The formula itself, evaluated by mpmath with 40 digits in the variables as defined here anew from the matrix phi, is the
truth; gradients of it are Cauchy integrals on a small circle. Tolerances are rounding unless said otherwise.
"""

import ast
import copy
import os
import pickle
import re
import subprocess
import sys
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive import states

import fastaff
from fastaff import Body, HenonHeiles, Hyperelastic, Status, affine_body, hamiltonian, integrate
from fastaff.engine import jit as _jit

FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "asin", "acos", "atan")
ROOT = Path(fastaff.__file__).parent.parent
H = 1e-30
HYPERELASTIC = "C/2*(D1**2 + D2**2) + C/(D1*D2)"
NEO_HOOKEAN = "G/2*(D1**2 + D2**2 - 2) - G*log(D1*D2) + K/2*(D1*D2 - 1)**2"
HENON_HEILES = "(x**2 + y**2)/2 + lam*(x**2*y - y**3/3)"


def planes(q):
    """The variables of a body at (a1, a2, b1, b2), from the matrix: D1 >= |D2| are its singular values."""
    a1, a2, b1, b2 = q
    w = 1 / mpmath.sqrt(2)
    x, y, z, u = w * (a1 + b1), w * (b2 - a2), w * (a2 + b2), w * (a1 - b1)
    trace, det = x * x + y * y + z * z + u * u, x * u - y * z
    total, difference = mpmath.sqrt(trace + 2 * det), mpmath.sqrt(trace - 2 * det)  # D1 + D2, D1 - D2
    D1, D2 = (total + difference) / 2, (total - difference) / 2
    return {
        "x": x,
        "y": y,
        "z": z,
        "u": u,
        "a1": a1,
        "a2": a2,
        "b1": b1,
        "b2": b2,
        "D1": D1,
        "D2": D2,
        "r": trace,
        "rho": mpmath.sqrt(trace),
        "alpha": w * total,
        "beta": w * difference,
        "vartheta": mpmath.atan2(D1**2 - D2**2, 2 * det),
    }


class Exact(ast.NodeTransformer):
    """Numbers as mpf of their literals."""

    def visit_Constant(self, node):
        return ast.Call(ast.Name("mpf", ast.Load()), [ast.Constant(repr(node.value))], [])


def truth(text, values, parameters):
    """A formula by Python's own eval on mpmath numbers."""
    tree = ast.fix_missing_locations(Exact().visit(ast.parse(text, mode="eval")))
    names = {name: getattr(mpmath, name) for name in (*FUNCTIONS, "pi", "mpf")}
    return eval(
        compile(tree, "formula", "eval"), {**names, **values, **{k: mpmath.mpf(v) for k, v in parameters.items()}}
    )


def gradient(function, q):
    """mpmath's derivatives of a real function, at 60 digits."""
    return [
        mpmath.diff(lambda s, k=k: function([*q[:k], s, *q[k + 1 :]]), q[k], h=mpmath.mpf(10) ** -20)
        for k in range(len(q))
    ]


BODIES = [
    (HYPERELASTIC, {"C": 1.1}),
    (NEO_HOOKEAN, {"G": 0.8, "K": 2.3}),
    ("C/2*(alpha**2 + beta**2) + 2*C/alpha**2", {"C": 0.9}),
    ("C*r/2 + A*cos(vartheta)/r", {"C": 1.2, "A": 0.6}),
    ("C/2*rho**2 + 4*C/(D1 + D2)**2 + eps*(D1 - D2)**4", {"C": 0.7, "eps": 0.1}),
    ("k/p*(D1**p + D2**p - 2) - k*log(D1*D2)", {"k": 1.3, "p": 2.5}),  # Ogden, not rational in D1, D2
    ("cos(D1) + cos(D2) + 0.3*exp(D1*D2)", {}),
    ("log(D1) + log(D2) + 1/D1 + 1/D2 + D1**3 + D2**3", {}),
    ("vartheta**2 + sqrt(r) + sin(vartheta/2)**2 + cos(3*vartheta)", {}),
    ("(x*u - y*z)**2 + x**2 + y**2 + z**2 + u**2", {}),
    ("C/2*r + C/(D1*D2) - g*y", {"C": 1.0, "g": 0.3}),
    ("x**4 + y**2*z + sin(u)*a1 + k*b2**3 + r**(3/2) + exp(-D1*D2)", {"k": 0.5}),
    ("cos(D1) + cos(D2) - g*y*alpha", {"g": 0.3}),
]
every_body = pytest.mark.parametrize(("text", "parameters"), BODIES, ids=[text[:24] for text, _ in BODIES])


def points(orbits=6, seed=5):
    return states(Body(Hyperelastic()), orbits, seed=seed, spread=0.25)[:4]


@every_body
def test_energy_and_force_are_those_of_the_formula(text, parameters):
    body = affine_body(text, **parameters)
    q = points()
    with mpmath.workdps(60):
        for i in range(q.shape[1]):
            at = [mpmath.mpf(float(x)) for x in q[:, i]]
            V = truth(text, planes(at), parameters)
            slope = gradient(lambda w: truth(text, planes(w), parameters), at)
            assert float(body.potential_energy(*q[:, i])) == pytest.approx(float(V), rel=1e-13, abs=1e-13)
            np.testing.assert_allclose(body.force(*q[:, i]), [-float(s) for s in slope], rtol=1e-11, atol=1e-12)


@every_body
def test_tangent_force_is_the_derivative_of_the_force(text, parameters):
    """Differences of fourth order; complex steps would not pass through comparisons."""
    body, h = affine_body(text, **parameters), 1e-3
    q, v = points(), np.random.default_rng(1).standard_normal((4, 6))
    at = {k: np.array(body.force(*(q + k * h * v))) for k in (-2, -1, 1, 2)}
    expected = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * h)
    np.testing.assert_allclose(np.array(body.tangent_force(*q, *v)), expected, rtol=1e-8, atol=1e-8)


@every_body
def test_floats_arrays_and_shapes(text, parameters):
    body, q = affine_body(text, **parameters), points()
    v = q[::-1] * 0.3
    calls = {
        "force": q,
        "potential_energy": q,
        "margin": q,
        "tangent_force": [*q, *v],
        "velocity": q,
        "kinetic_energy": q,
    }
    for name, rows in calls.items():
        whole = np.array(getattr(body, name)(*rows))
        assert whole.shape[-1:] == (6,), name
        for i in range(6):
            one = np.array(getattr(body, name)(*(float(r[i]) for r in rows)), dtype=float)
            np.testing.assert_allclose(one, whole[..., i], rtol=1e-13, atol=1e-14, err_msg=name)
    assert (np.array(body.margin(*q)) > 0).all()


# --- beta = 0 -----------------------------------------------------------------------------------------------------


EVEN = [
    ("cos(D1) + cos(D2)", {}),
    ("k/p*(D1**p + D2**p) + alpha", {"p": 2.5, "k": 1.0}),
    ("vartheta**2 + exp(D1) + exp(D2)", {}),
    ("sqrt(1 + D1) + sqrt(1 + D2) + sin(20*D1) + sin(20*D2)", {}),
]


@pytest.mark.parametrize(("text", "parameters"), EVEN)
@pytest.mark.parametrize("beta", [0.0, 1e-9, 1e-6, 1e-4, 1e-2, 0.0155, 0.0157, 0.1, 0.7])
def test_slopes_and_curvatures_near_beta_zero(text, parameters, beta):
    """V as a function of B by Taylor series of g(alpha, beta) at 60 digits: g'/(2 beta) and so on, to 1e-12 and 1e-11
    of V's size.
    """
    potential, alpha = affine_body(text, **parameters).potential, 1.1
    with mpmath.workdps(80):

        def V(A, B):
            p, q = mpmath.sqrt(A / 2), mpmath.sqrt(B / 2)  # q is imaginary for B < 0: V is even in it
            values = {"D1": p + q, "D2": p - q, "alpha": mpmath.sqrt(A), "vartheta": 2 * mpmath.atan(q / p)}
            return truth(text, values, parameters)

        at = (mpmath.mpf(alpha) ** 2, mpmath.mpf(beta) ** 2)
        orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
        expected = [
            float(mpmath.re(mpmath.diff(V, at, n, h=mpmath.mpf(10) ** -15) if any(n) else V(*at))) for n in orders
        ]
    found = [
        potential.value(alpha**2, beta**2),
        *potential.slopes(alpha**2, beta**2),
        *potential.curvatures(alpha**2, beta**2),
    ]
    np.testing.assert_allclose(np.array(found[:3], float), expected[:3], rtol=1e-12, atol=1e-12)
    size = max(map(abs, expected))
    np.testing.assert_allclose(np.array(found[3:], float), expected[3:], rtol=0, atol=1e-11 * size)


def test_orbits_through_beta_zero():
    """p_gamma = 0, started at b = 0: energy and p_eta stay."""
    body = affine_body("-2*(cos(D1) + cos(D2)) + k*(D1*D2 - 1)**2", k=0.5)
    z0 = np.array([1.3, 0.0, 0.0, 0.0, 0.2, 0.3, 0.25, 0.0])
    run = integrate(body, z0, time=50.0, step=0.02)
    run.raise_if_failed()
    assert run.energy_error[0] < 1e-12
    z = run.z[:, 0]
    assert z[0] * z[5] - z[1] * z[4] == pytest.approx(1.3 * 0.3, abs=1e-12)
    general = affine_body("-2*(cos(D1) + cos(D2)) + k*(D1*D2 - 1)**2 + 0*g*y", k=0.5, g=0.0, mu=(1.0, 1.0))
    other = integrate(general, z0, time=50.0, step=0.02)
    np.testing.assert_allclose(other.z, run.z, atol=1e-9)


# --- denominators that vanish where the formula is finite ----------------------------------------------------------

DIVIDED = [
    ("(exp(D1) - exp(D2))/(D1 - D2)", {}),
    ("k*(log(D1) - log(D2))/(D1 - D2) + r", {"k": 0.7}),
    ("(exp(k*(D1 - D2)**2) - 1)/(D1 - D2)**2 + r/2", {"k": 0.15}),
    ("(D1**p - D2**p)/(D1 - D2) + 1/(D1*D2)", {"p": 3.5}),
    ("sin(D1 - D2)/(D1 - D2)*cos(D1*D2)", {}),
]


@pytest.mark.parametrize(("text", "parameters"), DIVIDED, ids=[text for text, _ in DIVIDED])
def test_divided_differences_are_exact_up_to_the_axis(text, parameters):
    """(f(D1) - f(D2))/(D1 - D2) and its like: value, slopes, curvatures, force from beta = alpha/2 down to 0, at 120
    digits.
    """
    body = affine_body(text, mu=1.3, **parameters)
    potential, rng = body.potential, np.random.default_rng(8)
    with mpmath.workdps(120):

        def V(A, B):
            p, q = mpmath.sqrt(A / 2), mpmath.sqrt(B / 2)
            return truth(text, {"D1": p + q, "D2": p - q, "r": A + B}, parameters)

        for beta in (0.5, 0.3, 0.26, 0.24, 0.1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12, 0.0):
            a = float(rng.uniform(0.7, 1.6))
            A, B = a * a, (a * beta) ** 2
            at = (mpmath.mpf(A), mpmath.mpf(B) if B else mpmath.mpf(10) ** -50)
            orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
            exact = [
                float(mpmath.re(mpmath.diff(V, at, n, h=mpmath.mpf(10) ** -20) if any(n) else V(*at))) for n in orders
            ]
            found = [potential.value(A, B), *potential.slopes(A, B), *potential.curvatures(A, B)]
            size = max(map(abs, exact))
            np.testing.assert_allclose(found[:3], exact[:3], rtol=0, atol=1e-12 * size)
            np.testing.assert_allclose(found[3:], exact[3:], rtol=0, atol=1e-10 * size)
            force = np.array(body.force(a, 0.0, a * beta, 0.0))
            expected = [-2 * exact[1] * a, -2 * exact[2] * a * beta]
            np.testing.assert_allclose(force[[0, 2]], expected, rtol=1e-11, atol=1e-12 * size * a * beta)


@pytest.mark.parametrize(
    "call",
    [
        ("sin(x)/x + y**2", "x - 0.2"),
        ("(exp(2*x) - exp(2*y))/(x - y)", "x - y - 0.1"),
        ("y**2 + (1 - cos(x - 0.3))/(x - 0.3)**2", "x - 0.5"),
        ("log(1 + x*y)/(x*y)", "x*y - 0.01"),
        ("2*tanh(x + y)/(x + y)", "-0.1 - x - y"),
        ("1/tan(x) - 1/x + y**2", "x - 0.5"),
    ],
    ids=lambda v: v[0],
)
def test_forces_that_would_lose_their_digits_are_refused(call):
    text, domain = call
    with pytest.raises(ValueError, match=r"the denominator .* vanishes inside the domain, as at x = .*finite"):
        hamiltonian(text)
    assert hamiltonian(text, domain=domain).domain == domain  # a region without those places


def test_other_denominators_that_vanish_are_refused_on_bodies():
    for text in (
        "sin(r)/r",
        "sin(alpha)/alpha + r",
        "sin(D1*D2 - 1)/(D1*D2 - 1)",
        "(exp(D1) - exp(D2))/(D1 - D2) + 0.1*y",
        "(exp(D1) - exp(D2))/(D1 - D2)/(1 + 50*(D1 - D2)**2)",
    ):
        with pytest.raises(ValueError, match=r"the denominator .* vanishes inside the domain"):
            affine_body(text)
    for text in (
        "1/(D1*D2 - 1)",
        "(D1**3 - D2**3)/(D1 - D2)",
        "vartheta**2 + r",
        "tan(vartheta/2)**2/r",
        "r + 1/beta**2",
    ):
        affine_body(text)
    for text in ("1/x + 1/y**2", "x**2*y**2/(x**2 + y**2)", "-1/sqrt(x**2 + y**2)", "exp(-1/(1 + x**2))/(2 + sin(y))"):
        hamiltonian(text)


# --- large formulas -------------------------------------------------------------------------------------------------


def test_quotients_of_what_is_not_rational_are_not_multiplied_out(monkeypatch):
    """Exponentials beside a quotient: minutes of polynomial division whose result was of no use."""
    import sympy

    def never(*_):
        raise AssertionError("a division of polynomials in exponentials")

    monkeypatch.setattr(sympy, "cancel", never)
    body = affine_body("2.1*exp(-(alpha - 2)**2/0.7) - exp(-(alpha - 4)**2/0.4) + r/30 + 0.2*beta**2*alpha/(2 + r)")
    assert body.potential.slopes(1.0, 0.5)[1] == pytest.approx(1 / 30 + 0.2 / 3.5 - 0.2 * 0.5 / 3.5**2, rel=1e-13)


# --- symmetry -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        *("D1", "D1 - D2", "beta", "beta**3 + r", "vartheta", "sin(vartheta)", "D1**2*D2", "y*(D1 - D2)", "D1/D2"),
        "C*(D1 - D2)",
    ],
)
def test_what_d1_d2_change_is_refused(text):
    parameters = {"C": 0.0} if "C" in text else {}
    with pytest.raises(ValueError, match=r"symmetric under D1 <-> D2, got \S+ at D1 = \S+, D2 = \S+ and \S+ exch"):
        affine_body(text, **parameters)
    with pytest.raises(ValueError, match="domain must be symmetric under D1 <-> D2, got"):
        affine_body("r" if not parameters else "C*r", domain=text, **parameters)


def test_how_isotropy_is_known():
    assert "exactly" in affine_body(HYPERELASTIC, C=1.0).potential.proof
    assert "exactly" in affine_body("cos(D1) + cos(D2)").potential.proof
    assert "exactly" in affine_body("(x*u - y*z)**2").potential.proof
    numerical = affine_body(
        "cos(x*u - y*z)*cos(x*u - y*z) + sin(x*u - y*z)**2 + sin(D1)**2 + 1 - cos(D2)**2"
    ).potential.proof
    assert "numerically" in numerical or "exactly" in numerical
    assert "Not doubly isotropic" in affine_body("r - g*y", g=0.1).proof
    for text in ("x**2 + y**2", "x", "a1**2 + b2", "x*u", "(x*u - y*z)**2 + x**2"):
        assert not isinstance(affine_body(text), Body)


def test_domains():
    """Walls of the formula, or the one that is given."""
    q = np.array([1.0, 0.0, 0.9, 0.0])  # D1 D2 > 0, just so
    outside = np.array([0.9, 0.0, 1.0, 0.0])
    walled = (
        HYPERELASTIC,
        "C*log(D1*D2)",
        "C*log(D1) + C*log(D2)",
        "C*sqrt(D1*D2)",
        "-C/(x*u - y*z)**3",
        "C/(D1*D2) + y",
        "C*(D1*D2)**1.5",
    )
    for text in walled:
        body = affine_body(text, C=1.0)
        assert body.margin(*q) > 0
        assert not body.margin(*outside) > 0
    for text in (
        *("C*r", "C/(r + 1)", "C/(D1*D2 - 1)", "C*x", "C/(D1*D2 - 1)**2", "C*log(1 + x**2)", "C/cosh(x)"),
        "C*cos(D1) + C*cos(D2)",
    ):
        body = affine_body(text, C=1.0)
        assert body.margin(*q) > 0
        assert body.margin(*outside) > 0
    body = affine_body("C*r", domain="D1*D2 - k", C=1.0, k=0.05)
    assert body.margin(*q) == pytest.approx(0.095 - 0.05)
    assert body._replace(potential=body.potential._replace(k=0.1)).margin(*q) < 0
    shifted = affine_body("C*r", domain="1 - x", C=1.0)
    assert shifted.margin(*q) == pytest.approx(1 - 1.9 / np.sqrt(2))
    one = hamiltonian("log(x) + 1/y**2 + sqrt(2 - z)", coordinates="x y z")
    assert one.margin(1.0, 1.0, 1.0) > 0
    for wall in ((-1.0, 1.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 2.5)):
        assert not one.margin(*wall) > 0
    assert hamiltonian("x**2", coordinates="x", domain="1 - x**2").margin(0.5) == 0.75
    with pytest.raises(ValueError, match="in the domain of the potential"):
        integrate(one, [1.0, 1.0, 3.0, 0, 0, 0], time=1.0)
    run = integrate(
        one, [[1.0, 1.0], [1.0, 1.0], [1.0, 1.9], [0, 0], [0, 0], [0, 1.5]], time=0.3, step=0.01, energy_tolerance=1e9
    )
    assert run.status[0] == Status.OK
    assert run.status[1] in (Status.OUT_OF_DOMAIN, Status.NONFINITE)


# --- the anisotropic inertia --------------------------------------------------------------------------------------


def test_the_repr_of_a_long_formula_is_short():
    """A formula of a page is shown by its beginning; the model has the whole, and short ones are shown whole."""
    long = " + ".join(f"(x**2 + y**2)*k/{n}" for n in range(1, 60))
    model = hamiltonian(long, k=0.5)
    assert repr(model) == f"FormulaHamiltonian({long[:160]!r}... ({len(long)} characters), k=0.5)"
    assert model.formula == long
    kicked = fastaff.iterated_map(f"p1 = p + x*({long.replace('y', 'p')}); x1 = x + p1", k=0.5)
    assert len(repr(kicked)) < 220
    assert repr(hamiltonian("x**2 + k*y**2", k=0.5)) == "FormulaHamiltonian('x**2 + k*y**2', k=0.5)"


def test_anisotropic_inertia_is_that_of_the_matrix():
    from fastaff.systems.charts import to_matrix

    body = affine_body(HYPERELASTIC, C=1.1, mu=(0.7, 1.9))
    z = states(Body(Hyperelastic()), 20)
    (x, y), (mz, u) = to_matrix(z)[1]
    np.testing.assert_allclose(body.kinetic_energy(*z[4:]), (x**2 + mz**2) / 1.4 + (y**2 + u**2) / 3.8, rtol=1e-14)
    velocity = np.array(body.velocity(*z[4:]))
    (vx, vy), (vz, vu) = to_matrix(np.concatenate([velocity, z[4:]]))[0]
    np.testing.assert_allclose([vx, vy, vz, vu], [x / 0.7, y / 1.9, mz / 0.7, u / 1.9], rtol=1e-13, atol=1e-14)
    for k in range(4):
        p = z[4:] + 1j * H * np.eye(4)[k][:, None]
        np.testing.assert_allclose(velocity[k], np.imag(body.kinetic_energy(*p)) / H, rtol=1e-13, atol=1e-14)


# --- any Hamiltonian ----------------------------------------------------------------------------------------------


def test_henon_heiles_of_one_line():
    one, other = hamiltonian(HENON_HEILES, lam=0.9), HenonHeiles(0.9)
    z = states(other, 50)
    for name, rows in {
        "force": z[:2],
        "velocity": z[2:],
        "kinetic_energy": z[2:],
        "potential_energy": z[:2],
        "tangent_force": z,
    }.items():
        np.testing.assert_allclose(getattr(one, name)(*rows), getattr(other, name)(*rows), rtol=1e-14, atol=1e-15)
    assert one.coordinates == ("x", "y")
    assert one.degrees_of_freedom == 2
    heavy = hamiltonian(HENON_HEILES, masses=(2.0, 3.0), lam=0.9)
    assert heavy._fields == ("lam", "m_1", "m_2")
    np.testing.assert_allclose(heavy.velocity(*z[2:]), (z[2] / 2, z[3] / 3), rtol=1e-15)
    np.testing.assert_allclose(heavy.kinetic_energy(*z[2:]), z[2] ** 2 / 4 + z[3] ** 2 / 6, rtol=1e-14)


# --- parameters, wrong input --------------------------------------------------------------------------------------


def test_parameters_stay_run_time_values():
    body = affine_body(HYPERELASTIC, C=1.0)
    assert body.potential._fields == ("C",)
    other = body._replace(potential=body.potential._replace(C=2.0), mu=0.5)
    assert type(affine_body(HYPERELASTIC, C=2.0).potential) is type(body.potential)
    z0 = states(Body(Hyperelastic()), 5)
    one, two = (
        integrate(other, z0, time=1.0, step=0.05),
        integrate(Body(Hyperelastic(2.0), 0.5), z0, time=1.0, step=0.05),
    )
    np.testing.assert_allclose(one.z, two.z, atol=1e-12)
    if not _jit.JIT_DISABLED:
        from fastaff.engine.blocks import _compiled

        misses = _compiled.cache_info().misses
        integrate(affine_body(HYPERELASTIC, C=3.0), z0, time=1.0, step=0.05)
        assert _compiled.cache_info().misses == misses
    assert repr(body.potential) == f"FormulaPotential({HYPERELASTIC!r}, C=1.0)"
    assert "mu_1=1.0" in repr(affine_body(HYPERELASTIC, C=1.0, mu=(1, 2)))
    assert body.potential.formula == HYPERELASTIC


@pytest.mark.parametrize(
    ("call", "error", "says"),
    [
        (lambda: affine_body("C*r"), ValueError, "unknown name 'C'"),
        (lambda: affine_body("r", C=1.0), ValueError, "parameter 'C' must be a name in the formula, got 'r'"),
        (lambda: affine_body("C*r", C="1"), TypeError, "C must be a real number"),
        (lambda: affine_body("C*r", C=np.inf), ValueError, "C must be finite"),
        (lambda: affine_body("C*r", C=10**400), ValueError, "range of floats"),
        (lambda: affine_body("C*r", C=np.True_), TypeError, "C must be a real number"),
        (lambda: affine_body("r", r=1.0), ValueError, "'r' is taken"),
        (lambda: affine_body("r", sin=1.0), ValueError, "'sin' is the name of a function"),
        (lambda: affine_body("r", force=1.0), ValueError, "'force' is taken"),
        (lambda: affine_body("r", count=1.0), ValueError, "'count' is taken"),
        (lambda: affine_body("r", _k=1.0), ValueError, "must be an identifier"),
        (lambda: affine_body("r", **{"lambda": 1.0}), ValueError, "identifier"),
        (lambda: affine_body("r", mu=0.0), ValueError, "mu must be positive"),
        (lambda: affine_body("r", mu=(1.0, -1.0)), ValueError, r"mu\[1\] must be"),
        (lambda: affine_body("r", mu=(1.0,)), ValueError, "a pair"),
        (lambda: affine_body("r", mu="1"), TypeError, "mu must be a real number"),
        (lambda: affine_body(3), TypeError, "text must be a formula"),
        (lambda: affine_body("r", domain=3), TypeError, "domain must be a text"),
        (lambda: affine_body("r", domain="q"), ValueError, "domain: unknown name"),
        (
            lambda: affine_body("abs(x)"),
            ValueError,
            r"text: a call of 'abs' at column 1\. Use sqrt\(q\*\*2 \+ small\*\*2\),",
        ),
        (lambda: affine_body("sqrt(x**2)"), ValueError, "not smooth"),
        (lambda: affine_body("sqrt((D1 - D2)**2)"), ValueError, "not smooth"),
        (
            lambda: affine_body("sqrt(-1 - r)"),
            ValueError,
            "text must have finite real values, got none at 480 points with",
        ),
        (
            lambda: affine_body("1/(r - r)"),
            ValueError,
            "text must have finite real values, got none at 480 points with",
        ),
        (lambda: hamiltonian("x", coordinates="x x"), ValueError, "'x' is taken"),
        (lambda: hamiltonian("x", coordinates=""), ValueError, "1 to 16"),
        (lambda: hamiltonian("x", coordinates=3), TypeError, "coordinates must be names"),
        (lambda: hamiltonian("x", coordinates=["x", 3]), TypeError, "coordinate must be a name"),
        (lambda: hamiltonian("x", coordinates=[f"q{i}" for i in range(17)]), ValueError, "1 to 16 names, got 17"),
        (lambda: hamiltonian("x", masses=(1.0,)), ValueError, "masses must be 2"),
        (lambda: hamiltonian("x", masses=(1, 0)), ValueError, "positive"),
        (lambda: hamiltonian("x", masses=1.0), TypeError, "masses must be"),
        (lambda: hamiltonian("D1"), ValueError, "unknown name 'D1'"),
        (lambda: hamiltonian("x*y", y=1.0), ValueError, "'y' is taken"),
        (lambda: hamiltonian("log(-1 - x**2)"), ValueError, "no finite real"),
        (lambda: hamiltonian("sin(x", k=1.0), ValueError, "not one expression"),
    ],
)
def test_wrong_input(call, error, says):
    with pytest.raises(error, match=says):
        call()


def test_sympy_numbers_and_names_beyond_the_grammar():
    sympy = pytest.importorskip("sympy")
    r = sympy.Symbol("r")
    for wrong, says in (
        (sympy.Symbol("D1 + D2") * 2, "no name of the grammar"),
        (sympy.Float("1e-400") * r, "range of floats"),
        (sympy.Float("1e400") * r, "range of floats"),
    ):
        with pytest.raises(ValueError, match=says):
            affine_body(wrong)
    assert affine_body(sympy.Float(0) * r + r).force(1.0, 0.0, 0.0, 0.0)[0] == -2.0


def test_coordinates_may_be_called_anything():
    """Names that the generated text uses itself: temporaries, differentials, momenta."""
    names = ["t1", "w1", "dt1", "pt1", "s1", "root1"]
    model = hamiltonian(
        "sqrt(1 + t1**2 + w1**4) + exp(-dt1*pt1) + s1**6*root1**4/(2 + s1**2)**3 + k*t1*dt1", coordinates=names, k=0.3
    )
    q = np.random.default_rng(6).uniform(-1, 1, (6, 8))
    for k in range(6):
        step = model.potential_energy(*(q + 1j * H * np.eye(6)[k][:, None])).imag / H
        np.testing.assert_allclose(-model.force(*q)[k], step, rtol=1e-13, atol=1e-14)
    v = np.random.default_rng(7).standard_normal((6, 8))
    expected = np.imag(model.force(*(q + 1j * H * v))) / H
    np.testing.assert_allclose(np.array(model.tangent_force(*q, *v)), expected, rtol=1e-12, atol=1e-13)
    assert integrate(model, np.concatenate([q, v]), time=0.5, step=0.05).energy_error.max() < 1e-6


def test_sympy_expressions():
    import sympy

    D1, D2, C = sympy.symbols("D1 D2 C")
    body = affine_body(C / 2 * (D1**2 + D2**2) + C / (D1 * D2), C=1.1)
    np.testing.assert_allclose(body.potential.slopes(2.0, 0.3), Hyperelastic(1.1).slopes(2.0, 0.3), rtol=1e-14)
    x, y = sympy.symbols("x y")
    model = hamiltonian(
        sympy.exp(1) * x**2 / 3 + sympy.Float(0.1) * y**2 + sympy.sqrt(2) * x * sympy.pi - sympy.Rational(2, 7) * y
    )
    assert model.potential_energy(0.3, 0.7) == pytest.approx(
        np.e * 0.03 + 0.049 + np.sqrt(2) * 0.3 * np.pi - 0.2, rel=1e-14
    )
    for wrong in (
        sympy.Abs(x),
        sympy.Function("f")(x),
        sympy.Integral(x, x),
        sympy.Symbol("__class__"),
        sympy.I * x,
        sympy.oo + x,
        sympy.Piecewise((x, x > 0), (y, True)),
        sympy.Symbol("os.system('x')"),
        sympy.zeta(x),
    ):
        with pytest.raises(ValueError, match="text"):
            hamiltonian(wrong)
    with pytest.raises(TypeError, match="text must be"):
        hamiltonian(sympy.Matrix([x, y]))


LEAVES = st.sampled_from(["x", "y", "k", "2", "0.5", "3", "pi"])
TREES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        st.tuples(inner, inner).map(lambda t: f"({t[0]}/(2 + ({t[1]})**2))"),
        st.tuples(st.sampled_from(["sin", "cos", "tanh", "atan"]), inner).map(lambda t: f"{t[0]}({t[1]})"),
        inner.map(lambda t: f"log(3 + sin({t}))"),
        inner.map(lambda t: f"sqrt(1 + tanh({t})**2)"),
        inner.map(lambda t: f"({t})**3"),
    ),
    max_leaves=5,
)


@settings(max_examples=12)
@given(TREES)
def test_random_formulas_have_right_derivatives(text):
    """Against complex steps of the energy and of the force."""
    try:
        model = hamiltonian(f"{text} + k*x*y", k=0.7)
    except ValueError as problem:
        if not re.search("power|finite", str(problem)):
            raise
        return
    q, v = np.array([[0.3, -0.8], [0.6, 1.1]]), np.array([[0.4, 1.0], [-0.7, 0.2]])
    size = 1 + np.abs(model.potential_energy(*q)).max() + np.abs(model.force(*q)).max()
    for k in range(2):
        step = np.imag(model.potential_energy(*(q + 1j * H * np.eye(2)[k][:, None])) + 0 * q[0]) / H
        np.testing.assert_allclose(-np.array(model.force(*q))[k], step, rtol=1e-11, atol=1e-12 * size)
    expected = np.imag(np.array(model.force(*(q + 1j * H * v)))) / H
    found = np.array(model.tangent_force(*q, *v))
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-11 * (size + np.abs(found).max()))


# --- the library of classes ---------------------------------------------------------------------------------------


def run(code, **env):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[1]), str(ROOT)])} | env
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


SECOND = f"""
import pickle, sys
from fastaff import *
body = affine_body({HYPERELASTIC!r}, C=1.25, mu=0.75)
system = hamiltonian({HENON_HEILES!r}, lam=1.0)
general = affine_body("C/2*r + C/(D1*D2) - g*y", C=1.0, g=0.3, mu=(1.0, 2.0))
assert "sympy" not in sys.modules, "sympy"
print(pickle.dumps((body, system, general)).hex())
"""


def test_another_process_needs_no_sympy_and_pickles_travel():
    models = (
        affine_body(HYPERELASTIC, C=1.25, mu=0.75),
        hamiltonian(HENON_HEILES, lam=1.0),
        affine_body("C/2*r + C/(D1*D2) - g*y", C=1.0, g=0.3, mu=(1.0, 2.0)),
    )
    if _jit.cache_directory() is None:
        pytest.skip("no cache folder can be written here")
    back = pickle.loads(bytes.fromhex(run(SECOND)))
    assert back == models
    assert [type(m) for m in back] == [type(m) for m in models]
    assert copy.deepcopy(models) == models
    mine = pickle.dumps(models).hex()
    use = "print(*b[0].potential.slopes(2.0, 0.5), *b[2].force(1.5, 0.1, 0.2, 0.3))"
    code = f"import pickle; b = pickle.loads(bytes.fromhex({mine!r})); {use}"
    expected = (*models[0].potential.slopes(2.0, 0.5), *models[2].force(1.5, 0.1, 0.2, 0.3))
    np.testing.assert_array_equal([float(x) for x in run(code).split()], expected)


ORBIT = f"""
from numba.core import event
from fastaff import *
with event.install_recorder("numba:compile") as compiled:
    m = hamiltonian({HENON_HEILES!r}, lam=0.9)
    z = integrate(m, [0.1, 0.2, 0.3, 0.1], time=1.0, step=0.1, energy_tolerance=1.0).z
print(*(float(x).hex() for x in z[:, 0]))
print(len(compiled.buffer))
"""


@pytest.mark.skipif(_jit.JIT_DISABLED, reason="no compiler, no cache")
def test_compiled_formulas_are_cached_and_never_shared():
    """A second process compiles nothing; another formula, domain or order of parameters is another text."""
    if _jit.cache_directory() is None:
        pytest.skip("no cache folder can be written here")
    first, _ = run(ORBIT).splitlines()
    assert run(ORBIT).splitlines() == [first, "0"]
    m = hamiltonian(HENON_HEILES, lam=0.9)
    kinds = [
        hamiltonian("(x**2 + y**2)/2 + lam*(x**2*y - y**3/2)", lam=0.9),
        hamiltonian(HENON_HEILES, lam=0.9, domain="1 - lam*y"),
        hamiltonian(HENON_HEILES, lam=0.9, masses=(1, 1)),
        hamiltonian(HENON_HEILES, lam=0.9, coordinates="y x"),
    ]
    assert len({type(k) for k in (m, *kinds)}) == 5
    assert m.force(0.3, 0.5) != kinds[0].force(0.3, 0.5)


def test_a_damaged_text_is_written_anew(tmp_path):
    """Cut short or edited: the checksum in the first line does not fit."""
    env = {"FASTAFF_CACHE_DIR": str(tmp_path)}
    code = f"from fastaff import affine_body; print(*affine_body({HYPERELASTIC!r}, C=1.5).potential.slopes(2.0, 0.5))"
    first = run(code, **env)
    (path,) = tmp_path.rglob("formulas/*.py")
    whole = path.read_text()
    for damaged in (whole[: len(whole) // 2], whole.replace("2.0*", "3.0*")):
        assert damaged != whole
        path.write_text(damaged)
        assert run(code, **env) == first
        assert path.read_text() == whole


def test_without_a_folder_classes_live_in_memory(tmp_path):
    (tmp_path / "file").write_text("")
    code = (
        "import warnings; warnings.simplefilter('ignore')\nfrom fastaff import *\nfrom fastaff.engine.blocks import "
        "fingerprint\n"
        f"b = affine_body({HYPERELASTIC!r}, C=1.5)\nprint(*b.potential.slopes(2.0, 0.5), "
        "fingerprint((type(b.potential),)))"
    )
    V_A, V_B, fingerprint = run(code, FASTAFF_CACHE_DIR=str(tmp_path / "file" / "below")).split()
    assert fingerprint == "None"
    np.testing.assert_allclose([float(V_A), float(V_B)], Hyperelastic(1.5).slopes(2.0, 0.5), rtol=1e-14)


def test_the_generated_text_is_readable():
    """A formula on top, a docstring for each method, one division for both slopes."""
    potential = affine_body(HYPERELASTIC, C=1.0).potential
    module = sys.modules[type(potential).__module__]
    assert HYPERELASTIC in module.__doc__
    if getattr(module, "__file__", None):
        tree = ast.parse(Path(module.__file__).read_text())
        methods = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
        assert {m.name for m in methods} == {"value", "slopes", "curvatures", "margin"}
        assert all(ast.get_docstring(m) for m in methods)
        for m in methods:
            assert sum(isinstance(n, ast.Div) for n in ast.walk(m)) <= 1


@pytest.mark.slow
def test_large_formulas_end():
    """Products that would have millions of terms are not multiplied out; an 8-body chain has its Hessian."""
    body = affine_body("((x + y + z + u + a1)**8*(D1 + D2)**20 + 1)**2/(1 + r)**36 + r")
    assert np.isfinite(body.force(1.0, 0.2, 0.1, 0.3)).all()
    names = [f"q{i}" for i in range(8)]
    text = " + ".join(
        f"exp(-({a} - {b})**2) + sqrt(1 + ({a} - {b})**2)" for i, a in enumerate(names) for b in names[:i]
    )
    model = hamiltonian(text, coordinates=names)
    assert np.isfinite(model.force(*np.linspace(0, 1, 8))).all()
