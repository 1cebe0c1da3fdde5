"""Functions of one variable, the building blocks of separable potentials.

A function is a NamedTuple of float parameters with `value(x)` and `slope(x)` (and `curvature(x)` for tangent maps), on
floats and arrays, +inf outside its domain. It may also have `regular(s)`: its value as a function of the variable in
which its coordinate's motion is regular, s = alpha^2, beta^2, r, sin^2(vartheta/2), sinh^2(kappa), sin^2(lambda); else
value(x(s)) is used. `univariate` makes one from a plain Python function.
"""

from __future__ import annotations

import contextlib
import inspect
from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np

from ...core.numbers import reason, shown
from ...engine.values import told_apart
from .contracts import Arithmetic, OneVariable

COMPLEX_STEP = 1e-100
"""Imaginary step of a complex-step derivative: small enough that its square underflows and no difference is rounded."""


class Zero(NamedTuple):
    """Define the function V = 0.

    References
    ----------
    Martens & Slawianowski, EQ2.1 with V_eta = V_gamma = 0.

    Examples
    --------
    >>> fa.models.Zero().value(2.0)
    0.0
    """

    def value(self, x):
        """Return V.

        Parameters
        ----------
        x : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            V at the variable.
        """
        return 0.0 * x

    def slope(self, x):
        """Return the first derivative of V.

        Parameters
        ----------
        x : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dx.
        """
        return 0.0 * x

    def curvature(self, x):
        """Return the second derivative of V.

        Parameters
        ----------
        x : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to x.
        """
        return 0.0 * x


class Oscillator(NamedTuple):
    """Define the function V = k x^2/2 + c/x^2 of x = alpha or beta.

    Parameters
    ----------
    k : float, default 1
        Strength of the oscillator.
    c : float, default 0
        Strength of the barrier at x = 0.

    References
    ----------
    Martens & Slawianowski, EQ3.1 (k = C, c = 0) and EQa (V_alpha: c = 2 C).

    Examples
    --------
    >>> fa.models.Oscillator(k=4.0, c=1.0).value(2.0)
    8.25
    """

    k: float = 1.0
    c: float = 0.0

    def value(self, x):
        """Return V.

        Parameters
        ----------
        x : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            V at the variable.
        """
        return self.k * x * x / 2 + self.c / (x * x) if self.c != 0 else self.k * x * x / 2

    def slope(self, x):
        """Return the first derivative of V.

        Parameters
        ----------
        x : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dx.
        """
        return self.k * x - 2 * self.c / (x * x * x) if self.c != 0 else self.k * x

    def curvature(self, x):
        """Return the second derivative of V.

        Parameters
        ----------
        x : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to x.
        """
        return self.k + 6 * self.c / (x * x * x * x) if self.c != 0 else self.k + 0.0 * x

    def regular(self, s):
        """Return V as a function of the variable in which the motion is regular.

        Parameters
        ----------
        s : float or array_like
            Regular variable, s = x^2.

        Returns
        -------
        float or ndarray
            V at s.
        """
        return self.k * s / 2 + self.c / s if self.c != 0 else self.k * s / 2


class Spring(NamedTuple):
    """Define the function V_r = k r/2 + c/r.

    Parameters
    ----------
    k : float, default 1
        Strength of the oscillator.
    c : float, default 0
        Strength of the term c/r.

    Notes
    -----
    The function is the oscillator in r = rho^2. The term c/r is that of a constant V_vartheta = c.

    References
    ----------
    Martens & Slawianowski, EQ2.2h (V_r, c = 0), EQb (first term: c = 2 C).

    Examples
    --------
    >>> fa.models.Spring(k=4.0, c=1.0).value(2.0)
    4.5
    """

    k: float = 1.0
    c: float = 0.0

    def value(self, r):
        """Return V.

        Parameters
        ----------
        r : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            V at the variable.
        """
        return self.k * r / 2 + self.c / r if self.c != 0 else self.k * r / 2

    def slope(self, r):
        """Return the first derivative of V.

        Parameters
        ----------
        r : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dr.
        """
        return self.k / 2 - self.c / (r * r)

    def curvature(self, r):
        """Return the second derivative of V.

        Parameters
        ----------
        r : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to r.
        """
        return 2 * self.c / (r * r * r)

    def regular(self, s):
        """Return V as a function of the variable in which the motion is regular.

        Parameters
        ----------
        s : float or array_like
            Regular variable, s = r.

        Returns
        -------
        float or ndarray
            V at s.
        """
        return self.value(s)


class Barriers(NamedTuple):
    """Define the function V_vartheta with barriers at alpha = 0 and beta = 0.

    Parameters
    ----------
    c_alpha, c_beta : float, default 0
        Strengths of the barriers at alpha = 0 and at beta = 0.

    Notes
    -----
    The function is ``V_vartheta = c_alpha/cos^2(vartheta/2) + c_beta/sin^2(vartheta/2)``. Constants V_eta and V_gamma
    have the same form.

    References
    ----------
    Martens & Slawianowski, EQ2.2f (V_eta, V_gamma constant) and EQb (c_alpha = 2 C).

    Examples
    --------
    >>> fa.models.Barriers(c_alpha=1.0).value(np.pi / 2).round(9)
    np.float64(2.0)
    """

    c_alpha: float = 0.0
    c_beta: float = 0.0

    def value(self, vartheta):
        """Return V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            V at the variable.
        """
        return self.regular(np.sin(vartheta / 2) ** 2)

    def slope(self, vartheta):
        """Return the first derivative of V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dvartheta.
        """
        c, s = np.cos(vartheta / 2), np.sin(vartheta / 2)
        wall = self.c_alpha * s / (c * c * c) if self.c_alpha != 0 else 0.0 * c
        return wall - self.c_beta * c / (s * s * s) if self.c_beta != 0 else wall

    def curvature(self, vartheta):
        """Return the second derivative of V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to vartheta.
        """
        c, s = np.cos(vartheta / 2) ** 2, np.sin(vartheta / 2) ** 2
        wall = self.c_alpha * (1.5 / c - 1) / c if self.c_alpha != 0 else 0.0 * c
        return wall + self.c_beta * (1.5 / s - 1) / s if self.c_beta != 0 else wall

    def regular(self, s):
        """Return V as a function of the variable in which the motion is regular.

        Parameters
        ----------
        s : float or array_like
            Regular variable, s = sin^2(vartheta/2).

        Returns
        -------
        float or ndarray
            V at s.
        """
        wall = self.c_alpha / (1 - s) if self.c_alpha != 0 else 0.0 * s
        return wall + self.c_beta / s if self.c_beta != 0 else wall


class Secant(NamedTuple):
    """Define the function V_vartheta = k/cos(vartheta).

    Parameters
    ----------
    k : float, default 2
        Strength.

    Notes
    -----
    The value is plus infinity for vartheta >= pi/2, where det phi <= 0.

    References
    ----------
    Martens & Slawianowski, EQ2.2h (k = 2 C).

    Examples
    --------
    >>> fa.models.Secant(k=2.0).value(np.pi / 3).round(9)
    np.float64(4.0)
    """

    k: float = 2.0

    def value(self, vartheta):
        """Return V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            V, plus infinity outside the domain.
        """
        return self.k / np.maximum(np.cos(vartheta), 0.0)

    def slope(self, vartheta):
        """Return the first derivative of V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dvartheta.
        """
        c = np.cos(vartheta)
        return self.k * np.sin(vartheta) / (c * c)

    def curvature(self, vartheta):
        """Return the second derivative of V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to vartheta.
        """
        c = np.cos(vartheta)
        return self.k * (2 / (c * c) - 1) / c

    def regular(self, s):
        """Return V as a function of the variable in which the motion is regular.

        Parameters
        ----------
        s : float or array_like
            Regular variable, s = sin^2(vartheta/2).

        Returns
        -------
        float or ndarray
            V at s.
        """
        return self.k / np.maximum(1 - 2 * s, 0.0)


class Cosine(NamedTuple):
    """Define the function V_vartheta = k cos(vartheta) of the heavy top.

    Parameters
    ----------
    k : float, default 1
        Strength.

    References
    ----------
    Martens & Slawianowski, section 3 (V_vartheta = A cos vartheta).

    Examples
    --------
    >>> fa.models.Cosine(k=0.5).value(np.pi / 3).round(9)
    np.float64(0.25)
    """

    k: float = 1.0

    def value(self, vartheta):
        """Return V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            V at the variable.
        """
        return self.k * np.cos(vartheta)

    def slope(self, vartheta):
        """Return the first derivative of V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dvartheta.
        """
        return -self.k * np.sin(vartheta)

    def curvature(self, vartheta):
        """Return the second derivative of V.

        Parameters
        ----------
        vartheta : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to vartheta.
        """
        return -self.k * np.cos(vartheta)

    def regular(self, s):
        """Return V as a function of the variable in which the motion is regular.

        Parameters
        ----------
        s : float or array_like
            Regular variable, s = sin^2(vartheta/2).

        Returns
        -------
        float or ndarray
            V at s.
        """
        return self.k * (1 - 2 * s)


class CoshOscillator(NamedTuple):
    """Define the function V_kappa of the oscillator in the elliptic chart.

    Parameters
    ----------
    k : float, default 1
        Strength of the oscillator.
    c : float, default 0
        Strength of the barrier c/alpha^2.

    Notes
    -----
    The function is ``V_kappa = (k/2) cosh^2(2 kappa) - c/cosh^2(kappa)``. `CosOscillator` is its partner.

    References
    ----------
    Derived from the elliptic Hamiltonian of section 3 of Martens & Slawianowski (EQ3.1: c = 0; EQa: c = 2 C).

    Examples
    --------
    >>> fa.models.CoshOscillator(k=2.0).value(0.0)
    np.float64(1.0)
    """

    k: float = 1.0
    c: float = 0.0

    def value(self, kappa):
        """Return V.

        Parameters
        ----------
        kappa : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            V at the variable.
        """
        return self.k / 2 * np.cosh(2 * kappa) ** 2 - self.c / np.cosh(kappa) ** 2

    def slope(self, kappa):
        """Return the first derivative of V.

        Parameters
        ----------
        kappa : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dkappa.
        """
        return 2 * self.k * np.cosh(2 * kappa) * np.sinh(2 * kappa) + 2 * self.c * np.tanh(kappa) / np.cosh(kappa) ** 2

    def curvature(self, kappa):
        """Return the second derivative of V.

        Parameters
        ----------
        kappa : float or array_like
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to kappa.
        """
        w = 1 / np.cosh(kappa) ** 2
        return 4 * self.k * np.cosh(4 * kappa) + 2 * self.c * w * (3 * w - 2)

    def regular(self, s):
        """Return V as a function of the variable in which the motion is regular.

        Parameters
        ----------
        s : float or array_like
            Regular variable, s = sinh^2(kappa).

        Returns
        -------
        float or ndarray
            V at s.
        """
        return self.k / 2 * (1 + 2 * s) * (1 + 2 * s) - self.c / (1 + s)


class CosOscillator(NamedTuple):
    """Define the function V_lambda of the oscillator in the elliptic chart.

    Parameters
    ----------
    k : float, default 1
        Strength of the oscillator.
    c : float, default 0
        Strength of the barrier c/alpha^2.

    Notes
    -----
    The function is ``V_lambda = -(k/2) cos^2(2 lambda) + c/cos^2(lambda)``. `CoshOscillator` is its partner.

    References
    ----------
    Derived from the elliptic Hamiltonian of section 3 of Martens & Slawianowski (EQ3.1: c = 0; EQa: c = 2 C).

    Examples
    --------
    >>> fa.models.CosOscillator(k=2.0).value(0.0)
    np.float64(-1.0)
    """

    k: float = 1.0
    c: float = 0.0

    def value(self, lam):
        """Return V.

        Parameters
        ----------
        lam : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            V at the variable.
        """
        return self.regular(np.sin(lam) ** 2)

    def slope(self, lam):
        """Return the first derivative of V.

        Parameters
        ----------
        lam : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Derivative dV/dlambda.
        """
        c, s = np.cos(lam), np.sin(lam)
        wall = 2 * self.c * s / (c * c * c) if self.c != 0 else 0.0 * s
        return 2 * self.k * np.cos(2 * lam) * np.sin(2 * lam) + wall

    def curvature(self, lam):
        """Return the second derivative of V.

        Parameters
        ----------
        lam : float or array_like, radians
            Variable of the function.

        Returns
        -------
        float or ndarray
            Second derivative of V with respect to lambda.
        """
        w = 1 / np.cos(lam) ** 2
        wall = 2 * self.c * w * (3 * w - 2) if self.c != 0 else 0.0 * w
        return 4 * self.k * np.cos(4 * lam) + wall

    def regular(self, s):
        """Return V as a function of the variable in which the motion is regular.

        Parameters
        ----------
        s : float or array_like
            Regular variable, s = sin^2(lambda).

        Returns
        -------
        float or ndarray
            V at s.
        """
        oscillator = -self.k / 2 * (1 - 2 * s) * (1 - 2 * s)
        return oscillator + self.c / (1 - s) if self.c != 0 else oscillator


def univariate(value: Arithmetic, slope: Arithmetic | None = None, curvature: Arithmetic | None = None) -> OneVariable:
    """Make a function of one variable for a separable potential.

    Parameters
    ----------
    value : callable
        V(x), a Python function of one argument. It must accept floats and NumPy arrays, and Numba must be able to
        compile it.
    slope : callable, optional
        Derivative dV/dx, a function of the same kind. Default: the complex-step derivative Im V(x + 1e-100 i)/1e-100.
        For an analytic formula it is exact to round-off and costs twice as much.
    curvature : callable, optional
        Second derivative, which deviation vectors need. Default: the complex-step derivative of a given `slope`.

    Returns
    -------
    NamedTuple
        Value with the methods value, slope and, if known, curvature.

    Raises
    ------
    TypeError
        If an argument is not a Python function.
    ValueError
        If a function is not vectorised or not real, or if `slope` or `curvature` is not the derivative.

    Notes
    -----
    * Global numbers in the functions are fixed at their first compilation. For parameters that change at run time,
      write a NamedTuple with the same methods, like `Oscillator`.
    * A point where a function is infinite or NaN is outside its domain. For `action_angles` that is a hard
      wall. Integration needs a potential that grows instead.

    References
    ----------
    Squire & Trapp 1998, SIAM Review 40, 110 (the complex step).

    Examples
    --------
    >>> spring = fa.univariate(lambda x: x**2 / 2)
    >>> body = fa.Body(fa.SeparableAlphaBeta(spring, spring))
    >>> spring.value(2.0), spring.slope(2.0)
    (2.0, 2.0)
    """
    given = value, slope, curvature
    for name, function in zip(("value", "slope", "curvature"), given, strict=True):
        if function is not None or name == "value":
            _check_function(name, function)
    if slope is None:
        slope = _complex_slope("value", value)
    elif curvature is None:
        with contextlib.suppress(
            ValueError
        ):  # without tangent vectors a slope may have kinks, or fail for complex numbers
            derived = _complex_slope("slope", slope)
            _check_slope("curvature", slope, derived)
            curvature = derived
    _check_slope("slope", value, slope)
    if curvature is not None:
        _check_slope("curvature", slope, curvature)
    methods = {"value": value, "slope": slope, "curvature": curvature}
    cls: type = namedtuple("cls", [])
    cls.__name__ = cls.__qualname__ = getattr(value, "__name__", "function").replace("<lambda>", "function")
    for name, function in methods.items():
        if function is not None:
            setattr(cls, name, _method(function))
    cls.__module__ = value.__module__
    return cast(OneVariable, told_apart(cls, given)())


def _check_function(name: str, function: Any) -> None:
    if not inspect.isfunction(function):
        raise TypeError(
            f"{name} must be a Python function of one number, got {shown(function)} ({type(function).__name__})"
        )
    x = np.array([0.3, 0.7])
    try:
        with np.errstate(all="ignore"):
            result = np.asarray(function(x))
            ones = [np.asarray(function(float(number))) for number in x]
    except Exception as problem:
        raise ValueError(f"{name} must take an array of numbers, at {x} it raised {reason(problem)}") from problem
    if result.dtype.kind not in "fiu" or any(one.shape != () for one in ones) or result.shape not in ((2,), ()):
        raise ValueError(f"{name} must return one real number for each of {x}, got {shown(result)}")
    if not np.allclose(np.broadcast_to(result, 2), np.array(ones), rtol=1e-12, atol=0, equal_nan=True):
        raise ValueError(
            f"{name} must be vectorised, got {shown(result, 40)} on "
            f"{shown(x.tolist() if hasattr(x, 'tolist') else x, 40)} and {shown([float(o) for o in ones], 40)} one at "
            "a time"
        )


def _check_slope(name: str, function: Callable, slope: Callable) -> None:
    """Refuse a slope that is not the derivative, by differences of fourth order."""
    x = np.array([0.3, 0.7, 1.1])
    h = 1e-3
    with np.errstate(all="ignore"):
        given = np.broadcast_to(slope(x), 3)
        samples = [np.broadcast_to(function(x + k * h), 3) for k in (-2, -1, 1, 2)]
        expected = (8 * (samples[2] - samples[1]) - (samples[3] - samples[0])) / (12 * h)
        gap = np.abs(given - expected) / (np.abs(samples).max(axis=0) + np.abs(expected))
    if np.any(gap[np.isfinite(gap)] > 1e-4):
        raise ValueError(f"{name} must be the derivative, got {given} at {x}, differences give {expected}")


def _jitable(function: Callable) -> Callable:
    """Return `function`, callable from compiled code too."""
    from ...engine.numba_private import register_jitable

    return register_jitable(function)


def _complex_slope(name: str, value: Callable) -> Callable:
    compiled = _jitable(value)

    def slope(x):
        return compiled(x + COMPLEX_STEP * 1j).imag / COMPLEX_STEP

    try:
        with np.errstate(all="ignore"):
            numbers = [np.asarray(value(x + COMPLEX_STEP * 1j)) for x in (0.3, 0.7)]
            if not all(np.iscomplexobj(v) for v in numbers) and np.ptp([value(0.3), value(0.5), value(0.7)]) != 0:
                raise TypeError("it dropped the imaginary part")
    except Exception as problem:
        raise ValueError(
            f"{name} must take complex numbers if its slope is not given ({reason(problem)}). Use slope=dV/dx."
        ) from problem
    slope.__module__ = value.__module__
    return slope


def _method(function: Callable) -> Callable:
    compiled = _jitable(function)

    def method(self, x):
        return compiled(x)

    return method
