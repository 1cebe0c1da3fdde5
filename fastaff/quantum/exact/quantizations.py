"""The same levels by Bohr and Sommerfeld, by EBK, and exactly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...results.display import screen
from ...results.progress import says_progress
from ...systems.charts import Chart
from ...systems.models import Body
from ..states.level_table import LevelTable
from .exact_levels import exact_levels
from .quasiclassical_levels import BOHR_SOMMERFELD, EBK, quasiclassical_levels


class Quantizations(NamedTuple):
    """The same levels three times: by Bohr and Sommerfeld (J = n h), by EBK (J = (n + 1/2) h), exact.

    :Source: Martens & Slawianowski, EQ3.2 and EQ3.6 beside EQ5.1 and EQ5.2.
    """

    bohr_sommerfeld: LevelTable
    ebk: LevelTable
    exact: LevelTable

    def __repr__(self) -> str:
        return screen(self)

    @property
    def E(self) -> np.ndarray:
        """The energies, rows Bohr-Sommerfeld, EBK, exact (3, levels)."""
        return np.array([self.bohr_sommerfeld.E, self.ebk.E, self.exact.E])


@says_progress
def quantizations(
    model: Body,
    *,
    n: ArrayLike,
    m: ArrayLike,
    l: ArrayLike,
    hbar: float = 1.0,
    chart: Chart | None = None,
    single_valued: bool = True,
) -> Quantizations:
    """Compute levels of a solvable body by Bohr and Sommerfeld, by EBK, and exactly.

    :Parameters: model: a solvable Body; n, m, l, hbar, chart, single_valued as in `exact_levels`.
    :Returns: Quantizations.
    :Raises: ValueError or TypeError for wrong input.
    :Formula: Bohr-Sommerfeld lacks the zero point 2 hbar omega of two librations; EBK, with Maslov indices 2, 2, is
        exact.
    :Source: Martens & Slawianowski, section 5, below EQ5.1; Keller 1958, Ann. Phys. 4, 180 (EBK).

    Examples
    --------
    >>> found = fa.quantum.quantizations(fa.Body(fa.Harmonic()), n=(1, 0), m=1, l=1)
    >>> found.bohr_sommerfeld.E.round(9), found.ebk.E.round(9), found.exact.E.round(9)
    (array([3.]), array([5.]), array([5.]))
    """
    exact = exact_levels(model, n=n, m=m, l=l, hbar=hbar, chart=chart, single_valued=single_valued)
    first, second = (
        quasiclassical_levels(
            model,
            n=exact.n,
            m=exact.m,
            l=exact.l,
            maslov=maslov,
            hbar=exact.hbar,
            single_valued=single_valued,
            chart=chart,
        )
        for maslov in (BOHR_SOMMERFELD, EBK)
    )
    return Quantizations(first, second, exact)
