"""Colour scales and coloured values: scales of chaos follow from the threshold of their indicator, not from the data.

Bright is chaotic: cividis has a step of lightness at the threshold, so that the boundary between regular and chaotic is
seen with any kind of colour vision, and in grey. The regular half runs from the value of a regular orbit to the
threshold, whatever the data: rounding noise of regular orbits does not look like chaos. Diffusion decides less sharply
(slow chaos is below the threshold); its scale has no step, but grey at the threshold and ends that the threshold sets.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..chaos.chaos_map import ChaosMap
from ..chaos.indicator import IndicatorStyle
from ..chaos.indicators import GALI, INDICATORS
from ..chaos.pass_indicators import TOLD
from ..core.docstrings import inserts_parameters
from ..core.numbers import an_array, listed, numbers, real
from ..core.status import Status
from ..frequencies.frequencies import FrequencyMap
from ..frequencies.own_lines import duration
from ..frequencies.tunes import Tunes
from ..results.result import Result, columns
from .ratios import frequency
from .style import Palette, symbol

STEP = (0.36, 0.66)
"""The part of cividis that is left out at the threshold."""
DIFFUSION = r"diffusion  $\log_{10}|\Delta\nu|$"
SLOW = "diffusion"
"""A column that decides less sharply than the indicators."""
LABELS = {
    "diffusion": DIFFUSION,
    "energy_error": "energy error / largest kinetic energy",
    "counts": "crossings",
    "crossings": "crossings in a period",
    "period": "period $T$",
    "time": "time $T$",
}


class UnknownColumn(ValueError):
    """A result has no column of a name; names: those that it has."""

    def __init__(self, given: str, names: tuple[str, ...]):
        super().__init__(f"the column must be one of {listed(names)}, got {given}")
        self.names = names


class Colouring(NamedTuple):
    """Colours of orbits by a value of each.

    Attributes
    ----------
    values : ndarray, shape (orbits,)
        Values.
    label : str
        Label of the colour bar.
    norm : matplotlib.colors.Normalize
        Colour scale.
    threshold : float, optional
        Threshold of chaos.
    name : str
        Name of the column.
    falling : bool
        Whether chaos is below the threshold.
    """

    values: np.ndarray
    label: str
    norm: Any
    threshold: float | None = None
    name: str = ""
    falling: bool = False


def label_of(name: str, known: Any = None) -> str:
    """Return the label of a column for axes and colour bars; known: the indicator of that name, or its look."""
    if name in LABELS:
        return LABELS[name]
    if label := getattr(known, "label", None):
        return str(label)
    numerator, slash, denominator = name.partition("/")
    if slash:
        return rf"${symbol('nu_' + numerator)}/{symbol('nu_' + denominator)}$"
    head = name.partition("_")[0]
    return f"${symbol(name)}$" if head in ("nu", "p") or name in ("alpha", "beta") else name.replace("_", " ")


def indicator_of(name: str, result: Any = None) -> Any:
    """Return the indicator of the package with this name in results, a result's description of a user's indicator, or
    None.
    """
    if name.startswith("gali_") and name[5:].isdigit():
        known: Any = GALI(int(name[5:]))
    else:
        known = next((entry for entry in INDICATORS.values() if entry.name == name), None)
    styles = dict(zip(result.names, result._styles, strict=False)) if isinstance(result, ChaosMap) else {}
    style = styles.get(name)
    return known if style is None or (known is not None and IndicatorStyle.of(known) == style) else style


def threshold_colours(palette: Palette, falling: bool = False) -> Any:
    """Return cividis with a step in its middle, the bright half on the side of chaos."""
    from matplotlib.colors import ListedColormap

    place = np.concatenate([np.linspace(0.0, STEP[0], 128), np.linspace(STEP[1], palette.bright, 128)])
    return ListedColormap(palette.cividis(place[::-1] if falling else place), name="fastaff_threshold")


def stepped(colours: Colouring) -> bool:
    """Tell whether colours have a step at a threshold: those of indicators, not those of diffusion."""
    return getattr(colours.norm, "vcenter", None) is not None and colours.threshold is not None and colours.name != SLOW


def colours_of(colours: Colouring, palette: Palette) -> Any:
    """Return the map of colours: with a step at the threshold of an indicator."""
    return threshold_colours(palette, colours.falling) if stepped(colours) else palette.colour_map()


def threshold_scale(values: Any, threshold: float, regular: float | None = None) -> Any:
    """Return a colour scale with the threshold in its middle.

    On the side of `regular`, the value of a regular orbit, it ends there; on the other side it ends as far from the
    threshold or, if that is farther, at the 2nd or 98th percentile of the values beyond the threshold. Without
    `regular` both ends are such percentiles.
    """
    from matplotlib.colors import TwoSlopeNorm

    values = np.asarray(values, dtype=np.float64)
    values = values[np.isfinite(values)]
    below = values[values < threshold]
    above = values[values > threshold]
    low = float(np.quantile(below, 0.02)) if below.size else math.nan
    high = float(np.quantile(above, 0.98)) if above.size else math.nan
    if regular is not None and regular < threshold:
        low = regular
        high = np.fmax(high, 2 * threshold - regular)
    elif regular is not None and regular > threshold:
        low = np.fmin(low, 2 * threshold - regular)
        high = regular
    other = np.nanmax([threshold - low, high - threshold, 0.0]) or 1.0
    least = 1e-3 * max(other, abs(threshold)) or 1e-3
    low = threshold - 0.5 * other if math.isnan(low) else min(low, threshold - least)
    high = threshold + 0.5 * other if math.isnan(high) else max(high, threshold + least)
    return TwoSlopeNorm(threshold, float(low), float(high))


def diffusion_threshold(time: float) -> float:
    """Return log10 of the change of a frequency, in cycles per unit time, that is chaos: 0.3 cycles over half the time,
    as for the indicator `FrequencyDiffusion`.
    """
    return math.log10(0.6 / time)


def diffusion_scale(time: float) -> Any:
    """Return the colour scale of the frequency diffusion, which does not depend on the data.

    Parameters
    ----------
    time : float
        Length of the run, in units of time.

    Returns
    -------
    matplotlib.colors.Normalize
        Scale of eight decades below the threshold of chaos and two above it.

    Examples
    --------
    >>> scale = fa.plot.diffusion_scale(500.0)
    >>> scale.vmax - scale.vmin
    10.0
    """
    return scale_of("diffusion", (), diffusion_threshold(time))


def scale_of(name: str, values: Any, threshold: float | None, known: Any = None) -> Any:
    """Return the colour scale of a column by its name, set by its threshold where it has one and by what a regular
    orbit reads, if its indicator, where it is known, says that.
    """
    from matplotlib.colors import TwoSlopeNorm

    if threshold is None:
        return clipped(values)
    if name == SLOW:
        return TwoSlopeNorm(threshold, threshold - TOLD, threshold + 2.0)
    reads = getattr(known, "reads", None)
    return threshold_scale(values, threshold, None if reads is None else float(reads(threshold)))


def clipped(values: Any) -> Any:
    """Return a colour scale from the 5th to the 95th percentile of the finite values.

    Parameters
    ----------
    values : array_like
        Values. If the percentiles span more than 1/2, they are rounded outwards to multiples of 1/2.

    Returns
    -------
    matplotlib.colors.Normalize
        The scale.

    Examples
    --------
    >>> scale = fa.plot.clipped(np.linspace(-10.0, -2.0, 101))
    >>> scale.vmin, scale.vmax
    (-10.0, -2.0)
    """
    from matplotlib.colors import Normalize

    values = np.asarray(values, dtype=np.float64)
    finite = values[np.isfinite(values)]
    low, high = np.quantile(finite, [0.05, 0.95]) if finite.size else (0.0, 1.0)
    if high - low > 1.0:
        low, high = math.floor(2 * low) / 2, math.ceil(2 * high) / 2
    elif not high > low:
        low, high = low - 0.25, low + 0.25
    return Normalize(float(low), float(high))


def each_value(values: Any) -> np.ndarray:
    """Return values of orbits as floats; those of a mask are 0 and 1."""
    array = an_array("values", values)
    return numbers("values", array.astype(float) if array.dtype.kind == "b" else values)


def limited(norm: Any, vmin: float | None = None, vmax: float | None = None) -> Any:
    """Return a scale with given ends; it keeps its threshold if that lies between them. Raises ValueError
    for ends in the wrong order.
    """
    from matplotlib.colors import Normalize, TwoSlopeNorm

    if vmin is None and vmax is None:
        return norm
    low = norm.vmin if vmin is None else real("vmin", vmin)
    high = norm.vmax if vmax is None else real("vmax", vmax)
    if not low < high:
        raise ValueError(f"vmin must be below vmax, got {low:g} and {high:g}")
    threshold = getattr(norm, "vcenter", None)
    return (
        Normalize(low, high) if threshold is None or not low < threshold < high else TwoSlopeNorm(threshold, low, high)
    )


@inserts_parameters
def colouring(result: Any, name: str | None = None, *, vmin: float | None = None, vmax: float | None = None) -> Any:
    """Return colours of the orbits of a result by one of its columns.

    Parameters
    ----------
    result : Result
        A `ChaosMap` or a `FrequencyMap`, whose indicators and diffusion have scales with thresholds, or any other
        result.
    name : str, optional
        Column of shape (orbits,). For a frequency map also a ratio of frequencies, for example ``"beta/alpha"``.
        Default: the first indicator, or the diffusion.
    {colour_range}

    Returns
    -------
    Colouring
        Colours for the argument ``values`` of `plot_section`, `plot_diffusion_grid` and others. Orbits that are not
        ``OK`` have no value.

    Raises
    ------
    ValueError
        If the result has no such column. The message names the columns.

    Examples
    --------
    >>> freq = fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0)
    >>> colours = fa.plot.colouring(freq, "y/x")
    >>> colours.values.round(6)
    array([1.])
    """
    fine = np.asarray(getattr(result, "status", 0)) == Status.OK
    if isinstance(result, ChaosMap) and (name is None or name in result.names):
        name = result.names[0] if name is None else name
        values, threshold = _chaos(result, name, fine)
        return coloured(name, values, threshold, vmin, vmax, result=result)
    if isinstance(result, (FrequencyMap, Tunes)) and name in (None, "diffusion"):
        values = np.where(fine, result.diffusion, np.nan)
        times = np.ravel(duration(result))
        threshold = diffusion_threshold(float(np.median(times[times > 0])) if (times > 0).any() else 1.0)
        return coloured("diffusion", values, threshold, vmin, vmax)
    values = _column(result, name)
    if name != "status":
        values = np.where(fine | (not hasattr(result, "status")), values, np.nan) if name not in KEPT else values
    return coloured(str(name), values, None, vmin, vmax)


def coloured(
    name: str,
    values: np.ndarray,
    threshold: float | None,
    vmin: float | None = None,
    vmax: float | None = None,
    *,
    norm: Any = None,
    result: Any = None,
) -> Colouring:
    """Return the colours of orbits by values (orbits,) of that name, with the threshold of chaos or None; norm: another
    scale; result: the source of the values.
    """
    known = indicator_of(name, result)
    norm = limited(norm or scale_of(name, values, threshold, known), vmin, vmax)
    return Colouring(values, label_of(name, known), norm, threshold, name, not getattr(known, "above", True))


KEPT = ("counts", "status", "energy_error", "t")
"""Columns with values for orbits that are not OK too."""


def _chaos(result: ChaosMap, name: str, fine: np.ndarray) -> tuple[np.ndarray, float]:
    row = result.names.index(name)
    threshold = float(np.nanmedian(result.thresholds[row])) if np.isfinite(result.thresholds[row]).any() else 0.0
    return np.where(fine, result.values[row], np.nan), threshold


def _column(result: Any, name: str | None) -> np.ndarray:
    """Return a column (orbits,) of numbers by its name."""
    if not isinstance(result, Result):
        raise TypeError(f"result must be a result of fastaff, got {type(result).__name__}")
    found: Any = None
    if (
        isinstance(result, FrequencyMap)
        and name is not None
        and ("/" in name or name in (*result.names, "eta", "gamma"))
    ):
        found = frequency(result, name)
    elif name is not None:
        try:
            found = result[name]
        except KeyError:
            found = None
    array = np.asarray(found) if isinstance(found, (np.ndarray, np.generic)) else np.zeros(0, object)
    if array.ndim != 1 or array.dtype.kind not in "biuf":
        known = [entry.name for entry in columns(result) if entry.value.ndim == 1]
        known += [
            f"{entry.name}_{label}" for entry in columns(result) if entry.value.ndim == 2 for label in entry.labels
        ]
        known += list(getattr(result, "names", ())) if isinstance(result, ChaosMap) else []
        which = f"{name!r}" if name is not None else "none: fastaff.plot.colouring(result, name)"
        raise UnknownColumn(which, tuple(dict.fromkeys(known)))
    return array.astype(np.float64)


def orbit_colours(
    result: Any, values: Any, orbits: int, norm: Any, vmin: float | None, vmax: float | None, label: str | None
) -> Colouring:
    """Return the colours of orbits from a caller's values, name of a column or Colouring."""
    if isinstance(values, str):
        values = colouring(result, values)
    if not isinstance(values, Colouring):
        each = each_value(values)
        values = Colouring(each, "", clipped(each))
    if values.values.shape != (orbits,):
        raise ValueError(f"values must have shape ({orbits},), one for each orbit, got {values.values.shape}")
    chosen = limited(norm or values.norm, vmin, vmax)
    return values._replace(norm=chosen, label=values.label if label is None else label)
