"""Frequencies read from samples of orbits: each from the loop or the line that knows it best, with an error."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .angle_loops import Layout, Signals, clock_windows
from .fundamental import Loops, Modes, damping, fastest, line_changes, line_rates, modes, turning, values, windows
from .integer_lattice import box

SAFETY = 5.0
"""Factor of error estimates over the differences of windows and of steps: covers 99 % of the errors
(bench/test_frequency.py).
"""

LINES_DENSE = 0.8
"""Radians of the fastest motion between samples that lines are fitted to."""

CHANGED = 0.3
"""Cycles over a half by which frequencies differ from half to half where they are said to change."""

ROUGH = 0.1
"""Share of a loop's size that its strongest lines leave, beyond which a changing average is most likely chaos."""

SAME = 0.5
"""Cycles over the window by which a mean rate may be off the line that it should be."""

RESOLVED, CRISP = 1.5, 1e-6
"""Cycles over the window between two frequencies that lines tell apart, and errors up to which they need not be."""

BLUR = 4.0
"""Factor of the errors of closer ones all the same: all windows see the same of a beat."""

ROUNDING = 1e-13
AT_ONCE = 256
"""Loops whose lines are fitted at once."""

REACH = 12
"""Largest |k_i| that relates a body's own angles to the lattice of its librations' lines."""


class Samples(NamedTuple):
    """What is known of some orbits: signals of the run, `interval` apart, and of its start (orbits, rows, samples) with
    a finer step.

    order: of a scheme whose frequencies are those of a nearby system, so that the error is the same over all times; 0
    where it grows. start None: of samples that were given nothing is known of a scheme.
    """

    run: Signals
    start: np.ndarray | None
    interval: float
    order: int


class Reading(NamedTuple):
    """Frequencies as in a FrequencyMap, orbits first: nu and the like (orbits, n), halves (orbits, n, 2), basis
    (orbits, n, n).

    scheme_error: the share of the error (orbits, n) that is the scheme's, and rounding's.
    """

    nu: np.ndarray
    error: np.ndarray
    scheme_error: np.ndarray
    halves: np.ndarray
    method: np.ndarray
    rank: np.ndarray
    leading: np.ndarray
    leading_error: np.ndarray
    basis: np.ndarray


class _Rates(NamedTuple):
    """Frequencies (orbits, loops) with what their errors are but for the scheme's, and the method of each.

    halves (orbits, loops, 2): values of the halves; step: what they lose where the step is halved, and step_error: how
    much that may be.
    """

    nu: np.ndarray
    error: np.ndarray
    method: np.ndarray
    step: np.ndarray
    step_error: np.ndarray
    halves: np.ndarray

    def where(self, chosen: np.ndarray, other: _Rates) -> _Rates:
        """Return these for the chosen ones, `other` for the rest."""
        return _Rates(
            *(np.where(chosen if a.ndim == 2 else chosen[:, :, None], a, b) for a, b in zip(self, other, strict=True))
        )

    def better(self, other: _Rates) -> _Rates:
        """Return for each entry the one of the smaller error."""
        return self.where(self.error <= other.error, other)

    def of(self, loops: slice) -> _Rates:
        """Return those of some loops."""
        return _Rates(*(entry[:, loops] for entry in self))


def read(layout: Layout, samples: Samples, fallback: float, threads: int) -> Reading:
    """Read the frequencies of sampled orbits; lines are fitted again where the relative error exceeds `fallback` (0:
    all are lines).
    """
    s, start, dt = samples.run.s, samples.start, samples.interval
    time, m, n = (s.shape[2] - 1) * dt, layout.m, len(layout.angles.names)
    found, stride = _modes(s[:, : 2 * m], dt, threads)
    loops = _all_loops(layout, samples.run, found)
    rates = _averages(layout, s, start, loops, dt, threads)
    # A loop's mean rate counts where it is the line that the loop was made for.
    own, centre = rates.of(slice(0, m)), found.nu
    sound = (np.abs(own.nu - centre) * time < SAME) | (found.rank == 0)[:, None]
    own = own._replace(error=np.where(sound & found.moving, own.error, np.inf))
    line = own._replace(nu=centre, error=np.where(centre > 0, found.spread, np.inf), method=np.ones_like(own.method))

    def librations(lattice: _Rates) -> tuple[_Rates, np.ndarray]:
        """Return the frequencies that stand for the lattice's, and the leading lines' integers."""
        best = lattice.better(line) if np.isfinite(fallback) else lattice.where(np.isfinite(lattice.error), line)
        if not layout.body:
            return best, found.combination
        return _own_angles(best, rates.of(slice(m, 2 * m)), found, layout.separate, time, fallback == 0)

    steady = centre
    if 0 < fallback < np.inf:
        rough = (_change(librations(own)[0], time) > CHANGED).any(axis=1) & (found.rest > ROUGH) & ~found.drifting
        lost = found.drifting | _without_lines(own, rough, s, loops, centre, stride, dt, threads)
        steady = np.where(lost[:, None], 0.0, centre)
    chosen, combination = librations(_with_lines(own, s, loops, steady, stride, dt, fallback, threads))
    if not layout.body:
        chosen = chosen._replace(error=_blurred(chosen, found, time))
    leading, leading_error = np.zeros((2, len(centre), n))
    leading[:, :m], leading_error[:, :m] = found.leading, found.leading_error
    basis = np.zeros((len(centre), n, n), np.int64)
    basis[:, :m, :m] = combination
    if layout.body:
        planes = rates.of(slice(2 * m, None))
        regular = (_change(chosen, time) <= CHANGED).all(axis=1, keepdims=True) | (fallback == 0)
        near = np.where((planes.error * time < 3) & regular, planes.nu, 0.0)
        planes = _with_lines(
            planes, s, Loops(*(entry[:, 2 * m :] for entry in loops)), near, stride, dt, fallback, threads
        )
        chosen = _Rates(*(np.concatenate(pair, axis=1) for pair in zip(chosen, planes, strict=True)))
        leading[:, m:], leading_error[:, m:] = planes.nu, planes.error
        basis[:, range(m, n), range(m, n)] = 1
    return _with_scheme(chosen, samples, found.rank + n - m, leading, leading_error, basis)


def _with_scheme(
    rates: _Rates, samples: Samples, rank: np.ndarray, leading: np.ndarray, leading_error: np.ndarray, basis: np.ndarray
) -> Reading:
    """Return the reading in which the scheme's error is taken off where it is known, and counted as an error three
    times over.
    """
    if samples.start is None:
        growth, correction = 0.0, np.zeros_like(rates.step)
    elif samples.order:
        growth, correction = 1.0, rates.step / (1 - 0.5**samples.order)
    else:
        growth, correction = samples.run.s.shape[2] / samples.start.shape[2], np.zeros_like(rates.step)
    top = np.abs(rates.nu).max(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        more = SAFETY * growth * rates.step_error + ROUNDING * top
        nu, error = rates.nu - correction, rates.error + more
    known = np.isfinite(error) & np.isfinite(nu)
    leading_error = leading_error + np.where(np.isfinite(more), more, np.inf).max(axis=1, keepdims=True)
    return Reading(
        np.where(known, nu, 0.0),
        np.where(known, error, np.inf),
        more,
        rates.halves,
        rates.method,
        rank,
        leading,
        leading_error,
        basis,
    )


def _blurred(rates: _Rates, found: Modes, time: float) -> np.ndarray:
    """Return the errors (orbits, m) of rates whose lines are as close as 1/time, within which two look like one.

    Known to 1/time only are loops that no line of the lattice explains, and two frequencies as close as that where not
    both are sharp, as those of two coordinates that do not know of one another are.
    """
    nu, error, some = rates.nu, rates.error, found.owned & (rates.nu > 0)
    vague = found.moving & ~found.owned & (found.combination == 0).all(axis=2)
    near = np.zeros_like(vague)
    for i, j in itertools.combinations(range(nu.shape[1]), 2):
        with np.errstate(invalid="ignore"):
            pair = some[:, i] & some[:, j] & (np.abs(nu[:, i] - nu[:, j]) * time < RESOLVED)
            both = pair & ((error[:, i] + error[:, j]) * time > CRISP)
        for k in (i, j):
            near[:, k] |= pair
            vague[:, k] |= both
    return np.where(near, BLUR * error, error) + vague / time


def _modes(s: np.ndarray, dt: float, threads: int) -> tuple[Modes, np.ndarray]:
    """Return the modes of signals and the strides of the samples that their lines were fitted to: each orbit's own."""
    fast = fastest(s, dt, threads) * dt
    stride = 2 ** np.floor(np.log2(np.clip(LINES_DENSE / np.maximum(fast, 1e-6), 1, max(1, s.shape[2] // 64)))).astype(
        np.int64
    )
    parts = [(np.flatnonzero(stride == k), int(k)) for k in np.unique(stride)]
    found = [modes(np.ascontiguousarray(s[where]), dt, k, threads) for where, k in parts]
    order = np.argsort(np.concatenate([where for where, _ in parts]))
    return Modes(*(np.concatenate(entries)[order] for entries in zip(*found, strict=True))), stride


def _all_loops(layout: Layout, signals: Signals, found: Modes) -> Loops:
    """Return the loops of the modes, then a body's own."""
    orbits, rows, _ = signals.s.shape
    c = np.zeros((orbits, layout.m, rows), complex)
    c[:, :, : 2 * layout.m] = found.dual
    loops = Loops(c, found.offset, found.drift)
    if not layout.body:
        return loops
    own, offset = layout.own(signals)
    return Loops(
        *(np.concatenate(pair, axis=1) for pair in zip(loops, (own, offset, np.zeros_like(offset)), strict=True))
    )


def _averages(layout: Layout, s: np.ndarray, start: np.ndarray | None, loops: Loops, dt: float, threads: int) -> _Rates:
    """Return weighted averages of all loops' rates, those of angles with a clock in that clock."""
    steps = s.shape[2] - 1
    rates = turning(s, loops, windows(steps), dt, threads)
    if layout.clocked:
        on = [layout.m + i for i in layout.clocked]
        weights = clock_windows(s[:, -1])
        rates[:, on] = turning(s, Loops(*(entry[:, on] for entry in loops)), weights, dt, threads)
    nu, time = rates[:, :, 0], steps * dt
    error = SAFETY * np.abs(rates[:, :, 1:-1] - nu[:, :, None]).max(axis=2) + np.abs(rates[:, :, -1] - nu)
    error = error + damping(np.abs(nu) * time) / time
    change = np.zeros((*nu.shape, 1))
    if start is not None:
        count = start.shape[2]
        brief = windows(count - 1)[:3]  # the halves too: what one window says may be small by chance
        coarse, fine = (turning(np.ascontiguousarray(x[:, :, :count]), loops, brief, dt, threads) for x in (s, start))
        change = coarse - fine
    return _Rates(
        nu,
        np.where(np.isfinite(error), error, np.inf),
        np.zeros(nu.shape, np.int8),
        change[:, :, 0],
        np.abs(change).max(axis=2),
        rates[:, :, 1:3],
    )


def _change(rates: _Rates, time: float) -> np.ndarray:
    """Return by how many cycles over a half the rates (orbits, loops) differ from one half of the time to the other."""
    return np.abs(rates.halves[:, :, 0] - rates.halves[:, :, 1]) * time / 2


def _parts(needed: np.ndarray, stride: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, int]]:
    """Yield the orbits and the loops of what is needed (orbits, loops), AT_ONCE or fewer of one stride, and that."""
    for k in np.unique(stride):
        orbits, loops = np.nonzero(needed & (stride == k)[:, None])
        for begin in range(0, orbits.size, AT_ONCE):
            part = slice(begin, begin + AT_ONCE)
            yield orbits[part], loops[part], int(k)


def _without_lines(
    own: _Rates,
    rough: np.ndarray,
    s: np.ndarray,
    loops: Loops,
    centre: np.ndarray,
    stride: np.ndarray,
    dt: float,
    threads: int,
) -> np.ndarray:
    """Tell of which `rough` (orbits,) orbits no lines need be fitted: in the loop whose average changes most from
    half to half the line does so too, which is chaos.
    """
    change = np.where(centre != 0, _change(own, (s.shape[2] - 1) * dt), 0.0)
    most = np.arange(change.shape[1]) == change.argmax(axis=1)[:, None]
    lost = np.zeros(len(centre), bool)
    for o, j, k in _parts(most & (change > CHANGED) & rough[:, None], stride):
        lost[o] = line_changes(values(s, loops, o, j, k, threads), dt * k, centre[o, j]) > CHANGED
    return lost


def _with_lines(
    rates: _Rates,
    s: np.ndarray,
    loops: Loops,
    centre: np.ndarray,
    stride: np.ndarray,
    dt: float,
    fallback: float,
    threads: int,
) -> _Rates:
    """Return the rates with those of lines by `centre` (orbits, loops), 0 for none, where needed and better, or where
    all are asked for.
    """
    top = np.abs(rates.nu).max(axis=1, keepdims=True)
    needed = (centre != 0) & ((rates.error > fallback * top) | (fallback == 0))
    lines = rates._replace(
        nu=rates.nu.copy(),
        error=np.full(rates.error.shape, np.inf),
        method=np.ones_like(rates.method),
        halves=rates.halves.copy(),
    )
    for o, j, k in _parts(needed, stride):
        useless = np.full(o.size, np.inf) if fallback == 0 else rates.error[o, j] / SAFETY
        nu, uncertainty = line_rates(values(s, loops, o, j, k, threads), dt * k, centre[o, j], useless)
        lines.nu[o, j], lines.error[o, j] = nu[0], SAFETY * uncertainty
        lines.halves[o, j] = np.where(np.isfinite(nu[1:3]).all(axis=0), nu[1:3], rates.halves[o, j].T).T
    return lines.where(np.isfinite(lines.error), rates) if fallback == 0 else rates.better(lines)


def _applied(k: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Return k . nu (orbits, vectors) of vectors k ((orbits,) vectors, m): in the same order for any number of
    orbits.
    """
    result = np.zeros((len(nu), k.shape[-2]))
    for j in range(nu.shape[1]):
        result += k[..., j] * nu[:, j, None]
    return result


def _own_angles(
    lattice: _Rates, own: _Rates, found: Modes, separate: bool, time: float, lines: bool
) -> tuple[_Rates, np.ndarray]:
    """Return a body's librations, by its own angles where their turning is a basis of the lattice, and the leading
    lines' integers.

    With `lines` the values are those of the lattice's lines where the own angles say which they are. An incomplete
    lattice has no say against angles that turn steadily; nor has any against angles made for bodies that `separate`.
    """
    orbits, m = lattice.nu.shape
    k = box([REACH] * m)
    k = k[np.argsort(np.abs(k).sum(axis=1), kind="stable")]
    vectors, matched = np.zeros((orbits, m, m), np.int64), found.rank == m
    bar = np.minimum(lattice.error, 1 / time)
    for j in range(m):
        miss = np.abs(_applied(k, lattice.nu) - own.nu[:, j, None])
        within = miss <= _applied(np.abs(k), bar) + own.error[:, j, None] + 1e-3 / time
        vectors[:, j] = k[within.argmax(axis=1)]
        matched &= within.any(axis=1) & (own.error[:, j] * time < SAME)
    basis = matched & (np.abs(np.rint(np.linalg.det(vectors.astype(float)))) == 1)
    steady = (own.error * time < SAME).all(axis=1) & (found.rank < m)
    kept = basis | steady | separate
    through = _Rates(
        _applied(vectors, lattice.nu),
        np.where(basis[:, None], _applied(np.abs(vectors), np.where(basis[:, None], bar, 0.0)), np.inf),
        np.where(vectors != 0, lattice.method[:, None, :], 0).max(axis=2),
        _applied(vectors, lattice.step),
        _applied(np.abs(vectors), lattice.step_error),
        np.stack([_applied(vectors, half) for half in np.moveaxis(lattice.halves, 2, 0)], axis=2),
    )
    best = through.where(np.isfinite(through.error), own) if lines else own.better(through)
    chosen = best.where(kept[:, None], lattice)
    # leading = combination @ lattice and own = vectors @ lattice: leading = combination vectors^-1 @ own.
    inverse = np.zeros_like(vectors)
    inverse[basis] = np.rint(np.linalg.inv(vectors[basis].astype(float))).astype(np.int64)
    return chosen, np.where(basis[:, None, None], found.combination @ inverse, found.combination)
