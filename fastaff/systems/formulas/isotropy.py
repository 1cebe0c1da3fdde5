"""From the variables of the body to A = alpha^2, B = beta^2, with SymPy.

All variables are rational in p = (D1 + D2)/2 and q = (D1 - D2)/2: D1, D2 = p +- q, A = 2 p^2, B = 2 q^2, r = 2 (p^2 +
q^2). A potential is even in q (checked before); here algebra writes it with even powers only, if it can: term by term,
so that its structure stays.
"""

from __future__ import annotations

from math import comb, prod
from typing import Any, NamedTuple

from .grammar import Program
from .sympy_bridge import to_sympy
from .variables import INVARIANTS, MATRIX, PLANES

_LARGEST = 400
"""Number of terms above which a product is not multiplied out."""


class Reduced(NamedTuple):
    """A formula in A, or alpha where it is odd in that, and B, or beta where no algebra was found that removes odd
    powers.

    exact: whether algebra shows that beta -> -beta changes nothing.
    """

    expression: Any
    even_beta: bool
    exact: bool


def symbols() -> dict[str, Any]:
    """Return the symbols of reduction and of the generated source."""
    import sympy

    real = {name: sympy.Symbol(name, real=True) for name in ("q", "a1", "a2", "b1", "b2", "x", "y", "z", "u")}
    positive = {name: sympy.Symbol(name, positive=True) for name in ("p", "A", "alpha")}
    least_zero = {name: sympy.Symbol(name, nonnegative=True) for name in ("B", "beta")}
    return {**real, **positive, **least_zero}


def invariants(s: dict[str, Any]) -> dict[str, Any]:
    """Return D1, ..., rho in p and q; vartheta stays a symbol until `without_angle`."""
    import sympy

    p, q = s["p"], s["q"]
    return {
        "D1": p + q,
        "D2": p - q,
        "alpha": sympy.sqrt(2) * p,
        "beta": sympy.sqrt(2) * q,
        "r": 2 * p**2 + 2 * q**2,
        "rho": sympy.sqrt(2 * p**2 + 2 * q**2),
        "vartheta": sympy.Symbol("vartheta", real=True),
    }


def on_the_axes(s: dict[str, Any]) -> dict[str, Any]:
    """Return the elements of the matrix and of the planes for a = (alpha, 0), b = (beta, 0)."""
    import sympy

    p, q = s["p"], s["q"]
    zero = sympy.Integer(0)
    root = sympy.sqrt(2)
    return {"x": p + q, "u": p - q, "z": zero, "y": zero, "a1": root * p, "a2": zero, "b1": root * q, "b2": zero}


def without_angle(expression: Any, s: dict[str, Any]) -> Any:
    """Replace vartheta: its cosine (p^2 - q^2)/(p^2 + q^2) and sine 2 p q/(p^2 + q^2), else 2 atan(q/p)."""
    import sympy

    v = sympy.Symbol("vartheta", real=True)
    if not expression.has(v):
        return expression
    p = s["p"]
    q = s["q"]
    half = sympy.Symbol("half", real=True)
    square = p**2 + q**2
    known = {
        sympy.cos(v): (p**2 - q**2) / square,
        sympy.sin(v): 2 * p * q / square,
        sympy.tan(v): 2 * p * q / (p**2 - q**2),
        sympy.cos(half): p / sympy.sqrt(square),
        sympy.sin(half): q / sympy.sqrt(square),
        sympy.tan(half): q / p,
    }

    def opened(f: Any) -> Any:
        wide = sympy.expand_trig(f).xreplace(known)
        if wide.has(v):
            wide = sympy.expand_trig(f.xreplace({v: 2 * half})).xreplace(known).xreplace({half: v / 2})
        return wide

    kinds = (sympy.cos, sympy.sin, sympy.tan)
    # cos(n v) and sin(n v) of large n are not expanded, as they would only become longer.
    small = [f for f in expression.atoms(*kinds) if f.has(v) and all(abs(n) <= 8 for n in f.atoms(sympy.Integer))]
    expression = expression.xreplace({f: opened(f) for f in small})
    return expression.xreplace({v: 2 * sympy.atan(q / p)})


def reduce(expression: Any, s: dict[str, Any]) -> Reduced:
    """Return a formula in p and q (and others) in A or alpha and B or beta."""
    import sympy

    root = sympy.sqrt(2)
    even = evened(expression, s["q"])
    exact = even is not None or expression.xreplace({s["q"]: -s["q"]}) == expression
    expression = (
        _squares(even, s["q"], s["B"] / 2) if even is not None else expression.xreplace({s["q"]: s["beta"] / root})
    )
    even_p = evened(expression, s["p"])
    expression = (
        _squares(even_p, s["p"], s["A"] / 2) if even_p is not None else expression.xreplace({s["p"]: s["alpha"] / root})
    )
    return Reduced(expression, even is not None, exact)


def _squares(expression: Any, q: Any, square: Any) -> Any:
    """Replace q^(2k) by square^k."""
    powers = [e for e in expression.atoms(type(q**2)) if e.base == q]
    return expression.xreplace({e: square ** (e.exp / 2) for e in powers})


def turns_prove(program: Program) -> bool:
    """Tell whether a1 dV/da2 = a2 dV/da1, and the same for b, by algebra: rotations of a and b leave V unchanged."""
    import sympy

    names = [*INVARIANTS, *sorted(program.names - {*INVARIANTS, *MATRIX, *PLANES, "pi"})]
    own = {name: sympy.Symbol(name, real=True) for name in (*names, *PLANES)}
    a1, a2, b1, b2 = (own[name] for name in PLANES)
    elements = {"x": a1 + b1, "u": a1 - b1, "z": a2 + b2, "y": b2 - a2}
    V = to_sympy(program, own | {name: e / sympy.sqrt(2) for name, e in elements.items()})
    for one, other in ((a1, a2), (b1, b2)):
        change = one * V.diff(other) - other * V.diff(one)
        if _terms(change) > 20 * _LARGEST or sympy.expand(change) != 0:
            return False
    return True


def is_even(e: Any, q: Any) -> bool:
    """Tell whether q occurs in even integer powers only."""
    if e == q:
        return False
    if e.is_Pow and e.base == q:
        return bool(e.exp.is_Integer and e.exp % 2 == 0)
    return all(is_even(argument, q) for argument in e.args)


def evened(e: Any, q: Any) -> Any:
    """Return an expression equal to e with even powers of q only; None where none was found."""
    if not e.has(q):
        return e
    if is_even(e, q):
        return e
    if e.is_Pow:
        return _evened_power(e, q)
    if e.is_Mul:
        return _evened_product(e, q)
    if e.is_Add:
        return _evened_sum(e, q)
    arguments = [evened(argument, q) for argument in e.args]
    return None if not arguments or None in arguments else e.func(*arguments)


def _evened_power(e: Any, q: Any) -> Any:
    base = evened(e.base, q)
    exponent = evened(e.exp, q)
    if base is not None and exponent is not None:
        return base**exponent
    return _rational(e, q) if e.exp.is_Integer else None


def _evened_product(e: Any, q: Any) -> Any:
    """Factors one by one; then products of factors with the same exponent, such as D1*D2; then the rest together."""
    import sympy

    good, bad = _sorted(e.args, q)
    if not bad:
        return sympy.Mul(*good)
    groups: dict[Any, list[Any]] = {}
    for factor in bad:
        base, exponent = factor.as_base_exp()
        sign = -1 if exponent.could_extract_minus_sign() else 1
        groups.setdefault(sign * exponent, []).append(base if sign > 0 else 1 / base)
    left = []
    for exponent, bases in groups.items():
        together = _rational(sympy.Mul(*bases), q) if len(bases) > 1 else None
        if together is None:
            left += [base**exponent for base in bases]
        else:
            good.append(together**exponent)
    rest = _rational(sympy.Mul(*left), q) if left else sympy.Integer(1)
    return None if rest is None else sympy.Mul(*good, rest)


def _evened_sum(e: Any, q: Any) -> Any:
    """Terms one by one; then logarithms with the same coefficient as one; then the rest over one denominator."""
    import sympy

    good, bad = _sorted(e.args, q)
    if not bad:
        return sympy.Add(*good)
    logarithms: dict[Any, list[Any]] = {}
    rest = []
    for term in bad:
        coefficient, factor = term.as_independent(sympy.log, as_Add=False)
        if isinstance(factor, sympy.log) and not coefficient.has(q):
            logarithms.setdefault(coefficient, []).append(factor.args[0])
        else:
            rest.append(term)
    for coefficient, arguments in logarithms.items():
        product = evened(sympy.Mul(*arguments), q)
        if product is None:
            return None
        good.append(coefficient * sympy.log(product))
    if rest:
        whole = _rational(sympy.Add(*rest), q)
        if whole is None:
            return None
        good.append(whole)
    return sympy.Add(*good)


def _sorted(parts: Any, q: Any) -> tuple[list[Any], list[Any]]:
    good = []
    bad = []
    for part in parts:
        even = evened(part, q)
        if even is None:
            bad.append(part)
        else:
            good.append(even)
    return good, bad


def _rational(e: Any, q: Any) -> Any:
    """Return e as a quotient of polynomials in q^2; None where it is not one, or too large to multiply out."""
    import sympy

    if _terms(e) > _LARGEST or not e.is_rational_function(q):
        return None
    numerator, denominator = sympy.fraction(sympy.together(e))
    if _terms(numerator) * _terms(denominator) > _LARGEST:
        return None
    numerator = sympy.expand(numerator)
    denominator = sympy.expand(denominator)
    if not (is_even(numerator, q) and is_even(denominator, q)):
        if denominator.has(q):
            try:
                numerator, denominator = map(sympy.expand, sympy.fraction(sympy.cancel(numerator / denominator)))
            except sympy.PolynomialError:
                return None
        if not (is_even(numerator, q) and is_even(denominator, q)):
            return None
    return sympy.factor_terms(numerator) / sympy.factor_terms(denominator)


def _terms(e: Any) -> int:
    """Return a bound on the number of terms of e multiplied out."""
    if e.is_Add:
        return sum(map(_terms, e.args))
    if e.is_Mul:
        return prod(map(_terms, e.args))
    if e.is_Pow and e.exp.is_Integer:
        n = abs(int(e.exp))
        t = _terms(e.base)
        return comb(min(n + t - 1, 10_000), min(n, 10_000))
    return 1
