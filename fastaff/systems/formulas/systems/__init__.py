"""Named systems H(q, p), each a text with its rows and constants of motion, beside the function that makes it."""

from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from .system import SYSTEMS, TEXTS, Constants

__all__ = ["SYSTEMS", "constants_of"]

for _module in iter_modules(__path__):  # each registers its systems
    import_module(f".{_module.name}", __name__)


def constants_of(model: Any) -> Constants | None:
    """Return the constants of motion of a named system, None for other models."""
    text = getattr(model, "formula", None)
    rows = [getattr(model, name, ()) for name in ("coordinates", "momenta")]
    if not isinstance(text, str):
        return None
    for system in TEXTS:
        own = text == system.text or text.startswith(f"{system.text} + (")
        if own and rows == [tuple(system.coordinates.split()), tuple(system.momenta.split())]:
            return system.constants
    return None
