"""Figures of chaos: what they draw, where the threshold is, what is missing."""

from __future__ import annotations

import numpy as np
import pytest

import fastaff
from fastaff import plot
from fastaff.plot import chaos as plot_chaos
from fastaff.plot import scales, style

matplotlib = pytest.importorskip("matplotlib")

NEO = fastaff.Body(fastaff.NeoHookean())
SURFACE = {"energy": 1.5, "section": fastaff.AlphaTurning(), "p_eta": 0.3, "p_gamma": 0.2}


@pytest.fixture(scope="module")
def grid():
    return fastaff.energy_grid(NEO, axes=(np.linspace(0.1, 1.2, 9), np.linspace(-1.6, 1.6, 7)), **SURFACE)


def chaos_map(orbits, slots=0):
    """A map in which the first quarter is chaotic, the next undecided, and the last orbit failed."""
    part = np.arange(orbits) / orbits
    megno = np.where(part < 0.5, 20.0 + part, 2.0 - 0.1 * part)
    sali = np.where(part < 0.25, -14.0 - part, -1.0 - part)
    values, thresholds = np.array([megno, sali]), np.array([[5.0], [-7.0]]) * np.ones(orbits)
    values[:, -1] = np.nan
    by = np.array([values[0] > 5, values[1] < -7]).astype(int)
    classification = np.where(by[0] == by[1], by[0], fastaff.Classification.UNDECIDED)
    classification[-1] = fastaff.Classification.UNDECIDED
    status = np.zeros(orbits, int)
    status[-1] = fastaff.Status.OUT_OF_DOMAIN
    times = np.geomspace(1.0, 1000.0, slots)[:, None] * np.ones(orbits)
    history = np.array([np.full((slots, orbits), 2.0), -2 * np.log10(times)])
    return fastaff.chaos.ChaosMap(
        ("megno", "sali"),
        values,
        thresholds,
        by,
        classification,
        np.full(orbits, np.nan),
        np.full((2, orbits), np.nan),
        None,
        None,
        history,
        times,
        np.full(orbits, 100.0),
        np.zeros(orbits),
        status,
        100.0,
        fastaff.KAHAN_LI8,
        0.01,
    )


def scan(*axes):
    """A scan of 100 orbits a case whose first case is empty."""
    shape = tuple(len(axis) for axis in axes)
    orbits = np.full(shape, 100)
    orbits[(0,) * len(axes)] = 0
    chaotic = (orbits * np.linspace(0, 0.9, orbits.size).reshape(shape)).astype(int)
    doubt = np.where(orbits > 0, 4, 0)
    zero, statuses = np.zeros(shape), np.zeros((len(fastaff.Status), *shape), int)
    statuses[0] = orbits
    rows = np.zeros((2, *shape))
    return fastaff.chaos.ChaoticFraction(
        ("energy", "K")[: len(axes)],
        tuple(np.asarray(axis, float) for axis in axes),
        orbits,
        chaotic,
        orbits - chaotic - doubt,
        doubt,
        zero.astype(int),
        statuses,
        ("megno", "sali"),
        rows,
        rows,
        rows,
        zero + 10,
        zero,
        zero,
        zero == 0,
    )


@pytest.mark.parametrize("name", ["megno", "sali"])
def test_map_of_an_indicator(grid, ax, name):
    found = chaos_map(grid.cell_index.size)
    drawn = plot_chaos.plot_chaos_map(grid, found, indicator=name, ax=ax, boundary=plot.edge(NEO, **SURFACE))
    assert drawn.missing == 1
    assert drawn.points.get_array().count() == grid.cell_index.size - 1
    assert drawn.points.norm.vcenter == found.thresholds[found.names.index(name), 0]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\beta$", r"$p_{\beta}$")
    grey = ax.collections[0].get_array()
    assert np.flatnonzero(~np.ma.getmaskarray(grey.T).ravel()).tolist() == [grid.cell_index[-1]]
    assert ax.get_legend().get_texts()[0].get_text() == "1 left the domain"
    ticks = [text.get_text() for text in drawn.colorbar.ax.get_yticklabels()]
    assert ticks[-1] == {"megno": "threshold 5", "sali": "threshold \N{MINUS SIGN}7"}[name]
    # Chaos is bright, and at the top of the bar, whichever way the indicator goes.
    lightness = drawn.points.to_rgba(found.values[found.names.index(name), [0, -2]])[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert lightness[0] > lightness[1] + 0.2
    assert drawn.colorbar.ax.yaxis_inverted() == (name == "sali")


def test_map_of_the_classification(grid, ax):
    found = chaos_map(grid.cell_index.size)
    drawn = plot_chaos.plot_chaos_map(grid, found, ax=ax)
    classes, counts = np.unique(drawn.points.get_array().compressed(), return_counts=True)
    fine = found.status == 0
    assert classes.tolist() == [0, 1, 2]
    assert counts.tolist() == [(found.regular & fine).sum(), found.undecided.sum(), (found.chaotic & fine).sum()]
    assert [text.get_text() for text in drawn.colorbar.ax.get_yticklabels()] == ["regular", "undecided", "chaotic"]


def test_map_of_random_points(ax):
    drawn_points = fastaff.energy_sample(NEO, orbits=40, **SURFACE)
    drawn = plot_chaos.plot_chaos_map(drawn_points, chaos_map(40), indicator="megno", ax=ax, colorbar=False)
    assert drawn.points.get_offsets().shape == (39, 2)
    assert drawn.colorbar is None


def test_map_refuses(grid, ax):
    with pytest.raises(ValueError, match="indicator must be one of megno, sali"):
        plot_chaos.plot_chaos_map(grid, chaos_map(grid.cell_index.size), indicator="gali_2", ax=ax)
    with pytest.raises(ValueError, match="chaos_map must be of the"):
        plot_chaos.plot_chaos_map(grid, chaos_map(3), ax=ax)


@pytest.mark.parametrize("values", [[], [2.0], [9.0], [1.0, 2.0, 3.0], [5.0], [2.0, 40.0, np.nan], [-np.inf, 6.0]])
def test_scale_has_the_limit_in_its_middle(values):
    scale = scales.threshold_scale(np.array(values), 5.0)
    assert scale.vmin < 5.0 < scale.vmax
    assert scale(5.0) == 0.5


@pytest.mark.parametrize(("palette", "least"), [(style.ON_LIGHT, 0.15), (style.ON_DARK, 0.1)])
def test_colours_step_at_the_limit(palette, least):
    for falls in (False, True):
        colours = scales.threshold_colours(palette, falls)(np.arange(256))[:, :3] @ [0.2126, 0.7152, 0.0722]
        steps = np.diff(colours) * (-1 if falls else 1)
        assert (steps >= 0).all(), "bright towards chaos"
        assert steps[127] > least
        assert steps[127] > 10 * np.delete(steps, 127).max()


def test_fraction_curve(ax):
    found = scan(np.linspace(1.0, 2.0, 5))
    drawn = plot_chaos.plot_chaotic_fraction(found, ax=ax, label="x")
    assert drawn.missing == 1
    line, _, (bars,) = drawn.points
    np.testing.assert_array_equal(line.get_ydata(), found.fraction[1:])
    low, high = found.interval()
    ends = np.array([part[:, 1] for part in bars.get_segments()])
    np.testing.assert_allclose(ends.T, [low[1:], high[1:]])
    assert len(drawn.lines) == 2, "the band of doubt, and the grey part that the energy does not reach"
    assert ax.get_xlabel() == "energy $E$"


def test_fraction_map(ax):
    found = scan(np.linspace(1.0, 2.0, 3), np.linspace(0.5, 4.0, 4))
    drawn = plot_chaos.plot_chaotic_fraction(found, ax=ax)
    assert drawn.points.get_array().shape == (4, 3)
    assert np.ma.getmaskarray(drawn.points.get_array()).sum() == 1
    assert (drawn.points.norm.vmin, drawn.points.norm.vmax) == (0, 1)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("energy $E$", "$K$")


def test_history_with_a_power_law(ax):
    found = chaos_map(20, slots=30)
    drawn = plot_chaos.plot_history(found, "sali", ax=ax, orbits=range(6, 19), slopes=(-2,))
    assert len(drawn.points) == 13
    assert ax.get_xscale() == "log"
    x, y = drawn.lines[0].get_data()
    assert (y[1] - y[0]) / np.log10(x[1] / x[0]) == pytest.approx(-2)
    curve = drawn.points[-1]
    np.testing.assert_allclose(np.interp(x, curve.get_xdata(), curve.get_ydata()), y, atol=1e-12)
    assert "t^{-2}" in drawn.labels[0].get_text()
    assert ax.get_ylim()[0] >= -10.5, "not far below the threshold of -7"
    with pytest.raises(ValueError, match="must have a history of sali to be drawn"):
        plot_chaos.plot_history(chaos_map(20), "sali", ax=ax)
    with pytest.raises(ValueError, match="indicator must be one of"):
        plot_chaos.plot_history(found, "fli", ax=ax)
