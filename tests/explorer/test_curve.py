"""Rotation numbers along closed curves of any shape, in notebooks, against known ones and those of the page."""

import json

import numpy as np
import pytest
from page_engine import compute, needs_node

import fastaff as fa
from fastaff.explorer.curve import along_curve, curve_rotation
from fastaff.explorer.explore import setup_of


def crescents(seed, count):
    """Curves (2, points) whose mean lies beside them, bananas and thin ones, with their rotation numbers."""
    rng = np.random.default_rng(seed)
    curves, turns = [], []
    for k in range(count):
        turn = rng.uniform(-0.49, 0.49)
        angle = 2 * np.pi * (turn * np.arange((400, 700, 1500)[k % 3]) + rng.uniform())
        if k % 2:
            u, v = 0.15 * np.cos(angle) - rng.uniform(0.5, 2.0) * np.sin(angle) ** 2, 1e3 * np.sin(angle)
        else:
            bent = rng.uniform(1.0, 2.5) * np.sin(angle)
            u, v = (2 + 0.15 * np.cos(angle)) * np.cos(bent), (2 + 0.15 * np.cos(angle)) * np.sin(bent)
        curves.append(np.array([u, v]))
        turns.append(turn)
    return curves, np.array(turns)


def test_closed_curves_of_any_shape_turn():
    """Errors cover the true ones, also of rotation numbers beside fractions, where the points stand in clusters."""
    curves, turns = crescents(52, 300)
    found = [curve_rotation(curve) for curve in curves]
    told = np.array([one is not None for one in found])
    assert told.mean() > 0.85  # points in clusters tell no curve from a chain
    away = np.abs((np.array([one.value for one in found if one]) - turns[told] + 0.5) % 1 - 0.5)
    error = np.array([one.error for one in found if one])
    assert (away <= error).mean() >= 0.99
    assert (away <= 10 * error).all()
    assert np.median(error) < 1e-5


def test_what_is_no_curve_has_no_number_along_it():
    rng = np.random.default_rng(7)
    assert along_curve(rng.normal(size=(2, 1000))) is None
    assert along_curve(rng.normal(size=(2, 40))) is None
    assert along_curve(np.ones((2, 100))) is None
    assert curve_rotation(rng.normal(size=(2, 20))) is None


def librating(coupling, count, rng):
    """Points (2, 2000, orbits) of the standard map, of orbits that do not go around the cylinder."""
    angle, momentum = rng.uniform(0.0, 1.0, count), rng.uniform(-0.5, 0.5, count)
    points = []
    for _ in range(2000):
        momentum = momentum + coupling / (2 * np.pi) * np.sin(2 * np.pi * angle)
        angle = angle + momentum
        points.append((angle, momentum))
    points = np.array(points).transpose(1, 0, 2)
    return points[:, :, np.ptp(points[0], axis=0) < 1.0]


def crossings_of_henon_heiles(energy, count, rng):
    """Points (2, 2000, orbits) of x = 0 at random starts."""
    y, p_y = rng.uniform(-0.5, 0.8, count), rng.uniform(-0.45, 0.45, count)
    square = 2 * energy - p_y**2 - y**2 + 2 * y**3 / 3
    starts = np.array([0 * y, y, np.sqrt(np.maximum(square, 0.0)), p_y])[:, square > 0]
    run = fa.poincare_map(fa.HenonHeiles(), starts, section="x=0", crossings=2000, max_time=4e4, accuracy=1e-9)
    return np.array([run["y"], run["p_y"]])


def is_harmonic(value, error, points):
    """Whether the strongest lines of points are harmonics of a rotation number: no centre enters."""
    loop = points[0] + 1j * points[1]
    lines = fa.naff(loop - loop.mean(), 1.0, lines=3).nu
    order = np.arange(-12, 13)[:, None]
    apart = np.abs((order * value - lines + 0.5) % 1 - 0.5)
    return (apart <= np.abs(order) * error + 1e-6).any(axis=0).all()


def test_orbits_have_their_rotation_number_or_none():
    """That of the package about the mean of 2000 crossings, or one of which the strongest lines are harmonics."""
    rng = np.random.default_rng(2026)
    planes = [crossings_of_henon_heiles(energy, 20, rng) for energy in (1 / 12, 1 / 8)]
    planes += [librating(coupling, 24, rng) for coupling in (0.5, 0.8, 1.2)]
    told = 0
    for plane in planes:
        known = fa.islands(plane, max_islands=60)
        for k in np.flatnonzero(known.classification != fa.Classification.CHAOTIC):
            found = [curve_rotation(plane[:, :crossings, k]) for crossings in (32, 100, 300, 1000)]
            found = [one for one in found if one is not None]
            told += len(found)
            for one in found:
                apart = abs((one.value - known.rotation.rotation[k] + 0.5) % 1 - 0.5)
                about = apart <= one.error + known.rotation.error[k]
                assert about or (not one.q and is_harmonic(one.value, one.error, plane[:, :, k])), (k, one)
                if known.q[k] > 1 and one.q:
                    assert (one.q, one.value) == (known.q[k], known.p[k] / known.q[k])
                last = found[-1]
                assert abs((one.value - last.value + 0.5) % 1 - 0.5) <= one.error + last.error + 1e-13
    assert told > 100


def test_four_islands_are_a_chain_and_no_curve():
    """y = 0.14, p_y = 0.28774 at E = 1/8: the number of islands does not change with the crossings."""
    y, p_y = 0.14, 0.28774
    start = [0.0, y, np.sqrt(0.25 - p_y**2 - y**2 + 2 * y**3 / 3), p_y]
    run = fa.poincare_map(fa.HenonHeiles(), start, section="x=0", crossings=1000, max_time=1e5, accuracy=1e-10)
    points = np.array([run["y"], run["p_y"]])[:, :, 0]
    known = fa.islands(points)
    early = [curve_rotation(points[:, :count]) for count in (32, 60, 100)]
    assert all(one is None or abs(one.value + 0.25) <= one.error for one in early)
    for count in (300, 500, 1000):
        found = curve_rotation(points[:, :count])
        assert (found.q, found.value) == (4, -0.25)
        assert known.q[0] == 4
        assert abs(abs(found.secondary.value) - abs(known.secondary_rotation[0])) <= found.secondary.error + 1e-6


@needs_node
def test_the_page_finds_the_chains():
    """As in notebooks, of the standard map and its islands."""
    plane = librating(1.2, 30, np.random.default_rng(5))[:, :400]
    points = [plane[:, :, k] for k in range(plane.shape[2])]
    page = compute(
        f"{json.dumps([one.T.ravel().tolist() for one in points])}.map((points) => curveRotation(points))", "curve.js"
    )
    found = [curve_rotation(one) for one in points]
    assert any(one is not None and one.q for one in found)
    for own, other in zip(found, page, strict=True):
        if own is not None and other is not None:
            assert own.q == other.get("q", 0)
            assert abs(own.value - other["value"]) <= own.error + other["error"]


@needs_node
def test_the_page_finds_the_same():
    curves, turns = crescents(11, 120)
    page = compute(
        f"{json.dumps([curve.T.ravel().tolist() for curve in curves])}.map((points) => curveRotation(points))",
        "curve.js",
    )
    found = [curve_rotation(curve) for curve in curves]
    assert np.mean([(one is None) == (other is None) for one, other in zip(found, page, strict=True)]) > 0.97
    for own, turn, other in zip(found, turns, page, strict=True):
        if own is None or other is None:
            continue
        apart = abs((own.value - other["value"] + 0.5) % 1 - 0.5)
        assert apart <= own.error + other["error"] + 1e-12, turn


def test_the_crescent_of_henon_and_heiles_has_its_number_in_a_notebook():
    """The largest one at E = 1/8: that of the strongest line of its crossings, which no centre enters."""
    from fastaff.explorer.answers import Answers

    heard = []
    answers = Answers({"henon-heiles": fa.HenonHeiles()}, heard.append)
    system = {"name": "henon-heiles", "code": {}, "parameters": {"lam": 1.0}}
    surface = {"energy": 0.125, "section": "x=c", "constant": 0.0, "direction": 1, "width": 20, "height": 20}
    answers.receive({"type": "system", "system": system, "accuracy": 1e-10})
    answers.receive({"type": "surface", **surface})
    answers.receive({"type": "launch", "orbit": 1, "point": [-0.3314, -0.03487], "crossings": 500})
    rotation = heard[-1]["rotation"]
    assert rotation["error"] < 1e-4
    z0 = next(message["z0"] for message in heard if message["type"] == "launched")
    found = fa.poincare_map(fa.HenonHeiles(), z0, section="x=0", crossings=4000, max_time=1e5, accuracy=1e-10)
    loop = found["y"][:, 0] + 1j * found["p_y"][:, 0]
    lines = fa.naff(loop - loop.mean(), 1.0, lines=4).nu
    assert np.abs((lines - rotation["value"] + 0.5) % 1 - 0.5).min() <= rotation["error"] + 1e-7


def test_a_flow_begins_with_a_section_that_its_orbits_cross():
    """Roessler's z stays above 0: its page takes another variable, as that of the typed equations does."""
    roessler = fa.ode("x' = -y - z; y' = x + a*y; z' = b + z*(x - c)", a=0.2, b=0.2, c=5.7)
    start = setup_of(roessler)[0]["start"]
    section = f"{start['section'].removesuffix('=c')}={start['constant']}"
    state = {"x": 5.0, "y": 0.0, "z": 0.1}
    run = fa.poincare_map(roessler, list(state.values()), section=section, crossings=50, max_time=1e4)
    assert run.counts[0] == 50
    assert start["section"] == "y=c"
    lorenz = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
    kept = setup_of(lorenz)[0]["start"]
    assert kept["section"] == "z=c"
    assert kept["constant"] == pytest.approx(24.0, abs=4.0)
    assert setup_of(roessler, section="x=1")[0]["start"]["constant"] == 1.0
