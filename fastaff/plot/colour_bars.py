"""Colour bars: arrows where values lie beyond them, and the threshold of an indicator among the ticks."""

from __future__ import annotations

from typing import Any

import numpy as np

from .scales import Colouring, stepped
from .style import Palette


def colour_bar(ax: Any, drawn: Any, colours: Colouring) -> Any:
    """Draw a colour bar with arrows where values lie beyond it and, for an indicator, its threshold among the ticks."""
    values = colours.values[np.isfinite(colours.values)]
    scale = drawn.norm
    below = bool((values < scale.vmin).any())
    above = bool((values > scale.vmax).any())
    extend = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}[below, above]
    threshold = colours.threshold
    if threshold is None or not scale.vmin < threshold < scale.vmax:
        return ax.figure.colorbar(drawn, ax=ax, label=colours.label, extend=extend)
    bar = ax.figure.colorbar(drawn, ax=ax, label=colours.label, extend=extend, spacing="uniform")
    room = [(scale.vmax - threshold) / 8, (threshold - scale.vmin) / 8]  # no tick so close to the threshold
    if getattr(scale, "vcenter", None) is None:
        room = [(scale.vmax - scale.vmin) / 16] * 2
    ticks = [t for t in _ticks(scale.vmin, threshold) if t < threshold - room[1]] + [
        t for t in _ticks(threshold, scale.vmax) if t > threshold + room[0]
    ]
    labels = [*(f"{t:g}" for t in ticks), f"threshold {threshold:.3g}"]
    bar.set_ticks([*ticks, threshold], labels=[text.replace("-", "\N{MINUS SIGN}") for text in labels])
    bar.ax.get_yticklabels()[-1].set_fontweight("bold")
    bar.ax.axhline(threshold, color="black", lw=1.6)
    if colours.falling:
        bar.ax.invert_yaxis()
    for where, text in ((0.25, "regular"), (0.75, "chaotic")) if stepped(colours) else ():
        ground = drawn.cmap(1.0 - where if colours.falling else where)
        style = {"rotation": 90, "ha": "center", "va": "center", "fontsize": 7.5, "color": Palette.on(ground[:3]).ink}
        bar.ax.text(0.5, where, text, transform=bar.ax.transAxes, **style)
    return bar


def plain_numbers(bar: Any) -> None:
    """Write the ticks of a logarithmic colour bar as numbers without powers."""
    from matplotlib.ticker import LogFormatter

    bar.ax.yaxis.set_major_formatter(LogFormatter())
    bar.ax.yaxis.set_minor_formatter(LogFormatter())


def _ticks(low: float, high: float) -> list[float]:
    from matplotlib.ticker import MaxNLocator

    return [float(t) for t in MaxNLocator(4).tick_values(low, high) if low <= t <= high]
