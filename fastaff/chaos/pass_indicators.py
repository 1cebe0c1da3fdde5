"""Indicators of chaos without tangent vectors: from averages, frequencies, samples and the way back of an orbit.

The rule by which each calls an orbit chaotic or regular is that of `indicators`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.classification import Classification
from ..core.numbers import fits, whole
from ..core.status import Status
from ..engine.kernels import birkhoff
from ..engine.kernels.samples import ROWS
from ..frequencies.frequencies import FrequencyMap
from ..frequencies.frequency_map import FrequencyWork, checked_signals
from ..frequencies.map_frequencies import map_frequencies_of
from ..frequencies.turning import CHANGED
from ..runs import observers
from ..runs.flow import Flow, no_memory
from ..runs.launch import Callback, launch, units
from ..runs.requirements import current_system
from ..runs.scales import motion
from ..systems.models.contracts import Angles
from .indicator import MANY, Indicator, Watch, decades
from .kernels import zero_one as correlations

BEATS = 1e4
"""Natural periods before averages that don't converge are evidence of chaos; for correlations and changes of
frequencies it is MANY."""

ANGLES = 100
"""Angles c of the 0-1 test, random in (pi/5, 4 pi/5): away from the resonances with the sampling."""

QUIET = 50.0
"""Correlation times samples below which an orbit may be regular. Most regular orbits have less; of the chaotic orbits
of Henon and Heiles at the energy 1/8, one in a hundred has.
"""

DENSE = 0.5
"""Least radians of the natural frequency between samples for QUIET: the angles of denser samples belong to frequencies
beyond those of the motion.
"""

TOLD = 8.0
"""Decades of diffusion below the threshold that figures show."""

LEAST_SAMPLES = 400
"""Least number of samples of the 0-1 test if none is asked for."""

MOST_SAMPLES = 4000
"""Largest number of samples of the 0-1 test if none is asked for."""


CHAOTIC_CHANGE = 0.6
"""Change of a frequency, in cycles over the run, from which `FrequencyDiffusion` calls an orbit chaotic. Regular orbits
that `test_separatrices.py` and `test_chaos.py` draw stay below.
"""


@dataclass(frozen=True)
class WeightedBirkhoff(Indicator):
    """Digits to which weighted Birkhoff averages of the squared kinetic energy over both halves of the run agree.

    Chaotic orbits reach about log10(T)/2. (The average of the kinetic energy itself converges on chaotic orbits too
    where V is homogeneous: the virial theorem.) Fewer digits are no evidence of chaos: slow beats between frequencies
    cost a regular orbit as many until some twenty of them have passed. It takes fixed steps.

    Parameters
    ----------
    threshold : float, digits, default 5
        Regular from it on; chaotic below it after 10^4 natural periods.

    References
    ----------
    Sander & Meiss 2020, Physica D 411, 132569; the weight is that of `frequency_map`.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=2000.0, indicators=fa.WeightedBirkhoff()).regular
    array([ True])
    """

    threshold: float = 5.0
    name = "weighted_birkhoff"
    label = "digits of Birkhoff averages"
    above = False
    least = BEATS
    needs = ("energy", "fixed steps")

    def watch(self, flow: Flow, time: float, rates: np.ndarray) -> Watch | None:
        """Return the averages over both halves."""

        def read(memory: np.ndarray, reached: np.ndarray) -> tuple[np.ndarray, float]:
            rows = birkhoff.ROWS
            with np.errstate(all="ignore"):
                a = memory[rows.early] / memory[rows.early_weight]
                b = memory[rows.late] / memory[rows.late_weight]
                digits = -np.log10(np.where(a == b, 0.0, np.abs(a - b) / np.maximum(np.abs(a), np.abs(b))) + 1e-17)
            return np.where(reached >= time * (1 - 1e-12), digits, np.nan), np.nan

        return Watch(observers.averages(flow.model, flow.vectors, time), 0, lambda memory: None, read)

    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit."""
        return 2.0 * threshold

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell where the averages agree."""
        return value >= threshold


@dataclass(frozen=True)
class FrequencyDiffusion(Indicator):
    """log10 of the difference of the fundamental frequencies of both halves of the run, in cycles per natural period 2
    pi/omega.

    Parameters
    ----------
    threshold : float, optional
        Chaotic above it (default: a difference of 0.3 cycles over a half; those of regular orbits agree much better
        once the halves resolve them).
    signals : as in `frequency_map`, which runs in a pass of its own

    References
    ----------
    Laskar 1993, Physica D 67, 257.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=2000.0, indicators=fa.FrequencyDiffusion()).regular
    array([ True])
    """

    threshold: float | None = None
    signals: Angles | None = None
    name = "frequency_diffusion"
    label = r"diffusion  $\log_{10}|\Delta\nu|$ (cycles per natural period)"
    least = MANY
    needs = ("energy",)

    def check(self, where: str, model: Any) -> None:
        """Refuse angles that the body does not have."""
        if current_system(model).energetic:
            checked_signals(self.signals, model)

    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, callback: Callback | None) -> tuple:
        """Return the values, NaN where they are no evidence: close lines change the halves of regular orbits, too."""
        if flow.system.iterated:
            found = map_frequencies_of(flow, z0, int(time))
            value = found.diffusion + np.log10(2 * math.pi)
            return np.where(found.status == Status.OK, value, np.nan), np.nan, found.status
        work = FrequencyWork(flow, checked_signals(self.signals, flow.model), z0, time, None, callback)
        work.run()
        found = work.result()
        irregular = found.classification == Classification.IRREGULAR
        # The halves of an irregular orbit may agree by chance: the whole run is a third witness.
        change = np.where(irregular, _largest_change(found), 10.0**found.diffusion)
        value = np.where(irregular, np.log10(np.maximum(change, 1e-300)), found.diffusion)
        value = value - np.log10(rates / (2 * math.pi))
        moving = np.any(found.nu_halves != 0, axis=(0, 1))
        unclear = (found.classification == Classification.UNDECIDED) & moving
        close_lines = ~irregular & (time / 2 * change > CHANGED)
        by_chance = irregular & (time * change < CHAOTIC_CHANGE)
        known = (found.status == Status.OK) & ~unclear & ~close_lines & ~by_chance
        return np.where(known, value, np.nan), np.nan, found.status

    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit."""
        return threshold - TOLD

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell where the frequencies agree to a third of the difference that counts as chaos."""
        return value < threshold - 0.5

    def default(self, n: int, phase: Any) -> Any:
        """Return the threshold that follows from the phase x."""
        return np.log10(CHAOTIC_CHANGE * 2 * math.pi / phase)


def _largest_change(found: FrequencyMap) -> np.ndarray:
    """Return the largest difference (orbits,) between the frequencies of the whole run and of its halves."""
    first, second = found.nu_halves
    pairs = (found.nu - first, found.nu - second, first - second)
    return np.max([np.abs(pair).max(axis=0) for pair in pairs], axis=0)


@dataclass(frozen=True)
class ZeroOneTest(Indicator):
    """The 0-1 test: median correlation K of the mean square displacement of translations driven by samples, 0 regular,
    1 chaotic.

    K of regular orbits falls like 1/samples, that of weakly chaotic ones may be as small before their displacements
    have grown. An orbit is regular below 50/samples and below 1 - threshold, with half a radian of 2 pi/omega or more
    between samples, else undecided. Cost: samples^2 operations an orbit.

    Parameters
    ----------
    threshold : float, default 0.7
        Chaotic above it after 300 natural periods (beats look alike before).
    samples : int >= 100, optional
        Samples of the kinetic energy at some of the steps (default: five in 2 pi/omega, at least 400, at most 4000), of
        an adaptive scheme at equal times in a pass of its own.

    References
    ----------
    Gottwald & Melbourne 2009, SIAM J. Appl. Dyn. Syst. 8, 129.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=3000.0, indicators=fa.ZeroOneTest()).regular
    array([ True])
    """

    threshold: float = 0.7
    samples: int | None = None
    name = "zero_one_test"
    label = "0-1 test $K$"
    least = 3 * MANY
    needs = ("energy",)

    def check(self, where: str, model: Any) -> None:
        """Refuse too few samples."""
        if self.samples is not None:
            whole(f"{where}.samples", self.samples, 100)

    def watch(self, flow: Flow, time: float, rates: np.ndarray) -> Watch | None:
        """Return the samples at steps of one length."""
        return None if flow.adaptive else self._sampled(flow, time, rates)

    @property
    def _equidistant(self) -> int:
        """Number of states of an adaptive scheme."""
        return max(MOST_SAMPLES, self.samples or 0)

    def _sampled(self, flow: Flow, time: float, rates: np.ndarray) -> Watch:
        """Return the kinetic energy at some of each orbit's steps, or at some of equidistant states where the scheme is
        adaptive; compared: the correlation below which an orbit may be regular.
        """
        most = np.clip(0.8 * time * rates, LEAST_SAMPLES, MOST_SAMPLES)
        wanted = most if self.samples is None else np.full(rates.size, self.samples)
        seen = self._equidistant if flow.adaptive else flow.steps(time)
        stride = np.maximum(1, seen // wanted)
        counts = np.minimum(wanted, seen // stride).astype(np.int64)
        fits("ZeroOneTest.samples", rates.size, int(counts.max()))
        sparse = flow.system.iterated | (time * rates * stride / seen > DENSE)
        quiet = np.where(sparse, QUIET / counts, 0.0)

        def prepare(memory: np.ndarray) -> None:
            memory[ROWS.stride] = memory[ROWS.left] = stride

        def finish(out: np.ndarray, callback: Callback | None) -> np.ndarray:
            return median_correlation(out, counts, flow.threads, callback)

        observer = observers.kinetic_samples(flow.model, flow.vectors)
        return Watch(observer, int(counts.max()), prepare, lambda memory, reached: (np.nan, quiet), finish)

    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, callback: Callback | None) -> tuple:
        """Return the values, the reference values, and the statuses, of an adaptive scheme's equidistant states."""
        watch = self._sampled(flow, time, rates)
        ensemble = flow.ensemble(z0.copy())
        memory = np.zeros((watch.observer.rows, rates.size))
        out = np.zeros((rates.size, watch.columns))
        watch.prepare(memory)
        flow.advance(
            ensemble, watch.observer, memory, out, time=time, observations=self._equidistant, callback=callback
        )
        found = watch.finish(out, callback)  # type: ignore[misc]
        _, quiet = watch.read(memory, ensemble.time)
        return np.where(ensemble.status == Status.OK, found, np.nan), quiet, ensemble.status

    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit."""
        return 0.0

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell where K is as close to 0 as the threshold is to 1, or closer, and as that many samples allow
        (`before`).
        """
        return np.abs(value) < np.minimum(1.0 - threshold, before)


@dataclass(frozen=True)
class ReversibilityError(Indicator):
    """log10 of the distance of z from z0, in amplitudes of the motion, after a run to T and back with reversed momenta.

    Rounding errors grow like tangent vectors: as a power of time on regular orbits, as exp(lambda t) on chaotic ones.
    The indicator needs a pass of its own, of twice the length, with a splitting (which is reversible).

    Parameters
    ----------
    threshold : float, decades, optional
        Chaotic above it (default: -13 + 2 log10 x, at most -2, with x = omega T).

    References
    ----------
    Faranda, Mestre & Turchetti 2012, Int. J. Bifurcation Chaos 22, 1250215.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=1000.0, indicators=fa.ReversibilityError()).regular
    array([ True])
    """

    threshold: float | None = None
    name = "reversibility_error"
    label = r"$\log_{10}$ reversibility error"
    needs = ("energy", "flow", "splitting")

    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, callback: Callback | None) -> tuple:
        """Return the values, NaN, and the statuses."""

        def run(z: np.ndarray, status: Any) -> Any:
            ensemble = flow.ensemble(z)
            ensemble.status[:] = status
            nothing = observers.nothing()
            flow.advance(ensemble, nothing, *no_memory(ensemble), time=time, observations=1, callback=callback)
            return ensemble

        momenta_turned = np.repeat([1.0, -1.0], flow.model.degrees_of_freedom)[:, None]
        there = run(z0.copy(), Status.OK)
        back = run(there.z * momenta_turned, there.status)
        with np.errstate(all="ignore"):
            away = motion(flow.system, z0, flow.threads).between(back.z * momenta_turned, z0, flow.threads)
            value = np.log10(np.maximum(away, 1e-17))
        return np.where(back.status == Status.OK, value, np.nan), np.nan, back.status

    def default(self, n: int, phase: Any) -> Any:
        """Return the threshold that follows from the phase x."""
        return np.minimum(-2.0, -13.0 + 2 * decades(phase))

    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit."""
        return threshold - 4.0

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell where it is a hundred times below the threshold."""
        return value < threshold - 2.0


def median_correlation(samples: np.ndarray, counts: np.ndarray, threads: int, callback: Callback | None) -> np.ndarray:
    """Return K (orbits,) of the 0-1 test on samples (orbits, columns), the first `counts` of each row."""
    orbits = len(samples)
    angles = math.pi * (0.2 + 0.6 * np.random.default_rng(1).random(ANGLES))
    cosine = np.cos(np.arange(counts.max() // 10)[:, None] * angles)
    result = np.full(orbits, np.nan)
    launch(correlations.zero_one, (samples, counts, cosine, result), units(orbits, 1), float(orbits), threads, callback)
    return result
