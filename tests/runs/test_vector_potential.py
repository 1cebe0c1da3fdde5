"""Charges in magnetic fields that are not uniform: closed forms, gauges, drifts, traps."""

import math

import mpmath as mp
import numpy as np
import pytest
import shared_systems
from scipy.integrate import solve_ivp

import fastaff as fa
from fastaff.systems.models.contracts import Kind
from fastaff.systems.models.mechanics import system_of

RNG = np.random.default_rng(1865)
BOTTLE = {"x": "-B*y/2*(1 + (z/L)**2 - (x**2 + y**2)/(4*L**2))", "y": "B*x/2*(1 + (z/L)**2 - (x**2 + y**2)/(4*L**2))"}
"""Of B_z = B (1 + (z/L)^2 - rho^2/2 L^2), B_rho = -B rho z/L^2, which has neither sources nor currents."""


def speed(model, z):
    return np.array(model.rates(*z)[: len(z) // 2])


def test_a_uniform_field_in_the_symmetric_gauge_is_that_of_magnetic_to_the_bit():
    B, k, a = (float(x) for x in RNG.uniform(0.4, 1.5, 3))
    potential = {"x": "-B*y/2", "y": "B*x/2"}
    new = fa.hamiltonian(shared_systems.CHARGE, coordinates="x y z", vector_potential=potential, B=B, k=k, a=a)
    old = shared_systems.charge(k, a, B)
    assert system_of(new).terms == {"frame"}
    z0 = RNG.uniform(-0.3, 0.3, (6, 5))
    np.testing.assert_array_equal(*(fa.integrate(model, z0, time=20.0).z for model in (new, old)))


def test_a_turning_written_with_momenta_is_a_frame():
    written = "(px**2 + py**2)/(2*m) - w*(x*py - y*px) + x**4"
    model = fa.hamiltonian(written, coordinates="x y", momenta="px py", w=0.3, m=2.0)
    assert system_of(model).terms == {"frame"}
    assert model.angular_velocity() == 0.3
    for other in ("(px**2 + py**2)/2 - w*(x*py - 2*y*px)", "(px**2 + 2*py**2)/2 - w*(x*py - y*px)"):
        assert fa.hamiltonian(other, coordinates="x y", momenta="px py", w=0.3).kind == Kind.NONSEPARABLE


def test_orbits_in_a_bottle_are_those_of_lorentzs_force():
    B, L = float(RNG.uniform(2, 4)), float(RNG.uniform(2, 3))
    model = fa.hamiltonian("0", coordinates="x y z", vector_potential=BOTTLE, B=B, L=L)

    def lorentz(t, y):
        x, v = y[:3], y[3:]
        field = B * np.array(
            [-x[0] * x[2] / L**2, -x[1] * x[2] / L**2, 1 + (x[2] / L) ** 2 - (x[0] ** 2 + x[1] ** 2) / (2 * L * L)]
        )
        return [*v, *np.cross(v, field)]

    z0 = RNG.uniform(-0.5, 0.5, (6, 4))
    found = fa.integrate(model, z0, time=15.0, accuracy=1e-11)
    for k in range(4):
        start = [*z0[:3, k], *speed(model, z0[:, k])]
        end = solve_ivp(lorentz, (0, 15), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        np.testing.assert_allclose(found.z[:3, k], end[:3], rtol=0, atol=1e-8)
        np.testing.assert_allclose(speed(model, found.z[:, k]), end[3:], rtol=0, atol=1e-8)
    kinetic = [(speed(model, z) ** 2).sum(axis=0) / 2 for z in (z0, found.z)]
    np.testing.assert_allclose(kinetic[1], kinetic[0], rtol=1e-11)


@pytest.mark.slow
def test_the_magnetic_moment_is_an_adiabatic_invariant_and_the_charge_bounces():
    """mu = v_across^2/2 B stays within the gyroradius over L; along the field the motion is that of mu B(z)."""
    B, L = 40.0, 3.0
    model = fa.hamiltonian("0", coordinates="x y z", vector_potential=BOTTLE, B=B, L=L)
    v, along = 1.0, 0.6
    x0 = v / B  # the orbit winds around the axis
    z0 = np.array([x0, 0.0, 0.0, 0.0, 0.0, along])
    z0[4] = -v - float(model.rates(*z0)[1])  # so that the velocity across is v, against the turning of a charge
    run = fa.integrate(model, z0, time=40.0, samples=4000, accuracy=1e-9)
    x, y, z = run.samples[:, :3, 0].T
    w = speed(model, run.samples[:, :, 0].T)
    field = B * np.array([-x * z / L**2, -y * z / L**2, 1 + (z / L) ** 2 - (x * x + y * y) / (2 * L * L)])
    size = np.sqrt((field**2).sum(axis=0))
    parallel = (w * field).sum(axis=0) / size
    mu = ((w * w).sum(axis=0) - parallel**2) / (2 * size)
    assert np.ptp(mu) < 3 * (v / B / L) * mu.mean()
    turn = L * along / v  # mu B(z) = E: z = L along/v
    assert abs(z.max() - turn) < 0.01 * turn
    assert abs(z.min() + turn) < 0.01 * turn
    crossings = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    period = 0.01 * np.diff(crossings).mean()
    assert abs(period - 2 * np.pi * L / v) < 0.01 * period


def test_gauges_give_the_same_orbits():
    """A and A + grad chi: p_i + d chi/dx_i; chi = k x^2 y/2 + c sin(y) z, in a field that is not uniform."""
    A = {"x": "-B*y*(1 + x**2)", "y": "B*x/3", "z": "B*x*y"}
    other = {"x": f"{A['x']} + k*x*y", "y": f"{A['y']} + k*x**2/2 + c*cos(y)*z", "z": f"{A['z']} + c*sin(y)"}
    B, k, c = (float(x) for x in RNG.uniform(0.4, 1.5, 3))
    V, names = "(x**2 + y**2 + 2*z**2)/2", {"coordinates": "x y z"}
    one = fa.hamiltonian(V, vector_potential=A, B=B, **names)
    two = fa.hamiltonian(V, vector_potential=other, B=B, k=k, c=c, **names)

    def shifted(z):
        x, y, w = z[:3]
        return np.concatenate([z[:3], z[3:] + np.array([k * x * y, k * x * x / 2 + c * np.cos(y) * w, c * np.sin(y)])])

    z0 = RNG.uniform(-0.5, 0.5, (6, 5))
    runs = [fa.integrate(model, z, time=12.0, accuracy=1e-11) for model, z in ((one, z0), (two, shifted(z0)))]
    np.testing.assert_allclose(runs[1].z, shifted(runs[0].z), rtol=0, atol=1e-8)
    np.testing.assert_allclose(one.energy(*z0), two.energy(*shifted(z0)), rtol=1e-13)


def test_charges_drift_across_fields():
    """In Landau's gauge: E x B at E/B exactly; along a field that grows, by the quadrature of the motion in x, which
    for small gyroradii r is v r/2 L.
    """
    B, E, m = (float(x) for x in RNG.uniform(0.5, 2.0, 3))
    model = fa.hamiltonian("-E*x", vector_potential={"y": "B*x"}, masses=[m, m], B=B, E=E)
    period = 2 * np.pi * m / B
    z0 = RNG.uniform(-1, 1, (4, 4))
    end = fa.integrate(model, z0, time=period, accuracy=1e-12).z
    np.testing.assert_allclose(end - z0, np.array([0.0, -E / B * period, 0.0, 0.0])[:, None] + 0 * z0, atol=1e-10)

    L = float(RNG.uniform(3, 6))
    model = fa.hamiltonian("0", vector_potential={"y": "B*(x + x**2/(2*L))"}, B=B, L=L)
    for v in (0.3, 0.01):
        left, right = (L * (mp.sqrt(1 + mp.mpf(side * 2 * v) / (B * L)) - 1) for side in (-1, 1))  # p_y = 0, v_y = -+ v

        def mean(g, low=left, high=right):  # x'^2 = (v - a)(v + a), a = B (x + x^2/2 L)
            def at(s):
                x = (low + high) / 2 + (high - low) / 2 * mp.sin(s)
                return g(B * (x + x * x / (2 * L))) / (B / (2 * L) * mp.sqrt((x + high + 2 * L) * (x + low + 2 * L)))

            return mp.quad(at, [-mp.pi / 2, 0, mp.pi / 2])

        turn = 2 * float(mean(lambda a: 1))
        drift = 2 * float(mean(lambda a: -a))
        end = fa.integrate(model, [0.0, 0.0, v, 0.0], time=turn, accuracy=1e-12).z[:, 0]
        np.testing.assert_allclose(end, [0.0, drift, v, 0.0], rtol=0, atol=1e-9)
        radius = v / B
        assert abs(abs(drift / turn) - v * radius / (2 * L)) < (radius / L) ** 2 * v


@pytest.mark.parametrize("perfect", [True, False])
def test_a_penning_trap_keeps_browns_and_gabrielses_invariance(perfect):
    """omega_+^2 + omega_-^2 + omega_z^2 = omega_c^2, the field tilted by any angle and the electrodes elliptic."""
    B, w = 3.137, 1.0  # not 3: omega_+ + omega_- = B would be 3 omega_z
    theta, phi, e = (0.0, 0.0, 0.0) if perfect else RNG.uniform([0.05, 0.0, 0.05], [0.15, 6.0, 0.2])
    b = B * np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    A = {"x": "(b_2*z - b_3*y)/2", "y": "(b_3*x - b_1*z)/2", "z": "(b_1*y - b_2*x)/2"}
    trap = fa.hamiltonian(
        "w**2/2*(z**2 - (x**2 + y**2)/2 - e/2*(x**2 - y**2))",
        coordinates="x y z",
        vector_potential=A,
        **{"b_1": b[0], "b_2": b[1], "b_3": b[2], "w": w, "e": float(e)},
    )
    found = fa.frequency_map(trap, [0.3, 0.2, 0.4, 0.1, -0.2, 0.1], time=1500.0)
    omega = 2 * np.pi * np.sort(np.abs(found.nu[:, 0]))
    assert abs((omega**2).sum() - B * B) < 1e-6
    if perfect:
        root = math.sqrt(B * B / 4 - w * w / 2)
        np.testing.assert_allclose(omega, np.sort([w, B / 2 + root, B / 2 - root]), rtol=1e-7)


def test_a_driven_vector_potential_gives_the_electric_field_of_its_change():
    """x'' = -dA/dt: A = a cos(w t) and p = constant; with a spring against SciPy."""
    model = fa.hamiltonian(
        "k*x**2/2",
        coordinates="x",
        vector_potential={"x": "a*cos(w*t)*(1 + x**2)"},
        drive_period="2*pi/w",
        a=0.3,
        w=1.2,
        k=0.0,
    )
    free = model._replace(k=0.5)

    def motion(t, y):
        x, v = y  # v' = -k x - dA/dt on the path, less (p - A) dA/dx that cancels
        return [v, -0.5 * x + 0.3 * 1.2 * np.sin(1.2 * t) * (1 + x * x)]

    z0 = RNG.uniform(-0.5, 0.5, (2, 3))
    found = fa.integrate(free, z0, time=9.0, accuracy=1e-11).z
    for k in range(3):
        start = [z0[0, k], z0[1, k] - 0.3 * (1 + z0[0, k] ** 2)]
        end = solve_ivp(motion, (0, 9), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        assert abs(found[0, k] - end[0]) < 1e-9


def test_friction_of_charges_is_a_force_of_a_flow():
    """Its power is -g v^2, that of the velocities, beside scipy's rates of v."""
    B, c, g = 1.7, 0.3, 0.1
    charge = fa.hamiltonian("x**2/2 + y**2", vector_potential={"y": "B*x + c*x**2"}, B=B, c=c)
    forces = {"x": "-g*p_x", "y": "-g*(p_y - B*x - c*x**2)"}
    end = fa.integrate(fa.ode(charge, forces=forces, g=g), [0.4, 0.2, 0.1, 0.3], time=10.0, rtol=1e-11, atol=1e-11).z

    def rates(t, z):
        x, y, u, v = z
        return u, v, (B + 2 * c * x) * v - x - g * u, -(B + 2 * c * x) * u - 2 * y - g * v

    start = [0.4, 0.2, 0.1, 0.3 - B * 0.4 - c * 0.16]
    truth = solve_ivp(rates, (0, 10), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert np.abs(end[:2, 0] - truth[:2]).max() < 1e-9


def test_what_is_no_vector_potential_is_refused():
    A = {"y": "B*x**2"}
    for more, error, match in (
        ({"vector_potential": 3}, TypeError, "vector_potential must be formulas by coordinate"),
        ({"vector_potential": {}}, ValueError, "vector_potential must be of x, y"),
        ({"vector_potential": {"w": "x"}}, ValueError, "vector_potential must be of x, y"),
        ({"vector_potential": {"x": 3}}, TypeError, r"vector_potential\['x'\] must be a formula"),
        ({"vector_potential": {"x": "q*y"}}, ValueError, r"vector_potential\['x'\]: unknown name 'q'"),
        ({"vector_potential": {"x": "y*t"}}, ValueError, r"vector_potential\['x'\]: .*t"),
        ({"vector_potential": {"x": "__import__('os')"}}, ValueError, r"vector_potential\['x'\]"),
        ({"vector_potential": A, "B": 1.0, "magnetic": 1.0}, ValueError, "magnetic does not go with vector_potential"),
        ({"vector_potential": A, "B": 1.0, "friction": 1.0}, ValueError, "ode.model, forces={'x': '-g"),
        ({"vector_potential": A, "B": 1.0, "momenta": "p q"}, ValueError, "momenta does not go with vector_potential"),
        ({"vector_potential": A, "B": 1.0, "masses": [1.0]}, ValueError, "masses must be 2 positive numbers"),
        ({"vector_potential": A}, ValueError, "'B'"),
        ({"vector_potential": A, "B": 1.0, "C": 1.0}, ValueError, "parameter 'C' must be a name in the formula"),
    ):
        with pytest.raises(error, match=match):
            fa.hamiltonian("x**2", **more)
