"""The constant of a separated coordinate whose motion has a given action, by Newton's method."""

import numpy as np

from ...core.status import OK_CODE, UNBOUND_CODE
from ...engine.jit import jit
from .coordinates import ACTION, D0, RADIUS, S1, S2, SINE, WIDTH, complement, radicands, set_place
from .librations import integrals
from .narrow import axis_ends, powers
from .wells import SMALL, turning_points

GRID = 224
"""Number of ratios rho = 1.3^(-112...111) at which the bottom of an effective potential is searched."""

STEP = 1.3
"""Quotient of neighbouring ratios."""


@jit
def _effective(coordinate, n, work):
    """v = U - u2/t - u3/s at the first n places, to work[2]: the constant u0 of a body at rest there."""
    term = coordinate.term
    u = coordinate.u
    term.function(term.params, n, work[0], work[2])
    for k in range(n):
        s = work[0, k]
        t = work[1, k]
        work[2, k] -= u[1] * t + (u[2] / t if u[2] != 0.0 else 0.0) + (u[3] / s if u[3] != 0.0 else 0.0)


@jit
def _bottom(coordinate, start, work):
    """Lowest point of v, or the bottom downhill of the ratio `start` > 0: (rho, v there, number of wells)."""
    kind = coordinate.kind
    for k in range(GRID):
        set_place(kind, STEP ** (k - GRID // 2), k, work)
    _effective(coordinate, GRID, work)
    v = work[2]
    wells = 0
    best = 0
    for k in range(GRID):
        if not np.isfinite(v[k]):
            v[k] = np.inf
    # A well has a rim on both sides, higher than rounding errors; s = 0 and t = 0 are rims, infinity is not.
    low = v[0]
    high = v[0]
    falling = True
    for k in range(1, GRID):
        rim = 1e-9 * (abs(low) + abs(v[k])) if np.isfinite(v[k]) else 0.0
        if falling:
            if v[k] < low or not np.isfinite(low):
                low = v[k]
            elif v[k] > low + rim:
                wells += 1
                falling = False
                high = v[k]
        elif v[k] > high:
            high = v[k]
        elif v[k] < high - 1e-9 * (abs(high) if np.isfinite(high) else 0.0):
            falling = True
            low = v[k]
    if falling and kind == SINE:
        wells += 1
    for k in range(GRID):
        if v[k] < v[best] and not (k == GRID - 1 and kind != SINE):
            best = k
    if start > 0.0:
        best = min(GRID - 1, max(0, int(np.round(np.log(start) / np.log(STEP))) + GRID // 2))
        while best > 0 and v[best - 1] < v[best]:
            best -= 1
        while best < GRID - 1 and v[best + 1] < v[best]:
            best += 1
    if best == 0:
        return STEP ** (-GRID // 2), v[0], wells
    low = STEP ** (best - 1.0 - GRID // 2)
    high = STEP ** (best + 1.0 - GRID // 2)
    for _ in range(12):
        for k in range(16):
            set_place(kind, low + (high - low) * (k + 0.5) / 16, k, work)
        _effective(coordinate, 16, work)
        best = 0
        for k in range(16):
            if work[2, k] < work[2, best]:
                best = k
        middle = low + (high - low) * (best + 0.5) / 16
        step = (high - low) / 16
        low = max(low, middle - step)
        high = min(high, middle + step)
        if step < 1e-8 * middle:
            break
    set_place(kind, middle, 0, work)
    _effective(coordinate, 1, work)
    return middle, work[2, 0], wells


@jit
def _loop(coordinate, rho, goal, work, out):
    """Turning points and loop integrals of the motion through the ratio rho; returns a status."""
    set_place(coordinate.kind, rho, 0, work)
    s = work[0, 0]
    t = work[1, 0]
    radicands(coordinate, 1, work[0], work[1], work[2])
    root = np.sqrt(max(0.0, work[2, 0]))
    code = turning_points(coordinate, s, t, root, 0.0, work, out)
    return integrals(coordinate, goal, work, out) if code == OK_CODE else code


@jit
def _match_at_axis(coordinate, side, J, room, bottom, work, out):
    """Find the small libration of action J about an axis s = 0 or t = 0, from its size instead of its energy; return
    True where there is one.
    """
    mu = coordinate.mu
    kind = coordinate.kind
    u = coordinate.u
    ends = coordinate.ends
    u[0] = bottom
    edge = -1.0 if side == 0 else 1.0
    out[RADIUS] = 0.0
    Lambda2 = max(0.0, 2 * mu * (ends[side] - u[3 - side]))
    middle = 0.0
    G = 0.0
    for step in range(12):
        width = 0.0
        if step > 0:
            width = np.sqrt(max(0.0, middle * middle - Lambda2 / G))
        elif Lambda2 > 0.0:
            middle = 1e-3 * min(SMALL, room)  # anywhere in the well: only G is used
        if not axis_ends(coordinate, side, middle, np.sqrt(G) * width, 0.0, work, out) and step > 0:
            return False
        G = -powers(work[3], edge, 0) / (out[RADIUS] * out[RADIUS]) if out[RADIUS] > 0.0 else 0.0
        if not G > 0.0:
            return False
        error = J
        if step > 0:
            if integrals(coordinate, 1e-8, work, out) != OK_CODE:
                return False
            error -= out[ACTION]
        else:
            middle = np.sqrt(Lambda2 / G)
        middle += error / (np.pi * np.sqrt(G))
        work[0, 0], work[1, 0] = (middle, complement(kind, middle)) if side == 0 else (1 - middle, middle)
        _effective(coordinate, 1, work)
        u[0] = (
            work[2, 0] + (G * middle * middle - Lambda2) / (2 * mu * work[0, 0] * work[1, 0])
            if middle > 0.0
            else bottom
        )
        if step > 0 and abs(error) <= 1e-15 * J:
            break
    return integrals(coordinate, 1e-14, work, out) == OK_CODE


@jit
def _rise(coordinate, rho, lowest, work):
    """Rise of v around the bottom at rho, at the first ratio where it is larger than rounding."""
    rise = 0.0
    factor = 1.15
    while rise <= 1e-6 * abs(lowest) and factor < 1e12:
        set_place(coordinate.kind, rho * factor, 0, work)
        set_place(coordinate.kind, rho / factor, 1, work)
        _effective(coordinate, 2, work)
        for k in range(2):
            if np.isfinite(work[2, k]):
                rise = max(rise, work[2, k] - lowest)
        factor *= factor
    return rise


@jit
def match_action(coordinate, J, start, work, out):
    """Find u0 of the action J >= 0 by Newton's method between bounds: (status, wells)."""
    mu = coordinate.mu
    kind = coordinate.kind
    u = coordinate.u
    ends = coordinate.ends
    rho, lowest, wells = _bottom(coordinate, start, work)
    if not np.isfinite(lowest):
        return UNBOUND_CODE, wells
    set_place(kind, rho, 0, work)
    s = work[0, 0]
    t = work[1, 0]
    smooth = coordinate.term.knots.size == 0
    if smooth and s < SMALL and np.isfinite(ends[0]) and _match_at_axis(coordinate, 0, J, s, lowest, work, out):
        return OK_CODE, wells
    if smooth and kind == SINE and t < SMALL and _match_at_axis(coordinate, 1, J, t, lowest, work, out):
        return OK_CODE, wells
    low = lowest
    high = np.inf
    u[0] = lowest + (0.1 * _rise(coordinate, rho, lowest, work) if J > 0.0 else 0.0)
    code = OK_CODE
    tries = 0
    rim = 0.0
    for _ in range(200):
        code = _loop(coordinate, rho, 1e-8, work, out)
        if code == UNBOUND_CODE:
            high = u[0]
            u[0] = 0.5 * (low + high)
            if high - low <= 1e-15 * max(abs(low), abs(high)):
                return code, wells
            continue
        if code != OK_CODE:  # at the rim of a well, or next to a wall: try both sides, farther and farther away
            if tries == 0:
                rim = u[0]
            tries += 1
            aside = (rim - low) * 1e-7 * 4.0 ** (tries // 2)
            u[0] = rim - aside if tries % 2 == 1 else min(rim + aside, 0.5 * (rim + high) if high < np.inf else np.inf)
            if tries > 24:
                return code, wells
            continue
        tries = 0
        gap = J - out[ACTION]
        if gap > 0.0:
            low = max(low, u[0])
        else:
            high = min(high, u[0])
        change = gap / out[D0]
        if abs(change) <= 2e-16 * abs(u[0]) or abs(gap) <= 2e-16 * J or J == 0.0:
            break
        following = u[0] + change
        u[0] = following if low < following < high else (0.5 * (low + high) if high < np.inf else following)
        if high - low <= 2e-16 * abs(low):
            break
    code = _loop(coordinate, rho, 1e-14, work, out)
    if code == OK_CODE and J == 0.0 and out[RADIUS] > 0.0:
        out[S1] = out[S2] = 0.5 * (out[S1] + out[S2])
        out[WIDTH] = 0.0
        out[ACTION] = 0.0
    if code == OK_CODE and abs(J - out[ACTION]) > 1e-9 * J + 1e-13 * np.pi * np.sqrt(2 * mu * abs(u[3])) + 1e-14:
        code = UNBOUND_CODE  # the action jumps over J where wells join
    return code, wells
