"""Check every formula of the paper, as printed and as corrected, against independent numerics.

    python examples/paper_audit.py            prints the table; exit status 1 if a corrected formula fails
    python examples/paper_audit.py --csv F    writes it to F as well

Each line: label (the paper's, or section and words), relative residual as printed, residual as corrected ("same" where
the printed formula holds), verdict, statement and replacement. Residuals are the largest of three random
points, in 50 digits (formulas with a spectrum: in double). The paper: Martens, Slawianowski, "Affinely-Rigid Body and
Oscillatory Dynamical Models on GL(2,R)". Every formula is compared with matrix elements, actions by quadrature,
differences and matrix eigenproblems (examples/audit), never with another formula of the paper.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
from collections import Counter
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices of 200 rows: more threads only wait for each other

from audit import CHAPTERS
from audit.record import Finding, examine


def audit() -> list[Finding]:
    """Return the findings of all formulas, in the paper's order."""
    return [examine(formula) for chapter in CHAPTERS for formula in chapter]


def row(finding: Finding) -> tuple[str, ...]:
    """Return the columns of one finding."""
    formula = finding.formula
    if formula.sides is None:
        residuals = ("", "")
    else:
        residuals = (f"{finding.printed:.0e}", "same" if finding.corrected is None else f"{finding.corrected:.0e}")
    return formula.label, *residuals, finding.verdict, formula.says, formula.correct


def summary(findings: list[Finding]) -> str:
    """Return the numbers of formulas that hold, hold with a reading, are corrected, and are definitions."""
    count = Counter(finding.verdict for finding in findings)
    checked = len(findings) - count["definition"]
    return (
        f"{checked} formulas checked: {count['holds']} hold as printed, {count['holds with a reading']} hold with a "
        "reading, "
        f"{count['corrected']} are corrected, "
        f"{checked - sum(count[v] for v in ('holds', 'holds with a reading', 'corrected'))} fail; "
        f"{count['definition']} definitions and conventions have nothing to check."
    )


def main(arguments: list[str] | None = None) -> int:
    """Print the table and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--csv", type=Path, help="write the table to this file, too")
    options = parser.parse_args(arguments)
    findings, rows = [], []
    for chapter in CHAPTERS:
        print(f"\n{chapter.title}\n{'label':<46} {'printed':>8} {'corrected':>9}  {'verdict':<20} says -> correction")
        for formula in chapter:
            findings.append(examine(formula))
            rows.append(row(findings[-1]))
            label, printed, corrected, verdict, says, correct = rows[-1]
            print(
                f"{label:<46} {printed:>8} {corrected:>9}  {verdict:<20} {says}{' -> ' + correct if correct else ''}",
                flush=True,
            )
    print(f"\n{summary(findings)}")
    if options.csv:
        with options.csv.open("w", newline="") as file:
            csv.writer(file).writerows([("label", "printed", "corrected", "verdict", "says", "correction"), *rows])
    return int(any(finding.failed for finding in findings))


if __name__ == "__main__":
    sys.exit(main())
