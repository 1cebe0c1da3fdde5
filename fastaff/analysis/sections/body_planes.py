"""Momenta of a body on an energy surface, over its two radii."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...models.sections import AreaEquals, BetaEquals
from .allowed_region import Function


def planes(alpha, p_alpha, p_eta, beta, p_beta, p_gamma):
    """Return phase points with eta = gamma = 0; a radius 0 is allowed where its angular momentum is 0."""
    across_a = p_eta / alpha if p_eta else 0.0 * alpha
    across_b = p_gamma / beta if p_gamma else 0.0 * beta
    return np.array([alpha, 0 * alpha, beta, 0 * beta, p_alpha, across_a, p_beta, across_b])


def radii_over(section: Any, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return alpha and beta on a section that gives one of them over the other, u."""
    if isinstance(section, AreaEquals):
        return np.sqrt(2 * section.constant + u * u), u
    constant = np.full(u.shape, float(section.constant))
    return (u, constant) if isinstance(section, BetaEquals) else (constant, u)


def room(
    body: Any, energy: float, p_eta: float, p_gamma: float, alpha: Any, beta: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Return 2 mu (energy - H) at rest in alpha and beta, the squared momentum that is left, and the sum of the sizes
    of its terms.
    """
    A, B = alpha * alpha, beta * beta
    barrier = (p_eta / alpha) ** 2 if p_eta else 0.0
    barrier = barrier + ((p_gamma / beta) ** 2 if p_gamma else 0.0)
    V = body.potential.value(A, B)
    left = np.where(body.potential.margin(A, B) > 0, 2 * body.mu * (energy - V) - barrier, -np.inf)
    return left, 2 * body.mu * (abs(energy) + np.abs(V)) + barrier


def radial(body: Any, energy: float, p_eta: float, p_gamma: float, u: np.ndarray, *, alpha: bool) -> Function:
    """Return `room` as a function of alpha (else beta) in columns over values u of the other radius."""
    if alpha:
        return lambda x, j: room(body, energy, p_eta, p_gamma, x, u[j])
    return lambda x, j: room(body, energy, p_eta, p_gamma, u[j], x)
