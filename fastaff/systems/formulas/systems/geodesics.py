"""Geodesics: of an ellipsoid, and of massive particles around a black hole."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....core.numbers import positive, real, shown
from .system import NamedSystem, chosen, makes


def _of_ellipsoid(model: Any, z: np.ndarray) -> dict[str, Any]:
    squares = np.array([[model.a**2], [model.b**2], [model.c**2]])
    v = np.array(model.rates(*z)[:3])
    joachimsthal = (z[:3] ** 2 / squares**2).sum(axis=0) * (v**2 / squares).sum(axis=0)
    size = (z[:3] ** 2 / squares).sum(axis=0)
    qp = (z[:3] * z[3:]).sum(axis=0)
    return {"energy": model.energy(*z), "joachimsthal": joachimsthal, "size": size, "qp": qp}


ELLIPSOID = NamedSystem(
    # Few quotients of the semiaxes, the same in all derivatives: their rounding makes no drift of conserved quantities.
    "(x**2/a**2 + y**2/b**2 + z**2/c**2)*((y/b**2*p_z - z/c**2*p_y)**2 + (z/c**2*p_x - x/a**2*p_z)**2"
    " + (x/a**2*p_y - y/b**2*p_x)**2)/(2*(x**2/a**4 + y**2/b**4 + z**2/c**4))",
    "x y z",
    "p_x p_y p_z",
    "",
    _of_ellipsoid,
)


@makes(ELLIPSOID)
def EllipsoidGeodesic(a: float = 1.0, b: float = 1.2, c: float = 1.5) -> Any:
    """Make the geodesic flow on the ellipsoid x^2/a^2 + y^2/b^2 + z^2/c^2 = 1.

    Parameters
    ----------
    a, b, c : float, length, default 1, 1.2 and 1.5
        Semiaxes, positive, in any order. Two or three may be equal.

    Returns
    -------
    model
        Model of `hamiltonian` with the semiaxes as fields. Its rows are the Cartesian coordinates x, y, z, then p_x,
        p_y, p_z. It has no singular points.

    Raises
    ------
    TypeError
        If a semiaxis is not a number.
    ValueError
        If a semiaxis is not positive.

    Notes
    -----
    * Hamiltonian: ``H = s |n x p|^2/(2 |n|^2)`` with the normal n = (x/a^2, y/b^2, z/c^2) and the conserved s = x^2/a^2
      + y^2/b^2 + z^2/c^2.
    * Initial conditions: points of the surface, s = 1, with the velocity, a tangent vector, for p.
    * Velocities: the method rates returns them. p differs from the velocity by a vector along the normal, of which H is
      independent.
    * Conserved (`constants_of_motion`): energy, Joachimsthal's integral (x^2/a^4 + ...)(x'^2/a^2 + ...), size = s, qp =
      x . p.
    * Accuracy: over 10^4 turns the first two change by less than 1e-12 if the scheme's own error is smaller.

    References
    ----------
    Jacobi 1839, J. reine angew. Math. 19, 309; Klingenberg 1995, Riemannian Geometry, section 3.5.

    Examples
    --------
    >>> surface = fa.models.EllipsoidGeodesic(1.0, 1.2, 1.5)
    >>> round(float(surface.energy(1.0, 0.0, 0.0, 0.0, 0.6, 0.8)), 12)
    0.5
    """
    return ELLIPSOID.made({"a": positive("a", a), "b": positive("b", b), "c": positive("c", c)})


def _of_kerr(model: Any, z: np.ndarray) -> dict[str, Any]:
    (*_, theta, _), (*_, p_theta, p_phi) = np.split(z, 2)
    first = {"energy": -z[4], "mass_shell": model.energy(*z)} if len(z) == 8 else {"energy": model.energy(*z)}
    E = first["energy"]
    c2 = np.cos(theta) ** 2
    s2 = np.sin(theta) ** 2
    carter = p_theta**2 + c2 * (model.a**2 * (1 - E * E) + p_phi**2 / s2)
    return {**first, "p_phi": p_phi, "carter": carter}


_DELTA = "(r**2 - 2*r + a**2)"
_SIGMA = "(r**2 + a**2*cos(theta)**2)"
_AREA = f"((r**2 + a**2)**2 - a**2*{_DELTA}*sin(theta)**2)"
KERR = NamedSystem(
    f"2*a*r*p_phi/{_AREA} + sqrt({_SIGMA}*{_DELTA}/{_AREA}"
    f"*(1 + ({_DELTA}*p_r**2 + p_theta**2)/{_SIGMA} + {_SIGMA}*p_phi**2/({_AREA}*sin(theta)**2)))",
    "r theta phi",
    "p_r p_theta p_phi",
    "theta phi",
    _of_kerr,
)
MINO = NamedSystem(
    f"({_DELTA}*p_r**2 - ((r**2 + a**2)*p_t + a*p_phi)**2/{_DELTA} + p_theta**2"
    " + (p_phi/sin(theta) + a*p_t*sin(theta))**2 + r**2 + a**2*cos(theta)**2)/2",
    "t r theta phi",
    "p_t p_r p_theta p_phi",
    "theta phi",
    _of_kerr,
)


@makes(KERR, MINO)
def KerrGeodesic(a: float = 0.5, *, time: str = "coordinate") -> Any:
    """Make the geodesics of massive particles around a rotating black hole.

    The coordinates are those of Boyer and Lindquist. Units: G = c = 1, the mass of the hole is 1, the mass of the
    particle is 1.

    Parameters
    ----------
    a : float, default 0.5
        Spin of the hole, -1 < a < 1. Orbits with p_phi < 0 are retrograde for a > 0.
    time : {"coordinate", "mino"}, default "coordinate"
        Independent variable.

        * "coordinate": H(r, theta, phi, p_r, p_theta, p_phi) = -p_t, the energy E that solves g^(mu nu) p_mu p_nu = -1.
        * "mino": Mino's time lambda, d tau = Sigma d lambda, with H = Sigma (g^(mu nu) p_mu p_nu + 1)/2 of t, r, theta,
          phi and their momenta. It separates. Orbits have H = 0.

    Returns
    -------
    model
        Model of `hamiltonian` with the field a, outside the horizon. The margin is r less the radius of the horizon.
        Orbits that fall in get the status OUT_OF_DOMAIN.

    Raises
    ------
    TypeError
        If `a` is not a number or `time` is not a text.
    ValueError
        If `a` is not between -1 and 1, or `time` is another text.

    Notes
    -----
    * Conserved (`constants_of_motion`): E, p_phi and Carter's Q = p_theta^2 + cos(theta)^2 (a^2 (1 - E^2) +
      p_phi^2/sin(theta)^2).
    * Frequencies: in Mino's time the mean rates are Upsilon_r, Upsilon_theta, Upsilon_phi and, for t, Gamma. In
      coordinate time they are Upsilon/Gamma.
    * Basis: `frequency_map` returns these frequencies or another basis. For eccentricities above 0.5 the dominant line
      of theta is Upsilon_theta - Upsilon_r.
    * Equatorial orbits have theta = pi/2, p_theta = 0. The chart is singular on the axis, theta = 0 and pi.

    References
    ----------
    Carter 1968, Phys. Rev. 174, 1559; Mino 2003, Phys. Rev. D 67, 084027; Schmidt 2002, Class. Quantum Grav. 19, 2743;
    Fujita & Hikida 2009, Class. Quantum Grav. 26, 135002.

    Examples
    --------
    >>> hole = fa.models.KerrGeodesic(0.9)
    >>> round(float(hole.energy(10.0, np.pi / 2, 0.0, 0.0, 2.0, 3.0)), 12)
    0.955963194159
    """
    system = {"coordinate": KERR, "mino": MINO}[chosen("time", time, ("coordinate", "mino"))]
    if not -1 < real("a", a) < 1:
        raise ValueError(f"a must be between -1 and 1, got {shown(a)}")
    return system.made({"a": float(a)}, domain="r - 1 - sqrt(1 - a**2)")
