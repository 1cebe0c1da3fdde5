"""Wall time of calls on sets of orbits, with their defaults, by one thread to all: `python bench/threads.py [ORBITS]`.

For each call and number of threads: seconds, how many times as fast as one thread, the serial share s by which
Amdahl's law, 1/(s + (1 - s)/threads), says so, and the share of all processor time that the main thread takes, which
other work on the machine hardly changes. Results have the same bits, which is checked. Beside it stands the most that
the machine gives: so many processes, which share nothing, make the call at the same time, each with one thread.
"""

from __future__ import annotations

import multiprocessing
import sys
import time

import numpy as np
from common import NEO, hyperelastic_orbits, mixed_orbits

import fastaff as fa
from fastaff import models
from fastaff.engine.threads import available_threads

PLANE, AXIS = fa.HenonHeiles(), fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
TIMES = 3
"""Runs of which the shortest counts."""


def calls(orbits: int) -> dict:
    """Return the calls on so many orbits, by name: functions of the number of threads that return an array."""
    plane = np.tile(mixed_orbits(250), (1, -(-orbits // 1000)))[:, :orbits]
    body = hyperelastic_orbits(orbits)
    ring = models.HenonMap(0.2114)
    turns = 0.1 * np.random.default_rng(0).standard_normal((2, orbits))
    samples = fa.integrate(ring, turns, time=1024, samples=1024).samples
    return {
        "integrate, Hénon-Heiles": lambda n: fa.integrate(PLANE, plane, time=200.0, threads=n).z,
        "integrate, neo-Hookean": lambda n: fa.integrate(NEO, body, time=50.0, threads=n).z,
        "poincare_map, Hénon-Heiles": lambda n: (
            fa.poincare_map(PLANE, plane, section=AXIS, crossings=100, max_time=1e3, threads=n).points
        ),
        "chaos_map, Hénon-Heiles": lambda n: fa.chaos_map(PLANE, plane, time=400.0, threads=n).values,
        "frequency_map, Hénon-Heiles": lambda n: fa.frequency_map(PLANE, plane, time=400.0, threads=n).nu,
        "frequency_map, neo-Hookean": lambda n: fa.frequency_map(NEO, body, time=100.0, threads=n).nu,
        "frequency_map, a map": lambda n: fa.frequency_map(ring, turns, time=2048, threads=n).nu,
        "tunes of 1024 turns": lambda n: fa.tunes(samples, threads=n).nu,
    }


def machine(run, processes: int, alone: float) -> float:
    """Return how many times one thread's work so many processes do, each of which makes the call with one thread."""
    fork = multiprocessing.get_context("fork")
    best = np.inf
    for _ in range(TIMES):
        gate = fork.Barrier(processes + 1)

        def work(gate=gate):
            run(1)
            gate.wait()
            run(1)
            gate.wait()

        workers = [fork.Process(target=work) for _ in range(processes)]
        for worker in workers:
            worker.start()
        gate.wait()
        begin = time.perf_counter()
        gate.wait()
        best = min(best, time.perf_counter() - begin)
        for worker in workers:
            worker.join()
    return processes * alone / best


def main() -> None:
    orbits = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
    counts = [n for n in (1, 2, 4, 8, 16, 32, 64) if n <= available_threads()]
    for name, run in calls(orbits).items():
        first, alone = run(counts[-1]), 0.0
        for n in counts:
            best = main = np.inf
            for _ in range(TIMES):
                begin, own, every = time.perf_counter(), time.thread_time(), time.process_time()
                same = np.array_equal(run(n), first, equal_nan=True)
                best = min(best, time.perf_counter() - begin)
                main = min(main, (time.thread_time() - own) / (time.process_time() - every))
            alone = best if n == 1 else alone
            ratio = alone / best
            share = f", serial share {100 * (n / ratio - 1) / (n - 1):5.1f} %" if n > 1 else ""
            if n > 1:
                share += f", main thread {100 * main:5.1f} %, the machine {machine(run, n, alone):5.2f} times"
            print(
                f"{name:28s} {orbits} orbits, {n:2d} threads: {best:7.3f} s, {ratio:5.2f} times{share}"
                + ("" if same else ", OTHER BITS"),
                flush=True,
            )


if __name__ == "__main__":
    main()
