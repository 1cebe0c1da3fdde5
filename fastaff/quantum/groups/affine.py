"""Spectra of bodies with affinely invariant kinetic energies, one class of spin and vorticity at a time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.numbers import kind_of, positive, whole
from ...systems.formulas.formula import hamiltonian
from ...systems.formulas.systems.bodies import AffineParts, affine_parts
from ...systems.models.contracts import Dynamics
from ..exact.exact_levels import ROUNDING
from ..solvers.singular_ends import sampled
from ..spectra.spectrum import spectrum
from ..states.level_table import LevelTable
from ..states.symmetry import SymmetryClass, action_quantum, checked_class
from .shear_series import BOTTOM, casimir, series, why_none

FAR = 300.0
"""ln(det) where the limits of a potential are read: det is e^(+-300), its square and root are within floats."""


class AffineSpectrum(NamedTuple):
    """Spectrum of an affinely invariant body in one class of spin and vorticity.

    Attributes
    ----------
    levels : LevelTable
        Discrete levels, ascending, possibly none. n has the quantum numbers of a = ln det phi and of the shear b =
        ln(D1/D2). The constants are E_a and E_b; E_b has the term of l or of m.
    threshold : float
        Lower end of the continuum of the class.
    error : float
        Error of the threshold.
    reason : str
        Why the class has these discrete levels, or none, in one sentence.
    """

    levels: LevelTable
    threshold: float
    error: float
    reason: str


class _Rates(NamedTuple):
    """Constants of H = -dilatation d^2/da^2 + shear L + rotor + V, each with hbar^2."""

    dilatation: float
    shear: float
    rotor: float


@inserts_parameters
def affine_spectrum(
    model: Dynamics,
    *,
    m: int,
    l: int,
    count: int = 1,
    hbar: float = 1.0,
    tolerance: float = 1e-10,
) -> AffineSpectrum:
    """Compute discrete levels and the continuum of a body with an affinely invariant kinetic energy.

    Parameters
    ----------
    model : model
        An `AffineBody` without potential, or with a potential of det alone.
    {spin_vorticity}
    count : int, default 1
        Number of levels of the dilatation, at least 1. Each has all discrete levels of the shear.
    {hbar}
    {levels_tolerance}

    Returns
    -------
    AffineSpectrum
        Discrete levels, lower end of the continuum, and the reason, for det > 0.

    Raises
    ------
    TypeError
        If the model is no `AffineBody`, or an argument has the wrong type.
    ValueError
        If V depends on more than det, I + A or I + A + 2 B is not positive, or an argument has a wrong value.
    NoGroundState
        If V is unbounded below or binds fewer than `count` levels of the dilatation. It is a `ValueError`.

    Notes
    -----
    - H = -hbar^2/(I + A + 2 B) d^2/da^2 + V + hbar^2/(I + A) L + hbar^2 I/(2 (I^2 - A^2)) (l^2 for "left", m^2 for
      "right"), the Laplacian of the invariant metric; I = 0 for "both". The measure is da sinh(b) db.
    - L has a continuum from 1/4 on, and k (1 - k) with k = min(``|m|``, ``|l|``)/2 - n > 1/2 if m l < 0.
    - Levels of the dilatation: `spectrum`. Without V it is free, and no level is discrete.
    - Infinitely many classes share a level: any m for "left", any l for "right". They lie in continua of other classes.
    - "both": unbounded below over all classes, because T has the signature (+++-).
    - Limits of V are read at det = e^-300 and e^300.

    References
    ----------
    Martens & Slawianowski, EQ6.17-EQ6.22 (corrected; levels are derived); Bargmann 1947, Ann. Math. 48, 568.

    Examples
    --------
    >>> body = fa.models.AffineBody("both", A=1.0, B=0.5, potential="log(det)**2")
    >>> found = fa.quantum.affine_spectrum(body, m=4, l=-4, count=2)
    >>> found.levels.E.round(6), round(found.threshold, 6)
    (array([-1.292893,  0.12132 ,  0.707107,  2.12132 ]), 0.957107)
    >>> fa.quantum.affine_spectrum(body, m=2, l=2).levels.E
    array([], dtype=float64)
    """
    parts = affine_parts(model)
    if parts is None:
        raise TypeError(f"model must be an AffineBody, got {kind_of(model)}")
    symmetry = checked_class(m, l)
    count = whole("count", count, 1)
    tolerance = positive("tolerance", tolerance)
    rates = _rates(parts, symmetry, action_quantum(hbar))
    shear = rates.shear * casimir(series(symmetry)) + rates.rotor
    least = min([rates.shear * BOTTOM + rates.rotor, *shear])
    reason = why_none(symmetry) or f"k = {', '.join(f'{k:g}' for k in series(symmetry))} of the discrete series"
    if not parts.potential:
        reason = f"the dilatation is free without a potential, so no level is discrete; shear: {reason}."
        return AffineSpectrum(_levels(None, shear[:0], symmetry, hbar), least, ROUNDING * abs(least), reason)
    dilatation = _dilatation(parts)
    found = spectrum(dilatation, count=count, hbar=hbar, tolerance=tolerance)
    bound = rates.shear * BOTTOM + rates.rotor + float(found.E[0])
    error = float(found.error[0]) + ROUNDING * (abs(bound) + abs(rates.rotor))
    limits = sampled(dilatation.potential_energy, np.array([-FAR, FAR]))
    free = float(limits.min()) + least
    threshold, error = (free, ROUNDING * abs(free)) if free < bound else (bound, error)
    return AffineSpectrum(_levels(found, shear, symmetry, hbar), threshold, error, f"shear: {reason}.")


def _rates(parts: AffineParts, symmetry: SymmetryClass, hbar: float) -> _Rates:
    """Return the constants of H; raises ValueError where the dilatation or the shear has a negative mass."""
    size = parts.I + parts.A
    whole_size = size + 2 * parts.B
    if not (size > 0 and whole_size > 0):
        raise ValueError(f"model must have I + A and I + A + 2 B positive, got {size:g} and {whole_size:g}")
    turn = {"left": symmetry.l, "right": symmetry.m, "both": 0}[parts.invariance]
    rotor = parts.I * turn**2 / (2 * size * (parts.I - parts.A)) if turn else 0.0
    return _Rates(hbar**2 / whole_size, hbar**2 / size, hbar**2 * rotor)


def _dilatation(parts: AffineParts) -> Any:
    """Return the dilatation as a system: p^2/(I + A + 2 B) + V(e^a)."""
    taken = parts.parameters
    names = [_unused(name, taken) for name in ("a", "p_a", "mass")]
    potential = parts.of_dilatation(names[0])
    given = {names[2]: parts.I + parts.A + 2 * parts.B, **taken}
    text = f"{names[1]}**2/{names[2]} + ({potential})"
    return hamiltonian(text, coordinates=names[0], momenta=names[1], **given)


def _unused(name: str, taken: dict[str, float]) -> str:
    """Return a name that no parameter has."""
    while name in taken:
        name += "_"
    return name


def _levels(found: LevelTable | None, shear: np.ndarray, symmetry: SymmetryClass, hbar: float) -> LevelTable:
    """Return all sums of levels of the dilatation and of the shear, ascending."""
    E_a = found.E if found is not None else np.empty(0)
    error_a = found.error if found is not None else np.empty(0)
    status_a = found.status if found is not None else np.empty(0, np.int64)
    n_a, n_b = (index.ravel() for index in np.indices((E_a.size, shear.size)))
    constants = np.array([E_a[n_a], shear[n_b]])
    E = constants.sum(axis=0)
    order = np.argsort(E, kind="stable")
    n_a, n_b, E, constants = n_a[order], n_b[order], E[order], constants[:, order]
    m, l = (np.full(E.shape, number) for number in symmetry)
    method = "discrete series of SL(2,R) in closed form"
    if found is not None:
        method += f"; dilatation: {found.method}"
    return LevelTable(
        E=E,
        error=error_a[n_a] + ROUNDING * np.abs(constants).sum(axis=0),
        status=status_a[n_a],
        n=np.array([n_a, n_b]),
        names=("a", "b"),
        m=m,
        l=l,
        constants=constants,
        constant_names=("E_a", "E_b"),
        hbar=float(hbar),
        method=method,
        functions=found.functions if found is not None else 0,
    )
