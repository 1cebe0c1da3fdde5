"""Observers: what is kept from running orbits, as values that the drivers call block by block.

An observer is a compiled block function with its parameters, rows of memory for each orbit (they survive an
interruption) and numbers written for each orbit. `together` makes one observer of several, so that one pass gives, say,
a section and frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..compile.blocks import observer_block, parameters
from ..compile.jit import LANES
from ..compile.texts import Rows
from ..kernels import birkhoff
from ..kernels import crossings as crossing_kernels
from ..kernels import deviations as deviation_kernels
from ..kernels import zero_one as zero_one_kernels


@dataclass(frozen=True)
class Observer:
    """What to keep of running orbits: the value and the text of a block function, and the rows of memory that an orbit
    needs.

    The text may use `value`, the arguments of an observer (see `fastaff.compile.blocks`) and the package's kernels in
    `names`.
    """

    value: Any
    text: str
    names: tuple[tuple[str, Callable], ...]
    rows: int

    @property
    def function(self) -> Any:
        """The compiled block function."""
        return observer_block(self.value, self.text, self.names)

    @property
    def parameters(self) -> np.ndarray:
        """The parameters that the block function gets."""
        return parameters(self.value)


class _Nothing(NamedTuple):
    unused: float = 0.0


class _Crossings(NamedTuple):
    section: Any
    wanted: float
    direction: float


class _Deviations(NamedTuple):
    model: Any
    signs: tuple[float, ...]
    time: float
    early_stop: float
    slots: float


class _Average(NamedTuple):
    model: Any
    time: float


class _Together(NamedTuple):
    first: Any
    second: Any


def _coordinates(rows: int, array: str = "z") -> str:
    return ", ".join(f"{array}[{r * LANES} + i]" for r in range(rows))


def nothing() -> Observer:
    """Keep nothing but the end state."""
    return Observer(_Nothing(), "    return 0\n", (), 1)


def samples(rows: int) -> Observer:
    """Keep the phase point (rows numbers) at each observation."""
    body = f"    sample({rows}, lanes, orbit, fresh, z, memory, out)\n    return 0\n"
    return Observer(_Nothing(), body, (("sample", birkhoff.sample),), rows + 1)


def crossings(section: Any, wanted: int, degrees_of_freedom: int, vectors: int = 0) -> Observer:
    """Record the brackets of section crossings until `wanted` certain ones are found or the record is full."""
    rows = 2 * degrees_of_freedom * (1 + vectors)
    orbit = ", ".join(f"z[{r * LANES} + i]" for r in Rows(degrees_of_freedom, vectors).orbit)
    value = _Crossings(section, float(wanted), float(section.direction))
    body = (
        "    for i in range(lanes):\n"
        f"        memory[i] = value.section.value({orbit})\n"
        f"    return detect(value.direction, value.wanted, {rows}, lanes, orbit, fresh, t, z, memory, out, done)\n"
    )
    return Observer(value, body, (("detect", crossing_kernels.detect),), crossing_kernels.MEMORY + rows)


def deviations(
    model: Any,
    vectors: int,
    readings: tuple[str, ...],
    signs: tuple[float, ...],
    *,
    time: float,
    early_stop: bool,
    slots: int,
) -> Observer:
    """Keep growth and alignment of the tangent vectors at every step, and judge orbits by readings of them.

    `readings` are texts over the rows of `kernels.deviations`; out holds `slots` records of the time and the readings.
    Of the memory the caller sets each orbit's stride, columns, limits and metric.
    """
    n, k, m = model.degrees_of_freedom, vectors, len(readings)
    rows, across = Rows(n, k), any("ACROSS" in reading for reading in readings)
    at = [f"z[{r * LANES} + i]" for r in rows.orbit]
    vector = [f"z[{(r + n) * LANES} + i]" for r in rows.orbit]
    metric = [f"memory[metric + {r * LANES} + i]" for r in range(2 * n)]
    flow = _names("vf", n)
    along = (
        "    for i in range(lanes):\n"
        f"        {_letters('v', n)}, = value.model.velocity({', '.join(at[n:])})\n"
        f"        {_letters('f', n)}, = value.model.force({', '.join(at[:n])})\n"
        f"        size = {_sum(metric, flow, flow)}\n"
        f"        if fresh[i] > 0.0:\n"
        f"            peak_across(i, {_sum(metric, vector, vector)}, {_sum(metric, flow, vector)}, size, memory)\n"
    )
    text = (
        f"    k, m = {k}, {m}\n"
        f"    sums, lengths, readings, metric = {', '.join(f'place(k, m, {what})*{LANES}' for what in (0, 2, 5, 9))}\n"
        f"    peak({n}, k, place(k, m, 9), lanes, fresh, z, memory)\n{along if across else ''}"
        "    if wait(value.time, value.slots, lanes, fresh, t, memory) == 0.0:\n        return 0\n"
        f"    orthonormalise({n}, k, place(k, m, 9), lanes, z, memory)\n    grow(k, lanes, t, memory)\n    follow(k, "
        "lanes, memory)\n"
        "    for i in range(lanes):\n"
        "        if memory[DUE * LANES + i] > 0.0:\n"
        + "".join(f"            memory[readings + {j * LANES} + i] = {reading}\n" for j, reading in enumerate(readings))
        + "    return judge(k, m, value.signs, value.early_stop, value.slots, value.time, lanes, orbit, t, memory, "
        "out, done)\n"
    )
    names = (
        "wait",
        "peak",
        "orthonormalise",
        "follow",
        "grow",
        "peak_across",
        "volume",
        "alignment",
        "judge",
        "place",
        "LN10",
        "LANES",
        "DUE",
        "AREA",
        "LARGEST",
        "LARGEST_ACROSS",
    )
    # Without the flow it is one function for all models.
    value = _Deviations(model if across else _Nothing(), signs, time, float(early_stop), float(slots))
    end = deviation_kernels.place(k, m, 9) + 2 * n
    return Observer(value, text, tuple((name, getattr(deviation_kernels, name)) for name in names), end)


def _sum(*factors: list[str]) -> str:
    return " + ".join("*".join(term) for term in zip(*factors, strict=True))


def averages(model: Any, vectors: int, time: float) -> Observer:
    """Keep weighted sums of the square of the kinetic energy over both halves of `time`."""
    square = "    for i in range(lanes):\n        memory[i] *= memory[i]\n"
    text = _kinetic(model, vectors) + square + "    average(value.time, lanes, fresh, t, memory)\n    return 0\n"
    return Observer(_Average(model, time), text, (("average", birkhoff.average),), 5)


def kinetic_samples(model: Any) -> Observer:
    """Keep the kinetic energy at every n-th observation of an orbit, where the caller sets n in row 3 of the memory."""
    text = _kinetic(model, 0) + (
        "    thin(lanes, fresh, memory)\n"
        f"    sample(1, lanes, orbit, memory[{4 * LANES} : {5 * LANES}], memory, memory, out)\n    return 0\n"
    )
    return Observer(_Average(model, 0.0), text, (("sample", birkhoff.sample), ("thin", zero_one_kernels.thin)), 5)


def _kinetic(model: Any, vectors: int) -> str:
    momenta = [f"z[{r * LANES} + i]" for r in Rows(model.degrees_of_freedom, vectors).orbit[model.degrees_of_freedom :]]
    return f"    for i in range(lanes):\n        memory[i] = value.model.kinetic_energy({', '.join(momenta)})\n"


def together(first: Observer, second: Observer, columns: int) -> Observer:
    """Make one observer of two: a single pass over the orbits serves both.

    Memory and `out` hold those of the first, then those of the second; `columns` is the width of the first one's `out`.
    An orbit is done when both are done with it; the rows after their memory keep which are.
    """
    split, rows = first.rows, first.rows + second.rows
    scratch = rows * LANES
    both = _Together(first.value, second.value)
    text, names = "", {**dict(first.names), **dict(second.names)}
    for number, part in enumerate((first, second)):
        text += f"    def part{number}(value, lanes, orbit, fresh, t, z, memory, out, done):\n"
        text += "".join(f"    {line}\n" for line in part.text.splitlines())
    text += "    ended = 0\n"
    for number, (field, memory, out) in enumerate(
        (
            ("first", f"memory[: {split * LANES}]", f"out[:, :{columns}]"),
            ("second", f"memory[{split * LANES} : {scratch}]", f"out[:, {columns}:]"),
        )
    ):
        done, fresh = scratch + number * LANES, scratch + 2 * LANES
        text += (
            f"    finished, seen = memory[{done} : {done + LANES}], memory[{fresh} : {fresh + LANES}]\n"
            "    for i in range(lanes):\n        seen[i] = fresh[i] * (1.0 - finished[i])\n"
            f"    part{number}(value.{field}, lanes, orbit, seen, t, z, {memory}, {out}, finished)\n"
        )
    text += (
        "    for i in range(lanes):\n"
        f"        if memory[{scratch} + i] > 0.0 and memory[{scratch + LANES} + i] > 0.0:\n"
        "            done[i] = 1.0\n            ended += 1\n"
        "    return ended\n"
    )
    return Observer(both, text, tuple(names.items()), rows + 3)


def _letters(letter: str, count: int) -> str:
    return ", ".join(f"{letter}{r}" for r in range(count))


def _names(letters: str, count: int) -> list[str]:
    return [f"{letter}{r}" for letter in letters for r in range(count)]
