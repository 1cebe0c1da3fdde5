"""Actions, frequencies and angles of central bodies in the charts of R^4.

In a subspace R^d the angular momenta L_d > ... > L_3 > |L_2| are actions up to sums: J_j = 2 pi (L_j - L_{j-1}). With
S = S_r + the sum of S_j + p_azimuth azimuth the angles are the derivatives of S, all elementary but the radial ones:

    dS_j/dL_j = psi_j,   dS_j/dL_{j-1} = -phi_j,
    cos(angle_j) = c cos(psi_j),   tan(phi_j) = (L_j/L_{j-1}) tan(psi_j),   c^2 = 1 - (L_{j-1}/L_j)^2.

So 2 pi theta_j = dS_r/dL_d + psi_d - phi_d + ... + psi_j: psi is the phase of a motion along a great circle and phi its
longitude, both from the lower turning point of the coordinate.

Source: Martens & Slawianowski, EQ2.2c; Goldstein, Classical Mechanics, section 10.8 (angles, here derived for R^4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.numbers import Callback
from ..core.status import Status
from ..engine.blocks import function_block
from ..engine.packing import launch, units
from ..engine.threads import checked_threads
from ..engine.values import parameters
from ..systems.models.regular_variables import Itself, in_regular_variable
from .kernels.central import RadialMotion, RadialStates, radial_motions
from .kernels.closed import NOISE, TURN
from .kernels.coordinates import PotentialTerm
from .kernels.quadrature import UNIT
from .narrow_features import knots
from .r4_charts import CentralPotential, R4Separated, Subspace

HAVE_TORI = (Status.OK, Status.ACTION_ZERO, Status.SEPARATRIX)
"""Statuses of orbits with actions."""


class SubspaceTori(NamedTuple):
    """Tori of one subspace: J, nu, theta and constants (d, n), turning (d, 2, n), error and status (n,)."""

    J: np.ndarray
    nu: np.ndarray
    theta: np.ndarray
    constants: np.ndarray
    turning: np.ndarray
    error: np.ndarray
    status: np.ndarray


def radial_term(potential: CentralPotential) -> PotentialTerm:
    """Return the potential of the radial motion as kernels see it."""
    V = in_regular_variable(potential, Itself())
    return PotentialTerm(function_block(V), parameters(V), knots(potential, Itself()))


def elements_of(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix elements x, y, z, u (4, n) of phase points, and their momenta."""
    # One formula for both: parallel q and p have no angular momentum, not even round-off.
    q, p = (np.array([a1 + b1, b2 - a2, a2 + b2, a1 - b1]) / np.sqrt(2.0) for a1, a2, b1, b2 in (z[:4], z[4:]))
    return q, p


def angular_momenta(q: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return L_2 (with its sign), L_3, ... of the first elements, and sqrt(L_j^2 - L_{j-1}^2), 0 for j = 2.

    Both are (d - 1, n).
    """
    signed = q[0] * p[1] - q[1] * p[0]
    L = [signed]
    across = [np.zeros_like(signed)]
    for j in range(2, len(q)):
        gained = sum((q[i] * p[j] - q[j] * p[i]) ** 2 for i in range(j))
        across.append(np.sqrt(gained))
        L.append(np.sqrt(L[-1] ** 2 + gained))
    return np.array(L), np.array(across)


def radial_states(q: np.ndarray, p: np.ndarray, L: np.ndarray) -> RadialStates:
    """Return the states of the radial motion of a subspace."""
    return RadialStates((q**2).sum(axis=0), (q * p).sum(axis=0), (p**2).sum(axis=0), L)


def unknown_radial(n: int) -> RadialMotion:
    """Return radial motions (n,) before they are found."""
    energy, J, nu, rate, theta, swept, least, largest, error = np.full((9, n), np.nan)
    status = np.full(n, int(Status.INTERRUPTED))
    return RadialMotion(
        energy, J, nu, rate=rate, theta=theta, swept=swept, least=least, largest=largest, error=error, status=status
    )


def harmonic_radial(states: RadialStates, mu: float, k: float) -> RadialMotion:
    """Return the radial motions of V = k s/2 in closed form: s = m - l cos(chi)."""
    s, root, square, L = states
    stiffness = np.sqrt(mu * k)
    omega = np.sqrt(k / mu)
    energy = square / (2 * mu) + k * s / 2
    middle = energy / k
    mean = L / stiffness
    cosine = middle - s
    sine = root / stiffness
    amplitude = np.hypot(cosine, sine)
    still = amplitude <= NOISE * middle
    amplitude = np.where(still, 0.0, amplitude)
    largest = middle + amplitude
    chi = np.where(still, 0.0, np.mod(np.arctan2(sine, cosine), TURN))
    with np.errstate(divide="ignore", invalid="ignore"):
        # J = pi (E/omega - L) is a difference: amplitude^2 keeps the digits of a small action.
        J = np.where(still, 0.0, np.pi * stiffness * amplitude**2 / (middle + mean))
        least = np.where(largest > 0, mean**2 / largest, 0.0)
        rest = np.where(cosine <= 0, largest * (amplitude - cosine), largest * sine**2 / (amplitude + cosine))
        around = np.where(still, 0.0, np.arctan2(rest, mean * sine))
    ones = np.ones_like(s)
    return RadialMotion(
        energy=energy,
        J=J,
        nu=omega / np.pi * ones,
        rate=omega * ones,
        theta=np.where(still, np.nan, chi / TURN),
        swept=chi / 2 - around,
        least=least,
        largest=largest,
        error=np.full(s.size, np.finfo(float).eps),
        status=np.where(still, int(Status.ACTION_ZERO), int(Status.OK)),
    )


def line_tori(q: np.ndarray, p: np.ndarray, mu: float, k: float) -> SubspaceTori:
    """Return the tori of one element in V = k q^2/2."""
    omega = np.sqrt(k / mu)
    stiffness = np.sqrt(k * mu)
    energy = p**2 / (2 * mu) + k * q**2 / 2
    theta = np.mod(np.arctan2(p, -stiffness * q) / TURN, 1.0)
    amplitude = np.sqrt(2 * energy / k)
    still = energy == 0.0
    return SubspaceTori(
        J=(TURN * energy / omega)[None],
        nu=np.full((1, q.size), omega / TURN),
        theta=np.where(still, np.nan, theta)[None],
        constants=energy[None],
        turning=np.array([[-amplitude, amplitude]]),
        error=np.full(q.size, np.finfo(float).eps),
        status=np.where(still, int(Status.ACTION_ZERO), int(Status.OK)),
    )


def subspace_tori(space: Subspace, q: np.ndarray, p: np.ndarray, radial: RadialMotion) -> SubspaceTori:
    """Return the tori of a subspace of at least two elements (d, n), from its radial motion."""
    d = space.dimension
    L, across = angular_momenta(q, p)
    status = radial.status.copy()
    signed = L[0]
    sign = np.where(signed < 0, -1.0, 1.0)
    sizes = np.vstack([np.abs(signed), L[1:]])
    J, nu, theta = np.full((3, d, q.shape[1]), np.nan)
    turning = np.empty((d, 2, q.shape[1]))
    J[0] = radial.J
    nu[0] = radial.nu
    theta[0] = radial.theta
    turning[0] = np.sqrt(radial.least), np.sqrt(radial.largest)
    swept = radial.swept.copy()
    for row, j in enumerate(range(d - 1, 1, -1), start=1):
        upper, lower = sizes[j - 1], sizes[j - 2]
        tilt = across[j - 1]
        forward = 1.0 if space.from_axis[row - 1] else -1.0
        inward = sum(q[i] * (q[j] * p[i] - q[i] * p[j]) for i in range(j))
        sine, cosine = forward * inward, forward * q[j] * upper
        psi = np.arctan2(sine, cosine)
        flat = tilt <= NOISE * upper
        with np.errstate(divide="ignore", invalid="ignore"):
            J[row] = np.where(upper > 0, TURN * tilt**2 / (upper + lower), 0.0)
            half = np.arccos(np.clip(np.where(upper > 0, tilt / upper, 0.0), 0.0, 1.0))
        psi = np.where(flat, 0.0, psi)
        swept = swept + psi
        theta[row] = np.where(flat, np.nan, swept / TURN)
        swept = swept - np.where(flat, 0.0, np.arctan2(upper * sine, lower * cosine))
        nu[row] = radial.rate / TURN
        turning[row] = (half, np.pi - half) if forward > 0 else (half - np.pi / 2, np.pi / 2 - half)
        status = np.where(flat & (status == Status.OK), int(Status.ACTION_ZERO), status)
    on_axis = signed == 0.0
    azimuth = np.where((q[0] == 0) & (q[1] == 0), np.arctan2(p[1], p[0]), np.arctan2(q[1], q[0]))
    J[-1] = TURN * signed
    nu[-1] = np.where(on_axis, np.nan, sign * radial.rate / TURN)
    theta[-1] = np.where(on_axis, np.nan, (azimuth + sign * swept) / TURN)
    turning[-1] = np.array([0.0, TURN])[:, None]
    bound = (status == Status.OK) | (status == Status.ACTION_ZERO)
    status = np.where(bound & on_axis, int(Status.SEPARATRIX), status)
    with np.errstate(invalid="ignore"):
        theta = theta - np.floor(theta)
    constants = np.vstack([radial.energy, sizes[:0:-1], signed])
    return SubspaceTori(J, nu, np.where(theta >= 1.0, 0.0, theta), constants, turning, radial.error, status)


def r4_constants(separated: R4Separated, z: np.ndarray) -> np.ndarray:
    """Return the separation constants (4, n) of phase points."""
    q, p = elements_of(z)
    rows = []
    for space in separated.family.subspaces:
        x, y = q[list(space.elements)], p[list(space.elements)]
        kinetic = (y**2).sum(axis=0) / (2 * separated.mu)
        square = (x**2).sum(axis=0)
        if separated.family.whole:
            rows.append(kinetic + separated.body.potential.value(square))
        else:
            rows.append(kinetic + separated.body.stiffness * square / 2)
        if space.dimension > 1:
            L = angular_momenta(x, y)[0]
            rows += [*L[:0:-1], L[0]]
    return np.array(rows)


def r4_tori(
    separated: R4Separated, z: np.ndarray, found: RadialMotion, threads: int | None, callback: Callback | None
) -> None:
    """Find the radial motions in R^4 of phase points by quadrature."""
    q, p = elements_of(z)
    states = radial_states(q, p, np.abs(angular_momenta(q, p)[0][-1]))
    progress = units(states.s.size, UNIT)
    arguments = radial_term(separated.body.potential), separated.mu, states, found
    launch(radial_motions, arguments, progress, float(progress.size), checked_threads(threads), callback)


def assembled(separated: R4Separated, z: np.ndarray, found: RadialMotion | None) -> SubspaceTori:
    """Return the tori of phase points, from the radial motions in R^4 or, without them, in closed form."""
    q, p = elements_of(z)
    k = separated.body.stiffness
    parts = []
    for space in separated.family.subspaces:
        x, y = q[list(space.elements)], p[list(space.elements)]
        if space.dimension == 1:
            parts.append(line_tori(x[0], y[0], separated.mu, k))
            continue
        radial = found
        if radial is None:
            states = radial_states(x, y, np.abs(angular_momenta(x, y)[0][-1]))
            radial = harmonic_radial(states, separated.mu, k)
            if separated.family.whole:
                radial = radial._replace(energy=radial.energy + separated.body.offset)
        parts.append(subspace_tori(space, x, y, radial))
    J, nu, theta, constants, turning = (
        np.concatenate(arrays) for arrays in zip(*(part[:5] for part in parts), strict=True)
    )
    error = np.max([part.error for part in parts], axis=0)
    status = np.max([part.status for part in parts], axis=0)
    status[np.isin(status, HAVE_TORI) & ~np.isfinite(J).all(axis=0)] = Status.NOT_CONVERGED
    lost = ~np.isin(status, HAVE_TORI)
    for array in (J, nu, theta, turning):
        array[..., lost] = np.nan
    error[lost] = np.inf
    return SubspaceTori(J, nu, theta, constants, turning, error, status)
