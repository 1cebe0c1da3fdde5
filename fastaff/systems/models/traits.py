"""Traits: the facts about a model that the rest of the package depends on, each determined once."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...engine.kinds import own_of, term, terms_of, velocity_bends, winding_of, words_of
from ...engine.terms import Substep, Term
from . import maps


@dataclass(frozen=True)
class Traits:
    """The facts about a model, each determined at its first use. Facts about a whole kind of motion follow from the
    terms of its equations (`engine.kinds.TERMS`), so that a user's own kind has all of them.
    """

    model: Any

    @cached_property
    def terms(self) -> Set[str]:
        """The terms of its equations beside H = T(p) + V(q)."""
        return terms_of(self.model)

    driven, frame, iterated, nonseparable = map(term, ("drive", "frame", "iterates", "nonseparable"))

    @cached_property
    def words(self) -> Set[str]:
        """Its terms and the properties of each, which refusals depend on."""
        return words_of(self.terms)

    @cached_property
    def own(self) -> Term | None:
        """The term that splittings solve with their drifts or kicks, if there is one."""
        return own_of(self.terms)

    @property
    def substep(self) -> Substep | None:
        """The exact solution of that term in splittings."""
        return None if self.own is None else self.own.substep

    @property
    def lossy(self) -> bool:
        """Whether its energy is lost."""
        return "loss" in self.words

    @property
    def canonical(self) -> bool:
        """Whether its rows are coordinates and their momenta, not variables of dz/dt = f(z)."""
        return "rates" not in self.terms

    @property
    def separable(self) -> bool:
        """Whether velocities depend on momenta and forces on coordinates alone, except for a term in a substep."""
        return not self.terms & {"rates", "iterates", "nonseparable"}

    @property
    def poles(self) -> bool:
        """Whether it has a method for its poles, which steps may miss."""
        return not self.iterated and _tells_of_poles(self.model)

    @property
    def energetic(self) -> bool:
        """Whether it has an energy, conserved or not."""
        return self.canonical and not self.iterated

    @property
    def conserves(self) -> bool:
        """Whether its motion conserves an energy, H + p_t for a driven system."""
        return self.energetic and not self.lossy

    @cached_property
    def symplectic(self) -> bool:
        """Whether its motion conserves the symplectic form; for a map by a test to rounding, at random points."""
        return maps.symplectic(self.model) if self.iterated else self.conserves and "noncanonical" not in self.words

    @cached_property
    def n(self) -> int:
        """Its number of degrees of freedom, with the time."""
        return self.model.degrees_of_freedom

    @property
    def moving(self) -> int:
        """The number of its coordinates without the time; also the row of the time."""
        return self.n - self.driven

    @cached_property
    def rows(self) -> int:
        """The number of rows of a phase point: 2n, or that of the variables of dz/dt = f(z)."""
        return 2 * self.n if self.canonical else len(self.model.coordinates)

    @property
    def positions(self) -> int:
        """The number of arguments of its margin: coordinates, or all variables."""
        return self.n if self.separable or self.iterated else self.rows

    @cached_property
    def winding(self) -> tuple[bool, ...]:
        """Which rows of a map have a period, () for other systems."""
        return winding_of(self.model)

    @cached_property
    def periods(self) -> tuple[float, ...]:
        """The periods of its coordinates that are angles, 0 for the others; of all variables of dz/dt = f(z)."""
        n = self.n if self.canonical else self.rows
        return tuple(map(float, getattr(self.model, "periods", lambda: (0.0,) * n)()[:n]))

    def turned_back(self, z: np.ndarray) -> np.ndarray:
        """Return phase points (2n, ...) with angles reduced, in place, to half a period around 0."""
        for row, period in zip(z, () if self.iterated else self.periods, strict=False):
            if period > 0:
                row -= period * np.floor(row / period + 0.5)
        return z

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of its coordinates, q1 to qn by default."""
        return tuple(getattr(self.model, "coordinates", [f"q{i + 1}" for i in range(self.n)]))

    @cached_property
    def row_names(self) -> tuple[str, ...]:
        """The names of the rows of a phase point: coordinates, then their momenta."""
        momenta = getattr(self.model, "momenta", [f"p_{name}" for name in self.names]) if self.canonical else ()
        return (*self.names, *momenta)

    @cached_property
    def planar(self) -> bool:
        """Whether it is a body in the planes a and b: it has a potential and says whether it is isotropic."""
        return hasattr(self.model, "potential") and hasattr(self.model, "isotropic")

    @cached_property
    def isotropic(self) -> bool:
        """Whether it is a body in the planes a and b whose angular momenta p_eta and p_gamma are conserved."""
        return bool(getattr(self.model, "isotropic", False))

    @cached_property
    def quadratic(self) -> bool:
        """Whether its kinetic energy is quadratic in the momenta: velocities are linear in them (the time's is 1)."""
        if not self.separable:
            return False
        p = np.linspace(0.3, 1.1, self.n)
        d = np.linspace(-0.7, 0.4, self.n)
        with np.errstate(all="ignore"):
            v, rest, change = (np.array(self.model.velocity(*at))[: self.moving] for at in (p, p + d, d))
        rest = rest - v - change
        return bool(np.abs(rest).max() <= 1e-12 * np.abs(v).max())

    @property
    def bends(self) -> bool:
        """Whether it has the change of its velocities along a vector."""
        return velocity_bends(self.model)

    @cached_property
    def curved(self) -> bool:
        """Whether it is T(p) + V(q), T not quadratic, and has the changes of velocities and forces along vectors."""
        return self.separable and self.bends and hasattr(self.model, "tangent_force") and not self.quadratic

    @property
    def newtonian(self) -> bool:
        """Whether accelerations are forces times inverse masses: it is T(p) + V(q), T quadratic or without a derivative
        of its velocities.
        """
        return self.separable and not self.curved

    @cached_property
    def of_degree_two(self) -> bool:
        """Whether H is of second degree in the momenta over each place, found at random points of all sizes."""
        return self.quadratic if self.separable else self.nonseparable and self._tried[0]

    @cached_property
    def ellipsoidal(self) -> bool:
        """Whether an energy allows an ellipsoid of momenta over each place: of second degree, with positive masses."""
        return self.quadratic if self.separable else self.of_degree_two and self._tried[1]

    @cached_property
    def _tried(self) -> tuple[bool, bool]:
        """Whether velocities are linear in the momenta, and the inverse masses positive definite, at the points
        tried.
        """
        n = self.n
        random = np.random.default_rng(11)
        count = 512
        q = random.standard_normal((n, count)) * 10.0 ** random.uniform(-2, 1, count)
        p, d = random.standard_normal((2, n, count)) * 10.0 ** random.uniform(-20, 20, count)
        zero = np.zeros((n, count))
        with np.errstate(all="ignore"):
            v0, v1, vd, both = (
                np.array(np.broadcast_arrays(*self.model.rates(*q, *p), p[0])[:n]) for p in (zero, p, d, p + d)
            )
            margins = [np.broadcast_to(self.model.margin(*q, *p), count) > 0 for p in (zero, p, d)]
            columns = [
                self.model.tangent_rates(*q, *zero, *zero, *np.repeat(row[:, None], count, 1)) for row in np.eye(n)
            ]
            W = np.array([np.broadcast_arrays(*column, p[0])[:n] for column in columns])
            size = np.abs(both) + np.abs(v1) + np.abs(vd) + np.abs(v0)
            kept = margins[0] & np.isfinite(size).all(axis=0) & np.isfinite(W).all(axis=(0, 1))
            linear = np.abs(both - v1 - vd + v0)[:, kept] <= 1e-9 * size.max(axis=0)[kept]
        same = all((margin == margins[0]).all() for margin in margins)
        if kept.sum() < count // 64 or not same or not linear.all():
            return False, False
        return True, bool((np.linalg.eigvalsh(np.moveaxis(W[..., kept], 2, 0)) > 0).all())


def _tells_of_poles(model: Any) -> bool:
    """Whether a model has a method for its poles, and so has the part that gives them."""
    own = getattr(model, getattr(model, "poles_of", ""), None)
    return hasattr(model, "poles") and (own is None or _tells_of_poles(own))
