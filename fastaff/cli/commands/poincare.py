"""`fastaff poincare`: a section of one energy surface, coloured by diffusion."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from pathlib import Path
from typing import Annotated, Any

from ...jobs.analyses import Frequencies, Poincare, Run
from ...jobs.launch import Starts
from ...jobs.system import Model, Surface
from ..options import HOW, Look, Parameter, Written, job_of
from ..progress import begun, finished, kept
from ..stops import say
from .figures import plain, reliable, section_figure, with_colour
from .maps import Work, on_grid


def poincare(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Written = Written(),
    asked: Poincare = Poincare(),
    look: Look = Look(),
    no_diffusion: Annotated[bool, Parameter(group=HOW)] = False,
) -> int:
    """Draw a Poincaré section of one energy surface, coloured by the diffusion of each orbit, or by --colour.

    Orbits start on a grid of the section (20x20) or at random points of it. Units are those of the parameters: with G =
    mu = 1 or C = mu = 1 the unit of time is sqrt(mu/G) or sqrt(mu/C).

    Parameters
    ----------
    no_diffusion
        Do not compute the diffusion; draw in one colour.
    """
    # With a time of one's own nothing is known of returns.
    span = {"periods": 400.0} if asked.max_time is None else {"time": 1200.0}
    keeps = options.flow is None and options.friction is None  # what has no frequencies of its own
    default = keeps and not no_diffusion and (look.colour is None or plain(look.colour) == "diffusion")
    diffusion = Frequencies(method="naff", **span) if default else None
    starts = on_grid(starts, "20x20")
    job = job_of(model=options, surface=surface, starts=starts, run=run, poincare=asked, frequency_map=diffusion)
    job = with_colour(job, look.colour)
    work = Work.begun("poincare", job, output, look)
    if work is None:
        return 0
    start = clock.perf_counter()

    def keep(partial: Any) -> Path:
        found, extra = begun(partial, work.z0)
        return work.save(found, start, **extra, place=work.facts["place"][extra["begun"]])

    result = work.compute("poincare", lambda partial: kept(partial, lambda: keep(partial)))
    seconds = clock.perf_counter() - start
    say(finished(result, seconds))
    extra: dict[str, Any] = {"wall_time": seconds}

    def keep_both(more: dict[str, Any]) -> None:
        kept(result, lambda: work.save(result, start, **extra, **more))

    if diffusion is not None:

        def known(found: Any) -> dict[str, Any]:
            return {"diffusion": reliable(found), "diffusion_time": work.settled["frequency_map"]["time"]}

        extra |= work.colour("frequency_map", keep_both, known)
    for name in [name for name in ("frequency_map", "chaos_map") if name in work.plan.analyses]:
        if name not in work.colours:
            extra |= work.colour(name, keep_both)
    path = work.save(result, start, interrupted=False, **extra)
    return work.draw(path, lambda: section_figure(work.scene, result, work.colours))
