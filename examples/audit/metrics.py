"""Section 3, continued: kinetic energies, metrics and identities in every chart."""

from __future__ import annotations

from mpmath import cos, cosh, exp, mp, pi, sin, sinh, sqrt, tan, tanh

from . import charts as c
from .geometry import cloud, decomposed, deformed, polar
from .numerics import along, metric, square
from .record import Chapter, claim

METRICS = Chapter("Section 3: kinetic energies, metrics and identities")
defines, states = METRICS.defines, METRICS.states


# Kinetic energies and metrics: ds^2 = Tr(dphi^T dphi), T = (mu/2) ds^2/dt^2


def energy_formula(label, says, chart, point, form):
    """Add a kinetic energy (mu/2) form(q, dq), compared with the matrix elements' own."""

    @states(label, says)
    def _(rng):
        (q, dq), mu = point(rng), rng.real(0.5, 2)
        return mu / 2 * square(along(chart, q, dq)), mu / 2 * form(q, dq)


def metric_formula(label, says, chart, point, form, factor=1, correct=""):
    """Add a squared line element form(q, dq), to be multiplied by `factor` if that is not 1."""

    @states(label, says, correct)
    def _(rng):
        q, dq = point(rng)
        truth, printed = square(along(chart, q, dq)), form(q, dq)
        return (truth, printed) if factor == 1 else (truth, printed, factor * printed)


energy_formula(
    "EQ2.0a",
    "T in D1, D2, varphi, psi",
    c.two_polar,
    deformed,
    lambda q, v: (
        (q[0] ** 2 + q[1] ** 2) * (v[2] ** 2 + v[3] ** 2) - 4 * q[0] * q[1] * v[2] * v[3] + v[0] ** 2 + v[1] ** 2
    ),
)


@states("sec. 3, cyclic angles", "O and R do not enter T: varphi, psi are cyclic")
def _(rng):
    (D1, D2, varphi, psi), dq = deformed(rng)
    turned = [D1, D2, varphi + rng.real(), psi + rng.real()]
    return square(along(c.two_polar, [D1, D2, varphi, psi], dq)), square(along(c.two_polar, turned, dq))


defines("sec. 3, alpha, beta, eta, gamma", "alpha, beta = (D1 +- D2)/sqrt2, eta, gamma = varphi -+ psi")


@states(
    "sec. 3, pi/4-rotation",
    "(alpha, beta) is (D1, D2) turned by pi/4",
    "turned by -pi/4, then beta -> -beta: an improper turn",
    reading=True,
)
def _(rng):
    (D1, D2, *_), _ = deformed(rng)
    truth = [(D1 + D2) / sqrt(2), (D1 - D2) / sqrt(2)]
    turns = [[cos(t) * D1 - sin(t) * D2, sin(t) * D1 + cos(t) * D2] for t in (pi / 4, -pi / 4)]
    best = min(turns, key=lambda turn: square([a - b for a, b in zip(turn, truth)]))
    return truth, best, [turns[1][0], -turns[1][1]]


@states("sec. 3, alpha > |beta|", "D1, D2 > 0 gives alpha > 0 and |beta| < alpha")
def _(rng):
    D1, D2 = rng.reals(2, 0.01, 3)
    return claim(D1 + D2 > 0 and abs(D1 - D2) < D1 + D2)


energy_formula(
    "EQ2.0b",
    "T in alpha, beta, eta, gamma",
    c.alpha_beta,
    polar,
    lambda q, v: q[0] ** 2 * v[2] ** 2 + q[1] ** 2 * v[3] ** 2 + v[0] ** 2 + v[1] ** 2,
)


@states("EQ2.2a", "T = (mu/2) Tr(dphi^T dphi): the T_int of section 2 with J = mu I")
def _(rng):
    (mass, points, J, _, dphi, _) = cloud(rng)
    x, y, z = J[0][0], J[0][1], J[1][1]
    root = sqrt(x * z - y * y)
    s = (
        1 / sqrt(x + z + 2 * root) / root
    )  # labels L a with L = J^(-1/2), by Cayley-Hamilton: then the moment of L a is mu I, mu = 1
    L = (s * (z + root), -s * y, -s * y, s * (x + root))
    labels = [[L[0] * a[0] + L[1] * a[1], L[2] * a[0] + L[3] * a[1]] for a in points]
    v = (*dphi[0], *dphi[1])
    velocity = [[v[0] * a[0] + v[1] * a[1], v[2] * a[0] + v[3] * a[1]] for a in labels]
    return sum(m * square(w) for m, w in zip(mass, velocity)) / 2, c.trace(c.product(c.transposed(v), v)) / 2


@states("EQ2.2b", "T = (mu/2)(dx^2 + dy^2 + dz^2 + du^2)")
def _(rng):
    v = rng.reals(4)
    return c.trace(c.product(c.transposed(v), v)) / 2, sum(x * x for x in v) / 2


defines("EQ2.2c'", "phi = [[x, y], [z, u]]")


@states("sec. 3, T-orthogonal", "alpha, beta, eta, gamma are orthogonal coordinates of R^4")
def _(rng):
    G = metric(c.alpha_beta, polar(rng)[0])
    return [G[i, i] for i in range(4)] + [0] * 6, [G[i, i] for i in range(4)] + [
        G[i, j] for i in range(4) for j in range(i)
    ]


defines("sec. 3, r and vartheta", "alpha = sqrt(r) cos(vartheta/2), beta = sqrt(r) sin(vartheta/2)")
defines("sec. 3, rho and epsilon", "alpha = rho cos(epsilon), beta = rho sin(epsilon)")


@states("sec. 3, rho = sqrt(r)", "rho = sqrt(r), epsilon = vartheta/2")
def _(rng):
    (r, vartheta, eta, gamma), _ = polar(rng)
    return c.r_vartheta(r, vartheta, eta, gamma), c.rho_epsilon(sqrt(r), vartheta / 2, eta, gamma)


def form_r(q, v):
    """Line element in r, vartheta, eta, gamma."""
    angular = q[0] * cos(q[1] / 2) ** 2 * v[2] ** 2 + q[0] * sin(q[1] / 2) ** 2 * v[3] ** 2
    return angular + v[0] ** 2 / (4 * q[0]) + q[0] / 4 * v[1] ** 2


def form_rho(q, v):
    """Line element in rho, epsilon, eta, gamma."""
    rho2 = q[0] ** 2
    return v[0] ** 2 + rho2 * v[1] ** 2 + rho2 * cos(q[1]) ** 2 * v[2] ** 2 + rho2 * sin(q[1]) ** 2 * v[3] ** 2


def form_mixed(q, v):
    """Line element in rho, vartheta, eta, gamma."""
    rho2 = q[0] ** 2
    return (
        v[0] ** 2 + rho2 / 4 * v[1] ** 2 + rho2 * cos(q[1] / 2) ** 2 * v[2] ** 2 + rho2 * sin(q[1] / 2) ** 2 * v[3] ** 2
    )


def rho_vartheta(rho, vartheta, eta, gamma):
    """Chart of the third line element."""
    return c.rho_epsilon(rho, vartheta / 2, eta, gamma)


FORMS = (
    ("r, vartheta, eta, gamma", c.r_vartheta, form_r),
    ("rho, epsilon, eta, gamma", c.rho_epsilon, form_rho),
    ("rho, vartheta, eta, gamma", rho_vartheta, form_mixed),
)
for names, chart, form in FORMS:
    metric_formula(f"sec. 3, ds^2 ({names})", "line element", chart, polar, form)
for names, chart, form in FORMS:
    energy_formula(f"sec. 3, T ({names})", "kinetic energy", chart, polar, form)


# Identities


def identity(label, says, chart, point, truth, printed):
    """Add truth(matrix) = printed(coordinates)."""

    @states(label, says)
    def _(rng):
        q, _ = point(rng)
        return truth(chart(*q)), printed(*q)


def invariants(m):
    """Return D1 >= |D2| of a matrix."""
    return decomposed(m)[1]


identity(
    "EQ2.2y, first",
    "2 D1 D2 = r cos(vartheta)",
    c.r_vartheta,
    polar,
    lambda m: 2 * c.determinant(m),
    lambda r, t, *_: r * cos(t),
)
identity(
    "EQ2.2y, second",
    "D1^2 - D2^2 = r sin(vartheta)",
    c.r_vartheta,
    polar,
    lambda m: invariants(m)[0] ** 2 - invariants(m)[1] ** 2,
    lambda r, t, *_: r * sin(t),
)
identity(
    "EQ2.2x, r",
    "r = rho^2 = D1^2 + D2^2",
    c.r_vartheta,
    polar,
    lambda m: [square(invariants(m)), square(m)],
    lambda r, t, *_: [r, r],
)
identity(
    "EQ2.2x, tan",
    "tan(vartheta) = (D1/D2 - D2/D1)/2",
    c.r_vartheta,
    polar,
    lambda m: (invariants(m)[0] / invariants(m)[1] - invariants(m)[1] / invariants(m)[0]) / 2,
    lambda r, t, *_: tan(t),
)
identity(
    "EQ2.2z",
    "r = 2 D1 D2/cos(vartheta)",
    c.r_vartheta,
    polar,
    square,
    lambda r, t, *_: 2 * c.determinant(c.r_vartheta(r, t, 0, 0)) / cos(t),
)


@states("sec. 3, homogeneity", "r and D1 D2 are homogeneous of degree 2 in D1, D2, vartheta of degree 0")
def _(rng):
    (D1, D2, *_), _ = deformed(rng)
    s = rng.real(0.5, 2)

    def shear(D1, D2):
        return mp.atan2(D1**2 - D2**2, 2 * D1 * D2)

    return [s**2 * (D1**2 + D2**2), s**2 * D1 * D2, shear(D1, D2)], [
        (s * D1) ** 2 + (s * D2) ** 2,
        s * D1 * s * D2,
        shear(s * D1, s * D2),
    ]


def logarithmic(rng):
    """Return random a, b > 0 and angles."""
    return [rng.real(), rng.real(0.1, 1.2), *rng.reals(2)], rng.reals(4)


defines("sec. 3, a and b", "D1 = exp((a + b)/2), D2 = exp((a - b)/2)")
for label, truth, printed in (
    (
        "alpha = sqrt2 e^(a/2) cosh(b/2)",
        lambda D1, D2: (D1 + D2) / sqrt(2),
        lambda a, b: sqrt(2) * exp(a / 2) * cosh(b / 2),
    ),
    (
        "beta = sqrt2 e^(a/2) sinh(b/2)",
        lambda D1, D2: (D1 - D2) / sqrt(2),
        lambda a, b: sqrt(2) * exp(a / 2) * sinh(b / 2),
    ),
    ("D1 D2 = e^a", lambda D1, D2: D1 * D2, lambda a, b: exp(a)),
    ("D1^2 + D2^2 = 2 e^a cosh b", lambda D1, D2: D1**2 + D2**2, lambda a, b: 2 * exp(a) * cosh(b)),
    ("D1^2 - D2^2 = 2 e^a sinh b", lambda D1, D2: D1**2 - D2**2, lambda a, b: 2 * exp(a) * sinh(b)),
    ("D1/D2 = e^b", lambda D1, D2: D1 / D2, lambda a, b: exp(b)),
    ("sin(vartheta) = tanh b", lambda D1, D2: sin(mp.atan2(D1**2 - D2**2, 2 * D1 * D2)), lambda a, b: tanh(b)),
    ("cos(vartheta) = 1/cosh b", lambda D1, D2: cos(mp.atan2(D1**2 - D2**2, 2 * D1 * D2)), lambda a, b: 1 / cosh(b)),
    ("tan(vartheta) = sinh b", lambda D1, D2: tan(mp.atan2(D1**2 - D2**2, 2 * D1 * D2)), lambda a, b: sinh(b)),
):
    identity(
        f"sec. 3, {label}",
        "exponential parameters",
        c.exponents,
        logarithmic,
        lambda m, truth=truth: truth(*invariants(m)),
        lambda a, b, *_, printed=printed: printed(a, b),
    )


# Elliptic, parabolic and bipolar coordinates, and the Euler form of the metric


def oval(rng):
    """Return random coordinates of the three charts inside their ranges, and velocities."""
    return [rng.real(0.4, 1.0), rng.real(0.2, 0.38), *rng.reals(2)], rng.reals(4)


for name, chart in (
    ("(i) elliptic", c.elliptic),
    ("(ii) parabolic", c.parabolic),
    ('(iii) bipolar, "two-polar"', c.bipolar),
):

    @states(f"sec. 3, {name}", "orthogonal coordinates on the plane of deformation invariants")
    def _(rng, chart=chart):
        G = metric(chart, oval(rng)[0])
        return [G[0, 0], 0], [G[1, 1], G[0, 1]]  # orthogonal, and even conformal


metric_formula(
    "sec. 3, ds^2 (elliptic)",
    "line element in kappa, lambda, eta, gamma",
    c.elliptic,
    oval,
    lambda q, v: (
        (cosh(q[0]) ** 2 - cos(q[1]) ** 2) * (v[0] ** 2 + v[1] ** 2)
        + cosh(q[0]) ** 2 * cos(q[1]) ** 2 * v[2] ** 2
        + sinh(q[0]) ** 2 * sin(q[1]) ** 2 * v[3] ** 2
    ),
    2,
    "twice the right-hand side",
)


@states("sec. 3, cosh^2 - cos^2", "cosh^2 kappa - cos^2 lambda = sinh^2 kappa + sin^2 lambda")
def _(rng):
    k, l = rng.reals(2)
    return cosh(k) ** 2 - cos(l) ** 2, sinh(k) ** 2 + sin(l) ** 2


def top(q, v, sign):
    """Return dTheta^2 + dPhi^2 + sign 2 cos(Theta) dPhi dPsi + dPsi^2; q = (radius, Theta, Phi, Psi)."""
    return v[1] ** 2 + v[2] ** 2 + sign * 2 * cos(q[1]) * v[2] * v[3] + v[3] ** 2


metric_formula(
    "sec. 3, ds^2 (r, vartheta, varphi, psi)",
    "line element",
    c.r_vartheta_angles,
    polar,
    lambda q, v: (
        v[0] ** 2 / (4 * q[0])
        + q[0] / 4 * v[1] ** 2
        + q[0] * v[2] ** 2
        - 2 * q[0] * cos(q[1]) * v[2] * v[3]
        + q[0] * v[3] ** 2
    ),
)
metric_formula(
    "sec. 3, ds^2 (rho, vartheta, 2 varphi, 2 psi)",
    "line element",
    lambda rho, *q: c.r_vartheta_angles(rho**2, *q),
    polar,
    lambda q, v: v[0] ** 2 + q[0] ** 2 / 4 * top(q, [v[0], v[1], 2 * v[2], 2 * v[3]], -1),
)
metric_formula(
    "sec. 3, ds^2 (r, Theta, Phi, Psi)",
    "line element with doubled angles",
    lambda r, *q: c.euler(sqrt(r), *q),
    polar,
    lambda q, v: (v[0] ** 2 + q[0] ** 2 * top(q, v, -1)) / (4 * q[0]),
)


def unitary(_, Theta, Phi, Psi):
    """SU(2) in Euler angles, exp(Phi tau3) exp(Theta tau1) exp(Psi tau3) with tau = sigma/2i."""

    def turn(angle):
        return mp.expj(-angle / 2), 0, 0, mp.expj(angle / 2)

    return c.product(turn(Phi), (cos(Theta / 2), -1j * sin(Theta / 2), -1j * sin(Theta / 2), cos(Theta / 2)), turn(Psi))


@states(
    "sec. 3, d sigma^2", "dTheta^2 + dPhi^2 - 2 cos(Theta) dPhi dPsi + dPsi^2 is the SU(2) metric after Psi -> -Psi"
)
def _(rng):
    q, v = polar(rng)
    return 2 * square(along(lambda r, a, b, e: unitary(r, a, b, -e), q, v)), top(q, v, -1)


@states(
    "sec. 3, d sigma^2, usual sign",
    "dTheta^2 + dPhi^2 + 2 cos(Theta) dPhi dPsi + dPsi^2 is the doubly invariant metric of SU(2)",
)
def _(rng):
    q, v = polar(rng)
    left, right = unitary(1, *rng.reals(3, 0.2, 1)), unitary(1, *rng.reals(3, 0.2, 1))
    return 2 * square(along(lambda *x: c.product(left, unitary(*x), right), q, v)), top(q, v, +1)


@states("sec. 3, spherical top", "T = (I/2)(dTheta^2 + dPhi^2 + 2 cos(Theta) dPhi dPsi + dPsi^2)")
def _(rng):
    q, v = polar(rng)
    I = rng.real(0.5, 2)

    def turned(_, Theta, Phi, Psi):
        def about3(t):
            return mp.matrix([[cos(t), -sin(t), 0], [sin(t), cos(t), 0], [0, 0, 1]])

        return list(
            about3(Phi)
            * mp.matrix([[1, 0, 0], [0, cos(Theta), -sin(Theta)], [0, sin(Theta), cos(Theta)]])
            * about3(Psi)
        )

    return I / 2 * square(along(turned, q, v)) / 2, I / 2 * top(q, v, +1)  # |omega|^2 = Tr(dA^T dA)/2


@states("sec. 3, rho", "rho = |(x, y, z, u)| = sqrt(D1^2 + D2^2) = sqrt(Tr(phi^T phi)) = sqrt(Tr G)")
def _(rng):
    (rho, *rest), _ = polar(rng)
    m = c.rho_epsilon(rho, *rest)
    return [rho] * 3, [sqrt(square(m)), sqrt(square(invariants(m))), sqrt(c.trace(c.product(c.transposed(m), m)))]


@states(
    "sec. 3, rho covariant",
    "rho = sqrt(eta^AB G_AB) = sqrt(g_ij phi^i_A phi^j_B eta^AB): for general g, eta a Cartesian norm",
)
def _(rng):
    m, P, Q = rng.reals(4), rng.reals(4), rng.reals(4)
    g, eta = c.product(c.transposed(P), P), c.inverse(c.product(c.transposed(Q), Q))
    G = c.product(c.transposed(m), g, m)
    return sqrt(square(c.product(P, m, c.inverse(Q)))), sqrt(c.trace(c.product(c.transposed(eta), G)))


@states("sec. 3, SU(2) = S^3", "unitary unimodular matrices are the unit sphere of R^4")
def _(rng):
    m = unitary(1, *rng.reals(3, 0.2, 2))
    real = [mp.re(m[0]), mp.im(m[0]), mp.re(m[2]), mp.im(m[2])]
    return [1, mp.conj(m[0]), -mp.conj(m[2])], [square(real), m[3], m[1]]


@states(
    "sec. 3, spherical coordinates",
    "x^1..x^4 with r = rho^2 as radial variable",
    "r stands for rho here: sum (x^i)^2 = r^2",
    reading=True,
)
def _(rng):
    r, *angles = [rng.real(1.2, 2), *rng.reals(3)]
    return square(c.spherical(r, *angles)), r, r**2
