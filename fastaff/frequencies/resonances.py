"""Resonances of frequency vectors: the integer relations k . nu = 0, the lattice they span, and the diffusion."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import (
    MOST,
    Callback,
    an_array,
    checked_callback,
    fits,
    numbers,
    positive,
    real,
    shown,
    texts,
    whole,
)
from ..core.status import Status, counted, describe
from ..engine.jit import LANES
from ..engine.packing import launch
from ..engine.threads import checked_threads
from ..results.progress import says_progress
from ..results.result import Result, along
from .kernels.resonance import relations
from .own_lines import TURN, by_own_lines, own_lines, with_turn

TOLERANCE = 1e-9
"""Relative width of a resonance of frequencies without errors."""

SHOWN = 12
"""Resonances that are printed by name."""

CHANCE = 0.01
"""Expected number of relations by chance, up to the order of one and within the errors, from which it is undecided. Of
false `nu_x = nu_y` of a logarithmic potential over 140 periods all exceed it.
"""

MAX_ORDER = 50
"""Largest order: 2.1 million vectors of four frequencies."""


@dataclass(frozen=True)
class Resonances(Result):
    r"""Resonance module of each orbit: the lattice of integer vectors k with k·nu = 0 within its width.

    Arrays over orbits have the shape of one row of the frequencies.

    Attributes
    ----------
    names : tuple of str, length n
        Names of the frequencies.
    max_order : int
        Largest order of the vectors searched.
    tolerance : float
        Relative width of a resonance.
    rank : ndarray of int, shape (...)
        Number of independent resonances that the errors do not allow by chance.
    basis : ndarray of int, shape (n, n, ...)
        Basis vectors in the first `rank` rows, the shortest first, then 0. Every integer vector of their span is an
        integer combination of them.
    order : ndarray of int, shape (...)
        Order :math:`|k|_1` of the shortest vector; 0 if there is none.
    distance : ndarray, shape (n, ...)
        :math:`|k \cdot \nu|` of each basis vector, in the units of the frequencies; NaN after the rank.
    width : ndarray, shape (n, ...)
        Largest value allowed for `distance`; NaN after the rank.
    accidental : ndarray, shape (...)
        Expected number of resonances of a random frequency vector.
    status : ndarray of int, shape (...)
        `Status` of each orbit: NONFINITE if a frequency is not finite; NOT_CONVERGED if it is undecided, because an
        error is not finite or so wide that every relation may be chance; else that of the given result. Orbits that are
        not OK have rank 0.
    lines : Resonances, optional
        The same for the dominant lines of the coordinates, which figures and `orbit_families` use: a loop in a galaxy
        has ``nu_x - nu_y = 0``. None for others than a frequency map of coordinates in time.

    References
    ----------
    Morbidelli 2002, Modern Celestial Mechanics, section 2.1.
    """

    names: tuple[str, ...]
    max_order: int
    tolerance: float
    rank: Annotated[np.ndarray, along("orbit")]
    basis: Annotated[np.ndarray, along("vector", "angle", "orbit")]
    order: Annotated[np.ndarray, along("orbit")]
    distance: Annotated[np.ndarray, along("vector", "orbit", unit="cycles/time")]
    width: Annotated[np.ndarray, along("vector", "orbit", unit="cycles/time")]
    accidental: Annotated[np.ndarray, along("orbit")]
    status: Annotated[np.ndarray, along("orbit")]
    lines: Annotated[Resonances | None, along("orbit")] = None

    @property
    def dimension(self) -> np.ndarray:
        """Dimension n - rank of the torus that an orbit fills densely: 1 for a periodic orbit, 0 for rest."""
        return self.basis.shape[0] - self.rank

    def table(self) -> list[tuple[tuple[tuple[int, ...], ...], int]]:
        """Return the modules of the OK orbits with their numbers of orbits.

        Returns
        -------
        list of tuple
            Tuples (module, orbits), where a module is a tuple of basis vectors. Frequent modules are first.
        """
        n = self.basis.shape[0]
        rows = np.ascontiguousarray(
            self.basis.reshape(n * n, -1)[:, self.status.ravel() == Status.OK].T.astype(np.int8)
        )
        modules, counts = np.unique(rows.view(np.dtype((np.void, n * n))).ravel(), return_counts=True)
        bases = modules.view(np.int8).reshape(-1, n, n).tolist()
        found = [
            (tuple(tuple(k) for k in basis if any(k)), int(count)) for basis, count in zip(bases, counts, strict=True)
        ]
        return sorted(found, key=lambda entry: (-entry[1], entry[0]))

    def label(self, orbit: Any = ()) -> str:
        """Return the module of one orbit as text, such as ``nu_alpha - nu_beta = 0``.

        Parameters
        ----------
        orbit : int or tuple of int, default ()
            Index of the orbit.

        Returns
        -------
        str
            Equations of the basis vectors.
        """
        where = orbit if isinstance(orbit, tuple) else (orbit,)
        if len(where) != self.status.ndim:
            raise ValueError(f"orbit must be an index of {self.status.ndim} numbers, got {shown(orbit)}")
        where = tuple(whole("orbit", k, -size, size - 1) for k, size in zip(where, self.status.shape, strict=True))
        outcome = Status(int(self.status[where]))
        if outcome != Status.OK:
            return f"{outcome.name}: {self._advice().get(outcome, outcome.sentence)}"
        basis = self.basis[(slice(None), slice(None), *where)][: int(self.rank[where])]
        return ", ".join(equation(k, self.names) for k in basis) or f"no resonance up to order {self.max_order}"

    def __str__(self) -> str:
        """Return the fields, and the frequent resonances by name with the share of orbits that have them."""
        rows = [f"  orbits      share  resonance, to order {self.max_order}", *self._rows()]
        if self.lines is not None:
            rows += ["  orbits      share  resonance of the dominant lines", *self.lines._rows()]
        return "\n".join([super().__str__(), *rows])

    def _rows(self) -> list[str]:
        """Return lines of text with the frequent resonances."""
        table = self.table()
        total = np.count_nonzero(self.status == Status.OK)
        rows = [
            f"  {count:8d}  {count / total:6.1%}  {'; '.join(equation(k, self.names) for k in basis) or 'none'}"
            for basis, count in table[:SHOWN]
        ]
        rest = sum(count for _, count in table[SHOWN:])
        rows += [f"  {rest:8d}  {rest / total:6.1%}  {len(table) - SHOWN} others"] if rest else []
        undecided = int(np.count_nonzero(self.status == Status.NOT_CONVERGED))
        return rows + ([f"  {undecided:8d}          undecided"] if undecided else [])

    def _advice(self) -> dict[Status, str]:
        """Return the words for orbits that are undecided."""
        return {Status.NOT_CONVERGED: "undecided, as the errors of the frequencies are too wide; try a longer time"}

    def summary(self) -> str:
        """Return one line with the number of orbits that have no resonance, one, two and more.

        Returns
        -------
        str
            Summary. For a frequency map it has the number of orbits with resonant dominant lines too.
        """
        ranks = [int(rank) for rank in np.unique(self.rank)]
        said = {rank: "not resonant" if rank == 0 else f"with {counted(rank, 'resonance')}" for rank in ranks}
        kinds = {words: self.rank == rank for rank, words in said.items()}
        text = self._in_own_words(describe(self.status, kinds))
        if self.lines is None:
            return text
        return f"{text}; {counted(int(np.count_nonzero(self.lines.rank)), 'orbit')} with resonant dominant lines"


def relation(k: Sequence[int], names: Sequence[str]) -> tuple[list[tuple[int, str]], int, str]:
    """Return the terms (k_i, name) of k . nu = 0, the first of them positive, the number on the other side, and the
    letter of the frequencies: Q for tunes, which are related to the turn.
    """
    terms = [(int(c), name) for c, name in zip(k, names, strict=True) if c and name != TURN]
    turns = sum(int(c) for c, name in zip(k, names, strict=True) if name == TURN)
    sign = -1 if terms and terms[0][0] < 0 else 1
    return [(sign * c, name) for c, name in terms], -sign * turns, "Q" if TURN in names else "nu"


def equation(k: Sequence[int], names: Sequence[str]) -> str:
    """Return k . nu = 0 as text: `nu_alpha - 2 nu_phi = 0`; of tunes `2 Q_x - Q_y = 1`."""
    terms, right, letter = relation(k, names)
    text = " ".join(f"{'-' if c < 0 else '+'} {f'{abs(c)} ' if abs(c) > 1 else ''}{letter}_{name}" for c, name in terms)
    return f"{text.removeprefix('+ ') or 0} = {right}"


@functools.lru_cache(maxsize=16)
def vectors(n: int, max_order: int) -> np.ndarray:
    """Return the primitive integer vectors (m, n) with |k|_1 <= max_order, one of each pair +-k, by |k|_1, then largest
    entry.

    The first entry that is not zero is positive. About (2 max_order)^n/(2 n! zeta(n)) of them: 7512 for n = 4 and order
    12.
    """
    rows = np.zeros((1, 0), np.int64)
    left = np.array([max_order])
    for _ in range(n):
        count = 2 * left + 1
        start = np.repeat(np.cumsum(count) - count, count)
        entry = np.arange(count.sum()) - start - np.repeat(left, count)
        rows = np.column_stack([np.repeat(rows, count, axis=0), entry])
        left = np.repeat(left, count) - np.abs(entry)
    first = rows[np.arange(len(rows)), (rows != 0).argmax(axis=1)]
    rows = rows[(first > 0) & (np.gcd.reduce(rows, axis=1) == 1)]
    size = np.abs(rows)
    rows = rows[np.lexsort((*-rows.T[::-1], size.max(axis=1), size.sum(axis=1)))]
    rows.flags.writeable = False
    return rows


@says_progress
@inserts_parameters
def resonances(
    nu: ArrayLike | Result,
    *,
    max_order: int = 8,
    tolerance: float = TOLERANCE,
    errors: ArrayLike | None = None,
    names: Sequence[str] | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> Resonances:
    r"""Find the integer relations between the frequencies of each orbit, and the lattice that they span.

    Parameters
    ----------
    nu : array_like, shape (n, ...), or result
        Frequencies of n = 2, 3 or 4 angles. A `FrequencyMap`, `ActionAngles` or `Tunes` provides names and errors too.
        For tunes and a frequency map of a map of up to three planes, the frequency 1 of the turn is appended.
    max_order : int, default 8
        Largest order :math:`|k|_1` of the vectors searched, from 1 to 50.
    tolerance : float, default 1e-9
        Relative width of a resonance, not negative.
    errors : array_like, shape of `nu`, default 0
        Absolute errors of the frequencies, such as ``.error``.
    names : sequence of str, optional
        Names of the frequencies, for labels.
    {threads}
    {callback}

    Returns
    -------
    `Resonances`
        Rank, basis and widths of each orbit. For a frequency map of coordinates in time, its ``lines`` are the
        resonances of their dominant lines.

    Raises
    ------
    ValueError
        If a shape is wrong, a value is out of its range, or n is not 2, 3 or 4.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the orbits finished so far in ``.partial``.

    Notes
    -----
    - Resonance: a primitive k with :math:`|k|_1 \le \mathrm{max\_order}` and :math:`|k \cdot \nu| \le
      \mathrm{tolerance}\,|k|_1 \max|\nu| + \sum_i |k_i|\,\mathrm{error}_i`. The entry for the turn counts: 3 nu_x = 1
      has order 4.
    - Basis: Minkowski's reduction in the norm :math:`|k|_1`. If it needs a vector that is no resonance, the errors are
      too wide and the status is NOT_CONVERGED.
    - Significance: a resonance counts if the errors allow fewer than 0.01 accidental ones up to its order. An orbit
      with none that counts is undecided, NOT_CONVERGED.
    - Accidental: :math:`\sum_k 2 c_n\,\mathrm{width}(k)/(|k|_2 |\nu|_2)`, :math:`c_n =
      \Gamma(n/2)/(\sqrt{\pi}\,\Gamma((n - 1)/2))`. If it is not far below 1, reduce `max_order`, `tolerance` or the
      errors. For n = 4 it is 2e-6 by default, 1e-5 at order 12.
    - Two kinds: ``nu`` are independent frequencies, whose resonances reduce the dimension of the torus. Loops fill two
      dimensions, but their coordinates have one dominant line: ``resonances(found).lines`` counts them.
    - Cost: 15 flops an orbit and vector; n = 4 has 1640 vectors. Memory: 64 bytes an orbit beyond the results.

    References
    ----------
    Laskar 1990, Icarus 88, 266 (resonances in frequency maps); Cassels 1971, An Introduction to the Geometry of
    Numbers, section V.4 (reduction); the degeneracy conditions after EQ3.23 and EQa of Martens & Slawianowski.

    Examples
    --------
    >>> found = fa.resonances([0.2, 0.4, 0.3137], max_order=4)
    >>> found.rank, found.label()
    (array(1), '2 nu_1 - nu_2 = 0')
    """
    checked_callback(callback)
    given: Any = nu
    lined = given if errors is None and isinstance(given, Result) and by_own_lines(given) else None
    if hasattr(given, "nu") and hasattr(given, "names"):  # a result that carries its names
        own, given, error = with_turn(given)
        names = own if names is None else names
        if errors is None and np.shape(error) == np.shape(given):
            errors = error
    ends = np.ravel(getattr(nu, "status", Status.OK))
    (nu, errors) = checked_frequencies(given, errors)
    max_order, tolerance = whole("max_order", max_order, 1), real("tolerance", tolerance)
    if max_order > MAX_ORDER:
        raise ValueError(f"max_order must be at most {MAX_ORDER}, got {max_order}")
    if tolerance < 0:
        raise ValueError(f"tolerance must not be negative, got {tolerance}")
    count = checked_threads(threads)
    n, shape, names = len(nu), nu.shape[1:], _names(names, len(nu))
    flat, spread = np.zeros((2, 4, math.prod(shape)))
    flat[:n] = nu.reshape(n, -1)
    spread[:n] = widths(nu, tolerance, errors).reshape(n, -1)
    status = np.where(np.isfinite(spread).all(axis=0), Status.OK, Status.NOT_CONVERGED)
    status[~np.isfinite(flat).all(axis=0)] = Status.NONFINITE
    status = np.where(ends == Status.OK, status, ends)
    spread[:, status != Status.OK] = np.nan
    rank, basis = np.zeros(status.size, np.int64), np.zeros((status.size, 4, 4), np.int64)
    table = np.zeros((len(vectors(n, max_order)), 4), np.int64)
    table[:, :n] = vectors(n, max_order)
    progress = np.zeros(math.ceil(status.size / LANES))

    noise = np.zeros((n, status.size))
    noise[:, status == Status.OK] = errors.reshape(n, -1)[:, status == Status.OK]

    def found() -> Resonances:
        done = np.repeat(progress > 0, LANES)[: status.size]
        outcome = np.where(done | (status != Status.OK), status, Status.INTERRUPTED)
        bases = _by_order(np.ascontiguousarray(np.moveaxis(basis[:, :n, :n], 0, -1)), rank)
        counted_rank = _significant(bases, rank, flat[:n], noise, max_order)
        unsure = (rank > 0) & (counted_rank == 0)
        present = np.arange(n)[:, None] < counted_rank
        bases = np.where(present[:, None], bases, 0)
        size = np.abs(bases)
        frequencies, allowed = (np.where(outcome == Status.OK, rows[:n], 0.0) for rows in (flat, spread))
        distance = np.where(present, np.abs(np.einsum("ijo,jo->io", bases, frequencies)), np.nan)
        width = np.where(present, np.einsum("ijo,jo->io", size, allowed), np.nan)
        rounding = 4 * np.finfo(float).eps * np.einsum("ijo,jo->io", size, np.abs(frequencies))
        # No frequencies within the errors have all that was found, or nothing that was found is significant.
        torn = (distance > width + rounding).any(axis=0) | unsure
        outcome = np.where(torn, Status.NOT_CONVERGED, outcome)
        distance, width = (np.where(torn, np.nan, rows) for rows in (distance, width))
        return Resonances(
            names=names,
            max_order=max_order,
            tolerance=tolerance,
            rank=np.where(torn, 0, counted_rank).reshape(shape),
            basis=np.where(torn, 0, bases).reshape(n, n, *shape),
            order=np.where(torn, 0, size[0].sum(axis=0)).reshape(shape),
            distance=distance.reshape(n, *shape),
            width=width.reshape(n, *shape),
            accidental=_accidental(flat[:n], spread[:n], max_order).reshape(shape),
            status=outcome.reshape(shape),
        )

    with partial_result_on_interrupt("resonances", found):
        if status.size:
            arguments = (n, table, flat, spread, rank, basis)
            launch(relations, arguments, progress, float(progress.size), count, callback)
    if lined is None:
        return found()
    return replace(found(), lines=line_resonances(lined, max_order, tolerance, names, threads))


def line_resonances(
    found: Any, max_order: int, tolerance: float, names: Sequence[str], threads: int | None
) -> Resonances:
    """Return the resonances of the coordinates' own lines of a frequency map."""
    own, error = own_lines(found)
    error = np.where(np.isfinite(own), error, np.inf)
    given = np.nan_to_num(own)
    made = resonances(given, max_order=max_order, tolerance=tolerance, errors=error, names=names, threads=threads)
    fine = found.status == Status.OK
    return replace(
        made,
        rank=np.where(fine, made.rank, 0),
        basis=np.where(fine, made.basis, 0),
        order=np.where(fine, made.order, 0),
        status=np.where(fine, made.status, found.status),
    )


def widths(nu: np.ndarray, tolerance: float, errors: np.ndarray) -> np.ndarray:
    """Return tolerance max|nu| + errors (n, ...), so that width(k) = sum of |k_i| times these."""
    with np.errstate(invalid="ignore"):
        return tolerance * np.abs(nu).max(axis=0) + errors


def checked_frequencies(nu: Any, errors: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return nu and its errors (n, ...) as float64 of one shape, or raise."""
    try:
        array = numbers("nu", nu).astype(np.float64)
        spread = np.zeros(array.shape) if errors is None else numbers("errors", errors)
    except (TypeError, ValueError):
        raise TypeError(
            f"nu and errors must be arrays of real numbers, got {type(nu).__name__}, {type(errors).__name__}"
        ) from None
    if array.ndim == 0 or not 2 <= array.shape[0] <= 4:
        raise ValueError(f"nu must have shape (n,) or (n, ...) with n = 2, 3 or 4 frequencies, got {array.shape}")
    if spread.shape != array.shape:
        raise ValueError(f"errors must have the shape {array.shape} of nu, got {spread.shape}")
    if (spread < 0).any():
        raise ValueError(f"errors must not be negative, got {np.nanmin(spread)}")
    return array, spread


def _names(names: Sequence[str] | None, n: int) -> tuple[str, ...]:
    """Return names, by default 1 to n."""
    chosen = tuple(str(i + 1) for i in range(n)) if names is None else texts("names", names)
    if len(chosen) != n:
        raise ValueError(f"names must be {n} names, one for each frequency, got {shown(names)}")
    return chosen


def _by_order(basis: np.ndarray, rank: np.ndarray) -> np.ndarray:
    """Return bases (n, n, orbits) with the shorter rows first; they are so but where a width hid a short vector."""
    size = np.abs(basis).sum(axis=1)
    size[np.arange(len(size))[:, None] >= rank] = np.iinfo(np.int64).max
    wrong = np.flatnonzero((np.diff(size, axis=0) < 0).any(axis=0))
    if wrong.size:
        rows = np.argsort(size[:, wrong], axis=0, kind="stable")
        basis[:, :, wrong] = np.take_along_axis(basis[:, :, wrong], rows[:, None], axis=0)
    return basis


@functools.lru_cache(maxsize=16)
def _sums_of_ratios(n: int, max_order: int) -> np.ndarray:
    """Return the sums of |k_1|/|k|_2 over the vectors up to each order from 0 to max_order; every component has the
    same.
    """
    k = vectors(n, max_order)
    size = np.abs(k).sum(axis=1)
    sums = np.bincount(size, size / np.sqrt((k * k).sum(axis=1)), minlength=max_order + 1).cumsum() / n
    sums.flags.writeable = False
    return sums


def _relative_spread(nu: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Return the expected number (orbits,) of accidental relations per unit sum of ratios; NaN at rest."""
    n = len(nu)
    density = math.gamma(n / 2) / (math.sqrt(math.pi) * math.gamma((n - 1) / 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.abs(nu).max(axis=0)
        ratio = nu / top  # squares in any units
        return np.asarray(2 * density * (spread.sum(axis=0) / top) / np.sqrt((ratio * ratio).sum(axis=0)))


def _accidental(nu: np.ndarray, spread: np.ndarray, max_order: int) -> np.ndarray:
    """Return the expected number (orbits,) of accidental relations, at most that of all vectors; NaN where spread
    is.
    """
    n = len(nu)
    expected = _relative_spread(nu, spread) * _sums_of_ratios(n, max_order)[-1]
    most = float(len(vectors(n, max_order)))
    resting = np.isfinite(spread).all(axis=0) & ~(np.abs(nu).max(axis=0) > 0)
    return np.where(resting, most, np.minimum(expected, most))


def _significant(bases: np.ndarray, rank: np.ndarray, nu: np.ndarray, errors: np.ndarray, max_order: int) -> np.ndarray:
    """Return the number (orbits,) of first vectors of bases (n, n, orbits) up to whose order fewer than CHANCE
    accidental relations within the errors are expected; at rest all of them.
    """
    length = np.minimum(np.abs(bases).sum(axis=1), max_order)
    expected = _relative_spread(nu, errors) * _sums_of_ratios(len(nu), max_order)[length]
    wide = (expected >= CHANCE) & (np.arange(len(nu))[:, None] < rank)
    return np.where(wide.any(axis=0), wide.argmax(axis=0), rank)


@dataclass(frozen=True)
class DiffusionHistogram(Result, axis=None):
    r"""Counts of log10 diffusion, and the fraction of orbits above a threshold.

    Attributes
    ----------
    edges : ndarray, shape (bins + 1,)
        Edges of the bins.
    counts : ndarray of int, shape (bins,)
        Number of orbits in each bin.
    threshold : float
        Threshold of the fraction.
    fraction : float
        Fraction of the orbits above the threshold; 0 without orbits.
    error : float
        Standard deviation :math:`\sqrt{f (1 - f)/N}` of the fraction f of N orbits, as a sample of a larger set.
    orbits : int
        Number of orbits that are counted.
    missing : int
        Number of the other orbits: not finite, or not OK.
    """

    edges: Annotated[np.ndarray, along("edge", unit="log10(cycles/time)")]
    counts: Annotated[np.ndarray, along("bin")]
    threshold: float
    fraction: float
    error: float
    orbits: int
    missing: int


def diffusion_histogram(
    diffusion: Any, *, threshold: float = -6.0, bin_width: float = 0.25, status: Any = None
) -> DiffusionHistogram:
    """Count orbits by their diffusion, and those that diffuse faster than a threshold.

    Parameters
    ----------
    diffusion : array_like
        Logarithms log10 of the change of frequencies, such as ``diffusion`` of a `FrequencyMap`.
    threshold : float, default -6
        Threshold of the fraction, in the same logarithm.
    bin_width : float, default 0.25
        Positive width of the bins. Their edges are whole multiples of it, so that histograms can be compared.
    status : array_like of int, shape of `diffusion`, optional
        `Status` of each orbit; orbits that are not OK are left out.

    Returns
    -------
    DiffusionHistogram
        Edges and counts of the bins, and the fraction above the threshold.

    Raises
    ------
    ValueError
        If a value or shape is wrong.
    TypeError
        If an argument is of a wrong kind.

    Notes
    -----
    - Cost: one pass.

    References
    ----------
    Laskar 1993, Physica D 67, 257 (diffusion of frequencies).

    Examples
    --------
    >>> histogram = fa.frequencies.diffusion_histogram([-9.0, -8.0, -3.0, np.nan])
    >>> histogram.fraction, histogram.missing
    (0.3333333333333333, 1)
    """
    threshold = real("threshold", threshold)
    bin_width = positive("bin_width", bin_width)
    values = numbers("diffusion", diffusion)
    kept = np.isfinite(values)
    if status is not None:
        status = an_array("status", status)
        if status.shape != values.shape:
            raise ValueError(f"status must have the shape {values.shape} of diffusion, got {status.shape}")
        kept = kept & (status == Status.OK)
    missing = int(values.size - np.count_nonzero(kept))
    values = values[kept]
    bins = float(np.ptp(values) / bin_width) if values.size else 1.0
    if not (bins < MOST and np.abs(values).max(initial=abs(threshold)) / bin_width < MOST):
        raise ValueError(
            f"bin_width must be wider for values up to {np.abs(values).max(initial=0.0):.6g}, got {bin_width}"
        )
    fits("bin_width", int(bins) + 1, 2)
    cell = np.floor(values / bin_width).astype(np.int64)
    low = int(cell.min()) if cell.size else math.floor(threshold / bin_width)
    counts = np.bincount(cell - low, minlength=1)
    fraction = float(np.mean(values > threshold)) if values.size else 0.0
    error = math.sqrt(fraction * (1 - fraction) / max(values.size, 1))
    edges = bin_width * np.arange(low, low + counts.size + 1)
    return DiffusionHistogram(
        edges, counts, threshold, fraction=fraction, error=error, orbits=int(values.size), missing=missing
    )
