"""Tunes of orbits that arrive a few turns at a time, in memory that does not grow with the number of turns."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.status import Status
from ..engine.threads import checked_threads
from ..results.result import Result, along
from ..runs.given_orbits import Given, gap, given_orbits, row_names, stays
from ..runs.row_order import wrong_order
from .kernels import tunes as kernels
from .plane_modes import entangled
from .tunes import Tunes, tunes_of
from .turning import PIECE, Means, RotationAccumulator, TurningWindow, run_orbits, without_standing

FIRST = 32
"""Steps that only locate the loops; the windows are [32, 64), [64, 128), ..., each twice as long."""

FRAME = 4096
"""Steps in the middle of a window whose moments set the frame of the next one."""

PART = 8
"""The part of the window that these are, if that is more."""


def window_of(step: int) -> TurningWindow:
    """Return the window that a step from sample number `step` to the next belongs to."""
    begin = 0 if step < FIRST else 1 << (step.bit_length() - 1)
    length = max(begin, FIRST)
    middle = length if length <= FRAME else max(FRAME, length // PART)
    return TurningWindow(begin, length, (begin + (length - middle) // 2, middle))


@dataclass(frozen=True)
class TuneSums(Result):
    """State of a `TuneAccumulator`, which `save` writes to a file and ``TuneAccumulator.of`` resumes from.

    Attributes
    ----------
    names : tuple of str, length 2n
        Names of the rows.
    samples : int
        Number of turns that were pushed.
    last : ndarray, shape (2n, orbits)
        Last sample.
    planes : ndarray, shape (n, 8, orbits)
        Centre, shape and reference turn of the loop of each plane.
    sums : ndarray, shape (n, 6, orbits)
        Weighted sums of angles over the current window, in radians.
    moments : ndarray, shape (n, 9, orbits)
        Weighted moments over the current window.
    weights : ndarray, shape (7,)
        Sums of the weights of the current window.
    turns : ndarray of int, shape (orbits,)
        Samples before the first one that is not finite.
    ended : ndarray of bool, shape (orbits,)
        Whether an orbit has ended.
    still : ndarray of int, shape (2, orbits)
        Number of consecutive equal samples, at the end and at most.
    nu, error : ndarray, shape (n, orbits)
        Tunes and error estimates per turn, over the last window that the orbit completed.
    halves : ndarray, shape (2, n, orbits)
        Tunes of both halves of that window.
    window : ndarray of int, shape (orbits,)
        Length of that window in turns, 0 if there is none.

    Notes
    -----
    States with equal numbers of samples can be joined along their orbits with ``concat``.

    References
    ----------
    Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111 (weighted averages).
    """

    names: tuple[str, ...]
    samples: int
    last: Annotated[np.ndarray, along("coordinate", "orbit", labels="names")]
    planes: Annotated[np.ndarray, along("angle", "column", "orbit")]
    sums: Annotated[np.ndarray, along("angle", "span", "orbit", unit="radians")]
    moments: Annotated[np.ndarray, along("angle", "moment", "orbit")]
    weights: Annotated[np.ndarray, along("weight")]
    turns: Annotated[np.ndarray, along("orbit", unit="turns")]
    ended: Annotated[np.ndarray, along("orbit")]
    still: Annotated[np.ndarray, along("run", "orbit")]
    nu: Annotated[np.ndarray, along("angle", "orbit", unit="1/turn")]
    error: Annotated[np.ndarray, along("angle", "orbit", unit="1/turn")]
    halves: Annotated[np.ndarray, along("half", "angle", "orbit", unit="1/turn")]
    window: Annotated[np.ndarray, along("orbit", unit="turns")]


@inserts_parameters
class TuneAccumulator:
    """Tunes with error estimates and diffusion of orbits that are pushed a few turns at a time.

    `push` adds the next turns and ``tunes()`` returns the result so far. ``state`` can be saved, and the accumulator
    itself can be pickled.

    Parameters
    ----------
    coordinates : str or sequence of str, optional
        Names of the 2n rows. Default: q1, ..., p1, ...
    {threads}

    Raises
    ------
    ValueError
        If a name or the number of threads is out of its range.
    TypeError
        If an argument is of a wrong kind.

    Notes
    -----
    - Method: windows of :math:`[2^k, 2^{k + 1})` turns, each averaged as in `tunes` about the centre and ellipse of the
      previous one. The number of turns need not be known.
    - Result: the tunes of the last complete window, a quarter to a half of all turns. They depend on the chunks by
      round-off only.
    - Limits: spectral lines need the samples and are not computed. If a loop passes through its centre, as for coupled
      planes, the error shows that there is no tune; orbits whose planes show one line are UNDECIDED. Use `tunes`
      instead.
    - Cost: 2 ns a plane and turn. Memory: :math:`8(12 + 26n)` bytes an orbit, for any number of turns.

    References
    ----------
    Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111 (weighted averages); Laskar 1990, Icarus 88, 266 (diffusion);
    Courant & Snyder 1958, Ann. Phys. 3, 1 (ellipses).

    Examples
    --------
    >>> turn = 2 * np.pi * 0.28 * np.arange(600)
    >>> running = fa.TuneAccumulator()
    >>> for part in np.split(np.array([np.cos(turn), -np.sin(turn)]), 3, axis=1):
    ...     running.push(part)
    >>> running.tunes().nu.round(9)
    array([[0.28]])
    """

    def __init__(self, coordinates: str | Sequence[str] | None = None, *, threads: int | None = None):
        self._coordinates = None if coordinates is None else row_names(coordinates)
        wrong = None if self._coordinates is None else wrong_order(self._coordinates, by_name=False, alone=True)
        if wrong is not None:
            raise wrong
        self._threads = threads
        checked_threads(threads)
        self._known: _AccumulatedResults | None = None

    @classmethod
    @inserts_parameters
    def of(cls, state: TuneSums, *, threads: int | None = None) -> TuneAccumulator:
        """Return an accumulator that resumes from a state.

        Parameters
        ----------
        state : TuneSums
            State of another accumulator.
        {threads}

        Returns
        -------
        `TuneAccumulator`
            New accumulator.

        Raises
        ------
        TypeError
            If `state` is of another kind.
        """
        if not isinstance(state, TuneSums):
            raise TypeError(f"state must be a TuneSums, got {type(state).__name__}")
        found = cls(threads=threads)
        found._coordinates = state.names
        found._known = _AccumulatedResults.of(state)
        return found

    @property
    def samples(self) -> int:
        """Number of turns that have been pushed."""
        return 0 if self._known is None else self._known.samples

    @property
    def state(self) -> TuneSums:
        """Copy of the state, a `TuneSums`.

        Raises
        ------
        ValueError
            If nothing has been pushed.
        """
        return self._pushed().state()

    def push(self, samples: Given) -> None:
        """Add the next turns of all orbits.

        Parameters
        ----------
        samples : array_like, shape (2n, orbits, turns) or (2n, turns)
            Any number of turns, in the forms that `tunes` accepts. Samples are NaN or one point from the end of an
            orbit on.

        Raises
        ------
        ValueError
            If a sample is wrong, or the number of orbits has changed. The message counts samples from the first push.
        TypeError
            If `samples` is of a wrong kind.

        Notes
        -----
        If an error is raised, or on Ctrl-C, no turn has been added.
        """
        names = self._coordinates if self._known is None else self._known.names
        given = given_orbits(samples, coordinates=names, least=int(self._known is None), ordered=True)
        rows, orbits, _ = given.shape
        z = given.read(0, orbits)
        threads = checked_threads(self._threads)
        if self._known is None:
            known = _AccumulatedResults(given.names, z[:, :, 0])
        elif (rows, orbits) != self._known.last_shape:
            raise ValueError(
                f"samples must have {self._known.last_shape[0]} rows of {self._known.last_shape[1]} orbits, as before, "
                f"got shape {given.shape}"
            )
        else:
            known = self._known.copy()
        known.push(z, threads)
        self._known = known

    def tunes(self) -> Tunes:
        """Return the tunes of all orbits so far.

        Returns
        -------
        `Tunes`
            Tunes over the last complete window.

        Raises
        ------
        ValueError
            If nothing has been pushed.
        """
        known = self._pushed()
        means = without_standing(Means(known.nu, known.error, known.halves), known.window)
        lost = known.stay(known.samples)
        turns = known.turns - lost * (known.still[0] + 1)
        status = np.where(known.ended, Status.NONFINITE, np.where(lost, Status.LOST, Status.OK))
        names = known.names[: len(known.nu)]
        # Whether two planes show one line or two that are close by, lines would tell, which need the samples.
        ambiguous = entangled(np.where(np.isfinite(means.error), means.nu, np.nan), known.window)
        return tunes_of(names, means, np.zeros(known.nu.shape, np.int8), turns, known.window.copy(), status, ambiguous)

    def _pushed(self) -> _AccumulatedResults:
        if self._known is None:
            raise ValueError("samples must be pushed first")
        return self._known

    def __repr__(self) -> str:
        if self._known is None:
            return "TuneAccumulator()"
        return f"TuneAccumulator: {self._known.last_shape[1]} orbits, {self.samples} turns"


class _AccumulatedResults:
    """The results of an accumulator so far, in arrays that one push changes."""

    def __init__(self, names: tuple[str, ...], first: np.ndarray):
        rows, orbits = first.shape
        n = rows // 2
        self.names = names
        self.samples = 0
        self.turning = RotationAccumulator(first)
        self.turns, self.window = np.zeros((2, orbits), np.int64)
        self.ended, self.still = np.zeros(orbits, bool), np.array([[-1], [0]]).repeat(orbits, axis=1)
        self.nu = np.zeros((n, orbits))
        self.error = np.full((n, orbits), np.inf)
        self.halves = np.zeros((2, n, orbits))

    @property
    def last_shape(self) -> tuple[int, int]:
        """Rows and orbits."""
        return self.turning.last.shape[1], self.turning.last.shape[0]

    def copy(self) -> _AccumulatedResults:
        """Return a copy that a push may change."""
        return copy.deepcopy(self)

    def stay(self, samples: int) -> np.ndarray:
        """Return a mask (orbits,) of orbits that stay at one point to the last of so many samples, see `stays`."""
        return stays(self.still[0], self.still[1], samples) & ~self.ended

    def push(self, z: np.ndarray, threads: int) -> None:
        """Take the samples z (2n, orbits, samples)."""
        until, again = np.empty((2, z.shape[1]), np.int64)
        given = (z, self.turning.last, self.ended.astype(np.int64), until, again, self.still)
        run_orbits(kernels.finite_until, z.shape[1], given, threads)
        for orbit in np.flatnonzero(again >= 0)[:1]:
            lost = self.turns[orbit] if self.ended[orbit] else self.samples + until[orbit]
            raise gap(int(orbit), int(lost), self.samples + int(again[orbit]))
        self.turns += until
        self.ended |= until < z.shape[2]
        lived = self.turns - self.stay(self.samples + z.shape[2]) * self.still[0]
        at = 0
        if self.samples == 0:
            at = 1  # the first sample, from which no step is known yet
        while at < z.shape[2]:
            step = self.samples + at - 1
            window = window_of(step)
            size = min(z.shape[2] - at, window.begin + window.length - step, PIECE)
            angles = window.begin > 0
            part = np.clip(until - at, 0, size)
            self.turning.add(z[:, :, at : at + size], part, step, window, threads, angles=angles, frame=True)
            at += size
            if step + size == window.begin + window.length:
                self._end(window, angles, lived, threads)
        self.samples += z.shape[2]

    def _end(self, window: TurningWindow, angles: bool, lived: np.ndarray, threads: int) -> None:
        """Keep the means of a complete window for the orbits that came to its end, and begin the next."""
        alive = lived > window.begin + window.length
        if angles:
            nu, error, halves = self.turning.means(window.length, threads)
            self.nu[:, alive], self.error[:, alive] = nu[:, alive], error[:, alive]
            self.halves[:, :, alive], self.window[alive] = halves[:, :, alive], window.length
        self.turning.learn(alive, threads)
        self.turning.clear()

    def state(self) -> TuneSums:
        """Return a copy of the state."""
        turning = self.turning
        return TuneSums(
            names=self.names,
            samples=self.samples,
            last=turning.last.T.copy(),
            planes=turning.planes.transpose(1, 2, 0).copy(),
            sums=turning.sums.transpose(1, 2, 0).copy(),
            moments=turning.moments.transpose(1, 2, 0).copy(),
            weights=turning.weights.copy(),
            turns=self.turns.copy(),
            ended=self.ended.copy(),
            still=self.still.copy(),
            nu=self.nu.copy(),
            error=self.error.copy(),
            halves=self.halves.copy(),
            window=self.window.copy(),
        )

    @classmethod
    def of(cls, state: TuneSums) -> _AccumulatedResults:
        """Return the results in a state."""
        known = cls(state.names, np.array(state.last, np.float64))
        turning = known.turning
        for name in ("planes", "sums", "moments"):
            setattr(turning, name, np.ascontiguousarray(getattr(state, name).transpose(2, 0, 1)))
        turning.weights = np.array(state.weights)
        known.samples = state.samples
        for name in ("turns", "ended", "still", "nu", "error", "halves", "window"):
            setattr(known, name, np.array(getattr(state, name)))
        return known
