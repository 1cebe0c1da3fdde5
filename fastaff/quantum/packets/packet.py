"""Wave packets: superpositions of stationary states, their motion in time, autocorrelation and expectation values.

    Psi(t) = sum over k of c_k e^(-i E_k t/hbar) Psi_k

A `Packet` is energies, coefficients and states of any symmetry classes; the source of the states does not matter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.docstrings import inserts_parameters
from ...core.numbers import an_array, positive
from ...core.numbers import function as a_function
from ...engine.packing import run_points
from ...systems.charts import ALPHA_BETA, TWO_POLAR, Chart
from ..kernels.phases import phase_sums
from ..states.angle_states import AngularClass
from ..states.quadrature import resolved
from ..states.state import Product, State, checked_invariants, invariants_of
from ..states.symmetry import SymmetryClass


@dataclass(frozen=True)
class Packet:
    """Wave packet, a sum of stationary states.

    The coefficients are kept as given. After a projection, `missing` is the part of the packet that the states do not
    hold. Each state is evaluated once for all times.

    Parameters
    ----------
    states : tuple of State
        Stationary states of one body, of one or many symmetry classes.
    energies : ndarray, shape (states,)
        Energies.
    coefficients : ndarray of complex, shape (states,)
        Coefficients.
    hbar : float
        Planck's constant over 2 pi.
    """

    states: tuple[State, ...]
    energies: np.ndarray
    coefficients: np.ndarray
    hbar: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "states", tuple(self.states))
        object.__setattr__(self, "energies", _row("energies", self.energies, float, len(self.states)))
        object.__setattr__(self, "coefficients", _row("coefficients", self.coefficients, complex, len(self.states)))
        object.__setattr__(self, "hbar", positive("hbar", self.hbar))

    def __repr__(self) -> str:
        classes = len(self.classes)
        return (
            f"<Packet of {len(self.states)} states in {classes} class{'es' * (classes > 1)}, E = {self.energy:.6g} "
            f"+- {self.spread:.3g}>"
        )

    @property
    def weights(self) -> np.ndarray:
        """Share ``|c|^2`` of each state in the packet, shape (states,)."""
        return np.abs(self.coefficients) ** 2

    @property
    def missing(self) -> float:
        """Part of the packet that its states do not hold, 1 - sum of the weights."""
        return float(1 - self.weights.sum())

    @property
    def classes(self) -> dict[SymmetryClass | AngularClass, np.ndarray]:
        """Indices of the states of each symmetry class, a dict of ndarray."""
        found: dict[SymmetryClass | AngularClass, list[int]] = {}
        for place, state in enumerate(self.states):
            found.setdefault(state.symmetry, []).append(place)
        return {symmetry: np.array(places) for symmetry, places in found.items()}

    @property
    def energy(self) -> float:
        """Mean of E over the states held."""
        return float(np.average(self.energies, weights=self.weights))

    @property
    def spread(self) -> float:
        """Standard deviation of E over the states held."""
        return math.sqrt(np.average((self.energies - self.energy) ** 2, weights=self.weights))

    def norm(self) -> float:
        """Return the norm sqrt(sum ``|c|^2``), which does not depend on time.

        Returns
        -------
        float
            The norm.
        """
        return float(np.linalg.norm(self.coefficients))

    def evolved(self, time: float) -> Packet:
        """Return the packet at a later time.

        Parameters
        ----------
        time : float
            Time from now.

        Returns
        -------
        Packet
            The packet.
        """
        moment = _moments(time)
        if moment.ndim:
            raise ValueError(f"time must be one number, got shape {moment.shape}")
        return replace(self, coefficients=self._moved(moment.reshape(1))[0])

    def autocorrelation(self, time: ArrayLike) -> np.ndarray:
        """Return the autocorrelation A(t) = ``<Psi(0)|Psi(t)>`` = sum ``|c|^2`` e^(-i E t/hbar).

        Parameters
        ----------
        time : float or array_like
            Times.

        Returns
        -------
        ndarray of complex
            A, of the shape of `time`. ``|A|^2`` is norm^4 when the packet has revived.

        Notes
        -----
        - Accuracy: 1e-16 of the phases E t/hbar; in ``|A|`` only of the phases of E - `energy`.
        - Cost: 2.5 ns per state and time on one thread, and memory of a few times the result.
        """
        moments = _moments(time)
        mean = self.energy
        flat = np.ascontiguousarray(moments).reshape(-1)
        out = np.empty(flat.size, complex)
        rates = (self.energies - mean) / (2 * np.pi * self.hbar)
        run_points(phase_sums, (rates, self.weights, flat, out), flat.size)
        return (out * np.exp(-1j * mean / self.hbar * flat)).reshape(moments.shape)[()]

    def __call__(self, phi: ArrayLike, time: ArrayLike = 0.0) -> np.ndarray:
        """Return Psi, complex, at matrices phi (2, 2, ...)."""
        return self._sum(lambda state: state(phi), time)

    @inserts_parameters
    def planes(self, planes: ArrayLike, time: ArrayLike = 0.0) -> np.ndarray:
        """Return Psi at points of the planes.

        Parameters
        ----------
        planes : array_like, shape (4, ...)
            Rows a1, a2, b1, b2.
        {packet_time}

        Returns
        -------
        ndarray of complex
            Psi.
        """
        return self._sum(lambda state: state.planes(planes), time)

    @inserts_parameters
    def at(self, q: ArrayLike, chart: Chart = ALPHA_BETA, time: ArrayLike = 0.0) -> np.ndarray:
        """Return Psi at coordinates of a chart.

        Parameters
        ----------
        q : array_like, shape (4, ...)
            Coordinates.
        chart : Chart, default ALPHA_BETA
            Any chart.
        {packet_time}

        Returns
        -------
        ndarray of complex
            Psi.
        """
        return self._sum(lambda state: state.at(q, chart), time)

    @inserts_parameters
    def amplitude(self, x: ArrayLike, y: ArrayLike, chart: Chart | None = None, time: ArrayLike = 0.0) -> np.ndarray:
        """Return Psi e^(-i m phi - i l psi) of a packet of one symmetry class.

        Parameters
        ----------
        {invariant_values}
        {invariant_chart}
        {packet_time}

        Returns
        -------
        ndarray of complex
            The amplitude.

        Raises
        ------
        ValueError
            If the packet has several symmetry classes.
        """
        if len(self.classes) > 1:
            raise ValueError(
                f"amplitude requires a packet of one class (m, l), got {len(self.classes)}. Use density or at."
            )
        return self._sum(_amplitudes(x, y, ALPHA_BETA if chart is None else chart), time)

    @inserts_parameters
    def density(self, x: ArrayLike, y: ArrayLike, chart: Chart | None = None, time: ArrayLike = 0.0) -> np.ndarray:
        """Return the probability density of two invariants, summed over the symmetry classes.

        Parameters
        ----------
        {invariant_values}
        {invariant_chart}
        {packet_time}

        Returns
        -------
        ndarray
            Density per unit dx dy. Its integral is norm^2. In `TWO_POLAR` it is 0 outside of D1 >= ``|D2|``.
        """
        chosen = ALPHA_BETA if chart is None else chart
        invariants = invariants_of(chosen)
        first, second = checked_invariants(x, y, chosen)
        alpha, beta = invariants.to_radii(first, second)
        inside = (alpha >= 0) & (beta >= 0)
        if chosen.name == TWO_POLAR.name:
            first = np.where(inside, alpha, 0.0)
            second = np.where(inside, beta, 0.0)
            chosen = ALPHA_BETA
        measure = np.where(inside, 4 * math.pi**2 * alpha * beta * invariants.area, 0.0)
        evaluate = _amplitudes(first, second, chosen)
        return sum(np.abs(self._sum(evaluate, time, places)) ** 2 for places in self.classes.values()) * measure

    @inserts_parameters
    def expectation(
        self,
        function: Callable[[np.ndarray, np.ndarray], np.ndarray],
        *,
        chart: Chart | None = None,
        time: ArrayLike = 0.0,
    ) -> np.ndarray:
        """Return the mean of a function of two invariants over the packet, divided by norm^2.

        Parameters
        ----------
        function : callable
            Function of two arrays, the invariants, that returns real values.
        {invariant_chart}
        {packet_time}

        Returns
        -------
        ndarray
            Mean at each time.

        Raises
        ------
        ValueError
            If the quadrature does not normalise all states to 1e-9.

        Notes
        -----
        - Method: Gauss-Legendre quadrature over the reach of the states, refined until all states are normalised to
          1e-9.
        - Cost: about 1 ns per state, node (some 10^4) and time.
        """
        chosen = invariants_of(ALPHA_BETA if chart is None else chart)
        moments = _moments(time)
        a_function("function", function)
        classes = list(self.classes.values())
        tables, grid = resolved([[self.states[k] for k in places] for places in classes])
        values = np.asarray(function(*chosen.from_radii(*grid.radii)))
        if np.iscomplexobj(values):
            raise TypeError("function must return real values")
        if not np.isfinite(values).all():
            raise ValueError("function must return finite values where the states live")
        flat = moments.reshape(-1)
        weighted = (grid.weights * values).reshape(-1)
        total = np.zeros(flat.size)
        for start in range(0, flat.size, 512):
            for places, table in zip(classes, tables, strict=True):
                moved = self._moved(flat[start : start + 512], places)
                parts = np.concatenate([moved.real, moved.imag])
                for nodes, amplitudes in table.blocks(256):
                    square = (parts @ amplitudes) ** 2 @ weighted[nodes]
                    total[start : start + 512] += square[: len(moved)] + square[len(moved) :]
        return (total / self.weights.sum()).reshape(moments.shape)[()]

    def _moved(self, times: np.ndarray, places: Any = slice(None)) -> np.ndarray:
        """Return c e^(-i E t/hbar) (times, states)."""
        return self.coefficients[places] * np.exp(-1j / self.hbar * np.multiply.outer(times, self.energies[places]))

    def _sum(
        self, evaluate: Callable[[State], np.ndarray], time: ArrayLike, places: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the sum of states, each evaluated once and a few kept at a time."""
        moments = _moments(time)
        chosen = np.arange(len(self.states)) if places is None else places
        total: Any = 0.0
        for start in range(0, chosen.size, 16):
            some = chosen[start : start + 16]
            values = np.array([evaluate(self.states[k]) for k in some])
            total = total + np.tensordot(self._moved(moments.reshape(-1), some), values, axes=1)
        return np.reshape(total, (*moments.shape, *np.shape(total)[1:]))[()]


def _amplitudes(x: ArrayLike, y: ArrayLike, chart: Chart) -> Callable[[State], np.ndarray]:
    """Return a function that evaluates a state at invariants of a chart; a state with factors in it has them evaluated
    on x and y before they broadcast.
    """
    first, second = checked_invariants(x, y, chart)
    front = invariants_of(chart).front

    def evaluate(state: State) -> np.ndarray:
        if isinstance(state.shape, Product) and state.chart.name == chart.name:
            return front * state.shape.factors[0](first) * state.shape.factors[1](second)
        return state.amplitude(first, second, chart)

    return evaluate


def _moments(time: ArrayLike) -> np.ndarray:
    given = an_array("time", time)
    if given.dtype.kind not in "fiu":
        raise TypeError(f"time must be real numbers, got {given.dtype}")
    moments = given.astype(float)
    if not np.isfinite(moments).all():
        raise ValueError(f"time must be finite, got {moments[~np.isfinite(moments)][0]}")
    return moments


def _row(name: str, value: ArrayLike, kind: type, size: int) -> np.ndarray:
    given = an_array(name, value)
    if given.dtype.kind not in ("fiu" if kind is float else "fiuc"):
        raise TypeError(f"{name} must be {'real' if kind is float else 'complex'} numbers, got {given.dtype}")
    row: np.ndarray = given.astype(kind)
    if row.shape != (size,) or size == 0:
        raise ValueError(
            f"{name} must have one entry for each of the {size} states (at least 1), got shape {row.shape}"
        )
    if not np.isfinite(row).all():
        raise ValueError(f"{name} must be finite, got {row[~np.isfinite(row)][0]}")
    return row
