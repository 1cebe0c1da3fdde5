"""The planar affinely-rigid body in the two planes a and b of GL(2,R)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ...core.docstrings import inserts_parameters
from ...core.numbers import shown
from .angles import AreaTrace, Coordinates2
from .constructors import checks_arguments
from .contracts import Arithmetic
from .energy_method import energy_method

TERMS = ("friction", "drive_period", "period", "damping", "forcing", "drive")
FREE = "For friction or a drive use hamiltonian(..., friction=0.1, drive_period=6.28) or ode(body, forces=...)."
"""Advice where a body should be damped or driven."""


def _is_planar(arguments: Mapping[str, Any]) -> None:
    """Name the systems that have friction or a drive, which bodies do not have, and refuse a model or a potential of
    3x3 matrices in place of a planar potential.
    """
    for name in TERMS:
        if name in arguments:
            raise TypeError(f"Body takes potential and mu, got {name}={shown(arguments[name], 20)}. {FREE}")
    potential = arguments.get("potential")
    if isinstance(potential, type):
        return
    if hasattr(potential, "matrix_value"):
        raise TypeError(
            f"potential must be a potential of A and B, got {type(potential).__name__}. Use fa.models.Body3 for "
            "3x3 matrices."
        )
    if hasattr(potential, "degrees_of_freedom") and not hasattr(potential, "slopes"):
        mass = ", its mass by fa.affine_body(..., mu=)" if hasattr(potential, "mu") else ""
        raise TypeError(
            "potential must be a potential of A and B (value, slopes, margin), got a model. Pass "
            f"{type(potential).__name__} without Body{mass}."
        )


@checks_arguments(_is_planar)
@inserts_parameters
class Body(NamedTuple):
    """Model the planar affinely-rigid body with a doubly isotropic potential.

    Parameters
    ----------
    potential : potential
        Potential of ``fastaff.models``, such as `NeoHookean`, or any NamedTuple with the methods value, slopes,
        curvatures and margin.
    {inertia}

    Raises
    ------
    TypeError
        If `potential` is a model itself, or if friction or a drive is given. A body has neither: use `hamiltonian` or
        `ode`.

    Notes
    -----
    * Hamiltonian: ``H = |p|^2/(2 mu) + V(|a|^2, |b|^2)``.
    * Rows of a phase point: a1, a2, b1, b2, then their momenta.
    * Planes: a = (x + u, z - y)/sqrt2 and b = (x - u, y + z)/sqrt2 of phi = [[x, y], [z, u]].
    * Invariants and angles: ``alpha = |a|, beta = |b|``, eta = arg a, gamma = arg b.

    References
    ----------
    Martens & Slawianowski, EQ2.1 (Hamiltonian), EQ2.0b (invariants and angles).

    Examples
    --------
    >>> body = fa.Body(fa.NeoHookean(K=2.0))
    >>> round(fa.integrate(body, [1.5, 0, 0.2, 0, 0, 0.3, 0, 0.1], time=1.0)["alpha"].item(), 6)
    1.381952
    """

    potential: Any
    mu: float = 1.0

    @property
    def degrees_of_freedom(self) -> int:
        """Return 4."""
        return 4

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the first 4 rows of z."""
        return "a1", "a2", "b1", "b2"

    @property
    def isotropic(self) -> bool:
        """Whether p_eta and p_gamma are conserved: yes."""
        return True

    @property
    def angles(self) -> Any:
        """Angle variables natural to the potential: its own `angles`, else loops in area and trace."""
        return getattr(self.potential, "angles", AreaTrace())

    def velocity(self, pa1, pa2, pb1, pb2):
        """Return the velocity dq/dt = p/mu.

        Parameters
        ----------
        {plane_momenta}

        Returns
        -------
        tuple of float or ndarray
            Four rows: the rates of a1, a2, b1, b2.
        """
        w = 1.0 / self.mu
        return w * pa1, w * pa2, w * pb1, w * pb2

    @property
    def energy(self) -> Arithmetic:
        """Function H(q..., p...): ``model.energy(*z)`` for phase points z (2n, ...), NaN outside the domain."""
        return energy_method(self)

    def kinetic_energy(self, pa1, pa2, pb1, pb2):
        """Return the kinetic energy.

        Parameters
        ----------
        {plane_momenta}

        Returns
        -------
        float or ndarray
            Energy T = ``|p|^2``/(2 mu).
        """
        return (pa1 * pa1 + pa2 * pa2 + pb1 * pb1 + pb2 * pb2) / (2 * self.mu)

    def force(self, a1, a2, b1, b2):
        """Return the force dp/dt = -grad V.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        tuple of float or ndarray
            Four rows: the rates of the momenta.
        """
        V_A, V_B = self.potential.slopes(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)
        return -2 * V_A * a1, -2 * V_A * a2, -2 * V_B * b1, -2 * V_B * b2

    def tangent_force(self, a1, a2, b1, b2, da1, da2, db1, db2):
        """Return the change of the force along a vector.

        Parameters
        ----------
        {plane_coordinates}
        {plane_changes}

        Returns
        -------
        tuple of float or ndarray
            Four rows: minus the Hessian of V times the vector.
        """
        A = a1 * a1 + a2 * a2
        B = b1 * b1 + b2 * b2
        dA = 2 * (a1 * da1 + a2 * da2)
        dB = 2 * (b1 * db1 + b2 * db2)
        V_A, V_B = self.potential.slopes(A, B)
        V_AA, V_AB, V_BB = self.potential.curvatures(A, B)
        dV_A = V_AA * dA + V_AB * dB
        dV_B = V_AB * dA + V_BB * dB
        return (
            -2 * (dV_A * a1 + V_A * da1),
            -2 * (dV_A * a2 + V_A * da2),
            -2 * (dV_B * b1 + V_B * db1),
            -2 * (dV_B * b2 + V_B * db2),
        )

    def potential_energy(self, a1, a2, b1, b2):
        """Return the potential energy.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.potential.value(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)

    def margin(self, a1, a2, b1, b2):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        float or ndarray
            Margin of the potential.
        """
        return self.potential.margin(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)

    @property
    def poles_of(self) -> str:
        """Name of the field that gives its poles."""
        return "potential"

    def poles(self, a1, a2, b1, b2):
        """Return numbers whose integer parts change at poles of the potential.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        tuple of float or ndarray
            Numbers of the potential. Only a potential that has `poles` has them.
        """
        return self.potential.poles(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)


class HenonHeiles(NamedTuple):
    """Model two oscillators with a cubic coupling.

    Parameters
    ----------
    lam : float, default 1
        Strength of the coupling. The motion is bounded if 6 lam^2 E < 1.

    Notes
    -----
    The Hamiltonian is ``H = (px^2 + py^2 + x^2 + y^2)/2 + lam (x^2 y - y^3/3)``.

    References
    ----------
    Henon & Heiles 1964, Astron. J. 69, 73 (lam = 1).

    Examples
    --------
    >>> fa.HenonHeiles().potential_energy(0.0, 1.0)
    0.16666666666666669
    """

    lam: float = 1.0

    @property
    def degrees_of_freedom(self) -> int:
        """Return 2."""
        return 2

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the first 2 rows of z."""
        return "x", "y"

    @property
    def angles(self) -> Coordinates2:
        """Angle variables natural to this system."""
        return Coordinates2()

    def velocity(self, px, py):
        """Return the velocity dq/dt = p.

        Parameters
        ----------
        px, py : float or array_like
            Momenta.

        Returns
        -------
        tuple of float or ndarray
            Rates of x and y.
        """
        return px, py

    def force(self, x, y):
        """Return the force dp/dt = -grad V.

        Parameters
        ----------
        x, y : float or array_like
            Coordinates.

        Returns
        -------
        tuple of float or ndarray
            Rates of the momenta.
        """
        return -x - 2 * self.lam * x * y, -y - self.lam * (x * x - y * y)

    def tangent_force(self, x, y, dx, dy):
        """Return the change of the force along a vector.

        Parameters
        ----------
        x, y : float or array_like
            Coordinates.
        dx, dy : float or array_like
            Vector of changes of the coordinates.

        Returns
        -------
        tuple of float or ndarray
            Minus the Hessian of V times the vector.
        """
        return (
            -dx - 2 * self.lam * (y * dx + x * dy),
            -dy - 2 * self.lam * (x * dx - y * dy),
        )

    @property
    def energy(self) -> Arithmetic:
        """Function H(q..., p...): ``model.energy(*z)`` for phase points z (2n, ...), NaN outside the domain."""
        return energy_method(self)

    def kinetic_energy(self, px, py):
        """Return the kinetic energy.

        Parameters
        ----------
        px, py : float or array_like
            Momenta.

        Returns
        -------
        float or ndarray
            Energy T = (px^2 + py^2)/2.
        """
        return (px * px + py * py) / 2

    def potential_energy(self, x, y):
        """Return the potential energy.

        Parameters
        ----------
        x, y : float or array_like
            Coordinates.

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return (x * x + y * y) / 2 + self.lam * (x * x * y - y * y * y / 3)

    def margin(self, x, y):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        x, y : float or array_like
            Coordinates.

        Returns
        -------
        float or ndarray
            1: the potential is defined everywhere.
        """
        return 1.0 + 0.0 * (x + y)
