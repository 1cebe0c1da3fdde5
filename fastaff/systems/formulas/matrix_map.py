"""A matrix as a map: its entries are the parameters m11, m12, ... of one text for each size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.numbers import shown

MOST_ROWS = 8
"""Most rows of a matrix: its 64 entries are as many parameters as a text may have."""

_NAMES = {2: ("x", "p"), 4: ("x y", "p_x p_y"), 6: ("x y z", "p_x p_y p_z"), 8: ("q1 q2 q3 q4", "p1 p2 p3 p4")}
"""Names of coordinates and momenta by the number of rows."""


def is_matrix(given: Any) -> bool:
    """Tell whether an argument is an array, or lists of lists, in place of a text."""
    return isinstance(given, np.ndarray) or (isinstance(given, Sequence) and not isinstance(given, str))


def checked_matrix(given: Any) -> np.ndarray:
    """Return the matrix of a linear map; ValueError or TypeError for arrays that are none."""
    try:
        matrix = np.asarray(given)
        matrix = matrix.astype(np.float64, casting="same_kind") if matrix.dtype.kind != "O" else matrix
    except (TypeError, ValueError):
        matrix = np.empty(0, dtype=object)
    if matrix.dtype != np.float64:
        raise TypeError(f"text must be a map or a matrix of real numbers, got {shown(given, 60)}")
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or matrix.shape[0] not in _NAMES:
        sizes = ", ".join(f"{n}x{n}" for n in _NAMES)
        raise ValueError(f"text must be a matrix of one of the shapes {sizes}, got shape {matrix.shape}")
    if not np.isfinite(matrix).all():
        raise ValueError(f"text must be a matrix of finite numbers, got {shown(given, 60)}")
    return matrix


def names_of(matrix: np.ndarray) -> tuple[str, str]:
    """Return the names of coordinates and of momenta of a matrix."""
    return _NAMES[len(matrix)]


def text_of_matrix(rows: Sequence[str]) -> str:
    """Return the text of the linear map of these rows."""
    return "; ".join(
        f"{name}' = {' + '.join(f'm{i}{j}*{other}' for j, other in enumerate(rows, 1))}"
        for i, name in enumerate(rows, 1)
    )


def entries(matrix: np.ndarray) -> dict[str, float]:
    """Return the entries of a matrix as parameters."""
    return {f"m{i + 1}{j + 1}": float(number) for (i, j), number in np.ndenumerate(matrix)}
