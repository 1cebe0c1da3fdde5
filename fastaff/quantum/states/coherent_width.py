"""The width of coherent states, in `coherent_packet` and `husimi` alike.

    Psi(q) = (2 pi width^2)^(-1/2) exp(-|q - q0|^2/(4 width^2) + i p0.(q - q0)/hbar)    of each plane

width is the standard deviation of |Psi|^2 in each direction of position, hbar/(2 width) that in each of momentum.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...base.arrays import checked


def plane_widths(width: ArrayLike) -> tuple[float, float]:
    """Return the widths of the planes a and b from one positive number or two; raises ValueError or TypeError for
    others.
    """
    widths = checked("width", width, ())
    if widths.shape not in ((), (2,)) or not np.all(widths > 0):
        raise ValueError(f"width must be one or two positive numbers, got {width!r}")
    if np.any((widths < 1e-100) | (widths > 1e100)):
        raise ValueError(f"width must lie between 1e-100 and 1e100, got {width!r}")
    first, second = np.broadcast_to(widths, (2,)).tolist()
    return first, second
