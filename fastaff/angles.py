"""Angle variables whose mean rates are the fundamental frequencies (layer L1).

Each degree of freedom k gives a pair (Q_k, P_k) of real or complex functions of the phase point. The angle is that of the loop

    f_k = Q_k - c_k - i kappa_k P_k,        positive for q = cos(omega t), p = -omega sin(omega t),

with a centre c_k and a scale kappa_k of each orbit's own. Functions of |a|^2, |b|^2 and their rates are smooth on the whole phase space
(no chart singularity: beta may pass through 0). For the planes, Q = a1 + i a2, P = pa1 + i pa2, c = 0 and the sign of kappa is that of
p_eta, so |f|^2 = |a|^2 + kappa^2 |p|^2 + 2 |kappa p_eta| never vanishes: arg f has exactly the mean rate of eta = arg a and stays smooth
where eta itself turns in jumps (p_eta near 0). Likewise for b and gamma.
"""

from __future__ import annotations

from typing import NamedTuple


class AlphaBeta(NamedTuple):
    """Loops in (alpha^2, its rate), (beta^2, its rate), and the planes a and b.

    Exact for bodies that separate in (alpha, beta): EQ3.1, EQa of Martens & Slawianowski.
    """

    names = ("alpha", "beta", "eta", "gamma")
    planes = (False, False, True, True)

    def signals(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        A, B = a1 * a1 + a2 * a2, b1 * b1 + b2 * b2
        a_rate, b_rate = a1 * pa1 + a2 * pa2, b1 * pb1 + b2 * pb2
        zero = 0.0 * A
        return A, zero, a_rate, zero, B, zero, b_rate, zero, a1, a2, pa1, pa2, b1, b2, pb1, pb2


class RVartheta(NamedTuple):
    """Loops in (r, its rate), (cos vartheta, r times its rate), and the planes a and b.

    Exact for bodies that separate in (r, vartheta): EQ2.2h and the heavy top of Martens & Slawianowski.
    """

    names = ("r", "vartheta", "eta", "gamma")
    planes = (False, False, True, True)

    def signals(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        A, B = a1 * a1 + a2 * a2, b1 * b1 + b2 * b2
        a_rate, b_rate = a1 * pa1 + a2 * pa2, b1 * pb1 + b2 * pb2
        r = A + B
        w = 1.0 / r
        zero = 0.0 * A
        # minus cos vartheta, whose oscillation has the orientation of vartheta itself
        return (
            (r, zero, a_rate + b_rate, zero)
            + ((B - A) * w, zero, (A * b_rate - B * a_rate) * w, zero)
            + (a1, a2, pa1, pa2, b1, b2, pb1, pb2)
        )


class Coordinates2(NamedTuple):
    """Loops in the coordinate planes (x, px), (y, py) of a system of two degrees of freedom."""

    names = ("x", "y")
    planes = (False, False)

    def signals(self, x, y, px, py):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        zero = 0.0 * x
        return x, zero, px, zero, y, zero, py, zero
