"""Time-transformed splittings: steps in a fictitious time s that runs slower near a wall, and still symplectic.

An orbit of energy E = T(p) + V(q) has E - T(p) = V(q); so for any increasing G the Hamiltonian G(V(q)) - G(E - T(p))
has the same orbits, in a time s with dt/ds = g = G'. It is separable: the drift moves q by g(E - T) v and t by g(E -
T), the kick moves p by g(V) f. Here time is a further coordinate, tau = t/time, and E its momentum: an ordinary model
with one more degree of freedom, for the same kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...core.numbers import shown
from ...engine.tuples import halves, scaled
from ...engine.values import is_value, parameters
from .catalogue import KAHAN_LI8, Splitting


class Exponential(NamedTuple):
    """Define the rate g = exp(-(V - origin)/kappa).

    Parameters
    ----------
    kappa : float, energy
        Width of the transition, positive.
    origin : float, energy, default 0
        Energy at which the rate changes.

    Notes
    -----
    At a logarithmic barrier V = -G ln d, kappa = G makes the force in s constant.

    References
    ----------
    Preto & Tremaine 1999, Astron. J. 118, 2532 (the family of transformations).

    Examples
    --------
    >>> fa.schemes.Exponential(kappa=2.0).at(0.0)
    np.float64(1.0)
    """

    kappa: float
    origin: float = 0.0

    def at(self, V):
        """Return the rate dt/ds.

        Parameters
        ----------
        V : float or array_like
            Potential energy.

        Returns
        -------
        float or ndarray
            Rate, positive.
        """
        return np.exp((self.origin - V) * (1.0 / self.kappa))


class Logistic(NamedTuple):
    """Define the rate g = 1/(1 + exp((V - origin)/kappa)).

    Parameters
    ----------
    kappa : float, energy
        Width of the transition, positive.
    origin : float, energy, default 0
        Energy at which the rate changes.

    Notes
    -----
    The rate is 1 where V is low and that of `Exponential` on the barrier. It does not change the fast, free part of an
    orbit.

    References
    ----------
    Preto & Tremaine 1999, Astron. J. 118, 2532 (the family of transformations).

    Examples
    --------
    >>> fa.TimeTransformed(rate=fa.schemes.Logistic(kappa=1.0)).rate
    Logistic(kappa=1.0, origin=0.0)
    """

    kappa: float
    origin: float = 0.0

    def at(self, V):
        """Return the rate dt/ds.

        Parameters
        ----------
        V : float or array_like
            Potential energy.

        Returns
        -------
        float or ndarray
            Rate, positive.
        """
        return 1.0 / (1.0 + np.exp((V - self.origin) * (1.0 / self.kappa)))


class Algebraic(NamedTuple):
    """Define the rate g = (u + sqrt(u^2 + 1))^-exponent, u = (V - origin)/(2 kappa).

    Parameters
    ----------
    kappa : float, energy
        Width of the transition, positive.
    origin : float, energy, default 0
        Energy at which the rate changes.
    exponent : float, default 1
        Exponent, positive.

    Notes
    -----
    On the barrier the rate is about (V/kappa)^-exponent, which suits barriers V = c/d^k. It is positive for every V.

    References
    ----------
    Preto & Tremaine 1999, Astron. J. 118, 2532 (the family of transformations).

    Examples
    --------
    >>> fa.schemes.Algebraic(kappa=1.0).at(0.0)
    np.float64(1.0)
    """

    kappa: float
    origin: float = 0.0
    exponent: float = 1.0

    def at(self, V):
        """Return the rate dt/ds.

        Parameters
        ----------
        V : float or array_like
            Potential energy.

        Returns
        -------
        float or ndarray
            Rate, positive.
        """
        u = (V - self.origin) * (0.5 / self.kappa)
        return np.exp(-self.exponent * np.log(u + np.sqrt(u * u + 1.0)))


class Rate(Protocol):
    """Rate dt/ds of the fictitious time: a NamedTuple of floats with this method."""

    @property
    def at(self) -> Callable[..., Any]:
        """The function dt/ds of V."""


@dataclass(frozen=True)
class TimeTransformed:
    """Run a splitting in a fictitious time s that slows down near a potential barrier.

    Parameters
    ----------
    splitting : Splitting, default KAHAN_LI8
        Splitting whose order holds for every T(p).
    rate : rate, optional
        Rate dt/ds as a function of V: `Exponential`, `Logistic`, `Algebraic`, or a NamedTuple of floats with a method
        ``at(V)``. The method is positive, decreasing and made of arithmetic. Default: a short trial chooses it.

    Raises
    ------
    TypeError
        If `splitting` is not a `Splitting`, or if `rate` is not a rate.
    ValueError
        If the order of the splitting needs T quadratic in p, or if a parameter of the rate is not finite or not
        positive.

    Notes
    -----
    * Method: explicit, reversible, symplectic in extended phase space.
    * The step of a run is a step in s.
    * Cost of a stage: one force, V, T and two rates.
    * Supported by `integrate` and `poincare_map`.

    References
    ----------
    Preto & Tremaine 1999, Astron. J. 118, 2532; Mikkola & Tanikawa 1999, Celest. Mech. Dyn. Astron. 74, 287.

    Examples
    --------
    >>> scheme = fa.TimeTransformed(rate=fa.schemes.Logistic(kappa=1.0))
    >>> scheme.order, scheme.splitting.name
    (8, 'KAHAN_LI8')
    """

    splitting: Splitting = KAHAN_LI8
    rate: Rate | None = None

    def __repr__(self) -> str:
        return f"TimeTransformed({self.splitting!r}{'' if self.rate is None else f', {self.rate!r}'})"

    def __post_init__(self) -> None:
        if not isinstance(self.splitting, Splitting):
            raise TypeError(
                f"splitting must be a Splitting such as KAHAN_LI8, got {shown(self.splitting)} "
                f"({type(self.splitting).__name__})"
            )
        if self.splitting.nystrom:
            raise ValueError(
                f"splitting {self.splitting.name} needs T quadratic in p, which G(E - T) is not: take KAHAN_LI8"
            )
        if self.rate is None:
            return
        if not (is_value(self.rate) and hasattr(self.rate, "at")):
            raise TypeError(
                f"rate must be a rate such as Logistic(kappa=1.0, origin=2.0), got {shown(self.rate)} "
                f"({type(self.rate).__name__})"
            )
        if not np.all(np.isfinite(parameters(self.rate))):
            raise ValueError(f"rate has a parameter that is not finite: {shown(self.rate)}")
        for name in {"kappa", "exponent"} & set(vars(type(self.rate))):
            if not getattr(self.rate, name) > 0:
                raise ValueError(f"rate.{name} must be positive, got {shown(getattr(self.rate, name))}")

    @property
    def name(self) -> str:
        """Name of the scheme."""
        return f"TimeTransformed({self.splitting.name})"

    symplectic = True
    """Whether it is symplectic and reversible with equal steps: in extended phase space."""

    @property
    def order(self) -> int:
        """Order of the splitting."""
        return self.splitting.order

    @property
    def stages(self) -> int:
        """Number of kicks in a step."""
        return self.splitting.stages

    @property
    def source(self) -> str:
        """The publications of the splitting and the transformation."""
        return (
            "Preto & Tremaine 1999, Astron. J. 118, 2532; Mikkola & Tanikawa 1999, Celest. Mech. Dyn. Astron. 74, 287; "
            + self.splitting.source
        )


class TransformedModel(NamedTuple):
    """The system of n + 1 degrees of freedom in s of `transformed_model`: positions q..., tau, momenta p..., e."""

    model: Any
    rate: Any
    time: float

    @property
    def degrees_of_freedom(self) -> int:
        """Return n + 1."""
        return self.model.degrees_of_freedom + 1

    def velocity(self, *p):
        """Return dq/ds and dtau/ds."""
        g = self.rate.at(p[-1] - self.model.kinetic_energy(*p[:-1]))
        return scaled(g, self.model.velocity(*p[:-1])) + (g * (1.0 / self.time),)  # noqa: RUF005 - as Numba reads it

    def force(self, *q):
        """Return dp/ds and de/ds."""
        g = self.rate.at(self.model.potential_energy(*q[:-1]))
        return scaled(g, self.model.force(*q[:-1])) + (0.0 * q[-1],)  # noqa: RUF005

    def margin(self, *q):
        """Return the model's margin."""
        return self.model.margin(*q[:-1])

    @property
    def poles_of(self) -> str:
        """Name of the field that gives its poles."""
        return "model"

    def poles(self, *q):
        """Return the model's numbers, if it has some, whose whole parts change at its poles."""
        return self.model.poles(*q[:-1])

    def kinetic_energy(self, *p):
        """Return the model's own T."""
        return self.model.kinetic_energy(*p[:-1])

    def potential_energy(self, *q):
        """Return the model's own V."""
        return self.model.potential_energy(*q[:-1])


class TransformedSection(NamedTuple):
    """A section of a model as a section of its `TransformedModel`."""

    section: Any
    direction: float

    def value(self, *z):
        """Return the section's value without time and energy."""
        q, p = halves(z)
        return self.section.value(*(q[:-1] + p[:-1]))


def transformed_model(model: Any, rate: Any, time: float) -> Any:
    """Return the system of n + 1 degrees of freedom in s: rows q..., tau = t/time, then p..., e, the energy.

    Its `kinetic_energy` and `potential_energy` are those of `model`, so that energies and their errors are the orbit's
    own.
    """
    return TransformedModel(model, rate, float(time))


def transformed_section(section: Any) -> Any:
    """Return a section as a section of the transformed system."""
    return TransformedSection(section, float(section.direction))


def lifted(z: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """Return phase points z (2n, orbits) at time 0 as points (2n + 2, orbits) of the transformed system."""
    n = z.shape[0] // 2
    return np.concatenate([z[:n], np.zeros((1, z.shape[1])), z[n:], np.reshape(energy, (1, -1))])


def lowered(z: np.ndarray) -> np.ndarray:
    """Return points (2n + 2, ...) of the transformed system without time and energy."""
    n = z.shape[0] // 2 - 1
    return np.concatenate([z[:n], z[n + 1 : 2 * n + 1]])
