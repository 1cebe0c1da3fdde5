"""Letters of other authors: a parameter that a potential has under another name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from ...core.numbers import shown
from .constructors import checks_arguments

T = TypeVar("T", bound=type)


def inertia_is_mu(body: str) -> Callable[[T], T]:
    """Return a decorator of potentials whose shear modulus is G: a caller who says mu reads that, and that mu is the
    inertia of a body, which is written as `body`.
    """

    def told(cls: T) -> T:
        fields: tuple[str, ...] = cls._fields  # type: ignore[attr-defined]

        def has_no_mu(arguments: Mapping[str, Any]) -> None:
            if "mu" in arguments:
                raise TypeError(
                    f"{cls.__name__} takes {' and '.join(fields)}, got mu={shown(arguments['mu'], 20)}. "
                    f"The shear modulus is G; mu is the inertia, {body}."
                )

        return checks_arguments(has_no_mu)(cls)

    return told
