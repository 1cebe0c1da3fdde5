"""Source text of whole models: velocity, force, tangent force, energies, margin and angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...engine.kinds import TERMS
from .centres import kept, shifted
from .inertia import KineticSide, driven_inertia, fresh, mass_inertia, plane_inertia
from .potential_source import Description, class_text, constant, margin_method, method, module, poles_methods
from .printing import Assignments

HALF = 0.7071067811865476
"""Square root of 1/2."""

_LINEAR = {
    "x": (("a1", 1), ("b1", 1)),
    "u": (("a1", 1), ("b1", -1)),
    "z": (("a2", 1), ("b2", 1)),
    "y": (("b2", 1), ("a2", -1)),
}
_PLANE = {"A": ("a1", "a2"), "B": ("b1", "b2"), "alpha": ("a1", "a2"), "beta": ("b1", "b2")}
_CLAMP = 2.0**-34
"""Least square below a root, where the root's derivative would be infinite."""


class _Inner:
    """The symbols in V, as functions of the coordinates."""

    def __init__(self, V: Sequence[Any], coordinates: Sequence[str], clamped: Sequence[str]):
        import sympy

        present = {s.name: s for e in V for s in e.free_symbols if not s.name.startswith("self.")}
        self.coordinates = tuple(coordinates)
        self.clamped = clamped
        self.symbols = {name: present[name] for name in sorted(present)}
        self.differentials = dict(zip(coordinates, fresh("d", coordinates, tuple(present)), strict=True))
        self.d = {n: sympy.Symbol(self.differentials.get(n, f"d{n}"), real=True) for n in self.symbols}
        self.real = {c: sympy.Symbol(c, real=True) for c in coordinates}
        self.outer_d = {c: sympy.Symbol(self.differentials[c], real=True) for c in coordinates}
        self.body = tuple(coordinates) == ("a1", "a2", "b1", "b2")

    def derived(self) -> list[str]:
        """Return the names of symbols other than coordinates."""
        return [n for n in self.symbols if n not in self.coordinates]

    def reach(self, name: str) -> tuple[str, ...]:
        """Return the coordinates that a symbol depends on."""
        if name in self.coordinates:
            return (name,)
        return _PLANE[name] if name in _PLANE else tuple(c for c, _ in _LINEAR[name])

    def lines(self, tangent: bool, *, clamp: bool = True) -> list[str]:
        """Return the assignments of the inner symbols, and of their differentials."""
        found = []
        for name in self.derived():
            if name in _LINEAR:
                (one, _), (other, t) = _LINEAR[name]
                found.append(f"{name} = {HALF!r}*({one} {'-' if t < 0 else '+'} {other})")
                if tangent:
                    found.append(f"d{name} = {HALF!r}*(d{one} {'-' if t < 0 else '+'} d{other})")
                continue
            c, e = _PLANE[name]
            square = f"{c}*{c} + {e}*{e}"
            if name in ("A", "B"):
                found.append(f"{name} = {square}")
                if tangent:
                    found.append(f"d{name} = 2*({c}*d{c} + {e}*d{e})")
            else:
                kept = f"np.maximum({square}, {_CLAMP!r})" if clamp and name in self.clamped else square
                found.append(f"{name} = np.sqrt({kept})")
                if tangent:
                    found.append(f"d{name} = ({c}*d{c} + {e}*d{e})/{name}")
        return found

    def pull(self, slopes: Mapping[str, Any], changes: Mapping[str, Any] | None) -> list[Any]:
        """Return minus the gradient in the coordinates, or minus its change, from the slopes in the inner symbols."""
        import sympy

        own = slopes if changes is None else changes
        total = {c: own.get(c, sympy.Integer(0)) for c in self.coordinates}
        root = sympy.sqrt(2) / 2
        linear: dict[str, Any] = {}
        for name, entries in _LINEAR.items():
            if self.body and name in self.derived():
                for c, sign in entries:
                    linear[c] = linear.get(c, 0) + sign * own[name]
        for c, e in linear.items():
            total[c] += root * e
        for name in self.derived():
            if name in _PLANE:
                symbol = self.symbols[name]
                slope = slopes[name]
                factor = 2 * slope if name in ("A", "B") else slope / symbol
                for c in _PLANE[name]:
                    q = self.real[c]
                    if changes is None:
                        total[c] += factor * q
                    else:
                        change = (
                            2 * changes[name]
                            if name in ("A", "B")
                            else (changes[name] - factor * self.d[name]) / symbol
                        )
                        total[c] += change * q + factor * self.outer_d[c]
        return [-total[c] for c in self.coordinates]


def model(
    name: str,
    what: str,
    d: Description,
    V: Any,
    walls: Sequence[Any],
    inertia: KineticSide,
    *,
    clamped: Sequence[str],
    angles: str,
    imports: str = "",
    before: str = "",
    more: Sequence[str] = (),
) -> str:
    """Return the text of a model of any number of degrees of freedom, with the tangent force as one Hessian-vector
    product.
    """
    q = d.coordinates
    V = shifted(V, d.centres)
    inner = _Inner([V], q, clamped)
    slopes = {n: V.diff(symbol) for n, symbol in inner.symbols.items()}
    changes = {n: sum(slopes[n].diff(inner.symbols[m]) * inner.d[m] for m in inner.symbols) for n in inner.symbols}
    momenta = fresh("p", q, ()) if not inner.body else ("pa1", "pa2", "pb1", "pb2")
    dq = tuple(inner.differentials[c] for c in q)
    taken = (*q, *dq, *momenta, *inner.symbols, *(f"d{n}" for n in inner.symbols))

    def lines(tangent: bool = False) -> Assignments:
        begun = Assignments(taken)
        begun.lines += inner.lines(tangent)
        return begun

    def filled(texts: Sequence[str], expressions: Sequence[Any]) -> list[str]:
        vary = {*inner.real.values(), *inner.symbols.values(), *inner.d.values(), *inner.outer_d.values()}
        return [t if e.free_symbols & vary else f"{t} + 0.0*{c}" for t, e, c in zip(texts, expressions, q, strict=True)]

    kinetic = Assignments(taken)
    dp = fresh("d", momenta, ())
    kinetic.lines += inertia.lines
    methods = [
        constant("degrees_of_freedom", f"Return {len(q)}.", str(len(q))),
        constant("coordinates", f"Names of the first {len(q)} rows of z.", repr(tuple(q))),
        constant("angles", "Angle variables natural to this system.", angles),
        method("velocity", momenta, "Return dq/dt.", kinetic, inertia.velocity),
        method("kinetic_energy", momenta, "Return T.", kinetic, [inertia.kinetic], single=True),
    ]
    if inertia.tangent:
        doc = f"Return the change of the velocity along ({', '.join(dp)})."
        methods.append(method("tangent_velocity", (*momenta, *dp), doc, kinetic, inertia.tangent))
    work = lines()
    force = inner.pull(slopes, None)
    methods.append(
        method("force", q, "Return dp/dt = -grad V.", work, filled(work.add(kept(work, force, d.centres)), force))
    )
    work = lines(True)
    tangent = inner.pull(slopes, changes)
    doc = "Return the change of the force along " + f"({', '.join(dq)}): minus the Hessian of V times that vector."
    methods.append(
        method(
            "tangent_force",
            (*q, *dq),
            doc,
            work,
            filled(work.add(kept(work, tangent, d.centres, least=False)), tangent),
        )
    )
    work = Assignments(taken)
    work.lines += inner.lines(False, clamp=False)
    texts = work.add(kept(work, [V], d.centres))
    value = texts[0] if V.free_symbols & set(inner.symbols.values()) else f"{texts[0]} + 0.0*({' + '.join(q)})"
    methods.append(method("potential_energy", q, "Return V.", work, [value], single=True))
    methods += [_margin(walls, q, taken), *more]
    return module(d, before + class_text(name, what, d, (*d.parameters, *inertia.fields), methods), imports)


def _margin(walls: Sequence[Any], q: Sequence[str], taken: Sequence[str]) -> str:
    work = Assignments(taken)
    if not walls:
        return margin_method([], q, work)
    inner = _Inner(walls, q, ())
    work.lines += inner.lines(False, clamp=False)
    covered = {c for name in inner.symbols for c in inner.reach(name)} >= set(q)
    return margin_method(walls, q, work, covered=covered)


_LOOPS = '''\
class Loops(NamedTuple):
    """Loops in the coordinate planes (q_i, p_i){about}."""
{field}
    names = {names!r}
    planes = {planes!r}

    def signals(self, {row}):
        """Return Re Q, Im Q, Re P, Im P of each angle in turn."""
        zero = 0.0*{first}
{phase}        return {signals}


'''


def loops(coordinates: Sequence[str], *, time: bool = False) -> str:
    """Return the text of angle variables of loops in (q_i, p_i), one for each coordinate; time: the last coordinate is
    the time, whose loop is that of the drive's phase.
    """
    n = range(len(coordinates))
    q, p = ([f"{stem}{i}" for i in n] for stem in ("q", "p"))
    signals = [f"{q[i]}, zero, {p[i]}, zero" for i in n]
    if time:
        signals[-1] = "c, zero, -self.omega*s, zero"
    return _LOOPS.format(
        about=" and of the drive's phase" if time else "",
        field="\n    omega: float\n" if time else "",
        phase=f"        c, s = np.cos(self.omega*{q[-1]}), np.sin(self.omega*{q[-1]})\n" if time else "",
        names=tuple(coordinates),
        planes=(False,) * len(n),
        first=q[0],
        row=", ".join((*q, *p)),
        signals=", ".join(signals),
    )


def body_model(d: Description, V: Any, walls: Sequence[Any], *, pair: bool, clamped: Sequence[str]) -> str:
    """Return the text of a body in the two planes with any potential."""
    d = d._replace(coordinates=("a1", "a2", "b1", "b2"))
    what = "a planar affinely-rigid body" + (" with inertia diag(mu_1, mu_2) in the material frame" if pair else "")
    return model(
        "FormulaBody",
        what,
        d,
        V,
        walls,
        plane_inertia(pair),
        clamped=clamped,
        angles="AreaTrace()",
        imports="\nfrom fastaff.systems.models.angles import AreaTrace\n",
        more=poles_methods(d.poles, d.coordinates),
    )


def hamiltonian_model(
    d: Description,
    V: Any,
    walls: Sequence[Any],
    *,
    masses: bool,
    term: str | None = None,
    rate: Any = None,
    inertia: KineticSide | None = None,
    periods: Sequence[Any] = (),
    momenta: Sequence[str] = (),
    poles: Sequence[Any] = (),
) -> str:
    """Return the text of a system of particles on lines: T = sum p_i^2/2 m_i + V(q), or T of an inertia, perhaps with a
    further term (`engine.kinds.TERMS`) of that rate; periods: of its rows, if it has some; momenta: their names, if
    they have some; poles: expressions that pass a whole number at those of V.
    """
    more: Sequence[str] = ()
    if term is not None:
        work = Assignments(())
        entry = TERMS[term]
        (text,) = work.add([rate])
        named = method(entry.rate, (), f"Return the rate: {entry.does}.", work, [f"1.0*({text})"], single=True)
        more = constant("kind", f"{entry.equations}.", f"alone({term!r})"), named
    what = f"{len(d.coordinates)} degrees of freedom, {_kinetic(masses, inertia)}"
    return model(
        "FormulaHamiltonian",
        what,
        d,
        V,
        walls,
        inertia or mass_inertia(d.coordinates, masses, len(d.coordinates)),
        clamped=(),
        angles="Loops()",
        before=loops(d.coordinates),
        imports="\nfrom fastaff.engine.kinds import alone\n" if more else "",
        more=[*more, *periods_methods(periods), *_names_of(momenta), *poles_methods(poles, d.coordinates)],
    )


def driven_model(
    d: Description,
    V: Any,
    walls: Sequence[Any],
    period: Any,
    *,
    masses: bool,
    inertia: KineticSide | None = None,
    periods: Sequence[Any] = (),
    momenta: Sequence[str] = (),
    poles: Sequence[Any] = (),
) -> str:
    """Return the text of a driven system of particles on lines: T = sum p_i^2/2 m_i + V(q, t), or T of an inertia, in
    the phase space extended by the time, the last coordinate, and its momentum. period: "" if it is a
    field.
    """
    *own, time = d.coordinates
    inertia = inertia or mass_inertia(d.coordinates, masses, len(own))
    fields, more = period_methods(time, period, inertia.fields)
    inertia = inertia._replace(fields=fields)
    more += [constant("kind", "What the motion is made of.", "Kind.DRIVEN"), *periods_methods(periods)]
    more += _names_of((*momenta, "p_t") if momenta else ()) + poles_methods(poles, d.coordinates)
    return model(
        "FormulaHamiltonian",
        f"{len(own)} driven degrees of freedom, {_kinetic(masses, inertia)}",
        d,
        V,
        walls,
        driven_inertia(inertia, d.coordinates),
        clamped=(),
        angles="Loops(2*np.pi/self.period)",
        imports="\nfrom fastaff.systems.models.contracts import Kind\n",
        before=loops(d.coordinates, time=True),
        more=more,
    )


def _kinetic(masses: bool, inertia: KineticSide | None) -> str:
    """Return the words for the kinetic energy of a system of particles on lines."""
    return "T(p)" if inertia and inertia.tangent else f"T = {'sum p_i^2/2 m_i' if masses else '|p|^2/2'}"


def period_methods(time: str, period: Any, fields: Sequence[str]) -> tuple[tuple[str, ...], list[str]]:
    """Return the fields of a driven system, and its methods: `period`, unless that is a field, and `phase`."""
    lines = Assignments((time,))
    if period == "":
        fields = (*fields, "period")
        text = "self.period"
        more = []
    else:
        text = lines.text(period)
        more = [method("period", (), "Return the period of the drive.", lines, [text], single=True)]
        more = [f"@property\n{more[0]}"]
    doc = "Return the time reduced by whole periods."
    more.append(method("phase", (time,), doc, lines, [f"{time} - ({text})*np.floor({time}/({text}))"], single=True))
    return tuple(fields), more


def periods_methods(periods: Sequence[Any]) -> list[str]:
    """Return the method of the periods of the rows where some have one."""
    lines = Assignments(())
    doc = "Return the period of each row, 0 where it has none."
    return [method("periods", (), doc, lines, lines.add(periods))] if any(p != 0 for p in periods) else []


def _names_of(momenta: Sequence[str]) -> list[str]:
    """Return the constant of the names of momenta where they have some."""
    doc = f"Names of the last {len(momenta)} rows of z."
    return [constant("momenta", doc, repr(tuple(momenta)))] if momenta else []
