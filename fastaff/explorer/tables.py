"""The tables of the grammar of formulas, as a module of the page: written once, in Python."""

from __future__ import annotations

import json
import keyword

from ..systems.formulas import grammar
from ..systems.formulas.gammainc import GAMMAINC
from ..systems.formulas.reserved import RESERVED


def grammar_module() -> str:
    """Return the text of the module tables.js, which exports GRAMMAR."""
    tables = {
        "functions": grammar.FUNCTIONS,
        "constants": grammar.CONSTANTS,
        "limits": {
            "length": grammar.MAX_LENGTH,
            "nodes": grammar.MAX_NODES,
            "depth": grammar.MAX_DEPTH,
            "exponent": grammar.MAX_EXPONENT,
        },
        "allowed": grammar.ALLOWED,
        "letters": "".join(sorted(grammar.LETTERS)),
        "signs": grammar.SIGNS,
        "spellings": grammar.SPELLINGS,
        "advice": {**grammar.ADVICE, GAMMAINC: "the page has no gammainc; fa.hamiltonian has"},
        "keywords": keyword.kwlist,
        "reserved": sorted(name for name in RESERVED if not name.startswith("_")),
    }
    return f"export const GRAMMAR = {json.dumps(tables)};\n"
