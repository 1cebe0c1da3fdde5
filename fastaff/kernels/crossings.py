"""Section crossings: detection at full steps, location on the scheme's own flow.

A record (a row of RECORD.state + rows numbers) holds what the location needs: the state at a step, its time, and the
range of fractional steps that contains the crossing. Location then turns the record, in place, into the crossing's time
and state.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compile.jit import LANES, jit, read_now, write_now
from ..compile.pointers import call_value
from .stepping import advance, load_lane, row, store_lane


class Record(NamedTuple):
    """Columns of a record: time, kind, lower and upper fractional step, the first one of the state; once located, the
    section function stands where the lower one was.
    """

    time: int = 0
    kind: int = 1
    lower: int = 2
    upper: int = 3
    state: int = 4
    residual: int = 2


RECORD = Record()

NOTHING, CERTAIN, LOWER, UPPER, LOCATED, RETURN = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
"""Kinds of record: empty; sign change over a step; first and second of a suspected pair within two steps; located
crossing; sign change over the first step of an orbit that starts on the section."""

BARELY = 5e-324
"""Size of the section function of a start on the section: only its sign counts, that of the function just after the
start.
"""


class Rows(NamedTuple):
    """Rows of observer memory: section function now, one and two steps ago; times one and two steps ago; records
    written, certain crossings among them; the first one of the state a step ago.
    """

    now: int = 0
    before: int = 1
    earlier: int = 2
    time_before: int = 3
    time_earlier: int = 4
    written: int = 5
    certain: int = 6
    state: int = 7


ROWS = Rows()


@jit
def dips(earlier, before, now, first, second):
    """Tell whether a parabola through three values of one sign, `first` and `second` apart, may reach zero beside the
    middle one.

    The middle one is the nearest to zero; with equal distances h and curvature c the parabola goes at most c h^2/8
    deeper, which is taken twice.
    """
    if not (abs(before) < abs(now) and abs(before) <= abs(earlier) and before * now > 0.0 and before * earlier > 0.0):
        return False
    bend = 2.0 * ((now - before) / second - (before - earlier) / first) / (first + second)
    return 4.0 * abs(before) <= abs(bend) * max(first, second) ** 2


@jit(inline=True)
def detect(value, calls, rows, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: record sign changes of the section function, which the call gives, and extrema near zero.

    memory (ROWS.state + rows)*LANES. An orbit is done when value.wanted certain crossings are found or the record is
    full. Returns how many lanes became done.
    """
    call_value(calls, 0, lanes, z, row(memory, ROWS.now))
    width = RECORD.state + rows
    slots = out.shape[1] // width
    ended = 0
    for i in range(lanes):
        if fresh[i] == 0.0:
            continue
        now, before = memory[ROWS.now * LANES + i], memory[ROWS.before * LANES + i]
        earlier = memory[ROWS.earlier * LANES + i]
        rises, falls = before < 0.0 and now >= 0.0, before > 0.0 and now <= 0.0
        crossed = (rises and value.direction >= 0.0) or (falls and value.direction <= 0.0)
        t1, t2 = memory[ROWS.time_before * LANES + i], memory[ROWS.time_earlier * LANES + i]
        paired = dips(earlier, before, now, t1 - t2, t[i] - t1)
        if crossed or paired:
            slot = int(memory[ROWS.written * LANES + i])
            o = orbit[i]
            first, last = (CERTAIN, CERTAIN) if crossed else (LOWER, UPPER)
            if crossed and abs(before) == BARELY:
                first, last = RETURN, RETURN
            for kind in range(int(first), int(last) + 1):
                c = slot * width
                out[o, c + RECORD.time], out[o, c + RECORD.kind] = t1, kind
                out[o, c + RECORD.lower] = 0.0 if crossed else t2 - t1
                out[o, c + RECORD.upper] = t[i] - t1
                for r in range(rows):
                    out[o, c + RECORD.state + r] = memory[(ROWS.state + r) * LANES + i]
                slot += 1
            memory[ROWS.written * LANES + i] = slot
            if crossed:
                memory[ROWS.certain * LANES + i] += 1.0
            if memory[ROWS.certain * LANES + i] >= value.wanted or slot + 2 > slots:
                done[i] = 1.0
                ended += 1
        memory[ROWS.earlier * LANES + i], memory[ROWS.before * LANES + i] = before, now
        memory[ROWS.time_earlier * LANES + i], memory[ROWS.time_before * LANES + i] = t1, t[i]
        for r in range(rows):
            memory[(ROWS.state + r) * LANES + i] = z[r * LANES + i]
    return ended


@jit
def chandrupatla(x1, f1, x2, f2, x3, f3):
    """Return the next fraction of the bracket [x1, x2]: inverse quadratic interpolation where it is safe, else 1/2.

    Chandrupatla 1997, Adv. Eng. Software 28, 145.
    """
    xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
    if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
        return f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
    return 0.5


@jit
def fractional(
    stage, derivative, section, params, section_params, drift, kick, a, b, rows, lanes, start, tau, z, k, work, f
):
    """Set z to the state a fractional step tau[i] after start, and f to the section function there."""
    for j in range(rows * LANES):
        z[j] = start[j]
    for j in range(rows * LANES, z.size):
        z[j] = 0.0
    advance(stage, derivative, params, drift, kick, a, b, rows, lanes, tau, z, k, work)
    section(section_params, lanes, z, f)


@jit
def split_pairs(
    stage, derivative, section, params, section_params, drift, kick, a, b, rows, lanes, start, kind, x1, x2, z, k, work
):
    """Halve the bracket of each suspected pair at the extremum of the section function; other lanes are untouched.

    Golden sections, until a point of the other sign is found or the extremum is known to rounding. Returns how many
    there are.
    """
    pairs = 0
    for i in range(lanes):
        pairs += 1 if kind[i] == LOWER or kind[i] == UPPER else 0
    if pairs == 0:
        return pairs
    low, high, inner, found = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    tau, value, f = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    for i in range(lanes):
        low[i], high[i] = x1[i], x2[i]
    fractional(
        stage,
        derivative,
        section,
        params,
        section_params,
        drift,
        kick,
        a,
        b,
        rows,
        lanes,
        start,
        inner,
        z,
        k,
        work,
        value,
    )
    for _ in range(60):
        for i in range(lanes):
            right = high[i] - inner[i] > inner[i] - low[i]
            tau[i] = inner[i] + 0.3819660112501051 * ((high[i] if right else low[i]) - inner[i])
        fractional(
            stage,
            derivative,
            section,
            params,
            section_params,
            drift,
            kick,
            a,
            b,
            rows,
            lanes,
            start,
            tau,
            z,
            k,
            work,
            f,
        )
        searching = 0
        for i in range(lanes):
            if (kind[i] != LOWER and kind[i] != UPPER) or found[i] > 0.0:
                continue
            searching += 1
            later = tau[i] > inner[i]
            if value[i] * f[i] < 0.0:
                inner[i], found[i] = tau[i], 1.0
            elif abs(f[i]) < abs(value[i]):
                if later:
                    low[i] = inner[i]
                else:
                    high[i] = inner[i]
                inner[i], value[i] = tau[i], f[i]
            elif later:
                high[i] = tau[i]
            else:
                low[i] = tau[i]
        if searching == 0:
            break
    for i in range(lanes):
        if kind[i] == LOWER:
            x2[i] = inner[i]
        elif kind[i] == UPPER:
            x1[i] = inner[i]
    return pairs


@jit
def leave_section(
    stage, derivative, section, params, section_params, drift, kick, a, b, rows, lanes, start, kind, x1, x2, z, k, work
):
    """Move the lower end of the first steps of orbits that start on the section off it, to where the function has left
    it.

    Towards the start until the function has not the sign that it has at the upper end; where it never has, the record
    becomes empty.
    """
    returns = 0
    for i in range(lanes):
        returns += 1 if kind[i] == RETURN else 0
    if returns == 0:
        return returns
    tau, f, last, found = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    for i in range(lanes):
        tau[i] = x2[i]
    for sweep in range(90):
        fractional(
            stage,
            derivative,
            section,
            params,
            section_params,
            drift,
            kick,
            a,
            b,
            rows,
            lanes,
            start,
            tau,
            z,
            k,
            work,
            f,
        )
        searching = 0
        for i in range(lanes):
            if kind[i] != RETURN or found[i] > 0.0:
                continue
            if sweep == 0:
                last[i] = f[i]
            elif f[i] * last[i] < 0.0:
                x1[i], found[i] = tau[i], 1.0
                continue
            tau[i] *= 0.7
            searching += 1
        if searching == 0:
            break
    for i in range(lanes):
        if kind[i] == RETURN and found[i] == 0.0:
            kind[i] = NOTHING
    return returns


def shift(block, stop, progress, stage, derivative, params, drift, kick, a, b, precise, tau, table):
    """Advance the columns of table (rows, orbits) of a block by one step of tau[orbit] each."""
    rows, orbits = table.shape
    first = block * LANES
    lanes = min(LANES, orbits - first) if read_now(stop, 0) == 0 else 0
    z, k = np.zeros((3 if precise else 1) * rows * LANES), np.empty(b.size * rows * LANES)
    step, work = np.zeros(LANES), np.empty(rows * LANES)
    for i in range(lanes):
        load_lane(table, first + i, z, i)
        step[i] = tau[first + i]
    advance(stage, derivative, params, drift, kick, a, b, rows, lanes, step, z, k, work)
    for i in range(lanes):
        store_lane(z, i, table, first + i)
    write_now(progress, block, lanes)


def locate(
    block,
    stop,
    progress,
    stage,
    derivative,
    section,
    params,
    section_params,
    drift,
    kick,
    a,
    b,
    direction,
    precise,
    rows,
    records,
    where,
):
    """Turn the records numbered `where` (rows of `records`) into crossings: root of the section function on the flow.

    All lanes iterate together, each in its own bracket, until the bracket, or the function beside its change over the
    step, is as small as rounding. A suspected pair is first split at the extremum of the section function, a return to
    the section left by a step off it; where there is no other sign, or the wrong direction, the record becomes empty.
    Afterwards a record holds time, kind, section function and state.
    """
    count = where.size
    size = rows * LANES
    first = block * LANES
    lanes = min(LANES, count - first) if read_now(stop, 0) == 0 else 0
    start, z, work, k = np.zeros(size), np.empty(3 * size if precise else size), np.empty(size), np.empty(b.size * size)
    x1, x2, x3, tau = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    f1, f2, f3, f = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    kind, live, resolution, flat = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    for i in range(lanes):
        o = where[first + i]
        kind[i] = records[o, RECORD.kind]
        x1[i], x2[i] = records[o, RECORD.lower], records[o, RECORD.upper]
        for r in range(rows):
            start[r * LANES + i] = records[o, RECORD.state + r]
    pairs = split_pairs(
        stage,
        derivative,
        section,
        params,
        section_params,
        drift,
        kick,
        a,
        b,
        rows,
        lanes,
        start,
        kind,
        x1,
        x2,
        z,
        k,
        work,
    )
    pairs += leave_section(
        stage,
        derivative,
        section,
        params,
        section_params,
        drift,
        kick,
        a,
        b,
        rows,
        lanes,
        start,
        kind,
        x1,
        x2,
        z,
        k,
        work,
    )
    section(section_params, lanes, start, f1)
    if pairs > 0:
        fractional(
            stage,
            derivative,
            section,
            params,
            section_params,
            drift,
            kick,
            a,
            b,
            rows,
            lanes,
            start,
            x1,
            z,
            k,
            work,
            f1,
        )
    fractional(
        stage, derivative, section, params, section_params, drift, kick, a, b, rows, lanes, start, x2, z, k, work, f2
    )
    for i in range(lanes):
        if kind[i] > CERTAIN and (f1[i] * f2[i] > 0.0 or (f2[i] - f1[i]) * direction < 0.0):
            kind[i] = NOTHING
        live[i] = 1.0 if kind[i] != NOTHING and f1[i] * f2[i] < 0.0 else 0.0
        resolution[i], flat[i] = 1.2e-16 * abs(x2[i] - x1[i]), 1.2e-16 * abs(f2[i] - f1[i])
        x3[i], f3[i] = x1[i], f1[i]
        tau[i] = x1[i] + (x2[i] - x1[i]) * (f1[i] / (f1[i] - f2[i]) if live[i] > 0.0 else 0.5)
    active, sweeps = lanes, 0
    while active > 0 and sweeps < 100:
        active, sweeps = 0, sweeps + 1
        fractional(
            stage,
            derivative,
            section,
            params,
            section_params,
            drift,
            kick,
            a,
            b,
            rows,
            lanes,
            start,
            tau,
            z,
            k,
            work,
            f,
        )
        for i in range(lanes):
            if live[i] == 0.0:
                continue
            if (f[i] > 0.0) == (f1[i] > 0.0):
                x3[i], f3[i] = x1[i], f1[i]
            else:
                x3[i], f3[i] = x2[i], f2[i]
                x2[i], f2[i] = x1[i], f1[i]
            x1[i], f1[i] = tau[i], f[i]
            width = abs(x2[i] - x1[i])
            if abs(f[i]) <= flat[i] or width <= 2.0 * resolution[i]:
                live[i] = 0.0
                continue
            active += 1
            least = resolution[i] / width
            fraction = chandrupatla(x1[i], f1[i], x2[i], f2[i], x3[i], f3[i])
            tau[i] = x1[i] + min(max(fraction, least), 1.0 - least) * (x2[i] - x1[i])
    for i in range(lanes):
        tau[i] = x1[i] if abs(f1[i]) <= abs(f2[i]) else x2[i]
    fractional(
        stage, derivative, section, params, section_params, drift, kick, a, b, rows, lanes, start, tau, z, k, work, f
    )
    for i in range(lanes):
        o = where[first + i]
        records[o, RECORD.time] += tau[i]
        records[o, RECORD.kind] = NOTHING if kind[i] == NOTHING else LOCATED
        records[o, RECORD.residual] = f[i]
        for r in range(rows):
            records[o, RECORD.state + r] = z[r * LANES + i]
    write_now(progress, block, lanes)


@jit
def compact(rows, out, counts):
    """Keep the located records of each orbit's row, without gaps, NaN after them; counts (orbits,) becomes their
    number.
    """
    width = RECORD.state + rows
    for o in range(out.shape[0]):
        kept = 0
        for slot in range(counts[o]):
            if out[o, slot * width + RECORD.kind] == LOCATED:
                if kept != slot:
                    out[o, kept * width : (kept + 1) * width] = out[o, slot * width : (slot + 1) * width]
                kept += 1
        out[o, kept * width : counts[o] * width] = np.nan
        counts[o] = kept
