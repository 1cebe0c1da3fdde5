"""Texts of kinetic energies, and tests for one in H(q, p): T(p) + V(q), perhaps in a rotating frame."""

from __future__ import annotations

import re
from collections.abc import Sequence
from random import Random
from typing import Any, NamedTuple

import numpy as np

from .domains import SAMPLES, everywhere, poles
from .gammainc import numeric
from .printing import Assignments


class KineticSide(NamedTuple):
    """The kinetic side of a model: fields, and texts of the velocities and of T; tangent: of the changes of velocities
    along a vector, where T is not quadratic.
    """

    fields: tuple[str, ...]
    lines: tuple[str, ...]
    velocity: tuple[str, ...]
    kinetic: str
    tangent: tuple[str, ...] = ()


def fresh(prefix: str, coordinates: Sequence[str], taken: Sequence[str]) -> tuple[str, ...]:
    """Return names of a prefix and each coordinate; none of them is taken."""
    while {prefix + c for c in coordinates} & {*coordinates, *taken, "self", "np"}:
        prefix += "_"
    return tuple(prefix + c for c in coordinates)


def plane_inertia(pair: bool) -> KineticSide:
    """Return the inertia mu of a body, or diag(mu_1, mu_2) in the material frame: T = (p_x^2 + p_z^2)/2 mu_1 + (p_y^2 +
    p_u^2)/2 mu_2.
    """
    p = ("pa1", "pa2", "pb1", "pb2")
    if not pair:
        square = " + ".join(f"{c}*{c}" for c in p)
        return KineticSide(("mu",), ("w = 1.0/self.mu",), tuple(f"w*{c}" for c in p), f"({square})/(2*self.mu)")
    lines = ("v, w = 0.5/self.mu_1, 0.5/self.mu_2", "k, d = v + w, v - w")
    velocity = ("k*pa1 + d*pb1", "k*pa2 + d*pb2", "d*pa1 + k*pb1", "d*pa2 + k*pb2")
    first = "(pa1 + pb1)*(pa1 + pb1) + (pa2 + pb2)*(pa2 + pb2)"
    second = "(pa1 - pb1)*(pa1 - pb1) + (pb2 - pa2)*(pb2 - pa2)"
    return KineticSide(("mu_1", "mu_2"), lines, velocity, f"({first})/(4*self.mu_1) + ({second})/(4*self.mu_2)")


def mass_inertia(coordinates: Sequence[str], masses: bool, moving: int) -> KineticSide:
    """Return unit masses, or masses m_1, ... that are fields, of the first coordinates: T = sum p_i^2/2 m_i."""
    p = fresh("p", coordinates, ())[:moving]
    if not masses:
        return KineticSide((), (), p, f"({' + '.join(f'{c}*{c}' for c in p)})/2")
    fields = tuple(f"m_{i}" for i in range(1, len(p) + 1))
    velocity = tuple(f"{c}*(1.0/self.{m})" for c, m in zip(p, fields, strict=True))
    kinetic = " + ".join(f"{c}*{c}/(2*self.{m})" for c, m in zip(p, fields, strict=True))
    return KineticSide(fields, (), velocity, kinetic)


def driven_inertia(inertia: KineticSide, coordinates: Sequence[str]) -> KineticSide:
    """Return the inertia of a driven system from that of its coordinates; the velocity of the time is 1."""
    p = fresh("p", coordinates, ())[-1]
    tangent = (*inertia.tangent, f"0.0*{p}") if inertia.tangent else ()
    return inertia._replace(velocity=(*inertia.velocity, f"1.0 + 0.0*{p}"), tangent=tangent)


def in_turning_frame(
    H: Any, walls: Sequence[Any], momenta: Sequence[Any], coordinates: Sequence[str]
) -> tuple[Any, Any, KineticSide] | None:
    """Return V(q), the rate w and the inertia of H = T(p) + V(q) - w (x p_y - y p_x), with T quadratic, and isotropic
    in the momenta of the first two coordinates x, y; None where it is not of that form.
    """
    import sympy

    if len(momenta) < 2:
        return None
    x, y = (sympy.Symbol(name, real=True) for name in coordinates[:2])
    twice = H.diff(momenta[1], x)
    if twice == 0 or _varied([twice], ()):
        return None
    parts = sympy.Add.make_args(H)
    mixed = sympy.expand(sympy.Add(*(part for part in parts if part.free_symbols & {*momenta})))
    rate = -mixed.diff(momenta[1], x)
    rest = sympy.expand(mixed + rate * (x * momenta[1] - y * momenta[0]))
    W = [[sympy.simplify(rest.diff(one, other)) for other in momenta] for one in momenta[:2]]
    round_ = W[0][0] == W[1][1] and not any(w != 0 for i, row in enumerate(W) for j, w in enumerate(row) if i != j)
    varied = {*momenta, *(sympy.Symbol(name, real=True) for name in coordinates)}
    if rate == 0 or rate.free_symbols & varied or not round_:
        return None
    found = separated(_still(H, momenta) + rest - _still(rest, momenta), walls, momenta, coordinates)
    return None if found is None or found[1].tangent else (found[0], rate, found[1])


def _still(H: Any, momenta: Sequence[Any]) -> Any:
    """Return H at zero momenta, not expanded: far from its centre an expanded polynomial is a difference of large
    numbers.
    """
    import sympy

    return H.xreplace(dict.fromkeys(momenta, sympy.Integer(0)))


def separated(
    H: Any, walls: Sequence[Any], momenta: Sequence[Any], coordinates: Sequence[str]
) -> tuple[Any, KineticSide] | None:
    """Return V(q) and the inertia of H = T(p) + V(q); the time may be one more coordinate; None where it is not of that
    form, or not known to be: T must have no poles and walls, and nowhere less than its value at rest.
    """
    import sympy

    if _varied([H.diff(p) for p in momenta], momenta):
        return None
    walls = [wall for wall in walls if not _positive(wall, momenta)]
    of_momenta = [
        [part for part in sympy.Add.make_args(form) if part.free_symbols & {*momenta}] for form in (H, sympy.expand(H))
    ]
    places = {sympy.Symbol(name, real=True) for name in coordinates}
    for own in of_momenta:
        T = sympy.Add(*own)
        W = [[T.diff(one, other) for other in momenta] for one in momenta]
        rest = sympy.expand(T - sympy.Add(*(w * a * b / 2 for a, r in zip(momenta, W) for b, w in zip(momenta, r))))
        if T.free_symbols & places or _bounded(walls, momenta) or any(w.is_zero for w in map(T.diff, momenta)):
            continue
        curved = rest != 0 or any(w.free_symbols & {*momenta} for row in W for w in row)
        if not curved and all(row[i] != 0 for i, row in enumerate(W)):
            return _still(H, momenta), _quadratic_inertia(W, coordinates)
        if curved and _least_at_rest(T, momenta):
            return _still(H, momenta), _curved_inertia(T, momenta, coordinates)
    return None


def _positive(wall: Any, momenta: Sequence[Any]) -> bool:
    """Tell whether a wall of momenta alone is positive for all of them and positive parameters."""
    import sympy

    parameters = wall.free_symbols - {*momenta}
    own = all(str(name).startswith("self.") for name in parameters)
    return own and bool(wall.xreplace({name: sympy.Dummy(positive=True) for name in parameters}).is_positive)


def _least_at_rest(T: Any, momenta: Sequence[Any]) -> bool:
    """Tell whether T has no poles, and at many momenta no less than at rest: it is the scale of errors of energies."""
    import sympy

    region = everywhere(momenta)
    still = _still(T, momenta)
    if still.is_finite is False or still.has(sympy.nan) or poles(T, region):
        return False
    rng = np.random.default_rng(4)
    names = sorted((T + still).free_symbols, key=str)
    drawn = region(rng, SAMPLES)
    values = [drawn[name] if name in drawn else rng.uniform(0.1, 2.0, 2 * SAMPLES) for name in names]
    with np.errstate(all="ignore"):
        moving, resting = sympy.lambdify(names, [T, still], numeric("numpy"), dummify=True)(*values)
        return not (moving - resting < -1e-9 * (np.abs(moving) + np.abs(resting))).any()


def _curved_inertia(T: Any, momenta: Sequence[Any], coordinates: Sequence[str]) -> KineticSide:
    """Return the inertia of T, not quadratic, with the energy at rest left out."""
    import sympy

    p = fresh("p", coordinates, ())
    d = fresh("d", p, ())
    own = [sympy.Symbol(name, real=True) for name in p[: len(momenta)]]
    along = [sympy.Symbol(name, real=True) for name in d[: len(momenta)]]
    T = (T - _still(T, momenta)).xreplace(dict(zip(momenta, own, strict=True)))
    v = [T.diff(x) for x in own]
    lines = Assignments((*p, *d))
    changes = [sympy.sympify(sum(entry.diff(x) * dx for x, dx in zip(own, along, strict=True))) for entry in v]
    velocity, tangent, kinetic = (lines.add(part) for part in (v, changes, [T]))
    kept = [
        tuple(
            text if entry.free_symbols & {*own} else f"{text} + 0.0*{p[0]}" for text, entry in zip(*part, strict=True)
        )
        for part in ((velocity, v), (tangent, changes))
    ]
    return KineticSide((), tuple(lines.lines), kept[0], kinetic[0], kept[1])


def _varied(expressions: Sequence[Any], fixed: Sequence[Any]) -> bool:
    """Tell whether expressions, by values at a few points, depend on more than parameters and the fixed symbols: to
    expand long ones takes minutes.
    """
    import mpmath
    import sympy

    names = sorted(sympy.Tuple(*expressions).free_symbols, key=str)
    function = sympy.lambdify(names, list(expressions), numeric("mpmath"), cse=True)
    random = Random(7)
    with mpmath.workdps(30):
        for _ in range(8):
            here = [mpmath.mpf(random.uniform(0.2, 5)) for _ in names]
            there = [
                value if name in fixed or str(name).startswith("self.") else value * random.uniform(1, 1.5)
                for name, value in zip(names, here, strict=True)
            ]
            try:
                one = function(*here)
                other = function(*there)
            except (ArithmeticError, ValueError):
                continue
            if any(abs(a - b) > 1e-9 * (abs(a) + abs(b)) for a, b in zip(one, other, strict=True)):
                return True
    return False


def _bounded(walls: Sequence[Any], momenta: Sequence[Any]) -> bool:
    return any(wall.free_symbols & {*momenta} for wall in walls)


def _quadratic_inertia(W: Sequence[Sequence[Any]], coordinates: Sequence[str]) -> KineticSide:
    """Return the inertia of T = p.W p/2, in the texts of `mass_inertia` where W is diagonal."""
    p = fresh("p", coordinates, ())[: len(W)]
    n = range(len(W))
    if all(W[i][j] == 0 for i in n for j in n if i != j):
        if all(W[i][i] == 1 for i in n):
            return mass_inertia(coordinates, False, len(W))
        masses = [f"({_text(1 / W[i][i])})" for i in n]
        kinetic = " + ".join(f"{c}*{c}/(2*{m})" for c, m in zip(p, masses, strict=True))
        return KineticSide((), (), tuple(f"{c}*(1.0/{m})" for c, m in zip(p, masses, strict=True)), kinetic)
    velocity = tuple(" + ".join(f"({_text(W[i][j])})*{p[j]}" for j in n if W[i][j] != 0) for i in n)
    return KineticSide((), (), velocity, f"({' + '.join(f'{c}*({v})' for c, v in zip(p, velocity, strict=True))})/2")


def _text(expression: Any) -> str:
    """Return an expression as one text, with its named parts written out in parentheses."""
    lines = Assignments(())
    text = lines.text(expression)
    for name, value in (line.split(" = ", 1) for line in reversed(lines.lines)):
        text = re.sub(rf"(?<![\w.]){name}\b", f"({value})", text)
    return text
