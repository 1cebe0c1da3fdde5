"""Names that users give: found in any spelling of their letters, refused with the nearest one."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from .numbers import listed, shown

BEGINS = 3
"""Least letters that count as the beginning of a name."""

MOST = 3
"""Most names with this beginning that are offered."""


def named(option: str, given: str, names: Iterable[str]) -> str:
    """Return the known name for `given`, in capitals or not, with or without spaces, hyphens and underscores; refuse an
    unknown one, with the nearest name.
    """
    known = tuple(names)
    found = spelled(given, known)
    if found in known:
        return found
    hint = did_you_mean(given, known)
    raise ValueError(f"{option} must be one of {shortened(known, 90 - len(hint))}, got {shown(given, 40)}.{hint}")


def shortened(names: Iterable[str], length: int) -> str:
    """Return names with commas between them, the first that fit into a length."""
    said = listed(names)
    return said if len(said) <= length else f"{said[: length - 5].rpartition(', ')[0]}, ..."


def spelled(given: str, names: Iterable[str]) -> str:
    """Return the known name for `given` in its own spelling; an unknown one as it is."""
    known = tuple(names)
    alike = [name for name in known if _letters(name) == _letters(given)]
    return alike[0] if len(alike) == 1 and given not in known else given


def did_you_mean(given: str, names: Iterable[str]) -> str:
    """Return the question "Did you mean" for the names that begin with `given`, or for the nearest one; "" for none."""
    known = {name.lower(): name for name in names}
    near = [name for name in known if len(given) >= BEGINS and name.startswith(given.lower())][:MOST]
    near = near or difflib.get_close_matches(given.lower(), known, n=1, cutoff=0.5)
    return f" Did you mean {' or '.join(known[name] for name in near)}?" if near else ""


def pairs(option: str, texts: Iterable[str], takes: str) -> list[tuple[str, str]]:
    """Return name and value of each text NAME=VALUE; refuse others, and names given twice."""
    found: list[tuple[str, str]] = []
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (equals and name and value):
            raise ValueError(f"{option} must be NAME={takes}, got {shown(text)}")
        if name in dict(found):
            raise ValueError(f"{option} {name} is given twice")
        found.append((name, value))
    return found


def _letters(name: str) -> str:
    return re.sub(r"[\s_-]", "", name).lower()
