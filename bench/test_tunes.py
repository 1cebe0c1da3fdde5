"""Speed and error of `tunes` and `TuneAccumulator`: turns of the 4-D Henon map in memory, pushed by 256; lines and
tunes beside nafflib (make peers), on the same arrays: milliseconds an orbit.

Run: pytest bench/test_tunes.py -s
"""

import numpy as np
import pytest
from common import alternating

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


def pushed(chunk: int) -> fa.frequencies.Tunes:
    running = fa.TuneAccumulator()
    for begin in range(0, TURNS + 1, chunk):
        running.push(PATH[:, :, begin : min(begin + chunk, TURNS + 1)])
    return running.tunes()


@pytest.mark.parametrize("how", ["stored", "pushed"])
def test_tunes(numbers, timed, how):
    """Orbit-turns per second and the error against the record twice as long."""
    call = (lambda: fa.tunes(PATH[:, :, :TURNS])) if how == "stored" else (lambda: pushed(CHUNK))
    found, truth = call(), fa.tunes(PATH)
    regular = found.regular & truth.regular
    error = np.abs(found.nu - truth.nu)[:, regular]
    numbers.update(
        rate=ORBITS * TURNS / timed(call, repeats=3),
        median_error=np.median(error),
        error_of_99=np.quantile(error, 0.99),
        outside=(error > found.error[:, regular] + truth.error[:, regular]).mean(),
        regular=regular.mean(),
    )


FEW = 150
"""Orbits that nafflib takes, one a call; times are per orbit, errors of these orbits for both."""


@pytest.mark.parametrize("turns", [1024, TURNS])
def test_tunes_beside_nafflib(numbers, turns):
    """Processor time of both planes' tunes of an orbit, and errors against a record of eight or two times the turns."""
    nafflib = pytest.importorskip("nafflib")
    truth, samples = fa.tunes(PATH), PATH[:, :, :turns]

    def theirs(order):
        return np.array([[nafflib.tune(z[k], z[k + 2], window_order=order) for k in (0, 1)] for z in few]).T % 1.0

    few = samples[:, :FEW].transpose(1, 0, 2)
    runs = {"fastaff": lambda: fa.tunes(samples)}
    runs |= {f"nafflib, window order {p}": lambda p=p: theirs(p) for p in (1, 2, 4)}
    found, cost = alternating(runs, repeats=3)
    for how, result in found.items():
        nu, orbits = (result.nu[:, :FEW], ORBITS) if how == "fastaff" else (result, FEW)
        regular = truth.regular[:FEW] & (truth.error[:, :FEW] < 1e-12).all(axis=0)
        off = np.abs((nu - truth.nu[:, :FEW] + 0.5) % 1.0 - 0.5)[:, regular]
        numbers.update({how: 1e3 * cost[how] / orbits, f"{how}, error": np.quantile(off, 0.99)})


@pytest.mark.parametrize("lines", [6])
def test_lines_beside_nafflib(numbers, lines):
    """Several lines of a plane: lines that both programs know from a record of twice the turns count."""
    nafflib = pytest.importorskip("nafflib")
    signals = PATH[0] - 1j * PATH[2]
    own = lambda z, order: fa.naff(z, 1.0, lines=lines, window_order=order)  # noqa: E731
    runs = {f"fastaff, window order {p}": lambda p=p: own(signals[:, :TURNS], p).nu for p in (1, 2, 3)}
    for p in (1, 2, 4):
        runs[f"nafflib, window order {p}"] = lambda p=p: np.array(
            [nafflib.naff(z, num_harmonics=lines, window_order=p)[1] for z in signals[:FEW, :TURNS]]
        )
    found, cost = alternating(runs, repeats=3)
    truth = own(signals[:FEW], 3).nu
    for how, nu in found.items():
        gaps = np.abs((nu[:FEW, :, None] - truth[:, None, :] + 0.5) % 1.0 - 0.5).min(axis=1)
        numbers.update({how: 1e3 * cost[how] / len(nu), f"{how}, error": np.quantile(gaps, 0.9)})
