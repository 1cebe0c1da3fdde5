"""Frequency maps against closed forms, dE/dJ by quadrature, and angles unwrapped by hand; error estimates, diffusion,
promises.

The truth of EQ2.2h and the heavy top is `naive.r_vartheta_frequencies`, checked here against the 20-digit reference of
the project.
"""

import tracemalloc

import numpy as np
import pytest
import shared_systems
from comparison import same
from naive import frequencies, label, sign, states, turns

import fastaff as fa
from fastaff import (
    DOP853,
    LEAPFROG,
    SOFRONIOU_SPALETTA10,
    AlphaTurning,
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    NeoHookean,
    Status,
    energy_grid,
    frequency_map,
    integrate,
)
from fastaff.systems.charts import from_matrix
from fastaff.systems.models.angles import AlphaBeta
from fastaff.systems.models.double_pendulum import DoublePendulum

SEPARABLE_AB = [Body(Harmonic(1.3), 0.7), Body(Anharmonic(0.9), 1.4)]
SEPARABLE_RV = [Body(Hyperelastic(1.0), 1.0), Body(HeavyTop(1.0, 0.5), 1.0)]
BODY, BALL = SEPARABLE_RV[0], HenonHeiles(0.9)
PERIODS = 200 * np.pi  # about 200 dilatations for C = mu = 1
PRECISE = {"step": 0.02, "scheme": SOFRONIOU_SPALETTA10}


def rows(f):
    """The two librations, eta and gamma."""
    return np.array([*f.nu[:2], f.nu_eta, f.nu_gamma])


def relative(f, truth):
    """Largest error of each orbit, relative to its fastest frequency."""
    return (np.abs(rows(f) - truth) / np.abs(truth).max(axis=0)).max(axis=0)


def moving(body, orbits, seed):
    """Random bound orbits without a nearly vanishing angular momentum; those have tests of their own."""
    z = states(body, 2 * orbits, seed)
    spins = np.abs([z[0] * z[5] - z[1] * z[4], z[2] * z[7] - z[3] * z[6]])
    return np.ascontiguousarray(z[:, spins.min(axis=0) > 1e-3][:, :orbits])


# tests/data/reference_numbers.json, table d_classical (mpmath quadrature at 40 digits; C = mu = 1, A = 0.5):
# x y z u, p_x p_y p_z p_u; then nu_r or nu_alpha, nu_vartheta or nu_beta, nu_phi, nu_psi
POINTS = (
    ((1.3, 0.2, -0.1, 0.8), (0.3, -0.4, 0.5, 0.2)),
    ((1.0, 0.5, -0.3, 1.4), (-0.2, 0.6, 0.1, -0.5)),
    ((1.7, -0.2, 0.5, 0.8), (0.2, -0.9, -0.3, -0.4)),
)
LIBRATION = 0.31830988618379067154
REFERENCE = [
    (
        Harmonic(),
        (
            (LIBRATION, LIBRATION, 0.15915494309189533577, 0.0),
            (LIBRATION, LIBRATION, -0.15915494309189533577, 0.0),
            (LIBRATION, LIBRATION, 0.0, -0.15915494309189533577),
        ),
    ),
    (
        Anharmonic(),
        (
            (LIBRATION, LIBRATION, 0.11573159247222921162, 0.043423350619666124145),
            (LIBRATION, LIBRATION, -0.11162639216315601897, -0.047528550928739316799),
            (LIBRATION, LIBRATION, -0.049389496610530005353, -0.10976544648136533042),
        ),
    ),
    (
        Hyperelastic(),
        (
            (LIBRATION, 0.43310631540450606680, 0.14324822812309199101, 0.072674021217335999060),
            (LIBRATION, 0.44684892444546547336, -0.13916269262706489412, -0.078587541024214583502),
            (LIBRATION, 0.48351122512896520210, -0.085055932018638540893, -0.13532404425669438526),
        ),
    ),
    (
        HeavyTop(1.0, 0.5),
        (
            (LIBRATION, 0.13928719665643554007, 0.084162497813912671869, -0.065656794013653051613),
            (LIBRATION, 0.27179704981362459310, -0.14476612603601616510, 0.020246313190522229580),
            (LIBRATION, 0.31569571506030090303, 0.010586928999729569527, -0.15761346039988382364),
        ),
    ),
]
every_reference = pytest.mark.parametrize(("potential", "expected"), REFERENCE, ids=label)


def reference_points():
    return np.array([from_matrix(np.reshape(phi, (2, 2)), np.reshape(p, (2, 2))) for phi, p in POINTS]).T


@every_reference
def test_the_naive_truth_is_the_reference(potential, expected):
    nu = frequencies(Body(potential), reference_points())
    phi_psi = np.array([nu[0], nu[1], (nu[2] + nu[3]) / 2, (nu[3] - nu[2]) / 2])
    np.testing.assert_allclose(phi_psi, np.transpose(expected), rtol=0, atol=2e-15)


@pytest.mark.parametrize("body", SEPARABLE_RV, ids=label)
def test_the_naive_truth_is_the_turning_of_the_planes(body):
    """Mean rates of the unwrapped angles over a long time: the boundary terms fall like 1/time."""
    z0 = moving(body, 3, 20)
    truth = frequencies(body, z0)
    np.testing.assert_allclose(turns(body, z0, 400.0, 0.1), truth[2:], rtol=0, atol=1.0 / 400)


# --- a population of random orbits -------------------------------------------------------------------------------


@pytest.mark.parametrize("body", SEPARABLE_AB, ids=label)
def test_closed_form_frequencies(body):
    z0 = moving(body, 200, 1)
    f = frequency_map(body, z0, time=PERIODS, **PRECISE)
    truth = frequencies(body, z0)
    off = relative(f, truth)
    assert (off < 1e-11).mean() >= 0.9
    assert (off <= np.maximum(f.error.max(axis=0) / np.abs(truth).max(axis=0), 1e-11)).all()  # a slow turn in a plane
    f.raise_if_failed()


@pytest.mark.parametrize("orbits", [300, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("body", SEPARABLE_RV, ids=label)
def test_random_orbits(body, orbits):
    z0 = moving(body, orbits, 2)
    truth = frequencies(body, z0)
    f = frequency_map(body, z0, time=PERIODS, **PRECISE)
    error, estimate = relative(f, truth), f.error.max(axis=0) / np.abs(truth).max(axis=0)
    assert (f.status == Status.OK).all()
    assert np.median(error) < 1e-10
    assert (error <= estimate + 1e-14).mean() >= 0.99
    assert (error / np.maximum(estimate, 1e-14)).max() < 10


@pytest.mark.parametrize(
    ("terms", "time", "size"),
    [({"a": 1, "b": 1, "c": 1, "d": 1}, 1000.0, 0.2), ({"a": 1, "b": 1.33, "f": 0.4, "g": 1}, 600.0, 0.4)],
    ids=["Hénon-Heiles", "oscillators"],
)
def test_errors_cover_beside_resonances(terms, time, size):
    """Where nothing is integrable most orbits are near some resonance, whose beat no window sees the whole of."""
    model, rng = shared_systems.plane(**terms), np.random.default_rng(27)
    z0 = rng.normal(0, size, (4, 150))
    brief, truth = (frequency_map(model, z0, time=t) for t in (time, 8 * time))
    same = np.abs(brief.nu - truth.nu).max(axis=0) < 0.01  # generators: others of the same lattice are as good
    own = (
        same & (brief.classification == fa.Classification.REGULAR) & (truth.classification == fa.Classification.REGULAR)
    )
    ratio = (np.abs(brief.nu - truth.nu) / (brief.error + truth.error))[:, own].max(axis=0)
    assert own.sum() >= 50
    assert (ratio <= 1).mean() >= 0.95, np.sort(ratio)[-5:]
    assert ratio.max() < 10


def test_what_may_be_a_resonance_is_not_independent():
    """An orbit in the island 5 : 4 of a body, of which the time shows hardly two librations."""
    body = fa.Body(fa.NeoHookean(G=1.0, K=2.0))
    axes = np.linspace(0.05, 1.3, 20), np.linspace(-1.5, 1.5, 20)
    z0 = fa.energy_grid(body, energy=0.8, p_eta=0.5, p_gamma=0.1, section=fa.AlphaTurning(+1), axes=axes).z0[:, 38]
    brief, truth = (frequency_map(body, z0, time=time) for time in (400.0, 8000.0))
    assert truth.classification[0] == fa.Classification.REGULAR
    middle, nu = 5 * truth.nu[1, 0], truth.nu[:, 0].copy()
    slow = abs(nu[0] - middle)
    assert 1 < 400 * slow < 2
    nu[0] = middle + slow * np.sign(brief.nu[0, 0] - middle)  # the lines on either side are as good
    assert (np.abs(brief.nu[:, 0] - nu) <= brief.error[:, 0]).all()
    assert brief.classification[0] == fa.Classification.UNDECIDED


def test_a_slow_libration_is_not_known_before_its_period():
    """An orbit of the double pendulum in the island 3 : 7, which librates once in 1750."""
    z0 = np.array([[-0.44111148208465956], [-0.35992830199603076], [0.32039244961889324], [0.005067819275357155]])
    brief, truth = (frequency_map(DoublePendulum(), z0, time=time) for time in (504.8, 10096.0))
    assert truth.classification[0] == fa.Classification.REGULAR
    assert abs(truth.nu[0, 0] - 7 * truth.nu[1, 0]) == pytest.approx(1 / 1750, rel=0.05)
    k = np.array([(i, j) for i in range(-3, 4) for j in range(-3, 4) if 0 < abs(i) + abs(j) <= 3])
    off = np.abs(brief.nu - (k @ truth.nu).T).min(axis=1)
    assert (off <= brief.error[:, 0]).all()
    assert brief.error.min() > 1 / 1750
    assert brief.classification[0] == fa.Classification.UNDECIDED


@pytest.mark.parametrize("body", SEPARABLE_AB + SEPARABLE_RV, ids=label)
def test_all_frequencies_agree_with_the_truth(body):
    z0 = moving(body, 20, 3)
    truth = frequencies(body, z0)
    f = frequency_map(body, z0, time=PERIODS, **PRECISE)
    error = np.abs(rows(f) - truth)
    estimate = np.array([*f.error[:2], f.error[2] * 2, f.error[2] * 2])
    assert np.median(error) < (1e-9 if isinstance(body.potential, HeavyTop) else 1e-12)
    assert (error <= estimate + 1e-12).all(axis=0).mean() >= 0.95
    assert (error <= 10 * estimate + 1e-12).all()


@pytest.mark.parametrize("body", SEPARABLE_RV, ids=label)
def test_adaptive_runs_agree(body):
    z0 = moving(body, 10, 4)
    f = frequency_map(body, z0, time=PERIODS, scheme=DOP853, rtol=1e-13, atol=1e-13)
    error = relative(f, frequencies(body, z0))
    assert np.median(error) < 1e-10
    assert (error < 1e-11 + f.error.max(axis=0) * 10).mean() >= 0.9


def test_error_falls_with_the_step_by_the_order():
    """The frequencies of a splitting are those of a modified Hamiltonian: off by h^order, which is known and nearly all
    taken off.
    """
    z0 = moving(SEPARABLE_AB[1], 20, 5)
    truth = frequencies(SEPARABLE_AB[1], z0)
    steps = 0.2, 0.1, 0.05
    options = {"time": 1200.0, "scheme": LEAPFROG, "energy_tolerance": 1.0}
    maps = [frequency_map(SEPARABLE_AB[1], z0, step=h, **options) for h in steps]
    estimates = [np.median(f.error[0]) for f in maps]
    assert np.polyfit(np.log(steps), np.log(estimates), 1)[0] == pytest.approx(2, abs=0.1)
    for f in maps:
        assert (relative(f, truth) < 0.2 * f.error.max(axis=0) / np.abs(truth).max(axis=0)).all()


# --- angular momenta near zero -----------------------------------------------------------------------------------


def with_momenta(p_eta, p_gamma):
    """A moving body at alpha = 1.5, beta = 0.3 with these angular momenta; in general position about the axes."""
    alpha, beta, c, s = 1.5, 0.3, np.cos(0.4), np.sin(0.4)
    radial, across = np.array([0.2, 0.25]), np.array([p_eta / alpha, p_gamma / beta])
    a = [alpha * c, alpha * s, radial[0] * c - across[0] * s, radial[0] * s + across[0] * c]
    b = [beta * c, beta * s, radial[1] * c - across[1] * s, radial[1] * s + across[1] * c]
    return np.array([*a[:2], *b[:2], *a[2:], *b[2:]])


MOMENTA = [
    (0.4, 0.1),
    (0.4, -0.1),
    (-0.4, 0.1),
    (-0.4, -0.1),
    (0.3, 1e-3),
    (0.3, -1e-6),
    (0.3, 1e-9),
    (0.0, 0.2),
    (0.3, 0.0),
    (0.0, 0.0),
]


@pytest.mark.parametrize("body", SEPARABLE_AB + SEPARABLE_RV, ids=label)
def test_signs_and_smallness_of_angular_momenta(body):
    """The senses of turning are those of the momenta; p_gamma -> 0 is no singularity of nu_gamma (half a libration a
    turn).

    Exactly 0 (to rounding of z0) has no sense of turning: there only the size is asked for.
    """
    z0 = np.array([with_momenta(*pair) for pair in MOMENTA]).T
    truth = frequencies(body, z0)
    f = frequency_map(body, z0, time=PERIODS, **PRECISE)
    nu = rows(f)
    free = np.array(MOMENTA).T == 0.0
    for k in (2, 3):
        nu[k] = np.where(free[k - 2], np.abs(nu[k]), nu[k])
        truth[k] = np.where(free[k - 2], np.abs(truth[k]), truth[k])
    allowed = np.array([*f.error[:2], f.error[2] * 2, f.error[2] * 2])
    assert (np.abs(nu - truth) <= 1e-11 + allowed).all()
    assert np.median(np.abs(nu - truth)) < 1e-11
    moving_gamma = np.abs(np.array(MOMENTA)[:, 1]) > 0
    np.testing.assert_array_equal(np.sign(f.nu_gamma)[moving_gamma], sign(np.array(MOMENTA)[moving_gamma, 1]))
    np.testing.assert_allclose(f.nu[2:], [(f.nu_eta + f.nu_gamma) / 2, (f.nu_gamma - f.nu_eta) / 2], rtol=0, atol=1e-16)


def test_reflection_reverses_the_planes():
    z0 = moving(BODY, 10, 6)
    mirror = np.array([1, -1, 1, -1] * 2)[:, None]
    one, other = (frequency_map(BODY, z, time=200.0, step=0.05) for z in (z0, z0 * mirror))
    np.testing.assert_allclose(other.nu_eta, -one.nu_eta, rtol=0, atol=1e-13)
    np.testing.assert_allclose(other.nu_gamma, -one.nu_gamma, rtol=0, atol=1e-13)
    np.testing.assert_allclose(other.nu[:2], one.nu[:2], rtol=0, atol=1e-13)


# --- not separable -----------------------------------------------------------------------------------------------


def neo_hookean(energy, cells):
    body = Body(NeoHookean(1.0, 2.0))
    axes = np.linspace(0.05, 1.5, cells), np.linspace(-1.5, 1.5, cells)
    return body, energy_grid(body, energy=energy, section=AlphaTurning(-1), axes=axes, p_eta=0.3, p_gamma=0.2).z0


def test_diffusion_tells_chaos_from_order():
    """Mostly regular at E = 1, mostly chaotic at E = 3 (formulas.md section 8): six orders of magnitude apart."""
    medians = []
    for energy, cells in ((0.5, 15), (4.0, 7)):
        body, z0 = neo_hookean(energy, cells)
        f = frequency_map(body, z0, time=600.0, step=0.02, energy_tolerance=1e-4)
        kept = f.status == Status.OK
        assert kept.sum() > 10
        medians.append(np.median(f.diffusion[kept]))
    regular, chaotic = medians
    assert regular < -8
    assert chaotic > -4
    assert (f.diffusion[kept] < 1).all()


def test_diffusion_is_the_change_of_the_frequencies_between_the_halves():
    """Halves by hand, chaotic orbits: maps over the first half from z0 and over the second from the state in
    between.
    """
    body, z0 = neo_hookean(4.0, 6)
    options = {"step": 0.005, "scheme": SOFRONIOU_SPALETTA10, "energy_tolerance": 1e-4}
    f = frequency_map(body, z0, time=160.0, **options)
    middle = integrate(body, z0, time=80.0, step=0.005, scheme=SOFRONIOU_SPALETTA10, energy_tolerance=1e-4)
    kept = (f.status == Status.OK) & (middle.status == Status.OK)
    assert kept.sum() >= 8
    first, second = (frequency_map(body, z[:, kept], time=80.0, **options) for z in (z0, middle.z))
    change = np.abs(rows(first) - rows(second)).max(axis=0)
    # Chaotic orbits have no sharp lines: within a factor of ten.
    assert np.median(np.abs(f.diffusion[kept] - np.log10(change))) < 1.0


# --- angles ---------------------------------------------------------------------------------------------------------


def test_other_angles_may_be_chosen():
    """The averages over time of the planes' angles are the same frequencies, found with more effort."""
    z0 = moving(BODY, 5, 8)
    f = frequency_map(BODY, z0, time=3000.0, signals=AlphaBeta(), step=0.1)
    truth = frequencies(BODY, z0)
    assert f.names == ("alpha", "beta", "phi", "psi")
    np.testing.assert_allclose(f.nu_eta, truth[2], rtol=0, atol=1e-6)
    np.testing.assert_allclose(f.nu_gamma, truth[3], rtol=0, atol=1e-6)


def test_lost_orbits_have_a_status_and_no_frequencies():
    z0 = np.array([[0.05, 1.2, 0.05], [0.08, 0.1, 0.05], [0.1, 0.5, 0.1], [0.0, 0.3, 0.1]])
    f = frequency_map(HenonHeiles(), z0, time=200.0, step=0.05)
    assert f.status[1] in (Status.ESCAPED, Status.NONFINITE)
    np.testing.assert_array_equal(f.status[[0, 2]], Status.OK)
    assert (f.error[:, 1] == np.inf).all()
    assert (np.isfinite(f.nu) == np.isfinite(f.error)).all()
    alone = frequency_map(HenonHeiles(), z0[:, [0, 2]], time=200.0, step=0.05)
    np.testing.assert_array_equal(f.nu[:, [0, 2]], alone.nu)


def test_energy_drift_is_marked():
    f = frequency_map(BODY, moving(BODY, 10, 9), time=50.0, step=0.2, scheme=LEAPFROG)
    np.testing.assert_array_equal(f.status == Status.ENERGY_DRIFT, f.energy_error > 1e-6)
    assert (f.status == Status.ENERGY_DRIFT).any()


# --- promises ----------------------------------------------------------------------------------------------------


def test_memory_does_not_grow_with_time(monkeypatch):
    """Samples are in memory for as many orbits at a time as the budget allows; one orbit's always are.

    By one thread: of two it is a matter of chance which numbers they have at the same time.
    """
    z0 = states(BODY, 32)
    monkeypatch.setattr("fastaff.frequencies.frequency_map.BUDGET", 1 << 22)

    def peak(time):
        tracemalloc.start()
        frequency_map(BODY, z0, time=time, step=0.1, threads=1)
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return size

    peak(1000.0)  # what a first long run leaves in caches
    assert peak(1000.0) < 1.2 * peak(250.0) + 20_000


def test_threads_read_shares_of_the_orbits():
    """Two threads read halves of large sets, tunes too; their numbers are those of one thread, to the bit."""
    start = np.array([[0.0], [0.1], [0.3], [0.1]]) + 0.05 * np.random.default_rng(4).standard_normal((4, 300))
    start[:, 7] = 3.0  # escapes
    same(*(fa.frequency_map(HenonHeiles(), start, time=80.0, threads=k) for k in (1, 2)))
    turn = 2 * np.pi * np.random.default_rng(5).uniform(0.05, 0.45, 300)[:, None] * np.arange(512)
    samples = np.array([np.cos(turn), -np.sin(turn) + 0.1 * np.cos(2 * turn)])
    samples[:, 11, 300:] = np.nan
    same(*(fa.tunes(samples, lines=2, threads=k) for k in (1, 2)))
