"""The system and its energy surface: the tables [model] and [energy_surface] of a job, options of the commands."""

from __future__ import annotations

import inspect
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..core.names import named, pairs, spelled
from ..core.numbers import listed
from ..core.status import Status
from ..engine.kinds import OPTIONS, TERMS
from ..runs.requirements import check_given
from ..sections.energy_shell import may_escape
from ..systems import models
from ..systems.formulas.formula import affine_body, hamiltonian
from ..systems.formulas.grammar import TIME, UnknownName
from ..systems.formulas.iterated_map import iterated_map
from ..systems.formulas.library import Request
from ..systems.formulas.map_source import MapRequest
from ..systems.formulas.number import number
from ..systems.formulas.ode import ode
from ..systems.formulas.section_text import canonical, section_forms, section_named
from ..systems.formulas.systems import SYSTEMS as NAMED
from ..systems.models.mechanics import System
from .wording import OptionError, option, respelled

MODELS = {
    "harmonic": ("Harmonic", ("C",)),
    "anharmonic": ("Anharmonic", ("C",)),
    "hyperelastic": ("Hyperelastic", ("C",)),
    "heavy-top": ("HeavyTop", ("C", "A")),
    "neo-hookean": ("NeoHookean", ("G", "K")),
    "henon-heiles": ("HenonHeiles", ("lam",)),
}

MAPS = {
    "standard-map": "StandardMap",
    "henon-map": "HenonMap",
    "mcmillan-map": "McMillanMap",
    "froeschle-map": "FroeschleMap",
    "one-turn-map": "OneTurnMap",
}
"""Maps by name, whose parameters are given by --parameter."""

SYSTEMS = {re.sub(r"(?<=.)(?=[A-Z])", "-", name).lower(): name for name in ("DoublePendulum", *NAMED)}
"""Systems H(q, p) by name, whose parameters are given by --parameter too."""

OWN = (*MODELS, *MAPS, *SYSTEMS)
"""All models by name."""

RATES = (*OPTIONS, "drive_period")
"""Options of a Hamiltonian that are numbers or formulas."""

LOSING = ("ode", *(name for name, term in OPTIONS.items() if "loss" in TERMS[term].words))
"""Options of systems that keep no energy."""

_LOSING = " and ".join(f"{{{name}}}" for name in LOSING)

RESERVED = ("mu", "domain", "coordinates", "momenta", "periodic", "masses", "vector_potential", *RATES)
"""Names that no parameter of a formula has."""


@dataclass(frozen=True, kw_only=True)
class Model:
    """The system."""

    model: str | None = None
    """harmonic, anharmonic, hyperelastic (parameter C), heavy-top (C, A), neo-hookean (G, K) or henon-heiles (lam).
    With --parameter: a system of `fa.models` by its name in small letters, such as double-pendulum or kerr-geodesic, or
    a map: standard-map, henon-map, mcmillan-map, froeschle-map, one-turn-map. An unknown name lists all. [neo-hookean]
    """
    C: float | None = None
    """Stiffness of harmonic, anharmonic, hyperelastic and heavy-top [1]."""
    A: float | None = None
    """Strength of the heavy top's cos(vartheta) term [1]."""
    G: float | None = None
    """Shear modulus of neo-hookean [1]."""
    K: float | None = None
    """Bulk modulus of neo-hookean [2]."""
    lam: float | None = None
    """Coupling of henon-heiles [1]."""
    formula: str | None = None
    """Potential of a body, such as `C/2*(D1**2+D2**2) + C/(D1*D2)`, instead of a model."""
    hamiltonian: str | None = None
    """Potential of a system p^2/2 + V, such as `(x**2+y**2)/2 + x**2*y - y**3/3`; with --momenta the
    whole of H.
    """
    map: str | None = None
    """Iterated map, such as `p1 = p + K*sin(x); x1 = x + p1`."""
    periodic: list[str] | None = None
    """NAME=PERIOD of a variable of --map that winds, or a coordinate of --hamiltonian that is an angle, such as
    `x=2*pi`; once for each.
    """
    coordinates: str | None = None
    """Coordinates of --hamiltonian ["x y"] or of --map [by their names]."""
    momenta: str | None = None
    """Momenta in the text of --hamiltonian, one for each coordinate, such as "p1 p2": any H(q, p)."""
    rotation: str | None = None
    """Rotation rate of the frame of the first two coordinates of --hamiltonian, a number or a formula."""
    magnetic: str | None = None
    """Charge times a uniform magnetic field across the first two coordinates of --hamiltonian."""
    vector_potential: list[str] | None = None
    """NAME=FORMULA of the charge times the vector potential along a coordinate of --hamiltonian, such as
    `y=B*x + k*x**2/2`; once for each.
    """
    friction: str | None = None
    """Rate at which --hamiltonian loses its momenta, a number or a formula of the parameters."""
    ode: str | None = None
    """ODE system, such as `x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z`."""
    parameter: list[str] | None = None
    """NAME=VALUE of a letter in the formula, or of a map; once for each."""
    domain: str | None = None
    """Formula that is positive in the domain of the potential. [from logarithms, roots and poles]"""
    drive_period: str | None = None
    """Period in the time t of --hamiltonian, a number or a formula of the parameters such as `2*pi/w`: a driven system.
    """
    mu: float = 1.0
    """Inertia of a body. [1]"""

    def build(self) -> Any:
        """Return the model of the table.

        Returns
        -------
        model
            The model.

        Raises
        ------
        TypeError, ValueError
            If the model does not have a given parameter, or a value is wrong.
        """
        given = {name: getattr(self, name) for name in ("C", "A", "G", "K", "lam") if getattr(self, name) is not None}
        if self.periodic is not None and self.map is None and self.hamiltonian is None and self.ode is None:
            raise OptionError.of("{periodic} belongs to {map}, {hamiltonian} or {ode}")
        if any(entry is not None for entry in self._texts):
            return self._own(given)
        key = named(option("model"), self.model or "neo-hookean", OWN)
        letters = ("parameter",) if key in MODELS else ()
        for name in ("coordinates", "momenta", "vector_potential", "domain", *RATES, *letters):
            if getattr(self, name) is not None:
                raise OptionError.of("{it} belongs to {formula}, {hamiltonian}, {map} or {ode}", it=option(name))
        if key not in MODELS:
            return self._by_parameters(key, given)
        kind, names = MODELS[key]
        for name in given:
            if name not in names:
                raise OptionError(f"{option(name)} is not a parameter of {key}, which has {listed(map(option, names))}")
        value = getattr(models, kind)(**given)
        return value if key == "henon-heiles" else models.Body(value, self.mu)

    @property
    def _texts(self) -> tuple[str | None, ...]:
        """The texts that stand for a system of one's own."""
        return self.formula, self.hamiltonian, self.map, self.ode

    def canonical(self) -> Model:
        """Return the table with the canonical name of the model.

        Returns
        -------
        Model
            The table.
        """
        return self if self.model is None else replace(self, model=spelled(self.model, OWN))

    def _by_parameters(self, key: str, given: dict[str, float]) -> Any:
        """Return one of the maps of the package, or of the systems H(q, p)."""
        kind: Any = getattr(models, {**MAPS, **SYSTEMS}[key])
        takes = {entry.name: type(entry.default) for entry in inspect.signature(kind).parameters.values()}
        names = [name for name in takes if takes[name] in (float, str)]
        texts = [name for name in names if takes[name] is str]
        values = self._values(texts) | given
        for name in values:
            if name not in names:
                raise OptionError(f"{option('parameter')} {name} is none of {key}, which has {listed(names)}")
        if self.mu != 1.0:
            raise OptionError.of("{mu} belongs to bodies")
        return kind(**values)

    def _values(self, texts: Sequence[str] = ()) -> dict[str, Any]:
        """Return the parameters by name: numbers, but texts for the names in `texts`."""
        values: dict[str, Any] = {}
        for name, text in pairs(option("parameter"), self.parameter or (), "VALUE with a number, for example C=1.5"):
            values[name] = text if name in texts else number(f"{option('parameter')} {name}", text)
            if name in RESERVED:
                text = "{parameter} {name}=...: {name} is an option of its own, {it}, or has a meaning: choose another "
                raise OptionError.of(text + "letter", name=name, it=option(name))
        return values

    def _own(self, given: dict[str, float]) -> Any:
        """Return the model that a formula describes."""

        if given:
            name = next(iter(given))
            text = "{it} belongs to a {model}; a formula takes {parameter} {name}={value:g}"
            raise OptionError.of(text, it=option(name), name=name, value=given[name])
        if sum(entry is not None for entry in (self.model, *self._texts)) > 1:
            raise OptionError.of("give one of {model}, {formula}, {hamiltonian}, {map} and {ode}")
        values = self._values()
        if self.formula is not None and self.coordinates is not None:
            raise OptionError.of(
                "{coordinates} belongs to {hamiltonian}; a {formula} is in D1, D2, alpha, beta, r, vartheta, ..."
            )
        if self.ode is not None and self.coordinates is not None:
            raise OptionError.of(
                "{coordinates} belongs to {hamiltonian}; the variables of {ode} are those of its equations"
            )
        for name in (*RATES, "momenta", "vector_potential"):
            if self.hamiltonian is None and getattr(self, name) is not None:
                why = ": the coordinates of a body do not turn, nor is it driven" if name in RATES else ""
                why = why if name != "momenta" else ", as the names of momenta in its text"
                raise OptionError.of("{it} belongs to {hamiltonian}{why}", it=option(name), why=why)
        if self.formula is None and self.mu != 1.0:
            raise OptionError.of(
                "{mu} belongs to bodies; a {hamiltonian} has the masses 1, others none: rescale the coordinates"
            )
        try:
            return self._made(values)
        except ValueError as problem:
            own = next(name for name in ("formula", "hamiltonian", "map", "ode") if getattr(self, name) is not None)
            said = str(problem)
            if said.startswith(("text:", "text,", "text must")):
                said = option(own) + said.removeprefix("text")
            elif own == "hamiltonian" and said.startswith(("coordinates must", "momenta must")):
                said = respelled(said, ("coordinates", "momenta"))
            elif said.startswith("vector_potential"):
                said = option("vector_potential") + said.removeprefix("vector_potential")
            elif own in ("hamiltonian", "ode") and said.startswith("periodic"):
                said = option("periodic") + said.removeprefix("periodic")
            elif said.startswith("drive_period"):
                said = option("drive_period") + said.removeprefix("drive_period")
            if isinstance(problem, UnknownName):
                said = said.replace(f". {problem.hint}", f". {_hint(problem, own)}")
            raise OptionError(said) from None

    def _made(self, values: dict[str, Any]) -> Any:
        """Return the model of the formula with its parameters."""
        periodic = dict(pairs(option("periodic"), self.periodic or (), "PERIOD")) or None
        if self.ode is not None:
            return ode(self.ode, domain=self.domain, periodic=periodic, **values)
        if self.map is not None:
            how: dict[str, Any] = {
                "coordinates": self.coordinates,
                "periodic": periodic,
                "domain": self.domain,
                **values,
            }
            return iterated_map(self.map, **how)
        if self.formula is None:
            own: dict[str, Any] = {name: _rate(getattr(self, name)) for name in RATES}
            fields = dict(pairs(option("vector_potential"), self.vector_potential or (), "FORMULA")) or None
            own |= {"coordinates": self.coordinates or "x y", "momenta": self.momenta, "periodic": periodic}
            own["vector_potential"] = fields
            return hamiltonian(self.hamiltonian, domain=self.domain, **own, **values)
        return affine_body(self.formula, mu=self.mu, domain=self.domain, **values)


def _hint(problem: UnknownName, own: str) -> str:
    """Return the options that may be meant where a formula has an unknown name."""
    if near := re.search(r"Did you mean [^?]*\?", problem.hint):
        return near[0]
    if problem.name == TIME and own == "hamiltonian":
        return f"Use {option('drive_period')} for the time of a driven system."
    coordinates = f" or {option('coordinates')}" if own == "hamiltonian" else ""
    return f"Use {option('parameter')} {problem.name}=VALUE{coordinates}."


def _rate(text: str | None) -> float | str | None:
    """Return a number that is written as one, else the formula."""
    try:
        return text if text is None else float(text)
    except ValueError:
        return text


@dataclass(frozen=True, kw_only=True)
class EnergySurface:
    """Energy and section of the orbits."""

    energy: float | None = None
    """Energy of every orbit. Required."""
    p_eta: float = 0.0
    """Angular momentum in the plane a, of radius alpha = (D1 + D2)/sqrt(2). [0]"""
    p_gamma: float = 0.0
    """Angular momentum in the plane b, of radius beta = (D1 - D2)/sqrt(2). [0]"""
    section: str | None = None
    """alpha-turning (p_alpha = 0), beta-turning, alpha=c, beta=c, area=c (D1 D2 = c); x=c or y=c, or a coordinate of
    --hamiltonian, with c a number; t=c where it is driven. [alpha-turning; x=0; t=0]"""
    direction: str = "+1"
    """Crossings where the section function increases (+1), decreases (-1) or both (0). [+1]"""

    def build(self, system: System) -> Any:
        """Return the section of the table.

        Parameters
        ----------
        system : object
            System of the job.

        Returns
        -------
        Section
            The section, or None for a map.

        Raises
        ------
        ValueError
            If the energy is missing or a value is wrong.
        """
        if system.iterated:
            check_given(
                system,
                "a time",
                "a map has none",
                **{option(name): getattr(self, name) for name in ("energy", "section")},
            )
            return None
        if not system.conserves:
            if self.energy is not None:
                raise OptionError.of(f"{{energy}} is for systems that keep one: those of {_LOSING} do not")
            return self.section_of(system)
        if system.driven:
            raise OptionError.of("{file} is required: the starts of a driven system, rows of coordinates and momenta")
        if self.energy is None:
            sign = "" if option("energy").startswith("--") else "= "
            raise OptionError.of(f"{{energy}} is required: the energy of every orbit. Try {{energy}} {sign}1.5.")
        return self.section_of(system)

    def escape(self, system: System, status: np.ndarray) -> str | None:
        """Return a note on the energy if orbits have escaped.

        Parameters
        ----------
        system : object
            System of the job.
        status : ndarray of int
            Statuses of the orbits.

        Returns
        -------
        str
            The note, or None if no orbit has escaped.
        """
        gone = np.isin(status, (Status.ESCAPED, Status.NONFINITE)).any()
        return may_escape(system, self.energy, self.p_eta, self.p_gamma) if gone and self.energy is not None else None

    def section_of(self, system: System) -> Any:
        """Return the section of the table without a check of the energy.

        Parameters
        ----------
        system : object
            System of the job.

        Returns
        -------
        Section
            The section, or None for a map.
        """
        if system.iterated:
            return None
        if self.direction not in ("+1", "1", "-1", "0", "+0"):
            raise OptionError(f"{option('direction')} must be +1, -1 or 0, got {self.direction}")
        own = section_forms(system)[system.moving if system.driven else 0]  # if driven, a constant time
        text = self.section or own.replace("=c", "=0")
        return section_named(text, system, int(self.direction), argument=option("section"))

    def canonical(self) -> EnergySurface:
        """Return the table with the canonical form of the section.

        Returns
        -------
        EnergySurface
            The table.
        """
        return self if self.section is None else replace(self, section=canonical(self.section))


def described(system: System) -> Model | None:
    """Return the options that build this model, None where none do."""
    inner = getattr(system.model, "potential", system.model)
    if hasattr(inner, "_fields") and any(isinstance(entry, tuple) for entry in inner):
        return None  # of parts, such as functions of one variable or pairs of atoms
    mu = float(getattr(system.model, "mu", 1.0)) if inner is not system.model else 1.0
    fields: dict[str, Any] = (
        {name: float(entry) for name, entry in zip(inner._fields, inner)} if hasattr(inner, "_fields") else {}
    )
    text = getattr(inner, "formula", None)
    found = None
    made = Request(*system.model._request) if hasattr(system.model, "_request") and not system.iterated else None
    if text is not None:
        options = {} if made is None else made.options
        rates: dict[str, Any] = {name: repr(fields.pop(name)) if how == name else how for name, how in options.items()}
        parameter = [f"{name}={entry!r}" for name, entry in fields.items()] or None
        domain = getattr(inner, "domain", None)
        if system.iterated:
            rows = (*system.model.coordinates, *system.model.momenta)
            periodic = [
                f"{name}={text}" for name, text in zip(rows, MapRequest(*system.model._request).periods) if text
            ]
            more: dict[str, Any] = {"periodic": periodic or None, "parameter": parameter, "domain": domain}
            found = Model(map=text, coordinates=" ".join(system.model.coordinates), **more)
        elif not system.canonical:
            turns = () if made is None else zip(made.coordinates, made.periods)
            periodic = [f"{name}={text}" for name, text in turns if text]
            found = Model(ode=text, parameter=parameter, domain=domain, periodic=periodic or None)
        elif inner is not system.model:
            found = Model(formula=text, parameter=parameter, domain=domain, mu=mu)
        elif made is not None:
            coordinates = " ".join(system.model.coordinates[: system.moving])
            drive_period = None
            if system.driven:
                said = fields.pop("period", None)
                drive_period = made.period if said is None else repr(said)
                parameter = [f"{name}={entry!r}" for name, entry in fields.items()] or None
            periodic = [f"{name}={text}" for name, text in zip(made.coordinates, made.periods) if text]
            found = Model(
                hamiltonian=text,
                momenta=" ".join(made.momenta) or None,
                periodic=periodic or None,
                coordinates=coordinates,
                parameter=parameter,
                domain=domain,
                drive_period=drive_period,
                **rates,
            )
    else:
        keys = [key for key, (kind, _) in MODELS.items() if type(inner) is getattr(models, kind)]
        maps = [key for key, kind in {**MAPS, **SYSTEMS}.items() if type(system.model) is getattr(models, kind)]
        if maps:
            found = Model(model=maps[0], parameter=[f"{name}={entry!r}" for name, entry in fields.items()])
        if keys:
            found = Model(model=keys[0], mu=mu, **fields)
    try:
        same = found is not None and found.build()
    except (ValueError, TypeError):
        return None
    return found if found is not None and type(same) is type(system.model) and same == system.model else None
