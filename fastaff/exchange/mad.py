"""Files of MAD-X and MAD-NG: TFS tables of tracking as orbits, tables of maps and damaps as maps of one turn."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..core.foreign import Foreign
from ..core.numbers import listed, shown
from ..core.placing import text_of
from .frames import orbits as orbits_of
from .taylor import SIX, Terms, of_columns, turn

WORDS = re.compile(r'"[^"]*"|\S+')
SERIES = re.compile(r"^\s*I\s+COEFFICIENT\s+ORDER\s+EXPONENTS", re.MULTILINE)
HEAD = re.compile(r"^\s*\S+\s*:\s*([RC]), NV =\s*(\d+)", re.MULTILINE)


EQUATIONS = "equations of a map are the text itself: iterated_map(path.read_text())"
"""What to do with other files that may be maps."""


def read_tfs(path: Path, advice: str = EQUATIONS) -> dict[str, np.ndarray]:
    """Return the columns of a TFS file by their names in small letters; other entries among numbers are NaN.

    advice: what to do with other files.
    """
    lines = [words for line in text_of(path).splitlines() if (words := WORDS.findall(line))]
    heads = {first: rest for first, *rest in lines if first in ("*", "$")}
    names = [word.lower() for word in heads.get("*", ())]
    formats = heads.get("$", ())
    rows = [words for words in lines if words[0] not in heads and words[0][0] not in "@#"]
    if not names or len(formats) != len(names):
        raise ValueError(f"{path} must be a TFS table with lines of * and $, or a damap of MAD-NG; {advice}")
    uneven = next((row for row in rows if len(row) != len(names)), None)
    if uneven is not None:
        raise ValueError(f"{path} must have {len(names)} entries in each row, got {shown(' '.join(uneven)[:80])}")
    columns = zip(*rows, strict=True) if rows else [()] * len(names)
    return {name: np.array([_read(w, kind) for w in c]) for name, kind, c in zip(names, formats, columns, strict=True)}


def _read(word: str, kind: str) -> Any:
    if kind.endswith("s"):
        return word.strip('"')
    try:
        return float(word)
    except ValueError:
        return np.nan


def orbits(path: Path, name: str, coordinates: tuple[str, ...] | None) -> Foreign | None:
    """Return the particles of a table of tracking: the last row of each turn, at the end of the sequence."""
    table = read_tfs(path, "of a CSV table give pandas.read_csv(path), coordinates=...")
    owner = next((entry for entry in ("number", "id") if entry in table), None)
    if owner is None or "turn" not in table:
        raise ValueError(f"{name} must be a table of tracking with turn, and number or id; it has {listed(table)}")
    wanted = coordinates or ("x", "y", "px", "py")
    keys = np.array([table[owner], table["turn"]])[:, ::-1]
    rows = keys.shape[1] - 1 - np.unique(keys, axis=1, return_index=True)[1]
    columns = {entry: table[entry.lower()][rows] for entry in wanted if entry.lower() in table}
    return orbits_of({**columns, "particle": table[owner][rows], "turn": table["turn"][rows]}, name, wanted)


def lattice(path: Path) -> str:
    """Return the map of one turn of a file, on momentum and about the closed orbit, as a text."""
    text = text_of(path)
    return turn(_series(text, path) if SERIES.search(text) else of_columns(read_tfs(path), f"{path}"))


def _series(text: str, path: Path) -> list[Terms]:
    """Return the rows x, px, y, py, t, pt that a damap has; terms of parameters are left out."""
    kinds = HEAD.findall(text)
    if not 4 <= len(kinds) <= len(SIX) or {kind for kind, _ in kinds} != {"R"}:
        raise ValueError(f"{path} must have 4 to 6 real series x, px, y, py, t, pt, got {len(kinds)} series")
    found: list[Terms] = []
    for part in HEAD.split(text)[3::3]:
        lines = (line.split() for line in part.splitlines() if re.match(r"\s*\d+\s+\S+E", line) and "^" not in line)
        found.append({tuple(map(int, entry[3:])): float(entry[1]) for entry in lines})
    return found
