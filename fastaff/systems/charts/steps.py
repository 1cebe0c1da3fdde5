"""The four kinds of steps in the chains of charts.

A step replaces some of four coordinates x by new ones y. It has, with rows first and any trailing shape,

    invert(x, d)      -> y     d: the momentum or velocity at x, which picks the angle where a radius is 0
    restore(y)        -> x
    pull(x, y, p)     -> p_y   J^T p,  J = dx/dy: momenta into the chart
    unpull(y, p_y)    -> p     its inverse
    push(y, v_y)      -> v     J v: velocities out of the chart
    unpush(x, y, v)   -> v_y   its inverse

A value that does not exist becomes infinite or NaN (which the chart refuses), or is refused here with a better message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from ...core.arrays import Array, Mask, at_orbit, first

TURN = 2 * np.pi


class Step(Protocol):
    """The methods of a step; see the module."""

    def invert(self, x: Array, d: Array) -> Array: ...
    def restore(self, y: Array) -> Array: ...
    def pull(self, x: Array, y: Array, p: Array) -> Array: ...
    def unpull(self, y: Array, p: Array) -> Array: ...
    def push(self, y: Array, v: Array) -> Array: ...
    def unpush(self, x: Array, y: Array, v: Array) -> Array: ...


class PolarStep(NamedTuple):
    """Polar coordinates: (x_i, x_j) = radius (cos, sin)(angle/fold), the radius in row i, the angle in row j.

    radius, momentum: names for messages.  wrap: angles in [0, 2 pi fold), else as arctan2 gives them. Where the radius
    is 0 the angle is that of the motion, so p_radius = |p|, p_angle = 0, and the inverse returns the phase point.
    """

    i: int
    j: int
    radius: str
    momentum: str
    fold: int = 1
    wrap: bool = True

    def invert(self, x: Array, d: Array) -> Array:
        radius = np.hypot(x[self.i], x[self.j])
        e_i, e_j = (np.where(radius > 0, x[k], d[k]) + 0.0 for k in (self.i, self.j))  # + 0.0 takes the sign from -0.0
        angle = np.arctan2(e_j, e_i)
        if self.wrap:
            angle = np.mod(angle, TURN)
            angle = np.where(angle < TURN, angle, 0.0)  # -1e-20 mod 2 pi rounds to 2 pi
        return _replaced(x, self.i, radius, self.j, self.fold * angle)

    def restore(self, y: Array) -> Array:
        cosine, sine = direction(y[self.j] / self.fold)
        return _replaced(y, self.i, y[self.i] * cosine, self.j, y[self.i] * sine)

    def pull(self, x: Array, y: Array, p: Array) -> Array:
        return _replaced(p, self.i, self._along(x, y, p), self.j, self._cross(x, p) / self.fold)

    def unpull(self, y: Array, p: Array) -> Array:
        return self._out(y, p[self.i], self._transverse(p[self.j], y[self.i] / self.fold), p)

    def push(self, y: Array, v: Array) -> Array:
        return self._out(y, v[self.i], y[self.i] * v[self.j] / self.fold, v)

    def unpush(self, x: Array, y: Array, v: Array) -> Array:
        rate = self.fold * quotient(quotient(self._cross(x, v), y[self.i]), y[self.i])
        return _replaced(v, self.i, self._along(x, y, v), self.j, rate)

    def _along(self, x: Array, y: Array, d: Array) -> Array:
        """The component of d along the radius, from x itself where x has a direction."""
        cosine, sine = direction(y[self.j] / self.fold)
        radius = y[self.i]
        return (
            np.where(radius == 0, cosine, x[self.i] / radius) * d[self.i]
            + np.where(radius == 0, sine, x[self.j] / radius) * d[self.j]
        )

    def _cross(self, x: Array, d: Array) -> Array:
        return x[self.i] * d[self.j] - x[self.j] * d[self.i]

    def _out(self, y: Array, along: Array, across: Array, rows: Array) -> Array:
        cosine, sine = direction(y[self.j] / self.fold)
        return _replaced(rows, self.i, along * cosine - across * sine, self.j, along * sine + across * cosine)

    def _transverse(self, p_angle: Array, radius: Array) -> Array:
        """p_angle/radius, 0 where both are 0; refuse an infinite quotient."""
        momentum = quotient(p_angle, radius)
        if not np.isfinite(momentum).all():
            index = first(~np.isfinite(momentum))
            raise ValueError(
                f"q: {self.momentum} must be 0 where {self.radius} = 0, got {p_angle[index]}{at_orbit(index)}"
            )
        return momentum


class Mix(NamedTuple):
    """Sum and difference: (x_i, x_j) -> (x_i + x_j, x_i - x_j)/scale; an orthogonal turn for scale = sqrt2."""

    i: int
    j: int
    scale: float

    def invert(self, x: Array, d: Array) -> Array:
        return self._into(x)

    def restore(self, y: Array) -> Array:
        return self._back(y)

    def pull(self, x: Array, y: Array, p: Array) -> Array:
        return self._back(p)

    def unpull(self, y: Array, p: Array) -> Array:
        return self._into(p)

    def push(self, y: Array, v: Array) -> Array:
        return self._back(v)

    def unpush(self, x: Array, y: Array, v: Array) -> Array:
        return self._into(v)

    def _into(self, rows: Array) -> Array:
        return _replaced(
            rows, self.i, (rows[self.i] + rows[self.j]) / self.scale, self.j, (rows[self.i] - rows[self.j]) / self.scale
        )

    def _back(self, rows: Array) -> Array:
        half = self.scale / 2
        return _replaced(
            rows, self.i, (rows[self.i] + rows[self.j]) * half, self.j, (rows[self.i] - rows[self.j]) * half
        )


class Warp(NamedTuple):
    """A function of one coordinate: y_i = into(x_i), x_i = out(y_i), rate(y_i) = dy_i/dx_i.

    inside(y_i) tells where y_i is in the chart; takes, got: the condition on it and its name, for messages.
    """

    i: int
    into: Callable[[Array], Array]
    out: Callable[[Array], Array]
    rate: Callable[[Array], Array]
    inside: Callable[[Array], Mask]
    takes: str = ""
    got: str = ""

    def invert(self, x: Array, d: Array) -> Array:
        return _replaced(x, self.i, self.into(x[self.i]))

    def restore(self, y: Array) -> Array:
        outside = ~self.inside(y[self.i])
        if np.any(outside):
            index = first(outside)
            raise ValueError(f"q: {self.takes}; got {self.got} = {y[self.i][index]}{at_orbit(index)}")
        return _replaced(y, self.i, self.out(y[self.i]))

    def pull(self, x: Array, y: Array, p: Array) -> Array:
        return _replaced(p, self.i, quotient(p[self.i], self.rate(y[self.i])))

    def unpull(self, y: Array, p: Array) -> Array:
        return _replaced(p, self.i, p[self.i] * self.rate(y[self.i]))

    def push(self, y: Array, v: Array) -> Array:
        return _replaced(v, self.i, v[self.i] / self.rate(y[self.i]))

    def unpush(self, x: Array, y: Array, v: Array) -> Array:
        return _replaced(v, self.i, v[self.i] * self.rate(y[self.i]))


class Conformal(NamedTuple):
    """A holomorphic map of the plane of invariants: x_i + i sign x_j = w(zeta), zeta = y_i + i y_j.

    value(y_i, y_j) -> x_i, x_j;  slope(y_i, y_j) -> w'(zeta), complex;  inverse(x_i, x_j) -> y_i, y_j.
    Momenta are multiplied by the conjugate of w', velocities divided by w'; where w' = 0 neither has an inverse.
    """

    i: int
    j: int
    value: Callable[[Array, Array], tuple[Array, Array]]
    slope: Callable[[Array, Array], np.ndarray]
    inverse: Callable[[Array, Array], tuple[Array, Array]]
    sign: int = 1

    def invert(self, x: Array, d: Array) -> Array:
        first_row, second_row = self.inverse(x[self.i], x[self.j])
        return _replaced(x, self.i, first_row, self.j, second_row)

    def restore(self, y: Array) -> Array:
        first_row, second_row = self.value(y[self.i], y[self.j])
        return _replaced(y, self.i, first_row, self.j, second_row)

    def pull(self, x: Array, y: Array, p: Array) -> Array:
        w = np.conj(self.slope(y[self.i], y[self.j])) * (p[self.i] + 1j * self.sign * p[self.j])
        return _replaced(p, self.i, w.real, self.j, w.imag)

    def unpull(self, y: Array, p: Array) -> Array:
        w = (p[self.i] + 1j * p[self.j]) / np.conj(self.slope(y[self.i], y[self.j]))
        return _replaced(p, self.i, w.real, self.j, self.sign * w.imag)

    def push(self, y: Array, v: Array) -> Array:
        w = self.slope(y[self.i], y[self.j]) * (v[self.i] + 1j * v[self.j])
        return _replaced(v, self.i, w.real, self.j, self.sign * w.imag)

    def unpush(self, x: Array, y: Array, v: Array) -> Array:
        w = quotient(v[self.i] + 1j * self.sign * v[self.j], self.slope(y[self.i], y[self.j]))
        return _replaced(v, self.i, w.real, self.j, w.imag)


def direction(angle: Array) -> tuple[Array, Array]:
    """Return cosine and sine, exactly 0 and +-1 at the doubles nearest to multiples of pi/2."""
    quarters = np.rint(angle / (np.pi / 2))
    exact = angle == quarters * (np.pi / 2)
    quarter = np.mod(quarters, 4)
    cosine = np.where(exact, (quarter == 0) * 1.0 - (quarter == 2), np.cos(angle))
    return cosine, np.where(exact, (quarter == 1) * 1.0 - (quarter == 3), np.sin(angle))


def quotient(p: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return p/radius without warnings, 0 where p is 0 and infinite (or NaN) where only the radius is."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(p == 0, 0.0, p / radius)


def _replaced(rows: Array, i: int, first_row: Array, j: int | None = None, second_row: Array | None = None) -> Array:
    out = rows.copy()
    out[i] = first_row
    if j is not None:
        out[j] = second_row
    return out
