"""The affinely-rigid body in space, GL(3,R): nine coordinates, the elements of the matrix phi."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.numbers import shown
from .constructors import checks_arguments
from .contracts import Arithmetic
from .energy_method import energy_method
from .matrix_potentials import MATRIX_METHODS
from .potentials3 import Sum3


def is_of_matrices(potential: Any) -> bool:
    """Tell whether a value is a potential of 3x3 matrices, of a sum whether both parts are."""
    if isinstance(potential, Sum3):
        return is_of_matrices(potential.first) and is_of_matrices(potential.second)
    return not isinstance(potential, type) and all(hasattr(potential, name) for name in MATRIX_METHODS)


def _is_spatial(arguments: Mapping[str, Any]) -> None:
    """Refuse a potential of other variables than 3x3 matrices."""
    if "potential" in arguments and not is_of_matrices(arguments["potential"]):
        raise TypeError(
            "potential must be a potential of 3x3 matrices such as fa.models.GasCloud(), got "
            f"{shown(arguments['potential'], 40)}."
        )


@checks_arguments(_is_spatial)
@inserts_parameters
class Body3(NamedTuple):
    """Model the affinely-rigid body in space with an isotropic potential.

    Parameters
    ----------
    potential : potential
        Potential of 3x3 matrices, such as `GasCloud`, `SelfGravity`, `NeoHookean3` or a result of `formula3`. A
        user-defined NamedTuple becomes one by the decorators of ``fastaff.models.matrix_potentials``.
    {inertia}

    Raises
    ------
    TypeError
        If `potential` is not a potential of 3x3 matrices.

    Notes
    -----
    * Hamiltonian: ``H = |p|^2/(2 mu) + V(phi)``.
    * Rows of a phase point: x1, x2, x3, y1, y2, y3, z1, z2, z3, the elements of phi row by row, then their momenta. A
      material point a is at phi a.
    * Conserved: energy, spin and vorticity, three numbers each (`constants_of_motion`).
    * Cost: the first `chaos_map` or `tangent_map` compiles for some seconds.
    * A body at rest in its principal axes and without rotation stays diagonal. A motion of the first two rows and
      columns keeps its third axis.

    References
    ----------
    Martens & Slawianowski, section 2 (the kinetic energy of GL(n,R)) and section 3 (the invariants), for n = 3.

    Examples
    --------
    >>> cloud = fa.models.Body3(fa.models.GasCloud())
    >>> cloud.potential_energy(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    np.float64(3.0)
    """

    potential: Any
    mu: float = 1.0

    @property
    def degrees_of_freedom(self) -> int:
        """Return 9."""
        return 9

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the first 9 rows of z."""
        return "x1", "x2", "x3", "y1", "y2", "y3", "z1", "z2", "z3"

    def velocity(self, px1, px2, px3, py1, py2, py3, pz1, pz2, pz3):
        """Return the velocity dq/dt = p/mu.

        Parameters
        ----------
        {matrix_momenta}

        Returns
        -------
        tuple of float or ndarray
            Nine rows: the rates of the elements of phi.
        """
        w = 1.0 / self.mu
        return w * px1, w * px2, w * px3, w * py1, w * py2, w * py3, w * pz1, w * pz2, w * pz3

    @property
    def energy(self) -> Arithmetic:
        """Function H(q..., p...): ``model.energy(*z)`` for phase points z (2n, ...), NaN outside the domain."""
        return energy_method(self)

    def kinetic_energy(self, px1, px2, px3, py1, py2, py3, pz1, pz2, pz3):
        """Return the kinetic energy.

        Parameters
        ----------
        {matrix_momenta}

        Returns
        -------
        float or ndarray
            Energy T = ``|p|^2``/(2 mu).
        """
        x = px1 * px1 + px2 * px2 + px3 * px3
        y = py1 * py1 + py2 * py2 + py3 * py3
        z = pz1 * pz1 + pz2 * pz2 + pz3 * pz3
        return (x + y + z) / (2 * self.mu)

    def force(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
        """Return the force dp/dt = -grad V.

        Parameters
        ----------
        {matrix_coordinates}

        Returns
        -------
        tuple of float or ndarray
            Nine rows: the rates of the momenta.
        """
        a1, a2, a3, b1, b2, b3, c1, c2, c3 = self.potential.matrix_slopes(x1, x2, x3, y1, y2, y3, z1, z2, z3)
        return -a1, -a2, -a3, -b1, -b2, -b3, -c1, -c2, -c3

    def tangent_force(self, x1, x2, x3, y1, y2, y3, z1, z2, z3, *change):
        """Return the change of the force along a vector.

        Parameters
        ----------
        {matrix_coordinates}
        {matrix_changes}

        Returns
        -------
        tuple of float or ndarray
            Nine rows: minus the Hessian of V times the vector.
        """
        a1, a2, a3, b1, b2, b3, c1, c2, c3 = self.potential.matrix_changes(x1, x2, x3, y1, y2, y3, z1, z2, z3, *change)
        return -a1, -a2, -a3, -b1, -b2, -b3, -c1, -c2, -c3

    def potential_energy(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
        """Return the potential energy.

        Parameters
        ----------
        {matrix_coordinates}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.potential.matrix_value(x1, x2, x3, y1, y2, y3, z1, z2, z3)

    def margin(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {matrix_coordinates}

        Returns
        -------
        float or ndarray
            Margin of the potential, det phi for most.
        """
        return self.potential.matrix_margin(x1, x2, x3, y1, y2, y3, z1, z2, z3)

    def constants(self, z):
        """Return the constants of motion.

        Parameters
        ----------
        z : array_like, shape (18, ...)
            Phase points.

        Returns
        -------
        dict of ndarray
            Values by name: energy; spin_x, spin_y, spin_z about axes in space; vorticity_1, vorticity_2, vorticity_3
            about axes in the body.
        """
        z = np.asarray(z, dtype=np.float64)
        phi = z[:9].reshape(3, 3, *z.shape[1:])
        p = z[9:].reshape(3, 3, *z.shape[1:])
        spin = np.cross(phi, p, axis=0).sum(axis=1)
        vorticity = np.cross(phi, p, axis=1).sum(axis=0)
        found = {"energy": self.kinetic_energy(*z[9:]) + self.potential_energy(*z[:9])}
        found |= {f"spin_{axis}": row for axis, row in zip("xyz", spin, strict=True)}
        return found | {f"vorticity_{axis}": row for axis, row in zip("123", vorticity, strict=True)}
