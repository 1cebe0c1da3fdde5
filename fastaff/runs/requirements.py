"""What a call requires of a model and of its arguments, and how it refuses.

First the table of terms of equations that do not go with an analysis, an argument or a scheme; then derivatives of
user-defined models, which are compared with differences at and near the initial conditions; then checks of input. Each
check raises at once and names the argument, the value given and the values allowed.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from ..core.foreign import call_for
from ..core.numbers import LONGEST, kind_of, listed, numbers, reason, shown, titled
from ..engine.kinds import Kind
from ..engine.values import FAILS, at_points, by_identity, is_as_met, is_value, parameters
from ..systems.charts import Chart
from ..systems.formulas.section_text import section_forms
from ..systems.models.contracts import Autonomous, Map, Nonseparable, Potential, Section, SeparableModel
from ..systems.models.mechanics import System, system_of
from ..systems.models.sections import Stroboscopic
from .schemes.catalogue import Collocation, Nystrom, RungeKutta, Scheme, Splitting
from .schemes.time_transformed import TimeTransformed
from .starts import in_rows

NEEDS: dict[str, frozenset[str]] = {
    "equations": frozenset(),
    "a start by rows": frozenset({"drive"}),
    "regular motion": frozenset({"loss", "rates"}),
    "Hamilton's equations": frozenset({"loss", "noncanonical", "rates", "iterates"}),
    "an energy surface": frozenset({"drive", "loss", "energy", "rates", "iterates"}),
    "H = T(p) + V(q)": frozenset({"term"}),
    "a page": frozenset({"kicks"}),
}
"""The need of an analysis as a whole: the terms that it does not take, by name or by their words
(`engine.kinds.Kind`).
"""

_WHOLE = (
    "scheme {got} requires H = T(p) + V(q) with T least at p = 0, and {model} has H(q, p). Use GAUSS16, GAUSS8, DOP853 "
    "or VERNER9."
)

REFUSALS = {
    "a time": {"iterates": "{argument} is not supported for maps: {instead}, got {got}."},
    "a start by energy": {
        "iterates": "{argument} is not supported for maps, which have no energy, got {got}.",
        "energy": "{argument} requires the energy T + V; that of a system that {has} has more terms, got {got}.",
        "loss": "{argument} requires a conserved energy, which a system that {has} does not have, got {got}.",
        "rates": "{argument} is not supported for ODE systems, which have no energy, got {got}.",
    },
    "a page of orbits": {
        "drive": "{argument} is not supported for driven systems: the page plots the state once per period, got {got}.",
        "rates": "{argument} is not supported for ODE systems, which have no energy, got {got}.",
    },
    "signals of coordinates alone": {
        "drive": "signals must be given for a driven system without its own: functions of its coordinates and its time."
    },
    "a return": {
        "drive loss": "{named} has a drive and {has}. Write both as equations, fa.ode.",
        "loss": "{named} {has} and no drive, so no orbit returns. Write a drive and friction as equations, fa.ode.",
    },
    "a return at an energy": {
        "iterates": "energy is not supported for maps, which have none, got {got}.",
        "rates": "energy is not supported for ODE systems, which have none, got {got}.",
        "drive": "energy is not supported for driven systems, which do not conserve it, got {got}.",
    },
    "a time of return": {"drive": "max_time is not supported for driven systems, got {got}."},
    "a branch along the energy": {
        "iterates": "parameter must be a number for a map, which has no energy to follow, got None.",
        "rates": "parameter must be a number for an ODE system, which has no energy to follow, got None.",
        "drive": "parameter must be a number for a driven system, which has no energy to follow, got None.",
    },
    "an indicator of the energy": {
        "loss": "indicators must be {instead} for a system that {has}, got {got}.",
        "rates": "indicators must be {instead} for ODE systems, got {got}.",
    },
    "an indicator along the flow": {
        "drive": "{argument} is not supported for driven systems. Use FLI, MEGNO, SALI or the Lyapunov spectrum.",
        "iterates": "{argument} is not supported for maps. Use FLI or GALI.",
    },
    "a scheme by energy": {
        "loss": "scheme {got} requires a conserved energy, and {model} {has}. Use KAHAN_LI8 or DOP853.",
        "nonseparable": _WHOLE,
    },
    "a fictitious time": {
        "drive": "scheme {got} is not supported for driven systems. Use a splitting or a Runge-Kutta scheme such as "
        "KAHAN_LI8.",
        "substep": "scheme {got} requires H = T(p) + V(q), and {model} {has}. Use KAHAN_LI8, AUTO or DOP853.",
    },
    "a splitting": {
        "rates": "scheme {got} requires a Hamiltonian system. Use DOP853, VERNER9 or RK4 for an ODE system.",
        "nonseparable": _WHOLE,
    },
    "an accuracy": {"rates": "accuracy is not supported for ODE systems, got {got}. Use rtol and atol."},
    "a step of its own": {"rates": "step must be given for an ODE system with {got}, which has no step-size control."},
    "forces of the coordinates alone": {
        "kicks": "scheme {got} has its order {order} only if forces depend on the coordinates alone, and {model} "
        "{has}. Use KAHAN_LI8."
    },
    "accelerations of the coordinates alone": {
        "drifts": "scheme {got} requires accelerations that depend on the coordinates alone, and {model} {has}. Use "
        "BLANES_CASAS_ESCORIHUELA8."
    },
}
"""The request: the terms, by name or by their words, that together do not go with it, and the sentence with an
alternative.
"""

OF_MODELS = ("a return", "an indicator of the energy")
"""Needs that a model as a whole does not meet: refused by TypeError; a wrong argument beside it by ValueError."""


def check_needs(system: System, need: str, **said: Any) -> None:
    """Raise the refusal of the first terms of a model's equations that do not go with a request; said: the numbers and
    names in its sentence beside the model's.
    """
    for words, sentence in REFUSALS[need].items():
        if system.words >= {*words.split()}:
            error = TypeError if need in OF_MODELS else ValueError
            model = system.model
            has = "" if system.own is None else system.own.has
            raise error(sentence.format(model=kind_of(model), named=titled("model", model), has=has, **said))


def check_given(system: System, need: str, instead: str = "", **given: Any) -> None:
    """Raise the refusal of the first argument that is given and does not go with a model's equations."""
    for argument, value in given.items():
        if value is not None:
            check_needs(system, need, argument=argument, instead=instead, got=shown(value))


def check_kind(model: Any, name: str, need: str) -> None:
    """Refuse a model whose equations have terms that an analysis does not take."""
    kind = getattr(model, "kind", Kind.SEPARABLE)
    if not isinstance(kind, Kind):
        raise TypeError(f"{name}.kind must be a fastaff.models.contracts.Kind, got {shown(kind)}")
    if kind.words & NEEDS[need]:
        got = next((words for term, words in GOT.items() if term in kind.words), kind.equations)
        raise TypeError(f"{titled(name, model)} must be {WANTED[need]}, got {got}.{_instead_of(kind, need)}")
    if need == "regular motion":
        check_momenta(name, model)


def check_momenta(name: str, model: Any) -> None:
    """Refuse a map of one variable, which turns in no plane of a coordinate and its momentum."""
    if getattr(model, "momenta", None) == ():
        raise TypeError(f"{titled(name, model)} must have momenta, got a map of one variable. Use chaos_map.")


GOT = {
    "rates": "an ODE system",
    "iterates": "a map",
    "loss": "a system with friction",
    "drive": "a driven system",
    "nonseparable": "H(q, p)",
}
"""The terms of equations in words."""

WANTED = {
    "a start by rows": "a system without a drive",
    "regular motion": "a Hamiltonian system without friction, or a map",
    "Hamilton's equations": "a Hamiltonian system without friction",
    "an energy surface": "a system that conserves H = T(p) + V(q) or H(q, p)",
    "H = T(p) + V(q)": "a system H = T(p) + V(q)",
    "a page": "a system without friction",
}
"""The needs in words."""


def _instead_of(kind: Kind, need: str) -> str:
    """Return the call that tells most about the regular motion of such a system."""
    if need not in ("regular motion", "H = T(p) + V(q)"):
        return ""
    if kind.words & NEEDS["regular motion"]:
        return " Use fa.naff on samples of fa.integrate."
    return " Use fa.fit_torus for actions and frequencies."


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
    who = titled(name, system.model)
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
        if not system.has_tangent_velocity:
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
        raise ValueError(
            f"{what}: that of {names[row]} is {said[row, point]:.9g}, by differences {truth[row, point]:.9g}{by}"
        )


LARGEST = 1e150
"""Size of a model's parameters whose squares are still numbers."""


def current_system(model: Any) -> System:
    """Return the system of a user's model, which may not be checked yet. It is made anew if methods of the model's
    class have been replaced since it was checked.
    """
    if _needs_met(model):
        is_as_met(model)
    return system_of(model)


def checked_model(model: Any, name: str = "model", needs: str = "equations") -> Any:
    """Return `model` if it meets a need of NEEDS, see `checked_system`."""
    return checked_system(model, name, needs).model


def checked_system(model: Any, name: str = "model", needs: str = "equations") -> System:
    """Return the system of a user's model if it meets a need of NEEDS: a NamedTuple with the methods of the physics and
    finite parameters.
    """
    if not is_value(model):
        raise TypeError(
            f"{name} must be a model such as Body(Hyperelastic()) or HenonHeiles(), got {_given(model)} "
            f"({type(model).__name__}){_instead(model)}"
        )
    system = current_system(model)
    met = _needs_met(model)
    if needs in met:
        return system
    missing = lacking(
        model,
        Map
        if system.iterated
        else SeparableModel
        if system.separable
        else Nonseparable
        if system.canonical
        else Autonomous,
    )
    if missing and hasattr(model, "matrix_value"):
        raise TypeError(f"{name} {shown(model, 40)} is a potential. Use fa.models.Body3({type(model).__name__}(...)).")
    if isinstance(model, Potential) and missing:
        raise TypeError(f"{name} {shown(model)} is a potential. Use Body({type(model).__name__}(...)).")
    if missing:
        raise TypeError(f"{titled(name, model)} has no {listed(missing)}{_unnamed_kind(model)}")
    check_kind(model, name, needs)
    if len(set(system.row_names)) < len(system.row_names):
        raise ValueError(f"{titled(name, model)} must have different names of its rows, got {listed(system.row_names)}")
    body = system.planar or system.breathes
    if body and not is_value(model.potential):
        raise TypeError(
            f"{name}.potential must be a NamedTuple such as Hyperelastic(C=1.0), got {shown(model.potential)}"
            f"{_instead(model.potential)}"
        )
    if body and lacking(model.potential, Potential):
        raise TypeError(
            f"{name}.potential must be a potential of A and B (value, slopes, margin), got {shown(model.potential)}"
        )
    flat = _parameters(name, model)
    if not np.all(np.isfinite(flat)):
        raise ValueError(f"{name} has a parameter that is not finite: {shown(model)}")
    if np.any(np.abs(flat) > LARGEST):
        raise ValueError(f"{name} has a parameter beyond {LARGEST:g}, whose square overflows: {shown(model)}")
    if hasattr(model, "potential") and hasattr(model, "mu") and not model.mu > 0:
        raise ValueError(f"{name}.mu must be positive, got {shown(model.mu)}")
    if system.breathes and not model.breathing > -1:
        raise ValueError(f"{name}.c must be above -1 for a positive kinetic energy, got {shown(model.breathing)}")
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
        raise TypeError(f"{titled(name, model)} {has}: it must have {method}(), a number ({shown(problem)})") from None
    if not abs(rate) <= LARGEST:
        raise ValueError(f"{name} {shown(model)} must have a finite {method}(), got {shown(rate)}")


def _check_turning(name: str, system: System) -> None:
    """Refuse a model in a rotating frame whose kinetic energy changes under the rotation."""
    model = system.model
    n = system.moving
    if n < 2:
        raise ValueError(f"{titled(name, model)} must have two coordinates or more for a rotating frame, got {n}")
    units = np.eye(system.n)[:n]
    mass = np.array([np.array(model.velocity(*unit), dtype=np.float64)[:n] for unit in units])
    round_ = mass[0, 0] == mass[1, 1] > 0 and not mass[0, 1:].any() and not mass[1, 2:].any() and not mass[1:, 0].any()
    if not (system.quadratic and round_ and not mass[2:, :2].any()):
        raise ValueError(
            f"{titled(name, model)} must have T = (p_x^2 + p_y^2)/2m + ... with one mass m of its first two "
            "coordinates for a rotating frame"
        )


def _check_drive(name: str, system: System) -> None:
    """Refuse a driven model whose last coordinate is not the time, with a period."""
    what = f"{titled(name, system.model)} is driven"
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


def _given(value: Any) -> str:
    """Return a value in a message, a class by its name."""
    return value.__name__ if isinstance(value, type) else shown(value, 40)


def _instead(given: Any) -> str:
    """Return a hint for a user who gave a class, a name, or a system of another tool."""
    if call := call_for(given):
        return call
    if isinstance(given, type) and lacking(given, Potential) == []:
        return f". Use Body({given.__name__}()), with its parameters."
    if isinstance(given, type) and given.__name__.isidentifier():
        return f". Use {given.__name__}(), with its parameters."
    return ". Names are for jobs and the command line." if isinstance(given, str) else ""


def _unnamed_kind(model: Any) -> str:
    """Return a hint for a class that has all methods of a kind, and does not name it."""
    contracts = {"MAP": Map, "NONSEPARABLE": Nonseparable, "FLOW": Autonomous}
    kinds = () if hasattr(model, "kind") else (kind for kind, entry in contracts.items() if not lacking(model, entry))
    return next((f". With its methods it must have kind = fastaff.models.contracts.Kind.{kind}." for kind in kinds), "")


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
                z, dz = (*q, *p)[:length], (*p, *q)[:length]
                rows = [model.periods(), model.iterate(*z), model.tangent_iterate(*z, *dz)]
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
        raise TypeError(f"{name} {shown(model)} does not give numbers ({reason(problem)})") from None
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


def checked_tangent_system(model: Any, name: str = "model") -> System:
    """Return the system of a user's model if tangent vectors can follow it: it has changes of its forces and, if not
    linear, velocities.
    """
    system = checked_system(model, name)
    if not system.separable:
        if not (system.iterated or hasattr(model, "tangent_rates")):
            raise TypeError(f"{titled(name, model)} must have tangent_rates(z..., dz...) for deviation vectors")
        return system
    try:
        with np.errstate(all="ignore"):
            change = model.tangent_force(*_some_point(system.n)[0], *np.ones(system.n))
    except AttributeError:
        raise TypeError(
            f"{titled(name, model)} must have second derivatives: tangent_force(q..., dq...) of a model, curvatures of "
            "a potential, univariate(value, slope, curvature)"
        ) from None
    if any(map(np.iscomplexobj, change)):
        raise TypeError(f"{titled(name, model)}.tangent_force must give real numbers, some are complex")
    if not (system.quadratic or system.has_tangent_velocity):
        raise ValueError(
            f"{titled(name, model)} must have tangent_velocity(p..., dp...) for deviation vectors: its velocity is not "
            "linear in the momenta"
        )
    return system


def checked_scheme(scheme: Any) -> Scheme:
    """Return `scheme` if it is one that steps in time itself."""
    if isinstance(scheme, TimeTransformed):
        raise TypeError(
            f"scheme must step in time, such as fastaff.KAHAN_LI8, got {scheme.name}, which only integrate and "
            "poincare_map take"
        )
    if not isinstance(scheme, (Splitting, Nystrom, RungeKutta, Collocation)):
        raise TypeError(
            f"scheme must be a scheme such as fastaff.KAHAN_LI8, or its name, got {shown(scheme)} "
            f"({type(scheme).__name__})"
        )
    return scheme


def suited_scheme(scheme: Any, system: System) -> Any:
    """Return `scheme` if its order holds for the model."""
    if not getattr(scheme, "nystrom", False):
        return scheme
    check_needs(system, "forces of the coordinates alone", got=scheme.name, order=scheme.order, argument="model")
    if isinstance(scheme, Nystrom):
        check_needs(system, "accelerations of the coordinates alone", got=scheme.name, argument="model")
    if not system.quadratic:
        raise ValueError(
            f"scheme {scheme.name} has its order {scheme.order} only if T is quadratic in the momenta, which it is not "
            "here. Use KAHAN_LI8."
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
        what = "of the angle such as univariate(f) or Zero()" if angle else "such as Oscillator(k=1.0) or univariate(f)"
        raise TypeError(f"{field} must be a function {what}, got {shown(entry)}")
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
        instead = f". Use {section.__name__}()." if isinstance(section, type) else ""
        raise TypeError(
            f"section must be a text such as {shown(section_forms(system)[0].replace('=c', '=0'))} or a section such "
            f"as fa.Hyperplane(normal, offset), got {_given(section)} ({type(section).__name__}){instead}"
        )
    if not (isinstance(section.direction, (int, float, np.number)) and section.direction in (-1, 0, 1)):
        raise ValueError(f"section.direction must be -1, 0 or +1, got {shown(section.direction)}")
    if not np.all(np.isfinite(_parameters("section", section))):
        raise ValueError(f"section has a parameter that is not finite: {shown(section)}")
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
            f"section must depend on the {rows} rows of {kind_of(system.model)}, such as "
            f"{listed(section_forms(system)[:3])}, got {shown(section)}"
        ) from None
    if isinstance(section, Stroboscopic):
        if not system.driven:
            raise ValueError(
                f"section must be {listed(section_forms(system))} for a system without a drive, got {shown(section)}"
            )
    elif system.driven:
        _check_timeless(section, system)
    elif rows % 2 and normal is None:
        raise TypeError(
            f"section must be Hyperplane or AngleEquals for an odd number of variables, {rows}, got {shown(section)}"
        )
    return section


def _check_timeless(section: Any, system: System) -> None:
    """Refuse a section whose function changes with the time, as the time starts again after every period."""
    now = np.linspace(0.7, 1.9, 2 * system.n)
    later = now.copy()
    later[system.moving] += 0.3 * system.model.period
    if section.value(*now) != section.value(*later):
        raise ValueError(
            f"section must be one of constant time, such as 't=0', or not depend on the time t, got {shown(section)}"
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
            f"{name} must have shape ({rows},) or ({rows}, orbits) for {kind_of(system.model)}, rows "
            f"{listed(system.names)}{' and their momenta' if system.canonical else ''}, got shape {z.shape}"
            f"{f'. Try {name}.T.' if z.ndim == 2 and z.shape[1] == rows else ''}"
            f"{f'. Try {name}.reshape({rows}, -1).' if z.ndim > 2 and z.shape[0] == rows else ''}"
        )
    z = z.reshape(rows, -1)
    bad = np.flatnonzero(~np.isfinite(z).all(axis=0))
    if bad.size:
        raise ValueError(
            f"{name} must be finite, got {shown(z[:, bad[0]].tolist())} in orbit {bad[0]}{and_others(bad.size)}"
        )
    if system.driven:
        z[system.moving] = system.model.phase(z[system.moving])
    with np.errstate(all="ignore"):
        margin = np.broadcast_to(at_points(system.model, "margin", *z[: system.positions]), z.shape[1:])
    outside = np.flatnonzero(~(margin > 0))
    if outside.size:
        of = "" if system.nonseparable else " of the potential"
        raise ValueError(
            f"{name} must lie in the domain{of} ({_where(system)}), got margin "
            f"{margin[outside[0]]:.6g} in orbit {outside[0]}{and_others(outside.size)}"
        )
    return carried(z, system)


def and_others(count: int) -> str:
    """Return the words for the wrong orbits after the first one, of `count` in all."""
    return "" if count == 1 else f" and {count - 1} other{'' if count == 2 else 's'}"


def _where(system: System) -> str:
    """Return words for the domain of a model."""
    domain = getattr(system.model, "domain", None)
    if domain:
        return f"{domain if len(domain) <= LONGEST else domain[:LONGEST] + ' ...'} > 0"
    if system.nonseparable:
        return 'off the axis of a chart; for a top use AsymmetricTop(..., chart="quaternion")'
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
    if system.dissipative:
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
