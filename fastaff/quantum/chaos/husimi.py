"""Husimi functions: states seen by coherent states at points of phase space, over classical sections."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.numbers import positive, shown
from ...results.display import screen
from ...results.progress import says_progress
from ...results.result import Drawable
from ...systems.charts import ALPHA_BETA
from ..packets.coherent_packet import plane_widths
from ..states.angle_states import AngularClass
from ..states.factors import PlaneFactor
from ..states.state import State
from ..states.vibration_state import VibrationState

LARGEST = 640
"""Radial quanta of the largest expansion in each plane."""
ROOT2 = math.sqrt(2)
"""sqrt2 width is the length in which a coherent state is e^(-|q|^2/2)."""
CHUNK = 1 << 21
"""Numbers of the largest table at once, in points times radial quanta."""


@dataclass(frozen=True)
class Husimi(Drawable):
    """Husimi function of a state of a body: call it on phase points.

    The argument z has the shape (8, ...), with rows a1, a2, b1, b2 and their momenta.

    Attributes
    ----------
    coefficients : ndarray, shape (n_alpha, n_beta)
        Coefficients of the state in products of plane oscillators with radial quanta n.
    momenta : tuple of int
        Angular momenta ((m - l)/2, (m + l)/2) of the oscillators, in units of hbar.
    width : tuple of float
        Standard deviations of the positions of the coherent states in the planes a and b.
    hbar : float
        Planck's constant over 2 pi.
    """

    coefficients: np.ndarray
    momenta: tuple[int, int]
    width: tuple[float, float]
    hbar: float

    def __repr__(self) -> str:
        return screen(self)

    @property
    def norm(self) -> float:
        """Integral over phase space in cells of (2 pi hbar)^4: 1 less the missing part of the expansion."""
        return float(np.sum(self.coefficients**2))

    def __call__(self, z: ArrayLike) -> np.ndarray:
        """Return |<z|Psi>|^2 (...), between 0 and 1, at phase points z (8, ...), such as `Grid.z0` and `Sample.z0`."""
        points = checked("z", z, (8,))
        flat = points.reshape(8, -1)
        planes = [
            (flat[2 * i : 2 * i + 2], flat[2 * i + 4 : 2 * i + 6], ROOT2 * self.width[i], self.momenta[i])
            for i in (0, 1)
        ]
        out = np.empty(flat.shape[1])
        step = max(1, CHUNK // sum(self.coefficients.shape))
        for k in range(0, out.size, step):
            first, second = (
                _fock(q[:, k : k + step], p[:, k : k + step] / self.hbar, sigma, quanta, count)
                for (q, p, sigma, quanta), count in zip(planes, self.coefficients.shape, strict=True)
            )
            half = (first.real @ self.coefficients) + 1j * (first.imag @ self.coefficients)
            out[k : k + step] = np.abs(np.einsum("pn,pn->p", half, second)) ** 2
        return out.reshape(points.shape[1:])[()]


@dataclass(frozen=True)
class VibrationHusimi(Drawable):
    """Husimi function of a `VibrationState`: call it on phase points.

    The argument z has the shape (2n, ...): coordinates, then momenta.

    Attributes
    ----------
    state : VibrationState
        The state.
    width : tuple of float
        Standard deviation of the position of the coherent states for each coordinate.
    """

    state: VibrationState
    width: tuple[float, ...]

    def __repr__(self) -> str:
        return screen(self)

    @property
    def norm(self) -> float:
        """Integral over phase space in cells of (2 pi hbar)^n, equal to the integral of ``|Psi|^2``."""
        return float(np.sum(self.state.values**2))

    def __call__(self, z: ArrayLike) -> np.ndarray:
        """Return |<z|Psi>|^2 (...), between 0 and 1, at phase points z (2n, ...).

        Sums over the lattice are integrals for all waves that it resolves; the state has no shorter ones.
        """
        lattice = self.state.lattice
        width = np.array(self.width)[:, None, None]
        n = width.size
        points = checked("z", z, (2 * n,))
        flat = points.reshape(2 * n, -1)
        places = lattice.points(self.state.kept)
        cell = abs(float(np.linalg.det(lattice.R))) * float(np.prod(lattice.step))
        size = np.sqrt(cell / np.prod(np.sqrt(2 * np.pi) * width))
        out = np.empty(flat.shape[1])
        step = max(1, CHUNK // places.shape[1])
        for k in range(0, out.size, step):
            q = flat[:n, k : k + step, None]
            p = flat[n:, k : k + step, None]
            away = places[:, None] - q
            wave = np.exp(-((away / (2 * width)) ** 2).sum(axis=0)) * self.state.values
            phase = (p * away).sum(axis=0) / self.state.hbar
            out[k : k + step] = size**2 * (
                (wave * np.cos(phase)).sum(axis=1) ** 2 + (wave * np.sin(phase)).sum(axis=1) ** 2
            )
        short = np.abs(lattice.R.T @ flat[n:]) / self.state.hbar > np.pi / lattice.step[:, None]
        return np.where(short.any(axis=0), 0.0, out).reshape(points.shape[1:])[()]


def _of_vibration(state: VibrationState, width: ArrayLike | None) -> VibrationHusimi:
    """Return the Husimi function of a vibration; by default the coherent states have the state's own proportions."""
    lattice = state.lattice
    if lattice.around.any():
        angles = ", ".join(np.array(lattice.names)[lattice.around].tolist())
        raise ValueError(
            f"state must have no periodic coordinates for a Husimi function, got {angles}. Use state.density(q)."
        )
    if width is None:
        _, q, p = state.moments()
        width = np.sqrt(state.hbar / 2 * np.sqrt(np.diag(q) / np.diag(p)))
    widths = checked("width", width, ())
    n = len(lattice.names)
    if widths.shape not in ((), (n,)) or not np.all((widths > 1e-100) & (widths < 1e100)):
        raise ValueError(f"width must be one positive number or {n}, between 1e-100 and 1e100, got {shown(width)}")
    return VibrationHusimi(state, tuple(np.broadcast_to(widths, (n,)).tolist()))


@says_progress
def husimi(
    state: State | VibrationState, *, width: ArrayLike | None = None, tolerance: float = 1e-4
) -> Husimi | VibrationHusimi:
    """Compute the Husimi function of a state on the phase space of the body or the vibration.

    Parameters
    ----------
    state : State or VibrationState
        State of `wavefunction` or ``LevelTable.state``. The state of a body must have m + l even.
    width : float or array_like, optional
        Standard deviation of ``|Psi|^2`` of the coherent states in each direction of position, positive. One number,
        one for each of the planes a and b, or one for each coordinate of a vibration. Default: sqrt(hbar/2) for a body,
        sqrt(hbar dq/(2 dp)) with the spreads of the state for a vibration.
    tolerance : float, default 1e-4
        Largest part of the norm that the expansion may lack.

    Returns
    -------
    Husimi or VibrationHusimi
        Function of phase points, for example of the points of `energy_grid`, `energy_sample` and `poincare_map`.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If an argument has a wrong value, or 640 radial quanta in each plane do not hold the state to the tolerance.

    Notes
    -----
    - Q(z) = ``|<z|Psi>|^2`` with coherent states e^(-``|a - q|^2``/(4 width^2) + i p.a/hbar) of spreads width and
      hbar/(2 width). For a body they are four-dimensional and int Q d^8z/(2 pi hbar)^4 = 1.
    - The width sqrt(hbar/(2 mu omega)) belongs to an oscillation omega.
    - Q of a body is largest at p_eta = hbar (m - l)/2 and p_gamma = hbar (m + l)/2.
    - Accuracy: about sqrt(tolerance) of the largest amplitude, far better if the state is large.
    - Cost: 0.3 s for 40000 points at 100 quanta.

    References
    ----------
    Husimi 1940, Proc. Phys.-Math. Soc. Jpn. 22, 264; Bargmann 1961, Commun. Pure Appl. Math. 14, 187.

    Examples
    --------
    >>> state = fa.quantum.wavefunction(fa.Body(fa.Harmonic()), m=0, l=0, n=(0, 0))
    >>> Q = fa.quantum.husimi(state)
    >>> Q(np.zeros(8)).round(9), Q([1.0, 0, 0, 0, 0, 0, 0, 0]).round(9)
    (np.float64(1.0), np.float64(0.60653066))
    >>> levels = fa.quantum.spectrum(fa.hamiltonian("x**2/2", coordinates="x"), count=2)
    >>> fa.quantum.husimi(levels.state(1))([[0.0, 1.0], [0.0, 0.0]]).round(6)
    array([0.      , 0.303265])
    """
    if isinstance(state, VibrationState):
        positive("tolerance", tolerance)
        return _of_vibration(state, width)
    if not isinstance(state, State):
        raise TypeError(f"state must be a State, of `wavefunction` or `LevelTable.state`, got {type(state).__name__}")
    if isinstance(state.symmetry, AngularClass):
        raise ValueError("state must have m and l to have a Husimi function, got one of a body with angular potentials")
    m, l = state.symmetry
    if not state.symmetry.single_valued:
        raise ValueError(f"state must be single-valued (m + l even) to have a Husimi function, got m = {m}, l = {l}")
    tolerance = positive("tolerance", tolerance)
    hbar = positive("state.hbar", state.hbar)
    if not tolerance < 1:
        raise ValueError(f"tolerance must be below 1, got {shown(tolerance)}")
    sides = plane_widths(math.sqrt(hbar / 2) if width is None else width)
    momenta = ((m - l) // 2, (m + l) // 2)
    count = 40
    while True:
        found = Husimi(_coefficients(state, count, momenta, sides), momenta, sides, hbar)
        if found.norm >= 1 - tolerance:
            return found
        if count >= LARGEST:
            raise ValueError(
                f"state must fit in {count} radial quanta of width = {sides}, got {1 - found.norm:.2g} of its norm "
                "outside. Try another width or a larger tolerance."
            )
        count = min(2 * count, LARGEST)


def _coefficients(state: Any, count: int, momenta: tuple[int, int], width: tuple[float, float]) -> np.ndarray:
    """Return the expansion (count, count), by a Gauss rule of half as many nodes more."""
    radii = []
    tables = []
    for quanta, side in zip(momenta, width, strict=True):
        functions = [PlaneFactor(n, float(abs(quanta)), (ROOT2 * side) ** -2) for n in range(count)]
        x, weights = functions[0].rule(count + count // 2)
        # Far nodes have weights that overflow; all functions of the expansion are 0 there.
        table = np.array([f(x) for f in functions])
        radii.append(x)
        tables.append(np.where(np.isfinite(weights), table * np.where(np.isfinite(weights), weights, 0.0), 0.0))
    values = state.amplitude(radii[0][:, None], radii[1][None, :], ALPHA_BETA)
    return 2 * math.pi * tables[0] @ values @ tables[1].T


def _fock(q: np.ndarray, wave: np.ndarray, sigma: float, quanta: int, count: int) -> np.ndarray:
    """Return (-1)^n <z|n, M> (points, count) of one plane, the phase of z+^M left out; by logarithms, for nothing to
    overflow.
    """
    from scipy.special import gammaln, xlogy

    first, second = (q[i] / sigma + 1j * sigma * wave[i] for i in (0, 1))  # sqrt2 z_1, sqrt2 z_2
    turn = 1j if quanta >= 0 else -1j
    plus = (first - turn * second) / 2
    minus = (first + turn * second) / 2
    n = np.arange(count)
    more = np.arange(count) + abs(quanta)
    size = -(np.abs(plus) ** 2 + np.abs(minus) ** 2)[:, None] / 2 - (gammaln(n + 1) + gammaln(more + 1)) / 2
    size = size + xlogy(more, np.abs(plus)[:, None]) + xlogy(n, np.abs(minus)[:, None])
    return np.exp(size) * (-np.exp(-1j * (np.angle(plus) + np.angle(minus))))[:, None] ** n
