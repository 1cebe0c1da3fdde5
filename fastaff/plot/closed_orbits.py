"""Periodic orbits as closed curves, integrated over one period."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..periodic.found_orbits import PeriodicOrbits, Stability
from ..runs.coordinates import chart_row
from ..runs.integrate import integrate
from ..runs.requirements import current_system
from .curves import above_rounding, axes_of, equal_axes, in_space, smooth
from .periodic import number_text
from .picking import carry
from .sections import why
from .style import Artists, Palette, chosen_orbits, figure, nothing, symbol
from .winding import argument_of, around_zero, broken

MOST = 40
"""Orbits drawn by default."""

SAMPLES = 256
"""Samples in a period for each crossing of the section; at most LONGEST."""

LONGEST = 4096
"""Samples in a period."""

SAME = 0.01
"""Distance of two halves of a curve, relative to its size, below which an orbit goes back the way it came."""

NAMED = 8
"""Curves that a legend names one by one."""

MORE = ("#009e73", "#cc79a7", "#808080")
"""Colours of curves after those of the palette, up to NAMED, seen on light and dark grounds (Okabe & Ito 2008, Color
Universal Design).
"""

STABLE = (Stability.ELLIPTIC, Stability.PARABOLIC, Stability.ATTRACTING)
"""Kinds that are drawn as whole lines; others are dashed."""


def has_curves(orbits: PeriodicOrbits) -> bool:
    """Tell whether the model of periodic orbits is known and moves between their points."""
    model = argument_of(orbits, "model")
    return model is not None and not current_system(model).iterated


@figure
@inserts_parameters
def plot_closed_orbits(
    orbits: PeriodicOrbits,
    *,
    ax: Any = None,
    x: str | None = None,
    y: str | None = None,
    numbers: Any = None,
    legend: bool = True,
) -> Artists:
    """Plot periodic orbits as closed curves, with their stability, period and residue.

    Parameters
    ----------
    orbits : PeriodicOrbits
        Result of `periodic_orbits` for a flow. Orbits that are not ``OK`` are not drawn.
    {ax}
    x, y : str, optional
        Coordinates or momenta, for a body of any chart. Default: the first two coordinates, alpha and beta for a body,
        all bodies for coordinates x1, y1, x2, y2, ...
    numbers : sequence of int, optional
        Numbers of the orbits to draw. Default: up to 40.
    legend : bool, default True
        Name up to 8 curves.

    Returns
    -------
    Artists
        ``points`` are the curves, dashed if the orbit is unstable. ``missing`` is the number of orbits not drawn. A
        click picks the orbit.

    Raises
    ------
    ValueError
        If a name is unknown, or the model is a map or not known. Use `plot_periodic` for the points of maps.

    Notes
    -----
    Each orbit is integrated over one period. Cartesian coordinates have axes of one scale.

    Examples
    --------
    >>> orbit = fa.periodic_orbits(fa.HenonHeiles(), [0.0, 0.3, 0.4, 0.0], section="x=0", energy=0.1, max_time=20.0)
    >>> curve = fa.plot.plot_closed_orbits(orbit).points[0].get_xydata()
    >>> bool(abs(curve[-1] - curve[0]).max() < 1e-8)
    True
    """
    drawn = orbits.status == Status.OK  # which refuses what has no status, before the model is sought
    if not has_curves(orbits):
        raise ValueError("orbits must be those of a flow whose model is known, got others. Try plot_periodic.")
    model = argument_of(orbits, "model")
    chosen = chosen_orbits(numbers, drawn.size, MOST, "numbers")
    chosen = chosen[drawn[chosen]]
    pairs = axes_of(tuple(orbits.names), x, y)
    curves = []
    palette = Palette.of(ax)
    for number, k in enumerate(chosen):
        states = _closed(orbits, model, int(k))
        for body, names in enumerate(pairs):
            plain = [_row(orbits, states, name) for name in names]
            u, v = (around_zero(orbits, name, row)[:, 0] for name, row in zip(names, plain, strict=True))
            U, V, _ = broken(u, v, (plain[0][:, 0], plain[1][:, 0]))
            U, V = _once(U, V)
            kind = Stability(int(orbits.stability[k]))
            look = number if len(pairs) == 1 else body
            few = max(len(chosen), len(pairs)) <= NAMED
            colours = [*(colour for colour, _ in palette.curves), *MORE]
            colour = colours[look] if few else palette.main
            label = _label(orbits, int(k), kind) if body == 0 else None
            (curve,) = ax.plot(U, V, color=colour, lw=1.2, ls="-" if kind in STABLE else (0, (4, 1.5)), label=label)
            curves.append(carry(curve, U, V, np.full(len(U), k)))
    if not curves:
        nothing(ax, why(orbits.status, ~drawn))
    elif legend and len(chosen) <= NAMED:
        named = [curve for curve in curves if not curve.get_label().startswith("_")]
        ax.legend(handles=named, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2 if len(named) > 3 else 1)
    first, second = ("x", "y") if len(pairs) > 1 else pairs[0]
    ax.set(xlabel=f"${symbol(first)}$", ylabel=f"${symbol(second)}$")
    if in_space(first, second):
        equal_axes(ax)
    elif curves:
        above_rounding(ax, max(float(np.nanmax(np.abs(curve.get_xydata()))) for curve in curves))
    return Artists(tuple(curves), None, (), (), int(drawn.size - chosen.size))


def _closed(orbits: PeriodicOrbits, model: Any, k: int) -> np.ndarray:
    """Return the states (2n, moments, 1) of one orbit over its period, the first of them also the last."""
    samples = int(min(SAMPLES * max(orbits.crossings[k], 1), LONGEST))
    start = orbits.z[:, [k]]
    run = integrate(model, start, time=float(orbits.period[k]), samples=samples)
    states = np.concatenate([start[None], run.samples]).transpose(1, 0, 2)
    return smooth(run, states, np.concatenate([[0.0], run.times]))[0]


def _once(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a closed curve, or its half from one turning point to the other if an orbit goes back the way it came:
    drawn twice, dashes would make a whole line.
    """
    moments = len(u) - 1
    slowest = int(np.hypot(np.diff(u), np.diff(v)).argmin())
    for turn in (slowest, slowest + 1):
        order = (turn + np.arange(moments + 1)) % moments
        apart = np.hypot(u[order] - u[order[::-1]], v[order] - v[order[::-1]])
        if apart.max() < SAME * max(np.ptp(u), np.ptp(v)):
            return u[order[: moments // 2 + 1]], v[order[: moments // 2 + 1]]
    return u, v


def _row(orbits: PeriodicOrbits, states: np.ndarray, name: str) -> np.ndarray:
    """Return one coordinate (moments, 1) of states by its name."""
    if name in orbits.names:
        return states[orbits.names.index(name)]
    found = chart_row(states, name)
    if found is None:
        raise ValueError(f"x and y must be among {listed(orbits.names)}, or of a body's charts, got {shown(name)}")
    return found


def _label(orbits: PeriodicOrbits, k: int, kind: Stability) -> str:
    """Return the entry of an orbit in a legend: its number, kind, period and residue."""
    said = f"{k}: {kind.name.lower().replace('_', ' ')}, $T = {orbits.period[k]:.4g}$"
    residue = float(orbits.residue[k]) if orbits.symplectic else np.nan
    return said + (f", residue ${number_text(residue)}$" if np.isfinite(residue) else "")
