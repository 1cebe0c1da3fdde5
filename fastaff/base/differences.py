"""Central differences of order 8: weights of the values at OFFSETS steps from a point, over the step (FIRST) or its
square (SECOND).
"""

from __future__ import annotations

import numpy as np

FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
OFFSETS = np.arange(-4, 5)
