"""Planar affinely-rigid bodies: in the two-polar chart, and with affinely invariant kinetic energies."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np

from ....core.docstrings import inserts_parameters
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
@inserts_parameters
def TwoPolarBody(
    potential: str = "C/2*(D1**2 + D2**2) + C/(D1*D2)",
    *,
    inertia: float = 1.0,
    domain: str | None = None,
    **parameters: float,
) -> Any:
    """Make a planar affinely-rigid body in its two-polar chart.

    The chart is phi = O(phi) diag(D1, D2) O(psi)^T. `Body` is the same system in Cartesian planes: it has no singular
    points and is faster.

    Parameters
    ----------
    potential : str, default "C/2*(D1**2 + D2**2) + C/(D1*D2)"
        Formula of V, in the grammar of `affine_body`, of D1, D2 and parameters. The default is EQ2.2h; its parameter C
        is 1 unless you give it.
    inertia : float, default 1
        Inertia mu, positive.
    {formula_domain}
    {formula_parameters}

    Returns
    -------
    model
        Model of `hamiltonian` with the inertia and the parameters as fields. Its rows are D1, D2, phi, psi, p_1, p_2,
        p_phi, p_psi.

    Raises
    ------
    TypeError
        If `potential` is not a text, or if a value is not a number.
    ValueError
        If `potential` is not a formula, or if the inertia is not positive.
    ImportError
        If SymPy is missing and the formula is new.

    Notes
    -----
    * Hamiltonian: ``2 mu H = p_1^2 + p_2^2 + (p_phi - p_psi)^2/(2 (D1 + D2)^2) + (p_phi + p_psi)^2/(2 (D1 - D2)^2) + 2
      mu V``.
    * Conserved (`constants_of_motion`): energy, spin p_phi, vorticity p_psi.
    * The chart is singular at D1 = D2; orbits stay on one side.
    * `TWO_POLAR` converts phase points of `Body` to this chart and back.

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


_OF_ELEMENTS = {"det": "(x*u - y*z)", "r": "(x**2 + y**2 + z**2 + u**2)"}
"""Variables of a potential, in matrix elements."""

AFFINE = {
    invariance: NamedSystem(_kinetic(spin, invariance), "x y z u", "p_x p_y p_z p_u", "", _of_affine)
    for invariance, spin in (("left", _BODY_SPIN), ("right", _SPIN), ("both", _SPIN))
}


@makes(*AFFINE.values())
@inserts_parameters
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

    Parameters
    ----------
    invariance : {"left", "right", "both"}, default "left"
        Action of GL(2, R) that leaves the kinetic energy T unchanged.

        * "left": phi -> g phi, deformations of space. The affine velocity is W = phi^-1 phi', in the body.
        * "right": phi -> phi g, deformations of the body. The affine velocity is W = phi' phi^-1, in space.
        * "both": as "right" with I = 0.
    I, A, B : float, default 1, 0.5 and 0
        Constants of inertia. T is positive if I > abs(A) and I + A + 2 B > 0. For "both" I is not used.
    potential : str, optional
        Formula of V, in the grammar of `affine_body`, of ``det`` = D1 D2, ``r`` = D1^2 + D2^2 and parameters. Every
        isotropic potential can be written so.
    {formula_parameters}

    Returns
    -------
    model
        Model of `hamiltonian` with I, A, B and the parameters as fields. Its rows are x, y, z, u, p_x, p_y, p_z, p_u,
        with phi = [[x, y], [z, u]]. T is a polynomial without singular points.

    Raises
    ------
    TypeError
        If `invariance` or `potential` is not a text, or if a value is not a number.
    ValueError
        If `invariance` is another text, if the constants make T degenerate, or if `potential` is not a formula.
    ImportError
        If SymPy is missing and the formula is new.

    Notes
    -----
    * T = I/2 Tr(W^T W) + A/2 Tr(W^2) + B/2 (Tr W)^2. For "both", A = 1 and B = c/2 give (ds/dt)^2 of EQ6.22, of
      signature (+++-).
    * With the affine spin ``S = phi p^T``, for "left" ``p^T phi``: T = ((S_11 - S_22)^2 + (S_12 + S_21)^2)/4(I + A) +
      (S_12 - S_21)^2/4(I - A) + (Tr S)^2/4(I + A + 2 B).
    * Conserved (`constants_of_motion`): energy, p_phi, p_psi. Without V also Sigma_11 to Sigma_22 for "left",
      Sigma_body for "right", all for "both".
    * Motion without V: phi(t) = exp(W t) phi(0) for "both"; a steady rotation of the body ("left") or of space
      ("right") is added.

    References
    ----------
    Martens & Slawianowski, section 7, EQ6.17-EQ6.22 (corrected: docs/reference/formulas); Slawianowski et al. 2004,
    Rep. Math. Phys. 54, 333.

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
        more = re.sub(r"\b(det|r)\b", lambda found: _OF_ELEMENTS[found[0]], potential)
    return AFFINE[invariance].made({**constants, **parameters}, more)


class AffineParts(NamedTuple):
    """Constants of an `AffineBody` (I = 0 for "both") and its potential in matrix elements, "" for none."""

    invariance: str
    I: float
    A: float
    B: float
    potential: str

    def written(self) -> str:
        """Return the potential as the user wrote it."""
        text = self.potential
        for variable, elements in _OF_ELEMENTS.items():
            text = text.replace(elements, variable)
        return text


def affine_parts(model: Any) -> AffineParts | None:
    """Return the parts of an `AffineBody`, None for other models."""
    text: Any = getattr(model, "formula", None)
    rows = [getattr(model, name, ()) for name in ("coordinates", "momenta")]
    for invariance, system in AFFINE.items():
        own = isinstance(text, str) and (text == system.text or text.startswith(f"{system.text} + ("))
        if own and rows == [tuple(system.coordinates.split()), tuple(system.momenta.split())]:
            I, A, B = (float(getattr(model, name, 0.0)) for name in ("I", "A", "B"))
            return AffineParts(invariance, I, A, B, text[len(system.text) + len(" + (") : -1])
    return None
