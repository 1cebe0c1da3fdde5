"""Texts of block functions: loops over lanes around the scalar methods of `value`, a model or section.

State blocks are flat: row r of lane i is z[r*LANES + i].
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from .jit import LANES
from .state_rows import CARRIED, StateRows, listed
from .terms import Substep
from .terms import indented as _indent
from .terms import loop as _loop

HIGH = 16.0
"""Ratio of the change of H to the kinetic energy, or of rates to those of both ends, that shows a pole; the distance of
a chord from its orbit makes less.
"""

DRIFT = "hd = drift*step[i]\n"
"""Text of the length of a lane's drift."""

KICK = "hk = kick*step[i]\n"
"""Text of the length of a lane's kick."""


def _at(row: int) -> str:
    return f"z[{row * LANES} + i]"


def _splitting(rows: StateRows) -> str:
    """Steps of drifts and kicks of the state in place."""
    passed = "" if rows.time is None else _loop(f"{_at(rows.time)} += step[i]\n", 0)
    return _steps(rows, 0, passed, 2 * rows.half)


def _precise_splitting(rows: StateRows) -> str:
    """Steps of drifts and kicks of the increments since the start of the step (rows 2n...4n), which round at their own
    small size; then these are added to the state.
    """
    size = 2 * rows.half
    passed = "" if rows.time is None else _loop(f"{_at(size + rows.time)} = step[i]\n", 0)
    return _steps(rows, size, passed + _settling(rows), 3 * size)


def _steps(rows: StateRows, first: int, after: str, size: int) -> str:
    """Text of steps of `size` rows: drifts and kicks of those from `first` on and the text `after` them; ends early,
    after the step with which a lane leaves the domain; returns the number of steps.

    One call makes all stages between two observations: an array is passed as words on the stack, and a call that reads
    these waits until the stores of the stage before have left the store queue, a sixth of the time of a stage. Lanes in
    a rotating frame with one step share the numbers of their rotations, a fifth of the time with a cheap force; they
    have separate steps, as both kinds of loops in one would take that time again.
    """
    made = _numbers(rows, size, "lanes", ("drifts", "kicks"), "step[i]")
    phase = "" if rows.time is None else _loop(f"{_at(rows.time)} = value.phase({_at(rows.time)})\n", 0)
    own, alike = (
        while_inside(rows, _drifts_kicks(rows, first, alike=alike) + after + phase) for alike in (False, True)
    )
    if not rows.shares:
        return f"{made}{_indent(own, 1)}    return taken\n"
    uneven = "    uneven = 0\n" + _loop("uneven += 0 if step[i] == step[0] else 1\n", 1)
    return f"{made}{uneven}    if uneven > 0:\n{_indent(own, 2)}    else:\n{_indent(alike, 2)}    return taken\n"


def while_inside(rows: StateRows, step: str, kept: str = "") -> str:
    """Text of `steps` steps, or up to the one with which a lane leaves the domain; kept: text after each."""
    margin = f"outside += 0 if value.margin({', '.join(_at(r) for r in range(rows.n))}) > 0.0 else 1\n"
    return (
        "taken = 0\nwhile taken < steps:\n"
        + _indent(step, 1)
        + f"    taken += 1\n{_indent(kept, 1)}    if taken == steps:\n        break\n    outside = 0\n"
        + _loop(margin, 1)
        + "    if outside > 0:\n        break\n"
    )


def traced(state: Iterable[str]) -> str:
    """Text that puts lane 0 into the trace of a march, where there is one, and goes on with the next step."""
    return _traced("".join(f"kept[{r * LANES}] = {entry}\n" for r, entry in enumerate(state)))


def _traced(kept: str) -> str:
    return f"if trace.size > 0:\n    kept = trace[taken - 1:]\n{_indent(kept, 1)}    continue\n"


def _settling(rows: StateRows) -> str:
    """Text that adds the increments of a step to the state with the carried errors, rows 4n...6n. The rows of vectors
    are in a loop: written out they would take as long to compile as all the rest.
    """
    size = 2 * rows.half
    text = f"{CARRIED}change[i] = 0.0\n"
    if rows.vectors:
        names = ", ".join(f"z[{k * size * LANES} + {LANES}*r:]" for k in range(3))
        return f"for r in range({size}):\n    mine, change, error = {names}\n{_loop(text, 1)}"
    places = [[_at(k * size + r) for k in range(3)] for r in range(size)]
    return _loop(
        "".join(text.replace("mine[i]", a).replace("change[i]", b).replace("error[i]", c) for a, b, c in places), 0
    )


def _drifts_kicks(rows: StateRows, first: int, *, alike: bool) -> str:
    """Text of a step that changes the rows from `first` on, the state itself (0) or its increments; alike: for lanes of
    one step.
    """
    n = rows.half
    drifts = rows.solves("drift")
    kicks = rows.solves("kick")
    loaded = "" if kicks is None else kicks.loaded
    loop = _loop if not alike else functools.partial(_shared, () if drifts is None else (drifts.loaded,))

    def now(row: int) -> str:
        if row == rows.time:  # its row has the start of the step
            return f"{_at(row)} + passed*step[i]" if first else f"fma(passed, step[i], {_at(row)})"
        return f"{_at(row)} + {_at(first + row)}" if first else _at(row)

    drift = kick = ""
    repeated = rows.repeated
    for group in rows.groups:
        if group in repeated[1:]:
            continue
        move = DRIFT
        both = move + KICK + loaded
        both += "" if group.start == 0 else "".join(f"q{r} = {now(r)}\n" for r in range(rows.n))
        for part in rows.parts(group):  # one after another: their numbers are not all live at once
            text = "".join(f"p{r} = {now(n + r)}\n" for r in part) + rows.velocities(part)
            text += "".join(
                f"d{r} = fma(hd, v{r}, {_at(first + r)})\n"
                if r != rows.time
                else f"d{r} = passed*step[i]\n"
                if first
                else f"d{r} = fma(passed, step[i], {_at(r)})\n"
                for r in part
            )
            text += "" if drifts is None else drifts.moved(part, n, first)
            text += "".join(f"{_at(first + r)} = d{r}\n" for r in part if r != rows.time)
            push = "".join(f"q{r} = {f'{_at(r)} + ' if first else ''}d{r}\n" for r in part) + rows.forces(part)
            push += "".join(f"{_at(first + n + r)} = {_pushed(kicks, r, part, _at(first + n + r))}\n" for r in part)
            pushed = text + push
            if group in repeated:
                text, pushed = (entry.replace("z[", "own[") for entry in (text, pushed))
            move = move + text
            both = both + pushed
        if group in repeated:
            size = len(group)
            drift += (
                f"    for part in range(0, {len(repeated) * size}, {size}):\n        own = distant(z, {LANES}*part)\n"
            )
            kick += (
                f"    for part in range(0, {len(repeated) * size}, {size}):\n        own = distant(z, {LANES}*part)\n"
            )
            drift += loop(move, 2)
            kick += loop(both, 2)
            continue
        drift += loop(move, 1)
        kick += loop(both, 1)
    start, end = (
        "" if drifts is None else _indent(drifts.before(rows.parts(rows.all), n, first, entry), 1)
        for entry in ("s", "kicks.size")
    )
    begin, more = ("", "") if rows.time is None else ("passed = 0.0\n", "    passed += drift\n")
    if kicks is not None:
        more += _indent(kicks.select_coefficients(3 * first if first else 2 * n, "s", "kicks.size - 1"), 1)
    return (
        f"{begin}for s in range(kicks.size):\n    drift, kick = drifts[s], kicks[s]\n{more}{start}{kick}"
        f"drift = drifts[kicks.size]\nif drift != 0.0:\n{end}{drift}"
    )


def _shared(loaded: tuple[str, ...], body: str, depth: int) -> str:
    """Text of a loop over lanes of one step: all use the numbers of drift, kick and substep of the first."""
    lines = body.splitlines(keepends=True)
    shared = dict.fromkeys(line for line in lines if line in (DRIFT, KICK, *loaded))
    own = "".join(line for line in lines if line not in shared)
    return _indent("".join(shared).replace("[i]", "[0]"), depth) + _loop(own, depth)


def _numbers(rows: StateRows, first: int, lanes: str, stages: tuple[str, str], step: str) -> str:
    """Text that makes the numbers of the substep, if there is one; stages: names of drifts and kicks."""
    if rows.own is None or rows.substep is None:
        return ""
    return rows.substep.made(first, rows.own.rate, lanes, stages[rows.substep.stage == "kick"], step)


def _pushed(kicks: Substep | None, r: int, part: range, p: str) -> str:
    """Text of row r of the momenta after a kick."""
    return f"fma(hk, f{r}, {p})" if kicks is None else kicks.text(r, part, p)


def _march(rows: StateRows) -> str:
    """Whole steps of lane 0 with its state in scalars, and the bits of `splitting`: for a single orbit.

    Ends early, after the step that leaves the domain; returns the number of steps.
    """
    if rows.in_memory:
        return _march_with_vectors(rows)
    n = rows.half
    state = [f"q{r}" for r in rows.all] + [f"p{r}" for r in rows.all]
    time = rows.time
    drift = rows.velocities(rows.all) + "hd = drift[s]*step\n"
    drift += "".join(f"q{r} = fma(hd, v{r}, q{r})\n" for r in rows.all if r != time)
    drift += "" if time is None else f"passed += drift[s]\nq{time} = fma(passed, step, begun)\n"
    started = "" if time is None else f"        begun, passed = q{time}, 0.0\n"
    end = "" if time is None else f"        q{time} = value.phase(begun + step)\n"
    begin = _numbers(rows, 2 * n, "1", ("drift", "kick"), "step")
    drifts = rows.solves("drift")
    kicks = rows.solves("kick")
    if drifts is not None:
        turn = f"{drifts.select_coefficients(2 * n, 's', 'kick.size')}i = 0\n{drifts.loaded}"
        if drifts.fallback is not None:
            fallback = "".join(drifts.fallback(part, n, None) for part in rows.parts(rows.all))
            turn += f"if {drifts.names[-1]} > 0.0:\n{_indent(fallback, 1)}"
        drift = turn + drift + "".join(drifts.text(part, "q", "p", {}) for part in rows.parts(rows.all))
    kick = rows.forces(rows.all) + "hk = kick[s]*step\n"
    if kicks is not None:
        kick += f"{kicks.select_coefficients(2 * n, 's', 'kick.size - 1')}i = 0\n{kicks.loaded}"
    pushed = ((r, _pushed(kicks, r, part, f"p{r}")) for part in rows.parts(rows.all) for r in part)
    kick += "".join(f"p{r} = {after}\n" for r, after in pushed)
    return (
        begin + f"    {', '.join(state)}, = {', '.join(f'z[{r * LANES}]' for r in range(2 * n))},\n"
        f"    taken = 0\n    while taken < steps:\n{started}        for s in range(drift.size):\n"
        + _indent(drift, 3)
        + "            if s < kick.size:\n"
        + _indent(kick, 4)
        + end
        + f"        taken += 1\n{_indent(traced(state), 2)}"
        + f"        if not value.margin({listed('q', range(rows.n))}) > 0.0:\n            break\n"
        + "".join(f"    z[{r * LANES}] = {name}\n" for r, name in enumerate(state))
        + "    return taken\n"
    )


def _march_with_vectors(rows: StateRows) -> str:
    """Whole steps of lane 0 with its orbit in scalars and its vectors in their rows: one text moves all of them, at the
    end of the orbit's drift and before its kick.
    """
    n, half = rows.n, rows.half
    own, vector = range(n), range(n, 2 * n)
    moved = [r for r in own if r != rows.time]
    state = [f"q{r}" for r in own] + [f"p{r}" for r in own]
    places = [*(f"z[{r * LANES}]" for r in own), *(f"z[{(half + r) * LANES}]" for r in own)]
    mine = [*(f"mine[{k * LANES}]" for k in own), *(f"mine[{(half + k) * LANES}]" for k in own)]
    names = [f"q{r}" for r in vector] + [f"p{r}" for r in vector]
    drift = rows.velocities(own) + "hd = drift[s]*step\n" + "".join(f"q{r} = fma(hd, v{r}, q{r})\n" for r in moved)
    if rows.time is not None:
        drift += f"passed += drift[s]\nq{rows.time} = fma(passed, step, begun)\n"
    read = "".join(f"{name} = {place}\n" for name, place in zip(names, mine, strict=True))
    move = rows.velocities(vector) + "".join(f"q{r} = fma(hd, v{r}, q{r})\n" for r in vector)
    push = rows.forces(vector) + "".join(f"p{r} = fma(hk, f{r}, p{r})\n" for r in vector)
    written = "".join(f"{place} = {name}\n" for name, place in zip(names, mine, strict=True))
    vectors = f"mine = z[{LANES}*part:]\n{read}{move}if s < kick.size:\n{_indent(push, 1)}{written}"
    step = (
        f"{drift}hk = kick[s]*step if s < kick.size else 0.0\nfor part in range({n}, {half}, {n}):\n"
        f"{_indent(vectors, 1)}if s < kick.size:\n"
        + _indent(rows.forces(own) + "".join(f"p{r} = fma(hk, f{r}, p{r})\n" for r in own), 1)
    )
    kept = "".join(f"{place.replace('z[', 'kept[')} = {name}\n" for name, place in zip(state, places, strict=True))
    kept += f"for r in range({n}, {half}):\n    mine, copy = z[{LANES}*r:], kept[{LANES}*r:]\n"
    kept += f"    copy[0], copy[{half * LANES}] = mine[0], mine[{half * LANES}]\n"
    text = "".join(f"{name} = {place}\n" for name, place in zip(state, places, strict=True))
    text += "taken = 0\nwhile taken < steps:\n"
    text += "" if rows.time is None else f"    begun, passed = q{rows.time}, 0.0\n"
    text += f"    for s in range(drift.size):\n{_indent(step, 2)}"
    text += "" if rows.time is None else f"    q{rows.time} = value.phase(begun + step)\n"
    text += f"    taken += 1\n{_indent(_traced(kept), 1)}"
    text += f"    if not value.margin({listed('q', own)}) > 0.0:\n        break\n"
    text += "".join(f"{place} = {name}\n" for name, place in zip(state, places, strict=True))
    return _indent(text, 1) + "    return taken\n"


def _derivative(rows: StateRows) -> str:
    n = rows.half
    text = ""
    if rows.variables:
        return "".join(_rates(rows, group) for group in rows.groups)
    for group in rows.groups:
        q = [*group] if group.start == 0 else [*range(rows.n), *group]
        body = "".join(f"q{r} = {_at(r)}\n" for r in q) + "".join(f"p{r} = {_at(n + r)}\n" for r in group)
        body += rows.slopes(group)
        body += "".join(f"result[{r * LANES} + i] = v{r}\nresult[{(n + r) * LANES} + i] = f{r}\n" for r in group)
        text += _loop(body, 1)
    return text


def _rates(rows: StateRows, group: range) -> str:
    """Rates of a system dz/dt = f(z), and their changes along vectors; 0 in an idle row."""
    z = [f"z{j}" for j in range(rows.variables)]
    body = "".join(f"{name} = {_at(r)}\n" for name, r in zip(z, rows.state(range(rows.n)), strict=True))
    for part in rows.parts(group):
        f = [f"f{j}" for j in range(rows.variables)]
        own = rows.state(part)
        given = ", ".join(z)
        call = f"rates({given})"
        if part.start:
            body += "".join(f"w{j} = {_at(r)}\n" for j, r in enumerate(own))
            call = f"tangent_rates({given}, {listed('w', range(rows.variables))})"
        body += f"{', '.join(f)}, = value.{call}\n"
        body += "".join(f"result[{r * LANES} + i] = {name}\n" for name, r in zip(f, own, strict=True))
        if rows.variables < 2 * rows.n:
            body += f"result[{(rows.half + part.stop - 1) * LANES} + i] = 0.0\n"
    return _loop(body, 1)


def of_orbit(n: int) -> list[str]:
    """Return the texts of the numbers of an orbit, whatever number of vectors lies between its positions and its
    momenta.
    """
    return [*map(_at, range(n)), *(f"momenta[{r * LANES} + i]" for r in range(n))]


def _check(rows: StateRows) -> str:
    """The state of the orbits alone: one code serves all numbers of vectors, whose rows `check_vectors` looks at."""
    rows = replace(rows, vectors=0)
    z = [f"z{r}" for r in range(2 * rows.n)]
    kinetic = "" if rows.variables and not rows.nonseparable else _kinetic_energy(rows, "energy", z)
    kinetic += "kinetic[i] = energy if energy > kinetic[i] else kinetic[i]\n" if kinetic else ""
    # 0*z is 0 for finite z and NaN else; comparisons with NaN are false.
    return _loop(
        "".join(f"{name} = {entry}\n" for name, entry in zip(z, of_orbit(rows.n), strict=True))
        + f"finite = {' + '.join(f'0.0*{name}' for name in z)}\n"
        f"size = {' + '.join(f'{name}*{name}' for name in (z[r] for r in rows.place[: rows.time]))}\nmargin = "
        f"value.margin({', '.join(z[r] for r in rows.place)})\ncode = 0.0 if margin > 0.0 else 2.0\ncode = code if "
        "size < radius[i]*radius[i] else 3.0\n"
        "result[i] = code if finite == 0.0 else 1.0\n" + kinetic,
        1,
    )


def _inside(rows: StateRows) -> str:
    """The part of `check` that every step needs: whether the orbit is finite and in the domain."""
    rows = replace(rows, vectors=0)
    z = of_orbit(rows.n)
    return _loop(
        f"margin = value.margin({', '.join(z[r] for r in rows.place)})\nfinite = "
        f"{' + '.join(f'0.0*{row}' for row in z)}\ncode = 2.0 if finite == 0.0 else 1.0\nresult[i] = 0.0 if margin > "
        "0.0 else code\n",
        1,
    )


def _leapt(rows: StateRows) -> str:
    """Whether steps from the states `begin` to z have passed a pole: one of the model's `poles` has passed a whole
    number, and V, H or the rates next to that point of the chord are larger than the motion allows. At a pole without
    residue they are not.
    """
    old = [f"begin[{r * LANES} + i]" for r in rows.place]
    new = [_at(r) for r in rows.place]
    between = [f"{a} + x*({b} - {a})" for a, b in zip(old, new, strict=True)]
    turned = "moved = 0\nfor k in range(len(first)):\n    moved += np.floor(first[k]) != np.floor(last[k])\n"
    signs = f"first, last = value.poles({', '.join(old)}), value.poles({', '.join(new)})\n{turned}"
    text = _loop(signs + "result[i] = -1.0 if (moved > 0) & (result[i] == 0.0) else result[i]\n", 1)
    half = f"x = 0.5*(low + high)\nlast = value.poles({', '.join(between)})\n{turned}"
    half += "low, high = (x, high) if moved == 0 else (low, x)\n"
    search = f"first = value.poles({', '.join(old)})\nlow, high = 0.0, 1.0\nfor _ in range(64):\n{_indent(half, 1)}"
    search += _had(rows, old, new, between) + "result[i] = 2.0*leap\n"
    return text + _loop(f"if result[i] < 0.0:\n{_indent(search, 1)}", 1)


def _had(rows: StateRows, old: Sequence[str], new: Sequence[str], between: Sequence[str]) -> str:
    """Text that sets `leap` to 1 if V, H or the rates `between` are far beyond those at both ends of a step, else 0."""
    if rows.variables and not rows.nonseparable:
        f = ([f"{letter}{j}" for j in range(rows.variables)] for letter in "fgh")
        n = range(rows.variables)
        rates = [
            f"{', '.join(r)}, = value.rates({', '.join(z)})\n" for r, z in zip(f, (old, new, between), strict=True)
        ]
        change = "".join(f"leap = 1.0 if abs(h{j}) > {HIGH}*(abs(f{j}) + abs(g{j})) else leap\n" for j in n)
        return f"{rates[0]}{rates[1]}leap = 0.0\nfor x in (low, high):\n{_indent(rates[2] + change, 1)}"
    ends = [[f"{where}[{r * LANES} + i]" for r in range(2 * rows.half)] for where in ("begin", "z")]
    text = "".join(_kinetic_energy(rows, f"kinetic{k}", end) for k, end in enumerate(ends))
    energy = f"value.{'energy' if rows.nonseparable else 'potential_energy'}"
    text += f"energy, leap = {energy}({', '.join(old)}), 0.0\nfor x in (low, high):\n"
    text += f"    change = abs({energy}({', '.join(between)}) - energy)\n"
    return text + f"    leap = 1.0 if change > {HIGH}*(kinetic0 + kinetic1) else leap\n"


def _value(rows: StateRows) -> str:
    return _loop(f"result[i] = value.value({', '.join(map(_at, rows.orbit))})\n", 1)


def _kinetic_energy(rows: StateRows, name: str, z: Sequence[str]) -> str:
    """Text that sets a name to the kinetic energy of rows with these texts, for H(q, p) to half of |p . dH/dp|."""
    orbit = [z[r] for r in rows.orbit]
    if not rows.nonseparable:
        return f"{name} = value.kinetic_energy({', '.join(orbit[rows.n :])})\n"
    text = f"{listed('g', range(2 * rows.n))}, = value.rates({', '.join(orbit)})\n"
    work = " + ".join(f"{orbit[rows.n + r]}*g{r}" for r in range(rows.n - rows.driven))
    return f"{text}{name} = 0.5*np.abs({work})\n"


def _kinetic(rows: StateRows) -> str:
    return _loop(_kinetic_energy(rows, "result[i]", [_at(r) for r in range(2 * rows.half)]), 1)


def _potential(rows: StateRows) -> str:
    return _loop(f"result[i] = value.potential_energy({', '.join(map(_at, range(rows.n)))})\n", 1)


def _along(rows: StateRows) -> str:
    """The direction of the flow: velocities and forces of the orbit alone."""
    n = rows.n
    orbit = rows.orbit
    if rows.variables:
        alone = StateRows(n, 0, rows.terms, rows.variables)
        load = _rates(alone, range(n))
        for j in range(rows.variables):  # read at the orbit's rows among those of its vectors
            load = load.replace(f"z{j} = {_at(alone.state(range(n))[j])}\n", f"z{j} = {_at(rows.state(range(n))[j])}\n")
        return load
    body = "".join(f"q{r} = {_at(orbit[r])}\np{r} = {_at(orbit[n + r])}\n" for r in range(n))
    body += rows.slopes(range(n))
    return _loop(
        body + "".join(f"result[{r * LANES} + i] = v{r}\nresult[{(n + r) * LANES} + i] = f{r}\n" for r in range(n)), 1
    )


def signals(rows: int, kept: Sequence[int]) -> str:
    """Text of the kept signals of angles at states of this number of rows."""
    z = ", ".join(map(_at, range(rows)))
    body = f"s = value.signals({z})\n" + "".join(f"result[{j * LANES} + i] = s[{k}]\n" for j, k in enumerate(kept))
    return _loop(body, 1)


def taken(order: Iterable[int]) -> str:
    """Text of the rows of a state in an order."""
    return _loop("".join(f"result[{j * LANES} + i] = {_at(r)}\n" for j, r in enumerate(order)), 1)


def observed(sizes: tuple[int, ...], calls: bool) -> str:
    """Text of an observer: the call of its function `keep` with the constants `sizes` and with its calls if it has
    any.
    """
    given = "".join(f"{entry}, " for entry in ["value", *(["Calls(calls, params)"] if calls else []), *sizes])
    return f"    return keep({given}lanes, orbit, fresh, t, z, memory, out, done)\n"


def read(parameters: int) -> str:
    """Text of the reading of an indicator: its function `read` over the lanes that are due; NaN where it returns
    None.
    """
    given = "".join(f", params[{j}]" for j in range(parameters))
    body = (
        f"if due[i] > 0.0:\n    said = read(growth, i{given})\n    result[i] = float('nan') if said is None else said\n"
    )
    return "    growth = view(n, k, m, memory)\n" + _loop(body, 1)


ONE_VARIABLE = _loop("result[i] = value.value(z[i])\n", 1)
"""Text of a function of one variable."""

TEXTS: dict[str, Callable[[StateRows], str]] = {
    "splitting": _splitting,
    "precise_splitting": _precise_splitting,
    "march": _march,
    "derivative": _derivative,
    "check": _check,
    "inside": _inside,
    "leapt": _leapt,
    "value": _value,
    "kinetic": _kinetic,
    "potential": _potential,
    "along": _along,
}
ARGUMENTS = {
    "splitting": "params, lanes, drifts, kicks, step, steps, z",
    "precise_splitting": "params, lanes, drifts, kicks, step, steps, z",
    "moments": "params, lanes, drifts, kicks, step, steps, z",
    "angles": "params, lanes, drifts, kicks, step, steps, z",
    "march": "params, drift, kick, step, steps, z, trace",
    "nystrom_splitting": "params, lanes, drifts, kicks, step, steps, z",
    "nystrom_march": "params, drifts, kicks, step, steps, z, trace",
    "step": "derivative, params, lanes, rows, a, b, dense, sweeps, step, z, k, work",
    "check": "params, lanes, radius, z, momenta, result, kinetic",
    "inside": "params, lanes, z, momenta, result",
    "leapt": "params, lanes, begin, z, result",
    "derivative": "params, lanes, z, result",
    "value": "params, lanes, z, result",
    "kinetic": "params, lanes, z, result",
    "potential": "params, lanes, z, result",
    "along": "params, lanes, z, result",
    "reading": "params, lanes, n, k, m, due, memory, result",
    "observe": "params, calls, lanes, orbit, fresh, t, z, memory, out, done",
}
