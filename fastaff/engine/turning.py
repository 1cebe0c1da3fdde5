"""A rotating frame: after each drift the first two coordinates and their momenta are rotated.

By H = T(p) - Omega (x p_y - y p_x) both rotate by -Omega t. A kinetic energy isotropic in them drives the drift: the
two flows commute, so drift and rotation together are exact, and a splitting keeps its order, also if that requires a
quadratic T. A rotation is three shears; those of the momenta are the transposed inverses of those of the coordinates:
symplectic to the last digit with any rounding of the shears, and exact beside the increments of a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .fused import SHIFT, fma
from .jit import LANES
from .terms import Rows, Substep, Term

PI_HIGH = 3.141592653589793
"""The first part of pi."""

PI_LOW = 1.2246467991473532e-16
"""The second part of pi."""


def turn(rate, length):
    """Return tan(r/2), sin(r) and 1 or 0: the angle rate*length is r, at most a right angle, plus an odd (1) or even
    (0) number of half turns.

    Without branches; the Taylor series of sine and cosine up to pi/4 have errors of 1e-16.
    """
    angle = rate * length
    turns = fma(angle, 1.0 / math.pi, SHIFT) - SHIFT
    odd = fma(-2.0, fma(0.5, turns, SHIFT) - SHIFT, turns)
    x = 0.5 * fma(-turns, PI_LOW, fma(-turns, PI_HIGH, angle))
    w = x * x
    s = fma(-1.0 / 1307674368000.0, w, 1.0 / 6227020800.0)
    s = fma(s, w, -1.0 / 39916800.0)
    s = fma(s, w, 1.0 / 362880.0)
    s = fma(s, w, -1.0 / 5040.0)
    s = fma(s, w, 1.0 / 120.0)
    s = fma(s, w, -1.0 / 6.0)
    c = fma(1.0 / 20922789888000.0, w, -1.0 / 87178291200.0)
    c = fma(c, w, 1.0 / 479001600.0)
    c = fma(c, w, -1.0 / 3628800.0)
    c = fma(c, w, 1.0 / 40320.0)
    c = fma(c, w, -1.0 / 720.0)
    c = fma(c, w, 1.0 / 24.0)
    sine = fma(x * w, s, x)
    cosine = fma(w, fma(w, c, -0.5), 1.0)
    return sine / cosine, 2.0 * sine * cosine, 1.0 if odd * odd > 0.5 else 0.0


def flipped(part: Sequence[int], n: int, first: int | None) -> str:
    """Text that turns two rows and their momenta, n rows further, by half a turn in lanes whose drift turns by an odd
    number of half turns.
    """
    text = ""
    for r in part[:2]:
        if first is None:
            text += f"q{r} = -q{r}\np{r} = -p{r}\n"
            continue
        for row in (r, n + r):
            state = f"z[{row * LANES} + i]"
            moved = f"z[{(first + row) * LANES} + i]"
            after = f"-{moved} - ({state} + {state})" if first else f"-{moved}"
            text += f"{moved} = {after} if odds[i] > 0.0 else {moved}\n"
    return text


def rotated(part: Sequence[int], q: str, p: str, base: Mapping[str, str]) -> str:
    """Text that rotates two coordinates and their momenta."""
    x, y = part[:2]
    qx, qy, px, py = (base.get(name, "") for name in (f"q{x}", f"q{y}", f"p{x}", f"p{y}"))
    there = f"{q}{x} = fma(tangent, {qy}{q}{y}, {q}{x})\n"
    across = f"{q}{y} = fma(-sine, {qx}{q}{x}, {q}{y})\n"
    back = f"{p}{y} = fma(-tangent, {px}{p}{x}, {p}{y})\n"
    over = f"{p}{x} = fma(sine, {py}{p}{y}, {p}{x})\n"
    return there + across + there + back + over + back


def turned(letter: str, by: str) -> Callable[[Sequence[int]], str]:
    """Return the text that adds the slopes of two rows by the rotation."""

    def text(part: Sequence[int]) -> str:
        x, y = part[:2]
        return f"{letter}{x}, {letter}{y} = {letter}{x} + rate*{by}{y}, {letter}{y} - rate*{by}{x}\n"

    return text


def in_frame(values: Mapping[str, Any], mass: Any, q: Rows) -> tuple[Any, Any]:
    """Return the rate of a rotation and a magnetic field, in the symmetric gauge, and the field's addition to V."""
    rate = values.get("rotation", 0) + values.get("magnetic", 0) / (2 * mass)
    field = values.get("magnetic")
    return rate, 0 if field is None else field**2 / (8 * mass) * sum(x**2 for x in q[:2])


FRAME = Term(
    does="the frame of the first two coordinates turns: angular_velocity()",
    equations="H = T(p) + V(q) in a rotating frame or a uniform magnetic field",
    rate="angular_velocity",
    has="turns",
    velocities=turned("v", "q"),
    forces=turned("f", "p"),
    energy="rate*(q1*p0 - q0*p1)",
    substep=Substep("drift", turn, ("tangent", "sine", "odd"), rotated, flipped),
    options=("rotation", "magnetic"),
    options_rate=in_frame,
    planar=True,
)
