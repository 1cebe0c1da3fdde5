"""Parameter grids: the meaning of `--scan`, the case of each value, and the scan of `fastaff chaos-map`."""

from __future__ import annotations

import itertools
import time as clock
from dataclasses import replace
from typing import Any

import numpy as np

from ...jobs.job import Job, JobPlan
from ...jobs.launch import Points
from ...jobs.scans import ORBITS, Cases, Scan, Scanned, ScanOfChaos
from ...jobs.scans import scanned as parsed
from ...jobs.wording import OptionError
from ...runs.requirements import current_system
from ..options import OutputFiles
from ..progress import TerminalProgress, drawing, watched
from ..stops import Stops, say
from .captions import caption, figure_of, in_words, stated, surface_in_words, title, titled, units, write
from .maps import settled


def scanned(texts: list[str], job: Any, output: OutputFiles) -> int:
    """Compute, save and draw the chaotic fraction over one or two parameters, of the random orbits of a job."""
    body = job.model.build()
    run = job.options
    asked = job.chaos_map
    system = current_system(body)
    axes = Scan(axes=texts).parsed(system)
    job = _at_the_end(axes, job)
    section = job.energy_surface.build(system)
    asked.check(run)
    if output.wrote(replace(job, scan=Scan(axes=texts))):
        return 0
    stem = output.stem("fastaff-chaos-scan")
    output.check()
    ranges = job.initial_conditions.ranges()
    if None in ranges and any(ranges):
        raise OptionError("with --scan give both of --q-range and --p-range, or none")
    work = ScanOfChaos(Cases(axes), job.energy_surface, job.initial_conditions, asked)
    one, z0 = _some_case(work, body, section)
    plan = JobPlan(system, section, Points(z0), {"chaos_map": asked})
    settled(plan._replace(system=current_system(one)), run)
    cases = work.cases.size
    facts = {
        **stated(job, plan, None),
        **vars(asked),
        "returns": asked.in_returns(),
        "scan": [axis.name for axis in axes],
        "scans": texts,
        "orbits_per_case": job.initial_conditions.orbits,
        "scheme": run.scheme_value(),
    }
    start = clock.perf_counter()

    def save(result: Any, interrupted: bool = True) -> Any:
        found = {"fraction": result.fraction, "interval": result.interval(), "bounds": result.bounds}
        passed = clock.perf_counter() - start
        return output.save(stem, result, {**facts, **found, "wall_time": passed, "interrupted": interrupted})

    def keep(partial: Any) -> None:
        done = int(np.count_nonzero(partial.done))
        if done:
            say(f"{Stops.said()}: kept {done} finished of {cases} cases in {save(partial)}; no figure drawn")
        else:
            say(f"{Stops.said()} before any of {cases} cases was finished; nothing is kept")

    result = watched(
        TerminalProgress("chaotic fraction", cases * job.initial_conditions.orbits),
        lambda callback: work.fractions(body, section, [axis.values for axis in axes], run, callback),
        keep,
    )
    seconds = clock.perf_counter() - start
    say(f"{result.summary()}; in {seconds:.1f} s, {result.orbits.sum() / seconds:,.0f} orbits/s")
    path = save(result, interrupted=False)
    with drawing(path):
        if not output.no_figure:
            write(scan_figure(result, texts, job), path.with_suffix(""), output.ending, facts, output.overwrite)
    return 0


def _at_the_end(axes: list[Scanned], job: Job) -> Job:
    """Return the job of random orbits at the last value of the energy, where that is scanned."""
    if job.initial_conditions.grid is not None or job.initial_conditions.file is not None:
        raise OptionError(
            "--scan requires --orbits, got --grid or --file. Random points measure the share of the section's area."
        )
    surface = job.energy_surface
    for axis in axes:
        if axis.name == "energy":
            surface = replace(surface, energy=float(axis.values[-1]))
    return replace(
        job,
        energy_surface=surface,
        initial_conditions=replace(job.initial_conditions, orbits=job.initial_conditions.orbits or ORBITS),
    )


def _some_case(work: ScanOfChaos, model: Any, section: Any) -> tuple[Any, Any]:
    """Return the first case, from the last values on, that has orbits."""
    from ...sections.energy_shell import NotReached

    problem: NotReached | None = None
    for number, values in enumerate(itertools.product(*(axis.values[::-1] for axis in work.cases.axes))):
        try:
            return work.orbits(model, section, values, number)
        except NotReached as empty:
            problem = empty
    raise OptionError(f"no case of the scan has orbits: {problem}")


def scan_figure(result: Any, texts: list[str], job: Job) -> Any:
    """Return the figure of a chaotic fraction over the parameters of --scan."""
    from ...plot import chaos as plot_chaos

    axes = parsed(texts)
    surface = job.energy_surface
    body = job.model.build()
    system = current_system(body)
    section = surface.build(system)
    figure, ax = figure_of()
    plot_chaos.plot_chaotic_fraction(result, ax=ax)
    names = tuple(axis.name for axis in axes)
    hidden = (*names, *(("p_eta", "p_gamma") if {"p_phi", "p_psi"} & set(names) else ()))
    where = surface_in_words(system, surface, without=hidden)
    if {"p_phi", "p_psi"} & set(names):
        spin = surface.p_gamma + surface.p_eta
        vorticity = surface.p_gamma - surface.p_eta
        rest = [rf"$p_\varphi$ = {spin:g}"] * ("p_phi" not in names) + [rf"$p_\psi$ = {vorticity:g}"] * (
            "p_psi" not in names
        )
        where = ", ".join([*filter(None, [where]), *rest])
    title(figure, ", ".join(filter(None, [titled(body, without=names), where])))
    shown = "bars: 95 % interval; pale band: undecided orbits" if len(axes) == 1 else "largest 95 % half width "
    if len(axes) == 2:
        low, high = result.interval()
        widest = np.max(high - low, where=np.isfinite(high), initial=0.0)
        shown += f"{widest / 2:.3f}" if np.isfinite(high).any() else "unknown"
    without = ["inaccessible"] if (result.orbits == 0).any() else []
    if len(axes) == 2 and (np.isnan(result.fraction) & (result.orbits > 0)).any():
        without.append("no orbit is decided")
    empty = f"; {'grey' if len(axes) == 1 else 'hatched'}: {' or '.join(without)}" if without else ""
    failed = int(result.failed.sum())
    said = (
        f"{result.shares.bounds_text()}; {shown}{empty}"
        + (f"; {failed} orbits failed" if failed else "")
        + f"; {int(result.orbits.max())} random orbits per case; indicators {', '.join(result.indicators)}"
    )
    caption(figure, f"section {in_words(section, system)}; {said}; {units(body)}")
    return figure
