"""The tables of a job's TOML file: keys, types and meanings, from the classes of `fastaff.jobs`."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
import textwrap
from typing import Any

from fastaff.jobs.job import TABLES

TYPES = {
    "str": "text",
    "float": "number",
    "int": "whole number",
    "int | str": "whole number or text",
    "bool": "true or false",
    "list[str]": "list of text",
}


def meanings(cls: Any) -> dict[str, str]:
    """Return the string that follows each field in the source of a class."""
    (body,) = ast.parse(textwrap.dedent(inspect.getsource(cls))).body
    assert isinstance(body, ast.ClassDef)
    found = {}
    for field, about in zip(body.body, body.body[1:]):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(about, ast.Expr):
            found[field.target.id] = ast.literal_eval(about.value)
    return found


def _cell(text: str) -> str:
    """Return a meaning in one line; flags of commands become keys."""
    line = re.sub(r"--([a-z][\w-]*)", lambda flag: f"`{flag[1].replace('-', '_')}`", " ".join(text.split()))
    return line.replace("|", "\\|")


def text() -> str:
    """Return the tables as Markdown."""
    lines = []
    for name, cls in TABLES.items():
        about = (inspect.getdoc(cls) or "").split("\n\n")[0]
        lines += ["", f"### [{name}]", "", about, ""]
        keys = dataclasses.fields(cls)
        if not keys:
            lines.append("It has no keys.")
            continue
        lines += ["| key | type | meaning [default] |", "|---|---|---|"]
        said = meanings(cls)
        for key in keys:
            kind = TYPES[str(key.type).removesuffix(" | None")]
            lines.append(f"| `{key.name}` | {kind} | {_cell(said[key.name])} |")
    return "\n".join(lines).lstrip("\n") + "\n"
