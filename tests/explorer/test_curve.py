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
    away = np.abs((np.array([one.value for one in found]) - turns + 0.5) % 1 - 0.5)
    error = np.array([one.error for one in found])
    assert (away <= error).mean() >= 0.99
    assert (away <= 10 * error).all()
    assert np.median(error) < 1e-5


def test_what_is_no_curve_has_no_number_along_it():
    rng = np.random.default_rng(7)
    assert along_curve(rng.normal(size=(2, 1000))) is None
    assert along_curve(rng.normal(size=(2, 40))) is None
    assert along_curve(np.ones((2, 100))) is None
    assert curve_rotation(rng.normal(size=(2, 20))) is None


@needs_node
def test_the_page_finds_the_same():
    curves, turns = crescents(11, 120)
    page = compute(
        f"{json.dumps([curve.T.ravel().tolist() for curve in curves])}.map((points) => curveRotation(points))",
        "curve.js",
    )
    for curve, turn, other in zip(curves, turns, page, strict=True):
        own = curve_rotation(curve)
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
