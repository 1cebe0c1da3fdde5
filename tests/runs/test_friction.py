"""Friction in proportion to the momenta: closed forms, orders, dissipated volumes, and words for what is wrong."""

from math import log2
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import fastaff as fa
from fastaff.systems.models.contracts import Kind

CUBIC = "(x**2 + y**2)/2 + x**2*y - y**3/3"
DAMPED = fa.hamiltonian(CUBIC, friction=0.02)
Z0 = fa.energy_sample(fa.HenonHeiles(), energy=0.12, section="x=0", orbits=20, seed=1).z0
OMEGA = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])


def coupled(seed):
    """Two coupled oscillators of random masses, stiffnesses, friction and units: model, matrix of z' = A z, starts and
    their sizes.
    """
    rng = np.random.default_rng(seed)
    length, mass, rate = 10.0 ** rng.uniform(-4, 4, 3)
    k, (m1, m2), g = mass * rate**2 * rng.uniform(0.5, 3, 3), mass * rng.uniform(0.5, 2, 2), rate * rng.uniform(0.01, 3)
    text = "a*x**2/2 + b*(x - y)**2/2 + c*y**2/2"
    model = fa.hamiltonian(text, masses=(m1, m2), a=k[0], b=k[1], c=k[2], friction=g)
    stiff = np.array([[k[0] + k[1], -k[1]], [-k[1], k[1] + k[2]]])
    A = np.block([[np.zeros((2, 2)), np.diag([1 / m1, 1 / m2])], [-stiff, -g * np.eye(2)]])
    size = np.repeat([length, mass * length * rate], 2)[:, None]
    return model, A, size * rng.normal(size=(4, 30)), size, rate


# --- solutions ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_coupled_oscillators_and_their_errors(seed):
    """Any units, under- and overdamped: by the matrix exponential; errors cover the truth."""
    model, A, z0, size, rate = coupled(seed)
    run = fa.integrate(model, z0, time=6.0 / rate, samples=3, accuracy=1e-10)
    exact = expm(A * 6.0 / rate) @ z0
    assert run.scheme == fa.KAHAN_LI8
    assert (run.status == fa.Status.OK).all()
    np.testing.assert_array_equal(run.energy_error, 0.0)
    np.testing.assert_allclose(run.z / size, exact / size, atol=1e-8)
    wrong = np.abs(run.z - exact) > run.error + 1e-14 * size
    assert wrong.mean() <= 0.01
    assert (np.abs(run.z - exact) <= 10 * run.error + 1e-14 * size).all()
    np.testing.assert_allclose(run.samples[0] / size, expm(A * 2.0 / rate) @ z0 / size, atol=1e-8)


@pytest.mark.parametrize("scheme", [fa.LEAPFROG, fa.YOSHIDA4, fa.KAHAN_LI8, fa.SOFRONIOU_SPALETTA10, fa.RK4])
def test_orders(scheme):
    """Of the damped cubic system, which is not linear, against DOP853."""
    exact = fa.integrate(DAMPED, Z0, time=8.0, scheme=fa.VERNER9, rtol=1e-14, atol=1e-14).z
    longest = {2: 0.05, 4: 0.05, 8: 0.4, 10: 0.8}[scheme.order]
    errors = [
        np.abs(fa.integrate(DAMPED, Z0, time=8.0, scheme=scheme, step=h).z - exact).max()
        for h in (longest, longest / 2)
    ]
    assert log2(errors[0] / errors[1]) == pytest.approx(scheme.order, abs=0.15 * scheme.order)


def test_pure_friction_is_exact():
    """V = 0 nearly: p = p0 exp(-g t) with any step of any scheme, however strong the friction; growth too."""
    for g in (3.0, 40.0, -0.5, 1e-9):
        model = fa.hamiltonian("1e-300*x", coordinates="x", friction=g)
        for scheme in (fa.LEAPFROG, fa.KAHAN_LI8, fa.SOFRONIOU_SPALETTA10):
            run = fa.integrate(model, [0.0, 1.3], time=2.0, step=0.1, scheme=scheme)
            np.testing.assert_allclose(run["p_x"], 1.3 * np.exp(-2.0 * g), rtol=5e-13)


def test_without_friction_nothing_changes():
    plain, damped = fa.hamiltonian(CUBIC), fa.hamiltonian(CUBIC, friction=0.0)
    for scheme in (fa.KAHAN_LI8, fa.SOFRONIOU_SPALETTA10, fa.DOP853):
        how = {} if scheme.adaptive else {"step": 0.1}
        for z0 in (Z0, Z0[:, 0]):
            one, other = (fa.integrate(model, z0, time=10.0, scheme=scheme, **how).z for model in (plain, damped))
            np.testing.assert_array_equal(one, other)


def test_crossings_of_a_damped_oscillator():
    """x = 0 upwards: equal times apart, each crossing slower by exp(-g T/2)."""
    k, g = 1.7, 0.21
    model = fa.hamiltonian("k*x**2/2", coordinates="x", k=k, friction=g)
    cut = fa.poincare_map(model, [0.3, 0.8], section="x=0", crossings=6, max_time=99.0)
    period = 2 * np.pi / np.sqrt(k - g * g / 4)
    np.testing.assert_allclose(np.diff(cut.times[:, 0]), period, rtol=1e-10)
    speed = cut["p_x"][:, 0]
    np.testing.assert_allclose(speed[1:] / speed[:-1], np.exp(-g * period / 2), rtol=1e-9)


def test_a_damped_pendulum_is_that_of_scipy():
    model = fa.hamiltonian("-cos(x)", coordinates="x", friction="2*z*w", z=0.1, w=0.7)
    assert "friction='2*z*w'" in repr(model)
    z0 = np.array([[0.1, 2.0, 3.1], [3.0, 0.0, 0.3]])
    run = fa.integrate(model, z0, time=15.0)
    for k in range(3):
        exact = solve_ivp(
            lambda t, z: [z[1], -np.sin(z[0]) - 0.14 * z[1]], (0, 15), z0[:, k], method="DOP853", rtol=1e-13, atol=1e-13
        ).y[:, -1]
        np.testing.assert_allclose(run.z[:, k], exact, atol=1e-9)
    free = model._replace(z=0.0)
    end = fa.integrate(free, z0, time=5.0).z
    energy = [free.kinetic_energy(z[1]) + free.potential_energy(z[0]) for z in (z0, end)]
    np.testing.assert_allclose(energy[1], energy[0], atol=1e-10)


# --- volumes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", [fa.LEAPFROG, fa.KAHAN_LI8, fa.SOFRONIOU_SPALETTA10])
def test_the_dissipated_volume_is_exact(scheme):
    """M^T Omega M = exp(-g t) Omega and det M = exp(-2 g t), to rounding, of any step."""
    found = fa.tangent_map(DAMPED, Z0[:, :5], time=6.0, step=0.3, scheme=scheme)
    for k in range(5):
        M = found.matrix[..., k]
        np.testing.assert_allclose(M.T @ OMEGA @ M, np.exp(-0.02 * 6) * OMEGA, atol=2e-13 * np.abs(M).max() ** 2)
        assert np.linalg.det(M) == pytest.approx(np.exp(-2 * 0.02 * 6), rel=1e-12)


def test_the_sum_of_the_spectrum_is_the_friction():
    """-n g to 1e-12, and pairs of -g each."""
    found = fa.chaos_map(DAMPED, Z0, time=100.0, indicators="spectrum,megno")
    np.testing.assert_allclose(found.spectrum.sum(axis=0), -2 * 0.02, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.spectrum + found.spectrum[::-1], -0.02, rtol=0, atol=1e-10)
    one = fa.hamiltonian("(x**2 + 2*y**2 + 3*z**2)/2", coordinates="x y z", friction=0.3)
    rates = fa.chaos_map(one, np.ones(6), time=400.0, indicators="spectrum").spectrum[:, 0]
    np.testing.assert_allclose(rates, -0.15, atol=0.01)
    assert rates.sum() == pytest.approx(-0.9, abs=1e-12)


# --- promises -------------------------------------------------------------------------------------------------------


class Own(NamedTuple):
    """A system of one's own with friction."""

    g: float

    degrees_of_freedom = 1
    kind = Kind.DAMPED
    coordinates = ("x",)

    def velocity(self, p):
        return (p,)

    def force(self, x):
        return (-x * x * x,)

    def tangent_force(self, x, dx):
        return (-3 * x * x * dx,)

    def kinetic_energy(self, p):
        return p * p / 2

    def potential_energy(self, x):
        return x**4 / 4

    def margin(self, x):
        return 1.0 + 0.0 * x

    def damping_rate(self):
        return self.g


def test_a_class_of_ones_own():
    text = fa.hamiltonian("x**4/4", coordinates="x", friction=0.4)
    z0 = [[1.0, 0.3], [0.0, 2.0]]
    one, other = (fa.integrate(model, z0, time=10.0).z for model in (Own(0.4), text))
    np.testing.assert_allclose(one, other, atol=1e-9)


# --- words ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda: fa.integrate(DAMPED, Z0, time=1.0, scheme=fa.BLANES_MOAN6),
            ValueError,
            "scheme BLANES_MOAN6 has its order 6 only if forces depend on",
        ),
        (
            lambda: fa.integrate(DAMPED, Z0, time=1.0, scheme=fa.AUTO),
            ValueError,
            "scheme AUTO requires a conserved energy",
        ),
        (
            lambda: fa.integrate(DAMPED, Z0, time=1.0, scheme=fa.TimeTransformed()),
            ValueError,
            r"scheme TimeTransformed\(KAHAN_LI8\) requires a conserved energy,",
        ),
        (
            lambda: fa.frequency_map(DAMPED, Z0, time=9.0),
            TypeError,
            "model must be a Hamiltonian system without friction, or a map,",
        ),
        (
            lambda: fa.energy_grid(DAMPED, energy=0.1, axes={"x": [0.1]}, solve="p_y"),
            ValueError,
            "energy requires a conserved energy, which a system that has",
        ),
        (
            lambda: fa.chaos_map(DAMPED, Z0, time=9.0, indicators="zero_one_test"),
            TypeError,
            "indicators must be those of deviation vectors, such as",
        ),
        (lambda: fa.chaos_map(DAMPED, Z0, time=9.0, indicators="reversibility_error"), TypeError, "has friction"),
        (
            lambda: fa.hamiltonian(CUBIC, friction=0.1, rotation=0.1),
            ValueError,
            "friction must be given without rotation, magnetic and",
        ),
        (lambda: fa.hamiltonian(CUBIC, friction=np.inf), ValueError, "friction must be finite"),
        (lambda: fa.hamiltonian(CUBIC, friction=[1.0]), TypeError, "friction must be a real number"),
        (lambda: fa.hamiltonian(CUBIC, friction="x"), ValueError, "friction: unknown name"),
        (lambda: fa.integrate(DAMPED._replace(friction=np.nan), Z0, time=1.0), ValueError, "not finite"),
    ],
)
def test_what_friction_forbids(call, error, message):
    with pytest.raises(error, match=message):
        call()
