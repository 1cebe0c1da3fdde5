"""The quantum numbers of all levels below an energy, where E grows with every one of them."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

import numpy as np

LONGEST_ROW = 2**20
"""Levels that differ in one quantum number only, below an energy: more are not listed."""
Energy = Callable[[np.ndarray, Any, Any], np.ndarray]
"""E (levels,) of n (2, levels), m, l; NaN where there is no level."""


def numbers_below(energy: Energy, top: float, single_valued: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return n (2, levels), m and l (levels,) of all levels below `top`, class by class.

    E must grow with both n and with |m - l| and |m + l|: the search stops at the first level above, or none, in each
    direction. Raises ValueError for rows of more than LONGEST_ROW levels.
    """
    rows = []
    for eta, gamma, n in _classes(energy, top, 2 if single_valued else 1):
        for signed_eta in sorted({eta, -eta}):
            for signed_gamma in sorted({gamma, -gamma}):
                m = (signed_gamma + signed_eta) // 2
                l = (signed_gamma - signed_eta) // 2
                rows.append(np.vstack([n, np.full((1, n.shape[1]), m), np.full((1, n.shape[1]), l)]))
    table = np.concatenate(rows, axis=1) if rows else np.zeros((4, 0), np.int64)
    return table[:2], table[2], table[3]


def _classes(energy: Energy, top: float, step: int) -> Iterator[tuple[int, int, np.ndarray]]:
    """Yield |m - l|, |m + l|, which have the same parity, and n (2, levels), n1 first, where there are any."""
    for parity in range(0, 2, step):
        for eta in count(parity, 2):
            found_any = False
            for gamma in count(parity, 2):
                m = (gamma + eta) // 2
                l = (gamma - eta) // 2
                n = rows_below(functools.partial(_in_class, energy, m, l), top)
                if not n.size:
                    break
                found_any = True
                yield eta, gamma, n
            if not found_any:
                break


def _in_class(energy: Energy, m: int, l: int, n: np.ndarray) -> np.ndarray:
    """Return E (levels,) of n (2, levels) in one class."""
    return energy(n, m, l)


def rows_below(energy: Callable[[np.ndarray], np.ndarray], top: float) -> np.ndarray:
    """Return n (2, levels), n1 first, of all levels of a class below `top`; energy(n): E, NaN where there is none."""
    lengths = list(_lengths(energy, top))
    return np.array(np.nonzero(np.arange(max(lengths, default=0))[:, None] < np.array(lengths, int)))


def _lengths(energy: Callable[[np.ndarray], np.ndarray], top: float) -> Iterator[int]:
    """Yield the number of n1 below `top` for n2 = 0, 1, ..., as long as there are any."""
    for n2 in count():
        length = 0
        size = 8
        while True:
            n1 = np.arange(length, length + size)
            inside = top > energy(np.array([n1, np.full_like(n1, n2)]))
            length += size if inside.all() else int(np.argmin(inside))
            if not inside.all():
                break
            size *= 2
            if size > LONGEST_ROW:
                raise ValueError(f"hbar must be larger: more than {LONGEST_ROW} levels lie below the energy in one row")
        if length == 0:
            return
        yield length
