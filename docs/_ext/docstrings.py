"""Docstrings of the package as reStructuredText: "Parameters: a: ...; b: ...", "Returns", "Raises", "Cost:", "Source:"
become fields, names in single quotes become links where the site has them, the rest is escaped prose.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

FIELDS = ("Formula", "Formulas", "Method", "Errors", "Cost", "Memory", "Source")
_SENTENCE = r"(?:^|(?<=[.!?)\]])\s+)"
_HEADS = re.compile(rf"{_SENTENCE}(?=(?:Parameters|{'|'.join(FIELDS)}): |(?:Returns|Raises) )")
_HEAD = re.compile(rf"(?:(Parameters|{'|'.join(FIELDS)}):|(Returns|Raises))\s+(.*)", re.DOTALL)
_NAMES = re.compile(r"(\*{0,2}[A-Za-z_]\w*(?:, \*{0,2}[A-Za-z_]\w*)*)(.*)", re.DOTALL)
_QUOTED = re.compile(r"`([^`]+)`")
_CLASS = re.compile(r"[A-Z][A-Za-z]+\b")

Link = Callable[[str], str | None]
"""Of a name to what it is called in the site's index, or None."""


def no_link(name: str) -> None:
    """Return None: the site has no such name."""


def escaped(text: str) -> str:
    """Return text in which no character means anything to reStructuredText."""
    return re.sub(r"([\\*`|_<>])", r"\\\1", text)


def prose(text: str, link: Link = no_link) -> str:
    """Return a paragraph, with what stands in single quotes as a link or as code and the rest escaped."""
    text = re.sub(r"\s+", " ", text)
    parts, end = [], 0
    for found in _QUOTED.finditer(text):
        parts += [_plain(text[end : found.start()]), _code(found[1], link)]
        end = found.end()
    return _joined([*parts, _plain(text[end:])])


def _plain(text: str) -> str:
    text = escaped(text)
    return re.sub(r"^([-+]|\w{1,2}[.)])(\s)", r"\\\1\2", text)  # no list begins here


def _joined(parts: list[str]) -> str:
    """Join text and markup in turns; where they touch, by an escaped blank, which is nothing but ends the markup."""
    text = ""
    for part in filter(None, parts):
        touching = text and not text[-1].isspace() and not part[0].isspace()
        text += ("\\ " if touching else "") + part
    return text


def _code(name: str, link: Link) -> str:
    target = link(name.removesuffix("()"))
    return f":py:obj:`{name} <{target}>`" if target else f"``{name}``"


def split_top(text: str, mark: str = ";") -> list[str]:
    """Return the parts of a text between marks that stand in no bracket."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if character == mark and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts if part.strip()]


def parameters(text: str, known: set[str]) -> list[tuple[str, str]] | None:
    """Return (names, description) of each entry of a list of parameters; None where the text is no such list.

    An entry begins with names of the signature; a part that does not goes on with the one before.
    """
    entries: list[tuple[str, str]] = []
    for part in split_top(text):
        found = _NAMES.fullmatch(part)
        names = [name for name in found[1].split(", ") if name.lstrip("*") in known] if found else []
        if names:
            taken = ", ".join(names)
            call = re.match(r"\([^)]*\)", part[len(taken) :])  # a function, as it is called: report(fraction)
            taken += call[0] if call else ""
            rest = part[len(taken) :].lstrip(",").strip()
            entries.append((taken, rest.removeprefix(":").strip().removesuffix(".")))
        elif entries:
            entries[-1] = (entries[-1][0], f"{entries[-1][1]}; {part.removesuffix('.')}")
        else:
            return None
    return entries or None


def _blocks(lines: list[str]) -> list[tuple[str, list[str]]]:
    """Return the paragraphs, each with its kind: table or code, kept line by line, or text."""
    blocks: list[tuple[str, list[str]]] = []
    for line in [*lines, ""]:
        if not line.strip():
            blocks.append(("", []))
            continue
        kind = "code" if line.startswith(("    ", "|")) else "text"
        if not blocks or blocks[-1][0] != kind:
            blocks.append((kind, []))
        blocks[-1][1].append(line)
    return [(kind, body) for kind, body in blocks if body]


def _sections(body: list[str]) -> list[str]:
    """Return a paragraph cut where a field begins: at a line's start, or after a sentence."""
    pieces: list[list[str]] = [[]]
    for line in body:
        if re.match(rf"(?:{'|'.join(FIELDS)}|Parameters): ", line):
            pieces.append([])
        pieces[-1].append(line)
    texts = [" ".join(piece) for piece in pieces if piece]
    return [section.strip() for text in texts for section in _HEADS.split(text) if section.strip()]


def converted(lines: list[str], known: set[str] = frozenset(), link: Link = no_link) -> list[str]:
    """Return a docstring's lines as reStructuredText.

    known: the names of the signature, which are no links; link: what other names are called in the site's index.
    """
    out: list[str] = []

    def of_others(name: str) -> str | None:
        return None if name in known else link(name)

    for kind, body in _blocks(lines):
        if kind == "code":
            out += ["::", "", *("    " + line for line in body), ""]
            continue
        for section in _sections(body):
            out += [*_section(section, known, of_others), ""]
    return out


def _section(text: str, known: set[str], link: Link) -> list[str]:
    found = _HEAD.fullmatch(text)
    if found is None:
        return [prose(text, link)]
    name, rest = found[1] or found[2], found[3]
    if name == "Parameters":
        entries = parameters(rest, known)
        if entries is None:
            return [prose(text, link)]
        items = [
            f"  * **{escaped(names)}**" + (f" -- {prose(about, link)}" if about else "") for names, about in entries
        ]
        return [":Parameters:", *items]
    if name == "Returns":
        first = _CLASS.match(rest)
        named = _code(first[0], link) if first and link(first[0]) else ""
        return [f":Returns: {_joined([named, prose(rest[first.end() :] if first and named else rest, link)])}"]
    return [f":{name}: {prose(rest, link)}"]


def signature_names(value: Any) -> set[str]:
    """Return the names of a function's parameters."""
    try:
        return set(inspect.signature(value).parameters)
    except (TypeError, ValueError):
        return set()
