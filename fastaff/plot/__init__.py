"""Figures: every function takes `ax=` and returns the artists it made; Matplotlib is imported when one is drawn."""

from ..analysis.sections.energy_sample import Edge, edge
from .chaos import plot_chaos_map, plot_chaotic_fraction, plot_history
from .figures import FIGURES
from .periodic import plot_periodic
from .quantum import plot_degeneracies, plot_density, plot_levels, plot_spectrum
from .quantum_chaos import plot_husimi, plot_spacings
from .resonances import plot_diffusion_histogram, plot_ratio_web, plot_web
from .sections import (
    Artists,
    clipped,
    colour_map,
    diffusion_scale,
    frequency,
    on_line,
    plot_diffusion_grid,
    plot_frequency_map,
    plot_section,
    resonances_between,
    symbol,
)

__all__ = [
    "FIGURES",
    "Artists",
    "Edge",
    "clipped",
    "colour_map",
    "diffusion_scale",
    "edge",
    "frequency",
    "on_line",
    "plot_chaos_map",
    "plot_chaotic_fraction",
    "plot_degeneracies",
    "plot_density",
    "plot_diffusion_grid",
    "plot_diffusion_histogram",
    "plot_frequency_map",
    "plot_history",
    "plot_husimi",
    "plot_levels",
    "plot_periodic",
    "plot_ratio_web",
    "plot_section",
    "plot_spacings",
    "plot_spectrum",
    "plot_web",
    "resonances_between",
    "symbol",
]
