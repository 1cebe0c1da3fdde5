"""The options of the command line: what they mean, how they are checked, what files and captions say of them (layer L5)."""

from __future__ import annotations

import difflib
import importlib.util
import json
import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

import numpy as np

try:
    import cyclopts
    import rich
    from cyclopts import Group, Parameter
except ImportError:  # `main` says so in one line
    cyclopts = rich = None  # type: ignore[assignment]

    def Group(*_: Any, **__: Any) -> None:  # type: ignore[no-redef]
        """Stand in for cyclopts."""

    def Parameter(*_: Any, **__: Any) -> Any:  # type: ignore[no-redef]
        """Stand in for cyclopts."""
        return lambda options: options


MODELS = {
    "harmonic": ("Harmonic", ("C",)),
    "anharmonic": ("Anharmonic", ("C",)),
    "hyperelastic": ("Hyperelastic", ("C",)),
    "heavy-top": ("HeavyTop", ("C", "A")),
    "neo-hookean": ("NeoHookean", ("G", "K")),
    "henon-heiles": ("HenonHeiles", ("lam",)),
}
SECTIONS = ("alpha-turning", "beta-turning", "alpha=c", "beta=c", "area=c", "x=c", "y=c")


class Wrong(ValueError):
    """Wrong input: its text is all that the user sees."""

HELP = """Poincaré sections and frequency maps of planar affinely-rigid bodies.

Each command computes many orbits on all cores, draws a PNG and writes an .npz file with the numbers, all
parameters, versions and the seed (read it with `fastaff.files.load`). Ctrl-C stops within a second and keeps
what is finished. Exit codes: 0, 2 for wrong input, 130 after Ctrl-C.

Start with one of

- `fastaff demo`
- `fastaff poincare --energy 1.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff poincare --model henon-heiles --energy 0.125 --orbits 200`
- `fastaff frequency-map --model hyperelastic --energy 3.5 --p-eta 0.3 --p-gamma 0.2`
"""
WHAT, WHERE, STARTS, HOW, WRITTEN = (
    Group(name, sort_key=k)
    for k, name in enumerate(("Body", "Energy surface and section", "Starting points", "Computation", "Output"))
)


@Parameter(name="*", group=WHAT)
@dataclass(frozen=True, kw_only=True)
class Model:
    """The body."""

    model: str = "neo-hookean"
    """harmonic, anharmonic, hyperelastic (parameter C), heavy-top (C, A), neo-hookean (G, K), henon-heiles (lam). [neo-hookean]"""
    C: Annotated[float | None, Parameter(name="--C")] = None
    """Stiffness of harmonic, anharmonic, hyperelastic and heavy-top [1]."""
    A: Annotated[float | None, Parameter(name="--A")] = None
    """Strength of the heavy top's cos(vartheta) term [1]."""
    G: Annotated[float | None, Parameter(name="--G")] = None
    """Shear modulus of neo-hookean [1]."""
    K: Annotated[float | None, Parameter(name="--K")] = None
    """Bulk modulus of neo-hookean [2]."""
    lam: float | None = None
    """Coupling of henon-heiles [1]."""
    mu: float = 1.0
    """Inertia of a body. [1]"""

    def build(self) -> Any:
        """Return the model, refusing parameters that it does not have."""
        import fastaff

        key = named("--model", self.model.lower().replace("_", "-"), tuple(MODELS))
        kind, names = MODELS[key]
        given = {name: getattr(self, name) for name in ("C", "A", "G", "K", "lam") if getattr(self, name) is not None}
        for name in given:
            if name not in names:
                raise Wrong(f"--{name} is not a parameter of {key}, which has {', '.join('--' + n for n in names)}")
        value = getattr(fastaff, kind)(**given)
        return value if key == "henon-heiles" else fastaff.Body(value, self.mu)


@Parameter(name="*", group=WHERE)
@dataclass(frozen=True, kw_only=True)
class Surface:
    """Where the orbits live."""

    energy: float | None = None
    """Energy of every orbit. Required."""
    p_eta: float = 0.0
    """Angular momentum in the plane a, |a| = alpha = (D1 + D2)/sqrt(2). [0]"""
    p_gamma: float = 0.0
    """Angular momentum in the plane b, |b| = beta = (D1 - D2)/sqrt(2). [0]"""
    section: str | None = None
    """alpha-turning (p_alpha = 0), beta-turning, alpha=c, beta=c, area=c (D1 D2 = c), x=c or y=c for
    henon-heiles, with c a number. [alpha-turning; x=0]"""
    direction: str = "+1"
    """Crossings where the section function increases (+1), decreases (-1) or both (0). [+1]"""

    def build(self, body: Any) -> Any:
        """Return the section."""
        import fastaff

        if self.energy is None:
            raise Wrong("--energy is required: the energy of every orbit, for example --energy 1.5")
        plane = not isinstance(body, fastaff.Body)
        text = self.section or ("x=0" if plane else "alpha-turning")
        if self.direction.lstrip("+") not in ("1", "-1", "0"):
            raise Wrong(f"--direction must be +1, -1 or 0, got {self.direction}")
        direction = int(self.direction)
        name, equals, constant = text.lower().partition("=")
        form = named("--section", name + "=c" if equals else name, SECTIONS)
        if equals:
            try:
                value = float(constant)
            except ValueError:
                raise Wrong(f"--section {name}=c needs a number for c, got {constant!r}") from None
        if plane != (form in ("x=c", "y=c")):
            suits = "x=c, y=c" if plane else ", ".join(SECTIONS[:5])
            raise Wrong(f"--section {text} does not suit {type(body).__name__}; it takes {suits}")
        if plane:
            normal = (1.0, 0.0, 0.0, 0.0) if form == "x=c" else (0.0, 1.0, 0.0, 0.0)
            return fastaff.Linear(normal, value, direction)
        if not equals:
            return (fastaff.AlphaTurning if form == "alpha-turning" else fastaff.BetaTurning)(direction)
        kinds = {"alpha=c": fastaff.AlphaEquals, "beta=c": fastaff.BetaEquals, "area=c": fastaff.AreaEquals}
        return kinds[form](value, direction)


@Parameter(name="*", group=STARTS)
@dataclass(frozen=True, kw_only=True)
class Starts:
    """Where the orbits start."""

    grid: str | None = None
    """Cells N1xN2 over the section's coordinate and its momentum; cells beyond the energy are left out. [20x20 or 40x40]"""
    orbits: int | None = None
    """Random starts, uniform over the accessible part of the section, instead of a grid."""
    seed: int = 0
    """Seed of the random starts. [0]"""
    range1: str | None = None
    """Range LOW:HIGH of the section's coordinate. [all that the energy allows]"""
    range2: str | None = None
    """Range LOW:HIGH of its momentum. [all that the energy allows]"""

    def build(self, body: Any, section: Any, surface: Surface, default: str) -> tuple[Any, Any, Any]:
        """Return the grid of starts, with all its cells or a random choice, the edge of the section, and the chosen z0."""
        import fastaff

        from . import plot

        if self.grid is not None and self.orbits is not None:
            raise Wrong("give --grid or --orbits, not both")
        if self.orbits is not None and self.orbits < 1:
            raise Wrong(f"--orbits must be at least 1, got {self.orbits}")
        ranges: list[Any] = [_range(name, text) for name, text in (("--range1", self.range1), ("--range2", self.range2))]
        where: dict[str, Any] = {"energy": surface.energy, "p_eta": surface.p_eta, "p_gamma": surface.p_gamma}
        edge = None
        try:
            edge = plot.edge(body, section, **where)
            ranges = [given or found for given, found in zip(ranges, edge.axes)]
        except ValueError as problem:
            if None in ranges:
                raise Wrong(f"{problem}; or give --range1 and --range2") from None
        n1, n2 = (300, 300) if self.orbits is not None else _cells(self.grid or default)
        # Cell centres: the ends of the range are the edge itself.
        axes = [low + (high - low) * (np.arange(n) + 0.5) / n for (low, high), n in zip(ranges, (n1, n2))]
        grid = fastaff.energy_grid(body, section=section, axes=axes, **where)
        z0 = grid.z0
        if self.orbits is not None:
            cells = z0.shape[1]
            chosen = np.random.default_rng(self.seed).choice(cells, size=self.orbits, replace=self.orbits > cells)
            z0 = np.ascontiguousarray(z0[:, chosen])
        return grid, edge, z0


@Parameter(name="*", group=HOW)
@dataclass(frozen=True, kw_only=True)
class Run:
    """How to integrate."""

    scheme: str = "KAHAN_LI8"
    """LEAPFROG, YOSHIDA4, BLANES_MOAN6, KAHAN_LI8, SOFRONIOU_SPALETTA10, RK4, DOP853 and VERNER9 (both adaptive). [KAHAN_LI8]"""
    step: float | None = None
    """Fixed step. [chosen by a short trial for an energy error of 1e-11]"""
    threads: int | None = None
    """Threads. [all cores]"""

    def build(self, body: Any, z0: np.ndarray) -> dict[str, Any]:
        """Return the options of the library's functions, with the step chosen once for all calls."""
        from .engine import make_flow
        from .schemes import scheme_named

        scheme = scheme_named(self.scheme.replace("-", "_"))
        flow, _ = make_flow(body, z0, scheme, self.step, 1e-12, 1e-12, self.threads)
        return {"scheme": scheme, "step": flow.step if math.isfinite(flow.step) else None, "threads": flow.threads}


@Parameter(name="*", group=WRITTEN)
@dataclass(frozen=True, kw_only=True)
class Output:
    """What is written."""

    out: Path | None = None
    """Path without ending; .npz and .png are added, and a number where they exist. [fastaff-poincare, fastaff-frequency-map]"""
    force: bool = False
    """Replace existing files instead of numbering the new ones."""
    no_figure: bool = False
    """Write the data only."""

    def stem(self, default: str) -> Path:
        """Return the path without ending under which nothing exists yet."""
        from .files import free_stem

        stem = self.out or Path(default)
        stem = stem.with_suffix("") if stem.suffix in (".npz", ".png") else stem
        if not stem.parent.is_dir():
            raise Wrong(f"--out {stem}: the folder {stem.parent} does not exist")
        return stem if self.force else free_stem(stem, (".npz", ".png"))

    def check(self) -> None:
        """Refuse a figure where matplotlib is missing."""
        if not self.no_figure and importlib.util.find_spec("matplotlib") is None:
            raise ModuleNotFoundError("matplotlib", name="matplotlib")

    def save(self, stem: Path, result: Any, facts: dict[str, Any]) -> Path:
        """Write the data with all that is known of them."""
        from .files import save

        own = {entry.name for entry in fields(result)}
        facts = {name: value for name, value in facts.items() if name not in own or name in ("section", "time")}
        return save(stem.with_name(stem.name + ".npz"), result, force=self.force, **facts)


def named(option: str, given: str, names: tuple[str, ...]) -> str:
    """Return the name given if it is one of the names; refuse it with the nearest one otherwise."""
    if given in names:
        return given
    near = difflib.get_close_matches(given, names, n=1, cutoff=0.5)
    raise Wrong(f"{option} must be one of {', '.join(names)}, got {given!r}." + (f" Did you mean {near[0]}?" if near else ""))


def _range(option: str, text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    low, colon, high = text.partition(":")
    try:
        ends = (float(low), float(high))
        if not (colon and math.isfinite(ends[0]) and math.isfinite(ends[1]) and ends[0] < ends[1]):
            raise ValueError
    except ValueError:
        raise Wrong(f"{option} must be LOW:HIGH with LOW < HIGH, for example 0.1:1.2, got {text!r}") from None
    return ends


def _cells(text: str) -> tuple[int, int]:
    first, cross, second = text.lower().partition("x")
    try:
        n1, n2 = int(first), int(second if cross else first)
        if n1 < 1 or n2 < 1:
            raise ValueError
    except ValueError:
        raise Wrong(f"--grid must be N1xN2 with whole numbers of at least 1, for example 40x40, got {text!r}") from None
    return n1, n2


def return_times(body: Any, z0: np.ndarray, section: Any, choices: dict[str, Any]) -> np.ndarray:
    """Return the mean time between crossings of each of a few orbits, NaN where there are none."""
    from .engine import natural_rate
    from .poincare import poincare_map

    few = np.ascontiguousarray(z0[:, :: max(1, z0.shape[1] // 64)])
    found = poincare_map(body, few, section=section, crossings=16, max_time=300.0 / natural_rate(body, few), **choices)
    return np.array([t[n - 1] / n if n else np.nan for t, n in zip(found.times, found.counts)])


def enough_time(pace: np.ndarray, section: Any, crossings: int) -> float:
    """Return four times what the median orbit needs for the crossings."""
    if np.isnan(pace).all():
        raise Wrong(f"no orbit of a trial crosses {section!r}; give --max-time, or another section or direction")
    return float(4.0 * np.nanmedian(pace) * (crossings + 4))


def stated(body, surface, section, starts, choices, z0, fixed) -> dict[str, Any]:
    """Return what a file says of its computation."""
    return {
        "model": body, "energy": surface.energy, "p_eta": surface.p_eta, "p_gamma": surface.p_gamma, "section": section,
        "seed": starts.seed if starts.orbits is not None else None, "grid": starts.grid, "orbits": z0.shape[1],
        "range1": starts.range1, "range2": starts.range2, "rtol": 1e-12, "atol": 1e-12, "energy_tolerance": 1e-6,
        "threads": choices["threads"], "z0": z0, **{name: value for name, value in fixed.items() if name != "section"},
    }  # fmt: skip


def in_words(section: Any) -> str:
    """Name a section in a caption."""
    turn = {1: "rising", -1: "falling", 0: "both ways"}[section.direction]
    name = type(section).__name__
    if name == "Linear":
        return f"{'x' if section.normal[0] else 'y'} = {section.offset:g}, {turn}"
    if name.endswith("Turning"):
        return rf"$p_\{name.removesuffix('Turning').lower()}$ = 0, {turn}"
    left = {"AlphaEquals": r"$\alpha$", "BetaEquals": r"$\beta$", "AreaEquals": "$D_1D_2$"}[name]
    return f"{left} = {section.constant:g}, {turn}"


def units(inner: Any, body: Any) -> str:
    """Say in a caption what is 1."""
    stiffness = inner._fields[0]
    if inner is body or inner[0] != 1 or body.mu != 1:
        return "units: those of the parameters"
    return rf"units: {stiffness} = $\mu$ = 1"


def figure_of(panels: int = 1) -> tuple[Any, Any]:
    """Return a figure and its panels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6 if panels == 1 else 12.6, 6.2), dpi=200, layout="constrained")
    return figure, figure.subplots(1, panels)


def finish(figure, ax, body, surface, section, text, stem, facts) -> None:
    """Put title and caption on the figure and write it, with the parameters inside the PNG; name the file."""
    from .files import plain, provenance

    inner = getattr(body, "potential", body)
    values = ", ".join(f"{name} = {value:g}" for name, value in zip(inner._fields, inner))
    where = f"E = {surface.energy:g}"
    if inner is not body:
        values += f", mu = {body.mu:g}"
        where += rf", $p_\eta$ = {surface.p_eta:g}, $p_\gamma$ = {surface.p_gamma:g}"
    figure.suptitle(f"{type(inner).__name__} ({values}), {where}", fontsize=11)
    figure.supxlabel(f"section {in_words(section)}; {text}; {units(inner, body)}", fontsize=7.5, color="0.3")
    kept = {name: plain(value) for name, value in facts.items() if not isinstance(value, np.ndarray)}
    path = stem.with_name(stem.name + ".png")
    figure.savefig(path, metadata={"Title": "fastaff", "Description": json.dumps({**provenance(), **kept})})
    print(path)
