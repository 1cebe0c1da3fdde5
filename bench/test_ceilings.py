"""Kernels beside the ceilings of the machine, on one thread. Run: pytest bench/test_ceilings.py -s

Operations are counted, not guessed: the text that is compiled (`fastaff.engine.source`) runs once with numbers that
count their operations. An expression computed twice counts once, one of the parameters alone not at all, as a compiler
moves it out of the loop; signs are free. A number of a lane is loaded once and stored once a loop. A fused multiply-add
is one operation of the multipliers and two flops; the forces of the systems here need no transcendental function.

The ceiling of a kernel is the longest time of its operations, each kind by itself: multipliers and adders, divider,
loads, stores. It has no latency, no loop, no call and no checks of the orbits; the measured time has all of these, as
it is that of whole calls of `integrate`.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from typing import ClassVar

import numba
import numpy as np
import pytest
from common import alternating, henon_heiles_orbits, hyperelastic_orbits

from fastaff import Body, HenonHeiles, Hyperelastic, NeoHookean, hamiltonian, integrate
from fastaff.engine import source
from fastaff.engine.fused import fma
from fastaff.engine.jit import LANES
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, BLANES_MOAN6, SOFRONIOU_SPALETTA10

ORBITS, STEP = 1024, 0.02
CHAINS, VECTOR = 12, 8
"""Independent chains of operations, enough to hide their latency; ceilings are given per so many numbers."""


# ---------------------------------------------------------------------------------------------------- the machine


def _room(rows: int) -> np.ndarray:
    """Return ones (rows*LANES,) from the beginning of a cache line."""
    whole = np.ones(rows * LANES + 8)
    first = -whole.ctypes.data % 64 // 8
    return whole[first : first + rows * LANES]


def _loop(lines: list[str]) -> object:
    names = {"fma": fma, "np": np}
    body = "".join(f"            {line}\n" for line in lines)
    exec(f"def run(z, a, b, times):\n    for _ in range(times):\n        for i in range({LANES}):\n{body}", names)
    return numba.njit(names["run"], error_model="numpy")


def _chains(operation: str, rounds: int) -> object:
    """Return the loop that does an operation on x so many times, in CHAINS rows of numbers."""
    lines = [f"x{r} = z[{r * LANES} + i]" for r in range(CHAINS)]
    lines += [re.sub(r"\bx\b", f"x{r}", operation) for _ in range(rounds) for r in range(CHAINS)]
    return _loop(lines + [f"z[{r * LANES} + i] = x{r}" for r in range(CHAINS)])


def _loads() -> object:
    return _loop([f"z[i] = {' + '.join(f'z[{r * LANES} + i]' for r in range(CHAINS))}"])


def _copies() -> object:
    """Return the loop that moves all rows on by one: LLVM leaves out values that are only stored again and again."""
    lines = [f"x{r} = z[{r * LANES} + i]" for r in range(CHAINS)]
    return _loop(lines + [f"z[{(r + 1) % CHAINS * LANES} + i] = x{r}" for r in range(CHAINS)])


LOOPS = {
    "multiply": (_chains("x = x * a", 12), 12 * CHAINS),
    "add": (_chains("x = x + b", 12), 12 * CHAINS),
    "fused multiply-add": (_chains("x = fma(x, a, b)", 12), 12 * CHAINS),
    "multiply, add": (_chains("x = x * a + b", 12), 12 * CHAINS),
    "divide": (_chains("x = a / x", 6), 6 * CHAINS),
    "square root": (_chains("x = np.sqrt(x)", 6), 6 * CHAINS),
    "load": (_loads(), CHAINS),
    "load, store": (_copies(), CHAINS),
}


def _ceilings(repeats: int) -> dict[str, float]:
    """Return nanoseconds that an operation takes for VECTOR numbers: the shortest processor times of some in turns."""
    z, times = _room(CHAINS), {name: 2_000_000 // operations for name, (_, operations) in LOOPS.items()}

    def of(name, loop):
        def run():
            z[:] = 1.0
            loop(z, 1.0 - 1e-9, 1e-9, times[name])

        return run

    _, took = alternating({name: of(name, loop) for name, (loop, _) in LOOPS.items()}, repeats=repeats)
    return {name: took[name] / (times[name] * LOOPS[name][1] * LANES / VECTOR) * 1e9 for name in LOOPS}


@pytest.fixture(scope="module")
def ceilings():
    """Ceilings in nanoseconds per operation on VECTOR numbers."""
    return _ceilings(15)


def test_machine(numbers, ceilings):
    """Nanoseconds for 8 numbers."""
    numbers.update(ceilings)


# ------------------------------------------------------------------------------------------------------- counting


class Number:
    """A number that counts operations: the same operation on the same numbers gives the same number."""

    known: ClassVar[dict] = {}
    counts: ClassVar[Counter] = Counter()

    def __init__(self, constant: bool):
        self.constant = constant

    @classmethod
    def of(cls, kind: str, *numbers: object) -> Number:
        """Return the result of an operation, counted where it is a new one and numbers of lanes enter."""
        ids = [("number", id(x)) if isinstance(x, Number) else ("constant", x) for x in numbers]
        key = (kind, *(sorted(ids, key=str) if kind in ("multiply", "add") else ids))
        if key not in cls.known:
            constant = all(not isinstance(x, Number) or x.constant for x in numbers)
            cls.known[key] = cls(constant), numbers  # which are kept, so that their ids are theirs
            cls.counts[kind] += not constant
        return cls.known[key][0]

    def __mul__(self, other):
        return self.of("multiply", self, other)

    def __add__(self, other):
        return self.of("add", self, other)

    def __sub__(self, other):
        return self.of("subtract", self, other)

    def __rsub__(self, other):
        return self.of("subtract", other, self)

    def __truediv__(self, other):
        exact = isinstance(other, (int, float)) and abs(math.frexp(other)[0]) == 0.5
        return self * (1 / other) if exact else self.of("divide", self, other)

    def __rtruediv__(self, other):
        return self.of("divide", other, self)

    def __pow__(self, power):
        if power != int(power) or not 2 <= power <= 4:
            raise TypeError(f"power {power} is not counted")
        square = self * self
        return square if power == 2 else square * (self if power == 3 else square)

    def __neg__(self):
        return self.of("sign", self)

    def __gt__(self, other):
        self.of("compare", self, other)
        return True

    def sqrt(self):
        """Return the square root, which np.sqrt asks for."""
        return self.of("root", self)

    __rmul__, __radd__ = __mul__, __add__


class Memory:
    """Rows of a block: loads and stores are counted; values in registers are not loaded again."""

    def __init__(self):
        self.registers: dict = {}
        self.stored: set = set()

    def __getitem__(self, index):
        if index not in self.registers:
            self.registers[index] = Number(False)
            Number.counts["load"] += 1
        return self.registers[index]

    def __setitem__(self, index, number):
        self.registers[index] = number
        Number.counts["store"] += index not in self.stored
        self.stored.add(index)


def _of_numbers(value: object) -> object:
    """Return a model with constants that count for its parameters."""
    return type(value)(*(_of_numbers(x) if hasattr(x, "_fields") else Number(True) for x in value))


def _count(model: object, scheme: object, steps: int) -> Counter:
    text = source(model, "precise_splitting" if scheme.increments else "splitting")
    text = re.sub(r"\n    value = .*\n", "\n", text)
    memories = Memory(), Memory()

    def one_lane(end):
        if end == "lanes":
            for memory in memories:
                memory.__init__()
            return [0]
        return range(end)

    names = {
        "value": _of_numbers(model),
        "range": one_lane,
        "fma": lambda a, b, c: Number.of("fused", a, b, c),
    }
    exec(text, names)
    Number.known, Number.counts = {}, Counter()
    tables = [np.array([Number(True) for _ in table], object) for table in (scheme.drift_array, scheme.kick_array)]
    run = names[re.search(r"def (\w+)", text)[1]]
    run(None, "lanes", *tables, memories[0], steps, memories[1])
    return Number.counts


def operations(model: object, scheme: object) -> Counter:
    """Return the operations of one step of one orbit among others, with the look at the domain."""
    more = _count(model, scheme, 3)
    more.subtract(_count(model, scheme, 2))
    return more


def ceiling(counts: Counter, took: dict[str, float]) -> tuple[float, str]:
    """Return the least nanoseconds for a step of one orbit, and the kind of operation that sets them."""
    multiplied, added = _flops(counts)
    together = took["multiply"] + took["add"] - took["multiply, add"]  # the time saved by two ports
    arithmetic = counts["multiply"] * took["multiply"] + counts["fused"] * took["fused multiply-add"]
    arithmetic += added * took["add"] - min(multiplied, added) * max(together, 0.0)
    limits = {
        "arithmetic": arithmetic,
        "divider": counts["divide"] * took["divide"] + counts["root"] * took["square root"],
        "loads": counts["load"] * took["load"],
        "stores": counts["store"] * took["load, store"],
    }
    limit = max(limits, key=limits.__getitem__)
    return limits[limit] / VECTOR, limit


def _flops(counts: Counter) -> tuple[int, int]:
    return counts["multiply"] + counts["fused"], counts["add"] + counts["subtract"] + counts["compare"]


# ------------------------------------------------------------------------------------------------------ the kernels


def kepler_orbits(orbits: int) -> np.ndarray:
    """Return z0 (4, orbits) near the circle of radius 1."""
    return np.array([[1.0], [0.0], [0.0], [1.0]]) + 0.05 * np.random.default_rng(2).standard_normal((4, orbits))


SYSTEMS = {
    "neo-Hookean": (Body(NeoHookean(1.0, 2.0)), hyperelastic_orbits, 16000),
    "EQ2.2h": (Body(Hyperelastic(1.0)), hyperelastic_orbits, 16000),
    "Hénon-Heiles": (HenonHeiles(), henon_heiles_orbits, 48000),
    "Kepler": (hamiltonian("-1/sqrt(x**2 + y**2)"), kepler_orbits, 24000),
    "logarithmic": (hamiltonian("log(x**2 + y**2/b + c)/2", b=0.81, c=0.01), kepler_orbits, 32000),
}
SCHEMES = [BLANES_MOAN6, BLANES_CASAS_ESCORIHUELA8, SOFRONIOU_SPALETTA10]


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("system", SYSTEMS)
def test_share_of_the_ceiling(numbers, ceilings, system, scheme):
    """Time of a step of one orbit in a call of `integrate`, beside its ceiling."""
    model, orbits, steps = SYSTEMS[system]
    z0 = orbits(ORBITS)

    def run():
        return integrate(model, z0, time=steps * STEP, step=STEP, scheme=scheme, threads=1)

    results, cost = alternating({"run": run}, repeats=5)
    result, took = results["run"], cost["run"] / (ORBITS * steps) * 1e9
    counts = operations(model, scheme)
    least, limit = ceiling(counts, ceilings)
    multiplied, added = _flops(counts)
    flops = multiplied + added + counts["fused"] + counts["divide"] + counts["root"]
    numbers.update({name: counts[name] for name in ("fused", "divide", "root", "load", "store")})
    numbers.update(system=system, scheme=scheme.name, flops=flops, multiplied=multiplied, added=added)
    numbers.update(ceiling=least, limit=limit, ns=took, share=least / took, energy_error=result.energy_error.max())
    assert result.energy_error.max() < 1e-6
