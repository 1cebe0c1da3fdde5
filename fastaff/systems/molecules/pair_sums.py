"""Energies of all pairs of atoms of a homogeneously deformed molecule, as potentials that kernels compile.

The distance l of two atoms, whose material difference is the vector d with the height h along the axis, is l^2 = |phi
d|^2 + h^2. In the planes a and b it is |d|^2 (|a|^2 + |b|^2)/2 + |d|^2 |a| |b| cos(2 theta') + h^2, where theta' is the
angle of d from the principal axis of stretch. Sums of pairs with one potential form a link; a chain of links is the
molecule.
"""

from __future__ import annotations

from math import cos, pi
from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from ..models.contracts import Arithmetic
from ..models.energy_method import energy_method
from .pairs import PairPotential

DIRECTIONS = 16
"""Material directions of the average over orientations: the average is exact up to terms (beta/alpha)^16."""

COSINES = tuple(cos(pi * (2 * j + 1) / DIRECTIONS) for j in range(DIRECTIONS // 4))
"""Positive cosines of twice the angles of the directions; the others are their negatives, or equal to them."""

NEAR = 2.0**-20
"""Least square of the relative spread of squared distances at which quotients of differences are taken directly.

Below it the quotients of V_A, V_B and V_AB are extrapolated in that square from two values, with relative errors of
about 1e-11 and 1e-9. V_BB keeps its value there, with a relative error of about 1e-4. In forces beta^2 < 1e-6 alpha^2
multiplies it.
"""


class NoPairs(NamedTuple):
    """The end of a chain of pairs: its energy is 0."""

    unused: float = 0.0

    def value(self, A, B):
        """Return 0."""
        return 0.0 * (A + B)

    def slopes(self, A, B):
        """Return zeros."""
        zero = 0.0 * (A + B)
        return zero, zero

    def curvatures(self, A, B):
        """Return zeros."""
        zero = 0.0 * (A + B)
        return zero, zero, zero

    def energy(self, a1, a2, b1, b2):
        """Return 0."""
        return 0.0 * (a1 + a2 + b1 + b2)

    def gradient(self, a1, a2, b1, b2):
        """Return zeros."""
        zero = 0.0 * (a1 + a2 + b1 + b2)
        return zero, zero, zero, zero

    def change_of_gradient(self, a1, a2, b1, b2, da1, da2, db1, db2):
        """Return zeros."""
        zero = 0.0 * (a1 + a2 + b1 + b2)
        return zero, zero, zero, zero


class AveragedPairs(NamedTuple):
    """Pairs of atoms in all material directions alike: a doubly isotropic potential V(A, B).

    pair: potential of the distance.  lengths: material distances in the plane, heights: along the axis, counts: numbers
    of pairs.  rest: other pairs.
    """

    pair: PairPotential
    lengths: tuple[float, ...]
    heights: tuple[float, ...]
    counts: tuple[float, ...]
    rest: Any = NoPairs()

    def value(self, A, B):
        """Return the energy."""
        total = self.rest.value(A, B)
        half = (A + B) / 2
        middle = np.sqrt(A * B)
        for length, height, count in zip(self.lengths, self.heights, self.counts):
            s = length * length * half + height * height
            for c in COSINES:
                t = length * length * c * middle
                both = self.pair.value(np.sqrt(s + t)) + self.pair.value(np.sqrt(s - t))
                total = total + count / (2 * len(COSINES)) * both
        return total

    def slopes(self, A, B):
        """Return V_A and V_B."""
        V_A, V_B = self.rest.slopes(A, B)
        half = (A + B) / 2
        for length, height, count in zip(self.lengths, self.heights, self.counts):
            square = length * length
            s = square * half + height * height
            weight = count / (2 * len(COSINES))
            for c in COSINES:
                q = square * square * c * c * A * B
                far = np.maximum(q, NEAR * s * s)
                t = np.sqrt(q)
                along = weight * square / 2 * (self.rise(s + t) + self.rise(s - t))
                across = weight * square * square * c * c * self.spread(s, q, far)
                V_A = V_A + along + across * B
                V_B = V_B + along + across * A
        return V_A, V_B

    def curvatures(self, A, B):
        """Return V_AA, V_AB and V_BB."""
        V_AA, V_AB, V_BB = self.rest.curvatures(A, B)
        half = (A + B) / 2
        for length, height, count in zip(self.lengths, self.heights, self.counts):
            square = length * length
            s = square * half + height * height
            weight = count / (2 * len(COSINES))
            for c in COSINES:
                k = square * square * c * c
                q = k * A * B
                far = np.maximum(q, NEAR * s * s)
                t = np.sqrt(q)
                along = weight * square * square / 4 * (self.bend(s + t) + self.bend(s - t))
                mixed = weight * k * square / 2 * self.bend_spread(s, q, far)
                across = weight * k * self.spread(s, q, far)
                fourth = weight * k * k * self.spread_of_spread(s, far)
                V_AA = V_AA + along + 2 * mixed * B + fourth * B * B
                V_AB = V_AB + along + mixed * (A + B) + fourth * A * B + across
                V_BB = V_BB + along + 2 * mixed * A + fourth * A * A
        return V_AA, V_AB, V_BB

    def rise(self, square):
        """Return dV/d(l^2) of one pair, l^2 = square."""
        distance = np.sqrt(square)
        return self.pair.slope(distance) / (2 * distance)

    def bend(self, square):
        """Return the second derivative of V with respect to l^2."""
        distance = np.sqrt(square)
        return (self.pair.curvature(distance) - self.pair.slope(distance) / distance) / (4 * square)

    def spread(self, s, q, far):
        """Return the derivative of V(s + t) + V(s - t) with respect to q = t^2."""
        t = np.sqrt(far)
        near = t / 2
        outer = (self.rise(s + t) - self.rise(s - t)) / (2 * t)
        inner = (self.rise(s + near) - self.rise(s - near)) / (2 * near)
        return outer + (q - far) * (outer - inner) / (0.75 * far)

    def bend_spread(self, s, q, far):
        """Return the derivative of `spread` with respect to s."""
        t = np.sqrt(far)
        near = t / 2
        outer = (self.bend(s + t) - self.bend(s - t)) / (2 * t)
        inner = (self.bend(s + near) - self.bend(s - near)) / (2 * near)
        return outer + (q - far) * (outer - inner) / (0.75 * far)

    def spread_of_spread(self, s, far):
        """Return the derivative of `spread` with respect to q, at q = far."""
        t = np.sqrt(far)
        quotient = (self.rise(s + t) - self.rise(s - t)) / (2 * t)
        return ((self.bend(s + t) + self.bend(s - t)) / 2 - quotient) / (2 * far)

    def margin(self, A, B):
        """Return 2 det phi."""
        return A - B


class DirectedPairs(NamedTuple):
    """Pairs of atoms in their material directions: a potential of the planes a and b.

    pair: potential of the distance.  x, y: material differences in the plane, heights: along the axis, counts: numbers
    of equal pairs.  rest: other pairs.
    """

    pair: PairPotential
    x: tuple[float, ...]
    y: tuple[float, ...]
    heights: tuple[float, ...]
    counts: tuple[float, ...]
    rest: Any = NoPairs()

    def energy(self, a1, a2, b1, b2):
        """Return the energy."""
        total = self.rest.energy(a1, a2, b1, b2)
        for x, y, height, count in zip(self.x, self.y, self.heights, self.counts):
            v1 = ((a1 + b1) * x + (b2 - a2) * y) / np.sqrt(2.0)
            v2 = ((a2 + b2) * x + (a1 - b1) * y) / np.sqrt(2.0)
            total = total + count * self.pair.value(np.sqrt(v1 * v1 + v2 * v2 + height * height))
        return total

    def gradient(self, a1, a2, b1, b2):
        """Return the derivatives with respect to a1, a2, b1 and b2."""
        g1, g2, g3, g4 = self.rest.gradient(a1, a2, b1, b2)
        for x, y, height, count in zip(self.x, self.y, self.heights, self.counts):
            v1 = ((a1 + b1) * x + (b2 - a2) * y) / np.sqrt(2.0)
            v2 = ((a2 + b2) * x + (a1 - b1) * y) / np.sqrt(2.0)
            distance = np.sqrt(v1 * v1 + v2 * v2 + height * height)
            w = count * self.pair.slope(distance) / (distance * np.sqrt(2.0))
            g1 = g1 + w * (v1 * x + v2 * y)
            g2 = g2 + w * (v2 * x - v1 * y)
            g3 = g3 + w * (v1 * x - v2 * y)
            g4 = g4 + w * (v2 * x + v1 * y)
        return g1, g2, g3, g4

    def change_of_gradient(self, a1, a2, b1, b2, da1, da2, db1, db2):
        """Return the Hessian applied to a vector."""
        h1, h2, h3, h4 = self.rest.change_of_gradient(a1, a2, b1, b2, da1, da2, db1, db2)
        for x, y, height, count in zip(self.x, self.y, self.heights, self.counts):
            v1 = ((a1 + b1) * x + (b2 - a2) * y) / np.sqrt(2.0)
            v2 = ((a2 + b2) * x + (a1 - b1) * y) / np.sqrt(2.0)
            dv1 = ((da1 + db1) * x + (db2 - da2) * y) / np.sqrt(2.0)
            dv2 = ((da2 + db2) * x + (da1 - db1) * y) / np.sqrt(2.0)
            square = v1 * v1 + v2 * v2 + height * height
            distance = np.sqrt(square)
            w = count * self.pair.slope(distance) / (distance * np.sqrt(2.0))
            stiffness = count * self.pair.curvature(distance) / (square * np.sqrt(2.0)) - w / square
            more = stiffness * (v1 * dv1 + v2 * dv2)
            f1 = w * dv1 + more * v1
            f2 = w * dv2 + more * v2
            h1 = h1 + f1 * x + f2 * y
            h2 = h2 + f2 * x - f1 * y
            h3 = h3 + f1 * x - f2 * y
            h4 = h4 + f2 * x + f1 * y
        return h1, h2, h3, h4


@inserts_parameters
class MolecularBody(NamedTuple):
    """Model a body with the energy of all pairs of a molecule.

    `Molecule.exact_body` makes it.

    Parameters
    ----------
    pairs : object
        Sum of all pairs in their directions.
    mu_1, mu_2 : float, default 1
        Principal moments of inertia.

    Notes
    -----
    * Hamiltonian: ``H = (p_x^2 + p_z^2)/(2 mu_1) + (p_y^2 + p_u^2)/(2 mu_2) + V(phi)`` with phi = [[x, y], [z, u]] in
      the frame of the principal axes.
    * Rows of a phase point: those of `Body`.
    * The spin p_phi is conserved. The vorticity p_psi is not, because V depends on psi.

    References
    ----------
    Martens & Slawianowski, section 2 (kinetic energy with unequal moments).

    Examples
    --------
    >>> ring = fa.molecules.ring(6, pairs=fa.molecules.HarmonicBond(k=2.0))
    >>> float(round(ring.exact_body.potential_energy(1.6, 0.0, 0.0, 0.0), 6))
    0.10355
    """

    pairs: Any
    mu_1: float = 1.0
    mu_2: float = 1.0

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
        """Whether p_eta and p_gamma are conserved: no."""
        return False

    def velocity(self, pa1, pa2, pb1, pb2):
        """Return the velocity dq/dt.

        Parameters
        ----------
        {plane_momenta}

        Returns
        -------
        tuple of float or ndarray
            Four rows: the rates of a1, a2, b1, b2.
        """
        v, w = 0.5 / self.mu_1, 0.5 / self.mu_2
        k, d = v + w, v - w
        return k * pa1 + d * pb1, k * pa2 + d * pb2, d * pa1 + k * pb1, d * pa2 + k * pb2

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
            Energy T.
        """
        first = (pa1 + pb1) * (pa1 + pb1) + (pa2 + pb2) * (pa2 + pb2)
        second = (pa1 - pb1) * (pa1 - pb1) + (pb2 - pa2) * (pb2 - pa2)
        return first / (4 * self.mu_1) + second / (4 * self.mu_2)

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
        g1, g2, g3, g4 = self.pairs.gradient(a1, a2, b1, b2)
        return -g1, -g2, -g3, -g4

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
        h1, h2, h3, h4 = self.pairs.change_of_gradient(a1, a2, b1, b2, da1, da2, db1, db2)
        return -h1, -h2, -h3, -h4

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
        return self.pairs.energy(a1, a2, b1, b2)

    def margin(self, a1, a2, b1, b2):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        float or ndarray
            2 det phi: the body ends where it is flattened to a line.
        """
        return a1 * a1 + a2 * a2 - b1 * b1 - b2 * b2

    def constants(self, z):
        """Return the constants of motion.

        Parameters
        ----------
        z : array_like, shape (8, ...)
            Phase points.

        Returns
        -------
        dict of ndarray
            Values by name: energy; p_phi, the spin.
        """
        a1, a2, b1, b2, pa1, pa2, pb1, pb2 = np.asarray(z, dtype=np.float64)
        energy = self.kinetic_energy(pa1, pa2, pb1, pb2) + self.potential_energy(a1, a2, b1, b2)
        return {"energy": energy, "p_phi": a1 * pa2 - a2 * pa1 + (b1 * pb2 - b2 * pb1)}
