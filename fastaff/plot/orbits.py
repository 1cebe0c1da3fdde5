"""Figures of orbits: curves of two coordinates, and the growth of their tangent vectors."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..runs.coordinates import chart_row
from ..runs.integrate import Orbits
from ..runs.tangent_map import TangentMap
from .picking import carry
from .sections import why
from .style import DARK, GREY, LINES, Artists, chosen_orbits, figure, nothing, symbol
from .winding import around_zero, broken

MOST = 40
"""Orbits drawn as curves by default."""


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
        Coordinates or momenta, for a body of any chart; `x` may be ``"time"``. Default: the first two coordinates, and
        alpha and beta for a body. A periodic coordinate that rotates is drawn within half a period around 0.
    orbits : sequence of int, optional
        Numbers of the orbits to draw. Default: up to 40.

    Returns
    -------
    Artists
        ``points`` are the curves; curves of failed orbits are grey. ``missing`` is the number of orbits not drawn. A
        click picks orbit and sample.

    Examples
    --------
    >>> orbits = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=10.0, samples=50)
    >>> len(fa.plot.plot_orbits(orbits, x="time", y="p_y").points)
    1
    """
    body = len(result.z) == 8
    x = x or ("alpha" if body else result.names[0])
    y = y or ("beta" if body else result.names[1 % len(result.names)])
    z = result.z.reshape(len(result.z), -1)
    whole = result.z.ndim > 1
    samples = result.samples.reshape(len(result.times), len(z), z.shape[1]).transpose(1, 0, 2)
    status = np.atleast_1d(result.status).ravel()
    total = z.shape[1]
    chosen = chosen_orbits(orbits, total, MOST)
    states = samples if len(result.times) else z[:, None]
    plain = [_row(result, states, name) for name in (x, y)]
    u, v = (around_zero(result, name, row) for name, row in zip((x, y), plain, strict=True))
    curves = []
    for number, k in enumerate(chosen):
        if status[k] != Status.OK:
            colour = GREY
        elif len(chosen) <= 5:
            colour = LINES[number % len(LINES)][0]
        else:
            colour = DARK
        dashes = LINES[number][1] if len(chosen) <= 5 else "-"  # told apart in grey too
        mark: dict[str, Any] = {"marker": "o", "ls": "", "ms": 3.0}
        if len(result.times):
            mark = {"lw": 0.8, "alpha": 0.85, "ls": dashes}
        U, V, moment = broken(u[:, k], v[:, k], (plain[0][:, k], plain[1][:, k]))
        (curve,) = ax.plot(U, V, color=colour, **mark)
        curves.append(carry(curve, U, V, np.full(len(U), k), moment if whole else None))
    gone = status[chosen] != Status.OK
    if not (np.isfinite(u[:, chosen]) & np.isfinite(v[:, chosen])).any():
        nothing(ax, why(status[chosen], gone))
    elif gone.any():
        line = ax.plot([], [], color=GREY, label=why(status[chosen], gone))
        ax.legend(handles=line, loc="upper right")
    ax.set(xlabel="time $t$" if x == "time" else f"${symbol(x)}$", ylabel=f"${symbol(y)}$")
    return Artists(tuple(curves), None, (), (), total - len(chosen))


def _row(result: Orbits, states: np.ndarray, name: str) -> np.ndarray:
    """Return one coordinate (moments, orbits) of states (2n, moments, orbits), by its name."""
    if name == "time":
        times = result.times if len(result.times) else np.atleast_1d(result.t)
        return np.broadcast_to(times[:, None], states.shape[1:]) if len(result.times) else times[None]
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
    for k, row in enumerate(length):
        colour = LINES[k % len(LINES)][0]
        (mark,) = ax.plot(number, row, ls="", marker="osD^v"[k % 5], ms=3.5, color=colour, label=str(k))
        marks.append(carry(mark, number, row, number))
    if not np.isfinite(length).any():
        nothing(ax, why(np.atleast_1d(result.status), ~fine))
    elif 1 < len(marks) <= 8:
        ax.legend(title="vector", loc="best")
    ax.set(xlabel="orbit", ylabel=r"growth  $\log_{10}|w|$")
    ax.xaxis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 2.5, 5, 10], integer=True))
    return Artists(tuple(marks), None, (), (), int(np.count_nonzero(~fine)))
