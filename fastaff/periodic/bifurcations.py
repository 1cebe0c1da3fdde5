"""Bifurcations of a family of periodic orbits, where its stability changes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import pairwise
from typing import Annotated, Any

import numpy as np

from ..results.result import Result, along
from .found_orbits import PeriodicOrbits

VANISHING = 1e-5
"""Product of residues up to which a change of its sign is a zero, not a jump."""

NEAR = 1e-10
"""Product at which the search for the zero ends, as nearer to it z is undetermined."""

SAFETY = 4.0
"""Factor of the error of a parameter over its changes by another step and a closer correction."""

CLOSER = 0.01
"""Tolerance of the closer correction."""


class Event(IntEnum):
    """Bifurcation at a point of a branch.

    Attributes
    ----------
    FOLD : 0
        The energy or parameter turns back; a residue passes 0.
    BRANCH_POINT : 1
        A residue passes 0 without a turn (pitchfork, transcritical).
    PERIOD_DOUBLING : 2
        A residue passes 1; an orbit of twice the period branches off.
    NEIMARK_SACKER : 3
        A complex pair of multipliers of an ODE system, or of a map that is not symplectic, passes the unit circle; an
        invariant torus or closed curve branches off.
    """

    FOLD = 0
    BRANCH_POINT = 1
    PERIOD_DOUBLING = 2
    NEIMARK_SACKER = 3


@dataclass(frozen=True)
class Bifurcation(Result, axis=None):
    """Point of a branch at which its stability changes.

    Attributes
    ----------
    event : Event
        Kind of the bifurcation.
    arclength : float
        Arclength of the branch.
    parameter : float
        Energy or parameter.
    z : ndarray, shape (2n,)
        Point of the periodic orbit on the section.
    period : float
        Period in units of time; for a map in iterates.
    error : float
        Error estimate of `parameter`: the half width of the last interval, or the remaining product over its slope,
        plus changes with half the step size and with a closer correction.
    amplitude : ndarray, shape (2n,), or None
        For driven and ODE systems half of the range of each variable over the orbit.
    """

    event: Event
    arclength: float
    parameter: float
    z: Annotated[np.ndarray, along("coordinate")]
    period: float
    error: float
    amplitude: Annotated[np.ndarray | None, along("coordinate")] = None


def residue_products(orbits: PeriodicOrbits) -> np.ndarray:
    """Return the products (orbits, 2) of the residues and of 1 - residue; for multipliers without pairs, the products
    of (1 - multiplier)/2, of (1 + multiplier)/2, which generalise these, and of 1 - the product of two (orbits, 3).
    """
    if not orbits.symplectic:
        values = orbits.multipliers
        i, j = np.triu_indices(len(values), 1)
        factors = (1 - values) / 2, (1 + values) / 2, 1 - values[i] * values[j]
        return np.array([np.prod(factor, axis=0).real for factor in factors]).T
    R = orbits.residues
    return np.array([np.prod(R, axis=0).real, np.prod(1 - R, axis=0).real]).T


def _complex(values: np.ndarray) -> bool:
    """Tell whether the two multipliers whose product is nearest to 1 are a complex pair, no real ones (a saddle)."""
    i, j = np.triu_indices(len(values), 1)
    nearest = np.abs(1 - values[i] * values[j]).argmin()
    return bool(values[i[nearest]].imag != 0)


def bifurcations(family: Any, points: list[Any], arclength: np.ndarray, orbits: PeriodicOrbits) -> list[Bifurcation]:
    """Find the sign changes between neighbouring points of a family of `continuation` and polish them."""
    signs = residue_products(orbits)
    found = []
    for k, (last, following) in enumerate(pairwise(points)):
        turned = last.tangent[-1] * following.tangent[-1] < 0
        for kind in range(signs.shape[1]):
            if not signs[k, kind] * signs[k + 1, kind] < 0:
                continue
            if kind == 2 and np.abs(signs[k : k + 2, kind]).max() < VANISHING:  # rounding, where volumes are kept
                continue
            s, point, product, error = _sign_change(family, last, following, signs[k : k + 2, kind], kind)
            if abs(product) < VANISHING or error > 0.01 * abs(following.u[-1] - last.u[-1]):
                if kind == 2 and not _complex(family.orbits(point).multipliers[:, 0]):
                    continue
                event = (Event.FOLD if turned else Event.BRANCH_POINT, Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER)[
                    kind
                ]
                place = float(arclength[k] + s)
                parameter = float(point.u[-1])
                period = float(point.back.time[0])
                z = point.u[: len(orbits.z)]
                amplitude = family.amplitude(point)
                at: Any = {"z": z, "period": period, "error": error, "amplitude": amplitude}
                found.append(Bifurcation(event, place, parameter, **at))
    return sorted(found, key=lambda b: b.arclength)


def _sign_change(
    family: Any, last: Any, following: Any, ends: np.ndarray, kind: int
) -> tuple[float, Any, float, float]:
    """Find the sign change of a product between two points: (s, the point of the branch there, the product, the error
    of the value).

    False position with the Illinois rule; where the branch cannot be found at a place, others between the ends are
    tried.
    """
    reach = family.distance(last.u, following.u)
    a = 0.0
    b = 1.0
    low = last
    high = following
    side = 0
    weights = [float(end) for end in ends]
    products = [float(end) for end in ends]
    best = min((abs(products[0]), a, last), (abs(products[1]), b, following), key=lambda tried: tried[0])
    for _ in range(60):
        if b - a <= 1e-12 or best[0] <= NEAR:
            break
        share = np.clip(weights[0] / (weights[0] - weights[1]), 1e-3, 1 - 1e-3)
        for place in (share, 0.5, 0.25, 0.75):
            s = a + float(place) * (b - a)
            point = family.corrected(*family.between(last, following, s), last.scale, last.step)
            if point is not None:
                break
        else:
            break
        product = float(family.products(point)[kind])
        best = min(best, (abs(product), s, point), key=lambda tried: tried[0])
        if product * ends[0] > 0:
            weights = [product, weights[1] * (0.5 if side < 0 else 1.0)]
            a = s
            low = point
            products[0] = product
            side = -1
        else:
            weights = [weights[0] * (0.5 if side > 0 else 1.0), product]
            b = s
            high = point
            products[1] = product
            side = 1
    left = abs(float(high.u[-1] - low.u[-1]))
    value = float(best[2].u[-1])
    slope = abs(products[1] - products[0]) / left if left > 0 else np.inf
    # The same place once more, with half the step and closer, shows the errors by steps and corrections.
    exact = family.flow.system.iterated
    finer = replace(family, tolerance=CLOSER * family.tolerance, flow=family.flow if exact else family.flow.finer())
    step = best[2].step if exact else 0.5 * best[2].step
    again = finer.corrected(*family.between(last, following, best[1]), last.scale, step)
    moved = left
    wrong = 0.0
    if again is not None:
        moved = abs(float(again.u[-1]) - value)
        wrong = abs(float(finer.products(again)[kind]) - best[0])
    far = float(family.units[-1] * np.abs(best[2].u[:-1] / family.units[:-1]).max())  # whose digits are lost
    error = min(0.5 * left, (best[0] + wrong) / slope) + SAFETY * (moved + 1e-15 * (abs(value) + far))
    return best[1] * reach, best[2], best[0], error
