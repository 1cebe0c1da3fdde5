"""Periodic orbits as a result: points, monodromy, multipliers, residues, stability."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Any

import numpy as np

from ..core.status import Status, describe
from ..results.result import Result, along
from ..runs.coordinates import chart_row
from ..runs.flow import Flow
from ..runs.schemes.catalogue import Scheme
from ..systems.models.contracts import Section
from ..systems.models.mechanics import System
from .own_units import Scale
from .return_map import Returns, each, reduced_monodromy, stability_indices

SAME = 1e-6
"""Distance, in an orbit's own units, below which two section points are one."""

EDGE = 1e-9
"""Part of a period below which an angle at its edge is at the upper one."""

MARGINAL = 1e-6
"""Distance of a residue from 0 or 1, beside the size of the monodromy matrix, below which an orbit is parabolic."""


class Stability(IntEnum):
    """Kind of a periodic orbit, by the pair of multipliers farthest from the unit circle.

    R is the residue of this pair. The multipliers of ODE systems, and of maps that are not symplectic, have no pairs.

    Attributes
    ----------
    ELLIPTIC : 0
        The pair is on the unit circle, 0 < R < 1.
    PARABOLIC : 1
        The pair is at 1 or -1, R = 0 or 1. Without pairs, a multiplier is on the unit circle.
    HYPERBOLIC : 2
        The pair is positive, R < 0.
    INVERSE_HYPERBOLIC : 3
        The pair is negative, with reflection, R > 1.
    COMPLEX : 4
        Four multipliers are off the circle together, for three degrees of freedom or more.
    UNKNOWN : 5
        The orbit did not converge.
    ATTRACTING : 6
        Without pairs: all multipliers are within the unit circle.
    SADDLE : 7
        Without pairs: some multipliers are within the unit circle, some beyond.
    REPELLING : 8
        Without pairs: all multipliers are beyond the unit circle.
    """

    ELLIPTIC = 0
    PARABOLIC = 1
    HYPERBOLIC = 2
    INVERSE_HYPERBOLIC = 3
    COMPLEX = 4
    UNKNOWN = 5
    ATTRACTING = 6
    SADDLE = 7
    REPELLING = 8


@dataclass(frozen=True)
class PeriodicOrbits(Result):
    """Periodic orbits of a section map or of a map.

    If an orbit is not OK, its points, period and matrices are NaN. Own units are the amplitudes of the motion in
    `scale`.

    Attributes
    ----------
    z : ndarray, shape (2n, orbits)
        Point of each orbit on the section. ODE systems of d variables have d rows.
    crossings : ndarray of int, shape (orbits,)
        Number of crossings in a period.
    points : ndarray, shape (2n, crossings, orbits)
        All crossings, the first of them `z`; NaN after the last one of an orbit.
    period : ndarray, shape (orbits,)
        Period in units of time; for a map in iterates.
    energy : ndarray, shape (orbits,)
        Energy; 0 for ODE systems.
    monodromy : ndarray, shape (2n, 2n, orbits)
        Derivative of the flow over the period at `z`.
    reduced_monodromy : ndarray, shape (2n - 2, 2n - 2, orbits)
        Derivative of the section map within the energy surface, in a basis that is orthonormal in own units. For ODE
        systems the shape is (d - 1, d - 1, orbits), for maps of d variables (d, d, orbits).
    residual : ndarray, shape (orbits,)
        Distance ``|flow(z) - z|`` in own units.
    error : ndarray, shape (orbits,)
        Error estimate of `z` and of 2 pi period/(a natural period), in own units, from a smaller step (or a larger
        `rtol`) and a neighbour.
    reduced_monodromy_error : ndarray, shape (orbits,)
        Error estimate of `reduced_monodromy`; see `multiplier_errors`.
    iterations : ndarray of int, shape (orbits,)
        Number of returns that were computed.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit.
    step : ndarray, shape (orbits,)
        Step size, in units of time; inf for an adaptive method.
    scale : ndarray, shape (2n, orbits)
        Own units of the rows.
    names : tuple of str, length 2n
        Names of the rows.
    section : Section or None
        Surface of section; None for a map.
    scheme : Scheme
        Integration method.
    symplectic : bool
        False for ODE systems and for maps that are not symplectic. Their multipliers have no pairs, so indices and
        residues are NaN.
    """

    z: Annotated[np.ndarray, along("coordinate", "orbit", labels="names", plain=True)]
    crossings: Annotated[np.ndarray, along("orbit", unit="crossings")]
    points: Annotated[np.ndarray, along("coordinate", "crossing", "orbit", labels="names", padded="crossing")]
    period: Annotated[np.ndarray, along("orbit", unit="time")]
    energy: Annotated[np.ndarray, along("orbit", unit="energy")]
    monodromy: Annotated[np.ndarray, along("coordinate", "start coordinate", "orbit", labels="names")]
    reduced_monodromy: Annotated[np.ndarray, along("direction", "start direction", "orbit")]
    residual: Annotated[np.ndarray, along("orbit")]
    error: Annotated[np.ndarray, along("orbit")]
    reduced_monodromy_error: Annotated[np.ndarray, along("orbit")]
    iterations: Annotated[np.ndarray, along("orbit")]
    status: Annotated[np.ndarray, along("orbit")]
    step: Annotated[np.ndarray, along("orbit", unit="time")]
    scale: Annotated[np.ndarray, along("coordinate", "orbit", labels="names")]
    names: tuple[str, ...]
    section: Any
    scheme: Scheme
    symplectic: bool = True

    @property
    def multipliers(self) -> np.ndarray:
        """Multipliers: eigenvalues of the reduced monodromy matrix, shape (2n - 2, orbits).

        The two multipliers 1 of the flow and the energy are left out, for ODE systems the one of the flow.
        """
        matrices = np.moveaxis(self.reduced_monodromy, -1, 0)
        return each(np.linalg.eigvals, matrices, matrices.shape[2:], np.complex128).T

    @property
    def multiplier_errors(self) -> np.ndarray:
        """Error estimates of `multipliers`, shape (2n - 2, orbits).

        They are the condition of a multiplier times `reduced_monodromy_error`, or for close multipliers the largest
        effect of such a change of the matrix. In a pair of 1e6 and 1e-6 the small one is lost if the matrix is known to
        1e-6; it is the inverse of the other.

        References
        ----------
        Elsner 1985, Linear Algebra Appl. 71, 77 (the bound).
        """
        matrices = np.moveaxis(self.reduced_monodromy, -1, 0)
        off = self.reduced_monodromy_error
        m = matrices.shape[1]
        condition = each(_conditions, matrices, (m,), np.float64)
        with np.errstate(all="ignore"):
            whole = 2 * np.linalg.norm(matrices, axis=(1, 2)) + off
            return np.fmin(condition * off[:, None], (whole ** (1 - 1 / m) * off ** (1 / m))[:, None]).T

    @property
    def residue_errors(self) -> np.ndarray:
        """Error estimates of `residues`, shape (n - 1, orbits): of the trace for n = 2, else of the multipliers."""
        if not self.symplectic or len(self.reduced_monodromy) == 2:
            error = np.sqrt(2) / 4 * self.reduced_monodromy_error + (0.0 if self.symplectic else np.nan)
            return np.broadcast_to(error, self.indices.shape).copy()
        values = self.multipliers
        off = self.multiplier_errors
        with np.errstate(all="ignore"):
            away = np.abs((values + 1 / values)[:, None] - self.indices)
            nearest = np.where(np.abs(values)[:, None] >= 1 - MARGINAL, away, np.inf).argmin(axis=0)
            own, error = (np.take_along_axis(rows, nearest, axis=0) for rows in (values, off))
            return (np.abs(1 - own**-2.0) * error + error**2) / 4

    @property
    def indices(self) -> np.ndarray:
        """Stability indices, shape (n - 1, orbits): sums m + 1/m of the pairs of multipliers, the trace for n = 2."""
        matrices = np.moveaxis(self.reduced_monodromy, -1, 0)
        if not self.symplectic:
            return np.full((max(1, len(self.reduced_monodromy) // 2), len(matrices)), np.nan + 0j)
        return each(stability_indices, matrices, (len(self.reduced_monodromy) // 2,), np.complex128).T

    @property
    def residues(self) -> np.ndarray:
        """Greene's residue of each pair, (2 - index)/4, complex, shape (n - 1, orbits)."""
        return (2 - self.indices) / 4

    @property
    def residue(self) -> np.ndarray:
        """Greene's residue of the pair farthest from the unit circle (its real part), shape (orbits,)."""
        return np.take_along_axis(self.residues, self._worst[None], axis=0)[0].real

    @property
    def stability(self) -> np.ndarray:
        """Kinds of the orbits, codes of `Stability`, shape (orbits,)."""
        if not self.symplectic:
            return self._without_pairs
        R = np.take_along_axis(self.residues, self._worst[None], axis=0)[0]
        with np.errstate(all="ignore"):
            near = MARGINAL * np.maximum(1.0, np.linalg.norm(self.reduced_monodromy, axis=(0, 1)))
            kind = np.where((R.real < 0), Stability.HYPERBOLIC, Stability.ELLIPTIC)
            kind = np.where(R.real > 1, Stability.INVERSE_HYPERBOLIC, kind)
            kind = np.where(np.abs(R.imag) > near, Stability.COMPLEX, kind)
            kind = np.where(np.minimum(np.abs(R), np.abs(R - 1)) <= near, Stability.PARABOLIC, kind)
        return np.where(np.isfinite(R), kind, Stability.UNKNOWN)

    @property
    def _without_pairs(self) -> np.ndarray:
        """The kinds (orbits,) by the sizes of all multipliers."""
        size = np.abs(self.multipliers)
        with np.errstate(all="ignore"):
            kind = np.where((size < 1).any(axis=0), Stability.SADDLE, Stability.REPELLING)
            kind = np.where((size < 1).all(axis=0), Stability.ATTRACTING, kind)
            kind = np.where((np.abs(size - 1) <= MARGINAL).any(axis=0), Stability.PARABOLIC, kind)
        return np.where(np.isfinite(size).all(axis=0), kind, Stability.UNKNOWN)

    @property
    def _worst(self) -> np.ndarray:
        """Number of the pair whose index is farthest from the stable interval [-2, 2]."""
        k = self.indices
        away = np.maximum(np.abs(k.real) - 2, 0.0) + np.abs(k.imag)
        return np.argmax(np.where(np.isnan(away), -1.0, away), axis=0)

    @property
    def minimal_crossings(self) -> np.ndarray:
        """Crossings in the minimal period, a divisor of `crossings`, shape (orbits,); 0 for orbits that are not OK."""
        back = np.linalg.norm((self.points - self.z[:, None]) / self.scale[:, None], axis=0) <= SAME
        back = np.concatenate([back[1:], np.zeros((1, len(self)), bool)])
        first = np.where(back.any(axis=0), back.argmax(axis=0) + 1, self.crossings)
        return np.where(self.status == Status.OK, np.minimum(first, self.crossings), 0)

    def same(self) -> np.ndarray:
        """Number the orbits so that equal closed orbits have one number, for any crossing as their first.

        Returns
        -------
        ndarray of int, shape (orbits,)
            Numbers from 0; -1 for orbits that are not OK.
        """
        number = np.full(self.status.shape, -1)
        good = self.status == Status.OK
        # Fewest crossings first, so that a number stands for an orbit over its minimal period where there is one.
        for o in np.lexsort((np.arange(good.size), self.crossings)):
            if good[o] and number[o] < 0:
                away = (self.z[:, None] - self.points[:, : self.crossings[o], o, None]) / self.scale[:, o, None, None]
                number[(np.linalg.norm(away, axis=0).min(axis=0) <= SAME) & good & (number < 0)] = o
        return np.unique(number, return_inverse=True)[1] - (not good.all())

    def unique(self) -> PeriodicOrbits:
        """Return each OK orbit once, with the fewest crossings found.

        Returns
        -------
        `PeriodicOrbits`
            Orbits in the order of crossings and energy.
        """
        number = self.same()
        order = np.lexsort((self.residual, self.crossings))
        kept = [next(o for o in order if number[o] == k) for k in range(number.max(initial=-1) + 1)]
        chosen = self.take(np.array(kept, np.int64))
        return chosen.take(np.lexsort((chosen.residue, chosen.energy, chosen.crossings)))

    def _row(self, name: str) -> np.ndarray | None:
        return chart_row(self.z, name)

    def summary(self) -> str:
        """Return one line with the outcomes of guesses, the kinds of the orbits, and the number of inaccurate ones.

        Returns
        -------
        str
            Summary.
        """
        good = self.status == Status.OK
        kinds = {entry.name.lower().replace("_", " "): self.stability == entry for entry in Stability}
        said = describe(self.status, kinds)
        if self.status.size == 1 and good.all():
            energy = f", energy {self.energy.item():.6g}" if np.isfinite(self.energy).all() else ""
            said += f"; period {self.period.item():.6g}{energy}"
        vague = int((self.error[good] > SAME).sum())
        return f"{said}; {vague} have relative errors above {SAME:g}" if vague else said


def _conditions(matrix: np.ndarray) -> np.ndarray:
    """Return the condition numbers of a matrix's eigenvalues: the ratios of their changes to that of the matrix."""
    _, right = np.linalg.eig(matrix)
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return np.full(len(matrix), np.inf)
    return np.linalg.norm(left, axis=1) * np.linalg.norm(right, axis=0)


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
    reduced_monodromy_error: np.ndarray,
    iterations: np.ndarray,
) -> PeriodicOrbits:
    """Return PeriodicOrbits of points z (2n, orbits) and their returns; orbits that are not OK are NaN."""
    model = flow.model
    system = flow.system
    good = found.status == Status.OK
    reduced = reduced_monodromy(system, section, z, found.monodromy, scale)
    # The orbit starts at z, which is its last crossing.
    points = np.concatenate([z.T[:, None], found.points[:, :-1]], axis=1)
    if system.iterated:
        points = within_a_period(model, points)
        z = points[:, 0].T.copy()
    d = system.rows  # without an idle row
    z = z[:d]
    points = points[:, :, :d]
    period = found.time.copy()
    error = error.copy()
    monodromy = found.monodromy[:, :d, :d].copy()
    reduced_monodromy_error = reduced_monodromy_error.copy()
    for array in (points, period, monodromy, reduced, error, reduced_monodromy_error):
        array[~good] = np.nan
    return PeriodicOrbits(
        z=z,
        crossings=np.full(good.size, points.shape[1]),
        points=points.transpose(2, 1, 0),
        period=period,
        energy=energy,
        monodromy=np.moveaxis(monodromy, 0, -1),
        reduced_monodromy=np.moveaxis(reduced, 0, -1),
        residual=residual,
        error=error,
        reduced_monodromy_error=reduced_monodromy_error,
        iterations=iterations,
        status=found.status,
        step=np.array(np.broadcast_to(flow.step, good.shape)),
        scale=scale.rows[:d],
        names=system.row_names,
        section=section,
        scheme=flow.scheme,
        symplectic=system.symplectic,
    )


def within_a_period(model: Any, points: np.ndarray) -> np.ndarray:
    """Return points (..., 2n) of a map with periodic rows in (-period/2, period/2], to rounding."""
    points = points.copy()
    for row, period in enumerate(model.periods()):
        if period > 0:
            turns = points[..., row] / period
            points[..., row] -= period * np.ceil(turns - 0.5 - EDGE)
    return points


def no_orbits(system: System, section: Any, scheme: Any) -> PeriodicOrbits:
    """Return PeriodicOrbits of none, the result of a search that was stopped at once."""
    rows = system.rows
    symplectic = system.symplectic
    z = np.zeros((rows, 0))
    matrices = np.zeros((rows, rows, 0))
    reduced = matrices if section is None else matrices[2:, 2:] if symplectic else matrices[1:, 1:]
    return PeriodicOrbits(
        z=z,
        points=np.zeros((rows, 0, 0)),
        monodromy=matrices,
        reduced_monodromy=reduced,
        scale=z,
        names=system.row_names,
        section=section,
        scheme=scheme,
        symplectic=symplectic,
        **dict.fromkeys(("period", "energy", "residual", "error", "reduced_monodromy_error", "step"), np.zeros(0)),
        **dict.fromkeys(("crossings", "iterations", "status"), np.zeros(0, np.int64)),
    )
