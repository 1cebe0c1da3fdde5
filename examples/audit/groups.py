"""Section 7, derived: spectra of the invariant Laplacians on U(2) and on GL+(2,R)."""

from __future__ import annotations

import numpy as np
from mpmath import conj, cosh, hyp2f1, mp, mpc, mpf, sinh, sqrt

from . import charts as c
from .affine import cartan, entries
from .numerics import axis, d, dd, gradient, levels, metric
from .record import DOUBLE, Chapter
from .section7 import times

GROUPS = Chapter("Section 7, derived: levels on U(2) and on GL+(2,R)")
states = GROUPS.states


def laplacian_of(metric_at, f, q):
    """Return |g|^(-1/2) d_i |g|^(1/2) g^ij d_j f of a function, with the metric g at a point, by differences."""

    def flux(i):
        def value(*x):
            G = metric_at(x)
            inverse = mp.inverse(G)
            return sqrt(abs(mp.det(G))) * sum(inverse[i, j] * s for j, s in enumerate(gradient(f, x)))

        return value

    return sum(d(flux(i), i)(*q) for i in range(len(q))) / sqrt(abs(mp.det(metric_at(q))))


def UNITARY(a, Theta, Phi, Psi):
    """Return e^(i a/2) exp(Phi tau2) exp(Theta tau3) exp(Psi tau2)."""
    turn = mp.expj(Theta / 2)
    return times(mp.expj(a / 2), c.product(c.rotation(Phi / 2), (1 / turn, 0, 0, turn), c.rotation(Psi / 2)))


def unitary_point(rng):
    """Return random a, Theta, Phi, Psi away from the singular points."""
    return [rng.real(-3, 3), rng.real(0.6, 2.4), *rng.reals(2, -3, 3)]


@states(
    "EQ6.16, levels", "E = (hbar^2/2 mu)(k^2/(1 + c) + 4 j (j + 1)) of phi_11^p phi_21^q det^s, 2j = p + q, k = 2j + 2s"
)
def _(rng):
    p, q, s, extra = rng.randrange(4), rng.randrange(4), rng.randrange(-2, 3), rng.real(-0.5, 2)

    def metric_at(x):
        G = metric(UNITARY, x) / 2
        G[0, 0] += extra / 4  # |d ln det|^2 = da^2
        return G

    def f(*x):
        m = UNITARY(*x)
        return m[0] ** p * m[2] ** q * c.determinant(m) ** s

    x = unitary_point(rng)
    k, twice = p + q + 2 * s, p + q
    return -laplacian_of(metric_at, f, x) + f(*x), (mpf(k * k) / (1 + extra) + twice * (twice + 2) + 1) * f(*x)


@states("EQ6.16, double cover", "e^(i(k a + m Phi - l Psi)/2) is a function on U(2) for k, m, l of one parity alone")
def _(rng):
    k, m, l = (rng.randrange(-6, 7) for _ in range(3))
    a, Theta, Phi, Psi = unitary_point(rng)
    here = UNITARY(a, Theta, Phi, Psi)
    turns = [
        ((a + 2 * mp.pi, Theta, Phi, Psi + 2 * mp.pi), k - l),
        ((a, Theta, Phi + 2 * mp.pi, Psi + 2 * mp.pi), m - l),
    ]
    signs = [mp.re(mp.expj(mp.pi * number)) for _, number in turns]
    return [here, here, 1 - (k - l) % 2 * 2, 1 - (m - l) % 2 * 2], [UNITARY(*q) for q, _ in turns] + signs


def bilinear(I, A, B, left):
    """Return the metric I Tr(W^T W) + A Tr(W^2) + B (Tr W)^2 at matrix elements, W = phi^-1 dphi (left) or dphi
    phi^-1.
    """

    def metric_at(x):
        W = [cartan(entries, x, axis(4, i))[left] for i in range(4)]
        return mp.matrix(
            [
                [
                    I * c.trace(c.product(c.transposed(U), V))
                    + A * c.trace(c.product(U, V))
                    + B * c.trace(U) * c.trace(V)
                    for V in W
                ]
                for U in W
            ]
        )

    return metric_at


def lowest_weight(a, b):
    """Return d^b conj(c)^-a det^((a - b)/2) of matrix elements: m = a + b, l = b - a, k = (a - b)/2 of the series."""

    def f(x, y, z, u):
        first, second = ((x + u) + mpc(0, 1) * (z - y)) / 2, ((x - u) + mpc(0, 1) * (y + z)) / 2
        return second**b * conj(first) ** -a * (x * u - y * z) ** (mpf(a - b) / 2)

    return f


def matrix(rng):
    """Return random matrix elements with a positive determinant."""
    return [rng.real(1, 2), *rng.reals(2, -0.5, 0.5), rng.real(1, 2)]


for label, inertia, left in (
    ("EQ6.22, discrete levels", False, 0),
    ("sec. 7, left-invariant, discrete levels", True, 1),
    ("sec. 7, right-invariant, discrete levels", True, 0),
):

    @states(
        label,
        "E = hbar^2 k (1 - k)/(I + A) + hbar^2 I (l^2 or m^2)/(2 (I^2 - A^2)), k = (|m - l| - |m + l|)/4 - n (n = 0)",
    )
    def _(rng, inertia=inertia, left=left):
        b = rng.randrange(3)
        a = b + rng.randrange(2, 6)
        A, B, I = rng.real(0.3, 0.9), rng.real(0.1, 0.5), rng.real(1.2, 2) if inertia else mpf(0)
        f, x, k = lowest_weight(a, b), matrix(rng), mpf(a - b) / 2
        turn = (b - a if left else a + b) ** 2
        E = k * (1 - k) / (I + A) + I * turn / (2 * (I * I - A * A))
        return -laplacian_of(bilinear(I, A, B, left), f, x) / 2 + f(*x), (E + 1) * f(*x)


@states("EQ6.22, dilatation", "on functions of a alone H is -hbar^2/(I + A + 2 B) d^2/da^2, the measure is da")
def _(rng):
    A, B, I = rng.real(0.3, 0.9), rng.real(0.1, 0.5), rng.real(1.2, 2)
    w = rng.real(0.5, 2)
    x = matrix(rng)

    def f(*x):
        return c.determinant(x) ** w

    return -laplacian_of(bilinear(I, A, B, 1), f, x) / 2, -(w**2) / (I + A + 2 * B) * f(*x)


def radial(m, l):
    """Return L = -(1/sinh b) d/db sinh b d/db + (m^2 + l^2 + 2 m l cosh b)/(4 sinh^2 b), acting on f, as a function."""

    def L(f, b):
        slopes = dd(f, 0, 0)(b) + cosh(b) / sinh(b) * d(f, 0)(b)
        return -slopes + (m * m + l * l + 2 * m * l * cosh(b)) / (4 * sinh(b) ** 2) * f(b)

    return L


@states("EQ6.22, continuum", "L f = (1/4 + s^2) f: f ~ cos(s b + delta) e^(-b/2), the principal series, from 1/4 on")
def _(rng):
    m = rng.randrange(0, 5)
    l = m - 2 * rng.randrange(0, 5)
    alpha, beta, s = mpf(abs(m - l)) / 2, mpf(abs(m + l)) / 2, rng.real(0.2, 2)
    first = mpc(beta - alpha + 1, 2 * s) / 2

    def f(b):
        y = sinh(b / 2)
        return y**beta * cosh(b / 2) ** -alpha * hyp2f1(first, conj(first), 1 + beta, -y * y)

    b = rng.real(0.5, 2)
    far, step = mpf(60), mpf(1) / 2  # far out f e^(b/2) oscillates with s
    wave = [f(far + n * step) * mp.exp((far + n * step) / 2) for n in (-1, 0, 1)]
    return [radial(m, l)(f, b), wave[0] + wave[2]], [(mpf(1) / 4 + s * s) * f(b), 2 * mp.cos(s * step) * wave[1]]


@states(
    "EQ6.22, radial levels",
    "L has the levels k (1 - k), k = min(|m|, |l|)/2 - n > 1/2, for m l < 0, and no other below 1/4",
    threshold=DOUBLE,
)
def _(rng):
    m = rng.randrange(2, 8)
    l = -(m + 2 * rng.randrange(1, 4))  # v ~ e^(beta t), beta = |m + l|/2 > 0, decays at both ends
    shift = float(m * m)

    def potential(t):  # u = sqrt(sinh b) f, b = e^t, u = sqrt(b) v
        b = np.exp(t)
        Q = 0.25 - 0.25 / np.sinh(b) ** 2 + ((m * m + l * l) / np.sinh(b) + 2 * m * l / np.tanh(b)) / np.sinh(b) / 4
        return 0.25 + b * b * (Q + shift)

    count = m // 2
    found = levels(potential, lambda t: np.exp(2 * t), -20.0, 4.2, count + 1, 0.03)
    exact = [(m / 2 - n) * (1 - m / 2 + n) + shift for n in range(count)]
    return [*exact, 1], [*found[:count], int(found[count] - shift > 0.25)]
