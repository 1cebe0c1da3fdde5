"""Weighted mean angles from sample to sample of the planes (q, p) of orbits, over windows that are filled by pieces."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from ..engine.packing import launch
from ..engine.plane_loops import COLUMNS, MOMENTS
from ..engine.threads import by_portions
from ..systems.models.mechanics import total
from .integer_lattice import ball, one_of_each
from .kernels import tunes as kernels
from .windows import SPANS, damping, weight_at

PIECE = 65536
"""Samples at once: so long are tables of weights."""

SAFETY = 5.0
"""Factor of error estimates over the differences between windows, as for frequency maps."""

ROUNDING = 2e-15
"""Turns that the mean of angles may be off by rounding."""

STANDING = 0.1
"""Cycles over a window below which a mean turn is none, as for a lost particle that stays beside a centre."""

HARMONICS = 40
"""Harmonics of a curve whose slow beats count in the error of its rotation number."""

COST = 8 * HARMONICS
"""Numbers that the error, or the kind, of a mean turn counts as."""

CHANGED = 0.3
"""Change of a tune, in turns over a half, that counts."""

ISLAND = 3.0
"""Allowed change times the order of a resonance for an orbit that swings slowly in one, in turns over a half."""

BESIDE = 1.5
"""Largest distance of its tunes from that resonance, in turns over the window."""

RELATED = 5
"""Largest |k|_1 of a relation of two tunes."""

CHANCE = 1e-3
"""Largest width of a relation that is not accidental, unless the tunes are equal."""

TIGHT = 1e-5
"""Width, in cycles over the window, from which a relation within it is no proof of one."""

UNSEEN = 0.3
"""Cycles over the window up to which all windows see the same part of the beat of two lines."""

FAINT = 0.1
"""Relative amplitude that one of these lines may have."""

LOCKED = 12
"""Largest order of islands that are sought."""


class TurningWindow(NamedTuple):
    """Steps from sample to sample begin to begin + length, and the part (begin, length) of them whose moments set the
    frame of the next window.
    """

    begin: int
    length: int
    frame: tuple[int, int]

    def weights(self, at: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the weights (spans, samples) of SPANS, and those of the frame (samples,), of steps from number `at`
        on.
        """
        step = np.arange(at, at + samples)
        place = (step - self.begin + 0.5) / self.length
        tables = np.array([weight_at(2 * (place - x0) / (x1 - x0) - 1) for x0, x1 in SPANS])
        begin, length = self.frame
        return tables, weight_at(2 * (step - begin + 0.5) / length - 1)


class Means(NamedTuple):
    """Means over a window: turns per step nu (n, orbits), their error, and those of the halves (2, n, orbits)."""

    nu: np.ndarray
    error: np.ndarray
    halves: np.ndarray


def without_standing(means: Means, length: int | np.ndarray) -> Means:
    """Return means over that many steps (orbits,), with error inf for planes that do not go around."""
    standing = from_whole(means.nu) * length < STANDING
    return means._replace(error=np.where(standing, np.inf, means.error))


def run_orbits(kernel: object, orbits: int, arguments: tuple, threads: int) -> None:
    """Run a kernel of units of orbits to its end."""
    if orbits:
        units = -(-orbits // kernels.ORBITS)
        launch(kernel, arguments, np.zeros(units), float(units), threads, None)  # type: ignore[arg-type]


class RotationAccumulator:
    """Sums over a window, of orbits that each have a centre, a shape and a reference of their own.

    Arrays, orbits first: last (orbits, 2n), the last sample; planes (orbits, n, 8) of
    `frequencies.kernels.tunes.COLUMNS`; sums (orbits, n, 6) of angles over SPANS of the window, moments (orbits, n,
    9); weights (7,): the sums of their weights so far.
    """

    def __init__(self, first: np.ndarray):
        rows, orbits = first.shape
        self.last = np.array(first.T, order="C")
        self.planes = np.zeros((orbits, rows // 2, COLUMNS.end))
        self.planes[:, :, COLUMNS.q], self.planes[:, :, COLUMNS.p] = (
            self.last[:, : rows // 2],
            self.last[:, rows // 2 :],
        )
        self.planes[:, :, [COLUMNS.a, COLUMNS.cosine]] = 1.0
        self.planes[:, :, COLUMNS.c] = -1.0
        self.clear()

    def clear(self) -> None:
        """Begin a window."""
        orbits, n, _ = self.planes.shape
        self.sums = np.zeros((orbits, n, len(SPANS)))
        self.moments = np.zeros((orbits, n, MOMENTS))
        self.weights = np.zeros(len(SPANS) + 1)

    def add(
        self,
        chunk: np.ndarray,
        until: np.ndarray,
        at: int,
        window: TurningWindow,
        threads: int,
        *,
        angles: bool,
        frame: bool,
    ) -> None:
        """Add the steps from number `at` to the samples of chunk (2n, orbits, samples), until (orbits,) of each, all in
        the window: their angles, or the moments for its frame.
        """
        orbits, samples = chunk.shape[1:]
        tables, weights = window.weights(at, samples)
        tables = tables if angles else tables[:, :0]
        weights = weights if frame else np.zeros(samples)
        self.weights[:-1] += tables.sum(axis=1)
        self.weights[-1] += weights.sum()
        table = np.ascontiguousarray(tables.T)
        some = kernels.Frame(weights, *_within(weights))
        arguments = chunk, until, self.last, self.planes, table, some, self.sums, self.moments
        run_orbits(kernels.turn_on, orbits, arguments, threads)

    def learn(self, known: np.ndarray, threads: int) -> None:
        """Take centre, shape and reference of the `known` orbits (orbits,) from the moments of the window."""
        arguments = self.moments, float(self.weights[-1]), known.astype(np.int64), self.planes
        run_orbits(kernels.learn, len(self.planes), arguments, threads)

    def means(self, length: int, threads: int) -> Means:
        """Return the means over a window of that many steps; error inf for a plane at rest."""
        orbits, n, _ = self.planes.shape
        found = Means(np.empty((n, orbits)), np.empty((n, orbits)), np.empty((2, n, orbits)))

        def some(at: slice) -> None:
            turns = self.planes[at, :, COLUMNS.turn, None] + self.sums[at] / (2 * math.pi * self.weights[:-1])
            nu = turns[:, :, 0]
            with np.errstate(invalid="ignore"):
                error = SAFETY * np.abs(turns[:, :, 1:] - turns[:, :, :1]).max(axis=2)
                error = error + unresolved(nu, length) + ROUNDING
                # Near 0 and 1/2 the samples do not show where the centre is, nor the shape.
                halves = from_whole(2 * nu) * length
                error = error + np.where(np.rint(2 * nu) % 2 == 0, 1.0, 0.25) * damping(halves) / length
            error = np.where(self.planes[at, :, COLUMNS.a] != 0, error, np.inf)
            found.nu[:, at], found.error[:, at], found.halves[:, :, at] = nu.T, error.T, turns[:, :, 1:3].T

        by_portions(some, orbits, COST * n, threads)
        return found


def _within(weights: np.ndarray) -> tuple[int, int]:
    """Return the range where weights (samples,) are not 0."""
    some = np.flatnonzero(weights)
    return (int(some[0]), int(some[-1]) + 1) if some.size else (0, 0)


def from_whole(turns: np.ndarray) -> np.ndarray:
    """Return the distances of turns from whole ones."""
    return np.abs(turns - np.rint(turns))


def unresolved(rotation: np.ndarray, steps: np.ndarray | float) -> np.ndarray:
    """Return the error of a rotation number so near a fraction p/m that the orbit has not gone around between the m
    points.

    The angle of a step varies along the curve by harmonics m, taken to fall like 2^-m; the window leaves `damping` of
    their slow beats.
    """
    m = np.arange(1, HARMONICS + 1).reshape(-1, *[1] * np.ndim(rotation))
    beat = from_whole(m * rotation)
    return total(4.0 * 0.5**m * beat / m * damping(beat * steps))


class Relations(NamedTuple):
    """Relations of tunes: tied (n, orbits): a mask of those that follow from the tunes before them; unsure (orbits,):
    of orbits with a relation within errors that are too wide to tell; unseen (n, orbits): the errors of tunes by lines
    that the window does not separate.
    """

    tied: np.ndarray
    unsure: np.ndarray
    unseen: np.ndarray


def relations(
    nu: np.ndarray, error: np.ndarray, window: np.ndarray | int, wound: np.ndarray | None = None
) -> Relations:
    """Return the relations of two tunes nu (n, orbits) that are 0 within their errors over windows (orbits,).

    wound (n,): coordinates that go round, which sums and differences alone relate.
    """
    tied = np.zeros(nu.shape, bool)
    unseen = np.zeros_like(nu)
    unsure = np.zeros(nu.shape[1], bool)
    narrow = TIGHT / np.maximum(window, 1)
    for a in range(1, RELATED):
        for b in range(a - RELATED, RELATED - a + 1):
            equal = a + abs(b) == 2
            for i, j in itertools.permutations(range(len(nu)), 2) if b else ():
                if not equal and wound is not None and (wound[i] or wound[j]):
                    continue
                apart = a * nu[i] + b * nu[j]
                width = a * error[i] + abs(b) * error[j]
                beat = from_whole(apart)
                related = beat <= np.where(width < (math.inf if equal else CHANCE), width, -1.0)
                tight = width < narrow
                tied[max(i, j)] |= related & tight
                unsure |= related & ~tight
                unseen[i] = np.maximum(unseen[i], np.where(beat * window < UNSEEN, FAINT * beat, 0.0))
    return Relations(tied, unsure, unseen)


def calm_change(nu: np.ndarray, halves: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Return the largest difference (orbits,) without chaos, in turns over a `half` (orbits,), of the means of the
    halves (2, n, orbits); nu (n, orbits): of the whole.

    In a chain of |k| islands each angle swings by 1/|k| of a turn, and the halves may see parts of a swing: where a
    combination |k| <= LOCKED/n of the tunes, of the whole or of a half, turns less than BESIDE.
    """
    result = np.full(half.shape, CHANGED)
    some = np.flatnonzero(half * np.abs(halves[0] - halves[1]).max(axis=0) > CHANGED)
    for k in one_of_each(ball(len(nu), max(LOCKED // len(nu), 2))[1:]):
        for seen in (nu, *halves):
            beat = total(k[:, None] * seen[:, some])
            near = some[from_whole(beat) * half[some] < BESIDE]
            result[near] = np.maximum(result[near], ISLAND / np.abs(k).sum())
    return result
