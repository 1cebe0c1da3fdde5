"""Automatic choice of a scheme: the candidates, and the decision between them by a short trial."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...core.numbers import positive, shown
from .catalogue import (
    BLANES_CASAS_ESCORIHUELA8,
    BLANES_MOAN6,
    DOP853,
    KAHAN_LI8,
    SOFRONIOU_SPALETTA10,
    VERNER9,
    RungeKutta,
    Splitting,
)
from .time_transformed import TimeTransformed

PREFERENCE = 1.5
"""Largest cost, over that of the cheapest scheme, of a scheme that conserves phase space volume: its error does not
grow with time.
"""

BETTER = {KAHAN_LI8: BLANES_CASAS_ESCORIHUELA8}
"""Schemes that are not tried beside a better one if T is quadratic: in the race of bench/test_schemes.py the latter is
ahead on all systems at all accuracies.
"""

TRIAL_ORBITS = 64
"""Number of orbits that decide between schemes."""


SHARE = 0.25
"""Share of the wanted energy error that a trial may use: it sees fewer orbits, for a shorter time, at fewer moments."""


@dataclass(frozen=True)
class CandidateTrial:
    """Result of a candidate in the trial: its step, the largest energy error expected at the end, forces per unit
    time.
    """

    scheme: Any
    step: float
    error: float
    cost: float


@dataclass(frozen=True)
class Automatic:
    """Choose a scheme by a trial on a sample of the orbits.

    Parameters
    ----------
    candidates : tuple of Scheme or TimeTransformed, optional
        Schemes to choose from. Default: six schemes of the package and `TimeTransformed`.
    energy_error : float, default 1e-9
        Largest energy error at the end of the run, relative to the largest kinetic energy.

    Raises
    ------
    TypeError
        If a candidate is not a scheme.
    ValueError
        If there is no candidate, or if `energy_error` is not positive.

    Notes
    -----
    * Choice: the cheapest candidate that meets `energy_error` on about 64 orbits. A symplectic scheme of up to 1.5
      times the least cost is preferred. If no candidate meets it, the most accurate is taken. If no candidate keeps
      the sample in the domain, an adaptive one is taken.
    * Steps: fixed steps are as long as the error allows. An adaptive scheme keeps the tolerances; its error is assumed
      to grow in proportion to time.
    * Cost is counted in force evaluations, never timed, so every machine chooses the same.
    * Orbits that leave the domain do not count.
    * `integrate` and `poincare_map` try all candidates, other functions only those that step in time.
    * The result has the scheme and step.

    Examples
    --------
    >>> either = fa.schemes.Automatic((fa.LEAPFROG, fa.BLANES_MOAN6))
    >>> fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=2.0, scheme=either).scheme.name
    'BLANES_MOAN6'
    """

    candidates: tuple[Any, ...] = (
        BLANES_CASAS_ESCORIHUELA8,
        BLANES_MOAN6,
        KAHAN_LI8,
        SOFRONIOU_SPALETTA10,
        TimeTransformed(),
        DOP853,
        VERNER9,
    )
    energy_error: float = 1e-9

    def __post_init__(self) -> None:
        object.__setattr__(self, "energy_error", positive("energy_error", self.energy_error))
        if not isinstance(self.candidates, tuple) or not self.candidates:
            raise ValueError(f"candidates must be a tuple of at least one scheme, got {shown(self.candidates)}")
        for candidate in self.candidates:
            if not isinstance(candidate, (Splitting, RungeKutta, TimeTransformed)):
                raise TypeError(
                    f"candidates must be schemes such as KAHAN_LI8, got {shown(candidate)} ({type(candidate).__name__})"
                )

    @property
    def name(self) -> str:
        """Name of the scheme."""
        return f"Automatic({', '.join(candidate.name for candidate in self.candidates)})"

    @property
    def bound(self) -> float:
        """The energy error that trials may make."""
        return SHARE * self.energy_error

    @property
    def in_time(self) -> Automatic:
        """The same choice among the candidates that step in time itself."""
        kept = tuple(c for c in self.candidates if not isinstance(c, TimeTransformed))
        if not kept:
            raise ValueError(
                f"scheme {self.name} has only time-transformed candidates: integrate and poincare_map take those"
            )
        return replace(self, candidates=kept)

    def suited(self, quadratic: bool) -> Automatic:
        """Return the same choice among the candidates that suit a kinetic energy.

        Parameters
        ----------
        quadratic : bool
            True if T is quadratic in the momenta.

        Returns
        -------
        `Automatic`
            Choice among the candidates whose order holds. If T is quadratic, candidates with a better alternative in
            the tuple are left out.

        Raises
        ------
        ValueError
            If no candidate is left.
        """
        kept = tuple(
            c
            for c in self.candidates
            if (BETTER.get(c) not in self.candidates if quadratic else not getattr(c, "nystrom", False))
        )
        if not kept:
            raise ValueError(f"scheme {self.name} takes T quadratic in the momenta, which it is not")
        return replace(self, candidates=kept)

    def choose(self, trials: Iterable[CandidateTrial]) -> CandidateTrial:
        """Return the best of several trials.

        Parameters
        ----------
        trials : iterable of CandidateTrial
            Trials of the candidates.

        Returns
        -------
        CandidateTrial
            Trial of the scheme to use.
        """
        tried = list(trials)
        good = [trial for trial in tried if trial.error <= self.bound]
        if not good:
            return min(tried, key=lambda trial: (trial.error, math.isfinite(trial.step)))
        bound = PREFERENCE * min(trial.cost for trial in good)
        return min(good, key=lambda trial: (not (trial.scheme.symplectic and trial.cost <= bound), trial.cost))


AUTO = Automatic()
"""The schemes of the package to choose from, for an energy error of 1e-9 at the end of the run."""


def trial_rounds(sample: np.ndarray, span: float, time: float | None) -> int:
    """Return the number of spans for a trial of fewer than TRIAL_ORBITS orbits, for as many bounces as these have: no
    longer than the run.
    """
    return max(1, math.ceil(min(TRIAL_ORBITS / sample.shape[1], 8.0 if time is None else time / span)))


def spread(z: np.ndarray, orbits: int) -> np.ndarray:
    """Return at least `orbits` of the phase points z, evenly chosen (all where there are fewer)."""
    return np.ascontiguousarray(z[:, :: max(1, z.shape[1] // orbits)])
