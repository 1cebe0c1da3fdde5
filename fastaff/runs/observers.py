"""Observers: functions that keep numbers of running orbits, as values that the drivers call block by block.

An observer is a compiled function with its parameters, rows of memory for each orbit (they survive an interruption) and
numbers written for each orbit. `both` makes one observer of two, so that one pass gives, say, a section and
frequencies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from ..engine.blocks import Bound, call_table, model_block, observer_block, reading_block
from ..engine.jit import LANES
from ..engine.kernels import birkhoff, pairs
from ..engine.kernels import crossings as crossing_kernels
from ..engine.kernels import deviations as deviation_kernels
from ..engine.kernels import readings as reading_kernels
from ..engine.kernels import sample_times as time_kernels
from ..engine.kernels import samples as sample_kernels
from ..engine.kernels import time_levels as level_kernels
from ..engine.values import parameters


class NoNumbers(NamedTuple):
    """The value of an observer without parameters."""

    unused: float = 0.0


NO_NUMBERS = NoNumbers()


@dataclass(frozen=True)
class Observer:
    """Define numbers to keep of running orbits.

    Parameters
    ----------
    function : callable
        Python function that Numba compiles, or one that it has compiled. See the notes for its arguments.
    rows : int
        Number of rows of memory that an orbit needs.
    value : NamedTuple, optional
        Parameters of the function: floats, NamedTuples of floats or tuples of them.
    sizes : tuple of int, default ()
        Constants that the function gets before `lanes`, compiled into it.
    calls : tuple of Bound or Observer, default ()
        Functions that the function gets before these.
    along : Observer, optional
        The same observer for successive states of one orbit.
    stretch : int, optional
        Largest number of such states that it sees at once, a power of two.

    Notes
    -----
    The function is called with (value, lanes, orbit, fresh, t, z, memory, out, done) and returns the number of orbits
    that it has ended.

    * lanes: number of lanes of the block, each one orbit. orbit (lanes,): their numbers.
    * fresh: 1 for lanes to observe, else 0. t: times.
    * z, memory: states and numbers of the observer, flat: row r of lane i is [r*LANES + i], with LANES of
      ``fastaff.engine.jit``. Rows of z are coordinates, then momenta.
    * out (orbits, columns): records, by orbit. done: set to 1 to end an orbit.

    Memory is 0 at the start unless the caller sets it.

    Examples
    --------
    >>> from fastaff.runs.observers import Observer, samples
    >>> isinstance(samples(4), Observer)
    True
    """

    function: Callable
    rows: int
    value: Any = NO_NUMBERS
    sizes: tuple[int, ...] = ()
    calls: tuple[Bound | Observer, ...] = ()
    along: Observer | None = None
    stretch: int = LANES

    @cached_property
    def bound(self) -> Bound:
        """The compiled function with its parameters and calls."""
        block = observer_block(self.value, self.function, self.sizes, bool(self.calls))
        calls = tuple(call.bound if isinstance(call, Observer) else call for call in self.calls)
        return Bound(block, *call_table(parameters(self.value), calls))


def bound(kind: str, value: Any, degrees_of_freedom: int, vectors: int) -> Bound:
    """Return the block function of a model or section with its parameters."""
    return Bound(model_block(kind, value, degrees_of_freedom, vectors), *call_table(parameters(value), ()))


class _Rows(NamedTuple):
    rows: float


@cache
def nothing() -> Observer:
    """Keep nothing but the end state."""
    return Observer(sample_kernels.nothing, 1)


@cache
def samples(rows: int) -> Observer:
    """Keep the phase point (rows numbers) at each observation."""
    return Observer(sample_kernels.states, sample_kernels.ROWS.taken + 1, _Rows(float(rows)))


@cache
def at_times(rows: int) -> Observer:
    """Keep the first phase point (rows numbers) at or after given times, see `engine.kernels.sample_times`."""
    kept = time_kernels.ROWS.end
    value = _Rows(float(rows))
    along = Observer(time_kernels.pass_times_along, kept, value)
    return Observer(time_kernels.pass_times, kept, value, along=along)


class _Columns(NamedTuple):
    rows: float
    samples: float


@cache
def columns(rows: int, samples: int) -> Observer:
    """Keep the phase point (rows numbers) at each observation, orbits side by side, see
    `engine.kernels.samples.columns`. The caller sets the number of earlier samples.
    """
    return Observer(sample_kernels.columns, sample_kernels.ROWS.taken + 1, _Columns(float(rows), float(samples)))


def called_rows(call: Bound, rows: int) -> Observer:
    """Keep the rows that a call gives of the phase point at each observation, see
    `engine.kernels.samples.CHUNK_ROWS`.
    """
    memory = sample_kernels.CHUNK_ROWS.kept + sample_kernels.CHUNK * sample_kernels.places(rows) + rows
    return Observer(sample_kernels.called_rows, memory, _Rows(float(rows)), calls=(call,))


@cache
def damped_samples(rows: int, stretch: int) -> Observer:
    """Slow orbits of `rows` rows, each every n-th step, a multiple of `stretch`, see
    `engine.kernels.samples.DAMPING_ROWS`, and keep nothing.
    """
    kept = sample_kernels.DAMPING_ROWS.end
    value = _Rows(float(rows))
    along = Observer(sample_kernels.worn_along, kept, value, stretch=stretch)
    return Observer(sample_kernels.damped_samples, kept, value, along=along)


@cache
def worn_samples(rows: int) -> Observer:
    """Slow orbits and keep the phase point at every n-th observation, see `engine.kernels.samples.DAMPING_ROWS`."""
    return Observer(sample_kernels.worn_states, sample_kernels.DAMPING_ROWS.sampled, _Rows(float(rows)))


class _CrossingValue(NamedTuple):
    wanted: float
    direction: float
    rows: float
    most: float
    beside: float


def crossings(
    section: Any, wanted: int, degrees_of_freedom: int, vectors: int = 0, *, beside: bool = False
) -> Observer:
    """Record the brackets of section crossings until `wanted` certain ones are found or the record is full; if the
    records hold times of another run `beside`, also until the two have diverged.
    """
    rows = 2 * degrees_of_freedom * (1 + vectors)
    most = getattr(section, "period", math.inf) / 2
    value = _CrossingValue(float(wanted), float(section.direction), float(rows), most, float(beside))
    kept = crossing_kernels.ROWS.state + rows
    calls = (bound("value", section, degrees_of_freedom, vectors),)
    along = Observer(crossing_kernels.detect_along, kept, value, calls=calls)
    return Observer(crossing_kernels.detect, kept, value, calls=calls, along=along)


class _Levels(NamedTuple):
    levels: float
    row: float
    rows: float


def levels(row: int, count: int, rows: int) -> Observer:
    """Record the passages of row `row` of a state (rows numbers) through `count` increasing levels, which the caller
    writes as the times of the records.
    """
    value = _Levels(float(count), float(row), float(rows))
    return Observer(level_kernels.pass_levels, level_kernels.ROWS.state + rows, value)


class _Beyond(NamedTuple):
    row: float
    limit: float


def beyond(row: int, limit: float) -> Observer:
    """End orbits whose row `row` of the state has reached `limit`."""
    return Observer(level_kernels.stop_beyond, 0, _Beyond(float(row), limit))


class _Deviations(NamedTuple):
    time: float
    early_stop: float
    slots: float
    forced: float
    readings: float
    sums: float
    longest: float


def deviations(
    model: Any,
    vectors: int,
    indicators: tuple[Any, ...],
    *,
    time: float,
    early_stop: bool,
    slots: int,
    forced: int,
    sums: int,
    longest: float,
) -> Observer:
    """Keep growth and alignment of the tangent vectors at each look, and judge orbits by the indicators' readings.

    Vectors are made orthonormal at the first `forced` records too, and before their time where the square of the first
    has grown more than `longest`.

    out holds `slots` records of the time, the readings and the growth of the first `sums` vectors. The caller sets some
    rows of the memory, see `engine.kernels.deviations`.
    """
    n = model.degrees_of_freedom
    m = len(indicators)
    calls = []
    for entry in indicators:
        own = np.array(entry.parameters, dtype=np.float64)
        block = reading_block(entry.reading, len(own), reading_kernels.growth_of)
        calls.append(Bound(block, *call_table(own, ())))
    function = deviation_kernels.deviations
    if any(entry.across_flow for entry in indicators):
        calls.append(bound("along", model, n, vectors))
        function = deviation_kernels.deviations_across
    value = _Deviations(time, float(early_stop), float(slots), float(forced), float(m), float(sums), longest)
    rows = deviation_kernels.layout(n, vectors, m).end
    return Observer(function, rows, value, (n, vectors), tuple(calls))


class _Average(NamedTuple):
    time: float


def averages(model: Any, vectors: int, time: float) -> Observer:
    """Keep weighted sums of the square of the kinetic energy over both halves of `time`."""
    kinetic = bound("kinetic", model, model.degrees_of_freedom, vectors)
    return Observer(birkhoff.average, birkhoff.ROWS.end, _Average(time), calls=(kinetic,))


def kinetic_samples(model: Any, vectors: int) -> Observer:
    """Keep the kinetic energy at every n-th observation of an orbit; the caller sets n, see
    `engine.kernels.samples.ROWS`.
    """
    kinetic = bound("kinetic", model, model.degrees_of_freedom, vectors)
    return Observer(sample_kernels.thinned, sample_kernels.ROWS.end, calls=(kinetic,))


class _Pair(NamedTuple):
    split: float
    rows: float
    columns: float


def both(first: Observer, second: Observer, columns: int) -> Observer:
    """Make one observer of two: a single pass over the orbits serves both.

    Memory and `out` hold those of the first, then those of the second; `columns` is the width of the first one's `out`.
    An orbit is done when both are done with it; the rows after their memory hold their `done`.
    """
    rows = first.rows + second.rows
    value = _Pair(float(first.rows), float(rows), float(columns))
    return Observer(pairs.both, rows + pairs.ROWS.end, value, calls=(first, second))


def chain(parts: list[tuple[Observer, int]]) -> tuple[Observer, list[tuple[int, int]], int]:
    """Make one observer of any number, given with the widths of their `out`.

    Return it with the first row of memory and the first column that each has, and the width of all columns.
    """
    (whole, columns), *others = parts or [(nothing(), 0)]
    firsts = [(0, 0)]
    for part, width in others:
        firsts.append((whole.rows, columns))
        whole = both(whole, part, columns)
        columns = columns + width
    return whole, firsts, columns


class _Either(NamedTuple):
    split: float


def either(first: Observer, second: Observer) -> Observer:
    """Make one observer of two; the second writes nothing. An orbit is done when one of them is done with
    it.
    """
    value = _Either(float(first.rows))
    rows = first.rows + second.rows
    along = None
    if first.along is not None and second.along is not None:
        along = replace(either(first.along, second.along), stretch=min(first.along.stretch, second.along.stretch))
    return Observer(pairs.either, rows, value, calls=(first, second), along=along)
