"""Exactly solvable bodies: energy levels, separation constants, multiplets, and the quasiclassical levels beside them.

Solvable are oscillators with walls V = k_alpha alpha^2/2 + c_alpha/alpha^2 + k_beta beta^2/2 + c_beta/beta^2 in (alpha,
beta), and V = k r/2 + c/r + (c_alpha/cos^2(vartheta/2) + c_beta/sin^2(vartheta/2))/r in (r, vartheta); `Harmonic` and
`Anharmonic` are both.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count as counting
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.tori.separation import Family, separate
from ..base.display import screen
from ..base.numbers import fits, flag, positive, real, whole, whole_numbers
from ..base.recipe import recorded
from ..models.functions import Barriers, Oscillator, Spring
from .quasiclassical import BOHR_SOMMERFELD, EBK, QuasiclassicalLevels, quasiclassical_levels
from .symmetry import action_quantum


class SolvableBody(NamedTuple):
    """An oscillator with walls in the chart of `family`: k, c of alpha and beta, the core c/r (r-vartheta only), mu,
    hbar.

    Source: Martens & Slawianowski, EQ3.1, EQa, EQb (section 5); walls elsewhere are derived, they only change the
    indices.
    """

    family: Family
    k: tuple[float, float]
    walls: tuple[float, float]
    core: float
    mu: float
    hbar: float

    @property
    def kappa(self) -> tuple[float, float]:
        """sqrt(k mu)/hbar of alpha and beta."""
        first, second = (float(np.sqrt(k * self.mu)) / self.hbar for k in self.k)
        return first, second

    @property
    def quanta(self) -> np.ndarray:
        """hbar omega of alpha and beta."""
        return self.hbar * np.sqrt(np.array(self.k) / self.mu)

    def indices(self, m: ArrayLike, l: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return s_alpha = sqrt(((m - l)/2)^2 + 2 mu c_alpha/hbar^2) and s_beta, the exponents at alpha = 0 and beta =
        0.

        Raises ValueError where a wall attracts more than the angular momentum holds.
        """
        spin, vorticity = np.asarray(m, float), np.asarray(l, float)
        squares = [
            ((spin + sign * vorticity) / 2) ** 2 + 2 * self.mu / self.hbar**2 * c
            for sign, c in zip((-1, 1), self.walls, strict=True)
        ]
        for square, c in zip(squares, self.walls, strict=True):
            if np.any(square < 0):
                raise ValueError(
                    f"body has a wall c = {c} that attracts below any energy for some m, l: 2 mu c/hbar^2 < -(m -+ "
                    "l)^2/4"
                )
        return np.sqrt(squares[0]), np.sqrt(squares[1])

    def angular_index(self, n_vartheta: ArrayLike, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return 2 n_vartheta + 1 + s_alpha + s_beta, the square root of 1 + 2 mu e_vartheta/hbar^2."""
        s_alpha, s_beta = self.indices(m, l)
        return 2 * np.asarray(n_vartheta) + 1 + s_alpha + s_beta

    def radial_index(self, n_vartheta: ArrayLike, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return 2 epsilon = sqrt(1 + 2 mu (e_vartheta + c)/hbar^2), the index of f_r."""
        square = self.angular_index(n_vartheta, m, l) ** 2 + 2 * self.mu * self.core / self.hbar**2
        if np.any(square < 0):
            raise ValueError(f"body has a core c = {self.core} that attracts below any energy")
        return np.sqrt(square)

    def constants(self, n: np.ndarray, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return the rows E_alpha, E_beta, or E, e_vartheta, of n (2, ...): eigenvalues of the chart's constants of
        motion.
        """
        if self.family.code == 0:
            s = self.indices(m, l)
            return np.array([quantum * (2 * n[i] + 1 + s[i]) for i, quantum in enumerate(self.quanta)])
        e = self.hbar**2 / (2 * self.mu) * (self.angular_index(n[1], m, l) ** 2 - 1)
        return np.array([self.quanta[0] * (2 * n[0] + 1 + self.radial_index(n[1], m, l)), e])

    def energy(self, n: np.ndarray, m: ArrayLike, l: ArrayLike) -> np.ndarray:
        """Return E of n (2, ...)."""
        constants = self.constants(n, m, l)
        return constants[0] + constants[1] if self.family.code == 0 else constants[0]


def solvable(body: Any, chart: Any = None, hbar: Any = 1.0) -> SolvableBody:
    """Return `body` as an exactly solvable one in `chart` (None: the first in which it separates).

    Raises TypeError or ValueError for wrong input, ValueError for a body without closed-form states there.
    """
    separated = separate(body, chart)
    quantum = action_quantum(hbar, separated.mu)
    first, second = separated.functions
    name = type(body.potential).__name__
    if not separated.isotropic:
        raise ValueError(
            f"body must be isotropic for m and l to be quantum numbers; {name} comes with angular potentials"
        )
    if isinstance(first, Oscillator) and isinstance(second, Oscillator):
        found = SolvableBody(separated.family, (first.k, second.k), (first.c, second.c), 0.0, separated.mu, quantum)
    elif isinstance(first, Spring) and isinstance(second, Barriers):
        walls = (second.c_alpha, second.c_beta)
        found = SolvableBody(separated.family, (first.k, first.k), walls, first.c, separated.mu, quantum)
    else:
        raise ValueError(
            f"body must have closed-form states in the {separated.family.chart} chart, as Harmonic and Anharmonic have "
            "in alpha-beta and "
            f"r-vartheta; {name} is {type(first).__name__} and {type(second).__name__} there"
        )
    for k in found.k:
        positive("k (C) of the body", k)
    return found


@dataclass(frozen=True)
class ExactLevels:
    """Levels E (levels,) with their quantum numbers: n (2, levels) of the two coordinates, m of spin, l of vorticity.

    names: alpha, beta or r, vartheta. constants (2, levels): the eigenvalues of `constant_names`, E_alpha and E_beta,
    or E and e_vartheta (with V_vartheta = 2 C/cos^2(vartheta/2) for Anharmonic; for the paper's 2 C tan^2(vartheta/2)
    it is 2 C less).
    """

    names: tuple[str, str]
    E: np.ndarray
    n: np.ndarray
    m: np.ndarray
    l: np.ndarray
    constants: np.ndarray
    constant_names: tuple[str, str]
    hbar: float

    def __repr__(self) -> str:
        return screen(self)

    @property
    def case(self) -> np.ndarray:
        """The paper's case of each level (levels,): 1 for |m| > |l|, 2 for |m| < |l|, 3 for |m| = |l| (below EQ5.1).

        The harmonic E is hbar omega (2 n + 2 + |m|), (2 n + 2 + |l|), and either.
        """
        return np.where(np.abs(self.m) > np.abs(self.l), 1, np.where(np.abs(self.m) < np.abs(self.l), 2, 3))


@recorded
def exact_levels(
    body: Any,
    *,
    n: ArrayLike,
    m: ArrayLike,
    l: ArrayLike,
    hbar: float = 1.0,
    chart: Any = None,
    single_valued: bool = True,
) -> ExactLevels:
    """Compute exact energy levels of a solvable body for given quantum numbers.

    Parameters: n (2,) or (2, levels), whole numbers >= 0 of the two coordinates in the chart's order; m, l: whole
    numbers of spin and vorticity, one or (levels,); hbar > 0, in the units of the actions; chart: ALPHA_BETA (default)
    or R_VARTHETA, which label the same levels differently; single_valued: wave functions on GL(2,R) need m + l even
    (else refused), False: on the covering. Returns ExactLevels. Raises ValueError or TypeError for wrong input and for
    bodies without closed-form states. Formulas: E_alpha = hbar omega (2 n_alpha + 1 + s_alpha), the same for beta;
    s_alpha = |m - l|/2 (Harmonic) or sqrt((m - l)^2 + 16 C mu/hbar^2)/2 (Anharmonic), s_beta = |m + l|/2; E = hbar
    omega (2 n_r + 1 + 2 epsilon), e_vartheta = (hbar^2/2 mu) ((2 n_vartheta + 1 + s_alpha + s_beta)^2 - 1). Exact to
    rounding; nanoseconds for a level. Source: Martens & Slawianowski, EQ5.1, EQ5.2, EQ3.2.2 (with m + l even;
    e_vartheta corrected).
    """
    model, flagged = solvable(body, chart, hbar), flag("single_valued", single_valued)
    quanta = whole_numbers("n", n)
    if quanta.ndim not in (1, 2) or quanta.shape[0] != 2 or np.any(quanta < 0):
        raise ValueError(f"n must have shape (2,) or (2, levels) and be >= 0, got {n!r}")
    spins = whole_numbers("m", m), whole_numbers("l", l)
    sizes = {q.size for q in (quanta[0], *spins)} - {1}
    if len(sizes) > 1 or spins[0].ndim > 1 or spins[1].ndim > 1:
        raise ValueError(
            f"n, m and l must be single or have the same number of levels, got {[q.shape for q in (quanta, *spins)]}"
        )
    n1, n2, spin, vorticity = (
        q.copy() for q in np.broadcast_arrays(*(q.ravel() for q in (quanta[0], quanta[1], *spins)))
    )
    odd = np.flatnonzero((spin + vorticity) % 2)
    if flagged and odd.size:
        raise ValueError(
            f"m + l must be even: (phi + pi, psi + pi) is the same matrix; got m = {spin[odd[0]]}, l = "
            f"{vorticity[odd[0]]} "
            "(single_valued=False takes them, on the covering)"
        )
    return _levels(model, np.array([n1, n2]), spin, vorticity)


def _levels(model: SolvableBody, n: np.ndarray, m: np.ndarray, l: np.ndarray) -> ExactLevels:
    names = ("E_alpha", "E_beta") if model.family.code == 0 else ("E", "e_vartheta")
    return ExactLevels(
        model.family.coordinates, model.energy(n, m, l), n, m, l, model.constants(n, m, l), names, model.hbar
    )


@recorded
def exact_levels_below(
    body: Any, energy: float, *, hbar: float = 1.0, chart: Any = None, single_valued: bool = True
) -> ExactLevels:
    """Compute all exact levels of a solvable body below an energy, in ascending order.

    Parameters: energy, finite; hbar, chart, single_valued as in `exact_levels`. Returns ExactLevels, perhaps of no
    level. Raises ValueError or TypeError for wrong input. Formula: E grows with both n and with |m - l| and |m + l|, so
    the list is complete; cost in proportion to its length. Source: Martens & Slawianowski, EQ5.1, EQ5.2.
    """
    model, top = solvable(body, chart, hbar), real("energy", energy)
    step = 2 if flag("single_valued", single_valued) else 1
    fits("energy", 10, _many(model, top, step))
    rows = [row for row in _search(model, top, step) if row.shape[1]]
    table = np.concatenate(rows, axis=1) if rows else np.zeros((4, 0), np.int64)
    order = np.argsort(model.energy(table[:2], table[2], table[3]), kind="stable")
    return _levels(model, table[:2, order], table[2, order], table[3, order])


def _many(model: SolvableBody, top: float, step: int) -> int:
    """Return about how many levels are below `top`: rather too many."""
    rise = top - float(model.energy(np.zeros((2, 1), np.int64), 0, 0)[0])
    if rise <= 0:
        return 0
    count = 1.0
    for quantum, s in zip(model.quanta, model.indices(0, 0), strict=True):
        x = min(rise / float(quantum), 1e70)
        count *= (x / 2 + 1) * (2 * np.sqrt(x * (x + 2 * float(s))) + 1)
    return int(count / (6 * step))


def _search(model: SolvableBody, top: float, step: int) -> Iterator[np.ndarray]:
    """Yield rows n1, n2, m, l (4, levels) of the levels below `top`, class by class."""

    def energy(n1: Any, n2: Any, eta: int, gamma: int) -> np.ndarray:
        return model.energy(np.array(np.broadcast_arrays(n1, n2)), (gamma + eta) / 2, (gamma - eta) / 2)

    def how_many(n1: int, n2: int, eta: int, gamma: int) -> int:
        """Number of levels in this direction; they are evenly spaced, or more than that, in both."""
        return next(k for k in counting() if energy(k * n1, k * n2, eta, gamma) >= top)

    for parity in range(0, 2, step):  # |m - l| and |m + l| are both even or both odd
        for eta in counting(parity, 2):
            if energy(0, 0, eta, parity) >= top:
                break
            for gamma in counting(parity, 2):
                if energy(0, 0, eta, gamma) >= top:
                    break
                box = np.indices((how_many(1, 0, eta, gamma), how_many(0, 1, eta, gamma))).reshape(2, -1)
                inside = box[:, energy(box[0], box[1], eta, gamma) < top]
                for signed_eta in sorted({eta, -eta}):
                    for signed_gamma in sorted({gamma, -gamma}):
                        m, l = (signed_gamma + signed_eta) // 2, (signed_gamma - signed_eta) // 2
                        yield np.concatenate(
                            [inside, np.full((1, inside.shape[1]), m), np.full((1, inside.shape[1]), l)]
                        )


@dataclass(frozen=True)
class Multiplets:
    """Distinct energies E (multiplets,) in ascending order, how many levels each has, and the levels themselves.

    degeneracy (multiplets,); levels: all of them, ascending; first (multiplets + 1,): where each multiplet begins in
    `levels`.
    """

    E: np.ndarray
    degeneracy: np.ndarray
    levels: ExactLevels
    first: np.ndarray

    def __repr__(self) -> str:
        return screen(self)

    def members(self, k: int) -> np.ndarray:
        """Return the quantum numbers (degeneracy, 4) of multiplet k, columns n1, n2, m, l."""
        k = whole("k", k, 0, self.first.size - 2)
        inside = slice(*self.first[[k, k + 1]])
        return np.column_stack([*self.levels.n[:, inside], self.levels.m[inside], self.levels.l[inside]])

    def labels(self, k: int) -> list[tuple[int, int, int]]:
        """Return the different (n1 + n2, |m + l|, |m - l|) of multiplet k: on what its energy depends where both planes
        are alike.
        """
        n1, n2, m, l = self.members(k).T
        return sorted(set(zip((n1 + n2).tolist(), np.abs(m + l).tolist(), np.abs(m - l).tolist(), strict=True)))


@recorded
def multiplets(
    body: Any,
    *,
    below: float | None = None,
    count: int | None = None,
    hbar: float = 1.0,
    chart: Any = None,
    single_valued: bool = True,
    tolerance: float = 1e-12,
) -> Multiplets:
    """Compute the distinct energies of a solvable body with their degeneracies, below an energy or the first `count`.

    Parameters: below, finite, or count >= 1, one of them; hbar, chart, single_valued as in `exact_levels`; tolerance in
    [0, 1): energies that differ relatively by no more are one. Returns Multiplets. Raises ValueError or TypeError for
    wrong input. Formulas: Harmonic: E = hbar omega (N + 2), C(N + 3, 3) times; Anharmonic: each (n1 + n2, m, l) comes
    n1 + n2 + 1 times. Source: Martens & Slawianowski, EQ5.1, EQ5.2 (with m + l even, which makes the harmonic levels
    those of the oscillator in R^4).
    """
    if (below is None) == (count is None):
        raise ValueError(f"give either below or count, got below = {below!r}, count = {count!r}")
    gap = real("tolerance", tolerance)
    if not 0 <= gap < 1:
        raise ValueError(f"tolerance must be at least 0 and below 1, got {tolerance!r}")
    if below is not None:
        return _grouped(exact_levels_below(body, below, hbar=hbar, chart=chart, single_valued=single_valued), gap)
    wanted = whole("count", count, 1)
    fits("count", 10, wanted)
    model = solvable(body, chart, hbar)
    zero = np.zeros((2, 1), np.int64)
    ground, rise = float(model.energy(zero, 0, 0)[0]), float(model.quanta.min())
    for k in counting(1):
        found = _grouped(
            exact_levels_below(body, ground + k * rise, hbar=hbar, chart=chart, single_valued=single_valued), gap
        )
        if found.E.size > wanted:  # one more, so that nothing within the tolerance is missing
            break
    levels, last = found.levels, found.first[wanted]
    cut = ExactLevels(
        levels.names,
        levels.E[:last],
        levels.n[:, :last],
        levels.m[:last],
        levels.l[:last],
        levels.constants[:, :last],
        levels.constant_names,
        levels.hbar,
    )
    return Multiplets(found.E[:wanted], found.degeneracy[:wanted], cut, found.first[: wanted + 1])


def _grouped(levels: ExactLevels, tolerance: float) -> Multiplets:
    new = np.ones(levels.E.size, bool)
    new[1:] = np.diff(levels.E) > tolerance * np.abs(levels.E[1:])
    first = np.append(np.flatnonzero(new), levels.E.size)
    return Multiplets(levels.E[first[:-1]], np.diff(first), levels, first)


class Quantizations(NamedTuple):
    """The same levels three times: by Bohr and Sommerfeld (J = n h), by EBK (J = (n + 1/2) h), exact.

    Source: Martens & Slawianowski, EQ3.2 and EQ3.6 beside EQ5.1 and EQ5.2.
    """

    bohr_sommerfeld: QuasiclassicalLevels
    ebk: QuasiclassicalLevels
    exact: ExactLevels

    def __repr__(self) -> str:
        return screen(self)

    @property
    def E(self) -> np.ndarray:
        """The energies, rows Bohr-Sommerfeld, EBK, exact (3, levels)."""
        return np.array([self.bohr_sommerfeld.E, self.ebk.E, self.exact.E])


def quantizations(
    body: Any,
    *,
    n: ArrayLike,
    m: ArrayLike,
    l: ArrayLike,
    hbar: float = 1.0,
    chart: Any = None,
    single_valued: bool = True,
) -> Quantizations:
    """Compute levels of a solvable body by Bohr and Sommerfeld, by EBK, and exactly.

    Parameters: n, m, l, hbar, chart, single_valued as in `exact_levels`. Returns Quantizations. Raises ValueError or
    TypeError for wrong input. Formula: Bohr-Sommerfeld lacks the zero point 2 hbar omega of two librations; EBK, with
    Maslov indices 2, 2, is exact. Source: Martens & Slawianowski, section 5, below EQ5.1; Keller 1958, Ann. Phys. 4,
    180 (EBK).
    """
    exact = exact_levels(body, n=n, m=m, l=l, hbar=hbar, chart=chart, single_valued=single_valued)
    first, second = (
        quasiclassical_levels(
            body,
            n=exact.n,
            m=exact.m,
            l=exact.l,
            maslov=maslov,
            hbar=exact.hbar,
            single_valued=single_valued,
            chart=chart,
        )
        for maslov in (BOHR_SOMMERFELD, EBK)
    )
    return Quantizations(first, second, exact)
