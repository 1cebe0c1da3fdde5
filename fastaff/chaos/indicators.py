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

from ..core.docstrings import inserts_parameters
from ..core.names import named
from ..core.numbers import kind_of, whole
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
        return 0.0 if self.rate else threshold - MARGIN

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
        return MARGIN + decades(phase)

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular: values grew since half the time no faster than t squared.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        return value - before < math.log10(2.0) + SLACK


class _Volume(VectorIndicator):
    """Decades of the volume that unit vectors span."""

    above = False

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
        return -MARGIN - self._power(n) * decades(phase)

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular: values fell since half the time no faster than on a torus.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        return before - value < self._power(n) * math.log10(2.0) + SLACK

    def _power(self, n: int) -> int:
        return self.count - 1 + 2 * max(0, self.count - n)


@dataclass(frozen=True)
class Lyapunov(_Growth):
    r"""Largest Lyapunov exponent, per unit time.

    Parameters
    ----------
    threshold : float, optional
        Exponent above which an orbit is chaotic. Default: :math:`\ln(10^4 x)/T`, where :math:`x = \max(\omega T, 10)`.

    Notes
    -----
    - Definition: :math:`\ln |w(T)| / T` of a deviation vector w with :math:`|w(0)| = 1`.
    - :math:`\omega` is the natural angular frequency of an orbit and T its time, or iterates of a map.

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
    r"""All 2n Lyapunov exponents, per unit time; the largest one classifies an orbit.

    Parameters
    ----------
    threshold : float, optional
        Exponent above which an orbit is chaotic. Default: :math:`\ln(10^4 x)/T`, where :math:`x = \max(\omega T, 10)`.

    Notes
    -----
    - Method: volumes of deviation vectors by repeated QR factorisation. The results are ``spectrum`` and
      ``spectrum_error`` of a `ChaosMap`.
    - Cost: n vectors. They start as half of a symplectic basis, so the other exponents are the negatives. If 2n vectors
      are used anyway, for ``GALI(2n)`` or as `deviation_vectors`, all are computed. A map that is not symplectic needs
      2n.

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
        """Return the number of deviation vectors.

        Parameters
        ----------
        n : int
            Number of degrees of freedom.

        Returns
        -------
        int
            Number of vectors.
        """
        return n


@dataclass(frozen=True)
class FLI(_Growth):
    r"""Fast Lyapunov indicator: the largest log10 of the length of a deviation vector.

    Parameters
    ----------
    threshold : float, optional
        Decades above which an orbit is chaotic. Default: :math:`4 + \log_{10} x`, where :math:`x = \max(\omega T, 10)`.

    Notes
    -----
    - Definition: :math:`\max_{t \le T} \log_{10} |w(t)|`, over all steps.

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
    r"""Orthogonal fast Lyapunov indicator, which is bounded on periodic orbits.

    Parameters
    ----------
    threshold : float, optional
        Decades above which an orbit is chaotic. Default: :math:`4 + \log_{10} x`, where :math:`x = \max(\omega T, 10)`.

    Notes
    -----
    - Definition: :math:`\max_{t \le T} \log_{10} |w_\perp(t)|`, over all steps, where :math:`w_\perp` is the part of a
      deviation vector across the flow.
    - Maps are not supported; use `FLI`.

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
    r"""Mean exponential growth factor of nearby orbits.

    Parameters
    ----------
    threshold : float, default 5
        Value above which an orbit is chaotic.

    Notes
    -----
    - Definition: :math:`\langle Y \rangle`, the time average of :math:`Y(t) = \frac{2}{t} \int_0^t s\,d\ln|w(s)|` of a
      deviation vector w.
    - Values: 2 on regular orbits, 0 if all periods are equal, :math:`\lambda T/2` on chaotic orbits with the Lyapunov
      exponent :math:`\lambda`.

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
        return 2.0

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular: the value is close to 2, or falls.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        return (value < 2.5) | (value < 0.95 * before)


@dataclass(frozen=True)
class SALI(_Volume):
    r"""Smaller alignment index of two deviation vectors, as log10.

    Parameters
    ----------
    threshold : float, optional
        Decades below which an orbit is chaotic. Default: :math:`-4 - \log_{10} x`, where :math:`x = \max(\omega T,
        10)`.

    Notes
    -----
    - Definition: :math:`\log_{10} \min(|w_1 + w_2|, |w_1 - w_2|)` of two unit vectors.
    - Chaotic orbits: SALI falls as :math:`e^{-(\lambda_1 - \lambda_2) t}`.
    - Regular orbits: SALI is bounded, or falls as 1/x if only one combination of the frequencies changes between tori.

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
    r"""Generalised alignment index of k deviation vectors, as log10.

    Parameters
    ----------
    count : int
        Number k of vectors, from 2 to 2n.
    threshold : float, optional
        Decades below which an orbit is chaotic. Default: :math:`-4 - (k - 1 + 2\max(0, k - n)) \log_{10} x`, where
        :math:`x = \max(\omega T, 10)`. It covers degenerate frequencies too.

    Notes
    -----
    - Definition: log10 of the volume of k unit vectors, the product of their singular values. It comes from accumulated
      QR factors and has no floor at 1e-16.
    - Chaotic orbits: the volume falls as :math:`e^{-\sum_{i \le k} (\lambda_1 - \lambda_i) t}`.
    - Regular orbits on tori of n dimensions: it is bounded for :math:`k \le n` and falls as :math:`t^{-2(k - n)}`
      beyond.

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
        """Name of the indicator: gali_2, gali_3, ..."""
        return f"gali_{self.count}"

    @property
    def label(self) -> str:
        """Label for figures in LaTeX, log10 GALI_2, GALI_3, ..."""
        return rf"$\log_{{10}}$ GALI$_{{{self.count}}}$"

    @property
    def parameters(self) -> tuple[float, ...]:  # type: ignore[override]
        """Arguments of the reading after the growth."""
        return (float(self.count),)

    @inserts_parameters
    def check(self, where: str, model: Any) -> None:
        """Check that the number of vectors is from 2 to 2n.

        Parameters
        ----------
        {indicator_check}

        Raises
        ------
        ValueError
            If it is not.
        TypeError
            If it is no whole number.
        """
        rows = moving_rows(current_system(model))
        if not 2 <= whole(f"{where}.count", self.count, 2) <= rows:
            raise ValueError(f"GALI.count must be from 2 to {rows} for {kind_of(model)}, got {self.count}")


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
