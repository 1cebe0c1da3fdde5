"""The loop of an orbit in a plane (q, p), and the angle of a step on it: for texts and kernels."""

from __future__ import annotations

import math
from typing import NamedTuple

from .jit import jit

SPANS = 6
"""Number of windows over which angles are averaged, and of the weights of an iterate."""

MOMENTS = 9
"""Number of weighted sums of a plane: of q, p; qq, qp, pp; and of products with the next q', p': q'q, q'p, p'q, p'p."""


class PlaneColumns(NamedTuple):
    """Columns of a plane's loop: its centre; a, b, c of (a + i b)(q - centre) + i c (p - centre), 0 for a plane at
    rest; cosine, sine and turns of the reference.
    """

    q: int = 0
    p: int = 1
    a: int = 2
    b: int = 3
    c: int = 4
    cosine: int = 5
    sine: int = 6
    turn: int = 7
    end: int = 8


COLUMNS = PlaneColumns()


@jit
def angle_of(x, y):
    """Return the argument of x + i y to 3e-16, 0 at the origin, without branches: loops over it become vector
    instructions.

    atan u/u is a polynomial in u^2 on |u| <= tan(pi/8), to 5e-20; above, pi/4 is subtracted.
    """
    wide = abs(x)
    high = abs(y)
    steep = high > wide
    big = high if steep else wide
    small = wide if steep else high
    beyond = small > 0.41421356237309503 * big
    top = small - big if beyond else small
    bottom = small + big if beyond else big
    u = top / (bottom if bottom != 0.0 else 1.0)
    w = u * u
    p = 0.015113765096600920006
    p = p * w - 0.033387824501211946912
    p = p * w + 0.044995007289840318104
    p = p * w - 0.052173125740615909524
    p = p * w + 0.058768340046141606564
    p = p * w - 0.066662052599765261871
    p = p * w + 0.0769228109993774325
    p = p * w - 0.090909080590311910269
    p = p * w + 0.11111111085322108759
    p = p * w - 0.14285714285329708164
    p = p * w + 0.19999999999997013892
    p = p * w - 0.33333333333333324206
    angle = (u + u * w * p) + (0.25 * math.pi if beyond else 0.0)
    angle = 0.5 * math.pi - angle if steep else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle
