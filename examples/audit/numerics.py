"""Independent numerics: differences, pullbacks, brackets, loops and eigenvalues from first principles, no formula of
the paper.

First and second derivatives are central differences with steps of 1e-12 in 50 digits: truncation and rounding leave
1e-24.
"""

from __future__ import annotations

import numpy as np
from mpmath import cos, mp, mpf, pi, sin, sqrt

STEP = mpf(10) ** -12


def moved(x, i, h):
    """Return the list x with h added to x[i]."""
    return [value + h if k == i else value for k, value in enumerate(x)]


def d(f, i):
    """Return the function df/dx_i of a function of several arguments."""
    return lambda *x: (f(*moved(x, i, STEP)) - f(*moved(x, i, -STEP))) / (2 * STEP)


def dd(f, i, j):
    """Return the function d^2 f/dx_i dx_j."""
    if i == j:
        return lambda *x: (f(*moved(x, i, STEP)) - 2 * f(*x) + f(*moved(x, i, -STEP))) / STEP**2
    return d(d(f, i), j)


def along(f, q, dq):
    """Return the derivative of a list-valued function at q in the direction dq."""
    ahead = f(*[x + STEP * v for x, v in zip(q, dq)])
    behind = f(*[x - STEP * v for x, v in zip(q, dq)])
    return [(u - v) / (2 * STEP) for u, v in zip(ahead, behind)]


def axis(n, i):
    """Return the unit vector i of n."""
    return [mpf(k == i) for k in range(n)]


def square(dx):
    """Return the sum of |dx|^2."""
    return sum(abs(v) ** 2 for v in dx)


def metric(chart, q):
    """Return the pullback matrix [d_i X . d_j X] of the Euclidean metric by the chart q -> X."""
    n = len(q)
    columns = [along(chart, q, axis(n, i)) for i in range(n)]
    return mp.matrix([[mp.re(sum(mp.conj(u) * v for u, v in zip(a, b))) for b in columns] for a in columns])


def jacobian(chart, q):
    """Return the matrix [dX_k/dq_i], rows k."""
    n = len(q)
    return mp.matrix([along(chart, q, axis(n, i)) for i in range(n)]).T


def momenta(chart, q, dq, mu):
    """Return p_i = dT/d(dq_i) of T = mu/2 |dX|^2."""
    dx = along(chart, q, dq)
    return [mu * sum(u * v for u, v in zip(along(chart, q, axis(len(q), i)), dx)) for i in range(len(q))]


def gradient(f, z):
    """Return all first derivatives."""
    return [d(f, i)(*z) for i in range(len(z))]


def bracket(f, g, z):
    """Return the Poisson bracket {f, g} at z = (q, p), divided by |grad f| |grad g|."""
    n = len(z) // 2
    a, b = gradient(f, z), gradient(g, z)
    return sum(a[i] * b[n + i] - a[n + i] * b[i] for i in range(n)) / sqrt(square(a) * square(b))


def levi_civita(H, z):
    """Return the largest of Levi-Civita's expressions, which vanish for all z if and only if H separates in these
    coordinates.

    For i != j, without sums (H_i = dH/dq_i, H^i = dH/dp_i): H^i H^j H_ij + H_i H_j H^ij - H^i H_j H_i^j - H_i H^j
    H^i_j, divided by the largest first derivative squared times the largest second one (T. Levi-Civita, Math. Ann. 59,
    383, 1904).
    """
    n = len(z) // 2
    g = gradient(H, z)
    worst, curvature = mpf(0), max(abs(dd(H, i, i)(*z)) for i in range(2 * n))
    for i in range(n):
        for j in range(i):
            second = [dd(H, k, m)(*z) for k, m in ((i, j), (n + i, n + j), (i, n + j), (n + i, j))]
            factors = g[n + i] * g[n + j], g[i] * g[j], -g[n + i] * g[j], -g[i] * g[n + j]
            worst = max(worst, abs(sum(a * b for a, b in zip(factors, second))))
    return worst / (curvature * max(abs(v) for v in g) ** 2)


def turning(inside, end, value):
    """Return the zero of `value` between a point where it is positive and the end of the domain (0 or inf, or any
    number).
    """
    near, far = inside, inside
    while value(far) > 0:
        near, far = far, far * mpf(5) / 4 if end == mp.inf else end + (far - end) * mpf(4) / 5
    for _ in range(20):
        middle = (near + far) / 2
        near, far = (middle, far) if value(middle) > 0 else (near, middle)
    return mp.findroot(value, (near, far), solver="anderson", tol=mpf(10) ** -90, maxsteps=200, verify=False)


def loop(radicand, inside, low=0, high=mp.inf):
    """Return the closed integral of sqrt(radicand) dq over the well around `inside`.

    With q = middle + half cos(t) the integrand is smooth and periodic, so the trapezoidal rule converges exponentially:
    twice the nodes square the error, and two sums that agree to 1e-20 have an error of about 1e-40.
    """
    left, right = turning(inside, mpf(low), radicand), turning(inside, mpf(high), radicand)
    middle, half = (left + right) / 2, (right - left) / 2

    def term(t):
        return sqrt(abs(radicand(middle + half * cos(t)))) * sin(t)

    nodes, total, before = 16, mpf(0), mp.inf
    total = sum(term(pi * k / nodes) for k in range(1, nodes))
    while True:
        total += sum(term(pi * (k + mpf(1) / 2) / nodes) for k in range(nodes))
        nodes *= 2
        now = 2 * half * pi / nodes * total
        if abs(now - before) < mpf(10) ** -20 * abs(now) or nodes > 8192:
            return now
        before = now


def frequencies(actions, energy, constants):
    """Return nu_k = dE/dJ_k from the functions J(constants) (a list) and E(constants), by differences and one linear
    solve.
    """
    return list(mp.lu_solve(jacobian(actions, constants).T, mp.matrix(gradient(energy, constants))))


def laplacian(f, x):
    """Return the sum of the second derivatives of f in Cartesian coordinates."""
    return sum(dd(f, i, i)(*x) for i in range(len(x)))


def levels(potential, weight, low, high, count, step):
    """Return the lowest eigenvalues e of -f'' + potential(t) f = e weight(t) f on the line, by sinc collocation in
    double.

    f must decay at both ends. The spectrum is that of the inverse, which is well conditioned though the weight spans
    many orders. The discretisation error is exp(-2 pi d/step) with d = pi/4 the width of the analytic strip, once
    pi/step exceeds the largest classical momentum.
    """
    t = np.arange(low, high, step)
    k = np.subtract.outer(np.arange(t.size), np.arange(t.size))
    with np.errstate(divide="ignore"):
        kinetic = np.where(k == 0, np.pi**2 / 3, 2.0 * (-1.0) ** np.abs(k) / np.where(k == 0, 1, k) ** 2) / step**2
    root = np.sqrt(weight(t))
    inverse = np.linalg.inv(kinetic + np.diag(potential(t)))
    values = np.linalg.eigvalsh(root[:, None] * inverse * root)
    return [float(v) for v in 1 / values[::-1][:count]]


def determinant_ratio(chart, q):
    """Return |det(dX/dq)|."""
    return abs(mp.det(jacobian(chart, q)))
