"""The grammar of formulas: a whitelist over Python's ast, turned into a postfix program that any arithmetic can run.

Nothing is ever executed: a text outside of the grammar raises ValueError with the part at fault, its place, and the
parts allowed.
"""

from __future__ import annotations

import ast
import contextlib
import difflib
import keyword
import math
import unicodedata
import warnings
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from ...core.numbers import listed, shown
from .gammainc import GAMMAINC, MOST_A, incomplete_gamma
from .outside import ADVICE, FOUND, SIGNS, SPELLINGS

FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "asin", "acos", "atan")
CONSTANTS = {"pi": math.pi}
MAX_LENGTH = 2000
"""Most characters of a formula."""

MAX_NODES = 1000
"""Most operations, names and numbers of a formula."""

MAX_DEPTH = 60
"""Most levels of nesting of a formula."""

MAX_EXPONENT = 64
"""Largest exponent, and largest product of nested exponents."""

ALLOWED = "Use numbers, names, pi, + - * / ** (or ^), parentheses and functions such as sqrt, exp and sin."
LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.+-*/^(), \t\n\r")
_BINARY: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
_OTHER_BINARY: dict[type, str] = {ast.FloorDiv: "//"}
NUMERIC: dict[str, Callable] = {**{name: getattr(math, name) for name in FUNCTIONS}, GAMMAINC: incomplete_gamma}
"""Functions of floats by name."""


TIME = "t"
"""Name of the time in the potentials of driven systems."""

TIME_HINT = "Use drive_period, such as drive_period='2*pi/w', for the time of a driven system."


class UnknownName(ValueError):
    """A formula has a name that is neither a variable nor a parameter; place: the sentence without the hint."""

    def __init__(self, place: str, name: str, hint: str):
        super().__init__(f"{place}. {hint}")
        self.place = place
        self.name = name
        self.hint = hint


class Operation(NamedTuple):
    """One step of a postfix program: kind is "number", "name", "call", "gammainc" (the operand: its first argument),
    "negate" or the sign of a binary operator.
    """

    kind: str
    operand: Any = None


class Program(NamedTuple):
    """A formula in postfix order, with the names that it uses."""

    operations: tuple[Operation, ...]
    names: frozenset[str]

    def run(
        self,
        number: Callable[[Fraction], Any],
        names: Mapping[str, Any],
        functions: Mapping[str, Callable],
        power: Callable,
    ) -> Any:
        """Run on any arithmetic: number(Fraction), the value of each name, functions by name, power(base, exponent)."""
        stack: list[Any] = []
        for kind, operand in self.operations:
            if kind == "number":
                stack.append(number(operand))
            elif kind == "name":
                stack.append(names[operand])
            elif kind == "call":
                stack.append(functions[operand](stack.pop()))
            elif kind == GAMMAINC:
                stack.append(functions[GAMMAINC](number(operand), stack.pop()))
            elif kind == "negate":
                stack.append(-stack.pop())
            else:
                right, left = stack.pop(), stack.pop()
                stack.append(_apply(kind, left, right, power))
        return stack.pop()


def _apply(kind: str, left: Any, right: Any, power: Callable) -> Any:
    if kind == "+":
        return left + right
    if kind == "-":
        return left - right
    if kind == "*":
        return left * right
    return left / right if kind == "/" else power(left, right)


def checked_name(name: str, what: str, taken: Iterable[str]) -> str:
    """Return `name` if it can name a parameter or a coordinate: a plain identifier that means nothing else."""
    if not isinstance(name, str):
        raise TypeError(f"{what} must be a name, got {shown(name)} ({type(name).__name__})")
    if (
        not (name.isascii() and name.isidentifier())
        or keyword.iskeyword(name)
        or name.startswith("_")
        or len(name) > 40
    ):
        raise ValueError(
            f"{what} must be an identifier of at most 40 ASCII letters, digits and _, starting with a letter, got "
            f"{shown(name)}"
        )
    if name in FUNCTIONS or name in CONSTANTS or name in ADVICE or name == GAMMAINC:
        raise ValueError(
            f"{what} {shown(name)} is the name of a function or constant of the grammar. Use another name."
        )
    if name in taken:
        raise ValueError(f"{what} {shown(name)} is taken by a variable or a part of the model. Use another name.")
    return name


def parse(
    text: str, variables: Iterable[str], parameters: Iterable[str], *, argument: str = "text", length: int = MAX_LENGTH
) -> Program:
    """Return the program of `text`, whose names are variables and parameters; ValueError for anything else."""
    reader = _Reader(text, tuple(variables), tuple(parameters), argument)
    reader.check_letters(length)
    root = reader.tree()
    operations = reader.postfix(root)
    reader.check_sizes(operations)
    names = frozenset(operation.operand for operation, _ in operations if operation.kind == "name")
    return Program(tuple(operation for operation, _ in operations), names)


class _Reader:
    """A text that is being parsed."""

    def __init__(self, text: str, variables: tuple[str, ...], parameters: tuple[str, ...], argument: str):
        if not isinstance(text, str):
            raise TypeError(
                f"{argument} must be a text such as 'C/2*(x**2 + y**2)', got {shown(text)} ({type(text).__name__})"
            )
        self.text = text
        self.variables = variables
        self.parameters = parameters
        self.argument = argument

    def refuse(self, found: str, column: int, hint: str = "") -> ValueError:
        """Return the error: the part at fault, its place, and the parts allowed."""
        return ValueError(f"{self.argument}: {found} at column {column}. {hint or ALLOWED}")

    def check_letters(self, length: int) -> None:
        """Refuse long texts, letters that no formula has and deep parentheses before Python's parser runs."""
        if len(self.text) > length:
            raise ValueError(f"{self.argument} must have at most {length} characters, got {len(self.text)}")
        if not self.text.strip():
            raise ValueError(f"{self.argument} must be a formula, got an empty text. {ALLOWED}")
        depth = 0
        for column, letter in enumerate(self.text, 1):
            if letter not in LETTERS:
                name = unicodedata.name(letter, "an unprintable character")
                found = SIGNS.get(letter) or f"the character {letter!r} ({name.lower()})"
                hint = f"Use {SPELLINGS[letter]}." if letter in SPELLINGS else ""
                raise self.refuse(found, column, hint)
            depth += (letter == "(") - (letter == ")")
            if depth < 0:
                raise self.refuse("a closing parenthesis without an opening one", column)
            if depth > MAX_DEPTH:
                raise self.refuse(f"parentheses nested deeper than {MAX_DEPTH}", column)

    def tree(self) -> ast.expr:
        """Return the tree of the text."""
        line = self.text.translate({ord(c): " " for c in "\t\n\r"})
        self.places = [at for at, letter in enumerate(line, 1) for _ in range(1 + (letter == "^"))]
        line = self.source = line.replace("^", "**")
        indent = len(line) - len(line.lstrip())
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                root = ast.parse("(" + line[indent:] + "\n)", mode="eval").body
        except SyntaxError as problem:
            column = self.place((problem.offset or 1) - 1 + indent) if problem.lineno == 1 else len(self.text)
            hint = (
                "Use * for a product."
                if "literal" in (problem.msg or "") or "forgot a comma" in (problem.msg or "")
                else ""
            )
            raise self.refuse(f"not one expression, {str(problem.msg).partition('.')[0][:80]}", column, hint) from None
        except (MemoryError, RecursionError, ValueError):
            raise self.refuse("an expression that is nested too deeply", 1) from None
        self.shift = indent  # of one parenthesis and the omitted spaces: columns start at 1
        return root

    def column(self, node: ast.AST) -> int:
        """Return the column at which a node starts, from 1."""
        return self.place(getattr(node, "col_offset", 0) + self.shift)

    def place(self, column: int) -> int:
        """Return the column in the user's text, where each ** may be a ^."""
        return self.places[max(1, min(len(self.places), column)) - 1]

    def postfix(self, root: ast.expr) -> list[tuple[Operation, int]]:
        """Return the operations of the tree and their columns, without recursion; refuse nodes outside of the
        grammar.
        """
        done: list[tuple[Operation, int]] = []
        pending: list[tuple[Any, int, int]] = [(root, 0, 0)]
        count = 0
        while pending:
            node, depth, column = pending.pop()
            if isinstance(node, Operation):
                done.append((node, column))
                continue
            count += 1
            column = self.column(node)
            if count > MAX_NODES:
                raise self.refuse(f"a formula of more than {MAX_NODES} parts", column)
            if depth > MAX_DEPTH:
                raise self.refuse(f"an expression nested deeper than {MAX_DEPTH}", column)
            if isinstance(node, ast.BinOp):
                kind = self.operator(node)
                chain = (
                    isinstance(node.left, ast.BinOp)
                    and kind in "+-*/"
                    and _BINARY.get(type(node.left.op), "**") in "+-*/"
                )
                pending.append((Operation(kind), depth, self.between(node)))
                pending.append((node.right, depth + 1, 0))
                pending.append((node.left, depth if chain else depth + 1, 0))
            elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
                if isinstance(node.op, ast.USub):
                    pending.append((Operation("negate"), depth, column))
                pending.append((node.operand, depth + 1, 0))
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == GAMMAINC:
                pending.append((Operation(GAMMAINC, self.first_argument(node)), depth, column))
                pending.append((node.args[1], depth + 1, 0))
            elif isinstance(node, ast.Call):
                pending.append((Operation("call", self.called(node)), depth, column))
                pending.append((node.args[0], depth + 1, 0))
            elif isinstance(node, ast.Constant):
                done.append((Operation("number", self.number(node)), column))
            elif isinstance(node, ast.Name):
                done.append((self.name(node), column))
            else:
                found = FOUND.get(type(node), f"Python's {type(node).__name__}")
                found = "a logical operator" if isinstance(node, ast.UnaryOp) else found
                raise self.refuse(found, column)
        return done

    def in_parentheses(self, node: ast.expr) -> bool:
        """Return whether an expression is in its own parentheses."""
        return self.source[: node.col_offset + self.shift - 1].rstrip().endswith("(")

    def between(self, node: ast.BinOp) -> int:
        """Return the column of a binary operator."""
        start = (node.left.end_col_offset or 0) + self.shift - 1
        rest = self.source[start:]
        return self.place(start + len(rest) - len(rest.lstrip(" )")) + 1)

    def operator(self, node: ast.BinOp) -> str:
        """Return the sign of an operator."""
        kind = _BINARY.get(type(node.op))
        if kind is None:
            raise self.refuse(
                f"the operator {_OTHER_BINARY.get(type(node.op), type(node.op).__name__)}", self.between(node)
            )
        if kind == "**" and "^" in self.text:  # to some programs x^y^z is (x^y)^z
            right = node.right
            while isinstance(right, ast.UnaryOp) and not self.in_parentheses(right):
                right = right.operand
            if isinstance(right, ast.BinOp) and isinstance(right.op, ast.Pow) and not self.in_parentheses(right):
                raise self.refuse("a power of a power", self.between(node), "Use parentheses with ^: x^(y^z).")
        return kind

    def called(self, node: ast.Call) -> str:
        """Return the name of a function that is called with one argument."""
        column = self.column(node)
        if not isinstance(node.func, ast.Name):
            found = FOUND.get(type(node.func), "something that is no function")
            raise self.refuse(f"a call of {found}", column, "Use * for a product.")
        name = node.func.id
        if name in self.variables or name in self.parameters or name in CONSTANTS:
            raise self.refuse(f"a call of {name}", column, f"Use {name}*(...) for a product.")
        if name not in FUNCTIONS:
            raise self.refuse(f"a call of {shown(name)}", column, ADVICE.get(name) or self.similar(name, FUNCTIONS))
        if len(node.args) != 1 or node.keywords or isinstance(node.args[0], ast.Starred):
            raise self.refuse(
                f"{name} with {len(node.args) + len(node.keywords)} arguments", column, "Functions have one argument."
            )
        return name

    def first_argument(self, node: ast.Call) -> Fraction:
        """Return the number a of gammainc(a, x)."""
        a = None
        hint = f"Use a number a, 0 < a <= {MOST_A}, and x >= 0: gammainc(0.6, x**2)."
        if len(node.args) == 2 and not node.keywords and not any(isinstance(e, ast.Starred) for e in node.args):
            program = Program(tuple(operation for operation, _ in self.postfix(node.args[0])), frozenset())
            if all(kind in "+-*/" or kind in ("number", "negate") for kind, _ in program.operations):
                with contextlib.suppress(ZeroDivisionError):
                    a = program.run(lambda f: f, {}, {}, pow)
        if a is None or not 0 < a <= MOST_A:
            given = ", ".join(map(ast.unparse, node.args))
            raise self.refuse(f"{GAMMAINC}({given})", self.column(node), hint)
        return Fraction(a)

    def number(self, node: ast.Constant) -> Fraction:
        """Return a finite literal as the exact number that it reads."""
        value = node.value
        column = self.column(node)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            kind = {str: "a string", bytes: "a string", complex: "an imaginary number"}.get(type(value), repr(value))
            raise self.refuse(kind, column)
        literal = self.source[node.col_offset + self.shift - 1 : (node.end_col_offset or 0) + self.shift - 1]
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number) or (number == 0 and literal.lower().split("e")[0].strip("0.")):
            raise self.refuse(f"the number {literal[:30]}", column, "Use numbers within the range of floats.")
        return Fraction(value) if isinstance(value, int) else Fraction(repr(value))

    def name(self, node: ast.Name) -> Operation:
        """Return a variable, a parameter or a constant."""
        name = node.id
        column = self.column(node)
        if name in (*FUNCTIONS, GAMMAINC):
            raise self.refuse(f"{name} without an argument", column, f"Use {name}(...).")
        if name in CONSTANTS or name in self.variables or name in self.parameters:
            return Operation("name", name)
        known = (*self.variables, *self.parameters, *CONSTANTS)
        meant = known if len(name) < 3 else (*known, *FUNCTIONS)  # a letter is a parameter, not a function
        hint = self.similar(name, meant) or f"Give a parameter its value, {name}=1.0."
        hint = TIME_HINT if name == TIME else f"{hint} Known names: {listed(known)}."
        raise UnknownName(f"{self.argument}: unknown name {shown(name, 44)} at column {column}", name, hint)

    @staticmethod
    def similar(name: str, known: Iterable[str]) -> str:
        """Return a "did you mean" for a name, or nothing."""
        close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5 if len(name) < 3 else 0.6)
        close = close or [k for k in known if k.lower() == name.lower()]
        return f"Did you mean {close[0]}?" if close else ""

    def check_sizes(self, operations: list[tuple[Operation, int]]) -> None:
        """Refuse constants that overflow or have no value, and powers of a size that no formula has.

        Each entry of the stack is the value of a constant (None for others) and the product of the exponents above its
        variables.
        """
        stack: list[tuple[float | None, float]] = []
        for (kind, operand), column in operations:
            try:
                if kind == "number":
                    entry: tuple[float | None, float] = float(operand), 1.0
                elif kind == "name":
                    entry = CONSTANTS.get(operand), 1.0
                elif kind == "call":
                    value, power = stack.pop()
                    entry = None if value is None else NUMERIC[operand](value), power
                elif kind == GAMMAINC:
                    value, power = stack.pop()
                    entry = None if value is None else float(incomplete_gamma(operand, value)), power
                elif kind == "negate":
                    value, power = stack.pop()
                    entry = None if value is None else -value, power
                else:
                    right, left = stack.pop(), stack.pop()
                    entry = self.combined(kind, left, right, column)
                if entry[0] is not None and not (isinstance(entry[0], float) and math.isfinite(entry[0])):
                    raise OverflowError
            except (OverflowError, ZeroDivisionError, ValueError) as problem:
                if str(problem).startswith(self.argument):
                    raise
                what = operand if kind == "call" else kind
                raise self.refuse(f"a constant without a finite real value ({what})", column) from None
            stack.append(entry)

    def combined(self, kind: str, left: tuple, right: tuple, column: int) -> tuple[float | None, float]:
        """Return the entry of left kind right."""
        both = left[0] is not None and right[0] is not None
        if kind != "**":
            if kind == "/" and right[0] == 0:
                raise ZeroDivisionError
            return (_apply(kind, left[0], right[0], pow) if both else None), max(left[1], right[1])
        if right[0] is None:
            if left[0] is not None and left[0] <= 0:
                raise self.refuse("a power of a number that is not positive", column, "Use a constant exponent.")
            return None, max(left[1], right[1])
        if abs(right[0]) > MAX_EXPONENT:
            raise self.refuse(f"the exponent {right[0]:g}", column, f"Use numeric exponents up to {MAX_EXPONENT}.")
        if both:
            value = left[0] ** right[0]
            if value == 0 and left[0] != 0:
                raise OverflowError
            return value, 1.0
        power = left[1] * max(1.0, abs(right[0]))
        if power > MAX_EXPONENT:
            raise self.refuse(
                f"powers of powers up to {power:g}", column, f"Use products of exponents up to {MAX_EXPONENT}."
            )
        return None, power
