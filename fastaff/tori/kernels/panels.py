"""Loop integrals of one separated coordinate where its potential has narrow features or a wall is near: panels.

The phase chi of `tori_librations` is cut at the potential's knots, and halved until on every panel the last Legendre
coefficients of all integrands vanish. Panels lie in the rows of work memory one after another, ORDER nodes each.
"""

import numpy as np

from ...engine.jit import jit
from .coordinates import PANELS, S1, SINE, WIDTH

ORDER = 16
"""Gauss-Legendre nodes of a panel."""

LOW = 12
"""Row of work memory: sin^2 of chi/2 at the nodes."""

HIGH = 13
"""Row of work memory: cos^2 of chi/2 at the nodes."""

LEFT = 10
"""Row of work memory: beginnings of panels."""

LENGTH = 11
"""Row of work memory: lengths of panels."""


def _legendre():
    """Return nodes, weights and the matrix from values to Legendre coefficients."""
    x, w = np.polynomial.legendre.leggauss(ORDER)
    k = np.arange(ORDER)
    return x, w, np.ascontiguousarray((2 * k[:, None] + 1) / 2 * np.polynomial.legendre.legvander(x, ORDER - 1).T * w)


NODES, WEIGHTS, TO_LEGENDRE = _legendre()


@jit
def place_panel(panel, work):
    """Write sin^2 and cos^2 of chi/2 at the nodes of a panel."""
    for k in range(ORDER):
        chi = work[LEFT, panel] + 0.5 * work[LENGTH, panel] * (1 + NODES[k])
        work[LOW, panel * ORDER + k] = np.sin(0.5 * chi) ** 2
        work[HIGH, panel * ORDER + k] = np.cos(0.5 * chi) ** 2


@jit
def first_panels(kind, knots, most, work, out):
    """Cut [0, pi] at the knots between the turning points; returns the number of panels."""
    count = 0
    last = 0.0
    for k in range(knots.size):
        s = knots[k] / (1 + knots[k]) if kind == SINE else knots[k]
        share = (s - out[S1]) / (2 * out[WIDTH])
        if not 0.0 < share < 1.0:
            continue
        chi = 2 * np.arcsin(np.sqrt(share))
        if chi - last > 1e-6 and np.pi - chi > 1e-6 and count < most // 2:
            work[LEFT, count] = last
            work[LENGTH, count] = chi - last
            count = count + 1
            last = chi
    work[LEFT, count] = last
    work[LENGTH, count] = np.pi - last
    return count + 1


@jit
def halve(panel, count, work):
    """Cut a panel; its second half becomes number `count`."""
    half = 0.5 * work[LENGTH, panel]
    work[LENGTH, panel] = half
    work[LEFT, count] = work[LEFT, panel] + half
    work[LENGTH, count] = half


@jit
def size_and_rest(row, panel, work):
    """Return the integral of |f| over a panel, and the size of its last two Legendre coefficients there."""
    size = 0.0
    last = 0.0
    before = 0.0
    first = panel * ORDER
    for k in range(ORDER):
        f = work[row, first + k]
        size += WEIGHTS[k] * abs(f)
        last += TO_LEGENDRE[ORDER - 1, k] * f
        before += TO_LEGENDRE[ORDER - 2, k] * f
    half = 0.5 * work[LENGTH, panel]
    return half * size, half * (abs(last) + abs(before))


@jit
def panel_value(row, chi, work, out):
    """The function of a row at chi of [0, pi], from the Legendre series of the panel there."""
    for panel in range(int(out[PANELS])):
        x = 2 * (chi - work[LEFT, panel]) / work[LENGTH, panel] - 1
        if -1 - 1e-12 <= x <= 1 + 1e-12:
            return _series(row, panel, x, work, 0)
    return np.nan


@jit
def _series(row, panel, x, work, integral):
    """The Legendre series of a panel at x of [-1, 1], or its integral from -1."""
    total = 0.0
    before = 1.0
    now = x
    for n in range(ORDER):
        c = 0.0
        for k in range(ORDER):
            c += TO_LEGENDRE[n, k] * work[row, panel * ORDER + k]
        following = ((2 * n + 3) * x * now - (n + 1) * before) / (n + 2)  # P_(n+2)
        if integral == 0:
            total += c * before
        elif n == 0:
            total += c * (x + 1)
        else:
            total += c * (now - ((2 * n + 1) * x * before - (n + 1) * now) / n) / (2 * n + 1)
        before = now
        now = following
    return total


@jit
def panel_integral(row, chi, work, out):
    """The integral of the function of a row from 0 to chi of [0, pi]."""
    total = 0.0
    for panel in range(int(out[PANELS])):
        left = work[LEFT, panel]
        length = work[LENGTH, panel]
        if chi >= left + length:
            for k in range(ORDER):
                total += 0.5 * length * WEIGHTS[k] * work[row, panel * ORDER + k]
        elif chi > left:
            total += 0.5 * length * _series(row, panel, 2 * (chi - left) / length - 1, work, 1)
    return total


@jit
def turned_integral(row, chi, work, out):
    """The same for chi of [0, 2 pi): the functions are even."""
    if chi <= np.pi:
        return panel_integral(row, chi, work, out)
    return 2 * panel_integral(row, np.pi, work, out) - panel_integral(row, 2 * np.pi - chi, work, out)
