"""`fastaff frequency-map`: fundamental frequencies of orbits of one energy surface."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...analysis import BirkhoffAverages, NaffLines
from ...base.numbers import positive
from ..options import HOW, WRITTEN, Model, Output, Parameter, Run, Starts, Surface, named
from ..progress import Progress, compiled, counted, drawing, finished, kept, say, watched
from .captions import figure_of, finish, stated

METHODS = {"birkhoff": BirkhoffAverages(), "naff": NaffLines()}
"""Values of --method."""


def frequencies(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Output = Output(),
    time: Annotated[float, Parameter(group=HOW)] = 1000.0,
    method: Annotated[str, Parameter(group=HOW)] = "birkhoff",
    max_order: Annotated[int, Parameter(group=WRITTEN)] = 7,
) -> int:
    """Compute the fundamental frequencies of orbits of one energy surface, and draw their map and their diffusion.

    Orbits start on a grid of the section (40x40) or at random points of it. Two panels: diffusion over the section, and
    the ratios of frequencies with the resonance lines m:n on which orbits stand. Frequencies are in cycles per unit
    time.

    Parameters
    ----------
    time
        Time over which frequencies are averaged, best 100 periods or more. [1000]
    method
        birkhoff (weighted averages, and NAFF where they do not converge) or naff. [birkhoff]
    max_order
        Largest m + n of the resonances m:n to look for. [7]
    """
    import fastaff

    body = options.build()
    section = surface.build(body)
    grid, _, z0 = starts.build(body, section, surface, "40x40")
    chosen = METHODS[named("--method", method.lower(), tuple(METHODS))]
    stem = output.stem("fastaff-frequency-map")
    output.check()
    fixed: dict[str, Any] = {"time": positive("time", time), "method": chosen}

    def smallest() -> None:
        few: dict[str, Any] = {"scheme": run.scheme_value(), "step": run.step or 0.02, "threads": run.threads}
        fastaff.frequency_map(body, z0[:, :1], **{**fixed, "time": 5.0}, **few)
        if isinstance(chosen, BirkhoffAverages):
            fastaff.frequency_map(body, z0[:, :1], time=5.0, method=NaffLines(), **few)

    compiled("frequency-map", smallest)
    choices = run.build(body, z0)
    facts = stated(body, surface, section, starts, choices, z0, fixed)
    start = clock.perf_counter()

    def save(result: Any, seconds: float, interrupted: bool = True) -> Path:
        return output.save(stem, result, {**facts, "wall_time": seconds, "interrupted": interrupted})

    result = watched(
        Progress("frequencies", z0.shape[1]),
        lambda report: fastaff.frequency_map(body, z0, report=report, **fixed, **choices),
        lambda partial: kept(partial, lambda: save(partial, clock.perf_counter() - start)),
    )
    seconds = clock.perf_counter() - start
    say(finished(result, seconds))
    with drawing(save(result, seconds, interrupted=False)):
        if not output.no_figure:
            _draw_frequencies(result, grid, starts, body, surface, section, max_order, stem, facts)
    return 0


def _draw_frequencies(result, grid, starts, body, surface, section, max_order, stem, facts) -> None:
    from ... import plot

    figure, ax = figure_of(panels=1 if starts.orbits is not None else 2)
    axes = [ax] if starts.orbits is not None else list(ax)
    if len(axes) == 2:
        values = np.where(result.status == 0, result.diffusion, np.nan)
        plot.plot_diffusion_grid(grid, values, ax=axes[0], norm=plot.diffusion_scale(values), colorbar=False)
    first, second = result.names[:2]
    plane = result.nu_gamma is not None
    x, y = (f"{second}/{first}", f"gamma/{first}") if plane else (first, second)
    ratio = plot.frequency(result, f"{second}/{first}")
    fine = np.isfinite(ratio) & result.regular
    low, high = np.quantile(ratio[fine], [0.01, 0.99]) if fine.any() else (0.0, 1.0)
    least = max(3, result.status.size // 200)
    lines = []
    for n, _, m in plot.resonances_between(low - 1e-3, high + 1e-3, max_order):
        line = (n, 0, m) if plane else (m, n, 0)
        if plot.on_line(result, line, x=x, y=y, tolerance=1e-6, shown=result.regular) >= least:
            lines.append(line)
    drawn = plot.plot_frequency_map(result, ax=axes[-1], x=x, y=y, lines=lines, shown=result.regular)
    finish(
        figure, axes[-1], body, surface, section, f"{counted(result.status)}; {drawn.missing} not drawn", stem, facts
    )
