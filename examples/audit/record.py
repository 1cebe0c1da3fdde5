"""A formula of the paper as a record: its statement, both sides at a random point, and a verdict."""

from __future__ import annotations

import random
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from mpmath import mp, mpf

DIGITS = 50
"""Working precision of all mpmath arithmetic; differences with steps of 1e-12 then keep 24 digits (see numerics)."""
EXACT = 1e-20
"""Threshold of formulas checked in 50 digits: the differences leave 1e-24 times the growth of a third derivative."""
DOUBLE = 1e-9
"""Threshold of formulas checked against a double-precision eigenproblem."""
POINTS = 3
"""Random points per formula."""


class Random(random.Random):
    """Random numbers with all digits of mpmath; `index` numbers the points of one formula from 0."""

    def __init__(self, label: str, index: int):
        super().__init__(zlib.crc32(f"{label}/{index}".encode()))
        self.index = index

    def real(self, low: float = -1.0, high: float = 1.0) -> Any:
        """Return one number between low and high."""
        return low + (high - low) * mpf(self.getrandbits(160)) / 2**160

    def reals(self, count: int, low: float = -1.0, high: float = 1.0) -> list[Any]:
        """Return `count` numbers between low and high."""
        return [self.real(low, high) for _ in range(count)]


Sides = Callable[[Random], tuple[Any, ...]]


@dataclass(frozen=True)
class Formula:
    """Hold one formula: `sides` gives (truth, printed) or (truth, printed, corrected) at a random point.

    `correct` is the replacement of the printed formula in words; `reading` marks a printed formula that is right if its
    words are read so. A definition has no sides.
    """

    label: str
    says: str
    sides: Sides | None = None
    correct: str = ""
    reading: bool = False
    threshold: float = EXACT


@dataclass(frozen=True)
class Finding:
    """Hold the residuals of one formula and the verdict that follows from them."""

    formula: Formula
    printed: float = 0.0
    corrected: float | None = None
    verdict: str = field(default="definition")

    @property
    def failed(self) -> bool:
        """Tell whether neither the printed nor the corrected formula holds, or the correction is needless."""
        return self.verdict in ("FAILS", "needless correction")


class Chapter:
    """Collect the formulas of one part of the paper, in its order."""

    def __init__(self, title: str):
        self.title = title
        self.formulas: list[Formula] = []

    def __iter__(self) -> Iterator[Formula]:
        return iter(self.formulas)

    def defines(self, label: str, says: str) -> None:
        """Add a definition or convention: nothing to check."""
        self.formulas.append(Formula(label, says))

    def states(self, label: str, says: str, correct: str = "", *, reading: bool = False, threshold: float = EXACT):
        """Add the decorated sides as a formula that states a fact."""

        def add(sides: Sides) -> Sides:
            self.formulas.append(Formula(label, says, sides, correct, reading, threshold))
            return sides

        return add


def flat(value: Any) -> list[Any]:
    """Return the numbers of a number, a matrix or nested sequences as one list."""
    if isinstance(value, mp.matrix):
        return list(value)
    if isinstance(value, (list, tuple)):
        return [number for part in value for number in flat(part)]
    return [value + mpf(0)]


def claim(truth: Any) -> tuple[int, int]:
    """Return the sides of a claim that is true or false."""
    return 1, int(bool(truth))


def residual(value: Any, truth: Any) -> float:
    """Return max |value - truth| / max |truth| (max |value| where the truth is 0: both sides are then scaled to 1); inf
    if not finite.
    """
    ours, theirs = flat(value), flat(truth)
    differences = [abs(v - t) for v, t in zip(ours, theirs, strict=True)]
    if not all(mp.isfinite(difference) for difference in differences):
        return float("inf")
    return float(max(differences) / (max(abs(t) for t in theirs) or mpf(1)))


def examine(formula: Formula) -> Finding:
    """Return the largest residuals over the random points, and the verdict."""
    if formula.sides is None:
        return Finding(formula)
    printed, corrected = [], []
    with mp.workdps(DIGITS):
        for index in range(POINTS):
            truth, as_printed, *as_corrected = formula.sides(Random(formula.label, index))
            printed.append(residual(as_printed, truth))
            corrected += [residual(value, truth) for value in as_corrected]
    worst, mended = max(printed), max(corrected, default=None)
    if worst < formula.threshold:
        verdict = "holds" if mended is None else "needless correction"
    elif mended is not None and mended < formula.threshold:
        verdict = "holds with a reading" if formula.reading else "corrected"
    else:
        verdict = "FAILS"
    return Finding(formula, worst, mended, verdict)
