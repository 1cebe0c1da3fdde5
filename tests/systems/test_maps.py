"""Maps as models: images, tangent maps, exponents, tunes, against closed forms, NumPy and each other."""

import pickle

import numpy as np
import pytest
import shared_systems
from hypothesis import given, settings
from hypothesis import strategies as st

import fastaff as fa
from fastaff import Classification
from fastaff.core.classification import is_regular
from fastaff.engine.jit import LANES
from fastaff.systems.models import FroeschleMap, HenonMap, McMillanMap, OneTurnMap, StandardMap
from fastaff.systems.models.maps import jacobian, symplectic, symplectic_defect

NAMED = (
    StandardMap(0.8),
    FroeschleMap(0.5, 0.3, 0.02),
    HenonMap(0.2114),
    McMillanMap(1.6),
    OneTurnMap(0.28, 0.31, -0.4),
)
TEXTS = {
    "StandardMap": ("p1 = p + K*sin(x); x1 = x + p1", {"x": "2*pi"}),
    "HenonMap": ("k = p + x**2; x1 = x*cos(2*pi*nu) + k*sin(2*pi*nu); p1 = k*cos(2*pi*nu) - x*sin(2*pi*nu)", None),
    "McMillanMap": ("x' = p\np' = -x + 2*m*p/(1 + p**2)", None),
    "FroeschleMap": (
        "b1 = b*sin(x_1 + x_2); p_1' = p_1 + K_1*sin(x_1) + b1; p_2' = p_2 + K_2*sin(x_2) + b1;"
        "x_1' = x_1 + p_1'; x_2' = x_2 + p_2'",
        {"x_1": 2 * np.pi, "x_2": 2 * np.pi},
    ),
}
TWO_PLANES = "x1 = a + c*(x - a) + s*u*p_x; p_x1 = c*p_x - s/u*(x - a); y1 = d*y + e*p_y; p_y1 = d*p_y - e*y"


def starts(model, count, size=0.3, seed=1):
    """Random phase points (2n, count) about the origin."""
    return np.random.default_rng(seed).uniform(-size, size, (2 * model.degrees_of_freedom, count))


def iterated(model, z, count):
    """The naive twin: images (count, 2n, orbits) by NumPy, brought back to half a period around 0."""
    periods, found = np.array(model.periods())[:, None], []
    for _ in range(count):
        with np.errstate(all="ignore"):
            z = np.array(np.broadcast_arrays(*model.iterate(*z)))
            z = np.where(periods > 0, z - periods * np.rint(z / np.where(periods > 0, periods, 1.0)), z)
        found.append(z)
    return np.array(found)


@pytest.mark.parametrize("model", NAMED, ids=lambda model: type(model).__name__)
def test_iterates_are_those_of_numpy(model):
    z = starts(model, 2 * LANES + 5, 0.1)
    found = fa.integrate(model, z, time=40, samples=40)
    assert (found.status == fa.Status.OK).all()
    assert found.step == 1.0
    assert (found.energy_error == 0).all()
    np.testing.assert_allclose(found.samples, iterated(model, z, 40), atol=1e-13)
    assert (found.samples[-1] == found.z).all()


@pytest.mark.parametrize("model", NAMED, ids=lambda model: type(model).__name__)
def test_starts_are_not_touched(model):
    z = starts(model, 4, 0.2)
    kept = z.copy()
    found = fa.chaos_map(model, z, time=50, history=50)
    fa.periodic_orbits(model, z, iterations=1)
    np.testing.assert_array_equal(z, kept)
    again = fa.tangent_map(model, z, time=50, deviation_vectors=np.eye(len(z))[:1])
    assert found.status.max() == again.status.max() == 0


@pytest.mark.parametrize("model", NAMED, ids=lambda model: type(model).__name__)
def test_tangent_maps_are_derivatives_and_symplectic(model):
    z, h = starts(model, 3), 1e-6
    columns = []
    for row in np.eye(len(z)):
        ends = [fa.integrate(model, z + sign * h * row[:, None], time=5).z for sign in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2 * h))
    found = fa.tangent_map(model, z, time=5)
    np.testing.assert_allclose(found.matrix, np.array(columns).transpose(1, 0, 2), atol=2e-8)
    n = model.degrees_of_freedom
    J = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    M = np.moveaxis(fa.tangent_map(model, z, time=50).matrix, -1, 0)
    assert np.abs(M.transpose(0, 2, 1) @ J @ M - J).max() < 1e-13 * np.abs(M).max() ** 2
    assert symplectic(model)


@pytest.mark.parametrize("name", TEXTS)
def test_texts_are_the_named_maps(name):
    named = next(model for model in NAMED if type(model).__name__ == name)
    text, periods = TEXTS[name]
    made = fa.iterated_map(text, periodic=periods, **named._asdict())
    assert made.coordinates == named.coordinates
    assert made.momenta == named.momenta
    assert made.symplectic
    assert made.periods() == pytest.approx(named.periods())
    z = starts(named, 50)
    np.testing.assert_allclose(fa.integrate(made, z, time=30).z, fa.integrate(named, z, time=30).z, atol=1e-12)
    np.testing.assert_allclose(jacobian(made, z), jacobian(named, z), atol=1e-14)
    assert pickle.loads(pickle.dumps(made)) == made


def test_parameters_of_a_text_stay_run_time_values(tmp_path):
    made = fa.iterated_map("p1 = p + K*sin(x); x1 = x + p1", periodic={"x": "2*pi"}, K=0.5)
    other = made._replace(K=1.5)
    z = starts(other, 20)
    found = fa.integrate(other, z, time=20)
    np.testing.assert_allclose(found.z, fa.integrate(StandardMap(1.5), z, time=20).z, atol=1e-10)
    path = fa.save(tmp_path / "map.npz", found)
    assert fa.files.recipe(path).arguments["model"] == other
    assert (fa.load(path).z == found.z).all()
    assert fa.load(path).scheme == found.scheme


def test_exponents_of_the_standard_map_are_ln_of_half_k():
    for K in (10.0, 17.0):
        found = fa.chaos_map(StandardMap(K), starts(StandardMap(), 400, 3.0), time=4000, indicators=("spectrum",))
        assert found.spectrum[0].mean() == pytest.approx(np.log(K / 2), abs=0.02)
        np.testing.assert_allclose(found.spectrum.sum(axis=0), 0.0, atol=1e-12)
        assert found.chaotic.all()


def test_a_linear_map_has_its_eigenvalues_for_exponents():
    rng = np.random.default_rng(4)
    A = rng.standard_normal((2, 2))
    model = shared_systems.linear_map(A)
    assert not model.symplectic
    assert symplectic_defect(model, [0.1, 0.2]) > 1e-3
    found = fa.chaos_map(model, [0.0, 0.0], time=4000, indicators=(fa.LyapunovSpectrum(),))
    exact = np.sort(np.log(np.abs(np.linalg.eigvals(A))))[::-1]
    np.testing.assert_allclose(found.spectrum[:, 0], exact, atol=5e-4)
    assert found.spectrum.sum() == pytest.approx(np.log(abs(np.linalg.det(A))), abs=1e-12)


def test_the_dissipative_henon_map_contracts_areas_by_b():
    model = shared_systems.henon()
    found = fa.chaos_map(model, np.array([[0.1, 0.2], [0.1, 0.0]]), time=20000, indicators=(fa.LyapunovSpectrum(),))
    np.testing.assert_allclose(found.spectrum.sum(axis=0), np.log(0.3), atol=1e-9)
    np.testing.assert_allclose(found.spectrum[0], 0.4192, atol=0.006)  # Sprott 2003: 0.41922


def test_mcmillan_has_no_chaotic_orbit():
    model, z = McMillanMap(1.6), starts(McMillanMap(), 10_000, 1.5)
    found = fa.chaos_map(model, z, time=2000)
    assert not found.chaotic.any()
    assert found.regular.mean() > 0.95
    end = fa.integrate(model, z, time=2000).z
    kept = [x * x * p * p + x * x + p * p - 2 * model.m * x * p for x, p in (z, end)]
    np.testing.assert_allclose(kept[1], kept[0], atol=1e-12)


def test_classifications_agree_on_chaotic_seas_and_islands():
    rng = np.random.default_rng(2)
    sea = fa.chaos_map(
        StandardMap(10.0), rng.uniform(-3, 3, (2, 100)), time=5000, indicators="megno,sali,zero_one_test,fli"
    )
    assert (sea.classifications == 1).all()
    island = np.array([np.pi + 0.2 * rng.uniform(-1, 1, 100), 0.2 * rng.uniform(-1, 1, 100)])
    calm = fa.chaos_map(StandardMap(0.5), island, time=2000, indicators="megno,sali,zero_one_test,fli")
    assert calm.regular.all()
    assert (calm.classifications == 0).mean() > 0.98


def test_iterates_are_the_crossings_of_a_map():
    model, z = OneTurnMap(octupole=-0.5, aperture=2.0), starts(OneTurnMap(), 300, 0.6)
    found = fa.poincare_map(model, z, crossings=200)
    naive = iterated(model, z, 200)
    with np.errstate(all="ignore"):
        inside = np.logical_and.accumulate(naive[:, 0] ** 2 + naive[:, 1] ** 2 < 4.0, axis=0)
    # A particle is lost on the turn after its last state.
    lost = found.status == fa.Status.LOST
    assert 20 < lost.sum() < 280
    np.testing.assert_array_equal(found.counts, inside.sum(axis=0))
    early = found.points[:, :5, ~lost]
    np.testing.assert_allclose(early, naive[:5, :, ~lost].transpose(1, 0, 2), atol=1e-13)
    assert (found.times[:, ~lost] == np.arange(1, 201)[:, None]).all()
    assert found.names == ("x", "y", "p_x", "p_y")


@given(
    nu=st.tuples(st.floats(0.03, 0.97), st.floats(0.03, 0.97)),
    size=st.floats(1e-3, 1e3),
    unit=st.floats(1e-3, 1e3),
    at=st.floats(-3, 3),
)
@settings(max_examples=15, deadline=None)
def test_tunes_of_linear_maps_in_any_unit_and_at_any_place(nu, size, unit, at):
    """Two turning planes, about points that are not the origin, one with coordinates in another unit."""
    if min(abs(x - round(2 * x) / 2) for x in nu) < 0.02:
        return
    c, s = np.cos(2 * np.pi * np.array(nu)), np.sin(2 * np.pi * np.array(nu))
    model = fa.iterated_map(TWO_PLANES, a=at * size, u=unit, c=c[0], s=s[0], d=c[1], e=s[1])
    found = fa.frequency_map(model, [at * size + size, 0.3, 0.0, 0.1], time=2000)
    off = found.nu[:, 0] - nu
    assert (np.abs(off - np.rint(off)) <= found.error[:, 0]).all()
    assert (found.error < 1e-9).all()
    assert found.names == ("x", "y")


def test_rotation_numbers_of_the_standard_map_cover_those_of_ten_times_the_turns():
    model = StandardMap(0.6)
    z = np.array([np.full(60, np.pi), np.linspace(0.2, 3.0, 60)])
    short, long = (fa.frequency_map(model, z, time=turns) for turns in (3000, 30000))
    regular = is_regular(long.classification)
    assert regular.mean() > 0.8
    off = np.abs(short.nu - long.nu)[0, regular]
    assert (off <= short.error[0, regular] + long.error[0, regular]).mean() >= 0.98
    assert (off <= 10 * (short.error[0, regular] + long.error[0, regular])).all()
    assert np.median(long.error) < 1e-11
    assert (np.diff(long.nu[0, regular]) > -1e-9).all()  # twist


def test_frequency_maps_tell_regular_from_chaotic_as_indicators_do():
    model, z = FroeschleMap(0.5, 0.3, 0.02), starts(FroeschleMap(), 150, 3.0)
    found = fa.frequency_map(model, z, time=4096)
    classification = fa.chaos_map(model, z, time=8192).classification
    assert ((classification == 1) & is_regular(found.classification)).sum() <= 0.2 * (classification == 1).sum()
    assert ((classification == 0) & (found.classification == Classification.IRREGULAR)).sum() <= 1
    diffusing = fa.chaos_map(model, z[:, :40], time=4096, indicators=fa.FrequencyDiffusion())
    assert (diffusing.classification[classification[:40] == 0] != 1).all()


def test_windows_at_both_ends_give_tunes_and_diffusion_of_those_who_survive():
    model, z = OneTurnMap(0.28, 0.31, -0.3, aperture=3.0), starts(OneTurnMap(), 400, 0.5)
    z[2:] = 0.0
    whole = fa.integrate(model, z, time=5000)
    found = fa.frequency_map(model, z, time=5000, window=512)
    lost = whole.status != fa.Status.OK
    assert 50 < lost.sum() < 350
    np.testing.assert_array_equal(found.status, whole.status)
    np.testing.assert_array_equal(found.t, whole.t - lost)
    first = fa.frequency_map(model, z, time=512)
    np.testing.assert_array_equal(found.nu, first.nu)
    last = fa.frequency_map(model, fa.integrate(model, z[:, ~lost], time=5000 - 512).z, time=512)
    change = np.abs(last.nu - first.nu[:, ~lost])
    change = np.abs(change - np.rint(change)).max(axis=0)
    np.testing.assert_allclose(found.diffusion[~lost], np.log10(change + 1e-18), atol=1e-9)
    alone = fa.frequency_map(model, z[:, [5, 7]], time=5000, window=512, threads=1)
    np.testing.assert_array_equal(alone.nu, found.nu[:, [5, 7]])


def test_coupled_planes_of_a_map_have_both_tunes_in_both_windows():
    """Two quadratic maps in coordinates turned by 45 degrees, where both planes have as much of both."""
    rng = np.random.default_rng(15)
    nu, share = rng.uniform(0.13, 0.17), np.sqrt(0.5)
    c, s, d, e = (g(2 * np.pi * x) for x in (nu, nu + 0.2547) for g in (np.cos, np.sin))
    text = (
        "u = r*(x + y); a = r*(p_x + p_y) + u**2; v = r*(y - x); b = r*(p_y - p_x) + v**2; f = c*u + s*a;"
        "g = c*a - s*u; h = d*v + e*b; j = d*b - e*v; x1 = r*(f - h); y1 = r*(f + h);"
        "p_x1 = r*(g - j); p_y1 = r*(g + j)"
    )
    model = fa.iterated_map(text, coordinates="x, y", momenta="p_x, p_y", r=share, c=c, s=s, d=d, e=e)
    u, v, a, b = w = rng.uniform(-0.15, 0.15, (4, 40))
    own = [fa.frequency_map(HenonMap(x), w[k::2], time=8192).nu[0] for k, x in enumerate((nu, nu + 0.2547))]
    z = share * np.array([u - v, u + v, a - b, a + b])
    for more in ({"time": 1024}, {"time": 8192, "window": 1024}):
        found = fa.frequency_map(model, z, **more)
        assert (found.classification == Classification.REGULAR).all()
        off = np.minimum(np.abs(found.nu - own), np.abs(found.nu - own[::-1]))
        assert (off <= found.error + 1e-12).mean() >= 0.98
        assert (found.diffusion < -6).all()
        assert (fa.resonances(found, max_order=3).rank == 0).all()


def test_orbits_that_were_lost_are_on_no_resonance():
    """What frequencies they had before are of no torus, and their wide errors would be near to everything."""
    x = np.linspace(0.05, 1.2, 60)
    found = fa.frequency_map(HenonMap(0.2054), [x, 0 * x], time=1024)
    near = fa.resonances(found, max_order=6)
    np.testing.assert_array_equal(near.status, found.status)
    lost = found.status != fa.Status.OK
    assert 0 < lost.sum() < 60
    assert (near.rank[lost] == 0).all()
    assert sum(count for _, count in near.table()) == (~lost).sum()


DRIVEN_RING = (  # two tunes between symplectic shears, of which y gets the line 2 m: back, a turn, and out again
    "r = p_y + 2*d*x*p_x; ua = x*exp(-2*d*y); va = p_x*exp(2*d*y); qa = y + d*va**2; u = ua + 2*d*va*r;"
    "q = qa - d*u**2; v = va + 2*d*u*r;"
    "X = u*cos(2*pi*m) + v*sin(2*pi*m); U = v*cos(2*pi*m) - u*sin(2*pi*m);"
    "Y = q*cos(2*pi*n) + r*sin(2*pi*n); V = r*cos(2*pi*n) - q*sin(2*pi*n);"
    "Ya = Y + d*X**2; Ua = U - 2*d*X*V; Yb = Ya - d*Ua**2; Xb = X - 2*d*Ua*V;"
    "x1 = Xb*exp(2*d*Yb); y1 = Yb; p_x1 = Ua*exp(-2*d*Yb); p_y1 = V - 2*d*Xb*Ua"
)


def outside(x, a, y, b, d):
    """Starts (4, orbits) of DRIVEN_RING from the coordinates of its turn, by NumPy."""
    y, a = y + d * x**2, a - 2 * d * x * b
    y, x = y - d * a**2, x - 2 * d * a * b
    return np.array([x * np.exp(2 * d * y), y, a * np.exp(-2 * d * y), b - 2 * d * x * a])


def test_a_plane_that_shows_a_harmonic_of_the_other_has_its_own_tune():
    """y turns by 2 nu_x, with some 0.1, and by its own tune with 1e-4 to 0.03. Where it has no motion of its own it is
    RESONANT, at the harmonic.
    """
    rng = np.random.default_rng(41)
    model = fa.iterated_map(DRIVEN_RING, m=0.2, n=0.3, d=0.1)
    assert model.symplectic
    for _ in range(4):
        m, d = rng.uniform(0.05, 0.24), rng.uniform(0.2, 0.4)
        n = m * rng.choice([rng.uniform(0.4, 0.9), rng.uniform(1.1, 1.8)])
        model = model._replace(m=m, n=n, d=d)
        size, (phase, other) = 10 ** rng.uniform(-4, -1.5, 20), rng.uniform(0, 2 * np.pi, (2, 20))
        x = rng.uniform(0.4, 0.6, 20)
        for own, line in ((size, n), (0 * size, 2 * m)):
            z = outside(x * np.cos(phase), x * np.sin(phase), own * np.cos(other), own * np.sin(other), d)
            kept = fa.integrate(model, z, time=2048, samples=2048)
            for found in (fa.frequency_map(model, z, time=2048), fa.tunes(kept)):
                truth = np.array([[m], [line]])
                off = np.minimum(np.abs(found.nu - truth), np.abs(found.nu - 1 + truth))  # in either sense
                assert (off <= found.error + 1e-12).all()
                assert (
                    found.classification == (Classification.RESONANT if line == 2 * m else Classification.REGULAR)
                ).all()


def test_orbits_caught_in_a_resonance_stay_at_it():
    """Beside nu_y = 2 nu_x: their slow swing is no tune of y; whether they are at it, a relation within wide errors
    does not tell.
    """
    ring = OneTurnMap(0.3, 0.597, 0.0, 2.0)
    found = fa.frequency_map(ring, starts(ring, 400), time=4096)
    width = 2 * found.error[0] + found.error[1]
    at = (found.status == fa.Status.OK) & (width < 1e-6) & (np.abs(2 * found.nu[0] - found.nu[1]) <= width)
    assert at.sum() >= 5
    assert (found.classification[at] != Classification.REGULAR).all()
    assert not (found.classification[at] == Classification.IRREGULAR).any()


@pytest.mark.parametrize("turns", [1000, 6000])
def test_chaotic_rotations_stay_irregular(turns):
    """A strongly kicked rotor: nearly no orbit is regular, and its mean turns change from half to half."""
    z0 = np.random.default_rng(12).uniform(0, 2 * np.pi, (2, 100))
    found = fa.frequency_map(StandardMap(6.0), z0, time=turns)
    assert fa.chaos_map(StandardMap(6.0), z0, time=3000).chaotic.mean() > 0.95
    assert (found.classification == Classification.IRREGULAR).mean() > 0.95


def test_tunes_of_running_orbits_are_bitwise_those_of_their_samples():
    """Also of those whose planes are fitted by lines, or that are lost."""
    rng = np.random.default_rng(12)
    for model in (OneTurnMap(*rng.uniform(0.1, 0.4, 2), -0.4, 1.0), HenonMap(rng.uniform(0.2, 0.3))):
        z, turns = starts(model, LANES + 22, 0.6), 700
        found = fa.frequency_map(model, z, time=turns)
        samples = fa.integrate(model, z, time=turns, samples=turns).samples.transpose(1, 2, 0)
        known = found.t >= 64
        assert (found.t[known] < turns).any()
        assert (found.t == turns).any()
        stored = fa.tunes(np.ascontiguousarray(samples[:, known]))
        for name in ("nu", "error"):
            np.testing.assert_array_equal(getattr(found, name)[:, known], getattr(stored, name), name)
        np.testing.assert_array_equal(found.t[known], stored.turns)
        assert stored.method.any() | (model.degrees_of_freedom == 1)


def test_maps_of_an_angle_and_a_plane_have_the_tunes_of_both():
    rng = np.random.default_rng(13)
    K, nu, at, unit = 0.5, rng.uniform(0.1, 0.4), rng.normal(), 10 ** rng.uniform(-2, 2)
    text = (
        "p_a' = p_a + K*sin(a); a' = a + p_a'; y' = b + c*(y - b) + s*u*(p_y + e*(y - b)**2);"
        "p_y' = c*(p_y + e*(y - b)**2) - s/u*(y - b)"
    )
    c, s = np.cos(2 * np.pi * nu), np.sin(2 * np.pi * nu)
    model = fa.iterated_map(text, periodic={"a": "2*pi"}, K=K, b=at, c=c, s=s, u=unit, e=0.2 / unit)
    assert model.coordinates == ("a", "y")
    y, p_y, p_a = at + rng.uniform(-0.2, 0.2, 40), rng.uniform(-0.1, 0.1, 40) / unit, np.linspace(1.5, 3.0, 40)
    found = fa.frequency_map(model, np.array([0 * y, y, p_a, p_y]), time=4000)
    wound = fa.frequency_map(StandardMap(K), np.array([0 * y, p_a]), time=4000)
    np.testing.assert_array_equal(found.nu[0], wound.nu[0])
    np.testing.assert_array_equal(found.error[0], wound.error[0])
    plane = fa.integrate(model, np.array([0 * y, y, p_a, p_y]), time=4000, samples=4000).samples[:, [1, 3]]
    np.testing.assert_array_equal(found.nu[1], fa.tunes(plane.transpose(1, 2, 0)).nu[0])
    few = fa.frequency_map(model, np.array([0 * y, y, p_a, p_y])[:, 3:5], time=4000, threads=1)
    np.testing.assert_array_equal(few.nu, found.nu[:, 3:5])


def test_lines_of_maps_have_the_amplitudes_and_phases_of_conjugated_rotations():
    """x = u + e y^2 with u and y on circles about places of their own: lines at +-nu_x and +-2 nu_y, in any unit."""
    rng = np.random.default_rng(14)
    text = (
        "u = x - a - e*y**2; v = c*u + s*b*p_x; p_x1 = c*p_x - s/b*u; y1 = d*y + f*p_y; p_y1 = d*p_y - f*y;"
        "x1 = a + v + e*y1**2"
    )
    for _ in range(3):
        nu, (r, w), (phi, psi) = np.array([0.21, 0.34]) + rng.uniform(-0.02, 0.02, 2), *rng.uniform(0.3, 3.0, (2, 2))
        unit, at, e = 10 ** rng.uniform(-3, 3), rng.normal(), 0.2 * r / w**2
        c, s, d, f = (g(2 * np.pi * x) for x in nu for g in (np.cos, np.sin))
        order = {"coordinates": "x, y", "momenta": "p_x, p_y"}
        model = fa.iterated_map(text, **order, a=at, b=unit, c=c, s=s, d=d, f=f, e=e)
        y = w * np.cos(psi)
        z = [at + r * np.cos(phi) + e * y * y, y, -r * np.sin(phi) / unit, -w * np.sin(psi)]
        found = fa.frequency_map(model, np.array([z, z]).T, time=3000, lines=5).lines
        small = e * w * w / 4
        kappa = np.sqrt(1 + (2 * small / r) ** 2)  # of Q, that has both, over that of P, in units b
        double = small * np.exp(2j * psi)
        truth = {nu[0]: r / 2 * (1 + kappa) * np.exp(1j * phi), 2 * nu[1] - 1: double, 1 - 2 * nu[1]: np.conj(double)}
        for line, amplitude in truth.items():
            k = np.abs(found.nu[0, :, 0] - line).argmin()
            assert found.nu[0, k, 0] == pytest.approx(line, abs=1e-10)
            assert abs(found.amplitude[0, k, 0] - amplitude) < 1e-5 * r
        assert found.nu[1, 0, 0] == pytest.approx(nu[1], abs=1e-12)
        assert found.amplitude[1, 0, 0] == pytest.approx(w * np.exp(1j * psi), abs=1e-7 * w)
        np.testing.assert_array_equal(found.nu[..., 0], found.nu[..., 1])
        assert found.names == ("x", "y")


def test_lines_of_an_angle_that_winds_are_what_is_left_of_it():
    """Of a weak standard map x = theta + A sin theta, A = -K/(4 sin^2(pi nu)), to the second order in K."""
    K, p = 0.004, 2 * np.pi * np.array([0.153, 0.381, 0.617, 2.271])
    found = fa.frequency_map(StandardMap(K), np.array([np.zeros(4), p]), time=2000, lines=4)
    nu = found.nu[0] - np.rint(found.nu[0])
    size = [np.zeros(4, complex), np.zeros(4, complex)]
    for i, sign in enumerate((1, -1)):
        k = np.abs(found.lines.nu[0] - sign * nu).argmin(axis=0)
        np.testing.assert_allclose(found.lines.nu[0][k, range(4)], sign * nu, atol=1e-9)
        size[i] = found.lines.amplitude[0][k, range(4)]
    np.testing.assert_allclose(np.abs(size[0] + np.conj(size[1])), K / (4 * np.sin(np.pi * nu) ** 2), rtol=0.02)
    lost = fa.frequency_map(OneTurnMap(octupole=-0.4, aperture=1.0), starts(OneTurnMap(), 60, 0.6), time=700, lines=2)
    brief = lost.t < 64
    assert 0 < brief.sum() < 60
    assert (lost.lines.error[..., brief] == np.inf).all()
    assert np.isfinite(lost.lines.error[..., ~brief]).any()
    assert (fa.frequency_map(StandardMap(K), [0.0, 1.0], time=100).lines) is None


def test_what_frequency_maps_of_maps_cannot_be_asked_for():
    for more, said in (
        ({"time": 40}, "at least 64"),
        ({"time": 1000, "window": 600}, "at most half"),
        ({"time": 1000, "window": 10}, "window"),
        ({"time": 1000.5}, "whole number"),
        ({"time": 1000, "signals": fa.models.angles.AlphaBeta()}, "signals is not supported for maps"),
    ):
        with pytest.raises(ValueError, match=said):
            fa.frequency_map(StandardMap(), [0.1, 0.2], **more)
    with pytest.raises(ValueError, match="window must be None for a system in time"):
        fa.frequency_map(fa.HenonHeiles(), [0.1, 0.2, 0.0, 0.1], time=10.0, window=100)


def symmetric(K, x, p, q):
    """The momentum of the orbit with the rotation number p/q on the symmetry line x of the standard map, by Newton's
    method for the lifted angle alone, from K = 0.
    """
    r = 2 * np.pi * p / q
    for k in np.linspace(0, K, 40)[1:]:
        for _ in range(20):
            a, m, da, dm = x, r, 0.0, 1.0
            for _ in range(q):
                m, dm = m + k * np.sin(a), dm + k * np.cos(a) * da
                a, da = a + m, da + dm
            r -= (a - x - 2 * np.pi * p) / da
    return r


def test_residues_at_the_break_up_of_the_golden_curve_are_near_a_quarter():
    """Greene 1979: they go to 0.25 at K = 0.971635, to 0 below, and grow beyond."""
    ratios = ((5, 8), (8, 13), (13, 21), (21, 34))
    residues = {}
    for K in (0.9, 0.971635406, 1.05):
        elliptic = []
        for p, q in ratios:
            z = np.array([[x, symmetric(K, x, p, q)] for x in (0.0, np.pi)]).T
            z = z[:, np.abs(z[1] - 2 * np.pi * p / q) < 1]  # where the search along the line did not get lost
            found = fa.periodic_orbits(StandardMap(K), z, crossings=q)
            assert (found.status == fa.Status.OK).all()
            assert (found.error < 1e-9).all()
            elliptic.append(found.residue.max())
        residues[K] = np.array(elliptic)
    np.testing.assert_allclose(residues[0.971635406], 0.25, atol=0.006)
    assert (np.diff(residues[0.9]) < -0.02).all()
    assert (np.diff(residues[1.05])[:2] > 0.1).all()


@pytest.mark.parametrize("K", [0.3, 0.9, 2.5])
def test_fixed_points_of_the_standard_map_have_the_residue_k_over_4(K):
    rng = np.random.default_rng(6)
    guesses = np.array([[0.0], [np.pi]]).reshape(1, 2) + 0.05 * rng.standard_normal((2, 2)) * [[1], [1]]
    guesses[1] -= np.array([0.0, np.pi])
    found = fa.periodic_orbits(StandardMap(K), guesses)
    np.testing.assert_allclose(found.residue, [-K / 4, K / 4], atol=1e-13)
    np.testing.assert_allclose(found.z, [[0.0, np.pi], [0.0, 0.0]], atol=1e-12)
    assert found.reduced_monodromy.shape == (2, 2, 2)


def test_residues_of_a_map_of_four_rows_are_those_of_its_tunes():
    model = OneTurnMap(0.28, 0.31, -0.3)
    found = fa.periodic_orbits(model, [0.01, -0.01, 0.005, 0.0])
    exact = np.sort([np.sin(np.pi * nu) ** 2 for nu in (0.28, 0.31)])
    np.testing.assert_allclose(np.sort(found.residues[:, 0].real), exact, atol=1e-12)
    np.testing.assert_allclose(np.abs(found.multipliers), 1.0, atol=1e-12)


def test_a_family_of_a_map_is_followed_in_its_parameter():
    """The fixed point at x = pi loses its stability at K = 4, R = 1."""
    found = fa.continuation(lambda K: StandardMap(K), [np.pi, 0.0], parameter=0.5, bounds=(0.5, 5.0), max_steps=300)
    assert found.status == fa.Status.OK
    np.testing.assert_allclose(found.orbits.residue, found.parameter / 4, atol=1e-10)
    assert [event.parameter for event in found.bifurcations] == pytest.approx([4.0], abs=1e-6)


def test_the_periodic_orbits_of_a_map_are_all_different():
    model = StandardMap(0.9)
    z = np.random.default_rng(0).uniform(-3, 3, (2, 200))
    found = fa.find_periodic_orbits(model, z, max_crossings=3)
    assert (found.status == fa.Status.OK).all()
    inside = found.take(np.flatnonzero((np.abs(found.z[1]) < 3.2) & (found.crossings == 1)))
    np.testing.assert_allclose(np.sort(inside.residue), [-0.225, 0.225], atol=1e-12)
    images = iterated(model, found.z, 3)
    for q in (1, 2, 3):
        own = found.crossings == q
        apart = (images[q - 1] - found.z)[:, own]
        apart[0] -= 2 * np.pi * np.rint(apart[0] / (2 * np.pi))
        np.testing.assert_allclose(apart, 0.0, atol=1e-10)


def test_what_periodic_orbits_of_maps_cannot_be_asked_for():
    with pytest.raises(ValueError, match="section is not supported for maps"):
        fa.periodic_orbits(StandardMap(), [0.1, 0.2], section="x=0")
    with pytest.raises(ValueError, match="energy is not supported for maps"):
        fa.periodic_orbits(StandardMap(), [0.1, 0.2], energy=1.0)
    with pytest.raises(ValueError, match="parameter must be a number for a map"):
        fa.continuation(StandardMap(), [0.1, 0.2])
    with pytest.raises(TypeError, match="section must be"):
        fa.periodic_orbits(fa.HenonHeiles(), [0.1, 0.2, 0.0, 0.1])
    wound = fa.periodic_orbits(StandardMap(), [0.0, 1e18])
    assert wound.status[0] != fa.Status.OK


@given(nu=st.floats(0.02, 0.48), size=st.floats(1e-3, 1e3), unit=st.floats(1e-3, 1e3))
@settings(max_examples=20, deadline=None)
def test_rotation_numbers_of_linear_maps_in_any_unit(nu, size, unit):
    c, s = np.cos(2 * np.pi * nu), np.sin(2 * np.pi * nu)
    model = shared_systems.linear_map([[c, s * unit], [-s / unit, c]])
    found = fa.poincare_map(model, [size, 0.0], crossings=1000)
    points = found.points / np.array([size, size / unit])[:, None, None]
    turning = fa.rotation_number(points, centre=(0.0, 0.0))
    assert abs(turning.rotation[0] + nu) <= max(turning.error[0], 1e-13)


@pytest.mark.parametrize(
    ("text", "more", "said"),
    [
        (3, {}, "text must be a map such as"),
        ("x1 = y; y1 = z; z1 = x", {}, "images of 1, 2, 4"),
        ("nothing", {}, "statements name = formula"),
        ("p1 = p + K*sin(x); x1 = x + q", {"K": 1.0}, "unknown name 'q'"),
        ("p1 = p + K*sin(x); x1 = x + p1", {}, "unknown name 'K'"),
        ("x1 = x + p1; p1 = p + sin(x)", {}, "text, x1: p1 = ... comes later. Write p1 = ... before x1 = ..."),
        ("x' = x + p'; p' = p + sin(x)", {}, "text, x': p' = ... comes later. Write p' = ... before x' = ..."),
        ("x1 = x + x1; p1 = p", {}, "unknown name 'x1'"),
        ("p1 = p + x; x1 = x + p1", {"K": 1.0}, "'K' is not used"),
        ("p = p + 1; x1 = x; p1 = p", {}, "must give a value to a new name, got a variable. Write"),
        ("p1 = p; x1 = x; p1 = x", {}, "images of 1, 2"),
        ("p1 = sqrt(-1 - p**2); x1 = x", {}, "no finite real value"),
        ("p1 = __import__('os'); x1 = x", {}, "must give the image"),
        ("p1 = p + x; x1 = x + p1", {"periodic": {"z": 1.0}}, "periodic must be of x, p"),
        ("p1 = p + x; x1 = x + p1", {"periodic": {"x": -1.0}}, "periodic"),
        ("p1 = p + x; x1 = x + p1", {"periodic": 2.0}, "periodic must be a dictionary"),
        (
            "p1 = p + x; x1 = x + p1",
            {"coordinates": "y"},
            "coordinates and momenta must each be half of the variables p, x, got y",
        ),
        ("p1 = p + x; x1 = x + p1", {"domain": "1 - p**2"}, "unknown name 'p'"),
    ],
)
def test_what_is_no_map_is_refused(text, more, said):
    with pytest.raises((ValueError, TypeError), match=said):
        fa.iterated_map(text, **more)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda m: fa.integrate(m, [0.0, 1.0], time=2.5), "whole number of iterates"),
        (lambda m: fa.integrate(m, [0.0, 1.0], time=10, samples=3), "samples must divide"),
        (lambda m: fa.integrate(m, [0.0, 1.0], time=10, step=0.1), "step is not supported for maps"),
        (lambda m: fa.integrate(m, [0.0, 1.0], time=10, scheme="dop853"), "scheme is not supported for maps"),
        (lambda m: fa.integrate(m, [0.0, 1.0], time=10, accuracy=1e-8), "accuracy is not supported for maps"),
        (lambda m: fa.integrate(m, [0.0, 1.0, 2.0], time=10), "shape"),
        (lambda m: fa.poincare_map(m, [0.0, 1.0], crossings=5, section="x=0"), "section is not supported for maps"),
        (lambda m: fa.poincare_map(m, [0.0, 1.0], crossings=5, max_time=9.0), "max_time is not supported for maps"),
        (lambda m: fa.chaos_map(m, [0.0, 1.0], time=10, indicators=fa.OFLI()), "ofli, is not supported for maps"),
        (lambda m: fa.action_angles(m, [0.0, 1.0]), "got a map"),
        (lambda m: fa.energy_grid(m, section="x=0", energy=1.0, axes=([0.0], [0.0])), "got a map"),
    ],
)
def test_what_needs_a_system_in_time_is_refused(call, said):
    with pytest.raises((ValueError, TypeError), match=said):
        call(StandardMap())


def test_a_map_that_misses_something_is_named():
    class Half(tuple):
        pass

    with pytest.raises(TypeError, match="must be a model"):
        fa.integrate(StandardMap, [0.0, 1.0], time=3)
    bad = fa.iterated_map("p1 = p + a*sin(2*pi*x/a); x1 = x + p1", periodic={"x": "a"}, a=1.0)._replace(a=-1.0)
    with pytest.raises(ValueError, match=r"periods must be positive, or 0 for none, got \(-1.0, 0.0\)"):
        fa.integrate(bad, [0.0, 1.0], time=3)


def test_grids_and_samples_of_maps_have_no_energy():
    model = FroeschleMap()
    grid = fa.energy_grid(model, axes={"x_1": [0.0, 0.5, 1.0], "p_2": [0.2, 0.3]}, fixed={"x_2": 0.1})
    assert grid.z0.shape == (4, 6)
    np.testing.assert_array_equal(grid.z0[1], 0.1)
    np.testing.assert_array_equal(grid["p_2"], grid.z0[3])
    assert np.isnan(grid.energy)
    sample = fa.energy_sample(model, orbits=50, axes={"x_1": (-1.0, 1.0), "p_1": (0.0, 2.0)}, seed=3)
    few = fa.energy_sample(model, orbits=5, axes={"x_1": (-1.0, 1.0), "p_1": (0.0, 2.0)}, seed=3)
    np.testing.assert_array_equal(sample.z0[:, :5], few.z0)
    assert (np.abs(sample.z0[0]) <= 1).all()
    assert np.ptp(sample.z0[2]) > 1
    inside = fa.energy_grid(OneTurnMap(aperture=1.0), axes={"x": [0.0, 0.9, 2.0], "y": [0.0, 0.9]})
    assert inside.inaccessible.sum() == 3
    for more, said in (
        ({"energy": 1.0}, "energy is not supported for maps"),
        ({"section": "x_1=0"}, "section is not supported for maps"),
        ({"solve": "p_2"}, "solve is not supported for maps"),
        ({"at_rest": True}, "at_rest is not supported for maps"),
        ({"axes": {"x": [0.0]}}, "axes must be one of"),
    ):
        with pytest.raises((ValueError, TypeError), match=said):
            fa.energy_grid(model, **{"axes": {"x_1": [0.0]}, **more})


def test_jobs_of_maps_keep_what_the_functions_give(tmp_path):
    from fastaff.jobs import ChaosOptions, FrequencyOptions, InitialConditions, Job, Model, PoincareOptions

    text = Model(map="p1 = p + K*sin(x); x1 = x + p1", periodic=["x=2*pi"], parameter=["K=0.9"])
    starts_ = InitialConditions(axes=["x=0:6:4", "p=-1:1:3"])
    job = Job(
        model=text,
        initial_conditions=starts_,
        poincare=PoincareOptions(crossings=20),
        chaos_map=ChaosOptions(time=200.0),
        frequency_map=FrequencyOptions(time=128.0),
        chunk=5,
    )
    found = fa.run(job, tmp_path / "map.zarr")
    model = fa.iterated_map("p1 = p + K*sin(x); x1 = x + p1", periodic={"x": "2*pi"}, K=0.9)
    x, p = (low + (high - low) * (np.arange(n) + 0.5) / n for low, high, n in ((0, 6, 4), (-1, 1, 3)))
    grid = fa.energy_grid(model, axes={"x": x, "p": p})
    np.testing.assert_array_equal(found["poincare"].points, fa.poincare_map(model, grid.z0, crossings=20).points)
    np.testing.assert_array_equal(found["chaos_map"].values, fa.chaos_map(model, grid.z0, time=200).values)
    np.testing.assert_array_equal(found["frequency_map"].nu, fa.frequency_map(model, grid.z0, time=128).nu)
    again = Job.parsed(job.text())
    assert again == job
    for entry in (StandardMap(0.4), model):
        given_ = Job(model=entry, initial_conditions=grid.z0, chaos_map=ChaosOptions(time=50.0))
        assert isinstance(given_.model, Model)
        assert given_.model.build() == entry


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--model", "standard-map", "--energy", "1"], "--energy is not supported for maps"),
        (["--model", "standard-map", "--step", "0.1"], "--step is not supported for maps"),
        (["--model", "standard-map", "--parameter", "Q=1"], "--parameter Q is none of standard-map"),
        (["--model", "standard-map", "--axes", "y=0:1:3"], "--axes must be one of x, p"),
        (["--map", "x1 = x; y1 = y; z1 = z", "--axes", "x=0:1:3"], "must give the images"),
        (["--map", "p1 = p + x; x1 = x + p1", "--model", "henon-map"], "give one of"),
        (["--periodic", "x=1"], "--periodic belongs to --map, --hamiltonian or --ode"),
    ],
)
def test_commands_refuse_what_maps_do_not_have(options, said, capsys):
    from fastaff.cli.main import main

    more = [] if "--axes" in options else ["--axes", "x=0:1:3"]
    assert main(["chaos-map", "--time", "100", *options, *more]) == 2
    assert said in capsys.readouterr().err


def test_commands_draw_maps(tmp_path, capsys):
    from fastaff.cli.main import main

    where = ["--axes", "x=-3:3:6", "--axes", "p=-3:3:6"]
    assert main(["poincare", "--model", "standard-map", *where, "--crossings", "80", "--out", str(tmp_path / "a")]) == 0
    text = ["--map", "p1 = p + K*sin(x); x1 = x + p1", "--periodic", "x=2*pi", "--parameter", "K=0.97"]
    assert main(["chaos-map", *text, *where, "--time", "200", "--out", str(tmp_path / "b")]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "a.png", "b.npz", "b.png"]
    assert "36 OK" in capsys.readouterr().err


def test_resonances_of_maps_count_the_turn():
    c, s = (np.round(f(2 * np.pi * np.array([0.25, 0.31])), 15) for f in (np.cos, np.sin))
    model = fa.iterated_map(TWO_PLANES, a=0.0, u=1.0, c=c[0], s=s[0], d=c[1], e=s[1])
    found = fa.resonances(fa.frequency_map(model, [0.3, 0.2, 0.0, 0.1], time=4000), max_order=6)
    assert found.names == ("x", "y", "turn")
    np.testing.assert_array_equal(found.basis[0, :, 0], [4, 0, -1])


def test_an_orbit_ends_with_the_same_iterate_in_all_analyses():
    """With the first one that is not finite or outside the domain, whatever is asked; no distance is an escape, so a
    start beside a fixed point is no end of it. Momenta that no coordinate depends on count too.
    """
    rng = np.random.default_rng(31)
    a, b, r = rng.uniform(1.5, 3.0), rng.uniform(1.5, 3.0), rng.uniform(0.6, 0.9)
    models = [
        HenonMap(rng.uniform(0.1, 0.4)),
        OneTurnMap(0.28, 0.31, -0.3, rng.uniform(1.0, 2.0)),
        shared_systems.linear_map([[0.5, 0.0], [0.0, 10.0**a]]),
        shared_systems.linear_map([[b, 0.0], [1.0, 1.0]]),
        fa.iterated_map("x1 = x*x*r + p; p1 = x", domain="9 - x**2", r=r),
    ]
    for model in models:
        rows = 2 * model.degrees_of_freedom
        z = rng.uniform(-1.2, 1.2, (rows, 60))
        z[:, :10] *= 10.0 ** rng.uniform(-12, -1, (rows, 10))
        path, naive = z, np.full(60, 3000)
        for k in range(3000):
            with np.errstate(all="ignore"):
                path = np.array(np.broadcast_arrays(*model.iterate(*path)))
                inside = np.isfinite(path).all(axis=0) & (model.margin(*path[: rows // 2]) > 0)
            naive = np.where(~inside & (naive == 3000), k, naive)
            path = np.where(inside | (naive == 3000), path, np.nan)
        lost = naive < 3000
        assert lost.any()
        run, cut = fa.integrate(model, z, time=3000), fa.poincare_map(model, z, crossings=3000)
        chaos, map_ = fa.chaos_map(model, z, time=3000), fa.frequency_map(model, z, time=3000)
        for found, survived in ((run, run.t - lost), (cut, cut.counts), (chaos, chaos.t - lost), (map_, map_.t)):
            assert ((found.status != fa.Status.OK) == lost).all()
            np.testing.assert_array_equal(survived, naive)
        same_end = run.status == cut.status
        assert (same_end & (run.status == chaos.status) & (run.status == map_.status)).all()
        assert not (run.status == fa.Status.ESCAPED).any()


def test_exponents_where_an_iterate_stretches_beyond_all_digits():
    """ln(K/2) of the standard map up to K = 10^12 with both signs, where the second vector keeps no digit; and maps
    whose derivative has a lower rank, one of whose exponents is minus infinity.
    """
    rng = np.random.default_rng(32)
    for K in 10.0 ** rng.uniform(7, 12, 4):
        found = fa.chaos_map(StandardMap(K), starts(StandardMap(K), 20), time=4000, indicators="spectrum,megno,sali")
        assert (found.status == fa.Status.OK).all()
        np.testing.assert_allclose(found.spectrum[0], np.log(K / 2), atol=0.1)
        np.testing.assert_array_equal(found.spectrum[1], -found.spectrum[0])
        assert (found.classification == 1).all()
        assert not np.isnan(found.values).any()
    rank = fa.iterated_map("x1 = 1 - 2*x**2; p1 = c*x", c=rng.uniform(0.5, 2.0))
    found = fa.chaos_map(rank, starts(rank, 20), time=20000, indicators="spectrum,megno,sali")
    assert (found.status == fa.Status.OK).all()
    np.testing.assert_allclose(found.spectrum[0], np.log(2), atol=0.01)
    assert (found.spectrum[1] == -np.inf).all()
    assert not np.isnan(found.values).any()


def test_rotation_numbers_and_islands_take_section_maps():
    found = fa.poincare_map(HenonMap(), np.array([np.linspace(0.1, 0.6, 12), np.zeros(12)]), crossings=600)
    np.testing.assert_array_equal(fa.rotation_number(found).rotation, fa.rotation_number(found.points).rotation)
    body, z = fa.HenonHeiles(), np.array([[0.0, 0.1, 0.3, 0.05], [0.0, 0.2, 0.25, 0.0]]).T
    cut = fa.poincare_map(body, z, section="x=0", crossings=60, max_time=1000.0)
    np.testing.assert_array_equal(fa.islands(cut).classification, fa.islands(cut.points[[1, 3]]).classification)
    with pytest.raises(ValueError, match="points must be a SectionMap of a map"):
        fa.islands(fa.poincare_map(FroeschleMap(), [0.1, 0.2, 0.0, 0.1], crossings=50))


def test_errors_of_doublings_hold():
    """p' = p + e - c (x - o)^2, x' = x + p': the fixed point doubles at e = 4/c, in any unit and from any origin."""
    rng = np.random.default_rng(11)
    for _ in range(12):
        c, o, unit = rng.uniform(0.3, 3.0), rng.normal() * 5.0, 10.0 ** rng.uniform(-2, 2)

        def quadratic(e, c=c, o=o, unit=unit):
            return fa.iterated_map("p1 = p + e - c*(x - o)**2; x1 = x + p1", e=e * unit, c=c / unit, o=o * unit)

        e = rng.uniform(1.0, 2.0) / c
        start = [unit * (o + np.sqrt(e / c)), 0.0]
        branch = fa.continuation(quadratic, start, parameter=e, ds_max=20.0, max_steps=90, bounds=(0.0, 5.0 / c))
        assert [found.event for found in branch.bifurcations] == [fa.periodic.Event.PERIOD_DOUBLING]
        (found,) = branch.bifurcations
        assert abs(found.parameter - 4.0 / c) <= found.error < 1e-7 / c


def test_periods_that_a_map_has_not_got_are_refused():
    text = "p1 = p + K*sin(x); x1 = x + p1"
    for periods, said in (({"x": 2}, r"\['x'\] must .* got 2:"), ({"x": "4*pi", "p": 1}, r"\['p'\] must .* got 1:")):
        with pytest.raises(ValueError, match=f"periodic{said}"):
            fa.iterated_map(text, periodic=periods, K=0.9)
    with pytest.raises(ValueError, match=r"must be a period of the map, .* the image of x changes by 3.14159 after it"):
        fa.iterated_map("p1 = p + K*sin(x); x1 = x/2 + p1", periodic={"x": "2*pi"}, K=0.9)
    # Multiples of the least period, maps that wind twice, sawteeth, any unit: all of these have theirs.
    fa.iterated_map(text, periodic={"x": "4*pi", "p": "4*pi"}, K=0.9)
    fa.iterated_map("p1 = p + K*sin(x); x1 = 2*x + p1", periodic={"x": "2*pi"}, K=0.9)
    fa.iterated_map("p1 = p + K*atan(tan(pi*x))/pi; x1 = x + p1", periodic={"x": 1}, K=0.3)
    for unit in (1e-9, 360.0, 1e9):
        fa.iterated_map("p1 = p + K*P*sin(2*pi*x/P); x1 = x + p1", periodic={"x": "P"}, K=0.1, P=unit)


def test_maps_that_are_real_only_far_away():
    text = "p1 = p + 0.1/sqrt(x - a) - 0.1; x1 = x + p1"
    far, near = fa.iterated_map(text, a=1e5), fa.iterated_map(text, a=0.0)
    starts = np.array([[1.3, 2.0], [0.0, 0.0]])
    there = fa.frequency_map(far, starts + np.array([[1e5], [0.0]]), time=1000)
    here = fa.frequency_map(near, starts, time=1000)
    assert np.abs(there.nu - here.nu).max() < 1e-8
    fa.iterated_map("p1 = p + sqrt(1 - (x - a)**2); x1 = x + p1", a=1e3)
    with pytest.raises(ValueError, match="real"):
        fa.iterated_map("p1 = p + sqrt(-1 - x**2*q**2); x1 = x + p1; q1 = q; y1 = y")


def test_orbits_of_islands_are_not_irregular():
    """Around the islands 1/5 of Henon's map: the halves see other parts of a slow swing."""
    model, z0 = HenonMap(0.2054), np.zeros((2, 200))
    angle = np.random.default_rng(8).uniform(0, 2 * np.pi, 200)
    z0[:] = np.random.default_rng(9).uniform(0.3, 0.42, 200) * [np.cos(angle), np.sin(angle)]
    found, truth = (fa.frequency_map(model, z0, time=time) for time in (512, 16384))
    calm = truth.classification == Classification.REGULAR
    assert calm.sum() > 150
    swinging = (np.abs(5 * found.nu[0] - 1) * 512 < 3) & calm
    assert swinging.sum() > 10
    assert (found.classification[calm] == Classification.IRREGULAR).sum() <= 2
    samples = fa.integrate(model, z0[:, calm], time=512, samples=512).samples.transpose(1, 2, 0)
    assert (fa.tunes(samples).classification == Classification.IRREGULAR).sum() <= 2


def test_planes_that_are_all_restless():
    """No orbit of two planes is calm: there are no modes to look for."""
    model = OneTurnMap(nu_x=0.28883115136299725, nu_y=0.19452565053883175, octupole=-0.0812251067380454, aperture=10.0)
    found = fa.frequency_map(model, [0.3476747055894037, 0.25973390354356185, 0.0, 0.0], time=8192)
    assert found.classification[0] in (Classification.IRREGULAR, Classification.UNDECIDED)
