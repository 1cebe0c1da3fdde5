"""Required methods of a model, a potential, a function of one variable, a section and a set of angles.

Any value with these methods is one: a NamedTuple of floats (or of such NamedTuples) whose methods are arithmetic of
scalars, which kernels compile, and of arrays. `fastaff.runs.requirements` refuses a value and names the missing
methods.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, Self, runtime_checkable

from ...engine.kinds import Kind as Kind

Arithmetic = Callable[..., Any]
"""A function of numbers or arrays."""


@runtime_checkable
class SeparableModel(Protocol):
    """A system H = T(p) + V(q) of n degrees of freedom. Its phase points have 2n rows: coordinates, then momenta.

    velocity(p...) = dT/dp and force(q...) = -dV/dq, n numbers each; kinetic_energy(p...), potential_energy(q...);
    margin(q...): positive in the domain of the potential. Optional: poles(q...): numbers whose whole parts change at
    poles of V (from -1 to 0 if a number changes its sign), as a step may miss a pole: an orbit that has passed one
    where V is infinite is OUT_OF_DOMAIN, or an adaptive step is repeated; poles_of: name of the field that gives the
    poles, where the model has them only if that field does; coordinates (n names); angles (see `Angles`); for tangent
    vectors tangent_force(q..., dq...), the change of the force along dq, and, unless T is quadratic,
    tangent_velocity(p..., dp...), that of the velocity along dp; isotropic: whether p_eta and p_gamma of a body in the
    two planes a and b are conserved; kind, a `Kind`. A ROTATING model has angular_velocity(), the rate Omega of
    rotation of the frame of its first two coordinates x, y: H = T(p) + V(q) - Omega (x p_y - y p_x), with T = (p_x^2 +
    p_y^2)/2m + ..., so that p are the momenta in a frame at rest.

    A DRIVEN model of n coordinates has n + 1 degrees of freedom: its last coordinate is the time t, with velocity 1,
    and p_t balances the energy from the drive, H + p_t = T(p) + V(q, t) + p_t. It has its `period` in t, and phase(t),
    the time reduced by whole periods; its kinetic_energy is T, without p_t.
    """

    @property
    def degrees_of_freedom(self) -> int:
        """Number n of coordinates."""

    @property
    def velocity(self) -> Arithmetic:
        """The function dT/dp of n momenta."""

    @property
    def force(self) -> Arithmetic:
        """The function -dV/dq of n coordinates."""

    @property
    def kinetic_energy(self) -> Arithmetic:
        """The function T of n momenta."""

    @property
    def potential_energy(self) -> Arithmetic:
        """The function V of n coordinates."""

    @property
    def margin(self) -> Arithmetic:
        """A function of n coordinates that is positive in the domain of the potential."""


@runtime_checkable
class Map(Protocol):
    """A map z -> M(z) of phase points of 2n rows, coordinates, then momenta. Its time is the number of iterates.

    iterate(q..., p...): the 2n numbers of the image, angles as they wind on; tangent_iterate(q..., p..., dq..., dp...):
    the derivative applied to a vector; periods(): for each row its period, 0 where it has none; margin(q...): positive
    in the domain of the map. Optional: coordinates and momenta, n names each. A map of one variable has one coordinate
    and momenta = (): its methods have one row.
    """

    @property
    def degrees_of_freedom(self) -> int:
        """Number n of coordinates."""

    @property
    def iterate(self) -> Arithmetic:
        """The image of a phase point, 2n numbers of 2n."""

    @property
    def tangent_iterate(self) -> Arithmetic:
        """The image of a vector at a phase point, 2n numbers of 4n."""

    @property
    def periods(self) -> Arithmetic:
        """A function without arguments: the periods of the rows, 0 where there is none."""

    @property
    def margin(self) -> Arithmetic:
        """A function of n coordinates that is positive in the domain of the map."""


@runtime_checkable
class Autonomous(Protocol):
    """An autonomous system dz/dt = f(z) of d variables, with `kind` FLOW.

    coordinates: their d names; rates(z...) = dz/dt, d numbers; margin(z...): positive in the domain; degrees of
    freedom: d/2, rounded up. For tangent vectors tangent_rates(z..., dz...), the change of the rates along dz.
    """

    @property
    def degrees_of_freedom(self) -> int:
        """Half the number of rows of a state in memory: with an odd number of variables one row is idle."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the variables."""

    @property
    def rates(self) -> Arithmetic:
        """The function dz/dt of d numbers."""

    @property
    def margin(self) -> Arithmetic:
        """A function of d numbers that is positive in the domain of the system."""


@runtime_checkable
class Nonseparable(Protocol):
    """A system H(q, p) of n degrees of freedom, with `kind` NONSEPARABLE.

    energy(q..., p...) = H; rates(q..., p...) = dH/dp, -dH/dq, 2n numbers; tangent_rates(q..., p..., dq..., dp...),
    the change of the rates along a vector; margin(q..., p...): positive in the domain. Optional: coordinates and
    momenta, n names each; angles; periods(): for each row its period, 0 where it has none; poles(q..., p...): see
    `SeparableModel`. With a drive the last coordinate is the time, as in `SeparableModel`, and H includes + p_t.
    """

    @property
    def degrees_of_freedom(self) -> int:
        """Number n of coordinates."""

    @property
    def energy(self) -> Arithmetic:
        """The function H of 2n numbers."""

    @property
    def rates(self) -> Arithmetic:
        """The function dz/dt of 2n numbers."""

    @property
    def tangent_rates(self) -> Arithmetic:
        """The change of dz/dt along a vector, 2n numbers of 4n."""

    @property
    def margin(self) -> Arithmetic:
        """A function of 2n numbers that is positive in the domain of the system."""


class Written(Protocol):
    """A system of a text: its parameters are fields, `system.k`, and `system._replace(k=2.0)` compiles nothing."""

    def _replace(self, **parameters: float) -> Self:
        """Return the same with other parameters."""

    def __getattr__(self, name: str) -> Any:
        """Parameters, and attributes of some kinds of systems, are known only when the text is read."""


class FormulaBody(SeparableModel, Written, Protocol):
    """A planar affinely-rigid body of a text."""


class FormulaSeparable(SeparableModel, Written, Protocol):
    """A `SeparableModel` of a text."""


class FormulaNonseparable(Nonseparable, Written, Protocol):
    """A `Nonseparable` system of a text."""


FormulaHamiltonian = FormulaSeparable | FormulaNonseparable
"""A Hamiltonian system of a text."""


class FormulaMap(Map, Written, Protocol):
    """A `Map` of a text."""


class FormulaODE(Autonomous, Written, Protocol):
    """An `Autonomous` system of a text."""


Dynamics = SeparableModel | Map | Autonomous | Nonseparable
"""Any system: the first argument of analyses."""


@runtime_checkable
class Potential(Protocol):
    """A doubly isotropic potential V(A, B) of A = alpha^2, B = beta^2. Optional: curvatures(A, B) = V_AA, V_AB,
    V_BB.
    """

    @property
    def value(self) -> Arithmetic:
        """V(A, B)."""

    @property
    def slopes(self) -> Arithmetic:
        """V_A, V_B."""

    @property
    def margin(self) -> Arithmetic:
        """Positive in the domain of the potential."""


@runtime_checkable
class OneVariable(Protocol):
    """A function of one variable, value(x) and slope(x) = d value/dx. Optional: curvature(x)."""

    @property
    def value(self) -> Arithmetic:
        """The function."""

    @property
    def slope(self) -> Arithmetic:
        """Its derivative."""


@runtime_checkable
class Section(Protocol):
    """A surface of section value(z...) = 0, crossed upwards (direction +1), downwards (-1) or either way (0)."""

    @property
    def direction(self) -> int:
        """+1, -1 or 0."""

    @property
    def value(self) -> Arithmetic:
        """The section function of 2n numbers."""


@runtime_checkable
class Angles(Protocol):
    """Loops whose turning rates are the frequencies; see `fastaff.models.angles`."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the n angles."""

    @property
    def planes(self) -> tuple[bool, ...]:
        """Whether each is the angle of a plane."""

    @property
    def signals(self) -> Arithmetic:
        """Re Q, Im Q, Re P, Im P of each angle at a phase point."""
