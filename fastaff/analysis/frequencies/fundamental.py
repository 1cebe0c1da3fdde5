"""Independent fundamental frequencies from samples of orbits: lattices of lines, loops of single modes, their rates.

Signals are (orbits, 2m, samples): Q and P of each of m loops in turn, equidistant in time. The lines of all loops
together span a lattice of frequencies; its generators nu_k have complex amplitudes A_k in the signals. The row d_k of
the dual basis to (A_1 ... A_r, conj A_1 ... conj A_r) makes a loop f_k = d_k . (s - centre) that has the line nu_k with
amplitude 1 and neither another generator nor its conjugate: of a linear system exactly one normal mode. The mean rate
of its argument is nu_k.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ...compile.threads import by_workers
from ...flows.launch import launch
from ...kernels import fundamental as kernels
from ...kernels import peaks
from ...kernels.demodulation import Loops, loop_values
from ...kernels.fundamental import Lattice, Rows, Vectors
from ...kernels.peaks import Lines, Spectra
from .integer_lattice import ball
from .naff import found_lines, lines_of_transforms
from .rooms import ROOMS
from .signals import Signals
from .windows import APART_ORDER, apart_window, cosine_window, fast_lengths, growth_windows, tables_for, tabulated

LINES, MORE_LINES = 4, 8
"""Lines of a loop beyond the number of loops from which a lattice is found; the second number where the first leave it
incomplete.
"""

LONGEST = (40, 20, 10, 6, 5, 4, 3, 3)
"""Largest |k|_1 of a line in a lattice of rank 1, 2, ...; half of it where a line refines the lattice."""

FARTHEST, BESIDE = (1000, 60, 20, 12, 8, 6, 5, 4), (1000, 3, 2, 1, 1, 1, 1, 1)
"""The same of lines that are no weak generators; and of those whose neighbours are none."""

SEEN = 6
"""Lines of each loop that are sought where they stand apart."""

BROAD = 0.1
"""Share of a loop's size that its strongest lines leave, beyond which none stands out."""

FEW, BRIEF = 8, 4096
"""Orbits for which waking another thread takes longer than the work; of kernels of a microsecond an orbit."""

AT_ONCE = 32
"""Orbits whose Fourier transforms are made at once."""

WEAK, MINOR = 1e-9, 2e-3
"""Amplitudes of a line, relative to its loop's largest, below which it is ignored, and below which it is no generator.
"""

SHARP = 0.03
"""Error bar of a line, in cycles over the window, up to which it belongs to the lattice."""

LINE_WIDTH = 1e-5
"""Addition to error bars of lines, in cycles over the window: lines of the lattice that lie within one bin are fitted
as one.
"""

WEAKEST, FAINT, CLOSE, EXACT = (2, 5, 12), 1e-10, 0.5, 0.01
"""Numbers of lines that are sought beside those of the known generators, one after the other; their least amplitude,
relative to the signals' sizes, 1e5 times the rounding errors; and the distances, in cycles over the window, up to which
a line is that of a short combination, as lines closer than 1.5 are not resolved, and of any.
"""

NOT_FEW = 0.2
"""Share of a loop's size that the first lines leave, beyond which no lattice is sought among more of them."""

AT_REST = 1e-12
"""Relative size of a loop (root of its Q times its P) below which it is at rest."""

ORDERED = 0.02
"""Advantage of ascending frequencies, in the logarithm of shares: decides where coordinates share modes equally."""


class Modes(NamedTuple):
    """Modes from the lines of loops: arrays over orbits first, then over m loops (NaN or 0 past the rank).

    rank: number of independent frequencies found; nu, spread: the frequency of each loop and its error bar, from lines;
    leading, leading_error: strongest line of each loop; combination (orbits, m, m): integers with leading = combination
    @ nu, 0 where none is known; dual (orbits, m, 2m), offset, drift (orbits, m): the loop of each frequency, that of Q
    and P itself where a loop has none of its own; owned: mask of loops with their own; moving: of those that move;
    drifting (orbits,): whether the lattice is incomplete as no line is steady; rest (orbits,): share of a loop's size
    that its lines leave, the largest one's; lines (orbits, 3, m, SEEN): frequencies, error bars and amplitudes of the
    strongest lines; tail (orbits,): the largest amplitude near the highest frequency that samples show, relative to the
    loop's largest; unexplained (orbits,): the largest amplitude of a line that is no combination of the frequencies, in
    units of the signals' sizes, where the lattice is incomplete; weak (orbits, m): of loops whose frequency is in lines
    alone that are weak beside the others'.
    """

    rank: np.ndarray
    nu: np.ndarray
    spread: np.ndarray
    leading: np.ndarray
    leading_error: np.ndarray
    combination: np.ndarray
    dual: np.ndarray
    offset: np.ndarray
    drift: np.ndarray
    owned: np.ndarray
    moving: np.ndarray
    drifting: np.ndarray
    rest: np.ndarray
    lines: np.ndarray
    tail: np.ndarray
    unexplained: np.ndarray
    weak: np.ndarray


@functools.cache
def _table(rank: int, lengths: tuple[int, ...]) -> tuple[np.ndarray, int, int]:
    """Return the vectors of |k|_1 from 1 to the longest for that rank, by length; their number, and that of vectors up
    to half that length.
    """
    longest = lengths[rank - 1] if rank <= len(lengths) else 2
    k = ball(rank, longest)[1:]
    return k, len(k), int((np.abs(k).sum(axis=1) <= longest // 2).sum())


@functools.cache
def tables_of(most: int, lengths: tuple[int, ...] = LONGEST) -> Vectors:
    """Return the tables of ranks 1 to `most`, (ranks, most + 1, vectors) with zeros past their ends, see
    `kernels.fundamental.relate`, and their numbers of vectors (ranks, 2).
    """
    tables = [_table(rank, lengths) for rank in range(1, most + 1)]
    sizes = np.array([[whole, half] for _, whole, half in tables])
    vectors = np.zeros((most, most + 1, int(sizes.max())))
    for rank, (k, whole, _) in enumerate(tables, 1):
        vectors[rank - 1, :rank, :whole], vectors[rank - 1, most, :whole] = k.T, np.abs(k).sum(axis=1)
    return Vectors(vectors, sizes)


def fastest(signals: np.ndarray, interval: float, threads: int) -> np.ndarray:
    """Return a high angular frequency (orbits,) of the signals (orbits, rows, samples): root mean square of second over
    first differences, the largest row's.
    """
    ratio = np.zeros(len(signals))
    run(kernels.quickness, len(signals), (signals, ratio), threads)
    return np.sqrt(ratio) / interval


def run(kernel: Any, orbits: int, arguments: tuple, threads: int, few: int = FEW) -> None:
    """Run a kernel of one orbit after another; for so few the caller's own thread does it."""
    if orbits:
        steps = 0.0 if orbits <= few else math.inf
        launch(kernel, arguments, np.zeros(orbits), float(orbits), threads, None, steps)


def modes(signals: Signals, m: int, threads: int) -> tuple[Modes, Spectra]:
    """Find the independent frequencies of the first 2m rows of signals; return them with their spectra.

    Lines that stand apart are read from the bins of Fourier transforms; others are fitted together. Orbits without a
    line that stands out, such as chaotic ones, are `drifting` and have no fit.
    """
    spectra = _spectra(signals, m, threads)
    found = _in_units_of(_apart(spectra, signals.interval, threads), spectra, np.arange(signals.samples.size))
    done = (found.rank == found.moving.sum(axis=1)) | ~found.moving.any(axis=1)
    fit(found, signals, spectra, np.flatnonzero(~done & ~found.drifting), threads)
    return found, spectra


def fit(found: Modes, signals: Signals, spectra: Spectra, orbits: np.ndarray, threads: int) -> None:
    """Fill in the modes of these orbits, from lines that are fitted together to their loops."""
    if orbits.size:
        fitted = _fitted(signals, spectra, orbits, threads)._replace(tail=found.tail[orbits])
        adopt(found, orbits, _in_units_of(fitted, spectra, orbits))


def _in_units_of(found: Modes, spectra: Spectra, orbits: np.ndarray) -> Modes:
    """Return the modes of these orbits with loops of the signals themselves, from those in units of their sizes."""
    rows = spectra.rows
    dual = found.dual / rows.size[orbits, None]
    offset, step = (dual * entry[orbits, None] for entry in (rows.centre, rows.drift))
    return found._replace(dual=dual, offset=offset.sum(axis=2), drift=step.sum(axis=2))


def adopt(table: NamedTuple, orbits: np.ndarray, found: NamedTuple) -> None:
    """Fill in the results of these orbits, arrays (orbits, ...)."""
    for old, new in zip(table, found, strict=True):
        old[orbits] = new


def taken(table: Any, orbits: np.ndarray) -> Any:
    """Return a tuple of arrays (orbits, ...) of these orbits alone."""
    return type(table)(*(entry[orbits] for entry in table))


def _no_modes(orbits: int, m: int) -> Modes:
    """Return empty modes."""
    zero, none = np.zeros((orbits, m)), np.zeros((orbits, m), bool)
    return Modes(
        rank=np.zeros(orbits, np.int64),
        nu=zero.copy(),
        spread=np.full((orbits, m), np.inf),
        leading=zero.copy(),
        leading_error=np.full((orbits, m), np.inf),
        combination=np.zeros((orbits, m, m), np.int64),
        dual=np.zeros((orbits, m, 2 * m), complex),
        offset=zero.astype(complex),
        drift=zero.astype(complex),
        owned=none.copy(),
        moving=none.copy(),
        drifting=np.zeros(orbits, bool),
        rest=np.zeros(orbits),
        lines=np.zeros((orbits, 3, m, SEEN)),
        tail=np.zeros(orbits),
        unexplained=np.zeros(orbits),
        weak=none.copy(),
    )


def _no_lattice(orbits: int, m: int) -> Lattice:
    """Return lattices without generators."""
    nu, spread = np.zeros((2, orbits, m))
    return Lattice(np.zeros(orbits, np.int64), nu, spread, np.full((orbits, m), -1))


def prepared(
    signals: np.ndarray, n: int, threads: int, at_rest: float = AT_REST**2
) -> tuple[np.ndarray, np.ndarray, Rows]:
    """Return the first n samples of the rows, the loops (orbits, m, n), and the properties of the rows; see
    `kernels.fundamental.prepare`.
    """
    orbits, rows, m = len(signals), signals.shape[1], signals.shape[1] // 2
    x, loops, found = np.empty((orbits, rows, n)), np.empty((orbits, m, n), complex), _rows(orbits, m)
    run(kernels.prepare, orbits, (signals, cosine_window(n), growth_windows(n), at_rest, x, loops, found), threads)
    return x, loops, found


def _rows(orbits: int, m: int) -> Rows:
    """Return the arrays for the properties of rows."""
    drift, centre, size = np.empty((3, orbits, 2 * m))
    return Rows(drift, centre, size, np.zeros((orbits, m), bool))


@tabulated
def _windows(n: int) -> np.ndarray:
    """Return the tables of n samples for `kernels.peaks.windowed`."""
    return np.concatenate([cosine_window(n), apart_window(n), *growth_windows(n)])


def _spectra(signals: Signals, m: int, threads: int) -> Spectra:
    """Return the Fourier transforms of the loops of the first 2m rows."""
    n = fast_lengths(signals.samples)
    orbits = n.size
    start, numbers = np.cumsum(m * n) - m * n, ROOMS.spectra.array(2 * m * int(n.sum()))
    spectra = Spectra(numbers, start, n, _rows(orbits, m))
    run(peaks.windowed, orbits, (signals.ragged, tables_for(_windows, n), AT_REST**2, spectra), threads)
    numbers, parts, begin = numbers.view(complex), [], 0
    for end in range(1, orbits + 1):  # neighbours of equally many samples
        if end == orbits or n[end] != n[begin] or end - begin == AT_ONCE:
            first = int(start[begin])
            parts.append(numbers[first : first + (end - begin) * m * int(n[begin])].reshape(-1, int(n[begin])))
            begin = end

    def transform(begin: int) -> None:
        for part in parts[begin::threads]:
            np.fft.fft(part, axis=-1, out=part)

    by_workers(transform, threads)
    return spectra._replace(numbers=numbers)


def _apart(spectra: Spectra, h: np.ndarray, threads: int) -> Modes:
    """Return the modes of loops whose lines stand apart, from bins of Fourier transforms of samples h (orbits,) apart;
    rank 0 for others.
    """
    moving = spectra.rows.moving
    orbits, m = moving.shape
    result, unit = _no_modes(orbits, m), (spectra.n * h)[:, None]
    value, bar, strength = np.zeros((3, orbits, m, SEEN))
    bar[:] = np.inf
    lattice, dual, share = _no_lattice(orbits, m), np.zeros((orbits, m, 2 * m), complex), np.zeros((orbits, m, m))
    rest, clear = np.zeros(orbits), np.zeros(orbits, np.int64)
    apart = peaks.Apart(Lines(value, bar, strength), lattice, dual, share, rest, result.tail, clear)
    arguments = spectra, APART_ORDER, MINOR, SHARP, LINE_WIDTH, tables_of(m), apart
    run(peaks.separate, orbits, arguments, threads)
    some = clear.astype(bool)
    value, bar = value / unit[:, :, None], bar / unit[:, :, None]
    result.lines[:] = np.stack([value, bar, strength], axis=1)
    rank, nu, spread = np.where(some, lattice.rank, 0), lattice.nu / unit, lattice.spread / unit
    top, top_bar = value[:, :, 0].copy(), bar[:, :, 0].copy()
    _place(result, Lattice(rank, nu, spread, lattice.source), dual, share, top, top_bar, moving, threads)
    result.rest[:], result.drifting[:] = rest, ~some & (rest > BROAD)
    return result


def _fitted(signals: Signals, spectra: Spectra, orbits: np.ndarray, threads: int) -> Modes:
    """Return the modes from lines that are fitted together to the loops of some orbits; more lines if a few leave the
    lattice incomplete, then weak ones.
    """
    m = spectra.rows.moving.shape[1]
    result = _lattice(signals, spectra, orbits, m + LINES, threads)
    short = np.flatnonzero((result.rank < result.moving.sum(axis=1)) & result.moving.any(axis=1))
    result.drifting[short] = result.rest[short] > NOT_FEW
    short = short[~result.drifting[short]]
    # A leading line that is not sharp is not resolved, and no line beside it would be: more of them only show that
    # lines explain the rest.
    time = (spectra.n * signals.interval)[orbits[short], None]
    sharp = ~result.moving[short] | (result.leading_error[short] * time < 3 * SHARP)
    short = short[sharp.all(axis=1) | (result.rest[short] > BROAD)]
    if short.size:
        adopt(result, short, _lattice(signals, spectra, orbits[short], m + MORE_LINES, threads))
    _complete(result, signals, spectra, orbits, threads)
    return result


def _complete(found: Modes, signals: Signals, spectra: Spectra, orbits: np.ndarray, threads: int) -> None:
    """Add weak generators to the modes of some orbits, those whose lattice is incomplete and whose lines are few.

    Combinations of the rows that have none of the generators' lines show what else moves, however weak it is beside
    these. Its lines are generators where no combination of the known ones is as close as half the resolution.
    """
    left = np.flatnonzero((found.rank > 0) & ~found.drifting & (found.rest <= NOT_FEW))
    for _ in range(found.moving.shape[1]):
        before = found.rank.copy()
        for lines in WEAKEST:  # more of them than there are would be rounding errors, which blur those beside them
            some = left[(found.rank[left] == before[left]) & (found.rank[left] < found.moving[left].sum(axis=1))]
            if some.size:
                now = _with_weak(taken(found, some), signals, spectra, orbits[some], lines, threads)
                adopt(found, some, now)
        left = left[found.rank[left] > before[left]]


def _with_weak(found: Modes, signals: Signals, spectra: Spectra, orbits: np.ndarray, lines: int, threads: int) -> Modes:
    """Return the modes of some orbits with further generators among so many lines that are weak beside the known
    ones'.
    """
    m, count = found.moving.shape[1], orbits.size
    nu, spread = np.zeros((2, count, m))
    for o in range(count):
        own = found.owned[o]
        nu[o, : own.sum()], spread[o, : own.sum()] = found.nu[o, own], found.spread[o, own]
    value, bar, strength = _weak_lines(found, nu, signals, spectra, orbits, lines, threads)
    time = (spectra.n * signals.interval)[orbits, None]
    most, rate = value.shape[1], 1 / signals.interval[orbits]
    near = _explained(value, bar, nu, spread, time, rate[:, None], threads)
    strange = (strength > FAINT) & ~near
    unexplained = np.where(strange, strength, 0.0).max(axis=1, initial=0.0)
    used = strange & (bar * time < 3 * SHARP) & (strength > MINOR * strength.max(axis=1, keepdims=True))
    order = np.argsort(-np.where(used, strength, 0.0), axis=1, kind="stable")
    value, bar = (np.take_along_axis(entry, order, axis=1) for entry in (value, bar))
    values_of, bars_of = np.zeros((2, count, m + most))
    for o in range(count):
        r, new = found.rank[o], used[o].sum()
        values_of[o, :r], bars_of[o, :r] = nu[o, :r], spread[o, :r]
        values_of[o, r : r + new], bars_of[o, r : r + new] = value[o, :new], bar[o, :new]
    lattice = _no_lattice(count, m)
    arguments = values_of, bars_of, found.rank + used.sum(axis=1), tables_of(m), rate, lattice
    run(kernels.generators, count, arguments, threads, BRIEF)
    dual, share = _dual(signals, spectra, orbits, lattice.rank, lattice.nu, threads)
    result = taken(found, np.arange(count))
    top, top_bar = found.leading, found.leading_error
    _place(result, lattice, dual, share, top, top_bar, found.moving, threads)
    result.unexplained[:] = unexplained
    before = np.where(found.owned & ~found.weak, found.nu, np.nan)
    result.weak[:] = result.owned & ~(result.nu[:, :, None] == before[:, None]).any(axis=2)
    return result


def _explained(
    value: np.ndarray,
    bar: np.ndarray,
    nu: np.ndarray,
    spread: np.ndarray,
    time: np.ndarray,
    rate: np.ndarray,
    threads: int,
) -> np.ndarray:
    """Return a mask of lines (orbits, lines) that are combinations of nu (orbits, m), also modulo the sampling rate, or
    too close to a short one; time, rate (orbits, 1).
    """
    m, (count, most) = nu.shape[1], value.shape
    result = np.zeros(value.shape, bool)
    lines = np.zeros((3, count, -(-most // m) * m))
    widths = np.zeros((2, *lines.shape[1:]))
    for entry, place in zip(lines, (value, rate - value, rate + value), strict=True):
        entry[:, :most] = np.where(value > 0, place, 0.0)
    sharp = np.maximum(bar, EXACT / time)
    widths[0, :, :most], widths[1, :, :most] = np.maximum(sharp, CLOSE / time), sharp
    tables = [(width, tables_of(m, lengths)) for width, lengths in zip(widths, (BESIDE, FARTHEST), strict=True)]
    for first, entry, (width, table) in itertools.product(range(0, most, m), lines, tables):
        part, k = slice(first, first + m), np.zeros((count, m, m), np.int64)
        chosen = (np.ascontiguousarray(some[:, part]) for some in (entry, width))
        run(kernels.combinations, count, (*chosen, nu, spread, table, k), threads, BRIEF)
        result[:, part] |= np.abs(k).max(axis=2)[:, : most - first] > 0
    return result


def _weak_lines(
    found: Modes,
    nu: np.ndarray,
    signals: Signals,
    spectra: Spectra,
    orbits: np.ndarray,
    lines: int,
    threads: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frequencies, error bars and amplitudes (orbits, m lines), in units of the rows' sizes, of so many lines of
    each combination of the rows without the generators nu (orbits, m).
    """
    m, count = found.moving.shape[1], orbits.size
    rows = spectra.rows
    value, bar, strength = np.zeros((3, count, m * lines))
    amplitudes = np.zeros((count, 2 * m, 2 * m))
    for r, where, amplitude in _amplitudes(signals, spectra, orbits, found.rank, nu, threads):
        parts = np.concatenate([amplitude[:, :r].real, amplitude[:, :r].imag], axis=1)
        amplitudes[where, :, : 2 * r] = parts.transpose(0, 2, 1)
    moving = np.repeat(found.moving, 2, axis=1)
    c = np.zeros((count, m, signals.rows), complex)
    for o in range(count):
        r, own = int(found.rank[o]), np.flatnonzero(moving[o])
        left = np.linalg.svd(amplitudes[o, own, : 2 * r])[0][:, 2 * r :]
        for j in range(left.shape[1] // 2):
            c[o, j, own] = left[:, 2 * j] - 1j * left[:, 2 * j + 1]
    c[:, :, : 2 * m] /= rows.size[orbits][:, None]
    offset, drift = ((c[:, :, : 2 * m] * entry[orbits][:, None]).sum(axis=2) for entry in (rows.centre, rows.drift))
    some = signals.of(orbits)
    loops = Loops(c, offset, drift)
    for alike in some.alike():
        row, place = np.nonzero(c[alike].any(axis=2))
        owner = alike[row]
        for begin in range(0, owner.size, AT_ONCE):
            part = slice(begin, begin + AT_ONCE)
            f = values(some, loops, owner[part], place[part], threads)[:, : spectra.n[orbits[alike[0]]]]
            most = max(1, min(lines, f.shape[1] // 4 - APART_ORDER))
            got = found_lines(np.ascontiguousarray(f), float(some.interval[alike[0]]), most, APART_ORDER, threads)
            unit = f.shape[1] * float(some.interval[alike[0]])
            known = np.isfinite(got.error) & (np.abs(got.nu) * unit > 2)
            for i, (orbit, loop) in enumerate(zip(owner[part], place[part], strict=True)):
                at = slice(loop * lines, loop * lines + most)
                value[orbit, at] = np.where(known[i], np.abs(got.nu[i]), 0.0)
                bar[orbit, at] = np.where(known[i], 3 * got.error[i], 0.0) + LINE_WIDTH / unit
                strength[orbit, at] = np.where(known[i], np.abs(got.amplitude[i]), 0.0)
    return value, bar, strength


def _lines(spectra: Spectra, orbits: np.ndarray, lines: int, threads: int) -> tuple[np.ndarray, ...]:
    """Return the frequencies, error bars, both in bins, and amplitudes (orbits, m, lines) of the strongest lines of
    the loops of some orbits, and the root mean square (orbits, m) of the rest.
    """
    m = spectra.rows.moving.shape[1]
    nu, bar, strength = np.zeros((3, orbits.size, m, lines))
    bar[:], rest = np.inf, np.zeros((orbits.size, m))
    n = spectra.n[orbits]
    for samples in np.unique(n):
        own = np.flatnonzero(n == samples)
        begins = spectra.start[orbits[own]]
        parts = np.concatenate([spectra.numbers[at : at + m * samples] for at in begins]).reshape(-1, samples)
        most = max(1, min(lines, int(samples) // 4 - APART_ORDER))
        found = lines_of_transforms(parts, APART_ORDER, most, threads if len(parts) > FEW else 1)
        value, amplitude, error, residual = (entry.reshape(own.size, m, *entry.shape[1:]) for entry in found)
        nu[own, :, :most], bar[own, :, :most], strength[own, :, :most] = value, error, np.abs(amplitude)
        rest[own] = residual
    return nu, bar, strength, rest


def _lattice(signals: Signals, spectra: Spectra, orbits: np.ndarray, lines: int, threads: int) -> Modes:
    """Return the modes of some orbits by so many lines fitted to each loop."""
    moving, h = spectra.rows.moving[orbits], signals.interval[orbits]
    m, time = moving.shape[1], spectra.n[orbits] * h
    value, error, strength, rest = _lines(spectra, orbits, lines, threads)
    unit = time[:, None, None]
    value, error = np.abs(value) / unit, error / unit
    strength = strength / np.maximum(strength.max(axis=2, keepdims=True), 1e-300)
    seen = np.isfinite(error) & (value * unit > 2) & (strength > WEAK) & moving[:, :, None]
    strength = np.where(seen, strength, 0.0)
    first = strength.argmax(axis=2)[:, :, None]
    leads = np.arange(strength.shape[2]) == first
    lines_seen = np.stack([entry[:, :, :SEEN] for entry in (value, 3 * error + LINE_WIDTH / unit, strength)], axis=1)
    bar = 3 * np.where(seen, error, np.inf) + LINE_WIDTH / unit
    top = np.take_along_axis(np.where(seen, value, 0.0), first, axis=2)[:, :, 0]
    top_bar = np.take_along_axis(bar, first, axis=2)[:, :, 0]
    used = seen & (bar * unit < 3 * SHARP) & ((strength > MINOR) | leads)
    rank_of_lines = np.where(used, strength + 2.0 * leads, 0.0).reshape(orbits.size, -1)
    order = np.argsort(-rank_of_lines, axis=1, kind="stable")
    value, bar = (
        np.ascontiguousarray(np.take_along_axis(entry.reshape(orbits.size, -1), order, axis=1))
        for entry in (value, bar)
    )
    bar = np.where(np.isfinite(bar), bar, 0.0)
    # Where a leading line is not sharp, sharper ones may be its multiples.
    known = (used | ~leads | ~moving[:, :, None]).all(axis=(1, 2))
    count = np.where(known, (rank_of_lines > 0).sum(axis=1), 0)
    lattice = _no_lattice(orbits.size, m)
    arguments = value, bar, count, tables_of(m), 1 / h, lattice
    run(kernels.generators, orbits.size, arguments, threads, BRIEF)
    dual, share = _dual(signals, spectra, orbits, lattice.rank, lattice.nu, threads)
    result = _no_modes(orbits.size, m)
    _place(result, lattice, dual, share, top, top_bar, moving, threads)
    result.rest[:] = (np.where(moving, rest, 0.0) / math.sqrt(2)).max(axis=1, initial=0.0)
    result.lines[..., : lines_seen.shape[3]] = lines_seen
    return result


def _place(
    result: Modes,
    lattice: Lattice,
    dual: np.ndarray,
    share: np.ndarray,
    top: np.ndarray,
    top_bar: np.ndarray,
    moving: np.ndarray,
    threads: int,
) -> None:
    """Fill in generators, each with the loop of whose motion it has most, and leading lines `top`."""
    rank, nu, spread, _ = lattice
    orbits, m = nu.shape
    place, rows = places(share, nu, rank, moving), np.arange(orbits)[:, None]
    owned = place < rank[:, None]
    nu, spread = nu[rows, place], spread[rows, place]
    plain = np.zeros((m, 2 * m), complex)
    plain[np.arange(m), 2 * np.arange(m)], plain[np.arange(m), 2 * np.arange(m) + 1] = 1.0, -1j
    nu, spread = np.where(owned, nu, 0.0), np.where(owned, spread, np.inf)
    top_bar = np.where(top > top_bar, top_bar, np.inf)  # else it cannot be distinguished from 0
    run(kernels.combinations, orbits, (top, top_bar, nu, spread, tables_of(m), result.combination), threads, BRIEF)
    result.rank[:], result.owned[:], result.moving[:] = rank, owned, moving
    result.dual[:] = np.where(owned[:, :, None], dual[rows, place], plain * moving[:, :, None])
    # A loop without a frequency of its own shows its leading line, which depends on the others.
    result.nu[:], result.spread[:] = np.where(owned, nu, top), np.where(owned, spread, top_bar)
    result.leading[:], result.leading_error[:] = top, top_bar


def _dual(
    signals: Signals, spectra: Spectra, which: np.ndarray, rank: np.ndarray, nu: np.ndarray, threads: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the dual rows (orbits, m, 2m) of the lines nu in the signals of some orbits, in units of their sizes, and
    the share (orbits, m, m) that line k has of loop j's motion.
    """
    orbits, m = nu.shape
    dual, share = np.zeros((orbits, m, 2 * m), complex), np.zeros((orbits, m, m))
    for r, where, amplitude in _amplitudes(signals, spectra, which, rank, nu, threads):
        dual[where, :r] = np.linalg.pinv(amplitude.transpose(0, 2, 1), rcond=1e-12)[:, :r]
        size = np.abs(amplitude[:, :r])
        share[where, :r] = size[:, :, ::2] * size[:, :, 1::2]
    return dual, share


def _amplitudes(
    signals: Signals, spectra: Spectra, which: np.ndarray, rank: np.ndarray, nu: np.ndarray, threads: int
) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Yield each rank r, the numbers of its orbits, and the complex amplitudes (orbits, 2r, 2m) of their lines nu, then
    of -nu, in the rows in units of their sizes.
    """
    orbits, m = nu.shape
    rows, n, own = 2 * m, spectra.n[which], signals.of(which)
    moments, gram = np.zeros((orbits, rows, m), complex), np.zeros((orbits, rows, rows))
    found = spectra.rows
    scaling = found.drift[which], found.centre[which], 1 / found.size[which]
    arguments = own.ragged, n, tables_for(cosine_window, n), own.interval, scaling, rank, nu, moments, gram
    run(kernels.project, orbits, arguments, threads)
    for r in np.unique(rank[rank > 0]):
        where = np.flatnonzero(rank == r)
        projections = np.concatenate([moments[where, :, :r], moments[where, :, :r].conj()], axis=2)
        # The amplitudes A of the lines obey A gram^T = projections.
        yield (
            int(r),
            where,
            np.linalg.pinv(gram[where, : 2 * r, : 2 * r], rcond=1e-12) @ projections.transpose(0, 2, 1),
        )


def places(share: np.ndarray, nu: np.ndarray, rank: np.ndarray, moving: np.ndarray) -> np.ndarray:
    """Return the generator (orbits, m) of each loop; a generator goes to the loop of whose motion it has most; numbers
    past the rank for none.
    """
    orbits, m = nu.shape
    total = share.sum(axis=2, keepdims=True)
    score = np.log(np.where(total > 0, share / np.where(total > 0, total, 1.0), 1.0) + 1e-12)
    score = np.where(moving[:, None, :] | (np.arange(m) >= rank[:, None])[:, :, None], score, -60.0)
    if m > 6:
        return _greedy(score)
    best = np.full(orbits, -np.inf)
    place = np.zeros((orbits, m), np.int64)
    for permutation in itertools.permutations(range(m)):  # loop j gets generator permutation[j]
        own = nu[:, permutation]
        kept = np.array(permutation) < rank[:, None]
        value = sum(score[:, k, j] for j, k in enumerate(permutation))
        for i, j in itertools.combinations(range(m), 2):
            value = value + ORDERED * ((own[:, i] < own[:, j]) & kept[:, i] & kept[:, j])
        better = value > best
        best, place = np.where(better, value, best), np.where(better[:, None], permutation, place)
    return place


def _greedy(score: np.ndarray) -> np.ndarray:
    """Return the assignment of generators to loops that takes the largest score first."""
    orbits, m, _ = score.shape
    place, left = np.zeros((orbits, m), np.int64), score.copy()
    for _ in range(m):
        k, j = np.unravel_index(left.reshape(orbits, -1).argmax(axis=1), (m, m))
        place[np.arange(orbits), j] = k
        left[np.arange(orbits), k, :] = -np.inf
        left[np.arange(orbits), :, j] = -np.inf
    return place


def values(signals: Signals, loops: Loops, orbits: np.ndarray, number: np.ndarray, threads: int) -> np.ndarray:
    """Return the values (count, samples) of loops given by their orbits (count,), of equally many samples, and their
    numbers (count,) in these.
    """
    f = np.empty((orbits.size, int(signals.samples[orbits[0]])), complex)
    run(loop_values, orbits.size, (signals.ragged, orbits, number, loops.complexes(), f), threads)
    return f
