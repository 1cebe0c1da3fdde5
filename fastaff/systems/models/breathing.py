"""The planar affinely-rigid body whose kinetic energy has a breathing term: another inertia of rho = |phi|."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...core.docstrings import inserts_parameters
from .angles import AreaTrace
from .contracts import Kind


@inserts_parameters
class BreathingBody(NamedTuple):
    """Model a body with a breathing term c in its kinetic energy.

    Parameters
    ----------
    potential : potential
        Doubly isotropic potential of ``fastaff.models``, such as `Hyperelastic`.
    c : float
        Breathing term, above -1. At c = 0 the motion is that of `Body`.
    {inertia}

    Notes
    -----
    * Kinetic energy: ``T = mu ((1 + c) rho'^2 + rho^2 w^2)/2`` with rho^2 = alpha^2 + beta^2 and w the velocity on the
      sphere rho = 1.
    * Hamiltonian: ``H = (|p|^2 - c/(1 + c) (q.p)^2/|q|^2)/(2 mu) + V``, not of the form T(p) + V(q).
    * Conserved: p_eta, p_gamma. If V separates in (r, vartheta), the body has actions (`action_angles`) and levels
      (`spectrum`).
    * Rows of a phase point: a1, a2, b1, b2, then their momenta, as for `Body`.

    References
    ----------
    Martens & Slawianowski, EQ6.4, EQ6.13-EQ6.15 (the metric; motion and levels are derived).

    Examples
    --------
    >>> body = fa.models.BreathingBody(fa.Harmonic(), c=3.0)
    >>> fa.action_angles(body, [1.0, 0.0, 0.5, 0.0, 0.2, 0.5, 0.0, 0.3]).omega[0].round(9)
    array([1.])
    """

    potential: Any
    c: float
    mu: float = 1.0

    @property
    def breathing(self) -> float:
        """The breathing term c."""
        return self.c

    @property
    def degrees_of_freedom(self) -> int:
        """Return 4."""
        return 4

    @property
    def angles(self) -> Any:
        """Angle variables natural to the potential: its own `angles`, else loops in area and trace."""
        return getattr(self.potential, "angles", AreaTrace())

    def energy(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return the energy H.

        Parameters
        ----------
        {plane_coordinates}
        {plane_momenta}

        Returns
        -------
        float or ndarray
            Energy H.
        """
        A = a1 * a1 + a2 * a2
        B = b1 * b1 + b2 * b2
        qp = a1 * pa1 + a2 * pa2 + b1 * pb1 + b2 * pb2
        square = pa1 * pa1 + pa2 * pa2 + pb1 * pb1 + pb2 * pb2
        return (square - self.c / (1 + self.c) * qp * qp / (A + B)) / (2 * self.mu) + self.potential.value(A, B)

    def rates(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return the rates of the rows.

        Parameters
        ----------
        {plane_coordinates}
        {plane_momenta}

        Returns
        -------
        tuple of float or ndarray
            Eight rows: dH/dp, then -dH/dq.
        """
        A = a1 * a1 + a2 * a2
        B = b1 * b1 + b2 * b2
        w = 1.0 / self.mu
        s = (a1 * pa1 + a2 * pa2 + b1 * pb1 + b2 * pb2) / (A + B)
        k = self.c / (1 + self.c) * s
        V_A, V_B = self.potential.slopes(A, B)
        return (
            w * (pa1 - k * a1),
            w * (pa2 - k * a2),
            w * (pb1 - k * b1),
            w * (pb2 - k * b2),
            w * k * (pa1 - s * a1) - 2 * V_A * a1,
            w * k * (pa2 - s * a2) - 2 * V_A * a2,
            w * k * (pb1 - s * b1) - 2 * V_B * b1,
            w * k * (pb2 - s * b2) - 2 * V_B * b2,
        )

    def tangent_rates(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2, *changes):
        """Return the change of the rates along a vector.

        Parameters
        ----------
        {plane_coordinates}
        {plane_momenta}
        *changes : float or array_like
            Vector of changes of the eight rows.

        Returns
        -------
        tuple of float or ndarray
            Eight rows: the changes of dH/dp, then of -dH/dq.
        """
        da1, da2, db1, db2, dpa1, dpa2, dpb1, dpb2 = changes
        A = a1 * a1 + a2 * a2
        B = b1 * b1 + b2 * b2
        dA = 2 * (a1 * da1 + a2 * da2)
        dB = 2 * (b1 * db1 + b2 * db2)
        V_A, V_B = self.potential.slopes(A, B)
        V_AA, V_AB, V_BB = self.potential.curvatures(A, B)
        dV_A = V_AA * dA + V_AB * dB
        dV_B = V_AB * dA + V_BB * dB
        w = 1.0 / self.mu
        r = A + B
        s = (a1 * pa1 + a2 * pa2 + b1 * pb1 + b2 * pb2) / r
        moved = da1 * pa1 + da2 * pa2 + db1 * pb1 + db2 * pb2
        pushed = a1 * dpa1 + a2 * dpa2 + b1 * dpb1 + b2 * dpb2
        ds = (moved + pushed - s * (dA + dB)) / r
        k = self.c / (1 + self.c) * s
        dk = self.c / (1 + self.c) * ds
        return (
            w * (dpa1 - dk * a1 - k * da1),
            w * (dpa2 - dk * a2 - k * da2),
            w * (dpb1 - dk * b1 - k * db1),
            w * (dpb2 - dk * b2 - k * db2),
            w * (dk * (pa1 - s * a1) + k * (dpa1 - ds * a1 - s * da1)) - 2 * (dV_A * a1 + V_A * da1),
            w * (dk * (pa2 - s * a2) + k * (dpa2 - ds * a2 - s * da2)) - 2 * (dV_A * a2 + V_A * da2),
            w * (dk * (pb1 - s * b1) + k * (dpb1 - ds * b1 - s * db1)) - 2 * (dV_B * b1 + V_B * db1),
            w * (dk * (pb2 - s * b2) + k * (dpb2 - ds * b2 - s * db2)) - 2 * (dV_B * b2 + V_B * db2),
        )

    def margin(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {plane_coordinates}
        {plane_momenta}

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

    def poles(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return numbers whose integer parts change at poles of the potential.

        Parameters
        ----------
        {plane_coordinates}
        {plane_momenta}

        Returns
        -------
        tuple of float or ndarray
            Numbers of the potential. Only a potential that has `poles` has them.
        """
        return self.potential.poles(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)


_named: Any = BreathingBody
_named.kind = Kind.NONSEPARABLE
_named.coordinates = ("a1", "a2", "b1", "b2")
_named.momenta = ("pa1", "pa2", "pb1", "pb2")
