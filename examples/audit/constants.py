"""The constants of motion and the models of section 3: elliptic K and L, h_vartheta, spherical actions, EQ2.2h,
EQ3.1.
"""

from __future__ import annotations

from mpmath import cos, cosh, mp, mpf, pi, sin, sinh, sqrt

from . import charts as c
from .dynamics import APART, MU, generic, in_elliptic, in_r_vartheta, phase
from .numerics import bracket, d, dd, gradient, levi_civita, loop, square
from .record import Chapter, claim

CONSTANTS = Chapter("Section 3: constants of motion and models")
defines, states = CONSTANTS.defines, CONSTANTS.states


# Elliptic chart, doubly isotropic: V_eta, V_gamma constant


def elliptic_system(rng):
    """Return H and, as functions of z, h_kappa and h_lambda as printed and as corrected."""
    Vk, Vl = generic(rng), generic(rng)
    Ve, Vg = rng.reals(2, 0.2, 1)
    H = in_elliptic(Vk, Vl, lambda _: Ve, lambda _: Vg)

    def h_kappa(Pe, Pg):
        def h(k, l, eta, gamma, pk, pl, pe, pg):
            return (
                pk**2
                + 2 * MU * Vk(k)
                - (pe**2 + 2 * MU * Pe(k)) / cosh(k) ** 2
                + (pg**2 + 2 * MU * Pg(k)) / sinh(k) ** 2
            ) / (2 * MU)

        return h

    def h_lambda(Pe, Pg):
        def h(k, l, eta, gamma, pk, pl, pe, pg):
            return (
                pl**2 + 2 * MU * Vl(l) + (pe**2 + 2 * MU * Pe(l)) / cos(l) ** 2 + (pg**2 + 2 * MU * Pg(l)) / sin(l) ** 2
            ) / (2 * MU)

        return h

    constant = (lambda _: Ve), (lambda _: Vg)
    return H, (h_kappa(Vk, Vk), h_lambda(Vl, Vl)), (h_kappa(*constant), h_lambda(*constant))


def K_and_L(h_kappa, h_lambda, sign):
    """Return K (with the sign of its second term) and L."""

    def K(*z):
        k, l = z[:2]
        return (h_kappa(*z) * cos(l) ** 2 + sign * h_lambda(*z) * cosh(k) ** 2) / (2 * (cosh(k) ** 2 - cos(l) ** 2))

    def L(*z):
        k, l = z[:2]
        return (h_kappa(*z) * sin(l) ** 2 - h_lambda(*z) * sinh(k) ** 2) / (2 * (sinh(k) ** 2 + sin(l) ** 2))

    return K, L


for name, which in (("h_kappa", 0), ("h_lambda", 1)):

    @states(
        f"sec. 3, {name}",
        f"with V_{name[2:]} in the p_eta, p_gamma terms; H = (h_kappa + h_lambda)/2(cosh^2 - cos^2)",
        "V_eta, V_gamma in these terms",
    )
    def _(rng, which=which):
        (H, printed, corrected), z = elliptic_system(rng), phase(rng)
        D = 2 * (cosh(z[0]) ** 2 - cos(z[1]) ** 2)
        truth = D * H(*z) - corrected[1 - which](*z)
        return truth, printed[which](*z), corrected[which](*z)


@states(
    "sec. 3, V_kappa, V_lambda constant",
    '"V_kappa, V_lambda are constants here": H then separates with the p_eta, p_gamma kept',
    "V_eta, V_gamma are the constants; V_kappa, V_lambda are arbitrary",
    reading=False,
)
def _(rng):
    z, eta_free = phase(rng), generic(rng)
    one, two = generic(rng), generic(rng)
    printed = in_elliptic(lambda _: 1, lambda _: 1, eta_free, eta_free)  # V_eta, V_gamma left free: p_eta is lost
    corrected = in_elliptic(one, two, lambda _: 1, lambda _: 1)
    angular = [lambda *z: z[6], lambda *z: z[7]]
    return [0, 0], [bracket(p, printed, z) for p in angular], [bracket(p, corrected, z) for p in angular]


@states(
    "sec. 3, K",
    "K = (h_kappa cos^2 lambda - h_lambda cosh^2 kappa)/2(cosh^2 - cos^2) is a constant of motion",
    "plus sign",
)
def _(rng):
    (H, _, h), z = elliptic_system(rng), phase(rng)
    return 0, bracket(K_and_L(*h, -1)[0], H, z), bracket(K_and_L(*h, +1)[0], H, z)


@states(
    "sec. 3, L",
    "L = (h_kappa sin^2 lambda - h_lambda sinh^2 kappa)/2(sinh^2 + sin^2) is a constant of motion (with the corrected "
    "h)",
)
def _(rng):
    (H, _, h), z = elliptic_system(rng), phase(rng)
    return 0, bracket(K_and_L(*h, 1)[1], H, z)


@states("sec. 3, H = K + L", "H = K + L", "with the corrected K")
def _(rng):
    (H, _, h), z = elliptic_system(rng), phase(rng)
    return H(*z), *(sum(f(*z) for f in K_and_L(*h, sign)) for sign in (-1, +1))


@states("sec. 3, elliptic involution", "p_varphi, p_psi, K, L commute pairwise", "with the corrected K")
def _(rng):
    (_, _, h), z = elliptic_system(rng), phase(rng)
    angular = [lambda *z: z[7] + z[6], lambda *z: z[7] - z[6]]

    def brackets(sign):
        four = [*angular, *K_and_L(*h, sign)]
        return [bracket(four[i], four[j], z) for i in range(4) for j in range(i)]

    return [0] * 6, brackets(-1), brackets(+1)


@states("sec. 3, two more constants", "p_eta, p_gamma, K, L are independent, so the problem is integrable")
def _(rng):
    (_, _, h), z = elliptic_system(rng), phase(rng)
    rows = [gradient(f, z) for f in (*K_and_L(*h, 1), lambda *z: z[6], lambda *z: z[7])]
    gram = mp.matrix([[sum(a * b for a, b in zip(u, v)) / sqrt(square(u) * square(v)) for v in rows] for u in rows])
    return claim(abs(mp.det(gram)) > APART)


@states("sec. 3, h_kappa not constant", "h_kappa, h_lambda are not constants of motion")
def _(rng):
    (H, _, h), z = elliptic_system(rng), phase(rng)
    return claim(all(abs(bracket(f, H, z)) > APART for f in h))


# Polar chart, doubly isotropic


def shear_system(rng):
    """Return H of EQ2.2f with V_eta = V_gamma = 0, and h_vartheta, H_r as printed, of z = (r, vartheta, varphi, psi,
    momenta).
    """
    Vr, Vt = generic(rng), generic(rng)

    def H(r, t, varphi, psi, pr, pt, s, v):
        return in_r_vartheta(Vr, Vt, lambda _: 0, lambda _: 0)(r, t, 0, 0, pr, pt, (s - v) / 2, (s + v) / 2)

    def h(r, t, varphi, psi, pr, pt, s, v):
        return (s**2 + v**2 + 2 * s * v * cos(t)) / (2 * MU * sin(t) ** 2) + 2 / MU * pt**2 + Vt(t)

    def H_r(r, t, varphi, psi, pr, pt, s, v):
        return 2 / MU * r * pr**2 + Vr(r)

    return H, h, H_r


@states("sec. 3, V_eta/cos^2 in V_vartheta", "constant V_eta, V_gamma may be included into V_vartheta")
def _(rng):
    z, (Vr, Vt), (Ve, Vg) = phase(rng), [generic(rng), generic(rng)], rng.reals(2)
    apart = in_r_vartheta(Vr, Vt, lambda _: Ve, lambda _: Vg)
    joined = in_r_vartheta(Vr, lambda t: Vt(t) + Ve / cos(t / 2) ** 2 + Vg / sin(t / 2) ** 2, lambda _: 0, lambda _: 0)
    return apart(*z), joined(*z)


@states("sec. 3, h_vartheta", "h_vartheta, p_varphi, p_psi, H commute pairwise")
def _(rng):
    (H, h, _), z = shear_system(rng), phase(rng)
    four = [h, H, lambda *z: z[6], lambda *z: z[7]]
    return [0] * 6, [bracket(four[i], four[j], z) for i in range(4) for j in range(i)]


@states("sec. 3, H = H_r + h_vartheta/r", "H_r = (2/mu) r p_r^2 + V_r, H = H_r + h_vartheta/r")
def _(rng):
    (H, h, H_r), z = shear_system(rng), phase(rng)
    return H(*z), H_r(*z) + h(*z) / z[0]


@states("sec. 3, H_r not constant", "H_r and h_vartheta/r are not constants of motion separately")
def _(rng):
    (H, h, H_r), z = shear_system(rng), phase(rng)
    return claim(all(abs(bracket(f, H, z)) > APART for f in (H_r, lambda *z: h(*z) / z[0])))


@states("sec. 3, V_r stabilises", "without V_r (and with energy > 0) the radial mode is unbounded: r'' = 4H/mu > 0")
def _(rng):
    (_, h, _), z = shear_system(rng), phase(rng)

    def free(*z):
        return h(*z) / z[0] + 2 / MU * z[0] * z[4] ** 2

    def rate(*z):  # dr/dt
        return d(free, 4)(*z)

    n = 4
    with mp.workdps(100):
        acceleration = sum(d(rate, i)(*z) * d(free, n + i)(*z) - d(rate, n + i)(*z) * d(free, i)(*z) for i in range(n))
    return 4 / MU * free(*z), acceleration


@states(
    "EQ2.2c",
    "H = omega (2 J_r + J_lambda + J_mu + J_nu)",
    "(omega/2 pi)(2 J_r + J_lambda + J_mu + |J_nu|), J = closed integral of p dq",
)
def _(rng):
    C, (q, p) = rng.real(0.6, 1.4), (rng.reals(4), rng.reals(4))
    w = sqrt(C / MU)
    E = square(p) / (2 * MU) + C / 2 * square(q)
    nu = q[0] * p[1] - q[1] * p[0]  # p_nu turns x1, x2; L3 turns x1, x2, x3; L all four
    L3 = sum((q[i] * p[j] - q[j] * p[i]) ** 2 for j in range(3) for i in range(j))
    L = sum((q[i] * p[j] - q[j] * p[i]) ** 2 for j in range(4) for i in range(j))
    J_r = loop(lambda r: 2 * MU * E - MU * C * r * r - L / r**2, sqrt(square(q)))
    J_lambda = loop(lambda x: L - L3 / sin(x) ** 2, mp.acos(q[3] / sqrt(square(q))), 0, pi)
    shift = pi / 2
    J_mu = loop(lambda x: L3 - nu**2 / cos(x - shift) ** 2, shift + mp.asin(q[2] / sqrt(square(q[:3]))), 0, pi)
    J_nu = 2 * pi * nu
    return E, w * (2 * J_r + J_lambda + J_mu + J_nu), w / (2 * pi) * (2 * J_r + J_lambda + J_mu + abs(J_nu))


@states(
    "sec. 3, actions in R^3 x R",
    "E = (omega/2 pi)(2 J_R + J_theta + |J_chi| + J_u) in R^3 x R, EQ2.2c for the mixed coordinates (derived)",
)
def _(rng):
    C, (q, p) = rng.real(0.6, 1.4), (rng.reals(4), rng.reals(4))
    w = sqrt(C / MU)
    kinetic, potential = square(p) / (2 * MU), C / 2 * square(q)
    N = q[0] * p[1] - q[1] * p[0]
    L3 = sum((q[i] * p[j] - q[j] * p[i]) ** 2 for j in range(3) for i in range(j))
    E_R = square(p[:3]) / (2 * MU) + C / 2 * square(q[:3])
    E_u = p[3] ** 2 / (2 * MU) + C / 2 * q[3] ** 2
    J_R = loop(lambda r: 2 * MU * E_R - MU * C * r * r - L3 / r**2, sqrt(square(q[:3])))
    J_theta = loop(lambda x: L3 - N**2 / sin(x) ** 2, mp.acos(q[2] / sqrt(square(q[:3]))), 0, pi)
    far = 2 * sqrt(2 * E_u / C)
    J_u = loop(lambda x: 2 * MU * E_u - MU * C * x * x, q[3], -far, far)
    return kinetic + potential, w / (2 * pi) * (2 * J_R + J_theta + abs(2 * pi * N) + J_u)


# EQ2.2h


def hyperelastic(C):
    """Return EQ2.2h as a function of D1, D2: its last form."""
    return lambda D1, D2: C * (1 / (D1 * D2) + (D1**2 + D2**2) / 2)


def of_matrix(V):
    """Return V(D1, D2) as a function of the matrix elements, for det > 0: D1 +- D2 by the two planes."""

    def value(x, y, z, u):
        plus, minus = sqrt((x + u) ** 2 + (z - y) ** 2), sqrt((x - u) ** 2 + (z + y) ** 2)
        return V((plus + minus) / 2, (plus - minus) / 2)

    return value


@states("EQ2.2h", "C r/2 + 2C/(r cos vartheta) = C (1/(D1 D2) + (D1^2 + D2^2)/2)")
def _(rng):
    C, r, t = rng.real(0.5, 2), rng.real(0.5, 2), rng.real(0.1, 1.4)
    m = c.r_vartheta(r, t, *rng.reals(2))
    return C * (1 / c.determinant(m) + square(m) / 2), C / 2 * r + 2 * C / (r * cos(t))


@states("sec. 3, C(D1^2 + D2^2)/2", "C (D1^2 + D2^2)/2 = C (alpha^2 + beta^2)/2")
def _(rng):
    alpha, beta = rng.reals(2, 0.1, 2)
    return square(c.alpha_beta(alpha, beta, *rng.reals(2))) / 2, (alpha**2 + beta**2) / 2


@states(
    "EQ2.2h, no collapse",
    "1/(D1 D2) is repulsive at the point and the straight line",
    "from det > 0; V -> -infinity from det < 0",
    reading=True,
)
def _(rng):
    D1, tiny = rng.real(0.5, 1), mpf(10) ** -30
    V = hyperelastic(mpf(1))
    wall = [int(V(D1, side * tiny) > 1e20) for side in (1, -1)]
    return [1, 1], wall, [wall[0], int(V(D1, -tiny) < -1e20)]


@states("EQ2.2h, expansion", "the harmonic term prevents unlimited expansion: V -> infinity")
def _(rng):
    angle, far = rng.real(0.1, 1.4), mpf(10) ** 12
    return claim(hyperelastic(mpf(1))(far * cos(angle), far * sin(angle)) > 1e20)


def equilibrium(states, label, V, says, squares):
    """Add the claim of stable equilibria at D1 = D2 = 1: gradient 0, Hessian eigenvalues `squares` in units of C."""

    @states(label, says)
    def _(rng):
        C = rng.real(0.5, 2)
        at = list(c.rotation(rng.real(-3, 3)))
        f = V(C)
        hessian = mp.matrix([[dd(f, i, j)(*at) for j in range(4)] for i in range(4)])
        values = sorted(mp.eigsy(hessian, eigvals_only=True))
        return [0, 0, 0, 0, 1, *squares], [*gradient(f, at), int(min(values) > -1e-15), *(v / C for v in values)]


equilibrium(
    states,
    "EQ2.2h, equilibria",
    lambda C: lambda *m: C * (1 / c.determinant(m) + square(m) / 2),
    "stable continuum of relative equilibria at D1 = D2 = 1: one zero mode, omega^2 = (0, 2, 2, 4) C/mu",
    (0, 2, 2, 4),
)


@states("EQ2.2h, d^2V/dD1 dD2", "d^2 V/dD1 dD2 > 0 at D1 = D2 = 1 (it is C)")
def _(rng):
    C = rng.real(0.5, 2)
    value = dd(hyperelastic(C), 0, 1)(mpf(1), mpf(1))
    return [1, C], [int(value > 0), value]


@states("EQ2.2h, separable", "EQ2.2h separates in r, vartheta (and in neither alpha, beta nor kappa, lambda)")
def _(rng):
    z = phase(rng)
    polar = in_r_vartheta(lambda r: r / 2, lambda t: 2 / cos(t), lambda _: 0, lambda _: 0)
    V = of_matrix(hyperelastic(mpf(1)))

    def with_force(H, chart):
        return lambda *z: H(*z) + V(*chart(*z[:4]))

    ellipse = in_elliptic(*[lambda _: 0] * 4)

    def planes(a, b, eta, gamma, pa, pb, pe, pg):
        return (pa**2 + pb**2 + pe**2 / a**2 + pg**2 / b**2) / (2 * MU)

    others = [with_force(planes, c.alpha_beta), with_force(ellipse, c.elliptic)]
    return [1, 0], [int(all(levi_civita(H, z) > APART for H in others)), levi_civita(polar, z)]


@states("EQ3.1", "C/2 (alpha^2 + beta^2) = C/2 (D1^2 + D2^2) = C/2 (x^2 + y^2 + z^2 + u^2) = C/2 Tr(phi^T phi)")
def _(rng):
    alpha, beta, eta, gamma = *rng.reals(2, 0.2, 2), *rng.reals(2)
    m = c.alpha_beta(alpha, beta, eta, gamma)
    D = (alpha + beta) / sqrt(2), (alpha - beta) / sqrt(2)
    return [square(m)] * 3, [alpha**2 + beta**2, square(D), c.trace(c.product(c.transposed(m), m))]
