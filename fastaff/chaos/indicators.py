"""Indicators of chaos, as values: the quantity that each measures, and its rule for chaotic and regular orbits.

Every indicator has a `threshold`: chaotic orbits are above it, or below it where `above` is False. The default
thresholds follow from how an indicator of a regular orbit can grow or fall. With the phase x = omega T, omega the
orbit's own natural angular frequency, tangent vectors grow at most like x (shear between tori) and alignments fall at
most as the powers stated, while those of chaotic orbits are exponential. Four factors of ten (MARGIN) lie between. So
chaos is seen where lambda T is above about ln(10^4 x), and where the indicator still changes: a strong shear that tears
vectors apart at once leaves them beyond a threshold on regular orbits too. An orbit that is not chaotic is regular only
if the indicator changed since half the time as it does on tori (`calm`), over a hundred natural periods or more. Other
orbits are undecided, and a longer time decides them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.names import named
from ..core.numbers import whole
from ..engine.kernels import readings
from ..runs.requirements import current_system
from ..systems.models.mechanics import System
from .indicator import VectorIndicator, decades, is_indicator
from .pass_indicators import FrequencyDiffusion, ReversibilityError, WeightedBirkhoff, ZeroOneTest

MARGIN = 4.0
"""Decades between the largest growth of tangent vectors on a regular orbit and the threshold above which an orbit is
chaotic.
"""

SLACK = 0.75
"""Decades since half the time by which a regular orbit may exceed the law of its indicator: vectors turn and alignments
swing.
"""


def moving_rows(system: System) -> int:
    """Return the number of independent tangent vectors: rows of the state without the time and its momentum."""
    return system.rows - 2 * system.driven


class _Growth(VectorIndicator):
    """Decades by which vectors grow."""

    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit."""
        return 0.0 if self.rate else threshold - MARGIN

    def default(self, n: int, phase: Any) -> Any:
        """Return the threshold that follows from the phase x."""
        return MARGIN + decades(phase)

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell where they rose since half the time as a power below the square would, and a swing."""
        return value - before < math.log10(2.0) + SLACK


class _Volume(VectorIndicator):
    """Decades of the volume that unit vectors span."""

    above = False

    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit."""
        return 0.0

    def default(self, n: int, phase: Any) -> Any:
        """Return the threshold that follows from the phase x."""
        return -MARGIN - self._power(n) * decades(phase)

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell where they fell since half the time no faster than the power that their count allows, and a swing."""
        return before - value < self._power(n) * math.log10(2.0) + SLACK

    def _power(self, n: int) -> int:
        return self.count - 1 + 2 * max(0, self.count - n)


@dataclass(frozen=True)
class Lyapunov(_Growth):
    """Largest Lyapunov exponent ``log |w(T)| / T`` of a tangent vector w, per unit time.

    Parameters
    ----------
    threshold : float, 1/time, optional
        Chaotic above it (default: ln(10^4 x)/T, with x = omega T).

    References
    ----------
    Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=fa.Lyapunov())["lyapunov"] > 1
    array([ True])
    """

    threshold: float | None = None
    name = "lyapunov"
    label = r"Lyapunov exponent $\lambda_1$ (per unit time)"
    rate = True
    reading = staticmethod(readings.first_length)


@dataclass(frozen=True)
class LyapunovSpectrum(_Growth):
    """All 2n Lyapunov exponents, per unit time, from the volumes that tangent vectors span (repeated QR); the largest
    decides.

    They are in `ChaosMap.spectrum` and `.spectrum_error`. n vectors suffice: they start as half of a symplectic basis,
    whose QR factors obey R_ii R_(2n+1-i) = 1, so the other exponents are the negatives. Where 2n vectors run anyway,
    for GALI(2n) or as `deviation_vectors`, all are computed.

    Parameters
    ----------
    threshold : float, 1/time, optional
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

    threshold: float | None = None
    name = "largest"
    label = Lyapunov.label
    rate = True
    reading = staticmethod(readings.first_stretch)
    spectrum = True

    def vectors(self, n: int) -> int:
        """Return the number of tangent vectors it needs."""
        return n


@dataclass(frozen=True)
class FLI(_Growth):
    """Fast Lyapunov indicator: the largest ``log10 |w(t)|`` up to T.

    Parameters
    ----------
    threshold : float, decades, optional
        Chaotic above it (default: 4 + log10 x, with x = omega T).

    References
    ----------
    Froeschle, Lega & Gonczi 1997, Celest. Mech. Dyn. Astron. 67, 41.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=fa.FLI()).chaotic
    array([ True])
    """

    threshold: float | None = None
    name = "fli"
    label = r"FLI, largest $\log_{10}|w|$"
    reading = staticmethod(readings.largest_length)
    each_step = True


@dataclass(frozen=True)
class OFLI(_Growth):
    """Orthogonal fast Lyapunov indicator: the largest log10 of the part of w(t) across the flow; bounded on periodic
    orbits.

    Parameters
    ----------
    threshold : float, decades, optional
        Chaotic above it (default: 4 + log10 x, with x = omega T).

    References
    ----------
    Fouchard, Lega, Froeschle & Froeschle 2002, Celest. Mech. Dyn. Astron. 83, 205.

    Examples
    --------
    >>> fa.chaos_map(fa.HenonHeiles(), [0.0, 0.1, 0.2, 0.0], time=1000.0, indicators=fa.OFLI()).regular
    array([ True])
    """

    threshold: float | None = None
    name = "ofli"
    label = r"OFLI, largest $\log_{10}|w_\perp|$"
    reading = staticmethod(readings.largest_across)
    across_flow = True
    each_step = True


@dataclass(frozen=True)
class MEGNO(VectorIndicator):
    """Mean exponential growth of nearby orbits <Y>: 2 on regular orbits (0 where all periods are equal), lambda T/2 on
    chaotic ones.

    Parameters
    ----------
    threshold : float, default 5
        Chaotic above it.

    References
    ----------
    Cincotta & Simo 2000, Astron. Astrophys. Suppl. 147, 205.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(0.5), [2.0, 0.1], time=1000, indicators=fa.MEGNO())["megno"].round(1)
    array([2.])
    """

    threshold: float = 5.0
    name = "megno"
    label = r"MEGNO $\langle Y\rangle$"
    reading = staticmethod(readings.mean_megno)

    def reads(self, threshold: float) -> float:
        """Return the value of a regular orbit."""
        return 2.0

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell where it is close to 2, or falls: it doubles where growth is exponential."""
        return (value < 2.5) | (value < 0.95 * before)


@dataclass(frozen=True)
class SALI(_Volume):
    """Smaller alignment index, as log10: ``min |w1 +- w2|`` of two unit tangent vectors.

    It falls as exp(-(lambda_1 - lambda_2) t) on chaotic orbits. On regular ones it stays, or falls as 1/x where only
    one combination of the frequencies changes between tori.

    Parameters
    ----------
    threshold : float, decades, optional
        Chaotic below it (default: -4 - log10 x, with x = omega T).

    References
    ----------
    Skokos 2001, J. Phys. A 34, 10029.

    Examples
    --------
    >>> fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=fa.SALI()).chaotic
    array([ True])
    """

    threshold: float | None = None
    name = "sali"
    label = r"$\log_{10}$ SALI"
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
    threshold : float, decades, optional
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
    threshold: float | None = None
    reading = staticmethod(readings.volume)

    @property
    def name(self) -> str:  # type: ignore[override]
        """Return gali_2, gali_3, ..."""
        return f"gali_{self.count}"

    @property
    def label(self) -> str:
        """Return log10 GALI_2, GALI_3, ... in LaTeX."""
        return rf"$\log_{{10}}$ GALI$_{{{self.count}}}$"

    @property
    def parameters(self) -> tuple[float, ...]:  # type: ignore[override]
        """Return the arguments of the reading beside the growth."""
        return (float(self.count),)

    def check(self, where: str, model: Any) -> None:
        """Refuse a count that is not 2 to 2n."""
        rows = moving_rows(current_system(model))
        if not 2 <= whole(f"{where}.count", self.count, 2) <= rows:
            raise ValueError(f"GALI.count must be 2 ... {rows} for {type(model).__name__}, got {self.count}")


_KNOWN: tuple[Any, ...] = (
    MEGNO(),
    SALI(),
    *(GALI(k) for k in range(2, 9)),
    FLI(),
    OFLI(),
    Lyapunov(),
    WeightedBirkhoff(),
    FrequencyDiffusion(),
    ZeroOneTest(),
    ReversibilityError(),
)
INDICATORS: dict[str, Any] = {**{entry.name: entry for entry in _KNOWN}, "spectrum": LyapunovSpectrum()}
"""Indicators with their default thresholds, by name."""


def indicator_names(text: str, option: str = "indicators") -> tuple[str, ...]:
    """Return the names in a text, with commas between them, as they are in INDICATORS."""
    return tuple(named(option, name.strip(), INDICATORS) for name in text.split(","))


def indicators_of(value: Any, _: Any = None) -> Any:
    """Return the tuple of indicators for one of them, a name, or names with commas; return other values as they are."""
    if is_indicator(value):
        return (value,)
    if isinstance(value, str):
        return tuple(INDICATORS[name] for name in indicator_names(value))
    if isinstance(value, (tuple, list)):
        return tuple(entry for one in value for entry in (indicators_of(one) if isinstance(one, str) else (one,)))
    return value
