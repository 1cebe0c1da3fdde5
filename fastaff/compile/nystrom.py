"""Texts of steps of a Runge-Kutta-Nyström scheme of H = T(p) + V(q), T quadratic in the momenta.

Stage s has the force F_s at the end of a drift of c_s h with the momenta p + h sum of a_sj/c_s F_j, which is what the
velocities of the stage come to. `kicks` are the c; `drifts` the coefficients of the sums that are not 0: of all stages,
then of the drift and of the kick of the whole step. A step is added to the state with the rounding errors carried over
to the next (Kahan's summation), in rows 2n...4n.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .jit import LANES
from .texts import Rows, _indent, traced, while_inside

Terms = tuple[tuple[int, ...], ...]
"""Which forces each of the sums is of: those of the stages, the drift's, the kick's."""

CHAIN = 4
"""Terms of a sum that wait for one another."""


def lanes_at_once(half: int) -> int:
    """Return the lanes that take a whole step together: the forces of their stages lie in the fastest cache."""
    return 128 if half <= 2 else 64 if half <= 8 else 32


def spare_rows(n: int, half: int, stages: int) -> int:
    """Return the rows that two sums of forces, the coordinates of a stage and the forces of all stages need."""
    return -(-((stages + 2) * half + n) * lanes_at_once(half) // LANES)


def steps_text(rows: Rows, terms: Terms) -> str:
    """Text of steps of the state in place."""
    width = lanes_at_once(rows.half)
    step = f"count, own, size = min({width}, lanes - first), z[first:], step[first:]\nfull = count == {width}\n"
    step += _step(rows, terms, _lanes)
    return _until_outside(rows, f"for first in range(0, lanes, {width}):\n" + _indent(step, 1))


def march_text(rows: Rows, terms: Terms) -> str:
    """Text of steps of lane 0 with the bits of the others: for a single orbit."""
    kept = traced(f"z[{r * LANES}]" for r in range(2 * rows.half))
    begin = "    own, lanes, count, full = z, 1, 1, False\n"
    return begin + _until_outside(rows, _step(rows, terms, _alone), kept)


def _until_outside(rows: Rows, step: str, kept: str = "") -> str:
    """Text of steps, in the rows behind the state and its carried rounding errors."""
    first, width = 4 * rows.half * LANES, lanes_at_once(rows.half)
    made = f"    sums = z[{first}:]\n    forces = z[{first + width * (2 * rows.half + rows.n)}:]\n"
    return made + _indent(while_inside(rows, step, kept), 1) + "    return taken\n"


def _lanes(text: str, count: str = "count") -> str:
    return f"for i in range({count}):\n" + _indent(text.replace("lane_step", "size[i]"), 1)


def _alone(text: str, count: str = "1") -> str:
    return "i = 0\n" + text.replace("lane_step", "step")


def _step(rows: Rows, terms: Terms, each: Callable[..., str]) -> str:
    """Text of one step of `each` lane: loops over few rows, as only such become vectors. LLVM must look before whether
    rows at unknown places of one array overlap.
    """
    half, width, stages = rows.half, lanes_at_once(rows.half), len(terms) - 2
    starts = [sum(map(len, terms[:k])) for k in range(len(terms))]
    summed = "".join(
        f"{'el' * (s > 1)}if s == {s}:\n" + _indent(_summed(rows, each, terms[s], starts[s]), 1)
        for s in range(1, stages)
    )
    added = "increment = change[i] + error[i]\nwhole = mine[i] + increment\n"
    added += "error[i] = increment - (whole - mine[i])\nmine[i] = whole\n"
    time = f"own[{(rows.time or 0) * LANES} + i]"
    return (
        f"for r in range({half}):\n    total = sums[{width}*r:]\n{_indent(each('total[i] = 0.0'), 1)}"
        f"for s in range({stages}):\n    node = kicks[s]\n"
        + _indent(summed + _parts(rows, lambda part: _stage(rows, each, part)), 1)
        + _summed(rows, each, terms[-2], starts[-2])
        + _summed(rows, each, terms[-1], starts[-1], half)
        + _parts(rows, lambda part: _end(rows, each, part))
        + f"for r in range({2 * half}):\n"
        + f"    mine, error, change = own[{LANES}*r:], own[{LANES}*(r + {2 * half}):], sums[{width}*r:]\n"
        + _indent(each(added), 1)
        + (each(f"{time} = value.phase({time})\n") if rows.time is not None else "")
    )


def _summed(rows: Rows, each: Callable[..., str], stages: Sequence[int], first: int, target: int = 0) -> str:
    """Text that sets the sums of all rows, from row `target` on, to those of the forces of these stages, with the
    coefficients from the number `first` on. A time has a velocity of its own. Rows of a full stretch of lanes follow
    one another: one loop goes through all.
    """
    half, width = rows.half, lanes_at_once(rows.half)
    chains = []
    for start in range(0, len(stages), CHAIN):
        text = ""
        for k, stage in list(enumerate(stages))[start : start + CHAIN]:
            known = f"known[{stage * half * width} + i]"
            text = f"fma(a{k}, {known}, {text})" if text else f"a{k}*{known}"
        chains.append(text)
    top = width * (half - 1 if rows.time is not None and not rows.vectors and not target else half)
    return (
        "".join(f"a{k} = drifts[{first + k}]\n" for k in range(len(stages)))
        + f"apart, many = ({top}, {top}) if full else ({width}, count)\n"
        + f"for at in range(0, {top}, apart):\n    total, known = sums[at + {width * target}:], forces[at:]\n"
        + _indent(each(f"total[i] = {' + '.join(chains)}\n", "many"), 1)
    )


def _parts(rows: Rows, text: Callable[[range], str]) -> str:
    """Text for the orbit, with the names of its rows, and for each vector, with those of the first."""
    n = rows.n
    vectors = f"for part in range({n}, {rows.half}, {n}):\n{_indent(text(range(n, 2 * n)), 1)}" if rows.vectors else ""
    return f"part = 0\n{text(range(n))}{vectors}"


def _moved(rows: Rows, part: range) -> str:
    """Text that sets the v of a part to the velocities at the momenta that its sums make."""
    momenta = (f"mine[{(rows.half + k) * LANES} + i]" for k in range(rows.n))
    sums = (f"total[{k * lanes_at_once(rows.half)} + i]" for k in range(rows.n))
    text = "".join(
        f"p{r} = fma(h, {total}, {p})\n" if k != rows.time else f"p{r} = {p}\n"
        for k, (r, p, total) in enumerate(zip(part, momenta, sums))
    )
    return f"h = lane_step\n{text}{rows.velocities(part)}"


def _stage(rows: Rows, each: Callable[..., str], part: range) -> str:
    """Text that sets the forces of stage s of a part."""
    half, width, n = rows.half, lanes_at_once(rows.half), rows.n
    place = [f"sums[{(2 * half + r) * width} + i]" for r in range(n)]
    text = "" if part.start == 0 else "".join(f"q{r} = {place[r]}\n" for r in range(n))
    text += _moved(rows, part) + "hd = node*h\n"
    text += "".join(f"q{r} = fma(hd, v{r}, mine[{k * LANES} + i])\n" for k, r in enumerate(part)) + rows.forces(part)
    text += "".join(f"now[{k * width} + i] = f{r}\n" for k, r in enumerate(part))
    if part.start == 0 and rows.vectors:
        text += "".join(f"{place[r]} = q{r}\n" for r in range(n))
    begin = f"mine, total = own[{LANES}*part:], sums[{width}*part:]\nnow = forces[{width}*({half}*s + part):]\n"
    return begin + each(text)


def _end(rows: Rows, each: Callable[..., str], part: range) -> str:
    """Text that makes of the sums of a part what the step adds to its coordinates and momenta."""
    width = lanes_at_once(rows.half)
    drift = _moved(rows, part) + "".join(f"total[{k * width} + i] = h*v{r}\n" for k, r in enumerate(part))
    kick = "".join(f"total[{k * width} + i] *= lane_step\n" for k in range(rows.n))
    begin = f"mine, total = own[{LANES}*part:], sums[{width}*part:]\n"
    return f"{begin}{each(drift)}total = sums[{width}*({rows.half} + part):]\n{each(kick)}"
