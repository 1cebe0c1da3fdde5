"""Actions by quadrature and frequencies by differences of those quadratures, for the harmonic model and EQa = EQb."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

from mpmath import atan2, cos, mpf, pi, sin

from .numerics import frequencies, loop
from .record import Random

MU, C = mpf(3) / 4, mpf(6) / 5
SIGNS = ((1, 1), (1, -1), (-1, 1), (-1, -1))


def barrier(strength):
    """Return V_alpha = C alpha^2/2 + strength 2C/alpha^2: harmonic for 0, EQa for 1."""
    return lambda alpha: C / 2 * alpha**2 + strength * 2 * C / alpha**2


def spring(beta):
    """Return V_beta."""
    return C / 2 * beta**2


def in_planes(strength, start, constants):
    """Return J_alpha, J_beta, J_varphi, J_psi of (E_alpha, E_beta, p_varphi, p_psi); start lies inside both wells."""
    E_alpha, E_beta, s, v = constants
    V = barrier(strength)
    J_alpha = loop(lambda q: 2 * MU * (E_alpha - V(q)) - ((s - v) / 2) ** 2 / q**2, start[0])
    J_beta = loop(lambda q: 2 * MU * (E_beta - spring(q)) - ((s + v) / 2) ** 2 / q**2, start[1])
    return [J_alpha, J_beta, 2 * pi * s, 2 * pi * v]


def in_shear(strength, start, constants):
    """Return J_r, J_vartheta, J_varphi, J_psi of (E, h_vartheta, p_varphi, p_psi), with V_vartheta = strength
    2C/cos^2(vartheta/2).
    """
    E, h, s, v = constants
    r, vartheta = start
    J_r = loop(lambda r: (2 * MU * (E - C / 2 * r) - 2 * MU * h / r) / (4 * r), r)

    def radicand(t):
        angular = ((s - v) / 2) ** 2 / cos(t / 2) ** 2 + ((s + v) / 2) ** 2 / sin(t / 2) ** 2
        return MU / 2 * (h - strength * 2 * C / cos(t / 2) ** 2) - angular / 4

    return [J_r, loop(radicand, vartheta, 0, pi), 2 * pi * s, 2 * pi * v]


@cache
def torus(strength, chart, index, signs=None):
    """Return one random torus: its J, nu, energies and momenta. chart: in_planes or in_shear."""
    rng = Random(f"torus {strength} {chart.__name__}", index)
    alpha, beta, pa, pb = *rng.reals(2, 0.7, 1.1), *rng.reals(2, 0.5, 0.9)
    one, two = signs or SIGNS[index % 4]
    p_eta, p_gamma = one * rng.real(0.3, 0.7), two * rng.real(0.3, 0.7)
    s, v = p_gamma + p_eta, p_gamma - p_eta
    E_alpha = (pa**2 + p_eta**2 / alpha**2) / (2 * MU) + barrier(strength)(alpha)
    E_beta = (pb**2 + p_gamma**2 / beta**2) / (2 * MU) + spring(beta)
    E = E_alpha + E_beta
    if chart is in_planes:
        constants, start, energy = [E_alpha, E_beta, s, v], (alpha, beta), lambda *k: k[0] + k[1]
    else:
        # In Cartesian planes a, b: 2 mu (h - V_vartheta) is the squared angular momentum of R^4.
        r = alpha**2 + beta**2
        turned = (alpha * pb - beta * pa) ** 2 + r * (p_eta**2 / alpha**2 + p_gamma**2 / beta**2)
        h = turned / (2 * MU) + strength * 2 * C * r / alpha**2
        constants, start, energy = [E, h, s, v], (r, 2 * atan2(beta, alpha)), lambda *k: k[0]

    def actions(*k):
        return chart(strength, start, k)

    J = actions(*constants)
    return SimpleNamespace(
        J=J,
        E=E,
        E_alpha=E_alpha,
        E_beta=E_beta,
        s=s,
        v=v,
        p_eta=p_eta,
        p_gamma=p_gamma,
        energy=energy,
        actions=actions,
        constants=constants,
        start=start,
        strength=strength,
    )


@cache
def rates(strength, chart, index, signs=None):
    """Return the four frequencies of a torus, in cycles per unit time."""
    t = torus(strength, chart, index, signs)
    return frequencies(t.actions, t.energy, t.constants)
