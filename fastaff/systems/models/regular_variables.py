"""Coordinates as functions of their regular variables s, which kernels use.

The motion of a coordinate is regular in s = alpha^2, beta^2, r, sin^2(vartheta/2), sinh^2(kappa), sin^2(lambda), so
that turning points at the chart's edges are like others.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Radius(NamedTuple):
    """Alpha or beta of s = alpha^2 or beta^2."""

    @property
    def bounded(self) -> bool:
        """Whether s ends at 1."""
        return False

    def value(self, s):
        """Return sqrt(s)."""
        return np.sqrt(s)


class Itself(NamedTuple):
    """The coordinate r, which is regular itself."""

    @property
    def bounded(self) -> bool:
        """Whether s ends at 1."""
        return False

    def value(self, s):
        """Return s."""
        return s


class VarthetaVariable(NamedTuple):
    """Vartheta of s = sin^2(vartheta/2)."""

    @property
    def bounded(self) -> bool:
        """Whether s ends at 1."""
        return True

    def value(self, s):
        """Return 2 arcsin(sqrt(s))."""
        return 2 * np.arcsin(np.sqrt(s))


class Hyperbolic(NamedTuple):
    """Kappa of s = sinh^2(kappa)."""

    @property
    def bounded(self) -> bool:
        """Whether s ends at 1."""
        return False

    def value(self, s):
        """Return arsinh(sqrt(s))."""
        return np.arcsinh(np.sqrt(s))


class Circular(NamedTuple):
    """Lambda of s = sin^2(lambda)."""

    @property
    def bounded(self) -> bool:
        """Whether s ends at 1."""
        return True

    def value(self, s):
        """Return arcsin(sqrt(s))."""
        return np.arcsin(np.sqrt(s))


class Composition(NamedTuple):
    """A function of one variable after a coordinate: function.value(coordinate.value(s))."""

    function: Any
    coordinate: Any

    def value(self, s):
        """Return V at s."""
        return self.function.value(self.coordinate.value(s))


class Regular(NamedTuple):
    """A function of one variable by its own formula in s."""

    function: Any

    def value(self, s):
        """Return V at s."""
        return self.function.regular(s)


def in_regular_variable(function: Any, coordinate: Any) -> Any:
    """Return a function of one variable, V of the coordinate, as a function of s: by its `regular` if it has that."""
    return Regular(function) if hasattr(function, "regular") else Composition(function, coordinate)
