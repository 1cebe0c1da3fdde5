"""Section 2 and the two-polar decomposition of section 3."""

from __future__ import annotations

from itertools import product as pairs

from mpmath import cos, mp, mpf, pi, sin

from . import charts as c
from .numerics import square
from .record import Chapter

GEOMETRY = Chapter("Section 2, section 3: inertia and two-polar decomposition")
defines, states = GEOMETRY.defines, GEOMETRY.states


def deformed(rng):
    """Return random D1 > D2 > 0, varphi, psi and random velocities."""
    D2 = rng.real(0.4, 1.1)
    return [D2 + rng.real(0.1, 0.9), D2, *rng.reals(2, -3, 3)], rng.reals(4)


def polar(rng):
    """Return random r (or rho), vartheta, two angles, and velocities."""
    return [rng.real(0.6, 2.0), rng.real(0.2, 1.4), *rng.reals(2, -3, 3)], rng.reals(4)


# Section 2

defines("sec. 2, Q = AfI(N,M)", "configuration space of affine isomorphisms")
defines("sec. 2, Q = M x LI(U,V)", "translations times internal motion")
defines("EQa'", "y = phi a + x: the affine constraints")
defines("sec. 2, centre of mass", "integral of a dmu = 0: choice of the Lagrange origin")
defines("sec. 2, m and J^KL", "total mass and co-moving second moment")
defines("sec. 2, T", "T = (1/2) integral of g(dPhi/dt, dPhi/dt) dmu")


def cloud(rng):
    """Return a cloud of masses about its centre, and the motion: masses, points, moment J, dx/dt, dphi/dt, spatial
    metric.
    """
    mass = rng.reals(7, 0.2, 1)
    points = [rng.reals(2) for _ in mass]
    centre = [sum(m * a[i] for m, a in zip(mass, points)) / sum(mass) for i in range(2)]
    points = [[a[0] - centre[0], a[1] - centre[1]] for a in points]
    J = [[sum(m * a[k] * a[n] for m, a in zip(mass, points)) for n in range(2)] for k in range(2)]
    shear = rng.real(-0.5, 0.5)
    return mass, points, J, rng.reals(2), [rng.reals(2), rng.reals(2)], [[mp.mpf(1.3), shear], [shear, mp.mpf(0.8)]]


def summed(g, v):
    """Return g_ij v^i v^j."""
    return sum(g[i][j] * v[i] * v[j] for i, j in pairs(range(2), repeat=2))


def cloud_energy(rng, g=None):
    """Return the cloud and its kinetic energy, mass by mass."""
    body = cloud(rng)
    mass, points, _, dx, dphi, metric_g = body
    velocity = [[dx[i] + dphi[i][0] * a[0] + dphi[i][1] * a[1] for i in range(2)] for a in points]
    return body, sum(m * summed(g or metric_g, v) for m, v in zip(mass, velocity)) / 2


@states(
    "sec. 2, T_tr + T_int", "T = (m/2) g dx dx + (1/2) g_ij dphi^i_A dphi^i_B J^AB", "dphi^i_A dphi^j_B: one index j"
)
def _(rng):
    (mass, _, J, dx, dphi, g), T = cloud_energy(rng)
    indices = list(pairs(range(2), repeat=4))
    translation = sum(mass) * summed(g, dx) / 2
    printed = sum(g[i][j] * dphi[i][A] * dphi[i][B] * J[A][B] for i, j, A, B in indices) / 2
    corrected = sum(g[i][j] * dphi[i][A] * dphi[j][B] * J[A][B] for i, j, A, B in indices) / 2
    return T, translation + printed, translation + corrected


@states("sec. 2, T_int", "T_int = (1/2) Tr(dphi^T dphi J) in Cartesian coordinates")
def _(rng):
    unit = [[1, 0], [0, 1]]
    (mass, _, J, dx, dphi, _), T = cloud_energy(rng, unit)
    inner = c.product((dphi[0][0], dphi[1][0], dphi[0][1], dphi[1][1]), (*dphi[0], *dphi[1]), (*J[0], *J[1]))
    return T - sum(mass) * summed(unit, dx) / 2, c.trace(inner) / 2


@states(
    "sec. 6, rings",
    "a ring of n equal atoms (S8, C6H6, a nanotube's section) is isotropic: J^KL = (n m R^2/2) delta^KL",
)
def _(rng):
    atoms, mass, radius, turn = 3 + rng.index * 3 + int(rng.real(0, 3)), *rng.reals(2, 0.5, 2), rng.real(-3, 3)
    angles = [turn + 2 * pi * k / atoms for k in range(atoms)]
    points = [[radius * cos(angle), radius * sin(angle)] for angle in angles]
    J = [sum(mass * a[k] * a[n] for a in points) for k, n in pairs(range(2), repeat=2)]
    return J, [atoms * mass * radius**2 / 2 * (k == n) for k, n in pairs(range(2), repeat=2)]


@states(
    "sec. 6, homogeneous vibrations",
    "breathing of a ring of springs is a homogeneous mode: (n/2) m omega^2 R^2 by both",
)
def _(rng):
    # Bonds k (l - L)^2/2 of neighbours, at rest: the radius s R stretches each bond by (s - 1) L, and T = mu s'^2 with
    # J = mu delta. All atoms: the radial displacement is an eigenvector of the full Hessian with omega^2.
    atoms, k, mass, radius = 3 + rng.index * 2, *rng.reals(3, 0.5, 2)
    angles = [2 * pi * i / atoms for i in range(atoms)]
    units = [[cos(angle), sin(angle)] for angle in angles]
    force = [mpf(0)] * 2
    for other in (1, atoms - 1):  # on atom 0, for a radial displacement of all by 1
        apart = [units[0][i] - units[other][i] for i in range(2)]
        size = mp.sqrt(sum(a * a for a in apart))
        stretch = k * sum(a * a for a in apart) / size
        force = [f - stretch * a / size for f, a in zip(force, apart)]
    length = 2 * radius * sin(pi / atoms)
    mu = atoms * mass * radius**2 / 2
    homogeneous = atoms * k * length**2 / (2 * mu)
    return [-force[0] / mass, force[1]], [homogeneous, 0]


@states("sec. 2, R^n x_s GL(n,R)", "affine maps compose as (x, phi)(x', phi') = (x + phi x', phi phi')")
def _(rng):
    p, q, x, y, a = rng.reals(4), rng.reals(4), rng.reals(2), rng.reals(2), rng.reals(2)

    def affine(m, s, v):
        return [m[0] * v[0] + m[1] * v[1] + s[0], m[2] * v[0] + m[3] * v[1] + s[1]]

    return affine(p, x, affine(q, y, a)), affine(c.product(p, q), affine(p, x, y), a)


# Two-polar decomposition


def decomposed(m):
    """Return O, (D1, D2), R with phi = O D R^T, O and R proper rotations, D1 >= |D2|: eigenvectors of phi^T phi."""
    x, y, _, u = c.product(c.transposed(m), m)
    angle = mp.atan2(2 * y, x - u) / 2
    R = c.rotation(angle)
    first = c.product(m, R)
    O = c.rotation(mp.atan2(first[2], first[0]))
    D = c.product(c.transposed(O), m, R)
    return O, (D[0], D[3]), R


@states(
    "EQ2.0",
    "every phi is O D R^T with O, R in SO(2) and D positive",
    "D2 has the sign of det phi; D > 0 on GL+ only",
    reading=True,
)
def _(rng):
    m = rng.reals(4)
    if (c.determinant(m) > 0) == (rng.index == 0):
        m = [m[2], m[3], m[0], m[1]]
    O, (D1, D2), R = decomposed(m)
    return m, c.product(O, (D1, 0, 0, abs(D2)), c.transposed(R)), c.product(O, (D1, 0, 0, D2), c.transposed(R))


@states(
    "sec. 3, Gram-Schmidt",
    "the two-polar decomposition is connected with Gram-Schmidt: its O makes O^T phi phi^T O diagonal",
    "O of the singular value decomposition; Gram-Schmidt gives phi = O T with a triangle T",
)
def _(rng):
    m = rng.reals(4)
    O, _, _ = decomposed(m)
    first = c.rotation(mp.atan2(m[2], m[0]))  # the first column of phi, normalised, is the first of Gram and Schmidt
    spatial = c.product(m, c.transposed(m))
    mixed = [c.product(c.transposed(turn), spatial, turn)[1] for turn in (first, O)]
    return mpf(0), *mixed


@states("sec. 3, SO(2)", "O^T O = R^T R = Id, det O = det R = 1")
def _(rng):
    O, _, R = decomposed(rng.reals(4))
    return [1, 0, 0, 1] * 2 + [1, 1], [
        c.product(c.transposed(O), O),
        c.product(c.transposed(R), R),
        c.determinant(O),
        c.determinant(R),
    ]


@states("sec. 3, uniqueness", "for D1 != D2 > 0 unique up to D1 <-> D2 with signed permutations of SO(2) on O and R")
def _(rng):
    q, _ = deformed(rng)
    m = c.two_polar(*q)
    O, (D1, D2), R = decomposed(m)
    # All decompositions: R has the eigenvectors of phi^T phi as columns (2 orders, 4 signs), O = phi R D^-1.
    found = []
    for swap, s, t in pairs((False, True), (1, -1), (1, -1)):
        E = [v * k for v, k in zip((R[1], R[0], R[3], R[2]) if swap else R, (s, t, s, t))]
        D = (D2, 0, 0, D1) if swap else (D1, 0, 0, D2)
        P = c.product(m, E, c.inverse(D))
        if c.determinant(E) > 0 and c.determinant(P) > 0:
            found.append((c.product(c.transposed(O), P), c.product(c.transposed(R), E)))
    turns = [c.rotation(k * pi / 2) for k in range(4)]
    closest = [min(range(4), key=lambda k, V=V: square([a - b for a, b in zip(V, turns[k])])) for _, V in found]
    each_once = [closest.count(k) for k in range(4)]
    return [[1] * 4, *(V for _, V in found), *(V for _, V in found)], [
        each_once,
        *(W for W, _ in found),
        *(turns[k] for k in closest),
    ]


@states("sec. 3, V(D)", "doubly isotropic potentials depend on D only and are symmetric in D1, D2")
def _(rng):
    (D1, D2, varphi, psi), _ = deformed(rng)
    k = rng.reals(3)

    def V(m):  # a generic function of the two invariants of phi -> A phi B under rotations
        green = c.product(c.transposed(m), m)
        return sin(k[0] * c.trace(green)) + k[1] * c.determinant(m) + k[2] * c.trace(c.product(green, green))

    return V(c.two_polar(D1, D2, varphi, psi)), V((D2, 0, 0, D1))


@states("sec. 3, left and right rotations", "spatial rotations move varphi, material rotations move psi")
def _(rng):
    (D1, D2, varphi, psi), _ = deformed(rng)
    s, t = rng.reals(2)
    moved = c.product(c.rotation(s), c.two_polar(D1, D2, varphi, psi), c.rotation(-t))
    return moved, c.two_polar(D1, D2, varphi + s, psi + t)


defines("sec. 3, J = mu I", "isotropic inertia")
