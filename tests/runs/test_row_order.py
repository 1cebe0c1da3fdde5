"""Named rows in the order of accelerators, and positions without momenta, are refused with the right call."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.tori import fit_samples

NU = np.array([0.28, 0.31])
ANGLE = 2 * np.pi * NU[:, None, None] * np.arange(400) + np.array([0.3, 1.1])[:, None]
(X, Y), (PX, PY) = np.cos(ANGLE), -np.sin(ANGLE)
NAMED = {"x": X, "px": PX, "y": Y, "py": PY}


def calls():
    yield lambda samples, names: fa.tunes(samples, coordinates=names)
    yield lambda samples, names: fa.orbit_frequencies(samples, 1.0, coordinates=names)
    yield lambda samples, names: fit_samples(samples, 1.0, coordinates=names)


def test_the_order_of_accelerators_is_refused_with_the_right_call():
    said = "coordinates must list all q, then all p, got 'x px y py'. Use 'x y px py'."
    for call in calls():
        with pytest.raises(ValueError, match="coordinates must list all q") as refused:
            call(NAMED, "x px y py")
        assert str(refused.value) == said
    np.testing.assert_allclose(fa.tunes(NAMED, coordinates="x y px py").nu[:, 0], NU, atol=1e-12)


def test_rows_without_names_of_their_own_are_to_be_put_in_order_too():
    said = "coordinates must list all q, then all p, got 'x px y py'. Order the rows and the names as 'x y px py'."
    with pytest.raises(ValueError, match="coordinates must list all q") as refused:
        fa.tunes(np.array([X, PX, Y, PY]), coordinates=("x", "px", "y", "py"))
    assert str(refused.value) == said
    with pytest.raises(ValueError, match="coordinates must list all q") as refused:
        fa.TuneAccumulator("x px y py")
    assert str(refused.value) == said


@pytest.mark.parametrize(
    ("given", "right"),
    [
        ("X PX Y PY", "X Y PX PY"),
        ("x xp y yp", "x y xp yp"),
        ("x xprime y yprime", "x y xprime yprime"),
        ("x p_x y p_y", "x y p_x p_y"),
        ("x vx y vy", "x y vx vy"),
        ("q1 p1 q2 p2", "q1 q2 p1 p2"),
        ("q_1 p_1 q_2 p_2", "q_1 q_2 p_1 p_2"),
        ("x y py px", "x y px py"),
        ("px py x y", "x y px py"),
        ("p q", "q p"),
        ("x px y py t pt", "x y t px py pt"),
        ("x px y py zeta delta", "x y zeta px py delta"),
        ("x px y py delta ct", "x y ct px py delta"),
    ],
)
def test_usual_names_are_known(given, right):
    samples = dict.fromkeys(given.split(), X)
    with pytest.raises(ValueError, match="coordinates must list all q") as refused:
        fa.tunes(samples, coordinates=given)
    assert str(refused.value) == f"coordinates must list all q, then all p, got '{given}'. Use '{right}'."


def test_a_wrong_order_without_a_known_right_one_is_refused_without_a_call():
    with pytest.raises(ValueError, match=r"got 'x px a b c d'$"):
        fa.tunes(dict.fromkeys(["x", "px", "a", "b", "c", "d"], X), coordinates="x px a b c d")


@pytest.mark.parametrize("names", ["x y px py", "x y u v", "a b c d", "x u y v", "x theta y phi", "theta x I J"])
def test_right_and_unknown_names_pass(names):
    arrays = dict(zip(names.split(), (X, Y, PX, PY), strict=True))
    found = fa.tunes(arrays, coordinates=names)
    np.testing.assert_allclose(found.nu[:, 0], NU, atol=1e-12)


@pytest.mark.parametrize("names", ["x y", "q1 q2", "R z", "x y z r"])
def test_positions_alone_are_refused(names):
    samples = dict.fromkeys(names.split(), X)
    for call in calls():
        with pytest.raises(ValueError, match=r"got positions, '.*'. Use fa.naff for positions alone.$"):
            call(samples, names)
    with pytest.raises(ValueError, match=r"Use fa.naff for positions alone.$"):
        fa.TuneAccumulator(names)


def test_names_of_a_run_itself_are_kept():
    """A map whose momentum has the name of a position: its own names are right."""
    text = "x1 = x*cos(w) + y*sin(w); y1 = y*cos(w) - x*sin(w)"
    run = fa.integrate(fa.iterated_map(text, coordinates="x", momenta="y", w=1.3), [0.1, 0.2], time=100, samples=100)
    running = fa.TuneAccumulator()
    running.push(run)
    running.push(run)
    assert fa.TuneAccumulator.of(running.state).state.names == ("x", "y")
    assert fa.tunes(run, coordinates="x y").names == ("x",)
    with pytest.raises(ValueError, match="Use 'y p_y'"):
        fa.tunes(
            fa.poincare_map(fa.HenonHeiles(), [0.0, 0.1, 0.3, 0.05], section="x=0", crossings=70, max_time=1000),
            coordinates="p_y y",
        )
