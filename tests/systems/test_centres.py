"""Homogeneous potentials at their centres, where the formula and its forces are finite."""

import numpy as np
import pytest
from scipy.integrate import quad

import fastaff as fa

AXES = ("x", "y", "z")


def homogeneous(n, degree, centre):
    """c |q - centre|^degree/degree in n coordinates."""
    square = " + ".join(f"({q} - {q}0)**2" for q in AXES[:n])
    values = {f"{q}0": float(at) for q, at in zip(AXES, centre, strict=False)}
    return fa.hamiltonian(f"c*({square})**{degree / 2!r}/{degree!r}", coordinates=" ".join(AXES[:n]), c=1.3, **values)


def quarter(speed, degree, c=1.3):
    """Time from the centre to the turning point on a line, v = speed at the centre, and the distance there."""
    energy = speed**2 / 2
    top = (energy * degree / c) ** (1 / degree)
    # r = top sin^2: the root at the end is a factor, the integrand is smooth there.
    found = quad(
        lambda a: 2 * np.sin(a) * np.cos(a) * top / np.sqrt(2 * energy * (1 - np.sin(a) ** (2 * degree))),
        0,
        np.pi / 2,
        epsabs=0,
        epsrel=1e-11,
        limit=400,
    )
    return found[0], top


CASES = [(1, 2.5), (1, 3.0), (2, 2.5), (2, 1.5), (3, 2.25)]


@pytest.mark.parametrize(("n", "degree"), CASES)
def test_orbits_run_from_and_through_a_centre(n, degree):
    """They were refused there, with a margin of 0; in any units."""
    rng = np.random.default_rng(int(100 * degree) + n)
    for size in (1.0, 1e-6, 1e5) if (n, degree) == (2, 2.5) else (1.0,):
        centre = rng.uniform(-1, 1, n) * (rng.random() < 0.7)
        model = homogeneous(n, degree, centre)
        way = rng.normal(size=n)
        way /= np.sqrt(way @ way)
        speed = size * rng.uniform(0.5, 1.5)
        time, top = quarter(speed, degree)
        found = fa.integrate(model, [*centre, *(speed * way)], time=time)
        assert found.status[0] == 0
        off = np.abs(found.z[:n, 0] - centre - top * way)
        assert (off <= 3 * found.error[:n, 0] + 1e-9 * top + 1e-14).all()
        whole = fa.integrate(model, [*centre, *(speed * way)], time=4 * time)
        back = np.abs(whole.z[:, 0] - [*centre, *(speed * way)])
        assert (back <= 5 * whole.error[:, 0] + 1e-8 * np.repeat([top, speed], n) + 1e-14).all()


@pytest.mark.parametrize(("n", "degree"), [*CASES, (2, 3.7), (3, 1.3)])
def test_methods_at_and_next_to_a_centre(n, degree):
    rng = np.random.default_rng(n)
    centre = rng.uniform(-1, 1, n)
    model = homogeneous(n, degree, centre)
    assert model.margin(*centre) > 0
    assert model.potential_energy(*centre) < 1e-100
    assert np.abs(model.force(*centre)).max() < 1e-30
    for distance in (1.0, 1e-3, 1e-6):
        way = rng.normal(size=n)
        q = centre + distance * way
        way, r = q - centre, np.sqrt(((q - centre) ** 2).sum())
        np.testing.assert_allclose(model.force(*q), -1.3 * r ** (degree - 2) * way, rtol=1e-9)
        dq = rng.normal(size=n)
        change = -1.3 * (r ** (degree - 2) * dq + (degree - 2) * r ** (degree - 4) * way * (way @ dq))
        np.testing.assert_allclose(model.tangent_force(*q, *dq), change, rtol=1e-8)
    if degree > 2:
        with np.errstate(all="ignore"):
            assert np.abs(model.tangent_force(*map(np.float64, centre), *np.ones(n))).max() < 1e-15


def test_walls_that_are_walls_remain():
    """Kepler's, a cone, a base of two signs, a power that a parameter sets, a modulus with a kink."""
    for text, at in (
        ("-(x**2 + y**2)**(-1/2)", (0.0, 0.0)),
        ("(x**2 + y**2)**(1/2)", (0.0, 0.0)),
        ("(x**2 + y**2)**1.25 - (x**2 + y**2)**(-1/2)", (0.0, 0.0)),
        ("(x**2 - y)**1.5", (0.0, 1.0)),
        ("(1 - x**2 - y**2)**1.5", (1.0, 0.1)),
    ):
        assert not fa.hamiltonian(text).margin(*at) > 0
    for text in ("(x**2)**0.5", "(x**2)**0.5 + (y**2)**1.5", "x*(x**2)**0.5 + (y**2)**0.4"):
        with pytest.raises(ValueError, match="text: the formula"):
            fa.hamiltonian(text)


def test_an_infinite_hessian_is_no_number():
    """r^1.5 runs through its centre; a tangent vector there has none."""
    model = homogeneous(2, 1.5, (0.0, 0.0))
    with np.errstate(all="ignore"):
        change = model.tangent_force(*np.zeros((2, 1)), *np.ones((2, 1)))
    assert not np.isfinite(change).any()
    assert fa.chaos_map(model, [0.0, 0.0, 0.3, 0.2], time=20.0).status[0] != 0
    away = fa.chaos_map(model, [0.5, 0.0, 0.0, 0.7], time=50.0)
    assert away.status[0] == 0
    assert not away.chaotic[0]


def test_angular_potentials_of_broken_degree():
    """A power below 1/2 of the square of the radius, with a factor that makes up for it."""
    model = fa.hamiltonian("(x**2 + y**2)**0.25*(x**2 + 2*y**2)")
    assert model.margin(0.0, 0.0) > 0
    found = fa.integrate(model, [0.0, 0.0, 0.4, 0.3], time=30.0)
    assert found.status[0] == 0
    assert found.energy_error[0] < 1e-9
