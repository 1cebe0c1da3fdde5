"""The number of levels of a symmetry class below an energy, from its classical phase space."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.docstrings import inserts_parameters
from ...core.numbers import kind_of
from ...results.progress import says_progress
from ...runs.requirements import checked_system
from ...systems.models import Body
from ..solvers.cover import Cover, plane_cover
from ..solvers.panels import DENSE, Panels, panels
from ..solvers.singular_ends import potential
from ..states.symmetry import action_quantum, checked_class

CHUNK = 48
"""Energies done at once: the largest arrays have CHUNK*ORDER*SCAN numbers, 3 MB."""
ORDER = 56
"""Gauss nodes between turning points, in either direction."""
LINES = 24
"""Rays and circles along which narrow features are sought."""

PANELS = 60
"""Largest number of panels in each direction."""

SCAN = 128
"""Radii on which a ray is searched for turning points, in equal steps of the logarithm."""


RADII = np.geomspace(1e-4, 1e4, 800)
"""Radii of the tables."""

ANGLES = np.pi / 4 * (1 - np.cos(np.pi * (np.arange(400) + 0.5) / 400))
"""Angles of the tables."""


class _Well(NamedTuple):
    """The effective potential of a class, V + (p_eta/alpha)^2/2 mu + (p_gamma/beta)^2/2 mu, on rays alpha + i beta =
    rho e^(i theta).

    theta, low: angles, dense at both ends, and the smallest value on these rays; reach: radii within which it is below
    the top energy; breaks: radii, and angles, at which integrals are cut where V has narrow features, and radii at
    which these are looked for.
    """

    model: Any
    p_eta: float
    p_gamma: float
    theta: np.ndarray = np.empty(0)
    low: np.ndarray = np.empty(0)
    reach: tuple[float, float] = (0.0, 0.0)
    breaks: tuple[np.ndarray, np.ndarray] = (np.empty(0), np.empty(0))
    scan: np.ndarray = np.empty(0)

    def value(self, rho: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """Return it, +inf where the potential does not live."""
        A = (rho * np.cos(theta)) ** 2
        B = (rho * np.sin(theta)) ** 2
        with np.errstate(all="ignore"):
            V = potential(self.model, A, B)
            for square, p in ((A, self.p_eta), (B, self.p_gamma)):
                V = V + p * p / (2 * self.model.mu * square) if p else V
        return V


def _well(model: Any, p_eta: float, p_gamma: float, top: float, features: tuple[Panels, Panels] | None = None) -> _Well:
    """Return the well of a class with its tables for energies up to `top`; features: those of the body, if known."""
    well = _Well(model, p_eta, p_gamma)
    rho = RADII
    theta = ANGLES
    radii, angles = _features(model, top) if features is None else features
    theta = np.union1d(theta, angles.points.ravel()) if angles.needed > ORDER else theta
    rho = np.union1d(rho, radii.points.ravel()) if radii.needed > ORDER else rho
    value = well.value(rho[:, None], theta)
    allowed = np.flatnonzero((value < top).any(axis=1))
    if allowed.size and allowed[-1] == rho.size - 1:
        raise ValueError(f"the potential must bind at the energy {top:.6g}: the allowed region is not bounded")
    reach = (rho[max(allowed[0] - 1, 0)], rho[allowed[-1] + 1]) if allowed.size else (0.0, 0.0)
    best = np.clip(np.argmin(value, axis=0), 1, rho.size - 2)
    index = np.arange(theta.size)
    y0 = value[best - 1, index]
    y1 = value[best, index]
    y2 = value[best + 1, index]
    with np.errstate(all="ignore"):
        parabola = y1 - (y2 - y0) ** 2 / (8 * (y0 - 2 * y1 + y2))
    low = np.where(np.isfinite(parabola) & (y1 <= y0) & (y1 <= y2), parabola, value.min(axis=0))
    scan = np.geomspace(reach[0], reach[1], SCAN) if allowed.size else np.empty(0)
    breaks = [part.edges[1:-1] if part.needed > ORDER else np.empty(0) for part in (radii, angles)]
    if breaks[0].size and allowed.size:
        scan = np.union1d(scan, np.clip(radii.points.ravel(), *reach))
    return well._replace(theta=theta, low=low, reach=reach, breaks=(breaks[0], breaks[1]), scan=scan)


def _features(model: Any, top: float) -> tuple[Panels, Panels]:
    """Return partitions of radii and angles that resolve the potential itself, where it is below the top energy."""
    plain = _Well(model, 0.0, 0.0)
    rho = RADII[::4]
    theta = ANGLES[::4]
    V = plain.value(rho[:, None], theta)
    low = float(V.min())
    hidden = _hidden(model, np.isinf(V[:, theta > np.pi / 4]).all(), low, top)
    inside = top > V
    allowed = [rho[inside.any(axis=1)], theta[inside.any(axis=0)]]
    wells = hidden.lo * 0.95, np.minimum(hidden.hi * 1.05, [[np.inf], [np.pi / 2]])  # panels at ends are not refined
    q, v = (np.concatenate([one, *ends]) for one, ends in zip(allowed, zip(*wells)))
    if not q.size:
        return (Panels(np.array([0.0, 1.0]), np.zeros(1)),) * 2
    far = float(q.max())
    lo = float(v.min())
    hi = float(v.max())
    low = float(hidden.low.min(initial=low))
    spread = (np.arange(LINES) * 0.6180339887498949 + 0.31) % 1
    deep = hidden.at[:, np.argsort(hidden.low)[:LINES]]
    rays, circles = (
        np.append(a + (b - a) * spread, at)[:, None] for (a, b), at in zip(((lo, hi), (0.0, far)), deep[::-1])
    )
    thin = np.stack([hidden.lo, hidden.hi], axis=1)
    return (
        panels(lambda q: plain.value(q, rays), 0.0, far, low, top - low, DENSE >> 3, PANELS, thin[0]),
        panels(lambda v: plain.value(circles, v), lo, hi, low, top - low, DENSE >> 3, PANELS, thin[1]),
    )


def _hidden(model: Any, walled: bool, low: float, top: float) -> Cover:
    """Return boxes of radii and angles with wells below the top energy between the points of the tables."""
    kinetic = max(top - low, 1e-3 * abs(top))
    seen = plane_cover(model, (0.0, 0.0), (RADII[0], RADII[-1]), walled, top, kinetic)
    found = seen.unseen([RADII[::4], np.cos(2 * ANGLES[::-4])])
    x = (np.stack([row[0], np.arccos(row[1]) / 2]) for row in (found.lo, found.hi, found.at))
    lo, hi, at = x
    return found._replace(lo=np.stack([lo[0], hi[1]]), hi=np.stack([hi[0], lo[1]]), at=at)


@says_progress
@inserts_parameters
def weyl_count(model: Body, energy: ArrayLike, *, m: int, l: int, hbar: float = 1.0) -> np.ndarray:
    """Compute the smooth number of levels of one symmetry class below given energies.

    Parameters
    ----------
    model : Body
        Affinely-rigid body. Its potential has ``curvatures``.
    energy : float or array_like
        Energies in any order.
    m, l : int
        Quantum numbers of spin and vorticity. For m + l odd, the levels belong to the double cover.
    {hbar}

    Returns
    -------
    ndarray
        Smooth number N of levels, close to k + 1/2 at level k = 0, 1, ... It is 0 below the minimum of the effective
        potential, and can be as low as -1/12 just above it.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the accessible region is not bounded or an argument has a wrong value.

    Notes
    -----
    - N = (mu/2 pi hbar^2) int (E - V_eff)_+ dalpha dbeta plus corrections of order 1 (-1/12 for oscillators). V_eff
      includes (hbar^2/2 mu)(a^2/alpha^2 + b^2/beta^2) with a = ``|m - l|``/2, b = ``|m + l|``/2.
    - Terms of order hbar and oscillating terms are left out.
    - Limits: a potential barrier det phi = 0 and narrow features of V must be smooth on the scale of the wavelength.
      For V = c/distance this is mu c/(hbar p) > 1.
    - Interval bounds find narrow wells if the formula of V supports them.
    - Accuracy: about 1e-6 of N, less at saddle energies.
    - Cost: 20 ms per energy, more if V has narrow features.

    References
    ----------
    Wigner 1932, Phys. Rev. 40, 749, and Kirkwood 1933, Phys. Rev. 44, 31 (order hbar^2); Langer 1937, Phys. Rev. 51,
    669; the terms of fixed angular momenta are derived from H - omega_a L_a - omega_b L_b at imaginary rates.

    Examples
    --------
    >>> fa.quantum.weyl_count(fa.Body(fa.Harmonic()), [4.0, 10.0], m=0, l=0).round(4)
    array([ 1.9167, 12.4167])
    """
    if not checked_system(model, needs="H = T(p) + V(q)").isotropic:
        raise TypeError(f"model must be a Body with a doubly isotropic potential, got {kind_of(model)}")
    if not hasattr(model.potential, "curvatures"):
        raise TypeError(f"model must have a potential with curvatures(A, B), {type(model.potential).__name__} has none")
    chosen = checked_class(m, l, False)
    hbar = action_quantum(hbar, model.mu)
    given = checked("energy", energy, ())
    distinct, where = np.unique(given.ravel(), return_inverse=True)
    count = np.zeros(distinct.size)
    if distinct.size:
        quanta = np.array([chosen.a, chosen.b])
        here, bends = _wells(model, quanta, hbar, float(distinct[-1]))
        for k in range(0, distinct.size, CHUNK):
            count[k : k + CHUNK] = _count(distinct[k : k + CHUNK], here, bends, hbar)
    return count[where].reshape(given.shape)[()]


def _wells(model: Any, quanta: np.ndarray, hbar: float, top: float) -> tuple[_Well, list[tuple[int, float, _Well]]]:
    """Return the well of a class, and those of d^2/da^2 and d^2/db^2: row of the integral, weight, well.

    By differences of dN/da = -(a/2 pi) int dalpha dbeta/alpha^2 over half a quantum to either side; at 0, where N has a
    kink in the sign of a, to the right alone.
    """
    top = top + 1e-3 * abs(top)
    features = _features(model, top)
    bends = []
    for which in (0, 1):
        sided = quanta[which] >= 1
        offsets, weights = ((-0.5, 0.5), (-1.0, 1.0)) if sided else ((0.5, 1.0, 1.5), (-5.0, 8.0, -3.0))
        for offset, weight in zip(offsets, weights, strict=True):
            moved = quanta.copy()
            moved[which] += offset
            well = _well(model, hbar * moved[0], hbar * moved[1], top, features)
            bends.append((1 + which, -weight * moved[which] / (2 * np.pi), well))
    return _well(model, hbar * quanta[0], hbar * quanta[1], top, features), bends


def _count(energy: np.ndarray, well: _Well, bends: list[tuple[int, float, _Well]], hbar: float) -> np.ndarray:
    bottom = float(well.low.min())
    step = 1e-3 * np.maximum(energy - bottom, 0.0)
    volume = _integrals(well, energy)[0]
    stiffness = (_integrals(well, energy + step)[3] - _integrals(well, energy - step)[3]) / np.where(
        step > 0, 2 * step, 1.0
    )
    bend = sum(weight * _integrals(other, energy)[row] for row, weight, other in bends)
    total = well.model.mu / (2 * np.pi * hbar**2) * volume - bend / 12 - stiffness / (48 * np.pi)
    return np.where(energy > bottom, total, 0.0)


def _integrals(well: _Well, energy: np.ndarray) -> np.ndarray:
    """Return the integrals (4, energies) of E - V, 1/alpha^2, 1/beta^2 and Delta V over dalpha dbeta where V_eff <
    E.
    """
    n, first, last = _intervals(well.low < energy[:, None])
    total = np.zeros((4, energy.size))
    if n.size == 0 or well.reach[1] == 0.0:
        return total
    ends = [_crossing(well, k, step, energy[n], edge) for k, step, edge in ((first, -1, 0.0), (last, 1, np.pi / 2))]
    n, lo, hi = _cut(n, ends[0], ends[1], well.breaks[1])
    t, w = np.polynomial.legendre.leggauss(ORDER)
    half = np.pi / 2 * (1 + t)  # theta = lo + (hi - lo) sin^2(half/2): roots at the ends become analytic
    span = (hi - lo)[:, None]
    rays = (lo[:, None] + span * np.sin(half / 2) ** 2).ravel()
    weights = (np.pi / 4 * w * np.sin(half) * span).ravel()
    owner = np.repeat(n, ORDER)
    ray, lo, hi = _cut(*_turning(well, rays, energy[owner]), well.breaks[0])
    rho = ((hi + lo) / 2)[:, None] + ((hi - lo) / 2)[:, None] * t
    angle = rays[ray, None]
    area = weights[ray, None] * ((hi - lo) / 2)[:, None] * w * rho
    A = (rho * np.cos(angle)) ** 2
    B = (rho * np.sin(angle)) ** 2
    V_A, V_B = well.model.potential.slopes(A, B)
    V_AA, _, V_BB = well.model.potential.curvatures(A, B)
    room = energy[owner[ray], None] - well.value(rho, angle)
    rows = (room, 1 / A, 1 / B, 4 * (V_A + A * V_AA + V_B + B * V_BB))
    for row, values in enumerate(rows):
        total[row] += np.bincount(owner[ray], (area * values).sum(axis=1), energy.size)
    return total


def _cut(
    owner: np.ndarray, lo: np.ndarray, hi: np.ndarray, breaks: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return intervals (lo, hi) of owners cut at all breaks inside of them."""
    if not breaks.size:
        return owner, lo, hi
    edges = np.clip(np.append(np.append(-np.inf, breaks), np.inf), lo[:, None], hi[:, None])
    piece, place = np.nonzero(np.diff(edges, axis=1) > 0)
    return owner[piece], edges[piece, place], edges[piece, place + 1]


def _intervals(inside: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return row, first and last index of every run of True in the rows."""
    edge = np.zeros((inside.shape[0], 1), bool)
    row, first = np.nonzero(inside & ~np.hstack([edge, inside[:, :-1]]))
    _, last = np.nonzero(inside & ~np.hstack([inside[:, 1:], edge]))
    return row, first, last


def _crossing(well: _Well, inside: np.ndarray, step: int, energy: np.ndarray, edge: float) -> np.ndarray:
    """Return the angles where the smallest value on rays crosses the energy next to the index `inside`; the edge where
    it never does.

    By bisection: next to a wall the angles of the table are far apart, and interpolation between them would miss most
    of Delta V.
    """
    out = inside + step
    natural = (out < 0) | (out >= well.theta.size)
    near = well.theta[inside]
    far = well.theta[np.where(natural, inside, out)]
    for _ in range(30):
        middle = (near + far) / 2
        allowed = _lowest(well, middle) < energy
        near = np.where(allowed, middle, near)
        far = np.where(allowed, far, middle)
    return np.where(natural, edge, near)


def _lowest(well: _Well, rays: np.ndarray) -> np.ndarray:
    """Return the smallest value on rays, by a scan and golden sections."""
    rho = well.scan
    best = np.argmin(well.value(rho, rays[:, None]), axis=1)
    left = rho[np.maximum(best - 1, 0)]
    right = rho[np.minimum(best + 1, rho.size - 1)]
    for _ in range(24):
        c = left + 0.381966011250105 * (right - left)
        d = right - 0.381966011250105 * (right - left)
        lower = well.value(c, rays) < well.value(d, rays)
        left = np.where(lower, left, c)
        right = np.where(lower, d, right)
    return well.value((left + right) / 2, rays)


def _turning(well: _Well, rays: np.ndarray, energy: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the allowed intervals of every ray: ray numbers, lower and upper radii, to rounding."""
    rho = np.repeat(well.scan[None], rays.size, axis=0)
    value = well.value(rho, rays[:, None])
    # The bottom of every ray goes into the scan, so that no narrow interval hides between two radii.
    best = np.argmin(value, axis=1)
    index = np.arange(rays.size)
    left = rho[index, np.maximum(best - 1, 0)]
    right = rho[index, np.minimum(best + 1, rho.shape[1] - 1)]
    for _ in range(18):
        c = left + 0.381966011250105 * (right - left)
        d = right - 0.381966011250105 * (right - left)
        lower = well.value(c, rays) < well.value(d, rays)
        left = np.where(lower, left, c)
        right = np.where(lower, d, right)
    middle = (left + right) / 2
    deepest = well.value(middle, rays)
    lower = deepest < value[index, best]
    rho[index, best] = np.where(lower, middle, rho[index, best])
    value[index, best] = np.where(lower, deepest, value[index, best])
    ray, first, last = _intervals(value < energy[:, None])
    ends = []
    for inside, step in ((first, -1), (last, 1)):
        near = rho[ray, inside]
        far = rho[ray, np.clip(inside + step, 0, rho.shape[1] - 1)]
        far = np.where(near == far, 0.0, far)  # no motion turns back before rho = 0
        for _ in range(34):
            middle = (near + far) / 2
            deep = well.value(middle, rays[ray]) < energy[ray]
            near = np.where(deep, middle, near)
            far = np.where(deep, far, middle)
        ends.append(near)
    return ray, ends[0], ends[1]
