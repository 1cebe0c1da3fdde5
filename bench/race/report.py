"""Output of the race: JSON with a stamp of the machine, Markdown tables, figures, and the summaries."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from textwrap import fill

import numpy as np
from pages import put, stamp, version, where

from .contest import Row, Timed, best

COLOURS = {
    "fastaff": "#d1495b",
    "heyoka": "#2e5eaa",
    "heyoka, ensemble": "#8fb1e3",
    "SciPy": "#6a994e",
    "pynamicalsys": "#7b5ea7",
    "gala": "#e09f3e",
}
MARKERS = dict(zip(COLOURS, "osv^Dh"))


def seconds(value: float) -> str:
    """Write a time with its unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


def verdict(own: Timed, peer: Timed) -> str:
    """Write how many times the peer's processor time is ours, and say so where we are behind."""
    ratio = peer.cpu / own.cpu
    return f"{ratio:.{0 if ratio >= 10 else 1}f} ×" if ratio >= 1 else f"**{ratio:.2f} ×, behind**"


def cell(entry: Timed, own: Timed | None, row: Row) -> str:
    """Write a run: time, ratio to ours, error, how."""
    per = f" ({seconds(entry.cpu / row.per[1])} per {row.per[0]})" if row.per else ""
    ratio = f", {verdict(own, entry)}" if own is not None and entry.program != "fastaff" else ""
    return f"{seconds(entry.cpu)}{per}{ratio}; {entry.error:.1e}; {entry.how}"


def table(row: Row, timed: Sequence[Timed]) -> str:
    """Return a row's Markdown table: accuracies down, programs across; or one line for each run."""
    programs = list(dict.fromkeys(entry.program for entry in timed))
    lines = [
        f"## {row.title}",
        "",
        f"Error: {row.error}." + (f" Note: {row.note}." if row.note else ""),
    ]
    missing = [name for name in row.programs if version(name) is None]
    if missing:
        lines.append(f"Left out, not installed: {', '.join(missing)}.")
    lines.append("")
    if not row.asked:
        lines += ["| program | time; error; how |", "|---|---|"]
        return "\n".join([*lines, *(f"| {entry.program} | {cell(entry, None, row)} |" for entry in timed)])
    lines += [f"| error | {' | '.join(programs)} |", "|---" * (len(programs) + 1) + "|"]
    for asked in row.asked:
        own = next(iter(best(timed, asked, "fastaff")), None)
        cells = []
        for program in programs:
            found = best(timed, asked, program)
            reached = min(entry.error for entry in timed if entry.program == program)
            cells.append(cell(found[0], own, row) if found else f"not reached ({reached:.1e})")
        lines.append(f"| {asked:.0e} | {' | '.join(cells)} |")
    return "\n".join(lines)


def summary(results: Sequence[tuple[Row, Sequence[Timed]]]) -> str:
    """Return the short table: a line for each work and error, with the fastest other package that reaches it."""
    lines = ["| work | error | fastaff | other package | its CPU time | ratio |", "|---|---|---|---|---|---|"]
    for row, timed in results:
        title = row.title
        for asked in row.asked:
            own = next(iter(best(timed, asked, "fastaff")), None)
            peers = [e for e in timed if e.program != "fastaff" and e.error <= asked]
            peer = min(peers, key=lambda entry: entry.cpu, default=None)
            said = [title, f"{asked:.0e}", seconds(own.cpu) if own else "**not reached**"]
            said += [peer.program, seconds(peer.cpu)] if peer else ["none reaches it", ""]
            lines.append(f"| {' | '.join(said)} | {verdict(own, peer) if own and peer else ''} |")
            title = ""
        if not row.asked:
            own = min((e for e in timed if e.program == "fastaff"), key=lambda entry: entry.cpu)
            lines.append(f"| {title} | {own.error:.1e} | {seconds(own.cpu)} | none | | |")
    return "\n".join(lines)


BRIEF = {
    "End states of 4096 orbits, three systems": ("End states of 4096 orbits",),
    "Sections of 1024 and 4096 orbits, two systems": ("Section of 4096 orbits", "Section of 1024 orbits"),
    "Section of a single orbit, 306 crossings": ("Section of one orbit",),
    "Three spectral lines of 1000 signals": ("1000 signals",),
    "Frequencies of 1024 orbits": ("Frequencies of 1024 orbits",),
    "SALI and Lyapunov spectra of 1024 orbits": ("SALI of", "Lyapunov spectrum of"),
}
"""Lines of the table of README, each with the beginnings of the titles of its rows."""


def brief(results: Sequence[tuple[Row, Sequence[Timed]]]) -> str:
    """Return the table of README: for each line of BRIEF the span of ratios over its rows and the accuracies asked."""
    lines = ["| work, at equal measured error | CPU time of the fastest other program over `fastaff`'s |", "|---|---|"]
    for title, begins in BRIEF.items():
        ratios: dict[str, list[float]] = {}
        for row, timed in results:
            for asked in row.asked if row.title.startswith(begins) else ():
                own = next(iter(best(timed, asked, "fastaff")), None)
                others = [e for e in timed if e.program != "fastaff" and e.error <= asked]
                if own and others:
                    peer = min(others, key=lambda entry: entry.cpu)
                    ratios.setdefault(peer.program, []).append(peer.cpu / own.cpu)
        said = []
        for program, found in ratios.items():
            span = " to ".join(dict.fromkeys(_ratio(value) for value in (min(found), max(found))))
            said.append(f"{span} × {program}" + (" (**slower**)" if min(found) < 1 else ""))
        if said:
            lines.append(f"| {title} | {'; '.join(said)} |")
    return "\n".join(lines)


def _ratio(value: float) -> str:
    return f"{value:.{0 if value >= 10 else 1 if value >= 1 else 2}f}"


def started(starts: dict[str, dict], grid: dict) -> str:
    """Return the tables of first starts and of the frequency map of a grid."""
    lines = ["## New processes", "", "CPU time (wall time), including the import. Cold: nothing compiled before.", ""]
    lines += ["| what | cold | warm |", "|---|---|---|"]
    for name, run in starts.items():
        cells = [f"{run[kind]:.2f} s ({run[kind + '_wall']:.2f} s)" for kind in ("cold", "warm")]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    lines += ["", "## Frequency map of a grid of the neo-Hookean body, E = 1.5, 100 periods, end to end", ""]
    lines.append(
        f"{grid['cells']} × {grid['cells']} cells, {grid['orbits']} orbits, {grid['regular']} regular: "
        f"{grid['cpu']:.1f} s of processor time ({grid['wall']:.1f} s elapsed), "
        f"{seconds(grid['cpu'] / grid['orbits'])} an orbit, {grid['peak_GiB']:.2f} GiB at its peak; "
        f"median error estimate of the regular ones {grid['median_error_estimate']:.1e} of the largest frequency. "
        "No other package makes such a map."
    )
    return "\n".join(lines)


def figure(results: Sequence[tuple[Row, Sequence[Timed]]], columns: int, path: Path) -> None:
    """Draw processor time against error: the envelope of each program, its other runs as dots."""
    import matplotlib.pyplot as plt

    rows = -(-len(results) // columns)
    fig, axes = plt.subplots(rows, columns, figsize=(4.6 * columns, 3.7 * rows), layout="constrained", squeeze=False)
    for ax, (row, timed) in zip(axes.flat, results):
        for program in dict.fromkeys(entry.program for entry in timed):
            runs = sorted((e for e in timed if e.program == program and np.isfinite(e.error)), key=lambda e: e.cpu)
            ax.plot([e.error for e in runs], [e.cpu for e in runs], ".", color=COLOURS[program], alpha=0.3, ms=4)
            smallest = np.minimum.accumulate([np.inf, *(e.error for e in runs)])
            front = [e for e, before in zip(runs, smallest) if e.error < before]
            style = {"color": COLOURS[program], "marker": MARKERS[program], "ms": 4, "lw": 1.4, "label": program}
            ax.plot([e.error for e in front], [e.cpu for e in front], **style)
        ax.set(xscale="log", yscale="log", xlabel="measured error", ylabel="processor time [s]")
        low, high = ax.get_ylim()
        ax.set_ylim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
        ax.set_title(fill(row.title.replace(" = ", "\u00a0=\u00a0"), 44), fontsize=9)
        ax.invert_xaxis()
        ax.grid(alpha=0.3)
    for ax in list(axes.flat)[len(results) :]:
        ax.remove()
    named = {label: line for ax in fig.axes for line, label in zip(*ax.get_legend_handles_labels())}
    fig.legend(named.values(), named.keys(), loc="outside lower center", ncols=len(named), fontsize=8)
    fig.savefig(path, dpi=120)
    plt.close(fig)


def write(results: Sequence[tuple[Row, list[Timed]]], starts: dict, grid: dict, folder: Path) -> None:
    """Write race.json, race.md and the figures to a folder, and the summaries to README and the site."""
    folder.mkdir(parents=True, exist_ok=True)
    made_on = stamp()
    rows = [
        {"title": row.title, "error": row.error, "asked": row.asked, "note": row.note, "runs": [*map(asdict, timed)]}
        for row, timed in results
    ]
    whole = {"machine": made_on, "rows": rows, "starts": starts, "frequency_map": grid}
    (folder / "race.json").write_text(json.dumps(whole, indent=1, ensure_ascii=False) + "\n")
    figures = {"end_states.png": "End states", "sections.png": "Section"}
    for name, begin in figures.items():
        chosen = [(row, timed) for row, timed in results if row.title.startswith(begin)]
        if chosen:
            figure(chosen, 2 if len(chosen) == 4 else len(chosen), folder / name)
    text = [
        "# Benchmarks against other packages",
        "",
        "This page lists CPU times at equal measured error. Each package is used as its documentation recommends.",
        "",
        f"Written by `make bench-peers`: {where(made_on)}",
        "",
        "- Times are CPU times of all threads, the shortest of alternating runs, without compilation.",
        "- For each error a cell gives the fastest run of a package that reaches it: time, ratio to `fastaff`,",
        "  measured error, method.",
        "- If a package is slow, it integrates part of the orbits, and its time is scaled.",
        "- `heyoka` restarts one batch integrator for each eight orbits. `heyoka, ensemble` is its",
        "  `ensemble_propagate_until_batch`, which copies the integrator for each batch.",
        "",
        *(f"![{begin}: error against processor time]({name})\n" for name, begin in figures.items()),
        *(table(row, timed) + "\n" for row, timed in results),
        started(starts, grid),
        "",
    ]
    (folder / "race.md").write_text("\n".join(text))
    put("README.md", "race", f"{brief(results)}\n\n{where(made_on)}")
    put("docs/benchmarks/performance.md", "race", f"{summary(results)}\n\n{where(made_on)}")
