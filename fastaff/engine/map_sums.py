"""Texts of block functions of maps that add up weighted sums along their iterates: moments and angles of loops.

They are splittings whose states have more rows after those of the map, named in `Moments` and `AngleSumRows`; the
weights of the iterates come in the table of drifts. An orbit's sums have the same bits beside any other orbits.
"""

from __future__ import annotations

from typing import NamedTuple

from .jit import LANES
from .map_texts import _counted, _image, _names, _periods, _read, _stored
from .plane_loops import COLUMNS, MOMENTS, SPANS
from .state_rows import StateRows
from .texts import _at, _indent, _loop


class Moments(NamedTuple):
    """Rows of a state for the moments, after the 2n rows of the map: iterates so far; then for each plane without a
    period the origin, the last point relative to it, and the MOMENTS.
    """

    size: int
    planes: tuple[int, ...]

    @property
    def iterates(self) -> int:
        """The row of the iterates so far."""
        return self.size

    def plane(self, k: int) -> int:
        """The first row of plane number k: origin (2), last point (2), then its moments."""
        return self.size + 1 + k * (4 + MOMENTS)

    @property
    def end(self) -> int:
        """The number of all rows."""
        return self.plane(len(self.planes))


class AngleSumRows(NamedTuple):
    """Rows of a state for the angles, after the 2n rows of the map: iterates so far; for each angle, first those of
    coordinates with a period, then those of the other planes, the last step and its sums over SPANS; for each of these
    planes the COLUMNS of its loop and its last value there.
    """

    size: int
    wound: tuple[int, ...]
    planes: tuple[int, ...]

    @property
    def iterates(self) -> int:
        """The row of the iterates so far."""
        return self.size

    @property
    def angles(self) -> int:
        """The number of angles."""
        return len(self.wound) + len(self.planes)

    def step(self, k: int) -> int:
        """The row of the last step of angle number k, before those of its sums."""
        return self.size + 1 + k * (1 + SPANS)

    def plane(self, k: int) -> int:
        """The first row of plane number k: COLUMNS, then its last value (2)."""
        return self.step(self.angles) + k * (COLUMNS.end + 2)

    @property
    def end(self) -> int:
        """The number of all rows."""
        return self.plane(len(self.planes))


def moments_of(winding: tuple[bool, ...]) -> Moments:
    """Return the rows of the moments of a map; winding (2n,): which of its rows have a period."""
    n = len(winding) // 2
    return Moments(2 * n, tuple(r for r in range(n) if not winding[r]))


def angles_of(winding: tuple[bool, ...]) -> AngleSumRows:
    """Return the rows of the angles of a map; winding (2n,): which of its rows have a period."""
    n = len(winding) // 2
    return AngleSumRows(2 * n, tuple(r for r in range(n) if winding[r]), tuple(r for r in range(n) if not winding[r]))


def moments(rows: StateRows) -> str:
    """Iterates that add up the MOMENTS of planes, with the weight drifts[k] of iterate k."""
    own = moments_of(rows.winding)
    n = rows.n
    body = "w = drifts[before + taken]\n"
    for k, r in enumerate(own.planes):
        at = own.plane(k)
        first = _at(at + 2)
        second = _at(at + 3)
        text = f"x, y = {first}, {second}\nxx, yy = {_at(r)} - {_at(at)}, {_at(n + r)} - {_at(at + 1)}\n"
        products = ("x", "y", "(x*x)", "(x*y)", "(y*y)", "(xx*x)", "(xx*y)", "(yy*x)", "(yy*y)")
        text += "".join(f"{_at(at + 4 + j)} += w*{product}\n" for j, product in enumerate(products))
        body += _loop(text + f"{first} = xx\n{second} = yy\n", 0)
    return _summed(rows, own.iterates, "", body)


def angles(rows: StateRows) -> str:
    """Iterates that add up the steps of angles over SPANS, with the weights drifts[k*SPANS + s] of iterate k."""
    own = angles_of(rows.winding)
    n = rows.n
    names = _names(rows, 0)
    moved = ""
    body = ""
    for k, r in enumerate(own.wound):
        moved += f"{_at(own.step(k))} = (z{r} - {names[r]})*turns{r}\n"
    for k, r in enumerate(own.planes):
        at = own.plane(k)
        q, p, a, b, c, cosine, sine, _ = (_at(at + column) for column in range(COLUMNS.end))
        last = _at(at + COLUMNS.end)
        other = _at(at + COLUMNS.end + 1)
        body += _loop(
            f"x = {_at(r)} - {q}\nre, im = {a}*x, {b}*x + {c}*({_at(n + r)} - {p})\nx, y = re*{last} + im*{other}, "
            f"im*{last} - re*{other}\n{_at(own.step(len(own.wound) + k))} = angle_of(x*{cosine} + y*{sine}, y*{cosine} "
            f"- x*{sine})\n{last} = re\n{other} = im\n",
            0,
        )
    for s in range(SPANS):
        text = "".join(f"{_at(own.step(k) + 1 + s)} += w*{_at(own.step(k))}\n" for k in range(own.angles))
        body += f"w = drifts[{SPANS}*(before + taken) + {s}]\nif w != 0.0:\n{_loop(text, 1)}"
    return _summed(rows, own.iterates, moved, body)


def _summed(rows: StateRows, count: int, moved: str, body: str) -> str:
    """Text of iterates, with the body after each; ends early like those of `map_texts`, after the sums of the iterate
    with which an orbit ends.
    """
    image = _image(rows).split("\n", 1)
    iterate = _read(rows, 0) + f"{image[0]}\n{moved}{image[1]}" + _stored(rows, 0, "z")
    iterate += _counted(rows)
    return (
        _indent(_periods(rows), 1)
        + f"    taken = 0\n    before = int(z[{count * LANES}])\n    while taken < steps:\n        outside = 0\n"
        + _loop(iterate, 2)
        + _indent(body, 2)
        + "        taken += 1\n        if outside > 0:\n            break\n"
        + _loop(f"{_at(count)} = before + taken\n", 1)
        + "    return taken\n"
    )


TEXTS = {"moments": moments, "angles": angles}
