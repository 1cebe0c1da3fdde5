"""`fastaff spectrum`: quantum levels of a body or of some of its symmetry classes, against a parameter too."""

# ruff: noqa: B008
from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import Annotated, Any

import numpy as np

from ...core.interruption import partial_result_on_interrupt
from ...core.names import named
from ...core.numbers import shown, whole
from ...jobs.system import Model
from ...jobs.wording import OptionError
from ...quantum.states.level_table import VIBRATION
from ..options import HOW, WRITTEN, Output, Parameter
from ..progress import TerminalProgress, drawing, watched
from ..stops import Stops, say
from . import scans
from .captions import caption, figure_of, title, titled, units, write
from .level_tables import level_table, scan_table, vibration_table

PANELS = 4
"""Densities in one figure."""
SEPARATED = 1e-10
"""Tolerance of bodies that separate."""

COUPLED = 1e-6
"""Tolerance of bodies that do not separate."""

Watch = Callable[[Callable[[TerminalProgress], Any], str], Any]


def energy_levels(
    *,
    options: Model = Model(),
    output: Output = Output(),
    m: Annotated[str | None, Parameter(group=HOW, allow_leading_hyphen=True)] = None,
    l: Annotated[str | None, Parameter(group=HOW, name="--l", allow_leading_hyphen=True)] = None,
    levels: Annotated[int, Parameter(group=HOW)] = 20,
    max_energy: Annotated[float | None, Parameter(group=HOW)] = None,
    hbar: Annotated[float, Parameter(group=HOW)] = 1.0,
    chart: Annotated[str | None, Parameter(group=HOW)] = None,
    double_cover: Annotated[bool, Parameter(group=HOW)] = False,
    tolerance: Annotated[float | None, Parameter(group=HOW)] = None,
    scan: Annotated[str | None, Parameter(group=HOW)] = None,
    states: Annotated[str | None, Parameter(group=WRITTEN)] = None,
    density_chart: Annotated[str | None, Parameter(group=WRITTEN)] = None,
) -> int:
    """Compute quantum levels with their degeneracies and errors, print them and draw them.

    For --hamiltonian in one to three coordinates, the levels are those of a vibration, without --m and --l. For a body
    without --m and --l they are its lowest levels, none missing. With both, they are the levels of one or more symmetry
    classes e^(i m phi + i l psi).

    The figure shows levels against the spin m and their degeneracies. With --scan it shows levels against m, l or a
    parameter. For one class it shows probability densities of the states with the classical turning curve.

    Parameters
    ----------
    m
        Spin in units of hbar, a whole number or all of LOW:HIGH, such as -3:3. With --l, or both left out.
    l
        Vorticity, the same; m + l must be even, and ranges skip the other classes.
    levels
        Levels of each class, or different energies of the whole body. [20]
    max_energy
        All levels of the whole body below this energy, instead of --levels.
    hbar
        Planck's constant over 2 pi, in the units of the actions. [1]
    chart
        alpha-beta, r-vartheta or elliptic, for quantum numbers of bodies that separate in several. [the first]
    double_cover
        Take m + l odd too: functions on the double covering of GL(2,R).
    tolerance
        Relative error of levels that count as converged. [1e-10; 1e-6 where the body does not separate]
    scan
        NAME=LOW:HIGH:N: levels of the classes against a parameter of the body such as C, or mu.
    states
        Numbers of the states to draw for one class, from 0, with commas, up to four. [0,1,2,3]
    density_chart
        alpha-beta, r-vartheta or two-polar, for the densities. [that of the levels]
    """
    whole("levels", levels, 1)
    body = options.build()
    vibration, separates = _kind(body)
    _for_bodies(vibration, m, l, chart, max_energy, scan, states, density_chart, double_cover or None)
    classes = _classes(m, l, double_cover)
    if chart is not None:
        named("--chart", chart, ("alpha-beta", "r-vartheta", "elliptic"))
    _chart(density_chart)
    if scan is not None and classes is None:
        raise OptionError("--scan needs --m and --l, the classes whose levels are followed")
    if max_energy is not None and classes is not None:
        raise OptionError("--max-energy belongs to the whole body; with --m and --l give --levels")
    if (states is not None or density_chart is not None) and (classes is None or len(classes) > 1 or scan is not None):
        raise OptionError("--states and --density-chart belong to one class: give --m and --l, one number each")
    _states(states, levels)
    stem = output.stem("fastaff-spectrum")
    output.check()
    how: dict[str, Any] = {
        "hbar": hbar,
        "single_valued": not double_cover,
        "chart": chart,
        "tolerance": (SEPARATED if separates else COUPLED) if tolerance is None else tolerance,
    }
    facts = {
        "options": {name: value for name, value in vars(options).items() if value is not None},
        "states": states,
        "density_chart": density_chart,
        "model": body,
        "spin": m,
        "vorticity": l,
        "levels": levels,
        "max_energy": max_energy,
        "double_cover": double_cover,
        **how,
        "scan": scan,
    }
    facts |= {name: getattr(getattr(body, "potential", None), name, None) for name in ("formula", "domain")}
    start = clock.perf_counter()

    def save(result: Any, interrupted: bool = True) -> Any:
        gathered = {"first": result.multiplets().first} if hasattr(result, "multiplets") else {}
        spent = {"wall_time": clock.perf_counter() - start, "interrupted": interrupted}
        return output.save(stem, result, {**facts, **gathered, **spent})

    def watch(compute: Callable[[TerminalProgress], Any], kept: str) -> Any:
        return watched(TerminalProgress("levels"), compute, lambda partial: _keep(partial, save, kept))

    found: list[Any] | None = None
    if classes is None:
        result = _vibration(body, levels, how, watch) if vibration else _whole(body, levels, max_energy, how, watch)
    elif scan is not None:
        result = _scanned(body, classes, levels, scan, how, watch)
    else:
        found, result = _some(body, classes, levels, how, watch)
    if vibration:
        rows = vibration_table(result)
    elif scan is None:
        rows = level_table(result)
    else:
        rows = scan_table(result)
    path = save(result, interrupted=False)
    print("\n".join(rows))
    say(f"{_said(result, classes)}; {clock.perf_counter() - start:.1f} s")
    with drawing(path):
        if not output.no_figure:
            write(spectrum_figure(result, facts, found), path.with_suffix(""), output.ending, facts, output.overwrite)
    return 0


# Options


def _classes(m: str | None, l: str | None, double_cover: bool) -> list[tuple[int, int]] | None:
    """Return the classes asked for, None for all."""
    if (m is None) != (l is None):
        raise OptionError("give both --m and --l, or neither for the whole body")
    if m is None or l is None:
        return None
    spins = _numbers("--m", m)
    vorticities = _numbers("--l", l)
    if len(spins) == len(vorticities) == 1:
        return [(spins[0], vorticities[0])]
    found = [(one, other) for one in spins for other in vorticities if double_cover or (one + other) % 2 == 0]
    if not found:
        raise OptionError(
            f"m + l must be even, got --m {m} --l {l}. Use --double-cover for functions on the double cover."
        )
    return found


def _numbers(option: str, text: str) -> list[int]:
    low, colon, high = text.partition(":")
    try:
        ends = int(low), int(high if colon else low)
        if ends[0] > ends[1]:
            raise ValueError
    except ValueError:
        raise OptionError(
            f"{option} must be a whole number, or LOW:HIGH with LOW <= HIGH, for example -3:3, got {shown(text)}"
        ) from None
    return list(range(ends[0], ends[1] + 1))


def _states(text: str | None, levels: int) -> list[int]:
    if text is None:
        return list(range(min(PANELS, levels)))
    try:
        numbers = [int(part) for part in text.split(",")]
        if not 1 <= len(numbers) <= PANELS or min(numbers) < 0 or max(numbers) >= levels:
            raise ValueError
    except ValueError:
        raise OptionError(
            f"--states must be one to {PANELS} numbers from 0 to {levels - 1} with commas, for example 0,3, got "
            f"{shown(text)}"
        ) from None
    return numbers


def _chart(name: str | None) -> Any:
    from ...plot.quantum import CHARTS

    known = {chart.name: chart for chart in CHARTS}
    return None if name is None else known[named("--density-chart", name, tuple(known))]


def _kind(model: Any) -> tuple[bool, bool]:
    """Return whether a system is a vibration, and whether it is a body that separates."""
    from ...quantum.spectra import spectrum, vibration

    return (True, False) if vibration.vibrates(model) else (False, bool(spectrum.solved_families(model)))


def _for_bodies(vibration: bool, *given: Any) -> None:
    if vibration and any(value is not None for value in given):
        raise OptionError("a vibration takes --levels, --hbar and --tolerance; the other options are for bodies")


# Computing


def _vibration(model: Any, levels: int, how: dict[str, Any], watch: Watch) -> Any:
    import fastaff

    own = {"count": levels, "hbar": how["hbar"], "tolerance": how["tolerance"]}
    return watch(lambda callback: fastaff.quantum.spectrum(model, **own, callback=callback), "the others are missing")


def _whole(model: Any, levels: int, max_energy: float | None, how: dict[str, Any], watch: Watch) -> Any:
    import fastaff

    asked: dict[str, Any] = {"multiplets": levels} if max_energy is None else {"max_energy": max_energy}
    return watch(
        lambda callback: fastaff.quantum.all_levels(model, **asked, **how, callback=callback),
        "complete below E = {complete_below:.6g}",
    )


def _scanned(
    model: Any, classes: list[tuple[int, int]], levels: int, text: str, how: dict[str, Any], watch: Watch
) -> Any:
    import fastaff

    axis = scans.parsed([text])[0]
    potential: Any = getattr(model, "potential", None)
    named("--scan", axis.name, (*getattr(potential, "_fields", ()), "mu"))
    m, l = zip(*classes, strict=True)

    def make(value: float) -> Any:
        return (
            model._replace(mu=value)
            if axis.name == "mu"
            else model._replace(potential=potential._replace(**{axis.name: value}))
        )

    return watch(
        lambda callback: fastaff.quantum.level_diagram(
            make, axis.values, m=m, l=l, count=levels, name=axis.name, callback=callback, **how
        ),
        "the others are NaN",
    )


def _some(
    model: Any, classes: list[tuple[int, int]], levels: int, how: dict[str, Any], watch: Watch
) -> tuple[list[Any], Any]:
    """Return the levels of each class, and of all of them."""
    import fastaff

    found: list[Any] = []

    def compute(callback: TerminalProgress) -> Any:
        with partial_result_on_interrupt("spectrum", lambda: fastaff.quantum.level_list(found) if found else None):
            for number, (m, l) in enumerate(classes):
                found.append(fastaff.quantum.spectrum(model, m=m, l=l, count=levels, **how))
                callback((number + 1) / len(classes))
        return fastaff.quantum.level_list(found)

    return found, watch(compute, "of the first classes")


def _keep(partial: Any, save: Callable[[Any], Any], kept: str) -> None:
    """Save the levels of an interrupted run, and say so."""
    if partial is None:
        say(f"{Stops.said()} before any level was finished; nothing is kept")
        return
    facts = {"complete_below": getattr(partial, "complete_below", np.nan)}
    done = int(np.count_nonzero(np.isfinite(partial.E)))
    say(f"{Stops.said()}: kept {done} levels, {kept.format(**facts)}, in {save(partial)}; no figure drawn")


def _said(result: Any, classes: list[tuple[int, int]] | None) -> str:
    """Return one line about the computed levels."""
    from ...quantum.states.symmetry import SymmetryClass

    worst = f"largest error {result.error.max(initial=0.0):.1e}"
    if not hasattr(result, "multiplets"):
        return (
            f"{result.E.size} levels of {result.m.shape[1]} classes at {result.values.size} values of "
            f"{result.name}; {worst}"
        )
    text = f"{result.E.size} levels, {len(result.multiplets())} different energies; {worst}"
    if classes is None and VIBRATION in result.method:
        return f"{text}; {result.method}"
    if classes is None:
        return f"{text}; none is missing below E = {result.complete_below:.10g}"
    if len(classes) > 1:
        return f"{text}; degeneracies are those among these {len(classes)} classes"
    others = [other for other in SymmetryClass(*classes[0]).alike() if other != classes[0]]
    return text + (f"; the same levels in the classes {' '.join(f'({m},{l})' for m, l in others)}" if others else "")


# Drawing


def spectrum_figure(result: Any, facts: dict[str, Any], found: list[Any] | None = None) -> Any:
    """Return the figure of levels from the facts in their file; found: the levels of each class, if at hand."""
    from ...plot import quantum as plot_quantum
    from ...quantum.spectra.spectrum import spectrum

    body = Model(**facts["options"]).build()
    if VIBRATION in getattr(result, "method", ""):
        figure, ax = figure_of()
        plot_quantum.plot_spectrum(result, ax=ax)
        text = f"{len(result)} levels; largest error {result.error.max():.0e}"
        return _finish(figure, body, "vibration", text, result.hbar)
    classes = _classes(facts["spin"], facts["vorticity"], facts["double_cover"])
    if classes is None:
        return _whole_figure(result, body)
    if facts["scan"] is not None:
        return _diagram_figure(result, body, classes)
    if found is None and len(classes) == 1:  # wave functions are in no file
        how = {name: facts[name] for name in ("hbar", "single_valued", "chart", "tolerance")}
        found = [spectrum(body, m=classes[0][0], l=classes[0][1], count=facts["levels"], **how)]
    elif found is None:
        found = [result.take(np.flatnonzero((result.m == m) & (result.l == l))) for m, l in classes]
    states = _states(facts["states"], facts["levels"])
    return _classes_figure(found, result, body, states, _chart(facts["density_chart"]))


def _whole_figure(levels: Any, model: Any) -> Any:
    from ...plot import quantum as plot_quantum

    figure, (left, right) = figure_of(panels=2)
    plot_quantum.plot_spectrum(levels, ax=left)
    plot_quantum.plot_degeneracies(levels, ax=right)
    text = (
        f"{levels.E.size} levels, {len(levels.multiplets())} different energies; none is missing below E = "
        f"{levels.complete_below:.6g}"
    )
    return _finish(figure, model, "all classes", text, levels.hbar)


def _diagram_figure(diagram: Any, model: Any, classes: list[tuple[int, int]]) -> Any:
    from ...plot import quantum as plot_quantum

    figure, ax = figure_of()
    plot_quantum.plot_levels(diagram, ax=ax)
    what = f"(m, l) = {classes[0]}" if len(classes) == 1 else f"{len(classes)} classes"
    text = f"{diagram.E.shape[2]} levels of each class; grey: above them; largest error {np.nanmax(diagram.error):.0e}"
    return _finish(figure, model, what, text, diagram.hbar, without=(diagram.name,))


def _classes_figure(found: list[Any], levels: Any, model: Any, states: list[int], chart: Any) -> Any:
    """Return the figure of densities of one class, levels against m or l, or over both."""
    from ...plot import quantum as plot_quantum
    from ...quantum.spectra.level_diagram import diagram_of

    m, l = (np.array([getattr(one, name)[0] for one in found]) for name in ("m", "l"))
    spins = np.unique(m)
    vorticities = np.unique(l)
    if len(found) == 1:
        return _states_figure(found[0], model, states, chart)
    text = f"{found[0].E.size} levels of each class; largest error {levels.error.max():.0e}"
    figure, ax = figure_of()
    if min(len(spins), len(vorticities)) == 1:
        name, values, other = ("m", m, f"l = {l[0]}") if len(spins) > 1 else ("l", l, f"m = {m[0]}")
        plot_quantum.plot_levels(diagram_of(name, values.astype(float), [[one] for one in found]), ax=ax)
        text += "; grey: above them"
    else:
        other = f"{len(found)} classes"
        plot_quantum.plot_spectrum(levels, ax=ax)
    return _finish(figure, model, other, text, levels.hbar)


def _states_figure(found: Any, model: Any, states: list[int], chart: Any) -> Any:
    from ...plot import quantum as plot_quantum

    figure, axes = figure_of(panels=len(states))
    for ax, k in zip(np.atleast_1d(axes).ravel(), states, strict=True):
        state = found.state(k)
        plot_quantum.plot_density(state, ax=ax, model=model, chart=chart)
        named_by = ", ".join(f"${_quantum(name)} = {n}$" for name, n in state.numbers.items() if found.separated)
        ax.set_title(
            f"state {k}:  $E$ = {state.energy:.8g}" + (f",  {named_by}" if named_by else ""), fontsize=10, loc="left"
        )
    text = r"white: classical turning curve; dashed: $\det\varphi = 0$ where it is in the frame"
    return _finish(figure, model, f"(m, l) = ({found.m[0]}, {found.l[0]})", text, found.hbar)


def _quantum(name: str) -> str:
    from ...plot.sections import symbol

    return f"n_{{{symbol(name.removeprefix('n_'))}}}"


def _finish(figure: Any, model: Any, what: str, text: str, hbar: float, without: tuple[str, ...] = ()) -> Any:
    """Put title and caption on a figure of levels, and return it."""
    title(figure, rf"{titled(model, without)}, $\hbar$ = {hbar:g}, {what}")
    caption(figure, f"{text}; {units(model)}")
    return figure
