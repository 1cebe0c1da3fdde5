"""Bifurcation diagrams: the last iterates of a map of one variable, and their exponent, against a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.names import did_you_mean
from ..core.numbers import fits, listed, numbers, shown, whole
from ..core.status import Status
from ..engine.values import at_points
from ..results.calls import records_call
from ..results.result import Result, along
from ..runs.requirements import checked_system
from ..systems.models.contracts import FormulaMap

BLOCKS = 16
"""Parts of the kept iterates whose means tell the error of the exponent."""

FLAT = 1e-9
"""Slope below which it is compared with that at the next number: rounding is 1e-16 of a slope that changes by 1 over
the map.
"""

ROUNDED = 4.0
"""Changes of the slope to the next number within which a slope is 0: iterates of a superstable cycle are within two.
"""

LONGEST = 1_000_000
"""Most iterates of the transient, and of those kept: about half a minute of calls of the map's formula."""


@dataclass(frozen=True)
class BifurcationDiagram(Result, axis="value"):
    """Iterates of a map of one variable against a parameter.

    Attributes
    ----------
    parameter : str
        Name of the parameter.
    names : tuple of str
        Name of the variable.
    values : ndarray, shape (values,)
        Values of the parameter.
    points : ndarray, shape (iterates, values)
        Iterates after the transient; NaN from the end of an orbit on.
    exponent : ndarray, shape (values,)
        Lyapunov exponent of these iterates, per iterate; -inf where an iterate has slope 0.
    exponent_error : ndarray, shape (values,)
        Standard error of the exponent, from the means of 16 parts of the iterates; inf where an iterate has slope 0
        within rounding, as on a superstable cycle.
    status : ndarray of int, shape (values,)
        `Status`: OK, LOST outside of the domain, or NONFINITE.
    """

    parameter: str
    names: tuple[str, ...]
    values: Annotated[np.ndarray, along("value")]
    points: Annotated[np.ndarray, along("iterate", "value")]
    exponent: Annotated[np.ndarray, along("value", unit="1/iterate")]
    exponent_error: Annotated[np.ndarray, along("value", unit="1/iterate")]
    status: Annotated[np.ndarray, along("value")]

    def _advice(self) -> dict[Status, str]:
        """Return the words for a map, which has no step."""
        return {Status.NONFINITE: "an iterate became infinite or NaN; choose x0 or parameters of bounded orbits"}


@records_call
def bifurcation_diagram(
    model: FormulaMap,
    parameter: str,
    values: ArrayLike,
    *,
    x0: ArrayLike,
    transient: int = 1000,
    iterates: int = 256,
) -> BifurcationDiagram:
    """Iterate a map of one variable for many values of a parameter.

    Parameters
    ----------
    model : map of one variable
        Result of `iterated_map` such as "x1 = r*x*(1 - x)".
    parameter : str
        Name of the parameter.
    values : array_like, shape (values,)
        Its values.
    x0 : float or array_like, shape (values,)
        Initial condition, the same or one for each value.
    transient : int, default 1000
        Number of iterates before those that are kept, at most a million.
    iterates : int, default 256
        Number of iterates that are kept, from 16 to a million.

    Returns
    -------
    `BifurcationDiagram`
        The iterates and their exponents. Its method ``plot`` draws them.

    Raises
    ------
    TypeError
        If `model` is no map of one variable, or an argument has a wrong type.
    ValueError
        If the model has no such parameter, or a value is out of its range.

    Notes
    -----
    - Exponent: the mean of ln of the absolute slope. It is negative on a stable cycle, 0 where the cycle bifurcates.
    - Error: means of parts of a chaotic orbit are nearly independent. Near a bifurcation the transient is long, and the
      error does not tell of it.
    - Cost: one evaluation of the map for each iterate, over all values at once.

    References
    ----------
    May 1976, Nature 261, 459; Feigenbaum 1978, J. Stat. Phys. 19, 25.

    Examples
    --------
    >>> logistic = fa.iterated_map("x1 = r*x*(1 - x)", r=4.0)
    >>> found = fa.chaos.bifurcation_diagram(logistic, "r", [2.9, 3.2, 4.0], x0=0.3)
    >>> found.points.shape, found.exponent.round(1)
    ((256, 3), array([-0.1, -0.9,  0.7]))
    """
    system = checked_system(model)
    if not (system.iterated and system.rows == 1):
        raise TypeError(f"model must be a map of one variable such as 'x1 = r*x*(1 - x)', got {shown(model, 60)}.")
    fields = getattr(model, "_fields", ())
    if not isinstance(parameter, str) or parameter not in fields:
        hint = did_you_mean(parameter, fields) if isinstance(parameter, str) else ""
        raise ValueError(f"parameter must be one of {listed(fields) or 'none'}, got {shown(parameter, 40)}.{hint}")
    given = np.array(numbers("values", values))
    if given.ndim != 1 or not given.size or not np.isfinite(given).all():
        raise ValueError(f"values must be finite numbers in one row, got {shown(values, 60)}")
    start = np.array(numbers("x0", x0))
    if start.ndim > 1 or (start.ndim == 1 and start.shape != given.shape) or not np.isfinite(start).all():
        raise ValueError(f"x0 must be a finite number or {given.size} of them, got {shown(x0, 60)}")
    before = whole("transient", transient, 0)
    if before > LONGEST:
        raise ValueError(f"transient must be at most {LONGEST}, got {shown(transient)}. Use integrate for longer runs.")
    kept = whole("iterates", iterates, BLOCKS)
    if kept > LONGEST:
        raise ValueError(f"iterates must be at most {LONGEST}, got {shown(iterates)}. Use integrate for longer runs.")
    fits("iterates", kept, given.size)
    many: Any = model
    many = many._replace(**{parameter: given})  # one orbit for each value
    x = np.broadcast_to(start, given.shape).astype(np.float64)
    status = np.full(given.size, int(Status.OK))
    for _ in range(before):
        x = _next(many, x, status)
    points = np.empty((kept, given.size))
    growth = np.empty((kept, given.size))
    critical = np.zeros(given.size, bool)
    for k in range(kept):
        with np.errstate(all="ignore"):
            slope = _slope(many, x)
            if (flat := np.abs(slope) < FLAT).any():
                beside = _slope(many, np.nextafter(x, np.inf))
                critical |= flat & (np.abs(slope) <= ROUNDED * np.abs(beside - slope))
            growth[k] = np.where(status == Status.OK, np.log(np.abs(slope)), np.nan)
        points[k] = x = _next(many, x, status)
    with np.errstate(all="ignore"):
        means = np.array([part.mean(axis=0) for part in np.array_split(growth, BLOCKS)])
        error = means.std(axis=0, ddof=1) / np.sqrt(BLOCKS)
        return BifurcationDiagram(
            parameter=parameter,
            names=system.row_names,
            values=given,
            points=points,
            exponent=growth.mean(axis=0),
            exponent_error=np.where(np.isneginf(means).any(axis=0) | critical, np.inf, error),
            status=status,
        )


def _slope(model: Any, x: np.ndarray) -> np.ndarray:
    """Return the slopes of the map at points."""
    return np.broadcast_to(at_points(model, "tangent_iterate", x, np.ones_like(x))[0], x.shape)


def _next(model: Any, x: np.ndarray, status: np.ndarray) -> np.ndarray:
    """Return the images of points, NaN from the end of an orbit on, whose status is set."""
    (period,) = model.periods()
    with np.errstate(all="ignore"):
        image = np.array(np.broadcast_to(at_points(model, "iterate", x)[0], x.shape))
        image = np.where(period > 0, image - period * np.rint(image / np.where(period > 0, period, 1.0)), image)
        inside = np.broadcast_to(at_points(model, "margin", image), x.shape) > 0
    going = status == Status.OK
    status[going & ~np.isfinite(image)] = Status.NONFINITE
    status[going & np.isfinite(image) & ~inside] = Status.LOST
    return np.where(status == Status.OK, image, np.nan)
