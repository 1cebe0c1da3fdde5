"""Integer lattices of frequencies: generators of spectral lines, exact relations, bases.

A frequency of a torus is k . nu with an integer vector k. Everything here is exact integer algebra but for the
comparison of two frequencies, which takes their errors.
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

DENOMINATORS = 8
"""Largest m of a relation m nu = k . basis that refines a lattice."""

REACH = {1: 48, 2: 24, 3: 8}
"""Largest |k_i| of a line in a lattice of that rank."""


class Generators(NamedTuple):
    """A basis of the lattice of lines: nu (rank,), and k (lines, rank) with known (lines,): a mask of the lines it
    explains.
    """

    nu: np.ndarray
    k: np.ndarray
    known: np.ndarray


def box(orders: tuple[int, ...] | list[int]) -> np.ndarray:
    """Return all integer vectors with |k_i| <= orders[i], (terms, rank), the last component fastest."""
    ranges = [np.arange(-order, order + 1) for order in orders]
    return (
        np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, len(ranges))
        if ranges
        else np.zeros((1, 0), int)
    )


@functools.cache
def ball(rank: int, longest: int) -> np.ndarray:
    """Return all integer vectors with |k|_1 <= longest, (terms, rank), by length, those of one length in ascending
    order.
    """
    k = np.array(_ball(rank, longest), np.int64).reshape(-1, rank)
    return k[np.argsort(np.abs(k).sum(axis=1), kind="stable")]


def one_of_each(k: np.ndarray) -> np.ndarray:
    """Return one of each pair +-k of vectors (vectors, n), with its first nonzero entry positive."""
    first = np.take_along_axis(k, (k != 0).argmax(axis=1)[:, None], axis=1)[:, 0]
    return k[first > 0]


def combined(k: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Return k . nu (orbits, vectors) of vectors k ((orbits,) vectors, n) and frequencies (orbits, n): added up in the
    same order for any number of orbits.
    """
    result = np.zeros((len(nu), k.shape[-2]))
    with np.errstate(invalid="ignore"):  # 0 times an unknown frequency is 0
        for j in range(nu.shape[1]):
            result += np.where(k[..., j] != 0, k[..., j] * nu[:, j, None], 0.0)
    return result


def _ball(rank: int, longest: int) -> list[tuple[int, ...]]:
    if rank == 0:
        return [()]
    return [(first, *rest) for first in range(-longest, longest + 1) for rest in _ball(rank - 1, longest - abs(first))]


def determinant(matrix: np.ndarray) -> int:
    """Return the determinant of a small integer matrix."""
    return round(float(np.linalg.det(matrix))) if len(matrix) else 1


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverse of an integer matrix of determinant +-1."""
    return np.rint(np.linalg.inv(matrix)).astype(int) if len(matrix) else matrix


def primitive(vectors: np.ndarray) -> bool:
    """Tell whether integer vectors (r, rank) can be completed to a basis of the integers: the gcd of their minors
    is 1.
    """
    r, rank = vectors.shape
    if r > rank:
        return False
    return math.gcd(*(determinant(vectors[:, list(c)]) for c in itertools.combinations(range(rank), r))) == 1


def first_basis(vectors: np.ndarray) -> list[int]:
    """Return the numbers of early vectors (count, rank) that are a basis of the integers, or part of one."""
    chosen: list[int] = []
    for i in range(len(vectors)):
        if len(chosen) < vectors.shape[1] and primitive(vectors[[*chosen, i]]):
            chosen.append(i)
    return chosen


def reduced(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (M V, V): `matrix` M in lower column-echelon form by a unimodular V, Euclid's algorithm on columns."""
    M, V = np.array(matrix, dtype=object), np.eye(matrix.shape[1], dtype=object)
    column = 0
    for row in range(M.shape[0]):
        while True:
            filled = [j for j in range(column, M.shape[1]) if M[row, j]]
            if not filled:
                break
            pivot = min(filled, key=lambda j: abs(M[row, j]))
            for A in (M, V):
                A[:, [column, pivot]] = A[:, [pivot, column]]
            for j in range(column + 1, M.shape[1]):
                factor = M[row, j] // M[row, column]
                M[:, j] -= factor * M[:, column]
                V[:, j] -= factor * V[:, column]
            if not any(M[row, column + 1 :]):
                column += 1
                break
    return M.astype(int), V.astype(int)


def generators(nu: np.ndarray, error: np.ndarray, rank: int) -> Generators:
    """Find a basis, of at most `rank` frequencies, of the lattice that lines lie in; the trusted lines come first.

    A line that is k . basis is in; one with m nu = k . basis, m > 1, refines the lattice; one with no such relation
    adds a generator while there are fewer than `rank`, and stays unknown otherwise.
    """
    basis = np.zeros(0)
    spread = np.zeros(0)
    for value, bar in zip(nu, error, strict=True):
        found = _relation(value, bar, basis, spread)
        if found is None:
            if len(basis) < rank:
                basis = np.append(basis, value)
                spread = np.append(spread, bar)
            continue
        m, k = found
        if m > 1:
            generated = reduced(np.column_stack([m * np.eye(len(basis), dtype=int), k]))[0][:, : len(basis)]
            spread = (np.abs(generated).T @ spread + bar) / m
            basis = generated.T @ basis / m
    k = np.zeros((len(nu), len(basis)), int)
    known = np.zeros(len(nu), bool)
    for i, (value, bar) in enumerate(zip(nu, error, strict=True)):
        found = _relation(value, bar, basis, spread, 1)
        if found is not None:
            k[i] = found[1]
            known[i] = True
    return Generators(basis, k, known)


def _relation(
    value: float, bar: float, basis: np.ndarray, spread: np.ndarray, denominators: int = DENOMINATORS
) -> tuple[int, np.ndarray] | None:
    """Return the smallest m, and for it the shortest k, with m value = k . basis within the errors."""
    rank = len(basis)
    reach = REACH.get(rank, 4) if rank else 0
    for m in range(1, denominators + 1):
        k = box([reach if m == 1 else reach // 2] * rank)
        miss = np.abs(m * value - k @ basis)
        within = np.flatnonzero(miss <= m * bar + np.abs(k) @ spread)
        if within.size:
            return m, k[within[np.argmin(np.abs(k[within]).sum(axis=1))]]
        if rank == 0:
            break
    return None


def relations(nu: np.ndarray, error: np.ndarray, largest: int) -> np.ndarray:
    """Return independent integer vectors (count, n) with k . nu = 0 within the errors, |k_i| <= largest, shortest
    first.
    """
    k = box([largest] * len(nu))
    k = k[(k != 0).any(axis=1)]
    small = k[np.abs(k @ nu) <= np.abs(k) @ error]
    small = small[np.argsort(np.abs(small).sum(axis=1), kind="stable")]
    chosen = np.zeros((0, len(nu)), int)
    for vector in small[:400]:
        longer = np.vstack([chosen, vector])
        if np.linalg.matrix_rank(longer) == len(longer):
            chosen = longer
    return chosen


def quotient(relation: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return R (n, d) and C (d, n), integer with C R = 1: frequencies with these relations are nu = R y, y = C nu.

    The rows of R are unit vectors for the first of the n frequencies that can be a basis.
    """
    _, V = reduced(relation) if len(relation) else (relation, np.eye(n, dtype=int))
    R = V[:, len(relation) :]
    C = inverse(V)[len(relation) :]
    chosen = first_basis(R)
    if len(chosen) == R.shape[1]:
        S = R[chosen]
        R = R @ inverse(S)
        C = np.eye(n, dtype=int)[chosen]
    return R, C
