"""Terms of equations beside H = T(p) + V(q): all properties of one, in one value."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any

import numpy as np

from .jit import LANES

Rows = Sequence[Any] | np.ndarray
"""Rows of numbers, arrays or expressions."""


@dataclass(frozen=True, eq=False)
class Substep:
    """Exact solution of a term in splittings, together with each drift, dq/dt = v(p), or each kick, dp/dt = f(q).

    stage: "drift" or "kick". numbers(rate, length): coefficients of the flow over such a length, one for each of
    `names`, without branches. text(part, q, p, base), for a drift: change of the coordinates and momenta with these
    letters, in the rows of an orbit or vector, after the drift itself; for increments `base` has the numbers to
    which they are added. text(r, part, p), for a kick: row r of p after it, with f the slopes of the momenta at p.
    fallback(part, n, first), if given: text before a stage whose last number is positive, for the state in rows, for
    increments in rows from `first` on or, with None, for one orbit in scalars.

    The numbers of all stages of a step are kept in rows after the state, with the step that they belong to: zeros
    belong to the step 0. Splittings are palindromic, so the numbers of the first half are enough.
    """

    stage: str
    numbers: Callable
    names: tuple[str, ...]
    text: Callable[..., str]
    fallback: Callable[..., str] | None = None

    @property
    def _own(self) -> int:
        """Number of rows before the numbers: for the step and, if there are fallback stages, their count."""
        return 1 if self.fallback is None else 2

    def spare_rows(self, drifts: int, kicks: int) -> int:
        """Return the number of rows for the numbers of these drifts or kicks."""
        return self._own + len(self.names) * (((drifts if self.stage == "drift" else kicks) + 1) // 2)

    def made(self, first: int, rate: str, lanes: str, stages: str, step: str) -> str:
        """Text that makes the numbers, in rows from `first` on, where the step of a lane has changed."""
        own = f"z[{first * LANES} + i]"
        met = f"z[{(first + 1) * LANES} + i]"
        look = f"stale += 0 if {own} == {step} else 1\n"
        begin = f"{own} = {step}\n"
        keep = ""
        end = ""
        if self.fallback is not None:
            look = f"{look}beyond += {met}\n"
            begin = f"{begin}{met} = 0.0\n"
            keep = f"{met} += {self.names[-1]}\n"
            end = loop(f"beyond += {met}\n", 2, lanes)
        kept = "".join(f"z[row + {k * LANES} + i] = {name}\n" for k, name in enumerate(self.names))
        made = f"{', '.join(self.names)}, = numbers(rate, {stages}[s]*{step})\n"
        return (
            f"    stale, beyond = 0, 0.0\n{loop(look, 1, lanes)}"
            f"    if stale > 0:\n        rate, beyond = value.{rate}(), 0.0\n{loop(begin, 2, lanes)}"
            f"        for s in range(({stages}.size + 1)//2):\n"
            f"            row = {(first + self._own) * LANES} + {len(self.names) * LANES}*s\n"
            f"{loop(made + kept + keep, 3, lanes)}{end}"
        )

    def select_coefficients(self, first: int, stage: str, last: str) -> str:
        """Text that selects the numbers of a stage: in the second half of a step those of its mirror image.

        As separate arrays: loops over rows at distances that are not constant would not be vectorised.
        """
        begin = (first + self._own) * LANES
        text = f"row = {begin} + {len(self.names) * LANES}*min({stage}, {last} - {stage})\n"
        parts = (f"z[row + {k * LANES} : row + {(k + 1) * LANES}]" for k in range(len(self.names)))
        return text + "".join(f"{name}s = {part}\n" for name, part in zip(self.names, parts, strict=True))

    def before(self, parts: Sequence[range], n: int, first: int, stage: str) -> str:
        """Text before a drift of an orbit and its vectors, of n coordinates together."""
        text = self.select_coefficients(3 * first if first else 2 * n, stage, "kicks.size")
        if self.fallback is not None:
            fallback = self.fallback
            text += "if beyond > 0.0:\n" + loop("".join(fallback(part, n, first) for part in parts), 1)
        return text

    def moved(self, part: range, n: int, first: int) -> str:
        """Text of the change of the coordinates d of an orbit or vector after a drift, and of its momenta in their
        rows, from `first` on, which are increments if that is positive.
        """
        places = (("q", 0), ("p", n)) if first else ()
        base = {f"{letter}{r}": f"z[{(r + m) * LANES} + i] + " for r in part for letter, m in places}
        text = self.text(part, "d", "e", base)
        rows = [(f"e{r}", f"z[{(first + n + r) * LANES} + i]") for r in part if f"e{r} = " in text]
        begin, end = ("".join(f"{pair[k]} = {pair[1 - k]}\n" for pair in rows) for k in (0, 1))
        return self.loaded + begin + text + end

    @property
    def loaded(self) -> str:
        """Text that loads a lane's numbers of the selected stage."""
        return f"{', '.join(self.names)}, = {', '.join(f'{name}s[i]' for name in self.names)},\n"


@dataclass(frozen=True, eq=False)
class Term:
    """A term that equations of motion have beside H = T(p) + V(q).

    does: its description, with the methods that a model then has; rate: the method of its rate; equations: those of a
    kind that has it alone; has: text of refusals about a model with it. velocities(part), forces(part): text that adds
    to v, f of the rows of an orbit or vector, by q, p and `rate`; energy: text of its contribution to H.

    words: properties beside its name and the stage of its substep that traits and refusals (`runs.requirements`)
    depend on: "loss" where energy is not conserved, "noncanonical" where p are not conjugate to q. options: arguments
    of `formulas.hamiltonian`; options_rate(values, mass, q) makes the rate and the addition to V from their values by
    name; without it the rate is the one option; a `planar` term needs two coordinates of one mass.
    """

    does: str
    equations: str
    rate: str = ""
    has: str = ""
    velocities: Callable[[Sequence[int]], str] | None = None
    forces: Callable[[Sequence[int]], str] | None = None
    energy: str = "0"
    substep: Substep | None = None
    words: Set[str] = frozenset()
    options: tuple[str, ...] = ()
    options_rate: Callable[[Mapping[str, Any], Any, Rows], tuple[Any, Any]] | None = None
    planar: bool = False

    def slopes(self, part: Sequence[int]) -> str:
        """Text that adds to velocities and forces."""
        return "".join(made(part) for made in (self.velocities, self.forces) if made is not None)

    def added(self, letter: str, rate: Any, q: Rows, p: Rows, rows: Rows) -> list[Any]:
        """Return the rows of velocities ("v") or forces ("f"), numbers, arrays or expressions, with the term added."""
        made = self.velocities if letter == "v" else self.forces
        n = range(len(q))
        names = _named(rate, q, p) | {f"{letter}{r}": rows[r] for r in n}
        if made is not None:
            exec(_compiled(made(n), "exec"), names)
        return [names[f"{letter}{r}"] for r in n]

    def energies(self, rate: Any, q: Rows, p: Rows) -> Any:
        """Return its contribution to H, a number, an array or an expression."""
        return eval(_compiled(self.energy, "eval"), _named(rate, q, p))

    def of_options(self, values: Mapping[str, Any], mass: Any, q: Rows) -> tuple[Any, Any]:
        """Return the rate and the addition to V from options by name; mass: of the first coordinates."""
        return (values[self.options[0]], 0) if self.options_rate is None else self.options_rate(values, mass, q)


def _named(rate: Any, q: Rows, p: Rows) -> dict[str, Any]:
    rows = {f"{letter}{r}": row for letter, part in (("q", q), ("p", p)) for r, row in enumerate(part)}
    return {"rate": rate, **rows}


@functools.lru_cache
def _compiled(text: str, mode: str) -> Any:
    return compile(text, "<fastaff term>", mode)


def loop(body: str, depth: int, lanes: str = "lanes") -> str:
    """Text of a loop over lanes."""
    return indented(f"for i in range({lanes}):\n{indented(body, 1)}", depth)


def indented(text: str, depth: int) -> str:
    """Indented text."""
    return "".join(f"{' ' * 4 * depth}{line}\n" for line in text.splitlines())
