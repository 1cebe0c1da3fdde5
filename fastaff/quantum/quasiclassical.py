"""Quasiclassical energy levels of separable bodies: Bohr-Sommerfeld and EBK."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.tori.action_angles import LARGEST_ACTION, energy_of_actions
from ..base.display import screen
from ..base.numbers import flag, nonnegative, positive, real, whole, whole_numbers
from ..base.recipe import recorded

BOHR_SOMMERFELD = (0, 0)
"""Maslov indices of the paper's quantization, J = n h."""

EBK = (2, 2)
"""Maslov indices of two librations between soft turning points, J = (n + 1/2) h; 3 for a libration with one hard wall.
"""


@dataclass(frozen=True)
class QuasiclassicalLevels:
    """Levels E (levels,) with their quantum numbers: n (2, levels) of the two coordinates, m of spin, l of vorticity.

    spacing (2, levels): h nu of the two coordinates, the energy of one more quantum to first order. status (levels,):
    UNBOUND where no torus has these actions; E is NaN there.
    """

    names: tuple[str, ...]
    E: np.ndarray
    n: np.ndarray
    m: np.ndarray
    l: np.ndarray
    spacing: np.ndarray
    maslov: tuple[int, int]
    hbar: float
    status: np.ndarray

    def __repr__(self) -> str:
        return screen(self)

    def degeneracies(self, *, tolerance: float = 1e-9) -> tuple[np.ndarray, np.ndarray]:
        """Return the distinct energies, relative `tolerance` apart, and how many of the levels each has.

        Source: Martens & Slawianowski, section 4 (degeneracy of the Bohr-Sommerfeld levels).
        """
        tolerance = nonnegative("tolerance", tolerance)
        E = np.sort(self.E[np.isfinite(self.E)])
        if E.size == 0:
            return E, np.zeros(0, np.int64)
        first = np.concatenate([[True], np.diff(E) > tolerance * np.abs(E[1:])])
        return E[first], np.diff(np.append(np.flatnonzero(first), E.size))


LONGEST_ROW = 2**20
"""Levels that differ in one quantum number only, below an energy: more are not listed."""


@recorded
def quasiclassical_levels(
    body: Any,
    *,
    n: ArrayLike,
    m: ArrayLike,
    l: ArrayLike,
    maslov: tuple[int, int] = EBK,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Any = None,
    near: ArrayLike | None = None,
) -> QuasiclassicalLevels:
    """Compute quasiclassical levels of a separable body for given quantum numbers.

    Parameters: n (2,) or (2, levels), whole numbers >= 0 of the two coordinates in the chart's order; m, l: whole
    numbers of spin and vorticity, one or (levels,); maslov: the indices M of the two coordinates, BOHR_SOMMERFELD = (0,
    0), EBK = (2, 2), or others; hbar > 0; single_valued: wave functions on GL(2,R) need m + l even (else refused),
    False: on the covering; chart, near as in `from_action_angles`. Returns QuasiclassicalLevels. Raises ValueError or
    TypeError for wrong input. Formulas: E(J) with J_i = 2 pi hbar (n_i + M_i/4), J_phi = 2 pi hbar m, J_psi = 2 pi hbar
    l. Exact (EBK) for Harmonic and Anharmonic in both charts; for Hyperelastic the effective index of vartheta lies
    between 2 and 3 (the wall at det = 0). Cost: that of `energy_of_actions`, about 20 microseconds for a level by
    quadrature. Source: Martens & Slawianowski, EQ3.2 and EQ3.6 (with m + l even, which they lack); Keller 1958, Ann.
    Phys. 4, 180 (EBK).
    """
    h = 2 * np.pi * positive("hbar", hbar)
    flag("single_valued", single_valued)
    quanta = [whole_numbers(name, value) for name, value in (("n", n), ("m", m), ("l", l))]
    if quanta[0].ndim not in (1, 2) or quanta[0].shape[0] != 2 or np.any(quanta[0] < 0):
        raise ValueError(f"n must have shape (2,) or (2, levels) and be >= 0, got {n!r}")
    indices = tuple(whole("maslov", index, 0) for index in maslov) if isinstance(maslov, (tuple, list)) else ()
    if len(indices) != 2:
        raise ValueError(f"maslov must be two indices such as EBK = (2, 2), got {maslov!r}")
    sizes = {q.size for q in (quanta[0][0], quanta[1], quanta[2])} - {1}
    if len(sizes) > 1 or quanta[1].ndim > 1 or quanta[2].ndim > 1:
        raise ValueError(
            f"n, m and l must be single or have the same number of levels, got {[q.shape for q in quanta]}"
        )
    n1, n2, spin, vorticity = np.broadcast_arrays(
        *(q.ravel() for q in (quanta[0][0], quanta[0][1], quanta[1], quanta[2]))
    )
    odd = np.flatnonzero((spin + vorticity) % 2)
    if single_valued and odd.size:
        raise ValueError(
            f"m + l must be even: (phi + pi, psi + pi) is the same matrix; got m = {spin[odd[0]]}, l = "
            f"{vorticity[odd[0]]} "
            "(single_valued=False takes them, on the covering)"
        )
    J = h * np.array([n1 + indices[0] / 4, n2 + indices[1] / 4, spin, vorticity])
    if not np.abs(J).max() < LARGEST_ACTION:
        raise ValueError(
            f"hbar times the quantum numbers must be below {LARGEST_ACTION / (2 * np.pi):.3g}, got hbar = {hbar!r}"
        )
    result = energy_of_actions(body, J, chart=chart, near=near)
    numbers = np.array([n1, n2]), spin.copy(), vorticity.copy()
    pair = (indices[0], indices[1])
    return QuasiclassicalLevels(
        result.names, result.energy, *numbers, h * result.nu[:2], pair, float(hbar), result.status
    )


@recorded
def quasiclassical_levels_below(
    body: Any,
    energy: float,
    *,
    maslov: tuple[int, int] = EBK,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Any = None,
) -> QuasiclassicalLevels:
    """Compute all quasiclassical levels of a separable body below an energy, in ascending order.

    Parameters: energy, finite; maslov, hbar, single_valued, chart as in `quasiclassical_levels`. Returns
    QuasiclassicalLevels, perhaps of no level. Raises ValueError or TypeError for wrong input. Formula: E(J) grows with
    both actions and with |J_eta| and |J_gamma|, so the search stops at the first level above in each direction; each
    level of m - l, m + l other than 0 comes with both signs. Actions that belong to no torus (bodies that fall or
    escape) end their direction too. Source: Martens & Slawianowski, EQ3.2 and EQ3.6; Keller 1958, Ann. Phys. 4, 180.
    """
    top = real("energy", energy)
    rows = list(_search(body, top, maslov, hbar, 2 if flag("single_valued", single_valued) else 1, chart))
    signed = [
        (n1, n2, (g + e) // 2, (g - e) // 2)
        for n1, n2, eta, gamma in rows
        for e in sorted({eta, -eta})
        for g in sorted({gamma, -gamma})
    ]
    table = np.array(signed, dtype=np.int64).reshape(-1, 4).T
    if table.shape[1] == 0:
        table = np.zeros((4, 1), np.int64)
    found = quasiclassical_levels(
        body, n=table[:2], m=table[2], l=table[3], maslov=maslov, hbar=hbar, single_valued=single_valued, chart=chart
    )
    order = np.argsort(found.E, kind="stable")
    order = order[found.E[order] < top]
    numbers = found.n[:, order], found.m[order], found.l[order], found.spacing[:, order]
    return QuasiclassicalLevels(found.names, found.E[order], *numbers, found.maslov, found.hbar, found.status[order])


def _search(
    body: Any, top: float, maslov: tuple[int, int], hbar: float, step: int, chart: Any
) -> Iterator[tuple[int, int, int, int]]:
    """Yield n1, n2, |m - l|, |m + l| of the levels below `top`; the last two have the same parity and grow by
    `step`.
    """

    def below(n1: np.ndarray, n2: int, eta: int, gamma: int) -> np.ndarray:
        levels = quasiclassical_levels(
            body,
            n=np.array([n1, np.full_like(n1, n2)]),
            m=(gamma + eta) // 2,
            l=(gamma - eta) // 2,
            maslov=maslov,
            hbar=hbar,
            single_valued=False,
            chart=chart,
        )
        return top > levels.E

    for parity in range(0, 2, step):  # the classes of even and of odd |m - l|, |m + l|
        for eta in count(parity, 2):
            found_eta = False
            for gamma in count(parity, 2):
                found_gamma = False
                for n2 in count():
                    n1, size = 0, 8
                    while True:
                        inside = below(np.arange(n1, n1 + size), n2, eta, gamma)
                        last = size if inside.all() else int(np.argmin(inside))
                        yield from ((n1 + k, n2, eta, gamma) for k in range(last))
                        n1 += last
                        if last < size:
                            break
                        size *= 2
                        if size > LONGEST_ROW:
                            raise ValueError(
                                f"hbar must be larger: more than {LONGEST_ROW} levels lie below the energy in one row"
                            )
                    if n1 == 0:
                        break
                    found_gamma = True
                if not found_gamma:
                    break
                found_eta = True
            if not found_eta:
                break
