"""Loop integrals of one separated coordinate between its turning points.

With F and the kinds of coordinates of `tori_wells`,

    J = 1/2 loop integral of sqrt(F)/(s t) ds     (of sqrt(F) ds on a LINE).

Between the turning points s = s1 + 2 l sin^2(chi/2), F = (s - s1)(s2 - s) G, and J and its derivatives to u0...u3 are
integrals over chi of smooth even functions of period 2 pi, which sums over midpoints give with exponential accuracy.
The functions 1/s and 1/t may have their pole near a turning point; they are subtracted in closed form.
"""

import numpy as np

from ...core.status import NOT_CONVERGED_CODE, OK_CODE
from ...engine.jit import jit
from .coordinates import (
    ACTION,
    CENTRE,
    D2,
    D3,
    ERROR,
    LINE,
    NODES,
    PANELS,
    RADIAL,
    RADIUS,
    S1,
    S2,
    SINE,
    SINH,
    T1,
    T2,
    WIDTH,
    complement,
    radicands,
)
from .narrow import powers
from .panels import HIGH, LENGTH, LOW, ORDER, WEIGHTS, first_panels, halve, place_panel, size_and_rest

LEAST = 16
"""Least number of midpoints, doubled until the last Fourier coefficients vanish."""

MOST = 2048
"""Largest number of midpoints."""

ENOUGH = 256
"""Number of midpoints above which panels are better: a wall or a barrier is near a turning point."""

APART = 0.6
"""Poles are subtracted where the turning points are farther apart than this ratio; for closer ones J would be a small
difference.
"""

ROWS = 14
"""Rows of work memory, of MOST numbers each."""

FIRST = 5
"""Rows of work memory: s and t; F; the quotient of a narrow well; the integrands J, D0...D3; cosines (or panels);
sin^2, cos^2 of chi/2. Rows 2 and 4 hold weights."""

D0_ROW = FIRST + 1


def _tables():
    """Return sin^2(chi/2), sin(chi), cos(chi) at the midpoints of each number of nodes, one after another."""
    out = []
    nodes = LEAST
    while nodes <= MOST:
        chi = (np.arange(nodes) + 0.5) * np.pi / nodes
        out.append([np.sin(chi / 2) ** 2, np.sin(chi), np.cos(chi)])
        nodes *= 2
    return np.ascontiguousarray(np.concatenate(out, axis=1))


TABLES = _tables()


@jit
def poles(coordinate, out):
    """Lambda = sqrt(-F) at s = 0 and at t = 0, 0 where that end is far from the turning points or has no
    pole.
    """
    mu = coordinate.mu
    kind = coordinate.kind
    u = coordinate.u
    ends = coordinate.ends
    at_0 = 0.0
    at_1 = 0.0
    if kind != LINE and out[S1] < APART * out[S2] and np.isfinite(ends[0]):
        at_0 = np.sqrt(max(0.0, 2 * mu * (ends[0] - u[3])))
    if kind == SINE and out[T2] < APART * out[T1] and np.isfinite(ends[1]):
        at_1 = np.sqrt(max(0.0, 2 * mu * (ends[1] - u[2])))
    if kind == SINH and out[T1] < APART * out[T2] and np.isfinite(ends[1]):
        # Beyond the ends of motion a branch point of sqrt(G) nears the pole if Lambda is small: then the pole stays.
        at_1 = np.sqrt(max(0.0, 2 * mu * (ends[1] + u[2])))
        at_1 = at_1 if at_1 * at_1 > 0.1 * mu * (abs(u[0]) + abs(u[1])) else 0.0
    return at_0, at_1


@jit
def _integrands(coordinate, first, nodes, at_0, at_1, work, out):
    """Fill the rows J, D0...D3 of the integrands at `nodes` phases from number `first` on; False where F is not
    positive there.
    """
    kind = coordinate.kind
    s1 = out[S1]
    t2 = out[T2]
    width = out[WIDTH]
    end = first + nodes
    s = work[0, first:end]
    t = work[1, first:end]
    F = work[2, first:end]
    low = work[LOW, first:end]
    high = work[HIGH, first:end]
    for k in range(nodes):
        s[k] = s1 + 2 * width * low[k]
    for k in range(nodes):
        t[k] = t2 + 2 * width * high[k] if kind == SINE else complement(kind, s[k])
    if out[RADIUS] > 0.0:
        p = work[3]
        scale = -1 / (out[RADIUS] * out[RADIUS])
        for k in range(nodes):
            F[k] = scale * powers(p, (s[k] - out[CENTRE]) / out[RADIUS], 0)
    else:
        radicands(coordinate, nodes, s, t, F)
        for k in range(nodes):
            F[k] /= 4 * width * width * low[k] * high[k]
    good = True
    for k in range(nodes):
        good = good and F[k] > 0.0 and F[k] < np.inf
    if not good:
        return False
    J = work[5, first:end]
    f0 = work[6, first:end]
    f1 = work[7, first:end]
    f2 = work[8, first:end]
    f3 = work[9, first:end]
    near_0 = np.sqrt(s1 * out[S2])
    near_1 = np.sqrt(out[T1] * t2)
    take_0 = 0.0 if at_0 == 0.0 else near_0 / at_0
    take_1 = 0.0 if at_1 == 0.0 else near_1 / at_1
    give_0 = at_0 * near_0
    give_1 = (-at_1 if kind == SINH else at_1) * near_1
    # Through the axis itself the pole is not integrable: that derivative jumps and has no value.
    has_0 = s1 > 0.0 or at_0 > 0.0
    has_1 = t2 > 0.0 or at_1 > 0.0
    for k in range(nodes):
        G = np.sqrt(F[k])
        square = 4 * width * width * low[k] * high[k]
        f0[k] = 1 / G
        if kind == LINE:
            J[k] = G * square
            f1[k] = 0.0
            f2[k] = 0.0
            f3[k] = 0.0
        else:
            v = 1 / s[k] if s[k] > 0.0 else 0.0
            w = 1 / t[k] if t[k] > 0.0 else 0.0
            J[k] = G * square * v * w + give_0 * v + give_1 * w
            f1[k] = t[k] * f0[k]
            f2[k] = (f0[k] - take_1) * w if has_1 else 0.0
            f3[k] = (f0[k] - take_0) * v if has_0 else 0.0
    return True


@jit
def _tail(kind, nodes, at_0, at_1, work):
    """Size of the last Fourier coefficients of the integrands, relative to the integrals with the subtracted poles."""
    off = nodes - LEAST
    worst = 0.0
    for row in range(FIRST, FIRST + 2 if kind == LINE else FIRST + 5):
        first = 0.0
        second = 0.0
        size = 0.0
        sign = 1.0
        if row == FIRST + 4 and at_0 > 0.0:
            size = nodes / at_0
        if row == FIRST + 3 and at_1 > 0.0:
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
def _noise(coordinate, first, nodes, work, out):
    """Errors of 1/sqrt(G) from the rounding of F, a difference of large terms, summed over nodes, and its own sum
    there.
    """
    mu = coordinate.mu
    kind = coordinate.kind
    u = coordinate.u
    total = 0.0
    sum_f = 0.0
    size = 4e-16 * mu * (abs(u[0]) + abs(u[1])) / (4 * out[WIDTH] * out[WIDTH])
    for k in range(first, first + nodes):
        f = work[FIRST + 1, k]
        square = work[LOW, k] * work[HIGH, k]
        total += size * (work[0, k] * work[1, k] if kind != LINE else 1.0) * f * f * f / square
        sum_f += f
    return total, sum_f


@jit
def _finish(coordinate, at_0, at_1, out):
    """Add the subtracted poles to the integrals."""
    mu = coordinate.mu
    kind = coordinate.kind
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


@jit
def _by_midpoints(coordinate, at_0, at_1, goal, most, work, out):
    """Loop integrals by sums over midpoints of the phase; returns a status, or -1 where panels are better."""
    mu = coordinate.mu
    kind = coordinate.kind
    nodes = LEAST
    before = np.inf
    while True:
        off = nodes - LEAST
        for k in range(nodes):
            work[LOW, k] = TABLES[0, off + k]
            work[HIGH, k] = TABLES[0, off + nodes - 1 - k]
        if not _integrands(coordinate, 0, nodes, at_0, at_1, work, out):
            return NOT_CONVERGED_CODE
        tail = _tail(kind, nodes, at_0, at_1, work)
        # Coefficients that no longer fall are rounding; more nodes would only add to it.
        if tail <= goal or (tail > 0.3 * before and before < 1e-9) or nodes == MOST:
            break
        if nodes >= most and out[RADIUS] == 0.0:
            return -1
        before = tail
        nodes *= 2
    scale = (2 if kind == LINE else 1) * np.pi / nodes
    for j in range(5):
        out[ACTION + j] = scale * (1.0 if j == 0 else mu) * work[FIRST + j, :nodes].sum()
    if out[RADIUS] == 0.0:
        total, sum_f = _noise(coordinate, 0, nodes, work, out)
        out[ERROR] = 1e-15 + total / sum_f
    out[NODES] = nodes
    out[ERROR] = max(10 * tail, out[ERROR])
    return OK_CODE if tail < 1e-7 else NOT_CONVERGED_CODE


@jit
def _by_panels(coordinate, at_0, at_1, goal, work, out):
    """Loop integrals over panels of the phase, halved until all integrands are resolved; returns a status."""
    mu = coordinate.mu
    kind = coordinate.kind
    most = MOST // ORDER
    rows = 2 if kind == LINE else 5
    count = first_panels(kind, coordinate.term.knots, most, work, out)
    done = 0
    sizes = np.zeros(5)
    while True:
        for panel in range(done, count):
            place_panel(panel, work)
            if not _integrands(coordinate, panel * ORDER, ORDER, at_0, at_1, work, out):
                return NOT_CONVERGED_CODE
        sizes[:] = 0.0
        for panel in range(count):
            for j in range(rows):
                sizes[j] += size_and_rest(FIRST + j, panel, work)[0]
        sizes[3] += np.pi / at_1 if at_1 > 0.0 else 0.0
        sizes[4] += np.pi / at_0 if at_0 > 0.0 else 0.0
        tail = 0.0
        noise = 0.0
        done = count
        for panel in range(done):
            rest = 0.0
            for j in range(rows):
                if sizes[j] > 0.0:
                    rest = max(rest, size_and_rest(FIRST + j, panel, work)[1] / sizes[j])
            total, sum_f = _noise(coordinate, panel * ORDER, ORDER, work, out)
            for k in range(
                panel * ORDER, (panel + 1) * ORDER
            ):  # s itself is rounded: next to a wall F has a large slope
                edge = 0.5 / work[LOW, k] + 0.5 / work[HIGH, k]
                total += 1e-16 * work[0, k] / (2 * out[WIDTH]) * edge * work[FIRST + 1, k] if kind != LINE else 0.0
            rounding = total / sum_f * size_and_rest(FIRST + 1, panel, work)[0] / sizes[1]
            tail = tail + rest
            noise = noise + rounding
            if rest > max(0.1 * goal, 4 * rounding, 2e-16) and count < most and work[LENGTH, panel] > 1e-9:
                halve(panel, count, work)
                count += 1
        if count == done:
            break
        for panel in range(done):  # those that were cut have new nodes
            place_panel(panel, work)
            if not _integrands(coordinate, panel * ORDER, ORDER, at_0, at_1, work, out):
                return NOT_CONVERGED_CODE
    scale = 2 if kind == LINE else 1
    for j in range(5):
        total = 0.0
        for panel in range(count):
            for k in range(ORDER):
                total += 0.5 * work[LENGTH, panel] * WEIGHTS[k] * work[FIRST + j, panel * ORDER + k]
        out[ACTION + j] = scale * (1.0 if j == 0 else mu) * total
    out[NODES] = count * ORDER
    out[PANELS] = count
    out[ERROR] = tail + noise + 1e-15
    return OK_CODE if tail < 1e-7 else NOT_CONVERGED_CODE


@jit
def integrals(coordinate, goal, work, out):
    """Loop integrals J, dJ/du0...dJ/du3 between the turning points in `out`; returns a status."""
    kind = coordinate.kind
    knots = coordinate.term.knots
    at_0, at_1 = poles(coordinate, out)
    code = -1
    low = out[S1]
    high = out[S2]
    if kind == SINE:
        low = low / max(out[T1], 1e-300)
        high = high / max(out[T2], 1e-300)
    smooth = out[RADIUS] > 0.0 or out[WIDTH] <= 0.0 or np.searchsorted(knots, low) == np.searchsorted(knots, high)
    out[PANELS] = 0.0
    if smooth:
        code = _by_midpoints(coordinate, at_0, at_1, goal, ENOUGH, work, out)
    if code < 0:
        code = _by_panels(coordinate, at_0, at_1, goal, work, out)
        error = out[ERROR] if code == OK_CODE else np.inf
        if smooth and error > 1e-12:  # more midpoints may suffer less from rounding
            out[PANELS] = 0.0
            code = _by_midpoints(coordinate, at_0, at_1, goal, MOST, work, out)
            if error < np.inf and not (code == OK_CODE and out[ERROR] < error):
                code = _by_panels(coordinate, at_0, at_1, goal, work, out)
    _finish(coordinate, at_0, at_1, out)
    return code


@jit
def limits(coordinate, work):
    """Set the limits of U s t at s = 0 and at t = 0: the potential's own walls there."""
    term = coordinate.term
    kind = coordinate.kind
    ends = coordinate.ends
    s = work[0]
    U = work[2]
    ends[0] = 0.0
    ends[1] = 0.0
    if kind == LINE:
        return
    s[0] = 1e-200
    for k in range(1, 3):  # s = 1 or, beyond the end of the motion, s = -1
        s[k] = 1 - 10.0 ** (-2 * k - 4) if kind == SINE else 10.0 ** (-2 * k - 4) - 1
    term.function(term.params, 3, s, U)
    ends[0] = U[0] * 1e-200 if abs(U[0]) > 1e110 or not np.isfinite(U[0]) else 0.0
    if kind != RADIAL:
        far = U[1] * s[1] * complement(kind, s[1])
        near = U[2] * s[2] * complement(kind, s[2])
        # For a wall c/t U s t stays finite towards t = 0; for a regular potential it falls with t.
        if not np.isfinite(near):
            ends[1] = near
        elif abs(near) > 0.5 * abs(far):
            ends[1] = near + (near - far) / 99
