"""Levels against a parameter of the body, or against spin or vorticity: the curves of level diagrams."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.docstrings import inserts_parameters
from ...core.interruption import partial_result_on_interrupt
from ...core.numbers import an_array, checked_callback, function, numbers, shown, text, whole
from ...results.calls import records_call
from ...results.display import screen
from ...results.result import Drawable
from ...systems.charts import Chart
from ...systems.models import Body
from ..states.level_table import LevelTable
from ..states.symmetry import SymmetryClass, checked_class
from .spectrum import spectrum, spectrum_table


class Curve(NamedTuple):
    """One level of a diagram: its column, quantum numbers, E (points,), NaN outside."""

    column: int
    label: tuple[int, ...]
    E: np.ndarray

    def __repr__(self) -> str:
        return screen(self)


@dataclass(frozen=True)
class LevelDiagram(Drawable):
    """Levels of one or several symmetry classes at each value of a parameter.

    Attributes
    ----------
    name : str
        Name of the abscissa: a parameter, ``"m"`` or ``"l"``.
    values : ndarray, shape (points,)
        Values of the abscissa.
    m, l : ndarray of int, shape (points, columns)
        Quantum numbers of spin and vorticity of the classes.
    E : ndarray, shape (points, columns, levels)
        Lowest energies of each class, ascending, NaN if not computed.
    error : ndarray, shape (points, columns, levels)
        Errors of E.
    n : ndarray of int, shape (numbers, points, columns, levels)
        Quantum numbers as in `LevelTable`, -1 if not computed.
    names : tuple of str
        Names of the quantum numbers.
    hbar : float
        Planck's constant over 2 pi.
    """

    name: str
    values: np.ndarray
    m: np.ndarray
    l: np.ndarray
    E: np.ndarray
    error: np.ndarray
    n: np.ndarray
    names: tuple[str, ...]
    hbar: float

    def __repr__(self) -> str:
        return screen(self)

    @property
    def top(self) -> float:
        """Energy up to which no curve is cut off by the number of levels."""
        return float(np.nanmin(self.E[..., -1]))

    def curves(self) -> list[Curve]:
        """Return the levels as curves, each with the same quantum numbers at all points.

        Returns
        -------
        list of Curve
            Tuples of column, label (quantum numbers) and E, which is NaN if the level was not computed. Curves cross if
            the body separates, else they keep their order.
        """
        found = []
        for column in range(self.m.shape[1]):
            n = self.n[:, :, column]
            points = np.arange(self.values.size)
            for label in sorted(
                {label for label in zip(*n.reshape(len(n), -1).tolist(), strict=True) if label[0] >= 0}
            ):
                here = (n == np.reshape(label, (-1, 1, 1))).all(axis=0)
                E = np.where(here.any(axis=1), self.E[points, column, here.argmax(axis=1)], np.nan)
                found.append(Curve(column, label, E))
        return found


@records_call
@inserts_parameters
def level_diagram(
    make: Callable[[float], Any],
    values: ArrayLike,
    *,
    m: int | Sequence[int],
    l: int | Sequence[int],
    count: int,
    name: str = "parameter",
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Chart | None = None,
    tolerance: float = 1e-10,
    callback: Callable[[float], None] | None = None,
) -> LevelDiagram:
    """Compute levels against a parameter, in one symmetry class or several.

    Parameters
    ----------
    make : callable
        Function of a value that returns the `Body`.
    values : array_like, shape (points,)
        Finite values of the parameter.
    m, l : int or sequence of int
        Quantum numbers of spin and vorticity of each class.
    {class_count}
    name : str, default "parameter"
        Name of the parameter.
    {hbar}
    {single_valued}
    {quantum_chart}
    {levels_tolerance}
    {callback}

    Returns
    -------
    LevelDiagram
        Levels at each value.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If an argument has a wrong value, or `make` returns both separable and nonseparable bodies.
    NoGroundState
        If the energy of a body is unbounded below or it does not bind that many levels.
    Interrupted
        On Ctrl-C. The result so far is in its attribute ``partial``, with NaN for values not yet computed.

    Notes
    -----
    Cost: one call of `spectrum` per value. For a figure of nonseparable bodies a tolerance of 1e-6 is sufficient.

    References
    ----------
    Martens & Slawianowski, section 4; von Neumann & Wigner 1929, Phys. Z. 30, 467 (levels of a class cross only if more
    than the class is conserved).

    Examples
    --------
    >>> diagram = fa.quantum.level_diagram(lambda C: fa.Body(fa.Harmonic(C)), [1.0, 4.0], m=0, l=0, count=2, name="C")
    >>> diagram.E[:, 0].round(9)
    array([[2., 4.],
           [4., 8.]])
    """
    text("name", name)
    points = np.atleast_1d(numbers("values", values))
    if points.ndim != 1 or not points.size or not np.isfinite(points).all():
        raise ValueError(f"values must be a non-empty one-dimensional array of finite numbers, got {shown(values)}")
    function("make", make)
    checked_callback(callback)
    chosen = _classes(m, l, single_valued)
    options = {"hbar": hbar, "single_valued": single_valued, "chart": chart, "tolerance": tolerance}
    rows: list[list[LevelTable]] = []
    with partial_result_on_interrupt("level_diagram", lambda: diagram_of(name, points, rows) if rows else None):
        for number, value in enumerate(points):
            rows.append(_row_at(number, float(value), make, chosen, count, options))
            if callback is not None:
                callback((number + 1) / points.size)
    return diagram_of(name, points, rows)


@records_call
@inserts_parameters
def class_diagram(
    model: Body,
    *,
    m: int | Sequence[int],
    l: int | Sequence[int],
    count: int,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Chart | None = None,
    tolerance: float = 1e-10,
) -> LevelDiagram:
    """Compute levels of a body against its spin m at one vorticity l, or against l at one m.

    Parameters
    ----------
    {body}
    m, l : int or sequence of int
        Quantum numbers of spin and vorticity. One is a sequence, the points of the diagram, the other an integer.
    {class_count}
    {hbar}
    {single_valued}
    {quantum_chart}
    {levels_tolerance}

    Returns
    -------
    LevelDiagram
        Diagram of one column. Its values are the sequence.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If an argument has a wrong value.
    NoGroundState
        If the energy is unbounded below or the body does not bind that many levels.

    References
    ----------
    Martens & Slawianowski, section 4 (EQ4.1-EQ4.9, corrected).

    Examples
    --------
    >>> fa.quantum.class_diagram(fa.Body(fa.Harmonic()), m=[0, 2, 4], l=0, count=1).E.ravel().round(9)
    array([2., 4., 6.])
    """
    if (np.ndim(an_array("m", m)) == 1) == (np.ndim(an_array("l", l)) == 1):
        raise ValueError(
            f"m or l must be a sequence and the other a whole number, got m = {shown(m, 40)}, l = {shown(l, 40)}"
        )
    name = "m" if np.ndim(m) == 1 else "l"
    chosen = _classes(m, l, single_valued)
    options = {"hbar": hbar, "single_valued": single_valued, "chart": chart, "tolerance": tolerance}
    rows = [[found] for found in _row(model, chosen, count, options)]
    return diagram_of(name, np.array([getattr(one, name) for one in chosen], float), rows)


def _classes(m: Any, l: Any, single_valued: bool) -> list[SymmetryClass]:
    """Return the classes of two numbers, or sequences of one length; a number goes with each of a sequence."""
    spins, vorticities = (np.atleast_1d(np.asarray(an_array(of, given), object)) for of, given in (("m", m), ("l", l)))
    if spins.ndim != 1 or vorticities.ndim != 1 or not spins.size or not vorticities.size:
        raise ValueError(
            f"m and l must be whole numbers or non-empty sequences of them, got m = {shown(m, 30)}, l = {shown(l, 30)}"
        )
    if spins.size != vorticities.size and 1 not in (spins.size, vorticities.size):
        raise ValueError(f"m and l must be of the same length, got {spins.size} and {vorticities.size}")
    pairs = np.broadcast_arrays(spins, vorticities)
    return [checked_class(one, other, single_valued) for one, other in zip(*pairs, strict=True)]


def _row_at(
    number: int, value: float, make: Callable, chosen: list[Any], count: int, options: dict[str, Any]
) -> list[LevelTable]:
    """Return the levels of the body of one value, which messages name."""
    try:
        return _row(make(value), chosen, count, options)
    except ValueError as problem:
        raise type(problem)(f"values[{number}] = {value:g}: {problem}") from problem


def _row(model: Any, chosen: list[Any], count: int, options: dict[str, Any]) -> list[LevelTable]:
    """Return the levels of the classes of a body: at once where it separates."""
    whole("count", count, 1)
    found = spectrum(model, m=chosen[0].m, l=chosen[0].l, count=count, **options)
    if len(chosen) == 1:
        return [found]
    m, l = zip(*chosen, strict=True)
    if found.separated:
        return spectrum_table(model, m=m, l=l, count=count, **options)
    return [found, *(spectrum(model, m=one.m, l=one.l, count=count, **options) for one in chosen[1:])]


def diagram_of(name: str, values: np.ndarray, rows: Sequence[Sequence[LevelTable]]) -> LevelDiagram:
    """Return the diagram of levels that are computed already: one row for each value, NaN for last values without a
    row.
    """
    first = rows[0][0]
    if len({found.names for row in rows for found in row}) > 1:
        raise ValueError("make must give bodies that all separate in one chart, or none, for curves to be followed")
    shape = (len(values), len(rows[0]), first.E.size)
    E = np.full(shape, np.nan)
    error = np.full(shape, np.nan)
    n = np.full((len(first.n), *shape), -1)
    for i, row in enumerate(rows):
        E[i] = [found.E for found in row]
        error[i] = [found.error for found in row]
        n[:, i] = np.stack([found.n for found in row], axis=1)
    classes = [*rows, *[rows[0]] * (len(values) - len(rows))]
    m, l = (np.array([[getattr(found, axis)[0] for found in row] for row in classes]) for axis in ("m", "l"))
    return LevelDiagram(
        name=name,
        values=np.asarray(values, float),
        m=m,
        l=l,
        E=E,
        error=error,
        n=n,
        names=first.names,
        hbar=first.hbar,
    )
