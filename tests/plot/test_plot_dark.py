"""Figures on a dark ground: the ground is the user's, and all that is drawn is seen on it."""

from __future__ import annotations

import doctest
from dataclasses import replace

import numpy as np
import pytest

import fastaff as fa
from fastaff import plot

pytest.importorskip("matplotlib")
import matplotlib.pyplot as plt
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from fastaff.plot import style
from fastaff.plot.style import Palette, contrast

LINE, TEXT = 3.0, 4.5
"""Least contrast of lines and of text (Web Content Accessibility Guidelines 2.1)."""

HH = fa.HenonHeiles()
GROUNDS = ["black", "#121212", "#1e1e1e", "#0d1117", "#282c34", "#002b36"]
"""Black, and the dark grounds of pages, editors and notebooks."""
FUNCTIONS = [name for name in plot.__all__ if name.startswith("plot_")]


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


# --- what is drawn ----------------------------------------------------------------------------------------------------


def seen(colours, ground):
    """Return the largest contrast of some colours to a ground through which transparent ones are seen."""
    found = [0.0]
    for colour in colours:
        *rgb, alpha = to_rgba(colour)
        found.append(contrast([alpha * a + (1 - alpha) * b for a, b in zip(rgb, ground, strict=True)], ground))
    return max(found)


def strokes(artist):
    """Return the colours of the outlines around an artist."""
    found = [effect._gc.get("foreground") for effect in artist.get_path_effects() if hasattr(effect, "_gc")]
    return [colour for colour in found if colour is not None]


def of_text(text, ground):
    """Return the least contrast of a text to the ground, its outline and its plate."""
    plate = text.get_bbox_patch()
    behind = [ground, *strokes(text), *([plate.get_facecolor()] if plate else [])]
    return min(seen([text.get_color()], to_rgba(colour)[:3]) for colour in behind)


def of_line(line, ground):
    colours = [line.get_color(), *strokes(line)] if line.get_linestyle() not in ("None", "", " ") else []
    if line.get_marker() not in ("None", None, ""):
        colours += [line.get_markerfacecolor(), line.get_markeredgecolor()]
    alpha = 1.0 if line.get_alpha() is None else line.get_alpha()
    return seen([(*to_rgba(c)[:3], alpha * to_rgba(c)[3]) for c in colours if c != "none"], ground)


def of_collection(many, ground):
    """Return the least contrast of the elements of a collection: of face or edge."""
    many.update_scalarmappable()
    faces, edges = np.reshape(many.get_facecolors(), (-1, 4)), np.reshape(many.get_edgecolors(), (-1, 4))
    count = max(len(faces), len(edges))
    shown = [rows[np.arange(count) % len(rows)] for rows in (faces, edges) if len(rows)]
    each = [tuple(map(tuple, pair)) for pair in zip(*shown, strict=True)]
    return min((seen(pair, ground) for pair in set(each) if max(c[3] for c in pair) > 0), default=21.0)


def is_area(artist, ax):
    """Tell whether an artist is an area behind the data: grey as the shade, a band, a function that is 0 there, or the
    cells of basins, which cover the ground.
    """
    if isinstance(artist, QuadMesh):
        shade = to_rgba(Palette.of(ax).shade)
        return artist.cmap.name in ("fastaff_husimi", "fastaff_basins") or bool(np.allclose(artist.cmap(0.5), shade))
    return isinstance(artist, (PolyCollection, Polygon))


def dim(figure):
    """Return descriptions of the artists of a figure that are not seen on their grounds."""
    figure.canvas.draw()
    page = style._behind(figure)
    found = []
    for ax in figure.axes:
        bar = hasattr(ax, "_colorbar")
        around = [*ax.get_xticklabels(), *ax.get_yticklabels(), ax.xaxis.label, ax.yaxis.label, ax.title]
        around += [ax._left_title, ax._right_title]
        texts = [(text, page) for text in around]
        spines = [spine.get_edgecolor() for name, spine in ax.spines.items() if name != "outline"]
        found += [f"spine {colour}" for colour in spines if seen([colour], page) < LINE]
        if bar:  # what is on its colours has the ink for these
            found += [f"text {t.get_text()}" for t, on in texts if t.get_text() and of_text(t, on) < TEXT]
            continue
        ground = style._behind(ax)
        texts += [(text, ground) for text in ax.texts]
        legend = ax.get_legend()
        texts += [(text, ground) for text in legend.get_texts()] if legend else []
        found += [f"text {t.get_text()}" for t, on in texts if t.get_text() and of_text(t, on) < TEXT]
        lines = [line for line in ax.lines if len(line.get_xdata())]
        lines += legend.get_lines() if legend else []
        found += [f"{line} {line.get_color()}" for line in lines if of_line(line, ground) < LINE]
        many = [artist for artist in ax.collections if not is_area(artist, ax)]
        found += [str(artist) for artist in many if of_collection(artist, ground) < LINE]
        patches = [patch for patch in ax.patches if not is_area(patch, ax)]
        edges = [(p, [p.get_facecolor(), p.get_edgecolor()]) for p in patches]
        found += [str(patch) for patch, colours in edges if seen(colours, ground) < LINE]
        gaps = [image for image in ax.images if np.ma.is_masked(image.get_array())]
        found += [str(image) for image in gaps if min(seen([c], ground) for c in image.cmap(np.arange(256))) < LINE]
    return found


def run_example(name):
    """Run the example in the docstring of a function of `fastaff.plot`."""
    for case in doctest.DocTestFinder(recurse=False).find(getattr(plot, name), name, globs={"fa": fa, "np": np}):
        said = []
        doctest.DocTestRunner(verbose=False).run(case, out=said.append)
        assert not said, "".join(said)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_figure_is_legible_on_black(name):
    with plt.style.context("dark_background"):
        run_example(name)
        figures = [plt.figure(number) for number in plt.get_fignums()]
        assert figures
        for figure in figures:
            assert {ax.get_facecolor()[:3] for ax in figure.axes} == {(0.0, 0.0, 0.0)}
            assert not dim(figure)


@pytest.fixture(scope="module")
def starts():
    return fa.energy_sample(HH, energy=1 / 8, section="x=0", orbits=6, seed=3)


@pytest.fixture(scope="module")
def crossings(starts):
    cut = fa.poincare_map(HH, starts.z0, section="x=0", crossings=20, max_time=500.0)
    return replace(cut, status=np.where(np.arange(6) < 2, fa.Status.ESCAPED, cut.status))


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("ink", ["white", "black"])
@pytest.mark.parametrize("density", [False, True])
def test_lost_orbits_and_legends_are_legible_on_dark_grounds(crossings, ground, ink, density):
    """Also if the user's settings have a dark ground and forget the ink."""
    inks = dict.fromkeys(("text.color", *style.OUTSIDE), ink)
    with plt.rc_context({"figure.facecolor": ground, "axes.facecolor": ground, **inks}):
        drawn = crossings.plot(boundary=plot.edge(HH, "x=0", energy=1 / 8), density=density)
        coloured = crossings.plot(values=np.where(np.arange(6) < 3, np.nan, np.arange(6.0)))
        for made in (drawn, coloured):
            assert made.points.axes.get_facecolor() == to_rgba(ground)
            assert made.points.axes.get_legend() is not None
            assert not dim(made.points.figure)


def test_a_figure_that_is_not_legible_is_found():
    """The measure of these tests finds dark points, words, bars and lines."""
    with plt.style.context("dark_background"):
        figure, ax = plt.subplots()
        ax.plot([0, 1], color="#00224e")
        ax.scatter([0, 1], [0, 1], color="0.1")
        ax.bar([0], [1], color="#00224e")
        ax.text(0, 0, "dark", color="0.3")
        assert len(dim(figure)) == 4


@pytest.mark.parametrize("make", ["body", "point", "rods"])
def test_animations_are_legible_on_black(make):
    model, z0 = {
        "body": (fa.Body(fa.Harmonic()), [1.0, 0.0, 0.5, 0.0, 0.2, 0.5, 0.0, 0.3]),
        "point": (HH, [0.1, 0.1, 0.3, 0.2]),
        "rods": (fa.models.DoublePendulum(), [1.0, 1.0, 0.0, 0.0]),
    }[make]
    with plt.style.context("dark_background"):
        film = plot.animate(model, z0, time=2.0, frames=4)
    film.draw(3)
    assert film.figure.get_facecolor() == (0, 0, 0, 1)
    assert not dim(film.figure)


# --- the ground -------------------------------------------------------------------------------------------------------


def test_ground_is_that_of_the_axes_or_of_the_sheet_below():
    figure = Figure(facecolor="black")
    ax = figure.subplots()
    assert not Palette.of(ax).dark
    assert Palette.of(figure).dark
    ax.set_facecolor("none")
    assert Palette.of(ax).dark
    ax.set_facecolor((1.0, 1.0, 1.0, 0.25))
    np.testing.assert_allclose(Palette.of(ax).ground, 0.25)
    figure.set_facecolor("none")
    for ink, dark in (("black", False), ("white", True)):
        with plt.rc_context({"text.color": ink}):
            assert Palette.of(figure).dark is dark


def test_axes_of_another_ground_than_the_settings(crossings):
    """Words on them have their ink; those around them have that of the figure."""
    ax = Figure().subplots()
    ax.set_facecolor("black")
    drawn = crossings.plot(ax=ax, values=np.arange(6.0))
    fa.plot.plot_periodic(fa.periodic_orbits(fa.models.StandardMap(0.9), [3.0, 0.1]), ax=ax)
    assert not dim(ax.figure)
    assert to_rgba(drawn.colorbar.ax.get_yticklabels()[0].get_color()) == to_rgba("black")


def test_light_ground_has_the_colours_for_paper():
    with plt.rc_context({"text.color": "white", **dict.fromkeys(style.OUTSIDE, "white")}):
        palette = Palette.of(Figure(facecolor="white").subplots())
    assert palette == replace(style.ON_LIGHT, ground=palette.ground)
    assert palette.grey(0.35) == "0.35"
    assert palette.curves[0][0] == "#00224e"


# --- the palette ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ground", GROUNDS)
def test_colours_of_a_dark_ground_differ_from_it(ground):
    palette = Palette.on(to_rgba(ground)[:3])
    inks = [colour for colour, _ in palette.curves] + [palette.ink, palette.navy, palette.lost, *palette.blues]
    inks += [palette.grey(level) for level in (0.0, 0.5, 0.85)]
    assert min(contrast(colour, ground) for colour in inks) >= LINE
    assert min(contrast(colour, ground) for colour in palette.cividis(np.linspace(0, 1, 50))) >= LINE
    assert contrast(palette.grey(0.35), ground) >= TEXT


@pytest.mark.parametrize("palette", [style.ON_LIGHT, style.ON_DARK])
def test_greys_are_in_order_of_lightness(palette):
    greys = [style.luminance(palette.grey(level)) for level in np.linspace(0, 0.9, 10)]
    assert len(set(np.sign(np.diff(greys)))) == 1


def test_lifted_cividis_keeps_its_order_and_its_hues():
    """Lightness rises evenly; the low end is blue, the high end the same yellow."""
    colours = style.ON_DARK.cividis(np.linspace(0, 1, 200))
    lightness = np.array([np.cbrt(style.luminance(colour)) for colour in colours])
    steps = np.diff(lightness)
    assert (steps > 0).all()
    assert steps.max() < 3 * steps.mean()
    red, _, blue = colours[0, :3]
    assert blue > red + 0.2
    np.testing.assert_allclose(colours[-1], plt.get_cmap("cividis")(1.0), atol=1e-6)


def test_colour_map_is_for_axes_or_for_the_settings():
    ax = Figure(facecolor="black").subplots()
    with plt.style.context("dark_background"):
        lifted = plot.colour_map()
    assert plot.colour_map(ax)(0) == plot.colour_map()(0) != lifted(0)
    ax.set_facecolor("black")
    assert plot.colour_map(ax)(0) == lifted(0)
    with pytest.raises(TypeError, match="ax must be axes of Matplotlib"):
        plot.colour_map("dark")


def test_contrast_is_that_of_the_guidelines():
    """21 of black and white; 4.54 of the grey #767676 on white, the palest for text there."""
    assert contrast("black", "white") == pytest.approx(21.0)
    assert contrast("#767676", "white") == pytest.approx(4.54, abs=0.01)
    assert contrast("#ff0000", "white") == pytest.approx(4.0, abs=0.01)
