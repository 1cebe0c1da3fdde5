"""One-dimensional problems of separable bodies: radial equations in alpha, beta or rho, and the angular one in
vartheta.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...core.numbers import shown
from ...systems.models.functions import Barriers, Oscillator, Spring, Zero
from .convergence import LARGEST, near_end, powers_of, until_equal
from .cover import Cover, line_cover
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
from .jacobi_basis import Basis, ProblemEnds, basis
from .panels import DENSE, Panels, panels
from .singular_ends import NoGroundState, Reach, Well, decayed, exponent, radii, reach, sampled, well

LONGEST = 50_000
"""Size of the largest basis of elements, whose matrices are banded."""
GLOBAL = 400
"""Nodes of one interval beyond which a potential is resolved by elements instead."""
PANELS = 800
"""Panels of an interval at most."""
SHORT = 0.01
"""Part of an interval, at its end, in which the smoothness of V is examined."""
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
    form, V with features too narrow for one polynomial by elements. spare: extra levels above `count` that set the
    reach. limit: below this energy E are levels of V, above it levels of V with a wall where waves up to it have
    decayed; raises NoGroundState if V does not grow to it.
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
    sides = K.max() + (dimension - 2) ** 2 / 4, deepest
    if np.isfinite(limit):
        found = _walled(name, U, found, min(deepest, 0.0), limit / unit)
    y = radii(found.lo, found.hi)
    above, below, seen = _reaches(name, U, found, sides, y, count + spare)
    far = max(above.hi, below.hi)
    e_lo = np.broadcast_to(e_zero if below.lo == found.lo else np.ones(1), K.shape)
    e_far = exponent(name, found.c_hi, "at its outer wall") if far == found.hi else 1.0
    equations = _Equations(U, strength, below.lo, found.c_lo, below.lo == 0.0 == found.lo, e_lo, e_far)
    parts = equations.panels(far, below.top, below.kinetic, seen)
    if parts.needed > GLOBAL:
        top = max(above.top, below.top)
        room = np.maximum(top - sampled(U, parts.points) - deepest / parts.points**2, 0).max(axis=1)
        fine = parts.cut(np.diff(parts.edges) * np.sqrt(room))
        check_size(name, fine.missed.size * ORDERS[-1], count, LONGEST)
        values, error, solutions, n = _by_elements(equations.of_elements, K.size, fine, top, below.kinetic, count)
        if far < found.hi and values.max() > top:
            # Barriers raise levels: they reach farther than the semiclassical ones.
            return radial(name, V, dimension, K, count, hbar, mu, tolerance, 2 * spare + 2, limit)
        error = error + seen.lost(values)
        return Factors(unit * values, unit * error, RadialTable(solutions, dimension), n, seen.said)
    first = int(1.3 * max(above.nodes, below.nodes)) + count + 24
    check_size(name, first, count)
    d = SHORT * (far - below.lo)
    ends = [near_end(U, below.lo, d, 1.0)] * (below.lo == found.lo) + [near_end(U, far, -d, 1.0)] * (far == found.hi)
    n = max(first, parts.needed)
    grow = 1.0 if far == found.hi else 1.05
    in_one_basis = partial(equations.in_one_basis, count=count + 1)
    b, (values, vectors), error, n = until_equal(in_one_basis, n, far, grow, count, tolerance, powers_of(*ends))
    functions = RadialTable(IntervalFunctions(b.interval, vectors), dimension)
    values = values[:, :count]
    return Factors(unit * values, unit * (error + seen.lost(values)), functions, n, seen.said)


def _walled(name: str, U: Callable, found: Well, centrifugal: float, top: float) -> Well:
    """Return a well with a wall where waves of -u'' + (U + centrifugal/q^2) u up to an energy have decayed."""
    y = radii(found.lo, found.hi)
    far = decayed(name, y, sampled(U, y) + centrifugal / y**2, top, found.lo, found.hi)[1]
    return found._replace(hi=far, natural_hi=False, c_hi=0.0) if far < found.hi else found


def _reaches(
    name: str, U: Callable, found: Well, sides: tuple[float, float], y: np.ndarray, count: int
) -> tuple[Reach, Reach, Cover]:
    """Return the reach of states with the highest and the deepest centrifugal term, and the places of hidden wells: the
    radii of these wells are added to the radii y.
    """

    def reaches(y):
        return [reach(name, lambda q, k=k: U(q) + k / q**2, y, found.lo, found.hi, count) for k in sides]

    def W(q):
        return U(q) + sides[1] / q**2

    above, below = reaches(y)
    seen = line_cover(W, W, y[::40], max(above.top, below.top), below.kinetic)
    if (hidden := seen.unseen([y])).low.size:
        above, below = reaches(np.union1d(y, hidden.nodes(0)))
    return above, below, seen


class _Equations(NamedTuple):
    """The equations -u'' + (U + strength/q^2) u = E u of every K from `near` on, u ~ (q - near)^e_lo and, at the outer
    end, a power e_far of the distance; c_lo: the 1/q^2 part of U; regular: whether `near` is the origin.
    """

    U: Callable
    strength: np.ndarray
    near: float
    c_lo: float
    regular: bool
    e_lo: np.ndarray
    e_far: float

    def panels(self, far: float, top: float, kinetic: float, seen: Cover) -> Panels:
        """Return the partition up to `far` that resolves U."""
        thin = seen.thin(self.near, far, DENSE)
        return panels(self.U, self.near, far, top - kinetic, kinetic, DENSE, PANELS, thin)

    def in_one_basis(self, n: int, hi: float, count: int) -> tuple[Basis, tuple[np.ndarray, np.ndarray]]:
        """Return the polynomials of n nodes up to hi, with the lowest values and their vectors."""
        e_lo = self.e_lo[:, None]
        e_far = self.e_far
        b = basis(ProblemEnds(self.near, hi, self.e_lo.copy(), np.full(self.e_lo.shape, e_far), True, True), n, 16)
        kept = self.strength[:, None] / b.x**2 if not self.regular else (-self.c_lo / b.x**2)
        singular = 2 * e_lo * e_far / (b.below * b.above)
        if not self.regular:
            singular = singular - e_lo * (e_lo - 1) / b.below**2
        q = sampled(self.U, b.x) + kept + singular - e_far * (e_far - 1) / b.above**2
        return b, b.lowest(q, np.ones_like(q), count, 0)

    def of_elements(self, i: int, edges: np.ndarray, n: int) -> tuple[Elements, np.ndarray, np.ndarray]:
        """Return the elements between edges, p and q of the i-th equation."""
        e_lo = self.e_lo[i]
        e_far = self.e_far
        strength = self.strength[i]
        line = elements(edges, n, float(e_lo), e_far, True, True)
        q = sampled(self.U, line.x) + strength / line.x**2
        q[0] -= (strength + self.c_lo) / line.x[0] ** 2 if self.regular else e_lo * (e_lo - 1) / line.below[0] ** 2
        q[-1] -= e_far * (e_far - 1) / line.above[-1] ** 2
        return line, np.ones_like(q), q


def _by_elements(
    problem: Callable, size: int, parts: Panels, top: float, kinetic: float, count: int
) -> tuple[np.ndarray, np.ndarray, ElementFunctions, int]:
    """Solve `size` problems(i, edges, n) -> line, p, q on elements: values and errors (size, count), functions, size.

    Errors: twice the change from polynomials of a lower degree, and the difference of V from its polynomials.
    """
    rows = []
    for i in range(size):
        before: Any = np.inf
        for n in ORDERS:
            line, p, q = problem(i, parts.edges, n)
            values, c = solve(line, p, q, count + 1, top, 1e-4 * kinetic)
            gap = np.abs(values - before)
            before = values
        rounding = 64 * np.finfo(float).eps * np.abs(values).max()
        rows.append(
            (
                values[:count],
                (2 * gap + rounding + left_over(line, parts.missed, c))[:count],
                line,
                c * first_signs(c),
            )
        )
    values, errors = (np.array([row[k] for row in rows]) for k in (0, 1))
    functions = ElementFunctions(tuple(row[2] for row in rows), tuple(row[3] for row in rows))
    return values, errors, functions, rows[0][2].size


def check_size(name: str, size: int, count: int, largest: int = LARGEST) -> None:
    """Raise ValueError for a basis so large that no larger one is possible for comparison."""
    if 1.25 * size + 12 > largest:
        raise ValueError(
            f"{count} levels of {name} require {size} basis functions or more, above {largest}. Try fewer levels or a "
            "larger hbar."
        )


def _oscillator(name, V, dimension, K, count, hbar, mu):
    if not V.k > 0:
        raise NoGroundState(f"{name} = {shown(V)} must have k > 0 for a discrete spectrum")
    strength = K + (dimension - 1) * (dimension - 3) / 4 + 2 * mu * V.c / hbar**2
    s = centrifugal(name, strength) - 0.5
    omega = float(np.sqrt(V.k / mu))
    kappa = float(np.sqrt(V.k * mu)) / hbar
    values = hbar * omega * (2 * np.arange(count) + 1 + s[:, None])
    return Factors(values, np.zeros_like(values), OscillatorTable(dimension, s, kappa), count)


def angular(
    name: str, V: Any, K_alpha: np.ndarray, K_beta: np.ndarray, count: int, hbar: float, mu: float, tolerance: float
) -> Factors:
    """Solve EQ4.6 for K_alpha, K_beta (problems,), a^2 and b^2 of a class: the lowest `count` e_vartheta of each.

    In x = cos(vartheta): -((1 - x^2) f')' + [K_beta/(2(1 - x)) + K_alpha/(2(1 + x)) + mu V/(2 hbar^2)] f = (mu e/2
    hbar^2) f.
    Where V becomes infinite inside (0, pi), as at det phi = 0, f = 0 there (Friedrichs). Barriers in closed form.
    """
    unit = 2 * hbar**2 / mu
    if isinstance(V, (Barriers, Zero)):
        return _barriers(name, V if isinstance(V, Barriers) else Barriers(0.0, 0.0), K_alpha, K_beta, count, unit)

    def U(vartheta):
        return V.value(vartheta) / unit

    found = well(name, U, 0.0, np.pi)
    interval = angular_interval(name, found, K_alpha, K_beta)

    d = SHORT * (found.hi - found.lo)  # polynomials of x are even at the natural ends
    places = (found.lo, d, found.natural_lo), (found.hi, -d, found.natural_hi)
    ends = [near_end(U, place, step, 0.5 if natural else 1.0) for place, step, natural in places]

    def attempt(n, _):
        base = basis(interval, n, 24)
        q = angular_potential(base, K_alpha, K_beta) + sampled(
            U, 2 * np.arctan2(np.sqrt(1 - base.x), np.sqrt(1 + base.x))
        )
        return base, base.lowest(q, 1 - base.x**2, count + 1, 0)

    check_size(name, count + 24, count)

    def inside(x):
        return sampled(U, angle_of(interval.lo, interval.hi, x - interval.lo))

    inner = np.linspace(interval.lo, interval.hi, 4098)[1:-1]
    low = float(inside(inner).min())
    spins = np.sqrt(max(K_alpha.max(), 0.0)) + np.sqrt(max(K_beta.max(), 0.0))
    scale = float((count + spins + 1) ** 2)  # of e_vartheta/unit
    seen = line_cover(lambda x: U(np.arccos(x)), inside, _graded(interval.lo, interval.hi), low + scale, scale)
    deepest = min(low, seen.low.min(initial=low))
    scale = scale + low - deepest
    low = deepest
    thin = seen.thin(interval.lo, interval.hi, DENSE)
    parts = panels(inside, interval.lo, interval.hi, low, scale, DENSE, PANELS, thin)
    if parts.needed > GLOBAL:

        def problem(i, edges, n):
            e_lo = float(interval.e_lo[i])
            e_hi = float(interval.e_hi[i])
            line = elements(edges, n, e_lo, e_hi, interval.wall_lo, interval.wall_hi)
            sides = (np.full(len(line.x), side[i]) for side in (K_alpha, K_beta))
            q = angular_potential(line, *sides) + sampled(U, angle_of(line.lo, line.hi, line.below))
            return line, 1 - line.x**2, q

        top = low + scale
        room = np.maximum(top - inside(parts.points), 0).max(axis=1)
        fine = parts.cut(-np.diff(np.arccos(parts.edges)) * np.sqrt(room))
        values, error, solutions, n = _by_elements(problem, K_alpha.size, fine, top, scale, count)
        lost = float(seen.lost(values).max())
        return Factors(unit * values, unit * error, AngularTable(solutions), n, seen.said, lost)
    base, (values, vectors), error, n = until_equal(
        attempt, max(count + 24, parts.needed), 1.0, 1.0, count, tolerance, powers_of(*ends)
    )
    functions = AngularTable(IntervalFunctions(base.interval, vectors))
    lost = float(seen.lost(values[:, :count]).max())
    values = values[:, :count]
    return Factors(unit * values, unit * error, functions, n, seen.said, lost)


def _graded(lo: float, hi: float) -> np.ndarray:
    """Return edges within (lo, hi), dense at both ends."""
    steps = (hi - lo) / 2 * np.geomspace(1e-9, 1.0, 31)
    return np.concatenate([lo + steps, (hi - steps[:-1])[::-1]])


def _barriers(name: str, V: Barriers, K_alpha: np.ndarray, K_beta: np.ndarray, count: int, unit: float) -> Factors:
    """e_vartheta = (hbar^2/2 mu) (Q^2 - 1), Q = 2 n + 1 + s_alpha + s_beta."""
    s_alpha = centrifugal(name, K_alpha - 0.25 + 4 * V.c_alpha / unit, "at vartheta = pi") - 0.5
    s_beta = centrifugal(name, K_beta - 0.25 + 4 * V.c_beta / unit, "at vartheta = 0") - 0.5
    values = unit / 4 * ((2 * np.arange(count) + 1 + (s_alpha + s_beta)[:, None]) ** 2 - 1)
    return Factors(values, np.zeros_like(values), BarrierTable(s_alpha, s_beta), count)


def angular_interval(name: str, found: Well, K_alpha: np.ndarray, K_beta: np.ndarray) -> ProblemEnds:
    """Return the interval in x = cos(vartheta) of a well in vartheta, with exponents of the classes."""

    def end(natural, c, K, place):
        if natural:
            return np.array([(exponent(name, k - 0.25 + c, place) - 0.5) / 2 for k in K])
        return np.full(K.shape, exponent(name, c, place))

    e_hi = end(found.natural_lo, found.c_lo, K_beta, "at vartheta = 0" if found.natural_lo else "at its wall")
    e_lo = end(found.natural_hi, found.c_hi, K_alpha, "at vartheta = pi" if found.natural_hi else "at its wall")
    lo = -1.0 if found.natural_hi else _cosine(found.hi)
    hi = 1.0 if found.natural_lo else _cosine(found.lo)
    return ProblemEnds(lo, hi, e_lo, e_hi, not found.natural_hi, not found.natural_lo)


def _cosine(vartheta: float) -> float:
    x = float(np.cos(vartheta))
    return 0.0 if abs(x) < 1e-14 else x


def angular_potential(base: Basis | Elements, K_alpha: np.ndarray, K_beta: np.ndarray) -> np.ndarray:
    """Return the centrifugal terms less those that the weight takes, without the potential: q - (p w')'/w - c-terms of
    natural ends.

    K_alpha, K_beta: a^2 and b^2 of every row of nodes.
    """
    x = base.x
    low = base.below
    high = base.above
    _, _, e0, e1, wall_lo, wall_hi = base.interval
    e0 = e0[:, None]
    e1 = e1[:, None]
    p = 1 - x**2
    q = 2 * e0 * e1 * p / (low * high)
    if wall_lo:
        q = q + 2 * x * e0 / low - p * e0 * (e0 - 1) / low**2 + K_alpha[:, None] / (2 * (1 + x))
    else:  # 2 e0^2/low = (K_alpha + c)/(2 low): the weight takes the c-term of the potential too
        q = q + e0 * (e0 + 1) - (2 * e0**2 - K_alpha[:, None] / 2) / low
    if wall_hi:
        q = q - 2 * x * e1 / high - p * e1 * (e1 - 1) / high**2 + K_beta[:, None] / (2 * (1 - x))
    else:
        q = q + e1 * (e1 + 1) - (2 * e1**2 - K_beta[:, None] / 2) / high
    return q
