"""Centres of homogeneous potentials: zeros of a base of a broken power where the formula and its forces have a limit.

(x^2 + y^2)^1.25 is such a potential. Its derivatives are products of a zero and of an infinite power at the centre, so
they are printed with a base that is kept above a least number.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any, NamedTuple

from .gammainc import numeric

DIGITS = 500
"""Decimal digits in which limits at centres are computed."""

DRAWS = 2
"""Zeros of a centre's base that are tried."""

DIRECTIONS = 5
"""Directions from which a centre is approached."""

NEAR = -100
"""Decade of distance at which forces are compared with those at distance 1."""

NEARER = -200
"""Second, nearer decade at which forces are compared."""

SAME = 1e-6
"""The difference, relative to those at distance 1, that is none: forces have a limit if V is of a degree beyond 1.06.
"""

STEPS = 8
"""Newton steps to a zero, which a quadratic form reaches in two."""

RANGE = 300
"""Decades that the powers of the least base may span: the lowest of second derivatives is a number there."""


class Centre(NamedTuple):
    """A base of powers that is 0 at places where the formula and its forces have limits.

    base: as in the formula; square: the same as a smooth expression, the square of a modulus; smooth: whether second
    derivatives have a limit too; decades: the least base is 10^-decades.
    """

    base: Any
    square: Any
    smooth: bool
    decades: int = 300

    def shift(self, number: int) -> Any:
        """Return the symbol that stands for the least number while the formula is differentiated."""
        import sympy

        return sympy.Symbol(f"self.kept_{number}", positive=True)


def centres(V: Any, coordinates: Sequence[Any]) -> list[Centre]:
    """Return the centres of an expression of real symbols `coordinates`; parameters are drawn at random."""
    import mpmath
    import sympy

    found = []
    with mpmath.workdps(DIGITS):
        for base in dict.fromkeys(filter(None, map(_base, sympy.postorder_traversal(V)))):
            square = base.args[0] ** 2 if isinstance(base, sympy.Abs) else base
            used = [x for x in coordinates if square.has(x)]
            if used and square.is_polynomial(*used):
                centre = Centre(base, square, True)
                forces, smooth = _limits(mpmath.mp, V, centre, coordinates)
                if forces:
                    found.append(centre._replace(smooth=smooth, decades=_decades(V, centre)))
    return found


def shifted(V: Any, known: Sequence[Centre]) -> Any:
    """Return the expression with a symbol added to each of these bases, which keeps it apart from others."""
    import sympy

    for number, centre in enumerate(known):
        whole = centre.square + centre.shift(number)
        if isinstance(centre.base, sympy.Abs):
            V = V.xreplace({centre.base: sympy.sqrt(whole)})
        else:
            V = V.replace(
                lambda e, centre=centre: e.is_Pow and _base(e) == centre.base,
                lambda e, whole=whole: whole**e.exp,
            )
    return V


def kept(work: Any, expressions: Sequence[Any], known: Sequence[Centre], *, least: bool = True) -> list[Any]:
    """Return expressions of `shifted` with names of the bases, whose lines are added; least: whether bases are kept
    above the least number.
    """
    import sympy

    found = list(expressions)
    for number, centre in enumerate(known):
        whole = centre.square + centre.shift(number)
        if not any(e.has(centre.shift(number)) for e in found):
            continue
        text = work.text(centre.square)
        name = work.assign("kept", f"np.maximum({text}, 1e-{centre.decades})" if least or centre.smooth else text)
        symbol = sympy.Symbol(name, positive=True)
        found = [
            e.replace(
                lambda f, whole=whole: f.is_Pow and f.base == whole,
                lambda f, symbol=symbol: symbol**f.exp,
            )
            for e in found
        ]
    return found


def _decades(V: Any, centre: Centre) -> int:
    """Return the decades of the least base of an expression, from the lowest power in its second derivatives."""
    import sympy

    whole = centre.square + centre.shift(0)
    powers = [e.exp for e in sympy.postorder_traversal(shifted(V, [centre])) if e.is_Pow and e.base == whole]
    return int(RANGE / max(1.0, 2.0 - float(min(powers, default=1))))


def _base(e: Any) -> Any:
    """Return the base of a power whose exponent is a number and not whole, or a modulus; None for other expressions."""
    import sympy

    if isinstance(e, sympy.Abs):
        return e
    broken = e.is_Pow and e.exp.is_number and e.exp.is_real and not e.exp.is_Integer
    return e.base if broken and not isinstance(e.base, sympy.Abs) else None


def _limits(mp: Any, V: Any, centre: Centre, coordinates: Sequence[Any]) -> tuple[bool, bool]:
    """Return whether V and its gradient have limits at zeros of a smooth base, and whether its second derivatives have;
    none where it has no zeros.
    """
    import sympy

    rng = random.Random(4)
    shift = centre.shift(0)
    V = shifted(V, [centre])
    others = [*sorted(V.free_symbols - {*coordinates, shift}, key=str), shift]
    values = [mp.mpf(rng.uniform(0.5, 1.5)) for _ in others[:-1]] + [mp.mpf(0)]
    zeros = [_zero(mp, centre.square, [*coordinates], others, values, rng) for _ in range(DRAWS)]
    if any(zero is None for zero in zeros):
        return False, False
    alone = [sympy.lambdify([*coordinates, *others], V, numeric("mpmath"), dummify=True)]
    if not all(_alike(mp, alone, zero, values, rng, 0)[0] for zero in zeros if zero is not None):
        return False, False  # a pole, whose derivatives need not be formed
    gradient = [V.diff(x) for x in coordinates]
    second = [one.diff(x) for one in gradient for x in coordinates]
    if any(e.has(sympy.sign, sympy.Derivative, sympy.DiracDelta) for e in gradient):  # of another modulus
        return False, False
    second = [e for e in second if not e.has(sympy.sign, sympy.Derivative, sympy.DiracDelta)]
    every = [
        sympy.lambdify([*coordinates, *others], e, numeric("mpmath"), dummify=True) for e in (V, *gradient, *second)
    ]
    found = [_alike(mp, every, zero, values, rng, len(coordinates)) for zero in zeros if zero is not None]
    forces, curved = (all(entry[k] for entry in found) for k in range(2))
    return forces, forces and curved


def _zero(mp: Any, square: Any, coordinates: list, others: list, values: list, rng: random.Random) -> list | None:
    """Return a zero of a base that is nowhere negative, by Newton steps to its minimum; None where there is none."""
    import sympy

    arguments = [*coordinates, *others]
    n = len(coordinates)
    function = sympy.lambdify(arguments, square, numeric("mpmath"), dummify=True)
    slopes = [sympy.lambdify(arguments, square.diff(x), numeric("mpmath"), dummify=True) for x in coordinates]
    hessian = [
        [sympy.lambdify(arguments, square.diff(x, y), numeric("mpmath"), dummify=True) for y in coordinates]
        for x in coordinates
    ]
    at = [mp.mpf(rng.uniform(-1.5, 1.5)) for _ in coordinates]
    low = abs(function(*at, *values)) * mp.mpf(10) ** (2 * NEARER - 40)
    for _ in range(STEPS):
        if abs(function(*at, *values)) <= low:
            return at
        H = mp.matrix([[mp.mpf(entry(*at, *values)) for entry in row] for row in hessian])
        small = mp.mpf(10) ** (-DIGITS // 2) * sum(abs(entry) for entry in H)
        if small == 0:
            return None
        step = mp.lu_solve(H + small * mp.eye(n), mp.matrix([slope(*at, *values) for slope in slopes]))
        at = [x - s for x, s in zip(at, step, strict=True)]
    return None


def _alike(mp: Any, every: list, zero: list, values: list, rng: random.Random, n: int) -> tuple[bool, bool]:
    """Return whether V and its gradient, and its second derivatives, tend to one value each from all directions."""
    rows: list[list[list[Any]]] = [[], [], []]
    for _ in range(DIRECTIONS):
        way = [mp.mpf(rng.uniform(-1, 1)) for _ in zero]
        for row, decade in zip(rows, (0, NEAR, NEARER), strict=True):
            at = [x + mp.mpf(10) ** decade * w for x, w in zip(zero, way, strict=True)]
            try:
                row.append([mp.mpf(f(*at, *values)) for f in every])
            except (ArithmeticError, ValueError, TypeError):
                return False, False
    found = []
    for part in (slice(0, 1 + n), slice(1 + n, None)):
        far, near, nearer = ([entry[part] for entry in row] for row in rows)
        size = max((abs(x) for entry in far for x in entry), default=mp.mpf(0)) or mp.mpf(1)
        off = [abs(x - y) for entry in (*near, *nearer) for x, y in zip(entry, nearer[0], strict=True)]
        found.append(all(x <= SAME * size for x in off))
    return found[0], found[1]
