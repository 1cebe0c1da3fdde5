"""Lattices as maps of one turn: linear parts and thin multipoles, written as statements of `fastaff.iterated_map`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import zip_longest
from math import factorial
from typing import NamedTuple

import numpy as np

ROWS = ("x", "y", "px", "py")


class Kick(NamedTuple):
    """A thin multipole: integrated strengths knl and ksl, of x' - i y' as the series in (x + iy)^n/n!."""

    knl: tuple[float, ...]
    ksl: tuple[float, ...]

    def moved(self, x: float, y: float, angle: float) -> Kick:
        """Return the kick of the multipole with its axis at (x, y), turned by an angle from x to y."""
        own = [complex(*pair) for pair in zip_longest(*self, fillvalue=0.0)]
        turn = np.exp(-1j * angle)
        place = -np.exp(-1j * angle) * complex(x, y)
        made = [
            turn ** (n + 1) * sum(c * place**k / factorial(k) for k, c in enumerate(own[n:])) for n in range(len(own))
        ]
        return Kick(tuple(entry.real for entry in made), tuple(entry.imag for entry in made))

    def images(self, points: np.ndarray) -> np.ndarray:
        """Return the images of points (4, count)."""
        place = points[0] + 1j * points[1]
        momentum = points[2] - 1j * points[3]
        strengths = enumerate(zip_longest(*self, fillvalue=0.0))
        momentum = momentum - sum(complex(*pair) * place**n / factorial(n) for n, pair in strengths)
        return np.array([*points[:2], momentum.real, -momentum.imag])


def turn(parts: Iterable[Kick | tuple[np.ndarray, ...]]) -> str:
    """Return the text of a map, neighbouring linear parts as one."""
    lines: list[str] = []
    matrix = np.eye(4)
    shift = np.zeros(4)
    names = list(ROWS)
    count = 0
    for part in parts:
        if not isinstance(part, Kick):
            matrix = part[0] @ matrix
            shift = part[0] @ shift + part[1]
            continue
        names = _linear(lines, matrix, shift, names, f"_{count}_")
        lines += _kicked(part, names, f"_{count}_")
        names = [*names[:2], f"k_{count}_", f"l_{count}_"]
        matrix = np.eye(4)
        shift = np.zeros(4)
        count = count + 1
    _linear(lines, matrix, shift, names, "1")
    return "\n".join(lines)


def _linear(lines: list[str], matrix: np.ndarray, shift: np.ndarray, names: Sequence[str], end: str) -> list[str]:
    """Add the statements of a matrix; return the names of its images."""
    for name, row, off in zip(ROWS, matrix, shift, strict=True):
        terms = [f"({float(entry)!r})*{old}" for entry, old in zip(row, names, strict=True) if entry]
        lines.append(f"{name}{end} = {' + '.join([*terms, f'({float(off)!r})'] if off else terms)}")
    return [name + end for name in ROWS]


def _kicked(kick: Kick, names: Sequence[str], end: str) -> list[str]:
    """Return the statements of a kick: real and imaginary part of its series by Horner's rule."""
    x, y, px, py = names
    orders = max(len(kick.knl), len(kick.ksl))
    knl, ksl = (np.pad(np.asarray(entry, float), (0, orders - len(entry))) for entry in kick)
    top = orders - 1
    lines = []
    real = repr(float(knl[top]))
    imaginary = repr(float(ksl[top]))
    for n in reversed(range(top)):
        a = f"a{n}{end}"
        b = f"b{n}{end}"
        share = float(n + 1)
        lines.append(f"{a} = ({float(knl[n])!r}) + (({real})*{x} - ({imaginary})*{y})/{share!r}")
        lines.append(f"{b} = ({float(ksl[n])!r}) + (({real})*{y} + ({imaginary})*{x})/{share!r}")
        real = a
        imaginary = b
    return [*lines, f"k{end} = {px} - ({real})", f"l{end} = {py} + ({imaginary})"]
