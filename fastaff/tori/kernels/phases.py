"""Phase of a state between its turning points, and the partial integrals up to it."""

import numpy as np

from ...core.status import OK_CODE
from ...engine.jit import jit
from .coordinates import CHI, LINE, NODES, PANELS, S1, S2, SINE, T1, T2, W0, W2, W3, WIDTH
from .librations import FIRST, LEAST, TABLES, integrals, poles
from .panels import panel_value, turned_integral
from .wells import turning_points


@jit
def _dirichlet(nodes, x):
    """1 + 2 (cos x + ... + cos((nodes - 1) x))."""
    x = abs(x)
    x = x if x < np.pi else 2 * np.pi - x  # both sines of one small number: their errors cancel
    half = np.sin(0.5 * x)
    return np.sin((nodes - 0.5) * x) / half if abs(half) > 1e-12 else 2.0 * nodes - 1


@jit
def inverse_root(chi, work, out):
    """1/sqrt(G) at the phase chi: the cosine series through its values at the midpoints."""
    nodes = int(out[NODES])
    total = 0.0
    chi = chi if chi < np.pi else 2 * np.pi - chi
    if out[PANELS] > 0.0:
        return panel_value(FIRST + 1, chi, work, out)
    for k in range(nodes):
        at = (k + 0.5) * np.pi / nodes
        total += work[6, k] * (_dirichlet(nodes, chi - at) + _dirichlet(nodes, chi + at))
    return total / (2 * nodes)


@jit
def phase(kind, s0, t0, root0, work, out):
    """Set chi of the state: s = s1 + 2 l sin^2(chi/2), and near the turning points sqrt(F) = l sin(chi) sqrt(G),
    precise there.
    """
    width = out[WIDTH]
    if width <= 0.0:
        out[CHI] = 0.0
        return
    upper = kind == SINE and s0 > 0.5
    d1 = out[T1] - t0 if upper else s0 - out[S1]
    d2 = t0 - out[T2] if upper else out[S2] - s0
    sign = 1.0 if root0 >= 0.0 else -1.0
    chi = np.arctan2(sign * np.sqrt(max(0.0, d1 * d2)), (d2 - d1) / 2)
    near = d1 < 1e-3 * s0 or d2 < 1e-3 * (t0 if upper else s0)
    if near or kind == LINE:
        chi = np.arctan2(root0 * inverse_root(chi, work, out), (d2 - d1) / 2)
    out[CHI] = chi if chi >= 0.0 else chi + 2 * np.pi


@jit
def _partial_sums(chi, scale, work, out):
    """Set W0...W3 without the subtracted poles, from the midpoints."""
    nodes = int(out[NODES])
    half = nodes // 2
    off = nodes - LEAST
    last = work[10]
    now = work[11]
    even = work[2]
    odd = work[4]
    for k in range(half):  # cos(n chi) of node nodes - 1 - k is that of node k, with the sign (-1)^n
        last[k] = 1.0
        now[k] = TABLES[2, off + k]
        even[k] = chi
        odd[k] = 0.0
    sine = np.sin(chi)
    sine_last = 0.0
    turn = 2 * np.cos(chi)
    for n in range(1, nodes, 2):
        c = 2 * sine / n
        sine, sine_last = turn * sine - sine_last, sine
        d = 2 * sine / (n + 1) if n + 1 < nodes else 0.0
        sine, sine_last = turn * sine - sine_last, sine
        for k in range(half):
            double = 2 * TABLES[2, off + k]
            odd[k] += c * now[k]
            last[k] = double * now[k] - last[k]
            even[k] += d * last[k]
            now[k] = double * last[k] - now[k]
    for j in range(4):
        f = work[FIRST + 1 + j]
        total = 0.0
        for k in range(half):
            total += (even[k] + odd[k]) * f[k] + (even[k] - odd[k]) * f[nodes - 1 - k]
        out[W0 + j] = scale / nodes * total


@jit
def partials(coordinate, work, out):
    """Set W0...W3, the integrals of dJ/du0...dJ/du3 from chi = 0 to the state's chi (a whole turn gives dJ/du)."""
    mu = coordinate.mu
    kind = coordinate.kind
    chi = out[CHI]
    scale = (1.0 if kind == LINE else 0.5) * mu
    if out[PANELS] > 0.0:
        for j in range(4):
            out[W0 + j] = scale * turned_integral(FIRST + 1 + j, chi, work, out)
    else:
        _partial_sums(chi, scale, work, out)
    at_0, at_1 = poles(coordinate, out)
    half_sine = np.sin(chi / 2)
    half_cosine = np.cos(chi / 2)
    if at_0 > 0.0:
        out[W3] += mu / at_0 * np.arctan2(np.sqrt(out[S2]) * half_sine, np.sqrt(out[S1]) * half_cosine)
    if at_1 > 0.0:
        out[W2] += mu / at_1 * np.arctan2(np.sqrt(out[T2]) * half_sine, np.sqrt(out[T1]) * half_cosine)


@jit
def librate(coordinate, s0, t0, root0, speed2, goal, work, out):
    """Turning points, loop integrals, phase and integrals up to it of one state; returns a status."""
    code = turning_points(coordinate, s0, t0, root0, speed2, work, out)
    if code == OK_CODE:
        code = integrals(coordinate, goal, work, out)
    if code == OK_CODE:
        phase(coordinate.kind, s0, t0, root0, work, out)
        partials(coordinate, work, out)
    return code
