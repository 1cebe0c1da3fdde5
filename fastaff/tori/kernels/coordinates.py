"""Separated coordinates in their regular variables: F(s) of a motion, and the entries of a result."""

from typing import Any, NamedTuple

import numpy as np

from ...engine.jit import jit

RADIAL = 0
SINE = 1
SINH = 2
LINE = 3
LINE_STEP = 2 * np.pi / 64
"""Steps of the search for turning points; narrower barriers have knots, which are searched too."""
S1, T1, S2, T2, WIDTH, ACTION, D0, D1, D2, D3, NODES, CHI, W0, W1, W2, W3, ERROR, CENTRE, RADIUS, PANELS, RESULTS = (
    range(21)
)
"""Entries of a result: ends, half-width, J, dJ/du0...dJ/du3, nodes, phase, integrals to it, error, fitted interval
(radius 0: none), panels (0: none)."""


class PotentialTerm(NamedTuple):
    """A term of a separated potential: its block function with its parameters, and the increasing ratios (places on a
    line) at which it has narrow features.
    """

    function: Any
    params: np.ndarray
    knots: np.ndarray


class Coordinate(NamedTuple):
    """A separated coordinate: its potential, the mass, its kind, the coefficients u (4,) of its motion, and the limits
    of U s t at s = 0 and at t = 0 (2,).
    """

    term: PotentialTerm
    mu: float
    kind: int
    u: np.ndarray
    ends: np.ndarray


@jit
def complement(kind, s):
    """Return t at s."""
    if kind == SINE:
        return 1.0 - s
    if kind == SINH:
        return 1.0 + s
    return 1.0


@jit
def radicands(coordinate, n, s, t, F):
    """F (n,) at s, t (n,)."""
    term = coordinate.term
    mu = coordinate.mu
    kind = coordinate.kind
    u = coordinate.u
    term.function(term.params, n, s, F)
    if kind == LINE:
        for k in range(n):
            F[k] = 2 * mu * (u[0] - F[k])
    else:
        for k in range(n):
            W = s[k] * t[k]
            F[k] = 2 * mu * ((u[0] + u[1] * t[k]) * W + u[2] * s[k] + u[3] * t[k] - F[k] * W)


@jit
def set_place(kind, rho, k, work):
    """Write s and t of the ratio rho (s itself on a line) to work[0:2, k]."""
    if kind == SINE:
        work[0, k] = rho / (1 + rho)
        work[1, k] = 1 / (1 + rho)
    else:
        work[0, k] = rho
        work[1, k] = complement(kind, rho)
