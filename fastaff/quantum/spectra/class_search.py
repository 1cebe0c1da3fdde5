"""The search for all levels of a body below an energy, class by class.

The classes are pairs of numbers, and the k-th level of a class grows with both (min-max principle): a class cannot have
more levels below an energy than its smaller neighbours have, and where one of them has none the search ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..states.level_table import LevelTable

Key = tuple[int, int]
"""The two numbers of a class."""
FIRST = 16
"""Levels of the lowest class to begin with where only an energy is given."""


class Ladder(NamedTuple):
    """The classes of a body: the step between neighbours and the lowest classes."""

    step: int
    seeds: tuple[Key, ...]

    def smaller(self, key: Key) -> list[Key]:
        """Return the neighbours with a smaller first or second number."""
        if key == (1, 1) and self.step == 2:
            return [(0, 0)]
        pairs = (key[0] - self.step, key[1]), (key[0], key[1] - self.step)
        return [(first, second) for first, second in pairs if min(first, second) >= 0]

    def bound(self, solved: dict[Key, LevelTable], key: Key) -> float:
        """Return a lower bound of the levels of a class that are still to be found."""
        if key in solved:
            return float(solved[key].E[-1])
        return max((float(solved[other].E[0]) for other in self.smaller(key)), default=-math.inf)

    def following(self, solved: dict[Key, LevelTable]) -> list[Key]:
        """Return the unsolved classes whose smaller neighbours are all solved."""
        candidates = dict.fromkeys(self.seeds) | dict.fromkeys(
            new for first, second in solved for new in ((first + self.step, second), (first, second + self.step))
        )
        return [new for new in candidates if new not in solved and all(other in solved for other in self.smaller(new))]

    def todo(self, solved: dict[Key, LevelTable], top: float) -> dict[Key, int]:
        """Return the classes that may have more levels up to `top`, and the numbers to compute: twice as many as
        before, or in a new class one more than its smaller neighbours have.
        """
        longer = {key: 2 * found.E.size for key, found in solved.items() if found.E[-1] - found.error[-1] <= top}
        if math.isinf(top):
            return longer
        inside = {key: int(np.count_nonzero(found.E - found.error <= top)) for key, found in solved.items()}
        new = {key: min(inside[other] for other in self.smaller(key)) for key in self.following(solved)}
        return longer | {key: levels + 1 for key, levels in new.items() if levels}

    def complete(self, solved: dict[Key, LevelTable]) -> float:
        """Return the energy below which no level is missing."""
        return min(self.bound(solved, key) for key in [*solved, *self.following(solved)])

    def share(self, solved: dict[Key, LevelTable], top: float) -> float:
        """Return the part of the energies up to `top` that is complete."""
        ground = min(float(found.E[0]) for found in solved.values())
        if not ground < top < math.inf:
            return 0.0
        return min(max((self.complete(solved) - ground) / (top - ground), 0.0), 1.0)
