"""Outcomes of an orbit, with the sentence for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    Status.NONFINITE: "a coordinate became infinite or NaN; use a smaller step or an adaptive method",
    Status.OUT_OF_DOMAIN: "left the domain of the potential; use a smaller step or an adaptive method",
    Status.ESCAPED: "escaped farther than a million times its own size; lower the energy to keep it",
    Status.ENERGY_DRIFT: "energy error above the tolerance; use a smaller step or an adaptive method",
    Status.TOO_FEW_CROSSINGS: "reached max_time before the requested number of crossings; increase max_time",
    Status.NOT_CONVERGED: "an iteration did not reach its tolerance; try a better guess or a larger tolerance",
    Status.STEP_TOO_SMALL: "the adaptive step became too small, at a singularity or in a divergence; shorten the run",
    Status.INTERRUPTED: "stopped before its end; run it again",
    Status.UNBOUND: "no torus, as a coordinate has no turning point on one side; choose a bound orbit",
    Status.ACTION_ZERO: "an action is 0 (circular orbit or equilibrium), so its angle in theta is NaN",
    Status.SEPARATRIX: "on a separatrix, where the frequency that is NaN has two limits; move the orbit to one side",
    Status.LOST: "left the domain of the map, such as its aperture, or stays at one point; reduce the amplitude",
}


def summary(status: np.ndarray) -> dict[Status, int]:
    """Count the orbits of each outcome, the frequent ones first."""
    codes, counts = np.unique(np.asarray(status), return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return {Status(int(codes[i])): int(counts[i]) for i in order}


def counted(number: int, what: str) -> str:
    """Return a number with the name of what is counted, in the plural where it is not 1."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def describe(status: np.ndarray, classes: Mapping[str, np.ndarray] | None = None, what: str = "orbit") -> str:
    """Return in one line the number of items, of those that are OK the counts of some classes, masks by name, and the
    count of each other outcome.
    """
    status = np.asarray(status)
    fine = status == Status.OK
    named = {"OK": fine} if classes is None else {name: mask & fine for name, mask in classes.items()}
    parts = [f"{n} {name}" for name, mask in named.items() if (n := int(np.count_nonzero(mask)))]
    failed = [f"{n} {outcome.name} ({outcome.sentence})" for outcome, n in summary(status).items() if outcome]
    said = "; ".join([", ".join(parts), *failed] if parts else failed)
    return f"{counted(status.size, what)}{f': {said}' if said else ''}"


def of_single(status: np.ndarray, symbol: str, names: Sequence[str], rows: np.ndarray) -> str:
    """Return the values (names, 1) of a single item that is OK, as the next part of its summary; "" for other items."""
    status = np.asarray(status)
    if status.size != 1 or status.item() != Status.OK:
        return ""
    known = [(name, value) for name, value in zip(names, np.ravel(rows), strict=True) if np.isfinite(value)]
    return "; " + ", ".join(f"{symbol}_{name} = {value:.6g}" for name, value in known) if known else ""


class OrbitError(RuntimeError):
    """Report that some orbit has another status than OK.

    The method raise_if_failed of a result raises it, with the count of each outcome.
    """


def raise_if_failed(status: np.ndarray) -> None:
    """Raise OrbitError, with the count of each outcome, unless every orbit is OK."""
    if np.any(np.asarray(status) != Status.OK):
        raise OrbitError(describe(status))
