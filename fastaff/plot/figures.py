"""The figure of each kind of result: `result.plot(...)` draws it, with the other options of the figure."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..chaos.basins import Basins
from ..chaos.chaos_map import ChaosMap
from ..chaos.chaotic_fraction import ChaoticFraction, FoundCases
from ..chaos.measured_series import SeriesExponent
from ..chaos.parameter_diagrams import BifurcationDiagram
from ..core.numbers import shown
from ..frequencies.angle_lines import AngleLines
from ..frequencies.frequencies import FrequencyMap
from ..frequencies.naff import FrequencyLines
from ..frequencies.orbit_family import OrbitFamilies
from ..frequencies.resonance_web import ResonanceLine
from ..frequencies.resonances import DiffusionHistogram, Resonances
from ..frequencies.tune_accumulator import TuneAccumulator, TuneSums
from ..frequencies.tunes import Tunes
from ..periodic.bifurcations import Bifurcation
from ..periodic.continuation import Branch
from ..periodic.found_orbits import PeriodicOrbits
from ..quantum.chaos.husimi import Husimi, VibrationHusimi
from ..quantum.spectra.level_diagram import LevelDiagram
from ..quantum.states.level_table import LevelTable, Multiplets
from ..quantum.states.state import State
from ..quantum.states.vibration_state import VibrationState
from ..results.result import drawn
from ..runs.integrate import Orbits
from ..runs.tangent_map import TangentMap
from ..sections.energy_grid import EnergyGrid
from ..sections.energy_sample import EnergySample
from ..sections.islands import Islands, Rotation
from ..sections.section_edge import Edge
from ..sections.section_map import SectionMap
from ..tori.action_angles import ActionAngles
from ..tori.inverse_tori import EnergyOfActions
from ..tori.torus import TorusFit
from .backbone import plot_backbone, plot_bifurcation
from .basins import plot_basins
from .chaos import plot_chaos_map, plot_chaotic_fraction
from .closed_orbits import has_curves, plot_closed_orbits
from .divergence import plot_divergence
from .families import plot_families
from .frequencies import plot_frequency_map, plot_tunes
from .islands import plot_islands, plot_rotation
from .one_variable import plot_bifurcation_diagram
from .orbits import plot_orbits, plot_tangent_map
from .periodic import plot_periodic
from .quantum import plot_degeneracies, plot_density, plot_levels, plot_spectrum
from .quantum_chaos import plot_husimi
from .resonances import plot_diffusion_histogram, plot_resonances, plot_web
from .scales import colouring
from .sections import plot_edge, plot_section
from .starts import plot_starts
from .tori import plot_actions, plot_energy_of_actions, plot_frequency_lines, plot_torus

NEEDED = {
    ChaosMap: ("starts", "the EnergyGrid or EnergySample of its orbits"),
    Husimi: ("grid", "an EnergyGrid of the section"),
    VibrationHusimi: ("grid", "an EnergyGrid of the section"),
}
"""Further input of the figure of a result."""


def _chaos_map(chaos_map: ChaosMap, starts: Any = None, **options: Any) -> Any:
    return plot_chaos_map(_needed(chaos_map, starts), chaos_map, **options)


def _husimi(husimi: Husimi | VibrationHusimi, grid: Any = None, **options: Any) -> Any:
    return plot_husimi(_needed(husimi, grid), husimi(grid.z0), **options)


def _needed(result: Any, other: Any) -> Any:
    """Return the starts that a figure needs; refuse other values, None among them."""
    if not isinstance(other, (EnergyGrid, EnergySample)):
        name, what = NEEDED[type(result)]
        instead = "" if other is None else f", got {shown(other)}"
        raise TypeError(f"the figure of a {type(result).__name__} needs {name}, {what}: result.plot({name}){instead}")
    return other


def _over(draw: Callable) -> Callable:
    """Return the figure of frequencies, drawn over an EnergyGrid or EnergySample of their orbits if one is given, with
    a web of resonances over a grid.
    """

    def figure(found: Any, starts: Any = None, *, web: Any = None, **options: Any) -> Any:
        if web is not None and not isinstance(starts, EnergyGrid):
            raise TypeError(f"web must be drawn over its EnergyGrid, result.plot(grid, web=web), got {shown(starts)}")
        if starts is None:
            return draw(found, **options)
        drawn = plot_starts(starts, values=colouring(found, "diffusion"), **options)
        if web is None:
            return drawn
        lines = plot_web(web, ax=drawn.points.axes, axes=starts)
        return drawn._replace(lines=lines.lines, labels=(*drawn.labels, *lines.labels))

    return figure


def _periodic(orbits: PeriodicOrbits, **options: Any) -> Any:
    """Draw periodic orbits as closed curves; those of a map, or of a model that is not known, as marks."""
    return (plot_closed_orbits if has_curves(orbits) else plot_periodic)(orbits, **options)


def _cases(cases: FoundCases, **options: Any) -> Any:
    return plot_chaotic_fraction(cases.assembled(tuple(np.unique(row) for row in cases.values)), **options)


def _angle_lines(lines: AngleLines, *, orbit: int = 0, **options: Any) -> Any:
    nu, amplitude, error = (array[:, :, orbit] for array in (lines.nu, lines.amplitude, lines.error))
    return plot_frequency_lines(FrequencyLines(nu, amplitude, error, residual=np.zeros(len(nu))), **options)


FIGURES: dict[type, Callable] = {
    ActionAngles: plot_actions,
    AngleLines: _angle_lines,
    Basins: plot_basins,
    Bifurcation: plot_bifurcation,
    BifurcationDiagram: plot_bifurcation_diagram,
    SeriesExponent: plot_divergence,
    Branch: lambda branch, *others, **options: plot_backbone([branch, *others], **options),
    ChaosMap: _chaos_map,
    ChaoticFraction: plot_chaotic_fraction,
    DiffusionHistogram: plot_diffusion_histogram,
    Edge: plot_edge,
    EnergyGrid: plot_starts,
    EnergyOfActions: plot_energy_of_actions,
    EnergySample: plot_starts,
    FoundCases: _cases,
    FrequencyLines: plot_frequency_lines,
    FrequencyMap: _over(plot_frequency_map),
    Husimi: _husimi,
    Islands: plot_islands,
    LevelDiagram: plot_levels,
    LevelTable: plot_spectrum,
    Multiplets: plot_degeneracies,
    OrbitFamilies: plot_families,
    Orbits: plot_orbits,
    PeriodicOrbits: _periodic,
    ResonanceLine: lambda line, *others, **options: plot_web([line, *others], **options),
    Resonances: plot_resonances,
    Rotation: plot_rotation,
    SectionMap: plot_section,
    State: plot_density,
    VibrationHusimi: _husimi,
    VibrationState: plot_density,
    TangentMap: plot_tangent_map,
    TorusFit: plot_torus,
    TuneSums: lambda sums, **options: plot_tunes(TuneAccumulator.of(sums).tunes(), **options),
    Tunes: _over(plot_tunes),
}

for _kind, _function in FIGURES.items():
    drawn.register(_kind)(_function)
