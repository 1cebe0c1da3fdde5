"""Indicators of chaos without tangent vectors: from averages, frequencies, samples and the way back of an orbit.

The rule by which each calls an orbit chaotic or regular is that of `indicators`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ..core.classification import Classification
from ..core.docstrings import inserts_parameters
from ..core.numbers import Callback, fits, whole
from ..core.status import Status
from ..engine.kernels import birkhoff
from ..engine.kernels.samples import ROWS
from ..engine.packing import launch, units
from ..frequencies.frequencies import FrequencyMap
from ..frequencies.frequency_map import FrequencyWork, checked_signals
from ..frequencies.map_frequencies import map_frequencies_of
from ..frequencies.turning import CHANGED
from ..runs import observers
from ..runs.flow import Flow, no_memory
from ..runs.requirements import check_momenta, current_system
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
    r"""Digits to which weighted Birkhoff averages over both halves of the run agree.

    Parameters
    ----------
    threshold : float, default 5
        Digits from which an orbit is regular. Below it an orbit is chaotic after :math:`10^4` natural periods.

    Notes
    -----
    - Method: averages of the squared kinetic energy, with the weight of `frequency_map`. The average of the kinetic
      energy itself converges on chaotic orbits too if V is homogeneous (virial theorem).
    - Values: up to 16 on regular orbits, about :math:`\log_{10}(T)/2` on chaotic ones. Slow beats between frequencies
      cost a regular orbit as many digits until some twenty of them have passed.
    - Adaptive methods are not supported; use a fixed step.

    References
    ----------
    Sander & Meiss 2020, Physica D 411, 132569.

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

    @inserts_parameters
    def watch(self, flow: Flow, time: float, rates: np.ndarray) -> Watch | None:
        """Return the observer of the averages over both halves.

        Parameters
        ----------
        {indicator_watch}

        Returns
        -------
        Watch or None
            Observer of the run with the deviation vectors; None if the indicator has none.
        """

        def read(memory: np.ndarray, reached: np.ndarray) -> tuple[np.ndarray, float]:
            rows = birkhoff.ROWS
            with np.errstate(all="ignore"):
                a = memory[rows.early] / memory[rows.early_weight]
                b = memory[rows.late] / memory[rows.late_weight]
                digits = -np.log10(np.where(a == b, 0.0, np.abs(a - b) / np.maximum(np.abs(a), np.abs(b))) + 1e-17)
            return np.where(reached >= time * (1 - 1e-12), digits, np.nan), np.nan

        return Watch(observers.averages(flow.model, flow.vectors, time), 0, lambda memory: None, read)

    @inserts_parameters
    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit.

        Parameters
        ----------
        {indicator_reads}

        Returns
        -------
        float
            Typical value.
        """
        return 2.0 * threshold

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular: the averages agree.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        return value >= threshold


@dataclass(frozen=True)
@inserts_parameters
class FrequencyDiffusion(Indicator):
    r"""Change of the fundamental frequencies between both halves of the run, as log10.

    Parameters
    ----------
    threshold : float, optional
        Value above which an orbit is chaotic. Default: a change of 0.3 cycles over a half.
    {signals}

    Notes
    -----
    - Definition: :math:`\log_{10} \max_i |\nu_i^{(1)} - \nu_i^{(2)}|`, in cycles per natural period
      :math:`2\pi/\omega`. For IRREGULAR orbits the whole run is compared too, because its halves may agree by chance.
    - Values of regular orbits are far smaller once the halves resolve the frequencies. A value that lines too close to
      each other may cause is NaN.
    - Cost: a `frequency_map` in a run of its own.

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

    @inserts_parameters
    def check(self, where: str, model: Any) -> None:
        """Check that the model has the angles.

        Parameters
        ----------
        {indicator_check}

        Raises
        ------
        ValueError
            If the angles do not suit the number of coordinates.
        TypeError
            If `signals` has no angles.
        """
        check_momenta("model", model)
        if current_system(model).energetic:
            checked_signals(self.signals, model)

    @inserts_parameters
    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, callback: Callback | None) -> tuple:
        """Compute the values in a run of their own.

        Parameters
        ----------
        {indicator_compute}

        Returns
        -------
        tuple
            Values of shape (orbits,), NaN if they are unknown; NaN; and statuses of shape (orbits,).
        """
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

    @inserts_parameters
    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit.

        Parameters
        ----------
        {indicator_reads}

        Returns
        -------
        float
            Typical value.
        """
        return threshold - TOLD

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular: the change is below a third of a chaotic one.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        return value < threshold - 0.5

    @inserts_parameters
    def default(self, n: int, phase: Any) -> Any:
        """Return the default threshold.

        Parameters
        ----------
        {indicator_default}

        Returns
        -------
        float or ndarray, shape (orbits,)
            Threshold.
        """
        return np.log10(CHAOTIC_CHANGE * 2 * math.pi / phase)


def _largest_change(found: FrequencyMap) -> np.ndarray:
    """Return the largest difference (orbits,) between the frequencies of the whole run and of its halves."""
    first, second = cast(np.ndarray, found.nu_halves)
    pairs = (found.nu - first, found.nu - second, first - second)
    return np.max([np.abs(pair).max(axis=0) for pair in pairs], axis=0)


@dataclass(frozen=True)
class ZeroOneTest(Indicator):
    r"""The 0-1 test: a correlation K that is 0 for regular and 1 for chaotic orbits.

    Parameters
    ----------
    threshold : float, default 0.7
        Value above which an orbit is chaotic, after 300 natural periods; before that beats look like chaos.
    samples : int, optional
        Number of samples of the kinetic energy, 100 or more. Default: five in :math:`2\pi/\omega`, at least 400 and at
        most 4000. With an adaptive method they are taken at equal times in a run of their own.

    Notes
    -----
    - Definition: median over angles of the correlation of the mean square displacement with time, where translations
      are driven by the samples.
    - Regular: K is below 50/samples and below 1 - threshold, with half a radian of the natural motion or more between
      samples. All other orbits below the threshold are undecided, because weakly chaotic ones may have a small K.
    - Cost: samples squared operations an orbit.

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

    @inserts_parameters
    def check(self, where: str, model: Any) -> None:
        """Check the number of samples.

        Parameters
        ----------
        {indicator_check}

        Raises
        ------
        ValueError
            If it is less than 100.
        TypeError
            If it is no whole number.
        """
        if self.samples is not None:
            whole(f"{where}.samples", self.samples, 100)

    @inserts_parameters
    def watch(self, flow: Flow, time: float, rates: np.ndarray) -> Watch | None:
        """Return the observer that takes samples at steps of one size.

        Parameters
        ----------
        {indicator_watch}

        Returns
        -------
        Watch or None
            Observer of the run with the deviation vectors; None if the indicator has none.
        """
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

    @inserts_parameters
    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, callback: Callback | None) -> tuple:
        """Compute the values from equidistant states of an adaptive method.

        Parameters
        ----------
        {indicator_compute}

        Returns
        -------
        tuple
            Values of shape (orbits,), NaN if they are unknown; numbers for comparison; and statuses of shape (orbits,).
        """
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

    @inserts_parameters
    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit.

        Parameters
        ----------
        {indicator_reads}

        Returns
        -------
        float
            Typical value.
        """
        return 0.0

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular: K is as close to 0 as the samples allow.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        return np.abs(value) < np.minimum(1.0 - threshold, before)


@dataclass(frozen=True)
class ReversibilityError(Indicator):
    r"""Distance from the initial conditions after a run forwards and back, as log10.

    Parameters
    ----------
    threshold : float, optional
        Decades above which an orbit is chaotic. Default: :math:`-13 + 2\log_{10} x`, at most -2, where :math:`x =
        \max(\omega T, 10)`.

    Notes
    -----
    - Definition: log10 of the distance from z0, in amplitudes of the motion, after a run over T and back with reversed
      momenta.
    - Values: round-off grows like deviation vectors, as a power of the time on regular orbits and as :math:`e^{\lambda
      t}` on chaotic ones.
    - Cost: a run of its own, of twice the length, with a splitting method, which is reversible.
    - Maps are not supported; use `FLI`.

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

    @inserts_parameters
    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, callback: Callback | None) -> tuple:
        """Compute the values in a run of their own.

        Parameters
        ----------
        {indicator_compute}

        Returns
        -------
        tuple
            Values of shape (orbits,), NaN if they are unknown; NaN; and statuses of shape (orbits,).
        """

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

    @inserts_parameters
    def default(self, n: int, phase: Any) -> Any:
        """Return the default threshold.

        Parameters
        ----------
        {indicator_default}

        Returns
        -------
        float or ndarray, shape (orbits,)
            Threshold.
        """
        return np.minimum(-2.0, -13.0 + 2 * decades(phase))

    @inserts_parameters
    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit.

        Parameters
        ----------
        {indicator_reads}

        Returns
        -------
        float
            Typical value.
        """
        return threshold - 4.0

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular: the value is two decades below the threshold.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        return value < threshold - 2.0


def median_correlation(samples: np.ndarray, counts: np.ndarray, threads: int, callback: Callback | None) -> np.ndarray:
    """Return K (orbits,) of the 0-1 test on samples (orbits, columns), the first `counts` of each row."""
    orbits = len(samples)
    angles = math.pi * (0.2 + 0.6 * np.random.default_rng(1).random(ANGLES))
    cosine = np.cos(np.arange(counts.max() // 10)[:, None] * angles)
    result = np.full(orbits, np.nan)
    launch(correlations.zero_one, (samples, counts, cosine, result), units(orbits, 1), float(orbits), threads, callback)
    return result
