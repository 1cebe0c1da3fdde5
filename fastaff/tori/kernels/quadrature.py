"""Actions, frequencies and angles of many states of a separable body by quadrature.

Constants c = (c0, c1, c_eta, c_gamma): two of the chart and the squares of the angular momenta over 2 mu with the
angular potentials, c_eta = p_eta^2/(2 mu) + V_eta. Coordinate i has the coefficients u = LINKS[chart, i] c of
`tori_wells`, so dJ_i/dc = LINKS^T (D0...D3), dE = dc0 (+ dc1 in the alpha-beta chart), and nu = dE/dJ, theta =
(dJ/dc)^-T (partial integrals).
"""

from typing import NamedTuple

import numpy as np

from ...core.status import ACTION_ZERO_CODE, NOT_CONVERGED_CODE, OK_CODE, SEPARATRIX_CODE
from ...engine.jit import jit
from .coordinates import ACTION, D0, ERROR, LINE, RADIAL, RESULTS, S1, S2, SINE, SINH, T2, W0, WIDTH, Coordinate
from .librations import MOST, ROWS, limits
from .phases import librate

ALPHA_BETA = 0
R_VARTHETA = 1
ELLIPTIC = 2
KINDS = np.array([[RADIAL, RADIAL], [RADIAL, SINE], [SINH, SINE]])
UNIT = 64
"""States that a thread takes at once."""

LEAST_TURN = 64
"""Least number of nodes over a turn of an angle that has a potential, in the search for barriers."""


def _links():
    """Return du_k/dc_j (chart, coordinate, k, j)."""
    links = np.zeros((3, 2, 4, 4))
    links[0, 0, 0, 0] = 1
    links[0, 0, 3, 2] = -1
    links[0, 1, 0, 1] = 1
    links[0, 1, 3, 3] = -1
    links[1, 0, 0, 0] = 1
    links[1, 0, 3, 1] = -1
    links[1, 1, 0, 1] = 1
    links[1, 1, 2, 2] = -1
    links[1, 1, 3, 3] = -1
    links[2, 0, 1, 0] = 2
    links[2, 0, 0, 1] = -2
    links[2, 0, 2, 2] = 1
    links[2, 0, 3, 3] = -1
    links[2, 1, 0, 1] = 2
    links[2, 1, 1, 0] = -2
    links[2, 1, 2, 2] = -1
    links[2, 1, 3, 3] = -1
    return links


LINKS = _links()
ENERGY = np.array([[1.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
"""dE/dc0, dE/dc1 of each chart."""


@jit
def place(chart, z, k, where):
    """Write s, t, root = sqrt(F) with its sign, and dF/ds (or dF/dt) on the axis, of both coordinates of state k to
    where (2, 4).
    """
    T_a = z[4, k] * z[4, k] + z[5, k] * z[5, k]
    T_b = z[6, k] * z[6, k] + z[7, k] * z[7, k]
    A = z[0, k] * z[0, k] + z[1, k] * z[1, k]
    B = z[2, k] * z[2, k] + z[3, k] * z[3, k]
    pA = z[0, k] * z[4, k] + z[1, k] * z[5, k]
    pB = z[2, k] * z[6, k] + z[3, k] * z[7, k]
    r = A + B
    if chart == ALPHA_BETA:
        where[0, 0] = A
        where[0, 1] = 1.0
        where[0, 2] = pA
        where[1, 0] = B
        where[1, 1] = 1.0
        where[1, 2] = pB
        where[0, 3] = T_a
        where[1, 3] = T_b
    elif chart == R_VARTHETA:
        where[0, 0] = r
        where[0, 1] = 1.0
        where[0, 2] = pA + pB
        where[1, 0] = B / r
        where[1, 1] = A / r
        where[1, 2] = (A * pB - B * pA) / r
        where[0, 3] = 0.0
        where[1, 3] = r * (T_b if B <= A else T_a)
    else:
        sigma = r / 2 - 1
        root = np.sqrt(sigma * sigma + 2 * B)
        large = (abs(sigma) + root) / 2
        small = B / (2 * large) if large > 0.0 else 0.0
        s = large if sigma >= 0 else small
        t = small if sigma >= 0 else large
        where[0, 0] = s
        where[0, 1] = 1 + s
        where[0, 2] = s * pA + (1 + s) * pB
        where[1, 0] = t
        where[1, 1] = A / (2 * (1 + s))
        where[1, 2] = -t * pA + A / (2 * (1 + s)) * pB
        # On the axis beta = 0 one of the two is 0: p^2 s t/s there.
        where[0, 3] = 2 * (1 - t) * T_b
        where[1, 3] = 2 * (1 + s) * (T_b if B <= A else T_a)


@jit
def separate(chart, mu, radial_mu, z, k, where, U, V, c):
    """Write the constants c (4,) of state k; U (2,) are the coordinates' potentials, V (2,) those of eta and gamma."""
    A = z[0, k] * z[0, k] + z[1, k] * z[1, k]
    B = z[2, k] * z[2, k] + z[3, k] * z[3, k]
    p_eta = z[0, k] * z[5, k] - z[1, k] * z[4, k]
    p_gamma = z[2, k] * z[7, k] - z[3, k] * z[6, k]
    T_a = (z[4, k] * z[4, k] + z[5, k] * z[5, k]) / (2 * mu)
    T_b = (z[6, k] * z[6, k] + z[7, k] * z[7, k]) / (2 * mu)
    wall_a = V[0] / A if V[0] != 0.0 else 0.0
    wall_b = V[1] / B if V[1] != 0.0 else 0.0
    c[2] = p_eta * p_eta / (2 * mu) + V[0]
    c[3] = p_gamma * p_gamma / (2 * mu) + V[1]
    if chart == ALPHA_BETA:
        c[0] = T_a + U[0] + wall_a
        c[1] = T_b + U[1] + wall_b
        return
    square = 0.0
    for i in range(4):
        for j in range(i):
            turn = z[i, k] * z[4 + j, k] - z[j, k] * z[4 + i, k]
            square += turn * turn
    h = square / (2 * mu)
    if chart == R_VARTHETA:
        r = where[0, 0]
        c[1] = h + U[1] + r * wall_a + r * wall_b
        c[0] = T_a + T_b + U[0] + (U[1] + r * wall_a + r * wall_b) / r
        c[0] -= (0.5 / mu - 0.5 / radial_mu) * where[0, 2] * where[0, 2] / r
    else:
        s = where[0, 0]
        t = where[1, 0]
        t_c = where[1, 1]
        width = s + t
        c[0] = T_a + T_b + (U[0] + U[1]) / (2 * width) + wall_a + wall_b
        c[1] = T_a + h / 2 + (U[0] * t_c + U[1] * (1 + s)) / (2 * width)
        c[1] += V[0] * (2 + s - t) / (2 * (1 + s) * t_c) if V[0] != 0.0 else 0.0
        c[1] += V[1] * (1 + s - t) / (2 * s * t) if V[1] != 0.0 else 0.0


@jit
def coefficients(chart, i, c, u):
    """Write the coefficients u (4,) of coordinate i."""
    for row in range(4):
        u[row] = 0.0
        for j in range(4):
            u[row] += LINKS[chart, i, row, j] * c[j]


@jit
def _harmonics(nodes, work):
    """Write cosine and sine coefficients of the slopes in work[1] to work[2:4]; returns the relative size of the last
    two.
    """
    cosine = work[4]
    sine = work[5]
    for k in range(nodes):
        cosine[k] = 1.0
        sine[k] = 0.0
    for n in range(nodes // 2):
        a = 0.0
        b = 0.0
        for k in range(nodes):
            a += work[1, k] * cosine[k]
            b += work[1, k] * sine[k]
        work[2, n] = 2 * a / nodes
        work[3, n] = 2 * b / nodes
        for k in range(nodes):
            c, s = work[6, k], work[7, k]
            cosine[k], sine[k] = cosine[k] * c - sine[k] * s, sine[k] * c + cosine[k] * s
    last = nodes // 2 - 1
    tail = abs(work[2, last]) + abs(work[3, last]) + abs(work[2, last - 1]) + abs(work[3, last - 1])
    return tail / work[2, 0]


@jit
def _turn(angle, c, at, momentum, work, out):
    """A rotating angle: J, D0 = dJ/dc and W0 to the state; returns a status, or -1 where it does not rotate."""
    potential, params, knots = angle.term
    mu = angle.mu
    nodes = LEAST_TURN
    for k in range(knots.size):
        # narrow features take all nodes
        work[0, 0] = knots[k]
        nodes = MOST
        potential(params, 1, work[0], work[1])
        if not work[1, 0] < c:
            return -1
    while True:
        for k in range(nodes):
            work[0, k] = (k + 0.5) * 2 * np.pi / nodes
            work[6, k] = np.cos(work[0, k])
            work[7, k] = np.sin(work[0, k])
        potential(params, nodes, work[0], work[1])
        action = 0.0
        for k in range(nodes):
            if not work[1, k] < c:
                return -1
            p = np.sqrt(2 * mu * (c - work[1, k]))
            action += p
            work[1, k] = mu / p
        tail = _harmonics(nodes, work)
        if tail < 1e-14 or nodes == MOST:
            break
        nodes *= 2
    last_cosine = 1.0
    last_sine = 0.0
    total = 0.5 * work[2, 0] * at
    for n in range(1, nodes // 2):
        last_cosine, last_sine = (
            last_cosine * np.cos(at) - last_sine * np.sin(at),
            last_sine * np.cos(at) + last_cosine * np.sin(at),
        )
        total += (work[2, n] * last_sine + work[3, n] * (1 - last_cosine)) / n
    sign = 1.0 if momentum >= 0.0 else -1.0
    out[ACTION] = sign * 2 * np.pi / nodes * action
    out[D0] = sign * np.pi * work[2, 0]
    out[W0] = sign * total
    out[WIDTH] = 1.0
    out[ERROR] = tail
    return OK_CODE if tail < 1e-7 else NOT_CONVERGED_CODE


@jit
def _angle(angle, c, at, momentum, work, out):
    """An angle that rotates or librates in its potential: J, D0 = dJ/dc and W0 to the state; returns a status."""
    code = _turn(angle, c, at, momentum, work, out)
    if code >= 0:
        return code
    angle.u[0] = c
    return librate(angle, at, 1.0, momentum, 0.0, 1e-14, work, out)


@jit
def solve_transposed(M, right, answer):
    """Solve the 2 x 2 system M^T x = right."""
    determinant = M[0, 0] * M[1, 1] - M[0, 1] * M[1, 0]
    answer[0] = (right[0] * M[1, 1] - M[1, 0] * right[1]) / determinant
    answer[1] = (M[0, 0] * right[1] - M[0, 1] * right[0]) / determinant


@jit
def derivatives(chart, mu, momenta, angular, results, M, N):
    """Write M = dJ_i/dc_j (i, j of the coordinates) and N = dJ_i/d(p_eta, p_gamma), or d(c_eta, c_gamma) where
    `angular`.
    """
    for i in range(2):
        for j in range(4):
            total = 0.0
            for k in range(4):
                if LINKS[chart, i, k, j] != 0.0:
                    total += LINKS[chart, i, k, j] * results[i, D0 + k]
            if j < 2:
                M[i, j] = total
            elif angular[j - 2]:
                N[i, j - 2] = total
            else:
                p = momenta[j - 2]
                # On the axis with p = 0 the derivative jumps from +pi to -pi: it has no value.
                N[i, j - 2] = p / mu * total if np.isfinite(total) else np.nan


class Scratch(NamedTuple):
    """Memory for one state after another: rows of work; s, t, root and slope of both coordinates; vectors of four
    numbers, the constants c and the coefficients u first; results of both coordinates and of an angle.
    """

    work: np.ndarray
    where: np.ndarray
    small: np.ndarray
    results: np.ndarray


@jit
def _place_angles(angles, angular, z, k, at, momenta, V, work):
    """Write the angles eta and gamma of state k, their momenta, and V (2,): their potentials, 0 where there is none."""
    for a in range(2):
        i = 2 * a
        j = 2 * a + 1
        at[a] = (
            np.arctan2(z[j, k], z[i, k]) if z[j, k] != 0.0 or z[i, k] != 0.0 else np.arctan2(z[4 + j, k], z[4 + i, k])
        )
        momenta[a] = z[i, k] * z[4 + j, k] - z[j, k] * z[4 + i, k]
        V[a] = 0.0
        if angular[a]:
            term = angles[a].term
            term.function(term.params, 1, at[a:], work[2])
            V[a] = work[2, 0]


@jit
def _inner(chart, j, row, results):
    """Return the sum over both coordinates of dS/dc_j to the phase of the state, for the coefficients from `row` on."""
    total = 0.0
    for i in range(2):
        for u in range(row, 4):
            if LINKS[chart, i, u, j] != 0.0:
                total += LINKS[chart, i, u, j] * results[i, W0 + u]
    return total


@jit
def _settle(tori, k, results, still, code):
    """Reduce the angles theta of state k to [0, 1), NaN where an action vanishes; return the status."""
    _, J, nu, theta, _, _, _, _ = tori
    for i in range(2):
        if results[i, WIDTH] <= 0.0:
            theta[i, k] = np.nan
            code = ACTION_ZERO_CODE if code == OK_CODE else code
    for a in range(2):
        if still[a] == 1.0:
            theta[2 + a, k] = np.nan
            J[2 + a, k] = 0.0
            nu[2 + a, k] = nu[2 + a, k] if np.isfinite(nu[2 + a, k]) else np.nan
            code = ACTION_ZERO_CODE if code == OK_CODE else code
    for i in range(4):
        theta[i, k] -= np.floor(theta[i, k])
        if theta[i, k] >= 1.0:
            theta[i, k] = 0.0
    return code


@jit
def _state(chart, coordinates, angles, angular, tori, k, scratch):
    """All of one state; returns its status. J, nu, theta have rows of the two coordinates, eta, gamma."""
    work, where, small, results = scratch
    z, J, nu, theta, turning, constants, error, _ = tori
    mu = coordinates[1].mu
    place(chart, z, k, where)
    c = small[0]
    u = small[1]
    U = small[2]
    V = small[3]
    at = small[4]
    momenta = small[5]
    pair = small[6]
    answer = small[7]
    turn = small[8]
    partial = small[9]
    M = small[10:12]
    N = small[12:14]
    still = small[14]
    for i in range(2):
        term = coordinates[i].term
        term.function(term.params, 1, where[i, :1], work[2])
        U[i] = work[2, 0]
    _place_angles(angles, angular, z, k, at, momenta, V, work)
    separate(chart, mu, coordinates[0].mu, z, k, where, U, V, c)
    for j in range(4):
        constants[j, k] = c[j]
    for i in range(2):
        coefficients(chart, i, c, u)
        code = librate(coordinates[i], where[i, 0], where[i, 1], where[i, 2], where[i, 3], 1e-14, work, results[i])
        if code != OK_CODE:
            return code
    for i in range(2):
        turning[i, 0, k] = results[i, S1]
        turning[i, 1, k] = results[i, S2]
        turning[i, 2, k] = results[i, T2]
    error[k] = max(results[0, ERROR], results[1, ERROR])
    derivatives(chart, mu, momenta, angular, results, M, N)
    for a in range(2):
        still[a] = 0.0
        if not angular[a]:
            J[2 + a, k] = 2 * np.pi * momenta[a]
            turn[a] = 2 * np.pi
            partial[a] = at[a]
            continue
        code = _angle(angles[a], c[2 + a], at[a], momenta[a], work, results[2])
        if code != OK_CODE:
            return code
        J[2 + a, k] = results[2, ACTION]
        turn[a] = results[2, D0]
        partial[a] = results[2, W0]
        still[a] = 1.0 if results[2, WIDTH] <= 0.0 else 0.0
        error[k] = max(error[k], results[2, ERROR])
    solve_transposed(M, ENERGY[chart], answer)
    nu[0, k] = answer[0]
    nu[1, k] = answer[1]
    J[0, k] = results[0, ACTION]
    J[1, k] = results[1, ACTION]
    for a in range(2):
        nu[2 + a, k] = -(answer[0] * N[0, a] + answer[1] * N[1, a]) / turn[a]
        if np.isnan(N[0, a]) or np.isnan(N[1, a]):
            code = SEPARATRIX_CODE
    for j in range(2):
        pair[j] = _inner(chart, j, 0, results)
    solve_transposed(M, pair, answer)
    for a in range(2):
        factor = 1.0 if angular[a] else momenta[a] / mu
        partial[a] += factor * _inner(chart, 2 + a, 2, results) if factor != 0.0 else 0.0
        theta[a, k] = answer[a]
        theta[2 + a, k] = (partial[a] - answer[0] * N[0, a] - answer[1] * N[1, a]) / turn[a]
    return _settle(tori, k, results, still, code)


def tori_by_quadrature(unit, stop, progress, chart, first, second, eta, gamma, mu, radial_mu, angular, tori):
    """Fill the tori of the states z, from the terms of the potential in both coordinates, eta and gamma."""
    _, J, nu, theta, turning, _, error, status = tori
    if stop[0] != 0:
        return
    scratch = Scratch(np.zeros((ROWS, MOST)), np.zeros((2, 4)), np.zeros((15, 4)), np.zeros((3, RESULTS)))
    ends = np.zeros((2, 2))
    u = scratch.small[1]
    coordinates = (
        Coordinate(first, radial_mu, KINDS[chart, 0], u, ends[0]),
        Coordinate(second, mu, KINDS[chart, 1], u, ends[1]),
    )
    angles = Coordinate(eta, mu, LINE, u, u), Coordinate(gamma, mu, LINE, u, u)
    limits(coordinates[0], scratch.work)
    limits(coordinates[1], scratch.work)
    for k in range(unit * UNIT, min(status.size, (unit + 1) * UNIT)):
        # clear the numbers of the state before
        scratch.results[:] = 0.0
        scratch.small[:] = 0.0
        status[k] = _state(chart, coordinates, angles, angular, tori, k, scratch)
        if status[k] == OK_CODE and not np.isfinite(J[:, k].sum() + nu[:, k].sum() + theta[:, k].sum()):
            status[k] = NOT_CONVERGED_CODE
        if status[k] not in (OK_CODE, ACTION_ZERO_CODE, SEPARATRIX_CODE):
            error[k] = np.inf
            for i in range(4):
                J[i, k] = np.nan
                nu[i, k] = np.nan
                theta[i, k] = np.nan
            turning[:, :, k] = np.nan
    progress[unit] = 1
