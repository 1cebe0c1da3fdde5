"""The options of the command line: what they mean, how they are checked, what files and captions say of them."""

from __future__ import annotations

import difflib
import importlib.util
import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ..models.contracts import isotropic

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


HELP = """Poincaré sections, frequency maps and chaos maps of planar affinely-rigid bodies.

Each command computes many orbits on all cores, draws a PNG and writes an .npz file with the numbers, all
parameters, versions and the seed (read it with `fastaff.files.load`, or `contents`). Ctrl-C stops within a second and
keeps what is finished. Exit codes: 0, 2 for wrong input, 130 after Ctrl-C.

Start with one of

- `fastaff demo`
- `fastaff poincare --energy 1.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff poincare --model henon-heiles --energy 0.125 --orbits 200`
- `fastaff frequency-map --model hyperelastic --energy 3.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff chaos-map --energy 1.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff chaos-map --p-eta 0.3 --p-gamma 0.2 --scan energy=0.5:3:11`
- `fastaff spectrum --model hyperelastic`
"""
WHAT, WHERE, STARTS, HOW, WRITTEN = (
    Group(name, sort_key=k)
    for k, name in enumerate(("Body", "Energy surface and section", "Starting points", "Computation", "Output"))
)


@Parameter(name="*", group=WHAT)
@dataclass(frozen=True, kw_only=True)
class Model:
    """The body."""

    model: str | None = None
    """harmonic, anharmonic, hyperelastic (parameter C), heavy-top (C, A), neo-hookean (G, K), henon-heiles (lam).
    [neo-hookean]
    """
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
    formula: str | None = None
    """Potential energy of a body of your own, such as `C/2*(D1**2+D2**2) + C/(D1*D2)`, instead of a model."""
    hamiltonian: str | None = None
    """Potential energy of a system p^2/2 + V of your own, such as `(x**2+y**2)/2 + x**2*y - y**3/3`."""
    coordinates: str | None = None
    """Coordinates of --hamiltonian. ["x y"]"""
    parameter: list[str] | None = None
    """NAME=VALUE of a letter in the formula; once for each."""
    domain: str | None = None
    """Formula that is positive where the potential lives. [from logarithms, roots and poles]"""
    mu: float = 1.0
    """Inertia of a body. [1]"""

    def build(self) -> Any:
        """Return the model, refusing parameters that it does not have."""
        import fastaff

        given = {name: getattr(self, name) for name in ("C", "A", "G", "K", "lam") if getattr(self, name) is not None}
        if self.formula is not None or self.hamiltonian is not None:
            return self._own(given)
        for name in ("coordinates", "parameter", "domain"):
            if getattr(self, name) is not None:
                raise Wrong(f"--{name} belongs to --formula or --hamiltonian")
        key = named("--model", (self.model or "neo-hookean").lower().replace("_", "-"), tuple(MODELS))
        kind, names = MODELS[key]
        for name in given:
            if name not in names:
                raise Wrong(f"--{name} is not a parameter of {key}, which has {', '.join('--' + n for n in names)}")
        value = getattr(fastaff, kind)(**given)
        return value if key == "henon-heiles" else fastaff.Body(value, self.mu)

    def _own(self, given: dict[str, float]) -> Any:
        """Return the model that a formula describes."""
        import fastaff

        if given:
            name = next(iter(given))
            raise Wrong(f"--{name} belongs to a --model; a formula takes --parameter {name}={given[name]:g}")
        if self.model is not None or (self.formula is not None and self.hamiltonian is not None):
            raise Wrong("give one of --model, --formula and --hamiltonian")
        values: dict[str, float] = {}
        for name, value in map(_parameter, self.parameter or ()):
            if name in values:
                raise Wrong(f"--parameter {name} is given twice")
            if name in ("mu", "domain", "coordinates", "masses"):
                raise Wrong(
                    f"--parameter {name}=...: {name} is an option of its own, --{name}, or has a meaning: choose "
                    "another letter"
                )
            values[name] = value
        if self.formula is not None and self.coordinates is not None:
            raise Wrong(
                "--coordinates belongs to --hamiltonian; a --formula is in D1, D2, alpha, beta, r, vartheta, ..."
            )
        if self.formula is None and self.mu != 1.0:
            raise Wrong("--mu belongs to bodies; a --hamiltonian has the masses 1: rescale the coordinates")
        maker: Any = getattr(fastaff, "formula" if self.formula is not None else "hamiltonian", None)
        if maker is None:
            raise Wrong("this version of fastaff has no formulas")
        if self.formula is None:
            return maker(self.hamiltonian, coordinates=self.coordinates or "x y", domain=self.domain, **values)
        return maker(self.formula, mu=self.mu, domain=self.domain, **values)


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
    """alpha-turning (p_alpha = 0), beta-turning, alpha=c, beta=c, area=c (D1 D2 = c); x=c or y=c, or a coordinate of
    --hamiltonian, with c a number. [alpha-turning; x=0]"""
    direction: str = "+1"
    """Crossings where the section function increases (+1), decreases (-1) or both (0). [+1]"""

    def build(self, body: Any) -> Any:
        """Return the section."""
        import fastaff

        if self.energy is None:
            raise Wrong("--energy is required: the energy of every orbit, for example --energy 1.5")
        plane = not isotropic(body)
        if plane and body.degrees_of_freedom != 2:
            raise Wrong(
                "sections are those of a body with a potential of alpha and beta (or D1 and D2) alone, or of a system "
                "of two "
                f"coordinates; this one has the {body.degrees_of_freedom} coordinates {', '.join(body.coordinates)}: "
                "use fastaff.poincare_map or fastaff.chaos_map from Python"
            )
        planes = tuple(f"{name}=c" for name in body.coordinates) if plane else ()
        text = self.section or (f"{body.coordinates[0]}=0" if plane else "alpha-turning")
        if self.direction.lstrip("+") not in ("1", "-1", "0"):
            raise Wrong(f"--direction must be +1, -1 or 0, got {self.direction}")
        direction = int(self.direction)
        name, equals, constant = (text if plane else text.lower()).partition("=")
        form = named("--section", name + "=c" if equals else name, (*planes, *(k for k in SECTIONS if k not in planes)))
        if equals:
            try:
                value = float(constant)
            except ValueError:
                raise Wrong(f"--section {name}=c needs a number for c, got {constant!r}") from None
        if plane != (form in planes) or (not plane and form not in SECTIONS[:5]):
            raise Wrong(
                f"--section {text} does not suit {type(body).__name__}; it takes {', '.join(planes or SECTIONS[:5])}"
            )
        if plane:
            normal = (1.0, 0.0, 0.0, 0.0) if form == planes[0] else (0.0, 1.0, 0.0, 0.0)
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
    """Cells N1xN2 over the section's coordinate and its momentum; cells beyond the energy are left out. [20x20, 40x40
    or 60x60]
    """
    orbits: int | None = None
    """Random starts, uniform over the accessible part of the section, instead of a grid."""
    seed: int = 0
    """Seed of the random starts. [0]"""
    range1: str | None = None
    """Range LOW:HIGH of the section's coordinate. [all that the energy allows]"""
    range2: str | None = None
    """Range LOW:HIGH of its momentum. [all that the energy allows]"""

    def build(self, body: Any, section: Any, surface: Surface, default: str) -> tuple[Any, Any, Any]:
        """Return the Grid of starts or the random Sample, the edge of the section, and z0."""
        import fastaff

        from ..analysis.sections import energy_sample

        if self.grid is not None and self.orbits is not None:
            raise Wrong("give --grid or --orbits, not both")
        if self.orbits is not None and self.orbits < 1:
            raise Wrong(f"--orbits must be at least 1, got {self.orbits}")
        ranges = self.ranges()
        where: dict[str, Any] = {"energy": surface.energy, "p_eta": surface.p_eta, "p_gamma": surface.p_gamma}
        edge = None
        try:
            edge = energy_sample.edge(body, section, **where)
            ranges = [given or found for given, found in zip(ranges, edge.axes)]
        except ValueError as problem:
            if None in ranges:
                raise Wrong(f"{problem}; or give --range1 and --range2") from None
        if self.orbits is not None:
            narrowed = None if not any(self.ranges()) else ranges
            drawn = fastaff.energy_sample(
                body, section=section, orbits=self.orbits, seed=self.seed, axes=narrowed, **where
            )
            return drawn, edge, drawn.z0
        # Cell centres: the ends of the range are the edge itself.
        axes = [
            low + (high - low) * (np.arange(n) + 0.5) / n
            for (low, high), n in zip(ranges, _cells(self.grid or default))
        ]
        grid = fastaff.energy_grid(body, section=section, axes=axes, **where)
        return grid, edge, grid.z0

    def ranges(self) -> list[Any]:
        """Return the ranges given, None for those not given."""
        return [_range(name, text) for name, text in (("--range1", self.range1), ("--range2", self.range2))]


@Parameter(name="*", group=HOW)
@dataclass(frozen=True, kw_only=True)
class Run:
    """How to integrate."""

    scheme: str | None = None
    """LEAPFROG, YOSHIDA4, BLANES_MOAN6, BLANES_CASAS_ESCORIHUELA8, KAHAN_LI8, SOFRONIOU_SPALETTA8,
    SOFRONIOU_SPALETTA10, RK4, DOP853 and VERNER9 (both adaptive). [the cheapest for the accuracy, KAHAN_LI8 with a
    step]
    """
    step: float | None = None
    """Fixed step. [chosen for each orbit by a short trial]"""
    threads: int | None = None
    """Threads. [all cores]"""

    def scheme_value(self) -> Any:
        """Return the scheme, None where it is left open."""
        from ..schemes.catalogue import scheme_named

        return None if self.scheme is None else scheme_named(self.scheme.replace("-", "_"))

    def build(self, body: Any, z0: np.ndarray) -> dict[str, Any]:
        """Return the options of the library's functions."""
        return {"scheme": self.scheme_value(), "step": self.step, "threads": self.threads}


@Parameter(name="*", group=WRITTEN)
@dataclass(frozen=True, kw_only=True)
class Output:
    """What is written."""

    out: Path | None = None
    """Path without ending; .npz and .png are added, and a number where they exist. [fastaff-poincare,
    fastaff-frequency-map, ...]
    """
    force: bool = False
    """Replace existing files instead of numbering the new ones."""
    no_figure: bool = False
    """Write the data only."""

    def stem(self, default: str) -> Path:
        """Return the path without ending under which nothing exists yet."""
        from ..files import free_stem

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
        from ..files import save

        own = {entry.name for entry in fields(result)}
        facts = {name: value for name, value in facts.items() if name not in own or name in ("section", "time")}
        return save(stem.with_name(stem.name + ".npz"), result, force=self.force, **facts)


def named(option: str, given: str, names: tuple[str, ...]) -> str:
    """Return the name given if it is one of the names; refuse it with the nearest one otherwise."""
    if given in names:
        return given
    near = difflib.get_close_matches(given, names, n=1, cutoff=0.5)
    raise Wrong(
        f"{option} must be one of {', '.join(names)}, got {given!r}." + (f" Did you mean {near[0]}?" if near else "")
    )


def _parameter(text: str) -> tuple[str, float]:
    """Return name and value of NAME=VALUE."""
    name, equals, value = text.partition("=")
    try:
        if not (equals and name.strip()):
            raise ValueError
        return name.strip(), float(value)
    except ValueError:
        raise Wrong(f"--parameter must be NAME=VALUE with a number, for example C=1.5, got {text!r}") from None


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
    from ..analysis.sections.poincare_map import poincare_map
    from ..flows.motion import typical_rate

    few = np.ascontiguousarray(z0[:, :: max(1, z0.shape[1] // 64)])
    found = poincare_map(body, few, section=section, crossings=16, max_time=300.0 / typical_rate(body, few), **choices)
    return np.array([t[n - 1] / n if n else np.nan for t, n in zip(found.times.T, found.counts)])


def enough_time(pace: np.ndarray, section: Any, crossings: int) -> float:
    """Return four times what the median orbit needs for the crossings."""
    if np.isnan(pace).all():
        raise Wrong(f"no orbit of a trial crosses {section!r}; give --max-time, or another section or direction")
    return float(4.0 * np.nanmedian(pace) * (crossings + 4))
