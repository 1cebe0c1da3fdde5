"""The look of all figures: colours, sizes and fonts in one place, in force while a figure is drawn and only then.

The ground and the ink of axes and texts are the user's. All other colours are those of a `Palette`, which follows from
the ground of the axes: light or dark. Curves have a few colours that differ by lightness too. Values have the colours
of cividis, perceptually uniform and the same to people with any kind of colour vision, without the end that would
vanish: the palest on a light ground, the darkest, lifted, on a dark one.
"""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar, cast

from ..core.interruption import imported
from ..core.numbers import real, shown
from ..results.progress import watched

END = 1e-6
"""Largest share of an edge's momentum at the ends of its pieces; inner points have 0.002 of their piece's or more."""
PALE_END = 0.93
"""Part of cividis that is kept on a light ground."""
LIFTED = 0.56
"""Lightness in Oklab of the dark end of cividis on a dark ground: 4.5:1 on black, 3:1 on the grey #282c34."""
DIM = 0.36
"""Share of the ink in the palest grey of lines on a dark ground: 3.2:1 on black."""
LOST = 0.42
"""Share of the ink in the grey of lost orbits on a dark ground: 3.9:1 on black."""
SHADE = 0.18
"""Share of the ink in grey areas on a dark ground, behind what is drawn."""
MIDDLE = 0.18
"""Relative luminance of a ground on which black and white have the same contrast."""
LEGIBLE = 3.0
"""Least contrast of the user's ink and the ground, that of graphics in the Web Content Accessibility Guidelines 2.1.
"""
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
    "figure.dpi": 120.0,
    "savefig.dpi": 200.0,
    "savefig.facecolor": "auto",
    "svg.hashsalt": "fastaff",
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "scatter.marker": "o",
    "lines.linestyle": "-",
    "lines.marker": "None",
}
"""Settings of Matplotlib while we draw."""
OUTSIDE = ("axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
"""Settings of the ink around axes."""

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


@dataclass(frozen=True)
class Palette:
    """Colours for one ground.

    ground : behind what is drawn, (red, green, blue); ink : of the strongest contrast to it; main, accent, pale, plum,
    charcoal : of curves and points; navy : of regular orbits; tint : of areas; blues : from one point to many; browns :
    from 0, the ground, to the largest value.
    """

    ground: tuple[float, float, float]
    ink: str
    main: str
    accent: str
    pale: str
    plum: str
    charcoal: str
    navy: str
    tint: str
    blues: tuple[str, ...]
    browns: tuple[str, ...]

    @classmethod
    def of(cls, sheet: Any) -> Palette:
        """Return the palette for axes or a figure."""
        return cls.on(_behind(sheet))

    @classmethod
    def on(cls, ground: tuple[float, float, float]) -> Palette:
        """Return the palette for a ground (red, green, blue)."""
        return replace(ON_DARK if luminance(ground) < MIDDLE else ON_LIGHT, ground=ground)

    @property
    def dark(self) -> bool:
        """Whether the ground is dark."""
        return luminance(self.ground) < MIDDLE

    @property
    def bright(self) -> float:
        """Place of the palest colour of cividis that is seen on the ground."""
        return 1.0 if self.dark else PALE_END

    @property
    def curves(self) -> tuple[tuple[str, Any], ...]:
        """Colours and dashes of curves, in turn."""
        return (
            (self.main, "-"),
            (self.accent, (0, (5, 1.5))),
            (self.pale, "-."),
            (self.plum, (0, (1.5, 1))),
            (self.charcoal, (0, (7, 1.5, 1, 1.5, 1, 1.5))),
        )

    @property
    def plate(self) -> dict[str, Any]:
        """Background of a name."""
        return {"boxstyle": "round,pad=0.12", "facecolor": self.ground, "edgecolor": "none", "alpha": 0.9}

    @property
    def lost(self) -> Any:
        """Grey of orbits that have left or have no value."""
        return self._mixed(LOST) if self.dark else "0.72"

    @property
    def shade(self) -> Any:
        """Grey of areas behind what is drawn."""
        return self._mixed(SHADE) if self.dark else "0.9"

    def grey(self, level: float) -> Any:
        """Return the grey of lines or texts that is `level` on white, 0 for the strongest, and its like on dark."""
        return self._mixed(1.0 - level * (1.0 - DIM)) if self.dark else f"{level:g}"

    def _mixed(self, ink: float) -> tuple[float, ...]:
        """Return the ground with a share of white ink."""
        return tuple(part + ink * (1.0 - part) for part in self.ground)

    def cividis(self, places: Any) -> Any:
        """Return the colours (n, 4) of cividis at places from 0 to `bright`, lifted on a dark ground."""
        import matplotlib
        import numpy as np

        colours = matplotlib.colormaps["cividis"](np.asarray(places, dtype=np.float64))
        return _lifted(colours) if self.dark else colours

    def colour_map(self) -> Any:
        """Return the map of colours of values, each seen on the ground."""
        return self._map(self.cividis, "fastaff")

    def image_map(self) -> Any:
        """Return the map of colours of an image without gaps, which hides the ground: the dark end stays dark."""
        import matplotlib

        return self._map(matplotlib.colormaps["cividis"], "fastaff_image")

    def _map(self, colours: Callable[[Any], Any], name: str) -> Any:
        """Return the map of 256 colours at places from 0 to `bright`."""
        import numpy as np
        from matplotlib.colors import ListedColormap

        return ListedColormap(colours(np.linspace(0.0, self.bright, 256)), name=name)


ON_LIGHT = Palette(
    ground=(1.0, 1.0, 1.0),
    ink="black",
    main="#00224e",  # the dark end of cividis
    accent="#b35900",
    pale="#5a8fc8",
    plum="#7f2a5f",
    charcoal="#3d3d3d",
    navy="#00306f",
    tint="#dfe8f3",
    blues=("#b9cfe8", "#5a8fc8", "#00306f", "#000d20"),
    browns=("#f6d9b8", "#e39a4f", "#a8500b", "#4a1d00"),
)
ON_DARK = Palette(
    ground=(0.0, 0.0, 0.0),
    ink="white",
    main="#a6cdf7",
    accent="#f29a3f",
    pale="#5a8fc8",
    plum="#bb62a4",
    charcoal="#d9d9d9",
    navy="#8fc1f5",
    tint="#1f2a3a",
    blues=("#5a8fc8", "#7fb0e6", "#a6cdf7", "#f4f9ff"),
    browns=("#5a2a05", "#a8500b", "#e39a4f", "#ffe9d0"),
)


def luminance(colour: Any) -> float:
    """Return the relative luminance of a colour, 0 to 1 (IEC 61966-2-1)."""
    from matplotlib.colors import to_rgb

    return float(_linear(to_rgb(colour)) @ LUMINANCE)


def contrast(colour: Any, ground: Any) -> float:
    """Return the contrast of two colours, 1 to 21 (Web Content Accessibility Guidelines 2.1)."""
    low, high = sorted((luminance(colour), luminance(ground)))
    return (high + 0.05) / (low + 0.05)


LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Shares of linear red, green and blue in the luminance."""


def _linear(rgb: Any) -> Any:
    """Return linear values of parts of sRGB in [0, 1]."""
    import numpy as np

    parts = np.asarray(rgb, dtype=np.float64)
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


CONES = (
    (0.4122214708, 0.5363325363, 0.0514459929),
    (0.2119034982, 0.6806995451, 0.1073969566),
    (0.0883024619, 0.2817188376, 0.6299787005),
)
"""Matrix from linear sRGB to the responses of cones of Oklab (B. Ottosson 2020, A perceptual color space for image
processing).
"""
OKLAB = (
    (0.2104542553, 0.7936177850, -0.0040720468),
    (1.9779984951, -2.4285922050, 0.4505937099),
    (0.0259040371, 0.7827717662, -0.8086757660),
)
"""Matrix from cube roots of these to lightness, green to red, blue to yellow."""


def _lifted(colours: Any) -> Any:
    """Return colours (n, 4) of cividis with their hues and with lightness from LIFTED to that of the pale end."""
    import matplotlib
    import numpy as np

    def oklab(rgb: Any) -> Any:
        return np.cbrt(_linear(rgb) @ np.transpose(CONES)) @ np.transpose(OKLAB)

    low, high = oklab(matplotlib.colormaps["cividis"]([0.0, 1.0])[:, :3])[:, 0]
    own = oklab(colours[:, :3])
    own[:, 0] = LIFTED + (own[:, 0] - low) * (high - LIFTED) / (high - low)
    cones = np.linalg.solve(OKLAB, own.T) ** 3
    parts = np.clip(np.linalg.solve(CONES, cones).T, 0.0, 1.0)
    parts = np.where(parts <= 0.0031308, 12.92 * parts, 1.055 * parts ** (1 / 2.4) - 0.055)
    return np.column_stack([parts, colours[:, 3]])


def _behind(sheet: Any) -> tuple[float, float, float]:
    """Return the colour behind what is drawn on axes or a figure. A part that is transparent shows the sheet below; the
    lowest is white, or black if the user's ink is for that.
    """
    import matplotlib

    settings: Any = matplotlib.rcParams
    below: Any = sheet.figure if sheet.figure is not sheet else None
    colour = sheet.get_facecolor() if sheet.patch.get_visible() else "none"
    return _over(colour, functools.partial(_behind, below) if below is not None else lambda: _page(settings))


def _page(settings: Any) -> tuple[float, float, float]:
    """Return the colour of the page below a transparent figure: the opposite of the user's ink."""
    shade = 0.0 if luminance(settings["text.color"]) > MIDDLE else 1.0
    return shade, shade, shade


def _over(colour: Any, below: Callable[[], tuple[float, float, float]]) -> tuple[float, float, float]:
    """Return a colour, mixed with that below it if it is transparent."""
    from matplotlib.colors import to_rgba

    *rgb, alpha = to_rgba(colour)
    mixed = rgb if alpha == 1 else [alpha * a + (1 - alpha) * b for a, b in zip(rgb, below(), strict=True)]
    return cast(tuple[float, float, float], tuple(mixed))


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
    matplotlib = imported("matplotlib", what="a figure")
    return matplotlib.rc_context({**SETTINGS, **_inks(*_new_grounds(matplotlib.rcParams))})


def _new_grounds(settings: Any) -> tuple[Palette, Palette]:
    """Return the palettes of new axes and of their figure."""
    outside = _over(settings["figure.facecolor"], lambda: _page(settings))
    return Palette.on(_over(settings["axes.facecolor"], lambda: outside)), Palette.on(outside)


def _inks(inside: Palette, outside: Palette) -> dict[str, Any]:
    """Return settings for drawing on axes and around them: the user's inks, or ours if these are not legible there."""
    import matplotlib

    settings: Any = matplotlib.rcParams
    inks: dict[str, Any] = {"legend.edgecolor": inside.grey(0.8)}
    if contrast(settings["text.color"], inside.ground) < LEGIBLE:
        inks["text.color"] = inside.ink
    if contrast(settings["axes.labelcolor"], outside.ground) < LEGIBLE:
        inks |= dict.fromkeys(OUTSIDE, outside.ink)
        inks |= {"xtick.labelcolor": "inherit", "ytick.labelcolor": "inherit"}
    return inks


def nothing(ax: Any, why: str = "") -> Any:
    """Say on empty axes that there is nothing to draw, and why."""
    said = "nothing to draw" + (f": {why}" if why else "")
    return ax.text(
        0.5, 0.5, said, transform=ax.transAxes, ha="center", va="center", color=Palette.of(ax).grey(0.35), wrap=True
    )


def beyond(ax: Any, said: str) -> Any:
    """Write a note in a corner of axes about the values that they do not show."""
    palette = Palette.of(ax)
    style = {"ha": "right", "va": "bottom", "fontsize": 8, "color": palette.grey(0.35), "bbox": palette.plate}
    return ax.text(0.99, 0.01, said, transform=ax.transAxes, zorder=5, **style)


def figure(function: Function) -> Function:
    """Return a figure's function that draws in our style, on new axes where `ax` is not given, and refuses a first
    argument that lacks what it reads.
    """
    first = next(iter(inspect.signature(function).parameters))

    @functools.wraps(function)
    def draw(*given: Any, ax: Any = None, **options: Any) -> Any:
        with imported("matplotlib", what="a figure").rc_context(SETTINGS):
            if ax is None:
                with styled():
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


def _inked(ax: Any) -> Any:
    """Return the context for drawing on axes; legends have the ground of these axes."""
    import matplotlib

    settings: Any = {**_inks(Palette.of(ax), Palette.of(ax.figure)), "axes.facecolor": ax.get_facecolor()}
    return matplotlib.rc_context(settings)


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
    _check_axes(ax)
    if ax.name != "rectilinear":
        raise ValueError(f"ax must be plain axes of two coordinates, got {ax.name} axes")
    if size is not None and not real("size", size) >= 0:
        raise ValueError(f"size must be >= 0 square points, got {size:g}")


def _check_axes(ax: Any) -> None:
    """Refuse what is no axes."""
    from matplotlib.axes import Axes

    if not isinstance(ax, Axes):
        raise TypeError(f"ax must be axes of Matplotlib, such as those of plt.subplots(), got {type(ax).__name__}")


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


def colour_map(ax: Any = None) -> Any:
    """Return the colour map of the package: cividis without the end that vanishes on the ground.

    Parameters
    ----------
    ax : matplotlib.axes.Axes, optional
        Axes whose ground counts. Default: new axes with the present settings of Matplotlib.

    Returns
    -------
    matplotlib.colors.Colormap
        The colour map. On a light ground it ends before the palest colours. On a dark ground its dark end is lifted.

    Raises
    ------
    TypeError
        If `ax` is no axes.

    Examples
    --------
    >>> fa.plot.colour_map().N
    256
    """
    matplotlib = imported("matplotlib", what="a figure")
    if ax is None:
        return _new_grounds(matplotlib.rcParams)[0].colour_map()
    _check_axes(ax)
    return Palette.of(ax).colour_map()


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
    colour = Palette.of(ax).grey(0.35)
    return [line for loop in loops for line in ax.plot(*loop, color=colour, lw=0.8)]
