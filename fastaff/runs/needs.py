"""Refusals: the terms of a system's equations that do not go with an analysis, an argument or a scheme."""

from __future__ import annotations

from typing import Any

from ..core.numbers import shown
from ..engine.kinds import KINDS, Kind
from ..systems.models.mechanics import System

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
(`engine.kinds.words_of`).
"""

_WHOLE = (
    "scheme {got} needs velocity(*p) and force(*q) of H = T(p) + V(q), from a class or a text whose T has no poles and "
    "is least at p = 0, and {model} has rates(*q, *p) of H(q, p): take GAUSS16, GAUSS8, DOP853 or VERNER9"
)

REFUSALS = {
    "a time": {"iterates": "{argument} is for systems in time: {instead}; got {got}"},
    "a start by energy": {
        "iterates": "{argument} is for systems in time: a map has no energy; got {got}",
        "energy": "{argument} is for systems whose energy is T + V: one that {has} has more; got {got}",
        "loss": "{argument} is for systems with an energy: one that {has} keeps none; got {got}",
        "rates": "{argument} is for systems with an energy: dz/dt = f(z) has none; got {got}",
    },
    "a page of orbits": {
        "drive": "{argument} does not go with a driven system, whose states once a period are shown; got {got}",
        "rates": "{argument} does not go with dz/dt = f(z), which has no energy; got {got}",
    },
    "angles of coordinates alone": {
        "drive": "angles must be given for {model}, which is driven and has none: of its coordinates, and of its time"
    },
    "a return": {
        "drive loss": "model {model} has a drive and {has}: write both as equations, fa.flow",
        "loss": "model {model} {has} and no drive: it loses energy as long as it moves, so nothing returns; "
        "with a drive, write both as equations, fa.flow",
    },
    "a return at an energy": {
        "iterates": "energy is for systems in time: a map has none; got {got}",
        "rates": "energy must be left out of dz/dt = f(z), which has none, got {got}",
        "drive": "energy must be left out of a driven system, which has none, got {got}",
    },
    "a time of return": {"drive": "max_time must be left out of a driven system, got {got}"},
    "a branch along the energy": {
        "iterates": "parameter must be a number for a map, which has no energy to follow; got None",
        "rates": "parameter must be given for dz/dt = f(z), which has no energy to follow",
        "drive": "parameter must be given for a driven system, which has no energy to follow",
    },
    "an indicator of the energy": {
        "loss": "indicators of {model}, which {has}, are {instead}, got {got}",
        "rates": "indicators of {model}, which is dz/dt = f(z), are {instead}, got {got}",
    },
    "an indicator along the flow": {
        "drive": "{argument} does not suit a driven system, whose flow goes along the time and does not go back: take "
        "FLI, MEGNO, SALI or the Lyapunov spectrum",
        "iterates": "{got} needs a flow, along which a map does not go: take FLI or GALI",
    },
    "a scheme by energy": {
        "loss": "scheme {got} goes by the energy, which {model} loses: take KAHAN_LI8, or DOP853",
        "nonseparable": _WHOLE,
    },
    "a fictitious time": {
        "drive": "scheme {got} steps in a fictitious time, which a driven system has not: take a splitting or a "
        "Runge-Kutta scheme such as fastaff.KAHAN_LI8",
        "substep": "scheme {got} takes H = T(p) + V(q), and {model} {has}: take KAHAN_LI8, AUTO or DOP853",
    },
    "a splitting": {
        "rates": "scheme {got} needs coordinates and momenta: {model} is dz/dt = f(z), which Runge-Kutta schemes run, "
        "such as DOP853, VERNER9 and RK4",
        "nonseparable": _WHOLE,
    },
    "an accuracy": {
        "rates": "accuracy is relative to the amplitudes of a motion with an energy; {model} is dz/dt = f(z): give "
        "rtol and atol, got accuracy={got}"
    },
    "a step of its own": {"rates": "step must be given with {got}, which has no control of steps, for dz/dt = f(z)"},
    "forces of the coordinates alone": {
        "kicks": "scheme {got} has its order {order} only where forces depend on the coordinates alone, and "
        "{argument} {model} {has}: take KAHAN_LI8"
    },
    "accelerations of the coordinates alone": {
        "drifts": "scheme {got} takes accelerations that depend on the coordinates alone, and {argument} {model} "
        "{has}: take BLANES_CASAS_ESCORIHUELA8"
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
            has = "" if system.own is None else system.own.has
            raise error(sentence.format(model=type(system.model).__name__, has=has, **said))


def check_given(system: System, need: str, instead: str = "", **given: Any) -> None:
    """Raise the refusal of the first argument that is given and does not go with a model's equations."""
    for argument, value in given.items():
        if value is not None:
            check_needs(system, need, argument=argument, instead=instead, got=shown(value))


def check_kind(model: Any, name: str, need: str) -> None:
    """Refuse a model whose equations have terms that an analysis does not take."""
    kind = getattr(model, "kind", Kind.SEPARABLE)
    known = isinstance(kind, Kind)
    if not known or kind.words & NEEDS[need]:
        runs = "; ".join(entry.equations for entry in KINDS if not entry.words & NEEDS[need])
        instead = _instead(kind, name) if known and need in ("regular motion", "H = T(p) + V(q)") else ""
        raise TypeError(
            f"{name} {type(model).__name__} is {kind.equations if known else shown(kind)}; what runs here is {runs}"
            f"{instead}"
        )


def _instead(kind: Kind, name: str) -> str:
    """Return the call that tells most about the regular motion of such a system."""
    if kind.words & NEEDS["regular motion"]:
        return (
            f". Lines of an orbit: run = fa.integrate({name}, z0, time=..., samples=4096), "
            "fa.naff(run.samples[:, 0, 0], run.times[1] - run.times[0], lines=3)"
        )
    return (
        f". A torus of one orbit: fit = fa.fit_torus({name}, z0, time=...), with actions fit.J, frequencies fit.nu and "
        "levels by J = 2 pi hbar (n + fit.maslov/4)"
    )
