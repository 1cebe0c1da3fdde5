"""Wave packets from given functions: their expansion in the lowest states of symmetry classes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.numbers import real, shown, whole
from ...results.progress import says_progress
from ...runs.requirements import current_system
from ...systems.charts import ALPHA_BETA, Chart
from ...systems.models import Body
from ..spectra.spectrum import solved_families, spectrum, spectrum_table
from ..states.quadrature import GROWTH, NodeGrid, converged_box, resolved
from ..states.state import State, invariants_of
from ..states.symmetry import SymmetryClass, checked_class
from .packet import Packet

NOTHING = 1e-3
"""Part of `missing` that the states left out of a packet may have together."""


@says_progress
@inserts_parameters
def projected_packet(
    model: Body,
    function: Callable[[np.ndarray, np.ndarray], np.ndarray],
    *,
    m: int,
    l: int,
    count: int,
    hbar: float = 1.0,
    chart: Chart = ALPHA_BETA,
    missing: float = 1e-6,
    single_valued: bool = True,
) -> Packet:
    """Expand a function in the lowest states of one symmetry class of a body.

    Parameters
    ----------
    {body}
    function : callable
        Function of two arrays, the invariants of the chart, that returns Psi e^(-i m phi - i l psi), real or complex.
        It need not be normalised and must have decayed at twice the reach of the states. Its part beyond a potential
        barrier is missing.
    {spin_vorticity}
    {class_count}
    {hbar}
    chart : Chart, default ALPHA_BETA
        Coordinates of the invariants: `ALPHA_BETA`, `R_VARTHETA` or `TWO_POLAR`.
    missing : float, default 1e-6
        Largest part of the function that the states may lack.
    {single_valued}

    Returns
    -------
    Packet
        Packet with norm^2 = 1 - ``missing``.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the function is not finite, the quadrature does not resolve it, an argument has a wrong value, or more than
        `missing` is lost. The message then has a sufficient number of levels.
    NoGroundState
        If the energy is unbounded below or the body does not bind that many levels.

    Notes
    -----
    - Method: c_k = ``<Psi_k|Psi>``/||Psi|| by Gauss-Legendre quadrature.
    - Accuracy: about 1e-9.
    - Cost: one call of `spectrum`, and milliseconds.

    References
    ----------
    Martens & Slawianowski, EQ4.3 (the states; the expansion is the spectral theorem).

    Examples
    --------
    >>> body = fa.Body(fa.Harmonic())
    >>> packet = fa.quantum.projected_packet(body, lambda a, b: np.exp(-(a**2 + b**2) / 2), m=0, l=0, count=3)
    >>> packet.weights.round(9)
    array([1.])
    """
    chosen = checked_class(m, l, single_valued)
    tolerance = fraction(missing)
    invariants = invariants_of(chart)
    if not callable(function):
        raise TypeError(f"function must be callable, got {shown(function)}")

    def values(grid: NodeGrid) -> np.ndarray:
        found = np.broadcast_to(np.asarray(function(*invariants.from_radii(*grid.radii))), grid.weights.shape)
        if found.dtype.kind not in "fiuc" or not np.isfinite(found).all():
            raise ValueError("function must return finite real or complex numbers in the domain of the body")
        return found

    def build(count: int) -> Packet:
        states = class_states(model, [chosen], count, hbar, single_valued)[0]
        tables, grid = resolved([states])
        box, orders = converged_box(states)
        square = []
        for growth in (1.0, GROWTH):
            outer = box.whole().grid((int(growth * orders[0]), int(growth * orders[1])))
            density = outer.weights * np.abs(values(outer)) ** 2
            square.append(float(density.sum()))
        if not square[1] > 0:
            raise ValueError("function must not vanish where the states of the body live")
        edge = max(density[-2:].sum(), density[:, -2:].sum() if box.ends[1][-1] != math.pi else 0.0)
        if abs(square[1] - square[0]) > (1e-3 * tolerance + 1e-9) * square[1] or edge > 1e-9 * square[1]:
            raise ValueError(
                f"function must be resolved by the lowest {count} states, which do not give its norm. Try more levels."
            )
        return kept_packet(
            states, tables[0].integrals(grid.weights * values(grid)) / math.sqrt(square[1]), hbar, tolerance
        )

    return holding(build, whole("count", count, 1), tolerance)


def class_states(
    model: Any, chosen: Sequence[SymmetryClass], count: int, hbar: float, single_valued: bool
) -> list[list[State]]:
    """Return the lowest states of each class."""
    if current_system(model).isotropic and solved_families(model):
        m, l = zip(*chosen, strict=True)
        found = spectrum_table(model, m=m, l=l, count=count, hbar=hbar, single_valued=single_valued)
    else:
        found = [spectrum(model, m=m, l=l, count=count, hbar=hbar, single_valued=single_valued) for m, l in chosen]
    return [[cast(State, table.state(k)) for k in range(count)] for table in found]


def kept_packet(states: list[State], coefficients: np.ndarray, hbar: float, missing: float) -> Packet:
    """Return the packet of the states that count: those left out have together no more than NOTHING of `missing`."""
    weights = np.abs(coefficients) ** 2
    kept = np.flatnonzero((weights > NOTHING * missing / weights.size) | (weights == weights.max()))
    return Packet(tuple(states[k] for k in kept), np.array([states[k].energy for k in kept]), coefficients[kept], hbar)


def holding(build: Callable[[int], Packet], count: int, missing: float) -> Packet:
    """Return build(count) if it lacks no more than `missing`; else raise an error with a sufficient count."""
    packet = build(count)
    if packet.missing <= missing:
        return packet
    enough = next((f"count = {more}" for more in (2 * count, 4 * count) if _lost(build, more) <= missing), None)
    raise ValueError(
        f"count = {count} levels in each class leave out {packet.missing:.2g} of the packet, more than missing = "
        f"{missing:.2g}. Try {enough or f'count > {4 * count}, or a larger missing'}."
    )


def _lost(build: Callable[[int], Packet], count: int) -> float:
    try:
        return build(count).missing
    except ValueError:  # more levels than can be computed
        return math.inf


def fraction(missing: Any) -> float:
    """Return `missing` as a number between 0 and 1."""
    part = real("missing", missing)
    if not 0 < part < 1:
        raise ValueError(f"missing must lie between 0 and 1, got {shown(missing)}")
    return part
