"""A running flow: states of many orbits, how far each may go, and the kernels that advance them.

First the distances beyond which orbits count as escaped and the states of running orbits; then orbits that overflow in
a step, of which those that run away to infinity have escaped; then the arguments of kernels, the blocks of a model and
the coefficients of a scheme; then the flow of a system by a scheme, with interruption and progress.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import Callback, fits, number_of_steps
from ..core.status import Status
from ..engine import nystrom
from ..engine.blocks import idle_block, model_block, nystrom_block, step_block
from ..engine.jit import LANES
from ..engine.kernels import crossing_roots as roots
from ..engine.kernels import escape
from ..engine.kernels.adaptive_drive import AdaptiveSteps, run_adaptive
from ..engine.kernels.collocation import collocate
from ..engine.kernels.crossings import CERTAIN, RECORD
from ..engine.kernels.drive import FixedSteps, RunningOrbits, run_along, run_fixed, run_one
from ..engine.kernels.sample_times import ROUNDING
from ..engine.kernels.sample_times import ROWS as SAMPLE_ROWS
from ..engine.kernels.samples import DAMPING_ROWS, lost_until
from ..engine.kernels.stepping import Blocks, Coefficients, runge_kutta
from ..engine.lane_sums import VECTOR
from ..engine.packing import Packed, launch, run_units, units
from ..engine.threads import by_portions
from ..engine.values import by_identity, parameters
from ..systems.models.mechanics import System, length
from . import observers
from .observers import Observer
from .requirements import energy_drift
from .schemes.catalogue import DOP853, Collocation, Nystrom, Scheme, Splitting

FARTHEST = 1e150
"""Distance beyond which orbits of usual size have escaped."""

ESCAPE = 1e6
"""Escape radius in units of the orbit's own size."""


LARGEST = 1e154
"""Largest escape radius, whose square is still a number."""

HUGE = 1e3
"""Least ratio of the escape radius, up to LARGEST, to the size of an orbit of more than FARTHEST."""


def escape_radii(system: System, z: np.ndarray, energy: np.ndarray | None = None) -> np.ndarray:
    """Return the distance from the origin (orbits,) beyond which each orbit from z (2n, orbits) counts as escaped;
    energy (orbits,) of these, where it is known already.

    It is ESCAPE times the orbit's size: its distance at the start, or that of the turning point on the straight line
    along its initial velocity, if that is farther; `FARTHEST` where it has neither. So it scales with the unit of
    length, and depends neither on other orbits nor on the zero of V. Orbits of a map, and of H(q, p), have no such
    limit: a start near a fixed point does not show the size, and coordinates may be angles that wind.
    """
    if not system.separable or "energy" in system.words:
        return np.full(z.shape[1], FARTHEST)
    limit = system.energies(z) if energy is None else energy
    with np.errstate(all="ignore"):
        reach = _reaches(system, z, limit)
    farthest = np.fmax(FARTHEST, np.fmin(HUGE * reach, LARGEST))
    return np.where(reach > 0, np.fmin(ESCAPE * reach, farthest), FARTHEST)


def _reaches(system: System, z: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Return the distances from the origin (orbits,) of orbits from z, or of their turning points at these energies, to
    two digits.
    """
    n = system.moving
    total = system.n
    orbits = z.shape[1]
    speeds = system.slopes(z)
    centrifugal = 0.0
    if system.driven:  # V along the line is that of one moment
        limit = limit - z[-1]
        speeds = np.concatenate([speeds[:n], speeds[n + 1 : -1]])
    if system.frame:
        centrifugal = 0.5 * system.turning_mass * float(system.model.angular_velocity()) ** 2
    q = np.ascontiguousarray(z[:total])
    distances = _distances()
    size = length(q[:n])
    along = np.zeros((total, orbits))
    unit = np.where(size > 0, size, 1.0)
    own = np.where((speeds[:n] != 0).any(axis=0), speeds[:n], speeds[n:])  # of an orbit that rests the force
    own = own / np.abs(own).max(axis=0)  # lengths of huge velocities have no square
    own = own / length(own)
    along[:n] = np.where(np.isfinite(own), own * unit, 0.0)
    lowest, highest = np.where(size > 0, np.array(escape.OWN)[:, None], np.array(escape.DECADES)[:, None])
    begin = escape.FINE * (lowest - escape.DECADES[0])
    looks = highest - lowest + 1
    turn = np.full((2, orbits), -1)
    if (potential := _potential(system.model)) is None:
        _find_turns(system, distances, q, along, begin, looks, limit, turn)
    else:
        arguments = (parameters(system.model), potential, centrifugal, distances, q, along, begin, looks, limit, turn)
        run_units(escape.find_turns, arguments, -(-orbits // LANES), threads=1)
    farther = turn.max(axis=0)
    turned = farther >= 0
    reach = np.where(turned, np.maximum(size, unit * distances[farther]), size)
    near = np.flatnonzero(~turned & (reach > 0))
    if near.size:  # turning points may be far beyond the distance of a start next to the origin
        centred = np.array(z[:, near])
        own = limit[near]
        centred[:n] = 0.0
        far = _reaches(system, centred, own + (z[-1, near] if system.driven else 0.0))
        reach[near] = np.where(far > 10.0 ** escape.OWN[1] * reach[near], far, reach[near])
    return reach


_NOT_COMPILED: set[tuple[type, ...]] = set()
"""Classes of models, with those of their fields, whose potential energy Numba does not compile."""


def _potential(model: Any) -> Any:
    """Return the compiled potential energy; None where it does not compile: no other function needs it compiled."""
    classes = (type(model), *map(type, model))
    if classes not in _NOT_COMPILED:
        try:
            return model_block("potential", model, model.degrees_of_freedom)
        except Exception:  # Numba's own, and any other that its passes raise
            _NOT_COMPILED.add(classes)
    return None


def _find_turns(
    system: System,
    distances: np.ndarray,
    q: np.ndarray,
    along: np.ndarray,
    begin: np.ndarray,
    looks: np.ndarray,
    limit: np.ndarray,
    turn: np.ndarray,
) -> None:
    """Set turn as `escape.find_turns` does, by NumPy."""

    def below(number: np.ndarray, way: float) -> np.ndarray:
        place = q + distances[np.clip(number, 0, distances.size - 1)] * (way * along)
        return system.least_energies(place) <= limit

    for side, way in enumerate((1.0, -1.0)):
        last = turn[side]
        inside = np.zeros(begin.size, bool)
        for k in range(looks.max()):
            now = below(begin + escape.FINE * k, way)
            last[:] = np.where((k < looks) & inside & ~now, begin + escape.FINE * (k - 1), last)
            inside = np.where(k < looks, now, inside)
        half = escape.FINE // 2
        while half > 0:
            last += np.where((last >= 0) & below(last + half, way), half, 0)
            half //= 2


@functools.cache
def _distances() -> np.ndarray:
    """Return the distances that are tried, in units of an orbit's own."""
    least, most = escape.DECADES
    return 10.0 ** (np.arange(least * escape.FINE, most * escape.FINE + 1) / escape.FINE)


@dataclass
class Ensemble:
    """Running orbits: all data that a run needs to go on where it stopped. Arrays over orbits.

    z (2n (1 + vectors), orbits) with tangent vectors: positions of the orbit and of each vector, then momenta likewise;
    energy at the start; kinetic: the largest kinetic energy so far, the scale of energy errors, which is independent
    of the zero of V; radius: the distance from the origin beyond which an orbit has escaped.
    """

    z: np.ndarray
    energy: np.ndarray
    kinetic: np.ndarray
    vectors: int = 0
    status: np.ndarray = field(init=False)
    count: np.ndarray = field(init=False)
    time: np.ndarray = field(init=False)
    ahead: np.ndarray = field(init=False)
    ticks: np.ndarray = field(init=False)
    radius: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        n = self.z.shape[1]
        self.status = np.zeros(n, np.int64)
        self.count = np.zeros(n, np.int64)
        self.ticks = np.zeros(n, np.int64)
        self.time = np.zeros(n)
        self.ahead = np.zeros(n)
        self.radius = np.full(n, FARTHEST)

    def of(self, orbits: Any) -> Ensemble:
        """Return some of the orbits as an ensemble of their own."""
        part = Ensemble(self.z[:, orbits], self.energy[orbits], self.kinetic[orbits], self.vectors)
        for name in ("status", "count", "time", "ahead", "ticks", "radius"):
            setattr(part, name, getattr(self, name)[orbits])
        return part

    def orbits(self, memory: np.ndarray, out: np.ndarray) -> RunningOrbits:
        """Return the arrays of the orbits for kernels, with the memory and records of an observer."""
        places = self.z, self.time, self.count, self.ahead, self.ticks, self.kinetic, self.radius, self.status
        return RunningOrbits(*places, memory, out)

    def take(self, orbits: Any, part: Ensemble) -> None:
        """Take over the state of `part` for the orbits of that index array or mask."""
        for name in ("z", "energy", "kinetic", "status", "count", "time", "ahead", "ticks", "radius"):
            getattr(self, name)[..., orbits] = getattr(part, name)

    @property
    def scale(self) -> np.ndarray:
        """The scale of energy errors: the largest kinetic energy seen; 1 for an orbit that rests."""
        return np.where(self.kinetic > 0, self.kinetic, 1.0)

    @property
    def points(self) -> np.ndarray:
        """The orbits' phase points (2n, orbits)."""
        return self.z if self.vectors == 0 else self.parts[:, 0].reshape(-1, self.z.shape[1])

    @property
    def parts(self) -> np.ndarray:
        """A view (2, 1 + vectors, n, orbits) of z: positions and momenta of the orbit and of its tangent vectors."""
        return self.z.reshape(2, 1 + self.vectors, -1, self.z.shape[1])

    @property
    def deviations(self) -> np.ndarray:
        """The tangent vectors (vectors, 2n, orbits)."""
        return self.parts[:, 1:].transpose(1, 0, 2, 3).reshape(self.vectors, -1, self.z.shape[1])


def energy_error(system: System, ensemble: Ensemble) -> np.ndarray:
    """Return |E - E0| of each orbit over the largest kinetic energy seen on it; inf where the energy has no value."""
    return energy_drift(system, ensemble.points, ensemble.energy, ensemble.scale)


def mark_drift(ensemble: Ensemble, error: np.ndarray, tolerance: float) -> None:
    """Give orbits whose energy error exceeds the tolerance the status ENERGY_DRIFT, unless they have another."""
    ensemble.status[(ensemble.status == Status.OK) & (error > tolerance)] = Status.ENERGY_DRIFT


def no_memory(ensemble: Ensemble) -> tuple[np.ndarray, np.ndarray]:
    """Return the memory and output arrays of an observer that keeps nothing."""
    return np.zeros((1, ensemble.z.shape[1])), np.zeros((1, 1))


# tests/runs/test_leaving.py has orbits that run away, by every scheme.

BACK = 16
"""Steps before the overflow from which an orbit is followed again, as the last ones are spoilt."""

AHEAD = 64.0
"""Time for which it is followed, in steps."""

SOUND = 0.05
"""Energy error there, over the largest kinetic energy, above which the step was unstable and the orbit tells nothing.
"""


def mark_escapes(flow: Any, ensemble: Ensemble, begun: Ensemble, sizes: Callable[[], np.ndarray]) -> None:
    """Give orbits that overflowed on their way to infinity the status ESCAPED in the place of NONFINITE.

    begun: the orbits before the run; sizes: returns their steps (orbits,). In a potential that falls ever more steeply
    an orbit reaches infinity in a finite time, and a fixed step passes from ordinary numbers to an overflow. Such
    orbits run again to some steps before, and from there with an adaptive scheme, which meets the escape radius first.
    """
    lost = overflowed(ensemble, begun) & (ensemble.count > begun.count + 1)
    if not lost.any():
        return
    which = np.flatnonzero(lost)
    last = _alone(begun.of(which))
    size = sizes()[which]
    alone = replace(flow, vectors=0, step=size)
    # One step at least: its energy error tells whether steps are stable.
    until = np.maximum(ensemble.count[which] - BACK, last.count + 1)
    _run(alone, last, until * size)
    with np.errstate(all="ignore"):
        sound = np.isfinite(last.z).all(axis=0) & (energy_error(flow.system, last) < SOUND)
    sound &= (last.status == Status.OK) & (last.count == until)
    which = which[sound]
    size = size[sound]
    if not which.size:
        return
    start = last.z[:, sound]
    beyond = replace(flow, vectors=0, scheme=DOP853, step=np.inf, rtol=1e-9, atol=1e-300)
    ahead = beyond.ensemble(start.copy(), radius=ensemble.radius[which])
    ahead.ahead[:] = size / 64
    _run(beyond, ahead, AHEAD * size)
    ensemble.status[which[ahead.status == Status.ESCAPED]] = Status.ESCAPED


def overflowed(ensemble: Ensemble, begun: Ensemble) -> np.ndarray:
    """Return a mask (orbits,) of the orbits that overflowed in a run, on whatever way."""
    return (ensemble.status == Status.NONFINITE) & (begun.status == Status.OK) & (ensemble.radius < FARTHEST)


def leave_open(ensemble: Ensemble, begun: Ensemble) -> None:
    """Give orbits that overflowed in a run that was interrupted the status INTERRUPTED: how they ended is not told."""
    ensemble.status[overflowed(ensemble, begun) & (ensemble.count > begun.count + 1)] = Status.INTERRUPTED


def _alone(ensemble: Ensemble) -> Ensemble:
    """Return the orbits of an ensemble without tangent vectors."""
    if not ensemble.vectors:
        return ensemble
    bare = Ensemble(np.ascontiguousarray(ensemble.points), ensemble.energy, ensemble.kinetic)
    for name in ("status", "count", "time", "ahead", "ticks", "radius"):
        setattr(bare, name, getattr(ensemble, name))
    return bare


def _run(flow: Any, ensemble: Ensemble, time: np.ndarray) -> None:
    """Run orbits to times of their own."""
    flow.run(ensemble, observers.nothing(), *no_memory(ensemble), time=time)


def blocks_of(system: System, vectors: int = 0, step: Callable | None = None, **kinds: str | nystrom.Terms) -> Blocks:
    """Return a model's functions for kernels: block functions of these kinds, or of a Runge-Kutta-Nyström scheme's
    terms, idle ones in the other places; step: the kernel of a scheme that steps by the derivative.
    """
    n = system.n
    derivative = 0
    leapt = 0
    found = {
        place: model_block(kind, system.model, n, vectors)
        if isinstance(kind, str)
        else nystrom_block(f"nystrom_{place}", system.model, n, vectors, kind)
        for place, kind in kinds.items()
    }
    if step is not None:
        found["step"], derivative = step_block(step), model_block("derivative", system.model, n, vectors).address
    if system.poles:
        leapt = model_block("leapt", system.model, n, vectors).address
    idle = {place: idle_block(place) for place in Blocks._fields[1:6] if place not in found}
    return Blocks(
        parameters(system.model),
        **found,
        **idle,
        derivative=derivative,
        leapt=leapt,
        own=n,
        half=n * (1 + vectors),
        between=1.0 if system.iterated else 0.0,
    )


@by_identity
def _kept(model: Any) -> dict[tuple, tuple[Packed, Packed, Scheme]]:
    """The arguments that kernels have got from a model, and their schemes, whose ids could else pass to others."""
    return {}


def stepping(flow: Any, *kinds: str, solo: bool = False) -> tuple[Packed, Packed]:
    """Return the blocks of these kinds and that of the scheme's step, for units of one orbit if `solo`, and the
    scheme's coefficients.
    """
    scheme = flow.scheme
    kept = _kept(flow.model)
    key = id(scheme), flow.vectors, solo, kinds
    if key not in kept:
        by: dict[str, Any] = {"step": collocate if isinstance(scheme, Collocation) else runge_kutta}
        if isinstance(scheme, Nystrom):
            by = {"march" if solo else "splitting": scheme.terms}
        if isinstance(scheme, Splitting):
            by = {"march": "march"} if solo else {"splitting": "precise_splitting" if flow.precise else "splitting"}
        blocks = blocks_of(flow.system, flow.vectors, **by | {kind: kind for kind in kinds})
        kept[key] = Packed(blocks), Packed(_coefficients(flow)), scheme
    return kept[key][:2]


def _coefficients(flow: Any) -> Coefficients:
    """Return the scheme for kernels, with the rows that the system adds."""
    found = _tables(flow.scheme)
    if isinstance(flow.scheme, Splitting):
        return found._replace(copies=3 if flow.precise else 1, spare=_spare(flow))
    return found._replace(spare=_spare(flow)) if isinstance(flow.scheme, Nystrom) else found


@by_identity
def _tables(scheme: Scheme) -> Coefficients:
    """Return the arrays of a scheme, which kernels only read."""
    if isinstance(scheme, Splitting):
        return Coefficients(scheme.drift_array, scheme.kick_array)
    if isinstance(scheme, Nystrom):
        return Coefficients(scheme.drift_array, scheme.kick_array, copies=2)
    if isinstance(scheme, Collocation):
        a = scheme.a_array
        b = scheme.b_array
        dense = scheme.dense_array
        return Coefficients(a=a, b=b, dense=dense, copies=2 * (1 + scheme.stages), sweeps=scheme.sweeps)
    return Coefficients(a=scheme.a_array, b=scheme.b_array, errors=scheme.error_array, dense=scheme.dense_array)


def _spare(flow: Any) -> int:
    """Return the number of further rows in blocks of states: for the numbers of a substep, or for the forces of
    stages.
    """
    substep = flow.system.substep
    scheme = flow.scheme
    if isinstance(scheme, Nystrom):
        n = flow.model.degrees_of_freedom
        return nystrom.spare_rows(n, n * (1 + flow.vectors), scheme.stages)
    return 0 if substep is None else substep.spare_rows(len(scheme.drift), len(scheme.kick))


DAMPING_STEPS = 2, 4, 8, 16, 32
"""Steps, or one, after which slowed orbits lose part of their momenta: lanes of a block stop together."""


class Damping(NamedTuple):
    """Slowing of each orbit: by the time t momenta have lost the fraction share*(u + 2 u e/(u + e)), u = sqrt(t),
    e = sqrt(early), three times as much in the beginning as later; they lose it about once in a time `every`. Arrays
    (orbits,).
    """

    share: np.ndarray
    early: np.ndarray
    every: np.ndarray

    def pace(self, step: np.ndarray | float, parts: np.ndarray | int = 0) -> np.ndarray:
        """Return the number (orbits,) of steps after which momenta are lost: 1 or one of DAMPING_STEPS, a divisor of
        `parts`.
        """
        found = np.ones(len(self.every), np.int64)
        most = self.every / step
        for steps in DAMPING_STEPS:
            found = np.where((steps <= most) & (parts % steps == 0), steps, found)
        return found

    def begin(self, ensemble: Ensemble, memory: np.ndarray, pace: np.ndarray) -> None:
        """Set DAMPING_ROWS of orbits that lose momenta every `pace` steps; the loss up to the first of these is made at
        once, as chaotic orbits have amplified by then what else would not be there.
        """
        early = np.sqrt(self.early)
        momenta = len(ensemble.z) // 2
        lost = lost_until(pace * ensemble.ahead, self.share, early)
        memory[DAMPING_ROWS.share] = self.share
        memory[DAMPING_ROWS.early] = early
        memory[DAMPING_ROWS.lost] = lost
        ensemble.z[momenta:] *= 1 - lost


@dataclass(frozen=True)
@inserts_parameters
class Flow:
    """Hold the flow of a model by a scheme, and run it.

    Parameters
    ----------
    system : System
        Model with its traits and mechanics.
    scheme : Scheme
        Integration method.
    step : float or ndarray, shape (orbits,)
        Step size, one for all orbits or one for each; infinite to let an adaptive scheme choose the first step.
    rtol, atol : float
        Tolerances of an adaptive scheme.
    threads : int
        Number of threads.
    vectors : int, default 0
        Number of deviation vectors of each orbit.
    """

    system: System
    scheme: Scheme
    step: float | np.ndarray
    rtol: float
    atol: float
    threads: int
    vectors: int = 0

    patience = 1

    @property
    def model(self) -> Any:
        """The model."""
        return self.system.model

    @property
    def adaptive(self) -> bool:
        """Whether the scheme controls its step."""
        return self.scheme.adaptive

    @property
    def fixed(self) -> bool:
        """Whether it takes equal steps in time."""
        return not (self.adaptive or self.system.iterated)

    @property
    def alike(self) -> bool:
        """Whether the caller chose one step or one pair of tolerances for all orbits."""
        return self.adaptive

    @property
    def precise(self) -> bool:
        """True if steps are added with compensated summation."""
        return getattr(self.scheme, "increments", isinstance(self.scheme, Collocation))

    def ensemble(
        self, z0: np.ndarray, deviations: np.ndarray | None = None, radius: np.ndarray | None = None
    ) -> Ensemble:
        """Start orbits from initial states.

        Parameters
        ----------
        z0 : ndarray, shape (2n, orbits)
            Initial states, taken over without a copy.
        deviations : ndarray, shape (vectors, 2n, orbits), optional
            Deviation vectors at the start.
        radius : ndarray, shape (orbits,), optional
            Distances beyond which orbits have escaped. Default: computed from the initial states.

        Returns
        -------
        Ensemble
            Running orbits at time 0.
        """
        n = self.system.n
        state = z0
        if deviations is not None:
            whole = np.concatenate([z0[None], deviations]).reshape(1 + self.vectors, 2, n, -1)
            state = np.ascontiguousarray(whole.transpose(1, 0, 2, 3)).reshape(-1, z0.shape[1])
        started = Ensemble(state, self.system.energies(z0), self.system.kinetic_energies(z0), self.vectors)
        started.radius = escape_radii(self.system, z0, started.energy) if radius is None else radius
        started.ahead[:] = self.step if np.isfinite(self.step).all() else self._first_steps(z0)
        return started

    def _first_steps(self, z0: np.ndarray) -> np.ndarray:
        """Return the first steps (orbits,) of a scheme that controls them: those given, else a hundredth of the time in
        which z0 changes by its size.
        """
        size = np.abs(z0).max(axis=0)
        speed = np.abs(self.system.slopes(z0)).max(axis=0)
        guess = np.where(speed > 0, 0.01 * size / np.where(speed > 0, speed, 1.0), 0.01)
        guess = np.where(guess > 0, guess, 1e-6)
        if self.system.driven:
            guess = np.full_like(guess, 1e-3 * self.model.period)
        return np.where(np.isfinite(self.step), self.step, guess)

    def steps(self, time: float | np.ndarray) -> np.ndarray:
        """Return the number of steps that reach a time.

        Parameters
        ----------
        {run_time}

        Returns
        -------
        ndarray of int
            Numbers of steps, one for each orbit if steps or times differ.
        """
        return np.maximum(1, number_of_steps(time, self.step)).astype(np.int64)

    def fitted(self, time: float | np.ndarray, parts: int = 1) -> Flow:
        """Return the flow with the longest steps that divide a time.

        Parameters
        ----------
        {run_time}
        parts : int, default 1
            Number that divides the number of steps.

        Returns
        -------
        `Flow`
            Flow with steps of at most its own size; the same flow if it is adaptive.
        """
        return replace(self, step=time / (parts * self.steps(time / parts))) if self.fixed else self

    def sized(self, step: np.ndarray) -> Flow:
        """Return the flow with other steps.

        Parameters
        ----------
        step : ndarray, shape (orbits,)
            Step sizes. For an adaptive flow they are factors, where 1 keeps its tolerances.

        Returns
        -------
        `Flow`
            Flow with these steps. An adaptive flow gets tolerances that follow from its order.
        """
        if self.adaptive:
            factor = float(step[0]) ** self.scheme.order
            return replace(self, rtol=self.rtol * factor, atol=self.atol * factor)
        return replace(self, step=step)

    def finer(self) -> Flow:
        """Return the flow with half its step, or with a hundredth of its tolerances.

        Returns
        -------
        `Flow`
            More accurate flow.
        """
        if self.adaptive:
            return replace(self, rtol=max(self.rtol / 100, 1e-15), atol=self.atol / 100)
        return replace(self, step=self.step / 2)

    def of(self, orbits: Any) -> Flow:
        """Return the flow of some of the orbits.

        Parameters
        ----------
        orbits : index array or mask
            Orbits to keep.

        Returns
        -------
        `Flow`
            Flow with their steps.
        """
        return replace(self, step=self.step[orbits]) if isinstance(self.step, np.ndarray) and self.step.ndim else self

    def _unit(self, orbits: int) -> int:
        """Number of orbits that a thread takes at once: about eight portions each, whole blocks where there are enough
        orbits, else equal numbers of blocks for each thread, all of equal numbers of whole vectors.
        """
        portion = math.ceil(orbits / (8 * self.threads))
        if portion >= LANES:
            return LANES * math.ceil(portion / LANES)
        own = math.ceil(orbits / self.threads)
        size = math.ceil(own / math.ceil(own / LANES))
        return size if own <= LANES else VECTOR * math.ceil(size / VECTOR)

    def unit(self, orbits: int) -> int:
        """Return the number of orbits that a thread runs at once.

        Parameters
        ----------
        orbits : int
            Number of all orbits.

        Returns
        -------
        int
            Number of orbits, at most a block, if all have equally many steps.
        """
        return min(LANES, self._unit(orbits))

    def advance(
        self,
        ensemble: Ensemble,
        observer: Observer,
        memory: np.ndarray,
        out: np.ndarray,
        *,
        time: float | np.ndarray,
        observations: int | np.ndarray = 0,
        refill: bool = False,
        callback: Callback | None = None,
    ) -> None:
        """Advance orbits to a time under an observer, and mark those that escaped.

        Parameters
        ----------
        {ensemble}
        {observer}
        {observer_memory}
        {observer_out}
        {run_time}
        observations : int or ndarray, default 0
            Number of equidistant observations, for which steps are shortened. 0: the observer sees every step.
        refill : bool, default False
            True to let the lane of an ended orbit run the next orbit.
        callback : callable, optional
            Function that is called with the completed fraction.
        """
        known = not self.adaptive and bool((ensemble.radius < FARTHEST).any())
        begun = ensemble.of(np.arange(ensemble.status.size)) if known else None
        try:
            self.run(
                ensemble, observer, memory, out, time=time, observations=observations, refill=refill, callback=callback
            )
            if begun is not None:
                mark_escapes(self, ensemble, begun, lambda: self._equal_steps(begun.status.size, time, observations)[2])
        except BaseException:
            if begun is not None:
                leave_open(ensemble, begun)
            raise

    def run(
        self,
        ensemble: Ensemble,
        observer: Observer,
        memory: np.ndarray,
        out: np.ndarray,
        *,
        time: float | np.ndarray,
        observations: int | np.ndarray = 0,
        refill: bool = False,
        callback: Callback | None = None,
    ) -> None:
        """Advance orbits to a time; an orbit that overflows gets the status NONFINITE.

        Parameters
        ----------
        {ensemble}
        {observer}
        {observer_memory}
        {observer_out}
        {run_time}
        observations : int or ndarray, default 0
            Number of equidistant observations, for which steps are shortened. 0: the observer sees every step.
        refill : bool, default False
            True to let the lane of an ended orbit run the next orbit.
        callback : callable, optional
            Function that is called with the completed fraction.
        """
        run = self._advance_adaptive if self.adaptive else self._advance_fixed
        run(ensemble, observer, memory, out, time, observations, refill, callback)

    def states(self, z: np.ndarray) -> np.ndarray:
        """Return the phase points of the rows of an ensemble.

        Parameters
        ----------
        z : ndarray, shape (rows, ...)
            Rows of an ensemble.

        Returns
        -------
        ndarray, shape (2n, ...)
            Phase points without an idle row. The time of a driven model is reduced to its period.
        """
        if self.system.driven:
            z[self.system.moving] = self.model.phase(z[self.system.moving])
        return z[: self.system.rows]

    def section(self, section: Any) -> Any:
        """Return a section of the model as a section of the states of the flow.

        Parameters
        ----------
        section : Section
            Section of the model.

        Returns
        -------
        Section
            The same section, or one with a 0 for an idle row.
        """
        idle = 2 * self.system.n - self.system.rows
        return section._replace(normal=(*section.normal, 0.0)) if idle else section

    def trajectory(
        self, ensemble: Ensemble, time: float, count: int, callback: Callback | None
    ) -> tuple[np.ndarray, bool]:
        """Run orbits to a time and keep equidistant states.

        Parameters
        ----------
        {ensemble}
        time : float
            Time of the end of the run.
        count : int
            Number of states.
        callback : callable or None
            Function that is called with the completed fraction.

        Returns
        -------
        states : ndarray, shape (count, 2n, orbits)
            States, NaN if not reached.
        interrupted : bool
            True if Ctrl-C ended the run.
        """
        rows, orbits = ensemble.z.shape
        fits("samples", orbits, count, rows)
        states = np.full((orbits, count, rows), np.nan)
        interrupted = False
        try:
            if count:
                self.sampled(ensemble, count, time=time, states=states, callback=callback)
            else:
                nothing = observers.nothing()
                self.advance(ensemble, nothing, *no_memory(ensemble), time=time, observations=1, callback=callback)
        except KeyboardInterrupt:
            interrupted = True
        self.states(states.transpose(2, 0, 1))
        return states.transpose(1, 2, 0)[:, : self.system.rows], interrupted

    def sampled(
        self,
        ensemble: Ensemble,
        count: int,
        *,
        time: float | np.ndarray,
        states: np.ndarray | None = None,
        callback: Callback | None = None,
    ) -> np.ndarray:
        """Advance orbits to a time and return equidistant states.

        Parameters
        ----------
        {ensemble}
        count : int
            Number of states.
        {run_time}
        states : ndarray, shape (orbits, count, rows), optional
            Array for the states, so that Ctrl-C does not lose them.
        callback : callable, optional
            Function that is called with the completed fraction.

        Returns
        -------
        ndarray, shape (orbits, count, rows)
            States, NaN if not reached.
        """
        rows, orbits = ensemble.z.shape
        if states is None:
            states = np.full((orbits, count, rows), np.nan)
        observer = observers.samples(rows)
        out = states.reshape(orbits, count * rows)
        memory = np.zeros((observer.rows, orbits))
        self.advance(ensemble, observer, memory, out, time=time, observations=count, callback=callback)
        return states

    def damped(
        self, ensemble: Ensemble, count: int, damping: Damping, *, time: float, callback: Callback | None
    ) -> tuple[np.ndarray, bool]:
        """Run orbits with artificial damping and keep equidistant states.

        Parameters
        ----------
        {ensemble}
        count : int
            Number of states.
        damping : Damping
            Loss of the momenta of each orbit.
        time : float
            Time of the end of the run.
        callback : callable or None
            Function that is called with the completed fraction.

        Returns
        -------
        states : ndarray, shape (count, rows, orbits)
            States, NaN if not reached.
        interrupted : bool
            True if Ctrl-C ended the run.
        """
        rows, orbits = ensemble.z.shape
        fits("samples", orbits, count, rows)
        states = np.full((orbits, count, rows), np.nan)
        interrupted = False
        each = self.steps(time / count)
        pace = damping.pace(self.step, each)
        stride = each // pace
        observer = observers.worn_samples(rows)
        at = DAMPING_ROWS
        memory = np.zeros((observer.rows, orbits))
        damping.begin(ensemble, memory, pace)
        memory[at.stride] = stride
        memory[at.left] = stride
        out = states.reshape(orbits, count * rows)
        try:
            self.advance(ensemble, observer, memory, out, time=time, observations=count * stride, callback=callback)
        except KeyboardInterrupt:
            interrupted = True
        return states.transpose(1, 2, 0), interrupted

    def trajectory_at(
        self,
        ensemble: Ensemble,
        time: float,
        moments: np.ndarray,
        callback: Callback | None,
        damping: Damping | None = None,
    ) -> tuple[np.ndarray, bool]:
        """Run orbits to a time and keep states at given times. They do not change the steps.

        Parameters
        ----------
        {ensemble}
        time : float
            Time of the end of the run.
        moments : ndarray, shape (moments,)
            Increasing times in (0, time].
        callback : callable or None
            Function that is called with the completed fraction.
        damping : Damping, optional
            Loss of the momenta of each orbit, for artificial damping.

        Returns
        -------
        states : ndarray, shape (moments, 2n, orbits)
            States, NaN if not reached.
        interrupted : bool
            True if Ctrl-C ended the run.
        """
        rows, orbits = ensemble.z.shape
        width = rows + 1
        fits("samples", orbits, len(moments), width)
        records = np.full((orbits, len(moments), width), np.nan)
        records[..., 0] = moments
        observer = observers.at_times(rows)
        first = observer.rows
        if damping is not None:
            pace = damping.pace(ensemble.ahead)
            observer = observers.either(observer, observers.damped_samples(rows, int(pace.min())))
        memory = np.zeros((observer.rows, orbits))
        memory[SAMPLE_ROWS.following] = moments[0]
        if damping is not None:
            damping.begin(ensemble, memory[first:], pace)
            memory[first + DAMPING_ROWS.stride] = pace
            memory[first + DAMPING_ROWS.left] = pace
        interrupted = False
        out = records.reshape(orbits, -1)
        try:
            self.advance(ensemble, observer, memory, out, time=time, refill=True, callback=callback)
        except KeyboardInterrupt:
            interrupted = True
        reached = np.arange(len(moments)) < memory[SAMPLE_ROWS.taken, :, None]
        back = np.where(reached, moments - records[..., 0], 0.0)
        where = np.nonzero(np.abs(back) > 2 * ROUNDING * moments)
        states = records[..., 1:]
        if where[0].size:
            # Two steps back, each at most half a step of the run: their error is smaller by the order.
            half = 0.5 * back[where]
            states[where] = self.shifted(self.shifted(states[where].T, half), half).T
        self.states(states.transpose(2, 0, 1))
        return states.transpose(1, 2, 0)[:, : self.system.rows], interrupted

    def observed(
        self,
        z0: np.ndarray,
        observer: Observer,
        *,
        time: float,
        columns: int = 1,
        observations: int = 0,
        callback: Callback | None = None,
    ) -> tuple[Ensemble, np.ndarray, np.ndarray]:
        """Run orbits from initial states under an observer.

        Parameters
        ----------
        z0 : ndarray, shape (2n, orbits)
            Initial states.
        {observer}
        time : float or ndarray, shape (orbits,)
            Time of the end of the run.
        columns : int, default 1
            Number of columns of the records.
        observations : int, default 0
            Number of equidistant observations. 0: every step.
        callback : callable, optional
            Function that is called with the completed fraction.

        Returns
        -------
        ensemble : Ensemble
            Orbits at the end.
        memory : ndarray, shape (rows, orbits)
            Memory of the observer, which is 0 at the start.
        out : ndarray, shape (orbits, columns)
            Records of the observer, NaN if not written.
        """
        ensemble = self.ensemble(np.array(z0, dtype=np.float64, order="C"))
        orbits = z0.shape[1]
        memory = np.zeros((observer.rows, orbits))
        out = np.full((orbits, columns), np.nan)
        self.advance(ensemble, observer, memory, out, time=time, observations=observations, callback=callback)
        return ensemble, memory, out

    def _advance_adaptive(self, ensemble, observer, memory, out, time, observations, refill, callback) -> None:
        """Advance with step control; lanes are always refilled, so `refill` changes nothing."""
        orbits = ensemble.z.shape[1]
        unit = self._unit(orbits)
        steps = AdaptiveSteps(
            until=np.array(np.broadcast_to(time, orbits), dtype=np.float64),
            rtol=self.rtol,
            atol=self.atol,
            own=self.model.degrees_of_freedom,
            mixed=not self.system.canonical,
            cadence=float(time / observations) if observations else 0.0,
            renew=self.vectors > 0,
        )
        under_way = ensemble.orbits(memory, out)
        arguments = *stepping(self, "check"), observer.bound, steps, unit, under_way
        launch(run_adaptive, arguments, units(orbits, unit), float(orbits), self.threads, callback)

    def _advance_fixed(self, ensemble, observer, memory, out, time, observations, refill, callback) -> None:
        """Advance each orbit with equal steps; `count` of the ensemble is the number of steps done."""
        orbits = ensemble.z.shape[1]
        every, total, h = self._equal_steps(orbits, time, observations)
        # Orbits that end and are observed together share blocks.
        order = np.lexsort((every, -total))
        unit = self._unit(orbits) if refill else self.unit(orbits)
        single = isinstance(self.scheme, Nystrom) or (isinstance(self.scheme, Splitting) and not self.precise)
        solo = unit == 1 and single and not self.system.poles
        steps = FixedSteps(h, total, every, order, strict=self.vectors > 0, refill=refill)
        kernel = run_one if solo else run_fixed
        if solo and refill and observer.along is not None:
            kernel = run_along
            observer = observer.along
            steps = steps._replace(every=np.full_like(every, observer.stretch))
        how = stepping(self, "inside", "check", solo=solo)
        arguments = *how, observer.bound, steps, unit, ensemble.orbits(memory, out)
        try:
            work = float((total - ensemble.count).sum())
            launch(kernel, arguments, units(orbits, unit), work, self.threads, callback, work)
        finally:
            ensemble.time[:] = ensemble.count * h

    def _equal_steps(self, orbits: int, time: Any, observations: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the steps (orbits,) between observations, those to `time`, and their sizes."""
        every = np.ones(orbits, np.int64)
        total = np.empty(orbits, np.int64)
        h = np.empty(orbits)
        if np.any(observations):
            every[:] = self.steps(time / observations)
            total[:] = observations * every
            h[:] = time / total
        else:
            total[:] = self.steps(time)
            h[:] = self.step
        return every, total, h

    def locate(self, section: Any, records: np.ndarray, where: np.ndarray, callback: Callback | None = None) -> None:
        """Turn records of a crossing observer into crossings of a section, in place.

        Parameters
        ----------
        section : Section
            Section of the states of the flow.
        records : ndarray
            Records of the observer.
        where : ndarray of int
            Numbers of the records.
        callback : callable, optional
            Function that is called with the completed fraction.
        """
        if not where.size:
            return
        certain = np.empty(where.size, bool)

        def look(at: slice) -> None:
            np.equal(records[where[at], RECORD.kind], CERTAIN, out=certain[at])

        by_portions(look, where.size, records.shape[1], self.threads)
        doubtful = where[~certain]
        if doubtful.size:
            where = np.concatenate([where[certain], doubtful])  # whose search takes longer
        function = observers.bound("value", section, self.model.degrees_of_freedom, self.vectors)
        found = *stepping(self), function
        if doubtful.size:
            steps = float(roots.SLOW * doubtful.size)
            launch(roots.bracket, (*found, records, doubtful), units(doubtful.size), 0.0, self.threads, None, steps)
        portion = math.ceil(where.size / self.threads)
        unit = portion if portion <= 8 * LANES else math.ceil(portion / 4)  # lanes of a unit take its next records
        arguments = *found, float(section.direction), records, where, unit
        steps = float(roots.USUAL * where.size)
        launch(roots.locate, arguments, units(where.size, unit), float(where.size), self.threads, callback, steps)

    def shifted(self, z: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """Return states one step later or earlier.

        Parameters
        ----------
        z : ndarray, shape (rows, orbits)
            States.
        steps : ndarray, shape (orbits,)
            Step sizes; negative steps go back.

        Returns
        -------
        ndarray, shape (rows, orbits)
            States after these steps.
        """
        table = np.array(z, order="C")
        arguments = *stepping(self), steps, table
        launch(roots.shift, arguments, units(z.shape[1]), 0.0, self.threads, None, z.shape[1])
        return table


def early(callback: Callback | None, flow: Any, ensemble: Any, time: float, share: float = 1.0) -> Callback | None:
    """Return a callback for a run whose orbits may end before `time`: it takes the fraction of all steps, and reports
    that of the steps needed, by the share that ended orbits have needed, or `share` while there are none.
    """
    if callback is None or flow.adaptive:  # which counts orbits
        return callback
    steps = np.broadcast_to(flow.steps(time), ensemble.count.shape)
    begun = ensemble.count.copy()

    def tell(fraction: float) -> None:
        taken = ensemble.count - begun
        ended = taken > 0
        need = taken[ended].sum() / steps[ended].sum() if ended.any() else share
        callback(min(1.0, fraction / need))

    return tell
