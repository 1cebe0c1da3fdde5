"""Rows of a state block: those of the orbit, of its vectors and of the time, and the texts of their slopes."""

from __future__ import annotations

from collections.abc import Iterable, Set
from dataclasses import dataclass

from .kinds import own_of
from .terms import Substep, Term

VECTORS_PER_LOOP = {1: 8, 2: 4, 3: 4, 4: 4}
"""Tangent vectors that one loop over lanes moves, by degrees of freedom (else 2): longer loops no longer vectorise."""

MOST_IN_SCALARS = 12
"""Most tangent vectors that steps of a single orbit keep in scalars. The 8 of a planar body take half as long again in
memory, where the 18 of a body in space take 0.9 of the time.
"""

CARRIED = """increment = change[i] + error[i]
whole = mine[i] + increment
error[i] = increment - (whole - mine[i])
mine[i] = whole
"""
"""Text that adds the change of a row to it with the rounding error carried over to the next (Kahan's summation)."""


@dataclass(frozen=True)
class StateRows:
    """Rows of a state block: positions, then momenta, of the orbit (n each) and of its tangent vectors (n each, one
    after another).

    terms: those of the equations, see `kinds.TERMS`. The time of a drive is no distance, and no vector changes it. It
    takes one addition a step, not one a stage, and is reduced by its period: over many periods the same rounding error
    in all steps would add up to a phase. variables: number of those of a system dz/dt = f(z), 2n for H(q, p), 0 for
    others; for an odd number the last row is idle; winding: which rows (2n,) of a map have a period, () for others.
    nonquadratic: whether velocities have a derivative of their own, tangent_velocity(p..., dp...); else T is quadratic.
    """

    n: int
    vectors: int
    terms: Set[str] = frozenset()
    variables: int = 0
    winding: tuple[bool, ...] = ()
    nonquadratic: bool = False

    @property
    def driven(self) -> bool:
        """Whether it has the row of the time of a drive."""
        return "drive" in self.terms

    @property
    def nonseparable(self) -> bool:
        """Whether its slopes are those of H(q, p)."""
        return "nonseparable" in self.terms

    @property
    def own(self) -> Term | None:
        """The term that splittings solve with their drifts or kicks, if there is one."""
        return own_of(self.terms)

    @property
    def substep(self) -> Substep | None:
        """The exact solution of that term in splittings."""
        return None if self.own is None else self.own.substep

    def solves(self, stage: str) -> Substep | None:
        """Return the substep that is solved together with that stage, if there is one."""
        return self.substep if self.substep is not None and self.substep.stage == stage else None

    @property
    def half(self) -> int:
        """The number of positions."""
        return self.n * (1 + self.vectors)

    @property
    def time(self) -> int | None:
        """The row of the time, if there is one."""
        return self.n - 1 if self.driven else None

    @property
    def shares(self) -> bool:
        """Whether lanes of one step have a separate text, which doubles the time of compilation: not beside the many
        vectors of a tangent map.
        """
        return self.solves("drift") is not None and self.vectors <= 2

    @property
    def orbit(self) -> list[int]:
        """The rows of the orbit itself."""
        return [*range(self.n), *range(self.half, self.half + self.n)]

    @property
    def all(self) -> range:
        """Numbers of the rows of a half."""
        return range(self.half)

    @property
    def groups(self) -> list[range]:
        """Numbers of the rows of a half that one loop moves: the orbit with its first vectors, then the other
        vectors. Vectors whose drifts depend on the orbit's momenta come before its kick, so in its own loop.
        """
        width = max(self.vectors, 1) if self.nonquadratic else VECTORS_PER_LOOP.get(self.n, 2)
        ends = [1 + min(self.vectors, width), *range(1 + 2 * width, 1 + self.vectors + width, width)]
        ends = [min(end, 1 + self.vectors) * self.n for end in ends]
        return [range(first, last) for first, last in zip([0, *ends], ends) if last > first]

    @property
    def repeated(self) -> list[range]:
        """The groups after the first that one text in a loop moves, if there are at least two: those of equal size.
        Numbers of a substep have other places for each.
        """
        _, *further = self.groups
        alike = [group for group in further if len(group) == len(further[0])]
        return alike if len(alike) > 1 and self.own is None else []

    @property
    def in_memory(self) -> bool:
        """Whether steps of a single orbit keep its vectors in memory: one text then serves all of them, and many have
        no room in registers.
        """
        return self.vectors > MOST_IN_SCALARS and self.own is None

    def parts(self, rows: range) -> list[range]:
        """These rows split by the orbit and the vectors that they belong to."""
        return [range(first, first + self.n) for first in range(rows.start, rows.stop, self.n)]

    def state(self, part: range) -> list[int]:
        """The rows of the variables of a system dz/dt = f(z), of the orbit or of one vector."""
        return [*part, *range(self.half + part.start, self.half + part.stop)][: self.variables]

    @property
    def place(self) -> list[int]:
        """The rows that determine the domain and the distance from the origin."""
        return self.state(range(self.n)) if self.variables else [*range(self.n)]

    def velocities(self, rows: range) -> str:
        """Text that sets the v of these rows to the velocities at p, or their change along a vector: where T is
        quadratic it follows from the vector's own momenta.
        """
        text = ""
        orbit = range(self.n)
        for part in self.parts(rows):
            call = f"velocity({listed('p', part)})"
            if self.nonquadratic and part != orbit:
                call = f"tangent_velocity({listed('p', orbit)}, {listed('p', part)})"
            text += f"{listed('v', part)}, = value.{call}\n"
            text += f"v{part[-1]} = 0.0\n" if self.driven and part.start > 0 else ""
        return text

    def forces(self, rows: range) -> str:
        """Text that sets the f of these rows to the force at q, or its change along a vector."""
        text = ""
        orbit = range(self.n)
        for part in self.parts(rows):
            call = (
                f"force({listed('q', orbit)})"
                if part == orbit
                else f"tangent_force({listed('q', orbit)}, {listed('q', part)})"
            )
            text += f"{listed('f', part)}, = value.{call}\n"
        return text + self._added("kick", rows)

    def slopes(self, rows: range) -> str:
        """Text that sets v and f of these rows to dq/dt and dp/dt."""
        text = self.velocities(rows) + self.forces(rows)
        return text + self._added("drift", rows)

    def _added(self, stage: str, rows: range) -> str:
        """Text that adds the contribution of the term solved with that stage to v and f of these rows."""
        if self.own is None or self.solves(stage) is None:
            return ""
        return f"rate = value.{self.own.rate}()\n" + "".join(map(self.own.slopes, self.parts(rows)))


def listed(letter: str, rows: Iterable[int]) -> str:
    """Text of the names of rows: "q0, q1"."""
    return ", ".join(f"{letter}{r}" for r in rows)
