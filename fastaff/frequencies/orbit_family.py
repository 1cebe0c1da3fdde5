"""Families of orbits in a galaxy: boxes, loops and their sense, resonant, irregular and undecided orbits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Any

import numpy as np

from ..core.classification import Classification
from ..core.interruption import imported
from ..core.numbers import shown, whole
from ..core.status import Status, describe
from ..results.calls import Starts
from ..results.progress import says_progress
from ..results.result import Result, along
from ..runs.integrate import integrate
from ..runs.requirements import checked_system, current_system, phase_points
from ..systems.models.contracts import Dynamics
from .frequencies import FrequencyMap
from .own_lines import about_an_axis, by_own_lines, in_turns, own_lines
from .resonances import MAX_ORDER, TOLERANCE, equation, line_resonances

PERIODS = 100.0
"""Periods over which the turns of an orbit about the centre are counted; at most the time of the map."""

DENSE = 24
"""Samples in a period."""

BUDGET = 1 << 24
"""Numbers of samples in memory at once."""

TURNING = 0.9
"""Least turns in a period of an orbit that circulates: loops of logarithmic potentials make 0.99 or more."""

SWINGING = 0.1
"""Most turns in a period of an orbit that does not circulate."""

ONE_WAY = 0.5
"""Least share of the area swept about the centre, less that swept the other way, of an orbit that circulates."""

ROUNDING = 1e-9
"""The same area relative to squared radii, below which it is rounding."""

ACCIDENTAL = 0.05
"""Expected number of resonances by accident from which an orbit is undecided."""

SHARP = 0.01
"""Error of lines, in cycles over the time, below which an orbit that is else undecided is trapped in a resonance."""

ACCURACY = 1e-6
"""Relative error of the orbits whose turns are counted."""


START_VALUES = ("energy", "angular_momentum", "radius")
"""Values of initial conditions."""


class OrbitFamily(IntEnum):
    """Family of an orbit.

    Attributes
    ----------
    BOX : 0
        The lines of the coordinates are not commensurable, and the orbit does not circulate.
    LOOP : 1
        Two coordinates have one frequency and the orbit circulates about the centre: a loop, or a tube about an axis.
    RESONANT : 2
        The lines of the coordinates are commensurable, and the orbit does not circulate.
    AXIAL : 3
        A coordinate is at rest.
    IRREGULAR : 4
        Chaos or a transient.
    UNDECIDED : 5
        The run is too short for a family.
    """

    BOX = 0
    LOOP = 1
    RESONANT = 2
    AXIAL = 3
    IRREGULAR = 4
    UNDECIDED = 5


@dataclass(frozen=True)
class OrbitFamilies(Result):
    r"""Families of orbits in a galaxy.

    Attributes
    ----------
    names : tuple of str, length n
        Names of the coordinates.
    family : ndarray of int, shape (orbits,)
        `OrbitFamily` of each orbit.
    sense : ndarray of int, shape (orbits,)
        Sense of a loop in the frame of the coordinates: 1 counterclockwise, from the first coordinate of its plane to
        the second; -1 clockwise; 0 for other orbits.
    resonance : ndarray of int, shape (n, orbits)
        Integers k of the shortest :math:`k \cdot \nu = 0` of the lines; 0 if there is none.
    nu : ndarray, shape (n, orbits)
        Line of each coordinate, in cycles per unit time; NaN if there is none.
    turns : ndarray, shape (orbits,)
        Turns about the centre per period, for orbits with two equal lines; NaN for others.
    energy : ndarray, shape (orbits,)
        Energy of the initial condition, Jacobi's in a rotating frame; NaN if the model is not known.
    angular_momentum : ndarray, shape (orbits,)
        x p_y - y p_x of the initial condition, for the first two coordinates.
    radius : ndarray, shape (orbits,)
        Distance of the initial condition from the centre.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit of the frequency map.
    """

    names: tuple[str, ...]
    family: Annotated[np.ndarray, along("orbit")]
    sense: Annotated[np.ndarray, along("orbit")]
    resonance: Annotated[np.ndarray, along("angle", "orbit", labels="names")]
    nu: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names", plain=True)]
    turns: Annotated[np.ndarray, along("orbit", unit="turns per period")]
    energy: Annotated[np.ndarray, along("orbit", unit="energy")]
    angular_momentum: Annotated[np.ndarray, along("orbit")]
    radius: Annotated[np.ndarray, along("orbit")]
    status: Annotated[np.ndarray, along("orbit")]

    def label(self, orbit: int) -> str:
        """Return the family of one orbit as text, such as ``loop +`` or ``resonant 2:1``.

        Parameters
        ----------
        orbit : int
            Number of the orbit.

        Returns
        -------
        str
            Family: ``loop +`` and ``loop -`` are counterclockwise and clockwise. ``z tube +`` is a loop about the axis
            z. ``resonant 2:1`` has nu_y : nu_x = 2 : 1.
        """
        at = whole("orbit", orbit, -self.family.size, self.family.size - 1)
        if self.status[at] != Status.OK:
            return Status(int(self.status[at])).name.lower().replace("_", " ")
        family, k = OrbitFamily(int(self.family[at])), tuple(self.resonance[:, at])
        return self._named(family, int(self.sense[at]), k, not self.unnamed[at])

    @property
    def unnamed(self) -> np.ndarray:
        """Mask of the orbits with two equal lines whose turns are not known: loops or resonant orbits."""
        equal = (np.abs(self.resonance).sum(axis=0) == 2) & (self.resonance.sum(axis=0) == 0)
        return (self.family == OrbitFamily.RESONANT) & equal & np.isnan(self.turns)

    def _named(self, family: OrbitFamily, sense: int, k: tuple[int, ...], counted: bool) -> str:
        """Return the name of a family from its sense, the integers of its resonance and whether turns are known."""
        word = family.name.lower()
        if family == OrbitFamily.LOOP:
            axis = "" if len(k) == 2 else next(name for name, entry in zip(self.names, k, strict=True) if not entry)
            return f"{axis + ' tube' if axis else word} {'+' if sense > 0 else '-'}"
        if family != OrbitFamily.RESONANT:
            return word
        word = word if counted else f"loop or {word}"
        ends = [int(entry) for entry in k if entry]
        if len(k) == 2 and ends[0] * ends[1] < 0:
            return f"{word} {abs(ends[0])}:{abs(ends[1])}"
        return f"{word} {equation(k, self.names)}"

    def table(self) -> list[tuple[str, int]]:
        """Return the families with their numbers of orbits.

        Returns
        -------
        list of tuple
            Tuples (family, orbits), in the order of `OrbitFamily`, frequent ones of one kind first. Orbits that are not
            ``OK`` are last, by their status.
        """
        return [(name, int(mask.sum())) for name, mask in self.members().items()]

    def members(self) -> dict[str, np.ndarray]:
        """Return the orbits of each family.

        Returns
        -------
        dict of ndarray of bool, shape (orbits,)
            Masks by the names of `table`, in its order.
        """
        labels = np.array([self.label(orbit) for orbit in range(self.family.size)], dtype=object)
        fine = self.status == Status.OK
        found = {}
        for name in dict.fromkeys(labels):
            mask = labels == name
            first = int(np.flatnonzero(mask)[0])
            found[str(name)] = (not fine[first], int(self.family[first]), -int(mask.sum()), str(name)), mask
        return {name: mask for name, (_, mask) in sorted(found.items(), key=lambda entry: entry[1][0])}

    def __str__(self) -> str:
        """Return the fields, and the families with their shares of the orbits."""
        total = max(self.family.size, 1)
        rows = [f"  {count:8d}  {count / total:6.1%}  {name}" for name, count in self.table()]
        return "\n".join([super().__str__(), "  orbits      share  family", *rows])

    def summary(self) -> str:
        """Return one line with the numbers of orbits of each family.

        Returns
        -------
        str
            Summary.
        """
        text = describe(self.status, self.members())
        if not self.unnamed.any():
            return text
        return f"{text}; turns need the model and z0, which parts joined and samples do not have: give both"


@says_progress
def orbit_families(
    frequency_map: FrequencyMap,
    *,
    max_order: int = 12,
    model: Dynamics | None = None,
    z0: Starts | None = None,
    threads: int | None = None,
) -> OrbitFamilies:
    r"""Sort the orbits of a frequency map into families: box, loop, resonant, irregular, undecided.

    Parameters
    ----------
    frequency_map : FrequencyMap
        Result of `frequency_map` for a system with two or three Cartesian coordinates, about a centre at the origin.
    max_order : int, default 12
        Largest order :math:`|k|_1` of a resonance, from 2 to 50.
    model : model, optional
        Model of the orbits, with `z0`. Default: that of the call of `frequency_map`, also for a part of its result.
    z0 : array_like, shape (2n, orbits), EnergyGrid or EnergySample, optional
        Initial conditions of the orbits, with `model`. Default: those of the call.
    threads : int, optional
        Number of threads. Default: all.

    Returns
    -------
    `OrbitFamilies`
        Family, sense and resonance of each orbit.

    Raises
    ------
    TypeError
        If `frequency_map` is of a wrong kind.
    ValueError
        If its frequencies are not those of two or three coordinates in time, `max_order` is out of its range, or
        `z0` does not suit.

    Notes
    -----
    - Lines: the dominant line of each coordinate, or its frequency if that line is only a harmonic. Two lines are
      commensurable if they are within their errors.
    - Loops: two coordinates have one frequency, and the orbit makes one turn about the centre per period. Turns are
      counted over 100 to 200 periods.
    - UNDECIDED orbits of the map with sharp, commensurable lines are trapped in a resonance. Chaos that is slower than
      the run is not detected.
    - For samples and joined results, model and initial conditions are not known. Orbits with two equal lines are then
      ``loop or resonant 1:1``, unless you give `model` and `z0`.
    - Cost: one integration of the orbits with two equal lines.

    References
    ----------
    Binney & Spergel 1982, Astrophys. J. 252, 308 (spectral classification); Miralda-Escude & Schwarzschild 1989,
    Astrophys. J. 339, 752 (families of the logarithmic potential); Carpintero & Aguilar 1998, Mon. Not. R. Astron. Soc.
    298, 1 (classification by fundamental frequencies).

    Examples
    --------
    >>> galaxy = fa.hamiltonian("log(0.02 + x**2 + y**2/0.8)/2")
    >>> found = fa.frequency_map(galaxy, [[0.5, 0.6], [0.0, 0.0], [0.0, 0.8], [0.9, 0.1]], time=300.0)
    >>> fa.frequencies.orbit_families(found).table()
    [('box', 1), ('loop +', 1)]
    """
    found: Any = frequency_map
    if not isinstance(found, FrequencyMap):
        raise TypeError(f"frequency_map must be a FrequencyMap, got {shown(frequency_map)}")
    if in_turns(found):
        raise ValueError("frequency_map must be of a system in time, got that of a map. Loops are orbits in time.")
    if not by_own_lines(found) or about_an_axis(found) or len(found.names) not in (2, 3):
        raise ValueError(
            f"frequency_map must have frequencies of two or three Cartesian coordinates, got {', '.join(found.names)}"
        )
    max_order = whole("max_order", max_order, 2, MAX_ORDER)
    n = len(found.names)
    if (model is None) != (z0 is None):
        raise ValueError(f"model and z0 must be given together, got {'z0' if model is None else 'model'} alone")
    if model is None:
        model, starts = start_of(found)
    else:
        starts = phase_points("z0", getattr(z0, "z0", z0), checked_system(model))
        if starts.shape != (2 * n, found.status.size):
            raise ValueError(f"z0 must have shape {(2 * n, found.status.size)}, got {starts.shape}")
    own, error = own_lines(found)
    lines = line_resonances(found, max_order, TOLERANCE, found.names, threads)
    commensurable = (lines.status == Status.OK) & (lines.rank > 0)
    k = np.where(commensurable, lines.basis[0], 0)
    fine = found.status == Status.OK
    regular = fine & found.regular
    family = np.full(found.status.size, OrbitFamily.UNDECIDED, np.int64)
    family[fine & (found.classification == Classification.IRREGULAR)] = OrbitFamily.IRREGULAR
    sharp = regular & (lines.status == Status.OK) & (lines.accidental < ACCIDENTAL)
    family[sharp & ~commensurable] = OrbitFamily.BOX
    # An orbit that a resonance has trapped librates slowly: its other frequency is undecided, its lines are sharp.
    lined = np.isfinite(own).all(axis=0) & (error * found.time < SHARP).all(axis=0)
    lined &= found.classification == Classification.UNDECIDED
    locked = fine & (regular | lined) & (lines.status == Status.OK) & (lines.accidental < ACCIDENTAL) & commensurable
    family[locked] = OrbitFamily.RESONANT
    family[regular & (found.basis.any(axis=1) == 0).any(axis=0)] = OrbitFamily.UNDECIDED
    family[regular & (np.nan_to_num(own) == 0).any(axis=0)] = OrbitFamily.AXIAL
    turns = np.full(family.size, np.nan)
    sense = np.zeros(family.size, np.int64)
    if model is not None:
        for i, j in [(0, 1), (1, 2), (0, 2)][: 1 if n == 2 else 3]:
            pair = (family == OrbitFamily.RESONANT) & (k[i] * k[j] == -1) & (np.abs(k).sum(axis=0) == 2)
            if pair.any():
                turns[pair] = _turns(model, starts[:, pair], own[i, pair], (i, j), found.time, threads)
        with np.errstate(invalid="ignore"):
            family[np.abs(turns) > SWINGING] = OrbitFamily.UNDECIDED
            family[np.abs(turns) > TURNING] = OrbitFamily.LOOP
        sense = np.where(family == OrbitFamily.LOOP, np.sign(np.nan_to_num(turns)), 0).astype(np.int64)
    energy, momentum, radius = values_at(model, starts, n, found.status.size).values()
    return OrbitFamilies(
        names=tuple(found.names),
        family=family,
        sense=sense,
        resonance=k,
        nu=own,
        turns=turns,
        energy=energy,
        angular_momentum=momentum,
        radius=radius,
        status=found.status.copy(),
    )


def start_of(found: FrequencyMap) -> tuple[Any, Any]:
    """Return the model of a frequency map, or of the map that it is a part of, and its initial conditions (2n, orbits),
    None where they are not known.
    """
    origin: Any = getattr(found, "origin", None)
    call: Any = getattr(found, "call", getattr(origin, "call", None))
    try:
        files = imported("..exchange.files", __package__)
        model, z0 = (files.decoded(name, call.arguments[name], {}) for name in ("model", "z0"))
    except (AttributeError, KeyError, ValueError):
        return None, None
    z0 = np.asarray(z0, dtype=float).reshape(len(z0), -1)
    if not hasattr(found, "call") and z0.shape[1] == math.prod(origin.shape):
        z0 = z0[:, origin.items()]
    n = len(found.names)
    return (model, z0) if z0.shape == (2 * n, found.status.size) else (None, None)


def start_values(found: FrequencyMap) -> dict[str, np.ndarray]:
    """Return energy, angular momentum of the first two coordinates, and radius (orbits,) of the initial conditions of a
    frequency map, by name; NaN if they are not known.
    """
    return values_at(*start_of(found), len(found.names), found.status.size)


def values_at(model: Any, z0: Any, n: int, orbits: int) -> dict[str, np.ndarray]:
    """Return the same of a model at initial conditions (2n, orbits), which may be None."""
    if model is None or n < 2:
        return dict.fromkeys(START_VALUES, np.full(orbits, np.nan))
    x, y = z0[:2]
    p_x, p_y = z0[n : n + 2]
    values = current_system(model).energies(z0), x * p_y - y * p_x, np.sqrt((z0[:n] ** 2).sum(axis=0))
    return dict(zip(START_VALUES, values, strict=True))


def _turns(
    model: Any, z0: np.ndarray, nu: np.ndarray, plane: tuple[int, int], longest: float, threads: int | None
) -> np.ndarray:
    """Return the mean turns (orbits,) about the centre of a plane in a period, 1/nu (orbits,)."""
    octave = np.ceil(np.log2(1 / nu)).astype(int)  # orbits of similar periods, whatever the others are
    turned = np.zeros(nu.size)
    for each in np.unique(octave):
        period = 2.0**each
        time = min(longest, PERIODS * period)
        samples = max(64, int(np.ceil(2 * DENSE * time / period)))
        mine = np.flatnonzero(octave == each)
        for part in np.array_split(mine, -(-mine.size * len(z0) * samples // BUDGET)):
            turned[part] = _mean_turns(model, z0[:, part], plane, time, samples, threads)
    return turned / nu


def _mean_turns(
    model: Any, z0: np.ndarray, plane: tuple[int, int], time: float, samples: int, threads: int | None
) -> np.ndarray:
    """Return the turns (orbits,) in a unit of time about the centre of a plane, 0 if orbits go to and fro."""
    run = integrate(model, z0, time=time, samples=samples, accuracy=ACCURACY, threads=threads)
    x, y = run.samples[:, list(plane)].transpose(1, 0, 2)
    angle = np.unwrap(np.arctan2(y, x), axis=0)
    area = x[:-1] * y[1:] - y[:-1] * x[1:]
    swept = np.abs(area).sum(axis=0)
    # The angle of an orbit through the centre jumps by half a turn, of either sign.
    goes_round = np.abs(area.sum(axis=0)) > np.maximum(ONE_WAY * swept, ROUNDING * (x**2 + y**2).sum(axis=0))
    return np.where(goes_round, (angle[-1] - angle[0]) / (2 * np.pi * (run.times[-1] - run.times[0])), 0.0)
