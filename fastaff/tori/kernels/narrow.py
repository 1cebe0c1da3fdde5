"""Narrow wells and small ones at an axis: turning points by a polynomial through F, without differences of energies."""

import numpy as np

from ...engine.jit import jit
from .coordinates import CENTRE, ERROR, LINE, LINE_STEP, RADIUS, S1, S2, SINE, T1, T2, WIDTH, complement, radicands

FIT_NOISE = 1e-12
"""Relative noise of G from a polynomial inside its interval (measured)."""

EDGE_NOISE = 1e-11
"""Relative noise of G at the edge of the interval, where second derivatives are harder (measured)."""

FIT = 16
"""Coefficients of a polynomial."""


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


FIT_NODES, TO_CHEBYSHEV, TO_POWERS = _fit_tables()


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

    side: 0 if the interval begins at s = 0, 1 if it ends at s = 1, -1 if it is around the centre. Coefficients that are
    rounding are left out: second derivatives at the edge would multiply them by the fourth power of their number.
    Returns the radius, 0 where it fell below `least`.
    """
    mu = coordinate.mu
    kind = coordinate.kind
    u = coordinate.u
    rounding = 2e-16 * 2 * mu * (abs(u[0]) + abs(u[1]))
    c = work[4]
    p = work[3]
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
def narrow_well(coordinate, s0, root0, work, out):
    """Turning points of a narrow well around s0; returns True where the well is narrow.

    There F is a small difference of large numbers. A polynomial through F on a wider interval is divided by (s - s1)(s2
    - s); the quotient G is smooth and exact to rounding for any width of the well. Its middle m is the root of F', its
    half-width hypot(s0 - m, root0/sqrt(G)): no difference of energies; an equilibrium is the limit.
    """
    kind = coordinate.kind
    wide = 0.5 * LINE_STEP if kind == LINE else 0.2 * (min(s0, 1 - s0) if kind == SINE else s0)
    radius = _fit(coordinate, -1, s0, wide, 0.02 * wide, work)
    if radius == 0.0:
        return False
    p = work[3]
    x = 0.0
    for i in range(FIT):
        work[4, i] = p[i]
    for _ in range(10):
        bend = powers(p, x, 2)
        if not bend < 0.0:
            return False
        x = min(0.6, max(-0.6, x - powers(p, x, 1) / bend))
    if abs(x) >= 0.6:
        return False
    middle = x
    half = 0.0
    for _ in range(30):
        for i in range(FIT):
            p[i] = work[4, i]
        _divide(p, middle - half)
        _divide(p, middle + half)
        here = -powers(p, 0.0, 0)
        top = -powers(p, x, 0)
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
    out[S1] = s0 + radius * (x - half)
    out[S2] = s0 + radius * (x + half)
    out[WIDTH] = radius * half
    out[T1] = complement(kind, out[S1])
    out[T2] = complement(kind, out[S2])
    out[CENTRE] = s0
    out[RADIUS] = radius
    out[ERROR] = FIT_NOISE
    return True


@jit
def axis_ends(coordinate, side, x0, root0, speed2, work, out):
    """Turning points of a small well at the axis s = 0 (side 0) or t = 0 (side 1); returns True where it is small.

    Its energy is a small difference too. With G from a polynomial as in `narrow_well` the ends x1, x2 follow without it
    from F(0) = -x1 x2 G(0), given by the angular momentum, and F(x0) = root0^2: sums of positive terms, exact for any
    amplitude. speed2 is dF/ds of a state on the axis itself, x0 = 0.
    """
    mu = coordinate.mu
    kind = coordinate.kind
    u = coordinate.u
    ends = coordinate.ends
    wide = 0.07 if kind == SINE else (1e6 * x0 if x0 > 0.0 else 1e3)
    least = 20 * x0 + 1e-12 * wide
    p = work[3]
    edge = -1.0 if side == 0 else 1.0
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
        if size < 30 * abs(powers(p, edge, 0)):  # else higher powers hide the curvature at the axis
            break
        wide = 0.3 * radius
    Lambda2 = max(0.0, 2 * mu * (ends[side] - u[3 - side]))
    first = edge
    second = edge
    x1 = 0.0
    x2 = 0.0
    width = 0.0
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
        first = edge - edge * x1 / radius
        second = edge - edge * x2 / radius
    out[WIDTH] = width
    out[RADIUS] = radius
    out[ERROR] = EDGE_NOISE
    out[CENTRE] = radius if side == 0 else 1 - radius
    if side == 0:
        out[S1] = x1
        out[S2] = x2
        out[T1] = complement(kind, x1)
        out[T2] = complement(kind, x2)
    else:
        out[S1] = 1 - x2
        out[S2] = 1 - x1
        out[T1] = x2
        out[T2] = x1
    return True
