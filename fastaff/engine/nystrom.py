"""Texts of steps of a Runge-Kutta-Nyström scheme of H = T(p) + V(q), T quadratic in the momenta.

Stage s has the force F_s at the end of a drift of c_s h by the velocities at the momenta p + h sum of a_sj/c_s F_j.
`kicks` are the c; `drifts` the coefficients of the sums that are not 0: of all stages, then of the drift and of the
kick of the whole step. A step is added to the state with the rounding errors carried over to the next (Kahan's
summation), in rows 2n...4n.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .jit import LANES
from .lane_sums import Terms, sum_of_table
from .state_rows import CARRIED
from .texts import StateRows, _indent, traced, while_inside


def lanes_at_once(half: int) -> int:
    """Return the number of lanes that take a whole step together: the forces of their stages fit the fastest cache."""
    if half <= 2:
        return 128
    if half <= 8:
        return 64
    return 32


def spare_rows(n: int, half: int, stages: int) -> int:
    """Return the number of rows for two sums of forces, the coordinates of a stage and the forces of all stages."""
    return -(-((stages + 2) * half + n) * lanes_at_once(half) // LANES)


def steps_text(rows: StateRows, terms: Terms) -> str:
    """Text of steps of the state in place; terms: the forces in each sum."""
    width = lanes_at_once(rows.half)
    step = f"count, own, size = min({width}, lanes - first), z[first:], step[first:]\n"
    step += _step(rows, width, len(terms) - 2, _lanes)
    return _until_outside(rows, width, terms, f"for first in range(0, lanes, {width}):\n" + _indent(step, 1))


def march_text(rows: StateRows, terms: Terms) -> str:
    """Text of steps of lane 0 with the bits of the others: for a single orbit."""
    kept = traced(f"z[{r * LANES}]" for r in range(2 * rows.half))
    step = _step(rows, 1, len(terms) - 2, _alone)
    return "    own, lanes, count = z, 1, 1\n" + _until_outside(rows, 1, terms, step, kept)


def sums(kind: str, half: int, terms: Terms) -> Any:
    """Return the function `summed` that these texts call: a march has rows of one lane."""
    alone = kind == "nystrom_march"
    return sum_of_table(terms, half * (1 if alone else lanes_at_once(half)), vectors=not alone)


def _until_outside(rows: StateRows, width: int, terms: Terms, step: str, kept: str = "") -> str:
    """Text of steps, in the rows after the state and its carried rounding errors."""
    first = 4 * rows.half * LANES
    made = f"    # Sums of forces: {', '.join(map(str, terms))}\n"
    made += f"    sums = z[{first}:]\n    forces = z[{first + width * (2 * rows.half + rows.n)}:]\n"
    return made + _indent(while_inside(rows, step, kept), 1) + "    return taken\n"


def _lanes(text: str, count: str = "count") -> str:
    return f"for i in range({count}):\n" + _indent(text.replace("lane_step", "size[i]"), 1)


def _alone(text: str, count: str = "1") -> str:
    return "i = 0\n" + text.replace("lane_step", "step")


def _step(rows: StateRows, width: int, stages: int, each: Callable[..., str]) -> str:
    """Text of one step of `each` lane: loops over few rows, as only these become vectors. LLVM must first test whether
    rows at unknown places of one array overlap.
    """
    half = rows.half
    time = f"own[{(rows.time or 0) * LANES} + i]"
    stage = f"node = kicks[s]\n{_parts(rows, lambda part: _stage(rows, width, each, part))}"
    return (
        f"for s in range({stages + 2}):\n"
        + _indent(_summed(rows, width, stages) + f"if s < {stages}:\n{_indent(stage, 1)}", 1)
        + _parts(rows, lambda part: _end(rows, width, each, part))
        + f"for r in range({2 * half}):\n"
        + f"    mine, error, change = own[{LANES}*r:], own[{LANES}*(r + {2 * half}):], sums[{width}*r:]\n"
        + _indent(each(CARRIED), 1)
        + (each(f"{time} = value.phase({time})\n") if rows.time is not None else "")
    )


def _summed(rows: StateRows, width: int, stages: int) -> str:
    """Text that makes sum s; that of the kick follows that of the drift. A time has its own velocity. Rows of a full
    width of lanes are contiguous: one loop goes through all.
    """
    kick = stages + 1
    top = f"{width * rows.half}"
    if rows.time is not None and not rows.vectors:
        top += f" if s == {kick} else {width * (rows.half - 1)}"
    return (
        f"top, total = {top}, sums[{width * rows.half} if s == {kick} else 0:]\n"
        f"apart, many = (top, top) if count == {width} else ({width}, count)\n"
        "for at in range(0, top, apart):\n    summed(total[at:], forces[at:], drifts, s, many)\n"
    )


def _parts(rows: StateRows, text: Callable[[range], str]) -> str:
    """Text for the orbit, with the names of its rows, and for each vector, with those of the first."""
    n = rows.n
    vectors = f"for part in range({n}, {rows.half}, {n}):\n{_indent(text(range(n, 2 * n)), 1)}" if rows.vectors else ""
    return f"part = 0\n{text(range(n))}{vectors}"


def _moved(rows: StateRows, width: int, part: range) -> str:
    """Text that sets the v of a part to the velocities at the momenta that its sums make."""
    momenta = (f"mine[{(rows.half + k) * LANES} + i]" for k in range(rows.n))
    sums = (f"total[{k * width} + i]" for k in range(rows.n))
    text = "".join(
        f"p{r} = fma(h, {total}, {p})\n" if k != rows.time else f"p{r} = {p}\n"
        for k, (r, p, total) in enumerate(zip(part, momenta, sums))
    )
    return f"h = lane_step\n{text}{rows.velocities(part)}"


def _stage(rows: StateRows, width: int, each: Callable[..., str], part: range) -> str:
    """Text that sets the forces of stage s of a part."""
    half = rows.half
    n = rows.n
    place = [f"sums[{(2 * half + r) * width} + i]" for r in range(n)]
    text = "" if part.start == 0 else "".join(f"q{r} = {place[r]}\n" for r in range(n))
    text += _moved(rows, width, part) + "hd = node*h\n"
    text += "".join(f"q{r} = fma(hd, v{r}, mine[{k * LANES} + i])\n" for k, r in enumerate(part)) + rows.forces(part)
    text += "".join(f"now[{k * width} + i] = f{r}\n" for k, r in enumerate(part))
    if part.start == 0 and rows.vectors:
        text += "".join(f"{place[r]} = q{r}\n" for r in range(n))
    begin = f"mine, total = own[{LANES}*part:], sums[{width}*part:]\nnow = forces[{width}*({half}*s + part):]\n"
    return begin + each(text)


def _end(rows: StateRows, width: int, each: Callable[..., str], part: range) -> str:
    """Text that turns the sums of a part into the increments of its coordinates and momenta over the step."""
    drift = _moved(rows, width, part) + "".join(f"total[{k * width} + i] = h*v{r}\n" for k, r in enumerate(part))
    kick = "".join(f"total[{k * width} + i] *= lane_step\n" for k in range(rows.n))
    begin = f"mine, total = own[{LANES}*part:], sums[{width}*part:]\n"
    return f"{begin}{each(drift)}total = sums[{width}*({rows.half} + part):]\n{each(kick)}"
