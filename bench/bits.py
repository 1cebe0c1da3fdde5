"""Checksums of results to compare before and after a change that must not touch a bit.

All rows of the table of promises, all calls of the battery, and the systems of other kinds. Run:
python bench/bits.py FILE writes them to a new file, and lists the differences from an older one (rc 1).
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import battery
from test_promises import ROWS

import fastaff as fa
from fastaff.systems.models.sections import Stroboscopic

Z2 = np.array([np.linspace(0.05, 0.6, 140), np.linspace(0.3, 0.1, 140)])
Z4 = np.concatenate([Z2, 0.5 * Z2[::-1]])
TIME = {"time": 100.0}


def systems() -> Iterator[tuple[str, Any, np.ndarray, Any]]:
    """Return systems of the other kinds, by name: the model, starts, and a section (None: each iterate)."""
    plane = fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
    quartic = "(x**2 + y**2)/2 + x**2*y**2 - 0.1*y**3"
    yield "potential", fa.hamiltonian(quartic), Z4, plane
    yield "turning", fa.hamiltonian(quartic, rotation=0.3), Z4, plane
    driven = fa.hamiltonian("x**2/2 + x**4/4 + 0.3*x*cos(t)", coordinates="x", drive_period="2*pi")
    yield "driven", driven, Z2, Stroboscopic(0.7)
    yield "damped", fa.hamiltonian(quartic, friction=0.01), Z4, plane
    yield "map", fa.models.HenonMap(0.2054), 0.3 * Z2, None
    yield "map of two planes", fa.models.OneTurnMap(nu_x=0.2103, nu_y=0.3087, octupole=0.3), 0.2 * Z4, None


def rows() -> Iterator[tuple[str, Any]]:
    """Return calls without arguments, by name."""
    for name, row in ROWS.items():
        yield f"promise {name}", row
    for name in battery.CALLS:
        yield f"battery {name}", lambda name=name: battery.call(name, battery.base(name))
    for name, model, z0, section in systems():
        yield f"{name}: integrate", lambda m=model, z=z0: fa.integrate(m, z, **TIME, samples=4)
        yield f"{name}: chaos", lambda m=model, z=z0: fa.chaos_map(m, z, **TIME, indicators="megno,sali")
        if name != "damped":
            yield f"{name}: frequencies", lambda m=model, z=z0: fa.frequency_map(m, z, time=256.0)
        if section is not None:
            cut = {"section": section, "crossings": 8} | ({} if name == "driven" else {"max_time": 200.0})
            yield f"{name}: section", lambda m=model, z=z0, cut=cut: fa.poincare_map(m, z, **cut)


def fold(value: Any, into: Any) -> None:
    """Add a value to a checksum: arrays and numbers to the bit."""
    if isinstance(value, (np.ndarray, np.generic, float)):
        array = np.asarray(value)
        into.update(f"{array.dtype}{array.shape}".encode())
        into.update(np.ascontiguousarray(array).tobytes() if array.dtype != object else repr(array.tolist()).encode())
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            into.update(field.name.encode())
            fold(getattr(value, field.name), into)
    elif isinstance(value, (tuple, list)):
        for entry in value:
            fold(entry, into)
    elif hasattr(value, "keys"):
        for key in value:
            into.update(str(key).encode())
            fold(value[key], into)
    elif isinstance(value, (str, bytes, int, complex, type(None))):
        into.update(repr(value).encode())


def checksums() -> dict[str, str]:
    """Return the checksum of each row."""
    found = {}
    for name, call in rows():
        digest = hashlib.sha256()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fold(call(), digest)
        found[name] = digest.hexdigest()[:16]
    return found


def main(path: Path) -> int:
    """Write the checksums, or compare with those that the file has."""
    now = checksums()
    if not path.exists():
        path.write_text(json.dumps(now, indent=1) + "\n")
        print(f"{len(now)} checksums in {path}")
        return 0
    before = json.loads(path.read_text())
    changed = [name for name in before if now.get(name) != before[name]]
    print(f"{len(changed)} of {len(before)} checksums differ", *changed, sep="\n")
    return bool(changed)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
