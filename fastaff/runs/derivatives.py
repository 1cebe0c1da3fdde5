"""User-defined models: their derivatives are compared with differences, at and near the starts of orbits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..core.identity import by_identity
from ..core.numbers import shown
from ..engine.blocks import is_value
from ..systems.models.mechanics import System
from ..systems.models.pointwise import FAILS, at_points

AGREE = 1e-5
"""Relative error above which a derivative is wrong, if it also exceeds BEYOND."""

BEYOND = 1e3
"""Multiple of the differences' own error that the error of a wrong derivative exceeds."""

HALVINGS = 40
"""Steps of differences, each half of the one before: one fits a function that is smooth on some scale between. For a
function of several scales the right one is unknown: a derivative that agrees with any is right.
"""

TRIED = 3
"""Starts that are tried."""

APART = 0.1
"""Distance of more points beside the starts, in sizes of rows: at a start too much may vanish."""

Rows = Callable[[np.ndarray], np.ndarray]


def check_derivatives(name: str, system: System, z: np.ndarray) -> None:
    """Refuse a user's model whose rates are not those of its energy, or whose tangent vectors do not follow its rates;
    z (2n, orbits): starts. Models of the package and of texts are tested or derived, and not tried.

    :Source: Dahlquist & Björck 2008, Numerical Methods in Scientific Computing I, 3.4 (Richardson's extrapolation).
    """
    tried = _tried(system.model)
    if tried or not any(_own(part) for part in (system.model, *system.model) if is_value(part)):
        return
    who = f"{name} {type(system.model).__name__}"
    at, size = _places(system, z)
    w = size * np.random.default_rng(3).uniform(0.5, 1, at.shape)
    energy = f"{who} must have rates dH/dp and -dH/dq of its energy H"
    tangent = _tangent(system)
    with np.errstate(all="ignore"):
        if system.energetic and (found := _tried_out(lambda: _of_energy(system, at, size))):
            by = ("velocity", "force") if system.separable else ("rates", "rates")
            said, truth, off = found
            _compare(energy, system.row_names, at, said, truth, off, methods=by)
        if tangent is not None:
            rates, change, method = tangent
            if found := _tried_out(lambda: (change(at, w), *_slope(rates, at, w))):
                what = f"{who} must have a {method} that is the change of its rates along a vector"
                _compare(what, system.row_names, at, *found)
    tried.append(True)


@by_identity
def _tried(model: Any) -> list[bool]:
    """Whether a model has been tried: a trial takes longer than a short run."""
    return []


def _tried_out(compute: Callable[[], tuple]) -> tuple:
    """Return the values of methods, () where they give none in Python: a run may not need them."""
    try:
        return compute()
    except FAILS:
        return ()


def _own(part: Any) -> bool:
    """Tell whether the class of a value is the user's: none of the package, nor itself one made of a text."""
    cls = type(part)
    return cls.__module__.partition(".")[0] != __name__.partition(".")[0] and "_request" not in vars(cls)


def _places(system: System, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (2n, ...) at some starts and beside them, and the sizes (2n, 1) of their rows."""
    z = z[: system.rows, np.unique(np.linspace(0, z.shape[1] - 1, TRIED).astype(int))]
    size = np.abs(z).max(axis=1)
    halves = np.array_split(np.arange(len(z)), 2 if system.canonical else 1)
    for half in halves:
        size[half] = np.where(size[half] > 0, size[half], size[half].max() or 1.0)
    beside = APART * np.random.default_rng(2).uniform(-1, 1, (2, *z.shape)) * size[:, None]
    return np.concatenate([z, *(z + beside)], axis=1), size[:, None]


def _slope(rows: Rows, z: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of rows along vectors w at points z by differences of all steps, (rows, points, steps),
    and their distances from those of the next steps.
    """
    h = APART * 0.5 ** np.arange(HALVINGS)
    step = h * w[..., None]
    ahead = rows(z[..., None] + step)
    back = rows(z[..., None] - step)
    change = (ahead - back) / (2 * h)
    rounding = np.finfo(float).eps * (np.abs(ahead) + np.abs(back)) / h
    better = (4 * change[..., 1:] - change[..., :-1]) / 3
    apart = np.abs(np.diff(better))
    apart = np.maximum(apart[..., 1:], apart[..., :-1]) + rounding[..., 2:-1]
    return better[..., 1:-1], np.where(np.isfinite(apart), apart, np.inf)


def _of_energy(system: System, z: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the model's rates (2n, points), those by differences of its energy, and the error of the latter."""
    n = system.n
    own = system.own
    said = system.slopes(z)
    if own is not None:  # the package's, and no model's own
        rest = np.zeros_like(z[:n])
        said = said - np.concatenate([own.added(letter, system.rate, z[:n], z[n:], rest) for letter in "vf"])

    def energies(at: np.ndarray) -> np.ndarray:
        return system.energies(at) - (0.0 if own is None else own.energies(system.rate, at[:n], at[n:]))

    units = size * np.eye(2 * n)[:, :, None] + 0.0 * z
    found = [_slope(lambda at: energies(at)[None], z, unit) for unit in units]
    truth, off = (np.array([entry[k][0] for entry in found]) / size[..., None] for k in range(2))
    return said, np.concatenate([truth[n:], -truth[:n]]), np.concatenate([off[n:], off[:n]])


def _tangent(system: System) -> tuple[Rows, Callable, str] | None:
    """Return the rates, their change along a vector by the model's method, and its name; None where it has none."""
    model = system.model
    n = system.n
    if system.separable:
        if not hasattr(model, "tangent_force"):
            return None
        if not system.bends:
            return (
                (lambda z: _array(at_points(model, "force", *z[:n]), z)),
                (lambda z, w: _array(at_points(model, "tangent_force", *z[:n], *w[:n]), z)),
                "tangent_force",
            )
        return (
            (lambda z: _array((*at_points(model, "velocity", *z[n:]), *at_points(model, "force", *z[:n])), z)),
            (lambda z, w: _array(_changes(model, z, w), z)),
            "tangent_velocity and a tangent_force",
        )
    method = "tangent_iterate" if system.iterated else "tangent_rates"
    if not hasattr(model, method):
        return None
    rates = "iterate" if system.iterated else "rates"
    return (
        (lambda z: _array(at_points(model, rates, *z), z)),
        (lambda z, w: _array(at_points(model, method, *z, *w), z)),
        method,
    )


def _changes(model: Any, z: np.ndarray, w: np.ndarray) -> tuple:
    """Return the changes of velocities and forces along vectors w, by the model's methods."""
    n = len(z) // 2
    velocities = at_points(model, "tangent_velocity", *z[n:], *w[n:])
    return *velocities, *at_points(model, "tangent_force", *z[:n], *w[:n])


def _array(numbers: Any, z: np.ndarray) -> np.ndarray:
    """Return the rows that a method gives as an array, also where a row is one number for all points."""
    return np.array([number + np.zeros(z.shape[1:]) for number in numbers])


def _compare(
    what: str,
    names: Any,
    z: np.ndarray,
    said: np.ndarray,
    truth: np.ndarray,
    off: np.ndarray,
    *,
    methods: tuple[str, ...] = (),
) -> None:
    """Raise where the model's rows (rows, points) disagree with the differences of all steps at more than one point."""
    names = names[len(names) - len(said) :]
    best = off.argmin(axis=-1)[..., None]
    beyond = ~(np.abs(said[..., None] - truth) <= AGREE * (np.abs(said[..., None]) + np.abs(truth)))  # NaN at an edge
    truth, off = (np.take_along_axis(entry, best, -1)[..., 0] for entry in (truth, off))
    wrong = beyond.all(axis=-1) & (np.abs(said - truth) > BEYOND * off)
    often = wrong.sum(axis=1) > 1
    if often.any():
        row = int(often.argmax())
        point = int(wrong[row].argmax())
        by = f" ({methods[2 * row // len(said)]})" if methods else ""
        place = [float(f"{x:.6g}") for x in z[:, point]]
        raise ValueError(
            f"{what}: at {shown(place)} that of {names[row]} is {said[row, point]:.9g}, by differences "
            f"{truth[row, point]:.9g}{by}"
        )
