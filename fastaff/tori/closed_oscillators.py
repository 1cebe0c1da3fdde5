"""Energy, frequencies and phase points of given actions of oscillators with walls, in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..systems.models import Barriers, Oscillator, Spring
from .kernels import closed as tori_closed
from .kernels.closed import TURN
from .separation import Separated


def _barriers(
    separated: Separated, p_eta: np.ndarray, p_gamma: np.ndarray
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return Lambda = sqrt(p^2 + 2 mu wall) of both planes of oscillators with walls, and p/Lambda, from above at 0."""
    second = separated.functions[1]
    walls = (separated.functions[0].c, second.c) if isinstance(second, Oscillator) else (second.c_alpha, second.c_beta)
    barriers = [np.sqrt(p * p + 2 * separated.mu * wall) for p, wall in zip((p_eta, p_gamma), walls, strict=True)]
    ratios = [
        np.where(L > 0, p / np.where(L > 0, L, 1.0), 1.0) for p, L in zip((p_eta, p_gamma), barriers, strict=True)
    ]
    return barriers, ratios


def closed_energy(separated: Separated, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return E and its gradient to J_1, J_2, J_eta, J_gamma of oscillators with walls."""
    mu = separated.mu
    first, second = separated.functions
    J1, J2, p_eta, p_gamma = actions
    omega = np.sqrt(first.k / mu)
    one = np.ones_like(J1)
    barriers, ratios = _barriers(separated, p_eta, p_gamma)
    if isinstance(second, Oscillator):
        other = np.sqrt(second.k / mu)
        E = omega * (J1 / np.pi + barriers[0]) + other * (J2 / np.pi + barriers[1])
        nu = [omega / np.pi * one, other / np.pi * one, omega / TURN * ratios[0], other / TURN * ratios[1]]
    else:
        Lambda = J2 / np.pi + barriers[0] + barriers[1]
        outer = np.sqrt(Lambda * Lambda + 2 * mu * first.c)
        E = omega * (J1 / np.pi + outer)
        slope = omega / np.pi * np.where(outer > 0, Lambda / np.where(outer > 0, outer, 1.0), 1.0)
        nu = [omega / np.pi * one, slope, slope / 2 * ratios[0], slope / 2 * ratios[1]]
    return E, np.array(nu)


def closed_points(separated: Separated, actions: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Return the phase points of oscillators with walls: each regular variable is m - l cos(chi)."""
    mu = separated.mu
    first, second = separated.functions
    J1, J2, p_eta, p_gamma = actions
    planes = isinstance(second, Oscillator)
    (L_a, L_b), ratios = _barriers(separated, p_eta, p_gamma)
    if planes:
        A, pA, psi_a, chi_a = swing(J1, L_a, np.sqrt(mu * first.k), TURN * theta[0])
        B, pB, psi_b, chi_b = swing(J2, L_b, np.sqrt(mu * second.k), TURN * theta[1])
        turn_a = psi_a - chi_a / 2
        turn_b = psi_b - chi_b / 2
    else:
        Lambda = J2 / np.pi + L_a + L_b
        outer = np.sqrt(Lambda * Lambda + 2 * mu * first.c)
        r, p_r, psi, chi_r = swing(J1, outer, np.sqrt(mu * first.k), TURN * theta[0])
        chi = TURN * theta[1] + 2 * Lambda / outer * (psi - chi_r / 2)
        # s1 s2 = (L_b/Lambda)^2, (1 - s1)(1 - s2) = (L_a/Lambda)^2, and l^2 as a product: no cancellation for small J.
        x = J2 / np.pi
        amplitude = np.sqrt(x * (x + 2 * L_a) * (x + 2 * L_b) * (x + 2 * L_a + 2 * L_b)) / (2 * Lambda * Lambda)
        middle_s = (x * (x + 2 * L_a + 2 * L_b) + 2 * L_b * (L_a + L_b)) / (2 * Lambda * Lambda)
        middle_t = (x * (x + 2 * L_a + 2 * L_b) + 2 * L_a * (L_a + L_b)) / (2 * Lambda * Lambda)
        s = _between((L_b / Lambda) ** 2, middle_s, amplitude, chi)
        t = _between((L_a / Lambda) ** 2, middle_t, amplitude, chi + np.pi)
        p_s = Lambda * amplitude * np.sin(chi)
        A = r * t
        B = r * s
        pA = t * p_r - p_s
        pB = s * p_r + p_s
        turns = np.floor(chi / TURN)
        rest = np.mod(chi, TURN)
        s2 = middle_s + amplitude
        t1 = middle_t + amplitude
        psi_s = (
            np.arctan2(np.sqrt(s2) * np.sin(rest / 2), L_b / Lambda / np.sqrt(s2) * np.cos(rest / 2)) + np.pi * turns
        )
        psi_t = (
            np.arctan2(L_a / Lambda / np.sqrt(t1) * np.sin(rest / 2), np.sqrt(t1) * np.cos(rest / 2)) + np.pi * turns
        )
        turn_a = psi_t - np.pi * theta[1]
        turn_b = psi_s - np.pi * theta[1]
    rows = (A, B, TURN * theta[2] + ratios[0] * turn_a, TURN * theta[3] + ratios[1] * turn_b)
    radii = [np.sqrt(A), np.sqrt(B)]
    momenta = [np.where(q > 0, p / np.where(q > 0, q, 1.0), 0.0) for p, q in zip((pA, pB), radii, strict=True)]
    across = [np.where(q > 0, p / np.where(q > 0, q, 1.0), 0.0) for p, q in zip((p_eta, p_gamma), radii, strict=True)]
    z = []
    for q, angle in ((radii[0], rows[2]), (radii[1], rows[3])):
        z += [q * np.cos(angle), q * np.sin(angle)]
    for p, w, angle in ((momenta[0], across[0], rows[2]), (momenta[1], across[1], rows[3])):
        z += [p * np.cos(angle) - w * np.sin(angle), p * np.sin(angle) + w * np.cos(angle)]
    return np.array(z)


def _between(product: np.ndarray, middle: np.ndarray, amplitude: np.ndarray, chi: np.ndarray) -> np.ndarray:
    """Return m - l cos(chi) as its least value and a positive term."""
    return product / (middle + amplitude) + 2 * amplitude * np.sin(chi / 2) ** 2


def swing(J: np.ndarray, Lambda: np.ndarray, stiffness: float, chi: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return s, root = s-momentum, psi and chi of an oscillator's plane (or of r) of action J and effective momentum
    Lambda.
    """
    middle = (J / np.pi + Lambda) / stiffness
    amplitude = np.sqrt(J / np.pi * (J / np.pi + 2 * Lambda)) / stiffness
    high = middle + amplitude
    least = (Lambda / stiffness) ** 2 / np.where(high > 0, high, 1.0)
    psi = np.arctan2(np.sqrt(high) * np.sin(chi / 2), np.sqrt(least) * np.cos(chi / 2))
    return least + 2 * amplitude * np.sin(chi / 2) ** 2, stiffness * amplitude * np.sin(chi), psi, chi


def closed_form(separated: Separated) -> tuple[Any, tuple[float, ...]] | None:
    """Return the kernel and parameters of a closed form, where there is one."""
    first, second = separated.functions
    if not separated.isotropic or separated.breathing:
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
