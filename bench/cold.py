"""Cost of first calls: the first of each kind, one after another, in fresh processes, with an empty cache and with the
cache that they leave. Run: make bench-cold.

The unit of the gate is the compilation of one plain loop by Numba in the same process, so that machines may differ.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BENCH = Path(__file__).parent
FIRST = ("import", "section", "frequency map", "chaos map", "formula")
"""The calls, in their order: each compiles the functions that no call before it has compiled."""


def calls() -> dict[str, list[float]]:
    """Return the processor and wall time of each of FIRST, and of the loop, in this process."""
    seconds: dict[str, list[float]] = {}

    def timed(name, call):
        before = time.process_time(), time.perf_counter()
        call()
        seconds[name] = [time.process_time() - before[0], time.perf_counter() - before[1]]

    timed("import", lambda: __import__("fastaff"))
    import numpy as np

    import fastaff as fa

    body, plane = fa.Body(fa.NeoHookean()), np.array([0.0, 0.1, 0.4, 0.14])
    start = np.array([1.5, 0, 0.3, 0, 0, 0.2, 0.1, 0.3])
    cut = {"crossings": 20, "max_time": 200.0}
    timed("section", lambda: fa.poincare_map(body, start, section=fa.AlphaTurning(), **cut))
    timed("frequency map", lambda: fa.frequency_map(body, start, time=200.0))
    timed("chaos map", lambda: fa.chaos_map(body, start, time=200.0))
    own = "(x**2 + y**2)/2 + 0.3*x**2*y - y**3/10"
    timed("formula", lambda: fa.poincare_map(fa.hamiltonian(own), plane, section="x=0", **cut))
    from common import naive_hyperelastic

    scheme = fa.KAHAN_LI8
    arguments = np.ones((8, 1)), 1.0, 1.0, scheme.drift_array, scheme.kick_array, 0.05, 1
    timed("loop", lambda: naive_hyperelastic(*arguments))
    return seconds


def measured() -> tuple[dict[str, list[float]], dict[str, list[float]], int]:
    """Return the times with an empty cache and with the one that this leaves, and its bytes."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "FASTAFF_CACHE_DIR": cache, "NUMBA_CACHE_DIR": cache}

        def run():
            code = "import cold, json; print(json.dumps(cold.calls()))"
            said = subprocess.run([sys.executable, "-c", code], cwd=BENCH, env=environment, check=True, text=True,
                                  stdout=subprocess.PIPE)  # fmt: skip
            return json.loads(said.stdout)

        cold, warm = run(), run()
        return cold, warm, sum(path.stat().st_size for path in Path(cache).rglob("*.code"))


def main() -> None:
    """Print the times."""
    cold, warm, size = measured()
    print("first call of a fresh process, seconds  cold: processor   wall   warm: processor   wall")
    for name in FIRST:
        print(f"{name:38s} {cold[name][0]:15.2f} {cold[name][1]:6.2f} {warm[name][0]:17.2f} {warm[name][1]:6.2f}")
    print(f"machine code kept: {size / 2**20:.2f} MiB; one plain loop compiles in {cold['loop'][0]:.2f} s")


if __name__ == "__main__":
    main()
