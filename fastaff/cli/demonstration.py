"""The demonstration: islands, chaos and resonances of a neo-Hookean body beside an integrable one."""

from __future__ import annotations

import json
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import files, plot
from ..core.placing import write_atomically
from ..core.status import describe
from ..frequencies.frequencies import FrequencyMap
from ..frequencies.frequency_map import frequency_map
from ..results.machine import cores
from ..results.provenance import provenance
from ..sections.energy_grid import EnergyGrid, energy_grid, grid_of
from ..sections.poincare_map import poincare_map
from ..sections.section_map import SectionMap
from ..systems.models import Body, Hyperelastic, NeoHookean
from ..systems.models.sections import AlphaTurning

P_ETA = 0.3
P_GAMMA = 0.2
SECTION = AlphaTurning(+1)
SEED = 1
CHAOTIC = -4.0
"""log10 of the change of frequency between the halves above which an orbit is counted as chaotic."""

Say = Callable[[str], None]
Meter = Callable[[str], Any]


@dataclass(frozen=True)
class Size:
    """Size of the computation."""

    orbits: int
    crossings: int
    cells: tuple[int, int]
    time: float


FULL = Size(orbits=320, crossings=800, cells=(56, 56), time=600.0)
QUICK = Size(orbits=40, crossings=60, cells=(24, 20), time=200.0)


@dataclass(frozen=True)
class Portrait:
    """One body: its section with the diffusion of each orbit, and its frequency map over (beta, p_gamma)."""

    name: str
    model: Body
    energy: float
    section: SectionMap
    diffusion: np.ndarray
    grid: EnergyGrid
    map: FrequencyMap
    edge: plot.Edge
    seconds: tuple[float, float]

    @property
    def shown(self) -> np.ndarray:
        """Orbits (orbits,) drawn in the plane of frequencies: regular ones, but for islands, which have the frequency
        of their chain, so that nu_r is a fifth or more from its median or the ratio within 1/1000 of 1 or 2, or beyond.
        """
        found = self.map
        ratio = plot.frequency(self.map, _plane(self)[0])
        r = found.nu[found.names.index("r")]
        near = (np.abs(r / np.median(r) - 1.0) < 0.2) & (ratio > 1.001) & (ratio < 1.999)
        return found.regular & near


def run(
    out_dir: Any,
    quick: bool = False,
    *,
    threads: int | None = None,
    say: Say = print,
    meter: Meter | None = None,
    overwrite: bool = False,
) -> list[Path]:
    """Compute both bodies, draw the figure and save it with its data; return the files written.

    Parameters: out_dir, made if missing; quick: a small version in seconds; threads; say: where lines of text go;
    meter: gives, for a title, a callback of the fraction; overwrite: replace earlier files instead of numbering the new
    ones.

    Both bodies have mu = 1, p_eta = 0.3, p_gamma = 0.2 and the energy 1.5 above their minimum (0 for the neo-Hookean
    body, 2 C for the hyperelastic one). At this energy of the neo-Hookean body (G = 1, K = 2) the chains of islands of
    the resonances 3:2, 4:3, 10:7 stand in a sea of chaos that covers about a third of the section; at 1.2 there is
    hardly any chaos, at 1.8 little else.
    Cost: about three minutes on two cores, and one of compilation the first time.
    """
    size = QUICK if quick else FULL
    folder = Path(out_dir)
    folder.mkdir(parents=True, exist_ok=True)
    start = clock.perf_counter()
    portraits = [
        portrait("neo-Hookean", Body(NeoHookean(G=1.0, K=2.0), 1.0), 1.5, size, threads, say, meter),
        portrait("hyperelastic", Body(Hyperelastic(C=1.0), 1.0), 3.5, size, threads, say, meter),
    ]
    seconds = clock.perf_counter() - start
    how = {"threads": threads or cores(), "quick": quick}
    written, stem = _saved(portraits, folder / "fastaff-demo", how, overwrite)
    figure = draw(*portraits)
    facts = {
        **provenance(),
        "seed": SEED,
        "energies": [p.energy for p in portraits],
        "p_eta": P_ETA,
        "p_gamma": P_GAMMA,
    }
    said = {"Title": "fastaff demo", "Description": json.dumps(facts)}
    image = write_atomically(stem, ".png", lambda path: figure.savefig(path, metadata=said), overwrite=overwrite)
    for p in portraits:
        for line in numbers(p):
            say(line)
    say(f"computed in {seconds:.0f} s, drawn in {clock.perf_counter() - start - seconds:.0f} s; open")
    for path in (image, *written):
        say(f"  {path}")
    return [image, *written]


def _saved(portraits: list[Portrait], stem: Path, how: dict[str, Any], overwrite: bool) -> tuple[list[Path], Path]:
    """Write section and map of each body with their parameters; return the files, and the beginning of their names: all
    have the number of the first.
    """
    written: list[Path] = []
    endings = [f"-{p.name.lower()}-{part}.npz" for p in portraits for part in ("section", "map")]
    for p in portraits:
        common = {"model": p.model, "energy": p.energy, "p_eta": P_ETA, "seed": SEED, **how}
        extra = {"p_gamma": P_GAMMA, "diffusion": p.diffusion, "wall_time": p.seconds[0]}
        over = {
            "section": SECTION,
            "z0": p.grid.z0,
            "cell_index": p.grid.cell_index,
            "shown": p.shown,
            "axis_0": p.grid.axes[0],
            "axis_1": p.grid.axes[1],
            "axis_names": p.grid.names,
            "wall_time": p.seconds[1],
        }
        for result, more in ((p.section, extra), (p.map, over)):
            ending = endings[len(written)]
            beside = [] if written else [".png", *endings]
            path = files.save_among(
                stem, ending, result, parameters={**common, **more}, beside=beside, overwrite=overwrite
            )
            written.append(path)
            stem = path.with_name(path.name.removesuffix(ending))
    return written, stem


def portrait(name, model, energy, size: Size, threads, say: Say, meter: Meter | None) -> Portrait:
    """Compute section and frequency map of one body."""
    callback = meter or (lambda title: None)
    edge = plot.edge(model, SECTION, energy=energy, p_eta=P_ETA, p_gamma=P_GAMMA)
    z0 = random_starts(model, edge, energy, size.orbits)
    _compile(model, z0[:, :1], threads, say)
    say(f"{name}: section of {size.orbits} orbits x {size.crossings} crossings")
    start = clock.perf_counter()
    # Return times are below one breathing period.
    section = poincare_map(
        model,
        z0,
        section=SECTION,
        crossings=size.crossings,
        max_time=20.0 * size.crossings,
        accuracy=1e-8,
        threads=threads,
        callback=callback(f"{name}, section"),
    )
    between = clock.perf_counter()
    diffusion = frequency_map(model, z0, time=size.time, threads=threads).diffusion
    say(f"{name}: frequency map")
    grid = surface(model, energy, size.cells)
    grown = clock.perf_counter()
    found = frequency_map(model, grid.z0, time=size.time, threads=threads, callback=callback(f"{name}, frequency map"))
    seconds = (between - start, clock.perf_counter() - grown)
    return Portrait(name, model, energy, section, diffusion, grid, found, edge, seconds=seconds)


def _compile(model: Any, z0: np.ndarray, threads: int | None, say: Say) -> None:
    """Compile the kernels of a portrait, so that its times are those of the computation."""
    start = clock.perf_counter()
    poincare_map(model, z0, section=SECTION, crossings=1, max_time=20.0, step=0.05, threads=threads)
    frequency_map(model, z0, time=5.0, threads=threads)
    seconds = clock.perf_counter() - start
    if seconds > 2.0:
        say(f"compiled in {seconds:.0f} s, once for this version")


def random_starts(model: Any, edge: plot.Edge, energy: float, orbits: int) -> np.ndarray:
    """Return starts (2n, orbits), uniform over the accessible part of the section."""
    (u0, u1), (v0, v1) = edge.axes
    axes = (np.linspace(u0, u1, 202)[1:-1], np.linspace(v0, v1, 202)[1:-1])
    fine = energy_grid(model, energy=energy, section=SECTION, axes=axes, p_eta=P_ETA, p_gamma=P_GAMMA)
    chosen = np.random.default_rng(SEED).choice(fine.cell_index.size, size=orbits, replace=False)
    return np.ascontiguousarray(fine.z0[:, chosen])


def surface(model: Any, energy: float, cells: tuple[int, int]) -> EnergyGrid:
    """Return a grid over beta and p_gamma of the energy surface, at p_beta = 0 on the section."""
    edge = plot.edge(model, SECTION, energy=energy, p_eta=P_ETA)
    beta = np.linspace(0.0, edge.coordinate[-1], cells[0] + 2)[1:-1]
    # The largest p_gamma: beta sqrt(2 mu (E - V_effective)) at its maximum over beta.
    top = float((edge.coordinate * edge.momentum).max())
    p_gamma = top * (np.arange(cells[1]) + 0.5) / cells[1]
    z0 = []
    cell = []
    for k, value in enumerate(p_gamma):
        try:
            row = energy_grid(model, energy=energy, section=SECTION, axes=(beta, [0.0]), p_eta=P_ETA, p_gamma=value)
        except ValueError:  # nothing is reached so close to the largest p_gamma
            continue
        z0.append(row.z0)
        cell.append(row.cell_index * cells[1] + k)
    return grid_of(
        np.concatenate(z0, axis=1), np.concatenate(cell), (beta, p_gamma), ("beta", "p_gamma"), energy, SECTION
    )


def numbers(p: Portrait) -> list[str]:
    """Return the main numbers of one portrait, in lines."""
    crossings = int(p.section.counts.sum())
    section_time, map_time = p.seconds
    chaotic = np.count_nonzero(p.map.diffusion > CHAOTIC)
    lines = [
        f"{p.name}, E = {p.energy:g}:",
        f"  section: {p.section.status.size} orbits, {crossings} crossings, {crossings / section_time:,.0f} "
        "crossings/s, "
        f"largest energy error {p.section.energy_error.max():.1e}; {p.section.summary()}",
        f"  frequency map: {p.map.status.size} orbits, {p.map.status.size / map_time:,.0f} orbits/s, largest energy "
        "error "
        f"{np.max(np.asarray(p.map.energy_error)):.1e}; {describe(p.map.status)}",
        f"  {chaotic} chaotic (diffusion > {CHAOTIC:g}), {p.map.status.size - chaotic} regular; "
        f"{np.count_nonzero(~p.shown)} not drawn in the plane of frequencies",
    ]
    if p.name == "hyperelastic":
        exact = np.sqrt(p.model.potential.C / p.model.mu) / np.pi
        lines.append(f"  nu_r = sqrt(C/mu)/pi for all orbits, to {np.abs(p.map.nu[0] - exact).max():.1e}")
    return lines


LINES = ((2, 0, -3), (3, 0, -4), (5, 0, -6), (7, 0, -10))
"""The resonances m:n, as (n, 0, -m), of the largest chains of islands of the neo-Hookean body."""


def _plane(p: Portrait) -> tuple[str, str]:
    other, r = sorted(p.map.names[:2], key="r".__eq__)
    return f"{other}/{r}", f"gamma/{r}"


TYPE = {"figure.labelsize": 12.0, "axes.labelsize": 13.0, "axes.titlesize": 12.0}
TICKS = 11.0
"""Sizes in points: 7.5 pixels and more on a telephone, whose 390 pixels show the 7.2 inches of the figure."""

WIDTH, HEIGHT = 7.2, 10.8
"""Inches of the figure."""


def draw(chaotic: Portrait, integrable: Portrait) -> Any:
    """Draw both portraits side by side: section, diffusion over the energy surface, frequency map."""
    import matplotlib
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, HEIGHT), dpi=200)
    layout = figure.add_gridspec(
        4, 2, height_ratios=(1, 1, 1, 0.06), left=0.115, right=0.975, bottom=0.1, top=0.925, wspace=0.36, hspace=0.56
    )
    norm = plot.clipped(np.concatenate([chaotic.map.diffusion, chaotic.diffusion]))
    with matplotlib.rc_context(TYPE):
        for column, p in enumerate((chaotic, integrable)):
            axes = [figure.add_subplot(layout[k, column]) for k in range(3)]
            last = _draw_column(p, axes, norm, column)
        bar = figure.colorbar(last, cax=figure.add_subplot(layout[3, :]), extend="both", orientation="horizontal")
    bar.ax.tick_params(labelsize=TICKS)
    bar.set_label(r"diffusion  $\log_{10}\,\max_k\,|\nu_k^{(2)}-\nu_k^{(1)}|$", fontsize=TYPE["figure.labelsize"])
    figure.text(0.5, 0.008, _caption(), fontsize=TICKS, ha="center", va="bottom")
    return figure


def _draw_column(p: Portrait, axes: list, norm: Any, column: int) -> Any:
    drawn = plot.plot_section(
        p.section, ax=axes[0], values=p.diffusion, boundary=p.edge, norm=norm, colorbar=False, size=0.4
    )
    plot.plot_diffusion_grid(p.grid, p.map.diffusion, ax=axes[1], norm=norm, colorbar=False)
    axes[1].axhline(P_GAMMA, color="0.1", lw=1.8)
    axes[1].axhline(P_GAMMA, color="white", lw=1.1, ls=(0, (5, 4)))
    axes[1].set_ylim(0.0, None)
    x, y = _plane(p)
    limits = tuple(_padded(plot.frequency(p.map, name)[p.shown]) for name in (x, y))
    lines = LINES if column == 0 else ()
    frequencies = plot.plot_frequency_map(
        p.map, ax=axes[2], x=x, y=y, shown=p.shown, norm=norm, colorbar=False, lines=lines, limits=limits, size=2.0
    )
    for label in frequencies.labels:
        label.set_fontsize(TICKS)
    titles = (r"section $p_\alpha=0$", r"all $p_\gamma$, at $p_\beta=0$", "frequencies")
    axes[0].annotate(
        f"{p.name} body",
        (0, 1),
        (0, 26),
        "axes fraction",
        "offset points",
        fontsize=TYPE["axes.labelsize"],
        weight="bold",
    )
    for k, ax in enumerate(axes):
        above = column == 0 and k == 2
        ax.set_title(
            f"({'abcdef'[2 * k + column]}) {titles[k]}",
            fontsize=TYPE["axes.titlesize"],
            loc="left",
            pad=20 if above else 5,
        )
        ax.tick_params(labelsize=TICKS)
        ax.xaxis.label.set_fontsize(TYPE["axes.labelsize"])
        ax.yaxis.label.set_fontsize(TYPE["axes.labelsize"])
        ax.locator_params(nbins=4)
    return drawn.points


def _padded(values: np.ndarray) -> tuple[float, float]:
    low, high = np.quantile(values, [0.001, 0.999]) if values.size else (0.0, 1.0)
    pad = 0.04 * (high - low) or 0.05
    return float(low - pad), float(high + pad)


def _caption() -> str:
    """Return one line: the meaning of the lines; the rest is in the documentation."""
    return r"dashed: $p_\gamma$ of (a), (b);   $m\!:\!n$: resonances $n\,\nu_{\rm area}=m\,\nu_r$"
