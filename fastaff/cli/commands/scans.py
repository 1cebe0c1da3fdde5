"""Parameter grids: what `--scan` means, which case each value makes, and the scan of `fastaff chaos-map`."""

from __future__ import annotations

import itertools
import math
import time as clock
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..options import Wrong, named
from ..progress import Progress, drawing, say, watched
from .captions import caption, figure_of, in_words, stated, surface_in_words, title, titled, units, write

PLANES = ("p_eta", "p_gamma", "p_phi", "p_psi")


class Scanned(NamedTuple):
    """One axis of a parameter grid."""

    name: str
    values: np.ndarray


def parsed(texts: list[str]) -> list[Scanned]:
    """Return the axes of NAME=LOW:HIGH:N, one or two."""
    if len(texts) > 2:
        raise Wrong(f"--scan can be given once or twice, got {len(texts)}")
    axes = [_parsed(text) for text in texts]
    taken = [axis.name for axis in axes]
    if len(set(taken)) < len(taken):
        raise Wrong(f"--scan must name two different parameters, got {taken[0]} twice")
    if set(taken) & {"p_phi", "p_psi"} and set(taken) & {"p_eta", "p_gamma"}:
        raise Wrong(
            "--scan takes p_eta and p_gamma, or p_phi = p_gamma + p_eta and p_psi = p_gamma - p_eta, not one of each"
        )
    return axes


def _parsed(text: str) -> Scanned:
    name, equals, span = text.partition("=")
    parts = span.split(":")
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2])
        if len(parts) != 3 or not equals or not math.isfinite(low + high) or not low < high or count < 2:
            raise ValueError
    except (ValueError, IndexError):
        form = "NAME=LOW:HIGH:N with LOW < HIGH and N of at least 2, for example energy=0.5:3:11"
        raise Wrong(f"--scan must be {form}, got {text!r}") from None
    return Scanned(name.strip().replace("p-", "p_"), np.linspace(low, high, count))


def check(axes: list[Scanned], body: Any) -> None:
    """Refuse names that are no parameter of the body or its energy surface."""
    from ...models.contracts import isotropic

    planar = isotropic(body)
    names = (
        "energy",
        *(PLANES if planar else ()),
        *getattr(body, "potential", body)._fields,
        *(("mu",) if planar else ()),
    )
    for axis in axes:
        named("--scan", axis.name, names)


def case(body: Any, surface: Any, given: dict[str, float]) -> tuple[Any, Any]:
    """Return body and surface with some parameters replaced."""
    spin, vorticity = surface.p_gamma + surface.p_eta, surface.p_gamma - surface.p_eta
    if "p_phi" in given or "p_psi" in given:
        spin, vorticity = given.get("p_phi", spin), given.get("p_psi", vorticity)
        surface = replace(surface, p_eta=(spin - vorticity) / 2, p_gamma=(spin + vorticity) / 2)
    for name, value in given.items():
        if name in ("energy", "p_eta", "p_gamma"):
            surface = replace(surface, **{name: value})
        elif name == "mu" and hasattr(body, "potential"):
            body = body._replace(mu=value)
        elif name not in PLANES:
            inner = getattr(body, "potential", body)._replace(**{name: value})
            body = body._replace(potential=inner) if hasattr(body, "potential") else inner
    return body, surface


def scanned(
    axes: list[Scanned],
    body: Any,
    surface: Any,
    section: Any,
    starts: Any,
    run: Any,
    output: Any,
    stem: Any,
    fixed: dict[str, Any],
    time: Callable,
    compile_first: Callable,
) -> int:
    """Compute, save and draw the chaotic fraction over one or two parameters."""
    import fastaff

    orbits = starts.orbits or 400
    ranges = starts.ranges()
    if None in ranges and any(ranges):
        raise Wrong("with --scan give both of --range1 and --range2, or none")
    seeds = itertools.count()

    def make(*values: float) -> tuple[Any, Any]:
        one, at = case(body, surface, dict(zip((axis.name for axis in axes), values)))
        where = {"energy": at.energy, "p_eta": at.p_eta, "p_gamma": at.p_gamma, "axes": ranges if all(ranges) else None}
        return one, fastaff.energy_sample(
            one, section=section, orbits=orbits, seed=[starts.seed, next(seeds)], **where
        ).z0

    compile_first(*_some_case(axes, make))
    seeds = itertools.count()
    cases = math.prod(axis.values.size for axis in axes)
    scheme = run.scheme_value()
    facts = {
        **stated(body, surface, section, replace(starts, orbits=orbits), {"threads": run.threads}, None, fixed),
        "scan": [axis.name for axis in axes],
        "orbits_per_case": orbits,
        "scheme": scheme,
    }
    start = clock.perf_counter()

    def save(result: Any, interrupted: bool = True) -> Any:
        found = {"fraction": result.fraction, "interval": result.interval(), "wall_time": clock.perf_counter() - start}
        return output.save(stem, result, {**facts, **found, "interrupted": interrupted})

    def keep(partial: Any) -> None:
        done = int(np.count_nonzero(partial.done))
        if done:
            say(f"stopped by Ctrl-C: kept {done} finished of {cases} cases in {save(partial)}; no figure drawn")
        else:
            say(f"stopped by Ctrl-C before any of {cases} cases was finished; nothing is kept")

    indicators, early_stop = fixed["indicators"], fixed["early_stop"]
    result = watched(
        Progress("chaotic fraction", cases * orbits),
        lambda report: fastaff.chaotic_fraction(
            make,
            [axis.values for axis in axes],
            names=[axis.name for axis in axes],
            time=time,
            indicators=indicators,
            early_stop=early_stop,
            scheme=scheme,
            step=run.step,
            threads=run.threads,
            report=report,
        ),
        keep,
    )
    seconds = clock.perf_counter() - start
    say(f"{result.summary()}; in {seconds:.1f} s, {result.orbits.sum() / seconds:,.0f} orbits/s")
    with drawing(save(result, interrupted=False)):
        if not output.no_figure:
            _draw(result, axes, body, surface, section, stem, facts)
    return 0


def _some_case(axes: list[Scanned], make: Callable) -> tuple[Any, Any]:
    """Return the first case, from the last values on, that has orbits."""
    from ...analysis.sections.energy_grid import NotReached

    problem: NotReached | None = None
    for values in itertools.product(*(axis.values[::-1] for axis in axes)):
        try:
            return make(*values)
        except NotReached as empty:
            problem = empty
    raise Wrong(f"no case of the scan has orbits: {problem}")


def _draw(result, axes, body, surface, section, stem, facts) -> None:
    from ...plot import chaos as plot_chaos

    figure, ax = figure_of()
    plot_chaos.plot_chaotic_fraction(result, ax=ax)
    names = tuple(axis.name for axis in axes)
    hidden = (*names, *(("p_eta", "p_gamma") if {"p_phi", "p_psi"} & set(names) else ()))
    where = surface_in_words(body, surface, without=hidden)
    if {"p_phi", "p_psi"} & set(names):
        spin, vorticity = surface.p_gamma + surface.p_eta, surface.p_gamma - surface.p_eta
        rest = [rf"$p_\varphi$ = {spin:g}"] * ("p_phi" not in names) + [rf"$p_\psi$ = {vorticity:g}"] * (
            "p_psi" not in names
        )
        where = ", ".join([*filter(None, [where]), *rest])
    title(figure, ", ".join(filter(None, [titled(body, without=names), where])))
    shown = "bars: 95 % of statistics; pale band: undecided orbits" if len(axes) == 1 else "largest 95 % half width "
    if len(axes) == 2:
        low, high = result.interval()
        shown += f"{np.nanmax(high - low) / 2:.3f}"
    empty = (
        f"; {'grey' if len(axes) == 1 else 'hatched'}: the energy reaches nothing" if (result.orbits == 0).any() else ""
    )
    said = (
        f"{int(result.orbits.max())} random orbits a case, uniform in area; indicators "
        f"{', '.join(result.indicators)}; {shown}{empty}"
    )
    failed = int(result.failed.sum())
    said += f"; {failed} orbits failed, left out" if failed else ""
    caption(figure, f"section {in_words(section, body)}; {said}; {units(body)}")
    write(figure, stem, facts)
