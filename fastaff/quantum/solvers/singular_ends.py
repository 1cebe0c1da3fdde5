"""One-dimensional potentials: their domains, their singular ends, and the reach of states."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

REACH = 42.0
"""Action in units of hbar by which states have decayed where an interval is cut: e^-42 = 6e-19."""
ESSENTIAL = 1e5
"""d^2 U where an essential singularity of -u'' + U u is cut off: sqrt(1e5) is beyond REACH for all powers up to d^-12.
"""
RANGE = (1e-6, 1e6)
"""Least and largest radius that is sampled."""


class NoGroundState(ValueError):
    """Error of a Hamiltonian without the levels asked for.

    Its energy is unbounded below, its discrete spectrum has too few levels, or no grid holds them.
    """


class FallsToCentre(NoGroundState):
    """Error of a potential that attracts more than -1/(4 x^2) at an end."""


class Well(NamedTuple):
    """The interval (lo, hi) where a potential is finite, whether its ends are the natural ones of the coordinate, and
    lim distance^2 V at both.
    """

    lo: float
    hi: float
    natural_lo: bool
    natural_hi: bool
    c_lo: float
    c_hi: float


def potential(model: Any, A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Return V of a body at A = alpha^2, B = beta^2, +inf where it does not live."""
    with np.errstate(all="ignore"):
        V = np.where(model.potential.margin(A, B) > 0, model.potential.value(A, B), np.inf)
    return np.where(np.isnan(V), np.inf, V)


def sampled(V: Callable, y: np.ndarray) -> np.ndarray:
    """Return V(y), one row or more, with +inf for NaN: a function lives where it is finite."""
    with np.errstate(all="ignore"):
        values = np.asarray(V(y), dtype=float)
    values = np.broadcast_to(values, np.broadcast_shapes(values.shape, y.shape))
    return np.where(np.isnan(values), np.inf, values)


def well(name: str, V: Callable, lo: float, hi: float) -> Well:
    """Return the well of V on (lo, hi), hi = inf for radii; raises NoGroundState or ValueError if there is none."""
    y = np.geomspace(*RANGE, 2001) if np.isinf(hi) else lo + (hi - lo) * (np.arange(2001) + 0.5) / 2001
    values = sampled(V, y)
    inside = np.flatnonzero(np.isfinite(values))
    if inside.size == 0:
        raise ValueError(f"{name} is finite nowhere")
    check_poles(name, V, y[inside[0] : inside[-1] + 1], values[inside[0] : inside[-1] + 1])
    natural_lo = inside[0] == 0
    natural_hi = inside[-1] == y.size - 1
    start = lo if natural_lo else _edge(V, y[inside[0]], y[inside[0] - 1])
    stop = hi if natural_hi else _edge(V, y[inside[-1]], y[inside[-1] + 1])
    size = y[inside[0]] if np.isinf(hi) and natural_lo else min(stop, y[inside[-1]]) - start
    size = max(size, 1e-3) if np.isinf(hi) else size
    start, c_lo = _strength(name, lambda d: V(start + d), start, size, +1)
    stop, c_hi = (stop, 0.0) if np.isinf(stop) else _strength(name, lambda d: V(stop - d), stop, size, -1)
    return Well(start, stop, bool(natural_lo and start == lo), bool(natural_hi and stop == hi), c_lo, c_hi)


def check_poles(name: str, V: Callable, y: np.ndarray, values: np.ndarray) -> None:
    """Raise ValueError for a V that is infinite inside of y, at which it has `values`.

    Sixteenfold zooms on the places where |V| is larger than on both sides: eight of them raise 1/d by 4e9, and leave it
    steep; a smooth hill, however narrow, is flat in the end.
    """
    size = np.where(np.isfinite(values), np.abs(values), np.inf)
    hills = (
        np.flatnonzero(
            (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:]) & (size[1:-1] > np.minimum(size[:-2], size[2:]))
        )
        + 1
    )
    for i in hills:
        lo = y[i - 1]
        hi = y[i + 1]
        side = max(size[i - 1], size[i + 1])
        for _ in range(8):
            t = np.linspace(lo, hi, 33)
            with np.errstate(all="ignore"):
                inner = np.abs(sampled(V, t))
            k = int(np.clip(np.argmax(inner), 1, 31))
            lo = t[k - 1]
            hi = t[k + 1]
        if np.isinf(side) or np.isinf(inner[k]) or inner[k] > max(1e6 * side, 2 * inner.min()):
            raise ValueError(
                f"{name} must be finite on one interval, got a pole at {t[k]:.6g}. Use np.inf on its other side."
            )


def _edge(V: Callable, inside: float, outside: float) -> float:
    """Return the place where V becomes infinite, by bisection to the last digit."""
    while True:
        middle = (inside + outside) / 2
        if middle in (inside, outside):
            return float(inside)
        if np.isfinite(sampled(V, np.array([middle]))[0]):
            inside = middle
        else:
            outside = middle


def _strength(name: str, V: Callable, end: float, size: float, sign: int) -> tuple[float, float]:
    """Return the end and c = lim d^2 V(d); an end where d^2 V -> +inf is moved to where the wave functions have
    decayed.

    d^2 V is extrapolated to d = 0 by polynomials through Chebyshev nodes of two small intervals; only agreement counts
    as a limit.
    """
    d = size * np.array([1e-2, 1e-4, 1e-6])
    g = d * d * sampled(V, d)
    if abs(g[2]) > 10 * abs(g[1]) > 100 * abs(g[0]):
        if g[2] < 0:
            raise NoGroundState(f"{name} falls faster than -1/x^2 at {end:.6g}: the energy has no lower bound")
        close = d[2:]
        while (close**2 * sampled(V, close))[0] > ESSENTIAL:
            close = close * 1.1
        return end + sign * float(close[0]), 0.0
    nodes = np.cos(np.pi * (np.arange(10) + 0.5) / 10)
    # Barycentric extrapolation to the end t = -1 of Chebyshev nodes.
    weights = (-1.0) ** np.arange(10) * np.sin(np.pi * (np.arange(10) + 0.5) / 10) / (-1 - nodes)
    limits = []
    for h in (1e-2 * size, 1e-3 * size):
        distance = h * (1 + nodes) / 2
        limits.append(float((weights * distance**2 * sampled(V, distance)).sum() / weights.sum()))
    return end, limits[1] if abs(limits[0] - limits[1]) <= 1e-6 * abs(limits[1]) else 0.0


def exponent(name: str, strength: float, place: str) -> float:
    """Return e of u ~ x^e in -u'' + strength u/x^2, the larger root; raises NoGroundState below -1/4."""
    if not strength >= -0.25 - 1e-14:
        raise FallsToCentre(
            f"{name} is too attractive {place}: the energy has no lower bound, as s = {strength:.6g} < -1/4 in -u'' + "
            "s u/x^2"
        )
    return 0.5 + max(0.25 + strength, 0.0) ** 0.5


class Reach(NamedTuple):
    """The interval (lo, hi) beyond which states have decayed, Gauss nodes that resolve them, their top energy, and the
    largest top - W.
    """

    lo: float
    hi: float
    nodes: float
    top: float
    kinetic: float


def radii(lo: float, hi: float, count: int = 6001) -> np.ndarray:
    """Return radii of all sizes in (lo, hi)."""
    stop = hi if np.isfinite(hi) else RANGE[1]
    return np.asarray(lo + np.geomspace(RANGE[0] * min(1.0, stop - lo), stop - lo, count))


def reach(name: str, W: Callable, y: np.ndarray, lo: float, hi: float, count: float) -> Reach:
    """Return the extent of the lowest `count` states of -u'' + W u, with samples of W at radii y in (lo, hi).

    W with the Langer centrifugal term; semiclassical count int sqrt(lambda - W) dx/pi. n Gauss nodes are pi sqrt(d
    d')/n apart at distances d, d' from the ends.
    """
    w = sampled(W, y)
    step = np.gradient(y)
    bottom = int(np.argmin(w))
    check_bottom(name, bottom, y.size, hi)
    top = count_top(
        lambda top: float((np.sqrt(np.maximum(top - w, 0)) * step).sum()) / np.pi, w[bottom], 1 / y[bottom] ** 2, count
    )
    left, right = decayed(name, y, w, top, lo, hi)
    waves = np.maximum(top - w, 0) * np.maximum(y - left, 0) * np.maximum(right - y, 0)
    return Reach(left, right, float(np.sqrt(waves.max())), float(top), float(top - w[bottom]))


def check_bottom(name: str, bottom: int, size: int, hi: float) -> None:
    """Raise NoGroundState for a potential whose least value is at the largest radius."""
    if bottom == size - 1 and not np.isfinite(hi):
        raise NoGroundState(f"{name} does not grow at large distance: there is no ground state")


def count_top(states: Callable, low: float, unit: float, count: float) -> float:
    """Return the place above `low` where the growing function `states` reaches `count`; `unit`: a first step."""
    up = unit
    down = 0.0
    while states(low + up) < count:
        up *= 2
    for _ in range(50):
        middle = (up + down) / 2
        up, down = (up, middle) if states(low + middle) < count else (middle, down)
    return low + up


def decayed(name: str, y: np.ndarray, w: np.ndarray, top: float, lo: float, hi: float) -> tuple[float, float]:
    """Return the points, left and right, beyond which states of -u'' + w u with eigenvalues up to `top` have decayed,
    on the grid y in (lo, hi).
    """
    allowed = np.flatnonzero(w < top)
    allowed = allowed if allowed.size else np.array([np.argmin(w)])
    if allowed[-1] == y.size - 1 and not np.isfinite(hi):
        raise NoGroundState(
            f"{name} must grow at large distance for a discrete spectrum; it binds fewer levels than requested"
        )
    with np.errstate(invalid="ignore", over="ignore"):
        decay = np.minimum(np.sqrt(np.maximum(w - top, 0)), 1e150) * np.gradient(y)
    after = np.cumsum(decay[allowed[-1] :])
    before = np.cumsum(decay[allowed[0] :: -1])
    right = y[allowed[-1] + np.argmax(after > REACH)] if after[-1] > REACH else hi
    left = y[allowed[0] - np.argmax(before > REACH)] if before[-1] > REACH else lo
    if not np.isfinite(right):
        raise NoGroundState(f"{name} grows too slowly at large distance for that many levels")
    return float(left), float(right)
