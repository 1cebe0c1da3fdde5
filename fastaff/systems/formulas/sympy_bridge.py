"""Between programs of the grammar and SymPy: exact numbers one way, a tree whitelist the other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from ...core.numbers import listed, shown
from .centres import centres
from .gammainc import GAMMAINC, gammainc
from .grammar import FUNCTIONS, Program

_EXACT_BITS = 4096
"""Bits up to which a power of numbers stays exact."""

_SPELLED = {"Pi": "pi", "Exp1": "exp(1)"}


def to_sympy(program: Program, names: Mapping[str, Any]) -> Any:
    """Return the SymPy expression of a program; decimal literals are exact rationals."""
    import sympy

    functions = {**{name: getattr(sympy, name) for name in FUNCTIONS}, GAMMAINC: gammainc()}
    expression = program.run(
        lambda f: sympy.Rational(f.numerator, f.denominator), {**names, "pi": sympy.pi}, functions, _power
    )
    return checked(sympy.sympify(expression))  # an Expr already: nothing is parsed


def _power(base: Any, exponent: Any) -> Any:
    """Return base**exponent; numbers whose exact power would be too long become floats."""
    import sympy

    if base.is_Rational and exponent.is_Rational:
        size = int(base.p).bit_length() + int(base.q).bit_length()
        large = size * abs(exponent) > _EXACT_BITS if exponent.is_Integer else size > 40 or exponent.q > 64
        if large:
            value = Fraction(repr(float(base) ** float(exponent)))
            return sympy.Rational(value.numerator, value.denominator)
    return base**exponent


def sharp(expression: Any) -> Any:
    """Return an expression whose denominators do not cancel: 1 - cos(x)**2, 1 - cos(x), cosh(x)**2 - cos(y)**2 and
    other sums of these functions and numbers that are 0 at 0 become sums of squares of sines, accurate down to the 0.
    """
    return expression.replace(
        lambda e: e.is_Pow and e.exp.is_Integer and e.exp.is_negative and e.base.is_Add,
        lambda e: _squares(e.base) ** e.exp,
    )


def _squares(total: Any) -> Any:
    """Return a sum of numbers, cos, cosh and their squares as a sum of squares of sines of one sign, or as it is."""
    import sympy

    constant = sympy.Integer(0)
    parts = []
    for factor, term in (term.as_coeff_Mul() for term in total.args):
        squared = term.is_Pow and term.exp == 2
        wave = term.base if squared else term
        constant += factor
        if isinstance(wave, (sympy.cos, sympy.cosh)):
            sign, sine = (-1, sympy.sin) if isinstance(wave, sympy.cos) else (1, sympy.sinh)
            x = wave.args[0]
            parts.append((sign * factor * (1 if squared else 2), sine(x if squared else x / 2) ** 2))
        elif term != 1:
            return total
    if constant != 0 or len({weight > 0 for weight, _ in parts}) != 1:
        return total
    return sympy.Add(*(weight * square for weight, square in parts))


def checked(expression: Any) -> Any:
    """Return a SymPy expression if it is a finite real formula; raise ValueError where SymPy shows that it is not."""
    import sympy

    for wrong, why in (
        (sympy.zoo, "divides by zero"),
        (sympy.nan, "has no value"),
        (sympy.oo, "is infinite"),
        (sympy.I, "is not real"),
    ):
        if expression.has(wrong):
            raise ValueError(f"text: the formula {why} everywhere ({expression})")
    if expression.is_real is False:
        raise ValueError(f"text: the formula has no finite real value anywhere ({expression})")
    moduli = [a for a in expression.atoms(sympy.Abs) if any(not s.name.startswith("self.") for s in a.free_symbols)]
    if moduli:  # |x|^2.5 has continuous forces
        coordinates = sorted((s for s in expression.free_symbols if not s.name.startswith("self.")), key=str)
        smooth = [centre.base for centre in centres(expression, coordinates)]
        moduli = [a for a in moduli if a not in smooth]
    if moduli:
        halves = {"p": "(D1 + D2)/2", "q": "(D1 - D2)/2"}
        shown = moduli[0].xreplace({s: sympy.Symbol(halves.get(s.name, s.name)) for s in moduli[0].free_symbols})
        raise ValueError(f"text: the formula contains {shown}, which is not smooth: forces would jump")
    return expression


def to_text(expression: Any) -> str:
    """Return a SymPy expression as text of the grammar; raise ValueError for parts outside the grammar."""
    import sympy

    for size, _ in enumerate(sympy.preorder_traversal(expression)):
        if size > 2000:
            raise ValueError("text: a SymPy expression of more than 2000 parts")
    return _text(expression)


def _text(e: Any) -> str:
    kind = type(e).__name__
    if e.is_Symbol:
        if not e.name.isidentifier():  # "D1 + D2" would be read as a sum
            raise ValueError(f"text: the SymPy symbol {shown(e.name)} is no name of the grammar")
        return str(e.name)
    if e.is_Rational:
        if e.q != 1:
            return f"({e.p}/{e.q})"
        if e.p < 0:
            return f"({e.p})"
        return str(e.p)
    if e.is_Float:
        value = float(e)
        if not math.isfinite(value) or (value == 0.0 and not e.is_zero):
            raise ValueError(f"text: the number {e} is beyond the range of floats")
        return f"({value!r})"
    if kind in _SPELLED:
        return _SPELLED[kind]
    if e.is_Add:
        return "(" + " + ".join(map(_text, e.as_ordered_terms())) + ")"
    if e.is_Mul:
        return "*".join(map(_text, e.as_ordered_factors()))
    if e.is_Pow:
        return f"({_text(e.base)})**({_text(e.exp)})"
    if kind in FUNCTIONS and len(e.args) == 1:
        return f"{kind}({_text(e.args[0])})"
    if kind == GAMMAINC:
        return f"{kind}({_text(e.args[0])}, {_text(e.args[1])})"
    if kind == "gamma" and e.is_number:
        return f"({float(e)!r})"
    raise ValueError(
        f"text: the SymPy expression contains {e} ({kind}); allowed are sums, products, powers and {listed(FUNCTIONS)}"
    )
