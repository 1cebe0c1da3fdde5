"""Equations of motion of a model as source text of other tools: C, and Python for heyoka."""

from __future__ import annotations

from typing import Any

from ..base.interruption import imported
from ..compile.kinds import OPTIONS, TERMS
from ..formulas.drive import TIME
from ..formulas.flow_text import flow
from ..formulas.gammainc import gammainc
from ..formulas.library import Request
from ..formulas.sympy_bridge import to_sympy


def _c(said: list[str], rows: list[str], sides: list[Any], _: list[float]) -> str:
    sympy = imported("sympy")
    parts, sides = sympy.cse(sides, symbols=sympy.numbered_symbols("s"))
    lines = [f"    const double {symbol} = {sympy.ccode(part)};" for symbol, part in parts]
    lines += [f"    dz[{i}] = {sympy.ccode(side)};" for i, side in enumerate(sides)]
    head = "".join(f" * {line}\n" for line in said).replace("*/", "* /")
    function = "void rates(double t, const double *z, const double *c, double *dz)"
    return f"/*\n{head} */\n#include <math.h>\n\n{function}\n{{\n" + "\n".join(lines) + "\n}\n"


def _heyoka(said: list[str], rows: list[str], sides: list[Any], values: list[float]) -> str:
    sympy = imported("sympy")
    used = sorted({entry.func.__name__ for side in sides for entry in side.atoms(sympy.Function)} | {"exp", "sqrt"})
    texts = [sympy.sstr(side.subs({sympy.pi: sympy.Float(sympy.pi, 17)}), full_prec=True) for side in sides]
    head = "".join(f"# {line}\n" for entry in said for line in entry.splitlines())
    made = f"z = heyoka.make_vars({', '.join(map(repr, rows))})\n" + ("z = [z]\n" if len(rows) == 1 else "")
    system = "".join(f"    (z[{i}], {text} + 0.0 * z[{i}]),\n" for i, text in enumerate(texts))
    return (
        f"{head}import heyoka\nfrom heyoka import {', '.join(used)}\n\n{made}t = heyoka.time\n"
        f"c = [heyoka.par[i] for i in range({len(values)})]\nsystem = [\n{system}]\nparameters = {values!r}\n"
    )


LANGUAGES = {"c": _c, "heyoka": _heyoka}
"""Functions that write each language."""


MOST = 8000
"""Characters of a formula, at most."""


def source(model: Any, language: str = "c") -> str:
    """Return the equations of motion dz/dt of a model that is a formula as source text.

    :Parameters: model of `hamiltonian` or `flow`; language: "c", for `void rates(double t, const double *z, const
        double *c, double *dz)`, or "heyoka", for Python that makes `system` and `parameters`, for
        taylor_adaptive(system, z0, pars=parameters). The rows z are those of fastaff, of a driven system without t and
        p_t; the parameters c are the model's fields, listed in the text with their values.
    :Raises: TypeError for a model that is no such formula, ValueError for another language; ImportError without SymPy.
    :Source: Meurer et al. 2017, PeerJ Comput. Sci. 3, e103 (SymPy: derivatives, common subexpressions, printing).

    Examples
    --------
    >>> from fastaff.exchange.sources import source
    >>> print(source(fa.flow("x' = s*(y - x); y' = -x", s=10.0)).splitlines()[-3])
        dz[0] = c[0]*(-z[0] + z[1]);
    """
    if language not in LANGUAGES:
        raise ValueError(f"language must be one of {', '.join(LANGUAGES)}, got {language!r}")
    sympy = imported("sympy", what="the source text of a model")
    known: tuple = getattr(type(model), "_request", ())
    if len(known) < len(Request._fields) - 1 or known[4] not in ("unit", "masses", "flow"):
        raise TypeError(
            f"model must be one of fa.hamiltonian(...) or fa.flow(...), got {type(model).__name__}{_flow(model)}"
        )
    request = Request(*known)
    named = ", ".join(f"{name} = {float(value)!r}" for name, value in zip(model._fields, model, strict=True))
    rows, sides = _equations(request, model._fields)
    if any(side.has(gammainc()) for side in sides):
        raise ValueError(f"model has gammainc, which neither C nor heyoka knows: {request.text}")
    sides = [side.replace(sympy.gamma, lambda a: sympy.gamma(a).evalf(17)) for side in sides]
    said = [f"dz/dt of {request.text}", f"z: {', '.join(rows)}", f"c: {named}" if named else "c: none"]
    return LANGUAGES[language](said, rows, sides, [float(value) for value in model])


def _flow(model: Any) -> str:
    """Return the call that makes equations of a model, as a hint; empty where there is none."""
    try:
        flow(model, forces={})
    except (TypeError, ValueError):
        return ""
    return ": of its equations, source(fa.flow(model, forces={}))"


def _equations(request: Request, fields: tuple[str, ...]) -> tuple[list[str], list[Any]]:
    """Return the names of the rows and the right-hand sides, in the symbols z[i], c[i] and t."""
    sympy = imported("sympy", what="the source text of a model")
    c = {name: sympy.Symbol(f"c[{i}]") for i, name in enumerate(fields)}
    coordinates = [name for name in request.coordinates if request.period is None or name != TIME]
    n = len(coordinates)
    z = [sympy.Symbol(f"z[{i}]") for i in range(2 * n)]
    names = {**c, **dict(zip(coordinates, z)), **({} if request.period is None else {TIME: sympy.Symbol("t")})}
    if request.inertia == "flow":
        return coordinates, [to_sympy(program, names) for program in request.programs(MOST)]
    masses = [c.get(f"m_{i + 1}", sympy.Integer(1)) for i in range(n)]
    q, p = z[:n], z[n:]
    if request.momenta:
        energy = to_sympy(request.program(MOST), {**names, **dict(zip(request.momenta, p))})
        sides = [sympy.diff(energy, p_i) for p_i in p] + [-sympy.diff(energy, q_i) for q_i in q]
        return [*coordinates, *request.momenta], sides
    V, options = to_sympy(request.program(MOST), names), request.option_programs()
    v, f, rows = [p_i / m for p_i, m in zip(p, masses)], [], [*coordinates, *(f"p_{name}" for name in coordinates)]
    for term in {OPTIONS[name] for name in options}:
        values = {name: to_sympy(program, c) for name, program in options.items()}
        rate, added = TERMS[term].of_options(values, masses[0], q)
        V, v = V + added, TERMS[term].added("v", rate, q, p, v)
        f = TERMS[term].added("f", rate, q, p, [-sympy.diff(V, q_i) for q_i in q])
    return rows, [*v, *(f or [-sympy.diff(V, q_i) for q_i in q])]
