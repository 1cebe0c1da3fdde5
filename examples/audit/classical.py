"""Section 4: energies, frequencies and resonances of the harmonic and anharmonic models, Bohr-Sommerfeld levels."""

from __future__ import annotations

from functools import cache

from mpmath import cos, expj, mp, mpf, pi, sin, sqrt, tan

from . import charts as c
from .constants import equilibrium
from .numerics import frequencies, loop, square
from .record import Chapter, claim
from .tori import MU, C, in_planes, rates, torus

CLASSICAL = Chapter("Section 4: harmonic and anharmonic vibrations")
defines, states = CLASSICAL.defines, CLASSICAL.states


def omega():
    """Return sqrt(C/mu)."""
    return sqrt(C / MU)


# Harmonic oscillator


@states(
    "sec. 4, collapse",
    "collapse to D1 D2 = 0 is prevented except for initial conditions of measure zero",
    "D1 = D2 = 0; D1 D2 = 0 is crossed by most orbits",
)
def _(rng):
    crossing, collapsing, orbits = 0, 0, 400
    for _ in range(orbits):
        q, p = [rng.gauss(0, 1) for _ in range(4)], [rng.gauss(0, 1) for _ in range(4)]  # mu = C = 1
        # det and r along q cos t + p sin t are k + Re(z exp(-2it)): zero is reached if |z| >= |k|
        at, moving = c.determinant(q), c.determinant(p)
        mixed = q[0] * p[3] + p[0] * q[3] - q[1] * p[2] - p[1] * q[2]
        crossing += (at + moving) ** 2 <= (at - moving) ** 2 + mixed**2
        size, speed, along = (sum(a * b for a, b in zip(*pair)) for pair in ((q, q), (p, p), (q, p)))
        collapsing += (size + speed) ** 2 <= (size - speed) ** 2 + 4 * along**2
    return mpf(0), mpf(crossing) / orbits, mpf(collapsing) / orbits


@states(
    "sec. 4, E(J) harmonic", "E = (omega/4 pi)(4 J + |J_varphi - J_psi| + |J_varphi + J_psi|), J = J_alpha + J_beta"
)
def _(rng):
    t = torus(0, in_planes, rng.index)
    Ja, Jb, Js, Jv = t.J
    return t.E, omega() / (4 * pi) * (4 * (Ja + Jb) + abs(Js - Jv) + abs(Js + Jv))


@states("sec. 4, E_alpha, E_beta", "E_alpha = (omega/4 pi)(4 J_alpha + |J_varphi - J_psi|), E_beta with +")
def _(rng):
    t = torus(0, in_planes, rng.index)
    Ja, Jb, Js, Jv = t.J
    return [t.E_alpha, t.E_beta], [
        omega() / (4 * pi) * (4 * Ja + abs(Js - Jv)),
        omega() / (4 * pi) * (4 * Jb + abs(Js + Jv)),
    ]


HBAR = mpf(7) / 10
QUANTA = ((1, 3, 1), (0, -3, 1), (2, 1, -3), (1, 2, 0), (0, 0, 4), (2, 2, 2), (1, -2, 2))
"""(n, m, l) with m + l even, of all three regions and all signs."""


@cache
def quantised(strength, n, m, l):
    """Return the energy at J = n h, J_varphi = m h, J_psi = l h, by solving the quadratures for the energies of the
    planes.
    """
    h = 2 * pi * HBAR
    s, v = HBAR * m, HBAR * l

    def plane(count, p, wall):
        if (
            p == 0 and not wall
        ):  # through the centre: J is the area over one passage 0 -> q_max -> 0, half the whole oval
            return count * h * omega() / pi
        inside = ((p**2 / (2 * MU) + wall * 2 * C) / (C / 2)) ** mpf("0.25")  # the circular orbit
        floor = C * inside**2
        if count == 0:
            return floor

        def excess(E):
            return loop(lambda q: 2 * MU * (E - C / 2 * q * q - wall * 2 * C / q**2) - p**2 / q**2, inside) - count * h

        return mp.findroot(
            excess,
            (floor + mpf("0.9") * count * HBAR * omega(), floor + 3 * count * HBAR * omega()),
            solver="anderson",
            tol=mpf(10) ** -25,
            verify=False,
        )

    with mp.workdps(40):
        return plane(n, (s - v) / 2, strength) + plane(0, (s + v) / 2, 0)


def bohr_sommerfeld(states, label, says, strength, form):
    """Add a Bohr-Sommerfeld spectrum."""

    @states(label, says)
    def _(rng):
        n, m, l = QUANTA[2 * rng.index]
        return quantised(strength, n, m, l), form(n, m, l)


def harmonic_level(n, m, l):
    """EQ3.2."""
    return HBAR * omega() / 2 * (4 * n + abs(m - l) + abs(m + l))


def anharmonic_level(n, m, l):
    """EQ3.6."""
    return HBAR * omega() / 2 * (4 * n + abs(m + l) + sqrt((m - l) ** 2 + 16 * C * MU / HBAR**2))


bohr_sommerfeld(
    states,
    "EQ3.2",
    "E = (hbar omega/2)(4n + |m - l| + |m + l|) from J = nh, J_varphi = mh, J_psi = lh",
    0,
    harmonic_level,
)


def parity(
    states,
    label,
    says="m, l = 0, +-1, ... independently: J over the closed circle varphi, psi -> varphi + pi, psi + pi is a whole "
    "number of h",
):
    """Add the rule m + l even: varphi and psi move together by pi, a closed loop with J = (J_varphi + J_psi)/2."""

    @states(label, says, "m + l even")
    def _(rng):
        q = [*rng.reals(2, 0.5, 1), *rng.reals(2)]
        m, l = rng.choice([(1, 0), (2, 1), (0, 3), (-1, 2)])
        assert (
            square(
                [
                    a - b
                    for a, b in zip(
                        c.alpha_beta_angles(q[2] + pi, q[3] + pi, *q[:2]), c.alpha_beta_angles(q[2], q[3], *q[:2])
                    )
                ]
            )
            < 1e-40
        )

        def over_h(m, l):
            return expj(2 * pi * mpf(m + l) / 2)

        return 1, over_h(m, l), over_h(m + 1 if (m + l) % 2 else m, l)


parity(states, "EQ3.2, m and l")

for label, says, region, pick in (
    ("EQ3.21a", "|m| > |l|: E = hbar omega (2n +- m)", lambda m, l: abs(m) > abs(l), lambda m, l: m),
    ("EQ3.22a", "|m| < |l|: E = hbar omega (2n +- l)", lambda m, l: abs(m) < abs(l), lambda m, l: l),
    (
        "EQ3.23a",
        "|m| = |l|: E = hbar omega (2n +- m) = hbar omega (2n +- l)",
        lambda m, l: abs(m) == abs(l),
        lambda m, l: l,
    ),
):

    @states(label, says + ", each with both signs", "+- is the sign of the number: 2n + |m|, 2n + |l|", reading=True)
    def _(rng, region=region, pick=pick):
        rows = [row for row in QUANTA if region(*row[1:])]
        n, m, l = rows[rng.index % len(rows)]
        E = quantised(0, n, m, l)
        both = [HBAR * omega() * (2 * n + sign * pick(m, l)) for sign in (1, -1)]
        return [E, E], both, [HBAR * omega() * (2 * n + abs(pick(m, l)))] * 2


def regions(index, first_larger):
    """Return a harmonic torus with |J_varphi| > |J_psi| (p_eta, p_gamma of one sign), or the reverse."""
    one = 1 if index % 2 else -1
    return torus(0, in_planes, index, (one, one) if first_larger else (one, -one))


for label, says, first in (
    ("EQ3.21", "|J_varphi| > |J_psi|: E = (omega/2 pi)(2 J_alpha + 2 J_beta +- J_varphi)", True),
    ("EQ3.22", "|J_varphi| < |J_psi|: E = (omega/2 pi)(2 J_alpha + 2 J_beta +- J_psi)", False),
):

    @states(label, says + ", with both signs", "+- is the sign of the action: |J_varphi|, |J_psi|", reading=True)
    def _(rng, first=first):
        t = regions(rng.index, first)
        Ja, Jb, Js, Jv = t.J
        larger = Js if first else Jv
        return (
            [t.E] * 2,
            [omega() / (2 * pi) * (2 * (Ja + Jb) + k * larger) for k in (1, -1)],
            [omega() / (2 * pi) * (2 * (Ja + Jb) + abs(larger))] * 2,
        )


@states(
    "EQ3.23",
    "on J_varphi = J_psi both forms agree; the regions and this submanifold exhaust the phase space",
    "|J_varphi| = |J_psi|",
)
def _(rng):
    J = rng.real(0.3, 1)
    cases = [(2 * J, J), (J, -2 * J), (J, J), (J, -J), (-J, J)]
    printed = [int(abs(s) > abs(v)) + int(abs(s) < abs(v)) + int(s == v) for s, v in cases]
    return [1] * 5, printed, [int(abs(s) > abs(v)) + int(abs(s) < abs(v)) + int(abs(s) == abs(v)) for s, v in cases]


@states(
    "sec. 4, degeneracy harmonic",
    "nu = (omega/pi)(1, 1, +-1/2, 0) for |J_varphi| > |J_psi|, (1, 1, 0, +-1/2) for <: integer coefficients, one "
    "vanishes",
)
def _(rng):
    first = rng.index % 2 == 0
    t = regions(rng.index, first)
    nu = rates(0, in_planes, rng.index, tuple(int(mp.sign(x)) for x in (t.p_eta, t.p_gamma)))
    turn = [mp.sign(t.s) / 2, 0] if first else [0, mp.sign(t.v) / 2]
    return nu, [omega() / pi * k for k in (1, 1, *turn)]


@states("sec. 4, swept in opposite directions", "the sign of J_varphi is the sense in which the angular cycle is swept")
def _(rng):
    nu = [rates(0, in_planes, 0, (k, k))[2] for k in (1, -1)]
    return claim(nu[0] > 0 > nu[1])


def oscillator(rng):
    """Return a random orbit of the plane oscillator: E, J_x, J_y, J_r, J_varphi by quadrature, and a frequency
    function.
    """
    x, y, px, py = rng.reals(4, 0.3, 1)
    if rng.index == 1:
        px, py = -py, px / 3
    energies = [p**2 / (2 * MU) + C / 2 * q**2 for q, p in ((x, px), (y, py))]

    def line(e):  # the oval of a libration through 0, from -q_max to q_max
        return loop(lambda q: 2 * MU * e - MU * C * (q - 5) ** 2, mpf(5), -(mpf(10) ** 3))

    L = x * py - y * px
    E = sum(energies)

    def radial(E, L):
        return [loop(lambda q: 2 * MU * E - MU * C * q * q - L**2 / q**2, sqrt(x * x + y * y)), 2 * pi * L]

    return E, L, [line(e) for e in energies], radial


@states(
    "sec. 4, E = omega (J_x + J_y)",
    "plane oscillator in Cartesian actions",
    "omega/2 pi: J is the closed integral of p dq everywhere else",
)
def _(rng):
    E, _, J, _ = oscillator(rng)
    return E, omega() * sum(J), omega() / (2 * pi) * sum(J)


@states("EQ3.1a", "plane oscillator, E = omega (2 J_r + J_varphi)", "(omega/2 pi)(2 J_r + |J_varphi|)")
def _(rng):
    E, L, _, radial = oscillator(rng)
    J_r, J_varphi = radial(E, L)
    return E, omega() * (2 * J_r + J_varphi), omega() / (2 * pi) * (2 * J_r + abs(J_varphi))


@states("EQ3.1a, ratio 2:1", "two librations in r for one rotation in varphi")
def _(rng):
    E, L, _, radial = oscillator(rng)
    nu_r, nu_varphi = frequencies(radial, lambda E, L: E, [E, L])
    return nu_r, 2 * abs(nu_varphi)


# EQa and EQb


def anharmonic(m):
    """Return EQa from the matrix elements: C r/2 + 2C/alpha^2, alpha^2 = ((x + u)^2 + (z - y)^2)/2."""
    x, y, z, u = m
    return C / 2 * square(m) + 4 * C / ((x + u) ** 2 + (z - y) ** 2)


@states("EQa", "(C/2)(alpha^2 + 4/alpha^2) + C beta^2/2 = (C/2)(alpha^2 + beta^2) + 2C/alpha^2")
def _(rng):
    a, b, *angles = [*rng.reals(2, 0.3, 1), *rng.reals(2)]
    truth = anharmonic(c.alpha_beta(a, b, *angles))
    return [truth] * 2, [C / 2 * (a**2 + 4 / a**2) + C / 2 * b**2, C / 2 * (a**2 + b**2) + 2 * C / a**2]


def polar_forms(rho, t):
    """Return both forms of EQb."""
    return [
        C / 2 * (rho**2 + 4 / rho**2) + 2 * C / rho**2 * tan(t / 2) ** 2,
        C / 2 * rho**2 + 2 * C / (rho**2 * cos(t / 2) ** 2),
    ]


@states("EQb", "(C/2)(rho^2 + 4/rho^2) + (2C/rho^2) tan^2(vartheta/2) = C rho^2/2 + 2C/(rho^2 cos^2(vartheta/2))")
def _(rng):
    first, second = polar_forms(*rng.reals(2, 0.4, 1.4))
    return first, second


@states(
    "EQb, a second model", 'EQb is "another interesting model" beside EQa', "EQb and EQa are the same function of phi"
)
def _(rng):
    rho, t, *angles = [*rng.reals(2, 0.4, 1.4), *rng.reals(2)]
    difference = polar_forms(rho, t)[1] / anharmonic(c.rho_epsilon(rho, t / 2, *angles)) - 1
    return 1, int(abs(difference) > 1e-20), 1 + difference


@states("sec. 4, V_alpha, V_beta, V_r, V_vartheta", "the shape functions of EQa and EQb")
def _(rng):
    r, t, *angles = [*rng.reals(2, 0.4, 1.4), *rng.reals(2)]
    a, b = sqrt(r) * cos(t / 2), sqrt(r) * sin(t / 2)
    truth = anharmonic(c.r_vartheta(r, t, *angles))
    return [truth] * 2, [C / 2 * (a**2 + 4 / a**2) + C / 2 * b**2, C / 2 * r + 2 * C / cos(t / 2) ** 2 / r]


equilibrium(
    states,
    "EQa, equilibria",
    lambda scale: lambda *m: anharmonic(m) * scale / C,
    "EQa, EQb have stable equilibria at D1 = D2 = 1: one zero mode, omega^2 = (0, 1, 1, 4) C/mu",
    (0, 1, 1, 4),
)
