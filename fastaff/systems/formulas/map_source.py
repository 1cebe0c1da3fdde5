"""Maps written as text: statements, and the source of their class."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ...core.foreign import call_for
from ...core.numbers import listed, shown
from ..models.contracts import Kind
from .gammainc import GAMMAINC
from .grammar import Program, UnknownName, checked_name, parse
from .potential_source import constant, method, spread
from .printing import Assignments

TAG = Kind.MAP.equations
"""First entry of the request of a map: no formula of a potential can be this text."""

_PRIMED = re.compile(r"([A-Za-z]\w*)'")
_IMAGE = "_image"
MAX_ROWS = 16
"""Most variables of a map."""

MANY = 16
"""Number of statements above which each is differentiated by itself."""

MOST = 400_000
"""Most characters of a text."""


class MapRequest(NamedTuple):
    """All data that determine the class of a map; coordinates and momenta are names, periods texts, "" for none."""

    tag: str
    text: str
    domain: str | None
    parameters: tuple[str, ...]
    coordinates: tuple[str, ...]
    momenta: tuple[str, ...]
    periods: tuple[str, ...]


class Statement(NamedTuple):
    """One line name = expression; `name` ends in the suffix of images, or is used in later lines."""

    name: str
    program: Program


class Statements(NamedTuple):
    """The lines of a map in their order, the suffix of images, and the variables in the order of their images."""

    lines: tuple[Statement, ...]
    suffix: str
    variables: tuple[str, ...]

    @property
    def names(self) -> frozenset[str]:
        """All names that the expressions use."""
        return frozenset().union(*(line.program.names for line in self.lines))


def statements(text: Any, parameters: Sequence[str], length: int = MOST) -> Statements:
    """Return the statements of a text; raise ValueError where it is no map."""
    example = "'p1 = p + K*sin(x); x1 = x + p1'"
    if not isinstance(text, str):
        raise TypeError(
            f"text must be a map such as {example}, got {shown(text)} ({type(text).__name__}){call_for(text)}"
        )
    if len(text) > length:
        raise ValueError(f"text must have at most {length} characters, got {len(text)}")
    suffix = _IMAGE if "'" in text else "1"
    pieces = [piece.strip() for piece in re.split(r"[;\n]", _PRIMED.sub(rf"\1{_IMAGE}", text)) if piece.strip()]
    sides = []
    for piece in pieces:
        left, equals, right = piece.partition("=")
        if not (equals and right.strip()) or not left.strip().isidentifier():
            file = f"; a file of MAD is pathlib.Path({text!r})" if Path(text).suffix and len(pieces) == 1 else ""
            raise ValueError(
                f"text must be statements name = formula, such as {example}; got {shown(_shown(piece))}{file}"
            )
        sides.append((left.strip(), right.strip()))
    images = [left for left, _ in sides if left.endswith(suffix) and len(left) > len(suffix)]
    variables = tuple(image.removesuffix(suffix) for image in images)
    if not variables:
        raise ValueError(f"text must give the image of each variable, x1 = ... or x' = ..., such as {example}")
    if (len(variables) % 2 and len(variables) > 1) or len(variables) > MAX_ROWS:
        raise ValueError(
            f"text must give the images of 1, 2, 4, ... or {MAX_ROWS} variables, got those of {listed(variables)}"
        )
    known: list[str] = []
    for variable in variables:
        known.append(checked_name(variable, "variable", {*known, *parameters, "self", "np"}))
    lines = []
    for left, right in sides:
        if left in known:
            what = "a parameter" if left in parameters else "a variable" if left in variables else "one with a value"
            raise ValueError(
                f"text: {_shown(left)} = ... must give a value to a new name, got {what}. Write the image of x as x1 "
                "or x'."
            )
        if left not in images:
            checked_name(left, "name", {*known, *parameters, "self", "np"})
        try:
            program = parse(right, known, parameters, argument=f"text, {_shown(left)}", length=length)
        except UnknownName as problem:
            if problem.name == left or problem.name not in dict(sides):
                raise
            late = f"{_shown(problem.name)} = ..."
            raise ValueError(
                f"text, {_shown(left)}: {late} comes later. Write {late} before {_shown(left)} = ..."
            ) from None
        lines.append(Statement(left, program))
        known.append(left)
    return Statements(tuple(lines), suffix, variables)


def _shown(name: str) -> str:
    return name.replace(_IMAGE, "'")


def class_of_map(
    request: MapRequest, found: Statements, domain: Program | None, periods: Sequence[Program | None]
) -> str:
    """Return the source of the class of a map, with its derivative from the same expressions."""
    import sympy

    from .sympy_bridge import checked, to_sympy

    rows = (*request.coordinates, *request.momenta)
    own = {name: sympy.Symbol(name, real=True) for name in rows}
    parameters = {name: sympy.Symbol(f"self.{name}", real=True) for name in request.parameters}
    values: dict[str, Any] = {**own, **parameters}
    changes = {name: sympy.Symbol(f"d{name}", real=True) for name in rows}
    taken = (*rows, *(f"d{name}" for name in rows))

    def arrays(expressions: Sequence[Any], lines: Assignments) -> list[str]:
        symbols = {*own.values(), *changes.values()}
        texts = lines.add(expressions)
        return [
            t if e.free_symbols & symbols else f"{t} + 0.0*{rows[0]}" for t, e in zip(texts, expressions, strict=True)
        ]

    lines = Assignments(taken)
    moving = Assignments(taken)
    other = Assignments(taken)
    if len(found.lines) > MANY:
        image, change = _one_by_one(found, values, changes, (lines, moving))
    else:
        for line in found.lines:
            values[line.name] = checked(to_sympy(line.program, values))
        images = [values[name + found.suffix] for name in rows]
        derivative = [sum((e.diff(own[name]) * changes[name] for name in rows), sympy.Integer(0)) for e in images]
        image = arrays(images, lines)
        change = arrays(derivative, moving)
    texts = ["0.0" if p is None else f"1.0*({other.text(to_sympy(p, parameters))})" for p in periods]
    wall = None if domain is None else to_sympy(domain, {**{q: own[q] for q in request.coordinates}, **parameters})
    methods = [
        constant("kind", "A map.", "Kind.MAP"),
        constant("symplectic", "Whether it is symplectic, at random points to rounding.", "symplectic(self)"),
        constant("degrees_of_freedom", f"Return {len(request.coordinates)}.", str(len(request.coordinates))),
        constant("coordinates", "Names of the coordinates.", repr(request.coordinates)),
        constant("momenta", "Names of the momenta.", repr(request.momenta)),
        method("iterate", rows, "Return the image of a phase point.", lines, image),
        method("tangent_iterate", taken, "Return the derivative of the map applied to a vector.", moving, change),
        method("periods", (), "Return the period of each row, 0 where it has none.", other, texts),
        _margin(wall, request.coordinates, taken),
    ]
    return "\n".join(_head(request)) + "\n" + "\n".join(textwrap.indent(entry, "    ") for entry in methods)


def _margin(wall: Any, q: Sequence[str], taken: Sequence[str]) -> str:
    """Return the text of the margin: the wall, an expression in the coordinates q, or 1."""
    lines = Assignments(taken)
    # Term by term: a sum of finite terms may be infinite.
    free = " + ".join(["1.0", *(f"0.0*{name}" for name in q)])
    whole = free if wall is None else spread(wall, lines.add([wall])[0], q)
    doc = "Return a number that is positive where the map lives."
    return method("margin", q, doc, lines, [whole], single=True)


def _head(request: MapRequest) -> list[str]:
    """Return the lines of a module of a map before the methods of its class."""
    said = " ".join(request.text.split())
    return [
        f'"""The map {said}: written by fastaff from this text; the derivative by SymPy."""',
        "",
        "from typing import NamedTuple",
        "",
        "import numpy as np",
        "",
        *([f"from fastaff.engine.incomplete_gamma import {GAMMAINC}"] if GAMMAINC in request.text else []),
        "from fastaff.systems.models.contracts import Kind",
        "from fastaff.systems.models.maps import symplectic",
        "",
        "",
        "class FormulaMap(NamedTuple):",
        f'    """The map {said}."""',
        "",
        *(f"    {name}: float" for name in request.parameters),
        *([""] if request.parameters else []),
        f"    formula = {request.text!r}",
        f"    domain = {request.domain!r}",
        "",
    ]


def _one_by_one(
    found: Statements, values: dict[str, Any], changes: dict[str, Any], lines: tuple[Assignments, Assignments]
) -> tuple[list[str], list[str]]:
    """Write the statements one after the other, each with its change by the chain rule; return the texts of the images
    and of their changes. The cost grows as the length; derivatives of expanded images would grow as its square.
    """
    import sympy

    from .sympy_bridge import to_sympy

    image, moving = lines
    moved = dict(changes)
    for line in found.lines:
        e = to_sympy(line.program, values)
        name = moving.name("s")
        to = moving.name("ds")
        image.name("s")
        parts = [e.diff(values[entry]) * moved[entry] for entry in sorted(line.program.names & moved.keys())]
        change = moving.text(sum(parts, sympy.Integer(0)))
        for each in lines:
            each.lines.append(f"{name} = {each.text(e)}")
        moving.lines.append(f"{to} = {change}")
        values[line.name], moved[line.name] = (sympy.Symbol(entry, real=True) for entry in (name, to))
    ends = [entry + found.suffix for entry in changes]
    return [values[entry].name for entry in ends], [moved[entry].name for entry in ends]


def pairs(variables: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return coordinates and momenta of variables: by names p or p_x or px beside x, else in their order, coordinates
    first; one variable alone has no momentum.
    """
    names = set(variables)
    if len(variables) == 1:
        return (variables[0],), ()

    def momentum(name: str) -> str | None:
        return next((m for m in (f"p_{name}", f"p{name}") if m in names and m != name), None)

    found = {name: momentum(name) for name in variables}
    if len(names) == 2 and "p" in names:
        other = next(name for name in variables if name != "p")
        return (other,), ("p",)
    coordinates = tuple(name for name in variables if found[name])
    momenta = tuple(str(found[name]) for name in coordinates)
    if {*coordinates, *momenta} == names and len(coordinates) == len(momenta):
        return coordinates, momenta
    return _numbered(variables) or (tuple(variables[: len(names) // 2]), tuple(variables[len(names) // 2 :]))


def _numbered(variables: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Return coordinates and momenta of variables such as x1, p1, x2, p2 or q_1, p_1, ...; None for other names."""
    ends = {name: name[1:] for name in variables}
    momenta = {end: name for name, end in ends.items() if name[0] == "p" and end}
    others = [name for name in variables if name[0] != "p"]
    if len(momenta) == len(others) and all(ends[name] in momenta for name in others):
        return tuple(others), tuple(momenta[ends[name]] for name in others)
    return None


def period_texts(periodic: Any, rows: Sequence[str]) -> tuple[str, ...]:
    """Return the text of each row's period, "" where it has none; raise ValueError or TypeError for wrong periods."""
    given = {} if periodic is None else periodic
    if not isinstance(given, Mapping):
        raise TypeError(
            f"periodic must be a dictionary such as {{'x': 2*pi}}, got {shown(periodic)} ({type(periodic).__name__})"
        )
    for name in given:
        if name not in rows:
            raise ValueError(f"periodic must be of {listed(rows)}, got one of {shown(name)}")
    texts = []
    for name in rows:
        value = given.get(name, "")
        if not isinstance(value, str):
            from ...core.numbers import positive

            value = repr(positive(f"periodic[{name!r}]", value))
        texts.append(value.strip())
    return tuple(texts)
