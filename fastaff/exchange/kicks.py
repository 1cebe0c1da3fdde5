"""Lattices as maps of one turn: linear parts and thin multipoles, written as statements of `fastaff.mapping`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

J = np.kron(np.array([[0.0, 1.0], [-1.0, 0.0]]), np.eye(2))
ROWS = ("x", "y", "px", "py")
SMALL, LARGE, LINEAR = 1e-5, 1e-3, 1e-9
"""Amplitudes at which an element is asked for its matrix, and tried; how well the matrix must be its image."""


class Kick(NamedTuple):
    """A thin multipole: integrated strengths knl and ksl, of x' - i y' as the series in (x + iy)^n/n!."""

    knl: tuple[float, ...]
    ksl: tuple[float, ...]


def probed(track: Callable[[np.ndarray], np.ndarray], name: str, kind: str, linear: bool) -> tuple[np.ndarray, ...]:
    """Return the matrix (4, 4) and shift (4,) of an element, of its images of points (4, count) in ROWS' order; linear:
    whether that is taken where it is no more than the element's linear part.

    Raises ValueError naming the element otherwise.
    """
    size = SMALL if linear else LARGE
    points = size * np.concatenate([np.eye(4), -np.eye(4), np.zeros((4, 1)), [[0.7], [-0.4], [0.3], [0.8]]], axis=1)
    images = np.asarray(track(points.copy()), dtype=float)
    if not np.isfinite(images).all():
        raise ValueError(f"the element {name!r} ({kind}) loses particles at {size:g}: it is no part of a map")
    shift, matrix = images[:, 8], (images[:, :4] - images[:, 4:8]) / (2 * size)
    if not linear and np.abs(matrix @ points[:, 9] + shift - images[:, 9]).max() > LINEAR * size:
        raise ValueError(
            f"the element {name!r} ({kind}) is neither linear nor a thin multipole: cut it into thin kicks first "
            "(xtrack: line.slice_thick_elements)"
        )
    for _ in range(2):  # to rounding symplectic, as differences of images are not
        matrix = matrix @ (np.eye(4) + J @ (matrix.T @ J @ matrix - J) / 2)
    return matrix, shift


def turn(parts: Iterable[Kick | tuple[np.ndarray, ...]]) -> str:
    """Return the text of a map, neighbouring linear parts as one."""
    lines: list[str] = []
    matrix, shift, names, count = np.eye(4), np.zeros(4), list(ROWS), 0
    for part in parts:
        if not isinstance(part, Kick):
            matrix, shift = part[0] @ matrix, part[0] @ shift + part[1]
            continue
        names = _linear(lines, matrix, shift, names, f"_{count}_")
        lines += _kicked(part, names, f"_{count}_")
        names = [*names[:2], f"k_{count}_", f"l_{count}_"]
        matrix, shift, count = np.eye(4), np.zeros(4), count + 1
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
    lines, real, imaginary = [], repr(float(knl[top])), repr(float(ksl[top]))
    for n in reversed(range(top)):
        a, b, share = f"a{n}{end}", f"b{n}{end}", float(n + 1)
        lines.append(f"{a} = ({float(knl[n])!r}) + (({real})*{x} - ({imaginary})*{y})/{share!r}")
        lines.append(f"{b} = ({float(ksl[n])!r}) + (({real})*{y} + ({imaginary})*{x})/{share!r}")
        real, imaginary = a, b
    return [*lines, f"k{end} = {px} - ({real})", f"l{end} = {py} + ({imaginary})"]


def strengths(coefficients: Sequence[float]) -> tuple[float, ...]:
    """Return knl of coefficients of the plain powers (x + iy)^n."""
    return tuple(float(entry) * math.factorial(n) for n, entry in enumerate(coefficients))
