"""Fourier series of tori, z(theta) = Re sum_k z_k exp(2 pi i k . theta): their canonical form, values and actions."""

from __future__ import annotations

import numpy as np

from ..frequencies.integer_lattice import first_basis

TERMS = 1e-16
"""Relative size of the coefficients that are kept."""


def canonical(k: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return k, z with one of each pair +-k, the largest first, and the angles at the middle, their origin made
    canonical.
    """
    d = k.shape[1]
    for i in range(d):  # the last component that is not 0 is positive
        negative = (k[:, i] < 0) & (k[:, i + 1 :] == 0).all(axis=1)
        k, z = np.where(negative[:, None], -k, k), np.where(negative, z.conj(), z)
    k, place = np.unique(k, axis=0, return_inverse=True) if d else (k[:1], np.zeros(len(k), int))
    summed = np.zeros((len(z), len(k)), complex)
    np.add.at(summed.T, place.ravel(), z.T)
    summed[:, ~k.any(axis=1)] = summed[:, ~k.any(axis=1)].real
    n = len(z) // 2
    scale = np.repeat([np.sqrt((np.abs(part) ** 2).sum()) or 1.0 for part in (summed[:n], summed[n:])], n)[:, None]
    size = np.abs(summed / scale).max(axis=0)
    order = np.argsort(-np.round(np.log(np.maximum(size, 1e-300)), 6), kind="stable")  # equal sizes in the order of k
    order = order[size[order] > TERMS * size.max()]
    k, z = k[order], summed[:, order]
    leading = np.flatnonzero(k.any(axis=1))[:60]
    chosen = leading[first_basis(k[leading])]
    large = np.abs(z[:n, chosen])
    coordinate = (large > (1 - 1e-6) * large.max(axis=0)).argmax(axis=0)  # the first of equals
    phases = np.angle(z[coordinate, chosen]) / (2 * np.pi)
    angles = np.linalg.lstsq(k[chosen].astype(float), phases, rcond=None)[0] if len(chosen) else np.zeros(d)
    return k, z * np.exp(-2j * np.pi * (k @ angles)), angles


def actions(k: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return J = 2 pi I, I_i = 1/2 Re sum_k i k_i conj(p_k) . q_k."""
    n = len(z) // 2
    return np.pi * k.T @ (1j * (z[n:].conj() * z[:n]).sum(axis=0)).real


def evaluate(k: np.ndarray, z: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Return Re sum_k z_k exp(2 pi i k . theta) at theta (d, points), from tables of exp(2 pi i j theta_i)."""
    out = np.empty((len(z), theta.shape[1]))
    reach = np.abs(k).max(axis=0, initial=0)
    for start in range(0, theta.shape[1], 64):
        part = slice(start, start + 64)
        waves = np.ones((len(k), theta[:, part].shape[1]), complex)
        for component, largest, angle in zip(k.T, reach, theta[:, part] % 1.0, strict=True):
            waves *= np.exp(2j * np.pi * np.arange(-largest, largest + 1)[:, None] * angle)[component + largest]
        out[:, part] = (z @ waves).real
    return out
