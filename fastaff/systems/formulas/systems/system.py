"""A named system H(q, p): its text, the names and periods of its rows, and its constants of motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ....core.names import named
from ....core.numbers import listed, shown
from ..formula import hamiltonian

Constants = Callable[[Any, np.ndarray], dict[str, Any]]
"""A function of a model and phase points (rows, orbits)."""


class NamedSystem(NamedTuple):
    """Text of H, coordinates and momenta, the coordinates that are angles, and the constants of motion."""

    text: str
    coordinates: str
    momenta: str
    angles: str
    constants: Constants

    def made(self, parameters: dict[str, Any], more: str = "", domain: str | None = None) -> Any:
        """Return the model with these parameters; more: text of a potential energy that is added."""
        return hamiltonian(
            f"{self.text} + ({more})" if more else self.text,
            coordinates=self.coordinates,
            momenta=self.momenta,
            periodic=dict.fromkeys(self.angles.split(), "2*pi"),
            domain=domain,
            **parameters,
        )


Maker = TypeVar("Maker", bound=Callable[..., Any])
SYSTEMS: dict[str, Callable[..., Any]] = {}
"""The functions that make systems, by name, for `fastaff.models`, the command line, the site and the tests."""
TEXTS: list[NamedSystem] = []
"""All systems that they make."""


def makes(*systems: NamedSystem) -> Callable[[Maker], Maker]:
    """Register the function that makes these systems in `SYSTEMS`, under its own name."""

    def entered(make: Maker) -> Maker:
        SYSTEMS[make.__name__] = make
        TEXTS.extend(systems)
        return make

    return entered


def of_angles(model: Any, z: np.ndarray) -> dict[str, Any]:
    """Return the energy and the momenta of the angles, for a system whose H does not depend on the angles."""
    n = model.degrees_of_freedom
    turning = {name: row for name, row, period in zip(model.momenta, z[n:], model.periods()) if period > 0}
    return {"energy": model.energy(*z), **turning}


def chosen(argument: str, given: Any, names: tuple[str, ...]) -> str:
    """Return `given` if it is one of the names; raise TypeError or ValueError for anything else."""
    if not isinstance(given, str):
        raise TypeError(f"{argument} must be one of {listed(names)}, got {shown(given)} ({type(given).__name__})")
    return named(argument, given, names)
