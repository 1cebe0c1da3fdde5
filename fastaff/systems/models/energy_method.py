"""The method `energy` of models H = T(p) + V(q) with their further terms: the sum, at rows of a phase point.

No kernel compiles it, so it is a property, which keys of compiled code leave out; functions of a class are in them.
"""

from __future__ import annotations

from types import MethodType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.numbers import kind_of
from .contracts import Arithmetic


def _energy(model: Any, /, *rows: ArrayLike) -> np.ndarray | np.float64:
    """Return the energy H at rows of a phase point, Jacobi's integral in a rotating frame.

    Parameters
    ----------
    *rows : float or array_like
        Coordinates, then momenta: ``model.energy(*z)`` for phase points z (2n, ...). Those of a driven system include
        the time t and p_t.

    Returns
    -------
    float or ndarray
        Energy H, with p_t for a driven system; NaN outside the domain.

    Raises
    ------
    TypeError
        If there are more or fewer rows than a phase point has.
    """
    from .mechanics import system_of  # the keys of models' kernels do not cover what only this function reads

    system = system_of(model)
    if len(rows) != system.rows:
        raise TypeError(
            f"energy must be given {system.rows} rows of {kind_of(model)}, as model.energy(*z), got {len(rows)}."
        )
    z = np.array(np.broadcast_arrays(*(np.asarray(row, dtype=np.float64) for row in rows)))
    found: np.ndarray | np.float64 = system.energies(z)[()]
    return found


def energy_method(model: Any) -> Arithmetic:
    """Return the method of a model: the getter of a property, as no kernel may read it."""
    return MethodType(_energy, model)
