"""Which charts a body separates in, its constants of motion there, and what kernels need of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.numbers import shown
from ...compile.blocks import function_block, parameters
from ...flows.checks import checked_function, checked_model, phase_points
from ...models import SeparableElliptic, Zero
from ...models.contracts import isotropic
from .narrow_features import knots


@dataclass(frozen=True)
class Family:
    """One of the charts in which bodies separate: what its coordinates and constants are called, in the kernels' order.

    member: the property of a potential that gives it as a member of the family; variables: the coordinate's text in
    terms of its regular variable s, in which kernels work; eigenvalues: names of the quantum constants; additive:
    whether the energy is the sum of both constants, not the first.
    """

    code: int
    member: str
    chart: str
    coordinates: tuple[str, str]
    constants: tuple[str, str]
    variables: tuple[str, str]
    eigenvalues: tuple[str, str]
    additive: bool

    def energy(self, constants: Any) -> Any:
        """Return the energy of the two separation constants (2, ...)."""
        return constants[0] + constants[1] if self.additive else constants[0]

    def coordinate(self, i: int, s: np.ndarray) -> np.ndarray:
        """Return coordinate i of its regular variable."""
        return _COORDINATES[self.variables[i]](s)


_COORDINATES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "np.sqrt({})": np.sqrt,
    "{}": lambda s: s,
    "2*np.arcsin(np.sqrt({}))": lambda s: 2 * np.arcsin(np.sqrt(s)),
    "np.arcsin(np.sqrt({}))": lambda s: np.arcsin(np.sqrt(s)),
    "np.arcsinh(np.sqrt({}))": lambda s: np.arcsinh(np.sqrt(s)),
}
FAMILIES = (
    Family(
        0,
        "alpha_beta",
        "alpha-beta",
        ("alpha", "beta"),
        ("H_alpha", "H_beta"),
        ("np.sqrt({})", "np.sqrt({})"),
        ("E_alpha", "E_beta"),
        True,
    ),
    Family(
        1,
        "r_vartheta",
        "r-vartheta",
        ("r", "vartheta"),
        ("E", "h_vartheta"),
        ("{}", "2*np.arcsin(np.sqrt({}))"),
        ("E", "e_vartheta"),
        False,
    ),
    Family(
        2,
        "elliptic",
        "elliptic",
        ("kappa", "lambda"),
        ("E", "K"),
        ("np.arcsinh(np.sqrt({}))", "np.arcsin(np.sqrt({}))"),
        ("E", "K"),
        False,
    ),
)


@dataclass(frozen=True)
class Separated:
    """A body in a chart that it separates in: its family, the functions of its coordinates and of eta and gamma, mu."""

    family: Family
    functions: tuple[Any, Any]
    angular: tuple[Any, Any]
    mu: float

    @property
    def isotropic(self) -> bool:
        """Whether neither angle has a potential, so that spin and vorticity are constants."""
        return all(isinstance(V, Zero) for V in self.angular)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows of actions, frequencies and angles."""
        return (*self.family.coordinates, *(("phi", "psi") if self.isotropic else ("eta", "gamma")))

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of the four constants of motion in involution."""
        return (*self.family.constants, *(("p_phi", "p_psi") if self.isotropic else ("c_eta", "c_gamma")))

    def blocks(self) -> tuple[Any, ...]:
        """Return block function and parameters of the two coordinates' potentials."""
        pairs = zip(self.functions, self.family.variables, strict=True)
        return tuple(part for V, variable in pairs for part in (function_block(V, variable), parameters(V)))

    def knots(self) -> tuple[np.ndarray, ...]:
        """Return the knots of the potentials of both coordinates, and of those of eta and gamma: where they have narrow
        features.
        """
        kinds = {
            "np.sqrt({})": "x^2",
            "{}": "r",
            "2*np.arcsin(np.sqrt({}))": "sin^2(x/2)",
            "np.arcsin(np.sqrt({}))": "sin^2",
            "np.arcsinh(np.sqrt({}))": "sinh^2",
        }
        own = [knots(V, kinds[variable]) for V, variable in zip(self.functions, self.family.variables, strict=True)]
        return (*own, *(knots(V, "angle") for V in self.angular))

    def angular_blocks(self) -> tuple[Any, ...]:
        """Return block function and parameters of the angles' potentials."""
        return tuple(part for V in self.angular for part in (function_block(V, "{}"), parameters(V)))


def separate(body: Any, chart: Any = None) -> Separated:
    """Return `body` in the chart it separates in (by default the first of alpha-beta, r-vartheta, elliptic).

    Raises TypeError for what is no Body or StackelBody, ValueError where the body does not separate, in that chart or
    in any.
    Source: Martens & Slawianowski, the separable Hamiltonians of section 3 (EQ2.2f and its neighbours).
    """
    checked_model(body)
    if not hasattr(body, "potential") or not hasattr(body, "isotropic"):
        raise TypeError(f"body must be a Body or a StackelBody, got {type(body).__name__}")
    name = type(body.potential).__name__
    possible = [family for family in FAMILIES if hasattr(body.potential, family.member)]
    if not possible:
        raise ValueError(
            f"body must separate: {name} is in none of the families SeparableAlphaBeta, SeparableRVartheta, "
            "SeparableElliptic "
            "(a potential joins one by a property alpha_beta, r_vartheta or elliptic); for other bodies use fit_torus"
        )
    wanted = getattr(chart, "name", chart)
    if chart is not None and not isinstance(wanted, str):
        raise TypeError(
            f"chart must be a chart such as fastaff.charts.ALPHA_BETA, or its name, got {shown(chart)} "
            f"({type(chart).__name__})"
        )
    chosen = [family for family in possible if chart is None or family.chart == wanted]
    if not chosen:
        raise ValueError(
            f"chart must be one that {name} separates in, {', '.join(family.chart for family in possible)}; got "
            f"{wanted!r}"
        )
    member = getattr(body.potential, chosen[0].member)
    for field, function in zip(member._fields, member, strict=True):
        checked_function(field, function)
    angular = (Zero(), Zero()) if isotropic(body) else (body.V_eta, body.V_gamma)
    return Separated(chosen[0], tuple(member), angular, body.mu)


def constants_of_motion(body: Any, z: ArrayLike, *, chart: Any = None) -> dict[str, np.ndarray]:
    """Compute the four constants of motion in involution of a separable body.

    body: Body or StackelBody of a separable potential; z: (8,) or (8, orbits); chart: one that it separates in (see
    `separate`). Returns a dict of arrays (orbits,): H_alpha and H_beta, or E and h_vartheta, or E, K and L = E - K,
    with p_phi and p_psi, where the angles have potentials c_eta = p_eta^2/(2 mu) + V_eta(eta) and c_gamma instead.
    Raises TypeError or ValueError as `separate`. Formulas, regular in all R^4 where the potential is: H_alpha =
    |p_a|^2/(2 mu) + V_alpha + V_eta/alpha^2; h_vartheta = sum over i < j of (q_i p_j - q_j p_i)^2/(2 mu) + V_vartheta +
    ...; K = (h_kappa cos^2 lambda + h_lambda cosh^2 kappa)/ (2 Delta), with the plus sign that the printed formula
    lacks, is |p_a|^2/(2 mu) + (sum of squares)/(4 mu) + potentials.
    Source: Martens & Slawianowski, EQ2.1b, EQ2.2f and K, L of section 3 (corrected).
    """
    separated = separate(body, chart)
    return involution(body, separated, phase_points("z", z, body))


def involution(body: Any, separated: Separated, z: np.ndarray) -> dict[str, np.ndarray]:
    """Return the constants of z (8, ...)."""
    mu, (first, second), (V_eta, V_gamma) = separated.mu, separated.functions, separated.angular
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = z
    A, B = a1 * a1 + a2 * a2, b1 * b1 + b2 * b2
    p_eta, p_gamma = a1 * pa2 - a2 * pa1, b1 * pb2 - b2 * pb1
    T_a, T_b = (pa1 * pa1 + pa2 * pa2) / (2 * mu), (pb1 * pb1 + pb2 * pb2) / (2 * mu)
    h = sum((z[i] * z[4 + j] - z[j] * z[4 + i]) ** 2 for i in range(4) for j in range(i)) / (2 * mu)
    at_eta = 0.0 if isinstance(V_eta, Zero) else V_eta.value(np.arctan2(a2, a1))
    at_gamma = 0.0 if isinstance(V_gamma, Zero) else V_gamma.value(np.arctan2(b2, b1))
    wall_a, wall_b = (
        0.0 if isinstance(V, Zero) else at / square for V, at, square in ((V_eta, at_eta, A), (V_gamma, at_gamma, B))
    )
    code, r, walls = separated.family.code, A + B, wall_a + wall_b
    if code == 0:
        values = [T_a + first.value(np.sqrt(A)) + wall_a, T_b + second.value(np.sqrt(B)) + wall_b]
    elif code == 1:
        values = [h + second.value(2 * np.arctan2(np.sqrt(B), np.sqrt(A))) + r * walls]
        values.insert(0, T_a + T_b + first.value(r) + (values[0] - h) / r)
    else:
        s, t = SeparableElliptic(first, second).squares(A, B)
        # The separated form is 0/0 at the focus, the undeformed body; V itself is not.
        W, V = second.value(np.arcsin(np.sqrt(t))), body.potential.value(A, B)
        E = T_a + T_b + V + walls
        K = T_a + h / 2 + V * (1 - t) + W / 2
        K = K + at_eta * (2 + s - t) / (2 * (1 + s) * (1 - t))
        K = K if isinstance(V_gamma, Zero) else K + at_gamma * (1 + s - t) / (2 * s * t)
        values = [E, K]
    names = dict(zip(separated.family.constants, values, strict=True))
    if code == 2:
        names["L"] = names["E"] - names["K"]
    if separated.isotropic:
        return names | {"p_phi": p_gamma + p_eta, "p_psi": p_gamma - p_eta}
    return names | {"c_eta": p_eta**2 / (2 * mu) + at_eta, "c_gamma": p_gamma**2 / (2 * mu) + at_gamma}
