"""Frequencies of orbits in the making: the arrays that collect them, and the map made from these."""

from __future__ import annotations

import numpy as np

from ..runs.schemes.catalogue import Scheme
from .angle_lines import LineTable
from .angle_loops import SignalLayout
from .classify import classify
from .frequencies import FrequencyMap
from .readings import Reading


class FrequencyTable:
    """The frequencies of orbits so far: arrays as in a FrequencyMap, with `ambiguous` and `irregular` as in a Reading;
    reached (orbits,): a mask of orbits that have been read.
    """

    def __init__(self, layout: SignalLayout, orbits: int, lines: int | None = None):
        self.layout, n = layout, len(layout.angles.names)
        self.nu, self.dominant = np.zeros((2, n, orbits))
        self.halves = np.zeros((2, n, orbits))
        self.error, self.dominant_error, self.scheme_error = np.full((3, n, orbits), np.inf)
        self.rank = np.zeros(orbits, np.int64)
        self.basis = np.zeros((n, n, orbits), np.int64)
        self.halves_error = np.full((2, n, orbits), np.inf)
        self.reached, self.ambiguous, self.irregular = np.zeros((3, orbits), bool)
        self.lines = None if lines is None else LineTable(layout.angles.names, lines, orbits)

    def adopt(self, orbits: np.ndarray, reading: Reading) -> None:
        """Fill in the reading of these orbits."""
        for name in ("nu", "error", "scheme_error", "dominant", "dominant_error"):
            getattr(self, name)[:, orbits] = getattr(reading, name).T
        for name in ("halves", "halves_error"):
            getattr(self, name)[:, :, orbits] = getattr(reading, name).transpose(2, 1, 0)
        self.ambiguous[orbits], self.irregular[orbits] = reading.ambiguous, reading.irregular
        self.basis[:, :, orbits], self.rank[orbits] = reading.basis.transpose(1, 2, 0), reading.rank
        self.reached[orbits] = True

    @property
    def change(self) -> np.ndarray:
        """Change (n, orbits) of the frequencies from one half to the other."""
        return np.abs(self.halves[0] - self.halves[1])

    def classification(self, time: float | np.ndarray) -> np.ndarray:
        """Return the classification of each orbit from its frequencies over that time and their change."""
        m = self.layout.m
        turns = time * np.abs(self.nu[:m]).max(axis=0, initial=0.0)
        # Two steady lines closer than 1/time, such as those of a slow precession, look alike and may change by a turn.
        unknown = time * np.where(np.isfinite(self.error[:m]), self.error[:m], 0.0) >= 1
        undecided = self.ambiguous | (unknown.any(axis=0) & (not self.layout.body))
        return classify(self.rank, len(self.nu), np.where(self.reached, turns, 0.0), undecided, self.irregular)

    def assembled(
        self,
        nu: np.ndarray,
        error: np.ndarray,
        status: np.ndarray,
        *,
        t: np.ndarray,
        time: float,
        step: float | np.ndarray,
        read: float | np.ndarray,
        energy_error: np.ndarray | None = None,
        scheme: Scheme | None = None,
    ) -> FrequencyMap:
        """Return the map of frequencies nu with their errors, with phi = (eta + gamma)/2 and psi = (gamma - eta)/2 for
        a body; t: the time that each orbit reached, read: that over which it was read.
        """
        names = self.layout.angles.names
        dominant_error = self.dominant_error
        nu, dominant, halves = (np.where(self.reached, rows, np.nan) for rows in (nu, self.dominant, self.halves))
        halves_error = self.halves_error
        # A libration of a coupled body may have no angle of its own; those of the planes always exist.
        body = self.layout.body and not self.layout.axis
        sound = np.array(self.layout.angles.planes) if body else np.ones(len(nu), bool)
        diffusion = np.where(self.reached, np.log10(self.change[sound].max(axis=0) + 1e-18), np.nan)
        eta = gamma = None
        if names[-2:] == ("eta", "gamma"):
            eta = nu[-2]
            gamma = nu[-1]
            names = (*names[:-2], "phi", "psi")
            nu, dominant = (np.array([*a[:-2], (a[-2] + a[-1]) / 2, (a[-1] - a[-2]) / 2]) for a in (nu, dominant))
            error, dominant_error = (np.array([*a[:-2], *[(a[-2] + a[-1]) / 2] * 2]) for a in (error, dominant_error))
            halves = np.stack(
                [*halves[:, :-2].swapaxes(0, 1), halves[:, -2:].sum(axis=1) / 2, (halves[:, -1] - halves[:, -2]) / 2], 1
            )
            halves_error = np.stack(
                [*halves_error[:, :-2].swapaxes(0, 1), *[halves_error[:, -2:].sum(axis=1) / 2] * 2], 1
            )
        return FrequencyMap(
            names=names,
            nu=nu,
            error=error,
            diffusion=diffusion,
            energy_error=energy_error,
            status=status,
            nu_eta=eta,
            nu_gamma=gamma,
            time=time,
            scheme=scheme,
            step=step,
            classification=self.classification(read),
            rank=self.rank,
            dominant=dominant,
            dominant_error=dominant_error,
            basis=self.basis,
            t=t,
            lines=None if self.lines is None else self.lines.result(),
            nu_halves=halves,
            nu_halves_error=halves_error,
        )
