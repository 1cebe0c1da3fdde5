"""Source text of systems given by their rates: autonomous ones dz/dt = f(z), and H(q, p)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .inertia import fresh
from .model_source import loops, period_methods, periods_methods, poles_methods
from .potential_source import Description, class_text, constant, margin_method, method, module, spread
from .printing import Assignments


def ode_model(
    d: Description,
    rates: Sequence[Any],
    bounds: tuple[Sequence[Any], Sequence[Any]],
    symbols: dict[str, Any],
    periods: Sequence[Any],
) -> str:
    """Return the text of a system with its rates, their changes along a vector, its margin, its poles and the periods
    of its rows, if it has some; bounds: its walls, and expressions that pass a whole number at its poles.
    """
    names = d.coordinates
    walls, poles = bounds
    methods = [
        constant("degrees_of_freedom", "Return half the rows of a state in memory.", str((len(names) + 1) // 2)),
        constant("kind", "Return Kind.FLOW: neither coordinates with momenta, nor an energy.", "Kind.FLOW"),
        constant("coordinates", f"Names of the {len(names)} rows of z.", repr(tuple(names))),
        *_methods_of_rates(names, d.parameters, rates, walls, symbols),
        *poles_methods(poles, names),
        *periods_methods(periods),
    ]
    what = f"an autonomous system of {len(names)} variable{'' if len(names) == 1 else 's'}"
    body = class_text("FormulaODE", what, d, d.parameters, methods)
    text = module(d, body, "\nfrom fastaff.systems.models.contracts import Kind\n")
    return text.replace('"""V = ', '"""')


def nonseparable_model(
    d: Description,
    H: Any,
    bounds: tuple[Sequence[Any], Sequence[Any]],
    symbols: dict[str, Any],
    momenta: Sequence[str],
    periods: Sequence[Any],
    period: Any = None,
) -> str:
    """Return the text of a system H(q, p): its energy, rates, their changes along a vector, margin, poles and angles;
    symbols: of coordinates, then of momenta; bounds: its walls, and expressions that pass a whole number at its poles.
    With the period of a drive, "" for a field, the last coordinate is the time, and its momentum is added to H.
    """
    n = len(d.coordinates)
    names = (*d.coordinates, *momenta)
    driven = period is not None
    walls, poles = bounds
    q, p = ([symbols[name] for name in part] for part in (d.coordinates, momenta))
    H = H + p[-1] if driven else H
    rates = [*(H.diff(x) for x in p), *(-H.diff(x) for x in q)]
    lines = Assignments(names)
    own = Assignments(names)
    energy = spread(H, lines.add([H])[0], names)
    methods = [
        constant("degrees_of_freedom", f"Return {n}.", str(n)),
        constant("coordinates", f"Names of the first {n} rows of z.", repr(tuple(d.coordinates))),
        constant("momenta", f"Names of the last {n} rows of z.", repr(tuple(momenta))),
        constant("angles", "Angle variables natural to this system.", f"Loops({'2*np.pi/self.period' * driven})"),
        method("periods", (), "Return the periods of the rows, 0 where there is none.", own, own.add(periods)),
        method("energy", names, "Return H.", lines, [energy], single=True),
        *_methods_of_rates(names, d.parameters, rates, walls, symbols, shared=not walls),
    ]
    methods += poles_methods(poles, names)
    kind = 'Kind("H(q, p, t) with a period in t", {"nonseparable", "drive"})'
    fields = d.parameters
    if not driven:
        kind = "Kind.NONSEPARABLE"
    else:
        fields, more = period_methods(d.coordinates[-1], period, fields)
        methods += more
    methods.append(constant("kind", "What the motion is made of.", kind))
    what = f"{n - driven} degrees of freedom{', driven' if driven else ''}"
    body = loops(d.coordinates, time=driven) + class_text("FormulaHamiltonian", what, d, fields, methods)
    return module(d, body, "\nfrom fastaff.systems.models.contracts import Kind\n").replace('"""V = ', '"""H = ')


def _methods_of_rates(
    names: Sequence[str],
    parameters: Sequence[str],
    rates: Sequence[Any],
    walls: Sequence[Any],
    symbols: dict[str, Any],
    *,
    shared: bool = False,
) -> list[str]:
    """Return the methods rates, tangent_rates and margin of variables with these names; `shared`: see `_of_sums`."""
    import sympy

    changes = dict(zip(names, fresh("d", names, parameters), strict=True))
    along = {name: sympy.Symbol(text, real=True) for name, text in changes.items()}
    taken = (*names, *changes.values())

    def listed(name: str, doc: str, arguments: Sequence[str], expressions: Sequence[Any]) -> str:
        lines = Assignments(taken)
        texts = lines.add(_of_sums(lines, expressions) if shared else expressions)
        varied = {*symbols.values(), *along.values()}
        kept = [
            text if expression.free_symbols & varied else f"{text} + 0.0*{arguments[0]}"
            for text, expression in zip(texts, expressions, strict=True)
        ]
        return method(name, arguments, doc, lines, kept)

    tangent = [sympy.sympify(sum(rate.diff(symbols[name]) * along[name] for name in names)) for rate in rates]
    doc = f"Return the change of the rates along ({', '.join(changes.values())})."
    return [
        listed("rates", "Return dz/dt.", names, rates),
        listed("tangent_rates", doc, (*names, *changes.values()), tangent),
        margin_method(walls, names, Assignments(taken)),
    ]


def _of_sums(lines: Assignments, expressions: Sequence[Any]) -> list[Any]:
    """Return the expressions with sin and cos of sums of two angles expanded, where those of the angles occur too: a
    few products replace a sine and a cosine, which take most of a pendulum's time.

    The sine of a sum that nearly vanishes is only as exact as the angles are: not for formulas with poles.
    """
    import sympy

    found = {f.args[0] for e in expressions for f in e.atoms(sympy.sin, sympy.cos)}
    angles = sorted(found, key=lambda angle: (len(sympy.Add.make_args(angle)), sympy.default_sort_key(angle)))
    known: dict[Any, Any] = {}

    def named(text: str) -> Any:
        return sympy.Symbol(lines.assign("a", text), real=True)

    def parts(angle: Any) -> list[Any]:
        for f in (sympy.sin(angle), sympy.cos(angle)):
            if f not in known:
                known[f] = named(lines.add([f])[0])
        return [known[sympy.sin(angle)], known[sympy.cos(angle)]]

    for number, angle in enumerate(angles):
        size = len(sympy.Add.make_args(angle))
        shorter = [a for a in angles[:number] if len(sympy.Add.make_args(a)) < size]
        pairs = ((a, b, sign) for a in shorter for b in shorter for sign in (1, -1) if angle == a + sign * b)
        if pair := next(pairs, None):
            s1, c1 = parts(pair[0])
            s2, c2 = parts(pair[1])
            sign = "+" if pair[2] > 0 else "-"
            known[sympy.sin(angle)] = named(f"{s1}*{c2} {sign} {c1}*{s2}")
            known[sympy.cos(angle)] = named(f"{c1}*{c2} {'-' if pair[2] > 0 else '+'} {s1}*{s2}")
    return [e.xreplace(known) for e in expressions]
