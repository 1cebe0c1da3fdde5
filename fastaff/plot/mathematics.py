"""Formulas and numbers as mathematics for titles and captions; nothing is computed, an unknown text stays as it is."""

from __future__ import annotations

import ast
import re

from .style import symbol

SUM, PRODUCT, SIGN, POWER, ATOM = range(5)
"""Precedence of the parts of a formula."""
MARKS = {ast.Add: "+", ast.Sub: "-"}
INVERSE = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "log": "ln"}


def mathematics(text: str) -> str:
    """Return a formula in the syntax of Python as TeX, without dollars; another text is returned as it is."""
    try:
        return _tex(ast.parse(text.replace("^", "**").strip(), mode="eval").body)[0]
    except (SyntaxError, ValueError, RecursionError):
        return rf"\mathrm{{{text}}}" if re.fullmatch(r"[\w .]*", text) else text


def terms(text: str) -> list[str]:
    """Return the terms of a formula as TeX, each with its sign but for a first +: lines are broken between them."""
    try:
        node = ast.parse(text.replace("^", "**").strip(), mode="eval").body
        parts: list[str] = []
        while isinstance(node, ast.BinOp) and type(node.op) in MARKS:
            parts.append(MARKS[type(node.op)] + _inside(node.right, PRODUCT))
            node = node.left
        return [_tex(node)[0], *reversed(parts)]
    except (SyntaxError, ValueError, RecursionError):
        return [mathematics(text)]


def number(value: float, digits: int = 6) -> str:
    """Return a number as TeX, without dollars: powers of ten as such."""
    text = f"{value:.{digits}g}"
    mantissa, e, power = text.partition("e")
    if not e:
        return text
    ten = f"10^{{{int(power)}}}"
    if mantissa == "1":
        return ten
    if mantissa == "-1":
        return "-" + ten
    return rf"{mantissa}\times{ten}"


def _inside(node: ast.expr, level: int) -> str:
    text, own = _tex(node)
    if own >= level:
        return text
    if r"\frac" in text:
        return rf"\left({text}\right)"
    return f"({text})"


def _tex(node: ast.expr) -> tuple[str, int]:
    """Return the TeX of a part of a formula and its precedence."""
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return number(node.value), ATOM
    if isinstance(node, ast.Name):
        return (r"\pi" if node.id == "pi" else symbol(node.id)), ATOM
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        sign = "-" if isinstance(node.op, ast.USub) else ""
        return sign + _inside(node.operand, PRODUCT), SIGN if sign else PRODUCT
    if isinstance(node, ast.BinOp):
        return _operation(node)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1:
        inner = _tex(node.args[0])[0]
        name = node.func.id
        if name == "sqrt":
            return rf"\sqrt{{{inner}}}", ATOM
        if name == "exp":
            return rf"e^{{{inner}}}", POWER
        brackets = (r"\left(", r"\right)") if r"\frac" in inner else ("(", ")")
        return rf"\{INVERSE.get(name, name)}" + inner.join(brackets), POWER
    raise ValueError("no formula")


def _operation(node: ast.BinOp) -> tuple[str, int]:
    if type(node.op) in MARKS:
        return _tex(node.left)[0] + MARKS[type(node.op)] + _inside(node.right, PRODUCT), SUM
    if isinstance(node.op, ast.Mult):
        left = _inside(node.left, PRODUCT)
        right = _inside(node.right, POWER)
        return left + (r"\cdot " if right[0].isdigit() else r"\,") + right, PRODUCT
    if isinstance(node.op, ast.Div):
        top = node.left
        bottom = node.right
        if isinstance(top, ast.UnaryOp) and isinstance(top.op, ast.USub):
            return "-" + _operation(ast.BinOp(top.operand, node.op, bottom))[0], SIGN
        if isinstance(top, ast.Constant) and isinstance(bottom, ast.Constant):
            return f"{_tex(top)[0]}/{_tex(bottom)[0]}", PRODUCT
        return rf"\frac{{{_tex(top)[0]}}}{{{_tex(bottom)[0]}}}", PRODUCT
    if isinstance(node.op, ast.Pow):
        exponent = _tex(node.right)[0]
        return f"{_inside(node.left, ATOM)}^{{{exponent}}}", POWER
    raise ValueError("no formula")


def wrapped(text: str, width: float) -> list[str]:
    """Return a text in lines of at most so many visible characters, broken at spaces outside of its mathematics."""
    lines: list[str] = []
    for word in re.findall(r"(?:\$[^$]*\$|[^\s$])+", text):
        if lines and visible(lines[-1]) + 1 + visible(word) <= width:
            lines[-1] += " " + word
        else:
            lines.append(word)
    return lines


def visible(text: str) -> int:
    """Return the approximate number of visible characters of a text with mathematics."""
    seen = re.sub(r"\\(frac|left|right|mathrm|,|;)", "", text)
    return len(re.sub(r"\\[A-Za-z]+", "x", seen).translate(str.maketrans("", "", "{}$^_")))
