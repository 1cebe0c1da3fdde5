"""Formulas that are 0/0 somewhere: the places to test, and the remedies."""

from __future__ import annotations

import types
from collections.abc import Mapping, Sequence
from typing import Any

from .gammainc import gammainc, numeric
from .potential_source import Description, ring_potential
from .removable import Places, Vanishing, refused, vanishing
from .variables import ProgramTrial, everything

AXES = ("alpha", "beta")
_RIGHT = 1e-9
"""Largest error allowed for a potential at the trial points, relative to its size on the scale alpha."""


def refuse_removable(
    V: Any,
    walls: Sequence[Any],
    places: Places,
    values: Mapping[str, float],
    names: Sequence[str],
    known: Sequence[Vanishing] = (),
) -> None:
    """Raise ValueError where a denominator of V, other than the known ones, vanishes at a place of the domain at which
    V is finite.
    """
    import sympy

    def inside(point: Mapping[str, Any]) -> bool:
        own = {
            symbol: values.get(symbol.name.removeprefix("self."), point.get(symbol.name))
            for w in walls
            for symbol in w.free_symbols
        }
        return all(sympy.N(wall.subs(own)) > 1e-30 for wall in walls)

    known_denominators = [one.denominator for one in known]
    found = [one for one in vanishing(V, places.within(inside), values) if one.denominator not in known_denominators]
    if found:
        raise refused(found[0], names)


def plain_places(coordinates: Sequence[str]) -> Places:
    """Return places of a system's coordinates: the origin, and each coordinate 0."""
    n = len(coordinates)
    special = [(0.0,) * n, *(tuple(0.0 if i == k else None for i in range(n)) for k in range(n))]
    return Places(
        lambda c: dict(zip(coordinates, c, strict=True)),
        lambda rng: [rng.uniform(-1.5, 1.5) for _ in range(n)],
        special,
    )


def invariant_places(*, axis: bool) -> Places:
    """Return places of (alpha, beta): those on the axis beta = 0, or all others."""

    def place(c: Sequence[Any]) -> dict[str, Any]:
        alpha, beta = c
        return {"alpha": alpha, "beta": beta, "A": alpha**2, "B": beta**2}

    def draw(rng: Any) -> list[float]:
        alpha = rng.uniform(0.2, 3.0)
        return [alpha, alpha * rng.uniform(0.05, 0.95)]

    return Places(place, draw, [(None, 0.0)] if axis else [(0.0, 0.0), (0.0, None)], only_special=axis)


def body_places() -> Places:
    """Return places of (alpha, beta, eta, gamma), the values of all variables there."""
    import mpmath

    def place(c: Sequence[Any]) -> dict[str, Any]:
        alpha, beta, eta, gamma = c
        a, b = ((r * mpmath.cos(t), r * mpmath.sin(t)) for r, t in ((alpha, eta), (beta, gamma)))
        values = everything(*a, *b, alpha, beta, mpmath.sqrt, mpmath.atan) if alpha != 0 else {}
        return {**values, "A": alpha**2, "B": beta**2}

    def draw(rng: Any) -> list[float]:
        alpha = rng.uniform(0.2, 3.0)
        return [alpha, alpha * rng.uniform(0.05, 0.95), rng.uniform(0, 6), rng.uniform(0, 6)]

    return Places(place, draw, [(None, 0.0, None, None)])


def ring_text(d: Description, g: Any, walls: Sequence[Any], s: dict[str, Any], trial: ProgramTrial) -> str:
    """Return the source of a potential that is 0/0 at beta = 0, tried against more digits; ValueError where it would be
    inexact.
    """
    if g.has(gammainc()):
        raise ValueError("text: gammainc is not supported in a potential that is 0/0 at beta = 0")
    text = ring_potential(d, g, walls, s, _even(g, s))
    worst = _largest_error(text, g, s, trial)
    if not worst <= _RIGHT:
        below = vanishing(g, invariant_places(axis=True), trial.parameters)
        raise refused(below[0] if below else Vanishing("of the formula", (1.0, 0.0)), AXES)
    return text


def _even(g: Any, s: dict[str, Any]) -> bool:
    """Tell whether algebra shows that g is even in alpha."""
    return bool(g.xreplace({s["alpha"]: -s["alpha"]}) == g)


def _largest_error(text: str, g: Any, s: dict[str, Any], trial: ProgramTrial) -> float:
    """Return the largest error of value, slopes and curvatures at points up to the axis, on the scale of the potential
    there.
    """
    import mpmath
    import sympy

    module = types.ModuleType("trial")
    exec(compile(text, "<fastaff formula on trial>", "exec"), module.__dict__)
    potential = module.FormulaPotential(**trial.parameters)
    symbols = [s["alpha"], s["beta"], *sorted(g.free_symbols - {s["alpha"], s["beta"]}, key=str)]
    exact = sympy.lambdify(symbols, g, numeric("mpmath"), dummify=True)
    worst = 0.0
    with mpmath.workdps(60):
        constants = [mpmath.mpf(trial.parameters[symbol.name.removeprefix("self.")]) for symbol in symbols[2:]]

        def V(A: Any, B: Any) -> Any:
            return exact(mpmath.sqrt(A), mpmath.sqrt(B), *constants)

        for alpha in (0.45, 1.0, 1.7):
            sizes = []
            errors = []
            for ratio in (0.0, 1e-7, 1e-3, 0.04, 0.15, 0.249, 0.251, 0.6):
                A = mpmath.mpf(alpha) ** 2
                B = (mpmath.mpf(ratio) * alpha) ** 2
                at = (A, B if ratio else A * mpmath.mpf(10) ** -18)
                orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
                truth = [
                    float(mpmath.re(mpmath.diff(V, at, n, h=A * mpmath.mpf(10) ** -9) if any(n) else V(*at)))
                    for n in orders
                ]
                a = float(A)
                b = float(B)
                found = [
                    float(potential.value(a, b)),
                    *map(float, potential.slopes(a, b)),
                    *map(float, potential.curvatures(a, b)),
                ]
                units = [1.0, a, a, a * a, a * a, a * a]
                sizes.append(max(abs(t) * u for t, u in zip(truth, units, strict=True)))
                errors.append(max(abs(t - f) * u for t, f, u in zip(truth, found, units, strict=True)))
            worst = max(worst, max(errors) / (min(sizes) or 1.0))
    return worst
