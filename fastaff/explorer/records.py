"""Models as records: their methods in JavaScript, and the properties of their rows that the page needs."""

from __future__ import annotations

from typing import Any

from ..core.numbers import kind_of
from ..systems.models.angles import Coordinates2
from ..systems.models.mechanics import System
from .javascript import Refused, ScriptPart, printed
from .loops import loops_of, turns_around
from .parameters import fields_of, numbers_in


def model_code(system: System) -> dict[str, Any]:
    """Return a model as data that `system.js` makes the text of a worker of.

    Returns kind ("body", "plane", "driven", "map" or "equations"), n, parameters (names, in the order of
    `parameter_values`) and methods, each with its lines and results in JavaScript. Raises TypeError for a model that
    the explorer has no sections of, or whose methods have no source, or a construct outside of the whitelist:
    arithmetic, elementary functions of numpy, tuples, assignments, conditions, calls of the model's own methods.
    """
    if system.iterated:
        return _map_code(system)
    if system.own is not None and not system.frame:
        raise Refused(
            f"model {kind_of(system.model)} {system.own.has}: it has no page; poincare_map computes its section"
        )
    if system.frame or not system.newtonian:
        return _equations_code(system)
    n = system.n
    kind = "body" if system.isotropic else "driven" if system.driven else "plane"
    if kind == "driven" and n != 2:
        raise _too_many("have one coordinate beside its time for a page", system)
    if n != (4 if kind == "body" else 2):
        raise _too_many("be a body with a doubly isotropic potential, or have two coordinates", system)
    q, p, d = ([f"{stem}{i}" for i in range(n)] for stem in "qpd")
    own = ScriptPart(system.model, ())
    wanted: list[tuple[str, ScriptPart, str, list[str]]] = [
        ("velocity", own, "velocity", p),
        ("force", own, "force", q),
        ("kinetic", own, "kinetic_energy", p),
        ("potential", own, "potential_energy", q),
        ("margin", own, "margin", q),
    ]
    if kind == "body":
        inner = ScriptPart(system.model.potential, ("potential",))
        wanted += [("V", inner, "value", ["A", "B"]), ("inside", inner, "margin", ["A", "B"])]
    if hasattr(system.model, "tangent_force") and system.quadratic:
        wanted.append(("tangent", own, "tangent_force", [*q, *d]))
    names = [name for name, _ in numbers_in(system.model, ())]
    methods = {key: printed(part, name, arguments, names) for key, part, name, arguments in wanted}
    if kind == "driven":
        own_period = {"lines": [], "results": ["$period"]}
        methods["period"] = own_period if "period" in fields_of(system.model) else printed(own, "period", [], names)
        methods["signals"] = printed(ScriptPart(Coordinates2(), ()), "signals", [*q, *p], [])
        winds = [turns_around(system.model), False]
        return {"kind": kind, "n": n, "parameters": names, "angles": ["x"], "winds": winds, "methods": methods}
    angles = loops_of(system)
    methods["signals"] = printed(ScriptPart(angles, ()), "signals", [*q, *p], [])
    return {"kind": kind, "n": n, "parameters": names, "angles": list(angles.names), "methods": methods}


def _too_many(takes: str, system: System) -> Refused:
    """Return the refusal of a system with another number of coordinates than a page draws."""
    names = system.names[: system.moving]
    where = "t=0" if system.driven else f"{names[0]}=0"
    kind = kind_of(system.model)
    return Refused(f"model must {takes}, got {kind} with {len(names)}. Try fa.poincare_map with section='{where}'.")


def _map_code(system: System) -> dict[str, Any]:
    """Return a map as data: winds (2n,) is true for rows with a period; one variable has an idle row beside it."""
    n = system.n
    own = ScriptPart(system.model, ())
    rows = [f"{stem}{i}" for stem in "qp" for i in range(n)][: system.rows]
    names = [name for name, _ in numbers_in(system.model, ())]
    wanted: tuple[tuple[str, str, list[str]], ...] = (
        ("iterate", "iterate", rows),
        ("tangent", "tangent_iterate", [*rows, *(f"d{r}" for r in range(system.rows))]),
        ("periods", "periods", []),
        ("margin", "margin", rows[:n]),
    )
    methods = {key: printed(own, name, arguments, names) for key, name, arguments in wanted}
    angles = list(system.names)
    winds = [float(period) > 0 for period in system.model.periods()]
    line = system.rows == 1
    if line:
        winds.append(False)
        for key in ("iterate", "tangent", "periods"):
            methods[key]["results"].append("0")
    return {
        "kind": "map",
        "n": n,
        "line": line,
        "parameters": names,
        "angles": angles,
        "winds": winds,
        "methods": methods,
    }


class TurningFrameMethods:
    """Methods of H(q, p) = T + V - w (x p_y - y p_x) for a model whose frame turns."""

    def rates(self: Any, x, y, p_x, p_y):
        """Return dH/dp and -dH/dq."""
        w = self.angular_velocity()
        v_x, v_y = self.velocity(p_x, p_y)
        f_x, f_y = self.force(x, y)
        return v_x + w * y, v_y - w * x, f_x + w * p_y, f_y - w * p_x

    def tangent_rates(self: Any, x, y, p_x, p_y, dx, dy, dp_x, dp_y):
        """Return their change along a vector: T is quadratic."""
        w = self.angular_velocity()
        v_x, v_y = self.velocity(dp_x, dp_y)
        f_x, f_y = self.tangent_force(x, y, dx, dy)
        return v_x + w * dy, v_y - w * dx, f_x + w * dp_y, f_y - w * dp_x

    def energy(self: Any, x, y, p_x, p_y):
        """Return H."""
        w = self.angular_velocity()
        return self.kinetic_energy(p_x, p_y) + self.potential_energy(x, y) - w * (x * p_y - y * p_x)


class Curved:
    """Methods of H(q, p) for a model of two coordinates whose T is not quadratic."""

    def rates(self: Any, x, y, p_x, p_y):
        """Return dH/dp and -dH/dq."""
        v_x, v_y = self.velocity(p_x, p_y)
        f_x, f_y = self.force(x, y)
        return v_x, v_y, f_x, f_y

    def tangent_rates(self: Any, x, y, p_x, p_y, dx, dy, dp_x, dp_y):
        """Return their change along a vector."""
        v_x, v_y = self.tangent_velocity(p_x, p_y, dp_x, dp_y)
        f_x, f_y = self.tangent_force(x, y, dx, dy)
        return v_x, v_y, f_x, f_y

    def energy(self: Any, x, y, p_x, p_y):
        """Return H, without p_t of a driven model, whose page shows no energy."""
        return self.kinetic_energy(p_x, p_y) + self.potential_energy(x, y)


def _equations_code(system: System) -> dict[str, Any]:
    """Return dz/dt = f(z) as data: rows, whether they are coordinates and momenta with an energy, winds (rows,)."""
    names = [name for name, _ in numbers_in(system.model, ())]
    methods_of = TurningFrameMethods if system.frame else Curved if system.nonquadratic else None
    whole = (
        system.model
        if methods_of is None
        else type(type(system.model).__name__, (methods_of, type(system.model)), {})(*system.model)
    )
    own = ScriptPart(whole, ())
    if system.canonical and system.n != 2:
        raise _too_many("have two coordinates, or one beside its time", system)
    if not system.canonical and system.rows < 3:
        raise Refused(
            f"model must have 3 variables or more to have a section, {kind_of(system.model)} has {system.rows}"
        )
    rows = [f"q{r}" for r in range(system.rows)]
    wanted = [("rates", "rates", rows), ("tangent", "tangent_rates", [*rows, *(f"d{r}" for r in range(system.rows))])]
    wanted += [("margin", "margin", rows[: system.positions])]
    wanted += [("energy", "energy", rows)] if system.canonical else []
    methods = {key: printed(own, name, arguments, names) for key, name, arguments in wanted}
    still = {"lines": [], "results": ["0"] * system.rows}
    methods["periods"] = printed(own, "periods", [], names) if hasattr(system.model, "periods") else still
    if system.driven:
        kept = {"lines": [], "results": ["$period"]}
        methods["period"] = kept if "period" in fields_of(system.model) else printed(own, "period", [], names)
    winds = [period > 0 for period in system.periods]
    winds += [False] * (system.rows - len(winds))
    angles = list(system.names[: system.moving]) if system.canonical else []
    facts = {"canonical": system.canonical and not system.driven, "driven": system.driven, "winds": winds}
    n = system.n if system.canonical else system.rows
    return {"kind": "equations", "n": n, "rows": system.rows, **facts, "parameters": names, "angles": angles} | {
        "methods": methods
    }
