"""Modes of coupled planes of maps: loops of one line each, for orbits whose planes show the same line, or each other's.

The lines of all planes, by harmonic inversion, span a lattice of frequencies modulo 1; the strongest independent ones
are its generators g_k. The rows of the inverse of their amplitudes (A_1 ... A_n, conj A_1 ... conj A_n) in the planes
make loops with the line g_k alone among these: planes again, whose tunes are found as those of any.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from ..engine.plane_loops import COLUMNS
from .fundamental import places
from .integer_lattice import ball, one_of_each
from .plane_lines import PlaneLines, plane_lines
from .readings import SAME
from .turning import CHANCE, CHANGED, from_whole
from .windows import cosine_window, fast_length

LINES = 6
"""Lines of a plane, beyond the number of planes, among which generators are sought."""

LONGEST = (12, 10, 6, 4, 3)
"""Largest |k|_1 of combinations of 1, 2, ... tunes; 2 of more."""

SHARP = 0.1
"""Error bar of a line, in cycles over the samples, up to which it is one line: it is wider where the samples do not
separate another one from it.
"""

WIDTH = 1e-7
"""Least width of a line, in cycles over the samples."""

CLEAN = 1e-13
"""Product of a line's error bar, in cycles per sample, and its relative amplitude up to which it is that of rounding:
another line beside it, however close, makes it larger.
"""

ONE = 1e-3
"""Cycles over the samples up to which the lines of two planes are one, whatever their error bars."""

PARTS = 3
"""Largest m of a line that is a combination of generators over m."""

VISIBLE = 1e-9
"""Smallest amplitude of a line, relative to its plane's largest."""

RESOLVED = 1.5
"""Cycles over the samples from which two lines are told apart."""

BESIDE = (6, 6, 5, 4)
"""Largest |k|_1 of combinations of 1, 2, ... tunes whose beats are compared with RESOLVED; 3 of more."""

HIDDEN = 5.0
"""Factor of the amplitudes that lines which are not told apart may have over those of the others of their order."""

SHOWS = 0.3
"""Ratio of these amplitudes to a mode's own from which the mode has no tune of its own."""

HARMONIC = 4
"""Largest harmonic of another plane's tune that a plane may show."""

CAUGHT = 0.1
"""Share of the smallest tune by which the lines of an orbit that is caught in such a resonance, and swings about it,
may differ from it.
"""

DRIFTS = 0.6
"""Change of a loop's strongest line between the halves, in cycles over a half, beyond which an orbit is chaotic."""

APART = 1e-7
"""Smallest over largest singular value of amplitudes that assign lines to planes."""


def plane_values(z: np.ndarray, planes: np.ndarray) -> np.ndarray:
    """Return the loops (orbits, n, samples) of z (2n, orbits, samples) about their centres, as circles: planes (orbits,
    n, COLUMNS.end).
    """
    n = len(z) // 2
    known = planes.transpose(1, 0, 2)[..., None]
    x = z[:n] - known[:, :, COLUMNS.q]
    y = z[n:] - known[:, :, COLUMNS.p]
    f = known[:, :, COLUMNS.a] * x + 1j * (known[:, :, COLUMNS.b] * x + known[:, :, COLUMNS.c] * y)
    return np.ascontiguousarray(f.swapaxes(0, 1))


class PlaneModes(NamedTuple):
    """Modes of orbits with n planes.

    known (orbits,): a mask of orbits with n lines of independent amplitudes; nu (n, known orbits): these lines; planes
    (2n, known orbits, samples): each mode in the place, and in the sense, of the loop of whose motion it has most;
    shift (n, known orbits): the turns by which lines that are not told apart from a mode's own may shift its tune;
    ambiguous (orbits,): a mask of orbits of which such lines, or strong ones that are not sharp, leave the modes
    unknown; few (orbits,): of those with fewer independent lines, periodic (orbits,): of those that have surely no
    others.
    """

    known: np.ndarray
    nu: np.ndarray
    planes: np.ndarray
    shift: np.ndarray
    ambiguous: np.ndarray
    few: np.ndarray
    periodic: np.ndarray


def modes_of(f: np.ndarray, harmonic: np.ndarray) -> PlaneModes:
    """Return the modes of loops f (orbits, n, samples). Orbits that show a `harmonic` (n, orbits) are taken without
    their combined lines.
    """
    n = f.shape[1]
    samples = fast_length(f.shape[2])
    lattice, found = _generators(f[:, :, :samples])
    g = lattice.nu
    known = lattice.known.copy()
    ambiguous = lattice.ambiguous.copy()
    f = f[known]
    g = g[known]
    some = np.flatnonzero(known)
    alone = harmonic[:, known].any(axis=0)
    f[alone] -= _combined(found.of(some[alone]), g[alone], f.shape[2])
    plus, minus = _amplitudes(f[:, :, :samples], g)  # (orbits, n loops, n lines): of +g and of -g
    size = np.hypot(np.abs(plus), np.abs(minus))
    shift, hidden = _hidden(lattice.decay[known], g, size, samples)
    alone = lattice.periodic[known]
    shift[alone] = 0.0
    hidden[alone] = False
    every = np.ones(size.shape[::2], bool)
    place = places(size.swapaxes(1, 2) ** 2, np.abs(g), every.sum(axis=1), every)  # whatever the modes' amplitudes
    each = np.arange(len(f))[:, None]
    loop = np.arange(n)
    plus = plus[each, :, place].swapaxes(1, 2)
    minus = minus[each, :, place].swapaxes(1, 2)
    # f = plus e + minus conj(e), and its conjugate
    whole = np.concatenate(
        [np.concatenate([plus, minus], axis=2), np.concatenate([minus.conj(), plus.conj()], axis=2)], axis=1
    )
    size = np.linalg.norm(whole, axis=1, keepdims=True)
    size = np.linalg.svd(whole / np.where(size > 0, size, 1.0), compute_uv=False)
    sound = size[:, -1] > APART * size[:, 0]
    known[some] = sound
    ambiguous[some[sound]] |= hidden[sound]
    back = np.linalg.inv(whole[sound])[:, :n]
    e = back[:, :, :n] @ f[sound] + back[:, :, n:] @ f[sound].conj()
    other = (np.abs(plus) < np.abs(minus))[:, loop, loop][sound]
    e = np.where(other[:, :, None], e.conj(), e).swapaxes(0, 1)
    g, shift = (np.take_along_axis(rows, place, axis=1)[sound] for rows in (g, shift))
    return PlaneModes(
        known=known,
        nu=np.where(other, -g, g).T,
        planes=np.concatenate([e.real, -e.imag]),
        shift=shift.T,
        ambiguous=ambiguous,
        few=lattice.few,
        periodic=lattice.periodic,
    )


def _combined(found: PlaneLines, g: np.ndarray, samples: int) -> np.ndarray:
    """Return the part (orbits, n, samples) of loops in their found lines, without +g and -g (orbits, n)."""
    apart = np.abs(found.nu)[..., None] - np.abs(g)[:, None, None]
    others = (from_whole(apart) * samples > SAME).all(axis=3)
    amplitude = np.where(others & np.isfinite(found.error), found.amplitude, 0.0)
    result = np.zeros((*amplitude.shape[:2], samples), complex)
    for nu, a in zip(np.moveaxis(found.nu, 2, 0), np.moveaxis(amplitude, 2, 0), strict=True):
        turns = nu[..., None] * np.arange(samples)
        result += a[..., None] * np.exp(2j * np.pi * (turns - np.rint(turns)))
    return result


class _Lattice(NamedTuple):
    """The lattice of the lines of orbits.

    nu (orbits, n): the strongest independent lines; where there are fewer than n, the strongest others behind them.
    known (orbits,): a mask of orbits with n lines; ambiguous (orbits,): of those with a strong line that is not sharp;
    periodic (orbits,): of those whose lines are all combinations of fewer; few (orbits,): of others with fewer. decay
    (orbits,): the factor by which amplitudes fall with each step of |k|_1.
    """

    nu: np.ndarray
    known: np.ndarray
    ambiguous: np.ndarray
    few: np.ndarray
    periodic: np.ndarray
    decay: np.ndarray


def _generators(f: np.ndarray) -> tuple[_Lattice, PlaneLines]:
    """Return the lattices of loops f (orbits, n, samples), and all lines found."""
    orbits, n, samples = f.shape
    found = plane_lines(f, n + LINES)
    size = np.abs(found.amplitude)
    width = found.error + WIDTH / samples
    size = np.where(np.isfinite(width), size / np.maximum(size.max(axis=2, keepdims=True), 1e-300), 0.0)
    # A line next to 0 is the centre's; one next to a half turn has no sense.
    visible = (size > VISIBLE) & (np.abs(found.nu) * samples > 2) & (np.abs(np.abs(found.nu) - 0.5) * samples > 1)
    order = np.argsort(-(size + 2.0 * (size == 1.0)).reshape(orbits, -1), axis=1, kind="stable")
    nu, width, size, visible = (
        np.take_along_axis(rows.reshape(orbits, -1), order, axis=1) for rows in (found.nu, width, size, visible)
    )
    sharp = visible & (width * samples < SHARP)
    k = ball(n, LONGEST[n - 1] if n <= len(LONGEST) else 2)
    length = np.abs(k).sum(axis=1)
    every = np.arange(orbits)
    one = np.where(length == 1, ONE / samples, 0.0)
    g = np.zeros((orbits, n))
    spread = np.zeros((orbits, n))
    rank = np.zeros(orbits, int)
    least = np.ones(orbits)
    for line, wide, part, there in zip(nu.T, width.T, size.T, sharp.T, strict=True):
        combined = g @ k.T
        blur = spread @ np.abs(k).T
        related = np.zeros(orbits, bool)
        for m in range(1, PARTS + 1):
            near = from_whole(m * line[:, None] - combined) < np.maximum(blur + m * wide[:, None], one)
            if m > 1:  # a generator is a multiple of this line
                single = near & (length == 1)
                which = np.abs(k[single.argmax(axis=1)]).argmax(axis=1)
                finer = there & ~related & single.any(axis=1) & (which < rank)
                g[every[finer], which[finer]], spread[every[finer], which[finer]] = line[finer], wide[finer]
                least[finer] = np.minimum(least, part)[finer]
            related |= near.any(axis=1)
        new = there & ~related & (rank < n)
        g[every[new], rank[new]], spread[every[new], rank[new]] = line[new], wide[new]
        rank[new] += 1
        least[new] = np.minimum(least, part)[new]
    decay = _decay(nu, width, np.where(sharp, size, 0.0), g, spread, k)
    # A line that is not sharp is none of the lattice: a stronger one than a generator may be a mode.
    ambiguous = (visible & ~sharp & (size >= least[:, None])).any(axis=1)
    excess = (np.where(visible, width, 0.0) - WIDTH / samples) * size
    periodic = (rank < n) & (excess <= CLEAN).all(axis=1)
    few = (rank < n) & ~periodic
    known = _completed(g, rank, nu, sharp & ~(ambiguous | few)[:, None], samples)
    return _Lattice(g, known, ambiguous, few, periodic, decay), found


def _decay(
    nu: np.ndarray, width: np.ndarray, size: np.ndarray, g: np.ndarray, spread: np.ndarray, k: np.ndarray
) -> np.ndarray:
    """Return the factor (orbits,) by which amplitudes fall with each step of |k|_1, by lines nu (orbits, lines) of
    relative size that are combinations k of generators; others count as the shortest.
    """
    combined = g @ k.T
    blur = spread @ np.abs(k).T
    length = np.abs(k).sum(axis=1)
    result = np.full(len(nu), VISIBLE)
    for line, wide, part in zip(nu.T, width.T, size.T, strict=True):
        near = from_whole(line[:, None] - combined) < blur + wide[:, None]
        steps = np.where(near, length, 99).min(axis=1)
        steps = np.where(steps < 99, steps, 2)
        result = np.where(steps > 1, np.maximum(result, part ** (1 / np.maximum(steps - 1, 1))), result)
    return result


def _completed(g: np.ndarray, rank: np.ndarray, nu: np.ndarray, usable: np.ndarray, samples: int) -> np.ndarray:
    """Fill generators g (orbits, n) up behind their rank (orbits,), with the first usable ones of the lines nu (orbits,
    lines) that are not among them; return a mask (orbits,) of those with n.
    """
    rank = rank.copy()
    n = g.shape[1]
    every = np.arange(len(g))
    for line, there in zip(nu.T, usable.T, strict=True):
        taken = np.arange(n) < rank[:, None]
        apart = np.minimum(from_whole(line[:, None] - g), from_whole(line[:, None] + g)) * samples
        new = there & (rank > 0) & (rank < n) & (np.where(taken, apart, np.inf).min(axis=1) > RESOLVED)
        g[every[new], rank[new]] = line[new]
        rank[new] += 1
    return rank == n


def _hidden(decay: np.ndarray, g: np.ndarray, size: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the turns (orbits, n) by which lines that are not told apart from those of modes g (orbits, n) may shift
    them, and a mask (orbits,) of orbits with a mode that may be such a line; size (orbits, loops, modes).
    """
    own = (size / np.maximum(size.max(axis=2, keepdims=True), 1e-300)).max(axis=1)
    shift = np.zeros_like(g)
    hidden = np.zeros(len(g), bool)
    n = g.shape[1]
    for k in one_of_each(ball(n, BESIDE[n - 1] if n <= len(BESIDE) else 3)[1:]):
        order = np.abs(k).sum()
        beat = from_whole(g @ k)
        close = (order > 1) & (beat * samples < RESOLVED)
        for j in np.flatnonzero(k):
            ratio = np.where(close, HIDDEN * decay ** (order - 2) / np.maximum(own[:, j], VISIBLE), 0.0)
            shift[:, j] = np.maximum(shift[:, j], np.minimum(ratio, 1.0) * beat)
            hidden |= ratio > SHOWS
    return shift, hidden


def _amplitudes(f: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitudes (orbits, loops, lines) of the lines g and -g (orbits, lines) in loops f (orbits, loops,
    samples), fitted together with the mean.
    """
    n = g.shape[1]
    w = cosine_window(f.shape[2])
    turns = g[:, :, None] * np.arange(f.shape[2])
    own = np.exp(2j * np.pi * (turns - np.rint(turns)))
    lines = np.concatenate([own, own.conj(), np.ones_like(own[:, :1])], axis=1)
    weighted = (w * lines.conj()).swapaxes(1, 2)
    amplitude = (f @ weighted) @ np.linalg.pinv(lines @ weighted, rcond=1e-12)
    return amplitude[:, :, :n], amplitude[:, :, n : 2 * n]


def restless(f: np.ndarray, halves: np.ndarray, length: int) -> np.ndarray:
    """Return a mask of loops f (signals, samples) of chaotic orbits: their mean turns change from half to half (2,
    signals), and their strongest line is not among the three strongest of both halves.
    """
    result = length / 2 * np.abs(halves[0] - halves[1]) > CHANGED
    some = f[result]
    dominant = np.abs(plane_lines(some, 1, beside=False).nu)
    half = f.shape[1] // 2
    change = np.zeros(len(some))
    for part in (some[:, :half], some[:, -half:]):
        found = plane_lines(part, 3, beside=False)
        near = np.where(np.isfinite(found.error), np.abs(np.abs(found.nu) - dominant), np.inf)
        change = np.maximum(change, near.min(axis=1, initial=np.inf) * half)
    result[result] = change > DRIFTS
    return result


def entangled(nu: np.ndarray, length: int | np.ndarray) -> np.ndarray:
    """Return a mask (orbits,) of orbits with two tunes nu (n, orbits) that so many steps do not tell apart."""
    result = np.zeros(nu.shape[1], bool)
    for one, other in itertools.combinations(nu, 2):
        for apart in (one - other, one + other):
            result |= from_whole(apart) * length < RESOLVED
    return result


def driven(nu: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return a mask of tunes nu (n, orbits), with their errors, that are harmonics of another one: the plane that shows
    one may have a weaker tune of its own.
    """
    result = np.zeros(nu.shape, bool)
    for i, j in itertools.permutations(range(len(nu)), 2):
        for k in range(2, HARMONIC + 1):
            width = error[i] + k * error[j]
            width[width > CHANCE] = -1.0
            for apart in (nu[i] - k * nu[j], nu[i] + k * nu[j]):
                result[i] |= from_whole(apart) <= width
    return result


def own_tunes(nu: np.ndarray, harmonic: np.ndarray, modes: np.ndarray, length: int) -> np.ndarray:
    """Return a mask (orbits,) of orbits whose `modes` (n, orbits) replace those of nu (n, orbits) that are harmonics
    (n, orbits) by own tunes and keep the others; not of orbits caught in a resonance, which swing slowly.
    """
    change = from_whole(modes - nu)
    fits = np.where(harmonic, change > CAUGHT * from_whole(modes).min(axis=0), change * length < SAME).all(axis=0)
    return np.asarray(fits & harmonic.any(axis=0))


def other_lines(nu: np.ndarray, lines: np.ndarray, length: int) -> np.ndarray:
    """Return a mask (orbits,) of orbits with a tune of nu (n, orbits) that is none of their lines (n, orbits)."""
    apart = np.minimum(from_whole(nu[:, None] - lines), from_whole(nu[:, None] + lines)) * length
    return np.asarray((apart.min(axis=1) > SAME).any(axis=0))
