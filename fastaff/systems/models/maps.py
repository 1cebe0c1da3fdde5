"""Maps as models: the standard map, Henon's, Froeschle's, an accelerator's, and an integrable one.

A map is a NamedTuple of float parameters with plain methods: iterate(q..., p...), 2n numbers of 2n, and
tangent_iterate(q..., p..., dq..., dp...), the derivative of it applied to a vector; periods(), 2n numbers: the period
of each coordinate and momentum that has one, else 0; margin(q...), positive in its domain. Its time is the number of
iterates, its exponents and tunes are per iterate. `fastaff.iterated_map` makes one from a text.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...engine.values import at_points
from .contracts import Kind

TURN = 2 * np.pi


def _map(coordinates: str, momenta: str) -> Any:
    """Return a decorator that gives a class of maps its kind and the names of its rows."""

    def named(cls: Any) -> Any:
        cls.kind = Kind.MAP
        cls.coordinates = tuple(coordinates.split())
        cls.momenta = tuple(momenta.split())
        return cls

    return named


@_map("x", "p")
class StandardMap(NamedTuple):
    """Define the standard map.

    Parameters
    ----------
    K : float, default 0.971635406
        Strength of the kicks. At the default the last rotational invariant curve, of the golden mean, breaks.

    Notes
    -----
    The map is ``p' = p + K sin x, x' = x + p'``. The coordinate x is an angle.

    References
    ----------
    Chirikov 1979, Phys. Rep. 52, 263; Greene 1979, J. Math. Phys. 20, 1183.

    Examples
    --------
    >>> fa.models.StandardMap(0.9).iterate(0.0, 0.5)
    (np.float64(0.5), np.float64(0.5))
    """

    K: float = 0.971635406

    @property
    def degrees_of_freedom(self) -> int:
        """Return 1."""
        return 1

    def periods(self):
        """Return the periods of the rows.

        Returns
        -------
        tuple of float
            Periods 2 pi of x and 0 of p, which is not periodic.
        """
        return TURN, 0.0

    def iterate(self, x, p):
        """Return the image of a point.

        Parameters
        ----------
        x, p : float or array_like
            Angle in radians, and momentum.

        Returns
        -------
        tuple of float or ndarray
            Image of the rows, in their order.
        """
        p1 = p + self.K * np.sin(x)
        return x + p1, p1

    def tangent_iterate(self, x, p, dx, dp):
        """Apply the derivative of the map to a vector.

        Parameters
        ----------
        x, p : float or array_like
            Angle in radians, and momentum.
        dx, dp : float or array_like
            Vector of changes of the rows.

        Returns
        -------
        tuple of float or ndarray
            Image of the vector.
        """
        dp1 = dp + self.K * np.cos(x) * dx
        return dx + dp1, dp1

    def margin(self, x):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        x : float or array_like
            Coordinate.

        Returns
        -------
        float or ndarray
            1: the map is defined everywhere.
        """
        return 1.0 + 0.0 * x


@_map("x", "p")
class HenonMap(NamedTuple):
    """Define the quadratic area-preserving map of Henon.

    Parameters
    ----------
    nu : float, default 0.2114
        Tune at the origin, in turns per iterate.

    Notes
    -----
    A kick x^2 is followed by a rotation by 2 pi nu: ``x' = x cos + (p + x^2) sin, p' = -x sin + (p + x^2) cos``.

    References
    ----------
    Henon 1969, Quart. Appl. Math. 27, 291, whose y is -p.

    Examples
    --------
    >>> orbit = fa.integrate(fa.models.HenonMap(), [0.01, 0.0], time=500, samples=500)
    >>> orbit.samples.shape, fa.tunes(orbit).nu.round(4)
    ((500, 2, 1), array([[0.2114]]))
    """

    nu: float = 0.2114

    @property
    def degrees_of_freedom(self) -> int:
        """Return 1."""
        return 1

    def periods(self):
        """Return the periods of the rows.

        Returns
        -------
        tuple of float
            Zeros: no row is periodic.
        """
        return 0.0, 0.0

    def iterate(self, x, p):
        """Return the image of a point.

        Parameters
        ----------
        x, p : float or array_like
            Coordinate and momentum.

        Returns
        -------
        tuple of float or ndarray
            Image of the rows, in their order.
        """
        c = np.cos(TURN * self.nu)
        s = np.sin(TURN * self.nu)
        kick = p + x * x
        return c * x + s * kick, c * kick - s * x

    def tangent_iterate(self, x, p, dx, dp):
        """Apply the derivative of the map to a vector.

        Parameters
        ----------
        x, p : float or array_like
            Coordinate and momentum.
        dx, dp : float or array_like
            Vector of changes of the rows.

        Returns
        -------
        tuple of float or ndarray
            Image of the vector.
        """
        c = np.cos(TURN * self.nu)
        s = np.sin(TURN * self.nu)
        kick = dp + 2 * x * dx
        return c * dx + s * kick, c * kick - s * dx

    def margin(self, x):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        x : float or array_like
            Coordinate.

        Returns
        -------
        float or ndarray
            1: the map is defined everywhere.
        """
        return 1.0 + 0.0 * x


@_map("x", "p")
class McMillanMap(NamedTuple):
    """Define the integrable map of McMillan.

    Parameters
    ----------
    m : float, default 1.6
        Strength of the kick.

    Notes
    -----
    The map is ``x' = p, p' = -x + 2 m p/(1 + p^2)``. It conserves x^2 p^2 + x^2 + p^2 - 2 m x p, so it has no chaotic
    orbit.

    References
    ----------
    McMillan 1971, in Topics in Modern Physics, Brittin & Odabasi (eds.), 219.

    Examples
    --------
    >>> fa.models.McMillanMap().iterate(0.5, 0.0)
    (0.0, -0.5)
    """

    m: float = 1.6

    @property
    def degrees_of_freedom(self) -> int:
        """Return 1."""
        return 1

    def periods(self):
        """Return the periods of the rows.

        Returns
        -------
        tuple of float
            Zeros: no row is periodic.
        """
        return 0.0, 0.0

    def iterate(self, x, p):
        """Return the image of a point.

        Parameters
        ----------
        x, p : float or array_like
            Coordinate and momentum.

        Returns
        -------
        tuple of float or ndarray
            Image of the rows, in their order.
        """
        return p, 2 * self.m * p / (1 + p * p) - x

    def tangent_iterate(self, x, p, dx, dp):
        """Apply the derivative of the map to a vector.

        Parameters
        ----------
        x, p : float or array_like
            Coordinate and momentum.
        dx, dp : float or array_like
            Vector of changes of the rows.

        Returns
        -------
        tuple of float or ndarray
            Image of the vector.
        """
        w = 1 / (1 + p * p)
        return dp, 2 * self.m * (1 - p * p) * w * w * dp - dx

    def margin(self, x):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        x : float or array_like
            Coordinate.

        Returns
        -------
        float or ndarray
            1: the map is defined everywhere.
        """
        return 1.0 + 0.0 * x


@_map("x_1 x_2", "p_1 p_2")
class FroeschleMap(NamedTuple):
    """Define two coupled standard maps.

    Parameters
    ----------
    K_1 : float, default 0.5
        Strength of the kicks of the first map.
    K_2 : float, default 0.3
        Strength of the kicks of the second map.
    b : float, default 0.02
        Strength of the coupling.

    Notes
    -----
    The map is ``p_1' = p_1 + K_1 sin x_1 + b sin(x_1 + x_2)``, p_2' likewise, and x' = x + p'. The coordinates are
    angles.

    References
    ----------
    Froeschle 1972, Astron. Astrophys. 16, 172.

    Examples
    --------
    >>> np.round(fa.models.FroeschleMap().iterate(np.pi, np.pi, 0.0, 0.0), 6) + 0.0
    array([3.141593, 3.141593, 0.      , 0.      ])
    """

    K_1: float = 0.5
    K_2: float = 0.3
    b: float = 0.02

    @property
    def degrees_of_freedom(self) -> int:
        """Return 2."""
        return 2

    def periods(self):
        """Return the periods of the rows.

        Returns
        -------
        tuple of float
            Periods 2 pi of both angles and 0 of the momenta.
        """
        return TURN, TURN, 0.0, 0.0

    def iterate(self, x_1, x_2, p_1, p_2):
        """Return the image of a point.

        Parameters
        ----------
        x_1, x_2, p_1, p_2 : float or array_like
            Angles in radians, then their momenta.

        Returns
        -------
        tuple of float or ndarray
            Image of the rows, in their order.
        """
        both = self.b * np.sin(x_1 + x_2)
        a = p_1 + self.K_1 * np.sin(x_1) + both
        c = p_2 + self.K_2 * np.sin(x_2) + both
        return x_1 + a, x_2 + c, a, c

    def tangent_iterate(self, x_1, x_2, p_1, p_2, dx_1, dx_2, dp_1, dp_2):
        """Apply the derivative of the map to a vector.

        Parameters
        ----------
        x_1, x_2, p_1, p_2 : float or array_like
            Angles in radians, then their momenta.
        dx_1, dx_2, dp_1, dp_2 : float or array_like
            Vector of changes of the rows.

        Returns
        -------
        tuple of float or ndarray
            Image of the vector.
        """
        both = self.b * np.cos(x_1 + x_2) * (dx_1 + dx_2)
        a = dp_1 + self.K_1 * np.cos(x_1) * dx_1 + both
        c = dp_2 + self.K_2 * np.cos(x_2) * dx_2 + both
        return dx_1 + a, dx_2 + c, a, c

    def margin(self, x_1, x_2):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        x_1, x_2 : float or array_like
            Coordinates.

        Returns
        -------
        float or ndarray
            1: the map is defined everywhere.
        """
        return 1.0 + 0.0 * (x_1 + x_2)


@_map("x y", "p_x p_y")
class OneTurnMap(NamedTuple):
    """Define the one-turn map of a lattice with a sextupole and an octupole.

    Parameters
    ----------
    nu_x : float, default 0.28
        Horizontal tune at the origin, in turns per iterate.
    nu_y : float, default 0.31
        Vertical tune at the origin, in turns per iterate.
    octupole : float, default 0
        Strength k of the octupole.
    aperture : float, length, default 1e3
        A particle is lost if x^2 + y^2 reaches aperture^2.

    Notes
    -----
    The lattice is linear apart from one thin kick: ``p_x += x^2 - y^2 + k (x^3 - 3 x y^2)`` and ``p_y += -2 x y + k
    (y^3 - 3 x^2 y)``. Rotations by 2 pi nu_x and 2 pi nu_y of the normalised coordinates follow. The map is the
    four-dimensional Henon map.

    References
    ----------
    Bazzani, Servizi, Todesco & Turchetti 1994, CERN 94-02; Todesco & Giovannozzi 1996, Phys. Rev. E 53, 4067.

    Examples
    --------
    >>> orbit = fa.integrate(fa.models.OneTurnMap(), [0.01, 0.01, 0.0, 0.0], time=500, samples=500)
    >>> fa.tunes(orbit).nu[:, 0].round(3)
    array([0.28, 0.31])
    """

    nu_x: float = 0.28
    nu_y: float = 0.31
    octupole: float = 0.0
    aperture: float = 1e3

    @property
    def degrees_of_freedom(self) -> int:
        """Return 2."""
        return 2

    def periods(self):
        """Return the periods of the rows.

        Returns
        -------
        tuple of float
            Zeros: no row is periodic.
        """
        return 0.0, 0.0, 0.0, 0.0

    def iterate(self, x, y, p_x, p_y):
        """Return the image of a point.

        Parameters
        ----------
        x, y, p_x, p_y : float or array_like
            Normalised coordinates, then their momenta.

        Returns
        -------
        tuple of float or ndarray
            Image of the rows, in their order.
        """
        cx = np.cos(TURN * self.nu_x)
        sx = np.sin(TURN * self.nu_x)
        cy = np.cos(TURN * self.nu_y)
        sy = np.sin(TURN * self.nu_y)
        xx = x * x
        yy = y * y
        k = self.octupole
        a = p_x + xx - yy + k * x * (xx - 3 * yy)
        b = p_y - 2 * x * y + k * y * (yy - 3 * xx)
        return cx * x + sx * a, cy * y + sy * b, cx * a - sx * x, cy * b - sy * y

    def tangent_iterate(self, x, y, p_x, p_y, dx, dy, dp_x, dp_y):
        """Apply the derivative of the map to a vector.

        Parameters
        ----------
        x, y, p_x, p_y : float or array_like
            Normalised coordinates, then their momenta.
        dx, dy, dp_x, dp_y : float or array_like
            Vector of changes of the rows.

        Returns
        -------
        tuple of float or ndarray
            Image of the vector.
        """
        cx = np.cos(TURN * self.nu_x)
        sx = np.sin(TURN * self.nu_x)
        cy = np.cos(TURN * self.nu_y)
        sy = np.sin(TURN * self.nu_y)
        k = 3 * self.octupole
        even = 2 * x + k * (x * x - y * y)
        odd = 2 * y + 2 * k * x * y
        a = dp_x + even * dx - odd * dy
        b = dp_y - odd * dx - even * dy
        return cx * dx + sx * a, cy * dy + sy * b, cx * a - sx * dx, cy * b - sy * dy

    def margin(self, x, y):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        x, y : float or array_like
            Coordinates.

        Returns
        -------
        float or ndarray
            Number aperture^2 - x^2 - y^2.
        """
        return self.aperture * self.aperture - x * x - y * y


def jacobian(model: Any, z: np.ndarray) -> np.ndarray:
    """Return the derivatives (2n, 2n, ...) of a map at phase points z (2n, ...): column k is that by row k."""
    rows = len(z)
    result = np.empty((rows, rows, *z.shape[1:]))
    with np.errstate(all="ignore"):
        for k, unit in enumerate(np.eye(rows)):
            image = at_points(model, "tangent_iterate", *z, *(unit[r] + 0.0 * z[r] for r in range(rows)))
            for r, number in enumerate(image):
                result[r, k] = number
    return result


def symplectic_defect(model: Any, z: Any) -> np.ndarray:
    """Return the largest entry of |M^T J M - J| (...) of a map at phase points z (2n, ...), M its derivative, J the
    symplectic unit matrix, over the largest of |M|^2: rounding where the map is symplectic.
    """
    points = np.asarray(z, dtype=np.float64)
    n = len(points) // 2
    M = np.moveaxis(jacobian(model, points), (0, 1), (-2, -1))
    J = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    with np.errstate(all="ignore"):  # M overflows at points far away
        size = np.maximum(np.abs(M).max(axis=(-2, -1)) ** 2, 1.0)
        return np.abs(np.swapaxes(M, -2, -1) @ J @ M - J).max(axis=(-2, -1)) / size


def symplectic(model: Any) -> bool:
    """Tell whether a map is symplectic, to rounding, at points around the origin and farther away; one of one variable
    is not.
    """
    if getattr(model, "momenta", None) == ():
        return False
    rng = np.random.default_rng(3)
    z = rng.standard_normal((2 * model.degrees_of_freedom, 96)) * 10.0 ** rng.uniform(-2, 0.5, 96)
    defect = symplectic_defect(model, z)
    known = np.isfinite(defect)
    return bool(known.any() and (defect[known] < 1e-11).all())
