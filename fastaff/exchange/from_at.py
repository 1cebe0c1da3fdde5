"""Lattices of PyAT as maps of one turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .kicks import Kick, turn
from .linear_parts import compared, higher, kept_momentum, probed, told

ROWS = [0, 2, 1, 3]
"""Rows of x, y, px, py among x, px, y, py, delta, ct."""


CUT = (
    "cut it into thin kicks first, n times [at.Drift('d', L/2/n), at.ThinMultipole('k', e.PolynomA*L/n, "
    "e.PolynomB*L/n), at.Drift('d', L/2/n)] with L = e.Length in place of the element e"
)
"""What makes thin kicks of a thick element: PyAT has no call for it."""

KICKS = (
    "A, B = e.PolynomA.copy(), e.PolynomB.copy(); A[:2] = B[:2] = 0; e.PolynomA[2:] = e.PolynomB[2:] = 0; then, of "
    "parts = e.divide([0.5/n]*2*n), at.ThinMultipole('k', A*L/n, B*L/n) with L = e.Length in the midst of each pair"
)
"""What makes thin kicks of the higher multipoles of a dipole e."""

LIMITS = ("Limits", "RApertures", "EApertures")
"""Attributes of apertures."""


def orbits(ring: Any, name: str, _: Any) -> Any:
    """Refuse a Lattice, which has no orbits: the arrays of its tracking are taken as they are."""
    raise TypeError(
        f"{name} must be the result of tracking, (6, particles, 1, turns), got {type(ring).__name__} of PyAT. Use "
        "ring.track(rays, nturns=4096)[0]."
    )


def lattice(ring: Any) -> str:
    """Return the map of one turn of a Lattice, on momentum, as a text."""
    if not hasattr(ring, "energy"):
        raise TypeError(f"text must be a Lattice of PyAT, got {type(ring).__name__}")
    told([e.FamName for e in ring if any(hasattr(e, entry) for entry in LIMITS)])
    return turn(_part(ring, element) for element in ring if not element.PassMethod.startswith("Aperture"))


def _part(ring: Any, element: Any) -> Any:
    """Return an element as a kick or a linear part; a ValueError names one that is neither."""
    kind = type(element).__name__
    element = element.deepcopy()
    for entry in LIMITS[1:]:
        element.__dict__.pop(entry, None)
    kept_momentum(not getattr(element, "longt_motion", False), element.FamName, kind, "ring.disable_6d()")

    def track(points: np.ndarray) -> np.ndarray:
        rays = np.asfortranarray(np.zeros((6, points.shape[1])))
        rays[ROWS] = points
        element.track(rays, in_place=True, energy=ring.energy, particle=ring.particle)
        return rays[ROWS]

    if element.PassMethod == "ThinMPolePass" and not np.any(getattr(element, "BendingAngle", 0.0)):
        return compared(Kick(_strengths(element.PolynomB), _strengths(element.PolynomA)), track, element.FamName, kind)
    thick = higher(element) if kind == "Dipole" else []
    return probed(track, element.FamName, kind, kind == "Dipole", KICKS if thick else CUT, thick)


def _strengths(coefficients: Sequence[float]) -> tuple[float, ...]:
    """Return knl of coefficients of the plain powers (x + iy)^n."""
    return tuple(float(entry) * math.factorial(n) for n, entry in enumerate(coefficients))
