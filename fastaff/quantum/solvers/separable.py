"""One-dimensional problems of separable bodies: radial equations in alpha, beta or rho, and the angular one in
vartheta.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...models.functions import Barriers, Oscillator, Spring, Zero
from .cover import line_cover
from .elements import Elements, elements, first_signs, left_over, solve
from .factor_tables import (
    AngularTable,
    BarrierTable,
    ElementFunctions,
    Factors,
    IntervalFunctions,
    OscillatorTable,
    RadialTable,
    angle_of,
)
from .jacobi_basis import Basis, Interval, basis
from .panels import DENSE, ORDER, Panels, chebyshev, panels
from .singular_ends import NoGroundState, Well, decayed, exponent, radii, reach, sampled, well

LARGEST = 1200
"""Functions of the largest basis in one dimension."""
LONGEST = 50_000
"""The same on elements, whose matrices are banded."""
FLOOR = 3e-14
"""Relative rounding of eigenvalues."""
GLOBAL = 400
"""Nodes of one interval beyond which a potential is resolved by elements instead."""
PANELS = 800
"""Panels of an interval at most."""
POWERS = np.geomspace(0.1, 40.0, 200)
"""Powers of the size of a basis that errors are taken to fall by."""
ROUGH = 3.0
"""The highest of them where V is not smooth at an end, the lowest where it is."""
NOISE = 1e-6
"""Part of a change below which the sign of the next one means nothing."""
SHORT = 0.01
"""Part of an interval at whose end V is looked at for that."""
SAFE = 2.0
"""Error in units of what such a power leaves."""
ORDERS = (14, 18)
"""Nodes of every element: of the smaller basis and of the larger."""


def centrifugal(name: str, strength: np.ndarray, place: str = "at 0") -> np.ndarray:
    """Return the exponents e of u ~ q^e at an end of problems with s/q^2, q the distance."""
    return np.array([exponent(name, float(s), place) for s in strength])


def radial(
    name: str,
    V: Any,
    dimension: int,
    K: np.ndarray,
    count: int,
    hbar: float,
    mu: float,
    tolerance: float,
    spare: int = 2,
    limit: float = np.inf,
) -> Factors:
    """Solve -(hbar^2/2 mu)(f'' + (dimension - 1) f'/q - K f/q^2) + V f = E f for every K: the lowest `count` E of each.

    V is a function of q = alpha or beta in 2 dimensions, of r = q^2 in 4 (rho). Oscillators k q^2/2 + c/q^2 in closed
    form, V with features too narrow for one polynomial by elements. spare: levels more than `count` whose reach is
    taken. limit: E are levels of V below this energy, above it of V with a wall where waves up to it have decayed;
    raises NoGroundState where V does not grow to it.
    """
    unit = hbar**2 / (2 * mu)
    if isinstance(V, (Oscillator, Spring)):
        return _oscillator(name, V, dimension, K, count, hbar, mu)

    def U(q):
        return V.value(q if dimension == 2 else q * q) / unit

    found = well(name, U, 0.0, np.inf)
    strength = K + (dimension - 1) * (dimension - 3) / 4
    e_zero = (
        centrifugal(name, strength + found.c_lo)
        if found.natural_lo
        else np.array([exponent(name, found.c_lo, "at its wall")])
    )
    deepest = K.min() + (dimension - 2) ** 2 / 4
    highest = K.max() + (dimension - 2) ** 2 / 4
    y, sides = radii(found.lo, found.hi), (highest, deepest)
    if np.isfinite(limit):
        w = sampled(U, y) + min(deepest, 0.0) / y**2
        far = decayed(name, y, w, limit / unit, found.lo, found.hi)[1]
        if far < found.hi:
            found = found._replace(hi=far, natural_hi=False, c_hi=0.0)
            y = radii(found.lo, far)

    def reaches(y):
        return [reach(name, lambda q, k=k: U(q) + k / q**2, y, found.lo, found.hi, count + spare) for k in sides]

    def W(q):
        return U(q) + deepest / q**2

    above, below = reaches(y)
    seen = line_cover(W, W, y[::40], max(above.top, below.top), below.kinetic)
    if (hidden := seen.unseen([y])).low.size:
        above, below = reaches(np.union1d(y, hidden.nodes(0)))
    near, far = below.lo, max(above.hi, below.hi)
    e_lo = np.broadcast_to(e_zero if near == found.lo else np.ones(1), K.shape)
    e_far = exponent(name, found.c_hi, "at its outer wall") if far == found.hi else 1.0
    regular = near == 0.0 == found.lo

    def attempt(n, hi):
        b = basis(Interval(near, hi, e_lo.copy(), np.full(K.shape, e_far), True, True), n, 16)
        kept = strength[:, None] / b.x**2 if not regular else (-found.c_lo / b.x**2)
        e0, e1 = e_lo[:, None], e_far
        singular = 2 * e0 * e1 / (b.below * b.above)
        if not regular:
            singular = singular - e0 * (e0 - 1) / b.below**2
        q = sampled(U, b.x) + kept + singular - e1 * (e1 - 1) / b.above**2
        return b, b.lowest(q, np.ones_like(q), count + 1, 0)

    d = SHORT * (far - near)
    ends = [_end(U, near, d, 1.0)] * (near == found.lo) + [_end(U, far, -d, 1.0)] * (far == found.hi)
    first = int(1.3 * max(above.nodes, below.nodes)) + count + 24
    grow = 1.0 if far == found.hi else 1.05
    parts = panels(U, near, far, below.top - below.kinetic, below.kinetic, DENSE, PANELS, seen.thin(near, far, DENSE))
    if parts.needed > GLOBAL:

        def problem(i, edges, n):
            line = elements(edges, n, float(e_lo[i]), e_far, True, True)
            q = sampled(U, line.x) + strength[i] / line.x**2
            q[0] -= (
                (strength[i] + found.c_lo) / line.x[0] ** 2 if regular else e_lo[i] * (e_lo[i] - 1) / line.below[0] ** 2
            )
            q[-1] -= e_far * (e_far - 1) / line.above[-1] ** 2
            return line, np.ones_like(q), q

        top = max(above.top, below.top)
        room = np.maximum(top - sampled(U, parts.points) - deepest / parts.points**2, 0).max(axis=1)
        fine = parts.cut(np.diff(parts.edges) * np.sqrt(room))
        check_size(name, fine.missed.size * ORDERS[-1], count, LONGEST)
        values, error, solutions, n = _by_elements(problem, K.size, fine, top, below.kinetic, count)
        if (
            far < found.hi and values.max() > top
        ):  # barriers raise levels: they reach farther than the semiclassical ones
            return radial(name, V, dimension, K, count, hbar, mu, tolerance, 2 * spare + 2, limit)
        error = error + seen.lost(values)
        return Factors(unit * values, unit * error, RadialTable(solutions, dimension), n, seen.said)
    check_size(name, first, count)
    b, (values, vectors), error, n = _until_equal(
        attempt, max(first, parts.needed), far, grow, count, tolerance, _powers(*ends)
    )
    functions, values = RadialTable(IntervalFunctions(b.interval, vectors), dimension), values[:, :count]
    return Factors(unit * values, unit * (error + seen.lost(values)), functions, n, seen.said)


def _by_elements(
    problem: Callable, size: int, parts: Panels, top: float, kinetic: float, count: int
) -> tuple[np.ndarray, np.ndarray, ElementFunctions, int]:
    """Solve `size` problems(i, edges, n) -> line, p, q on elements: values and errors (size, count), functions, size.

    Errors: twice the change from polynomials of a lower degree, and what V differs from its polynomials by.
    """
    rows = []
    for i in range(size):
        before: Any = np.inf
        for n in ORDERS:
            line, p, q = problem(i, parts.edges, n)
            values, c = solve(line, p, q, count + 1, top, 1e-4 * kinetic)
            gap, before = np.abs(values - before), values
        rounding = 64 * np.finfo(float).eps * np.abs(values).max()
        rows.append(
            (
                values[:count],
                (2 * gap + rounding + left_over(line, parts.missed, c))[:count],
                line,
                c * first_signs(line, c),
            )
        )
    values, errors = (np.array([row[k] for row in rows]) for k in (0, 1))
    functions = ElementFunctions(tuple(row[2] for row in rows), tuple(row[3] for row in rows))
    return values, errors, functions, rows[0][2].size


def check_size(name: str, size: int, count: int, largest: int = LARGEST) -> None:
    """Raise ValueError for a basis so large that it leaves no room for a larger one to compare with."""
    if 1.25 * size + 12 > largest:
        raise ValueError(
            f"{count} levels of {name} take {size} basis functions and more, above {largest}: ask for fewer, or a "
            "larger hbar"
        )


def _until_equal(solve, n, hi, grow, count, tolerance, powers):
    """Enlarge basis and interval until the values of two in succession agree: twofold while they are far from it.

    Return basis, values and vectors, errors, size. A smaller basis goes before, for how fast changes fall.
    """
    sizes, change, far = [max(int((n - 12) / 1.25), count + 2)], None, False
    _, (coarse, _) = solve(sizes[0], hi / grow)
    while True:
        sizes.append(2 * sizes[-1] if far else sizes[-1] + sizes[-1] // 4 + 12)
        b, (values, vectors) = solve(sizes[-1], hi)
        gap = values[:, :count] - coarse[:, :count]
        scale = np.maximum(np.abs(values[:, :count]), np.abs(np.diff(values[:, : count + 1])))
        if change is not None:
            error = _left(sizes[-3:], change, gap, FLOOR * scale, powers)
            if np.all(error <= max(0.1 * tolerance, FLOOR) * scale) or sizes[-1] > LARGEST:
                rounding = 8 * np.finfo(float).eps * np.abs(values[:, :count]).max(axis=1, keepdims=True)
                return b, (values, vectors), error + rounding, sizes[-1]
            far = bool(np.any(np.abs(gap) > 1e-4 * scale))
        coarse, change, hi = values, gap, hi * grow


def _left(sizes: list[int], change: np.ndarray, gap: np.ndarray, floor: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Return what is left behind two changes between bases of three sizes.

    Twice the last one, and twice what follows if errors fall as a power of the size, as they do at singular ends whose
    functions no exponent makes smooth. Changes of different signs, of the basis and of its quadrature, tell no power:
    the error is the larger one.
    """
    size, last = np.abs(change), np.abs(gap)
    if powers[-1] < POWERS[-1]:  # errors of the basis and of its quadrature may cancel
        size, last = by_chance(size), by_chance(last)
    error = 2 * last + SAFE * _remaining(sizes, size - floor, last - floor, powers)
    turned = (change * gap < 0) & (last > np.maximum(floor, NOISE * size))
    return np.where(turned, np.maximum(error, size), error)


def by_chance(gap: np.ndarray) -> np.ndarray:
    """Return the changes (..., levels), no less than those of neighbours: two bases may agree on a level by chance."""
    wide = np.pad(gap, [(0, 0)] * (gap.ndim - 1) + [(1, 1)])
    nearby = np.maximum(np.maximum(wide[..., :-2], wide[..., 2:]), gap)
    return np.maximum(nearby, 0.1 * np.maximum.accumulate(gap, axis=-1))


def _remaining(sizes: list[int], change: np.ndarray, gap: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Return the error of the last of three bases if errors fall as one of some powers of their size."""
    errors = [(size / sizes[-1]) ** -powers for size in sizes]
    drop, last = errors[0] - errors[1], errors[1] - errors[2]
    change = np.maximum(change, 1e-300)
    return change * np.interp(np.maximum(gap, 0) / change, (last / drop)[::-1], (1 / drop)[::-1])


def _end(U: Callable, place: float, step: float, power: float) -> Callable:
    """Return d^2 U as a function of t, d = step t^power its distance from an end."""
    return lambda t: (step * t**power) ** 2 * U(place + step * t**power)


def _powers(*ends: Callable) -> np.ndarray:
    """Return the powers by which errors may fall where V has such ends: functions of t in (0, 1), smooth or not."""
    nodes, matrix = chebyshev(2 * ORDER)
    between = (np.arange(2 * ORDER) + 0.5) / (2 * ORDER)
    for end in ends:
        inner, seen = sampled(end, nodes), sampled(end, between)
        if not np.abs(matrix @ inner - seen).max() <= 1e-9 * np.abs(seen).max():
            return POWERS[POWERS <= ROUGH]
    return POWERS[POWERS > ROUGH]


def _oscillator(name, V, dimension, K, count, hbar, mu):
    if not V.k > 0:
        raise NoGroundState(f"{name} = {V!r} must have k > 0: it does not bind, there is no discrete spectrum")
    strength = K + (dimension - 1) * (dimension - 3) / 4 + 2 * mu * V.c / hbar**2
    s = centrifugal(name, strength) - 0.5
    omega, kappa = float(np.sqrt(V.k / mu)), float(np.sqrt(V.k * mu)) / hbar
    values = hbar * omega * (2 * np.arange(count) + 1 + s[:, None])
    return Factors(values, np.zeros_like(values), OscillatorTable(dimension, s, kappa), count)


def angular(
    name: str, V: Any, a: np.ndarray, b: np.ndarray, count: int, hbar: float, mu: float, tolerance: float
) -> Factors:
    """Solve EQ4.6 for the classes a, b (problems,): the lowest `count` e_vartheta of each.

    In x = cos(vartheta): -((1 - x^2) f')' + [b^2/(2(1 - x)) + a^2/(2(1 + x)) + mu V/(2 hbar^2)] f = (mu e/2 hbar^2) f.
    Where V becomes infinite inside (0, pi), as at det phi = 0, f = 0 there (Friedrichs). Barriers in closed form.
    """
    unit = 2 * hbar**2 / mu
    if isinstance(V, (Barriers, Zero)):
        return _barriers(name, V if isinstance(V, Barriers) else Barriers(0.0, 0.0), a, b, count, unit)

    def U(vartheta):
        return V.value(vartheta) / unit

    found = well(name, U, 0.0, np.pi)
    interval = angular_interval(name, found, a, b)

    d = SHORT * (found.hi - found.lo)  # polynomials of x are even at the natural ends
    places = (found.lo, d, found.natural_lo), (found.hi, -d, found.natural_hi)
    ends = [_end(U, place, step, 0.5 if natural else 1.0) for place, step, natural in places]

    def attempt(n, _):
        base = basis(interval, n, 24)
        q = angular_potential(base, a, b) + sampled(U, 2 * np.arctan2(np.sqrt(1 - base.x), np.sqrt(1 + base.x)))
        return base, base.lowest(q, 1 - base.x**2, count + 1, 0)

    check_size(name, count + 24, count)

    def inside(x):
        return sampled(U, angle_of(interval.lo, interval.hi, x - interval.lo))

    inner = np.linspace(interval.lo, interval.hi, 4098)[1:-1]
    low = float(inside(inner).min())
    scale = float((count + a.max() + b.max() + 1) ** 2)  # of e_vartheta/unit
    seen = line_cover(lambda x: U(np.arccos(x)), inside, _graded(interval.lo, interval.hi), low + scale, scale)
    deepest = min(low, seen.low.min(initial=low))
    low, scale = deepest, scale + low - deepest
    thin = seen.thin(interval.lo, interval.hi, DENSE)
    parts = panels(inside, interval.lo, interval.hi, low, scale, DENSE, PANELS, thin)
    if parts.needed > GLOBAL:

        def problem(i, edges, n):
            e_lo, e_hi = float(interval.e_lo[i]), float(interval.e_hi[i])
            line = elements(edges, n, e_lo, e_hi, interval.wall_lo, interval.wall_hi)
            quanta = (np.full(len(line.x), side[i]) for side in (a, b))
            q = angular_potential(line, *quanta) + sampled(U, angle_of(line.lo, line.hi, line.below))
            return line, 1 - line.x**2, q

        top = low + scale
        room = np.maximum(top - inside(parts.points), 0).max(axis=1)
        fine = parts.cut(-np.diff(np.arccos(parts.edges)) * np.sqrt(room))
        values, error, solutions, n = _by_elements(problem, a.size, fine, top, scale, count)
        lost = float(seen.lost(values).max())
        return Factors(unit * values, unit * error, AngularTable(solutions), n, seen.said, lost)
    base, (values, vectors), error, n = _until_equal(
        attempt, max(count + 24, parts.needed), 1.0, 1.0, count, tolerance, _powers(*ends)
    )
    functions = AngularTable(IntervalFunctions(base.interval, vectors))
    values, lost = values[:, :count], float(seen.lost(values[:, :count]).max())
    return Factors(unit * values, unit * error, functions, n, seen.said, lost)


def _graded(lo: float, hi: float) -> np.ndarray:
    """Return edges within (lo, hi), dense at both ends."""
    steps = (hi - lo) / 2 * np.geomspace(1e-9, 1.0, 31)
    return np.concatenate([lo + steps, (hi - steps[:-1])[::-1]])


def _barriers(name: str, V: Barriers, a: np.ndarray, b: np.ndarray, count: int, unit: float) -> Factors:
    """e_vartheta = (hbar^2/2 mu) (Q^2 - 1), Q = 2 n + 1 + s_alpha + s_beta."""
    s_alpha = centrifugal(name, a**2 - 0.25 + 4 * V.c_alpha / unit, "at vartheta = pi") - 0.5
    s_beta = centrifugal(name, b**2 - 0.25 + 4 * V.c_beta / unit, "at vartheta = 0") - 0.5
    values = unit / 4 * ((2 * np.arange(count) + 1 + (s_alpha + s_beta)[:, None]) ** 2 - 1)
    return Factors(values, np.zeros_like(values), BarrierTable(s_alpha, s_beta), count)


def angular_interval(name: str, found: Well, a: np.ndarray, b: np.ndarray) -> Interval:
    """Return the interval in x = cos(vartheta) of a well in vartheta, with exponents of the classes."""

    def end(natural, c, angular_momentum, place):
        if natural:
            return np.array([(exponent(name, m * m - 0.25 + c, place) - 0.5) / 2 for m in angular_momentum])
        return np.full(angular_momentum.shape, exponent(name, c, place))

    e_hi = end(found.natural_lo, found.c_lo, b, "at vartheta = 0" if found.natural_lo else "at its wall")
    e_lo = end(found.natural_hi, found.c_hi, a, "at vartheta = pi" if found.natural_hi else "at its wall")
    lo = -1.0 if found.natural_hi else _cosine(found.hi)
    hi = 1.0 if found.natural_lo else _cosine(found.lo)
    return Interval(lo, hi, e_lo, e_hi, not found.natural_hi, not found.natural_lo)


def _cosine(vartheta: float) -> float:
    x = float(np.cos(vartheta))
    return 0.0 if abs(x) < 1e-14 else x


def angular_potential(base: Basis | Elements, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return what the weight leaves of the centrifugal terms, without the potential: q - (p w')'/w - c-terms of natural
    ends.

    a, b: of every row of nodes.
    """
    x, low, high, (_, _, e0, e1, wall_lo, wall_hi) = base.x, base.below, base.above, base.interval
    e0, e1, p = e0[:, None], e1[:, None], 1 - x**2
    q = 2 * e0 * e1 * p / (low * high)
    if wall_lo:
        q = q + 2 * x * e0 / low - p * e0 * (e0 - 1) / low**2 + (a**2)[:, None] / (2 * (1 + x))
    else:  # 2 e0^2/low = (a^2 + c)/(2 low): the weight takes the c-term of the potential too
        q = q + e0 * (e0 + 1) - (2 * e0**2 - (a**2)[:, None] / 2) / low
    if wall_hi:
        q = q - 2 * x * e1 / high - p * e1 * (e1 - 1) / high**2 + (b**2)[:, None] / (2 * (1 - x))
    else:
        q = q + e1 * (e1 + 1) - (2 * e1**2 - (b**2)[:, None] / 2) / high
    return q
