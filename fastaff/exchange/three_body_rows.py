"""Rows of published tables of three bodies: text, or rows of HTML."""

from __future__ import annotations

import re

NUMBER = re.compile(r"-?\d+\.\d{2,}(?:[eE][-+]?\d+)?")
"""Velocities, periods and scaled periods, but no numbers of orbits and no masses of one digit."""


def rows_of(text: str, m3: float) -> list[list[float]]:
    """Return the numbers of each row that has three or more, and no other mass in parentheses than m3."""
    pieces = text.split("<tr>") if "<tr>" in text else text.splitlines()
    masses = [re.search(r"\((\d+(?:\.\d+)?)\)", piece) for piece in pieces]
    kept = [piece for piece, mass in zip(pieces, masses, strict=True) if mass is None or float(mass[1]) == m3]
    return [found for found in ([float(word) for word in NUMBER.findall(piece)] for piece in kept) if len(found) > 2]
