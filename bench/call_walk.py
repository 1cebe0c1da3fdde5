"""Files and functions of the package that one warm call of a verb enters.

A reader who follows a call through the code opens these files. Each verb is called twice on two orbits of the
Hénon-Heiles system, on one thread and otherwise with its defaults. `sys.setprofile` watches the second call. Compiled
kernels are not Python functions and are not counted.

Run: python bench/call_walk.py [VERB ...]             one line for each verb
     python bench/call_walk.py --list [VERB ...]      the files and functions too, in the order of their first call
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple

os.environ["FASTAFF_PROGRESS"] = "0"  # a progress line would be counted on a terminal only

import numpy as np

import fastaff as fa

PACKAGE = Path(fa.__file__).parent
STARTS = np.array([[0.0, 0.0], [0.1, 0.12], [0.35, 0.3], [0.1, 0.1]])
"""Two orbits of the Hénon-Heiles system, an axis for each of x, y, px, py and then one for the orbits."""

RUN: dict[str, Any] = {"time": 100.0, "threads": 1}
CUT: dict[str, Any] = {"section": "x=0", "crossings": 8, "max_time": 100.0, "threads": 1}

VERBS: dict[str, Callable[[], Any]] = {
    "integrate": lambda: fa.integrate(fa.HenonHeiles(), STARTS, **RUN),
    "poincare_map": lambda: fa.poincare_map(fa.HenonHeiles(), STARTS, **CUT),
    "frequency_map": lambda: fa.frequency_map(fa.HenonHeiles(), STARTS, **RUN),
    "chaos_map": lambda: fa.chaos_map(fa.HenonHeiles(), STARTS, **RUN),
}
"""The calls that are counted, by the name of their verb."""

PARTS = {"<genexpr>", "<listcomp>", "<dictcomp>", "<setcomp>", "<module>"}
"""Frames that are no functions. Newer versions of Python have no frame for a comprehension."""


class Walk(NamedTuple):
    """What one call enters."""

    calls: Counter[CodeType]
    """How often each function of the package is called, in the order of the first calls."""
    deepest: int
    """The largest number of functions of the package that wait for one another."""

    def files(self) -> dict[str, list[CodeType]]:
        """Return the functions of each file, both in the order of the first calls."""
        found: dict[str, list[CodeType]] = {}
        for code in self.calls:
            found.setdefault(str(Path(code.co_filename).relative_to(PACKAGE)), []).append(code)
        return found


def walked(call: Callable[[], Any]) -> Walk:
    """Return what the second of two calls enters: the first one compiles and fills caches."""
    call()
    calls: Counter[CodeType] = Counter()
    inside = str(PACKAGE) + os.sep
    depth = 0
    deepest = 0

    def watch(frame: FrameType, event: str, _: Any) -> None:
        nonlocal depth, deepest
        code = frame.f_code
        if event not in ("call", "return") or code.co_name in PARTS or not code.co_filename.startswith(inside):
            return
        if event == "call":
            calls[code] += 1
            depth += 1
            deepest = max(deepest, depth)
        else:
            depth -= 1

    sys.setprofile(watch)
    try:
        call()
    finally:
        sys.setprofile(None)
    return Walk(calls, deepest)


def main(verbs: list[str], list_all: bool) -> None:
    """Print a line for each verb and, if asked for, its files and functions."""
    print(f"{'verb':15}{'files':>7}{'functions':>11}{'calls':>7}{'depth':>7}")
    for verb in verbs:
        walk = walked(VERBS[verb])
        files = walk.files()
        print(f"{verb:15}{len(files):7}{len(walk.calls):11}{walk.calls.total():7}{walk.deepest:7}")
        if list_all:
            for name, codes in files.items():
                print(f"    {name}")
                for code in codes:
                    print(f"        {walk.calls[code]:5} x {code.co_qualname}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("verbs", nargs="*", metavar="VERB", help=f"of {', '.join(VERBS)}; all when none is named")
    parser.add_argument("--list", action="store_true", help="list the files and functions too")
    given = parser.parse_args()
    unknown = [verb for verb in given.verbs if verb not in VERBS]
    if unknown:
        parser.error(f"VERB must be one of {', '.join(VERBS)}, got {', '.join(unknown)}")
    main(given.verbs or list(VERBS), given.list)
