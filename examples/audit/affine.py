"""Section 7, continued: affinely invariant metrics on GL+(2,R) and their complexification."""

from __future__ import annotations

from mpmath import cosh, exp, expj, mp, mpf, sqrt

from . import charts as c
from .numerics import along
from .record import Chapter
from .section7 import GROUP, TILDE, commutator, euler_group, point, times, wheel

AFFINE = Chapter("Section 7: affinely invariant metrics")
states = AFFINE.states


# Affinely invariant metrics


def cartan(chart, q, v):
    """Return Omega = dphi phi^-1 and phi^-1 dphi."""
    m, dm = chart(*q), tuple(along(chart, q, v))
    return c.product(dm, c.inverse(m)), c.product(c.inverse(m), dm)


def entries(*m):
    """Return the matrix elements themselves, as a chart."""
    return m


@states("EQ6.17", "Tr(Omega^2) = Tr(Omega^^2), invariant under phi -> A phi B")
def _(rng):
    q, v, A, B = (rng.reals(4) for _ in range(4))
    one, other = cartan(entries, q, v)
    moved, _ = cartan(lambda *m: c.product(A, m, B), q, v)
    first = c.trace(c.product(one, one))
    return [first, first], [c.trace(c.product(other, other)), c.trace(c.product(moved, moved))]


@states("EQ6.18", "(Tr Omega)^2 = (Tr Omega^)^2 is purely dilatational: (d ln det)^2")
def _(rng):
    q, v = rng.reals(4), rng.reals(4)
    one, other = cartan(entries, q, v)
    rate = along(lambda *m: [mp.log(abs(c.determinant(m)))], q, v)[0]
    return [rate**2] * 2, [c.trace(one) ** 2, c.trace(other) ** 2]


@states("EQ6.19", "Omega^ = phi^-1 dphi = phi^-1 Omega phi")
def _(rng):
    q, v = rng.reals(4), rng.reals(4)
    one, other = cartan(entries, q, v)
    return other, c.product(c.inverse(q), one, q)


def matrix_units():
    """Return the four matrix units."""
    return [tuple(mpf(i == k) for i in range(4)) for k in range(4)]


@states("EQ6.17, signature", "Tr(Omega^2) is non-degenerate of signature (+++-)")
def _(rng):
    units = matrix_units()
    values = mp.eigsy(mp.matrix([[c.trace(c.product(p, q)) for q in units] for p in units]), eigvals_only=True)
    return [-1, 1, 1, 1], sorted(mp.sign(v) for v in values if abs(v) > 1e-20)


@states("sec. 7, Killing", "the Killing tensor is 4 Tr(Omega^2) - 2 (Tr Omega)^2")
def _(rng):
    units, p, q = matrix_units(), rng.reals(4), rng.reals(4)
    # Tr(ad p ad q), from the commutators alone
    truth = sum(commutator(p, commutator(q, unit))[k] for k, unit in enumerate(units))
    return truth, 4 * c.trace(c.product(p, q)) - 2 * c.trace(p) * c.trace(q)


@states("sec. 7, Killing, degenerate", "the Killing tensor is degenerate, singular on the centre R+ Id only")
def _(rng):
    units = matrix_units()
    ad = mp.matrix(
        [[sum(commutator(p, commutator(q, unit))[k] for k, unit in enumerate(units)) for q in units] for p in units]
    )
    values, vectors = mp.eigsy(ad)
    kernel = [k for k in range(4) if abs(values[k]) < 1e-20]
    centre = [abs(vectors[i, kernel[0]]) for i in range(4)]
    return [1, 1 / sqrt(2), 0, 0, 1 / sqrt(2)], [len(kernel), *centre]


LINEAR = euler_group(2, 3, TILDE)


@states(
    "EQ6.20", "exp(a tau~0) exp(Phi tau~2) exp(b tau~3) exp(Psi tau~2) = delta exp(..) is EQ6.3, D = exp((a +- b)/2)"
)
def _(rng):
    q, _ = point(rng)
    a, b, Phi, Psi = q
    return [c.exponents(a, b, Phi / 2, -Psi / 2)] * 2, [LINEAR(*q), times(exp(a / 2), LINEAR(0, b, Phi, Psi))]


@states("EQ6.21", "delta = exp(a/2) = sqrt(lambda), lambda = det phi")
def _(rng):
    q, _ = point(rng)
    return sqrt(c.determinant(c.exponents(*q[:2], q[2] / 2, -q[3] / 2))), exp(q[0] / 2)


def hyperbolic(q, v):
    """Return db^2 - dPhi^2 - 2 cosh b dPhi dPsi - dPsi^2."""
    return v[1] ** 2 - v[2] ** 2 - 2 * cosh(q[1]) * v[2] * v[3] - v[3] ** 2


def linear_forms(q, v, extra, scale):
    """Return the three forms of EQ6.22 times `scale`: 1 as printed, e^-a corrected."""
    delta, lam = exp(q[0] / 2), exp(q[0])
    ddelta, dlam, rest = delta / 2 * v[0], lam * v[0], hyperbolic(q, v)
    return [
        scale * ((1 + extra) * ddelta**2 + delta**2 / 4 * rest),
        scale * ((1 + extra) * dlam**2 + lam**2 * rest) / (4 * lam),
        scale * lam / 4 * ((1 + extra) * v[0] ** 2 + rest),
    ]


for k, name in enumerate(("delta", "lambda", "a")):

    @states(
        f"EQ6.22, {name} form",
        f"a combination of EQ6.17 and EQ6.18, (1/2) Tr(Omega^2) + (c/4)(Tr Omega)^2, in {name}",
        "without the factor e^a (delta^2, lambda)",
    )
    def _(rng, k=k):
        (q, v), extra = point(rng), rng.real(-0.5, 1)
        omega, _ = cartan(LINEAR, q, v)
        truth = c.trace(c.product(omega, omega)) / 2 + extra / 4 * c.trace(omega) ** 2
        return truth, linear_forms(q, v, extra, 1)[k], linear_forms(q, v, extra, exp(-q[0]))[k]


@states(
    "EQ6.22, any combination",
    "some combination p Tr(Omega^2) + q (Tr Omega)^2 gives it (best fit at 12 points)",
    "without the factor e^a",
)
def _(rng):
    extra, rows, printed, corrected = rng.real(-0.5, 1), [], [], []
    for _ in range(12):
        q, v = point(rng)
        omega, _ = cartan(LINEAR, q, v)
        rows.append([mp.re(c.trace(c.product(omega, omega))), mp.re(c.trace(omega) ** 2)])
        printed.append(linear_forms(q, v, extra, 1)[0])
        corrected.append(linear_forms(q, v, extra, exp(-q[0]))[0])

    def misfit(values):
        A, y = mp.matrix(rows), mp.matrix(values)
        return mp.norm(A * mp.lu_solve(A, y) - y) / mp.norm(y)

    return 0, misfit(printed), misfit(corrected)


@states("EQ6.22, one formula", "the three forms are one formula")
def _(rng):
    (q, v), extra = point(rng), rng.real(-0.5, 1)
    forms = linear_forms(q, v, extra, 1)
    return forms[2], forms[0] if rng.index else forms[1]


@states("EQ6.23", "b = i Theta turns the last four terms into -dTheta^2 - dPhi^2 - 2 cos(Theta) dPhi dPsi - dPsi^2")
def _(rng):
    q, v = point(rng)
    imaginary = hyperbolic([q[0], 1j * q[1]], [v[0], 1j * v[1], *v[2:]])
    omega = c.product(tuple(along(GROUP, [0, *q[1:]], [0, *v[1:]])), c.inverse(GROUP(0, *q[1:])))
    return [-wheel(q, v), 2 * c.trace(c.product(omega, omega))], [imaginary, imaginary]


@states("EQ6.22, a -> ia", "with a imaginary, too, EQ6.22 becomes minus EQ6.16", "without the factor e^a")
def _(rng):
    (q, v), extra = point(rng), rng.real(-0.5, 1)
    turned = [1j * q[0], 1j * q[1], *q[2:]], [1j * v[0], 1j * v[1], *v[2:]]
    truth = -((1 + extra) * v[0] ** 2 + wheel(q, v)) / 4
    return truth, linear_forms(*turned, extra, 1)[2], linear_forms(*turned, extra, expj(-q[0]))[2]
