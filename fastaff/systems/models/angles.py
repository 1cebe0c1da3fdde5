"""Angle variables whose mean rates are the fundamental frequencies.

Each degree of freedom k gives a pair (Q_k, P_k) of real or complex functions of the phase point. The angle is that of
the loop

    f_k = Q_k - c_k - i kappa_k P_k,        positive for q = cos(omega t), p = -omega sin(omega t),

with a centre c_k and a scale kappa_k for each orbit. The functions are smooth on the whole phase space (no chart
singularity: beta may pass through 0). For the planes, Q and P are complex, c = 0 and the sign of kappa is that of p_eta
= Im(conj(Q) P), so |f|^2 = |Q|^2 + kappa^2 |P|^2 + 2 |kappa p_eta| never vanishes: arg f has exactly the mean rate of
eta = arg a and stays smooth where eta itself turns in jumps (p_eta near 0). Likewise for b and gamma.

`signals(z)` gives Re Q, Im Q, Re P, Im P of each angle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class _DeformationLoops:
    """Common part of sets of loops in two combinations of A = alpha^2, B = beta^2; `deformation_loops` attaches it."""

    planes = False, False, True, True
    """Which angles are those of a plane."""

    def signals(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        q, r = self.mix(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)
        s, t = self.mix(a1 * pa1 + a2 * pa2, b1 * pb1 + b2 * pb2)
        zero = 0.0 * q
        return q, zero, s, zero, r, zero, t, zero, a1, a2, pa1, pa2, b1, b2, pb1, pb2


def deformation_loops(cls):
    """Complete a NamedTuple class into a set of angles: two loops in Q = mix(A, B), P = mix(alpha p_alpha, beta
    p_beta), and the planes.

    `mix` is linear. A NamedTuple cannot inherit, so the methods are attached.
    """
    for name in ("planes", "signals"):
        setattr(cls, name, vars(_DeformationLoops)[name])
    return cls


@deformation_loops
class AlphaBeta(NamedTuple):
    """Loops in (alpha^2, alpha p_alpha), (beta^2, beta p_beta), and the planes a and b.

    For bodies that separate in (alpha, beta): EQ3.1, EQa of Martens & Slawianowski.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("alpha", "beta", "eta", "gamma")

    def mix(self, A, B):
        """Return the two combinations that the loops are in."""
        return A, B


@deformation_loops
class AreaTrace(NamedTuple):
    """Loops in (D1 D2, its rate), (r = D1^2 + D2^2, its rate), and the planes a and b.

    For bodies that separate in no chart and resist changes of area and of shape differently, such as the neo-Hookean
    one. Beyond the paper.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("area", "r", "eta", "gamma")

    def mix(self, A, B):
        """Return the two combinations that the loops are in."""
        return A - B, A + B


class RVartheta(NamedTuple):
    """Loops in (r, its rate), (-cos vartheta, r times its rate), and the planes a/sqrt(r), b/sqrt(r).

    For bodies that separate in (r, vartheta): EQ2.2h and the heavy top of Martens & Slawianowski.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("r", "vartheta", "eta", "gamma")

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane."""
        return (False, False, True, True)

    def signals(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        A = a1 * a1 + a2 * a2
        B = b1 * b1 + b2 * b2
        s = a1 * pa1 + a2 * pa2
        t = b1 * pb1 + b2 * pb2
        r = A + B
        w = 1.0 / r
        root = np.sqrt(r)
        v = 1.0 / root
        zero = 0.0 * A
        g1 = v * a1
        g2 = v * a2
        h1 = v * b1
        h2 = v * b2
        return (
            (r, zero, s + t, zero)
            + (w * (B - A), zero, w * (A * t - B * s), zero)
            + (g1, g2, root * pa1 - g1 * (s + t), root * pa2 - g2 * (s + t))
            + (h1, h2, root * pb1 - h1 * (s + t), root * pb2 - h2 * (s + t))
        )


class Coordinates2(NamedTuple):
    """Loops in the coordinate planes (x, px), (y, py) of a system of two degrees of freedom."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("x", "y")

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane."""
        return (False, False)

    def signals(self, x, y, px, py):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        zero = 0.0 * x
        return x, zero, px, zero, y, zero, py, zero


class Polar(NamedTuple):
    """Loop in (R, its rate) and the plane (x, y) of a system of two degrees of freedom with unit masses: nu_R, nu_phi.

    For motion about the centre of a galactic disk, with velocities as momenta. nu_phi is the mean rate of the azimuth,
    negative for clockwise motion. For an orbit that does not go around the centre use loops in x and y: its angles may
    have another basis. In a bar nu_R is that of a line that phi does not drive.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("R", "phi")

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane."""
        return (False, True)

    def signals(self, x, y, px, py):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        R = np.sqrt(x * x + y * y)
        zero = 0.0 * x
        return R, zero, (x * px + y * py) / R, zero, x, y, px, py


class Cylindrical(NamedTuple):
    """Loops in (R, its rate) and (z, its rate), and the plane (x, y), of a system of three degrees of freedom with unit
    masses: nu_R, nu_z, nu_phi.

    For motion about the axis of a galaxy, as `Polar`.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("R", "z", "phi")

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane."""
        return (False, False, True)

    def signals(self, x, y, z, px, py, pz):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        R = np.sqrt(x * x + y * y)
        zero = 0.0 * x
        return R, zero, (x * px + y * py) / R, zero, z, zero, pz, zero, x, y, px, py
