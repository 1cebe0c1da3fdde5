"""One step of a scheme for a block of lanes. State blocks are flat: row r of lane i is z[r*LANES + i]."""

from __future__ import annotations

from ..compile.jit import LANES, jit


@jit
def splitting_step(stage, params, drift, kick, lanes, step, z):
    """Advance z (rows*LANES) by step[i] in lane i with a splitting: drifts (stages+1,), kicks (stages,)."""
    for s in range(kick.size):
        stage(params, lanes, drift[s], kick[s], step, z)
    if drift[kick.size] != 0.0:
        stage(params, lanes, drift[kick.size], 0.0, step, z)


@jit
def settle(rows, lanes, z):
    """Add the increments of a step to the state with the rounding error carried over to the next (Kahan's summation).

    z holds rows of the state, of increments (left at zero) and of carried errors.
    """
    size = rows * LANES
    for r in range(rows):
        for i in range(lanes):
            j = r * LANES + i
            increment = z[size + j] + z[2 * size + j]
            total = z[j] + increment
            z[2 * size + j] = increment - (total - z[j])
            z[j] = total
            z[size + j] = 0.0


@jit
def combine(rows, lanes, first, last, coefficients, k, total):
    """Set total = sum of coefficients[s] * k[s] over first <= s < last, in the order of s."""
    size = rows * LANES
    for r in range(rows):
        for i in range(lanes):
            total[r * LANES + i] = 0.0
    for s in range(first, last):
        if coefficients[s] != 0.0:
            for r in range(rows):
                row = r * LANES
                ks = k[s * size + row : s * size + row + lanes]
                for i in range(lanes):
                    total[row + i] += coefficients[s] * ks[i]


@jit
def runge_kutta_stages(derivative, params, a, first, last, rows, lanes, step, z, k, work):
    """Fill the slopes k[first:last] (stages, rows*LANES) of an explicit tableau a at the state z."""
    size = rows * LANES
    for s in range(first, last):
        combine(rows, lanes, 0, s, a[s], k, work)
        for r in range(rows):
            for i in range(lanes):
                work[r * LANES + i] = z[r * LANES + i] + step[i] * work[r * LANES + i]
        derivative(params, lanes, work, k[s * size : (s + 1) * size])


@jit
def runge_kutta_step(derivative, params, a, b, rows, lanes, step, z, k, work):
    """Advance z by step[i] in lane i with an explicit Runge-Kutta tableau (a, b)."""
    runge_kutta_stages(derivative, params, a, 0, b.size, rows, lanes, step, z, k, work)
    combine(rows, lanes, 0, b.size, b, k, work)
    for r in range(rows):
        for i in range(lanes):
            z[r * LANES + i] += step[i] * work[r * LANES + i]


@jit
def advance(stage, derivative, params, drift, kick, a, b, rows, lanes, step, z, k, work):
    """Advance z by one step of the scheme: a splitting where it has kicks, else a Runge-Kutta tableau.

    Where z has room for increments and carried errors, the stage works on increments.
    """
    if kick.size > 0:
        splitting_step(stage, params, drift, kick, lanes, step, z)
        if z.size > rows * LANES:
            settle(rows, lanes, z)
    else:
        runge_kutta_step(derivative, params, a, b, rows, lanes, step, z, k, work)


@jit
def move_lane(rows, source, target, block):
    """Copy all rows of one lane over another lane of the same block."""
    for r in range(rows):
        block[r * LANES + target] = block[r * LANES + source]


@jit
def load_lane(table, column, block, lane):
    """Copy a column of table (rows, orbits) into a lane."""
    for r in range(table.shape[0]):
        block[r * LANES + lane] = table[r, column]


@jit
def store_lane(block, lane, table, column):
    """Copy a lane into a column of table (rows, orbits)."""
    for r in range(table.shape[0]):
        table[r, column] = block[r * LANES + lane]


@jit
def row(block, number):
    """Return the numbered row (LANES,) of a flat block."""
    return block[number * LANES : (number + 1) * LANES]
