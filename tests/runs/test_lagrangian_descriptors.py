"""Lagrangian descriptors as a variable of an ODE, as in their recipe: against closed forms and a quadrature."""

import numpy as np
from scipy.integrate import quad, solve_ivp

import fastaff as fa


def descriptor(equations, z0, time, **parameters):
    """Return the sum of the last variable forward and backward in time."""
    return sum(fa.integrate(fa.ode(equations, s=s, **parameters), z0, time=time).z[-1] for s in (1, -1))


def test_saddle_and_oscillator():
    """M of |z'|^2 is (x^2 + p^2) sinh 2 tau for H = (p^2 - x^2)/2; the arc of H = (p^2 + x^2)/2 is 2 tau r."""
    random = np.random.default_rng(2)
    z0 = np.vstack([random.uniform(-1, 1, (2, 20)), np.zeros(20)])
    square = z0[0] ** 2 + z0[1] ** 2
    saddle = descriptor("x' = s*p; p' = s*x; M' = x**2 + p**2", z0, 1.7)
    np.testing.assert_allclose(saddle, square * np.sinh(3.4), rtol=1e-8)
    circle = descriptor("x' = s*p; p' = -s*x; M' = sqrt(x**2 + p**2)", z0, 5.0)
    np.testing.assert_allclose(circle, 10.0 * np.sqrt(square), rtol=1e-8)


def test_driven_duffing_oscillator():
    tau, a, w = 6.0, 0.1, 1.0
    z0 = np.random.default_rng(3).uniform(-1, 1, (2, 4))
    equations = "x' = s*p; p' = s*(x - x**3 + a*cos(phi)); phi' = s*w; M' = sqrt(p**2 + (x - x**3 + a*cos(phi))**2)"
    found = descriptor(equations, np.vstack([z0, np.zeros((2, 4))]), tau, a=a, w=w)

    def rates(t, z):
        return [z[1], z[0] - z[0] ** 3 + a * np.cos(w * t)]

    for k in range(4):
        total = 0.0
        for end in (tau, -tau):
            path = solve_ivp(rates, (0.0, end), z0[:, k], method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True)
            arc, _ = quad(lambda t, path=path: np.hypot(*rates(t, path.sol(t))), 0.0, end, limit=400, epsabs=1e-10)
            total += abs(arc)
        np.testing.assert_allclose(found[k], total, rtol=1e-6)
