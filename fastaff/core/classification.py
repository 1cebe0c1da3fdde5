"""Classes of orbits, one numbering for all analyses."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Classification(IntEnum):
    """Class of an orbit, by the evidence that an analysis has; `.is_regular` is True for REGULAR and RESONANT.

    - REGULAR: quasi-periodic, with as many independent frequencies as coordinates. `frequency_map`,
      `orbit_frequencies` and `tunes`: these explain all visible lines. `fit_torus`: the fitted torus obeys the
      equations and predicts the orbit. `islands`: the rotation number of the curve converges. `chaos_map`: no
      indicator grows as on chaotic orbits over 100 natural periods or more; it does not tell REGULAR from RESONANT.
    - CHAOTIC: exponential divergence. `chaos_map`: tangent vectors grow, or orbits part, beyond the threshold of an
      indicator. `islands`: neighbours part until their points fill an area.
    - UNDECIDED: the time is too short for evidence, the evidence disagrees, or the orbit failed. All analyses.
    - RESONANT: regular, with commensurable frequencies or a coordinate at rest. Frequency analyses: fewer
      independent frequencies than coordinates. `fit_torus`: a torus of fewer dimensions. `islands`: a chain of islands.
    - IRREGULAR: not quasi-periodic, chaotic or transient. Frequency analyses: the frequencies change between the parts
      of the run. `fit_torus` and `fit_samples`: no torus, of an orbit that is chaotic, changes its frequencies or
      escapes.
    """

    REGULAR = 0
    CHAOTIC = 1
    UNDECIDED = 2
    RESONANT = 3
    IRREGULAR = 4

    @property
    def is_regular(self) -> bool:
        """True for REGULAR and RESONANT."""
        return self in (Classification.REGULAR, Classification.RESONANT)


def is_regular(classification: np.ndarray) -> np.ndarray:
    """Return a mask of the classes (orbits,) that are REGULAR or RESONANT."""
    return np.isin(classification, (Classification.REGULAR, Classification.RESONANT))
