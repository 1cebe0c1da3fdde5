"""Source text of autonomous systems dz/dt = f(z)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .model_source import fresh
from .potential_source import Description, class_text, constant, margin_method, method, module
from .printing import Lines


def flow_model(d: Description, rates: Sequence[Any], walls: Sequence[Any], symbols: dict[str, Any]) -> str:
    """Return the text of a system with its rates, their changes along a vector, and its margin."""
    import sympy

    names = d.coordinates
    changes = dict(zip(names, fresh("d", names, d.parameters), strict=True))
    along = {name: sympy.Symbol(text, real=True) for name, text in changes.items()}
    taken = (*names, *changes.values())

    def listed(name: str, doc: str, arguments: Sequence[str], expressions: Sequence[Any]) -> str:
        lines = Lines(taken)
        texts = lines.add(expressions)
        varied = {*symbols.values(), *along.values()}
        kept = [
            text if expression.free_symbols & varied else f"{text} + 0.0*{arguments[0]}"
            for text, expression in zip(texts, expressions, strict=True)
        ]
        return method(name, arguments, doc, lines, kept)

    tangent = [sum(rate.diff(symbols[name]) * along[name] for name in names) for rate in rates]
    methods = [
        constant("degrees_of_freedom", "Return half the rows of a state in memory.", str((len(names) + 1) // 2)),
        constant("kind", "Return Kind.FLOW: neither coordinates with momenta, nor an energy.", "Kind.FLOW"),
        constant("coordinates", f"Names of the {len(names)} rows of z.", repr(tuple(names))),
        listed("rates", "Return dz/dt.", names, rates),
        listed(
            "tangent_rates",
            f"Return the change of the rates along ({', '.join(changes.values())}).",
            (*names, *changes.values()),
            [sympy.sympify(entry) for entry in tangent],
        ),
        margin_method(walls, names, Lines(taken)),
    ]
    what = f"an autonomous system of {len(names)} variable{'' if len(names) == 1 else 's'}"
    body = class_text("FormulaFlow", what, d, d.parameters, methods)
    text = module(d, body, "\nfrom fastaff.models.contracts import Kind\n")
    return text.replace('"""V = ', '"""')
