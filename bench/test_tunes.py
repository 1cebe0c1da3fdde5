"""Speed and error of `tunes` and `TuneAccumulator`: turns of the 4-D Henon map in memory, pushed by 256.

Run: python -m pytest bench/test_tunes.py --benchmark-columns=median,ops -s
"""

import numpy as np
import pytest
from common import best

import fastaff as fa

ORBITS, TURNS, CHUNK = 1000, 4096, 256


def henon(orbits: int, turns: int) -> np.ndarray:
    """Return (4, orbits, turns) of the 4-D Henon map of small amplitudes (seed 1)."""
    x, y = np.random.default_rng(1).uniform(0.01, 0.12, (2, orbits))
    px, py = np.zeros((2, orbits))
    (cx, sx), (cy, sy) = ((np.cos(2 * np.pi * nu), np.sin(2 * np.pi * nu)) for nu in (0.2831, 0.3123))
    path = np.empty((4, orbits, turns))
    for turn in range(turns):
        path[:, :, turn] = x, y, px, py
        kx, ky = px + x * x - y * y, py - 2 * x * y
        x, px = cx * x + sx * kx, -sx * x + cx * kx
        y, py = cy * y + sy * ky, -sy * y + cy * ky
    return path


PATH = henon(ORBITS, 2 * TURNS)
"""The second half is the truth: a record twice as long."""


def pushed(chunk: int) -> fa.analysis.Tunes:
    running = fa.TuneAccumulator()
    for begin in range(0, TURNS + 1, chunk):
        running.push(PATH[:, :, begin : min(begin + chunk, TURNS + 1)])
    return running.tunes()


@pytest.mark.parametrize("how", ["stored", "pushed"])
def test_tunes(benchmark, how):
    """Orbit-turns per second and the error against the record twice as long."""
    call = (lambda: fa.tunes(PATH[:, :, :TURNS])) if how == "stored" else (lambda: pushed(CHUNK))
    found, truth = call(), fa.tunes(PATH)
    seconds = best(call, repeats=3)
    benchmark.pedantic(call, rounds=1)
    regular = found.regular & truth.regular
    error = np.abs(found.nu - truth.nu)[:, regular]
    rate = ORBITS * TURNS / seconds
    outside = float((error > found.error[:, regular] + truth.error[:, regular]).mean())
    benchmark.extra_info.update(orbit_turns_per_second=rate, GB_per_second=32e-9 * rate, median_error=np.median(error))
    print(
        f"\n{how}: {rate / 1e6:.0f} million orbit-turns/s ({32e-9 * rate:.2f} GB/s), error {np.median(error):.1e}, "
        f"{np.quantile(error, 0.99):.1e} at 99 %, outside {100 * outside:.2f} %, {regular.mean():.2f} regular"
    )
