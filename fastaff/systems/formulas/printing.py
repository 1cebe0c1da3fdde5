"""Expressions as lines of Python: common parts named, powers as products, one root and one division for each base."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from .gammainc import GAMMAINC

NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}
_FUNCTIONS = ("exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "asin", "acos", "atan", "Abs", "Min", "Max")
_SUM = 1
_PRODUCT = 2
_ATOM = 3
_LARGE = 1500
"""Operations of the expressions from which on only one way to write them is tried."""


class Assignments:
    """Assignments that are being written; taken: names that temporaries must not have."""

    def __init__(self, taken: Sequence[str]):
        self.lines: list[str] = []
        self._taken = {*taken, "self", "np"}
        self._counters: dict[str, int] = {}
        self._roots: dict[Any, str] = {}
        self._inverses: dict[Any, str] = {}
        self._squares: dict[tuple[str, int], str] = {}
        self._aliases: dict[str, str] = {}

    def name(self, stem: str) -> str:
        """Return a fresh name: t1, t2, ..."""
        while True:
            self._counters[stem] = self._counters.get(stem, 0) + 1
            fresh = f"{stem}{self._counters[stem]}"
            if fresh not in self._taken:
                self._taken.add(fresh)
                return fresh

    def assign(self, stem: str, text: str) -> str:
        """Add a line that gives `text` a fresh name."""
        fresh = self.name(stem)
        self.lines.append(f"{fresh} = {text}")
        return fresh

    def add(self, expressions: Sequence[Any]) -> list[str]:
        """Add the lines of expressions with their common parts; return the text of each."""
        import sympy
        from sympy.simplify.cse_opts import sub_post, sub_pre

        # Different ways to write a sum with parameters in front; the cheapest wins, parts of parameters alone are free.
        candidates: list[tuple[list[Any], Any]] = [(list(expressions), [(sub_pre, sub_post)])]
        if sum(map(cost_of, expressions)) < _LARGE:
            candidates += [(list(expressions), "basic"), ([sympy.factor_terms(e) for e in expressions], "basic")]
            candidates.append(([spread_parameters(sympy.factor_terms(e)) for e in expressions], [(sub_pre, sub_post)]))
        found = [sympy.cse(e, symbols=self._symbols(), optimizations=how, list=True) for e, how in candidates]
        replacements, results = min(found, key=lambda f: sum(cost_of(e) for _, e in f[0]) + sum(map(cost_of, f[1])))
        self._taken.update(symbol.name for symbol, _ in replacements)
        constants: dict[Any, Any] = {}
        for symbol, part in replacements:
            e = part.xreplace(constants)
            if e.is_number:
                constants[symbol] = e
                continue
            text = self.text(e)
            if text.isidentifier():
                self._aliases[symbol.name] = text
            else:
                self.lines.append(f"{symbol.name} = {text}")
        return [self.text(e.xreplace(constants)) for e in results]

    def _symbols(self) -> Iterator[Any]:
        import sympy

        number = 0
        while True:
            number += 1
            if f"t{number}" not in self._taken:
                yield sympy.Symbol(f"t{number}", real=True)

    def text(self, e: Any) -> str:
        """Return the text of an expression; may add lines."""
        return self._text(e)[0]

    def _inside(self, e: Any, level: int) -> str:
        text, own = self._text(e)
        return text if own >= level and not (text.startswith("-") and level > _SUM) else f"({text})"

    def _text(self, e: Any) -> tuple[str, int]:
        import sympy

        if e.is_Symbol:
            return self._aliases.get(e.name, e.name), _ATOM
        if e.is_number:
            return number(e)
        if e.is_Add:
            return self._sum(e)
        if e.is_Mul:
            return self._product(e)
        if e.is_Pow:
            return self._power(e.base, e.exp)
        name = type(e).__name__
        if isinstance(e, (sympy.Min, sympy.Max)):
            text = self.text(e.args[0])
            for argument in e.args[1:]:
                text = f"np.{name.lower()}imum({text}, {self.text(argument)})"
            return text, _ATOM
        if name == GAMMAINC:
            a, x = e.args
            front = number(1 / sympy.gamma(a + 1))[0]
            return f"{name}({number(a)[0]}, {self.text(x)}, {front})", _ATOM
        if name not in _FUNCTIONS or len(e.args) != 1:
            raise ValueError(f"text: the formula or a derivative of it contains {e}, which has no smooth derivative")
        return f"np.{NAMES.get(name, name.lower())}({self.text(e.args[0])})", _ATOM

    def _sum(self, e: Any) -> tuple[str, int]:
        terms = [
            self._inside(term, _SUM) for term in sorted(e.args, key=lambda t: (t.could_extract_minus_sign(), _order(t)))
        ]
        text = terms[0]
        for term in terms[1:]:
            text += f" - {term[1:]}" if term.startswith("-") else f" + {term}"
        return text, _SUM

    def _product(self, e: Any) -> tuple[str, int]:
        import sympy

        coefficient = sympy.Mul(*(factor for factor in e.args if factor.is_number))
        factors = sorted((factor for factor in e.args if not factor.is_number), key=_order)
        texts = [self._inside(factor, _PRODUCT) for factor in factors]
        sign = "-" if coefficient.is_negative else ""
        if abs(coefficient) != 1:
            texts.insert(0, self._inside(abs(coefficient), _PRODUCT))
        return sign + "*".join(texts), _PRODUCT

    def _power(self, base: Any, exponent: Any) -> tuple[str, int]:
        twice = 2 * exponent
        if not (twice.is_Integer and abs(twice) <= 256):
            return f"np.power({self.text(base)}, {self.text(exponent)})", _ATOM
        count, half = divmod(abs(int(twice)), 2)
        if exponent < 0:
            if half:
                root = self._inverse_root(base)
                return self._repeated(root, 2 * count + 1), _PRODUCT
            return self._repeated(self._inverse(base), count), _PRODUCT
        if half:
            root = self._root(base)
            return (root, _ATOM) if not count else (f"{self._natural(base, count)}*{root}", _PRODUCT)
        return self._natural(base, count), _PRODUCT

    def _natural(self, base: Any, count: int) -> str:
        return self._repeated(self.text(base) if base.is_Symbol else self._named("base", base), count)

    def _named(self, stem: str, base: Any) -> str:
        """Name a base once."""
        key = (str(base), 0)
        if key not in self._squares:
            text = self.text(base)
            self._squares[key] = self.assign(stem, text)
        return self._squares[key]

    def _repeated(self, name: str, count: int) -> str:
        """Return name**count as a product, beyond the third power of named squares."""
        if count <= 3:
            return "*".join([name] * count)
        parts = []
        power = 1
        while power <= count:
            if count & power:
                parts.append(self._square(name, power))
            power *= 2
        return "*".join(parts)

    def _square(self, name: str, power: int) -> str:
        if power == 1:
            return name
        if (name, power) not in self._squares:
            half = self._square(name, power // 2)
            self._squares[name, power] = self.assign("s", f"{half}*{half}")
        return self._squares[name, power]

    def _root(self, base: Any) -> str:
        if base not in self._roots:
            text = self.text(base)
            self._roots[base] = self.assign("root", f"np.sqrt({text})")
        return self._roots[base]

    def _inverse(self, base: Any) -> str:
        if base not in self._inverses:
            root = self._inverses.get(("root", base))
            self._inverses[base] = self.assign("w", f"{root}*{root}" if root else f"1.0/{self._inside(base, _ATOM)}")
        return self._inverses[base]

    def _inverse_root(self, base: Any) -> str:
        if ("root", base) not in self._inverses:
            root = self._root(base)
            inverse = self._inverses.get(base)
            self._inverses["root", base] = self.assign("w", f"{root}*{inverse}" if inverse else f"1.0/{root}")
        return self._inverses["root", base]


def number(e: Any) -> tuple[str, int]:
    """Return a constant as a float that Python reads back: short decimals, exact quotients, else 17 digits."""
    if e.is_Rational:
        exact = Fraction(int(e.p), int(e.q))
        try:
            value = float(exact)
        except OverflowError:
            raise ValueError(
                f"text: a constant of the formula is beyond the range of floats ({str(e)[:40]}...)"
            ) from None
        if Fraction(repr(value)) == exact or exact.denominator > 1000:
            return repr(value), _ATOM if value >= 0 else _PRODUCT
        return f"{exact.numerator}/{exact.denominator}", _SUM  # folded at compilation; parentheses in products
    constant = complex(e.evalf(20))
    if constant.imag != 0 or constant.real - constant.real != 0:
        raise ValueError(f"text: the constant {e} of the formula is not a finite real number")
    return repr(constant.real), _ATOM if constant.real >= 0 else _PRODUCT


def _order(e: Any) -> tuple[bool, bool, str]:
    """Sort key: numbers, then factors of parameters alone (which leave the loop over orbits), then the rest."""
    return not e.is_number, not is_free(e), str(e)


def is_free(e: Any) -> bool:
    """Tell whether an expression depends on parameters alone: it leaves the loop over orbits."""
    return all(symbol.name.startswith("self.") for symbol in e.free_symbols)


def spread_parameters(e: Any) -> Any:
    """Multiply sums out with the factors that depend on parameters alone."""
    import sympy

    if not e.args or is_free(e):
        return e
    e = e.func(*map(spread_parameters, e.args))
    if e.is_Mul:
        front = sympy.Mul(*filter(is_free, e.args))
        rest = sympy.Mul(*(factor for factor in e.args if not is_free(factor)))
        if rest.is_Add:
            return sympy.Add(*(front * term for term in rest.args))
    return e


def cost_of(e: Any) -> int:
    """Return a rough number of operations inside the loop over orbits."""
    total = 0
    stack = [e]
    while stack:
        f = stack.pop()
        if not f.args or is_free(f):
            continue
        stack.extend(f.args)
        if f.is_Add or f.is_Mul:
            free = [g for g in f.args if is_free(g) and g != -1]
            total += len([g for g in f.args if not is_free(g)]) - 1 + bool(free)
        elif f.is_Pow:
            total += abs(int(f.exp)) - 1 + (8 if f.exp < 0 else 0) if f.exp.is_Integer else 10
        else:
            total += 30
    return total
