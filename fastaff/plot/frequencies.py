"""Figures of frequency maps: orbits in the plane of two frequencies, with lines of resonances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core.classification import Classification
from ..core.docstrings import inserts_parameters
from ..core.numbers import entries, reals
from ..core.status import Status
from ..frequencies.frequencies import FrequencyMap
from ..frequencies.orbit_family import START_VALUES, start_values
from ..frequencies.own_lines import TURN, by_own_lines, in_time, in_turns
from ..frequencies.tunes import Tunes
from .colour_bars import colour_bar
from .labels import LabelBox, drawn_points, settled, write_along
from .picking import carry
from .ratios import frequencies_of, frequency, lines_of
from .resonances import formula
from .scales import colouring, colours_of, orbit_colours
from .sections import why
from .style import Artists, Palette, beyond, figure, nothing, symbol

LABELS = {
    "energy": "energy $E$",
    "angular_momentum": "angular momentum $L_z$ of the initial condition",
    "radius": "radius $r$ of the initial condition",
}
"""Names of the axes with values of initial conditions."""

FEW = 20
"""Fewest orbits of which some may be left out of the frame as far away."""


@figure
@inserts_parameters
def plot_frequency_map(
    frequency_map: FrequencyMap | Tunes,
    *,
    ax: Any = None,
    x: str | None = None,
    y: str | None = None,
    frequencies: Any = None,
    values: Any = None,
    lines: Sequence[Sequence[int]] | Sequence[int] | str = (),
    shown: Any = None,
    norm: Any = None,
    vmin: float | None = None,
    vmax: float | None = None,
    label: str | None = None,
    size: float | None = None,
    colorbar: bool = True,
    limits: tuple | None = None,
) -> Artists:
    """Plot orbits in the plane of two frequencies or frequency ratios, with resonance lines.

    Parameters
    ----------
    frequency_map : FrequencyMap or Tunes
        Frequencies of the orbits.
    {ax}
    x, y : str, optional
        Frequencies or ratios such as ``"beta/alpha"``, or ``"energy"``, ``"angular_momentum"`` or ``"radius"`` of the
        initial conditions, which are known for a result of `frequency_map`. Default: for a body, second row and gamma
        to the first row; for other flows of three or more coordinates, the first two rows to the third; else the two
        rows.
    frequencies : array_like, shape (n, orbits), optional
        Frequencies to draw, for example ``freq.nu`` or ``freq.dominant``. Default: the frequencies of `frequency`.
    values : array_like, shape (orbits,), str or Colouring, optional
        Colours: values, a column of the map, or a `Colouring` of another result of the same orbits. Default: the
        diffusion of the map on its `diffusion_scale`.
    lines : sequence of int, sequence of these, or str, optional
        Integers (k1, k2, k0) of each line k1 X + k2 Y + k0 = 0. For ratios to one frequency it is a resonance k . nu =
        0. The text ``"order<=5"`` draws all lines up to an order: ``|k1| + |k2| + |k0|`` for ratios, ``|k1| + |k2|``
        for tunes and for frequencies in time, whose k0 is 0.
    shown : array_like of bool, shape (orbits,), optional
        Orbits to draw. Default: all.
    {norm}
    {colour_range}
    {colour_label}
    {dot_size}
    {colorbar}
    limits : tuple, optional
        Limits (x0, x1), (y0, y1) of the axes. Default: the limits of all orbits, without a few or irregular orbits that
        lie far away. A note has the number of orbits beyond.

    Returns
    -------
    Artists
        ``missing`` is the number of orbits that are not ``OK`` or not shown. Vertical lines n X = m are labelled m:n
        above the frame, others by their equation. A label without room is left out. A click picks the orbit.

    Notes
    -----
    A note has the number of regular orbits that are drawn in another basis than the dominant line of each coordinate.

    Examples
    --------
    >>> freq = fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0)
    >>> fa.plot.plot_frequency_map(freq, lines="order<=3").missing
    0
    """
    if len(frequency_map.names) == 1:
        return _one_frequency(frequency_map, ax)
    x, y = _plane(frequency_map, x, y)
    X, Y = (_axis(frequency_map, name, frequencies) for name in (x, y))
    values = colouring(frequency_map) if values is None else values
    values = orbit_colours(frequency_map, values, X.size, norm, vmin, vmax, label)
    c = values.values
    good = (frequency_map.status == Status.OK) & np.isfinite(X) & np.isfinite(Y) & np.isfinite(c)
    good &= np.ones(good.shape, bool) if shown is None else np.asarray(shown)
    order = np.random.default_rng(0).permutation(np.flatnonzero(good))
    area = size if size is not None else float(np.clip(24000 / max(order.size, 1), 1.2, 16.0))
    how = {"cmap": colours_of(values, Palette.of(ax)), "norm": values.norm}
    points = ax.scatter(X[order], Y[order], c=c[order], s=area, linewidths=0, rasterized=True, zorder=2, **how)
    carry(points, X[order], Y[order], order)
    calm = frequency_map.regular[order]
    calm = calm if np.count_nonzero(calm) >= FEW else np.ones(order.shape, bool)
    notes = in_frame(ax, X[order], Y[order], calm, limits) + _other_basis(frequency_map, frequencies, good)
    gone = ~good if shown is None else ~good & np.asarray(shown)
    if order.size and gone.any():
        notes.append(f"{np.count_nonzero(gone)} of {good.size} orbits not drawn: {why(frequency_map.status, gone)}")
    noted = [beyond(ax, "\n".join(notes))] if notes else []
    letter = letter_of(frequency_map)
    per = "turn" if letter == "Q" else "unit time"
    ax.set(xlabel=_axis_label(x, per, letter), ylabel=_axis_label(y, per, letter))
    bar = colour_bar(ax, points, values._replace(values=c[good])) if colorbar else None
    if not order.size:
        nothing(ax, why(frequency_map.status, ~good) if good.size else "")
    chosen = lines_of(lines, x, y, (ax.get_xlim(), ax.get_ylim()), turns=not in_time(frequency_map))
    if chosen and {x, y} & set(START_VALUES):
        raise ValueError(f"lines must be empty if an axis is no frequency, got x={x!r} and y={y!r}")
    drawn, labels = _draw_lines(ax, chosen, x, y, noted, letter)
    return Artists(points, bar, drawn, labels, int(np.count_nonzero(~good)))


@figure
@inserts_parameters
def plot_tunes(tunes: Tunes, *, ax: Any = None, values: Any = None, **options: Any) -> Artists:
    """Plot orbits in the plane of their tunes, modulo 1, or the tune of one plane from orbit to orbit.

    Parameters
    ----------
    tunes : Tunes
        Result of `tunes`.
    {ax}
    values : array_like, shape (orbits,), str or Colouring, optional
        Colours. Default: the diffusion.
    **options : Any
        Other options of `plot_frequency_map`. Its resonance lines k1 X + k2 Y + k0 = 0 are resonances of tunes.

    Returns
    -------
    Artists
        ``missing`` is the number of orbits that are not ``OK`` or not shown. A click picks the orbit.

    Examples
    --------
    >>> turn = 2 * np.pi * 0.28 * np.arange(300)
    >>> fa.plot.plot_tunes(fa.tunes([2 * np.cos(turn), -np.sin(turn)])).missing
    0
    """
    if values is None and tunes.diffusion.size:
        values = colouring(tunes)
    if len(tunes.names) > 1:
        found = plot_frequency_map(tunes, ax=ax, values=values, **options)
        x, y = (options.get(axis) or tunes.names[k] for k, axis in enumerate("xy"))
        ax.set(xlabel=f"${fraction(x, 'Q')}$", ylabel=f"${fraction(y, 'Q')}$")
        return found
    return _one_frequency(tunes, ax)


def _plane(found: Any, x: str | None, y: str | None) -> tuple[str, str]:
    """Return the names of the two frequencies or ratios to draw; by default those that tell its orbits apart."""
    names = found.names
    if x in START_VALUES and y is None:
        return str(x), f"{names[1]}/{names[0]}"
    if getattr(found, "nu_eta", None) is not None:
        return x or f"{names[1]}/{names[0]}", y or f"gamma/{names[0]}"
    usual = tuple(names)
    if by_own_lines(found) and len(names) > 2 and "/" in (x or y or "/"):
        usual = f"{names[0]}/{names[2]}", f"{names[1]}/{names[2]}"
    if x is None and y is None:
        return usual[0], usual[1]
    other = next((name for name in usual if name not in (x, y)), usual[0])
    return x or other, y or other


def _axis(found: Any, name: str, frequencies: Any) -> np.ndarray:
    """Return the values (orbits,) on an axis: of initial conditions, a frequency or a ratio."""
    return start_values(found)[name] if name in START_VALUES else frequency(found, name, frequencies)


def _axis_label(name: str, per: str, letter: str) -> str:
    """Return the label of an axis; per: the unit of time of frequencies, letter: their symbol."""
    if name in START_VALUES:
        return LABELS[name]
    return f"${fraction(name, letter)}$" + ("" if "/" in name else f"  (cycles per {per})")


def _other_basis(found: Any, frequencies: Any, good: np.ndarray) -> list[str]:
    """Return the note on the number of regular orbits drawn by other frequencies than the dominant lines."""
    if not by_own_lines(found):
        return []
    off = np.abs(frequencies_of(found, frequencies) - found.dominant) > found.error + found.dominant_error
    many = np.count_nonzero(off.any(axis=0) & found.regular & good)
    return [f"{many} of {np.count_nonzero(good)} orbits by another basis"] if many else []


def in_frame(ax: Any, X: np.ndarray, Y: np.ndarray, calm: np.ndarray, limits: tuple | None) -> list[str]:
    """Set the frame, by default around all orbits but a few that lie far off, and those that are not `calm`; return the
    note with their number.
    """
    if limits is not None:
        wide, high = (reals("limits", pair) for pair in entries("limits", limits, "((x0, x1), (y0, y1))", 2))
        ax.set(xlim=wide, ylim=high)
        return []
    wide = _bulk(X[calm], ax.get_xlim())
    high = _bulk(Y[calm], ax.get_ylim())
    ax.set(xlim=wide, ylim=high)
    inside = (wide[0] <= X) & (wide[1] >= X) & (high[0] <= Y) & (high[1] >= Y)
    if inside.all():
        return []
    return [f"{np.count_nonzero(~inside)} of {X.size} orbits beyond the axes"]


def _bulk(values: np.ndarray, whole: tuple[float, float]) -> tuple[float, float]:
    """Return the ends of an axis: the whole, or where all but a fiftieth of the values take little, those of these.

    Of fewer than 100 values it is the first and the last.
    """
    if values.size < FEW:
        return whole
    share = max(0.01, 1 / (values.size - 1))
    low, high = np.quantile(values, [share, 1 - share])
    edge = 0.08 * (high - low)
    return whole if edge == 0 or whole[1] - whole[0] < 3 * (high - low + 2 * edge) else (low - edge, high + edge)


def _one_frequency(found: Any, ax: Any) -> Artists:
    """Draw the only frequency of a system of one degree of freedom, from orbit to orbit, chaotic ones grey."""
    good = (found.status == Status.OK) & np.isfinite(found.error[0])
    numbers = np.flatnonzero(good)
    calm = found.classification[good] != Classification.IRREGULAR
    palette = Palette.of(ax)
    colours = [palette.main if regular else palette.lost for regular in calm]
    points = ax.scatter(numbers, found.nu[0, good], c=colours, s=12.0, linewidths=0)
    ax.set(xlabel="orbit", ylabel=f"${fraction(found.names[0], letter_of(found))}$")
    carry(points, numbers, found.nu[0, good], numbers)
    return Artists(points, None, (), (), int(np.count_nonzero(~good)))


def fraction(name: str, letter: str = "nu") -> str:
    """Return the symbol of a frequency or of a ratio of two."""
    numerator, slash, denominator = name.partition("/")
    top = symbol(f"{letter}_{numerator}")
    return f"{top}/{symbol(f'{letter}_{denominator}')}" if slash else top


def letter_of(found: Any) -> str:
    """Return the letter of frequencies: Q for tunes, in cycles per turn."""
    return "Q" if in_turns(found) else "nu"


def _draw_lines(
    ax: Any, lines: Sequence[Sequence[int]], x: str, y: str, noted: Sequence[Any] = (), letter: str = "nu"
) -> tuple[tuple, tuple]:
    """Draw k1 X + k2 Y + k0 = 0 inside the present limits, lowest orders first; label those with room beside the notes
    on the figure. letter: of the frequencies.
    """
    from matplotlib.patheffects import withStroke

    x0, x1 = ax.get_xlim()
    y0, y1 = ax.get_ylim()
    palette = Palette.of(ax)
    drawn: list[Any] = []
    labels: list[Any] = []
    taken: list[float] = []
    slanted: list[tuple[np.ndarray, str]] = []
    for k1, k2, k0 in sorted((tuple(line) for line in lines), key=lambda k: sum(map(abs, k))):
        order = abs(k1) + abs(k2) + abs(k0)
        style = {"color": palette.grey(0.25), "lw": float(np.clip(6.0 / order, 0.5, 1.1)), "zorder": 1, "alpha": 0.75}
        if k2 == 0 and k1:
            at = -k0 / k1
            if not x0 < at < x1:
                continue
            drawn.append(ax.axvline(at, **style))
            place = (at - x0) / (x1 - x0)
            if all(abs(place - other) > 0.075 for other in taken):
                taken.append(place)
                labels.append(
                    ax.text(place, 1.012, f"{-k0}:{k1}", transform=ax.transAxes, ha="center", va="bottom", fontsize=8)
                )
        elif k2:
            ends = [(u, -(k1 * u + k0) / k2) for u in np.linspace(x0, x1, 200)]
            inside = np.array([(u, v) for u, v in ends if y0 < v < y1])
            if len(inside) < 2:
                continue
            style.update(ls=(0, (4, 2.5)))
            drawn += ax.plot(*inside[[0, -1]].T, **style)
            names = *(name.partition("/")[0] for name in (x, y)), x.partition("/")[2] or TURN
            slanted.append((inside, formula((k1, k2, k0), names, letter)))
    ax.set(xlim=(x0, x1), ylim=(y0, y1))
    if slanted:
        settled(ax)
        extents = [note.get_window_extent() for note in noted]
        room = [LabelBox(np.mean([box.min, box.max], axis=0), np.array(box.size) / 2, 0.0) for box in extents]
        dots = drawn_points(ax)
        how = {"path_effects": [withStroke(linewidth=2.0, foreground=palette.ground)]}
        written = [write_along(ax, curve, text, room, lift=0.6, points=dots, **how) for curve, text in slanted]
        labels += [text for text in written if text is not None]
    return tuple(drawn), tuple(labels)
