"""Analysis of the points of a section: rotation numbers, invariant curves, chains of islands, chaos.

Points are (2, crossings, orbits), two coordinates of a section at successive crossings, NaN past the last; from a
SectionMap of a body: np.array([found["beta"], found["p_beta"]]).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.classification import Classification
from ..core.numbers import an_array, fits, numbers, positive, shown, whole
from ..core.status import Status, describe
from ..engine.kernels.birkhoff import SHARPNESS
from ..frequencies.turning import unresolved
from ..frequencies.windows import SPANS
from ..results.progress import says_progress
from ..results.result import Result, along
from ..systems.models.sections import (
    AlphaEquals,
    AlphaTurning,
    AngleEquals,
    BetaEquals,
    BetaTurning,
    Hyperplane,
)
from .scatter import scattered
from .section_map import SectionMap

SAFETY = 5.0
"""Factor of error estimates over the differences between windows, as for frequency maps."""

ROUNDING = 1e-14
"""Rounding error of a rotation number, in turns: a term of each error."""

STILL = 1e-9
"""Relative size of an island below which it is a periodic orbit."""

LEAST = 32
"""Crossings that a rotation number needs."""

FRAMES = 3
"""Linear maps that make a curve round, one after the other, as moments of a thin one are lost in rounding."""

THINNEST = 1e-6
"""Least ratio of the axes that one of these maps changes."""

RADIAL = (AlphaTurning, BetaTurning, AlphaEquals, BetaEquals)
"""Sections of a body on which the other radius and its momentum are a canonical pair."""

STRAIGHT = 1e-11
"""Angular momentum in a plane of a body, relative to largest radius times largest momentum, below which the orbit runs
on a line. The round-off of a thousand steps is smaller.
"""

CHAOS = 1.5
"""Digits fewer than asked for that a chaotic orbit must have: its rotation number converges like N^(-1/2)."""


@dataclass(frozen=True)
class Rotation(Result):
    """Rotation numbers of section orbits.

    Attributes
    ----------
    rotation : ndarray, shape (orbits,)
        Rotation numbers in turns per crossing, in (-1/2, 1/2]. Counterclockwise is positive; whole turns more or less
        cannot be seen.
    error : ndarray, shape (orbits,)
        Error estimates, in turns per crossing; inf for orbits with too few crossings.
    digits : ndarray, shape (orbits,)
        Digits to which both halves of the orbit agree: -log10 of the difference of the rotation number or of the
        relative mean squared radius, the fewer of the two.
    centre : ndarray, shape (2, orbits)
        Centre about which the angle is measured.
    counts : ndarray of int, shape (orbits,)
        Number of points.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit: OK or TOO_FEW_CROSSINGS.
    """

    rotation: Annotated[np.ndarray, along("orbit", unit="turns per crossing")]
    error: Annotated[np.ndarray, along("orbit", unit="turns per crossing")]
    digits: Annotated[np.ndarray, along("orbit")]
    centre: Annotated[np.ndarray, along("coordinate", "orbit")]
    counts: Annotated[np.ndarray, along("orbit")]
    status: Annotated[np.ndarray, along("orbit")]


@dataclass(frozen=True)
class Islands(Result):
    """Classification of section orbits, with positions and sizes of islands.

    Attributes
    ----------
    classification : ndarray of int, shape (orbits,)
        `Classification` of each orbit: REGULAR, CHAOTIC, UNDECIDED, or RESONANT for a chain of islands.
    rotation : Rotation
        Rotation numbers.
    p, q : ndarray of int, shape (orbits,)
        Rotation number p/q of a chain of q islands; both 0 if there is none. A chain that does not go around the centre
        has p = 0.
    centres : ndarray, shape (2, islands, orbits)
        Mean point of each island, in the order of visits; NaN after the last one.
    semi_axes : ndarray, shape (2, islands, orbits)
        Half of the range of the points of each island in both coordinates; NaN after the last one.
    secondary_rotation : ndarray, shape (orbits,)
        Turns about the centre of the first island in q crossings; NaN without a chain.
    secondary_rotation_error : ndarray, shape (orbits,)
        Error estimates of these.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit.
    """

    classification: Annotated[np.ndarray, along("orbit")]
    rotation: Annotated[Rotation, along("orbit")]
    p: Annotated[np.ndarray, along("orbit")]
    q: Annotated[np.ndarray, along("orbit")]
    centres: Annotated[np.ndarray, along("coordinate", "island", "orbit", padded="island")]
    semi_axes: Annotated[np.ndarray, along("coordinate", "island", "orbit", padded="island")]
    secondary_rotation: Annotated[np.ndarray, along("orbit", unit="turns per period")]
    secondary_rotation_error: Annotated[np.ndarray, along("orbit", unit="turns per period")]
    status: Annotated[np.ndarray, along("orbit")]

    def table(self) -> list[tuple[int, int, int, tuple[float, float]]]:
        """Return the chains of islands that were found.

        Returns
        -------
        list of tuple
            Tuples (p, q, orbits, semi-axes): the rotation number p/q, the number of orbits, and the largest semi-axis
            of an island in both coordinates. Chains of few islands are first.
        """
        chains = sorted({(int(q), int(p)) for p, q in zip(self.p, self.q, strict=True) if q})
        found = []
        for q, p in chains:
            own = (self.p == p) & (self.q == q)
            size = np.fmax.reduce(self.semi_axes[:, :, own].reshape(2, -1), axis=1)
            found.append((p, q, int(own.sum()), (float(size[0]), float(size[1]))))
        return found

    def summary(self) -> str:
        """Return one line with the number of orbits of each class.

        Returns
        -------
        str
            Summary.
        """
        kinds = {entry.name.lower(): self.classification == entry for entry in Classification}
        return describe(np.zeros(self.classification.size, np.int64), kinds)


@says_progress
def rotation_number(points: ArrayLike | SectionMap, *, centre: ArrayLike | None = None) -> Rotation:
    r"""Compute rotation numbers of section orbits about a centre.

    Parameters
    ----------
    points : array_like, shape (2, crossings) or (2, crossings, orbits), or SectionMap
        Coordinate and momentum at the crossings, NaN after the last one. A `SectionMap` must be of a map of one degree
        of freedom, of a section q_i = c of a system of two degrees of freedom, or of a section of alpha or beta of a
        body, such as "alpha-turning". The points of a body are beta, p_beta or alpha, p_alpha.
    centre : array_like, shape (2,) or (2, orbits), optional
        Point inside the invariant curves. Default: the weighted mean of each orbit, which lies inside any convex curve.

    Returns
    -------
    `Rotation`
        Rotation numbers in turns per crossing. An orbit of fewer than 32 points has the status TOO_FEW_CROSSINGS.

    Raises
    ------
    ValueError
        If the points or the centre have a wrong shape or value, or the `SectionMap` has other dimensions.
    TypeError
        If the points are of another kind.

    Notes
    -----
    - Method: weighted Birkhoff average of the advance of the angle, with the weight :math:`\exp(30(\sqrt{1 - x^2} -
      1))`. A linear map first makes the second moments of the points those of a circle, so units and thin curves do not
      matter.
    - Accuracy: faster than any power of the number N of crossings for a smooth curve and a Diophantine rotation number;
      :math:`N^{-1/2}` for chaotic orbits. Neighbours must be less than half a turn apart. Any centre inside a curve
      r(theta) gives the same number.
    - Errors: 5 times the largest difference between windows, the effect of unseen beats with fractions p/m, and
      round-off.
    - Cost: one sort of the angles of each orbit. Memory: ten times the points.

    References
    ----------
    Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111; digits: Sander & Meiss 2020, Physica D 411, 132569.

    Examples
    --------
    >>> angle = 2 * np.pi * 0.381966 * np.arange(500)
    >>> fa.rotation_number([np.cos(angle), np.sin(angle)]).rotation.round(9)
    array([0.381966])
    """
    points, counts = _checked(points)
    return _rotation(points, counts, _centres(centre, points, counts))


@says_progress
def islands(
    points: ArrayLike | SectionMap, *, centre: ArrayLike | None = None, max_islands: int = 32, digits: float = 4.0
) -> Islands:
    """Distinguish invariant curves, chains of islands and chaotic orbits of a section.

    Parameters
    ----------
    points : array_like, shape (2, crossings) or (2, crossings, orbits), or SectionMap
        Coordinate and momentum at the crossings, NaN after the last one. A `SectionMap` must be of a map of one degree
        of freedom, of a section q_i = c of a system of two degrees of freedom, or of a section of alpha or beta of a
        body, such as "alpha-turning". The points of a body are beta, p_beta or alpha, p_alpha.
    centre : array_like, shape (2,) or (2, orbits), optional
        Point inside the invariant curves; for a chain, a point between its islands, such as the elliptic fixed point.
        Default: the weighted mean of each orbit.
    max_islands : int, default 32
        Largest number q of islands in a chain that is searched for.
    digits : float, default 4
        Positive number of digits to which the rotation number of a curve or chain must be known.

    Returns
    -------
    `Islands`
        Classification of each orbit, with rotation numbers, positions and sizes of islands.

    Raises
    ------
    ValueError
        If the points, the centre or an option have a wrong shape or value.
    TypeError
        If the points are of another kind, or the `SectionMap` has other dimensions.

    Notes
    -----
    - RESONANT: the rotation number is p/q within its error. Every q-th point stays in one sector of angles and turns
      back there, or does not move. An island beside the centre has q = 1.
    - REGULAR: all other orbits whose rotation number converges.
    - CHAOTIC: the rotation number does not converge, and 200 points or more fill an area while neighbours separate.
    - UNDECIDED: all others. Orbits close to a separatrix or a resonance need thousands of crossings.
    - Accuracy: the mean point of an island differs from its periodic point by the order of its width squared.
    - Cost: `rotation_number`, one pass for each q, and 600 distances a point of orbits that do not converge.

    References
    ----------
    Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111; Sander & Meiss 2020, Physica D 411, 132569 (digits); Meiss
    1992, Rev. Mod. Phys. 64, 795 (chains of islands).

    Examples
    --------
    >>> turns = fa.poincare_map(fa.models.HenonMap(), [[0.1, 0.2], [0.0, 0.0]], crossings=1000)
    >>> print(fa.islands(turns).summary())
    2 orbits: 2 regular
    """
    points, counts = _checked(points)
    max_islands = whole("max_islands", max_islands, 1)
    digits = positive("digits", digits)
    middle = _centres(centre, points, counts)
    rotation = _rotation(points, counts, middle)
    orbits = counts.size
    rounded = _rounded(points, counts, middle)
    fits("max_islands", orbits, max_islands, 4)
    classification = np.where(
        (rotation.digits >= digits) & (rotation.status == Status.OK), Classification.REGULAR, Classification.UNDECIDED
    )
    for o in np.flatnonzero((rotation.digits < digits - CHAOS) & (rotation.status == Status.OK)):
        classification[o] = Classification.CHAOTIC if scattered(rounded[o, : counts[o]]) else Classification.UNDECIDED
    p, q = np.zeros((2, orbits), np.int64)
    centres, semi_axes = np.full((2, orbits, max_islands, 2), np.nan)
    secondary_rotation, secondary_rotation_error = np.full((2, orbits), np.nan)
    size = np.fmax.reduce(points, axis=1) - np.fmin.reduce(points, axis=1)
    still = size.max(axis=1) <= STILL * np.fmax.reduce(np.abs(points), axis=1).max(axis=1)
    # One island comes last: points that keep to one sector may still fall apart into several inside of it.
    for period in (*range(2, max_islands + 1), 1):
        nearest = np.rint(period * rotation.rotation)
        near = np.abs(rotation.rotation - nearest / period) <= rotation.error
        if period == 1:  # a curve that closes turns by more than 1/counts
            near &= (rotation.error < 0.5 / np.maximum(counts, 1)) | still
        else:
            near &= ~still
        tried = np.flatnonzero(near & (classification == Classification.REGULAR) & (counts >= 4 * period))
        if not tried.size:
            continue
        sub = _visits(points[tried], counts[tried], period)
        apart, returns = _sectors(_visits(rounded[tried], counts[tried], period))
        returns |= still[tried]
        classification[tried[apart]] = np.where(returns[apart], Classification.RESONANT, Classification.UNDECIDED)
        found = tried[apart]
        p[found] = np.where(2 * nearest[found] == -period, period / 2, nearest[found])
        q[found] = period
        sub = sub[apart]
        visits = (counts[found] + period - 1) // period
        semi_axes[found, :period] = (np.fmax.reduce(sub, axis=1) - np.fmin.reduce(sub, axis=1)) / 2
        for island in range(period):
            number = (counts[found] - island + period - 1) // period
            centres[found, island] = _mean(sub[:, :, island], number)
        own = _rotation(sub[:, :, 0], visits, centres[found, 0])
        secondary_rotation[found] = own.rotation
        secondary_rotation_error[found] = own.error
    most = int(q.max(initial=1))
    centres, semi_axes = (array[:, :most].transpose(2, 1, 0) for array in (centres, semi_axes))
    status = rotation.status.copy()
    return Islands(
        classification,
        rotation,
        p,
        q=q,
        centres=centres,
        semi_axes=semi_axes,
        secondary_rotation=secondary_rotation,
        secondary_rotation_error=secondary_rotation_error,
        status=status,
    )


def _plane(section_map: SectionMap) -> np.ndarray:
    """Return the two free rows (2, crossings, orbits) of a map of two rows, or of a section q_i = c of four."""
    points = section_map.points
    normal = np.asarray(getattr(section_map.section, "normal", ()))
    if len(points) == 2:
        return points
    if type(section_map.section) in RADIAL and len(points) == 8:
        return _radial(points, section_map.section.over)
    one = type(section_map.section) in (Hyperplane, AngleEquals) and np.count_nonzero(normal) == 1
    if len(points) != 4 or not one or normal[2:].any():
        raise ValueError(
            "points must be a SectionMap of a map or a section q_i = c with one degree of freedom left. Try "
            f"{_pair_of(section_map)}."
        )
    other = 1 - int(np.flatnonzero(normal)[0])
    return points[[other, 2 + other]]


def _pair_of(section_map: SectionMap) -> str:
    """Return, as Python, the array of a coordinate that a section leaves free and of its momentum."""
    section = section_map.section
    names = section_map.names
    n = len(names) // 2
    fixed = set(np.flatnonzero(getattr(section, "normal", ())).tolist())
    rows = [k for k in range(len(names)) if k not in fixed]
    canonical = [k for k in rows if k + n in rows]
    if hasattr(section, "over"):
        q, p = section.over, f"p_{section.over}"
    elif len(names) == 2 * n and canonical:
        q, p = names[canonical[0]], names[canonical[0] + n]
    else:
        q, p = (names[k] for k in rows[:2])
    return f"np.array([found[{q!r}], found[{p!r}]])"


def _radial(points: np.ndarray, name: str) -> np.ndarray:
    """Return the radius alpha or beta of a body and its momentum (2, crossings, orbits). They are canonical on sections
    of the other radius, because p_eta and p_gamma are conserved. An orbit on a line through the centre of its plane
    gets its signed place on it: a radius would fold its curve.
    """
    first = 0 if name == "alpha" else 2
    q, p = points[first : first + 2], points[first + 4 : first + 6]
    radius, momentum = np.hypot(*q), np.hypot(*p)
    with np.errstate(all="ignore"):
        found = np.array([radius, (q * p).sum(axis=0) / radius])
    about = np.nan_to_num(np.abs(q[0] * p[1] - q[1] * p[0])).max(axis=0, initial=0.0)
    most = np.nan_to_num(radius).max(axis=0, initial=0.0)
    for o in np.flatnonzero(about <= STRAIGHT * most * np.nan_to_num(momentum).max(axis=0, initial=0.0)):
        part = q[:, :, o] if most[o] > 0 else p[:, :, o]
        farthest = np.argmax(np.nan_to_num(np.hypot(*part)))
        length = np.hypot(*part[:, farthest])
        along_line = part[:, farthest] / length if length > 0 else np.array([1.0, 0.0])
        found[:, :, o] = along_line @ q[:, :, o], along_line @ p[:, :, o]
    return found


def _checked(points: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return points (orbits, crossings, 2), fresh ones, NaN from the first that is not finite, and their numbers."""
    array = an_array("points", _plane(points) if isinstance(points, SectionMap) else points)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"points must be an array of real numbers, got {type(points).__name__} of {array.dtype}")
    if array.ndim not in (2, 3) or array.shape[0] != 2 or array.shape[1] == 0:
        raise ValueError(f"points must have shape (2, crossings) or (2, crossings, orbits), got {array.shape}")
    array = np.array(array.reshape(*array.shape[:2], -1).transpose(2, 1, 0), np.float64, order="C")
    if array.shape[1] == 1:  # a slot for the image of the only crossing
        array = np.concatenate([array, np.full_like(array, np.nan)], axis=1)
    missing = ~np.isfinite(array).all(axis=2)
    counts = np.where(np.any(missing, axis=1), np.argmax(missing, axis=1), array.shape[1])
    array[np.arange(array.shape[1]) >= counts[:, None]] = np.nan
    return array, counts


def _centres(centre: Any, points: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return a centre (orbits, 2) for each orbit."""
    if centre is None:
        return _mean(points, counts)
    given = numbers("centre", centre)
    if given.shape not in ((2,), (2, len(points))) or not np.isfinite(given).all():
        raise ValueError(
            f"centre must be a finite point (2,) or one for each of {len(points)} orbits (2, orbits), got "
            f"{shown(centre)}"
        )
    return np.broadcast_to(given.T, (len(points), 2)).copy()


def _weights(slots: int, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return normalised weights (orbits, slots) of a window over the places first <= k < last of each orbit."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (2 * np.arange(slots) + 1 - (first + last)[:, None]) / (last - first)[:, None]
        weight = np.where(np.abs(x) < 1, np.exp(SHARPNESS * (np.sqrt(np.maximum(1 - x * x, 0.0)) - 1)), 0.0)
        return weight / _total(weight)[:, None]


def _total(values: np.ndarray) -> np.ndarray:
    """Return the sums over the slots of values (orbits, slots, ...), one after another: zeros past the last change no
    bit.
    """
    return np.cumsum(values, axis=1)[:, -1]


def _mean(values: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the weighted averages of values (orbits, slots, 2) over the first counts of each orbit."""
    weight = _weights(values.shape[1], np.zeros_like(counts), counts)
    return _total(weight[..., None] * np.nan_to_num(values))


def _means(values: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the averages (spans, orbits) of values (orbits, slots) over SPANS of the counts: the whole, the halves,
    uneven windows.
    """
    clean = np.nan_to_num(values)
    windows = [(np.rint(begin * counts), np.rint(end * counts)) for begin, end in SPANS]
    return np.array([_total(_weights(values.shape[1], *window) * clean) for window in windows])


def _rotation(points: np.ndarray, counts: np.ndarray, centre: np.ndarray) -> Rotation:
    """Return the Rotation of points (orbits, slots, 2) about centre (orbits, 2)."""
    x, y = np.moveaxis(_rounded(points, counts, centre), -1, 0)
    enough = counts >= LEAST
    steps = np.where(enough, counts - 1, LEAST)
    turns = _means(_displacements(np.arctan2(y, x)) / (2 * np.pi), steps)
    radius = _means(x * x + y * y, np.where(enough, counts, LEAST))
    difference = np.abs(turns[1] - turns[2])
    uneven = np.abs(turns[1:] - turns[0]).max(axis=0)
    spread = np.abs(radius[1] - radius[2]) / np.where(radius[0] > 0, radius[0], 1.0)
    digits = np.where(enough, -np.log10(np.maximum(np.maximum(difference, spread), 1e-16)), 0.0)
    rotation = np.where(enough, turns[0] - np.ceil(turns[0] - 0.5), 0.0)
    error = np.where(enough, SAFETY * uneven + unresolved(turns[0], steps) + ROUNDING, np.inf)
    status = np.where(enough, Status.OK, Status.TOO_FEW_CROSSINGS)
    return Rotation(rotation, error, digits, centre=centre.T, counts=counts, status=status)


def _rounded(points: np.ndarray, counts: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Return points (orbits, slots, 2) about their centres (orbits, 2), moved linearly so that their weighted second
    moments are those of a circle of radius 1: an ellipse becomes that circle, whatever the units of its coordinates.

    The rotation number is the same. On a circle all steps are equal; on an ellipse they vary by harmonics, which beat
    slowly next to a rational number.
    """
    away = points - centre[:, None]
    exponent = np.frexp(np.fmax.reduce(np.abs(away), axis=1))[1]
    away = np.ldexp(away, -exponent[:, None])  # squares in any units
    weight = _weights(points.shape[1], np.zeros_like(counts), counts)[..., None, None]
    for _ in range(FRAMES):
        known = np.nan_to_num(away)
        moments = 2 * _total(weight * known[..., :, None] * known[..., None, :])
        spread, axes = np.linalg.eigh(np.where(np.isfinite(moments), moments, 0.0))
        size = np.sqrt(np.maximum(spread, THINNEST**2 * spread[:, 1:]))
        axes = axes / np.where(size > 0, size, 1.0)[:, None]
        axes[:, :, 0] *= np.sign(np.linalg.det(axes))[:, None]  # turns keep their sense
        turn = np.where(spread[:, 1:, None] > 0, axes, np.eye(2))[:, None]
        away = away[..., :1] * turn[..., 0, :] + away[..., 1:] * turn[..., 1, :]
    return away


def _displacements(theta: np.ndarray) -> np.ndarray:
    """Return the lifted displacements (orbits, slots - 1) of angles theta (orbits, slots), NaN past the last.

    In the order of the angles, from behind the widest gap, each image is taken within half a turn of the one before it.
    """
    image = theta[:, 1:]
    start = np.where(np.isnan(image), np.nan, theta[:, :-1])
    ring = np.sort(start, axis=1)
    gaps = np.diff(ring, axis=1)
    widest = np.fmax.reduce(gaps, axis=1, initial=0.0)
    around = 2 * np.pi - (np.fmax.reduce(ring, axis=1) - ring[:, 0])
    edge = np.fmax.reduce(
        np.where(gaps >= np.maximum(widest, around)[:, None], ring[:, :-1], -np.inf), axis=1, initial=-np.inf
    )
    start = np.where(start <= edge[:, None], start + 2 * np.pi, start)
    order = np.argsort(start, axis=1)
    walk = np.take_along_axis(image, order, axis=1)
    walk[:, 1:] = walk[:, :1] + np.cumsum(_wrap(np.diff(walk, axis=1)), axis=1)
    lifted = np.empty_like(walk)
    np.put_along_axis(lifted, order, walk, axis=1)
    return lifted - start


def _visits(points: np.ndarray, counts: np.ndarray, q: int) -> np.ndarray:
    """Return points (orbits, slots, 2) as (orbits, visits, q, 2), NaN past the last."""
    slots = -(-int(counts.max()) // q) * q
    padded = np.full((len(points), max(slots, points.shape[1]), 2), np.nan)
    padded[:, : points.shape[1]] = points
    return padded[:, :slots].reshape(len(points), -1, q, 2)


def _sectors(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tell, for visits d (orbits, visits, q, 2) about a centre, whether each island keeps to its own sector, and
    whether the points return.
    """
    theta = np.arctan2(d[..., 1], d[..., 0])
    away = _wrap(theta - theta[:, :1])
    low = np.fmin.reduce(away, axis=1)
    high = np.fmax.reduce(away, axis=1)
    begin = np.mod(theta[:, 0] + low, 2 * np.pi)
    end = high - low
    order = np.argsort(begin, axis=1)
    begin = np.take_along_axis(begin, order, axis=1)
    end = np.take_along_axis(end, order, axis=1)
    free = np.concatenate([begin[:, 1:], begin[:, :1] + 2 * np.pi], axis=1) - (begin + end)
    # A single island may reach around most of the circle; its rotation number 0 shows that it does not close.
    apart = (free.min(axis=1) > 0.0) | (d.shape[2] == 1)
    radius = np.fmax.reduce(np.abs(d).reshape(len(d), -1), axis=1)
    size = (np.fmax.reduce(d, axis=1) - np.fmin.reduce(d, axis=1)).reshape(len(d), -1).max(axis=1)
    still = size <= STILL * radius
    steps = _wrap(np.diff(theta, axis=1)).reshape(len(d), -1)
    returns = (np.fmin.reduce(steps, axis=1) < 0) & (np.fmax.reduce(steps, axis=1) > 0)
    return apart, returns | still


def _wrap(angle: np.ndarray) -> np.ndarray:
    """Return angles in [-pi, pi)."""
    return np.mod(angle + np.pi, 2 * np.pi) - np.pi
