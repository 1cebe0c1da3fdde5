"""Levels of H = p.W p/2 + V(q) in one to three coordinates: a uniform grid, truncated coordinate by coordinate."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...runs.interruptible import interruptible
from ...runs.requirements import current_system
from ...sections.accessible_box import SEED, minima, potential_of, walled
from ...systems.models.mechanics import System
from ..states.level_table import VIBRATION, LevelTable, class_levels, level_scale
from ..states.symmetry import SymmetryClass
from ..states.vibration_state import LatticeWaves, PointLattice
from .cover import ONLY_SAMPLES
from .hidden_wells import WellCover, lost, more_wells, vibration_cover
from .lattice import BasisTooLarge, LatticeGrid, LatticeProblem, lowest
from .singular_ends import NoGroundState

COORDINATES = 3
"""Most coordinates that are computed."""
CUTS = (1.3, 1.6, 2.0, 2.5, 3.1, 3.9, 5.0, 6.5, 8.5, 11.0)
"""Kinetic and potential energies that bases hold, in units of the energy of the highest level above the bottom."""
SETTLED = 0.1
"""Change of the levels to the last basis, in units of their tolerance. Waves of oscillators then are within 1e-8."""
NEARER = 0.6
"""Factor, from one basis to the next, of the distance from the wall to the energy from which wells have no end."""
SPARE = 8
"""States more than are asked for below that energy."""

FEW = 1
"""The same where SPARE takes too large a basis."""

GROW = 1.4
"""Factor by which a range of energies grows until it holds the wanted states."""

HALVINGS = 30
"""Halvings of such a range in a search."""

FIRST = 8
"""Points of the first grid on either side."""

WIDER = 0.5
"""Share by which the grid grows where it is too narrow."""

POINTS = (1 << 15, 1 << 19, 1 << 21)
"""Most points of the grid, by the number of coordinates."""

DECAY = 40.0
"""Powers of e by which waves fall to rounding."""
ROUNDING = 64 * np.finfo(float).eps
"""Rounding of levels in units of the range of energies."""

APART = 30.0
"""The error of a level in units of its last change, where two bases do not agree within their errors: 26 was the worst
seen where errors fall as a power of the size.
"""


SEARCHES = 6
"""Searches for wells that descents have not met."""

DIRECTIONS = 24
"""Random directions in which a well is measured."""

STIFF = 0.5
"""Zero-point energy of the stiffest mode, in parts of the range of energies, from which it is added to that."""

ROUND = 9.0
"""Ratio of the zero-point energies of two modes from which on the axes of the grid are those of the well."""

VALLEY = 1e-6
"""Depth of wells below the energy from which on they have no end, in parts of it, that counts as none."""
ALONG = 0.999
"""Cosine of the angle between an axis of a well and one of the grid below which the grid is turned."""
STEEPER = 2.0
"""Ratio of the falls of V over stretches that are a hundredth of one another from which on it has a pole."""

SQUARE = 9e3
"""That ratio of -1/r^2, with which there may be no lowest level."""

ABOVE = 0.25
"""How far above a level that is higher than expected the range of energies then ends, in parts of it."""
HELD = 0.3
"""Largest difference of the means of V over a state between points of a grid that holds it, in units of the kinetic
energy of its shortest waves.
"""


class Open(Exception):
    """The region that an energy allows has no end, or its wells are too far apart for one grid."""


def vibration_levels(
    model: Any,
    count: int,
    hbar: float,
    tolerance: float,
    known: list[LevelTable],
    callback: Callable[[float], None] | None,
) -> None:
    """Compute the lowest levels of a model, add a table for each basis to those known.

    On a uniform grid the kinetic energy is that of all waves up to the shortest (sinc functions, on angles Fourier's);
    points where V is higher than a wall are left out. At each point of the first coordinate the Hamiltonian of the
    others is diagonalised and its states below the wall are kept; the shortest wave and the wall are one energy, which
    grows until two bases agree. If the allowed region has no end from some energy on, behind a saddle or where V goes
    to a limit, the wall approaches that energy from below. Source: Colbert & Miller 1992, J. Chem. Phys. 96, 1982 (the
    grid); Bacic & Light 1986, J. Chem. Phys. 85, 4594 (sequential truncation).
    """
    system = current_system(model)
    again: tuple[LatticeProblem, _BasisSearch] | None = (_problem(system, hbar), _BasisSearch())
    while again is not None:
        again = _bases(system, *again, count, hbar, tolerance, known, callback)
    _check_held(known[-1])


class _BasisSearch(NamedTuple):
    """How bases begin: spare states below the top energy, bounds of the top energy, and an upper limit of walls."""

    spare: float = SPARE
    least: float = -math.inf
    most: float = math.inf
    cap: float = math.inf


def _bases(
    system: System,
    problem: LatticeProblem,
    search: _BasisSearch,
    count: int,
    hbar: float,
    tolerance: float,
    known: list[LevelTable],
    callback: Callable[[float], None] | None,
) -> tuple[LatticeProblem, _BasisSearch] | None:
    """Compute levels in ever larger bases. Return None, or the problem and the search with which to begin again."""
    before: tuple[np.ndarray, np.ndarray] | None = None
    try:
        problem, top, limit, cover = interruptible(_searched, system.model, problem, count, search)
        limit = min(limit, search.cap)
    except BasisTooLarge as reason:
        raise ValueError(f"count = {count} needs {reason}") from None
    for k, cut in enumerate(CUTS):
        shortest = problem.bottom + cut * (top - problem.bottom)
        try:
            grid, limit = interruptible(_basis, problem, shortest, top, limit, k)
            found, missed, left, size, *states = interruptible(lowest, grid, problem, shortest, count)
        except BasisTooLarge as reason:
            if limit == math.inf and (joint := interruptible(_joint, problem, top, shortest)) < math.inf:
                return problem, search._replace(cap=joint)
            if k > 1:
                return None
            if before is not None and (most := _lower(float(before[0][-1]), top, problem.bottom)) > search.least:
                return problem, search._replace(most=most)
            if search.spare > FEW:
                return problem, search._replace(spare=FEW)
            raise ValueError(f"count = {count} needs {reason}") from None
        if found[-1] > limit:
            raise NoGroundState(_unbound(problem, count, int((found < limit).sum()), limit))
        if found[-1] > top:  # other wells may hold levels below that
            least = min(float(found[-1]) + ABOVE * (top - problem.bottom), (float(found[-1]) + limit) / 2)
            return problem, search._replace(least=least)
        bound = missed + left + ROUNDING * (np.abs(found) + shortest - problem.bottom)
        error = _agreed(found, bound, before) + lost(problem, cover, grid, top, found)
        error[missed > HELD * (shortest - problem.bottom)] = np.inf
        # What a basis lacks enters energies in second order, waves in first: a basis after the last change has them.
        allowed = tolerance * level_scale(found)
        settled = before is not None and bool(np.all(np.abs(found - before[0]) <= SETTLED * allowed))
        last = (settled and bool(np.all(error <= allowed))) or k == len(CUTS) - 1
        if grid.leak.any() and k > 0 and last:
            error += np.abs(interruptible(lowest, _shrunk(grid), problem, shortest, count).E - found)
        waves = LatticeWaves(system.model, _lattice(system, problem, grid), states[1], states[0])
        said = ONLY_SAMPLES if cover.blind else ""
        known.append(_table(found, error, tolerance, size, hbar, limit, said, waves))
        if callback is not None:
            callback((k + 1) / len(CUTS))
        if last:
            break
        before = found, bound
    return None


def _lower(E: float, top: float, bottom: float) -> float:
    """Return a top energy nearer to the highest level E of a basis, -infinity if the top is near.

    Phase space counts few states of wells narrower than a wave, and wells above may take most of the grid.
    """
    return E + ABOVE * (top - E) if top - E > ABOVE * (top - bottom) else -math.inf


def _check_held(levels: LevelTable) -> None:
    """Raise ValueError for levels without any bound."""
    if not np.isfinite(levels.error[0]):
        raise ValueError(
            f"model must have wells as wide as the steps of a grid, which {levels.functions} functions do not "
            "resolve. Try closer scales of the coordinates."
        )


def _searched(
    model: Any, problem: LatticeProblem, count: int, search: _BasisSearch
) -> tuple[LatticeProblem, float, float, WellCover]:
    """Return the problem with all wells, the energies of `_range`, the first within its bounds, and its cover."""
    for _ in range(SEARCHES):
        problem = _turned(problem)
        top, limit = _range(problem, count, search.spare)
        top = max(min(top, search.most), search.least)
        try:
            grid = _grid(problem, top, 4 * (top - problem.bottom))
        except Open:
            raise BasisTooLarge(f"a grid of more than {POINTS[len(problem.wells) - 1]} points") from None
        cover = vibration_cover(model, problem, top, grid.step)
        more = more_wells(problem, cover, grid, top)
        if more.values.size == problem.values.size:
            break
        problem = more
    return problem, top, limit, cover


def _problem(system: System, hbar: float) -> LatticeProblem:
    n = system.n
    W = system.inverse_masses(np.ones((2 * n, 1)))[..., 0]
    periods = np.array(system.periods)
    mixed = W - np.diag(np.diagonal(W))
    if np.linalg.eigvalsh(W)[0] <= 0 or mixed[periods > 0].any():
        what = "positive masses" if not mixed[periods > 0].any() else "no product of momenta with that of an angle"
        raise ValueError(f"model must have {what} in its kinetic energy, got dv/dp = {W.tolist()}")
    R = np.linalg.cholesky(W) * hbar

    potential = potential_of(system.model)

    def V(u: np.ndarray) -> np.ndarray:
        return potential(np.tensordot(R, u, 1))

    periods = periods / np.diagonal(R)
    wells, values = minima(walled(V, periods.tolist()), n)
    problem = LatticeProblem(V, wells, values, periods, R)
    names = system.names
    if _falls(names, potential, problem):  # a narrow well on a plain is met by no descent
        problem = _below(system.model, problem, float(potential(_far(np.zeros(n))).min()))
    if falls := _falls(names, potential, problem):
        raise NoGroundState(falls)
    if pole := _pole(names, problem):
        raise NoGroundState(pole)
    return problem


def _below(model: Any, problem: LatticeProblem, least: float) -> LatticeProblem:
    """Return the problem with the minima below an energy, which V has at some point."""
    start = problem._replace(wells=np.zeros((len(problem.R), 1)), values=np.array([least]))
    step = np.full(len(problem.R), np.inf)
    found = more_wells(start, vibration_cover(model, start, least, step), None, least)
    at = found.wells[:, found.values < least]
    values = found.values[found.values < least]
    wells = np.concatenate([at, problem.wells], axis=1)
    return problem._replace(wells=wells, values=np.concatenate([values, problem.values]))


def _far(at: np.ndarray) -> np.ndarray:
    """Return points (d, ways, distances) at all distances from one (d,)."""
    ways = np.array([way for way in itertools.product((0, 1, -1), repeat=len(at)) if any(way)]).T
    distances = np.geomspace(1e-8, 1e8, 65) * max(1.0, float(np.abs(at).max()))
    return np.asarray(at[:, None, None] + ways[:, :, None] * distances)


def _place(names: tuple[str, ...], q: np.ndarray) -> str:
    """Return coordinates in words."""
    return ", ".join(f"{name} = {x:.3g}" for name, x in zip(names, q, strict=True))


def _falls(names: tuple[str, ...], potential: Callable, problem: LatticeProblem) -> str:
    """Return the reason if no minimum was found, or V only falls from the lowest one."""
    known = problem.values.size > 0
    at = problem.R @ problem.wells[:, 0] if known else np.zeros(len(problem.R))
    least = problem.bottom if known else math.inf
    far = _far(at)
    V = potential(far)
    if known and not ((least >= V).all(axis=1) & (V[:, -1] < least)).any():
        return ""
    k = int(np.argmin(V))
    return (
        "V has no minimum, so it binds no level: it is unbounded below, or falls for ever; "
        f"at {_place(names, far.reshape(len(at), -1)[:, k])} it is {V.flat[k]:.3g}"
    )


def _pole(names: tuple[str, ...], problem: LatticeProblem) -> str:
    """Return the reason if V falls without end to its lowest place: by more on each nearer stretch."""
    d = len(problem.wells)
    at = problem.wells[:, :1]
    sizes = np.geomspace(1e-8, 1e-4, 3) * max(1.0, float(np.abs(at).max()))
    near, middle, far = problem.V(at[..., None] + np.eye(d)[..., None] * sizes).T
    with np.errstate(invalid="ignore"):
        fall = middle - near
        before = far - middle
        if not ((fall > STEEPER * before) & (before > 0)).all():
            return ""
        binds = bool((fall < SQUARE * before).all())
    what = "it falls slower than -1/r^2, so it binds levels" if binds else "there may be no lowest level"
    return f"V has a pole at {_place(names, problem.R @ at[:, 0])}, which no uniform grid holds: {what}."


def _lattice(system: System, problem: LatticeProblem, grid: LatticeGrid) -> PointLattice:
    """Return the points of a grid in the coordinates of the model."""
    names = system.row_names[: len(problem.R)]
    origin = problem.wells[:, 0]
    return PointLattice(names, grid.V.shape, grid.low, grid.step, origin, grid.around, problem.R)


def _grid(problem: LatticeProblem, wall: float, shortest: float, top: float = math.inf) -> LatticeGrid:
    """Return the grid of the wells below a wall, for waves up to the kinetic energy `shortest`; of one coordinate as
    far as waves of the energy `top` come. Raises Open where these have no end, or more points than may be.
    """
    d = len(problem.wells)
    around = problem.periods > 0
    step = np.full(d, math.pi / math.sqrt(2 * shortest))
    turn = np.where(around, 2 * np.ceil(problem.periods / step / 2) + 1, 0).astype(np.int64)
    step = np.where(around, problem.periods / np.maximum(turn, 1), step)
    at = np.rint((problem.wells[:, problem.values < min(wall, top)] - problem.wells[:, :1]) / step[:, None])
    if np.abs(at).max() > POINTS[-1]:
        raise Open
    at = at.astype(np.int64)
    low = np.where(around, 0, at.min(axis=1) - FIRST)
    high = np.where(around, turn - 1, at.max(axis=1) + FIRST)
    while np.prod((high - low + 1).astype(float)) <= POINTS[d - 1]:
        grid = _kept(problem, LatticeGrid(low, high, step, around), at, wall)
        if d == 1 and top < math.inf and not around[0]:
            grid = grid._replace(kept=grid.kept & _reached(grid.V, step[0], top))
        faces = [[grid.kept.take(end, axis=k).any() and not around[k] for k in range(d)] for end in (0, -1)]
        if not np.any(faces):
            return grid
        wide = np.ceil(WIDER * (high - low)).astype(np.int64)
        low = low - wide * faces[0]
        high = high + wide * faces[1]
    raise Open


def _reached(V: np.ndarray, step: float, energy: float) -> np.ndarray:
    """Return whether waves of an energy have more than rounding at the points of one coordinate. A wall that rises as
    log(q) is e^energy wide, and no wave comes far into it.
    """

    def since(V: np.ndarray) -> np.ndarray:
        """The powers of e from the last allowed point on."""
        whole = np.cumsum(np.minimum(step * np.sqrt(2 * np.maximum(V - energy, 0.0)), DECAY))
        return whole - np.maximum.accumulate(np.where(energy > V, whole, -np.inf))

    return np.minimum(since(V), since(V[::-1])[::-1]) < DECAY


def _kept(problem: LatticeProblem, grid: LatticeGrid, at: np.ndarray, wall: float) -> LatticeGrid:
    """Return the grid with V, and keep the points below a wall that are connected to wells at lattice points `at`."""
    from scipy.ndimage import label

    V = problem.V(grid.points(problem.wells))
    parts = _joined(label(wall > V)[0], grid.around)
    shape = np.array(V.shape)[:, None]
    place = np.where(grid.around[:, None], at % shape, at - grid.low[:, None])
    inside = ((place >= 0) & (place < shape)).all(axis=0)
    return grid._replace(V=V, kept=np.isin(parts, np.setdiff1d(parts[tuple(place[:, inside])], 0)), at=at, wall=wall)


def _widened(problem: LatticeProblem, grid: LatticeGrid, shortest: float) -> LatticeGrid:
    """Return a wider grid. It keeps all points below `shortest` from which V falls into the wells of a grid; points
    from which V falls elsewhere are its `leak`.

    A wall close below the energy from where on wells have no end would cut waves at their other sides too.
    """
    extent = [np.flatnonzero(grid.kept.any(axis=tuple({*range(grid.kept.ndim)} - {k}))) for k in range(grid.kept.ndim)]
    low, high = (grid.low + np.array([side[end] for side in extent]) for end in (0, -1))
    wide = np.ceil((high - low) * WIDER / 4).astype(np.int64)
    low = np.where(grid.around, grid.low, low - wide)
    high = np.where(grid.around, grid.high, high + wide)
    most = POINTS[grid.kept.ndim - 1]
    if np.prod((high - low + 1).astype(float)) > most:
        raise BasisTooLarge(f"a grid of more than {most} points")
    wider = _kept(problem, grid._replace(low=low, high=high), grid.at, grid.wall)
    falls = wider.kept.ravel()[_fallen(wider.V, grid.around)].reshape(wider.V.shape)
    below = shortest > wider.V
    return wider._replace(kept=falls & below, leak=below & ~falls)


def _fallen(V: np.ndarray, around: np.ndarray) -> np.ndarray:
    """Return the index (points,) of the lattice minimum that V falls to from each point, by its lowest neighbours."""
    index: np.ndarray = np.arange(V.size).reshape(V.shape)
    lowest = V
    best: np.ndarray = index
    for shift in itertools.product((-1, 0, 1), repeat=V.ndim):
        there = np.roll(V, shift, range(V.ndim))
        number = np.roll(index, shift, range(V.ndim))
        for k in np.flatnonzero(np.array(shift) * ~around):
            there[(slice(None),) * k + ((0 if shift[k] > 0 else -1),)] = np.inf
        better = there < lowest
        lowest = np.where(better, there, lowest)
        best = np.where(better, number, best)
    best = best.ravel()
    while not np.array_equal(further := best[best], best):
        best = further
    return best


def _joined(parts: np.ndarray, around: np.ndarray) -> np.ndarray:
    """Return numbers of connected parts; parts that join across the ends of a periodic axis have one number."""
    for k in np.flatnonzero(around):
        for one, other in {*zip(parts.take(0, axis=k).ravel().tolist(), parts.take(-1, axis=k).ravel().tolist())}:
            if one and other:
                parts = np.where(parts == other, parts[parts == one][0] if (parts == one).any() else one, parts)
    return parts


def _range(problem: LatticeProblem, count: int, spare: float) -> tuple[float, float]:
    """Return an energy with `spare` more states below it than are asked for, and the energy from which wells have no
    end, infinite if none was met.
    """
    bottom = problem.bottom
    limit = math.inf

    def states(room: float) -> float:
        return _grid(problem, bottom + room, 4 * room).states(bottom + room)

    room = _ground(problem)
    wanted = (1.1 if spare == SPARE else 1.0) * count + spare
    if not bottom < bottom + room < math.inf:
        raise NoGroundState(f"V falls to {bottom:.3g} within a point, or is flat: levels need a well")
    while True:
        try:
            enough = states(room) >= wanted
        except Open:
            limit = _limit(problem, bottom, bottom + room)
            bound = states(limit - bottom) if limit > bottom else 0.0
            if bound < count - 0.5:
                raise NoGroundState(_unbound(problem, count, bound, limit)) from None
            wanted = min(wanted, (count + bound) / 2)
            break
        if enough:
            break
        room *= GROW
    low = 0.0
    high = min(room, limit - bottom)
    for _ in range(HALVINGS // 3):
        middle = (low + high) / 2
        low, high = (low, middle) if states(middle) >= wanted else (middle, high)
    zero, _ = _zero_points(problem)
    if zero.max() > STIFF * high:  # phase space counts no zero-point energy
        raised = high + float(zero.sum())
        try:
            states(raised)
        except Open:
            if limit == math.inf and not _endless(problem, bottom + raised):
                raise BasisTooLarge(f"a grid of more than {POINTS[len(problem.wells) - 1]} points") from None
            limit = min(limit, _limit(problem, bottom + high, bottom + raised))
        high = min(raised, (high + limit - bottom) / 2)
    return bottom + high, limit


def _endless(problem: LatticeProblem, energy: float) -> bool:
    """Whether V is below an energy at the largest distances from the origin, along axes and diagonals."""
    return bool((problem.V(_far(np.zeros(len(problem.wells)))[..., -1]) < energy).any())


def _zero_points(problem: LatticeProblem) -> tuple[np.ndarray, np.ndarray]:
    """Return zero-point energies (d,) of the lowest well in the directions of its axes (d, d), columns. The curvature
    is that of V over the width of the well in its stiffest direction.
    """
    at = problem.wells[:, :1]
    d = len(problem.wells)
    free = problem.periods == 0
    axes = np.eye(d)
    sizes = np.geomspace(1e-8, 1e8, 321) * max(1.0, float(np.abs(at).max()))

    def widths(ways: np.ndarray) -> np.ndarray:
        """Return how far (ways,) a wave of V's own size comes from the bottom along directions (d, ways)."""
        rise = problem.V(at[..., None] + ways[..., None] * sizes) - problem.bottom
        reached = rise >= 0.5 / sizes**2
        return sizes[np.where(reached.any(axis=1), reached.argmax(axis=1), -1)]

    random = np.random.default_rng(SEED).standard_normal((d, DIRECTIONS)) * free[:, None]
    lengths = np.sqrt((random**2).sum(axis=0))
    ways = np.concatenate([axes, -axes, random[:, lengths > 0] / lengths[lengths > 0]], axis=1)
    step = float(widths(ways).min())
    pairs = step * (axes[:, :, None] + axes[:, None, :]) / 2
    crossed = step * (axes[:, :, None] - axes[:, None, :]) / 2
    V = [problem.V(at[..., None] + place) for place in (pairs, -pairs, crossed, -crossed)]
    bend = (V[0] + V[1] - V[2] - V[3]) / step**2
    if np.isfinite(bend).all():
        bend = np.where(free[:, None] & free, bend, np.diag(np.diagonal(bend)))
        axes = np.linalg.eigh(bend)[1][:, ::-1]
        if not free.all():  # each axis keeps its place
            axes = np.eye(d)
    both = widths(np.concatenate([axes, -axes], axis=1)).reshape(2, d)
    return 0.5 / np.maximum(both.prod(axis=0), 1e-200), axes


def _turned(problem: LatticeProblem) -> LatticeProblem:
    """Return a problem whose coordinates u are along the axes of the lowest well, if these are much unlike: the grid of
    a narrow valley aslant would be as wide as it is long.
    """
    zero, axes = _zero_points(problem)
    along = np.abs(axes).max(axis=0).min() > ALONG
    if along or zero.max() < ROUND * zero.min() or (problem.periods > 0).any():
        return problem

    def V(u: np.ndarray) -> np.ndarray:
        return problem.V(np.tensordot(axes, u, 1))

    return problem._replace(V=V, wells=axes.T @ problem.wells, R=problem.R @ axes)


def _ground(problem: LatticeProblem) -> float:
    """Return the energy above the bottom of waves as short as V is narrow."""
    sizes = np.geomspace(1e-8, 1e8, 321) * max(1.0, float(np.abs(problem.wells[:, 0]).max()))
    axes = np.concatenate([np.eye(len(problem.wells)), -np.eye(len(problem.wells))])
    rise = np.array([problem.V(problem.wells[:, :1] + axis[:, None] * sizes) for axis in axes]) - problem.bottom
    reached = rise >= 0.5 / sizes**2
    first = sizes[np.where(reached.any(axis=1), reached.argmax(axis=1), -1)]
    return float(0.5 / max(float(first.max()), 1e-100) ** 2)


def _limit(problem: LatticeProblem, low: float, high: float) -> float:
    """Return the energy, above `low` and below `high`, from which the allowed region has no end."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        try:
            _grid(problem, middle, 4 * (middle - problem.bottom))
            low = middle
        except Open:
            high = middle
    return low


def _joint(problem: LatticeProblem, low: float, high: float) -> float:
    """Return the energy between two from which on the wells that are below the first join others, infinite if none."""
    others = problem.wells[:, (problem.values >= low) & (problem.values < high)]
    if not others.size:
        return math.inf

    def joined(wall: float) -> bool:
        try:
            grid = _grid(problem, wall, 4 * (low - problem.bottom), low)
        except Open:
            return True
        index = np.rint((others - problem.wells[:, :1]) / grid.step[:, None]).astype(np.int64)
        index = np.where(grid.around[:, None], index % np.array(grid.V.shape)[:, None], index - grid.low[:, None])
        index = index[:, ((index >= 0) & (index < np.array(grid.V.shape)[:, None])).all(axis=0)]
        return bool(grid.kept[tuple(index)].any())

    if joined(low) or not joined(high):
        return math.inf
    for _ in range(HALVINGS // 2):
        middle = (low + high) / 2
        low, high = (low, middle) if joined(middle) else (middle, high)
    return low


def _basis(problem: LatticeProblem, shortest: float, top: float, limit: float, k: int) -> tuple[LatticeGrid, float]:
    """Return the grid of basis k, and the energy from which wells have no end."""
    if limit == math.inf:
        try:
            return _grid(problem, shortest, shortest - problem.bottom, top), limit
        except Open:
            limit = _limit(problem, top, shortest)
    try:
        grid = _grid(problem, limit - (limit - top) * NEARER ** (k + 1), shortest - problem.bottom, top)
    except Open:
        raise BasisTooLarge(f"a grid of more than {POINTS[len(problem.wells) - 1]} points") from None
    return _widened(problem, grid, shortest), limit


def _shrunk(grid: LatticeGrid) -> LatticeGrid:
    """Return a grid without the points next to its leak."""
    from scipy.ndimage import binary_dilation

    return grid._replace(kept=grid.kept & ~binary_dilation(grid.leak, np.ones([3] * grid.V.ndim), iterations=2))


def _agreed(E: np.ndarray, bound: np.ndarray, before: tuple[np.ndarray, np.ndarray] | None) -> np.ndarray:
    """Return the errors of levels with bounds, given levels and bounds of the basis before. A residual bounds the
    distance to a level of any number: only a second basis tells that none is missing.
    """
    if before is None:
        return np.full_like(bound, np.inf)
    gap = np.abs(E - before[0])
    return np.where(gap > bound + before[1], np.maximum(APART * gap, bound), bound)


def _unbound(problem: LatticeProblem, count: int, bound: float, limit: float) -> str:
    """Return the reason why fewer levels than `count` are computed: their number below the limit is `bound`."""
    why = "have no end, behind a saddle, where V ends or along its bottom"
    if not _endless(problem, limit + VALLEY * (limit - problem.bottom)):
        why = "lie too far apart for one grid"
    if bound >= 0.5:
        return f"from {limit:.6g} on the wells of V {why}: about {bound:.0f} levels are below that; count = {count}"
    if _endless(problem, problem.bottom):
        return (
            "no well of V holds a level: at this hbar waves are as long as the wells, which have no end behind a "
            f"saddle, where V ends or along its bottom; give a smaller hbar; count = {count}"
        )
    if limit - problem.bottom <= VALLEY * (abs(limit) + abs(problem.bottom)):
        return (
            "V stays at its bottom along valleys without end, or in many wells, which no grid holds; levels may exist "
            f"all the same: count = {count}"
        )
    return (
        f"the wells below V = {limit:.6g} hold about {bound:.1g} states of phase space: waves of so weakly bound "
        f"levels are too wide for a grid; count = {count}"
    )


def _table(
    E: np.ndarray, error: np.ndarray, tolerance: float, size: int, hbar: float, limit: float, said: str, waves: Any
) -> LevelTable:
    wall = (
        f"; walls below {limit:.6g}, from where on the wells of V join others or have no end"
        if limit < math.inf
        else ""
    )
    return class_levels(
        SymmetryClass(0, 0),
        E,
        error,
        np.arange(E.size)[None],
        tolerance,
        names=("level",),
        constants=np.zeros((0, E.size)),
        constant_names=(),
        hbar=hbar,
        method=f"{VIBRATION}, truncated coordinate by coordinate{wall}{said}",
        functions=size,
        waves=waves,
    )
