"""Outcomes of an orbit, with the sentence for people."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

OK_CODE = 0
NONFINITE_CODE = 1
OUT_OF_DOMAIN_CODE = 2
ESCAPED_CODE = 3
ENERGY_DRIFT_CODE = 4
TOO_FEW_CROSSINGS_CODE = 5
NOT_CONVERGED_CODE = 6
INTERRUPTED_CODE = 7
STEP_TOO_SMALL_CODE = 8
UNBOUND_CODE = 9
ACTION_ZERO_CODE = 10
SEPARATRIX_CODE = 11
LOST_CODE = 12


class Status(IntEnum):
    """Enumerate the outcomes of an orbit.

    Attributes
    ----------
    OK : 0
        The orbit finished.
    NONFINITE : 1
        A coordinate became infinite or NaN.
    OUT_OF_DOMAIN : 2
        The orbit left the domain of the potential.
    ESCAPED : 3
        The orbit went beyond the escape radius, a million times its own size.
    ENERGY_DRIFT : 4
        The energy error exceeds the tolerance.
    TOO_FEW_CROSSINGS : 5
        The orbit reached ``max_time`` before the requested number of crossings.
    NOT_CONVERGED : 6
        An iteration did not reach its tolerance.
    INTERRUPTED : 7
        The orbit was stopped before its end.
    STEP_TOO_SMALL : 8
        The adaptive step fell below the resolution of time, or stays 10^4 times shorter than it was.
    UNBOUND : 9
        A coordinate has no turning point on one side, so there is no torus.
    ACTION_ZERO : 10
        An action is 0, so its angle has no value.
    SEPARATRIX : 11
        The orbit is on the border of two regions, so a frequency has two limits.
    LOST : 12
        The orbit left the domain of a map, or stays at one point to the last sample.

    Examples
    --------
    >>> fa.Status.ESCAPED.left, fa.Status.OK.sentence
    (True, 'finished')
    """

    OK = OK_CODE
    NONFINITE = NONFINITE_CODE
    OUT_OF_DOMAIN = OUT_OF_DOMAIN_CODE
    ESCAPED = ESCAPED_CODE
    ENERGY_DRIFT = ENERGY_DRIFT_CODE
    TOO_FEW_CROSSINGS = TOO_FEW_CROSSINGS_CODE
    NOT_CONVERGED = NOT_CONVERGED_CODE
    INTERRUPTED = INTERRUPTED_CODE
    STEP_TOO_SMALL = STEP_TOO_SMALL_CODE
    UNBOUND = UNBOUND_CODE
    ACTION_ZERO = ACTION_ZERO_CODE
    SEPARATRIX = SEPARATRIX_CODE
    LOST = LOST_CODE

    @property
    def sentence(self) -> str:
        """The outcome in words."""
        return _SENTENCES[self]

    @property
    def left(self) -> bool:
        """True for OUT_OF_DOMAIN, ESCAPED, LOST and NONFINITE: the orbit left the region of its motion."""
        return self in (Status.OUT_OF_DOMAIN, Status.ESCAPED, Status.LOST, Status.NONFINITE)


_SENTENCES = {
    Status.OK: "finished",
    Status.NONFINITE: "a coordinate became infinite or NaN",
    Status.OUT_OF_DOMAIN: "left the domain of the potential (det phi > 0 for most bodies), where a wall bounds it by "
    "too long a step: shorten it or use an adaptive scheme",
    Status.ESCAPED: "went beyond the escape radius, a million times the orbit's own size",
    Status.ENERGY_DRIFT: "energy error above the tolerance: shorten the step or use an adaptive scheme",
    Status.TOO_FEW_CROSSINGS: "reached max_time before the asked number of crossings",
    Status.NOT_CONVERGED: "an iteration did not reach its tolerance",
    Status.STEP_TOO_SMALL: "the adaptive step fell below the resolution of time, or stays 10^4 times shorter than it "
    "once was: the orbit runs away ever faster",
    Status.INTERRUPTED: "stopped before its end",
    Status.UNBOUND: "no torus: a coordinate has no turning point on one side "
    "(it escapes, or falls to alpha = beta = 0)",
    Status.ACTION_ZERO: "an action is 0 (circular orbit or equilibrium): its angle has no value, "
    "NaN in theta says which",
    Status.SEPARATRIX: "on the border of two regions (p_eta = 0 or p_gamma = 0 through the axis): the frequency that "
    "is NaN has two limits, one from each side",
    Status.LOST: "left the domain of a map, such as its aperture, or stays at one point to the last sample",
}


def summary(status: np.ndarray) -> dict[Status, int]:
    """Count the orbits of each outcome, the frequent ones first."""
    codes, counts = np.unique(np.asarray(status), return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return {Status(int(codes[i])): int(counts[i]) for i in order}


def describe(status: np.ndarray, of_which: str = "") -> str:
    """Return in one line the count of each outcome, with the text `of_which` for the orbits that are OK."""
    return "; ".join(
        f"{count} {outcome.name} ({outcome.sentence})" + (f", of which {of_which}" if outcome == 0 and of_which else "")
        for outcome, count in summary(status).items()
    )


class OrbitError(RuntimeError):
    """Report that some orbit has another status than OK.

    The method raise_if_failed of a result raises it, with the count of each outcome.
    """


def raise_if_failed(status: np.ndarray) -> None:
    """Raise OrbitError, with the count of each outcome, unless every orbit is OK."""
    if np.any(np.asarray(status) != Status.OK):
        raise OrbitError(describe(status))
