"""`fastaff frequency-map`: fundamental frequencies of orbits of one energy surface."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from typing import Annotated, Any

from ...jobs.analyses import Frequencies, Run
from ...jobs.launch import Starts
from ...jobs.system import Model, Surface
from ..options import WRITTEN, Look, Parameter, Written, job_of
from ..progress import finished, kept
from ..stops import say
from .figures import frequency_figure, with_colour
from .maps import Work, on_grid


def frequencies(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Written = Written(),
    asked: Frequencies = Frequencies(),
    look: Look = Look(),
    max_order: Annotated[int, Parameter(group=WRITTEN)] = 7,
) -> int:
    """Compute the fundamental frequencies of orbits of one energy surface, and draw their map and their diffusion.

    Orbits start on a grid of the section (40x40) or at random points of it. Two panels: diffusion over the section, and
    the ratios of frequencies with the resonance lines m:n on which orbits stand. Frequencies are in cycles per unit
    time.

    Parameters
    ----------
    max_order
        Largest m + n of the resonances m:n to look for. [7]
    """
    starts = on_grid(starts, "40x40")
    job = job_of(model=options, surface=surface, starts=starts, run=run, frequency_map=asked)
    job = with_colour(job, look.colour)
    work = Work.begun("frequency-map", job, output, look, max_order=max_order)
    if work is None:
        return 0
    start = clock.perf_counter()
    result = work.compute("frequency_map", lambda partial: kept(partial, lambda: work.save(partial, start)))
    seconds = clock.perf_counter() - start
    say(finished(result, seconds))
    extra: dict[str, Any] = {"wall_time": seconds}
    if job.chaos_map is not None:
        extra |= work.colour("chaos_map", lambda more: kept(result, lambda: work.save(result, start, **extra, **more)))
    path = work.save(result, start, interrupted=False, **extra)
    return work.draw(path, lambda: frequency_figure(work.scene._replace(max_order=max_order), result, work.colours))
