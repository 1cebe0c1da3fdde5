"""Section 5: measure, Laplacians in each chart, operators, separated equations, spherical and symmetric tops."""

from __future__ import annotations

from itertools import product

from mpmath import cos, cosh, cot, coth, exp, expj, mp, mpf, pi, sin, sinh, sqrt

from . import charts as c
from .numerics import d, dd, determinant_ratio, gradient, jacobian, laplacian, metric, square
from .record import Chapter

QUANTUM = Chapter("Section 5: quantized problems")
defines, states = QUANTUM.defines, QUANTUM.states
MU, HBAR = mpf(3) / 4, mpf(7) / 10


def smooth(rng):
    """Return a random smooth function of the matrix elements."""
    k, w = rng.reals(4), rng.reals(4)
    return lambda *m: exp(sum(a * x for a, x in zip(k, m))) * (1 + sum(a * x * x for a, x in zip(w, m)))


def polar(rng):
    """Return random r (or rho), vartheta and two angles."""
    return [rng.real(0.6, 2.0), rng.real(0.4, 1.4), *rng.reals(2, -3, 3)]


def planes(rng):
    """Return random varphi, psi, alpha, beta."""
    return [*rng.reals(2, -3, 3), rng.real(0.6, 1.5), rng.real(0.3, 1.2)]


# Riemannian generalities

defines("sec. 5, G^ij", "inverse metric: G_ik G^kj = delta_i^j")


@states("sec. 5, weights", "|G| is a scalar density of weight two, sqrt|G| of weight one")
def _(rng):
    r, t, *angles = polar(rng)

    def to_planes(r, t):
        return [sqrt(r) * cos(t / 2), sqrt(r) * sin(t / 2)]

    fine, coarse = (
        mp.det(metric(c.r_vartheta, [r, t, *angles])),
        mp.det(metric(c.alpha_beta, [*to_planes(r, t), *angles])),
    )
    factor = determinant_ratio(to_planes, [r, t])
    return [fine, sqrt(fine)], [coarse * factor**2, sqrt(coarse) * factor]


@states("sec. 5, measure", "sqrt|G| dq is the Euclidean volume of matrix elements in every chart")
def _(rng):
    q = polar(rng)
    charts = (c.r_vartheta, c.r_vartheta_angles, c.rho_epsilon, c.euler, c.alpha_beta)
    return [abs(mp.det(jacobian(chart, q))) for chart in charts], [sqrt(mp.det(metric(chart, q))) for chart in charts]


def divergence_form(chart, f, q):
    """Return |G|^(-1/2) d_i(|G|^(1/2) G^ij d_j f) of a function of the coordinates."""
    n = len(q)

    def flux(i):
        def value(*x):
            G = metric(chart, x)
            return sqrt(mp.det(G)) * sum(mp.inverse(G)[i, j] * s for j, s in enumerate(gradient(f, x)))

        return value

    return sum(d(flux(i), i)(*q) for i in range(n)) / sqrt(mp.det(metric(chart, q)))


def covariant_form(chart, f, q):
    """Return G^ij nabla_i nabla_j f = G^ij (d_i d_j f - Gamma^k_ij d_k f), Gamma^k_ij from the second derivatives of
    the chart.
    """
    n = len(q)
    J = jacobian(chart, q)
    inverse, back, slope = mp.inverse(metric(chart, q)), mp.inverse(J), gradient(f, q)
    total = mpf(0)
    for i, j in product(range(n), repeat=2):
        bend = [dd(lambda *x, k=k: chart(*x)[k], i, j)(*q) for k in range(n)]
        gamma = back * mp.matrix(bend)
        total += inverse[i, j] * (dd(f, i, j)(*q) - sum(gamma[k] * slope[k] for k in range(n)))
    return total


@states("sec. 5, Laplace-Beltrami", "Delta = G^ij nabla_i nabla_j = |G|^(-1/2) d_i |G|^(1/2) G^ij d_j")
def _(rng):
    f, q = smooth(rng), polar(rng)

    def g(*x):
        return f(*c.r_vartheta(*x))

    with mp.workdps(80):
        return [laplacian(f, c.r_vartheta(*q))] * 2, [
            covariant_form(c.r_vartheta, g, q),
            divergence_form(c.r_vartheta, g, q),
        ]


defines("sec. 5, scalar product", "<Psi|Phi> = integral of conj(Psi) Phi dmu")


def decaying(rng):
    """Return two random polynomials times a Gaussian on a half line."""
    k, w = rng.reals(3), rng.reals(3)
    return tuple(lambda a, s=s: (s[0] + s[1] * a * a + s[2] * a**4) * exp(-a * a) for s in (k, w))


def half_line(f):
    """Return the integral of f from 0 to infinity, f decaying like a Gaussian: trapezoidal rule in ln a, 1e-15."""
    step = mpf("0.05")
    return step * sum(f(a) * a for a in (exp(k * step) for k in range(-800, 46)))


@states(
    "sec. 5, Delta symmetric",
    "<f|Delta g> = <Delta f|g> in the plane alpha, with the measure alpha dalpha",
    threshold=1e-12,
)
def _(rng):
    f, g = decaying(rng)

    def delta(f):
        return lambda a: dd(f, 0, 0)(a) + d(f, 0)(a) / a

    return half_line(lambda a: f(a) * delta(g)(a) * a), half_line(lambda a: delta(f)(a) * g(a) * a)


@states(
    "sec. 5, nabla_i skew",
    "nabla_i are skew-symmetric",
    "as nabla: scalars -> vectors, <X|nabla f> = -<nabla.X|f>; d/dalpha on functions is not",
    reading=True,
    threshold=1e-12,
)
def _(rng):
    f, g = decaying(rng)
    direct = half_line(lambda a: f(a) * d(g, 0)(a) * a)
    as_functions = -half_line(lambda a: d(f, 0)(a) * g(a) * a)
    covariant = -half_line(lambda a: (d(f, 0)(a) * a + f(a)) * g(a))  # nabla.X = (1/alpha) d(alpha f)/dalpha
    return direct, as_functions, covariant


@states("sec. 5, H classical", "H = (mu/2) G_ij dq dq + V = G^ij p_i p_j/2mu + V")
def _(rng):
    q, dq = polar(rng), mp.matrix(rng.reals(4))
    G = metric(c.r_vartheta, q)
    p = MU * G * dq
    return MU / 2 * (dq.T * G * dq)[0], (p.T * mp.inverse(G) * p)[0] / (2 * MU)


@states(
    "sec. 5, H operator", "H = -(hbar/2mu) Delta + V", "-(hbar^2/2mu) Delta: a plane wave exp(i p x/hbar) has p^2/2mu"
)
def _(rng):
    p, x = rng.reals(4), rng.reals(4)

    def wave(*x):
        return expj(sum(a * b for a, b in zip(p, x)) / HBAR)

    delta = laplacian(wave, x) / wave(*x)
    return square(p) / (2 * MU), -HBAR / (2 * MU) * delta, -(HBAR**2) / (2 * MU) * delta


# Coordinates (varphi, psi, alpha, beta)


@states("sec. 5, [G_ij]", "metric in varphi, psi, alpha, beta")
def _(rng):
    q = planes(rng)
    a, b = q[2:]
    G = mp.matrix(
        [[a * a + b * b, b * b - a * a, 0, 0], [b * b - a * a, a * a + b * b, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    )
    return metric(c.alpha_beta_angles, q), G


def plane_operator(i, sign, factor):
    """Return H_alpha (i = 2, sign -1) or H_beta (3, +1) without potential: (S +- Sigma)^2/(factor q^2) - hbar^2(d^2 +
    d/q), over 2mu.
    """

    def act(f):
        def value(*q):
            turned = -(HBAR**2) * (dd(f, 0, 0)(*q) + sign * 2 * dd(f, 0, 1)(*q) + dd(f, 1, 1)(*q))
            return (turned / (factor * q[i] ** 2) - HBAR**2 * (dd(f, i, i)(*q) + d(f, i)(*q) / q[i])) / (2 * MU)

        return value

    return act


def plane_laplacian(f, m, sign):
    """Return the Laplacian of f(x, y, z, u) along the plane (x + sign u, z - sign y)/sqrt2."""
    half = (dd(f, 0, 0)(*m) + 2 * sign * dd(f, 0, 3)(*m) + dd(f, 3, 3)(*m)) / 2
    return half + (dd(f, 2, 2)(*m) - 2 * sign * dd(f, 2, 1)(*m) + dd(f, 1, 1)(*m)) / 2


for name, i, sign in (("H_alpha", 2, -1), ("H_beta", 3, 1)):

    @states(
        f"sec. 5, {name}",
        f"(1/2mu)((S {'-+'[sign > 0]} Sigma)^2/q^2 - hbar^2(d^2/dq^2 + (1/q) d/dq)) + V, q = {name[2:]}",
        "(...)^2/4q^2",
    )
    def _(rng, i=i, sign=sign):
        f, q = smooth(rng), planes(rng)

        def g(*q):
            return f(*c.alpha_beta_angles(*q))

        truth = -(HBAR**2) / (2 * MU) * plane_laplacian(f, c.alpha_beta_angles(*q), -sign)
        return truth, plane_operator(i, sign, 1)(g)(*q), plane_operator(i, sign, 4)(g)(*q)


@states(
    "sec. 5, H = H_alpha + H_beta",
    "H = H_alpha + H_beta = -(hbar^2/2mu) Delta + V",
    "with the corrected H_alpha, H_beta",
)
def _(rng):
    f, q = smooth(rng), planes(rng)

    def g(*q):
        return f(*c.alpha_beta_angles(*q))

    sums = [plane_operator(2, -1, k)(g)(*q) + plane_operator(3, 1, k)(g)(*q) for k in (1, 4)]
    return -(HBAR**2) / (2 * MU) * laplacian(f, c.alpha_beta_angles(*q)), *sums


@states(
    "sec. 5, S and Sigma",
    "S = (hbar/i) d/dvarphi generates spatial rotations, Sigma = (hbar/i) d/dpsi material rotations",
)
def _(rng):
    f, q = smooth(rng), planes(rng)
    m = c.alpha_beta_angles(*q)
    slope = gradient(f, m)
    turns = [c.product((0, -1, 1, 0), m), c.product(m, (0, 1, -1, 0))]
    truth = [sum(a * b for a, b in zip(slope, turn)) for turn in turns]
    return truth, gradient(lambda *q: f(*c.alpha_beta_angles(*q)), q)[:2]


def commutators(operators, f, q):
    """Return [A, B] f at q for all pairs, divided by |A B f|."""
    with mp.workdps(90):
        out = []
        for i, A in enumerate(operators):
            for B in operators[:i]:
                one, two = A(B(f))(*q), B(A(f))(*q)
                out.append((one - two) / abs(one))
    return out


def with_potential(operator, V):
    """Return operator + V as an operator."""
    return lambda f: lambda *q: operator(f)(*q) + V(*q) * f(*q)


def derivative(i):
    """Return (hbar/i) d/dq_i without the i."""
    return lambda f: d(f, i)


@states("sec. 5, commuting", "H_alpha, H_beta, S, Sigma commute with one another")
def _(rng):
    f, q, k = smooth(rng), planes(rng), rng.reals(2)
    four = [
        with_potential(plane_operator(2, -1, 4), lambda *q: k[0] * q[2] ** 2 + 1 / q[2]),
        with_potential(plane_operator(3, 1, 4), lambda *q: k[1] * q[3] ** 4),
        derivative(0),
        derivative(1),
    ]
    return [0] * 6, commutators(four, lambda *q: f(*c.alpha_beta_angles(*q)), q)


@states("sec. 5, Delta (alpha, beta)", "Laplacian in varphi, psi, alpha, beta")
def _(rng):
    f, q = smooth(rng), planes(rng)

    def g(*q):
        return f(*c.alpha_beta_angles(*q))

    a, b = q[2:]
    printed = dd(g, 2, 2)(*q) + dd(g, 3, 3)(*q) + d(g, 2)(*q) / a + d(g, 3)(*q) / b
    printed += (1 / (4 * a * a) + 1 / (4 * b * b)) * (dd(g, 0, 0)(*q) + dd(g, 1, 1)(*q)) + (
        1 / (2 * b * b) - 1 / (2 * a * a)
    ) * dd(g, 0, 1)(*q)
    return laplacian(f, c.alpha_beta_angles(*q)), printed


def elliptic_operators(V_kappa=None, V_lambda=None):
    """Return H and K in kappa, lambda, eta, gamma, quantized from the corrected h_kappa, h_lambda (derived)."""
    half = HBAR**2 / (2 * MU)

    def h(i, g, q):
        trace = dd(g, i, i)(*q) + 2 * (coth(2 * q[0]) if i == 0 else cot(2 * q[1])) * d(g, i)(*q)
        if i == 0:
            trace += dd(g, 3, 3)(*q) / sinh(q[0]) ** 2 - dd(g, 2, 2)(*q) / cosh(q[0]) ** 2
        else:
            trace += dd(g, 3, 3)(*q) / sin(q[1]) ** 2 + dd(g, 2, 2)(*q) / cos(q[1]) ** 2
        V = (V_kappa, V_lambda)[i]
        return -half * trace + (V(q[i]) * g(*q) if V else 0)

    def operator(of_kappa, of_lambda):
        def applied(g):
            def value(*q):
                width = 2 * (cosh(q[0]) ** 2 - cos(q[1]) ** 2)
                return (of_lambda(q[1]) * h(0, g, q) + of_kappa(q[0]) * h(1, g, q)) / width

            return value

        return applied

    return operator(lambda k: 1, lambda l: 1), operator(lambda k: cosh(k) ** 2, lambda l: cos(l) ** 2)


@states("sec. 5, Delta (kappa, lambda)", "Laplacian in kappa, lambda, eta, gamma is (h_kappa + h_lambda)/2 Delta")
def _(rng):
    f, q = smooth(rng), [*rng.reals(2, 0.3, 0.9), *rng.reals(2)]

    def g(*q):
        return f(*c.elliptic(*q))

    return laplacian(f, c.elliptic(*q)), -2 * MU / HBAR**2 * elliptic_operators()[0](g)(*q)


@states("sec. 5, elliptic K", "K = (h_kappa cos^2 lambda + h_lambda cosh^2 kappa)/2 Delta commutes with H (derived)")
def _(rng):
    f, q, k = smooth(rng), [*rng.reals(2, 0.3, 0.9), *rng.reals(2)], rng.reals(2)
    H, K = elliptic_operators(lambda x: k[0] * cosh(x) ** 3, lambda x: k[1] * sin(x) ** 3)
    return [0], commutators([H, K], lambda *q: f(*c.elliptic(*q)), q)


def angles_of(m):
    """Return alpha, beta, exp(i eta), exp(i gamma) of matrix elements."""
    a, b = mp.mpc(m[0] + m[3], m[2] - m[1]) / sqrt(2), mp.mpc(m[0] - m[3], m[1] + m[2]) / sqrt(2)
    return abs(a), abs(b), a / abs(a), b / abs(b)


for label, name, sign in (("EQ4.1", "alpha", -1), ("EQ4.2", "beta", 1)):

    @states(label, f"f'' + f'/q - (m {'-+'[sign > 0]} l)^2 f/4q^2 + (2mu/hbar^2)(E - V) f = 0, q = {name}")
    def _(rng, sign=sign):
        f, q = decaying(rng)[0], planes(rng)
        m, l = rng.choice([(1, 1), (2, 0), (-3, 1), (0, -2), (1, 5)])
        at = q[2] if sign < 0 else q[3]

        def wave(*x):  # exp(i(m varphi + l psi)) f(alpha) or f(beta), with its part of the phase
            alpha, beta, eta, gamma = angles_of(x)
            return f(alpha) * eta ** ((m - l) // 2) if sign < 0 else f(beta) * gamma ** ((m + l) // 2)

        x = c.alpha_beta_angles(*q)
        truth = laplacian(wave, x) / (wave(*x) / f(at))  # = -(2mu/hbar^2)(E - V) f for a solution
        return truth, dd(f, 0, 0)(at) + d(f, 0)(at) / at - mpf((m + sign * l) ** 2) / (4 * at * at) * f(at)


@states("EQ2.1, V_eta quantised", "H separates: -hbar^2 X''/2mu + V_eta X = c X, and (m - l)^2/4 becomes 2 mu c/hbar^2")
def _(rng):
    f, g, X, Y = (
        lambda x, k=k: exp(k[0] * sin(x)) * (1 + k[1] * cos(x) ** 2 / 3) for k in [rng.reals(2) for _ in range(4)]
    )
    constants = rng.reals(2)
    energies = rng.reals(2)
    unit = HBAR**2 / (2 * MU)

    def angular(x, at, constant):  # V_eta of which x is a solution
        return constant + unit * dd(x, 0, 0)(at) / x(at)

    def radial(x, at, constant, energy):  # V_alpha of which x is a solution, with 2 mu c/hbar^2 for (m - l)^2/4
        return energy + unit * (dd(x, 0, 0)(at) / x(at) + d(x, 0)(at) / (at * x(at))) - constant / at**2

    def wave(*x):
        alpha, beta, eta, gamma = angles_of(x)
        return f(alpha) * g(beta) * X(mp.arg(eta)) * Y(mp.arg(gamma))

    alpha, beta, eta, gamma = rng.real(0.6, 1.5), rng.real(0.3, 1.2), *rng.reals(2, -2, 2)
    V = radial(f, alpha, constants[0], energies[0]) + radial(g, beta, constants[1], energies[1])
    V += angular(X, eta, constants[0]) / alpha**2 + angular(Y, gamma, constants[1]) / beta**2
    x = c.alpha_beta(alpha, beta, eta, gamma)
    return sum(energies), -unit * laplacian(wave, x) / wave(*x) + V


@states(
    "sec. 5, m and l",
    "exp(i m varphi) exp(i l psi) with any integers m, l",
    "m + l even: (varphi + pi, psi + pi) is the same matrix",
)
def _(rng):
    m, l = rng.choice([(1, 0), (2, 1), (0, 3)])
    varphi, psi = rng.reals(2)

    def jump(m, l):
        return expj(m * (varphi + pi) + l * (psi + pi)) / expj(m * varphi + l * psi)

    return 1, jump(m, l), jump(m, l + 1)


# Coordinates (r, vartheta)


@states("sec. 5, Delta (r, vartheta)", "Laplacian in r, vartheta, varphi, psi")
def _(rng):
    f, q = smooth(rng), polar(rng)
    r, t = q[:2]

    def g(*q):
        return f(*c.r_vartheta_angles(*q))

    angular = (dd(g, 2, 2)(*q) + 2 * cos(t) * dd(g, 2, 3)(*q) + dd(g, 3, 3)(*q)) / (r * sin(t) ** 2)
    shear = 4 / r * (dd(g, 1, 1)(*q) + cot(t) * d(g, 1)(*q))
    return laplacian(f, c.r_vartheta_angles(*q)), 4 * r * dd(g, 0, 0)(*q) + 8 * d(g, 0)(*q) + angular + shear


@states(
    "sec. 5, Delta (rho, Theta)",
    "Laplacian in rho, Phi, Theta, Psi with 2 cot(Theta) at the mixed derivative",
    "2 cos(Theta), for Psi = 2 psi",
)
def _(rng):
    f, q = smooth(rng), polar(rng)
    rho, t = q[:2]

    def g(*q):
        return f(*c.euler(*q))

    def form(cross):
        angular = (dd(g, 2, 2)(*q) + 2 * cross * dd(g, 2, 3)(*q) + dd(g, 3, 3)(*q)) / sin(t) ** 2
        shear = dd(g, 1, 1)(*q) + cot(t) * d(g, 1)(*q)
        return dd(g, 0, 0)(*q) + 3 / rho * d(g, 0)(*q) + 4 / rho**2 * (angular + shear)

    return laplacian(f, c.euler(*q)), form(cot(t)), form(cos(t))
