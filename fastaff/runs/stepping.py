"""Arguments of kernels from a flow: the blocks of its model, the coefficients of its scheme."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..core.identity import by_identity
from ..engine import nystrom
from ..engine.blocks import idle_block, model_block, nystrom_block, parameters, step_block
from ..engine.kernels.collocation import collocate
from ..engine.kernels.stepping import Blocks, Coefficients, runge_kutta
from ..engine.packing import Packed
from ..engine.pointers import address
from ..systems.models.mechanics import System
from .schemes.catalogue import Collocation, Nystrom, Scheme, Splitting


def blocks_of(system: System, vectors: int = 0, step: Callable | None = None, **kinds: str | nystrom.Terms) -> Blocks:
    """Return a model's functions for kernels: block functions of these kinds, or of a Runge-Kutta-Nyström scheme's
    terms, idle ones in the other places; step: the kernel of a scheme that steps by the derivative.
    """
    n = system.n
    derivative = 0
    leapt = 0
    found = {
        place: model_block(kind, system.model, n, vectors)
        if isinstance(kind, str)
        else nystrom_block(f"nystrom_{place}", system.model, n, vectors, kind)
        for place, kind in kinds.items()
    }
    if step is not None:
        found["step"], derivative = step_block(step), address(model_block("derivative", system.model, n, vectors))
    if system.poles:
        leapt = address(model_block("leapt", system.model, n, vectors))
    idle = {place: idle_block(place) for place in Blocks._fields[1:-2] if place not in found}
    return Blocks(parameters(system.model), **found, **idle, derivative=derivative, leapt=leapt)


@by_identity
def _kept(model: Any) -> dict[tuple, tuple[Packed, Packed, Scheme]]:
    """The arguments that kernels have got from a model, and their schemes, whose ids could else pass to others."""
    return {}


def stepping(flow: Any, *kinds: str, solo: bool = False) -> tuple[Packed, Packed]:
    """Return the blocks of these kinds and that of the scheme's step, for units of one orbit if `solo`, and the
    scheme's coefficients.
    """
    scheme = flow.scheme
    kept = _kept(flow.model)
    key = id(scheme), flow.vectors, solo, kinds
    if key not in kept:
        by: dict[str, Any] = {"step": collocate if isinstance(scheme, Collocation) else runge_kutta}
        if isinstance(scheme, Nystrom):
            by = {"march" if solo else "splitting": scheme.terms}
        if isinstance(scheme, Splitting):
            by = {"march": "march"} if solo else {"splitting": "precise_splitting" if flow.precise else "splitting"}
        blocks = blocks_of(flow.system, flow.vectors, **by | {kind: kind for kind in kinds})
        kept[key] = Packed(blocks), Packed(_coefficients(flow)), scheme
    return kept[key][:2]


def _coefficients(flow: Any) -> Coefficients:
    scheme = flow.scheme
    if isinstance(scheme, (Splitting, Nystrom)):
        if isinstance(scheme, Nystrom):
            copies = 2
        elif flow.precise:
            copies = 3
        else:
            copies = 1
        return Coefficients(scheme.drift_array, scheme.kick_array, copies=copies, spare=_spare(flow))
    if isinstance(scheme, Collocation):
        a = scheme.a_array
        b = scheme.b_array
        dense = scheme.dense_array
        return Coefficients(a=a, b=b, dense=dense, copies=2 * (1 + scheme.stages), sweeps=scheme.sweeps)
    return Coefficients(a=scheme.a_array, b=scheme.b_array, errors=scheme.error_array, dense=scheme.dense_array)


def _spare(flow: Any) -> int:
    """Return the number of further rows in blocks of states: for the numbers of a substep, or for the forces of
    stages.
    """
    substep = flow.system.substep
    scheme = flow.scheme
    if isinstance(scheme, Nystrom):
        n = flow.model.degrees_of_freedom
        return nystrom.spare_rows(n, n * (1 + flow.vectors), scheme.stages)
    return 0 if substep is None else substep.spare_rows(scheme.drift_array.size, scheme.kick_array.size)
