"""Section 5, continued: separation in r and vartheta, the spherical and the symmetric top."""

from __future__ import annotations

from collections import Counter
from itertools import combinations_with_replacement

import numpy as np
from mpmath import cos, cot, expj, mp, mpf, pi, sin, sqrt

from . import charts as c
from .constants import hyperelastic
from .dynamics import generic, in_r_vartheta
from .numerics import d, dd, laplacian, levels, square
from .quantum import HBAR, MU, angles_of, commutators, derivative, polar, smooth
from .record import DOUBLE, Chapter, claim

SHEAR = Chapter("Section 5: separation in r and vartheta, tops")
defines, states = SHEAR.defines, SHEAR.states


@states(
    "sec. 5, V cited as EQ2.2h",
    '"the doubly isotropic separable potential energy (EQ2.2h)", V = V_r + V_vartheta/r',
    "EQ2.2f with V_eta = V_gamma = 0",
)
def _(rng):
    Vr, Vt = generic(rng), generic(rng)
    r, t = rng.real(0.6, 2), rng.real(0.2, 1.2)
    D1D2, size = r * cos(t) / 2, r  # EQ2.2y, EQ2.2x
    D1, D2 = (sqrt(size + 2 * D1D2) + sqrt(size - 2 * D1D2)) / 2, (sqrt(size + 2 * D1D2) - sqrt(size - 2 * D1D2)) / 2
    family = in_r_vartheta(Vr, Vt, lambda _: 0, lambda _: 0)
    return Vr(r) + Vt(t) / r, hyperelastic(mpf(1))(D1, D2), family(r, t, *[mpf(0)] * 6)


defines("EQ4.3", "Psi = exp(i m varphi) exp(i l psi) f_r f_vartheta = exp(i m varphi) exp(i l psi) f_rho f_vartheta")


@states("EQ4.3, m and l", "m, l are integers", "m + l even")
def _(rng):
    q = polar(rng)
    m, l = rng.choice([(1, 0), (2, 1), (0, 3)])
    same = [*q[:2], q[2] + pi, q[3] + pi]
    assert square([a - b for a, b in zip(c.r_vartheta_angles(*q), c.r_vartheta_angles(*same))]) < 1e-40

    def jump(m, l):
        return expj(m * same[2] + l * same[3]) / expj(m * q[2] + l * q[3])

    return 1, jump(m, l), jump(m + 1, l)


def h_operator(V):
    """Return h_vartheta as printed, acting on functions of r, vartheta, varphi, psi."""

    def act(f):
        def value(*q):
            t = q[1]
            turned = -(HBAR**2) * (dd(f, 2, 2)(*q) + 2 * cos(t) * dd(f, 2, 3)(*q) + dd(f, 3, 3)(*q))
            shear = dd(f, 1, 1)(*q) + cot(t) * d(f, 1)(*q)
            return turned / (2 * MU * sin(t) ** 2) - 4 * HBAR**2 / (2 * MU) * shear + V(t) * f(*q)

        return value

    return act


def radial_operator(V):
    """Return H_r as printed."""
    return lambda f: lambda *q: -(HBAR**2) / (2 * MU) * (4 * q[0] * dd(f, 0, 0)(*q) + 8 * d(f, 0)(*q)) + V(q[0]) * f(*q)


def whole(V_r, V_t):
    """Return H = H_r + h_vartheta/r."""
    return lambda f: lambda *q: radial_operator(V_r)(f)(*q) + h_operator(V_t)(f)(*q) / q[0]


@states("sec. 5, h_vartheta", "-(hbar^2/2mu) r Delta without its radial part")
def _(rng):
    f, q = smooth(rng), polar(rng)

    def g(*q):
        return f(*c.r_vartheta_angles(*q))

    m = c.r_vartheta_angles(*q)
    # The angular part of Delta: all of it, less that of the radial motion alone, along the ray s -> s m.
    ray = [d(lambda s: f(*[s * x for x in m]), 0)(mpf(1)), dd(lambda s: f(*[s * x for x in m]), 0, 0)(mpf(1))]
    truth = -(HBAR**2) / (2 * MU) * (square(m) * laplacian(f, m) - ray[1] - 3 * ray[0])
    return truth, h_operator(lambda t: 0)(g)(*q)


@states("sec. 5, H = H_r + h_vartheta/r", "H = H_r + h_vartheta/r")
def _(rng):
    f, q = smooth(rng), polar(rng)

    def g(*q):
        return f(*c.r_vartheta_angles(*q))

    return -(HBAR**2) / (2 * MU) * laplacian(f, c.r_vartheta_angles(*q)), whole(lambda r: 0, lambda t: 0)(g)(*q)


@states("sec. 5, H_r = H_rho", "4r d^2/dr^2 + 8 d/dr = d^2/drho^2 + (3/rho) d/drho")
def _(rng):
    f, rho = generic(rng), rng.real(0.5, 2)

    def g(rho):
        return f(rho**2)

    r = rho**2
    return 4 * r * dd(f, 0, 0)(r) + 8 * d(f, 0)(r), dd(g, 0, 0)(rho) + 3 / rho * d(g, 0)(rho)


@states("sec. 5, shear commuting", "p_varphi, p_psi, h_vartheta, H commute pairwise")
def _(rng):
    f, q, V_r, V_t = smooth(rng), polar(rng), generic(rng), generic(rng)
    four = [h_operator(V_t), whole(V_r, V_t), derivative(2), derivative(3)]
    return [0] * 6, commutators(four, lambda *q: f(*c.r_vartheta_angles(*q)), q)


@states("sec. 5, Warning", "H_r and h_vartheta/r do not commute with H")
def _(rng):
    f, q, V_r, V_t = smooth(rng), polar(rng), generic(rng), generic(rng)

    def part(f):
        return lambda *q: h_operator(V_t)(f)(*q) / q[0]

    values = commutators([part, whole(V_r, V_t), radial_operator(V_r)], lambda *q: f(*c.r_vartheta_angles(*q)), q)
    return claim(abs(values[0]) > 1e-6 and abs(values[2]) > 1e-6)


# Separated equations: the operators on exp(i m varphi + i l psi) f(vartheta) or f(r)


def shear_wave(rng):
    """Return f, m, l, q and exp(i m varphi + i l psi) f(vartheta) as a function of the matrix elements (degree 0 in
    them).
    """
    f, q = generic(rng), polar(rng)
    m, l = rng.choice([(1, 1), (2, 0), (-3, 1), (0, -2), (1, 3)])

    def wave(*x):
        alpha, beta, eta, gamma = angles_of(x)
        return f(2 * mp.atan2(beta, alpha)) * eta ** ((m - l) // 2) * gamma ** ((m + l) // 2)

    return f, m, l, q, wave


@states(
    "EQ4.4, EQ4.6", "f'' + cot f' - ((m^2 + 2ml cos + l^2)/4 sin^2 + (mu/2 hbar^2)(V - e)) f = 0 is h_vartheta f = e f"
)
def _(rng):
    f, m, l, q, wave = shear_wave(rng)
    x, t, V = c.r_vartheta_angles(*q), q[1], generic(rng)
    e = (-(HBAR**2) / (2 * MU) * square(x) * laplacian(wave, x) / wave(*x) + V(t)) * f(
        t
    )  # h f; on an eigenfunction e f
    left = (
        dd(f, 0, 0)(t)
        + cot(t) * d(f, 0)(t)
        - ((m * m + 2 * m * l * cos(t) + l * l) / (4 * sin(t) ** 2) + MU / (2 * HBAR**2) * V(t)) * f(t)
    )
    return e, -2 * HBAR**2 / MU * left


def radial_truth(f, rho, e, V):
    """Return (H f)(rho) for a function of rho times an eigenfunction of h_vartheta with eigenvalue e, by the Laplacian
    of R^4.
    """
    radial = laplacian(lambda *x: f(sqrt(square(x))), [rho / 2] * 4)
    return -(HBAR**2) / (2 * MU) * radial + (V + e / rho**2) * f(rho)


@states("EQ4.5, EQ4.7", "4r f'' + 8 f' + (2mu/hbar^2)(E - (V_r + e/r)) f = 0")
def _(rng):
    f, V, r, e = generic(rng), generic(rng), rng.real(0.5, 2), rng.real(0.5, 2)
    truth = radial_truth(lambda rho: f(rho**2), sqrt(r), e, V(r))
    left = 4 * r * dd(f, 0, 0)(r) + 8 * d(f, 0)(r) - 2 * MU / HBAR**2 * (V(r) + e / r) * f(r)
    return truth, -(HBAR**2) / (2 * MU) * left


@states("EQ4.9", "f'' + 3 f'/rho + (2mu/hbar^2)(E - (V_rho + e/rho^2)) f = 0")
def _(rng):
    f, V, rho, e = generic(rng), generic(rng), rng.real(0.5, 2), rng.real(0.5, 2)
    left = dd(f, 0, 0)(rho) + 3 / rho * d(f, 0)(rho) - 2 * MU / HBAR**2 * (V(rho) + e / rho**2) * f(rho)
    return radial_truth(f, rho, e, V(rho)), -(HBAR**2) / (2 * MU) * left


def halved(f, t, m, l):
    """Return the left side of EQ4.8 without V - e, for halved m, l."""
    return dd(f, 0, 0)(t) + cot(t) * d(f, 0)(t) - (m * m + 2 * m * l * cos(t) + l * l) / sin(t) ** 2 * f(t)


@states("EQ4.8", "f'' + cot f' - ((m^2 + 2ml cos + l^2)/sin^2 + (mu/2 hbar^2)(V - e)) f = 0 with m, l halved")
def _(rng):
    f, m, l, q, wave = shear_wave(rng)
    x, t = c.r_vartheta_angles(*q), q[1]
    return square(x) * laplacian(wave, x) / wave(*x) * f(t) / 4, halved(f, t, mpf(m) / 2, mpf(l) / 2)


@states(
    "EQ4.8, m and l", "m, l run over the non-negative integers and half-integers", "over both signs, m - l an integer"
)
def _(rng):
    f, q = generic(rng), polar(rng)
    m, l = rng.choice([(1, -1), (3, -1), (-2, 2), (-3, 1)])
    x, t = c.r_vartheta_angles(*q), q[1]

    def wave(*x):
        alpha, beta, eta, gamma = angles_of(x)
        return f(2 * mp.atan2(beta, alpha)) * eta ** ((m - l) // 2) * gamma ** ((m + l) // 2)

    truth = square(x) * laplacian(wave, x) / wave(*x) * f(t) / 4
    return truth, halved(f, t, mpf(abs(m)) / 2, mpf(abs(l)) / 2), halved(f, t, mpf(m) / 2, mpf(l) / 2)


# Spherical top: EQ4.10


def spin(j):
    """Return J_x, J_y, J_z of spin j, rows m = -j..j, for j = 0, 1/2, 1, ..."""
    size = int(2 * j + 1)
    up = mp.zeros(size)
    for k in range(size - 1):
        m = -j + k
        up[k + 1, k] = sqrt(j * (j + 1) - m * (m + 1))
    return (up + up.T) / 2, (up - up.T) / 2j, mp.diag([-j + k for k in range(size)])


def little_d(j, m, l, angle):
    """Return d^j_ml(angle) = <m| exp(-i angle J_y) |l>, by diagonalising J_y: analytic in the angle."""
    Jy = spin(j)[1]
    values, vectors = mp.eighe(Jy)
    a, b = int(m + j), int(l + j)
    return mp.re(sum(vectors[a, k] * expj(-angle * values[k]) * mp.conj(vectors[b, k]) for k in range(Jy.rows)))


HALVES = ((mpf(3) / 2, mpf(1) / 2, mpf(3) / 2), (mpf(2), mpf(1), mpf(-2)), (mpf(1), mpf(1), mpf(1)))


@states("EQ4.10", "d^j_ml(Theta) solves EQ4.10", "d^j_{m,-l}(Theta) in the sign Psi = 2 psi")
def _(rng):
    (j, m, l), t = HALVES[rng.index], rng.real(0.5, 1.2)

    def side(sign):
        def f(t):
            return little_d(j, m, sign * l, t)

        return halved(f, t, m, l) / f(t) + 1  # + 1: of size one where the equation holds for another e

    return 1 - j * (j + 1), *(side(sign) for sign in (1, -1))


def shear_levels(m, l, V, count):
    """Return the lowest e_vartheta of class (m, l): with t = ln tan(vartheta/2), sin d/dvarphi = d/dt."""
    hbar, mu = float(HBAR), float(MU)

    def potential(t):
        x, s2 = -np.tanh(t), np.cosh(t) ** -2.0
        return (m * m + 2 * m * l * x + l * l) / 4 + s2 * mu / (2 * hbar**2) * V(x)

    return levels(potential, lambda t: mu / (2 * hbar**2) * np.cosh(t) ** -2.0, -15.0, 15.0, count, 0.12)


@states(
    "sec. 5, e_Theta", "e_{Theta j} = (2 hbar^2/mu) j(j+1), j = 0, 1/2, 1, ...: eigenvalues of EQ4.10", threshold=DOUBLE
)
def _(rng):
    m, l = ((3, 1), (2, 0), (1, -5))[rng.index]
    least = mpf(max(abs(m), abs(l))) / 2
    return shear_levels(m, l, lambda x: 0 * x, 3), [2 * HBAR**2 / MU * (least + k) * (least + k + 1) for k in range(3)]


@states(
    "sec. 5, D^j",
    "D^j_ml = exp(i m Phi) d^j_ml(Theta) exp(i l Psi) are matrix elements of a unitary representation of SU(2)",
)
def _(rng):
    def D(j, Phi, Theta, Psi):
        size = range(int(2 * j + 1))
        return mp.matrix(
            [[expj((a - j) * Phi) * little_d(j, a - j, b - j, Theta) * expj((b - j) * Psi) for b in size] for a in size]
        )

    one, two = rng.reals(3), rng.reals(3)
    product_half = D(mpf(1) / 2, *one) * D(mpf(1) / 2, *two)
    # Euler angles of the product from its j = 1/2 matrix [[e^{-i(P+Q)/2} cos, ...]], d^{1/2} = [[cos, +-sin], [-+sin,
    # cos]](T/2)
    T = 2 * mp.atan2(abs(product_half[0, 1]), abs(product_half[0, 0]))
    rising = D(mpf(1) / 2, 0, T, 0)
    plus, minus = mp.arg(product_half[1, 1] / rising[1, 1]), mp.arg(product_half[1, 0] / rising[1, 0])
    three = plus + minus, T, plus - minus
    return D(mpf(3) / 2, *one) * D(mpf(3) / 2, *two), D(mpf(3) / 2, *three)


@states(
    "sec. 5, eigenvalues m, l",
    "(hbar/i) d/dPhi D = hbar m D, (hbar/i) d/dPsi D = hbar l D; m, l from -j to j by steps of one",
)
def _(rng):
    j, m, l = HALVES[rng.index]
    q = rng.reals(3)

    def D(Phi, Theta, Psi):
        return expj(m * Phi) * little_d(j, m, l, Theta) * expj(l * Psi)

    values = sorted(mp.eighe(spin(j)[0])[0])
    return [HBAR * m, HBAR * l, *(-j + k for k in range(int(2 * j + 1)))], [
        HBAR / 1j * d(D, 0)(*q) / D(*q),
        HBAR / 1j * d(D, 2)(*q) / D(*q),
        *values,
    ]


def harmonic_polynomials(degree):
    """Return the number of harmonic polynomials of a degree in 4 variables: the kernel of the Laplacian on
    monomials.
    """

    def monomials(n):
        return [tuple(Counter(k)[i] for i in range(4)) for k in combinations_with_replacement(range(4), n)]

    here, below = monomials(degree), monomials(degree - 2) if degree > 1 else []
    matrix = np.zeros((max(len(below), 1), len(here)))
    for column, powers in enumerate(here):
        for i in range(4):
            if powers[i] > 1:
                matrix[below.index(tuple(p - 2 * (k == i) for k, p in enumerate(powers))), column] += powers[i] * (
                    powers[i] - 1
                )
    return len(here) - np.linalg.matrix_rank(matrix)


@states("sec. 5, E_j", "E_j = (hbar^2/2I) j(j+1), (2j+1)^2-fold: free spherical top on S^3")
def _(rng):
    I, k, x = rng.real(0.5, 2), rng.index + 1, rng.reals(4)  # degree 2j = k

    def wave(*x):  # harmonic of degree k, carried to degree 0
        return (mp.mpc(x[0], x[1]) ** k + 2 * mp.mpc(x[2], x[3]) ** k) / sqrt(square(x)) ** k

    # T = (I/2) 4 (unit S^3 metric), so H = -(hbar^2/2I) (1/4) Delta on S^3, and Delta on S^3 is r^2 Delta on degree 0
    truth = -(HBAR**2) / (8 * I) * square(x) * laplacian(wave, x) / wave(*x)
    j = mpf(k) / 2
    return [truth, harmonic_polynomials(k)], [HBAR**2 / (2 * I) * j * (j + 1), (2 * j + 1) ** 2]


def symmetric_top(j, I, K):
    """Return the sorted energies of H = (J1^2 + J2^2)/2I + J3^2/2K on spin j: each (2j+1)-fold, for m."""
    a, b, e = spin(j)
    return sorted(mp.eighe(HBAR**2 * ((a * a + b * b) / (2 * I) + e * e / (2 * K)))[0])


@states(
    "sec. 5, symmetric top", "E_{j,l} = (hbar^2/2I) j(j+1) + hbar^2 (1/2I - 1/2K) l^2", "+ hbar^2 (1/2K - 1/2I) l^2"
)
def _(rng):
    I, K, j = *rng.reals(2, 0.5, 2), HALVES[rng.index][0]

    def form(sign):
        return sorted(
            HBAR**2 / (2 * I) * j * (j + 1) + sign * HBAR**2 * (1 / (2 * I) - 1 / (2 * K)) * (-j + k) ** 2
            for k in range(int(2 * j + 1))
        )

    return symmetric_top(j, I, K), form(1), form(-1)


@states(
    "sec. 5, symmetric top, degeneracy",
    "the levels E_{j,l} are 2(2j+1)-fold degenerate",
    "2(2j+1)-fold for l != 0, (2j+1)-fold for l = 0",
)
def _(rng):
    j = mpf(rng.index + 1)
    values = symmetric_top(j, mpf(1), mpf(2))
    found = Counter(mp.nstr(value, 20) for value in values)
    counts = sorted(n * int(2 * j + 1) for n in found.values())
    whole = [2 * int(2 * j + 1)] * len(counts)
    return counts, whole, [int(2 * j + 1), *whole[1:]]
