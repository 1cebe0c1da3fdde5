"""Section 6: quantum levels and wave functions of the harmonic and anharmonic models."""

from __future__ import annotations

from functools import cache
from math import comb

import numpy as np
from mpmath import cos, cot, exp, factorial, gamma, hyp1f1, hyp2f1, mp, mpf, pi, rf, sin, sqrt, tan

from .classical import quantised
from .numerics import d, dd, levels
from .quantum import HBAR, MU
from .record import DOUBLE, Chapter
from .shear import shear_levels
from .tori import C

WAVES = Chapter("Section 6: quantized harmonic and anharmonic vibrations")
defines, states = WAVES.defines, WAVES.states
CLASSES = ((3, 1), (1, -5), (4, 2), (-3, 1), (5, -1))
"""(m, l) with m + l even and neither angular momentum 0: the levels decay in the logarithm of the radius."""


def omega():
    """Return sqrt(C/mu)."""
    return sqrt(C / MU)


def kappa():
    """Return sqrt(C mu)/hbar."""
    return sqrt(C * MU) / HBAR


def quotient():
    """Return 16 C mu/hbar^2."""
    return 16 * C * MU / HBAR**2


@cache
def plane_levels(p, wall):
    """Return the 8 lowest energies of a plane with angular momentum p hbar: V = C q^2/2 + wall 2C/q^2, in t = ln q."""
    hbar, mu, k = float(HBAR), float(MU), float(C)

    def potential(t):
        q2 = np.exp(2 * t)
        return p * p + 2 * mu / hbar**2 * q2 * (k / 2 * q2 + wall * 2 * k / q2)

    return levels(potential, lambda t: 2 * mu / hbar**2 * np.exp(2 * t), -15.0, 2.0, 8, 0.08)


def radial_levels(e, V, count):
    """Return the lowest energies of the rho-equation EQ4.9 with V_rho = V(rho^2): t = ln rho, f = g/rho."""
    hbar, mu = float(HBAR), float(MU)

    def potential(t):
        r = np.exp(2 * t)
        return 1 + 2 * mu / hbar**2 * (V(r) * r + float(e))

    return levels(potential, lambda t: 2 * mu / hbar**2 * np.exp(2 * t), -12.0, 2.0, count, 0.08)


def tower(m, l, wall, count=4):
    """Return the lowest energies E_alpha + E_beta of a class, sorted."""
    one, two = plane_levels(abs(m - l) / 2, wall), plane_levels(abs(m + l) / 2, 0)
    return sorted(a + b for a in one for b in two)[:count]


# Harmonic


@states("EQ5.1", "E = (hbar omega/2)(4n + 4 + |m - l| + |m + l|), n = n_alpha + n_beta", threshold=DOUBLE)
def _(rng):
    m, l = CLASSES[rng.index]
    n = [i + j for i in range(4) for j in range(4)]
    return tower(m, l, 0), [HBAR * omega() / 2 * (4 * k + 4 + abs(m - l) + abs(m + l)) for k in sorted(n)[:4]]


@states("sec. 6, E_alpha, E_beta", "E_alpha = (hbar omega/2)(4 n_alpha + 2 + |m - l|), E_beta with +", threshold=DOUBLE)
def _(rng):
    m, l = CLASSES[rng.index]
    truth = [plane_levels(abs(m - l) / 2, 0)[:4], plane_levels(abs(m + l) / 2, 0)[:4]]
    return truth, [[HBAR * omega() / 2 * (4 * n + 2 + abs(m + s * l)) for n in range(4)] for s in (-1, 1)]


@states(
    "EQ5.1, m and l",
    "m, l = 0, +-1, ...: the level N = 2n + max(|m|, |l|) of four oscillators is (N+3 choose 3)-fold",
    "m + l even",
)
def _(rng):
    N = rng.index + 2
    quanta = [
        (n, m, l) for m in range(-N, N + 1) for l in range(-N, N + 1) for n in [N - max(abs(m), abs(l))] if n % 2 == 0
    ]
    # n = n_alpha + n_beta = (N - max)/2 is reached in n + 1 ways
    count = [sum(n // 2 + 1 for n, m, l in quanta if not even or (m + l) % 2 == 0) for even in (False, True)]
    return comb(N + 3, 3), *count


def regular(p, n, q):
    """Return f, the power series solution q^p exp(-k q^2/2) 1F1(-n; 1 + p; k q^2) of the plane oscillator."""
    k = kappa()
    return q**p * exp(-k * q * q / 2) * hyp1f1(-n, 1 + p, k * q * q)


def plane_energy(f, q, p, wall=0):
    """Return H f/f of a plane with angular momentum p hbar and V = C q^2/2 + wall 2C/q^2."""
    bend = dd(f, 0, 0)(q) + d(f, 0)(q) / q - p * p / q**2 * f(q)
    return -(HBAR**2) / (2 * MU) * bend / f(q) + C / 2 * q**2 + wall * 2 * C / q**2


for roman, region, rows, pick in (
    ("(i)", "|m| > |l|", ((1, 3, 1), (0, -3, 1), (2, -2, 0)), 1),
    ("(ii)", "|m| < |l|", ((2, 1, -3), (0, 0, 4), (1, 1, 5)), 2),
    ("(iii)", "|m| = |l|", ((1, 2, -2), (0, 3, 3), (2, -1, 1)), 1),
):

    @states(
        f"EQ5.1, {roman}",
        f"{region}: E = hbar omega (2n + 2 +- {'ml'[pick - 1]})",
        "+- is the sign of the number: its absolute value",
        reading=True,
    )
    def _(rng, rows=rows, pick=pick):
        n, m, l = rows[rng.index]
        number, q = rows[rng.index][pick], rng.real(0.5, 1)
        a, b = mpf(abs(m - l)) / 2, mpf(abs(m + l)) / 2
        E = plane_energy(lambda q: regular(a, n, q), q, a) + plane_energy(lambda q: regular(b, 0, q), q, b)
        return (
            [E, E],
            [HBAR * omega() * (2 * n + 2 + s * number) for s in (1, -1)],
            [HBAR * omega() * (2 * n + 2 + abs(number))] * 2,
        )


defines("sec. 6, F_1 and F_2", "the hypergeometric functions 2F1 and 1F1")
defines("sec. 6, sigma, gamma, kappa", "sigma = |m - l|/2, gamma = |m + l|/2, kappa = sqrt(C mu/hbar^2)")


def printed_plane(s, n):
    """Return f_alpha or f_beta as printed, with its prefactor."""
    k = kappa()
    return lambda q: q**s * k ** (mpf(1) / 4 + s / 2) * exp(-k / 2 * q * q) * hyp1f1(-n, 1 + s, k * q * q)


def norm_of_plane(s, n):
    """Return the prefactor of the normalised factor: kappa^((1+s)/2) sqrt(2 Gamma(n+s+1)/n!)/Gamma(s+1)."""
    return kappa() ** ((1 + s) / 2) * sqrt(2 * gamma(n + s + 1) / factorial(n)) / gamma(s + 1)


def integral(f, low, high):
    """Return the integral of a smooth function by Gauss-Legendre in 30 digits."""
    with mp.workdps(30):
        return mp.quad(f, [low + (high - low) * mpf(k) / 4 for k in range(5)], method="gauss-legendre", maxdegree=6)


def plane_function(name, model, exponent, wall):
    """Add f_alpha or f_beta of a model: as a solution, and its norm in L^2(q dq)."""

    def case(rng):
        m, l = CLASSES[rng.index]
        p = mpf(abs(m - l if name == "alpha" else m + l)) / 2
        return p, exponent(m, l), rng.index

    @states(f"sec. 6, f_{name} ({model})", f"f_{name} solves EQ4.{1 + (name == 'beta')}")
    def _(rng):
        p, s, n = case(rng)
        E = HBAR * omega() * (2 * n + 1 + s)
        return E, plane_energy(printed_plane(s, n), rng.real(0.4, 1.2), p, wall)

    @states(
        f"sec. 6, f_{name} norm ({model})",
        "kappa^(1/4 + s/2) as normalisation in the measure q dq",
        "kappa^((1+s)/2) sqrt(2 Gamma(n+s+1)/n!)/Gamma(s+1)",
        threshold=1e-15,
    )
    def _(rng):
        _, s, n = case(rng)
        f, k = printed_plane(s, n), kappa()
        square = integral(lambda x: f(x * x) ** 2 * x * x * 2 * x, 0, mpf("2.6"))  # q = x^2 keeps the power at 0 smooth
        return 1, square, square * (norm_of_plane(s, n) / k ** (mpf(1) / 4 + s / 2)) ** 2


def sigma(m, l):
    """Exponent |m - l|/2."""
    return mpf(abs(m - l)) / 2


def sum_exponent(m, l):
    """Exponent |m + l|/2."""
    return mpf(abs(m + l)) / 2


def chi(m, l):
    """Exponent sqrt((m - l)^2 + 16 C mu/hbar^2)/2."""
    return sqrt((m - l) ** 2 + quotient()) / 2


plane_function("alpha", "harmonic", sigma, 0)
plane_function("beta", "harmonic", sum_exponent, 0)


@states(
    "sec. 6, the constant 4",
    "the rigorous level exceeds the quasiclassical one EQ3.2 by the constant 4 (2 hbar omega)",
    threshold=DOUBLE,
)
def _(rng):
    n, m, l = ((1, 3, 1), (0, 1, -3), (1, 4, 2))[rng.index]
    # hbar = 7/10, mu and C are those of the classical part, too
    return tower(m, l, 0, 8)[n * (n + 1) // 2] - quantised(0, n, m, l), 4 * HBAR * omega() / 2


# EQa


@states("EQ5.2", "E = (hbar omega/2)(4n + 4 + |m + l| + sqrt((m - l)^2 + 16 C mu/hbar^2))", threshold=DOUBLE)
def _(rng):
    m, l = CLASSES[rng.index]
    n = sorted(i + j for i in range(4) for j in range(4))[:4]
    return tower(m, l, 1), [HBAR * omega() / 2 * (4 * k + 4 + abs(m + l) + sqrt((m - l) ** 2 + quotient())) for k in n]


@states("EQ5.2, n", "E depends on n = n_alpha + n_beta only: (n+1)-fold in each class (m, l)", threshold=DOUBLE)
def _(rng):
    m, l = CLASSES[rng.index]
    found = tower(m, l, 1, 10)
    return [found[k] for k in (1, 3, 3, 6, 6, 6)], [found[k] for k in (2, 4, 5, 7, 8, 9)]


plane_function("alpha", "EQa", chi, 1)
plane_function("beta", "EQa", sum_exponent, 0)
defines("sec. 6, chi", "chi = sqrt((m - l)^2 + 16 C mu/hbar^2)/2")


@states(
    "sec. 6, EQ3.6 again",
    "the quasiclassical formula is almost identical with the rigorous one: the same, less 4",
    threshold=DOUBLE,
)
def _(rng):
    m, l = CLASSES[rng.index]
    return tower(m, l, 1, 1)[0] - quantised(1, 0, m, l), 4 * HBAR * omega() / 2


@states(
    "sec. 6, effective quantum numbers",
    "levels are controlled by n_alpha + n_beta + |m + l| and |m - l|",
    "4(n_alpha + n_beta) + |m + l|",
    threshold=DOUBLE,
)
def _(rng):
    here = CLASSES[rng.index]
    s, D = abs(sum(here)), here[0] - here[1]

    def lowest(total, n):
        return tower((total + D) / 2, (total - D) / 2, 1, 8)[n * (n + 1) // 2]

    # |m + l| = s and n = 2 against n = 0 and |m + l| = s + 2, or s + 8
    truth = lowest(s, 2)
    return truth, lowest(s + 2, 0), lowest(s + 8, 0)


# EQb


@states("sec. 6, EQb", "(C/2)(r + 4/r) + (2C/r) tan^2(vartheta/2) is EQa")
def _(rng):
    r, t = rng.real(0.5, 2), rng.real(0.2, 1.4)
    alpha, beta = sqrt(r) * cos(t / 2), sqrt(r) * sin(t / 2)
    return C / 2 * (alpha**2 + 4 / alpha**2) + C / 2 * beta**2, C / 2 * (r + 4 / r) + 2 * C / r * tan(t / 2) ** 2


def well(x):
    """Return V_vartheta = 2C tan^2(vartheta/2) of x = cos(vartheta)."""
    return 2 * float(C) * (1 - x) / (1 + x)


def shear_constant(n, m, l):
    """Return e_vartheta as printed."""
    return HBAR**2 / (8 * MU) * ((4 * n + 2 + abs(m + l) + sqrt((m - l) ** 2 + quotient())) ** 2 - 4 - quotient())


@states(
    "EQ3.2.2",
    "E = (hbar omega/2)(4n + 4 + |m + l| + sqrt((m - l)^2 + 16 C mu/hbar^2)), n = n_r + n_vartheta",
    threshold=DOUBLE,
)
def _(rng):
    m, l = CLASSES[rng.index]
    k = float(C)
    two_steps = [radial_levels(e, lambda r: k / 2 * (r + 4 / r), 3) for e in shear_levels(m, l, well, 2)]
    return two_steps, [
        [HBAR * omega() / 2 * (4 * (n + j) + 4 + abs(m + l) + sqrt((m - l) ** 2 + quotient())) for n in range(3)]
        for j in range(2)
    ]


@states(
    "sec. 6, e_vartheta",
    "e_vartheta = (hbar^2/8mu)((4 n_vartheta + 2 + |m + l| + 2 chi)^2 - 4 - 16 C mu/hbar^2), V_vartheta = 2C tan^2",
    threshold=DOUBLE,
)
def _(rng):
    m, l = CLASSES[rng.index]
    return shear_levels(m, l, well, 3), [shear_constant(n, m, l) for n in range(3)]


@states(
    "sec. 6, e_vartheta of section 4",
    "the same e_vartheta with V_vartheta = 2C/cos^2(vartheta/2)",
    "without - 16 C mu/hbar^2 (that is, + 2C)",
    threshold=DOUBLE,
)
def _(rng):
    m, l = CLASSES[rng.index]
    truth = shear_levels(m, l, lambda x: 4 * float(C) / (1 + x), 3)
    return truth, [shear_constant(n, m, l) for n in range(3)], [shear_constant(n, m, l) + 2 * C for n in range(3)]


def shear_function(n, m, l):
    """Return f_vartheta as printed."""
    g, x = sum_exponent(m, l), chi(m, l)
    return lambda t: cos(t / 2) ** x * sin(t / 2) ** g * hyp2f1(-n, 1 + n + g + x, 1 + x, cos(t / 2) ** 2)


def radial_function(n, eps):
    """Return f_r as printed."""
    k = kappa()
    return lambda r: (
        r ** (eps - mpf(1) / 2) * k ** (eps + mpf(1) / 2) * exp(-k * r / 2) * hyp1f1(-n, 1 + 2 * eps, k * r)
    )


def epsilon(n, m, l, term):
    """Return sqrt(1 + 2 mu e/hbar^2 + term C mu/hbar^2)/2."""
    return sqrt(1 + 2 * MU / HBAR**2 * shear_constant(n, m, l) + term * C * MU / HBAR**2) / 2


def radial_sides(rng, term):
    """Return (H_r + e/r) f_r/f_r at two points for EQb, n_r = 1, 0, 2."""
    m, l = CLASSES[rng.index]
    n, k = (1, 0, 2)[rng.index], 1
    f = radial_function(n, epsilon(k, m, l, term))

    def energy(r):
        bend = 4 * r * dd(f, 0, 0)(r) + 8 * d(f, 0)(r)
        return -(HBAR**2) / (2 * MU) * bend / f(r) + C / 2 * (r + 4 / r) + shear_constant(k, m, l) / r

    E = HBAR * omega() / 2 * (4 * (n + k) + 4 + abs(m + l) + sqrt((m - l) ** 2 + quotient()))
    return [E, E], [energy(mpf("0.45")), energy(mpf("0.8"))]


@states("sec. 6, epsilon", "f_r solves EQ4.7 with epsilon = sqrt(1 + 2 mu e/hbar^2 + 2 C mu/hbar^2)/2", "4 C mu/hbar^2")
def _(rng):
    (truth, printed), (_, corrected) = radial_sides(rng, 2), radial_sides(rng, 4)
    return truth, printed, corrected


@states(
    "sec. 6, f_r",
    "f_r = r^(-1/2 + eps) exp(-kappa r/2) F_2(-n_r; 1 + 2 eps; kappa r) solves EQ4.7 (with the corrected epsilon)",
)
def _(rng):
    return radial_sides(rng, 4)


@states(
    "sec. 6, f_vartheta", "f_vartheta solves EQ4.6 with V_vartheta = 2C tan^2(vartheta/2) and the printed e_vartheta"
)
def _(rng):
    (m, l), n, t = CLASSES[rng.index], rng.index, rng.real(0.4, 1.3)
    f = shear_function(n, m, l)
    bend = dd(f, 0, 0)(t) + cot(t) * d(f, 0)(t) - (m * m + 2 * m * l * cos(t) + l * l) / (4 * sin(t) ** 2) * f(t)
    return shear_constant(n, m, l), -2 * HBAR**2 / MU * bend / f(t) + 2 * C * tan(t / 2) ** 2


@states(
    "sec. 6, f_r norm",
    "kappa^(1/2 + eps) as normalisation in the measure r dr",
    "kappa^(1/2+eps) sqrt(Gamma(n+2eps+1)/n!)/Gamma(2eps+1)",
    threshold=1e-15,
)
def _(rng):
    (m, l), n = CLASSES[rng.index], rng.index
    eps = epsilon(1, m, l, 4)
    f = radial_function(n, eps)
    square = integral(lambda x: f(x) ** 2 * x, mpf(10) ** -30, mpf(90))
    return 1, square, square * gamma(n + 2 * eps + 1) / factorial(n) / gamma(2 * eps + 1) ** 2


@states(
    "sec. 6, f_vartheta norm",
    "1 as normalisation in the measure sin(vartheta) dvartheta",
    "((1+chi)_n/n!) sqrt((2n+g+chi+1) n! Gamma(n+g+chi+1)/(2 Gamma(n+g+1) Gamma(n+chi+1)))",
    threshold=1e-15,
)
def _(rng):
    (m, l), n = CLASSES[rng.index], rng.index
    g, x, f = sum_exponent(m, l), chi(m, l), shear_function(n, m, l)
    square = integral(lambda t: f(t) ** 2 * sin(t), mpf(0), pi)
    norm = (
        rf(1 + x, n)
        / factorial(n)
        * sqrt((2 * n + g + x + 1) * factorial(n) * gamma(n + g + x + 1) / (2 * gamma(n + g + 1) * gamma(n + x + 1)))
    )
    return 1, square, square * norm**2
