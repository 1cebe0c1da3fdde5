"""Orbits computed by other programs: arrays, named arrays and files of them, as (2n, orbits, samples)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike

from ..core.foreign import dispatch_adapter, without_unit
from ..core.numbers import an_array, entries, fits, listed, numbers, positive, refuse_unit, shown
from ..core.status import Status
from ..engine.threads import by_portions
from ..results.result import Result
from .row_order import wrong_order
from .starts import COORDINATES, ORBITS

SAMPLES = ("sample", "samples", "time", "times", "t", "turn", "turns", "at_turn", "step", "steps")
"""Names of the dimension of samples of a labelled array."""

MOST = 12
"""Degrees of freedom that are taken: more rows than twice that are most likely orbits."""

EVEN = 1e-6
"""Part of the interval by which times may miss being equidistant."""

LADDER = 8
"""Number of lengths in a factor of 2 to which ending orbits are cut: those of one length are done together."""

SAMPLED: WeakValueDictionary[int, np.ndarray] = WeakValueDictionary()
"""The `samples` (samples, 2n, orbits) of results of `integrate`, by identity: their axes are known."""

Given = ArrayLike | Mapping[Any, ArrayLike] | Result
"""Orbits of any program, by rows or by name; objects of most tools have no types."""


class GivenOrbits(NamedTuple):
    """Orbits (2n, orbits, samples) that are read some at a time.

    parts: their sources, either one with three axes or one for each row with those of orbits and samples;
    order: for each source, the places of (coordinate,) orbit and sample among its axes, orbit -1 where there is one
    orbit without an axis; interval: between samples, None if unknown; start: time of the first sample; names (2n,): of
    the rows.
    """

    parts: tuple[Any, ...]
    order: tuple[tuple[int, ...], ...]
    shape: tuple[int, int, int]
    interval: float | None
    start: float
    names: tuple[str, ...]

    @property
    def angles(self) -> tuple[str, ...]:
        """Names of the coordinates, one for each angle."""
        return self.names[: len(self.names) // 2]

    def read(self, begin: int, end: int) -> np.ndarray:
        """Return the orbits from begin to end as floats (2n, orbits, samples), a view if they are floats."""
        rows = [self._rows(part, order, begin, end) for part, order in zip(self.parts, self.order, strict=True)]
        return rows[0] if len(self.order[0]) == 3 else np.stack(rows)

    def _rows(self, part: Any, order: tuple[int, ...], begin: int, end: int) -> np.ndarray:
        lone = order[-2] < 0
        index = tuple(slice(begin, end) if axis == order[-2] else slice(None) for axis in range(len(order) - lone))
        array = numbers("samples", _plain(part[index]))
        if lone:
            return np.expand_dims(array if len(order) == 2 or order[0] == 0 else array.T, -2)
        return array.transpose(order)


def given_orbits(
    value: Any,
    *,
    dt: Any = None,
    times: Any = None,
    coordinates: Any = None,
    least: int = 1,
    ordered: bool = False,
) -> GivenOrbits:
    """Return the orbits of an argument `samples`; files are not read yet.

    Parameters: value: an array (2n, orbits, samples) or (2n, samples); a result with `samples` and `times`; a
    SectionMap, whose rows `coordinates` names, each point a sample; an object of another tool that `core.foreign`
    knows; the path of a table of MAD's tracking; an array of PyAT (6, particles, 1, turns); a labelled array with
    `dims`, whose names tell the axes apart; anything with a shape and slices, such as a data set of a file; a mapping,
    group or Dataset, in which `coordinates` names the 2n arrays (orbits, samples) or (samples,). dt or times
    (samples,), or neither; coordinates (2n,): names of the rows; least: number of samples; ordered: whether the order
    of the names is known to be right. Raises ValueError or TypeError that name the wrong argument.
    """
    names = None if coordinates is None else row_names(coordinates)
    if isinstance(value, str):
        raise TypeError(
            f"samples must be arrays or a result, got a text. For a file of MAD use pathlib.Path({shown(value)})."
        )
    if hasattr(value, "degrees_of_freedom"):
        run = "fa.integrate(model, z0, time=..., samples=4096)"
        raise TypeError(f"samples must be of orbits, {type(value).__name__} is a system: give {run}")
    if hasattr(value, "column_names"):
        raise TypeError("samples is a table of Arrow: give samples.to_pandas() or polars.from_arrow(samples)")
    by_name = _named(value) or not isinstance(value, (np.ndarray, list, tuple))
    alone = not hasattr(value, "points")
    foreign = dispatch_adapter("orbits", value, "samples", names)
    if foreign is not None:
        value = foreign.rows
        names = foreign.names if names is None else names
        times = foreign.times if dt is None and times is None else times
    value = _known_order(value)
    dt = without_unit(dt)
    times = without_unit(times)
    parts: tuple[Any, ...]
    order: tuple[tuple[int, ...], ...]
    if times is None and hasattr(value, "samples") and hasattr(value, "times") and hasattr(value, "names"):
        found = value.times
        own = tuple(value.names)
        ordered = ordered or names == own
        value = value.samples
        if value.shape[0] == 0:
            raise ValueError("samples must have samples: integrate(..., samples=1000)")
        names = names or own
        times = None if dt is not None else found
        parts = (value,)
        order = ((1, 2, 0),)
    elif hasattr(value, "points") and hasattr(value, "counts") and hasattr(value, "names"):
        if names is None:
            raise ValueError(
                "coordinates must be given for points of a section, the two coordinates of its plane, such as "
                f"('{value.names[1]}', '{value.names[len(value.names) // 2 + 1 if len(value.names) > 2 else -1]}')"
            )
        parts = tuple(value[entry] for entry in names)
        order = ((1, 0),) * len(names)
    elif _named(value):
        if names is None:
            raise ValueError(
                "coordinates must name the arrays of samples in the order q1, ..., qn, p1, ..., pn, of the names "
                f"{shown(list(value))}"
            )
        missing = [entry for entry in names if entry not in value]
        if missing:
            raise ValueError(
                f"coordinates must be names in samples, which has {shown(list(value))}, got {shown(missing[0])}"
            )
        parts = tuple(_source(value[entry]) for entry in names)
        order = tuple(_order(part, 2) for part in parts)
    else:
        part = _source(value)
        order = (_order(part, 3),)
        parts = (_rows_of(part, order[0][0], names),)
    shape = _shape(parts, order)
    if dt is None and times is None:
        times = _coordinate(parts[0], order[0])
    _check_shape(shape, parts[0], least)
    if names is None:
        n = shape[0] // 2
        names = (*(f"q{i + 1}" for i in range(n)), *(f"p{i + 1}" for i in range(n)))
    if len(names) != shape[0]:
        raise ValueError(f"coordinates must be {shape[0]} names, one for each row of samples, got {len(names)}")
    wrong = None if coordinates is None or ordered else wrong_order(names, by_name=by_name, alone=alone)
    if wrong is not None:
        raise wrong
    start, interval = _interval(dt, times, shape[2])
    return GivenOrbits(parts=parts, order=order, shape=shape, interval=interval, start=start, names=names)


def ends(z: np.ndarray, first: int = 0, threads: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of samples (orbits,) of orbits z (2n, orbits, samples) before they end, and their statuses:
    NONFINITE with NaN or an infinity in some row from there to the last sample, LOST where they `stay` at one point.

    first: number of the first orbit, for messages. Raises ValueError where an orbit goes on after a gap.
    """
    samples = z.shape[2]
    counts = np.full(z.shape[1], samples, np.int64)
    status = np.full(z.shape[1], int(Status.OK))
    for orbit in np.flatnonzero((z[:, :, -1] == z[:, :, -2]).all(axis=0)) if samples > 1 else ():
        moves = 1 + np.flatnonzero((z[:, orbit, 1:] != z[:, orbit, :-1]).any(axis=0))
        runs = np.diff(moves, prepend=0, append=samples) - 1
        if stays(runs[-1], runs[:-1].max(initial=0), samples):
            counts[orbit] = samples - 1 - runs[-1]
            status[orbit] = Status.LOST
    sound = np.empty(z.shape[1], bool)

    def look(at: slice) -> None:
        with np.errstate(invalid="ignore", over="ignore"):
            sums = [row[at].sum(axis=1) for row in z]  # at once NumPy would add few rows that lie side by side
            sound[at] = np.isfinite(sums).all(axis=0)

    by_portions(look, z.shape[1], z.shape[0] * samples, threads)
    for orbit in np.flatnonzero(~sound):  # or their sum is too large
        finite = np.isfinite(z[:, orbit]).all(axis=0)
        if finite.all():
            continue
        counts[orbit] = int(np.argmin(finite))
        status[orbit] = Status.NONFINITE
        again = np.flatnonzero(finite[counts[orbit] :])
        if again.size:
            raise gap(first + int(orbit), int(counts[orbit]), int(counts[orbit] + again[0]))
    return counts, status


def stays(still: Any, longest: Any, samples: int) -> Any:
    """Tell whether orbits have ended and stay at one point, as 0 where a tracker has lost a particle: by the number of
    last samples that equal the one before, and the longest such row earlier. Orbits at rest all along have not ended.
    """
    return (still > longest) & (still < samples - 1)


def lengths(counts: np.ndarray, samples: int, least: int, most: int | None = None) -> Iterator[tuple[int, np.ndarray]]:
    """Yield numbers of steps to which orbits of `counts` samples are cut, and these orbits, at most `most` at once;
    orbits with less than `least` samples are left out.
    """
    steps = np.where(counts == samples, samples - 1, 0)
    short = np.flatnonzero((counts < samples) & (counts >= least))
    rung = np.floor(np.log2(counts[short] - 1) * LADDER) / LADDER
    steps[short] = np.clip(np.floor(2.0**rung), least - 1, counts[short] - 1)
    for length in np.unique(steps[steps > 0]):
        own = np.flatnonzero(steps == length)
        size = most or counts.size
        yield from ((int(length), own[at : at + size]) for at in range(0, own.size, size))


def gap(orbit: int, lost: int, again: int) -> ValueError:
    """Return the error of an orbit that has no finite numbers at one sample, and has them again at a later one."""
    return ValueError(
        f"samples must have no gaps: orbit {orbit} is not finite at sample {lost} and goes on at sample {again}; an "
        "orbit that ended is NaN from there to its last sample"
    )


def row_names(coordinates: Any) -> tuple[str, ...]:
    """Return the names of the 2n rows; ValueError or TypeError for other values."""
    listed = coordinates.replace(",", " ").split() if isinstance(coordinates, str) else coordinates
    names = entries("coordinates", listed, "names of the rows q1, ..., qn, p1, ..., pn")
    if not all(isinstance(entry, str) for entry in names) or len(set(names)) != len(names):
        raise TypeError(f"coordinates must be different names, got {shown(coordinates)}")
    if not names or len(names) % 2:
        raise ValueError(f"coordinates must be 2n names, q1, ..., qn, p1, ..., pn, got {len(names)}")
    return tuple(names)


def _known_order(value: Any) -> Any:
    """Return an array whose order of axes is known, though it is another, as (2n, orbits, samples); else the value."""
    pair = value.tolist() if isinstance(value, np.ndarray) and value.dtype == object else value
    pair = pair[0] if isinstance(pair, list) and pair and isinstance(pair[0], (list, tuple)) else pair
    if isinstance(pair, (list, tuple)) and [getattr(entry, "ndim", 0) for entry in pair[:3]] == [1, 2]:
        call = "samples=np.stack([rows.T for _, rows in orbits], axis=1), times=orbits[0][0]"
        raise TypeError(
            "samples must be rows (2n, samples), got times and rows (samples, 2n). Use rows.T, times=times; for "
            f"several orbits {call}."
        )
    if not isinstance(value, np.ndarray):
        return [without_unit(entry) for entry in value] if isinstance(value, (list, tuple)) else value
    if value.ndim == 3 and SAMPLED.get(id(value)) is value:
        return value.transpose(1, 2, 0)
    if value.ndim == 4 and value.shape[0] == 6 and value.shape[2] == 1:  # PyAT's x, px, y, py, delta, ct
        return value[[0, 2, 1, 3], :, 0]
    return value


def _named(value: Any) -> bool:
    """Tell whether a value has arrays by name: a mapping, a group of a file, a Dataset."""
    return isinstance(value, Mapping) or (
        not hasattr(value, "shape") and hasattr(value, "keys") and hasattr(value, "__getitem__")
    )


def _source(value: Any) -> Any:
    """Return a source with a shape and slices: unchanged if it is read later, else an array."""
    value = without_unit(value)
    lazy = not isinstance(value, np.ndarray) and all(hasattr(value, part) for part in ("shape", "dtype", "__getitem__"))
    if lazy:
        if getattr(value.dtype, "kind", "") not in "iuf":
            numbers("samples", np.zeros(0, value.dtype))
        refuse_unit("samples", value)
        return value
    return numbers("samples", _plain(value))


def _plain(value: Any) -> np.ndarray:
    array = an_array("samples", value)
    if array.dtype.kind == "c":
        raise TypeError(
            "samples must be real rows q1, ..., qn, p1, ..., pn, got complex numbers. For signals q - i p use "
            "np.concatenate([s.real, -s.imag])."
        )
    if array.dtype.kind == "O":
        raise TypeError(
            f"samples must be an array of real numbers, got objects of shape {array.shape}. Use "
            "np.array(samples.tolist(), dtype=float), rows of one length."
        )
    return array


def _order(part: Any, axes: int) -> tuple[int, ...]:
    """Return the places of (coordinate,) orbit and sample among the axes of a source; -1 for an orbit without one."""
    dims = getattr(part, "dims", None)
    ndim = len(part.shape)
    if ndim not in (axes, axes - 1):
        takes = "(2n, orbits, samples) or (2n, samples)" if axes == 3 else "(orbits, samples) or (samples,)"
        raise ValueError(f"samples must have shape {takes}, got {tuple(part.shape)}")
    lone = ndim == axes - 1
    plain = (*range(axes - 2), -1, axes - 2) if lone else tuple(range(axes))
    if not isinstance(dims, tuple) or not all(isinstance(entry, str) for entry in dims):
        return plain
    kinds = [COORDINATES] * (axes == 3) + [ORBITS] * (not lone) + [SAMPLES]
    places = [next((k for k, entry in enumerate(dims) if entry.lower() in kind), -1) for kind in kinds]
    unknown = [k for k in range(ndim) if k not in places]
    if places.count(-1) == 1 and len(unknown) == 1:
        places[places.index(-1)] = unknown[0]
    if -1 in places:
        raise ValueError(
            f"samples must have dimensions named like {listed(kind[0] for kind in kinds)}, got {dims}: rename them"
        )
    return (*places[:-1], -1, places[-1]) if lone else tuple(places)


def _shape(parts: tuple[Any, ...], order: tuple[tuple[int, ...], ...]) -> tuple[int, int, int]:
    shapes = [
        tuple(1 if axis < 0 else int(part.shape[axis]) for axis in axes)
        for part, axes in zip(parts, order, strict=True)
    ]
    if len(order[0]) == 3:
        return shapes[0]  # type: ignore[return-value]
    if any(shape != shapes[0] for shape in shapes):
        raise ValueError(f"samples must have arrays of one shape, got {' and '.join(map(str, sorted(set(shapes))))}")
    return len(parts), *shapes[0]  # type: ignore[return-value]


def _check_shape(shape: tuple[int, int, int], part: Any, least: int) -> None:
    """Raise ValueError for a shape that can't be (2n, orbits, samples), with the order of axes that could."""
    rows, _, samples = shape
    said = tuple(map(int, part.shape))
    few = samples < least
    if not few and rows % 2 == 0 and 0 < rows <= 2 * MOST:
        return
    hint = ""
    if len(said) == 3:
        small = [k for k, size in enumerate(said) if 0 < size <= 2 * MOST and size % 2 == 0]
        for c in sorted(small, key=lambda k: said[k]):
            first, last = sorted((k for k in range(3) if k != c), key=lambda k: (said[k], k))
            if (c, first, last) != (0, 1, 2) and said[last] >= least:
                hint = f". Try samples.transpose({c}, {first}, {last})."
                break
    elif len(said) == 2 and said[0] >= least and said[1] % 2 == 0 and 0 < said[1] <= 2 * MOST:
        hint = ". Try samples.T."
    if rows == 1 and not few:
        hint = ". Use fa.naff for positions alone."
    if few:
        raise ValueError(f"samples must have at least {least} samples, got shape {said}{hint}")
    raise ValueError(
        f"samples must have 2n rows q1, ..., qn, p1, ..., pn on the first axis, n up to {MOST}, got shape {said}{hint}"
    )


def _rows_of(part: Any, axis: int, names: tuple[str, ...] | None) -> Any:
    """Return a labelled array with its rows in the order of `names`, where its labels are names; raises ValueError for
    labels with the rows in another order, or with only some of the names.
    """
    labels = _labels(part, axis)
    if labels is None or labels.dtype.kind not in "UOT" or not hasattr(part, "isel"):
        return part
    known = [str(label) for label in labels]
    if names is None:
        paired = list(zip(known[::2], known[1::2], strict=False))
        if len(known) > 2 and all(p.strip("_") in (f"p{q}", f"p_{q}", f"v{q}", f"v_{q}") for q, p in paired):
            wanted = " ".join([*known[::2], *known[1::2]])
            raise ValueError(
                f"samples must have rows q1, ..., qn, p1, ..., pn, got {listed(known)}. Use "
                f"coordinates={shown(wanted)}."
            )
        return part
    missing = [entry for entry in names if entry not in known]
    if missing and len(missing) < len(names):
        raise ValueError(f"coordinates must be names in samples, which has {shown(known)}, got {shown(missing[0])}")
    return part if missing else part.isel({part.dims[axis]: [known.index(entry) for entry in names]})


def _labels(part: Any, axis: int) -> np.ndarray | None:
    """Return the labels that a labelled array has along an axis; None where it has none."""
    dims = getattr(part, "dims", None)
    coords = getattr(part, "coords", None)
    if not isinstance(dims, tuple) or coords is None or dims[axis] not in coords:
        return None
    return np.asarray(coords[dims[axis]])


def _coordinate(part: Any, order: tuple[int, ...]) -> Any:
    """Return the times that a labelled array has along its samples; None where it has none."""
    labels = _labels(part, order[-1])
    return labels if labels is not None and labels.dtype.kind in "iuf" else None


def _interval(dt: Any, times: Any, samples: int) -> tuple[float, float | None]:
    """Return the first time and the interval between samples, None if it is unknown."""
    if dt is not None and times is not None:
        raise ValueError("dt must not be given beside times")
    if times is None:
        return 0.0, None if dt is None else positive("dt", dt)
    array = numbers("times", times)
    if array.shape != (samples,):
        raise ValueError(f"times must have shape ({samples},), one for each sample, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(
            f"times must be finite, got {array[~np.isfinite(array)][0]} at sample {int(np.argmin(np.isfinite(array)))}"
        )
    if samples < 2:
        return float(array[0]), None
    interval = float((array[-1] - array[0]) / (samples - 1))
    if not interval > 0:
        raise ValueError(f"times must increase, got {array[0]} first and {array[-1]} last")
    fits("times", samples)
    off = np.abs(array - (array[0] + interval * np.arange(samples)))
    steps = np.abs(np.diff(array) - interval)
    if max(off.max(), steps.max()) > EVEN * interval:
        median = float(np.median(np.diff(array)))
        worst = int(np.abs(np.diff(array) - median).argmax())
        raise ValueError(
            f"times must be equidistant, got {array[worst + 1] - array[worst]:.9g} from sample {worst} to "
            f"{worst + 1}, most often {median:.9g}"
        )
    return float(array[0]), interval
