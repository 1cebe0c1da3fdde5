"""One separated coordinate: its turning points and loop integrals (layer L2).

The motion of a separated coordinate in its regular variable s obeys

    F(s) = 2 mu ((u0 + u1 t) s t + u2 s + u3 t - U(s) s t),   J = 1/2 loop integral of sqrt(F)/(s t) ds,

with t = 1 (alpha^2, beta^2, r), 1 - s (sin^2) or 1 + s (sinh^2), and U the potential of that coordinate; on a LINE (an angle)
F = 2 mu (u0 - U) and J = loop integral of sqrt(F) ds. Between the turning points s = s1 + 2 l sin^2(chi/2), F = (s - s1)(s2 - s) G,
and J and its derivatives to u0...u3 are integrals over chi of smooth even functions of period 2 pi, which sums over midpoints give
with exponential accuracy. The functions 1/s and 1/t, near whose pole a turning point may lie, are taken off in closed form.
Where s is known as a ratio rho = s/t its distances from both ends have all their digits.
"""

import numpy as np

from .._jit import jit
from ..status import NOT_CONVERGED_CODE, OK_CODE, UNBOUND_CODE

RADIAL, SINE, SINH, LINE = 0, 1, 2, 3
LEAST, MOST = 16, 2048
"""Numbers of midpoints: doubled until the last Fourier coefficients vanish."""

RATIO = 1.15
LINE_STEP = 2 * np.pi / 64
"""Steps in which turning points are looked for: barriers narrower than that can be overlooked."""

APART = 0.6
"""Poles are taken off where the turning points lie further apart than this ratio; nearer, J would be a small difference."""

CHUNK, FIT = 16, 16
FIT_NOISE, EDGE_NOISE = 1e-12, 1e-11
"""Relative noise of G from a polynomial inside its interval and at its edge, where second derivatives are harder (measured)."""

SMALL = 1e-3
"""States this near an axis may be in a well whose energy has lost digits; it gets G from a polynomial."""

REACH = 1e60
"""Where no turning point is found within this ratio of the start, the motion is unbound."""

S1, T1, S2, T2, WIDTH, ACTION, D0, D1, D2, D3, NODES, CHI, W0, W1, W2, W3, ERROR, CENTRE, RADIUS, RESULTS = range(20)
"""Entries of the result of `librate`: ends, half-width, J, dJ/du0...dJ/du3, nodes, phase, integrals to it, error, fitted interval."""

ROWS = 12
"""Rows of work memory, of MOST numbers each."""

_FIRST = 5
"""Rows of work memory: s and t; F; the quotient of a narrow well; the integrands J, D0...D3; cosines. Rows 2 and 4 hold weights."""


def _tables():
    """Return sin^2(chi/2), sin(chi), cos(chi) at the midpoints of each number of nodes, one after another."""
    out = []
    nodes = LEAST
    while nodes <= MOST:
        chi = (np.arange(nodes) + 0.5) * np.pi / nodes
        out.append([np.sin(chi / 2) ** 2, np.sin(chi), np.cos(chi)])
        nodes *= 2
    return np.ascontiguousarray(np.concatenate(out, axis=1))


def _fit_tables():
    """Return Chebyshev nodes, the matrix from values there to coefficients, and the one from these to coefficients of powers."""
    angles = (np.arange(FIT) + 0.5) * np.pi / FIT
    to_chebyshev = 2 / FIT * np.cos(np.outer(np.arange(FIT), angles))
    to_chebyshev[0] /= 2
    powers = np.zeros((FIT, FIT))
    for k in range(FIT):
        powers[: k + 1, k] = np.polynomial.chebyshev.cheb2poly(np.eye(FIT)[k])[: k + 1]
    return np.cos(angles), np.ascontiguousarray(to_chebyshev), powers


TABLES = _tables()
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
def radicands(potential, params, mu, u, kind, n, s, t, F):
    """F (n,) at s, t (n,)."""
    potential(params, n, s, F)
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
def _radicand(potential, params, mu, u, kind, rho, work):
    """F at one ratio."""
    set_place(kind, rho, 0, work)
    radicands(potential, params, mu, u, kind, 1, work[0], work[1], work[2])
    return work[2, 0]


@jit
def _scan(potential, params, mu, u, kind, rho, direction, work):
    """Step away from rho to negative F: (last point before, that point, steps); steps < 0 where there is none."""
    inside, steps, factors = rho, 0, FACTORS[0 if direction > 0 else 1]
    while True:
        start = rho if kind != LINE else rho + direction * steps * LINE_STEP
        for k in range(CHUNK):
            set_place(kind, start + direction * (k + 1) * LINE_STEP if kind == LINE else start * factors[k], k, work)
        radicands(potential, params, mu, u, kind, CHUNK, work[0], work[1], work[2])
        for k in range(CHUNK):
            at = start + direction * (k + 1) * LINE_STEP if kind == LINE else start * factors[k]
            if not work[2, k] >= 0.0:
                return inside, at, steps + k + 1
            inside = at
        steps += CHUNK
        if kind == LINE:
            if steps > 64:
                return inside, inside, -1
        elif (direction > 0 and inside > REACH) or (direction < 0 and inside < 1 / REACH):
            return inside, inside, -1
        else:
            rho = inside


@jit
def _refine(potential, params, mu, u, kind, inside, outside, F_inside, work):
    """Root of F between a point of F >= 0 and one of F < 0 (or no number), by Chandrupatla's method."""
    if not F_inside > 0.0:
        return inside
    a, Fa = outside, _radicand(potential, params, mu, u, kind, outside, work)
    b, Fb = inside, F_inside
    portion = 0.5
    for _ in range(120):
        x = a + portion * (b - a)
        F = _radicand(potential, params, mu, u, kind, x, work)
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
def _fit(potential, params, mu, u, kind, side, centre, radius, least, work):
    """Fit powers of x = (s - centre)/radius to F, into work[3], on an interval halved until the fit is exact to rounding.

    side 0, 1: the interval begins at s = 0 or ends at s = 1, -1: around the centre. Coefficients that are rounding are left out: second
    derivatives at the edge would multiply them by the fourth power of their number. Returns the radius, 0 where it fell below `least`.
    """
    rounding = 2e-16 * 2 * mu * (abs(u[0]) + abs(u[1]))
    c, p = work[4], work[3]
    while radius > least:
        middle = centre if side < 0 else (radius if side == 0 else 1 - radius)
        scale = 0.0
        for k in range(FIT):
            work[0, k] = middle + radius * FIT_NODES[k]
            work[1, k] = complement(kind, work[0, k])
        radicands(potential, params, mu, u, kind, FIT, work[0], work[1], work[2])
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
def _narrow(potential, params, mu, u, kind, s0, root0, work, out):
    """Turning points of a narrow well around s0: True where it is one.

    There F is a small difference of large numbers. A polynomial through F on a wider interval is divided by (s - s1)(s2 - s),
    which leaves G smooth and exact to rounding however narrow the well is. Its middle m is the root of F', its half-width
    hypot(s0 - m, root0/sqrt(G)): no difference of energies; an equilibrium is the limit.
    """
    wide = 0.5 * LINE_STEP if kind == LINE else 0.2 * (min(s0, 1 - s0) if kind == SINE else s0)
    radius = _fit(potential, params, mu, u, kind, -1, s0, wide, 0.02 * wide, work)
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
def axis_ends(potential, params, mu, u, kind, ends, side, x0, root0, speed2, work, out):
    """Turning points of a small well at the axis s = 0 (side 0) or t = 0 (side 1): True where it is one.

    Its energy is a small difference too, but with G from a polynomial as in `_narrow` the ends x1, x2 follow without it from
    F(0) = -x1 x2 G(0), which is the angular momentum's, and F(x0) = root0^2: sums of positive terms, exact for any amplitude.
    speed2 is dF/ds of a state on the axis itself, x0 = 0.
    """
    wide = 0.07 if kind == SINE else (1e6 * x0 if x0 > 0.0 else 1e3)
    least, p, edge = 20 * x0 + 1e-12 * wide, work[3], -1.0 if side == 0 else 1.0
    while True:
        radius = _fit(potential, params, mu, u, kind, side, 0.0, wide, least, work)
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
def _cancels(mu, u, s, t, root0):
    """Whether the energy of the motion is a small difference: F of the state far below the terms it is made of."""
    return root0 * root0 <= 1e-3 * 2 * mu * (abs(u[0]) + abs(u[1])) * s * t


@jit
def turning_points(potential, params, mu, u, kind, ends, s0, t0, root0, speed2, work, out):
    """Find the turning points around s0, t0, where F = root0^2 (root0 < 0 or > 0 for the direction); returns a status."""
    out[RADIUS] = 0.0
    falls = kind != LINE and u[3] > ends[0]
    if kind != LINE and not falls and np.isfinite(ends[0]) and (kind != SINE or s0 < SMALL) and _cancels(mu, u, s0, t0, root0):
        if axis_ends(potential, params, mu, u, kind, ends, 0, s0, root0, speed2, work, out):
            return OK_CODE
        out[RADIUS] = 0.0
    if kind == SINE and t0 < SMALL and np.isfinite(ends[1]) and _cancels(mu, u, s0, t0, root0):
        if axis_ends(potential, params, mu, u, kind, ends, 1, t0, root0, speed2, work, out):
            return OK_CODE
        out[RADIUS] = 0.0
    if kind != LINE:
        s0, t0 = max(s0, 1e-59), max(t0, 1e-59)
    rho = s0 / t0 if kind == SINE else s0
    below, under, down = _scan(potential, params, mu, u, kind, rho, -1, work)
    above, over, up = _scan(potential, params, mu, u, kind, rho, +1, work)
    if down == 1 and up == 1 and _narrow(potential, params, mu, u, kind, s0, root0, work, out):
        return OK_CODE
    if (up < 0 and kind != SINE) or (down < 0 and (kind == LINE or falls)):
        return UNBOUND_CODE
    low, high = 0.0, np.inf
    if down > 0:
        F = root0 * root0 if down == 1 else _radicand(potential, params, mu, u, kind, below, work)
        low = _refine(potential, params, mu, u, kind, below, under, F, work)
    if up > 0:
        F = root0 * root0 if up == 1 else _radicand(potential, params, mu, u, kind, above, work)
        high = _refine(potential, params, mu, u, kind, above, over, F, work)
    set_place(kind, low, 0, work)
    out[S1], out[T1] = work[0, 0], work[1, 0]
    set_place(kind, high if high < np.inf else 1.0, 0, work)
    out[S2], out[T2] = (work[0, 0], work[1, 0]) if high < np.inf else (1.0, 0.0)
    out[WIDTH] = 0.5 * (out[T1] - out[T2] if kind == SINE and out[S1] > 0.5 else out[S2] - out[S1])
    return OK_CODE


@jit
def _poles(mu, u, kind, ends, out):
    """Lambda = sqrt(-F) at s = 0 and at t = 0, 0 where that end is far from the turning points or its pole is not there."""
    at_0, at_1 = 0.0, 0.0
    if kind != LINE and out[S1] < APART * out[S2] and np.isfinite(ends[0]):
        at_0 = np.sqrt(max(0.0, 2 * mu * (ends[0] - u[3])))
    if kind == SINE and out[T2] < APART * out[T1] and np.isfinite(ends[1]):
        at_1 = np.sqrt(max(0.0, 2 * mu * (ends[1] - u[2])))
    if kind == SINH and out[T1] < APART * out[T2] and np.isfinite(ends[1]):
        # Beyond the ends of motion a branch point of sqrt(G) comes to the pole where Lambda is small: then it stays.
        at_1 = np.sqrt(max(0.0, 2 * mu * (ends[1] + u[2])))
        at_1 = at_1 if at_1 * at_1 > 0.1 * mu * (abs(u[0]) + abs(u[1])) else 0.0
    return at_0, at_1


@jit
def _integrands(potential, params, mu, u, kind, nodes, at_0, at_1, work, out):
    """Fill the rows J, D0...D3 of the integrands at the midpoints; False where F is not positive there."""
    off, s1, t2, width = nodes - LEAST, out[S1], out[T2], out[WIDTH]
    s, t, F = work[0], work[1], work[2]
    for k in range(nodes):
        s[k] = s1 + 2 * width * TABLES[0, off + k]
    for k in range(nodes):
        t[k] = t2 + 2 * width * TABLES[0, off + nodes - 1 - k] if kind == SINE else complement(kind, s[k])
    if out[RADIUS] > 0.0:
        p, scale = work[3], -1 / (out[RADIUS] * out[RADIUS])
        for k in range(nodes):
            F[k] = scale * powers(p, (s[k] - out[CENTRE]) / out[RADIUS], 0)
    else:
        radicands(potential, params, mu, u, kind, nodes, s, t, F)
        for k in range(nodes):
            F[k] /= 4 * width * width * TABLES[0, off + k] * TABLES[0, off + nodes - 1 - k]
    good = True
    for k in range(nodes):
        good = good and F[k] > 0.0 and F[k] < np.inf
    if not good:
        return False
    J, f0, f1, f2, f3 = work[5], work[6], work[7], work[8], work[9]
    near_0, near_1 = np.sqrt(s1 * out[S2]), np.sqrt(out[T1] * t2)
    take_0, take_1 = 0.0 if at_0 == 0.0 else near_0 / at_0, 0.0 if at_1 == 0.0 else near_1 / at_1
    give_0, give_1 = at_0 * near_0, (-at_1 if kind == SINH else at_1) * near_1
    # Through the axis itself the pole is not integrable: that derivative jumps and has no value.
    has_0, has_1 = s1 > 0.0 or at_0 > 0.0, t2 > 0.0 or at_1 > 0.0
    for k in range(nodes):
        G = np.sqrt(F[k])
        square = 4 * width * width * TABLES[0, off + k] * TABLES[0, off + nodes - 1 - k]
        f0[k] = 1 / G
        if kind == LINE:
            J[k], f1[k], f2[k], f3[k] = G * square, 0.0, 0.0, 0.0
        else:
            v, w = 1 / s[k] if s[k] > 0.0 else 0.0, 1 / t[k] if t[k] > 0.0 else 0.0
            J[k] = G * square * v * w + give_0 * v + give_1 * w
            f1[k] = t[k] * f0[k]
            f2[k] = (f0[k] - take_1) * w if has_1 else 0.0
            f3[k] = (f0[k] - take_0) * v if has_0 else 0.0
    return True


@jit
def _tail(kind, nodes, at_0, at_1, work):
    """Size of the last Fourier coefficients of the integrands, relative to the integrals with what was taken off."""
    off, worst = nodes - LEAST, 0.0
    for row in range(_FIRST, _FIRST + 2 if kind == LINE else _FIRST + 5):
        first, second, size, sign = 0.0, 0.0, 0.0, 1.0
        if row == _FIRST + 4 and at_0 > 0.0:
            size = nodes / at_0
        if row == _FIRST + 3 and at_1 > 0.0:
            size = nodes / at_1
        f = work[row]
        for k in range(nodes):
            term = sign * f[k] * TABLES[1, off + k]
            first += term
            second += 2 * term * TABLES[2, off + k]
            size += abs(f[k])
            sign = -sign
        if size > 0.0:
            worst = max(worst, 2 * (abs(first) + abs(second)) / size)
    return worst


@jit
def _noise(mu, u, kind, nodes, work, out):
    """Relative error of dJ/du0 from the rounding of F, a difference of large terms."""
    off, total, sum_f = nodes - LEAST, 0.0, 0.0
    size = 4e-16 * mu * (abs(u[0]) + abs(u[1])) / (4 * out[WIDTH] * out[WIDTH])
    for k in range(nodes):
        f = work[_FIRST + 1, k]
        square = TABLES[0, off + k] * TABLES[0, off + nodes - 1 - k]
        total += size * (work[0, k] * work[1, k] if kind != LINE else 1.0) * f * f * f / square
        sum_f += f
    return 1e-15 + total / sum_f


@jit
def integrals(potential, params, mu, u, kind, ends, goal, work, out):
    """Loop integrals J, dJ/du0...dJ/du3 between the turning points in `out`; returns a status."""
    at_0, at_1 = _poles(mu, u, kind, ends, out)
    nodes, before = LEAST, np.inf
    while True:
        if not _integrands(potential, params, mu, u, kind, nodes, at_0, at_1, work, out):
            return NOT_CONVERGED_CODE
        tail = _tail(kind, nodes, at_0, at_1, work)
        # Coefficients that stop falling are rounding; more nodes would only add to it.
        if tail <= goal or (tail > 0.3 * before and before < 1e-9) or nodes == MOST:
            break
        before = tail
        nodes *= 2
    scale = (2 if kind == LINE else 1) * np.pi / nodes
    for j in range(5):
        out[ACTION + j] = scale * (1.0 if j == 0 else mu) * work[_FIRST + j, :nodes].sum()
    if at_0 > 0.0:
        out[ACTION] -= np.pi * at_0
        out[D3] += mu * np.pi / at_0
    if at_1 > 0.0:
        out[ACTION] += np.pi * at_1 if kind == SINH else -np.pi * at_1
        out[D2] += mu * np.pi / at_1
    if kind != LINE and out[S1] == 0.0 and at_0 == 0.0:
        out[D3] = np.inf
    if kind == SINE and out[T2] == 0.0 and at_1 == 0.0:
        out[D2] = np.inf
    if out[RADIUS] == 0.0:
        out[ERROR] = _noise(mu, u, kind, nodes, work, out)
    out[NODES], out[ERROR] = nodes, max(10 * tail, out[ERROR])
    return OK_CODE if tail < 1e-7 else NOT_CONVERGED_CODE


@jit
def _dirichlet(nodes, x):
    """1 + 2 (cos x + ... + cos((nodes - 1) x))."""
    x = abs(x)
    x = x if x < np.pi else 2 * np.pi - x  # both sines of one small number: their errors cancel
    half = np.sin(0.5 * x)
    return np.sin((nodes - 0.5) * x) / half if abs(half) > 1e-12 else 2.0 * nodes - 1


@jit
def inverse_root(chi, work, out):
    """1/sqrt(G) at the phase chi: the cosine series through its values at the midpoints."""
    nodes, total = int(out[NODES]), 0.0
    chi = chi if chi < np.pi else 2 * np.pi - chi
    for k in range(nodes):
        at = (k + 0.5) * np.pi / nodes
        total += work[6, k] * (_dirichlet(nodes, chi - at) + _dirichlet(nodes, chi + at))
    return total / (2 * nodes)


@jit
def phase(kind, s0, t0, root0, work, out):
    """Set chi of the state: s = s1 + 2 l sin^2(chi/2), and near the turning points sqrt(F) = l sin(chi) sqrt(G), precise there."""
    width = out[WIDTH]
    if width <= 0.0:
        out[CHI] = 0.0
        return
    upper = kind == SINE and s0 > 0.5
    d1, d2 = out[T1] - t0 if upper else s0 - out[S1], t0 - out[T2] if upper else out[S2] - s0
    sign = 1.0 if root0 >= 0.0 else -1.0
    chi = np.arctan2(sign * np.sqrt(max(0.0, d1 * d2)), (d2 - d1) / 2)
    near = d1 < 1e-3 * s0 or d2 < 1e-3 * (t0 if upper else s0)
    if near or kind == LINE:
        chi = np.arctan2(root0 * inverse_root(chi, work, out), (d2 - d1) / 2)
    out[CHI] = chi if chi >= 0.0 else chi + 2 * np.pi


@jit
def partials(mu, u, kind, ends, work, out):
    """Set W0...W3, the integrals of dJ/du0...dJ/du3 from chi = 0 to the state's chi (a whole turn gives dJ/du)."""
    chi, nodes = out[CHI], int(out[NODES])
    half, off, last, now, even, odd = nodes // 2, nodes - LEAST, work[10], work[11], work[2], work[4]
    for k in range(half):  # cos(n chi) of node nodes - 1 - k is that of node k, with the sign (-1)^n
        last[k], now[k], even[k], odd[k] = 1.0, TABLES[2, off + k], chi, 0.0
    sine, sine_last, turn = np.sin(chi), 0.0, 2 * np.cos(chi)
    for n in range(1, nodes, 2):
        c = 2 * sine / n
        sine, sine_last = turn * sine - sine_last, sine
        d = 2 * sine / (n + 1) if n + 1 < nodes else 0.0
        sine, sine_last = turn * sine - sine_last, sine
        for k in range(half):
            double = 2 * TABLES[2, off + k]
            odd[k] += c * now[k]
            last[k] = double * now[k] - last[k]
            even[k] += d * last[k]
            now[k] = double * last[k] - now[k]
    scale = (1.0 if kind == LINE else 0.5) * mu / nodes
    for j in range(4):
        f, total = work[_FIRST + 1 + j], 0.0
        for k in range(half):
            total += (even[k] + odd[k]) * f[k] + (even[k] - odd[k]) * f[nodes - 1 - k]
        out[W0 + j] = scale * total
    at_0, at_1 = _poles(mu, u, kind, ends, out)
    half_sine, half_cosine = np.sin(chi / 2), np.cos(chi / 2)
    if at_0 > 0.0:
        out[W3] += mu / at_0 * np.arctan2(np.sqrt(out[S2]) * half_sine, np.sqrt(out[S1]) * half_cosine)
    if at_1 > 0.0:
        out[W2] += mu / at_1 * np.arctan2(np.sqrt(out[T2]) * half_sine, np.sqrt(out[T1]) * half_cosine)


@jit
def limits(potential, params, kind, work, ends):
    """Write the limits of U s t at s = 0 and at t = 0 to ends (2,): the potential's own walls there."""
    s, U = work[0], work[2]
    ends[0], ends[1] = 0.0, 0.0
    if kind == LINE:
        return
    s[0] = 1e-200
    for k in range(1, 3):  # s = 1 or, beyond the end of the motion, s = -1
        s[k] = 1 - 10.0 ** (-2 * k - 4) if kind == SINE else 10.0 ** (-2 * k - 4) - 1
    potential(params, 3, s, U)
    ends[0] = U[0] * 1e-200 if abs(U[0]) > 1e110 or not np.isfinite(U[0]) else 0.0
    if kind != RADIAL:
        far, near = U[1] * s[1] * complement(kind, s[1]), U[2] * s[2] * complement(kind, s[2])
        # A wall c/t keeps its size towards t = 0; a regular potential's falls with t.
        if not np.isfinite(near):
            ends[1] = near
        elif abs(near) > 0.5 * abs(far):
            ends[1] = near + (near - far) / 99


@jit
def librate(potential, params, mu, u, kind, ends, s0, t0, root0, speed2, goal, work, out):
    """Turning points, loop integrals, phase and integrals up to it of one state; returns a status."""
    code = turning_points(potential, params, mu, u, kind, ends, s0, t0, root0, speed2, work, out)
    if code == OK_CODE:
        code = integrals(potential, params, mu, u, kind, ends, goal, work, out)
    if code == OK_CODE:
        phase(kind, s0, t0, root0, work, out)
        partials(mu, u, kind, ends, work, out)
    return code
