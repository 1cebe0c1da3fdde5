"""Spectra of bodies with affinely invariant kinetic energies, one class of spin and vorticity at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.numbers import kind_of, positive, shown, whole
from ...core.status import Status
from ...results.progress import says_progress
from ...systems.formulas.systems.bodies import AffineParts, affine_parts
from ...systems.models.contracts import Dynamics
from ..exact.exact_levels import ROUNDING
from ..states.level_table import LevelTable
from ..states.symmetry import SymmetryClass, action_quantum, checked_class
from .dilatation import Dilatation, bound_dilatation
from .shear_levels import Shear, ShearRates, bound_shear, closed_shear, limit

SAMPLES = (np.linspace(-1.3, 1.1, 7)[:, None], np.linspace(0.15, 1.9, 5))
"""Values of a and b at which V(a, b) = V(a, 0) + V(0, b) - V(0, 0) is checked."""

SPLIT = 1e-9
"""Largest difference there, relative to V: that of rounding."""


class AffineSpectrum(NamedTuple):
    """Spectrum of an affinely invariant body in one class of spin and vorticity.

    Attributes
    ----------
    levels : LevelTable
        Discrete levels, ascending, possibly none. n has the quantum numbers of a = ln det phi and of the shear b =
        ln(D1/D2). The constants are E_a and E_b; E_b has the term of l or of m.
    threshold : float
        Lower end of the continuum of the class, inf without one. Limits of V are read at ``|a|`` and b = 300.
    error : float
        Error of the threshold.
    reason : str
        Why the class has these discrete levels, or none, in one sentence.
    """

    levels: LevelTable
    threshold: float
    error: float
    reason: str


@says_progress
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
        An `AffineBody` without potential, or with V = V_a(det) + V_b(r/det).
    {spin_vorticity}
    count : int, default 1
        Number of levels of the dilatation, at least 1, and of the shear if V depends on it. Without V_b each level of
        the dilatation has all discrete levels of the shear.
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
        If V is no such sum, I + A or I + A + 2 B is not positive, or an argument has a wrong value.
    NoGroundState
        If V is unbounded below or binds fewer than `count` levels. It is a `ValueError`.

    Notes
    -----
    - H = -hbar^2/(I + A + 2 B) d^2/da^2 + hbar^2/(I + A) L + V, and hbar^2 I l^2/(2 (I^2 - A^2)) for "left", with m for
      "right"; I = 0 for "both".
    - L, the shear's part of the invariant Laplacian: a continuum from 1/4 on, and k (1 - k) with k = min(``|m|``,
      ``|l|``)/2 - n > 1/2 if m l < 0. With V_b: Galerkin's method.
    - Dilatation: Galerkin's method on the line. Without V_a it is free, and no level is discrete.
    - Without V_b infinitely many classes share a level: any m for "left", any l for "right".
    - "both": unbounded below over all classes, because T has the signature (+++-).
    - Levels above the threshold stay discrete because E_a, E_b, m and l are conserved.

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
        raise TypeError(f"model must be an AffineBody, got {kind_of(model)}. Use spectrum for other systems.")
    symmetry = checked_class(m, l)
    count = whole("count", count, 1)
    tolerance = positive("tolerance", tolerance)
    hbar = action_quantum(hbar)
    rates = _rates(parts, symmetry, hbar)
    potentials = _potentials(model, parts)
    if potentials.of_b is None:
        shear = closed_shear(rates, symmetry)
    else:
        shear = bound_shear(potentials.of_b, rates, symmetry, count, tolerance)
    least = float(min([shear.bottom, *shear.E]))
    if potentials.of_a is None:
        threshold = least + potentials.rest
        reason = f"without a potential of det the dilatation is free, and no level is discrete; {shear.reason}."
        return AffineSpectrum(_levels(None, shear, symmetry, hbar), threshold, shear.slack(threshold), reason)
    mass = parts.I + parts.A + 2 * parts.B
    found = bound_dilatation(potentials.of_a, mass, count, hbar, tolerance)
    bound = shear.bottom + float(found.E[0])
    free = min(limit(potentials.of_a, side) for side in (-1, 1)) + least
    threshold = min(free, bound)
    error = shear.slack(free) if free < bound else float(found.error[0]) + ROUNDING * abs(bound)
    levels = _levels(found, shear, symmetry, hbar)
    return AffineSpectrum(levels, threshold, error if np.isfinite(threshold) else 0.0, f"{shear.reason}.")


def _rates(parts: AffineParts, symmetry: SymmetryClass, hbar: float) -> ShearRates:
    """Return the constants of H; raises ValueError where the dilatation or the shear has a negative mass."""
    size = parts.I + parts.A
    whole_size = size + 2 * parts.B
    if not (size > 0 and whole_size > 0):
        raise ValueError(f"model must have I + A and I + A + 2 B positive, got {size:g} and {whole_size:g}")
    turn = {"left": symmetry.l, "right": symmetry.m, "both": 0}[parts.invariance]
    rotor = parts.I * turn**2 / (2 * size * (parts.I - parts.A)) if turn else 0.0
    return ShearRates(hbar**2 / size, hbar**2 * rotor)


class _Potentials(NamedTuple):
    """V(a, b) = V_a(a) + V_b(b) with V_b(0) = 0; None for a part that does not depend on its coordinate; V(0, 0)."""

    of_a: Callable[[Any], Any] | None
    of_b: Callable[[Any], Any] | None
    rest: float


def _potentials(model: Any, parts: AffineParts) -> _Potentials:
    """Return the parts of the potential; raises ValueError where it is no sum of functions of det and of r/det."""
    if not parts.potential:
        return _Potentials(None, None, 0.0)

    def V(a: Any, b: Any) -> Any:
        with np.errstate(all="ignore"):
            D1, D2 = np.exp((a + b) / 2), np.exp((a - b) / 2)
            return model.energy(D1, 0.0, 0.0, D2, 0.0, 0.0, 0.0, 0.0)

    a, b = SAMPLES
    along_a, along_b, rest = V(a, 0 * a), V(0 * b, b), float(V(0.0, 0.0))
    size = SPLIT * max(np.abs(along_a).max(), np.abs(along_b).max(), abs(rest))
    if not np.abs(V(a + 0 * b, 0 * a + b) - along_a - along_b + rest).max() <= size:
        raise ValueError(f"model must have a potential V(det) + W(r/det), got {shown(parts.written(), 60)}")
    return _Potentials(
        (lambda a: V(a, 0 * a)) if np.abs(along_a - rest).max() > size else None,
        (lambda b: V(0 * b, b) - rest) if np.abs(along_b - rest).max() > size else None,
        rest,
    )


def _levels(found: Dilatation | None, shear: Shear, symmetry: SymmetryClass, hbar: float) -> LevelTable:
    """Return all sums of levels of the dilatation and of the shear, ascending; none where the dilatation is free."""
    size, method = shear.size, shear.method
    if found is None:
        none = np.empty(0)
        found = Dilatation(none, none, np.empty(0, bool), 0, "")
    else:
        size, method = max(size, found.size), f"{method}; dilatation: Galerkin in Jacobi polynomials{found.said}"
    n = np.indices((found.E.size, shear.E.size)).reshape(2, -1)
    n = n[:, np.argsort(found.E[n[0]] + shear.E[n[1]], kind="stable")]
    constants = np.array([found.E[n[0]], shear.E[n[1]]])
    E = constants.sum(axis=0)
    m, l = (np.full(E.shape, number) for number in symmetry)
    return LevelTable(
        E=E,
        error=found.error[n[0]] + shear.error[n[1]] + ROUNDING * np.abs(constants).sum(axis=0),
        status=np.where(found.converged[n[0]] & shear.converged[n[1]], Status.OK, Status.NOT_CONVERGED),
        n=n,
        names=("a", "b"),
        m=m,
        l=l,
        constants=constants,
        constant_names=("E_a", "E_b"),
        hbar=hbar,
        method=method,
        functions=size,
    )
