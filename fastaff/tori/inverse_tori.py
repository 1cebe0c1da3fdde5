"""Tori of given actions: their energy, and their points at given angles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import numbers, shown
from ..core.status import Status
from ..engine.threads import checked_threads
from ..results.calls import records_call
from ..results.progress import says_progress
from ..results.result import Result, along
from ..runs.requirements import and_others, current_system, phase_points
from ..systems.charts.chart import Chart
from ..systems.models import Zero
from ..systems.models.contracts import SeparableModel
from ..systems.models.mechanics import System
from .action_angles import run_kernel, to_spin
from .closed_oscillators import closed_energy, closed_form, closed_points
from .families import R_VARTHETA_FAMILY
from .kernels import inverse as tori_inverse
from .kernels import quadrature as tori_quadrature
from .kernels.closed import TURN
from .r4_charts import R4Separated
from .r4_inverse import (
    RadialPlaces,
    gathered,
    harmonic_energy,
    harmonic_places,
    line_points,
    momenta_of_actions,
    split_rows,
    subspace_points,
)
from .r4_tori import elements_of, r4_tori, unknown_radial
from .separation import Separated, separate_anywhere

LARGEST_ACTION = 1e150
"""Actions whose squares are numbers."""


@says_progress
@inserts_parameters
def from_action_angles(
    model: SeparableModel,
    J: ArrayLike,
    theta: ArrayLike,
    *,
    chart: Chart | str | None = None,
    guess: ArrayLike | None = None,
    threads: int | None = None,
) -> np.ndarray:
    """Compute the phase points of given actions and angles, the inverse of `action_angles`.

    Parameters
    ----------
    model : Body
        Body with a doubly isotropic potential that separates in (alpha, beta), (r, vartheta) or a chart of R^4.
    J : array_like, shape (4,) or (4, orbits)
        Actions of the two coordinates, at least 0, then J_phi and J_psi. In the charts of R^4, actions of its four
        coordinates; only those of azimuths may be negative.
    theta : array_like, shape (4,) or (4, orbits)
        Angles in cycles. A single column of J or theta is used for all columns of the other.
    {torus_chart}
    {torus_guess}
    {threads}

    Returns
    -------
    ndarray, shape (8,) or (8, orbits)
        Phase points.

    Raises
    ------
    TypeError
        If the model is not a body or an argument has the wrong type.
    ValueError
        If the body does not separate, no torus has these actions, or an argument has a wrong value or shape.
    Interrupted
        On Ctrl-C. Its attribute ``partial`` has the points found so far, and NaN for the others.

    Notes
    -----
    - Method: Newton's method on J finds the separation constants, starting at the minimum of the effective potential.
      Newton's method on theta = dS/dJ finds the phases.
    - J_eta = 0 or J_gamma = 0 is the limit from above.
    - Accuracy: round trips with `action_angles` agree to 1e-11 or better.

    References
    ----------
    Martens & Slawianowski, section 4 (the inverse is derived).

    Examples
    --------
    >>> body = fa.Body(fa.Harmonic())
    >>> z = fa.from_action_angles(body, [0.5, 0.6, 0.3, 0.2], [0.1, 0.2, 0.3, 0.4])
    >>> fa.action_angles(body, z).J.round(9)
    array([[0.5],
           [0.6],
           [0.3],
           [0.2]])
    """
    actions = _rows("J", J)
    angles = _rows("theta", theta)
    single = np.ndim(J) == np.ndim(theta) == 1
    n = max(actions.shape[1], angles.shape[1])
    if {actions.shape[1], angles.shape[1]} - {1, n}:
        raise ValueError(
            f"theta must have as many orbits as J, or one of them 1: got {angles.shape[1]} and {actions.shape[1]}"
        )
    actions = np.ascontiguousarray(np.broadcast_to(actions, (4, n)))
    angles = np.array(np.broadcast_to(angles, (4, n)))
    separated = separate_anywhere(model, chart)
    well = _well(current_system(model), guess, n)
    threads = checked_threads(threads)
    if isinstance(separated, R4Separated):
        with partial_result_on_interrupt("from_action_angles", lambda: np.full((8, n), np.nan)):
            z = _r4_points(separated, actions, np.mod(angles, 1.0), well, threads)
        return z[:, 0] if single else z
    angles[2], angles[3] = angles[2] - angles[3], angles[2] + angles[3]
    if closed_form(separated) is not None:
        z = closed_points(separated, _checked_actions(separated, actions), np.mod(angles, 1.0))
        return z[:, 0] if single else z
    z = np.full((8, n), np.nan)
    with partial_result_on_interrupt("from_action_angles", lambda: z[:, 0] if single else z):
        _refuse_failed(actions, _invert(separated, actions, np.mod(angles, 1.0), z, _unknown(n), well, threads))
    return z[:, 0] if single else z


@dataclass(frozen=True)
class EnergyOfActions(Result):
    """Energy and frequencies of tori as functions of their actions.

    Attributes
    ----------
    names : tuple of str
        Rows of nu.
    energy : ndarray, shape (orbits,)
        Energy E(J), NaN unless the status is ``OK``.
    nu : ndarray, shape (4, orbits)
        Frequencies dE/dJ, in cycles per unit time, NaN unless the status is ``OK``.
    status : ndarray of int, shape (orbits,)
        `Status` of each torus.
    """

    names: tuple[str, ...]
    energy: Annotated[np.ndarray, along("orbit", unit="energy")]
    nu: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names", plain=True)]
    status: Annotated[np.ndarray, along("orbit")]


@records_call
@inserts_parameters
def energy_of_actions(
    model: SeparableModel,
    J: ArrayLike,
    *,
    chart: Chart | str | None = None,
    guess: ArrayLike | None = None,
    threads: int | None = None,
) -> EnergyOfActions:
    """Compute the energy E(J) of tori and its gradient, the frequencies.

    Parameters
    ----------
    model : Body
        Body with a doubly isotropic potential that separates in (alpha, beta), (r, vartheta) or a chart of R^4.
    J : array_like, shape (4,) or (4, orbits)
        Actions of the two coordinates, at least 0, then J_phi and J_psi. In the charts of R^4, actions of its four
        coordinates; only those of azimuths may be negative.
    {torus_chart}
    {torus_guess}
    {threads}

    Returns
    -------
    EnergyOfActions
        Energies and frequencies. If no torus has the actions, the status is ``UNBOUND`` or ``NOT_CONVERGED`` and the
        values are NaN.

    Raises
    ------
    TypeError
        If the model is not a body or an argument has the wrong type.
    ValueError
        If the body does not separate, or an argument has a wrong value or shape.
    Interrupted
        On Ctrl-C. The result so far is in its attribute ``partial``.

    Notes
    -----
    - Method: closed forms for the oscillators (EQ3.21-3.23, EQa and EQb of the paper, corrected), else Newton's method
      on the quadratures of `action_angles`.
    - At J_eta = 0 or J_gamma = 0 the gradient is the limit from above.

    References
    ----------
    Martens & Slawianowski, section 4.

    Examples
    --------
    >>> fa.energy_of_actions(fa.Body(fa.Harmonic()), [0.5, 0.6, 0.3, 0.2]).energy.round(9)
    np.float64(0.397887358)
    """
    actions = _rows("J", J)
    separated = separate_anywhere(model, chart)
    well = _well(current_system(model), guess, actions.shape[1])
    threads = checked_threads(threads)

    def found(nu: np.ndarray, energy: np.ndarray, status: np.ndarray) -> EnergyOfActions:
        if not isinstance(separated, R4Separated):
            to_spin(nu, 0.5)
        which = 0 if np.ndim(J) == 1 else slice(None)
        return EnergyOfActions(names=separated.names, energy=energy[which], nu=nu[:, which], status=status[which])

    if isinstance(separated, R4Separated):
        out = _unknown(actions.shape[1])
        with partial_result_on_interrupt("energy_of_actions", lambda: found(*out)):
            _fill_r4_energy(separated, actions, out, well, threads)
        return found(*out)
    if closed_form(separated) is not None:
        energy, nu = closed_energy(separated, _checked_actions(separated, actions))
        return found(nu, energy, np.zeros(energy.size, np.int64))
    out = _unknown(actions.shape[1])
    with partial_result_on_interrupt("energy_of_actions", lambda: found(*out)):
        _invert(separated, actions, np.empty((4, 0)), np.empty((8, 0)), out, well, threads)
    return found(*out)


def _unknown(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return gradients (4, n), energies and statuses (n,) of actions before they are found."""
    return np.full((4, n), np.nan), np.full(n, np.nan), np.full(n, int(Status.INTERRUPTED))


def _well(system: System, guess: ArrayLike | None, n: int) -> np.ndarray | None:
    """Return phase points (8, 1) or (8, n) in the intended wells."""
    points = None if guess is None else phase_points("guess", guess, system)
    if points is not None and points.shape[1] not in (1, n):
        raise ValueError(f"guess must be one phase point or one for each of {n} orbits, got {points.shape[1]}")
    return points


def _rows(name: str, given: ArrayLike) -> np.ndarray:
    rows = numbers(name, given)
    if rows.ndim not in (1, 2) or rows.shape[0] != 4 or rows.size == 0:
        raise ValueError(f"{name} must have shape (4,) or (4, orbits), got {rows.shape}")
    if not np.isfinite(rows).all():
        raise ValueError(
            f"{name} must be finite; orbit {np.flatnonzero(~np.isfinite(rows.reshape(4, -1)).all(axis=0))[0]} is not"
        )
    return rows.reshape(4, -1)


def _checked_actions(separated: Separated, J: np.ndarray) -> np.ndarray:
    """Return rows J_1, J_2 >= 0, p_eta, p_gamma of actions J_1, J_2, J_phi, J_psi."""
    if not separated.isotropic or not separated.family.invertible:
        raise ValueError(
            "model must be doubly isotropic and chart alpha-beta or r-vartheta, or one of R^4, for the inverse"
        )
    if np.any(J[:2] < 0):
        raise ValueError(f"J of {' and '.join(separated.names[:2])} must not be negative, got {J[:2].min()}")
    if not np.all(np.abs(J) < LARGEST_ACTION):
        raise ValueError(f"J must be below {LARGEST_ACTION:g} in size, got {shown(J)}")
    return np.array([J[0], J[1], (J[2] - J[3]) / (2 * TURN), (J[2] + J[3]) / (2 * TURN)])


def _invert(
    separated: Separated,
    J: np.ndarray,
    theta: np.ndarray,
    z: np.ndarray,
    out: tuple[np.ndarray, np.ndarray, np.ndarray],
    guess: np.ndarray | None,
    threads: int | None,
) -> np.ndarray:
    """Fill z where theta has columns, and `out`: the gradient to J_1, J_2, J_eta, J_gamma, E and statuses, which are
    returned.
    """
    spins = _checked_actions(separated, J)
    spins[2:] *= TURN
    n = J.shape[1]
    start = np.zeros((2, n))
    if guess is not None:
        start[:] = _start(separated, guess)
    wells = np.ones(n, np.int64)
    nu, energy, status = out
    sought = tori_inverse.Sought(spins, theta, start, z, nu, energy, wells, status)
    arguments = separated.family.number, *separated.terms(), separated.mu, separated.radial_mu, sought
    run_kernel(tori_inverse.torus_points, arguments, n, tori_quadrature.UNIT, threads, None)
    several = np.flatnonzero(wells > 1)
    if several.size and guess is None:
        raise ValueError(
            f"guess must be given for orbit {several[0]}, whose effective potential has {wells[several[0]]} wells. "
            "Pass a phase point in one of them."
        )
    return status


def _r4_points(
    separated: R4Separated, J: np.ndarray, theta: np.ndarray, guess: np.ndarray | None, threads: int | None
) -> np.ndarray:
    """Return the phase points (8, n) of actions and angles in a chart of R^4."""
    _check_r4_actions(separated, J)
    parts = []
    rows = split_rows(separated, J), split_rows(separated, theta)
    for space, actions, angles in zip(separated.family.subspaces, *rows, strict=True):
        if space.dimension == 1:
            parts.append(line_points(separated, actions, angles))
            continue
        L = momenta_of_actions(actions)[-1]
        if separated.body.stiffness > 0:
            places = harmonic_places(separated, actions[0], L, angles[0])
        else:
            places = _central_places(separated, J, L, angles[0], guess, threads)
        parts.append(subspace_points(space, actions, angles, places))
    return gathered(separated, parts)


def _as_r_vartheta(separated: R4Separated, J: np.ndarray, L: np.ndarray) -> tuple[Separated, np.ndarray]:
    """Return a central body in (r, vartheta), and the actions there of tori with J_r and L and p_eta = p_gamma = 0."""
    central = Separated(R_VARTHETA_FAMILY, (separated.body.potential, Zero()), (Zero(), Zero()), separated.mu)
    return central, np.array([J[0], TURN / 2 * L, np.zeros_like(L), np.zeros_like(L)])


def _central_places(
    separated: R4Separated,
    J: np.ndarray,
    L: np.ndarray,
    theta: np.ndarray,
    guess: np.ndarray | None,
    threads: int | None,
) -> RadialPlaces:
    """Return the places of the radial motion of a central body, from tori of the same radial motion in (r, vartheta).

    Raises ValueError if there is no torus.
    """
    central, actions = _as_r_vartheta(separated, J, L)
    n = L.size
    z = np.full((8, n), np.nan)
    angles = np.zeros((4, n))
    angles[0] = theta
    _refuse_failed(J, _invert(central, actions, angles, z, _unknown(n), guess, threads))
    radial = unknown_radial(n)
    r4_tori(separated, z, radial, threads, None)
    q, p = elements_of(z)
    return RadialPlaces((q**2).sum(axis=0), (q * p).sum(axis=0), radial.swept)


def _fill_r4_energy(
    separated: R4Separated,
    J: np.ndarray,
    out: tuple[np.ndarray, np.ndarray, np.ndarray],
    guess: np.ndarray | None,
    threads: int | None,
) -> None:
    """Fill gradients, energies and statuses of the tori of actions in a chart of R^4."""
    _check_r4_actions(separated, J)
    nu, energy, status = out
    if separated.body.stiffness > 0:
        energy[:], nu[:] = harmonic_energy(separated, J)
        status[:] = Status.OK
        return
    central, actions = _as_r_vartheta(separated, J, momenta_of_actions(J)[-1])
    _invert(central, actions, np.empty((4, 0)), np.empty((8, 0)), out, guess, threads)
    # J_vartheta = pi L there, and 2 pi L is the sum of J_lambda, J_mu and |J_nu|.
    nu[1:] = nu[1] / 2 * np.where(J[1:] < 0, -1.0, 1.0)


def _check_r4_actions(separated: R4Separated, J: np.ndarray) -> None:
    """Refuse negative actions of coordinates that librate, and those whose squares are no numbers."""
    librating = ~np.array(separated.family.rotating)
    if np.any(J[librating] < 0):
        names = [name for name, kept in zip(separated.names, librating, strict=True) if kept]
        raise ValueError(f"J of {' and '.join(names)} must not be negative, got {J[librating].min()}")
    if not np.all(np.abs(J) < LARGEST_ACTION):
        raise ValueError(f"J must be below {LARGEST_ACTION:g} in size, got {shown(J)}")


def _refuse_failed(J: np.ndarray, status: np.ndarray) -> None:
    failed = np.flatnonzero(status != Status.OK)
    if failed.size:
        k = failed[0]
        raise ValueError(
            f"J must be the actions of a torus, got J = {shown(J[:, k].tolist())} of orbit {k}: "
            f"{Status(int(status[k])).name}{and_others(failed.size)}"
        )


def _start(separated: Separated, z: np.ndarray) -> np.ndarray:
    """Return the ratios s/t (2, orbits) of phase points, in the coordinates of kernels."""
    A = (z[:2] ** 2).sum(axis=0)
    B = (z[2:4] ** 2).sum(axis=0)
    return np.maximum(separated.family.start(A, B), 1e-28)  # type: ignore[union-attr]  # invertible
