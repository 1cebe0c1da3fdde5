"""Periodic orbits of section maps: Newton's method with the tangent map, stability, residues."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import fits, positive, whole
from ..core.status import Status
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.progress import tell
from ..runs.flow import Flow
from ..runs.options import Options
from ..runs.requirements import check_given, current_system
from ..runs.schemes.catalogue import Scheme, scheme_of
from ..runs.starts import starts_of
from ..systems.formulas.section_text import section_of
from ..systems.models.contracts import Dynamics, Section
from .closing_errors import closing_errors
from .found_orbits import PeriodicOrbits, packed
from .own_units import Scale, closed_scale, orbit_scale
from .return_map import (
    FINER,
    Returns,
    checked_guesses,
    checked_return,
    closing_goal,
    closing_matrix,
    finer_by,
    least_change,
    onto,
    section_gradient,
    section_returns,
    step_goal,
    vector_field,
)

FINEST = 200.0
"""Largest factor by which a step becomes shorter in all."""

ROUNDS = 4
"""Number of rounds with shorter steps."""

SHRINKS = 3
"""Number of times that the units of an orbit that has closed may become smaller: those of its guess were too large, so
that it had not closed. A linear map has no size, its fixed point at the origin would never be reached.
"""

LEAPS = 3
"""Number of whole steps that a stuck search takes."""

LEAP = 1.0
"""Largest length of such a step, in the orbit's own units."""

RESTS = 1e-6
"""Speed, in own units and radians, below which an orbit of dz/dt = f(z) rests."""

WAIT = 20 * 2 * np.pi
"""Radians of an orbit's motion to wait for a crossing."""

LONGER = 8
"""Factor of WAIT if there is no crossing: the motion near the start may be much faster than later."""


@coerces_arguments(z0=starts_of, section=section_of, scheme=scheme_of)
@records_call
@inserts_parameters
def periodic_orbits(
    model: Dynamics,
    z0: Starts,
    *,
    section: Section | str | None = None,
    crossings: int = 1,
    energy: ArrayLike | None = None,
    max_time: float | None = None,
    tolerance: float = 1e-12,
    iterations: int = 40,
    step: float | np.ndarray | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-13,
    atol: float = 1e-13,
    threads: int | None = None,
) -> PeriodicOrbits:
    r"""Find periodic orbits from guesses by Newton's method.

    Parameters
    ----------
    {closing_model}
    z0 : array_like, shape (2n,) or (2n, orbits)
        Guesses. They are first moved to the section and the energy, and along the flow if they cross the section in the
        wrong direction.
    {section}
    crossings : int, default 1
        Number of crossings (for a map of iterates) after which an orbit closes. It may be a multiple of
        ``minimal_crossings``.
    energy : float or array_like, shape (orbits,), optional
        Energy of the orbits. Default: that of each guess. Not available for maps, driven and ODE systems.
    max_time : float, optional
        Longest time of these crossings. Default: 20 periods of the natural motion for each, then 160 if these are too
        short.
    {closing_tolerance}
    iterations : int, default 40
        Largest number of returns that are computed for a guess with one step size.
    step : float or array_like, shape (orbits,), optional
        Fixed step size, in units of time. Default: chosen for each orbit, and shortened until it changes the return by
        the tolerance or less.
    {closing_scheme}
    {closing_rtol}
    {closing_atol}
    {threads}

    Returns
    -------
    `PeriodicOrbits`
        One orbit for each guess. The status is NOT_CONVERGED if a guess leads to no orbit, TOO_FEW_CROSSINGS if it
        never returns.

    Raises
    ------
    ValueError
        If a value is out of its range, or the model has no periodic orbits of this kind.
    TypeError
        If an argument is of a wrong kind, or the model has no derivatives of its forces.
    Interrupted
        On Ctrl-C, with the orbits so far in ``.partial``.

    Notes
    -----
    - Method: least-squares Newton steps :math:`(M - 1)\,dz + f\,dT = z - \Phi_T(z)` within section and energy surface,
      with the monodromy matrix M. Orbits of resonant tori are found too. Steps that increase the residual are damped by
      a factor of 4. If damping fails, up to three bounded full steps are tried.
    - Accuracy: quadratic convergence, to round-off. Scales are amplitudes of the motion, so results do not depend on
      units.
    - ODE systems: limit cycles, including unstable ones; equilibria are not found. A driven system with friction is an
      ODE system with two more variables.
    - Bodies: relative periodic orbits are periodic orbits of `reduced_body`.
    - Cost: 8 to 12 returns with 2n vectors for a guess.

    References
    ----------
    Baranger, Davies & Mahoney 1988, Ann. Phys. 186, 95 (the monodromy method); Greene 1979, J. Math. Phys. 20, 1183
    (residue); Howard & MacKay 1987, J. Math. Phys. 28, 1036 (stability indices).

    Examples
    --------
    >>> orbit = fa.periodic_orbits(fa.models.StandardMap(0.9), [3.0, 0.1])
    >>> orbit.z[:, 0].round(9) + 0.0, orbit.residue.round(6)
    (array([3.14159265, 0.        ]), array([0.225]))
    """
    system = current_system(model)
    scheme = checked_return(system, section, scheme)
    crossings = whole("crossings", crossings, 1)
    iterations = whole("iterations", iterations, 1)
    tolerance = positive("tolerance", tolerance)
    options = Options(scheme=scheme, step=step, rtol=rtol, atol=atol, threads=threads)
    flow, z, energy = checked_guesses(system, z0, energy, options)
    surface = section if section is None else flow.section(section)
    end = None if max_time is None else positive("max_time", max_time)
    check_given(system, "a time of return", max_time=max_time)
    fits("crossings", *z.shape, crossings)
    flexible = step is None and flow.fixed
    search = _NewtonSearch(flow, surface, section, crossings, end, tolerance, iterations, flexible)
    state = search.start(z, energy)
    with partial_result_on_interrupt("periodic_orbits", lambda: search.partial(state)):
        search.run(state)
        for left in reversed(range(ROUNDS + 1)):
            if not search.shorten(state, last=not left).any():
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
    reduced_monodromy_error: np.ndarray
    iterations: np.ndarray
    status: np.ndarray
    live: np.ndarray
    settled: np.ndarray
    found: Returns
    leaps: np.ndarray
    shrinks: np.ndarray


@dataclass(frozen=True)
class _NewtonSearch:
    """Newton's method for all guesses at once; `flexible`: their steps may be shortened."""

    flow: Flow
    section: Any
    asked: Any
    crossings: int
    max_time: float | None
    tolerance: float
    iterations: int
    flexible: bool

    def start(self, z: np.ndarray, energy: np.ndarray) -> _State:
        """Move guesses to the section and the energy; those that can't get there have ended."""
        system = self.flow.system
        (rows, orbits) = z.shape
        scale = orbit_scale(system, z, energy, self.flow.threads)
        limit = WAIT * self.crossings / scale.rate if self.max_time is None else np.full(orbits, self.max_time)
        step = np.array(np.broadcast_to(self.flow.step, orbits))
        trial, reached = onto(system, self.section, z, energy, scale)
        wrong = np.zeros(0, np.int64)
        if self.section is not None:
            with np.errstate(all="ignore"):
                rate = (section_gradient(self.section, trial, scale.rows) * vector_field(system, trial)).sum(axis=1)
            wrong = np.flatnonzero(reached & (rate * self.section.direction < 0))
        if wrong.size:  # it passes the section the other way: its first crossing is the guess
            first = (
                section_returns(self._flow(step[wrong]), self.section, trial[:, wrong], 1, limit[wrong]).points[:, 0].T
            )
            trial[:, wrong], reached[wrong] = onto(system, self.section, first, energy[wrong], scale.of(wrong))
        empty = (
            np.full((orbits, self.crossings, rows), np.nan),
            np.full(orbits, np.nan),
            np.full((orbits, rows, rows), np.nan),
        )
        status = np.full(orbits, int(Status.NOT_CONVERGED))
        return _State(
            z=trial.copy(),
            trial=trial,
            energy=energy,
            scale=scale,
            step=step,
            limit=limit,
            change=np.zeros_like(z),
            share=np.ones(orbits),
            residual=np.full(orbits, np.inf),
            error=np.full(orbits, np.nan),
            reduced_monodromy_error=np.full(orbits, np.nan),
            iterations=np.zeros(orbits, np.int64),
            status=status,
            live=reached,
            settled=np.zeros(orbits, bool),
            found=Returns(*empty, status.copy()),
            leaps=np.zeros(orbits, np.int64),
            shrinks=np.zeros(orbits, np.int64),
        )

    def _flow(self, step: np.ndarray) -> Flow:
        return self.flow if self.flow.adaptive else replace(self.flow, step=step)

    def run(self, state: _State) -> None:
        """Take Newton steps until every orbit has ended."""
        for _ in range(self.iterations):
            live = np.flatnonzero(state.live)
            if not live.size:
                return
            tell("periodic_orbits", 1 - live.size / state.live.size)
            trial = state.trial[:, live]
            back = self._returned(state, live)
            state.iterations[live] += 1
            size = state.scale.of(live).norm(back.points[:, -1] - trial.T)
            size = np.where(back.status == Status.OK, size, np.inf)
            before = state.residual[live]
            better = size < before
            hopeless = ~np.isfinite(size) & ~np.isfinite(before)
            state.status[live[hopeless]] = back.status[hopeless]
            kept = live[better]
            state.z[:, kept] = trial[:, better]
            state.residual[kept] = size[better]
            for all_orbits, some in zip(state.found, back, strict=True):
                all_orbits[kept] = some[better]
            state.share[live] = np.where(better, 1.0, 0.25 * np.minimum(state.share[live], 1.0))
            closed = (state.residual[live] <= self._goal(state, live)) & ~self._rests(state, live)
            # One more step as long as steps gain a digit: with quadratic convergence the last is the best.
            finished = closed & ~(size < 0.1 * before)
            shrunk = np.zeros(live.size, bool)
            shrunk[closed] = self._shrink(state, live[closed])
            closed = closed & ~shrunk
            finished = finished & ~shrunk
            state.status[live] = np.where(closed, Status.OK, state.status[live])
            stuck = (state.share[live] < 1e-4) & ~finished & ~hopeless
            leaps = live[stuck & (state.leaps[live] < LEAPS) & np.isfinite(before)]
            state.live[live[finished | hopeless | stuck]] = False
            state.live[leaps] = True
            moving = np.union1d(kept, live[shrunk])
            self._step(state, moving[state.live[moving]])
            self._leap(state, leaps)
            next_ones = np.flatnonzero(state.live)
            moved = state.z[:, next_ones] + state.share[next_ones] * state.change[:, next_ones]
            energy = state.energy[next_ones]
            scale = state.scale.of(next_ones)
            state.trial[:, next_ones] = onto(self.flow.system, self.section, moved, energy, scale)[0]
        state.live[:] = False  # later changes of others give no orbit more iterations

    def _returned(self, state: _State, live: np.ndarray) -> Returns:
        """Return the returns of the trials of the live ones; the first time late ones get more time, unless that is
        given.
        """

        def run(which: np.ndarray) -> Returns:
            flow = self._flow(state.step[which])
            return section_returns(flow, self.section, state.trial[:, which], self.crossings, state.limit[which])

        back = run(live)
        late = (back.status == Status.TOO_FEW_CROSSINGS) & (state.iterations[live] == 0) & (self.max_time is None)
        if late.any():
            state.limit[live[late]] *= LONGER
            for all_orbits, some in zip(back, run(live[late]), strict=True):
                all_orbits[late] = some
        return back

    def shorten(self, state: _State, *, last: bool) -> np.ndarray:
        """Estimate the errors of orbits; unless it is the last time, give those with too long a step a shorter one and
        let them go on. Returns a mask of these (orbits,).
        """
        again = np.zeros(state.status.shape, bool)
        which = np.flatnonzero(np.isfinite(state.residual) & ~np.isfinite(state.error) & ~state.settled)
        if which.size:
            order = self.flow.scheme.order
            scale = state.scale.of(which)
            z = state.z[:, which]
            found = Returns(*(entry[which] for entry in state.found))
            flow = self._flow(state.step[which])
            limit = state.limit[which]
            change, state.error[which], state.reduced_monodromy_error[which], state.found.time[which] = closing_errors(
                flow, self.section, z, limit, found, scale
            )
            goal = step_goal(self.tolerance, z, found.time / flow.step, found.monodromy, scale)
            # The error of the step may keep an orbit from closing.
            goal = np.where(state.status[which] == Status.OK, goal, np.maximum(goal, 0.01 * state.residual[which]))
            again[which] = (change > goal) & (not last)
            factor = finer_by(change, goal, order)
            state.step[which] = np.where(again[which], state.step[which] / factor, state.step[which])
        fell = np.isin(state.status, (Status.NONFINITE, Status.OUT_OF_DOMAIN)) & ~np.isfinite(state.residual)
        fell &= ~state.settled & (not last)
        state.step[fell] /= FINER
        again |= fell
        again &= self.flexible & (state.step * FINEST >= np.broadcast_to(self.flow.step, again.shape))
        state.status[again] = Status.NOT_CONVERGED
        state.live[again] = True
        state.share[again] = 1.0
        state.residual[again] = np.inf
        state.error[again] = np.nan
        state.trial[:, again] = state.z[:, again]
        state.settled[:] = ~again
        return again

    def _goal(self, state: _State, which: np.ndarray) -> np.ndarray:
        found = state.found
        scale = state.scale.of(which)
        steps = found.time[which] / self._flow(state.step[which]).step
        return closing_goal(self.tolerance, state.z[:, which], steps, found.monodromy[which], scale)

    def _rests(self, state: _State, which: np.ndarray) -> np.ndarray:
        """Return a mask (orbits,) of points that are no orbits: those where the flow touches the section, which are
        back at once, and equilibria of dz/dt = f(z), which return after any time.
        """
        if self.section is None:
            return np.zeros(which.size, bool)
        if self.flow.system.canonical:
            return state.found.time[which] * state.scale.rate[which] < RESTS
        scale = state.scale.of(which)
        field = vector_field(self.flow.system, state.z[:, which])
        return scale.norm(field) < RESTS * scale.rate

    def _shrink(self, state: _State, which: np.ndarray) -> np.ndarray:
        """Give orbits that have closed their own units, where those of their guesses were too large. Returns a mask of
        those (orbits,) that go on, as they have not closed in smaller units.
        """
        again = np.zeros(which.size, bool)
        which = np.asarray(which)
        tried = np.flatnonzero(state.shrinks[which] < SHRINKS)
        if not tried.size:
            return again
        some = which[tried]
        found = state.found
        before = state.scale.of(some)
        after = closed_scale(
            self._flow(state.step).of(some), state.z[:, some], found.points[some], found.time[some], before
        )
        smaller = (after.rows < before.rows).any(axis=0)
        again[tried[smaller]] = True
        shrunk = which[again]
        if shrunk.size:
            state.scale.put(shrunk, after.of(smaller))
            state.shrinks[shrunk] += 1
            state.residual[shrunk] = state.scale.of(shrunk).norm(found.points[shrunk, -1] - state.z[:, shrunk].T)
            state.share[shrunk] = 1.0
            state.status[shrunk] = int(Status.NOT_CONVERGED)
        return again

    def _leap(self, state: _State, which: np.ndarray) -> None:
        """Let orbits take the whole Newton step, at most a unit, if no part of it makes the residual smaller: other
        orbits may be found across the fold of the map, where it is singular.
        """
        if which.size:
            with np.errstate(all="ignore"):
                length = state.scale.of(which).norm(state.change[:, which].T)
                state.share[which] = np.where(length > LEAP, LEAP / length, 1.0)
            state.leaps[which] += 1
            state.residual[which] = np.inf

    def _step(self, state: _State, which: np.ndarray) -> None:
        """Set the Newton steps of orbits whose point is new."""
        if which.size:
            z = state.z[:, which]
            end = state.found.points[which, -1]
            scale = state.scale.of(which)
            matrix = closing_matrix(self.flow.system, self.section, z, end, state.found.monodromy[which], scale)
            right = np.concatenate([(z.T - end) / scale.rows.T, np.zeros((which.size, 2))], axis=1)
            state.change[:, which] = scale.rows * least_change(matrix, right)[:, :-1].T

    def partial(self, state: _State) -> PeriodicOrbits:
        """Assemble the result so far after Ctrl-C."""
        state.status[~state.settled] = Status.INTERRUPTED
        return self.result(state)

    def result(self, state: _State) -> PeriodicOrbits:
        """Assemble the orbits; those that failed keep their best point and lose the rest."""
        found = packed(
            self._flow(state.step),
            self.section,
            state.z,
            state.energy,
            state.found._replace(status=state.status),
            state.scale,
            residual=state.residual,
            error=state.error,
            reduced_monodromy_error=state.reduced_monodromy_error,
            iterations=state.iterations,
        )
        return replace(found, section=self.asked)
