"""The own units of orbits, for distances of phase points and for phases."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...flows.flow import Flow
from ...flows.motion import motion, natural_rates
from ...models.mechanics import system_of
from ...schemes.catalogue import DOP853

LOOKS, TURNS, LONGER = 64, 4 * np.pi, 10
"""Samples of a trial run of orbits of a flow, radians that it should show, and largest number of its doublings."""

LOOSE = 1e-8
"""Tolerance of such a run."""

RESTING = 1e-28
"""Share of the largest row below which another is 0, and moves by the rounding of a Newton step alone."""


class Scale(NamedTuple):
    """The own units of orbits: rows (2n, orbits), amplitudes of coordinates and momenta; rate (orbits,), an angular
    frequency; energy.
    """

    rows: np.ndarray
    rate: np.ndarray
    energy: np.ndarray

    def of(self, which: Any) -> Scale:
        """Return the units of some of the orbits."""
        return Scale(*(entry[..., which] for entry in self))

    def matrix(self, monodromy: np.ndarray) -> np.ndarray:
        """Return monodromy matrices (orbits, 2n, 2n) in these units."""
        with np.errstate(all="ignore"):
            return monodromy * self.rows.T[:, None, :] / self.rows.T[:, :, None]

    def norm(self, change: np.ndarray) -> np.ndarray:
        """Return the lengths of changes (orbits, 2n) of phase points."""
        with np.errstate(all="ignore"):
            return np.linalg.norm(change / self.rows.T, axis=1)

    def rounding(self, z: np.ndarray) -> np.ndarray:
        """Return the rounding error of phase points z (2n, orbits): large where the origin is far."""
        with np.errstate(all="ignore"):
            return 4e-16 * (1 + np.linalg.norm(z / self.rows, axis=0))


def orbit_scale(model: Any, z: np.ndarray, energy: np.ndarray, threads: int) -> Scale:
    """Return the own units of the orbits through z (2n, orbits), those of `Motion`; |energy - H(z)| counts if it
    exceeds the kinetic energy.
    """
    system = system_of(model)
    if not system.canonical:
        return _scale_of_flow(model, z, threads)
    found = motion(model, z, threads)
    if system.iterated:
        return Scale(np.concatenate([found.position, found.momentum]), found.rate, found.kinetic)
    W = np.einsum("iij->ij", system.inverse_masses(z))
    with np.errstate(all="ignore"):
        W = found.rate * found.position / found.momentum if system.curved else W
        K = np.fmax(found.kinetic, np.abs(energy - system.energies(z)))
        if system.driven:
            K = np.where(K > 0, K, 1.0)  # a fixed point of its map may be at rest: then any unit will do
        rows = np.stack([np.sqrt(2 * K * W) / found.rate, np.sqrt(2 * K / W)])
        if system.driven:
            rows[0, -1], rows[1, -1] = model.period, K
        return Scale(rows.reshape(-1, *K.shape), found.rate, K)


def _scale_of_flow(model: Any, z: np.ndarray, threads: int) -> Scale:
    """Return the own units of orbits of dz/dt = f(z): half of the range of each row, and the rate pi/2 <|dz/dt|> over
    that, the largest of all rows: 2 pi over the period of a row that oscillates.

    They come from a trial run that is doubled until it shows two turns.
    """
    rows, orbits = z.shape
    with np.errstate(all="ignore"):
        first = natural_rates(model, z, threads)
    turns = TURNS / np.where(np.isfinite(first) & (first > 0), first, 1.0)
    time = 2.0 ** np.ceil(np.log2(turns))  # orbits that share theirs are run together
    size, rate = np.zeros((rows, orbits)), np.zeros(orbits)
    todo, flow = np.arange(orbits), Flow(model, DOP853, np.inf, LOOSE, LOOSE, threads)
    for _ in range(LONGER):
        short = np.zeros(orbits, bool)
        for length in np.unique(time[todo]):
            some = todo[time[todo] == length]
            ensemble = flow.ensemble(np.ascontiguousarray(z[:, some]))
            path = np.concatenate([z[:, some].T[:, None], flow.sampled(ensemble, LOOKS, time=float(length))], axis=1)
            with np.errstate(all="ignore"):
                half = (np.fmax.reduce(path, axis=1) - np.fmin.reduce(path, axis=1)) / 2
                rates = 0.5 * np.pi * np.nansum(np.abs(np.diff(path, axis=1)), axis=1) / (half * length)
            size[:, some], rate[some] = half.T, np.fmax.reduce(np.where(half > 0, rates, 0.0), axis=1)
            short[some] = np.isfinite(path).all(axis=(1, 2)) & (rate[some] * length < TURNS)
        todo = np.flatnonzero(short)
        if not todo.size:
            break
        time[todo] *= 2.0
    least = RESTING * np.fmax(np.fmax.reduce(size, axis=0), np.abs(z).max(axis=0))
    here = np.where(np.abs(z) > least, np.abs(z), 1.0)
    size = np.where(np.isfinite(size) & (size > least), size, here)
    return Scale(size, np.where(rate > 0, rate, 1 / time), np.zeros(orbits))
