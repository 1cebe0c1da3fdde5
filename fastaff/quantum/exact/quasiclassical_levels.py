"""Quasiclassical energy levels of bodies and vibrations: Bohr-Sommerfeld and EBK."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ...core.docstrings import inserts_parameters
from ...core.names import named
from ...core.numbers import flag, listed, positive, real, shown, text, whole
from ...results.calls import records_call
from ...runs.requirements import current_system
from ...systems.charts import Chart
from ...systems.models.body import Body
from ...systems.models.contracts import Dynamics, SeparableModel
from ...tori.inverse_tori import LARGEST_ACTION, energy_of_actions
from ...tori.separation import separate
from ..states.level_table import LevelTable
from ..states.modes import WAYS
from ..states.symmetry import checked_numbers, refuse_spins
from .angular_tori import AngularTori, angular_quanta
from .body_tori import BodyLevels, is_coupled, motion_of
from .mode_tori import bodies_alone, is_vibration, mode_levels
from .numbers_below import numbers_below

BOHR_SOMMERFELD = (0, 0)
"""Maslov indices of the paper's quantization, J = n h."""

EBK = (2, 2)
"""Maslov indices of two librations between soft turning points, J = (n + 1/2) h; 3 for a libration with one hard wall.
"""


QUADRATURE = 5e-10
"""Assumed relative error of E(J): that of quadratures is some 1e-11."""


@records_call
@inserts_parameters
def quasiclassical_levels(
    model: Dynamics,
    *,
    n: ArrayLike | None = None,
    m: ArrayLike | None = None,
    l: ArrayLike | None = None,
    max_energy: float | None = None,
    maslov: tuple[int, int] = EBK,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Chart | None = None,
    guess: ArrayLike | None = None,
    modes: str = "normal",
) -> LevelTable:
    """Compute semiclassical levels of a body or a vibration.

    Parameters
    ----------
    model : Body, StackelBody or model
        A body with a doubly isotropic potential or that separates, also with angular potentials, or a vibration:
        another system H = p.W p/2 + V(q) of one to three coordinates.
    n : array_like of int, shape (2,) or (2, levels), optional
        Quantum numbers of the two coordinates in the order of the chart, at least 0. For a body that does not separate,
        those of its two modes at fixed spin and vorticity. With angular potentials, the numbers of the levels of eta
        and gamma follow, shape (4,) or (4, levels). For a vibration, quantum numbers of its modes, shape (modes,) or
        (modes, levels). Give `n` or `max_energy`.
    m, l : int or array_like of int, shape (levels,), optional
        Quantum numbers of spin and vorticity. Required with `n` for a `Body` and not supported for other systems. For a
        body that does not separate, they restrict `max_energy` to their classes.
    max_energy : float, optional
        Energy below which all levels are computed, ascending. Levels of fitted tori that may lie below, but for which
        no torus was found, follow with energy NaN.
    maslov : tuple of int, default EBK
        Maslov indices M of the two coordinates: `BOHR_SOMMERFELD` = (0, 0), `EBK` = (2, 2) or others. For a body that
        does not separate, those of its two modes. A vibration has the indices of its tori.
    {hbar}
    {single_valued}
    {quantum_chart}
    guess : array_like, shape (2n,) or (2n, levels), optional
        For a separable body, a phase point in the intended potential well. For other systems, phase points near the
        tori, for example in a resonance. The quantum numbers `n` then belong to the angles of the torus that
        `fit_torus` finds there. Default: no guess.
    modes : {"normal", "local"}, default "normal"
        Modes of a vibration or of alpha and beta: normal modes, the fastest first, or the mode of each coordinate.

    Returns
    -------
    LevelTable
        Levels, with their ``spacing``; empty if no level lies below `max_energy`. The errors are those of E(J). They do
        not include the error of the semiclassical approximation.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the body neither separates nor is doubly isotropic, or if an argument has a wrong value.
    Interrupted
        On Ctrl-C.

    Notes
    -----
    - J_i = 2 pi hbar (n_i + M_i/4), J_phi = 2 pi hbar m, J_psi = 2 pi hbar l. Newton's method on `fit_torus` finds tori
      of vibrations and of bodies that do not separate.
    - Angular potentials: librations of an angle have J = (n + 1/2) h, rotations J = n h. Levels are numbered as those
      of `spectrum`.
    - EBK is exact for `Harmonic` and `Anharmonic`. For `Hyperelastic` the effective index of vartheta lies between 2
      and 3.
    - ``UNBOUND``: no torus has the actions. ``NOT_CONVERGED``: no torus was found, for example beyond a separatrix.
      Other modes may have one.
    - Searches below `max_energy` end, in each direction of n, at the first level above it, or at the second in
      succession without a torus.
    - Cost: 20 microseconds per level by quadrature; seconds per level by `fit_torus`.

    References
    ----------
    Martens & Slawianowski, EQ3.2 and EQ3.6 (with m + l even, which they lack), section 4 (degeneracy of the
    Bohr-Sommerfeld levels); Keller 1958, Ann. Phys. 4, 180 (EBK); Eastes & Marcus 1974, J. Chem. Phys. 61, 4301
    (coupled vibrations).

    Examples
    --------
    >>> body = fa.Body(fa.Harmonic())
    >>> fa.quantum.quasiclassical_levels(body, n=(1, 0), m=1, l=1).E.round(9)
    array([5.])
    >>> fa.quantum.quasiclassical_levels(body, n=(1, 0), m=1, l=1, maslov=fa.quantum.BOHR_SOMMERFELD).E.round(9)
    array([3.])
    """
    way = named("modes", text("modes", modes), WAYS)
    if is_vibration(model):
        tori_of_bodies = {"maslov": (maslov, EBK), "single_valued": (single_valued, True)}
        bodies_alone(model, {"m": (m, None), "l": (l, None), "chart": (chart, None)} | tori_of_bodies)
        return mode_levels(model, n, max_energy, guess, hbar, way, motion_of)
    if chart is None and is_coupled(model):
        levels_of = BodyLevels(cast(Body, model), hbar, way, None if maslov == EBK else _indices(maslov))
        flagged = flag("single_valued", single_valued)
        if (max_energy is None) == (n is None) or (m is None) != (l is None) or (n is not None and m is None):
            got = f"n = {shown(n, 12)}, m = {shown(m, 12)}, l = {shown(l, 12)}, max_energy = {shown(max_energy, 12)}"
            raise ValueError(f"give n, m and l, or max_energy with or without m and l, got {got}")
        if max_energy is None:
            return levels_of.numbered(n, m, l, guess, flagged)
        if guess is not None:
            raise ValueError("guess must be given without max_energy: a torus near a point has its own angles")
        return levels_of.below(real("max_energy", max_energy), m, l, flagged)
    if way != WAYS[0]:
        raise ValueError(f"modes is for vibrations and bodies that do not separate, got {shown(modes)}")
    separated = separate(model, chart)  # refuses a body without tori before its numbers are checked
    h = 2 * np.pi * positive("hbar", hbar)
    flagged = flag("single_valued", single_valued)
    indices = _indices(maslov)
    if not separated.isotropic or (current_system(model).planar and not current_system(model).isotropic and m is None):
        refuse_spins(m, l)
        tori = AngularTori(model, chart, float(hbar), indices, flagged, guess)
        if (n is None) == (max_energy is None):
            raise ValueError(f"give either n or max_energy, got n = {shown(n)}, max_energy = {shown(max_energy)}")
        return tori.levels(angular_quanta(n, tori)) if n is not None else tori.below(real("max_energy", max_energy))
    given = [name for name, value in {"n": n, "m": m, "l": l}.items() if value is not None]
    if max_energy is not None and given:
        raise ValueError(f"max_energy must be None with {listed(given)}, got {shown(max_energy)}")
    if max_energy is None and len(given) < 3:
        got = listed(given) if given else "None"
        raise ValueError(f"n, m and l must be given together, or max_energy alone, got {got}")

    def levels(n: np.ndarray, m: Any, l: Any) -> LevelTable:
        quanta = np.array(np.broadcast_arrays(*n, m, l))
        J = h * (quanta + np.array([indices[0] / 4, indices[1] / 4, 0, 0])[:, None])
        if not np.abs(J).max(initial=0.0) < LARGEST_ACTION:
            most = f"{LARGEST_ACTION / (2 * np.pi):.3g}"
            raise ValueError(f"hbar times the quantum numbers must be below {most}, got hbar = {shown(hbar)}")
        found = energy_of_actions(cast(SeparableModel, model), J, chart=chart, guess=guess)
        return LevelTable(
            E=found.energy,
            error=QUADRATURE * np.abs(found.energy),
            status=found.status,
            n=quanta[:2],
            names=found.names[:2],
            m=quanta[2],
            l=quanta[3],
            constants=np.zeros((0, quanta.shape[1])),
            constant_names=(),
            hbar=float(hbar),
            method=f"quasiclassical, Maslov indices {indices}",
            spacing=h * found.nu[:2],
        )

    if max_energy is None:
        return levels(*checked_numbers(n, m, l, flagged))
    top = real("max_energy", max_energy)
    numbers = numbers_below(lambda n, m, l: levels(n, m, l).E, top, flagged)
    if not numbers[1].size:
        return levels(np.zeros((2, 1), np.int64), 0, 0).take(slice(0))
    return levels(*numbers).ascending().below(top)


def _indices(maslov: Any) -> tuple[int, ...]:
    """Return two Maslov indices; raises TypeError or ValueError for others."""
    indices = tuple(whole("maslov", index, 0) for index in maslov) if isinstance(maslov, (tuple, list)) else ()
    if len(indices) != 2:
        raise ValueError(f"maslov must be two indices such as EBK = (2, 2), got {shown(maslov)}")
    return indices
