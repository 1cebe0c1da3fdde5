"""The dynamic aperture: the number of turns that particles survive, over the amplitude and angle of their starts."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import numbers, whole
from ..core.status import Status
from ..runs.starts import ordered
from .picking import carry
from .style import ACCENT, Artists, beyond, colour_map, figure, symbol

FAR = 4.0
"""Starts beyond so many times the largest amplitude of the aperture, all lost, lie outside of the frame."""

BINS = 15
"""Bins of the angle if the starts have too many angles of their own."""


@figure
@inserts_parameters
def plot_aperture(
    result: Any, z0: Any, *, ax: Any = None, x: int = 0, y: int = 1, bins: int | None = None, colorbar: bool = True
) -> Artists:
    """Plot the time that orbits survived over angle and amplitude of their initial conditions.

    Parameters
    ----------
    result : Result
        Result with ``t`` and ``status`` of shape (orbits,), for example of `integrate` or `frequency_map` for a map, or
        of `tunes`.
    z0 : array_like, shape (2n, orbits), EnergyGrid or EnergySample
        Initial conditions of the orbits. A grid of x and y is drawn over x and y.
    {ax}
    x, y : int, default 0 and 1
        Rows of `z0` with r cos a and r sin a, for amplitude r and angle a.
    bins : int, optional
        Number of bins of the angles. Default: the angles themselves if they are few.
    {colorbar}

    Returns
    -------
    Artists
        ``points`` are the initial conditions and ``lines`` the aperture: at each angle, the largest amplitude up to
        which all orbits survived. If no orbit is lost at an angle, a mark means "at least". ``labels`` has the least,
        mean and largest aperture; ``missing`` is 0. A click picks the orbit. A note has the number of initial
        conditions far beyond the aperture, outside of the frame.

    Examples
    --------
    >>> starts = np.array([[0.1, 0.2, 2.0], [0.0, 0.0, 0.0]])
    >>> turns = fa.integrate(fa.models.HenonMap(), starts, time=100)
    >>> [text.get_text() for text in fa.plot.plot_aperture(turns, starts).labels]
    ['aperture 0.2 to 0.2, mean 0.2']
    """
    z0 = numbers("z0", ordered("z0", getattr(z0, "z0", z0), lambda: [tuple(result.names)]))
    if z0.ndim != 2 or z0.shape[1:] != np.shape(result.t):
        raise ValueError(f"z0 must be the starts (2n, {np.size(result.t)}) of the result, got {z0.shape}")
    rows = [whole(name, row, 0, len(z0) - 1) for name, row in (("x", x), ("y", y))]
    across, up = z0[rows]
    angle = np.degrees(np.arctan2(up, across))
    radius = np.hypot(across, up)
    lost = np.asarray(result.status) != Status.OK
    from matplotlib.colors import LogNorm

    end = float(np.max(result.t, initial=1.0))
    shown = np.clip(result.t, 1e-3 * end, end)
    how = {"cmap": colour_map().reversed(), "norm": LogNorm(float(shown.min(initial=0.1 * end)), end)}
    plane = min(sides := (np.unique(across).size, np.unique(up).size)) > 1 and sides[0] * sides[1] == across.size
    at = (across, up) if plane else (angle, radius)
    points = ax.scatter(*at, c=shown, s=14, linewidths=0, rasterized=True, **how)
    carry(points, *at, np.arange(angle.size))
    middles, aperture, least = _aperture(angle, radius, lost, bins)
    turned = np.radians(middles)
    if plane:  # no further than the starts in that direction
        with np.errstate(divide="ignore"):
            ends = np.where(np.cos(turned) > 0, across.max(), across.min()) / np.cos(turned)
            ends = np.minimum(ends, np.where(np.sin(turned) > 0, up.max(), up.min()) / np.sin(turned))
        aperture = np.minimum(aperture, ends)
    edge = np.array([aperture * np.cos(turned), aperture * np.sin(turned)] if plane else [middles, aperture])
    (curve,) = ax.plot(*edge, color=ACCENT, lw=1.6, marker="o", ms=3, label="dynamic aperture")
    (open_,) = ax.plot(*edge[:, least], ls="", marker="^", ms=7, color=ACCENT)
    known = aperture[np.isfinite(aperture)]
    said = f"aperture {known.min():.3g} to {known.max():.3g}, mean {known.mean():.3g}" if known.size else "no aperture"
    text = ax.set_title(said + (", ▲ at least" if least.any() else ""), fontsize=9, loc="left")
    if plane:
        names = getattr(result, "names", ())
        xlabel, ylabel = (f"${symbol(names[k])}$" if k < len(names) else f"row {k}" for k in rows)
        ax.set(xlabel=f"{xlabel} of the start", ylabel=f"{ylabel} of the start")
    else:
        ax.set(xlabel="angle of the start  (degrees)", ylabel="amplitude of the start", ylim=(0.0, None))
    _near(ax, at if plane else at[1:], FAR * np.max(known, initial=0.0))
    unit = "turns" if getattr(result, "scheme", None) is None or repr(result.scheme) == "ITERATION" else "time"
    bar = ax.figure.colorbar(points, ax=ax, label=f"{unit} survived") if colorbar else None
    return Artists(points, bar, (curve, open_), (text,), 0)


def _near(ax: Any, rows: tuple[np.ndarray, ...], reach: float) -> None:
    """Set the frame to starts, by their rows of x and y or y alone, no farther than `reach`, if that is not 0."""
    far = np.max(np.abs(rows), axis=0) > reach
    if not reach or not far.any():
        return
    for axis in "yx"[: len(rows)]:
        low, high = getattr(ax, f"get_{axis}lim")()
        ax.set(**{f"{axis}lim": (max(low, -1.05 * reach), min(high, 1.05 * reach))})
    beyond(ax, f"{np.count_nonzero(far)} of {far.size} starts beyond the axes")


def _aperture(
    angle: np.ndarray, radius: np.ndarray, lost: np.ndarray, bins: int | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return angles, the largest amplitude at each below the smallest lost one, and a mask of angles without loss."""
    own = np.unique(np.round(angle[radius > 0], 6))
    if bins is None and own.size <= max(BINS, angle.size // 4):
        middles = own
        number = np.searchsorted(own, np.round(angle, 6) - 1e-9).clip(0, max(own.size - 1, 0))
    else:
        count = BINS if bins is None else whole("bins", bins, 1)
        edges = np.linspace(angle.min(), angle.max(), count + 1)
        middles = (edges[1:] + edges[:-1]) / 2
        number = np.clip(np.digitize(angle, edges) - 1, 0, count - 1)
    found = np.full(middles.size, np.nan)
    least = np.zeros(middles.size, bool)
    for k in range(middles.size):
        mine = (number == k) | (radius == 0)
        first = np.min(radius[mine & lost], initial=np.inf)
        inside = radius[mine & ~lost & (radius < first * (1 - 1e-9))]
        found[k] = inside.max() if inside.size else 0.0 if np.isfinite(first) else np.nan
        least[k] = not np.isfinite(first) and bool(inside.size)
    return middles, found, least
