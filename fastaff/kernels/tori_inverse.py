"""From actions and angles to phase points of a separable, doubly isotropic body.

In the alpha-beta and r-vartheta charts each coordinate has a constant of its own (u0), whose action it increases with,
once the others are known: two one-dimensional Newton searches from the bottom of the effective potential. The angles
follow in the order in which the partial integrals depend on the phases.
"""

from typing import NamedTuple

import numpy as np

from ..base.status import NOT_CONVERGED_CODE, OK_CODE, UNBOUND_CODE
from ..compile.jit import jit
from .panels import turned_integral
from .tori_librations import D0_ROW, LEAST, MOST, ROWS, TABLES, integrals, inverse_root, limits, partials
from .tori_quadrature import ALPHA_BETA, ENERGY, KINDS, UNIT, coefficients, derivatives, solve_transposed
from .tori_wells import (
    ACTION,
    CHI,
    D0,
    D2,
    D3,
    ERROR,
    NODES,
    PANELS,
    RADIUS,
    RESULTS,
    S1,
    S2,
    SINE,
    SMALL,
    T2,
    W2,
    W3,
    WIDTH,
    Coordinate,
    axis_ends,
    complement,
    powers,
    radicands,
    set_place,
    turning_points,
)

GRID, STEP = 224, 1.3
"""Ratios rho = 1.3^(-112...111) at which the bottom of an effective potential is looked for."""

MINUTE = 1e-20
"""What an angular momentum of 0 is replaced by: the limit from above."""


@jit
def _effective(coordinate, n, work):
    """v = U - u2/t - u3/s at the first n places, to work[2]: the own constant u0 of a body at rest there."""
    term, u = coordinate.term, coordinate.u
    term.function(term.params, n, work[0], work[2])
    for k in range(n):
        s, t = work[0, k], work[1, k]
        work[2, k] -= u[1] * t + (u[2] / t if u[2] != 0.0 else 0.0) + (u[3] / s if u[3] != 0.0 else 0.0)


@jit
def _bottom(coordinate, start, work):
    """Lowest point of v, or the bottom downhill of the ratio `start` > 0: (rho, v there, number of wells)."""
    kind = coordinate.kind
    for k in range(GRID):
        set_place(kind, STEP ** (k - GRID // 2), k, work)
    _effective(coordinate, GRID, work)
    v, wells, best = work[2], 0, 0
    for k in range(GRID):
        if not np.isfinite(v[k]):
            v[k] = np.inf
    # A well has a rim on both sides that stands out of rounding; s = 0 and t = 0 are rims, infinity is not.
    low, high, falling = v[0], v[0], True
    for k in range(1, GRID):
        rim = 1e-9 * (abs(low) + abs(v[k])) if np.isfinite(v[k]) else 0.0
        if falling:
            if v[k] < low or not np.isfinite(low):
                low = v[k]
            elif v[k] > low + rim:
                wells += 1
                falling, high = False, v[k]
        elif v[k] > high:
            high = v[k]
        elif v[k] < high - 1e-9 * (abs(high) if np.isfinite(high) else 0.0):
            falling, low = True, v[k]
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
    low, high = STEP ** (best - 1.0 - GRID // 2), STEP ** (best + 1.0 - GRID // 2)
    for _ in range(12):
        for k in range(16):
            set_place(kind, low + (high - low) * (k + 0.5) / 16, k, work)
        _effective(coordinate, 16, work)
        best = 0
        for k in range(16):
            if work[2, k] < work[2, best]:
                best = k
        middle, step = low + (high - low) * (best + 0.5) / 16, (high - low) / 16
        low, high = max(low, middle - step), min(high, middle + step)
        if step < 1e-8 * middle:
            break
    set_place(kind, middle, 0, work)
    _effective(coordinate, 1, work)
    return middle, work[2, 0], wells


@jit
def _loop(coordinate, rho, goal, work, out):
    """Turning points and loop integrals of the motion through the ratio rho; returns a status."""
    set_place(coordinate.kind, rho, 0, work)
    s, t = work[0, 0], work[1, 0]
    radicands(coordinate, 1, work[0], work[1], work[2])
    root = np.sqrt(max(0.0, work[2, 0]))
    code = turning_points(coordinate, s, t, root, 0.0, work, out)
    return integrals(coordinate, goal, work, out) if code == OK_CODE else code


@jit
def _match_at_axis(coordinate, side, J, room, bottom, work, out):
    """Find the small libration of action J about an axis s = 0 or t = 0, from its size instead of its energy: True
    where it is one.
    """
    mu, kind, u, ends = coordinate.mu, coordinate.kind, coordinate.u, coordinate.ends
    u[0], edge = bottom, -1.0 if side == 0 else 1.0
    out[RADIUS] = 0.0
    Lambda2 = max(0.0, 2 * mu * (ends[side] - u[3 - side]))
    middle, G = 0.0, 0.0
    for step in range(12):
        width = 0.0
        if step > 0:
            width = np.sqrt(max(0.0, middle * middle - Lambda2 / G))
        elif Lambda2 > 0.0:
            middle = 1e-3 * min(SMALL, room)  # anywhere in the well: only G is wanted
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
def _match(coordinate, J, start, work, out):
    """Find u0 of the action J >= 0 by Newton's method between bounds: (status, wells)."""
    mu, kind, u, ends = coordinate.mu, coordinate.kind, coordinate.u, coordinate.ends
    rho, lowest, wells = _bottom(coordinate, start, work)
    if not np.isfinite(lowest):
        return UNBOUND_CODE, wells
    set_place(kind, rho, 0, work)
    s, t = work[0, 0], work[1, 0]
    smooth = coordinate.term.knots.size == 0
    if smooth and s < SMALL and np.isfinite(ends[0]) and _match_at_axis(coordinate, 0, J, s, lowest, work, out):
        return OK_CODE, wells
    if smooth and kind == SINE and t < SMALL and _match_at_axis(coordinate, 1, J, t, lowest, work, out):
        return OK_CODE, wells
    rise, factor = 0.0, 1.15
    while rise <= 1e-6 * abs(lowest) and factor < 1e12:
        set_place(kind, rho * factor, 0, work)
        set_place(kind, rho / factor, 1, work)
        _effective(coordinate, 2, work)
        for k in range(2):
            if np.isfinite(work[2, k]):
                rise = max(rise, work[2, k] - lowest)
        factor *= factor
    low, high = lowest, np.inf
    u[0] = lowest + (0.1 * rise if J > 0.0 else 0.0)
    code, tries, rim = OK_CODE, 0, 0.0
    for _ in range(200):
        code = _loop(coordinate, rho, 1e-8, work, out)
        if code == UNBOUND_CODE:
            high = u[0]
            u[0] = 0.5 * (low + high)
            if high - low <= 1e-15 * max(abs(low), abs(high)):
                return code, wells
            continue
        if code != OK_CODE:  # at the rim of a well, or next to a wall: try both sides, further and further off
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
        out[WIDTH], out[ACTION] = 0.0, 0.0
    if code == OK_CODE and abs(J - out[ACTION]) > 1e-9 * J + 1e-13 * np.pi * np.sqrt(2 * mu * abs(u[3])) + 1e-14:
        code = UNBOUND_CODE  # the action jumps over J where wells join
    return code, wells


@jit
def _find_in_panels(mu, target, work, out):
    """The same from panels, by Newton's method between bounds."""
    low, high, chi = 0.0, 2 * np.pi, 2 * np.pi * target / out[D0]
    for _ in range(60):
        gap = target - 0.5 * mu * turned_integral(D0_ROW, chi, work, out)
        if gap > 0.0:
            low = chi
        else:
            high = chi
        change = gap / (0.5 * mu * inverse_root(chi, work, out))
        chi = chi + change if low <= chi + change <= high else 0.5 * (low + high)
        if abs(change) < 1e-15 * (1 + chi):
            break
    out[CHI] = chi


@jit
def _find_phase(mu, target, work, out):
    """Set chi of the state whose W0 is `target`, which is brought into [0, D0); returns the turns taken off."""
    nodes = int(out[NODES])
    off, turns = nodes - LEAST, np.floor(target / out[D0])
    target -= turns * out[D0]
    if out[PANELS] > 0.0:
        _find_in_panels(mu, target, work, out)
        return turns
    f, last, now, a = work[6], work[10], work[11], work[2]
    for k in range(nodes):
        last[k], now[k] = 1.0, TABLES[2, off + k]
    mean = 0.0
    for k in range(nodes):
        mean += f[k]
    mean /= nodes
    for n in range(1, nodes):
        total = 0.0
        for k in range(nodes):
            total += f[k] * now[k]
            following = 2 * TABLES[2, off + k] * now[k] - last[k]
            last[k] = now[k]
            now[k] = following
        a[n] = 2 * total / nodes
    low, high, chi = 0.0, 2 * np.pi, 2 * np.pi * target / out[D0]
    for _ in range(60):
        value, slope, sine, sine_last, turn, cosine, cosine_last = (
            mean * chi,
            mean,
            np.sin(chi),
            0.0,
            2 * np.cos(chi),
            np.cos(chi),
            1.0,
        )
        for n in range(1, nodes):
            value += a[n] * sine / n
            slope += a[n] * cosine
            sine, sine_last = turn * sine - sine_last, sine
            cosine, cosine_last = turn * cosine - cosine_last, cosine
        gap = target - 0.5 * mu * value
        if gap > 0.0:
            low = chi
        else:
            high = chi
        change = gap / (0.5 * mu * slope)
        chi = chi + change if low <= chi + change <= high else 0.5 * (low + high)
        if abs(change) < 1e-15 * (1 + chi):
            break
    out[CHI] = chi
    return turns


@jit
def _coordinate(kind, work, out, at):
    """s, t and root = sqrt(F) with its sign at the phase of `out`, to at (3,)."""
    chi = out[CHI]
    half = np.sin(chi / 2) ** 2
    at[0] = out[S1] + 2 * out[WIDTH] * half
    at[1] = out[T2] + 2 * out[WIDTH] * np.cos(chi / 2) ** 2 if kind == SINE else 1.0
    at[2] = out[WIDTH] * np.sin(chi) / inverse_root(chi, work, out)


@jit
def _write_plane(z, row, k, square, radial, spin, angle):
    """Write one plane: |x|^2, x.p, x cross p and arg x."""
    length, cosine, sine = np.sqrt(square), np.cos(angle), np.sin(angle)
    along, across = (radial / length, spin / length) if length > 0.0 else (0.0, 0.0)
    z[row, k], z[row + 1, k] = length * cosine, length * sine
    z[row + 4, k], z[row + 5, k] = along * cosine - across * sine, along * sine + across * cosine


class Sought(NamedTuple):
    """Tori of given actions: J (4, n), theta (4, n or 0) of points on them, start (2, n), ratios in the wells that are
    meant, or 0; to be found are the points z (8, n or 0), nu (4, n), energy, the number of wells, and status (n,).
    """

    J: np.ndarray
    theta: np.ndarray
    start: np.ndarray
    z: np.ndarray
    nu: np.ndarray
    energy: np.ndarray
    wells: np.ndarray
    status: np.ndarray


@jit
def _point(chart, first, second, tori, k, work, other, results, small):
    """One torus and, where theta has columns, the point on it; returns a status."""
    J, theta, start, z, nu, energy, wells, _ = tori
    mu, c, u, v = first.mu, small[0], first.u, second.u
    momenta, answer, M, N, at = small[3], small[4], small[5:7], small[7:9], small[9:11]
    for a in range(2):
        p = J[2 + a, k] / (2 * np.pi)
        momenta[a] = p if p != 0.0 else MINUTE
        c[2 + a] = momenta[a] * momenta[a] / (2 * mu)
    c[0], c[1] = 0.0, 0.0
    coefficients(chart, 1, c, v)
    code, count = _match(second, J[1, k], start[1, k], other, results[1])
    wells[k] = count
    if code != OK_CODE:
        return code
    c[1] = v[0]
    coefficients(chart, 0, c, u)
    code, count = _match(first, J[0, k], start[0, k], work, results[0])
    wells[k] = max(wells[k], count)
    if code != OK_CODE:
        return code
    c[0] = u[0]
    energy[k] = ENERGY[chart, 0] * c[0] + ENERGY[chart, 1] * c[1]
    derivatives(chart, mu, momenta, np.zeros(2, np.int64), results, M, N)
    solve_transposed(M, ENERGY[chart], answer)
    nu[0, k], nu[1, k] = answer[0], answer[1]
    for a in range(2):
        nu[2 + a, k] = -(answer[0] * N[0, a] + answer[1] * N[1, a]) / (2 * np.pi)
    if theta.shape[1] == 0:
        return code
    turns = np.zeros(2)
    turns[0] = _find_phase(mu, M[0, 0] * theta[0, k], work, results[0])
    _coordinate(first.kind, work, results[0], at[0])
    partials(first, work, results[0])
    target = M[1, 1] * theta[1, k]
    if chart != ALPHA_BETA:
        target += M[0, 1] * theta[0, k] + results[0, W3] + turns[0] * results[0, D3]
    turns[1] = _find_phase(mu, target, other, results[1])
    _coordinate(second.kind, other, results[1], at[1])
    partials(second, other, results[1])
    phases = small[11]
    for a in range(2):
        i, entry, partial = (a, D3, W3) if chart == ALPHA_BETA else (1, D2 if a == 0 else D3, W2 if a == 0 else W3)
        passed = results[i, partial] + turns[i] * results[i, entry]
        phases[a] = (
            2 * np.pi * theta[2 + a, k] + N[0, a] * theta[0, k] + N[1, a] * theta[1, k] + momenta[a] / mu * passed
        )
    if chart == ALPHA_BETA:
        A, B, pA, pB = at[0, 0], at[1, 0], at[0, 2], at[1, 2]
    else:
        r, s, t = at[0, 0], at[1, 0], at[1, 1]
        A, B = r * t, r * s
        pA, pB = t * at[0, 2] - at[1, 2], s * at[0, 2] + at[1, 2]
    _write_plane(z, 0, k, A, pA, J[2, k] / (2 * np.pi), phases[0])
    _write_plane(z, 2, k, B, pB, J[3, k] / (2 * np.pi), phases[1])
    return OK_CODE if results[0, ERROR] < 1e-7 and results[1, ERROR] < 1e-7 else NOT_CONVERGED_CODE


def torus_points(unit, stop, progress, chart, first, second, mu, tori):
    """Find tori, from the terms of the potential in both coordinates."""
    _, theta, _, z, nu, energy, _, status = tori
    if stop[0] != 0:
        return
    work, other = np.zeros((ROWS, MOST)), np.zeros((ROWS, MOST))
    results, small, ends = np.zeros((2, RESULTS)), np.zeros((12, 4)), np.zeros((2, 2))
    points = min(1, theta.shape[1])  # for each torus
    inner = Coordinate(first, mu, KINDS[chart, 0], small[1], ends[0])
    outer = Coordinate(second, mu, KINDS[chart, 1], small[2], ends[1])
    limits(inner, work)
    limits(outer, work)
    for k in range(unit * UNIT, min(status.size, (unit + 1) * UNIT)):
        results[:], small[:] = 0.0, 0.0  # nothing of the torus before it
        status[k] = _point(chart, inner, outer, tori, k, work, other, results, small)
        if status[k] == OK_CODE and not np.isfinite(energy[k] + nu[:, k].sum() + z[:, k : k + points].sum()):
            status[k] = NOT_CONVERGED_CODE
        if status[k] != OK_CODE:
            energy[k], nu[:, k], z[:, k : k + points] = np.nan, np.nan, np.nan
    progress[unit] = 1
