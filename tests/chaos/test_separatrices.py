"""Regular orbits next to separatrices are never chaotic, nor is rest on a saddle; chaotic ones are found as before."""

import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff import Classification, Status

WELLS = {
    "pendulum": ("-{k}*cos({u})", lambda u: -np.cos(u), 1.0, 3.0),
    "double well": ("{k}*({u}**4/4 - {u}**2/2)", lambda u: u**4 / 4 - u**2 / 2, 0.0, 1.3),
    "cubic": ("{k}*({u}**2/2 - {u}**3/3)", lambda u: u**2 / 2 - u**3 / 3, 1 / 6, 0.45),
}
"""Text of a potential, the same as a function, its value at the saddle, and the reach of starts."""

INDICATORS = "megno,sali,gali_2,fli,lyapunov"


def beside_the_separatrix(rng, well, k, count):
    """Return u, p (2, count) of orbits 1e-1 to 1e-10 beside the separatrix of k V(u), in energy."""
    _, potential, saddle, reach = WELLS[well]
    u = rng.uniform(-reach, reach, count)
    off = 10.0 ** rng.uniform(-10, -1, count) * (-1 if well == "cubic" else rng.choice([-1, 1], count))
    kinetic = np.maximum(k * (saddle - potential(u) + off), 0.0)
    return np.array([u, np.sqrt(2 * kinetic) * rng.choice([-1, 1], count)])


@pytest.mark.parametrize("well", WELLS)
def test_one_degree_of_freedom_is_never_chaotic(well):
    rng = np.random.default_rng(47)
    for time in (100.0, 300.0, 1000.0, 10000.0):
        k = 10 ** rng.uniform(-0.7, 0.7)
        model = fa.hamiltonian(WELLS[well][0].format(k="k", u="x"), coordinates="x", k=k)
        found = fa.chaos_map(model, beside_the_separatrix(rng, well, k, 25), time=time, indicators=INDICATORS)
        assert not (found.classifications == Classification.CHAOTIC).any(), (k, time)


def test_the_pendulum_beside_its_separatrix():
    model = fa.hamiltonian("-cos(x)", coordinates="x", periodic={"x": "2*pi"})
    assert not fa.chaos_map(model, [0.0, 2 - 1e-7], time=1000.0).chaotic.any()


PRODUCTS = [("pendulum", "pendulum"), ("pendulum", "cubic"), ("double well", "pendulum"), ("cubic", "double well")]


def product(rng, wells, count):
    """Return a product of two systems, turned by an angle, and starts beside the separatrices of one or both."""
    k, l, angle = *10 ** rng.uniform(-0.7, 0.7, 2), rng.uniform(0, 6)
    texts = [WELLS[well][0].format(k=name, u=u) for well, name, u in zip(wells, "kl", ("(c*x + s*y)", "(c*y - s*x)"))]
    c, s = np.cos(angle), np.sin(angle)
    model = fa.hamiltonian(" + ".join(texts), coordinates="x y", k=k, l=l, c=c, s=s)
    (u, p), (v, q) = (beside_the_separatrix(rng, well, each, count) for well, each in zip(wells, (k, l)))
    return model, np.array([c * u - s * v, s * u + c * v, c * p - s * q, s * p + c * q])


@pytest.mark.slow
@pytest.mark.parametrize("wells", PRODUCTS, ids=" times ".join)
def test_products_beside_separatrices_are_never_chaotic(wells):
    rng = np.random.default_rng(48)
    for time in (100.0, 300.0, 1000.0, 3000.0, 10000.0):
        model, z0 = product(rng, wells, 25)
        found = fa.chaos_map(model, z0, time=time, indicators=INDICATORS)
        assert not (found.classifications == Classification.CHAOTIC).any(), time


@pytest.mark.parametrize("time", [100, 1000, 10000])
def test_integrable_maps_beside_separatrices_are_never_chaotic(time):
    """McMillan's map: x^2 p^2 + x^2 + p^2 - 2 g x p is kept, 0 on the separatrix through the origin."""
    rng = np.random.default_rng(49)
    for _ in range(4):
        g = rng.uniform(1.05, 3)
        model = fa.iterated_map("x1 = p; p1 = -x + 2*g*p/(1 + p**2)", g=g)
        x, kept = 0.9 * np.sqrt(g - 1) * rng.uniform(0.1, 1, 25), -(10.0 ** rng.uniform(-10, -2, 25))
        root = np.sqrt(np.maximum((g * x) ** 2 - (1 + x**2) * (x**2 - kept), 0.0))
        start = np.array([x, (g * x + root) / (1 + x**2)])
        found = fa.chaos_map(model, start[:, root > 0], time=time, indicators=INDICATORS)
        assert not (found.classifications == Classification.CHAOTIC).any(), g


def test_rest_on_a_saddle_is_not_chaotic():
    """Henon-Heiles at (0, 1); two pendulums upright; a fixed point of the standard map."""
    two = shared_systems.plane(a=-1, b=-1, e=1, g=1)
    for model, z0 in (
        (fa.HenonHeiles(), [0.0, 1.0, 0.0, 0.0]),
        (two, [0.0] * 4),
        (fa.models.StandardMap(1.5), [0.0, 0.0]),
    ):
        assert not fa.chaos_map(model, z0, time=1000, indicators=INDICATORS).chaotic.any()


def test_chaotic_orbits_are_found():
    """The numbers that were found by growth beyond the thresholds alone."""
    rng = np.random.default_rng(50)
    starts = rng.uniform(0, 2 * np.pi, (2, 100))
    assert fa.chaos_map(fa.models.StandardMap(6.0), starts, time=100).chaotic.sum() == 100
    assert fa.chaos_map(fa.models.StandardMap(1.5), starts, time=1000).chaotic.mean() > 0.6
    y, p_y = rng.uniform(-0.5, 0.9, 400), rng.uniform(-0.5, 0.5, 400)
    square = 2 * (1 / 6 - y**2 / 2 + y**3 / 3) - p_y**2
    z0 = np.array([0 * y, y, np.sqrt(np.abs(square)), p_y])[:, square > 0][:, :60]
    assert fa.chaos_map(fa.HenonHeiles(), z0, time=300.0).chaotic.mean() > 0.85


@pytest.mark.parametrize("size", [1e140, 1e150, 1e153])
def test_huge_oscillators_do_not_escape(size):
    oscillator = fa.hamiltonian("x**2/2 + y**2", coordinates="x y")
    found = fa.chaos_map(oscillator, [size, 0.5 * size, 0.0, size], time=1000.0)
    assert found.status[0] == Status.OK
    assert found.regular.all()
