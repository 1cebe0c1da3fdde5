"""`fastaff animate`: the body, or a point in its potential, in motion."""

# ruff: noqa: B008
from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...jobs.system import EnergySurface, Model
from ...jobs.wording import OptionError
from ...runs.requirements import current_system
from ..options import HOW, STARTS, WRITTEN, Output, Parameter, pair
from ..progress import TerminalProgress, compiled
from .captions import caption, surface_in_words, title, titled

MOST = 4
"""Motions side by side."""


def animate(
    *,
    options: Model = Model(),
    surface: EnergySurface = EnergySurface(),
    start: Annotated[list[str] | None, Parameter(group=STARTS)] = None,
    time: Annotated[float, Parameter(group=HOW)] = 40.0,
    frames: Annotated[int, Parameter(group=HOW)] = 200,
    out: Annotated[Path, Parameter(group=WRITTEN)] = Path("fastaff-animation.gif"),
    overwrite: Annotated[bool, Parameter(group=WRITTEN)] = False,
) -> int:
    """Animate motions: a body as an ellipse with its material lines, a system of two coordinates as a moving point.

    Parameters
    ----------
    start
        U,P: the section's coordinate and its momentum where a motion starts; up to four times, side by side. [one
        random point]
    time
        Time of the motion. [40]
    frames
        Frames, 25 a second. [200]
    out
        Path of the animation: .gif, or .mp4 where ffmpeg is installed. [fastaff-animation.gif]
    overwrite
        Replace an existing file instead of numbering the new one.
    """
    Output().check()
    from ... import plot

    body = options.build()
    system = current_system(body)
    section = surface.build(system)
    at = [pair("--start must be two numbers U,P, for example 0.7,0.1", text) for text in start or ()]
    if len(at) > MOST:
        raise OptionError(f"--start is taken up to {MOST} times, got {len(at)}")
    if out.suffix.lower() not in plot.animation.ENDINGS:
        raise OptionError(f"--out must end with {' or '.join(plot.animation.ENDINGS)}, got {out}")
    if not out.parent.is_dir():
        raise OptionError(f"--out {out}: the folder {out.parent} does not exist")
    z0, names = _starts(body, section, surface, at)
    heads = None if not at else [_named(names, point) for point in at]
    made: list[Any] = []
    compiled(lambda: made.append(plot.animate(body, z0, time=time, frames=frames, titles=heads)))
    animation = made[0]
    with plot.styled():
        title(animation.figure, ", ".join(filter(None, [titled(body), surface_in_words(system, surface)])))
        if "a1" in getattr(body, "coordinates", ()):
            caption(animation.figure, "the unit circle of the material, with eight of its radii and two inner circles")
    with TerminalProgress("frames") as callback:
        path = plot.save_animation(animation, out, overwrite=overwrite, callback=callback)
    print(path)
    return 0


def _starts(model: Any, section: Any, surface: EnergySurface, at: list[tuple[float, float]]) -> tuple[np.ndarray, Any]:
    """Return phase points (2n, motions) on the energy surface, and the names of the section's coordinates."""
    import fastaff

    where = {"section": section, "energy": surface.energy, "p_eta": surface.p_eta, "p_gamma": surface.p_gamma}
    if not at:
        sample = fastaff.energy_sample(model, orbits=1, seed=0, **where)
        return sample.z0, sample.names
    grids = [fastaff.energy_grid(model, axes=([u], [p]), **where) for u, p in at]
    return np.concatenate([grid.z0 for grid in grids], axis=1), grids[0].names


def _named(names: Any, point: tuple[float, float]) -> str:
    from ...plot.style import symbol

    return ", ".join(f"${symbol(name)} = {value:g}$" for name, value in zip(names, point, strict=True))
