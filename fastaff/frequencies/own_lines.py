"""The frequencies of figures and webs: the own line of each coordinate."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.classification import Classification
from ..runs.schemes.catalogue import ITERATION
from .angle_loops import NAMED
from .tunes import Tunes
from .turning import CHANGED

CAUGHT = 0.25
"""Largest relative difference of a dominant line and that of a resonance's own swing: for bananas in logarithmic
potentials it is 0.04 to 0.2, for harmonics in discs 0.27 to 0.52.
"""


TURN = "turn"
"""Name of the frequency 1 of the turn."""


def in_turns(found: Any) -> bool:
    """Tell whether frequencies are tunes, of a map or of samples: cycles per turn, known modulo 1."""
    return isinstance(found, Tunes) or getattr(found, "scheme", None) == ITERATION


def with_turn(found: Any) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """Return names, frequencies and errors of a result; of tunes with those of the turn as the last."""
    if not in_turns(found):
        return found.names, found.nu, found.error
    turn = np.ones((1, *found.nu.shape[1:]))
    nu = np.where(np.isfinite(found.error), found.nu, 0.0)
    return (*found.names, TURN), np.concatenate([nu, turn]), np.concatenate([found.error, 0 * turn])


def in_time(frequency_map: Any) -> bool:
    """Tell whether frequencies are those of a flow, in cycles per unit time: tunes of a map are modulo a turn."""
    return hasattr(frequency_map, "dominant") and not in_turns(frequency_map)


def about_an_axis(found: Any) -> bool:
    """Tell whether frequencies are those of R (, z) and phi, which may drive the others."""
    return tuple(found.names) in NAMED


def by_own_lines(frequency_map: Any) -> bool:
    """Tell whether figures show the coordinates' own lines: those of flows in time, but for a body's planes."""
    return in_time(frequency_map) and frequency_map.nu_eta is None


def harmonics(found: Any) -> np.ndarray:
    """Return a mask of dominant lines (n, orbits) of regular orbits that are only a harmonic of another coordinate's:
    dominant_i = c nu_j with c > 1, where nu_j leads its own coordinate, and the own nu_i is far from it.

    The radius of an orbit in a galaxy has the line 2 nu_z, often its strongest. Orbits that a resonance has caught,
    such as bananas, have these lines too, but swing about them slowly: their nu_i is within `CAUGHT` of the dominant
    one, which stays. About an axis lines of phi are always driven: one that a resonance has caught has another basis.
    """
    rows = np.arange(len(found.basis))[:, None]
    orbits = np.arange(found.basis.shape[2])
    size = np.abs(found.basis)
    source = size.argmax(axis=1)  # (n, orbits): the generator j of each row
    alone = np.count_nonzero(size, axis=1) == 1
    leads = alone & (source == rows) & (size.sum(axis=1) == 1)
    with np.errstate(all="ignore"):
        far = np.abs(found.nu / found.dominant - 1) > CAUGHT
    far |= (source == rows[-1]) & about_an_axis(found)
    multiple = alone & (size.sum(axis=1) > 1) & (source != rows)
    return multiple & leads[source, orbits] & far & (found.classification == Classification.REGULAR)


def own_lines(found: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the own line of each coordinate (n, orbits), `dominant`, but `nu` where that is a harmonic, and their
    errors; for maps, tunes and bodies `nu`; NaN where there is none.
    """
    nu = np.where(np.isfinite(found.error), found.nu, np.nan)
    error = found.error
    if not by_own_lines(found):
        return nu, error
    dominant = np.where(np.isfinite(found.dominant_error), found.dominant, np.nan)
    behind = harmonics(found)
    return np.where(behind, nu, dominant), np.where(behind, error, found.dominant_error)


def duration(found: Any) -> Any:
    """Return the time, or the turns (orbits,), that frequencies are of."""
    return found.window if isinstance(found, Tunes) else found.time


def calm(found: Any) -> np.ndarray:
    """Return a mask (orbits,) of orbits of a frequency map that do not show chaos: regular ones, and UNDECIDED ones
    whose frequencies change by less than CHANGED cycles from half to half.
    """
    with np.errstate(all="ignore"):
        steady = duration(found) / 2 * 10.0**found.diffusion < CHANGED
    return np.asarray(found.regular | ((found.classification == Classification.UNDECIDED) & steady))
