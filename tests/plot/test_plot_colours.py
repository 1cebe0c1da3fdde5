"""Colour scales, colours by columns, pictures of many points, picking, the style, mathematics in captions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fastaff as fa
from fastaff import plot
from fastaff.plot import mathematics, scales, style
from fastaff.plot.density import count_points, even_edges

matplotlib = pytest.importorskip("matplotlib")
from matplotlib.backend_bases import MouseEvent  # noqa: E402

HH, X = fa.HenonHeiles(), fa.Hyperplane((1.0, 0.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def crossings():
    sample = fa.energy_sample(HH, section=X, energy=1 / 8, orbits=12, seed=1)
    return sample, fa.poincare_map(HH, sample.z0, section=X, crossings=40, max_time=1e4, step=0.1)


# --- counting ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1.0, 1e-300, 1e-320, 1e300, 1e-14])
@pytest.mark.parametrize("offset", [0.0, 1.0, -1e10])
def test_counts_are_those_of_histogram2d(scale, offset):
    rng = np.random.default_rng(int(abs(np.log10(scale))) + 1)
    x = rng.integers(-50, 50, 3000) * scale + (offset if scale < 1e200 else 0.0)  # many on edges
    y = rng.normal(size=3000)
    x[rng.random(3000) < 0.1] = np.nan
    y[::17], x[5::31], y[3::29] = np.inf, -np.inf, np.nan
    for n in (1, 2, 7, 50):
        edges = even_edges(x, n), even_edges(y, n + 3)
        finite = x[np.isfinite(x)]
        assert edges[0][0] <= finite.min()
        assert edges[0][-1] >= finite.max()
        with np.errstate(over="ignore", invalid="ignore"):
            wanted = np.histogram2d(x, y, bins=edges)[0]
        np.testing.assert_array_equal(count_points(x, y, edges=edges).counts, wanted)


def test_points_on_edges_and_edges_of_ones_own():
    uneven = np.array([0.0, 0.1, 0.1, 0.7, np.nextafter(0.7, 1), 3.0])
    x = np.concatenate([uneven, np.nextafter(uneven, -9), np.nextafter(uneven, 9), [-0.0, 2.9, 1e308, -1e308]])
    y = np.full(x.size, 0.5)
    found = count_points(x, y, edges=(uneven, [0.0, 1.0]), values=x)
    np.testing.assert_array_equal(found.counts, np.histogram2d(x, y, bins=[uneven, [0.0, 1.0]])[0])
    place = np.digitize(x, uneven) - 1 - (x == 3.0)
    for k in range(5):
        own = x[place == k]
        np.testing.assert_allclose(found.mean[k, 0], own.mean() if own.size else np.nan, rtol=1e-15)


def test_values_of_orbits_are_taken_again_and_again():
    x, y, each = np.arange(12.0), np.zeros(12), np.array([1.0, 2.0, 4.0])
    found = count_points(x, y, edges=([0.0, 6.0, 12.0], [-1.0, 1.0]), values=each)
    assert found.mean[:, 0].tolist() == [7 / 3, 7 / 3]
    assert count_points([], [], edges=([0, 1], [0, 1])).counts.tolist() == [[0]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"y": [1.0]}, "y must have 2 entries"),
        ({"edges": ([0.0], [0.0, 1.0])}, "edges must be"),
        ({"edges": ([1.0, 0.0], [0.0, 1.0])}, "edges must be"),
        ({"edges": ([0.0, np.inf], [0.0, 1.0])}, "edges must be"),
        ({"values": [1.0, 2.0, 3.0]}, "values must have 2 entries"),
    ],
)
def test_counting_refuses(change, message):
    given = {"x": [0.1, 0.2], "y": [0.1, 0.2], "edges": ([0.0, 1.0], [0.0, 1.0]), **change}
    with pytest.raises(ValueError, match=message):
        count_points(given.pop("x"), given.pop("y"), **given)


def test_many_points_are_an_image(ax, crossings, monkeypatch):
    _, found = crossings
    drawn = plot.plot_section(found, ax=ax, density=True)
    assert drawn.points.get_array().sum() == found.counts.sum()
    assert isinstance(drawn.points.norm, matplotlib.colors.LogNorm)
    assert drawn.colorbar.ax.get_ylabel() == "crossings per cell"
    from fastaff.plot import sections

    monkeypatch.setattr(sections, "DENSE", 100)
    each = np.arange(12.0)
    coloured = plot.plot_section(found, ax=ax, values=each)
    image = coloured.points.get_array()
    assert image.min() >= 0
    assert image.max() <= 11
    assert plot.plot_section(found, ax=ax, density=False).points.get_offsets().shape == (found.counts.sum(), 2)


# --- picking -------------------------------------------------------------------------------------------------------


def clicks(ax, x, y):
    """What is picked by a click at data coordinates."""
    found = []
    number = ax.figure.canvas.mpl_connect("pick_event", lambda event: found.append(plot.picked(event)))
    ax.figure.pick(MouseEvent("button_press_event", ax.figure.canvas, *ax.transData.transform((x, y)), button=1))
    ax.figure.canvas.mpl_disconnect(number)
    return [entry for entry in found if entry is not None]


@pytest.mark.parametrize("density", [False, True])
def test_a_click_gives_orbit_and_crossing(ax, crossings, density):
    _, found = crossings
    plot.plot_section(found, ax=ax, density=density)
    ax.figure.canvas.draw()
    y, p = found["y"], found["p_y"]
    where = ax.transData.transform(np.column_stack([y.ravel(), p.ravel()]))
    for crossing, orbit in ((0, 0), (17, 5), (39, 11)):
        (entry,) = clicks(ax, y[crossing, orbit], p[crossing, orbit])
        assert (entry.x, entry.y) == (y[entry.crossing, entry.orbit], p[entry.crossing, entry.orbit])
        at = ax.transData.transform((y[crossing, orbit], p[crossing, orbit]))
        away = np.hypot(*(where - at.astype(int)).T).min()
        assert np.hypot(*(ax.transData.transform((entry.x, entry.y)) - at.astype(int))) == pytest.approx(away)
    assert clicks(ax, 10.0, 10.0) == []


def test_a_click_on_a_cell_gives_its_orbit(ax):
    grid = fa.energy_grid(HH, section=X, energy=0.1, axes=(np.linspace(-0.4, 0.5, 7), np.linspace(-0.4, 0.4, 5)))
    plot.plot_diffusion_grid(grid, np.arange(grid.cell_index.size), ax=ax)
    ax.figure.canvas.draw()
    for orbit in (0, 3, grid.cell_index.size - 1):
        (entry,) = clicks(ax, grid["y"][orbit] + 0.05, grid["p_y"][orbit] - 0.06)
        assert entry == plot.Picked(orbit, None, grid["y"][orbit], grid["p_y"][orbit])


def test_other_artists_pick_nothing():
    assert plot.picked(object()) is None


# --- scales --------------------------------------------------------------------------------------------------------


def chaos(values, threshold=5.0):
    """A ChaosMap of MEGNO with these values."""
    found = fa.chaos_map(HH, [[0.0, 0.0], [0.0, 0.1], [0.3, 0.3], [0.3, 0.2]], time=10.0, step=0.1)
    n = len(values)
    values = np.array([values], float)
    return dataclasses.replace(
        found.take(np.zeros(n, int)),
        names=("megno",),
        values=values,
        thresholds=np.full((1, n), threshold),
        status=np.zeros(n, int),
    )


def test_regular_orbits_do_not_look_chaotic_whatever_their_range():
    quiet = plot.colouring(chaos([1.9999, 2.0, 2.0001]))
    mixed = plot.colouring(chaos([1.9999, 2.0, 80.0]))
    for colours in (quiet, mixed):
        bright = scales.colours_of(colours, style.ON_LIGHT)(colours.norm(2.0001))[:3] @ np.array(
            [0.2126, 0.7152, 0.0722]
        )
        assert bright < 0.15
        assert (colours.norm.vmin, colours.norm.vcenter) == (2.0, 5.0)
    assert mixed.norm.vmax > 70
    first, second = (plot.diffusion_scale(1000.0) for _ in range(2))
    assert (first.vmin, first.vcenter, first.vmax) == (second.vmin, second.vcenter, second.vmax)
    assert first.vcenter == pytest.approx(np.log10(0.6 / 1000))
    # The indicator's own threshold, in cycles per natural period: the same drift.
    omega, phase = 1.3, 1.3 * 1000
    threshold = fa.FrequencyDiffusion().default(2, phase)
    assert 10**first.vcenter == pytest.approx(10**threshold * omega / (2 * np.pi))


def test_ends_of_ones_own():
    colours = plot.colouring(chaos([2.0, 9.0]), vmin=1.0, vmax=20.0)
    assert (colours.norm.vmin, colours.norm.vcenter, colours.norm.vmax) == (1.0, 5.0, 20.0)
    beyond = plot.colouring(chaos([2.0, 9.0]), vmin=6.0, vmax=20.0)
    assert not hasattr(beyond.norm, "vcenter")
    with pytest.raises(ValueError, match="vmin must be below vmax"):
        plot.colouring(chaos([2.0, 9.0]), vmin=3.0, vmax=2.0)


def test_any_column_colours(ax, crossings):
    _, found = crossings
    colours = plot.colouring(found, "energy_error")
    np.testing.assert_array_equal(colours.values, found.energy_error)
    drawn = plot.plot_section(found, ax=ax, values="energy_error", vmin=0.0, vmax=1.0)
    assert (drawn.points.norm.vmin, drawn.points.norm.vmax) == (0.0, 1.0)
    assert set(drawn.points.get_array()) == set(found.energy_error)
    with pytest.raises(ValueError, match=r"the column must be one of counts, .*energy_error.*, got 'sali'"):
        plot.colouring(found, "sali")
    with pytest.raises(TypeError, match="result must be a result"):
        plot.colouring([1.0], "x")


def test_frequencies_and_their_ratios_colour():
    found = fa.frequency_map(HH, [[0.0, 0.0], [0.0, 0.1], [0.2, 0.2], [0.1, 0.1]], time=50.0, step=0.1)
    first, second = found.names
    np.testing.assert_allclose(
        plot.colouring(found, f"{second}/{first}").values, found.dominant[1] / found.dominant[0], equal_nan=True
    )
    np.testing.assert_array_equal(plot.colouring(found, f"nu_{first}").values, found.nu[0])
    assert plot.colouring(found).threshold == pytest.approx(np.log10(0.6 / 50))


# --- orbits that escape ----------------------------------------------------------------------------------------------


def test_escaping_orbits_are_grey_and_counted(ax):
    grid = fa.energy_grid(HH, section=X, energy=0.2, axes=(np.linspace(-0.5, 0.9, 8), np.linspace(-0.5, 0.5, 8)))
    found = fa.poincare_map(HH, grid.z0, section=X, crossings=20, max_time=1e3, step=0.05)
    assert (found.status != 0).all()
    drawn = plot.plot_section(found, ax=ax, values=np.full(len(found), np.nan), starts=grid)
    assert drawn.missing == 0
    said = " ".join(text.get_text() for text in ax.get_legend().get_texts())
    crossed = found.counts > 0
    codes, counts = np.unique(found.status[crossed], return_counts=True)
    for code, count in zip(codes, counts):
        assert f"{count} {plot.sections.words(code)}" in said
    inside = np.isfinite(found["y"])
    grey = next(entry for entry in ax.collections if len(entry.get_offsets()) == inside.sum())
    red, green, blue, _ = grey.get_facecolor()[0]
    assert red == green == blue
    # The far end of the escapes does not set the frame.
    assert ax.get_xlim()[1] < 2
    assert np.nanmax(found["y"]) > 2


# --- style ---------------------------------------------------------------------------------------------------------


def test_settings_of_the_user_stay(crossings):
    import matplotlib.pyplot as plt

    before = dict(matplotlib.rcParams)
    _, found = crossings
    drawn = found.plot()
    assert drawn.points.axes.xaxis.get_label().get_fontsize() == style.SETTINGS["axes.labelsize"]
    assert dict(matplotlib.rcParams) == before
    plt.close(drawn.points.figure)


@pytest.mark.parametrize("palette", [style.ON_LIGHT, style.ON_DARK])
def test_lines_differ_by_lightness_and_by_dashes(palette):
    shades = [np.dot(matplotlib.colors.to_rgb(colour), [0.2126, 0.7152, 0.0722]) for colour, _ in palette.curves]
    assert min(np.diff(sorted(shades))) > 0.005
    assert len({str(dashes) for _, dashes in palette.curves}) == len(palette.curves)


# --- mathematics ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "tex"),
    [
        ("(x**2+y**2)/2 + x**2*y - y**3/3", r"\frac{x^{2}+y^{2}}{2}+x^{2}\,y-\frac{y^{3}}{3}"),
        ("C/2*(D1**2+D2**2) + C/(D1*D2)", r"\frac{C}{2}\,(D_1^{2}+D_2^{2})+\frac{C}{D_1\,D_2}"),
        ("-sqrt(alpha)*exp(-r/2)", r"-\sqrt{\alpha}\,e^{-\frac{r}{2}}"),
        ("2*3*x1", r"2\cdot 3\,x_{1}"),
        ("a-(b-c)", "a-(b-c)"),
        ("(a+b)^2", "(a+b)^{2}"),
        ("1e-6*log(r)", r"10^{-6}\,\ln(r)"),
        ("pi*lam", r"\pi\,\lambda"),
    ],
)
def test_formulas_as_mathematics(text, tex):
    assert mathematics.mathematics(text) == tex
    from matplotlib.mathtext import MathTextParser

    MathTextParser("path").parse(f"${tex}$")
    assert "".join(mathematics.terms(text)) == tex


def test_numbers_as_mathematics():
    assert [mathematics.number(x) for x in (1.5, -2.0, 1e-6, 2.5e10, -1e20)] == [
        "1.5",
        "-2",
        "10^{-6}",
        r"2.5\times10^{10}",
        "-10^{20}",
    ]


def test_lines_are_broken_outside_of_mathematics():
    lines = mathematics.wrapped("body ($G = 1$, $K = 2$), $V = a + b + c$ $+\\,d$ and so on", 20)
    assert all(line.count("$") % 2 == 0 for line in lines)
    assert max(map(mathematics.visible, lines)) <= 20
    assert len(lines) > 1
