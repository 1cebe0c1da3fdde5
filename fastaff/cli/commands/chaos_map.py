"""`fastaff chaos-map`: indicators of chaos over one energy surface, or the chaotic fraction over parameters."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...analysis.chaos.indicators import (
    FLI,
    GALI,
    MEGNO,
    OFLI,
    SALI,
    BirkhoffDigits,
    FrequencyDiffusion,
    Lyapunov,
    LyapunovSpectrum,
    ReversibilityError,
    ZeroOne,
)
from ...base.numbers import positive
from ..options import HOW, Model, Output, Parameter, Run, Starts, Surface, Wrong, named, return_times
from ..progress import Progress, compiled, counted, drawing, finished, kept, say, watched
from . import scans
from .captions import figure_of, finish, stated

_KNOWN: tuple[Any, ...] = (
    MEGNO(),
    SALI(),
    *(GALI(k) for k in range(2, 9)),
    FLI(),
    OFLI(),
    Lyapunov(),
    BirkhoffDigits(),
    FrequencyDiffusion(),
    ZeroOne(),
    ReversibilityError(),
)
INDICATORS: dict[str, Any] = {**{entry.name: entry for entry in _KNOWN}, "spectrum": LyapunovSpectrum()}
PANELS = 4


def chaos_map(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Output = Output(),
    time: Annotated[float | None, Parameter(group=HOW)] = None,
    periods: Annotated[float | None, Parameter(group=HOW)] = None,
    indicators: Annotated[str, Parameter(group=HOW)] = "megno,sali",
    early_stop: Annotated[bool, Parameter(group=HOW)] = False,
    scan: Annotated[list[str] | None, Parameter(group=HOW)] = None,
) -> int:
    """Tell regular from chaotic orbits of one energy surface, and draw the map; or the chaotic fraction over parameters
    (--scan).

    Orbits start on a grid of the section (60x60) or at random points of it, uniform in its invariant area. One panel
    for each indicator and one for the verdict: what the indicators that decide say, undecided where they disagree or
    none decides.

    Parameters
    ----------
    time
        Time of every orbit.
    periods
        Time of every orbit in median times of return to the section, instead of --time; fewer call weak chaos regular.
    [500] indicators
        Names, with commas: megno, sali, gali_2 ... gali_8, fli, ofli, lyapunov, spectrum, birkhoff_digits,
        frequency_diffusion, zero_one, reversibility_error. [megno,sali]
    early_stop
        End an orbit when all indicators have called it chaotic.
    scan NAME=LOW:HIGH:N, once or twice: draw the chaotic fraction of random orbits (400 unless --orbits) over energy,
        p_eta, p_gamma, the spin p_phi = p_gamma + p_eta, the vorticity p_psi = p_gamma - p_eta, or a parameter of the
        body such as K.
    """
    import fastaff

    chosen = _indicators(indicators)
    if time is not None and periods is not None:
        raise Wrong("give --time or --periods, not both")
    number = positive("periods", 500.0 if periods is None else periods)
    if time is not None:
        positive("time", time)
    body = options.build()
    axes = scans.parsed(scan) if scan else []
    scans.check(axes, body)
    for axis in axes:
        if axis.name == "energy":
            surface = replace(surface, energy=float(axis.values[-1]))
    section = surface.build(body)
    scheme = run.scheme_value()
    fixed: dict[str, Any] = {"indicators": chosen, "early_stop": early_stop}
    stem = output.stem("fastaff-chaos-scan" if axes else "fastaff-chaos-map")
    output.check()

    def length(one: Any, z: np.ndarray) -> float:
        return time or number * _period(one, z, section, run.threads)

    def compile_first(one: Any, z: np.ndarray) -> None:
        few, how = z[:, :64], {"scheme": scheme, "step": run.step or 0.02, "threads": run.threads}

        def smallest() -> None:
            fastaff.chaos_map(one, few, time=1.0, **fixed, **how)
            if time is None:
                _period(one, few[:, :2], section, run.threads)

        compiled("chaos-map", smallest)

    if axes:
        if starts.grid is not None:
            raise Wrong(
                "--scan takes random starts (--orbits), not --grid: the share of random points is that of the "
                "section's area"
            )
        return scans.scanned(
            axes,
            body,
            surface,
            section,
            starts,
            run,
            output,
            stem,
            {**fixed, "time": time, "periods": None if time else number},
            length,
            compile_first,
        )
    where, edge, z0 = starts.build(body, section, surface, "60x60")
    compile_first(body, z0)
    choices = run.build(body, z0)
    fixed["time"] = length(body, z0)
    facts = {
        **stated(body, surface, section, starts, choices, z0, fixed),
        "periods": None if time else number,
        **_placed(where),
    }
    start = clock.perf_counter()

    def save(result: Any, interrupted: bool = True) -> Path:
        wall = {"wall_time": clock.perf_counter() - start, "interrupted": interrupted, "fraction": result.fraction}
        return output.save(stem, result, {**facts, **wall})

    result = watched(
        Progress("chaos", z0.shape[1]),
        lambda report: fastaff.chaos_map(body, z0, report=report, **fixed, **choices),
        lambda partial: kept(partial, lambda: save(partial)),
    )
    say(f"chaotic fraction {result.fraction:.3f}; {finished(result, clock.perf_counter() - start)}")
    with drawing(save(result, interrupted=False)):
        if not output.no_figure:
            _draw(result, where, edge, body, surface, section, stem, facts)
    return 0


def _indicators(text: str) -> tuple[Any, ...]:
    names = [name.strip().lower().replace("-", "_") for name in text.split(",")]
    return tuple(INDICATORS[named("--indicators", name, tuple(INDICATORS))] for name in names)


def _period(body: Any, z0: np.ndarray, section: Any, threads: int | None) -> float:
    """Return the median time of return to the section; step control gets through steep walls."""
    import fastaff

    pace = return_times(body, z0, section, {"scheme": fastaff.VERNER9, "threads": threads})
    if np.isnan(pace).all():
        raise Wrong(f"no orbit of a trial returns to {section!r}; give --time, or another section or direction")
    return float(np.nanmedian(pace))


def _placed(where: Any) -> dict[str, Any]:
    """Return what a file says of where the orbits started."""
    if hasattr(where, "points"):
        return {"start_points": where.points, "axis_names": where.names}
    return {
        "cell": where.cell,
        "forbidden": where.forbidden,
        "axis_0": where.axes[0],
        "axis_1": where.axes[1],
        "axis_names": where.names,
    }


def _draw(result, where, edge, body, surface, section, stem, facts) -> None:
    from ...plot import chaos as plot_chaos

    shown: list[str | None] = list(result.names[:PANELS])
    if 1 < len(shown) < PANELS:
        shown.append(None)
    figure, axes = figure_of(panels=len(shown))
    for letter, ax, name in zip("abcd", np.atleast_1d(axes).ravel(), shown):
        drawn = plot_chaos.plot_chaos_map(where, result, indicator=name, ax=ax, boundary=edge)
        if len(shown) > 1:
            ax.set_title(letter if name else f"{letter}   verdict of all", fontsize=10, loc="left")
    periods = facts.get("periods")
    said = (
        f"time {facts['time']:.4g}"
        + (f" ({periods:g} median returns)" if periods else "")
        + f"; chaotic fraction {result.fraction:.3f}"
    )
    said += (
        f"; {counted(result.status)}" + ("; crosses: no value" if drawn.missing else "") + "; white: beyond the energy"
    )
    finish(figure, axes, body, surface, section, said, stem, facts)
