"""Periodic orbits whose neighbours run away: their unit is their own size, and OK is an orbit that closes."""

import numpy as np
import pytest

import fastaff as fa
from fastaff import Status


def quadratic_map(a, unit):
    """Return the map (x, p) -> (a - x^2 - p, x), with both rows in a unit."""
    return fa.iterated_map("x1 = u*(a - (x/u)**2) - p; p1 = x", a=float(a), u=unit)


def drawn_map(rng):
    """Return a map (x, p) -> (f(x) - p, x) of a polynomial f of degree 1 to 3, in any units about any origin, the
    units and the origin, and its fixed points x = p, f(x) = 2 x, in the map's own units.
    """
    degree, (s, r) = int(rng.integers(1, 4)), 10.0 ** rng.uniform(-6, 6, 2)
    a = np.append(3 * rng.standard_normal(degree + 1), np.zeros(3 - degree))
    c, d = np.array([s, r]) * rng.choice([0, 1, 1e3]) * rng.standard_normal(2)
    model = fa.iterated_map(
        "x1 = c + s*(a0 + (x - c)/s*(a1 + (x - c)/s*(a2 + (x - c)/s*a3)) - (p - d)/r); p1 = d + r*(x - c)/s",
        **dict(zip(("a0", "a1", "a2", "a3"), a, strict=True)),
        **{"c": c, "d": d, "s": s, "r": r},
    )
    fixed = np.polynomial.Polynomial((a - [0, 2, 0, 0])[: degree + 1]).roots()
    return model, np.array([s, r]), np.array([c, d]), fixed[fixed.imag == 0].real


def test_fixed_points_of_random_polynomial_maps_close_within_their_errors():
    """Guesses near and far, most of whose orbits run away: OK is a fixed point, and nothing else is."""
    rng, ratios, found = np.random.default_rng(47), [], 0
    for _ in range(40):
        model, units, origin, fixed = drawn_map(rng)
        guesses = rng.uniform(-3, 3, (2, 6))
        guesses[:, 5] *= 10 ** rng.uniform(0, 4)
        if fixed.size:
            guesses[:, :3] = rng.choice(fixed, 3) + 10.0 ** rng.uniform(-8, 0, 3) * rng.standard_normal((2, 3))
        orbits = fa.periodic_orbits(model, origin[:, None] + units[:, None] * guesses)
        good = orbits.status == Status.OK
        assert set(orbits.status[~good]) <= {Status.NOT_CONVERGED, Status.NONFINITE}
        assert fixed.size or not good.any(), "there is none"
        for o in np.flatnonzero(good):
            z = origin + units * fixed[np.abs(origin[0] + units[0] * fixed - orbits.z[0, o]).argmin()]
            rounding = 1e-15 * np.linalg.norm((np.abs(z) + np.abs(origin) + units) / orbits.scale[:, o])
            away = np.linalg.norm((orbits.z[:, o] - z) / orbits.scale[:, o])
            ratios.append(max(away - rounding, 0) / orbits.error[o])
            assert (orbits.scale[:, o] < 1e3 * (units * 30 + np.abs(z))).all(), "the unit is a size of the orbit"
        found += good.sum()
    assert found > 160
    assert np.mean(np.array(ratios) <= 1) >= 0.99
    assert max(ratios) < 10


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_a_guess_beside_a_fixed_point_whose_neighbours_escape_is_no_orbit(unit):
    """x' = a - x^2 - p at a = 3: (-3, -3), to which the guess is led."""
    model = quadratic_map(3.0, unit)
    for guess in ([-2.999, -3.0], [-2.9, -3.2], [-4.0, -1.0]):
        found = fa.periodic_orbits(model, unit * np.array(guess))
        assert found.status[0] == Status.OK
        assert found.z[:, 0] / unit == pytest.approx([-3.0, -3.0], rel=1e-14)
    none = quadratic_map(-1.1, unit)
    assert (fa.periodic_orbits(none, unit * np.array([[-1.0, -1.001], [-1.0, -1.0]])).status != Status.OK).all()


@pytest.mark.parametrize(("start", "branch"), [(-3.0, -1), (1.0, 1)])
def test_a_family_whose_neighbours_escape_closes(start, branch):
    """x = -1 +- sqrt(1 + a) of x' = a - x^2 - p, from a = 3 on: within the errors at every point."""
    family = fa.continuation(lambda a: quadratic_map(a, 1.0), [start, start], parameter=3.0, max_steps=50)
    true = -1 + branch * np.sqrt(1 + family.parameter)
    away = np.linalg.norm((family.orbits.z - true) / family.orbits.scale, axis=0)
    assert len(family.parameter) == 51
    assert (away <= family.orbits.error + 1e-15 * np.abs(true) / family.orbits.scale[0]).all()
    assert np.abs(family.orbits.z - true).max() < 1e-12 * np.abs(true).max()


def test_driven_saddles_whose_neighbours_escape_close():
    """-l x^2/2 - F x cos(w t): x = -F/(l + w^2) at t = 0, at rest; x^2/2 - x^3/(3 s) without a drive rests at s."""
    rng = np.random.default_rng(7)
    for _ in range(6):
        w, s = 10 ** rng.uniform(-0.5, 0.5), 10 ** rng.uniform(-4, 4)
        rate = w * rng.uniform(0.3, 1.2)
        F = s * rate**2 * 10 ** rng.uniform(-4, 0)
        model = fa.hamiltonian("-l*x**2/2 - F*x*cos(w*t)", coordinates="x", drive_period="2*pi/w", l=rate**2, F=F, w=w)
        found = fa.periodic_orbits(model, rng.standard_normal((2, 4)) * s * np.array([[1], [rate]]), section="t=0")
        assert (found.status == Status.OK).all()
        assert found.z[0] == pytest.approx(-F / (rate**2 + w**2), rel=1e-9)
        assert (found.scale[0] < 2e2 * np.abs(found.z[0])).all()
