"""Friction in proportion to the momenta: kicks solve dp/dt = F - g p exactly.

p goes to p + G(h) (F - g p) with G(h) = (1 - exp(-g h))/g, the length of the kick h as friction shortens it: each
momentum's volume shrinks by exp(-g h), so that a splitting is conformally symplectic. It keeps its order, unless that
requires forces that depend on the coordinates alone.
"""

from __future__ import annotations

from .terms import Substep, Term


def shortened(rate, length):
    """Return the tuple of (1 - exp(-rate length))/rate, without branches; of length where the rate is 0.

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
    return (length * s,)


FRICTION = Term(
    does="momenta are damped in proportion to themselves: damping_rate()",
    equations="H = T(p) + V(q) with a friction in proportion to the momenta",
    rate="damping_rate",
    has="has friction",
    forces=lambda part: "".join(f"f{r} = f{r} - rate*p{r}\n" for r in part),
    substep=Substep("kick", shortened, ("length",), lambda r, part, p: f"fma(length, f{r}, {p})"),
    words=frozenset({"loss"}),
    options=("friction",),
)
