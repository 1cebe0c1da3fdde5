"""Files of JPL's periodic orbits, with an orbit found by SciPy."""

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import fastaff as fa
from fastaff.exchange.jpl import read_periodic

MASS = 0.01215058560962404


def _slopes(_, s):
    x, y, z, vx, vy, vz = s
    a, b = ((x + MASS) ** 2 + y * y + z * z) ** -1.5, ((x - 1 + MASS) ** 2 + y * y + z * z) ** -1.5
    pull = (1 - MASS) * a + MASS * b
    ax = 2 * vy + x - (1 - MASS) * (x + MASS) * a - MASS * (x - 1 + MASS) * b
    return [vx, vy, vz, ax, -2 * vx + y - pull * y, -pull * z]


def _halo(z):
    """A halo orbit about L1 of the Earth and the Moon: perpendicular twice to the plane y = 0."""

    def half(s):
        state = [s[0], 0.0, z, 0.0, s[1], 0.0]
        return solve_ivp(_slopes, (0, s[2]), state, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]

    found = root(lambda s: half(s)[[1, 3, 5]], [0.8234, 0.1263, 1.3719], tol=1e-13)
    assert found.success
    x, vy, time = found.x
    r1, r2 = np.hypot(x + MASS, z), np.hypot(x - 1 + MASS, z)
    return x, 0.0, z, 0.0, vy, 0.0, x * x + 2 * (1 - MASS) / r1 + 2 * MASS / r2 - vy * vy, 2 * time


def _file(tmp_path, **changes):
    rows = [_halo(z) for z in (0.03, 0.05)]
    content = {
        "signature": {"source": "NASA/JPL Three-Body Periodic Orbits API", "version": "1.0"},
        "system": {"name": "Earth-Moon", "mass_ratio": f"{MASS!r}", "lunit": "389703.26", "tunit": "382981.29"},
        "family": "halo",
        "count": str(len(rows)),
        "fields": ["x", "y", "z", "vx", "vy", "vz", "jacobi", "period", "stability"],
        "data": [[f"{float(entry):.15e}" for entry in (*row, 1.0)] for row in rows],
    }
    path = tmp_path / "orbits.json"
    path.write_text(json.dumps(content | changes))
    return path


@pytest.mark.slow
def test_orbits_of_a_file_are_periodic(tmp_path):
    table = read_periodic(_file(tmp_path))
    assert table.family == "halo"
    assert table.length == 389703.26
    for z, period in zip(table.z0.T, table.period, strict=True):
        found = fa.integrate(table.model, z, time=period, accuracy=1e-12)
        np.testing.assert_allclose(found.z[:, 0], z, atol=1e-8)


@pytest.mark.slow
def test_a_family_goes_on_from_a_file(tmp_path):
    table = read_periodic(_file(tmp_path))
    family = fa.continuation(table.model, table.z0[:, 0], section="y=0", max_steps=3)
    np.testing.assert_allclose(family.orbits.period[0], table.period[0], rtol=1e-9)
    np.testing.assert_allclose(family.parameter[0], -table.jacobi[0] / 2, atol=1e-10)
    assert len(family.parameter) == 4


def test_what_is_no_such_file_is_refused(tmp_path):
    for changes, word in (({"fields": ["x", "y"]}, "'z' is not in list"), ({"system": {}}, "mass_ratio")):
        with pytest.raises(ValueError, match=f"path must be a file of JPL.*{word}"):
            read_periodic(_file(tmp_path, **changes))
    other = {"name": "Sun-Earth", "mass_ratio": "3.05e-6"}
    with pytest.raises(ValueError, match="data must have the Jacobi constants"):
        read_periodic(_file(tmp_path, system=other))
