"""Pair potentials of atoms: functions of their distance, with two derivatives."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ...core.docstrings import inserts_parameters
from ..models.contracts import Arithmetic, OneVariable


class PairPotential(OneVariable, Protocol):
    """A function of the distance of two atoms with two derivatives."""

    @property
    def curvature(self) -> Arithmetic:
        """Its second derivative."""


@inserts_parameters
class HarmonicBond(NamedTuple):
    """Define the harmonic bond, V = k (l - length)^2/2.

    Parameters
    ----------
    k : float, energy/length^2, default 1
        Force constant.
    {bond_length}

    References
    ----------
    Wilson, Decius & Cross 1955, Molecular Vibrations, section 8-1 (central force fields).

    Examples
    --------
    >>> fa.molecules.HarmonicBond(k=4.0, length=1.0).value(1.5)
    0.5
    """

    k: float = 1.0
    length: float = 1.0

    def value(self, distance):
        """Return the energy of the pair.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.k / 2 * (distance - self.length) * (distance - self.length)

    def slope(self, distance):
        """Return the first derivative of V.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            Derivative dV/d(distance).
        """
        return self.k * (distance - self.length)

    def curvature(self, distance):
        """Return the second derivative of V.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to the distance.
        """
        return self.k + 0.0 * distance


@inserts_parameters
class MorseBond(NamedTuple):
    """Define Morse's bond, V = D (1 - exp(-a (l - length)))^2.

    Parameters
    ----------
    D : float, energy, default 1
        Energy of dissociation.
    a : float, 1/length, default 1
        Inverse range. The force constant is 2 D a^2.
    {bond_length}

    References
    ----------
    Morse 1929, Phys. Rev. 34, 57.

    Examples
    --------
    >>> bond = fa.molecules.MorseBond(D=2.0, a=1.5, length=1.0)
    >>> float(bond.value(1.0)), float(bond.curvature(1.0))
    (0.0, 9.0)
    """

    D: float = 1.0
    a: float = 1.0
    length: float = 1.0

    def value(self, distance):
        """Return the energy of the pair.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        missing = 1 - np.exp(-self.a * (distance - self.length))
        return self.D * missing * missing

    def slope(self, distance):
        """Return the first derivative of V.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            Derivative dV/d(distance).
        """
        decay = np.exp(-self.a * (distance - self.length))
        return 2 * self.D * self.a * decay * (1 - decay)

    def curvature(self, distance):
        """Return the second derivative of V.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to the distance.
        """
        decay = np.exp(-self.a * (distance - self.length))
        return 2 * self.D * self.a * self.a * decay * (2 * decay - 1)


@inserts_parameters
class LennardJones(NamedTuple):
    """Define the potential of Lennard-Jones, V = epsilon ((length/l)^12 - 2 (length/l)^6).

    Parameters
    ----------
    epsilon : float, energy, default 1
        Depth.
    length : float, length, default 1
        Distance of the minimum, 2^(1/6) sigma.

    References
    ----------
    Lennard-Jones 1931, Proc. Phys. Soc. 43, 461.

    Examples
    --------
    >>> fa.molecules.LennardJones(epsilon=3.0, length=2.0).value(2.0)
    -3.0
    """

    epsilon: float = 1.0
    length: float = 1.0

    def value(self, distance):
        """Return the energy of the pair.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        square = self.length * self.length / (distance * distance)
        sixth = square * square * square
        return self.epsilon * sixth * (sixth - 2)

    def slope(self, distance):
        """Return the first derivative of V.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            Derivative dV/d(distance).
        """
        square = self.length * self.length / (distance * distance)
        sixth = square * square * square
        return 12 * self.epsilon * sixth * (1 - sixth) / distance

    def curvature(self, distance):
        """Return the second derivative of V.

        Parameters
        ----------
        {pair_distance}

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to the distance.
        """
        square = self.length * self.length / (distance * distance)
        sixth = square * square * square
        return 12 * self.epsilon * sixth * (13 * sixth - 7) / (distance * distance)
