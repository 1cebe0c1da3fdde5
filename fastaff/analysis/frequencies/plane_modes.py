"""Modes of coupled planes of maps: loops of one line each, for orbits whose planes show the same line, or each other's.

The lines of all planes together span a lattice of frequencies modulo 1; the strongest independent ones are its
generators g_k. The rows of the inverse of their amplitudes (A_1 ... A_n, conj A_1 ... conj A_n) in the planes make
loops with the line g_k alone among these: planes again, whose tunes are found as those of any.
"""

from __future__ import annotations

import itertools

import numpy as np

from ...compile.plane_loops import COLUMNS
from .fundamental import LINE_WIDTH, WEAK
from .integer_lattice import ball
from .line_rates import drifts
from .naff import FrequencyLines, found_lines
from .readings import SAME
from .turning import CHANCE, CHANGED, from_whole
from .windows import LINE_ORDER, cosine_window, fast_length

LINES = 6
"""Lines of a plane, beyond the number of planes, among which generators are sought."""

LONGEST = (12, 10, 6, 4, 3)
"""Largest |k|_1 of combinations of 1, 2, ... tunes; 2 of more."""

SHARP = 0.1
"""Error bar of a generator, in cycles over the samples."""

PARTS = 3
"""Largest m of a line that is a generator over m."""

BLURRED = 0.1
"""Over |k|_1^2, the bins within which a line is such a combination whatever its error bar: two lines in a bin pull."""

EQUAL = 0.03
"""Part by which shares differ that are equal: those of coordinates turned by 45 degrees."""

HARMONIC, CAUGHT = 4, 0.1
"""Largest harmonic of another plane's tune that a plane may show; and the share of the smallest tune by which the lines
of an orbit that is caught in such a resonance, and swings about it, may differ from it.
"""

APART = 1e-7
"""Smallest over largest singular value of amplitudes that assign lines to planes."""


def plane_values(z: np.ndarray, planes: np.ndarray) -> np.ndarray:
    """Return the loops (orbits, n, samples) of z (2n, orbits, samples) about their centres, as circles: planes (orbits,
    n, COLUMNS.end).
    """
    n = len(z) // 2
    known = planes.transpose(1, 0, 2)[..., None]
    x, y = z[:n] - known[:, :, COLUMNS.q], z[n:] - known[:, :, COLUMNS.p]
    f = known[:, :, COLUMNS.a] * x + 1j * (known[:, :, COLUMNS.b] * x + known[:, :, COLUMNS.c] * y)
    return np.ascontiguousarray(f.swapaxes(0, 1))


def modes_of(f: np.ndarray, harmonic: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a mask (orbits,) of orbits of loops f (orbits, n, samples) with n independent lines, for these the lines
    (n, some), and their modes as planes (2n, some, samples): each in the place, and in the sense, of the loop of whose
    motion it has most. Orbits that show a `harmonic` (n, orbits) are taken without their combined lines.
    """
    n, samples = f.shape[1], fast_length(f.shape[2])
    g, known, found = _generators(f[:, :, :samples])
    if not known.any():
        return known, np.zeros((n, 0)), np.zeros((2 * n, 0, f.shape[2]))
    f, g = f[known], g[known]
    alone = harmonic[:, known].any(axis=0)
    f[alone] -= _combined(found.take(np.flatnonzero(known)[alone]), g[alone], f.shape[2])
    plus, minus = _amplitudes(f[:, :, :samples], g)  # (orbits, n loops, n lines): of +g and of -g
    share = np.abs(np.abs(plus) ** 2 - np.abs(minus) ** 2) + 1e-3 * (np.abs(plus) ** 2 + np.abs(minus) ** 2)
    place = _places(share / share.sum(axis=2, keepdims=True), np.abs(g))
    each, loop = np.arange(len(f))[:, None], np.arange(n)
    plus, minus = plus[each, :, place].swapaxes(1, 2), minus[each, :, place].swapaxes(1, 2)
    # f = plus e + minus conj(e), and its conjugate
    whole = np.concatenate(
        [np.concatenate([plus, minus], axis=2), np.concatenate([minus.conj(), plus.conj()], axis=2)], axis=1
    )
    size = np.linalg.svd(whole, compute_uv=False)
    sound = size[:, -1] > APART * size[:, 0]
    known[known] = sound
    back = np.linalg.inv(whole[sound])[:, :n]
    e = back[:, :, :n] @ f[sound] + back[:, :, n:] @ f[sound].conj()
    other = (np.abs(plus) < np.abs(minus))[:, loop, loop][sound]
    e = np.where(other[:, :, None], e.conj(), e).swapaxes(0, 1)
    g = np.take_along_axis(g, place, axis=1)[sound]
    return known, np.where(other, -g, g).T, np.concatenate([e.real, -e.imag])


def _combined(found: FrequencyLines, g: np.ndarray, samples: int) -> np.ndarray:
    """Return the part (orbits, n, samples) of loops in their found lines, without +g and -g (orbits, n)."""
    apart = np.abs(found.nu)[..., None] - np.abs(g)[:, None, None]
    others = (from_whole(apart) * samples > SAME).all(axis=3)
    amplitude = np.where(others & np.isfinite(found.error), found.amplitude, 0.0)
    result = np.zeros((*amplitude.shape[:2], samples), complex)
    for nu, a in zip(np.moveaxis(found.nu, 2, 0), np.moveaxis(amplitude, 2, 0), strict=True):
        turns = nu[..., None] * np.arange(samples)
        result += a[..., None] * np.exp(2j * np.pi * (turns - np.rint(turns)))
    return result


def _generators(f: np.ndarray) -> tuple[np.ndarray, np.ndarray, FrequencyLines]:
    """Return the strongest independent lines (orbits, n) of loops f (orbits, n, samples), a loop's strongest first,
    a mask (orbits,) of those that have n, and all lines found.
    """
    orbits, n, samples = f.shape
    found = found_lines(f, 1.0, max(1, min(n + LINES, samples // 4 - LINE_ORDER)), LINE_ORDER)
    size, bar = np.abs(found.amplitude), 3 * found.error + LINE_WIDTH / samples
    seen = np.isfinite(bar) & (np.abs(found.nu) * samples > 2) & (size > WEAK * size.max(axis=2, keepdims=True))
    seen &= (bar * samples < 3 * SHARP) & (np.abs(np.abs(found.nu) - 0.5) * samples > 1)
    size = np.where(seen, size / np.maximum(size.max(axis=2, keepdims=True), 1e-300), 0.0)
    order = np.argsort(-(size + 2.0 * (size == 1.0)).reshape(orbits, -1), axis=1, kind="stable")
    nu, bar, size = (np.take_along_axis(rows.reshape(orbits, -1), order, axis=1) for rows in (found.nu, bar, size))
    k = ball(n, LONGEST[n - 1] if n <= len(LONGEST) else 2)
    length = np.abs(k).sum(axis=1)
    single, least = length == 1, BLURRED / np.maximum(length, 1) ** 2 / samples
    g, spread, rank = np.zeros((orbits, n)), np.zeros((orbits, n)), np.zeros(orbits, int)
    every = np.arange(orbits)
    for line, width, strength in zip(nu.T, bar.T, size.T, strict=True):
        combined, wide = g @ k.T, spread @ np.abs(k).T
        new = (rank < n) & (strength > 0) & np.isfinite(width)
        whole = np.zeros(orbits, bool)
        for m in range(1, PARTS + 1):
            apart = m * line[:, None] - combined
            near = from_whole(apart) < np.maximum(wide + m * width[:, None], least)
            whole = near.any(axis=1) if m == 1 else whole
            part = near & single if m > 1 else near[:, :0]
            finer = (strength > 0) & ~whole & part.any(axis=1)  # a generator is a harmonic of this line
            which = np.abs(k[part.argmax(axis=1)]).argmax(axis=1) if m > 1 else rank
            finer &= which < rank
            g[every[finer], which[finer]], spread[every[finer], which[finer]] = line[finer], width[finer]
            new &= ~near.any(axis=1)
            whole |= finer
        g[every[new], rank[new]], spread[every[new], rank[new]] = line[new], width[new]
        rank[new] += 1
    return g, rank == n, found


def _amplitudes(f: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitudes (orbits, loops, lines) of the lines g and -g (orbits, lines) in loops f (orbits, loops,
    samples), fitted together with the mean.
    """
    n, w = g.shape[1], cosine_window(f.shape[2])
    turns = np.concatenate([g, -g, 0 * g[:, :1]], axis=1)[:, :, None] * np.arange(f.shape[2])
    lines = np.exp(2j * np.pi * (turns - np.rint(turns)))
    weighted = (w * lines.conj()).swapaxes(1, 2)
    amplitude = (f @ weighted) @ np.linalg.pinv(lines @ weighted, rcond=1e-12)
    return amplitude[:, :, :n], amplitude[:, :, n : 2 * n]


def _places(share: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Return the line (orbits, n) of each loop by shares (orbits, loops, lines), the largest first, equal ones in the
    order of ascending nu (orbits, lines).
    """
    orbits, n, _ = share.shape
    place, every = np.zeros((orbits, n), int), np.arange(orbits)
    rank = nu.argsort(axis=1).argsort(axis=1)
    left = share * (1.0 - EQUAL * np.abs(rank[:, None] - np.arange(n)[:, None]))
    for _ in range(n):
        loop, line = np.divmod(left.reshape(orbits, -1).argmax(axis=1), n)
        place[every, loop] = line
        left[every, loop], left[every, :, line] = -1.0, -1.0
    return place


def restless(f: np.ndarray, halves: np.ndarray, length: int, threads: int) -> np.ndarray:
    """Return a mask of loops f (signals, samples) of chaotic orbits: their mean turns change from half to half (2,
    signals), and so does their strongest line.
    """
    result = length / 2 * np.abs(halves[0] - halves[1]) > CHANGED
    some = np.ascontiguousarray(f[result][:, None])
    leading = np.abs(found_lines(some, 1.0, 1, LINE_ORDER, threads).nu[:, :, 0])
    result[result] = drifts(some, leading, np.ones(leading.shape, bool), 1.0, threads)
    return result


def entangled(nu: np.ndarray, length: int) -> np.ndarray:
    """Return a mask (orbits,) of orbits with two tunes nu (n, orbits) that are one line over so many steps."""
    result = np.zeros(nu.shape[1], bool)
    for one, other in itertools.combinations(nu, 2):
        for apart in (one - other, one + other):
            result |= from_whole(apart) * length < SAME
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
