"""Maps as models, from a text."""

from __future__ import annotations

import functools
import hashlib
import json
import math
import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.foreign import dispatch_adapter
from ...core.interruption import imported
from ...core.numbers import listed, shown
from ...engine import code_folder
from ...engine.values import told_apart
from ...results.progress import says_progress
from ..models.contracts import FormulaMap
from .arguments import checked_names, values_of
from .formula import Text
from .grammar import CONSTANTS, NUMERIC, Program, parse
from .library import CLASSES, brief, loaded, rebuild
from .map_source import TAG, MapRequest, Statements, class_of_map, pairs, period_texts, statements
from .matrix_map import checked_matrix, entries, is_matrix, names_of, text_of_matrix

TRIED = 400
"""Number of points around the origin, and of points farther away, at which a map is tried."""

SAME = 1e-10
"""Relative rounding error of images a period apart."""


@says_progress
@inserts_parameters
def iterated_map(
    text: Text,
    /,
    *,
    coordinates: str | Sequence[str] | None = None,
    momenta: str | Sequence[str] | None = None,
    periodic: Mapping[str, float | str] | None = None,
    domain: str | None = None,
    **parameters: float,
) -> FormulaMap:
    """Make a map from its equations, written as text; its derivative is exact.

    Parameters
    ----------
    text : str, array, or lattice or map of another package
        Statements ``name = formula`` in the grammar of `affine_body`, one a line or separated by semicolons, such as
        "p1 = p + K*sin(x); x1 = x + p1". The image of x is x1 or x'; later statements may use it. Other names stand for
        formulas that later statements use. A map has 1, 2, 4, ... or 16 variables. Also accepted:

        * a Line of xtrack or a lattice of PyAT: the one-turn map of x, y, px, py on momentum. It has the linear
          elements, the kicks of thin multipoles and linear dipoles. Other elements raise an error that names them.
        * the path of the map_table of MAD-X or of a damap of MAD-NG, or a table with these columns: the Taylor series
          of x, px, y, py on momentum around the closed orbit. It is symplectic up to the order of truncation;
        * a matrix (2n, 2n), n up to 4, such as a one-turn matrix: rows and columns are coordinates, then momenta, by
          default x, p or x, y, p_x, p_y. Its entries are the parameters m11, m12, ...
    coordinates, momenta : str or sequence of str, optional
        Names of the variables, in pairs. Default: x with p, p_x or px, and q_1 with p_1. For other names the first half
        of the images are coordinates. One variable alone has no momentum.
    periodic : dict of float or str, optional
        Periods of coordinates and momenta, for example {"x": "2*pi"}: numbers or formulas of the parameters. Each
        iterate reduces these rows to half a period around 0.
    domain : str, optional
        Formula of the coordinates that is positive inside the domain, such as an aperture. An orbit ends outside.
    {formula_parameters}

    Returns
    -------
    model
        Map whose fields are the parameters. Its attribute symplectic is True if the map is symplectic.

    Raises
    ------
    TypeError
        If `text` is neither a text nor a map of another package, or if a value is not a number.
    ValueError
        If the text is not a map (no text is ever executed), a name has no value, or a value is not used. Also if images
        of points a period apart differ by more than whole periods.
    ImportError
        If SymPy is missing and the text is new.

    Notes
    -----
    * Time is a whole number of iterates. Exponents and tunes are per iterate.
    * A map has no step, scheme or energy. One of one variable has no tunes, tori and residues either.
    * An orbit ends with the first iterate that is outside the domain (status LOST) or not finite (NONFINITE). Without a
      domain no distance counts as an escape.
    * Sections are the iterates themselves: ``poincare_map(model, z0, crossings=1000)``.

    References
    ----------
    Meiss 1992, Rev. Mod. Phys. 64, 795 (symplectic maps); Meurer et al. 2017, PeerJ Comput. Sci. 3, e103 (SymPy).

    Examples
    --------
    >>> fa.iterated_map([[0.0, 1.0], [-1.0, 0.5]]).iterate(1.0, 2.0)
    (2.0, 0.0)
    >>> standard = fa.iterated_map("p1 = p + K*sin(x); x1 = x + p1", periodic={"x": "2*pi"}, K=0.9)
    >>> standard.symplectic
    True
    >>> fa.integrate(standard, [0.0, 0.1], time=3).z.round(3)
    array([[0.737],
           [0.447]])
    """
    if is_matrix(text):
        return _linear(text, parameters, coordinates, momenta, periodic, domain)
    given = dispatch_adapter("lattice", text)
    if given is not None:
        if coordinates is not None or momenta is not None:
            raise ValueError("coordinates and momenta of a map of another tool are x y and px py: leave them out")
        text = given
        coordinates = "x y"
        momenta = "px py"
    model = untried(text, parameters, coordinates, momenta, periodic, domain)
    _tried(model)
    return model


def _linear(
    given: Any, parameters: Mapping[str, Any], coordinates: Any, momenta: Any, periodic: Any, domain: str | None
) -> FormulaMap:
    """Return the map of a matrix."""
    matrix = checked_matrix(given)
    default = names_of(matrix)
    q = checked_names("coordinates", default[0] if coordinates is None else coordinates)
    p = checked_names("momenta", default[1] if momenta is None else momenta, q)
    if len(q) != len(p) or 2 * len(q) != len(matrix):
        raise ValueError(
            f"coordinates and momenta must each be {len(matrix) // 2} names for a matrix of {len(matrix)} rows, got "
            f"{listed(q)} and {listed(p)}"
        )
    known = entries(matrix)
    taken = [name for name in parameters if name in known]
    if taken:
        raise ValueError(f"parameter {shown(taken[0])} is the name of an entry of the matrix. Use another name.")
    text = text_of_matrix((*q, *p))
    model: FormulaMap = untried(text, {**known, **parameters}, q, p, periodic, domain)
    _tried(model)
    return model


def untried(
    text: Any,
    parameters: Mapping[str, float],
    coordinates: str | Sequence[str] | None = None,
    momenta: str | Sequence[str] | None = None,
    periodic: Mapping[str, float | str] | None = None,
    domain: str | None = None,
) -> Any:
    """Return the map of a text as `iterated_map` does, without a test of its images with these parameters."""
    values = values_of(dict(parameters), ())
    found = statements(text, tuple(values))
    q, p = _paired(found.variables, coordinates, momenta)
    request = MapRequest(TAG, text, domain, tuple(values), q, p, period_texts(periodic, (*q, *p)))
    cls: Any = _class(request, found, values)
    return cls(*values.values())


def _paired(variables: Sequence[str], coordinates: Any, momenta: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of coordinates and momenta."""
    if coordinates is None and momenta is None:
        return pairs(variables)
    if coordinates is None or momenta is None:
        known = checked_names("momenta", momenta) if coordinates is None else checked_names("coordinates", coordinates)
        rest = tuple(name for name in variables if name not in known)
        q, p = (rest, known) if coordinates is None else (known, rest)
    else:
        q = checked_names("coordinates", coordinates)
        p = checked_names("momenta", momenta)
    if sorted((*q, *p)) != sorted(variables) or len(q) != max(1, len(p)):
        raise ValueError(
            f"coordinates and momenta must each be half of the variables {listed(variables)}, got {listed(q)} and "
            f"{listed(p)}"
        )
    return q, p


def _programs(request: MapRequest) -> tuple[Program | None, list[Program | None]]:
    """Return the programs of the domain and of the periods."""
    domain = request.domain
    wall = None if domain is None else parse(domain, request.coordinates, request.parameters, argument="domain")
    names = (*request.coordinates, *request.momenta)
    return wall, [
        parse(text, (), request.parameters, argument=f"periodic[{name!r}]") if text else None
        for name, text in zip(names, request.periods, strict=True)
    ]


def _class(request: MapRequest, found: Statements, values: Mapping[str, float]) -> type:
    """Check the texts; return the class."""
    wall, periods = _programs(request)
    used = found.names.union(*(program.names for program in (wall, *periods) if program is not None))
    unused = [name for name in values if name not in used]
    if unused:
        why = "leave it out, or is a name misspelt?"
        if unused[0] in ("aperture", "radius"):
            inside = " - ".join(f"{q}**2" for q in request.coordinates)
            why = f"a domain is a formula that is positive inside, such as domain='1 - {inside}'"
        raise ValueError(f"parameter {shown(unused[0])} is not used by the map: {why}")
    for name, program in zip((*request.coordinates, *request.momenta), periods, strict=True):
        if program is not None:
            try:
                period = program.run(float, {**values, **CONSTANTS}, NUMERIC, pow)
            except (ArithmeticError, ValueError) as problem:
                raise ValueError(f"periodic[{shown(name)}] has no value: {problem}") from None
            if isinstance(period, complex) or not (math.isfinite(period) and period > 0):
                raise ValueError(f"periodic[{shown(name)}] must be positive, got {shown(period)}")
    return _generated(request, found, wall, periods)


def _generated(request: MapRequest, found: Statements, wall: Program | None, periods: Sequence[Program | None]) -> type:
    """Return the class of a request: from this process, from the folder of the cache, or derived now."""
    key = hashlib.sha256(json.dumps([code_folder.code_hash(__name__), sys.version, *request]).encode()).hexdigest()[:24]

    def derived() -> str:
        imported("sympy", what="a map that is new here")
        return class_of_map(request, found, wall, periods)

    def made() -> Any:
        cls: Any = loaded(key, derived)
        cls.__reduce__ = functools.partialmethod(_reduce, request)
        cls._request = tuple(request)
        cls.__repr__ = _repr
        return told_apart(cls, cls._request)

    return CLASSES.get(key, made)


def _repr(self: Any) -> str:
    domain = [] if self.domain is None else [f"domain={brief(self.domain)}"]
    fields = [f"{name}={value!r}" for name, value in zip(self._fields, self, strict=True)]
    return f"{type(self).__name__}({', '.join([brief(self.formula), *domain, *fields])})"


def _reduce(self: Any, request: MapRequest) -> tuple:
    return rebuild_map, (tuple(request), tuple(self))


def rebuild_map(request: tuple, values: tuple) -> Any:
    """Return the map of a stored request and the numbers of its fields."""
    entries: list[Any] = [tuple(entry) if isinstance(entry, list) else entry for entry in request]
    whole = MapRequest(*entries)
    found = statements(whole.text, whole.parameters)
    cls: Any = _class(whole, found, dict(zip(whole.parameters, values, strict=True)))
    return cls(*values)


def remade(request: tuple, values: tuple) -> Any:
    """Return the model of a formula, or the map of a text, of a stored request and the numbers of its fields."""
    return (rebuild_map if request[0] == TAG else rebuild)(request, values)


def _tried(model: Any) -> None:
    """Refuse a map that has no finite image, around the origin, its parameters or far away, or that does not have its
    stated periods.
    """
    random = np.random.default_rng(5)
    periods = np.array(model.periods(), dtype=float)[:, None]
    near = random.uniform(-1, 1, (len(periods), TRIED)) * np.where(periods > 0, periods / 2, 1.5)
    size = 10.0 ** random.uniform(-12, 15, TRIED)
    far = random.choice([0.0, *map(float, model)], near.shape) + size * random.uniform(-1, 1, near.shape)
    z = np.concatenate([near, np.where(periods > 0, near, far)], axis=1)
    image = _images(model, z)
    real = np.isfinite(image).all(axis=0)
    if not real.any():
        raise ValueError(f"text: the map has a finite real image at none of {real.size} points up to 1e15 from 0")
    names = (*model.coordinates, *model.momenta)
    z = z[:, real]
    image = image[:, real]
    for row in np.flatnonzero(periods[:, 0] > 0):
        later = _images(model, z + periods * (np.arange(len(periods)) == row)[:, None])
        with np.errstate(all="ignore"):
            turns = np.where(periods > 0, np.rint((later - image) / np.where(periods > 0, periods, 1.0)), 0.0)
            off = np.abs(later - image - turns * periods) > SAME * (np.abs(image) + np.abs(later))
        if off.any(axis=0).mean() > 0.25:
            at, worst = np.argwhere(off.T)[0]
            raise ValueError(
                f"periodic[{shown(names[row])}] must be a period of the map, got {periods[row, 0]:.9g}: the image of "
                f"{names[worst]} changes by {later[worst, at] - image[worst, at]:.6g} after it"
            )


def _images(model: Any, z: np.ndarray) -> np.ndarray:
    """Return the images (2n, points) of points z."""
    with np.errstate(all="ignore"):
        return np.array([np.broadcast_to(row, z.shape[1]) for row in model.iterate(*z)])
