"""Kernels of tunes: mean angles from sample to sample of loops in the planes (q, p) of many orbits, piece after piece.

The angle of the step from one sample to the next is relative to a reference turn, so that none is near the cut at half
a turn. Centre, shape and reference of a plane's loop follow from weighted moments of earlier samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import jit, read_now
from ...engine.plane_loops import COLUMNS, angle_of

ORBITS = 16
"""Orbits of a unit, which are gathered at once: they are neighbours in memory if samples come first."""

SEGMENT = 512
"""Samples of them at once."""


@jit
def gather(chunk, first, count, start, size, room):
    """Copy the samples from `start` of `count` orbits of chunk (rows, orbits, samples) to room (orbits, rows, 1 +
    samples), after the first of each.
    """
    along = chunk.strides[2] <= chunk.strides[1]
    for r in range(chunk.shape[0]):
        if along:
            for o in range(count):
                for i in range(size):
                    room[o, r, 1 + i] = chunk[r, first + o, start + i]
        else:
            for i in range(size):
                for o in range(count):
                    room[o, r, 1 + i] = chunk[r, first + o, start + i]


def finite_until(unit, stop, progress, chunk, last, ended, until, again, still):
    """Fill until (orbits,) with the number of finite samples of chunk (rows, orbits, samples) before the first that is
    not, 0 for orbits that have ended, and again (orbits,) with the first finite one after that, -1 for none.

    last (orbits, rows): the samples before the chunk; still (2, orbits): the number of successive samples equal to the
    one before, at the end, and the largest so far.
    """
    if read_now(stop, 0) > 0:
        return
    rows, orbits, samples = chunk.shape
    first = unit * ORBITS
    count = min(ORBITS, orbits - first)
    room = np.empty((count, rows, SEGMENT + 1))
    trace = np.empty(SEGMENT)
    for o in range(count):
        until[first + o] = 0 if ended[first + o] > 0 else samples
        again[first + o] = -1
    for start in range(0, samples, SEGMENT):
        size = min(SEGMENT, samples - start)
        gather(chunk, first, count, start, size, room)
        for o in range(count):
            for r in range(rows):
                room[o, r, 0] = last[first + o, r] if start == 0 else chunk[r, first + o, start - 1]
            for i in range(size):
                r = 0
                while r < rows and room[o, r, 1 + i] == room[o, r, i]:
                    r += 1
                if r == rows:
                    still[0, first + o] += 1
                elif still[0, first + o] > 0:
                    still[1, first + o] = max(still[0, first + o], still[1, first + o])
                    still[0, first + o] = 0
            for i in range(size):
                trace[i] = 0.0
            for r in range(rows):
                row = room[o, r]
                for i in range(size):
                    trace[i] += 0.0 * row[1 + i]
            end = until[first + o]
            clean = end > start
            if clean:
                for i in range(size):
                    clean = clean and trace[i] == 0.0
            if not clean:
                for i in range(size):
                    if trace[i] == 0.0:
                        if end <= start + i and again[first + o] < 0:
                            again[first + o] = start + i
                    elif end > start + i:
                        end = start + i
                until[first + o] = end
    progress[unit] = 1.0


@jit
def step_angles(plane, q, p, pairs, re, im, angles):
    """Fill angles (pairs,) with the angle, less that of the reference, from each value of a plane's loop to the
    next.
    """
    q0 = plane[COLUMNS.q]
    p0 = plane[COLUMNS.p]
    a = plane[COLUMNS.a]
    b = plane[COLUMNS.b]
    c = plane[COLUMNS.c]
    cosine = plane[COLUMNS.cosine]
    sine = plane[COLUMNS.sine]
    for i in range(pairs + 1):
        x = q[i] - q0
        re[i] = a * x
        im[i] = b * x + c * (p[i] - p0)
    for i in range(pairs):
        x = re[i + 1] * re[i] + im[i + 1] * im[i]
        y = im[i + 1] * re[i] - re[i + 1] * im[i]
        angles[i] = angle_of(x * cosine + y * sine, y * cosine - x * sine)


@jit
def add_angles(weights, angles, pairs, sums):
    """Add to sums (SPANS,) the first `pairs` of angles with their weights (samples, SPANS), one after another, like the
    loops of maps.
    """
    a = sums[0]
    b = sums[1]
    c = sums[2]
    d = sums[3]
    e = sums[4]
    f = sums[5]
    for i in range(pairs):
        w = weights[i]
        angle = angles[i]
        a += w[0] * angle
        b += w[1] * angle
        c += w[2] * angle
        d += w[3] * angle
        e += w[4] * angle
        f += w[5] * angle
    sums[0] = a
    sums[1] = b
    sums[2] = c
    sums[3] = d
    sums[4] = e
    sums[5] = f


@jit
def add_moments(plane, q, p, begin, end, weights, moments):
    """Add to moments (MOMENTS,) those of the pairs of samples from begin to end, with their weights, one after another,
    like the loops of maps.
    """
    q0 = plane[COLUMNS.q]
    p0 = plane[COLUMNS.p]
    mq, mp, qq, qp, pp, tq, tp, uq, up = moments
    x, y = q[begin] - q0, p[begin] - p0
    for i in range(begin, end):
        w = weights[i]
        xx = q[i + 1] - q0
        yy = p[i + 1] - p0
        mq += w * x
        mp += w * y
        qq += w * (x * x)
        qp += w * (x * y)
        pp += w * (y * y)
        tq += w * (xx * x)
        tp += w * (xx * y)
        uq += w * (yy * x)
        up += w * (yy * y)
        x, y = xx, yy
    for k, value in enumerate((mq, mp, qq, qp, pp, tq, tp, uq, up)):
        moments[k] = value


class Frame(NamedTuple):
    """Weights (samples,) of the moments that determine frames, not 0 from begin to end."""

    weights: np.ndarray
    begin: int
    end: int


def turn_on(unit, stop, progress, chunk, until, last, planes, tables, frame, sums, moments):
    """Add the steps to the samples of chunk (rows, orbits, samples), the first from last (orbits, rows), to sums
    (orbits, n, SPANS) of angles and moments (orbits, n, MOMENTS); last becomes the last sample.

    until (orbits,): samples of each orbit; planes (orbits, n, COLUMNS.end); tables (samples, SPANS): weights of the
    angles, empty for none.
    """
    if read_now(stop, 0) > 0:
        return
    rows, orbits, samples = chunk.shape
    n = rows // 2
    first = unit * ORBITS
    count = min(ORBITS, orbits - first)
    room = np.empty((count, rows, SEGMENT + 1))
    re = np.empty(SEGMENT + 1)
    im = np.empty(SEGMENT + 1)
    angles = np.empty(SEGMENT)
    for start in range(0, samples, SEGMENT):
        size = min(SEGMENT, samples - start)
        gather(chunk, first, count, start, size, room)
        for o in range(count):
            orbit = first + o
            pairs = min(size, until[orbit] - start)
            if pairs > 0:
                for r in range(rows):
                    room[o, r, 0] = last[orbit, r]
                    last[orbit, r] = room[o, r, pairs]
                low = max(frame.begin - start, 0)
                high = min(frame.end - start, pairs)
                for i in range(n):
                    q = room[o, i]
                    p = room[o, n + i]
                    plane = planes[orbit, i]
                    if tables.shape[0] > 0:
                        step_angles(plane, q, p, pairs, re, im, angles)
                        add_angles(tables[start : start + size], angles, pairs, sums[orbit, i])
                    if high > low:
                        weights = frame.weights[start : start + size]
                        add_moments(plane, q, p, low, high, weights, moments[orbit, i])
    progress[unit] = 1.0


@jit
def unit_of(square):
    """Return the power of 2 that makes the root of a mean square about 1."""
    return math.ldexp(1.0, -(math.frexp(square)[1] // 2)) if 0.0 < square < math.inf else 1.0


def learn(unit, stop, progress, moments, weight, known, planes):
    """Set the planes (orbits, n, COLUMNS.end) of the orbits that are `known` (orbits,) by their moments (orbits, n,
    MOMENTS), with the sum of their weights.

    The loop is the circle of the linear motion with these moments; the reference is the mean of its steps.
    """
    if read_now(stop, 0) > 0:
        return
    for orbit in range(unit * ORBITS, min((unit + 1) * ORBITS, planes.shape[0])):
        for i in range(planes.shape[1] if known[orbit] else 0):
            plane = planes[orbit, i]
            m = moments[orbit, i]
            x_unit = unit_of(m[2] / weight)
            y_unit = unit_of(m[4] / weight)
            xx_unit = x_unit * x_unit
            xy_unit = x_unit * y_unit
            yy_unit = y_unit * y_unit
            q, p = m[0] / weight, m[1] / weight
            plane[COLUMNS.q] += q
            plane[COLUMNS.p] += p
            # In these units no product of two moments leaves the range of numbers; powers of 2 round nothing.
            q, p = q * x_unit, p * y_unit
            whole_x = m[2] / weight * xx_unit
            whole_y = m[4] / weight * yy_unit
            A = whole_x - q * q
            B = m[3] / weight * xy_unit - q * p
            D = whole_y - p * p
            moving = whole_x * 1e-30 < A and whole_y * 1e-30 < D
            area = A * D - B * B
            if not area > 1e-14 * A * D:
                area = A * D
                B = 0.0
            a = 1.0 / math.sqrt(A) if moving else 0.0
            b = a * B / math.sqrt(area) if moving else 0.0
            c = -math.sqrt(A / area) if moving else 0.0
            qq = m[5] / weight * xx_unit - q * q
            qp = m[6] / weight * xy_unit - q * p
            pq = m[7] / weight * xy_unit - q * p
            pp = m[8] / weight * yy_unit - p * p
            x = (a * a + b * b) * qq + b * c * (qp + pq) + c * c * pp
            y = a * c * (pq - qp)
            size = math.sqrt(x * x + y * y)
            plane[COLUMNS.a] = a * x_unit
            plane[COLUMNS.b] = b * x_unit
            plane[COLUMNS.c] = c * y_unit
            plane[COLUMNS.cosine], plane[COLUMNS.sine] = (x / size, y / size) if size > 0.0 else (1.0, 0.0)
            plane[COLUMNS.turn] = angle_of(x, y) / (2.0 * math.pi)
    progress[unit] = 1.0
