"""What is said of wrong input of a job or a command."""

from __future__ import annotations

import difflib


class Wrong(ValueError):
    """Wrong input: its text is all that the user sees."""


def named(option: str, given: str, names: tuple[str, ...]) -> str:
    """Return the name given if it is one of the names; refuse it with the nearest one otherwise."""
    if given in names:
        return given
    near = difflib.get_close_matches(given, names, n=1, cutoff=0.5)
    raise Wrong(
        f"{option} must be one of {', '.join(names)}, got {given!r}." + (f" Did you mean {near[0]}?" if near else "")
    )
