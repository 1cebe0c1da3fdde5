"""Import, first result with a warm cache, and cold compile, each in a fresh process. Run: pytest bench/test_startup.py
-s
"""

from __future__ import annotations

import os
import subprocess
import sys
import time

FIRST = """
import numpy as np, fastaff
z0 = np.array([1.5, 0, 0.3, 0, 0, 0.2, 0.1, 0.3])
body = fastaff.Body(fastaff.NeoHookean())
m = fastaff.poincare_map(body, z0, section=fastaff.AlphaTurning(), crossings=20, max_time=200.0)
f = fastaff.frequency_map(body, z0, time=200.0)
assert m.counts[0] == 20 and f.status[0] == 0
"""


def seconds(code: str, cache) -> float:
    """Return the wall time of a fresh process that runs the code with this cache folder."""
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "FASTAFF_CACHE_DIR": str(cache)})
    return time.perf_counter() - start


def test_startup(benchmark, tmp_path):
    """Time a fresh process: bare interpreter, import, first section and frequencies cold and warm."""
    bare, load = seconds("", tmp_path), min(seconds("import fastaff", tmp_path) for _ in range(3))
    cold = seconds(FIRST, tmp_path)
    warm = min(seconds(FIRST, tmp_path) for _ in range(3))
    benchmark.pedantic(seconds, args=("import fastaff", tmp_path), rounds=3)
    benchmark.extra_info.update(bare=bare, load=load, cold=cold, warm=warm)
    print(
        f"\nfresh process: bare {bare:.2f} s, import fastaff {load - bare:.2f} s more, first section and frequencies "
        f"{warm:.2f} s with a "
        f"warm cache, {cold:.1f} s with a cold one"
    )
