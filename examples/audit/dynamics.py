"""The dynamics of section 3: potentials, Hamiltonians, separability, constants of motion, equilibria."""

from __future__ import annotations

from mpmath import cos, cosh, exp, mp, mpf, pi, sin, sinh, sqrt

from . import charts as c
from .numerics import along, bracket, dd, gradient, levi_civita, loop, momenta, square
from .record import Chapter, claim

DYNAMICS = Chapter("Section 3: dynamics")
defines, states = DYNAMICS.defines, DYNAMICS.states
MU = mpf(3) / 4
APART = 1e-9
"""A normalised expression larger than this is not zero: differences leave 1e-24."""


def generic(rng):
    """Return a random smooth function of one variable."""
    k = rng.reals(4)
    return lambda x: k[0] * sin(x) + k[1] * exp(k[2] * x) + k[3] * x * x


def phase(rng):
    """Return random coordinates of a chart (radius, radius or angle, two angles) and four momenta."""
    return [rng.real(0.6, 1.0), rng.real(0.3, 0.5), *rng.reals(2), *rng.reals(4)]


def kinetic(chart):
    """Return T(q, p) from the pullback of the Euclidean metric, G^-1 by one linear solve."""

    def T(*z):
        n = len(z) // 2
        columns = [along(chart, z[:n], [mpf(k == i) for k in range(n)]) for i in range(n)]
        G = mp.matrix([[sum(u * v for u, v in zip(a, b)) for b in columns] for a in columns])
        p = mp.matrix(list(z[n:]))
        return (p.T * mp.lu_solve(G, p))[0] / (2 * MU)

    return T


# Separable potentials and Hamiltonians in (alpha, beta)


def free_two_polar(D1, D2, _varphi, _psi, p1, p2, s, v):
    """Legendre transform of EQ2.0a, by the angular momenta of the two planes."""
    return (p1**2 + p2**2 + (s - v) ** 2 / (2 * (D1 + D2) ** 2) + (s + v) ** 2 / (2 * (D1 - D2) ** 2)) / (2 * MU)


@states(
    "sec. 3, D1 and D2 non-separable",
    "the Hamilton-Jacobi equation is non-separable in D1, D2, varphi, psi even without forces",
)
def _(rng):
    z = phase(rng)
    kind = abs(free_two_polar(*z) / kinetic(c.two_polar)(*z) - 1) < 1e-20
    return claim(kind and levi_civita(free_two_polar, z) > APART)


def separable(rng):
    """Return H of EQ2.1 in alpha, beta, eta, gamma with random one-variable functions."""
    Va, Vb, Ve, Vg = (generic(rng) for _ in range(4))

    def V(alpha, beta, eta, gamma):
        return Ve(eta) / alpha**2 + Vg(gamma) / beta**2 + Va(alpha) + Vb(beta)

    def H(alpha, beta, eta, gamma, pa, pb, pe, pg):
        return (pa**2 + pe**2 / alpha**2 + pb**2 + pg**2 / beta**2) / (2 * MU) + V(alpha, beta, eta, gamma)

    return V, H


@states(
    "EQ2.1",
    "V_eta/alpha^2 + V_gamma/beta^2 + V_alpha + V_beta separates in alpha, beta, eta, gamma (and alpha beta does not)",
)
def _(rng):
    (_, H), z = separable(rng), phase(rng)
    return claim(levi_civita(H, z) < 1e-18 and levi_civita(lambda *z: H(*z) + z[0] * z[1], z) > APART)


def isotropic(rng):
    """Return V_alpha, V_beta, H_alpha, H_beta of EQ2.1b in varphi, psi, alpha, beta and their momenta, as printed."""
    Va, Vb = generic(rng), generic(rng)

    def H_alpha(_varphi, _psi, alpha, _beta, s, v, pa, _pb):
        return ((s - v) ** 2 / (4 * alpha**2) + pa**2) / (2 * MU) + Va(alpha)

    def H_beta(_varphi, _psi, _alpha, beta, s, v, _pa, pb):
        return ((s + v) ** 2 / (4 * beta**2) + pb**2) / (2 * MU) + Vb(beta)

    return Va, Vb, H_alpha, H_beta


def angular_phase(rng):
    """Return varphi, psi, alpha, beta, and momenta."""
    return [*rng.reals(2), rng.real(0.6, 1.0), rng.real(0.3, 0.5), *rng.reals(4)]


@states("EQ2.1a", "H by Legendre transformation, in p_varphi, p_psi, p_alpha, p_beta")
def _(rng):
    Va, Vb, _, _ = isotropic(rng)
    q, dq = angular_phase(rng)[:4], rng.reals(4)
    z = [*q, *momenta(c.alpha_beta_angles, q, dq, MU)]
    truth = MU / 2 * square(along(c.alpha_beta_angles, q, dq)) + Va(q[2]) + Vb(q[3])
    _, _, alpha, beta, s, v, pa, pb = z
    return truth, ((s - v) ** 2 / (4 * alpha**2) + pa**2) / (2 * MU) + ((s + v) ** 2 / (4 * beta**2) + pb**2) / (
        2 * MU
    ) + Va(alpha) + Vb(beta)


@states("EQ2.1b", "H = H_alpha + H_beta, each the energy of one plane")
def _(rng):
    Va, Vb, H_alpha, H_beta = isotropic(rng)
    q, dq = angular_phase(rng)[:4], rng.reals(4)
    z = [*q, *momenta(c.alpha_beta_angles, q, dq, MU)]
    x, y, w, u = along(c.alpha_beta_angles, q, dq)
    truth = [MU / 4 * square([x + u, w - y]) + Va(q[2]), MU / 4 * square([x - u, w + y]) + Vb(q[3])]
    return truth, [H_alpha(*z), H_beta(*z)]


@states("sec. 3, involution", "H_alpha, H_beta, p_varphi, p_psi commute pairwise")
def _(rng):
    _, _, H_alpha, H_beta = isotropic(rng)
    z = angular_phase(rng)
    four = [H_alpha, H_beta, lambda *z: z[4], lambda *z: z[5]]
    return [0] * 6, [bracket(four[i], four[j], z) for i in range(4) for j in range(i)]


@states("sec. 3, Hamilton-Jacobi", "mixed term (1/2beta^2 - 1/2alpha^2) d^2 S/dvarphi dpsi", "(dS/dvarphi)(dS/dpsi)")
def _(rng):
    q, k = angular_phase(rng)[:4], rng.reals(4)

    def S(*q):
        return sin(sum(a * x for a, x in zip(k, q))) + q[0] * q[1]

    s, v, pa, pb = gradient(S, q)
    alpha, beta = q[2:]
    z = [*q, s, v, pa, pb]
    rest = (1 / (4 * alpha**2) + 1 / (4 * beta**2)) * (s**2 + v**2) + pa**2 + pb**2
    mixed = 1 / (2 * beta**2) - 1 / (2 * alpha**2)
    truth = 2 * MU * (kinetic(c.alpha_beta_angles)(*z))
    return truth, rest + mixed * dd(S, 0, 1)(*q), rest + mixed * s * v


def planar(rng):
    """Return a random harmonic motion of one plane: turning point radius, mu, C and constants E, p; q^2 = X + Y
    cos(2wt).
    """
    C, q0, p = rng.real(0.6, 1.5), rng.real(0.7, 1.1), rng.real(0.3, 0.6)
    speed = rng.real(0.2, 0.6)
    return C, q0, speed, p, MU / 2 * (speed**2 + (p / (MU * q0)) ** 2) + C / 2 * q0**2


def swept(C, q0, speed, p):
    """Return the closed integral of p_q dq = mu (dq/dt)^2 dt along the exact Cartesian motion of a plane, one period
    pi/w.
    """
    w = sqrt(C / MU)
    start, velocity = mp.mpc(q0, 0), mp.mpc(speed, p / (MU * q0))
    nodes = 400

    def term(k):
        t = pi / w * k / nodes
        a, b = start * cos(w * t) + velocity / w * sin(w * t), velocity * cos(w * t) - start * w * sin(w * t)
        return MU * (mp.re(mp.conj(a) * b) / abs(a)) ** 2

    return pi / w / nodes * sum(term(k) for k in range(nodes))


@states(
    "sec. 3, S separated",
    "S = a varphi + b psi + S_alpha + S_beta solves the Hamilton-Jacobi equation, E = E_alpha + E_beta",
)
def _(rng):
    Va, Vb, _, _ = isotropic(rng)
    q = angular_phase(rng)[:4]
    a, b, Ea, Eb = *rng.reals(2, -0.2, 0.2), *rng.reals(2, 6, 8)
    pa = sqrt(2 * MU * (Ea - Va(q[2])) - (a - b) ** 2 / (4 * q[2] ** 2))
    pb = sqrt(2 * MU * (Eb - Vb(q[3])) - (a + b) ** 2 / (4 * q[3] ** 2))
    return kinetic(c.alpha_beta_angles)(*q, a, b, pa, pb) + Va(q[2]) + Vb(q[3]), Ea + Eb


@states(
    "sec. 3, J_varphi and J_psi",
    "closed integrals of p_varphi dvarphi = 2 pi a, p_psi dpsi = 2 pi b over closed circles of matrices",
)
def _(rng):
    q, dq = angular_phase(rng)[:4], rng.reals(4)
    p = momenta(c.alpha_beta_angles, q, dq, MU)
    m, v = c.alpha_beta_angles(*q), along(c.alpha_beta_angles, q, dq)
    back = [c.alpha_beta_angles(q[0] + 2 * pi, *q[1:]), c.alpha_beta_angles(q[0], q[1] + 2 * pi, *q[2:])]
    left, right = c.product((0, -1, 1, 0), m), c.product(m, (0, 1, -1, 0))
    spin, vorticity = (MU * sum(a * b for a, b in zip(v, turn)) for turn in (left, right))
    return [m, m, 2 * pi * spin, 2 * pi * vorticity], [back, 2 * pi * p[0], 2 * pi * p[1]]


for label, sign in (("sec. 3, J_alpha", -1), ("EQ2.2", +1)):

    @states(
        label,
        f"J_{'alpha' if sign < 0 else 'beta'} = closed integral of sqrt(2 mu (E - V) - (J_varphi {'-+'[sign > 0]} "
        "J_psi)^2/16 pi^2 q^2) dq",
    )
    def _(rng, sign=sign):
        C, q0, speed, p, E = planar(rng)
        J_varphi = 2 * pi * rng.real()
        J_psi = sign * (2 * pi * 2 * p - J_varphi)  # p_varphi + sign p_psi = 2 p
        printed = loop(
            lambda q: 2 * MU * (E - C / 2 * q * q) - (J_varphi + sign * J_psi) ** 2 / (16 * pi**2 * q * q), q0
        )
        return swept(C, q0, speed, p), printed


# Staeckel Hamiltonians in three charts


def shapes(rng):
    """Return four random one-variable functions."""
    return [generic(rng) for _ in range(4)]


def in_alpha_beta(V1, V2, Ve, Vg):
    """As printed, first Hamiltonian."""

    def H(a, b, eta, gamma, pa, pb, pe, pg):
        return (
            ((pa**2 + pe**2 / a**2) + (pb**2 + pg**2 / b**2)) / (2 * MU)
            + V1(a)
            + V2(b)
            + Ve(eta) / a**2
            + Vg(gamma) / b**2
        )

    return H


def in_r_vartheta(V1, V2, Ve, Vg):
    """EQ2.2f as printed, with p_varphi = p_gamma + p_eta, p_psi = p_gamma - p_eta."""

    def H(r, t, eta, gamma, pr, pt, pe, pg):
        s, v = pg + pe, pg - pe
        T = (4 * r * pr**2 + ((s**2 + v**2 + 2 * s * v * cos(t)) / sin(t) ** 2 + 4 * pt**2) / r) / (2 * MU)
        return T + V1(r) + V2(t) / r + Ve(eta) / (r * cos(t / 2) ** 2) + Vg(gamma) / (r * sin(t / 2) ** 2)

    return H


def in_elliptic(V1, V2, Ve, Vg):
    """As printed, third Hamiltonian."""

    def H(k, l, eta, gamma, pk, pl, pe, pg):
        D = cosh(k) ** 2 - cos(l) ** 2
        A, B = cosh(k) ** 2 * cos(l) ** 2, sinh(k) ** 2 * sin(l) ** 2
        return (
            ((pk**2 + pl**2) / D + pe**2 / A + pg**2 / B) / (4 * MU)
            + (V1(k) + V2(l)) / (2 * D)
            + Ve(eta) / (2 * A)
            + Vg(gamma) / (2 * B)
        )

    return H


for label, name, chart, form in (
    ("sec. 3, H (alpha, beta)", "alpha, beta", c.alpha_beta, in_alpha_beta),
    ("EQ2.2f", "r, vartheta", c.r_vartheta, in_r_vartheta),
    ("sec. 3, H (kappa, lambda)", "kappa, lambda", c.elliptic, in_elliptic),
):

    @states(f"{label}, T", f"kinetic energy of the Staeckel Hamiltonian in {name}, eta, gamma")
    def _(rng, chart=chart, form=form):
        z = phase(rng)
        return kinetic(chart)(*z), form(*[lambda x: 0 * x] * 4)(*z)

    @states(f"{label}, separable", f"with its four shape functions it separates in {name}, eta, gamma")
    def _(rng, form=form):
        return 0, levi_civita(form(*shapes(rng)), phase(rng))


def free_parabolic(xi, delta, _eta, _gamma, p1, p2, pe, pg):
    """Free Hamiltonian in parabolic coordinates (compared with the pullback below)."""
    alpha, beta = (xi**2 - delta**2) / 2, xi * delta
    return ((p1**2 + p2**2) / (xi**2 + delta**2) + pe**2 / alpha**2 + pg**2 / beta**2) / (2 * MU)


def free_bipolar(e, f, _eta, _gamma, p1, p2, pe, pg):
    """Free Hamiltonian in bipolar coordinates, c = 1."""
    return (cosh(e) - cos(f)) ** 2 * (p1**2 + p2**2 + pe**2 / sinh(e) ** 2 + pg**2 / sin(f) ** 2) / (2 * MU)


for name, chart, H in (("parabolic", c.parabolic, free_parabolic), ('bipolar ("two-polar")', c.bipolar, free_bipolar)):

    @states(
        f"sec. 3, {name} non-separable",
        f"even the free Hamilton-Jacobi equation does not separate in {name} coordinates",
    )
    def _(rng, chart=chart, H=H):
        z = phase(rng)
        return claim(abs(H(*z) / kinetic(chart)(*z) - 1) < 1e-20 and levi_civita(H, z) > APART)


@states(
    "sec. 3, mixed coordinates",
    "free motion (and the oscillator) separates in R^3 x R and R^2 x R^2 spherical and polar coordinates",
)
def _(rng):
    z = [rng.real(0.5, 1), rng.real(0.5, 1), *rng.reals(6)]

    def cylinder(r, theta, phi, w):
        return r * sin(theta) * cos(phi), r * sin(theta) * sin(phi), r * cos(theta), w

    def polar(r, s, phi, w):
        return r * cos(phi), r * sin(phi), s * cos(w), s * sin(w)

    def flat(r, w, phi, z):
        return r * cos(phi), r * sin(phi), w, z

    def oscillator(chart):
        return lambda *z: kinetic(chart)(*z) + square(chart(*z[:4])) / 2

    with mp.workdps(100):  # kinetic differentiates once more
        return [0] * 4, [levi_civita(oscillator(chart), z) for chart in (cylinder, polar, flat, c.spherical)]
