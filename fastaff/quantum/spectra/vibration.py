"""Levels of systems that are not bodies: their checks and arguments."""

from __future__ import annotations

from typing import Any

from ...core.interruption import partial_result_on_interrupt
from ...core.numbers import fits, positive, whole
from ..exact.mode_tori import bodies_alone, is_vibration
from ..solvers.vibrations import COORDINATES, vibration_levels
from ..states.level_table import LevelTable
from ..states.symmetry import action_quantum


def vibrates(model: Any) -> bool:
    """Return whether a system is no body and has few coordinates and a kinetic energy quadratic in the momenta."""
    return is_vibration(model) and model.degrees_of_freedom <= COORDINATES


def vibration(
    model: Any, m: Any, l: Any, count: Any, hbar: Any, tolerance: Any, single_valued: Any, chart: Any, callback: Any
) -> LevelTable:
    """Return the levels of a system that `vibrates`; refuse arguments that only bodies have."""
    bodies_alone(
        model, {"m": (m, None), "l": (l, None), "single_valued": (single_valued, True), "chart": (chart, None)}
    )
    fits("count", count := whole("count", count, 1), 16)
    known: list[LevelTable] = []
    with partial_result_on_interrupt("spectrum", lambda: known[-1] if known else None):
        vibration_levels(model, count, action_quantum(hbar), positive("tolerance", tolerance), known, callback)
        if callback is not None:
            callback(1.0)
    return known[-1]
