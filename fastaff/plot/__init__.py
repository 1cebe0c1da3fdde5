"""Figures: every function takes `ax=`, new axes where it is not given, and returns the artists it made.

All have one style (`style`), in force while they draw and only then; Matplotlib is imported when the first is drawn.
The ground and the ink are the user's, for example those of ``plt.style.context("dark_background")``; other colours
follow from the ground. A click on a figure tells the orbit (`picked`). `result.plot()` draws the usual figure of a
result.
"""

from ..sections.section_edge import Edge, edge
from .animation import animate, save_animation
from .aperture import plot_aperture
from .backbone import plot_backbone, plot_bifurcation
from .basins import plot_basins
from .chaos import plot_chaos_map, plot_chaotic_fraction, plot_history
from .closed_orbits import plot_closed_orbits
from .density import Density, count_points
from .divergence import plot_divergence
from .families import plot_families
from .figures import FIGURES
from .frequencies import plot_frequency_map, plot_tunes
from .islands import plot_islands, plot_rotation
from .one_variable import plot_bifurcation_diagram, plot_cobweb
from .orbits import plot_orbits, plot_tangent_map
from .periodic import plot_periodic
from .picking import Picked, picked
from .quantum import plot_degeneracies, plot_density, plot_levels, plot_spectrum
from .quantum_chaos import plot_husimi, plot_spacings
from .ratios import frequency, on_line, resonances_between
from .resonances import plot_diffusion_histogram, plot_ratio_web, plot_resonances, plot_web
from .scales import Colouring, clipped, colouring, diffusion_scale
from .scars import plot_scars
from .sections import plot_edge, plot_section
from .starts import plot_diffusion_grid, plot_starts
from .style import Artists, colour_map, styled, symbol
from .tori import plot_actions, plot_energy_of_actions, plot_frequency_lines, plot_torus

__all__ = [
    "FIGURES",
    "Artists",
    "Colouring",
    "Density",
    "Edge",
    "Picked",
    "animate",
    "clipped",
    "colour_map",
    "colouring",
    "count_points",
    "diffusion_scale",
    "edge",
    "frequency",
    "on_line",
    "picked",
    "plot_actions",
    "plot_aperture",
    "plot_backbone",
    "plot_basins",
    "plot_bifurcation",
    "plot_bifurcation_diagram",
    "plot_chaos_map",
    "plot_chaotic_fraction",
    "plot_closed_orbits",
    "plot_cobweb",
    "plot_degeneracies",
    "plot_density",
    "plot_diffusion_grid",
    "plot_diffusion_histogram",
    "plot_divergence",
    "plot_edge",
    "plot_energy_of_actions",
    "plot_families",
    "plot_frequency_lines",
    "plot_frequency_map",
    "plot_history",
    "plot_husimi",
    "plot_islands",
    "plot_levels",
    "plot_orbits",
    "plot_periodic",
    "plot_ratio_web",
    "plot_resonances",
    "plot_rotation",
    "plot_scars",
    "plot_section",
    "plot_spacings",
    "plot_spectrum",
    "plot_starts",
    "plot_tangent_map",
    "plot_torus",
    "plot_tunes",
    "plot_web",
    "resonances_between",
    "save_animation",
    "styled",
    "symbol",
]
