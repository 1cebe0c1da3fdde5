"""A pendulum and rigid bodies about a fixed point."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....core.numbers import positive, real
from .system import NamedSystem, chosen, makes, of_angles


def _of_azimuths(model: Any, z: np.ndarray) -> dict[str, Any]:
    """Return the energy and the momenta of all angles but theta."""
    return {name: row for name, row in of_angles(model, z).items() if name != "p_theta"}


PENDULUM = NamedSystem(
    "(p_theta**2 + p_phi**2/sin(theta)**2)/(2*m*l**2) - m*g*l*cos(theta)",
    "theta phi",
    "p_theta p_phi",
    "theta phi",
    _of_azimuths,
)


@makes(PENDULUM)
def SphericalPendulum(m: float = 1.0, l: float = 1.0, g: float = 1.0) -> Any:
    """Make a spherical pendulum.

    Parameters
    ----------
    m : float, mass, default 1
        Mass, positive.
    l : float, length, default 1
        Length, positive.
    g : float, acceleration, default 1
        Gravity, positive.

    Returns
    -------
    model
        Model of `hamiltonian` with the fields m, l, g. Its rows are theta, phi, p_theta, p_phi: the angle from straight
        down and the azimuth, in radians.

    Raises
    ------
    TypeError
        If a parameter is not a number.
    ValueError
        If a parameter is not positive.

    Notes
    -----
    * Hamiltonian: ``H = (p_theta^2 + p_phi^2/sin(theta)^2)/(2 m l^2) - m g l cos theta``.
    * Conserved (`constants_of_motion`): energy and p_phi.
    * The chart is singular at the poles, which orbits with p_phi other than 0 do not reach.

    References
    ----------
    Landau & Lifshitz, Mechanics, section 14, problem 1; Cushman & Bates 2015, Global Aspects of Classical Integrable
    Systems, chapter IV.

    Examples
    --------
    >>> pendulum = fa.models.SphericalPendulum()
    >>> round(float(pendulum.energy(np.pi / 2, 0.0, 0.0, 1.0)), 12)
    0.5
    """
    return PENDULUM.made({"m": positive("m", m), "l": positive("l", l), "g": positive("g", g)})


SYMMETRIC = NamedSystem(
    "p_theta**2/(2*I_1) + (p_phi - p_psi*cos(theta))**2/(2*I_1*sin(theta)**2) + p_psi**2/(2*I_3) + h*cos(theta)",
    "theta phi psi",
    "p_theta p_phi p_psi",
    "theta phi psi",
    _of_azimuths,
)


@makes(SYMMETRIC)
def SymmetricTop(I_1: float = 1.0, I_3: float = 0.5, h: float = 1.0) -> Any:
    """Make a heavy symmetric top with a fixed point on its axis (Lagrange's).

    Parameters
    ----------
    I_1 : float, moment of inertia, default 1
        Moment across the axis, at the fixed point, positive.
    I_3 : float, moment of inertia, default 0.5
        Moment along the axis, positive.
    h : float, energy, default 1
        Weight times the distance of the centre of mass from the fixed point, along the axis.

    Returns
    -------
    model
        Model of `hamiltonian` with the fields I_1, I_3, h. Its rows are Euler's angles theta (from straight up), phi,
        psi, in radians, and their momenta.

    Raises
    ------
    TypeError
        If a parameter is not a number.
    ValueError
        If a moment of inertia is not positive.

    Notes
    -----
    * Hamiltonian: ``H = p_theta^2/(2 I_1) + (p_phi - p_psi cos theta)^2/(2 I_1 sin(theta)^2) + p_psi^2/(2 I_3) + h cos
      theta``.
    * Conserved (`constants_of_motion`): energy, p_phi, p_psi.
    * The chart is singular at theta = 0 and pi.

    References
    ----------
    Landau & Lifshitz, Mechanics, section 35, problem 1; Whittaker 1937, Analytical Dynamics, section 71.

    Examples
    --------
    >>> top = fa.models.SymmetricTop(I_1=1.0, I_3=0.5, h=1.0)
    >>> constants = fa.constants_of_motion(top, [1.0, 0.0, 0.0, 0.0, 1.0, 2.0])
    >>> list(constants)
    ['energy', 'p_phi', 'p_psi']
    """
    return SYMMETRIC.made({"I_1": positive("I_1", I_1), "I_3": positive("I_3", I_3), "h": real("h", h)})


def _of_euler(model: Any, z: np.ndarray) -> dict[str, Any]:
    theta, _, psi, p_theta, p_phi, p_psi = z
    s = np.sin(theta)
    c = np.cos(theta)
    sp = np.sin(psi)
    cp = np.cos(psi)
    k = (p_phi - p_psi * c) / s
    L = np.array([k * sp + p_theta * cp, k * cp - p_theta * sp, p_psi])
    up = np.array([s * sp, s * cp, c])
    return _of_top(model, {"energy": model.energy(*z), "p_phi": p_phi}, L, up)


def _of_quaternion(model: Any, z: np.ndarray) -> dict[str, Any]:
    a, b, c, d, A, B, C, D = z
    q2 = (z[:4] ** 2).sum(axis=0)
    up = np.array([2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d])
    L = np.array([a * B - b * A + d * C - c * D, a * C - c * A + b * D - d * B, a * D - d * A + c * B - b * C]) / 2
    p_phi = (a * D - d * A + b * C - c * B) / 2
    found = _of_top(model, {"energy": model.energy(*z), "p_phi": p_phi}, L, up / q2)
    return {**found, "q2": q2, "qp": (z[:4] * z[4:]).sum(axis=0)}


def _of_top(model: Any, found: dict[str, Any], L: np.ndarray, up: np.ndarray) -> dict[str, Any]:
    """Return `found` with the integrals that the parameters add; L, up: angular momentum and vertical in the body."""
    moments = np.array([model.I_1, model.I_2, model.I_3])
    h = np.array([model.h_1, model.h_2, model.h_3])
    w = (L[0] + 1j * L[1]) / moments[0]
    across = complex(h[0], h[1])
    J = moments[2]
    if not h.any():
        found["L2"] = (L * L).sum(axis=0)
    if moments[0] == moments[1] and across == 0:
        found["p_psi"] = L[2]
    if moments[0] == moments[1] == 2 * J and h[2] == 0:
        found["kovalevskaya"] = np.abs(w * w - across / J * (up[0] + 1j * up[1])) ** 2
    if moments[0] == moments[1] == 4 * J and h[2] == 0:
        found["goryachev_chaplygin"] = L[2] / J * np.abs(w) ** 2 - (np.conj(across) * w).real * up[2] / J
    return found


_K = "(p_phi - p_psi*cos(theta))/sin(theta)"
TOP = NamedSystem(
    f"({_K}*sin(psi) + p_theta*cos(psi))**2/(2*I_1) + ({_K}*cos(psi) - p_theta*sin(psi))**2/(2*I_2) + p_psi**2/(2*I_3)"
    " + (h_1*sin(psi) + h_2*cos(psi))*sin(theta) + h_3*cos(theta)",
    "theta phi psi",
    "p_theta p_phi p_psi",
    "theta phi psi",
    _of_euler,
)
QUATERNION = NamedSystem(
    "((q0*p1 - q1*p0 + q3*p2 - q2*p3)**2/I_1 + (q0*p2 - q2*p0 + q1*p3 - q3*p1)**2/I_2"
    " + (q0*p3 - q3*p0 + q2*p1 - q1*p2)**2/I_3)/8 + (2*h_1*(q1*q3 - q0*q2) + 2*h_2*(q2*q3 + q0*q1)"
    " + h_3*(q0**2 - q1**2 - q2**2 + q3**2))/(q0**2 + q1**2 + q2**2 + q3**2)",
    "q0 q1 q2 q3",
    "p0 p1 p2 p3",
    "",
    _of_quaternion,
)


@makes(TOP, QUATERNION)
def AsymmetricTop(
    I_1: float = 1.0,
    I_2: float = 2.0,
    I_3: float = 3.0,
    h_1: float = 0.0,
    h_2: float = 0.0,
    h_3: float = 0.0,
    *,
    chart: str = "euler",
) -> Any:
    """Make a rigid body about a fixed point, with any centre of mass.

    Parameters
    ----------
    I_1, I_2, I_3 : float, moment of inertia, default 1, 2 and 3
        Principal moments at the fixed point, positive.
    h_1, h_2, h_3 : float, energy, default 0
        Weight times the position of the centre of mass, along the principal axes. Zeros are Euler's free top.
    chart : {"euler", "quaternion"}, default "euler"
        Coordinates of the body.

        * "euler": Euler's angles theta, phi, psi (z-x-z) in radians, singular at theta = 0 and pi. ``up = (sin theta
          sin psi, sin theta cos psi, cos theta)``.
        * "quaternion": q0, ..., q3, which rotates the axes of the body into those of space. It has no singular points.
          ``p = 2 q L``, and ``q2 = q . q`` and ``qp = q . p`` are conserved too.

    Returns
    -------
    model
        Model of `hamiltonian` with the fields I_1 to h_3. Its rows are the coordinates of the chart and their momenta.

    Raises
    ------
    TypeError
        If a parameter is not a number or `chart` is not a text.
    ValueError
        If a moment of inertia is not positive, or if `chart` is another text.

    Notes
    -----
    * Hamiltonian: ``H = L_1^2/(2 I_1) + L_2^2/(2 I_2) + L_3^2/(2 I_3) + h . up``, with the angular momentum L and the
      vertical along the principal axes.
    * Euler's angles: ``L_1 = k sin psi + p_theta cos psi``, ``L_2 = k cos psi - p_theta sin psi``, ``L_3 = p_psi``, ``k
      = (p_phi - p_psi cos theta)/sin theta``.
    * Conserved (`constants_of_motion`): energy, p_phi; L2 (h = 0); p_psi (I_1 = I_2, h_1 = h_2 = 0); Kovalevskaya's
      integral (I_1 = I_2 = 2 I_3, h_3 = 0); Goryachev-Chaplygin's (I_1 = I_2 = 4 I_3, h_3 = 0, p_phi = 0 only).

    References
    ----------
    Whittaker 1937, Analytical Dynamics, chapter VI; Kovalevskaya 1889, Acta Math. 12, 177; Borisov & Mamaev 2018, Rigid
    Body Dynamics.

    Examples
    --------
    >>> top = fa.models.AsymmetricTop(2.0, 2.0, 1.0, h_1=1.0)
    >>> constants = fa.constants_of_motion(top, [1.0, 0.0, 0.5, 0.2, 1.0, 0.3])
    >>> list(constants)
    ['energy', 'p_phi', 'kovalevskaya']
    """
    system = {"euler": TOP, "quaternion": QUATERNION}[chosen("chart", chart, ("euler", "quaternion"))]
    moments = {"I_1": positive("I_1", I_1), "I_2": positive("I_2", I_2), "I_3": positive("I_3", I_3)}
    weights = {"h_1": real("h_1", h_1), "h_2": real("h_2", h_2), "h_3": real("h_3", h_3)}
    return system.made(moments | weights)
