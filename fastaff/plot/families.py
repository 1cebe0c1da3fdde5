"""Families of orbits of a galaxy: the ratio of their frequencies against energy, angular momentum or radius."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown, text
from ..core.status import Status
from ..frequencies.orbit_family import START_VALUES, OrbitFamilies, OrbitFamily
from ..frequencies.resonances import equation
from .frequencies import LABELS, fraction, in_frame
from .picking import carry
from .resonances import formula
from .scales import label_of
from .style import SMALL, Artists, Palette, figure, nothing

MOST = 8
"""Resonances with a mark of their own."""

SAME = 1e-6
"""Relative difference of energies that are one energy."""

RESONANT = "^vD<>p*h"
"""Marks of resonances, frequent ones first."""

TUBES = "oXP"
"""Marks of tubes about the last coordinate, the second and the first, and of loops."""


def _have_one_energy(families: OrbitFamilies) -> bool:
    """Tell whether all orbits have one energy. At E = 0 the scale is that of angular momentum times frequency."""
    energy = families.energy
    if not np.isfinite(energy).all():
        return False
    turning = 2 * np.pi * np.abs(families.nu[:2]).max(axis=0) * np.abs(families.angular_momentum)
    size = np.fmax(np.abs(energy), turning).max(initial=0.0)
    return bool(np.ptp(energy) <= SAME * size)


@figure
@inserts_parameters
def plot_families(
    families: OrbitFamilies, *, ax: Any = None, x: str | None = None, y: str | None = None, legend: bool = True
) -> Artists:
    """Plot the ratio of two frequencies of orbits against energy, angular momentum or radius, by family.

    Parameters
    ----------
    families : OrbitFamilies
        Result of `orbit_families`.
    {ax}
    x : str, optional
        ``"energy"``, ``"angular_momentum"`` or ``"radius"`` of the initial conditions, or a ratio. Default: the energy,
        or the angular momentum if all orbits have one energy.
    y : str, optional
        Ratio of two frequencies. Default: that of the second coordinate to the first.
    legend : bool, default True
        Name the families, with their numbers of orbits.

    Returns
    -------
    Artists
        ``points`` are the marks, one artist for each family. ``missing`` is the number of orbits not drawn; a note has
        the reasons. A click picks the orbit.

    Raises
    ------
    ValueError
        If a name is unknown.

    Examples
    --------
    >>> galaxy = fa.hamiltonian("log(0.02 + x**2 + y**2/0.8)/2")
    >>> found = fa.frequency_map(galaxy, [[0.5, 0.6], [0.0, 0.0], [0.0, 0.8], [0.9, 0.1]], time=300.0)
    >>> drawn = fa.plot.plot_families(fa.frequencies.orbit_families(found))
    >>> drawn.missing, len(drawn.points)
    (0, 2)
    """
    names = families.names
    x, y = (None if name is None else text(axis, name) for axis, name in (("x", x), ("y", y)))
    if x is None:
        x = "angular_momentum" if _have_one_energy(families) else "energy"
    y = y or f"{names[1]}/{names[0]}"
    across, up = (_values(families, name) for name in (x, y))
    good = (families.status == Status.OK) & np.isfinite(across) & np.isfinite(up)
    palette = Palette.of(ax)
    marks = []
    resonances = 0
    others = np.zeros(good.shape, bool)
    for name, mask in families.members().items():
        mine = np.flatnonzero(mask & good)
        if not mine.size:
            continue
        family = OrbitFamily(int(families.family[mine[0]]))
        if family == OrbitFamily.LOOP:
            colour = palette.main if families.sense[mine[0]] > 0 else palette.pale
            axis = int(np.flatnonzero(families.resonance[::-1, mine[0]] == 0)[0]) if len(names) > 2 else 0
            look = {"marker": TUBES[axis], "color": colour, "s": 24.0 if axis else 15.0}
        elif family == OrbitFamily.RESONANT:
            resonances += 1
            if resonances > MOST:
                others |= mask & good
                continue
            colour = (palette.accent, "#009e73", "#cc79a7")[(resonances - 1) % 3]
            look = {"marker": RESONANT[resonances - 1], "color": colour, "s": 18.0, "zorder": 3.0}
        else:
            look = _looks(palette)[family]
        marks.append(_mark(ax, across, up, mine, f"{mine.size} {_told(families, mine[0], name)}", look))
    if others.any():
        mine = np.flatnonzero(others)
        look = {"marker": ".", "color": palette.accent, "s": 18.0, "zorder": 3.0}
        marks.append(_mark(ax, across, up, mine, f"{mine.size} other resonances", look))
    missing = int(np.count_nonzero(~good))
    counts = {name: int(np.count_nonzero(mask & ~good)) for name, mask in families.members().items()}
    reasons = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    ax.set(xlabel=_label(x), ylabel=f"${fraction(y)}$")
    if not marks:
        nothing(ax, reasons)
    else:
        steady = np.isin(families.family[good], (OrbitFamily.BOX, OrbitFamily.LOOP, OrbitFamily.RESONANT))
        notes = in_frame(ax, across[good], up[good], steady, None)
        notes += [f"{missing} of {good.size} orbits not drawn: {reasons}"] if missing else []
        ax.set_title("; ".join(notes), fontsize=SMALL, loc="right", color=palette.grey(0.35), wrap=True)
    if legend and marks:
        place = {"loc": "center left", "bbox_to_anchor": (1.01, 0.5), "handletextpad": 0.2, "borderpad": 0.5}
        ax.legend(handles=marks, title=f"{good.size} orbits", handlelength=1.2, **place)
    return Artists(tuple(marks), None, (), (), missing)


def _told(families: OrbitFamilies, orbit: int, name: str) -> str:
    """Return the name of an orbit's family for the legend: of a resonance of three coordinates its equation."""
    vector = families.resonance[:, orbit].tolist()
    plain = equation(vector, families.names)
    if plain not in name:
        return name
    return name.replace("resonant ", "at ").replace(plain, formula(vector, families.names))


def _looks(palette: Palette) -> dict[OrbitFamily, dict[str, Any]]:
    """Return the marks of families; loops have one for each sense, resonances one each."""
    doubt = palette.grey(0.55)
    return {
        OrbitFamily.BOX: {"marker": "s", "color": palette.plum, "s": 11.0, "zorder": 2.0},
        OrbitFamily.AXIAL: {"marker": "+", "color": palette.ink, "s": 20.0, "zorder": 3.0, "linewidths": 1.0},
        OrbitFamily.IRREGULAR: {"marker": "x", "color": doubt, "s": 11.0, "zorder": 1.0, "linewidths": 0.7},
        OrbitFamily.UNDECIDED: {"marker": "o", "facecolors": "none", "edgecolors": doubt, "s": 11.0, "zorder": 1.5},
    }


def _mark(ax: Any, across: np.ndarray, up: np.ndarray, mine: np.ndarray, label: str, look: dict) -> Any:
    """Draw the orbits of one family by their numbers; return the artist."""
    how = {"linewidths": 0.0, "zorder": 2.5, **look}
    if look.get("facecolors") == "none":
        how["linewidths"] = 0.7
    return carry(ax.scatter(across[mine], up[mine], label=label, rasterized=True, **how), across[mine], up[mine], mine)


def _values(families: OrbitFamilies, name: str) -> np.ndarray:
    """Return values (orbits,) by their name: of initial conditions, or a ratio of frequencies."""
    if name in START_VALUES:
        return np.asarray(getattr(families, name))
    top, slash, bottom = name.partition("/")
    if slash and {top, bottom} <= set(families.names):
        with np.errstate(all="ignore"):
            return families.nu[families.names.index(top)] / families.nu[families.names.index(bottom)]
    ratio = f"{families.names[1]}/{families.names[0]}"
    raise ValueError(f"x and y must be among {listed(START_VALUES)}, or a ratio such as {ratio}, got {shown(name)}")


def _label(name: str) -> str:
    """Return the label of an axis."""
    return LABELS.get(name) or label_of(name)
