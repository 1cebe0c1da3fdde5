"""Indicators of chaos, as values: what each measures, and the rule by which it calls an orbit chaotic or regular.

Every indicator has a `limit`: chaotic orbits are above it, or below it where `above` is False. The default limits
follow from how an indicator of a regular orbit can grow or fall. With the phase x = omega T, omega the orbit's own
natural angular frequency, tangent vectors grow at most like x (shear between tori) and alignments fall at most as the
powers stated, while those of chaotic orbits are exponential. Four factors of ten (MARGIN) lie between. So chaos is seen
where lambda T is above about ln(10^4 x), and where the indicator still changes: a strong shear that tears vectors apart
at once leaves them beyond a limit on regular orbits too. What is not chaotic is regular only where that shows: where
the indicator changed since half the time as it does on tori (`calm`), over a hundred natural periods or more. All else
is undecided, and a longer time decides it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.names import named
from ...base.numbers import whole
from ...flows.flow import Flow, Report
from ...kernels import readings
from ...models.traits import traits_of
from ..frequencies.frequency_map import checked_angles
from .indicator import MANY, Indicator, VectorIndicator, is_indicator
from .own_passes import Watch, frequency_diffusion, kinetic_averages, kinetic_samples, reversibility_error, zero_one

MARGIN = 4.0

SLACK = 0.75
"""Decades since half the time by which a regular orbit may exceed the law of its indicator: vectors turn and alignments
swing.
"""

BEATS = 1e4
"""Natural periods before averages that don't converge say anything of chaos; correlations and changes of frequencies do
after MANY."""


def _decades(phase: Any) -> Any:
    return np.log10(np.maximum(phase, 10.0))


def moving_rows(body: Any) -> int:
    """Return how many tangent vectors can differ: rows of the state without the time and its momentum."""
    traits = traits_of(body)
    return traits.rows - 2 * traits.driven


class _Growth(VectorIndicator):
    """Decades by which vectors grow."""

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return MARGIN + _decades(phase)

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where they rose since half the time as a power below the square would, and a swing."""
        return value - before < math.log10(2.0) + SLACK


class _Volume(VectorIndicator):
    """Decades of the volume that unit vectors span."""

    above = False

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return -MARGIN - self._power(n) * _decades(phase)

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where they fell since half the time no faster than the power that their count allows, and a swing."""
        return before - value < self._power(n) * math.log10(2.0) + SLACK

    def _power(self, n: int) -> int:
        return self.count - 1 + 2 * max(0, self.count - n)


@dataclass(frozen=True)
class Lyapunov(_Growth):
    """Largest Lyapunov exponent ``log |w(T)| / T`` of a tangent vector w, per unit time.

    Parameters
    ----------
    limit : float, 1/time, optional
        Chaotic above it (default: ln(10^4 x)/T, with x = omega T).

    References
    ----------
    Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=fa.Lyapunov())["lyapunov"] > 1
    array([ True])
    """

    limit: float | None = None
    name = "lyapunov"
    rate = True
    reading = staticmethod(readings.first_length)


@dataclass(frozen=True)
class LyapunovSpectrum(_Growth):
    """All 2n Lyapunov exponents, per unit time, from the volumes that tangent vectors span (repeated QR); the largest
    decides.

    They are in `ChaosMap.spectrum` and `.spectrum_error`. n vectors suffice: they start as half of a symplectic basis,
    whose QR factors obey R_ii R_(2n+1-i) = 1, so the other exponents are the negatives. Where 2n vectors run anyway,
    for GALI(2n) or as `deviations`, all are computed.

    Parameters
    ----------
    limit : float, 1/time, optional
        Chaotic above it, as in `Lyapunov`.

    References
    ----------
    Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 21.

    Examples
    --------
    >>> chaos = fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=fa.LyapunovSpectrum())
    >>> chaos.spectrum.sum(axis=0).round(9) + 0.0
    array([0.])
    """

    limit: float | None = None
    name = "largest"
    rate = True
    reading = staticmethod(readings.first_stretch)
    spectrum = True

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return n


@dataclass(frozen=True)
class FLI(_Growth):
    """Fast Lyapunov indicator: the largest ``log10 |w(t)|`` up to T.

    Parameters
    ----------
    limit : float, decades, optional
        Chaotic above it (default: 4 + log10 x, with x = omega T).

    References
    ----------
    Froeschle, Lega & Gonczi 1997, Celest. Mech. Dyn. Astron. 67, 41.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=fa.FLI()).chaotic
    array([ True])
    """

    limit: float | None = None
    name = "fli"
    reading = staticmethod(readings.largest_length)


@dataclass(frozen=True)
class OFLI(_Growth):
    """Orthogonal fast Lyapunov indicator: the largest log10 of the part of w(t) across the flow; bounded on periodic
    orbits.

    Parameters
    ----------
    limit : float, decades, optional
        Chaotic above it (default: 4 + log10 x, with x = omega T).

    References
    ----------
    Fouchard, Lega, Froeschle & Froeschle 2002, Celest. Mech. Dyn. Astron. 83, 205.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=1000.0, indicators=fa.OFLI()).regular
    array([ True])
    """

    limit: float | None = None
    name = "ofli"
    reading = staticmethod(readings.largest_across)
    across_flow = True


@dataclass(frozen=True)
class MEGNO(VectorIndicator):
    """Mean exponential growth of nearby orbits <Y>: 2 on regular orbits (0 where all periods are equal), lambda T/2 on
    chaotic ones.

    Parameters
    ----------
    limit : float, default 5
        Chaotic above it.

    References
    ----------
    Cincotta & Simo 2000, Astron. Astrophys. Suppl. 147, 205.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(0.5), [2.0, 0.1], time=1000, indicators=fa.MEGNO())["megno"].round(1)
    array([2.])
    """

    limit: float = 5.0
    name = "megno"
    reading = staticmethod(readings.mean_megno)

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where it is close to 2, or falls: it doubles where growth is exponential."""
        return (value < 2.5) | (value < 0.95 * before)


@dataclass(frozen=True)
class SALI(_Volume):
    """Smaller alignment index, as log10: ``min |w1 +- w2|`` of two unit tangent vectors.

    It falls as exp(-(lambda_1 - lambda_2) t) on chaotic orbits. On regular ones it stays, or falls as 1/x where only
    one combination of the frequencies changes between tori.

    Parameters
    ----------
    limit : float, decades, optional
        Chaotic below it (default: -4 - log10 x, with x = omega T).

    References
    ----------
    Skokos 2001, J. Phys. A 34, 10029.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=fa.SALI()).chaotic
    array([ True])
    """

    limit: float | None = None
    name = "sali"
    count = 2
    reading = staticmethod(readings.alignment)


@dataclass(frozen=True)
class GALI(_Volume):
    """Generalised alignment index of `count` unit tangent vectors, as log10 of the volume that they span.

    It is the product of their singular values, taken from the accumulated QR factors: no floor at 1e-16. Chaotic
    orbits: exp(-sum_(i<=k) (lambda_1 - lambda_i) t). Regular ones on n-tori: constant for k <= n, t^(-2(k - n)) beyond.

    Parameters
    ----------
    count : int, 2 to 2n
        Number k of vectors.
    limit : float, decades, optional
        Chaotic below it (default: -4 - (k - 1 + 2 max(0, k - n)) log10 x, x = omega T, which covers degenerate
        frequencies too).

    References
    ----------
    Skokos, Bountis & Antonopoulos 2007, Physica D 231, 30; 2008, Eur. Phys. J. Special Topics 165, 5.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=1000.0, indicators=fa.GALI(4)).regular
    array([ True])
    """

    count: int
    limit: float | None = None
    reading = staticmethod(readings.volume)

    @property
    def name(self) -> str:  # type: ignore[override]
        """Return gali_2, gali_3, ..."""
        return f"gali_{self.count}"

    @property
    def parameters(self) -> tuple[float, ...]:  # type: ignore[override]
        """Return the arguments of the reading beside the growth."""
        return (float(self.count),)

    def check(self, where: str, body: Any) -> None:
        """Refuse a count that is not 2 to 2n."""
        rows = moving_rows(body)
        if not 2 <= whole(f"{where}.count", self.count, 2) <= rows:
            raise ValueError(f"GALI.count must be 2 ... {rows} for {type(body).__name__}, got {self.count}")


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
    angles: Any = None
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
        return np.minimum(-2.0, -13.0 + 2 * _decades(phase))

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where it is a hundred times below the limit."""
        return value < limit - 2.0


_KNOWN: tuple[Any, ...] = (
    MEGNO(),
    SALI(),
    *(GALI(k) for k in range(2, 9)),
    FLI(),
    OFLI(),
    Lyapunov(),
    BirkhoffDigits(),
    FrequencyDiffusion(),
    ZeroOne(),
    ReversibilityError(),
)
INDICATORS: dict[str, Any] = {**{entry.name: entry for entry in _KNOWN}, "spectrum": LyapunovSpectrum()}
"""Indicators with their default limits, by name."""


def indicator_names(text: str, option: str = "indicators") -> tuple[str, ...]:
    """Return the names in a text, with commas between them, as they are in INDICATORS."""
    return tuple(named(option, name.strip(), INDICATORS) for name in text.split(","))


def indicators_of(value: Any, _: Any = None) -> Any:
    """Return the tuple of indicators that one of them, a name, or names with commas stand for; anything else as it
    is.
    """
    if is_indicator(value):
        return (value,)
    if isinstance(value, str):
        return tuple(INDICATORS[name] for name in indicator_names(value))
    if isinstance(value, (tuple, list)):
        return tuple(entry for one in value for entry in (indicators_of(one) if isinstance(one, str) else (one,)))
    return value
