"""The radial motion of a central potential: its action, its rates and its share of the angles, by quadrature.

With s = |q|^2 and the total angular momentum L of the space around the centre F(s) = 2 mu (E - U(s)) s - L^2, which is
the form of `wells` with u0 = E and u3 = -L^2/(2 mu).
"""

from typing import NamedTuple

import numpy as np

from ...core.status import ACTION_ZERO_CODE, OK_CODE
from ...engine.jit import jit
from .coordinates import ACTION, D0, D3, ERROR, RADIAL, RESULTS, S1, S2, W0, W3, WIDTH, Coordinate
from .librations import MOST, ROWS, limits
from .phases import librate
from .quadrature import UNIT

PRECISION = 1e-14
"""Size of the last Fourier coefficients, relative to the integrals, at which quadratures end."""


class RadialStates(NamedTuple):
    """States of the radial motion, each (n,): |q|^2, q.p, |p|^2 and the total angular momentum L."""

    s: np.ndarray
    root: np.ndarray
    square: np.ndarray
    L: np.ndarray


class RadialMotion(NamedTuple):
    """Radial motions, each (n,): energy, J_r, dE/dJ_r, dE/dL at fixed J_r, theta_r in cycles, dS_r/dL at fixed J_r,
    ends of s, relative error and status.
    """

    energy: np.ndarray
    J: np.ndarray
    nu: np.ndarray
    rate: np.ndarray
    theta: np.ndarray
    swept: np.ndarray
    least: np.ndarray
    largest: np.ndarray
    error: np.ndarray
    status: np.ndarray


@jit
def _radial(coordinate, states, found, k, work, out):
    """Fill the radial motion of state k; returns its status."""
    mu = coordinate.mu
    s = states.s[k]
    L = states.L[k]
    term = coordinate.term
    work[0, 0] = s
    term.function(term.params, 1, work[0], work[1])
    E = states.square[k] / (2 * mu) + work[1, 0]
    coordinate.u[0] = E
    coordinate.u[3] = -L * L / (2 * mu)
    found.energy[k] = E
    code = librate(coordinate, s, 1.0, states.root[k], states.square[k], PRECISION, work, out)
    if code != OK_CODE:
        return code
    found.J[k] = out[ACTION]
    found.nu[k] = 1 / out[D0]
    found.least[k] = out[S1]
    found.largest[k] = out[S2]
    found.error[k] = out[ERROR]
    if L > 0.0:
        found.rate[k] = L / mu * out[D3] / out[D0]
        found.swept[k] = out[W0] * found.rate[k] - L / mu * out[W3]
    else:
        # L dJ_r/du3 has the limit pi mu if only the angular momentum keeps the motion from the centre.
        found.rate[k] = np.pi / out[D0] if coordinate.ends[0] == 0.0 else 0.0
        found.swept[k] = 0.0
    found.theta[k] = out[W0] / out[D0]
    if out[WIDTH] <= 0.0:
        found.theta[k] = np.nan
        return ACTION_ZERO_CODE
    return OK_CODE


def radial_motions(unit, stop, progress, term, mu, states, found):
    """Fill the radial motions of states in a central potential."""
    if stop[0] != 0:
        return
    work = np.zeros((ROWS, MOST))
    out = np.zeros(RESULTS)
    coordinate = Coordinate(term, mu, RADIAL, np.zeros(4), np.zeros(2))
    limits(coordinate, work)
    for k in range(unit * UNIT, min(found.status.size, (unit + 1) * UNIT)):
        out[:] = 0.0
        coordinate.u[:] = 0.0
        found.status[k] = _radial(coordinate, states, found, k, work, out)
    progress[unit] = 1
