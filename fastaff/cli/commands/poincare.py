"""`fastaff poincare`: a section of one energy surface, coloured by diffusion."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...base.numbers import whole
from ...models.contracts import isotropic
from ..options import HOW, Model, Output, Parameter, Run, Starts, Surface, enough_time, return_times
from ..progress import Progress, begun, compiled, counted, drawing, finished, kept, say, watched
from .captions import figure_of, finish, stated


def poincare(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Output = Output(),
    crossings: Annotated[int, Parameter(group=HOW)] = 500,
    max_time: Annotated[float | None, Parameter(group=HOW)] = None,
    no_diffusion: Annotated[bool, Parameter(group=HOW)] = False,
) -> int:
    """Draw a Poincaré section of one energy surface, coloured by the diffusion of each orbit.

    Orbits start on a grid of the section (20x20) or at random points of it. Units are those of the parameters: with G =
    mu = 1 or C = mu = 1 the unit of time is sqrt(mu/G) or sqrt(mu/C).

    Parameters
    ----------
    crossings
        Crossings wanted from each orbit. [500]
    max_time
        Time at which an orbit ends whatever it does. [four times what the crossings need in a trial]
    no_diffusion
        Do not compute the diffusion; draw in one colour.
    """
    import fastaff

    from ... import plot

    body = options.build()
    section = surface.build(body)
    where, edge, z0 = starts.build(body, section, surface, "20x20")
    stem = output.stem("fastaff-poincare")
    output.check()
    fixed: dict[str, Any] = {"section": section, "crossings": crossings}
    if max_time is not None:
        fixed["max_time"] = max_time
    span: dict[str, Any] = {} if no_diffusion else {"method": fastaff.analysis.NaffLines()}

    def smallest() -> None:
        few: dict[str, Any] = {"scheme": run.scheme_value(), "step": run.step or 0.02, "threads": run.threads}
        fastaff.poincare_map(body, z0[:, :1], section=section, crossings=1, max_time=max_time or 20.0, **few)
        if span:
            fastaff.frequency_map(body, z0[:, :1], time=5.0, **span, **few)

    # The checks of the library come before the compiler.
    whole("crossings", crossings, 1)
    compiled("poincare", smallest)
    choices = run.build(body, z0)
    pace = return_times(body, z0, section, choices)
    if max_time is None:
        fixed["max_time"] = enough_time(pace, section, crossings)
    period = fixed["max_time"] / 4 / crossings if max_time is None else 3.0
    share = float(np.fmin(pace * crossings / fixed["max_time"], 1.0).mean())
    facts = stated(body, surface, section, starts, choices, z0, fixed)
    start = clock.perf_counter()

    def save(result: Any, extra: dict[str, Any], interrupted: bool = True) -> Path:
        wall = {"wall_time": clock.perf_counter() - start, "interrupted": interrupted}
        return output.save(stem, result, {**facts, **wall, **extra})

    result = watched(
        Progress("section", z0.shape[1], share),
        lambda report: fastaff.poincare_map(body, z0, report=report, **fixed, **choices),
        lambda partial: kept(partial, lambda: save(*begun(partial, z0))),
    )
    seconds = clock.perf_counter() - start
    say(finished(result, seconds))
    extra: dict[str, Any] = {"wall_time": seconds}
    if span:
        time = max(200.0, 400 * period)

        def known(found: Any) -> dict[str, Any]:
            return {**extra, "diffusion": np.where(found.status == 0, found.diffusion, np.nan), "diffusion_time": time}

        extra = known(
            watched(
                Progress("diffusion", z0.shape[1]),
                lambda report: fastaff.frequency_map(body, z0, time=time, report=report, **span, **choices),
                lambda partial: kept(result, lambda: save(result, known(partial))),
            )
        )
    with drawing(save(result, extra, interrupted=False)):
        if not output.no_figure:
            figure, ax = figure_of()
            values = extra.get("diffusion")
            norm = None if values is None else plot.diffusion_scale(values)
            drawn = plot.plot_section(result, ax=ax, values=values, boundary=edge, norm=norm)
            if not isotropic(body):  # a system of one's own names its coordinates
                ax.set(xlabel=f"${plot.symbol(where.names[0])}$", ylabel=f"${plot.symbol(where.names[1])}$")
            finish(
                figure, ax, body, surface, section, f"{counted(result.status)}; {drawn.missing} not drawn", stem, facts
            )
    return 0
