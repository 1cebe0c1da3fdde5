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
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar

import numpy as np

from ...base.numbers import shown
from ...kernels import readings

MARGIN = 4.0

SLACK = 0.75
"""Decades since half the time by which a regular orbit may exceed the law of its indicator: vectors turn and alignments
swing.
"""

MANY, BEATS = 100.0, 1e4
"""Natural periods before an orbit is called regular, and before correlations and changes of frequencies say anything of
chaos; before averages that don't converge do. After 16 periods half of what looked regular among the orbits of Henon
and Heiles at the energy 1/8 was chaotic in the end, after 130 one in fifteen."""


class Character(IntEnum):
    """What an indicator says of an orbit, or all together."""

    REGULAR = 0
    CHAOTIC = 1
    UNDECIDED = 2


def judged(
    indicator: Any, value: np.ndarray, before: np.ndarray, limit: np.ndarray, phase: np.ndarray, n: int
) -> np.ndarray:
    """Return the verdicts (orbits,) of `Character` on readings (orbits,) at the end and at half the time, for the
    phases omega T.
    """
    with np.errstate(invalid="ignore"):
        beyond = value > limit if indicator.above else value < limit
        calm = indicator.calm(value, before, limit, n)
        chaotic = beyond & ~calm & (phase >= 2 * np.pi * indicator.least)
        calm = calm & (phase >= 2 * np.pi * MANY)
    return np.where(
        chaotic,
        Character.CHAOTIC,
        np.where(calm & ~beyond & np.isfinite(value), Character.REGULAR, Character.UNDECIDED),
    )


def _decades(phase: Any) -> Any:
    return np.log10(np.maximum(phase, 10.0))


def _growth(n: int, phase: Any) -> Any:
    return MARGIN + _decades(phase)


def _grows_slowly(self: Any, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
    """Tell where decades of growth rose since half the time as a power below the square would, and a swing."""
    return value - before < math.log10(2.0) + SLACK


@dataclass(frozen=True)
class Lyapunov:
    """Largest Lyapunov exponent log |w(T)| / T of a tangent vector w, per unit time.

    Chaotic above `limit`, by default ln(10^4 x)/T.
    Source: Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9.
    """

    limit: float | None = None
    name: ClassVar[str] = "lyapunov"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = True
    reading: ClassVar[Callable] = staticmethod(readings.first_length)
    parameters: ClassVar[tuple[float, ...]] = ()
    across_flow: ClassVar[bool] = False
    least: ClassVar[float] = 0.0
    default: ClassVar[Callable[[int, Any], Any]] = staticmethod(_growth)
    calm = _grows_slowly

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return 1


@dataclass(frozen=True)
class LyapunovSpectrum:
    """All 2n Lyapunov exponents, per unit time, from the volumes that tangent vectors span (repeated QR); judged by the
    largest.

    They are in `ChaosMap.spectrum` and `.spectrum_error`. n vectors suffice: they start as half of a symplectic basis,
    of whose QR factors R_ii R_(2n+1-i) = 1, so the other exponents are the negatives. Where 2n vectors run anyway, for
    GALI(2n) or as `deviations`, all are computed. Chaotic above `limit`, as `Lyapunov`.
    Source: Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 21.
    """

    limit: float | None = None
    name: ClassVar[str] = "largest"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = True
    reading: ClassVar[Callable] = staticmethod(readings.first_stretch)
    parameters: ClassVar[tuple[float, ...]] = ()
    across_flow: ClassVar[bool] = False
    least: ClassVar[float] = 0.0
    default: ClassVar[Callable[[int, Any], Any]] = staticmethod(_growth)
    calm = _grows_slowly

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return n


@dataclass(frozen=True)
class FLI:
    """Fast Lyapunov indicator: the largest log10 |w(t)| up to T.

    Chaotic above `limit`, by default 4 + log10 x.
    Source: Froeschle, Lega & Gonczi 1997, Celest. Mech. Dyn. Astron. 67, 41.
    """

    limit: float | None = None
    name: ClassVar[str] = "fli"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = False
    reading: ClassVar[Callable] = staticmethod(readings.largest_length)
    parameters: ClassVar[tuple[float, ...]] = ()
    across_flow: ClassVar[bool] = False
    least: ClassVar[float] = 0.0
    default: ClassVar[Callable[[int, Any], Any]] = staticmethod(_growth)
    calm = _grows_slowly

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return 1


@dataclass(frozen=True)
class OFLI:
    """Orthogonal fast Lyapunov indicator: the largest log10 of the part of w(t) across the flow; bounded on periodic
    orbits.

    Chaotic above `limit`, by default 4 + log10 x.
    Source: Fouchard, Lega, Froeschle & Froeschle 2002, Celest. Mech. Dyn. Astron. 83, 205.
    """

    limit: float | None = None
    name: ClassVar[str] = "ofli"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = False
    reading: ClassVar[Callable] = staticmethod(readings.largest_across)
    parameters: ClassVar[tuple[float, ...]] = ()
    across_flow: ClassVar[bool] = True
    least: ClassVar[float] = 0.0
    default: ClassVar[Callable[[int, Any], Any]] = staticmethod(_growth)
    calm = _grows_slowly

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return 1


@dataclass(frozen=True)
class MEGNO:
    """Mean exponential growth of nearby orbits <Y>: 2 on regular orbits (0 where all periods are equal), lambda T/2 on
    chaotic ones.

    Chaotic above `limit`.
    Source: Cincotta & Simo 2000, Astron. Astrophys. Suppl. 147, 205.
    """

    limit: float = 5.0
    name: ClassVar[str] = "megno"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = False
    reading: ClassVar[Callable] = staticmethod(readings.mean_megno)
    parameters: ClassVar[tuple[float, ...]] = ()
    across_flow: ClassVar[bool] = False
    least: ClassVar[float] = 0.0

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return 1

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where it is close to 2, or falls: it doubles where growth is exponential."""
        return (value < 2.5) | (value < 0.95 * before)


def _power(count: int, n: int) -> int:
    return count - 1 + 2 * max(0, count - n)


def _volume(count: int, n: int, phase: Any) -> Any:
    return -MARGIN - _power(count, n) * _decades(phase)


def _falls_slowly(self: Any, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
    """Tell where decades of volume fell since half the time no faster than the power that its count allows, and a
    swing.
    """
    return before - value < _power(self.vectors(n), n) * math.log10(2.0) + SLACK


@dataclass(frozen=True)
class SALI:
    """Smaller alignment index, as log10: min |w1 +- w2| of two unit tangent vectors.

    Falls as exp(-(lambda_1 - lambda_2) t) on chaotic orbits; on regular ones it stays, or falls as 1/x where only one
    combination of the frequencies changes between tori. Chaotic below `limit`, by default -4 - log10 x.
    Source: Skokos 2001, J. Phys. A 34, 10029.
    """

    limit: float | None = None
    name: ClassVar[str] = "sali"
    above: ClassVar[bool] = False
    rate: ClassVar[bool] = False
    reading: ClassVar[Callable] = staticmethod(readings.alignment)
    parameters: ClassVar[tuple[float, ...]] = ()
    across_flow: ClassVar[bool] = False
    least: ClassVar[float] = 0.0
    calm = _falls_slowly

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return 2

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return _volume(2, n, phase)


@dataclass(frozen=True)
class GALI:
    """Generalised alignment index of `count` unit tangent vectors, as log10 of the volume that they span.

    It is the product of their singular values, taken from the accumulated QR factors: no floor at 1e-16. Chaotic
    orbits: exp(-sum_(i<=k) (lambda_1 - lambda_i) t). Regular ones on n-tori: constant for k <= n, t^(-2(k - n)) beyond.
    Chaotic below `limit`, by default -4 - (k - 1 + 2 max(0, k - n)) log10 x, which covers degenerate frequencies too.
    Source: Skokos, Bountis & Antonopoulos 2007, Physica D 231, 30; 2008, Eur. Phys. J. Special Topics 165, 5.
    """

    count: int
    limit: float | None = None
    above: ClassVar[bool] = False
    rate: ClassVar[bool] = False
    reading: ClassVar[Callable] = staticmethod(readings.volume)
    across_flow: ClassVar[bool] = False
    least: ClassVar[float] = 0.0
    calm = _falls_slowly

    @property
    def name(self) -> str:
        """Return gali_2, gali_3, ..."""
        return f"gali_{self.count}"

    @property
    def parameters(self) -> tuple[float, ...]:
        """Return what the reading takes beside the growth."""
        return (float(self.count),)

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return self.count

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return _volume(self.count, n, phase)


@dataclass(frozen=True)
class BirkhoffDigits:
    """Digits to which weighted Birkhoff averages of the squared kinetic energy over both halves of the run agree.

    Regular from `limit` on: about log10(T)/2 are all that chaotic orbits get. (The average of the kinetic energy itself
    converges on chaotic orbits too where V is homogeneous: the virial theorem.) Fewer digits are no evidence of chaos:
    slow beats between frequencies cost a regular orbit as many until some twenty of them have passed. Chaotic below
    `limit` after 10^4 natural periods. Takes fixed steps.
    Source: Sander & Meiss 2020, Physica D 411, 132569; the weight is that of `frequency_map`.
    """

    limit: float = 5.0
    name: ClassVar[str] = "birkhoff_digits"
    above: ClassVar[bool] = False
    rate: ClassVar[bool] = False
    least: ClassVar[float] = BEATS

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where the averages agree."""
        return value >= limit


@dataclass(frozen=True)
class FrequencyDiffusion:
    """log10 of the difference of the fundamental frequencies of both halves of the run, in cycles per natural period 2
    pi/omega.

    `angles` as in `frequency_map`, which it calls: a pass of its own. Chaotic above `limit`, by default where they
    differ by 0.3 cycles over a half: those of regular orbits agree much better once the halves resolve them.
    Source: Laskar 1993, Physica D 67, 257.
    """

    limit: float | None = None
    angles: Any = None
    name: ClassVar[str] = "frequency_diffusion"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = False
    least: ClassVar[float] = MANY

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where the frequencies agree to a third of what is chaos."""
        return value < limit - 0.5

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return np.log10(0.6 * 2 * math.pi / phase)


@dataclass(frozen=True)
class ZeroOne:
    """The 0-1 test: median correlation K of the mean square displacement of translations driven by samples, 0 regular,
    1 chaotic.

    `samples` of the kinetic energy at some of the steps (None: five in 2 pi/omega, at least 400, at most 4000), of an
    adaptive scheme at equal times in a pass of its own. Cost: samples^2 operations an orbit. Chaotic above `limit`
    after 300 natural periods (beats look alike before). K of regular orbits falls like 1/samples, that of weakly
    chaotic ones may be as small before their displacements have grown: regular below 50/samples, and below 1 - limit,
    with half a radian of 2 pi/omega or more between samples, else undecided.
    Source: Gottwald & Melbourne 2009, SIAM J. Appl. Dyn. Syst. 8, 129.
    """

    limit: float = 0.7
    samples: int | None = None
    name: ClassVar[str] = "zero_one"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = False
    least: ClassVar[float] = 3 * MANY

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where K is as close to 0 as the limit is to 1, or closer, and as that many samples allow (`before`)."""
        return np.abs(value) < np.minimum(1.0 - limit, before)


@dataclass(frozen=True)
class ReversibilityError:
    """log10 of the distance of z from z0, in amplitudes of the motion, after going to T, turning the momenta round and
    coming back.

    Rounding errors grow like tangent vectors: as a power of time on regular orbits, as exp(lambda t) on chaotic ones. A
    pass of its own, of twice the length, with a splitting (which is reversible). Chaotic above `limit`, by default -13
    + 2 log10 x, at most -2.
    Source: Faranda, Mestre & Turchetti 2012, Int. J. Bifurcation Chaos 22, 1250215.
    """

    limit: float | None = None
    name: ClassVar[str] = "reversibility_error"
    above: ClassVar[bool] = True
    rate: ClassVar[bool] = False
    least: ClassVar[float] = 0.0

    def default(self, n: int, phase: Any) -> Any:
        """Return the limit that follows from the phase x."""
        return np.minimum(-2.0, -13.0 + 2 * _decades(phase))

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell where it is a hundred times below the limit."""
        return value < limit - 2.0


@dataclass(frozen=True)
class TangentIndicator:
    """An indicator of your own: a reading of the growth of tangent vectors, beside the others in the same pass.

    name: that of its row in `ChaosMap`; reading(growth, i, *parameters): a Python function that Numba compiles (or one
    that it has compiled) and that returns the number for lane i of `fastaff.kernels.readings.Growth`; limit: chaotic
    orbits are above it, or below it where `above` is False; count: how many tangent vectors it needs, 1 to 2n;
    parameters: floats that the reading gets, another value compiles nothing; across_flow: whether it needs the part of
    the first vector across the flow; judge(value, before, limit, n): which orbits (orbits,) look regular, from the
    readings at the end and at half the time, called with arrays, as an array of True and False (default: those whose
    reading changed by less than log10(2) + 0.75 towards chaos, as decades of a vector on a torus do). An orbit whose
    reading is NaN is undecided. Raises nothing itself: `chaos_map` checks it.
    Source: the tangent vectors are those of Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9.
    """

    name: str
    reading: Callable[..., float]
    limit: float
    above: bool = True
    count: int = 1
    parameters: tuple[float, ...] = ()
    across_flow: bool = False
    judge: Callable[..., np.ndarray] | None = None
    rate: ClassVar[bool] = False
    least: ClassVar[float] = 0.0

    def vectors(self, n: int) -> int:
        """Return how many tangent vectors it needs."""
        return self.count

    def calm(self, value: np.ndarray, before: np.ndarray, limit: np.ndarray, n: int) -> np.ndarray:
        """Tell which orbits look regular."""
        if self.judge is not None:
            said = self.judge(value, before, limit, n)
            if not isinstance(said, np.ndarray) or said.dtype != bool or said.shape != value.shape:
                raise TypeError(
                    f"judge of the indicator {self.name} must return an array of {value.size} True or False, got "
                    f"{shown(said)}"
                )
            return said
        return (value - before if self.above else before - value) < math.log10(2.0) + SLACK


Streamed = Lyapunov | LyapunovSpectrum | FLI | OFLI | MEGNO | SALI | GALI | TangentIndicator
"""Indicators that are readings of tangent vectors."""

Indicator = Streamed | BirkhoffDigits | FrequencyDiffusion | ZeroOne | ReversibilityError


def limit_of(indicator: Any, n: int, phase: np.ndarray, time: float) -> np.ndarray:
    """Return the limits (orbits,) of what is read of an indicator, for n degrees of freedom at the phases omega T
    (orbits,).

    Those of an exponent are decades of growth.
    """
    if indicator.limit is None:
        return indicator.default(n, phase)
    limit = float(indicator.limit)
    return np.full(phase.shape, limit * time / math.log(10) if indicator.rate else limit)
