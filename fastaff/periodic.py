"""Periodic orbits of section maps: Newton's method with the tangent map, stability, residues (layer L3)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any

import numpy as np

from .auto import Automatic
from .boundary import checked_section, checked_tangent_model, energies
from .engine import Flow, Interrupted
from .motion import typical_rate
from .recipe import recorded
from .returns import (
    Returns,
    each,
    energy_gradient,
    least_change,
    onto,
    reduced_monodromy,
    section_gradient,
    section_returns,
    vector_field,
)
from .scalars import an_array, positive, shown, whole
from .schemes import KAHAN_LI8, RungeKutta, Splitting
from .shown import screen
from .status import Status, describe, raise_if_failed
from .trials import make_flow, with_one_step

ENERGY_ERROR = 1e-13
"""What the step is chosen for where none is given: an orbit cannot close better than its energy is kept."""

SAME = 1e-6
"""Distance, beside 1 + |z|, below which two section points are one."""

MARGINAL = 1e-6
"""Distance of a residue from 0 or 1, beside the size of the monodromy matrix, below which an orbit is parabolic."""


class Stability(IntEnum):
    """Kinds of periodic orbits, by the pair of multipliers farthest from the unit circle.

    ELLIPTIC: on it, 0 < R < 1; PARABOLIC: at 1 or -1, R = 0 or 1; HYPERBOLIC: positive, R < 0; INVERSE_HYPERBOLIC: negative,
    with reflection, R > 1; COMPLEX: four together off the circle (three degrees of freedom and more); UNKNOWN: not converged.
    """

    ELLIPTIC = 0
    PARABOLIC = 1
    HYPERBOLIC = 2
    INVERSE_HYPERBOLIC = 3
    COMPLEX = 4
    UNKNOWN = 5


@dataclass(frozen=True)
class PeriodicOrbits:
    """Periodic orbits of a section map, with orbits on the last axis of z; where one is not OK, points, time and matrices are NaN.

    z (2n, orbits) on the section; period (orbits,) in crossings; points (orbits, longest period, 2n): all crossings, z first,
    NaN past the period; time (orbits,): the period in time; energy (orbits,); monodromy (orbits, 2n, 2n): the derivative of
    the flow over the period at z; reduced (orbits, 2n - 2, 2n - 2): that of the section map within the energy surface, in an
    orthonormal basis; residual (orbits,) = |flow(z) - z|; iterations (orbits,): returns computed; status (orbits,) of `Status`.
    names (2n,): of the rows of z.
    """

    z: np.ndarray
    period: np.ndarray
    points: np.ndarray
    time: np.ndarray
    energy: np.ndarray
    monodromy: np.ndarray
    reduced: np.ndarray
    residual: np.ndarray
    iterations: np.ndarray
    status: np.ndarray
    names: tuple[str, ...]
    section: Any
    scheme: Splitting | RungeKutta
    step: float | np.ndarray

    def __repr__(self) -> str:
        return screen(self)

    @property
    def multipliers(self) -> np.ndarray:
        """The eigenvalues (2n - 2, orbits) of the reduced monodromy: without the two 1 of the flow and the energy."""
        return each(np.linalg.eigvals, self.reduced, self.reduced.shape[2:], np.complex128).T

    @property
    def indices(self) -> np.ndarray:
        """The stability indices (n - 1, orbits): the sums lambda + 1/lambda of the pairs of multipliers, the trace for n = 2."""
        return each(_indices, self.reduced, (self.reduced.shape[2] // 2,), np.complex128).T

    @property
    def residues(self) -> np.ndarray:
        """Greene's residue of each pair, (2 - index)/4, complex (n - 1, orbits)."""
        return (2 - self.indices) / 4

    @property
    def residue(self) -> np.ndarray:
        """Greene's residue (orbits,) for n = 2; for more, that of the pair farthest from the unit circle (its real part)."""
        return np.take_along_axis(self.residues, self._worst[None], axis=0)[0].real

    @property
    def stability(self) -> np.ndarray:
        """The kinds (orbits,), codes of `Stability`."""
        R = np.take_along_axis(self.residues, self._worst[None], axis=0)[0]
        with np.errstate(all="ignore"):
            near = MARGINAL * np.maximum(1.0, np.linalg.norm(self.reduced, axis=(1, 2)))
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
        away = np.linalg.norm(self.points - self.z.T[:, None], axis=2) <= SAME * (1 + np.linalg.norm(self.z.T, axis=1))[:, None]
        away = np.concatenate([away[:, 1:], np.zeros((len(away), 1), bool)], axis=1)
        first = np.where(away.any(axis=1), away.argmax(axis=1) + 1, self.period)
        return np.where(self.status == Status.OK, np.minimum(first, self.period), 0)

    def take(self, which: Any) -> PeriodicOrbits:
        """Return the orbits `which`: numbers or a mask (orbits,)."""
        which = np.atleast_1d(an_array("which", which))
        if not (which.dtype == bool and which.shape == self.status.shape) and not (
            which.dtype.kind in "iu" and which.ndim == 1 and np.all((which >= -self.status.size) & (which < self.status.size))
        ):
            raise ValueError(f"which must be numbers of {self.status.size} orbits or a mask, got {shown(which)}")
        kept = {f.name: getattr(self, f.name) for f in fields(self)}
        for name in ("period", "points", "time", "energy", "monodromy", "reduced", "residual", "iterations", "status"):
            kept[name] = kept[name][which]
        kept["z"] = self.z[:, which]
        return PeriodicOrbits(**kept)

    def same(self) -> np.ndarray:
        """Number the orbits (orbits,) so that the same closed orbits, whatever crossing they start at, have one number; -1: not OK."""
        number, good = np.full(self.status.shape, -1), self.status == Status.OK
        scale = SAME * (1 + np.linalg.norm(self.z, axis=0))
        # Least periods first, so that a number stands for a prime orbit where there is one.
        for o in np.lexsort((np.arange(good.size), self.period)):
            if good[o] and number[o] < 0:
                away = np.linalg.norm(self.z.T[:, None] - self.points[o, : self.period[o]], axis=2).min(axis=1)
                number[(away <= scale) & good & (number < 0)] = o
        return np.unique(number, return_inverse=True)[1] - (not good.all())

    def unique(self) -> PeriodicOrbits:
        """Return one of each orbit that is OK, of the least period found, in the order of period and energy."""
        number = self.same()
        order = np.lexsort((self.residual, self.period))
        kept = [next(o for o in order if number[o] == k) for k in range(number.max(initial=-1) + 1)]
        chosen = self.take(np.array(kept, np.int64))
        return chosen.take(np.lexsort((chosen.residue, chosen.energy, chosen.period)))

    def raise_if_failed(self) -> None:
        """Raise OrbitError unless every orbit is OK."""
        raise_if_failed(self.status)

    def summary(self) -> str:
        """Say in one line what became of the guesses, and of which kind the orbits are."""
        kinds, counts = np.unique(self.stability[self.status == Status.OK], return_counts=True)
        return "; ".join([describe(self.status), *(f"{c} {Stability(k).name}" for k, c in zip(kinds, counts, strict=True))])


@recorded
def periodic_orbits(
    model: Any, z0: Any, *, section: Any, period: int = 1, energy: Any = None, max_time: float | None = None,
    tolerance: float = 1e-12, iterations: int = 40, step: float | np.ndarray | None = None, scheme: Splitting | RungeKutta = KAHAN_LI8,
    rtol: float = 1e-13, atol: float = 1e-13, threads: int | None = None,
) -> PeriodicOrbits:  # fmt: skip
    """Find periodic orbits of a section map from guesses, by Newton's method with the tangent map.

    Parameters: model with `tangent_force`, of two degrees of freedom or more; z0 (2n,) or (2n, orbits), guesses, which are first
    moved to the section and the energy, and along the flow where they pass the section the wrong way; section: a value of
    `fastaff.sections`; period >= 1: the number of crossings after which the orbit closes; energy: a number, or one for each
    orbit (None: that of each guess); max_time: for the `period` crossings (None: 20 turns of the guesses' typical frequency for
    each); tolerance: an orbit is OK once |flow(z) - z| <= tolerance (1 + |z|) |M|, what a change of z by `tolerance` does;
    iterations: most returns computed for an orbit; step: as in `integrate`, chosen for an energy error of 1e-13 where it is
    None; scheme, rtol, atol, threads as in `integrate`.
    Returns PeriodicOrbits. Raises ValueError or TypeError for wrong input; Interrupted on Ctrl-C, with `.partial`. A guess that leads
    nowhere has the status NOT_CONVERGED, one that never comes back TOO_FEW_CROSSINGS.

    All guesses take their steps together: one integration with 2n tangent vectors to the crossing, located on the scheme's own
    flow, then a small least-squares system for each orbit: (M - 1) dz + f dT = z - flow(z) within the tangent plane of section and
    energy, by singular values, those below 1e-8 of the largest left out, so that orbits of a resonant torus are found too. A step that
    makes the residual larger is cut to a quarter. Convergence is quadratic, to rounding. `period` may be a multiple of the least
    one: see `.prime`. A relative periodic orbit of a body is a periodic orbit of `fastaff.models.reduced`.
    Cost: about 6 to 8 returns of 2n + 1 vectors for each guess.
    Source: Baranger, Davies & Mahoney 1988, Ann. Phys. 186, 95 (the monodromy method); Greene 1979, J. Math. Phys. 20, 1183
    (residue); Howard & MacKay 1987, J. Math. Phys. 28, 1036 (stability indices).
    """
    checked_section(section, checked_tangent_model(model, "model"))
    period, iterations = whole("period", period, 1), whole("iterations", iterations, 1)
    tolerance = positive("tolerance", tolerance)
    flow, z, energy = checked_guesses(model, z0, energy, scheme, step, rtol, atol, threads)
    end = return_time(flow, z, period) if max_time is None else positive("max_time", max_time)
    search = _Search(flow, section, period, end, tolerance, iterations)
    state = search.start(z, energy)
    try:
        search.run(state)
    except KeyboardInterrupt:
        state.status[state.live] = Status.INTERRUPTED
        stopped = Interrupted("periodic_orbits")
        stopped.partial = search.result(state)
        raise stopped from None
    return search.result(state)


def checked_guesses(
    model: Any, z0: Any, energy: Any, scheme: Any, step: Any, rtol: Any, atol: Any, threads: Any
) -> tuple[Flow, np.ndarray, np.ndarray]:
    """Check what searches take; return the flow, the guesses (2n, orbits) and their energies (orbits,)."""
    if model.degrees_of_freedom < 2:
        raise ValueError(f"model {type(model).__name__} must have two degrees of freedom or more, it has {model.degrees_of_freedom}")
    unset = step is None and not isinstance(scheme, Automatic)
    flow, z = make_flow(model, z0, scheme, 1.0 if unset else step, rtol, atol, threads)  # the trial for an error of its own follows
    if step is None:
        flow = with_one_step(flow, z, ENERGY_ERROR)
    try:
        given = energies(model, z) if energy is None else np.asarray(energy, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"energy must be a number, or one for each orbit, got {energy!r}") from None
    if given.shape not in ((), (z.shape[1],)) or not np.isfinite(given).all():
        raise ValueError(f"energy must be a finite number, or one for each of {z.shape[1]} orbits, got {energy!r}")
    return flow, z, np.array(np.broadcast_to(given, z.shape[1:]))


def return_time(flow: Flow, z: np.ndarray, period: int) -> float:
    """Return the longest time to wait for `period` crossings: 20 turns of a typical frequency for each."""
    return 20 * 2 * np.pi / typical_rate(flow.model, z) * period


@dataclass
class _State:
    """A search under way: arrays over orbits. `z` is the best point so far, `trial` the next."""

    z: np.ndarray
    trial: np.ndarray
    energy: np.ndarray
    change: np.ndarray
    share: np.ndarray
    residual: np.ndarray
    iterations: np.ndarray
    status: np.ndarray
    live: np.ndarray
    found: Returns


@dataclass(frozen=True)
class _Search:
    """Newton's method for all guesses at once."""

    flow: Flow
    section: Any
    period: int
    max_time: float
    tolerance: float
    iterations: int

    def start(self, z: np.ndarray, energy: np.ndarray) -> _State:
        """Move guesses to the section and the energy; those that can't get there have ended."""
        rows, orbits = z.shape
        trial, reached = onto(self.flow.model, self.section, z, energy)
        with np.errstate(all="ignore"):
            rate = (section_gradient(self.section, trial) * vector_field(self.flow.model, trial)).sum(axis=1)
        wrong = np.flatnonzero(reached & (rate * self.section.direction < 0))
        if wrong.size:  # it passes the section the other way: its first crossing is the guess
            first = section_returns(self.flow, self.section, trial[:, wrong], 1, self.max_time).points[:, 0].T
            trial[:, wrong], reached[wrong] = onto(self.flow.model, self.section, first, energy[wrong])
        empty = np.full((orbits, self.period, rows), np.nan), np.full(orbits, np.nan), np.full((orbits, rows, rows), np.nan)
        status = np.full(orbits, int(Status.NOT_CONVERGED))
        return _State(
            trial.copy(), trial, energy, np.zeros_like(z), np.ones(orbits), np.full(orbits, np.inf), np.zeros(orbits, np.int64),
            status, reached, Returns(*empty, status.copy()),
        )  # fmt: skip

    def run(self, state: _State) -> None:
        """Take Newton steps until every orbit has ended."""
        for _ in range(self.iterations):
            live = np.flatnonzero(state.live)
            if not live.size:
                return
            trial = state.trial[:, live]
            back = section_returns(self.flow, self.section, trial, self.period, self.max_time)
            state.iterations[live] += 1
            size = np.linalg.norm(back.points[:, -1] - trial.T, axis=1)
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
            state.trial[:, next_ones] = onto(self.flow.model, self.section, moved, state.energy[next_ones])[0]

    def _goal(self, state: _State, which: np.ndarray) -> np.ndarray:
        size = 1.0 + np.linalg.norm(state.z[:, which], axis=0)
        return self.tolerance * size * np.maximum(1.0, np.linalg.norm(state.found.monodromy[which], axis=(1, 2)))

    def _step(self, state: _State, which: np.ndarray) -> None:
        """Set the Newton steps of orbits whose point is new."""
        if which.size:
            z, end = state.z[:, which], state.found.points[which, -1]
            matrix = closing_matrix(self.flow.model, self.section, z, end, state.found.monodromy[which])
            right = np.concatenate([z.T - end, np.zeros((which.size, 2))], axis=1)
            state.change[:, which] = least_change(matrix, right)[:, :-1].T

    def result(self, state: _State) -> PeriodicOrbits:
        """Assemble the orbits; those that failed keep their best point and lose the rest."""
        return packed(self.flow, self.section, state.z, state.energy, state.found, state.residual, state.iterations, state.status)


def packed(
    flow: Flow, section: Any, z: np.ndarray, energy: np.ndarray, found: Returns, residual: np.ndarray, iterations: np.ndarray,
    status: np.ndarray | None = None,
) -> PeriodicOrbits:  # fmt: skip
    """Return PeriodicOrbits of points z (2n, orbits) and their returns; what is not OK is NaN."""
    model, status = flow.model, found.status if status is None else status
    good = status == Status.OK
    reduced = reduced_monodromy(model, section, z, found.monodromy)
    # The orbit starts at z, which is its last crossing.
    points = np.concatenate([z.T[:, None], found.points[:, :-1]], axis=1)
    time, monodromy = found.time.copy(), found.monodromy.copy()
    for array in (points, time, monodromy, reduced):
        array[~good] = np.nan
    names = (*model.coordinates, *(f"p_{name}" for name in model.coordinates))
    return PeriodicOrbits(
        z, np.full(good.size, points.shape[1]), points, time, energy, monodromy, reduced, residual, iterations, status, names,
        section, flow.scheme, flow.step,
    )  # fmt: skip


def closing_matrix(model: Any, section: Any, z: np.ndarray, end: np.ndarray, monodromy: np.ndarray) -> np.ndarray:
    """Return the derivative (orbits, 2n + 2, 2n + 1) of (flow(z) - z, section, energy) to z and the time; end (orbits, 2n)."""
    orbits, rows = end.shape
    matrix = np.zeros((orbits, rows + 2, rows + 1))
    matrix[:, :rows, :rows] = monodromy - np.eye(rows)
    matrix[:, :rows, rows] = vector_field(model, end.T)
    matrix[:, rows, :rows], matrix[:, rows + 1, :rows] = section_gradient(section, z), energy_gradient(model, z)
    return matrix


def _indices(S: np.ndarray) -> np.ndarray:
    """Return lambda + 1/lambda of the pairs of eigenvalues of a symplectic matrix: roots of its characteristic polynomial in that sum.

    The polynomial is a palindrome, so with lambda^k + 1/lambda^k = 2 T_k((lambda + 1/lambda)/2) it is a Chebyshev series.
    """
    m = len(S) // 2
    c = np.poly(S)
    series = np.concatenate([[c[m]], (c[:m] + c[:m:-1])[::-1]])
    return 2 * np.polynomial.chebyshev.chebroots(series).astype(np.complex128)
