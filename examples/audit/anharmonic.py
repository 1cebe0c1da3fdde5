"""Section 4, continued: actions, frequencies and resonances of EQa and EQb, and the shear potentials."""

from __future__ import annotations

from itertools import product

from mpmath import cos, mp, mpf, pi, sin, sqrt

from . import charts as c
from .classical import QUANTA, anharmonic, anharmonic_level, bohr_sommerfeld, omega, parity, quantised
from .dynamics import in_alpha_beta, in_r_vartheta, phase
from .numerics import along, levi_civita, loop, momenta
from .record import Chapter, claim
from .tori import MU, C, in_planes, in_shear, rates, torus

ANHARMONIC = Chapter("Section 4: the models EQa and EQb")
defines, states = ANHARMONIC.defines, ANHARMONIC.states


def anharmonic_energy(J, s, v):
    """Return E(J) of EQa as printed, J = J_alpha + J_beta."""
    return omega() / (4 * pi) * (4 * J + abs(s + v) + sqrt(64 * MU * pi**2 * C + (s - v) ** 2))


@states("EQa and EQb, separable", "EQa separates in alpha, beta, EQb in r, vartheta")
def _(rng):
    z = phase(rng)
    nothing = [lambda _: 0] * 2
    planes = in_alpha_beta(lambda a: C / 2 * (a**2 + 4 / a**2), lambda b: C / 2 * b**2, *nothing)
    shear = in_r_vartheta(lambda r: C / 2 * r, lambda t: 2 * C / cos(t / 2) ** 2, *nothing)
    return [0, 0], [levi_civita(planes, z), levi_civita(shear, z)]


@states(
    "EQa, E(J)",
    "E = (omega/4 pi)(4(J_alpha + J_beta) + |J_varphi + J_psi| + sqrt(64 mu pi^2 C + (J_varphi - J_psi)^2))",
)
def _(rng):
    t = torus(1, in_planes, rng.index)
    return t.E, anharmonic_energy(t.J[0] + t.J[1], *t.J[2:])


defines("EQa, omega", "omega = sqrt(C/mu)")


@states("EQa, C/alpha^2", "the collapse-preventing term in V_alpha is C/alpha^2", "2C/alpha^2")
def _(rng):
    alpha, beta, *angles = [*rng.reals(2, 0.4, 1), *rng.reals(2)]
    truth = anharmonic(c.alpha_beta(alpha, beta, *angles)) - C / 2 * (alpha**2 + beta**2)
    return truth, C / alpha**2, 2 * C / alpha**2


def no_relation(nu, order):
    """Tell whether no integer vector of size <= order annihilates the numbers."""
    vectors = product(range(-order, order + 1), repeat=len(nu))
    return min(abs(sum(k * x for k, x in zip(vector, nu))) for vector in vectors if any(vector)) > 1e-8


@states("EQa, no resonance of varphi, psi", "there is no longer resonance between varphi and psi")
def _(rng):
    return claim(no_relation(rates(1, in_planes, rng.index)[2:], 12))


@states("EQa, nu_alpha", "nu_alpha = nu_beta = omega/pi")
def _(rng):
    return rates(1, in_planes, rng.index)[:2], [omega() / pi] * 2


defines("sec. 4, nu = dE/dJ", "frequencies in cycles per unit time")


@states("sec. 4, J_eta and J_gamma", "J_varphi = J_eta + J_gamma, J_psi = -J_eta + J_gamma")
def _(rng):
    q, dq = [*rng.reals(2, 0.4, 1), *rng.reals(2)], rng.reals(4)
    p = momenta(c.alpha_beta, q, dq, MU)
    m, v = c.alpha_beta(*q), [MU * x for x in along(c.alpha_beta, q, dq)]
    spin = sum(a * b for a, b in zip(c.product((0, -1, 1, 0), m), v))
    vorticity = sum(a * b for a, b in zip(c.product(m, (0, 1, -1, 0)), v))
    return [spin, vorticity], [p[2] + p[3], -p[2] + p[3]]


@states(
    "EQa, E(J_eta, J_gamma)",
    "E = (omega/4 pi)(4 J_alpha + 4 J_beta +- 2 J_gamma + sqrt(16 mu pi^2 C + J_eta^2))",
    "2 sqrt(16 mu pi^2 C + J_eta^2)",
)
def _(rng):
    t = torus(1, in_planes, rng.index)
    J_eta, J_gamma = 2 * pi * t.p_eta, 2 * pi * t.p_gamma
    root, rest = sqrt(16 * MU * pi**2 * C + J_eta**2), 4 * (t.J[0] + t.J[1]) + 2 * mp.sign(J_gamma) * J_gamma
    return t.E, omega() / (4 * pi) * (rest + root), omega() / (4 * pi) * (rest + 2 * root)


def signed(rng, chart):
    """Return the frequencies, the sign of J_varphi + J_psi, the torus, and nu_gamma = nu_varphi + nu_psi."""
    t = torus(1, chart, rng.index)
    nu = rates(1, chart, rng.index)
    return nu, mp.sign(t.s + t.v), t, nu[2] + nu[3]


@states("EQa, resonances", "nu_alpha - nu_beta = 0, nu_alpha -+ 2 nu_gamma = 0")
def _(rng):
    nu, sign, _, nu_gamma = signed(rng, in_planes)
    return [nu[0], nu[0]], [nu[1], 2 * sign * nu_gamma]


@states("EQa, resonances with nu_beta", "equivalently nu_beta -+ 2 nu_gamma = 0")
def _(rng):
    nu, sign, _, nu_gamma = signed(rng, in_planes)
    return nu[1], 2 * sign * nu_gamma


@states("EQa, 2-tori", "twice degenerate: closures are two-dimensional tori, isotropic")
def _(rng):
    nu, _, _, nu_gamma = signed(rng, in_planes)
    # isotropic: dp^dq vanishes on the two directions along the torus because all actions commute; two numbers remain
    return claim(no_relation([nu[0], nu[2] - nu[3]], 40) and abs(nu[0] - 2 * abs(nu_gamma)) < 1e-18)


for name, i in (("nu_varphi", 2), ("nu_psi", 3)):

    @states(
        f"EQa, {name}",
        f"{name} = (omega/4 pi)(+-1 {'+-'[i == 3]} 2(J_varphi - J_psi)/sqrt(64 mu pi^2 C + (J_varphi - J_psi)^2))",
        "factor 1, not 2",
    )
    def _(rng, i=i):
        nu, sign, t, _ = signed(rng, in_planes)
        D = (t.J[2] - t.J[3]) * (1 if i == 2 else -1)
        root = sqrt(64 * MU * pi**2 * C + D**2)
        return nu[i], omega() / (4 * pi) * (sign + 2 * D / root), omega() / (4 * pi) * (sign + D / root)


@states("EQa, omega = pi nu", "omega = pi nu_alpha = pi nu_beta")
def _(rng):
    nu = rates(1, in_planes, rng.index)
    return [omega()] * 2, [pi * nu[0], pi * nu[1]]


@states("EQa, omega = dE/dJ", "omega = dE/dJ", "omega = pi dE/dJ")
def _(rng):
    t = torus(1, in_planes, rng.index)
    step = mpf(10) ** -10
    up, down = (t.actions(t.constants[0] + k * step, *t.constants[1:])[0] for k in (1, -1))
    slope = 2 * step / (up - down)
    return omega(), slope, pi * slope


@states(
    "EQa, second resonance",
    "nu_alpha -+ 2 nu_varphi -+ 2 nu_psi = 0 for J_alpha + J_beta > 0, < 0",
    "for J_varphi + J_psi > 0, < 0",
)
def _(rng):
    nu, sign, t, _ = signed(rng, in_planes)
    return nu[0], mp.sign(t.J[0] + t.J[1]) * 2 * (nu[2] + nu[3]), sign * 2 * (nu[2] + nu[3])


bohr_sommerfeld(
    states,
    "EQ3.6",
    "E = (hbar omega/2)(4n + |m + l| + sqrt((m - l)^2 + 16 C mu/hbar^2)): J = nh, J_varphi = mh, J_psi = lh",
    1,
    anharmonic_level,
)
parity(states, "EQ3.6, m and l")


# EQb


@states(
    "EQb, E(J)",
    "E = (omega/4 pi)(4(J_r + J_vartheta) + |J_varphi + J_psi| + sqrt(64 mu pi^2 C + (J_varphi - J_psi)^2))",
)
def _(rng):
    t = torus(1, in_shear, rng.index)
    return t.E, anharmonic_energy(t.J[0] + t.J[1], *t.J[2:])


def radial_action(t):
    """Return J_rho, the closed integral of p_rho drho: p_rho^2 = 2 mu (E - C rho^2/2) - 2 mu h/rho^2."""
    E, h = t.constants[:2]
    return loop(lambda q: 2 * MU * (E - C / 2 * q * q) - 2 * MU * h / q**2, sqrt(t.start[0]))


@states("EQb, E(J_rho)", "E = (omega/4 pi)(4(2 J_rho + J_vartheta) + ...)", "J_rho = J_r: 4(J_rho + J_vartheta)")
def _(rng):
    t = torus(1, in_shear, rng.index)
    J_rho = radial_action(t)
    return t.E, anharmonic_energy(2 * J_rho + t.J[1], *t.J[2:]), anharmonic_energy(J_rho + t.J[1], *t.J[2:])


@states("EQb, nu_rho - 2 nu_vartheta", "nu_rho - 2 nu_vartheta = 0", "nu_rho - nu_vartheta = 0")
def _(rng):
    nu = rates(1, in_shear, rng.index)
    return nu[0], 2 * nu[1], nu[1]


@states("EQb, nu_vartheta", "nu_vartheta -+ 2 nu_varphi -+ 2 nu_psi = 0 for J_varphi + J_psi > 0, < 0")
def _(rng):
    nu, sign, _, nu_gamma = signed(rng, in_shear)
    return nu[1], 2 * sign * nu_gamma


@states("EQb, nu_rho -+ 4", "nu_rho -+ 4 nu_varphi -+ 4 nu_psi = 0", "nu_rho -+ 2 nu_varphi -+ 2 nu_psi = 0")
def _(rng):
    nu, sign, _, nu_gamma = signed(rng, in_shear)
    return nu[0], 4 * sign * nu_gamma, 2 * sign * nu_gamma


@states("EQb, 2-tori", "only a two-fold degeneracy: not periodic, dense in two-dimensional tori")
def _(rng):
    nu = rates(1, in_shear, rng.index)
    return claim(no_relation([nu[0], nu[2] - nu[3]], 40))


@states("EQb, Bohr-Sommerfeld", "the same levels in J = J_r + J_vartheta: both charts have the same sum of actions")
def _(rng):
    n, m, l = QUANTA[rng.index]
    t = torus(1, in_planes, rng.index, (1, 1))
    a, b = t.start
    r = a * a + b * b
    pa, pb = (
        sqrt(2 * MU * (E - V) - (p / q) ** 2)
        for E, V, p, q in (
            (t.E_alpha, C / 2 * a * a + 2 * C / a**2, t.p_eta, a),
            (t.E_beta, C / 2 * b * b, t.p_gamma, b),
        )
    )
    h = ((a * pb - b * pa) ** 2 + r * (t.p_eta**2 / a**2 + t.p_gamma**2 / b**2)) / (2 * MU) + 2 * C * r / a**2
    J = in_shear(1, (r, 2 * mp.atan2(b, a)), (t.E, h, t.s, t.v))
    return [t.J[0] + t.J[1], quantised(1, n, m, l)], [J[0] + J[1], anharmonic_level(n, m, l)]


@states("EQb, level labels", "levels are labelled by 4n + m + l and m - l", "4n + |m + l| and |m - l|")
def _(rng):
    n, k = rng.index, 2 + rng.index % 2
    same = (n, 1, 1), (n + 1, -1, -1)  # both have 4n + m + l = 4n + 2; |m + l| = 2 twice
    equal = (n + 1, k, k - 2), (n + 1, -k + 2, -k)  # equal 4n + |m + l| and |m - l|
    E = [quantised(1, *state) for state in (*same, *equal)]
    return [E[0], E[2]], [E[1], E[2]], [E[0], E[3]]


@states("EQb, signs of m, l", "degeneracy with respect to the simultaneous change of signs of m and l")
def _(rng):
    n, m, l = QUANTA[rng.index + 1]
    return quantised(1, n, m, l), quantised(1, n, -m, -l)


# Shear potentials


@states(
    "sec. 3, V_vartheta anharmonic",
    "V_r = Cr/2 with V_vartheta != 0 is anharmonic: frequencies depend on the actions (nu_r = omega/pi does not)",
)
def _(rng):
    one, two = (rates(1, in_shear, k) for k in (rng.index, rng.index + 1))
    return [1, omega() / pi], [int(abs(abs(one[2]) - abs(two[2])) > 1e-6), one[0]]


@states(
    "sec. 4, bounded r",
    "bounded in r implies bounded in the volume and in the shear",
    "shear D1^2 - D2^2 = r sin(vartheta); tan(vartheta), D1/D2 are not",
    reading=True,
)
def _(rng):
    R = rng.real(1, 2)
    shapes = [[R * rng.real(0, 1), pi / 2 - mpf(10) ** -k] for k in range(12)]
    volume = max(r * cos(t) / 2 for r, t in shapes) <= R
    return (
        [1, 1],
        [int(volume), int(max(mp.tan(t) for _, t in shapes) < 1e6)],
        [int(volume), int(max(r * sin(t) for r, t in shapes) <= R)],
    )


def euler_top(I, Theta, p_Theta, p_Phi, p_Psi):
    """Return the energy of a spherical top in Euler angles from its angular velocity, by Legendre transformation in 3 x
    3 matrices.
    """
    G = mp.matrix([[I, 0, 0], [0, I, I * cos(Theta)], [0, I * cos(Theta), I]])
    p = mp.matrix([p_Theta, p_Phi, p_Psi])
    return (p.T * mp.lu_solve(G, p))[0] / 2


for label, says, A in (
    (
        "sec. 4, V independent of vartheta",
        "motion in varphi, vartheta, psi is that of the free spherical top (I = mu/4)",
        0,
    ),
    ("sec. 4, heavy top", "V_vartheta = A cos(vartheta) is the heavy top: h_vartheta with I = mu/4, Psi = -2 psi", 1),
):

    @states(label, says)
    def _(rng, A=A):
        t, pt, s, v = rng.real(0.4, 1.2), *rng.reals(3)
        h = (s**2 + v**2 + 2 * s * v * cos(t)) / (2 * MU * sin(t) ** 2) + 2 / MU * pt**2 + A * cos(t)
        return euler_top(MU / 4, t, pt, s / 2, -v / 2) + A * cos(t), h
