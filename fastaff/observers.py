"""Observers: what is kept from running orbits, as values that the drivers call block by block (layer L2).

An observer is a compiled block function with its parameters, rows of memory for each orbit (they survive an interruption) and numbers
written for each orbit. `together` makes one observer of several, so that one pass gives, say, a section and frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ._blocks import observer_block, parameters
from ._jit import LANES
from .kernels import crossings as crossing_kernels
from .kernels import rotation as rotation_kernels


@dataclass(frozen=True)
class Observer:
    """A block function for the drivers, its parameters and the rows of memory that an orbit needs."""

    function: Callable
    parameters: np.ndarray
    rows: int


class _Nothing(NamedTuple):
    unused: float = 0.0


class _Crossings(NamedTuple):
    section: Any
    wanted: float
    direction: float


class _Signals(NamedTuple):
    angles: Any


class _Rotation(NamedTuple):
    angles: Any
    model: Any
    time: float


def _coordinates(rows: int, array: str = "z") -> str:
    return ", ".join(f"{array}[{r * LANES} + i]" for r in range(rows))


def nothing() -> Observer:
    """Keep nothing but the end state."""
    return Observer(observer_block(_Nothing(), "    return 0\n", ()), np.zeros(1), 1)


def samples(rows: int) -> Observer:
    """Keep the phase point (rows numbers) at each observation."""
    body = f"    sample({rows}, lanes, orbit, fresh, z, memory, out)\n    return 0\n"
    block = observer_block(_Nothing(), body, (("sample", rotation_kernels.sample),))
    return Observer(block, np.zeros(1), rows + 1)


def crossings(section: Any, wanted: int, degrees_of_freedom: int) -> Observer:
    """Record the brackets of section crossings until `wanted` certain ones are found or the record is full."""
    rows = 2 * degrees_of_freedom
    value = _Crossings(section, float(wanted), float(section.direction))
    body = (
        "    for i in range(lanes):\n"
        f"        memory[i] = value.section.value({_coordinates(rows)})\n"
        f"    return detect(value.direction, value.wanted, {rows}, lanes, orbit, fresh, t, z, memory, out, done)\n"
    )
    block = observer_block(value, body, (("detect", crossing_kernels.detect),))
    return Observer(block, parameters(value), crossing_kernels.MEMORY + rows)


def _with_signals(angles: Any, action: str, names: tuple, rows: int) -> Observer:
    """Return an observer that evaluates the signals of the angles into memory, then acts on them."""
    n = len(angles.names)
    signals = _coordinates(4 * n, "memory")
    body = (
        f"    for i in range(lanes):\n        {signals} = value.angles.signals({_coordinates(2 * n)})\n"
        f"    {action}\n    return 0\n"
    )
    value = _Signals(angles)
    return Observer(observer_block(value, body, names), parameters(value), rows)


def extents(angles: Any) -> Observer:
    """Keep the smallest and largest value of each signal of the angles."""
    signals = 4 * len(angles.names)
    action = f"widen({signals}, lanes, fresh, memory)"
    return _with_signals(angles, action, (("widen", rotation_kernels.widen),), 3 * signals)


def signal_samples(angles: Any) -> Observer:
    """Keep the signals of the angles at each observation."""
    rows = 4 * len(angles.names)
    action = f"sample({rows}, lanes, orbit, fresh, memory, memory, out)"
    return _with_signals(angles, action, (("sample", rotation_kernels.sample),), rows + 1)


def rotation(angles: Any, model: Any, time: float) -> Observer:
    """Keep the weighted Birkhoff sums of the angles' rates over `time` and its halves."""
    n = len(angles.names)
    p, q, v, f = _coordinates(2 * n).split(", ")[n:], _coordinates(n), _letters("v", n), _letters("f", n)
    body = (
        "    for i in range(lanes):\n"
        f"        {v} = value.model.velocity({', '.join(p)})\n"
        f"        {f} = value.model.force({q})\n"
        f"        {_coordinates(8 * n + 2, 'memory')} = value.angles.rates({_coordinates(2 * n)}, {v}, {f})\n"
        f"    rotate(value.time, {angles.clocks}, lanes, fresh, t, memory)\n"
        "    return 0\n"
    )
    value = _Rotation(angles, model, time)
    rows = 8 * n + 2 + rotation_kernels.SHARED + rotation_kernels.WEIGHTS + rotation_kernels.PER_ANGLE * n
    return Observer(observer_block(value, body, (("rotate", rotation_kernels.rotate),)), parameters(value), rows)


def _letters(letter: str, count: int) -> str:
    return ", ".join(f"{letter}{r}" for r in range(count))
