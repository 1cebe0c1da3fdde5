"""`explore`: a page that shows sections of a system; a click on one launches an orbit."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.names import named
from ..core.numbers import StrPath, kind_of, numbers, positive, real, shown
from ..core.placing import write_atomically
from ..results.progress import says_progress
from ..results.provenance import provenance
from ..results.result import Result
from ..runs.options import cheapest
from ..runs.requirements import check_given, checked_system, suited_scheme
from ..runs.schemes.catalogue import Splitting, scheme_named
from ..runs.schemes.collocation import GAUSS16, Collocation
from ..sections.energy_grid import EnergyGrid
from ..sections.energy_shell import NotReached, fitting_energy
from ..sections.named_axes import checked_names
from ..sections.section_edge import edge
from ..systems.formulas.section_text import section_forms, section_named
from ..systems.models.contracts import Dynamics, Section
from ..systems.models.mechanics import System
from ..systems.models.sections import Stroboscopic
from .background import MapOnGrid, background_record, found
from .page import page
from .parameters import parameter_values
from .setup import (
    frames,
    named_body,
    named_systems,
    page_schemes,
    plane_record,
    planes,
    scheme_record,
    section_record,
    system_record,
)

ACCURACY = 1e-10
"""Error of the first crossings where none is asked for."""

TRIED = 3000
"""Steps of a trial orbit, as in trial_section.js."""

LEAST_CROSSED = 8
"""Crossings of a trial orbit that a section needs."""

BESIDE_ZERO = 0.1
"""Distance of a variable's middle value from 0, in parts of its range, up to which its section is at 0."""


@says_progress
def explore(
    model: Dynamics | None = None,
    *,
    energy: float | None = None,
    section: Section | str | None = None,
    p_eta: float = 0.0,
    p_gamma: float = 0.0,
    accuracy: float = ACCURACY,
    scheme: Splitting | Collocation | str | None = None,
    background: StrPath | tuple[Result, EnergyGrid] | None = None,
    points: ArrayLike | None = None,
    fixed: Mapping[str, float] | None = None,
    out: StrPath | None = None,
) -> Path:
    """Write the explorer of a system, one HTML file that needs no server, network or Python.

    Parameters
    ----------
    model : model, optional
        Body with a doubly isotropic potential, or system of two degrees of freedom, with H(q, p) and rotating frames.
        Driven systems of one coordinate, maps, also of one variable, and ODE systems of three or more variables are
        supported too. Default: the neo-Hookean body. The page has all named models anyway.
    energy : float, optional
        Energy of the orbits. None for a map, an ODE or a driven system.
    section : Section or str, optional
        Surface of section, for example ``"alpha-turning"``, ``"beta=0.4"``, ``"x=0"``, or ``"t=0"`` for a driven
        system. Default: alpha-turning, the first coordinate = 0 whose section the energy reaches, a section of an ODE
        that a trial orbit crosses, or t = 0.
    p_eta, p_gamma : float, default 0
        Angular momenta of the planes of a body.
    accuracy : float, default 1e-10
        Relative error of the first crossings.
    scheme : Scheme or str, optional
        Splitting or collocation, or its name. Default: the splitting with the fewest force evaluations. H(q, p),
        rotating frames and ODE systems use ``"GAUSS16"`` or ``"GAUSS8"``.
    background : path_like or tuple, optional
        Chaos or frequency map over a grid of the section: a file, or a pair of result and `EnergyGrid`.
    points : array_like, shape (2, orbits), optional
        Section coordinates of the first orbits of the page, [] for none. Default: twelve over the region, one for a
        map of one variable, or none with a background.
    fixed : dict of float, optional
        For a map or an ODE, initial values of the other rows by name. Default: 0.
    out : path_like, optional
        Path of the file. Default: fastaff-explorer.html, with a number if it exists.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError
        If an argument has the wrong type, or the methods of the model cannot be printed as JavaScript. The message
        names the construct.
    ValueError
        If an argument has a wrong value.
    OSError
        If the file cannot be written.

    Notes
    -----
    - Energy, section, accuracy and scheme are not supported for maps and driven systems: a point of the plane is an
      orbit of iterates, or of states once per period. Periodic coordinates of a map are in [-T/2, T/2).
    - A map of one variable has the plane of x and its image, with a cobweb and a bifurcation diagram.
    - The coordinate of a driven system is periodic if the force has the period 2 pi or the model declares it.
    - Orbits of H(q, p) start at the outermost root of a momentum with a velocity of the sign of the direction.
    - Accuracy: first crossings agree with `poincare_map` to `accuracy`. Later ones of chaotic orbits differ with the
      elementary functions of the browser.
    - The page executes nothing that is not in it.

    References
    ----------
    Henon 1982, Physica D 5, 412 (sections); the indicators and averages name theirs.

    Examples
    --------
    >>> fa.explore(fa.HenonHeiles(), energy=0.1, section="x=0", out="explorer.html").name
    'explorer.html'
    """
    given: dict[str, Any] = {"energy": energy, "section": section, "p_eta": p_eta, "p_gamma": p_gamma}
    given |= {"accuracy": accuracy, "scheme": scheme, "background": background, "points": points, "fixed": fixed}
    setup, _ = setup_of(model, **given)
    path = _path(out)
    text = page(setup)
    return write_atomically(
        path.with_suffix(""),
        path.suffix,
        lambda name: name.write_text(text, encoding="utf-8"),
        overwrite=out is not None,
    )


def setup_of(
    model: Any = None,
    *,
    energy: float | None = None,
    section: Any = None,
    p_eta: float = 0.0,
    p_gamma: float = 0.0,
    accuracy: float = ACCURACY,
    scheme: Any = None,
    background: Any = None,
    points: Any = None,
    fixed: Any = None,
) -> tuple[dict[str, Any], Any]:
    """Return the set-up of a page, arguments as of `explore`, and the model that it begins with."""
    under = None if background is None else found(background)
    if under is not None and under.plan is not None and model is None:
        model = under.plan.model
        own = under.job.energy_surface  # type: ignore[union-attr]
        energy = own.energy if energy is None else energy
        p_eta = p_eta or own.p_eta
        p_gamma = p_gamma or own.p_gamma
        section = under.plan.section if section is None else section
    chosen = named_body("neo-hookean") if model is None else model
    system = checked_system(chosen, needs="a page")
    accuracy = positive("accuracy", accuracy)
    p_eta = real("p_eta", p_eta)
    p_gamma = real("p_gamma", p_gamma)
    if not system.isotropic and (p_eta or p_gamma):
        raise ValueError(
            f"p_eta and p_gamma must be 0 for {kind_of(chosen)}, got {p_eta} and {p_gamma}. Only a Body has them."
        )
    systems = named_systems()
    schemes = page_schemes()
    usual = _usual(chosen, systems)
    start: dict[str, Any] = {"p_eta": p_eta, "p_gamma": p_gamma}
    if system.iterated:
        given = {"energy": energy, "section": section, "scheme": scheme}
        given["accuracy"] = None if accuracy == ACCURACY else accuracy
        check_given(system, "a time", "a map is iterated as it is", **given)
        start |= plane_record(system, fixed, None if under is None else under.grid)
    elif system.driven:
        start |= _strobed(system, section, energy=energy, fixed=fixed, background=background)
    elif not system.canonical:
        start |= _flowing(system, section, fixed, energy=energy, background=background)
    else:
        if fixed is not None:
            raise ValueError(
                f"fixed is supported for maps and ODE systems only, got {shown(fixed)}. Use section and energy here."
            )
        start["energy"] = _energy(energy, usual, system, p_eta, p_gamma)
    if usual is None:
        systems.insert(0, system_record(system, "own", _title(system), _formula(system), start))
    elif energy is None and start["energy"] is not None:
        start.update({name: usual[name] for name in ("p_eta", "p_gamma") if not start[name]})
    start["system"] = "own" if usual is None else usual["name"]
    start["parameters"] = parameter_values(chosen)
    taken = cheapest(accuracy, True) if system.iterated else _scheme(scheme, accuracy, system)
    if start["energy"] is not None:
        cut = _section(section, system, start)
        start |= section_record(cut, system)
    start |= {"accuracy": accuracy, "scheme": taken.name}
    start["points"] = _points([] if points is None and under is not None else points)
    if start["scheme"] not in [entry["name"] for entry in schemes]:
        schemes.insert(0, scheme_record(taken))
    setup = {
        "version": provenance()["fastaff"],
        "systems": systems,
        "schemes": schemes,
        "frames": frames(),
        "start": start,
        "background": None if under is None else background_record(under, _of(under, start)),
    }
    return setup, chosen


def _strobed(system: System, section: Any, **given: Any) -> dict[str, Any]:
    """Return the first view of the page of a driven system: its states once a period, at a phase."""
    check_given(system, "a page of orbits", **given)
    cut = section_named(section, system) if isinstance(section, str) else Stroboscopic() if section is None else section
    if not isinstance(cut, Stroboscopic):
        raise TypeError(f"section must be Stroboscopic(phase) or 't=c' for a driven system, got {shown(section)}")
    kept: dict[str, Any] = {
        "energy": None,
        "section": planes(system)[0],
        "constant": None,
        "direction": 1,
        "others": {},
    }
    return {**kept, "phase": float(system.model.phase(real("section.phase", cut.phase)))}


def _reached(model: Any, section: Any, start: dict[str, Any]) -> None:
    """Refuse an energy that allows no point of the section; one that lets orbits escape is allowed."""
    try:
        edge(model, section, energy=start["energy"], p_eta=start["p_eta"], p_gamma=start["p_gamma"])
    except NotReached:
        raise
    except ValueError as problem:
        if "bound" not in str(problem):
            raise


def _of(under: MapOnGrid, start: dict[str, Any]) -> dict[str, Any]:
    """Return the system and surface of a map: those of its job, else those of the page."""
    if start["energy"] is None:
        kept = {name: start[name] for name in ("system", "section", "others")}
        return kept | {"parameters": parameter_values(under.plan.model) if under.plan else start["parameters"]}
    kept = {name: start[name] for name in ("system", "energy", "section", "constant", "p_eta", "p_gamma")}
    kept |= {"direction": start["direction"], "parameters": start["parameters"], "energy": float(under.grid.energy)}
    if under.plan is not None and under.job is not None:
        surface = under.job.energy_surface
        kept |= section_record(under.plan.section, under.plan.system)
        kept |= {"p_eta": surface.p_eta, "p_gamma": surface.p_gamma, "parameters": parameter_values(under.plan.model)}
    return kept


def _usual(model: Any, systems: list[dict[str, Any]]) -> dict[str, Any] | None:
    """Return the record of the named system of the body's kind, whatever its parameters."""
    for record in systems:
        named = named_body(record["name"])
        inner = getattr(named, "potential", named)
        own = getattr(model, "potential", model)
        if type(named) is type(model) and type(inner) is type(own):
            return record
    return None


def _energy(energy: Any, usual: dict[str, Any] | None, system: System, p_eta: float, p_gamma: float) -> float:
    if energy is not None:
        return real("energy", energy)
    if usual is None:
        fit = fitting_energy(system, p_eta, p_gamma)
        such = f", such as energy={fit:.2g}" if np.isfinite(fit) else ""
        raise ValueError(f"energy must be given for a model of your own: the energy of every orbit{such}")
    return float(usual["energy"])


def _section(section: Any, system: System, start: dict[str, Any]) -> Any:
    """Return a section given as a value or a text; by default the first of the system's that the energy reaches."""
    if section is not None:
        cut = section_named(section, system) if isinstance(section, str) else section
        _reached(system.model, cut, start)
        return cut
    refused = None
    for form in section_forms(system):
        cut = section_named(form.replace("=c", "=0"), system)
        try:
            _reached(system.model, cut, start)
        except NotReached as problem:
            refused = refused or problem
            continue
        return cut
    raise refused or AssertionError


def _flowing(system: System, section: Any, fixed: Any, **given: Any) -> dict[str, Any]:
    """Return the first view of the page of dz/dt = f(z): its section, and the starts of variables outside the plane."""
    check_given(system, "a page of orbits", **given)
    names = system.names
    met = _met(system)
    trial = _trial_section(system, met) if section is None else section
    cut = section_named(trial, system) if isinstance(trial, str) else trial
    starts = checked_names("fixed", () if fixed is None else fixed, "numbers")
    others = {named("fixed", name, names): real(f"fixed[{name!r}]", value) for name, value in starts.items()}
    record = {"energy": None, **section_record(cut, system)}  # which refuses sections that the page does not draw
    height = np.array([cut.value(*z) for z in met.T]) * (cut.direction or 1)
    crossed = _upward(height)
    usual = np.zeros((len(names), 1))
    if crossed.size:  # on the line between the samples beside the section
        k = crossed[-1]
        share = height[k] / (height[k] - height[k + 1])
        usual = system.turned_back(met[:, [k]] + share * (met[:, [k + 1]] - met[:, [k]]))
    outside = [name for name in names if record["section"] != f"{name}=c"][2:]
    beside = {name: float(f"{usual[names.index(name), 0]:.2g}") for name in outside}
    return {**record, "others": dict.fromkeys(names, 0.0) | beside | others}


def _trial_section(system: System, met: np.ndarray) -> str:
    """Return the section that a trial orbit (rows, moments) crosses, as trial_section.js finds it.

    It is that of the first variable, from the last one on, whose middle value is crossed often enough. A middle value
    near 0 is taken as 0.
    """
    names = system.names
    for name, values in zip(names[::-1], met[::-1], strict=True):
        if not values.size:
            continue
        middle = float(np.sort(values)[values.size // 2])
        constant = float(f"{middle:.2g}") if abs(middle) > BESIDE_ZERO * np.ptp(values) else 0.0
        if _upward(values - constant).size >= LEAST_CROSSED:
            return f"{name}={constant!r}"
    return f"{names[-1]}=0"


def _upward(height: np.ndarray) -> np.ndarray:
    """Return the samples after which a signal (moments,) passes 0 upwards."""
    return np.flatnonzero((height[1:] > 0) & (height[:-1] <= 0))


def _met(system: System) -> np.ndarray:
    """Return states (rows, moments) of a trial orbit of dz/dt = f(z) once it is where it stays, none if it ends: by
    Runge and Kutta's steps, a tenth of the time in which the velocity turns.
    """
    rows = system.rows

    def slopes(z: np.ndarray) -> np.ndarray:
        return np.array(system.model.rates(*z), dtype=float)

    z = np.linspace(0.3, 0.7, rows)
    states = np.empty((rows, TRIED))
    with np.errstate(all="ignore"):
        for k in range(TRIED):
            f = slopes(z)
            turning = np.linalg.norm(np.array(system.model.tangent_rates(*z, *f), dtype=float))
            h = 0.1 * np.linalg.norm(f) / turning
            g = slopes(z + h / 2 * f)
            e = slopes(z + h / 2 * g)
            z = z + h / 6 * (f + 2 * g + 2 * e + slopes(z + h * e))
            if not np.isfinite(z).all():
                return np.empty((rows, 0))
            states[:, k] = z
    return states[:, TRIED // 2 :]


def _scheme(scheme: Any, accuracy: float, system: System) -> Splitting | Collocation:
    """Return the scheme: a splitting that suits the body, or a collocation if none does."""
    if system.frame or not system.newtonian:
        taken: Any
        if scheme is None:
            taken = GAUSS16
        elif isinstance(scheme, str):
            taken = scheme_named(scheme)
        else:
            taken = scheme
        if not isinstance(taken, Collocation):
            raise TypeError(f"scheme must be 'GAUSS8' or 'GAUSS16' to run such a system in a page, got {shown(taken)}")
        return taken
    if scheme is None:
        return cheapest(accuracy, system.quadratic)
    found = scheme_named(scheme) if isinstance(scheme, str) else scheme
    if not isinstance(found, Splitting):
        raise TypeError(f"scheme must be a splitting such as 'KAHAN_LI8' to run in a page, got {shown(found)}")
    return suited_scheme(found, system)


def _points(points: Any) -> list[list[float]] | None:
    """Return starting points; None where the page chooses."""
    if points is None or (isinstance(points, (list, tuple)) and not points):
        return None if points is None else []
    array = numbers("points", points).astype(np.float64)
    array = array[:, None] if array.ndim == 1 else array
    if array.ndim != 2 or array.shape[0] != 2 or not np.isfinite(array).all():
        raise ValueError(f"points must be finite section coordinates (2, orbits), got {array.shape}")
    return array.T.tolist()


def _title(system: System) -> str:
    if system.driven:
        return "Driven system"
    if system.iterated:
        return "Map of a formula" if hasattr(system.model, "formula") else type(system.model).__name__
    if not hasattr(getattr(system.model, "potential", system.model), "formula"):
        return type(system.model).__name__
    return "Body of a formula" if system.isotropic else "System of a formula"


def _formula(system: System) -> str:
    """Return the text that names a model: its formula, or its class."""
    inner = getattr(system.model, "potential", system.model)
    text = getattr(inner, "formula", None)
    if system.driven and isinstance(text, str):
        return f"{'H' if system.nonseparable else 'V'} = {text}, period {system.model.period:.6g}"
    if not system.canonical and isinstance(text, str):
        return text
    if system.iterated:
        said = (
            "; ".join(part.strip() for part in text.replace("\n", ";").split(";") if part.strip())
            if isinstance(text, str)
            else type(inner).__name__
        )
        return said if system.symplectic else f"{said} (not symplectic)"
    whole = system.nonseparable or bool(getattr(inner, "momenta", ()))
    where = ", turning frame" if system.frame and not whole else ""
    return f"{'H' if whole else 'V'} = {text}{where}" if isinstance(text, str) else type(inner).__name__


def _path(out: Any) -> Path:
    """Return the path that is asked for."""
    if out is not None and not isinstance(out, (str, os.PathLike)):
        raise TypeError(f"out must be the path of a file, got {shown(out)} ({type(out).__name__})")
    if out is None:
        return Path("fastaff-explorer.html")
    path = Path(out)
    path = path if path.suffix.lower() in (".html", ".htm") else path.with_name(path.name + ".html")
    if not path.parent.is_dir():
        raise ValueError(f"out {path}: the folder {path.parent} does not exist")
    return path
