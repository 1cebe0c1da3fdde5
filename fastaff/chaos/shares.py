"""Shares of chaotic orbits among those that are decided, with intervals from numbers and undecided orbits."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import positive


class Shares(NamedTuple):
    """Numbers of orbits of each class, and the chaotic fraction that they give.

    Parameters
    ----------
    chaotic, regular, undecided : ndarray of int, shape (...)
        Numbers of orbits of one set, or of an array of sets.
    """

    chaotic: np.ndarray
    regular: np.ndarray
    undecided: np.ndarray

    @property
    def completed(self) -> np.ndarray:
        """Number of orbits that have a classification, UNDECIDED or not."""
        return self.chaotic + self.regular + self.undecided

    @property
    def fraction(self) -> np.ndarray:
        """Fraction of chaotic orbits among the decided ones; NaN if there are none."""
        return _share(self.chaotic, self.chaotic + self.regular)

    @property
    def bounds(self) -> np.ndarray:
        """Chaotic fractions if all undecided orbits were regular, and if all were chaotic, shape (2, ...)."""
        return np.array([_share(self.chaotic, self.completed), _share(self.chaotic + self.undecided, self.completed)])

    @inserts_parameters
    def interval(self, sigmas: float = 1.959964) -> np.ndarray:
        """Return the confidence interval of the fraction, due to the number of decided orbits.

        Parameters
        ----------
        {sigmas}

        Returns
        -------
        ndarray, shape (2, ...)
            Lower and upper ends. The score interval is valid for fractions of 0 and 1 too.

        References
        ----------
        Wilson 1927, J. Am. Stat. Assoc. 22, 209.
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
        """Return the shares of some of the sets.

        Parameters
        ----------
        sets : index
            Index of the arrays.

        Returns
        -------
        `Shares`
            Shares of these sets.
        """
        return Shares(*(count[sets] for count in self))

    def bounds_text(self) -> str:
        """Return the bounds of the fraction for all orbits as text.

        Returns
        -------
        str
            For a caption, with the number of undecided orbits.
        """
        total = int(np.sum(self.completed))
        if not total:
            return "chaotic fraction unknown: no orbits"
        return f"chaotic fraction {_span(self.bounds)} ({int(np.sum(self.undecided))} of {total} undecided)"

    def fraction_text(self) -> str:
        """Return the fraction as text, with its interval; for several sets the range of the fractions.

        Returns
        -------
        str
            Text. If orbits are undecided, the bounds for all orbits come first.
        """
        total = int(np.sum(self.completed))
        undecided = int(np.sum(self.undecided))
        if undecided == total:
            return self.bounds_text()
        ends = f"95 %: {_span(self.interval())}"
        if not undecided:
            return f"chaotic fraction {_span(self.fraction)} ({ends})"
        return f"{self.bounds_text()}, {_span(self.fraction)} of the decided orbits ({ends})"


def _share(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.where(np.greater(whole, 0), np.divide(part, whole), np.nan)


def _span(values: np.ndarray) -> str:
    ends = dict.fromkeys(f"{round(float(end), 3):g}" for end in (np.nanmin(values), np.nanmax(values)))
    return " to ".join(ends)
