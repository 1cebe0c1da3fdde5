"""The messages about wrong input of a job or a command. Options have the names that the user writes: arguments of
Python, flags of the shell or keys of a TOML file.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Container, Iterator
from contextvars import ContextVar

Spelling = Callable[[str, str], str]
"""The spelling of an option from its name and that of its table, which is empty where none is needed."""


def as_argument(name: str, table: str = "") -> str:
    """Name an option as Python does: energy, surface.energy."""
    return f"{table}.{name}" if table else name


def as_flag(name: str, table: str = "") -> str:
    """Name an option as the shell does: --energy."""
    return "--" + name.replace("_", "-")


_SPELLING: ContextVar[Spelling] = ContextVar("spelling", default=as_argument)


@contextlib.contextmanager
def spelled(spelling: Spelling) -> Iterator[None]:
    """Name options in that way within the block."""
    token = _SPELLING.set(spelling)
    try:
        yield
    finally:
        _SPELLING.reset(token)


def option(name: str, table: str = "") -> str:
    """Return an option's name as the user writes it."""
    return _SPELLING.get()(name, table)


def respelled(text: str, names: Container[str]) -> str:
    """Return a sentence of the functions below, which begins with one or two of their arguments, with these as options;
    names: those that are options.
    """
    words = text.split(" ")
    for k in (0, 2):
        if k < len(words) and words[k] in names and (k == 0 or words[1] == "and"):
            words[k] = option(words[k])
        else:
            break
    return " ".join(words)


class OptionError(ValueError):
    """Wrong input: its text is all that the user sees."""

    @classmethod
    def of(cls, text: str, /, **values: object) -> OptionError:
        """Return the error of a text in which options stand in braces, and other values by name."""
        return cls(text.format_map(_Options(values)))


class _Options(dict[str, object]):
    def __missing__(self, name: str) -> str:
        return option(name)
