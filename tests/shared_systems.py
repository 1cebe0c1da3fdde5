"""Systems that test modules share: their loops are compiled once, as the numbers are given when they run."""

import numpy as np

import fastaff as fa


def well(k=1.0, c=0.0):
    """x'' = -k x - c x^3."""
    return fa.hamiltonian("k*x**2/2 + c*x**4/4", coordinates="x", k=float(k), c=float(c))


def plane(a=0.0, b=0.0, ab=0.0, c=0.0, d=0.0, e=0.0, f=0.0, g=0.0, zero=0.0):
    """V = a x^2/2 + b y^2/2 + ab x y + c x^2 y - d y^3/3 + e x^4/4 + f x^2 y^2/2 + g y^4/4 + zero: Henon-Heiles for
    a = b = c = d = 1. Its terms have no value, not even 0, where x^4 is beyond all numbers.
    """
    text = "a*x**2/2 + b*y**2/2 + ab*x*y + c*x**2*y - d*y**3/3 + e*x**4/4 + f*x**2*y**2/2 + g*y**4/4 + zero"
    numbers = {"a": a, "b": b, "ab": ab, "c": c, "d": d, "e": e, "f": f, "g": g, "zero": zero}
    return fa.hamiltonian(text, **{name: float(value) for name, value in numbers.items()})


def duffing(a=0.3, w=1.2, k=-1.0, c=1.0, mass=1.0):
    """mass x'' = -k x - c x^3 + a cos(w t)."""
    return fa.hamiltonian(
        "k*x**2/2 + c*x**4/4 - a*x*cos(w*t)",
        coordinates="x",
        masses=(float(mass),),
        drive_period="2*pi/w",
        k=float(k),
        c=float(c),
        a=float(a),
        w=float(w),
    )


def oscillators(a=1.0, b=1.0, masses=(1.0, 1.0)):
    """Uncoupled oscillators: m_x x'' = -a x, m_y y'' = -b y."""
    return fa.hamiltonian("(a*x**2 + b*y**2)/2", masses=masses, a=float(a), b=float(b))


def springs(K, masses=None, origin=0.0, zero=0.0):
    """V = zero + (q - origin) K (q - origin)/2 in up to six coordinates; with masses it is another compiled model."""
    n = len(K)
    names, pairs = "xyzuvw"[:n], {f"k{i}{j}": (i, j) for i in range(n) for j in range(i + 1)}
    text = " + ".join(f"{k}*({names[i]} - o)*({names[j]} - o)" for k, (i, j) in pairs.items())
    return fa.hamiltonian(
        f"{text} + c",
        coordinates=" ".join(names),
        masses=masses,
        **{k: float(K[i, j] / (2 if i == j else 1)) for k, (i, j) in pairs.items()},
        o=float(origin),
        c=float(zero),
    )


def linear_map(matrix, centre=(0.0, 0.0)):
    """The map (x, p) -> centre + matrix ((x, p) - centre)."""
    (a, b), (c, d) = np.asarray(matrix, float).tolist()
    x0, p0 = np.asarray(centre, float).tolist()
    text = "x1 = x0 + a*(x - x0) + b*(p - p0); p1 = p0 + c*(x - x0) + d*(p - p0)"
    return fa.iterated_map(text, x0=x0, p0=p0, a=a, b=b, c=c, d=d)


def henon(a=1.4, b=0.3):
    """The dissipative map of Henon (1976)."""
    return fa.iterated_map("x1 = 1 - a*x**2 + y; y1 = b*x", a=a, b=b)


def toda():
    """Three particles on a ring, centre of mass removed (Henon 1974, Phys. Rev. B 9, 1921): integrable, Henon-Heiles to
    third order.
    """
    return fa.hamiltonian("(exp(2*y + 2*sqrt(3)*x) + exp(2*y - 2*sqrt(3)*x) + exp(-4*y))/24 - 1/8")


def galaxy(core, q=0.9):
    """V = log(core^2 + x^2 + y^2/q^2)/2."""
    return fa.hamiltonian("log(x**2 + y**2/q**2 + c**2)/2", q=float(q), c=float(core))


def turning_springs(a=1.0, b=1.0, w=0.3):
    """V = (a x^2 + b y^2)/2 in a frame that turns at the rate w."""
    return fa.hamiltonian("(a*x**2 + b*y**2)/2", rotation="w", a=float(a), b=float(b), w=float(w))


CHARGE = "k*(x**2 + y**2 + 2*z**2)/2 + a*x*y*z"


def charge(k, a, B, masses=(1.0, 1.0, 1.0)):
    """A charge 1 in the potential CHARGE and the uniform field B along z."""
    return fa.hamiltonian(CHARGE, coordinates="x y z", masses=masses, magnetic="B", k=k, a=a, B=B)


def spherical(rng, orbits):
    """Return a spherical pendulum, its azimuth in a drawn unit, starts, and frequencies (2, orbits) by quadrature.

    With u = cos th, u'^2 = 2 (E - g u)(1 - u^2) - L^2 = 2 g (u - u1)(u2 - u)(u3 - u), and f' = L/(1 - u^2).
    """
    g, unit = rng.uniform(0.5, 2.0), rng.uniform(0.2, 5.0)
    text = "pt**2/2 + (s*pf)**2/(2*sin(th)**2) + g*cos(th)"
    model = fa.hamiltonian(text, coordinates="th f", momenta="pt pf", periodic={"f": "2*pi*s"}, g=g, s=unit)
    L = rng.uniform(0.25, 1.0, orbits) * rng.choice([-1, 1], orbits)
    z = np.array([rng.uniform(1.4, 2.6, orbits), rng.uniform(-9, 9, orbits), rng.uniform(-0.5, 0.5, orbits), L / unit])
    E = z[2] ** 2 / 2 + L**2 / (2 * np.sin(z[0]) ** 2) + g * np.cos(z[0])
    truth = np.empty((2, orbits))
    phase = (np.arange(4096) + 0.5) * np.pi / 4096
    for o in range(orbits):
        u1, u2, u3 = np.sort(np.roots([2 * g, -2 * E[o], -2 * g, 2 * E[o] - L[o] ** 2]).real)
        u = (u1 + u2) / 2 - (u2 - u1) / 2 * np.cos(phase)
        rate = 1 / np.sqrt(2 * g * (u3 - u))
        period = 2 * np.pi * rate.mean()
        truth[:, o] = 1 / period, L[o] * (rate / (1 - u**2)).mean() / period
    return model, z, truth
