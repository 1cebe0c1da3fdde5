"""`fastaff doctor`: what is installed, and a check."""

from __future__ import annotations

import platform
import sys
import time as clock
from pathlib import Path

import numpy as np

from ..progress import compiled


def doctor() -> int:
    """Say what is installed and where, and integrate one harmonic orbit as a check. Exit code 1 where the check
    fails.
    """
    import fastaff

    from ...base.provenance import provenance
    from ...compile.jit import cache_directory, cache_root
    from ...compile.threads import default_threads

    facts = provenance()
    folder = cache_directory()
    size = sum(f.stat().st_size for f in cache_root().rglob("*") if f.is_file()) / 2**20 if folder else 0.0
    writable = "writable" if folder else "NOT USED: not writable, or writable by others (set FASTAFF_CACHE_DIR)"
    rows = [
        ("fastaff", f"{facts['fastaff']}, {Path(fastaff.__file__).parent}"),
        ("Python", f"{facts['python']}, {sys.executable}"),
        *((name, _version(name)) for name in ("numba", "numpy", "scipy", "matplotlib", "cyclopts", "rich")),
        ("machine", f"{platform.platform()}, {facts['cpu']}"),
        ("cores", f"{facts['cores']} for this process; {default_threads()} threads unless told otherwise"),
        ("cache", f"{folder or cache_root()}: {writable}, {size:.0f} MiB with older versions"),
    ]
    for name, text in rows:
        print(f"{name:<12}{text}")
    error: list[float] = []

    def check() -> None:
        z0 = np.array([1.0, 0.0, 0.3, 0.0, 0.0, 0.5, 0.0, 0.2])
        end = fastaff.integrate(fastaff.Body(fastaff.Harmonic(C=1.0)), z0, time=2 * np.pi, step=0.02).z[:, 0]
        error.append(float(np.abs(end - z0).max()))

    start = clock.perf_counter()
    compiled("poincare", check)
    fine = error[0] < 1e-11
    verdict, seconds = "passed" if fine else "FAILED", clock.perf_counter() - start
    print(f"{'self-check':<12}{verdict}: a harmonic orbit returns after 2 pi to {error[0]:.1e}, in {seconds:.1f} s")
    return 0 if fine else 1


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return 'missing: pip install "fastaff[demo]"'
