"""Slow and obvious twins of the kernels, and independent truths: NumPy, SciPy and pencil only, one orbit at a time."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fastaff import KAHAN_LI8, Anharmonic, Body, Harmonic, HeavyTop, HenonHeiles, Hyperelastic, NeoHookean
from fastaff.runs.schemes import Collocation, Nystrom, Splitting

MODELS = (
    Body(Harmonic(C=1.3), mu=0.7),
    Body(Anharmonic(C=0.9), mu=1.4),
    Body(Hyperelastic(C=1.1), mu=0.8),
    Body(HeavyTop(C=1.2, A=0.6), mu=1.1),
    Body(NeoHookean(G=0.8, K=2.3), mu=1.2),
    HenonHeiles(lam=0.9),
)
SMALL = 0.35
"""Standard deviation of random states around the rest state."""


def label(value):
    """Return a test id of a model, a scheme or a section."""
    potential = getattr(value, "potential", value)
    return getattr(potential, "name", type(potential).__name__)


def states(model, orbits, seed=1, spread=SMALL):
    """Return random phase points (2n, orbits) around the undeformed body (or the origin), well inside the domain."""
    rng, n = np.random.default_rng(seed), model.degrees_of_freedom
    if n == 2:
        z = 0.3 * rng.uniform(-1, 1, (4, orbits))  # Henon-Heiles: E < 0.13 for lam = 0.9, bounded
        return z
    z = spread * rng.standard_normal((8, 8 * orbits))
    z[0] += np.sqrt(2)
    A, B = (z[:2] ** 2).sum(0), (z[2:4] ** 2).sum(0)
    inside = (A - B > 0.5) & (A > 0.3)
    return np.ascontiguousarray(z[:, inside][:, :orbits])


def energy(model, z):
    """Return T + V."""
    n = model.degrees_of_freedom
    return model.kinetic_energy(*z[n:]) + model.potential_energy(*z[:n])


def slope(model, z):
    """Return dz/dt of Hamilton's equations."""
    n = model.degrees_of_freedom
    return np.array([*model.velocity(*z[n:]), *model.force(*z[:n])])


def splitting_step(model, scheme, z, h):
    """Return z after one step of a splitting."""
    n = model.degrees_of_freedom
    q, p = np.array(z[:n]), np.array(z[n:])
    for drift, kick in zip(scheme.drift, (*scheme.kick, 0.0), strict=True):
        q = q + h * drift * np.array(model.velocity(*p))
        p = p + h * kick * np.array(model.force(*q))
    return np.concatenate([q, p])


def runge_kutta_step(model, scheme, z, h):
    """Return z after one step of an explicit tableau."""
    k = []
    for row in scheme.a:
        k.append(slope(model, z + h * sum((a * s for a, s in zip(row, k, strict=True)), np.zeros_like(z))))
    return z + h * sum(b * s for b, s in zip(scheme.b, k, strict=True))


def collocation_step(model, scheme, z, h):
    """Return z after one step of a collocation, by a hundred sweeps over all stages at once."""
    a, b = scheme.a_array * scheme.b_array, scheme.b_array
    k = [slope(model, z)] * b.size
    for _ in range(100):
        k = [slope(model, z + h * sum(entry * s for entry, s in zip(row, k, strict=True))) for row in a]
    return z + h * sum(entry * s for entry, s in zip(b, k, strict=True))


def nystrom_step(model, scheme, z, h):
    """One step as it is published, for q'' = v(F(q)) of a velocity v linear in the momenta, plain arrays."""
    n, forces = len(z) // 2, []
    q, p = z[:n], z[n:]
    accelerations = lambda: np.array([model.velocity(*f) for f in forces]).reshape(len(forces), *q.shape)  # noqa: E731
    velocity = np.array(model.velocity(*p))
    for row, node in zip(scheme.a, scheme.c):
        forces.append(np.array(model.force(*(q + node * h * velocity + h * h * np.tensordot(row, accelerations(), 1)))))
    drift = [w * (1 - node) for w, node in zip(scheme.b, scheme.c)]
    q = q + h * velocity + h * h * np.tensordot(drift, accelerations(), 1)
    return np.concatenate([q, p + h * np.tensordot(scheme.b, np.array(forces), 1)])


def step(model, scheme, z, h):
    """Return z after one step of any scheme."""
    steps = {Splitting: splitting_step, Collocation: collocation_step, Nystrom: nystrom_step}
    one = steps.get(type(scheme), runge_kutta_step)
    return one(model, scheme, np.asarray(z, dtype=float), h)


def march(model, scheme, z, h, steps):
    """Return the states (steps + 1, 2n, ...) of a fixed-step run, the start first."""
    path = [np.asarray(z, dtype=float)]
    for _ in range(steps):
        path.append(step(model, scheme, path[-1], h))
    return np.array(path)


def solve(model, z, times):
    """Return the states (times, 2n) of one orbit by SciPy's DOP853."""
    times = np.atleast_1d(times)
    solution = solve_ivp(
        lambda t, y: slope(model, y), (0.0, times[-1]), z, method="DOP853", t_eval=times, rtol=1e-13, atol=1e-14
    )
    assert solution.success
    return solution.y.T


def solved_crossings(model, z, section, time):
    """Return the times of all crossings in (0, time) by root search on SciPy's dense output."""
    flow = solve_ivp(
        lambda t, y: slope(model, y),
        (0.0, time),
        z,
        method="DOP853",
        dense_output=True,
        rtol=1e-13,
        atol=1e-14,
        max_step=0.05,
    ).sol
    grid = np.linspace(0.0, time, 8001)
    return _roots(lambda t: section.value(*flow(t)), grid, section.value(*flow(grid)), section.direction)


def scheme_crossings(model, scheme, z, section, h, time):
    """Return times and states of all crossings in (0, time) by root search on fractional steps of a scheme."""
    path = march(model, scheme, z, h, int(np.ceil(time / h)))
    times, points = [], []
    for i, start in enumerate(path[:-1]):
        ends = [section.value(*start), section.value(*path[i + 1])]
        roots = _roots(
            lambda tau, start=start: section.value(*step(model, scheme, start, tau)), [0.0, h], ends, section.direction
        )
        times += [i * h + tau for tau in roots]
        points += [step(model, scheme, start, tau) for tau in roots]
    return np.array(times), np.array(points)


def _roots(function, grid, values, direction):
    """Return the roots between grid points of opposite sign, where the function goes the right way."""
    found = []
    for a, b, u, v in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
        if (u < 0 <= v and direction >= 0) or (u > 0 >= v and direction <= 0):
            found.append(b if v == 0 else brentq(function, a, b, xtol=1e-15, rtol=9e-16))
    return np.array(found)


def constants(body, z):
    """Return E, p_eta, p_gamma of phase points (8, ...)."""
    return energy(body, z), z[0] * z[5] - z[1] * z[4], z[2] * z[7] - z[3] * z[6]


def sign(x):
    """Return the sign of x, +1 for 0: the sense in which the plane's loop turns for no angular momentum."""
    return np.where(x < 0, -1.0, 1.0)


def alpha_beta_frequencies(body, z):
    """Return nu_alpha, nu_beta, nu_eta, nu_gamma (4, orbits) of Harmonic and Anharmonic bodies.

    formulas.md section 4 (Martens & Slawianowski, EQ3.21-3.23 and after EQa, corrected).
    """
    omega = np.sqrt(body.potential.C / body.mu)
    _, p_eta, p_gamma = constants(body, z)
    eta = sign(p_eta)
    if isinstance(body.potential, Anharmonic):
        J_eta = 2 * np.pi * p_eta
        eta = J_eta / np.sqrt(16 * np.pi**2 * body.mu * body.potential.C + J_eta**2)
    one = np.ones_like(p_eta)
    return omega / np.pi * np.array([one, one, eta / 2, sign(p_gamma) / 2])


def r_vartheta_frequencies(body, z, nodes=4096):
    """Return nu_r, nu_vartheta, nu_eta, nu_gamma (4, orbits) of Hyperelastic and HeavyTop bodies by quadrature.

    formulas.md section 7. With x = cos vartheta the square of p_vartheta is a cubic c(x) over a positive function.
    The loop integrals are sums over Chebyshev nodes between its turning points x1 < x2, which converge exponentially:

        c(x) = (x - x1)(x2 - x) R(x) (times x for Hyperelastic),   I[f] = integral of f/sqrt((x-x1)(x2-x) R) from x1 to
        x2, nu_r = omega/pi,   nu_vartheta = omega/(Lambda I[1]), nu_gamma = nu_vartheta I[2 p_gamma/(1 - x)]/2 pi,
        nu_eta = nu_vartheta I[2 p_eta/(1 + x)]/2 pi.

    For small p_gamma the pole at x = 1 comes close to x2: it is taken off in closed form. As c(1) = -4 p_gamma^2,

        I[2 p_gamma/(1-x)] = pi sign(p_gamma) + 2 p_gamma (integral of a smooth function),

    which is exact for p_gamma -> 0 and keeps all digits; the same at x = -1 for p_eta of the heavy top.
    """
    mu, C = body.mu, body.potential.C
    omega = np.sqrt(C / mu)
    E, p_eta, p_gamma = constants(body, z)
    A, B = (z[:2] ** 2).sum(0), (z[2:4] ** 2).sum(0)
    r, u = A + B, (z[:4] * z[4:]).sum(0)
    Lambda2 = 2 * mu * r * E - mu * C * r * r - u * u
    top = isinstance(body.potential, HeavyTop)
    theta = (np.arange(nodes) + 0.5) * np.pi / nodes
    out = np.full((4, z.shape[1]), np.nan)
    for i in range(z.shape[1]):
        pe, pg, L2 = p_eta[i], p_gamma[i], Lambda2[i]
        spins = [2 * pg * pg - 2 * pe * pe, 2 * pe * pe + 2 * pg * pg]
        if top:
            c = np.polysub(np.polymul([-1, 0, 1], [-2 * mu * body.potential.A, L2]), spins)
        else:
            c = np.polysub(np.polymul([-1, 0, 1], [L2, -4 * mu * C]), np.polymul([1, 0], spins))
        roots = np.sort(np.roots(c).real)
        for _ in range(3):
            slopes = np.polyval(np.polyder(c), roots)
            roots = roots - np.polyval(c, roots) / np.where(slopes == 0, np.inf, slopes)
        x0 = (A[i] - B[i]) / r[i]
        at = [j for j in range(2) if roots[j] - 1e-9 <= x0 <= roots[j + 1] + 1e-9]
        at = [j for j in at if np.polyval(c, (roots[j] + roots[j + 1]) / 2) > 0 and roots[j + 1] > (-1 if top else 0)]
        x1, x2 = roots[at[0]], roots[at[0] + 1]
        x3 = roots[0] if at[0] else roots[2]
        x = (x1 + x2) / 2 + (x2 - x1) / 2 * np.cos(theta)
        lead = -c[0]

        def R(x):
            return lead * (x - x3) if top else lead * (1 - x3 / x)  # noqa: B023

        # Next to an upright top x3 -> 1: R(1) = 4 p_gamma^2/((1 - x1)(1 - x2)) keeps the digits there.
        root, end = np.sqrt(R(x)), np.sqrt(R(1.0) if abs(1 - x3) > 1e-3 else 4 * pg * pg / ((1 - x1) * (1 - x2)))
        difference = lead if top else lead * x3 / x  # (R(1) - R(x))/(1 - x)
        smooth = difference / (root * end * (root + end))  # (1/sqrt R(x) - 1/sqrt R(1))/(1 - x)
        angle = np.pi * smooth.mean()
        turn_gamma = np.pi * sign(pg) + 2 * pg * angle
        if top:
            end = np.sqrt(R(-1.0))
            angle = np.pi * (-lead / (root * end * (root + end))).mean()
            turn_eta = np.pi * sign(pe) + 2 * pe * angle
        else:
            turn_eta = 2 * pe * np.pi * (1 / ((1 + x) * root)).mean()
        period = np.pi * (1 / root).mean()
        scale = omega / (np.sqrt(L2) * period)
        out[:, i] = omega / np.pi, scale, scale * turn_eta / (2 * np.pi), scale * turn_gamma / (2 * np.pi)
    return out


def frequencies(body, z):
    """Return the four frequencies of an integrable body in the order librations, eta, gamma."""
    separable = isinstance(body.potential, (Harmonic, Anharmonic))
    return alpha_beta_frequencies(body, z) if separable else r_vartheta_frequencies(body, z)


def turns(body, z, time, step):
    """Return the mean turning rates nu_eta, nu_gamma (2, ...) of orbits (8, ...) over `time`: unwrapped angles and
    nothing else.
    """
    path = march(body, KAHAN_LI8, z, step, round(time / step))
    planes = path[:, [0, 2]] + 1j * path[:, [1, 3]]
    return np.angle(planes[1:] / planes[:-1]).sum(axis=0) / (2 * np.pi * time)


def r_vartheta_actions(body, z):
    """Return J_r, J_vartheta, J_eta, J_gamma (4,) of one orbit of a Hyperelastic or HeavyTop body, by mpmath.

    formulas.md section 7: one integral in epsilon = vartheta/2 between its turning points.
    """
    import mpmath

    mu, potential = body.mu, body.potential
    E, p_eta, p_gamma = (mpmath.mpf(float(x)) for x in constants(body, z))
    r, u = (z[:4] ** 2).sum(), z[:4] @ z[4:]
    Lambda2 = mpmath.mpf(2 * mu * r) * E - mu * potential.C * r * r - u * u

    def square(epsilon):
        cosine = mpmath.cos(2 * epsilon)
        V = potential.A * cosine if isinstance(potential, HeavyTop) else 2 * potential.C / cosine
        return Lambda2 - (p_eta / mpmath.cos(epsilon)) ** 2 - (p_gamma / mpmath.sin(epsilon)) ** 2 - 2 * mu * V

    here = mpmath.atan2(np.hypot(z[2], z[3]), np.hypot(z[0], z[1]))
    ends = []
    for direction in (-1, 1):
        inside = outside = here
        while square(outside) > 0:
            inside, outside = outside, outside + direction * mpmath.mpf("1e-3")
        for _ in range(60):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if square(middle) > 0 else (inside, middle)
        ends.append(inside)
    centre, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2

    def integrand(s):
        return mpmath.sqrt(max(square(centre + half * mpmath.sin(s)), 0)) * half * mpmath.cos(s)

    J_vartheta = 2 * mpmath.quad(integrand, mpmath.linspace(-mpmath.pi / 2, mpmath.pi / 2, 5))
    J_r = mpmath.pi * (E * mpmath.sqrt(mu / potential.C) - mpmath.sqrt(Lambda2))  # E = omega (2 I_rho + Lambda)
    return np.array([float(J_r), float(J_vartheta), 2 * np.pi * float(p_eta), 2 * np.pi * float(p_gamma)])
