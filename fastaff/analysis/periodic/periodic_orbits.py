"""Periodic orbits of section maps: Newton's method with the tangent map, stability, residues."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Annotated, Any

import numpy as np

from ...base.axes import along
from ...base.interruption import keeping
from ...base.numbers import fits, positive, whole
from ...base.recipe import recorded
from ...base.results import Result
from ...base.short_forms import starts_of, takes
from ...base.status import Status, describe
from ...flows.coordinates import chart_row, row_names
from ...flows.flow import Flow
from ...flows.options import Options
from ...formulas.section_text import section_of
from ...models.contracts import Kind, Map, Model, Section, driven, kind_of
from ...schemes.catalogue import RungeKutta, Splitting, scheme_of
from .return_map import (
    FINER,
    Returns,
    Scale,
    checked_guesses,
    checked_return,
    closing_goal,
    closing_matrix,
    each,
    finer_by,
    least_change,
    onto,
    orbit_scale,
    reduced_monodromy,
    scheme_error,
    section_gradient,
    section_returns,
    stability_indices,
    step_goal,
    vector_field,
)

FINEST, ROUNDS = 200.0, 4
"""How many times shorter a step becomes in all, and how often Newton's method goes on with shorter ones."""

WAIT = 20 * 2 * np.pi
"""Radians of an orbit's motion to wait for a crossing."""

SAME = 1e-6
"""Distance, in an orbit's own units, below which two section points are one."""

EDGE = 1e-9
"""Part of a period below which an angle at its edge is at the upper one."""

MARGINAL = 1e-6
"""Distance of a residue from 0 or 1, beside the size of the monodromy matrix, below which an orbit is parabolic."""


class Stability(IntEnum):
    """Kinds of periodic orbits, by the pair of multipliers farthest from the unit circle.

    ELLIPTIC: on it, 0 < R < 1; PARABOLIC: at 1 or -1, R = 0 or 1; HYPERBOLIC: positive, R < 0; INVERSE_HYPERBOLIC:
    negative, with reflection, R > 1; COMPLEX: four together off the circle (three degrees of freedom and more);
    UNKNOWN: not converged.
    """

    ELLIPTIC = 0
    PARABOLIC = 1
    HYPERBOLIC = 2
    INVERSE_HYPERBOLIC = 3
    COMPLEX = 4
    UNKNOWN = 5


@dataclass(frozen=True)
class PeriodicOrbits(Result):
    """Periodic orbits of a section map; where one is not OK, points, time and matrices are NaN.

    z (2n, orbits) on the section; period (orbits,) in crossings; points (2n, longest period, orbits): all crossings, z
    first, NaN past the period; time (orbits,): the period in time; energy (orbits,); monodromy (2n, 2n, orbits): the
    derivative of the flow over the period at z; reduced (2n - 2, 2n - 2, orbits): that of the section map within the
    energy surface, in a basis orthonormal in own units; residual (orbits,) = |flow(z) - z| in own units; error
    (orbits,): estimate of that of z and of 2 pi time/(a turn), in own units, from a shorter step (or a larger rtol) and
    the residual; iterations (orbits,): returns computed; status (orbits,) of `Status`; step (orbits,), inf for an
    adaptive scheme; scale (2n, orbits): own units. names (2n,): of the rows.
    """

    z: Annotated[np.ndarray, along("coordinate", "orbit", labels="names", plain=True)]
    period: Annotated[np.ndarray, along("orbit", unit="crossings")]
    points: Annotated[np.ndarray, along("coordinate", "crossing", "orbit", labels="names", padded="crossing")]
    time: Annotated[np.ndarray, along("orbit", unit="time")]
    energy: Annotated[np.ndarray, along("orbit", unit="energy")]
    monodromy: Annotated[np.ndarray, along("coordinate", "start coordinate", "orbit", labels="names")]
    reduced: Annotated[np.ndarray, along("direction", "start direction", "orbit")]
    residual: Annotated[np.ndarray, along("orbit")]
    error: Annotated[np.ndarray, along("orbit")]
    iterations: Annotated[np.ndarray, along("orbit")]
    status: Annotated[np.ndarray, along("orbit")]
    step: Annotated[np.ndarray, along("orbit", unit="time")]
    scale: Annotated[np.ndarray, along("coordinate", "orbit", labels="names")]
    names: tuple[str, ...]
    section: Any
    scheme: Splitting | RungeKutta

    @property
    def multipliers(self) -> np.ndarray:
        """The eigenvalues (2n - 2, orbits) of the reduced monodromy: without the two 1 of the flow and the energy."""
        matrices = np.moveaxis(self.reduced, -1, 0)
        return each(np.linalg.eigvals, matrices, matrices.shape[2:], np.complex128).T

    @property
    def indices(self) -> np.ndarray:
        """The stability indices (n - 1, orbits): the sums lambda + 1/lambda of the pairs of multipliers, the trace for
        n = 2.
        """
        matrices = np.moveaxis(self.reduced, -1, 0)
        return each(stability_indices, matrices, (len(self.reduced) // 2,), np.complex128).T

    @property
    def residues(self) -> np.ndarray:
        """Greene's residue of each pair, (2 - index)/4, complex (n - 1, orbits)."""
        return (2 - self.indices) / 4

    @property
    def residue(self) -> np.ndarray:
        """Greene's residue (orbits,) for n = 2; for more, that of the pair farthest from the unit circle (its real
        part).
        """
        return np.take_along_axis(self.residues, self._worst[None], axis=0)[0].real

    @property
    def stability(self) -> np.ndarray:
        """The kinds (orbits,), codes of `Stability`."""
        R = np.take_along_axis(self.residues, self._worst[None], axis=0)[0]
        with np.errstate(all="ignore"):
            near = MARGINAL * np.maximum(1.0, np.linalg.norm(self.reduced, axis=(0, 1)))
            kind = np.where((R.real < 0), Stability.HYPERBOLIC, Stability.ELLIPTIC)
            kind = np.where(R.real > 1, Stability.INVERSE_HYPERBOLIC, kind)
            kind = np.where(np.abs(R.imag) > near, Stability.COMPLEX, kind)
            kind = np.where(np.minimum(np.abs(R), np.abs(R - 1)) <= near, Stability.PARABOLIC, kind)
        return np.where(np.isfinite(R), kind, Stability.UNKNOWN)

    @property
    def _worst(self) -> np.ndarray:
        """Which pair's index is farthest from the stable interval [-2, 2]."""
        k = self.indices
        away = np.maximum(np.abs(k.real) - 2, 0.0) + np.abs(k.imag)
        return np.argmax(np.where(np.isnan(away), -1.0, away), axis=0)

    @property
    def prime(self) -> np.ndarray:
        """The least periods (orbits,): the first crossing that is back at z; a divisor of `period`, 0 where not OK."""
        back = np.linalg.norm((self.points - self.z[:, None]) / self.scale[:, None], axis=0) <= SAME
        back = np.concatenate([back[1:], np.zeros((1, len(self)), bool)])
        first = np.where(back.any(axis=0), back.argmax(axis=0) + 1, self.period)
        return np.where(self.status == Status.OK, np.minimum(first, self.period), 0)

    def same(self) -> np.ndarray:
        """Number the orbits (orbits,) so that the same closed orbits, whatever crossing they start at, have one number;
        -1: not OK.
        """
        number, good = np.full(self.status.shape, -1), self.status == Status.OK
        # Least periods first, so that a number stands for a prime orbit where there is one.
        for o in np.lexsort((np.arange(good.size), self.period)):
            if good[o] and number[o] < 0:
                away = (self.z[:, None] - self.points[:, : self.period[o], o, None]) / self.scale[:, o, None, None]
                number[(np.linalg.norm(away, axis=0).min(axis=0) <= SAME) & good & (number < 0)] = o
        return np.unique(number, return_inverse=True)[1] - (not good.all())

    def unique(self) -> PeriodicOrbits:
        """Return one of each orbit that is OK, of the least period found, in the order of period and energy."""
        number = self.same()
        order = np.lexsort((self.residual, self.period))
        kept = [next(o for o in order if number[o] == k) for k in range(number.max(initial=-1) + 1)]
        chosen = self.take(np.array(kept, np.int64))
        return chosen.take(np.lexsort((chosen.residue, chosen.energy, chosen.period)))

    def _row(self, name: str) -> np.ndarray | None:
        return chart_row(self.z, name)

    def summary(self) -> str:
        """Say in one line what became of the guesses, and of which kind the orbits are."""
        kinds, counts = np.unique(self.stability[self.status == Status.OK], return_counts=True)
        return describe(self.status, ", ".join(f"{c} {Stability(k).name}" for k, c in zip(kinds, counts, strict=True)))


@takes(z0=starts_of, section=section_of, scheme=scheme_of)
@recorded
def periodic_orbits(
    model: Model | Map,
    z0: Any,
    *,
    section: Section | None = None,
    period: int = 1,
    energy: Any = None,
    max_time: float | None = None,
    tolerance: float = 1e-12,
    iterations: int = 40,
    step: float | np.ndarray | None = None,
    scheme: Splitting | RungeKutta | None = None,
    rtol: float = 1e-13,
    atol: float = 1e-13,
    threads: int | None = None,
) -> PeriodicOrbits:
    """Find periodic orbits of a section map, or of a map, from guesses, by Newton's method with the tangent map.

    Parameters: model with `tangent_force`, of two degrees of freedom or more; z0 (2n,) or (2n, orbits), guesses,
    which are first moved to the section and the energy, and along the flow where they pass the section the wrong
    way; section: a value of `fastaff.models.sections`, of a map None; period >= 1: the number of crossings after
    which the orbit closes; energy: a number, or one for each orbit (None: that of each guess); max_time: for the
    `period` crossings (None: 20 turns of each guess's own frequency for each); tolerance: an orbit is OK once
    |flow(z) - z| <= tolerance |M| in own units, what a change of z by `tolerance` does (but not less than rounding
    of z); iterations: most returns computed for an orbit with one step; step: as in `integrate`; None: for each
    orbit its own, shortened until that moves the return no more than the tolerance; scheme, rtol, atol, threads as
    in `integrate`. Returns PeriodicOrbits. Raises ValueError or TypeError for wrong input; Interrupted on Ctrl-C,
    with `.partial`. A guess that leads nowhere has the status NOT_CONVERGED, one that never comes back
    TOO_FEW_CROSSINGS.

    An orbit's own units are the amplitudes that its motion has by its kinetic energy and frequency (`Motion`): results
    are the same in any units, for any origin and zero of V, and in any company. All guesses take their steps together:
    one integration with 2n tangent vectors to the crossing, located on the scheme's own flow, then a small
    least-squares system for each orbit: (M - 1) dz + f dT = z - flow(z) within the tangent plane of section and energy,
    by singular values, those below 1e-8 of the largest left out, so that orbits of a resonant torus are found too. A
    step that makes the residual larger is cut to a quarter. Convergence is quadratic, to rounding. `period` may be a
    multiple of the least one: see `.prime`. A relative periodic orbit of a body is a periodic orbit of
    `fastaff.reduced`.
    Cost: about 8 to 12 returns of 2n + 1 vectors for each guess.
    Source: Baranger, Davies & Mahoney 1988, Ann. Phys. 186, 95 (the monodromy method); Greene 1979, J. Math. Phys. 20,
    1183 (residue); Howard & MacKay 1987, J. Math. Phys. 28, 1036 (stability indices).
    """
    scheme = checked_return(model, section, scheme)
    period, iterations = whole("period", period, 1), whole("iterations", iterations, 1)
    tolerance = positive("tolerance", tolerance)
    options = Options(scheme, step, None, rtol, atol, threads=threads)
    flow, z, energy = checked_guesses(model, z0, energy, options)
    end = None if max_time is None else positive("max_time", max_time)
    if end is not None and driven(model):
        raise ValueError(f"max_time must be left out of a driven system, got {max_time!r}")
    fits("period", *z.shape, period)
    search = _Search(
        flow, section, period, end, tolerance, iterations, step is None and not (flow.adaptive or flow.exact)
    )
    state = search.start(z, energy)
    with keeping("periodic_orbits", lambda: search.partial(state)):
        search.run(state)
        for _ in range(ROUNDS):
            if not search.shorten(state).any():
                break
            search.run(state)
    return search.result(state)


@dataclass
class _State:
    """A search under way: arrays over orbits. `z` is the best point so far, `trial` the next; `settled`: whether no
    shorter step will be tried.
    """

    z: np.ndarray
    trial: np.ndarray
    energy: np.ndarray
    scale: Scale
    step: np.ndarray
    limit: np.ndarray
    change: np.ndarray
    share: np.ndarray
    residual: np.ndarray
    error: np.ndarray
    iterations: np.ndarray
    status: np.ndarray
    live: np.ndarray
    settled: np.ndarray
    found: Returns


@dataclass(frozen=True)
class _Search:
    """Newton's method for all guesses at once; `flexible`: their steps may be shortened."""

    flow: Flow
    section: Any
    period: int
    max_time: float | None
    tolerance: float
    iterations: int
    flexible: bool

    def start(self, z: np.ndarray, energy: np.ndarray) -> _State:
        """Move guesses to the section and the energy; those that can't get there have ended."""
        model, (rows, orbits) = self.flow.model, z.shape
        scale = orbit_scale(model, z, energy, self.flow.threads)
        limit = WAIT * self.period / scale.rate if self.max_time is None else np.full(orbits, self.max_time)
        step = np.array(np.broadcast_to(self.flow.step, orbits))
        trial, reached = onto(model, self.section, z, energy, scale)
        wrong = np.zeros(0, np.int64)
        if self.section is not None:
            with np.errstate(all="ignore"):
                rate = (section_gradient(self.section, trial, scale.rows) * vector_field(model, trial)).sum(axis=1)
            wrong = np.flatnonzero(reached & (rate * self.section.direction < 0))
        if wrong.size:  # it passes the section the other way: its first crossing is the guess
            first = (
                section_returns(self._flow(step[wrong]), self.section, trial[:, wrong], 1, limit[wrong]).points[:, 0].T
            )
            trial[:, wrong], reached[wrong] = onto(model, self.section, first, energy[wrong], scale.of(wrong))
        empty = (
            np.full((orbits, self.period, rows), np.nan),
            np.full(orbits, np.nan),
            np.full((orbits, rows, rows), np.nan),
        )
        status = np.full(orbits, int(Status.NOT_CONVERGED))
        return _State(
            trial.copy(),
            trial,
            energy,
            scale,
            step,
            limit,
            np.zeros_like(z),
            np.ones(orbits),
            np.full(orbits, np.inf),
            np.full(orbits, np.nan),
            np.zeros(orbits, np.int64),
            status,
            reached,
            np.zeros(orbits, bool),
            Returns(*empty, status.copy()),
        )

    def _flow(self, step: np.ndarray) -> Flow:
        return self.flow if self.flow.adaptive else replace(self.flow, step=step)

    def run(self, state: _State) -> None:
        """Take Newton steps until every orbit has ended."""
        for _ in range(self.iterations):
            live = np.flatnonzero(state.live)
            if not live.size:
                return
            trial = state.trial[:, live]
            back = section_returns(self._flow(state.step[live]), self.section, trial, self.period, state.limit[live])
            state.iterations[live] += 1
            size = state.scale.of(live).norm(back.points[:, -1] - trial.T)
            size = np.where(back.status == Status.OK, size, np.inf)
            before = state.residual[live]
            better = size < before
            hopeless = ~np.isfinite(size) & ~np.isfinite(before)
            state.status[live[hopeless]] = back.status[hopeless]
            kept = live[better]
            state.z[:, kept], state.residual[kept] = trial[:, better], size[better]
            for all_orbits, some in zip(state.found, back, strict=True):
                all_orbits[kept] = some[better]
            state.share[live] = np.where(better, 1.0, 0.25 * state.share[live])
            closed = state.residual[live] <= self._goal(state, live)
            # One step more as long as steps gain a digit: quadratic convergence makes the last the best.
            finished = closed & ~(size < 0.1 * before)
            state.status[live[closed]] = Status.OK
            state.live[live[finished | hopeless | (state.share[live] < 1e-4)]] = False
            self._step(state, kept[state.live[kept]])
            next_ones = np.flatnonzero(state.live)
            moved = state.z[:, next_ones] + state.share[next_ones] * state.change[:, next_ones]
            energy, scale = state.energy[next_ones], state.scale.of(next_ones)
            state.trial[:, next_ones] = onto(self.flow.model, self.section, moved, energy, scale)[0]

    def shorten(self, state: _State) -> np.ndarray:
        """Estimate the errors of orbits; give those whose step is too long a shorter one and let them go on. Returns
        which (orbits,).
        """
        again = np.zeros(state.status.shape, bool)
        which = np.flatnonzero(np.isfinite(state.residual) & ~np.isfinite(state.error) & ~state.settled)
        if which.size:
            order, scale = self.flow.scheme.order, state.scale.of(which)
            z, found = state.z[:, which], Returns(*(entry[which] for entry in state.found))
            flow = self._flow(state.step[which])
            change, state.error[which] = scheme_error(flow, self.section, z, state.limit[which], found, scale)
            goal = step_goal(self.tolerance, z, found.monodromy, scale)
            # An orbit that does not close may not for the error of the step.
            goal = np.where(state.status[which] == Status.OK, goal, np.maximum(goal, 0.01 * state.residual[which]))
            again[which] = change > goal
            factor = finer_by(change, goal, order)
            state.step[which] = np.where(change > goal, state.step[which] / factor, state.step[which])
        fell = np.isin(state.status, (Status.NONFINITE, Status.COLLAPSED)) & ~np.isfinite(state.residual)
        fell &= ~state.settled
        state.step[fell] /= FINER
        again |= fell
        again &= self.flexible & (state.step * FINEST >= np.broadcast_to(self.flow.step, again.shape))
        state.status[again], state.live[again], state.share[again] = Status.NOT_CONVERGED, True, 1.0
        state.residual[again], state.error[again] = np.inf, np.nan
        state.trial[:, again] = state.z[:, again]
        state.settled[:] = ~again
        return again

    def _goal(self, state: _State, which: np.ndarray) -> np.ndarray:
        return closing_goal(self.tolerance, state.z[:, which], state.found.monodromy[which], state.scale.of(which))

    def _step(self, state: _State, which: np.ndarray) -> None:
        """Set the Newton steps of orbits whose point is new."""
        if which.size:
            z, end, scale = state.z[:, which], state.found.points[which, -1], state.scale.of(which)
            matrix = closing_matrix(self.flow.model, self.section, z, end, state.found.monodromy[which], scale)
            right = np.concatenate([(z.T - end) / scale.rows.T, np.zeros((which.size, 2))], axis=1)
            state.change[:, which] = scale.rows * least_change(matrix, right)[:, :-1].T

    def partial(self, state: _State) -> PeriodicOrbits:
        """Assemble what there is after Ctrl-C."""
        state.status[~state.settled] = Status.INTERRUPTED
        return self.result(state)

    def result(self, state: _State) -> PeriodicOrbits:
        """Assemble the orbits; those that failed keep their best point and lose the rest."""
        return packed(
            self._flow(state.step),
            self.section,
            state.z,
            state.energy,
            state.found,
            state.scale,
            residual=state.residual,
            error=state.error,
            iterations=state.iterations,
            status=state.status,
        )


def packed(
    flow: Flow,
    section: Section | None,
    z: np.ndarray,
    energy: np.ndarray,
    found: Returns,
    scale: Scale,
    *,
    residual: np.ndarray,
    error: np.ndarray,
    iterations: np.ndarray,
    status: np.ndarray | None = None,
) -> PeriodicOrbits:
    """Return PeriodicOrbits of points z (2n, orbits) and their returns; what is not OK is NaN."""
    model, status = flow.model, found.status if status is None else status
    good = status == Status.OK
    reduced = reduced_monodromy(model, section, z, found.monodromy, scale)
    # The orbit starts at z, which is its last crossing.
    points = np.concatenate([z.T[:, None], found.points[:, :-1]], axis=1)
    if kind_of(model) is Kind.MAP:
        points = within_a_period(model, points)
        z = points[:, 0].T.copy()
    time, monodromy, error = found.time.copy(), found.monodromy.copy(), error.copy()
    for array in (points, time, monodromy, reduced, error):
        array[~good] = np.nan
    return PeriodicOrbits(
        z,
        np.full(good.size, points.shape[1]),
        points.transpose(2, 1, 0),
        time,
        energy,
        np.moveaxis(monodromy, 0, -1),
        np.moveaxis(reduced, 0, -1),
        residual,
        error,
        iterations,
        status,
        np.array(np.broadcast_to(flow.step, good.shape)),
        scale.rows,
        row_names(model),
        section,
        flow.scheme,
    )


def within_a_period(model: Any, points: np.ndarray) -> np.ndarray:
    """Return points (..., 2n) of a map with what has a period in (-period/2, period/2], to rounding."""
    points = points.copy()
    for row, period in enumerate(model.periods()):
        if period > 0:
            turns = points[..., row] / period
            points[..., row] -= period * np.ceil(turns - 0.5 - EDGE)
    return points


def no_orbits(model: Any, section: Any, scheme: Any) -> PeriodicOrbits:
    """Return PeriodicOrbits of none: what a search that was stopped at once has found."""
    rows, none, whole = 2 * model.degrees_of_freedom, np.zeros(0), np.zeros(0, np.int64)
    z, matrices = np.zeros((rows, 0)), np.zeros((rows, rows, 0))
    reduced = matrices if section is None else matrices[2:, 2:]
    state = z, whole, np.zeros((rows, 0, 0)), none, none, matrices, reduced, none, none, whole, whole, none, z
    return PeriodicOrbits(*state, row_names(model), section, scheme)
