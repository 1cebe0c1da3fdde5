"""The pieces of a frequency: the window, the signals of the angles, and the loops that never pass their
centre.
"""

from functools import cache

import numpy as np
import pytest
from naive import march, states

from fastaff import SOFRONIOU_SPALETTA10, Body, HeavyTop, HenonHeiles
from fastaff.engine.kernels import birkhoff as rotation
from fastaff.systems.models.angles import AlphaBeta, Coordinates2, RVartheta

BODY = Body(HeavyTop(1.0, 0.5), 1.2)
CASES = [(AlphaBeta(), BODY), (RVartheta(), BODY), (Coordinates2(), HenonHeiles())]
weight = getattr(rotation.weight, "py_func", rotation.weight)


def formula(x):
    return np.exp(rotation.SHARPNESS * (np.sqrt(1 - x**2) - 1))


def test_weight_is_its_formula():
    """The Taylor series and seven squarings: 128 roundings of 1 + u at most."""
    x = np.concatenate([np.linspace(-0.999999, 0.999999, 20001), [-1 + 1e-12, 1 - 1e-12, 0.0]])
    ours = np.array([weight(float(t)) for t in x])
    np.testing.assert_allclose(ours, formula(x), rtol=5e-14)
    compiled = np.array([rotation.weight(float(t)) for t in x[::50]])
    np.testing.assert_allclose(compiled, formula(x[::50]), rtol=5e-14)


@pytest.mark.parametrize("x", [1.0, -1.0, 1.0 + 1e-15, -1.5, 40.0, -1e300])
def test_weight_is_zero_outside_its_window(x):
    assert weight(x) == 0.0


def test_the_window_damps_lines_as_it_says():
    """A line further than beta/pi cycles per window from zero is damped by e^-beta, over the mean weight: some
    1e-12.
    """
    n = 40_000
    x = 2 * (np.arange(1, n) / n) - 1
    w = np.array([weight(float(t)) for t in x])
    for cycles in np.linspace(rotation.SHARPNESS / np.pi * 1.02, 60, 300):
        assert abs((w * np.exp(1j * np.pi * cycles * x)).sum()) < 3e-12 * w.sum()
    assert abs((w * np.exp(1j * np.pi * 5 * x)).sum()) > 1e-6 * w.sum()


def loops(angles, path, kappa=1.0):
    """f_k = Q - c - i kappa P along a path (times, 2n), with centre and scale from the whole of it."""
    s = np.array(angles.signals(*path.T)).reshape(len(angles.names), 4, -1)
    Q, P = s[:, 0] + 1j * s[:, 1], s[:, 2] + 1j * s[:, 3]
    f = []
    for k, plane in enumerate(angles.planes):
        width = [np.ptp(x) for x in s[k]]
        scale = kappa * max(width[0], width[1]) / max(width[2], width[3])
        centre = 0.0 if plane else (s[k, 0].max() + s[k, 0].min()) / 2
        turning = np.mean((Q[k].conj() * P[k]).imag) if plane else 0.0
        f.append(Q[k] - centre - 1j * scale * (-1.0 if turning < 0 else 1.0) * P[k])
    return np.array(f)


def winding(f):
    return np.angle(f[:, 1:] / f[:, :-1]).sum(axis=1)


@cache
def long_paths():
    """Paths (times, 2n) of four random orbits."""
    z0 = np.concatenate([states(BODY, 1, seed=seed) for seed in range(4)], axis=1)
    return np.moveaxis(march(BODY, SOFRONIOU_SPALETTA10, z0, 0.1, 1000), -1, 0)


@pytest.mark.parametrize("angles", [AlphaBeta(), RVartheta()], ids=lambda v: type(v).__name__)
@pytest.mark.parametrize("kappa", [0.3, 1.0, 3.0])
def test_the_loop_of_a_plane_turns_as_the_plane_does(angles, kappa):
    """|f|^2 = |Q|^2 + kappa^2 |P|^2 + 2 |kappa L| > 0: no zero between kappa = 0 and kappa, so the same mean rate.

    The angles differ by less than half a turn for ever, whatever kappa; the sign of L is that of the plane's momentum.
    """
    for path in long_paths():
        f = loops(angles, path, kappa)
        for k, (i, j) in ((2, (0, 1)), (3, (2, 3))):
            L = path[0, i] * path[0, 4 + j] - path[0, j] * path[0, 4 + i]
            plane = path[:, i] + 1j * path[:, j]
            turned = np.angle(plane[1:] / plane[:-1]).sum()
            assert abs(winding(f)[k] - turned) <= np.pi + 1e-6
            assert np.sign(turned) == np.sign(L)
            assert np.abs(f[k]).min() > 0.0


def test_librations_turn_the_positive_way():
    """q = cos, p = -sin has a positive rate: alpha, beta, r, vartheta, x and y all count upwards."""
    for angles, model in CASES:
        z0 = states(model, 1, seed=3)[:, 0]
        path = march(model, SOFRONIOU_SPALETTA10, z0, 0.05, 1200)
        turned = winding(loops(angles, path))
        librations = [k for k, plane in enumerate(angles.planes) if not plane]
        assert (turned[librations] > 2 * np.pi).all()
