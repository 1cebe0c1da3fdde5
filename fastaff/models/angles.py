"""Angle variables whose mean rates are the fundamental frequencies.

Each degree of freedom k gives a pair (Q_k, P_k) of real or complex functions of the phase point. The angle is that of
the loop

    f_k = Q_k - c_k - i kappa_k P_k,        positive for q = cos(omega t), p = -omega sin(omega t),

with a centre c_k and a scale kappa_k of each orbit's own. The functions are smooth on the whole phase space (no chart
singularity: beta may pass through 0). For the planes, Q and P are complex, c = 0 and the sign of kappa is that of p_eta
= Im(conj(Q) P), so |f|^2 = |Q|^2 + kappa^2 |P|^2 + 2 |kappa p_eta| never vanishes: arg f has exactly the mean rate of
eta = arg a and stays smooth where eta itself turns in jumps (p_eta near 0). Likewise for b and gamma.

A set of angles may have a clock of its own, d(clock)/dt = rate(z) > 0. In r, vartheta the motion of everything but r is
a closed system in the clock dtau = dt/r, and r is one in t. So the mean rate in tau, times the mean of 1/r in t, is an
average over one periodic motion each: no small divisors, while the same angle averaged over t has those of all
combinations of nu_r and nu_vartheta.

`signals(z)` gives Re Q, Im Q, Re P, Im P of each angle; `rates(z, dz)` the same followed by their derivatives, for each
angle, then the rate of the clock and its derivative.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class _DeformationLoops:
    """What sets of loops in two combinations of A = alpha^2 and B = beta^2 share; `deformation_loops` attaches it."""

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane."""
        return (False, False, True, True)

    @property
    def clocks(self) -> tuple[int, ...]:
        """1 where an angle is averaged over the clock instead of time: none."""
        return (0, 0, 0, 0)

    def signals(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        q, r = self.mix(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)
        s, t = self.mix(a1 * pa1 + a2 * pa2, b1 * pb1 + b2 * pb2)
        zero = 0.0 * q
        return q, zero, s, zero, r, zero, t, zero, a1, a2, pa1, pa2, b1, b2, pb1, pb2

    def rates(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2, da1, da2, db1, db2, dpa1, dpa2, dpb1, dpb2):
        """Return each angle's signals and their derivatives, then 1, 0: the clock is time."""
        q, z, s, z, r, z, t, z, a1, a2, pa1, pa2, b1, b2, pb1, pb2 = self.signals(a1, a2, b1, b2, pa1, pa2, pb1, pb2)
        dq, dr = self.mix(2 * (a1 * da1 + a2 * da2), 2 * (b1 * db1 + b2 * db2))
        ds, dt = self.mix(da1 * pa1 + da2 * pa2 + a1 * dpa1 + a2 * dpa2, db1 * pb1 + db2 * pb2 + b1 * dpb1 + b2 * dpb2)
        return (
            (q, z, s, z, dq, z, ds, z)
            + (r, z, t, z, dr, z, dt, z)
            + (a1, a2, pa1, pa2, da1, da2, dpa1, dpa2)
            + (b1, b2, pb1, pb2, db1, db2, dpb1, dpb2)
            + (1.0 + z, z)
        )


def deformation_loops(cls):
    """Complete a NamedTuple class into a set of angles: two loops in Q = mix(A, B), P = mix(alpha p_alpha, beta
    p_beta), and the planes.

    `mix` is linear; all angles are averaged over time. A NamedTuple cannot inherit, so the methods are attached.
    """
    for name in ("planes", "clocks", "signals", "rates"):
        setattr(cls, name, vars(_DeformationLoops)[name])
    return cls


@deformation_loops
class AlphaBeta(NamedTuple):
    """Loops in (alpha^2, alpha p_alpha), (beta^2, beta p_beta), and the planes a and b; all averaged over time.

    Free of small divisors for bodies that separate in (alpha, beta): EQ3.1, EQa of Martens & Slawianowski.
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
    """Loops in (D1 D2, its rate), (r = D1^2 + D2^2, its rate), and the planes a and b; all averaged over time.

    For bodies that separate nowhere and resist changes of area and of shape differently, such as the neo-Hookean one.
    Beyond the paper.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("area", "r", "eta", "gamma")

    def mix(self, A, B):
        """Return the two combinations that the loops are in."""
        return A - B, A + B


class RVartheta(NamedTuple):
    """Loops in (r, its rate), (-cos vartheta, its rate in tau), and the planes a/sqrt(r), b/sqrt(r), with the clock
    dtau = dt/r.

    Free of small divisors for bodies that separate in (r, vartheta): EQ2.2h and the heavy top of Martens &
    Slawianowski.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("r", "vartheta", "eta", "gamma")

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane."""
        return (False, False, True, True)

    @property
    def clocks(self) -> tuple[int, ...]:
        """1 where an angle is averaged over the clock instead of time."""
        return (0, 1, 1, 1)

    def signals(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        A, B = a1 * a1 + a2 * a2, b1 * b1 + b2 * b2
        s, t = a1 * pa1 + a2 * pa2, b1 * pb1 + b2 * pb2
        r = A + B
        w, root = 1.0 / r, np.sqrt(r)
        v = 1.0 / root
        zero = 0.0 * A
        g1, g2, h1, h2 = v * a1, v * a2, v * b1, v * b2
        return (
            (r, zero, s + t, zero)
            + (w * (B - A), zero, w * (A * t - B * s), zero)
            + (g1, g2, root * pa1 - g1 * (s + t), root * pa2 - g2 * (s + t))
            + (h1, h2, root * pb1 - h1 * (s + t), root * pb2 - h2 * (s + t))
        )

    def rates(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2, da1, da2, db1, db2, dpa1, dpa2, dpb1, dpb2):
        """Return each angle's signals and their derivatives, then 1/r and its derivative."""
        r, z, u, z, x, z, y, z, g1, g2, G1, G2, h1, h2, H1, H2 = self.signals(a1, a2, b1, b2, pa1, pa2, pb1, pb2)
        A, B = a1 * a1 + a2 * a2, b1 * b1 + b2 * b2
        s, t = a1 * pa1 + a2 * pa2, b1 * pb1 + b2 * pb2
        dA, ds = 2 * (a1 * da1 + a2 * da2), da1 * pa1 + da2 * pa2 + a1 * dpa1 + a2 * dpa2
        dB, dt = 2 * (b1 * db1 + b2 * db2), db1 * pb1 + db2 * pb2 + b1 * dpb1 + b2 * dpb2
        w, root, dr, du = 1.0 / r, np.sqrt(r), dA + dB, ds + dt
        v, e = 1.0 / root, 0.5 * w * (dA + dB)
        dg1, dg2, dh1, dh2 = v * da1 - e * g1, v * da2 - e * g2, v * db1 - e * h1, v * db2 - e * h2
        c = root * e
        return (
            (r, z, u, z, dr, z, du, z)
            + (x, z, y, z, w * (dB - dA - x * dr), z, w * (dA * t + A * dt - dB * s - B * ds - y * dr), z)
            + (g1, g2, G1, G2, dg1, dg2)
            + (root * dpa1 + c * pa1 - dg1 * u - g1 * du, root * dpa2 + c * pa2 - dg2 * u - g2 * du)
            + (h1, h2, H1, H2, dh1, dh2)
            + (root * dpb1 + c * pb1 - dh1 * u - h1 * du, root * dpb2 + c * pb2 - dh2 * u - h2 * du)
            + (w, -w * w * dr)
        )


class Coordinates2(NamedTuple):
    """Loops in the coordinate planes (x, px), (y, py) of a system of two degrees of freedom; averaged over time."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the angles."""
        return ("x", "y")

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane."""
        return (False, False)

    @property
    def clocks(self) -> tuple[int, ...]:
        """1 where an angle is averaged over the clock instead of time."""
        return (0, 0)

    def signals(self, x, y, px, py):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        zero = 0.0 * x
        return x, zero, px, zero, y, zero, py, zero

    def rates(self, x, y, px, py, dx, dy, dpx, dpy):
        """Return each angle's signals and their derivatives, then 1, 0: the clock is time."""
        z = 0.0 * x
        return x, z, px, z, dx, z, dpx, z, y, z, py, z, dy, z, dpy, z, 1.0 + z, z
