"""The figures of jobs: of the commands, and again from a store or a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...core.names import did_you_mean
from ...core.numbers import listed, shown
from ...core.status import Status
from ...jobs.analyses import INDICATORS, ChaosOptions, FrequencyOptions
from ...jobs.job import Job, JobPlan
from ...jobs.wording import OptionError
from ..options import FigureOptions
from .captions import figure_of, finish, outcomes

PANELS = 4
"""Panels of a chaos map at most."""
KNOWN = tuple(name for name in INDICATORS if name != "spectrum")
"""Indicators that are colours."""


class Scene(NamedTuple):
    """Input of a figure: a job, its plan, and where the orbits started (EnergyGrid, EnergySample; None: on no section).

    max_order: of resonance lines; look: how orbits are coloured; waiting: starts that are not computed yet.
    """

    job: Job
    plan: JobPlan
    where: Any
    max_order: int = 7
    look: FigureOptions = FigureOptions()
    waiting: int = 0

    def outcomes(self, result: Any) -> str:
        """Count the outcomes of a result's orbits, and those that wait, in a caption."""
        return outcomes(result.status) + (f", {self.waiting} not computed yet" if self.waiting else "")


def reliable(found: Any) -> np.ndarray:
    """Return the diffusion of the orbits (orbits,) whose frequencies were found, NaN of the others."""
    return np.where(found.status == Status.OK, found.diffusion, np.nan)


def with_colour(job: Job, colour: str | None) -> Job:
    """Return a job that computes the quantity of a colour too: its indicator, or the frequencies."""
    name = None if colour is None else plain(colour)
    if name in KNOWN:
        asked = job.chaos_map
        if asked is None:
            return replace(job, chaos_map=ChaosOptions(indicators=name))
        if name not in [entry.name for entry in asked.values()]:
            return replace(job, chaos_map=replace(asked, indicators=f"{asked.indicators},{name}"))
    elif name is not None and (name.startswith(("nu_", "diffusion")) or "/" in name) and job.frequency_map is None:
        return replace(job, frequency_map=FrequencyOptions())
    return job


def plain(colour: str) -> str:
    """Return a colour as columns are named; names of coordinates keep their capitals."""
    lower = colour.lower().replace("-", "_")
    return lower if lower in KNOWN else colour


def colours(look: FigureOptions, found: Mapping[str, Any], default: str | None = None) -> Any:
    """Return the colours of orbits, by --colour or of a default analysis, from results by analysis; a `Colouring` among
    the results is taken as it is. None without either.
    """
    from ...plot.scales import Colouring, UnknownColumn, colouring, limited

    ends: dict[str, Any] = {"vmin": look.vmin, "vmax": look.vmax}
    if look.colour is None:
        if default is None or default not in found:
            return None
        chosen = found[default]
        if isinstance(chosen, Colouring):
            return chosen._replace(norm=limited(chosen.norm, **ends))
        return colouring(chosen, **ends)
    known: list[str] = []
    for result in found.values():
        if isinstance(result, Colouring):
            if result.name == plain(look.colour):
                return result._replace(norm=limited(result.norm, **ends))
            known.append(result.name)
            continue
        try:
            return colouring(result, plain(look.colour), **ends)
        except UnknownColumn as problem:
            known += problem.names
    hint = did_you_mean(look.colour, known)
    raise OptionError(f"--colour must be one of {listed(dict.fromkeys(known))}, got {shown(look.colour)}.{hint}")


def section_figure(scene: Scene, result: Any, found: Mapping[str, Any]) -> Any:
    """Return the figure of a SectionMap; found: the results of other analyses that may colour it."""
    from ... import plot

    figure, ax = figure_of()
    values = colours(scene.look, {"poincare": result, **found}, "frequency_map")
    boundary = scene.plan.launch.edge
    names: tuple[str, ...] = () if scene.where is None else scene.where.names
    where = scene.where if len(names) > 1 and names[1] == f"p_{names[0]}" else None
    drawn = plot.plot_section(result, ax=ax, values=values, boundary=boundary, starts=where)
    if where is not None and not scene.plan.system.isotropic:  # a system of one's own names its coordinates
        ax.set(xlabel=f"${plot.symbol(names[0])}$", ylabel=f"${plot.symbol(names[1])}$")
    crossings = f"{int(result.counts.sum())} crossings"
    missing = f"; {drawn.missing} not drawn" if drawn.missing else ""
    finish(figure, scene.plan, scene.job.energy_surface, f"{scene.outcomes(result)}; {crossings}{missing}")
    return figure


def frequency_figure(scene: Scene, result: Any, found: Mapping[str, Any]) -> Any:
    """Return the figure of a FrequencyMap: diffusion, or another colour, over the cells of a grid, and ratios of
    frequencies, or the only frequency from orbit to orbit.
    """
    from ... import plot

    gridded = hasattr(scene.where, "cell_index")
    figure, axes = figure_of(panels=2 if gridded else 1)
    axes = np.atleast_1d(axes)
    values = colours(scene.look, {"frequency_map": result, **found}, "frequency_map")
    if gridded:
        plot.plot_diffusion_grid(scene.where, values, ax=axes[0], colorbar=len(result.names) == 1)
    if len(result.names) == 1:
        drawn = plot.plot_frequency_map(result, ax=axes[-1])
    else:
        drawn = _ratios(scene, result, values, axes[-1])
    said = f"{scene.outcomes(result)}; time {result.time:.4g}"
    if not result.regular.any():
        said += "; none has regular frequencies"
    elif drawn.missing:
        said += f"; {drawn.missing} without regular frequencies not drawn"
    finish(figure, scene.plan, scene.job.energy_surface, said + ("; grey: no value" if _grey(values) else ""))
    return figure


def _ratios(scene: Scene, result: Any, values: Any, ax: Any) -> Any:
    """Draw a FrequencyMap in the plane of two ratios of frequencies, with lines of resonances that have orbits."""
    from ... import plot

    first, second = result.names[:2]
    plane = result.nu_gamma is not None
    x, y = (f"{second}/{first}", f"gamma/{first}") if plane else (first, second)
    if not plane and len(result.names) > 2:
        x = f"{first}/{result.names[2]}"
        y = f"{second}/{result.names[2]}"
    ratio = plot.frequency(result, f"{second}/{first}")
    fine = np.isfinite(ratio) & result.regular
    low, high = np.quantile(ratio[fine], [0.01, 0.99]) if fine.any() else (0.0, 1.0)
    least = max(3, result.status.size // 200)
    lines = []
    for n, _, m in plot.resonances_between(low - 1e-3, high + 1e-3, scene.max_order):
        line = (n, 0, m) if plane else (m, n, 0)
        if plot.on_line(result, line, x=x, y=y, tolerance=1e-6, shown=result.regular) >= least:
            lines.append(line)
    shown = result.regular if result.regular.any() else None  # an empty plane would show nothing of them
    return plot.plot_frequency_map(result, ax=ax, x=x, y=y, lines=lines, shown=shown, values=values)


def _grey(values: Any) -> bool:
    return bool(~np.isfinite(values.values).all())


def chaos_figure(scene: Scene, result: Any, found: Mapping[str, Any]) -> Any:
    """Return the figure of a ChaosMap: a panel for each indicator and one for the classification, or of one colour;
    None on no section.
    """
    from ...plot import chaos as plot_chaos
    from ...plot.starts import plot_starts

    if scene.where is None:
        return None
    look = scene.look
    edge = scene.plan.launch.edge
    asked = None if look.colour is None else plain(look.colour)
    shown: list[str | None] = list(result.names[:PANELS])
    if 1 < len(shown) < PANELS:
        shown.append(None)
    if asked is not None:
        shown = [None if asked == "classification" else asked]
    figure, axes = figure_of(panels=len(shown))
    missing = 0
    for letter, ax, name in zip("abcd", np.atleast_1d(axes).ravel(), shown):
        if name is None or name in result.names:
            ends: dict[str, Any] = {} if name is None else {"vmin": look.vmin, "vmax": look.vmax}
            drawn = plot_chaos.plot_chaos_map(scene.where, result, indicator=name, ax=ax, boundary=edge, **ends)
        else:
            drawn = plot_starts(scene.where, ax=ax, values=colours(look, {"chaos_map": result, **found}))
        missing = max(missing, drawn.missing)
        if len(shown) > 1:
            ax.set_title(letter if name else f"{letter}   classification of all", fontsize=10, loc="left")
    asked_of = scene.job.chaos_map
    returns = None if asked_of is None else asked_of.in_returns()
    said = (
        result.shares.bounds_text()
        + ("; white: inaccessible" + (" or not computed yet" if scene.waiting else ""))
        + ("; grey: no value" if missing else "")
        + f"; {scene.outcomes(result)}; time {result.time:.4g}"
        + (f" ({returns:g} median returns)" if returns else "")
    )
    finish(figure, scene.plan, scene.job.energy_surface, said)
    return figure


DRAWN = {"poincare": section_figure, "frequency_map": frequency_figure, "chaos_map": chaos_figure}
"""Functions that draw the results of an analysis."""


def figures_of(scene: Scene, found: Any, extra: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return the figures of the results of a job by the name of the analysis; found: results by that name, each of
    which may colour the others; extra: further results that may.
    """
    figures: dict[str, Any] = {}
    results = {name: found[name] for name in found}
    for name, result in results.items():
        if name in DRAWN:
            others = {other: value for other, value in results.items() if other != name}
            figures[name] = DRAWN[name](scene, result, {**others, **(extra or {})})
        else:
            figures[name] = captioned(scene, result)
    return {name: figure for name, figure in figures.items() if figure is not None}


def captioned(scene: Scene, result: Any) -> Any:
    """Return the figure that the library has for a result, with title and caption; None where there is none."""
    figure = plain_figure(result)
    if figure is not None:
        status = getattr(result, "status", None)
        finish(figure, scene.plan, scene.job.energy_surface, "" if status is None else outcomes(status))
    return figure


def plain_figure(result: Any) -> Any:
    """Return the figure that the library has for a result, None where there is none."""
    figure, ax = figure_of()
    try:
        result.plot(ax=ax)
    except (TypeError, AttributeError):
        return None
    return figure
