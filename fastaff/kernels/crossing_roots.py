"""Location of section crossings: the root of each record's bracket on the scheme's own flow."""

from __future__ import annotations

import numpy as np

from ..compile.jit import LANES, jit, read_now, write_now
from ..compile.pointers import call
from .crossings import CERTAIN, LOCATED, LOWER, NOTHING, RECORD, RETURN, UPPER
from .stepping import advance, load_lane, move_lane, room, row, store_lane

SEARCHING, FOUND, HERE = 0.0, 1.0, 2.0
"""What a lane's next fractional step is: one on the way to the root, the root; or the root is where it is now."""
FINE, NOISE, SWEEPS = 2.5e-16, 1e-12, 100
"""Beside the first bracket: a correction that is nothing; one that is rounding where the function stops to fall. Most
fractional steps for a root.
"""
USUAL, SLOW = 8, 60
"""Fractional steps that a root mostly takes, and the extremum between two."""
BRACKET = 10
"""Rows of numbers that a lane's search takes with it."""


@jit
def chandrupatla(x1, f1, x2, f2, x3, f3):
    """Return the next fraction of the bracket [x1, x2]: inverse quadratic interpolation where it is safe, else 1/2.

    Chandrupatla 1997, Adv. Eng. Software 28, 145.
    """
    xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
    if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
        return f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
    return 0.5


@jit(inline=True)
def narrowed(i, x1, f1, x2, f2, x3, f3, tau, f, whole, last, sweeps):
    """Put the section function f at tau[i] into lane i's bracket; return what its next fractional step is, set in tau.

    The search ends where its next correction is nothing beside the first bracket `whole`, or where rounding keeps the
    function from falling: at the last of its points with the smallest value.
    """
    if (f > 0.0) == (f1[i] > 0.0):
        x3[i], f3[i] = x1[i], f1[i]
    else:
        x3[i], f3[i] = x2[i], f2[i]
        x2[i], f2[i] = x1[i], f1[i]
    x1[i], f1[i] = tau[i], f
    width = abs(x2[i] - x1[i])
    fraction = chandrupatla(x1[i], f1[i], x2[i], f2[i], x3[i], f3[i])
    change = abs(f1[i] / (f2[i] - f1[i])) * width
    settled = change <= FINE * whole or (change <= NOISE * whole and abs(f) > 0.5 * last[i])
    last[i] = abs(f)
    if settled or width <= 2.4e-16 * whole or sweeps >= SWEEPS:
        if abs(f1[i]) <= min(abs(f2[i]), abs(f3[i])):
            return HERE
        tau[i] = x2[i] if abs(f2[i]) <= abs(f3[i]) else x3[i]
        return FOUND
    least = 1.2e-16 * whole / width
    tau[i] = x1[i] + min(max(fraction, least), 1.0 - least) * (x2[i] - x1[i])
    return SEARCHING


@jit
def fractional(flow, lanes, start, tau, z, k, work, f):
    """Set z to the state a fractional step tau[i] after start, and f to the section function there.

    flow: the blocks of the model, the coefficients of the scheme, the bound section, the rows of a state.
    """
    blocks, scheme, section, rows = flow
    for j in range(rows * LANES):
        z[j] = start[j]
    for j in range(rows * LANES, z.size):
        z[j] = 0.0
    advance(blocks, scheme, rows, lanes, tau, 1, z, k, work)
    call(section.function, section.parameters, lanes, z, f)


@jit
def split_pairs(flow, lanes, start, kind, x1, x2, z, k, work):
    """Halve the bracket of each suspected pair at the extremum of the section function; other lanes are untouched.

    Golden sections, until a point of the other sign is found or the extremum is known to rounding.
    """
    pairs = 0
    for i in range(lanes):
        pairs += 1 if kind[i] == LOWER or kind[i] == UPPER else 0
    if pairs == 0:
        return
    low, high, inner, found = room(1), room(1), room(1), room(1)
    tau, value, f = room(1), room(1), room(1)
    for i in range(lanes):
        low[i], high[i] = x1[i], x2[i]
    fractional(flow, lanes, start, inner, z, k, work, value)
    for _ in range(60):
        for i in range(lanes):
            right = high[i] - inner[i] > inner[i] - low[i]
            tau[i] = inner[i] + 0.3819660112501051 * ((high[i] if right else low[i]) - inner[i])
        fractional(flow, lanes, start, tau, z, k, work, f)
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


@jit
def leave_section(flow, lanes, start, kind, x1, x2, z, k, work):
    """Move the lower end of the first steps of orbits that start on the section off it, to where the function has left
    it.

    Towards the start until the function has not the sign that it has at the upper end; where it never has, the record
    becomes empty.
    """
    returns = 0
    for i in range(lanes):
        returns += 1 if kind[i] == RETURN else 0
    if returns == 0:
        return
    tau, f, last, found = room(1), room(1), room(1), room(1)
    for i in range(lanes):
        tau[i] = x2[i]
    for sweep in range(90):
        fractional(flow, lanes, start, tau, z, k, work, f)
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


def shift(unit, stop, progress, blocks, scheme, tau, table):
    """Advance the columns of table (rows, orbits) of a block by one step of tau[orbit] each."""
    rows, orbits = table.shape
    first = unit * LANES
    lanes = min(LANES, orbits - first) if read_now(stop, 0) == 0 else 0
    z, k = room(scheme.copies * rows + scheme.spare), room(scheme.b.size * rows)
    step, work = room(1), room(rows)
    for i in range(lanes):
        load_lane(table, first + i, z, i)
        step[i] = tau[first + i]
    advance(blocks, scheme, rows, lanes, step, 1, z, k, work)
    for i in range(lanes):
        store_lane(z, i, table, first + i)
    write_now(progress, unit, lanes)


def bracket(unit, stop, progress, blocks, scheme, section, records, where):
    """Narrow the brackets of the records numbered `where` that are no certain crossings, in place: a suspected pair is
    split at the extremum of the section function, a return to the section left by a step off it.
    """
    count, rows = where.size, records.shape[1] - RECORD.state
    first = unit * LANES
    lanes = min(LANES, count - first) if read_now(stop, 0) == 0 else 0
    z, work, k = room(scheme.copies * rows + scheme.spare), room(rows), room(scheme.b.size * rows)
    start, kind, x1, x2 = room(rows), room(1), room(1), room(1)
    for i in range(lanes):
        record = records[where[first + i]]
        kind[i], x1[i], x2[i] = record[RECORD.kind], record[RECORD.lower], record[RECORD.upper]
        for r in range(rows):
            start[r * LANES + i] = record[RECORD.state + r]
    flow = blocks, scheme, section, rows
    split_pairs(flow, lanes, start, kind, x1, x2, z, k, work)
    leave_section(flow, lanes, start, kind, x1, x2, z, k, work)
    for i in range(lanes):
        record = records[where[first + i]]
        record[RECORD.kind], record[RECORD.lower], record[RECORD.upper] = kind[i], x1[i], x2[i]
    write_now(progress, unit, lanes)


def locate(unit, stop, progress, blocks, scheme, section, direction, records, where):
    """Turn the records numbered `where` (rows of `records`) into crossings: root of the section function on the flow.

    Every lane has a bracket of its own, see `bracket` for those that are not certain, and lanes that have converged
    make room. Where there is no other sign, or the wrong direction, the record becomes empty. Afterwards a record holds
    time, kind, section function and state.
    """
    count, rows = where.size, records.shape[1] - RECORD.state
    size = rows * LANES
    first = unit * LANES
    lanes = min(LANES, count - first) if read_now(stop, 0) == 0 else 0
    z, work, k = room(scheme.copies * rows + scheme.spare), room(rows), room(scheme.b.size * rows)
    own = room(rows + BRACKET)
    start = own[:size]
    x1, x2, x3 = row(own, rows), row(own, rows + 1), row(own, rows + 2)
    f1, f2, f3 = row(own, rows + 3), row(own, rows + 4), row(own, rows + 5)
    tau, whole, last, live = row(own, rows + 6), row(own, rows + 7), row(own, rows + 8), row(own, rows + 9)
    kind, f, number, doubtful = room(1), room(1), np.zeros(LANES, np.int64), 0
    for i in range(lanes):
        o = where[first + i]
        number[i], kind[i] = o, records[o, RECORD.kind]
        x1[i], x2[i] = 0.0 if kind[i] == CERTAIN else records[o, RECORD.lower], records[o, RECORD.upper]
        f2[i] = records[o, RECORD.beyond]
        doubtful += 0 if kind[i] == CERTAIN else 1
        for r in range(rows):
            start[r * LANES + i] = records[o, RECORD.state + r]
    flow = blocks, scheme, section, rows
    call(section.function, section.parameters, lanes, start, f1)
    if doubtful > 0:
        fractional(flow, lanes, start, x1, z, k, work, f1)
        fractional(flow, lanes, start, x2, z, k, work, f)
        for i in range(lanes):
            f2[i] = f2[i] if kind[i] == CERTAIN else f[i]
    for i in range(lanes):
        whole[i] = abs(x2[i] - x1[i])
        if kind[i] > CERTAIN and (f1[i] * f2[i] > 0.0 or (f2[i] - f1[i]) * direction < 0.0):
            kind[i] = NOTHING
        x3[i], f3[i], last[i] = x1[i], f1[i], np.inf
        if f1[i] * f2[i] < 0.0:
            live[i] = SEARCHING
            tau[i] = x1[i] + (x2[i] - x1[i]) * (f1[i] / (f1[i] - f2[i]))
        else:
            live[i] = FOUND
            tau[i] = x1[i] if abs(f1[i]) <= abs(f2[i]) else x2[i]
    sweeps = 0
    while lanes > 0:
        sweeps += 1
        fractional(flow, lanes, start, tau, z, k, work, f)
        i = 0
        while i < lanes:
            if live[i] == SEARCHING:
                live[i] = narrowed(i, x1, f1, x2, f2, x3, f3, tau, f[i], whole[i], last, sweeps)
                if live[i] != HERE:
                    i += 1
                    continue
            o = number[i]
            records[o, RECORD.time] += tau[i]
            records[o, RECORD.kind] = NOTHING if kind[i] == NOTHING else LOCATED
            records[o, RECORD.residual] = f[i]
            for r in range(rows):
                records[o, RECORD.state + r] = z[r * LANES + i]
            lanes -= 1
            move_lane(rows + BRACKET, lanes, i, own)
            number[i], kind[i], f[i] = number[lanes], kind[lanes], f[lanes]
            move_lane(rows, lanes, i, z)
    write_now(progress, unit, min(LANES, count - first))


@jit
def compact(rows, out, counts, limit, unlocated):
    """Keep the records of each orbit's row that are located, after the start and up to its limit (orbits,), without
    gaps, NaN after them; counts (orbits,) becomes their number. unlocated (orbits,) tells where some are left.
    """
    width = RECORD.state + rows
    for o in range(out.shape[0]):
        kept = 0
        for slot in range(counts[o]):
            time, kind = out[o, slot * width + RECORD.time], out[o, slot * width + RECORD.kind]
            unlocated[o] |= kind != LOCATED and kind != NOTHING
            if kind == LOCATED and time > 0.0 and time <= limit[o]:
                if kept != slot:
                    for c in range(width):  # from slice to slice takes 1.5 s to compile, most of it for an error's text
                        out[o, kept * width + c] = out[o, slot * width + c]
                kept += 1
        for c in range(kept * width, counts[o] * width):
            out[o, c] = np.nan
        counts[o] = kept
