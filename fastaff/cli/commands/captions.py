"""The facts of a computation in files, titles and captions."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ...core.placing import write_atomically
from ...core.status import Status, summary
from ...jobs.job import Job, JobPlan
from ...jobs.launch import BY_NAME
from ...plot.mathematics import number, terms, visible, wrapped
from ...plot.sections import words
from ...plot.style import Palette, styled, symbol
from ...systems.models.mechanics import System


def stated(job: Job, plan: JobPlan, z0: np.ndarray | None) -> dict[str, Any]:
    """Return the facts of a job's computation for its file."""
    body = plan.model
    surface = job.energy_surface
    starts = job.initial_conditions
    inner = getattr(body, "potential", body)
    return {
        "job": job.text(),
        "model": body,
        "energy": surface.energy,
        "p_eta": surface.p_eta,
        "p_gamma": surface.p_gamma,
        "section": plan.section,
        "seed": starts.seed if starts.orbits is not None else None,
        "grid": starts.grid,
        "orbits": starts.orbits if z0 is None else z0.shape[1],
        "q_range": starts.q_range,
        "p_range": starts.p_range,
        **{name: getattr(starts, name) for name in BY_NAME if getattr(starts, name)},
        "rtol": 1e-12,
        "atol": 1e-12,
        "energy_tolerance": None,
        "formula": getattr(inner, "formula", None),
        "domain": getattr(inner, "domain", None),
        "threads": job.options.threads,
        "z0": z0,
    }


NAMES = {
    "Anharmonic": "anharmonic body",
    "DoublePendulum": "double pendulum",
    "Harmonic": "harmonic body",
    "HeavyTop": "heavy top",
    "HenonHeiles": "Hénon-Heiles system",
    "Hyperelastic": "hyperelastic body",
    "NeoHookean": "neo-Hookean body",
}
"""Models of the library in words."""
LONGEST = 160
"""Characters of a formula in a title."""


def equal(name: str, value: float) -> str:
    """Write a quantity and its value."""
    return f"${symbol(name)} = {number(value)}$"


def in_words(section: Any, system: System) -> str:
    """Name a section in a caption."""
    name = type(section).__name__
    if name in ("Hyperplane", "AngleEquals"):
        row = next(k for k, entry in enumerate(section.normal) if entry)
        q = system.row_names[row]
        plain = system.separable and system.quadratic and not system.frame and row < system.n
        rate = symbol(system.row_names[row + system.n]) if plain else rf"\dot{{{symbol(q)}}}"
        return f"{equal(q, section.offset)}, {crossed(rate, section.direction)}"
    if name == "Stroboscopic":
        return f"{equal(system.names[-1], section.phase)}, once per period"
    crossing = crossed(rf"\dot{{{section.label}}}", section.direction)
    return f"${section.label} = {number(getattr(section, 'constant', 0))}$, {crossing}"


def crossed(rate: str, direction: int) -> str:
    """Name the direction of crossings by the sign of a rate."""
    return (
        "crossed in both directions" if direction == 0 else f"crossed with ${rate} {'>' if direction > 0 else '<'} 0$"
    )


def units(model: Any) -> str:
    """Name in a caption the parameters that are 1; empty where there are none."""
    inner = getattr(model, "potential", model)
    if inner is model or not inner._fields or hasattr(inner, "formula") or inner[0] != 1 or model.mu != 1:
        return ""
    return rf"units: ${symbol(inner._fields[0])} = \mu = 1$"


def titled(model: Any, without: tuple[str, ...] = ()) -> str:
    """Name a body and its parameters in a title."""
    inner = getattr(model, "potential", model)
    values = [equal(name, value) for name, value in zip(inner._fields, inner) if name not in without]
    if inner is not model and "mu" not in without:
        values.append(equal("mu", model.mu))
    text = getattr(inner, "formula", None)
    name = type(inner).__name__
    of = "H" if hasattr(inner, "momenta") else "V"
    if text is None:
        said = NAMES.get(name, name)
    elif "=" in text:
        said = text
    else:
        said = potential(text, of)
    return said + (f" ({', '.join(values)})" if values else "")


def potential(text: str, of: str = "V") -> str:
    """Write a formula in a title, its terms apart so that lines can be broken between them."""
    parts = terms(text)
    kept = 0
    while kept < len(parts) and sum(map(visible, parts[: kept + 1])) <= LONGEST:
        kept += 1
    shown = parts[: max(kept, 1)] + ([r"+\,\ldots"] if kept < len(parts) else [])
    return " ".join(f"${f'{of} = ' if k == 0 else ''}{part}$" for k, part in enumerate(shown))


def surface_in_words(system: System, surface: Any, without: tuple[str, ...] = ()) -> str:
    """Name the energy surface in a title, without the scanned parameters."""

    if surface.energy is None:  # the orbits' own
        return ""
    parts = {"energy": f"$E = {number(surface.energy)}$"}
    if system.isotropic:
        parts |= {name: equal(name, getattr(surface, name)) for name in ("p_eta", "p_gamma")}
    return ", ".join(text for name, text in parts.items() if name not in without)


def outcomes(status: np.ndarray) -> str:
    """Count the outcomes of orbits in a caption."""
    found = summary(status)
    total = f"{np.size(status)} orbits"
    others = [f"{count} {words(outcome)}" for outcome, count in found.items() if outcome != Status.OK]
    return total + (f", {', '.join(others)}" if others else "")


def figure_of(panels: int = 1) -> tuple[Any, Any]:
    """Return a figure and its panels."""
    from matplotlib.figure import Figure

    rows = 2 if panels == 4 else 1
    width = {1: 7.6, 2: 12.6, 3: 17.0, 4: 12.6}[panels]
    if rows > 1:
        height = 6.2 * rows
    elif panels < 3:
        height = 6.2
    else:
        height = 5.6
    with styled():
        figure = Figure(figsize=(width, height), dpi=200, layout="constrained")
        return figure, figure.subplots(rows, panels // rows)


def finish(figure: Any, plan: JobPlan, surface: Any, text: str) -> None:
    """Put title and caption on a figure of orbits."""
    title(figure, ", ".join(filter(None, [titled(plan.model), surface_in_words(plan.system, surface)])))
    where = "" if plan.section is None else f"section {in_words(plan.section, plan.system)}"
    caption(figure, "; ".join(filter(None, [where, text, units(plan.model)])))


def title(figure: Any, text: str) -> None:
    """Write a title above the figure, in lines that fit: the formula of a model can be long."""
    figure.suptitle("\n".join(wrapped(text, 11 * figure.get_figwidth())), fontsize=11)


def caption(figure: Any, text: str) -> None:
    """Write a caption below the figure, the first of its parts that fit in one line."""
    width = 17 * figure.get_figwidth()
    line = ""
    for part in filter(None, text.split("; ")):
        longer = f"{line}; {part}" if line else part
        if line and visible(longer) > width:
            break
        line = longer
    figure.supxlabel(line, fontsize=7.5, color=Palette.of(figure).grey(0.3))


PLACES = {".png": "Description", ".pdf": "Subject", ".svg": "Description"}
"""Where the formats of figures keep the parameters."""


def write(figure: Any, stem: Path, ending: str, facts: dict[str, Any], overwrite: bool) -> None:
    """Write a figure with the parameters inside it, whole or not at all; name the file."""
    from ...results.calls import plain
    from ...results.provenance import provenance

    kept = {name: plain(value) for name, value in facts.items() if not isinstance(value, np.ndarray)}
    said = {"Title": "fastaff", PLACES[ending.lower()]: json.dumps({**provenance(), **kept})}
    with styled():
        print(
            write_atomically(
                stem, ending, lambda path: figure.savefig(path, metadata=said, facecolor="auto"), overwrite=overwrite
            )
        )
