"""Texts of block functions of maps: loops over lanes around the scalar methods `iterate` and `tangent_iterate`.

State blocks are those of `texts`. In a map of one variable the row of the momentum is idle. A row that has a period is
reduced to half a period around 0 after each iterate, so that sines of winding angles lose no digits.
"""

from __future__ import annotations

from collections.abc import Callable

from ..core.status import LOST_CODE
from .jit import LANES
from .state_rows import StateRows, listed
from .texts import _at, _indent, _loop, of_orbit


def _names(rows: StateRows, vector: int) -> list[str]:
    """Return the names of the numbers of the orbit (0), q0, ..., p0, ..., or of a tangent vector."""
    first = range(vector * rows.n, (vector + 1) * rows.n)
    return [*(f"q{r}" for r in first), *(f"p{r}" for r in first)][: len(rows.winding)]


def _places(rows: StateRows, vector: int) -> list[int]:
    """Return the rows of these numbers."""
    first = range(vector * rows.n, (vector + 1) * rows.n)
    return [*first, *(rows.half + r for r in first)][: len(rows.winding)]


def _periods(rows: StateRows) -> str:
    """Text that reads the periods."""
    wound = [r for r, winds in enumerate(rows.winding) if winds]
    text = "periods = value.periods()\n" if wound else ""
    return text + "".join(f"period{r}, turns{r} = periods[{r}], 1.0/periods[{r}]\n" for r in wound)


def _image(rows: StateRows) -> str:
    """Text that sets z0, z1, ... to the image of the orbit."""
    text = f"{listed('z', range(len(rows.winding)))}, = value.iterate({', '.join(_names(rows, 0))})\n"
    wound = [r for r, winds in enumerate(rows.winding) if winds]
    return text + "".join(f"z{r} -= period{r}*np.rint(z{r}*turns{r})\n" for r in wound)


def _vector_image(rows: StateRows, vector: int) -> str:
    """Text that sets w0, w1, ... to the image of a tangent vector."""
    given = ", ".join(_names(rows, 0) + _names(rows, vector))
    return f"{listed('w', range(len(rows.winding)))}, = value.tangent_iterate({given})\n"


def _read(rows: StateRows, vector: int) -> str:
    return "".join(f"{name} = {_at(r)}\n" for name, r in zip(_names(rows, vector), _places(rows, vector), strict=True))


def _counted(rows: StateRows) -> str:
    """Text that counts a lane as outside if its image has left the domain or has momenta that are not finite;
    coordinates that are not finite have no positive margin.
    """
    q = listed("z", range(rows.n))
    p = "".join(f" + 0.0*z{r}" for r in range(rows.n, len(rows.winding)))
    return f"outside += 0 if value.margin({q}){p} > 0.0 else 1\n"


def _stored(rows: StateRows, vector: int, letter: str) -> str:
    return "".join(f"{_at(r)} = {letter}{k}\n" for k, r in enumerate(_places(rows, vector)))


def _iterates(rows: StateRows) -> str:
    """Iterates, up to the one with which an orbit ends; returns their number.

    Vectors move before the orbit, by the derivative at its old point.
    """
    loops = ""
    for group in reversed(rows.groups):
        body = _read(rows, 0)
        for vector in [part.start // rows.n for part in rows.parts(group) if part.start]:
            body += _read(rows, vector) + _vector_image(rows, vector) + _stored(rows, vector, "w")
        if group.start == 0:
            body += _image(rows) + _stored(rows, 0, "z")
            body += _counted(rows)
        loops += _loop(body, 2)
    return (
        _indent(_periods(rows), 1)
        + f"    taken = 0\n    while taken < steps:\n        outside = 0\n{loops}"
        + "        taken += 1\n        if outside > 0:\n            break\n    return taken\n"
    )


def _march(rows: StateRows) -> str:
    """Iterates of lane 0 with its state in scalars, and the bits of `splitting`: for a single orbit."""
    every = [(name, r) for v in range(1 + rows.vectors) for name, r in zip(_names(rows, v), _places(rows, v))]
    body = ""
    for vector in range(1, 1 + rows.vectors):
        body += _vector_image(rows, vector)
        body += "".join(f"{name} = w{k}\n" for k, name in enumerate(_names(rows, vector)))
    body += _image(rows) + "".join(f"{name} = z{k}\n" for k, name in enumerate(_names(rows, 0)))
    body += f"taken += 1\noutside = 0\n{_counted(rows)}if outside > 0:\n    break\n"
    return (
        _indent(_periods(rows) + "".join(f"{name} = z[{r * LANES}]\n" for name, r in every), 1)
        + "    taken = 0\n    while taken < steps:\n"
        + _indent(body, 2)
        + _indent("".join(f"z[{r * LANES}] = {name}\n" for name, r in every), 1)
        + "    return taken\n"
    )


def _inside(rows: StateRows) -> str:
    """Whether the orbit is finite and in the domain."""
    z = of_orbit(rows.n)
    return _loop(
        f"margin = value.margin({', '.join(z[: rows.n])})\nfinite = {' + '.join(f'0.0*{row}' for row in z)}\ncode = "
        f"0.0 if margin > 0.0 else {LOST_CODE}.0\nresult[i] = code if finite == 0.0 else 1.0\n",
        1,
    )


def _observable(rows: StateRows) -> str:
    """A smooth function of phase points, which replaces the kinetic energy in indicators of maps: of cosines of angles,
    without their momenta, which may grow for ever.
    """
    n = rows.n
    terms = []
    for k, r in enumerate(_places(rows, 0)):
        if rows.winding[k]:
            terms.append(f"np.cos(6.283185307179586*turns{k}*{_at(r)})")
        elif not rows.winding[k % n]:
            terms.append(_at(r))
    return _indent(_periods(rows), 1) + _loop(f"result[i] = {' + '.join(terms)}\n", 1)


TEXTS: dict[str, Callable[[StateRows], str]] = {
    "splitting": _iterates,
    "march": _march,
    "check": _inside,
    "inside": _inside,
    "kinetic": _observable,
}
