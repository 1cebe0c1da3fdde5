"""Texts of kicks with a friction in proportion to the momenta: dp/dt = F - g p is solved exactly.

p goes to p + G(h) (F - g p) with G(h) = (1 - exp(-g h))/g, the length of the kick h as friction shortens it: each
momentum's volume shrinks by exp(-g h), so that a splitting is conformally symplectic. It keeps its order, but for those
whose order needs forces of the coordinates alone.

The lengths of all kicks of a step are kept in rows behind the state, with the step that they were made for: zeros are
those of the step 0.
"""

from __future__ import annotations

from collections.abc import Iterable

from .jit import LANES


def spare_rows(kicks: int) -> int:
    """Return the rows that the lengths of so many kicks need: the step, and those of the first half of the kicks, as
    splittings are palindromic.
    """
    return 1 + (kicks + 1) // 2


def shortened(rate, length):
    """Return (1 - exp(-rate length))/rate, without branches; length where the rate is 0.

    s = (exp(y) - 1)/y by Taylor's series at y = -rate length/2^6, then s(2 y) = s(y) (1 + y s(y)/2) six times: to
    rounding for |rate length| below 16.
    """
    y = -rate * length * 0.015625
    s = 1.0 / 6227020800.0
    s = s * y + 1.0 / 479001600.0
    s = s * y + 1.0 / 39916800.0
    s = s * y + 1.0 / 3628800.0
    s = s * y + 1.0 / 362880.0
    s = s * y + 1.0 / 40320.0
    s = s * y + 1.0 / 5040.0
    s = s * y + 1.0 / 720.0
    s = s * y + 1.0 / 120.0
    s = s * y + 1.0 / 24.0
    s = s * y + 1.0 / 6.0
    s = s * y + 0.5
    s = s * y + 1.0
    s = s * (1.0 + 0.5 * y * s)
    s = s * (1.0 + y * s)
    s = s * (1.0 + 2.0 * y * s)
    s = s * (1.0 + 4.0 * y * s)
    s = s * (1.0 + 8.0 * y * s)
    s = s * (1.0 + 16.0 * y * s)
    return length * s


def made(first: int, lanes: str, kicks: str, step: str) -> str:
    """Text that makes the lengths of kicks, rows from `first` on, where the step of a lane is another than before."""
    own = f"z[{first * LANES} + i]"
    return (
        f"    stale = 0\n    for i in range({lanes}):\n        stale += 0 if {own} == {step} else 1\n"
        f"    if stale > 0:\n        for i in range({lanes}):\n            {own} = {step}\n"
        f"        for s in range(({kicks}.size + 1)//2):\n            row = {(first + 1) * LANES} + {LANES}*s\n"
        f"            for i in range({lanes}):\n"
        f"                z[row + i] = shortened(value.damping_rate(), {kicks}[s]*{step})\n"
    )


def of_kick(first: int, kicks: str) -> str:
    """Text that takes the lengths of kick s in hand: those of its mirror image, behind half."""
    row = f"{(first + 1) * LANES} + {LANES}*min(s, {kicks}.size - 1 - s)"
    return f"row = {row}\nlengths = z[row : row + {LANES}]\n"


def drag(rows: Iterable[int]) -> str:
    """Text that takes the friction from the forces f of rows."""
    return "".join(f"f{r} = f{r} - value.damping_rate()*p{r}\n" for r in rows)
