"""Basins of attraction: the attractors of many initial conditions, and which of them each orbit comes to."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, Passes, number_of_steps, shown, titled
from ..core.status import Status, counted, describe
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.result import Result, along
from ..runs.options import Options, Problem
from ..runs.requirements import checked_tangent_system
from ..runs.scales import typical_rate
from ..runs.schemes.catalogue import DOP853, Scheme, scheme_of
from ..runs.starts import starts_of
from ..systems.formulas.forced import PHASE
from ..systems.models.contracts import Dynamics
from ..systems.models.mechanics import System
from .chaos_map import chaos_map
from .closing import Candidates, Closed, closed_orbits
from .indicators import LyapunovSpectrum
from .recurrence import CellBox, Recurrent, known, recurrent_sets, settled_in
from .settling import Motion, Trapped
from .shares import Shares

ESCAPED = -1
"""Label of orbits that leave."""

UNDECIDED = -2
"""Label of orbits that have come to no attractor."""

SCOUTS = 128
"""Orbits at once from whose ends attractors are sought, evenly spaced in their order."""

ROUNDS = 8
"""Number of times that orbits without an attractor are searched for new ones."""

WINDOW = 128
"""Intervals at the end of a run that are compared."""

LEAST = 16
"""Least number of intervals of a run."""

MOST = 2**16
"""Largest number of intervals of a run of a system without intervals of its own."""

FINE = 16
"""Parts of an interval between states of an orbit whose period is unknown."""

RETURNING = 0.05
"""Largest distance of states that may be a period apart, in units of the rows."""

TRIED = 2
"""Nearest returns of an orbit that are tried."""

LONG = (4096, 16384)
"""Least and largest number of intervals of the long runs that show recurrence; between, LONGER times the run."""

LONGER = 4
"""Long runs in units of the run of an orbit."""

STAYERS = 32
"""Orbits of long runs."""

BATCH = 2**18
"""Orbits that are run at once."""

OF_STARTS = 0.1
"""Least unit of a row, in extents of the initial conditions."""

FAR = 1e6
"""Distance, in extents of the initial conditions, beyond which an orbit whose steps become too small has escaped."""

SUGGESTED = 4.0
"""Factor of the suggested time over the time of the run."""

FEW = 32
"""Least number of cells of a quasi-periodic set: a cycle that orbits come to slowly has fewer."""

STEADY = 0.01
"""Largest relative change of the ranges of a quasi-periodic set between halves of a run."""

WEAK = 3.0
"""Growth of deviation vectors over the run, as a logarithm, that an orbit without chaos may show."""


class AttractorKind(IntEnum):
    """Kind of an attractor.

    Attributes
    ----------
    FIXED_POINT : 0
        A fixed point of a map, or an equilibrium.
    PERIODIC : 1
        A periodic orbit: a cycle of a map, a limit cycle, an orbit of one or more periods of a drive.
    QUASI_PERIODIC : 2
        A set that orbits visit again and again, with a largest exponent of 0 within its error.
    CHAOTIC : 3
        Such a set with a positive exponent.
    """

    FIXED_POINT = 0
    PERIODIC = 1
    QUASI_PERIODIC = 2
    CHAOTIC = 3


@dataclass(frozen=True)
class Basins(Result):
    """Attractors, and the attractor that each orbit comes to.

    Attributes
    ----------
    z0 : ndarray, shape (2n, orbits)
        Initial conditions.
    label : ndarray of int, shape (orbits,)
        Number of the attractor; -1 for orbits that escape, -2 for undecided ones.
    settling_time : ndarray, shape (orbits,)
        Time after which an orbit was near its attractor, or had escaped: NaN for undecided orbits. For sets that are
        not periodic it is the length of the run.
    suggested_time : ndarray, shape (orbits,)
        Length of a run that may decide undecided orbits; NaN for others.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit.
    kind : ndarray of int, shape (attractors,)
        `AttractorKind` of each attractor, that with most orbits first.
    period : ndarray, shape (attractors,)
        Minimal period in units of time, for a map in iterates: 0 for an equilibrium, NaN for sets that are not
        periodic.
    points : ndarray, shape (2n, points, attractors)
        States on each attractor; NaN after the last one.
    error : ndarray, shape (2n, attractors)
        Error estimate of the first point of a periodic orbit; NaN for other sets.
    exponent : ndarray, shape (attractors,)
        Largest Lyapunov exponent per unit time; that across the flow for a limit cycle.
    exponent_error : ndarray, shape (attractors,)
        Error estimate of `exponent`.
    time : float
        Length of the run.
    interval : float
        Time between comparisons with the attractors.
    names : tuple of str
        Names of the rows.
    scheme : Scheme
        Integration method.
    step : float or ndarray, shape (orbits,)
        Step size, in units of time; inf for an adaptive method.
    stepwise : bool
        Whether states are compared once per iterate of a map or once per period of a drive.
    """

    z0: Annotated[np.ndarray, along("coordinate", "orbit", labels="names", plain=True)]
    label: Annotated[np.ndarray, along("orbit")]
    settling_time: Annotated[np.ndarray, along("orbit", unit="time")]
    suggested_time: Annotated[np.ndarray, along("orbit", unit="time")]
    status: Annotated[np.ndarray, along("orbit")]
    kind: Annotated[np.ndarray, along("attractor")]
    period: Annotated[np.ndarray, along("attractor", unit="time")]
    points: Annotated[np.ndarray, along("coordinate", "point", "attractor")]
    error: Annotated[np.ndarray, along("coordinate", "attractor")]
    exponent: Annotated[np.ndarray, along("attractor", unit="1/time")]
    exponent_error: Annotated[np.ndarray, along("attractor", unit="1/time")]
    time: float
    interval: float
    names: tuple[str, ...]
    scheme: Scheme
    step: Annotated[float | np.ndarray, along("orbit", unit="time")]
    stepwise: bool = False

    @property
    def escaped(self) -> np.ndarray:
        """Mask of the orbits that escape, shape (orbits,)."""
        return self.label == ESCAPED

    @property
    def undecided(self) -> np.ndarray:
        """Mask of the undecided orbits, shape (orbits,), failed and unfinished ones among them."""
        return self.label == UNDECIDED

    @property
    def attractor_names(self) -> tuple[str, ...]:
        """Name of each attractor: its kind, with its period, and a number where several have the same name."""
        found = [self._name(k) for k in range(self.kind.size)]
        return tuple(
            f"{name} ({found[: k + 1].count(name)})" if found.count(name) > 1 else name for k, name in enumerate(found)
        )

    def _name(self, k: int) -> str:
        kind = AttractorKind(int(self.kind[k]))
        if kind == AttractorKind.PERIODIC:
            if self.stepwise:
                return f"period {round(self.period[k] / self.interval)}"
            return f"limit cycle, period {self.period[k]:.4g}"
        return kind.name.lower().replace("_", "-" if kind == AttractorKind.QUASI_PERIODIC else " ")

    @property
    def counts(self) -> np.ndarray:
        """Numbers of orbits of each attractor, then of those that escape, shape (attractors + 1,)."""
        return np.array([*(np.count_nonzero(self.label == k) for k in range(self.kind.size)), self.escaped.sum()])

    @property
    def shares(self) -> np.ndarray:
        """Shares of the attractors, then of escape, among the decided orbits, shape (attractors + 1,)."""
        return self._shares.fraction

    @property
    def intervals(self) -> np.ndarray:
        """95 % intervals of `shares`, shape (2, attractors + 1), for initial conditions drawn at random.

        The shares of a regular grid of as many points have smaller errors.
        """
        return self._shares.interval()

    @property
    def bounds(self) -> np.ndarray:
        """Shares of all orbits if no undecided orbit, and if all, came to the attractor, shape (2, attractors + 1)."""
        return self._shares.bounds

    @property
    def _shares(self) -> Shares:
        counts = self.counts
        undecided = int(self.undecided.sum())
        return Shares(counts, counts.sum() - counts, np.full(counts.shape, undecided))

    @property
    def entropy(self) -> float:
        """Entropy of the shares, in nats: 0 for one basin, ln m for m equal ones."""
        share = self.shares[self.shares > 0]
        return float(-(share * np.log(share)).sum()) + 0.0

    def summary(self) -> str:
        """Return one line with the attractors and their shares with 95 % intervals, or bounds if orbits are undecided.

        Returns
        -------
        str
            Summary.
        """
        names = [*self.attractor_names, "escaped"]
        known = not self.undecided.any()
        low, high = self.intervals if known else self.bounds
        told = [
            f"{name} {share:.3g} ({low[k]:.3g} to {high[k]:.3g})" if known else f"{name} {low[k]:.3g} to {high[k]:.3g}"
            for k, (name, share) in enumerate(zip(names, self.shares, strict=True))
            if self.counts[k]
        ]
        parts = [counted(self.label.size, "orbit"), *told]
        if not known:
            parts.append(f"{int(self.undecided.sum())} undecided, time {SUGGESTED * self.time:.3g} may decide")
        failed = self.undecided & (self.status != Status.OK)
        if failed.any():
            parts.append(describe(self.status[failed]))
        return "; ".join(parts)


@coerces_arguments(z0=starts_of, scheme=scheme_of)
@records_call
@inserts_parameters
def basins(
    model: Dynamics,
    z0: Starts,
    *,
    time: float,
    step: float | np.ndarray | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-9,
    atol: float = 1e-9,
    threads: int | None = None,
    callback: Callback | None = None,
) -> Basins:
    """Find the attractors of orbits and the attractor that each orbit comes to.

    Parameters
    ----------
    model : model
        System that loses volume of its state space: an ODE system, a Hamiltonian system with friction, with or without
        a drive, or a map that is not symplectic.
    {z0}
    time : float
        Longest run of an orbit, in units of time; for a map the number of iterates. Orbits that have not settled by
        then are undecided.
    step : float or array_like, shape (orbits,), optional
        Fixed step size, in units of time. For an adaptive method it is the first step.
    scheme : Scheme or str, optional
        Integration method or its name, for example ``"VERNER9"``. Default: DOP853; with a step KAHAN_LI8, or GAUSS16
        for nonseparable Hamiltonians.
    rtol : float, default 1e-9
        Relative tolerance of an adaptive method.
    atol : float, default 1e-9
        Absolute tolerance of an adaptive method.
    {threads}
    {callback}

    Returns
    -------
    `Basins`
        Label of each orbit; attractors with kind, period, states and exponent; shares with 95 % intervals.

    Raises
    ------
    ValueError
        If a value is out of its range, or initial conditions of a driven system have different phases.
    TypeError
        If an argument is of a wrong kind, or the model has no attractors.
    Interrupted
        On Ctrl-C, with the orbits labelled so far in ``.partial``.

    Notes
    -----
    - Periodic attractors: Newton's method from the ends of 128 orbits, then of orbits without a label. Neighbours in
      all directions give the radius of a tube that keeps them; an orbit within the tube has its label at once.
    - Other attractors: cells that long runs visit again and again. A set that one of 32 long runs leaves is transient.
      An orbit has its label if the last states of its run are in these cells and typical of them.
    - Escape: an orbit that leaves the domain, or becomes infinite.
    - Never decided: attractors within 1e-5 of a bifurcation per period, and sets that no orbit has come to.
    - Attractors depend on the set of orbits.

    References
    ----------
    Datseris & Wagemakers 2022, Chaos 32, 023104 (recurrences); Nusse & Yorke 1996, Science 271, 1376 (trapping
    regions).

    Examples
    --------
    >>> well = fa.hamiltonian("x**4/4 - x**2/2", coordinates="x", friction=0.5)
    >>> grid = fa.energy_grid(well, axes={"x": np.linspace(-2, 2, 40), "p_x": np.linspace(-2, 2, 40)})
    >>> found = fa.basins(well, grid, time=200.0)
    >>> found.attractor_names, np.sort(found.points[0, 0]).round(6)
    (('fixed point (1)', 'fixed point (2)'), array([-1.,  1.]))
    """
    system = checked_tangent_system(model)
    if scheme is None and step is None and not system.iterated:
        scheme = DOP853
    problem = Problem(model, z0, Options(scheme, step, rtol=rtol, atol=atol, threads=threads, callback=callback))
    length = problem.iterates("time", time)
    if system.symplectic or system.conserves:
        raise TypeError(f"{titled('model', model)} must lose volume of its state space, got a conservative system. "
                        "Use chaos_map.")  # fmt: skip
    plan = problem.suited().plan()
    motion, count = _motion(system, plan.flow, plan.z, length)
    with Passes(callback) as passes:
        options = {"scheme": plan.flow.scheme, "rtol": rtol, "atol": atol, "threads": threads}
        search = _Search(motion, plan.z, count, options=options)
        with partial_result_on_interrupt("basins", lambda: search.result(length, step, unfinished=True)):
            search.search(passes)
        return search.result(length, step, unfinished=False)


def _motion(system: System, flow: Any, z: np.ndarray, time: float) -> tuple[Motion, int]:
    """Return the motion with its interval, and the number of intervals in a time."""
    rows = z.shape[0]
    phase, interval = _drive(system, z)
    kept = np.setdiff1d(np.arange(system.rows), [*phase])
    if interval > 0:
        number_of_steps(time, interval)
        count = math.floor(time / interval * (1 + 1e-12))
    else:
        some = np.unique(np.linspace(0, z.shape[1] - 1, SCOUTS).astype(int))
        count = int(np.clip(math.ceil(time * typical_rate(system, z[:, some])), 4 * LEAST, MOST))
        interval = time / count
    if count < LEAST:
        raise ValueError(f"time must be at least {LEAST * interval:.6g}, {LEAST} intervals, got {shown(time)}.")
    periods = np.zeros(rows)
    own = system.model.periods() if system.iterated else system.periods
    periods[: len(own)] = own
    periods[[*phase]] = 0.0
    stepwise = bool(phase) or system.iterated
    return Motion(flow.fitted(interval), interval, kept, periods, np.ones(rows), stepwise, phase), count


def _drive(system: System, z: np.ndarray) -> tuple[dict[int, float], float]:
    """Return the values of the rows of a drive at the start, and its period: 1 for a map, 0 for no drive."""
    if system.iterated:
        return {}, 1.0
    if system.driven:
        rows = system.moving, z.shape[0] - 1
        period = float(system.model.period)
        _one_phase(z[rows[0]], period)
        return {rows[0]: float(z[rows[0], 0]), rows[1]: 0.0}, period
    if system.canonical or system.row_names[-2:] != PHASE:
        return {}, 0.0
    last = system.rows - 2, system.rows - 1
    rates = system.slopes(z)
    cosine, sine = z[[*last]]
    speed = (cosine * rates[last[1]] - sine * rates[last[0]]) / (cosine**2 + sine**2)
    if not np.ptp(speed) <= 1e-12 * np.abs(speed).max():
        return {}, 0.0
    _one_phase(np.arctan2(sine, cosine), 2 * np.pi)
    return {row: float(z[row, 0]) for row in last}, float(2 * np.pi / abs(speed[0]))


def _one_phase(phase: np.ndarray, period: float) -> None:
    """Refuse initial conditions of different phases (orbits,) of a drive."""
    if np.ptp(phase) > 1e-12 * period:
        raise ValueError(f"z0 must have one phase of the drive, got {phase.min():g} to {phase.max():g} of {period:g}.")


@dataclass
class _Set:
    """A set of cells with its exponent and the error of that."""

    cells: Recurrent
    exponent: float
    error: float
    chaotic: bool


class _Attractor(NamedTuple):
    """An attractor as the result has it, with states (rows, points)."""

    kind: AttractorKind
    period: float
    points: np.ndarray
    error: np.ndarray
    exponent: float
    exponent_error: float


@dataclass
class _Search:
    """A search under way: arrays over orbits, and the attractors found so far."""

    motion: Motion
    z0: np.ndarray
    count: int
    options: dict[str, Any]
    closed: list[Closed] = field(default_factory=list)
    sets: list[_Set] = field(default_factory=list)
    frame: CellBox | None = None
    extent: np.ndarray = field(init=False)
    end: np.ndarray = field(init=False)
    closed_label: np.ndarray = field(init=False)
    set_label: np.ndarray = field(init=False)
    time: np.ndarray = field(init=False)
    status: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        orbits = self.z0.shape[1]
        self.window = min(WINDOW, self.count // 2)
        self.end = self.z0.copy()
        self.closed_label = np.full(orbits, -1)
        self.set_label = np.full(orbits, -1)
        self.time = np.zeros(orbits)
        self.status = np.full(orbits, int(Status.INTERRUPTED))
        self.extent = self._extents(self.z0)

    def _extents(self, z: np.ndarray) -> np.ndarray:
        """Return the extents (rows,) of states (rows, orbits); those of an angle are half of its period."""
        periods = self.motion.periods
        return np.where(periods > 0, periods / 2, np.ptp(z, axis=1))

    def search(self, passes: Passes) -> None:
        """Find attractors and label orbits."""
        scouts = _spaced(np.arange(self.z0.shape[1]), SCOUTS)
        early = self._of(scouts).run(self.z0[:, scouts], self.count, [], passes.take(0.1, 1.0))
        settled = early.z[:, early.status == Status.OK]
        motion = self._of(scouts[early.status == Status.OK])
        self._set_scale(motion, settled)
        if settled.shape[1]:
            self._close(motion, settled)
        self._run(np.arange(self.z0.shape[1]), self.count, passes.take(0.8, 0.2))
        for _ in range(ROUNDS):
            rest = self._rest()
            some = _spaced(rest, SCOUTS)
            if not rest.size or not self._close(self._of(some), self.end[:, some]):
                break
            self._run(rest, self.window, None)
        for _ in range(ROUNDS):
            rest = self._rest()
            if not rest.size or not self._recur(rest):
                break

    def _of(self, orbits: np.ndarray) -> Motion:
        """Return the motion of some of the orbits, with their steps."""
        return self.motion.of(self.motion.flow.of(orbits))

    def _set_scale(self, motion: Motion, settled: np.ndarray) -> None:
        """Set the units of the rows: the extents of the last states of orbits, and no less than OF_STARTS."""
        found = np.zeros(len(self.extent))
        if settled.shape[1]:
            states, _ = motion.window(settled, self.window)
            fine = states[:, :, np.isfinite(states).all(axis=(0, 1))]
            found = self._extents(fine.transpose(1, 0, 2).reshape(len(found), -1)) if fine.size else found
        scale = np.maximum(found, OF_STARTS * self.extent)
        kept = self.motion.kept
        size = np.abs(self.z0).max(axis=1)
        least = scale[kept].max() or size[kept].max() or 1.0
        self.motion.scale = np.where(scale > 0, scale, least)

    def _close(self, motion: Motion, z: np.ndarray) -> bool:
        """Seek periodic attractors from states (rows, orbits); return whether there are new ones."""
        motion = self.motion.of(_one_step(motion.flow))
        before = len(self.closed)
        for guesses in self._guesses(motion, z):
            if guesses.time.size:
                for orbit in closed_orbits(motion, guesses, LONGER * self.count * motion.interval):
                    if not any(one.has(motion, orbit.point[:, None])[0] for one in self.closed):
                        self.closed.append(orbit)
        return len(self.closed) > before

    def _guesses(self, motion: Motion, z: np.ndarray) -> list[Candidates]:
        """Return guesses of periodic orbits near states (rows, orbits)."""
        if motion.stepwise:
            states, _ = motion.window(z, self.window)
            return [_returns(motion, states[::-1], self.window // 2, motion.interval, False)]
        points = Candidates(z, np.full(z.shape[1], motion.interval), False)
        fine, _ = motion.window(z, FINE * WINDOW, FINE)
        return [points, _returns(motion, fine, len(fine) - 1, motion.interval / FINE, True)]

    def _run(self, orbits: np.ndarray, count: int, callback: Callback | None) -> None:
        """Run orbits from their ends; label those that enter a tube."""
        tubes = [one.tube for one in self.closed]
        with Passes(callback) as passes:
            for first in range(0, orbits.size, BATCH):
                some = orbits[first : first + BATCH]

                def keep(found: Trapped, some: np.ndarray = some) -> None:
                    self.end[:, some] = found.z
                    self.closed_label[some] = found.tube
                    self.time[some] += found.time
                    self.status[some] = found.status

                told = passes.take(some.size, orbits.size - first - some.size)
                keep(self._of(some).run(self.end[:, some], count, tubes, told, keep))

    def _rest(self) -> np.ndarray:
        """Return the numbers of the orbits that have ended nowhere."""
        return np.flatnonzero((self.status == Status.OK) & (self.closed_label < 0) & (self.set_label < 0))

    def _recur(self, rest: np.ndarray) -> bool:
        """Seek sets of cells that orbits without a label visit, and label orbits; return whether there are new ones."""
        motion = self._of(rest)
        some = _spaced(rest, STAYERS)
        own = self._of(some)
        count = int(np.clip(LONGER * self.count, *LONG))
        states, _ = own.window(self.end[:, some], count)
        self.frame, found = recurrent_sets(own, self.frame, states, self.window)
        new = False
        for one in found:
            if not known(own, self.frame, [entry.cells for entry in self.sets], one):
                attracting = self._attracting(one, count * motion.interval)
                if attracting is not None:
                    self.sets.append(attracting)
                    new = True
        if new:
            self._assign(rest)
        return new

    def _attracting(self, one: Recurrent, time: float) -> _Set | None:
        """Return a set with its exponent if volumes shrink on it; one with a negative exponent is not known as closed,
        and left out.
        """
        system = self.motion.system
        z = one.states[-1].copy()
        chaos = chaos_map(
            system.model, z[: system.rows, None], time=time, indicators=(LyapunovSpectrum(),), **self.options,
            deviation_vectors=np.eye(system.rows),
        )  # fmt: skip
        if chaos.spectrum is None or chaos.spectrum_error is None or not np.isfinite(chaos.spectrum).all():
            return None
        spectrum = chaos.spectrum[:, 0]
        error = chaos.spectrum_error[:, 0]
        for exponent in self._of_drive(one.states[-1]):
            spectrum = np.delete(spectrum, np.argmin(np.abs(spectrum - exponent)))
        zero = np.maximum(error, WEAK / time)
        if not (spectrum.sum() < 0 or system.iterated):  # of a map that is not invertible volumes may grow
            return None
        chaotic = bool(spectrum[0] > zero[0])
        neutral = 0 if self.motion.stepwise else 1
        if not chaotic and (spectrum[neutral] < -zero[0] or one.cells.size < FEW or self._shrinks(one.states)):
            return None
        return _Set(one, float(spectrum[0]), float(error[0]), chaotic)

    def _shrinks(self, states: np.ndarray) -> bool:
        """Return whether states (states, rows) still change their range, as in slow convergence to a smaller set."""
        kept = states[:, self.motion.kept]
        first, second = (np.ptp(half, axis=0) for half in np.array_split(kept, 2))
        turns = self.motion.periods[self.motion.kept] > 0
        return bool((np.abs(first - second) > STEADY * np.maximum(first, second))[~turns].any())

    def _of_drive(self, z: np.ndarray) -> list[float]:
        """Return the exponents of the rows of a drive, over a period from a state (rows,)."""
        rows = [*self.motion.phase]
        if not rows:
            return []
        if self.motion.system.driven:
            return [0.0, 0.0]
        interval = self.motion.interval
        motion = self.motion.of(_one_step(self.motion.flow))
        matrix = motion.after(z[:, None], np.array([interval]))[1][0]
        with np.errstate(all="ignore"):
            return [float(np.log(np.abs(value)) / interval) for value in np.linalg.eigvals(matrix[np.ix_(rows, rows)])]

    def _assign(self, rest: np.ndarray) -> None:
        """Label orbits whose last states are in the cells of one set alone."""
        assert self.frame is not None
        cells = [one.cells for one in self.sets]
        for first in range(0, rest.size, BATCH):
            some = rest[first : first + BATCH]
            taken = settled_in(self._of(some), self.frame, cells, self.end[:, some], self.window, None)
            single = taken.sum(axis=0) == 1
            self.set_label[some[single]] = taken[:, single].argmax(axis=0)

    def _attractor(self, number: int) -> _Attractor:
        """Return what the result says of an attractor: those of tubes come first, then sets of cells."""
        rows = self.motion.system.rows
        if number < len(self.closed):
            one = self.closed[number]
            points = one.tube.points[:rows]
            single = points.shape[1] == 1 and not self.motion.phase
            kind = AttractorKind.FIXED_POINT if single else AttractorKind.PERIODIC
            return _Attractor(kind, one.period, points, one.error[:rows], one.exponent, one.exponent_error)
        other = self.sets[number - len(self.closed)]
        kind = AttractorKind.CHAOTIC if other.chaotic else AttractorKind.QUASI_PERIODIC
        points = other.cells.states[:, :rows].T
        return _Attractor(kind, math.nan, points, np.full(rows, math.nan), other.exponent, other.error)

    def result(self, time: float, step: Any, *, unfinished: bool) -> Basins:
        """Return the result so far."""
        system = self.motion.system
        rows = system.rows
        labels = np.where(self.closed_label >= 0, self.closed_label, UNDECIDED)
        labels = np.where(self.set_label >= 0, len(self.closed) + self.set_label, labels)
        left = np.isin(self.status, [entry for entry in Status if entry.left])
        with np.errstate(all="ignore"):
            away = (
                np.abs(self.end[self.motion.kept]) / np.where(self.extent > 0, self.extent, 1.0)[self.motion.kept, None]
            )
        left |= (self.status == Status.STEP_TOO_SMALL) & (away.max(axis=0) > FAR)
        labels = np.where(left, ESCAPED, labels)
        status = self.status.copy()
        if unfinished:
            status[(labels == UNDECIDED) & (status == Status.OK)] = Status.INTERRUPTED
        number = len(self.closed) + len(self.sets)
        order = np.argsort(-np.bincount(labels[labels >= 0], minlength=number), kind="stable")
        order = np.array([k for k in order if (labels == k).any()], np.int64)
        place = np.zeros(number, np.int64)
        place[order] = np.arange(order.size)
        labels[labels >= 0] = place[labels[labels >= 0]]
        found = [self._attractor(k) for k in order]
        longest = max((one.points.shape[1] for one in found), default=0)
        table = np.full((rows, longest, order.size), np.nan)
        for k, one in enumerate(found):
            table[:, : one.points.shape[1], k] = system.turned_back(one.points.copy())
        undecided = labels == UNDECIDED
        return Basins(
            z0=self.z0[:rows],
            label=labels,
            settling_time=np.where(undecided, np.nan, self.time),
            suggested_time=np.where(undecided, SUGGESTED * time, np.nan),
            status=status,
            kind=np.array([one.kind for one in found], np.int64),
            period=np.array([one.period for one in found], float),
            points=table,
            error=np.array([one.error for one in found], float).reshape(order.size, rows).T,
            exponent=np.array([one.exponent for one in found], float),
            exponent_error=np.array([one.exponent_error for one in found], float),
            time=time,
            interval=self.motion.interval,
            names=system.row_names,
            scheme=self.motion.flow.scheme,
            step=self.motion.flow.step,
            stepwise=self.motion.stepwise,
        )


def _spaced(orbits: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many of the orbits, evenly spaced in their order."""
    return orbits[np.unique(np.linspace(0, max(orbits.size - 1, 0), most).astype(int))] if orbits.size else orbits


def _one_step(flow: Any) -> Any:
    """Return the flow with one step for all orbits, the shortest, so that it runs any number of them."""
    return replace(flow, step=float(np.min(flow.step)))


def _returns(motion: Motion, states: np.ndarray, most: int, interval: float, free: bool) -> Candidates:
    """Return guesses from states (states, rows, orbits) near the first ones, after or before it."""
    away = motion.apart(states[1 : most + 1].transpose(1, 0, 2), states[0][:, None])
    away = np.where(np.isfinite(away), away, np.inf)
    if free:  # the first minima of the distance, after the orbit has left
        ends = np.full((1, away.shape[1]), np.inf)
        before = np.concatenate([-ends, away[:-1]])
        after = np.concatenate([away[1:], -ends])
        away = np.where((away <= before) & (away <= after), away, np.inf)
    nearest_ones = np.argsort(away, axis=0, kind="stable")[:TRIED]
    first = np.argmax(away < RETURNING / 10, axis=0)[None]
    number = np.concatenate([nearest_ones, first])
    good = np.take_along_axis(away, number, axis=0) < RETURNING
    good[-1] &= ~(number[-1] == nearest_ones).any(axis=0)
    orbit = np.broadcast_to(np.arange(away.shape[1]), number.shape)[good]
    return Candidates(motion.restarted(states[0][:, orbit]), (number[good] + 1.0) * interval, free)
