"""Independent fundamental frequencies from samples of orbits: lattices of lines, loops of single modes, their rates.

Signals are (orbits, 2m, samples): Q and P of each of m loops in turn, equidistant in time. The lines of all loops
together span a lattice of frequencies; its generators nu_k have complex amplitudes A_k in the signals. The row d_k of
the dual basis to (A_1 ... A_r, conj A_1 ... conj A_r) makes a loop f_k = d_k . (s - centre) that has the line nu_k with
amplitude 1 and neither another generator nor its conjugate: of a linear system exactly one normal mode. Its line is
inverted for nu_k.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..engine.packing import launch
from ..engine.threads import by_workers
from .integer_lattice import ball
from .kernels import dual_loops, line_lattice, loop_lines, loop_transforms
from .kernels import fundamental as kernels
from .kernels.fundamental import FrequencyLattice, SignalRows, Vectors
from .kernels.harmonic_inversion import SPACING
from .kernels.line_lattice import FoundLattices, LatticeLimits, RankedLines
from .kernels.loop_transforms import SUMS, Bands, Spectra
from .kernels.loops import Loops, loop_values
from .signals import BUFFERS, Signals
from .windows import APART_ORDER, apart_window, cosine_window, fast_lengths, growth_windows, tables_for, tabulated

LINES = 16
"""Most lines of each loop: its peaks and the lines beside them."""

LONGEST = (40, 20, 10, 6, 5, 4, 3, 3)
"""Largest |k|_1 of a line in a lattice of rank 1, 2, ...; half of it where a line refines the lattice."""

FARTHEST = (1000, 60, 20, 12, 8, 6, 5, 4)
"""Largest |k|_1 of combinations, at ranks 1, 2, ..., that are no weak generators."""

BESIDE = (1000, 3, 2, 1, 1, 1, 1, 1)
"""The same of combinations whose neighbours within CLOSE are no weak generators either."""

BROAD = 0.1
"""Share of a loop's size that its strongest lines leave, beyond which weak ones are not sought, and not all are
known.
"""

FEW = 8
"""Orbits for which waking another thread takes longer than the work."""

BRIEF = 4096
"""The same of kernels of a microsecond an orbit."""

AT_ONCE = 32
"""Orbits whose Fourier transforms are made at once."""

SAMPLES_AT_ONCE = 1 << 13
"""Samples of loops that are in memory at once where their lines are sought: 1 MiB."""

LIMITS = LatticeLimits(sharp=0.1, minor=2e-3, visible=2e-3)
"""Error bar of a line, in cycles over the window, up to which it belongs to the lattice; and sizes, relative to its
loop's largest, from which it does, and from which the lattice must explain it.
"""

WEAKEST = (2, 5, 12)
"""Numbers of lines that are sought beside those of the known generators, one after the other."""

MODAL = 6
"""Lines that are sought in the loop of a mode."""

FAINT = 1e-10
"""Least amplitude of these, relative to the signals' sizes: 1e5 times the rounding errors."""

REMAINS = 1e-4
"""Amplitude, in the same unit, of a generator's line that is still there after it was removed: it has a neighbour that
the time does not resolve. Leakage of other lines is far below, that of lines 1e-3 cycles apart is above.
"""

CLOSE = 0.5
"""Distance, in cycles over the window, up to which a line is not told from a short combination."""

EXACT = 1e-4
"""Distance beyond its error bar, in the same unit, up to which a line is any combination."""

FOLDS = 3
"""Largest multiple of the sampling rate that is compared with combinations: fast lines appear folded at it."""

FOLDED = 1e-4
"""Relative amplitude near the highest frequency below which only the rate itself is."""

AT_REST = 1e-12
"""Relative size of a loop (root of its Q times its P) below which it is at rest."""

ORDERED = 0.02
"""Advantage of ascending frequencies, in the logarithm of shares: decides where coordinates share modes equally."""


class LatticeModes(NamedTuple):
    """Modes from the lines of loops: arrays over orbits first, then over m loops (NaN or 0 past the rank).

    rank: number of independent frequencies found; nu, spread: the frequency of each loop and its error bar, from lines;
    dominant, dominant_error: strongest line of each loop; combination (orbits, m, m): integers with dominant =
    combination @ nu, 0 where none is known; dual (orbits, m, 2m), offset, drift (orbits, m): the loop of each
    frequency, that of Q and P itself where a loop has none of its own; owned: mask of loops with their own; moving: of
    those that move; rest (orbits,): share of a loop's size that its lines leave, the largest one's; lines (orbits, 3,
    m, LINES): frequencies, error bars and amplitudes of the strongest lines; tail (orbits,): the largest amplitude near
    the highest frequency that samples show, relative to the loop's largest; unexplained_size (orbits,): the largest
    amplitude of a line that the frequencies do not explain, relative to its loop's largest.
    """

    rank: np.ndarray
    nu: np.ndarray
    spread: np.ndarray
    dominant: np.ndarray
    dominant_error: np.ndarray
    combination: np.ndarray
    dual: np.ndarray
    offset: np.ndarray
    drift: np.ndarray
    owned: np.ndarray
    moving: np.ndarray
    rest: np.ndarray
    lines: np.ndarray
    tail: np.ndarray
    unexplained_size: np.ndarray


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
    `frequencies.kernels.fundamental.relate`, and their numbers of vectors (ranks, 2).
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


def modes(signals: Signals, m: int, threads: int) -> LatticeModes:
    """Find the independent frequencies of the first 2m rows of signals."""
    spectra, bands = _transforms(signals, m, threads)
    found = _lattices(signals, spectra, bands, threads)
    _complete(found, signals, spectra, threads)
    return _in_units_of(found, spectra, np.arange(signals.samples.size))


def _in_units_of(found: LatticeModes, spectra: Spectra, orbits: np.ndarray) -> LatticeModes:
    """Return the modes of these orbits with loops of the signals themselves, from those in units of their sizes."""
    rows = spectra.rows
    dual = found.dual / rows.size[orbits, None]
    offset, step = (dual * entry[orbits, None] for entry in (rows.centre, rows.drift))
    return found._replace(dual=dual, offset=offset.sum(axis=2), drift=step.sum(axis=2))


def store_rows(table: NamedTuple, orbits: np.ndarray, found: NamedTuple) -> None:
    """Fill in the results of these orbits, arrays (orbits, ...)."""
    for old, new in zip(table, found, strict=True):
        old[orbits] = new


def taken(table: Any, orbits: np.ndarray) -> Any:
    """Return a tuple of arrays (orbits, ...) of these orbits alone."""
    return type(table)(*(entry[orbits] for entry in table))


def _no_modes(orbits: int, m: int) -> LatticeModes:
    """Return empty modes."""
    zero = np.zeros((orbits, m))
    none = np.zeros((orbits, m), bool)
    return LatticeModes(
        rank=np.zeros(orbits, np.int64),
        nu=zero.copy(),
        spread=np.full((orbits, m), np.inf),
        dominant=zero.copy(),
        dominant_error=np.full((orbits, m), np.inf),
        combination=np.zeros((orbits, m, m), np.int64),
        dual=np.zeros((orbits, m, 2 * m), complex),
        offset=zero.astype(complex),
        drift=zero.astype(complex),
        owned=none.copy(),
        moving=none.copy(),
        rest=np.zeros(orbits),
        lines=np.zeros((orbits, 3, m, LINES)),
        tail=np.zeros(orbits),
        unexplained_size=np.zeros(orbits),
    )


def _no_lattice(orbits: int, m: int) -> FrequencyLattice:
    """Return lattices without generators."""
    nu, spread = np.zeros((2, orbits, m))
    return FrequencyLattice(np.zeros(orbits, np.int64), nu, spread, np.full((orbits, m), -1))


def prepared(
    signals: np.ndarray, n: int, threads: int, at_rest: float = AT_REST**2
) -> tuple[np.ndarray, np.ndarray, SignalRows]:
    """Return the first n samples of the rows, the loops (orbits, m, n), and the properties of the rows; see
    `frequencies.kernels.fundamental.prepare`.
    """
    orbits = len(signals)
    rows = signals.shape[1]
    m = signals.shape[1] // 2
    x = np.empty((orbits, rows, n))
    loops = np.empty((orbits, m, n), complex)
    found = _rows(orbits, m)
    run(kernels.prepare, orbits, (signals, cosine_window(n), growth_windows(n), at_rest, x, loops, found), threads)
    return x, loops, found


def _rows(orbits: int, m: int) -> SignalRows:
    """Return the arrays for the properties of rows."""
    drift, centre, size = np.empty((3, orbits, 2 * m))
    return SignalRows(drift, centre, size, np.zeros((orbits, m), bool))


@tabulated
def _windows(n: int) -> np.ndarray:
    """Return the tables of n samples for `frequencies.kernels.loop_transforms.prepare_transforms`."""
    return np.concatenate([cosine_window(n), apart_window(n), *growth_windows(n)])


def _transforms(signals: Signals, m: int, threads: int) -> tuple[Spectra, Bands]:
    """Return the Fourier transforms of the loops of the first 2m rows: windowed, and for harmonic inversion."""
    n = fast_lengths(signals.samples)
    size = band_sizes(n)
    orbits = n.size
    start, begin = (np.cumsum(m * count) - m * count for count in (n, SUMS * size))
    spectra = Spectra(BUFFERS.spectra.array(2 * m * int(n.sum())), start, n, _rows(orbits, m))
    bands = Bands(
        BUFFERS.bands.array(2 * m * SUMS * int(size.sum())), begin, size, np.empty((orbits, m, 2, 3), complex)
    )
    arguments = signals.ragged, tables_for(_windows, n), AT_REST**2, spectra, bands
    run(loop_transforms.prepare_transforms, orbits, arguments, threads)
    spectra = spectra._replace(numbers=spectra.numbers.view(complex))
    bands = bands._replace(numbers=bands.numbers.view(complex))
    parts = [*_alike(spectra.numbers, start, n, m), *_alike(bands.numbers, begin, size, m * SUMS)]

    def transform(first: int) -> None:
        for part in parts[first::threads]:
            np.fft.fft(part, axis=-1, out=part)

    by_workers(transform, threads)
    return spectra, bands


def band_sizes(n: np.ndarray) -> np.ndarray:
    """Return the number of functions of the bands of n samples (orbits,), whose Fourier transforms are fast."""
    from scipy.fft import next_fast_len  # not at import, which it would make slow

    different, which = np.unique(n, return_inverse=True)
    return np.array([next_fast_len(math.ceil(int(count) / SPACING)) for count in different], dtype=np.int64)[which]


def _alike(numbers: np.ndarray, start: np.ndarray, size: np.ndarray, rows: int) -> Iterator[np.ndarray]:
    """Yield arrays (rows, size) of the numbers of neighbouring orbits of one size (orbits,), AT_ONCE or fewer."""
    begin = 0
    for end in range(1, size.size + 1):
        if end == size.size or size[end] != size[begin] or end - begin == AT_ONCE:
            count = int(size[begin])
            first = int(start[begin])
            yield numbers[first : first + (end - begin) * rows * count].reshape(-1, count)
            begin = end


def _lattices(signals: Signals, spectra: Spectra, bands: Bands, threads: int) -> LatticeModes:
    """Return the modes of orbits by the lattices of the lines of their loops, without weak ones."""
    moving = spectra.rows.moving
    h = signals.interval
    orbits, m = moving.shape
    lines = RankedLines(*np.zeros((3, orbits, m, LINES)))
    found = FoundLattices(lines, _no_lattice(orbits, m), *np.zeros((3, orbits)))
    arguments = spectra, bands, APART_ORDER, LIMITS, tables_of(m), found
    run(line_lattice.find_lattice, orbits, arguments, threads)
    unit = (spectra.n * h)[:, None]
    lattice = found.lattice._replace(nu=found.lattice.nu / unit, spread=found.lattice.spread / unit)
    value = lines.value / unit[:, :, None]
    bar = lines.bar / unit[:, :, None]
    made = _dual(signals, spectra, np.arange(orbits), lattice.rank, lattice.nu, threads)
    result = _no_modes(orbits, m)
    _place(result, lattice, made, value[:, :, 0].copy(), bar[:, :, 0].copy(), moving, threads)
    result.lines[:] = np.stack([value, bar, lines.strength], axis=1)
    result.rest[:], result.tail[:], result.unexplained_size[:] = found.rest, found.tail, found.unexplained_size
    return result


def _complete(found: LatticeModes, signals: Signals, spectra: Spectra, threads: int) -> None:
    """Add weak generators to the modes of orbits whose lattice is incomplete and whose lines are few.

    Combinations of the rows that have none of the generators' lines show what else moves, however weak it is beside
    these. Its lines are generators where no combination of the known ones is as close as half the resolution.
    """
    left = np.flatnonzero((found.rank > 0) & (found.rank < found.moving.sum(axis=1)) & (found.rest <= BROAD))
    for _ in range(found.moving.shape[1]):
        before = found.rank.copy()
        for lines in WEAKEST:  # more of them than there are would be rounding errors, which blur those beside them
            some = left[(found.rank[left] == before[left]) & (found.rank[left] < found.moving[left].sum(axis=1))]
            if some.size:
                now = _with_weak(taken(found, some), signals, spectra, some, lines, threads)
                store_rows(found, some, now)
        left = left[found.rank[left] > before[left]]


def _with_weak(
    found: LatticeModes, signals: Signals, spectra: Spectra, orbits: np.ndarray, lines: int, threads: int
) -> LatticeModes:
    """Return the modes of some orbits with further generators among so many lines that are weak beside the known
    ones'.
    """
    m = found.moving.shape[1]
    count = orbits.size
    nu, spread = np.zeros((2, count, m))
    for o in range(count):
        own = found.owned[o]
        nu[o, : own.sum()], spread[o, : own.sum()] = found.nu[o, own], found.spread[o, own]
    value, bar, strength = _weak_lines(found, nu, signals, spectra, orbits, lines, threads)
    time = (spectra.n * signals.interval)[orbits, None]
    most = value.shape[1]
    rate = 1 / signals.interval[orbits]
    near, exact = _explained(value, bar, nu, spread, time, rate[:, None], bool((found.tail > FOLDED).any()), threads)
    # The lines of generators have been removed: one that remains has a neighbour, closer than the resolution.
    apart = np.abs(value[:, :, None] - np.where(found.owned, found.nu, np.inf)[:, None, :]).min(axis=2)
    remains = (apart <= bar + EXACT / time) & (strength > REMAINS)
    unexplained = np.where((strength > FAINT) & (~exact | remains), strength, 0.0).max(axis=1, initial=0.0)
    used = (strength > FAINT) & ~near & ~exact & (bar * time < LIMITS.sharp)
    used &= strength > LIMITS.minor * strength.max(axis=1, keepdims=True)
    order = np.argsort(-np.where(used, strength, 0.0), axis=1, kind="stable")
    value, bar = (np.take_along_axis(entry, order, axis=1) for entry in (value, bar))
    values_of, bars_of = np.zeros((2, count, m + most))
    for o in range(count):
        r = found.rank[o]
        new = used[o].sum()
        values_of[o, :r], bars_of[o, :r] = nu[o, :r], spread[o, :r]
        values_of[o, r : r + new], bars_of[o, r : r + new] = value[o, :new], bar[o, :new]
    lattice = _no_lattice(count, m)
    arguments = values_of, bars_of, found.rank + used.sum(axis=1), tables_of(m), rate, lattice
    run(kernels.generators, count, arguments, threads, BRIEF)
    made = _dual(signals, spectra, orbits, lattice.rank, lattice.nu, threads)
    result = taken(found, np.arange(count))
    top = found.dominant
    top_bar = found.dominant_error
    _place(result, lattice, made, top, top_bar, found.moving, threads)
    complete = result.rank == result.moving.sum(axis=1)
    result.unexplained_size[:] = np.maximum(found.unexplained_size, np.where(complete, 0.0, unexplained))
    return result


def _explained(
    value: np.ndarray,
    bar: np.ndarray,
    nu: np.ndarray,
    spread: np.ndarray,
    time: np.ndarray,
    rate: np.ndarray,
    aliased: bool,
    threads: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return masks of lines (orbits, lines) that are not told from short combinations of nu (orbits, m), also modulo
    the sampling rate, and of those that are combinations within their bars; time, rate (orbits, 1). aliased: whether
    several multiples of the rate count.
    """
    m = nu.shape[1]
    (count, most) = value.shape
    near, exact = np.zeros((2, *value.shape), bool)
    folds = range(1, 1 + (FOLDS if aliased else 1))
    places = value, *(fold * rate + sign * value for fold in folds for sign in (-1, 1))
    lines = np.zeros((len(places), count, -(-most // m) * m))
    widths = np.zeros((2, *lines.shape[1:]))
    for entry, place in zip(lines, places, strict=True):
        entry[:, :most] = np.where(value > 0, place, 0.0)
    widths[0, :, :most] = np.maximum(bar, CLOSE / time)
    widths[1, :, :most] = bar + EXACT / time
    tables = [(near, widths[0], tables_of(m, BESIDE)), (exact, widths[1], tables_of(m, FARTHEST))]
    for first, entry, (mask, width, table) in itertools.product(range(0, most, m), lines, tables):
        part = slice(first, first + m)
        k = np.zeros((count, m, m), np.int64)
        chosen = (np.ascontiguousarray(some[:, part]) for some in (entry, width))
        run(kernels.combinations, count, (*chosen, nu, spread, table, k), threads, BRIEF)
        mask[:, part] |= np.abs(k).max(axis=2)[:, : most - first] > 0
    return near, exact


def _weak_lines(
    found: LatticeModes,
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
    m = found.moving.shape[1]
    count = orbits.size
    rows = spectra.rows
    amplitude = _dual(signals, spectra, orbits, found.rank, nu, threads).amplitude
    moving = np.repeat(found.moving, 2, axis=1)
    c = np.zeros((count, m, signals.rows), complex)
    for o in range(count):
        r = int(found.rank[o])
        own = np.flatnonzero(moving[o])
        some_lines = amplitude[o, :r][:, own].T
        left = np.linalg.svd(np.concatenate([some_lines.real, some_lines.imag], axis=1))[0][:, 2 * r :]
        for j in range(left.shape[1] // 2):
            c[o, j, own] = left[:, 2 * j] - 1j * left[:, 2 * j + 1]
    c[:, :, : 2 * m] /= rows.size[orbits][:, None]
    offset, drift = ((c[:, :, : 2 * m] * entry[orbits][:, None]).sum(axis=2) for entry in (rows.centre, rows.drift))
    return _lines_in(signals.of(orbits), Loops(c, offset, drift), spectra.n[orbits], lines, threads)


def _lines_in(
    signals: Signals, loops: Loops, samples: np.ndarray, lines: int, threads: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frequencies, error bars and amplitudes (orbits, m lines) of so many lines of each of m loops, over so many
    samples (orbits,).
    """
    count, m = loops.c.shape[:2]
    value, bar, strength = np.zeros((3, count, m * lines))
    for alike in signals.alike():
        row, place = np.nonzero(loops.c[alike].any(axis=2))
        owner = alike[row]
        at_once = max(1, min(AT_ONCE, SAMPLES_AT_ONCE // int(samples[alike[0]])))
        for begin in range(0, owner.size, at_once):
            part = slice(begin, begin + at_once)
            f = values(signals, loops, owner[part], place[part], threads)[:, : samples[alike[0]]]
            got = lines_of(f, lines, threads)
            unit = f.shape[1] * float(signals.interval[alike[0]])
            known = (np.abs(got.value) > 2) & (got.strength > 0) & (got.bar < 1)
            for i, (orbit, loop) in enumerate(zip(owner[part], place[part], strict=True)):
                at = slice(loop * lines, (loop + 1) * lines)
                value[orbit, at] = np.where(known[i], np.abs(got.value[i]), 0.0) / unit
                bar[orbit, at] = np.where(known[i], got.bar[i], 0.0) / unit
                strength[orbit, at] = np.where(known[i], got.strength[i], 0.0)
    return value, bar, strength


def has_other_lines(signals: Signals, loops: Loops, found: LatticeModes, threads: int) -> np.ndarray:
    """Return a mask of orbits of which the loops of modes have a sharp, visible line that the frequencies do not
    explain: these may be harmonics of a line that lies next to another one in all coordinates.
    """
    m = found.nu.shape[1]
    nu = np.where(found.owned, found.nu, 0.0)
    spread = np.where(found.owned, found.spread, 0.0)
    value, bar, strength = _lines_in(signals, loops, fast_lengths(signals.samples), MODAL, threads)
    time = signals.time[:, None]
    aliased = bool((found.tail > FOLDED).any())
    _, exact = _explained(value, bar, nu, spread, time, 1 / signals.interval[:, None], aliased, threads)
    largest = strength.reshape(-1, m, MODAL).max(axis=2, keepdims=True)
    seen = (strength.reshape(-1, m, MODAL) > LIMITS.visible * largest).reshape(strength.shape)
    return (seen & (bar * time < LIMITS.sharp) & ~exact).any(axis=1)


def lines_of(f: np.ndarray, lines: int, threads: int) -> RankedLines:
    """Return the strongest lines of signals f (signals, samples), complex: places in bins, signed, error bars and sizes
    (signals, lines).
    """
    place, strength, bar = np.zeros((3, len(f), lines))
    arguments = *transforms_of(f, threads), APART_ORDER, place, strength, bar
    run(loop_lines.lines_of_values, len(f), arguments, threads)
    return RankedLines(place, bar, strength)


def transforms_of(f: np.ndarray, threads: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the Fourier transforms of signals f (signals, samples), complex: windowed, and for harmonic inversion; and
    the edges of the sums of these; until the next call. See `loop_transforms.prepare_values`.
    """
    count, n = f.shape
    size = int(band_sizes(np.array([n]))[0])
    windowed = BUFFERS.windowed.complexes(count, n)
    sums = BUFFERS.sums.complexes(count, SUMS, size)
    edges = np.empty((count, 2, 3), complex)
    real = np.ascontiguousarray(f).view(float), apart_window(n), windowed.view(float), sums.view(float)
    run(loop_transforms.prepare_values, count, (*real, edges), threads)
    np.fft.fft(windowed, axis=-1, out=windowed)
    np.fft.fft(sums, axis=-1, out=sums)
    return windowed, sums, edges


def _place(
    result: LatticeModes,
    lattice: FrequencyLattice,
    made: dual_loops.Duals,
    top: np.ndarray,
    top_bar: np.ndarray,
    moving: np.ndarray,
    threads: int,
) -> None:
    """Fill in generators, each with the loop of whose motion it has most, and dominant lines `top`."""
    rank, nu, spread, _ = lattice
    orbits, m = nu.shape
    place = places(made.share, nu, rank, moving)
    rows = np.arange(orbits)[:, None]
    owned = place < rank[:, None]
    nu = nu[rows, place]
    spread = spread[rows, place]
    plain = np.zeros((m, 2 * m), complex)
    plain[np.arange(m), 2 * np.arange(m)] = 1.0
    plain[np.arange(m), 2 * np.arange(m) + 1] = -1j
    nu = np.where(owned, nu, 0.0)
    spread = np.where(owned, spread, np.inf)
    top_bar = np.where(top > top_bar, top_bar, np.inf)  # else it cannot be distinguished from 0
    run(kernels.combinations, orbits, (top, top_bar, nu, spread, tables_of(m), result.combination), threads, BRIEF)
    result.rank[:] = rank
    result.owned[:] = owned
    result.moving[:] = moving
    result.dual[:] = np.where(owned[:, :, None], made.dual[rows, place], plain * moving[:, :, None])
    # A loop without a frequency of its own shows its dominant line, which depends on the others.
    result.nu[:] = np.where(owned, nu, top)
    result.spread[:] = np.where(owned, spread, top_bar)
    result.dominant[:] = top
    result.dominant_error[:] = top_bar


def _dual(
    signals: Signals, spectra: Spectra, which: np.ndarray, rank: np.ndarray, nu: np.ndarray, threads: int
) -> dual_loops.Duals:
    """Return the amplitudes of the lines nu (orbits, m) in the signals of some orbits, and what follows from them."""
    orbits, m = nu.shape
    made = dual_loops.Duals(
        amplitude=np.zeros((orbits, 2 * m, 2 * m), complex),
        dual=np.zeros((orbits, m, 2 * m), complex),
        share=np.zeros((orbits, m, m)),
    )
    n = spectra.n[which]
    own = signals.of(which)
    found = spectra.rows
    # Rows at rest are rounding errors, which in units of their size would be as large as motions.
    units = np.where(np.repeat(found.moving[which], 2, axis=1), 1 / found.size[which], 0.0)
    scaling = found.drift[which], found.centre[which], units
    tables = tables_for(cosine_window, n)
    arguments = own.ragged, n, tables, own.interval, scaling, rank, nu, made
    run(dual_loops.dual_loops, orbits, arguments, threads)
    return made


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
        best = np.where(better, value, best)
        place = np.where(better[:, None], permutation, place)
    return place


def _greedy(score: np.ndarray) -> np.ndarray:
    """Return the assignment of generators to loops that takes the largest score first."""
    orbits, m, _ = score.shape
    place = np.zeros((orbits, m), np.int64)
    left = score.copy()
    for _ in range(m):
        k, j = np.unravel_index(left.reshape(orbits, -1).argmax(axis=1), (m, m))
        place[np.arange(orbits), j] = k
        left[np.arange(orbits), k, :] = -np.inf
        left[np.arange(orbits), :, j] = -np.inf
    return place


def values(signals: Signals, loops: Loops, orbits: np.ndarray, number: np.ndarray, threads: int) -> np.ndarray:
    """Return the values (count, samples) of loops given by their orbits (count,), of equally many samples, and their
    numbers (count,) in these; until the next call.
    """
    f = BUFFERS.values.complexes(orbits.size, int(signals.samples[orbits[0]]))
    run(loop_values, orbits.size, (signals.ragged, orbits, number, loops.complexes(), f), threads)
    return f
