"""`fastaff plot`: the figures of any command again, from a store or a file."""

# ruff: noqa: B008
from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ... import files
from ...core.numbers import listed
from ...jobs.job import Job
from ...jobs.results import JobResults
from ...jobs.store import WAITING, Store, is_store
from ...jobs.wording import OptionError
from ...plot.scales import coloured, diffusion_threshold
from ..options import FORMATS, WRITTEN, FigureOptions, Output, Parameter
from .captions import write
from .figures import Scene, figures_of, plain_figure
from .jobs import in_keys
from .scans import scan_figure
from .spectrum import spectrum_figure


def plot(
    data: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(group=WRITTEN)] = None,
    overwrite: Annotated[bool, Parameter(group=WRITTEN)] = False,
    look: FigureOptions = FigureOptions(),
) -> int:
    """Draw the figures of a store of `fastaff run`, finished or not, or of an .npz file of any command.

    Parameters
    ----------
    data
        Store or file.
    out
        Path of the figure: .png, .pdf or .svg; where there are several the analysis is added. [that of the data, .png]
    overwrite
        Replace existing files instead of numbering the new ones.
    """
    Output().check()
    look.check()
    if not (data.is_file() or is_store(data)):
        raise OptionError(f"{data} must be a file or a store of fastaff, but does not exist")
    usual = data.with_suffix(".png")
    if out is None:
        target = usual
    elif out.is_dir():
        target = out / usual.name
    else:
        target = out
    if target.suffix.lower() not in FORMATS:
        raise OptionError(f"--out must end with {listed(FORMATS)}, got {target}")
    if not target.parent.is_dir():
        raise OptionError(f"--out {target}: the folder {target.parent} does not exist")
    with in_keys(str(data)):
        figures, facts = _of_store(data, look) if is_store(data) else _of_file(data, look)
    if not figures:
        raise OptionError(f"{data} has nothing that there is a figure of")
    for name, figure in figures.items():
        stem = target.with_suffix("")
        stem = stem if len(figures) == 1 else stem.with_name(f"{stem.name}-{name.replace('_', '-')}")
        write(figure, stem, target.suffix, facts, overwrite)
    return 0


def _of_store(path: Path, look: FigureOptions) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return figures and facts of the finished orbits of a store."""
    store = Store(path)
    results = JobResults.stored(path)
    place = results.place
    facts = {"job": store.facts["job"]}
    if not place.size:
        raise OptionError("no orbit is finished yet")
    if results.job.scan is not None:
        return {"scan": scan_figure(results["chaotic_fraction"], results.job.scan.axes, results.job)}, facts
    plan = results.job.plan()
    where = plan.launch.placed(store.root["launch/z0"][:][:, place], place)
    waiting = int(np.count_nonzero(store.finished() == WAITING))
    return figures_of(Scene(results.job, plan, where, look=look, waiting=waiting), results), facts


def _of_file(path: Path, look: FigureOptions) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return figures and facts of a file of a command; a file without a job has the library's figure for its result."""
    arrays, facts = files.contents(path)
    import_module("fastaff.quantum")  # files may hold its results
    result = files.load(path)
    if "spin" in facts and "options" in facts:
        return {"spectrum": spectrum_figure(result, facts)}, facts
    if not isinstance(facts.get("job"), str):
        figure = plain_figure(result)
        return ({} if figure is None else {"figure": figure}), facts
    job = Job.parsed(facts["job"], str(path))
    if "scans" in facts:
        return {"scan": scan_figure(result, facts["scans"], job)}, facts
    plan = job.plan()
    where = plan.launch.placed(arrays["z0"], arrays["place"])
    extra = _colours(arrays, facts)
    if look.colour is None and "colour" in facts:  # the colour of the command
        look = replace(look, colour=facts["colour"])
    scene = Scene(job, plan, where, facts.get("max_order", 7), look)
    # The file is of the first analysis; results of others are arrays beside it.
    return figures_of(scene, {_mine(result, plan): result}, extra), facts


def _mine(result: Any, plan: Any) -> str:
    """Return the name of the analysis that gave a result."""
    kinds = {"SectionMap": "poincare", "FrequencyMap": "frequency_map", "ChaosMap": "chaos_map"}
    return kinds.get(type(result).__name__, next(iter(plan.analyses)))


def _colours(arrays: Any, facts: dict[str, Any]) -> dict[str, Any]:
    """Return the colours that a file holds beside its result."""
    found = {}
    if "diffusion" in arrays and "diffusion_time" in facts:
        threshold = diffusion_threshold(float(facts["diffusion_time"]))
        found["frequency_map"] = coloured("diffusion", arrays["diffusion"], threshold)
    if "colour_values" in arrays:
        found["colour"] = coloured(facts["colour"], arrays["colour_values"], facts["colour_threshold"])
    return found
