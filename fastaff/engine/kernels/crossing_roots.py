"""Location of section crossings: the root of each record's bracket on the scheme's own flow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..jit import LANES, jit, read_now, write_now
from ..pointers import call
from .crossings import CERTAIN, LOCATED, LOWER, NOTHING, RECORD, RETURN, UPPER
from .stepping import advance, aligned_zeros, filled, load_lane, move_lane, row, store_lane

SEARCHING = 0.0
"""Kind of a lane's next fractional step: on the way to the root."""

FOUND = 1.0
"""Kind of a lane's next fractional step: at the root."""

HERE = 2.0
"""Kind of a lane's next fractional step: none, the root is at the present one."""

FINE = 2.5e-16
"""Correction relative to the first bracket that counts as 0."""

NOISE = 1e-12
"""Correction relative to the first bracket that is rounding if the function no longer falls."""

SWEEPS = 100
"""Most fractional steps for a root."""

USUAL = 8
"""Usual number of fractional steps for a root."""

SLOW = 60
"""Usual number of fractional steps for the extremum between two roots."""

HALF = LANES // 2
"""Number of searching lanes below which free ones take the next records."""


class Search(NamedTuple):
    """Rows of numbers of a lane's search: the last three points and the section function there, the next fractional
    step, the function after it, the first bracket, the size of the function before, kind and number of the next
    step.
    """

    x1: int = 0
    x2: int = 1
    x3: int = 2
    f1: int = 3
    f2: int = 4
    f3: int = 5
    tau: int = 6
    f: int = 7
    whole: int = 8
    last: int = 9
    live: int = 10
    sweeps: int = 11
    end: int = 12


SEARCH = Search()


@jit
def narrow(lanes, search):
    """Put the section function at each lane's fractional step into its bracket; set the next step and its kind; return
    the number of lanes whose root is HERE.

    The next step is by inverse quadratic interpolation within the bracket where that is safe, else the middle
    (Chandrupatla 1997, Adv. Eng. Software 28, 145). The search ends where its next correction is negligible beside the
    first bracket, or where rounding keeps the function from falling: at the one of its last points with the smallest
    value. Without branches, so that all lanes are vectors.
    """
    found = 0
    for i in range(lanes):
        x = search[SEARCH.tau * LANES + i]
        f = search[SEARCH.f * LANES + i]
        a = search[SEARCH.x1 * LANES + i]
        fa = search[SEARCH.f1 * LANES + i]
        b = search[SEARCH.x2 * LANES + i]
        fb = search[SEARCH.f2 * LANES + i]
        whole = search[SEARCH.whole * LANES + i]
        last = search[SEARCH.last * LANES + i]
        sweeps = search[SEARCH.sweeps * LANES + i] + 1.0
        searching = search[SEARCH.live * LANES + i] == SEARCHING
        same = (f > 0.0) == (fa > 0.0)
        x3 = a if same else b
        f3 = fa if same else fb
        x2 = b if same else a
        f2 = fb if same else fa
        xi = (x - x2) / (x3 - x2)
        phi = (f - f2) / (f3 - f2)
        safe = (phi * phi < xi) & ((1.0 - phi) * (1.0 - phi) < 1.0 - xi)
        secant = f / (f2 - f)
        inverse = secant * f3 / (f2 - f3) + (x3 - x) / (x2 - x) * f / (f3 - f) * f2 / (f3 - f2)
        fraction = inverse if safe else 0.5
        width = abs(x2 - x)
        change = abs(secant) * width
        stalls = (change <= NOISE * whole) & (abs(f) > 0.5 * last)
        settled = (change <= FINE * whole) | stalls | (width <= 2.4e-16 * whole) | (sweeps >= SWEEPS)
        here = abs(f) <= min(abs(f2), abs(f3))
        least = 1.2e-16 * whole / width
        inside = x + min(max(fraction, least), 1.0 - least) * (x2 - x)
        nearest = x2 if abs(f2) <= abs(f3) else x3
        search[SEARCH.x1 * LANES + i] = x
        search[SEARCH.f1 * LANES + i] = f
        search[SEARCH.x2 * LANES + i] = x2
        search[SEARCH.f2 * LANES + i] = f2
        search[SEARCH.x3 * LANES + i] = x3
        search[SEARCH.f3 * LANES + i] = f3
        live = (HERE if here else FOUND) if settled else SEARCHING
        live = live if searching else HERE
        following = nearest if settled else inside
        search[SEARCH.tau * LANES + i] = x if live == HERE else following
        search[SEARCH.last * LANES + i] = abs(f)
        search[SEARCH.sweeps * LANES + i] = sweeps
        search[SEARCH.live * LANES + i] = live
        found += 1 if live == HERE else 0
    return found


@jit
def fractional(flow, lanes, start, tau, z, k, work, f):
    """Set z to the state a fractional step tau[i] after start, and f to the section function there, for whole vectors
    of lanes.

    flow: the blocks of the model, the coefficients of the scheme, the bound section, the rows of a state.
    """
    blocks, scheme, section, rows = flow
    for j in range(rows * LANES):
        z[j] = start[j]
    for j in range(rows * LANES, z.size):
        z[j] = 0.0
    wide = filled(lanes, rows, z, tau)
    advance(blocks, scheme, rows, wide, tau, 1, z, k, work)
    call(section.function, section.parameters, wide, z, f)


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
    low = aligned_zeros(1)
    high = aligned_zeros(1)
    inner = aligned_zeros(1)
    found = aligned_zeros(1)
    tau = aligned_zeros(1)
    value = aligned_zeros(1)
    f = aligned_zeros(1)
    side = aligned_zeros(1)
    for i in range(lanes):
        low[i] = x1[i]
        high[i] = x2[i]
    fractional(flow, lanes, start, inner, z, k, work, value)
    for i in range(lanes):
        side[i] = -1.0 if value[i] < 0.0 else 1.0
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
            if side[i] * f[i] < 0.0:
                inner[i] = tau[i]
                found[i] = 1.0
            elif abs(f[i]) < abs(value[i]):
                if later:
                    low[i] = inner[i]
                else:
                    high[i] = inner[i]
                inner[i] = tau[i]
                value[i] = f[i]
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
    """Move the lower end of the first steps of orbits that start on the section off it, to a point where the function
    has left 0.

    The point moves from the upper end towards the start until the sign of the function changes; if it never does, the
    record becomes empty.
    """
    returns = 0
    for i in range(lanes):
        returns += 1 if kind[i] == RETURN else 0
    if returns == 0:
        return
    tau = aligned_zeros(1)
    f = aligned_zeros(1)
    last = aligned_zeros(1)
    found = aligned_zeros(1)
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
                x1[i] = tau[i]
                found[i] = 1.0
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
    z = aligned_zeros(scheme.copies * rows + scheme.spare)
    k = aligned_zeros(scheme.b.size * rows)
    step = aligned_zeros(1)
    work = aligned_zeros(rows)
    for i in range(lanes):
        load_lane(table, first + i, z, i)
        step[i] = tau[first + i]
    advance(blocks, scheme, rows, lanes, step, 1, z, k, work)
    for i in range(lanes):
        store_lane(z, i, table, first + i)
    write_now(progress, unit, lanes)


def bracket(unit, stop, progress, blocks, scheme, section, records, where):
    """Narrow the brackets of the records numbered `where` that are no certain crossings, in place: suspected pairs are
    split at the extremum of the section function, returns begin off the section.
    """
    count = where.size
    rows = records.shape[1] - RECORD.state
    first = unit * LANES
    lanes = min(LANES, count - first) if read_now(stop, 0) == 0 else 0
    z = aligned_zeros(scheme.copies * rows + scheme.spare)
    work = aligned_zeros(rows)
    k = aligned_zeros(scheme.b.size * rows)
    start = aligned_zeros(rows)
    kind = aligned_zeros(1)
    x1 = aligned_zeros(1)
    x2 = aligned_zeros(1)
    for i in range(lanes):
        record = records[where[first + i]]
        kind[i] = record[RECORD.kind]
        x1[i] = record[RECORD.lower]
        x2[i] = record[RECORD.upper]
        for r in range(rows):
            start[r * LANES + i] = record[RECORD.state + r]
    flow = blocks, scheme, section, rows
    split_pairs(flow, lanes, start, kind, x1, x2, z, k, work)
    leave_section(flow, lanes, start, kind, x1, x2, z, k, work)
    for i in range(lanes):
        record = records[where[first + i]]
        record[RECORD.kind] = kind[i]
        record[RECORD.lower] = x1[i]
        record[RECORD.upper] = x2[i]
    write_now(progress, unit, lanes)


@jit
def begin(flow, first, lanes, direction, records, number, kind, start, search, z, k, work):
    """Start the searches of the lanes from `first` on, which have taken their records: with the secant of their
    brackets.
    """
    _, _, section, _ = flow
    f = row(search, SEARCH.f)
    doubtful = 0
    for i in range(first, lanes):
        o = number[i]
        kind[i] = records[o, RECORD.kind]
        search[SEARCH.sweeps * LANES + i] = 0.0
        search[SEARCH.last * LANES + i] = np.inf
        lower = 0.0 if kind[i] == CERTAIN else records[o, RECORD.lower]
        upper = records[o, RECORD.upper]
        search[SEARCH.x1 * LANES + i] = lower
        search[SEARCH.x2 * LANES + i] = upper
        search[SEARCH.x3 * LANES + i] = lower
        search[SEARCH.whole * LANES + i] = abs(upper - lower)
        search[SEARCH.f2 * LANES + i] = records[o, RECORD.beyond]
        doubtful += 0 if kind[i] == CERTAIN else 1
    call(section.function, section.parameters, lanes, start, f)
    if doubtful > 0:
        fractional(flow, lanes, start, row(search, SEARCH.x2), z, k, work, f)
        for i in range(first, lanes):
            search[SEARCH.f2 * LANES + i] = search[SEARCH.f2 * LANES + i] if kind[i] == CERTAIN else f[i]
        fractional(flow, lanes, start, row(search, SEARCH.x1), z, k, work, f)
    for i in range(first, lanes):
        f1 = f[i]
        f2 = search[SEARCH.f2 * LANES + i]
        x1 = search[SEARCH.x1 * LANES + i]
        x2 = search[SEARCH.x2 * LANES + i]
        search[SEARCH.f1 * LANES + i] = f1
        search[SEARCH.f3 * LANES + i] = f1
        differ = (f1 < 0.0 and f2 > 0.0) or (f1 > 0.0 and f2 < 0.0)  # a zero alone is touched, not crossed
        if kind[i] > CERTAIN and (not differ or (f2 - f1) * direction < 0.0):
            kind[i] = NOTHING
        if f1 * f2 < 0.0:
            search[SEARCH.live * LANES + i] = SEARCHING
            search[SEARCH.tau * LANES + i] = x1 + (x2 - x1) * (f1 / (f1 - f2))
        else:
            search[SEARCH.live * LANES + i] = FOUND
            search[SEARCH.tau * LANES + i] = x1 if abs(f1) <= abs(f2) else x2


def locate(unit, stop, progress, blocks, scheme, section, direction, records, where, size):
    """Turn a unit of `size` of the records numbered `where` (rows of `records`) into crossings: roots of the section
    function on the flow.

    Every lane has its own bracket, see `bracket` for those that are not certain, and lanes that have converged take the
    next records. Without a change of sign, or in the wrong direction, the record becomes empty. Afterwards a record
    holds time, kind, section function and state.
    """
    rows = records.shape[1] - RECORD.state
    following = unit * size
    end = min((unit + 1) * size, where.size)
    z = aligned_zeros(scheme.copies * rows + scheme.spare)
    work = aligned_zeros(rows)
    k = aligned_zeros(scheme.b.size * rows)
    start = aligned_zeros(rows)
    search = aligned_zeros(SEARCH.end)
    kind = aligned_zeros(1)
    number = np.zeros(LANES, np.int64)
    tau = row(search, SEARCH.tau)
    f = row(search, SEARCH.f)
    flow = (blocks, scheme, section, rows)
    lanes = 0
    while True:
        if lanes <= HALF and following < end and read_now(stop, 0) == 0:
            first = lanes
            lanes = min(LANES, first + end - following)
            for i in range(first, lanes):
                number[i] = where[following]
                following += 1
                for r in range(rows):
                    start[r * LANES + i] = records[number[i], RECORD.state + r]
            begin(flow, first, lanes, direction, records, number, kind, start, search, z, k, work)
            write_now(progress, unit, following - unit * size)
        if lanes == 0:
            break
        fractional(flow, lanes, start, tau, z, k, work, f)
        here = narrow(lanes, search)
        i = 0
        while here > 0:
            if search[SEARCH.live * LANES + i] != HERE:
                i += 1
                continue
            o = number[i]
            records[o, RECORD.time] += search[SEARCH.tau * LANES + i]
            records[o, RECORD.kind] = NOTHING if kind[i] == NOTHING else LOCATED
            records[o, RECORD.residual] = f[i]
            for r in range(rows):
                records[o, RECORD.state + r] = z[r * LANES + i]
            lanes = lanes - 1
            here = here - 1
            move_lane(rows, lanes, i, start)
            move_lane(SEARCH.end, lanes, i, search)
            number[i] = number[lanes]
            kind[i] = kind[lanes]
            move_lane(rows, lanes, i, z)


def conditioning_of(unit, stop, progress, section, nudge, z, size, speed, result):
    """Fill result (points,) with the ratio of a crossing's error to its state's error: the change of the section
    function by an amplitude of the motion over its change in a radian, at least 1, NaN where there is none.

    z, speed (rows, points): the states, and their changes in a radian; size (rows, orbits): the amplitudes; all orbits
    have equally many points. Differences are between points a part `nudge` of the amplitude away.
    """
    if read_now(stop, 0) > 0:
        return
    rows, points = z.shape
    first = unit * LANES
    each = points // size.shape[1]
    lanes = min(LANES, points - first)
    block = aligned_zeros(rows)
    ahead = aligned_zeros(1)
    behind = aligned_zeros(1)
    amplitude = aligned_zeros(1)
    change = aligned_zeros(1)
    passing = aligned_zeros(1)
    orbit = np.empty(LANES, np.int64)
    for i in range(lanes):
        orbit[i] = (first + i) // each
        for r in range(rows):
            block[r * LANES + i] = z[r, first + i]
    for r in range(rows):
        here = z[r, first : first + lanes]
        fast = speed[r, first : first + lanes]
        own = row(block, r)
        for i in range(lanes):
            amplitude[i] = size[r, orbit[i]]
        for value, shift in ((ahead, nudge), (behind, -nudge)):
            for i in range(lanes):
                own[i] = here[i] + shift * amplitude[i]
            call(section.function, section.parameters, lanes, block, value)
        for i in range(lanes):
            own[i] = here[i]
            slope = (ahead[i] - behind[i]) / (2.0 * nudge)
            change[i] += slope * slope
            passing[i] += (slope / amplitude[i] if amplitude[i] > 0.0 else 0.0) * fast[i]
    for i in range(lanes):
        times = np.sqrt(change[i]) / abs(passing[i])
        result[first + i] = 1.0 if times < 1.0 else times
    progress[unit] = lanes


def compact(unit, rows, out, counts, limit, unlocated):
    """Keep the located records of the row of each orbit of a unit, after the start and up to its limit (orbits,),
    without gaps, NaN after them; counts (orbits,) becomes their number. unlocated (orbits,) tells which orbits have
    other records left.
    """
    width = RECORD.state + rows
    for o in range(unit * LANES, min((unit + 1) * LANES, counts.size)):
        kept = 0
        for slot in range(counts[o]):
            time = out[o, slot * width + RECORD.time]
            kind = out[o, slot * width + RECORD.kind]
            unlocated[o] |= kind != LOCATED and kind != NOTHING
            if kind == LOCATED and time > 0.0 and time <= limit[o]:
                if kept != slot:
                    for c in range(width):  # a copy by slices takes 1.5 s to compile, most of it for an error's text
                        out[o, kept * width + c] = out[o, slot * width + c]
                kept += 1
        for c in range(kept * width, counts[o] * width):
            out[o, c] = np.nan
        counts[o] = kept


def gather(unit, out, counts, points, times, residual):
    """Set points (rows, orbits, crossings) and times (orbits, crossings) of the orbits of a unit from their first
    counts[o] records, NaN after them, and residual (orbits,) to the largest section function.
    """
    rows, _, wanted = points.shape
    width = RECORD.state + rows
    for o in range(unit * LANES, min((unit + 1) * LANES, counts.size)):
        residual[o] = 0.0
        for slot in range(wanted):
            c = slot * width
            kept = slot < counts[o]
            times[o, slot] = out[o, c + RECORD.time] if kept else np.nan
            for r in range(rows):
                points[r, o, slot] = out[o, c + RECORD.state + r] if kept else np.nan
            if kept:
                residual[o] = np.maximum(residual[o], abs(out[o, c + RECORD.residual]))
