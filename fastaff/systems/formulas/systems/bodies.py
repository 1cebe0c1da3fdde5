"""Planar affinely-rigid bodies: in the two-polar chart, and with affinely invariant kinetic energies."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from ....core.numbers import positive, real
from ..grammar import parse
from .system import NamedSystem, chosen, makes, of_angles

TWO_POLAR = NamedSystem(
    "(p_1**2 + p_2**2 + ((p_phi - p_psi)**2/(D1 + D2)**2 + (p_phi + p_psi)**2/(D1 - D2)**2)/2)/(2*inertia)",
    "D1 D2 phi psi",
    "p_1 p_2 p_phi p_psi",
    "phi psi",
    of_angles,
)


@makes(TWO_POLAR)
def TwoPolarBody(
    potential: str = "C/2*(D1**2 + D2**2) + C/(D1*D2)",
    *,
    inertia: float = 1.0,
    domain: str | None = None,
    **parameters: float,
) -> Any:
    """Make a planar affinely-rigid body in its two-polar chart, the matrix O(phi) diag(D1, D2) O(psi)^T.

    2 mu H = p_1^2 + p_2^2 + (p_phi - p_psi)^2/2 (D1 + D2)^2 + (p_phi + p_psi)^2/2 (D1 - D2)^2 + 2 mu V(D1, D2).
    `Body` is the same in Cartesian planes, without singular points and faster.

    Parameters
    ----------
    potential : str
        V in the grammar of `affine_body`, of D1, D2 and parameters; the default, EQ2.2h, has the parameter C.
    inertia : float, default 1
        mu, positive.
    domain : str, optional
        Formula that is positive in the domain of V.
    **parameters : float
        Values of the parameters of V; the default potential has C = 1 unless it is given.

    Returns
    -------
    model
        As of `hamiltonian`, with the fields inertia and parameters, rows D1, D2, phi, psi, p_1, p_2, p_phi, p_psi.
        Orbits stay on one side of D1 = D2, where the chart is singular.

    Raises
    ------
    ValueError, TypeError
        As of `hamiltonian`, and where the inertia is not a positive number.

    Notes
    -----
    Conserved (`constants_of_motion`): energy, spin p_phi, vorticity p_psi. `charts.TWO_POLAR` turns phase points of
    `Body` into those of this chart and back.

    References
    ----------
    Martens & Slawianowski, EQ2.0, EQ2.0a, EQ2.1.

    Examples
    --------
    >>> body = fa.models.TwoPolarBody("C/2*(D1**2 + D2**2)", C=2.0)
    >>> float(body.energy(2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0))
    7.5
    """
    if not parameters and potential == "C/2*(D1**2 + D2**2) + C/(D1*D2)":
        parameters = {"C": 1.0}
    parse(potential, ("D1", "D2"), parameters, argument="potential")
    return TWO_POLAR.made({"inertia": positive("inertia", inertia), **parameters}, potential, domain)


_SPIN = ("x*p_x + y*p_y", "x*p_z + y*p_u", "z*p_x + u*p_y", "z*p_z + u*p_u")
_BODY_SPIN = ("x*p_x + z*p_z", "y*p_x + u*p_z", "x*p_y + z*p_u", "y*p_y + u*p_u")


def _kinetic(spin: tuple[str, ...], invariance: str) -> str:
    a, b, c, d = spin
    shear = f"(({a} - ({d}))**2 + ({b} + {c})**2)"
    turn = f"({b} - ({c}))**2"
    if invariance == "both":
        return f"({shear} - {turn})/(4*A) + ({a} + {d})**2/(4*(A + 2*B))"
    return f"{shear}/(4*(I + A)) + {turn}/(4*(I - A)) + ({a} + {d})**2/(4*(I + A + 2*B))"


def _of_affine(model: Any, z: np.ndarray) -> dict[str, Any]:
    x, y, z_, u, p_x, p_y, p_z, p_u = z
    left = x * p_x + y * p_y, x * p_z + y * p_u, z_ * p_x + u * p_y, z_ * p_z + u * p_u
    right = x * p_x + z_ * p_z, y * p_x + u * p_z, x * p_y + z_ * p_u, y * p_y + u * p_u
    found = {"energy": model.energy(*z), "p_phi": left[1] - left[2], "p_psi": right[2] - right[1]}
    places = ("11", "12", "21", "22")
    if model.formula in (AFFINE["left"].text, AFFINE["both"].text):
        found |= {f"Sigma_{place}": row for place, row in zip(places, left)}
    if model.formula in (AFFINE["right"].text, AFFINE["both"].text):
        found |= {f"Sigma_body_{place}": row for place, row in zip(places, right)}
    return found


AFFINE = {
    invariance: NamedSystem(_kinetic(spin, invariance), "x y z u", "p_x p_y p_z p_u", "", _of_affine)
    for invariance, spin in (("left", _BODY_SPIN), ("right", _SPIN), ("both", _SPIN))
}


@makes(*AFFINE.values())
def AffineBody(
    invariance: str = "left",
    *,
    I: float = 1.0,
    A: float = 0.5,
    B: float = 0.0,
    potential: str | None = None,
    **parameters: float,
) -> Any:
    """Make a planar affinely-rigid body with an affinely invariant kinetic energy.

    T = I/2 Tr(W^T W) + A/2 Tr(W^2) + B/2 (Tr W)^2, where W is the affine velocity in the body, phi^-1 phi', for "left"
    (T is invariant under phi -> g phi, deformations of space), and in space, phi' phi^-1, for "right" (phi -> phi g, of
    the body). "both" has I = 0; with A = 1, B = c/2 its T is (ds/dt)^2 of EQ6.22, of signature (+++-).

    Parameters
    ----------
    invariance : "left", "right" or "both"
        The action of GL(2, R) that leaves T unchanged.
    I, A, B : float
        Constants of inertia; T is positive where I > abs(A) and I + A + 2 B > 0. "both" has no I.
    potential : str, optional
        V in the grammar of `affine_body`, of ``det`` = D1 D2, ``r`` = D1^2 + D2^2 and parameters: any isotropic one.
    **parameters : float
        Values of the parameters of V.

    Returns
    -------
    model
        As of `hamiltonian`, with the fields I, A, B and parameters, in the matrix elements, rows x, y, z, u, p_x, p_y,
        p_z, p_u, phi = [[x, y], [z, u]]. T is a polynomial, without singular points.

    Raises
    ------
    ValueError, TypeError
        As of `hamiltonian`, and where invariance is none of these or the constants make T degenerate.

    Notes
    -----
    With ``Sigma = phi p^T`` (affine spin; in the body ``p^T phi``) T is ((S_11 - S_22)^2 + (S_12 + S_21)^2)/4 (I + A) +
    (S_12 - S_21)^2/4 (I - A) + (Tr S)^2/4 (I + A + 2 B), S in the body for "left". Conserved (`constants_of_motion`):
    energy, p_phi, p_psi; without V also Sigma, 11 to 22, for "left", Sigma_body for "right", and both for "both". Then
    phi(t) = exp(W t) phi(0) for "both"; for "left" with a steady turn of the body, for "right" of space.

    References
    ----------
    Martens & Slawianowski, section 7, EQ6.17-EQ6.22 (corrected: docs/physics); Slawianowski et al. 2004, Rep. Math.
    Phys. 54, 333.

    Examples
    --------
    >>> body = fa.models.AffineBody("both", A=1.0, B=0.5)
    >>> constants = fa.constants_of_motion(body, [1.0, 0.0, 0.0, 1.0, 0.2, 0.1, 0.3, 0.0])
    >>> list(constants)[3:8]
    ['Sigma_11', 'Sigma_12', 'Sigma_21', 'Sigma_22', 'Sigma_body_11']
    """
    invariance = chosen("invariance", invariance, tuple(AFFINE))
    constants = {"I": real("I", I), "A": real("A", A), "B": real("B", B)}
    if invariance == "both":
        constants["I"] = 0.0
    I, A, B = constants.values()
    if I + A == 0 or I == A or I + A + 2 * B == 0:
        raise ValueError(f"I + A, I - A and I + A + 2 B must not be 0, got I = {I}, A = {A}, B = {B}")
    if invariance == "both":
        del constants["I"]
    more = ""
    if potential is not None:
        parse(potential, ("det", "r"), parameters, argument="potential")
        of_elements = {"det": "(x*u - y*z)", "r": "(x**2 + y**2 + z**2 + u**2)"}
        more = re.sub(r"\b(det|r)\b", lambda found: of_elements[found[0]], potential)
    return AFFINE[invariance].made({**constants, **parameters}, more)
