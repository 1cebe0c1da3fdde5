"""gammainc(a, x) of formulas, P(a, x) = 1/gamma(a) int_0^x t^(a-1) e^-t dt, in each arithmetic of formulas."""

from __future__ import annotations

import functools
from typing import Any

GAMMAINC = "gammainc"
"""The only function of two arguments; the first is a number."""

MOST_A = 4
"""Largest first argument of gammainc for which `engine.incomplete_gamma` is accurate."""

CERTAIN = 2.4
"""Slightly more than log(10): e^-x is below 10^-digits for x beyond this times the digits."""


def incomplete_gamma(a: Any, x: Any) -> Any:
    """Return P(a, x), the regularised lower incomplete gamma function, of floats and arrays, or of mpmath's numbers."""
    for number in (a, x):
        if hasattr(number, "context"):
            return _by_series(number.context, a, x)
    from scipy.special import gammainc

    return gammainc(float(a), x)


def _by_series(mp: Any, a: Any, x: Any) -> Any:
    """Return P(a, x) of mpmath's numbers: x^a e^-x times a sum of positive terms, over gamma(a).

    mpmath tries an asymptotic series first, which takes minutes for some x at hundreds of digits.
    """
    if not x > 0:
        return mp.gammainc(a, 0, x, regularized=True)
    if x > CERTAIN * mp.dps + 60:  # the rest of the integral is below the last digit, for a up to MOST_A
        return mp.mpf(1)
    with mp.extradps(10):
        term = total = 1 / mp.mpf(a)
        n = 0
        while term > total * mp.eps:
            n += 1
            term *= x / (a + n)
            total += term
        result = mp.power(x, a) * mp.exp(-x) * total / mp.gamma(a)
    return +result


@functools.cache
def gammainc() -> Any:
    """Return SymPy's class of gammainc(a, x): its own lowergamma becomes other functions for some a."""
    import mpmath
    import sympy

    class Gammainc(sympy.Function):
        nargs = 2
        is_real = True

        def fdiff(self, argindex: int = 1) -> Any:
            a, x = self.args
            if argindex != 2:
                raise sympy.core.function.ArgumentIndexError(self, argindex)
            return x ** (a - 1) * sympy.exp(-x) / sympy.gamma(a)

        def _eval_evalf(self, prec: int) -> Any:
            with mpmath.workprec(prec + 10):
                a, x = (entry._to_mpmath(prec + 10) for entry in self.args)
                return sympy.Float._new(incomplete_gamma(a, x)._mpf_, prec)

    Gammainc.__name__ = GAMMAINC
    return Gammainc


def numeric(kind: str) -> list[Any]:
    """Return the modules of lambdify for "numpy", "mpmath" or "math"."""
    return [{GAMMAINC: incomplete_gamma}, kind]
