"""Actions, frequencies and angles in closed form where F is a quadratic polynomial: oscillators with walls.

Then G is constant, s = m - l cos(chi), and all integrals of `tori_librations` are elementary: with Lambda = sqrt(-F) at
a pole,

    1/2 loop integral of sqrt(F)/s ds = pi (b/(2 sqrt(a)) - Lambda),   integral of ds/(s sqrt(F)) = (2/Lambda) psi,
    psi = atan2(sqrt(s2) sin(chi/2), sqrt(s1) cos(chi/2)).
"""

from typing import NamedTuple

import numpy as np

from ...core.status import ACTION_ZERO_CODE, OK_CODE, SEPARATRIX_CODE, UNBOUND_CODE
from ...engine.jit import jit

UNIT = 1024
"""States that a thread takes at once."""

TURN = 2 * np.pi
NOISE = 4e-16
"""Amplitude relative to the middle below which it is rounding and counts as 0."""


class Tori(NamedTuple):
    """States z (8, n) and their tori: J, nu, theta, constants (4, n), turning (2, 3, n), error and status (n,)."""

    z: np.ndarray
    J: np.ndarray
    nu: np.ndarray
    theta: np.ndarray
    turning: np.ndarray
    constants: np.ndarray
    error: np.ndarray
    status: np.ndarray


@jit
def _cycle(middle, product, s, root, stiffness):
    """Oscillation of s around `middle` with s1 s2 = product, root = ds/dtime: (l, l cos(chi), l sin(chi), s1, s2,
    chi).
    """
    cosine = middle - s
    sine = root / stiffness
    amplitude = np.sqrt(cosine * cosine + sine * sine)
    if amplitude <= NOISE * middle:
        return 0.0, 0.0, 0.0, middle, middle, 0.0
    s2 = middle + amplitude
    return amplitude, cosine, sine, product / s2, s2, _angle(sine, cosine)


@jit
def _angle(sine, cosine):
    """Angle in [0, 2 pi)."""
    chi = np.arctan2(sine, cosine)
    return chi if chi >= 0.0 else chi + TURN


@jit
def _wind(mean, far, size, cosine, sine):
    """psi from l, l cos(chi), l sin(chi): atan2(far (1 - cos(chi)), mean sin(chi)) with mean = sqrt(near far), without
    half-angles.
    """
    rest = far * (size - cosine) if cosine <= 0.0 else far * sine * sine / (size + cosine)
    return np.arctan2(rest, mean * sine) if size > 0.0 else 0.0


@jit
def _wrap(x):
    """x modulo 1 in [0, 1)."""
    x -= np.floor(x)
    return 0.0 if x >= 1.0 else x


@jit
def _plane(mu, k, wall, x, y, px, py, out):
    """One plane with V = k s/2 + wall/s: (J, J_angle, nu, nu_angle, theta, theta_angle, energy, spin, s1, s2) to out;
    status.
    """
    s = x * x + y * y
    root = x * px + y * py
    spin = x * py - y * px
    energy = (px * px + py * py) / (2 * mu) + k * s / 2 + (wall / s if wall != 0.0 else 0.0)
    Lambda = np.sqrt(spin * spin + 2 * mu * wall)
    omega = np.sqrt(k / mu)
    middle = energy / k
    stiffness = np.sqrt(mu * k)
    mean = Lambda / stiffness
    amplitude, cosine, sine, s1, s2, chi = _cycle(middle, mean * mean, s, root, stiffness)
    out[6] = energy
    out[7] = spin
    out[8] = s1
    out[9] = s2
    angle = np.arctan2(y, x) if s > 0.0 else np.arctan2(py, px)
    code = OK_CODE
    ratio = 0.0
    if Lambda > 0.0:
        ratio = spin / Lambda
    else:
        code = SEPARATRIX_CODE
        ratio = np.nan
    # J = energy/omega - Lambda/2 pi is a difference: amplitude^2 keeps the digits of a small action.
    out[0] = np.pi * stiffness * amplitude * amplitude / (middle + mean) if amplitude > 0.0 else 0.0
    out[1] = TURN * spin
    out[2] = omega / np.pi
    out[3] = 0.5 * omega / np.pi * ratio
    out[4] = chi / TURN
    out[5] = (
        _wrap((angle - ratio * (_wind(mean, s2, amplitude, cosine, sine) - 0.5 * chi)) / TURN)
        if code == OK_CODE
        else np.nan
    )
    if amplitude == 0.0:
        out[4] = np.nan
        code = ACTION_ZERO_CODE if code == OK_CODE else code
    return code


def planes(unit, stop, progress, mu, k_a, wall_a, k_b, wall_b, tori):
    """Fill the tori: rows alpha, beta, eta, gamma of J, nu, theta; constants H_alpha, H_beta, c_eta, c_gamma."""
    z, J, nu, theta, turning, constants, error, status = tori
    if stop[0] != 0:
        return
    a = np.empty(10)
    b = np.empty(10)
    for i in range(unit * UNIT, min(status.size, (unit + 1) * UNIT)):
        code = _plane(mu, k_a, wall_a, z[0, i], z[1, i], z[4, i], z[5, i], a)
        other = _plane(mu, k_b, wall_b, z[2, i], z[3, i], z[6, i], z[7, i], b)
        J[0, i] = a[0]
        J[1, i] = b[0]
        J[2, i] = a[1]
        J[3, i] = b[1]
        nu[0, i] = a[2]
        nu[1, i] = b[2]
        nu[2, i] = a[3]
        nu[3, i] = b[3]
        theta[0, i] = a[4]
        theta[1, i] = b[4]
        theta[2, i] = a[5]
        theta[3, i] = b[5]
        constants[0, i] = a[6]
        constants[1, i] = b[6]
        constants[2, i] = a[7] * a[7] / (2 * mu)
        constants[3, i] = b[7] * b[7] / (2 * mu)
        turning[0, 0, i] = a[8]
        turning[0, 1, i] = a[9]
        turning[0, 2, i] = 1.0
        turning[1, 0, i] = b[8]
        turning[1, 1, i] = b[9]
        turning[1, 2, i] = 1.0
        error[i] = 1e-16
        status[i] = max(code, other)
    progress[unit] = 1


@jit
def _latitude(A, B, pA, pB, Lambda, L_a, L_b, z, i):
    """Motion of vartheta: whether it is nearer to pi, ends of s = sin^2(vartheta/2) and of t = 1 - s, half-width l,
    l cos(chi), l sin(chi).

    F = (s - s1)(s2 - s) Lambda^2 with s1 s2 = (L_b/Lambda)^2, (1 - s1)(1 - s2) = (L_a/Lambda)^2. The middle is computed
    from the nearer axis, as a sum of positive terms with F = root^2; from the energy it would be a difference.
    """
    r = A + B
    s = B / r
    t = A / r
    root = (A * pB - B * pA) / (r * Lambda)
    upper = s > 0.5
    x, near = (t, L_a / Lambda) if upper else (s, L_b / Lambda)
    if x > 0.0:
        total = (root * root + near * near) / x + x
        width = np.sqrt(root * root + (0.5 * total - x) * (0.5 * total - x))
    else:  # on the axis the whole momentum across it counts
        p = z[4, i] * z[4, i] + z[5, i] * z[5, i] if upper else z[6, i] * z[6, i] + z[7, i] * z[7, i]
        total = r * p / (Lambda * Lambda) + (near * near if near > 0.0 else 0.0)
        width = 0.5 * total
    bent = width <= NOISE * total
    width = 0.0 if bent else width
    x2 = 0.5 * total + width
    x1 = near * near / x2 if x2 > 0.0 else 0.0
    s1, s2, t1, t2 = (1 - x2, 1 - x1, x2, x1) if upper else (x1, x2, 1 - x1, 1 - x2)
    if upper:
        s1 = (L_b / Lambda) ** 2 / s2
    else:
        t2 = (L_a / Lambda) ** 2 / t1
    cosine = 0.0 if bent else (x - 0.5 * total if upper else 0.5 * total - x)
    return upper, s1, s2, t1, t2, width, cosine, 0.0 if bent else root


@jit
def _shell(mu, k, wall_r, wall_a, wall_b, tori, i):
    """One state of V = k r/2 + wall_r/r + (wall_a/cos^2(vartheta/2) + wall_b/sin^2(vartheta/2))/r; returns its
    status.
    """
    z, J, nu, theta, turning, constants, _, _ = tori
    A = z[0, i] * z[0, i] + z[1, i] * z[1, i]
    B = z[2, i] * z[2, i] + z[3, i] * z[3, i]
    pA = z[0, i] * z[4, i] + z[1, i] * z[5, i]
    pB = z[2, i] * z[6, i] + z[3, i] * z[7, i]
    p_eta = z[0, i] * z[5, i] - z[1, i] * z[4, i]
    p_gamma = z[2, i] * z[7, i] - z[3, i] * z[6, i]
    r = A + B
    square = 0.0
    kinetic = 0.0
    for m in range(4):
        kinetic += z[4 + m, i] * z[4 + m, i]
        for j in range(m):
            turn = z[m, i] * z[4 + j, i] - z[j, i] * z[4 + m, i]
            square += turn * turn
    h = square / (2 * mu) + (wall_a * r / A if wall_a != 0.0 else 0.0) + (wall_b * r / B if wall_b != 0.0 else 0.0)
    E = kinetic / (2 * mu) + k * r / 2 + (wall_r + h - square / (2 * mu)) / r
    constants[0, i] = E
    constants[1, i] = h
    constants[2, i] = p_eta * p_eta / (2 * mu)
    constants[3, i] = p_gamma * p_gamma / (2 * mu)
    if not h + wall_r > 0.0:
        return UNBOUND_CODE
    omega = np.sqrt(k / mu)
    outer = np.sqrt(2 * mu * (h + wall_r))
    Lambda = np.sqrt(2 * mu * h)
    L_a = np.sqrt(p_eta * p_eta + 2 * mu * wall_a)
    L_b = np.sqrt(p_gamma * p_gamma + 2 * mu * wall_b)
    stiffness = np.sqrt(mu * k)
    mean = outer / stiffness
    width_r, cos_r, sin_r, r1, r2, chi_r = _cycle(E / k, mean * mean, r, pA + pB, stiffness)
    upper, s1, s2, t1, t2, width, cosine, root = _latitude(A, B, pA, pB, Lambda, L_a, L_b, z, i)
    chi = _angle(root, cosine)
    bent = width == 0.0
    # sqrt(s1 s2), sqrt(t1 t2)
    product_s = L_b / Lambda
    product_t = L_a / Lambda
    spread = 2 * width / (np.sqrt(t1) + np.sqrt(t2) if upper else np.sqrt(s1) + np.sqrt(s2)) if width > 0.0 else 0.0
    turning[0, 0, i] = r1
    turning[0, 1, i] = r2
    turning[0, 2, i] = 1.0
    turning[1, 0, i] = s1
    turning[1, 1, i] = s2
    turning[1, 2, i] = t2
    J[2, i] = TURN * p_eta
    J[3, i] = TURN * p_gamma
    J[0, i] = np.pi * stiffness * width_r * width_r / (E / k + mean) if width_r > 0.0 else 0.0
    J[1, i] = np.pi * Lambda * spread * spread / (1 + (product_s - product_t if upper else product_t - product_s))
    code = OK_CODE if L_a > 0.0 and L_b > 0.0 else SEPARATRIX_CODE
    turn_a = p_eta / L_a if L_a > 0.0 else np.nan
    turn_b = p_gamma / L_b if L_b > 0.0 else np.nan
    nu[0, i] = omega / np.pi
    nu[1, i] = omega / np.pi * (Lambda / outer)
    nu[2, i] = 0.5 * nu[1, i] * turn_a
    nu[3, i] = 0.5 * nu[1, i] * turn_b
    tilt = (chi / 2 - Lambda / outer * (_wind(mean, r2, width_r, cos_r, sin_r) - chi_r / 2)) / np.pi
    eta = np.arctan2(z[1, i], z[0, i]) if A > 0.0 else np.arctan2(z[5, i], z[4, i])
    gamma = np.arctan2(z[3, i], z[2, i]) if B > 0.0 else np.arctan2(z[7, i], z[6, i])
    theta[0, i] = _wrap(chi_r / TURN)
    theta[1, i] = _wrap(tilt)
    theta[2, i] = _wrap((eta - turn_a * (_wind(product_t, t2, width, cosine, root) - np.pi * tilt)) / TURN)
    theta[3, i] = _wrap((gamma - turn_b * (_wind(product_s, s2, width, cosine, root) - np.pi * tilt)) / TURN)
    if width_r == 0.0 or bent:
        theta[0, i] = np.nan if width_r == 0.0 else theta[0, i]
        theta[1, i] = np.nan if bent else theta[1, i]
        code = ACTION_ZERO_CODE if code == OK_CODE else code
    return code


def shells(unit, stop, progress, mu, k, wall_r, wall_a, wall_b, tori):
    """Fill the tori: rows r, vartheta, eta, gamma of J, nu, theta; constants E, h_vartheta, c_eta, c_gamma."""
    _, J, nu, theta, turning, _, error, status = tori
    if stop[0] != 0:
        return
    for i in range(unit * UNIT, min(status.size, (unit + 1) * UNIT)):
        status[i] = _shell(mu, k, wall_r, wall_a, wall_b, tori, i)
        error[i] = 1e-16
        if status[i] == UNBOUND_CODE:
            error[i] = np.inf
            turning[:, :, i] = np.nan
            for m in range(4):
                J[m, i] = np.nan
                nu[m, i] = np.nan
                theta[m, i] = np.nan
    progress[unit] = 1
