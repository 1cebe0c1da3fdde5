"""Separable bodies: functions of one variable, the three families, the body with angular potentials, constants of
motion.

Derivatives are complex steps where the formulas are analytic, else sixth-order differences: error h^6 f^(7)/140 + 11
eps |f|/6 h, with h = 3e-3 about 1e-12 of f where f^(7) is within 1e5 of it.
"""

from __future__ import annotations

from itertools import combinations
from math import sqrt

import numpy as np
import pytest

from fastaff import (
    KAHAN_LI8,
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    NeoHookean,
    SeparableAlphaBeta,
    SeparableElliptic,
    SeparableRVartheta,
    action_angles,
    constants_of_motion,
    integrate,
    tangent_map,
    univariate,
)
from fastaff.systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA, TWO_POLAR
from fastaff.systems.models import (
    Barriers,
    CoshOscillator,
    Cosine,
    CosOscillator,
    Oscillator,
    Secant,
    Spring,
    StackelBody,
    Zero,
)
from fastaff.tori.separation import separate

STEP = 3e-3


def differences(function, q, step=STEP):
    """Return the gradient (n, ...) of a function of q (n, ...) by sixth-order central differences."""
    slopes = []
    for k in range(len(q)):
        e = np.zeros_like(q)
        e[k] = step
        terms = ((3 / 4, 1), (-3 / 20, 2), (1 / 60, 3))
        slopes.append(sum(w * (function(q + j * e) - function(q - j * e)) for w, j in terms) / step)
    return np.array(slopes)


def complex_step(function, x):
    return np.imag(function(x + 1e-100j)) / 1e-100


# Functions of one variable
# -------------------------------------------------------------------------------------------------------------

ROOT, SAME = (np.sqrt, 0.2, 6.0), (np.asarray, 0.2, 6.0)
HALF_ANGLE, ARCSIN, ARCSINH = (
    (lambda s: 2 * np.arcsin(np.sqrt(s)), 0.02, 0.97),
    (lambda s: np.arcsin(np.sqrt(s)), 0.02, 0.97),
    (lambda s: np.arcsinh(np.sqrt(s)), 0.01, 4.0),
)
FUNCTIONS = [
    (Zero(), ROOT),
    (Oscillator(1.3), ROOT),
    (Oscillator(1.3, 0.4), ROOT),
    (Oscillator(-0.3, 0.4), ROOT),
    (Spring(1.3), SAME),
    (Spring(1.3, 0.4), SAME),
    (Barriers(), HALF_ANGLE),
    (Barriers(0.3), HALF_ANGLE),
    (Barriers(0.0, 0.7), HALF_ANGLE),
    (Barriers(0.3, 0.7), HALF_ANGLE),
    (Secant(1.4), (HALF_ANGLE[0], 0.0, 0.45)),
    (Cosine(-0.8), HALF_ANGLE),
    (CoshOscillator(1.3), ARCSINH),
    (CoshOscillator(1.3, 0.4), ARCSINH),
    (CosOscillator(1.3), ARCSIN),
    (CosOscillator(1.3, 0.4), ARCSIN),
]
every_function = pytest.mark.parametrize(("V", "variable"), FUNCTIONS, ids=[repr(V) for V, _ in FUNCTIONS])


@every_function
def test_slope_is_the_derivative_of_value(V, variable):
    """By complex step to rounding, and by differences, which share nothing with it."""
    x = variable[0](np.linspace(*variable[1:], 41)[1:-1])
    np.testing.assert_allclose(V.slope(x), complex_step(V.value, x), rtol=1e-13, atol=1e-13)
    x = variable[0](np.linspace(*variable[1:], 41)[8:-8])
    slope = differences(lambda q: V.value(q[0]), x[None], 1e-3)[0]
    np.testing.assert_allclose(V.slope(x), slope, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize(
    ("V", "variable"),
    [case for case in FUNCTIONS if hasattr(case[0], "curvature")],
    ids=lambda v: repr(v) if hasattr(v, "_fields") else "",
)
def test_curvature_is_the_derivative_of_slope(V, variable):
    x = variable[0](np.linspace(*variable[1:], 41)[1:-1])
    np.testing.assert_allclose(V.curvature(x) + 0 * x, complex_step(V.slope, x) + 0 * x, rtol=1e-13, atol=1e-13)


@every_function
def test_regular_is_value_of_the_coordinate(V, variable):
    """x of s turns a rounding of s into |V'(x)| x'(s) s eps: below 1e-13 of V away from the ends."""
    if not hasattr(V, "regular"):
        pytest.skip("has no form of its own")
    s = np.linspace(*variable[1:], 41)[1:-1]
    np.testing.assert_allclose(V.regular(s), V.value(variable[0](s)), rtol=1e-13, atol=1e-14)
    for number in s[::10]:
        assert np.ndim(V.regular(float(number))) == 0


@every_function
def test_floats_and_arrays_give_the_same(V, variable):
    x = variable[0](np.linspace(*variable[1:], 7)[1:-1])
    for method in ("value", "slope", "curvature"):
        if hasattr(V, method):
            one_by_one = [getattr(V, method)(float(number)) for number in x]
            np.testing.assert_allclose(getattr(V, method)(x) + 0 * x, one_by_one, rtol=1e-15, atol=0)


def test_values_outside_are_infinite():
    with np.errstate(divide="ignore"):
        assert np.isposinf(Secant(2.0).value(np.array([np.pi / 2 + 0.01, 2.0, np.pi]))).all()
        assert np.isposinf(Secant(2.0).regular(np.array([0.5, 0.7, 1.0]))).all()
        assert np.isposinf(Barriers(0.3, 0.7).regular(np.array([0.0, 1.0]))).all()
        assert np.isposinf(Oscillator(1.0, 0.4).value(np.zeros(1))).all()


def test_oscillators_of_the_elliptic_chart():
    """Delta = cosh^2 kappa - cos^2 lambda; EQa: (C/2)(alpha^2 + beta^2) + c/alpha^2 = (V_kappa + V_lambda)/2 Delta."""
    kappa, lam = np.meshgrid(np.linspace(0.2, 1.5, 9), np.linspace(0.1, 1.4, 9))
    alpha, beta = sqrt(2) * np.cosh(kappa) * np.cos(lam), sqrt(2) * np.sinh(kappa) * np.sin(lam)
    V = CoshOscillator(1.3, 0.4).value(kappa) + CosOscillator(1.3, 0.4).value(lam)
    expected = 0.65 * (alpha**2 + beta**2) + 0.4 / alpha**2
    np.testing.assert_allclose(V / (2 * (np.cosh(kappa) ** 2 - np.cos(lam) ** 2)), expected, rtol=1e-12)


# Functions of one's own
# ----------------------------------------------------------------------------------------------------------------


def well(x):
    """Return a quartic well with a ripple."""
    return 0.6 * x * x + 0.1 * x * x * x * x + 0.05 * np.cos(2 * x)


def slope_of_well(x):
    """Return its derivative."""
    return 1.2 * x + 0.4 * x * x * x - 0.1 * np.sin(2 * x)


def test_slope_by_complex_step():
    """Exact to rounding, and that with a given slope is the given one."""
    x, made, given = np.linspace(-2, 2, 31), univariate(well), univariate(well, slope_of_well)
    np.testing.assert_allclose(made.slope(x), slope_of_well(x), rtol=4e-16, atol=1e-15)
    np.testing.assert_array_equal(given.slope(x), slope_of_well(x))
    np.testing.assert_array_equal(made.value(x), well(x))
    assert made.slope(0.7) == pytest.approx(slope_of_well(0.7), rel=4e-16)
    assert not hasattr(made, "curvature")
    assert univariate(well, slope_of_well, lambda x: 1.2 + 1.2 * x * x - 0.2 * np.cos(2 * x)).curvature(0.0) == 1.0
    assert repr(made) == "well()"


@pytest.mark.slow
def test_compiled_functions_are_those_of_their_closure():
    """Two functions of the same text differ by what they read: k x^2/2 has the period 2 pi/sqrt k (KAHAN_LI8 to
    rounding).
    """

    def spring(k):
        return univariate(lambda x: k * x * x / 2)

    z = np.array([1.2, 0.1, 0.3, 0.2, 0.1, 0.3, -0.2, 0.4])
    for k in (1.0, 4.0):
        body = Body(SeparableAlphaBeta(spring(k), spring(k)))
        assert np.abs(integrate(body, z, time=2 * np.pi / sqrt(k), step=0.02).z[:, 0] - z).max() < 1e-13
        np.testing.assert_allclose(action_angles(body, z).nu[:2], sqrt(k) / np.pi, rtol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ((3.0,), TypeError, "value must be a Python function"),
        ((np.sin,), TypeError, "value must be a Python function"),
        (("x*x",), TypeError, "value must be a Python function"),
        ((Oscillator(),), TypeError, "value must be a Python function"),
        ((well, 3.0), TypeError, "slope must be a Python function"),
        ((well, slope_of_well, 1), TypeError, "curvature must be a Python function"),
        ((lambda x, y: x + y,), ValueError, "value must take an array"),
        ((lambda: 1.0,), ValueError, "value must take an array"),
        ((lambda x: x if x > 0 else -x,), ValueError, "value must take an array"),
        ((lambda x: x.shape[0] * 1.0,), ValueError, "value must take an array"),
        ((lambda x: str(x),), ValueError, "must return one real number"),
        ((lambda x: None,), ValueError, "must return one real number"),
        ((lambda x: x > 0,), ValueError, "must return one real number"),
        ((lambda x: 1j * x,), ValueError, "must return one real number"),
        ((lambda x: np.array([x, x]),), ValueError, "must return one real number"),
        ((lambda x: np.sum(x),), ValueError, "must be vectorised"),
        ((lambda x: np.cumsum(x) if np.ndim(x) else x,), ValueError, "must be vectorised"),
        ((lambda x: abs(x),), ValueError, "imaginary.*Use slope"),
        ((lambda x: np.abs(x) ** 2,), ValueError, "imaginary.*Use slope"),
        ((lambda x: np.real(x) * np.real(x),), ValueError, "imaginary.*Use slope"),
        ((lambda x: np.where(x > 0.5, x, 0.0), lambda x: str(x)), ValueError, "slope must return"),
        ((lambda x: np.where(x.real > 0.5, x, 0.0) if x > 0 else 0.0 * x,), ValueError, "value must take an array"),
    ],
)
def test_what_is_no_function_of_one_variable(arguments, error, words):
    with pytest.raises(error, match=words):
        univariate(*arguments)


def test_constants_and_kinks_are_functions_where_a_slope_is_given():
    assert univariate(lambda x: 2.0).slope(0.3) == 0
    kink = univariate(lambda x: np.abs(x), lambda x: np.sign(x))
    assert (kink.value(-0.3), kink.slope(-0.3)) == (0.3, -1.0)


def test_powers_are_vectorised():
    assert univariate(lambda x: x**4).slope(1.5) == pytest.approx(13.5, rel=1e-15)


@pytest.mark.parametrize(
    "value", [lambda x: x * np.conj(x), lambda x: x + np.abs(x) ** 2], ids=["x conj(x)", "x + |x|^2"]
)
def test_functions_that_lose_part_of_the_imaginary_part_are_refused(value):
    with pytest.raises(ValueError, match="must be the derivative"):
        univariate(value)


# Families


def deformations(n=40, seed=5):
    """Return random A > B > 0 on both sides of A + B = 2, where the elliptic chart changes its formula."""
    rng = np.random.default_rng(seed)
    A = rng.uniform(0.6, 3.5, n)
    return np.array([A, A * rng.uniform(0.05, 0.9, n)])


RIPPLE = univariate(lambda v: 1.5 / np.cos(v / 2) ** 2 + 0.4 * np.cos(2 * v))
SOFT = univariate(lambda r: 0.6 * r + 0.3 * r * r)
SEXTIC = univariate(
    lambda k: 0.4 * np.sinh(k) ** 2 * np.sinh(k) ** 2 * np.sinh(k) ** 2 + 0.7 * np.sinh(k) ** 2 * np.sinh(k) ** 2
)
SINES = univariate(
    lambda x: 0.4 * np.sin(x) ** 2 * np.sin(x) ** 2 * np.sin(x) ** 2 - 0.7 * np.sin(x) ** 2 * np.sin(x) ** 2
)
FAMILIES = [
    SeparableAlphaBeta(univariate(well), Oscillator(1.2, 0.3)),
    SeparableRVartheta(SOFT, RIPPLE),
    SeparableElliptic(SEXTIC, SINES),
]
NAMED = [
    (P, member)
    for P in (Harmonic(1.2), Anharmonic(0.9), Hyperelastic(1.1), HeavyTop(1.3, 0.6))
    for member in ("alpha_beta", "r_vartheta", "elliptic")
    if hasattr(P, member)
]


@pytest.mark.parametrize("V", [*FAMILIES, *(getattr(P, member) for P, member in NAMED)], ids=lambda V: repr(V)[:60])
def test_slopes_are_the_derivatives_of_value(V):
    q = deformations()
    slopes, expected = np.array(V.slopes(*q)), differences(lambda q: V.value(*q), q, 1e-3)
    np.testing.assert_allclose(slopes, expected, rtol=1e-8, atol=1e-9 * np.abs(V.value(*q)).max())
    assert (V.margin(*q) == 0.5).all()


def test_sextic_of_the_elliptic_chart():
    """s - t = (A + B)/2 - 1 and s t = B/2: (s^3 + t^3)/(s + t) = (s - t)^2 + s t, (s^2 - t^2)/(s + t) = s - t."""
    A, B = deformations()
    sigma = (A + B) / 2 - 1
    expected = (0.4 * (sigma**2 + B / 2) + 0.7 * sigma) / 2
    np.testing.assert_allclose(FAMILIES[2].value(A, B), expected, rtol=1e-12, atol=1e-13)
    slopes = FAMILIES[2].slopes(A, B)
    np.testing.assert_allclose(slopes[0], 0.2 * sigma + 0.175, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(slopes[1], 0.2 * sigma + 0.275, rtol=1e-12, atol=1e-13)


CURVED = [
    SeparableAlphaBeta(Oscillator(1.3, 0.4), Oscillator(0.7)),
    SeparableRVartheta(Spring(1.1, 0.3), Barriers(0.3, 0.7)),
    SeparableElliptic(CoshOscillator(1.3, 0.4), CosOscillator(1.3, 0.4)),
    SeparableElliptic(Oscillator(0.4), CosOscillator(0.9)),
]


@pytest.mark.parametrize("V", [*CURVED, *(getattr(P, member) for P, member in NAMED)], ids=lambda V: repr(V)[:60])
def test_curvatures_are_the_derivatives_of_slopes(V):
    q = deformations()
    V_AA, V_AB, V_BB = np.broadcast_arrays(*V.curvatures(*q), q[0])[:3]
    (slope_A, slope_B), tolerance = (
        zip(*(differences(lambda q, k=k: V.slopes(*q)[k] + 0 * q[0], q, 1e-3) for k in (0, 1))),
        1e-8,
    )
    for found, expected in ((V_AA, slope_A[0]), (V_AB, slope_A[1]), (V_AB, slope_B[0]), (V_BB, slope_B[1])):
        np.testing.assert_allclose(found, expected, rtol=tolerance, atol=tolerance * (1 + np.abs(V_BB).max()))


def test_curvature_of_functions_of_ones_own():
    """Complex step of a given slope; none where the slope is itself one: then tangent vectors are refused with the
    remedy.
    """
    x = np.linspace(0.2, 2.0, 9)
    made = univariate(well, slope_of_well)
    np.testing.assert_allclose(made.curvature(x), complex_step(slope_of_well, x), rtol=1e-14)
    bare = StackelBody(Harmonic(), univariate(well), Zero())
    with pytest.raises(TypeError, match=r"curvature.*univariate\(value, slope, curvature\)"):
        tangent_map(bare, np.ones(8), time=1.0, step=0.1)


def test_tangent_force_of_a_stackel_body():
    ripple = univariate(
        lambda v: 0.3 * np.cos(v) + 0.1 * np.sin(2 * v), lambda v: -0.3 * np.sin(v) + 0.2 * np.cos(2 * v)
    )
    body = StackelBody(CURVED[1], ripple, ripple, 1.2)
    q, direction = np.random.default_rng(3).standard_normal((2, 4, 30))
    expected = differences(lambda t: np.array(body.force(*(q + t * direction))), np.zeros((1, 30)), 1e-3)[0]
    found = np.array(body.tangent_force(*q, *direction))
    size = np.abs(found).max(axis=0)
    assert np.median(np.abs(found - expected) / size) < 1e-10
    near = (q[:2] ** 2).sum(axis=0).clip(max=(q[2:] ** 2).sum(axis=0)) < 0.1  # differences fail next to the axes
    assert (np.abs(found - expected) / size)[:, ~near].max() < 1e-6


@pytest.mark.parametrize(("potential", "member"), NAMED, ids=str)
@pytest.mark.parametrize("ratio", [None, 0.0, 1e-14, 1e-6], ids=["anywhere", "beta=0", "beta=1e-7", "beta=1e-3"])
def test_named_potentials_are_their_members(potential, member, ratio):
    """Value and slopes, on both sides of the elliptic focus, and at beta = 0, where the charts end: rounding over s +
    t, > 0.05 here.
    """
    V = getattr(potential, member)
    A, B = deformations()
    A = A[np.abs(A - 2) > 0.1] if ratio is not None else A
    B = ratio * A if ratio is not None else B
    tolerance = {"rtol": 1e-11, "atol": 1e-11}
    np.testing.assert_allclose(V.value(A, B), potential.value(A, B), **tolerance)
    np.testing.assert_allclose(np.array(V.slopes(A, B)), np.array(potential.slopes(A, B)), **tolerance)
    assert getattr(V, member) is V
    assert (V.margin(A, B) > 0).all()


@pytest.mark.parametrize(
    "V", [Body(Hyperelastic().r_vartheta), Body(SeparableRVartheta(Spring(), Secant()))], ids=["named", "own"]
)
def test_margin_is_negative_where_the_potential_ends(V):
    with np.errstate(all="ignore"):  # inf - inf
        assert V.potential.margin(0.5, 1.1) < 0
        assert V.potential.margin(np.array([1.1, 0.5]), np.array([0.5, 1.1])).tolist() == [0.5, -0.5]
    with pytest.raises(ValueError, match="in the domain of the potential"):
        integrate(V, np.array([0.5, 0, 1.0, 0, 0, 0, 0, 0]), time=1.0, step=0.1)


# Bodies with angular potentials
# --------------------------------------------------------------------------------------------------------

V_ETA = univariate(lambda eta: 0.5 + 0.3 * np.cos(eta) + 0.1 * np.sin(2 * eta))
V_GAMMA = univariate(lambda gamma: 0.4 + 0.2 * np.sin(gamma))
STACKEL = [
    StackelBody(V, V_ETA, V_GAMMA, mu)
    for V, mu in zip((*FAMILIES, Harmonic(1.2).elliptic), (0.8, 1.3, 1.1, 0.7), strict=True)
]
ISOTROPIC = [Body(V, 0.9) for V in FAMILIES]
CASES = [
    *((body, None) for body in (*STACKEL, *ISOTROPIC)),
    *((Body(Anharmonic(0.9), 1.2), chart) for chart in (ALPHA_BETA, R_VARTHETA, ELLIPTIC)),
    *((Body(Harmonic(1.1), 0.7), chart) for chart in (ALPHA_BETA, R_VARTHETA, ELLIPTIC)),
    (Body(Hyperelastic(1.1), 0.8), R_VARTHETA),
    (Body(HeavyTop(1.2, 0.6), 1.1), None),
    (StackelBody(Hyperelastic(1.1), V_ETA, Zero(), 0.8), None),
    (StackelBody(Anharmonic(0.9), Zero(), V_GAMMA, 1.2), ELLIPTIC),
]


def case_name(value):
    if isinstance(value, (Body, StackelBody)):
        return f"{type(value).__name__}({type(value.potential).__name__})"
    return getattr(value, "name", "first")


every_case = pytest.mark.parametrize(("body", "chart"), CASES, ids=case_name)


def states(n=12, seed=3):
    """Return random phase points (8, n), alpha around 1.5, beta around 0.6, all spins."""
    rng = np.random.default_rng(seed)
    radius, angle = np.array([rng.uniform(1.2, 1.8, n), rng.uniform(0.4, 0.8, n)]), rng.uniform(0, 2 * np.pi, (2, n))
    a, b = radius * np.cos(angle), radius * np.sin(angle)
    return np.array([a[0], b[0], a[1], b[1], *(0.5 * rng.standard_normal((4, n)))])


@pytest.mark.parametrize("body", [*STACKEL, *(body for body, _ in CASES[-2:])], ids=case_name)
def test_force_of_a_stackel_body_is_minus_the_gradient(body):
    q = states(40)[:4]
    expected = -differences(lambda q: body.potential_energy(*q), q, 1e-3)
    np.testing.assert_allclose(np.array(body.force(*q)), expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())
    p = states(40)[4:]
    np.testing.assert_allclose(
        np.array(body.velocity(*p)), differences(lambda p: body.kinetic_energy(*p), p), rtol=1e-9, atol=1e-10
    )
    for k in range(4):  # floats as arrays
        np.testing.assert_allclose(
            body.force(*q[:, k].tolist()), np.array(body.force(*q))[:, k], rtol=1e-12, atol=1e-12
        )


def test_force_without_angular_potentials_is_that_of_the_body():
    q = states(40)[:4]
    for V in FAMILIES:
        np.testing.assert_allclose(
            np.array(StackelBody(V, Zero(), Zero(), 0.8).force(*q)),
            np.array(Body(V, 0.8).force(*q)),
            rtol=1e-14,
            atol=1e-15,
        )


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_force_at_beta_zero_without_a_potential_of_gamma():
    """V_gamma = 0: beta = 0 is a point like others, the undeformed body on it."""
    body = StackelBody(Harmonic(1.2).alpha_beta, V_ETA, Zero())
    force = np.array(body.force(*np.array([[1.4], [0.1], [0.0], [0.0]])))
    np.testing.assert_allclose(force[2:], 0.0, atol=1e-100)
    orbit = integrate(body, np.array([sqrt(2), 0, 0, 0, 0, 0, 0, 0]), time=0.1, step=0.05)
    orbit.raise_if_failed()


def test_tori_of_a_stackel_body_without_spin_of_b():
    """The limit p_gamma -> 0 of a bounded orbit: J_alpha, J_beta of p_gamma = 0 differ from those of 1e-9 by 1e-8 at
    most.
    """
    body = StackelBody(SeparableAlphaBeta(Oscillator(), Oscillator()), V_ETA, Zero())
    z = np.array([[1.4, 0.1, 0.3, 0.0, 0.1, 0.2, 0.3, spin] for spin in (0.0, 1e-9)]).T
    found = action_angles(body, z)
    assert np.isfinite(found.J).all()
    np.testing.assert_allclose(found.J[:, 0], found.J[:, 1], atol=1e-7)


# Constants of motion
# -------------------------------------------------------------------------------------------------------------------


def stacked(body, z, chart):
    """Return the constants as an array (4 or 5, orbits)."""
    shape = np.shape(z)[1:]
    return np.array([v.reshape(shape) for v in constants_of_motion(body, np.reshape(z, (8, -1)), chart=chart).values()])


@every_case
def test_energy_is_made_of_the_constants(body, chart):
    z = states()
    constants = constants_of_motion(body, z, chart=chart)
    E = body.kinetic_energy(*z[4:]) + body.potential_energy(*z[:4])
    if "H_alpha" in constants:
        assert separate(body, chart).family.chart == "alpha-beta"
        np.testing.assert_allclose(constants["H_alpha"] + constants["H_beta"], E, rtol=1e-13)
    else:
        np.testing.assert_allclose(constants["E"], E, rtol=1e-12)
    if "K" in constants:
        np.testing.assert_allclose(constants["K"] + constants["L"], E, rtol=1e-12)
    names = ("c_eta", "c_gamma") if isinstance(body, StackelBody) else ("p_phi", "p_psi")
    assert tuple(constants)[-2:] == names == separate(body, chart).constants[2:]


@every_case
def test_constants_are_conserved_to_rounding(body, chart):
    """KAHAN_LI8 with 400 steps of 0.005: the scheme's error is below rounding, 400 steps of some eps."""
    z = states(6)
    orbits = integrate(body, z, time=2.0, step=0.005, scheme=KAHAN_LI8, samples=5)
    orbits.raise_if_failed()
    start = stacked(body, z, chart)
    for sample in orbits.samples:
        assert np.abs(stacked(body, sample, chart) - start).max() < 1e-13 * np.abs(start).max()


def brackets(function, z):
    """Return the Poisson brackets over products of gradients, (pairs, orbits), of the rows of function(z)."""
    gradient = differences(function, z)  # (8, rows, orbits)
    q, p = gradient[:4], gradient[4:]
    size = np.sqrt((gradient**2).sum(axis=0))
    pairs = list(combinations(range(gradient.shape[1]), 2))
    return np.array([(q[:, i] * p[:, j] - p[:, i] * q[:, j]).sum(axis=0) / (size[i] * size[j]) for i, j in pairs])


@every_case
def test_constants_are_in_involution(body, chart):
    """Gradients by differences are right to 1e-11 of themselves, so brackets over |grad F| |grad G| too."""
    z = states()
    assert np.abs(brackets(lambda z: stacked(body, z, chart), z)).max() < 1e-10


@every_case
def test_constants_are_independent(body, chart):
    """Four of them with gradients that span four directions: the smallest singular value of unit gradients."""
    gradient = differences(lambda z: stacked(body, z, chart), states())
    keep = [k for k, name in enumerate(constants_of_motion(body, states(), chart=chart)) if name != "L"]
    gradient = np.moveaxis(gradient[:, keep], 2, 0)
    gradient = gradient / np.linalg.norm(gradient, axis=1, keepdims=True)
    assert np.linalg.svd(gradient, compute_uv=False)[:, -1].max() > 0.03


def separation_constants(body, z):
    """Return h_kappa, h_lambda, cosh^2 kappa, cos^2 lambda of section 3, with V_eta and V_gamma in the numerators."""
    V, mu = body.potential.elliptic, body.mu
    V_eta, V_gamma = (body.V_eta, body.V_gamma) if isinstance(body, StackelBody) else (Zero(), Zero())
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = z
    alpha, beta = np.hypot(a1, a2), np.hypot(b1, b2)
    near, far = np.hypot(alpha - sqrt(2), beta), np.hypot(alpha + sqrt(2), beta)  # distances from the foci
    kappa, lam = np.arccosh((far + near) / sqrt(8)), np.arccos((far - near) / sqrt(8))
    p_alpha, p_beta = (a1 * pa1 + a2 * pa2) / alpha, (b1 * pb1 + b2 * pb2) / beta
    p_kappa = sqrt(2) * (np.sinh(kappa) * np.cos(lam) * p_alpha + np.cosh(kappa) * np.sin(lam) * p_beta)
    p_lambda = sqrt(2) * (-np.cosh(kappa) * np.sin(lam) * p_alpha + np.sinh(kappa) * np.cos(lam) * p_beta)
    of_eta = (a1 * pa2 - a2 * pa1) ** 2 + 2 * mu * V_eta.value(np.arctan2(a2, a1))
    of_gamma = (b1 * pb2 - b2 * pb1) ** 2 + 2 * mu * V_gamma.value(np.arctan2(b2, b1))
    h_kappa = (
        p_kappa**2 + 2 * mu * V.V_kappa.value(kappa) - of_eta / np.cosh(kappa) ** 2 + of_gamma / np.sinh(kappa) ** 2
    )
    h_lambda = p_lambda**2 + 2 * mu * V.V_lambda.value(lam) + of_eta / np.cos(lam) ** 2 + of_gamma / np.sin(lam) ** 2
    return h_kappa / (2 * mu), h_lambda / (2 * mu), np.cosh(kappa) ** 2, np.cos(lam) ** 2


def paper(body, z, sign):
    """Return H, L and K = (h_kappa cos^2 lambda + sign h_lambda cosh^2 kappa)/2 Delta; the paper prints sign = -1."""
    h_kappa, h_lambda, C, c = separation_constants(body, z)
    delta = 2 * (C - c)
    return np.array(
        [
            (h_kappa + h_lambda) / delta,
            (h_kappa * (1 - c) - h_lambda * (C - 1)) / delta,
            (h_kappa * c + sign * h_lambda * C) / delta,
        ]
    )


ELLIPTICS = [(body, chart) for body, chart in CASES if separate(body, chart).family.chart == "elliptic"]
every_elliptic = pytest.mark.parametrize(("body", "chart"), ELLIPTICS, ids=case_name)


@every_elliptic
def test_elliptic_constants_are_those_of_the_chart(body, chart):
    """K = (h_kappa cos^2 lambda + h_lambda cosh^2 kappa)/2 Delta and L, from kappa, lambda and their momenta; H = K +
    L.
    """
    z = states(40)
    E, L, K = paper(body, z, +1)
    constants = constants_of_motion(body, z, chart=chart)
    for name, expected in {"E": E, "K": K, "L": L}.items():
        np.testing.assert_allclose(constants[name], expected, rtol=1e-10, atol=1e-10 * np.abs(E).max())
    np.testing.assert_allclose(K + L, E, rtol=1e-10)


@pytest.mark.parametrize(("C", "wall"), [(0.0, 0.0), (1.3, 0.0), (1.3, 0.5)], ids=["free", "harmonic", "EQa"])
def test_K_of_oscillators(C, wall):
    """K = H_alpha + h_vartheta/2 - C/4: of free motion, of the oscillator and of the one with a wall c/alpha^2."""
    z, mu = states(40), 0.7
    alpha_beta = Body(SeparableAlphaBeta(Oscillator(C, wall), Oscillator(C)), mu)
    shells = Body(SeparableRVartheta(Spring(C), Barriers(wall)), mu)
    elliptic = Body(SeparableElliptic(CoshOscillator(C, wall), CosOscillator(C, wall)), mu)
    K = constants_of_motion(elliptic, z)["K"]
    expected = constants_of_motion(alpha_beta, z)["H_alpha"] + constants_of_motion(shells, z)["h_vartheta"] / 2 - C / 4
    np.testing.assert_allclose(K, expected, rtol=1e-12, atol=1e-12)
    if C == 0:
        free = constants_of_motion(Body(SeparableElliptic(Zero(), Zero()), mu), z)
        np.testing.assert_allclose(free["K"], K, rtol=1e-13)


def test_h_vartheta_of_free_motion_is_angular_momentum_of_R4():
    """h_vartheta = |q|^2 |p|^2 - (q.p)^2 over 2 mu (Lagrange's identity)."""
    z, mu = states(40), 0.7
    q, p = z[:4], z[4:]
    expected = ((q**2).sum(0) * (p**2).sum(0) - (q * p).sum(0) ** 2) / (2 * mu)
    np.testing.assert_allclose(
        constants_of_motion(Body(SeparableRVartheta(Zero(), Zero()), mu), z)["h_vartheta"], expected, rtol=1e-12
    )


def test_constants_at_beta_zero():
    """The undeformed direction b = 0 with momentum: E and K of the charts that hold the body agree there."""
    z = np.array([1.5, 0.2, 0, 0, 0.3, -0.4, 0.2, 0.5])
    for potential in (Harmonic(1.2), Anharmonic(0.9)):
        body = Body(potential, 0.8)
        one, two, three = (constants_of_motion(body, z, chart=chart) for chart in (ALPHA_BETA, R_VARTHETA, ELLIPTIC))
        E = one["H_alpha"] + one["H_beta"]
        np.testing.assert_allclose([two["E"], three["E"]], [E, E], rtol=1e-13)
        np.testing.assert_allclose(three["K"], one["H_alpha"] + two["h_vartheta"] / 2 - potential.C / 4, rtol=1e-13)
    assert constants_of_motion(body, z)["p_phi"].shape == (1,)


def test_elliptic_constants_at_alpha_zero():
    """On alpha = 0 (det phi < 0) cos(lambda) = 0: they are the limits from points nearby."""
    body = Body(Harmonic(1.2), 0.7)
    z = np.array([0.0, 0.0, 0.6, -0.3, 0.2, 0.1, -0.4, 0.5])
    near = z.copy()
    near[0] = 1e-9
    on, beside = (constants_of_motion(body, point, chart="elliptic") for point in (z, near))
    for name, value in on.items():
        np.testing.assert_allclose(value, beside[name], rtol=1e-8, atol=1e-9)


def test_elliptic_constants_of_the_undeformed_body():
    """V(rest) = 2 C; K = H_alpha + h_vartheta/2 - C/4, with h_vartheta = V_vartheta = 2 C: 11/4."""
    constants = constants_of_motion(Body(Anharmonic(1.0)), [sqrt(2), 0, 0, 0, 0, 0, 0, 0], chart=ELLIPTIC)
    assert constants["E"][0] == pytest.approx(2.0, abs=1e-14)
    assert constants["K"][0] == pytest.approx(2.75, abs=1e-14)


# What does not separate
# ----------------------------------------------------------------------------------------------------------------


def test_charts():
    body = Body(Anharmonic())
    assert separate(body).family.chart == "alpha-beta"
    for chart in (ALPHA_BETA, R_VARTHETA, ELLIPTIC):
        assert separate(body, chart).family.chart == separate(body, chart.name).family.chart == chart.name
    assert separate(Body(Hyperelastic())).names == ("r", "vartheta", "phi", "psi")
    assert separate(STACKEL[2]).names == ("kappa", "lambda", "eta", "gamma")
    assert separate(STACKEL[0]).constants == ("H_alpha", "H_beta", "c_eta", "c_gamma")
    assert separate(StackelBody(Harmonic(), Zero(), Zero())).isotropic


@pytest.mark.parametrize(
    ("body", "chart", "error", "words"),
    [
        (Body(NeoHookean()), None, ValueError, "model must be separable, got a Body of NeoHookean.*fit_torus"),
        (
            StackelBody(NeoHookean(), V_ETA, V_GAMMA),
            None,
            ValueError,
            "model must be separable, got a Body of NeoHookean",
        ),
        (StackelBody(3.0, V_ETA, V_GAMMA), None, (TypeError, ValueError), ""),
        (
            Body(Hyperelastic()),
            ALPHA_BETA,
            ValueError,
            r"chart must separate Hyperelastic.* \(r-vartheta\), got 'alpha-beta'",
        ),
        (Body(Harmonic()), TWO_POLAR, ValueError, r"chart must separate Harmonic.* \(alpha-beta.*'two-polar'"),
        (Body(Harmonic()), "parabolic", ValueError, "chart must separate Harmonic.*'parabolic'"),
        (Body(Harmonic()), 3, TypeError, "chart must be a chart.*3"),
        (Harmonic(), None, TypeError, r"is a potential\. Use Body\("),
        (SeparableAlphaBeta(Oscillator(), Oscillator()), None, TypeError, r"is a potential\. Use Body\("),
        (HenonHeiles(), None, TypeError, "model must be a separable Body, got HenonHeiles"),
        ("Harmonic", None, TypeError, "model must be a model"),
        (None, None, TypeError, "model must be a model"),
        (Body(SeparableAlphaBeta(1.0, Oscillator())), None, TypeError, "V_alpha must be a function such as"),
        (Body(SeparableRVartheta(Spring(), 2.0)), None, TypeError, "V_vartheta must be a function such as"),
        (Body(SeparableElliptic(Zero(), np.cos)), None, TypeError, "V_lambda"),
        (StackelBody(Harmonic(), 1.0, Zero()), None, TypeError, "V_eta must be a function of the angle"),
        (StackelBody(Harmonic(), Zero(), np.cos), None, TypeError, "V_gamma"),
        (Body(SeparableAlphaBeta(Oscillator(np.nan), Oscillator())), None, ValueError, "not finite"),
        (Body(Harmonic(), -1.0), None, ValueError, "mu must be positive"),
    ],
)
def test_bad_bodies(body, chart, error, words):
    with pytest.raises(error, match=words or None):
        separate(body, chart)
    with pytest.raises(error, match=words or None):
        constants_of_motion(body, states(1), chart=chart)


@pytest.mark.parametrize("mu", [0.0, -1.0])
def test_stackel_body_needs_inertia(mu):
    with pytest.raises(ValueError, match="mu must be positive"):
        separate(StackelBody(Harmonic(), Zero(), Zero(), mu))


@pytest.mark.parametrize(
    ("z", "error", "words"),
    [
        (np.ones(7), ValueError, "z must have shape"),
        (np.full(8, np.nan), ValueError, "z must be finite"),
        ("state", TypeError, "z must be an array of real numbers"),
        (1j * np.ones(8), TypeError, "z must be an array of real numbers"),
        (np.array([0.5, 0, 1.0, 0, 0, 0, 0, 0]), ValueError, "z must lie in the domain of the potential"),
    ],
)
def test_bad_states(z, error, words):
    with pytest.raises(error, match=words):
        constants_of_motion(Body(Hyperelastic()), z)
