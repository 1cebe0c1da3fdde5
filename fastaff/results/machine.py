"""The machine and its programs, on which the speed and the bits of numbers depend."""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
import platform
import re
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numba

from ..core.numbers import free_memory
from ..engine.jit import config
from ..engine.numba_private import binding, get_host_cpu_features
from ..engine.threads import default_threads

WIDTHS = {"avx512f": 512, "avx2": 256, "avx": 256, "sve": 256, "neon": 128, "sse2": 128}
"""Bits of a vector register of instruction sets, the widest first."""
USERS = ("plot", "cli", "symbolic", "io", "dask", "notebook")
"""Extras for users; the others are for developers of the package."""


class Dependency(NamedTuple):
    """A package that fastaff uses: its version, None where it is missing; the least version allowed; the extra that
    installs it, None where the package is always installed.
    """

    name: str
    version: str | None
    least: str
    extra: str | None

    @property
    def wrong(self) -> str | None:
        """The fault of the package in words; None where there is none, or where it is optional and missing."""
        if self.version is None:
            return None if self.extra else f"{self.name} is missing: pip install fastaff"
        if _numbers(self.version) < _numbers(self.least):
            return f"{self.name} {self.version} is too old: pip install '{self.name}>={self.least}'"
        return None


def machine() -> dict[str, Any]:
    """Return processor, width of its vectors in bits, cores, threads and their layer (Python's own: kernels take units
    of work without the GIL), memory, versions.
    """
    return {
        "fastaff": sys.modules[__name__.partition(".")[0]].__version__,
        "python": platform.python_version(),
        "numba": numba.__version__,
        "numpy": importlib.metadata.version("numpy"),
        "platform": platform.platform(),
        "cpu": cpu_name(),
        "llvm_cpu": binding.get_host_cpu_name(),
        "vector_bits": vector_bits(),
        "cores": cores(),
        "threads": default_threads(),
        "threading_layer": "Python",
        "free_memory": free_memory(),
    }


def stamp(facts: dict[str, Any]) -> str:
    """Return the facts of a machine in one line."""
    return (
        f"fastaff {facts['fastaff']}, Python {facts['python']}, numba {facts['numba']}, numpy {facts['numpy']}; "
        f"{facts['cpu']} ({facts['llvm_cpu']}, {facts['vector_bits']} bit), {facts['cores']} cores, "
        f"{facts['threads']} threads; {facts['platform']}"
    )


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cpu_name() -> str:
    """Return the name of the processor, as far as the system tells it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def processor() -> str:
    """Return the target of machine code: the name of a processor and its instruction sets, as LLVM calls them; those of
    the environment where it sets another one for Numba (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES).
    """
    name = config.CPU_NAME
    features = config.CPU_FEATURES
    features = get_host_cpu_features() if features is None else features
    known = sorted(entry[1:] for entry in features.split(",") if entry.startswith("+"))
    return " ".join([binding.get_host_cpu_name() if name is None else name, *known])


def vector_bits() -> int:
    """Return the width of the widest vector registers that kernels may use; 64 where none is known."""
    features = binding.get_host_cpu_features()
    return next((bits for name, bits in WIDTHS.items() if features.get(name)), 64)


def dependencies() -> list[Dependency]:
    """Return the packages that fastaff and its extras for users need, as its metadata tells; none without metadata."""
    try:
        wanted = importlib.metadata.requires("fastaff") or []
    except importlib.metadata.PackageNotFoundError:
        return []
    found = []
    for line in wanted:
        name, least = re.match(r"([\w-]+)[^>;]*(?:>=([\d.]+))?", line).groups()  # type: ignore[union-attr]
        extra = re.search(r"extra == ['\"](\w+)['\"]", line)
        if name != "fastaff" and (extra is None or extra[1] in USERS):
            found.append(Dependency(name, _version(name), least or "0", extra and extra[1]))
    return found


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _numbers(version: str) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", version)][:3]
