"""Periodic orbits of dz/dt = f(z): limit cycles, unstable cycles of strange attractors, driven systems with friction.

And published families of Hill's problem.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastaff as fa
from fastaff.periodic import Stability

VAN_DER_POL = fa.ode("x' = y; y' = m*(1 - x**2)*y - x", m=1.0)
LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
ROESSLER = fa.ode("x' = -y - z; y' = x + a*y; z' = b + z*(x - c)", a=0.2, b=0.2, c=2.5)
DUFFING = fa.ode(  # the drive is a circle (c, s) that attracts
    "x' = v; v' = x - x**3 - g*v + a*c; c' = -w*s + c*(1 - c**2 - s**2); s' = w*c + s*(1 - c**2 - s**2)",
    g=0.3,
    a=0.2,
    w=1.2,
)
HILL = fa.hamiltonian("-x**2 + y**2/2 - 1/sqrt(x**2 + y**2)", rotation=1.0)


@pytest.mark.parametrize(("m", "period"), [(0.1, None), (1.0, 6.6632868593231301896996820305), (5.0, 11.6122306677195)])
def test_van_der_pols_cycle(m, period):
    """Periods of many digits (Andersen & Geer 1982 and others); the multiplier is exp of the integral of the
    divergence.
    """
    found = fa.periodic_orbits(VAN_DER_POL._replace(m=m), [1.5, 0.3], section="y=0")
    found.raise_if_failed()
    end = solve_ivp(
        lambda t, z: [z[1], m * (1 - z[0] ** 2) * z[1] - z[0], m * (1 - z[0] ** 2)],
        (0, found.period[0]),
        [*found.z[:, 0], 0.0],
        "DOP853",
        rtol=2.3e-14,
        atol=1e-15,
    ).y[:, -1]
    np.testing.assert_allclose(end[:2], found.z[:, 0], atol=1e-11)
    np.testing.assert_allclose(found.multipliers[0, 0], np.exp(end[2]), rtol=1e-9, atol=1e-12)
    assert found.stability[0] == Stability.ATTRACTING
    if period is None:  # 2 pi (1 + m^2/16 - 5 m^4/3072 + ...), Andersen & Geer 1982
        period = 2 * np.pi * (1 + m**2 / 16 - 5 * m**4 / 3072)
    assert abs(found.period[0] - period) < 1e-8 if m == 0.1 else abs(found.period[0] - period) < 1e-11
    assert np.isnan(found.residues).all()
    assert not found.symplectic


def test_nothing_depends_on_units():
    length, duration = np.array([3e-5, 7e4]), 1e3
    scaled = fa.ode(
        "x' = k*y; y' = m*(1 - (x/l)**2)*y - q*x", m=1.0 / duration, l=length[0], k=length[0] / length[1] / duration,
        q=length[1] / length[0] / duration,
    )  # fmt: skip
    own = fa.periodic_orbits(VAN_DER_POL, [1.5, 0.3], section="y=0")
    other = fa.periodic_orbits(scaled, length * [1.5, 0.3], section="y=0")
    np.testing.assert_allclose(other.z[:, 0] / length, own.z[:, 0], atol=1e-11)
    np.testing.assert_allclose(other.period / duration, own.period, rtol=1e-12)
    np.testing.assert_allclose(other.multipliers, own.multipliers, rtol=1e-8)


def test_unstable_cycles_of_lorenz():
    """Periods of AB, AAB, AAAB, AABB: Viswanath 2003, Nonlinearity 16, 1035."""
    z0 = np.random.default_rng(1).normal(size=(3, 30)) + np.array([[1.0], [1.0], [25.0]])
    z0 = fa.integrate(LORENZ, z0, time=20.0).z
    section = fa.Hyperplane((0.0, 0.0, 1.0), 27.0, -1)  # the fixed points lie on it, and are no cycles
    found = fa.find_periodic_orbits(LORENZ, z0, section=section, max_crossings=4, scan_crossings=200, max_time=400.0)
    periods = [1.5586522107161747, 2.3059072639398046, 3.0235837034339023, 3.0842767758221068]
    for period in periods:
        assert np.abs(found.period - period).min() < 1e-11, period
    assert all(np.abs(np.array(periods) - time).min() < 1e-11 for time in found.period)
    assert (found.stability == Stability.SADDLE).all()
    assert found.z.shape == (3, len(found))
    assert found.names == ("x", "y", "z")
    # The sum of the exponents is the divergence.
    shortest = found.take(np.argmin(found.period))
    largest = np.log(np.abs(shortest.multipliers).max())
    assert abs(largest / shortest.period[0] - 0.9946) < 1e-3
    turned = fa.periodic_orbits(LORENZ, found.z * np.array([[-1.0], [-1.0], [1.0]]), section=section, crossings=4)
    assert (turned.status == fa.Status.OK).sum() >= 2


def test_duffing_with_friction_doubles_its_period():
    """A multiplier passes -1 as the drive grows; the determinant of the map over a period is exp(-g T)."""
    smallest, z0 = [], None
    for a in (0.2, 0.27, 0.29):
        model = DUFFING._replace(a=a)
        z0 = fa.integrate(model, [1.2, 0.0, 1.0, 0.0], time=400.0).z[:, 0] if z0 is None else z0
        found = fa.periodic_orbits(model, z0, section="s=0")
        found.raise_if_failed()
        z0 = found.z[:, 0]
        np.testing.assert_allclose(found.period[0], 2 * np.pi / 1.2, rtol=1e-11)
        # Those of the oscillator and its drive: the circle's own is exp(-2 T).
        order = np.argsort(np.abs(found.multipliers[:, 0] - np.exp(-2 * found.period[0])))
        pair = found.multipliers[order[1:], 0]
        np.testing.assert_allclose(np.prod(pair).real, np.exp(-0.3 * found.period[0]), rtol=1e-7)
        smallest.append(pair.real.min())
        end = solve_ivp(
            lambda t, y, a=a: [y[1], y[0] - y[0] ** 3 - 0.3 * y[1] + a * np.cos(1.2 * t)],
            (0, found.period[0]),
            found.z[:2, 0],
            "DOP853",
            rtol=1e-13,
            atol=1e-14,
        ).y[:, -1]
        np.testing.assert_allclose(end, found.z[:2, 0], atol=1e-10)
    assert smallest[0] > -1 > smallest[-1]


def test_company_and_words():
    starts = np.random.default_rng(2).uniform(-2, 2, (2, 20))
    whole = fa.periodic_orbits(VAN_DER_POL, starts, section="y=0")
    for k in (0, 7, 19):
        alone = fa.periodic_orbits(VAN_DER_POL, starts[:, k], section="y=0")
        np.testing.assert_array_equal(alone.z[:, 0], whole.z[:, k])
        assert alone.status[0] == whole.status[k]
    rest = fa.periodic_orbits(VAN_DER_POL, [0.0, 0.0], section="y=0")
    assert rest.status[0] != fa.Status.OK
    damped = fa.hamiltonian("(x**2 + y**2)/2", friction=0.1)
    with pytest.raises(TypeError, match=r"^model has friction and no drive, so no orbit returns"):
        fa.periodic_orbits(damped, [1.0, 0.0, 0.0, 1.0], section="x=0")
    with pytest.raises(ValueError, match="energy is not supported for ODE"):
        fa.periodic_orbits(VAN_DER_POL, [1.5, 0.3], section="y=0", energy=1.0)
    with pytest.raises(ValueError, match="two variables or more"):
        fa.periodic_orbits(fa.ode("x' = -x"), [1.0], section="x=0")
    with pytest.raises(ValueError, match="parameter must be a number for an ODE system"):
        fa.continuation(VAN_DER_POL, [2.0, 0.0], section="y=0")


FAMILIES = {  # x, p_y, T, C, S = half the trace
    "a": (
        (1.20817994, -1.24833769, 5.60605818, 0.0, 76.7405533),
        (0.97780175, -1.00050388, 4.32640252, 1.0, 142.188452),
        (0.775219130, 0.156502880, 3.08230098, 4.0, 862.347092),
    ),
    "f": (
        (1.4168047, -1.65461742, 5.10225636, -2.0, -0.23259844),
        (0.43991291, -1.59157041, 1.51822353, 1.0, 0.10296631),
        (0.1588827, -2.51761389, 0.37634555, 5.5, 0.9264063),
    ),
    "g": (
        (-0.2801232, -2.45247438, 3.41124456, 2.65601304, 189.899995),
        (-0.23917773, -2.08598633, 0.8683057, 5.12289843, 0.82567435),
        (-0.20285369, -2.24468118, 0.64586191, 5.81371211, 0.86060629),
    ),
}
"""Members of families of Hill's problem that Henon found: Henon 1969, Astron. Astrophys. 1, 223; numbers of A. B.
Batkhin's tables, github.com/abbat06/Hill2D, which have nine digits. a: Lyapunov's orbits around L1, f: retrograde
satellites, g: direct ones; c, around L2, is a turned by 180 degrees.
"""


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("turned", [1, -1])
def test_families_of_hills_problem(family, turned):
    for x, p_y, T, C, S in FAMILIES[family]:
        section = fa.Hyperplane((0.0, 1.0, 0.0, 0.0), 0.0, int(np.sign(p_y - x)) * turned)
        guess = turned * np.array([x, 0.0, 0.0, p_y])
        found = fa.periodic_orbits(HILL, guess + 1e-4 * np.array([1.0, 0.0, 0.0, 1.0]), section=section, energy=-C / 2)
        found.raise_if_failed()
        np.testing.assert_allclose(found.z[:, 0], guess, atol=1e-8)
        assert abs(found.period[0] - T) < 6e-9
        np.testing.assert_allclose(found.indices[0, 0].real / 2, S, rtol=1e-8, atol=1e-6)
        assert found.stability[0] == (Stability.ELLIPTIC if abs(S) < 1 else Stability.HYPERBOLIC)
