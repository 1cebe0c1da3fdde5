"""The page: its modules, style and data assembled into one HTML file without requests."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from importlib.resources import files
from pathlib import PurePosixPath
from typing import Any

from .tables import grammar_module

_IMPORT = re.compile(r'^import \{[^}]*\} from "\./([A-Za-z0-9_]+\.js)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|class|const|let)\b)", re.MULTILINE)
_TOP = re.compile(r"^(?:export )?(?:async )?(?:function\*?|class|const|let) ([A-Za-z_$][\w$]*)", re.MULTILINE)
_ANY = re.compile(r"^\s*(?:import|export)\b", re.MULTILINE)


def web_text(name: str) -> str:
    """Return the text of a module, style or page of the folder `web`, or of the module that tables are written to."""
    if name == "tables.js":
        return grammar_module()
    return files(__package__).joinpath("web", str(PurePosixPath(name))).read_text(encoding="utf-8")


def script(entry: str) -> str:
    """Return a module and all that it imports as one script, in a fixed order: imported modules stand before.

    Raises ValueError where two modules have a top-level name in common, or an import is not `import { a } from
    "./b.js";`.
    """
    done: dict[str, str] = {}
    _gather(entry, done, ())
    owners: dict[str, str] = {}
    parts = []
    for name, text in done.items():
        for top in _TOP.findall(text):
            if owners.setdefault(top, name) != name:
                raise ValueError(f"{top} is a name of {owners[top]} and of {name}: one script has them both")
        plain = _EXPORT.sub("", _IMPORT.sub("", text))
        if _ANY.search(plain):
            raise ValueError(f'{name}: imports must be import {{ a, b }} from "./x.js"; exports stand at declarations')
        parts.append(plain)
    return "\n".join(parts)


def _gather(name: str, done: dict[str, str], above: tuple[str, ...]) -> None:
    if name in done:
        return
    if name in above:
        raise ValueError(f"the modules {' -> '.join([*above, name])} import one another in a circle")
    text = web_text(name)
    for other in _IMPORT.findall(text):
        _gather(other, done, (*above, name))
    done[name] = text


def worker_text() -> str:
    """Return the text of the worker, which a system's functions and `serve(compiledSystem);` complete."""
    return f'"use strict";\n{script("worker.js")}'


def as_data(value: Any) -> str:
    """Return a value as JSON in which nothing ends a script."""
    text = json.dumps(value, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


DATA = '<script type="application/json" id="setup">'
"""How the element begins that holds the set-up."""


def page(setup: dict[str, Any]) -> str:
    """Return the whole page for a set-up."""
    text = web_text("page.html")
    style = web_text("style.css")
    code = f'(() => {{\n"use strict";\n{script("page.js")}\n}})();\n'
    for what, part in (("script", code), ("style", style)):
        if f"</{what}" in part.lower() or "<!--" in part:
            raise ValueError(f"the text of the page's {what} must not have </{what} or <!--")
    policy = "; ".join(
        (
            "default-src 'none'",
            f"script-src '{_digest(code)}'",
            f"style-src '{_digest(style)}'",
            "img-src data: blob:",
            "worker-src blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    for mark, part in (
        ("<!-- policy -->", f'<meta http-equiv="Content-Security-Policy" content="{policy}">'),
        ('<link rel="stylesheet" href="style.css">', f"<style>{style}</style>"),
        (f"{DATA}</script>", f"{DATA}{as_data({**setup, 'worker': worker_text()})}</script>"),
        ('<script type="module" src="page.js"></script>', f"<script>{code}</script>"),
    ):
        if text.count(mark) != 1:
            raise ValueError(f"page.html must have {mark} once")
        text = text.replace(mark, part)
    return text


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
