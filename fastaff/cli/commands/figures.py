"""The figures of jobs: of the commands, and again from a store or a file."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...base.status import Status
from ...jobs.job import Job, Plan
from ...models.contracts import isotropic
from ..progress import counted
from .captions import figure_of, finish

PANELS = 4
"""Panels of a chaos map at most."""


class Scene(NamedTuple):
    """What is drawn of: a job, its plan, and where the orbits started (EnergyGrid, EnergySample; None: on no section).

    max_order: of resonance lines.
    """

    job: Job
    plan: Plan
    where: Any
    max_order: int = 7


def reliable(found: Any) -> np.ndarray:
    """Return the diffusion of the orbits (orbits,) whose frequencies were found, NaN of the others."""
    return np.where(found.status == Status.OK, found.diffusion, np.nan)


def section_figure(scene: Scene, result: Any, diffusion: np.ndarray | None = None) -> Any:
    """Return the figure of a SectionMap, coloured by the diffusion of each orbit."""
    from ... import plot

    figure, ax = figure_of()
    norm = None if diffusion is None else plot.diffusion_scale(diffusion)
    drawn = plot.plot_section(result, ax=ax, values=diffusion, boundary=scene.plan.launch.edge, norm=norm)
    if scene.where is not None and not isotropic(scene.plan.body):  # a system of one's own names its coordinates
        names = scene.where.names
        ax.set(xlabel=f"${plot.symbol(names[0])}$", ylabel=f"${plot.symbol(names[1])}$")
    finish(figure, scene.plan, scene.job.surface, f"{counted(result.status)}; {drawn.missing} not drawn")
    return figure


def frequency_figure(scene: Scene, result: Any) -> Any:
    """Return the figure of a FrequencyMap: diffusion over the cells of a grid, and ratios of frequencies."""
    from ... import plot

    gridded = hasattr(scene.where, "cell")
    figure, axes = figure_of(panels=2 if gridded else 1)
    axes = np.atleast_1d(axes)
    if gridded:
        values = reliable(result)
        norm = plot.diffusion_scale(values)
        plot.plot_diffusion_grid(scene.where, values, ax=axes[0], norm=norm, colorbar=False)
    first, second = result.names[:2]
    plane = result.nu_gamma is not None
    x, y = (f"{second}/{first}", f"gamma/{first}") if plane else (first, second)
    ratio = plot.frequency(result, f"{second}/{first}")
    fine = np.isfinite(ratio) & result.regular
    low, high = np.quantile(ratio[fine], [0.01, 0.99]) if fine.any() else (0.0, 1.0)
    least = max(3, result.status.size // 200)
    lines = []
    for n, _, m in plot.resonances_between(low - 1e-3, high + 1e-3, scene.max_order):
        line = (n, 0, m) if plane else (m, n, 0)
        if plot.on_line(result, line, x=x, y=y, tolerance=1e-6, shown=result.regular) >= least:
            lines.append(line)
    drawn = plot.plot_frequency_map(result, ax=axes[-1], x=x, y=y, lines=lines, shown=result.regular)
    finish(figure, scene.plan, scene.job.surface, f"{counted(result.status)}; {drawn.missing} not drawn")
    return figure


def chaos_figure(scene: Scene, result: Any) -> Any:
    """Return the figure of a ChaosMap: a panel for each indicator and one for the verdict; None on no section."""
    from ...plot import chaos as plot_chaos

    if scene.where is None:
        return None
    shown: list[str | None] = list(result.names[:PANELS])
    if 1 < len(shown) < PANELS:
        shown.append(None)
    figure, axes = figure_of(panels=len(shown))
    for letter, ax, name in zip("abcd", np.atleast_1d(axes).ravel(), shown):
        edge = scene.plan.launch.edge
        drawn = plot_chaos.plot_chaos_map(scene.where, result, indicator=name, ax=ax, boundary=edge)
        if len(shown) > 1:
            ax.set_title(letter if name else f"{letter}   verdict of all", fontsize=10, loc="left")
    asked = scene.job.chaos_map
    periods = None if asked is None else asked.returns()
    said = (
        f"time {result.time:.4g}"
        + (f" ({periods:g} median returns)" if periods else "")
        + f"; chaotic fraction {result.fraction:.3f}; {counted(result.status)}"
        + ("; crosses: no value" if drawn.missing else "")
        + "; white: beyond the energy"
    )
    finish(figure, scene.plan, scene.job.surface, said)
    return figure


def figures_of(scene: Scene, found: Any, diffusion: np.ndarray | None = None) -> dict[str, Any]:
    """Return the figures of the results of a job by the name of the analysis; found: results by that name.

    A section is coloured by `diffusion`, or by that of a frequency map of the same orbits.
    """
    figures: dict[str, Any] = {}
    for name in found:
        result = found[name]
        if name == "poincare":
            if diffusion is None and "frequency_map" in tuple(found):
                diffusion = reliable(found["frequency_map"])
            figures[name] = section_figure(scene, result, diffusion)
        elif name == "frequency_map":
            figures[name] = frequency_figure(scene, result)
        elif name == "chaos_map":
            figures[name] = chaos_figure(scene, result)
        else:
            figures[name] = plain_figure(result)
    return {name: figure for name, figure in figures.items() if figure is not None}


def plain_figure(result: Any) -> Any:
    """Return the figure that the library has for a result, None where there is none."""
    figure, ax = figure_of()
    try:
        result.plot(ax=ax)
    except (TypeError, AttributeError):
        return None
    return figure
