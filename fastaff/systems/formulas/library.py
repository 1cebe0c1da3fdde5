"""The library of formulas: their classes, derived once, kept as source text beside the compiled kernels.

The request, the package's sources, Python and Numba determine the name of a text. It is written whole, carries a
checksum, and is read back without SymPy. Without a writable folder classes live in memory.
"""

from __future__ import annotations

import functools
import hashlib
import json
import sys
import types
import weakref
from collections import OrderedDict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...core.interruption import imported
from ...engine import cache, code_folder
from ...engine.kinds import OPTIONS, TERMS
from ...engine.values import told_apart
from ..models.energy_method import energy_method
from .equations import split
from .grammar import Program, parse
from .singular import AXES, body_places, invariant_places, plain_places, refuse_removable, ring_text, vanishing
from .variables import VARIABLES, ProgramTrial, check_real, check_symmetry, everything, is_isotropic


class Request(NamedTuple):
    """All data that determine a generated class. inertia: "mu" or "pair" for bodies, "unit" or "masses" for other
    systems, or "ode" for equations; rotation, magnetic, friction: formulas of the parameters; others: names and
    formulas of the other options of terms (`engine.kinds.OPTIONS`); period: of a driven system, whose last coordinate
    is its time: a formula of the parameters, or "" for a field. With momenta the text is H(q, p); periods: texts of the
    periods of its rows, "" for none.
    """

    text: str
    domain: str | None
    parameters: tuple[str, ...]
    coordinates: tuple[str, ...]
    inertia: str
    rotation: str | None = None
    magnetic: str | None = None
    period: str | None = None
    friction: str | None = None
    momenta: tuple[str, ...] = ()
    periods: tuple[str, ...] = ()
    others: tuple[tuple[str, str], ...] = ()

    @property
    def options(self) -> dict[str, str]:
        """The formulas of the options of terms that are given, by name."""
        given = {name: getattr(self, name) for name in OPTIONS if name in self._fields} | dict(self.others)
        return {name: text for name, text in given.items() if text is not None}

    @property
    def variables(self) -> tuple[str, ...]:
        """Return the names allowed in the formula besides its parameters."""
        return (*self.coordinates, *self.momenta) or VARIABLES

    def period_programs(self) -> tuple[Program | None, ...]:
        """Return the programs of the periods of the rows, None where there is none."""
        named = [parse(text, (), self.parameters, argument="periodic") if text else None for text in self.periods]
        return tuple(named)

    def program(self, length: int) -> Program:
        """Return the program of the formula; raise ValueError where the text is no formula."""
        return parse(self.text, self.variables, self.parameters, length=length)

    def programs(self, length: int) -> tuple[Program, ...]:
        """Return the programs of the equations of a flow; raise ValueError where one is no formula."""
        return tuple(parse(side, self.variables, self.parameters, length=length) for _, side in split(self.text))

    def option_programs(self) -> dict[str, Program]:
        """Return the programs of the options of terms that are given."""
        return {name: parse(text, (), self.parameters, argument=name) for name, text in self.options.items()}

    def domain_program(self) -> Program | None:
        """Return the program of the domain, if one is given."""
        return None if self.domain is None else parse(self.domain, self.variables, self.parameters, argument="domain")


Programs = tuple[Program | tuple[Program, ...], Program | None]
"""Programs of a formula, or of the equations of a flow, and of its domain."""


def generated_class(request: Request, programs: Programs, values: Mapping[str, float]) -> type:
    """Return the NamedTuple class of a request: from this process, from the folder, or derived now, with trials around
    `values`.
    """
    terms = [(TERMS[OPTIONS[name]].rate, TERMS[OPTIONS[name]].equations) for name in request.options]
    key = hashlib.sha256(
        json.dumps([code_folder.code_hash(__name__), sys.version, *request, *terms]).encode()
    ).hexdigest()[:24]

    def made() -> Any:
        cls: Any = loaded(key, lambda: _derive(request, programs, values))
        cls.__reduce__ = functools.partialmethod(_reduce, request)
        cls._request = tuple(request) if request.others else tuple(request)[:-1]  # as in files of older versions
        return told_apart(cls, cls._request)

    return CLASSES.get(key, made)


class Classes:
    """Classes of formulas by their keys: all that are in use, and those met last beside them."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._alive: weakref.WeakValueDictionary[str, type] = weakref.WeakValueDictionary()
        self._last: OrderedDict[str, type] = OrderedDict()

    def get(self, key: str, make: Callable[[], type]) -> type:
        """Return the class of a key, made now if it is not there."""
        found = self._alive.get(key)
        if found is None:
            found = self._alive[key] = make()
        self._last[key] = found
        self._last.move_to_end(key)
        while len(self._last) > self._most:
            self._last.popitem(last=False)
        return found

    def named(self, key: str, name: str) -> Any:
        """Return the class of a key if it has that name and is in use."""
        found = self._alive.get(key)
        if found is None or found.__name__ != name:
            raise AttributeError(f"no class {name} is in use")
        return found


CLASSES = Classes(most=128)
"""The classes of this process. Those of 128 formulas take some 10 MB."""


class _Home(types.ModuleType):
    """The module by which Numba's cache finds the class of a formula; it does not keep that in memory."""

    def __init__(self, key: str, path: Path | None) -> None:
        super().__init__(f"fastaff_formula_{key}")
        self._key = key
        if path is not None:
            self.__file__ = str(path)

    def __getattr__(self, name: str) -> Any:
        return CLASSES.named(self._key, name)


def loaded(key: str, derive: Callable[[], str]) -> Any:
    """Return the class whose text is kept under a key, or derived now. Numba's cache finds it by the name of its
    module, which is there as long as the class is.
    """
    folder = code_folder.cache_directory()
    path = None if folder is None else folder / "formulas" / f"{key}.py"
    written = None if path is None else cache.read(path)
    if written is None:
        written = derive().encode()
        if path is not None and not cache.write(path, written):
            path = None
    text = "\n" + written.decode()  # below the line of the checksum
    home = _Home(key, path)
    space: dict[str, Any] = {"__name__": home.__name__, "__file__": getattr(home, "__file__", None)}
    exec(compile(text, str(path or f"<fastaff formula {key}>"), "exec"), space)
    home.__doc__ = space.get("__doc__")
    cls: Any = next(entry for name, entry in space.items() if name.startswith("Formula") and isinstance(entry, type))
    cls.__repr__ = _repr
    if hasattr(cls, "kinetic_energy") and "energy" not in cls._fields:  # a field of models kept by older versions
        cls.energy = property(energy_method)
    sys.modules[home.__name__] = home
    weakref.finalize(cls, _left, home).atexit = False
    return cls


def _left(home: _Home) -> None:
    """Remove the module of a class that is no more, unless another of the same key has come."""
    if sys.modules.get(home.__name__) is home:
        del sys.modules[home.__name__]


SHOWN = 300
"""Characters of a formula up to which a repr has the whole of it."""

FIRST = 160
"""Characters of a longer one that a repr has."""


def brief(text: str) -> str:
    """Return the repr of a formula, of a long one the beginning and its length; `model.formula` has the whole."""
    return repr(text) if len(text) <= SHOWN else f"{text[:FIRST]!r}... ({len(text)} characters)"


def _repr(self: Any) -> str:
    domain = [] if self.domain is None else [f"domain={brief(self.domain)}"]
    fields = [f"{name}={value!r}" for name, value in zip(self._fields, self, strict=True)]
    request = Request(*self._request)
    own = {**request.options, "drive_period": request.period, "momenta": request.momenta}
    said = [f"{name}={text!r}" for name, text in own.items() if text not in (None, "", (), [], name)]
    return f"{type(self).__name__}({', '.join([brief(self.formula), *domain, *said, *fields])})"


def _reduce(self: Any, request: Request) -> tuple:
    return rebuild, (tuple(request), tuple(self))


def rebuild(request: tuple, values: tuple) -> Any:
    """Return the value of a pickled request and the numbers of its fields."""
    whole = Request(*request)
    program = whole.programs(8000) if whole.inertia == "ode" else whole.program(8000)
    programs = program, whole.domain_program()
    cls = generated_class(whole, programs, dict(zip(whole.parameters, values, strict=False)))
    return cls(*values)


# --- derivation ---------------------------------------------------------------------------------------------------


def _derive(request: Request, programs: Any, values: Mapping[str, float]) -> str:
    imported("sympy", what="a formula that is new here")
    if request.inertia == "ode":
        return _derive_flow(request, programs, values)
    return (_derive_hamiltonian if request.coordinates else _derive_body)(request, programs, values)


def _parameters(request: Request) -> dict[str, Any]:
    import sympy

    return {name: sympy.Symbol(f"self.{name}", real=True) for name in request.parameters}


def _derive_hamiltonian(request: Request, programs: tuple[Program, Program | None], values: Mapping[str, float]) -> str:
    import sympy

    from .centres import centres
    from .domains import conditions, everywhere, poles, reached
    from .inertia import in_turning_frame, separated
    from .model_source import driven_model, hamiltonian_model
    from .ode_source import nonseparable_model
    from .potential_source import Description
    from .sympy_bridge import sharp, to_sympy

    program, domain = programs
    own = {name: sympy.Symbol(name, real=True) for name in request.variables}
    names = {**own, **_parameters(request)}
    V = sharp(to_sympy(program, names))
    middles = centres(V, [own[name] for name in request.coordinates])
    bases = [centre.base for centre in middles]
    walls = [to_sympy(domain, names)] if domain is not None else conditions(V, everywhere(own.values()), bases)
    search = functools.partial(reached, walls, [*own.values()], values)
    check_real(program, values, request.variables, "text", search)
    refuse_removable(V, walls if domain is not None else [], plain_places(request.variables), values, request.variables)
    masses = request.inertia == "masses"
    kind = "natural" if request.period is None else "driven"
    description = Description(
        request.text, request.domain, request.parameters, f"A {kind} Hamiltonian.", request.coordinates
    )
    period: Any = request.period
    if period:
        period = to_sympy(parse(period, (), request.parameters, argument="drive_period"), names)
    periods = [sympy.Integer(0) if p is None else to_sympy(p, names) for p in request.period_programs()]
    more: dict[str, Any]
    places = everywhere([own[name] for name in request.coordinates])
    inertia = None
    if request.momenta:
        p = [own[name] for name in request.momenta]
        found = separated(V, walls, p, request.coordinates)
        turned = None if found or period is not None else in_turning_frame(V, walls, p, request.coordinates)
        if turned is not None:
            rest, rate, inertia = turned
            description = description._replace(centres=tuple(middles))
            more = {"inertia": inertia, "periods": periods, "momenta": request.momenta, "poles": poles(rest, places)}
            return hamiltonian_model(description, rest, walls, masses=False, term="frame", rate=rate, **more)
        if found is None:
            momenta = (*request.momenta, *(["p_t"] if period is not None else []))
            own |= {name: sympy.Symbol(name, real=True) for name in momenta}
            walls = conditions(V, everywhere(own.values())) if domain is None else walls
            bounds = walls, poles(V, everywhere(own.values()))
            return nonseparable_model(description, V, bounds, own, momenta, periods, period)
        V, inertia = found
        walls = [wall for wall in walls if not wall.free_symbols & {*p}]
    more = {"inertia": inertia, "periods": periods, "momenta": request.momenta, "poles": poles(V, places)}
    description = description._replace(centres=tuple(middles))
    if period is not None:
        return driven_model(description, V, walls, period, masses=masses, **more)
    options = {name: to_sympy(part, names) for name, part in request.option_programs().items()}
    mass = sympy.Symbol("self.m_1", real=True) if masses else sympy.Integer(1)
    term = next((OPTIONS[name] for name in options), None)
    rate = None
    if term is not None:
        rate, added = TERMS[term].of_options(options, mass, [own[name] for name in request.coordinates])
        V += added
    return hamiltonian_model(description, V, walls, masses=masses, term=term, rate=rate, **more)


def _derive_flow(
    request: Request, programs: tuple[tuple[Program, ...], Program | None], values: Mapping[str, float]
) -> str:
    import sympy

    from .domains import conditions, everywhere, poles, reached
    from .ode_source import ode_model
    from .potential_source import Description
    from .sympy_bridge import sharp, to_sympy

    own = {name: sympy.Symbol(name, real=True) for name in request.coordinates}
    names = {**own, **_parameters(request)}
    rates = []
    walls = []
    region = everywhere(own.values())
    for program in programs[0]:
        rates.append(sharp(to_sympy(program, names)))
        here = conditions(rates[-1], region)
        search = functools.partial(reached, here, [*own.values()], values)
        check_real(program, values, request.coordinates, "text", search)
        walls += [wall for wall in here if wall not in walls]
    walls = walls if programs[1] is None else [to_sympy(programs[1], names)]
    description = Description(
        request.text, request.domain, request.parameters, "An autonomous system.", request.coordinates
    )
    periods = [sympy.Integer(0) if p is None else to_sympy(p, names) for p in request.period_programs()]
    return ode_model(description, rates, (walls, poles(sympy.Tuple(*rates), region)), own, periods)


def _derive_body(request: Request, programs: tuple[Program, Program | None], values: Mapping[str, float]) -> str:
    program, domain = programs
    trial = ProgramTrial(program, values)
    check_symmetry(trial, "text")
    isotropic = is_isotropic(trial)
    if domain is not None:
        of_domain = ProgramTrial(domain, values)
        check_symmetry(of_domain, "domain")
        isotropic_domain = is_isotropic(of_domain)
    else:
        isotropic_domain = True
    if isotropic and isotropic_domain and request.inertia == "mu":
        return _derive_potential(request, programs, trial)
    return _derive_general(request, programs, trial, isotropic)


def alpha_even(trial: ProgramTrial) -> bool:
    """Tell whether the formula is a smooth function of alpha^2 beyond alpha = 0: unchanged by alpha -> -alpha, at
    random points.
    """
    tried = 0
    for _ in range(40):
        _, (alpha, beta, eta, gamma) = trial.point()
        parameters = trial.generic_parameters()
        one, other = (trial.value(trial.at(sign * alpha, beta, eta, gamma), parameters) for sign in (1, -1))
        if one is None:
            continue
        if other is None or trial.differ(one, other):
            return False
        tried += 1
    return tried > 0


def body_region(s: Mapping[str, Any]) -> Any:
    """Return the sampler of D1 > D2 > 0 for all symbols of the body."""

    def region(rng: np.random.Generator, count: int) -> dict[Any, np.ndarray]:
        alpha = rng.uniform(0.2, 3.0, count)
        beta = alpha * rng.uniform(0, 1, count)
        eta = rng.uniform(0, 7, count)
        gamma = rng.uniform(0, 7, count)
        a1 = alpha * np.cos(eta)
        a2 = alpha * np.sin(eta)
        b1 = beta * np.cos(gamma)
        b2 = beta * np.sin(gamma)
        values = everything(a1, a2, b1, b2, alpha, beta, np.sqrt, np.arctan)
        values |= {"A": alpha**2, "B": beta**2}
        return {
            s[name]: values[name] for name in ("A", "B", "alpha", "beta", "x", "y", "z", "u", "a1", "a2", "b1", "b2")
        }

    return region


def _derive_potential(request: Request, programs: tuple[Program, Program | None], trial: ProgramTrial) -> str:
    """Return the source of a doubly isotropic potential."""
    import sympy

    from . import isotropy, potential_source
    from .domains import conditions, poles
    from .sympy_bridge import checked, to_sympy

    s = isotropy.symbols()
    names = {**isotropy.invariants(s), **isotropy.on_the_axes(s), **_parameters(request)}
    roots = {s["alpha"]: sympy.sqrt(s["A"]), s["beta"]: sympy.sqrt(s["B"])}

    def reduced(program: Program) -> isotropy.Reduced:
        return isotropy.reduce(isotropy.without_angle(to_sympy(program, names), s), s)

    V = reduced(programs[0])
    checked(V.expression)
    if programs[1] is not None:
        walls = [reduced(programs[1]).expression]
    else:
        walls = conditions(V.expression, body_region(s))
        if V.expression.has(s["alpha"]) and not alpha_even(trial):
            walls.append(s["A"])
    walls = [wall.xreplace(roots) for wall in walls]
    passed = tuple(number.xreplace(roots) for number in poles(V.expression, body_region(s)))
    about = request.text, request.domain, request.parameters, _proof(programs[0], V)
    description = potential_source.Description(*about, poles=passed)
    g = V.expression.xreplace({s["A"]: s["alpha"] ** 2, s["B"]: s["beta"] ** 2})
    on_axis = vanishing(V.expression, invariant_places(axis=True), trial.parameters)
    given = walls if programs[1] is not None else []
    refuse_removable(V.expression, given, invariant_places(axis=False), trial.parameters, AXES, on_axis)
    if on_axis:
        return ring_text(description, g, walls, s, trial)
    if V.even_beta:
        clamp = V.expression.has(s["alpha"]) and alpha_even(trial)
        return potential_source.potential(description, V.expression.xreplace(roots), walls, s, clamp=clamp)
    return potential_source.even_potential(description, g, walls, s, alpha_even(trial))


def _proof(program: Program, reduced: Any) -> str:
    """Return the proof that V depends on alpha and beta alone, in words."""
    from .isotropy import turns_prove
    from .variables import DIGITS, MATRIX, PLANES, POINTS

    if program.names & {*MATRIX, *PLANES} and not turns_prove(program):
        pass
    elif reduced.even_beta:
        return "Doubly isotropic, exactly: algebra turns it into a function of A and B."
    elif reduced.exact:
        return "Doubly isotropic, exactly: a function of alpha and beta that beta -> -beta leaves as it is."
    return f"Doubly isotropic, numerically: at {POINTS} random points, to {DIGITS // 2} of {DIGITS} digits."


def _derive_general(
    request: Request, programs: tuple[Program, Program | None], trial: ProgramTrial, isotropic: bool
) -> str:
    """Return the source of a body whose potential or inertia is not isotropic."""
    import sympy

    from . import isotropy, model_source, potential_source
    from .domains import conditions, poles
    from .sympy_bridge import checked, to_sympy

    s = isotropy.symbols()
    elements = (
        isotropy.on_the_axes(s)
        if isotropic
        else {name: s[name] for name in ("x", "y", "z", "u", "a1", "a2", "b1", "b2")}
    )
    names = {**isotropy.invariants(s), **elements, **_parameters(request)}

    def reduced(program: Program, isotropic_too: bool) -> Any:
        own = names if isotropic_too else {**names, **{n: s[n] for n in elements}}
        return isotropy.reduce(isotropy.without_angle(to_sympy(program, own), s), s)

    whole = reduced(programs[0], isotropic)
    V = checked(whole.expression)
    if programs[1] is not None:
        walls = [reduced(programs[1], False).expression]
    else:
        walls = conditions(V, body_region(s))
        if V.has(s["alpha"]) and not alpha_even(trial):
            walls.append(s["A"])
    refuse_removable(
        V, walls if programs[1] is not None else [], body_places(), trial.parameters, ("alpha", "beta", "eta", "gamma")
    )
    clamped = ["beta"] + (["alpha"] if alpha_even(trial) else [])
    proof = _proof(programs[0], whole) if isotropic else "Not doubly isotropic: turning a and b separately changes it."
    a1, a2, b1, b2 = (s[name] for name in ("a1", "a2", "b1", "b2"))
    alpha = sympy.sqrt(a1**2 + a2**2)
    beta = sympy.sqrt(b1**2 + b2**2)
    places = everything(a1, a2, b1, b2, alpha, beta, sympy.sqrt, sympy.atan)
    places |= {"A": alpha**2, "B": beta**2, "alpha": alpha, "beta": beta}
    own = {s[name]: place for name, place in places.items() if name in s}
    passed = tuple(number.xreplace(own) for number in poles(V, body_region(s)))
    description = potential_source.Description(request.text, request.domain, request.parameters, proof, poles=passed)
    return model_source.body_model(
        description, sympy.sympify(V), walls, pair=request.inertia == "pair", clamped=clamped
    )
