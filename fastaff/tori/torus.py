"""A torus as a Fourier series: the result of fits, and its residual in equations of motion or a map.

For a map, and for a driven system's map over its period, orbits are sampled once a turn: an iterate, a period.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..core.classification import Classification
from ..core.numbers import numbers, shown, whole
from ..core.status import Status, counted
from ..engine.values import at_points
from ..frequencies.integer_lattice import determinant, inverse
from ..results.result import Result, along
from ..runs.flow import Flow
from ..runs.options import Options, Problem
from ..runs.requirements import current_system
from ..systems.models.mechanics import System
from .series import actions, evaluate

GRID = 512
"""Points of the torus where its equation is tried, and of the orbit where the prediction is."""

STEP_ERROR = 1e-13
"""Error that the steps over a period of a driven system are chosen for."""

CONSTANT = 1e-6
"""Part of its distance from the origin below which the spread of a row is no scale of its errors."""


class Unknown(NamedTuple):
    """The model of given orbits: the names of its coordinates, no equations of motion."""

    coordinates: tuple[str, ...]

    @property
    def degrees_of_freedom(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)


SENTENCES = {
    Classification.REGULAR: "torus",
    Classification.RESONANT: "resonant torus of lower dimension",
    Classification.IRREGULAR: "not a torus",
    Classification.UNDECIDED: "undecided",
}
"""Whether an orbit lies on a torus, in words."""


@dataclass(frozen=True)
class TorusFit(Result, axis=None):
    """Torus of an orbit as a Fourier series z(theta) = Re sum_k z_k exp(2 pi i k·theta).

    The series has one k of each pair +-k. For a map, and for the stroboscopic map of a driven system, time is counted
    in iterates or periods.

    Attributes
    ----------
    names : tuple of str
        Names of the angles.
    nu : ndarray, shape (d,)
        Frequencies in cycles per unit time. For a map, in cycles per iterate from 0 to 1, in the sense of a positive
        action; an angle that rotates keeps its own sense.
    nu_error : ndarray, shape (d,)
        Errors of nu: the change between unequal parts of the window, and with half the step size. inf if there is no
        torus.
    J : ndarray, shape (d,)
        Actions, the integrals of p dq over the cycles. For a map, the positive area within the curve of a libration, or
        the area under the curve of an angle that rotates. For islands, the action of one of them.
    J_error : ndarray, shape (d,)
        Errors of J, as those of nu, and the prediction error. inf if there is no torus.
    theta0 : ndarray, shape (d,)
        Angles of z0 in cycles, so that z(t) = evaluate(theta0 + nu t). At theta = 0 the largest coefficients that form
        a basis are real and positive.
    k : ndarray of int, shape (terms, d)
        Integer vectors of the terms, the largest term first.
    coefficients : ndarray of complex, shape (2n, terms)
        Coefficients z_k.
    residual : float
        Largest ``|nu . dz/dtheta - X(z)|`` over points of the torus, relative to the largest ``|X|``. For a map, the
        largest ``|z(theta + nu) - M(z(theta))|`` relative to the size of the orbit about its middle.
    prediction_error : float
        Largest distance between the orbit and the series after the fitted time, relative to the size of the orbit.
    classification : Classification
        ``REGULAR``, ``RESONANT`` (d < n), ``IRREGULAR`` (no torus) or ``UNDECIDED``.
    dimension : int
        Dimension d of the torus.
    relations : ndarray of int, shape (n' - d, n')
        Integer vectors that annihilate the n' natural frequencies.
    evidence : dict of float
        Numbers behind the classification, by name.
    energy : float
        Energy of z0, NaN for a map.
    model : model
        Model of the orbit, None for `fit_samples`.
    winding : ndarray, shape (2n, d), optional
        Advance of a row in a cycle of an angle, its period or 0. The series adds winding @ theta. None if nothing
        winds.
    islands : int
        Number of pieces of the orbit, which are images of each other. The series then describes times that are
        multiples of it, and nu is below 1/islands.
    """

    names: tuple[str, ...]
    nu: Annotated[np.ndarray, along("angle", unit="cycles/time", labels="names", plain=True)]
    nu_error: Annotated[np.ndarray, along("angle", unit="cycles/time", labels="names")]
    J: Annotated[np.ndarray, along("angle", unit="action", labels="names")]
    J_error: Annotated[np.ndarray, along("angle", unit="action", labels="names")]
    theta0: Annotated[np.ndarray, along("angle", unit="cycles", labels="names")]
    k: Annotated[np.ndarray, along("term", "angle")]
    coefficients: Annotated[np.ndarray, along("coordinate", "term")]
    residual: float
    prediction_error: float
    classification: Classification
    dimension: int
    relations: Annotated[np.ndarray, along("relation", "frequency")]
    evidence: Mapping[str, float]
    energy: float
    model: Any
    winding: Annotated[np.ndarray | None, along("coordinate", "angle")] = None
    islands: int = 1

    @property
    def _system(self) -> System:
        """The body with its traits and mechanics."""
        return current_system(self.model)

    @property
    def I(self) -> np.ndarray:  # noqa: E743
        """Actions J/2 pi, shape (d,)."""
        return self.J / (2 * np.pi)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu, in radians per unit time, shape (d,)."""
        return 2 * np.pi * self.nu

    @property
    def order(self) -> int:
        """Largest sum ``|k_i|`` of the series."""
        return int(np.abs(self.k).sum(axis=1).max(initial=0))

    @property
    def maslov(self) -> np.ndarray:
        """Maslov indices of the cycles of the angles, shape (d,), for a torus of as many dimensions as coordinates.

        The index counts how often a cycle passes a caustic: 2 for a libration, 0 for a rotation, any integer for a
        resonant torus. It is the winding number of det(dq/dtheta - i dp/dtheta)^2 along the cycle. In another basis it
        transforms as J does. The EBK rule is J = 2 pi hbar (n + maslov/4).

        Raises
        ------
        ValueError
            If the torus has fewer dimensions, or is one of a map.

        References
        ----------
        Arnold 1967, Funct. Anal. Appl. 1, 1.
        """
        n = len(self.coefficients) // 2
        of_flow = isinstance(self.model, Unknown) or not turned(self._system)
        if self.dimension != n or not of_flow or not np.isfinite(self.coefficients).all():
            raise ValueError(
                f"maslov must be of a torus of {n} dimensions of a flow, got dimension {self.dimension} "
                f"({SENTENCES[self.classification]})"
            )
        return np.array([self._caustics(i) for i in range(n)])

    def _caustics(self, i: int) -> int:
        """Return the Maslov index of the cycle of one angle."""
        theta = np.zeros((self.dimension, max(GRID, 16 * int(np.abs(self.k[:, i]).max(initial=0)))))
        theta[i] = np.arange(theta.shape[1]) / theta.shape[1]
        q, p = np.split(tangents(self, theta), 2)
        q_size, p_size = (np.abs(rows).max(axis=(1, 2)) for rows in (q, p))  # 0 where a momentum is constant
        size = np.sqrt(np.where(q_size * p_size > 0, q_size / np.where(p_size > 0, p_size, 1.0), 1.0))[:, None, None]
        turns = np.linalg.det(np.moveaxis(q / size - 1j * size * p, 2, 0))
        return round(np.angle(np.roll(turns, -1) / turns).sum() / np.pi)

    def evaluate(self, theta: Any) -> np.ndarray:
        """Return the phase points at given angles.

        Parameters
        ----------
        theta : array_like, shape (d, ...)
            Angles in cycles.

        Returns
        -------
        ndarray, shape (2n, ...)
            Phase points.

        Raises
        ------
        ValueError
            If the shape is wrong.
        """
        theta = numbers("theta", theta)
        if theta.ndim < 1 or len(theta) != self.dimension:
            raise ValueError(f"theta must have shape ({self.dimension}, ...), got {theta.shape}")
        if not np.isfinite(theta).all():
            raise ValueError(f"theta must be finite, got {shown(theta)}")
        flat = theta.reshape(self.dimension, int(np.prod(theta.shape[1:])))
        z = evaluate(self.k, self.coefficients, flat)
        z = z if self.winding is None else z + self.winding @ flat
        return z.reshape(len(self.coefficients), *theta.shape[1:])

    def in_basis(self, M: Any) -> TorusFit:
        """Return the same torus with the angles M theta, so that nu' = M nu and J' = M^-T J.

        Parameters
        ----------
        M : array_like of int, shape (d, d)
            Matrix of determinant +1 or -1.

        Returns
        -------
        TorusFit
            The torus in the new basis.

        Raises
        ------
        ValueError
            If the matrix has another shape, another determinant or entries that are not integers.
        """
        given = numbers("M", M)
        if (
            given.shape != (self.dimension,) * 2
            or not np.all(np.abs(given) < 2**53)
            or (given % 1).any()
            or abs(determinant(given)) != 1
        ):
            raise ValueError(f"M must be an integer matrix {(self.dimension,) * 2} of determinant +-1, got {shown(M)}")
        M = given.astype(int)
        back = inverse(M)
        names = tuple(combination(row, self.names) for row in M)
        known = np.isfinite(self.nu_error).all()
        return replace(
            self,
            names=names,
            nu=M @ self.nu,
            nu_error=np.abs(M) @ self.nu_error if known else self.nu_error,
            J=back.T @ self.J,
            J_error=np.abs(back.T) @ self.J_error if known else self.J_error,
            theta0=M @ self.theta0 % 1.0,
            k=self.k @ back,
            winding=None if self.winding is None else self.winding @ back,
        )

    def truncated(self, order: int) -> TorusFit:
        """Return the torus with the terms of a low order only.

        Parameters
        ----------
        order : int
            Largest sum ``|k_i|`` of the terms, at least 0.

        Returns
        -------
        TorusFit
            The shorter series, with its actions and its residual.

        Raises
        ------
        ValueError
            If the order is negative.
        """
        kept = np.abs(self.k).sum(axis=1) <= whole("order", order, 0)
        k = self.k[kept]
        z = self.coefficients[:, kept]
        left = residual(self._system, k, z, self.nu * self.islands, self.winding, self.islands)
        return replace(self, k=k, coefficients=z, J=area(self._system, k, z, self.winding), residual=left)

    def summary(self) -> str:
        """Return one line with the classification and its numbers.

        Returns
        -------
        str
            The line.
        """
        pairs = ", ".join(f"nu_{name} = {value:.9g}" for name, value in zip(self.names, self.nu))
        text = (
            f"{SENTENCES[self.classification]}{f': {pairs}' if pairs else ''}; prediction error "
            f"{self.prediction_error:.1e}, residual {self.residual:.1e}, {counted(len(self.k), 'term')} in "
            f"{counted(self.dimension, 'dimension')}"
        )
        if self.classification is Classification.UNDECIDED:
            outcome = Status(int(self.evidence["status"]))
            text += (
                f"; a time of {self.evidence['suggested time']:.3g} may decide"
                if "suggested time" in self.evidence
                else f"; {outcome.sentence}"
                if outcome == Status.INTERRUPTED
                else "; the orbit failed"
            )
        return text


def tangents(fit: TorusFit, theta: np.ndarray) -> np.ndarray:
    """Return dz/dtheta (2n, d, points) of a torus at angles theta (d, points) in cycles."""
    rows = [evaluate(fit.k, 2j * np.pi * fit.k[:, i] * fit.coefficients, theta) for i in range(fit.dimension)]
    out = np.array(rows).swapaxes(0, 1)
    return out if fit.winding is None else out + fit.winding[:, :, None]


def classified(system: System, dimension: int) -> Classification:
    """Return the class of a torus of that dimension."""
    return Classification.REGULAR if dimension == system.moving else Classification.RESONANT


def resting(path: np.ndarray) -> bool:
    """Tell whether the orbit is at rest, to rounding."""
    return bool((np.ptp(path, axis=1) <= 1e-12 * np.abs(path).max()).all())


def nothing(system: System, energy: float, evidence: dict, *, gone: bool = False) -> TorusFit:
    """Return the result of an orbit that failed, or is too short: its status."""
    n = system.n
    unknown = np.full(n, np.nan)
    one = np.full((2 * n, 1), np.nan + 0j)
    return TorusFit(
        names=system.names,
        nu=unknown,
        nu_error=np.full(n, np.inf),
        J=unknown,
        J_error=np.full(n, np.inf),
        theta0=unknown,
        k=np.zeros((1, n), int),
        coefficients=one,
        residual=np.inf,
        prediction_error=np.inf,
        classification=Classification.IRREGULAR if gone else Classification.UNDECIDED,
        dimension=n,
        relations=np.zeros((0, n), int),
        evidence=MappingProxyType(evidence),
        energy=energy,
        model=system.model,
    )


def point(
    system: System, path: np.ndarray, energy: float, evidence: dict, *, residual: float, islands: int = 1
) -> TorusFit:
    """Return the torus of dimension 0 of an orbit (2n, samples) that stays where it is; its residual is absolute."""
    none = np.zeros(0)
    moving = path[rows_of(system)]
    return replace(
        nothing(system, energy, evidence),
        classification=Classification.RESONANT,
        names=(),
        nu=none,
        nu_error=none,
        J=none,
        J_error=none,
        theta0=none,
        k=np.zeros((1, 0), int),
        coefficients=path[:, :1] + 0j,
        residual=residual,
        prediction_error=float(np.ptp(moving, axis=1).max() / (np.abs(moving).max() or 1.0)),
        dimension=0,
        relations=np.zeros((0, 0), int),
        islands=islands,
    )


def turned(system: System) -> bool:
    """Tell whether the torus of a model's orbit is one of a map: its own, or that over the period of its drive."""
    return system.iterated or system.driven


def periods_of(system: System) -> np.ndarray:
    """Return the periods (2n,) of the rows, 0 where there is none, or that of a drive."""
    if isinstance(system.model, Unknown):
        return np.zeros(2 * system.n)
    if system.iterated:
        return np.array(system.model.periods(), dtype=np.float64)
    periods = np.zeros(2 * system.n)
    periods[: system.moving] = system.periods[: system.moving]
    return periods


def rows_of(system: System) -> np.ndarray:
    """Return the rows that move from turn to turn: all but the time of a driven system and its momentum."""
    n = system.n
    kept = np.arange(system.moving)
    return np.concatenate([kept, n + kept])


def flow_of_turns(problem: Problem) -> tuple[Flow, np.ndarray, float]:
    """Return a flow of the orbits, their starts, and the time of a turn, which its steps divide."""
    interval = 1.0 if problem.system.iterated else float(problem.model.period)
    flow, z, *_ = problem.plan(error=STEP_ERROR)
    return flow.fitted(interval), z, interval


def image(system: System, z: np.ndarray, count: int) -> np.ndarray:
    """Return the images of phase points z (2n, points) after `count` turns, NaN where they do not get there."""
    result = np.full(z.shape, np.nan)
    live = np.isfinite(z).all(axis=0) & system.inside(z)
    if not live.any():
        return result
    if system.iterated:
        points = z[:, live]
        with np.errstate(all="ignore"):
            for _ in range(count):
                points = np.array(np.broadcast_arrays(*at_points(system.model, "iterate", *points)))
        result[:, live] = points
        return result
    (flow, points, period) = flow_of_turns(Problem(system.model, z[:, live], Options()))
    row = system.moving
    ensemble = flow.ensemble(points.copy())
    states = flow.sampled(ensemble, 1 if flow.adaptive else count, time=count * period)
    after = np.where(ensemble.status == Status.OK, states[:, -1].T, np.nan)
    after[row] = np.where(np.isfinite(after[row]), points[row], np.nan)
    result[:, live] = after
    return result


def spread(d: int) -> np.ndarray:
    """Return GRID evenly spread points (d, GRID) of the torus of d angles (Roberts)."""
    ratio = np.roots([1.0, *[0.0] * (d - 1), -1.0, -1.0]).real.max() if d else 1.0
    return np.arange(GRID) * ratio ** -np.arange(1.0, d + 1)[:, None] % 1.0


def without_periods(away: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Take whole periods (rows,), 0 where a row has none, off differences (rows, points), which are returned."""
    for r in np.flatnonzero(periods > 0):
        away[r] -= periods[r] * np.rint(away[r] / periods[r])
    return away


def distance(system: System, one: np.ndarray, other: np.ndarray) -> float:
    """Return the largest difference of phase points (2n, points), for coordinates and momenta apart; inf where it is
    not finite. It is relative to the size of the others; of turns, whole periods aside, to their extent.
    """
    periods = periods_of(system)
    rows = rows_of(system)
    half = len(rows) // 2
    with np.errstate(all="ignore"):
        away = one - other
        size = np.abs(other).max(axis=1)
        if turned(system):
            away = without_periods(away, periods)
            size = np.maximum(np.ptp(other, axis=1) / 2, CONSTANT * size)
            size = np.where(periods > 0, np.minimum(size, periods / 2), size)
        parts = [np.abs(away[s]).max() / (size[s].max() or 1.0) for s in (rows[:half], rows[half:])]
    return float(max(parts)) if np.isfinite(parts).all() else np.inf


def residual(
    system: System, k: np.ndarray, z: np.ndarray, nu: np.ndarray, winding: np.ndarray | None, islands: int
) -> float:
    """Return the residual of points of the torus in the equations of motion, NaN where none are known: the
    largest |nu . dz/dtheta - X(z)|, or |z(theta + nu) - M(z(theta))| with M that of so many turns; see `distance`.
    """
    if system.model is None or isinstance(system.model, Unknown):
        return float("nan")
    theta = spread(k.shape[1])
    if not turned(system):
        point, slope = np.split(evaluate(k, np.vstack([z, 2j * np.pi * (k @ nu) * z]), theta), 2)
        if winding is not None:
            point = point + winding @ theta
            slope = slope + (winding @ nu)[:, None]
        with np.errstate(all="ignore"):
            return distance(system, slope, system.slopes(point))
    points = evaluate(k, z, theta)
    after = evaluate(k, z, theta + nu[:, None])
    if winding is not None:
        points = points + winding @ theta
        after = after + winding @ (theta + nu[:, None])
    return distance(system, image(system, points, islands), after)


def area(system: System, k: np.ndarray, z: np.ndarray, winding: np.ndarray | None) -> np.ndarray:
    """Return the integrals J (d,) of p dq over the cycles of a torus; NaN where they have no meaning: more than one
    degree of freedom of a map that is not symplectic, a momentum that winds.
    """
    n = len(z) // 2
    J = actions(k, z)
    if n > 1 and system.model is not None and not system.symplectic:
        return np.full(J.shape, np.nan)
    if winding is None:
        return J
    constant = z[n:, ~k.any(axis=1)].real.sum(axis=1)
    return np.where(winding[n:].any(), np.nan, J + winding[:n].T @ constant)


def combination(row: np.ndarray, names: tuple[str, ...]) -> str:
    """Return an integer combination of names, like r-2*gamma."""
    text = "".join(
        f"{'+' if c > 0 else '-'}{'' if abs(c) == 1 else f'{abs(c)}*'}{name}" for c, name in zip(row, names) if c
    )
    return text.removeprefix("+")
