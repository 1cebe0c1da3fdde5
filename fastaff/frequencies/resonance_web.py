"""The web of resonances: lines k . nu = 0 over a grid of initial conditions or in the plane of frequency ratios."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.numbers import an_array, entries, numbers, real, shown, span, whole
from ..results.progress import says_progress
from ..results.result import Result, along
from .own_lines import about_an_axis, calm, duration, harmonics, in_turns, own_lines, with_turn
from .resonances import MAX_ORDER, checked_frequencies, equation, vectors, widths

TORN = 0.03
"""Share of the largest frequency by which own lines of neighbours differ where they are not of one family."""

WRAPPED = 0.5
"""Turns by which tunes of neighbours differ where one passes a whole turn."""

BIN = 0.1
"""Cycles over the time of a map within which frequencies are alike."""


@dataclass(frozen=True)
class ResonanceLine(Result, axis=None):
    """Resonance k·nu = 0 in a plane of initial conditions or of frequency ratios.

    Attributes
    ----------
    vector : tuple of int
        Integer vector k.
    order : int
        Order :math:`|k|_1`.
    lines : tuple of ndarray, shape (points, 2)
        Polylines in the coordinates of the axes.
    locked : ndarray of bool, shape (n1, n2), or None
        Grid points whose frequencies satisfy the resonance within its width: an island, or all of a degenerate region.
        None in a plane of ratios.
    names : tuple of str
        Names of the frequencies; "turn" is the frequency 1 of a map.
    axes : tuple of ndarray
        Axes of the grid.
    coordinates : tuple of str
        Names of the axes, if an `EnergyGrid` was given.
    """

    vector: tuple[int, ...]
    order: int
    lines: tuple[np.ndarray, ...]
    locked: Annotated[np.ndarray | None, along("first", "second")]
    names: tuple[str, ...] = ()
    axes: tuple[np.ndarray, ...] = ()
    coordinates: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Total length of the lines, in the coordinates of the axes."""
        return float(sum(np.sqrt((np.diff(line, axis=0) ** 2).sum(axis=1)).sum() for line in self.lines))

    def summary(self) -> str:
        """Return one line with the resonance, its length, and the fraction of the grid that is locked in it.

        Returns
        -------
        str
            Summary.
        """
        names = self.names or [f"{k + 1}" for k in range(len(self.vector))]
        said = f"{equation(self.vector, names)}, order {self.order}, length {self.length:.3g}"
        if self.locked is None:
            return said
        return f"{said}, {np.count_nonzero(self.locked)} points locked ({np.mean(self.locked):.1%} of the grid)"


@says_progress
def resonance_web(
    nu: ArrayLike | Result,
    *,
    axes: Sequence[ArrayLike] | Result | None = None,
    max_order: int = 8,
    resonances: ArrayLike | None = None,
    tolerance: float = 1e-6,
    errors: ArrayLike | None = None,
    jump: float | None = None,
    shortest: int = 4,
) -> list[ResonanceLine]:
    r"""Find the lines k·nu = 0 over a grid of initial conditions.

    Parameters
    ----------
    nu : array_like, shape (n, n1, n2), or result
        Frequencies of n = 2 to 4 angles, NaN if there is no regular orbit. Also accepted, with their errors:

        - a `FrequencyMap` of the orbits of the grid `axes`: the dominant lines of all orbits that are not chaotic. If
          most of these are dependent, as for loops around a centre, its ``nu`` of the largest family with one
          ``basis``;
        - `Tunes`, or a `FrequencyMap` of a map: the frequency 1 of the turn is appended.
    axes : sequence of two array_like, shape (n1,) and (n2,), or EnergyGrid, optional
        Coordinates of the grid. Default: its indices.
    max_order : int, default 8
        Largest order of the primitive vectors searched, up to 50.
    resonances : array_like of int, shape (m, n), optional
        Vectors to search instead.
    tolerance : float, default 1e-6
        Relative width of a resonance, not negative.
    errors : array_like, shape of `nu`, default 0
        Absolute errors of the frequencies.
    jump : float, optional
        Cells in which a frequency differs by more than ``jump max|nu|`` between neighbours are left out. Default: none
        for arrays, 0.03 for dominant lines, 0.5 for tunes.
    shortest : int, default 4
        Lines of fewer points, which noise makes at the boundary of an island, and lines around a single cell are
        dropped. The same holds for resonances without a line that fewer grid points are locked in.

    Returns
    -------
    list of `ResonanceLine`
        Resonances that occur, by order.

    Raises
    ------
    ValueError
        If a shape is wrong or a value is out of its range.
    TypeError
        If an argument is of a wrong kind.

    Notes
    -----
    - Method: contours of the piecewise linear interpolant of :math:`k \cdot \nu`. Cells in which all corners are within
      the width are an area, shown by ``locked``, and contours end at it.
    - Accuracy: lines differ from those of a smooth map by the order of the squared cell size.
    - Degenerate models: if the whole map satisfies some resonances, vectors that differ by these give equal lines. Only
      the first is kept.
    - Cost: one pass over the grid for each vector, and a contour for each one that changes sign.

    References
    ----------
    Laskar 1993, Physica D 67, 257 (resonance lines in frequency maps); contours by contourpy, which comes with
    matplotlib.

    Examples
    --------
    Over a grid of initial conditions at one energy, drawn over the diffusion by ``found.plot(grid, web=web)``:

    >>> galaxy = fa.hamiltonian("log(0.01 + x**2 + y**2/0.81 + z**2/0.49)/2", coordinates="x y z")
    >>> starts = {"theta": np.linspace(0.1, 1.4, 4), "phi": np.linspace(0.1, 1.4, 4)}
    >>> grid = fa.energy_grid(galaxy, energy=0.0, axes=starts, at_rest=True)
    >>> found = fa.frequency_map(galaxy, grid.z0, time=200.0)
    >>> web = fa.resonance_web(found, axes=grid, max_order=5)

    >>> nu = np.array(np.meshgrid(np.linspace(0.2, 0.4, 9), np.linspace(0.21, 0.43, 9)))
    >>> [line.vector for line in fa.resonance_web(nu, max_order=2)]
    [(1, -1)]
    """
    import contourpy

    names: tuple[str, ...] = ()
    coordinates: tuple[str, ...] = ()
    if hasattr(axes, "to_grid"):
        grid: Any = axes
        axes = grid.axes
        coordinates = grid.names
        if isinstance(nu, Result):
            over, errors, torn = _over(grid, nu, errors)
            names = with_turn(nu)[0] if hasattr(nu, "names") else ()
            nu = over
            jump = torn if jump is None else jump
    elif hasattr(nu, "regular"):
        raise TypeError(
            f"axes must be the EnergyGrid of the orbits of nu, got {type(axes).__name__}. For another grid pass nu as "
            "an array, nu.reshape(-1, n1, n2)."
        )
    nu, errors = checked_frequencies(nu, errors)
    if nu.ndim != 3 or min(nu.shape[1:]) < 2:
        raise ValueError(f"nu must have shape (n, n1, n2) over a grid of 2 x 2 points or more, got {nu.shape}")
    first, second = _axes(axes, nu.shape[1:])
    shortest = whole("shortest", shortest, 2)
    k = _chosen(resonances, nu.shape[0], max_order)
    nu = np.where((np.isfinite(nu) & np.isfinite(errors)).all(axis=0), nu, np.nan)
    width = widths(nu, real("tolerance", tolerance), errors)
    valid = np.isfinite(nu[0])
    smooth = valid if jump is None else valid & ~_torn(nu, real("jump", jump))
    about: Any = {"names": names, "axes": (first, second), "coordinates": coordinates}
    found: list[ResonanceLine] = []
    everywhere: list[np.ndarray] = []
    for vector in k:
        value = np.tensordot(vector, nu, axes=1)
        with np.errstate(invalid="ignore"):
            locked = np.abs(value) <= np.tensordot(np.abs(vector), width, axes=1)
            changes = (value > 0).any() and (value < 0).any()
        if not changes and not locked.any():
            continue
        if valid.any() and locked[valid].all():
            everywhere.append(vector)
        hidden = np.where(smooth & ~_areas(locked), value, np.nan)
        contour: Any = (
            contourpy.contour_generator(x=first, y=second, z=np.ma.masked_invalid(hidden.T)) if changes else None
        )
        lines = contour.lines(0.0) if contour else ()
        lines = tuple(line for line in lines if len(line) >= shortest and not _around_one(line))
        if lines or np.count_nonzero(locked) >= shortest:
            order = int(np.abs(vector).sum())
            found.append(ResonanceLine(tuple(int(c) for c in vector), order, lines, locked=locked, **about))
    return _distinct(found, everywhere)


def _around_one(line: np.ndarray) -> bool:
    """Tell whether a line (points, 2) goes around a single cell, over the four edges that begin there."""
    return len(line) == 5 and bool((line[0] == line[-1]).all())


def _over(grid: Any, found: Any, errors: Any) -> tuple[np.ndarray, Any, float | None]:
    """Return the frequencies of a map's calm orbits over their grid, their errors, and the jump."""
    if not (hasattr(found, "regular") and np.shape(found.regular) == grid.cell_index.shape):
        raise TypeError(
            f"nu must be a frequency map of the {grid.cell_index.size} orbits of the grid in axes, got {shown(found)}"
        )
    known = found.regular if about_an_axis(found) else calm(found)  # there dominant lines may be driven ones of phi
    if in_turns(found):
        _, nu, error = with_turn(found)
        torn: float | None = WRAPPED
        error[:-1] = np.maximum(error[:-1], BIN / np.maximum(duration(found), 1))
    else:
        own = np.eye(len(found.nu), dtype=np.int64)[:, :, None]
        basis = np.where(harmonics(found)[:, None], own, found.basis)  # of the lines that `own_lines` takes
        families, counts = np.unique(basis[:, :, known], axis=2, return_counts=True)
        lost = np.linalg.matrix_rank(families.transpose(2, 0, 1)) < len(found.nu)
        alike = 2 * counts[lost].sum() >= counts.sum()
        nu, error = (found.nu, found.error) if alike else own_lines(found)
        if alike and counts.size:  # in another family `nu` are other lines: there is no resonance on the way to it
            known = known & (basis == families[:, :, counts.argmax(), None]).all(axis=(0, 1))
        error = np.maximum(error, BIN / found.time)
        torn = None if alike else TORN
    over = np.array([grid.to_grid(np.where(known, row, np.nan)).filled(np.nan) for row in (*nu, *error)])
    return over[: len(nu)], np.nan_to_num(over[len(nu) :], posinf=np.inf) if errors is None else errors, torn


@says_progress
def ratio_web(
    *, x: tuple[float, float], y: tuple[float, float], max_order: int = 8, resonances: Any = None
) -> list[ResonanceLine]:
    """Find the resonance lines in the plane of two frequency ratios, X = nu1/nu3 and Y = nu2/nu3.

    Parameters
    ----------
    x, y : tuple of float
        Ranges (low, high) of the two ratios.
    max_order : int, default 8
        Largest order of the primitive vectors (k1, k2, k3) searched, up to 50.
    resonances : array_like of int, shape (m, 3), optional
        Vectors to search instead.

    Returns
    -------
    list of `ResonanceLine`
        Resonances k1 X + k2 Y + k3 = 0 that cross the ranges, by order. Each has one segment of shape (2, 2), and
        ``locked`` is None.

    Raises
    ------
    ValueError
        If a value is out of its range.
    TypeError
        If an argument is of a wrong kind.

    Notes
    -----
    - Accuracy: exact to round-off.

    References
    ----------
    Laskar 1993, Physica D 67, 257.

    Examples
    --------
    >>> lines = fa.frequencies.ratio_web(x=(0.6, 1.4), y=(0.7, 1.2), max_order=2)
    >>> [line.vector for line in lines]
    [(1, 0, -1), (1, -1, 0), (0, 1, -1)]
    """
    box = np.array([span("x", x), span("y", y)])
    found = []
    for vector in _chosen(resonances, 3, max_order):
        if not vector[:2].any():
            continue
        line = _segment(vector.astype(float), box)
        if line is not None:
            found.append(ResonanceLine(tuple(int(c) for c in vector), int(np.abs(vector).sum()), (line,), locked=None))
    return found


def _segment(k: np.ndarray, box: np.ndarray) -> np.ndarray | None:
    """Return the part (2, 2) of k1 X + k2 Y + k3 = 0 inside of a box, None where it is a point or nothing."""
    normal = k[:2]
    foot = -k[2] * normal / (normal @ normal)
    along = np.array([-normal[1], normal[0]])
    low = -np.inf
    high = np.inf
    for i in range(2):
        if along[i] == 0:
            if not box[i, 0] <= foot[i] <= box[i, 1]:
                return None
            continue
        ends = np.sort((box[i] - foot[i]) / along[i])
        low, high = max(low, ends[0]), min(high, ends[1])
    if not low < high:
        return None
    return np.clip(foot + np.outer([low, high], along), box[:, 0], box[:, 1])


def _axes(axes: Any, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the two coordinates of a grid."""
    takes = f"two increasing arrays of {shape[0]} and {shape[1]} coordinates"
    given = [np.arange(m) for m in shape] if axes is None else entries("axes", axes, takes)
    chosen = [numbers("axes", a) for a in given]
    if len(chosen) != 2 or any(
        a.shape != (m,) or not (np.diff(a) > 0).all() for a, m in zip(chosen, shape, strict=True)
    ):
        raise ValueError(f"axes must be {takes}, got {shown(axes)}")
    return chosen[0], chosen[1]


def _chosen(resonances: Any, n: int, max_order: int) -> np.ndarray:
    """Return the vectors (m, n) to search, by order."""
    if resonances is None:
        if whole("max_order", max_order, 1) > MAX_ORDER:
            raise ValueError(f"max_order must be at most {MAX_ORDER}, got {max_order}")
        return vectors(n, max_order)
    k = an_array("resonances", resonances)
    if k.dtype.kind not in "iu" or k.ndim != 2 or k.shape[1] != n or not k.any(axis=1).all():
        raise ValueError(f"resonances must be integer vectors (m, {n}), none of them zero, got {shown(resonances)}")
    return k[np.argsort(np.abs(k).sum(axis=1), kind="stable")].astype(np.int64)


def _areas(locked: np.ndarray) -> np.ndarray:
    """Return the locked grid points (n1, n2) that are a corner of a cell whose corners are all locked."""
    full = locked[:-1, :-1] & locked[1:, :-1] & locked[:-1, 1:] & locked[1:, 1:]
    area = np.zeros_like(locked)
    for i in (slice(None, -1), slice(1, None)):
        for j in (slice(None, -1), slice(1, None)):
            area[i, j] |= full
    return area


def _torn(nu: np.ndarray, jump: float) -> np.ndarray:
    """Return the grid points (n1, n2) beside which a frequency jumps."""
    limit = jump * np.nanmax(np.abs(nu))
    torn = np.zeros(nu.shape[1:], bool)
    for axis in (0, 1):
        with np.errstate(invalid="ignore"):
            far = (np.abs(np.diff(nu, axis=1 + axis)) > limit).any(axis=0)
        before = [slice(None), slice(None)]
        after = list(before)
        before[axis], after[axis] = slice(None, -1), slice(1, None)
        torn[tuple(before)] |= far
        torn[tuple(after)] |= far
    return torn


def _distinct(found: list[ResonanceLine], everywhere: list[np.ndarray]) -> list[ResonanceLine]:
    """Keep a basis of the resonances that hold everywhere, and one line of those that differ by their combinations."""
    if not everywhere:
        return found
    common = {tuple(int(c) for c in vector) for vector in everywhere}
    _, size, axes = np.linalg.svd(np.array(everywhere, dtype=float))
    free = axes[int((size > 1e-9).sum()) :]  # the directions that the frequencies of this map can have
    basis: list[tuple[int, ...]] = []
    seen = set()
    kept = []
    for line in found:
        direction = free @ np.array(line.vector, dtype=float)
        length = np.linalg.norm(direction)
        if line.vector in common or length <= 1e-9:
            if np.linalg.matrix_rank(np.array([*basis, line.vector])) > len(basis):
                basis.append(line.vector)
                kept.append(line)
            continue
        lead = direction[np.abs(direction).argmax()]
        key = tuple(np.round(direction / length * np.sign(lead), 9) + 0.0)
        if key not in seen:
            seen.add(key)
            kept.append(line)
    return kept
