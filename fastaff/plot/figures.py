"""Which figure a result has: `result.plot(...)` draws it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..analysis.chaos.chaos_map import ChaosMap
from ..analysis.chaos.chaotic_fraction import ChaoticFraction
from ..analysis.frequencies.frequency_map import FrequencyMap
from ..analysis.frequencies.resonances import DiffusionHistogram
from ..analysis.periodic.periodic_orbits import PeriodicOrbits
from ..analysis.sections.poincare_map import SectionMap
from ..base.results import drawn
from .chaos import plot_chaos_map, plot_chaotic_fraction
from .periodic import plot_periodic
from .resonances import plot_diffusion_histogram
from .sections import plot_frequency_map, plot_section

FIGURES: dict[type, Callable] = {
    ChaosMap: lambda chaos_map, starts, **options: plot_chaos_map(starts, chaos_map, **options),
    ChaoticFraction: plot_chaotic_fraction,
    DiffusionHistogram: plot_diffusion_histogram,
    FrequencyMap: plot_frequency_map,
    PeriodicOrbits: plot_periodic,
    SectionMap: plot_section,
}


def with_axes(function: Callable) -> Callable:
    """Return a figure's function that takes new axes of pyplot where none are given."""

    def figure(result: Any, *others: Any, ax: Any = None, **options: Any) -> Any:
        if ax is None:
            import matplotlib.pyplot as plt

            ax = plt.subplots()[1]
        return function(result, *others, ax=ax, **options)

    return figure


for _kind, _function in FIGURES.items():
    drawn.register(_kind)(with_axes(_function))
