"""Returns of orbits to a section with their monodromy matrices, for searches of periodic orbits.

Operations that mix coordinates and momenta are done in an orbit's own units, `orbit_scale`: results are the same in any
unit of length, time and mass, for any origin and zero of the potential, and independent of other orbits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import fits, kind_of, numbers, shown
from ..core.status import Status
from ..engine.kernels import crossings as kernels
from ..engine.values import at_points
from ..results.display import screen
from ..runs import observers
from ..runs.flow import Ensemble, Flow, no_memory
from ..runs.options import Options, plan, suited
from ..runs.requirements import check_given, check_needs, checked_section, checked_tangent_system
from ..runs.scales import motion
from ..runs.schemes.catalogue import GAUSS16, ITERATION, KAHAN_LI8, VERNER9
from ..sections.crossing_run import SPARE, follow_crossings, start_crossings
from ..systems.models.mechanics import System
from ..systems.models.sections import Stroboscopic
from .own_units import Scale

STEP_ERROR = 1e-13
"""Error that the first step is chosen for if none is given: an orbit cannot close better than its flow."""

FASTEST = 1e10
"""Turns of an angle in one iterate beyond which a map's points are rounding."""

ASIDE = 1e-2
"""Displacement, relative or in the coordinates' unit, of a neighbour of an orbit at rest."""

COMPLEX_STEP = 1e-100
"""Imaginary step of a complex-step derivative: small enough that its square underflows and no difference is rounded."""

RANK = 1e-8
"""Singular values below this fraction of the largest count as 0: directions in which a periodic orbit has periodic
neighbours.
"""

STRETCHED = 1e2
"""Largest singular value up to which the fraction is RANK. Beyond it, as for an unstable orbit's M, the fraction falls
with its inverse square, as other singular values fall like its inverse.
"""

SHARPEST = 1e-14
"""Least fraction: rounding."""

WALK = 1.5
"""Roundings of a state after a step, beside the root of the number of steps: those of about 17 stages.
"""

FINER = 8.0
"""Largest factor by which a step becomes shorter at once."""


def checked_guesses(system: System, z0: Any, energy: Any, options: Options) -> tuple[Flow, np.ndarray, np.ndarray]:
    """Check the arguments of searches; return the flow, the guesses (2n, orbits) and their energies (orbits,)."""
    name = kind_of(system.model)
    check_given(system, "a return at an energy", energy=energy)
    if not (system.canonical or system.iterated) and system.rows < 2:
        raise ValueError(f"model {name} must have two variables or more to return, it has one")
    if system.energetic and system.n < 2:
        raise ValueError(f"model {name} must have two degrees of freedom or more, it has {system.n}")
    aim = None if energy is None else numbers("energy", energy)  # before anything is compiled
    flow, z, *_ = plan(system.model, z0, suited(options, system), error=STEP_ERROR)
    if system.driven:
        z[-1] -= system.energies(z)  # so that p_t is one at each place and phase
        if options.step is None and not flow.adaptive:
            flow = replace(flow, step=_steps_at_rest(flow, z, options))
    given = system.energies(z) if aim is None else aim
    if given.shape not in ((), (z.shape[1],)) or not np.isfinite(given).all():
        raise ValueError(f"energy must be a finite number, or one for each of {z.shape[1]} orbits, got {shown(energy)}")
    return flow, z, np.array(np.broadcast_to(given, z.shape[1:]))


def _steps_at_rest(flow: Flow, z: np.ndarray, options: Options) -> np.ndarray:
    """Return the steps (orbits,) of a flow; orbits at rest, where no step shows an error, get that of a neighbour."""
    steps = np.array(np.broadcast_to(flow.step, z.shape[1:]))
    rest = motion(flow.system, z, flow.threads).kinetic == 0
    if rest.any():
        near = z[:, rest]
        n = flow.system.moving
        near[:n] += ASIDE * np.where(near[:n] != 0, np.abs(near[:n]), 1.0)
        steps[rest] = plan(flow.model, near, options, error=STEP_ERROR).flow.step
    return steps


def checked_return(system: System, section: Any, scheme: Any) -> Any:
    """Check a model with its section, which a map does not have; return the scheme."""
    check_needs(system, "a return")
    checked_tangent_system(system.model, "model")
    if not system.iterated:
        checked_section(section, system)
        if system.driven and not isinstance(section, Stroboscopic):
            raise ValueError(
                f"section must be a stroboscopic one for a driven system, such as 't=0', got {shown(section)}"
            )
        usual: Any
        if system.separable:
            usual = KAHAN_LI8
        elif system.canonical:
            usual = GAUSS16
        else:
            usual = VERNER9
        return usual if scheme is None else scheme
    check_given(system, "a time", "the returns of a map are its images", section=section)
    return ITERATION if scheme is None else scheme


class Returns(NamedTuple):
    """Orbits followed to a crossing of a section, or to an image by a map.

    points (orbits, crossings, 2n): the crossings in their order; time (orbits,) of the last; monodromy (orbits, 2n,
    2n): the derivative of the flow over that time; status (orbits,). NaN where the status is not OK.
    """

    points: np.ndarray
    time: np.ndarray
    monodromy: np.ndarray
    status: np.ndarray

    def __repr__(self) -> str:
        return screen(self)


def section_returns(flow: Flow, section: Any, z: np.ndarray, crossings: int, max_time: Any) -> Returns:
    """Follow z (2n, orbits), all on the section, to crossing number `crossings` with 2n tangent vectors each; max_time
    (orbits,) or one. For a map, which has no section, follow z to that image, with its angles next to those of z.
    """
    rows, orbits = z.shape
    n = rows // 2
    strobed = isinstance(section, Stroboscopic)
    fits("crossings", orbits, crossings + SPARE, kernels.RECORD.state + rows * (1 + rows))
    found = Returns(
        np.full((orbits, crossings, rows), np.nan),
        np.full(orbits, np.nan),
        np.full((orbits, rows, rows), np.nan),
        np.full(orbits, int(Status.NONFINITE)),
    )
    live = np.flatnonzero(np.isfinite(z).all(axis=0) & flow.system.inside(z))
    if not live.size:
        return found
    flow = replace(flow.of(live), vectors=rows)
    unit = np.broadcast_to(np.eye(rows)[:, :, None], (rows, rows, live.size))
    ensemble = flow.ensemble(np.ascontiguousarray(z[:, live]), unit)
    if flow.system.iterated:
        return _images(flow, z[:, live], live, ensemble, found)
    if strobed:
        parts = _period_by_period(flow, section, ensemble, crossings)
        found.time[live] = crossings * flow.model.period
        arrived = np.isfinite(parts).all(axis=(1, 2, 3, 4))
        return _filled(found, live, parts, arrived, ensemble.status)
    limit = np.broadcast_to(np.asarray(max_time, dtype=np.float64), orbits)[live]
    whole = len(ensemble.z)
    width = kernels.RECORD.state + whole
    observer = observers.crossings(section, crossings, n, rows)
    memory = np.zeros((observer.rows, live.size))
    out = np.full((live.size, (crossings + SPARE) * width), np.nan)
    start_crossings(flow, memory, section, ensemble, on=True)
    follow_crossings(flow, ensemble, section, crossings, observer, memory, out, limit, None)
    records = out.reshape(live.size, -1, width)[:, :crossings]
    parts = records[:, :, kernels.RECORD.state :].reshape(live.size, crossings, 2, 1 + rows, n)
    found.time[live] = records[:, -1, kernels.RECORD.time]
    reached = (memory[kernels.ROWS.written] >= crossings) & (found.time[live] <= limit)
    arrived = np.isfinite(parts[:, -1, :, 1:]).all(axis=(1, 2, 3)) & reached
    return _filled(found, live, parts, arrived, ensemble.status)


def _period_by_period(flow: Flow, section: Any, ensemble: Ensemble, periods: int) -> np.ndarray:
    """Run orbits of a driven system with tangent vectors from the section; return their states (orbits, periods, 2,
    1 + vectors, n) after each period, NaN where not reached.
    """
    n = flow.model.degrees_of_freedom
    flow = flow.fitted(float(flow.model.period))
    shape = 2, 1 + flow.vectors, n, ensemble.z.shape[1]
    states = np.full((periods, *shape), np.nan)
    observed = 0 if flow.adaptive else 1
    for state in states:
        flow.advance(
            ensemble, observers.nothing(), *no_memory(ensemble), time=float(flow.model.period), observations=observed
        )
        going = ensemble.status == Status.OK
        state[..., going] = ensemble.z.reshape(shape)[..., going]
        state[0, 0, n - 1, going] = section.phase  # to rounding, of the steps of a period
        ensemble.count[:] = 0
        ensemble.ticks[:] = 0
        ensemble.time[:] = 0.0
    return np.moveaxis(states, -1, 0)


def _filled(found: Returns, live: np.ndarray, parts: np.ndarray, arrived: np.ndarray, ended: np.ndarray) -> Returns:
    """Return the returns with states parts (orbits, crossings, 2, 1 + vectors, n) of the orbits `live`, some of which
    have arrived.
    """
    rows = found.points.shape[2]
    found.points[live] = parts[:, :, :, 0].reshape(live.size, -1, rows)
    found.monodromy[live] = parts[:, -1, :, 1:].transpose(0, 1, 3, 2).reshape(live.size, rows, rows)
    ended = np.where(ended == Status.OK, Status.TOO_FEW_CROSSINGS, ended)
    found.status[live] = np.where(arrived, Status.OK, ended)
    for array in found[:3]:
        array[live[~arrived]] = np.nan
    return found


def _images(flow: Flow, z: np.ndarray, live: np.ndarray, ensemble: Ensemble, found: Returns) -> Returns:
    """Return the returns with the images of z (2n, orbits), the live ones, by a map."""
    rows = len(z)
    iterates = found.points.shape[1]
    parts = flow.sampled(ensemble, iterates, time=float(iterates)).reshape(live.size, iterates, 2, 1 + rows, rows // 2)
    turns = np.zeros(rows)  # of an idle row too
    turns[: flow.system.rows] = [1 / length if length > 0 else 0.0 for length in flow.model.periods()]
    found.time[live] = float(iterates)
    arrived = np.isfinite(parts[:, -1, :, 1:]).all(axis=(1, 2, 3))
    with np.errstate(all="ignore"):  # an angle that winds so fast that it is all rounding
        ahead = np.array(np.broadcast_arrays(*at_points(flow.model, "iterate", *z[: flow.system.rows])))
        fast = np.abs(ahead * turns[: len(ahead), None]) >= FASTEST
        arrived &= (ensemble.status == Status.OK) & ~fast.any(axis=0)
        ended = np.where(ensemble.status == Status.OK, Status.NONFINITE, ensemble.status)
        _filled(found, live, parts, arrived, ended)
        around = np.rint((found.points[live, -1] - z.T) * turns)
        found.points[live, -1] -= around * np.where(turns > 0, 1 / np.where(turns > 0, turns, 1.0), 0.0)
    return found


def vector_field(system: System, z: np.ndarray) -> np.ndarray:
    """Return dz/dt (orbits, 2n) of Hamilton's equations at z (2n, orbits)."""
    return system.slopes(z).T


def energy_gradient(system: System, z: np.ndarray) -> np.ndarray:
    """Return grad H (orbits, 2n): Hamilton's equations turned by a right angle; 0 for systems without energy."""
    n = system.n
    field = vector_field(system, z)
    if not system.canonical:
        return np.zeros(field.shape)
    return np.concatenate([-field[:, n:], field[:, :n]], axis=1)


def section_gradient(section: Any, z: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return the gradient (orbits, 2n) of the section function: complex steps, or differences where the function is not
    analytic.

    scale (2n, orbits): the orbits' own units, which differences are small beside.
    """
    exact = np.zeros(z.shape[::-1])
    difference = np.zeros(z.shape[::-1])
    with np.errstate(all="ignore"):
        for r in range(len(z)):
            h = 6e-6 * scale[r]
            difference[:, r] = (_value(section, z, r, h) - _value(section, z, r, -h)) / (2 * h)
            try:
                exact[:, r] = np.imag(_value(section, z, r, COMPLEX_STEP * 1j)) / COMPLEX_STEP
            except (TypeError, ValueError):
                exact[:, r] = np.nan
        off = np.abs(exact - difference) * scale.T
        size = np.abs(difference) * scale.T
        return np.where(off <= 1e-4 * size.max(axis=1)[:, None], exact, difference)


def _value(section: Any, z: np.ndarray, row: int, shift: Any) -> np.ndarray:
    """Return the section function at z with one row shifted, one number for each orbit."""
    rows = [z[r] + shift if r == row else z[r] for r in range(len(z))]
    return section.value(*rows) + np.zeros(z.shape[1])


def onto(
    system: System, section: Any, z: np.ndarray, energy: np.ndarray, scale: Scale
) -> tuple[np.ndarray, np.ndarray]:
    """Move z (2n, orbits) the shortest way, in the orbits' units, to the section and the energy (orbits,); return it
    and a mask of those that arrived.
    """
    if section is None:  # of a map
        return z.copy(), np.isfinite(z).all(axis=0)
    zero = np.zeros(z.shape[1])
    D = scale.rows
    z = z.copy()
    with np.errstate(all="ignore"):
        for _ in range(20):
            rows = np.stack([section_gradient(section, z, D), energy_gradient(system, z)], axis=1)
            short = np.stack([section.value(*z) + zero, system.energies(z) - energy], axis=1)
            # Sizes for the rounding of both, from z and from the sums.
            size = (np.abs(rows) * (np.abs(z) + D).T[:, None]).sum(axis=2)
            size[:, 1] += scale.energy + system.kinetic_energies(z) + np.abs(system.potential_energies(z))
            near = (np.abs(short) <= 4e-15 * size).all(axis=1)
            rows = rows * D.T[:, None]
            length = np.linalg.norm(rows, axis=2)
            length = np.where(length > 0, length, 1.0)
            change = D * least_change(rows / length[:, :, None], short / length).T
            z = np.where(near, z, z - change)
            if (near | ~np.isfinite(z).all(axis=0)).all():
                break
        arrived = np.isfinite(z).all(axis=0) & (np.abs(short) <= 1e-13 * size).all(axis=1)
    return np.where(arrived, z, np.nan), arrived


def least_change(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the shortest x (k, columns) with the least |matrix x - right| of matrix (k, rows, columns); NaN where not
    finite.
    """
    x = np.full((len(matrix), matrix.shape[2]), np.nan)
    good = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    if good.any():
        x[good] = (inverses(matrix[good]) @ right[good, :, None])[..., 0]
    return x


def inverses(matrix: np.ndarray) -> np.ndarray:
    """Return the pseudoinverses (k, columns, rows) of matrices (k, rows, columns), without directions lost in rounding;
    NaN where one is not finite.
    """
    inverse = np.full(matrix.swapaxes(1, 2).shape, np.nan)
    good = np.isfinite(matrix).all(axis=(1, 2))
    if good.any():
        with np.errstate(over="ignore"):
            size = np.maximum(np.linalg.norm(matrix[good], axis=(1, 2)) / STRETCHED, 1.0)
            cut = np.maximum(RANK / size**2, SHARPEST)
        inverse[good] = np.linalg.pinv(matrix[good], rcond=cut)
    return inverse


def reduced_monodromy(system: System, section: Any, z: np.ndarray, monodromy: np.ndarray, scale: Scale) -> np.ndarray:
    """Return the derivative (orbits, 2n - 2, 2n - 2) of the section map within the energy surface at fixed points z
    (2n, orbits); of dz/dt = f(z) of d variables (orbits, d - 1, d - 1), within the section.

    In a basis of the plane of both that is orthonormal in the orbits' own units; the flow takes each image back to the
    section.
    """
    D = scale.rows.T
    d = system.rows
    if section is None:  # of a map
        return scale.matrix(monodromy)[:, :d, :d]
    flows = not system.canonical
    kept = d - 1 if flows else d - 2
    with np.errstate(all="ignore"):
        field = vector_field(system, z) / D
        up = energy_gradient(system, z) * D
        along = section_gradient(section, z, scale.rows) * D
        own = scale.matrix(monodromy)
    reduced = np.full((len(monodromy), kept, kept), np.nan)
    with np.errstate(all="ignore"):  # a surface has no normal where its gradient vanishes, as at an equilibrium
        surfaces = [row[:, :d] / np.linalg.norm(row, axis=1)[:, None] for row in ((along,) if flows else (along, up))]
    normals = np.stack(surfaces, axis=1)
    good = np.isfinite(own).all(axis=(1, 2)) & np.isfinite(normals).all(axis=(1, 2))
    if good.any():
        _, _, rows = np.linalg.svd(normals[good], full_matrices=True)
        basis = rows[:, -kept:]
        M = own[good, :d, :d]
        f = field[good, :d]
        s = along[good, :d]
        with np.errstate(all="ignore"):  # at an equilibrium on the section
            delay = (s[:, None] @ M) / (s * f).sum(axis=1)[:, None, None]
            reduced[good] = basis @ (M - f[:, :, None] * delay) @ basis.transpose(0, 2, 1)
    return reduced


def each(function: Callable, stack: np.ndarray, shape: tuple[int, ...], dtype: type) -> np.ndarray:
    """Return function(matrix) of each matrix of a stack, NaN where it is not finite."""
    result: np.ndarray = np.full((len(stack), *shape), np.nan, dtype)
    for k in np.flatnonzero(np.isfinite(stack).all(axis=(1, 2))):
        result[k] = function(stack[k])
    return result


def closing_matrix(
    system: System, section: Any, z: np.ndarray, end: np.ndarray, monodromy: np.ndarray, scale: Scale
) -> np.ndarray:
    """Return the derivative (orbits, 2n + 2, 2n + 1) of (flow(z) - z, section, energy) to z and the time; end (orbits,
    2n).

    In the orbits' own units, the rows of section and energy of length 1.
    """
    orbits, rows = end.shape
    D = scale.rows.T
    matrix = np.zeros((orbits, rows + 2, rows + 1))
    with np.errstate(all="ignore"):
        matrix[:, :rows, :rows] = scale.matrix(monodromy) - np.eye(rows)
        if section is None:  # of a map, which has neither time nor energy
            return matrix
        matrix[:, :rows, rows] = vector_field(system, end.T) / D / scale.rate[:, None]
        for row, gradient in enumerate((section_gradient(section, z, scale.rows), energy_gradient(system, z))):
            length = np.linalg.norm(gradient * D, axis=1)[:, None]
            matrix[:, rows + row, :rows] = gradient * D / np.where(length > 0, length, 1.0)
    return matrix


def way_rounding(z: np.ndarray, steps: np.ndarray, scale: Scale) -> np.ndarray:
    """Return the rounding errors of phase points z (2n, orbits) after so many steps, in own units: a random walk."""
    return scale.rounding(z) * np.fmax(2.0, WALK * np.sqrt(steps))


def closing_goal(tolerance: float, z: np.ndarray, steps: np.ndarray, monodromy: np.ndarray, scale: Scale) -> np.ndarray:
    """Return the largest distance from z (2n, orbits) of a closed orbit after so many steps, in own units."""
    size = np.linalg.norm(scale.matrix(monodromy), axis=(1, 2))
    return np.maximum(tolerance, 2 * way_rounding(z, steps, scale)) * np.maximum(1.0, size)


def step_goal(tolerance: float, z: np.ndarray, steps: np.ndarray, monodromy: np.ndarray, scale: Scale) -> np.ndarray:
    """Return the largest change of a return to z (2n, orbits) by a shorter step: the tolerance, or rounding that has
    grown on the way.
    """
    size = np.linalg.norm(scale.matrix(monodromy), axis=(1, 2))
    return np.maximum(tolerance, 2 * way_rounding(z, steps, scale) * size)


def finer_by(change: np.ndarray, goal: np.ndarray, order: int) -> np.ndarray:
    """Return the factor by which a step should be shorter if its error `change` is above the goal."""
    with np.errstate(all="ignore"):
        factor = np.clip(1.1 * (change / goal) ** (1 / order), 1.2, FINER)
    return np.where(np.isfinite(factor), factor, 2.0)


def stability_indices(S: np.ndarray) -> np.ndarray:
    """Return lambda + 1/lambda of the pairs of eigenvalues of a symplectic matrix: roots of its characteristic
    polynomial in that sum.

    The polynomial is a palindrome, so with lambda^k + 1/lambda^k = 2 T_k((lambda + 1/lambda)/2) it is a Chebyshev
    series, of its first half: sums of products of large multipliers; the small ones have no digits beside these.
    """
    m = len(S) // 2
    c = np.poly(S)[: m + 1][::-1]
    return 2 * np.polynomial.chebyshev.chebroots(np.append(c[0], 2 * c[1:])).astype(np.complex128)
