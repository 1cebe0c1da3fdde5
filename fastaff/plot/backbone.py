"""Backbone curves: the frequency of periodic orbits against the energy, or a parameter, of their families."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..periodic.bifurcations import Bifurcation, Event
from ..periodic.continuation import Branch
from ..periodic.found_orbits import Stability
from .parameters import parameter_label
from .picking import carry
from .style import Artists, Palette, figure, symbol

MARKS = {
    Event.FOLD: {"marker": "^", "label": "fold"},
    Event.PERIOD_DOUBLING: {"marker": "D", "label": "period doubling"},
    Event.NEIMARK_SACKER: {"marker": "s", "label": "Neimark-Sacker"},
}
"""Shapes of bifurcations; others are circles."""
FREQUENCY = "frequency"
PIECES = 12
"""Straight pieces that are drawn between two points."""
STABLE = (Stability.ELLIPTIC, Stability.PARABOLIC, Stability.ATTRACTING)


@figure
@inserts_parameters
def plot_backbone(
    branches: Branch | Sequence[Branch],
    *,
    ax: Any = None,
    parameter: str | None = None,
    y: str | None = None,
    angular: bool = False,
    names: Sequence[str] | None = None,
    bifurcations: bool = True,
) -> Artists:
    """Plot families of periodic orbits: frequency against energy, or amplitude against a parameter.

    Parameters
    ----------
    branches : Branch or sequence of Branch
        Families of `continuation`. Two branches continued in both directions from one orbit may have the same name.
    {ax}
    parameter : str, optional
        Name of the parameter of the continuation. Default: the energy, or ``"parameter"``.
    y : str, optional
        For a driven system or an ODE, the variable whose amplitude is drawn (a response curve), or ``"frequency"``.
        Default: the first variable. For a map of one variable, its name, which is the default: the points of the cycle.
    angular : bool, default False
        Draw 2 pi/T in radians per unit time instead of 1/T in cycles per unit time.
    names : sequence of str, optional
        Names of the families for the legend.
    bifurcations : bool, default True
        Mark bifurcations.

    Returns
    -------
    Artists
        ``points`` are the solid and dashed curves, NaN elsewhere, ``lines`` the marks of bifurcations and ``labels``
        the legend. ``missing`` is the number of points without a period. A click picks the point of a branch.

    Notes
    -----
    - Solid: stable, that is elliptic (multipliers on the unit circle) or attracting. Dashed: others.
    - Curves are cubic splines in the arclength.
    - T is the period of the whole orbit in time. For relative periodic orbits it is the period of the reduced motion.

    References
    ----------
    Kerschen et al. 2009, Mech. Syst. Signal Process. 23, 170 (frequency-energy plots of nonlinear normal modes).

    Examples
    --------
    >>> family = fa.continuation(
    ...     fa.HenonHeiles(), [0.0, 0.0, 0.3, 0.31], section="x=0", energy=0.1, max_steps=2, max_time=20.0
    ... )
    >>> fa.plot.plot_backbone(family).missing
    0
    """
    listed = [branches] if isinstance(branches, Branch) else list(branches)
    if names is not None and len(names) != len(listed):
        raise ValueError(f"names must have {len(listed)} entries, one for each branch, got {len(names)}")
    row = _row(listed, y)
    one = _one_variable(listed, y)
    turn = 2 * math.pi if angular else 1.0
    palette = Palette.of(ax)
    seen: dict[str, int] = {}
    curves: list[Any] = []
    handles: list[Any] = []
    missing = 0
    for number, branch in enumerate(listed):
        name = str(number) if names is None else names[number]
        known = name in seen
        kind = seen.setdefault(name, len(seen)) % len(palette.curves)
        colour = palette.curves[kind][0]
        fine = (branch.orbits.status == Status.OK) & np.isfinite(branch.orbits.period)
        missing += int(np.count_nonzero(~fine))
        with np.errstate(all="ignore"):
            height = turn / branch.orbits.period if row is None or branch.amplitude is None else branch.amplitude[row]
        heights = branch.orbits.points[0] if one else height[None]
        stable = np.isin(branch.orbits.stability, STABLE)
        for height in heights:
            point, along, across = _smooth(branch.arclength, branch.parameter, np.where(fine, height, np.nan))
            # A piece has the kind of the point at its end, so that curves of two kinds meet.
            ends = np.minimum([np.ceil(point), np.floor(point) + 1], len(stable) - 1).astype(np.int64)
            for steady in (True, False):
                own = np.where((stable[ends] == steady).any(axis=0), across, np.nan)
                look = {"ls": "-", "lw": 1.7} if steady else {"ls": (0, (3, 1.6)), "lw": 1.2}
                (curve,) = ax.plot(along, own, color=colour, **look)
                carry(curve, along, own, np.rint(point).astype(np.int64))
                curves.append(curve)
        if names is not None:  # marks tell them apart in grey
            shape: dict[str, Any] = {"color": colour, "marker": "osD^v"[kind], "ms": 4.5}
            some = (len(along) * np.array([1, 3, 5])) // 6
            ax.plot(along[some], across[some], ls="", **shape)
            handles += [] if known else ax.plot([], [], lw=1.7, label=name, **shape)
    marks = _marked(ax, listed, turn, row, one) if bifurcations else []
    dashed = any(np.isfinite(curve.get_ydata()).any() for curve in curves[1::2])
    handles += ax.plot([], [], color=palette.grey(0.3), lw=1.7, label="stable")
    handles += ax.plot([], [], color=palette.grey(0.3), lw=1.2, ls=(0, (3, 1.6)), label="unstable") if dashed else []
    handles += [mark for mark in marks if not str(mark.get_label()).startswith("_")]
    legend = ax.legend(handles=handles, loc="best")
    turned = r"2\pi" if angular else "1"
    unit = "radians per unit time" if angular else "cycles per unit time"
    rate = rf"frequency ${turned}/T$  ({unit})"
    ax.set(
        xlabel=parameter_label(parameter or _followed(listed)),
        ylabel=rate if row is None else f"amplitude of ${symbol(listed[0].names[row])}$",
    )
    if one:
        ax.set_ylabel(f"${symbol(listed[0].names[0])}$")
    return Artists(tuple(curves), None, tuple(marks), tuple(legend.get_texts()), missing)


def _one_variable(branches: Sequence[Branch], y: str | None) -> bool:
    """Tell whether the height of a figure is the only variable of a map: its frequency is 1 over a whole number."""
    maps = bool(branches) and all(len(branch.names) == 1 and branch.orbits.section is None for branch in branches)
    return maps and y in (None, branches[0].names[0])


def _row(branches: Sequence[Branch], y: str | None) -> int | None:
    """Return the row of `amplitude` that is the height of a figure; None for the frequency."""
    forced = bool(branches) and all(branch.amplitude is not None for branch in branches)
    names = branches[0].names if forced else ()
    if _one_variable(branches, y):
        return None
    if y == FREQUENCY or (y is None and not forced):
        return None
    if y is not None and y not in names:
        raise ValueError(f"y must be one of {listed((*names, FREQUENCY))}, got {shown(y)}")
    return 0 if y is None else names.index(y)


def _followed(branches: Sequence[Branch]) -> str:
    """Return the name of the quantity along which the branches were followed."""
    calls = [getattr(branch, "call", None) for branch in branches]
    own = any(call is not None and call.arguments.get("parameter") is not None for call in calls)
    return "parameter" if own else "energy"


def _smooth(arclength: np.ndarray, value: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the curve through the points of a branch, with points between: their numbers, values and heights. Straight
    where points are too few, or without a height.
    """
    from scipy.interpolate import CubicSpline

    shares = np.linspace(0.0, 1.0, PIECES, endpoint=False)
    point = np.append(np.add.outer(np.arange(len(value) - 1), shares).ravel(), len(value) - 1.0)
    number = np.arange(len(value))
    rows = np.array([[*np.interp(point, number, row)] for row in (value, height)])
    if len(value) > 2 and np.isfinite(height).all() and (np.diff(arclength) > 0).all():
        at = np.interp(point, number, arclength)
        between = point % 1 > 0
        rows[:, between] = CubicSpline(arclength, [value, height], axis=1)(at[between])
    return point, rows[0], rows[1]


def _marked(ax: Any, branches: Sequence[Branch], turn: float, row: int | None, one: bool = False) -> list[Any]:
    """Mark the bifurcations of branches, each kind with a shape of its own."""
    marks: list[Any] = []
    for kind in Event:
        found = [event for branch in branches for event in branch.bifurcations if event.event == kind]
        if found:
            marks.append(_mark(ax, found, kind, turn, row, one))
    return marks


def _mark(ax: Any, found: Sequence[Any], kind: Event, turn: float, row: int | None = None, one: bool = False) -> Any:
    look = MARKS.get(kind, {"marker": "o", "label": kind.name.lower().replace("_", " ")})
    x = [event.parameter for event in found]
    y = [e.z[0] if one else turn / e.period if row is None else e.amplitude[row] for e in found]
    palette = Palette.of(ax)
    style = {"ls": "", "ms": 6.0, "mfc": palette.ground, "mec": palette.ink, "mew": 1.0, "zorder": 4}
    (mark,) = ax.plot(x, y, **style, **look)
    return mark


@figure
@inserts_parameters
def plot_bifurcation(
    bifurcation: Bifurcation, *, ax: Any = None, parameter: str = "energy", angular: bool = False
) -> Artists:
    """Mark a bifurcation on a plot of `plot_backbone`.

    Parameters
    ----------
    bifurcation : Bifurcation
        Bifurcation of a `Branch`.
    {ax}
    parameter : str, default "energy"
        Name of the parameter of the continuation.
    angular : bool, default False
        Use 2 pi/T in radians per unit time instead of 1/T in cycles per unit time.

    Returns
    -------
    Artists
        ``points`` is the mark, of the same shape as in `plot_backbone`.

    Examples
    --------
    >>> model = fa.models.StandardMap
    >>> family = fa.continuation(model, [np.pi, 0.0], parameter=3.5, bounds=(3.5, 4.5), max_steps=60)
    >>> fa.plot.plot_bifurcation(family.bifurcations[0], parameter="K").points.get_xdata().round(6)
    array([4.])
    """
    if not isinstance(bifurcation, Bifurcation):
        raise TypeError(
            f"bifurcation must be one of branch.bifurcations, got {shown(bifurcation)}. Use branch.plot() to draw all."
        )
    mark = _mark(ax, [bifurcation], bifurcation.event, 2 * math.pi if angular else 1.0)
    ax.annotate(
        mark.get_label(),
        (bifurcation.parameter, mark.get_ydata()[0]),
        xytext=(7, 5),
        textcoords="offset points",
    )
    if not ax.get_xlabel():
        ax.set(xlabel=parameter_label(parameter), ylabel=r"frequency $2\pi/T$" if angular else "frequency $1/T$")
    return Artists(mark, None, (mark,), (), 0)
