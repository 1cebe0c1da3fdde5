"""Integrate orbits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, Passes, fits, numbers, portion, shown, whole
from ..core.status import Status, describe
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.result import Result, along
from ..systems.models.contracts import Dynamics
from ..systems.models.mechanics import System
from . import observers
from .accuracy import is_dominated, planned, refine_steps, until
from .coordinates import chart_row
from .flow import Damping, Ensemble, Flow, energy_error, mark_drift, no_memory
from .given_orbits import SAMPLED
from .options import Options, Problem
from .requirements import energy_drift
from .scales import motion
from .schemes.automatic import Automatic
from .schemes.catalogue import VERNER9, Collocation, Nystrom, Scheme, Splitting, scheme_of
from .schemes.time_transformed import TimeTransformed
from .starts import starts_of
from .time_transformed import TransformedFlow
from .tolerances import (
    FINEST,
    SLOW,
    UNEVEN,
    last,
    max_radians,
    refine_tolerances,
    steps_for_remaining,
    tolerance_errors,
    tolerances,
    walled,
    with_tolerance,
)

EVEN = 1e-15
"""Relative difference up to which times are those of equal samples: two roundings on either side."""

CHUNK = 16384
"""Orbits that are run with two steps at once."""

POINTS = 2**16
"""Samples whose energies are computed at once, some of each orbit."""

MOMENTS = 8
"""SampleMoments at least at which two runs are compared."""


@dataclass(frozen=True)
class Orbits(Result):
    """Hold end states, samples and outcomes of integrated orbits.

    ``result["p_x"]`` is a row of z by its name. For a body, any coordinate or momentum of its charts is available too,
    for example ``result["p_beta"]``.

    Attributes
    ----------
    z : ndarray, shape (2n, orbits)
        States at the time `t`: coordinates, then momenta.
    t : ndarray, shape (orbits,), time
        Time reached. It is the requested time if the orbit finished.
    times : ndarray, shape (samples,), time
        Times of the samples.
    samples : ndarray, shape (samples, 2n, orbits)
        States at these times.
    error : ndarray, shape (2n, orbits), or None
        Estimated errors of z. None if you gave a step or tolerances instead of an accuracy; so are the next two.
    sample_error : ndarray, shape (samples, 2n, orbits), or None
        Estimated errors of the samples.
    accurate_until : ndarray, shape (orbits,), time, or None
        Time up to which the error stays below the accuracy. It is shorter than requested for chaotic orbits.
    energy_error : ndarray, shape (orbits,), relative
        Energy error divided by the largest kinetic energy of the orbit: the maximum over the samples and the end.
    status : ndarray, shape (orbits,), of `Status`
        Outcome of each orbit.
    scheme : Scheme or TimeTransformed
        Scheme that was used. Without a scheme of yours some orbits may have been run by VERNER9; then it is the scheme
        of the others, if there are any.
    step : float or ndarray, shape (orbits,), time
        Fixed step size, infinite for an adaptive scheme and for orbits that VERNER9 ran. For `TimeTransformed` it is a
        step in s.
    names : tuple of str, 2n entries
        Names of the rows of z.
    """

    z: Annotated[np.ndarray, along("coordinate", "orbit", labels="names", plain=True)]
    t: Annotated[np.ndarray, along("orbit", unit="time")]
    times: Annotated[np.ndarray, along("sample", unit="time")]
    samples: Annotated[np.ndarray, along("sample", "coordinate", "orbit")]
    error: Annotated[np.ndarray | None, along("coordinate", "orbit", labels="names")]
    sample_error: Annotated[np.ndarray | None, along("sample", "coordinate", "orbit")]
    accurate_until: Annotated[np.ndarray | None, along("orbit", unit="time")]
    energy_error: Annotated[np.ndarray, along("orbit", unit="largest kinetic energy")]
    status: Annotated[np.ndarray, along("orbit")]
    scheme: Scheme | TimeTransformed
    step: Annotated[float | np.ndarray, along("orbit", unit="time")]
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        SAMPLED[id(self.samples)] = self.samples

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits and their largest errors.

        Returns
        -------
        str
            Summary.
        """
        said = describe(self.status)
        fine = self.status == Status.OK
        if not fine.any():
            return said
        if self.error is not None and np.isfinite(self.error[:, fine]).any():
            said += f"; largest error {np.nanmax(self.error[:, fine]):.1e}"
        if self.energy_error[fine].any():
            said += f"; largest energy error {np.nanmax(self.energy_error[fine]):.1e}"
        if self.accurate_until is not None and (late := int(np.count_nonzero(fine & (self.accurate_until < self.t)))):
            said += f"; {late} above the requested error at the end, see accurate_until"
        return said

    def _row(self, name: str) -> np.ndarray | None:
        return chart_row(self.z, name)


@coerces_arguments(z0=starts_of, scheme=scheme_of)
@records_call
@inserts_parameters
def integrate(
    model: Dynamics,
    z0: Starts,
    *,
    time: float,
    accuracy: float | None = None,
    step: float | np.ndarray | None = None,
    scheme: Scheme | str | TimeTransformed | Automatic | None = None,
    samples: int | ArrayLike = 0,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    energy_tolerance: float | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> Orbits:
    """Integrate orbits of `model` from `z0` over `time`.

    Parameters
    ----------
    {model}
    {z0}
    time : float
        Length of the run, in units of time, positive. For a map, the number of iterates, a multiple of a number of
        samples.
    {accuracy}
    {step}
    scheme : Scheme, TimeTransformed, Automatic or str, optional
        Integration method or its name, for example ``"KAHAN_LI8"`` or ``"dop853"``. `AUTO` chooses by trial;
        `TimeTransformed` suits steep potential barriers. Default for H = T(p) + V(q):

        * BLANES_MOAN6 for accuracies from 1e-7, BLANES_CASAS_ESCORIHUELA8 for smaller ones, RKN12 up to 1e-12 (driven
          systems: up to 1e-11);
        * KAHAN_LI8 if T is not quadratic, or if you give a step;
        * VERNER9 for orbits that lose their energy with equal steps, as in close approaches.

        Default for a nonseparable H(q, p): VERNER9 for runs of up to 1000 radians of the motion and for orbits that
        equal steps lose; GAUSS8 for longer runs, or GAUSS16 for accuracies below 1e-11. ODE systems: DOP853.
    samples : int or array-like, shape (samples,), default 0
        Number of samples at equal intervals in (0, time], or their times, which increase from 0 or later to at most
        `time`. For a map, the times are whole numbers.
    {rtol}
    {atol}
    {energy_tolerance}
    {threads}
    {callback}

    Returns
    -------
    `Orbits`
        States, error estimates and the status of each orbit, with the integration method and step size.

    Raises
    ------
    TypeError
        If an argument has a wrong type.
    ValueError
        If a value is out of range, or if the model does not support an option.
    Interrupted
        On Ctrl-C. The result so far is in ``.partial``.

    Notes
    -----
    * Errors: if an accuracy is requested, steps are halved until two runs agree. The second run uses twice the step
      size and artificial damping at the level of round-off. Estimates cover 99 % of the true errors.
    * Chaotic orbits: errors grow exponentially. After `accurate_until` they exceed the accuracy with any step size.
    * Domain: checked between steps. An orbit that leaves and returns within one step is not detected, except at poles
      of formulas.
    * Energy: its error stays bounded for splitting methods and grows with time for RKN12.
    * Samples at times of yours do not change the steps. Two short steps of the scheme lead to each sample.
    * Maps: no step, scheme or energy; energy_error is 0.
    * Cost: one force evaluation per stage. The second run adds half of that, or the same again if round-off exceeds the
      accuracy.
    * Memory: 6 times z0 (12 with an accuracy), plus samples.

    References
    ----------
    Hairer, Lubich & Wanner 2006, Geometric Numerical Integration; each scheme names its own source.

    Examples
    --------
    >>> orbits = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=10.0, samples=5)
    >>> orbits.samples.shape
    (5, 4, 1)
    >>> orbits["p_x"].round(6)
    array([0.09314])
    """
    options = Options(
        scheme,
        step,
        accuracy,
        rtol=rtol,
        atol=atol,
        energy_tolerance=energy_tolerance,
        threads=threads,
        callback=callback,
    )
    problem = Problem(model, z0, options)
    time = problem.iterates("time", time)
    moments = sample_times(samples, time, problem.system.iterated)
    problem = problem.suited()
    options = problem.options
    flow, z, *_ = problem.plan(time=time, error=None, transformed=True)
    fits("samples", moments.number, *z.shape)
    goal = None if problem.system.iterated else options.goal()
    work: Any = (
        _Plain(flow, z, moments, callback)
        if goal is None
        else _Accurate(flow, problem.system, z, moments, goal, options.drift, callback, scheme is None)
    )
    with partial_result_on_interrupt("integrate", lambda: work.result(problem.system, options.drift, True)):
        work.run()
    return work.result(problem.system, options.drift, False)


class SampleMoments(NamedTuple):
    """The samples of a run over `time`: one at time 0 if `first`, then `number` of them at equal intervals up to the
    end or at increasing `times` (number,).
    """

    time: float
    number: int
    times: np.ndarray | None = None
    first: bool = False

    @property
    def parts(self) -> int:
        """The number of parts that steps must divide the run into: of equal samples, their intervals."""
        return max(self.number, 1) if self.times is None else 1

    @property
    def later(self) -> np.ndarray:
        """The times of the samples after time 0."""
        return self.time / self.parts * np.arange(1, self.number + 1) if self.times is None else self.times

    @property
    def all_times(self) -> np.ndarray:
        """The times of the samples."""
        return np.append(np.zeros(int(self.first)), self.later)

    def looks(self) -> Looks:
        """Return the moments at which runs are compared, MOMENTS of them at least."""
        if self.times is None:
            n = math.ceil(MOMENTS / self.number) if self.number else 1
            parts = n * self.number if self.number else MOMENTS
            return Looks(
                self.time / parts * np.arange(1, parts + 1), slice(n - 1, None, n) if self.number else slice(0), parts
            )
        times = np.union1d(self.times, self.time / MOMENTS * np.arange(1, MOMENTS + 1))
        return Looks(times, np.searchsorted(times, self.times), 1)

    def trajectory(
        self, flow: Flow | TransformedFlow, ensemble: Ensemble, callback: Callback | None
    ) -> tuple[np.ndarray, bool]:
        """Run to the end; return the samples (samples, 2n, orbits), NaN if not reached, and whether interrupted."""
        if self.times is None:
            return flow.trajectory(ensemble, self.time, self.number, callback)
        return flow.trajectory_at(ensemble, self.time, self.times, callback)

    def from_start(self, start: np.ndarray, later: np.ndarray) -> np.ndarray:
        """Return rows (samples, 2n, orbits) of all samples, given those at time 0 and later."""
        return np.concatenate([start[None], later]) if self.first else later


def _states(flow: Flow | TransformedFlow, z: np.ndarray) -> np.ndarray:
    """Return phase points z of the start as samples."""
    return flow.states(z.copy()) if isinstance(flow, Flow) else z.copy()


class Looks(NamedTuple):
    """The moments at which runs are compared, the samples among them, and the parts that steps must divide the run
    into.
    """

    times: np.ndarray
    samples: Any
    parts: int


def sample_times(samples: Any, time: float, mapping: bool = False) -> SampleMoments:
    """Return the samples as checked: a number of them, or increasing times from 0 to the time of the run."""
    if not (isinstance(samples, (list, tuple)) or getattr(samples, "ndim", False)):
        count = whole("samples", samples, 0)
        if mapping and count and time % count:
            raise ValueError(f"samples must divide the {time:g} iterates of a map, got {shown(samples)}")
        return SampleMoments(time, count)
    times = numbers("samples", samples)
    if times.ndim != 1:
        raise ValueError(f"samples must be times of shape (samples,), the same for all orbits, got shape {times.shape}")
    if not times.size:
        raise ValueError("samples must have at least one time, got none. Use samples=0 for the end alone.")
    if not np.isfinite(times).all():
        raise ValueError(f"samples must be finite times, got {times[~np.isfinite(times)][0]}")
    late = np.flatnonzero(np.diff(times) <= 0)
    if late.size:
        before, after = times[late[0] : late[0] + 2]
        raise ValueError(f"samples must be increasing times, got {after:.9g} after {before:.9g}")
    if times[0] < 0 or times[-1] > time:
        wrong = times[0] if times[0] < 0 else times[-1]
        raise ValueError(f"samples must be times from 0 to time={time:.9g}, got {wrong:.9g}")
    if mapping and (wrong := times[times != np.round(times)]).size:
        raise ValueError(f"samples of a map must be whole numbers of iterates, got {wrong[0]:.9g}")
    first = bool(times[0] == 0)
    later = np.array(times[int(first) :])
    even = SampleMoments(time, len(later), None, first)
    alike = np.abs(even.later - later) <= EVEN * later
    return even if alike.all() else even._replace(times=later)


class _Plain:
    """Orbits that are run once, with steps or tolerances that the user chose."""

    def __init__(self, flow: Flow | TransformedFlow, z: np.ndarray, moments: SampleMoments, callback: Callback | None):
        flow = flow.fitted(moments.time, moments.parts)  # the step that is used, which the result names
        self.flow = flow
        self.moments = moments
        self.callback = callback
        self.start = _states(flow, z)
        self.ensemble = flow.ensemble(z)
        self.samples = np.zeros((0, *z.shape))

    def run(self) -> None:
        """Run to the end, as far as Ctrl-C lets it."""
        self.samples, interrupted = self.moments.trajectory(self.flow, self.ensemble, self.callback)
        if interrupted:
            raise KeyboardInterrupt

    def result(self, system: System, tolerance: float, interrupted: bool) -> Orbits:
        """Return the orbits so far, without estimates of errors."""
        self.ensemble.z = self.flow.states(self.ensemble.z)
        samples = self.moments.from_start(self.start, self.samples)
        found = (self.ensemble, samples, self.moments, (None, None, None))
        how = self.flow.scheme
        return _assembled(system, how, *found, tolerance, interrupted, self.flow.step)


class Compared(NamedTuple):
    """Orbits after a run: their states at the moments of comparison (moments, 2n, orbits), the ensemble and the
    steps.
    """

    states: np.ndarray
    ensemble: Ensemble
    step: np.ndarray

    @property
    def status(self) -> np.ndarray:
        """The statuses (orbits,)."""
        return self.ensemble.status

    def of(self, orbits: np.ndarray) -> Compared:
        """Return the data of some of the orbits."""
        return Compared(self.states[..., orbits], self.ensemble.of(orbits), self.step[orbits])


class _Accurate:
    """Orbits that are run with steps halved until they agree."""

    def __init__(
        self,
        flow: Flow | TransformedFlow,
        system: System,
        z: np.ndarray,
        moments: SampleMoments,
        accuracy: float,
        drift: float,
        callback: Callback | None,
        free: bool,
    ):
        self.flow = flow
        self.system = system
        self.z = z
        self.moments = moments
        self.time = moments.time
        self.accuracy = accuracy
        self.drift = drift
        self.callback = callback
        self.times, self.sampled, self.parts = moments.looks()
        self.ensemble = Ensemble(z.copy(), system.energies(z), system.kinetic_energies(z))
        self.step, self.until, self.error = np.full(z.shape[1], np.inf), np.zeros(z.shape[1]), np.full(z.shape, np.inf)
        rows = len(self.times[self.sampled]) if moments.number else 0
        self.samples, self.sample_error = (np.full((rows, *z.shape), none) for none in (np.nan, np.inf))
        self.looks = self.times if moments.number else self.times[1::2]
        self.free = free and isinstance(flow.scheme, Collocation)
        self.rescues = free and isinstance(flow.scheme, (Splitting, Nystrom)) and not system.driven

    def run(self) -> None:
        """Run all orbits, a chunk at a time."""
        orbits = self.z.shape[1]
        with Passes(self.callback) as passes:
            for start in range(0, orbits, CHUNK):
                self.chunk = np.arange(start, min(start + CHUNK, orbits))
                self.motion = motion(self.system, z := np.ascontiguousarray(self.z[:, self.chunk]), self.flow.threads)
                with Passes(passes.take(self.chunk.size, orbits - self.chunk[-1] - 1)) as parts:
                    if self.free:
                        rest = self._short(tolerances(self.motion, self.time, self.accuracy), parts.take(1.0, SLOW))
                        self.chunk = self.chunk[rest]
                        z = z[:, rest]
                        self.motion = self.motion.of(rest)
                    if self.chunk.size:
                        self._stepped(np.ascontiguousarray(z), parts.take(1.0))

    def _short(self, tolerance: np.ndarray, callback: Callback | None) -> np.ndarray:
        how = self._toleranced, self._left, self._keep, lambda run: walled(self.system, run.states)
        return refine_tolerances(tolerance, self.accuracy, *how, callback)

    def _stepped(self, z: np.ndarray, callback: Callback | None) -> None:
        """Run the chunk with steps that are shortened until two runs agree."""
        given = (self.motion, self.time, self.accuracy)
        orbits = np.arange(len(self.chunk))
        steps = planned(self.flow, z, *given, run=self.time, parts=2 * self.parts)
        if self.free:
            rest = self._short(
                tolerances(*given, max_radians(*given[:2], steps.step * self.motion.pace < UNEVEN)), None
            )
            steps, orbits = steps_for_remaining(steps, *given, self.error[:, self.chunk].max(axis=0), rest)
        if orbits.size:
            refine_steps(
                self.flow, steps, self.accuracy, self._run, self._compare, self._keep, self._drifts, orbits, callback
            )
        if self.rescues:  # equal steps are too long for a close approach
            lost = self._lost()
            try:
                self._short(np.where(lost, FINEST, np.nan), None)
            except KeyboardInterrupt:
                self.ensemble.status[self.chunk[lost]] = Status.INTERRUPTED
                raise
        if self.free:  # the iteration may have failed next to a centre or on the axis of a chart
            lost = energy_error(self.system, self.ensemble.of(self.chunk))
            self._short(last(*given, self.error[0, self.chunk], lost), None)

    def _lost(self) -> np.ndarray:
        """Return a mask (orbits,) of the chunk: those that have another energy at the end or at a sample."""
        ended = self.ensemble.of(self.chunk)
        error = largest_energy_error(self.system, ended, self.samples[..., self.chunk])
        return (ended.status == Status.OK) & (error > self.drift)

    def _toleranced(
        self, orbits: np.ndarray, tolerance: np.ndarray, callback: Callback | None, stop: float
    ) -> Compared:
        """Return orbits with tolerances of their own, and their states at some moments; stop: see `_moments`."""
        where = self.chunk[orbits]
        z = np.ascontiguousarray(self.z[:, where])
        none = np.full(len(where), np.inf)
        whole = Compared(np.empty((len(self.looks), *z.shape)), self.ensemble.of(where), none)
        for number, each in enumerate(every := np.unique(tolerance)):
            part = np.flatnonzero(tolerance == each)
            flow = with_tolerance(self.flow, float(each))
            ensemble = flow.ensemble(np.ascontiguousarray(z[:, part]), radius=self.motion.radius[orbits[part]])
            try:
                whole.states[..., part] = self._moments(flow, ensemble, portion(callback, number, len(every)), stop)
            except KeyboardInterrupt:
                ensemble.status[:] = Status.INTERRUPTED
                self.ensemble.take(where[part], ensemble)
                self.step[where] = np.inf
                raise
            whole.ensemble.take(part, ensemble)
        return whole

    def _moments(self, flow: Flow, ensemble: Ensemble, callback: Callback | None, stop: float) -> np.ndarray:
        """Advance to the end, with the stops of STOPS; return the states that are compared (moments, 2n, orbits)."""
        if self.moments.times is not None:
            states, interrupted = flow.trajectory_at(ensemble, self.time, self.times, callback)
            flow.states(ensemble.z)
            if interrupted:
                raise KeyboardInterrupt
            return states
        if self.moments.number:
            states = flow.sampled(ensemble, self.parts, time=self.time, callback=callback).transpose(1, 2, 0)
        else:  # one run after the other: the interpolant would cost more
            states = np.empty((len(self.looks), *ensemble.z.shape))
            nothing = observers.nothing()
            for i, (now, moment) in enumerate(zip(states, self.looks, strict=True)):
                told = portion(callback, i, len(states))
                for end in (moment - (1 - stop) * self.looks[0], moment)[stop == 0 :]:
                    flow.advance(ensemble, nothing, *no_memory(ensemble), time=float(end), callback=told)
                now[:] = np.where(ensemble.status == Status.OK, ensemble.z, np.nan)
        for z in (states.transpose(1, 0, 2), ensemble.z):
            flow.states(z)
        return states

    def _left(self, fine: Compared, coarse: Compared, orbits: np.ndarray, tolerance: np.ndarray) -> tuple:
        error, usual = tolerance_errors(
            self.motion.of(orbits), self._compare(fine, coarse, orbits)[0], self.looks, tolerance
        )
        return np.where(self._drifts(fine), np.inf, error), usual

    def _run(
        self, orbits: np.ndarray, step: np.ndarray, damping: Damping | None, callback: Callback | None, _fine
    ) -> Compared:
        flow: Any = self.flow.sized(step)
        where = self.chunk[orbits]
        ensemble = flow.ensemble(np.ascontiguousarray(self.z[:, where]), radius=self.motion.radius[orbits])
        if self.moments.times is not None:
            states, interrupted = flow.trajectory_at(ensemble, self.time, self.times, callback, damping)
        elif damping is None:
            states, interrupted = flow.trajectory(ensemble, self.time, self.parts, callback)
        else:
            states, interrupted = flow.damped(ensemble, self.parts, damping, time=self.time, callback=callback)
        ensemble.z = flow.states(ensemble.z)
        used = step if math.isfinite(np.max(flow.step)) else np.full(len(step), np.inf)
        if interrupted:
            ensemble.status[:] = Status.INTERRUPTED  # whatever their outcome with these steps
            self.ensemble.take(where, ensemble)
            self.step[where] = used
            raise KeyboardInterrupt
        return Compared(states, ensemble, used)

    def _compare(self, fine: Compared, coarse: Compared, orbits: np.ndarray, _weight: Any = None) -> tuple:
        apart = self.motion.of(orbits).between(fine.states, coarse.states, self.flow.threads)
        return apart, self.times[:, None] * self.motion.rate[orbits], np.ones((1, orbits.size))

    def _drifts(self, run: Compared) -> np.ndarray:
        return (run.ensemble.status == Status.OK) & (energy_error(self.system, run.ensemble) > self.drift)

    def _keep(self, orbits: np.ndarray, fine: Compared, chosen: np.ndarray, error: np.ndarray) -> None:
        own = self.motion.of(orbits[chosen])
        where = self.chunk[orbits[chosen]]
        error = error[:, chosen]
        times = self.times if len(error) == len(self.times) else self.looks
        times = np.broadcast_to(times[:, None], error.shape)
        size = np.maximum(np.vstack([own.position, own.momentum]), 1e-300)  # amplitudes may be 0
        late = until(error <= self.accuracy, times, self.times[-1])
        failed = fine.status[chosen] == Status.NOT_CONVERGED  # else shorter steps and tighter tolerances know better
        worse = failed | (np.isfinite(fine.step[chosen]) ^ np.isfinite(self.step[where]))
        worse &= is_dominated(error[-1], late, self.error[0, where] / size[0], self.until[where])
        chosen, where, error, size, late = (entry[..., ~worse] for entry in (chosen, where, error, size, late))
        self.ensemble.take(where, fine.ensemble.of(chosen))
        self.step[where] = fine.step[chosen]
        self.until[where] = late
        self.samples[..., where] = fine.states[self.sampled][..., chosen]
        self.error[:, where] = error[-1] * size
        self.sample_error[..., where] = error[self.sampled, None] * size

    def result(self, system: System, tolerance: float, interrupted: bool) -> Orbits:
        """Return the orbits so far, with the estimated errors."""
        moments = self.moments
        samples = moments.from_start(_states(self.flow, self.z), self.samples)
        sample_error = moments.from_start(np.zeros_like(self.error), self.sample_error)
        found = self.ensemble, samples, moments, (self.error, sample_error, self.until)
        toleranced = self.free or (self.rescues and not interrupted)  # steps of orbits that did not begin are inf too
        scheme = VERNER9 if toleranced and np.isinf(self.step).all() else self.flow.scheme
        return _assembled(system, scheme, *found, tolerance, interrupted, self.step)


def largest_energy_error(system: System, ensemble: Ensemble, samples: np.ndarray) -> np.ndarray:
    """Return the largest energy errors (orbits,) at the end and at samples (samples, 2n, orbits)."""
    energy = energy_error(system, ensemble)
    together = max(1, POINTS // max(1, len(energy)))
    for first in range(0, len(samples), together):
        z = samples[first : first + together].transpose(1, 0, 2)
        drift = energy_drift(system, z, ensemble.energy, ensemble.scale)
        energy = np.maximum(energy, np.where(np.isfinite(z).all(axis=0), drift, 0.0).max(axis=0))
    return energy


def _assembled(
    system: System, scheme, ensemble, samples, moments: SampleMoments, errors: tuple, tolerance, interrupted, step
) -> Orbits:
    """Return the orbits with their energy errors and statuses."""
    if interrupted:
        ensemble.status[(ensemble.status == Status.OK) & (ensemble.time < moments.time * (1 - 1e-12))] = (
            Status.INTERRUPTED
        )
    energy = largest_energy_error(system, ensemble, samples)
    mark_drift(ensemble, energy, tolerance)
    return Orbits(
        z=ensemble.z,
        t=ensemble.time,
        times=moments.all_times[: len(samples)],
        samples=samples,
        error=errors[0],
        sample_error=errors[1],
        accurate_until=errors[2],
        energy_error=energy,
        status=ensemble.status,
        scheme=scheme,
        step=step,
        names=system.row_names,
    )
