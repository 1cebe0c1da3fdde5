"""Text of benchmarks in pages: blocks between two marks, and the line with the machine and versions of numbers."""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
from collections.abc import Sequence
from datetime import date
from functools import cache
from pathlib import Path

from fastaff.results.machine import machine

ROOT = Path(__file__).parents[1]
PROGRAMS = (
    *("fastaff", "numba", "numpy", "scipy", "heyoka", "pynamicalsys"),
    *("gala", "nafflib", "rebound", "PyNAFF"),
)


@cache
def version(program: str) -> str | None:
    """Return the version of an installed program, None where there is none."""
    try:
        return importlib.metadata.version(program)
    except importlib.metadata.PackageNotFoundError:
        return None


def stamp() -> dict:
    """Return the conditions of the numbers: processor, cores, versions, commit, date."""
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True)
    return {
        **machine(),
        "versions": {name: version(name) for name in PROGRAMS},
        "commit": commit.stdout.strip(),
        "date": date.today().isoformat(),
    }


def where(made_on: dict, programs: Sequence[str] = PROGRAMS) -> str:
    """Return a stamp in one line."""
    versions = [f"{name} {made_on['versions'][name]}" for name in programs if made_on["versions"][name]]
    return (
        f"{made_on['cpu']} ({made_on['llvm_cpu']}), {made_on['cores']} cores, {made_on['vector_bits']} bit; "
        f"Python {made_on['python']}, {', '.join(versions)}; commit {made_on['commit']}, {made_on['date']}."
    )


def between(text: str, name: str) -> tuple[str, str, str]:
    """Return the text of a page before, between and after the marks `<!-- name: written by a command -->` and
    `<!-- end of name -->`.
    """
    before, first, rest = re.split(f"(<!-- {name}: written by .* -->\n)", text)
    block, end, after = rest.partition(f"<!-- end of {name} -->")
    if not end:
        raise ValueError(f"there is no end of {name}")
    return before + first, block, end + after


def put(page: str, name: str, block: str) -> None:
    """Replace the text of a page, named from the root, between its marks of that name."""
    path = ROOT / page
    before, _, after = between(path.read_text(), name)
    path.write_text(f"{before}\n{block.strip()}\n\n{after}")
