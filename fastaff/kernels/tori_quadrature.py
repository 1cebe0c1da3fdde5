"""Actions, frequencies and angles of many states of a separable body by quadrature.

Constants c = (c0, c1, c_eta, c_gamma): two of the chart and the squares of the angular momenta over 2 mu with the
angular potentials, c_eta = p_eta^2/(2 mu) + V_eta. Coordinate i has the coefficients u = LINKS[chart, i] c of
`libration`, so dJ_i/dc = LINKS^T (D0...D3), dE = dc0 (+ dc1 in the alpha-beta chart), and nu = dE/dJ, theta =
(dJ/dc)^-T (partial integrals).
"""

import numpy as np

from ..base.status import ACTION_ZERO_CODE, NOT_CONVERGED_CODE, OK_CODE, SEPARATRIX_CODE
from ..compile.jit import jit
from .tori_librations import MOST, ROWS, librate, limits
from .tori_wells import ACTION, D0, ERROR, LINE, RADIAL, RESULTS, S1, S2, SINE, SINH, T2, W0, WIDTH

ALPHA_BETA, R_VARTHETA, ELLIPTIC = 0, 1, 2
KINDS = np.array([[RADIAL, RADIAL], [RADIAL, SINE], [SINH, SINE]])
UNIT = 64
"""States that a thread takes at once."""

LEAST_TURN = 64
"""Least number of nodes over a turn of an angle that has a potential, where barriers are looked for."""


def _links():
    """Return du_k/dc_j (chart, coordinate, k, j)."""
    links = np.zeros((3, 2, 4, 4))
    links[0, 0, 0, 0], links[0, 0, 3, 2] = 1, -1
    links[0, 1, 0, 1], links[0, 1, 3, 3] = 1, -1
    links[1, 0, 0, 0], links[1, 0, 3, 1] = 1, -1
    links[1, 1, 0, 1], links[1, 1, 2, 2], links[1, 1, 3, 3] = 1, -1, -1
    links[2, 0, 1, 0], links[2, 0, 0, 1], links[2, 0, 2, 2], links[2, 0, 3, 3] = 2, -2, 1, -1
    links[2, 1, 0, 1], links[2, 1, 1, 0], links[2, 1, 2, 2], links[2, 1, 3, 3] = 2, -2, -1, -1
    return links


LINKS = _links()
ENERGY = np.array([[1.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
"""dE/dc0, dE/dc1 of each chart."""


@jit
def place(chart, z, k, where):
    """Write s, t, root = sqrt(F) with its sign, and dF/ds (or dF/dt) on the axis, of both coordinates of state k to
    where (2, 4).
    """
    T_a, T_b = z[4, k] * z[4, k] + z[5, k] * z[5, k], z[6, k] * z[6, k] + z[7, k] * z[7, k]
    A, B = z[0, k] * z[0, k] + z[1, k] * z[1, k], z[2, k] * z[2, k] + z[3, k] * z[3, k]
    pA, pB = z[0, k] * z[4, k] + z[1, k] * z[5, k], z[2, k] * z[6, k] + z[3, k] * z[7, k]
    r = A + B
    if chart == ALPHA_BETA:
        where[0, 0], where[0, 1], where[0, 2] = A, 1.0, pA
        where[1, 0], where[1, 1], where[1, 2] = B, 1.0, pB
        where[0, 3], where[1, 3] = T_a, T_b
    elif chart == R_VARTHETA:
        where[0, 0], where[0, 1], where[0, 2] = r, 1.0, pA + pB
        where[1, 0], where[1, 1], where[1, 2] = B / r, A / r, (A * pB - B * pA) / r
        where[0, 3], where[1, 3] = 0.0, r * (T_b if B <= A else T_a)
    else:
        sigma = r / 2 - 1
        root = np.sqrt(sigma * sigma + 2 * B)
        large = (abs(sigma) + root) / 2
        small = B / (2 * large) if large > 0.0 else 0.0
        s = large if sigma >= 0 else small
        t = small if sigma >= 0 else large
        where[0, 0], where[0, 1], where[0, 2] = s, 1 + s, s * pA + (1 + s) * pB
        where[1, 0], where[1, 1], where[1, 2] = t, A / (2 * (1 + s)), -t * pA + A / (2 * (1 + s)) * pB
        # On the axis beta = 0 one of the two is 0: p^2 s t/s there.
        where[0, 3], where[1, 3] = 2 * (1 - t) * T_b, 2 * (1 + s) * (T_b if B <= A else T_a)


@jit
def separate(chart, mu, z, k, where, U, V, c):
    """Write the constants c (4,) of state k; U (2,) are the coordinates' potentials, V (2,) those of eta and gamma."""
    A, B = z[0, k] * z[0, k] + z[1, k] * z[1, k], z[2, k] * z[2, k] + z[3, k] * z[3, k]
    p_eta, p_gamma = z[0, k] * z[5, k] - z[1, k] * z[4, k], z[2, k] * z[7, k] - z[3, k] * z[6, k]
    T_a = (z[4, k] * z[4, k] + z[5, k] * z[5, k]) / (2 * mu)
    T_b = (z[6, k] * z[6, k] + z[7, k] * z[7, k]) / (2 * mu)
    wall_a = V[0] / A if V[0] != 0.0 else 0.0
    wall_b = V[1] / B if V[1] != 0.0 else 0.0
    c[2], c[3] = p_eta * p_eta / (2 * mu) + V[0], p_gamma * p_gamma / (2 * mu) + V[1]
    if chart == ALPHA_BETA:
        c[0], c[1] = T_a + U[0] + wall_a, T_b + U[1] + wall_b
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
    else:
        s, t, t_c = where[0, 0], where[1, 0], where[1, 1]
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
    cosine, sine = work[4], work[5]
    for k in range(nodes):
        cosine[k], sine[k] = 1.0, 0.0
    for n in range(nodes // 2):
        a, b = 0.0, 0.0
        for k in range(nodes):
            a += work[1, k] * cosine[k]
            b += work[1, k] * sine[k]
        work[2, n], work[3, n] = 2 * a / nodes, 2 * b / nodes
        for k in range(nodes):
            c, s = work[6, k], work[7, k]
            cosine[k], sine[k] = cosine[k] * c - sine[k] * s, sine[k] * c + cosine[k] * s
    last = nodes // 2 - 1
    tail = abs(work[2, last]) + abs(work[3, last]) + abs(work[2, last - 1]) + abs(work[3, last - 1])
    return tail / work[2, 0]


@jit
def _turn(potential, params, mu, c, at, momentum, knots, work, out):
    """An angle that turns over and over: J, D0 = dJ/dc and W0 to the state; a status, or -1 where it does not turn."""
    nodes = LEAST_TURN
    for k in range(knots.size):
        work[0, 0], nodes = knots[k], MOST  # narrow features: all that there are
        potential(params, 1, work[0], work[1])
        if not work[1, 0] < c:
            return -1
    while True:
        for k in range(nodes):
            work[0, k] = (k + 0.5) * 2 * np.pi / nodes
            work[6, k], work[7, k] = np.cos(work[0, k]), np.sin(work[0, k])
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
    last_cosine, last_sine, total = 1.0, 0.0, 0.5 * work[2, 0] * at
    for n in range(1, nodes // 2):
        last_cosine, last_sine = (
            last_cosine * np.cos(at) - last_sine * np.sin(at),
            last_sine * np.cos(at) + last_cosine * np.sin(at),
        )
        total += (work[2, n] * last_sine + work[3, n] * (1 - last_cosine)) / n
    sign = 1.0 if momentum >= 0.0 else -1.0
    out[ACTION], out[D0], out[W0] = sign * 2 * np.pi / nodes * action, sign * np.pi * work[2, 0], sign * total
    out[WIDTH], out[ERROR] = 1.0, tail
    return OK_CODE if tail < 1e-7 else NOT_CONVERGED_CODE


@jit
def _angle(potential, params, mu, c, at, momentum, u, knots, work, out):
    """An angle that turns over or librates in its potential: J, D0 = dJ/dc and W0 to the state; returns a status."""
    code = _turn(potential, params, mu, c, at, momentum, knots, work, out)
    if code >= 0:
        return code
    u[0] = c
    return librate(potential, params, mu, u, LINE, u, knots, at, 1.0, momentum, 0.0, 1e-14, work, out)


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


@jit
def _state(
    chart,
    first,
    first_p,
    second,
    second_p,
    eta_V,
    eta_p,
    gamma_V,
    gamma_p,
    mu,
    angular,
    ends,
    knots,
    z,
    k,
    work,
    where,
    small,
    results,
    J,
    nu,
    theta,
    turning,
    constants,
    error,
):
    """All of one state; returns its status. J, nu, theta have rows of the two coordinates, eta, gamma."""
    place(chart, z, k, where)
    c, u, U, V, at, momenta, pair = small[0], small[1], small[2], small[3], small[4], small[5], small[6]
    answer, turn, partial, M, N, still = small[7], small[8], small[9], small[10:12], small[12:14], small[14]
    V[0], V[1] = 0.0, 0.0
    first(first_p, 1, where[0, :1], work[2])
    U[0] = work[2, 0]
    second(second_p, 1, where[1, :1], work[2])
    U[1] = work[2, 0]
    for a in range(2):
        i, j = 2 * a, 2 * a + 1
        at[a] = (
            np.arctan2(z[j, k], z[i, k]) if z[j, k] != 0.0 or z[i, k] != 0.0 else np.arctan2(z[4 + j, k], z[4 + i, k])
        )
        momenta[a] = z[i, k] * z[4 + j, k] - z[j, k] * z[4 + i, k]
    if angular[0]:
        eta_V(eta_p, 1, at, work[2])
        V[0] = work[2, 0]
    if angular[1]:
        gamma_V(gamma_p, 1, at[1:], work[2])
        V[1] = work[2, 0]
    separate(chart, mu, z, k, where, U, V, c)
    for j in range(4):
        constants[j, k] = c[j]
    coefficients(chart, 0, c, u)
    code = librate(
        first,
        first_p,
        mu,
        u,
        KINDS[chart, 0],
        ends[0],
        knots[0],
        where[0, 0],
        where[0, 1],
        where[0, 2],
        where[0, 3],
        1e-14,
        work,
        results[0],
    )
    if code != OK_CODE:
        return code
    coefficients(chart, 1, c, u)
    code = librate(
        second,
        second_p,
        mu,
        u,
        KINDS[chart, 1],
        ends[1],
        knots[1],
        where[1, 0],
        where[1, 1],
        where[1, 2],
        where[1, 3],
        1e-14,
        work,
        results[1],
    )
    if code != OK_CODE:
        return code
    for i in range(2):
        turning[i, 0, k], turning[i, 1, k], turning[i, 2, k] = results[i, S1], results[i, S2], results[i, T2]
    error[k] = max(results[0, ERROR], results[1, ERROR])
    derivatives(chart, mu, momenta, angular, results, M, N)
    for a in range(2):
        still[a] = 0.0
        if not angular[a]:
            J[2 + a, k], turn[a], partial[a] = 2 * np.pi * momenta[a], 2 * np.pi, at[a]
            continue
        if a == 0:
            code = _angle(eta_V, eta_p, mu, c[2], at[0], momenta[0], u, knots[2], work, results[2])
        else:
            code = _angle(gamma_V, gamma_p, mu, c[3], at[1], momenta[1], u, knots[3], work, results[2])
        if code != OK_CODE:
            return code
        J[2 + a, k], turn[a], partial[a] = results[2, ACTION], results[2, D0], results[2, W0]
        still[a] = 1.0 if results[2, WIDTH] <= 0.0 else 0.0
        error[k] = max(error[k], results[2, ERROR])
    solve_transposed(M, ENERGY[chart], answer)
    nu[0, k], nu[1, k] = answer[0], answer[1]
    J[0, k], J[1, k] = results[0, ACTION], results[1, ACTION]
    for a in range(2):
        nu[2 + a, k] = -(answer[0] * N[0, a] + answer[1] * N[1, a]) / turn[a]
        if np.isnan(N[0, a]) or np.isnan(N[1, a]):
            code = SEPARATRIX_CODE
    for j in range(2):
        pair[j] = 0.0
        for i in range(2):
            for row in range(4):
                if LINKS[chart, i, row, j] != 0.0:
                    pair[j] += LINKS[chart, i, row, j] * results[i, W0 + row]
    solve_transposed(M, pair, answer)
    for a in range(2):
        total = 0.0
        for i in range(2):
            for row in range(2, 4):
                if LINKS[chart, i, row, 2 + a] != 0.0:
                    total += LINKS[chart, i, row, 2 + a] * results[i, W0 + row]
        factor = 1.0 if angular[a] else momenta[a] / mu
        partial[a] += factor * total if factor != 0.0 else 0.0
        theta[2 + a, k] = (partial[a] - answer[0] * N[0, a] - answer[1] * N[1, a]) / turn[a]
    for i in range(2):
        theta[i, k] = answer[i]
        if results[i, WIDTH] <= 0.0:
            theta[i, k] = np.nan
            code = ACTION_ZERO_CODE if code == OK_CODE else code
    for a in range(2):
        if still[a] == 1.0:
            theta[2 + a, k], J[2 + a, k] = np.nan, 0.0
            nu[2 + a, k] = nu[2 + a, k] if np.isfinite(nu[2 + a, k]) else np.nan
            code = ACTION_ZERO_CODE if code == OK_CODE else code
    for i in range(4):
        theta[i, k] -= np.floor(theta[i, k])
        if theta[i, k] >= 1.0:
            theta[i, k] = 0.0
    return code


def tori_by_quadrature(
    unit,
    stop,
    progress,
    chart,
    first,
    first_p,
    second,
    second_p,
    eta_V,
    eta_p,
    gamma_V,
    gamma_p,
    mu,
    angular,
    knots_1,
    knots_2,
    knots_eta,
    knots_gamma,
    z,
    J,
    nu,
    theta,
    turning,
    constants,
    error,
    status,
):
    """z (8, n), knots of the four functions ->
    J, nu, theta, constants (4, n), turning (2, 3, n), error, status (n,); stop (1,), progress (units,)."""
    n = z.shape[1]
    if stop[0] != 0:
        return
    work, results, where = np.zeros((ROWS, MOST)), np.zeros((3, RESULTS)), np.zeros((2, 4))
    small, ends, knots = np.zeros((15, 4)), np.zeros((2, 2)), (knots_1, knots_2, knots_eta, knots_gamma)
    limits(first, first_p, KINDS[chart, 0], work, ends[0])
    limits(second, second_p, KINDS[chart, 1], work, ends[1])
    for k in range(unit * UNIT, min(n, (unit + 1) * UNIT)):
        results[:], small[:] = 0.0, 0.0  # nothing of the state before it
        status[k] = _state(
            chart,
            first,
            first_p,
            second,
            second_p,
            eta_V,
            eta_p,
            gamma_V,
            gamma_p,
            mu,
            angular,
            ends,
            knots,
            z,
            k,
            work,
            where,
            small,
            results,
            J,
            nu,
            theta,
            turning,
            constants,
            error,
        )
        if status[k] == OK_CODE and not np.isfinite(J[:, k].sum() + nu[:, k].sum() + theta[:, k].sum()):
            status[k] = NOT_CONVERGED_CODE
        if status[k] not in (OK_CODE, ACTION_ZERO_CODE, SEPARATRIX_CODE):
            error[k] = np.inf
            for i in range(4):
                J[i, k], nu[i, k], theta[i, k] = np.nan, np.nan, np.nan
            turning[:, :, k] = np.nan
    progress[unit] = 1
