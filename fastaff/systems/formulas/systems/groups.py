"""Motion on the compact form of GL+(2,R), the unitary group U(2)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....core.docstrings import inserts_parameters
from ....core.numbers import positive, real, shown
from ..grammar import parse
from .system import NamedSystem, makes


def _of_unitary(model: Any, z: np.ndarray) -> dict[str, Any]:
    _, _, Theta, _, p_a, p_Phi, p_Theta, p_Psi = z
    found = {"energy": model.energy(*z), "p_Phi": p_Phi, "p_Psi": p_Psi}
    if model.formula == UNITARY_GROUP.text:
        square = (p_Phi**2 + p_Psi**2 - 2 * np.cos(Theta) * p_Phi * p_Psi) / np.sin(Theta) ** 2
        found |= {"p_a": p_a, "J2": p_Theta**2 + square}
    return found


UNITARY_GROUP = NamedSystem(
    "2*(p_a**2/(1 + c) + p_Theta**2 + (p_Phi**2 + p_Psi**2 - 2*cos(Theta)*p_Phi*p_Psi)/sin(Theta)**2)/inertia",
    "a Phi Theta Psi",
    "p_a p_Phi p_Theta p_Psi",
    "a Phi Theta Psi",
    _of_unitary,
)


@makes(UNITARY_GROUP)
@inserts_parameters
def UnitaryBody(
    potential: str | None = None,
    *,
    inertia: float = 1.0,
    c: float = 0.0,
    domain: str | None = None,
    **parameters: float,
) -> Any:
    """Make a system on U(2), the compact form of the affinely invariant body.

    The matrix is e^(i a/2) exp(Phi tau_2) exp(Theta tau_3) exp(Psi tau_2).

    Parameters
    ----------
    potential : str, optional
        Formula of V, in the grammar of `affine_body`, of a, Theta and parameters, with the period 2 pi in a.
    inertia : float, default 1
        Inertia mu, positive: T = (mu/2) (ds/dt)^2.
    c : float, default 0
        Weight of the dilatational term of the metric, above -1.
    {formula_domain}
    {formula_parameters}

    Returns
    -------
    model
        Model of `hamiltonian` with the inertia, c and the parameters as fields. Its rows are a, Phi, Theta, Psi, p_a,
        p_Phi, p_Theta, p_Psi, with angles in radians.

    Raises
    ------
    TypeError
        If `potential` is not a text, or if a value is not a number.
    ValueError
        If `potential` is not a formula, the inertia is not positive, or c is not above -1.
    ImportError
        If SymPy is missing and the formula is new.

    Notes
    -----
    * Hamiltonian: ``H = (2/mu) (p_a^2/(1 + c) + p_Theta^2 + (p_Phi^2 + p_Psi^2 - 2 cos Theta p_Phi p_Psi)/sin(Theta)^2)
      + V``.
    * Conserved (`constants_of_motion`): energy, p_Phi, p_Psi. Without V also p_a and J2, the square of the angular
      momentum.
    * Motion without V: phi(t) = exp(W t) phi(0), `geodesic` of ``fastaff.systems.invariant_metrics.UNITARY``.
    * The chart is singular at Theta = 0 and pi, which orbits with ``|p_Phi|`` other than ``|p_Psi|`` do not reach.
    * (a + 2 pi, Psi + 2 pi) and (a, Psi) are the same matrix.

    References
    ----------
    Martens & Slawianowski, EQ6.16.

    Examples
    --------
    >>> body = fa.models.UnitaryBody(inertia=2.0, c=0.5)
    >>> float(body.energy(0.0, 0.0, np.pi / 2, 0.0, 1.5, 0.0, 1.0, 0.0))
    2.5
    """
    size = positive("inertia", inertia)
    weight = real("c", c)
    if not weight > -1:
        raise ValueError(f"c must be above -1, got {shown(c)}. Elsewhere the metric of U(2) is not positive.")
    if potential is not None:
        parse(potential, ("a", "Theta"), parameters, argument="potential")
    return UNITARY_GROUP.made({"inertia": size, "c": weight, **parameters}, potential or "", domain)
