"""Families of periodic orbits followed in the energy or a parameter, with their bifurcations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import numbers, positive, real, shown, whole
from ..core.status import Status
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.progress import tell
from ..results.result import Result, along
from ..runs.options import Options, plan
from ..runs.requirements import carried, check_needs, current_system
from ..runs.schemes.catalogue import Scheme, scheme_of
from ..systems.formulas.section_text import section_of
from ..systems.models.contracts import Dynamics, Section
from .bifurcations import Bifurcation, bifurcations
from .family import VANISHED, Family, Point
from .found_orbits import PeriodicOrbits, no_orbits
from .own_units import Scale, closed_scale, orbit_scale
from .periodic_orbits import LONGER, periodic_orbits
from .return_map import checked_return

EASY = 3
"""Corrections after which the next step along the branch is longer."""


JUMP = 0.1
"""Largest change of the residues' product between neighbouring points, relative to 1 + the product, so that no dip is
missed.
"""

SHORTEST = 1e-6
"""Least step along the branch, beside the first one."""


STOPPED = Status.INTERRUPTED, "stopped by the user before its end"
"""Status and stop reason of a branch after Ctrl-C."""


@dataclass(frozen=True)
class Branch(Result, axis="point"):
    """Family of periodic orbits, followed in the energy or in a parameter.

    Attributes
    ----------
    parameter : ndarray, shape (points,)
        Energy or parameter of each orbit.
    arclength : ndarray, shape (points,)
        Arclength in the space of z and parameter, both in units of the first orbit.
    orbits : PeriodicOrbits
        Periodic orbits at the points of the branch.
    bifurcations : tuple of Bifurcation
        Bifurcations in the order of the branch.
    status : Status
        OK if the branch ended at `max_steps` or its bounds; ACTION_ZERO if the orbits shrink to an equilibrium;
        NOT_CONVERGED if the shortest step failed; INTERRUPTED after Ctrl-C.
    stop_reason : str
        The reason for the end as text.
    amplitude : ndarray, shape (2n, points), or None
        For driven and ODE systems half of the range of each variable over the orbit, the height of a response curve;
        else None.
    """

    parameter: Annotated[np.ndarray, along("point")]
    arclength: Annotated[np.ndarray, along("point")]
    orbits: Annotated[PeriodicOrbits, along("point")]
    bifurcations: tuple[Bifurcation, ...]
    status: Status
    stop_reason: str
    amplitude: Annotated[np.ndarray | None, along("coordinate", "point", labels="names")] = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables, 2n of them."""
        return self.orbits.names

    def summary(self) -> str:
        """Return one line with the range of the branch and the reason for its end.

        Returns
        -------
        str
            Summary.
        """
        if not len(self.parameter):
            return self.stop_reason
        count = f"{len(self.parameter)} points from {self.parameter[0]:.6g} to {self.parameter[-1]:.6g}"
        return f"{count}, {len(self.bifurcations)} bifurcations; {self.stop_reason}"


@coerces_arguments(section=section_of, scheme=scheme_of)
@records_call
@inserts_parameters
def continuation(
    model: Dynamics,
    z0: Starts,
    *,
    section: Section | str | None = None,
    crossings: int = 1,
    parameter: float | None = None,
    energy: float | None = None,
    bounds: tuple[float, float] = (-np.inf, np.inf),
    direction: int = 1,
    ds: float = 0.01,
    ds_max: float = 0.1,
    max_steps: int = 100,
    max_time: float | None = None,
    tolerance: float = 1e-12,
    step: float | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-13,
    atol: float = 1e-13,
    threads: int | None = None,
) -> Branch:
    r"""Follow a family of periodic orbits in the energy, or in a parameter at one energy.

    Parameters
    ----------
    model : model or callable
        System to compute, with derivatives of its forces. If a parameter is followed, a function that returns the model
        for a value, such as ``lambda C: Body(Hyperelastic(C))``.
    z0 : array_like, shape (2n,)
        Initial guess of the first orbit.
    {section}
    crossings : int, default 1
        Number of crossings (for a map of iterates) after which an orbit closes.
    parameter : float, optional
        First value of the parameter to follow. Default: the family is followed in the energy.
    energy : float, optional
        Energy of the first orbit, and of all orbits if a parameter is followed. Default: the energy of the guess.
    bounds : tuple of float, default (-inf, inf)
        Range of the energy or parameter. The branch ends at a bound.
    direction : {1, -1}, default 1
        Sign of the first change of the energy or parameter.
    ds : float, default 0.01
        First arclength step in (z, energy) or (z, parameter), without a unit. The units of z are the amplitudes of the
        first orbit (``scale`` of `PeriodicOrbits`). The unit of the energy is its kinetic energy. The unit of a
        parameter is the change that moves the return by one amplitude.
    ds_max : float, default 0.1
        Maximum arclength step.
    max_steps : int, default 100
        Maximum number of points after the first.
    max_time : float, optional
        Time, in units of time, within which an orbit must have its crossings. Default: 20 periods of the motion for
        each crossing, and 160 if an orbit needs more.
    {closing_tolerance}
    {closing_step}
    {closing_scheme}
    {closing_rtol}
    {closing_atol}
    {threads}

    Returns
    -------
    `Branch`
        Orbits of the family, with its bifurcations.

    Raises
    ------
    ValueError
        If a value is out of its range, or the guess leads to no periodic orbit.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the branch so far in ``.partial``, without its bifurcations.

    Notes
    -----
    - Method: pseudo-arclength continuation, which passes folds. Steps grow by half after a correction of few
      iterations. They are halved after a failure, a bend above 0.35 radians or a change of the residue R above
      0.1(1 + abs(R)).
    - Bifurcations: sign changes of :math:`\prod R` or :math:`\prod (1 - R)`, refined in the arclength. Residues that
      touch 0 or 1, or pass it twice between points, are missed. At a branch point the same branch is followed.
    - ODE systems: products of :math:`(1 \mp m)/2` over the multipliers m, and of :math:`1 - m m'` over pairs for a
      Neimark-Sacker bifurcation. In Hamiltonian systems, ``stability`` alone shows it.
    - Cost: 3 returns with 2n deviation vectors for each point, 9 with a parameter.

    References
    ----------
    Keller 1977, in Applications of Bifurcation Theory (pseudo-arclength); Greene, MacKay, Vivaldi & Feigenbaum 1981,
    Physica D 3, 468 (residues at bifurcations).

    Examples
    --------
    >>> family = fa.continuation(
    ...     fa.HenonHeiles(), [0.0, 0.0, 0.3, 0.31], section="x=0", energy=0.1, max_steps=2, max_time=20.0
    ... )
    >>> print(family.summary())
    3 points from 0.1 to 0.101885, 0 bifurcations; ended after its 2 steps: increase max_steps or ds_max to go further
    """
    make, first_model = _family(model, parameter)
    section = section_of(section, first_model)
    system = current_system(first_model)
    scheme = checked_return(system, section, scheme)
    if parameter is None:
        check_needs(system, "a branch along the energy")
    if not isinstance(direction, (int, float, np.number)) or direction not in (-1, 1):
        raise ValueError(f"direction must be +1 or -1, got {shown(direction)}")
    low, high = _bounds(bounds)
    ds_max = positive("ds_max", ds_max)
    tolerance = positive("tolerance", tolerance)
    ds = min(positive("ds", ds), ds_max)
    max_steps = whole("max_steps", max_steps, 1)
    crossings = whole("crossings", crossings, 1)
    limit = None if max_time is None else positive("max_time", max_time)
    none = no_orbits(system, section, scheme)
    (status, reason) = STOPPED
    empty = Branch(np.zeros(0), np.zeros(0), none, bifurcations=(), status=status, stop_reason=reason)
    how: Any = {"scheme": scheme, "step": step, "rtol": rtol, "atol": atol, "threads": threads}
    with partial_result_on_interrupt("continuation", lambda: empty):
        cut: Any = {"section": section, "crossings": crossings, "max_time": max_time}
        first = periodic_orbits(first_model, z0, energy=energy, tolerance=tolerance, **cut, **how)
        if first.status.size != 1 or first.status[0] != Status.OK:
            raise ValueError(f"z0 must be a guess (2n,) that leads to a periodic orbit, got {first.summary()}")
        value = float(first.energy[0]) if parameter is None else parameter
        if not low <= value <= high:
            raise ValueError(f"bounds must contain the first value {shown(value)}, got {shown(bounds)}")
        how["step"] = None if section is None or np.isinf(first.step[0]) else float(first.step[0])
        # z: of an odd number of variables with the idle row.
        flow, z, *_ = plan(first_model, first.z, Options(**{**how, "scheme": first.scheme}))
        surface = None if section is None else flow.section(section)
        own = step is None and flow.fixed
        scale = orbit_scale(system, z, first.energy, flow.threads)
        first_flow = flow if flow.adaptive or section is None else replace(flow, step=first.step)
        returns = carried(np.moveaxis(first.points, (0, 1, 2), (2, 1, 0)), system, axis=2)
        scale = closed_scale(first_flow, z, returns, first.period, scale)
        units = np.append(scale.rows[:, 0], scale.energy[0])
        kept = None if parameter is None else float(first.energy[0])
        wait = LONGER * first.period[0]
        more: Any = {"own_step": own, "units": units, "wait": wait}
        family = Family(make, flow, surface, section, crossings, limit, tolerance, kept, **more)
        start = _first_point(family, np.append(z[:, 0], value), scale, first.step[0])
    points = [_turned(start, direction)]
    with partial_result_on_interrupt("continuation", lambda: _branch(family, points, *STOPPED)):
        branch = _branch(family, points, *_follow(family, points, ds, ds_max, max_steps, (low, high)))
        return replace(branch, bifurcations=tuple(bifurcations(family, points, branch.arclength, branch.orbits)))


def _first_point(family: Family, u: np.ndarray, scale: Scale, step: float) -> Point:
    """Return the first orbit as a point of the family, once the family has its unit of the parameter."""
    if family.energy is not None:
        family.units[-1] = family.parameter_unit(u, scale)
    start = family.corrected(u, None, scale, step)
    if start is None:
        raise ValueError("z0 leads to an orbit that cannot be continued")
    return start


def _branch(family: Family, points: list[Point], status: Status, reason: str) -> Branch:
    """Return the branch of the points found so far, without its bifurcations."""
    orbits = PeriodicOrbits.concat([family.orbits(p) for p in points])
    values = np.array([p.u[-1] for p in points])
    arclength = np.concatenate([[0.0], np.cumsum([family.distance(a.u, b.u) for a, b in pairwise(points)])])
    heights = [family.amplitude(p) for p in points]
    amplitude = None if heights[0] is None else np.array(heights).T
    whole: Any = {"parameter": values, "arclength": arclength, "orbits": orbits, "amplitude": amplitude}
    return Branch(**whole, bifurcations=(), status=status, stop_reason=reason)


def _turned(start: Point, direction: int) -> Point:
    """Return the first point with its tangent in the first direction of the energy or parameter."""
    forward = start.tangent if start.tangent[-1] * direction >= 0 else -start.tangent
    return replace(start, tangent=forward)


def _family(model: Any, parameter: float | None) -> tuple[Callable, Any]:
    """Return the function from the parameter to the model, and the first model."""
    if parameter is None:
        return (lambda _: model), model
    if not callable(model) or isinstance(model, tuple):
        raise TypeError(
            "model must be a function from the parameter to a model if a parameter is followed, got "
            f"{shown(model)} ({type(model).__name__})"
        )
    return model, model(real("parameter", parameter))


def _bounds(bounds: Any) -> tuple[float, float]:
    given = numbers("bounds", bounds)
    if given.shape != (2,) or not given[0] < given[1]:
        raise ValueError(f"bounds must be two increasing numbers, got {shown(bounds)}")
    return float(given[0]), float(given[1])


def _reached(first: float, value: float, bounds: tuple[float, float], share: float) -> tuple[float, str]:
    """Return the share of a branch that is done, of its steps or of the way to its bound, and where it is in words."""
    way = (bounds[1] if value > first else bounds[0]) - first
    done = (value - first) / way if np.isfinite(way) and way != 0.0 else 0.0
    return max(share, done), f"at {value:.6g}"


def _follow(family, points: list[Point], ds, ds_max, max_steps, bounds) -> tuple[Status, str]:
    """Step along the branch from its first point to its bounds, its number of steps, or the shortest step; add to the
    points. Return the status and the reason for the end in words.
    """
    start = points[0]
    signs = family.products(points[0])[:2]
    shortest = SHORTEST * ds
    while len(points) <= max_steps:
        last = points[-1]
        tell("continuation", *_reached(start.u[-1], last.u[-1], bounds, (len(points) - 1) / max_steps))
        point = family.ahead(last, ds)
        ahead = (
            family.products(point)[:2] if point is not None and family.follows(last, point, ds) else np.full(2, np.nan)
        )
        if not (np.abs(ahead - signs) <= JUMP * (1 + np.abs(signs))).all():
            ds *= 0.5
            if ds < shortest:
                if last.scale.energy[0] < VANISHED * start.scale.energy[0]:
                    return Status.ACTION_ZERO, "ended where the orbits shrink to an equilibrium"
                return Status.NOT_CONVERGED, f"ended where steps down to ds={ds:.1e} found no further orbit"
            continue
        if not bounds[0] <= point.u[-1] <= bounds[1]:
            edge = bounds[0] if point.u[-1] < bounds[0] else bounds[1]
            share = (edge - last.u[-1]) / (point.u[-1] - last.u[-1])
            between = np.append(((1 - share) * last.u + share * point.u)[:-1], edge)
            end = family.corrected(between, None, last.scale, last.following)
            if end is None and share > 1e-9:
                return Status.NOT_CONVERGED, f"ended next to the bound {edge:.6g}, where no orbit was found"
            if end is not None and share > 1e-9:
                points.append(end)
            return Status.OK, f"ended at the bound {edge:.6g}"
        points.append(point)
        signs = ahead
        if point.corrections <= EASY:
            ds = min(1.5 * ds, ds_max)
    return Status.OK, f"ended after its {max_steps} steps: increase max_steps or ds_max to go further"
