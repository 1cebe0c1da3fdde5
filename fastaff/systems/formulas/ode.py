"""Autonomous systems of ordinary differential equations written as text: x' = s*(y - x); y' = ..."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ...core.docstrings import inserts_parameters
from ...core.foreign import call_for
from ...core.numbers import real, shown
from ...results.progress import says_progress
from ..models.contracts import FormulaODE
from .arguments import text_of
from .equations import split
from .forced import equations as equations_of
from .forced import periods_of
from .formula import Text, with_periods
from .grammar import checked_name
from .library import Request, generated_class
from .map_source import period_texts
from .reserved import WITHOUT_BODY
from .second_order import first_order

LENGTH = 2000
"""Most characters of a text, and of each equation that is an expression."""

DRIVE = "drive_period"
"""Argument of `hamiltonian` for its time."""

TIMED = "Try a variable t with t' = 1, periodic={'t': '2*pi/w'}"
"""Hint for equations with the time: the section t=0 then counts each period."""


@says_progress
@inserts_parameters
def ode(
    text: Text,
    /,
    *,
    domain: str | None = None,
    forces: Mapping[str, str] | None = None,
    periodic: Mapping[str, float | str] | None = None,
    **parameters: float,
) -> FormulaODE:
    """Make an autonomous system dz/dt = f(z) from equations; the derivatives are exact.

    Parameters
    ----------
    text : str, dict, sequence of pairs or model
        Equations of 1 to 16 variables, in one of these forms:

        * a text with one equation for each variable, x' = ... or dx/dt = ..., separated by semicolons or line breaks,
          in the grammar of `affine_body`. An equation x'' = ... of x and x' becomes two, of x and its velocity v_x;
        * variables with their right-hand sides as expressions of SymPy or heyoka, {x: ...} or [(x, ...), ...]. The
          parameter par[0] of heyoka becomes par_0;
        * a model: a result of `hamiltonian`, a named system H(q, p), `HenonHeiles`, a `Body` of a named potential, or
          an `affine_body` of D1 and D2. Its rows are q, p; for a body the stretches D1, D2, p_D1, p_D2.
    domain : str, optional
        Formula that is positive inside the domain. Default for a model: its own domain.
    forces : dict of str, optional
        Additional forces on a model, by coordinate, for example {"x": "f*cos(w*t) - g*p_x"}. The time may occur only as
        cos(w*t) and sin(w*t), which become two more rows, cosine and sine.
    periodic : dict of float or str, optional
        Periods of periodic variables, for example {"x": "2*pi"}: numbers or formulas of the parameters. A section x=c
        counts each turn. Default for a model: its own periods.
    {formula_parameters}

    Returns
    -------
    model
        System with the methods rates(z...) and tangent_rates(z..., dz...). Its fields are the parameters. Its
        coordinates are the variables in the order of the equations, which is the order of the rows of all states.

    Raises
    ------
    TypeError
        If `text` is of another kind, or if a value is not a number.
    ValueError
        If the text is not a system of equations (no text is ever executed), a name has no value, or a value is not
        used. Also if the equations do not have the periods.
    ImportError
        If SymPy is missing and the text is new.

    Notes
    -----
    * Methods: Runge-Kutta schemes only. Default: DOP853. VERNER9, and RK4 with a step, are available too.
    * Supported: `integrate`, `poincare_map` with sections x=c and `Hyperplane`, `tangent_map`, and `chaos_map` with
      indicators of deviation vectors.
    * Accuracy: there is no energy, so energy_error is 0. Check conserved quantities yourself.
    * Memory: a state of an odd number of variables needs the memory of one more.

    References
    ----------
    Lorenz 1963, J. Atmos. Sci. 20, 130, for one; Meurer et al. 2017, PeerJ Comput. Sci. 3, e103 (SymPy).

    Examples
    --------
    >>> lorenz = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
    >>> lorenz.coordinates, lorenz.rates(1.0, 1.0, 1.0)
    (('x', 'y', 'z'), (-0.0, 26.0, -1.6666666666666665))
    >>> fa.ode("x'' = m*(1 - x**2)*x' - x", m=1.0).formula
    "x' = v_x; v_x' = m*(1 - x**2)*v_x - x"
    >>> sheet = fa.affine_body("gent", G=1.0, Jm=4.0, K=2.0)
    >>> pulled = fa.ode(sheet, forces={"D1": "f*cos(w*t) - g*p_D1", "D2": "-g*p_D2"}, f=0.1, g=0.1, w=1.2)
    >>> pulled.coordinates
    ('D1', 'D2', 'p_D1', 'p_D2', 'cosine', 'sine')
    """
    if forces is not None or hasattr(text, "degrees_of_freedom"):
        turned = periods_of(text)
        text, own, parameters = equations_of(text, {} if forces is None else forces, parameters)
        domain = own if domain is None else domain
        periodic = turned if periodic is None else periodic
    written, length = _written(text)
    equations = split(written)
    if DRIVE in parameters and not re.search(rf"\b{DRIVE}\b", f"{written} {domain}"):
        raise ValueError(f"{DRIVE} must be left out for an ODE system, got {shown(parameters[DRIVE])}. {TIMED}.")
    names: list[str] = []
    for name, _ in equations:
        names.append(checked_name(name, "variable", {*names, *WITHOUT_BODY}))
    values = {
        checked_name(name, "parameter", {*names, *WITHOUT_BODY}): real(name, value)
        for name, value in parameters.items()
    }
    for name, side in equations:
        if re.search(r"\bt\b", side) and "t" not in (*names, *values):
            raise ValueError(f"text: {name}' must not depend on t. {TIMED}.")
    turns = period_texts(periodic, names)
    request = Request(written, domain, tuple(values), tuple(names), "ode", periods=turns if any(turns) else ())
    programs = request.programs(length)
    domain_program = request.domain_program()
    every = (*programs, domain_program, *request.period_programs())
    used = frozenset().union(*(p.names for p in every if p is not None))
    unused = [name for name in values if name not in used]
    if unused:
        raise ValueError(f"parameter {shown(unused[0])} must be a name in the equations, got {shown(written)}")
    return with_periods(generated_class(request, (programs, domain_program), values)(*values.values()))


def _written(given: Any) -> tuple[Any, int]:
    """Return equations as text, and their largest length."""
    if isinstance(given, str):
        return first_order(given), LENGTH
    listed = list(given.items()) if isinstance(given, Mapping) else given
    if not isinstance(listed, (list, tuple)) or not all(isinstance(e, tuple) and len(e) == 2 for e in listed):
        raise TypeError(
            f"text must be equations such as \"x' = y; y' = -x\" or pairs (variable, expression), got {shown(given)} "
            f"({type(given).__name__}){call_for(given)}"
        )
    sides = [[text_of(entry) for entry in pair] for pair in listed]
    return "; ".join(f"{name}' = {side}" for name, side in sides), LENGTH * max(1, len(sides))
