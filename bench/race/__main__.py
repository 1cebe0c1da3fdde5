"""Run the race: make bench-peers, or PYTHONPATH=bench:tests python -m race --rows 'Section' to see some rows."""

from __future__ import annotations

import argparse
import re
from importlib.util import find_spec
from pathlib import Path


def main() -> None:
    """Run the rows asked for; the whole race is written to a folder, README and the site, some rows are printed."""
    parser = argparse.ArgumentParser(prog="race", description=__doc__)
    parser.add_argument("--rows", default="", help="only rows whose title matches this pattern, printed")
    parser.add_argument("--cells", type=int, default=None, help="cells along each axis of the frequency map")
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "results", help="folder of the results")
    options = parser.parse_args()
    if find_spec("heyoka") is None:
        parser.error("the truth needs heyoka: make peers")
    from . import grids, others, report, sections, signals
    from .contest import hold

    chosen = [
        row
        for module in (grids, sections, signals, others)
        for row in module.ROWS
        if re.search(options.rows, row.title)
    ]
    results = []
    for row in chosen:
        results.append((row, hold(row)))
        print(report.table(*results[-1]) + "\n", flush=True)
    if not options.rows:
        starts, grid = others.starts(), others.map_of_a_grid(options.cells or others.CELLS)
        print(report.started(starts, grid))
        report.write(results, starts, grid, options.out)


if __name__ == "__main__":
    main()
