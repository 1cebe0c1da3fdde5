"""Two commits in turns: make bench-compare BASE=<commit> runs named calls on both and says whether bits agree.

The base is checked out into a temporary worktree. Each side is one process that stays alive, with the same interpreter
and another PYTHONPATH, and makes a call when it is asked to; the sides take turns, the one that begins alternates.
Ratios are of processor time; their spread is that of the ratios of neighbours in time.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]


def calls() -> dict:
    """Return the compared calls by name: functions of no arguments."""
    import fastaff as fa
    from fastaff import schemes
    from fastaff.frequencies.naff import naff

    body, neo, plane = fa.Body(fa.Hyperelastic(1.0), 1.0), fa.Body(fa.NeoHookean()), fa.HenonHeiles()
    turning, axis = fa.AlphaTurning(+1), fa.Hyperplane((1, 0, 0, 0))
    rng = np.random.default_rng(1)
    z = np.zeros((8, 4096))
    z[0], z[2] = 1.5, 0.3
    z += 0.1 * rng.standard_normal(z.shape)
    flat = np.array([[0.0], [0.1], [0.4], [0.14]]) + 0.01 * rng.standard_normal((4, 1024))
    one, lone = z[:, 0], np.array([0.0, 0.1, 0.4, 0.14])
    signals = np.exp(2j * np.pi * np.outer(rng.random(200), np.arange(8192)))
    signals += 0.1 * np.exp(2j * np.pi * np.outer(rng.random(200), np.arange(8192)))
    cut = {"crossings": 100, "max_time": 400.0}
    found = {
        "integrate, grid, accuracy": lambda: fa.integrate(body, z[:, :1024], time=50.0),
        "frequency_map, body": lambda: fa.frequency_map(body, z[:, :128], time=200.0),
        "frequency_map, Henon-Heiles": lambda: fa.frequency_map(plane, flat[:, :256], time=500.0),
        "chaos_map, Henon-Heiles": lambda: fa.chaos_map(plane, flat, time=500.0),
        "chaos_map, neo-Hookean": lambda: fa.chaos_map(neo, z[:, :256], time=200.0),
        "action_angles": lambda: fa.action_angles(body, z),
        "naff, 200 signals": lambda: naff(signals, 1.0, lines=2),
        "naff, one signal": lambda: naff(signals[0], 1.0, lines=2),
        "poincare_map, grid of the body": lambda: fa.poincare_map(
            neo, z[:, :1024], section=turning, step=0.1, scheme=fa.BLANES_MOAN6, **cut
        ),
        "poincare_map, grid of Henon-Heiles": lambda: fa.poincare_map(plane, flat, section=axis, step=0.1, **cut),
        "poincare_map, grid, accuracy": lambda: fa.poincare_map(plane, flat, section=axis, **cut),
        "poincare_map, 306 crossings of one orbit": lambda: fa.poincare_map(
            plane, lone, section=axis, crossings=306, max_time=2000.0, step=0.2, scheme=fa.SOFRONIOU_SPALETTA10
        ),
        "one orbit: integrate, one step": lambda: fa.integrate(body, one, time=0.05, step=0.05),
        "one orbit: integrate, accuracy": lambda: fa.integrate(body, one, time=50.0),
        "one orbit: poincare_map": lambda: fa.poincare_map(neo, one, section=turning, crossings=20, max_time=200.0),
        "one orbit: frequency_map": lambda: fa.frequency_map(plane, lone, time=500.0),
        "one orbit: chaos_map": lambda: fa.chaos_map(plane, lone, time=500.0),
        "one orbit: action_angles": lambda: fa.action_angles(body, one),
    }
    for name, step in (("BLANES_MOAN6", 0.1), ("BLANES_CASAS_ESCORIHUELA8", 0.1), ("SOFRONIOU_SPALETTA10", 0.1)):
        scheme = getattr(schemes, name, None)  # the base may not have it yet
        if scheme is not None:
            for title, model, z0 in (("body", body, z), ("neo-Hookean", neo, z), ("Henon-Heiles", plane, flat)):
                found[f"integrate, grid, {title}, {name}"] = lambda scheme=scheme, step=step, model=model, z0=z0: (
                    fa.integrate(model, z0, time=50.0, step=step, scheme=scheme)
                )
    small = 0.2 * rng.standard_normal((4, 1024))
    for title, text in FUNCTIONS.items():
        if "y" in text:
            model, z0, crossed = fa.hamiltonian(text), small, fa.Hyperplane((0, 0, 1, 0))
        else:
            model, z0, crossed = fa.hamiltonian(text, coordinates="x"), small[::2], fa.Hyperplane((0, 1))
        for name, run in {
            "integrate, step": lambda model=model, z0=z0: fa.integrate(model, z0, time=20.0, step=0.05),
            "integrate, accuracy": lambda model=model, z0=z0: fa.integrate(model, z0, time=20.0),
            "one orbit": lambda model=model, z0=z0: fa.integrate(model, z0[:, 0], time=100.0, step=0.05),
            "poincare_map": lambda model=model, z0=z0, crossed=crossed: fa.poincare_map(
                model, z0[:, :512], section=crossed, crossings=50, max_time=100.0, step=0.1
            ),
            "frequency_map": lambda model=model, z0=z0: fa.frequency_map(model, z0[:, :128], time=100.0, step=0.05),
            "chaos_map": lambda model=model, z0=z0: fa.chaos_map(model, z0[:, :512], time=100.0, step=0.05),
        }.items():
            found[f"functions, {title}: {name}"] = run
    return found


FUNCTIONS = {
    "pendulum": "-cos(x)",
    "cosine lattice": "-cos(x) - cos(y) - 0.3*cos(x)*cos(y)",
    "Toda": "(exp(2*y + 2*sqrt(3)*x) + exp(2*y - 2*sqrt(3)*x) + exp(-4*y))/24",
    "Morse": "(1 - exp(-x))**2 + (1 - exp(-y))**2 + 0.1*x*y",
    "logarithmic": "log(x**2 + y**2/0.81 + 0.01)/2",
    "tanh": "x**2/2 + y**2/2 + 0.3*tanh(x*y)",
    "power": "(x**2 + y**2/0.81 + 0.01)**0.65",
}
"""Potentials of elementary functions."""


def digest(result) -> str:
    """Return a hash of all arrays of a result, in the order of their names."""
    hashed = hashlib.sha256()
    for name, value in sorted(vars(result).items()):
        if isinstance(value, np.ndarray) and value.dtype.kind in "biufc":
            hashed.update(f"{name} {value.dtype} {value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    return hashed.hexdigest()


def serve() -> None:
    """Make the calls whose names come in, one a line; answer with times and hash. A call of less than 50 ms is made
    again until that much is measured.
    """
    found = calls()
    print(json.dumps([*found]), flush=True)
    for line in sys.stdin:
        run, count = found[json.loads(line)], 0
        try:
            wall, cpu = time.perf_counter(), time.process_time()
            while count == 0 or time.perf_counter() - wall < 0.05:
                result, count = run(), count + 1
            cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
            answer = {"cpu": cpu / count, "wall": wall / count, "hash": digest(result)}
        except Exception as error:  # a call the base does not know is no reason to stop
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), flush=True)


class Side:
    """One commit's process."""

    def __init__(self, name: str, folder: Path):
        self.name = name
        self.process = subprocess.Popen(
            [sys.executable, __file__, "--serve"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(folder)},
        )
        self.calls = json.loads(self.process.stdout.readline())

    def ask(self, call: str) -> dict:
        """Make the call once."""
        self.process.stdin.write(json.dumps(call) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def end(self) -> None:
        """Let the process end."""
        self.process.stdin.close()
        self.process.wait()


def compare(sides: list[Side], call: str, turns: int) -> str:
    """Return a line on one call: times, the ratio with its spread, and whether the bits are the same."""
    first = [side.ask(call) for side in sides]  # compiles
    for side, answer in zip(sides, first):
        if "error" in answer:
            return f"{call:52s} {side.name}: {answer['error']}"
    runs: list = [[], []]
    for turn in range(turns):
        for k in (0, 1) if turn % 2 == 0 else (1, 0):
            runs[k].append(sides[k].ask(call)["cpu"])
    base, this = map(np.array, runs)
    low, high = np.quantile(this / base, (0.25, 0.75))
    same = "identical" if first[0]["hash"] == first[1]["hash"] else "DIFFERENT BITS"
    times = f"{1e3 * base.min():10.3f} {1e3 * this.min():10.3f}"
    return f"{call:52s} {times}   {this.min() / base.min():5.2f}   {low:.2f}-{high:.2f}   {same}"


def main() -> None:
    """Compare this tree, as it is, with a commit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("base", nargs="?", default="HEAD", help="the commit to compare with (default HEAD)")
    parser.add_argument("--turns", type=int, default=9)
    parser.add_argument("--only", default="", help="only calls whose name has this in it")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        return serve()
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "base"
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(tree), options.base], check=True)
        sides: list[Side] = []
        try:
            sides += [Side("base", tree), Side("this", ROOT)]
            print(
                f"{'ms of processor time, the shortest of ' + str(options.turns):52s} {'base':>10s} {'this':>10s}",
                end="",
            )
            print("   ratio   quartiles   bits")
            for call in (call for call in sides[1].calls if call in sides[0].calls and options.only in call):
                print(compare(sides, call, options.turns), flush=True)
        finally:
            for side in sides:
                side.end()
            subprocess.run([*git, "remove", "--force", str(tree)], check=True)


if __name__ == "__main__":
    main()
