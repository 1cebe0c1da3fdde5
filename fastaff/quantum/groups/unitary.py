"""Free motion on U(2), the compact form of GL+(2,R): its energy levels and its states.

A state is e^(i k a/2) times a function of SU(2). U(2) is U(1) x SU(2) with (a + 2 pi, u) and (a, -u) identified, so k
and 2 j are both even or both odd.

Source: Martens & Slawianowski, EQ6.16; the levels are derived.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.docstrings import inserts_parameters
from ...core.numbers import MOST, fits, positive, real, shown, whole
from ...core.status import Status
from ...results.calls import records_call
from ..exact.exact_levels import ROUNDING
from ..reference.rigid_tops import wigner_d
from ..states.level_table import LevelTable
from ..states.symmetry import action_quantum, whole_quantum

VOLUME = 32 * math.pi**3
"""Integral of sin(Theta) da dPhi dTheta dPsi over U(2)."""

WORDS = 24
"""Most numbers of eight bytes for each level while a table is made. 20 are measured."""

EQUAL = 1e-13
"""Largest relative difference of energies of one multiplet."""


class _Top(NamedTuple):
    """Constants of the levels: hbar^2/(2 mu) and 1 + c."""

    quantum: float
    weight: float

    def parts(self, k: Any, twice_j: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return E_a and E_Theta."""
        k = np.asarray(k, float)
        twice_j = np.asarray(twice_j, float)
        return self.quantum * k * k / self.weight, self.quantum * twice_j * (twice_j + 2)


@records_call
@inserts_parameters
def unitary_levels(
    *,
    inertia: float = 1.0,
    c: float = 0.0,
    k: int | None = None,
    j: float | None = None,
    max_energy: float | None = None,
    multiplets: int | None = None,
    hbar: float = 1.0,
) -> LevelTable:
    """Compute energy levels of free motion on U(2): one multiplet, or all of the lowest.

    Parameters
    ----------
    inertia : float, default 1
        Inertia mu, positive: T = (mu/2) (ds/dt)^2.
    c : float, default 0
        Weight of the dilatational term of the metric, above -1.
    k : int, optional
        Quantum number of the phase: the state is e^(i k a/2). Give `k` and `j`, or `max_energy`, or `multiplets`.
    j : float, optional
        Quantum number of SU(2), an integer or half-integer of at least 0; k + 2 j is even.
    max_energy : float, optional
        Energy below which all levels are returned, ascending.
    multiplets : int, optional
        Number of different energies. All their levels are returned, ascending.
    {hbar}

    Returns
    -------
    LevelTable
        One level for each state. n has k and n_Theta = j - max(``|m|``, ``|l|``)/2, the constants are E_a and E_Theta.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If k + 2 j is odd, c is not above -1, or an argument has another wrong value.

    Notes
    -----
    - E = (hbar^2/2 mu) (k^2/(1 + c) + 4 j (j + 1)), (2 j + 1)^2 times for each k.
    - k and -k have the same energy. Further coincidences depend on c.
    - m and l are those of e^(i (m Phi - l Psi)/2), as for a body: Phi = 2 phi, Psi = -2 psi. m + l and m + k are even.
    - k + 2 j is even because (a + 2 pi, -u) and (a, u) are the same matrix.
    - U(2) is compact: the spectrum is discrete, with finite multiplets.
    - Exact to round-off.

    References
    ----------
    Martens & Slawianowski, EQ6.16 (the metric); the levels are derived.

    Examples
    --------
    >>> levels = fa.quantum.unitary_levels(multiplets=4).multiplets()
    >>> levels.E, levels.degeneracy
    (array([0., 2., 4., 6.]), array([ 1, 10,  9, 26]))
    """
    constants = _constants(inertia, c, hbar)
    top = _Top(constants.hbar**2 / (2 * constants.mu), constants.weight)
    given = [name for name, value in (("max_energy", max_energy), ("multiplets", multiplets)) if value is not None]
    if (k is not None or j is not None) + len(given) != 1 or (k is None) != (j is None):
        raise ValueError(
            f"give k and j, or max_energy, or multiplets, got k = {shown(k, 12)}, j = {shown(j, 12)}, max_energy = "
            f"{shown(max_energy, 12)}, multiplets = {shown(multiplets, 12)}"
        )
    if max_energy is not None:
        end = real("max_energy", max_energy)
        pairs = _pairs(top, end, "max_energy")
        return _levels("max_energy", top, pairs, constants.hbar, end)
    if multiplets is not None:
        return _lowest(top, whole("multiplets", multiplets, 1), constants.hbar)
    return _levels("j", top, np.array([_charge_and_spin(k, j)]).T, constants.hbar, -math.inf)


class _Constants(NamedTuple):
    mu: float
    weight: float
    hbar: float


def _constants(inertia: Any, c: Any, hbar: Any) -> _Constants:
    """Return the inertia, 1 + c and hbar, checked."""
    size = positive("inertia", inertia)
    weight = 1 + real("c", c)
    if not weight > 0:
        raise ValueError(f"c must be above -1, got {shown(c)}. Elsewhere the metric of U(2) is not positive.")
    return _Constants(size, weight, action_quantum(hbar, size * min(1.0, weight)))


def _charge_and_spin(k: Any, j: Any) -> tuple[int, int]:
    """Return k and 2 j of one state; raises ValueError where k + 2 j is odd."""
    charge = whole_quantum("k", k)
    if abs(charge) > MOST:
        raise ValueError(f"k must be at most 2**53 in size, got {shown(k)}")
    twice = 2 * real("j", j)
    if twice < 0 or not twice.is_integer():
        raise ValueError(f"j must be an integer or half-integer of at least 0, got {shown(j)}")
    if (charge + int(twice)) % 2:
        raise ValueError(
            f"k + 2 j must be even, got k = {charge}, j = {shown(j)}. (a + 2 pi, -u) and (a, u) are the same matrix."
        )
    return charge, int(twice)


def _pairs(top: _Top, end: float, name: str) -> np.ndarray:
    """Return k and 2 j (2, pairs) of all energies below `end`; raises ValueError if they are too many."""
    rise = max(end, 0.0) / top.quantum
    spins = math.sqrt(rise + 1)
    charges = math.sqrt(rise * top.weight)
    fits(name, 8, int(min((spins + 1) * (2 * charges + 3), 1e18)))
    twice_j = np.arange(int(spins) + 1)
    k = np.arange(-int(charges) - 1, int(charges) + 2)
    both = np.array(np.meshgrid(k, twice_j, indexing="ij")).reshape(2, -1)
    both = both[:, both.sum(axis=0) % 2 == 0]
    return both[:, sum(top.parts(*both)) < end]


def _lowest(top: _Top, multiplets: int, hbar: float) -> LevelTable:
    """Return the levels of the lowest multiplets: enough different energies have j = 0, 1, ..., `multiplets` of k = 0,
    and k = 0, 2, ..., 2 `multiplets` of j = 0, which are lower for a large c.
    """
    fits("multiplets", 10, multiplets)
    end = float(min(sum(top.parts(0, 2 * multiplets)), sum(top.parts(2 * multiplets, 0)))) * (1 + 4 * EQUAL)
    pairs = _pairs(top, end, "multiplets")
    E = np.sort(sum(top.parts(*pairs)))
    first = np.flatnonzero(np.append(True, np.diff(E) > EQUAL * E[1:]))
    after = float(E[first[multiplets]])
    kept = pairs[:, sum(top.parts(*pairs)) < after * (1 - EQUAL / 2)]
    return _levels("multiplets", top, kept, hbar, after)


def _levels(name: str, top: _Top, pairs: np.ndarray, hbar: float, complete_below: float) -> LevelTable:
    """Return the table of all states of the multiplets k, 2 j, ascending; `name` is the argument that bounds them."""
    fits(name, WORDS, int(((pairs[1] + 1.0) ** 2).sum()))
    k, twice, m, l = _states(*pairs)
    parts = np.array(top.parts(k, twice))
    E = parts.sum(axis=0)
    order = np.argsort(E, kind="stable")
    n = np.array([k, (twice - np.maximum(np.abs(m), np.abs(l))) // 2])
    return LevelTable(
        E=E[order],
        error=ROUNDING * E[order],
        status=np.full(E.shape, Status.OK),
        n=n[:, order],
        names=("a", "Theta"),
        m=m[order],
        l=l[order],
        constants=parts[:, order],
        constant_names=("E_a", "E_Theta"),
        hbar=hbar,
        method="closed form on U(2)",
        complete_below=complete_below,
    )


def _states(k: np.ndarray, twice_j: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return k, 2 j, m, l of all states of the multiplets, (2 j + 1)^2 each."""
    sizes = (twice_j + 1) ** 2
    number = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    k, twice = np.repeat(k, sizes), np.repeat(twice_j, sizes)
    m, l = (2 * part - twice for part in np.divmod(number, twice + 1))
    return k, twice, m, l


def unitary_wave(q: ArrayLike, *, k: int, j: float, m: int, l: int) -> np.ndarray:
    """Compute a stationary state of free motion on U(2).

    Parameters
    ----------
    q : array_like, shape (4, ...)
        Coordinates a, Phi, Theta, Psi of the matrix e^(i a/2) exp(Phi tau_2) exp(Theta tau_3) exp(Psi tau_2), in
        radians, with Theta in [0, pi].
    k : int
        Quantum number of the phase.
    j : float
        Quantum number of SU(2), an integer or half-integer of at least 0; k + 2 j is even.
    m, l : int
        Spin and vorticity: 2 j, 2 j - 2, ..., -2 j.

    Returns
    -------
    ndarray of complex, shape (...)
        Values of the state.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the quantum numbers belong to no state on U(2), or Theta is outside [0, pi].

    Notes
    -----
    - sqrt((2 j + 1)/(32 pi^3)) e^(i (k a + m Phi - l Psi)/2) d^j_(m/2, -l/2)(Theta) with Wigner's d.
    - Norm: the integral of ``|psi|^2`` sin(Theta) da dPhi dTheta dPsi over U(2) is 1. a and Phi in [0, 2 pi), Theta in
      [0, pi] and Psi in [0, 4 pi) cover U(2) once.
    - The state does not depend on c.

    References
    ----------
    Martens & Slawianowski, EQ6.16, EQ4.10 (Wigner's functions, with -l).

    Examples
    --------
    >>> psi = fa.quantum.unitary_wave([0.3, 0.1, 1.2, 0.4], k=1, j=0.5, m=1, l=-1)
    >>> complex(psi.round(6))
    (0.03413+0.01443j)
    """
    rows = checked("q", q, (4,))
    charge, twice = _charge_and_spin(k, j)
    spin, vorticity = (whole_quantum(name, value) for name, value in (("m", m), ("l", l)))
    for name, value in (("m", spin), ("l", vorticity)):
        if abs(value) > twice or (value - twice) % 2:
            raise ValueError(f"{name} must be 2 j, 2 j - 2, ..., -2 j, got {value} for j = {twice / 2:g}")
    a, Phi, Theta, Psi = rows
    if not np.all((Theta >= 0) & (Theta <= math.pi)):
        raise ValueError(f"q must have Theta in [0, pi], got {Theta.min():g} to {Theta.max():g}")
    phase = np.exp(0.5j * (charge * a + spin * Phi - vorticity * Psi))
    return math.sqrt((twice + 1) / VOLUME) * phase * wigner_d(twice / 2, spin / 2, -vorticity / 2, Theta)
