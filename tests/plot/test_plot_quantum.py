"""Figures of quantum levels and states: what they draw, and where."""

from __future__ import annotations

import numpy as np
import pytest

import fastaff
from fastaff.plot import quantum as plot_quantum
from fastaff.systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA, TWO_POLAR

matplotlib = pytest.importorskip("matplotlib")

BODY = fastaff.Body(fastaff.Hyperelastic())
LUMINANCE = [0.2126, 0.7152, 0.0722]


@pytest.fixture(scope="module")
def diagram():
    return fastaff.quantum.level_diagram(
        lambda C: fastaff.Body(fastaff.Hyperelastic(C)), [0.5, 1.0, 30.0], m=0, l=0, count=12, name="C"
    )


def test_levels_against_a_parameter(diagram, ax):
    unit = np.sqrt(diagram.values)
    drawn = plot_quantum.plot_levels(diagram, ax=ax, unit=unit, ylabel=r"$E/\hbar\omega$")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$C$", r"$E/\hbar\omega$")
    curves = diagram.curves()
    assert len(drawn.points) == len(curves) - drawn.missing
    assert drawn.missing == 0
    for line, curve in zip(drawn.points, curves):
        np.testing.assert_allclose(line.get_ydata(), curve.E / unit)
    legend = ax.get_legend()
    assert legend.get_title().get_text() == r"$n_{\vartheta}$"
    assert [text.get_text() for text in legend.get_texts()] == ["0", "1", "2", "3"]
    written = [text.get_text() for text in drawn.labels]
    assert written[-1] == r"$n_{r},n_{\vartheta}$"
    assert written[0] == "0,0"
    grey = drawn.lines[0].get_paths()[0].vertices
    for value, top in zip(diagram.values, diagram.E[:, 0, -1] / unit):
        assert np.min(grey[grey[:, 0] == value][:, 1]) == pytest.approx(top)


def test_classes_differ_in_colour_and_style(ax):
    found = fastaff.quantum.level_diagram(
        lambda C: fastaff.Body(fastaff.Hyperelastic(C)), [1.0, 2.0], m=[0, 1], l=[0, -1], count=3
    )
    drawn = plot_quantum.plot_levels(found, ax=ax, numbers=False)
    looks = {(line.get_color(), line.get_linestyle()) for line in drawn.points}
    assert len(looks) == 2
    assert drawn.labels == ()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["(0, 0)", "(1, -1)"]


def test_levels_by_order_and_against_spin(ax):
    E = np.sort(np.random.default_rng(1).uniform(1, 5, (5, 1, 4)))
    m = np.arange(-4, 5, 2)[:, None]
    n = np.broadcast_to(np.arange(4), (1, *E.shape))
    found = fastaff.quantum.LevelDiagram("m", m[:, 0].astype(float), m, 0 * m, E, 0 * E, n, ("level",), 1.0)
    drawn = plot_quantum.plot_levels(found, ax=ax)
    for k, line in enumerate(drawn.points):
        inside = np.isfinite(line.get_ydata())
        np.testing.assert_array_equal(line.get_ydata()[inside], E[inside, 0, k])
    assert ax.get_xlabel().startswith("spin $m$  (units of")
    assert drawn.points[0].get_marker() == "o"
    assert ax.get_legend() is None


def test_whole_spectrum(ax):
    levels = fastaff.quantum.all_levels(BODY, max_energy=7.5)
    drawn = plot_quantum.plot_spectrum(levels, ax=ax)
    middles = np.array([segment.mean(axis=0) for segment in drawn.points.get_segments()])
    order, wanted = np.lexsort(middles.T), np.stack([levels.m, levels.E], 1)
    np.testing.assert_allclose(middles[order], wanted[np.lexsort(wanted.T)])
    assert (ax.get_ylabel(), drawn.colorbar.ax.get_ylabel()) == ("energy $E$", r"$|l|$  (units of $\hbar$)")
    colours = drawn.points.to_rgba(np.arange(5))[:, :3] @ LUMINANCE
    assert np.all(np.diff(colours) > 0.01)
    lengths = {int(v): np.ptp(s[:, 0]) for v, s in zip(drawn.points.get_array(), drawn.points.get_segments())}
    assert all(lengths[k] > lengths[k + 1] for k in range(max(lengths)))


def test_degeneracies(ax):
    levels = fastaff.quantum.all_levels(fastaff.Body(fastaff.Harmonic()), multiplets=4)
    drawn = plot_quantum.plot_degeneracies(levels, ax=ax)
    np.testing.assert_allclose(drawn.points.get_offsets(), [[2, 1], [3, 4], [4, 10], [5, 20]])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("energy $E$", "degeneracy")


def turning(state, body, alpha, beta):
    a, b = (state.symmetry.m - state.symmetry.l) / 2, (state.symmetry.m + state.symmetry.l) / 2
    V = body.potential.value(alpha**2, beta**2) + state.hbar**2 / (2 * body.mu) * (a**2 / alpha**2 + b**2 / beta**2)
    return V - state.energy


@pytest.mark.parametrize("chart", [ALPHA_BETA, R_VARTHETA, TWO_POLAR], ids=lambda chart: chart.name)
def test_density(chart, ax):
    state = fastaff.quantum.spectrum(BODY, m=3, l=1, count=5).state(4)
    drawn = plot_quantum.plot_density(state, ax=ax, model=BODY, chart=chart, points=201)
    image, (x0, x1, y0, y1) = drawn.points.get_array(), drawn.points.get_extent()
    share = image.sum() * (x1 - x0) * (y1 - y0) / image.size
    assert 0.985 < share < 1.001
    first, second = (f"${fastaff.plot.symbol(name)}$" for name in chart.names[:2])
    assert ax.get_xlabel() == first
    assert ax.get_ylabel().startswith(second)
    assert ax.get_ylabel().endswith("radians)") == (chart is R_VARTHETA)
    assert drawn.colorbar.ax.get_ylabel() == rf"probability density, per d{first}$\,$d{second}"
    curve, wall = drawn.lines
    cell = np.array([x1 - x0, y1 - y0]) / 200
    for contour, value in ((curve, lambda a, b: turning(state, BODY, a, b)), (wall, lambda a, b: a * a - b * b)):
        points = np.concatenate([path.vertices for path in contour.get_paths()])
        assert len(points) > 20
        # zero somewhere within a cell of the grid
        steps = cell * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
        with np.errstate(all="ignore"):
            signs = np.sign([value(*plot_quantum._radii(chart, *(points + step).T)) for step in steps])
        assert np.mean(np.ptp(signs, axis=0) > 0) > 0.97


def test_density_of_a_closed_form_state_crosses_the_wall(ax):
    state = fastaff.quantum.wavefunction(fastaff.Body(fastaff.Harmonic()), m=0, l=0, n=(1, 2))
    drawn = plot_quantum.plot_density(state, ax=ax, points=101, colorbar=False)
    assert drawn.colorbar is None
    assert ax.get_xlabel() == r"$\alpha$", "the state's own chart"
    (wall,) = drawn.lines  # without a body no turning curve
    points = np.concatenate([path.vertices for path in wall.get_paths()])
    np.testing.assert_allclose(points[:, 0], points[:, 1], atol=1e-12)
    assert drawn.points.norm.vmin == 0
    shades = drawn.points.cmap(np.arange(256))[:, :3] @ LUMINANCE
    assert np.all(np.diff(shades) > -1e-3), "brighter is more probable, in grey too"


def test_limits_are_kept_and_charts_refused(ax):
    state = fastaff.quantum.wavefunction(fastaff.Body(fastaff.Harmonic()), m=1, l=1, n=(0, 0))
    plot_quantum.plot_density(state, ax=ax, limits=((0, 2), (0, 3)), points=31)
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, 2), (0, 3))
    with pytest.raises(ValueError, match=r"chart must be .*, got 'elliptic"):
        plot_quantum.plot_density(state, ax=ax, chart=ELLIPTIC)
