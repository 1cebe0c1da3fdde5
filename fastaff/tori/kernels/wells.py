"""The well of one separated coordinate around a state: its turning points.

The motion of a separated coordinate in its regular variable s obeys

    F(s) = 2 mu ((u0 + u1 t) s t + u2 s + u3 t - U(s) s t),

with t = 1 (alpha^2, beta^2, r), 1 - s (sin^2) or 1 + s (sinh^2), and U the potential of that coordinate; on a LINE (an
angle) F = 2 mu (u0 - U). It takes place between the zeros of F around the state. With s given by the ratio rho = s/t
its distances from both ends have all their digits. In narrow wells and small ones at an axis F is a small difference of
large numbers; they get F = (s - s1)(s2 - s) G with G from a polynomial and s1, s2 from the state itself.
"""

import numpy as np

from ...core.status import OK_CODE, UNBOUND_CODE
from ...engine.jit import jit
from .coordinates import LINE, LINE_STEP, PANELS, RADIUS, S1, S2, SINE, T1, T2, WIDTH, radicands, set_place
from .narrow import axis_ends, narrow_well

RATIO = 1.15
"""Quotient of neighbouring places of a search for a turning point."""

CHUNK = 16
"""Places of this search that are computed at once."""

WIDER = 1.6
"""Largest ratio around a state of a narrow well, so that its polynomial meets no narrow feature of the potential."""

SMALL = 1e-3
"""States this close to an axis may be in a well whose energy has lost digits."""

REACH = 1e60
"""The motion is unbound if there is no turning point within this ratio of the start."""


FACTORS = RATIO ** np.outer([1.0, -1.0], np.arange(1, CHUNK + 1))
"""Places of a chunk, over its start, outward and inward."""


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
    inside = rho
    steps = 0
    factors = FACTORS[0 if direction > 0 else 1]
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
    a = outside
    Fa = _radicand(coordinate, outside, work)
    b = inside
    Fb = F_inside
    portion = 0.5
    for _ in range(120):
        x = a + portion * (b - a)
        F = _radicand(coordinate, x, work)
        if (F >= 0.0) == (Fa >= 0.0):
            c = a
            Fc = Fa
        else:
            c = b
            Fc = Fb
            b = a
            Fb = Fa
        a = x
        Fa = F
        best = a if abs(Fa) < abs(Fb) else b
        room = 2.3e-16 * abs(best) / max(abs(b - a), 1e-300)
        if Fa == 0.0 or room > 0.5:
            return a if Fa == 0.0 else best
        portion = 0.5
        xi = (a - b) / (c - b)
        phi = (Fa - Fb) / (Fc - Fb)
        if phi * phi < xi and (1 - phi) * (1 - phi) < 1 - xi:
            portion = Fa / (Fb - Fa) * Fc / (Fb - Fc) + (c - a) / (b - a) * Fa / (Fc - Fa) * Fb / (Fc - Fb)
        portion = min(1 - room, max(room, portion))
    return a


@jit
def _cancels(coordinate, s, t, root0):
    """Whether the energy of the motion is a small difference: F of the state is far smaller than its terms."""
    return root0 * root0 <= 1e-3 * 2 * coordinate.mu * (abs(coordinate.u[0]) + abs(coordinate.u[1])) * s * t


@jit
def _nearest(coordinate, rho, direction, inside, outside, steps, work):
    """Search for a turning point at the knots on the way to that of `_scan`; return the latter where there is none."""
    knots = coordinate.term.knots
    last = rho
    first = int(np.searchsorted(knots, rho))
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
    kind = coordinate.kind
    u = coordinate.u
    ends = coordinate.ends
    knots = coordinate.term.knots
    out[RADIUS] = 0.0
    out[PANELS] = 0.0
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
        s0 = max(s0, 1e-59)
        t0 = max(t0, 1e-59)
    rho = s0 / t0 if kind == SINE else s0
    below, under, down = _scan(coordinate, rho, -1, work)
    above, over, up = _scan(coordinate, rho, +1, work)
    if knots.size > 0:
        below, under, down = _nearest(coordinate, rho, -1, below, under, down, work)
        above, over, up = _nearest(coordinate, rho, +1, above, over, up, work)
    smooth = knots.size == 0 or np.searchsorted(knots, rho / WIDER) == np.searchsorted(knots, rho * WIDER)
    if kind == LINE:
        smooth = np.searchsorted(knots, rho - LINE_STEP) == np.searchsorted(knots, rho + LINE_STEP)
    if smooth and down == 1 and up == 1 and narrow_well(coordinate, s0, root0, work, out):
        return OK_CODE
    if (up < 0 and kind != SINE) or (down < 0 and (kind == LINE or falls)):
        return UNBOUND_CODE
    low = 0.0
    high = np.inf
    if down > 0:
        F = root0 * root0 if down == 1 else _radicand(coordinate, below, work)
        low = _refine(coordinate, below, under, F, work)
    if up > 0:
        F = root0 * root0 if up == 1 else _radicand(coordinate, above, work)
        high = _refine(coordinate, above, over, F, work)
    set_place(kind, low, 0, work)
    out[S1] = work[0, 0]
    out[T1] = work[1, 0]
    set_place(kind, high if high < np.inf else 1.0, 0, work)
    out[S2], out[T2] = (work[0, 0], work[1, 0]) if high < np.inf else (1.0, 0.0)
    out[WIDTH] = 0.5 * (out[T1] - out[T2] if kind == SINE and out[S1] > 0.5 else out[S2] - out[S1])
    return OK_CODE
