"""Descriptions of parts outside of the grammar of formulas, with alternatives."""

from __future__ import annotations

import ast

SIGNS = {
    **dict.fromkeys("'\"`", "a string"),
    **dict.fromkeys("[]", "a subscript or list"),
    **dict.fromkeys("{}", "a set or dictionary"),
    **dict.fromkeys("<>!", "a comparison"),
    "=": "an assignment or comparison",
    ":": "a colon (lambda, slice or assignment)",
    "#": "a comment",
    ";": "a second statement",
    "\\": "a backslash",
    "%": "the operator %",
    "@": "the operator @",
    "&": "the operator &",
    "|": "the operator |",
    "~": "the operator ~",
    "\0": "a null byte",
}
SPELLINGS = {
    "α": "alpha",
    "β": "beta",
    "ϑ": "vartheta",
    "θ": "vartheta",
    "ρ": "rho",
    "π": "pi",
    "²": "**2",
    "³": "**3",
    "·": "*",
    "×": "*",
    "−": "-",
    "–": "-",
    "÷": "/",
    "√": "sqrt(...)",
}
ADVICE = {
    "abs": "Use sqrt(q**2 + small**2), which is smooth at 0.",
    "ln": "Use log, the natural logarithm.",
    "sign": "Use a smooth function such as tanh(x/small).",
    "arcsin": "Use asin.",
    "arccos": "Use acos.",
    "arctan": "Use atan.",
    "atan2": "Use atan.",
    "cbrt": "Use (...)**(1/3).",
    "pow": "Use **.",
    "max": "Use a smooth function, such as one of sqrt.",
    "min": "Use a smooth function, such as one of sqrt.",
}
FOUND: dict[type, str] = {
    ast.Attribute: "attribute access",
    ast.Subscript: "a subscript",
    ast.Compare: "a comparison",
    ast.Lambda: "a lambda",
    ast.ListComp: "a comprehension",
    ast.SetComp: "a comprehension",
    ast.DictComp: "a comprehension",
    ast.GeneratorExp: "a comprehension",
    ast.NamedExpr: "an assignment",
    ast.IfExp: "a condition",
    ast.BoolOp: "a logical operator",
    ast.Tuple: "a comma",
    ast.Await: "await",
    ast.Yield: "yield",
    ast.YieldFrom: "yield",
    ast.Starred: "a star",
    ast.JoinedStr: "a string",
}
