"""Classes of orbits, one numbering for all analyses."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Classification(IntEnum):
    """Class of an orbit, by the evidence that an analysis has.

    Attributes
    ----------
    REGULAR : 0
        Quasi-periodic, with as many independent frequencies as coordinates.
    CHAOTIC : 1
        Exponential divergence of neighbouring orbits.
    UNDECIDED : 2
        The run is too short for evidence, the evidence disagrees, or the orbit failed.
    RESONANT : 3
        Regular, with commensurable frequencies or a coordinate at rest.
    IRREGULAR : 4
        Not quasi-periodic: chaos or a transient.

    Notes
    -----
    - `frequency_map`, `orbit_frequencies`, `tunes`: REGULAR if independent frequencies explain all visible lines,
      RESONANT if there are fewer of them, IRREGULAR if they change between the parts of the run.
    - `chaos_map`: REGULAR if no indicator grows as on chaotic orbits over 100 natural periods or more. RESONANT orbits
      are REGULAR here. CHAOTIC if deviation vectors, or orbits, separate beyond the threshold.
    - `islands`: REGULAR for a curve, RESONANT for a chain of islands, CHAOTIC if neighbours separate and fill an area.
    - `fit_torus`: REGULAR if the fitted torus obeys the equations and predicts the orbit, RESONANT for a torus of fewer
      dimensions. IRREGULAR if there is no torus: the orbit is chaotic, changes its frequencies or escapes.
    """

    REGULAR = 0
    CHAOTIC = 1
    UNDECIDED = 2
    RESONANT = 3
    IRREGULAR = 4

    @property
    def is_regular(self) -> bool:
        """True for REGULAR and RESONANT."""
        return bool(is_regular(np.array(self)))


def is_regular(classification: np.ndarray) -> np.ndarray:
    """Return a mask of the classes (orbits,) that are REGULAR or RESONANT."""
    return np.isin(classification, (Classification.REGULAR, Classification.RESONANT))
