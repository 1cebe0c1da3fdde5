"""Indicators of chaos without tangent vectors: of averages, frequencies and samples of an orbit, and of its way back.

The rule by which each calls an orbit chaotic or regular is that of `indicators`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.numbers import whole
from ...flows.flow import Flow
from ...flows.launch import Report
from ...models.contracts import Angles
from ...models.traits import traits_of
from ..frequencies.frequency_map import checked_angles
from .indicator import MANY, Indicator, decades
from .own_passes import Watch, frequency_diffusion, kinetic_averages, kinetic_samples, reversibility_error, zero_one

BEATS = 1e4
"""Natural periods before averages that don't converge say anything of chaos; correlations and changes of frequencies do
after MANY."""


@dataclass(frozen=True)
class BirkhoffDigits(Indicator):
    """Digits to which weighted Birkhoff averages of the squared kinetic energy over both halves of the run agree.

    Chaotic orbits reach about log10(T)/2. (The average of the kinetic energy itself converges on chaotic orbits too
    where V is homogeneous: the virial theorem.) Fewer digits are no evidence of chaos: slow beats between frequencies
    cost a regular orbit as many until some twenty of them have passed. It takes fixed steps.

    Parameters
    ----------
    limit : float, digits, default 5
        Regular from it on; chaotic below it after 10^4 natural periods.

    References
    ----------
    Sander & Meiss 2020, Physica D 411, 132569; the weight is that of `frequency_map`.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=2000.0, indicators=fa.BirkhoffDigits()).regular
    array([ True])
    """

    limit: float = 5.0
    name = "birkhoff_digits"
    above = False
    least = BEATS
    needs = ("energy", "fixed steps")

    def watch(self, flow: Flow, time: float, rates: np.ndarray) -> Watch | None:
        """Return the averages over both halves."""
        return kinetic_averages(flow, time)

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where the averages agree."""
        return value >= limit


@dataclass(frozen=True)
class FrequencyDiffusion(Indicator):
    """log10 of the difference of the fundamental frequencies of both halves of the run, in cycles per natural period 2
    pi/omega.

    Parameters
    ----------
    limit : float, optional
        Chaotic above it (default: a difference of 0.3 cycles over a half; those of regular orbits agree much better
        once the halves resolve them).
    angles : as in `frequency_map`, which runs in a pass of its own

    References
    ----------
    Laskar 1993, Physica D 67, 257.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=2000.0, indicators=fa.FrequencyDiffusion()).regular
    array([ True])
    """

    limit: float | None = None
    angles: Angles | None = None
    name = "frequency_diffusion"
    least = MANY
    needs = ("energy",)

    def check(self, where: str, body: Any) -> None:
        """Refuse angles that the body has not."""
        if traits_of(body).energetic:
            checked_angles(self.angles, body)

    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None) -> tuple:
        """Return the values, the reference values, and the statuses."""
        return frequency_diffusion(self.angles, flow, z0, time, rates, report)

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where the frequencies agree to a third of the difference that counts as chaos."""
        return value < limit - 0.5

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return np.log10(0.6 * 2 * math.pi / phase)


@dataclass(frozen=True)
class ZeroOne(Indicator):
    """The 0-1 test: median correlation K of the mean square displacement of translations driven by samples, 0 regular,
    1 chaotic.

    K of regular orbits falls like 1/samples, that of weakly chaotic ones may be as small before their displacements
    have grown. An orbit is regular below 50/samples and below 1 - limit, with half a radian of 2 pi/omega or more
    between samples, else undecided. Cost: samples^2 operations an orbit.

    Parameters
    ----------
    limit : float, default 0.7
        Chaotic above it after 300 natural periods (beats look alike before).
    samples : int >= 100, optional
        Samples of the kinetic energy at some of the steps (default: five in 2 pi/omega, at least 400, at most 4000), of
        an adaptive scheme at equal times in a pass of its own.

    References
    ----------
    Gottwald & Melbourne 2009, SIAM J. Appl. Dyn. Syst. 8, 129.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=3000.0, indicators=fa.ZeroOne()).regular
    array([ True])
    """

    limit: float = 0.7
    samples: int | None = None
    name = "zero_one"
    least = 3 * MANY
    needs = ("energy",)

    def check(self, where: str, body: Any) -> None:
        """Refuse too few samples."""
        if self.samples is not None:
            whole(f"{where}.samples", self.samples, 100)

    def watch(self, flow: Flow, time: float, rates: np.ndarray) -> Watch | None:
        """Return the samples at steps of one length."""
        return None if flow.adaptive else kinetic_samples(self.samples, flow, time, rates)

    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None) -> tuple:
        """Return the values, the reference values, and the statuses."""
        return zero_one(self.samples, flow, z0, time, rates, report)

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where K is as close to 0 as the limit is to 1, or closer, and as that many samples allow (`before`)."""
        return np.abs(value) < np.minimum(1.0 - limit, before)


@dataclass(frozen=True)
class ReversibilityError(Indicator):
    """log10 of the distance of z from z0, in amplitudes of the motion, after a run to T and back with reversed momenta.

    Rounding errors grow like tangent vectors: as a power of time on regular orbits, as exp(lambda t) on chaotic ones.
    The indicator needs a pass of its own, of twice the length, with a splitting (which is reversible).

    Parameters
    ----------
    limit : float, decades, optional
        Chaotic above it (default: -13 + 2 log10 x, at most -2, with x = omega T).

    References
    ----------
    Faranda, Mestre & Turchetti 2012, Int. J. Bifurcation Chaos 22, 1250215.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=1000.0, indicators=fa.ReversibilityError()).regular
    array([ True])
    """

    limit: float | None = None
    name = "reversibility_error"
    needs = ("energy", "flow", "splitting")

    def compute(self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None) -> tuple:
        """Return the values, the reference values, and the statuses."""
        return reversibility_error(flow, z0, time, report)

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return np.minimum(-2.0, -13.0 + 2 * decades(phase))

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where it is a hundred times below the limit."""
        return value < limit - 2.0
