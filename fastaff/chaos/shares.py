"""Shares of chaotic orbits among those that are decided, with intervals from numbers and undecided orbits."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import positive


class Shares(NamedTuple):
    """Numbers of orbits by classification, of one set or an array of sets, and the chaotic fraction that they give."""

    chaotic: np.ndarray
    regular: np.ndarray
    undecided: np.ndarray

    @property
    def completed(self) -> np.ndarray:
        """Orbits that have a classification, UNDECIDED or not."""
        return self.chaotic + self.regular + self.undecided

    @property
    def fraction(self) -> np.ndarray:
        """Share of chaotic orbits among those that are decided; NaN where there are none."""
        return _share(self.chaotic, self.chaotic + self.regular)

    @property
    def bounds(self) -> np.ndarray:
        """Shares (2, ...) if all undecided orbits were regular, and if all were chaotic."""
        return np.array([_share(self.chaotic, self.completed), _share(self.chaotic + self.undecided, self.completed)])

    def interval(self, sigmas: float = 1.959964) -> np.ndarray:
        """Return ends (2, ...) of the interval of the fraction that the number of decided orbits leaves open.

        :Source: Wilson 1927, J. Am. Stat. Assoc. 22, 209 (the score interval, good at fractions of 0 and 1 too).
        """
        # Beyond these the ends are 0 and 1, or the fraction itself.
        sigmas = min(max(positive("sigmas", sigmas), 1e-100), 1e100)
        count = (self.chaotic + self.regular) / sigmas**2
        p = self.fraction
        with np.errstate(all="ignore"):
            width = np.sqrt(p * (1 - p) * count + 0.25) / (1 + count)
            middle = (p * count + 0.5) / (1 + count)
        return np.clip([middle - width, middle + width], 0.0, 1.0)

    def of(self, sets: Any) -> Shares:
        """Return the shares of some sets, by an index of arrays."""
        return Shares(*(count[sets] for count in self))

    def said(self) -> str:
        """Say the fraction, of several sets from the least to the largest, with its interval. Where orbits are
        undecided, the bounds for all orbits come first.
        """
        if not np.isfinite(self.fraction).any():
            return f"chaotic fraction unknown: none of {int(np.sum(self.completed))} orbits is decided"
        ends = f"95 %: {_span(self.interval())}"
        if not np.any(self.undecided):
            return f"chaotic fraction {_span(self.fraction)} ({ends})"
        share = _span(100 * _share(self.undecided, self.completed), 1)
        return (
            f"chaotic fraction {_span(self.bounds)} of all orbits, {share} % of them undecided; "
            f"{_span(self.fraction)} of the decided ones ({ends})"
        )


def _share(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.where(np.greater(whole, 0), np.divide(part, whole), np.nan)


def _span(values: np.ndarray, digits: int = 3) -> str:
    ends = dict.fromkeys(f"{end:.{digits}f}" for end in (np.nanmin(values), np.nanmax(values)))
    return " ... ".join(ends)
