"""The messages of the explorer's page answered by the package itself, for the notebook widget."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..chaos.chaos_map import chaos_map
from ..chaos.indicators import MEGNO, Lyapunov
from ..core.classification import Classification
from ..core.status import Status
from ..frequencies.frequency_map import frequency_map
from ..runs.coordinates import chart_row
from ..runs.integrate import integrate
from ..runs.requirements import checked_model, current_system
from ..runs.scales import natural_rates
from ..runs.schemes.catalogue import scheme_named
from ..sections.energy_shell import EnergyShell
from ..sections.poincare_map import poincare_map
from ..sections.section_edge import edge
from ..sections.section_points import lift
from ..systems.formulas.formula import affine_body, hamiltonian
from ..systems.formulas.grammar import TIME, UnknownName
from ..systems.formulas.iterated_map import iterated_map, untried
from ..systems.formulas.section_text import section_named
from ..systems.models.mechanics import System
from .curve import curve_rotation
from .parameters import parameter_values, with_parameters
from .plane import Plane, map_reading, survived

PERIODS = 20.0
"""Natural periods for each crossing after which an orbit has no more."""

CALM_PERIODS = 200.0
"""Natural periods before an orbit is called regular, as in engine.js."""

MARGIN = 0.03
"""Margin of the page's frame on each side, in parts of the range of the accessible region."""

LETTERS = {"alpha": "α", "beta": "β"}
STATUS = {
    Status.OK: "done",
    Status.ESCAPED: "escaped",
    Status.NONFINITE: "escaped",
    Status.OUT_OF_DOMAIN: "out of domain",
    Status.LOST: "lost",
}
INTERRUPTED = "no more crossings"


class LaunchedOrbit(NamedTuple):
    """An orbit: its state at the start, its time at the last crossing, and the number of crossings sent so far."""

    z0: np.ndarray
    point: tuple[float, float]
    sent: int
    time: float


class Answers:
    """Answers messages: `post` gets each as a dictionary, with NumPy arrays where the page has typed ones.

    systems: models by the name that the page has for them. Every launch is a `poincare_map`, each reading a
    `curve_rotation`, a `chaos_map` and a `frequency_map`; wrong input is answered, never raised.
    """

    def __init__(self, systems: dict[str, Any], post: Callable[[dict[str, Any]], None]):
        self.systems = systems
        self.post = post
        self.system: System = current_system(None)  # until the page names one
        self.section: Any = None
        self.where: dict[str, float] = {}
        self.orbits: dict[int, LaunchedOrbit] = {}
        self.scheme = ""
        self.accuracy = 1e-10

    @property
    def model(self) -> Any:
        """The model."""
        return self.system.model

    def receive(self, message: dict[str, Any]) -> None:
        """Answer one message."""
        kind = message.get("type")
        try:
            answer = getattr(self, f"on_{kind}", None)
            if answer is not None:
                answer(message)
        except (ValueError, TypeError, KeyError, ImportError) as problem:
            what = {"system": "formula", "parse": "formula", "surface": "energy", "parameters": "parameter"}.get(
                str(kind), "orbit"
            )
            text = str(problem).replace("text:", "formula:", 1)
            self.post({"type": "wrong", "what": what, "message": text, "orbit": message.get("orbit")})

    def on_system(self, message: dict[str, Any]) -> None:
        """Take a model: one of the systems by its name, or a formula."""
        given = message["system"]
        parameters = {name: float(value) for name, value in (given.get("parameters") or {}).items()}
        if given.get("code") is None and "formula" in given:
            self.system = current_system(_typed(given, parameters))
        else:
            self.system = current_system(with_parameters(self.systems[given["name"]], parameters))
        self.scheme, self.accuracy = message.get("scheme") or "", float(message.get("accuracy") or 1e-10)
        self.orbits.clear()
        self.section = None
        names = list(self.system.names)
        self.post({"type": "ready", "names": names, "parameters": parameter_values(self.model)})

    def on_parse(self, message: dict[str, Any]) -> None:
        """Answer whether a text is a formula, with its parameters."""
        names: list[str] = []
        said = None
        try:
            for _ in range(64):
                try:
                    _typed(message, dict.fromkeys(names, 1.0), known=False)
                    break
                except UnknownName as problem:
                    driven = problem.name == TIME and message["kind"] != "map"
                    if driven or problem.name in names:  # it means something else to the package
                        raise
                    names.append(problem.name)
        except (ValueError, TypeError, ImportError) as problem:
            said = str(problem).replace("text:", "formula:", 1)
        self.post({**message, "type": "parsed", "names": names, "message": said})

    def on_parameters(self, message: dict[str, Any]) -> None:
        """Take other values of the parameters."""
        values = {k: float(v) for k, v in message["parameters"].items()}
        self.system = current_system(with_parameters(self.model, values))
        self.orbits.clear()
        self.section = None

    def on_surface(self, message: dict[str, Any]) -> None:
        """Take a section of an energy surface; answer with the region that it allows."""
        system = self.system
        if system.iterated:
            self.orbits.clear()
            self.section = None
            return self._show_plane(message)
        where: dict[str, Any] = {name: float(message.get(name) or 0.0) for name in ("energy", "p_eta", "p_gamma")}
        section = section_of(self.system, message["section"], message.get("constant"), int(message["direction"]))
        (u0, u1), (v0, v1) = edge(self.model, section, **where).axes
        width = int(message["width"])
        height = int(message["height"])
        du = MARGIN * (u1 - u0)
        dv = MARGIN * (v1 - v0)
        extent = [max(u0 - du, 0.0) if system.isotropic else u0 - du, u1 + du, v0 - dv, v1 + dv]
        u = extent[0] + (extent[1] - extent[0]) * (np.arange(width) + 0.5) / width
        v = extent[2] + (extent[3] - extent[2]) * (np.arange(height) + 0.5) / height
        first, second = (x.ravel() for x in np.meshgrid(u, v))
        _, allowed, names = lift(EnergyShell(self.system, section=section, **where), first, second)
        self.orbits.clear()  # if the energy is not reached, the old orbits stay with their section
        self.section = section
        self.where = where
        self.names = names
        self.post(
            {
                "type": "surface",
                "labels": [_label(name) for name in names],
                "axes": list(names),
                "extent": extent,
                "width": width,
                "height": height,
                "allowed": allowed.astype(np.uint8),
                "minimum": None,
                "escape": None,
                "section": message["section"],
                "constant": message.get("constant"),
                "energy": where["energy"],
            }
        )
        return None

    def _show_plane(self, message: dict[str, Any]) -> None:
        """Take a plane of a map."""
        plane = Plane.of(self.system, message["section"], message.get("others"))
        extent = plane.extent()
        width = int(message["width"])
        height = int(message["height"])
        u = extent[0] + (extent[1] - extent[0]) * (np.arange(width) + 0.5) / width
        v = extent[2] + (extent[3] - extent[2]) * (np.arange(height) + 0.5) / height
        _, allowed = plane.lift(*(x.ravel() for x in np.meshgrid(u, v)))
        u_name, v_name = plane.name.split(",")
        self.section = plane
        self.names = (u_name, v_name)
        names = [u_name, v_name]
        said = {"labels": names, "axes": names, "extent": extent, "width": width, "height": height}
        none = {"minimum": None, "escape": None, "constant": None, "energy": None}
        facts = {"section": plane.name, "periods": list(plane.periods), "open": bool(allowed.all())}
        self.post({"type": "surface", **said, **none, **facts, "allowed": allowed.astype(np.uint8)})

    def _lift(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return phase points over points of the section or plane, and a mask of those that exist."""
        if isinstance(self.section, Plane):
            return self.section.lift(u, v)
        z, found, _ = lift(EnergyShell(self.system, section=self.section, **self.where), u, v)
        return z, found

    def on_launch(self, message: dict[str, Any]) -> None:
        """Launch an orbit and follow it to its crossings."""
        if self.section is None:
            raise ValueError("there is no section yet")
        if message.get("z0") is not None:
            z0 = np.array(message["z0"], dtype=np.float64)
            point = tuple(map(float, message.get("point") or self._projected(z0[:, None])[:, 0]))
        else:
            point = tuple(map(float, message["point"]))
            z, found = self._lift(np.array(point[:1]), np.array(point[1:]))
            if not found[0]:
                u, v = (f"{_label(name)} = {value:.5g}" for name, value in zip(self.names, point))
                where = "in the domain of the map" if isinstance(self.section, Plane) else "on the energy surface"
                said = f"{u}, {v} is not {where}"
                self.post({"type": "refused", "orbit": message["orbit"], "point": list(point), "message": said})
                return
            z0 = z[:, 0]
            if isinstance(self.section, Plane):
                point = tuple(map(float, self.section.projected(z)[:, 0]))
        self.orbits[message["orbit"]] = LaunchedOrbit(z0, point, 0, 0.0)  # type: ignore[arg-type]
        self.post({"type": "launched", "orbit": message["orbit"], "point": list(point), "z0": z0})
        self._follow(message["orbit"], int(message.get("crossings") or 1000))

    def on_fill(self, message: dict[str, Any]) -> None:
        """Launch a grid of orbits."""
        u0, u1, v0, v1 = message["view"]
        columns = int(message["columns"])
        rows = int(message["rows"])
        number = int(message.get("first") or 0)
        u = u0 + (u1 - u0) * (np.arange(columns) + 0.5) / columns
        v = v0 + (v1 - v0) * (np.arange(rows) + 0.5) / rows
        first, second = (x.ravel() for x in np.meshgrid(u, v))
        _, found = self._lift(first, second)
        if isinstance(self.section, Plane):  # an angle's first period
            z, _ = self.section.lift(first, second)
            found &= (self.section.projected(z) == [first, second]).all(axis=0)
        for k in np.flatnonzero(found):
            point = [float(first[k]), float(second[k])]
            self.on_launch({"orbit": number, "point": point, "crossings": message.get("crossings") or 300})
            number += 1

    def on_more(self, message: dict[str, Any]) -> None:
        """Follow an orbit further."""
        self._follow(message["orbit"], self.orbits[message["orbit"]].sent + int(message["crossings"]))

    def on_forget(self, message: dict[str, Any]) -> None:
        """Forget an orbit, or all."""
        if message.get("orbit") is None:
            self.orbits.clear()
        else:
            self.orbits.pop(message["orbit"], None)

    def on_motion(self, message: dict[str, Any]) -> None:
        """Send states of an orbit at equal times."""
        if isinstance(self.section, Plane):
            raise ValueError("a map has no motion between its iterates")
        begin, end = float(message["from"]), float(message["to"])
        z = self.orbits[message["orbit"]].z0
        samples = max(2, min(int(message["samples"]), 20000))
        if begin > 0:
            z = integrate(self.model, z, time=begin, accuracy=self.accuracy).z[:, 0]
        run = integrate(self.model, z, time=end - begin, samples=samples - 1, accuracy=self.accuracy)
        states = np.concatenate([z[None], run.samples[:, :, 0]])
        if self.system.isotropic:
            a1, a2, b1, b2 = states[:, :4].T
            phi = np.array([a1 + b1, b2 - a2, a2 + b2, a1 - b1]).T / np.sqrt(2.0)
            states = np.concatenate([phi, states], axis=1)
        kept = {"orbit": message["orbit"], "from": begin, "to": end}
        self.post({"type": "motion", **kept, "rows": samples, "states": np.ascontiguousarray(states).ravel()})

    def _projected(self, z: np.ndarray) -> np.ndarray:
        """Return the section coordinates (2, ...) of states (2n, ...)."""
        if isinstance(self.section, Plane):
            return self.section.projected(z)
        system = self.system
        rows = dict(zip(system.row_names, system.turned_back(np.array(z))))
        found = [rows[name] if name in rows else chart_row(z, name) for name in self.names]
        return np.array(found)

    def _follow(self, number: int, crossings: int) -> None:
        """Find the crossings of an orbit, send the new ones and the readings of the orbit."""
        orbit = self.orbits[number]
        if isinstance(self.section, Plane):
            return self._iterate(number, orbit, self.section, crossings)
        rate = float(natural_rates(self.system, orbit.z0[:, None])[0])
        run = poincare_map(
            self.model,
            orbit.z0,
            section=self.section,
            crossings=crossings,
            max_time=PERIODS * crossings * 2 * np.pi / rate,
            accuracy=self.accuracy,
            scheme=scheme_named(self.scheme) if self.scheme else None,
        )
        count = int(run.counts[0])
        points = self._projected(run.points[:, :count, 0])
        times = run.times[:count, 0]
        new = slice(orbit.sent, count)
        sent = {"orbit": number, "first": orbit.sent, "points": np.ascontiguousarray(points[:, new].T).ravel()}
        self.post({"type": "points", **sent, "times": times[new].copy()})
        time = float(times[-1]) if count else 2 * np.pi / rate
        self.orbits[number] = orbit._replace(sent=count, time=time)
        status = STATUS.get(Status(int(run.status[0])), INTERRUPTED)
        reading = self._reading(orbit.z0, points, time)
        error = float(run.energy_error[0])
        facts = {"crossings": count, "time": time, "energy_error": error, "status": status}
        self.post({"type": "reading", "orbit": number, **facts, **reading})
        return None

    def _iterate(self, number: int, orbit: LaunchedOrbit, plane: Plane, count: int) -> None:
        """Find the iterates of an orbit, send the new ones and the readings of the orbit."""
        run = poincare_map(self.model, orbit.z0, crossings=count)
        chaos = chaos_map(self.model, orbit.z0, time=count, indicators=(MEGNO(), Lyapunov()))
        kept = survived(chaos)
        states = run.points[:, :kept, 0]
        new = slice(orbit.sent, kept)
        points = plane.projected(states)
        times = np.arange(1.0, kept + 1)
        sent = {"orbit": number, "first": orbit.sent, "points": np.ascontiguousarray(points[:, new].T).ravel()}
        self.post({"type": "points", **sent, "times": times[new].copy()})
        self.orbits[number] = orbit._replace(sent=kept, time=float(kept))
        status = STATUS.get(Status(int(chaos.status[0])), INTERRUPTED)
        classification = Classification(int(chaos.classification[0]))
        early = kept < 2 * np.pi * CALM_PERIODS and classification == Classification.REGULAR
        said = "undecided" if early or status != "done" else classification.name.lower()
        facts = {"crossings": kept, "time": float(kept), "energy_error": None, "status": status, "classification": said}
        megno, lyapunov = _finite([chaos.megno[0], chaos.lyapunov[0]])
        reading = map_reading(plane, orbit.z0, states, points)
        self.post({"type": "reading", "orbit": number, **facts, "megno": megno, "lyapunov": lyapunov, **reading})

    def _reading(self, z0: np.ndarray, points: np.ndarray, time: float) -> dict[str, Any]:
        """Return rotation number, indicators of chaos and frequencies of an orbit."""
        turning = curve_rotation(points) if points.shape[1] else None
        rotation = None if turning is None else turning.record()
        chaos = chaos_map(self.model, z0, time=time, indicators=(MEGNO(), Lyapunov()))
        found = frequency_map(self.model, z0, time=time)
        values = [*found.dominant[:, 0]]
        errors = [*found.dominant_error[:, 0]]
        names = list(found.names)
        if found.nu_eta is not None and found.nu_gamma is not None:
            names[2:] = ["eta", "gamma"]
            values[2:] = [found.nu_eta[0], found.nu_gamma[0]]
        lines = {"names": names, "values": _finite(values), "errors": _finite(errors)}
        classification = Classification(int(chaos.classification[0]))
        early = time * natural_rates(self.system, z0[:, None])[0] < 2 * np.pi * CALM_PERIODS
        said = (
            Classification.UNDECIDED if early and classification == Classification.REGULAR else classification
        ).name.lower()
        megno, lyapunov = _finite([chaos.megno[0], chaos.lyapunov[0]])
        return {
            "rotation": rotation,
            "megno": megno,
            "lyapunov": lyapunov,
            "classification": said,
            "frequencies": lines,
        }


def _finite(values: Any) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]


def _label(name: str) -> str:
    stem = name.removeprefix("p_")
    return ("p_" if stem != name else "") + LETTERS.get(stem, stem)


def _typed(given: dict[str, Any], parameters: dict[str, Any], known: bool = True) -> Any:
    """Return the model of a typed formula; known: whether the parameters have values; else any are taken."""
    text = given["formula"]
    if given["kind"] == "body":
        own: dict[str, Any] = {name: value for name, value in parameters.items() if name != "mu"}
        made = affine_body(text, mu=parameters.get("mu", 1.0), **own)
        if not current_system(made).isotropic:
            raise ValueError("formula must be isotropic, the same for rotations of a and b, to have sections")
        return made
    pieces = [
        part.strip() for part in re.split(r"[,;\n]|\s+(?=[A-Za-z]\w*\s*=)", given.get("periodic") or "") if part.strip()
    ]
    periods = {name.strip(): value.strip() for name, _, value in (part.partition("=") for part in pieces)}
    if given["kind"] == "map":
        return (
            iterated_map(text, periodic=periods, **parameters) if known else untried(text, parameters, periodic=periods)
        )
    if given["kind"] == "ode" or given.get("drive_period"):
        raise ValueError("formula must have no drive and no equations in a notebook. Use fa.explore.")
    rows: dict[str, Any] = {"coordinates": given.get("coordinates") or "x y", "momenta": given.get("momenta") or None}
    return checked_model(hamiltonian(text, **rows, periodic=periods or None, **parameters), needs="a page")


def section_of(system: System, name: str, constant: float | None, direction: int) -> Any:
    """Return the section of that name, such as x=c with the constant c; ValueError if the body has no such section."""
    text = name.removesuffix("=c")
    return section_named(text if text == name else f"{text}={float(constant or 0.0)!r}", system, direction)
