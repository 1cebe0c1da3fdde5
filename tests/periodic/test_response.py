"""Frequency response of a damped, driven oscillator: a branch of limit cycles over the driving frequency."""

import functools

import numpy as np
import pytest
import shared_systems
from scipy.optimize import root

import fastaff as fa

DAMPING, PUSH = 0.2, 1.0
TEXT = "x' = v; v' = -x - e*x**3 - 2*e*z*v + e*f*c; c' = -w*s + c*(1 - c**2 - s**2); s' = w*c + s*(1 - c**2 - s**2)"
"""Duffing's oscillator and a circle on which its drive runs."""


@functools.cache
def _response(e):
    """The branch over the frequencies around the resonance."""

    def duffing(w):
        return fa.ode(TEXT, e=e, z=DAMPING, f=PUSH, w=w)

    first = 1 - 2 * e
    start = fa.integrate(duffing(first), [0.3, 0.0, 1.0, 0.0], time=40 / (e * DAMPING)).z[:, 0]
    return fa.continuation(duffing, start, section="s=0", parameter=first, bounds=(0.0, 1 + 4 * e), ds_max=0.4)


def _balanced(e, w, x, v, count=24):
    """The periodic solution by harmonic balance on `count` places of the period, from x and v at its begin."""
    theta = 2 * np.pi * np.arange(count) / count
    wave = 1j * np.fft.fftfreq(count, 1 / count)

    def slopes(values, order):
        return np.fft.ifft(np.fft.fft(values) * (w * wave) ** order).real

    def rest(values):
        forces = values + e * values**3 + 2 * e * DAMPING * slopes(values, 1) - e * PUSH * np.cos(theta)
        return slopes(values, 2) + forces

    found = root(rest, x * np.cos(theta) + v / w * np.sin(theta), tol=1e-13)
    return found.x[0], slopes(found.x, 1)[0]


@pytest.mark.slow
def test_a_response_curve_is_that_of_harmonic_balance():
    """On the stable and the unstable part, before and behind both folds."""
    branch = _response(0.1)
    assert branch.status == fa.Status.OK
    for point in branch[:: len(branch) // 12]:
        x, v = point.orbits.z[:2, 0]
        np.testing.assert_allclose(_balanced(0.1, point.parameter[0], x, v), (x, v), atol=1e-9)


@pytest.mark.slow
def test_between_two_folds_the_response_is_unstable():
    branch = _response(0.1)
    assert [event.event for event in branch.bifurcations] == [fa.periodic.Event.FOLD] * 2
    upper, lower = (event.arclength for event in branch.bifurcations)
    between = (branch.arclength > upper) & (branch.arclength < lower)
    saddle = branch.orbits.stability == fa.periodic.Stability.SADDLE
    assert (saddle == between).all()
    assert between.sum() > 5
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.parameter)))) + 1
    for turn, event in zip(turns, branch.bifurcations, strict=True):
        near = branch.parameter[turn - 1 : turn + 2]
        assert abs(event.parameter - near[1]) <= np.ptp(near)


@pytest.mark.slow
def test_the_figure_is_solid_where_orbits_attract_and_knows_what_was_followed(ax):
    branch = _response(0.1)
    fa.plot.plot_backbone(branch, ax=ax, bifurcations=False)
    at = np.isin(ax.lines[0].get_xdata(), branch.parameter)
    solid, dashed = (np.isfinite(line.get_ydata()[at]) for line in ax.lines[:2])
    saddle = branch.orbits.stability == fa.periodic.Stability.SADDLE
    assert solid[~saddle].all()
    assert not solid[saddle].all()
    assert dashed[saddle].all()
    assert ax.get_xlabel() == "parameter"
    assert ax.get_ylabel() == "amplitude of $x$"
    drawn = branch.plot(ax=ax)
    for mark, event in zip(drawn.lines[0].get_ydata(), branch.bifurcations, strict=True):  # folds, on the curve
        assert mark == event.amplitude[0]
        near = np.abs(branch.arclength - event.arclength).argsort()[:2]
        assert branch.amplitude[0, near].min() < mark < branch.amplitude[0, near].max()


def test_a_forced_branch_is_drawn_by_its_amplitude(ax):
    """x'' = -x + f cos(w t) swings by f/|1 - w^2|; y chooses the height, and names what there is."""
    rng = np.random.default_rng(6)
    w, force = rng.uniform(0.3, 0.8), rng.uniform(0.5, 1.0)

    def oscillator(f):
        return shared_systems.duffing(a=f, w=w, k=1.0, c=0.0)

    start = [force / (1 - w**2), 0.0]
    branch = fa.continuation(oscillator, start, section="t=0", parameter=force, max_steps=3)
    assert len(branch) == 4
    truth = branch.parameter / (1 - w**2)
    np.testing.assert_allclose(
        branch.amplitude, [truth, 0 * truth, w * truth, branch.amplitude[3]], rtol=1e-10, atol=1e-14
    )
    np.testing.assert_array_equal(branch["amplitude_x"], branch.amplitude[0])
    for y, height, label in (
        (None, truth, "amplitude of $x$"),
        ("p_x", w * truth, "amplitude of $p_{x}$"),
        ("frequency", 0 * truth + w / (2 * np.pi), "frequency $1/T$  (cycles per unit time)"),
    ):
        ax.clear()
        drawn = fa.plot.plot_backbone(branch, ax=ax, y=y)
        (shown,) = [line for line in drawn.points if np.isfinite(line.get_ydata()).any()]
        at = np.isin(shown.get_xdata(), branch.parameter)
        np.testing.assert_allclose(shown.get_ydata()[at], height, rtol=1e-9)
        assert ax.get_ylabel() == label
    with pytest.raises(ValueError, match="y must be one of x, t, p_x, p_t, frequency, got 'v'"):
        branch.plot(ax=ax, y="v")
    with pytest.raises(TypeError, match=r"must be one of branch.bifurcations, got .* Use branch.plot\(\)"):
        fa.plot.plot_bifurcation(branch, ax=ax)


def test_a_torus_is_born_where_a_complex_pair_passes_the_unit_circle():
    """Of a linear oscillator with friction g the multipliers are exp(s T), s^2 + g s + k = 0: they pass it at g = 0,
    and two real ones, of a product 1 as of any saddle, are no torus.
    """
    rng = np.random.default_rng(34)
    k, f, w = rng.uniform(0.5, 1.5), rng.uniform(0.2, 0.6), rng.uniform(1.7, 2.1)
    turn = "c' = -w*s + c*(1 - c**2 - s**2); s' = w*c + s*(1 - c**2 - s**2)"

    def followed(text, begin, end, slope):
        def make(g):
            return fa.ode(f"{text}; {turn}", k=k, f=f, w=w, g=g)

        z = np.array([*slope(begin), 1.0, 0.0])
        return fa.continuation(make, z, section="s=0", parameter=begin, bounds=(end, begin), direction=-1, ds_max=1.0)

    def forced(g):  # x of x'' + g x' + k x = f cos(w t) at t = 0, and its velocity
        x = f / (k - w * w + 1j * g * w)
        return x.real, (1j * w * x).real

    circle = followed("x' = v; v' = -k*x - g*v + f*c", 0.1, -0.1, forced)
    (event,) = circle.bifurcations
    assert event.event == fa.periodic.Event.NEIMARK_SACKER
    assert abs(event.parameter) <= event.error < 1e-6
    saddle = followed("x' = k*x + f*c; v' = -(k + g)*v", 0.1, -0.1, lambda g: ((f / (1j * w - k)).real, 0.0))
    assert saddle.parameter[-1] == -0.1
    assert saddle.bifurcations == ()
