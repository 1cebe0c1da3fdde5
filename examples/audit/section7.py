"""Section 7: generators, Euler-like parametrisations, metrics on R+SU(2) and U(2)."""

from __future__ import annotations

from mpmath import cos, cosh, exp, mp, mpf, sin, sinh, sqrt

from . import charts as c
from .numerics import along, jacobian, metric, square
from .record import Chapter

SECTION7 = Chapter("Section 7: generators and the breathing top")
defines, states = SECTION7.defines, SECTION7.states

SIGMA = ((1, 0, 0, 1), (0, 1, 1, 0), (0, -1j, 1j, 0), (1, 0, 0, -1))
TAU = (tuple(v / mpf(2) for v in SIGMA[0]), *(tuple(v / mpf(2) / 1j for v in m) for m in SIGMA[1:]))
TILDE = (TAU[0], tuple(1j * v for v in TAU[1]), TAU[2], tuple(1j * v for v in TAU[3]))


def times(s, m):
    """Return s m."""
    return tuple(s * v for v in m)


def commutator(p, q):
    """Return [p, q]."""
    return tuple(a - b for a, b in zip(c.product(p, q), c.product(q, p)))


def point(rng):
    """Return random a, b or Theta, Phi, Psi, and velocities."""
    return [rng.real(), rng.real(0.3, 1.2), *rng.reals(2)], rng.reals(4)


def wheel(q, v):
    """Return dTheta^2 + dPhi^2 + 2 cos(Theta) dPhi dPsi + dPsi^2, q = (a, Theta, Phi, Psi)."""
    return v[1] ** 2 + v[2] ** 2 + 2 * cos(q[1]) * v[2] * v[3] + v[3] ** 2


# Parametrisation


@states("EQ6.1", "ds^2 = Tr(dphi^T dphi) = dx^2 + dy^2 + dz^2 + du^2")
def _(rng):
    v = rng.reals(4)
    return c.trace(c.product(c.transposed(v), v)), square(v)


@states("EQ6.2", "T = (mu/2) Tr(dphi^T/dt dphi/dt) is the energy of the section 2 body")
def _(rng):
    mu, v, a = rng.real(0.5, 2), rng.reals(4), mpf(1) / sqrt(2)
    masses = [(mu / 2, s) for s in ((1, 1), (1, -1), (-1, 1), (-1, -1))]  # moment: mu/2 sum a a^T = 2 mu a^2 = mu
    speed = sum(m * square([a * (v[0] * s + v[1] * t), a * (v[2] * s + v[3] * t)]) for m, (s, t) in masses)
    return speed / 2, mu / 2 * c.trace(c.product(c.transposed(v), v))


def printed_R(Psi):
    """Return R of section 7."""
    return cos(Psi / 2), sin(Psi / 2), -sin(Psi / 2), cos(Psi / 2)


@states("EQ6.3", "phi = O D R^-1 with half angles is EQ2.0 with Phi = 2 varphi, Psi = -2 psi")
def _(rng):
    D1, D2, varphi, psi = [*rng.reals(2, 0.3, 1), *rng.reals(2)]
    return c.two_polar(D1, D2, varphi, psi), c.product(
        c.rotation(varphi), (D1, 0, 0, D2), c.inverse(printed_R(-2 * psi))
    )


@states(
    "sec. 7, D1 and D2",
    "D1 = exp(a + b/2), D2 = exp(a - b/2), D = exp(a sigma0/2) exp(b sigma3/2)",
    "exp((a +- b)/2), as in section 3",
)
def _(rng):
    a, b = rng.reals(2)
    D = c.product(c.exponential(times(a / 2, SIGMA[0])), c.exponential(times(b / 2, SIGMA[3])))
    return D, [exp(a + b / 2), 0, 0, exp(a - b / 2)], [exp((a + b) / 2), 0, 0, exp((a - b) / 2)]


@states("sec. 7, O", "O = exp(Phi sigma2/2i)")
def _(rng):
    Phi = rng.real()
    return c.exponential(times(Phi / 2 / 1j, SIGMA[2])), c.rotation(Phi / 2)


@states("sec. 7, R^-1", "R^-1 = exp(Psi sigma2/2i)")
def _(rng):
    Psi = rng.real()
    return c.exponential(times(Psi / 2 / 1j, SIGMA[2])), c.inverse(printed_R(Psi))


defines("sec. 7, sigma_nu", "unit and Pauli matrices")
defines("sec. 7, tau_a", "tau_a = sigma_a/2i")
CYCLES = ((1, 2, 3), (2, 3, 1), (3, 1, 2))


@states("sec. 7, [tau, tau]", "[tau1, tau2] = tau3 and cyclic")
def _(rng):
    return [TAU[k] for *_, k in CYCLES], [commutator(TAU[i], TAU[j]) for i, j, _ in CYCLES]


@states("sec. 7, tau~_a", "i tau1, tau2, i tau3 are real, traceless, independent: generators of SL(2,R)")
def _(rng):
    gram = mp.matrix([[c.trace(c.product(c.dagger(p), q)) for q in TILDE[1:]] for p in TILDE[1:]])
    defects = [abs(c.trace(m)) + max(abs(mp.im(v)) for v in m) for m in TILDE[1:]]
    return [0, mpf(1) / 8], [sum(defects), mp.det(gram)]


@states("sec. 7, [tau~, tau~]", "[1,2] = 3, [2,3] = 1, [3,1] = -2")
def _(rng):
    return [TILDE[3], TILDE[1], times(-1, TILDE[2])], [commutator(TILDE[i], TILDE[j]) for i, j, _ in CYCLES]


@states("sec. 7, tau_0", "tau0 = 1/2 generates real dilatations: exp(a tau0) = e^(a/2)")
def _(rng):
    a = rng.real()
    return [exp(a / 2), 0, 0, exp(a / 2)], c.exponential(times(a, TAU[0]))


@states(
    "sec. 7, generators of GL(2,R)",
    "the tau~_nu generate GL(2,R), all its matrices",
    "its connected part GL+(2,R)",
    reading=True,
)
def _(rng):
    factors = [
        c.exponential(tuple(sum(t * m[k] for t, m in zip(rng.reals(4), TILDE)) for k in range(4))) for _ in range(3)
    ]
    sign = mp.sign(mp.re(c.determinant(c.product(*factors))))
    target = [mpf(1), mpf(-1)]  # signs of det in GL(2,R)
    return target, [sign, sign], [sign, -1]


@states(
    "sec. 7, R+SU(2)", "exp of tau_nu gives lambda u with u in SU(2); 2:1 over R+SO(3), u and -u being one rotation"
)
def _(rng):
    m = c.product(
        c.exponential(times(rng.real(), TAU[0])), *(c.exponential(times(rng.real(), TAU[k])) for k in (1, 2, 3))
    )
    size = c.determinant(m)

    def turned(u):  # the rotation of the sigma's
        return [c.trace(c.product(SIGMA[i], u, SIGMA[j], c.dagger(u))) for i in (1, 2, 3) for j in (1, 2, 3)]

    return [(1, 0, 0, 1), turned(m)], [times(1 / size, c.product(c.dagger(m), m)), turned(times(-1, m))]


@states("sec. 7, sin(vartheta)", "sin(vartheta) = (D1^2 - D2^2)/(D1^2 + D2^2)")
def _(rng):
    D2, more = rng.reals(2, 0.3, 1)
    D1 = D2 + more
    return sin(mp.atan2(D1**2 - D2**2, 2 * D1 * D2)), (D1**2 - D2**2) / (D1**2 + D2**2)


@states("EQ6.4", "ds^2 = drho^2 + (rho^2/4)(dTheta^2 + dPhi^2 + 2 cos(Theta) dPhi dPsi + dPsi^2), and with r")
def _(rng):
    (_, *angles), v = point(rng)
    rho = rng.real(0.5, 2)
    q = [rho, *angles]
    dr = 2 * rho * v[0]
    return [square(along(c.euler_section7, q, v))] * 2, [
        v[0] ** 2 + rho**2 / 4 * wheel(q, v),
        (dr**2 + rho**4 * wheel(q, v)) / (4 * rho**2),
    ]


@states("sec. 7, delta", "delta = sqrt(D1 D2) = exp(a/2) (with D1, D2 of section 3)")
def _(rng):
    a, b = rng.reals(2)
    return sqrt(c.determinant(c.exponents(a, b, *rng.reals(2)))), exp(a / 2)


def stretched(delta, b, Phi, Psi):
    """Return phi of delta, b, Phi, Psi."""
    return c.exponents(2 * mp.log(delta), b, Phi / 2, -Psi / 2)


@states(
    "EQ6.4a",
    "ds^2 = cosh b ddelta^2 + delta sinh b ddelta db + (delta^2/4) cosh b (db^2 + dPhi^2 + (2/cosh b) dPhi dPsi + "
    "dPsi^2)",
    "twice this",
)
def _(rng):
    (_, b, *angles), v = point(rng)
    s = rng.real(0.5, 2)
    printed = cosh(b) * v[0] ** 2 + s * sinh(b) * v[0] * v[1] + s**2 / 4 * cosh(b) * v[1] ** 2
    printed += s**2 / 4 * cosh(b) * (v[2] ** 2 + 2 / cosh(b) * v[2] * v[3] + v[3] ** 2)
    return square(along(stretched, [s, b, *angles], v)), printed, 2 * printed


@states("sec. 7, 1/cosh b", "1/cosh b = cos(Theta)")
def _(rng):
    a, b = rng.real(), rng.real(0.1, 1)
    D1, D2 = exp((a + b) / 2), exp((a - b) / 2)
    return cos(mp.atan2(D1**2 - D2**2, 2 * D1 * D2)), 1 / cosh(b)


# The breathing top


def euler_group(first, second, generators=TAU, turn=1):
    """Return (a, Theta, Phi, Psi) -> exp(a tau0) exp(Phi first) exp(Theta second) exp(Psi first); turn = 1j makes a
    imaginary.
    """

    def phi(a, Theta, Phi, Psi):
        parts = ((turn * a, 0), (Phi, first), (Theta, second), (Psi, first))
        return c.product(*(c.exponential(times(s, generators[k])) for s, k in parts))

    return phi


GROUP = euler_group(2, 3)


def covers(m):
    """Return m^+ m/det m for m in R+SU(2), and the determinant."""
    return times(1 / c.determinant(m), c.product(c.dagger(m), m))


for label, first, second in (("EQ6.5", 2, 3), ("EQ6.6", 3, 1), ("EQ6.7", 3, 2)):

    @states(
        label,
        f"exp(a tau0) exp(Phi tau{first}) exp(Theta tau{second}) exp(Psi tau{first}) lies in R+SU(2); Phi, Theta, Psi "
        "are Euler angles",
    )
    def _(rng, first=first, second=second):
        (q, v), chart = point(rng), euler_group(first, second)
        # all three give one line element: the orthogonal pair of axes does not matter
        return [(1, 0, 0, 1), square(along(GROUP, q, v))], [covers(chart(*q)), square(along(chart, q, v))]


defines("EQ6.8", "ds^2 = Tr(dphi^+ dphi)")


@states("EQ6.9", "delta = exp(a/2), lambda = delta^2 = exp(a)")
def _(rng):
    q, _ = point(rng)
    lam = c.determinant(GROUP(*q))
    return [sqrt(lam), lam], [exp(q[0] / 2), exp(q[0])]


def top_forms(q, v, extra):
    """Return the three forms of EQ6.13-6.15 with constant `extra` (EQ6.10-6.12 for 0)."""
    a, delta, lam = q[0], exp(q[0] / 2), exp(q[0])
    ddelta, dlam = delta / 2 * v[0], lam * v[0]
    return [
        (1 + extra) * ddelta**2 + delta**2 / 4 * wheel(q, v),
        ((1 + extra) * dlam**2 + lam**2 * wheel(q, v)) / (4 * lam),
        exp(a) / 4 * ((1 + extra) * v[0] ** 2 + wheel(q, v)),
    ]


for k, label in enumerate(("EQ6.10", "EQ6.11", "EQ6.12")):

    @states(label, "Tr(dphi^+ dphi) of EQ6.8 on R+SU(2)", "twice this, or EQ6.8 read as (1/2) Tr")
    def _(rng, k=k):
        q, v = point(rng)
        printed = top_forms(q, v, 0)[k]
        return square(along(GROUP, q, v)), printed, 2 * printed


for k, label in enumerate(("EQ6.13", "EQ6.14", "EQ6.15")):

    @states(label, f"{('EQ6.10', 'EQ6.11', 'EQ6.12')[k]} with c ddelta^2 added ((1/2) Tr normalisation)")
    def _(rng, k=k):
        (q, v), extra = point(rng), rng.real(-0.5, 1)
        delta = along(lambda *q: [sqrt(c.determinant(GROUP(*q)))], q, v)[0]
        return square(along(GROUP, q, v)) / 2 + extra * delta**2, top_forms(q, v, extra)[k]


@states("EQ6.13, motion", "its kinetic energy on the body is (|p|^2 - c (q.p)^2/((1 + c) |q|^2))/2mu")
def _(rng):
    (q, v), extra, mu = point(rng), rng.real(-0.5, 1), rng.real(0.5, 2)

    def body(a, *angles):  # the affine body of the same coordinates, delta = rho
        return c.euler_section7(exp(a / 2), *angles)

    place = body(*q)
    G = metric(body, q)
    G[0, 0] += extra * exp(q[0]) / 4  # c ddelta^2
    velocity = mp.matrix(v)
    p = mu * mp.inverse(jacobian(body, q)).T * (G * velocity)
    along_place = sum(x * y for x, y in zip(place, p))
    kinetic = (square(p) - extra / (1 + extra) * along_place**2 / square(place)) / (2 * mu)
    return mu / 2 * top_forms(q, v, extra)[0], kinetic


def fixed(rng, turn=1):
    """Return two fixed group elements."""
    return [euler_group(2, 3, TAU, turn)(*rng.reals(4, 0.2, 0.8)) for _ in range(2)]


@states(
    "sec. 7, two-side invariant",
    "ds^2 on R+SU(2) is two-side invariant",
    "under SU(2) x SU(2); the R+ factor multiplies it by lambda^2",
    reading=True,
)
def _(rng):
    (q, v), (left, right) = point(rng), fixed(rng)
    scale = abs(c.determinant(left) * c.determinant(right))
    here = square(along(GROUP, q, v))
    return (
        here,
        square(along(lambda *q: c.product(left, GROUP(*q), right), q, v)),
        square(along(lambda *q: times(1 / sqrt(scale), c.product(left, GROUP(*q), right)), q, v)),
    )


@states(
    "EQ6.16",
    "a -> ia in EQ6.8, EQ6.9 gives (1/4)((1+c) da^2 + dTheta^2 + ...) on U(2), c = 0",
    "(1/2) Tr(dphi^+ dphi), as for EQ6.10-6.12",
)
def _(rng):
    q, v = point(rng)
    printed = (v[0] ** 2 + wheel(q, v)) / 4
    return square(along(euler_group(2, 3, TAU, 1j), q, v)), printed, 2 * printed


@states("EQ6.16, U(2)", "it is a two-side invariant metric on U(2), for every c")
def _(rng):
    (q, v), (left, right), extra, chart = point(rng), fixed(rng, 1j), rng.real(-0.5, 1), euler_group(2, 3, TAU, 1j)

    def element(chart):
        det = along(lambda *q: [c.determinant(chart(*q))], q, v)[0]
        return square(along(chart, q, v)) / 2 + extra * abs(det) ** 2 / 4

    moved = element(lambda *q: c.product(left, chart(*q), right))
    return [(1, 0, 0, 1), moved], [
        c.product(c.dagger(chart(*q)), chart(*q)),
        ((1 + extra) * v[0] ** 2 + wheel(q, v)) / 4,
    ]


@states(
    "sec. 7, complex a",
    "complex a gives (C \\ 0) SU(2) = R+U(2) with a doubly invariant metric",
    "under U(2) x U(2); a dilatation multiplies it",
    reading=True,
)
def _(rng):
    (q, v), da, (left, right) = point(rng), mp.mpc(*rng.reals(2)), fixed(rng, mp.expj(0.7))
    chart = euler_group(2, 3, TAU)

    def line(s):  # a curve with complex a
        return chart(mp.mpc(q[0], 0.3) + s * da, *(x + s * y for x, y in zip(q[1:], v[1:])))

    def element(left, right):
        return square(along(lambda s: c.product(left, line(s), right), [mpf(0)], [mpf(1)]))

    scale = abs(c.determinant(left) * c.determinant(right))
    return element((1, 0, 0, 1), (1, 0, 0, 1)), element(left, right), element(left, times(1 / sqrt(scale), right))
