"""Figures of tori: actions and frequencies of many tori, the spectrum of one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import numbers, whole
from ..frequencies.naff import FrequencyLines
from ..tori.action_angles import ActionAngles
from ..tori.inverse_tori import EnergyOfActions
from ..tori.torus import TorusFit
from .picking import carry
from .scales import clipped
from .style import DARK, LINES, Artists, chosen_orbits, colour_map, figure, symbol


@figure
@inserts_parameters
def plot_actions(
    result: ActionAngles, *, ax: Any = None, x: int = 0, y: int = 1, values: Any = None, label: str = "energy $E$"
) -> Artists:
    """Plot tori in the plane of two actions I = J/2 pi, coloured by a value of each.

    Parameters
    ----------
    result : ActionAngles
        Result of `action_angles`.
    {ax}
    x, y : int, default 0 and 1
        Rows of J.
    values : array_like, shape (orbits,), optional
        Values of the orbits. Default: the energy.
    label : str, optional
        Label of the colour bar. Default: the energy.

    Returns
    -------
    Artists
        ``missing`` is the number of orbits without a torus. A click picks the orbit.

    Examples
    --------
    >>> tori = fa.action_angles(fa.Body(fa.Harmonic()), [1.0, 0.0, 0.5, 0.0, 0.2, 0.5, 0.0, 0.3])
    >>> fa.plot.plot_actions(tori).missing
    0
    """
    each = np.atleast_1d(result.energy if values is None else numbers("values", values)).ravel()
    u, v = (result.I[k].ravel() for k in _rows(result.names, x=x, y=y))
    if each.size != u.size:
        raise ValueError(f"values must be {u.size}, one for each orbit, got {each.size}")
    points, bar, missing = _dots(ax, u, v, each, label)
    ax.set(xlabel=f"action $I_{{{symbol(result.names[x])}}}$", ylabel=f"action $I_{{{symbol(result.names[y])}}}$")
    return Artists(points, bar, (), (), missing)


@figure
@inserts_parameters
def plot_energy_of_actions(result: EnergyOfActions, *, ax: Any = None, x: int = 0, y: int = 1) -> Artists:
    """Plot the frequencies of tori in the plane of two of them, coloured by the energy.

    Parameters
    ----------
    result : EnergyOfActions
        Result of `energy_of_actions`.
    {ax}
    x, y : int, default 0 and 1
        Rows of nu.

    Returns
    -------
    Artists
        ``missing`` is the number of tori that are not ``OK``. A click picks the orbit.

    Examples
    --------
    >>> tori = fa.energy_of_actions(fa.Body(fa.Harmonic()), [0.5, 0.6, 0.3, 0.2])
    >>> fa.plot.plot_energy_of_actions(tori).missing
    0
    """
    u, v = (result.nu[k].ravel() for k in _rows(result.names, x=x, y=y))
    points, bar, missing = _dots(ax, u, v, np.atleast_1d(result.energy).ravel(), "energy $E$")
    first, second = (symbol(f"nu_{result.names[k]}") for k in (x, y))
    ax.set(xlabel=f"${first}$  (cycles per unit time)", ylabel=f"${second}$  (cycles per unit time)")
    return Artists(points, bar, (), (), missing)


def _rows(names: Sequence[str], **rows: Any) -> list[int]:
    """Return rows by number, from the first or from the last, if they are there."""
    return [whole(name, row, -len(names), len(names) - 1) for name, row in rows.items()]


def _dots(ax: Any, u: np.ndarray, v: np.ndarray, each: np.ndarray, label: str) -> tuple[Any, Any, int]:
    fine = np.isfinite(u) & np.isfinite(v) & np.isfinite(each)
    area = float(np.clip(24000 / max(u.size, 1), 2.0, 24.0))
    how = {"c": each[fine], "cmap": colour_map(), "norm": clipped(each)}
    points = carry(
        ax.scatter(u[fine], v[fine], s=area, linewidths=0, rasterized=True, **how),
        u[fine],
        v[fine],
        np.flatnonzero(fine),
    )
    bar = ax.figure.colorbar(points, ax=ax, label=label, extend="both") if fine.any() else None
    return points, bar, int(np.count_nonzero(~fine))


@figure
@inserts_parameters
def plot_frequency_lines(result: FrequencyLines, *, ax: Any = None, signals: Any = None) -> Artists:
    """Plot the spectral lines of signals: the logarithm of their amplitudes over their frequencies.

    Parameters
    ----------
    result : FrequencyLines
        Result of `naff`.
    {ax}
    signals : sequence of int, optional
        Numbers of the signals to draw. Default: the first five.

    Returns
    -------
    Artists
        ``points`` are the dots of each signal, ``lines`` their stems. ``missing`` is the number of lines that were not
        found.

    Examples
    --------
    >>> lines = fa.naff(np.exp(2j * np.pi * 0.031 * np.arange(256)), 1.0, lines=1)
    >>> fa.plot.plot_frequency_lines(lines).missing
    0
    """
    nu, size = (array.reshape(-1, array.shape[-1]) for array in (result.nu, np.abs(result.amplitude)))
    chosen = np.arange(min(len(nu), 5)) if signals is None else chosen_orbits(signals, len(nu), 5, "signals")
    found = size[chosen] > 0
    bottom = 0.3 * float(size[chosen][found].min()) if found.any() else 0.1
    dots = []
    stems = []
    for number, k in enumerate(chosen):
        colour = LINES[number % len(LINES)][0]
        kept = size[k] > 0
        stems.append(ax.vlines(nu[k, kept], bottom, size[k, kept], color=colour, lw=1.0, alpha=0.7))
        (dot,) = ax.plot(
            nu[k, kept], size[k, kept], ls="", marker="osD^v"[number % 5], ms=4, color=colour, label=str(k)
        )
        dots.append(carry(dot, nu[k, kept], size[k, kept], np.full(int(kept.sum()), k), np.flatnonzero(kept)))
    ax.set_yscale("log")
    if len(chosen) > 1:
        ax.legend(title="signal", loc="best")
    ax.set(xlabel=r"$\nu$  (cycles per unit time)", ylabel="amplitude")
    return Artists(tuple(dots), None, tuple(stems), (), int(np.count_nonzero(~found)))


@figure
@inserts_parameters
def plot_torus(result: TorusFit, *, ax: Any = None, row: int | None = None) -> Artists:
    """Plot the Fourier series of a torus: the size of each term over its frequency k·nu.

    Parameters
    ----------
    result : TorusFit
        Result of `fit_torus`.
    {ax}
    row : int, optional
        Row of z. Default: the norm over all rows.

    Returns
    -------
    Artists
        ``points`` are the dots, darker for a lower order ``|k|``, ``lines`` the stems. ``missing`` is the number of
        terms of size 0. The ordinate is logarithmic.

    Examples
    --------
    >>> fit = fa.fit_torus(fa.models.StandardMap(0.5), [3.0, 0.3], time=1000)
    >>> fa.plot.plot_torus(fit).missing
    0
    """
    size = np.abs(result.coefficients)
    size = np.sqrt((size**2).sum(axis=0)) if row is None else size[whole("row", row, -len(size), len(size) - 1)]
    rate = np.abs(result.k @ result.nu)
    kept = (size > 0) & np.isfinite(rate)
    order = np.abs(result.k).sum(axis=1)[kept]
    bottom = 0.3 * float(size[kept].min()) if kept.any() else 0.1
    stems = ax.vlines(rate[kept], bottom, size[kept], color="0.8", lw=0.7, zorder=1)
    how = {"c": order, "cmap": colour_map()} if order.size else {"color": DARK}
    dots = ax.scatter(rate[kept], size[kept], s=12, linewidths=0, zorder=2, **how)
    bar = ax.figure.colorbar(dots, ax=ax, label="order $|k|$") if order.size else None
    ax.set_yscale("log")
    ax.set(xlabel=r"$|k\cdot\nu|$  (cycles per unit time)", ylabel="$|z_k|$" if row is None else f"$|z_{{k,{row}}}|$")
    return Artists(dots, bar, (stems,), (), int(np.count_nonzero(~kept)))
