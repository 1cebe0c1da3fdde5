"""Parameter scans as jobs: the table [scan]. Its points are cases, each with random orbits of its own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..chaos.chaotic_fraction import ChaoticFraction, FoundCases, chaotic_fraction
from ..core.names import named
from ..core.numbers import portion, shown
from ..runs.requirements import current_system
from ..sections.energy_sample import energy_sample
from ..systems.formulas.number import number
from ..systems.models.mechanics import System
from .analyses import AnalysedOrbits, ChaosOptions, RunOptions
from .launch import InitialConditions
from .system import EnergySurface
from .wording import OptionError, option

PLANES = ("p_eta", "p_gamma", "p_phi", "p_psi")
"""Angular momenta that a body's energy surface has."""

ORBITS = 400
"""Orbits of a case."""

FORM = "NAME=LOW:HIGH:N with LOW < HIGH and N of at least 2, for example energy=0.5:3:11"


class Scanned(NamedTuple):
    """A parameter and its values."""

    name: str
    values: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Scan:
    """The share of chaotic orbits for each value of one or two parameters."""

    axes: list[str]
    """NAME=LOW:HIGH:N, once or twice: energy, p_eta, p_gamma, the spin p_phi = p_gamma + p_eta, the vorticity p_psi =
    p_gamma - p_eta, or a parameter of the system such as K.
    """

    def parsed(self, system: System) -> list[Scanned]:
        """Return the parameters with their values.

        Parameters
        ----------
        system : object
            System of the job.

        Returns
        -------
        list of tuple
            Names and values of the parameters.

        Raises
        ------
        ValueError
            If neither the model nor its energy surface has a parameter of that name.
        """
        axes = scanned(self.axes)
        planar = system.isotropic
        body = system.model
        own = getattr(body, "potential", body)._fields
        names = ("energy", *(PLANES if planar else ()), *own, *(("mu",) if planar else ()))
        for axis in axes:
            named(option("scan"), axis.name, names)
        return axes


def scanned(texts: list[str]) -> list[Scanned]:
    """Return the parameters of a scan with their values."""
    if not 1 <= len(texts) <= 2:
        raise OptionError(f"{option('scan')} takes one or two parameters, got {len(texts)}")
    axes = [_parsed(text) for text in texts]
    taken = [axis.name for axis in axes]
    if len(set(taken)) < len(taken):
        raise OptionError(f"{option('scan')} takes two different parameters, got {taken[0]} twice")
    if set(taken) & {"p_phi", "p_psi"} and set(taken) & {"p_eta", "p_gamma"}:
        sums = "p_phi = p_gamma + p_eta and p_psi = p_gamma - p_eta"
        raise OptionError.of("{scan} takes p_eta and p_gamma, or {sums}, not one of each", sums=sums)
    return axes


def _parsed(text: str) -> Scanned:
    name, equals, span = text.partition("=")
    parts = span.split(":")
    try:
        low = number("LOW", parts[0])
        high = number("HIGH", parts[1])
        count = int(parts[2])
        if len(parts) != 3 or not equals or not math.isfinite(low + high) or not low < high or not 2 <= count < 10**6:
            raise ValueError
    except (ValueError, IndexError):
        raise OptionError(f"{option('scan')} must be {FORM}, got {shown(text)}") from None
    return Scanned(name.strip().replace("p-", "p_"), np.linspace(low, high, count))


def case(model: Any, surface: Any, given: dict[str, float]) -> tuple[Any, Any]:
    """Return body and surface with some parameters replaced."""
    spin = surface.p_gamma + surface.p_eta
    vorticity = surface.p_gamma - surface.p_eta
    if "p_phi" in given or "p_psi" in given:
        spin = given.get("p_phi", spin)
        vorticity = given.get("p_psi", vorticity)
        surface = replace(surface, p_eta=(spin - vorticity) / 2, p_gamma=(spin + vorticity) / 2)
    for name, value in given.items():
        if name in ("energy", "p_eta", "p_gamma"):
            surface = replace(surface, **{name: value})
        elif name == "mu" and hasattr(model, "potential"):
            model = model._replace(mu=value)
        elif name not in PLANES:
            inner = getattr(model, "potential", model)._replace(**{name: value})
            model = model._replace(potential=inner) if hasattr(model, "potential") else inner
    return model, surface


@dataclass(frozen=True, eq=False)
class Cases:
    """Launch set of a scan: the values (parameters, cases) of its cases, the last parameter fastest."""

    axes: list[Scanned]
    edge: Any = None

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters."""
        return tuple(axis.name for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Values of each parameter."""
        return tuple(axis.values.size for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of cases."""
        return math.prod(self.shape)

    @property
    def block(self) -> int:
        """All at once."""
        return self.size

    def points(self, block: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the values of all cases and their numbers."""
        values = np.array([grid.ravel() for grid in np.meshgrid(*(a.values for a in self.axes), indexing="ij")])
        return values, np.arange(self.size)

    def placed(self, z0: np.ndarray, place: np.ndarray) -> None:
        """Return None: cases are on no section."""


@dataclass(frozen=True)
class ScanOfChaos:
    """The analysis of a scan: random orbits of each case, told regular from chaotic."""

    title: ClassVar[str] = "chaotic fraction"
    brief: ClassVar[dict[str, Any]] = {"time": 1.0}

    cases: Cases
    energy_surface: EnergySurface
    initial_conditions: InitialConditions
    chaos: ChaosOptions

    def check(self, run: RunOptions) -> None:
        """Refuse values that are wrong for any orbits."""
        self.chaos.check(run)

    def resolve_defaults(self, few: AnalysedOrbits, run: RunOptions) -> dict[str, Any]:
        """Return nothing: each case has its own time."""
        self.check(run)
        return {}

    def compute(
        self, orbits: AnalysedOrbits, settled: dict[str, Any], run: RunOptions, callback: Any = None
    ) -> FoundCases:
        """Return the results of the cases whose values are the columns of z0."""
        parts = []
        for k in range(orbits.z0.shape[1]):
            part = portion(callback, k, orbits.z0.shape[1])
            parts.append(self._case(orbits, orbits.z0[:, k], settled, run, part))
        return FoundCases.concat(parts)

    def _case(
        self, orbits: AnalysedOrbits, values: np.ndarray, settled: dict[str, Any], run: RunOptions, callback: Any
    ) -> FoundCases:
        at = [int(np.flatnonzero(axis.values == value)[0]) for axis, value in zip(self.cases.axes, values)]
        number = int(np.ravel_multi_index(at, self.cases.shape))
        time = settled["time"] if settled else None
        one = [np.array([value]) for value in values]
        return FoundCases.of(self.fractions(orbits.model, orbits.section, one, run, callback, number, time))

    def orbits(self, model: Any, section: Any, values: Sequence[float], number: int) -> tuple[Any, np.ndarray]:
        """Return the body of a case, the one of that number, and its random starts (2n, orbits)."""
        model, surface = case(model, self.energy_surface, dict(zip(self.cases.names, values)))
        ranges = self.initial_conditions.ranges()
        drawn = energy_sample(
            model,
            section=section,
            orbits=self.initial_conditions.orbits or ORBITS,
            seed=np.random.SeedSequence(self.initial_conditions.seed, spawn_key=(number,)),
            energy=surface.energy,
            p_eta=surface.p_eta,
            p_gamma=surface.p_gamma,
            axes=ranges if all(ranges) else None,
        )
        return model, drawn.z0

    def fractions(
        self,
        model: Any,
        section: Any,
        values: list[np.ndarray],
        run: RunOptions,
        callback: Any,
        first: int = 0,
        time: float | None = None,
    ) -> ChaoticFraction:
        """Return the chaotic fraction over values of each parameter, cases numbered from `first`."""
        numbers = count(first)

        def length(model: Any, z0: np.ndarray) -> float:
            return (
                self.chaos.resolve_defaults(AnalysedOrbits(current_system(model), section, z0), run)["time"]
                if time is None
                else time
            )

        return chaotic_fraction(
            lambda *given: self.orbits(model, section, given, next(numbers)),
            values,
            names=self.cases.names,
            time=length,
            indicators=self.chaos.values(),
            early_stop=self.chaos.early_stop,
            scheme=run.scheme_value(),
            step=run.step,
            threads=run.threads,
            callback=callback,
        )


def assembled(found: FoundCases, cases: Cases) -> ChaoticFraction:
    """Return the ChaoticFraction of the cases that were found: the others are not done."""
    return found.assembled(tuple(axis.values for axis in cases.axes))
