"""The largest Lyapunov exponent of a measured series: neighbours in delay coordinates and how they part."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ..core.classification import Classification
from ..core.foreign import without_unit
from ..core.numbers import fits, numbers, positive, whole
from ..results.progress import says_progress
from ..results.result import Result, along

LEAST = 500
"""Least number of samples."""

REFERENCES = 4000
"""Most points whose neighbours are followed: more hardly lower the error, which successive points share."""

DIMENSIONS = 3
"""Numbers of delay coordinates that are compared: the given one and the next."""

USUAL = 4
"""Number of delay coordinates if none is given: enough for an attractor of dimension below 2 (Takens 1981), and with
the next ones for one of dimension 2.5.
"""

MOST_PERIODS = 30.0
"""Mean periods for which neighbours are followed at most, and for which the distances of a map need no average."""

GROUPS = 8
"""Stretches of the series whose slopes show the statistical error."""

SATURATED = 1.0
"""Logarithm of the typical distance of points over that of neighbours up to which these still part exponentially."""

SLOW = 0.25
"""Rate of growth over the largest one at which a curve has slowed down: orbits that keep their phases saturate far
below the typical distance of points.
"""

UNSURE = 0.5
"""Logarithmic distance by which a curve may saturate above that place: both levels are fitted."""

SYSTEMATIC = 0.05
"""Error of the law of saturation and of distances that are not yet along the unstable direction, over the exponent."""

GROWTH = 1.2
"""Growth of the logarithmic distance below which there is no exponential divergence to see."""

# tests/chaos/test_series_exponent.py measures the coverage of errors with these constants.

DEVIATIONS = 3.0
"""Factor of the errors that groups, dimensions and parts of the divergence show."""


@dataclass(frozen=True)
class SeriesExponent(Result):
    """Largest Lyapunov exponent of a series, with the divergence of neighbours that shows it.

    Attributes
    ----------
    exponent : float, 1/time
        Largest Lyapunov exponent: the slope of the divergence. NaN if the neighbours do not part exponentially.
    error : float, 1/time
        Error estimate, infinite with NaN.
    classification : Classification
        CHAOTIC if the exponent is positive beyond its error, else UNDECIDED: no finite series shows that an exponent
        is 0.
    time : ndarray, shape (times,), time
        Times after the neighbours were met.
    divergence : ndarray, shape (dimensions, times)
        Mean logarithms of the distances of neighbours, averaged over a mean period, for three numbers of delay
        coordinates.
    fitted : tuple of float, 2 entries, time
        Times between which the slope was fitted.
    dimension : int
        Smallest number of delay coordinates.
    lag : int
        Number of samples between delay coordinates.
    separation : int
        Least number of samples between neighbours.
    """

    exponent: float
    error: float
    classification: Classification
    time: Annotated[np.ndarray, along("moment", unit="time", plain=True)]
    divergence: Annotated[np.ndarray, along("dimension", "moment")]
    fitted: tuple[float, float]
    dimension: int
    lag: int
    separation: int

    def summary(self) -> str:
        """Return one line with the exponent and its error.

        Returns
        -------
        str
            Summary.
        """
        return f"{self.classification.name}: exponent {self.exponent:.3g}, error {self.error:.1g}"


@says_progress
def series_exponent(
    series: ArrayLike,
    dt: float = 1.0,
    *,
    dimension: int = USUAL,
    lag: int | None = None,
    separation: int | None = None,
) -> SeriesExponent:
    """Compute the largest Lyapunov exponent of a measured series.

    Parameters
    ----------
    series : array_like, shape (samples,)
        One coordinate at equidistant times: 500 samples or more, better 5000, over 100 mean periods or more.
    dt : float, default 1
        Positive interval between samples, in units of time; 1 for iterates of a map.
    dimension : int, default 4
        Smallest number of delay coordinates, 1 or more. It should exceed twice the dimension of the attractor.
    lag : int, optional
        Positive number of samples between delay coordinates. Default: where the correlation falls to 1/e.
    separation : int, optional
        Least number of samples between neighbours, 1 or more. Default: a mean period.

    Returns
    -------
    `SeriesExponent`
        Exponent with its error, and the divergence of neighbours.

    Raises
    ------
    ValueError
        If the series is constant, too short or not finite, or if a value is out of its range.
    TypeError
        If an argument is of a wrong kind.

    Notes
    -----
    - Method: the nearest neighbour of each point in delay coordinates. The mean logarithm of their distances grows
      linearly with the exponent as slope, after the transient and before saturation.
    - Error: from stretches of the series, from three numbers of delay coordinates, and from both parts of the fit. It
      covers 99 % of the true errors of Lorenz, Roessler, Henon and logistic series.
    - Noise hides the divergence below its size; the result is then UNDECIDED.
    - Cost: about a second for 20,000 samples.

    References
    ----------
    Rosenstein, Collins & De Luca 1993, Physica D 65, 117; Kantz 1994, Phys. Lett. A 185, 77 (exponential divergence);
    Theiler 1986, Phys. Rev. A 34, 2427 (separation).

    Examples
    --------
    >>> henon = fa.iterated_map("x1 = 1 - a*x**2 + y; y1 = b*x", a=1.4, b=0.3)
    >>> x = fa.integrate(henon, [0.1, 0.1], time=3000, samples=3000).samples[:, 0, 0]
    >>> found = fa.chaos.series_exponent(x[100:])
    >>> bool(abs(found.exponent - 0.419) < found.error), found.classification.name
    (True, 'CHAOTIC')
    """
    x = numbers("series", without_unit(series))
    if x.ndim != 1:
        raise ValueError(f"series must have shape (samples,), got {x.shape}. Give one coordinate.")
    if len(x) < LEAST:
        raise ValueError(f"series must have at least {LEAST} samples, got {len(x)}")
    if not np.isfinite(x).all():
        raise ValueError(f"series must be finite, got {x[~np.isfinite(x)][0]} at sample {np.argmin(np.isfinite(x))}")
    if not np.ptp(x) > 1e-12 * np.abs(x).max():
        raise ValueError(f"series must change, got {x[0]:.9g} everywhere")
    dt = positive("dt", without_unit(dt))
    dimension = whole("dimension", dimension, 1, 20)
    x = (x - x.mean()) / x.std()
    period = _mean_period(x)
    lag = _decay(x) if lag is None else whole("lag", lag, 1)
    separation = math.ceil(period) if separation is None else whole("separation", separation, 1)
    longest = (dimension + DIMENSIONS - 2) * lag
    follow = min(math.ceil(MOST_PERIODS * period), len(x) // 8)
    points = len(x) - longest - follow
    if points < max(LEAST // 2, 4 * separation):
        raise ValueError(
            f"series is too short for dimension={dimension}, lag={lag}, separation={separation}: {points} points left"
        )
    fits("series", REFERENCES, follow)
    window = max(1, round(period / 2)) if period >= 5 else 1
    curves = [_curves(x, d, lag, separation, follow, points) for d in range(dimension, dimension + DIMENSIONS)]
    averaged = np.array([[_averaged(group, window) for group in curve.groups] for curve in curves])
    found = _slope(averaged, np.array([curve.typical for curve in curves]), max(1, window))
    times = dt * (np.arange(averaged.shape[2]) + 0.5 * (window - 1))
    chaotic = found.slope - found.error > 0
    return SeriesExponent(
        exponent=found.slope / dt,
        error=found.error / dt,
        classification=Classification.CHAOTIC if chaotic else Classification.UNDECIDED,
        time=times,
        divergence=averaged.mean(axis=1),
        fitted=(float(times[found.first]), float(times[found.last])),
        dimension=dimension,
        lag=lag,
        separation=separation,
    )


def _mean_period(x: np.ndarray) -> float:
    """Return the inverse of the mean frequency of the spectrum, in samples."""
    power = np.abs(np.fft.rfft(x * np.hanning(len(x)))) ** 2
    power[0] = 0.0
    return float(power.sum() / (power * np.fft.rfftfreq(len(x))).sum())


def _decay(x: np.ndarray) -> int:
    """Return the first number of samples after which the correlation is below 1/e."""
    power = np.abs(np.fft.rfft(x, 2 * len(x))) ** 2
    correlation = np.fft.irfft(power)[: len(x) // 4]
    below = correlation < correlation[0] / math.e
    return max(1, int(np.argmax(below)) if below.any() else len(x) // 4)


class _Curves(NamedTuple):
    """Mean logarithmic distances (groups, times) of neighbours, and that of points that are no neighbours."""

    groups: np.ndarray
    typical: float


def _curves(x: np.ndarray, dimension: int, lag: int, separation: int, follow: int, points: int) -> _Curves:
    """Return how the neighbours of points in so many delay coordinates part."""
    states = np.stack([x[k * lag : k * lag + points + follow] for k in range(dimension)], axis=1)
    references = np.unique(np.linspace(0, points - 1, min(points, REFERENCES)).astype(np.int64))
    partners = _neighbours(states[:points], references, separation)
    known = partners >= 0
    if np.count_nonzero(known) < 4 * GROUPS:  # a series that repeats itself exactly has no neighbours that part
        return _Curves(np.zeros((GROUPS, follow)), 0.0)
    references, partners = references[known], partners[known]
    logs = np.empty((len(references), follow))
    for k in range(follow):
        apart = np.linalg.norm(states[references + k] - states[partners + k], axis=1)
        logs[:, k] = np.log(np.maximum(apart, 1e-300))
    logs = np.where(logs < -600, np.nan, logs)
    with np.errstate(all="ignore"):
        groups = np.array([np.nanmean(part, axis=0) for part in np.array_split(logs, GROUPS)])
    far = np.linalg.norm(states[references] - states[np.roll(references, len(references) // 2)], axis=1)
    return _Curves(groups, float(np.log(far[far > 0]).mean()))


def _neighbours(states: np.ndarray, references: np.ndarray, separation: int) -> np.ndarray:
    """Return the nearest points that are at least so many samples away and not the same, -1 if there is none."""
    tree = cKDTree(states)
    partners = np.full(len(references), -1)
    left = np.arange(len(references))
    most = min(len(states), 2 * separation + 16)
    asked = min(8, most)
    while left.size:
        apart, near = tree.query(states[references[left]], k=asked)
        fine = (np.abs(near - references[left, None]) >= separation) & (apart > 0)
        first = fine.argmax(axis=1)
        met = fine.any(axis=1)
        partners[left[met]] = near[met, first[met]]
        left = left[~met]
        if asked == most:
            break
        asked = min(4 * asked, most)
    return partners


def _averaged(curve: np.ndarray, window: int) -> np.ndarray:
    """Return the moving average over so many samples."""
    return np.convolve(curve, np.full(window, 1 / window), mode="valid")


def _unsaturated(mean: np.ndarray, top: float) -> np.ndarray:
    """Return logarithmic distances with the logistic law of saturation removed: exponential growth is a line in time.

    The rate of growth falls as 1 - exp(mean - top).
    """
    return mean - np.log1p(-np.exp(mean - top))


class _Slope(NamedTuple):
    """The slope of the divergence for each sample, with its error, and the samples between which it was fitted."""

    slope: float
    error: float
    first: int
    last: int


def _slope(curves: np.ndarray, typical: np.ndarray, skip: int) -> _Slope:
    """Return the slope of curves (dimensions, groups, times) after `skip` samples and before saturation at `typical`
    (dimensions,).
    """
    fits = [_fitted(each, top, skip) for each, top in zip(curves, typical, strict=True)]
    first, last = fits[len(fits) // 2][0][:2]
    if any(math.isnan(fit.slope) for pair in fits for fit in pair):
        return _Slope(math.nan, math.inf, first, last)
    every = np.array([[fit[2:] for fit in pair] for pair in fits])  # (dimensions, levels, numbers)
    slopes = every[..., 0].mean(axis=1)
    statistical, bent = every[..., 1].max(), every[..., 2].max()
    levels = np.abs(np.diff(every[..., 0], axis=1)).max() / 2
    between = np.ptp(slopes) / 2
    slope = float(np.median(slopes))
    error = DEVIATIONS * math.hypot(statistical, between, bent, levels, SYSTEMATIC * slope)
    return _Slope(slope, error, first, last)


class _Fit(NamedTuple):
    """The samples between which a slope was fitted, the slope, its statistical error and a quarter of the difference
    of its halves.
    """

    first: int
    last: int
    slope: float
    statistical: float
    bent: float


def _fitted(groups: np.ndarray, typical: float, skip: int) -> list[_Fit]:
    """Return the slopes of a curve, the mean of groups (groups, times), for both levels at which it may saturate."""
    mean = groups.mean(axis=0)
    first = min(skip, len(mean) - 1)
    found = []
    slowed = _slowed(mean, first, typical)
    for top in (min(typical, slowed + UNSURE), slowed):
        beyond = np.flatnonzero(mean > top - SATURATED)
        last = int(beyond[0]) if beyond.size else len(mean) - 1
        if last - first < 4 or mean[last] - mean[first] < GROWTH:
            found.append(_Fit(min(first, last), last, math.nan, math.inf, math.inf))
            continue
        at = np.arange(first, last + 1)
        slopes = [np.polyfit(at, _unsaturated(np.minimum(group[at], top - 0.1), top), 1)[0] for group in groups]
        rising = _unsaturated(mean[at], top)
        half = len(at) // 2
        early, late = (np.polyfit(at[part], rising[part], 1)[0] for part in (slice(half + 1), slice(half, None)))
        slope = float(np.polyfit(at, rising, 1)[0])
        found.append(_Fit(first, last, slope, float(np.std(slopes, ddof=1)) / math.sqrt(GROUPS), abs(early - late) / 4))
    return found


def _slowed(mean: np.ndarray, first: int, typical: float) -> float:
    """Return the logarithmic distance at which a curve rises at SLOW times its largest rate, or the typical one."""
    span = max(4, (len(mean) - first) // 24)
    rates = (mean[first + span :] - mean[first:-span]) / span
    if rates.size < 2:
        return typical
    slow = np.flatnonzero(rates[rates.argmax() :] < SLOW * rates.max())
    return min(typical, float(mean[first + rates.argmax() + slow[0]])) if slow.size else typical
