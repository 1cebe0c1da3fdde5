"""Factors of wave functions that are a weight times a polynomial, and the turn e^(i k eta + i g gamma).

Both families, Laguerre and Jacobi, obey one ladder once the polynomials are divided by their value at y = 0:

    d_(k+1) = u_k d_k - w_k y phi_k,   phi_(k+1) = phi_k + d_(k+1),   phi_0 = 1, d_0 = 0

It goes by differences: near y = 0 it loses no digits, where the three-term recurrence loses n^2 units of rounding.
Where the polynomial grows, it is the growing solution. phi and d share a power of two that is taken out every few
steps: no n or y overflows.
"""

from __future__ import annotations

import math

import numpy as np

from ...engine.jit import LANES, POINTS, jit

CHUNK = 16  # steps between two checks of the size: it changes by less than 2^600 in them, for y below the cut
BIG = 2.0**300
"""Size above which a recurrence is scaled down."""

SMALL = 2.0**-300
"""Size below which a recurrence is scaled up."""

LOG_BIG = 300 * math.log(2.0)
"""Logarithm of BIG."""

# 33 bits of ln 2, and the rest
LN2_HIGH = 6.93147180369123816490e-01
LN2_LOW = 1.90821492927058770002e-10


@jit
def _ladder(u, w, y, phi, d, logarithm):
    """Climb u.size steps for a block of y; the polynomial is phi*exp(logarithm), all (LANES,)."""
    for i in range(LANES):
        phi[i] = 1.0
        d[i] = 0.0
        logarithm[i] = 0.0
    for first in range(0, u.size, CHUNK):
        for k in range(first, min(first + CHUNK, u.size)):
            up = u[k]
            down = w[k]
            for i in range(LANES):
                d[i] = up * d[i] - down * y[i] * phi[i]
                phi[i] += d[i]
        for i in range(LANES):
            size = max(abs(phi[i]), abs(d[i]))
            shrink = SMALL if size > BIG else (BIG if size < SMALL else 1.0)
            logarithm[i] -= LOG_BIG if shrink > 1.0 else (-LOG_BIG if shrink < 1.0 else 0.0)
            phi[i] *= shrink
            d[i] *= shrink


@jit
def _exp(x, out, power):
    """Write e^x for a block without branches, 0 below -708; power (LANES,) is work space. Error 1 unit of rounding for
    |x| < 1.
    """
    for i in range(LANES):
        power[i] = np.floor(min(max(x[i], -708.0), 709.0) * 1.4426950408889634 + 0.5)
        r = min(max(x[i], -708.0), 709.0) - power[i] * LN2_HIGH - power[i] * LN2_LOW
        value = 1.0 / 6227020800.0
        value = value * r + 1.0 / 479001600.0
        value = value * r + 1.0 / 39916800.0
        value = value * r + 1.0 / 3628800.0
        value = value * r + 1.0 / 362880.0
        value = value * r + 1.0 / 40320.0
        value = value * r + 1.0 / 5040.0
        value = value * r + 1.0 / 720.0
        value = value * r + 1.0 / 120.0
        value = value * r + 1.0 / 24.0
        value = value * r + 1.0 / 6.0
        value = value * r + 0.5
        out[i] = (r + r * r * value + 1.0) if x[i] >= -708.0 else 0.0
    bits = power.view(np.int64)
    for i in range(LANES):
        bits[i] = (np.int64(power[i]) + 1023) << 52
    for i in range(LANES):
        out[i] *= power[i]


@jit
def _log(x, out, work):
    """Write ln x for a block of x >= 0 without branches, -inf at 0; work (LANES,). By 2 artanh((m - 1)/(m + 1)), m in
    [1/sqrt2, sqrt2].
    """
    for i in range(LANES):
        work[i] = x[i] * 2.0**54 if x[i] < 1e-290 else x[i]
    bits = work.view(np.int64)
    for i in range(LANES):
        out[i] = float((bits[i] >> 52) - 1023)
        bits[i] = (bits[i] & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000
    for i in range(LANES):
        large = work[i] > 1.4142135623730951
        m = 0.5 * work[i] if large else work[i]
        e = out[i] + (1.0 if large else 0.0) - (54.0 if x[i] < 1e-290 else 0.0)
        s = (m - 1.0) / (m + 1.0)
        t = s * s
        value = 1.0 / 21.0
        value = value * t + 1.0 / 19.0
        value = value * t + 1.0 / 17.0
        value = value * t + 1.0 / 15.0
        value = value * t + 1.0 / 13.0
        value = value * t + 1.0 / 11.0
        value = value * t + 1.0 / 9.0
        value = value * t + 1.0 / 7.0
        value = value * t + 0.2
        value = value * t + 1.0 / 3.0
        finite = e * LN2_HIGH + (e * LN2_LOW + 2.0 * s * t * value + 2.0 * s)
        out[i] = finite if x[i] > 0.0 else -np.inf


def laguerre_values(portion, u, w, constants, kappa, squared, x, out):
    """Write (y/y0)^h e^(c - (y - y0)/2) phi_n(y) into out for y = kappa x or kappa x^2, x (points,).

    constants (c, h, y0, cut): 0 beyond the cut.
    """
    c = constants[0]
    h = constants[1]
    y0 = constants[2]
    cut = constants[3]
    for start in range(portion * POINTS, min(x.size, (portion + 1) * POINTS), LANES):
        count = min(LANES, x.size - start)
        t = np.empty(LANES)
        phi = np.empty(LANES)
        d = np.empty(LANES)
        logarithm = np.empty(LANES)
        work = np.empty(LANES)
        inside = np.empty(LANES)
        for i in range(LANES):
            at = x[start + min(i, count - 1)]
            t[i] = min(kappa * (at * at if squared else at), cut)
            inside[i] = 1.0 if t[i] < cut else 0.0
        _ladder(u, w, t, phi, d, logarithm)
        for i in range(LANES):
            logarithm[i] += c - 0.5 * (t[i] - y0)
            t[i] = t[i] / y0 if h > 0.0 else t[i]
        if h > 0.0:
            _log(t, d, work)
            for i in range(LANES):
                logarithm[i] += h * d[i]
        _exp(logarithm, d, work)
        for i in range(count):
            out[start + i] = inside[i] * d[i] * phi[i]


def jacobi_values(portion, u, w, constants, y, z, out):
    """Write (y/y0)^h (z/z0)^g e^c phi_n(y) into out; z = 1 - y. Tables (2, n), constants (2, 6), rows: from the end y =
    0, from z = 0.

    constants (c, h, y0, g, z0, sign); the second row is the first with y and z exchanged. Each point uses its nearer
    end.
    """
    for start in range(portion * POINTS, min(y.size, (portion + 1) * POINTS), LANES):
        count = min(LANES, y.size - start)
        near = np.empty(LANES)
        phi = np.empty(LANES)
        d = np.empty(LANES)
        logarithm = np.empty(LANES)
        work = np.empty(LANES)
        for end in range(2):
            c = constants[end, 0]
            h = constants[end, 1]
            y0 = constants[end, 2]
            g = constants[end, 3]
            z0 = constants[end, 4]
            sign = constants[end, 5]
            some = False
            for i in range(LANES):
                j = start + min(i, count - 1)
                mine = (y[j] <= z[j]) == (end == 0)
                some |= mine
                near[i] = (y[j] if end == 0 else z[j]) if mine else 0.0
            if some:
                _ladder(u[end], w[end], near, phi, d, logarithm)
                for i in range(LANES):
                    logarithm[i] += c
                    near[i] /= y0
                if h > 0.0:
                    _log(near, d, work)
                    for i in range(LANES):
                        logarithm[i] += h * d[i]
                if g > 0.0:
                    for i in range(LANES):
                        j = start + min(i, count - 1)
                        near[i] = (z[j] if end == 0 else y[j]) / z0
                    _log(near, d, work)
                    for i in range(LANES):
                        logarithm[i] += g * d[i]
                _exp(logarithm, d, work)
                for i in range(count):
                    j = start + i
                    if (y[j] <= z[j]) == (end == 0):
                        out[j] = sign * d[i] * phi[i]


def polynomial_values(portion, diagonal, off, coefficients, t, out):
    """Write sum c_k p_k(t) into out (points,): off_k p_k = (t - diagonal_(k-1)) p_(k-1) - off_(k-1) p_(k-2), off from k
    = 1, p_0 = 1.
    """
    for start in range(portion * POINTS, min(t.size, (portion + 1) * POINTS), LANES):
        count = min(LANES, t.size - start)
        at = np.empty(LANES)
        p = np.ones(LANES)
        before = np.zeros(LANES)
        total = np.empty(LANES)
        for i in range(LANES):
            at[i] = t[start + min(i, count - 1)]
            total[i] = coefficients[0]
        back = 0.0
        for k in range(1, coefficients.size):
            shift = diagonal[k - 1]
            up = 1.0 / off[k - 1]
            c = coefficients[k]
            for i in range(LANES):
                here = ((at[i] - shift) * p[i] - back * before[i]) * up
                before[i] = p[i]
                p[i] = here
                total[i] += c * here
            back = off[k - 1]
        for i in range(count):
            out[start + i] = total[i]


@jit
def _turned(k, x, y, radius, re, im, lanes):
    """Multiply re + i im by ((x + i y)/radius)^k for a block, by repeated squaring; the angle of radius 0 counts as
    0.
    """
    cosine = np.empty(LANES)
    sine = np.empty(LANES)
    up = 1.0 if k >= 0 else -1.0
    for i in range(lanes):
        w = 1.0 / radius[i] if radius[i] > 0.0 else 0.0
        cosine[i] = x[i] * w if radius[i] > 0.0 else 1.0
        sine[i] = up * y[i] * w
    power = abs(k)
    while power:
        if power & 1:
            for i in range(lanes):
                real = re[i] * cosine[i] - im[i] * sine[i]
                im[i] = re[i] * sine[i] + im[i] * cosine[i]
                re[i] = real
        power >>= 1
        if power:
            for i in range(lanes):
                real = cosine[i] * cosine[i] - sine[i] * sine[i]
                sine[i] = 2.0 * cosine[i] * sine[i]
                cosine[i] = real


def plane_radii(portion, planes, radii):
    """Write |a|, |b| of planes (4, points) into radii (2, points)."""
    for i in range(portion * POINTS, min(planes.shape[1], (portion + 1) * POINTS)):
        a1 = planes[0, i]
        a2 = planes[1, i]
        b1 = planes[2, i]
        b2 = planes[3, i]
        radii[0, i] = math.sqrt(a1 * a1 + a2 * a2)
        radii[1, i] = math.sqrt(b1 * b1 + b2 * b2)


def turn_planes(portion, k, g, planes, radii, amplitude, out):
    """Write amplitude*e^(i k eta + i g gamma) into out (points,), complex, for planes (4, points) of radii (2,
    points).
    """
    points = amplitude.size
    for start in range(portion * POINTS, min(points, (portion + 1) * POINTS), LANES):
        lanes = min(LANES, points - start)
        re, im = np.empty(LANES), np.zeros(LANES)
        for i in range(lanes):
            re[i] = amplitude[start + i]
        end = start + lanes
        _turned(k, planes[0, start:end], planes[1, start:end], radii[0, start:end], re, im, lanes)
        _turned(g, planes[2, start:end], planes[3, start:end], radii[1, start:end], re, im, lanes)
        for i in range(lanes):
            out[start + i] = complex(re[i], im[i])
