"""Letters of other authors: a parameter that a potential has under another name."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar

from ...core.numbers import shown

T = TypeVar("T", bound=type)


def inertia_is_mu(body: str) -> Callable[[T], T]:
    """Return a decorator of potentials whose shear modulus is G: a caller who says mu reads that, and that mu is the
    inertia of a body, which is written as `body`.
    """

    def told(cls: T) -> T:
        potential: Any = cls
        made = potential.__new__

        @functools.wraps(made)
        def wrapped(*given: Any, **named: Any) -> Any:
            if "mu" in named:
                raise TypeError(
                    f"{cls.__name__} takes {' and '.join(potential._fields)}, got mu={shown(named['mu'], 20)}. "
                    f"The shear modulus is G; mu is the inertia, {body}."
                )
            return made(*given, **named)

        potential.__new__ = wrapped
        return cls

    return told
