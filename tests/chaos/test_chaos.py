"""Chaos maps: indicators against slow twins and laws, classifications on known orbits, streaming, history, early stop,
outcomes.
"""

import math
import sys
from functools import cache

import numpy as np
import pytest
import shared_systems
from naive import march
from own_models import HenonHeilesInUnits

import fastaff
from fastaff import (
    DOP853,
    FLI,
    GALI,
    KAHAN_LI8,
    MEGNO,
    OFLI,
    SALI,
    Body,
    Classification,
    FrequencyDiffusion,
    HenonHeiles,
    Lyapunov,
    LyapunovSpectrum,
    ReversibilityError,
    Status,
    WeightedBirkhoff,
    ZeroOneTest,
    chaos_map,
    integrate,
    tangent_map,
)
from fastaff.chaos.streamed import own_rates, scales, symplectic_frame
from fastaff.engine.jit import JIT_DISABLED
from fastaff.runs.options import Options, plan
from fastaff.systems.models.mechanics import system_of

EVERY = (
    Lyapunov(),
    LyapunovSpectrum(),
    FLI(),
    OFLI(),
    MEGNO(),
    SALI(),
    GALI(2),
    GALI(3),
    GALI(4),
    WeightedBirkhoff(),
    FrequencyDiffusion(),
    ZeroOneTest(),
    ReversibilityError(),
)
STREAMED = EVERY[:9]
CHAOTIC, REGULAR = [0.0, -0.25, 0.42081, 0.0], [0.0, 0.483, 0.27898039, 0.0]
"""Skokos 2001, J. Phys. A 34, 10029 and Skokos, Bountis & Antonopoulos 2007: E = 1/8."""
BOTH = np.array([CHAOTIC, REGULAR]).T


@pytest.fixture(scope="module")
def known():
    """All indicators of the two orbits of the literature."""
    return chaos_map(HenonHeiles(), BOTH, time=1000.0, indicators=EVERY, step=0.05, history=20)


def test_every_indicator_knows_the_orbits_of_the_literature(known):
    assert known.names[3] == "ofli"
    expected = np.array([[Classification.CHAOTIC, Classification.REGULAR]] * len(EVERY))
    for name in ("weighted_birkhoff", "zero_one_test"):  # 160 periods: slow beats would look the same
        expected[known.names.index(name), 0] = Classification.UNDECIDED
    np.testing.assert_array_equal(known.classifications, expected)
    np.testing.assert_array_equal(known.classification, [Classification.CHAOTIC, Classification.REGULAR])
    assert not known.disagree.any()
    assert 0.04 <= known.lyapunov[0] <= 0.08  # the range of the literature at E = 1/8
    assert known.megno[1] == pytest.approx(2.0, abs=0.05)
    assert known.megno[0] == pytest.approx(known.lyapunov[0] * 1000 / 2, rel=0.1)
    assert known.fraction == 0.5
    assert known.summary().startswith("2 orbits: 1 regular, 1 chaotic")


def test_spectra_sum_to_zero_and_pair(known):
    """With 2n vectors (GALI(4) runs) nothing is mirrored: the splitting and the symplectic frame pair them to
    rounding.
    """
    np.testing.assert_allclose(known.spectrum.sum(axis=0), 0, atol=1e-13)
    np.testing.assert_allclose(known.spectrum, -known.spectrum[::-1], atol=1e-13)
    half = chaos_map(HenonHeiles(), REGULAR, time=1000.0, indicators=(LyapunovSpectrum(),), step=0.05)
    np.testing.assert_allclose(
        half.spectrum[:, 0], known.spectrum[:, 1], atol=1e-11
    )  # the regular one: chaos would magnify roundings
    # Two exponents are 0; what is left of them at T = 1000 is covered by the error estimate.
    assert (np.abs(known.spectrum[1:3]) <= 3 * known.spectrum_error[1:3]).all()
    assert (np.abs(known.spectrum[0, 1]) <= 3 * known.spectrum_error[0, 1]).all()


def test_any_frame_pairs_within_the_error_estimate():
    frame = np.linalg.qr(np.random.default_rng(8).standard_normal((4, 4)))[0]
    found = chaos_map(
        HenonHeiles(), BOTH, time=2000.0, indicators=(LyapunovSpectrum(),), step=0.1, deviation_vectors=frame
    )
    np.testing.assert_allclose(found.spectrum.sum(axis=0), 0, atol=1e-13)
    error = found.spectrum_error + found.spectrum_error[::-1]
    assert (np.abs(found.spectrum + found.spectrum[::-1]) <= error + 1e-3).all()


def scale_of(model, z0, time):
    """What makes one unit of the positions and momenta of tangent vectors (2n, orbits)."""
    z0 = np.array(z0, dtype=float).reshape(2 * model.degrees_of_freedom, -1)
    return scales(system_of(model), z0, own_rates(plan(model, z0, Options()), time))


def twin(model, z0, time, observations):
    """Growth of raw vectors by SVD: log10 of the volumes of the first k, MEGNO by its sum, from tangent maps over short
    stretches.
    """
    n, scale = model.degrees_of_freedom, scale_of(model, z0, time)[:, 0]
    vectors, z, dt = symplectic_frame(n, 2 * n) / scale, np.array(z0), time / observations
    logs, mean, megno, weighted = np.zeros(2 * n), 0.0, 0.0, 0.0
    for k in range(observations):
        step = tangent_map(model, z, time=dt, step=0.05, deviation_vectors=vectors)
        z, lengths = step.z[:, 0], np.linalg.norm(step.vectors[:, :, 0] * scale, axis=1)
        vectors = step.vectors[:, :, 0] / lengths[:, None]
        logs += np.log(lengths)
        weighted += (k + 0.5) * dt * math.log(lengths[0])
        now = 2 * weighted / ((k + 1) * dt)
        mean, megno = mean + 0.5 * (megno + now) * dt, now
    volumes = [np.log10(np.linalg.svd(vectors[:k] * scale, compute_uv=False)).sum() for k in range(2, 2 * n + 1)]
    return logs / math.log(10), volumes, mean / time


@pytest.mark.parametrize("start", [CHAOTIC, REGULAR], ids=["chaotic", "regular"])
def test_streamed_values_are_those_of_raw_vectors(start):
    """Singular values of vectors that were never made orthogonal, over a time in which they can still be told apart."""
    run = {"time": 60.0, "step": 0.05, "indicators": (FLI(), MEGNO(), SALI(), GALI(2), GALI(3), GALI(4)), "history": 60}
    found = chaos_map(HenonHeiles(), start, **run)
    logs, volumes, megno = twin(HenonHeiles(), start, 60.0, 60)
    assert found.gali_2[0] == pytest.approx(volumes[0], abs=1e-9)
    assert found.gali_3[0] == pytest.approx(volumes[1], abs=1e-7)
    assert found.gali_4[0] == pytest.approx(volumes[2], abs=1e-5)
    assert found.megno[0] == pytest.approx(megno, abs=2e-2)  # sums over other intervals
    assert found.fli[0] >= logs[0] - 1e-12
    angle = math.asin(10 ** volumes[0])
    assert found.sali[0] == pytest.approx(math.log10(2 * math.sin(angle / 2)), abs=1e-9)


def test_alignment_laws():
    """GALI_k of a regular orbit of n = 2: constant for k = 2, t^-2 for 3, t^-4 for 4; of a chaotic one by the
    exponents, past 1e-16.
    """
    run = {"time": 10_000.0, "step": 0.1, "indicators": (LyapunovSpectrum(), GALI(2), GALI(3), GALI(4)), "history": 100}
    found = chaos_map(HenonHeiles(), BOTH, **run)
    t = np.log10(found.history_times[9:, 1])
    for j, power in ((1, 0), (2, -2), (3, -4)):
        assert np.polyfit(t, found.history[j, 9:, 1], 1)[0] == pytest.approx(power, abs=0.15)
    largest = found.spectrum[0, 0]
    # lambda = (l, 0, 0, -l): volumes of 2, 3, 4 vectors shrink as exp(-l t), exp(-2 l t), exp(-4 l t)
    for name, factor in (("gali_2", 1), ("gali_3", 2), ("gali_4", 4)):
        assert getattr(found, name)[0] == pytest.approx(-factor * largest * 1e4 / math.log(10), rel=0.06)
    assert found.gali_4[0] < -100  # how far depends on the last digits, as the orbit sticks to islands or does not


@pytest.mark.parametrize(("energy", "share"), [(0.1, 0.06), (0.125, 0.15), (0.14, 0.3)])
def test_what_is_called_regular_is_rarely_chaotic_in_the_end(energy, share):
    """Nothing before 100 natural periods; of what is after 120, as much as told is chaotic after 3000."""
    z0 = surface(energy, 120, seed=8)
    short, enough, long = (chaos_map(HenonHeiles(), z0, time=time) for time in (550.0, 760.0, 19000.0))
    assert not short.regular.any()
    assert (short.suggested_time[short.undecided] > 600.0).all()
    assert long.undecided.mean() < 0.05
    assert enough.regular.sum() > 10
    assert (long.chaotic & enough.regular).sum() <= share * enough.regular.sum()
    assert not (long.regular & enough.chaotic).any()


def test_isochronous_orbits_have_constant_vectors():
    """Harmonic oscillator with mu omega = 1: the tangent map is a rotation, so all volumes stay 1 and MEGNO is 0."""
    body = Body(fastaff.Harmonic(C=1.25), mu=0.8)
    z0 = np.random.default_rng(2).standard_normal((8, 5))
    found = chaos_map(
        body, z0, time=600.0, step=0.05, indicators=(Lyapunov(), LyapunovSpectrum(), FLI(), MEGNO(), SALI(), GALI(4))
    )
    # In a metric whose frequency is a little off, as it comes from a look at the orbit, vectors swing by as much.
    swing = np.abs(np.log10(own_rates(plan(body, z0, Options()), 600.0) / 1.25))
    assert (swing < 0.05).all()
    for j, name in enumerate(found.names):
        expected = math.log10(math.sqrt(2)) if name == "sali" else 0.0
        assert (np.abs(found.values[j] - expected) <= 8 * swing + 1e-9).all(), name
    assert found.regular.all()


def cubic(A, B, c):
    """Integrable for c = -1, A = B; c = -6; c = -16, B = 16 A (Chang, Tabor & Weiss 1982)."""
    return shared_systems.plane(a=A, b=B, c=1, d=c)


def quartic(a, b, c, m=1.0):
    """Separable for c = 0, strongly chaotic for large c."""
    return fastaff.hamiltonian("(a*x**4 + b*y**4)/4 + c*x**2*y**2/2", masses=(m, m), a=a, b=b, c=c)


def random_starts(model, orbits, size, seed=3):
    """Random bound states inside the domain, some fast."""
    n = model.degrees_of_freedom
    z = size * np.random.default_rng(seed).standard_normal((2 * n, 3 * orbits))
    if isinstance(model, Body):
        z[:4] *= 0.5
        z[0] += 1.4
    margin = np.broadcast_to(model.margin(*z[:n]), z.shape[1:])
    return np.ascontiguousarray(z[:, margin > 0.1][:, :orbits])


INTEGRABLE = {
    "harmonic": (Body(fastaff.Harmonic()), 1.0),
    "anharmonic": (Body(fastaff.Anharmonic()), 1.0),
    "hyperelastic": (Body(fastaff.Hyperelastic()), 1.0),
    "heavy-top": (Body(fastaff.HeavyTop(A=0.5)), 1.0),
    "separable cubic": (cubic(1.0, 1.0, -1.0), 0.1),
    "cubic -6": (cubic(1.3, 0.7, -6.0), 0.015),
    "cubic -16": (cubic(0.5, 8.0, -16.0), 0.05),
    "toda": (shared_systems.toda(), 0.5),
}


def none_is_chaotic(model, size, orbits, time, indicators, **run):
    z0 = random_starts(model, orbits, size)
    found = chaos_map(model, z0, time=time, indicators=indicators, **run)
    fine = found.status == Status.OK
    assert fine.mean() > 0.9
    assert not (found.classifications[:, fine] == Classification.CHAOTIC).any(), found.summary()


COMPILED_ONLY_HERE = {"harmonic", "anharmonic", "heavy-top"}
"""Types that cost a compilation each and that no other default test of chaos runs with as many vectors."""


@pytest.mark.parametrize(
    ("model", "size"),
    [
        pytest.param(*case, id=name, marks=[pytest.mark.slow] if name in COMPILED_ONLY_HERE else [])
        for name, case in INTEGRABLE.items()
    ],
)
def test_integrable_models_have_no_chaotic_orbit(model, size):
    none_is_chaotic(model, size, 150, 60.0, (Lyapunov(), FLI(), MEGNO(), SALI()))


def test_vectors_that_a_shear_tears_apart_at_once_are_no_evidence_of_chaos():
    """GALI_4 of this orbit is beyond its threshold after four turns of the radius, and stays there."""
    z0 = [0.35157306, -0.1379269, 0.75182566, 0.4161813, 0.08589251, -0.78958962, 0.09381623, -0.36855371]
    found = chaos_map(Body(fastaff.HeavyTop(A=0.5)), z0, time=100.0, indicators=(GALI(4),), scheme=DOP853)
    assert found.gali_4[0] < found.thresholds[0, 0]
    assert found.classification[0] == Classification.UNDECIDED


@pytest.mark.slow
@pytest.mark.parametrize(("model", "size"), list(INTEGRABLE.values())[:4], ids=list(INTEGRABLE)[:4])
def test_no_orbit_of_thousands_is_chaotic_where_the_body_is_integrable(model, size):
    none_is_chaotic(model, size, 2500, 100.0, (MEGNO(), SALI(), GALI(4)), scheme=DOP853, rtol=1e-10, atol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize(("model", "size"), list(INTEGRABLE.values())[4:], ids=list(INTEGRABLE)[4:])
def test_no_orbit_of_a_thousand_is_chaotic_in_integrable_planes(model, size):
    none_is_chaotic(model, size, 1000, 1000.0, (Lyapunov(), FLI(), OFLI(), MEGNO(), SALI(), GALI(3), GALI(4)))


def test_energy_surfaces_of_henon_heiles_are_as_in_the_literature():
    """E = 1/12: hardly any chaos; E = 1/6: nearly all (Henon & Heiles 1964, figures 4 to 7)."""
    section, axes = fastaff.Hyperplane((1.0, 0.0, 0.0, 0.0)), (np.linspace(-0.45, 0.95, 16), np.linspace(-0.5, 0.5, 16))
    fractions = []
    for energy in (1 / 12, 1 / 8, 0.999 / 6):
        z0 = fastaff.energy_grid(HenonHeiles(), energy=energy, section=section, axes=axes).z0
        fractions.append(chaos_map(HenonHeiles(), z0, time=2000.0, step=0.2, early_stop=True).fraction)
    assert fractions[0] < 0.05
    assert 0.3 < fractions[1] < 0.75
    assert fractions[2] > 0.9


def test_history_and_detection(known):
    """The last record is the value; a threshold is passed between two records."""
    streamed = len(STREAMED)
    np.testing.assert_allclose(known.history_times[:, 0], np.arange(1, 21) * 50.0, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(known.history[:streamed, -1], known.values[:streamed])
    assert np.isnan(known.history[streamed:]).all()
    np.testing.assert_array_equal(
        np.isfinite(known.detection_time[:streamed]), known.classifications[:streamed] == Classification.CHAOTIC
    )
    for j in (4, 5, 8):
        threshold = known.thresholds[j, 0]
        beyond = known.history[j, :, 0] > threshold if STREAMED[j].above else known.history[j, :, 0] < threshold
        first = known.history_times[np.argmax(beyond), 0]
        assert first - 100 <= known.detection_time[j, 0] <= first  # a swing may take it back before the next record


@pytest.mark.parametrize("run", [{"step": 0.05}, {"scheme": DOP853}], ids=["fixed", "adaptive"])
def test_early_stop(run):
    found = chaos_map(HenonHeiles(), BOTH, time=1000.0, indicators=(MEGNO(), SALI()), early_stop=True, **run)
    whole = chaos_map(HenonHeiles(), BOTH, time=1000.0, indicators=(MEGNO(), SALI()), **run)
    assert (found.status == Status.OK).all()
    np.testing.assert_array_equal(found.chaotic, [True, False])
    assert found.t[1] == pytest.approx(1000.0)
    assert found.t[0] == np.nanmax(found.detection_time[:, 0]) < 600
    if "step" in run:
        np.testing.assert_allclose(found.detection_time, whole.detection_time)
        np.testing.assert_array_equal(found.values[:, 1], whole.values[:, 1])


SOME_SCHEMES = (fastaff.LEAPFROG, fastaff.SOFRONIOU_SPALETTA10, fastaff.RK4, DOP853, fastaff.VERNER9)


@pytest.mark.parametrize("scheme", SOME_SCHEMES, ids=lambda s: s.name)
def test_schemes_agree_on_a_regular_orbit(scheme):
    """Growth is a smooth function of the orbit: schemes agree to their own error."""
    indicators = (Lyapunov(), MEGNO(), SALI(), GALI(4))
    truth = chaos_map(HenonHeiles(), REGULAR, time=100.0, step=0.025, indicators=indicators)
    found = chaos_map(
        HenonHeiles(), REGULAR, time=100.0, step=0.005, scheme=scheme, indicators=indicators, energy_tolerance=1e-3
    )
    loose = 2e-3 if scheme.order == 2 else 1e-7
    for name in ("lyapunov", "sali", "gali_4"):
        assert getattr(found, name)[0] == pytest.approx(getattr(truth, name)[0], abs=loose), name
    assert found.megno[0] == pytest.approx(truth.megno[0], abs=0.05)  # its sum has the observations' resolution


@pytest.mark.parametrize("scheme", ["GAUSS16", "SOFRONIOU_SPALETTA10", "RKN12"])
def test_schemes_that_keep_something_from_step_to_step_know_no_company(scheme):
    """Vectors are renormalised in some lanes: those of others keep what is carried."""
    text = "p1**2/2 + p2**2/2*(1 + q1**2) + q1**2/2 + q2**2/2" if scheme == "GAUSS16" else None
    names = {"coordinates": "q1 q2", "momenta": "p1 p2"}
    model = HenonHeiles() if text is None else fastaff.hamiltonian(text, **names)
    z0 = np.random.default_rng(5).uniform(-0.4, 0.4, (4, 24))
    how = {"time": 40.0, "step": 0.2, "scheme": scheme, "indicators": "megno"}
    whole = chaos_map(model, z0, threads=2, **how).megno
    for first, last in ((0, 1), (1, 4), (4, 11), (11, 24)):
        part = chaos_map(model, np.ascontiguousarray(z0[:, first:last]), threads=1, **how).megno
        np.testing.assert_array_equal(part, whole[first:last])


COMPANY = [entry for entry in EVERY if not isinstance(entry, LyapunovSpectrum)]
"""Indicators that need no more vectors in company, of which the spectrum would make use."""


@pytest.mark.parametrize("options", [{"step": 90.0 / 1536}, {}], ids=["given step", "default"])
@pytest.mark.parametrize("model", [HenonHeiles(), Body(fastaff.NeoHookean(), 0.7)], ids=["Henon-Heiles", "neo-Hookean"])
def test_an_indicator_says_the_same_alone_and_in_any_company(model, options):
    """To the bit, in random subsets and orders of all."""
    random = np.random.default_rng(11)
    z0 = surface(0.125, 5) if isinstance(model, HenonHeiles) else random_starts(model, 5, 0.3)
    run = {"time": 90.0, "history": 3, **options}
    alone = {entry: chaos_map(model, z0, indicators=(entry,), **run) for entry in COMPANY}
    for count in (2, 3, 5, len(COMPANY)):
        chosen = tuple(COMPANY[j] for j in random.permutation(len(COMPANY))[:count])
        found = chaos_map(model, z0, indicators=chosen, **run)
        for row, entry in enumerate(chosen):
            for name in ("values", "thresholds", "classifications", "detection_time", "history"):
                # An orbit that failed for one of them has a status, and no classification.
                kept = found.status == Status.OK if name == "classifications" else np.full(5, True)
                ours, theirs = getattr(found, name)[row][..., kept], getattr(alone[entry], name)[0][..., kept]
                np.testing.assert_array_equal(ours, theirs, err_msg=f"{entry.name}, {name}: {chosen}")
        assert (found.status == Status.OK).sum() >= 3


def test_averages_are_those_of_samples():
    z0 = np.array(REGULAR)
    found = chaos_map(HenonHeiles(), z0, time=300.0, step=0.05, indicators=(WeightedBirkhoff(),))
    path = march(HenonHeiles(), KAHAN_LI8, z0[:, None], 0.05, 6000)[1:, :, 0]
    kinetic, t = ((path[:, 2:] ** 2).sum(axis=1) / 2) ** 2, np.arange(1, 6001) * 0.05
    means = []
    for shift in (1, -1):
        x = 2 * (2 * t / 300.0 - 1) + shift
        weight = np.where(np.abs(x) < 1, np.exp(30.0 * (np.sqrt(np.clip(1 - x * x, 0, None)) - 1)), 0)
        means.append((weight * kinetic).sum() / weight.sum())
    assert found.weighted_birkhoff[0] == pytest.approx(-math.log10(abs(means[0] - means[1]) / max(means)), abs=0.3)


@pytest.mark.parametrize("count", [400, 401, 402, 403, 999, 4000])
def test_the_correlations_of_zero_one_are_those_of_their_definition(count):
    """At three angles against displacements written out with NumPy; samples of the kinetic energy at equal times."""
    from fastaff.chaos.kernels.zero_one import correlations

    samples = integrate(HenonHeiles(), CHAOTIC, time=1.2 * count, step=0.05, samples=count).samples[:, 2:, 0]
    phi, angles, lags = 100.0 + (samples**2).sum(axis=1) / 2, np.array([0.7, 1.9, 2.4]), count // 10
    found, n, left = np.empty(3), np.arange(1, lags + 1), count - lags
    correlations(phi, np.cos(np.arange(lags)[:, None] * angles), found)
    for k, c in zip(found, angles, strict=True):
        walk = np.cumsum(phi * np.exp(1j * c * np.arange(1, count + 1)))
        square = np.array([np.mean(np.abs(walk[m : m + left] - walk[:left]) ** 2) for m in n])
        square -= phi.mean() ** 2 * (1 - np.cos(n * c)) / (1 - math.cos(c))
        assert k == pytest.approx(np.corrcoef(n, square)[0, 1], abs=1e-9)


def test_zero_one_calls_no_chaotic_orbit_regular():
    """Of those of Henon and Heiles, as long runs tell them, one in a hundred at most, however many samples there are;
    most regular ones are regular.
    """
    rng, energy = np.random.default_rng(31), 0.125
    y, p_y = rng.uniform(-0.5, 0.9, 1200), rng.uniform(-0.5, 0.5, 1200)
    square = 2 * energy - y * y + 2 * y**3 / 3 - p_y**2
    z = np.array([0 * y, y, np.sqrt(np.maximum(square, 0)), p_y])[:, square > 0][:, : 16 if JIT_DISABLED else 400]
    truth = chaos_map(HenonHeiles(), z, time=1000.0 if JIT_DISABLED else 50000.0).classification
    chaotic, regular = truth == 1, truth == 0
    for time, samples in ((1000.0, None), (1000.0, 4000), (2500.0, None), (2500.0, 10000)):
        found = chaos_map(HenonHeiles(), z, time=time, indicators=ZeroOneTest(samples=samples)).classification
        assert (found[chaotic] == 0).mean() <= 0.01
        assert not (found[regular] == 1).any()
        if not JIT_DISABLED and samples is None:
            assert (found[regular] == 0).mean() > 0.5
    assert chaotic.sum() > 0


def test_zero_one_tells_chaos_from_order():
    found = chaos_map(HenonHeiles(), BOTH, time=2000.0, step=0.1, indicators=(ZeroOneTest(samples=1000),))
    assert found.zero_one_test[0] > 0.8
    assert abs(found.zero_one_test[1]) < 0.2


def test_reversibility_error_grows_as_rounding_errors_do():
    run = {"step": 0.1, "indicators": (ReversibilityError(),)}
    found = [chaos_map(HenonHeiles(), BOTH, time=time, **run).reversibility_error for time in (50.0, 200.0, 800.0)]
    regular, chaotic = np.array(found)[:, 1], np.array(found)[:, 0]
    assert (regular < -11).all()
    assert chaotic[2] > -3
    assert chaotic[1] - chaotic[0] > 1.5  # lambda 150/ln 10 is 3.7


def test_ensemble_of_indicators_without_tangent_vectors():
    found = chaos_map(
        HenonHeiles(), BOTH, time=1000.0, step=0.1, indicators=(FrequencyDiffusion(), ReversibilityError())
    )
    np.testing.assert_array_equal(found.chaotic, [True, False])
    assert found.history.shape == (2, 0, 2)
    assert np.isnan(found.detection_time).all()


def test_orbits_that_fail_have_a_status_and_no_classification():
    z0 = np.column_stack([REGULAR, [0.0, 1.5, 0.0, 1.0], [0.0, 0.1, 0.0, 0.0]])
    found = chaos_map(HenonHeiles(), z0, time=100.0, step=0.1)
    assert found.status[1] in (Status.ESCAPED, Status.NONFINITE)
    assert (found.status[[0, 2]] == Status.OK).all()
    assert found.t[1] < 20
    assert not found.chaotic[1]
    assert not found.disagree[1]
    with pytest.raises(fastaff.OrbitError):
        found.raise_if_failed()
    rough = chaos_map(HenonHeiles(), REGULAR, time=100.0, step=0.9, scheme=fastaff.LEAPFROG)
    assert rough.status[0] in (Status.ENERGY_DRIFT, Status.ESCAPED)


def test_orbits_that_meet_steep_forces_late_get_shorter_steps(monkeypatch):
    """A core that a trial of 16 radians misses: the energy of these stars is kept, beside DOP853's classifications."""
    galaxy = shared_systems.galaxy(core=0.2)
    y = np.array([0.36837432, -0.33429969, 0.3880399, 0.51029282])
    p_x = np.array([0.32057775, 0.25158198, 0.45574634, 0.12034896])
    p_y = np.sqrt(2 * (-0.5 - galaxy.potential_energy(0.0, y)) - p_x**2)
    z0 = np.array([0 * y, y, p_x, p_y])
    found = chaos_map(galaxy, z0, time=500.0, indicators=(SALI(),))
    assert (found.status == Status.OK).all(), found.summary()
    assert (found.energy_error < 1e-6).all()
    given = chaos_map(galaxy, z0, time=500.0, indicators=(SALI(),), step=0.13)
    assert (given.status == Status.ENERGY_DRIFT).any()  # a step of one's own is kept
    alone = chaos_map(galaxy, z0[:, 3], time=500.0, indicators=(SALI(),))
    assert alone.values.tobytes() == found.values[:, 3:].tobytes()

    module = sys.modules["fastaff.chaos.chaos_map"]
    runs = iter((module.ChaosRun,))

    def once(*arguments, **options):
        for run in runs:
            return run(*arguments, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "ChaosRun", once)
    with pytest.raises(fastaff.Interrupted) as stopped:
        chaos_map(galaxy, z0, time=500.0, indicators=(SALI(),))
    partial = stopped.value.partial
    kept = partial.status == Status.OK
    assert {*partial.status} == {Status.OK, Status.INTERRUPTED}  # those whose step was short enough, and the others
    assert partial.values[:, kept].tobytes() == found.values[:, kept].tobytes()


def test_given_vectors_count_from_their_start():
    """Lengths and angles of the deviations change no growth: against the QR factors of the tangent map at both ends."""
    deviations = np.random.default_rng(3).standard_normal((4, 4)) * np.array([1e-200, 1.0, 30.0, 1e200])[:, None]
    indicators = (Lyapunov(), FLI(), MEGNO(), GALI(3), LyapunovSpectrum())
    found = chaos_map(HenonHeiles(), CHAOTIC, time=40.0, step=0.05, indicators=indicators, deviation_vectors=deviations)
    scale = scale_of(HenonHeiles(), CHAOTIC, 40.0)[:, 0]
    unit = deviations / np.abs(deviations).max(axis=1, keepdims=True)
    unit /= np.linalg.norm(unit * scale, axis=1, keepdims=True)
    ends = scale * tangent_map(HenonHeiles(), CHAOTIC, time=40.0, step=0.05, deviation_vectors=unit).vectors[:, :, 0]
    start, end = (np.log(np.abs(np.diag(np.linalg.qr(w.T, mode="r")))) for w in (unit * scale, ends))
    np.testing.assert_allclose(found.spectrum[:, 0], np.sort((end - start) / 40.0)[::-1], atol=1e-9)
    assert found.lyapunov[0] == pytest.approx(math.log(np.linalg.norm(ends[0])) / 40.0, abs=1e-11)
    lengths = np.linalg.norm(ends, axis=1)
    assert found.gali_3[0] == pytest.approx((end[:3] - np.log(lengths[:3])).sum() / math.log(10), abs=1e-9)
    again = chaos_map(HenonHeiles(), CHAOTIC, time=40.0, step=0.05, indicators=indicators, deviation_vectors=unit)
    np.testing.assert_allclose(again.values, found.values, atol=1e-9)


def test_an_equilibrium_is_regular_for_every_indicator():
    found = chaos_map(HenonHeiles(), np.zeros(4), time=100.0, step=0.1, indicators=EVERY)
    assert np.isfinite(found.values).all()
    assert not (found.classifications == Classification.CHAOTIC).any()


@pytest.mark.parametrize(
    ("arguments", "problem", "words"),
    [
        ({"indicators": 3.5}, TypeError, "must be a tuple"),
        ({"indicators": ()}, TypeError, "must be a tuple"),
        ({"indicators": (SALI,)}, TypeError, r"Use SALI\(\)"),
        ({"indicators": ("salli",)}, ValueError, "indicators must be one of .*Did you mean sali"),
        ({"indicators": (SALI(), SALI(threshold=-5.0))}, ValueError, "must differ"),
        ({"indicators": (GALI(5),)}, ValueError, r"GALI.count must be from 2 to 4"),
        ({"indicators": (GALI(2.5),)}, TypeError, "GALI.count must be a whole number"),
        ({"indicators": (SALI(threshold=math.nan),)}, ValueError, "SALI.threshold must be finite"),
        ({"indicators": (MEGNO(threshold="2"),)}, TypeError, "MEGNO.threshold must be a real number"),
        ({"indicators": (WeightedBirkhoff(),), "scheme": DOP853, "step": None}, ValueError, "fixed steps"),
        ({"indicators": (ReversibilityError(),), "scheme": fastaff.RK4}, ValueError, "splitting"),
        ({"indicators": (ZeroOneTest(samples=10),)}, ValueError, "ZeroOneTest.samples must be at least 100"),
        ({"indicators": (FrequencyDiffusion(signals=3),)}, TypeError, "signals"),
        ({"indicators": (ZeroOneTest(),), "early_stop": True}, ValueError, "early_stop"),
        ({"history": -1}, ValueError, "history must be at least 0"),
        ({"deviation_vectors": np.eye(4)[:1]}, ValueError, "at least 2 vectors"),
        ({"deviation_vectors": [[1.0, 0, 0, 0], [0, 0, 0, 0]]}, ValueError, "linearly independent"),
        ({"deviation_vectors": [[0.1, 0.3, 0.7, 0], [0.2, 0.6, 1.4, 0]]}, ValueError, "linearly independent"),
        ({"deviation_vectors": np.random.default_rng(1).standard_normal((5, 4))}, ValueError, "at most 4"),
        ({"indicators": (MEGNO(threshold=None),)}, TypeError, "MEGNO.threshold must be a real number"),
        (
            {"indicators": (WeightedBirkhoff(),), "scheme": fastaff.schemes.Automatic((DOP853,)), "step": None},
            ValueError,
            "fixed steps",
        ),
        ({"indicators": (LyapunovSpectrum(),), "deviation_vectors": np.eye(4)[:2]}, ValueError, "at least 4 vectors"),
        ({"time": 0.0}, ValueError, "time must be positive"),
    ],
)
def test_wrong_input_is_refused(arguments, problem, words):
    with pytest.raises(problem, match=words):
        chaos_map(**{"model": HenonHeiles(), "z0": REGULAR, "time": 10.0, "step": 0.1, **arguments})


def test_the_result_names_its_indicators(known):
    with pytest.raises(AttributeError, match="its indicators are lyapunov"):
        _ = known.salli
    assert known.sali is not None


def test_vectors_in_directions_at_rest_are_stable():
    """The orbit moves in alpha alone, slowly; its vectors feel beta's stiff spring, which the step must resolve."""
    from fastaff.systems.models import Oscillator

    body = Body(fastaff.SeparableAlphaBeta(Oscillator(1.0, 1.0), Oscillator(1e4)))
    found = chaos_map(body, [1.3, 0.0, 0.0, 0.0, 0.3, 0.5, 0.0, 0.0], time=100.0)
    assert found.status[0] == Status.OK
    assert found.step <= 0.01
    assert not found.chaotic[0]
    rest = chaos_map(Body(fastaff.Harmonic(C=1e4)), np.zeros(8), time=3.0, indicators=(MEGNO(),))
    assert rest.status[0] == Status.OK
    assert not rest.chaotic[0]


def test_an_orbit_that_collapses_ends_where_it_does():
    """No reading and no record past the end, in steps of a block too."""
    z0 = [0.8, 0.0, 0.75, 0.0, -3.0, 0.0, 3.0, 0.0]
    run = {"time": 30.0, "step": 0.05, "indicators": (MEGNO(),), "history": 30}
    block = np.column_stack([z0, z0])
    found = chaos_map(Body(fastaff.NeoHookean()), block, **run)
    early = chaos_map(Body(fastaff.NeoHookean()), block, early_stop=True, **run)
    assert (found.status != Status.OK).all()
    assert found.t[0] <= early.t[0] + 1.0
    assert np.isnan(found.history[0, found.history_times[:, 0] > found.t[0]]).all()
    assert np.isnan(found.history_times[-1]).all()


def surface(energy, orbits, seed=2):
    section = fastaff.Hyperplane((1.0, 0.0, 0.0, 0.0))
    return fastaff.energy_sample(HenonHeiles(), energy=energy, section=section, orbits=orbits, seed=seed).z0


@cache
def in_units(*units):
    """Regular and chaotic orbits, the same in any units of length, time and mass."""
    z0, own = np.concatenate([surface(0.03, 20), surface(0.16, 12)], axis=1), HenonHeilesInUnits(*units)
    indicators = (FLI(), OFLI(), MEGNO(), SALI(), GALI(3), LyapunovSpectrum(), ReversibilityError(), WeightedBirkhoff())
    return chaos_map(own, own.rows(z0), time=700.0 * own.time, step=0.1 * own.time, indicators=indicators)


@pytest.mark.parametrize("units", [(1e6, 1.0, 1.0), (1.0, 1e-6, 1.0), (1e-6, 1e6, 3e5), (7e3, 3e-2, 1e-6)], ids=str)
def test_units_change_nothing(units):
    """Lengths, times and masses from 1e-6 to 1e6: classifications are the same, and values where chaos magnifies no
    rounding.
    """
    plain, found = (in_units(*given) for given in ((), units))
    own = HenonHeilesInUnits(*units)
    np.testing.assert_array_equal(found.status, plain.status)
    np.testing.assert_array_equal(found.classification, plain.classification)
    assert plain.regular[:20].all()
    assert plain.chaotic[20:].mean() > 0.7
    for name in ("fli", "ofli", "megno", "sali", "gali_3"):
        np.testing.assert_allclose(
            getattr(found, name)[:20], getattr(plain, name)[:20], rtol=0, atol=1e-5, err_msg=name
        )
    np.testing.assert_allclose(found.spectrum[:, :20] * own.time, plain.spectrum[:, :20], rtol=0, atol=1e-7)


def test_the_step_is_the_one_asked_for():
    """Steps of 0.4 and 0.2 give different orbits; one that doesn't divide the time is the nearest shorter one that
    does.
    """
    indicators = (MEGNO(), WeightedBirkhoff(), ZeroOneTest(), ReversibilityError())
    long, short = (chaos_map(HenonHeiles(), BOTH, time=100.0, step=step, indicators=indicators) for step in (0.4, 0.2))
    assert (long.step, short.step) == (0.4, 0.2)
    assert (long.energy_error > 10 * short.energy_error).all()
    assert (long.megno != short.megno).all()
    odd = chaos_map(HenonHeiles(), BOTH, time=10.0, step=0.7, history=3)
    assert odd.step == pytest.approx(10 / 15, rel=1e-15)
    np.testing.assert_allclose(odd.t, 10.0, rtol=1e-15)
    np.testing.assert_allclose(odd.history_times[:, 0], np.array([5, 10, 15]) * 10 / 15)


@pytest.mark.parametrize("start", [CHAOTIC, REGULAR], ids=["chaotic", "regular"])
def test_fli_and_ofli_are_maxima_over_all_steps(start):
    """Against the vector at each of 160 steps, nothing renormalised; a record a radian would miss the crests."""
    model, z, h = HenonHeiles(), np.array(start), 0.05
    scale = scale_of(model, start, 8.0)[:, 0]
    w = symplectic_frame(2, 1) / scale
    fli = ofli = 0.0
    for _ in range(160):
        moved = tangent_map(model, z, time=h, step=h, deviation_vectors=w)
        z, w = moved.z[:, 0], moved.vectors[:, :, 0]
        flow = scale * np.array([*model.velocity(*z[2:]), *model.force(*z[:2])])
        own = scale * w[0]
        fli = max(fli, math.log10(np.linalg.norm(own)))
        ofli = max(ofli, math.log10(np.linalg.norm(own - (own @ flow) / (flow @ flow) * flow)))
    found = chaos_map(model, start, time=8.0, step=h, indicators=(FLI(), OFLI()))
    assert found.fli[0] == pytest.approx(fli, abs=1e-10)
    assert found.ofli[0] == pytest.approx(ofli, abs=1e-10)


def test_without_evidence_the_classification_is_undecided():
    """Two periods say nothing, and the result says how long a run may; sticky or slow orbits get the same word."""
    short = chaos_map(HenonHeiles(), BOTH, time=12.0, step=0.1)
    np.testing.assert_array_equal(short.classification, [Classification.UNDECIDED] * 2)
    assert math.isnan(short.fraction)
    assert (short.suggested_time >= 48.0).all()
    assert "2 undecided" in short.summary()
    longer = chaos_map(HenonHeiles(), BOTH, time=20 * short.suggested_time.max(), step=0.1)
    np.testing.assert_array_equal(longer.classification, [Classification.CHAOTIC, Classification.REGULAR])
    assert np.isnan(longer.suggested_time).all()


REGULAR_SETS = {
    "slow beats": lambda: (HenonHeiles(), surface(0.01, 60)),
    "Henon-Heiles 0.05": lambda: (HenonHeiles(), surface(0.05, 60)),
    "separable quartic": lambda: (quartic(1.3, 0.4, 0.0, 0.7), random_starts(quartic(1.3, 0.4, 0.0, 0.7), 60, 1.0)),
    "hyperelastic": lambda: (
        Body(fastaff.Hyperelastic(1.7), 0.6),
        random_starts(Body(fastaff.Hyperelastic(1.7), 0.6), 60, 1.0),
    ),
}


@pytest.mark.parametrize("make", REGULAR_SETS.values(), ids=REGULAR_SETS)
def test_averages_that_have_not_settled_are_no_evidence_of_chaos(make):
    """At 100 to 200 periods beats cost regular orbits their digits."""
    model, z0 = make()
    for time in (120.0, 900.0):
        found = chaos_map(model, z0, time=time, indicators=(WeightedBirkhoff(), ReversibilityError()))
        assert not (found.classifications == Classification.CHAOTIC).any(), found.summary()


@pytest.mark.slow
@pytest.mark.parametrize("model", [HenonHeiles(), quartic(0.05, 0.08, 2.0, 1.3)], ids=["Henon-Heiles", "x2y2"])
def test_chaotic_orbits_are_seldom_called_regular(model):
    """Truth: MEGNO after ten times the time. At most 2 % of the chaotic ones are called regular, none by all indicators
    at once.
    """
    z0 = surface(0.999 / 6, 200) if isinstance(model, HenonHeiles) else random_starts(model, 200, 1.0)
    truth = chaos_map(model, z0, time=6000.0, indicators=(MEGNO(),), early_stop=True)
    found = chaos_map(model, z0, time=600.0, indicators=(FLI(), OFLI(), MEGNO(), SALI(), GALI(4), WeightedBirkhoff()))
    chaotic = truth.chaotic & (found.status == Status.OK)
    assert chaotic.sum() > 150
    assert (found.regular & chaotic).sum() <= 0.02 * chaotic.sum()
    assert not (found.classifications[:, chaotic] == Classification.REGULAR).all(axis=0).any()
