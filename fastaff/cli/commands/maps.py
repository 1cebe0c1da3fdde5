"""The part that commands of one analysis share: the job of their flags is computed, kept in a file and drawn."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...jobs.analyses import AnalysedOrbits, RunOptions
from ...jobs.job import Job, JobPlan
from ...jobs.launch import InitialConditions, whole
from ..options import FigureOptions, OutputFiles
from ..progress import TerminalProgress, compiled, drawing, watched
from ..stops import say
from .captions import stated, write
from .figures import Scene, plain, with_colour


def on_grid(starts: InitialConditions, cells: str) -> InitialConditions:
    """Return starts, on a grid of so many cells unless they say otherwise."""
    given = starts.grid or starts.orbits or starts.file or starts.by_name
    return starts if given else replace(starts, grid=cells)


def checked(job: Job) -> JobPlan:
    """Return the plan of a job after all checks that need no computation."""
    plan = job.plan()
    for analysis in plan.analyses.values():
        analysis.check(job.options)
    return plan


def settled(plan: JobPlan, run: RunOptions, announce: bool = True) -> dict[str, Any]:
    """Compile the kernels of a plan, in a thread that Ctrl-C need not wait for; return the options of its analyses."""
    few = plan.few()
    found = {}
    brief = replace(run, accuracy=None, step=run.step or 0.02)

    def work() -> None:
        for name, analysis in plan.analyses.items():
            small = few._replace(z0=few.z0[:, -1:]) if hasattr(analysis, "cases") else few  # a case is many orbits
            analysis.compute(small, analysis.brief, brief)
            found[name] = analysis.resolve_defaults(few, run)

    compiled(work, announce)
    return found


@dataclass
class CommandJob:
    """A job that a command computes in memory: its orbits, the settled options, and the facts for its file."""

    job: Job
    plan: JobPlan
    scene: Scene
    z0: np.ndarray
    settled: dict[str, Any]
    output: OutputFiles
    stem: Path
    facts: dict[str, Any]
    colours: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def begun(cls, command: str, job: Job, output: OutputFiles, look: FigureOptions, **facts: Any) -> CommandJob | None:
        """Return the work of a command; None where its job is written and nothing else is asked for."""
        look.check()
        job = with_colour(job, look.colour)
        plan = checked(job)
        if output.wrote(job):
            return None
        stem = output.stem(f"fastaff-{command}")
        output.check()
        z0, place = whole(plan.launch)
        options = settled(plan, job.options)
        scene = Scene(job, plan, plan.launch.placed(z0, place), look=look)
        mine = next(iter(plan.analyses))
        facts = {**stated(job, plan, z0), **vars(plan.analyses[mine]), **options[mine], "place": place, **facts}
        return cls(job, plan, scene, z0, options, output, stem, facts)

    def compute(self, name: str, keep: Callable[[Any], Any]) -> Any:
        """Return the result of an analysis; at Ctrl-C the partial result is handed to `keep`."""
        orbits = AnalysedOrbits(self.plan.system, self.plan.section, self.z0)
        analysis = self.plan.analyses[name]
        result = watched(
            TerminalProgress(analysis.title, self.z0.shape[1]),
            lambda callback: analysis.compute(orbits, self.settled[name], self.job.options, callback),
            keep,
        )
        note = self.job.energy_surface.escape(self.plan.system, result.status)
        if note and name == next(iter(self.settled)):  # once
            say(f"note: {note}")
        return result

    def save(self, result: Any, start: float, interrupted: bool = True, **extra: Any) -> Path:
        """Write a result with the facts about it; start: when its computation began."""
        facts = {**self.facts, "wall_time": clock.perf_counter() - start, "interrupted": interrupted, **extra}
        return self.output.save(self.stem, result, facts)

    def colour(
        self,
        name: str,
        keep: Callable[[dict[str, Any]], Any],
        known: Callable[[Any], dict[str, Any]] | None = None,
    ) -> dict[str, Any]:
        """Compute the analysis that only colours orbits and return its entries of the file; keep: saves the result with
        these entries after Ctrl-C; known: gives the entries of a result (default: the column that colours).
        """
        known = self._column if known is None else known
        found = self.compute(name, lambda partial: keep({} if partial is None else known(partial)))
        self.colours[name] = found
        return known(found)

    def _column(self, found: Any) -> dict[str, Any]:
        """Return the entries of a file for the column that colours orbits."""
        from ...plot.scales import colouring

        chosen = self.scene.look.colour
        values = colouring(found, None if chosen is None else plain(chosen))
        return {"colour": values.name, "colour_values": values.values, "colour_threshold": values.threshold}

    def draw(self, path: Path, figure: Callable[[], Any]) -> int:
        """Name the file of the data, then draw the figure, and return the exit code."""
        with drawing(path):
            if not self.output.no_figure:
                drawn = figure()
                if drawn is None:
                    say("no figure: these points are not those of a section; see fastaff.plot")
                else:
                    write(drawn, path.with_suffix(""), self.output.ending, self.facts, self.output.overwrite)
        return 0
