"""Energy surfaces H(q, p) = E and their sections: the value that grids, random points and edges share, the momenta over
a place, and the energies that a system can have.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import kind_of, real, shown
from ..runs.requirements import check_given, checked_model, checked_section
from ..systems.models.mechanics import System, system_of
from ..systems.models.reduction import reduced_body
from ..systems.models.sections import AngleEquals, Hyperplane
from .accessible_box import falls_below, potential_of, spread
from .allowed_region import Function, crossings, extrema, line, line_where_it_happens

TOLERANCE = 1e-9
"""Largest relative error of the energy of a point that was found. At a wall where the potential jumps there is no such
point.
"""

ROUNDING = 1e-12
"""Relative rounding error of the coordinates themselves."""

MOST_ROOTS = 32
"""Number of roots along a row beyond which there is no end of them, as for an H that is periodic in it."""

RADII = np.geomspace(1e-8, 1e8, 129)
"""Distances at which the search for stationary points starts: all sizes."""

ANGLES = 24
"""Directions in which the search for stationary points starts."""

STEPS = 60
"""Steps of the search for stationary points."""

LONGEST = 0.5
"""Longest step of the search, in distances from the origin."""


class NotReached(ValueError):
    """Raised if an energy surface has no point on the section or in the ranges, because the energy is too low there."""


class EnergyShell(NamedTuple):
    """An energy surface, or a section of it; of a body at the angular momenta of its planes. energy: NaN for a system
    that conserves none.
    """

    system: System
    energy: float
    section: Any = None
    p_eta: float = 0.0
    p_gamma: float = 0.0

    @classmethod
    def of_section(cls, system: System, energy: Any, section: Any, p_eta: Any, p_gamma: Any) -> EnergyShell:
        """Return a section for its two coordinates, if all of it suits the system."""
        checked_model(system.model, needs="an energy surface")
        checked_section(section, system)
        energy = given_energy(energy)
        p_eta = real("p_eta", p_eta)
        p_gamma = real("p_gamma", p_gamma)
        if system.n == 4 and not hasattr(system.model, "potential"):
            raise TypeError(
                f"model must be a Body with a doubly isotropic potential to have a grid, got {shown(system.model)}"
            )
        if not system.isotropic and (p_eta or p_gamma):
            raise ValueError(
                f"p_eta and p_gamma must be 0 for {kind_of(system.model)}, got {p_eta} and {p_gamma}. Only a Body has "
                "them."
            )
        return cls(system, energy, section, p_eta, p_gamma)

    @classmethod
    def of_rows(cls, system: System, energy: Any, section: Any, p_eta: Any, p_gamma: Any) -> EnergyShell:
        """Return a surface, or a section of it, for rows of phase points by name, if all of it suits the system."""
        checked_model(system.model, needs="a start by rows")
        if system.conserves:
            energy = given_energy(energy)
        else:
            unknown = isinstance(energy, float) and np.isnan(energy)
            check_given(system, "a start by energy", energy=None if unknown else energy)
            energy = float("nan")
        if real("p_eta", p_eta) or real("p_gamma", p_gamma):
            raise ValueError(
                f"p_eta and p_gamma must be 0 with axes by name, got {p_eta} and {p_gamma}. Use fixed={{name: value}}."
            )
        return cls(system, energy, section)

    @property
    def model(self) -> Any:
        """The model."""
        return self.system.model

    def section_row(self) -> tuple[str, float, int]:
        """Return the row that the section fixes, its value and the sign of its rate."""
        section = self.section
        checked_section(section, self.system)
        names = self.system.row_names
        normal = np.asarray(getattr(section, "normal", ()), dtype=np.float64)
        if type(section) not in (Hyperplane, AngleEquals) or np.count_nonzero(normal) != 1:
            raise self._no_coordinate()
        k = int(np.flatnonzero(normal)[0])
        return names[k], section.offset / normal[k], int(section.direction * np.sign(normal[k]))

    def section_coordinate(self) -> tuple[int, float, int]:
        """Return the number of the coordinate that the section fixes, its value and the sign of its rate."""
        name, value, sign = self.section_row()
        if name not in self.system.names:
            raise self._no_coordinate()
        return self.system.names.index(name), value, sign

    def _no_coordinate(self) -> TypeError:
        return TypeError(
            "section must be a Hyperplane normal to one coordinate to launch orbits on it, such as "
            f"{self.system.names[0]}=0, got {shown(self.section)}"
        )

    # --- phase points -----------------------------------------------------------------------------------------------

    def left(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the energy that is left at phase points (2n, ...), and the size of its terms."""
        system, energy = self[:2]
        if system.nonseparable:
            H = system.energies(z)
            return np.where(system.inside(z), energy - H, -np.inf), abs(energy) + np.abs(H)
        T = system.kinetic_energies(z)
        V = system.potential_energies(z)
        return np.where(system.inside(z), energy - T - V, -np.inf), abs(energy) + np.abs(T) + np.abs(V)

    def contains(self, z: np.ndarray) -> np.ndarray:
        """Return a mask of the phase points z (2n, points) that have this energy and lie in the domain of the
        potential.

        An energy of 0, where V has its zero, is no measure of its rounding; its change along z is.
        """
        system, energy = self[:2]
        T = system.kinetic_energies(z)
        V = system.potential_energies(z)
        n = len(z) // 2
        with np.errstate(all="ignore"):
            along = np.nan_to_num(ROUNDING * np.abs(z * np.roll(system.slopes(z), n, axis=0)).sum(axis=0), posinf=0.0)
            exact = np.abs(T + V - energy) <= TOLERANCE * (np.abs(T) + np.abs(V) + abs(energy)) + along
        return exact & np.isfinite(z).all(axis=0) & system.inside(z)

    def roots_along(self, z: np.ndarray, row: int, sign: int) -> np.ndarray:
        """Return the values (sheets, points) of a row at which points z (2n, points) have the energy and H rises with
        sign times the row: the last one in that direction first, NaN where there are fewer.

        For a momentum in which H is of second degree they are in closed form; else between extrema at all sizes.
        """
        system = self.system
        n = len(z) // 2
        if row >= n and system.of_degree_two:
            return self._of_parabola(z, row, sign)[None]

        def room(x: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            at = spread(z[:, column], x)
            at[row] = sign * x
            return self.left(at)

        column = np.arange(z.shape[1])
        nodes = line() if system.separable else line_where_it_happens(room, column.size)
        found = sign * crossings(room, extrema(room, column.size, nodes), column, np.zeros(column.size), False)[0]
        if len(found) > MOST_ROOTS:
            name = system.row_names[row]
            raise ValueError(f"energy {self.energy:g} is met without end along {name}: solve for another row")
        return found

    def _of_parabola(self, z: np.ndarray, row: int, sign: int) -> np.ndarray:
        """Return the root of a momentum p in H = H0 + v p + w p^2/2 at which its velocity, +-sqrt(v^2 + 2 w (E - H0)),
        has the sign; refined by a step of Newton's method where this lessens the error.
        """
        system, energy = self[:2]
        at = z.copy()
        k = row - len(z) // 2
        at[row] = 0.0
        v = system.velocities(at)[k]
        rest = energy - system.energies(at)
        w = system.tangent_slopes(at, np.eye(len(z))[row, :, None])[k]
        square = v * v + 2 * w * rest
        speed = sign * np.sqrt(np.where(square >= 0, square, np.nan))
        p = np.where(v * sign > 0, 2 * rest / (v + speed), (speed - v) / w)
        at[row] = p
        miss = system.energies(at) - energy
        at[row] = better = p - miss / system.velocities(at)[k]
        return np.where(np.abs(system.energies(at) - energy) < np.abs(miss), better, p)

    # --- bodies at the angular momenta of their planes --------------------------------------------------------------

    def room(self, alpha: Any, beta: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return 2 mu (energy - H) at rest in alpha and beta, the squared momentum that is left, and the sum of the
        sizes of its terms.
        """
        potential = self.model.potential
        mass = 2 * self.model.mu
        A = alpha * alpha
        B = beta * beta
        barrier = (self.p_eta / alpha) ** 2 if self.p_eta else 0.0
        barrier = barrier + ((self.p_gamma / beta) ** 2 if self.p_gamma else 0.0)
        V = potential.value(A, B)
        left = np.where(potential.margin(A, B) > 0, mass * (self.energy - V) - barrier, -np.inf)
        return left, mass * (abs(self.energy) + np.abs(V)) + barrier

    def radial(self, u: np.ndarray, *, alpha: bool) -> Function:
        """Return `room` as a function of alpha (else beta) in columns over values u of the other radius."""
        if alpha:
            return lambda x, j: self.room(x, u[j])
        return lambda x, j: self.room(u[j], x)

    def point(self, alpha: Any, p_alpha: Any, beta: Any, p_beta: Any) -> np.ndarray:
        """Return phase points with eta = gamma = 0; a radius 0 is allowed where its angular momentum is 0."""
        across_a = self.p_eta / alpha if self.p_eta else 0.0 * alpha
        across_b = self.p_gamma / beta if self.p_gamma else 0.0 * beta
        return np.array([alpha, 0 * alpha, beta, 0 * beta, p_alpha, across_a, p_beta, across_b])

    # --- the energies of the system ---------------------------------------------------------------------------------

    def too_low(self) -> str | None:
        """Return the sentence for an energy below the minimum; None where it is not known to be."""
        return too_low(self.system, self.energy, self.p_eta, self.p_gamma)

    def may_escape(self) -> str | None:
        """Return the sentence for an energy above the lowest saddle; None where there is none below."""
        return may_escape(self.system, self.energy, self.p_eta, self.p_gamma)


def given_energy(energy: Any) -> float:
    """Return the energy of a surface."""
    if energy is None:
        raise TypeError("energy must be given for a model that conserves it, got None")
    return real("energy", energy)


# --- ellipsoids of momenta: small systems of equations at many points, rows first -----------------------------------


class Momenta(NamedTuple):
    """The momenta over coordinates: the coordinates' order, that of a section first, and L of the inverse inertia, None
    where that depends on the coordinates.
    """

    system: System
    order: tuple[int, ...]
    lower: np.ndarray | None

    @classmethod
    def of(cls, system: System, first: int = 0) -> Momenta:
        """Return the momenta of a system whose kinetic energy is quadratic."""
        n = system.n
        order = (first, *(k for k in range(n) if k != first))
        if system.nonseparable:
            return cls(system, order, None)
        inverse = np.array([system.model.velocity(*row) for row in np.eye(n)], dtype=np.float64)[np.ix_(order, order)]
        return cls(system, order, np.linalg.cholesky((inverse + inverse.T) / 2))

    def floor(self, q: np.ndarray) -> np.ndarray:
        """Return the least energy over coordinates q (n, ...), infinite outside the domain of the potential."""
        system = self.system
        z = np.concatenate([q, np.zeros_like(q)])
        if self.lower is None:
            lower, drift, energy = self._here(q)
            z[len(q) + np.array(self.order)] = backward(lower, -drift)
            # H there, not H(q, 0) less the kinetic part: far out that would be a difference of equal numbers.
            here = np.where(np.isnan(energy), energy, system.energies(z))
            energy = np.where(np.isnan(lower).any(axis=(0, 1)), -np.inf, here)
        else:
            drift = self._scaled(system.velocities(z))
            energy = system.energies(z) - (drift**2).sum(axis=0) / 2
        return np.where(system.inside(z) & ~np.isnan(energy), energy, np.inf)

    def lifted(self, q: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return phase points (2n, points) over q (n, points) at y (n, points)."""
        z = np.concatenate([q, np.zeros_like(q)])
        if self.lower is None:
            lower, drift, _ = self._here(q)
            z[len(q) + np.array(self.order)] = backward(lower, y - drift)
            return z
        y = y - self._scaled(self.system.velocities(z))
        z[len(q) + np.array(self.order)] = np.linalg.solve(self.lower.T, y)
        return z

    def reach(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return, for two coordinates (2, ...), the reach of the second momentum to each side at the kinetic energy
        1/2, and its value in the middle.
        """
        lower, drift, _ = self._here(q)
        return 1 / lower[1, 1], -backward(lower, drift)[1]

    def density(self, q: np.ndarray, room: np.ndarray, power: float, sign: int) -> np.ndarray:
        """Return the density of the measure over q (n, ...) with kinetic energy `room`, 0 where there is none."""
        with np.errstate(all="ignore"):
            size = np.where(room > 0, np.abs(room) ** power, np.nan)
            if self.lower is None:
                lower = self._here(q)[0]
                size = size / np.prod([lower[k, k] for k in range(bool(sign), len(lower))], axis=0)
        return np.where(np.isnan(size), 0.0, size)

    def _here(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return L, NaN where the inverse inertia is finite and not positive definite, L^-1 dq/dt and H at p = 0."""
        W, v, energy = self.system.momentum_form(q)
        order = np.array(self.order)
        with np.errstate(all="ignore"):
            known = np.isfinite(W).all(axis=(0, 1))
            lower = cholesky(W[order][:, order])
            return np.where(known, lower, np.inf), forward(lower, v[order]), np.where(known, energy, np.nan)

    def _scaled(self, velocity: np.ndarray) -> np.ndarray:
        assert self.lower is not None
        flat = velocity[list(self.order)].reshape(len(velocity), -1)
        return np.linalg.solve(self.lower, flat).reshape(velocity.shape)


def rest(system: System, q: np.ndarray) -> np.ndarray:
    """Return the momenta (n, ...) at places q (n, ...) at which all velocities are 0."""
    if not system.nonseparable:
        return system.at_rest(q)
    W, v, _ = system.momentum_form(q)
    L = cholesky(W)
    return -backward(L, forward(L, v))


def cholesky(W: np.ndarray) -> np.ndarray:
    """Return L (n, n, ...) of W = L L^T (n, n, ...), lower triangular; NaN where W is not positive definite."""
    L = np.zeros_like(W)
    for j in range(len(W)):
        square = W[j, j] - (L[j, :j] ** 2).sum(axis=0)
        L[j, j] = np.sqrt(np.where(square > 0, square, np.nan))
        for i in range(j + 1, len(W)):
            L[i, j] = (W[i, j] - (L[i, :j] * L[j, :j]).sum(axis=0)) / L[j, j]
    return L


def forward(L: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return y (n, ...) of L y = b."""
    y = np.empty(np.broadcast_shapes(L.shape[1:], b.shape))
    for i in range(len(y)):
        y[i] = (b[i] - (L[i, :i] * y[:i]).sum(axis=0)) / L[i, i]
    return y


def backward(L: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return x (n, ...) of L^T x = y."""
    x = np.empty(np.broadcast_shapes(L.shape[1:], y.shape))
    for i in range(len(x) - 1, -1, -1):
        x[i] = (y[i] - (L[i + 1 :, i] * x[i + 1 :]).sum(axis=0)) / L[i, i]
    return x


# --- the energies of a system ---------------------------------------------------------------------------------------


class Limits(NamedTuple):
    """The least energy of a minimum and of a saddle of the effective potential; NaN where none was found."""

    minimum: float
    saddle: float


def energy_limits(system: System, p_eta: float = 0.0, p_gamma: float = 0.0) -> Limits:
    """Return the least energies of a minimum and of a saddle: of a body at the angular momenta of its planes, or of a
    system of two coordinates.

    Newton's method from some 3000 points of all sizes finds where the force is 0, the second derivatives tell minima
    from saddles. The values are for messages, not for computations: a narrow well far from the others may be missed.
    NaN where there is none or the second derivatives are not known.
    Source: Henon & Heiles 1964, Astron. J. 69, 73: a minimum at 0 and three saddles at 1/6.
    """
    plane = _in_plane(system, p_eta, p_gamma)
    if plane.n != 2 or not hasattr(plane.model, "tangent_force"):
        return Limits(np.nan, np.nan)
    try:
        with np.errstate(all="ignore"):
            energy, negative = _stationary(plane)
    except AttributeError:  # a potential without second derivatives
        return Limits(np.nan, np.nan)
    minimum, saddle = (float(energy[negative == k].min()) if (negative == k).any() else np.nan for k in (0, 1))
    return Limits(minimum, saddle)


def _in_plane(system: System, p_eta: float, p_gamma: float) -> System:
    """Return the system of two coordinates at the angular momenta of a body's planes; any other system as it is."""
    if not system.isotropic:
        return system
    return system_of(reduced_body(system.model, p_eta=p_eta, p_gamma=p_gamma))


def _stationary(system: System) -> tuple[np.ndarray, np.ndarray]:
    """Return energies of stationary points of a potential of two coordinates, and the number of directions in which
    each is a maximum.
    """
    turn = (np.arange(ANGLES) + 0.5) * (2 * np.pi / ANGLES)
    q = np.array([np.outer(RADII, np.cos(turn)).ravel(), np.outer(RADII, np.sin(turn)).ravel()])
    q = q[:, system.model.margin(*q) > 0]
    step = np.zeros_like(q)
    for _ in range(STEPS):
        force, second = _derivatives(system, q)
        a = second[0, 0]
        b = second[0, 1]
        d = second[1, 1]
        step = np.array([d * force[0] - b * force[1], a * force[1] - b * force[0]]) / (a * d - b * b)
        long = np.hypot(*step) / (LONGEST * np.hypot(*q))
        q = q + step / np.maximum(long, 1.0)
    found = (np.hypot(*step) <= 1e-9 * np.hypot(*q)) | (np.hypot(*q) < 1e-12)
    q = q[:, found & np.isfinite(q).all(axis=0) & (system.model.margin(*q) > 0)]
    _, second = _derivatives(system, q)
    energy = system.least_energies(q)
    bends = np.linalg.eigvalsh(np.moveaxis(np.where(np.isfinite(second), second, 0.0), 2, 0))
    return energy[np.isfinite(energy)], (bends < 0).sum(axis=1)[np.isfinite(energy)]


def _derivatives(system: System, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return force (2, points) and second derivatives (2, 2, points) of the potential at q (2, points)."""
    unit = np.ones(q.shape[1:])
    columns = [system.model.tangent_force(*q, unit, 0.0 * unit), system.model.tangent_force(*q, 0.0 * unit, unit)]
    spread = np.array([[np.broadcast_to(-row, unit.shape) for row in column] for column in columns])
    force = np.array([np.broadcast_to(row, unit.shape) for row in system.model.force(*q)])
    if system.frame:  # the centrifugal force
        pull = system.turning_mass * system.frame_rate**2
        return force + pull * q, spread - pull * np.eye(2)[:, :, None]
    return force, spread


def fitting_energy(system: System, p_eta: float, p_gamma: float) -> float:
    """Return an energy under the lowest saddle, else that of rest at a distance of about 1; NaN where none is known."""
    least, saddle = energy_limits(system, p_eta, p_gamma)
    if saddle > least:
        return least + 0.75 * (saddle - least)
    plane = _in_plane(system, p_eta, p_gamma)
    if plane.n != 2:
        return np.nan
    with np.errstate(all="ignore"):
        return float(plane.energies(np.array([[1.0], [0.5], [0.0], [0.0]]))[0])


def too_low(system: System, energy: float, p_eta: float, p_gamma: float) -> str | None:
    """Return the sentence for an energy below the minimum of the system; None where it is not known to be."""
    least = energy_limits(system, p_eta, p_gamma).minimum
    if not energy < least or system.frame:  # a turning frame has lower energies far away
        return None
    where = f" with p_eta = {p_eta:g} and p_gamma = {p_gamma:g}" if system.isotropic else ""
    what = "body" if system.isotropic else "system"
    least = least if abs(least) > 1e-12 * abs(energy) else 0.0  # hidden by rounding
    plane = _in_plane(system, p_eta, p_gamma)
    kind = "local minimum" if falls_below(potential_of(plane.model), plane.n, least) else "minimum"
    return f"energy must be at least the {kind} {least:.6g} of this {what}{where}, got {energy:g}"


def may_escape(system: System, energy: float, p_eta: float = 0.0, p_gamma: float = 0.0) -> str | None:
    """Return the sentence for an energy above the lowest saddle of the potential; None where there is none below."""
    saddle = energy_limits(system, p_eta, p_gamma).saddle
    if not energy > saddle + 1e-12 * abs(saddle):  # to rounding
        return None
    return f"energy {energy:g} exceeds the escape energy {saddle:.6g}"
