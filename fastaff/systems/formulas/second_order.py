"""Equations of second order, x'' = f(x, x'), as equations of first order with the velocities v_x."""

from __future__ import annotations

import re

from ...core.numbers import shown

_LEFT = re.compile(r"\s*(\w+)\s*''\s*\Z")
_PRIMED = re.compile(r"\b([A-Za-z_]\w*)\s*'(?!')")


def first_order(text: str) -> str:
    """Return equations with x' = v_x; v_x' = ... in place of x'' = ...; a text without '' as it is.

    Raises ValueError where a velocity has a name that is taken, or a higher derivative is left.
    """
    lines = [line for line in re.split(r"[;\n]", text) if line.strip()]
    lefts = [line.partition("=")[0] for line in lines]
    second = [match[1] for match in map(_LEFT.match, lefts) if match]
    if not second:
        return text
    found = []
    for line, left in zip(lines, lefts, strict=True):
        right = _PRIMED.sub(lambda match: f"v_{match[1]}" if match[1] in second else match[0], line.partition("=")[2])
        match = _LEFT.match(left)
        if match:
            found.append(f"{match[1]}' = v_{match[1]}")
            left = f"v_{match[1]}'"
        if "'" in right or not right.strip():
            raise ValueError(
                f"text must give x'' by variables and by x' of these variables, got {shown(line.strip()[:60])}"
            )
        found.append(f"{left.strip()} = {right.strip()}")
    for name in second:
        if sum(re.match(rf"\s*{name}\s*'", left) is not None for left in lefts) > 1:
            raise ValueError(f"text must have one equation of {name}, got two")
        if any(re.match(rf"\s*v_{name}\s*'", left) for left in lefts):
            raise ValueError(f"text must leave the name v_{name} to the velocity of {name}, got an equation of it")
    return "; ".join(found)
