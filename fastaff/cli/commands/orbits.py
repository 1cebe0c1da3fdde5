"""The commands of orbits on one energy surface: `fastaff poincare`, `frequency-map` and `chaos-map`."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...jobs.analyses import ChaosOptions, FrequencyOptions, PoincareOptions, RunOptions
from ...jobs.launch import InitialConditions
from ...jobs.system import LOSING, EnergySurface, Model
from ...jobs.wording import OptionError
from ..options import HOW, WRITTEN, FigureOptions, OutputFiles, Parameter, job_of
from ..progress import begun, finished, kept
from ..stops import say
from . import scans
from .figures import chaos_figure, frequency_figure, plain, reliable, section_figure
from .maps import CommandJob, on_grid


def poincare(
    *,
    options: Model = Model(),
    surface: EnergySurface = EnergySurface(),
    starts: InitialConditions = InitialConditions(),
    run: RunOptions = RunOptions(),
    output: OutputFiles = OutputFiles(),
    asked: PoincareOptions = PoincareOptions(),
    look: FigureOptions = FigureOptions(),
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
    if options.map is not None and options.build().momenta == ():
        raise OptionError(
            "--map must have two variables or more for a section, got one. Try fastaff explore: its page has the "
            "cobweb and the bifurcation diagram."
        )
    # With a given time the times of return are not known.
    span = {"returns": 400.0} if asked.max_time is None else {"time": 1200.0}
    keeps = all(getattr(options, name) is None for name in LOSING)  # these options make systems without frequencies
    default = keeps and not no_diffusion and (look.colour is None or plain(look.colour) == "diffusion")
    diffusion = FrequencyOptions(**span) if default else None
    starts = on_grid(starts, "20x20")
    job = job_of(
        model=options,
        energy_surface=surface,
        initial_conditions=starts,
        options=run,
        poincare=asked,
        frequency_map=diffusion,
    )
    work = CommandJob.begun("poincare", job, output, look)
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


def frequencies(
    *,
    options: Model = Model(),
    surface: EnergySurface = EnergySurface(),
    starts: InitialConditions = InitialConditions(),
    run: RunOptions = RunOptions(),
    output: OutputFiles = OutputFiles(),
    asked: FrequencyOptions = FrequencyOptions(),
    look: FigureOptions = FigureOptions(),
    max_order: Annotated[int, Parameter(group=WRITTEN)] = 7,
) -> int:
    """Compute the fundamental frequencies of orbits of one energy surface, and draw their map and their diffusion.

    Orbits start on a grid of the section (40x40) or at random points of it. Two panels show the diffusion over the
    section, and the ratios of frequencies with the resonance lines m:n that hold orbits. Frequencies are in cycles per
    unit time.

    Parameters
    ----------
    max_order
        Largest m + n of the resonances m:n to look for. [7]
    """
    starts = on_grid(starts, "40x40")
    job = job_of(model=options, energy_surface=surface, initial_conditions=starts, options=run, frequency_map=asked)
    work = CommandJob.begun("frequency-map", job, output, look, max_order=max_order)
    if work is None:
        return 0
    start = clock.perf_counter()
    result = work.compute("frequency_map", lambda partial: kept(partial, lambda: work.save(partial, start)))
    seconds = clock.perf_counter() - start
    say(finished(result, seconds))
    extra: dict[str, Any] = {"wall_time": seconds}
    if work.job.chaos_map is not None:
        extra |= work.colour("chaos_map", lambda more: kept(result, lambda: work.save(result, start, **extra, **more)))
    path = work.save(result, start, interrupted=False, **extra)
    return work.draw(path, lambda: frequency_figure(work.scene._replace(max_order=max_order), result, work.colours))


def chaos_map(
    *,
    options: Model = Model(),
    surface: EnergySurface = EnergySurface(),
    starts: InitialConditions = InitialConditions(),
    run: RunOptions = RunOptions(),
    output: OutputFiles = OutputFiles(),
    asked: ChaosOptions = ChaosOptions(),
    look: FigureOptions = FigureOptions(),
    scan: Annotated[list[str] | None, Parameter(group=HOW)] = None,
) -> int:
    """Classify orbits of one energy surface as regular or chaotic, or draw the chaotic fraction over parameters.

    Orbits start on a grid of the section (60x60) or at random points of it, uniform in its invariant area. Each
    indicator has a panel. The last panel shows the classification by the indicators that decide. An orbit is undecided
    if they disagree or none decides.

    Parameters
    ----------
    scan
        NAME=LOW:HIGH:N, once or twice: draw the chaotic fraction of random orbits (400 unless --orbits) over energy,
        p_eta, p_gamma, the spin p_phi = p_gamma + p_eta, the vorticity p_psi = p_gamma - p_eta, or a parameter of the
        body such as K.
    """
    if scan:
        if look.given:
            raise OptionError("--colour, --vmin and --vmax belong to maps, not to --scan")
        job = job_of(model=options, energy_surface=surface, initial_conditions=starts, options=run, chaos_map=asked)
        return scans.scanned(scan, job, output)
    job = job_of(
        model=options, energy_surface=surface, initial_conditions=on_grid(starts, "60x60"), options=run, chaos_map=asked
    )
    work = CommandJob.begun("chaos-map", job, output, look, returns=asked.in_returns())
    if work is None:
        return 0
    work.facts.update(_placed(work.scene.where))
    start = clock.perf_counter()

    def save(result: Any, interrupted: bool = True, **extra: Any) -> Path:
        shares = {"fraction": result.fraction, "interval": result.shares.interval(), "bounds": result.shares.bounds}
        return work.save(result, start, interrupted, **shares, **extra)

    result = work.compute("chaos_map", lambda partial: kept(partial, lambda: save(partial)))
    say(finished(result, clock.perf_counter() - start))
    extra = {}
    if work.job.frequency_map is not None:
        extra = work.colour("frequency_map", lambda more: kept(result, lambda: save(result, **more)))
    path = save(result, interrupted=False, **extra)
    return work.draw(path, lambda: chaos_figure(work.scene, result, work.colours))


def _placed(where: Any) -> dict[str, np.ndarray]:
    """Return the entries of a file for the starting points of the orbits."""
    if where is None:
        return {}
    if hasattr(where, "points"):
        return {"start_points": where.points, "axis_names": where.names}
    return {
        "cell_index": where.cell_index,
        "inaccessible": where.inaccessible,
        "axis_0": where.axes[0],
        "axis_1": where.axes[1],
        "axis_names": where.names,
    }
