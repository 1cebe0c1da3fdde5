"""Quasiclassical levels of bodies with angular potentials: tori of alpha and beta, or r and vartheta, over levels of
both angles.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.numbers import shown, whole_numbers
from ...core.status import Status
from ...systems.models import Barriers, Body, Oscillator, SeparableAlphaBeta, SeparableRVartheta, Zero
from ...tori.families import ALPHA_BETA_FAMILY
from ...tori.inverse_tori import energy_of_actions
from ...tori.separation import Separated, separate
from ..states.level_table import LevelTable
from .angle_quanta import AngleQuanta
from .numbers_below import rows_below


class WithCentre(NamedTuple):
    """A function of alpha or beta with a centre c/x^2."""

    function: Any
    c: float

    def value(self, x):
        """Return V."""
        return self.function.value(x) + self.c / (x * x)

    def slope(self, x):
        """Return dV/dx."""
        return self.function.slope(x) - 2 * self.c / (x * x * x)


class WithBarriers(NamedTuple):
    """A function of vartheta with barriers or centres at alpha = 0 and beta = 0."""

    function: Any
    barriers: Barriers

    def value(self, vartheta):
        """Return V."""
        return self.function.value(vartheta) + self.barriers.value(vartheta)

    def slope(self, vartheta):
        """Return dV/dvartheta."""
        return self.function.slope(vartheta) + self.barriers.slope(vartheta)


class AngularTori:
    """The quasiclassical levels of one body with angular potentials; maslov: indices of both coordinates."""

    def __init__(
        self, model: Any, chart: Any, hbar: float, maslov: tuple[int, ...], single_valued: bool, guess: ArrayLike | None
    ):
        self.separated: Separated = separate(model, chart)
        if not self.separated.family.invertible:
            raise ValueError(f"chart must be alpha-beta or r-vartheta, got {self.separated.family.chart}")
        self.hbar = hbar
        self.h = 2 * np.pi * hbar
        self.maslov = np.array(maslov)
        self.guess = guess
        turns = 1 if single_valued else 2
        mu = self.separated.mu
        self.angles = [AngleQuanta(V, mu, self.h, turns) for V in self.separated.angular]

    def below(self, top: float) -> LevelTable:
        """Return all levels below an energy, ascending."""
        rows: list[np.ndarray] = [np.zeros((4, 0), np.int64)]
        eta = 0
        while True:
            any_gamma = False
            gamma = 0
            while True:
                found = self._class_below(top, eta, gamma) if self._alike(eta, gamma) else None
                any_gamma |= found is not None and found.shape[1] > 0
                if found is not None and found.shape[1] == 0 and self._binds(1, gamma):
                    break
                if found is not None:
                    rows.append(found)
                gamma += 1
            if not any_gamma and self._binds(0, eta) and self._alike(eta, 0):
                break
            eta += 1
        return self.levels(np.concatenate(rows, axis=1)).ascending().below(top)

    def _binds(self, side: int, k: int) -> bool:
        """Return whether a level of an angle has a torus and repels from the centre: higher ones repel more."""
        return self.angles[side].level(k) >= 0

    def _alike(self, eta: int, gamma: int) -> bool:
        """Return whether both functions have one period."""
        return self.angles[0].periodic(eta) == self.angles[1].periodic(gamma)

    def _class_below(self, top: float, eta: int, gamma: int) -> np.ndarray:
        """Return the quantum numbers (4, levels) of the levels of a pair of angular levels below an energy."""

        def energy(n):
            return self.levels(np.vstack([n, np.full(n.shape[1], eta), np.full(n.shape[1], gamma)])).E

        n = rows_below(energy, top)
        return np.vstack([n, np.full(n.shape[1], eta), np.full(n.shape[1], gamma)])

    def levels(self, n: np.ndarray) -> LevelTable:
        """Return the levels of quantum numbers n (4, levels)."""
        size = n.shape[1]
        c = np.array(
            [[angle.level(int(k)) for k in row] for angle, row in zip(self.angles, n[2:], strict=True)]
        ).reshape(2, size)
        E = np.full(size, np.nan)
        spacing = np.full((2, size), np.nan)
        status = np.full(size, int(Status.UNBOUND))
        known = np.isfinite(c).all(axis=0)
        attracting = np.where(known, np.minimum(c, 0.0), 0.0)
        for pair in np.unique(attracting[:, known], axis=1).T:
            some = np.flatnonzero(known & (attracting == pair[:, None]).all(axis=0))
            J = np.empty((4, some.size))
            J[:2] = self.h * (n[:2, some] + self.maslov[:, None] / 4)
            J_eta, J_gamma = 2 * np.pi * np.sqrt(2 * self.separated.mu * np.maximum(c[:, some], 0.0))
            J[2] = J_gamma + J_eta
            J[3] = J_gamma - J_eta
            found = energy_of_actions(
                self._centred(*pair.tolist()), J, chart=self.separated.family.chart, guess=self.guess
            )
            E[some] = found.energy
            spacing[:, some] = self.h * found.nu[:2]
            status[some] = found.status
        return LevelTable(
            E=E,
            error=QUADRATURE * np.abs(E),
            status=status,
            n=n,
            names=(*self.separated.family.coordinates, "eta", "gamma"),
            m=np.zeros(size, np.int64),
            l=np.zeros(size, np.int64),
            constants=c,
            constant_names=("c_eta", "c_gamma"),
            hbar=self.hbar,
            method=f"quasiclassical, Maslov indices {tuple(self.maslov.tolist())}; 2 for librations of angles",
            spacing=spacing,
        )

    def _centred(self, c_eta: float, c_gamma: float) -> Any:
        """Return the isotropic body whose potential has the centres of attracting levels of the angles."""
        first, second = self.separated.functions
        mu = self.separated.mu
        if self.separated.family == ALPHA_BETA_FAMILY:
            return Body(SeparableAlphaBeta(_with_centre(first, c_eta), _with_centre(second, c_gamma)), mu)
        return Body(SeparableRVartheta(first, _with_barriers(second, c_eta, c_gamma)), mu)


QUADRATURE = 5e-10
"""Assumed relative error of E(J): that of quadratures is some 1e-11."""


def _with_centre(V: Any, c: float) -> Any:
    if c == 0.0:
        return V
    return Oscillator(V.k, V.c + c) if isinstance(V, Oscillator) else WithCentre(V, c)


def _with_barriers(V: Any, c_alpha: float, c_beta: float) -> Any:
    if c_alpha == 0.0 == c_beta:
        return V
    known = Barriers(0.0, 0.0) if isinstance(V, Zero) else V
    if isinstance(known, Barriers):
        return Barriers(known.c_alpha + c_alpha, known.c_beta + c_beta)
    return WithBarriers(V, Barriers(c_alpha, c_beta))


def angular_quanta(n: Any, tori: AngularTori) -> np.ndarray:
    """Return quantum numbers n (4, levels); raises TypeError or ValueError for others."""
    rows = whole_numbers("n", n)
    if rows.ndim not in (1, 2) or rows.shape[0] != 4 or np.any(rows < 0):
        raise ValueError(f"n must have shape (4,) or (4, levels) and be >= 0 for angular potentials, got {shown(n)}")
    rows = rows.reshape(4, -1)
    unlike = [k for k in range(rows.shape[1]) if not tori._alike(int(rows[2, k]), int(rows[3, k]))]
    if unlike:
        raise ValueError(f"n must have levels of eta and gamma of one period, 2 pi or 4 pi, got {rows[2:, unlike[0]]}")
    return rows
