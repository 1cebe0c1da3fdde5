"""tunes and TuneAccumulator: orbits whose tunes are known, coverage of errors, chunks, ends, company, bad input."""

import itertools
import pickle
from importlib import import_module

import numpy as np
import pytest
from comparison import same
from hypothesis import given, settings
from hypothesis import strategies as st

import fastaff as fa
from fastaff import Classification
from fastaff.engine.jit import JIT_DISABLED
from fastaff.frequencies import TuneSums
from fastaff.frequencies.integer_lattice import ball
from fastaff.frequencies.tune_accumulator import window_of

MANY = 8 if JIT_DISABLED else 400
VECTORS = np.array([(i, j) for i in range(9) for j in range(-8, 9) if 0 < i + abs(j) <= 8])


def apart(rng, orbits, samples):
    """Tunes (2, orbits) of which no low combination is so near an integer that lines hide, or beats are too slow."""
    order = np.abs(VECTORS).sum(axis=1)[:, None]
    width = np.where(order <= 4, min(2 / samples, 0.02), min(2 / samples, 0.002))
    nu = np.empty((2, 0))
    while nu.shape[1] < orbits:
        tried = rng.uniform(0, 1, (2, orbits))
        combined = VECTORS @ tried
        far = (np.abs(combined - np.rint(combined)) > width).all(axis=0)
        nu = np.concatenate([nu, tried[:, far]], axis=1)
    return nu[:, :orbits]


def circles(rng, nu, samples):
    """Rotations (n, orbits, samples) e^(2 pi i (nu t + phase)), phases reduced before they are rounded."""
    turns = nu[..., None] * np.arange(samples) + rng.uniform(size=(*nu.shape, 1))
    return np.exp(2j * np.pi * (turns - np.rint(turns)))


def optics(rng, h):
    """Samples (2n, orbits, samples) of loops h = q - i p as another place of a ring with its own origin shows them."""
    n, orbits, _ = h.shape
    beta, alpha = 10 ** rng.uniform(-2, 3, (n, orbits, 1)), rng.uniform(-3, 3, (n, orbits, 1))
    q = np.sqrt(beta) * h.real
    p = (-h.imag - alpha * h.real) / np.sqrt(beta)
    return np.concatenate([q, p]) + rng.normal(size=(2 * n, orbits, 1))


def coupled(rng, nu, samples):
    """Loops with lines at nu, at 2 nu_i - nu_j and at 3 nu_j, of up to a third of the first."""
    z = circles(rng, nu, samples)
    size = 10 ** rng.uniform(-6, np.log10(0.35), (*nu.shape, 1)) * np.exp(2j * np.pi * rng.uniform(size=(*nu.shape, 1)))
    return optics(rng, z + size * (np.conj(z[::-1]) * z**2 + 0.3 * z[::-1] ** 3))


def sheared(rng, nu, samples):
    """Circles in coordinates that are nonlinear in those of the rotation: all harmonics."""
    z = circles(rng, nu, samples)
    q, p = z.real, -z.imag
    p = p + rng.uniform(-0.6, 0.6, (*nu.shape, 1)) * q * q
    q = q + rng.uniform(-0.3, 0.3, (*nu.shape, 1)) * p * p
    return optics(rng, q - 1j * p)


def distance(one, other):
    d = np.abs(one - other)
    return np.minimum(d, 1 - d)


def twin(z, length):
    """The stored computation in NumPy: mean and moments with the weight, angles about the centre, weighted means."""
    x = (np.arange(length) + 0.5) / length

    def weight(a, b):
        y = np.maximum(1 - (2 * (x - a) / (b - a) - 1) ** 2, 0)
        w = np.where(y > 0, np.exp(30 * (np.sqrt(y) - 1)), 0)
        return w / w.sum()

    q, p = np.split(z[:, : length + 1], 2)
    nu = []
    for one, other in zip(q, p, strict=True):
        w, start = weight(0, 1), (one[0], other[0])
        one, other = one - start[0], other - start[1]
        cut = one[:-1], other[:-1]
        mean = [w @ entry for entry in cut]
        (A, B), (_, D) = np.array([[w @ (a * b) for b in cut] for a in cut]) - np.outer(mean, mean)
        emittance = np.sqrt(A * D - B * B)
        beta, alpha = A / emittance, -B / emittance
        h = (one - mean[0]) - 1j * (alpha * (one - mean[0]) + beta * (other - mean[1]))
        step = h[1:] * h[:-1].conj()
        reference = (w @ step) / abs(w @ step)
        turns = np.angle(step * reference.conj()) / (2 * np.pi)
        nu.append(np.angle(reference) / (2 * np.pi) + np.array([weight(0, 1) @ turns, weight(0, 0.5) @ turns]))
    return np.array(nu)


def test_rotations_by_exact_tunes():
    """In any place of any ring, by mean turns of many samples and lines of few, to rounding; 0.2 is the sense of motion
    in time.
    """
    rng = np.random.default_rng(1)
    for samples in (100, 3000):
        nu = apart(rng, 40, samples)
        found = fa.tunes(optics(rng, circles(rng, nu, samples)))
        assert distance(found.nu, nu).max() < 2e-15
        assert (distance(found.nu, nu) <= found.error).all()
        assert found.diffusion.max() < -14
        assert distance(found.signed % 1, nu).max() < 2e-15
        assert (found.method == 1).all() if samples == 100 else (found.method == 0).any()
    assert found.error.max() < 1e-8
    assert (found.classification == Classification.REGULAR).all()
    t = 0.01 * np.arange(1000)
    later = fa.tunes(np.array([np.cos(0.2 * np.pi * t), -np.sin(0.2 * np.pi * t)]))  # of H = 0.1 pi (q^2 + p^2)
    assert later.signed[0, 0] == pytest.approx(0.001, abs=later.error[0, 0])


@pytest.mark.parametrize("make", [coupled, sheared])
@pytest.mark.parametrize("samples", [64, 100, 300, 1000, 3000, 10000])
def test_errors_cover_the_truth(make, samples):
    rng = np.random.default_rng(samples)
    nu = apart(rng, min(MANY, 2_000_000 // samples), samples)
    z = make(rng, nu, samples)
    found = fa.tunes(z)
    running = fa.TuneAccumulator()
    running.push(z)
    for result in (found, running.tunes()):
        known = np.isfinite(result.error)
        ratio = (distance(result.nu, nu) / result.error)[known]
        assert (ratio <= 1).sum() >= 0.99 * ratio.size
        assert (ratio <= 10).all()
    assert np.isfinite(found.error).all()
    assert np.median(found.error) < (1e-6 if samples < 100 else 1e-12)


@pytest.mark.parametrize("samples", [300, 2000])
def test_errors_cover_the_truth_next_to_resonances(samples):
    """Two planes that modulate each other, at distances from a |k| <= 5 that the window does not resolve."""
    rng = np.random.default_rng(samples)
    k = np.array([(1, -1), (2, -1), (1, -2), (3, -2), (1, -3), (1, 1), (2, 1)])[rng.integers(0, 7, MANY)]
    beat = 10 ** rng.uniform(-4, 0.5, MANY) / samples
    nu = rng.uniform(0.1, 0.4, MANY)
    nu = np.array([nu, (np.rint(k @ [0.25, 0.25]) + beat - k[:, 0] * nu) / k[:, 1] % 1.0])
    theta = 2 * np.pi * (nu[:, :, None] * np.arange(samples) + rng.uniform(0, 1, nu.shape)[:, :, None])
    size = 1 + 0.1 * np.cos(theta[::-1])
    found = fa.tunes(np.concatenate([size * np.cos(theta), -np.sin(theta)]))
    ratio = distance(found.nu, nu) / found.error
    assert (ratio <= 1).mean() > 0.99
    assert (ratio <= 10).all()


def test_the_stored_computation_is_what_it_says():
    rng = np.random.default_rng(3)
    z = sheared(rng, apart(rng, 5, 5000), 5000)
    found = fa.tunes(z)
    assert (found.method == 0).all()
    for k in range(5):
        whole, first = twin(z[:, k], 4999).T
        assert distance(found.nu[:, k], whole % 1).max() < 1e-14
        assert np.isfinite(first).all()


def henon(start, turns, tune=0.2114):
    """Orbits (2, orbits, turns) of Henon's area-preserving map."""
    c, s = np.cos(2 * np.pi * tune), np.sin(2 * np.pi * tune)
    x, p = np.array(start, float)
    out = np.empty((2, x.size, turns))
    for t in range(turns):
        out[:, :, t] = x, p
        kick = p + x * x
        x, p = c * x + s * kick, -s * x + c * kick
    return out


def test_a_batch_reports_shares_of_itself(monkeypatch):
    """Shares of one portion of memory, in order: a line of progress has a pace."""
    monkeypatch.setattr(import_module("fastaff.frequencies.tunes"), "TOLD", 2**12)
    turn, told = 2 * np.pi * np.linspace(0.1, 0.4, 24)[:, None] * np.arange(2**10), []
    samples = np.array([np.cos(turn), -np.sin(turn)])
    samples[:, 3, 2**9 :] = np.nan
    found = fa.tunes(samples, threads=2, callback=told.append)
    assert len(told) > 6
    assert told == sorted(told)
    assert told[-1] == 1.0
    monkeypatch.undo()
    same(found, fa.tunes(samples, threads=1))


def test_henon_map_against_longer_runs_and_high_precision():
    """The tune at vanishing amplitude is that of the linear map; errors cover what a record 16 times as long says."""
    import mpmath

    start = np.linspace(0.02, 0.45, 40), np.zeros(40)
    long = henon(start, 32768)
    best, brief = fa.tunes(long), fa.tunes(long[:, :, :2048])
    regular = best.regular & brief.regular
    assert regular.sum() >= 36
    assert (distance(best.nu, brief.nu) <= best.error + brief.error)[:, regular].mean() >= 0.99
    tiny = fa.tunes(henon((np.array([1e-7]), np.zeros(1)), 2048))
    assert tiny.nu[0, 0] == pytest.approx(0.2114, abs=1e-14)
    with mpmath.workdps(40):
        c, s = mpmath.cospi(2 * mpmath.mpf(0.2114)), mpmath.sinpi(2 * mpmath.mpf(0.2114))
        x, p, path = mpmath.mpf(0.25), mpmath.mpf(0), []
        for _ in range(2048):
            path.append((float(x), float(p)))
            kick = p + x * x
            x, p = c * x + s * kick, -s * x + c * kick
    exact = fa.tunes(np.array(path).T)
    nearest = fa.tunes(henon((np.array([0.25]), np.zeros(1)), 2048))
    assert distance(exact.nu, nearest.nu)[0, 0] <= exact.error[0, 0] + nearest.error[0, 0]


def test_a_plane_that_shows_another_planes_line():
    """Where coupling is stronger than a plane's own line its loop turns with the other, which the lines of both undo;
    what arrives in parts has no lines: undecided.
    """
    rng = np.random.default_rng(4)
    z = circles(rng, np.array([[0.2317, 0.31], [0.1721, 0.4]]), 4000)
    h = z + np.array([0.2, 3.0])[:, None, None] * z[::-1]
    samples = optics(rng, h)
    found = fa.tunes(samples)
    assert distance(found.nu, np.array([[0.2317, 0.31], [0.1721, 0.4]])).max() < 1e-10
    assert (found.classification == Classification.REGULAR).all()
    found = pushed(samples, 4000)
    assert distance(found.nu, np.array([[0.2317, 0.31], [0.2317, 0.31]])).max() < 1e-10
    assert (found.classification == Classification.UNDECIDED).all()
    assert (found.error >= 1 / found.window).all()
    equal = fa.tunes(optics(rng, z + 0.99 * z[::-1] * np.array([1.0, 0.0])[:, None, None]))
    assert (distance(equal.nu, np.array([[0.2317, 0.31], [0.1721, 0.4]])) <= equal.error).all()


@pytest.mark.parametrize("angle", [np.pi / 4, None])
@pytest.mark.parametrize("n", [2, 3])
def test_modes_of_coupled_planes(n, angle):
    """Quadratic maps that know nothing of each other, seen in turned coordinates: their own tunes, each once."""
    if n == 3 and angle is not None:
        return
    rng = np.random.default_rng([21, n, angle is None])
    count, turns = 10 if JIT_DISABLED else 500, 1024
    nu = rng.uniform(0.05, 0.95, (n, count))
    c, s = np.cos(2 * np.pi * nu), np.sin(2 * np.pi * nu)
    (u, p), own = rng.uniform(-0.2, 0.2, (2, n, count)), np.empty((2, n, count, turns))
    with np.errstate(all="ignore"):
        for t in range(turns):
            own[:, :, :, t] = u, p
            kick = p + u * u
            u, p = c * u + s * kick, c * kick - s * u
    own = own[:, :, np.isfinite(own).all(axis=(0, 1, 3))]
    truth = fa.tunes(own.reshape(2 * n, -1, turns))
    clear = (truth.classification == Classification.REGULAR) & (truth.error < 1e-8).all(axis=0)
    for i, j in itertools.combinations(range(n), 2):
        low = VECTORS[np.abs(VECTORS).sum(axis=1) <= 4] @ truth.nu[[i, j]]
        clear &= (np.abs(low - np.rint(low)) > 3 / turns).all(axis=0)
    if n == 3:
        low = ball(3, 5)[1:] @ truth.nu
        clear &= (np.abs(low - np.rint(low)) > 3 / turns).all(axis=0)
    truth, own = truth.take(np.flatnonzero(clear)), own[:, :, clear]
    assert JIT_DISABLED or clear.sum() > 150
    turn = np.linalg.qr(rng.normal(size=(clear.sum(), n, n)))[0]
    if angle is not None:
        turn[:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    found = fa.tunes(np.einsum("oij,rjot->riot", turn, own).reshape(2 * n, -1, turns))
    assert (found.classification == Classification.REGULAR).mean() >= 0.99
    orders = np.array([*itertools.permutations(range(n))])
    off, error = distance(found.nu, truth.nu[orders]), truth.error[orders] + found.error
    off, error = off.transpose(2, 0, 1), error.transpose(2, 0, 1)
    best = off.max(axis=2).argmin(axis=1)
    ratio = np.array([each[k] / width[k] for each, width, k in zip(off, error, best, strict=True)])
    assert (ratio <= 1).mean() >= 0.99
    assert np.median(found.error) < 1e-10
    few = fa.resonances(found, max_order=3)
    assert (few.rank == 0).mean() > 0.98


def test_a_plane_driven_harder_than_it_moves_by_itself():
    """Its loop passes through its centre; its own line is the strongest that is no combination of the other's tune."""
    rng = np.random.default_rng(14)
    nu = np.array([[0.2831, 0.1234], [0.3123, 0.4071]])
    z = circles(rng, nu, 3000)
    for own in (1.0, 0.4):
        for driven in (z[1] ** 2, np.conj(z[1] ** 2), z[1] + 0.9 * np.conj(z[1] ** 2)):
            found = fa.tunes(optics(rng, np.array([own * z[0] + driven, z[1]])))
            clear = distance(found.nu, nu) < 1e-9
            assert clear[1].all()
            assert (clear[0] | (found.classification == Classification.RESONANT)).all()


def test_a_line_plus_a_combination_of_the_others_tune_is_no_own_line():
    """Of x beside the drive 2 nu_y of a sextupole: weak lines nu_x + 2 nu_y have all others as their harmonics too."""
    rng = np.random.default_rng(7)
    nu = rng.uniform(0.05, 0.45, (2, 30))
    a, b = circles(rng, nu, 2000)
    driven = rng.uniform(0.7, 1.3, (30, 1)) * (0.81 * np.conj(b * b) + 0.17 * b * b)
    weak = 3.5e-3 * a * b * b + 1.1e-3 * np.conj(a * b * b) + 1.1e-3 * np.conj(a * a) + 1e-3 * np.conj(a * b) ** 2
    h = np.array([a + driven + 0.089 * np.conj(a) + weak, 20 * b])
    assert (distance(fa.tunes(np.concatenate([h.real, -h.imag])).nu, nu) < 1e-9).all()


def test_a_plane_at_rest_and_changing_tunes():
    rng = np.random.default_rng(5)
    z = np.concatenate([circles(rng, np.array([[0.2317]]), 1000).real, np.zeros((1, 1, 1000))])
    z = np.concatenate([z, [-circles(np.random.default_rng(5), np.array([[0.2317]]), 1000).imag[0]], 0 * z[:1]])
    for found in (fa.tunes(z), pushed(z, 1000)):
        assert found.error[1, 0] == np.inf
        assert np.isnan(found.nu[1, 0])
        assert found.classification[0] == Classification.RESONANT
        assert distance(found.nu[0, 0], 0.2317) < 1e-13
    t = np.arange(4000)
    turns = 0.2 * t + 0.01 * t**2 / 4000
    drifting = np.array([np.cos(2 * np.pi * turns), -np.sin(2 * np.pi * turns)])
    found = fa.tunes(drifting)
    assert found.classification[0] == Classification.IRREGULAR
    assert found.diffusion[0] == pytest.approx(np.log10(0.01), abs=0.05)
    assert not found.regular[0]


def test_a_plane_that_only_follows_a_harmonic_of_another_is_dependent():
    """Rotations of two planes, the second kicked by k x^2 and begun where it has no motion of its own."""
    rng = np.random.default_rng(15)
    text = "b = p_y + k*x**2; x1 = c*x + s*p_x; p_x1 = c*p_x - s*x; y1 = d*y + e*b; p_y1 = d*b - e*y"
    for _ in range(3):
        mu, k, phase = 2 * np.pi * rng.uniform([0.1, 0.35], [0.2, 0.45]), 0.3, 2 * np.pi * rng.random(10)
        size = rng.uniform(0.1, 1.0, 10)
        u, turn = size * np.exp(1j * phase), np.exp(-1j * mu[1])
        # w = y + i p_y becomes turn (w + i k x^2), x = Re u, of which u turns by exp(-i mu_x).
        kick = 1j * turn * k * size**2 / 4
        w = 2 * kick / (1 - turn) + kick * np.exp(2j * phase) / (np.exp(-2j * mu[0]) - turn)
        w += kick * np.exp(-2j * phase) / (np.exp(2j * mu[0]) - turn)
        model = fa.iterated_map(text, c=np.cos(mu[0]), s=np.sin(mu[0]), d=np.cos(mu[1]), e=np.sin(mu[1]), k=k)
        z = np.array([u.real, w.real, u.imag, w.imag])
        for found in (fa.frequency_map(model, z, time=2000), fa.tunes(fa.integrate(model, z, time=2000, samples=2000))):
            apart = found.nu[1] + np.array([[-2], [2]]) * mu[0] / (2 * np.pi)
            assert np.abs(apart - np.rint(apart)).min(axis=0).max() < 1e-9
            assert (found.classification == Classification.RESONANT).all()


def test_orbits_seen_to_be_chaotic_are_spared_lines_and_change_no_others(monkeypatch):
    """Two planes with a kick that is bounded, and random tunes: a sea, and islands whose bits stay what they were."""
    from fastaff.frequencies import tunes as module

    rng = np.random.default_rng(16)
    text = (
        "a = p_x - K*x/(1 + x**2 + 2*y**2); b = p_y - 3*K*y/(1 + x**2 + 2*y**2)**2;"
        "x1 = c*x + s*a; p_x1 = c*a - s*x; y1 = d*y + e*b; p_y1 = d*b - e*y"
    )
    turn = 2 * np.pi * (0.25 + 0.08 * rng.uniform(-1, 1, 2))
    model = fa.iterated_map(text, K=0.6, c=np.cos(turn[0]), s=np.sin(turn[0]), d=np.cos(turn[1]), e=np.sin(turn[1]))
    z = np.concatenate([rng.uniform(-1.5, 1.5, (4, 40)), rng.uniform(-0.1, 0.1, (4, 20))], axis=1)
    samples = fa.integrate(model, z, time=1024, samples=1024).samples.transpose(1, 2, 0)
    classification = fa.chaos_map(model, z, time=8192).classification
    spared = fa.tunes(samples)
    with monkeypatch.context() as patch:
        patch.setattr(module, "restless", lambda f, halves, length: np.zeros(len(f), bool))
        fitted = fa.tunes(samples)
    calm = classification == 0
    assert 10 < calm.sum() < 50
    same(spared.take(np.flatnonzero(calm)), fitted.take(np.flatnonzero(calm)))
    off = (spared.nu != fitted.nu).any(axis=0)
    assert off.any()
    beside = (spared.classification == Classification.UNDECIDED) & (spared.window / 2 * 10.0**spared.diffusion <= 3.0)
    assert (beside | (spared.classification == Classification.IRREGULAR))[off].all()
    assert (spared.method[:, ~calm].sum(axis=0) == 0).mean() > 0.7


def test_crescents_by_their_lines():
    """Loops beside their centre, as the islands of a chain that is seen every few turns: their mean turn is 0, their
    tune that of the line, in the sense of the area; also with another plane's line in them, and where they jump across
    the centre from turn to turn. An arc that goes back along itself has no sense, and stays undecided.
    """
    rng = np.random.default_rng(17)
    count, samples = 16 if JIT_DISABLED else 120, 2000
    nu = apart(rng, 20 * count, samples)
    parts = np.arange(1, 17)[:, None] * nu[0]
    nu = nu[:, (np.abs(parts - np.rint(parts)) > 8 / samples).all(axis=0)]  # lines apart from each other
    slow = np.minimum(nu[0], 1 - nu[0])
    nu = np.concatenate([nu[:, slow < 0.14][:, : count // 2], nu[:, slow > 0.14][:, : count // 2]], axis=1)
    z = circles(rng, nu, samples)
    w = np.angle(z[0])
    wide, open_ = rng.uniform(1.6, 2.9, (count, 1)), rng.uniform(0.1, 0.4, (count, 1)) * rng.choice([-1, 1], (count, 1))

    def bow(w):
        return (1 + open_ * np.cos(w)) * np.exp(1j * (wide * np.sin(w)))

    curve = bow(np.linspace(0, 2 * np.pi, 2001))
    middle, chord = (curve[:, 1:] + curve[:, :-1]) / 2, np.diff(curve, axis=1)
    sense = np.sign((middle.conj() * chord).imag.sum(axis=1))
    assert {-1.0, 1.0} == {*sense}
    for share in (0.0, 0.04):
        found = fa.tunes(optics(rng, np.array([bow(w) + share * z[1], z[1]])))
        truth = np.array([(sense * nu[0]) % 1, nu[1]])
        decided = found.classification == Classification.REGULAR
        assert decided.mean() > 0.9
        within = distance(found.nu, truth) <= found.error
        assert within[:, decided & (np.arange(count) < count // 2)].all()
        assert within[:, decided].mean() > 0.95
        assert (found.method[0, decided & (np.arange(count) < count // 2)] == 1).all()
        assert np.median(found.error[0]) < 1e-8
    arc = fa.tunes(optics(rng, np.exp(1j * wide * np.sin(w))[None])[:, : count // 2])
    assert (arc.classification == Classification.UNDECIDED).mean() > 0.9


def test_crescents_of_the_standard_map():
    """A libration about the resonance of tune 1/2 in every second turn, the pendulum's in the plane of sin x and p: the
    same frequency as in the plane about its centre.
    """
    K = np.random.default_rng(18).uniform(0.7, 1.1)
    p = np.linspace(0.6, 1.2, 5)
    samples = fa.integrate(fa.models.StandardMap(K), [np.full(5, np.pi), p], time=4000, samples=4000).samples
    x, p = samples.transpose(1, 2, 0)
    plain = fa.tunes([np.mod(x, 2 * np.pi), p])
    bent = (2.5 + p) * np.exp(1j * 1.3 * (np.mod(x, 2 * np.pi) - np.pi))
    found = fa.tunes([bent.real, bent.imag])
    known = (found.classification == Classification.REGULAR) & (plain.classification == Classification.REGULAR)
    assert known.sum() >= 3
    off = np.minimum(distance(found.nu, plain.nu), distance(found.nu, 1 - plain.nu))
    assert (off <= found.error + plain.error)[:, known].all()


def test_lines_of_planes():
    """Frequencies, amplitudes in the units of Q and phases at the first sample of lines that are known; the numbers of
    `orbit_frequencies` where samples are dense, of `frequency_map` from the first turn on.
    """
    rng = np.random.default_rng(19)
    count, samples = 8 if JIT_DISABLED else 50, 3000
    nu = apart(rng, count, samples)
    z = circles(rng, nu, samples)
    small = rng.uniform(0.01, 0.3, (2, count, 1))
    h = np.array([z[0] + small[0] * z[1], z[1] + small[1] * z[0].conj()])
    unit = 10.0 ** rng.uniform(-8, 8, (4, 1, 1))
    found = fa.tunes(np.concatenate([h.real, -h.imag]) * unit, lines=2)
    truth = np.array([[nu[0], nu[1]], [nu[1], -nu[0]]])
    lines = found.lines
    assert lines.names == found.names
    assert lines.nu.shape == (2, 2, count)
    assert (distance(lines.nu % 1, truth % 1) <= lines.error + 2e-16).mean() >= 0.99
    assert np.abs(lines.nu).max() <= 0.5
    size = np.array([[np.ones(count), small[0, :, 0]], [np.ones(count), small[1, :, 0]]]) * unit[:2]
    first = np.array([[z[0, :, 0], z[1, :, 0]], [z[1, :, 0], z[0, :, 0].conj()]])
    assert np.abs(lines.amplitude / (size * first / np.abs(first)) - 1).max() < 1e-3
    same(found.take([4, 1]).lines.nu, lines.nu[:, :, [4, 1]])
    assert fa.tunes(RECORD).lines is None
    assert (fa.tunes(RECORD, lines=3).lines.error[:, :, [4, 6]] == np.inf).all()
    slow = optics(rng, circles(rng, nu * 0.05, samples))
    same(fa.tunes(slow, lines=3, threads=1).lines, fa.orbit_frequencies(slow, 1.0, lines=3).lines)
    model, start = fa.models.HenonMap(rng.uniform(0.1, 0.4)), [[0.1, 0.2], [0.0, 0.1]]
    path = fa.integrate(model, start, time=1000, samples=1000).samples.transpose(1, 2, 0)
    own = fa.frequency_map(model, start, time=1000, lines=3).lines
    later = fa.tunes(path, lines=3, coordinates=("x", "p")).lines
    same(later.nu, own.nu)
    np.testing.assert_allclose(later.amplitude, own.amplitude * np.exp(2j * np.pi * own.nu), rtol=1e-9)
    for scale in (1e-170, 1e170):  # whose squares are no numbers
        beyond = fa.tunes(slow[:, :3] * scale, lines=2)
        np.testing.assert_allclose(beyond.nu, fa.tunes(slow[:, :3]).nu, rtol=1e-12)
        assert np.isfinite(beyond.lines.amplitude).all()
    with pytest.raises(ValueError, match="lines must be at least 1, got 0"):
        fa.tunes(RECORD, lines=0)


def test_many_planes_whose_lines_are_looked_at(two_threads):
    """Twelve planes, one of them driven by the next one's square: combinations of the others' tunes are a table."""
    rng = np.random.default_rng(20)
    nu = rng.uniform(0.05, 0.45, (12, 3))
    z = circles(rng, nu, 1000)
    z[0] = 0.4 * z[0] + z[1] ** 2
    found = fa.tunes(optics(rng, z))
    assert (distance(found.nu, nu) <= found.error)[1:].all()
    assert ((distance(found.nu, nu) < 1e-6)[0] | (found.classification != Classification.REGULAR)).all()


# --- the accumulator -------------------------------------------------------------------------------------------------


def pushed(z, *sizes, **given):
    running, at = fa.TuneAccumulator(**given), 0
    for size in sizes:
        running.push(z[:, :, at : at + size])
        at += size
    return running.tunes()


def close(one, other):
    """Equal to the rounding of sums; what is at rounding is 0."""
    np.testing.assert_allclose(10**one.diffusion, 10**other.diffusion, rtol=0, atol=1e-14)
    finite = np.isfinite(one.error)
    assert distance(one.nu, other.nu)[finite].max(initial=0.0) < 1e-14
    assert (finite == np.isfinite(one.nu)).all()
    assert (finite == np.isfinite(other.nu)).all()
    assert (finite == np.isfinite(other.error)).all()
    assert np.abs(one.error[finite] - other.error[finite]).max(initial=0) < 1e-13
    for name in ("turns", "window", "status", "classification"):
        assert (getattr(one, name) == getattr(other, name)).all(), name


RECORD = coupled(np.random.default_rng(6), apart(np.random.default_rng(6), 20, 2500), 2500)
RECORD[:, 3, 1700:] = np.nan
RECORD[:, 4, 40:] = np.inf
RECORD[2, 5, 129:] = np.nan
RECORD[:, 6] = np.nan


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=60))
def test_any_chunks_give_the_stored_value(sizes):
    count = min(sum(sizes), 2500)
    close(pushed(RECORD, *sizes), pushed(RECORD, count))


def test_windows_are_averages_of_their_steps():
    """The last complete window against its stored twin, which knows nothing of windows before it."""
    found = pushed(RECORD, 2500)
    assert list(found.window[:7]) == [1024, 1024, 1024, 512, 0, 64, 0]
    assert list(found.turns[:7]) == [2500, 2500, 2500, 1700, 40, 129, 0]
    assert list(found.status[:7]) == [0, 0, 0, 1, 1, 1, 1]
    for k in (0, 1, 2, 7, 8):
        own, _ = twin(RECORD[:, k, 1024:2049], 1024).T
        assert (distance(found.nu[:, k], own % 1) <= found.error[:, k]).all()
    assert (found.error[:, [4, 6]] == np.inf).all()
    assert window_of(31)[:2] == (0, 32)
    assert window_of(32)[:2] == (32, 32)
    assert window_of(2**40 + 5)[:2] == (2**40, 2**40)


def test_an_orbit_keeps_what_is_known_up_to_its_last_turn():
    """What comes after its end changes nothing; a window is complete with the sample after its last step."""
    before = pushed(RECORD[:, :, :1700], 1700)
    after = pushed(RECORD, 2500)
    for name in ("nu", "error", "diffusion", "turns", "window"):
        same(getattr(before.take(3), name), getattr(after.take(3), name))
    whole = RECORD[:, :3]
    assert list(pushed(whole, 1024).window) == [256] * 3
    assert list(pushed(whole, 1025).window) == [512] * 3


@pytest.mark.parametrize("sizes", [(2500,), (700, 1, 1799)])
def test_bits_do_not_depend_on_company_or_threads(sizes, two_threads):
    together = pushed(RECORD, *sizes, threads=1)
    same(pushed(RECORD, *sizes, threads=2), together)
    for chosen in ([0], [3], [7, 4, 19], [*range(19, -1, -1)]):
        same(pushed(RECORD[:, chosen], *sizes), together.take(chosen))


def test_layouts_have_the_same_bits():
    together, stored = pushed(RECORD, 2500), fa.tunes(RECORD)
    for other in (np.asfortranarray(RECORD), np.moveaxis(np.ascontiguousarray(np.moveaxis(RECORD, 2, 0)), 0, 2)):
        kept = other.copy()
        same(pushed(other, 2500), together)
        same(fa.tunes(other), stored)
        same(np.ascontiguousarray(other), np.ascontiguousarray(kept))
    small = RECORD[:, :3].astype(np.float32)
    same(fa.tunes(small), fa.tunes(small.astype(float)))
    same(pushed(small, 2500), pushed(small.astype(float), 2500))


def test_it_goes_on_after_a_pickle_a_file_and_in_parts(tmp_path):
    whole = fa.TuneAccumulator(("x", "y", "px", "py"))
    whole.push(RECORD[:, :, :777])
    again = pickle.loads(pickle.dumps(whole))
    stored = fa.TuneAccumulator.of(fa.load(fa.save(tmp_path / "tunes", whole.state)))
    parts = []
    for chosen in (slice(None, 9), slice(9, None)):
        part = fa.TuneAccumulator("x y px py")
        part.push(RECORD[:, chosen, :777])
        parts.append(part.state)
    joined = fa.TuneAccumulator.of(TuneSums.concat(parts))
    for each in (whole, again, stored, joined):
        assert each.samples == 777
        each.push(RECORD[:, :, 777:])
    for each in (again, stored, joined):
        same(each.tunes(), whole.tunes())
        same(each.state, whole.state)
    assert whole.tunes()["x"].shape == (20,)
    assert repr(whole) == "TuneAccumulator: 20 orbits, 2500 turns"


def test_memory_does_not_grow():
    running = fa.TuneAccumulator()
    sizes = []
    for _ in range(4):
        running.push(RECORD[:, :3, :1000])
        sizes.append(sum(getattr(running.state, name).nbytes for name in ("last", "planes", "sums", "moments", "nu")))
    assert len(set(sizes)) == 1


def test_a_push_is_whole_or_has_not_been(monkeypatch):
    from fastaff.frequencies import turning

    running = fa.TuneAccumulator()
    running.push(RECORD[:, :, :500])
    before, own, count = running.state, turning.launch, [0]

    def launch(*arguments):
        count[0] += 1
        if count[0] == 3:
            raise KeyboardInterrupt
        own(*arguments)

    monkeypatch.setattr(turning, "launch", launch)
    with pytest.raises(KeyboardInterrupt):
        running.push(RECORD[:, :, 500:])
    same(running.state, before)
    monkeypatch.setattr(turning, "launch", own)
    running.push(RECORD[:, :, 500:])
    same(running.tunes(), pushed(RECORD, 500, 2000))


def test_bad_pushes_are_named_and_change_nothing():
    running = fa.TuneAccumulator()
    with pytest.raises(ValueError, match="samples must be pushed first"):
        running.tunes()
    running.push(RECORD[:, :4, :100])
    before = running.state
    gap = RECORD[:, :4, 100:200].copy()
    gap[1, 2, 7] = np.nan
    for bad, said in (
        (gap, "samples must have no gaps: orbit 2 is not finite at sample 107 and goes on at sample 108"),
        (RECORD[:, :3, 100:200], r"samples must have 4 rows of 4 orbits, as before, got shape \(4, 3, 100\)"),
        (RECORD[:3, :4, :10], "coordinates must be 3 names|must have 2n rows"),
    ):
        with pytest.raises(ValueError, match=said):
            running.push(bad)
        same(running.state, before)
    running.push(RECORD[:, :4, :0])
    same(running.state, before)
    with pytest.raises(ValueError, match="samples must have at least 1 samples"):
        fa.TuneAccumulator().push(RECORD[:, :4, :0])
    with pytest.raises(TypeError, match="samples must be real rows"):
        running.push(RECORD[:, :4].astype(complex))
    ended = RECORD[:, :4, 100:200].copy()
    ended[:, 1, 30:] = np.nan
    running.push(ended)
    with pytest.raises(ValueError, match="orbit 1 is not finite at sample 130 and goes on at sample 200"):
        running.push(RECORD[:, :4, 200:300])
    with pytest.raises(TypeError, match="state must be a TuneSums, got dict"):
        fa.TuneAccumulator.of({})


def test_resonances_of_tunes_count_the_turn():
    rng = np.random.default_rng(15)
    nu = np.array([[1 / 3 + 1e-15, 0.2, 0.3317, 0.25 * np.sqrt(2)], [0.1234, 0.3, 0.3366 / 2, 0.1111]])
    nu[1, 2] = 1 - 2 * nu[0, 2]
    nu[0, 1], nu[1, 1] = 0.31, 0.5 - 0.31
    found = fa.resonances(fa.tunes(optics(rng, circles(rng, nu, 4000))), max_order=6)
    assert found.label(0) == "3 Q_q1 = 1"
    assert found.label(1) == "2 Q_q1 + 2 Q_q2 = 1"
    assert found.label(2) == "2 Q_q1 + Q_q2 = 1"
    assert found.label(3) == "no resonance up to order 6"


def test_digits_of_averages_tell_order_from_chaos():
    """Of a map, of its iterates as arrays, and of samples in time, in any unit."""
    model = fa.models.maps.StandardMap(0.9)
    z0 = np.array([[np.pi + 0.5, np.pi + 1.0, 0.05], [0.0, 0.0, 0.05]])
    whole = fa.frequency_map(model, z0, time=8000)
    assert (whole.digits[:2] > 9).all()
    assert whole.digits[2] < 5
    path = fa.integrate(model, z0[:, :2], time=8000, samples=8000).samples.transpose(1, 2, 0)
    found = fa.tunes(np.array([path[0] % (2 * np.pi), path[1]]))
    assert (found.digits > 9).all()
    body = fa.HenonHeiles()
    orbits = fa.integrate(body, [[0.0, 0.0], [0.1, -0.15], [0.3, 0.5], [0.05, 0.1]], time=3000.0, samples=20000)
    one = fa.orbit_frequencies(orbits)
    other = fa.orbit_frequencies(orbits.samples.transpose(1, 2, 0), 1e4 * (orbits.times[1] - orbits.times[0]))
    assert one.digits[0] > 9 > 4 > one.digits[1]
    np.testing.assert_allclose(one.digits[1], other.digits[1], atol=1e-3)


# --- orbits that are lost ---------------------------------------------------------------------------------------------

FILLED = ["zeros", "frozen", "sentinel"]
"""What trackers write behind a lost particle."""


def lost(rng, fill, n, samples):
    """Orbits (2n, orbits, samples) of known tunes, all but each third lost at some turn; tunes, turns that they live,
    and which of them end.
    """
    orbits = 36
    nu = np.concatenate([apart(rng, orbits, samples) for _ in range(n)])[:n]
    z = optics(rng, circles(rng, nu, samples))
    life = np.where(np.arange(orbits) % 3 > 0, rng.integers(1, samples - 1, orbits), samples)
    life[1::6] = samples - rng.integers(2, 9, life[1::6].size)  # near the end, where weights hide it
    for k in np.flatnonzero(life < samples):
        last = z[:, k, [life[k] - 1]]
        z[:, k, life[k] :] = {"zeros": 0.0, "frozen": last, "sentinel": rng.choice([-1.0, 999.0, 1e30])}[fill]
    return z, nu, life - (fill == "frozen") * (life < samples), life < samples


@pytest.mark.parametrize("fill", FILLED)
@pytest.mark.parametrize("samples", [64, 300, 1024])
def test_a_tail_of_one_point_is_an_end(fill, samples):
    rng = np.random.default_rng([samples, FILLED.index(fill)])
    for n in (1, 3):
        z, nu, life, gone = lost(rng, fill, n, samples)
        found, running = fa.tunes(z), fa.TuneAccumulator()
        for part in np.split(z, np.sort(rng.integers(1, samples, 5)), axis=2):
            running.push(part)
        for result in (found, running.tunes(), pushed(z, samples)):
            np.testing.assert_array_equal(result.turns, life)
            np.testing.assert_array_equal(result.status, np.where(gone, fa.Status.LOST, fa.Status.OK))
            known = np.isfinite(result.error)
            assert (known.all(axis=0) <= (life >= 64)).all()
            assert (distance(result.nu, nu) <= result.error)[known].sum() >= 0.99 * known.sum()
            assert (distance(result.nu, nu) <= 10 * result.error)[known].all()
            assert f"{gone.sum()} LOST (" in result.summary()
        assert (np.isfinite(found.error).all(axis=0) == (life >= 64)).all()
        again = fa.tunes(np.where(np.arange(samples) < life[:, None], z, np.nan))
        for name in ("nu", "error", "turns", "window", "classification"):
            same(getattr(again, name), getattr(found, name))
        slow = fa.orbit_frequencies(z, 1.0)
        np.testing.assert_array_equal(slow.status == fa.Status.LOST, gone & (slow.status != fa.Status.NOT_CONVERGED))


def test_what_does_not_move_or_moves_in_ticks_is_not_lost():
    """Fixed points, planes at rest, and whole numbers as of a detector, in which neighbours are often equal."""
    rng = np.random.default_rng(3)
    z = optics(rng, circles(rng, apart(rng, 30, 500), 500))
    z[:, 0], z[:, 1] = 0.0, 1.5
    z[[0, 2], 2] = 0.0
    z[:, 3, -1] = 0.0  # one sample is no tail
    assert (fa.tunes(z).status == fa.Status.OK).all()
    assert (pushed(z, 100, 1, 399).status == fa.Status.OK).all()
    nu = rng.uniform(0.01, 0.5, 400)
    ticks = np.rint(rng.uniform(3, 30, (1, 400, 1)) * circles(rng, nu[None], 1000))
    found = fa.tunes(np.concatenate([ticks.real, -ticks.imag]))
    assert (found.status == fa.Status.OK).mean() > 0.97
    assert (distance(found.nu[0], nu) < 1e-3).all()


def test_what_has_no_tune_is_no_regular_orbit():
    """Most of a grid leaves Henon's map, after 64 turns or more some of it; what stays far away after its end, by the
    map itself or by its samples, has no tune and no diffusion; what lived long enough has the numbers of its life.
    """
    grid = np.linspace(-1.4, 1.4, 12 if JIT_DISABLED else 40)
    z0 = np.array([each.ravel() for each in np.meshgrid(grid, grid)])
    model, turn = fa.models.HenonMap(np.random.default_rng(8).uniform(0.205, 0.215)), 2 * np.pi * 0.2114
    # within a circle a turn with a kick, outside an attracting point far away
    inside = "w = 1/(1 + exp(50*(x**2 + p**2 - 1))); k = p + 0.3*x**2;"
    bounded = fa.iterated_map(
        inside + "x1 = w*(c*x + s*k) + (1 - w)*(5 + 0.5*(x - 5)); p1 = w*(c*k - s*x) + (1 - w)*(4 + 0.5*(p - 4))",
        c=np.cos(turn),
        s=np.sin(turn),
    )
    for body in (model, bounded):
        samples = fa.integrate(body, z0, time=1024, samples=1024).samples.transpose(1, 2, 0)
        gone = ~(np.abs(samples[:, :, -40]) < 3).all(axis=0)  # not just now
        assert gone.mean() > 0.5
        filled, last = np.nan_to_num(samples), fa.frequency_map(body, z0, time=1024, window=256)
        for found in (fa.frequency_map(body, z0, time=1024), last, fa.tunes(filled), pushed(filled, 1024)):
            none = ~np.isfinite(found.error[0])
            assert none[gone].mean() > 0.9
            assert np.isnan(found.diffusion[none]).all()
            assert np.isnan(found.digits[none]).all()
            assert (found.classification[none] == Classification.UNDECIDED).all()
            assert np.isnan(found.nu[0, none]).all()
            assert not found.regular[gone].any()
            assert not (found.diffusion[gone] < -6).any()
            assert np.isfinite(found.diffusion[~gone]).mean() > 0.98
            brief = gone & (found.classification != Classification.UNDECIDED)
            lived = found.turns if hasattr(found, "turns") else found.t
            assert (lived[brief] >= 64).all()
            assert (lived[brief] * np.minimum(found.nu, 1 - found.nu)[0, brief] >= 30).all()


def test_particles_of_a_ring_with_an_aperture_are_lost():
    """By the map itself, and by its samples with zeros behind the aperture."""
    ring = fa.models.OneTurnMap(nu_x=0.28, nu_y=0.31, octupole=-0.3, aperture=0.8)
    z0 = np.random.default_rng(5).uniform(-0.4, 0.4, (4, 80))
    own = fa.frequency_map(ring, z0, time=1000)
    gone = own.status == fa.Status.LOST
    assert 10 < gone.sum() < 70
    assert (own.status[~gone] == fa.Status.OK).all()
    samples = np.moveaxis(fa.integrate(ring, z0, time=1000, samples=1000).samples, 0, 2)
    assert np.isnan(samples).any()
    read = fa.tunes(np.nan_to_num(samples))
    np.testing.assert_array_equal(read.status == fa.Status.LOST, gone)


def test_a_system_in_the_place_of_its_orbits_is_told_what_to_run():
    with pytest.raises(
        TypeError, match=r"samples must be of orbits, StandardMap is a system: give fa.integrate\(model"
    ):
        fa.tunes(fa.models.StandardMap(0.5))
