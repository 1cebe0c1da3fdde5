"""Texts of drifts in a turning frame: after each drift the first two coordinates and their momenta are rotated.

By H = T(p) - Omega (x p_y - y p_x) both rotate by -Omega t while a kinetic energy that is isotropic in them drives the
drift: the two flows commute, so drift and rotation together are exact, and a splitting keeps its order, also where that
needs T quadratic. A rotation is three shears, those of the momenta the transposed inverses of those of the coordinates:
symplectic to the last digit, whatever the shears round to, and exact beside the increments of a step.

Tangents and sines of all drifts of a step are kept in rows behind the state, with the step that they were made for:
zeros are those of the step 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from .fused import SHIFT, fma
from .jit import LANES

PI_HIGH, PI_LOW = 3.141592653589793, 1.2246467991473532e-16
"""pi in two parts."""

OWN = 2
"""Rows of the rotations of a block: the step, how many drifts turn by an odd number of half turns and then, for each
drift of the first half, tangent, sine, and whether it is such a one: splittings are palindromic.
"""


def spare_rows(drifts: int) -> int:
    """Return the rows that the rotations of so many drifts need."""
    return OWN + 3 * ((drifts + 1) // 2)


def turn(angle):
    """Return tan(r/2), sin(r) and 1 or 0: the angle is r, at most a right angle, more than an odd number of half turns,
    or an even one.

    Without branches; Taylor series of sine and cosine of at most pi/4 leave 1e-16.
    """
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
    sine, cosine = fma(x * w, s, x), fma(w, fma(w, c, -0.5), 1.0)
    return sine / cosine, 2.0 * sine * cosine, 1.0 if odd * odd > 0.5 else 0.0


def made(first: int, lanes: str, drifts: str, step: str) -> str:
    """Text that makes the rotations, rows from `first` on, where the step of a lane is another than before."""
    own, flips = f"z[{first * LANES} + i]", f"z[{(first + 1) * LANES} + i]"

    def loop(body: str, depth: int) -> str:
        return _indented(f"for i in range({lanes}):\n" + _indented(body, 1), depth)

    return (
        "    stale, beyond = 0, 0.0\n"
        + loop(f"stale += 0 if {own} == {step} else 1\nbeyond += {flips}\n", 1)
        + "    if stale > 0:\n        omega, beyond = value.angular_velocity(), 0.0\n"
        + loop(f"{own} = {step}\n{flips} = 0.0\n", 2)
        + f"        for s in range(({drifts}.size + 1)//2):\n"
        + f"            row = {(first + OWN) * LANES} + {3 * LANES}*s\n"
        + loop(
            f"tangent, sine, odd = turn(omega*({drifts}[s]*{step}))\n"
            f"z[row + i] = tangent\nz[row + {LANES} + i] = sine\nz[row + {2 * LANES} + i] = odd\n{flips} += odd\n",
            3,
        )
        + loop(f"beyond += {flips}\n", 2)
    )


def of_drift(first: int, drift: str, kicks: str) -> str:
    """Text that takes the rotation of a drift in hand: that of its mirror image, for those behind half.

    As arrays of their own: loops over rows at distances that are not constant would be no loops of vectors.
    """
    return (
        f"row = {(first + OWN) * LANES} + {3 * LANES}*min({drift}, {kicks}.size - {drift})\n"
        f"tangents, sines = z[row : row + {LANES}], z[row + {LANES} : row + {2 * LANES}]\n"
        f"odds = z[row + {2 * LANES} : row + {3 * LANES}]\n"
    )


def flipped(x: int, y: int, n: int, first: int) -> str:
    """Text that turns two rows and their momenta, n rows further, by half a turn where a drift turns by an odd number
    of them: of the state, or of its increments, which begin at row `first`.
    """
    text = "odd = odds[i]\n"
    for r in (x, y, n + x, n + y):
        state, moved = f"z[{r * LANES} + i]", f"z[{(first + r) * LANES} + i]"
        after = f"-{moved} - ({state} + {state})" if first else f"-{moved}"
        text += f"{moved} = {after} if odd > 0.0 else {moved}\n"
    return text


ROTATION = "tangent, sine = tangents[i], sines[i]\n"
"""Text of the numbers of the rotation at hand."""


def rotated(x: int, y: int, names: tuple[str, str], base: Sequence[str] = ("", "", "", "")) -> str:
    """Text that rotates two coordinates and their momenta in variables of those names; where these are
    increments, `base` says what they are added to.
    """
    q, p = names
    qx, qy, px, py = base
    there, across = f"{q}{x} = fma(tangent, {qy}{q}{y}, {q}{x})\n", f"{q}{y} = fma(-sine, {qx}{q}{x}, {q}{y})\n"
    back, over = f"{p}{y} = fma(-tangent, {px}{p}{x}, {p}{y})\n", f"{p}{x} = fma(sine, {py}{p}{y}, {p}{x})\n"
    return there + across + there + back + over + back


def rates(x: int, y: int) -> str:
    """Text that adds what the turning frame makes of velocities v and forces f, of coordinates q and momenta p."""
    return (
        f"omega = value.angular_velocity()\nv{x}, v{y} = v{x} + omega*q{y}, v{y} - omega*q{x}\n"
        f"f{x}, f{y} = f{x} + omega*p{y}, f{y} - omega*p{x}\n"
    )


def _indented(text: str, depth: int) -> str:
    return "".join(f"{' ' * 4 * depth}{line}\n" for line in text.splitlines())
