"""Central differences of order 8: weights of the values at OFFSETS steps from a point, over the step (FIRST) or its
square (SECOND).
"""

from __future__ import annotations

import numpy as np

FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Weights of the first derivative, over the step."""

SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
"""Weights of the second derivative, over the square of the step."""

OFFSETS = np.arange(-4, 5)
"""Places of the values, in steps from the point."""
