"""Crossings of a section by orbits that were measured, or computed by other programs: by interpolation of samples.

A polynomial through eight samples around a crossing gives its time and point. The error has two parts: that of
polynomials, from divided differences of neighbouring windows, and the noise of the samples, from differences so high
that a resolved signal has none. A crossing whose error allows another number of crossings is undecided.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize.elementwise import find_root

from ..core.foreign import without_unit
from ..core.names import named
from ..core.numbers import fits, listed, numbers, positive, shown, whole
from ..core.status import Status
from ..results.progress import says_progress
from ..runs.given_orbits import SAMPLED, Given, ends
from ..runs.requirements import lacking
from ..systems.formulas.number import number
from ..systems.formulas.section_text import parted
from ..systems.models.contracts import Section
from ..systems.models.sections import Hyperplane
from .section_map import SectionMap

NODES = 8
"""Samples of a polynomial: four on either side of a crossing."""

NOISE_NODES = 12
"""Samples of the differences that show noise. With four samples a period they are as small as the error of NODES."""

LEAST = 16
"""Least number of samples of an orbit."""

# tests/sections/test_map_samples.py measures the coverage of errors with these constants.

SAFETY = 3.0
"""Factor of the difference of polynomials of NODES and NODES + 1 samples, the largest in five neighbouring windows."""

DEVIATIONS = 3.5
"""Standard deviations of noise that an error covers."""

ROUNDING = 8 * float(np.finfo(float).eps)
"""Rounding error of an interpolated coordinate, relative to its largest value."""

STEEP = 4.0
"""Rate of an interpolation error over the error and the sampling rate: it changes sign at each sample."""

FINE = 1 / 64
"""Part of the interval between samples over which rates of the section function are taken."""

PIECES = 8
"""Pieces into which an interval around an extremum of the section function is divided, again and again."""

ROUNDS = 12
"""Number of such divisions: each leaves a quarter of the interval."""


class _Weights(NamedTuple):
    """Weights (windows, nodes) of the samples in divided differences, up to a factor, and the root mean squares
    (windows,) of differences of independent errors of unit variance; and the factor (windows,).
    """

    weights: np.ndarray
    size: np.ndarray
    factor: np.ndarray

    @classmethod
    def of(cls, t: np.ndarray, nodes: int) -> _Weights:
        """Return the weights for samples at times t."""
        at = np.lib.stride_tricks.sliding_window_view(t, nodes)
        unit = (at[:, -1:] - at[:, :1]) / (nodes - 1)  # else products of many intervals overflow
        apart = np.ones(at.shape)
        for i in range(nodes):
            distance = (at - at[:, i : i + 1]) / unit
            distance[:, i] = 1.0
            apart *= distance
        return cls(1 / apart, np.sqrt((apart**-2.0).sum(axis=1)), unit[:, 0] ** (1 - nodes))

    def differences(self, z: np.ndarray) -> np.ndarray:
        """Return the divided differences (rows, windows) of z (rows, samples), up to the factor."""
        windows = np.lib.stride_tricks.sliding_window_view(z, self.weights.shape[1], axis=1)
        return np.einsum("rwj,wj->rw", windows, self.weights)


class SamplePolynomials(NamedTuple):
    """SamplePolynomials through NODES samples of one orbit z (rows, samples) at t (samples,), for a section; the errors
    (rows, windows) that the differences of each window and its neighbours show, and the noise (rows,) of the samples.
    """

    section: Any
    t: np.ndarray
    z: np.ndarray
    difference: np.ndarray
    noise: np.ndarray

    @classmethod
    def of(cls, section: Any, t: np.ndarray, z: np.ndarray, weights: tuple[_Weights, _Weights]) -> SamplePolynomials:
        """Return the polynomials of an orbit; weights of differences of NODES + 1 and of NOISE_NODES samples."""
        low, high = weights
        wide = np.pad(np.abs(low.differences(z)) * low.factor, ((0, 0), (2, 3)), mode="edge")
        largest = np.lib.stride_tricks.sliding_window_view(wide, 5, axis=1).max(axis=-1)
        deviation = np.median(np.abs(high.differences(z)) / high.size, axis=1) / 0.6745
        return cls(section, t, z, largest, deviation + ROUNDING * np.abs(z).max(axis=1))

    def first(self, interval: np.ndarray) -> np.ndarray:
        """Return the first samples of the windows around intervals."""
        return np.clip(interval - (NODES // 2 - 1), 0, len(self.t) - NODES)

    def weights(self, time: np.ndarray, interval: np.ndarray) -> np.ndarray:
        """Return Lagrange's weights (NODES, moments) of the samples around intervals."""
        nodes = self.t[self.first(interval) + np.arange(NODES)[:, None]]
        found = np.ones(nodes.shape)
        for j in range(NODES):
            for i in range(NODES):
                if i != j:
                    found[j] *= (time - nodes[i]) / (nodes[j] - nodes[i])
        return found

    def state(self, time: np.ndarray, interval: np.ndarray) -> np.ndarray:
        """Return the states (rows, moments)."""
        samples = self.z[:, self.first(interval) + np.arange(NODES)[:, None]]
        return np.einsum("rjm,jm->rm", samples, self.weights(time, interval))

    def value(self, time: np.ndarray, interval: np.ndarray) -> np.ndarray:
        """Return the section function (moments,)."""
        shape = np.broadcast_shapes(np.shape(time), np.shape(interval))
        time, interval = (np.broadcast_to(entry, shape).ravel() for entry in (time, interval))
        return section_values(self.section, self.state(time, interval)).reshape(shape)

    def errors(self, time: np.ndarray, interval: np.ndarray) -> np.ndarray:
        """Return the errors of states (rows, moments)."""
        first = self.first(interval)
        product = np.abs(time - self.t[first + np.arange(NODES)[:, None]]).prod(axis=0)
        noise = DEVIATIONS * np.sqrt((self.weights(time, interval) ** 2).sum(axis=0))
        return SAFETY * self.difference[:, first] * product + np.maximum(noise, 1.0) * self.noise[:, None]

    def value_errors(self, time: np.ndarray, interval: np.ndarray) -> np.ndarray:
        """Return the errors of the section function (moments,)."""
        z = self.state(time, interval)
        here = section_values(self.section, z)
        total = np.zeros(len(time))
        for row, error in enumerate(self.errors(time, interval)):
            moved = z.copy()
            moved[row] += error
            total += np.abs(section_values(self.section, moved) - here)
        return total


def section_values(section: Any, z: np.ndarray) -> np.ndarray:
    """Return the section function of states (rows, ...)."""
    with np.errstate(all="ignore"):
        return np.asarray(section.value(*z), dtype=np.float64) + np.zeros(z.shape[1:])


class _Brackets(NamedTuple):
    """Brackets of crossings: times of their ends and numbers of the intervals between samples; and whether the orbit
    may have more crossings.
    """

    left: np.ndarray
    right: np.ndarray
    interval: np.ndarray
    doubtful: bool


def _brackets(own: SamplePolynomials) -> _Brackets:
    """Return the brackets of an orbit: sign changes between samples, and extrema between these beyond the section."""
    t = own.t
    g = section_values(own.section, own.z)
    period = getattr(own.section, "period", np.inf)
    above = g >= 0
    start = np.zeros(1, np.int64)
    if abs(g[0]) <= own.value_errors(t[:1], start)[0]:
        above[0] = above[1]  # an orbit that starts on the section does not cross it there
    jumps = np.abs(np.diff(g)) > period / 2
    changed = (above[1:] != above[:-1]) & ~jumps
    size = np.pad(np.abs(g), 1, constant_values=np.inf)
    least = (size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:])
    near = np.flatnonzero((least[:-1] | least[1:]) & ~changed & ~jumps)
    sign = np.where(above[near], 1.0, -1.0)
    low, high = t[near], t[near + 1]
    share = np.linspace(0.0, 1.0, PIECES + 1)[:, None]
    lowest = low
    for _ in range(ROUNDS if near.size else 0):
        moments = low + share * (high - low)
        at = (sign * own.value(moments, near)).argmin(axis=0)
        each = np.arange(near.size)
        lowest = moments[at, each]
        low, high = moments[np.maximum(at - 1, 0), each], moments[np.minimum(at + 1, PIECES), each]
    value = sign * own.value(lowest, near)
    inside = (lowest > t[0]) & (lowest < t[-1])
    doubtful = bool((inside & (np.abs(value) <= own.value_errors(lowest, near))).any())
    beyond = inside & (value < 0)
    changes = np.flatnonzero(changed)
    near, lowest = near[beyond], lowest[beyond]
    left = np.concatenate([t[changes], t[near], lowest])
    right = np.concatenate([t[changes + 1], lowest, t[near + 1]])
    interval = np.concatenate([changes, near, near])
    order = np.lexsort((left, interval))
    return _Brackets(left[order], right[order], interval[order], doubtful)


class _Crossed(NamedTuple):
    """Crossings of one orbit: times and their errors (crossings,), points and theirs (rows, crossings), and whether
    all are decided.
    """

    times: np.ndarray
    time_error: np.ndarray
    points: np.ndarray
    point_error: np.ndarray
    decided: bool


def _crossed(own: SamplePolynomials, direction: int) -> _Crossed:
    """Return the crossings of an orbit in a direction."""
    left, right, interval, doubtful = _brackets(own)
    if interval.size:
        rising = own.value(right, interval) > own.value(left, interval)
        wanted = (direction == 0) | (rising == (direction > 0))
        left, right, interval = left[wanted], right[wanted], interval[wanted]
    time = left
    if interval.size:
        time = find_root(own.value, (left, right), args=(interval,)).x
    apart = FINE * (own.t[interval + 1] - own.t[interval])
    before, here, after = (own.value(time + side * apart, interval) for side in (-1, 0, 1))
    error = own.value_errors(time, interval) + np.abs(here)
    ahead = own.weights(time + apart, interval) - own.weights(time - apart, interval)
    noisy = DEVIATIONS * own.noise[:, None] * np.sqrt((ahead**2).sum(axis=0)) / (2 * apart)
    states = own.state(time, interval)
    rates = np.abs(own.state(time + apart, interval) - own.state(time - apart, interval)) / (2 * apart)
    slope_error = STEEP * error * FINE / apart
    for row, part in enumerate(noisy):
        moved = states.copy()
        moved[row] += part * apart
        slope_error += np.abs(section_values(own.section, moved) - here) / apart
    slope = np.abs(after - before) / (2 * apart) - slope_error
    bend = np.abs(after - 2 * here + before) / apart**2
    with np.errstate(all="ignore"):
        late = 2 * error / (slope + np.sqrt(slope**2 - 2 * bend * error))
        sound = (slope > 0) & (late < apart / FINE)
    late = np.where(sound, late, np.inf)
    points_error = own.errors(time, interval) + np.where(rates > 0, rates, 1.0) * late
    return _Crossed(time, late, states, points_error, bool(sound.all()) and not doubtful)


@says_progress
def map_samples(
    samples: Given,
    dt: float | None = None,
    *,
    section: Section | str,
    times: ArrayLike | None = None,
    coordinates: str | Sequence[str] | None = None,
    direction: int | None = None,
) -> SectionMap:
    """Compute the crossings of a section by orbits that are given as samples in time.

    Parameters
    ----------
    samples : array_like, shape (rows, orbits, samples) or (rows, samples)
        States, one row for each coordinate, with 16 samples or more, NaN after the end of an orbit. Also accepted:
        `Orbits` with samples, and arrays of shape (orbits, samples) or (samples,) by name (a mapping or a table).
    dt : float, optional
        Positive interval between samples, in units of time.
    section : Section or str
        Surface of section, for example ``fa.Hyperplane((1, 0, 0), 27)``, or text: a name of `coordinates` and a number,
        ``"z=27"``.
    times : array_like, shape (samples,), optional
        Increasing times of the samples instead of `dt`, which may be unequal.
    coordinates : str or sequence of str, optional
        Names of the rows.
    direction : {1, -1, 0}, optional
        Crossings that count, as in `poincare_map`. Default: the direction of `section`.

    Returns
    -------
    `SectionMap`
        Points and times of the crossings, with error estimates and the status of each orbit. The scheme is None and the
        step is the median interval between samples.

    Raises
    ------
    ValueError
        If a value is out of its range or shape; the message names the argument.
    TypeError
        If an argument is of a wrong kind.

    Notes
    -----
    - Method: the polynomial through the eight samples around each crossing.
    - Errors cover 99 % of the true errors. They are estimated from differences of the samples and include their white
      noise. They are infinite if the errors allow more or fewer crossings.
    - Status: NOT_CONVERGED if the number of crossings is undecided, as for coarse or noisy samples and for orbits that
      touch the section. Average or thin noisy samples first.
    - Limits: samples with less than four in a period may pass for slower motion. Angles must not jump.

    References
    ----------
    Henon 1982, Physica D 5, 412; Hildebrand 1974, Introduction to Numerical Analysis (divided differences).

    Examples
    --------
    >>> t = np.array([*range(40)]) * 0.2 + 0.01
    >>> cut = fa.sections.map_samples(np.stack([np.sin(t), np.cos(t)]), times=t, coordinates="x p", section="x=0")
    >>> cut.times[:, 0].round(5)
    array([6.28319])
    """
    z, names, known = _samples_of(samples, coordinates)
    t = _times_of(dt, times if times is not None or dt is not None else known, z.shape[2])
    cut = _section_of(section, names)
    if direction is not None:
        sign = whole("direction", direction, -1, 1)
        cut = cut._replace(direction=sign)
    counts, status = ends(z)
    fits("samples", z.shape[2], 4 * NOISE_NODES)
    unit = float(np.median(np.diff(t)))
    u = (t - t[0]) / unit  # powers of times in other units may overflow
    whole_weights = _weights(u)
    found = []
    for orbit, count in enumerate(counts):
        if count < LEAST:
            status[orbit] = Status.NOT_CONVERGED if status[orbit] == Status.OK else status[orbit]
            found.append(_Crossed(*(np.zeros(0),) * 2, *(np.zeros((len(z), 0)),) * 2, True))
            continue
        weights = whole_weights if count == len(t) else _weights(u[:count])
        own = SamplePolynomials.of(cut, u[:count], np.ascontiguousarray(z[:, orbit, :count]), weights)
        found.append(_crossed(own, int(cut.direction)))
        if not found[-1].decided:
            status[orbit] = Status.NOT_CONVERGED
    return _assembled(found, status, cut, (float(t[0]), unit), names)


def _weights(t: np.ndarray) -> tuple[_Weights, _Weights]:
    """Return the weights of the differences that `SamplePolynomials` uses."""
    return _Weights.of(t, NODES + 1), _Weights.of(t, NOISE_NODES)


def _assembled(
    found: list[_Crossed], status: np.ndarray, section: Any, clock: tuple[float, float], names: tuple[str, ...]
) -> SectionMap:
    """Return the crossings of all orbits as one map; clock: time of the first sample, and the unit of their times."""
    start, unit = clock
    crossings = np.array([len(each.times) for each in found])
    most = int(crossings.max(initial=0))
    points, point_error = np.full((2, len(names), most, len(found)), np.nan)
    times, time_error = np.full((2, most, len(found)), np.nan)
    residual = np.zeros(len(found))
    for orbit, each in enumerate(found):
        at = slice(len(each.times)), orbit
        times[at] = start + unit * each.times
        time_error[at] = unit * each.time_error + ROUNDING * np.abs(times[at])
        points[:, *at], point_error[:, *at] = each.points, each.point_error
        residual[orbit] = np.abs(section_values(section, each.points)).max(initial=0.0)
    return SectionMap(
        points=points,
        times=times,
        counts=crossings,
        section_error=residual,
        energy_error=np.zeros(len(found)),
        status=status,
        section=section,
        scheme=None,
        step=unit,
        names=names,
        time_error=time_error,
        point_error=point_error,
    )


def _samples_of(value: Any, coordinates: Any) -> tuple[np.ndarray, tuple[str, ...], Any]:
    """Return samples (rows, orbits, samples), the names of the rows, and the times that are known with them."""
    if isinstance(value, str) or hasattr(value, "degrees_of_freedom"):
        raise TypeError(f"samples must be arrays or a result, got {shown(value)}. Use fa.poincare_map for a system.")
    names = None if coordinates is None else _names_of(coordinates)
    known = None
    if hasattr(value, "samples") and hasattr(value, "times") and hasattr(value, "names"):
        names, known = names or tuple(value.names), value.times
        value = value.samples
        if not len(value):
            raise ValueError("samples must have samples: integrate(..., samples=1000)")
        array = value.transpose(1, 2, 0)
    elif isinstance(value, Mapping) or (hasattr(value, "keys") and hasattr(value, "__getitem__")):
        names = names or tuple(map(str, value.keys()))
        missing = [entry for entry in names if entry not in value]
        if missing:
            raise ValueError(
                f"coordinates must be names in samples, which has {listed(value.keys())}, got {shown(missing[0])}"
            )
        rows = [numbers("samples", without_unit(value[entry])) for entry in names]
        if len({row.shape for row in rows}) > 1:
            raise ValueError(
                f"samples must have arrays of one shape, got {listed(sorted({row.shape for row in rows}))}"
            )
        array = np.stack(rows)
    else:
        array = numbers("samples", without_unit(value))
        array = array.transpose(1, 2, 0) if array.ndim == 3 and SAMPLED.get(id(value)) is value else array
    array = array[:, None] if array.ndim == 2 else array
    if array.ndim != 3 or not array.shape[0] or not array.shape[1]:
        raise ValueError(f"samples must have shape (rows, orbits, samples) or (rows, samples), got {array.shape}")
    if array.shape[2] < LEAST:
        hint = " Try samples.T." if array.shape[1] == 1 and array.shape[0] >= LEAST else ""
        raise ValueError(f"samples must have at least {LEAST} samples, got shape {np.shape(value)}.{hint}")
    if names is None:
        half = array.shape[0] // 2
        paired = [*(f"q{i + 1}" for i in range(half)), *(f"p{i + 1}" for i in range(half))]
        names = tuple(paired if array.shape[0] == 2 * half else (f"x{i + 1}" for i in range(array.shape[0])))
    if len(names) != len(array):
        raise ValueError(f"coordinates must be {len(array)} names, one for each row of samples, got {len(names)}")
    return array, names, known


def _names_of(coordinates: Any) -> tuple[str, ...]:
    """Return different names of rows."""
    given = coordinates.replace(",", " ").split() if isinstance(coordinates, str) else coordinates
    fine = isinstance(given, (list, tuple)) and given and all(isinstance(entry, str) for entry in given)
    if not fine or len(set(given)) != len(given):
        raise TypeError(f"coordinates must be different names, got {shown(coordinates)}")
    return tuple(given)


def _times_of(dt: Any, times: Any, samples: int) -> np.ndarray:
    """Return the times of the samples."""
    if dt is not None and times is not None:
        raise ValueError("dt must not be given beside times")
    if dt is None and times is None:
        raise TypeError("times is required, or dt, the interval between samples")
    if dt is not None:
        return positive("dt", without_unit(dt)) * np.arange(samples)
    array = numbers("times", without_unit(times))
    if array.shape != (samples,):
        raise ValueError(f"times must have shape ({samples},), one for each sample, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"times must be finite, got {array[~np.isfinite(array)][0]}")
    late = np.flatnonzero(np.diff(array) <= 0)
    if late.size:
        raise ValueError(f"times must increase, got {array[late[0] + 1]:.9g} after {array[late[0]]:.9g}")
    return array


def _section_of(section: Any, names: tuple[str, ...]) -> Any:
    """Return a section of rows with these names."""
    if isinstance(section, str):
        body, sign = parted(section)
        name, equals, constant = body.partition("=")
        row = names.index(named("section", name.strip(), names)) if equals else -1
        if row < 0 or not constant.strip():
            raise ValueError(f"section must be a name and a number, such as {names[0]}=0, got {shown(section)}")
        normal = tuple(float(k == row) for k in range(len(names)))
        return Hyperplane(normal, number(f"section {name.strip()}", constant), 1 if sign is None else sign)
    if isinstance(section, type) or lacking(section, Section) or not hasattr(section, "_replace"):
        raise TypeError(f"section must be a section or text such as {names[0]}=0, got {shown(section)}")
    try:
        fine = np.shape(section.value(*np.ones(len(names)))) == ()
        fine &= len(getattr(section, "normal", names)) == len(names)
    except (TypeError, ValueError, IndexError):
        fine = False
    if not fine:
        raise ValueError(f"section must depend on the {len(names)} rows of samples, got {shown(section)}")
    return section
