"""Figures of orbits: curves of two coordinates, and the growth of their tangent vectors."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..runs.coordinates import chart_row
from ..runs.integrate import Orbits
from ..runs.schemes.catalogue import ITERATION
from ..runs.tangent_map import TangentMap
from .curves import above_rounding, axes_of, equal_axes, far_apart, in_space, smooth
from .picking import carry
from .sections import why
from .style import Artists, Palette, chosen_orbits, figure, nothing, symbol
from .winding import around_zero, broken

MOST = 40
"""Orbits drawn as curves by default."""

JOINED = 200
"""Iterates against their number that thin lines join: more of them would fill the figure."""


@figure
@inserts_parameters
def plot_orbits(
    result: Orbits, *, ax: Any = None, x: str | None = None, y: str | None = None, orbits: Any = None
) -> Artists:
    """Plot the samples of orbits in two coordinates, or in one against time.

    Parameters
    ----------
    result : Orbits
        Result of `integrate`. Without samples, the ends of the orbits are drawn.
    {ax}
    x, y : str, optional
        Coordinates or momenta, for a body of any chart; `x` may be ``"time"``. Default: the first two coordinates,
        alpha and beta for a body, all bodies for coordinates x1, y1, x2, y2, ..., time and the coordinate for one. A
        periodic coordinate that rotates is
        drawn within half a period around 0.
    orbits : sequence of int, optional
        Numbers of the orbits to draw. Default: up to 40.

    Returns
    -------
    Artists
        ``points`` are the curves; curves of failed orbits are grey. ``missing`` is the number of orbits not drawn. A
        click picks orbit and sample.

    Notes
    -----
    - Curves between samples are cubic polynomials, by the model's rates at the samples. They are chords if the model is
      not known or if the samples are farther apart than about a quarter of a turn. If their times are unequal too,
      the samples are dots.
    - Cartesian coordinates x, y, z have axes of one scale.

    Examples
    --------
    >>> orbits = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=10.0, samples=50)
    >>> len(fa.plot.plot_orbits(orbits, x="time", y="p_y").points)
    1
    """
    bodies = axes_of(tuple(result.names), x, y)
    z = result.z.reshape(len(result.z), -1)
    total = z.shape[1]
    status = np.atleast_1d(result.status).ravel()
    chosen = chosen_orbits(orbits, total, MOST)
    sampled = len(result.times) > 0
    dots = False
    iterated = getattr(result, "scheme", None) == ITERATION  # nothing lies between two iterates
    states, times = z[:, None, chosen], np.ravel(result.t)[None, chosen]
    if sampled:
        samples = result.samples.reshape(len(result.times), len(z), total).transpose(1, 0, 2)
        states, times = samples[:, :, chosen], result.times
        dots = far_apart(result, states, times)
        states, times = (states, times) if dots else smooth(result, states, times)
        times = times[:, None]
    gone = status[chosen] != Status.OK
    palette = Palette.of(ax)
    curves = []
    finite = False
    for number, (across, up) in enumerate(bodies):
        plain = [_row(result, states, times, name) for name in (across, up)]
        u, v = (around_zero(result, name, row) for name, row in zip((across, up), plain, strict=True))
        finite |= bool((np.isfinite(u) & np.isfinite(v)).any())
        for k in range(len(chosen)):
            alike = (number, len(bodies)) if len(bodies) > 1 else (k, len(chosen))
            colour, dashes = _look(palette, *alike)
            how: dict[str, Any] = {"marker": "o", "ls": "", "ms": 3.0}
            if sampled:
                how = {"marker": ".", "ls": "", "ms": 1.5} if iterated else {"lw": 0.8, "alpha": 0.85, "ls": dashes}
                how = {"marker": ".", "ls": "", "ms": 3.0} if dots else how
                if iterated and across == "time" and len(u) <= JOINED:
                    how = {"marker": ".", "ls": "-", "lw": 0.5, "ms": 4.0}
            if len(bodies) > 1:
                how |= {"marker": "o", "ms": 4.0, "markevery": [-1]}  # where each body is at the end
                how |= {"label": f"body {across[1:]}"} if k == 0 else {}
            U, V, moment = broken(u[:, k], v[:, k], (plain[0][:, k], plain[1][:, k]))
            (curve,) = ax.plot(U, V, color=palette.lost if gone[k] else colour, **how)
            nearest = np.rint(moment * (max(len(result.times), 1) - 1) / max(len(u) - 1, 1)).astype(int)
            curves.append(carry(curve, U, V, np.full(len(U), chosen[k]), nearest if result.z.ndim > 1 else None))
    _name(ax, curves, bodies, why(status[chosen], gone) if gone.any() or not finite else "", finite)
    if iterated and bodies[0][0] == "time":
        ax.set_xlabel("iterate $n$")
    return Artists(tuple(curves), None, (), (), total - len(chosen))


def _look(palette: Palette, number: int, curves: int) -> tuple[str, Any]:
    """Return colour and dashes of one of so many curves; up to five are told apart, in grey too."""
    looks = palette.curves
    return looks[number % len(looks)] if curves <= len(looks) else (palette.main, "-")


def _name(ax: Any, curves: list, bodies: list[tuple[str, str]], ended: str, finite: bool) -> None:
    """Name the axes and the curves, with the ends of orbits that failed, and set scales."""
    named = curves[:0] if len(bodies) < 2 else [curve for curve in curves if not curve.get_label().startswith("_")]
    if not finite:
        nothing(ax, ended)
    elif ended:
        named += ax.plot([], [], color=Palette.of(ax).lost, label=ended)
    if named:
        ax.legend(handles=named, loc="upper right")
    x, y = bodies[0]
    if len(bodies) > 1:
        ax.set(xlabel="$x$", ylabel="$y$")
    else:
        ax.set(xlabel="time $t$" if x == "time" else f"${symbol(x)}$", ylabel=f"${symbol(y)}$")
    if in_space(x, y):
        equal_axes(ax)
    elif finite:
        size = max(np.nanmax(np.abs(curve.get_data()[k]), initial=0.0) for curve in curves for k in (0, 1))
        above_rounding(ax, float(size) if np.isfinite(size) else 0.0)


def _row(result: Orbits, states: np.ndarray, times: np.ndarray, name: str) -> np.ndarray:
    """Return one coordinate (moments, orbits), by its name, of states (2n, moments, orbits) at times (moments, 1) or
    (moments, orbits).
    """
    if name == "time":
        return np.broadcast_to(times, states.shape[1:])
    if name in result.names:
        return states[result.names.index(name)]
    found = chart_row(states, name)
    if found is None:
        raise ValueError(f"x and y must be among {listed(result.names)}, or of a body's charts, got {shown(name)}")
    return found


@figure
@inserts_parameters
def plot_tangent_map(result: TangentMap, *, ax: Any = None) -> Artists:
    """Plot the lengths of the deviation vectors of each orbit.

    Parameters
    ----------
    result : TangentMap
        Result of `tangent_map`.
    {ax}

    Returns
    -------
    Artists
        ``points`` are the dots of each vector: log10 of its length against the number of the orbit. ``missing`` is the
        number of orbits that are not ``OK``. A click picks the orbit.

    Examples
    --------
    >>> tangent = fa.tangent_map(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=5.0, step=0.1)
    >>> fa.plot.plot_tangent_map(tangent).missing
    0
    """
    from matplotlib.ticker import MaxNLocator

    vectors = result.vectors.reshape(*result.vectors.shape[:2], -1)
    with np.errstate(all="ignore"):
        length = np.log10(np.sqrt((vectors**2).sum(axis=1)))
    fine = np.atleast_1d(result.status) == Status.OK
    length[:, ~fine] = np.nan
    number = np.arange(length.shape[1])
    marks = []
    curves = Palette.of(ax).curves
    for k, row in enumerate(length):
        colour = curves[k % len(curves)][0]
        (mark,) = ax.plot(number, row, ls="", marker="osD^v"[k % 5], ms=3.5, color=colour, label=str(k))
        marks.append(carry(mark, number, row, number))
    if not np.isfinite(length).any():
        nothing(ax, why(np.atleast_1d(result.status), ~fine))
    elif 1 < len(marks) <= 8:
        ax.legend(title="vector", loc="best")
    ax.set(xlabel="orbit", ylabel=r"growth  $\log_{10}|w|$")
    ax.xaxis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 2.5, 5, 10], integer=True))
    return Artists(tuple(marks), None, (), (), int(np.count_nonzero(~fine)))
