"""Texts of block functions: loops over lanes around the scalar methods of `value`, a model or section (layer L0).

State blocks are flat: row r of lane i is z[r*LANES + i].
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ._jit import LANES


def _row(array: str, rows: Iterable[int]) -> str:
    return ", ".join(f"{array}[{r * LANES} + i]" for r in rows)


def _assign(array: str, rows: range, values: list[str]) -> str:
    return "".join(f"{array}[{r * LANES} + i] = {v}\n" for r, v in zip(rows, values, strict=True))


def _names(prefix: str, count: int) -> list[str]:
    return [f"{prefix}{r}" for r in range(count)]


class Rows:
    """Rows of a state block: positions, then momenta, of the orbit (n each) and of its tangent vectors (n each, one after another)."""

    def __init__(self, n: int, vectors: int):
        self.n, self.vectors, self.half = n, vectors, n * (1 + vectors)

    def parts(self, names: list[str]) -> list[list[str]]:
        """Split names of a half of the rows into those of the orbit and of each vector."""
        return [names[first : first + self.n] for first in range(0, self.half, self.n)]

    @property
    def orbit(self) -> list[int]:
        """The rows of the orbit itself."""
        return [*range(self.n), *range(self.half, self.half + self.n)]

    def velocities(self, v: list[str], p: list[str]) -> str:
        """Text that sets v to the velocities at p: T is quadratic, so a vector's velocity is that of its own momenta."""
        return "".join(f"{', '.join(out)}, = value.velocity({', '.join(given)})\n" for out, given in zip(self.parts(v), self.parts(p)))

    def forces(self, f: list[str], q: list[str]) -> str:
        """Text that sets f to the force at q and its change along each vector."""
        (f0, *tangent), (q0, *along) = self.parts(f), self.parts(q)
        text = f"{', '.join(f0)}, = value.force({', '.join(q0)})\n"
        for out, given in zip(tangent, along):
            text += f"{', '.join(out)}, = value.tangent_force({', '.join(q0 + given)})\n"
        return text


def _indent(text: str, depth: int) -> str:
    return "".join(f"{' ' * 4 * depth}{line}\n" for line in text.splitlines())


def _stage(rows: Rows) -> str:
    """Drift and kick of the state in place."""
    n = rows.half
    q, p = _names("q", n), _names("p", n)
    drift = [f"{_row('z', range(r, r + 1))} + hd*v{r}" for r in range(n)]
    return _drift_kick(rows, [_row("z", range(n + r, n + r + 1)) for r in range(n)], drift, "", q, p, 0)


def _precise_stage(rows: Rows) -> str:
    """Drift and kick of the increments since the start of the step (rows 2n...4n): they round at their own small size."""
    n = rows.half
    momenta = [f"{_row('z', range(n + r, n + r + 1))} + {_row('z', range(3 * n + r, 3 * n + r + 1))}" for r in range(n)]
    drift = [f"{_row('z', range(2 * n + r, 2 * n + r + 1))} + hd*v{r}" for r in range(n)]
    states = "".join(f"q{r} = {_row('z', range(r, r + 1))} + d{r}\n" for r in range(n))
    increments = [_row("z", range(3 * n + r, 3 * n + r + 1)) for r in range(n)]
    return _drift_kick(rows, momenta, drift, states, _names("d", n), increments, 2 * n)


def _drift_kick(rows: Rows, momenta: list[str], drift: list[str], states: str, drifted: list[str], kicked: list[str], first: int) -> str:
    """Text of a drift of rows first...first+n and a kick of the n rows after them."""
    n = rows.half
    p, v, f, q = _names("p", n), _names("v", n), _names("f", n), _names("q", n)
    move = (
        "".join(f"{p[r]} = {momenta[r]}\n" for r in range(n))
        + rows.velocities(v, p)
        + "hd = drift*step[i]\n"
        + "".join(f"{drifted[r]} = {drift[r]}\n" for r in range(n))
        + _assign("z", range(first, first + n), drifted)
    )
    kick = (
        states + rows.forces(f, q) + "hk = kick*step[i]\n"
        + _assign("z", range(first + n, first + 2 * n), [f"{kicked[r]} + hk*{f[r]}" for r in range(n)])
    )  # fmt: skip
    return (
        "    if kick == 0.0:\n        for i in range(lanes):\n" + _indent(move, 3) + "        return\n"
        "    for i in range(lanes):\n" + _indent(move + kick, 2)
    )


def _march(rows: Rows) -> str:
    """Whole steps of lane 0 with its state in scalars, and the arithmetic of `stage` to the bit: for a single orbit."""
    n = rows.half
    q, p, v, f = (_names(letter, n) for letter in "qpvf")
    drift = rows.velocities(v, p) + "hd = drift[s]*step\n" + "".join(f"{q[r]} = {q[r]} + hd*{v[r]}\n" for r in range(n))
    kick = rows.forces(f, q) + "hk = kick[s]*step\n" + "".join(f"{p[r]} = {p[r]} + hk*{f[r]}\n" for r in range(n))
    return (
        f"    {', '.join(q + p)}, = {', '.join(f'z[{r * LANES}]' for r in range(2 * n))},\n"
        "    for _ in range(steps):\n        for s in range(drift.size):\n"
        + _indent(drift, 3)
        + "            if s < kick.size:\n"
        + _indent(kick, 4)
        + "".join(f"    z[{r * LANES}] = {name}\n" for r, name in enumerate(q + p))
    )


def _derivative(rows: Rows) -> str:
    n = rows.half
    q, p, v, f = (_names(letter, n) for letter in "qpvf")
    load = f"{', '.join(q + p)}, = {_row('z', range(2 * n))},\n"
    return "    for i in range(lanes):\n" + _indent(
        load + rows.velocities(v, p) + rows.forces(f, q) + _assign("result", range(2 * n), v + f), 2
    )


def _check(rows: Rows) -> str:
    z, n = _names("z", 2 * rows.half), rows.n
    # 0*z is 0 for finite z and NaN else; comparisons with NaN are false.
    return (
        "    for i in range(lanes):\n"
        f"        {', '.join(z)}, = {_row('z', range(2 * rows.half))},\n"
        f"        finite = {' + '.join(f'0.0*{name}' for name in z)}\n"
        f"        size = {' + '.join(f'{name}*{name}' for name in z[:n])}\n"
        f"        margin = value.margin({', '.join(z[:n])})\n"
        "        code = 0.0 if margin > 0.0 else 2.0\n"
        "        code = code if size < radius*radius else 3.0\n"
        "        result[i] = code if finite == 0.0 else 1.0\n"
    )


def _value(rows: Rows) -> str:
    return f"    for i in range(lanes):\n        result[i] = value.value({_row('z', rows.orbit)})\n"


TEXTS: dict[str, Callable[[Rows], str]] = {
    "stage": _stage,
    "precise_stage": _precise_stage,
    "march": _march,
    "derivative": _derivative,
    "check": _check,
    "value": _value,
}
ARGUMENTS = {
    "stage": "params, lanes, drift, kick, step, z",
    "precise_stage": "params, lanes, drift, kick, step, z",
    "march": "params, drift, kick, step, steps, z",
    "check": "params, lanes, radius, z, result",
    "derivative": "params, lanes, z, result",
    "value": "params, lanes, z, result",
    "observe": "params, lanes, orbit, fresh, t, z, memory, out, done",
}
