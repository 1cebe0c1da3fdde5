"""Curves of orbits between their samples: cubic Hermite polynomials through states and their rates, and axes for them.

A chord between two samples cuts a corner, and the corners of an ellipse look like a precession. The equations give the
rates of coordinates and momenta at each sample, so that a cubic costs no integration.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..runs.requirements import current_system
from .style import MANY
from .winding import argument_of

PIECES = 8
"""Pieces of a curve between two samples: over half a radian they are within 1e-5 of the cubic."""

DIFFERENT = 0.3
"""Difference of a chord and the mean rate times the interval, relative to the larger rate, up to which a cubic is
drawn: 1.8 radians of a circle. Samples farther apart do not tell how the orbit went between them.
"""

UNEQUAL = 1e-6
"""Relative difference of intervals between samples that are equal."""

ROUNDING = 1e-9
"""Size of an orbit in one coordinate, relative to its largest coordinate, below which it is rounding."""


def smooth(result: Any, states: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return states (2n, moments, orbits) of a result with further moments between its own, and all the times.

    They are the given ones if the model or its rates are not known.
    """
    model = argument_of(result, "model")
    system = None if model is None else current_system(model)
    if system is None or system.iterated or system.driven or len(times) < 2 or not states.size:
        return states, times
    pieces = min(PIECES, MANY // (2 * states[0].size))
    with np.errstate(all="ignore"):
        rates = system.slopes(states)
    if pieces < 2 or rates.shape != states.shape:
        return states, times
    return hermite(states, rates, times, pieces)


def far_apart(result: Any, states: np.ndarray, times: np.ndarray) -> bool:
    """Tell whether unequal times (moments,) of states (2n, moments, orbits) of a result have an interval over which
    rates and chord of an orbit contradict each other, so that no line tells how it went.
    """
    h = np.diff(times)
    model = argument_of(result, "model")
    system = None if model is None else current_system(model)
    if system is None or system.iterated or system.driven or h.size < 2 or not states.size:
        return False
    with np.errstate(all="ignore"):
        rates = system.slopes(states)
        if np.ptp(h) <= UNEQUAL * h.max() or rates.shape != states.shape:
            return False
        chord = np.diff(states, axis=1)
        known = _known(chord, h[:, None] * rates[:, :-1], h[:, None] * rates[:, 1:])
    return bool((~known & np.isfinite(chord).all(axis=0)).any())


def _known(chord: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return a mask (intervals, orbits) of the intervals whose chord and rates, times the interval, agree."""
    with np.errstate(all="ignore"):
        apart = np.abs(0.5 * (start + end) - chord).max(axis=0)
        size = np.maximum(np.abs(start), np.abs(end)).max(axis=0)
        return apart <= DIFFERENT * size


def hermite(states: np.ndarray, rates: np.ndarray, times: np.ndarray, pieces: int) -> tuple[np.ndarray, np.ndarray]:
    """Return states (rows, moments, orbits) at so many moments for each interval between times (moments,), and these
    times: by cubics, or by chords where the rates and the chord contradict each other.
    """
    h = np.diff(times)[:, None]
    left, right = states[:, :-1], states[:, 1:]
    chord = right - left
    with np.errstate(all="ignore"):
        start, end = h * rates[:, :-1], h * rates[:, 1:]
    known = _known(chord, start, end)
    start = np.where(known, start, chord)
    end = np.where(known, end, chord)
    share = np.arange(pieces)[:, None] / pieces
    cubic = (
        left[:, :, None]
        + share * chord[:, :, None]
        + share * (1 - share) * ((1 - share) * (start - chord)[:, :, None] - share * (end - chord)[:, :, None])
    )
    fine = np.concatenate([cubic.reshape(len(states), -1, states.shape[2]), states[:, -1:]], axis=1)
    moments = (times[:-1, None] + np.diff(times)[:, None] * share.T).ravel()
    return fine, np.append(moments, times[-1])


BODY = ("a1", "a2", "b1", "b2")
"""Coordinates of an affinely-rigid body, which is drawn in alpha and beta."""


def planes_of(names: tuple[str, ...]) -> list[tuple[str, str]]:
    """Return the coordinates x and y of each body among names of rows: (x, y), or (x1, y1), (x2, y2), ..."""
    bodies = [name[1:] for name in names if name[:1] == "x" and (name[1:].isdigit() or name == "x")]
    return [(f"x{body}", f"y{body}") for body in bodies if f"y{body}" in names]


def axes_of(names: tuple[str, ...], x: str | None, y: str | None) -> list[tuple[str, str]]:
    """Return the names on the axes of an orbit's curves: those given, else of each of several bodies, else alpha and
    beta of a body, else of the first two coordinates, else of time and the only coordinate.
    """
    several = planes_of(names)
    if x is None and y is None and len(several) > 1:
        return several
    if len(names) == 1:
        return [(x or "time", y or names[0])]
    usual = ("alpha", "beta") if names[:4] == BODY else (names[0], names[1 % len(names)])
    return [(x or usual[0], y or usual[1])]


def in_space(x: str, y: str) -> bool:
    """Tell whether two names are Cartesian coordinates, so that both axes have one scale."""
    return x != y and x[:1] in "xyz" and y[:1] in "xyz" and x[1:] == y[1:] and (len(x) == 1 or x[1:].isdigit())


def equal_axes(ax: Any) -> None:
    """Give both axes one scale: within the frame, or by its shape if axes of other frames follow them."""
    shared = any(len(group.get_siblings(ax)) > 1 for group in (ax.get_shared_x_axes(), ax.get_shared_y_axes()))
    ax.set_aspect("equal", adjustable="box" if shared else "datalim")


def above_rounding(ax: Any, size: float) -> None:
    """Widen an axis that shows less than rounding of coordinates of a size around the middle of its values."""
    for axis in "xy":
        low, high = getattr(ax, f"get_{axis}lim")()
        if 0 < abs(high - low) < ROUNDING * size:
            middle = 0.5 * (low + high)
            middle = 0.0 if abs(middle) < ROUNDING * size else middle
            ax.set(**{f"{axis}lim": (middle - 0.1 * size, middle + 0.1 * size)})
