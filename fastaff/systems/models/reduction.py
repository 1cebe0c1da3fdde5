"""The doubly isotropic body reduced by its rotations: two degrees of freedom, alpha and beta."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.numbers import real, shown
from .angles import Coordinates2
from .body import Body
from .contracts import Arithmetic
from .energy_method import energy_method
from .mechanics import system_of


@inserts_parameters
class ReducedBody(NamedTuple):
    """Model a doubly isotropic body reduced by its rotations.

    `reduced_body` makes it and checks the arguments. The rows of a phase point are alpha, beta, p_alpha, p_beta.

    Parameters
    ----------
    potential : potential
        Doubly isotropic potential.
    {inertia}
    p_eta, p_gamma : float, action, default 0
        Angular momenta of the planes a and b, which are conserved.

    Notes
    -----
    * Hamiltonian: ``H = (p_alpha^2 + p_beta^2)/(2 mu) + p_eta^2/(2 mu alpha^2) + p_gamma^2/(2 mu beta^2) + V(alpha^2,
      beta^2)``.
    * Signs: if p_gamma = 0, b moves on a straight line of its plane, so beta passes through 0 and has either sign. The
      same holds for alpha if p_eta = 0.
    * Periodic orbits: a periodic orbit of the reduced body is a relative periodic orbit of the body. After a period the
      body has rotated by two angles. The orbit of the body is periodic only if both are rational fractions of a turn.

    References
    ----------
    Arnold 1989, Mathematical Methods of Classical Mechanics, app. 5 (reduction); H is EQ2.1 of Martens & Slawianowski
    in the chart EQ2.0b.

    Examples
    --------
    >>> fa.models.ReducedBody(fa.Harmonic(), p_eta=0.3, p_gamma=0.2).potential_energy(1.0, 0.5)
    0.75
    """

    potential: Any
    mu: float = 1.0
    p_eta: float = 0.0
    p_gamma: float = 0.0

    @property
    def degrees_of_freedom(self) -> int:
        """Return 2."""
        return 2

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the first 2 rows of z."""
        return "alpha", "beta"

    @property
    def angles(self) -> Coordinates2:
        """Angle variables: loops in the planes of alpha and of beta."""
        return Coordinates2()

    def velocity(self, p_alpha, p_beta):
        """Return the velocity dq/dt = p/mu.

        Parameters
        ----------
        p_alpha, p_beta : float or array_like
            Momenta.

        Returns
        -------
        tuple of float or ndarray
            Rates of alpha and beta.
        """
        w = 1.0 / self.mu
        return w * p_alpha, w * p_beta

    @property
    def energy(self) -> Arithmetic:
        """Function H(q..., p...): ``model.energy(*z)`` for phase points z (2n, ...), NaN outside the domain."""
        return energy_method(self)

    def kinetic_energy(self, p_alpha, p_beta):
        """Return the kinetic energy of alpha and beta.

        Parameters
        ----------
        p_alpha, p_beta : float or array_like
            Momenta.

        Returns
        -------
        float or ndarray
            Energy of both radii. The energy of the rotations is part of the effective potential.
        """
        return (p_alpha * p_alpha + p_beta * p_beta) / (2 * self.mu)

    def force(self, alpha, beta):
        """Return the force dp/dt, minus the gradient of the effective potential.

        Parameters
        ----------
        alpha, beta : float or array_like
            Coordinates.

        Returns
        -------
        tuple of float or ndarray
            Rates of p_alpha and p_beta.
        """
        V_A, V_B = self.potential.slopes(alpha * alpha, beta * beta)
        f = -2 * V_A * alpha
        g = -2 * V_B * beta
        if self.p_eta != 0.0:  # without angular momentum there is no barrier, and 0/0 must not appear at the origin
            f = f + self.p_eta * self.p_eta / (self.mu * alpha * alpha * alpha)
        if self.p_gamma != 0.0:
            g = g + self.p_gamma * self.p_gamma / (self.mu * beta * beta * beta)
        return f, g

    def tangent_force(self, alpha, beta, d_alpha, d_beta):
        """Return the change of the force along a vector.

        Parameters
        ----------
        alpha, beta : float or array_like
            Coordinates.
        d_alpha, d_beta : float or array_like
            Vector of changes of the coordinates.

        Returns
        -------
        tuple of float or ndarray
            Minus the Hessian of the effective potential times the vector.
        """
        A = alpha * alpha
        B = beta * beta
        dA = 2 * alpha * d_alpha
        dB = 2 * beta * d_beta
        V_A, V_B = self.potential.slopes(A, B)
        V_AA, V_AB, V_BB = self.potential.curvatures(A, B)
        f = -2 * ((V_AA * dA + V_AB * dB) * alpha + V_A * d_alpha)
        g = -2 * ((V_AB * dA + V_BB * dB) * beta + V_B * d_beta)
        if self.p_eta != 0.0:
            f = f - 3 * self.p_eta * self.p_eta / (self.mu * A * A) * d_alpha
        if self.p_gamma != 0.0:
            g = g - 3 * self.p_gamma * self.p_gamma / (self.mu * B * B) * d_beta
        return f, g

    def potential_energy(self, alpha, beta):
        """Return the effective potential.

        Parameters
        ----------
        alpha, beta : float or array_like
            Coordinates.

        Returns
        -------
        float or ndarray
            V with the energy of the rotations.
        """
        A = alpha * alpha
        B = beta * beta
        total = self.potential.value(A, B)
        if self.p_eta != 0.0:
            total = total + self.p_eta * self.p_eta / (2 * self.mu * A)
        if self.p_gamma != 0.0:
            total = total + self.p_gamma * self.p_gamma / (2 * self.mu * B)
        return total

    def margin(self, alpha, beta):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        alpha, beta : float or array_like
            Coordinates.

        Returns
        -------
        float or ndarray
            Margin of the potential.
        """
        return self.potential.margin(alpha * alpha, beta * beta)

    def from_planes(self, z):
        """Reduce phase points of the body.

        The angles are dropped. The angular momenta of `z` are not checked; they should equal p_eta and p_gamma.

        Parameters
        ----------
        {body_states}

        Returns
        -------
        ndarray, shape (4, ...)
            Rows alpha, beta, p_alpha, p_beta, with alpha, beta >= 0.
        """
        a1, a2, b1, b2, pa1, pa2, pb1, pb2 = np.asarray(z, dtype=np.float64)
        alpha, beta = np.hypot(a1, a2), np.hypot(b1, b2)
        # Any motion from the origin is outwards.
        p_alpha = np.where(alpha > 0, (a1 * pa1 + a2 * pa2) / np.where(alpha > 0, alpha, 1.0), np.hypot(pa1, pa2))
        p_beta = np.where(beta > 0, (b1 * pb1 + b2 * pb2) / np.where(beta > 0, beta, 1.0), np.hypot(pb1, pb2))
        return np.array([alpha, beta, p_alpha, p_beta])

    def to_planes(self, z, eta=0.0, gamma=0.0):
        """Return phase points of the body.

        Parameters
        ----------
        z : array_like, shape (4, ...)
            Rows alpha, beta, p_alpha, p_beta.
        eta, gamma : float or array_like, radians, default 0
            Angles of the planes a and b.

        Returns
        -------
        ndarray, shape (8, ...)
            Rows a1, a2, b1, b2, then their momenta.
        """
        alpha, beta, p_alpha, p_beta = np.asarray(z, dtype=np.float64)
        across_a = self.p_eta / alpha if self.p_eta != 0.0 else 0.0 * alpha
        across_b = self.p_gamma / beta if self.p_gamma != 0.0 else 0.0 * beta
        c = np.cos(eta)
        s = np.sin(eta)
        C = np.cos(gamma)
        S = np.sin(gamma)
        a = (alpha * c, alpha * s)
        b = (beta * C, beta * S)
        p_a = (p_alpha * c - across_a * s, p_alpha * s + across_a * c)
        p_b = (p_beta * C - across_b * S, p_beta * S + across_b * C)
        return np.array(np.broadcast_arrays(*a, *b, *p_a, *p_b))


def reduced_body(model: Body, *, p_eta: float, p_gamma: float) -> ReducedBody:
    """Reduce a doubly isotropic body by its rotations to alpha and beta.

    Parameters
    ----------
    model : Body
        Body with a doubly isotropic potential.
    p_eta, p_gamma : float, action
        Angular momenta of the planes a and b, which are conserved.

    Returns
    -------
    `ReducedBody`
        Model of two degrees of freedom. Its methods from_planes and to_planes convert phase points of the body.

    Raises
    ------
    TypeError
        If `model` is not a doubly isotropic body, or if an angular momentum is not a number.
    ValueError
        If an angular momentum is not finite.

    Notes
    -----
    * Sections: "p_alpha=0" is `AlphaTurning` of the body. If p_gamma is not 0, "p_beta=0" is `BetaTurning`.
    * Cost: the reduced body has half the rows and is twice as fast.
    * Periodic orbits: their only neutral directions are the flow and the energy.

    References
    ----------
    Arnold 1989, Mathematical Methods of Classical Mechanics, app. 5; EQ2.1, EQ2.0b of Martens & Slawianowski.

    Examples
    --------
    >>> model = fa.reduced_body(fa.Body(fa.Hyperelastic()), p_eta=0.2, p_gamma=0.1)
    >>> model.coordinates
    ('alpha', 'beta')
    """
    if not system_of(model).isotropic:
        raise TypeError(
            f"model must be a Body, whose potential depends on alpha and beta alone, got {shown(model)} "
            f"({type(model).__name__})"
        )
    return ReducedBody(model.potential, model.mu, real("p_eta", p_eta), real("p_gamma", p_gamma))
