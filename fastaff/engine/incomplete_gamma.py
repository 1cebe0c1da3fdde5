"""The regularised lower incomplete gamma function without branches or tables, like the functions of `elementary`."""

from __future__ import annotations

import numpy as np

from .elementary import OPTIONS, exp, power
from .elementary import _part as part
from .fused import fma
from .numba_private import overload


def _eight_terms(a, x, n, s):
    """Return a sum 1 + x/(a+n) (1 + x/(a+n+1) (...)) of eight terms, the last times s."""
    s = fma(x * (1.0 / (a + (n + 7.0))), s, 1.0)
    s = fma(x * (1.0 / (a + (n + 6.0))), s, 1.0)
    s = fma(x * (1.0 / (a + (n + 5.0))), s, 1.0)
    s = fma(x * (1.0 / (a + (n + 4.0))), s, 1.0)
    s = fma(x * (1.0 / (a + (n + 3.0))), s, 1.0)
    s = fma(x * (1.0 / (a + (n + 2.0))), s, 1.0)
    s = fma(x * (1.0 / (a + (n + 1.0))), s, 1.0)
    return fma(x * (1.0 / (a + n)), s, 1.0)


def _four_levels(a, x, n, p, q):
    """Return numerator and denominator of four levels of Legendre's continued fraction, from level n + 3 to n."""
    p, q = fma(x + (2.0 * n + 7.0 - a), p, -((n + 4.0) * (n + 4.0 - a)) * q), p
    p, q = fma(x + (2.0 * n + 5.0 - a), p, -((n + 3.0) * (n + 3.0 - a)) * q), p
    p, q = fma(x + (2.0 * n + 3.0 - a), p, -((n + 2.0) * (n + 2.0 - a)) * q), p
    return fma(x + (2.0 * n + 1.0 - a), p, -((n + 1.0) * (n + 1.0 - a)) * q), p


def _gammainc(a, x, front):
    """Return P(a, x): the series of positive terms below 8, 1 less the continued fraction of Q beyond.

    Source: DLMF 8.7.1 and 8.9.2 in its even part. Error: 8 units in the last place for 0 < a <= 4.
    """
    near = x < 8.0
    far = 750.0 if x > 750.0 else x  # where e^-x is 0
    low, high = (far, 8.0) if near else (8.0, far)
    s = _terms_part(a, low, 33.0, _terms_part(a, low, 41.0, 1.0))
    s = _terms_part(a, low, 1.0, _terms_part(a, low, 9.0, _terms_part(a, low, 17.0, _terms_part(a, low, 25.0, s))))
    p, q = _levels_part(a, high, 8.0, high + (25.0 - a), 1.0)
    p, q = _levels_part(a, high, 4.0, p, q)
    p, q = _levels_part(a, high, 0.0, p, q)
    weight = front * power(far, a) * exp(-far)
    value = weight * s if near else 1.0 - weight * a * (q / p)
    return value if x >= 0.0 else np.nan


_terms_part, _levels_part = map(part, (_eight_terms, _four_levels))


def gammainc(a, x, front):
    """Return the regularised lower incomplete gamma function P(a, x), x >= 0, 0 < a <= 4; front: 1/gamma(a + 1)."""
    from scipy.special import gammainc

    return gammainc(a, x)


@overload(gammainc, jit_options=OPTIONS)
def _chosen_gammainc(a, x, front):
    callee = part(_gammainc)
    return lambda a, x, front: callee(a, x, front)
