"""The look of all figures: colours, sizes and fonts in one place, in force while a figure is drawn and only then.

Colours are cividis, perceptually uniform and the same to people with any kind of colour vision, cut at its palest end
so that no point vanishes on white, and a few dark ones that differ by lightness too.
"""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, TypeVar, cast

from ..core.interruption import imported
from ..core.numbers import real, shown
from ..results.progress import watched

DARK = "#00224e"
"""The dark end of cividis."""

ACCENT = "#b35900"
"""An orange that differs from DARK by lightness too."""

PALE = "#5a8fc8"
"""A blue that differs from DARK by lightness too."""

GREY = "0.72"
"""Orbits that have left or have no value."""

OUTLINE = "0.35"
"""The edge of the accessible region."""

END = 1e-6
"""Largest share of an edge's momentum at the ends of its pieces; inner points have 0.002 of their piece's or more."""
LINES = (
    (DARK, "-"),
    (ACCENT, (0, (5, 1.5))),
    (PALE, "-."),
    ("#7f2a5f", (0, (1.5, 1))),
    ("#3d3d3d", (0, (7, 1.5, 1, 1.5, 1, 1.5))),
)
"""Colours and dashes of curves, in turn."""
PLATE = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.9}
"""Background of a name."""
PALE_END = 0.93
"""Part of cividis that is kept."""
SMALL = 8.0
"""Points of labels inside a figure."""

SETTINGS: Any = {
    "font.size": 9.5,
    "axes.labelsize": 10.5,
    "axes.titlesize": 10.5,
    "axes.linewidth": 0.8,
    "axes.formatter.use_mathtext": True,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": SMALL,
    "legend.title_fontsize": SMALL,
    "legend.framealpha": 0.92,
    "legend.edgecolor": "0.8",
    "figure.dpi": 120.0,
    "savefig.dpi": 200.0,
    "svg.hashsalt": "fastaff",
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "scatter.marker": "o",
    "lines.linestyle": "-",
    "lines.marker": "None",
}
"""Settings of Matplotlib while we draw."""
INK: Any = dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), "black") | {
    "xtick.labelcolor": "inherit",
    "ytick.labelcolor": "inherit",
    "legend.labelcolor": "black",
}
"""Settings for white paper, used if the user's are for dark."""
PAPER: Any = {"figure.facecolor": "white", "axes.facecolor": "white", "savefig.facecolor": "auto"}

GREEK = """alpha beta gamma delta zeta eta theta vartheta kappa lambda mu xi rho sigma tau chi psi omega Gamma Delta
Omega"""

SYMBOLS = {
    **{name: rf"\{name}" for name in GREEK.split()},
    "epsilon": r"\varepsilon",
    "phi": r"\varphi",
    "lam": r"\lambda",
    "D1": "D_1",
    "D2": "D_2",
    "area": r"\mathrm{area}",
}

Function = TypeVar("Function", bound=Callable[..., Any])


class Artists(NamedTuple):
    """Artists that a function of ``fastaff.plot`` has drawn.

    Attributes
    ----------
    points : artist or list of artists
        Dots, cells, bars or curves of the data.
    colorbar : matplotlib.colorbar.Colorbar
        Colour bar, or None.
    lines : tuple of artists
        Boundary, resonance lines and other lines.
    labels : tuple of matplotlib.text.Text
        Labels of the lines.
    missing : int
        Number of orbits not drawn.
    """

    points: Any
    colorbar: Any
    lines: tuple
    labels: tuple
    missing: int


def styled() -> Any:
    """Return the context in which figures have the style of the package.

    Returns
    -------
    context manager
        Context of Matplotlib settings. It restores the earlier settings at its end.

    Examples
    --------
    >>> import matplotlib
    >>> with fa.plot.styled():
    ...     print(matplotlib.rcParams["savefig.dpi"])
    200.0
    """
    return imported("matplotlib", what="a figure").rc_context({**SETTINGS, **INK, **PAPER})


def light(colour: Any) -> bool:
    """Tell whether a colour is light, or transparent."""
    from matplotlib.colors import to_rgba

    *rgb, alpha = to_rgba(colour)
    return alpha < 0.5 or sum(share * part for share, part in zip((0.3, 0.59, 0.11), rgb, strict=True)) > 0.5


def _inked(ax: Any) -> Any:
    """Return the context for drawing on axes: our colours, and texts on them, are for white."""
    import matplotlib

    settings: Any = (
        dict(INK) if light(ax.figure.get_facecolor()) else {"text.color": "black", "legend.labelcolor": "black"}
    )
    if not light(ax.get_facecolor()):
        ax.set_facecolor("white")
        settings["axes.facecolor"] = "white"
    return matplotlib.rc_context(settings if light(matplotlib.rcParams["text.color"]) else {})


def nothing(ax: Any, why: str = "") -> Any:
    """Say on empty axes that there is nothing to draw, and why."""
    said = "nothing to draw" + (f": {why}" if why else "")
    return ax.text(0.5, 0.5, said, transform=ax.transAxes, ha="center", va="center", color="0.35", wrap=True)


def beyond(ax: Any, said: str) -> Any:
    """Write a note in a corner of axes about the values that they do not show."""
    style = {"ha": "right", "va": "bottom", "fontsize": 8, "color": "0.35", "bbox": PLATE, "zorder": 5}
    return ax.text(0.99, 0.01, said, transform=ax.transAxes, **style)


def figure(function: Function) -> Function:
    """Return a figure's function that draws in our style, on new axes where `ax` is not given, and refuses a first
    argument that lacks what it reads.
    """
    first = next(iter(inspect.signature(function).parameters))

    @functools.wraps(function)
    def draw(*given: Any, ax: Any = None, **options: Any) -> Any:
        with imported("matplotlib", what="a figure").rc_context(SETTINGS):
            if ax is None:
                ax = imported("matplotlib.pyplot").subplots(layout="constrained")[1]
            _check(ax, options.get("size"))
            with watched(function.__name__), _inked(ax):
                try:
                    drawn = function(*given, ax=ax, **options)
                except (AttributeError, TypeError) as error:
                    value = given[0] if given else options.get(first)
                    _refuse(first, value, str(function.__annotations__.get(first, "")), error)
                    raise
                _light_to_print(ax)
                _with_room(ax, getattr(drawn, "colorbar", None))
                return drawn

    return cast(Function, draw)


def _refuse(name: str, value: Any, kinds: str, error: Exception) -> None:
    """Name the argument where an error says that it, or an entry of a sequence, is none of the kinds that are read."""
    entries = value if "Sequence" in kinds and isinstance(value, Iterable) else ()
    if isinstance(error, AttributeError):
        wrong = error.obj is value or any(type(each) is type(error.obj) for each in entries)
    else:
        wrong = str(error) == f"'{type(value).__name__}' object is not iterable"
    if wrong:
        taken = re.sub(r"Sequence\[(\w+)\]", r"a sequence of \1", kinds).replace(" | ", " or ")
        taken = f"an object with {getattr(error, 'name', 'entries')}" if kinds in ("", "Any") else taken
        raise TypeError(f"{name} must be {taken}, got {shown(value)}") from error


def _with_room(ax: Any, bar: Any) -> None:
    """Lay out a figure that has a colour bar, so that none covers another, where its owner has not:
    neither by a layout engine, nor by hand.
    """
    import matplotlib
    from matplotlib.figure import Figure

    settings: Any = matplotlib.rcParams
    sheet = ax.figure
    sides = ("left", "right", "bottom", "top", "wspace", "hspace")
    own = any(getattr(sheet.subplotpars, side) != settings[f"figure.subplot.{side}"] for side in sides)
    if bar is None or own or not isinstance(sheet, Figure) or sheet.get_layout_engine() is not None:
        return
    if all(axes.get_subplotspec() is not None for axes in sheet.axes):
        sheet.set_layout_engine("tight", w_pad=3.0)


MANY = 100_000
"""Points of curves up to which a PDF or SVG has each: 3 MiB; beyond them they are an image in it."""


def _light_to_print(ax: Any) -> None:
    """Make artists with many points images in files of vector graphics; axes and texts stay vectors."""
    curves = [(line, len(line.get_xdata())) for line in ax.lines if not line.get_rasterized()]
    vectors = [many for many in ax.collections if not many.get_rasterized()]
    curves += [(many, len(many.get_offsets()) + sum(len(path) for path in many.get_paths())) for many in vectors]
    if sum(points for _, points in curves) > MANY:
        for artist, points in curves:
            artist.set_rasterized(points > 1)


def _check(ax: Any, size: Any) -> None:
    """Refuse axes that no figure can be drawn on, and sizes that are not numbers >= 0."""
    from matplotlib.axes import Axes

    if not isinstance(ax, Axes):
        raise TypeError(f"ax must be axes of Matplotlib, such as those of plt.subplots(), got {type(ax).__name__}")
    if ax.name != "rectilinear":
        raise ValueError(f"ax must be plain axes of two coordinates, got {ax.name} axes")
    if size is not None and not real("size", size) >= 0:
        raise ValueError(f"size must be >= 0 square points, got {size:g}")


def chosen_orbits(orbits: Any, total: int, most: int, name: str = "orbits") -> Any:
    """Return the numbers of the orbits, or signals, to draw: those asked for, or up to `most` of all."""
    import numpy as np

    if orbits is None:
        return np.unique(np.linspace(0, total - 1, min(total, most)).astype(int))
    found = np.ravel(orbits)
    if not found.size:
        return found.astype(int)
    if found.dtype.kind not in "iu" or found.min() < -total or found.max() >= total:
        raise ValueError(f"{name} must be whole numbers below {total}, the number of {name}, got {shown(orbits)}")
    return found % total


def colour_map() -> Any:
    """Return the colour map of the package: cividis without its palest end.

    Returns
    -------
    matplotlib.colors.Colormap
        The colour map.

    Examples
    --------
    >>> fa.plot.colour_map().N
    256
    """
    import matplotlib
    import numpy as np
    from matplotlib.colors import ListedColormap

    return ListedColormap(matplotlib.colormaps["cividis"](np.linspace(0.0, PALE_END, 256)), name="fastaff")


def symbol(name: str) -> str:
    """Return the mathematical symbol of a coordinate, a momentum or a frequency.

    Parameters
    ----------
    name : str
        Name of a coordinate, a momentum (``p_...``) or a frequency (``nu_...``).

    Returns
    -------
    str
        TeX symbol, without dollar signs.

    Examples
    --------
    >>> fa.plot.symbol("x2")
    'x_{2}'
    """
    head, _, tail = name.partition("_")
    if tail and head in ("p", "nu"):
        return (r"\nu" if head == "nu" else "p") + f"_{{{SYMBOLS.get(tail, tail)}}}"
    if name in SYMBOLS or not name.isidentifier():
        return SYMBOLS.get(name, name)
    letters = name.rstrip("0123456789")
    if letters in SYMBOLS or (len(letters) == 1 and letters != name):
        return f"{SYMBOLS.get(letters, letters)}_{{{name[len(letters) :]}}}"
    if tail:
        return f"{symbol(head)}_{{{SYMBOLS.get(tail, tail)}}}"
    return name if len(name) == 1 else rf"\mathrm{{{name}}}"


def outline(ax: Any, boundary: Any) -> list[Any]:
    """Draw an `Edge` on both sides of its centre, mostly momentum 0, each of its pieces by itself."""
    import numpy as np

    if not all(hasattr(boundary, name) for name in ("coordinate", "momentum", "centre")):
        raise TypeError(f"boundary must be an Edge, such as fastaff.plot.edge returns, got {shown(boundary)}")
    u = boundary.coordinate
    high = boundary.centre + boundary.momentum
    low = boundary.centre - boundary.momentum
    end = boundary.momentum <= END * boundary.momentum.max()
    pieces = np.split(np.arange(u.size), np.flatnonzero(end[1:] & end[:-1]) + 1)
    loops = [(np.append(u[k], [*u[k][::-1], u[k][0]]), np.append(high[k], [*low[k][::-1], high[k][0]])) for k in pieces]
    return [line for loop in loops for line in ax.plot(*loop, color=OUTLINE, lw=0.8)]
