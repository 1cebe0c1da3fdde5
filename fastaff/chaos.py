"""Chaos maps: indicators of many orbits in one pass, and the verdict that they give together (layer L3)."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from . import observers
from .boundary import checked_model, checked_tangent_model
from .chaos_passes import frequency_diffusion, reversibility_error, zero_one
from .engine import Ensemble, Flow, Interrupted, Report, energy_error, make_flow, mark_drift, natural_rate, no_memory
from .frequency import checked_angles
from .indicators import (
    GALI,
    MEGNO,
    SALI,
    BirkhoffDigits,
    FrequencyDiffusion,
    Indicator,
    LyapunovSpectrum,
    ReversibilityError,
    TangentIndicator,
    ZeroOne,
    limit_of,
)
from .kernels.deviations import SHARED
from .scalars import positive, real, whole
from .schemes import KAHAN_LI8, RungeKutta, Splitting
from .status import Status, describe, raise_if_failed
from .tangent import checked_deviations

DEPENDENT = 1e-10
"""Distance of a unit vector from the plane of those before it, below which rounding errors would decide its direction."""


@dataclass(frozen=True)
class ChaosMap:
    """Indicators of orbits and what they say.

    names: one for each row of values (indicators, orbits), also as attributes (`result.megno`); limits (indicators,) and the
    verdicts they give, chaotic_by (indicators, orbits); detected (indicators, orbits): the time when a streamed indicator first passed
    its limit, NaN where it did not. chaotic (orbits,): more than half of the indicators say so; disagree (orbits,): not all say the
    same, as for sticky orbits, or runs too short. spectrum (2n, orbits), the largest first, and spectrum_error, its change since
    half the time, where asked for. history (indicators, records, orbits) at history_times (records, orbits), NaN past an orbit's
    end (and for indicators that are not streamed). Orbits that failed have no verdict: chaotic and disagree are False. t (orbits,)
    reached, energy_error, status, step as in `Orbits`.
    """

    names: tuple[str, ...]
    values: np.ndarray
    limits: np.ndarray
    chaotic_by: np.ndarray
    detected: np.ndarray
    chaotic: np.ndarray
    disagree: np.ndarray
    spectrum: np.ndarray | None
    spectrum_error: np.ndarray | None
    history: np.ndarray
    history_times: np.ndarray
    t: np.ndarray
    energy_error: np.ndarray
    status: np.ndarray
    time: float
    scheme: Splitting | RungeKutta
    step: float

    def __getattr__(self, name: str) -> np.ndarray:
        """Return the values of the indicator of that name."""
        names = self.__dict__.get("names", ())
        if name in names:
            return self.values[names.index(name)]
        raise AttributeError(f"ChaosMap has no {name!r}; its indicators are {', '.join(names)}")

    @property
    def fraction(self) -> float:
        """Share of chaotic orbits among those that did not fail; NaN where all failed."""
        fine = self.status == Status.OK
        return float(self.chaotic[fine].mean()) if fine.any() else math.nan

    def raise_if_failed(self) -> None:
        """Raise OrbitError unless every orbit is OK."""
        raise_if_failed(self.status)

    def summary(self) -> str:
        """Say in one line what became of the orbits."""
        fine = self.status == Status.OK
        counts = f"{(self.chaotic & fine).sum()} chaotic, {(~self.chaotic & fine).sum()} regular, {(self.disagree & fine).sum()} in doubt"
        return f"{counts}; {describe(self.status)}"


def chaos(
    body: Any, z0: Any, *, time: float, indicators: tuple[Indicator, ...] = (MEGNO(), SALI()), history: int = 0,
    early_stop: bool = False, deviations: Any = None, step: float | None = None, scheme: Splitting | RungeKutta = KAHAN_LI8,
    rtol: float = 1e-12, atol: float = 1e-12, energy_tolerance: float = 1e-6, threads: int | None = None,
    report: Report | None = None,
) -> ChaosMap:  # fmt: skip
    """Tell regular from chaotic orbits of `body` from `z0` over `time` by one or more indicators.

    Parameters: z0 (2n,) or (2n, orbits); time > 0, best 100 periods or more; indicators: values of `fastaff.indicators`, such as
    (MEGNO(), SALI(limit=-10), GALI(4), LyapunovSpectrum()); history: records of the streamed indicators, equidistant in time (of an
    adaptive scheme the first steps past such times); early_stop: end an orbit when all indicators have called it chaotic (they must
    be streamed); deviations: tangent vectors at the start, independent, as in `tangent_map` (their lengths don't matter; default:
    columns of a fixed random symplectic orthogonal matrix); the other options as in `integrate`.
    Returns ChaosMap. Raises ValueError or TypeError for wrong input; Interrupted on Ctrl-C, with `.partial`.

    All indicators of tangent vectors come from one set of vectors in one pass, which moves by the derivative of the scheme and
    is made orthonormal about once in a radian of the natural motion; weighted averages run in the same pass. FrequencyDiffusion,
    ZeroOne and ReversibilityError make passes of their own. Limits use the median natural frequency of the given orbits.
    Cost: an orbit with k vectors takes about 1 + k steps' time. Memory: about 2 k^2 + 2n (1 + k) numbers an orbit, and the history.
    Source: Skokos & Manos 2016, Lect. Notes Phys. 915, 129 (review); each indicator names its own.
    """
    time, tolerance = positive("time", time), positive("energy_tolerance", energy_tolerance)
    chosen = _checked(indicators, checked_model(body))
    slots = whole("history", history, 0)
    tangent = [entry for entry in chosen if isinstance(entry, TangentIndicator)]
    if early_stop and len(tangent) < len(chosen):
        raise ValueError("early_stop takes indicators of tangent vectors only: the others need the whole time")
    if tangent:
        checked_tangent_model(body)
    flow, z = make_flow(body, z0, scheme, step, rtol, atol, threads)
    _check_scheme(chosen, flow)
    work = _Work(flow, z, time, chosen, tangent, slots, bool(early_stop), deviations)
    passes: list[Callable[[Report | None], None]] = [work.stream] * work.streams
    for entry in chosen:
        for kind, own in _OWN_PASS.items():
            if isinstance(entry, kind):
                passes.append(functools.partial(work.adopt, entry, own))
    interrupted = False
    try:
        for number, run in enumerate(passes):
            run(None if report is None else functools.partial(_portion, report, number, len(passes)))
    except KeyboardInterrupt:
        interrupted = True
    result = work.result(tolerance, interrupted)
    if interrupted:
        stopped = Interrupted("chaos")
        stopped.partial = result
        raise stopped
    return result


_OWN_PASS: dict[type, Callable] = {
    FrequencyDiffusion: frequency_diffusion, ZeroOne: zero_one, ReversibilityError: reversibility_error,
}  # fmt: skip


def _portion(report: Report, number: int, passes: int, fraction: float) -> None:
    report((number + fraction) / passes)


def _checked(indicators: Any, body: Any) -> tuple[Indicator, ...]:
    """Return the indicators if they suit the body."""
    if not isinstance(indicators, (tuple, list)) or not indicators:
        raise TypeError(f"indicators must be a tuple of indicators such as (MEGNO(), SALI()), got {indicators!r}")
    n = body.degrees_of_freedom
    for entry in indicators:
        if not isinstance(entry, Indicator):
            hint = f": write {entry.__name__}()" if isinstance(entry, type) and issubclass(entry, Indicator) else ""
            raise TypeError(f"indicators must be values of fastaff.indicators, got {entry!r}{hint}")
        if entry.limit is not None or not hasattr(entry, "default"):
            real(f"{type(entry).__name__}.limit", entry.limit)
        if isinstance(entry, GALI) and not 2 <= whole("GALI.count", entry.count, 2) <= 2 * n:
            raise ValueError(f"GALI.count must be 2 ... {2 * n} for {type(body).__name__}, got {entry.count}")
        if isinstance(entry, FrequencyDiffusion):
            checked_angles(entry.angles, body)
        if isinstance(entry, ZeroOne) and entry.samples is not None:
            whole("ZeroOne.samples", entry.samples, 100)
    names = [entry.name for entry in indicators]
    if len(set(names)) < len(names):
        raise ValueError(f"indicators must differ, got {', '.join(names)}")
    return tuple(indicators)


def _check_scheme(chosen: tuple[Indicator, ...], flow: Flow) -> None:
    """Raise ValueError unless the flow's scheme, perhaps one chosen by trial, suits the indicators."""
    for entry in chosen:
        if isinstance(entry, BirkhoffDigits) and flow.adaptive:
            raise ValueError(f"BirkhoffDigits needs a scheme of fixed steps, got {flow.scheme.name}")
        if isinstance(entry, ReversibilityError) and not isinstance(flow.scheme, Splitting):
            raise ValueError(f"ReversibilityError needs a splitting, which is reversible, got {flow.scheme.name}")


def _unit_vectors(deviations: Any, z0: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return given tangent vectors with unit length, and the logarithms (count, orbits) of the volumes they add at the start."""
    given = checked_deviations(deviations, z0)
    with np.errstate(all="ignore"):
        given = given / np.abs(given).max(axis=1, keepdims=True)  # squares must neither overflow nor vanish
        given = given / np.linalg.norm(given, axis=1, keepdims=True)
    unit = np.nan_to_num(given).transpose(2, 1, 0)
    factors = np.abs(np.diagonal(np.linalg.qr(unit, mode="r"), axis1=1, axis2=2))
    if len(given) > len(z0) or not (factors > DEPENDENT).all():
        raise ValueError(f"deviations must be at most {len(z0)} linearly independent vectors, got {len(given)} that depend or vanish")
    return given, np.log(factors).T


def symplectic_frame(n: int, count: int) -> np.ndarray:
    """Return tangent vectors (count, 2n): columns of a fixed random symplectic orthogonal matrix, w_(2n+1-i) the conjugate of w_i."""
    random = np.random.default_rng(20)
    unitary, _ = np.linalg.qr(random.standard_normal((n, n)) + 1j * random.standard_normal((n, n)))
    first = np.concatenate([unitary.real, unitary.imag]).T
    conjugate = np.concatenate([-unitary.imag, unitary.real]).T
    return np.concatenate([first, conjugate[::-1]])[:count]


class _Work:
    """A chaos map in the making: what the streams and the other passes have found so far."""

    def __init__(
        self, flow: Flow, z0: np.ndarray, time: float, chosen: tuple[Indicator, ...], tangent: list[TangentIndicator], slots: int,
        early_stop: bool, deviations: Any,
    ):  # fmt: skip
        self.flow, self.z0, self.time, self.chosen, self.tangent = flow, z0, time, chosen, tangent
        self.slots, self.early_stop = slots, early_stop
        self.n, self.orbits = flow.model.degrees_of_freedom, z0.shape[1]
        self.rate = natural_rate(flow.model, z0)
        self.limits = np.array([limit_of(entry, self.n, self.rate * time) for entry in chosen])
        for j, entry in enumerate(chosen):  # limits of exponents as decades of growth, as they are read
            if getattr(entry, "rate", False) and entry.limit is not None:
                self.limits[j] = entry.limit * time / math.log(10)
        self.digits = any(isinstance(entry, BirkhoffDigits) for entry in chosen)
        self.streams = 1 if tangent or self.digits else 0
        start = None
        if tangent:
            needed = max(entry.vectors(self.n) for entry in tangent)
            if deviations is None:
                start, self.first = checked_deviations(symplectic_frame(self.n, needed), z0), np.zeros((needed, 1))
            else:
                start, self.first = _unit_vectors(deviations, z0)
            if len(start) < needed or (deviations is not None and self._spectrum and len(start) < 2 * self.n):
                least = 2 * self.n if self._spectrum else needed
                raise ValueError(f"deviations must be at least {least} vectors for these indicators, got {len(start)}")
            self.flow = replace(flow, vectors=len(start))
        self.k, self.m = self.flow.vectors, len(tangent)
        self.ensemble: Ensemble = self.flow.ensemble(z0.copy(), start)
        self.values = np.full((len(chosen), self.orbits), np.nan)
        self.memory, self.out = no_memory(self.ensemble)  # until the stream runs

    @property
    def _spectrum(self) -> bool:
        return any(isinstance(entry, LyapunovSpectrum) for entry in self.tangent)

    def _observer(self, stride: int) -> observers.Observer:
        """Return the observer of the stream, and make its memory and output."""
        streamed = [j for j, entry in enumerate(self.chosen) if isinstance(entry, TangentIndicator)]
        averages = observers.averages(self.flow.model, self.k, self.time) if self.digits else None
        width = (self.m + 1) * self.slots
        self.out = np.full((self.orbits, max(1, width)), np.nan)
        if not streamed:
            observer = averages
        else:
            observer = observers.deviations(
                self.flow.model, self.k, tuple(entry.reading for entry in self.tangent), tuple(self.limits[streamed]),
                tuple(1.0 if entry.above else -1.0 for entry in self.tangent), time=self.time, stride=stride,
                early_stop=self.early_stop, slots=self.slots,
            )  # fmt: skip
            if averages is not None:
                observer = observers.together(observer, averages, max(1, width))
        assert observer is not None
        self.memory = np.zeros((observer.rows, self.orbits))
        first = SHARED + 3 * self.k
        self.memory[first : first + self.k * self.k : self.k + 1] = 1.0
        return observer

    def stream(self, report: Report | None) -> None:
        """Run the tangent vectors and the averages."""
        often = max(1, math.ceil(self.time * self.rate))
        often = self.slots * math.ceil(often / self.slots) if self.slots else often
        stride, observations = 1, 0 if self.flow.adaptive else often
        if (self.early_stop or self.digits) and observations:
            stride = self.flow.steps(self.time / often)
            observations = often * stride
        observer = self._observer(stride)
        try:
            self.flow.advance(
                self.ensemble, observer, self.memory, self.out, time=self.time, observations=observations,
                refill=self.early_stop, report=report,
            )  # fmt: skip
        finally:
            self._read()

    def _read(self) -> None:
        """Take the values of the streamed indicators from the memory of the observer."""
        readings = iter(self.memory[SHARED + 3 * self.k + 2 * self.k * self.k :])
        with np.errstate(all="ignore"):
            for j, entry in enumerate(self.chosen):
                if isinstance(entry, TangentIndicator):
                    self.values[j] = next(readings)
                elif isinstance(entry, BirkhoffDigits):
                    _, first, a, second, b = self.memory[-8:-3] if self.tangent else self.memory[:5]
                    a, b = a / first, b / second
                    digits = -np.log10(np.where(a == b, 0.0, np.abs(a - b) / np.maximum(np.abs(a), np.abs(b))) + 1e-17)
                    self.values[j] = np.where(self.ensemble.time >= self.time * (1 - 1e-12), digits, np.nan)

    def adopt(self, entry: Indicator, own: Callable, report: Report | None) -> None:
        """Run the pass of an indicator of its own; an orbit that fails in it is marked."""
        value, status = own(entry, replace(self.flow, vectors=0), self.z0, self.time, self.rate, report)
        self.values[self.chosen.index(entry)] = value
        fine = self.ensemble.status == Status.OK
        self.ensemble.status[fine] = status[fine]

    def result(self, tolerance: float, unfinished: bool) -> ChaosMap:
        """Assemble the map, where `unfinished` of the passes that were done."""
        ensemble, names = self.ensemble, tuple(entry.name for entry in self.chosen)
        if unfinished:
            ensemble.status[(ensemble.status == Status.OK) & ~np.isfinite(self.values).all(axis=0)] = Status.INTERRUPTED
        reached = ensemble.time if self.streams else np.where(ensemble.status == Status.OK, self.time, 0.0)
        error = energy_error(self.flow.model, ensemble)
        mark_drift(ensemble, error, tolerance)
        known = np.isfinite(self.values)
        stopped = reached < self.time * (1 - 1e-12)
        detected = np.full(self.values.shape, np.nan)
        history = np.full((len(names), self.slots, self.orbits), np.nan)
        width = self.slots * (self.m + 1)
        flat = self.out[:, :width] if self.out.shape[1] >= width > 0 else np.full((self.orbits, width), np.nan)
        records = flat.reshape(self.orbits, self.slots, self.m + 1)
        above = np.array([entry.above for entry in self.chosen])[:, None]
        limits = self.limits[:, None]
        chaotic_by = known & np.where(above, self.values > limits, self.values < limits)
        row = SHARED + 3 * self.k + 2 * self.k * self.k + self.m
        with np.errstate(all="ignore"):
            for streamed, entry in enumerate(self.tangent):
                j = self.chosen.index(entry)
                times = self.memory[row + streamed] if self.memory.shape[0] > row + streamed else np.zeros(self.orbits)
                detected[j] = np.where(times > 0, times, np.nan)
                history[j] = records[:, :, 1 + streamed].T
                if entry.rate:
                    self.values[j] *= math.log(10) / reached
                    history[j] *= math.log(10) / records[:, :, 0].T
        scaled = [limit * math.log(10) / self.time if getattr(entry, "rate", False) else limit
                  for limit, entry in zip(self.limits, self.chosen)]  # fmt: skip
        votes, count = chaotic_by.sum(axis=0), known.sum(axis=0)
        by_detection = self.early_stop & np.isfinite(detected).all(axis=0)
        interrupted = stopped & (ensemble.status == Status.OK) & ~by_detection
        ensemble.status[interrupted] = Status.INTERRUPTED
        sound = np.isin(ensemble.status, (Status.OK, Status.INTERRUPTED))
        return ChaosMap(
            names, self.values, np.array(scaled), chaotic_by, detected, sound & ((2 * votes > count) | by_detection),
            sound & (votes > 0) & (votes < count) & ~by_detection, *self._exponents(), history, records[:, :, 0].T, reached, error,
            ensemble.status, self.time, self.flow.scheme, self.flow.step,
        )  # fmt: skip

    def _exponents(self) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Return the Lyapunov spectrum, the largest first, and its change since half the time."""
        if not self._spectrum:
            return None, None
        # Volumes count from the start, whatever the angles between given vectors.
        sums = self.memory[SHARED : SHARED + self.k] - self.first
        half = self.memory[SHARED + self.k : SHARED + 2 * self.k] - self.first
        if self.k < 2 * self.n:
            sums, half = (np.concatenate([s[: self.n], -s[: self.n][::-1]], axis=0) for s in (sums, half))
        with np.errstate(all="ignore"):
            now, before = sums / self.ensemble.time, half / (0.5 * self.time)
        order = np.argsort(-now, axis=0, kind="stable")
        error = np.where(self.ensemble.time > 0.5 * self.time, np.abs(now - before), np.inf)
        return np.take_along_axis(now, order, axis=0), np.take_along_axis(error, order, axis=0)
