"""Figures of what is hardly there: nothing, one cell, all failed; on dark paper, with settings of the user."""

from __future__ import annotations

import contextlib
import inspect
import warnings
from dataclasses import replace

import battery
import numpy as np
import pytest

import fastaff as fa

pytest.importorskip("matplotlib")
import matplotlib.pyplot as plt
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from fastaff.plot.figures import FIGURES
from fastaff.plot.quantum_chaos import plot_spacings

MODEL, SECTION = fa.HenonHeiles(lam=1.0), fa.Hyperplane((1, 0, 0, 0))


@pytest.fixture
def ax():
    return Figure(layout="constrained").subplots()


@pytest.fixture(scope="module")
def crossings():
    starts = fa.energy_sample(MODEL, energy=1 / 8, section=SECTION, orbits=6, seed=3)
    return fa.poincare_map(MODEL, starts.z0, section=SECTION, crossings=20, max_time=500.0)


@pytest.fixture(scope="module")
def frequencies():
    starts = fa.energy_sample(MODEL, energy=1 / 8, section=SECTION, orbits=6, seed=3)
    return fa.frequency_map(MODEL, starts.z0, time=100.0)


def written(ax):
    ax.figure.canvas.draw()
    return [text.get_text() for text in ax.texts]


def test_where_nothing_can_be_drawn_the_figure_says_so(ax, frequencies):
    failed = replace(frequencies, status=np.full_like(frequencies.status, fa.Status.ESCAPED))
    assert failed.plot(ax=ax).missing == 6
    assert "nothing to draw: 6 escaped" in written(ax)
    assert (
        fa.resonances(np.full((2, 3), np.nan), max_order=4, tolerance=1e-3).plot(ax=ax.figure.add_subplot()).missing
        == 3
    )


@pytest.mark.parametrize("dense", [True, False])
def test_points_that_are_not_finite(ax, crossings, dense):
    status = np.full_like(crossings.status, fa.Status.NONFINITE)
    lost = replace(crossings, status=status, points=np.full_like(crossings.points, np.nan))
    lost.plot(ax=ax, density=dense)
    crossings.plot(ax=ax, density=dense, values=np.full(6, np.nan))
    values = np.where(np.arange(6) < 3, np.nan, 1.0)
    crossings.plot(ax=ax, density=dense, values=values)
    ax.figure.canvas.draw()
    assert np.isfinite([*ax.get_xlim(), *ax.get_ylim()]).all()
    y = crossings["y"][:, 3:]
    assert ax.get_xlim()[0] <= y.min()
    assert y.max() <= ax.get_xlim()[1]


def test_all_grey_crossings_near_the_first_ones_are_in_the_frame(ax, crossings):
    crossings.plot(ax=ax, values=np.full(6, np.nan))
    y = crossings["y"]
    assert ax.get_xlim()[0] < y.min()
    assert y.max() < ax.get_xlim()[1]


@pytest.mark.parametrize("axes", [([0.1], [0.1]), (np.linspace(-0.2, 0.2, 4), [0.0])])
def test_grids_of_one_cell_or_row_are_seen(ax, axes):
    grid = fa.energy_grid(MODEL, energy=1 / 8, section=SECTION, axes=axes)
    cells = grid.plot(ax=ax, values=np.arange(grid.cell_index.size)).points
    corners = cells.get_coordinates()
    assert (np.ptp(corners, axis=(0, 1)) > 0).all()
    middle = (corners[1:, 1:] + corners[:-1, :-1]) / 2
    np.testing.assert_allclose(middle[0, :, 0], axes[0], atol=1e-15)


@pytest.mark.parametrize("settings", [{"scatter.marker": "x"}, {"lines.linestyle": ":", "lines.marker": "s"}])
def test_settings_of_the_user_make_no_point_vanish(crossings, settings):
    with plt.rc_context(settings):
        made = crossings.plot().points
    plt.close("all")
    assert made.get_paths()[0].codes is not None  # a filled circle, no cross of lines 0 wide


def test_on_dark_paper_the_ground_stays_and_words_can_be_read(crossings):
    with plt.style.context("dark_background"):
        status = np.where(np.arange(6) < 2, fa.Status.ESCAPED, crossings.status)
        artists = replace(crossings, status=status).plot(values=np.where(status, np.nan, np.arange(6.0)))
        axes = artists.points.axes
        assert axes.get_facecolor() == (0, 0, 0, 1)
        assert axes.figure.get_facecolor() == (0, 0, 0, 1)
        assert to_hex(axes.get_legend().get_texts()[0].get_color()) == "#ffffff"  # above the frame
        assert to_hex(artists.colorbar.ax.get_yticklabels()[0].get_color()) == "#ffffff"
    plt.close("all")


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ({"ax": "here"}, TypeError, "ax must be axes of Matplotlib"),
        ({"ax": np.zeros(2)}, TypeError, "ax must be axes of Matplotlib"),
        ({"size": -1}, ValueError, "size must be >= 0"),
        ({"values": ["a"] * 6}, TypeError, "values must be an array of real numbers"),
        ({"values": "red"}, ValueError, "column must be one of counts,"),
        ({"vmin": 3, "vmax": 1, "values": np.arange(6)}, ValueError, "vmin must be below vmax"),
    ],
)
def test_refused(crossings, given, error, message):
    with pytest.raises(error, match=message):
        crossings.plot(**{"ax": Figure().subplots(), **given})


@pytest.mark.parametrize("projection", ["polar", "3d"])
def test_other_kinds_of_axes_are_refused(crossings, projection):
    with pytest.raises(ValueError, match="ax must be plain axes of two coordinates"):
        crossings.plot(ax=Figure().add_subplot(projection=projection))


def test_orbits_that_are_chosen(ax):
    run = fa.integrate(MODEL, np.full((4, 3), 0.1), time=5.0, samples=20)
    assert len(run.plot(ax=ax, orbits=[-1, 0]).points) == 2
    assert run.plot(ax=ax, orbits=[]).missing == 3
    for wrong in ([3], [0.5], ["a"]):
        with pytest.raises(ValueError, match="orbits must be whole numbers below 3"):
            run.plot(ax=ax, orbits=wrong)


def test_a_mask_colours(ax, crossings):
    points = crossings.plot(ax=ax, values=np.arange(6) % 2 == 0).points
    assert set(points.get_array()) == {0.0, 1.0}


# --- what is no value of an option ------------------------------------------------------------------------------------

WRONG = [object(), "nothing", -1, float("nan"), [1, "a"], {}, np.zeros((3, 3, 3, 3)), np.inf]
FOUND = [name for name in battery.CALLS if "." not in name and name not in battery.OF_TEXTS]
FOUND = [name for name in FOUND if name.islower() or name == "AlphaTurning"]  # one section of a body


@pytest.mark.parametrize("name", FOUND)
def test_options_of_figures_are_taken_or_refused(name):
    """Anything in the place of any option of the figure of a result: drawn, or TypeError or ValueError."""
    result = battery.CALLS[name][0](**battery.base(name))
    drawn = FIGURES.get(type(result))
    options = [] if drawn is None else list(inspect.signature(drawn).parameters.values())[1:]
    for option in options:
        if option.name == "ax" or option.kind in (option.VAR_KEYWORD, option.VAR_POSITIONAL):
            continue
        for wrong in WRONG:
            with warnings.catch_warnings(), contextlib.suppress(TypeError, ValueError):
                warnings.simplefilter("ignore")  # of matplotlib, about what it was given
                drawn(result, ax=Figure().subplots(), **{option.name: wrong})


LAW = fa.quantum.BerryRobnik(0.3)


@pytest.mark.parametrize("laws", [[LAW, fa.quantum.Brody(0.5)], (LAW,), LAW, {"mine": LAW}, [], {}], ids=repr)
def test_laws_of_spacings_with_labels_or_without(ax, laws):
    drawn = plot_spacings(np.random.default_rng(1).exponential(size=50), laws, ax=ax)
    expected = laws.values() if isinstance(laws, dict) else laws if isinstance(laws, (list, tuple)) else [laws]
    assert len(drawn.lines) == len(expected)
    for line, law in zip(drawn.lines, expected, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), law.density(line.get_xdata()))
    labels = [line.get_label() for line in drawn.lines]
    assert labels == (["mine"] if isinstance(laws, dict) and laws else [repr(law) for law in expected])


@pytest.mark.parametrize(
    "laws", [fa.quantum.BerryRobnik, [fa.quantum.BerryRobnik], {"a": 0.3}, [LAW, 0.3], 0.3, "GOE", None]
)
def test_what_are_no_laws(ax, laws):
    with pytest.raises(TypeError, match=r"^laws must be laws of spacings, or such by their labels"):
        plot_spacings([0.5, 1.0], laws, ax=ax)


@pytest.mark.parametrize(
    "given", [{"bins": 0}, {"bins": 2.5}, {"top": 0.0}, {"top": "a"}, {"spacings": [np.nan]}, {"spacings": "a"}]
)
def test_what_is_no_histogram(ax, given):
    with pytest.raises((TypeError, ValueError), match=f"^{next(iter(given))} "):
        plot_spacings(**{"spacings": [0.5, 1.0], "laws": [LAW], "ax": ax, **given})
