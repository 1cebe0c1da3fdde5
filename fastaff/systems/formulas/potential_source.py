"""Source text of models: NamedTuple classes with exact derivatives, from expressions."""

from __future__ import annotations

import cmath
import re
import textwrap
from collections.abc import Sequence
from typing import Any, NamedTuple

from .centres import Centre
from .gammainc import GAMMAINC
from .printing import Assignments

_WORD = re.compile(r"[A-Za-z_]\w*")


class Description(NamedTuple):
    """Properties of a generated class, its parameters in field order, expressions that pass a whole number at poles of
    a body's V, and centres of V.
    """

    formula: str
    domain: str | None
    parameters: tuple[str, ...]
    proof: str
    coordinates: tuple[str, ...] = ()
    poles: tuple[Any, ...] = ()
    centres: tuple[Centre, ...] = ()


def module(description: Description, body: str, imports: str = "") -> str:
    """Return the text of the module of a class."""
    head = (
        f'"""V = {_one_line(description.formula)}: written by fastaff from this formula; derivatives by SymPy."""\n\n'
    )
    if f"{GAMMAINC}(" in body:
        imports += f"\nfrom fastaff.engine.incomplete_gamma import {GAMMAINC}\n"
    text = f"{head}from typing import NamedTuple\n\nimport numpy as np\n{imports}\n\n{body}"
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


def _one_line(text: str) -> str:
    return " ".join(text.split())


def class_text(name: str, what: str, d: Description, fields: Sequence[str], methods: Sequence[str]) -> str:
    """Return the text of a NamedTuple class."""
    said = f"V = {_one_line(d.formula)}"
    lines = [f"class {name}(NamedTuple):", f'    """{said}: {what}.', ""]
    lines += [f"    {d.proof}", '    """', ""]
    lines += [f"    {field}: float" for field in fields]
    lines += [""] if fields else []
    for attribute in ("formula", "domain", "proof"):
        lines.append(f"    {attribute} = {getattr(d, attribute)!r}")
    return "\n".join(lines) + "\n\n" + "\n".join(textwrap.indent(method, "    ") for method in methods)


def method(
    name: str, arguments: Sequence[str], doc: str, lines: Assignments, results: Sequence[str], *, single: bool = False
) -> str:
    """Return the text of a method that returns a number, or a tuple."""
    returned = results[0] if single else ", ".join(results) + ("," if len(results) == 1 else "")
    body = [f'"""{doc}"""', *_used(lines.lines, returned), f"return {returned}"]
    return f"def {name}({', '.join(['self', *arguments])}):\n" + textwrap.indent("\n".join(body), "    ") + "\n"


def _used(lines: Sequence[str], returned: str) -> list[str]:
    """Return the assignments that the result needs."""
    needed = set(_WORD.findall(returned))
    kept = []
    for line in reversed(lines):
        targets, text = line.split(" = ", 1)
        if needed & set(_WORD.findall(targets)):
            needed |= set(_WORD.findall(text))
            kept.append(line)
    return kept[::-1]


def constant(name: str, doc: str, value: str) -> str:
    """Return the text of a property."""
    return f'@property\ndef {name}(self):\n    """{doc}"""\n    return {value}\n'


def spread(expression: Any, text: str, coordinates: Sequence[str]) -> str:
    """Return text, as an array of the shape of the coordinates if the expression does not depend on all of them."""
    present = {s.name for s in expression.free_symbols}
    return text if present >= set(coordinates) else f"{text} + 0.0*({' + '.join(coordinates)})"


def margin_method(
    walls: Sequence[Any], coordinates: Sequence[str], lines: Assignments, *, covered: bool = False
) -> str:
    """Return the margin: the least of the walls, 1 where there is none; `covered` where they depend on all
    coordinates.
    """
    import sympy

    texts = lines.add(walls) if walls else ["1.0"]
    text = texts[0]
    for other in texts[1:]:
        text = f"np.minimum({text}, {other})"
    whole = sympy.Tuple(*walls)
    doc = (
        "Return a number that is positive where the potential lives."
        if walls
        else "Return 1: the potential lives everywhere."
    )
    return method(
        "margin", coordinates, doc, lines, [text if covered else spread(whole, text, coordinates)], single=True
    )


def poles_methods(poles: Sequence[Any], names: Sequence[str]) -> list[str]:
    """Return the method of `poles` where there are some."""
    lines = Assignments(names)
    doc = "Return numbers whose whole parts an orbit keeps: they change at poles."
    return [method("poles", names, doc, lines, lines.add(poles))] if poles else []


def _bounds(d: Description, walls: Sequence[Any]) -> list[str]:
    """Return the methods of the domain of a potential of A and B: its margin, its poles."""
    return [margin_method(walls, ("A", "B"), Assignments(("A", "B"))), *poles_methods(d.poles, ("A", "B"))]


# --- doubly isotropic potentials ------------------------------------------------------------------------------------

_ISOTROPIC = "a doubly isotropic potential of A = alpha^2, B = beta^2"


def potential(d: Description, V: Any, walls: Sequence[Any], s: dict[str, Any], *, clamp: bool) -> str:
    """Return the text of a potential V(A, B) with value, slopes, curvatures and margin; `clamp` keeps alpha above
    2^-17.
    """
    A = s["A"]
    B = s["B"]
    V_A = V.diff(A)
    V_B = V.diff(B)
    methods = []
    for name, doc, results in (
        ("value", "Return V.", [V]),
        ("slopes", "Return V_A, V_B.", [V_A, V_B]),
        ("curvatures", "Return V_AA, V_AB, V_BB.", [V_A.diff(A), V_A.diff(B), V_B.diff(B)]),
    ):
        lines = Assignments(("A", "B"))
        lines.lines += [f"A = np.maximum(A, {2.0**-34!r})"] if clamp and name != "value" else []
        texts = [
            spread(e, text, ("A", "B")) if not e.free_symbols & {A, B} else text
            for e, text in zip(results, lines.add(results), strict=True)
        ]
        methods.append(method(name, ("A", "B"), doc, lines, texts, single=name == "value"))
    methods += _bounds(d, walls)
    return module(d, class_text("FormulaPotential", _ISOTROPIC, d, d.parameters, methods))


NODES = (
    (0.2386191860831969, 0.4679139345726910),
    (0.6612093864662645, 0.3607615730481386),
    (0.9324695142031521, 0.1713244923791704),
)
"""Positive nodes and weights of Gauss and Legendre's rule with six points."""

_ROOTS = """\
alpha, beta = {alpha}, np.sqrt(B)
near = {near}
far, inner, choice = np.maximum(beta, near), np.minimum(beta, near), 1.0*(beta < near)
"""


class _Start(NamedTuple):
    """Beginning of a method of V(A, B): its lines, the names that are taken, and the symbols alpha, beta and far, a
    beta that is kept away from 0.
    """

    lines: list[str]
    taken: tuple[str, ...]
    alpha: Any
    beta: Any
    far: Any

    def begun(self) -> Assignments:
        """Return the lines of a new method."""
        lines = Assignments(self.taken)
        lines.lines += self.lines
        return lines


def even_potential(d: Description, g: Any, walls: Sequence[Any], s: dict[str, Any], even_alpha: bool) -> str:
    """Return the text of a potential g(alpha, beta) that is even in beta but has no formula in B.

    V_B = g'/(2 beta) and V_BB are 0/0 at beta = 0. For beta < alpha/64 they are the integrals over t from 0 to 1 of
    g''(t beta)/2 and (1 - t^2) g''''(t beta)/8, by Gauss's rule with six points: relative error (1/128)^12 where g is
    analytic up to beta = alpha. Where g is even in alpha too, alpha is kept above 2^-17: forces are then right to
    rounding.
    """
    import sympy

    alpha, beta = s["alpha"], s["beta"]
    roots = _ROOTS.format(
        alpha=f"np.sqrt(np.maximum(A, {2.0**-34!r}))" if even_alpha else "np.sqrt(A)",
        near="(alpha + 0.25)/64" if even_alpha else "alpha/64",
    ).splitlines()
    taken = ("A", "B", "alpha", "beta", "near", "far", "inner", "choice")
    start = _Start(roots, taken, alpha, beta, sympy.Symbol("far", positive=True))
    g_bb = g.diff(beta).diff(beta)

    def helper(name: str, doc: str, results: Sequence[Any]) -> str:
        lines = Assignments(("alpha", "beta"))
        return method(name, ("alpha", "beta"), doc, lines, lines.add(results), single=len(results) == 1)

    lines = Assignments(("A", "B", "alpha", "beta"))
    lines.lines += ["alpha, beta = np.sqrt(A), np.sqrt(B)"]
    higher = "Return that derivative's slope in alpha, and the fourth derivative in beta."
    methods = [
        method("value", ("A", "B"), "Return V.", lines, lines.add([g]), single=True),
        _even_slopes(g, start),
        _even_curvatures(g, start),
        helper("second", "Return the second derivative in beta.", [g_bb]),
        helper("higher", higher, [g_bb.diff(alpha), g_bb.diff(beta, 2)]),
        *_bounds(d, walls),
    ]
    return module(d, class_text("FormulaPotential", _ISOTROPIC, d, d.parameters, methods))


def _even_slopes(g: Any, start: _Start) -> str:
    """Return the text of V_A, V_B, with the mean of `second` near beta = 0."""
    lines = start.begun()
    alpha = start.alpha
    far = start.far
    g_a = g.diff(alpha)
    g_b = g.diff(start.beta)
    texts = lines.add([g_a / (2 * alpha), g_b.xreplace({start.beta: far}) / (2 * far)])
    nodes = " + ".join(f"{w / 2!r}*self.second(alpha, {t!r}*inner)" for t, w in NODES)
    lines.lines.append(f"limit = {nodes}")
    results = [texts[0], f"choice*limit + (1.0 - choice)*({texts[1]})"]
    return method("slopes", ("A", "B"), "Return V_A, V_B.", lines, results)


def _even_curvatures(g: Any, start: _Start) -> str:
    """Return the text of V_AA, V_AB, V_BB, with means of `higher` near beta = 0."""
    lines = start.begun()
    alpha = start.alpha
    beta = start.beta
    far = start.far
    g_a = g.diff(alpha)
    g_b = g.diff(beta)
    at = {beta: far}
    texts = lines.add(
        [
            (g_a.diff(alpha) - g_a / alpha) / (4 * alpha**2),
            g_a.diff(beta).xreplace(at) / (4 * alpha * far),
            (g_b.diff(beta).xreplace(at) - g_b.xreplace(at) / far) / (4 * far**2),
        ]
    )
    for k, (t, _) in enumerate(NODES):
        lines.lines.append(f"mixed{k}, fourth{k} = self.higher(alpha, {t!r}*inner)")
    mixed = " + ".join(f"{w / 4!r}*mixed{k}" for k, (_, w) in enumerate(NODES))
    fourth = " + ".join(f"{w * (1 - t * t) / 8!r}*fourth{k}" for k, (t, w) in enumerate(NODES))
    results = [
        texts[0],
        f"choice*({mixed})/alpha + (1.0 - choice)*({texts[1]})",
        f"choice*({fourth}) + (1.0 - choice)*({texts[2]})",
    ]
    return method("curvatures", ("A", "B"), "Return V_AA, V_AB, V_BB.", lines, results)


RING = 14
"""Points on a quarter of the circle for the evaluation of a potential that is 0/0 at beta = 0."""


def ring_potential(d: Description, g: Any, walls: Sequence[Any], s: dict[str, Any], even_alpha: bool) -> str:
    """Return the text of a potential g(alpha, beta), even in beta, that is finite but 0/0 at beta = 0.

    For beta < alpha/4 it and its derivatives are Cauchy's integrals over the circle |beta| = alpha/2 in the complex
    plane, by the trapezoidal rule with 4 RING = 56 points; by symmetry a quarter of them is enough. The relative error
    is 2^-56 where g is analytic up to |beta| = alpha.
    Source: Trefethen & Weideman 2014, SIAM Rev. 56, 385.
    """
    import sympy

    alpha, beta = s["alpha"], s["beta"]
    lines = [
        f"alpha, beta = {f'np.sqrt(np.maximum(A, {2.0**-34!r}))' if even_alpha else 'np.sqrt(A)'}, np.sqrt(B)",
        "near = alpha/4",
        "far, choice = np.maximum(beta, near), 1.0*(beta < near)",
        "u = 4*np.minimum(beta, near)**2/(alpha*alpha)",
    ]
    taken = ("A", "B", "alpha", "beta", "near", "far", "choice", "u")
    start = _Start(lines, taken, alpha, beta, sympy.Symbol("far", positive=True))
    methods = []
    for count, (name, (doc, beyond, near)) in enumerate(_ring_results(g, start).items()):
        own = start.begun()
        texts = own.add(beyond)
        own.lines += _on_ring(count)
        chosen = [f"choice*({inner}) + (1.0 - choice)*({outer})" for inner, outer in zip(near, texts, strict=True)]
        methods.append(method(name, ("A", "B"), doc, own, chosen, single=name == "value"))
    own = Assignments(("alpha", "beta"))
    doc = "Return V of a complex beta, and its first and second derivatives in alpha."
    g_a = g.diff(alpha)
    methods.append(method("ring", ("alpha", "beta"), doc, own, own.add([g, g_a, g_a.diff(alpha)])))
    methods += _bounds(d, walls)
    return module(d, class_text("FormulaPotential", _ISOTROPIC, d, d.parameters, methods))


def _on_ring(count: int) -> list[str]:
    """Return the lines of V on the ring with its derivatives in alpha, and of the weights of `count` powers."""
    lines = []
    for k in range(RING):
        turn = cmath.exp(1j * cmath.pi * (2 * k + 1) / (4 * RING))
        names = ", ".join(f"{name}{k}" for name in ("g", "ga", "gaa"))
        lines.append(f"{names} = self.ring(alpha, {turn / 2!r}*alpha)")
        lines.append(f"v{k} = 1.0/(1.0 - {turn**-2!r}*u)")
        for power in range(2, count + 2):
            lines.append(f"v{k}_{power} = {'*'.join([f'v{k}'] * power)}*{turn ** (2 - 2 * power)!r}")
    return lines


def _mean(name: str, power: int) -> str:
    """Return the text of the mean over the ring of values with a power of the weight."""
    weight = [f"v{k}" if power == 1 else f"v{k}_{power}" for k in range(RING)]
    return "(" + " + ".join(f"({name}{k}*{w}).real" for k, w in enumerate(weight)) + f")/{RING}"


def _ring_results(g: Any, start: _Start) -> dict[str, tuple[str, list[Any], list[str]]]:
    """Return, by the name of the method, its docstring, its results at far, and their texts by means over the ring."""
    alpha = start.alpha
    beta = start.beta
    far = start.far
    at = {beta: far}
    g_a = g.diff(alpha)
    g_aa = g_a.diff(alpha)
    g_b = g.diff(beta)
    g_ab = g_a.diff(beta)
    g_bb = g.diff(beta, 2)
    slope = _mean("ga", 1)
    square = "(alpha*alpha)"
    return {
        "value": ("Return V.", [g.xreplace(at)], [_mean("g", 1)]),
        "slopes": (
            "Return V_A, V_B.",
            [g_a.xreplace(at) / (2 * alpha), g_b.xreplace(at) / (2 * far)],
            [f"0.5*{slope}/alpha", f"4*{_mean('g', 2)}/{square}"],
        ),
        "curvatures": (
            "Return V_AA, V_AB, V_BB.",
            [
                (g_aa.xreplace(at) - g_a.xreplace(at) / alpha) / (4 * alpha**2),
                g_ab.xreplace(at) / (4 * alpha * far),
                (g_bb.xreplace(at) - g_b.xreplace(at) / far) / (4 * far**2),
            ],
            [
                f"0.25*({_mean('gaa', 1)} - {slope}/alpha)/{square}",
                f"2*{_mean('ga', 2)}/(alpha*{square})",
                f"32*{_mean('g', 3)}/({square}*{square})",
            ],
        ),
    }
