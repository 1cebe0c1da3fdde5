"""Frequency maps: fundamental frequencies of many orbits, their errors and their diffusion (layer L3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import observers
from .boundary import checked_model
from .engine import Ensemble, Flow, Interrupted, Report, energy_error, mark_drift
from .kernels.rotation import PER_ANGLE, SHARED, WEIGHTS
from .motion import typical_rate
from .naff import naff
from .recipe import recorded
from .scalars import positive
from .schemes import KAHAN_LI8, RungeKutta, Splitting
from .shown import screen
from .status import Status, describe, raise_if_failed
from .trials import make_flow

METHODS = ("birkhoff", "naff")
NAFF_SAMPLES = 4096
SAFETY = 3.0
"""Factor of error estimates over the difference of half-windows: covers 99 % of the errors (bench/test_frequency.py)."""

CHUNK = 1024
"""Orbits whose sampled signals are in memory at once."""


@dataclass(frozen=True)
class FrequencyMap:
    """Fundamental frequencies of orbits.

    names: one for each row of nu (n, orbits), in cycles per unit time (`omega` = 2 pi nu); error (n, orbits), the estimate
    3 |nu(first half) - nu(second half)| of each, with what rounding and the energy error add; method (n, orbits), an index
    into METHODS: which method gave the value;
    diffusion (orbits,) = log10 of the largest |nu(first half) - nu(second half)|, for a body over nu_eta and nu_gamma, whose
    angles are well defined on every orbit; energy_error, status (orbits,).
    For a body the rows are two librations, phi and psi; nu_eta and nu_gamma are kept beside them.
    """

    names: tuple[str, ...]
    nu: np.ndarray
    error: np.ndarray
    diffusion: np.ndarray
    method: np.ndarray
    energy_error: np.ndarray
    status: np.ndarray
    nu_eta: np.ndarray | None
    nu_gamma: np.ndarray | None
    time: float
    scheme: Splitting | RungeKutta
    step: float | np.ndarray

    def __repr__(self) -> str:
        return screen(self)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu, in radians per unit time."""
        return 2 * np.pi * self.nu

    def raise_if_failed(self) -> None:
        """Raise OrbitError unless every orbit is OK."""
        raise_if_failed(self.status)

    def summary(self) -> str:
        """Say in one line what became of the orbits."""
        return describe(self.status)


@recorded
def frequency_map(
    body: Any, z0: Any, *, time: float, method: str = "birkhoff", angles: Any = None, fallback: float = 1e-9,
    step: float | np.ndarray | None = None, scheme: Splitting | RungeKutta = KAHAN_LI8, rtol: float = 1e-12, atol: float = 1e-12,
    energy_tolerance: float = 1e-6, threads: int | None = None, report: Report | None = None,
) -> FrequencyMap:  # fmt: skip
    """Find the fundamental frequencies of orbits of `body` from `z0` over `time`.

    Parameters: z0 (2n,) or (2n, orbits); time > 0, best 100 periods or more; method "birkhoff" or "naff"; angles: a value of
    `fastaff.angles` (default: those natural to the potential); step: for an adaptive scheme the interval between the states that
    are averaged (default: a sixteenth of a typical radian); fallback: relative error estimate above which a Birkhoff
    value is replaced by the NAFF one where that has the smaller error and agrees with it (inf: never); the other options as in `integrate`.
    Returns FrequencyMap. Raises ValueError or TypeError for wrong input; Interrupted on Ctrl-C, with `.partial`.

    Birkhoff: nu = sum w_k (theta_(k+1) - theta_k)/(2 pi sum w_k dt) of the angle of a loop f = Q - c - i kappa P (see
    `fastaff.angles`), streamed over every step; w = exp(30 (sqrt(1 - x^2) - 1)), so a line at distance d from zero frequency
    is damped below 2e-12 once d*time > 9.6. Centre and scale of each orbit come from a first pass of a sixteenth of the time.
    NAFF: the leading line of the sampled loop, 4096 samples for each orbit, 1024 orbits in memory at a time.
    Errors: from the difference of the values of the two halves; it bounds the error of the whole, which converges faster, for
    99 % of regular orbits, and is the diffusion of chaotic ones. Memory of a Birkhoff map: about 70 numbers for each
    orbit, whatever `time` is.
    Source: Laskar 1990, Icarus 88, 266 (frequency maps, diffusion); Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111
    (weighted averages); the paper's nu = dE/dJ.
    """
    time, tolerance = positive("time", time), positive("energy_tolerance", energy_tolerance)
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(map(repr, METHODS))}, got {method!r}")
    if isinstance(fallback, bool) or not (isinstance(fallback, (int, float, np.number)) and fallback > 0):
        raise ValueError(f"fallback must be a positive number or inf, got {fallback!r}")
    angles = checked_angles(angles, checked_model(body))
    flow, z = make_flow(body, z0, scheme, step, rtol, atol, threads, time=time, error=1e-11)
    work = _Work(flow, angles, z, time, report)
    interrupted = False
    try:
        work.prepare()
        if method == "naff":
            work.naff(np.ones(work.nu.shape, bool))
        else:
            work.birkhoff()
            if fallback < math.inf:
                work.naff((work.error > fallback * np.abs(work.nu).max(axis=0)) & work.reached)
    except KeyboardInterrupt:
        interrupted = True
    result = work.result(tolerance)
    if interrupted:
        stopped = Interrupted("frequency_map")
        stopped.partial = result
        raise stopped
    return result


def checked_angles(angles: Any, body: Any) -> Any:
    """Return `angles`, or those natural to the body for None, if they suit it."""
    chosen: Any = getattr(body, "angles", None) if angles is None else angles
    if not all(hasattr(chosen, name) for name in ("signals", "names", "planes")):
        raise TypeError(
            f"angles must be a value of fastaff.angles such as AlphaBeta(), got {chosen!r}; "
            f"{type(body).__name__} has no `angles` of its own"
        )
    if len(chosen.names) != body.degrees_of_freedom:
        raise ValueError(f"angles must have {body.degrees_of_freedom} angles for {type(body).__name__}, got {chosen!r}")
    return chosen


def _leading(f: np.ndarray, dt: float, lines: int) -> np.ndarray:
    """Return the frequency of the largest of `lines` lines of each signal."""
    return naff(np.ascontiguousarray(f), dt, lines=lines).nu[..., 0]


class _Sums:
    """Memory of the rotation observer, with its shared rows and each angle's own as views."""

    def __init__(self, n: int, orbits: int):
        start = 8 * n + 2 + SHARED
        self.memory = np.zeros((start + WEIGHTS + PER_ANGLE * n, orbits))
        self.shared = self.memory[start - SHARED : start]
        self.own = self.memory[start + WEIGHTS :].reshape(n, PER_ANGLE, orbits)


class _Work:
    """A frequency map in the making; arrays over angles and orbits hold what is known so far."""

    def __init__(self, flow: Flow, angles: Any, z0: np.ndarray, time: float, report: Report | None):
        self.flow, self.angles, self.z0, self.time, self.report = flow, angles, z0, time, report
        self.n, self.orbits = len(angles.names), z0.shape[1]
        self.ensemble: Ensemble = flow.ensemble(z0.copy())
        if flow.adaptive:
            interval = flow.step if np.isfinite(flow.step) else 1 / (16 * typical_rate(flow.model, z0))
            self.observations = max(64, int(time / interval))
        else:
            self.flow = flow.fitted(time, 32)
            self.observations = 0
        self.nu = np.zeros((self.n, self.orbits))
        self.halves = np.zeros((2, self.n, self.orbits))
        self.error = np.full((self.n, self.orbits), np.inf)
        self.method = np.zeros((self.n, self.orbits), np.int8)
        self.reached = np.zeros(self.orbits, bool)
        self.window = np.full(self.orbits, time)
        self.centre, self.kappa = np.zeros((self.n, self.orbits)), np.ones((self.n, self.orbits))

    def prepare(self) -> None:
        """Find each orbit's centres and scales from the ranges of the signals over a sixteenth of the time."""
        observer = observers.extents(self.angles)
        signals, pilot_time = 4 * self.n, self.time / 16
        memory = np.zeros((observer.rows, self.orbits))
        start = self._signals(self.z0)
        memory[signals : 2 * signals], memory[2 * signals :] = start, start
        self._pilot(observer, memory, pilot_time)
        if any(self.angles.clocks):
            sums = self._sums(pilot_time)
            self._pilot(observers.rotation(self.angles, self.flow.model, pilot_time), sums.memory, pilot_time)
            with np.errstate(all="ignore"):
                rate = sums.shared[8] / sums.shared[5]
            # Closed a little early: the clock's end is known only as well as its mean rate is from the first pass.
            self.window = np.where(np.isfinite(rate) & (rate > 0), 0.995 * rate * self.time, self.time)
        low = memory[signals : 2 * signals].reshape(self.n, 4, -1)
        high = memory[2 * signals :].reshape(self.n, 4, -1)
        width = high - low
        for k, plane in enumerate(self.angles.planes):
            q, p = np.maximum(width[k, 0], width[k, 1]), np.maximum(width[k, 2], width[k, 3])
            scale = np.where((q > 0) & (p > 0), q / np.where(p > 0, p, 1.0), 1.0)
            scale = np.where(np.isfinite(scale), scale, 1.0)
            s = start.reshape(self.n, 4, -1)[k]
            turning = s[0] * s[3] - s[1] * s[2]
            self.centre[k] = 0.0 if plane else np.nan_to_num((low[k, 0] + high[k, 0]) / 2)
            self.kappa[k] = scale * np.where(turning < 0, -1.0, 1.0) if plane else scale

    def _pilot(self, observer: observers.Observer, memory: np.ndarray, time: float) -> None:
        pilot = self.flow.ensemble(self.z0.copy())
        self.flow.advance(
            pilot, observer, memory, np.zeros((1, 1)), time=time, observations=self.observations // 16
        )

    def _signals(self, z: np.ndarray) -> np.ndarray:
        return np.array(self.angles.signals(*z))

    def _sums(self, window: Any) -> _Sums:
        """Return fresh memory of the rotation observer: the clock at the start of the orbits, its window, centres, scales."""
        sums = _Sums(self.n, self.orbits)
        n = self.flow.model.degrees_of_freedom
        slopes = (*self.flow.model.velocity(*self.z0[n:]), *self.flow.model.force(*self.z0[:n]))
        sums.shared[2], sums.shared[3] = self.angles.rates(*self.z0, *slopes)[-2:]
        sums.shared[4] = window
        sums.own[:, 0], sums.own[:, 1] = self.centre, self.kappa
        return sums

    def birkhoff(self) -> None:
        """Stream the weighted averages of the angles' rates."""
        observer = observers.rotation(self.angles, self.flow.model, self.time)
        sums = self._sums(self.window)
        shared, own = sums.shared, sums.own
        try:
            self.flow.advance(
                self.ensemble, observer, sums.memory, np.zeros((1, 1)), time=self.time,
                observations=self.observations,
                report=self.report,
            )  # fmt: skip
        finally:
            self.reached = (self.ensemble.time >= self.time * (1 - 1e-12)) & (self.ensemble.status == Status.OK)
            clocks = np.array(self.angles.clocks)[:, None, None]
            with np.errstate(all="ignore"):
                in_time, in_clock = 1 / shared[5:8], shared[8:11] / shared[5:8] / shared[11:14]
                rates = own[:, 2:5] * np.where(clocks == 1, in_clock, in_time) / (2 * np.pi)
            rates = np.where(self.reached & np.isfinite(rates), rates, 0.0)
            self.nu, self.halves = rates[:, 0], np.array([rates[:, 1], rates[:, 2]])
            # A numerical orbit follows a slightly different energy: what its drift says counts as error, and so does rounding.
            drift = np.nan_to_num(energy_error(self.flow.model, self.ensemble), posinf=0.0)
            floor = (1e-13 + 2 * drift) * np.abs(self.nu).max(axis=0)
            # Where the clock ended before its window did, the missing part of the window counts as error too.
            missing = np.where(clocks[:, 0] == 1, np.maximum(0.0, 1.0 - shared[1] / self.window), 0.0)
            floor = floor + np.where(missing > 1e-3, missing, 0.0) * np.abs(self.nu).max(axis=0)
            self.error = np.where(self.reached, SAFETY * np.abs(self.halves[0] - self.halves[1]) + floor, np.inf)

    def naff(self, chosen: np.ndarray) -> None:
        """Give the chosen (angle, orbit) pairs the leading line of their loop where its error is smaller than what is known."""
        observer = observers.signal_samples(self.angles)
        steps = self.observations or int(np.max(self.flow.steps(self.time)))
        size = min(NAFF_SAMPLES, 2 ** int(np.log2(max(64, steps))))
        signals = 4 * self.n
        where = np.flatnonzero(chosen.any(axis=0))
        for begin in range(0, where.size, CHUNK):
            part = where[begin : begin + CHUNK]
            run = self.flow.ensemble(np.ascontiguousarray(self.z0[:, part]))
            memory, out = np.zeros((observer.rows, part.size)), np.zeros((part.size, size * signals))
            self.flow.of(part).advance(run, observer, memory, out, time=self.time, observations=size)
            for name in ("z", "status", "count", "time"):
                getattr(self.ensemble, name)[..., part] = getattr(run, name)
            s = out.reshape(part.size, size, self.n, 4).transpose(3, 2, 0, 1)
            self.reached[part] = (run.status == Status.OK) & (run.time >= self.time * (1 - 1e-12))
            self.reached[part] &= np.isfinite(s).all(axis=(0, 1, 3))
            for k in range(self.n):
                own = chosen[k, part] & self.reached[part]
                q, p = s[0, k, own] + 1j * s[1, k, own], s[2, k, own] + 1j * s[3, k, own]
                if own.any():
                    centre, kappa = self.centre[k, part[own], None], self.kappa[k, part[own], None]
                    self._adopt(k, part[own], q - centre - 1j * kappa * p, self.time / size)
            if self.report is not None:
                self.report((begin + part.size) / where.size)

    def _adopt(self, k: int, orbits: np.ndarray, f: np.ndarray, dt: float) -> None:
        """Take over the leading line of each signal f (orbits, samples) whose halves agree better than what is known.

        The halves are compared with one line first, which is enough to leave chaotic signals alone.
        """
        half = f.shape[1] // 2
        first, second = _leading(f[:, :half], dt, 1), _leading(f[:, half:], dt, 1)
        hopeful = np.abs(first - second) < 10 * self.error[k, orbits]
        f, orbits = f[hopeful], orbits[hopeful]
        if not orbits.size:
            return
        first, second, whole = (_leading(g, dt, 3) for g in (f[:, :half], f[:, half:], f))
        drift = np.nan_to_num(energy_error(self.flow.model, self.ensemble)[orbits], posinf=0.0)
        error = SAFETY * np.abs(first - second) + (1e-13 + 2 * drift) * np.abs(whole)
        # Another combination of the frequencies can have the largest line: agree with the average within its own error.
        known = self.error[k, orbits]
        better = (error < known) & ~(np.abs(whole - self.nu[k, orbits]) > known)
        chosen = orbits[better]
        self.nu[k, chosen], self.error[k, chosen] = whole[better], error[better]
        self.halves[0, k, chosen], self.halves[1, k, chosen] = first[better], second[better]
        self.method[k, chosen] = METHODS.index("naff")

    def result(self, tolerance: float) -> FrequencyMap:
        """Assemble the map, with phi = (eta + gamma)/2 and psi = (gamma - eta)/2 for a body."""
        ensemble = self.ensemble
        energy = energy_error(self.flow.model, ensemble)
        mark_drift(ensemble, energy, tolerance)
        ensemble.status[(ensemble.status == Status.OK) & ~self.reached] = Status.INTERRUPTED
        names, nu, error, halves, method = self.angles.names, self.nu, self.error, self.halves, self.method
        # A libration of a coupled body may have no angle of its own; those of the planes always exist.
        sound = np.array(self.angles.planes) if any(self.angles.planes) else np.ones(self.n, bool)
        diffusion = np.log10(np.abs(halves[0] - halves[1])[sound].max(axis=0) + 1e-18)
        diffusion = np.where(self.reached, diffusion, 0.0)
        eta = gamma = None
        if names[-2:] == ("eta", "gamma"):
            eta, gamma = nu[-2], nu[-1]
            names = (*names[:-2], "phi", "psi")
            both = error[-2] + error[-1]
            nu = np.array([*nu[:-2], (eta + gamma) / 2, (gamma - eta) / 2])
            error = np.array([*error[:-2], both / 2, both / 2])
            method = np.array([*method[:-2], *[np.maximum(method[-2], method[-1])] * 2])
        return FrequencyMap(
            names, nu, error, diffusion, method, energy, ensemble.status, eta, gamma, self.time, self.flow.scheme, self.flow.step
        )  # fmt: skip



