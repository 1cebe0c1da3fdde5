"""The look of all figures: colours, sizes and fonts in one place, in force while a figure is drawn and only then.

Colours are cividis, perceptually uniform and the same to people with any kind of colour vision, cut at its palest end
so that no point vanishes on white, and a few dark ones that differ by lightness too.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

DARK, ACCENT, PALE = "#00224e", "#b35900", "#5a8fc8"
"""The dark end of cividis, an orange and a blue that are told from it by lightness too."""
GREY, OUTLINE = "0.72", "0.35"
"""What has left or has no value, and the edge of what the energy reaches."""
LINES = (
    (DARK, "-"),
    (ACCENT, (0, (5, 1.5))),
    (PALE, "-."),
    ("#7f2a5f", (0, (1.5, 1))),
    ("#3d3d3d", (0, (7, 1.5, 1, 1.5, 1, 1.5))),
)
"""Colours and dashes of curves, in turn."""
PALE_END = 0.93
"""Where cividis is cut."""
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
}
"""Settings of Matplotlib while we draw."""

SYMBOLS = {
    "alpha": r"\alpha",
    "beta": r"\beta",
    "eta": r"\eta",
    "gamma": r"\gamma",
    "phi": r"\varphi",
    "psi": r"\psi",
    "kappa": r"\kappa",
    "lambda": r"\lambda",
    "lam": r"\lambda",
    "mu": r"\mu",
    "rho": r"\rho",
    "vartheta": r"\vartheta",
    "omega": r"\omega",
    "D1": "D_1",
    "D2": "D_2",
    "area": r"\mathrm{area}",
}

Function = TypeVar("Function", bound=Callable[..., Any])


class Artists(NamedTuple):
    """What a function drew: the points or cells, colour bar, lines with their labels, and the number of orbits not
    drawn.
    """

    points: Any
    colorbar: Any
    lines: tuple
    labels: tuple
    missing: int


def styled() -> Any:
    """Return the context in which figures are made; it leaves the settings of Matplotlib as they were."""
    import matplotlib

    return matplotlib.rc_context(SETTINGS)


def figure(function: Function) -> Function:
    """Return a figure's function that draws in our style, on new axes where `ax` is not given."""

    @functools.wraps(function)
    def draw(*given: Any, ax: Any = None, **options: Any) -> Any:
        with styled():
            if ax is None:
                import matplotlib.pyplot as plt

                ax = plt.subplots(layout="constrained")[1]
            return function(*given, ax=ax, **options)

    return cast(Function, draw)


def colour_map() -> Any:
    """Return cividis without its palest end."""
    import matplotlib
    import numpy as np
    from matplotlib.colors import ListedColormap

    return ListedColormap(matplotlib.colormaps["cividis"](np.linspace(0.0, PALE_END, 256)), name="fastaff")


def symbol(name: str) -> str:
    """Return the mathematical symbol, without dollars, of a coordinate, a momentum (p_...) or a frequency (nu_...)."""
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
    """Draw an `Edge` on both sides of momentum 0."""
    import numpy as np

    u, p = boundary.coordinate, boundary.momentum
    loop = np.concatenate([u, u[::-1], u[:1]]), np.concatenate([p, -p[::-1], p[:1]])
    return list(ax.plot(*loop, color=OUTLINE, lw=0.8))
