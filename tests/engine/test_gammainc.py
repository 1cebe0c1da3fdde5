"""gammainc(a, x) of formulas, against mpmath: value, forces and tangent forces, maps, drives and bodies; refusals."""

from __future__ import annotations

import random

import mpmath
import numba
import numpy as np
import pytest

import fastaff as fa
from fastaff.engine.fused import FUSED
from fastaff.engine.incomplete_gamma import gammainc
from fastaff.engine.jit import JIT_DISABLED
from fastaff.exchange.sources import source
from fastaff.explorer.javascript import Refused, ScriptPart, printed
from fastaff.systems.formulas.gammainc import MOST_A, incomplete_gamma

RNG = np.random.default_rng(31)
FIRSTS = [0.1, 0.6, 1.0, float(RNG.uniform(0.05, 3)), float(RNG.uniform(0.05, 3)), float(MOST_A)]


def P(a, x):
    return mpmath.gammainc(a, 0, x, regularized=True)


def compiled(a):
    front = float(1 / mpmath.gamma(mpmath.mpf(a) + 1))

    @numba.njit(error_model="numpy")
    def loop(x, r):
        for i in range(r.size):
            r[i] = gammainc(a, x[i], front)

    return loop


@pytest.mark.skipif(not FUSED or JIT_DISABLED, reason="powers are less exact there")
@pytest.mark.parametrize("a", FIRSTS)
def test_it_is_right_to_a_few_units_in_the_last_place_in_vectors_and_alone(a):
    x = np.concatenate([10 ** RNG.uniform(-12, 3, 150), RNG.uniform(0, 20, 150), 8 + RNG.uniform(-1e-3, 1e-3, 50)])
    loop, found = compiled(a), np.empty(x.size)
    loop(x, found)
    with mpmath.workdps(40):
        true = [P(mpmath.mpf(a), mpmath.mpf(entry)) for entry in x]
        off = [abs(float((value - t) / mpmath.mpf(np.spacing(float(t))))) for value, t in zip(found, true)]
    assert max(off) < 8
    one = np.empty(1)
    for i in range(0, x.size, 7):
        loop(x[i : i + 1], one)
        assert one[0] == found[i]
    (text,) = loop.inspect_llvm().values()
    assert "x double> @llvm.fma.v" in text
    edges = np.array([0.0, np.inf, 1e300, -1e-300, -1.0, np.nan])
    loop(edges, found[:6])
    np.testing.assert_array_equal(found[:6], [0, 1, 1, np.nan, np.nan, np.nan])


@pytest.mark.parametrize("a", [FIRSTS[3], 0.6])
def test_models_have_its_exact_derivatives(a):
    k, s = RNG.uniform(0.5, 2, 2)
    text = f"k*gammainc({a!r}, (x**2 + 2*y**2)/s)"
    model = fa.hamiltonian(text, coordinates="x y", k=k, s=s, domain="x**2 + y**2")

    def V(x, y):
        return k * P(a, (x * x + 2 * y * y) / s)

    with mpmath.workdps(30):
        for _ in range(4):
            q, d = RNG.uniform(0.1, 3, 2) * RNG.choice([-1, 1], 2), RNG.uniform(-1, 1, 2)
            force = [-float(mpmath.diff(V, tuple(q), n)) for n in ((1, 0), (0, 1))]
            hessian = [
                [float(mpmath.diff(V, tuple(q), n)) for n in row] for row in (((2, 0), (1, 1)), ((1, 1), (0, 2)))
            ]
            assert model.potential_energy(*q) == pytest.approx(float(V(*q)), rel=1e-13)
            np.testing.assert_allclose(model.force(*q), force, rtol=1e-12, atol=1e-14)
            np.testing.assert_allclose(model.tangent_force(*q, *d), -np.array(hessian) @ d, rtol=1e-11, atol=1e-13)
    run = fa.integrate(model, [0.7, 0.4, 0.1, 0.5], time=20.0, accuracy=1e-11)
    assert run.status[0] == 0
    assert run.energy_error[0] < 1e-11


def test_where_x_is_negative_no_formula_lives():
    model = fa.hamiltonian("x**2/2 + gammainc(1.5, 1 + x)", coordinates="x")
    assert model.margin(-0.5) == 0.5
    assert model.margin(-1.5) < 0
    with pytest.raises(ValueError, match="in the domain of the potential"):
        fa.integrate(model, [-1.5, 0.0], time=1.0)


def test_maps_flows_drives_bodies_and_constants_have_it():
    x, c = 0.4, float(P(0.6, 1.16))
    kicked = fa.iterated_map("p1 = p + K*gammainc(0.6, 1 + x**2); x1 = x + p1", K=0.9)
    end = fa.integrate(kicked, [x, 0.1], time=1).z[:, 0]
    np.testing.assert_allclose(end, [x + 0.1 + 0.9 * c, 0.1 + 0.9 * c], rtol=1e-14)
    flow = fa.ode("x' = gammainc(3/5, 1 + x**2) - x")
    assert flow.rates(x)[0] == pytest.approx(c - x, rel=1e-14)
    driven = fa.hamiltonian("x**2/2 + gammainc(0.6, 1 + x**2)*cos(t)", coordinates="x", drive_period="2*pi")
    assert driven.potential_energy(x, 0.0) == pytest.approx(0.08 + c, rel=1e-14)
    body = fa.affine_body("(D1**2 + D2**2)/2 + k*gammainc(0.6, r)", k=0.3)
    assert body.potential.value(1.0, 0.2) == pytest.approx(0.6 + 0.3 * float(P(0.6, 1.2)), rel=1e-13)
    constant = fa.hamiltonian("gammainc(0.6, 2)*x**2", coordinates="x")
    assert constant.potential_energy(1.0) == pytest.approx(float(P(0.6, 2)), rel=1e-14)
    turning = fa.hamiltonian("(x**2 + y**2)/2", rotation="gammainc(0.6, w)", w=2.0)
    assert turning.potential_energy(1.0, 0.0) == 0.5


@pytest.mark.parametrize(
    "text",
    [
        *("gammainc(k, x)", "gammainc(x)", "gammainc(0, x)", "gammainc(-1, x)", "gammainc(4.1, x)"),
        *("gammainc(1/0, x)", "gammainc(pi, x)", "gammainc(0.5, x, 1)", "gammainc(0.5, *x)"),
    ],
)
def test_another_first_argument_is_refused(text):
    with pytest.raises(ValueError, match=r"at column 10\. Use a number a, 0 < a <= 4, .*: gammainc\(0.6, x\*\*2\)"):
        fa.hamiltonian(f"k*x**2 + {text}", coordinates="x", k=1.0)


def test_what_does_not_know_it_says_so():
    with pytest.raises(ValueError, match="gammainc without an argument"):
        fa.hamiltonian("gammainc + x**2", coordinates="x")
    with pytest.raises(ValueError, match="'gammainc' is the name of a function"):
        fa.hamiltonian("gammainc*x**2", coordinates="x", gammainc=1.0)
    model = fa.hamiltonian("x*gammainc(0.6, x**2 + 1)", coordinates="x")
    for language in ("c", "heyoka"):
        with pytest.raises(ValueError, match="has gammainc, which neither C nor heyoka knows"):
            source(model, language)
    alone = fa.hamiltonian("gammainc(0.6, x**2 + 1)", coordinates="x")  # whose forces are powers
    assert "gamma" not in source(alone, "c").replace(alone.formula, "")
    with pytest.raises(Refused, match="the call of gammainc cannot be printed as JavaScript"):
        printed(ScriptPart(model, ()), "potential_energy", ["q0"], [])


@pytest.mark.parametrize("digits", [15, 60, 500])
def test_many_digits_obey_the_recurrence(digits):
    """P(1, x) = 1 - e^-x, and P(a + 1, x) = P(a, x) - x^a e^-x/gamma(a + 1), from tiny x to where P is 1."""
    rng = random.Random(digits)
    with mpmath.workdps(digits):
        for x in (mpmath.mpf(10) ** rng.uniform(-20, 4) for _ in range(20)):
            a = mpmath.mpf(rng.uniform(0.05, 3))
            step = mpmath.power(x, a) * mpmath.exp(-x) / mpmath.gamma(a + 1)
            assert abs(incomplete_gamma(mpmath.mpf(1), x) + mpmath.expm1(-x)) <= 10 * mpmath.eps
            assert abs(incomplete_gamma(a + 1, x) + step - incomplete_gamma(a, x)) <= 10 * mpmath.eps
