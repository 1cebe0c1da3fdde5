"""The charts in which a body separates, its constants of motion there, and its data for kernels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.names import spelled
from ..core.numbers import kind_of, listed, shown
from ..engine.blocks import function_block
from ..engine.values import parameters
from ..results.progress import says_progress
from ..runs.requirements import checked_function, checked_system, current_system, phase_points
from ..systems.charts.chart import Chart
from ..systems.formulas.systems import constants_of
from ..systems.models import Zero
from ..systems.models.contracts import SeparableModel
from ..systems.models.regular_variables import in_regular_variable
from .families import FAMILIES, R_VARTHETA_FAMILY, Family, MotionQuantities
from .kernels.coordinates import PotentialTerm
from .narrow_features import knots, knots_around
from .r4_charts import R4_FAMILIES, R4Separated, central_body, r4_families
from .r4_tori import r4_constants


@dataclass(frozen=True)
class Separated:
    """A body in a chart of separation: its family, the functions of its coordinates and of eta and gamma, mu, and the
    breathing term c of T = mu ((1 + c) rho'^2 + ...)/2.
    """

    family: Family
    functions: tuple[Any, Any]
    angular: tuple[Any, Any]
    mu: float
    breathing: float = 0.0

    @property
    def radial_mu(self) -> float:
        """Inertia of the first coordinate, mu (1 + c)."""
        return self.mu * (1 + self.breathing)

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

    def terms(self) -> list[PotentialTerm]:
        """Return the terms of the potential in both coordinates, as kernels see them."""
        pairs = zip(self.functions, self.family.variables, strict=True)
        return [_term(in_regular_variable(V, variable), knots(V, variable)) for V, variable in pairs]

    def angular_terms(self) -> list[PotentialTerm]:
        """Return the terms in eta and gamma."""
        return [_term(V, knots_around(V)) for V in self.angular]

    def energy(self, constants: np.ndarray) -> np.ndarray:
        """Return the energy of the separation constants (4, ...)."""
        return self.family.energy(constants)

    def plane_actions(self, J: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the actions of the primitive cycles of eta and gamma."""
        return ((J[2] - J[3]) / 2, (J[2] + J[3]) / 2) if self.isotropic else (J[2], J[3])

    def turning_points(self, s: np.ndarray) -> np.ndarray:
        """Return both coordinates (2, ...) of their regular variables."""
        variables: tuple[Any, ...] = self.family.variables
        return np.array([variable.value(at) for variable, at in zip(variables, s, strict=True)])


def _term(V: Any, places: np.ndarray) -> PotentialTerm:
    return PotentialTerm(function_block(V), parameters(V), places)


def separate(model: Any, chart: Chart | str | None = None) -> Separated:
    """Return `model` in the chart it separates in (by default the first of alpha-beta, r-vartheta, elliptic).

    Raises TypeError for other values than a Body, StackelBody or BreathingBody, ValueError where the body does not
    separate, in that chart or in any.
    Source: Martens & Slawianowski, the separable Hamiltonians of section 3 (EQ2.2f and its neighbours).
    """
    name, possible = _candidates(model)
    if not possible:
        raise _nonseparable(name)
    wanted = _chart_name(chart, (family.chart for family in FAMILIES))
    found = [family for family in possible if wanted in (None, family.chart)]
    if not found:
        charts = listed(family.chart for family in possible)
        raise ValueError(f"chart must separate {name} in two coordinates ({charts}), got {shown(wanted, 40)}.")
    return _in_family(model, found[0])


def separate_anywhere(model: Any, chart: Chart | str | None = None) -> Separated | R4Separated:
    """Return `model` in a chart of `separate` or of R^4, by default the first in which it separates.

    Raises as `separate`.
    """
    name, possible = _candidates(model)
    wanted = _chart_name(chart, (family.chart for family in (*FAMILIES, *R4_FAMILIES)))
    found = [family for family in possible if wanted in (None, family.chart)]
    if found:
        return _in_family(model, found[0])
    if _breathes(model):
        raise _elsewhere(name, wanted, (family.chart for family in possible))
    central = checked_system(model).model
    body = central_body(central)
    more = r4_families(body)
    if not possible and not more:
        raise _nonseparable(name)
    chosen = [family for family in more if wanted in (None, family.chart)]
    if not chosen or body is None:
        raise _elsewhere(name, wanted, (family.chart for family in (*possible, *more)))
    return R4Separated(chosen[0], body, central.mu)


def _candidates(model: Any) -> tuple[str, list[Family]]:
    """Return the name of a body's potential, and the families that it is a member of.

    A breathing term leaves r and vartheta alone; without that family the body is refused here.
    """
    breathes = _breathes(model)
    system = checked_system(model) if breathes else checked_system(model, needs="H = T(p) + V(q)")
    if not (system.planar or breathes):
        raise TypeError(f"model must be a separable Body, got {kind_of(model)}. Use fa.fit_torus for other systems.")
    potential = system.model.potential
    name = type(potential).__name__
    possible = [family for family in FAMILIES if hasattr(potential, family.member)]
    if not breathes:
        return name, possible
    if R_VARTHETA_FAMILY not in possible:
        raise _nonseparable(name, " in r and vartheta")
    return name, [R_VARTHETA_FAMILY]


def _breathes(model: Any) -> bool:
    """Whether the kinetic energy of a body has a breathing term."""
    return hasattr(model, "breathing")


def _chart_name(chart: Any, names: Iterable[str]) -> str | None:
    """Return the name of a chart, given as itself or by name."""
    wanted = getattr(chart, "name", chart)
    if chart is not None and not isinstance(wanted, str):
        raise TypeError(
            f"chart must be a chart such as fastaff.charts.ALPHA_BETA, or its name, got {shown(chart)} "
            f"({type(chart).__name__})"
        )
    return wanted if wanted is None else spelled(wanted, names)


def _nonseparable(name: str, where: str = "") -> ValueError:
    """Return the error for a body that separates in no chart."""
    return ValueError(f"model must be separable{where}, got a Body of {name}. Use fa.fit_torus for other bodies.")


def _elsewhere(name: str, wanted: str | None, charts: Iterable[str]) -> ValueError:
    """Return the error for a chart in which a body does not separate."""
    return ValueError(f"chart must separate {name} ({listed(charts)}), got {shown(wanted, 40)}.")


def _in_family(model: Any, family: Family) -> Separated:
    """Return a body as a member of a family, whose functions are checked."""
    system = checked_system(model)
    member = getattr(system.model.potential, family.member)
    for field, function in zip(member._fields, member, strict=True):
        checked_function(field, function)
    spins = system.isotropic or _breathes(model)
    angular = (Zero(), Zero()) if spins else (system.model.V_eta, system.model.V_gamma)
    return Separated(family, tuple(member), angular, system.model.mu, float(getattr(model, "breathing", 0.0)))


@says_progress
def constants_of_motion(
    model: SeparableModel, z: ArrayLike, *, chart: Chart | str | None = None
) -> dict[str, np.ndarray]:
    """Compute the constants of motion of a separable body, a body in space or a named system.

    Parameters
    ----------
    model : Body, StackelBody, Body3 or named system
        Body with a separable potential, body in space, or a system of ``fastaff.models`` with known constants, such as
        `AsymmetricTop`.
    z : array_like, shape (2n,) or (2n, orbits)
        Phase points; 2n is 8 for a body.
    chart : Chart or str, optional
        Coordinates in which the body separates: `ALPHA_BETA`, `R_VARTHETA`, `ELLIPTIC`, `SPHERICAL`,
        `SPHERICAL_CARTESIAN`, `POLAR_POLAR`, `POLAR_CARTESIAN` or `CARTESIAN`. Default: the first of these. Not
        supported for named systems.

    Returns
    -------
    dict of ndarray, shape (orbits,)
        Constants by name. Bodies have H_alpha and H_beta, or E and h_vartheta, or E, K and L = E - K, with p_phi and
        p_psi. If the angles have potentials, c_eta = p_eta^2/(2 mu) + V_eta(eta) and c_gamma replace p_phi and p_psi.
        `SPHERICAL` has E, the angular momenta L_4 and L_3 of (x, y, z, u) and (x, y, z), and p_nu. Mixed charts have
        the energies of their subspaces. Bodies in space have energy, spin_x, spin_y, spin_z, vorticity_1, vorticity_2
        and vorticity_3. ``exact_body`` of a molecule has energy and p_phi. The constants of a named system are in its
        docstring.

    Raises
    ------
    TypeError
        If the model is neither a body nor a named system.
    ValueError
        If the body does not separate in the chart or in any, or `z` has a wrong shape.

    Notes
    -----
    - ``H_alpha = |p_a|^2/(2 mu) + V_alpha + V_eta/alpha^2``
    - h_vartheta = sum over i < j of (q_i p_j - q_j p_i)^2/(2 mu) + V_vartheta + ...
    - K = (h_kappa cos^2 lambda + h_lambda cosh^2 kappa)/(2 Delta), with the plus sign that the printed formula lacks.
      It equals ``|p_a|^2/(2 mu) + (sum of squares)/(4 mu)`` plus potentials.
    - The formulas are regular wherever the potential is.

    References
    ----------
    Martens & Slawianowski, EQ2.1b, EQ2.2f and K, L of section 3 (corrected).

    Examples
    --------
    >>> constants = fa.constants_of_motion(fa.Body(fa.Harmonic()), [1.0, 0.0, 0.5, 0.0, 0.2, 0.5, 0.0, 0.3])
    >>> list(constants)
    ['H_alpha', 'H_beta', 'p_phi', 'p_psi']
    """
    named = constants_of(model) if chart is None else None
    if named is None and chart is None and hasattr(model, "constants"):
        return dict(model.constants(phase_points("z", z, checked_system(model))))
    if named is not None:
        return named(model, phase_points("z", z, current_system(model)))
    separated = separate_anywhere(model, chart)
    points = phase_points("z", z, current_system(model))
    if isinstance(separated, R4Separated):
        return dict(zip(separated.constants, r4_constants(separated, points), strict=True))
    return involution(model, separated, points)


def involution(model: Any, separated: Separated, z: np.ndarray) -> dict[str, np.ndarray]:
    """Return the constants of z (8, ...)."""
    mu = separated.mu
    V_eta, V_gamma = separated.angular
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = z
    A = a1 * a1 + a2 * a2
    B = b1 * b1 + b2 * b2
    p_eta = a1 * pa2 - a2 * pa1
    p_gamma = b1 * pb2 - b2 * pb1
    T_a = (pa1 * pa1 + pa2 * pa2) / (2 * mu)
    T_b = (pb1 * pb1 + pb2 * pb2) / (2 * mu)
    h = sum((z[i] * z[4 + j] - z[j] * z[4 + i]) ** 2 for i in range(4) for j in range(i)) / (2 * mu)
    at_eta = None if isinstance(V_eta, Zero) else V_eta.value(np.arctan2(a2, a1))
    at_gamma = None if isinstance(V_gamma, Zero) else V_gamma.value(np.arctan2(b2, b1))
    c = separated.breathing
    radial = (a1 * pa1 + a2 * pa2 + b1 * pb1 + b2 * pb2) ** 2 / (A + B) if c else 0.0
    at = MotionQuantities(
        A=A,
        B=B,
        T_a=T_a,
        T_b=T_b,
        h=h,
        V=model.potential.value(A, B),
        V_eta=at_eta,
        V_gamma=at_gamma,
        breathing=-c / (1 + c) * radial / (2 * mu),
    )
    values = separated.family.values(*separated.functions, at)
    if separated.isotropic:
        return values | {"p_phi": p_gamma + p_eta, "p_psi": p_gamma - p_eta}
    c_eta, c_gamma = (p**2 / (2 * mu) + (0.0 if V is None else V) for p, V in ((p_eta, at_eta), (p_gamma, at_gamma)))
    return values | {"c_eta": c_eta, "c_gamma": c_gamma}
