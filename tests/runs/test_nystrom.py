"""RKN12 in runs: the same bits in any company, crossings on its own flow, errors that cover, and what it refuses."""

from fractions import Fraction

import numba
import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff.engine.fused import FUSED
from fastaff.engine.jit import JIT_DISABLED
from fastaff.engine.lane_sums import CHAIN, VECTOR, sum_of_table
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, RKN12, SOFRONIOU_SPALETTA10

DRIVEN = fa.hamiltonian("-cos(x) - a*cos(x - w*t)", coordinates="x", drive_period="2*pi/w", a=0.3, w=1.25)
PLANE = shared_systems.plane(1, 1.3, f=1.4)
SPREAD = 0.3


def starts(model, orbits, seed):
    rng, n = np.random.default_rng(seed), 1 if model is DRIVEN else 2
    return rng.uniform(-SPREAD, SPREAD, (2 * n, orbits))


@pytest.mark.parametrize("model", [PLANE, DRIVEN], ids=["natural", "driven"])
def test_an_orbit_has_its_bits_in_any_company(model):
    """In vectors, among the lanes left over, in a block of several portions, on two threads, alone."""
    z0, run = starts(model, 150, 1), {"time": 20.0, "step": 0.4, "scheme": RKN12, "samples": 5}
    whole = fa.integrate(model, z0, threads=2, **run)
    for part in (slice(0, 1), slice(0, 67), slice(3, 132), slice(149, 150)):
        some = fa.integrate(model, z0[:, part], threads=1, **run)
        np.testing.assert_array_equal(some.samples, whole.samples[..., part])
        np.testing.assert_array_equal(some.energy_error, whole.energy_error[part])
    finer = fa.integrate(model, z0, time=20.0, step=0.05, scheme=SOFRONIOU_SPALETTA10)
    assert np.abs(whole.z - finer.z).max() < 1e-6


@pytest.mark.parametrize("alone", [True, False])
def test_crossings_are_located_on_its_own_flow(alone):
    """To rounding on the section, at the times of a finer run."""
    z0 = starts(PLANE, 1 if alone else 40, 3)
    run = {"section": "x=0", "crossings": 10, "max_time": 200.0}
    ours = fa.poincare_map(PLANE, z0, step=0.4, scheme=RKN12, **run)
    finer = fa.poincare_map(PLANE, z0, step=0.05, scheme=SOFRONIOU_SPALETTA10, **run)
    np.testing.assert_array_equal(ours.counts, finer.counts)
    np.testing.assert_allclose(ours.times, finer.times, rtol=0, atol=1e-10)
    assert np.nanmax(ours.section_error) < 1e-15


@pytest.mark.skipif(not FUSED or JIT_DISABLED, reason="no such instruction")
@pytest.mark.parametrize("vectors", [True, False])
def test_sums_of_a_table_are_chains_of_multiply_adds(vectors):
    """To the last bit those in exact arithmetic that is rounded where a chain is; a sum of nothing is 0."""
    rng, size, apart = np.random.default_rng(6), 3 * VECTOR if vectors else 5, 40
    table = ((), *(tuple(sorted(rng.choice(20, count, replace=False).tolist())) for count in (1, 3, 4, 5, 8, 18)))
    k, weights = rng.normal(size=20 * apart), rng.normal(size=sum(map(len, table)))
    summed = sum_of_table(table, apart, vectors)

    @numba.njit
    def run(total, k, weights, s, size):
        summed(total, k, weights, s, size)

    used = 0
    for s, terms in enumerate(table):
        total = np.full(size + 1, np.nan)
        run(total, k, weights, s, size)
        for i in range(size):
            chains = [0.0] if not terms else []
            for j, term in enumerate(terms):
                before = Fraction(0) if j % CHAIN == 0 else Fraction(chains.pop())
                chains.append(float(Fraction(weights[used + j]) * Fraction(k[apart * term + i]) + before))
            whole = chains[0]
            for chain in chains[1:]:
                whole += chain
            assert total[i] == whole
        assert np.isnan(total[size])
        used += len(terms)


def test_steps_do_not_lose_digits():
    """The energy of long runs with short steps: rounding errors are carried on, sums of large coefficients are not."""
    run = fa.integrate(PLANE, starts(PLANE, 64, 4), time=2000.0, step=0.15, scheme=RKN12)
    assert np.quantile(run.energy_error, 0.9) < 1e-13


def test_errors_cover_the_truth_where_the_package_takes_it():
    """Driven systems from 1e-11 and others from 1e-12, of drawn parameters: 99 % within, none ten times beyond."""
    rng, ratios = np.random.default_rng(5), []
    for _ in range(4):
        a, w, accuracy = rng.uniform(0.01, 0.2), rng.uniform(0.7, 2.0), 10 ** rng.uniform(-13, -11)
        pendulum, natural = DRIVEN._replace(a=a, w=w), PLANE._replace(b=w, f=2 * a)
        for model, rows, asked in ((pendulum, 2, accuracy), (natural, 4, 0.1 * accuracy)):
            z0, time = rng.uniform(-0.8, 0.8, (rows, 40)), rng.uniform(5.0, 60.0)
            run = fa.integrate(model, z0, time=time, accuracy=asked)
            assert run.scheme == RKN12
            truth = fa.integrate(model, z0, time=time, step=0.02, scheme=SOFRONIOU_SPALETTA10)
            own = [0, 2] if model is pendulum else slice(None)
            ratios.append(np.abs(run.z - truth.z)[own] / np.maximum(run.error[own], 1e-14))
    ratios = np.concatenate([entry.ravel() for entry in ratios])
    assert (ratios <= 1).mean() >= 0.99
    assert ratios.max() < 10


def test_the_package_takes_it_where_it_is_quickest():
    z0 = {model: starts(model, 4, 6) for model in (DRIVEN, PLANE)}
    taken = {
        (model is DRIVEN, accuracy): fa.integrate(model, z0[model], time=5.0, accuracy=accuracy).scheme
        for model in (DRIVEN, PLANE)
        for accuracy in (1e-10, 1e-11, 1e-12)
    }
    assert [taken[True, a] for a in (1e-10, 1e-11, 1e-12)] == [BLANES_CASAS_ESCORIHUELA8, RKN12, RKN12]
    assert [taken[False, a] for a in (1e-10, 1e-11, 1e-12)] == [BLANES_CASAS_ESCORIHUELA8] * 2 + [RKN12]


def test_what_its_order_does_not_hold_for_is_refused():
    turning = fa.hamiltonian("(x**2 + y**2)/2", coordinates="x y", rotation=0.3)
    damped = fa.hamiltonian("x**2/2", coordinates="x", friction=0.1)
    whole = fa.hamiltonian("p**2*(1 + x**2)/2 + x**2/2", coordinates="x", momenta="p")
    for model, said in (
        (turning, r"turns\. Use BLANES_CASAS_ESCORIHUELA8"),
        (damped, "has friction"),
        (whole, r"the system has H\(q, p\)"),
    ):
        z0 = np.full(2 * model.degrees_of_freedom, 0.1)
        with pytest.raises(ValueError, match=said):
            fa.integrate(model, z0, time=1.0, step=0.1, scheme=RKN12)
    with pytest.raises(TypeError, match="Splitting"):
        fa.schemes.TimeTransformed(RKN12)
