"""The order of named rows: positions first, then their momenta, as usual names show it."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ..core.numbers import shown

MOMENTUM = ("p{}", "p_{}", "v{}", "v_{}", "{}p", "{}_p", "{}'", "{}prime", "{}_prime", "{}dot", "{}_dot")
"""Usual names of the momentum or velocity of a position {}."""

POSITION = re.compile(r"(x|y|z|r|rho|q)_?\d*")
"""Usual names of positions."""

ENERGIES = frozenset({"delta", "deltap", "dp", "dpp", "de", "pt", "ptau", "pzeta", "psigma"})
"""Usual names of the momentum of the last plane of a particle tracker, beside z, zeta, t, tau or ct."""


def wrong_order(names: Sequence[str], *, by_name: bool, alone: bool) -> ValueError | None:
    """Return the error of names of rows that are not q1, ..., qn, p1, ..., pn by usual names; None if they may be.

    Parameters: names (2n,): of the rows; by_name: whether the rows are found by their names; alone: whether positions
    without momenta are wrong too. Names that no convention knows pass.
    """
    n = len(names) // 2
    plain = [name.lower() for name in names]
    pairs = momenta(plain)
    if any(p != q + n for q, p in pairs.items()):
        return ValueError(f"coordinates must list all q, then all p, got {_text(names)}{_hint(names, pairs, by_name)}")
    if alone and all(POSITION.fullmatch(name) for name in plain):
        return ValueError(
            f"coordinates must list all q, then all p, got positions, {_text(names)}. Use fa.naff for positions alone."
        )
    return None


def momenta(names: Sequence[str]) -> dict[int, int]:
    """Return the place of the momentum of each position among names in lower case, where there is exactly one."""
    found: dict[int, int] = {}
    for place, name in enumerate(names):
        usual = {form.format(name) for form in MOMENTUM}
        if re.fullmatch(r"q_?\d*", name):
            usual.add("p" + name[1:])
        theirs = [other for other, own in enumerate(names) if own in usual]
        if len(theirs) == 1:
            found[place] = theirs[0]
    places = list(found.values())
    return {q: p for q, p in found.items() if places.count(p) == 1 and p not in found and q not in places}


def _hint(names: Sequence[str], pairs: dict[int, int], by_name: bool) -> str:
    """Return the order that is right, as a hint; empty if it is not known."""
    ordered = dict(pairs)
    rest = [place for place in range(len(names)) if place not in pairs and place not in pairs.values()]
    if len(rest) == 2 and not all(POSITION.fullmatch(names[place].lower()) for place in rest):
        q, p = reversed(rest) if names[rest[0]].lower() in ENERGIES else rest
        ordered[q] = p
    if 2 * len(ordered) < len(names):
        return ""
    places = sorted(ordered)
    right = _text([names[place] for place in (*places, *(ordered[place] for place in places))])
    return f". Use {right}." if by_name else f". Order the rows and the names as {right}."


def _text(names: Sequence[str]) -> str:
    return shown(" ".join(names))
