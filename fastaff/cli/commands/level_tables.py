"""Tables of quantum levels, as `fastaff spectrum` prints them."""

from __future__ import annotations

from typing import Any

import numpy as np

SHOWN = 60
"""Rows of a table that are printed."""
MEMBERS = 3
"""Rows of one multiplet that are printed."""
COLUMNS = 8
"""Levels of each class that the table of a scan prints."""


def level_table(levels: Any) -> list[str]:
    """Return the lines of a table, one for each different set of quantum numbers of each multiplet."""
    numbers = [f"n_{name}" if levels.separated else "number" for name in levels.names]
    gathered = levels.multiplets()
    head = ["E", "degeneracy", "error", "converged", *numbers, "|m-l|", "|m+l|", "(m, l)"]
    body: list[list[str]] = []
    for k in range(len(gathered)):
        inside = gathered.members(k)
        sets = _sets(inside)
        converged = "yes" if inside.converged.all() else "NO"
        error = float(inside.error.max())
        front = [digits(float(inside.E[0]), error), str(len(inside)), f"{error:.1e}", converged]
        for row, (key, classes) in enumerate(list(sets.items())[:MEMBERS]):
            body.append(
                [*(front if row == 0 else [""] * 4), *map(str, key), " ".join(f"({m},{l})" for m, l in classes)]
            )
        if len(sets) > MEMBERS:
            body.append([*[""] * 4, f"and {len(sets) - MEMBERS} more sets of quantum numbers, all in the file"])
        if len(body) >= SHOWN and k + 1 < len(gathered):
            return [*_aligned(head, body), f"... {len(gathered) - k - 1} more energies, all in the file"]
    return _aligned(head, body)


def vibration_table(levels: Any) -> list[str]:
    """Return the lines of a table, one for each level of a vibration."""
    rows = zip(levels.E[:SHOWN], levels.error, levels.converged, strict=False)
    body = [
        [str(k), digits(float(E), float(e)), f"{e:.1e}", "yes" if ok else "NO"] for k, (E, e, ok) in enumerate(rows)
    ]
    more = [f"... {len(levels) - SHOWN} more energies, all in the file"] if len(levels) > SHOWN else []
    return [*_aligned(["level", "E", "error", "converged"], body), *more]


def _sets(levels: Any) -> dict[tuple[int, ...], list[tuple[int, int]]]:
    """Return the classes (m, l) of each set of quantum numbers n, |m - l|, |m + l| of a multiplet."""
    sets: dict[tuple[int, ...], list[tuple[int, int]]] = {}
    for one, other, label in zip(levels.m.tolist(), levels.l.tolist(), levels.n.T.tolist(), strict=True):
        sets.setdefault((*label, abs(one - other), abs(one + other)), []).append((one, other))
    return dict(sorted(sets.items(), key=lambda entry: (entry[0][-2:], entry[0])))


def digits(E: float, error: float) -> str:
    """Return E with the decimals that are larger than its error."""
    decimals = int(np.clip(np.floor(-np.log10(max(error, 1e-300))), 2, 15))
    return f"{E:.{decimals}f}"


def _aligned(head: list[str], body: list[list[str]]) -> list[str]:
    """Return lines of columns, energies aligned at their points, the last column and notes to the left."""
    point = max((row[0].find(".") for row in body), default=0)
    body = [[" " * (point - row[0].find(".")) + row[0] if row[0] else "", *row[1:]] for row in body]
    full = [row for row in body if len(row) == len(head)]
    widths = [max(len(row[k]) for row in [head, *full]) for k in range(len(head))]
    lines = []
    for row in [head, *body]:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:-1], widths[1:-1]))]
        lines.append("  ".join([*cells, row[-1]]).rstrip())
    return lines


def scan_table(diagram: Any) -> list[str]:
    """Return the lines of a table of the lowest levels at each value."""
    lines = []
    shown = min(COLUMNS, diagram.E.shape[2])
    for column in range(diagram.m.shape[1]):
        lines.append(
            f"(m, l) = ({diagram.m[0, column]}, {diagram.l[0, column]}): the lowest {shown} of {diagram.E.shape[2]} "
            "levels"
        )
        lines.append("  ".join([f"{diagram.name:>10}", *(f"{f'E_{k}':>12}" for k in range(shown))]))
        for value, E in list(zip(diagram.values, diagram.E[:, column, :shown]))[:SHOWN]:
            lines.append("  ".join([f"{value:10.6g}", *(f"{one:12.8g}" for one in E)]))
    return lines
