"""Steady motions of the body in space: ellipsoids of constant shape that rotate, with a steady circulation inside.

phi(t) = exp(W t) D exp(-U t) with antisymmetric W (rotation of the axes in space) and U (circulation in the body) is a
motion if mu (W^2 D - 2 W D U + D U^2) + grad V(D) = 0. For rotation and circulation about the third axis (type S of
Riemann) this is three equations: with w and u about that axis, mu (w - u)^2 = (V_1 + V_2)/(D1 + D2), mu (w + u)^2 =
(V_1 - V_2)/(D1 - D2), V_3 = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import Array, checked
from ...core.numbers import positive, shown
from .body3 import Body3
from .matrix_potentials import NEAR, NODES

STEADY = 1e-12
"""Largest residual of a steady motion, relative to the forces in it, or to those of a deformation as large as the body.
At rest no force is left, and round-off is that of the second.
"""

AT_REST = 1e-14
"""Squared rates below this part of the largest squared frequency of the first two axes are round-off: 0. The spheres at
rest of 300 random stars have up to 6.4e-16.
"""

STEPS = 200
"""Most steps of a search. Most searches take 5 to 20."""

HALVINGS = 20
"""Most halvings of a step that does not lessen the residual."""

FLAT = 1e-8
"""Singular values of the equations below this part of the largest belong to directions along a family."""

GROWTH = 1e-5
"""Growth rate, relative to the fastest frequency, that counts as unstable. Conserved spin and vorticity make double
eigenvalues 0, which round-off moves by its root: up to 3e-8 for random steady motions.
"""

LARGEST = 1e30
"""Largest stretch or rate of a guess: beyond it the equations overflow."""

SIZES = (np.geomspace(1e-3, 1e3, 121), np.geomspace(1e-15, 1e15, 601))
"""Sizes of an ellipsoid among which its equilibrium is sought, relative to the undeformed body; the second ones if the
first have none.
"""

FLATTEST = 1e-3
"""Least ratio of axes among which an ellipsoid that rotates rigidly is sought."""


class RelativeEquilibrium(NamedTuple):
    """Hold a steady motion of the body in space.

    Parameters
    ----------
    model : Body3
        Body in space.
    D : ndarray, shape (3,)
        Stretches.
    omega : ndarray, shape (3,), radians per unit time
        Angular velocity of the principal axes in space, by its components along these axes.
    circulation : ndarray, shape (3,), radians per unit time
        Rate of the circulation in the body, by its components along the principal axes.
    z0 : ndarray, shape (18,)
        Phase point with the principal axes along x, y, z.
    energy : float
        Total energy.
    exponents : ndarray, shape (18,), complex
        Exponents of small deviations exp(s t) in the principal axes.

    Notes
    -----
    A rigid rotation has no circulation. A Dedekind ellipsoid has constant axes in space, omega = 0.

    References
    ----------
    Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, chapter 7.

    Examples
    --------
    >>> star = fa.models.Sum3(fa.models.SelfGravity(), fa.models.GasCloud(k=0.1, gamma=2.0, C=0.0))
    >>> fa.models.riemann_ellipsoid(fa.models.Body3(star), 1.0, 0.8).stable
    True
    """

    model: Body3
    D: Array
    omega: Array
    circulation: Array
    z0: Array
    energy: float
    exponents: Array

    @property
    def growth(self) -> float:
        """Largest growth rate of small deviations, per unit time."""
        return float(self.exponents.real.max())

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially, to 1e-5 of the fastest frequency."""
        return bool(self.growth <= GROWTH * np.abs(self.exponents).max())

    @property
    def adjoint(self) -> RelativeEquilibrium:
        """The steady motion of the transposed phi: rotation and circulation are exchanged (Dedekind's theorem)."""
        return _found(self.model, self.D, self.circulation, self.omega)


def riemann_ellipsoid(model: Body3, a2: float, a3: float | None = None) -> RelativeEquilibrium:
    """Find the steady ellipsoid of given axes that rotates and circulates about its third axis (Riemann's type S).

    Parameters
    ----------
    model : Body3
        Body in space whose potential determines a size, such as a self-gravitating gas.
    a2, a3 : float
        Ratios of the second and the third axis to the first, positive. If a3 is not given, the body rotates rigidly,
        without circulation, as a Jacobi ellipsoid.

    Returns
    -------
    RelativeEquilibrium
        Steady motion with omega >= abs(circulation). Its adjoint exchanges them. If a2 = 1, the spheroid rotates
        rigidly, as a Maclaurin spheroid.

    Raises
    ------
    TypeError
        If `model` is not a `Body3`, or if an axis is not a number.
    ValueError
        If an axis is not positive, a2 = 1 without a3, or if there is no such steady motion.

    Notes
    -----
    * Method: the size solves V_3 = 0 and the rates follow from V_1 and V_2 in closed form.
    * A pressure that depends on the volume alone changes the size, not the shape: the shapes are those of
      incompressible fluids.

    References
    ----------
    Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, sections 32, 39 and 48.

    Examples
    --------
    >>> star = fa.models.Sum3(fa.models.SelfGravity(), fa.models.GasCloud(k=0.1, gamma=2.0, C=0.0))
    >>> jacobi = fa.models.riemann_ellipsoid(fa.models.Body3(star), 0.8)
    >>> round(float(jacobi.D[2] / jacobi.D[0]), 9)
    0.517216059
    """
    _check_body(model)
    a2 = positive("a2", a2)
    if a3 is None:
        a3 = _rigid_axis(model, a2)
    axes = np.array([1.0, a2, positive("a3", a3)])
    size = _size(model, axes)
    if size is None:
        raise ValueError(f"model must have an equilibrium size for the axes {shown(axes.tolist(), 40)}, it has none.")
    D = size * axes
    less, more = (_without_rounding(model, D, square) for square in _rates(model, D))
    if less < 0 or more < 0:
        raise ValueError(f"a2 and a3 must be the axes of a steady ellipsoid, got {a2:g} and {a3:g}.")
    difference, total = np.sqrt(less), np.sqrt(more)
    if a2 == 1.0:  # of a spheroid only the difference of both rates has a meaning
        total = difference
    along = np.array([0.0, 0.0, 1.0])
    return _found(model, D, (total + difference) / 2 * along, (total - difference) / 2 * along)


def relative_equilibrium(
    model: Body3, D: Sequence[float], omega: Sequence[float], circulation: Sequence[float] = (0.0, 0.0, 0.0)
) -> RelativeEquilibrium:
    """Find a steady motion near a guess, with rotation and circulation about any axes.

    Parameters
    ----------
    model : Body3
        Body in space.
    D : sequence of float, length 3
        Guess of the stretches.
    omega, circulation : sequence of float, length 3, radians per unit time
        Guess of the angular velocity of the principal axes and of the rate of circulation, by their components along
        the principal axes.

    Returns
    -------
    RelativeEquilibrium
        Steady motion close to the guess. Steady motions form families of two parameters and more.

    Raises
    ------
    TypeError
        If `model` is not a `Body3`.
    ValueError
        If a guess has another length or is not finite, or if the search does not end at a steady motion.

    Notes
    -----
    * Method: Gauss and Newton's steps of least length for the nine equations in D, omega and circulation, halved until
      the residual decreases.
    * Accuracy: the residual is below 1e-12 of the forces, at rest of those of a deformation as large as the body.

    References
    ----------
    Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, section 47 (the general problem of Riemann).

    Examples
    --------
    >>> star = fa.models.Sum3(fa.models.SelfGravity(), fa.models.GasCloud(k=0.1, gamma=2.0, C=0.0))
    >>> guess = [0.6, 0.8, 0.4], [0.0, 0.9, 0.9], [0.0, 0.5, 0.7]
    >>> tilted = fa.models.relative_equilibrium(fa.models.Body3(star), *guess)
    >>> bool(np.abs(tilted.omega[1:]).min() > 0.1)
    True
    """
    _check_body(model)
    guess = np.concatenate([_three("D", D), _three("omega", omega), _three("circulation", circulation)])
    with np.errstate(all="ignore"):
        inside = guess[:3].min() > 0 and model.potential.stretch_margin(*guess[:3]) > 0
    if not inside:
        raise ValueError(f"D must be positive and inside the domain of the potential, got {shown(D, 40)}.")
    found = _nearby(model, guess)
    if found is None:
        raise ValueError("D, omega and circulation must be near a steady motion. Try another guess.")
    return _found(model, found[:3], found[3:6], found[6:])


def _check_body(model: Any) -> None:
    if not isinstance(model, Body3):
        raise TypeError(f"model must be a Body3, got {shown(model, 40)} ({type(model).__name__}).")
    positive("model.mu", model.mu)


def _three(name: str, given: Any) -> Array:
    """Return three finite numbers."""
    vector = checked(name, given, (3,))
    if vector.ndim > 1:
        raise ValueError(f"{name} must be three numbers, got shape {vector.shape}.")
    if np.abs(vector).max() > LARGEST:
        raise ValueError(f"{name} must be at most {LARGEST:g} in size, got {np.abs(vector).max():g}.")
    return vector


def _cross(w: Array) -> Array:
    """Return the antisymmetric matrix of an angular velocity."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def _residual(model: Body3, D: Array, omega: Array, circulation: Array) -> tuple[Array, float]:
    """Return mu phi'' + grad V of a steady motion in its principal axes, and the size of its terms."""
    W, U = _cross(omega), _cross(circulation)
    shape = np.diag(D)
    inertial = model.mu * (W @ W @ shape - 2 * W @ shape @ U + shape @ U @ U)
    slopes = np.diag(model.potential.stretch_slopes(*D))
    return inertial + slopes, float(np.abs(inertial).max() + np.abs(slopes).max())


def _jacobian(model: Body3, x: Array) -> Array:
    """Return the derivatives (9, 9) of the residual in D, omega and circulation."""
    W, U = _cross(x[3:6]), _cross(x[6:])
    shape = np.diag(x[:3])
    columns = []
    for unit in np.eye(3):
        E = np.diag(unit)
        inertial = model.mu * (W @ W @ E - 2 * W @ E @ U + E @ U @ U)
        columns.append(inertial + np.diag(model.potential.stretch_changes(*x[:3], *unit)))
    turns = [_cross(unit) for unit in np.eye(3)]
    columns += [model.mu * ((G @ W + W @ G) @ shape - 2 * G @ shape @ U) for G in turns]
    columns += [model.mu * (shape @ (G @ U + U @ G) - 2 * W @ shape @ G) for G in turns]
    return np.array([column.ravel() for column in columns]).T


def _nearby(model: Body3, x: Array) -> Array | None:
    """Return D, omega and circulation of a steady motion near x, None where the search does not end at one."""
    with np.errstate(all="ignore"):
        residual, scale = _residual(model, x[:3], x[3:6], x[6:])
        for _ in range(STEPS):
            equations = _jacobian(model, x)
            if not np.isfinite(equations).all():
                return None
            stiffness = np.abs(equations[:, :3] * x[:3]).max()
            if np.abs(residual).max() <= STEADY * max(scale, stiffness):
                return x
            step = np.linalg.lstsq(equations, -residual.ravel(), rcond=FLAT)[0]
            for k in range(HALVINGS):
                moved = x + step / 2**k
                after, size = _residual(model, moved[:3], moved[3:6], moved[6:])
                if moved[:3].min() > 0 and np.linalg.norm(after) < (1 - 0.1 / 2**k) * np.linalg.norm(residual):
                    break
            else:
                return None
            x, residual, scale = moved, after, size
    return None


def _rates(model: Body3, D: Array) -> tuple[float, float]:
    """Return (omega - circulation)^2 and (omega + circulation)^2 of the third axis."""
    V_1, V_2, _ = (float(slope) for slope in model.potential.stretch_slopes(*D))
    less = (V_1 + V_2) / (model.mu * (D[0] + D[1]))
    if D[0] == D[1]:
        return less, abs(less)
    middle, half = (D[0] + D[1]) / 2, (D[0] - D[1]) / 2
    if abs(half) >= NEAR * middle:
        return less, (V_1 - V_2) / (model.mu * 2 * half)
    mean = 0.0  # of the second derivative of V(middle + t, middle - t): nothing cancels
    for node, weight in NODES:
        t = node * half
        one, other, _ = model.potential.stretch_changes(middle + t, middle - t, D[2], 1.0, -1.0, 0.0)
        mean += weight / 2 * float(one - other)
    return less, mean / model.mu


def _without_rounding(model: Body3, D: Array, square: float) -> float:
    """Return a squared rate, 0 where it is of the size of round-off."""
    columns = np.array([model.potential.stretch_changes(*D, *unit) for unit in np.eye(3)[:2]])
    fastest = np.abs(columns[:, :2]).max() / model.mu
    return square if abs(square) > AT_REST * fastest else 0.0


def _size(model: Body3, axes: Array) -> float | None:
    """Return the size of an ellipsoid of these axes without a force along the third."""

    def force(size: Any) -> Any:
        with np.errstate(all="ignore"):
            return model.potential.stretch_slopes(*(size * axis for axis in axes))[2]

    for sizes in SIZES:
        places = sizes / np.cbrt(axes.prod())
        found = _root(force, places, force(places))
        if found is not None:
            return found
    return None


def _rigid_axis(model: Body3, a2: float) -> float:
    """Return the ratio of the third axis of an ellipsoid without circulation."""
    if a2 == 1.0:
        raise ValueError("a3 must be given for a spheroid, a2 = 1, got None.")

    def circulation(a3: float) -> float:
        axes = np.array([1.0, a2, a3])
        size = _size(model, axes)
        if size is None:
            return np.nan
        less, more = _rates(model, size * axes)
        return more - less

    places = np.geomspace(FLATTEST, 1.0, 31) * min(1.0, a2)
    found = _root(circulation, places, np.array([circulation(float(place)) for place in places]))
    if found is None:
        raise ValueError(f"a2 must be an axis of an ellipsoid that rotates rigidly, got {a2:g}.")
    return found


def _root(function: Callable[[float], float], places: Array, values: Array) -> float | None:
    """Return the first root at which a function of these values increases between the places, else the first at which
    it decreases, None where there is none.
    """
    from scipy.optimize import brentq

    for k in np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0)):
        return float(brentq(function, places[k], places[k + 1], xtol=1e-300, rtol=1e-15))
    for k in np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0)):
        return float(brentq(function, places[k], places[k + 1], xtol=1e-300, rtol=1e-15))
    return None


def _found(model: Body3, D: Array, omega: Array, circulation: Array) -> RelativeEquilibrium:
    """Return a steady motion with its phase point, its energy and its exponents."""
    W, U = _cross(omega), _cross(circulation)
    shape = np.diag(D)
    p = model.mu * (W @ shape - shape @ U)
    z0 = np.concatenate([shape.ravel(), p.ravel()])
    energy = float(model.kinetic_energy(*z0[9:]) + model.potential_energy(*z0[:9]))
    # In the rotating axes d/dt becomes d/dt + A, A xi = W xi - xi U.
    A = np.kron(W, np.eye(3)) - np.kron(np.eye(3), U.T)
    H = np.array([model.potential.matrix_changes(*z0[:9], *unit) for unit in np.eye(9)]).T
    rates = np.block([[np.zeros((9, 9)), np.eye(9)], [-H / model.mu - A @ A, -2 * A]])
    return RelativeEquilibrium(model, D, omega, circulation, z0, energy, np.linalg.eigvals(rates))
