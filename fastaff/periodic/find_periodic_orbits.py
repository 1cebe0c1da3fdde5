"""All periodic orbits up to a number of crossings: guesses from close returns of a section map, then Newton."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.interruption import Interrupted, partial_result_on_interrupt
from ..core.numbers import positive, shown, whole
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.progress import tell
from ..runs.options import Options
from ..runs.requirements import current_system
from ..runs.scales import typical_rate
from ..runs.schemes.catalogue import Scheme, scheme_of
from ..runs.starts import starts_of
from ..sections.poincare_map import poincare_map
from ..sections.section_map import SectionMap
from ..systems.formulas.section_text import section_of
from ..systems.models.contracts import Dynamics, Section
from .found_orbits import PeriodicOrbits, no_orbits
from .periodic_orbits import WAIT, periodic_orbits
from .return_map import checked_guesses, checked_return


def periodic_guesses(
    section_map: SectionMap, crossings: int, *, max_guesses: int = 100, min_distance: float = 0.02
) -> np.ndarray:
    """Find points of a section that return close to themselves, the closest first.

    Parameters
    ----------
    section_map : SectionMap
        Crossings of orbits, more than `crossings` of each.
    crossings : int
        Positive number of crossings after which a point returns.
    max_guesses : int, default 100
        Largest number of points.
    min_distance : float, default 0.02
        Smallest distance between two points, as a fraction of the size of the section in each coordinate.

    Returns
    -------
    ndarray, shape (2n, guesses)
        Phase points; no column if no orbit is long enough.

    Raises
    ------
    ValueError
        If a value is out of its range.
    TypeError
        If `section_map` is of another kind.

    Notes
    -----
    - Method: close returns. Every crossing is compared with its image. Among points nearer to each other than
      `min_distance` the one with the smallest displacement is kept, a local minimum of the displacement.

    References
    ----------
    Auerbach et al. 1987, Phys. Rev. Lett. 58, 2387 (the method of close returns).

    Examples
    --------
    >>> cut = fa.poincare_map(fa.models.StandardMap(0.9), [[3.0, 2.8], [0.1, 0.0]], crossings=200)
    >>> guesses = fa.periodic.periodic_guesses(cut, 1)
    >>> fa.periodic_orbits(fa.models.StandardMap(0.9), guesses[:, :1]).z.round(9) + 0.0
    array([[3.14159265],
           [0.        ]])
    """
    if not isinstance(section_map, SectionMap):
        raise TypeError(f"section_map must be a SectionMap, got {shown(section_map)} ({type(section_map).__name__})")
    crossings = whole("crossings", crossings, 1)
    max_guesses = whole("max_guesses", max_guesses, 1)
    min_distance = positive("min_distance", min_distance)
    points = section_map.points.transpose(2, 1, 0)
    rows = points.shape[2]
    if points.shape[1] <= crossings:
        return np.zeros((rows, 0))
    flat = points.reshape(-1, rows)
    size = np.fmax.reduce(flat, axis=0) - np.fmin.reduce(flat, axis=0)
    # The section's own direction has no information: its row varies by rounding, beside rows of its kind.
    halves = (size,) if rows % 2 else np.split(size, 2)
    kind = np.concatenate([np.full(len(half), np.fmax.reduce(half)) for half in halves])
    scale = np.where(size > np.maximum(1e-12 * kind, 1e-13 * np.fmax.reduce(np.abs(flat), axis=0)), size, np.inf)
    away = np.linalg.norm((points[:, crossings:] - points[:, :-crossings]) / scale, axis=2)
    # The best crossings represent an orbit: along a regular orbit the displacement repeats itself.
    per_orbit = np.argsort(away, axis=1)[:, : max(1, -(-20 * max_guesses // len(away)))]
    orbit = np.repeat(np.arange(len(away)), per_orbit.shape[1])
    slot = per_orbit.ravel()
    near = away[orbit, slot]
    order = np.argsort(near, kind="stable")
    order = order[np.isfinite(near[order])]
    candidates = points[orbit[order], slot[order]]
    free = np.ones(len(candidates), bool)
    chosen: list[int] = []
    while free.any() and len(chosen) < max_guesses:
        k = int(np.argmax(free))
        chosen.append(k)
        free &= np.linalg.norm((candidates - candidates[k]) / scale, axis=1) > min_distance
        free[k] = False
    return candidates[chosen].T


@coerces_arguments(z0=starts_of, section=section_of, scheme=scheme_of)
@records_call
@inserts_parameters
def find_periodic_orbits(
    model: Dynamics,
    z0: Starts | SectionMap,
    *,
    section: Section | str | None = None,
    max_crossings: int,
    energy: float | None = None,
    max_guesses: int = 100,
    min_distance: float = 0.02,
    scan_crossings: int | None = None,
    max_time: float | None = None,
    tolerance: float = 1e-12,
    iterations: int = 40,
    step: float | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-13,
    atol: float = 1e-13,
    threads: int | None = None,
) -> PeriodicOrbits:
    """Find the periodic orbits of a section map up to a number of crossings, from close returns of orbits.

    Parameters
    ----------
    {closing_model}
    z0 : array_like, shape (2n, orbits), or SectionMap
        Initial conditions of the orbits whose close returns are the guesses, such as ``energy_grid(...).z0``, or a
        `SectionMap` of this section.
    {section}
    max_crossings : int
        Largest number of crossings of a periodic orbit.
    energy : float, optional
        Energy of all orbits. Default: that of each guess.
    max_guesses : int, default 100
        Largest number of guesses for each number of crossings.
    min_distance : float, default 0.02
        Smallest distance between two guesses, as a fraction of the size of the section in each coordinate.
    scan_crossings : int, optional
        Number of crossings of each orbit from `z0`. Default: ``max_crossings + 8``.
    max_time : float, optional
        Time after which an orbit from `z0` ends. Not used for maps and stroboscopic sections.
    {closing_tolerance}
    iterations : int, default 40
        Largest number of returns that are computed for a guess with one step size.
    {closing_step}
    {closing_scheme}
    {closing_rtol}
    {closing_atol}
    {threads}

    Returns
    -------
    `PeriodicOrbits`
        Each orbit that was found once, over its minimal period, those of few crossings first. On a resonant torus of an
        integrable model there are as many orbits as guesses.

    Raises
    ------
    ValueError
        If a value is out of its range, or no orbit returns more than once.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the orbits found so far in ``.partial``.

    Notes
    -----
    - Method: `periodic_guesses` for each number of crossings, then `periodic_orbits`. A finer grid of initial
      conditions makes the search more complete.
    - Completeness: for two degrees of freedom, the fixed points of a power of the map on an energy surface have a total
      index. It is the number with residue R > 0 less the number with R < 0, and shows how many are missing.
    - Cost: the section map, then that of `periodic_orbits` for `max_guesses` guesses of each number of crossings.

    References
    ----------
    Auerbach et al. 1987, Phys. Rev. Lett. 58, 2387 (close returns); Baranger, Davies & Mahoney 1988, Ann. Phys. 186, 95
    (the monodromy method); Greene 1979, J. Math. Phys. 20, 1183 (index).

    Examples
    --------
    >>> starts = np.array([[3.0, 2.8, 2.5], [0.1, 0.0, 0.2]])
    >>> found = fa.find_periodic_orbits(fa.models.StandardMap(0.9), starts, max_crossings=1)
    >>> found.z.round(9) + 0.0
    array([[3.14159265],
           [0.        ]])
    """
    system = current_system(model)
    scheme = checked_return(system, section, scheme)
    longest = whole("max_crossings", max_crossings, 1)
    tolerance = positive("tolerance", tolerance)
    iterations = whole("iterations", iterations, 1)
    seen = z0 if isinstance(z0, SectionMap) else None
    rows = system.rows
    if seen is not None and len(seen.points) != rows:
        raise ValueError(f"z0 must be a SectionMap of {rows} rows, got one of {len(seen.points)}")
    starts = z0 if seen is None else seen.points[:, 0, seen.counts > 0]
    how: Any = {"scheme": scheme, "step": step, "rtol": rtol, "atol": atol, "threads": threads}
    flow, z, _ = checked_guesses(system, starts, energy, Options(**how))
    how["scheme"] = flow.scheme
    count = longest + 8 if scan_crossings is None else whole("scan_crossings", scan_crossings, 2)
    wait = WAIT / typical_rate(system, z) if max_time is None else positive("max_time", max_time) / count
    newton = partial(
        periodic_orbits, model, section=section, energy=energy, tolerance=tolerance, iterations=iterations, **how
    )
    search = _PeriodSearch(newton, None if max_time is None else wait, [no_orbits(system, section, flow.scheme)])
    with partial_result_on_interrupt("find_periodic_orbits", search.orbits):
        if seen is None:
            limit = None if section is None or system.driven else wait * count
            seen = poincare_map(model, z[:rows], section=section, crossings=count, max_time=limit, **how)
        for k in range(1, longest + 1):
            tell("find_periodic_orbits", (k - 1) / longest, f"{k} of {longest} crossings")
            search.near(periodic_guesses(seen, k, max_guesses=max_guesses, min_distance=min_distance), k)
        if len(search.found) == 1:
            raise ValueError("z0 has no orbit that returns to the section more than once")
        return search.orbits()


@dataclass(frozen=True)
class _PeriodSearch:
    """Orbits over their minimal period found so far, the first entry none, and Newton's method, which finds more.

    wait: time for each crossing, or None.
    """

    newton: Callable[..., PeriodicOrbits]
    wait: float | None
    found: list[PeriodicOrbits]

    def orbits(self) -> PeriodicOrbits:
        """Return each orbit once."""
        return PeriodicOrbits.concat(self.found).unique()

    def near(self, guesses: np.ndarray, crossings: int) -> None:
        """Add the orbits near guesses (2n, guesses) of so many crossings; those that close after fewer are sought again
        with these.
        """
        if not guesses.size:
            return
        try:
            max_time = None if self.wait is None else self.wait * crossings
            orbits = self.newton(guesses, crossings=crossings, max_time=max_time)
        except Interrupted as stopped:
            self.found.append(stopped.partial.take(stopped.partial.minimal_crossings == crossings))
            raise
        minimal = orbits.minimal_crossings
        self.found.append(orbits.take(minimal == crossings))
        for fewer in np.unique(minimal[(minimal > 0) & (minimal < crossings)]):
            self.near(orbits.z[:, minimal == fewer], int(fewer))
