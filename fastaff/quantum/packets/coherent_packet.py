"""Coherent states of a body at a phase point, over symmetry classes or in one of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.docstrings import inserts_parameters
from ...core.numbers import shown, whole
from ...results.progress import says_progress
from ...runs.interruptible import interruptible
from ...runs.requirements import checked_system, phase_points
from ...systems.models import Body
from ..states.quadrature import resolved
from ..states.symmetry import SymmetryClass, action_quantum, checked_class
from .packet import Packet
from .projected_packet import class_states, fraction, holding, kept_packet

FINEST = 4000
"""Most nodes along the radius of a plane."""

WORK = 1e5
"""Most angles beside as many nodes."""

CLASSES = 4000
"""Most symmetry classes of a packet."""
REACH = 12.0
"""Standard deviations at which a Gaussian has ended: e^-36 of its maximum."""


@says_progress
@inserts_parameters
def coherent_packet(
    model: Body,
    z0: ArrayLike,
    *,
    width: ArrayLike,
    count: int,
    hbar: float = 1.0,
    m: int | None = None,
    l: int | None = None,
    missing: float = 1e-6,
) -> Packet:
    """Expand the coherent state at a phase point in states of all symmetry classes, or of one.

    Parameters
    ----------
    {body}
    z0 : array_like, shape (8,)
        Centre: a1, a2, b1, b2, then their momenta.
    width : float or array_like, shape (2,)
        Standard deviation of ``|Psi|^2`` in each direction of position, positive, one number or one for each of the
        planes a and b. sqrt(hbar/(2 mu omega)) keeps its shape in a harmonic body.
    {class_count}
    {hbar}
    m, l : int, optional
        Quantum numbers of one symmetry class, best those next to p_phi/hbar and p_psi/hbar of `z0`. The packet is
        normalised in it. Default: all classes that the packet needs.
    missing : float, default 1e-6
        Largest part of the packet that the states may lack, including the classes left out.

    Returns
    -------
    Packet
        The packet.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the centre is outside of the domain of the body, an argument has a wrong value, or more than `missing` is
        lost. The message then has a sufficient number of levels.
    NoGroundState
        If the energy is unbounded below or the body does not bind that many levels.

    Notes
    -----
    - Psi ~ exp(-``|q - q0|^2``/(4 width^2) + i p0.(q - q0)/hbar) in R^4.
    - Method: harmonics e^(i k eta + i k' gamma) by sums over equal angles, exact to round-off, on the grid of
      `projected_packet`.
    - Cost: seconds for some 100 classes.

    References
    ----------
    Heller 1975, J. Chem. Phys. 62, 1544 (Gaussian packets); Martens & Slawianowski, EQ4.3 (the states).

    Examples
    --------
    >>> body, z0 = fa.Body(fa.Harmonic()), [1.2, 0.1, 0.4, 0.0, 0.1, 0.6, 0.1, 0.2]
    >>> packet = fa.quantum.coherent_packet(body, z0, width=0.5**0.5, m=0, l=0, count=30)
    >>> packet.missing < 1e-6, abs(packet.autocorrelation(np.pi)).round(6)
    (True, np.float64(1.0))
    """
    z = phase_points("z0", z0, checked_system(model, needs="H = T(p) + V(q)"))
    tolerance = fraction(missing)
    if z.shape[1] != 1:
        raise ValueError(f"z0 must be one phase point of shape (8,), got {z.shape[1]}")
    sides = plane_widths(width)
    quantum = action_quantum(hbar)
    planes = [PlaneGaussian(z[2 * i : 2 * i + 2, 0], z[4 + 2 * i : 6 + 2 * i, 0], sides[i], quantum) for i in (0, 1)]
    if (m is None) != (l is None):
        raise ValueError(f"m and l must be given both or neither, got m = {shown(m)}, l = {shown(l)}")
    if m is None:  # classes of a Gaussian distribution
        _check_classes(math.prod(gaussian.spread for gaussian in planes), quantum)
    quanta = [interruptible(gaussian.probabilities) for gaussian in planes]
    if m is not None and l is not None:
        one = checked_class(m, l)
        chosen = [one]
        share = math.prod(found.get(k, 0.0) for found, k in zip(quanta, _turns(one), strict=True))
        if share < 1e-12:
            means = [round(float(np.average(list(found), weights=list(found.values()))), 2) + 0.0 for found in quanta]
            raise ValueError(
                f"m and l must be of a class of the packet, got {share:.2g} of it in m = {m}, l = {l}. Try (m - l)/2 "
                f"= {means[0]}, (m + l)/2 = {means[1]}."
            )
    else:
        chosen = _likeliest(quanta, 0.1 * tolerance)
        share = 1.0
        _check_classes(len(chosen), quantum)

    def build(count: int) -> Packet:
        groups = class_states(model, chosen, count, hbar, True)
        tables, grid = resolved(groups)
        needed = [sorted({_turns(symmetry)[i] for symmetry in chosen}) for i in (0, 1)]
        parts = [gaussian.harmonics(radii, k) for gaussian, radii, k in zip(planes, grid.radii, needed, strict=True)]
        rows = []
        for symmetry, table in zip(chosen, tables, strict=True):
            first, second = (part[needed[i].index(_turns(symmetry)[i])] for i, part in enumerate(parts))
            rows.append(table.integrals(grid.weights * first * second))
        states = [state for group in groups for state in group]
        return kept_packet(states, np.concatenate(rows) / math.sqrt(share), hbar, tolerance)

    return holding(build, whole("count", count, 1), tolerance)


class PlaneGaussian(NamedTuple):
    """A Gaussian of one plane, (2 pi width^2)^(-1/2) exp(-|q - centre|^2/(4 width^2) + i momentum.(q -
    centre)/hbar).
    """

    centre: np.ndarray
    momentum: np.ndarray
    width: float
    hbar: float

    @property
    def spread(self) -> float:
        """The standard deviation of the angular momentum of the plane, in hbar."""
        return math.hypot(
            math.hypot(*self.centre) / (2 * self.width), math.hypot(*self.momentum) * self.width / self.hbar
        )

    def harmonics(self, radius: np.ndarray, k: Sequence[int]) -> np.ndarray:
        """Return the parts f_k (k, ...) of sum over k of f_k(radius) e^(i k angle)."""
        flat = radius.reshape(-1)
        near = np.flatnonzero(np.abs(flat - np.hypot(*self.centre)) < REACH * self.width)
        out = np.zeros((len(k), flat.size), complex)
        angles = 2 * np.pi * np.arange(self._angles(max(map(abs, k)))) / self._angles(max(map(abs, k)))
        turns = np.exp(-1j * np.multiply.outer(angles, k)) / angles.size
        for some in np.array_split(near, max(near.size * angles.size // (1 << 18), 1)):
            out[:, some] = (self._values(flat[some], angles) @ turns).T
        return out.reshape(len(k), *radius.shape)

    def probabilities(self) -> dict[int, float]:
        """Return the probability of each angular momentum k (in hbar) of the plane, down to 1e-15."""
        from scipy.special import roots_legendre

        far = np.hypot(*self.centre)
        lo = max(far - REACH * self.width, 0.0)
        hi = far + REACH * self.width
        waves = 96 + (hi - lo) * np.hypot(*self.momentum) / self.hbar
        count = self._angles(0)
        if not max(waves * WORK, waves * count) <= WORK * FINEST:
            raise ValueError(
                f"width = {self.width:g} requires {waves:.2g} radii and {count:.2g} angles of a plane, more than "
                f"{FINEST} and {WORK:.0e}. Try one nearer to sqrt(hbar) = {self.hbar**0.5:.3g}."
            )
        t, w = roots_legendre(int(waves))
        radius = lo + (hi - lo) * (1 + t) / 2
        parts = np.fft.fft(self._values(radius, 2 * np.pi * np.arange(count) / count), axis=1) / count
        share = np.pi * (hi - lo) * (w * radius) @ np.abs(parts) ** 2
        orders = np.fft.fftfreq(count, 1 / count).round().astype(int)
        return {int(k): float(p) for k, p in zip(orders, share, strict=True) if p > 1e-15}

    def _angles(self, k: int) -> int:
        """Return a number of angles that resolves all harmonics with a weight."""
        far = np.hypot(*self.centre)
        rate = far / (2 * self.width**2) + np.hypot(*self.momentum) / self.hbar
        return 2 * (int((far + REACH * self.width) * rate) + k + 32)

    def _values(self, radius: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Return the Gaussian (radii, angles)."""
        steps = [
            np.multiply.outer(radius, turn(angles)) - q for turn, q in zip((np.cos, np.sin), self.centre, strict=True)
        ]
        square = -(steps[0] ** 2 + steps[1] ** 2) / (4 * self.width**2)
        phase = (self.momentum[0] * steps[0] + self.momentum[1] * steps[1]) / self.hbar
        return np.exp(square + 1j * phase) / math.sqrt(2 * math.pi * self.width**2)


def _check_classes(needed: float, quantum: float) -> None:
    if needed > CLASSES:
        raise ValueError(
            f"width must be nearer to sqrt(hbar) = {quantum**0.5:.3g}: the packet requires {needed:.0f} symmetry "
            f"classes or more, above {CLASSES}. Try m and l, one class."
        )


def _likeliest(quanta: list[dict[int, float]], missing: float) -> list[SymmetryClass]:
    """Return the classes of two planes that together hold all but `missing`, the likeliest first."""
    first, second = (np.array([list(found), list(found.values())]) for found in quanta)
    share = np.multiply.outer(first[1], second[1])
    order = np.argsort(-share, axis=None)
    needed = int(np.searchsorted(np.cumsum(share.ravel()[order]), 1 - missing)) + 1
    i, j = np.unravel_index(order[:needed], share.shape)
    eta = first[0][i].astype(int)
    gamma = second[0][j].astype(int)
    return [SymmetryClass(int(g + e), int(g - e)) for e, g in zip(eta, gamma, strict=True)]


def _turns(symmetry: SymmetryClass) -> tuple[int, int]:
    """Return the angular momenta of the planes a and b with their signs."""
    return (symmetry.m - symmetry.l) // 2, (symmetry.m + symmetry.l) // 2


def plane_widths(width: ArrayLike) -> tuple[float, float]:
    """Return the widths of coherent states in the planes a and b from one positive number or two; raises ValueError or
    TypeError for others. Of each plane

        Psi(q) = (2 pi width^2)^(-1/2) exp(-|q - q0|^2/(4 width^2) + i p0.(q - q0)/hbar):

    width is the standard deviation of |Psi|^2 in each direction of position, hbar/(2 width) that in each of momentum.
    """
    widths = checked("width", width, ())
    if widths.shape not in ((), (2,)) or not np.all(widths > 0):
        raise ValueError(f"width must be one or two positive numbers, got {shown(width)}")
    if np.any((widths < 1e-100) | (widths > 1e100)):
        raise ValueError(f"width must lie between 1e-100 and 1e100, got {shown(width)}")
    first, second = np.broadcast_to(widths, (2,)).tolist()
    return first, second
