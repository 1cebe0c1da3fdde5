"""Equations of motion of a model that was written as text, with forces beside those of its energy."""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from ...core.numbers import listed, shown
from ..models import Body, DoublePendulum, HenonHeiles
from ..models.contracts import Kind
from ..models.potentials import Anharmonic, Harmonic, HeavyTop, Hyperelastic, NeoHookean
from .grammar import TIME, UnknownName, parse
from .library import Request
from .variables import VARIABLES

PHASE = "cosine", "sine"
"""Variables cos(w t) and sin(w t): they run round the unit circle, which attracts."""

INERTIA = "inertia"
"""Parameter of a body's flow for its mu; inertia_1, inertia_2, ... for coordinates with masses."""


class EnergyText(NamedTuple):
    """V or H(q, p) of a model, its domain, and the periods of its coordinates, as text."""

    formula: str
    domain: str | None = None
    periods: Mapping[str, str] = {}


BUILT_IN: dict[type, EnergyText] = {
    Harmonic: EnergyText("C*(D1**2 + D2**2)/2"),
    Anharmonic: EnergyText("C*(D1**2 + D2**2)/2 + 4*C/(D1 + D2)**2", "(D1 + D2)**2"),
    Hyperelastic: EnergyText("C*(1/(D1*D2) + (D1**2 + D2**2)/2)", "D1*D2"),
    HeavyTop: EnergyText("C*(D1**2 + D2**2)/2 + 2*A*D1*D2/(D1**2 + D2**2)**2", "D1**2 + D2**2"),
    NeoHookean: EnergyText("G/2*(D1**2 + D2**2 - 2) - G*log(D1*D2) + K/2*(D1*D2 - 1)**2", "D1*D2"),
    HenonHeiles: EnergyText("(x**2 + y**2)/2 + lam*(x**2*y - y**3/3)"),
    DoublePendulum: EnergyText(
        "(m_2*l_2**2*p1**2 + (m_1 + m_2)*l_1**2*p2**2 - 2*m_2*l_1*l_2*cos(q1 - q2)*p1*p2)"
        "/(2*m_2*l_1**2*l_2**2*(m_1 + m_2*sin(q1 - q2)**2)) - (m_1 + m_2)*g*l_1*cos(q1) - m_2*g*l_2*cos(q2)",
        periods={"q1": "2*pi", "q2": "2*pi"},
    ),
}
"""Texts of the potentials, in the stretches of a body, and of the models that are classes of fastaff."""

_STRETCHES = "D1", "D2"
_MASS = re.compile(r"\bm_(?=\d+\b)")
_WAVE = re.compile(r"\b(cos|sin)\(\s*(?:(?P<rate>[\w.]+)\s*\*\s*t|t(?:\s*\*\s*(?P<after>[\w.]+))?)\s*\)")


def equations(
    model: Any, forces: Mapping[str, str], parameters: Mapping[str, Any]
) -> tuple[list[tuple[str, str]], str | None, dict[str, Any]]:
    """Return equations q' = dH/dp, p' = -dH/dq + force of a model, the domain, and the parameters of both.

    Raises ValueError or TypeError for models without a text, forces on unknown coordinates, and other drives than
    cos(w t) and sin(w t) of one rate.
    """
    H, domain, (names, momenta), own = _written(model)
    twice = [name for name in parameters if name in own]
    if twice:
        raise ValueError(
            f"parameter {shown(twice[0])} is that of the model, {own[twice[0]]:g}: rename that of the forces"
        )
    pushes, rate = _pushes(forces, names)
    found = []
    for row, rate_of_row in _canonical(H, names, momenta, tuple(own)):
        push = pushes.get(names[momenta.index(row)], "") if row in momenta else ""
        found.append((row, f"{rate_of_row} + ({push})" if push else rate_of_row))
    if rate:
        c, s = PHASE
        known = (*names, *momenta, *own, *parameters)
        for name in PHASE:
            if name in known:
                raise ValueError(f"forces: {name} is the phase of the drive: rename the parameter or coordinate")
        draw = f"(1 - {c}**2 - {s}**2)"
        found += [(c, f"-{rate}*{s} + {c}*{draw}"), (s, f"{rate}*{c} + {s}*{draw}")]
    return found, domain, {**own, **parameters}


def periods_of(model: Any) -> dict[str, str]:
    """Return the texts of the periods of a model's coordinates, by name."""
    if type(model) in BUILT_IN:
        return dict(BUILT_IN[type(model)].periods)
    request = Request(*model._request) if hasattr(model, "_request") else None
    return {} if request is None else {q: text for q, text in zip(request.coordinates, request.periods) if text}


@functools.lru_cache(maxsize=64)
def _canonical(
    H: str, names: tuple[str, ...], momenta: tuple[str, ...], parameters: tuple[str, ...]
) -> list[tuple[str, str]]:
    """Return dH/dp of the coordinates and -dH/dq of the momenta, as text."""
    import sympy

    from .sympy_bridge import to_sympy, to_text

    symbols = {name: sympy.Symbol(name, real=True) for name in (*names, *momenta, *parameters)}
    energy = to_sympy(parse(H, (*names, *momenta), parameters, length=len(H)), symbols)
    pairs = list(zip(names, momenta, strict=True))
    moved = [(q, to_text(energy.diff(symbols[p]))) for q, p in pairs]
    return moved + [(p, to_text(-energy.diff(symbols[q]))) for q, p in pairs]


def _written(model: Any) -> tuple[str, str | None, tuple[tuple[str, ...], tuple[str, ...]], dict[str, float]]:
    """Return H as text, its domain, its coordinates and momenta, and its parameters."""
    body = isinstance(model, Body)
    value = model.potential if body else model
    known: Any = BUILT_IN.get(type(value), value)
    text = getattr(known, "formula", None)
    kind = getattr(model, "kind", None)
    whole = body or hasattr(model, "coordinates")  # a potential alone has no mass
    if not isinstance(text, str) or kind not in (None, Kind.NONSEPARABLE) or not whole:
        raise TypeError(
            "text must be equations or a model made of a formula, without drive, rotation and friction, got "
            f"{shown(model)} ({type(model).__name__})"
        )
    names = _STRETCHES if body else tuple(value.coordinates)
    momenta = tuple(getattr(value, "momenta", ())) or tuple(f"p_{name}" for name in names)
    parameters = {_MASS.sub(f"{INERTIA}_", key): entry for key, entry in value._asdict().items()}
    masses = [f"*{INERTIA}_{i + 1}" if f"{INERTIA}_{i + 1}" in parameters else "" for i in range(len(names))]
    if body:
        try:
            parse(text, _STRETCHES, parameters, length=len(text))
        except UnknownName as wrong:
            if wrong.name not in VARIABLES:
                raise
            raise ValueError(
                f"text: pulled along its stretches a body is a formula of D1 and D2, got {shown(text)}"
            ) from None
        masses = [f"*{INERTIA}"] * 2
        parameters[INERTIA] = model.mu
    kinetic = (
        ""
        if hasattr(value, "momenta")
        else " + ".join(f"{p}**2/(2{m})" for p, m in zip(momenta, masses, strict=True)) + " + "
    )
    return f"{kinetic}({_MASS.sub(f'{INERTIA}_', text)})", getattr(known, "domain", None), (names, momenta), parameters


def _pushes(forces: Mapping[str, str], names: tuple[str, ...]) -> tuple[dict[str, str], str]:
    """Return the forces with the phase in place of cos(w t) and sin(w t), and w, "" where there is no drive."""
    example = f"{{{names[0]!r}: 'f*cos(w*t) - g*p_{names[0]}'}}"
    if not isinstance(forces, Mapping) or not all(isinstance(entry, str) for entry in forces.values()):
        raise TypeError(f"forces must be formulas by coordinate such as {example}, got {shown(forces)}")
    found = {}
    rates = set()
    for name, text in forces.items():
        if name not in names:
            raise ValueError(f"forces must be of {listed(names)}, as {example}, got {shown(name)}")
        rates |= {match["rate"] or match["after"] or "1" for match in _WAVE.finditer(text)}
        found[name] = _WAVE.sub(lambda match: PHASE[match[1] == "sin"], text)
        if re.search(rf"\b{TIME}\b", found[name]) or len(rates) > 1:
            raise ValueError(
                f"forces[{shown(name)}] must have the time as cos(w*t) and sin(w*t) of one rate w, got {shown(text)}"
            )
    return found, rates.pop() if rates else ""
