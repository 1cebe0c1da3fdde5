"""Equations in a text: the variable and the right-hand side of each."""

from __future__ import annotations

import re
from typing import Any

from ...core.numbers import shown
from ...core.numbers import text as a_text

MOST_VARIABLES = 16
"""Most variables of a system of equations."""

_EXAMPLE = "such as \"x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z\""
_LEFT = re.compile(r"\s*(?:(\w+)\s*'|d\s*(\w+)\s*/\s*d\s*t)\s*\Z")


def split(text: Any) -> list[tuple[str, str]]:
    """Return variable and right-hand side of each equation of a text; ValueError or TypeError where it has none."""
    found = []
    for line in re.split(r"[;\n]", a_text("text", text)):
        if not line.strip():
            continue
        left, equals, right = line.partition("=")
        match = _LEFT.match(left)
        if not (equals and match and right.strip()):
            raise ValueError(f"text must be equations {_EXAMPLE}, got {shown(line.strip()[:80])}")
        found.append((match[1] or match[2], right))
    if not 1 <= len(found) <= MOST_VARIABLES:
        raise ValueError(f"text must have 1 to {MOST_VARIABLES} equations {_EXAMPLE}, got {len(found)}")
    return found
