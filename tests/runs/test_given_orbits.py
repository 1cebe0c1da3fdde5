"""Orbits of others: arrays, labelled arrays and files give what own orbits give; what is wrong is named."""

from types import SimpleNamespace

import numpy as np
import pytest
import shared_systems
from comparison import same

import fastaff as fa
from fastaff import Classification
from fastaff.engine.jit import JIT_DISABLED
from fastaff.runs.given_orbits import given_orbits
from fastaff.systems.models.angles import AlphaBeta

MANY = 6 if JIT_DISABLED else 200
HH = fa.HenonHeiles()
Z0 = np.array([[0.0, 0.1, -0.05, 0.2], [0.1, -0.1, 0.2, 0.0], [0.3, 0.28, 0.2, 0.1], [0.05, 0.1, 0.0, 0.2]])
OWN = fa.integrate(HH, Z0, time=400.0, samples=2000)
ARRAY = np.ascontiguousarray(OWN.samples.transpose(1, 2, 0))
DT = 0.2


def flow_signals(rng, orbits, samples, dt):
    """Samples (4, orbits, samples) of motion with two frequencies, in units and places of its own: q has lines at nu_1,
    nu_2 and 2 nu_1 - nu_2, p is proportional to its derivative. The frequencies (2, orbits) ascend."""
    span = samples * dt
    nu = np.empty((2, 0))
    k = np.array([(i, j) for i in range(7) for j in range(-6, 7) if 0 < i + abs(j) <= 6])
    while nu.shape[1] < orbits:
        tried = np.sort(rng.uniform(12 / span, 0.12 / dt, (2, orbits)), axis=0)
        clear = (np.abs(k @ tried) * span > np.where(np.abs(k).sum(axis=1) <= 4, 2.5, 1.0)[:, None]).all(axis=0)
        nu = np.concatenate([nu, tried[:, clear]], axis=1)
    nu = nu[:, :orbits]
    t = dt * np.arange(samples)
    phase = rng.uniform(size=(2, orbits, 1))
    theta = nu[..., None] * t + phase
    mixed = 10 ** rng.uniform(-4, -0.8, (2, 2, orbits, 1))
    unit, mass, place = (10 ** rng.uniform(-2, 2, (2, orbits, 1)) for _ in range(3))
    q, p = np.zeros((2, 2, orbits, samples))
    for i in range(2):
        for size, turns, rate in (
            (1.0, theta[i], nu[i]),
            (mixed[i, 0], theta[1 - i], nu[1 - i]),
            (mixed[i, 1], 2 * theta[i] - theta[1 - i], 2 * nu[i] - nu[1 - i]),
        ):
            q[i] += unit[i] * size * np.cos(2 * np.pi * turns)
            p[i] -= mass[i] * size * 2 * np.pi * rate[:, None] * np.sin(2 * np.pi * turns)
        q[i] += place[i]
    return nu, np.concatenate([q, p]), unit


@pytest.mark.parametrize("samples", [300, 1000, 4000, 20000])
def test_frequencies_of_known_lines(samples):
    rng = np.random.default_rng(samples)
    dt = 10 ** rng.uniform(-3, 3)
    nu, z, _ = flow_signals(rng, min(MANY, 400_000 // samples), samples, dt)
    found = fa.orbit_frequencies(z, dt)
    off = np.abs(found.nu - nu)
    known = (found.rank == 2)[None] & np.isfinite(found.error)
    assert known.mean() > 0.95
    assert (off <= found.error)[known].mean() >= 0.99
    assert (off <= 10 * found.error)[known].all()
    assert np.median(found.error * samples * dt) < (1e-3 if samples < 1000 else 1e-5)
    assert (found.classification[found.nu.max(axis=0) * samples * dt > 30] != Classification.IRREGULAR).all()
    assert found.energy_error is None
    assert found.scheme is None
    assert found.step == dt


def test_lines_have_amplitudes_and_phases():
    rng = np.random.default_rng(3)
    nu, z, unit = flow_signals(rng, 20, 4000, 0.1)
    found = fa.orbit_frequencies(z, 0.1, lines=4)
    first = found.lines.nu[:, 0]
    np.testing.assert_allclose(first, nu, rtol=1e-10)
    size = np.abs(found.lines.amplitude[:, 0])
    assert (np.abs(size / unit[:, :, 0] - 1) < 0.4).all()
    t = 0.1 * np.arange(4000)
    waves = np.exp(2j * np.pi * found.lines.nu[..., None] * t)
    sums = np.einsum("alo,alot->aot", found.lines.amplitude, waves).real
    q = z[:2] - z[:2].mean(axis=-1, keepdims=True)
    rest = np.abs(q - sums).mean(axis=-1) / np.abs(q).max(axis=-1)
    assert np.median(rest) < 1e-3
    assert (np.abs(found.lines.phase - np.angle(found.lines.amplitude)) == 0).all()
    few = found.take([3, 1])
    same(few.lines.nu, found.lines.nu[:, :, [3, 1]])


def test_lines_of_a_frequency_map_are_those_of_its_start():
    """A harmonic oscillator of two masses: amplitudes, phases at the start, in the units of q."""
    body = shared_systems.oscillators(1.3, 2.9, (1.0, 3.0))
    rng = np.random.default_rng(4)
    z0 = rng.normal(size=(4, 9))
    omega = np.sqrt(np.array([1.3, 2.9 / 3.0]))[:, None]
    found = fa.frequency_map(body, z0, time=300.0, accuracy=1e-12, lines=3)
    expected = z0[:2] - 1j * z0[2:] / (np.array([1.0, 3.0])[:, None] * omega)
    np.testing.assert_allclose(found.lines.nu[:, 0], np.broadcast_to(omega / (2 * np.pi), (2, 9)), rtol=1e-11)
    np.testing.assert_allclose(found.lines.amplitude[:, 0], expected, rtol=0, atol=1e-7)
    assert fa.frequency_map(body, z0, time=300.0).lines is None
    without = fa.frequency_map(body, z0, time=300.0, accuracy=1e-12)
    same(without.nu, found.nu)
    body8 = fa.Body(fa.Hyperelastic())
    z8 = np.array([[1.2, 0.1, 0.4, 0.0, 0.1, 0.6, 0.1, 0.2]]).T
    deformed = fa.frequency_map(body8, z8, time=200.0, lines=2)
    assert deformed.lines.names == ("r", "vartheta", "eta", "gamma")
    k = np.array([(i, j) for i in range(-8, 9) for j in range(-8, 9)])
    for turning, lines in zip((deformed.nu_eta, deformed.nu_gamma), deformed.lines.nu[2:], strict=True):
        combined = turning + k @ deformed.nu[:2, 0]
        assert (np.abs(lines[:, 0, None] - combined).min(axis=1) < 1e-7).all()


def test_own_orbits_and_their_numbers_have_the_same_bits():
    whole = fa.orbit_frequencies(OWN, lines=2)
    given = {"dt": DT, "coordinates": OWN.names, "lines": 2}
    interval = (OWN.times[-1] - OWN.times[0]) / 1999
    for array in (
        ARRAY,
        np.asfortranarray(ARRAY),
        OWN.samples.transpose(1, 2, 0),
        np.repeat(ARRAY, 2, axis=2)[:, :, ::2],
    ):
        same(fa.orbit_frequencies(array, **{**given, "dt": interval}), whole)
        same(fa.orbit_frequencies(array, times=OWN.times, coordinates=OWN.names, lines=2), whole)
    assert whole.names == ("x", "y")
    alone = fa.orbit_frequencies(ARRAY[:, 2], interval, coordinates=OWN.names, lines=2)
    same(alone, whole.take(2))
    lists = fa.orbit_frequencies(ARRAY[:, :1, :80].tolist(), DT)
    same(lists, fa.orbit_frequencies(ARRAY[:, :1, :80], DT))


def test_what_frequency_map_says_of_the_same_orbits():
    direct = fa.frequency_map(HH, Z0, time=400.0)
    found = fa.orbit_frequencies(OWN)
    regular = direct.regular & found.regular
    assert regular.sum() >= 3
    assert (np.abs(direct.nu - found.nu) <= 3 * (direct.error + found.error) + 1e-9)[:, regular].all()
    body = fa.Body(fa.Hyperelastic())
    z0 = np.array([[1.2, 0.1, 0.4, 0.0, 0.1, 0.6, 0.1, 0.2]]).T
    orbits = fa.integrate(body, z0, time=200.0, samples=4000, accuracy=1e-11)
    direct = fa.frequency_map(body, z0, time=200.0)
    for given in ({"model": body}, {"signals": body.angles}):
        found = fa.orbit_frequencies(orbits, **given)
        assert found.names == direct.names
        assert (np.abs(found.nu - direct.nu) <= found.error + direct.error + 1e-11).all()
    same(
        fa.orbit_frequencies(orbits, model=body),
        fa.orbit_frequencies(orbits.samples.transpose(1, 2, 0), model=body, times=orbits.times),
    )


def test_orbits_that_end_and_orbits_too_coarse():
    cut = ARRAY.copy()
    cut[:, 1, 1500:] = np.nan
    cut[2, 2, 20:] = np.inf
    found = fa.orbit_frequencies(cut, DT)
    assert list(found.status) == [0, 1, 1, 0]
    assert found.error[0, 2] == np.inf
    assert found.classification[2] == Classification.UNDECIDED
    part = fa.orbit_frequencies(ARRAY[:, 1:2, : 1448 + 1], DT)  # 2^10.5 steps
    same(part.nu[:, 0], found.nu[:, 1])
    t = np.arange(500)
    fast = np.array([np.cos(2.5 * t), -np.sin(2.5 * t)])
    found = fa.orbit_frequencies(fast, 1.0)
    assert found.status[0] == fa.Status.NOT_CONVERGED
    assert found.error[0, 0] == np.inf
    assert fa.tunes(fast).nu[0, 0] == pytest.approx(2.5 / (2 * np.pi), abs=1e-14)


# --- where orbits lie ------------------------------------------------------------------------------------------------


class Lazy:
    """A data set of a file: a shape, a type and slices, and how much has been read of it at once."""

    def __init__(self, array):
        self._array, self.shape, self.dtype, self.most = array, array.shape, array.dtype, 0

    def __getitem__(self, index):
        part = self._array[index]
        self.most = max(self.most, part.size)
        return part

    def __array__(self, *_, **__):
        raise AssertionError("the whole of it was read")


def test_data_sets_are_read_some_orbits_at_a_time(monkeypatch):
    monkeypatch.setattr("fastaff.frequencies.orbit_frequencies.BUDGET", 8 * 4 * 2000 * 2)
    monkeypatch.setattr("fastaff.frequencies.tunes.BUDGET", 8 * 4 * 2000 * 2)
    source = Lazy(ARRAY)
    same(fa.orbit_frequencies(source, DT), fa.orbit_frequencies(ARRAY, DT))
    same(fa.tunes(source), fa.tunes(ARRAY))
    assert source.most == ARRAY.size // 2


def test_hdf5_and_zarr(tmp_path):
    whole = fa.orbit_frequencies(ARRAY, DT)
    named = dict(zip(("x", "y", "px", "py"), ARRAY, strict=True))
    by_name = fa.orbit_frequencies(named, DT, coordinates="x y px py")
    same(by_name.nu, whole.nu)
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "orbits.h5", "w") as file:
        file["all"] = ARRAY
        for name, rows in named.items():
            file[f"parts/{name}"] = rows
    with h5py.File(tmp_path / "orbits.h5") as file:
        same(fa.orbit_frequencies(file["all"], DT), whole)
        same(fa.orbit_frequencies(file["parts"], DT, coordinates=("x", "y", "px", "py")), by_name)
        same(fa.tunes(file["parts"], coordinates="x, y, px, py").nu, fa.tunes(ARRAY).nu)
        with pytest.raises(ValueError, match=r"coordinates must name the arrays of samples .* of the names .*'px'"):
            fa.tunes(file["parts"])
        with pytest.raises(ValueError, match=r"coordinates must be names in samples, which has .*, got 'pz'"):
            fa.tunes(file["parts"], coordinates="x, y, px, pz")
    zarr = pytest.importorskip("zarr")
    store = zarr.open_group(str(tmp_path / "orbits.zarr"), mode="w")
    store.create_array("all", data=ARRAY)
    for name, rows in named.items():
        store.create_array(name, data=rows)
    same(fa.orbit_frequencies(store["all"], DT), whole)
    same(fa.orbit_frequencies(store, DT, coordinates="x y px py"), by_name)


def test_xarray_by_the_names_of_its_dimensions():
    xarray = pytest.importorskip("xarray")
    interval = (OWN.times[-1] - OWN.times[0]) / 1999
    whole = fa.orbit_frequencies(ARRAY, interval)
    labelled = xarray.DataArray(ARRAY, dims=("coordinate", "particle", "turn"))
    turned = labelled.transpose("turn", "coordinate", "particle")
    same(fa.tunes(turned), fa.tunes(ARRAY))
    same(fa.orbit_frequencies(turned, interval), whole)
    timed = xarray.DataArray(OWN.samples, dims=("time", "coordinate", "orbit"), coords={"time": OWN.times})
    same(fa.orbit_frequencies(timed), whole)
    same(fa.orbit_frequencies(timed.isel(orbit=1)), whole.take(1))
    parts = xarray.Dataset(
        {name: (("time", "star"), OWN.samples[:, k]) for k, name in enumerate("xyuv")}, {"time": OWN.times}
    )
    same(fa.orbit_frequencies(parts, coordinates=tuple("xyuv")).nu, whole.nu)
    other = xarray.DataArray(ARRAY, dims=("coordinate", "a", "b"))
    with pytest.raises(ValueError, match=r"samples must have dimensions named like coordinate, orbit, sample, got \("):
        fa.tunes(other)


# --- what is wrong ---------------------------------------------------------------------------------------------------


def test_gaps_are_named_by_orbit_and_sample():
    for bad in (np.nan, np.inf):
        z = ARRAY.copy()
        z[1, 2, 700] = bad
        z[3, 2, 701] = bad
        for call in (lambda z=z: fa.orbit_frequencies(z, DT), lambda z=z: fa.tunes(z)):
            with pytest.raises(
                ValueError,
                match="samples must have no gaps: orbit 2 is not finite at sample 700 and goes on at sample 702",
            ):
                call()


def test_uneven_times_are_named_by_sample():
    times = DT * np.arange(2000)
    for k, bad, said in (
        (
            300,
            times[300] + 0.01,
            "times must be equidistant, got 0.(19|21) from sample (299|300) to (300|301), most often 0.2",
        ),
        (1999, np.nan, "times must be finite, got nan at sample 1999"),
    ):
        uneven = times.copy()
        uneven[k] = bad
        with pytest.raises(ValueError, match=said):
            fa.orbit_frequencies(ARRAY, times=uneven)
    skipped = np.delete(DT * np.arange(2001), 1200)
    with pytest.raises(ValueError, match=r"got 0.4 from sample 1199 to 1200, most often 0.2"):
        fa.orbit_frequencies(ARRAY, times=skipped)
    with pytest.raises(ValueError, match=r"times must have shape \(2000,\), one for each sample, got \(1999,\)"):
        fa.orbit_frequencies(ARRAY, times=times[1:])
    with pytest.raises(ValueError, match=r"times must increase, got 399.8\d* first and 0.0 last"):
        fa.orbit_frequencies(ARRAY, times=times[::-1])
    with pytest.raises(ValueError, match="dt must not be given beside times"):
        fa.orbit_frequencies(ARRAY, DT, times=times)
    with pytest.raises(ValueError, match="dt must be given, the time between samples"):
        fa.orbit_frequencies(ARRAY)
    noisy = times * (1 + 1e-15)
    same(fa.orbit_frequencies(ARRAY, times=noisy).status, np.zeros(4, np.int64))


def test_axes_in_another_order_are_shown_how_to_be_turned():
    for order, back in (((2, 1, 0), "2, 1, 0"), ((1, 2, 0), "2, 0, 1"), ((2, 0, 1), "1, 2, 0")):
        turned = ARRAY[:, :3].transpose(order)
        with pytest.raises(ValueError, match=rf"samples must have .*\. Try samples.transpose\({back}\)\."):
            fa.tunes(turned)
        same(fa.tunes(turned.transpose([int(k) for k in back.split(", ")])).nu, fa.tunes(ARRAY[:, :3]).nu)
    with pytest.raises(ValueError, match=r"at least 64 samples, got shape \(2000, 4\)\. Try samples\.T\."):
        fa.tunes(ARRAY[:, 0].T)
    with pytest.raises(ValueError, match=r"samples must have 2n rows q1, ..., qn, p1, ..., pn on the first axis"):
        fa.tunes(ARRAY[:3])
    with pytest.raises(ValueError, match="at least 64 samples, got shape"):
        fa.tunes(ARRAY[:, :, :63])
    with pytest.raises(ValueError, match=r"Use fa\.naff for positions alone"):
        fa.tunes(ARRAY[:1])


OBJECTS = np.empty(4, dtype=object)
OBJECTS[:] = list(ARRAY[:, 0])


@pytest.mark.parametrize(
    ("value", "error", "said"),
    [
        (ARRAY + 0j, TypeError, "samples must be real rows q1, ..., qn, p1, ..., pn, got complex numbers"),
        (
            np.ma.masked_invalid(np.where(ARRAY[0, 0, 3] == ARRAY, np.nan, ARRAY)),
            ValueError,
            "samples must have no masked entries",
        ),
        ("orbits", TypeError, "samples must be"),
        (None, TypeError, "samples must be"),
        (ARRAY > 0, TypeError, "samples must be an array of real numbers"),
        (
            OBJECTS,
            TypeError,
            r"real numbers, got objects of shape \(4,\)\. Use np.array\(samples.tolist\(\), dtype=float\)",
        ),
        (ARRAY[0, 0], ValueError, r"samples must have shape \(2n, orbits, samples\) or \(2n, samples\), got \(2000,\)"),
        (
            SimpleNamespace(samples=np.zeros((0, 4, 3)), times=np.zeros(0), names=OWN.names),
            ValueError,
            "must have samples: integrate",
        ),
        ({"x": ARRAY[0], "p": ARRAY[2, :2]}, ValueError, "samples must have arrays of one shape"),
    ],
)
def test_what_is_no_array_of_orbits_is_refused(value, error, said):
    coordinates = ("x", "p") if isinstance(value, dict) else None
    for call in (fa.tunes, lambda value, **given: fa.orbit_frequencies(value, DT, **given)):
        with pytest.raises(error, match=said):
            call(value, coordinates=coordinates)


def test_an_array_of_objects_is_taken_as_its_refusal_says():
    np.testing.assert_array_equal(fa.tunes(np.array(OBJECTS.tolist(), dtype=float)).nu, fa.tunes(ARRAY[:, 0]).nu)


def test_angles_and_bodies_that_do_not_suit():
    with pytest.raises(ValueError, match="signals must have 2 angles for samples of 4 rows"):
        fa.orbit_frequencies(ARRAY, DT, signals=AlphaBeta())
    with pytest.raises(
        TypeError, match=r"signals must be a text such as 'R z phi', or a value of fastaff.models.angles, got 3"
    ):
        fa.orbit_frequencies(ARRAY, DT, signals=3)
    with pytest.raises(ValueError, match="model must have 2 degrees of freedom for samples of 4 rows, got 4"):
        fa.orbit_frequencies(ARRAY, DT, model=fa.Body(fa.Hyperelastic()))
    with pytest.raises(ValueError, match="coordinates must be 4 names, one for each row of samples, got 2"):
        fa.orbit_frequencies(ARRAY, DT, coordinates="x p")
    with pytest.raises(ValueError, match="lines must be at least 1"):
        fa.orbit_frequencies(ARRAY, DT, lines=0)


def test_nothing_is_read_before_it_is_asked_for():
    given = given_orbits(Lazy(ARRAY), dt=0.2)
    assert given.shape == ARRAY.shape
    assert given.angles == ("q1", "q2")
    same(np.ascontiguousarray(given.read(1, 3)), np.ascontiguousarray(ARRAY[:, 1:3]))


def test_points_of_a_section_are_turns():
    """The tune of a section's points is minus their rotation number, counterclockwise, about the same curve."""
    cut = fa.poincare_map(HH, Z0[:, 1:], section="x=0", crossings=300, max_time=4000.0)
    found = fa.tunes(cut, coordinates=("y", "p_y"))
    plain = fa.tunes(np.array([cut["y"].T, cut["p_y"].T]), coordinates=("y", "p_y"))
    same(found, plain)
    turning = fa.rotation_number(np.array([cut["y"], cut["p_y"]]))
    apart = found.nu[0] + turning.rotation
    known = np.isfinite(found.error[0]) & (found.classification != Classification.IRREGULAR)
    assert (np.abs(apart - np.rint(apart)) <= found.error[0] + turning.error)[known].all()
    assert known.any()
    with pytest.raises(
        ValueError, match=r"coordinates must be given for points of a section, .* such as \('y', 'p_y'\)"
    ):
        fa.tunes(cut)


def test_rows_of_a_labelled_array_go_by_their_labels():
    xarray = pytest.importorskip("xarray")
    turn = np.arange(400)
    rows = np.array([np.cos(0.3 * turn), np.cos(1.1 * turn), -np.sin(0.3 * turn), -np.sin(1.1 * turn)])[:, None]
    exact = np.array([0.3, 1.1]) / (2 * np.pi)
    labels = {"coordinate": ["x", "px", "y", "py"]}
    mixed = xarray.DataArray(rows[[0, 2, 1, 3]], dims=("coordinate", "particle", "turn"), coords=labels)
    for array in (mixed, mixed.transpose("turn", "particle", "coordinate")):
        assert np.allclose(fa.tunes(array, coordinates="x y px py").nu[:, 0], exact, atol=1e-12)
        assert np.allclose(fa.tunes(array, coordinates=["y", "py"]).nu[:, 0], exact[1:], atol=1e-12)
        with pytest.raises(ValueError, match="coordinates='x y px py'"):
            fa.tunes(array)
        with pytest.raises(ValueError, match="got 'pz'"):
            fa.tunes(array, coordinates="x y px pz")
    plain = xarray.DataArray(rows, dims=mixed.dims)
    assert np.array_equal(fa.tunes(plain, coordinates="a b c d").nu, fa.tunes(rows).nu)


@pytest.mark.parametrize("samples", [512, 4096])
def test_errors_cover_noise(samples):
    """White noise and single precision: 99 % of the errors cover, none ten times beyond, of motion that is known."""
    rng = np.random.default_rng(41)
    omega = np.array([rng.uniform(0.3, 0.7, 150), rng.uniform(0.85, 1.3, 150)])
    amplitude, dt = np.exp(rng.normal(size=omega.shape)), 0.37
    theta = omega[:, :, None] * dt * np.arange(samples) + rng.uniform(0.0, 6.28, omega.shape)[:, :, None]
    q = amplitude[:, :, None] * np.cos(theta) * (1 + 0.1 * np.cos(theta[::-1]))
    z = np.concatenate([q, -(omega * amplitude)[:, :, None] * np.sin(theta)])
    clean = fa.orbit_frequencies(z, dt)
    for noisy in (z.astype(np.float32), *(z + level * rng.normal(size=z.shape) for level in (1e-7, 1e-4, 0.03))):
        found = fa.orbit_frequencies(noisy, dt)
        sure = clean.classification == Classification.REGULAR
        ratio = np.abs(np.abs(found.nu) - omega / (2 * np.pi)) / found.error
        ratio = np.where(np.isfinite(found.error), ratio, 0.0)  # where none is known, nothing is claimed
        assert sure.mean() > 0.3
        assert np.quantile(ratio[:, sure], 0.99) < 1
        assert ratio[:, sure].max() < 10
        regular = sure & (found.classification == Classification.REGULAR)
        assert np.median(ratio[:, regular]) > 0.001  # not merely large, as those of undecided orbits are
