"""Rotation numbers and islands against closed forms: circles, ellipses, the area-preserving quadratic and standard
maps.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fastaff
from fastaff import Classification, Status
from fastaff.sections.islands import islands, rotation_number

GOLDEN = (math.sqrt(5) - 1) / 2


def ellipse(rho, crossings, a=1.0, b=0.5, centre=(0.0, 0.0), start=0.0):
    """Return points (2, crossings) of a rotation by rho turns, made elliptic."""
    t = 2 * np.pi * (start + rho * np.arange(crossings))
    return np.array([centre[0] + a * np.cos(t), centre[1] + b * np.sin(t)])


def chain(p, q, inner, crossings, radius=1.0, a=0.1, b=0.05):
    """Return points (2, crossings) of q ellipses with half-axes a (radial), b (along), visited p at a time."""
    n = np.arange(crossings)
    t, place = 2 * np.pi * inner * n / q, 2 * np.pi * p * n / q
    along = (radius + a * np.cos(t)) + 1j * b * np.sin(t)
    z = along * np.exp(1j * place)
    return np.array([z.real, z.imag])


def quadratic(x, y, cosine, sine, crossings):
    """Return crossings (2, crossings, orbits) of Henon's map: a rotation after the shear y - x^2. Source: Henon
    1969.
    """
    points = np.empty((2, crossings, x.size))
    for n in range(crossings):
        points[:, n] = x, y
        shear = y - x * x
        x, y = x * cosine - shear * sine, x * sine + shear * cosine
    return points


def standard(K, x, y, crossings, folds=1):
    """Return x, y (crossings, orbits) of y' = y + K/(2 pi folds) sin(2 pi folds x), x' = x + y'. Source: Chirikov
    1979.
    """
    path = np.empty((2, crossings, x.size))
    for n in range(crossings):
        path[:, n] = x, y
        y = y + K / (2 * np.pi * folds) * np.sin(2 * np.pi * folds * x)
        x = x + y
    return path


def annulus(x, y, radius=3.0):
    """Return the points (2, ...) of angles x (turns) and heights y drawn as a ring."""
    return np.array([(radius + y) * np.cos(2 * np.pi * x), (radius + y) * np.sin(2 * np.pi * x)])


@given(st.floats(0.1, 0.4), st.sampled_from([1, -1]), st.floats(0.3, 3.0), st.floats(-0.2, 0.2), st.booleans())
def test_rotation_of_an_ellipse(rho, sign, b, off, known):
    """Any axes, any centre inside; the error estimate covers the error."""
    found = rotation_number(
        ellipse(sign * rho, 1000, b=b, centre=(2.0, 1.0)), centre=(2.0 + off, 1.0 + b * off) if known else None
    )
    assert found.status[0] == Status.OK
    assert abs(found.rotation[0] - sign * rho) <= found.error[0]
    assert found.error[0] < 1e-3


def drawn_curve(rng, bent):
    """Return the rotation number, near a rational of low order in two of three cases, and points of a rotated ellipse
    of any aspect, perhaps bent, with rows in any units and the origin anywhere.
    """
    crossings, q = int(10 ** rng.uniform(1.6, 3.4)), int(rng.integers(1, 14))
    near = rng.integers(0, q) / q
    rho = [rng.uniform(), near + 10 ** rng.uniform(-6, -1) / q, near + rng.uniform(-3, 3) / crossings / q][
        rng.integers(3)
    ]
    t = 2 * np.pi * (rng.uniform() + rho * np.arange(crossings))
    radius = 1 + bent * rng.uniform(0, 0.2) * np.cos(2 * t + rng.uniform(0, 6))
    t = t + bent * rng.uniform(0, 0.3) * np.sin(t + rng.uniform(0, 6))
    z = (radius * np.cos(t) + 1j * 10 ** rng.uniform(-4, 4) * radius * np.sin(t)) * np.exp(1j * rng.uniform(0, 6))
    points = np.array([z.real, z.imag]) * 10 ** rng.uniform(-4, 4, (2, 1))
    far = rng.choice([0, 1, 30]) * rng.standard_normal((2, 1)) * np.abs(points).max(axis=1, keepdims=True)
    return rho, points + far


@pytest.mark.parametrize("bent", [0, 1])
def test_errors_of_rotation_cover_whatever_the_units_and_the_shape(bent):
    """Ellipses of aspect 1e-4 ... 1e4 at any angle, and bent ones: 99 % within their errors, none ten times beyond."""
    rng = np.random.default_rng(47 + bent)
    ratio, errors = [], []
    for _ in range(300):
        rho, points = drawn_curve(rng, bent)
        found = rotation_number(points)
        ratio.append(abs((found.rotation[0] - rho + 0.5) % 1 - 0.5) / found.error[0])
        errors.append(found.error[0])
    assert np.mean(np.array(ratio) <= 1) >= 0.99
    assert max(ratio) <= 10
    assert np.median(errors) < 1e-4


@pytest.mark.parametrize("unit", [1e-4, 1e-2, 1.0, 1e3])
def test_rotation_does_not_depend_on_the_unit_of_a_row(unit):
    """A circle beside 5/13 is known to rounding, whatever the unit of p."""
    rho = 5 / 13 + 1e-4
    found = rotation_number(ellipse(rho, 2000, b=unit))
    assert found.rotation[0] == pytest.approx(rho, abs=1e-13)
    assert found.error[0] < 1e-7


@pytest.mark.parametrize("unit", [1e-4, 1e-2, 30.0])
def test_turning_within_islands_does_not_depend_on_the_unit_of_a_row(unit):
    """Chains of circles, turning beside 5/13, with p in other units."""
    inner = 5 / 13 + 1e-4
    for p, q in ((1, 3), (2, 5), (1, 4)):
        found = islands(chain(p, q, inner, 1500 * q, a=0.05, b=0.05) * np.array([[1.0], [unit]]))
        assert (found.p[0], found.q[0], found.classification[0]) == (p, q, Classification.RESONANT)
        assert abs(found.secondary_rotation[0] - inner) <= found.secondary_rotation_error[0] < 1e-6


def test_rotation_reaches_rounding():
    """A golden ellipse: from 1000 crossings on all digits, whatever the branch of the rotation number; 2000 from
    another centre.
    """
    for rho in (GOLDEN - 1, 1 - GOLDEN, 0.5 - 0.02 * GOLDEN, GOLDEN / 2):
        found = rotation_number(np.stack([ellipse(rho, 2000), ellipse(rho, 2000, b=2.0)], axis=-1))
        assert found.rotation == pytest.approx(rho, abs=1e-13)
    found = rotation_number(ellipse(GOLDEN - 1, 3000), centre=(0.3, 0.1))
    assert found.rotation[0] == pytest.approx(GOLDEN - 1, abs=1e-12)
    assert found.digits[0] > 10


@pytest.mark.parametrize("alpha", [0.7, 1.3, 2.2])
def test_rotation_at_an_elliptic_point(alpha):
    """arccos(trace/2)/2 pi of the linear map, approached like the square of the amplitude."""
    amplitude = np.array([1e-3, 2e-3])
    points = quadratic(amplitude, 0 * amplitude, math.cos(alpha), math.sin(alpha), 3000)
    found = rotation_number(points, centre=(0.0, 0.0))
    linear = math.acos((2 * math.cos(alpha)) / 2) / (2 * math.pi)
    shift = np.abs(found.rotation - linear)
    assert shift.max() < 1e-5
    # The next term is of relative size amplitude^2 over the squared distance to the resonance 1/3, 0.017 turns for 2.2.
    assert shift[1] / shift[0] == pytest.approx(4.0, rel=1e-2)
    assert (islands(points).classification == Classification.REGULAR).all()


@pytest.mark.parametrize(("p", "q"), [(1, 2), (1, 3), (-1, 3), (2, 5), (3, 7), (-4, 9), (5, 24)])
def test_chain_of_ellipses(p, q):
    """Rotation p/q, q islands with the centres, semi-axes and secondary rotation number that they were made with."""
    inner, crossings = GOLDEN - 1, 200 * q
    found = islands(chain(p, q, inner, crossings))
    assert found.classification[0] == Classification.RESONANT
    assert (found.p[0], found.q[0]) == (p, q)
    place = 2 * np.pi * p * np.arange(q) / q
    direction = np.array([np.cos(place), np.sin(place)])
    assert found.centres[:, :, 0] == pytest.approx(direction, abs=1e-5)
    # Half-extents of an ellipse turned by `place`; 200 points of a golden rotation miss an end by at most (pi/200)^2 of
    # it or so.
    size = np.hypot(0.1 * direction, 0.05 * direction[::-1])
    assert found.semi_axes[:, :, 0] == pytest.approx(size, rel=2e-3)
    # The second half-window of 100 visits resolves the inner rotation number to a few digits.
    assert found.secondary_rotation[0] == pytest.approx(inner, abs=max(found.secondary_rotation_error[0], 1e-12))
    assert found.secondary_rotation_error[0] < 1e-2
    assert found.table()[0][:3] == (p, q, 1)


def test_a_periodic_orbit_is_islands_without_size():
    found = islands(np.stack([chain(1, 5, 0.2, 500, a=0.0, b=0.0), np.full((2, 500), 0.7)], axis=-1), centre=(0.0, 0.0))
    assert found.classification.tolist() == [Classification.RESONANT] * 2
    assert found.q.tolist() == [5, 1]
    assert np.nanmax(found.semi_axes) < 1e-12


def test_width_of_the_main_island_of_the_standard_map():
    """Half-width sqrt(K)/pi in y at the elliptic point (pendulum; next order K^(3/2)): seen from the middle of the
    ring.
    """
    K = 0.02
    half = math.sqrt(K) / math.pi
    y = half * np.array([0.2, 0.5, 0.9, 0.97, 1.03, 1.1, 1.5])
    x, y = standard(K, np.full(y.shape, 0.5), y, 4000)
    found = islands(annulus(x, y), centre=(0.0, 0.0))
    assert found.classification.tolist() == [Classification.RESONANT] * 4 + [Classification.REGULAR] * 3
    assert found.q[:4].tolist() == [1] * 4
    # Outside, the rotation number is the mean of y: positive and growing from the separatrix on.
    assert (np.diff(found.rotation.rotation[4:]) > 0).all()
    assert (found.rotation.rotation[4:] > 1e-3).all()


@pytest.mark.parametrize(("p", "folds"), [(1, 3), (2, 5)])
def test_width_of_a_chain_by_the_pendulum(p, folds):
    """m-fold kicks make m islands at y = p/m with half-width sqrt(K)/(pi m): the standard map of (m x, m y), turned by
    p/m.
    """
    K = 0.02
    half = math.sqrt(K) / (math.pi * folds)
    offset = half * np.array([0.1, 0.6, 0.95, 1.05, 1.4])
    x, y = standard(K, np.full(5, 0.5 / folds if folds % 2 == 0 else 0.5), p / folds + offset, 6000, folds)
    found = islands(annulus(x, y), centre=(0.0, 0.0))
    assert found.classification.tolist() == [Classification.RESONANT] * 3 + [Classification.REGULAR] * 2
    assert (found.q[:3] == folds).all()
    assert (found.p[:3] == p).all()
    # Radial extent of the islands in the ring, which cuts each at the angle of its centre: see one in (x, y) itself.
    top = y[:, 2].max() - p / folds
    assert top == pytest.approx(0.95 * half, rel=0.02)


def test_libration_inside_the_island_is_the_pendulum():
    """Small librations of the standard map about (1/2, 0): arccos(1 - K/2)/2 pi; seen from the ring it is the secondary
    number.
    """
    K = 0.3
    x, y = standard(K, np.array([0.5 + 1e-4]), np.zeros(1), 3000)
    plane = np.array([x - 0.5, y])
    linear = math.acos(1 - K / 2) / (2 * math.pi)
    assert abs(rotation_number(plane, centre=(0.0, 0.0)).rotation[0]) == pytest.approx(linear, abs=1e-7)
    ring = islands(annulus(x, y), centre=(0.0, 0.0))
    assert (ring.classification[0], ring.p[0], ring.q[0]) == (Classification.RESONANT, 0, 1)
    assert abs(ring.secondary_rotation[0]) == pytest.approx(linear, abs=1e-7)


def test_chaos_does_not_converge():
    """Standard map at K = 8: two or so digits at most, like N^(-1/2); at K = 0.3 all but the orbits beside a separatrix
    do.
    """
    y = np.linspace(0.013, 0.49, 60)
    x, height = standard(8.0, np.full(y.shape, 0.5), y, 2000)
    found = islands(np.array([x % 1 - 0.5, (height + 0.5) % 1 - 0.5]), centre=(0.0, 0.0))
    assert (found.classification == Classification.CHAOTIC).all()
    assert np.median(found.rotation.digits) < 2
    x, height = standard(0.3, np.full(y.shape, 0.5), y, 4000)
    regular = islands(annulus(x, height), centre=(0.0, 0.0))
    assert (regular.classification != Classification.CHAOTIC).mean() > 0.9
    assert "regular" in regular.summary()


SMOOTH = {
    "ellipses": lambda rng, n: np.stack(
        [ellipse(rng.uniform(-0.5, 0.5), n, b=10 ** rng.uniform(-3, 0)) for _ in range(40)], axis=-1
    ),
    "Henon": lambda rng, n: quadratic(rng.uniform(0.02, 0.25, 40), np.zeros(40), math.cos(1.28), math.sin(1.28), n),
    "standard": lambda rng, n: annulus(*standard(0.2, rng.random(40), rng.uniform(0, 0.5, 40), n)),
    "chains": lambda rng, n: np.stack(
        [chain(1, q, rng.random(), n, a=0.2 * rng.random(), b=0.1 * rng.random()) for q in range(2, 32)], axis=-1
    ),
}


@pytest.mark.parametrize("make", SMOOTH.values(), ids=SMOOTH)
@pytest.mark.parametrize("crossings", [64, 130, 260, 520])
def test_few_crossings_of_smooth_curves_are_no_chaos(make, crossings):
    """Their rotation numbers have few digits yet, close to rationals above all: undecided, and decided by more
    crossings.
    """
    points = make(np.random.default_rng(7), crossings)
    found = islands(points)
    if make is not SMOOTH["ellipses"] or crossings < 256:  # these are known to rounding once they have gone around
        assert (found.rotation.digits < 4).mean() > 0.02, "the test can fail"
    assert not (found.classification == Classification.CHAOTIC).any(), found.summary()


def test_chaos_is_seen_in_a_few_hundred_crossings():
    """Standard map at K = 6, and the sea around the islands of K = 1.5."""
    rng = np.random.default_rng(8)
    x, y = standard(6.0, rng.random(40), rng.random(40), 300)
    strong = islands(np.array([x % 1 - 0.5, (y + 0.5) % 1 - 0.5]), centre=(0.0, 0.0))
    assert (strong.classification == Classification.CHAOTIC).mean() > 0.9
    x, y = standard(1.5, 1e-3 * rng.random(30), 1e-3 * rng.random(30), 1000)
    sea = islands(annulus(x, (y + 0.5) % 1 - 0.5), centre=(0.0, 0.0))
    assert (sea.classification == Classification.CHAOTIC).mean() > 0.9
    assert not np.isin(sea.classification, (Classification.REGULAR, Classification.RESONANT)).any()


def test_a_curve_close_to_a_rational_is_not_islands():
    """Ellipses at 1/3 + 1e-3 and + 1e-4 in 20 000 points; at 1/3 + 1e-15 it is a periodic orbit."""
    found = islands(np.stack([ellipse(1 / 3 + d, 20_000) for d in (1e-3, 1e-4)], axis=-1))
    assert (found.classification == Classification.REGULAR).all()
    slow = islands(ellipse(1 / 3 + 1e-15, 400)[:, :, None])
    assert slow.q[0] == 3, "a periodic orbit to rounding"


def test_islands_that_have_not_turned_yet_are_undecided():
    """A quarter of a turn in islands of size 1e-5 around 1/3: p/q within its error, and nobody knows whether they come
    back.
    """
    found = islands(chain(1, 3, 0.00245, 300, a=1e-5, b=1e-5))
    assert found.classification[0] == Classification.UNDECIDED
    assert (found.p[0], found.q[0]) == (1, 3)
    longer = islands(chain(1, 3, 0.00245, 3000, a=1e-5, b=1e-5))
    assert longer.classification[0] == Classification.RESONANT


def test_padding_and_few_points():
    """NaN past the last point changes nothing; less than 32 points have a status and no kind."""
    long = ellipse(GOLDEN - 1, 400)
    points = np.full((2, 500, 3), np.nan)
    points[:, :400, 0], points[:, :20, 1] = long, long[:, :20]
    found = islands(points)
    alone = rotation_number(long)
    assert found.rotation.rotation[0] == alone.rotation[0]
    assert found.rotation.counts.tolist() == [400, 20, 0]
    assert found.status.tolist() == [Status.OK, Status.TOO_FEW_CROSSINGS, Status.TOO_FEW_CROSSINGS]
    assert found.classification[1:].tolist() == [Classification.UNDECIDED] * 2
    assert np.isinf(found.rotation.error[1:]).all()
    with pytest.raises(fastaff.OrbitError):
        found.raise_if_failed()


@pytest.mark.parametrize(("section", "free"), [("alpha-turning", "beta"), ("beta-turning", "alpha")])
@pytest.mark.parametrize("straight", [False, True])
def test_sections_of_a_body_are_taken(section, free, straight):
    """Two oscillators in the planes a and b, of frequencies w: a radius has twice that of its plane, a signed place on
    a line through the centre that of the plane.
    """
    rng = np.random.default_rng(7)
    a, b = rng.uniform(0.5, 3.0, 2)
    body = fastaff.affine_body("a*alpha**2/2 + b*beta**2/2", a=a, b=b)
    about = {"p_eta": 0.3, "p_gamma": 0.2}
    if straight:
        about["p_gamma" if free == "beta" else "p_eta"] = 0.0
    z0 = fastaff.energy_sample(body, energy=4.0, section=section, orbits=3, seed=1, **about)
    cut = fastaff.poincare_map(body, z0, section=section, crossings=300, max_time=4000.0)
    found = rotation_number(cut)
    ratio = np.sqrt(b / a if free == "beta" else a / b) / (2 if straight else 1)
    off = found.rotation + ratio
    assert (found.status == Status.OK).all()
    assert (np.abs(off - np.rint(off)) <= found.error).all()
    assert (found.error < (1e-6 if straight else 0.06)).all()
    if not straight:
        by_hand = rotation_number(np.array([cut[free], cut[f"p_{free}"]]))
        np.testing.assert_allclose(by_hand.rotation, found.rotation, atol=1e-9)
    assert len(islands(cut)) == 3


def test_the_hint_of_a_section_names_rows_that_it_has():
    body = fastaff.Body(fastaff.NeoHookean())
    z0 = fastaff.energy_sample(body, energy=1.5, section="area=1", p_eta=0.3, p_gamma=0.2, orbits=1)
    cut = fastaff.poincare_map(body, z0, section="area=1", crossings=40, max_time=900.0)
    with pytest.raises(ValueError, match="points must be a SectionMap") as refusal:
        rotation_number(cut)
    hint = str(refusal.value).split("Try ")[1].removesuffix(".")
    assert hint == "np.array([found['beta'], found['p_beta']])"
    assert rotation_number(eval(hint, {"np": np, "found": cut})).rotation.shape == (1,)


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda: rotation_number(np.ones((3, 5))), ValueError, "points must have shape"),
        (lambda: rotation_number(np.ones(2)), ValueError, "points must have shape"),
        (lambda: rotation_number("ab"), TypeError, "points must be an array"),
        (lambda: rotation_number(np.ones((2, 40)), centre=(1.0, np.nan)), ValueError, "centre must be a finite point"),
        (lambda: islands(np.ones((2, 40)), max_islands=0), ValueError, "max_islands must be at least 1"),
        (lambda: islands(np.ones((2, 40)), digits=0), ValueError, "digits must be positive"),
    ],
)
def test_wrong_input(call, error, match):
    with pytest.raises(error, match=match):
        call()
