"""Streamed rotation rates: weighted Birkhoff averages of the increments of angles (layer L2).

Observer memory, in rows of LANES: the 4 n signals Re Q, Im Q, Re P, Im P of each angle; then SHARED rows (three sums of
weights, time of the last observation); then PER_ANGLE rows of each angle (centre, scale kappa, last loop (2), three sums); then the three weights of the moment.
The three windows are the whole time, its first half and its second half.
"""

from __future__ import annotations

import math

from .._jit import LANES, jit

SHARED, PER_ANGLE = 4, 7

SHARPNESS = 30.0
"""beta of the weight exp(beta (sqrt(1 - x^2) - 1)) on -1 < x < 1 (Barnett, Magland & af Klinteberg 2019, SIAM J. Sci. Comput. 41,
C479): a line further than beta/pi cycles per window from zero is damped by e^-beta ~ 1e-13."""


@jit
def angle(y, x):
    """Return atan2(y, x) to 2 ulp without a branch, so that loops over lanes vectorise."""
    ax, ay = abs(x), abs(y)
    small, large = min(ax, ay), max(ax, ay)
    far = small > 0.41421356237309503 * large
    numerator = small - large if far else small
    denominator = small + large if far else large
    s = numerator / (denominator if denominator > 0.0 else 1.0)
    u = s * s
    # atan(s)/s on |s| <= tan(pi/8) in powers of u: mpmath.chebyfit at 40 digits, error 1.3e-18
    c = -0.017805397205419446
    c = c * u + 0.03796525745386593
    c = c * u - 0.05035102456601552
    c = c * u + 0.05846878297330872
    c = c * u - 0.06662951813629191
    c = c * u + 0.07692045330902225
    c = c * u - 0.09090896809064027
    c = c * u + 0.11111110744919658
    c = c * u - 0.14285714279250245
    c = c * u + 0.19999999999940893
    c = c * u - 0.3333333333333312
    c = c * u + 1.0
    value = s * c + (0.78539816339744828 if far else 0.0)
    value = 1.5707963267948966 - value if ay > ax else value
    value = 3.1415926535897931 - value if x < 0.0 else value
    return -value if y < 0.0 else value


@jit
def weight(x):
    """Return the weight at -1 < x < 1 of a window, 0 outside it."""
    return math.exp(SHARPNESS * (math.sqrt(1.0 - x * x) - 1.0)) if abs(x) < 1.0 else 0.0


@jit
def rotate(time, angles, lanes, fresh, t, memory):
    """Add the increments of all angles, weighted at the middle of the interval; memory as in the module text."""
    shared = 4 * angles * LANES
    weights = shared + SHARED * LANES + PER_ANGLE * angles * LANES
    last, w0, w1, w2 = -1.0, 0.0, 0.0, 0.0
    for i in range(lanes):
        before = shared + 3 * LANES + i
        if fresh[i] == 0.0:
            for j in range(3):
                memory[weights + j * LANES + i] = 0.0
            continue
        # Lanes usually share their time: the weights of the lane before are used again.
        if t[i] + memory[before] != last:
            last = t[i] + memory[before]
            x = last / time - 1.0
            w0, w1, w2 = weight(x), weight(2.0 * x + 1.0), weight(2.0 * x - 1.0)
        memory[weights + i], memory[weights + LANES + i], memory[weights + 2 * LANES + i] = w0, w1, w2
        memory[before] = t[i]
    for j in range(3):
        for i in range(lanes):
            memory[shared + j * LANES + i] += memory[weights + j * LANES + i]
    for n in range(angles):
        s = 4 * n * LANES
        m = shared + (SHARED + PER_ANGLE * n) * LANES
        for i in range(lanes):
            centre, kappa = memory[m + i], memory[m + LANES + i]
            re = memory[s + i] - centre + kappa * memory[s + 3 * LANES + i]
            im = memory[s + LANES + i] - kappa * memory[s + 2 * LANES + i]
            re0, im0 = memory[m + 2 * LANES + i], memory[m + 3 * LANES + i]
            turn = angle(im * re0 - re * im0, re * re0 + im * im0)
            memory[m + 4 * LANES + i] += memory[weights + i] * turn
            memory[m + 5 * LANES + i] += memory[weights + LANES + i] * turn
            memory[m + 6 * LANES + i] += memory[weights + 2 * LANES + i] * turn
            memory[m + 2 * LANES + i] = re if fresh[i] > 0.0 else re0
            memory[m + 3 * LANES + i] = im if fresh[i] > 0.0 else im0


@jit
def widen(signals, lanes, fresh, memory):
    """Widen the range of each signal: memory rows are signals, smallest values, largest values."""
    for s in range(signals):
        for i in range(lanes):
            value = memory[s * LANES + i]
            j, k = (signals + s) * LANES + i, (2 * signals + s) * LANES + i
            memory[j] = min(memory[j], value) if fresh[i] > 0.0 else memory[j]
            memory[k] = max(memory[k], value) if fresh[i] > 0.0 else memory[k]


@jit
def sample(rows, lanes, orbit, fresh, block, memory, out):
    """Write the rows of block as the next sample of each orbit; row `rows` of memory counts the samples."""
    for i in range(lanes):
        taken = int(memory[rows * LANES + i])
        if fresh[i] > 0.0 and (taken + 1) * rows <= out.shape[1]:
            for r in range(rows):
                out[orbit[i], taken * rows + r] = block[r * LANES + i]
            memory[rows * LANES + i] += 1.0
