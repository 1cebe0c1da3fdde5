"""`fastaff chaos-map`: indicators of chaos over one energy surface, or the chaotic fraction over parameters."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...jobs.analyses import Chaos, Run
from ...jobs.launch import Starts
from ...jobs.system import Model, Surface
from ...jobs.wording import Wrong
from ..options import HOW, Look, Parameter, Written, job_of
from ..progress import finished, kept
from ..stops import say
from . import scans
from .figures import chaos_figure, with_colour
from .maps import Work, on_grid


def chaos_map(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Written = Written(),
    asked: Chaos = Chaos(),
    look: Look = Look(),
    scan: Annotated[list[str] | None, Parameter(group=HOW)] = None,
) -> int:
    """Tell regular from chaotic orbits of one energy surface, and draw the map; or the chaotic fraction over parameters
    (--scan).

    Orbits start on a grid of the section (60x60) or at random points of it, uniform in its invariant area. One panel
    for each indicator and one for the verdict: what the indicators that decide say, undecided where they disagree or
    none decides.

    Parameters
    ----------
    scan
        NAME=LOW:HIGH:N, once or twice: draw the chaotic fraction of random orbits (400 unless --orbits) over energy,
        p_eta, p_gamma, the spin p_phi = p_gamma + p_eta, the vorticity p_psi = p_gamma - p_eta, or a parameter of the
        body such as K.
    """
    if scan:
        if look.given:
            raise Wrong("--colour, --vmin and --vmax belong to maps, not to --scan")
        job = job_of(model=options, surface=surface, starts=starts, run=run, chaos_map=asked)
        return scans.scanned(scan, job, output)
    job = job_of(model=options, surface=surface, starts=on_grid(starts, "60x60"), run=run, chaos_map=asked)
    job = with_colour(job, look.colour)
    work = Work.begun("chaos-map", job, output, look, periods=asked.returns())
    if work is None:
        return 0
    work.facts.update(_placed(work.scene.where))
    start = clock.perf_counter()

    def save(result: Any, interrupted: bool = True, **extra: Any) -> Path:
        shares = {"fraction": result.fraction, "interval": result.shares.interval(), "bounds": result.shares.bounds}
        return work.save(result, start, interrupted, **shares, **extra)

    result = work.compute("chaos_map", lambda partial: kept(partial, lambda: save(partial)))
    say(f"{result.shares.said()}; {finished(result, clock.perf_counter() - start)}")
    extra = {}
    if job.frequency_map is not None:
        extra = work.colour("frequency_map", lambda more: kept(result, lambda: save(result, **more)))
    path = save(result, interrupted=False, **extra)
    return work.draw(path, lambda: chaos_figure(work.scene, result, work.colours))


def _placed(where: Any) -> dict[str, np.ndarray]:
    """Return what a file says of where the orbits started."""
    if where is None:
        return {}
    if hasattr(where, "points"):
        return {"start_points": where.points, "axis_names": where.names}
    return {
        "cell": where.cell,
        "forbidden": where.forbidden,
        "axis_0": where.axes[0],
        "axis_1": where.axes[1],
        "axis_names": where.names,
    }
