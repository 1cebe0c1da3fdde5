"""The checks of what a user hands in: each raises at once, naming the argument, what it got and what it takes."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..base.numbers import numbers, shown
from ..charts import Chart
from ..compile.blocks import is_value, parameters
from ..formulas.section_text import section_forms
from ..models.contracts import (
    Autonomous,
    Kind,
    Map,
    Model,
    Potential,
    Section,
    coordinate_names,
    damped,
    dimension,
    driven,
    kind_of,
    moving,
    planar,
    quadratic,
)
from ..models.mechanics import kinetic_energies, potential_energies, turns
from ..models.sections import Linear, Stroboscopic
from ..schemes.catalogue import SCHEMES, RungeKutta, Splitting
from ..schemes.time_transformed import TimeTransformed

LARGEST = 1e150
"""Size of a model's parameters whose squares are still numbers."""


NATURAL = (Kind.SEPARABLE,)
"""Kinds of models whose energy is T(p) + V(q)."""

CONSERVATIVE = (*NATURAL, Kind.ROTATING)
"""Kinds of models that conserve an energy."""

RUNS = (*CONSERVATIVE, Kind.DRIVEN)
"""Kinds of models that run in time."""

EVERY = (*RUNS, Kind.DAMPED, Kind.MAP, Kind.FLOW)
"""These, with friction, maps, and dz/dt = f(z)."""


def checked_model(model: Any, name: str = "body", kinds: tuple[Kind, ...] = RUNS) -> Any:
    """Return `model` if it is a model of one of these kinds: a NamedTuple with the methods of the physics and finite
    parameters.
    """
    if not is_value(model):
        raise TypeError(
            f"{name} must be a model such as Body(Hyperelastic(C=1.0), mu=1.0) or HenonHeiles(), got {shown(model)} "
            f"({type(model).__name__}){_instead(model)}"
        )
    missing = lacking(model, {Kind.MAP: Map, Kind.FLOW: Autonomous}.get(kind_of(model), Model))
    if isinstance(model, Potential) and missing:
        raise TypeError(f"{name} {shown(model)} is a potential, no model: wrap it, Body({type(model).__name__}(...))")
    if missing:
        raise TypeError(f"{name} {type(model).__name__} has no {', '.join(missing)}")
    kind = kind_of(model)
    if kind not in kinds:
        what = kind.value if isinstance(kind, Kind) else shown(kind)
        runs = "; ".join(entry.value for entry in kinds)
        raise TypeError(f"{name} {type(model).__name__} is {what}; what runs here is {runs}")
    body = planar(model)
    if body and not is_value(model.potential):
        raise TypeError(
            f"{name}.potential must be a NamedTuple such as Hyperelastic(C=1.0), got {model.potential!r}"
            f"{_instead(model.potential)}"
        )
    if body and lacking(model.potential, Potential):
        alone = f": {type(model.potential).__name__} is a model itself, without Body"
        raise TypeError(
            f"{name}.potential must be a potential of A and B (value, slopes, margin), got {model.potential!r}"
            f"{'' if lacking(model.potential, Model) else alone}"
        )
    flat = _parameters(name, model)
    if not np.all(np.isfinite(flat)):
        raise ValueError(f"{name} has a parameter that is not finite: {model!r}")
    if np.any(np.abs(flat) > LARGEST):
        raise ValueError(f"{name} has a parameter beyond {LARGEST:g}, whose square overflows: {shown(model)}")
    if hasattr(model, "potential") and hasattr(model, "mu") and not model.mu > 0:
        raise ValueError(f"{name}.mu must be positive, got {model.mu!r}")
    if kind is Kind.DRIVEN:
        _check_drive(name, model)
    _evaluated(name, model)
    if turns(model):
        _check_turning(name, model)
    if damped(model):
        _check_damping(name, model)
    return model


def _check_damping(name: str, model: Any) -> None:
    """Refuse a model with friction whose rate is no number."""
    try:
        rate = float(model.damping_rate())
    except (AttributeError, TypeError, ValueError, ArithmeticError) as problem:
        raise TypeError(
            f"{name} {type(model).__name__} has friction: it must have damping_rate(), a number ({problem})"
        ) from None
    if not abs(rate) <= LARGEST:
        raise ValueError(f"{name} {shown(model)} must have a finite friction, got {rate!r}")


def _check_turning(name: str, model: Any) -> None:
    """Refuse a model of a turning frame whose rate is no number, or whose kinetic energy the turning would change."""
    n = model.degrees_of_freedom
    try:
        omega = float(model.angular_velocity())
    except (AttributeError, TypeError, ValueError, ArithmeticError) as problem:
        raise TypeError(
            f"{name} {type(model).__name__} turns: it must have angular_velocity(), a number ({problem})"
        ) from None
    if not abs(omega) <= LARGEST:
        raise ValueError(f"{name} {shown(model)} must turn at a finite rate, got {omega!r}")
    if n < 2:
        raise ValueError(f"{name} {type(model).__name__} must have two coordinates or more to turn, it has {n}")
    mass = np.array([np.array(model.velocity(*unit), dtype=np.float64) for unit in np.eye(n)])
    round_ = mass[0, 0] == mass[1, 1] > 0 and not mass[0, 1:].any() and not mass[1, 2:].any() and not mass[1:, 0].any()
    if not (quadratic(model) and round_ and not mass[2:, :2].any()):
        raise ValueError(
            f"{name} {type(model).__name__} must have T = (p_x^2 + p_y^2)/2m + ... of its first two coordinates to "
            "turn: equal masses, and quadratic in the momenta"
        )


def _check_drive(name: str, model: Any) -> None:
    """Refuse a driven model whose last coordinate is not the time, with a period."""
    what = f"{name} {type(model).__name__} is driven"
    period = getattr(model, "period", None)
    if not isinstance(period, (int, float, np.number)):
        raise TypeError(f"{what}: it must have its period, a number, as `period`, got {shown(period)}")
    if not (np.isfinite(period) and period > 0):
        raise ValueError(f"{what}: its period must be positive and finite, got {shown(period)}")
    if not hasattr(model, "phase"):
        raise TypeError(f"{what}: it must have phase(t), the time t reduced by whole periods")
    _, p = _some_point(model.degrees_of_freedom)
    if not (moving(model) > 0 and model.velocity(*p)[-1] == 1.0):
        raise ValueError(f"{what}: its last coordinate must be the time, whose velocity is 1")


def _instead(given: Any) -> str:
    """Return what to write instead of a class, or of a name."""
    if isinstance(given, type) and lacking(given, Potential) == []:
        return f": a class; write Body({given.__name__}()), with its parameters"
    if isinstance(given, type) and given.__name__.isidentifier():
        return f": a class; write {given.__name__}(), with its parameters"
    return ": write a model as a value; names are for jobs and the command line" if isinstance(given, str) else ""


def lacking(value: Any, contract: Any) -> list[str]:
    """Return what a value lacks of a contract, by name in the contract's order."""
    wanted = [entry for entry in vars(contract) if isinstance(vars(contract)[entry], property)]
    return [entry for entry in wanted if not hasattr(value, entry)]


def _evaluated(name: str, model: Any) -> None:
    """Refuse a model whose parts do not fit together: each of its methods must give numbers at some point."""
    if kind_of(model) is Kind.MAP:
        return _evaluated_map(name, model)
    for part in (model, getattr(model, "potential", None)):
        _functions(part)
    n = model.degrees_of_freedom
    if kind_of(model) is Kind.FLOW:
        return _evaluated_rates(name, model)
    try:
        q, p = _some_point(n)
        with np.errstate(all="ignore"):
            numbers_of = [
                *(getattr(model, method)(*q) for method in ("potential_energy", "margin")),
                model.kinetic_energy(*p),
            ]
            rows = model.force(*q), model.velocity(*p)
        if [len(row) for row in rows] != [n, n] or any(
            np.shape(number) != () for number in (*numbers_of, *rows[0], *rows[1])
        ):
            raise TypeError("one number for each coordinate is needed, and one for energies and the margin")
    except (TypeError, ValueError, AttributeError, ArithmeticError) as problem:
        raise TypeError(f"{name} {shown(model)} does not give numbers ({type(problem).__name__}: {problem})") from None


def _evaluated_rates(name: str, model: Any) -> None:
    """Refuse a flow whose parts do not fit together."""
    d = dimension(model)
    try:
        if model.degrees_of_freedom != (d + 1) // 2:
            raise TypeError(f"{d} variables take degrees_of_freedom = {(d + 1) // 2}, got {model.degrees_of_freedom}")
        z = np.linspace(1.3, 0.2, d)
        with np.errstate(all="ignore"):
            rates, margin = model.rates(*z), model.margin(*z)
        if len(rates) != d or any(np.shape(number) != () for number in (*rates, margin)):
            raise TypeError("one number for each variable is needed, and one for the margin")
    except (TypeError, ValueError, AttributeError, ArithmeticError) as problem:
        raise TypeError(f"{name} {shown(model)} does not give numbers ({type(problem).__name__}: {problem})") from None


def _evaluated_map(name: str, model: Any) -> None:
    """Refuse a map whose parts do not fit together."""
    q, p = _some_point(model.degrees_of_freedom)
    try:
        with np.errstate(all="ignore"):
            rows = model.iterate(*q, *p), model.tangent_iterate(*q, *p, *p, *q), model.periods()
            margin = model.margin(*q)
        if [len(row) for row in rows] != [2 * len(q)] * 3 or any(np.shape(x) != () for row in rows for x in row):
            raise TypeError("iterate, tangent_iterate and periods must give one number for each row")
        if np.shape(margin) != ():
            raise TypeError("the margin must be one number")
    except (TypeError, ValueError, AttributeError, ArithmeticError) as problem:
        raise TypeError(f"{name} {shown(model)} does not give numbers ({type(problem).__name__}: {problem})") from None
    if not all(np.isfinite(period) and period >= 0 for period in rows[2]):
        raise ValueError(f"{name} {shown(model)}: periods must be positive, or 0 for none, got {rows[2]}")


@functools.lru_cache
def _some_point(n: int) -> tuple[tuple, tuple]:
    """Return n coordinates and momenta at which models are tried."""
    return tuple(np.linspace(1.3, 0.2, n)), tuple(np.linspace(0.3, 1.1, n))


def _parameters(name: str, value: Any) -> np.ndarray:
    """Return the parameters of a model or section; where they are no numbers the message names the argument too."""
    try:
        return parameters(value)
    except (TypeError, ValueError) as problem:
        raise type(problem)(f"{name} has a wrong parameter: {problem}") from None


def checked_tangent_model(model: Any, name: str = "body", kinds: tuple[Kind, ...] = RUNS) -> Any:
    """Return `model` if it has what tangent vectors need: `tangent_force`, and a velocity linear in the momenta."""
    checked_model(model, name, kinds)
    if kind_of(model) is Kind.MAP:
        return model
    n = model.degrees_of_freedom
    if kind_of(model) is Kind.FLOW:
        if not hasattr(model, "tangent_rates"):
            raise TypeError(f"{name} {type(model).__name__} needs tangent_rates(z..., dz...) for tangent vectors")
        return model
    try:
        with np.errstate(all="ignore"):
            model.tangent_force(*np.linspace(1.3, 0.2, n), *np.ones(n))
    except AttributeError as problem:
        raise TypeError(
            f"{name} {type(model).__name__} has no second derivatives ({problem}): tangent vectors need "
            "tangent_force(q..., dq...) of a "
            "model, curvatures of a potential, one_variable(value, slope, curvature) of a function"
        ) from None
    if not quadratic(model):
        raise ValueError(
            f"{name} {type(model).__name__} must have a velocity linear in the momenta (T quadratic) for tangent "
            "vectors"
        )
    return model


def checked_scheme(scheme: Any) -> Splitting | RungeKutta:
    """Return `scheme` if it is one that steps in time itself."""
    if isinstance(scheme, TimeTransformed):
        raise TypeError(
            f"scheme {scheme.name} steps in a fictitious time: only integrate and poincare_map take it; got it "
            "elsewhere, where a "
            "Splitting or RungeKutta such as fastaff.KAHAN_LI8 is needed"
        )
    if not isinstance(scheme, (Splitting, RungeKutta)):
        raise TypeError(
            f"scheme must be a scheme such as fastaff.KAHAN_LI8, got {scheme!r} ({type(scheme).__name__}); "
            f"or a name of {', '.join(SCHEMES)}"
        )
    return scheme


def suited_scheme(scheme: Any, model: Any, name: str = "body") -> Any:
    """Return `scheme` if its order holds for the model."""
    if getattr(scheme, "nystrom", False) and damped(model):
        raise ValueError(
            f"scheme {scheme.name} has its order {scheme.order} only where forces depend on the coordinates alone, and "
            f"{name} {type(model).__name__} has friction: take KAHAN_LI8"
        )
    if getattr(scheme, "nystrom", False) and not quadratic(model):
        raise ValueError(
            f"scheme {scheme.name} has its order {scheme.order} only where T is quadratic in the momenta, and that of "
            f"{name} {type(model).__name__} is not: take KAHAN_LI8"
        )
    return scheme


def _functions(value: Any) -> None:
    """Refuse numbers and plain functions in the fields V_... of a separable potential or body."""
    for field in getattr(value, "_fields", ()):
        entry = getattr(value, field)
        if field.startswith("V_"):
            checked_function(field, entry)


def checked_function(field: str, entry: Any) -> Any:
    """Return the entry of the field V_... if it is a function of one variable."""
    if not is_value(entry) or not hasattr(entry, "value"):
        angle = field in ("V_eta", "V_gamma")
        what = (
            "of the angle such as one_variable(f) or Zero()"
            if angle
            else "such as Oscillator(k=1.0) or one_variable(f)"
        )
        raise TypeError(f"{field} must be a function {what}, got {entry!r}")
    return entry


def checked_chart(chart: Any) -> Chart:
    """Return `chart` if it is one of GL(2,R)."""
    if not isinstance(chart, Chart):
        raise TypeError(
            f"chart must be a chart such as fastaff.charts.ALPHA_BETA, got {shown(chart)} ({type(chart).__name__})"
        )
    return chart


def checked_section(section: Any, model: Any) -> Any:
    """Return `section` if it is a section that suits the model."""
    if not is_value(section) or lacking(section, Section):
        instead = f": a class; write {section.__name__}()" if isinstance(section, type) else ""
        raise TypeError(
            f"section must be a section such as AlphaTurning(direction=+1), or its text, here one of "
            f"{', '.join(section_forms(model))}, got {section!r} ({type(section).__name__}){instead}"
        )
    if not (isinstance(section.direction, (int, float, np.number)) and section.direction in (-1, 0, 1)):
        raise ValueError(f"section.direction must be -1, 0 or +1, got {shown(section.direction)}")
    if not np.all(np.isfinite(_parameters("section", section))):
        raise ValueError(f"section has a parameter that is not finite: {section!r}")
    rows = dimension(model)
    normal = getattr(section, "normal", None)
    try:
        if normal is not None and (len(normal) != rows or not any(normal)):
            raise TypeError
        if np.shape(section.value(*np.ones(rows))) != ():
            raise TypeError
    except (TypeError, ValueError):
        raise ValueError(
            f"section {section!r} does not suit a {type(model).__name__}: it must take {rows} numbers, "
            f"the rows of z, and depend on one of them, such as {', '.join(section_forms(model))}"
        ) from None
    if isinstance(section, Stroboscopic):
        if not driven(model):
            raise ValueError(
                f"section {section!r} is one of driven systems, with a period: {type(model).__name__} takes "
                f"{', '.join(section_forms(model))}"
            )
    elif driven(model):
        _check_timeless(section, model)
    elif rows % 2 and type(section) is not Linear:
        raise TypeError(f"section must be Linear for an odd number of variables, here {rows}, got {section!r}")
    return section


def _check_timeless(section: Any, model: Any) -> None:
    """Refuse a section whose function changes with the time, which begins again after every period."""
    now = np.linspace(0.7, 1.9, 2 * model.degrees_of_freedom)
    later = now.copy()
    later[moving(model)] += 0.3 * model.period
    if section.value(*now) != section.value(*later):
        raise ValueError(
            f"section {section!r} of a driven system must not depend on its time t, but be one of constant t: "
            "Stroboscopic(phase=0.0), t=c"
        )


def phase_points(name: str, z0: Any, model: Any) -> np.ndarray:
    """Return `z0` of shape (2n,) or (2n, orbits) as a fresh float64 array (2n, orbits) inside the model's domain; of a
    flow with an odd number of variables with the idle row below.
    """
    rows, flow = dimension(model), kind_of(model) is Kind.FLOW
    z = np.array(numbers(name, z0), order="C")
    if driven(model) and z.ndim in (1, 2) and z.shape[0] == rows - 2:
        z = np.insert(z, [rows // 2 - 1, rows - 2], 0.0, axis=0)  # t = 0 and p_t = 0
    if z.ndim not in (1, 2) or z.shape[0] != rows or z.size == 0:
        raise ValueError(
            f"{name} must have shape ({rows},) or ({rows}, orbits) for {type(model).__name__}, rows "
            f"{', '.join(coordinate_names(model))}{'' if flow else ' and their momenta'}; got shape {z.shape}"
            f"{' (orbits first: transpose it, z0.T)' if z.ndim == 2 and z.shape[1] == rows else ''}"
            f"{f' (a grid: flatten it, z0.reshape({rows}, -1))' if z.ndim > 2 and z.shape[0] == rows else ''}"
        )
    z = z.reshape(rows, -1)
    bad = np.flatnonzero(~np.isfinite(z).all(axis=0))
    if bad.size:
        raise ValueError(f"{name} must be finite; orbit {bad[0]} is {z[:, bad[0]]} ({bad.size} such orbits)")
    if driven(model):
        z[moving(model)] = model.phase(z[moving(model)])
    with np.errstate(all="ignore"):
        margin = np.broadcast_to(model.margin(*z[: rows if flow else rows // 2]), z.shape[1:])
    outside = np.flatnonzero(~(margin > 0))
    if outside.size:
        raise ValueError(
            f"{name} must lie where the potential lives (for most bodies det phi > 0); orbit {outside[0]} has margin "
            f"{margin[outside[0]]:.6g} <= 0 ({outside.size} such orbits)"
        )
    return carried(z, model)


def carried(z: np.ndarray, model: Any, axis: int = 0) -> np.ndarray:
    """Return rows of phase points, along an axis, as carried: with an idle row below an odd number of variables."""
    width = [(0, 0)] * z.ndim
    width[axis] = (0, 2 * model.degrees_of_freedom - z.shape[axis])
    return np.pad(z, width) if width[axis][1] > 0 else z


ROUNDING = 8 * np.finfo(float).eps
"""Relative error that an energy may have from its own sums."""

NOTICED, WALK = 1e-7, 64 * np.finfo(float).eps
"""Energy error from which on it is looked at whether it is rounding; the part of z that rounding makes in a run."""


def energy_drift(model: Any, z: np.ndarray, energy: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return |E - energy|/scale of phase points z (2n, ...); inf where the energy has no value.

    What rounding of E or of z may make, as where V has a large constant or an orbit rests, does not count; 0 with
    friction.
    """
    if damped(model):
        return np.where(np.isfinite(z).all(axis=0), 0.0, np.inf)
    with np.errstate(all="ignore"):
        T, V = kinetic_energies(model, z), potential_energies(model, z)
        drift = np.maximum(np.abs(T + V - energy) - ROUNDING * (T + np.abs(V) + np.abs(energy)), 0.0) / scale
        far = drift > NOTICED
        if far.any():  # next to an equilibrium the last digits of z have more energy than the motion
            near, away = z[:, far], (V - energy + T)[far]
            noise = [np.abs(potential_energies(model, near * (1 + sign * WALK)) - V[far]) for sign in (-1, 1)]
            drift[far] = np.minimum(
                drift[far],
                np.maximum(np.abs(away) - np.maximum(*noise), 0.0) / np.broadcast_to(scale, drift.shape)[far],
            )
    return np.where(np.isfinite(drift), drift, np.inf)
