"""What kernels see of a model: its compiled blocks, by the places that they have there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..compile.blocks import idle_block, model_block, nystrom_block, parameters, step_block
from ..compile.nystrom import Terms
from ..compile.pointers import address
from ..kernels.stepping import Blocks


def blocks_of(model: Any, vectors: int = 0, step: Callable | None = None, **kinds: str | Terms) -> Blocks:
    """Return what kernels see of a model: block functions of these kinds, or of a Runge-Kutta-Nyström scheme's terms,
    idle ones in the other places; step: the kernel of a scheme that steps by the derivative.
    """
    n, derivative = model.degrees_of_freedom, 0
    found = {
        place: model_block(kind, model, n, vectors)
        if isinstance(kind, str)
        else nystrom_block(f"nystrom_{place}", model, n, vectors, kind)
        for place, kind in kinds.items()
    }
    if step is not None:
        found["step"], derivative = step_block(step), address(model_block("derivative", model, n, vectors))
    idle = {place: idle_block(place) for place in Blocks._fields[1:-1] if place not in found}
    return Blocks(parameters(model), **found, **idle, derivative=derivative)
