"""Sections as text: alpha-turning, beta=0.2, x=0, p_x=0. The grammar of jobs, of the command line, of all functions."""

from __future__ import annotations

import re
from typing import Any

from ...core.names import did_you_mean, named, spelled
from ...core.numbers import kind_of, listed, shown
from ..models.mechanics import System, system_of
from ..models.sections import OF_BODIES, AngleEquals, Hyperplane, Stroboscopic
from .grammar import TIME
from .number import number

TURNING = {text: kind for text, kind in OF_BODIES.items() if "constant" not in kind._fields}
VANISHING = {"p_alpha=0": "alpha-turning", "p_beta=0": "beta-turning"}
EQUALS = {text: kind for text, kind in OF_BODIES.items() if "constant" in kind._fields}


def section_forms(system: System) -> tuple[str, ...]:
    """Return the texts for sections of a model, with c for a number."""
    coordinates = tuple(f"{name}=c" for name in system.names)
    if not system.planar:
        return coordinates
    return (*TURNING, *(f"{name}=c" for name in EQUALS), *(() if system.isotropic else coordinates))


def _of_momenta(system: System) -> tuple[str, ...]:
    """Return the texts for sections of constant momenta, which the planes of an isotropic body have not."""
    if system.planar and system.isotropic:
        return ()
    return tuple(f"{name}=c" for name in system.row_names[system.n :][: system.moving])


def _without_planes(text: str, system: System) -> str:
    """Return alpha-turning and beta-turning, the canonical texts of p_alpha = 0 and p_beta = 0, as these momenta of a
    system that is no body.
    """
    known = {turning: momentum for momentum, turning in VANISHING.items() if f"{momentum[:-1]}c" in _of_momenta(system)}
    return known.get(text.strip(), text)


def _unknown(argument: str, asked: str, text: str, forms: tuple[str, ...], system: System) -> str:
    """Return the sentence for the text of a section that a model does not have."""
    said = f"{argument} must be one of {listed(forms)}, got {shown(text)}."
    if asked == f"{TIME}=c" and not system.driven:
        kind = kind_of(system.model)
        return f"{said} {kind[0].upper()}{kind[1:]} has no drive."
    name, equals, _ = asked.partition("=")
    names = [form.partition("=")[0] for form in forms if form.endswith("=c")] if equals else forms
    momentum = [form for form in _of_momenta(system) if form.replace("_", "") == asked.replace("_", "")]
    hint = did_you_mean(asked, forms) if did_you_mean(name, names) and not momentum else ""
    hint = f" Did you mean {momentum[0]}?" if momentum else hint
    other = " Use fa.Hyperplane(normal, offset) for other sections." if argument == "section" else ""
    return said + (hint or other)


PERIOD = "period"
"""Name of the drive period in the phase of a stroboscopic section, t=period/4."""

SIGNS = {"+": 1, "-": -1, "+-": 0, "-+": 0}
"""Ends of a text that ask for crossings upwards, downwards, or both."""


def parted(text: str) -> tuple[str, int | None]:
    """Return the text of a section without the sign at its end, and the direction of that; None without one."""
    body = text.rstrip()
    end = next((end for end in sorted(SIGNS, key=len, reverse=True) if body.endswith(end)), "")
    return (body[: -len(end)], SIGNS[end]) if end else (text, None)


def section_named(text: str, system: System, direction: int = 1, *, argument: str = "section") -> Any:
    """Return the section of a model for a text, crossed as its sign says, "x=0-", else in that direction. Raises
    ValueError with the known forms.
    """
    forms = section_forms(system)
    text, own = parted(text)
    direction = direction if own is None else own
    text = VANISHING.get(re.sub(r"\s", "", text).lower(), text) if system.planar else _without_planes(text, system)
    name, equals, constant = text.partition("=")
    asked = f"{name.strip()}=c" if equals else name.strip()
    try:
        form = asked if asked in _of_momenta(system) else named(argument, asked, forms)
    except ValueError:
        raise ValueError(_unknown(argument, asked, text.strip(), forms, system)) from None
    if not equals:
        return TURNING[form](direction)
    name = form.removesuffix("=c")
    if not constant.strip():
        raise ValueError(f"{argument} {form} needs a number for c, such as {name}=0.2, got {shown(text)}")
    row = None if system.planar and name in EQUALS else system.row_names.index(name)
    strobed = system.driven and row == system.moving
    value = number(f"{argument} {form}: c", constant, {PERIOD: float(system.model.period)} if strobed else {})
    if row is None:
        return EQUALS[name](value, direction)
    if strobed:
        if own not in (None, 1):
            raise ValueError(f"{argument} {form} has one direction, as the time goes on: leave the sign out")
        return Stroboscopic(value)
    normal = tuple(float(k == row) for k in range(system.rows))
    if row < len(system.names) and not system.iterated and system.periods[row : row + 1] > (0.0,):
        return AngleEquals(normal, value, system.periods[row], direction)
    return Hyperplane(normal, value, direction)


def canonical(text: str) -> str:
    """Return the text of a section with its number in the form of floats, and turning points by their name; any other
    as it is.
    """
    body, direction = parted(text)
    sign = "" if direction is None else next(end for end, way in SIGNS.items() if way == direction)
    name, _, constant = spelled(body, TURNING).partition("=")
    if not constant:
        return name + sign
    try:
        value = number("c", constant)
    except ValueError:
        return text
    short = f"{value:g}"
    found = f"{name.strip()}={short if float(short) == value else repr(value)}"
    return VANISHING.get(found, found) + sign


def section_in_words(section: Any, system: System) -> str:
    """Return the text of a section, its repr where there is none."""
    for name, kind in {**TURNING, **EQUALS}.items():
        if type(section) is kind:
            return f"{name}={section.constant:g}" if hasattr(section, "constant") else name
    if type(section) is Stroboscopic and system.driven:
        return f"{system.names[system.moving]}={section.phase:g}"
    rows = [k for k, entry in enumerate(getattr(section, "normal", ())) if entry]
    if type(section) in (Hyperplane, AngleEquals) and len(rows) == 1 and rows[0] < len(system.row_names):
        name = system.row_names[rows[0]]
        if name in system.names or f"{name}=c" in _of_momenta(system):
            return f"{name}={section.offset / section.normal[rows[0]]:g}"
    return repr(section)


def section_of(value: Any, model: Any) -> Any:
    """Return the section for a text; anything else as it is."""
    known = hasattr(model, "degrees_of_freedom") and not isinstance(model, type)
    return section_named(value, system_of(model)) if isinstance(value, str) and known else value
