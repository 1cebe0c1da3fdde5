"""The variables of formulas about the body, and numerical proof of their symmetries.

phi = [[x, y], [z, u]]; a = (x+u, z-y)/sqrt2, b = (x-u, y+z)/sqrt2; alpha = |a|, beta = |b|; alpha, beta =
(D1+-D2)/sqrt2; r = alpha^2 + beta^2 = rho^2; cos(vartheta) = (alpha^2 - beta^2)/r, sin(vartheta) = 2 alpha beta/r.
"""

from __future__ import annotations

import functools
import random
from collections.abc import Callable, Mapping
from typing import Any

from .gammainc import GAMMAINC, incomplete_gamma
from .grammar import FUNCTIONS, Program

INVARIANTS = ("D1", "D2", "alpha", "beta", "r", "vartheta", "rho")
MATRIX = ("x", "y", "z", "u")
PLANES = ("a1", "a2", "b1", "b2")
VARIABLES = (*INVARIANTS, *MATRIX, *PLANES)

POINTS = 24
"""Random points at which a formula is tried."""

DIGITS = 50
"""Decimal digits in which it is tried."""


def everything(a1: Any, a2: Any, b1: Any, b2: Any, alpha: Any, beta: Any, sqrt: Any, atan: Any) -> dict[str, Any]:
    """Return the value of every variable at a point; alpha and beta may have any sign."""
    w = 1 / sqrt(2)
    r = alpha * alpha + beta * beta
    return {
        "D1": w * (alpha + beta),
        "D2": w * (alpha - beta),
        "alpha": alpha,
        "beta": beta,
        "r": r,
        "rho": sqrt(r),
        "vartheta": 2 * atan(beta / alpha),
        "x": w * (a1 + b1),
        "u": w * (a1 - b1),
        "z": w * (a2 + b2),
        "y": w * (b2 - a2),
        "a1": a1,
        "a2": a2,
        "b1": b1,
        "b2": b2,
    }


class ProgramTrial:
    """A program evaluated with 50 digits at random points, its parameters varied around the given ones."""

    def __init__(self, program: Program, parameters: Mapping[str, float]):
        import mpmath

        self.mp = mpmath.mp.clone()
        self.mp.dps = DIGITS
        self.program = program
        self.parameters = parameters
        self.random = random.Random(1)
        self.functions: dict[str, Any] = {
            name: functools.partial(self._bounded, getattr(self.mp, name)) for name in FUNCTIONS
        }
        self.functions[GAMMAINC] = incomplete_gamma

    def uniform(self, low: float, high: float) -> Any:
        """Return a random number with all its digits."""
        mp = self.mp
        return low + (high - low) * (mp.mpf(self.random.getrandbits(160)) / mp.mpf(2) ** 160)

    def generic_parameters(self) -> dict[str, Any]:
        """Return parameters near the given ones, none of them zero."""
        return {
            name: self.mp.mpf(value) * (1 + self.uniform(0.01, 0.3)) + (self.uniform(0.1, 0.4) if value == 0 else 0)
            for name, value in self.parameters.items()
        }

    def value(self, variables: Mapping[str, Any], parameters: Mapping[str, Any]) -> Any:
        """Return the value at a point, None where it is not a finite real number."""
        mp = self.mp
        try:
            value = self.program.run(
                lambda f: mp.mpf(f.numerator) / f.denominator,
                {**variables, **parameters, "pi": mp.pi},
                self.functions,
                self._power,
            )
            value = mp.mpmathify(value)
        except (ArithmeticError, ValueError):
            return None
        if isinstance(value, mp.mpc):
            return None
        return value if mp.isfinite(value) else None

    def _bounded(self, function: Any, argument: Any) -> Any:
        """Return function(argument); arguments beyond 1e9 would need that many digits of pi or of e."""
        if abs(argument) > 1e9 and function not in (self.mp.sqrt, self.mp.log, self.mp.atan):
            raise OverflowError
        return function(argument)

    def _power(self, base: Any, exponent: Any) -> Any:
        if abs(exponent) > 1e6:
            raise OverflowError
        return self.mp.power(base, exponent)

    def point(self) -> tuple[dict[str, Any], tuple[Any, Any, Any, Any]]:
        """Return the variables at a random point with D1 > D2 > 0, and (alpha, beta, eta, gamma)."""
        alpha = self.uniform(0.9, 2.1)
        beta = self.uniform(0.05, 0.85)
        eta = self.uniform(0, 6)
        gamma = self.uniform(0, 6)
        return self.at(alpha, beta, eta, gamma), (alpha, beta, eta, gamma)

    def at(self, alpha: Any, beta: Any, eta: Any, gamma: Any) -> dict[str, Any]:
        """Return the variables at given alpha, beta, eta, gamma."""
        mp = self.mp
        a1 = abs(alpha) * mp.cos(eta)
        a2 = abs(alpha) * mp.sin(eta)
        b1 = abs(beta) * mp.cos(gamma)
        b2 = abs(beta) * mp.sin(gamma)
        return everything(a1, a2, b1, b2, alpha, beta, mp.sqrt, mp.atan)

    def differ(self, one: Any, other: Any) -> bool:
        """Tell whether two values of one formula are not the same number."""
        return abs(one - other) > self.mp.mpf(10) ** (-DIGITS // 2) * (1 + abs(one) + abs(other))


def check_symmetry(trial: ProgramTrial, argument: str) -> None:
    """Refuse a formula that changes under D1 <-> D2 (beta -> -beta, vartheta -> -vartheta): both name one matrix."""
    tried = 0
    for _ in range(20 * POINTS):
        variables, (alpha, beta, eta, gamma) = trial.point()
        parameters = trial.generic_parameters()
        one = trial.value(variables, parameters)
        other = trial.value(trial.at(alpha, -beta, eta, gamma), parameters)
        if one is None or other is None:
            continue
        if trial.differ(one, other):
            show = trial.mp.nstr
            raise ValueError(
                f"{argument} must be symmetric under D1 <-> D2, got {show(one, 6)} at D1 = "
                f"{show(variables['D1'], 6)}, D2 = {show(variables['D2'], 6)} and {show(other, 6)} exchanged"
            )
        tried += 1
        if tried == POINTS:
            return
    if not tried:
        raise ValueError(f"{argument} must have finite real values, got none at {20 * POINTS} points with D1 > D2 > 0")


def is_isotropic(trial: ProgramTrial) -> bool:
    """Tell whether independent rotations of a and b leave the formula unchanged, at random points."""
    tried = 0
    for _ in range(20 * POINTS):
        variables, (alpha, beta, _, _) = trial.point()
        parameters = trial.generic_parameters()
        turned = trial.at(alpha, beta, trial.uniform(0, 6), trial.uniform(0, 6))
        one = trial.value(variables, parameters)
        other = trial.value(turned, parameters)
        if one is None and other is None:
            continue
        if one is None or other is None or trial.differ(one, other):
            return False
        tried += 1
        if tried == POINTS:
            return True
    return tried > 0


def check_real(
    program: Program,
    parameters: Mapping[str, float],
    coordinates: tuple[str, ...],
    argument: str,
    search: Callable[[], list[float] | None],
) -> None:
    """Refuse a formula of coordinates that is real at no point tried: around the origin, then around the
    parameters and farther and farther away, and at last at a point that a search returns.
    """
    trial = ProgramTrial(program, parameters)
    for k in range(40 * POINTS):
        generic = trial.generic_parameters()
        centres = [0.0, *generic.values()]
        size = 1.5
        if k >= 20 * POINTS:
            size = 10 ** trial.uniform(-12, 15)
        point = {}
        for name in coordinates:
            centre = centres[trial.random.randrange(len(centres))] if k >= 20 * POINTS else 0
            point[name] = centre + size * trial.uniform(-1, 1)
        if trial.value(point, generic) is not None:
            return
    found = search()
    exact = {name: trial.mp.mpf(value) for name, value in parameters.items()}
    if (
        found is not None
        and trial.value(dict(zip(coordinates, map(trial.mp.mpf, found), strict=True)), exact) is not None
    ):
        return
    raise ValueError(f"{argument} must have finite real values, got none at {40 * POINTS} points up to 1e15 from 0")
