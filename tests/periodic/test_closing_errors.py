"""Errors of periodic orbits, their periods, multipliers and residues against closed forms, whatever the multiplier, the
units and the accuracy.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipk

import fastaff as fa
from fastaff import Status

DRAWS = 120
ROUNDED = 2e-14
"""Of the truths themselves, in own units."""

DUFFING = "m*(L/s)**2*(a*((c*(x-u)+d*(y-v))/L)**2/2 + b*((c*(x-u)+d*(y-v))/L)**4/4 - k*k*((c*(y-v)-d*(x-u))/L)**2/2)"


def units(rng):
    """Return a length, a time and a mass."""
    return 10 ** rng.uniform(-5, 5), 10 ** rng.uniform(-3, 3), 10 ** rng.uniform(-3, 3)


def accuracy(rng, step, length):
    """Return the options of a search: none, another scheme with coarse or fine steps, or tolerances."""
    kind = rng.integers(4)
    if kind == 0:
        return {"scheme": fa.DOP853, "rtol": 10 ** rng.uniform(-13, -9), "atol": 1e-14 * length, "tolerance": 1e-8}
    if kind == 1:
        scheme = (fa.KAHAN_LI8, fa.BLANES_MOAN6)[rng.integers(2)]
        return {"scheme": scheme, "step": step * 10 ** rng.uniform(-2, -0.9), "tolerance": 1e-11}
    return {}


class Draw:
    """A system with its periodic orbit: model, section, the orbit's point and period, its multipliers."""

    def __init__(self, model, section, z, time, multipliers, options, guess):
        self.model, self.section, self.z, self.time = model, section, z, time
        self.multipliers, self.options, self.guess = multipliers, options, guess

    def ratios(self):
        """Return the errors of z, period, multipliers and residue beside their estimates, or None: not found."""
        found = fa.periodic_orbits(self.model, self.guess, section=self.section, **self.options)
        if found.status[0] != Status.OK:
            return None
        rows = [0, 2] if len(self.z) == 2 and len(found.z) == 4 else slice(None)
        rate = 2 * np.pi / self.time  # at most that of the motion
        off = np.linalg.norm((found.z[rows, 0] - self.z) / found.scale[rows, 0])
        late = abs(found.period[0] - self.time) * rate
        error = found.error[0] + ROUNDED
        own = np.sort(np.abs(found.multipliers[:, 0]))
        order, truth = np.argsort(np.abs(found.multipliers[:, 0])), np.sort(self.multipliers)
        wrong = np.abs(own - truth) / (found.multiplier_errors[order, 0] + ROUNDED * truth)
        result = [off / error, late / error, *wrong]
        if found.symplectic:
            residue = (2 - self.multipliers.sum()) / 4
            result.append(abs(found.residue[0] - residue) / (found.residue_errors[0, 0] + ROUNDED * abs(residue)))
        return np.array(result)


def natural(rng):
    """A quartic oscillator beside an inverted one, seen from turned axes, at any place and in any units."""
    (L, s, m), a, b, A = units(rng), rng.uniform(0.5, 2), rng.uniform(0.1, 1), rng.uniform(0.3, 1.5)
    stiff = np.sqrt(a + b * A * A)
    time = 4 * ellipk(b * A * A / (2 * stiff**2)) / stiff
    large = 10 ** rng.uniform(0.3, 6)
    angle, k = rng.uniform(-1, 1), np.log(large) / time
    c, d = np.cos(angle), np.sin(angle)
    u, v = L * rng.choice([0.0, 1.0, 30.0]) * rng.standard_normal(2)
    model = fa.hamiltonian(DUFFING, coordinates="x y", masses=[m, m], m=m, L=L, s=s, a=a, b=b, k=k, c=c, d=d, u=u, v=v)
    normal = np.array([c, d, 0, 0]) + rng.uniform(-0.4, 0.4) * np.array([-d, c, 0, 0])
    P = A * np.sqrt(a + b * A * A / 2) * m * L / s
    z = np.array([u, v, c * P, d * P])
    scale = np.array([L, L, m * L / s, m * L / s])
    guess = z + 0.02 / large * scale * rng.uniform(-1, 1, 4)
    options = {"energy": P * P / (2 * m), "section": 0, **accuracy(rng, s, L)}
    del options["section"]
    section = fa.Hyperplane(tuple(normal), offset=float(normal[:2] @ (u, v)))
    return Draw(model, section, z, time * s, np.array([large, 1 / large]), options, guess)


def driven(rng):
    """An inverted quartic well, carried along f cos(w t) with the force that this takes."""
    (L, s, m), b, f, w = units(rng), rng.uniform(0.1, 1), rng.uniform(0.1, 1), rng.uniform(0.6, 2)
    large, u = 10 ** rng.uniform(0.3, 6), L * rng.choice([0.0, 1.0, 30.0]) * rng.standard_normal()
    k = np.log(large) * w / (2 * np.pi)
    V = "m*(L/s)**2*(-k*k*((x-u)/L-f*cos(w*t/s))**2/2 + b*((x-u)/L-f*cos(w*t/s))**4/4 + f*w*w*(x-u)/L*cos(w*t/s))"
    model = fa.hamiltonian(
        V, coordinates="x", masses=[m], drive_period="2*pi*s/w", m=m, L=L, s=s, k=k, b=b, f=f, w=w, u=u
    )
    z = np.array([u + L * f, 0.0])
    guess = z + 0.01 / large * np.array([L, m * L / s]) * rng.uniform(-1, 1, 2)
    time = 2 * np.pi * s / w
    return Draw(model, "t=0", z, time, np.array([large, 1 / large]), accuracy(rng, s, L), guess)


def standard(rng):
    """The fixed point of the standard map at 0: residue -K/4."""
    K = 10 ** rng.uniform(-1, 6)
    large = 1 + K / 2 + np.sqrt(K + K * K / 4)
    guess = 0.02 / (1 + K) * rng.uniform(-1, 1, 2)
    return Draw(fa.models.StandardMap(K=K), None, np.zeros(2), 1.0, np.array([large, 1 / large]), {}, guess)


@pytest.mark.parametrize("system", [standard, natural, driven], ids=lambda system: system.__name__)
def test_errors_cover_closed_forms_whatever_the_multiplier(system):
    rng = np.random.default_rng(16)
    ratios = [system(rng).ratios() for _ in range(DRAWS)]
    found = np.array([each for each in ratios if each is not None])
    assert len(found) >= 0.95 * DRAWS
    assert found.max() < 10
    assert np.mean(found.max(axis=1) <= 1) >= 0.99


def test_orbits_whose_multipliers_leave_no_digits_say_so():
    """Multipliers of 1e12: what is left of the period is said, and covers it; a coarse step is said too."""
    rng = np.random.default_rng(3)
    for _ in range(6):
        draw = natural(rng)
        k = draw.model.k * np.log(1e12) / np.log(draw.multipliers[0])
        found = fa.periodic_orbits(draw.model._replace(k=k), draw.z, section=draw.section)
        if found.status[0] == Status.OK:
            rate = 2 * np.pi / draw.time
            assert abs(found.period[0] - draw.time) * rate <= found.error[0]
            assert ("relative errors above 1e-06" in found.summary()) == (found.error[0] > 1e-6)
        else:
            assert found.status[0] == Status.NOT_CONVERGED
    coarse = fa.periodic_orbits(
        fa.HenonHeiles(),
        [0.0, 0.0, np.sqrt(0.12), 0.2],
        section=fa.Hyperplane((1, 0, 0, 0)),
        scheme=fa.YOSHIDA4,
        step=0.3,
        tolerance=1e-4,
    )
    assert coarse.status[0] == Status.OK
    assert coarse.error[0] > 1e-6
    assert "1 have relative errors above 1e-06" in coarse.summary()


MOON = 1.215058560962404e-02
NEAR = ((0.9795, -1.75296), (0.9755, -1.43367), (0.9995, 1.44839), (0.996, 1.73446))
"""x and about y' of planar Lyapunov orbits of L1 and L2, where they pass the Moon at 0.008 to 0.012."""


@pytest.mark.parametrize(("x", "speed"), NEAR)
def test_lyapunov_orbits_that_pass_the_moon_closely_have_the_period_of_a_symmetric_shooting(x, speed):
    """From one perpendicular crossing to the next by SciPy; the motion beside the Moon is much faster than the
    orbit: it must not set the time to wait for.
    """
    m, sign = MOON, np.sign(speed)

    def slope(t, z):
        x, y, px, py = z
        near, far = m / np.hypot(x - 1 + m, y) ** 3, (1 - m) / np.hypot(x + m, y) ** 3
        return px + y, py - x, py - far * (x + m) - near * (x - 1 + m), -px - (far + near) * y

    def across(t, z):
        return z[1]

    across.terminal, across.direction = True, -sign

    def half(v):
        start = [x, 0.0, 0.0, v + x]
        return solve_ivp(slope, (0, 12), start, events=across, method="DOP853", rtol=1e-13, atol=1e-14)

    v = brentq(lambda v: half(v).y[2, -1], speed - 2e-4, speed + 2e-4, xtol=1e-15, rtol=1e-15)
    start, period = np.array([x, 0.0, 0.0, v + x]), 2 * half(v).t[-1]
    V = "-(1 - m)/sqrt((x + m)**2 + y**2) - m/sqrt((x - 1 + m)**2 + y**2)"
    model = fa.hamiltonian(V, rotation=1.0, m=m)
    section = fa.Hyperplane((0.0, 1.0, 0.0, 0.0), direction=int(sign))
    found = fa.periodic_orbits(model, start, section=section)
    assert found.status[0] == Status.OK
    rate = found.scale[2, 0] / found.scale[0, 0]
    # SciPy's error is that of half the orbit, at which 1e-13 has grown by the root of the multiplier.
    assert abs(found.period[0] - period) * rate <= found.error[0] + 1e-10
    assert found.error[0] < 1e-8
    branch = fa.continuation(model, found.z[:, 0], section=section, max_steps=1, ds=1e-3)
    assert abs(branch.orbits.period[0] - period) * rate <= branch.orbits.error[0] + 1e-10
