"""The body in space that rotates about one of its axes, reduced to its three stretches."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.numbers import real, shown
from .body3 import Body3
from .contracts import Arithmetic
from .energy_method import energy_method


@inserts_parameters
class ReducedBody3(NamedTuple):
    """Model a body in space that rotates about its third axis, reduced to its stretches.

    `reduced_body3` makes it and checks the arguments. The rows of a phase point are D1, D2, D3, p_1, p_2, p_3.

    Parameters
    ----------
    potential : potential
        Potential of 3x3 matrices.
    {inertia}
    spin, vorticity : float, action, default 0
        Spin about the third axis in space and vorticity about the third axis in the body, which are conserved.

    Notes
    -----
    * Hamiltonian: ``H = (p_1^2 + p_2^2 + p_3^2)/(2 mu) + (S - K)^2/(4 mu (D1 + D2)^2) + (S + K)^2/(4 mu (D1 - D2)^2) +
      V(D1, D2, D3)`` with the spin S and the vorticity K.
    * With S = K = 0 the body does not rotate, and D1 - D2 changes its sign freely.
    * Equilibria are the steady ellipsoids of Riemann of type S: `riemann_ellipsoid`.

    References
    ----------
    Martens & Slawianowski, EQ2.0a, for the first two stretches of n = 3; Dyson 1968, J. Math. Mech. 18, 91.

    Examples
    --------
    >>> cloud = fa.models.ReducedBody3(fa.models.GasCloud(gamma=2.0), spin=1.0, vorticity=1.0)
    >>> round(float(cloud.potential_energy(2.0, 1.0, 0.5)), 12)
    4.625
    """

    potential: Any
    mu: float = 1.0
    spin: float = 0.0
    vorticity: float = 0.0

    @property
    def degrees_of_freedom(self) -> int:
        """Return 3."""
        return 3

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the first 3 rows of z."""
        return "D1", "D2", "D3"

    @property
    def momenta(self) -> tuple[str, ...]:
        """Names of the last 3 rows of z."""
        return "p_1", "p_2", "p_3"

    def velocity(self, p_1, p_2, p_3):
        """Return the velocity dq/dt = p/mu.

        Parameters
        ----------
        p_1, p_2, p_3 : float or array_like
            Momenta of the stretches.

        Returns
        -------
        tuple of float or ndarray
            Rates of the stretches.
        """
        w = 1.0 / self.mu
        return w * p_1, w * p_2, w * p_3

    @property
    def energy(self) -> Arithmetic:
        """Function H(q..., p...): ``model.energy(*z)`` for phase points z (2n, ...), NaN outside the domain."""
        return energy_method(self)

    def kinetic_energy(self, p_1, p_2, p_3):
        """Return the kinetic energy of the stretches.

        Parameters
        ----------
        p_1, p_2, p_3 : float or array_like
            Momenta of the stretches.

        Returns
        -------
        float or ndarray
            Energy of the stretches. The energy of the rotations is part of the effective potential.
        """
        return (p_1 * p_1 + p_2 * p_2 + p_3 * p_3) / (2 * self.mu)

    def force(self, D1, D2, D3):
        """Return the force dp/dt, minus the gradient of the effective potential.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        tuple of float or ndarray
            Rates of the momenta.
        """
        V_1, V_2, V_3 = self.potential.stretch_slopes(D1, D2, D3)
        along = 0.0 * D1
        across = 0.0 * D1
        less = self.spin - self.vorticity
        more = self.spin + self.vorticity
        if less != 0.0:  # without angular momentum there is no barrier, and 0/0 must not appear
            w = 1 / (D1 + D2)
            along = less * less / (2 * self.mu) * w * w * w
        if more != 0.0:
            w = 1 / (D1 - D2)
            across = more * more / (2 * self.mu) * w * w * w
        return along + across - V_1, along - across - V_2, -V_3

    def tangent_force(self, D1, D2, D3, d1, d2, d3):
        """Return the change of the force along a vector.

        Parameters
        ----------
        {stretches}
        {stretch_changes}

        Returns
        -------
        tuple of float or ndarray
            Minus the Hessian of the effective potential times the vector.
        """
        c1, c2, c3 = self.potential.stretch_changes(D1, D2, D3, d1, d2, d3)
        along = 0.0 * d1
        across = 0.0 * d1
        less = self.spin - self.vorticity
        more = self.spin + self.vorticity
        if less != 0.0:
            w = 1 / (D1 + D2)
            along = -3 * less * less / (2 * self.mu) * w * w * w * w * (d1 + d2)
        if more != 0.0:
            w = 1 / (D1 - D2)
            across = -3 * more * more / (2 * self.mu) * w * w * w * w * (d1 - d2)
        return along + across - c1, along - across - c2, -c3

    def potential_energy(self, D1, D2, D3):
        """Return the effective potential.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            V with the energy of the rotations.
        """
        total = self.potential.stretch_value(D1, D2, D3)
        less = self.spin - self.vorticity
        more = self.spin + self.vorticity
        if less != 0.0:
            total = total + less * less / (4 * self.mu * (D1 + D2) * (D1 + D2))
        if more != 0.0:
            total = total + more * more / (4 * self.mu * (D1 - D2) * (D1 - D2))
        return total

    def margin(self, D1, D2, D3):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            Margin of the potential; with S + K not 0, D1 - D2 if it is less.
        """
        inside = self.potential.stretch_margin(D1, D2, D3)
        if self.spin + self.vorticity != 0.0:
            inside = np.minimum(inside, D1 - D2)
        return inside

    def to_matrix(self, z, phi=0.0, psi=0.0):
        """Return phase points of `Body3`.

        Parameters
        ----------
        z : array_like, shape (6, ...)
            Rows D1, D2, D3, p_1, p_2, p_3.
        phi, psi : float or array_like, radians, default 0
            Angles of the principal axes in space and in the body.

        Returns
        -------
        ndarray, shape (18, ...)
            Elements of phi row by row, then their momenta.

        Raises
        ------
        TypeError, ValueError
            If `z` has another shape or a number that is not finite, or D1 = D2 with spin + vorticity not 0.
        """
        # Plain NumPy: the key of compiled kernels follows what methods of a model call.
        z = np.asarray(z, float)
        if z.shape[:1] != (6,) or not np.isfinite(z).all():
            raise ValueError(f"z must be finite real numbers of shape (6, ...), got shape {z.shape}.")
        D1, D2, D3, p_1, p_2, p_3 = z
        if self.spin + self.vorticity != 0.0 and np.any(D1 == D2):
            place = tuple(np.argwhere(D1 == D2)[0])
            raise ValueError(f"z must have D1 > D2 if spin + vorticity is not 0, got D1 = D2 = {D1[place]:g}.")
        less = self.spin - self.vorticity
        more = self.spin + self.vorticity
        # In the principal axes spin is D1 p21 - D2 p12 and vorticity D1 p12 - D2 p21.
        turning = less / (D1 + D2) / 2 if less != 0.0 else 0.0 * D1
        shearing = more / (D1 - D2) / 2 if more != 0.0 else 0.0 * D1
        zero = 0.0 * D1
        c = np.cos(phi)
        s = np.sin(phi)
        C = np.cos(psi)
        S = np.sin(psi)
        rows = []
        for m11, m12, m21, m22, m33 in (
            (D1, zero, zero, D2, D3),
            (p_1, shearing - turning, shearing + turning, p_2, p_3),
        ):
            a1 = m11 * C - m12 * S
            a2 = m11 * S + m12 * C
            b1 = m21 * C - m22 * S
            b2 = m21 * S + m22 * C
            rows += [c * a1 - s * b1, c * a2 - s * b2, zero, s * a1 + c * b1, s * a2 + c * b2, zero, zero, zero, m33]
        return np.array(np.broadcast_arrays(*rows))


def reduced_body3(model: Body3, *, spin: float = 0.0, vorticity: float = 0.0) -> ReducedBody3:
    """Reduce a body in space that rotates about its third axis to its stretches.

    Parameters
    ----------
    model : Body3
        Body in space.
    spin, vorticity : float, action, default 0
        Spin and vorticity about the third axis. If both are 0, the body does not rotate.

    Returns
    -------
    `ReducedBody3`
        Model of three degrees of freedom. Its method to_matrix returns phase points of `Body3`.

    Raises
    ------
    TypeError
        If `model` is not a `Body3`, or if spin or vorticity is not a number.
    ValueError
        If spin or vorticity is not finite.

    Notes
    -----
    * Sections: texts such as ``"D1=1"`` or ``"p_3=0"``.
    * Spin and vorticity about other axes than a common principal axis do not reduce to three degrees of freedom. Use
      `Body3`.

    References
    ----------
    Dyson 1968, J. Math. Mech. 18, 91; Martens & Slawianowski, EQ2.0a, EQ2.1.

    Examples
    --------
    >>> cloud = fa.models.reduced_body3(fa.models.Body3(fa.models.GasCloud()), spin=0.5)
    >>> cloud.coordinates, cloud.spin
    (('D1', 'D2', 'D3'), 0.5)
    """
    if not isinstance(model, Body3):
        raise TypeError(f"model must be a Body3, got {shown(model, 40)} ({type(model).__name__}).")
    return ReducedBody3(model.potential, model.mu, real("spin", spin), real("vorticity", vorticity))
