"""Section crossings against slow twins; every section, pairs inside a step, orders, outcomes, bitwise promises,
Ctrl-C.
"""

import subprocess
import sys

import numpy as np
import pytest
import shared_systems
from naive import energy, label, march, scheme_crossings, solve, solved_crossings, states
from scipy import optimize

from fastaff import (
    DOP853,
    KAHAN_LI8,
    LEAPFROG,
    RK4,
    SOFRONIOU_SPALETTA10,
    AlphaEquals,
    AlphaTurning,
    AreaEquals,
    BetaEquals,
    BetaTurning,
    Body,
    Harmonic,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    OrbitError,
    Status,
    energy_grid,
    integrate,
    poincare_map,
)
from fastaff.core.interruption import Interrupted
from fastaff.runs import flow as engine
from fastaff.systems.charts import ALPHA_BETA, R_VARTHETA, TWO_POLAR

BODY, BALL = Body(Hyperelastic(1.1), 0.8), HenonHeiles(0.9)
ON_X = Hyperplane((1.0, 0.0, 0.0, 0.0))
SECTIONS = [
    AlphaTurning(1),
    AlphaTurning(-1),
    BetaTurning(1),
    BetaTurning(0),
    AlphaEquals(1.45, 1),
    AlphaEquals(1.5, 0),
    BetaEquals(0.3, -1),
    AreaEquals(1.05, 1),
    AreaEquals(0.95, -1),
    Hyperplane((0.0, 0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.1), 0.05, 1),
    Hyperplane((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0), 0.0, -1),
]
every_section = pytest.mark.parametrize("section", SECTIONS, ids=[str(s) for s in SECTIONS])


def found(cut, i=0):
    return cut.times[: cut.counts[i], i]


# --- against the twins -------------------------------------------------------------------------------------------


@every_section
def test_crossings_are_those_of_scipy(section):
    """Times agree to the error of a tenth-order scheme with step 0.02 and SciPy's dense output."""
    z0 = states(BODY, 3, seed=2)
    cut = poincare_map(BODY, z0, section=section, crossings=60, max_time=12.0, step=0.02, scheme=SOFRONIOU_SPALETTA10)
    assert cut.counts.sum() >= 3
    for i in range(3):
        truth = solved_crossings(BODY, z0[:, i], section, 12.0)
        np.testing.assert_allclose(found(cut, i), truth, rtol=0, atol=2e-9)
        if truth.size:
            points = solve(BODY, z0[:, i], [truth[-1], 12.0])[0]
            np.testing.assert_allclose(cut.points[:, cut.counts[i] - 1, i], points, rtol=0, atol=1e-8)


@pytest.mark.parametrize("scheme", [LEAPFROG, KAHAN_LI8, SOFRONIOU_SPALETTA10, RK4], ids=label)
@pytest.mark.parametrize("section", [AlphaTurning(1), BetaEquals(0.3, 0)], ids=str)
def test_crossings_are_roots_on_fractional_steps_of_the_scheme(scheme, section):
    z0 = states(BODY, 3, seed=3)
    cut = poincare_map(
        BODY, z0, section=section, crossings=50, max_time=8.0, step=0.1, scheme=scheme, energy_tolerance=1.0
    )
    for i in range(3):
        times, points = scheme_crossings(BODY, scheme, z0[:, i], section, 0.1, 8.0)
        np.testing.assert_allclose(found(cut, i), times, rtol=0, atol=2e-12)
        np.testing.assert_allclose(cut.points[:, : len(times), i].T, points, rtol=0, atol=2e-12)


# --- accuracy ----------------------------------------------------------------------------------------------------


@every_section
def test_crossings_lie_on_section_and_energy_surface(section):
    z0 = states(BODY, 100, seed=4)
    cut = poincare_map(BODY, z0, section=section, crossings=20, max_time=100.0, step=0.02, scheme=SOFRONIOU_SPALETTA10)
    kept = np.isfinite(cut.times)
    assert kept.sum() > 300
    z = cut.points[:, kept]
    values = np.zeros(kept.shape)
    values[kept] = np.abs(section(z))
    assert values.max() <= 1e-12
    np.testing.assert_allclose(values.max(axis=0), cut.section_error, rtol=0, atol=1e-15)
    drift = np.zeros(kept.shape)
    start = energy(BODY, z0), BODY.kinetic_energy(*z0[4:]) + np.abs(BODY.potential_energy(*z0[:4]))
    E0, scale = (np.broadcast_to(values, kept.shape)[kept] for values in start)
    drift[kept] = np.abs(energy(BODY, z) - E0) / scale
    assert (drift.max(axis=0) <= cut.energy_error + 1e-14).all()  # rounding of E itself does not count
    assert np.quantile(cut.energy_error, 0.9) < 1e-11


@every_section
def test_crossings_go_the_right_way(section):
    """The derivative of the section function along the flow, by a complex step in the state."""
    cut = poincare_map(BODY, states(BODY, 20, seed=5), section=section, crossings=10, max_time=50.0, step=0.05)
    z = cut.points[:, np.isfinite(cut.times)]
    flow = np.array([*BODY.velocity(*z[4:]), *BODY.force(*z[:4])])
    rate = section.value(*(z + 1e-30j * flow)).imag / 1e-30
    if section.direction:
        assert (rate * section.direction > 0).all()
    else:
        assert 0.3 < (rate > 0).mean() < 0.7


@pytest.mark.parametrize(
    ("scheme", "steps"), [(LEAPFROG, (40, 80, 160)), (KAHAN_LI8, (14, 20, 28)), (RK4, (40, 80, 160))], ids=label
)
def test_crossing_times_converge_with_the_order_of_the_scheme(scheme, steps):
    """Fractional steps add no error of their own (linear interpolation would show order 2)."""
    z0, section = states(BODY, 5, seed=7, spread=0.1), Hyperplane((0, 0, 1, 0, 0, 0, 0, 0), 0.01, 1)

    def times(scheme, step):
        cut = poincare_map(
            BODY, z0, section=section, crossings=2, max_time=60.0, step=step, scheme=scheme, energy_tolerance=1.0
        )
        assert (cut.counts == 2).all()
        return cut.times

    truth = times(SOFRONIOU_SPALETTA10, 0.02)
    errors = [np.abs(times(scheme, 4.0 / n) - truth).max() for n in steps]
    slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert errors[-1] > 1e-12
    assert slope == pytest.approx(scheme.order, abs=0.25)


@every_section
def test_adaptive_sections(section):
    """DOP853 at 1e-13 against fixed steps: the same crossings."""
    z0 = states(BODY, 20, seed=6)
    options = {"section": section, "crossings": 8, "max_time": 20.0}
    fixed = poincare_map(BODY, z0, step=0.02, scheme=SOFRONIOU_SPALETTA10, **options)
    adaptive = poincare_map(BODY, z0, scheme=DOP853, rtol=1e-13, atol=1e-13, **options)
    np.testing.assert_array_equal(adaptive.counts, fixed.counts)
    np.testing.assert_allclose(adaptive.times, fixed.times, rtol=0, atol=1e-7)
    assert np.nanmedian(np.abs(adaptive.times - fixed.times)) < 1e-11
    assert adaptive.section_error.max() < 1e-12
    assert adaptive.step == np.inf


# --- what is counted ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1, 0])
@pytest.mark.parametrize("options", [{"step": 0.05}, {"scheme": DOP853}], ids=["fixed", "adaptive"])
def test_a_start_on_the_section_is_not_counted(direction, options):
    axes = np.linspace(0.1, 0.5, 5), np.linspace(-0.4, 0.4, 5)
    z0 = energy_grid(BODY, energy=2.6, section=AlphaTurning(-1), axes=axes, p_eta=0.3, p_gamma=0.1).z0
    cut = poincare_map(BODY, z0, section=AlphaTurning(direction), crossings=3, max_time=50.0, **options)
    assert (cut.counts == 3).all()
    half = np.pi / np.sqrt(1.1 / 0.8) / 2  # half a dilatation, roughly: alpha turns at each
    first = {-1: 2 * half, 1: half, 0: half}[direction]
    np.testing.assert_allclose(np.median(cut.times[0]), first, rtol=0.25)
    assert cut.times[0].min() > 0.5 * first


def test_both_directions_are_the_union():
    z0 = states(BODY, 10, seed=8)
    options = {"crossings": 30, "max_time": 15.0, "step": 0.05}
    up, down, both = (poincare_map(BODY, z0, section=BetaTurning(d), **options) for d in (1, -1, 0))
    for i in range(10):
        union = np.sort(np.concatenate([found(up, i), found(down, i)]))
        np.testing.assert_allclose(found(both, i), union, rtol=0, atol=1e-13)
        assert abs(int(up.counts[i]) - int(down.counts[i])) <= 1


@pytest.mark.parametrize("kind", [AlphaEquals, BetaEquals])
@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("depth", [1e-3, 1e-5])
def test_two_crossings_inside_a_step_are_found(kind, side, depth):
    """A section just inside an extremum of the radius: crossed twice in a moment, shorter than the step."""
    z0 = states(BODY, 1, seed=12)[:, 0]
    path = march(BODY, SOFRONIOU_SPALETTA10, z0, 0.002, 6000)
    radius = np.hypot(path[:, 0], path[:, 1]) if kind is AlphaEquals else np.hypot(path[:, 2], path[:, 3])
    inner = side * radius[1:-1]
    extremum = side * inner[(inner > side * radius[:-2]) & (inner > side * radius[2:])]
    extremum = extremum[np.argsort(side * extremum)][len(extremum) // 2]  # one of the middle: others cross deeply
    section = kind(float(extremum - side * depth), 0)
    cuts = [
        poincare_map(BODY, z0, section=section, crossings=100, max_time=12.0, step=h, scheme=SOFRONIOU_SPALETTA10)
        for h in (0.3, 0.1, 0.05, 0.02, 0.002)
    ]
    gap = np.diff(found(cuts[-1])).min()
    assert gap < 0.3 * (1 if depth == 1e-3 else 0.1) * 2
    for cut in cuts:
        assert cut.counts[0] == cuts[-1].counts[0] >= 2
        np.testing.assert_allclose(found(cut), found(cuts[-1]), rtol=0, atol=1e-5)
        assert cut.section_error[0] < 1e-12
    one_way = [kind(section.constant, d) for d in (1, -1)]
    for section in one_way:
        coarse, fine = (
            poincare_map(BODY, z0, section=section, crossings=100, max_time=12.0, step=h, scheme=SOFRONIOU_SPALETTA10)
            for h in (0.3, 0.002)
        )
        np.testing.assert_allclose(found(coarse), found(fine), rtol=0, atol=1e-5)


def test_a_wanted_pair_is_cut_at_the_wanted_number():
    """Every number of crossings gives the first of them, whether or not a pair straddles the end."""
    z0 = states(BODY, 1, seed=12)[:, 0]
    section = BetaEquals(0.3, 0)
    whole = poincare_map(BODY, z0, section=section, crossings=20, max_time=60.0, step=0.3, energy_tolerance=1.0)
    assert whole.counts[0] == 20
    for wanted in range(1, 20):
        part = poincare_map(BODY, z0, section=section, crossings=wanted, max_time=60.0, step=0.3, energy_tolerance=1.0)
        np.testing.assert_array_equal(part.times[:, 0], whole.times[:wanted, 0])
        np.testing.assert_array_equal(part.points[:, :, 0], whole.points[:, :wanted, 0])
        assert part.status[0] == Status.OK


def test_times_increase_and_end_in_nan():
    z0 = states(BODY, 60, seed=9)
    cut = poincare_map(BODY, z0, section=BetaEquals(0.35, 0), crossings=12, max_time=8.0, step=0.1)
    assert cut.points.shape == (8, 12, 60)
    assert len(set(cut.counts)) > 2
    for i in range(60):
        n = cut.counts[i]
        assert (np.diff(cut.times[:n, i]) > 0).all()
        assert (cut.times[:n, i] <= 8.0 * (1 + 2e-15)).all()
        assert np.isnan(cut.times[n:, i]).all()
        assert np.isnan(cut.points[:, n:, i]).all()
        assert np.isfinite(cut.points[:, :n, i]).all()
        assert (cut.status[i] == Status.OK) == (n == 12)


def test_many_crossings_beyond_the_spare_records():
    """Hundreds of crossings of one orbit, the same as in pieces by the twin's count."""
    cut = poincare_map(BALL, states(BALL, 2), section=ON_X, crossings=400, max_time=1e4, step=0.2)
    assert (cut.counts == 400).all()
    np.testing.assert_allclose(np.diff(cut.times, axis=0), 2 * np.pi, rtol=0.25)
    assert cut.energy_error.max() < 1e-6


# --- the ends ----------------------------------------------------------------------------------------------------


def harmonic_crossings(S, time, direction):
    """Zeros in (0, time) of a function by a fine scan with its extrema; and how near to zero an extremum or an end
    comes.
    """
    t = np.linspace(0, time, 801)
    v = S(t)
    turns = np.flatnonzero((v[1:-1] - v[:-2]) * (v[2:] - v[1:-1]) <= 0) + 1
    extrema = [
        optimize.minimize_scalar(
            lambda x, s=s: s * S(x), bounds=(t[k - 1], t[k + 1]), method="bounded", options={"xatol": 1e-11 * time}
        ).x
        for k in turns
        for s in [1.0 if v[k] <= v[k - 1] else -1.0]
    ]
    t = np.sort(np.concatenate([t, extrema]))
    v = S(t)
    found = [
        optimize.brentq(S, t[k], t[k + 1], xtol=1e-16 * time, rtol=1e-14)
        for k in np.flatnonzero(v[1:] * v[:-1] < 0)
        if direction * (v[k + 1] - v[k]) >= 0
    ]
    return np.array(found), np.abs(S(np.array([0.0, time, *extrema]))).min()


@pytest.mark.parametrize("seed", range(8))
def test_nothing_is_lost_at_the_ends_of_short_runs(seed):
    """Two oscillators, known for all times: runs of half a step to six steps, any units, slanting sections, pairs at
    both ends.
    """
    rng = np.random.default_rng(seed)
    L, U = 10 ** rng.uniform(-6, 6, 2)
    w, c, offset, direction = (
        rng.uniform(0.5, 2, 2) / U,
        rng.uniform(-0.3, 0.3),
        L * rng.choice([-1, 1]),
        int(rng.integers(-1, 2)),
    )
    step = U * (0.05, 0.2, 0.4, 0.6)[seed % 4]
    time = step * rng.uniform(0.7, 6)
    model = shared_systems.oscillators(*w**2)
    A, phase = L * rng.uniform(0.8, 1.4, (2, 150)), rng.uniform(0, 2 * np.pi, (2, 150))
    phase[0, :100] = rng.uniform(-1.2, 0.3, 100) + (
        0.0 if offset > 0 else np.pi
    )  # through the extremum that the section is near
    z0 = np.concatenate([A * np.cos(phase), -A * w[:, None] * np.sin(phase)])
    section = Hyperplane((1.0, c, 0.0, 0.0), offset, direction)
    cuts = [
        poincare_map(model, z0, section=section, crossings=9, max_time=time, energy_tolerance=1.0, **options)
        for options in (
            {"step": step, "scheme": SOFRONIOU_SPALETTA10},
            {"scheme": DOP853, "rtol": 1e-13, "atol": 1e-13 * min(L, L / U)},
        )
    ]
    tried = crossed = 0
    for i in range(150):
        truth, near = harmonic_crossings(
            lambda t, i=i: (
                A[0, i] * np.cos(w[0] * t + phase[0, i]) + c * A[1, i] * np.cos(w[1] * t + phase[1, i]) - offset
            ),
            time,
            direction,
        )
        if near < 1e-5 * L:
            continue
        tried, crossed = tried + 1, crossed + truth.size
        for cut in cuts:
            assert cut.counts[i] == truth.size
            np.testing.assert_allclose(found(cut, i), truth, rtol=0, atol=1e-6 * U)
    assert tried > 100
    assert crossed > 0


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e7])
@pytest.mark.parametrize(
    "options", [{"step": 0.3}, {"step": 0.3, "scheme": SOFRONIOU_SPALETTA10}, {"scheme": DOP853}], ids=str
)
def test_an_orbit_that_starts_on_its_section_and_returns_within_a_step(scale, options):
    """x = A sin(t + phase) from x = A cos(d) upwards comes back down after 2 d; from a little below it also crosses at
    once.
    """
    model, d = shared_systems.oscillators(), np.array([0.0447, 0.01, 0.1, 1e-3])
    A = scale * np.array([1.0, 0.7, 1.9, 1.3])
    x, v = A * np.cos(d), A * np.sin(d)
    z0 = np.array([x, 0 * x, v, 0.1 * A])
    options = options | ({"atol": 1e-12 * scale} if options.get("scheme") is DOP853 else {})
    for i in range(4):
        for direction, expected in ((0, [2 * d[i]]), (-1, [2 * d[i]]), (1, [])):
            cut = poincare_map(
                model, z0[:, i], section=Hyperplane((1, 0, 0, 0), x[i], direction), crossings=3, max_time=2.0, **options
            )
            np.testing.assert_allclose(found(cut), expected, rtol=0, atol=1e-7)
        below = z0[:, i].copy()
        below[0] -= 1e-7 * scale
        expected = np.arctan2(v[i], below[0]) - np.arccos(x[i] / np.hypot(below[0], v[i]))
        cut = poincare_map(
            model, below, section=Hyperplane((1, 0, 0, 0), x[i], 1), crossings=3, max_time=2.0, **options
        )
        assert cut.counts[0] == 1
        assert cut.times[0, 0] == pytest.approx(expected, rel=1e-2, abs=1e-8)


def test_small_coordinates_are_not_on_the_section():
    """First crossings of orbits of any size, and of starts that are near the section by any standard but their own."""
    model = shared_systems.oscillators()
    for size in (1e-12, 1e-7, 1.0, 1e5):
        z0 = size * np.array([[-1.0, -1e-9], [0.3, 0.3], [0.0, 1.0], [0.2, 0.1]])
        cut = poincare_map(model, z0, section=ON_X, crossings=1, max_time=7.0, step=0.1)
        np.testing.assert_allclose(cut.times[0], [np.pi / 2, 1e-9], rtol=1e-6)


def test_nothing_comes_after_max_time():
    """max_time between two steps: x = sin(t - t0) rises through 0 at t0, just before it or just after."""
    model, late = shared_systems.oscillators(), np.array([1.91, 1.93, 1.95, 1.97, 1.99, 2.01])
    z0 = np.array([-np.sin(late), 0.1 + 0 * late, np.cos(late), 0 * late])
    for options in ({"step": 0.3}, {"scheme": DOP853}, {"step": 1.5, "scheme": SOFRONIOU_SPALETTA10}, {}):
        cut = poincare_map(model, z0, section=ON_X, crossings=2, max_time=1.96, energy_tolerance=1.0, **options)
        np.testing.assert_array_equal(cut.counts, late < 1.96)
        assert (cut.status == Status.TOO_FEW_CROSSINGS).all()


# --- outcomes ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [{"step": 0.1}, {"scheme": DOP853}], ids=["fixed", "adaptive"])
def test_an_orbit_that_never_crosses_ends_at_max_time(options):
    cut = poincare_map(BODY, states(BODY, 3), section=AlphaEquals(50.0), crossings=4, max_time=30.0, **options)
    assert (cut.status == Status.TOO_FEW_CROSSINGS).all()
    assert (cut.counts == 0).all()
    assert np.isnan(cut.points).all()
    assert (cut.section_error == 0).all()
    assert "3 TOO_FEW_CROSSINGS (reached max_time" in cut.summary()
    with pytest.raises(OrbitError, match="TOO_FEW_CROSSINGS"):
        cut.raise_if_failed()


def test_energy_drift_cuts_the_orbit_off():
    """RK4 loses energy steadily: crossings before the tolerance is exceeded are kept, the others are not."""
    z0 = states(BODY, 10, seed=7, spread=0.1)
    options = {"section": AlphaTurning(1), "crossings": 200, "max_time": 2000.0, "step": 0.1, "scheme": RK4}
    all_of_it = poincare_map(BODY, z0, energy_tolerance=1e9, **options)
    assert (all_of_it.counts == 200).all()
    path = integrate(BODY, z0, time=540.0, step=0.1, samples=5400).samples
    assert np.nanmax(all_of_it.times) < 540.0
    scale = BODY.kinetic_energy(*np.moveaxis(path, 1, 0)[4:]).max(axis=0)  # nearly the largest that is met
    drift = np.abs(energy(BODY, all_of_it.points) - energy(BODY, z0)) / scale
    tolerance = float(np.median(drift[100]))
    cut = poincare_map(BODY, z0, energy_tolerance=tolerance, **options)
    lost = cut.status == Status.ENERGY_DRIFT
    assert lost.any()
    for i in np.flatnonzero(lost):
        n = cut.counts[i]
        assert 0 < n < 200
        assert (drift[:n, i] <= 1.001 * tolerance).all()
        assert drift[n, i] > 0.998 * tolerance
        np.testing.assert_array_equal(cut.times[:n, i], all_of_it.times[:n, i])
        assert np.isnan(cut.times[n:, i]).all()
        assert cut.energy_error[i] > tolerance


def test_escape_is_noticed():
    z0 = np.array([[0.1, 0.0], [1.2, 0.1], [0.1, 0.3], [0.3, 0.1]])
    cut = poincare_map(HenonHeiles(), z0, section=ON_X, crossings=5, max_time=200.0, step=0.01)
    assert cut.status[0] in (Status.ESCAPED, Status.NONFINITE)
    assert cut.status[1] == Status.OK
    far = poincare_map(
        Body(Harmonic(C=-1.0)),
        [1.0, 0, 0, 0, 1, 0, 0, 0],
        section=AlphaTurning(),
        crossings=1,
        max_time=1e3,
        step=0.1,
        energy_tolerance=1e15,
    )
    assert far.status[0] == Status.ESCAPED


def test_collapse_is_noticed():
    z0 = np.array([1.5, 0.0, 1.45, 0.0, -3.0, 0.0, 3.0, 0.0])
    cut = poincare_map(
        Body(Hyperelastic()), z0, section=AlphaTurning(), crossings=5, max_time=50.0, step=0.1, scheme=LEAPFROG
    )
    assert cut.status[0] == Status.OUT_OF_DOMAIN


# --- bitwise promises --------------------------------------------------------------------------------------------


# --- the result --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["KAHAN_LI8", "RKN12"])
@pytest.mark.parametrize(("crossings", "time"), [(1, 30.0), (7, 55.0), (300, 77.7)])
def test_one_orbit_alone_is_the_same(scheme, crossings, time):
    """Its states are looked at a stretch at a time: orbits that end with their crossings, at max_time, or escape."""
    rng = np.random.default_rng(crossings)
    z = np.array([0.0, 0.1, 0.4, 0.14])[:, None] + rng.normal(0, [[0.05], [0.05], [0.05], [0.6]], (4, 12))
    z[:, 0] = 0.0, 2.0, 0.4, 1.0
    options = {"section": ON_X, "crossings": crossings, "max_time": time, "step": 0.1, "scheme": scheme, "threads": 1}
    every = poincare_map(BALL, z, **options)
    assert len(set(every.status)) > 1 or crossings == 1
    for k in range(z.shape[1]):
        alone = poincare_map(BALL, z[:, k], **options)
        for name in ("points", "times", "counts", "section_error", "energy_error", "status"):
            np.testing.assert_array_equal(getattr(alone, name)[..., 0], getattr(every, name)[..., k], err_msg=name)


@pytest.mark.parametrize(("scheme", "accuracy"), [("KAHAN_LI8", 1e-10), ("RKN12", 1e-12), (None, 1e-4)])
def test_one_orbit_alone_has_the_same_errors(scheme, accuracy):
    """Its run with twice the step is slowed a stretch at a time, beside the other run or after it."""
    rng = np.random.default_rng(8)
    z = np.array([0.0, 0.1, 0.4, 0.14])[:, None] + rng.normal(0, [[0.05], [0.05], [0.05], [0.3]], (4, 80))
    z[:, 0] = 0.0, 2.0, 0.4, 1.0
    options = {"section": ON_X, "crossings": 40, "max_time": 200.0, "scheme": scheme, "accuracy": accuracy}
    every = poincare_map(BALL, z, **options)
    for k in range(0, 80, 4):
        alone = poincare_map(BALL, z[:, k], **options, threads=1 + k // 4 % 2)
        for name in ("points", "times", "counts", "status", "step", "time_error", "point_error", "accurate_until"):
            np.testing.assert_array_equal(getattr(alone, name)[..., 0], getattr(every, name)[..., k], err_msg=name)


@pytest.mark.parametrize("chart", [ALPHA_BETA, TWO_POLAR, R_VARTHETA], ids=lambda c: c.name)
def test_coordinates_in_charts(chart):
    cut = poincare_map(BODY, states(BODY, 30), section=BetaEquals(0.3, 1), crossings=10, max_time=15.0, step=0.1)
    q = cut.coordinates(chart)
    assert q.shape == (8, 10, 30)
    kept = np.isfinite(cut.times)
    assert 0 < kept.sum() < kept.size
    assert np.isnan(q[:, ~kept]).all()
    np.testing.assert_allclose(chart.to_planes(q[:, kept]), cut.points[:, kept], rtol=0, atol=1e-12)
    if chart is ALPHA_BETA:
        np.testing.assert_allclose(q[1][kept], 0.3, rtol=0, atol=1e-12)
        assert (q[5][kept] > 0).all()


def test_sections_are_callable_values():
    z = states(BODY, 4)
    assert AlphaTurning()(z).shape == (4,)
    assert AreaEquals(1.0)(z[:, 0]) == pytest.approx(
        (z[0, 0] ** 2 + z[1, 0] ** 2 - z[2, 0] ** 2 - z[3, 0] ** 2) / 2 - 1.0
    )
    assert AlphaEquals(1.0)(z)[1] == pytest.approx(np.hypot(z[0, 1], z[1, 1]) - 1.0)
    assert Hyperplane((0, 0, 0, 0, 0, 0, 0, 3.0), 0.5)(z)[2] == pytest.approx(3 * z[7, 2] - 0.5)
    assert AlphaTurning(1) == AlphaTurning(direction=1) != AlphaTurning(-1)


# --- interruption ------------------------------------------------------------------------------------------------

INTERRUPT = """
import os, signal, threading
import numpy as np
import fastaff
from fastaff import *

body = Body(Hyperelastic())
z0 = np.array([1.5, 0.1, 0.2, 0.3, 0.1, 0.2, 0.3, 0.1])[:, None] + 0.01*np.arange(400)/400
callback = None
CALL
def send():
    os.kill(os.getpid(), signal.SIGINT)
call(10.0)    # compile or load
armed = True
def callback(fraction):
    global armed
    if armed and fraction > 0.005:  # something is found by then
        armed = False
        threading.Timer(0.01, send).start()
try:
    call(BIG)   # some 10 s
except Interrupted as stopped:
    assert isinstance(stopped, KeyboardInterrupt)
    whole = stopped.partial
    partial = whole[whole.status == Status.INTERRUPTED]  # some may be finished by then
    assert len(partial), whole.summary()
    CHECK
    print("fine")
else:
    print("not stopped")
# and the session goes on
assert (integrate(body, z0[:, :3], time=1.0, step=0.1).status == 0).all()
"""


def interrupt(call, big, check):
    script = INTERRUPT.replace("CALL", call).replace("BIG", str(big)).replace("CHECK", check)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert "fine" in done.stdout, done.stdout + done.stderr


@pytest.mark.race
@pytest.mark.parametrize("options", ["step=0.01", "scheme=DOP853"], ids=["fixed", "adaptive"])
def test_ctrl_c_stops_a_map_and_hands_over_what_there_is(options):
    interrupt(
        "call = lambda time: poincare_map("
        f"body, z0, section=AlphaTurning(), crossings=4000, max_time=time, callback=callback, {options})",
        2e4,
        "assert whole.counts.max() > 10, whole.counts\n"
        "    counts = partial.counts; assert 4000 > counts.max(), counts; k = counts.argmax(); n = counts[k]\n"
        "    assert np.isfinite(partial.points[:, :n, k]).all() and np.isnan(partial.times[n:, k]).all()\n"
        "    assert partial.section_error.max() < 1e-12",
    )


@pytest.mark.parametrize("located", [0, 40], ids=["none located", "some located"])
def test_ctrl_c_while_crossings_are_located_keeps_only_located_ones(monkeypatch, located):
    locate = engine.Flow.locate

    def stopped(self, section, records, where, *rest):
        locate(self, section, records, where[:located], *rest)
        raise KeyboardInterrupt

    monkeypatch.setattr(engine.Flow, "locate", stopped)
    with pytest.raises(Interrupted) as caught:
        poincare_map(BODY, states(BODY, 10, seed=3), section=AlphaTurning(), crossings=8, max_time=200.0, step=0.1)
    partial = caught.value.partial
    assert partial.counts.sum() == located
    assert (np.isfinite(partial.times).sum(axis=0) == partial.counts).all()
    assert np.abs(AlphaTurning()(partial.points[:, np.isfinite(partial.times)])).max(initial=0) < 1e-12
    assert np.isin(partial.status, (Status.OK, Status.INTERRUPTED)).all()


def test_how_long_an_orbit_is_accurate_does_not_depend_on_its_company():
    """Others that met the section but grazing, and run on for more crossings, moved it to the end of the time."""
    z0, more = np.random.default_rng(5).uniform(-0.3, 0.3, (4, 60)), {"crossings": 12, "max_time": 200.0}
    whole = poincare_map(HenonHeiles(), z0, section="x=0.3", accuracy=1e-6, **more)
    assert ((whole.accurate_until < 200) & (whole.counts == 12)).sum() >= 10
    for k in range(0, 60, 4):
        alone = poincare_map(HenonHeiles(), z0[:, [k]], section="x=0.3", accuracy=1e-6, **more)
        for name in ("accurate_until", "times", "point_error"):
            np.testing.assert_array_equal(getattr(alone, name)[..., 0], getattr(whole, name)[..., k], err_msg=name)
