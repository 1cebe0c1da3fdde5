"""The well of one separated coordinate around a state: its turning points.

The motion of a separated coordinate in its regular variable s obeys

    F(s) = 2 mu ((u0 + u1 t) s t + u2 s + u3 t - U(s) s t),

with t = 1 (alpha^2, beta^2, r), 1 - s (sin^2) or 1 + s (sinh^2), and U the potential of that coordinate; on a LINE (an
angle) F = 2 mu (u0 - U). It takes place between the zeros of F around the state. Where s is known as a ratio rho = s/t
its distances from both ends have all their digits. Narrow wells and small ones at an axis, where F is a small
difference of large numbers, get F = (s - s1)(s2 - s) G with G from a polynomial and s1, s2 from the state itself.
"""

from typing import Any, NamedTuple

import numpy as np

from ..base.status import OK_CODE, UNBOUND_CODE
from ..compile.jit import jit

RADIAL, SINE, SINH, LINE = 0, 1, 2, 3
RATIO = 1.15
LINE_STEP = 2 * np.pi / 64
"""Steps in which turning points are looked for; barriers narrower than that have knots, where it is looked too."""

CHUNK, FIT = 16, 16
FIT_NOISE, EDGE_NOISE = 1e-12, 1e-11
"""Relative noise of G from a polynomial inside its interval and at its edge, where second derivatives are harder
(measured).
"""

WIDER = 1.6
"""Ratio around a state within which a well is narrow: a polynomial sees no narrow feature of the potential."""

SMALL = 1e-3
"""States this near an axis may be in a well whose energy has lost digits."""

REACH = 1e60
"""Where no turning point is found within this ratio of the start, the motion is unbound."""

S1, T1, S2, T2, WIDTH, ACTION, D0, D1, D2, D3, NODES, CHI, W0, W1, W2, W3, ERROR, CENTRE, RADIUS, PANELS, RESULTS = (
    range(21)
)
"""Entries of a result: ends, half-width, J, dJ/du0...dJ/du3, nodes, phase, integrals to it, error, fitted interval
(radius 0: none), panels (0: none)."""


class Term(NamedTuple):
    """A term of a separated potential: its block function with its parameters, and the increasing ratios (places on a
    line) at which it has narrow features.
    """

    function: Any
    params: np.ndarray
    knots: np.ndarray


class Coordinate(NamedTuple):
    """A separated coordinate: its potential, the mass, its kind, the coefficients u (4,) of its motion, and the limits
    of U s t at s = 0 and at t = 0 (2,).
    """

    term: Term
    mu: float
    kind: int
    u: np.ndarray
    ends: np.ndarray


def _fit_tables():
    """Return Chebyshev nodes, the matrix from values there to coefficients, and the one from these to coefficients of
    powers.
    """
    angles = (np.arange(FIT) + 0.5) * np.pi / FIT
    to_chebyshev = 2 / FIT * np.cos(np.outer(np.arange(FIT), angles))
    to_chebyshev[0] /= 2
    powers = np.zeros((FIT, FIT))
    for k in range(FIT):
        powers[: k + 1, k] = np.polynomial.chebyshev.cheb2poly(np.eye(FIT)[k])[: k + 1]
    return np.cos(angles), np.ascontiguousarray(to_chebyshev), powers


FACTORS = RATIO ** np.outer([1.0, -1.0], np.arange(1, CHUNK + 1))
FIT_NODES, TO_CHEBYSHEV, TO_POWERS = _fit_tables()


@jit
def complement(kind, s):
    """t that belongs to s."""
    if kind == SINE:
        return 1.0 - s
    if kind == SINH:
        return 1.0 + s
    return 1.0


@jit
def radicands(coordinate, n, s, t, F):
    """F (n,) at s, t (n,)."""
    term, mu, kind, u = coordinate.term, coordinate.mu, coordinate.kind, coordinate.u
    term.function(term.params, n, s, F)
    if kind == LINE:
        for k in range(n):
            F[k] = 2 * mu * (u[0] - F[k])
    else:
        for k in range(n):
            W = s[k] * t[k]
            F[k] = 2 * mu * ((u[0] + u[1] * t[k]) * W + u[2] * s[k] + u[3] * t[k] - F[k] * W)


@jit
def set_place(kind, rho, k, work):
    """Write s and t of the ratio rho (s itself on a line) to work[0:2, k]."""
    if kind == SINE:
        work[0, k], work[1, k] = rho / (1 + rho), 1 / (1 + rho)
    else:
        work[0, k], work[1, k] = rho, complement(kind, rho)


@jit
def _radicand(coordinate, rho, work):
    """F at one ratio."""
    set_place(coordinate.kind, rho, 0, work)
    radicands(coordinate, 1, work[0], work[1], work[2])
    return work[2, 0]


@jit
def _scan(coordinate, rho, direction, work):
    """Step away from rho to negative F: (last point before, that point, steps); steps < 0 where there is none."""
    kind = coordinate.kind
    inside, steps, factors = rho, 0, FACTORS[0 if direction > 0 else 1]
    while True:
        for k in range(CHUNK):
            set_place(kind, rho + direction * (k + 1) * LINE_STEP if kind == LINE else rho * factors[k], k, work)
        radicands(coordinate, CHUNK, work[0], work[1], work[2])
        for k in range(CHUNK):
            at = rho + direction * (k + 1) * LINE_STEP if kind == LINE else rho * factors[k]
            if not work[2, k] >= 0.0:
                return inside, at, steps + k + 1
            inside = at
        steps += CHUNK
        if kind == LINE:
            if steps > 64:
                return inside, inside, -1
        elif (direction > 0 and inside > REACH) or (direction < 0 and inside < 1 / REACH):
            return inside, inside, -1
        rho = inside


@jit
def _refine(coordinate, inside, outside, F_inside, work):
    """Root of F between a point of F >= 0 and one of F < 0 (or no number), by Chandrupatla's method."""
    if not F_inside > 0.0:
        return inside
    a, Fa = outside, _radicand(coordinate, outside, work)
    b, Fb = inside, F_inside
    portion = 0.5
    for _ in range(120):
        x = a + portion * (b - a)
        F = _radicand(coordinate, x, work)
        if (F >= 0.0) == (Fa >= 0.0):
            c, Fc = a, Fa
        else:
            c, Fc, b, Fb = b, Fb, a, Fa
        a, Fa = x, F
        best = a if abs(Fa) < abs(Fb) else b
        room = 2.3e-16 * abs(best) / max(abs(b - a), 1e-300)
        if Fa == 0.0 or room > 0.5:
            return a if Fa == 0.0 else best
        portion = 0.5
        xi, phi = (a - b) / (c - b), (Fa - Fb) / (Fc - Fb)
        if phi * phi < xi and (1 - phi) * (1 - phi) < 1 - xi:
            portion = Fa / (Fb - Fa) * Fc / (Fb - Fc) + (c - a) / (b - a) * Fa / (Fc - Fa) * Fb / (Fc - Fb)
        portion = min(1 - room, max(room, portion))
    return a


@jit
def powers(p, x, order):
    """Value (order 0), first or second derivative of the polynomial p (FIT,) at x."""
    value = 0.0
    for i in range(FIT - 1, order - 1, -1):
        factor = 1.0 if order == 0 else (float(i) if order == 1 else float(i) * (i - 1))
        value = value * x + factor * p[i]
    return value


@jit
def _fit(coordinate, side, centre, radius, least, work):
    """Fit powers of x = (s - centre)/radius to F, into work[3], on an interval halved until the fit is exact to
    rounding.

    side 0, 1: the interval begins at s = 0 or ends at s = 1, -1: around the centre. Coefficients that are rounding are
    left out: second derivatives at the edge would multiply them by the fourth power of their number. Returns the
    radius, 0 where it fell below `least`.
    """
    mu, kind, u = coordinate.mu, coordinate.kind, coordinate.u
    rounding = 2e-16 * 2 * mu * (abs(u[0]) + abs(u[1]))
    c, p = work[4], work[3]
    while radius > least:
        middle = centre if side < 0 else (radius if side == 0 else 1 - radius)
        scale = 0.0
        for k in range(FIT):
            work[0, k] = middle + radius * FIT_NODES[k]
            work[1, k] = complement(kind, work[0, k])
        radicands(coordinate, FIT, work[0], work[1], work[2])
        for k in range(FIT):
            scale += abs(work[2, k])
        if np.isfinite(scale):
            size = 0.0
            for i in range(FIT):
                c[i] = 0.0
                for k in range(FIT):
                    c[i] += TO_CHEBYSHEV[i, k] * work[2, k]
                size = max(size, abs(c[i]))
            noise = max(1e-15 * size, 4 * rounding * (abs(middle) + radius if kind != LINE else 1.0))
            if abs(c[FIT - 1]) + abs(c[FIT - 2]) + abs(c[FIT - 3]) < 8 * noise:
                order = FIT
                while order > 3 and abs(c[order - 1]) < noise:
                    order -= 1
                for i in range(FIT):
                    p[i] = 0.0
                    for k in range(i, order):
                        p[i] += TO_POWERS[i, k] * c[k]
                return radius
        radius *= 0.5
    return 0.0


@jit
def _divide(p, root):
    """Divide the polynomial p (FIT,) by x - root in place."""
    carry = 0.0
    for i in range(FIT - 1, -1, -1):
        step = carry * root + p[i]
        p[i] = carry
        carry = step


@jit
def _narrow(coordinate, s0, root0, work, out):
    """Turning points of a narrow well around s0: True where it is one.

    There F is a small difference of large numbers. A polynomial through F on a wider interval is divided by (s - s1)(s2
    - s), which leaves G smooth and exact to rounding however narrow the well is. Its middle m is the root of F', its
    half-width hypot(s0 - m, root0/sqrt(G)): no difference of energies; an equilibrium is the limit.
    """
    kind = coordinate.kind
    wide = 0.5 * LINE_STEP if kind == LINE else 0.2 * (min(s0, 1 - s0) if kind == SINE else s0)
    radius = _fit(coordinate, -1, s0, wide, 0.02 * wide, work)
    if radius == 0.0:
        return False
    p, x = work[3], 0.0
    for i in range(FIT):
        work[4, i] = p[i]
    for _ in range(10):
        bend = powers(p, x, 2)
        if not bend < 0.0:
            return False
        x = min(0.6, max(-0.6, x - powers(p, x, 1) / bend))
    if abs(x) >= 0.6:
        return False
    middle, half = x, 0.0
    for _ in range(30):
        for i in range(FIT):
            p[i] = work[4, i]
        _divide(p, middle - half)
        _divide(p, middle + half)
        here, top = -powers(p, 0.0, 0), -powers(p, x, 0)
        if not (here > 0.0 and top > 0.0 and half < 0.35):
            return False
        before = half
        # F' = 0 at the top x: (2 m - 2 x) G + (l^2 - (x - m)^2) G' = 0.
        middle = x + 0.5 * (half * half - (x - middle) * (x - middle)) * powers(p, x, 1) / top
        half = np.hypot(middle, root0 / np.sqrt(here))
        if abs(half - before) <= 4e-16 * half:
            break
    x = middle
    if half <= 4e-16 * (1.0 if kind == LINE else s0) / radius:
        half = 0.0
    out[S1], out[S2], out[WIDTH] = s0 + radius * (x - half), s0 + radius * (x + half), radius * half
    out[T1], out[T2] = complement(kind, out[S1]), complement(kind, out[S2])
    out[CENTRE], out[RADIUS], out[ERROR] = s0, radius, FIT_NOISE
    return True


@jit
def axis_ends(coordinate, side, x0, root0, speed2, work, out):
    """Turning points of a small well at the axis s = 0 (side 0) or t = 0 (side 1): True where it is one.

    Its energy is a small difference too, but with G from a polynomial as in `_narrow` the ends x1, x2 follow without it
    from F(0) = -x1 x2 G(0), which is the angular momentum's, and F(x0) = root0^2: sums of positive terms, exact for any
    amplitude. speed2 is dF/ds of a state on the axis itself, x0 = 0.
    """
    mu, kind, u, ends = coordinate.mu, coordinate.kind, coordinate.u, coordinate.ends
    wide = 0.07 if kind == SINE else (1e6 * x0 if x0 > 0.0 else 1e3)
    least, p, edge = 20 * x0 + 1e-12 * wide, work[3], -1.0 if side == 0 else 1.0
    while True:
        radius = _fit(coordinate, side, 0.0, wide, least, work)
        if radius == 0.0:
            return False
        size = 0.0
        for i in range(FIT):
            work[4, i] = p[i]
            size += abs(p[i])
        _divide(p, edge)
        _divide(p, edge)
        if size < 30 * abs(powers(p, edge, 0)):  # else higher powers drown the curvature at the axis
            break
        wide = 0.3 * radius
    Lambda2 = max(0.0, 2 * mu * (ends[side] - u[3 - side]))
    first, second, x1, x2, width = edge, edge, 0.0, 0.0, 0.0
    for _ in range(60):
        before = x2
        for i in range(FIT):
            p[i] = work[4, i]
        _divide(p, first)
        _divide(p, second)
        at_axis = -powers(p, edge, 0) / (radius * radius)
        here = -powers(p, edge - edge * x0 / radius, 0) / (radius * radius)
        if not (at_axis > 0.0 and here > 0.0):
            return False
        product = Lambda2 / at_axis
        total = (root0 * root0 / here + product) / x0 + x0 if x0 > 0.0 else speed2 / at_axis
        # l from the state, not from the difference of squares: exact for circular orbits too.
        width = np.hypot(0.5 * total - x0, root0 / np.sqrt(here)) if x0 > 0.0 else 0.5 * total
        width = width if width > 4e-16 * total else 0.0
        x2 = 0.5 * total + width
        x1 = product / x2 if x2 > 0.0 else 0.0
        if not x2 < 0.01 * radius:
            return False
        if abs(x2 - before) <= 4e-16 * x2:
            break
        first, second = edge - edge * x1 / radius, edge - edge * x2 / radius
    out[WIDTH], out[RADIUS], out[ERROR] = width, radius, EDGE_NOISE
    out[CENTRE] = radius if side == 0 else 1 - radius
    if side == 0:
        out[S1], out[S2], out[T1], out[T2] = x1, x2, complement(kind, x1), complement(kind, x2)
    else:
        out[S1], out[S2], out[T1], out[T2] = 1 - x2, 1 - x1, x2, x1
    return True


@jit
def _cancels(coordinate, s, t, root0):
    """Whether the energy of the motion is a small difference: F of the state far below the terms it is made of."""
    return root0 * root0 <= 1e-3 * 2 * coordinate.mu * (abs(coordinate.u[0]) + abs(coordinate.u[1])) * s * t


@jit
def _nearest(coordinate, rho, direction, inside, outside, steps, work):
    """Look for a turning point at the knots on the way to the one of `_scan`, which is returned where there is none."""
    knots = coordinate.term.knots
    last, first = rho, int(np.searchsorted(knots, rho))
    for i in range(knots.size):
        k = first + i if direction > 0 else first - 1 - i
        if k < 0 or k >= knots.size or (steps > 0 and (knots[k] - outside) * direction >= 0):
            break
        if knots[k] == rho:
            continue
        if not _radicand(coordinate, knots[k], work) >= 0.0:
            return last, knots[k], 1 if last == rho else 2
        last = knots[k]
    # The point inside that is nearest to the turning point.
    return (
        (last if (last - inside) * direction > 0 else inside),
        outside,
        (steps if steps < 2 and last == rho else max(2, steps)),
    )


@jit
def turning_points(coordinate, s0, t0, root0, speed2, work, out):
    """Find the turning points around s0, t0, where F = root0^2, root0 < 0 or > 0 by the direction; returns a status."""
    kind, u, ends, knots = coordinate.kind, coordinate.u, coordinate.ends, coordinate.term.knots
    out[RADIUS], out[PANELS] = 0.0, 0.0
    falls = kind != LINE and u[3] > ends[0]
    rare = knots.size == 0
    if (
        rare
        and kind != LINE
        and not falls
        and np.isfinite(ends[0])
        and (kind != SINE or s0 < SMALL)
        and _cancels(coordinate, s0, t0, root0)
    ):
        if axis_ends(coordinate, 0, s0, root0, speed2, work, out):
            return OK_CODE
        out[RADIUS] = 0.0
    if rare and kind == SINE and t0 < SMALL and np.isfinite(ends[1]) and _cancels(coordinate, s0, t0, root0):
        if axis_ends(coordinate, 1, t0, root0, speed2, work, out):
            return OK_CODE
        out[RADIUS] = 0.0
    if kind != LINE:
        s0, t0 = max(s0, 1e-59), max(t0, 1e-59)
    rho = s0 / t0 if kind == SINE else s0
    below, under, down = _scan(coordinate, rho, -1, work)
    above, over, up = _scan(coordinate, rho, +1, work)
    if knots.size > 0:
        below, under, down = _nearest(coordinate, rho, -1, below, under, down, work)
        above, over, up = _nearest(coordinate, rho, +1, above, over, up, work)
    smooth = knots.size == 0 or np.searchsorted(knots, rho / WIDER) == np.searchsorted(knots, rho * WIDER)
    if kind == LINE:
        smooth = np.searchsorted(knots, rho - LINE_STEP) == np.searchsorted(knots, rho + LINE_STEP)
    if smooth and down == 1 and up == 1 and _narrow(coordinate, s0, root0, work, out):
        return OK_CODE
    if (up < 0 and kind != SINE) or (down < 0 and (kind == LINE or falls)):
        return UNBOUND_CODE
    low, high = 0.0, np.inf
    if down > 0:
        F = root0 * root0 if down == 1 else _radicand(coordinate, below, work)
        low = _refine(coordinate, below, under, F, work)
    if up > 0:
        F = root0 * root0 if up == 1 else _radicand(coordinate, above, work)
        high = _refine(coordinate, above, over, F, work)
    set_place(kind, low, 0, work)
    out[S1], out[T1] = work[0, 0], work[1, 0]
    set_place(kind, high if high < np.inf else 1.0, 0, work)
    out[S2], out[T2] = (work[0, 0], work[1, 0]) if high < np.inf else (1.0, 0.0)
    out[WIDTH] = 0.5 * (out[T1] - out[T2] if kind == SINE and out[S1] > 0.5 else out[S2] - out[S1])
    return OK_CODE
