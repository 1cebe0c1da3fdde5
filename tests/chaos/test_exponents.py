"""Errors of Lyapunov exponents: 99 % of the exponents of endless runs are within them."""

import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff.chaos.streamed import BLOCKS, LONG_MEMORY, RECORDS, averaging_error
from fastaff.systems.models.mechanics import system_of

LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
ROESSLER = fa.ode("x' = -y - z; y' = x + a*y; z' = b + z*(x - c)", a=0.2, b=0.2, c=5.7)
HENON = shared_systems.henon()


def exponents(model, z0, time):
    """The spectra of orbits and their errors."""
    loose = {} if system_of(model).iterated else {"rtol": 1e-8, "atol": 1e-8}
    found = fa.chaos_map(model, z0, time=time, indicators="spectrum", **loose)
    assert (found.status == fa.Status.OK).all()
    return found.spectrum, found.spectrum_error


def attracted(model, rng, orbits):
    """Starts on the attractor."""
    low, high, time = {LORENZ: (-5, 5, 30.0), ROESSLER: (0.5, 2, 100.0), HENON: (-0.1, 0.1, 100)}[model]
    rows = 2 if model is HENON else 3
    return fa.integrate(model, rng.uniform(low, high, (rows, orbits)), time=time).z


@pytest.mark.parametrize(
    ("model", "times", "truth"),
    [
        (LORENZ, (50.0, 250.0), (0.90566, 0.0, -14.57233)),  # Viswanath 1998; Sprott 2003
        (ROESSLER, (150.0, 800.0), (0.0714, 0.0, -5.3943)),
        (HENON, (300, 4000), (0.41920, np.log(0.3) - 0.41920)),
    ],
    ids=["Lorenz", "Roessler", "Henon map"],
)
def test_errors_of_exponents_cover_on_attractors(model, times, truth):
    z0 = attracted(model, np.random.default_rng(11), 150)
    truth = np.array(truth)[:, None]
    for time in times:
        found, error = exponents(model, z0, time)
        ratio = np.abs(found - truth) / error
        assert np.mean(ratio <= 1) >= 0.99
        assert ratio.max() < 3
        assert np.median(error[0]) < 25 * np.median(np.abs(found - truth)[0])


@pytest.mark.parametrize(("K", "truth", "share"), [(4.0, None, 0.98), (8.0, None, 0.99), (15.0, np.log(7.5), 0.99)])
def test_errors_of_exponents_cover_on_the_standard_map(K, truth, share):
    """ln(K/2) for large K (Chirikov 1979), else the mean of long runs; orbits in islands are left out, of which those
    of K = 4 are large enough to stick to.
    """
    rng = np.random.default_rng(int(K))
    model = fa.models.StandardMap(K)
    z0 = rng.uniform(0, 2 * np.pi, (2, 200))
    late = fa.chaos_map(model, z0, time=100_000, indicators="spectrum")
    sea = late.spectrum[0] > 0.8 * np.median(late.spectrum[0])
    assert sea.sum() > 150
    mean = late.spectrum[0, sea].mean()
    assert truth is None or mean == pytest.approx(truth, abs=0.02)
    for time in (300, 3000):
        found, error = exponents(model, z0[:, sea], time)
        ratio = np.abs(found[0] - mean) / error[0]
        assert np.mean(ratio <= 1) >= share
        assert ratio.max() < 10


def test_exponents_of_regular_orbits_are_zero_within_their_errors():
    z0 = fa.energy_sample(fa.HenonHeiles(), energy=1 / 12, section="x=0", orbits=100, seed=3).z0
    for time in (300.0, 1000.0, 4000.0):
        found = fa.chaos_map(fa.HenonHeiles(), z0, time=time, indicators="spectrum", step=0.1)
        ratio = np.abs(found.spectrum) / found.spectrum_error
        assert np.mean(ratio <= 1) >= 0.99
        assert ratio.max() < 3


@pytest.mark.parametrize("blocks", [BLOCKS, LONG_MEMORY], ids=["dissipative", "symplectic"])
def test_the_error_is_that_of_averages_with_memory(blocks):
    """Increments of an autoregressive process of known mean, of long and short memory, beside a start that differs."""
    rng = np.random.default_rng(7)
    for memory in (0.0, 0.5, 0.9):
        noise = rng.normal(size=(2000, 640))
        for k in range(1, 640):
            noise[:, k] = memory * noise[:, k - 1] + np.sqrt(1 - memory**2) * noise[:, k]
        S = np.cumsum(0.3 + noise, axis=1)[:, 19::20] + rng.normal(scale=10.0, size=(2000, 1))
        times = np.broadcast_to(20.0 * np.arange(1, RECORDS + 1)[:, None], (RECORDS, 2000))
        mean = S[:, -1] / 640
        error = averaging_error(times, S.T[None], mean[None], blocks)[0]
        assert np.mean(np.abs(mean - 0.3) <= error) >= 0.99
    cut = np.where(np.arange(RECORDS)[:, None] < 5, times, np.nan)  # an orbit that ended early
    assert np.isinf(averaging_error(cut, S.T[None], mean[None], blocks)).all()


def test_the_history_is_the_same_with_and_without_a_spectrum():
    """A spectrum keeps more records than the user asks for: the history is some of them."""
    for records in (3, 7, 40):
        run = {"time": 60.0, "history": records, "step": 0.1}
        alone = fa.chaos_map(fa.HenonHeiles(), [0.1, 0.2, 0.3, 0.1], indicators="sali", **run)
        both = fa.chaos_map(fa.HenonHeiles(), [0.1, 0.2, 0.3, 0.1], indicators="sali,spectrum", **run)
        assert both.history.shape == (2, records, 1)
        np.testing.assert_allclose(both.history_times, alone.history_times, rtol=1e-13)
        np.testing.assert_allclose(both.history[0], alone.history[0], atol=1e-9)
