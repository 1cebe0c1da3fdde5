"""Orbits against slow twins and SciPy; orders, structure, bitwise promises, outcomes, memory."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import shared_systems
from naive import MODELS, energy, label, march, solve, states, step

from fastaff import (
    DOP853,
    KAHAN_LI8,
    LEAPFROG,
    RK4,
    SOFRONIOU_SPALETTA10,
    VERNER9,
    Body,
    Harmonic,
    HenonHeiles,
    Hyperelastic,
    NeoHookean,
    OrbitError,
    Status,
    energy_grid,
    frequency_map,
    hamiltonian,
    integrate,
    poincare_map,
)
from fastaff.engine import packing
from fastaff.runs import flow
from fastaff.runs.flow import ESCAPE, FARTHEST, Flow, escape_radii
from fastaff.runs.observers import Observer
from fastaff.runs.schemes import Splitting
from fastaff.runs.schemes.catalogue import SCHEMES
from fastaff.systems.models.mechanics import system_of
from fastaff.systems.models.sections import AlphaTurning

every_model = pytest.mark.parametrize("model", MODELS, ids=label)
ADAPTIVE = (DOP853, VERNER9)
FIXED = [
    replace(s, name=f"{s.name} fixed", errors=(), error_orders=()) if s in ADAPTIVE else s for s in SCHEMES.values()
]
every_adaptive = pytest.mark.parametrize("scheme", ADAPTIVE, ids=label)
every_fixed = pytest.mark.parametrize("scheme", FIXED, ids=label)
SPLITTINGS = [s for s in FIXED if isinstance(s, Splitting)]
BODY, BALL = Body(Hyperelastic(1.1), 0.8), HenonHeiles(0.9)
FAST = {"time": 2.0, "step": 0.1}


def assert_same(one, other, orbits=slice(None)):
    """Bit for bit, for every array over orbits (last axis)."""
    for name in ("z", "t", "samples", "energy_error", "status"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name)[..., orbits], err_msg=name)


# --- against the twins -------------------------------------------------------------------------------------------


@every_fixed
@pytest.mark.parametrize("model", [BALL, BODY], ids=label)
def test_fixed_steps_are_those_of_the_twin(model, scheme):
    z0 = states(model, 5)
    path = march(model, scheme, z0, 0.1, 20)
    run = integrate(model, z0, time=2.0, step=0.1, scheme=scheme, samples=4, energy_tolerance=1.0)
    np.testing.assert_allclose(run.z, path[-1], rtol=0, atol=2e-14 * 20)
    np.testing.assert_allclose(run.samples, path[5::5], rtol=0, atol=2e-14 * 20)
    np.testing.assert_allclose(run.times, [0.5, 1.0, 1.5, 2.0], rtol=1e-15)
    np.testing.assert_array_equal(run.samples[-1], run.z)
    assert run.step == 0.1
    assert (run.status == Status.OK).all()


@every_model
def test_every_model_follows_scipy(model):
    z0 = states(model, 2, seed=3)
    run = integrate(model, z0, time=10.0, scheme=SOFRONIOU_SPALETTA10, step=0.02, samples=2)
    for i in range(2):
        np.testing.assert_allclose(run.samples[:, :, i], solve(model, z0[:, i], [5.0, 10.0]), rtol=0, atol=2e-11)


@every_adaptive
@every_model
def test_adaptive_schemes_follow_scipy(model, scheme):
    z0 = states(model, 2, seed=4)
    run = integrate(model, z0, time=10.0, scheme=scheme, rtol=1e-13, atol=1e-13)
    for i in range(2):
        np.testing.assert_allclose(run.z[:, i], solve(model, z0[:, i], 10.0)[0], rtol=0, atol=5e-11)
    assert run.step == np.inf
    np.testing.assert_array_equal(run.t, 10.0)


@every_adaptive
def test_adaptive_schemes_sample_by_their_interpolants(scheme):
    """Interpolants of order 7 and 8: as good as the steps at small tolerances, at times that are no step ends."""
    z0 = states(BODY, 2, seed=4)
    run = integrate(BODY, z0, time=10.0, scheme=scheme, rtol=1e-13, atol=1e-13, samples=37)
    np.testing.assert_allclose(run.times, np.arange(1, 38) * 10 / 37, rtol=1e-15)
    for i in range(2):
        np.testing.assert_allclose(run.samples[:, :, i], solve(BODY, z0[:, i], run.times), rtol=0, atol=1e-10)
    plain = integrate(BODY, z0, time=10.0, scheme=scheme, rtol=1e-13, atol=1e-13)
    np.testing.assert_array_equal(plain.z, run.z)  # sampling does not touch the steps


@every_adaptive
def test_error_is_proportional_to_the_tolerance(scheme):
    """Global error ~ h^order and estimate ~ h^order (9 for VERNER9, 8 for DOP853's blend): error/rtol = const, 1e-6 to
    1e-13.
    """
    z0, tolerances = states(BALL, 6, seed=8), np.logspace(-6, -13, 8)
    truth = integrate(BALL, z0, time=40.0, step=0.02, scheme=SOFRONIOU_SPALETTA10).z
    errors = [np.abs(integrate(BALL, z0, time=40.0, scheme=scheme, rtol=t, atol=t).z - truth).max() for t in tolerances]
    assert np.polyfit(np.log(tolerances), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.12)
    assert (np.array(errors) < 50 * tolerances).all()


def tally(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Count the steps that are accepted."""
    for i in range(lanes):
        memory[i] += fresh[i]
    return 0


@every_adaptive
@pytest.mark.parametrize("tolerance", [1e-7, 1e-10])
def test_few_steps_are_taken_twice(scheme, tolerance):
    """The next step is short enough to be accepted nearly always: of steps as long as they may be a fifth is not."""
    flow = Flow(system_of(BODY), scheme, np.inf, tolerance, tolerance, 1)
    ensemble, taken, _ = flow.observed(states(BODY, 40, seed=11), Observer(tally, 1), time=20.0)
    assert (ensemble.status == Status.OK).all()
    assert 0 <= 1 - taken.sum() / ensemble.count.sum() < 0.14


def test_the_step_is_the_longest_allowed():
    """The step used divides the time between samples: 3 steps of 1/3 for a step of 0.4, not 2 of 0.5."""
    z0 = states(BALL, 3)
    run = integrate(BALL, z0, time=2.0, step=0.4, samples=2)
    np.testing.assert_array_equal(run.z, integrate(BALL, z0, time=2.0, step=1 / 3, samples=2).z)
    np.testing.assert_allclose(run.samples, march(BALL, KAHAN_LI8, z0, 1 / 3, 6)[3::3], rtol=0, atol=1e-13)


@every_model
def test_a_missing_step_is_chosen_for_the_energy(model):
    """States as accurate as asked keep the energy."""
    run = integrate(model, states(model, 60), time=30.0)
    assert run.step.shape == (60,)
    assert (run.step > 0).all()
    assert (run.step < 1).all()
    assert np.median(run.energy_error) < 1e-10
    run.raise_if_failed()


# --- structure ---------------------------------------------------------------------------------------------------


def test_energy_error_of_a_splitting_does_not_grow():
    z0 = states(BODY, 10, seed=11, spread=0.2)

    def growth(scheme, step):
        errors = []
        for time in (50.0, 800.0):
            run = integrate(BODY, z0, time=time, step=step, scheme=scheme, samples=200, energy_tolerance=1.0)
            errors.append(run.energy_error)
        return np.median(errors[1] / errors[0]), np.median(errors[1])

    ratio, size = growth(LEAPFROG, 0.1)
    assert size > 1e-5
    assert ratio < 1.5
    ratio, _ = growth(RK4, 0.1)
    assert ratio > 5


def test_angular_momenta_are_kept_to_rounding():
    """Splittings keep quadratic invariants: exactly but for rounding, which grows at most like steps * eps."""
    z0 = states(BODY, 20)
    z = integrate(BODY, z0, time=100.0, step=0.05).z
    for i, j in ((0, 1), (2, 3)):
        before = z0[i] * z0[4 + j] - z0[j] * z0[4 + i]
        np.testing.assert_allclose(z[i] * z[4 + j] - z[j] * z[4 + i], before, rtol=0, atol=1e-12)


def test_energy_error_is_what_it_says():
    """|E - E0| over the largest kinetic energy at the steps where orbits are looked at, the largest over samples and
    end.
    """
    z0 = states(BODY, 6)
    run = integrate(BODY, z0, time=5.0, step=0.1, scheme=LEAPFROG, samples=10, energy_tolerance=1.0)
    steps = integrate(BODY, z0, time=5.0, step=0.1, scheme=LEAPFROG, samples=50, energy_tolerance=1.0).samples
    looks = [z0, *steps[np.array([1, 2, 4, 8, 16, 32, 50]) - 1]]
    scale = np.max([BODY.kinetic_energy(*z[4:]) for z in looks], axis=0)
    drift = np.abs(np.array([energy(BODY, z) for z in run.samples]) - energy(BODY, z0)) / scale
    np.testing.assert_allclose(run.energy_error, drift.max(axis=0), rtol=1e-9)
    end = integrate(BODY, z0, time=5.0, step=0.1, scheme=LEAPFROG, energy_tolerance=1.0)
    np.testing.assert_allclose(end.energy_error, drift[-1], rtol=1e-9)


# --- bitwise promises --------------------------------------------------------------------------------------------


def test_results_do_not_depend_on_the_state_before():
    """The same call twice; z0 is left alone."""
    z0 = states(BODY, 10)
    before = z0.copy()
    assert_same(integrate(BODY, z0, **FAST), integrate(BODY, z0, **FAST))
    np.testing.assert_array_equal(z0, before)
    z0.flags.writeable = False
    integrate(BODY, z0, **FAST)


def test_layout_and_type_of_the_input_do_not_matter():
    z0 = states(BODY, 10).astype(np.float32).astype(np.float64)
    plain = integrate(BODY, z0, **FAST)
    assert_same(integrate(BODY, np.asfortranarray(z0), **FAST), plain)
    assert_same(integrate(BODY, z0.astype(np.float32), **FAST), plain)
    assert_same(integrate(BODY, z0.tolist(), **FAST), plain)
    single = integrate(BODY, z0[:, 0], **FAST)
    assert single.z.shape == (8, 1)
    assert single.samples.shape == (0, 8, 1)


# --- outcomes ----------------------------------------------------------------------------------------------------


def test_harmonic_motion_crosses_zero_area_by_its_closed_form():
    body = Body(Harmonic(1.3), 0.7)
    z0, omega = states(body, 50, spread=1.0), np.sqrt(1.3 / 0.7)
    run = integrate(body, z0, time=7.0, step=0.05, samples=140)
    t = run.times[:, None, None]
    q = z0[:4] * np.cos(omega * t) + z0[4:] / (0.7 * omega) * np.sin(omega * t)
    np.testing.assert_allclose(run.samples[:, :4], q, rtol=0, atol=1e-11)
    det = (run.samples[:, 0] ** 2 + run.samples[:, 1] ** 2 - run.samples[:, 2] ** 2 - run.samples[:, 3] ** 2) / 2
    assert (det.min(axis=0) < 0).mean() > 0.5
    assert (run.status == Status.OK).all()


def test_a_step_too_long_for_the_wall_is_a_collapse():
    z0 = np.array([1.5, 0.0, 1.45, 0.0, -3.0, 0.0, 3.0, 0.0])
    run = integrate(Body(Hyperelastic()), z0, time=0.4, step=0.1, scheme=LEAPFROG)
    assert run.status[0] == Status.OUT_OF_DOMAIN
    assert run.energy_error[0] > 1e-6
    with pytest.raises(OrbitError, match=r"1 OUT_OF_DOMAIN \(left the domain"):
        run.raise_if_failed()
    assert "1 OUT_OF_DOMAIN" in run.summary()
    adaptive = integrate(Body(Hyperelastic()), z0, time=0.4, scheme=DOP853)
    adaptive.raise_if_failed()


@pytest.mark.parametrize(
    "text",
    [
        "w*(x**2 + 16*y**2)/2 + x**2*y + 16/3*y**3",
        "(x**2 + y**2)/2 - w*x**4/4",
        "w*(x**2 + y**2) - x**2*y**6",
        "w/x - x**8 + y**2",
    ],
)
def test_orbits_that_are_gone_in_finite_time_leave_others_alone(text):
    """Potentials without a bottom, whose orbits reach infinity at once: a status, and the neighbours' bits."""
    rng = np.random.default_rng(9)
    model = hamiltonian(text, w=rng.uniform(0.5, 2.0))
    z = 2.0 * rng.normal(size=(4, 24))
    calm = 1e-3 * z[:, :4] + [[1.0 if "/x" in text else 0.0], [0.0], [0.0], [0.0]]
    z = np.concatenate([z, calm], axis=1)
    for call in (
        lambda z: integrate(model, z, time=20.0),
        lambda z: integrate(model, z, time=20.0, accuracy=1e-6),
        lambda z: frequency_map(model, z, time=50.0),
        lambda z: poincare_map(model, z, section="y=0", crossings=2, max_time=20.0),
    ):
        found, alone = call(z), call(z[:, -4:])
        assert (found.status != Status.OK).sum() >= 8
        assert np.array_equal(found.status[-4:], alone.status)
        assert np.array_equal(found.energy_error[-4:], alone.energy_error, equal_nan=True)


@pytest.mark.parametrize(
    "options",
    [{"step": 0.1}, {"step": 0.1, "scheme": RK4}, {"step": 0.2, "scheme": SOFRONIOU_SPALETTA10}, {"scheme": DOP853}],
    ids=["splitting", "runge-kutta", "order ten", "adaptive"],
)
@pytest.mark.parametrize("scale", [1.0, 3e-7, 2e8])
def test_orbits_that_leave_the_domain_and_return_have_left_it(options, scale):
    """x = A cos(t + phase) in a smooth potential with the domain |x| < scale: who goes beyond has collapsed, when it
    does, at any size.
    """
    model = hamiltonian("x**2/2 + 1.7*y**2/2", domain="w**2 - x**2", w=scale)
    rng = np.random.default_rng(4)
    A, phase = (
        scale * np.concatenate([rng.uniform(0.3, 0.999, 30), rng.uniform(1.05, 1.6, 40)]),
        rng.uniform(0, 2 * np.pi, 70),
    )
    z0 = np.array([A * np.cos(phase), 0.1 * A, -A * np.sin(phase), 0.2 * A])
    z0, A, phase = (entry[..., np.abs(z0[0]) < 0.98 * scale] for entry in (z0, A, phase))
    run = integrate(model, z0, time=7.0, energy_tolerance=1e-3, **options)
    leaves = scale < A
    np.testing.assert_array_equal(run.status, np.where(leaves, Status.OUT_OF_DOMAIN, Status.OK))
    t = np.linspace(0, 7.0, 70_001)
    first = t[(np.abs(A * np.cos(t[:, None] + phase)) >= scale).argmax(axis=0)]
    assert (np.abs(run.t - first)[leaves] < options.get("step", 1e-3) + 1e-3).all()
    for i in (0, len(A) - 1):
        alone = integrate(model, z0[:, i], time=7.0, energy_tolerance=1e-3, **options)
        assert_same(alone, run, slice(i, i + 1))
    if "scheme" not in options:
        map_ = frequency_map(model, z0, time=200.0, step=0.1)
        np.testing.assert_array_equal(map_.status == Status.OUT_OF_DOMAIN, leaves)


@pytest.mark.parametrize("unit", [1e-6, 1e-3, 1.0, 40.0, 1e6])
def test_escape_is_the_same_in_any_unit_of_length(unit):
    """Bound orbits of any size stay OK, also from next to a saddle; unbound ones escape at the same time in every
    unit.
    """
    well = shared_systems.plane(-1, 2, e=1.0 / unit**2)
    z0 = unit * np.array([[1e-9, 0.3, 1.5, 0.0], [0.0, 0.2, 0.1, 0.5], [1e-9, 0.1, 0.0, 1e-9], [0.0, 0.1, -0.4, 0.0]])
    run = integrate(well, z0, time=60.0, step=0.02)
    assert (run.status == Status.OK).all()
    saddle = shared_systems.plane(-1, 1)
    z0 = unit * np.array([[1.0, 0.2], [0.3, 0.1], [1.0, 0.2], [0.1, 0.3]])
    run = integrate(saddle, z0, time=60.0, step=0.02, energy_tolerance=1e9)
    assert (run.status == Status.ESCAPED).all()
    assert (np.abs(run.t - 15.0) < 3.0).all()
    valley = HenonHeiles(1 / unit)
    z0 = unit * np.array([[0.1, 0.0], [1.2, 0.1], [0.1, 0.3], [0.3, 0.1]])
    run = integrate(valley, z0, time=60.0, step=0.02)
    assert run.status[0] in (Status.ESCAPED, Status.NONFINITE)
    assert run.status[1] == Status.OK


def test_an_orbit_that_rests_on_a_slope_at_the_origin_falls():
    """It has neither a size nor a turning point ahead."""
    z0 = np.zeros((4, 1))
    slope = hamiltonian("-k*x + y**2/2", k=1.0)
    assert escape_radii(system_of(slope), z0) == FARTHEST
    run = integrate(slope, z0, time=2.0, step=0.1)
    assert run.status == Status.OK
    np.testing.assert_allclose(run.z[:, 0], [2.0, 0.0, 2.0, 0.0], atol=1e-14)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("omega", [0.0, 0.4])
def test_escape_radii_are_those_of_turning_points(omega, compiled, monkeypatch):
    """An oscillator turns where V is the energy, in a turning frame V less the centrifugal part Jacobi's: on a straight
    line a root of a quadratic equation, with the two digits of the table of distances; starts at rest go by the force.
    Also where NumPy evaluates a potential that does not compile.
    """
    rng = np.random.default_rng(5)
    z0 = rng.normal(size=(4, 300)) * 10.0 ** rng.uniform(-3, 3, 300)
    z0[2:, ::5] = 0.0 if omega == 0.0 else z0[2:, ::5]
    system = hamiltonian("(x**2 + y**2)/2", **({"rotation": omega} if omega else {}))
    q, p = z0[:2], z0[2:]
    v = p + omega * np.array([q[1], -q[0]])
    way = np.where((v == 0).all(axis=0), -q, v)
    way = way / np.hypot(*way) * np.hypot(*q)
    square = (q**2).sum(axis=0) + (v**2).sum(axis=0) / (1 - omega**2)  # of the distance where it turns
    a, b = (way**2).sum(axis=0), (q * way).sum(axis=0)
    root = np.sqrt(b**2 - a * ((q**2).sum(axis=0) - square))
    turn = np.maximum(np.abs(-b + root), np.abs(-b - root)) / a * np.hypot(*q)
    expected = np.maximum(np.hypot(*q), turn)
    if not compiled:
        monkeypatch.setattr(flow, "_potential", lambda model: None)
    found = escape_radii(system_of(system), z0) / ESCAPE
    assert (found <= expected * (1 + 1e-9)).all()
    assert (found >= 0.99 * expected).all()


@pytest.mark.parametrize("options", [{"step": 0.05, "samples": 4}, {"accuracy": 1e-8}], ids=["step", "accuracy"])
def test_short_runs_have_the_bits_of_long_ones(monkeypatch, options):
    """In the caller's thread and in the kernels' own; progress is reported from both."""
    seen = []
    short = integrate(BALL, states(BALL, 5), time=3.0, callback=seen.append, **options)
    assert seen[-1] == 1.0
    monkeypatch.setattr(packing, "BRIEF", 0)
    assert_same(integrate(BALL, states(BALL, 5), time=3.0, **options), short)


def test_unbound_henon_heiles():
    """Blows up in a finite time: ESCAPED where the check sees it before the numbers end, else NONFINITE."""
    z0 = np.array([[0.0, 0.0], [1.2, 0.1], [0.0, 0.1], [0.3, 0.1]])
    fixed = integrate(HenonHeiles(), z0, time=100.0, step=0.01)
    assert fixed.status[0] in (Status.ESCAPED, Status.NONFINITE)
    adaptive = integrate(HenonHeiles(), z0, time=100.0, scheme=DOP853)
    assert adaptive.status[0] in (Status.ESCAPED, Status.STEP_TOO_SMALL)
    for run in (fixed, adaptive):
        assert run.status[1] == Status.OK
        assert run.t[0] < 10 < run.t[1] == 100.0


def test_numbers_that_overflow():
    z0 = states(BODY, 3)
    z0[4, 1] = 1e200
    run = integrate(BODY, z0, **FAST)
    assert run.status[1] in (Status.NONFINITE, Status.ESCAPED)
    np.testing.assert_array_equal(run.status[[0, 2]], Status.OK)
    assert run.energy_error[1] > 1
    assert np.isfinite(run.energy_error[[0, 2]]).all()


def test_energy_drift():
    z0 = states(BODY, 20)
    run = integrate(BODY, z0, time=5.0, step=0.1, scheme=LEAPFROG)
    drifted = run.energy_error > 1e-6
    assert drifted.any()
    np.testing.assert_array_equal(run.status, np.where(drifted, Status.ENERGY_DRIFT, Status.OK))
    strict = integrate(BODY, z0, time=5.0, step=0.1, scheme=LEAPFROG, energy_tolerance=1e-9)
    assert (strict.status == Status.ENERGY_DRIFT).all()
    np.testing.assert_array_equal(strict.z, run.z)


@pytest.mark.parametrize("samples", [0, 40])
def test_neo_hookean_at_high_energy_with_too_long_a_step_is_reported(samples):
    """E = 8 and step 0.04: fixed steps miss the wall. What is called OK must be right, by energy and by the other
    scheme.
    """
    body = Body(NeoHookean(1.0, 2.0))
    axes = np.linspace(0.05, 3, 12), np.linspace(-3, 3, 13)
    z0 = energy_grid(body, energy=8.0, section=AlphaTurning(-1), axes=axes, p_eta=0.3, p_gamma=0.2).z0
    run = integrate(body, z0, time=20.0, step=0.04, samples=samples)
    assert (run.status != Status.OK).mean() > 0.9
    assert Status.OUT_OF_DOMAIN in set(run.status)
    run = integrate(body, z0, time=2.0, step=0.04, samples=samples)
    assert 3 <= (run.status == Status.OK).sum() <= run.status.size - 3
    fine = run.status == Status.OK
    np.testing.assert_allclose(energy(body, run.z[:, fine]), 8.0, atol=1e-6 * 50)
    assert (body.margin(*run.z[:4, fine]) > 0).all()
    adaptive = integrate(body, z0, time=2.0, scheme=DOP853, rtol=1e-13, atol=1e-13)
    adaptive.raise_if_failed()
    assert np.abs(run.z - adaptive.z)[:, fine].max() < 1e-4


def test_failed_orbits_keep_their_samples_until_then():
    z0 = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    run = integrate(Body(Harmonic(C=-1.0)), z0, time=40.0, step=0.05, samples=40, energy_tolerance=1e12)
    seen = np.isfinite(run.samples[:, 0, 0])
    assert run.status[0] == Status.ESCAPED
    assert 13 <= seen.sum() <= 21
    assert not seen[np.argmin(seen) :].any()
    np.testing.assert_allclose(run.samples[seen][:, 0, 0], np.exp(run.times[seen]), rtol=1e-9)


# --- resources ---------------------------------------------------------------------------------------------------


def test_memory_does_not_grow_with_the_steps():
    z0 = states(BALL, 8)

    def peak(time):
        tracemalloc.start()
        integrate(BALL, z0, time=time, step=0.05, samples=2, scheme=LEAPFROG, energy_tolerance=1.0, threads=1)
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return size

    peak(1.0), peak(5000.0)  # which are run in ways of their own
    assert peak(5000.0) < 1.2 * peak(1.0) + 100_000  # one number a step would be 800 kB


def test_one_step_is_the_twins_step_exactly():
    """The same operations in the same order: equal to the last bits (a fused multiply-add would show here)."""
    z0 = states(BALL, 9)
    run = integrate(BALL, z0, time=0.125, step=0.125, scheme=KAHAN_LI8)
    np.testing.assert_allclose(run.z, step(BALL, KAHAN_LI8, z0, 0.125), rtol=0, atol=3e-16)


@pytest.mark.parametrize("amplitude", [1e-3, 1e-5, 1e-7])
def test_steps_chosen_next_to_an_equilibrium_resolve_its_oscillations(amplitude):
    """The energy error says nothing there, E being quadratic: the frequency comes from the change of the force."""
    body = Body(Hyperelastic())
    z0 = np.array([np.sqrt(2), 0, 0, 0, 0, 0, 0, 0]) + amplitude * np.array([1.0, 0.0, 0.3, 0.0, 0.0, 0.2, 0.0, 0.5])
    found, truth = integrate(body, z0, time=100.0), integrate(body, z0, time=100.0, step=0.02)
    assert found.step < 0.5
    assert np.abs(found.z - truth.z).max() < 1e-5 * amplitude + 1e-12


@pytest.mark.parametrize(
    ("scheme", "more"),
    [
        ("BLANES_CASAS_ESCORIHUELA8", {}),
        ("BLANES_CASAS_ESCORIHUELA8", {"rotation": 0.3}),
        ("KAHAN_LI8", {"friction": 0.01}),
        ("RKN12", {}),
        ("RK4", {}),
        ("GAUSS8", {"momenta": "u v"}),
    ],
    ids=str,
)
def test_lanes_that_fill_up_a_vector_touch_nothing(scheme, more):
    """Any number of orbits beyond whole vectors, some of which leave on their way, have the same bits."""
    text = "(x**2 + y**2)/2 + x**2*y - y**3/3" + (" + (u**2 + v**2)*(1 + x**2)/2" if "momenta" in more else "")
    model = hamiltonian(text, coordinates="x y", **more) if more else shared_systems.plane(1, 1, c=1, d=1)
    z0 = np.random.default_rng(8).normal(size=(4, 31)) * 0.35
    run = {"time": 12.0, "step": 0.1 + 0.01 * np.arange(31), "scheme": scheme, "threads": 1, "energy_tolerance": 0.5}
    whole = integrate(model, z0, **run)
    assert 0 < (whole.status != Status.OK).sum() < 31
    for orbits in (*range(1, 18), 30):
        some = integrate(model, z0[:, :orbits], **{**run, "step": run["step"][:orbits]})
        for name in ("z", "t", "energy_error", "status"):
            np.testing.assert_array_equal(getattr(some, name), getattr(whole, name)[..., :orbits], err_msg=name)
