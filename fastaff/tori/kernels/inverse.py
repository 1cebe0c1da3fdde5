"""From actions and angles to phase points of a separable, doubly isotropic body.

In the alpha-beta and r-vartheta charts each coordinate has its own constant (u0); its action increases with that once
the others are known: two one-dimensional Newton searches from the bottom of the effective potential. The angles follow
in the order in which the partial integrals depend on the phases.
"""

from typing import NamedTuple

import numpy as np

from ...core.status import NOT_CONVERGED_CODE, OK_CODE
from ...engine.jit import jit
from .actions import match_action
from .coordinates import CHI, D0, D2, D3, ERROR, NODES, PANELS, RESULTS, S1, SINE, T2, W2, W3, WIDTH, Coordinate
from .librations import D0_ROW, LEAST, MOST, ROWS, TABLES, limits
from .panels import turned_integral
from .phases import inverse_root, partials
from .quadrature import ALPHA_BETA, ENERGY, KINDS, UNIT, coefficients, derivatives, solve_transposed

MINUTE = 1e-20
"""Substitute for an angular momentum of 0: the limit from above."""


@jit
def _find_in_panels(mu, target, work, out):
    """The same from panels, by Newton's method between bounds."""
    low = 0.0
    high = 2 * np.pi
    chi = 2 * np.pi * target / out[D0]
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
    """Set chi of the state whose W0 is `target`, reduced to [0, D0); returns the turns subtracted."""
    nodes = int(out[NODES])
    off = nodes - LEAST
    turns = np.floor(target / out[D0])
    target -= turns * out[D0]
    if out[PANELS] > 0.0:
        _find_in_panels(mu, target, work, out)
        return turns
    f = work[6]
    last = work[10]
    now = work[11]
    a = work[2]
    for k in range(nodes):
        last[k] = 1.0
        now[k] = TABLES[2, off + k]
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
    low = 0.0
    high = 2 * np.pi
    chi = 2 * np.pi * target / out[D0]
    for _ in range(60):
        value = mean * chi
        slope = mean
        sine = np.sin(chi)
        sine_last = 0.0
        turn = 2 * np.cos(chi)
        cosine = np.cos(chi)
        cosine_last = 1.0
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
    length = np.sqrt(square)
    cosine = np.cos(angle)
    sine = np.sin(angle)
    along, across = (radial / length, spin / length) if length > 0.0 else (0.0, 0.0)
    z[row, k] = length * cosine
    z[row + 1, k] = length * sine
    z[row + 4, k] = along * cosine - across * sine
    z[row + 5, k] = along * sine + across * cosine


class Sought(NamedTuple):
    """Tori of given actions: J (4, n), theta (4, n or 0) of points on them, start (2, n), ratios in the intended wells,
    or 0; results: the points z (8, n or 0), nu (4, n), energy, the number of wells, and status (n,).
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
    mu = second.mu
    c = small[0]
    u = first.u
    v = second.u
    momenta = small[3]
    answer = small[4]
    M = small[5:7]
    N = small[7:9]
    at = small[9:11]
    for a in range(2):
        p = J[2 + a, k] / (2 * np.pi)
        momenta[a] = p if p != 0.0 else MINUTE
        c[2 + a] = momenta[a] * momenta[a] / (2 * mu)
    c[0] = 0.0
    c[1] = 0.0
    coefficients(chart, 1, c, v)
    code, count = match_action(second, J[1, k], start[1, k], other, results[1])
    wells[k] = count
    if code != OK_CODE:
        return code
    c[1] = v[0]
    coefficients(chart, 0, c, u)
    code, count = match_action(first, J[0, k], start[0, k], work, results[0])
    wells[k] = max(wells[k], count)
    if code != OK_CODE:
        return code
    c[0] = u[0]
    energy[k] = ENERGY[chart, 0] * c[0] + ENERGY[chart, 1] * c[1]
    derivatives(chart, mu, momenta, np.zeros(2, np.int64), results, M, N)
    solve_transposed(M, ENERGY[chart], answer)
    nu[0, k] = answer[0]
    nu[1, k] = answer[1]
    for a in range(2):
        nu[2 + a, k] = -(answer[0] * N[0, a] + answer[1] * N[1, a]) / (2 * np.pi)
    if theta.shape[1] == 0:
        return code
    turns = np.zeros(2)
    turns[0] = _find_phase(first.mu, M[0, 0] * theta[0, k], work, results[0])
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
        A = at[0, 0]
        B = at[1, 0]
        pA = at[0, 2]
        pB = at[1, 2]
    else:
        r = at[0, 0]
        s = at[1, 0]
        t = at[1, 1]
        A = r * t
        B = r * s
        pA = t * at[0, 2] - at[1, 2]
        pB = s * at[0, 2] + at[1, 2]
    _write_plane(z, 0, k, A, pA, J[2, k] / (2 * np.pi), phases[0])
    _write_plane(z, 2, k, B, pB, J[3, k] / (2 * np.pi), phases[1])
    return OK_CODE if results[0, ERROR] < 1e-7 and results[1, ERROR] < 1e-7 else NOT_CONVERGED_CODE


def torus_points(unit, stop, progress, chart, first, second, mu, radial_mu, tori):
    """Find tori, from the terms of the potential in both coordinates."""
    _, theta, _, z, nu, energy, _, status = tori
    if stop[0] != 0:
        return
    work = np.zeros((ROWS, MOST))
    other = np.zeros((ROWS, MOST))
    results = np.zeros((2, RESULTS))
    small = np.zeros((12, 4))
    ends = np.zeros((2, 2))
    points = min(1, theta.shape[1])  # for each torus
    inner = Coordinate(first, radial_mu, KINDS[chart, 0], small[1], ends[0])
    outer = Coordinate(second, mu, KINDS[chart, 1], small[2], ends[1])
    limits(inner, work)
    limits(outer, work)
    for k in range(unit * UNIT, min(status.size, (unit + 1) * UNIT)):
        # clear the numbers of the torus before
        results[:] = 0.0
        small[:] = 0.0
        status[k] = _point(chart, inner, outer, tori, k, work, other, results, small)
        if status[k] == OK_CODE and not np.isfinite(energy[k] + nu[:, k].sum() + z[:, k : k + points].sum()):
            status[k] = NOT_CONVERGED_CODE
        if status[k] != OK_CODE:
            energy[k] = np.nan
            nu[:, k] = np.nan
            z[:, k : k + points] = np.nan
    progress[unit] = 1
