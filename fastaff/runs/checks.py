"""Checks of a user's input: each raises at once and names the argument, the value given and the values allowed."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..core.foreign import call_for
from ..core.identity import by_identity
from ..core.numbers import numbers, shown
from ..engine.blocks import is_as_met, is_value, parameters
from ..systems.charts import Chart
from ..systems.formulas.section_text import section_forms
from ..systems.models.contracts import Autonomous, Map, Model, Nonseparable, Potential, Section
from ..systems.models.mechanics import System, system_of
from ..systems.models.pointwise import at_points
from ..systems.models.sections import Stroboscopic
from .needs import check_kind, check_needs
from .schemes.catalogue import SCHEMES, Collocation, Nystrom, RungeKutta, Scheme, Splitting
from .schemes.time_transformed import TimeTransformed
from .starts import in_rows

LARGEST = 1e150
"""Size of a model's parameters whose squares are still numbers."""


def current_system(model: Any) -> System:
    """Return the system of a user's model, which may not be checked yet. It is made anew if methods of the model's
    class have been replaced since it was checked.
    """
    if _needs_met(model):
        is_as_met(model)
    return system_of(model)


def checked_model(model: Any, name: str = "body", needs: str = "equations") -> Any:
    """Return `model` if it meets a need of NEEDS, see `checked_system`."""
    return checked_system(model, name, needs).model


def checked_system(model: Any, name: str = "body", needs: str = "equations") -> System:
    """Return the system of a user's model if it meets a need of NEEDS: a NamedTuple with the methods of the physics and
    finite parameters.
    """
    if not is_value(model):
        raise TypeError(
            f"{name} must be a model such as Body(Hyperelastic(C=1.0), mu=1.0) or HenonHeiles(), got {shown(model)} "
            f"({type(model).__name__}){_instead(model)}"
        )
    system = current_system(model)
    met = _needs_met(model)
    if needs in met:
        return system
    missing = lacking(
        model,
        Map if system.iterated else Model if system.separable else Nonseparable if system.canonical else Autonomous,
    )
    if isinstance(model, Potential) and missing:
        raise TypeError(f"{name} {shown(model)} is a potential, no model: wrap it, Body({type(model).__name__}(...))")
    if missing:
        raise TypeError(f"{name} {type(model).__name__} has no {', '.join(missing)}{_unnamed_kind(model)}")
    check_kind(model, name, needs)
    if len(set(system.row_names)) < len(system.row_names):
        raise ValueError(f"{name} {type(model).__name__} must have different names of its rows, got {system.row_names}")
    body = system.planar
    if body and not is_value(model.potential):
        raise TypeError(
            f"{name}.potential must be a NamedTuple such as Hyperelastic(C=1.0), got {model.potential!r}"
            f"{_instead(model.potential)}"
        )
    if body and lacking(model.potential, Potential):
        raise TypeError(
            f"{name}.potential must be a potential of A and B (value, slopes, margin), got {model.potential!r}"
        )
    flat = _parameters(name, model)
    if not np.all(np.isfinite(flat)):
        raise ValueError(f"{name} has a parameter that is not finite: {model!r}")
    if np.any(np.abs(flat) > LARGEST):
        raise ValueError(f"{name} has a parameter beyond {LARGEST:g}, whose square overflows: {shown(model)}")
    if hasattr(model, "potential") and hasattr(model, "mu") and not model.mu > 0:
        raise ValueError(f"{name}.mu must be positive, got {model.mu!r}")
    if system.driven:
        _check_drive(name, system)
    _evaluated(name, system)
    if system.own is not None:
        _check_rate(name, model, system.own.has, system.own.rate)
    if system.frame:
        _check_turning(name, system)
    met.add(needs)
    return system


@by_identity
def _needs_met(model: Any) -> set[str]:
    """The needs for which a model has been checked: a check in every call would take longer than a hundred steps."""
    return set()


def _check_rate(name: str, model: Any, has: str, method: str) -> None:
    """Refuse a model that has a term whose rate is no finite number."""
    try:
        rate = float(getattr(model, method)())
    except (AttributeError, TypeError, ValueError, ArithmeticError) as problem:
        raise TypeError(f"{name} {type(model).__name__} {has}: it must have {method}(), a number ({problem})") from None
    if not abs(rate) <= LARGEST:
        raise ValueError(f"{name} {shown(model)} must have a finite {method}(), got {rate!r}")


def _check_turning(name: str, system: System) -> None:
    """Refuse a model in a rotating frame whose kinetic energy changes under the rotation."""
    model = system.model
    n = system.moving
    if n < 2:
        raise ValueError(f"{name} {type(model).__name__} must have two coordinates or more to turn, it has {n}")
    units = np.eye(system.n)[:n]
    mass = np.array([np.array(model.velocity(*unit), dtype=np.float64)[:n] for unit in units])
    round_ = mass[0, 0] == mass[1, 1] > 0 and not mass[0, 1:].any() and not mass[1, 2:].any() and not mass[1:, 0].any()
    if not (system.quadratic and round_ and not mass[2:, :2].any()):
        raise ValueError(
            f"{name} {type(model).__name__} must have T = (p_x^2 + p_y^2)/2m + ... of its first two coordinates to "
            "turn: equal masses, and quadratic in the momenta"
        )


def _check_drive(name: str, system: System) -> None:
    """Refuse a driven model whose last coordinate is not the time, with a period."""
    what = f"{name} {type(system.model).__name__} is driven"
    period = getattr(system.model, "period", None)
    if not isinstance(period, (int, float, np.number)):
        raise TypeError(f"{what}: it must have its period, a number, as `period`, got {shown(period)}")
    if not (np.isfinite(period) and period > 0):
        raise ValueError(f"{what}: its period must be positive and finite, got {shown(period)}")
    if not hasattr(system.model, "phase"):
        raise TypeError(f"{what}: it must have phase(t), the time t reduced by whole periods")
    q, p = _some_point(system.n)
    if not (system.moving > 0 and system.velocities(np.array([*q, *p])[:, None])[-1, 0] == 1.0):
        raise ValueError(f"{what}: its last coordinate must be the time, whose velocity is 1")


def _instead(given: Any) -> str:
    """Return a hint for a user who gave a class, a name, or a system of another tool."""
    if call := call_for(given):
        return call
    if isinstance(given, type) and lacking(given, Potential) == []:
        return f": a class; write Body({given.__name__}()), with its parameters"
    if isinstance(given, type) and given.__name__.isidentifier():
        return f": a class; write {given.__name__}(), with its parameters"
    return ": write a model as a value; names are for jobs and the command line" if isinstance(given, str) else ""


def _unnamed_kind(model: Any) -> str:
    """Return a hint for a class that has all methods of a kind, and does not name it."""
    contracts = {"MAP": Map, "NONSEPARABLE": Nonseparable, "FLOW": Autonomous}
    kinds = () if hasattr(model, "kind") else (kind for kind, entry in contracts.items() if not lacking(model, entry))
    return next((f": with its methods it must have kind = fastaff.models.contracts.Kind.{kind}" for kind in kinds), "")


def lacking(value: Any, contract: Any) -> list[str]:
    """Return the names in a contract that a value lacks, in the contract's order."""
    wanted = [entry for entry in vars(contract) if isinstance(vars(contract)[entry], property)]
    return [entry for entry in wanted if not hasattr(value, entry)]


def _evaluated(name: str, system: System) -> None:
    """Refuse a model whose parts do not fit together: each of its methods must give numbers at some point."""
    model = system.model
    if system.separable:
        for part in (model, getattr(model, "potential", None)):
            _functions(part)
    q, p = _some_point(system.n)
    single = []
    length = system.rows
    each = "row"
    try:
        with np.errstate(all="ignore"):
            if system.iterated:
                rows = [model.periods(), model.iterate(*q, *p), model.tangent_iterate(*q, *p, *p, *q)]
            elif system.nonseparable:
                rows = [model.rates(*q, *p), model.tangent_rates(*q, *p, *p, *q)]
                single = [model.energy(*q, *p)]
            elif system.energetic:
                rows = [model.force(*q), model.velocity(*p)]
                length = system.n
                each = "coordinate"
                single = [model.potential_energy(*q), model.kinetic_energy(*p)]
            else:
                if system.n != (length + 1) // 2:
                    raise TypeError(f"{length} variables take degrees_of_freedom = {(length + 1) // 2}, got {system.n}")
                rows = [model.rates(*_some_point(length)[0])]
                each = "variable"
            single.append(model.margin(*_some_point(system.positions)[0]))
        if any(len(row) != length for row in rows) or any(np.shape(x) != () for row in (single, *rows) for x in row):
            raise TypeError(f"one number for each {each} is needed, and one for energies and the margin")
        kinds = {np.asarray(x).dtype.kind for row in (single, *rows) for x in row}
        if kinds - set("biuf"):
            raise TypeError(f"real numbers are needed, {'some are complex' if 'c' in kinds else 'others are given'}")
    except (TypeError, ValueError, AttributeError, ArithmeticError) as problem:
        raise TypeError(f"{name} {shown(model)} does not give numbers ({type(problem).__name__}: {problem})") from None
    if system.iterated and not all(np.isfinite(period) and period >= 0 for period in rows[0]):
        raise ValueError(f"{name} {shown(model)}: periods must be positive, or 0 for none, got {rows[0]}")


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


def checked_tangent_system(model: Any, name: str = "body") -> System:
    """Return the system of a user's model if tangent vectors can follow it: it has changes of its forces and, if not
    linear, velocities.
    """
    system = checked_system(model, name)
    if not system.separable:
        if not (system.iterated or hasattr(model, "tangent_rates")):
            raise TypeError(f"{name} {type(model).__name__} needs tangent_rates(z..., dz...) for tangent vectors")
        return system
    try:
        with np.errstate(all="ignore"):
            change = model.tangent_force(*_some_point(system.n)[0], *np.ones(system.n))
    except AttributeError as problem:
        raise TypeError(
            f"{name} {type(model).__name__} has no second derivatives ({problem}): tangent vectors need "
            "tangent_force(q..., dq...) of a model, curvatures of a potential, one_variable(value, slope, curvature) "
            "of a function"
        ) from None
    if any(map(np.iscomplexobj, change)):
        raise TypeError(f"{name} {type(model).__name__}.tangent_force must give real numbers, some are complex")
    if not (system.quadratic or system.bends):
        raise ValueError(
            f"{name} {type(model).__name__} must have tangent_velocity(p..., dp...) for tangent vectors, as its "
            "velocity is not linear in the momenta"
        )
    return system


def checked_scheme(scheme: Any) -> Scheme:
    """Return `scheme` if it is one that steps in time itself."""
    if isinstance(scheme, TimeTransformed):
        raise TypeError(
            f"scheme {scheme.name} steps in a fictitious time: only integrate and poincare_map take it; got it "
            "elsewhere, where a Splitting or RungeKutta such as fastaff.KAHAN_LI8 is needed"
        )
    if not isinstance(scheme, (Splitting, Nystrom, RungeKutta, Collocation)):
        raise TypeError(
            f"scheme must be a scheme such as fastaff.KAHAN_LI8, got {scheme!r} ({type(scheme).__name__}); "
            f"or a name of {', '.join(SCHEMES)}"
        )
    return scheme


def suited_scheme(scheme: Any, system: System) -> Any:
    """Return `scheme` if its order holds for the model."""
    if not getattr(scheme, "nystrom", False):
        return scheme
    check_needs(system, "forces of the coordinates alone", got=scheme.name, order=scheme.order, argument="body")
    if isinstance(scheme, Nystrom):
        check_needs(system, "accelerations of the coordinates alone", got=scheme.name, argument="body")
    if not system.quadratic:
        raise ValueError(
            f"scheme {scheme.name} has its order {scheme.order} only where T is quadratic in the momenta, and that of "
            f"body {type(system.model).__name__} is not: take KAHAN_LI8"
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


def checked_section(section: Any, system: System) -> Any:
    """Return `section` if it is a section that suits the model."""
    if not is_value(section) or lacking(section, Section):
        instead = f": a class; write {section.__name__}()" if isinstance(section, type) else ""
        raise TypeError(
            f"section must be a section such as AlphaTurning(direction=+1), or its text, here one of "
            f"{', '.join(section_forms(system))}; one of your own is a NamedTuple with a field direction and a method "
            f"value({', '.join(system.row_names)}), got {section!r} ({type(section).__name__}){instead}"
        )
    if not (isinstance(section.direction, (int, float, np.number)) and section.direction in (-1, 0, 1)):
        raise ValueError(f"section.direction must be -1, 0 or +1, got {shown(section.direction)}")
    if not np.all(np.isfinite(_parameters("section", section))):
        raise ValueError(f"section has a parameter that is not finite: {section!r}")
    is_as_met(section)
    rows = system.rows
    normal = getattr(section, "normal", None)
    try:
        if normal is not None and (len(normal) != rows or not any(normal)):
            raise TypeError
        if np.shape(section.value(*np.ones(rows))) != ():
            raise TypeError
    except (TypeError, ValueError):
        raise ValueError(
            f"section {section!r} does not suit a {type(system.model).__name__}: it must take {rows} numbers, "
            f"the rows of z, and depend on one of them, such as {', '.join(section_forms(system))}"
        ) from None
    if isinstance(section, Stroboscopic):
        if not system.driven:
            raise ValueError(
                f"section {section!r} is one of driven systems, with a period: {type(system.model).__name__} takes "
                f"{', '.join(section_forms(system))}"
            )
    elif system.driven:
        _check_timeless(section, system)
    elif rows % 2 and normal is None:
        raise TypeError(
            f"section must be Linear or AngleEquals for an odd number of variables, here {rows}, got {section!r}"
        )
    return section


def _check_timeless(section: Any, system: System) -> None:
    """Refuse a section whose function changes with the time, as the time starts again after every period."""
    now = np.linspace(0.7, 1.9, 2 * system.n)
    later = now.copy()
    later[system.moving] += 0.3 * system.model.period
    if section.value(*now) != section.value(*later):
        raise ValueError(
            f"section {section!r} of a driven system must not depend on its time t, but be one of constant t: "
            "Stroboscopic(phase=0.0), t=c"
        )


def phase_points(name: str, z0: Any, system: System) -> np.ndarray:
    """Return `z0` of shape (2n,) or (2n, orbits), with or without labels, as a fresh float64 array (2n, orbits) inside
    the model's domain; of a flow with an odd number of variables with the idle row below.
    """
    rows = system.rows
    z = np.array(numbers(name, in_rows(name, z0, system)), order="C")
    if system.driven and z.ndim in (1, 2) and z.shape[0] == rows - 2:
        z = np.insert(z, [rows // 2 - 1, rows - 2], 0.0, axis=0)  # t = 0 and p_t = 0
    if z.ndim not in (1, 2) or z.shape[0] != rows or z.size == 0:
        raise ValueError(
            f"{name} must have shape ({rows},) or ({rows}, orbits) for {type(system.model).__name__}, rows "
            f"{', '.join(system.names)}{' and their momenta' if system.canonical else ''}; got shape {z.shape}"
            f"{' (orbits first: transpose it, z0.T)' if z.ndim == 2 and z.shape[1] == rows else ''}"
            f"{f' (a grid: flatten it, z0.reshape({rows}, -1))' if z.ndim > 2 and z.shape[0] == rows else ''}"
        )
    z = z.reshape(rows, -1)
    bad = np.flatnonzero(~np.isfinite(z).all(axis=0))
    if bad.size:
        raise ValueError(f"{name} must be finite; orbit {bad[0]} is {z[:, bad[0]]} ({bad.size} such orbits)")
    if system.driven:
        z[system.moving] = system.model.phase(z[system.moving])
    with np.errstate(all="ignore"):
        margin = np.broadcast_to(at_points(system.model, "margin", *z[: system.positions]), z.shape[1:])
    outside = np.flatnonzero(~(margin > 0))
    if outside.size:
        raise ValueError(
            f"{name} must lie where the potential lives ({_where(system)}); orbit {outside[0]} has margin "
            f"{margin[outside[0]]:.6g} <= 0 ({outside.size} such orbits)"
        )
    return carried(z, system)


def _where(system: System) -> str:
    """Return words for the domain of a model."""
    domain = getattr(system.model, "domain", None)
    axis = 'off the axis of a chart, as theta = 0 of a top, which AsymmetricTop(..., chart="quaternion") takes'
    if domain:
        return f"{domain} > 0"
    if system.nonseparable:
        return axis
    return "for most bodies det phi > 0"


def carried(z: np.ndarray, system: System, axis: int = 0) -> np.ndarray:
    """Return rows of phase points, along an axis, as carried: with an idle row below an odd number of variables."""
    width = [(0, 0)] * z.ndim
    width[axis] = (0, 2 * system.n - z.shape[axis])
    return np.pad(z, width) if width[axis][1] > 0 else z


ROUNDING = 8 * np.finfo(float).eps
"""Relative error that an energy may have from its own sums."""

NOTICED = 1e-7
"""Energy error above which a test for rounding follows."""

WALK = 64 * np.finfo(float).eps
"""Relative rounding error of z in a run."""


def energy_drift(system: System, z: np.ndarray, energy: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return |E - energy|/scale of phase points z (2n, ...); inf where the energy has no value.

    The error that rounding of E or of z may make, as where V has a large constant or an orbit rests, does not count; 0
    where the system loses energy.
    """
    if system.lossy:
        return np.where(np.isfinite(z).all(axis=0), 0.0, np.inf)
    with np.errstate(all="ignore"):
        T = system.kinetic_energies(z)
        V = system.potential_energies(z)
        drift = np.maximum(np.abs(T + V - energy) - ROUNDING * (T + np.abs(V) + np.abs(energy)), 0.0) / scale
        far = drift > NOTICED
        if far.any():  # next to an equilibrium the last digits of z have more energy than the motion
            near = z[:, far]
            away = (V - energy + T)[far]
            noise = [np.abs(system.potential_energies(near * (1 + sign * WALK)) - V[far]) for sign in (-1, 1)]
            drift[far] = np.minimum(
                drift[far],
                np.maximum(np.abs(away) - np.maximum(*noise), 0.0) / np.broadcast_to(scale, drift.shape)[far],
            )
    return np.where(np.isfinite(drift), drift, np.inf)
