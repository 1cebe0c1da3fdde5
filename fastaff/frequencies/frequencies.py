"""Fundamental frequencies of orbits: the result, and the classification of each orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..core.classification import Classification, is_regular
from ..core.status import Status, describe
from ..results.result import Result, along
from ..runs.schemes.catalogue import ITERATION, Scheme
from .angle_lines import AngleLines


@dataclass(frozen=True)
class FrequencyMap(Result):
    """Fundamental frequencies of orbits.

    names: one for each row of nu (n, orbits), in cycles per unit time (`omega` = 2 pi nu); error (n, orbits), which
    covers the averaging, the scheme and rounding; inf where there is no frequency (of a map, and of an orbit that was
    lost, nu is NaN there); classification (orbits,) of `Classification`: REGULAR, all n
    frequencies are independent; RESONANT, only `rank` (orbits,) of them are (a resonance, a mode at rest; of a
    map, an angle locked to a fraction of the turn), the other rows show the dominant line of their coordinate;
    IRREGULAR, they change from one half to the other: chaos or a transient; UNDECIDED, the time is too short to tell,
    as where a visible line is no combination of the frequencies, lines are closer than about 1/time (a slow precession,
    weakly coupled modes, a low resonance), an error is above 0.15/time, or a mode is too slow to show. dominant,
    dominant_error (n, orbits): the strongest line of each angle's own loop, and basis (n, n, orbits) integers with
    dominant_i = sum_j basis_ij nu_j within the errors (row i is 0 where none are known). Frequencies that all have
    basis 1 are those of the coordinates' own lines (`other_basis` marks orbits without them); with a singular basis
    the dominant lines are locked. diffusion (orbits,) = log10 of the largest ``|nu(first half) - nu(second half)|``,
    for a body over nu_eta and nu_gamma, whose angles are well defined on every orbit, NaN where there is none;
    energy_error, status (orbits,); t (orbits,) the time reached. step: the step used, one for each orbit, or that
    of an adaptive scheme. For a body the rows are two librations, phi and psi; nu_eta and nu_gamma are kept beside
    them. lines: the strongest lines of each angle's signal, where they were asked for. nu_halves, nu_halves_error
    (2, n, orbits): the frequencies of both halves of the time with their errors, None for maps. Orbits that were given
    as samples have no energy_error and no scheme, and step is their interval.
    """

    names: tuple[str, ...]
    nu: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names", plain=True)]
    error: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names")]
    diffusion: Annotated[np.ndarray, along("orbit", unit="log10(cycles/time)")]
    energy_error: Annotated[np.ndarray | None, along("orbit", unit="largest kinetic energy")]
    status: Annotated[np.ndarray, along("orbit")]
    nu_eta: Annotated[np.ndarray | None, along("orbit", unit="cycles/time")]
    nu_gamma: Annotated[np.ndarray | None, along("orbit", unit="cycles/time")]
    time: float
    scheme: Scheme | None
    step: Annotated[float | np.ndarray, along("orbit", unit="time")]
    classification: Annotated[np.ndarray, along("orbit")]
    rank: Annotated[np.ndarray, along("orbit")]
    dominant: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names")]
    dominant_error: Annotated[np.ndarray, along("angle", "orbit", unit="cycles/time", labels="names")]
    basis: Annotated[np.ndarray, along("angle", "generator", "orbit", labels="names")]
    t: Annotated[np.ndarray | None, along("orbit", unit="time")] = None
    lines: Annotated[AngleLines | None, along("orbit")] = None
    nu_halves: Annotated[np.ndarray | None, along("half", "angle", "orbit", unit="cycles/time", labels="names")] = None
    nu_halves_error: Annotated[
        np.ndarray | None, along("half", "angle", "orbit", unit="cycles/time", labels="names")
    ] = None

    @property
    def digits(self) -> np.ndarray:
        """Digits (orbits,) to which the weighted averages of both halves agree, relative to the largest frequency, for
        a map to one turn; NaN where there is none.

        Chaotic orbits have about log10(t)/2, t in periods, regular ones up to all 16. In `frequency_map` with a
        window: of the first and the last one.

        :Source: Sander & Meiss 2020, Physica D 411, 132569.
        """
        largest = np.where(np.isfinite(self.error), np.abs(self.nu), 0.0).max(axis=0)
        if self.scheme == ITERATION:
            largest = np.where(np.isfinite(self.error).any(axis=0), 1.0, 0.0)
        with np.errstate(all="ignore"):
            digits = np.minimum(np.log10(largest) - self.diffusion, 18.0)
        return np.where(largest > 0, digits, np.nan)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu, in radians per unit time."""
        return 2 * np.pi * self.nu

    @property
    def regular(self) -> np.ndarray:
        """Whether orbits (orbits,) are OK and have frequencies, independent or not: neither irregular nor undecided."""
        return (self.status == Status.OK) & is_regular(self.classification)

    @property
    def other_basis(self) -> np.ndarray:
        """Whether regular orbits (orbits,) have frequencies of another basis than the coordinates' own lines, as in a
        resonance: nu jumps from orbit to orbit where the basis changes, `dominant` where another line is the strongest.
        """
        own = np.eye(len(self.basis), dtype=np.int64)[:, :, None]
        return self.regular & ((self.basis != own).any(axis=1) & self.basis.any(axis=1)).any(axis=0)

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits, and the classes of those that are OK."""
        fine = self.status == Status.OK
        counts = {
            "by the coordinates' own lines": self.regular & ~self.other_basis,
            "by another basis (the own lines are `dominant`)": self.other_basis,
            "irregular": fine & (self.classification == Classification.IRREGULAR),
            "undecided (error 1/time: a longer time tells)": fine & (self.classification == Classification.UNDECIDED),
        }
        return describe(self.status, ", ".join(f"{n} {said}" for said, which in counts.items() if (n := which.sum())))
