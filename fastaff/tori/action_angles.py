"""Action-angle tori of separable bodies: from states to actions, frequencies and angles, and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, checked_callback
from ..core.status import Status, describe, of_single
from ..engine.packing import launch, units
from ..engine.threads import checked_threads
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.result import Result, along
from ..runs.requirements import current_system, phase_points
from ..runs.starts import starts_of
from ..systems.charts.chart import Chart
from ..systems.models import Zero
from ..systems.models.contracts import SeparableModel
from .closed_oscillators import closed_form
from .kernels import closed as tori_closed
from .kernels import quadrature as tori_quadrature
from .kernels.central import RadialMotion
from .kernels.closed import TURN, Tori
from .r4_charts import R4Separated
from .r4_tori import assembled, r4_tori, unknown_radial
from .separation import Separated, separate_anywhere


@dataclass(frozen=True)
class ActionAngles(Result):
    """Action-angle variables of states of a separable body.

    Attributes
    ----------
    names : tuple of str
        Rows: the two coordinates of the chart, then phi and psi, or eta and gamma if an angle has a potential. In the
        charts of R^4, the four coordinates of the chart.
    J : ndarray, shape (4, orbits)
        Actions, the closed integrals of p dq.
    nu : ndarray, shape (4, orbits)
        Frequencies dE/dJ, in cycles per unit time.
    theta : ndarray, shape (4, orbits)
        Angles conjugate to J, in cycles from 0 to 1. They grow by nu per unit time, and {theta_i, J_j} = delta_ij.
        theta_phi and theta_psi are defined up to adding 1/2 to both, because phi = (gamma + eta)/2 and psi = (gamma -
        eta)/2.
    energy : ndarray, shape (orbits,)
        Energy.
    constant_names : tuple of str
        Names of the separation constants.
    constants : ndarray, shape (4, orbits)
        Separation constants, rows as `constant_names`.
    region : ndarray of int, shape (2, orbits)
        Signs of p_eta and p_gamma, 0 on the border.
    error : ndarray, shape (orbits,)
        Estimate of the relative error of nu, from the last Fourier coefficients and round-off of small differences. It
        covers 99 % of the orbits. For closed forms it is round-off.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit.
    nu_eta, nu_gamma : ndarray, shape (orbits,)
        Frequencies of the primitive cycles of eta and gamma, in cycles per unit time. NaN in the charts of R^4.
    theta_eta, theta_gamma : ndarray, shape (orbits,)
        Angles of the primitive cycles of eta and gamma, in cycles. NaN in the charts of R^4.
    separated : object
        The body in its chart of separation.
    regular_turning_points : ndarray, shape (2, 3, orbits) or (4, 2, orbits)
        Turning points in the regular variables of the coordinates; `turning_points` has the coordinates themselves.
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
    separated: Separated | R4Separated
    regular_turning_points: Annotated[np.ndarray, along("coordinate", "end", "orbit")]

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits, and with the actions of a single orbit.

        Returns
        -------
        str
            Summary.
        """
        return describe(self.status) + of_single(self.status, "J", self.names, self.J)

    @property
    def I(self) -> np.ndarray:  # noqa: E743
        """Actions J/2 pi, shape (4, orbits)."""
        return self.J / TURN

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu, in radians per unit time, shape (4, orbits)."""
        return TURN * self.nu

    @property
    def turning_points(self) -> np.ndarray:
        """Turning points of both coordinates, shape (2, 2, orbits); of all four, (4, 2, orbits), in the charts of R^4.

        The least and largest values identify the potential well of an orbit. Those of an azimuth are 0 and 2 pi.
        """
        return self.separated.turning_points(self.regular_turning_points[:, :2])

    @property
    def J_eta(self) -> np.ndarray:
        """Action of the primitive cycle of eta, shape (orbits,). NaN in the charts of R^4."""
        return self.separated.plane_actions(self.J)[0]

    @property
    def J_gamma(self) -> np.ndarray:
        """Action of the primitive cycle of gamma, shape (orbits,). NaN in the charts of R^4."""
        return self.separated.plane_actions(self.J)[1]


@coerces_arguments(z0=starts_of)
@records_call
@inserts_parameters
def action_angles(
    model: SeparableModel,
    z0: Starts,
    *,
    chart: Chart | str | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> ActionAngles:
    """Compute actions, frequencies, angles and separation constants of states of a separable body.

    Parameters
    ----------
    model : Body, StackelBody or BreathingBody
        Body with a separable potential: `Harmonic`, `Anharmonic`, `Hyperelastic`, `HeavyTop`, `SeparableAlphaBeta`,
        `SeparableRVartheta`, `SeparableElliptic`, or a user-defined one with a property ``alpha_beta``, ``r_vartheta``
        or ``elliptic``.
    z0 : array_like, shape (8,) or (8, orbits)
        Phase points: a1, a2, b1, b2, then their momenta.
    chart : Chart or str, optional
        Coordinates of separation: `ALPHA_BETA`, `R_VARTHETA` or `ELLIPTIC`; `SPHERICAL` if V depends on r alone; if V
        is harmonic, also `SPHERICAL_CARTESIAN`, `POLAR_POLAR`, `POLAR_CARTESIAN` and `CARTESIAN`. Default: the first
        of these in which the body separates.
    {threads}
    {callback}

    Returns
    -------
    ActionAngles
        Actions, frequencies and angles, with one column for each orbit.

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
    - Method: J, dE/dJ and dS/dJ are quadratures over the phase between the turning points. Oscillators with walls, and
      all angles of the charts of R^4, have closed forms.
    - Accuracy: spectral, with 16 to 2048 points. The relative error of nu is 1e-14 in the median and 1e-12 for 99 % of
      random orbits.
    - ``UNBOUND``: J, nu and theta are NaN.
    - ``ACTION_ZERO``: circular orbits and equilibria. Values are limits if they exist; the angle of a vanishing action
      is NaN.
    - ``SEPARATRIX``: p_eta or p_gamma = 0 on an orbit or equilibrium at alpha = 0 or beta = 0. Actions are limits; that
      frequency is NaN.
    - ``NOT_CONVERGED``: the orbit is too close to an unstable equilibrium.
    - Memory: 300 bytes per state.

    References
    ----------
    Martens & Slawianowski, EQ2.2 and section 4 (corrected); Landau & Lifshitz, Mechanics, section 50.

    Examples
    --------
    >>> tori = fa.action_angles(fa.Body(fa.Harmonic()), [1.0, 0.0, 0.5, 0.0, 0.2, 0.5, 0.0, 0.3])
    >>> tori.omega[:3, 0].round(9)
    array([2., 2., 1.])
    """
    separated = separate_anywhere(model, chart)
    z = phase_points("z0", z0, current_system(model))
    n = z.shape[1]
    if isinstance(separated, R4Separated):
        found = None if separated.body.stiffness > 0 else unknown_radial(n)
        checked_threads(threads)
        with partial_result_on_interrupt("action_angles", lambda: _in_r4(separated, z, found)):
            if found is not None:
                r4_tori(separated, z, found, threads, callback)
            elif (report := checked_callback(callback)) is not None:
                report(1.0)
        return _in_r4(separated, z, found)
    J, nu, theta, constants = np.full((4, 4, n), np.nan)
    turning = np.full((2, 3, n), np.nan)
    error = np.full(n, np.nan)
    status = np.full(n, int(Status.INTERRUPTED))
    out = Tori(z, J, nu, theta, turning, constants, error, status)
    with partial_result_on_interrupt("action_angles", lambda: _assembled(separated, out)):
        closed = closed_form(separated)
        if closed is not None:
            kernel, parameters = closed
            run_kernel(kernel, (separated.mu, *parameters, out), n, tori_closed.UNIT, threads, callback)
        else:
            angular = np.array([not isinstance(V, Zero) for V in separated.angular], np.int64)
            terms = *separated.terms(), *separated.angular_terms()
            arguments = separated.family.number, *terms, separated.mu, separated.radial_mu, angular, out
            run_kernel(tori_quadrature.tori_by_quadrature, arguments, n, tori_quadrature.UNIT, threads, callback)
    return _assembled(separated, out)


def _assembled(separated: Separated, out: Tori) -> ActionAngles:
    """Return the tori that a kernel has written; the angles of planes become those of spin and vorticity."""
    z, J, nu, theta, turning, constants, error, status = out
    nu_eta, nu_gamma, theta_eta, theta_gamma = (row.copy() for row in (*nu[2:], *theta[2:]))
    region = np.zeros((2, z.shape[1]), np.int8)
    np.sign(_momenta(z), out=region, casting="unsafe")
    if separated.isotropic:
        constants[2:] = J[2:] / TURN
        for rows, factor in ((J, 1.0), (constants, 1.0), (nu, 0.5), (theta, 0.5)):
            to_spin(rows, factor)
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


def _in_r4(separated: R4Separated, z: np.ndarray, found: RadialMotion | None) -> ActionAngles:
    """Return tori in a chart of R^4, from the radial motions, or without them in closed form."""
    tori = assembled(separated, z, found)
    nu_eta, nu_gamma, theta_eta, theta_gamma = np.full((4, z.shape[1]), np.nan)
    return ActionAngles(
        names=separated.names,
        J=tori.J,
        nu=tori.nu,
        theta=tori.theta,
        energy=separated.energy(tori.constants),
        constant_names=separated.constants,
        constants=tori.constants,
        region=np.sign(_momenta(z)).astype(np.int8),
        error=tori.error,
        status=tori.status,
        nu_eta=nu_eta,
        nu_gamma=nu_gamma,
        theta_eta=theta_eta,
        theta_gamma=theta_gamma,
        separated=separated,
        regular_turning_points=tori.turning,
    )


def _momenta(z: np.ndarray) -> np.ndarray:
    """Return p_eta, p_gamma (2, orbits)."""
    return np.array([z[0] * z[5] - z[1] * z[4], z[2] * z[7] - z[3] * z[6]])


def run_kernel(
    kernel: Any, arguments: tuple, n: int, unit: int, threads: int | None, callback: Callback | None
) -> None:
    """Run a kernel of tori over n of them, `unit` at a time."""
    progress = units(n, unit)
    launch(kernel, arguments, progress, float(progress.size), checked_threads(threads), callback)


def to_spin(rows: np.ndarray, factor: float) -> None:
    """Turn rows eta, gamma into phi, psi in place."""
    total = factor * (rows[3] + rows[2])
    difference = factor * (rows[3] - rows[2])
    rows[2] = total
    rows[3] = difference
