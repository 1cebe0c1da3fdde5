"""Section crossings: detection at full steps; `crossing_roots` locates them on the scheme's own flow.

A record (a row of RECORD.state + rows numbers) holds the data for the location: the state at a step, its time, and the
range of fractional steps that contains the crossing. Location then turns the record, in place, into the crossing's time
and state.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..jit import LANES, jit
from ..lane_flags import FLAGS, flags, lowest
from ..pointers import call_value
from .stepping import row


class Record(NamedTuple):
    """Columns of a record: time, kind, lower and upper fractional step, the first one of the state.

    Certain crossings begin at step 0: their column of the lower end holds the section function at the upper end, and
    after location that of the crossing. An unwritten record may hold the earliest and latest time of the same crossing
    in another run.
    """

    time: int = 0
    kind: int = 1
    lower: int = 2
    upper: int = 3
    state: int = 4
    beyond: int = 2
    residual: int = 2
    earliest: int = 2
    latest: int = 3


RECORD = Record()

NOTHING = 0.0
"""Kind of record: empty."""

CERTAIN = 1.0
"""Kind of record: sign change over a step."""

LOWER = 2.0
"""Kind of record: first of a suspected pair within two steps."""

UPPER = 3.0
"""Kind of record: second of a suspected pair within two steps."""

LOCATED = 4.0
"""Kind of record: located crossing."""

RETURN = 5.0
"""Kind of record: sign change over the first step of an orbit that starts on the section."""

BETWEEN = 6.0
"""Kind of record: suspected sign change between two fractional steps, beside or around a step where the function is
zero.
"""

ASIDE = 2.0**-10
"""Fractional step beside a step where the section function is zero, at which its sign is looked at: a root of order
four leaves 1e-12 of the function there, which is no rounding yet. Other roots nearer than this are not told apart."""

ROUNDED = 1e-11
"""Section function, beside its size at the steps before, that counts as zero: rounding may decide its sign, and signs
beside the step tell the same.
"""

FADING = 0.5
"""Factor by which this size falls from step to step where the function is small."""

RESTING = 16
"""Successive steps at which the function is zero, after which the orbit runs in the section and has no crossings."""


FEW = 4
"""A block is copied whole if at least 1/FEW of it is filled."""


BARELY = 5e-324
"""Size of the section function of a start on the section: only its sign counts, which is that just after the
start.
"""


PARTED = np.inf
"""Number of certain crossings of an orbit that is done because it has diverged from another run."""


class CrossingRows(NamedTuple):
    """Rows of observer memory: section function now, one and two steps ago; times one and two steps ago; records
    written, certain crossings among them, or PARTED; whether there is news; successive steps at which the function was
    zero; its size at the steps before; the first row of the state a step ago.
    """

    now: int = 0
    before: int = 1
    earlier: int = 2
    time_before: int = 3
    time_earlier: int = 4
    written: int = 5
    certain: int = 6
    news: int = 7
    zeros: int = 8
    size: int = 9
    state: int = 10


ROWS = CrossingRows()


def may_touch_zero(earlier, before, now, first, second):
    """Tell whether a parabola through three values of one sign, at distances `first` and `second`, may reach zero near
    the middle one; numbers or arrays.

    The middle one is the nearest to zero; with equal distances h and curvature c the parabola goes at most c h^2/8
    deeper; twice that is allowed.
    """
    nearest = (abs(before) < abs(now)) & (abs(before) <= abs(earlier)) & (before * now > 0.0) & (before * earlier > 0.0)
    bend = 2.0 * ((now - before) / second - (before - earlier) / first) / (first + second)
    return nearest & (4.0 * abs(before) <= abs(bend) * np.maximum(first, second) ** 2)


_dips = jit(may_touch_zero)


@jit
def has_news(most, direction, earlier, before, now):
    """Tell whether an orbit has passed the section over the last step, in the direction that counts, was on it at an
    end of that step, or was nearest to it at the beginning of that step, on one side: `may_touch_zero` then tells
    whether there may be a pair of crossings.

    A function of an angle jumps between two sections by more than `most`: a jump is no crossing.
    """
    rises = (before < 0.0) & (now > 0.0)
    falls = (before > 0.0) & (now < 0.0)
    changed = (rises & (direction >= 0.0)) | (falls & (direction <= 0.0)) | (now == 0.0) | (before == 0.0)
    nearest = (abs(before) < abs(now)) & (abs(before) <= abs(earlier)) & (before * now > 0.0) & (before * earlier > 0.0)
    return (changed & (abs(now - before) <= most)) | nearest


@jit(inline=True)
def detect(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: record sign changes of the section function, by the call, and extrema near zero.

    memory (ROWS.state + rows)*LANES. An orbit is done when value.wanted certain crossings are found, the record is full
    or it has diverged from another run. Returns the number of lanes that became done.
    """
    rows = int(value.rows)
    call_value(calls, 0, lanes, z, row(memory, ROWS.now))
    news = row(memory, ROWS.news)
    moved = 0
    ended = 0
    for i in range(lanes):  # loops without branches become vector instructions
        earlier = memory[ROWS.earlier * LANES + i]
        before = memory[ROWS.before * LANES + i]
        now = memory[ROWS.now * LANES + i]
        seen = fresh[i] != 0.0
        size = memory[ROWS.size * LANES + i]
        now = 0.0 if abs(now) <= ROUNDED * size else now
        memory[ROWS.size * LANES + i] = max(abs(now), FADING * size) if seen else size
        found = has_news(value.most, value.direction, earlier, before, now) & seen
        news[i] = 1.0 if found else 0.0
        moved += 1 if seen else 0
        memory[ROWS.now * LANES + i] = earlier  # for the records of this step
        memory[ROWS.earlier * LANES + i] = before if seen else earlier
        memory[ROWS.before * LANES + i] = now if seen else before
    for i in range(lanes, LANES):
        news[i] = 0.0
    for first in range(0, LANES, FLAGS):
        left = flags(news, first)
        while left != 0:
            i = first + lowest(left)
            left &= left - 1
            seen = memory[ROWS.now * LANES + i], memory[ROWS.earlier * LANES + i], memory[ROWS.before * LANES + i]
            times = memory[ROWS.time_earlier * LANES + i], memory[ROWS.time_before * LANES + i], t[i]
            if write_records(value, rows, i, orbit[i], seen, times, ROWS.state * LANES + i, memory, memory, out):
                done[i] = 1.0
                ended += 1
    if moved == lanes:
        for i in range(lanes):
            memory[ROWS.time_earlier * LANES + i] = memory[ROWS.time_before * LANES + i]
            memory[ROWS.time_before * LANES + i] = t[i]
        if FEW * lanes >= LANES:
            for j in range(rows * LANES):
                memory[ROWS.state * LANES + j] = z[j]
            return ended
    for i in range(lanes):
        if fresh[i] > 0.0:
            if moved < lanes:
                memory[ROWS.time_earlier * LANES + i] = memory[ROWS.time_before * LANES + i]
                memory[ROWS.time_before * LANES + i] = t[i]
            for r in range(rows):
                memory[(ROWS.state + r) * LANES + i] = z[r * LANES + i]
    return ended


@jit
def write_records(value, rows, i, o, seen, times, first, states, memory, out):
    """Record the crossing, or suspected ones, of orbit o, in lane i, by three steps with these section functions and
    times, and the state at the middle one, from the place `first` of the states on; return whether that has ended the
    orbit.
    """
    width = RECORD.state + rows
    earlier, before, now = seen
    smooth = abs(now - before) <= value.most
    if now == 0.0 or before == 0.0:
        return smooth and write_around_zeros(rows, i, o, before, now, times, first, states, memory, out)
    rises = before < 0.0 and now > 0.0 and smooth
    falls = before > 0.0 and now < 0.0 and smooth
    crossed = (rises and value.direction >= 0.0) or (falls and value.direction <= 0.0)
    t2, t1, t = times
    if not (crossed or _dips(earlier, before, now, t1 - t2, t - t1)):
        return False
    slot = int(memory[ROWS.written * LANES + i])
    if crossed and value.beside > 0.0:  # else its own place, which is not in the cache, is only written
        # Suspected pairs may be crossings: the number of this one is at most the slot's, without pairs it is equal.
        sure = memory[ROWS.certain * LANES + i] == slot
        c = slot * width
        if t1 > out[o, c + RECORD.latest] or (sure and t < out[o, c + RECORD.earliest]):
            memory[ROWS.certain * LANES + i] = PARTED
            return True
    least, last = (CERTAIN, CERTAIN) if crossed else (LOWER, UPPER)
    if crossed and abs(before) == BARELY:
        least = RETURN
        last = RETURN
    for kind in range(int(least), int(last) + 1):
        c = slot * width
        out[o, c + RECORD.time] = t1
        out[o, c + RECORD.kind] = kind
        out[o, c + RECORD.lower] = now if kind == CERTAIN else 0.0 if crossed else t2 - t1
        out[o, c + RECORD.upper] = t - t1
        for r in range(rows):
            out[o, c + RECORD.state + r] = states[first + r * LANES]
        slot += 1
    memory[ROWS.written * LANES + i] = slot
    if crossed:
        memory[ROWS.certain * LANES + i] += 1.0
    return memory[ROWS.certain * LANES + i] >= value.wanted or slot + 2 > out.shape[1] // width


@jit
def write_around_zeros(rows, i, o, before, now, times, first, states, memory, out):
    """Record suspected crossings of orbit o, in lane i, over a step at an end of which the section function is zero:
    one within the step and one at its end; return whether that has filled the record.

    A zero has no sign: it is a crossing where the signs a little before and after it differ, and a sign change within
    the step is between signs a little within it.
    """
    width = RECORD.state + rows
    slot = int(memory[ROWS.written * LANES + i])
    _, t1, t = times
    zeros = memory[ROWS.zeros * LANES + i] + 1.0 if now == 0.0 else 0.0
    memory[ROWS.zeros * LANES + i] = zeros
    if zeros > RESTING:
        return False
    begin = ASIDE if before == 0.0 or abs(before) == BARELY else 0.0
    end = 1.0 - ASIDE if now == 0.0 else 1.0
    for k in range(2 if now == 0.0 else 1):
        c = slot * width
        out[o, c + RECORD.time] = t1
        out[o, c + RECORD.kind] = BETWEEN
        out[o, c + RECORD.lower] = (begin if k == 0 else end) * (t - t1)
        out[o, c + RECORD.upper] = (end if k == 0 else 1.0 + ASIDE) * (t - t1)
        for r in range(rows):
            out[o, c + RECORD.state + r] = states[first + r * LANES]
        slot += 1
    memory[ROWS.written * LANES + i] = slot
    return slot + 2 > out.shape[1] // width


@jit(inline=True)
def detect_along(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer of `lanes` successive states of one orbit: the same records, memory and end as `detect` at each."""
    rows = int(value.rows)
    # section functions from two steps before the first state on
    own = z[rows * LANES :]
    hits = 0
    own[0] = memory[ROWS.earlier * LANES]
    own[1] = memory[ROWS.before * LANES]
    call_value(calls, 0, lanes, z, own[2 : 2 + LANES])
    news = row(memory, ROWS.news)
    size = memory[ROWS.size * LANES]
    for s in range(lanes):
        own[s + 2] = 0.0 if abs(own[s + 2]) <= ROUNDED * size else own[s + 2]
        size = max(abs(own[s + 2]), FADING * size)
        found = has_news(value.most, value.direction, own[s], own[s + 1], own[s + 2])
        news[hits] = s
        hits += 1 if found else 0
    taken = lanes
    for k in range(hits):
        s = int(news[k])
        t1 = t[s - 1] if s > 0 else memory[ROWS.time_before * LANES]
        t2 = t[s - 2] if s > 1 else memory[(ROWS.time_before if s == 1 else ROWS.time_earlier) * LANES]
        first, states = (s - 1, z) if s > 0 else (ROWS.state * LANES, memory)
        seen = (own[s], own[s + 1], own[s + 2])
        times = (t2, t1, t[s])
        if write_records(value, rows, 0, orbit[0], seen, times, first, states, memory, out):
            taken = s + 1
            done[0] = s + 1.0
            break
    memory[ROWS.earlier * LANES] = own[taken]
    memory[ROWS.before * LANES] = own[taken + 1]
    memory[ROWS.size * LANES] = size
    memory[ROWS.time_earlier * LANES] = t[taken - 2] if taken > 1 else memory[ROWS.time_before * LANES]
    memory[ROWS.time_before * LANES] = t[taken - 1]
    for r in range(rows):
        memory[(ROWS.state + r) * LANES] = z[r * LANES + taken - 1]
    return 1 if taken < lanes or done[0] > 0.0 else 0
