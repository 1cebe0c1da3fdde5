"""Equations of motion of a model as source text of other tools: C, and Python for heyoka."""

from __future__ import annotations

from typing import Any

from ..core.interruption import imported
from ..core.numbers import listed, shown
from ..systems.formulas.forced import BUILT_IN
from ..systems.formulas.gammainc import gammainc
from ..systems.formulas.library import Request
from ..systems.formulas.ode import ode
from .symbols import equations


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


def source(model: Any, language: str = "c") -> str:
    """Return the equations of motion of a formula as source text.

    Parameters
    ----------
    model : model
        Result of `hamiltonian` or `ode`, `HenonHeiles` or `DoublePendulum`.
    language : {"c", "heyoka"}, default "c"
        Language of the text.

        * "c": ``void rates(double t, const double *z, const double *c, double *dz)``.
        * "heyoka": Python that makes ``system`` and ``parameters`` for ``taylor_adaptive(system, z0,
          pars=parameters)``.

    Returns
    -------
    str
        Source text. Its z are the rows of fastaff without t and p_t, its c the fields of the model.

    Raises
    ------
    TypeError
        If `model` is not one of these.
    ValueError
        If `language` is another one, or if the model has gammainc.
    ImportError
        If SymPy is missing.

    References
    ----------
    Meurer et al. 2017, PeerJ Comput. Sci. 3, e103 (SymPy: derivatives, common subexpressions, printing).

    Examples
    --------
    >>> from fastaff.exchange.sources import source
    >>> print(source(fa.ode("x' = s*(y - x); y' = -x", s=10.0)).splitlines()[-3])
        dz[0] = c[0]*(-z[0] + z[1]);
    """
    if language not in LANGUAGES:
        raise ValueError(f"language must be one of {listed(LANGUAGES)}, got {shown(language)}")
    model = ode(model, forces={}) if type(model) in BUILT_IN and hasattr(model, "coordinates") else model
    known: tuple = getattr(type(model), "_request", ())
    if len(known) < len(Request._fields) - 1 or known[4] not in ("unit", "masses", "ode"):
        raise TypeError(f"model must be one of fa.hamiltonian(...) or fa.ode(...), got {_refused(model)}")
    request = Request(*known)
    named = ", ".join(f"{name} = {float(value)!r}" for name, value in zip(model._fields, model, strict=True))
    rows, sides = equations(request, model._fields)
    if any(side.has(gammainc()) for side in sides):
        raise ValueError(f"model has gammainc, which neither C nor heyoka knows: {request.text}")
    sides = [side.replace(lambda e: e.func.__name__ == "gamma", lambda e: e.evalf(17)) for side in sides]
    said = [f"dz/dt of {request.text}", f"z: {', '.join(rows)}", f"c: {named}" if named else "c: none"]
    return LANGUAGES[language](said, rows, sides, [float(value) for value in model])


def _refused(model: Any) -> str:
    """Return the class of a model, with the call that makes equations of it, if there is one."""
    try:
        ode(model, forces={})
    except (TypeError, ValueError):
        return type(model).__name__
    return f"{type(model).__name__}: of its equations, source(fa.ode(model, forces={{}}))"
