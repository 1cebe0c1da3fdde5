"""Basins of attraction: a million points of a map, a hundred thousand of a driven oscillator, beside NumPy.

Run: pytest bench/test_basins.py -s
"""

import numpy as np
from common import alternating

import fastaff as fa

NEWTON = fa.iterated_map(
    "d = (x**2 + y**2)**2; x1 = 2*x/3 + (x**2 - y**2)/(3*d); y1 = 2*y/3 - 2*x*y/(3*d)", coordinates="x", momenta="y"
)
DUFFING = fa.ode(
    fa.hamiltonian("x**4/4 - x**2/2", coordinates="x"), forces={"x": "a*cos(w*t) - g*p_x"}, g=0.15, a=0.2, w=1.0
)


def square(side):
    """Points of a square grid."""
    values = np.linspace(-2.0, 2.0, side)
    return np.array(np.meshgrid(values, values)).reshape(2, -1)


def twin(z0):
    """Roots of z^3 = 1 that Newton's method comes to, by NumPy; orbits are compared at every fifth step."""
    w = z0[0] + 1j * z0[1]
    roots = np.exp(2j * np.pi * np.arange(3) / 3)
    found = np.full(w.size, -1)
    while (found < 0).any():
        for _ in range(5):
            w = w - (w**3 - 1) / (3 * w**2)
        for k, root in enumerate(roots):
            found[(np.abs(w - root) < 1e-3) & (found < 0)] = k
    return found


def test_newtons_method(numbers):
    z0 = square(1000)
    fa.basins(NEWTON, z0[:, ::1000], time=100)
    runs = {"ours": lambda: fa.basins(NEWTON, z0, time=100), "numpy": lambda: twin(z0)}
    found, seconds = alternating(runs, repeats=1)
    own = found["ours"].points[0, 0] + 1j * found["ours"].points[1, 0]
    order = np.round(np.angle(own) / (2 * np.pi / 3)).astype(int) % 3
    numbers.update(
        seconds=seconds["ours"],
        numpy_seconds=seconds["numpy"],
        different_labels=int((order[found["ours"].label] != found["numpy"]).sum()),
    )


def test_driven_oscillator(numbers):
    z0 = square(316)
    z0 = np.concatenate([z0, np.ones((1, z0.shape[1])), np.zeros((1, z0.shape[1]))])
    fa.basins(DUFFING, z0[:, ::1000], time=2 * np.pi * 200)
    found, seconds = alternating({"ours": lambda: fa.basins(DUFFING, z0, time=2 * np.pi * 200)}, repeats=1)
    numbers.update(seconds=seconds["ours"], said=found["ours"].summary())
