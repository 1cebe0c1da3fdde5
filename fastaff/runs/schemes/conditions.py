"""Conditions on the coefficients of a scheme: sums, orders of quadratures, rows of numbers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from ...core.numbers import reals, shown

Weights = tuple[float, ...]
Rows = tuple[Weights, ...]


MOST_ORDER = 40
"""An order above that of all known schemes; its quadrature conditions are still well posed."""


def require(condition: bool, scheme: str, fault: str) -> None:
    """Raise ValueError with the fault of a scheme unless the condition holds."""
    if not condition:
        raise ValueError(f"scheme {scheme}: {fault}")


def agree(found: float | np.ndarray, expected: float | np.ndarray, weights: Weights) -> bool:
    """Whether sums over `weights` agree with the expected values up to rounding."""
    return bool(np.all(np.abs(found - expected) <= 1e-14 * max(1.0, sum(map(abs, weights)))))


def tableau(name: str, value: Any) -> Rows:
    """Return a tuple of rows of numbers."""
    if not isinstance(value, (tuple, list)):
        raise TypeError(f"{name} must be a tuple of rows of numbers, got {shown(value)} ({type(value).__name__})")
    return tuple(reals(f"{name}[{k}]", row) for k, row in enumerate(value))


def values(text: str) -> Weights:
    """Return the numbers of a text, decimals or fractions, each rounded once."""
    return tuple(float(Fraction(number)) for number in text.split())


def sparse(text: str, length: int) -> Weights:
    """Return a row of `length` numbers from those that are not 0, each as column:number."""
    row = [0.0] * length
    for entry in text.split():
        column, _, number = entry.partition(":")
        row[int(column)] = float(Fraction(number))
    return tuple(row)


def moments(weights: Weights, nodes: np.ndarray, order: int) -> np.ndarray:
    """Sums of weights * nodes**k for k = 0 ... order - 1."""
    return np.vander(nodes, order, increasing=True).T @ np.array(weights)


def nested(k: int, rows: int) -> list[float]:
    """Coefficients of x**k / k in the nesting x (F_0 + (1-x) (F_1 + x (F_2 + ...))); it has degree `rows`."""
    rest = np.polynomial.Polynomial.basis(k) / k // [0, 1]
    coefficients = []
    for r in range(rows):
        coefficients.append(float(rest(1.0 if r % 2 == 0 else 0.0)))
        rest = (rest - coefficients[-1]) // ([1, -1] if r % 2 == 0 else [0, 1])
    return coefficients
