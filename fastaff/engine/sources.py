"""Sources of machine code: what each means without its comments, and what it imports.

Content keys follow the values that code reads. A type of Numba, an intrinsic or the like has no such content: the
source of its module stands for it, with the sources of the modules which that imports, at its top or in functions, and
so on. Every key has those of all modules of `engine`, which are the compiler of the others.

A source counts by its syntax tree: comments, docstrings and formatting are no part of it. To parse takes some ten times
as long as to read, so a file beside the folders of code keeps what is known of each source, by a hash of its bytes:
whatever dates files have, an edited one is another. A wheel brings such a file too.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import hashlib
import json
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from .cache import cache_root, others_write, read, write
from .packs import FOLDER
from .room import INDEX

COMPILED = (
    "core",
    "engine",
    "systems",
    "runs/schemes",
    "chaos/kernels",
    "frequencies/kernels",
    "quantum/kernels",
    "tori/kernels",
)
"""Folders of the package with the sources of machine code: higher layers only call it."""

ROOT = Path(__file__).parents[1]
"""Folder of the package."""

PACKAGE = __name__.partition(".")[0]
"""Name of the package."""

MOST = 1024
"""Sources of which that file tells at most: the package has some two hundred that machine code is made of."""


class Import(NamedTuple):
    """A statement of import: the dots before the module, the module, the names that are taken from it."""

    level: int
    module: str
    names: tuple[str, ...]


class Source(NamedTuple):
    """A hash of what a source means, and its statements of import."""

    meaning: str
    imports: tuple[Import, ...]


def key(modules: Iterable[str]) -> str | None:
    """Return a hash of what modules and all that they import mean; None of none, and where a source is missing."""
    return _key(tuple(modules))


@functools.cache
def _key(modules: tuple[str, ...]) -> str | None:
    found = {module: _source(module) for module in imported(modules)}
    _Index.keep()
    digest = hashlib.sha256()
    for module, source in sorted(found.items()):
        if source is None:
            return None
        digest.update(f"{module} {source.meaning}\n".encode())
    return digest.hexdigest() if found else None


def compiler() -> list[str]:
    """Return the modules of `engine`, without its kernels: they compile the others and tell Numba of types."""
    return [module for module in compiled() if module.rpartition(".")[0] == __package__]


def compiled() -> list[str]:
    """Return all modules of which machine code is made."""
    return sorted(_texts())


def imported(modules: Iterable[str]) -> set[str]:
    """Return modules and those of the package that they import, at once or by others."""
    found: set[str] = set()
    pending = list(modules)
    while pending:
        module = pending.pop()
        if module not in found:
            found.add(module)
            source = _source(module)
            pending += () if source is None else _targets(module, source.imports)
    return found


def _targets(module: str, imports: Iterable[Import]) -> list[str]:
    """Return the modules of the package that statements in a module import."""
    found = []
    # of a package, the first dot is the package itself
    inside = [*module.split("."), ""] if _file(module).name == "__init__.py" else module.split(".")
    for level, name, names in imports:
        base = ".".join(part for part in (*inside[: -level if level else 0], name) if part)
        if base.partition(".")[0] == PACKAGE:
            below = [f"{base}.{one}" for one in names]
            modules = [one for one in below if _file(one).is_file()]
            found += modules
            if len(modules) < len(names) or not names:
                found.append(base)
    return found


@functools.cache
def _file(module: str) -> Path:
    """Return the source of a module of the package."""
    path = ROOT.joinpath(*module.split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_name(f"{path.name}.py")


@functools.cache
def _texts() -> dict[str, bytes]:
    """Return all sources of machine code. They are read at once, when the first kernel is made: later the package may
    be another one on disk than in memory.
    """
    paths = sorted(path for top in COMPILED for path in (ROOT / top).rglob("*.py"))
    return {_module(path): path.read_bytes() for path in paths}


def _module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join((PACKAGE, *(parts[:-1] if parts[-1] == "__init__" else parts)))


@functools.cache
def _source(module: str) -> Source | None:
    """Return what is known of the source of a module; None where there is none."""
    content = _texts().get(module)
    if content is None:
        try:
            content = _file(module).read_bytes()
        except OSError:
            return None
    name = hashlib.sha256(_how() + content).hexdigest()
    found = _Index.known().get(name)
    if found is None:
        found = _Index.known()[name] = parsed(content)
        _Index.more = True
    return found


@functools.cache
def _how() -> bytes:
    """Return what the meaning of a source depends on beside it: the syntax of Python, and this module."""
    return f"{sys.implementation.cache_tag}\0".encode() + _file(__name__).read_bytes() + b"\0"


def parsed(content: bytes) -> Source:
    """Return the hash of the syntax tree of a source without docstrings, and what the source imports."""
    tree = ast.parse(content)
    imports = []
    for node in ast.walk(tree):
        for part in ("body", "orelse", "finalbody"):
            if isinstance(lines := getattr(node, part, None), list):
                setattr(node, part, [line for line in lines if not _is_text(line)])
        if isinstance(node, ast.Import):
            imports += [Import(0, entry.name, ()) for entry in node.names]
        elif isinstance(node, ast.ImportFrom):
            imports.append(Import(node.level, node.module or "", tuple(entry.name for entry in node.names)))
    return Source(hashlib.sha256(ast.dump(tree).encode("utf-8", "surrogatepass")).hexdigest()[:32], tuple(imports))


def _is_text(line: ast.AST) -> bool:
    """Tell whether a statement is a text alone: a docstring, or one below a constant."""
    return isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant) and isinstance(line.value.value, str)


class _Index:
    """What is known of sources by the hash of their bytes, and whether that is more than the file tells."""

    more = False

    @staticmethod
    @functools.cache
    def known() -> dict[str, Source]:
        """Return what the files tell: that of a wheel and the user's own."""
        return {**_told(FOLDER / INDEX, own=False), **_told(cache_root() / INDEX, own=True)}

    @classmethod
    def keep(cls) -> None:
        """Write what is known. Where that cannot be, the sources are parsed again in each process."""
        if not cls.more:
            return
        cls.more = False
        root = cache_root()
        with contextlib.suppress(OSError):
            root.parent.mkdir(parents=True, exist_ok=True)
            root.mkdir(mode=0o700, exist_ok=True)
        if os.access(root, os.W_OK):
            # of others that write at this moment, some may be lost: they are parsed again
            whole = {**_told(root / INDEX, own=True), **cls.known()}
            write(root / INDEX, json.dumps(dict(list(whole.items())[-MOST:])).encode())


def _told(path: Path, *, own: bool) -> dict[str, Source]:
    """Return what a file tells of sources: nothing where there is none, or one that others could write."""
    try:
        if own and others_write(path.stat()):
            return {}
    except OSError:
        return {}
    content = read(path, own=own)
    known = {} if content is None else json.loads(content)
    return {
        name: Source(meaning, tuple(Import(level, module, tuple(names)) for level, module, names in imports))
        for name, (meaning, imports) in known.items()
    }
