"""`fastaff doctor`: the installed packages, the machine, and a check with its speed."""

from __future__ import annotations

import json
import os
import time as clock
import warnings
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...engine import packs
from ...results.progress import Compilation
from ..options import WRITTEN, Parameter
from ..progress import compiled
from ..stops import say

ORBITS = 2048
"""Orbits of the check."""

PERIODS = 4
"""Periods that the orbits run over."""

STEPS = 200
"""Steps of a period."""

TOLERANCE = 1e-11
"""Distance from their start to which harmonic orbits must return."""

LITTLE = 256 * 2**20
"""Bytes of free memory below which sections of thousands of orbits do not fit."""


def doctor(*, as_json: Annotated[bool, Parameter(name="--json", group=WRITTEN)] = False) -> int:
    """Print the installed packages and the machine, and check a small computation with a known answer and its speed.

    The last line is a stamp of the machine for reports. For each problem the command prints a sentence and ends with
    exit code 1: an old dependency, a cache that cannot be written, little memory, a wrong result.

    Parameters
    ----------
    as_json
        Print all as JSON instead.
    """
    facts, wrong = examined()
    if as_json:
        print(json.dumps({**facts, "wrong": wrong}))
    else:
        print("\n".join(f"{name:<14}{text}" for name, text in _rows(facts)))
    for sentence in wrong:
        say(sentence)
    return 1 if wrong else 0


def examined() -> tuple[dict[str, Any], list[str]]:
    """Return the facts about installation and machine, and a sentence for each problem."""
    import fastaff

    from ...results.machine import dependencies, machine, stamp

    needed = dependencies()
    cache = _cache()
    check = _check()
    facts = machine()  # after the check, which starts the threads
    wrong = [sentence for entry in needed if (sentence := entry.wrong)]
    if cache["problem"]:
        wrong.append(cache["problem"])
    if facts["free_memory"] < LITTLE:
        wrong.append(f"only {facts['free_memory'] / 2**20:.0f} MiB of memory are free")
    if not check["error"] < TOLERANCE:
        wrong.append(
            f"the check failed: harmonic orbits return to {check['error']:.1e} after {PERIODS} periods, not to "
            f"{TOLERANCE:.0e}; please report it with this output"
        )
    installed = {entry.name: entry.version for entry in needed}
    extras = {entry.name: entry.extra for entry in needed}
    place = str(Path(fastaff.__file__).parent)
    found = {**facts, "folder": place, "versions": installed, "extras": extras, "cache": cache, "check": check}
    return {**found, "stamp": stamp(facts)}, wrong


def _cache() -> dict[str, Any]:
    """Return folder and size of the compile cache, and its problem if there is one."""
    from ...engine.code_folder import cache_directory, cache_root

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        cache_directory.cache_clear()
        folder = cache_directory()
    size = sum(file.stat().st_size for file in cache_root().rglob("*") if file.is_file()) if folder else 0
    problem = str(said[0].message) if said else None
    writable = folder is not None and os.access(folder, os.W_OK)
    return {
        "folder": str(folder or cache_root()),
        "bytes": size,
        "used": folder is not None,
        "writable": writable,
        "problem": problem,
    }


def _check() -> dict[str, Any]:
    """Integrate harmonic orbits over whole periods; return the error, seconds until the first result and steps/s."""
    import fastaff

    from ...engine.cache import CodeCache
    from ...engine.code_folder import prebuilt

    body = fastaff.Body(fastaff.Harmonic(C=1.0))
    start = np.array([1.0, 0.0, 0.3, 0.0, 0.0, 0.5, 0.0, 0.2])
    z0 = start[:, None] * np.linspace(0.5, 1.5, ORBITS)
    period = 2 * np.pi
    compilation = Compilation()
    seconds = []
    error = []

    def run() -> None:
        for _ in range(3):
            begin = clock.perf_counter()
            end = fastaff.integrate(body, z0, time=PERIODS * period, step=period / STEPS, scheme=fastaff.KAHAN_LI8).z
            seconds.append(clock.perf_counter() - begin)
            error.append(float(np.abs(end - z0).max()))

    compiled(run)
    steps = ORBITS * PERIODS * STEPS
    rate = steps / min(seconds[1:])
    pack = prebuilt() if CodeCache.prebuilt else None
    wheel = packs.FOLDER / "built.json"
    kernels = "compiled here"
    if pack is not None:
        kernels = f"prebuilt {pack.level.name}"
    elif prebuilt() is None and wheel.is_file():
        kernels += f"; the wheel has machine code for {_built(json.loads(wheel.read_text()))}"
    return {
        "error": max(error),
        "first_result": seconds[0],
        "was_cached": not compilation.begins,
        "kernels": kernels,
        "orbit_steps_per_second": rate,
    }


def _built(versions: dict[str, str]) -> str:
    """Return for which versions and processors a wheel has machine code."""
    named = ", ".join(f"{name} {version}" for name, version in versions.items())
    return f"{named} and processors of {' or '.join(reversed(packs.LEVELS))}"


def _rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    cache = facts["cache"]
    check = facts["check"]
    rows = [("fastaff", f"{facts['fastaff']}, {facts['folder']}"), ("Python", facts["python"])]
    for name, version in facts["versions"].items():
        extra = facts["extras"][name]
        missing = f'missing, optional: pip install "fastaff[{extra}]"' if extra else "MISSING: pip install fastaff"
        rows.append((name, missing if version is None else f"{version}{f'  ({extra})' if extra else ''}"))
    verdict = "passed" if check["error"] < TOLERANCE else "FAILED"
    if cache["writable"]:
        state = "writable"
    elif cache["used"]:
        state = "read only"
    else:
        state = "NOT USED"
    ready = "nothing to compile" if check["was_cached"] else "compiling"
    return [
        *rows,
        ("machine", f"{facts['platform']}, {facts['cpu']}, vectors of {facts['vector_bits']} bit"),
        ("cores", f"{facts['cores']} for this process; {facts['threads']} threads of {facts['threading_layer']}'s own"),
        ("memory", f"{facts['free_memory'] / 2**30:.1f} GiB free"),
        (
            "cache",
            f"{cache['folder']}: {state}, {cache['bytes'] / 2**20:.0f} MiB with older versions",
        ),
        ("kernels", check["kernels"]),
        (
            "self-check",
            f"{verdict}: {ORBITS} harmonic orbits return after {PERIODS} periods to {check['error']:.1e}; first result "
            f"after {check['first_result']:.1f} s ({ready}), then {check['orbit_steps_per_second'] / 1e6:.0f} million "
            "orbit-steps/s",
        ),
        ("stamp", facts["stamp"]),
    ]
