"""From samples of an orbit to what a torus is fitted from: signals, the lattice of their lines, first frequencies."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...models.traits import traits_of
from ..frequencies.integer_lattice import box, first_basis, generators
from ..frequencies.naff import naff
from .series import weights

LINES = (16, 48)
"""Lines of each signal from which the lattice of frequencies is found; the second number where the first leave it
incomplete.
"""

FLAT = 1e-11
"""Size of a signal, relative to the orbit, below which it counts as constant."""

TRUSTED = 0.03
"""Error bar of a line, in cycles over the window, up to which it can add to the lattice or speak against it."""


class Unknown(NamedTuple):
    """What stands for the model of orbits that were given: the names of its coordinates, no equations of motion."""

    coordinates: tuple[str, ...]

    @property
    def degrees_of_freedom(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)


class Signals(NamedTuple):
    """Complex signals of unit size (signals, samples), and the way back to phase points: z_k = rows @ c_k, rows (2n,
    signals).

    carrier (signals,): number of each signal's carrier frequency, -1 for none; nu: first values of `rank` libration
    frequencies, then of the carriers; names of both; unknown: lines that are no integer combination of the librations.
    """

    values: np.ndarray
    rows: np.ndarray
    carrier: np.ndarray
    rank: int
    nu: np.ndarray
    names: tuple[str, ...]
    unknown: int


def signals(body: Any, t: np.ndarray, z: np.ndarray) -> Signals:
    """Return the signals of samples z (2n, samples) at equidistant times t, and the first values of their frequencies.

    For a body the planes a and b and their momenta, whose carriers are the mean turning rates of eta and gamma;
    for other systems the loops q - i kappa p of the coordinates, without carriers.
    """
    n = body.degrees_of_freedom
    size = [np.sqrt((part**2).sum(axis=0).mean()) or 1.0 for part in (z[:n], z[n:])]
    librations, names, unknown = _lattice(body, t, z, size[0])
    if not traits_of(body).isotropic:
        loops = z[:n] / size[0] - 1j * z[n:] / size[1]
        way_back = np.vstack([size[0] * np.eye(n), 1j * size[1] * np.eye(n)])
        return Signals(loops, way_back, np.full(n, -1), rank=len(names), nu=librations, names=names, unknown=unknown)
    values: list[np.ndarray] = []
    rows: list[np.ndarray] = []
    carrier: list[int] = []
    turning: list[float] = []
    for name, q, p in (("eta", 0, 4), ("gamma", 2, 6)):
        planes = [z[q] + 1j * z[q + 1], z[p] + 1j * z[p + 1]]
        if all(np.abs(plane).max() <= FLAT * s for plane, s in zip(planes, size, strict=True)):
            continue
        for plane, s, row in zip(planes, size, (q, p), strict=True):
            back = np.zeros(8, complex)
            back[row : row + 2] = s, -1j * s  # Re of the plane, and Im
            values.append(plane / s)
            rows.append(back)
            carrier.append(len(turning))
        turning.append(_turning(values[-2], values[-1], t[1] - t[0], librations))
        names = (*names, name)
    return Signals(
        values=np.array(values),
        rows=np.array(rows).T,
        carrier=np.array(carrier),
        rank=len(librations),
        nu=np.append(librations, turning),
        names=names,
        unknown=unknown,
    )


def _loops(body: Any, z: np.ndarray, size: float) -> tuple[np.ndarray, list[str]]:
    """Return the loops Q - c - i kappa P of the librations that move, (loops, samples), and their names."""
    n = body.degrees_of_freedom
    angles = getattr(body, "angles", None)
    if angles is None or (any(angles.planes) and not traits_of(body).isotropic):
        pairs, names = [(z[i], z[n + i]) for i in range(n)], list(body.coordinates)
    else:
        s = np.array([np.broadcast_to(row, z[0].shape) for row in angles.signals(*z)]).reshape(-1, 4, z.shape[1])
        kept = [i for i, plane in enumerate(angles.planes) if not plane]
        pairs, names = [(s[i, 0], s[i, 2]) for i in kept], [angles.names[i] for i in kept]
    loops, moving = [], []
    for (q, p), name in zip(pairs, names, strict=True):
        width, height = np.ptp(q), np.ptp(p)
        if width > FLAT * max(np.abs(q).max(), size) and height > 0:
            loops.append(q - (q.max() + q.min()) / 2 - 1j * width / height * p)
            moving.append(name)
    return np.array(loops).reshape(-1, z.shape[1]), moving


def _lattice(body: Any, t: np.ndarray, z: np.ndarray, size: float) -> tuple[np.ndarray, tuple[str, ...], int]:
    """Return a basis of the librations' frequencies with names, and how many lines it does not explain.

    The leading lines of the natural signals come first where they can be part of a basis, then the stronger ones; all
    positive.
    """
    loops, names = _loops(body, z, size)
    if not len(loops):
        return np.zeros(0), (), 0
    rank = 2 if traits_of(body).isotropic else body.degrees_of_freedom
    for lines in LINES:  # many multiples of one strong frequency can hide the second one
        found = naff(loops, t[1] - t[0], lines=lines, window_order=4)
        known = np.isfinite(found.error)
        strength = np.abs(found.amplitude) / np.abs(found.amplitude).max(axis=1, keepdims=True)
        strength = np.where(known & (np.abs(found.nu) * t[-1] > 3), strength, 0.0)
        error = np.where(known, 3 * found.error, np.inf) + 1e-12 * np.abs(found.nu).max()
        leading = np.arange(lines) == strength.argmax(axis=1)[:, None]
        sharp = error * t[-1] < TRUSTED
        order = np.argsort(-(strength + 2.0 * leading), axis=None, kind="stable")
        order = order[(((strength > 1e-6) & sharp) | leading).ravel()[order]]
        lattice = generators(found.nu.ravel()[order], error.ravel()[order], rank)
        if len(lattice.nu) == rank:
            break
    unknown = int((~lattice.known & sharp.ravel()[order]).sum())
    k = lattice.k[lattice.known]
    chosen = first_basis(k)
    if len(chosen) < len(lattice.nu):  # no lines are a basis: take the generators themselves
        return np.abs(lattice.nu), tuple(names[: len(lattice.nu)]), unknown
    own = [names[j // lines] for j in order[lattice.known][chosen]]  # the signal of each, or one that none is from
    spare = [name for name in names if name not in own]
    own = [name if name not in own[:i] or not spare else spare.pop(0) for i, name in enumerate(own)]
    basis, natural = np.abs(k[chosen] @ lattice.nu), sorted(range(len(own)), key=lambda i: names.index(own[i]))
    return basis[natural], tuple(own[i] for i in natural), unknown


def _turning(a: np.ndarray, p: np.ndarray, dt: float, librations: np.ndarray) -> float:
    """Return the mean turning rate of a plane: a line of its loop a - i kappa p, minus what librations bring it to the
    mean rate.

    The loop never vanishes where kappa has the sign of Im(conj(a) p), so the mean rate of its argument is that of arg
    a; its weighted average says which of the lines' classes is meant, the line itself is sharper.
    """
    sense = -1.0 if np.mean(np.imag(a.conj() * p)) < -1e-13 else 1.0
    loop = a - 1j * sense * np.sqrt(np.mean(np.abs(a) ** 2) / (np.mean(np.abs(p) ** 2) or np.inf)) * p
    steps = np.angle(loop[1:] * loop[:-1].conj()) / (2 * np.pi * dt)
    half = len(steps) // 2
    rate, first, second = (float(weights(len(s)) @ s) for s in (steps, steps[:half], steps[half:]))
    line = naff(loop, dt, lines=LINES[0], window_order=4).nu[0]
    k = box([12] * len(librations))
    candidates = line - k @ librations
    miss = np.abs(candidates - rate)
    near = np.flatnonzero(miss <= max(3 * abs(first - second) + 1e-9 * abs(rate), miss.min()))
    return float(candidates[near[np.argmin(np.abs(k[near]).sum(axis=1))]])
