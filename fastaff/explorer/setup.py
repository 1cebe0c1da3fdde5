"""The data of a page: systems with their parameters and code, schemes, and where it starts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..chaos.streamed import symplectic_frame
from ..core.names import named
from ..core.numbers import kind_of, real, shown
from ..jobs.system import RATES, described
from ..runs.schemes.catalogue import SCHEMES, Splitting
from ..runs.schemes.collocation import Collocation
from ..sections.named_axes import checked_names
from ..systems import models
from ..systems.formulas.map_source import MAX_ROWS
from ..systems.formulas.section_text import EQUALS, TURNING
from ..systems.models.mechanics import System, system_of
from ..systems.models.sections import AngleEquals, Hyperplane
from .parameters import parameter_values
from .records import model_code

NOWHERE: dict[str, Any] = {"energy": None, "p_eta": 0.0, "p_gamma": 0.0}
"""Values of the energy surface in the set-up of a map."""

NAMED: dict[str, tuple[str, str, str, dict[str, Any]]] = {
    "neo-hookean": (
        "NeoHookean",
        "Neo-Hookean body",
        "V = G/2 (D₁² + D₂² − 2) − G ln(D₁D₂) + K/2 (D₁D₂ − 1)²",
        {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2},
    ),
    "hyperelastic": (
        "Hyperelastic",
        "Hyperelastic body",
        "V = C (1/(D₁D₂) + (D₁² + D₂²)/2)",
        {"energy": 3.5, "p_eta": 0.3, "p_gamma": 0.2},
    ),
    "harmonic": (
        "Harmonic",
        "Harmonic body",
        "V = C (D₁² + D₂²)/2",
        {"energy": 2.0, "p_eta": 0.3, "p_gamma": 0.2},
    ),
    "anharmonic": (
        "Anharmonic",
        "Anharmonic body",
        "V = C (D₁² + D₂²)/2 + 4C/(D₁ + D₂)²",
        {"energy": 3.5, "p_eta": 0.3, "p_gamma": 0.2},
    ),
    "heavy-top": (
        "HeavyTop",
        "Heavy-top body",
        "V = C r/2 + A cos ϑ/r, r = α² + β²",
        {"energy": 2.0, "p_eta": 0.5, "p_gamma": 0.4},
    ),
    "henon-heiles": (
        "HenonHeiles",
        "Hénon–Heiles",
        "V = (x² + y²)/2 + λ (x²y − y³/3)",
        {"energy": 0.125, "p_eta": 0.0, "p_gamma": 0.0},
    ),
    "double-pendulum": (
        "DoublePendulum",
        "Double pendulum",
        "H = (p₁² + 2p₂² − 2p₁p₂ cos(q₁ − q₂))/(2 + 2 sin²(q₁ − q₂)) − 2 cos q₁ − cos q₂ at unit masses, lengths and g",
        {"energy": -1.0, "p_eta": 0.0, "p_gamma": 0.0},
    ),
    "standard-map": ("StandardMap", "Standard map", "p′ = p + K sin x, x′ = x + p′", NOWHERE),
    "henon-map": (
        "HenonMap",
        "Hénon’s map",
        "x′ = cx + s(p + x²), p′ = c(p + x²) − sx, c = cos 2πν, s = sin 2πν",
        NOWHERE,
    ),
    "mcmillan-map": ("McMillanMap", "McMillan’s map", "x′ = p, p′ = −x + 2m p/(1 + p²)", NOWHERE),
    "froeschle-map": (
        "FroeschleMap",
        "Froeschlé’s map",
        "p_i′ = p_i + K_i sin x_i + b sin(x_1 + x_2), x_i′ = x_i + p_i′",
        NOWHERE,
    ),
    "one-turn-map": (
        "OneTurnMap",
        "One-turn map, 4-D Hénon",
        "kicks x² − y² and −2xy, those of an octupole, then turns by 2πν_x and 2πν_y",
        NOWHERE,
    ),
}
"""Class, title, formula and first surface of the systems that every page has; a map has none."""

BODY_SECTIONS = (("alpha-turning", None), ("beta-turning", None), ("alpha=c", 1.0), ("beta=c", 0.5), ("area=c", 1.0))


def named_body(name: str) -> Any:
    """Return the system of that name with its usual parameters."""
    made = getattr(models, NAMED[name][0])()
    return made if hasattr(made, "coordinates") else models.Body(made)


def system_record(system: System, name: str, title: str, formula: str, start: dict[str, Any]) -> dict[str, Any]:
    """Return the record of a system for a page."""
    count = system.moving if system.canonical else system.rows
    names, momenta = (list(rows[:count]) for rows in (system.names, system.row_names[len(system.names) :]))
    if system.iterated or system.driven:
        kind = "map"
    elif system.isotropic:
        kind = "body"
    else:
        kind = "plane"
    kind = kind if system.canonical or system.iterated else "ode"
    sections: Any = BODY_SECTIONS
    if kind != "body":
        sections = [(plane, None) for plane in planes(system)] if kind == "map" else [(f"{q}=c", 0.0) for q in names]
    return {
        "name": name,
        "title": title,
        "formula": formula,
        "kind": kind,
        "coordinates": names,
        "momenta": momenta,
        "parameters": [_slider(key, value) for key, value in parameter_values(system.model).items()],
        "code": model_code(system),
        "sections": [{"name": section, "constant": constant} for section, constant in sections],
        "energy": start["energy"],
        "p_eta": start["p_eta"],
        "p_gamma": start["p_gamma"],
        "driven": system.driven,
        "line": system.iterated and system.rows == 1,
        "phase": start.get("phase"),
        "job": job_record(system),
    }


def planes(system: System) -> list[str]:
    """Return the planes of a map that a page has: each coordinate with its momentum, or one variable with its image."""
    if system.rows == 1:
        return list(system.names)
    return [f"{system.row_names[k]},{system.row_names[system.n + k]}" for k in range(system.moving)]


def plane_record(system: System, fixed: Any, grid: Any = None) -> dict[str, Any]:
    """Return the first view of the page of a map: its plane, that of a grid if there is one, and the other rows."""
    rows = system.row_names
    given = checked_names("fixed", () if fixed is None else fixed, "numbers")
    others = {named("fixed", name, rows): real(f"fixed[{name!r}]", value) for name, value in given.items()}
    plane = planes(system)[0]
    if grid is not None:
        plane = ",".join(grid.names)
        if plane not in planes(system):
            raise ValueError(
                f"background must be over a plane of the map, {' or '.join(planes(system))}; its axes are {plane}"
            )
        for row, name in enumerate(rows):
            if name not in grid.names:
                others[name] = float(grid.z0[row, 0])
                if (grid.z0[row] != others[name]).any():
                    raise ValueError(f"background must be over one plane of the map: {name} is not the same everywhere")
    for name in plane.split(","):
        if name in others:
            raise ValueError(f"fixed must be of rows outside of the plane {plane}, got {name}")
    kept = {"energy": None, "section": plane, "constant": None, "direction": 1}
    return {**kept, "others": {name: others.get(name, 0.0) for name in rows} if len(rows) > 2 else {}}


def job_record(system: System) -> dict[str, Any] | None:
    """Return the keys of a job's table [model] that name a system, without its parameters; None if there are none."""
    found = described(system)
    keys = ("model", "formula", "hamiltonian", "map", "ode", "periodic", "coordinates", "momenta", "domain", *RATES)
    return None if found is None else {key: getattr(found, key) for key in keys if getattr(found, key) is not None}


def _slider(name: str, value: float) -> dict[str, Any]:
    """Return a parameter with a range around its value."""
    low, high = (0.0, 2.0) if value == 0 else sorted((value * 0.1, value * 3.0))
    return {"name": name, "value": value, "from": low, "to": high}


def named_systems() -> list[dict[str, Any]]:
    """Return the records of the systems of the package."""
    return [system_record(system_of(named_body(name)), name, *entry[1:]) for name, entry in NAMED.items()]


def page_schemes() -> list[dict[str, Any]]:
    """Return the splittings and collocations of the package as data."""
    return [scheme_record(scheme) for scheme in SCHEMES.values() if isinstance(scheme, (Splitting, Collocation))]


def scheme_record(scheme: Splitting | Collocation) -> dict[str, Any]:
    """Return a scheme as data: drifts and kicks, or for a collocation m_ij = a_ij/b_j in rows, and b."""
    if isinstance(scheme, Collocation):
        a = scheme.a_array.ravel().tolist()
        b = scheme.b_array.tolist()
        return {"name": scheme.name, "order": scheme.order, "collocation": True, "a": a, "b": b}
    return {
        "name": scheme.name,
        "order": scheme.order,
        "nystrom": scheme.nystrom,
        "a": list(scheme.drift),
        "b": list(scheme.kick),
    }


def frames() -> dict[str, list[float]]:
    """Return the tangent vectors that orbits start with, by degrees of freedom: the first of `chaos_map`."""
    return {str(n): [float(x) for x in symplectic_frame(n, 1)[0]] for n in range(1, MAX_ROWS // 2 + 1)}


def section_record(section: Any, system: System) -> dict[str, Any]:
    """Return name, constant and direction of a section; TypeError for one that the explorer has not."""
    known = dict(BODY_SECTIONS)
    simple = {made: name for name, made in TURNING.items() if name in known}
    constant = {made: f"{name}=c" for name, made in EQUALS.items() if f"{name}=c" in known}
    kind = type(section)
    if system.isotropic and kind in simple:
        return {"section": simple[kind], "constant": None, "direction": int(section.direction)}
    if system.isotropic and kind in constant:
        return {"section": constant[kind], "constant": float(section.constant), "direction": int(section.direction)}
    names = system.names
    if isinstance(section, (Hyperplane, AngleEquals)) and not system.isotropic and len(section.normal) == system.rows:
        at = np.flatnonzero(section.normal)
        places = 2 if system.canonical else system.rows
        if at.size == 1 and at[0] < places and math.isfinite(section.offset):
            factor = float(section.normal[at[0]])
            direction = int(section.direction) * (1 if factor > 0 else -1)
            return {"section": f"{names[at[0]]}=c", "constant": section.offset / factor, "direction": direction}
    takes = (
        "AlphaTurning, BetaTurning, AlphaEquals, BetaEquals, AreaEquals"
        if system.isotropic
        else f"Hyperplane with one coordinate, {' or '.join(f'{name} = c' for name in names)},"
    )
    raise TypeError(f"section must be {takes} for {kind_of(system.model)}, got {shown(section)}")
