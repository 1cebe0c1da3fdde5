"""Tunes: frequencies modulo 1 of orbits that are known once a turn, from arrays of samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..core.classification import Classification, is_regular
from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, checked_callback, whole
from ..core.status import Status, describe, of_single
from ..engine.plane_loops import COLUMNS
from ..engine.threads import by_portions, checked_threads
from ..results.progress import says_progress
from ..results.result import Result, along
from ..runs.given_orbits import Given, GivenOrbits, ends, given_orbits, lengths
from .angle_lines import AngleLines, LineTable
from .angle_loops import Plain, SignalLayout
from .classify import MANY_TURNS
from .integer_lattice import ball
from .inverted_lines import inverted_values
from .plane_lines import PlaneLines, plane_lines
from .plane_modes import driven, entangled, modes_of, other_lines, own_tunes, plane_values, restless
from .readings import SAME
from .signals import signals_of
from .turning import (
    CHANGED,
    PIECE,
    ROUNDING,
    SAFETY,
    STANDING,
    Means,
    RotationAccumulator,
    TurningWindow,
    calm_change,
    from_whole,
    relations,
    without_standing,
)
from .windows import cosine_window

FALLBACK = 1e-9
"""Error in turns above which the line of a plane is inverted."""

EXACT = 1e-12
"""The same over at most SHORT samples: 99 % of the 4-D Henon orbits of `bench/test_tunes.py` over 1024 to 4096 turns
are then within 4e-11 to 4e-14, without it 1e-10 to 2e-11.
"""

LEAST = 64
"""Least number of samples of an orbit."""

SHORT = 4096
"""Turns up to which a mean turn that is nearly exact is still inverted: mean turns of longer runs cost a tenth."""

BUDGET = 1 << 27
"""Bytes of samples in work."""

AT_ONCE = 1 << 22
"""Samples of signals whose lines are sought at once."""

TOLD = 1 << 19
"""Numbers that a thread reads between reports."""

SMALL = 1e-140
"""Amplitude whose square is a number with all its digits, as that of its inverse."""

ROUGH = 0.05
"""Cycles over the window by which windows of a mean turn differ where the loop may pass through its centre."""

LINES = 8
"""Lines of a plane whose mean turn is not exact."""

OWN_LINES = 6
"""Lines of a plane whose loop passes through its centre, among which its own is sought."""

COMBINED = 4
"""Largest |k|_1 of combinations of other tunes that are none of its own."""

SHARP = 0.02
"""Bins within which a line is one of these combinations."""

WEAK = 0.01
"""Relative amplitude below which a line is no own line."""

LONG = 500
"""Turns from which a line in such a bin is not accidental."""

NEAR = 3
"""Bins within which the line of a mean turn is."""

HARMONIC = 6
"""Harmonics of a plane's own line among which its lines are sought."""

SHARED = 2
"""Largest |k|_1 of combinations of other tunes beside these harmonics."""

EXPLAINED = 0.999
"""Share of the squared amplitudes that these lines must explain."""

OPEN = 0.02
"""Least share of the area that they could enclose for which the sense of the loop is known."""


@dataclass(frozen=True)
class Tunes(Result):
    """Tunes of orbits: mean turns from one sample to the next in each plane (q, p), modulo 1.

    Attributes
    ----------
    names : tuple of str, length n
        Names of the coordinates, one for each row of `nu`.
    nu : ndarray, shape (n, orbits)
        Tunes in [0, 1), of q - i p: 0.2 is a fifth of a turn that takes (1, 0) towards p < 0, as motion in time does.
        0.8 is a fifth of a turn the other way. NaN if there is no tune.
    error : ndarray, shape (n, orbits)
        Error estimates of `nu`, per turn; inf if there is no tune.
    method : ndarray of int, shape (n, orbits)
        0 for a weighted mean turn, 1 for a spectral line.
    diffusion : ndarray, shape (orbits,)
        log10 of the largest ``|change|`` of a tune from the first half of the window to the second; NaN without a tune.
    turns : ndarray of int, shape (orbits,)
        Samples before the end of an orbit; all of them for an orbit that survived.
    window : ndarray of int, shape (orbits,)
        Number of steps over which `nu` is the mean.
    classification : ndarray of int, shape (orbits,)
        `Classification` of each orbit: REGULAR, RESONANT, IRREGULAR or UNDECIDED.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit: OK; NONFINITE, or LOST if the samples stay at one point. Numbers of orbits that ended
        are those before the end.
    lines : AngleLines or None
        Strongest spectral lines of each plane, if they were requested: per turn, modulo 1, in [-1/2, 1/2).

    Notes
    -----
    - RESONANT: a plane is at rest, or two tunes are related by small integers.
    - IRREGULAR: the tunes change between the halves by 0.3 cycles or more, beside a resonance of order k by 3/k.
    - UNDECIDED: too few turns, no tune, or two lines closer than 1.5/window, of two tunes or of a tune and a visible
      combination. Their errors are then 1/window or more.
    - REGULAR: all other orbits.
    """

    names: tuple[str, ...]
    nu: Annotated[np.ndarray, along("angle", "orbit", unit="1/turn", labels="names", plain=True)]
    error: Annotated[np.ndarray, along("angle", "orbit", unit="1/turn", labels="names")]
    method: Annotated[np.ndarray, along("angle", "orbit", labels="names")]
    diffusion: Annotated[np.ndarray, along("orbit", unit="log10(1/turn)")]
    turns: Annotated[np.ndarray, along("orbit", unit="turns")]
    window: Annotated[np.ndarray, along("orbit", unit="turns")]
    classification: Annotated[np.ndarray, along("orbit")]
    status: Annotated[np.ndarray, along("orbit")]
    lines: Annotated[AngleLines | None, along("orbit")] = None

    @property
    def signed(self) -> np.ndarray:
        """Tunes in (-1/2, 1/2], shape (n, orbits)."""
        return self.nu - (self.nu > 0.5)

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits, and the classes of those that are OK.

        Returns
        -------
        str
            Summary.
        """
        fine = self.status == Status.OK
        some = np.isfinite(self.error).any(axis=0)
        counts = {entry.name.lower(): fine & some & (self.classification == entry) for entry in Classification}
        counts["without a tune"] = fine & ~some
        return describe(self.status, counts) + of_single(self.status, "nu", self.names, self.nu)

    @property
    def digits(self) -> np.ndarray:
        """Digits to which weighted averages over both halves of the window agree, in turns, shape (orbits,).

        NaN without a tune. Chaotic orbits have about log10(window)/2, regular ones up to 16.

        References
        ----------
        Sander & Meiss 2020, Physica D 411, 132569.
        """
        return np.where(np.isfinite(self.error).any(axis=0), -self.diffusion, np.nan)

    @property
    def regular(self) -> np.ndarray:
        """Mask of the orbits that are OK, and REGULAR or RESONANT, shape (orbits,)."""
        return (self.status == Status.OK) & is_regular(self.classification)


@says_progress
@inserts_parameters
def tunes(
    samples: Given,
    *,
    coordinates: str | Sequence[str] | None = None,
    lines: int | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> Tunes:
    """Compute the tunes of orbits that are sampled once per turn by a map, a tracking code or a section.

    Parameters
    ----------
    samples : array_like, shape (2n, orbits, turns) or (2n, turns)
        Rows q1, ..., qn, p1, ..., pn, with 64 turns or more. Turns after the end of
        an orbit are NaN or repeat one point. Also accepted:

        - `Orbits` of a map, or their array ``samples``;
        - an array of xarray, with its dimensions in any order;
        - a data set of an HDF5 or Zarr file, read in parts;
        - a monitor of xtrack, or an array (6, particles, 1, turns) of PyAT;
        - with `coordinates`, a `SectionMap`, whose points are turns; arrays of shape (orbits, turns) by name (a
          mapping, a Dataset, a group of a file); or a table of pandas, polars or Astropy with a row for each turn.
    coordinates : str or sequence of str, optional
        Names of the 2n rows.
    {lines}
    {threads}
    {callback}

    Returns
    -------
    `Tunes`
        Tunes per turn, with error estimates, diffusion and classification of each orbit.

    Raises
    ------
    ValueError
        If a value is out of its range; the message names orbit and sample.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the orbits finished so far in ``.partial``.

    Notes
    -----
    - Method: weighted Birkhoff average of the angle per turn in each plane, after a map of the ellipse to a circle. If
      the average has not converged, the nearest spectral line replaces it, by harmonic inversion.
    - Coupled planes: each plane gets the mode with the larger amplitude in it, even if its strongest line is a
      harmonic.
    - Errors: 5 times the largest difference between windows, a bound for slow beats near resonances, and round-off.
    - Limits: modes with amplitudes below 1e-9 of another are not detected. Below 1e-6 the orbit may be UNDECIDED. Of
      orbits that ended early, up to a twelfth of the turns is not used.
    - Cost: 2 ns per plane and turn, more with lines. Memory: 128 MiB or one orbit.

    See the explanation page on frequencies.

    References
    ----------
    Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111 (weighted averages); Laskar 1990, Icarus 88, 266 (diffusion,
    lines); Courant & Snyder 1958, Ann. Phys. 3, 1 (ellipses).

    Examples
    --------
    >>> turn = 2 * np.pi * 0.28 * np.arange(300)
    >>> fa.tunes([2 * np.cos(turn), -np.sin(turn)]).nu.round(9)
    array([[0.28]])
    """
    checked_callback(callback)
    given = given_orbits(samples, coordinates=coordinates, least=LEAST)
    lines = None if lines is None else whole("lines", lines, 1)
    work = TuneWork(given, checked_threads(threads), callback, lines)
    with partial_result_on_interrupt("tunes", work.result):
        work.run()
    return work.result()


def tunes_of(
    names: tuple[str, ...],
    means: Means,
    method: np.ndarray,
    turns: np.ndarray,
    window: np.ndarray,
    status: np.ndarray,
    ambiguous: np.ndarray,
    lines: AngleLines | None = None,
) -> Tunes:
    """Return the Tunes from means (n, orbits) over windows (orbits,), NaN for orbits without one; ambiguous (orbits,):
    a mask of orbits with two tunes that are not told apart.
    """
    known = np.isfinite(means.error) & (window > 0)
    nu = np.where(known, means.nu, 0.0)
    error = np.where(known, means.error, np.inf)
    nu = nu - np.floor(nu)
    nu = np.where(nu >= 1.0, 0.0, nu)
    change = np.where(known, np.abs(means.halves[0] - means.halves[1]), 0.0).max(axis=0)
    some = known.any(axis=0)
    related = relations(nu, error, window)
    classification = np.where(
        known.all(axis=0) & ~related.tied.any(axis=0), Classification.REGULAR, Classification.RESONANT
    )
    error = np.maximum(error, related.unseen)
    error = np.where(ambiguous, np.maximum(error, 1 / np.maximum(window, 1)), error)
    cycles = window * np.minimum(nu, 1 - nu).max(axis=0, initial=0.0)
    classification[window / 2 * change > CHANGED] = Classification.UNDECIDED
    classification[window / 2 * change > calm_change(nu, means.halves, window / 2)] = Classification.IRREGULAR
    classification[(classification != Classification.IRREGULAR) & related.unsure] = Classification.UNDECIDED
    classification[(cycles < MANY_TURNS) | ~some | ambiguous] = Classification.UNDECIDED
    diffusion = np.where(some, np.log10(change + 1e-18), np.nan)
    return Tunes(
        names,
        np.where(known, nu, np.nan),
        error,
        method=method,
        diffusion=diffusion,
        turns=turns,
        window=window,
        classification=classification,
        status=status,
        lines=lines,
    )


class TuneWork:
    """Tunes in the making; arrays hold the results so far."""

    def __init__(
        self,
        given: GivenOrbits,
        threads: int,
        callback: Callback | None,
        lines: int | None = None,
        inexact: float = EXACT,
    ):
        self.given = given
        self.threads = threads
        self.callback = callback
        self.inexact = inexact
        (_, self.orbits, self.samples), n = given.shape, given.shape[0] // 2
        self.lines = None if lines is None else LineTable(given.angles, lines, self.orbits)
        self.nu, self.error = np.zeros((n, self.orbits)), np.full((n, self.orbits), np.inf)
        self.halves, self.method = np.zeros((2, n, self.orbits)), np.zeros((n, self.orbits), np.int8)
        self.turns, self.window = np.zeros((2, self.orbits), np.int64)
        self.ambiguous = np.zeros(self.orbits, bool)
        self.status = np.full(self.orbits, int(Status.INTERRUPTED))

    def run(self) -> None:
        """Find the tunes of all orbits, as many at a time as memory allows."""
        rows, orbits, samples = self.given.shape
        portion = max(1, BUDGET // (8 * rows * samples))
        size = self.threads * max(1, TOLD // (rows * samples))
        for begin in range(0, orbits, portion):
            z = self.given.read(begin, end := min(begin + portion, orbits))
            counts, status = ends(z, begin, self.threads)
            self.turns[begin:end] = counts
            for length, own in lengths(counts, samples, LEAST, size):
                some = lambda at, z=z, b=begin, o=own, n=length: self._adopt(z, b, o[at], n)  # noqa: E731
                by_portions(some, own.size, 8 * rows * length, self.threads)
                if self.callback is not None:
                    self.callback((begin + int(np.count_nonzero(self.window[begin:end]))) / orbits)
            self.status[begin:end] = status
            if self.callback is not None:
                self.callback(end / orbits)

    def _adopt(self, whole: np.ndarray, first: int, own: np.ndarray, length: int) -> None:
        """Fill in the results of orbits `own` of whole (2n, orbits, samples), whose first is number `first`."""
        together = own[-1] - own[0] < own.size  # seen without a copy
        orbits = first + own
        z = whole[:, slice(own[0], own[-1] + 1) if together else own, : length + 1]
        turning, means, method, rough = self._read(z, length)
        scaled = z
        factors = _factors(z, turning)
        if (factors != 1.0).any():
            scaled = z * factors
            turning, means, method, rough = self._read(scaled, length)
        self.ambiguous[orbits] = self._with_modes(scaled, turning, means, method, rough)
        self.nu[:, orbits], self.error[:, orbits], self.halves[:, :, orbits] = without_standing(means, length)
        self.method[:, orbits] = method
        self.window[orbits] = length
        if self.lines is not None:
            self._lined(z, orbits, self.lines)

    def _read(self, z: np.ndarray, length: int) -> tuple[RotationAccumulator, Means, np.ndarray, np.ndarray]:
        """Return the loops of z (2n, orbits, length + 1), their tunes, the methods of these, and a mask (orbits,) of
        orbits with a loop whose mean turn is not steady.
        """
        until = np.empty(z.shape[1], np.int64)
        window = TurningWindow(0, length, (0, length))
        turning = RotationAccumulator(z[:, :, 0])
        first = turning.last.copy()
        for angles in (False, True):
            for at in range(0, length, PIECE):
                piece = z[:, :, 1 + at : 1 + min(at + PIECE, length)]
                until[:] = piece.shape[2]
                turning.add(piece, until, at, window, 1, angles=angles, frame=not angles)
            if not angles:
                turning.learn(np.ones(z.shape[1], bool), 1)
                turning.clear()
                turning.last = first
        means = turning.means(length, 1)
        method = np.zeros(means.nu.shape, np.int8)
        rough = np.any(means.error / SAFETY * length > ROUGH, axis=0)
        self._with_lines(z, turning, means, method, length)
        return turning, means, method, rough

    def _with_modes(
        self, z: np.ndarray, turning: RotationAccumulator, means: Means, method: np.ndarray, rough: np.ndarray
    ) -> np.ndarray:
        """Replace the tunes of planes that show the same line, or whose loops pass through their centres (`rough`), by
        those of modes; return a mask (orbits,) of orbits with two tunes that are not told apart.
        """
        length = z.shape[2] - 1
        ambiguous = np.zeros(z.shape[1], bool)
        twice = entangled(means.nu, length)
        harmonic = driven(means.nu, means.error)
        related = relations(means.nu, means.error, length)
        unseen = related.unseen
        tied = np.asarray(related.tied.any(axis=0))
        needed = (twice | harmonic.any(axis=0) | rough | (unseen > means.error).any(axis=0)) & (
            turning.planes[:, :, COLUMNS.a] != 0
        ).all(axis=1)
        for _, orbits in _parts(needed[None] & (len(means.nu) > 1), max(1, AT_ONCE // (len(z) * (length + 1)))):
            f = plane_values(z[:, orbits], turning.planes[orbits])
            halves = means.halves[:, :, orbits].swapaxes(1, 2).reshape(2, -1)
            wild = restless(f.reshape(-1, length + 1), halves, length).reshape(f.shape[:2])
            calm = ~wild.all(axis=1)
            if not calm.any():
                continue
            own = orbits[calm]
            modes = modes_of(f[calm], harmonic[:, own])
            # Without a line of their own in all planes, tunes are related, or there are lines that are not told apart.
            ambiguous[own] = modes.ambiguous | (modes.few & ~tied[own]) | (twice[own] & ~modes.periodic)
            own = own[modes.known]
            if not own.size:
                continue
            _, found, how, _ = self._read(modes.planes, length)
            found = found._replace(error=found.error + modes.shift)
            finer = found.error.max(axis=0) < np.maximum(means.error, unseen)[:, own].max(axis=0)
            better = twice[own] | (finer & ~harmonic[:, own].any(axis=0))
            better |= own_tunes(means.nu[:, own], harmonic[:, own], found.nu, length)
            better |= rough[own] & other_lines(means.nu[:, own], modes.nu, length)
            off = from_whole(found.nu - modes.nu)
            good = better & (np.maximum(off, found.error) * length < SAME).all(axis=0)
            ambiguous[own[good]] = modes.ambiguous[modes.known][good]
            own = own[good]
            for old, new in zip(means, found, strict=True):
                old[..., own] = new[..., good]
            method[:, own] = how[:, good]
        return ambiguous

    def _lined(self, z: np.ndarray, orbits: np.ndarray, table: LineTable) -> None:
        """Fill in the lines of z (2n, orbits, samples)."""
        n = len(z) // 2
        portion = max(1, AT_ONCE // z.shape[2])
        layout = SignalLayout(Plain(self.given.angles), n)
        order = np.arange(2 * n).reshape(2, n).T.ravel()
        for begin in range(0, orbits.size, portion):
            part = orbits[begin : begin + portion]
            s = np.ascontiguousarray(z[order, begin : begin + portion].swapaxes(0, 1))
            table.adopt(part, layout, signals_of(s, 1.0), 0.0)

    def _with_lines(
        self, z: np.ndarray, turning: RotationAccumulator, means: Means, method: np.ndarray, length: int
    ) -> None:
        """Replace inaccurate averages by lines, where these are better."""
        n = len(means.nu)
        least = self.inexact if length <= SHORT else max(self.inexact, FALLBACK)
        needed = (means.error > least) & (turning.planes[:, :, COLUMNS.a] != 0).T
        steady = means.error / SAFETY * length < SAME
        t = np.arange(length + 1)
        terms = 8 * (2 * HARMONIC + 1) * len(ball(n, SHARED)) + len(ball(n, COMBINED))
        for planes, orbits in _parts(needed, max(1, AT_ONCE // max(length + 1, terms))):
            known = turning.planes[orbits, planes]
            rough = means.nu[planes, orbits]
            x = z[planes, orbits] - known[:, :1]
            y = z[n + planes, orbits] - known[:, 1:2]
            a, b, c = (known[:, k, None] for k in (COLUMNS.a, COLUMNS.b, COLUMNS.c))
            f = a * x + 1j * (b * x + c * y)
            halves = means.halves[:, planes, orbits]
            if not (kept := ~restless(f, halves, length)).all():
                planes = planes[kept]
                orbits = orbits[kept]
                rough = rough[kept]
                f = f[kept]
            turns = rough[:, None] * t
            f *= np.exp(-2j * np.pi * (turns - np.rint(turns)))
            near = steady[planes, orbits]
            others = np.where(steady, means.nu, np.nan)[:, orbits].T
            there = near & (from_whole(rough) * length >= SAME) & (_share(f) > WEAK)
            centre = np.zeros(len(f))
            if not there.all():
                centre[~there] = _turned(f[~there], rough[~there], near[~there], planes[~there], others[~there])
            # A mean turn that is no line gives no error to compare with.
            worst = np.where(~near | (centre != 0), np.inf, means.error[planes, orbits] / SAFETY)
            found = inverted_values(f, centre)
            good = (found.error * length < 1) & (found.error < SAFETY * worst)
            good &= from_whole(rough + found.nu) * length >= STANDING
            i = planes[good]
            o = orbits[good]
            means.nu[i, o] = rough[good] + found.nu[good]
            means.error[i, o] = found.error[good] + ROUNDING
            means.halves[:, i, o] = rough[good] + found.halves[good].T
            method[i, o] = 1

    def result(self) -> Tunes:
        """Assemble the tunes."""
        means = Means(self.nu, self.error, self.halves)
        lines = None if self.lines is None else self.lines.result()
        return tunes_of(
            self.given.angles, means, self.method, self.turns, self.window, self.status, self.ambiguous, lines
        )


def _factors(z: np.ndarray, turning: RotationAccumulator) -> np.ndarray:
    """Return the powers of 2 (2n, orbits, 1) that bring those planes to amplitudes about 1 that seem at rest as the
    squares of their samples z (2n, orbits, samples) are no numbers.
    """
    factors = np.ones((*z.shape[:2], 1))
    still = (turning.planes[:, :, COLUMNS.a] == 0).T
    for r, o in np.argwhere(np.concatenate([still, still])):
        size = np.abs(z[r, o]).max()
        if size > 0 and not SMALL < size < 1 / SMALL:
            factors[r, o] = 2.0 ** -np.clip(np.frexp(size)[1], -1022, 1022)
    return factors


def _share(f: np.ndarray) -> np.ndarray:
    """Return the size (signals,) of the lines next to 0 of signals f (signals, samples), relative to these."""
    w = cosine_window(f.shape[1])
    # No product of matrices: its own threads would wait beside those that read other orbits.
    power = ((f.real**2 + f.imag**2) * w).sum(axis=1)
    return np.abs((f * w).sum(axis=1)) / np.sqrt(np.where(power > 0, power, 1.0))


def _turned(f: np.ndarray, rough: np.ndarray, near: np.ndarray, planes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the places (signals,) of the own lines of loops f that are not seen next to their mean turns, 0 where
    there is a line next to one that is `near` (signals,); see `_own_lines`.
    """
    lines = plane_lines(f, LINES, beside=False)
    there = (np.abs(lines.nu) * f.shape[1] < NEAR) & (np.abs(lines.amplitude) > 0)
    turned = ~(near & there.any(axis=1)) | (from_whole(rough) * f.shape[1] < SAME)
    result = np.zeros(len(f))
    result[turned] = _own_lines(f[turned], lines.of(turned), rough[turned], planes[turned], others[turned])
    return result


def _own_lines(
    f: np.ndarray, lines: PlaneLines, rough: np.ndarray, planes: np.ndarray, others: np.ndarray
) -> np.ndarray:
    """Return the own line of each signal f (signals, samples) among its `lines`: the one of which all of them are
    harmonics, with combinations of the tunes of the other planes, others (signals, n), NaN where there is none; else
    the strongest that is no such combination, else the strongest.

    f turns by `rough` (signals,) less than the plane does. Where that is 0 the loop is beside its centre: 0, no sense.
    """
    if not len(f):
        return np.zeros(0)
    beside = from_whole(rough) * f.shape[1] < SAME
    if f.shape[1] < LONG:
        return np.where(beside, 0.0, lines.nu[:, 0])
    others = np.where(np.arange(others.shape[1]) == planes[:, None], np.nan, others)
    nu = lines.nu[:, :OWN_LINES]
    size = np.abs(lines.amplitude[:, :OWN_LINES])
    apart = (nu + rough[:, None])[:, :, None] - _combined(others, COMBINED)[:, None]
    foreign = (from_whole(apart) * f.shape[1] < SHARP).any(axis=2)
    own = np.where(foreign | (size < WEAK * size[:, :1]), 0.0, size)
    best = np.where(own.any(axis=1), own.argmax(axis=1), 0)
    first = _generators(lines, rough, others, foreign, f.shape[1])
    found = nu[np.arange(len(f)), np.where(first < 0, best, first)]
    return np.where(beside & (first < 0), 0.0, found)


def _combined(others: np.ndarray, longest: int) -> np.ndarray:
    """Return all combinations (signals, terms) of tunes with |k|_1 up to `longest`; NaN where one is not known."""
    k = ball(others.shape[1], longest)
    with np.errstate(invalid="ignore"):
        return np.where(k != 0, k * others[:, None, :], 0.0).sum(axis=2)


def _generators(
    lines: PlaneLines, rough: np.ndarray, others: np.ndarray, foreign: np.ndarray, samples: int
) -> np.ndarray:
    """Return the numbers (signals,) of lines of which all `lines` are harmonics, with combinations of the others'
    tunes, of the sense of the enclosed area; the shortest on the mean; -1: there is none, or the area is too small.
    """
    nu = lines.nu + rough[:, None]
    power = np.abs(lines.amplitude) ** 2
    order = np.arange(-HARMONIC, HARMONIC + 1)
    terms = np.abs(order)[:, None] + np.abs(ball(others.shape[1], SHARED)).sum(axis=1)
    combined = _combined(others, SHARED)[:, None, None]
    result = np.full(len(nu), -1)
    least = np.full(len(nu), np.inf)
    for c in range(min(OWN_LINES, nu.shape[1])):
        apart = nu[:, :, None, None] - (order * nu[:, c, None])[:, None, :, None] - combined
        with np.errstate(invalid="ignore"):
            fits = from_whole(apart) * samples < SHARP
        cost = np.where(fits, terms, 99).reshape(*nu.shape, -1)
        harmonic = order[cost.argmin(axis=2) // terms.shape[1]]
        length = cost.min(axis=2)
        explained = power * (length < 99)
        worth = (power * length).sum(axis=1)
        size = (np.abs(harmonic) * explained).sum(axis=1)
        area = (harmonic * explained).sum(axis=1)
        good = (explained.sum(axis=1) > EXPLAINED * power.sum(axis=1)) & (area > OPEN * size) & (worth < least)
        good &= ~foreign[:, c] & np.isfinite(lines.error[:, c])
        result[good], least[good] = c, worth[good]
    return result


def _parts(needed: np.ndarray, most: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield rows and columns of the True entries of `needed`, so many or fewer at a time."""
    rows, columns = np.nonzero(needed)
    for begin in range(0, rows.size, most):
        yield rows[begin : begin + most], columns[begin : begin + most]
