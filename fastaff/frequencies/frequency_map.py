"""Frequency maps: fundamental frequencies of many orbits, their errors and their diffusion."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.classification import is_regular
from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, Passes, fits, kind_of, shown, whole
from ..core.status import Status
from ..engine.jit import LANES
from ..engine.kernels.samples import CHUNK_ROWS
from ..results.calls import Starts, coerces_arguments, records_call
from ..runs import observers, scales
from ..runs.accuracy import HALVINGS, round_down_to_grid
from ..runs.flow import Ensemble, Flow, energy_error, mark_drift
from ..runs.options import Options, Problem
from ..runs.requirements import check_needs, checked_model
from ..runs.scales import natural_rates
from ..runs.schemes.catalogue import Scheme, scheme_of
from ..runs.starts import starts_of
from ..systems.models.contracts import Angles, Dynamics
from ..systems.models.mechanics import system_of
from .angle_loops import Plain, SignalLayout, named_signals, suited
from .found_frequencies import FrequencyTable
from .frequencies import FrequencyMap
from .fundamental import fastest
from .map_frequencies import map_frequencies
from .readings import SampledOrbits, read
from .signals import BUFFERS, ReusableBuffer, Signals
from .turning import unresolved
from .windows import BRIEF

ACCURACY = 1e-11
"""Relative error that the scheme may leave in frequencies where neither a step nor an accuracy is asked for."""

BUDGET = 1 << 27
"""Bytes of samples in memory at once."""

MOST = 1 << 29
"""The same for long orbits, as few of them do not fill a block of lanes."""

PROBE = 128
"""Steps of the trial that measures the speed of an orbit."""

DENSE = 1.1
"""Radians of the fastest motion between samples."""

BODY_DENSE = 0.8
"""The same of bodies, whose own angles are followed from one sample to the next."""

FINER = 0.1
"""Share of the progress that runs with finer steps take."""

PILOT_WORK = 0.4
"""Work of short runs with half the step, in units of the run, for the progress."""

READING = 6.0
"""Work of reading the samples, in the same unit."""

PARTS = 8
"""Parts read between reports of the progress."""

BESIDE = 0.1
"""Share of a frequency's error from which the scheme's counts."""

PILOT = 16
"""Most parts of the time, of which a pilot with half the step takes one: it shows the step's error."""

PILOT_STEPS = 128
"""Least steps of a pilot."""

PILOT_SAMPLES = 48
"""Least samples of a pilot."""

SIZES = np.array([16 * q * 2**k for k in range(40) for q in (4, 5, 6, 7)])
"""Numbers of samples: few, as orbits of equal numbers are read together, all multiples of those of pilots."""

LONGEST = 1.5
"""Radians of the fastest small oscillation of an orbit that a step may have: more would show another frequency."""


@coerces_arguments(z0=starts_of, scheme=scheme_of, signals=named_signals)
@records_call
@inserts_parameters
def frequency_map(
    model: Dynamics,
    z0: Starts,
    *,
    time: float,
    accuracy: float | None = None,
    signals: Angles | str | None = None,
    window: int | None = None,
    step: float | np.ndarray | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    energy_tolerance: float | None = None,
    lines: int | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> FrequencyMap:
    r"""Compute the fundamental frequencies of orbits.

    Parameters
    ----------
    {model}
    {z0}
    time : float
        Length of the run, in units of time; for a map the number of iterates, 64 or more. Use 50 periods of the motion
        or more: orbits with fewer than 18 are UNDECIDED.
    accuracy : float, default 1e-11
        Requested error of the frequencies due to the integration, relative to the largest frequency of an orbit. It
        determines the step size of each orbit. A short `time` causes further errors, which ``error`` includes. Not
        supported for ODE systems and adaptive methods; use `rtol` and `atol`.
    {signals}
    window : int, optional
        For maps only: number of iterates of a window. The frequencies are those of the first window. The diffusion
        compares the first with the last window. Default: half of the run.
    step : float or array_like, shape (orbits,), optional
        Largest fixed step size, in units of time, instead of `accuracy`. For an adaptive method it is the interval
        between samples, by default 1/16 of the time of a radian of the motion.
    {scheme}
    {rtol}
    {atol}
    {energy_tolerance}
    {lines}
    {threads}
    {callback}

    Returns
    -------
    `FrequencyMap`
        Frequencies in cycles per unit time, with error estimates, diffusion and classification of each orbit.

    Raises
    ------
    ValueError
        If a value is out of its range, `window` is given for a system in time, or `signals` for a map.
    TypeError
        If an argument is of a wrong kind, or does not suit the model.
    Interrupted
        On Ctrl-C, with the orbits finished so far in ``.partial``.

    Notes
    -----
    - Method: each coordinate and momentum form a complex signal. Its spectral lines are found by harmonic inversion
      near peaks of its transform. Fundamental frequencies are independent lines that generate the others; each is
      assigned to the coordinate with its largest amplitude.
    - Diffusion: :math:`\log_{10} \max_i |\nu_i^{(1)} - \nu_i^{(2)}|` of the halves of the run.
    - Errors: 5 times (:math:`5(n - 1)` for :math:`n > 2`) the largest of a line's growth, its residual and its change
      in shorter windows. The integration error from a partial run with half the step is added. Resonances slower
      than the run increase errors.
    - Cost: the run, the partial run, a transform of each signal. Memory: 256 MiB, or 640 MiB for long orbits.

    See the explanation page on frequencies.

    References
    ----------
    Laskar 1990, Icarus 88, 266 (frequency maps, diffusion); Papaphilippou & Laskar 1996, Astron. Astrophys. 307, 427,
    and Valluri & Merritt 1998, Astrophys. J. 506, 686 (independent lines); Das, Saiki, Sander & Yorke 2017,
    Nonlinearity 30, 4111 (weighted averages); Wall & Neuhauser 1995, J. Chem. Phys. 102, 8011, and Mandelshtam & Taylor
    1997, J. Chem. Phys. 107, 6756 (harmonic inversion); the paper's nu = dE/dJ.

    Examples
    --------
    >>> freq = fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0)
    >>> freq.nu.round(6)
    array([[0.15556 ],
           [0.159622]])
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
    checked_model(problem.model, needs="regular motion")
    lines = None if lines is None else whole("lines", lines, 1)
    if problem.system.iterated:
        return map_frequencies(problem, time=time, window=window, signals=signals, lines=lines)
    if window is not None:
        raise ValueError(
            f"window must be None for a system in time, got {shown(window)}. The windows are the halves of the run."
        )
    if signals is None and getattr(problem.model, "angles", None) is None:
        check_needs(problem.system, "signals of coordinates alone")
    goal = options.goal(ACCURACY)
    signals = checked_signals(signals, problem.model)
    flow, z, *_ = problem.plan(time=time, error=goal or ACCURACY)
    work = FrequencyWork(flow, signals, z, time, goal, callback, lines)
    with partial_result_on_interrupt("frequency_map", lambda: work.result(options.drift)):
        work.run(options.drift)
    return work.result(options.drift)


def checked_signals(signals: Any, model: Any) -> Any:
    """Return `signals`, or those natural to the body for None, if they suit it; `Plain` where it has none."""
    system = system_of(model)
    chosen: Any = getattr(model, "angles", None) if signals is None else signals
    if signals is None and (chosen is None or (any(chosen.planes) and not system.conserves_spins)):
        return Plain(system.names)  # without the symmetry the planes' angles are coordinates like others
    if not all(hasattr(chosen, name) for name in ("signals", "names", "planes")):
        raise TypeError(
            f"signals must be a text such as 'R z phi', or a value of fastaff.models.angles, got {shown(chosen)}"
        )
    suited(chosen, model.degrees_of_freedom, kind_of(model))
    return chosen


class FrequencyWork:
    """A frequency map in the making; arrays over angles and orbits hold the results so far."""

    def __init__(
        self,
        flow: Flow,
        signals: Any,
        z0: np.ndarray,
        time: float,
        accuracy: float | None,
        callback: Callback | None,
        lines: int | None = None,
    ):
        if not flow.adaptive:
            self.rate = scales.fastest_rates(flow.system, z0, flow.step)
            flow = resolving(flow, self.rate, time)
        self.flow = flow
        self.angles = signals
        self.z0 = z0
        self.time = time
        self.callback = callback
        self.accuracy = accuracy
        self.layout = SignalLayout(signals, flow.model.degrees_of_freedom, flow.system.periods)
        self.n = len(signals.names)
        self.orbits = z0.shape[1]
        self.ensemble: Ensemble = flow.ensemble(z0.copy())
        self.found = FrequencyTable(self.layout, self.orbits, lines)
        self.unfinished = np.ones(self.orbits, bool)
        self.used = np.full(self.orbits, np.nan)

    def run(self, tolerance: float = math.inf) -> None:
        """Find the frequencies of all orbits; with an accuracy, again with half the step where the scheme's error is
        larger.
        """
        flow = self.flow
        orbits = np.arange(self.orbits)
        before = np.full((2, self.orbits), np.inf)
        with Passes(self.callback) as passes:
            for _ in range(HALVINGS + 1):
                self._pass(flow, orbits, passes.take(1.0, 0.0 if self.accuracy is None else FINER))
                if self.accuracy is None:
                    return
                excess = self._excess(self.accuracy, tolerance)
                # An error that a finer step does not reduce is rounding, or chaos.
                again = np.asarray(((excess > 1) & (excess < before / 4)).any(axis=0))
                self.unfinished = again
                if not again.any():
                    return
                orbits = np.flatnonzero(again)
                before = np.where(again, np.where(excess > 0, excess, np.inf), 0.0)
                flow = flow.finer()
        self.unfinished[:] = False

    def _excess(self, accuracy: float, tolerance: float) -> np.ndarray:
        """Return the ratios (2, orbits) of the scheme's errors to those allowed for frequencies and for energy; 0 where
        there are none.
        """
        found = self.found
        known = is_regular(found.classification(self.time))
        share = np.where(np.isfinite(found.scheme_error), found.scheme_error, 0.0)
        # A finer step does not help where the time is too short.
        share = np.where(share > BESIDE * found.error, share, 0.0).max(axis=0)
        share = np.where(known, share / np.maximum(np.abs(found.nu).max(axis=0), 1e-300), 0.0)
        energy = np.nan_to_num(energy_error(self.flow.system, self.ensemble), nan=0.0, posinf=0.0)
        return np.where(self.ensemble.status == Status.OK, np.stack([share / accuracy, energy / tolerance]), 0.0)

    def _pass(self, flow: Flow, orbits: np.ndarray, callback: Callback | None) -> None:
        """Sample these orbits and find their frequencies, as many at a time as memory allows."""
        counts, steps = self._counts(flow, orbits)
        fits("time", self.layout.rows, int(counts.max(initial=0)))  # samples of one orbit
        order = np.argsort(counts, kind="stable")
        begin = 0
        passes = Passes(callback)
        while begin < orbits.size:
            ahead = counts[order[begin:]]
            number = np.arange(1, ahead.size + 1)
            room = np.where(number > flow.threads * LANES, BUDGET, MOST)
            full = (8 * self.layout.rows * np.cumsum(ahead) > room) | (flow.adaptive & (ahead != ahead[0]))
            end = begin + (1 + int(full[1:].argmax()) if full[1:].any() else ahead.size)
            part = np.sort(order[begin:end])
            stages = Passes(passes.take(counts[part].sum(), counts[order[end:]].sum()))
            self._portion(flow, orbits[part], counts[part], steps[part], stages)
            begin = end

    def _counts(self, flow: Flow, orbits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of samples (orbits,) that orbits need, and of steps, a multiple of these."""
        if flow.adaptive:
            interval = flow.step
            if not np.isfinite(flow.step):
                interval = 1 / (16 * natural_rates(flow.system, self.z0[:, orbits], flow.threads))
            # By powers of 2: orbits of equal numbers are read together.
            found = 2 ** np.ceil(np.log2(np.maximum(64, np.broadcast_to(self.time / interval, orbits.size))))
            return found.astype(np.int64), found.astype(np.int64)
        steps = np.broadcast_to(np.maximum(64, flow.of(orbits).steps(self.time)), orbits.size)
        need = np.empty(orbits.size)
        layout = self.layout
        radians = BODY_DENSE if layout.body else DENSE
        portion = max(LANES, BUDGET // (8 * layout.rows * PROBE))
        for at in range(0, orbits.size, portion):
            part = slice(at, min(at + portion, orbits.size))
            step = np.broadcast_to(flow.of(orbits[part]).step, need[part].size)
            counts = np.full(need[part].size, PROBE)
            brief = replace(flow, step=step)
            seen, run = self._sampled(brief, orbits[part], PROBE * step, counts, BUFFERS.signals)
            with np.errstate(all="ignore"):
                dense = self.time * fastest(seen.array(np.arange(counts.size)), 1.0, flow.threads) / step / radians
            dense = np.maximum(dense, self.time * self.rate[orbits[part]] / LONGEST)
            need[part] = np.where((run.status == Status.OK) & np.isfinite(dense), dense, steps[part])
        counts = sample_counts(need, steps)
        return counts, counts * -(-steps // counts)

    def _portion(self, flow: Flow, orbits: np.ndarray, counts: np.ndarray, steps: np.ndarray, passes: Passes) -> None:
        """Find the frequencies of these orbits from so many samples, and so many steps."""
        share = pilot_share(steps, counts)
        order = np.argsort(counts, kind="stable")  # those of equally many samples side by side
        orbits = orbits[order]
        counts = counts[order]
        steps = steps[order]
        share = share[order]
        if not flow.adaptive:
            flow = replace(flow, step=self.time / steps)
        signals, run = self._sampled(
            flow, orbits, self.time, counts, BUFFERS.signals, passes.take(1.0, PILOT_WORK + READING)
        )
        told = passes.take(PILOT_WORK, READING)
        start, _ = self._sampled(flow.finer(), orbits, self.time / share, counts // share, BUFFERS.starts, told)
        self.ensemble.take(orbits, run)
        self.used[orbits] = self.time / steps
        done = np.flatnonzero((run.status == Status.OK) & (run.time >= self.time * (1 - 1e-12)))
        # Tables are longer than the samples of a long orbit: these are read by equal numbers.
        kinds = np.where(counts[done] > BRIEF, counts[done], 0)
        left = done.size
        scheme = self.flow.scheme
        for alike in np.split(done, np.flatnonzero(np.diff(kinds)) + 1) if done.size else ():
            parts = max(1, math.ceil(8 * self.layout.rows * float(counts[alike].sum()) / BUDGET))
            told = 0 if passes.callback is None else min(PARTS, alike.size // (LANES * flow.threads))
            for some in np.array_split(alike, min(max(parts, told), alike.size)):
                samples = SampledOrbits(signals.of(some), start.of(some), scheme.order if scheme.symplectic else 0)
                left -= some.size
                with Passes(passes.take(some.size, left)):
                    self._adopt(orbits[some], samples)
        self.unfinished[orbits] &= self.accuracy is not None  # lost orbits have no more samples

    def _sampled(
        self,
        flow: Flow,
        orbits: np.ndarray,
        time: Any,
        counts: np.ndarray,
        room: ReusableBuffer,
        callback: Callback | None = None,
    ) -> tuple[Signals, Ensemble]:
        """Return so many samples of the signals of these orbits, and the orbits' ends; samples that were not reached
        are arbitrary.
        """
        rows = self.layout.rows
        step = flow.step
        if isinstance(step, np.ndarray) and step.size != orbits.size:
            flow = flow.of(orbits)
        run = flow.ensemble(np.ascontiguousarray(self.z0[:, orbits]), radius=self.ensemble.radius[orbits])
        start = np.cumsum(rows * counts) - rows * counts
        signals = Signals(room.array(rows * int(counts.sum())), rows, start, counts, time / counts)
        observer = observers.called_rows(self.layout.call, rows)
        memory = np.zeros((observer.rows, orbits.size))
        memory[CHUNK_ROWS.length] = counts
        memory[CHUNK_ROWS.start] = start
        alike = flow.adaptive
        time, observations = (float(np.max(time)), int(counts[0])) if alike else (time, counts)
        flow.advance(
            run, observer, memory, signals.numbers[None], time=time, observations=observations, callback=callback
        )
        return signals, run

    def _adopt(self, orbits: np.ndarray, samples: SampledOrbits) -> None:
        """Fill in the results from samples of these orbits."""
        found = read(self.layout, samples, self.flow.threads)
        if self.found.lines is not None:  # before the orbits count as finished
            # The first sample is an interval after the start.
            self.found.lines.adopt(orbits, self.layout, samples.run, 1.0)
        self.found.adopt(orbits, found)
        self.unfinished[orbits] &= self.accuracy is not None  # with one, once its error is judged

    def result(self, tolerance: float = math.inf) -> FrequencyMap:
        """Assemble the map."""
        ensemble = self.ensemble
        found = self.found
        energy = energy_error(self.flow.system, ensemble)
        mark_drift(ensemble, energy, tolerance)
        ensemble.status[((ensemble.status == Status.OK) & ~found.reached) | self.unfinished] = Status.INTERRUPTED
        nu = found.nu
        error = found.error
        if not self.flow.scheme.symplectic:  # the energy drifts, and frequencies with it
            error = error + 2 * np.nan_to_num(energy, posinf=0.0) * np.abs(nu).max(axis=0)
        if self.flow.system.driven and self.angles == getattr(self.flow.model, "angles", None):
            nu, error = self._known_drive(nu, error, found.basis)
        return found.assembled(
            nu,
            error,
            ensemble.status,
            t=ensemble.time,
            time=self.time,
            step=self.flow.step if self.flow.adaptive else self.used,
            read=self.time,
            energy_error=energy,
            scheme=self.flow.scheme,
        )

    def _known_drive(self, nu: np.ndarray, error: np.ndarray, basis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return frequencies and errors (n, orbits), with the exact one of the drive, the last, if it was found."""
        nu = nu.copy()
        error = error.copy()
        known = 1 / float(self.flow.model.period)
        found = (basis[-1, -1] == 1) & (basis[-1, :-1] == 0).all(axis=0) & (np.abs(nu[-1] - known) <= 2 * error[-1])
        nu[-1] = np.where(found, known, nu[-1])
        error[-1] = np.where(found, np.finfo(float).eps * known, error[-1])
        # Next to a fraction of the drive an orbit may turn in an island, too slowly to be seen.
        slow = known * unresolved(nu[:-1] / known, self.time * known)
        error[:-1] = error[:-1] + np.where(found, slow, 0.0)
        return nu, error


def resolving(flow: Flow, rate: np.ndarray, time: float) -> Flow:
    """Return the flow with steps that resolve the fastest oscillation (orbits,) of each orbit, however weak."""
    long = rate * flow.step > LONGEST
    if not long.any():
        return flow
    return replace(flow, step=np.where(long, round_down_to_grid(LONGEST / np.where(long, rate, 1.0), time), flow.step))


def sample_counts(need: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return numbers of samples (orbits,), few different ones, that are enough for those needed and take few more steps
    than `steps`.
    """
    need = np.clip(need, SIZES[0], SIZES[-4])
    first = np.searchsorted(SIZES, need * (1 - 1e-9))
    choice = SIZES[first[:, None] + np.arange(3)]
    cost = choice * -(-steps[:, None] // choice) / steps[:, None] + 0.1 * choice / need[:, None]
    return np.take_along_axis(choice, cost.argmin(axis=1)[:, None], axis=1)[:, 0]


def pilot_share(steps: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the divisor of steps and samples for the pilot: PILOT, or a smaller power of 2 that leaves it PILOT_STEPS
    and PILOT_SAMPLES.
    """
    room = np.maximum(np.minimum(steps // PILOT_STEPS, counts // PILOT_SAMPLES), 1)
    return np.minimum(PILOT, 2 ** np.floor(np.log2(room)).astype(np.int64))
