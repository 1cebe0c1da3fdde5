"""Action-angle tori of separable bodies: against the paper, quadratures, orbits, frequency maps and canonical
relations.
"""

import naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from fastaff import (
    SOFRONIOU_SPALETTA10,
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    Hyperelastic,
    NeoHookean,
    SeparableAlphaBeta,
    SeparableElliptic,
    SeparableRVartheta,
    Status,
    action_angles,
    constants_of_motion,
    energy_of_actions,
    from_action_angles,
    integrate,
    univariate,
)
from fastaff.systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA, from_matrix
from fastaff.systems.models import Cosine, Oscillator, StackelBody, Zero

ROOT2 = np.sqrt(2.0)
CHARTS = {
    Harmonic: (ALPHA_BETA, R_VARTHETA, ELLIPTIC),
    Anharmonic: (ALPHA_BETA, R_VARTHETA, ELLIPTIC),
    Hyperelastic: (R_VARTHETA,),
    HeavyTop: (R_VARTHETA,),
}
CASES = [(body, chart) for body in naive.MODELS[:4] for chart in CHARTS[type(body.potential)]]


def quartic(x):
    return 0.02 * x**4 + 0.5 * x**2 + 0.3 / x**2


def bowl(x):
    return 0.4 * x**2 + 0.1 * x**4


def stretch(r):
    return 0.3 * r + 0.05 * r * r + 0.2 / r


def shear(v):
    return 0.3 * np.cos(v) + 0.2 * np.cos(2 * v)


def outer(k):
    return 0.5 * np.cosh(2 * k) ** 2 + 0.2 * np.cosh(k) ** 2


def inner(q):
    return -0.5 * np.cos(2 * q) ** 2 - 0.2 * np.cos(q) ** 2


def around_eta(x):
    return 0.6 + 0.3 * np.cos(x) + 0.1 * np.sin(2 * x)


def around_gamma(x):
    return 0.6 + 0.2 * np.cos(x) ** 2 + 0.05 * np.sin(3 * x)


def double_well(x):
    return 0.5 * (x * x - 2.0) ** 2 / (1 + 0.1 * x * x) + 0.05 / (x * x)


USER = (
    (Body(SeparableAlphaBeta(univariate(quartic), univariate(bowl)), mu=0.9), ALPHA_BETA),
    (Body(SeparableRVartheta(univariate(stretch), univariate(shear)), mu=1.2), R_VARTHETA),
    (Body(SeparableElliptic(univariate(outer), univariate(inner))), ELLIPTIC),
)
ANGULAR = tuple(
    (StackelBody(potential, univariate(around_eta), univariate(around_gamma), mu=0.9), chart)
    for potential, chart in (
        (Anharmonic(0.9), ALPHA_BETA),
        (Hyperelastic(0.9), R_VARTHETA),
        (Anharmonic(0.9), ELLIPTIC),
    )
)


def name(case):
    if hasattr(case, "mu"):
        return f"{type(case).__name__}-{type(case.potential).__name__}"
    return getattr(case, "name", str(case))


def primitive(found):
    """Rows of the coordinates, then of eta and gamma: nu and theta."""
    nu = np.array([found.nu[0], found.nu[1], found.nu_eta, found.nu_gamma])
    return nu, np.array([found.theta[0], found.theta[1], found.theta_eta, found.theta_gamma])


def turned(difference):
    """Difference of angles in cycles, brought next to 0."""
    return difference - np.round(difference)


# Martens & Slawianowski's models at mu = C = 1 (heavy top A = 0.5): mpmath quadrature with 40 digits, confirmed to
# 7e-10 by weighted averages along DOP853 orbits; points are (x, y, z, u, px, py, pz, pu).
POINTS = np.array(
    [
        [1.3, 0.2, -0.1, 0.8, 0.3, -0.4, 0.5, 0.2],
        [1.0, 0.5, -0.3, 1.4, -0.2, 0.6, 0.1, -0.5],
        [1.7, -0.2, 0.5, 0.8, 0.2, -0.9, -0.3, -0.4],
    ]
).T
REFERENCE = {
    ("Harmonic", "alpha-beta"): (
        ("J_1", 1.1623892818282234982, 2.8431413514987628808, 3.0316369107141504751),
        ("J_2", 0.15707963267948966192, 0.078539816339744830962, 0.14137166941154069573),
        ("c_1", 1.39, 1.785, 1.785),
        ("c_2", 0.07, 0.195, 0.675),
        ("nu_1", 0.31830988618379067154, 0.31830988618379067154, 0.31830988618379067154),
        ("nu_2", 0.31830988618379067154, 0.31830988618379067154, 0.31830988618379067154),
        ("nu_phi", 0.15915494309189533577, -0.15915494309189533577, 0.0),
        ("nu_psi", 0.0, 0.0, -0.15915494309189533577),
    ),
    ("Harmonic", "r-vartheta"): (
        ("J_1", 1.2786416356479199891, 2.0276511752928189187, 1.2903521246928565614),
        ("J_2", 0.040827278859793171017, 0.89402999254568879307, 1.8826564554328346094),
        ("c_1", 1.46, 1.98, 2.46),
        ("c_2", 0.5544, 0.89055, 2.09975),
    ),
    ("Anharmonic", "alpha-beta"): (
        ("J_1", 0.10620270679214211661, 0.70673254072442811886, 0.68140613457390994008),
        ("J_2", 0.15707963267948966192, 0.078539816339744830962, 0.14137166941154069573),
        ("c_1", 2.2788888888888888889, 2.41, 2.3784718100890207715),
        ("c_2", 0.07, 0.195, 0.675),
        ("nu_phi", 0.11573159247222921162, -0.11162639216315601897, -0.049389496610530005353),
        ("nu_psi", 0.043423350619666124145, -0.047528550928739316799, -0.10976544648136533042),
    ),
    ("Anharmonic", "r-vartheta"): (
        ("J_1", 0.11958196070852592030, 0.54900305189417347289, 0.30850803549362155604),
        ("J_2", 0.14370037876310585823, 0.23626930516999947693, 0.51426976849182907977),
        ("c_1", 2.3488888888888888889, 2.605, 3.0534718100890207715),
        ("c_2", 2.6699555555555555556, 2.95305, 4.3668123145400593472),
        ("nu_1", 0.31830988618379067154, 0.31830988618379067154, 0.31830988618379067154),
        ("nu_2", 0.31830988618379067154, 0.31830988618379067154, 0.31830988618379067154),
    ),
    ("Hyperelastic", "r-vartheta"): (
        ("J_1", 0.11654763974648289297, 0.52681407261789755010, 0.23157949489354572544),
        ("J_2", 0.21935131218822779885, 0.093110717197664012040, 0.095626340143930200878),
        ("J_phi", 6.5345127194667699360, -6.5973445725385658008, 1.1938052083641214306),
        ("J_psi", -6.2831853071795864769, 4.4610615680975063986, -9.1106186954104003915),
        ("c_1", 2.4033962264150943396, 2.6251612903225806452, 3.1449315068493150685),
        ("c_2", 2.7996830188679245283, 3.0195822580645161290, 4.7161883561643835616),
        ("nu_1", 0.31830988618379067154, 0.31830988618379067154, 0.31830988618379067154),
        ("nu_2", 0.43310631540450606680, 0.44684892444546547336, 0.48351122512896520210),
        ("nu_phi", 0.14324822812309199101, -0.13916269262706489412, -0.085055932018638540893),
        ("nu_psi", 0.072674021217335999060, -0.078587541024214583502, -0.13532404425669438526),
    ),
    ("HeavyTop", "r-vartheta"): (
        ("J_1", 0.73223297231174915365, 1.4857861623648757107, 1.0432330800035401266),
        ("J_2", 0.25846636412280856300, 1.6004527850016278674, 2.4095193636879953750),
        ("c_1", 1.6471336770002118494, 2.1223324150596877870, 2.5600520819056495162),
        ("c_2", 0.99977815126050420168, 1.3602469696969696970, 2.4819489528795811518),
        ("nu_2", 0.13928719665643554007, 0.27179704981362459310, 0.31569571506030090303),
        ("nu_phi", 0.084162497813912671869, -0.14476612603601616510, 0.010586928999729569527),
        ("nu_psi", -0.065656794013653051613, 0.020246313190522229580, -0.15761346039988382364),
    ),
}
MODELS = {
    "Harmonic": Harmonic(),
    "Anharmonic": Anharmonic(),
    "Hyperelastic": Hyperelastic(),
    "HeavyTop": HeavyTop(1.0, 0.5),
}


@pytest.mark.parametrize(("model", "chart"), REFERENCE)
def test_reference_values(model, chart):
    z = from_matrix(POINTS[:4].reshape(2, 2, 3), POINTS[4:].reshape(2, 2, 3))
    found = action_angles(Body(MODELS[model]), z, chart=ALPHA_BETA if chart == "alpha-beta" else R_VARTHETA)
    rows = {"J_1": found.J[0], "J_2": found.J[1], "J_phi": found.J[2], "J_psi": found.J[3]}
    rows |= {"nu_1": found.nu[0], "nu_2": found.nu[1], "nu_phi": found.nu[2], "nu_psi": found.nu[3]}
    rows |= {"c_1": found.constants[0], "c_2": found.constants[1]}
    for row, *values in REFERENCE[model, chart]:
        np.testing.assert_allclose(rows[row], values, rtol=1e-13, atol=1e-14, err_msg=row)
    found.raise_if_failed()


@pytest.mark.parametrize(("body", "chart"), CASES, ids=name)
def test_frequencies_of_random_states(body, chart):
    z = naive.states(body, 300)
    separable = naive.alpha_beta_frequencies if hasattr(body.potential, "alpha_beta") else naive.r_vartheta_frequencies
    truth = separable(body, z)
    found = action_angles(body, z, chart=chart)
    found.raise_if_failed()
    gap = np.abs(primitive(found)[0] - truth) / np.abs(truth).max(axis=0)
    assert np.median(gap) < 1e-13
    assert gap.max() < (
        1e-10 if chart is ELLIPTIC else 1e-11
    )  # separation constants that are small differences lose digits
    assert np.all(found.error < 1e-8)


@pytest.mark.parametrize(("body", "chart"), [*CASES, *USER, *ANGULAR], ids=name)
def test_actions_are_constant_and_angles_advance_with_nu(body, chart):
    z = naive.states(body, 40)
    z = z[:, (z[2:4] ** 2).sum(axis=0) > 0.05]
    orbits = integrate(body, z, time=3.7, step=0.004, scheme=SOFRONIOU_SPALETTA10)
    before, after = action_angles(body, z, chart=chart), action_angles(body, orbits.z, chart=chart)
    good = (before.status == 0) & (after.status == 0)
    assert good.sum() >= 0.9 * good.size  # the rest is too close to a separatrix of V_eta or V_gamma
    np.testing.assert_allclose(after.J[:, good], before.J[:, good], rtol=0, atol=2e-13)
    np.testing.assert_allclose(after.constants[:, good], before.constants[:, good], rtol=0, atol=2e-12)
    (nu, start), (_, end) = primitive(before), primitive(after)
    assert np.abs(turned(end - start - 3.7 * nu))[:, good].max() < 2e-10
    constants = constants_of_motion(body, z, chart=chart)
    np.testing.assert_allclose(
        [constants[key] for key in before.constant_names], before.constants, rtol=1e-12, atol=1e-13
    )


def test_functions_of_a_coordinate_serve_as_those_of_an_angle():
    """Their form in the regular variable belongs to the coordinate, so an angle's potential is value(x) of it."""
    rng = np.random.default_rng(41)
    z, k = rng.uniform(-0.9, 0.9, (8, 12)), rng.uniform(0.05, 0.2)
    named, plain = (
        action_angles(StackelBody(Harmonic(1.2), V, Zero(), mu=0.9), z)
        for V in (Cosine(k), univariate(lambda x: k * np.cos(x)))
    )
    np.testing.assert_array_equal(named.status, plain.status)
    for rows in ("J", "nu", "constants"):
        np.testing.assert_allclose(getattr(named, rows), getattr(plain, rows), rtol=1e-12, atol=1e-13)


def brackets(body, chart, z, step=2e-4):
    """{theta_i, J_j} (4, 4) of one state by sixth-order differences of the primitive angles and actions."""
    weights = np.array([-1, 9, -45, 45, -9, 1]) / 60 / step
    shifts = np.array([-3, -2, -1, 1, 2, 3]) * step
    points = (z[:, None, None] + np.eye(8)[:, :, None] * shifts).reshape(8, -1)
    found = action_angles(body, points, chart=chart)
    found.raise_if_failed()
    J = np.array([found.J[0], found.J[1], found.J_eta, found.J_gamma])
    _, theta = primitive(found)
    theta = theta.reshape(4, 8, 6)
    grad_J, grad_theta = J.reshape(4, 8, 6) @ weights, turned(theta - theta[:, :, :1]) @ weights
    return grad_theta[:, :4] @ grad_J[:, 4:].T - grad_theta[:, 4:] @ grad_J[:, :4].T, grad_theta, grad_J


@pytest.mark.parametrize(("body", "chart"), [*CASES, *USER, *ANGULAR], ids=name)
def test_angles_and_actions_are_canonical(body, chart):
    z = from_matrix(POINTS[:4, 2].reshape(2, 2), POINTS[4:, 2].reshape(2, 2))
    cross, grad_theta, grad_J = brackets(body, chart, z)
    # Differences: rounding 1e-13/step over gradients of order 10.
    np.testing.assert_allclose(cross, np.eye(4), atol=1e-7)
    for rows in (grad_theta, grad_J):
        np.testing.assert_allclose(rows[:, :4] @ rows[:, 4:].T - rows[:, 4:] @ rows[:, :4].T, 0, atol=1e-6)


@pytest.mark.parametrize(("body", "chart"), [case for case in [*CASES, *USER] if case[1] is not ELLIPTIC], ids=name)
def test_round_trip_and_energy_of_actions(body, chart):
    z = naive.states(body, 300)
    found = action_angles(body, z, chart=chart)
    back = from_action_angles(body, found.J, found.theta, chart=chart)
    np.testing.assert_allclose(back, z, rtol=0, atol=1e-11)
    result = energy_of_actions(body, found.J, chart=chart)
    assert result.names == found.names
    np.testing.assert_allclose(result.energy, naive.energy(body, z), rtol=1e-13)
    np.testing.assert_allclose(result.nu, found.nu, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.energy, naive.energy(body, z), rtol=1e-13)


@pytest.mark.parametrize(("body", "chart"), [case for case in [*CASES, *USER] if case[1] is not ELLIPTIC], ids=name)
def test_gradient_of_the_energy_is_the_frequency(body, chart):
    J = action_angles(body, naive.states(body, 20), chart=chart).J
    J[:2] += 0.1
    step, weights, shifts = 1e-3, np.array([-1, 9, -45, 45, -9, 1]) / 60, (-3, -2, -1, 1, 2, 3)
    spins = (
        np.abs(np.array([J[2] - J[3], J[2] + J[3]])).min(axis=0) > 0.1
    )  # no border between regions within the differences
    for row in range(4):
        moved = [energy_of_actions(body, J + k * step * np.eye(4)[row][:, None], chart=chart).energy for k in shifts]
        slope = np.tensordot(weights, np.array(moved), 1) / step
        np.testing.assert_allclose(
            slope[spins], energy_of_actions(body, J, chart=chart).nu[row][spins], rtol=0, atol=1e-10
        )


def test_turning_points_name_the_well():
    """Two wells of V_alpha: the turning points are those of the well an orbit is in, and the orbit stays between
    them.
    """
    body = Body(SeparableAlphaBeta(univariate(double_well), Oscillator(1.0)))
    z = np.zeros((8, 2))
    z[0], z[2], z[6], z[7], z[4], z[5] = (0.45, 1.5), 0.3, 0.2, 0.3, 0.1, 0.02
    found = action_angles(body, z)
    found.raise_if_failed()
    low, high = found.turning_points[0]
    assert np.all((low < z[0]) & (z[0] < high))
    walls = univariate(lambda x: double_well(x) + 0.0)
    # On the ends p_alpha = 0: H_alpha = V_alpha + p_eta^2/(2 mu alpha^2).
    p_eta = (found.J_eta / (2 * np.pi)) ** 2 / 2
    for end in (low, high):
        np.testing.assert_allclose(walls.value(end) + p_eta / end**2, found.constants[0], rtol=1e-12)
    path = integrate(body, z, time=40.0, step=0.005, samples=2000).samples
    alpha = np.hypot(path[:, 0], path[:, 1])
    assert np.all(alpha >= low * (1 - 1e-9))
    assert np.all(alpha <= high * (1 + 1e-9))


def test_several_wells_need_a_hint():
    def wells(x):
        return 2.0 * np.cos(3 * x) + 0.2 * x * x + 0.3 / (x * x)

    body = Body(SeparableAlphaBeta(univariate(wells), Oscillator(1.0)))
    z = np.zeros((8, 2))
    z[0], z[5], z[2], z[7] = (1.1, 3.1), 0.2, 0.3, 0.2
    found = action_angles(body, z)
    found.raise_if_failed()
    with pytest.raises(ValueError, match=r"guess must be given.*wells"):
        from_action_angles(body, found.J, found.theta)
    for k in range(2):
        back = from_action_angles(body, found.J[:, k], found.theta[:, k], guess=z[:, k])
        np.testing.assert_allclose(back, z[:, k], atol=1e-11)


@pytest.mark.parametrize(("body", "chart"), [case for case in CASES if case[1] is not ELLIPTIC], ids=name)
def test_small_angular_momenta_have_limits(body, chart):
    """p -> 0 changes nothing but the angle's own frequency, which has the sign of p on orbits through the axis."""
    z = np.array([ROOT2, 0.1, 0.3, 0.0, 0.2, 0.3, 0.1, 0.0])
    states = np.repeat(z[:, None], 4, axis=1)
    states[7] = (1e-5, 1e-9, -1e-9, 0.0)
    found = action_angles(body, states, chart=chart)
    through = not isinstance(body.potential, HeavyTop) or found.status[3] == Status.SEPARATRIX
    np.testing.assert_allclose(
        found.J[:2, 1:], found.J[:2, 1:2] * np.ones(3), atol=2 * np.pi * 1e-9
    )  # dJ_i/dJ_gamma >= -1
    np.testing.assert_allclose(found.nu[:2, 1:], found.nu[:2, 1:2] * np.ones(3), rtol=1e-8)
    np.testing.assert_allclose(found.nu_eta[1:], found.nu_eta[1] * np.ones(3), rtol=1e-8)
    assert found.nu_gamma[1] == pytest.approx(-found.nu_gamma[2], rel=1e-8)
    if through:
        assert found.status.tolist() == [0, 0, 0, Status.SEPARATRIX]
        assert np.isnan(found.nu_gamma[3])
        assert not np.isnan(found.J[:, 3]).any()
        assert found.nu_gamma[1] == pytest.approx(found.nu[1, 1] / 2, rel=1e-8)  # two librations to a turn
    else:
        assert found.nu_gamma[3] == 0.0
        assert found.status[3] == Status.OK


def test_p_eta_zero_without_the_axis_is_regular():
    z = np.array([ROOT2, 0, 0.2, 0, 0.1, 0, 0.1, 0.2])
    for potential in (Anharmonic(), Hyperelastic()):
        found = action_angles(Body(potential), z)
        assert found.status[0] == Status.OK
        assert found.nu_eta[0] == 0.0


STIFF = [
    case for case in CASES if isinstance(case[0].potential, (Anharmonic, Hyperelastic)) and case[1] is not ELLIPTIC
]
"""Bodies whose undeformed state is a stable equilibrium."""


@pytest.mark.parametrize(("body", "chart"), STIFF, ids=name)
@pytest.mark.parametrize("size", 10.0 ** -np.arange(2, 13, 2))
def test_small_oscillations_about_the_undeformed_body(body, chart, size):
    """Frequencies go to those of the normal modes: sqrt2 omega for the shear of EQ2.2h, omega for EQa, 2 omega for the
    dilatation.
    """
    rng = np.random.default_rng(3)
    z = np.zeros((8, 50))
    z[0] = ROOT2
    z[2:4], z[6:8] = size * rng.standard_normal((2, 2, 50))
    found = action_angles(body, z, chart=chart)
    assert np.isin(found.status, (Status.OK, Status.ACTION_ZERO)).all()
    omega = np.sqrt(body.potential.C / body.mu)
    shear = np.sqrt(2) if isinstance(body.potential, Hyperelastic) else 1.0
    # nu counts full librations of beta^2, two to a turn of the plane.
    np.testing.assert_allclose(found.nu[1], shear * omega / np.pi, rtol=max(30 * size**2, 1e-8))
    np.testing.assert_allclose(np.abs(found.nu_gamma), shear * omega / (2 * np.pi), rtol=max(30 * size**2, 1e-8))
    np.testing.assert_allclose(found.nu[0], omega / np.pi, rtol=1e-12)


def test_vanishing_actions():
    """Circular orbits and equilibria: J = 0 exactly, frequencies at their limits, no angle for that action."""
    harmonic = Body(Harmonic())
    circle = np.array([1.0, 0, 0.5, 0, 0, 1.0, 0, -0.5])  # both planes turn at constant radius
    found = action_angles(harmonic, circle)
    assert found.status[0] == Status.ACTION_ZERO
    assert found.J[:2, 0].tolist() == [0.0, 0.0]
    assert np.isnan(found.theta[:2, 0]).all()
    np.testing.assert_allclose(found.nu[:, 0], [1 / np.pi, 1 / np.pi, 0.0, -1 / (2 * np.pi)], atol=1e-15)
    for potential, chart, shear in (
        (Anharmonic(), ALPHA_BETA, 1.0),
        (Anharmonic(), R_VARTHETA, 1.0),
        (Hyperelastic(), R_VARTHETA, ROOT2),
    ):
        rest = action_angles(Body(potential), np.array([ROOT2, 0, 0, 0, 0, 0, 0, 0]), chart=chart)
        assert rest.status[0] in (Status.ACTION_ZERO, Status.SEPARATRIX)
        assert np.abs(rest.J).max() == 0.0
        np.testing.assert_allclose(rest.nu[:2, 0], [1 / np.pi, shear / np.pi], rtol=1e-11)


def test_circular_limit_of_the_quadrature():
    """A narrowing libration: nu goes to its limit smoothly, without noise, though F is a small difference there."""
    body = Body(SeparableAlphaBeta(univariate(quartic), univariate(bowl)))
    # Circular orbit in plane a at alpha = 1: p_eta^2/mu = V'(1) alpha^3; V'(1) = 0.08 + 1 - 0.6 = 0.48.
    sizes = 10.0 ** -np.arange(1.0, 12.0)
    z = np.zeros((8, sizes.size))
    z[0], z[5], z[4] = 1.0, np.sqrt(0.48), sizes
    z[2], z[6], z[7] = 0.4, 0.1, 0.3
    found = action_angles(body, z)
    found.raise_if_failed()
    # Radial frequency of small oscillations: omega^2 = V'' + 3 V'/alpha at alpha = 1, V'' = 0.24 + 1 + 1.8.
    limit = np.sqrt(0.24 + 1.0 + 1.8 + 3 * 0.48) / (2 * np.pi)
    gaps = np.abs(found.nu[0] / limit - 1)
    assert np.all(gaps < np.maximum(5 * sizes**2, 3e-12))
    np.testing.assert_allclose(found.J[0], sizes**2 / 2 / limit, rtol=1e-2, atol=1e-15)


def test_narrow_shear_next_to_the_wall():
    """A narrow libration whose fitting interval would reach the pole of EQ2.2h at s = 1/2; values by mpmath quadrature,
    50 digits.
    """
    z = [
        2.451019240714001,
        0,
        2.0012488298310527,
        0,
        -0.10006244149155263,
        0.12239805996488533,
        0.12255096203570004,
        2.8284282268446446,
    ]
    found = action_angles(Body(Hyperelastic()), z)
    np.testing.assert_allclose([found.nu[1, 0], found.J[1, 0]], [0.77828, 0.0160648], rtol=1e-5)
    later = integrate(Body(Hyperelastic()), z, time=3.0, step=0.002, scheme=SOFRONIOU_SPALETTA10).z
    assert (
        abs(turned(action_angles(Body(Hyperelastic()), later).theta[1] - found.theta[1] - 3 * found.nu[1])[0]) < 1e-10
    )


def quartic_spring(strength):
    """x^2/2 + strength x^4 as a function of one variable."""
    return univariate(lambda x: 0.5 * x * x + strength * x**4)


def test_units_do_not_matter():
    """V = x^2/2 + K x^4: lengths scale with K^(-1/2), actions with 1/K, frequencies stay."""
    z = np.array([1.0, 0.1, 0.5, 0.2, 0.3, 0.9, 0.2, -0.4])
    first = None
    for K in (1e-6, 1.0, 1e6, 1e12):
        found = action_angles(Body(SeparableAlphaBeta(quartic_spring(K), quartic_spring(K))), z / np.sqrt(K))
        values = np.concatenate([found.J[:, 0] * K, found.nu[:, 0], found.theta[:, 0]])
        first = values if first is None else first
        np.testing.assert_allclose(values, first, rtol=1e-12)


def test_a_constant_in_the_potential_costs_only_its_digits():
    z = [2.0, 0, 3e-4, 1e-3, 0.1, 1.5, 1e-3, 2e-4]
    plain = action_angles(Body(SeparableAlphaBeta(Oscillator(1.0), univariate(lambda x: np.cosh(x)))), z).nu[1, 0]
    raised = action_angles(Body(SeparableAlphaBeta(Oscillator(1.0), univariate(lambda x: 1000.0 + np.cosh(x)))), z).nu[
        1, 0
    ]
    assert raised == pytest.approx(plain, rel=1e-8)


def test_motion_through_the_axis_keeps_its_energy():
    """Exactly on beta = 0 the energy of the motion through it is |p_b|^2/2 mu, not a difference: J_vartheta ~ p^2."""
    ratios = [
        action_angles(Body(HeavyTop(1.0, -1.0)), [2.0, 0, 0, 0, 0.1, 1.5, p, 0]).J[1, 0] / p**2
        for p in (1e-3, 1e-5, 1e-7)
    ]
    np.testing.assert_allclose(ratios, 1.742642062, rtol=1e-7)  # mpmath


def test_unbound_motion_has_a_status():
    falling = Body(SeparableAlphaBeta(univariate(lambda x: -1 / (1 + x * x)), Oscillator(1.0)))
    z = np.array([[1.0, 0, 0.3, 0, 2.0, 0.1, 0.1, 0.2], [1.0, 0, 0.3, 0, 0.1, 0.3, 0.1, 0.2]]).T
    found = action_angles(falling, z)
    assert found.status.tolist() == [Status.UNBOUND, Status.OK]
    assert np.isnan(found.J[:, 0]).all()
    alone = action_angles(falling, z[:, 1])
    np.testing.assert_array_equal(alone.J[:, 0], found.J[:, 1])
    # h_vartheta < 0: the body falls to D1 = D2 = 0.
    collapsing = action_angles(Body(HeavyTop(1.0, -3.0)), np.array([1.0, 0, 0.1, 0, 0.1, 0, 0.1, 0.0]))
    assert collapsing.status[0] == Status.UNBOUND


@pytest.mark.parametrize(
    ("J", "E"),  # mpmath with 30 digits: J_vartheta by quadrature in pieces towards the wall, h_vartheta by its root
    [(100, 402.84321591150942048), (200, 802.82383188069327856), (10000, 40002.800726096682987)],
)
def test_actions_next_to_the_wall_at_det_0(J, E):
    found = energy_of_actions(Body(Hyperelastic(1.0)), 2 * np.pi * np.array([1, J, 0.5, 0.3]))
    assert found.status == Status.OK
    assert found.energy == pytest.approx(E, rel=1e-11)
    # nu = dE/dJ is twice that of r for a hard wall: EQ3 of an oscillator cut in half.
    assert found.nu[1] == pytest.approx(2 / np.pi, rel=2 / J)


def test_all_actions_of_the_hyperelastic_body_are_of_tori():
    J = 2 * np.pi * np.array([[1.0, J, 0.5, 0.3] for J in np.geomspace(0.1, 3e5, 60)]).T
    found = energy_of_actions(Body(Hyperelastic(0.7), mu=1.4), J)
    assert (found.status == Status.OK).all(), found.status
    assert (np.diff(found.energy) > 0).all()
    slopes = np.diff(found.energy) / np.diff(J[1])
    assert (slopes[:-1] < slopes[1:] * (1 + 1e-9)).all()


@pytest.mark.parametrize("width", [0.03, 4e-3, 6e-4, 2e-4])
@pytest.mark.parametrize("height", [0.9, 0.2, -0.6])
def test_narrow_barriers_and_wells_are_seen(width, height):
    """A Gaussian on an oscillator: the orbit that it stops and the one that passes, by quadrature with cuts at the
    feature.
    """
    at, k, mu = 1.17, 1.3, 0.8
    V = univariate(lambda x: 0.5 * k * x * x + height * np.exp(-(((x - at) / width) ** 2)))
    body = Body(SeparableAlphaBeta(V, Oscillator(1.0)), mu=mu)
    for p in (0.5, 1.9):
        z = np.array([0.6, 0.0, 0.3, 0.1, p, 0.4, 0.2, 0.3])
        spin = z[0] * z[5]

        E = p * p / (2 * mu) + V.value(0.6) + 0.4**2 / (2 * mu)

        def momentum2(x, spin=spin, E=E):
            return 2 * mu * (E - V.value(x)) - spin**2 / x**2

        found = action_angles(body, z)
        found.raise_if_failed()
        ends = []
        for side in (-1, 1):
            x = 0.6 + side * np.arange(1, 40000) * 1e-4
            x = x[(x > 1e-3)]
            out = np.flatnonzero(momentum2(x) < 0)[0]
            ends.append(brentq(momentum2, x[out - 1] if out else 0.6, x[out], xtol=1e-15))
        middle, half = sum(ends) / 2, (ends[1] - ends[0]) / 2
        places = at + width * np.array([-6, -3, -1.5, 0, 1.5, 3, 6])
        cuts = [np.arccos((middle - x) / half) for x in places if ends[0] < x < ends[1]]

        def slice_of(c, middle=middle, half=half, momentum2=momentum2):
            return half * np.sin(c) * np.sqrt(max(momentum2(middle - half * np.cos(c)), 0.0))

        J = 2 * sum(
            quad(slice_of, a, b, epsabs=1e-13, limit=200)[0] for a, b in zip([0, *cuts], [*cuts, np.pi], strict=True)
        )
        assert found.J[0, 0] == pytest.approx(J, rel=1e-10)


def test_tori_of_actions_are_finite_or_unbound():
    """UNBOUND where h_vartheta < 0 lets r fall to 0."""
    rng = np.random.default_rng(12)
    body = Body(HeavyTop(C=0.7, A=1.6), mu=1.3)
    J = rng.choice([0.0, 1e-12, 1e-6, 1e-3, 0.01, 0.1, 1.0, 5.0], size=(4, 60)) * np.array([[1], [1], [1], [-1]])
    together = energy_of_actions(body, J)
    good = together.status == Status.OK
    assert np.isfinite(together.nu[:, good]).all()
    assert np.isnan(together.nu[:, ~good]).all()
    for k in np.flatnonzero(J[2] * J[3] != 0):
        a, c = (((J[3, k] + sign * J[2, k]) / (4 * np.pi)) ** 2 / (2 * body.mu) for sign in (-1, 1))

        def squared(v, a=a, c=c):
            """(dJ/dvartheta)^2/2 mu at h_vartheta = 0."""
            return -(1.6 * np.cos(v) + a / np.cos(v / 2) ** 2 + c / np.sin(v / 2) ** 2)

        v = np.linspace(0, np.pi, 40001)[1:-1]
        at_zero = np.sqrt(2 * body.mu * np.maximum(squared(v), 0)).sum() * (v[1] - v[0])
        if abs(J[1, k] - at_zero) > 1e-3 * at_zero + 1e-3:
            assert (together.status[k] == Status.UNBOUND) == (J[1, k] < at_zero), (k, J[:, k])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-2, 2, allow_nan=False, width=32), min_size=8, max_size=8))
def test_every_bound_state_has_values_or_a_status(numbers):
    z = np.array(numbers, dtype=float)
    for potential in (Harmonic(), Anharmonic(), HeavyTop(1.0, 0.5)):
        if (potential.margin(z[0] ** 2 + z[1] ** 2, z[2] ** 2 + z[3] ** 2)) <= 1e-9:
            continue
        found = action_angles(Body(potential), z)
        values = np.concatenate([found.J[:, 0], found.nu[:, 0], found.theta[:, 0]])
        assert found.status[0] != Status.OK or np.isfinite(values).all()
        if found.status[0] == Status.OK:
            assert np.all(found.J[:2, 0] >= 0)


def test_wrong_input_is_named():
    body, z = Body(Hyperelastic()), naive.states(naive.MODELS[2], 3)
    found = action_angles(body, z)
    for call, message in (
        (lambda: action_angles(Body(NeoHookean()), z), "model must be separable, got a Body of NeoHookean"),
        (
            lambda: action_angles(body, z, chart=ALPHA_BETA),
            r"chart must separate Hyperelastic \(r-vartheta\), got 'alpha-beta'",
        ),
        (lambda: action_angles(body, z[:7]), "z0 must have shape"),
        (lambda: action_angles(body, z, threads=0), "threads must be at least 1"),
        (lambda: from_action_angles(body, -found.J, found.theta), "must not be negative"),
        (lambda: from_action_angles(body, found.J[:3], found.theta), "J must have shape"),
        (lambda: from_action_angles(body, found.J, found.theta[:, :2]), "theta must have as many orbits"),
        (lambda: from_action_angles(body, found.J * np.nan, found.theta), "J must be finite"),
        (
            lambda: from_action_angles(Body(Harmonic()), found.J, found.theta, chart=ELLIPTIC),
            "alpha-beta or r-vartheta",
        ),
        (
            lambda: action_angles(Body(SeparableAlphaBeta(np.cos, Zero())), z),
            r"V_alpha must be a function|must be a float or a NamedTuple",
        ),
    ):
        with pytest.raises((ValueError, TypeError), match=message):
            call()
    # Its wells end: -1/x^2 at infinity would have tori of any action.
    bounded = Body(SeparableAlphaBeta(univariate(lambda x: -1 / (1 + x * x) ** 2), Oscillator(1.0)))
    with pytest.raises(ValueError, match=r"J must be the actions of a torus, got J = .* of orbit 0: UNBOUND"):
        from_action_angles(bounded, [50.0, 1.0, 1.0, 0.5], [0, 0, 0, 0])
    energies = energy_of_actions(bounded, np.array([[50.0, 1.0, 1.0, 0.5], [0.1, 1.0, 1.0, 0.5]]).T)
    assert energies.status[0] in (Status.UNBOUND, Status.NOT_CONVERGED)
    assert energies.status[1] == Status.OK
    assert np.isnan(energies.energy[0])
    assert np.isfinite(energies.energy[1])
