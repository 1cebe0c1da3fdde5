"""Fundamental frequencies of orbits: the result, and the classification of each orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..core.classification import Classification, is_regular
from ..core.status import Status, describe, of_single
from ..results.result import Result, along
from ..runs.schemes.catalogue import ITERATION, Scheme
from .angle_lines import AngleLines


@dataclass(frozen=True)
class FrequencyMap(Result):
    """Fundamental frequencies of orbits.

    Attributes
    ----------
    names : tuple of str, length n
        Names of the angles, one for each row of `nu`. For a body they are two librations, phi and psi.
    nu : ndarray, shape (n, orbits)
        Fundamental frequencies in cycles per unit time; for a map per iterate. They are positive, or have the sign of
        the rotation for the planes of a body. For a plane of a map it is the tune in [0, 1); for a periodic coordinate
        the mean advance in periods, not modulo 1. NaN for orbits of a map that were lost.
    error : ndarray, shape (n, orbits)
        Error estimates of `nu`, of averaging, integration and round-off; inf if there is no frequency.
    diffusion : ndarray, shape (orbits,)
        log10 of the largest ``|nu(first half) - nu(second half)|``, for a body over `nu_eta` and `nu_gamma`; NaN if
        there is no frequency.
    energy_error : ndarray, shape (orbits,), or None
        Largest energy error, relative to the largest kinetic energy. None for orbits given as samples.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit.
    nu_eta, nu_gamma : ndarray, shape (orbits,), or None
        Frequencies of the angles eta and gamma of a body, which are defined on every orbit.
    time : float
        Length of the run.
    scheme : Scheme or None
        Integration method. None for orbits given as samples.
    step : float or ndarray, shape (orbits,)
        Step size, in units of time: one for each orbit if it was chosen. For orbits given as samples, their interval.
    classification : ndarray of int, shape (orbits,)
        `Classification` of each orbit: REGULAR, RESONANT, IRREGULAR or UNDECIDED.
    rank : ndarray of int, shape (orbits,)
        Number of independent frequencies. If it is less than n, the other rows of `nu` are the dominant lines of their
        coordinates.
    dominant : ndarray, shape (n, orbits)
        Dominant spectral line of each coordinate, in cycles per unit time.
    dominant_error : ndarray, shape (n, orbits)
        Error estimates of `dominant`.
    basis : ndarray of int, shape (n, n, orbits)
        Integers with ``dominant_i = sum_j basis_ij nu_j`` within the errors. A row is 0 if they are unknown. A singular
        basis means that the dominant lines are locked.
    t : ndarray, shape (orbits,), or None
        Time that each orbit reached. A lost particle keeps its earlier frequencies.
    lines : AngleLines or None
        Strongest spectral lines of each signal, if they were requested. For a map they are those of the first window,
        modulo 1, in (-1/2, 1/2], and without the mean advance of a periodic coordinate.
    nu_halves : ndarray, shape (2, n, orbits), or None
        Frequencies of both halves of the run; None for maps.
    nu_halves_error : ndarray, shape (2, n, orbits), or None
        Error estimates of `nu_halves`.

    Notes
    -----
    - REGULAR: all visible lines are combinations of n independent frequencies.
    - RESONANT: they are combinations of fewer (a resonance, a mode at rest, or an angle of a map locked to a fraction).
    - IRREGULAR: chaos or a transient. Frequencies of the whole run and of the halves differ by 0.25 cycles over a half
      or more, and the dominant lines are not sharp.
    - UNDECIDED: the run is too short. A line is not explained, lines are closer than about 1/time, a mode is too slow,
      a low resonance is within the errors, or an error exceeds 0.15/time.
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
        """Digits to which weighted averages over both halves (or windows) agree, shape (orbits,).

        They are relative to the largest frequency, for a map to one turn; NaN if there is no frequency. Chaotic orbits
        have about log10(t)/2, with t in periods, regular ones up to 16.

        References
        ----------
        Sander & Meiss 2020, Physica D 411, 132569.
        """
        largest = np.where(np.isfinite(self.error), np.abs(self.nu), 0.0).max(axis=0)
        if self.scheme == ITERATION:
            largest = np.where(np.isfinite(self.error).any(axis=0), 1.0, 0.0)
        with np.errstate(all="ignore"):
            digits = np.minimum(np.log10(largest) - self.diffusion, 18.0)
        return np.where(largest > 0, digits, np.nan)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu in radians per unit time, shape (n, orbits)."""
        return 2 * np.pi * self.nu

    @property
    def regular(self) -> np.ndarray:
        """Mask of the orbits that are OK, and REGULAR or RESONANT, shape (orbits,)."""
        return (self.status == Status.OK) & is_regular(self.classification)

    @property
    def other_basis(self) -> np.ndarray:
        """Mask of regular orbits whose frequencies differ from the dominant lines of the coordinates, shape (orbits,).

        An orbit trapped in a resonance is an example. At such orbits `nu` jumps from orbit to orbit because the basis
        changes; `dominant` jumps if another line is the strongest.
        """
        own = np.eye(len(self.basis), dtype=np.int64)[:, :, None]
        return self.regular & ((self.basis != own).any(axis=1) & self.basis.any(axis=1)).any(axis=0)

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits, and the classes of those that are OK.

        Returns
        -------
        str
            Summary.
        """
        kinds = {entry.name.lower(): self.classification == entry for entry in Classification}
        said = describe(self.status, kinds) + of_single(self.status, "nu", self.names, self.nu)
        if np.any((self.status == Status.OK) & (self.classification == Classification.UNDECIDED)):
            said += "; frequencies of undecided orbits may be off by up to 1/time"
        if other := int(np.count_nonzero(self.other_basis)):
            said += f"; {other} with frequencies other than the dominant lines, see other_basis"
        return said
