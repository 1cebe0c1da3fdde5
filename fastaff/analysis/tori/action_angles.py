"""Action-angle tori of separable bodies: from states to actions, frequencies and angles, and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.axes import along
from ...base.interruption import keeping
from ...base.numbers import numbers, shown
from ...base.recipe import recorded
from ...base.results import Result
from ...base.short_forms import Starts, starts_of, takes
from ...base.status import Status
from ...charts.chart import Chart
from ...compile.threads import checked_threads
from ...flows.checks import phase_points
from ...flows.flow import Report, launch, units
from ...kernels import tori_closed, tori_inverse, tori_quadrature
from ...kernels.tori_closed import Tori
from ...models import Barriers, Oscillator, Spring, Zero
from ...models.contracts import Model
from .closed_oscillators import closed_energy, closed_points
from .separation import Separated, separate

TURN = 2 * np.pi
LARGEST_ACTION = 1e150
"""Actions whose squares are numbers."""


@dataclass(frozen=True)
class ActionAngles(Result):
    """Action-angle description of states of a separable body; arrays over orbits last, rows as `names`.

    names: the two coordinates of the chart, then phi, psi (eta, gamma where an angle has a potential); J (4, orbits),
    closed integrals of p dq (`I` = J/2 pi); nu (4, orbits) = dE/dJ, in cycles per unit time (`omega` = 2 pi nu); theta
    (4, orbits), the angles conjugate to J, in cycles [0, 1): they grow by nu per unit time and {theta_i, J_j} =
    delta_ij. J_eta, J_gamma, nu_eta, nu_gamma, theta_eta, theta_gamma: those of the primitive cycles; phi = (gamma +
    eta)/2, psi = (gamma - eta)/2, so theta_phi, theta_psi are defined up to adding 1/2 to both. constants (4, orbits)
    with `constant_names`: the separation constants; turning_points (2, 2, orbits): least and largest value of both
    coordinates, which name the well an orbit is in; region (2, orbits): signs of p_eta and p_gamma (0 on the border).
    energy, status (orbits,); error (orbits,): estimate of the relative error of nu, from the last Fourier coefficients
    and the rounding of small differences: covers 99 % of the orbits (a closed form: rounding).
    """

    names: tuple[str, ...]
    J: Annotated[np.ndarray, along("angle", "orbit", unit="action", labels="names")]
    nu: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names")]
    theta: Annotated[np.ndarray, along("angle", "orbit", unit="cycles", labels="names")]
    energy: Annotated[np.ndarray, along("orbit", unit="energy")]
    constant_names: tuple[str, ...]
    constants: Annotated[np.ndarray, along("constant", "orbit", labels="constant_names", plain=True)]
    region: Annotated[np.ndarray, along("plane", "orbit")]
    error: Annotated[np.ndarray, along("orbit")]
    status: Annotated[np.ndarray, along("orbit")]
    nu_eta: Annotated[np.ndarray, along("orbit", unit="cycles/time")]
    nu_gamma: Annotated[np.ndarray, along("orbit", unit="cycles/time")]
    theta_eta: Annotated[np.ndarray, along("orbit", unit="cycles")]
    theta_gamma: Annotated[np.ndarray, along("orbit", unit="cycles")]
    separated: Separated
    regular_turning_points: Annotated[np.ndarray, along("coordinate", "end", "orbit")]

    @property
    def I(self) -> np.ndarray:  # noqa: E743
        """Actions J/2 pi."""
        return self.J / TURN

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu, in radians per unit time."""
        return TURN * self.nu

    @property
    def turning_points(self) -> np.ndarray:
        """Least and largest value of both coordinates, (2, 2, orbits)."""
        return self.separated.turning_points(self.regular_turning_points[:, :2])

    @property
    def J_eta(self) -> np.ndarray:
        """Action of the primitive cycle of eta."""
        return (self.J[2] - self.J[3]) / 2 if self.separated.isotropic else self.J[2]

    @property
    def J_gamma(self) -> np.ndarray:
        """Action of the primitive cycle of gamma."""
        return (self.J[2] + self.J[3]) / 2 if self.separated.isotropic else self.J[3]


@takes(z0=starts_of)
@recorded
def action_angles(
    body: Model,
    z0: Starts,
    *,
    chart: Chart | str | None = None,
    threads: int | None = None,
    report: Report | None = None,
) -> ActionAngles:
    """Find actions, frequencies, angles and separation constants of states of a separable body.

    Parameters
    ----------
    body : `Body` or `StackelBody`
        Its potential separates: Harmonic, Anharmonic, Hyperelastic, HeavyTop, SeparableAlphaBeta, SeparableRVartheta,
        SeparableElliptic, or any with a property alpha_beta, r_vartheta or elliptic.
    z0 : array (8,) or (8, orbits)
        Phase points.
    chart : `Chart`, optional
        For bodies that separate in several: ALPHA_BETA, R_VARTHETA, ELLIPTIC (default: the first of these).
    threads, report : as in `integrate`

    Returns
    -------
    `ActionAngles`
        Status of an orbit, never an exception: UNBOUND (J, nu, theta are NaN), ACTION_ZERO (circular orbits and
        equilibria: limits where they exist, NaN for the angle of a vanishing action), SEPARATRIX (p_eta or p_gamma = 0
        on an orbit through alpha = 0 or beta = 0, or an equilibrium there: actions are limits; the frequency of that
        angle jumps, NaN), NOT_CONVERGED (too close to an unstable equilibrium).

    Raises
    ------
    TypeError, ValueError
        An argument is wrong, or the body does not separate.
    Interrupted
        On Ctrl-C, with the result so far in `.partial`.

    Notes
    -----
    J_i = closed integral of p_i dq_i; nu = dE/dJ and theta = dS/dJ come from the derivatives of the integrals to the
    separation constants. Oscillators with walls have closed forms. Others are sums over midpoints of the phase between
    the turning points, spectrally accurate, their number doubled until the last Fourier coefficients vanish (16 to
    2048). The relative error of nu is 1e-14 in the median, 1e-12 for 99 % of random orbits (bench/test_tori.py). Narrow
    wells and small shears, whose energy is a difference in its last digits, get G from a polynomial fit and the width
    from the state itself. Memory: 300 bytes for each state.

    References
    ----------
    Martens & Slawianowski, EQ2.2 and section 4 (corrected); Landau & Lifshitz, Mechanics, section 50.

    Examples
    --------
    >>> tori = fa.action_angles(fa.Body(fa.Harmonic()), [1.0, 0.0, 0.5, 0.0, 0.2, 0.5, 0.0, 0.3])
    >>> tori.omega[:3, 0].round(9)
    array([2., 2., 1.])
    """
    separated = separate(body, chart)
    z = phase_points("z0", z0, body)
    n = z.shape[1]
    J, nu, theta, constants = np.full((4, 4, n), np.nan)
    turning, error = np.full((2, 3, n), np.nan), np.full(n, np.nan)
    status = np.full(n, int(Status.INTERRUPTED))
    out = Tori(z, J, nu, theta, turning, constants, error, status)
    with keeping("action_angles", lambda: _assembled(separated, out)):
        closed = _closed_form(separated)
        if closed is not None:
            kernel, parameters = closed
            _run(kernel, (separated.mu, *parameters, out), n, tori_closed.UNIT, threads, report)
        else:
            angular = np.array([not isinstance(V, Zero) for V in separated.angular], np.int64)
            terms = *separated.terms(), *separated.angular_terms()
            arguments = separated.family.number, *terms, separated.mu, angular, out
            _run(tori_quadrature.tori_by_quadrature, arguments, n, tori_quadrature.UNIT, threads, report)
    return _assembled(separated, out)


def _assembled(separated: Separated, out: Tori) -> ActionAngles:
    """Return the tori of what a kernel has written; the angles of planes become those of spin and vorticity."""
    z, J, nu, theta, turning, constants, error, status = out
    nu_eta, nu_gamma, theta_eta, theta_gamma = (row.copy() for row in (*nu[2:], *theta[2:]))
    region = np.zeros((2, z.shape[1]), np.int8)
    np.sign(_momenta(z), out=region, casting="unsafe")
    if separated.isotropic:
        constants[2:] = J[2:] / TURN
        for rows, factor in ((J, 1.0), (constants, 1.0), (nu, 0.5), (theta, 0.5)):
            _to_spin(rows, factor)
        theta[2:] -= np.floor(theta[2:])
    return ActionAngles(
        names=separated.names,
        J=J,
        nu=nu,
        theta=theta,
        energy=separated.family.energy(constants),
        constant_names=separated.constants,
        constants=constants,
        region=region,
        error=error,
        status=status,
        nu_eta=nu_eta,
        nu_gamma=nu_gamma,
        theta_eta=theta_eta,
        theta_gamma=theta_gamma,
        separated=separated,
        regular_turning_points=turning,
    )


def _momenta(z: np.ndarray) -> np.ndarray:
    """Return p_eta, p_gamma (2, orbits)."""
    return np.array([z[0] * z[5] - z[1] * z[4], z[2] * z[7] - z[3] * z[6]])


def _run(kernel: Any, arguments: tuple, n: int, unit: int, threads: int | None, report: Report | None) -> None:
    progress = units(n, unit)
    launch(kernel, arguments, progress, float(progress.size), checked_threads(threads), report)


def _closed_form(separated: Separated) -> tuple[Any, tuple[float, ...]] | None:
    """Return the kernel and parameters of a closed form, where there is one."""
    first, second = separated.functions
    if not separated.isotropic:
        return None
    if (
        isinstance(first, Oscillator)
        and isinstance(second, Oscillator)
        and min(first.k, second.k) > 0
        and min(first.c, second.c) >= 0
    ):
        return tori_closed.planes, (first.k, first.c, second.k, second.c)
    if (
        isinstance(first, Spring)
        and isinstance(second, Barriers)
        and first.k > 0
        and min(first.c, second.c_alpha, second.c_beta) >= 0
    ):
        return tori_closed.shells, (first.k, first.c, second.c_alpha, second.c_beta)
    return None


def _to_spin(rows: np.ndarray, factor: float) -> None:
    """Turn rows eta, gamma into phi, psi in place."""
    total, difference = factor * (rows[3] + rows[2]), factor * (rows[3] - rows[2])
    rows[2], rows[3] = total, difference


def from_action_angles(
    body: Model,
    J: ArrayLike,
    theta: ArrayLike,
    *,
    chart: Chart | str | None = None,
    near: ArrayLike | None = None,
    threads: int | None = None,
) -> np.ndarray:
    """Find the phase points of given actions and angles on the tori of a separable body: the inverse of
    `action_angles`.

    Parameters
    ----------
    body : `Body`
        Doubly isotropic and separable in (alpha, beta) or (r, vartheta).
    J : array (4,) or (4, orbits), action
        J >= 0 of the two coordinates, then J_phi, J_psi.
    theta : array (4,) or (4, orbits), cycles
        Angles; a single column goes with any number of the other.
    chart : as in `action_angles`
    near : array (8,) or (8, orbits), optional
        Phase point in the intended well, where the effective potentials have several.
    threads : as in `integrate`

    Returns
    -------
    array (8, orbits), or (8,) for single ones
        Phase points.

    Raises
    ------
    ValueError, TypeError
        An argument is wrong, or no torus has these actions.
    Interrupted
        On Ctrl-C, with NaN in `.partial` for points not yet found.

    Notes
    -----
    The constants come by Newton's method on J, from the bottom of the effective potential, the phases by Newton's
    method on theta = dS/dJ. J_eta = 0 or J_gamma = 0 is taken as the limit from above. Round trips with `action_angles`
    agree to 1e-11 or better.

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
    actions, angles, single = _rows("J", J), _rows("theta", theta), np.ndim(J) == np.ndim(theta) == 1
    n = max(actions.shape[1], angles.shape[1])
    if {actions.shape[1], angles.shape[1]} - {1, n}:
        raise ValueError(
            f"theta must have as many orbits as J, or one of them 1: got {angles.shape[1]} and {actions.shape[1]}"
        )
    actions = np.ascontiguousarray(np.broadcast_to(actions, (4, n)))
    angles = np.array(np.broadcast_to(angles, (4, n)))
    angles[2], angles[3] = angles[2] - angles[3], angles[2] + angles[3]
    separated = separate(body, chart)
    well, threads = _well(body, near, n), checked_threads(threads)
    if _closed_form(separated) is not None:
        z = closed_points(separated, _checked_actions(separated, actions), np.mod(angles, 1.0))
        return z[:, 0] if single else z
    z = np.full((8, n), np.nan)
    with keeping("from_action_angles", lambda: z[:, 0] if single else z):
        _refuse_failed(actions, _invert(separated, actions, np.mod(angles, 1.0), z, _unknown(n), well, threads))
    return z[:, 0] if single else z


@dataclass(frozen=True)
class EnergyOfActions(Result):
    """E(J) of tori: energy (orbits,), its gradient nu = dE/dJ (4, orbits), the names of the rows; status (orbits,): NaN
    where not OK.
    """

    names: tuple[str, ...]
    energy: Annotated[np.ndarray, along("orbit", unit="energy")]
    nu: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names", plain=True)]
    status: Annotated[np.ndarray, along("orbit")]


@recorded
def energy_of_actions(
    body: Model,
    J: ArrayLike,
    *,
    chart: Chart | str | None = None,
    near: ArrayLike | None = None,
    threads: int | None = None,
) -> EnergyOfActions:
    """Compute the Hamiltonian as a function of the actions, E(J), and its gradient, the frequencies.

    Parameters
    ----------
    body, J, chart, near, threads : as in `from_action_angles`

    Returns
    -------
    `EnergyOfActions`
        At J_eta = 0 or J_gamma = 0 the gradient is the limit from above. An orbit whose actions belong to no torus has
        the status UNBOUND or NOT_CONVERGED, and NaN.

    Raises
    ------
    TypeError, ValueError, Interrupted
        As in `from_action_angles`.

    Notes
    -----
    Closed forms for the oscillators (EQ3.21-3.23, EQa, EQb of the paper, corrected), else Newton's method on the
    quadratures.

    References
    ----------
    Martens & Slawianowski, section 4.

    Examples
    --------
    >>> fa.energy_of_actions(fa.Body(fa.Harmonic()), [0.5, 0.6, 0.3, 0.2]).energy.round(9)
    np.float64(0.397887358)
    """
    actions = _rows("J", J)
    separated = separate(body, chart)
    well, threads = _well(body, near, actions.shape[1]), checked_threads(threads)

    def found(nu: np.ndarray, energy: np.ndarray, status: np.ndarray) -> EnergyOfActions:
        _to_spin(nu, 0.5)
        which = 0 if np.ndim(J) == 1 else slice(None)
        return EnergyOfActions(names=separated.names, energy=energy[which], nu=nu[:, which], status=status[which])

    if _closed_form(separated) is not None:
        energy, nu = closed_energy(separated, _checked_actions(separated, actions))
        return found(nu, energy, np.zeros(energy.size, np.int64))
    out = _unknown(actions.shape[1])
    with keeping("energy_of_actions", lambda: found(*out)):
        _invert(separated, actions, np.empty((4, 0)), np.empty((8, 0)), out, well, threads)
    return found(*out)


def _unknown(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return gradients (4, n), energies and statuses (n,) of actions of which nothing is known yet."""
    return np.full((4, n), np.nan), np.full(n, np.nan), np.full(n, int(Status.INTERRUPTED))


def _well(body: Any, near: ArrayLike | None, n: int) -> np.ndarray | None:
    """Return phase points (8, 1) or (8, n) in the wells that are meant."""
    points = None if near is None else phase_points("near", near, body)
    if points is not None and points.shape[1] not in (1, n):
        raise ValueError(f"near must be one phase point or one for each of {n} orbits, got {points.shape[1]}")
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
            "body must be doubly isotropic and chart alpha-beta or r-vartheta: the inverse is not available for others"
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
    near: np.ndarray | None,
    threads: int | None,
) -> np.ndarray:
    """Fill z where theta has columns, and `out`: the gradient to J_1, J_2, J_eta, J_gamma, E and statuses, which are
    returned.
    """
    spins = _checked_actions(separated, J)
    spins[2:] *= TURN
    n = J.shape[1]
    start = np.zeros((2, n))
    if near is not None:
        start[:] = _start(separated, near)
    wells, (nu, energy, status) = np.ones(n, np.int64), out
    sought = tori_inverse.Sought(spins, theta, start, z, nu, energy, wells, status)
    arguments = separated.family.number, *separated.terms(), separated.mu, sought
    _run(tori_inverse.torus_points, arguments, n, tori_quadrature.UNIT, threads, None)
    several = np.flatnonzero(wells > 1)
    if several.size and near is None:
        raise ValueError(
            f"near must be given: the effective potential of orbit {several[0]} has {wells[several[0]]} wells; pass a "
            "phase point in the "
            "one that is meant (`action_angles` of it gives its turning points)"
        )
    return status


def _refuse_failed(J: np.ndarray, status: np.ndarray) -> None:
    failed = np.flatnonzero(status != Status.OK)
    if failed.size:
        k = failed[0]
        raise ValueError(
            f"J must be the actions of a torus: orbit {k}, J = {J[:, k]}, gives {Status(int(status[k])).name} "
            f"({Status(int(status[k])).sentence}); {failed.size} such orbits"
        )


def _start(separated: Separated, z: np.ndarray) -> np.ndarray:
    """Return the ratios s/t (2, orbits) of phase points, in the coordinates of kernels."""
    A, B = (z[:2] ** 2).sum(axis=0), (z[2:4] ** 2).sum(axis=0)
    return np.maximum(separated.family.start(A, B), 1e-28)  # type: ignore[union-attr]  # invertible
