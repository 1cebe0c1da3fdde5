"""The grammar of formulas: what it computes against Python itself, what it refuses, and that it never hangs or runs
anything.
"""

import ast
import json
import math
import random
import re
from fractions import Fraction

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fastaff.systems.formulas.grammar import CONSTANTS, FUNCTIONS, checked_name, parse

X, Y, K = 0.7, 1.3, 2.5
NUMERIC = {name: getattr(math, name) for name in FUNCTIONS}


def number(program, power=pow):
    return program.run(float, {"x": X, "y": Y, "k": K, **CONSTANTS}, NUMERIC, power)


def read(text):
    return parse(text, ("x", "y"), ("k",))


def written(depth, rng):
    """A random formula, fully parenthesised, and its value by Python's own operators."""
    if depth == 0 or rng.random() < 0.15:
        choice = rng.choice(["x", "y", "k", "pi", "number"])
        if choice == "number":
            text = rng.choice(["2", "0.1", "3.5", "1e-3", "7", ".5", "12.", "1_0"])
            return text, float(text)
        return choice, {"x": X, "y": Y, "k": K, "pi": math.pi}[choice]
    kind = rng.choice(["+", "-", "*", "/", "neg", "pos", "**", *FUNCTIONS])
    text, value = written(depth - 1, rng)
    if kind in ("neg", "pos"):
        return f"({'-' if kind == 'neg' else '+'}{text})", -value if kind == "neg" else value
    if kind in FUNCTIONS:
        inner, argument = f"({text})/(1 + ({text})**2)", value / (1 + value**2)  # in [-1/2, 1/2]
        if kind in ("sqrt", "log"):
            inner, argument = f"1 + {inner}", 1 + argument
        return f"{kind}({inner})", NUMERIC[kind](argument)
    if kind == "**":
        n = rng.choice([2, 3, -1])
        return f"((2 + sin({text}))**{n})" if n > 0 else f"((2 + sin({text}))**({n}))", (2 + math.sin(value)) ** n
    other, right = written(depth - 1, rng)
    if kind == "/":
        return f"(({text})/(2 + sin({other})))", value / (2 + math.sin(right))
    return f"(({text}) {kind} ({other}))", {"+": value + right, "-": value - right, "*": value * right}[kind]


def test_values_are_those_of_python():
    rng, done = random.Random(3), 0
    while done < 200:
        try:
            text, value = written(3, rng)
        except (OverflowError, ZeroDivisionError):
            continue
        if len(text) > 1500 or not abs(value) < 1e30:
            continue
        try:
            program = read(text)
        except ValueError as problem:
            if not re.search("powers|finite|exponent", str(problem)):
                raise
            continue
        assert number(program) == pytest.approx(value, rel=1e-9, abs=1e-9)
        done += 1


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2 - 3 - 4", -5),
        ("2/4/2", 0.25),
        ("2**3**2", 512),
        ("-x**2", -X * X),
        ("-2**2", -4),
        ("2*-x", -2 * X),
        ("x**-1", 1 / X),
        ("+x", X),
        ("1 + 2*x - y/2", 1 + 2 * X - Y / 2),
        ("(x)", X),
        ("  x\n + \t y ", X + Y),
        ("x/y*k", X / Y * K),
        ("sqrt(x)**3", X**1.5),
        ("x**(3/2)", X**1.5),
        ("exp(-k*x)", math.exp(-K * X)),
        ("--x", X),
        ("pi", math.pi),
        ("x**k", X**K),
        ("2**x", 2**X),
        ("(x + y)*(x - y)", X * X - Y * Y),
    ],
)
def test_precedence_is_that_of_python(text, value):
    assert number(read(text)) == pytest.approx(value, rel=1e-15)


def test_decimals_are_exact():
    program = read("0.1*x + 1e-3 + 12.5 + 3")
    literals = [o.operand for o in program.operations if o.kind == "number"]
    assert literals == [Fraction(1, 10), Fraction(1, 1000), Fraction(25, 2), 3]
    assert program.names == {"x"}


def test_long_sums_are_no_deep_nesting():
    assert number(read(" + ".join(["x"] * 400))) == pytest.approx(400 * X, rel=1e-13)
    assert number(read("*".join(["x"] * 300))) == pytest.approx(X**300, rel=1e-12)


REFUSED = [  # text, what the message says
    ("x.__class__", "attribute access", 1),
    ("x.real", "attribute access", 1),
    ("foo(x)", "a call of 'foo'", 1),
    ("__import__(x)", "a call of '__import__'", 1),
    ("x[0]", "subscript", 2),
    ("'x'", "a string", 1),
    ('"x"', "a string", 1),
    ("x < y", "a comparison", 3),
    ("x == y", "comparison", 3),
    ("lambda x: x", "lambda", 9),
    ("[x for x in y]", "list", 1),
    ("(x for x in y)", "a comprehension", 1),
    ("(y := x)", "assignment", 4),
    ("x if y else k", "a condition", 1),
    ("x and y", "a logical operator", 1),
    ("not x", "a logical operator", 1),
    ("x, y", "a comma", 1),
    ("x; y", "a second statement", 2),
    ("x # y", "a comment", 3),
    ("x % 2", "operator %", 3),
    ("x // 2", "operator //", 3),
    ("x @ y", "operator @", 3),
    ("x ^ y ^ 2", "a power of a power", 3),
    ("x + y^-k**2", "a power of a power", 6),
    ("x^2 + y^2 + z", "unknown name 'z'", 13),
    ("x^2 + y^(x y)", "not one expression", 10),
    ("x & y", "operator &", 3),
    ("~x", "operator ~", 1),
    ("{x}", "set", 1),
    ("x\\y", "backslash", 2),
    ("1j*x", "an imaginary number", 1),
    ("True*x", "True", 1),
    ("None", "None", 1),
    ("...", "Ellipsis", 1),
    ("x\0", "a null byte", 2),
    ("αlpha", "greek small letter alpha", 1),
    ("х + y", "cyrillic", 1),
    ("x²", "superscript two", 2),
    ("x·y", "middle dot", 2),
    ("1e400", "the number 1e400", 1),
    ("x + 1e-400", "the number 1e-400", 5),
    ("1" + "0" * 400, "the number", 1),
    ("2**10**9", "exponent", 2),
    ("x**10**9", "exponent", 2),
    ("x**65", "exponent 65", 2),
    ("(x**9)**9", "powers of powers", 7),
    ("x**1e9", "exponent", 2),
    ("x/0", "finite real value", 2),
    ("x + 1/(2 - 2)", "finite real value", 6),
    ("log(0)*x", "finite real value", 1),
    ("sqrt(-1)*x", "finite real value", 1),
    ("(-2)**0.5", "finite real value", 5),
    ("exp(1000)*x", "finite real value", 1),
    ("1e300*1e300", "finite real value", 6),
    ("(1e-300**64)*x", "finite real value", 8),
    ("(-2)**x", "not positive", 5),
    ("sin", "sin without an argument", 1),
    ("sin()", "sin with 0 arguments", 1),
    ("sin(x, y)", "sin with 2 arguments", 1),
    ("sin(x=y)", "comparison", 6),
    ("sin(*x)", "Functions have one", 1),
    ("x(y)", "a call of x", 1),
    ("2(x)", "no function", 1),
    ("x.y(2)", "attribute", 1),
    ("2x", "not one expression", 1),
    ("x y", "not one expression", 1),
    ("x +", "not one expression", 3),
    ("(x", "not one expression", 1),
    ("x)", "closing parenthesis", 2),
    ("x)*(y", "closing parenthesis", 2),
    ("", "an empty text", None),
    ("  ", "an empty text", None),
    ("import os", "not one expression", 1),
    ("await x", "await", 1),
    ("yield x", "yield", None),
    ("abs(x)", "smooth at 0", 1),
    ("ln(x)", "Use log, the natural", 1),
    ("(" * 5000, "at most 2000 characters", None),
    ("(" * 61 + "x" + ")" * 61, "deeper than 60", 61),
    ("-" * 1900 + "x", "deeper than 60", 62),
    ("x**" * 100 + "x", "deeper than 60", None),
    ("+".join(["x"] * 900), "more than 1000", None),
]


@pytest.mark.parametrize(("text", "found", "column"), REFUSED, ids=[repr(t[:16]) for t, _, _ in REFUSED])
def test_refused_with_what_where_and_what_is_allowed(text, found, column):
    with pytest.raises(ValueError, match="text") as refused:
        read(text)
    message = str(refused.value)
    assert found in message
    if column is not None:
        assert re.search(rf"at column {column}\. (Use|Did you mean|Give|Functions) ", message)
    assert len(message) <= 160


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("alhpa", "Did you mean alpha?"),
        ("D3", "Did you mean D1?"),
        ("Sin(x)", "Did you mean sin?"),
        ("sqr(x)", "Did you mean sqrt?"),
        ("K", "Did you mean k?"),
        ("c*x", "Give a parameter its value, c=1.0."),
        ("x^2^3", "Use parentheses with ^"),
        ("2x", "Use * for a product"),
        ("k(x)", "Use k*(...)"),
        ("zeta", "Give a parameter its value, zeta=1.0"),
    ],
)
def test_hints(text, hint):
    with pytest.raises(ValueError, match="text: ") as refused:
        parse(text, ("x", "alpha", "D1"), ("k",))
    assert hint in str(refused.value)
    if "unknown" in str(refused.value):
        assert "Known names: x, alpha, D1, k, pi." in str(refused.value)


@pytest.mark.parametrize("wrong", [None, 3, b"x", ["x"], 1.5])
def test_only_texts(wrong):
    with pytest.raises(TypeError, match="text must be a text"):
        read(wrong)


@pytest.mark.parametrize(
    "name", ["1x", "x y", "", "_x", "__class__", "lambda", "sin", "pi", "abs", "µ", "х", "a" * 41, "x"]
)
def test_names_that_are_none(name):
    with pytest.raises(ValueError, match="parameter"):
        checked_name(name, "parameter", {"x"})


@given(st.lists(st.sampled_from(["x", "(x + y)", "sin(y)", "2.5", "k"]), min_size=2, max_size=6), st.data())
def test_a_circumflex_is_a_power(factors, data):
    """Written so, the program is that of **, whatever stands around it."""
    pieces = [f"{factor}{{}}{data.draw(st.integers(-3, 5))}" for factor in factors]
    text = data.draw(st.sampled_from([" + ", "*", " / ", " - "])).join(
        [*pieces, "x{}(y{}2)", "-k{}(-y{}3)", "y{}-(x{}2)"]
    )
    count = text.count("{}")
    marks = [data.draw(st.sampled_from(["^", " ^ ", "**"])) for _ in range(count)]
    assert read(text.format(*marks)) == read(text.format(*["**"] * count))


def test_names_that_are():
    for name in ("C", "eps", "k_1", "Lambda", "a" * 40):
        assert checked_name(name, "parameter", {"x"}) == name


PIECES = [
    *("x", "y", "k", "1", "2.5", "1e5", "(", ")", "+", "-", "*", "/", "**", " ", "sin(", "log(", "sqrt", "pi", "."),
    *(",", "^", "=", "__", "import", "lambda", ":", "[", "]", "'", "e", "9"),
]


@settings(max_examples=400)
@given(st.one_of(st.text(max_size=60), st.lists(st.sampled_from(PIECES), max_size=30).map("".join)))
@example("x" + "**2" * 30)
@example("9**9**9**9")
@example("1e308*10**64")
def test_any_text_is_a_formula_or_refused(text):
    try:
        program = read(text)
    except ValueError as problem:
        if not str(problem).startswith("text"):
            raise
        return
    assert program.names <= {"x", "y", "k", "pi"}
    tree = ast.parse(" ".join(text.split()).strip(), mode="eval")  # what is accepted is Python with the same names
    assert {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)} - set(FUNCTIONS) == program.names
    json.dumps([str(o) for o in program.operations])
