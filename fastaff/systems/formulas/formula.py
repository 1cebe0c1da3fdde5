"""Models written as one line of mathematics."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ...core.docstrings import inserts_parameters
from ...core.foreign import ForeignSystem, dispatch_adapter
from ...core.numbers import listed, positive, shown
from ...engine.kinds import OPTIONS, TERMS
from ...results.progress import says_progress
from ..models import Body
from ..models.contracts import FormulaBody, FormulaHamiltonian
from ..models.mechanics import system_of
from .arguments import checked_names, inertia_of, masses_of, text_of, values_of
from .drive import period_of
from .grammar import TIME, parse
from .hints import PULLED, hinted, no_terms_of_motion
from .laws import in_stretches, written_out
from .library import Request, generated_class
from .map_source import period_texts
from .options import rates_of, term_of
from .variables import VARIABLES

_SYMPY_LENGTH = 8000
"""Most characters of a formula that the package has written from parts or from a SymPy expression."""

TRIED = 32
"""Points at which a system's periods are tried."""

SAME = 1e-9
"""Relative change of its equations that counts as 0."""


Text = str | object
"""A formula as text; else an expression of SymPy, or a potential or expression of another tool."""


@says_progress
@hinted
@inserts_parameters
def affine_body(
    text: Text, /, *, mu: float | Sequence[float] = 1.0, domain: str | None = None, **parameters: float
) -> FormulaBody:
    """Make a body from its potential energy V, written as a formula.

    All derivatives are exact.

    Parameters
    ----------
    text : str or SymPy expression
        Potential energy V, either a formula or the name of a hyperelastic law in plane strain.

        * Variables of a formula: D1, D2; alpha, beta; r, vartheta; rho; x, y, z, u of phi = [[x, y], [z, u]]; a1, a2,
          b1, b2; in plane strain I1 = D1^2 + D2^2 + 1, I2 = J^2 + D1^2 + D2^2 and J = D1 D2, unless they are
          parameters. They may be mixed.
        * Grammar: numbers, pi, ``+ - * / **``, sqrt, exp, log, sin, cos, tan, sinh, cosh, tanh, asin, acos, atan, and
          gammainc(a, x), the regularised lower incomplete gamma function of a number a, 0 < a <= 4.
        * Laws and their parameters: "neo-hookean" (G, K), "mooney-rivlin" (c10, c01, K), "ogden" (a1, m1, a2, m2, ...,
          K), "yeoh" (c10, c20, c30, K), "arruda-boyce" (G, N, K), "gent" (G, Jm, K), "hencky" and
          "saint-venant-kirchhoff" (G, lam). G is the shear modulus.
    mu : float or pair of float, default 1
        Inertia, or a pair (mu_1, mu_2) for the kinetic energy T = (mu_1 (x'^2 + z'^2) + mu_2 (y'^2 + u'^2))/2.
    {formula_domain}
    {formula_parameters}

    Returns
    -------
    model
        If V depends on alpha and beta alone and `mu` is a number, a `Body`. Else a model of four degrees of freedom
        with the parameters and the inertia as fields. The potential of the `Body`, or the model, has the fields of the
        formula and the attributes formula, domain and proof (the proof of isotropy).

    Raises
    ------
    TypeError
        If `text` is neither a text nor an expression, or if a value is not a number.
    ValueError
        If the text is not a formula (no text is ever executed), a name has no value, or a value is not used. Also if V
        changes under D1 <-> D2, two names of one matrix.
    ImportError
        If SymPy is missing and the formula is new.

    Notes
    -----
    * Domain: by default the margin is the least argument of the logarithms and roots, and of those poles that have one
      sign for D1 > D2 > 0.
    * Accuracy: V and its derivatives are evaluated as written, accurate to round-off. Decimal numbers are exact while
      derivatives are taken.
    * Cost: as fast as a handwritten model. If V has no formula in beta^2, as cos(D1) + cos(D2), one evaluation costs
      four.
    * First use: about 1 s, minutes for hundreds of terms. Later uses in any process need milliseconds and no SymPy.
    * Another value of a parameter: ``body.potential._replace(C=2.0)`` compiles nothing.
    * A named potential, such as `Hyperelastic`, may have more angles and actions than its formula.

    References
    ----------
    Martens & Slawianowski, EQ2.0, EQ2.0b, EQ2.2c' (the variables); Meurer et al. 2017, PeerJ Comput. Sci. 3, e103
    (SymPy).

    Examples
    --------
    >>> body = fa.affine_body("C*(D1**2 + D2**2)/2", C=1.0)
    >>> body.potential.C, body.mu
    (1.0, 1.0)
    """
    no_terms_of_motion(parameters, text)
    law, letters = written_out(text, parameters)
    short, length = _written(law)
    written = in_stretches(short, letters)
    length += len(written) - len(short)
    domain = in_stretches(domain, letters) if isinstance(domain, str) else domain
    values = values_of(letters, VARIABLES, body=True)
    pair = isinstance(mu, (tuple, list)) or (isinstance(mu, np.ndarray) and mu.ndim > 0)
    inertia = inertia_of(mu) if pair else (positive("mu", mu),)
    request = Request(written, domain, tuple(values), (), "pair" if pair else "mu")
    cls: Any = _class(request, values, length)
    if cls.__name__ == "FormulaPotential":
        return cast(FormulaBody, Body(cls(**values), inertia[0]))
    return cls(*values.values(), *inertia)


@says_progress
@hinted
@inserts_parameters
def hamiltonian(
    text: Text,
    /,
    *,
    coordinates: str | Sequence[str] | None = None,
    momenta: str | Sequence[str] | None = None,
    periodic: Mapping[str, float | str] | None = None,
    masses: ArrayLike | None = None,
    domain: str | None = None,
    rotation: float | str | None = None,
    magnetic: float | str | None = None,
    vector_potential: Mapping[str, Text] | None = None,
    drive_period: float | str | None = None,
    friction: float | str | None = None,
    **parameters: float,
) -> FormulaHamiltonian:
    """Make a Hamiltonian system from a formula of its potential energy or of H.

    The energy is ``H = sum p_i^2/(2 m_i) + V(q)``. For a driven system, V is periodic in t. If you name the momenta,
    the text is the whole Hamiltonian, H(q, p) or H(q, p, t). All derivatives are exact.

    Parameters
    ----------
    text : str, SymPy expression or potential of another package
        Formula of V, or of H, in the grammar of `affine_body`. Also accepted:

        * an expression of heyoka;
        * a potential of gala, or its Hamiltonian in a rotating frame, in kpc, Myr and solar masses;
        * a potential of galpy, in its natural units.

        Objects of gala and galpy bring their own coordinates and parameters.
    coordinates : str or sequence of str, optional
        From 1 to 16 names. Default: "x y", or the coordinates of the other package's potential.
    momenta : str or sequence of str, optional
        Names of the momenta, if the text is the whole of H.
    periodic : dict of float or str, optional
        Periods of periodic coordinates, for example {"x": "2*pi"}: numbers or formulas of the parameters. States are
        not reduced to a period. A section such as "x=0" is taken modulo the period.
    masses : sequence of float, optional
        One mass for each coordinate. They become the fields m_1, m_2, ... of the model. Default: all masses are 1,
        without fields.
    {formula_domain}
    rotation : float or str, optional
        Rate Omega of a rotating frame of the first two coordinates x and y, in radians per unit time. H gets the term
        -Omega (x p_y - y p_x). The momenta are those of the inertial frame. V is constant in the rotating frame. The
        energy is Jacobi's integral.
    magnetic : float or str, optional
        Charge times magnetic field, e B, along x cross y, in the symmetric gauge: Omega = e B/(2 m), and V gets the
        term m Omega^2 (x^2 + y^2)/2. The momenta are canonical.
    vector_potential : dict of str, optional
        Charge times vector potential, e A, by coordinate, for example {"y": "B*x + k*x**2/2"}; other components are 0.
        With a drive it may depend on t. ``H = sum (p_i - e A_i)^2/(2 m_i) + V``, where V includes the charge and the
        speed of light is 1. The canonical momentum of x is p_x.
    drive_period : float or str, optional
        Period of a driven system. The text contains the time t. The rows are q, t, p, p_t, and T + V + p_t is
        conserved. Initial conditions of 2n rows have t = p_t = 0.
    friction : float or str, optional
        Rate g of dp/dt = -dV/dq - g p. The energy is not conserved, so it is not checked: energy_error is 0. Supported
        by `integrate`, `poincare_map`, `tangent_map` and `chaos_map`.
    {formula_parameters}

    Returns
    -------
    model
        Model with the methods of `HenonHeiles`. Its fields are the parameters, rotation, magnetic, friction, masses and
        period. A rate or drive period that is a formula of the parameters, such as "2*pi/w", is not a field. The
        angles for frequencies are the phase angles of (q_i, p_i).

    Raises
    ------
    TypeError
        If `text` or an option has a wrong type.
    ValueError
        If the text is not a formula (no text is ever executed), a name has no value, or a value is not used. Also if
        V(q, t) does not contain t or has another period, or if the equations do not have the periods.
    ImportError
        If SymPy is missing and the formula is new.

    Notes
    -----
    * H with momenta: H = T(p) + V(q) is separable if T has no poles and its minimum at p = 0. V includes the value of
      that minimum. A term -Omega (x p_y - y p_x) becomes `rotation`. Any other H requires GAUSS8, GAUSS16, DOP853 or
      VERNER9.
    * Drive: the time is taken modulo the period. Sections are `Stroboscopic`, such as "t=0", or do not depend on t,
      such as "x=0".
    * Friction: splitting methods are conformally symplectic and contract volume as exp(-n g t). The order of
      BLANES_MOAN6 and other schemes for a quadratic T falls.
    * Domain: by default the margin is the least argument of logarithms and roots, and of poles with one sign
      everywhere.

    References
    ----------
    Henon & Heiles 1964, Astron. J. 69, 73 (the example); Szebehely 1967, Theory of Orbits, chapter 1 (Jacobi's
    integral); McLachlan & Perlmutter 2001, J. Geom. Phys. 39, 276 (conformal Hamiltonian systems); Landau & Lifshitz,
    The Classical Theory of Fields, section 45 (Larmor's theorem); Meurer et al. 2017, PeerJ Comput. Sci. 3, e103
    (SymPy).

    Examples
    --------
    >>> model = fa.hamiltonian("(x**2 + y**2)/2 + lam*(x**2*y - y**3/3)", lam=1.0)
    >>> model.coordinates, model.potential_energy(1.0, 0.5)
    (('x', 'y'), 1.0833333333333333)
    >>> pendulum = fa.hamiltonian("-(1 + e*cos(t))*cos(x)", coordinates="x", drive_period="2*pi", e=0.1)
    >>> H = "(p1**2 + 2*p2**2 - 2*p1*p2*cos(q1 - q2))/(2 + 2*sin(q1 - q2)**2) - 2*cos(q1) - cos(q2)"
    >>> double = fa.hamiltonian(H, coordinates="q1 q2", momenta="p1 p2", periodic={"q1": "2*pi", "q2": "2*pi"})
    >>> float(double.energy(0.0, 0.0, 1.0, 0.5))
    -2.75
    """
    options: dict[str, Any] = {"rotation": rotation, "magnetic": magnetic, "friction": friction}
    given = dispatch_adapter("system", text)
    if given is not None:
        if momenta is not None:
            raise ValueError(f"momenta are for a whole H, this {type(text).__name__} is V alone: leave them out")
        beside: dict[str, Any] = {
            "masses": masses,
            "drive_period": drive_period,
            "domain": domain,
            "periodic": periodic,
        }
        beside |= {"vector_potential": vector_potential, **options}
        return _taken(given, coordinates, beside, parameters)
    written, length = _written(text)
    names = checked_names("coordinates", "x y" if coordinates is None else coordinates)
    inside: dict[str, float] = {}
    if vector_potential is not None:
        others = {"momenta": momenta, **options}
        written, momenta, inside = _charged(
            written, vector_potential, names, masses, others, (parameters, drive_period)
        )
        masses = None
        length = _SYMPY_LENGTH
    term = term_of(options, drive_period)
    if momenta is None:
        _check_rows(names, drive_period)
    conjugate = () if momenta is None else _momenta(momenta, names, {"masses": masses, **options})
    values = values_of(parameters, (*names, *conjugate, *([] if drive_period is None else [TIME]))) | inside
    weights = () if masses is None else masses_of(masses, len(names))
    own = period_texts(periodic, names)
    if drive_period is not None:
        return _driven((written, length), domain, values, (names, conjugate), weights, drive_period, own)
    rates = rates_of(options, values, names)
    if term is not None and term.planar and weights and weights[0] != weights[1]:
        raise ValueError(
            f"masses must be equal for {names[0]} and {names[1]} in a rotating frame, got {weights[0]} and {weights[1]}"
        )
    inertia = "unit" if masses is None else "masses"
    rows = (*own, *[""] * len(names)) if any(own) or conjugate else ()
    known: dict[str, Any] = {name: rates.pop(name, None) for name in OPTIONS if name in Request._fields}
    request = Request(written, domain, tuple(values), names, inertia, **known, momenta=conjugate, periods=rows)
    request = request._replace(others=tuple(rates.items()))
    return with_periods(_class(request, values, length)(*values.values(), *weights))


def _taken(given: ForeignSystem, coordinates: Any, beside: dict[str, Any], parameters: dict[str, float]) -> Any:
    """Return the system of another tool, with the user's options and parameters."""
    if given.coordinates and coordinates is not None and checked_names("coordinates", coordinates) != given.coordinates:
        plane = " (orbits that start in a plane of symmetry stay there)" if len(given.coordinates) > 2 else ""
        raise ValueError(
            f"coordinates must be left out for this potential, which has {listed(given.coordinates)}{plane}, got "
            f"{shown(coordinates)}"
        )
    own = {name: entry for name, entry in (("domain", given.domain), ("rotation", given.rotation)) if entry is not None}
    options = own | {name: entry for name, entry in beside.items() if entry is not None}
    values: dict[str, Any] = {**given.parameters, **parameters, **options}
    return hamiltonian(given.text, coordinates=given.coordinates or coordinates, **values)


def _check_rows(names: tuple[str, ...], period: Any) -> None:
    """Refuse a coordinate with the name of a momentum."""
    every = names if period is None else (*names, TIME)
    for name in every:
        if f"p_{name}" in names:
            raise ValueError(f"coordinate 'p_{name}' is taken by the momentum of {name}")


def _charged(
    V: str,
    potential: Any,
    names: tuple[str, ...],
    masses: Any,
    others: Mapping[str, Any],
    beside: tuple[Mapping[str, float], Any],
) -> tuple[str, tuple[str, ...], dict[str, float]]:
    """Return H of charges in a vector potential as text, its momenta, and the masses in it; others: arguments that do
    not go with that; beside: parameters, and the period if there is one.
    """
    given = [name for name, entry in others.items() if entry is not None]
    if given:
        instead = "write the whole of H with its momenta"
        if given[0] == "friction":
            instead = "make the model without it, then ode(model, forces={'x': '-g*(p_x - A_x)'}, ...), A_x written out"
        raise ValueError(f"{given[0]} does not go with vector_potential: {instead}")
    example = "{'y': 'B*x'}"
    if not isinstance(potential, Mapping):
        raise TypeError(f"vector_potential must be formulas by coordinate such as {example}, got {shown(potential)}")
    wrong = [name for name in potential if name not in names]
    if wrong or not potential:
        raise ValueError(f"vector_potential must be of {listed(names)}, as {example}, got {shown(dict(potential))}")
    parameters, period = beside
    terms = []
    weights = {} if masses is None else {f"m_{i + 1}": m for i, m in enumerate(masses_of(masses, len(names)))}
    variables = (*names, *([] if period is None else [TIME]))
    parse(V, variables, parameters, length=_SYMPY_LENGTH)
    for name, mass in zip(names, [*weights] or [""] * len(names), strict=True):
        p = f"p_{name}"
        entry = potential.get(name)
        argument = f"vector_potential[{name!r}]"
        if name in potential:
            try:
                field = text_of(entry)
            except TypeError:
                raise TypeError(f"{argument} must be a formula such as 'B*x', got {shown(entry)}") from None
            parse(field, variables, parameters, argument=argument, length=_SYMPY_LENGTH)
            p = f"({p} - ({field}))"
        terms.append(f"{p}**2/(2*{mass})" if mass else f"{p}**2/2")
    return f"{' + '.join(terms)} + ({V})", tuple(f"p_{name}" for name in names), weights


def _driven(
    text: tuple[str, int],
    domain: str | None,
    values: dict[str, float],
    rows: tuple[tuple[str, ...], tuple[str, ...]],
    weights: tuple[float, ...],
    period: Any,
    periods: tuple[str, ...],
) -> Any:
    """Return the driven system of a text with its largest length, with rows of these names and periods."""
    written, length = text
    names, momenta = rows
    if TIME in names:
        raise ValueError(f"coordinates must not contain {TIME}, the time of a driven system")
    said = period if isinstance(period, str) else ""
    inertia = "masses" if weights else "unit"
    own = (*periods, *[""] * (len(names) + 2)) if any(periods) or momenta else ()
    every = (*names, TIME)
    request = Request(written, domain, tuple(values), every, inertia, period=said, momenta=momenta, periods=own)
    number = period_of(request, period, values, length)
    cls: Any = _class(request, values, length)
    return with_periods(cls(*values.values(), *weights, *([] if said else [number])))


def _momenta(momenta: Any, names: tuple[str, ...], others: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of momenta in the text, one for each coordinate; others: arguments that do not go with them."""
    for name, entry in others.items():
        if entry is not None and name in OPTIONS and "loss" in TERMS[OPTIONS[name]].words:
            raise ValueError(f"{name} must be given without momenta, as it is no part of H. {PULLED}")
        if entry is not None:
            raise ValueError(f"{name} does not go with momenta in the text: write the whole of H(q, p)")
    found = checked_names("momenta", momenta, names)
    if len(found) != len(names):
        raise ValueError(
            f"momenta must be {len(names)} names, one for each coordinate of {listed(names)}; got {listed(found)}"
        )
    return found


def with_periods(model: Any) -> Any:
    """Return a model if its equations have the stated periods of its coordinates."""
    system = system_of(model)
    periods = np.array(model.periods(), dtype=float)[:, None] if hasattr(model, "periods") else np.zeros((1, 1))
    if not (np.isfinite(periods) & (periods >= 0)).all():
        raise ValueError(f"periodic must be positive, got {periods[:, 0].tolist()}")
    random = np.random.default_rng(5)
    slopes = system.slopes
    z = random.uniform(-1, 1, (system.rows, TRIED)) * np.where(periods > 0, periods / 2, 1.5)
    for row in np.flatnonzero(periods[:, 0] > 0):
        here = slopes(z)
        there = slopes(z + periods * (np.arange(len(periods)) == row)[:, None])
        with np.errstate(all="ignore"):  # where they are infinite
            off = np.abs(here - there) > SAME * (np.abs(here) + np.abs(there) + np.abs(here).max(axis=0))
        if off.any():
            raise ValueError(
                f"periodic[{shown(model.coordinates[row])}] must be a period of the system, got "
                f"{periods[row, 0]:.9g}, over which its equations change"
            )
    return model


def _written(text: Any) -> tuple[str, int]:
    """Return a formula as text, and its largest length; ValueError for equations, which are of `ode`."""
    if isinstance(text, str) and re.search(r"\w\s*'+\s*=", text):
        raise ValueError(f"text must be an energy, got equations {shown(text, 60)}. Use fa.ode(text).")
    return text_of(text), 2000 if isinstance(text, str) else _SYMPY_LENGTH


def _class(request: Request, values: dict[str, float], length: int) -> type:
    """Check the formula and its domain; return the class."""
    programs = request.program(length), request.domain_program()
    used = programs[0].names | (programs[1].names if programs[1] is not None else frozenset())
    used = used.union(*(program.names for program in request.option_programs().values()))
    used = used.union(*(program.names for program in request.period_programs() if program is not None))
    if request.period:
        used |= parse(request.period, (), request.parameters, argument="drive_period").names
    unused = [name for name in values if name not in used]
    if unused:
        raise ValueError(f"parameter {shown(unused[0])} must be a name in the formula, got {shown(request.text)}")
    return generated_class(request, programs, values)
