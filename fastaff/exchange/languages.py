"""Right-hand sides in SymPy's symbols as source text: C, and Python for heyoka."""

from __future__ import annotations

from typing import Any

from ..base.interruption import imported


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
