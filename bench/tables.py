"""The tables of measurements of the site, all at one commit: make tables.

Runs the benchmarks that the rows of tables.md name, and the gate; writes their measurements to results/tables.json and
history/<version>.json, and each table between its marks. With --again it writes the tables from tables.json.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from pages import ROOT, put, stamp, where

BENCH = ROOT / "bench"
RECORD = BENCH / "results" / "tables.json"
PROGRAMS = ("fastaff", "numba", "numpy", "scipy", "heyoka", "nafflib")
FIELD = re.compile(r"\{(?:(\d)(?:-(\d))? )?([^{}:!]+)(!m)?(?::([^{}]*))?\}")
GATE = "gate"


class Row(NamedTuple):
    """A row: its benchmark, as pytest has it, or the gate; whether each parameter has a line; its cells, templates."""

    source: str
    each: bool
    cells: list[str]

    @property
    def command(self) -> str:
        """Command that measures this row."""
        return "`make gate`" if self.source == GATE else f"`pytest {self.source.partition('::')[0]} -s`"

    def lines(self, numbers: dict[str, list[dict]], *more: str) -> list[str]:
        """Return the lines of the row; KeyError if it was not measured."""
        found = numbers[self.source]
        text = "|".join(["", *self.cells, *(f" {entry} " for entry in more), ""])
        parts = [[entry] for entry in found] if self.each else [found]
        return [FIELD.sub(lambda field, part=part: filled(field, part), text) for part in parts]


def filled(field: re.Match[str], found: list[dict]) -> str:
    """Return the text of a field: a number of all parameters, or of some."""
    first, last, name, millions, kind = field.groups()
    some = found if first is None else found[int(first) : int(last or first) + 1]
    said = "; ".join(format(entry[name] / 1e6 if millions else entry[name], kind or "") for entry in some)
    return said.replace("%", " %")


class Table(NamedTuple):
    """A table: its page, the name of its marks, its heads and rows; a column of commands if the last head is that."""

    page: str
    name: str
    heads: list[str]
    rows: list[Row]

    def text(self, record: dict) -> str:
        """Return the table, the rows that were not measured, and the machine."""
        lines = ["|".join(["", *self.heads, ""]), "|" + "---|" * len(self.heads)]
        missing = []
        for row in self.rows:
            try:
                lines += row.lines(record["numbers"], *[row.command] * (self.heads[-1] == " command "))
            except KeyError:
                missing.append(row.cells[0].strip())
        left = [f"\nNot measured, as a program or a second core is missing: {'; '.join(missing)}."] if missing else []
        return "\n".join([*lines, *left, "", where(record["machine"], PROGRAMS)])


def tables() -> Iterator[Table]:
    """Yield the tables of tables.md."""
    for section in (BENCH / "tables.md").read_text().split("\n## ")[1:]:
        title, heads, _, *rows = (line for line in section.splitlines() if line)
        page, _, name = title.partition(": ")
        cells = [line.split("|")[1:-1] for line in (heads, *rows)]
        yield Table(page, name, cells[0] if cells[0][-1].strip() else cells[0][:-1], [*map(row_of, cells[1:])])


def row_of(cells: list[str]) -> Row:
    """Return a row: the last cell names its benchmark."""
    *each, name = cells[-1].split()
    file, _, test = name.partition("::")
    return Row(name if name == GATE else f"bench/test_{file}.py::test_{test}", bool(each), cells[:-1])


def measured() -> dict:
    """Run the gate and the benchmarks of all rows; return their measurements, with the machine."""
    import gate

    made_on = stamp()
    ratios, above = gate.measured()
    gate.write(BENCH / "history" / f"{made_on['fastaff']}.json", made_on, ratios, above)
    sources = dict.fromkeys(row.source for table in tables() for row in table.rows if row.source != GATE)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "numbers.json"
        subprocess.run([sys.executable, "-m", "pytest", *sources, "-s", "--numbers", path], cwd=ROOT, check=True)
        return {"machine": made_on, "numbers": {**json.loads(path.read_text()), GATE: [ratios]}}


def main() -> None:
    """Measure, unless that is done, and write."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--again", action="store_true", help=f"write the tables from {RECORD.name}")
    start = time.perf_counter()
    if not parser.parse_args().again:
        RECORD.write_text(json.dumps(measured(), indent=1, ensure_ascii=False) + "\n")
    record = json.loads(RECORD.read_text())
    for table in tables():
        put(table.page, table.name, table.text(record))
    print(f"{(time.perf_counter() - start) / 60:.1f} minutes")


if __name__ == "__main__":
    main()
