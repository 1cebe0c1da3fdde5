"""The same levels by Bohr and Sommerfeld, by EBK, and exactly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.docstrings import inserts_parameters
from ...results.display import screen
from ...results.progress import says_progress
from ...systems.charts import Chart
from ...systems.models import Body
from ..states.level_table import LevelTable
from .exact_levels import exact_levels
from .quasiclassical_levels import BOHR_SOMMERFELD, EBK, quasiclassical_levels


class Quantizations(NamedTuple):
    """The same levels by three methods.

    Attributes
    ----------
    bohr_sommerfeld : LevelTable
        Levels of J = n h.
    ebk : LevelTable
        Levels of J = (n + 1/2) h.
    exact : LevelTable
        Exact levels.

    References
    ----------
    Martens & Slawianowski, EQ3.2 and EQ3.6 beside EQ5.1 and EQ5.2.
    """

    bohr_sommerfeld: LevelTable
    ebk: LevelTable
    exact: LevelTable

    def __repr__(self) -> str:
        return screen(self)

    @property
    def E(self) -> np.ndarray:
        """Energies in rows Bohr-Sommerfeld, EBK and exact, shape (3, levels)."""
        return np.array([self.bohr_sommerfeld.E, self.ebk.E, self.exact.E])


@says_progress
@inserts_parameters
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

    Parameters
    ----------
    {solvable_body}
    n : array_like of int, shape (2,) or (2, levels)
        Quantum numbers of the two coordinates in the order of the chart, at least 0.
    m, l : int or array_like of int, shape (levels,)
        Quantum numbers of spin and vorticity.
    {hbar}
    {quantum_chart}
    {single_valued}

    Returns
    -------
    Quantizations
        Three tables of the same levels.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the body has no closed-form states or an argument has a wrong value.

    Notes
    -----
    Bohr-Sommerfeld lacks the zero-point energy 2 hbar omega of two librations. EBK, with Maslov indices 2 and 2, is
    exact.

    References
    ----------
    Martens & Slawianowski, section 5, below EQ5.1; Keller 1958, Ann. Phys. 4, 180 (EBK).

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
