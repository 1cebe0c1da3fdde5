"""Models as JavaScript: their scalar methods, printed from their Python source by a whitelist of its syntax.

Models of the package, classes made from formulas and a user's NamedTuples go the same way. Calls of other methods of
the model are written out, so that each method is a sequence of statements; parameters stay values. The names in a
record are fixed: coordinates q0, q1, ..., momenta p0, ..., a tangent vector d0, ...
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import shown
from .parameters import fields_of, parameter_name

FUNCTIONS = {
    **{name: f"Math.{name}" for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "hypot")},
    **{name: f"Math.{name}" for name in ("log1p", "expm1", "log2", "log10", "cbrt", "sign", "floor", "ceil")},
    **{f"arc{name}": f"Math.a{name}" for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "tan2")},
    **{f"a{name}": f"Math.a{name}" for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "tan2")},
    **dict.fromkeys(("abs", "absolute", "fabs"), "Math.abs"),
    **dict.fromkeys(("minimum", "min", "fmin"), "Math.min"),
    **dict.fromkeys(("maximum", "max", "fmax"), "Math.max"),
    **dict.fromkeys(("pow", "power"), "Math.pow"),
}
"""Elementary functions of numpy and math, and their names in JavaScript."""

_BINARY: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_COMPARED: dict[type, str] = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "===",
    ast.NotEq: "!==",
}
_WRITTEN_OUT = 4
"""Powers up to this one are products."""


class ScriptText(str):
    """An expression in JavaScript: a name, a number or something in parentheses."""


class ScriptPart(NamedTuple):
    """The model, or a value inside of it, and its path: the names of the fields."""

    value: Any
    path: tuple[str, ...]


class Refused(TypeError):
    """Raised for a construct that cannot be printed: one sentence that names it."""


def printed(part: ScriptPart, name: str, arguments: list[str], parameters: list[str]) -> dict[str, Any]:
    """Return lines and results of one method with those arguments."""
    work = _Printer(parameters)
    value = work.called(part, name, [ScriptText(argument) for argument in arguments])
    results = list(value) if isinstance(value, tuple) else [value]
    return {"lines": work.lines, "results": [work.number(result) for result in results]}


class _Printer:
    """Lines of JavaScript under way."""

    def __init__(self, parameters: list[str]):
        self.parameters = parameters
        self.count = 0
        self.depth = 0
        self.lines: list[str] = []

    def fresh(self, stem: str) -> ScriptText:
        """Return a name that nothing else has."""
        self.count += 1
        return ScriptText(f"{stem}${self.count}")

    def called(self, part: ScriptPart, name: str, arguments: list[Any]) -> Any:
        """Return the value of a method of the model, written out."""
        function = getattr(type(part.value), name, None)
        if isinstance(function, property):
            function = function.fget
        function = inspect.unwrap(function) if function is not None else None
        if not isinstance(function, FunctionType):
            raise Refused(f"{type(part.value).__name__} has no method {name} in Python to print as JavaScript")
        definition = _definition(function)
        wanted = [argument.arg for argument in definition.args.args]
        plain = not (definition.args.vararg or definition.args.kwarg or definition.args.kwonlyargs)
        if not plain or len(wanted) != len(arguments) + 1:
            raise self.refused(definition, f"the arguments of {name}")
        self.depth += 1
        if self.depth > 20:
            raise self.refused(definition, "a method that calls itself")
        values = {wanted[0]: part, **dict(zip(wanted[1:], arguments))}
        scope = _Scope(self, function, values)
        found = scope.block(definition.body)
        self.depth -= 1
        if found is None:
            raise self.refused(definition, f"the end of {name} without a return")
        return found

    def assign(self, stem: str, value: Any) -> Any:
        """Give a value a name in a line; names and numbers need none, tuples one for each entry."""
        if isinstance(value, tuple) and not isinstance(value, ScriptPart):
            return tuple(self.assign(stem, entry) for entry in value)
        if not isinstance(value, ScriptText) or value.replace("$", "_").isidentifier():
            return value
        name = self.fresh(stem)
        self.lines.append(f"const {name} = {value};")
        return name

    def number(self, value: Any) -> ScriptText:
        """Return a value as the text of a number."""
        if isinstance(value, ScriptText):
            return value
        if isinstance(value, (bool, np.bool_)):
            return ScriptText("1" if value else "0")
        if isinstance(value, (int, float, np.floating, np.integer)):
            if math.isinf(value) or math.isnan(value):
                return ScriptText("NaN" if math.isnan(value) else "Infinity" if value > 0 else "(-Infinity)")
            text = repr(float(value)).removesuffix(".0")
            return ScriptText(text if value >= 0 and not text.startswith("-") else f"({text})")
        raise Refused(f"a value of type {type(value).__name__} cannot be printed as a number of JavaScript")

    @staticmethod
    def refused(node: ast.AST, what: str) -> Refused:
        """Return the error for a construct."""
        return Refused(f"{what} cannot be printed as JavaScript (line {getattr(node, 'lineno', 0)} of the method)")


class _Scope:
    """One call of a method: its names, and the values of its statements."""

    def __init__(self, printer: _Printer, function: FunctionType, names: dict[str, Any]):
        self.printer = printer
        self.function = function
        self.names = names

    def block(self, statements: Sequence[ast.stmt]) -> Any:
        """Write statements; return the value of a return, None where there is none."""
        for k, statement in enumerate(statements):
            if isinstance(statement, ast.Return):
                if statement.value is None:
                    raise self.printer.refused(statement, "a return without a value")
                return self.value(statement.value)
            if isinstance(statement, ast.If):
                rest = statements[k + 1 :]
                if any(isinstance(node, ast.Return) for node in ast.walk(statement)):
                    return self.either(statement, [*statement.body, *rest], [*statement.orelse, *rest])
                self.branches(statement)
            else:
                self.statement(statement)
        return None

    def statement(self, node: ast.stmt) -> None:
        """Write an assignment."""
        if isinstance(node, ast.Assign):
            value = self.value(node.value)
            for target in node.targets:
                self.bind(target, value)
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            self.bind(node.target, self.value(node.value))
        elif isinstance(node, ast.AugAssign):
            if not isinstance(node.target, ast.Name):
                raise self.printer.refused(node, "an assignment to what is no name")
            before = ast.copy_location(ast.Name(node.target.id, ast.Load()), node)
            whole = ast.copy_location(ast.BinOp(before, node.op, node.value), node)
            self.bind(node.target, self.value(whole))
        elif not (isinstance(node, ast.Pass) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))):
            raise self.printer.refused(node, f"Python's {type(node).__name__}")

    def bind(self, target: ast.expr, value: Any) -> None:
        """Give a value the names of a target."""
        if isinstance(target, ast.Name):
            self.names[target.id] = self.printer.assign(target.id, value)
        elif isinstance(target, (ast.Tuple, ast.List)) and type(value) is tuple and len(value) == len(target.elts):
            for entry, part in zip(target.elts, [self.printer.assign("t", v) for v in value]):
                self.bind(entry, part)
        else:
            raise self.printer.refused(target, "an assignment of other than names and tuples of them")

    def either(self, node: ast.If, first: list[ast.stmt], second: list[ast.stmt]) -> Any:
        """Write both ways to a return; return its value."""
        condition = self.value(node.test)
        if not isinstance(condition, ScriptText):
            return self.block(first if condition else second)
        yes, a = self.aside(first)
        no, b = self.aside(second)
        if a is None or b is None:
            raise self.printer.refused(node, "a condition with a return in one way only")
        values = tuple(map(self.printer.number, a if type(a) is tuple else (a,)))
        others = tuple(map(self.printer.number, b if type(b) is tuple else (b,)))
        if len(values) != len(others):
            raise self.printer.refused(node, "a condition whose ways return different numbers of values")
        names = [self.printer.fresh("r") for _ in values]
        self.joined(condition, yes, no, names, values, others)
        return tuple(names) if type(a) is tuple else names[0]

    def branches(self, node: ast.If) -> None:
        """Write a condition whose ways assign names."""
        condition = self.value(node.test)
        if not isinstance(condition, ScriptText):
            self.block(node.body if condition else node.orelse)
            return
        before = dict(self.names)
        yes, _ = self.aside(node.body)
        one = self.names
        self.names = dict(before)
        no, _ = self.aside(node.orelse)
        other = self.names
        changed = [name for name in one if name in other and one[name] != other[name]]
        names = [self.printer.fresh(name) for name in changed]
        values, others = ([self.printer.number(side[name]) for name in changed] for side in (one, other))
        self.joined(condition, yes, no, names, values, others)
        self.names = {**before, **dict(zip(changed, names))}

    def aside(self, statements: Sequence[ast.stmt]) -> tuple[list[str], Any]:
        """Return the lines of statements, which are not written, and their value."""
        kept = self.printer.lines
        names = dict(self.names)
        self.printer.lines = []
        value = self.block(statements)
        lines = self.printer.lines
        self.printer.lines = kept
        if value is not None:
            self.names = names
        return lines, value

    def joined(self, condition: str, yes: Sequence, no: Sequence, names: Sequence, one: Sequence, other: Sequence):
        """Write a condition that sets names."""
        first, second = (
            " ".join([*lines, *(f"{name} = {value};" for name, value in zip(names, values))])
            for lines, values in ((yes, one), (no, other))
        )
        let = f"let {', '.join(names)}; " if names else ""
        self.printer.lines.append(f"{let}if ({condition}) {{ {first} }} else {{ {second} }}")

    def value(self, node: ast.expr) -> Any:
        """Return the value of an expression: Text, a number, a tuple of those, or a part of the model."""
        found: Callable[[Any], Any] | None = getattr(self, f"on_{type(node).__name__}", None)
        if found is None:
            raise self.printer.refused(node, f"Python's {type(node).__name__}")
        return found(node)

    def text(self, node: ast.expr) -> ScriptText:
        """Return the text of a number."""
        value = self.value(node)
        if isinstance(value, (tuple, ScriptPart)) or isinstance(value, str) != isinstance(value, ScriptText):
            raise self.printer.refused(node, "a value that is no number")
        return self.printer.number(value)

    def on_Constant(self, node: ast.Constant) -> Any:
        """Return a number."""
        if isinstance(node.value, complex) or not isinstance(node.value, (int, float)):
            raise self.printer.refused(node, f"the constant {shown(node.value)}")
        return node.value

    def on_Name(self, node: ast.Name) -> Any:
        """Return the value of a name: a variable, or a number beside the class."""
        if node.id in self.names:
            return self.names[node.id]
        value = _outside(self.function).get(node.id)
        if isinstance(value, (int, float, tuple)):
            return value
        raise self.printer.refused(node, f"the name {node.id}")

    def on_Tuple(self, node: ast.Tuple) -> Any:
        """Return a tuple, in which others may be spread."""
        found: list[Any] = []
        for entry in node.elts:
            if isinstance(entry, ast.Starred):
                found += self.value(entry.value)
            else:
                found.append(self.value(entry))
        return tuple(found)

    def on_Attribute(self, node: ast.Attribute) -> Any:
        """Return a parameter, a part, a property or a constant of the class."""
        if isinstance(node.value, ast.Name) and node.value.id in ("np", "math", "numpy"):
            constant = getattr(math, node.attr, None)
            if isinstance(constant, float):
                return constant
        owner = self.value(node.value)
        if not isinstance(owner, ScriptPart):
            raise self.printer.refused(node, f"the attribute .{node.attr}")
        if isinstance(getattr(type(owner.value), node.attr, None), property):
            return self.printer.called(owner, node.attr, [])
        if not hasattr(owner.value, node.attr):
            raise self.printer.refused(node, f"the attribute .{node.attr}, which {type(owner.value).__name__} lacks,")
        return self.entry(node, owner, node.attr)

    def entry(self, node: ast.AST, owner: ScriptPart, name: str) -> Any:
        """Return a field as a parameter, an inner value or a constant."""
        value = getattr(owner.value, name)
        path = (*owner.path, name)
        if name in fields_of(owner.value) and isinstance(value, (int, float, np.floating, np.integer)):
            parameter = parameter_name(path)
            if parameter in self.printer.parameters:
                return ScriptText(f"${parameter}")
        if fields_of(value):
            return ScriptPart(value, path)
        if isinstance(value, (int, float, tuple)):
            return value
        raise self.printer.refused(node, f"the attribute .{name} of type {type(value).__name__}")

    def on_BinOp(self, node: ast.BinOp) -> Any:
        """Return an operation, computed now where both are numbers."""
        left, right = self.value(node.left), self.value(node.right)
        if type(left) is tuple and type(right) is tuple and isinstance(node.op, ast.Add):
            return left + right
        if not isinstance(left, (ScriptText, int, float)) or not isinstance(right, (ScriptText, int, float)):
            raise self.printer.refused(node, "arithmetic of other than numbers")
        if not isinstance(left, ScriptText) and not isinstance(right, ScriptText):
            return _computed(node, left, right, self.printer)
        if isinstance(node.op, ast.Pow):
            return self.power(left, right)
        sign = _BINARY.get(type(node.op))
        if sign is None:
            raise self.printer.refused(node, f"the operator {type(node.op).__name__}")
        return ScriptText(f"({self.printer.number(left)} {sign} {self.printer.number(right)})")

    def power(self, base: Any, exponent: Any) -> ScriptText:
        """Return a power: a product where it is small."""
        whole = isinstance(exponent, (int, float)) and float(exponent).is_integer()
        if whole and 1 <= abs(exponent) <= _WRITTEN_OUT and isinstance(base, ScriptText):
            name = self.printer.assign("b", base)
            product = "*".join([name] * abs(int(exponent)))
            return ScriptText(f"({product})" if exponent > 0 else f"(1/({product}))")
        return ScriptText(f"Math.pow({self.printer.number(base)}, {self.printer.number(exponent)})")

    def on_UnaryOp(self, node: ast.UnaryOp) -> Any:
        """Return a sign or a negation."""
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return ScriptText(f"(!{value})") if isinstance(value, ScriptText) else not value
        if isinstance(node.op, ast.Invert) or isinstance(value, (tuple, ScriptPart)):
            raise self.printer.refused(node, "the operator ~, or a sign of what is no number,")
        if isinstance(node.op, ast.UAdd):
            return value
        return ScriptText(f"(-{value})") if isinstance(value, ScriptText) else -value

    def on_Compare(self, node: ast.Compare) -> Any:
        """Return a chain of comparisons that must all hold."""
        values = [self.value(entry) for entry in (node.left, *node.comparators)]
        texts = []
        for first, op, second in zip(values, node.ops, values[1:]):
            if type(op) not in _COMPARED:
                raise self.printer.refused(node, f"the comparison {type(op).__name__}")
            texts.append(f"{self.printer.number(first)} {_COMPARED[type(op)]} {self.printer.number(second)}")
        return ScriptText(f"({' && '.join(texts)})")

    def on_BoolOp(self, node: ast.BoolOp) -> Any:
        """Return conditions joined by `and` or `or`."""
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return ScriptText(f"({sign.join(self.text(entry) for entry in node.values)})")

    def on_IfExp(self, node: ast.IfExp) -> Any:
        """Return one of two values."""
        condition = self.value(node.test)
        if not isinstance(condition, ScriptText):
            return self.value(node.body if condition else node.orelse)
        return ScriptText(f"({condition} ? {self.text(node.body)} : {self.text(node.orelse)})")

    def on_Subscript(self, node: ast.Subscript) -> Any:
        """Return an entry of a tuple."""
        value = self.value(node.value)
        index = self.value(node.slice)
        if type(value) is not tuple or not isinstance(index, int):
            raise self.printer.refused(node, "a subscript of other than a tuple with a fixed number")
        return value[index]

    def on_Call(self, node: ast.Call) -> Any:
        """Return an elementary function, or a method of the model written out."""
        if node.keywords or not isinstance(node.func, (ast.Attribute, ast.Name)):
            raise self.printer.refused(node, "a call with keywords, or of what is no name,")
        name = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
        if isinstance(node.func, ast.Attribute) and not (
            isinstance(node.func.value, ast.Name) and node.func.value.id in ("np", "math", "numpy")
        ):
            owner = self.value(node.func.value)
            if not isinstance(owner, ScriptPart):
                raise self.printer.refused(node, f"the call of .{name}")
            arguments: list[Any] = []
            for entry in node.args:
                value = self.value(entry.value if isinstance(entry, ast.Starred) else entry)
                arguments += value if isinstance(entry, ast.Starred) else [value]
            return self.printer.called(owner, name, [self.printer.assign("t", value) for value in arguments])
        if name == "float" and len(node.args) == 1:
            return self.value(node.args[0])
        if name == "square" and len(node.args) == 1:
            return self.power(self.text(node.args[0]), 2)
        if name == "where" and len(node.args) == 3:
            condition, yes, no = map(self.text, node.args)
            return ScriptText(f"({condition} ? {yes} : {no})")
        if name not in FUNCTIONS or any(isinstance(entry, ast.Starred) for entry in node.args):
            raise self.printer.refused(node, f"the call of {name}")
        return ScriptText(f"{FUNCTIONS[name]}({', '.join(map(self.text, node.args))})")


def _computed(node: ast.BinOp, left: Any, right: Any, printer: _Printer) -> Any:
    """Return an operation of two numbers."""
    operations: Mapping[type, Callable[[Any, Any], Any]] = {
        ast.Add: lambda a, b: a + b,
        ast.Sub: lambda a, b: a - b,
        ast.Mult: lambda a, b: a * b,
        ast.Div: lambda a, b: a / b,
        ast.Pow: lambda a, b: float(a) ** b,
    }
    if type(node.op) not in operations:
        raise printer.refused(node, f"the operator {type(node.op).__name__}")
    return operations[type(node.op)](left, right)


def _outside(function: FunctionType) -> dict[str, Any]:
    """Return the names that a function sees outside of itself."""
    closure = inspect.getclosurevars(function)
    return {**closure.globals, **closure.nonlocals}


def _definition(function: FunctionType) -> ast.FunctionDef:
    """Return the tree of a function."""
    try:
        text = textwrap.dedent(inspect.getsource(function))
        node = ast.parse(text).body[0]
    except (OSError, TypeError, SyntaxError, IndexError):
        raise Refused(
            f"the source of {function.__qualname__} is not at hand: a model for the explorer must be in a file"
        ) from None
    if not isinstance(node, ast.FunctionDef):
        raise Refused(f"{function.__qualname__} is no plain function, which alone can be printed as JavaScript")
    return node
