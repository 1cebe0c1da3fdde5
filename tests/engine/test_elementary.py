"""Branch-free elementary functions against 200-bit arithmetic, at special numbers, and in the place of NumPy's."""

from __future__ import annotations

import math
from typing import NamedTuple

import mpmath
import numba
import numpy as np
import pytest

import fastaff as fa
from fastaff.engine import elementary, substitution
from fastaff.engine.blocks import model_block
from fastaff.engine.fused import FUSED
from fastaff.engine.jit import JIT_DISABLED, LANES
from fastaff.engine.values import parameters
from fastaff.systems.formulas.grammar import FUNCTIONS

pytestmark = pytest.mark.skipif(not FUSED or JIT_DISABLED, reason="they are NumPy's there")

NUMBERS = 400
"""Random arguments of each kind that are compared with 200 bits."""


def wide(rng, low, high, size=NUMBERS):
    """Numbers of both signs with all magnitudes between 10^low and 10^high."""
    return 10.0 ** rng.uniform(low, high, size) * rng.choice([-1.0, 1.0], size)


def near(rng, low, high):
    """Numbers near 1."""
    return 1.0 + wide(rng, low, high)


ANGLES = [lambda rng: wide(rng, -300, 10), lambda rng: rng.uniform(-10, 10, NUMBERS)]
GROWING = [lambda rng: wide(rng, -300, 2.84), lambda rng: rng.uniform(-3, 3, NUMBERS)]
ONE = {
    "exp": (mpmath.exp, 1.0, [*GROWING, lambda rng: rng.uniform(-707, 709.7, NUMBERS)]),
    "expm1": (mpmath.expm1, 1.0, [*GROWING, lambda rng: rng.uniform(-50, 709.7, NUMBERS)]),
    "log": (
        mpmath.log,
        1.0,
        [
            lambda rng: abs(wide(rng, -323, 308)),
            lambda rng: rng.uniform(0.3, 3, NUMBERS),
            lambda rng: near(rng, -15, -1),
        ],
    ),
    "sin": (mpmath.sin, 1.0, ANGLES),
    "cos": (mpmath.cos, 1.0, ANGLES),
    "tan": (mpmath.tan, 1.0, ANGLES),
    "sinh": (mpmath.sinh, 1.0, [*GROWING, lambda rng: rng.uniform(-710.4, 710.4, NUMBERS)]),
    "cosh": (mpmath.cosh, 1.0, [*GROWING, lambda rng: rng.uniform(-710.4, 710.4, NUMBERS)]),
    "tanh": (mpmath.tanh, 1.0, [*GROWING, lambda rng: rng.uniform(-25, 25, NUMBERS)]),
    "arctan": (mpmath.atan, 1.0, [lambda rng: wide(rng, -300, 300), lambda rng: rng.uniform(-3, 3, NUMBERS)]),
    "arcsin": (mpmath.asin, 1.4, [lambda rng: wide(rng, -300, 0), lambda rng: near(rng, -15, -1) - 0.1]),
    "arccos": (mpmath.acos, 1.4, [lambda rng: wide(rng, -300, 0), lambda rng: rng.uniform(-1, 1, NUMBERS)]),
}
TWO = {
    "arctan2": (
        mpmath.atan2,
        1.0,
        [(lambda rng: wide(rng, -3, 3),) * 2, (lambda rng: wide(rng, -300, 300),) * 2],
    ),
    "hypot": (mpmath.hypot, 1.2, [(lambda rng: wide(rng, -1, 1),) * 2, (lambda rng: wide(rng, -300, 307),) * 2]),
    "power": (
        mpmath.power,
        1.0,
        [
            (lambda rng: abs(wide(rng, -300, 308)), lambda rng: rng.uniform(-1, 1, NUMBERS)),
            (lambda rng: rng.uniform(0, 3, NUMBERS), lambda rng: wide(rng, -3, 2)),
            (lambda rng: near(rng, -15, -1), lambda rng: wide(rng, -3, 16)),
            (lambda rng: wide(rng, -5, 5), lambda rng: rng.integers(-20, 21, NUMBERS).astype(float)),
        ],
    ),
}
COMPILED: dict = {}


def values(name, *arguments):
    """The function of arrays, in one compiled loop."""
    if name not in COMPILED:
        function = getattr(elementary, name)
        if len(arguments) == 1:
            COMPILED[name] = numba.njit(lambda x, r: _one(function, x, r))
        else:
            COMPILED[name] = numba.njit(lambda x, y, r: _two(function, x, y, r))
    result = np.empty(arguments[0].size)
    COMPILED[name](*(np.ascontiguousarray(entry, dtype=float) for entry in arguments), result)
    return result


@numba.njit(error_model="numpy")
def _one(function, x, r):
    for i in range(r.size):
        r[i] = function(x[i])


@numba.njit(error_model="numpy")
def _two(function, x, y, r):
    for i in range(r.size):
        r[i] = function(x[i], y[i])


def ulps(name, exact, *arguments):
    """Errors in units in the last place, of results that are ordinary numbers below the largest."""
    found, errors = values(name, *arguments), []
    with mpmath.workprec(200):
        for value, *given in zip(found, *arguments, strict=True):
            true = exact(*map(mpmath.mpf, map(float, given)))
            if 3.4e-308 < abs(true) < 1.79e308:
                errors.append(float(abs(mpmath.mpf(value) - true) / mpmath.mpf(np.spacing(abs(float(true))))))
    return np.array(errors)


@pytest.mark.parametrize("name", ONE)
def test_functions_of_one_number_are_right_to_a_unit_in_the_last_place(name):
    exact, bound, kinds = ONE[name]
    for seed, kind in enumerate(kinds):
        x = kind(np.random.default_rng(seed))
        errors = ulps(name, exact, x[abs(x) <= 1] if name in ("arcsin", "arccos") else x)
        assert errors.size > NUMBERS / 3
        assert errors.max() < bound


@pytest.mark.parametrize("name", TWO)
def test_functions_of_two_numbers_are_right_to_a_unit_in_the_last_place(name):
    exact, bound, kinds = TWO[name]
    for seed, (first, second) in enumerate(kinds):
        rng = np.random.default_rng(seed)
        errors = ulps(name, exact, first(rng), second(rng))
        assert errors.size > NUMBERS / 3
        assert errors.max() < bound


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sines_of_large_numbers_have_small_absolute_errors_or_are_nan(name):
    x = wide(np.random.default_rng(3), 10, 15.2)
    with mpmath.workprec(200):
        true = np.array([float(getattr(mpmath, name)(mpmath.mpf(float(entry)))) for entry in x])
    np.testing.assert_allclose(values(name, x), true, rtol=0, atol=2e-12)
    assert np.isnan(values(name, np.array([1.8e15, -3e15, 2.0**52, 1e16, -1e18, 1e300]))).all()


SPECIAL = [0.0, -0.0, np.inf, -np.inf, np.nan, 5e-324, -5e-324, 1e-310, 2.2250738585072014e-308]
LARGE = [1e300, -1e300, 1.7976931348623157e308, -1.7976931348623157e308, 2.0**53 + 2, 1e5, -1e5]
BORDERS = [-708.0, -745.0, -746.0, 709.78, 709.782712893384, 709.7827128933841, 710.0, 710.4758600739439, 711.0]
EDGES = np.array([*SPECIAL, *LARGE, *BORDERS, 710.475860073944, 1.0, -1.0, 0.5, 2.0, 3.0, -3.0])


def agrees(found, true):
    """Whether special numbers are the same, others within two units; NaN, which becomes a status, and 0 for what is
    below 3.4e-308 are allowed too.
    """
    with np.errstate(all="ignore"):
        close = (found == true) | (abs(found - true) <= 2 * np.spacing(abs(true)))
    return close | np.isnan(found) | ((found == 0) & (abs(true) < 3.4e-308))


@pytest.mark.parametrize("name", [*ONE, *TWO])
def test_at_the_edges_they_give_what_numpy_gives_or_nan(name):
    given = [EDGES] if name in ONE else [grid.ravel() for grid in np.meshgrid(EDGES, EDGES)]
    found = values(name, *given)
    with np.errstate(all="ignore"):
        true = getattr(np, name)(*given)
    assert agrees(found, true).all(), [entry[~agrees(found, true)] for entry in (*given, found, true)]
    only = np.isnan(found) & ~np.isnan(true)  # NaN where there is a value
    allowed = abs(given[0]) > 1e15 if name in ("sin", "cos", "tan") else np.isinf(given).any(axis=0) & (name == "power")
    assert not (only & ~allowed).any()
    assert np.isnan(found[np.isnan(true)]).all()


@pytest.mark.parametrize("name", [*ONE, *TWO])
def test_the_same_bits_in_vectors_and_alone_and_vectors_there_are(name):
    rng = np.random.default_rng(5)
    given = [rng.uniform(0.05, 0.95, 37) for _ in range(1 if name in ONE else 2)]
    together = values(name, *given)
    alone = [values(name, *(entry[i : i + 1] for entry in given))[0] for i in range(37)]
    np.testing.assert_array_equal(together, alone)
    (text,) = COMPILED[name].inspect_llvm().values()
    assert "x double> @llvm.fma.v" in text


def test_all_functions_of_formulas_are_replaced_but_the_root_which_is_an_instruction():
    for name in FUNCTIONS:
        if name != "sqrt":
            free = substitution.replaced(lambda x, name=name: getattr(np, name)(x))
            assert free.__globals__["np"] is not np
            assert getattr(free.__globals__["np"], name) is not getattr(np, name)
            assert getattr(free.__globals__["math"], name) is getattr(free.__globals__["np"], name)
    assert free.__globals__["np"].sqrt is np.sqrt


def read_in_many_ways():
    """A function that reads others by module, by name and from a scope, of numbers, whole ones, complex ones and
    arrays.
    """
    own = math.cos
    return lambda x, k, z, a: (np.sin(x), by_name(x), own(x), np.power(k, 2), np.exp(z), np.exp(a), math.atan2(x, k))


by_name = np.tanh


def test_functions_are_replaced_however_they_are_read():
    function = read_in_many_ways()
    twin = substitution.replaced(function)
    given = 0.7, 3, 1 + 2j, np.array([0.1, 0.2])
    found, true = numba.njit(twin)(*given), function(*given)
    for value, other in zip(found, true, strict=True):
        np.testing.assert_allclose(value, other, rtol=1e-15)
    assert found[0] == values("sin", np.array([0.7]))[0]
    assert found[1] == values("tanh", np.array([0.7]))[0]
    assert found[2] == values("cos", np.array([0.7]))[0]
    assert twin.__qualname__ == function.__qualname__
    assert (twin.__module__, twin.__closure__ is None) == (function.__module__, False)


class Chain(NamedTuple):
    """A force of many terms: one that LLVM would not inline by itself."""

    k: float = 1.0

    degrees_of_freedom = 2
    coordinates = ("x", "y")

    def velocity(self, px, py):
        return px, py

    def force(self, x, y):
        fx = np.exp(-x) - self.k * np.sin(x) * np.cosh(y) - np.tanh(x - y) - np.arctan(x + y) + np.log(4 + x * x)
        fy = -np.cos(x) * np.sinh(y) + np.tanh(x - y) - np.arctan(x + y) - np.power(4 + y * y, 0.3) - np.expm1(0.1 * y)
        return fx, fy

    def kinetic_energy(self, px, py):
        return (px * px + py * py) / 2

    def potential_energy(self, x, y):
        return 0.0 * x

    def margin(self, x, y):
        return 1.0 + 0.0 * x


@pytest.mark.parametrize("lanes", [1, 5, 8, 128])
def test_a_block_has_the_bits_of_a_single_orbit_and_the_values_of_numpy(lanes):
    model, rng = Chain(), np.random.default_rng(lanes)
    tables = fa.KAHAN_LI8.drift_array, fa.KAHAN_LI8.kick_array
    z = np.zeros((4, LANES))
    z[:, :lanes] = rng.uniform(-1, 1, (4, lanes))
    step = np.full(LANES, 0.1)
    block, one = z.ravel().copy(), z.ravel().copy()
    _block(model_block("splitting", model, 2), parameters(model), lanes, *tables, step, 2, block)
    _march(model_block("march", model, 2), parameters(model), *tables, 0.1, 2, one)
    np.testing.assert_array_equal(block[::LANES], one[::LANES])
    q, p = z[:2, :lanes], z[2:, :lanes]
    for _ in range(2):
        for drift, kick in zip(tables[0], (*tables[1], 0.0), strict=True):
            q = q + 0.1 * drift * p
            p = p + 0.1 * kick * np.array(model.force(*q))
    np.testing.assert_allclose(block.reshape(4, LANES)[:, :lanes], [*q, *p], rtol=1e-13, atol=1e-13)


@numba.njit
def _block(block, params, lanes, drift, kick, step, steps, z):
    return block(params, lanes, drift, kick, step, steps, z)


@numba.njit
def _march(block, params, drift, kick, step, steps, z):
    return block(params, drift, kick, step, steps, z, z[:0])
