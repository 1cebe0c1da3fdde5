"""Wells that samples of V do not see, far away or narrow; what refuses to compute says why."""

import numpy as np
import pytest
from numpy.random import default_rng
from scipy.linalg import eigh
from scipy.sparse import diags
from test_quantum_narrow import Plain, feature, lagrange, mesh

from fastaff import affine_body
from fastaff.core.status import Status
from fastaff.quantum import coherent_packet, spectrum
from fastaff.quantum.chaos.weyl_count import _integrals, _well
from fastaff.quantum.solvers.intervals import Interval, Sector, interval
from fastaff.quantum.solvers.separable import angular, radial
from fastaff.quantum.solvers.singular_ends import well
from fastaff.systems.models import Body, NeoHookean, SeparableAlphaBeta, SeparableRVartheta
from fastaff.systems.models.functions import Oscillator, Spring, univariate

FUNCTIONS = (
    *(getattr(np, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh", "cosh", "arctan", "arccos")),
    *(np.square, np.absolute, np.sinh, np.arcsin, np.negative, lambda x: x**3, lambda x: x**-2, lambda x: x**0.4),
    *(lambda x: 1.7 - x, lambda x: -0.3 * x * x, lambda x: 2**x, lambda x: np.where(x < 0.4, x, 1.5 - x)),
)
BOTH = (np.add, np.subtract, np.multiply, np.divide, np.maximum, np.minimum, np.hypot)


def drawn(rng, depth, x):
    """A random formula of the entries of x, as a function of them."""
    if depth == 0:
        k, c = int(rng.integers(len(x))), float(rng.normal())
        return lambda x: x[k] if c > 0 else x[k] + c
    parts = [drawn(rng, depth - 1, x) for _ in range(2)]
    if rng.random() < 0.6:
        f = FUNCTIONS[rng.integers(len(FUNCTIONS))]
        return lambda x: f(parts[0](x))
    g = BOTH[rng.integers(len(BOTH))]
    return lambda x: g(parts[0](x), parts[1](x))


@pytest.mark.parametrize("plane", [False, True])
def test_intervals_enclose_random_formulas(plane):
    rng, checked = default_rng(11), 0
    for _ in range(400):
        lo = rng.uniform([[0.1], [-1]], [[3], [0.9]], (2, 6))
        hi = lo + (np.array([[3.0], [1.0]]) - np.array([[0.0], [lo[1].max()]])) * 10 ** rng.uniform(-4, 0, (2, 6)) * 0.9
        hi[1] = np.minimum(hi[1], 1)
        q, x = lo[:, None] + (hi - lo)[:, None] * rng.random((2, 50, 6))
        given = (q * q * (1 + x) / 2, q * q * (1 - x) / 2) if plane else (q, x)
        boxes = Sector(lo, hi).squares() if plane else [Interval(*ends) for ends in zip(lo, hi, strict=True)]
        f = drawn(rng, int(rng.integers(1, 5)), given)
        with np.errstate(all="ignore"):
            value, found = f(given), interval(f(boxes))
        value = np.where(np.isnan(value), found.lo, value)  # where the formula does not live
        with np.errstate(invalid="ignore"):
            slack = np.nan_to_num(1e-9 * (1 + np.abs(value)), posinf=1.0)
            inside = (value >= found.lo - slack) & (value <= found.hi + slack)
        assert np.all(inside)
        checked += int(np.isfinite(found.lo).sum())
    assert checked > 1000


def sinc(V, unit, strength, place, width, reach):
    """Lowest level of -unit u'' + (unit strength/q^2 + V) u around a place, on equal steps: those of a sinc DVR."""
    h = min(width / 8, reach / 200)
    k = np.arange(-int(reach / h), int(reach / h) + 1)
    gap = k[:, None] - k
    np.fill_diagonal(gap, 1)
    T = unit / h**2 * 2 * (-1.0) ** gap / gap**2.0
    np.fill_diagonal(T, unit / h**2 * np.pi**2 / 3)
    q = place + h * k
    return eigh(T + np.diag(V(q) + unit * strength / q**2), eigvals_only=True, subset_by_index=(0, 0))[0]


EASY = 0, 2, 3, 4
SEEDS = [seed if seed in EASY else pytest.param(seed, marks=pytest.mark.slow) for seed in range(40)]


@pytest.mark.parametrize("seed", SEEDS)
def test_wells_far_away(seed):
    rng = default_rng(500 + seed)
    place, hbar, a = 10 ** rng.uniform(0.7, 2.5), rng.uniform(0.5, 1.2), int(rng.integers(0, 3))
    width, dimension = place * 10 ** rng.uniform(-5, -3), int(rng.choice([2, 4]))
    unit = hbar**2 / 2
    depth = 2 * place**2 + rng.uniform(6, 12) * unit / width**2
    pit = feature("Gauss", -depth, place, width)

    def V(q):
        return q**2 / 2 + pit(q)

    W = V if dimension == 2 else lambda r: V(np.sqrt(r))
    K = float(a * a if dimension == 2 else a * (a + 2))
    try:
        found = radial("V", Plain(W), dimension, np.array([K]), 1, hbar, 1.0, 1e-10)
        refused = ""
    except ValueError as problem:
        found, refused = None, str(problem)
    if found is None:  # a few take more functions than there may be, and are refused by name
        assert seed not in EASY
        assert "basis functions" in refused
        return
    strength = K + (dimension - 1) * (dimension - 3) / 4
    outside = np.sqrt(unit / (place**2 / 2 - found.values[0, 0]))
    truth = sinc(V, unit, strength, place, width, 6 * width + 36 * outside)
    assert truth < 0  # of the well, not of the oscillator
    assert np.abs(found.values[0, 0] - truth) <= found.error[0, 0] + (1e-12 if seed in EASY else 1e-10) * depth
    # Of the others some have errors of up to a few percent: NOT_CONVERGED.
    assert found.error[0, 0] <= (1e-9 if seed in EASY else 0.1) * abs(truth)
    assert not found.said


def test_wells_and_the_oscillator_beside_them():
    """Levels far above those of the well, closer to one another by orders: each is there."""
    V = univariate(lambda x: x**2 / 2 - 6000 * np.exp(-(((x - 90) / 0.05) ** 2)))
    found = spectrum(Body(SeparableAlphaBeta(V, Oscillator(1.0))), m=0, l=0, count=3)
    np.testing.assert_allclose(found.E, -929.000030631 + 2 * np.arange(3), atol=2e-9)
    deep = radial(
        "V", Plain(lambda x: x**2 / 2 - 6e6 * np.exp(-(((x - 90) / 1e-3) ** 2))), 2, np.zeros(1), 5, 1.0, 1.0, 1e-9
    )
    assert np.all(deep.values[0, :3] < -1e5)
    assert np.all(np.abs(deep.values[0, 3:] - [1, 3]) <= deep.error[0, 3:] + 1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_wells_in_vartheta(seed):
    rng = default_rng(70 + seed)
    c, width = rng.uniform(-0.8, 0.8), 10 ** rng.uniform(-5.5, -4)
    depth = rng.uniform(2, 6) * (1 - c * c) / width**2

    def V(x):
        return 3 * x - depth * np.exp(-(((x - c) / width) ** 2))

    found = angular("V", Plain(lambda v: V(np.cos(v))), np.zeros(1), np.zeros(1), 2, 1.0, 1.0, 1e-10)
    values, slopes, x, w = lagrange(np.union1d(np.linspace(-1, 1, 41), mesh(-1, 1, [(c, width)], 4)), 8)
    K = slopes.T @ diags(w * 2 * (1 - x**2)) @ slopes + values.T @ diags(w * V(x)) @ values
    truth = eigh(K.toarray(), (values.T @ diags(w) @ values).toarray(), eigvals_only=True, subset_by_index=(0, 0))
    assert truth[0] < -0.01 * depth
    assert abs(found.values[0, 0] - truth[0]) <= found.error[0, 0] + 1e-9 * depth


@pytest.mark.parametrize("seed", range(3))
def test_rings_and_spots_in_the_plane(seed):
    """Phase space of wells between the radii and angles of tables."""
    rng = default_rng(40 + seed)
    rho, angle = 10 ** rng.uniform(0, 1.5), rng.uniform(0.2, 1.3)
    width, depth = rho * 10 ** rng.uniform(-4, -3), rho**2 / 2 + 10 ** rng.uniform(1, 3)
    E = float(rng.uniform(-0.5, 0.9)) * (depth - rho**2 / 2)
    ring = affine_body("r/2 - h*exp(-((rho - c)/w)**2)", h=depth, c=rho, w=width)
    steps = np.union1d(
        np.linspace(0, max(2 * E, 0) ** 0.5 + 2 * rho, 200_001), rho + width * np.linspace(-9, 9, 400_001)
    )
    q = (steps[1:] + steps[:-1]) / 2
    room = np.maximum(E - q**2 / 2 + depth * np.exp(-(((q - rho) / width) ** 2)), 0)
    truth = (room * q * np.diff(steps)).sum() * np.pi / 2
    assert _integrals(_well(ring, 0.0, 0.0, E), np.array([E]))[0, 0] == pytest.approx(truth, rel=1e-6)
    a, b = rho * np.cos(angle), rho * np.sin(angle)
    spot = affine_body("r/2 - h*exp(-((alpha - c)/w)**2 - ((beta - d)/w)**2)", h=depth, c=a, d=b, w=width)
    x, y = np.meshgrid(*[width * np.linspace(-5, 5, 2001)] * 2)
    V = ((a + x) ** 2 + (b + y) ** 2) / 2 - depth * np.exp(-(x**2 + y**2) / width**2)
    truth = np.maximum(-0.2 * depth + rho**2 / 10 - V, 0).sum() * (width / 200) ** 2
    E = -0.2 * depth + rho**2 / 10
    assert E < 0
    assert _integrals(_well(spot, 0.0, 0.0, E), np.array([E]))[0, 0] == pytest.approx(truth, rel=1e-4)


def test_what_cannot_be_excluded_is_said():
    far = {"dimension": 2, "K": np.zeros(1), "count": 2, "hbar": 1.0, "mu": 1.0, "tolerance": 1e-10}
    loose = radial("V", Plain(lambda q: q * q / 2 + 1e14 * (q - q)), **far)  # intervals do not see that this is 0
    assert np.all(np.abs(loose.values - [1, 3]) <= loose.error)
    assert np.all(loose.error > 1)
    plain = univariate(lambda q: 0.5 * np.abs(np.interp(q, [0.0, 1e3], [0.0, 1e3])) ** 2, slope=lambda q: q)
    found = spectrum(Body(SeparableAlphaBeta(plain, Oscillator(1.0))), m=0, l=0, count=1)
    assert "known at points only" in found.method
    smooth = spectrum(Body(SeparableAlphaBeta(univariate(lambda q: q**4), Oscillator(1.0))), m=0, l=0, count=1)
    assert "known at points" not in smooth.method
    assert smooth.status[0] == Status.OK


# --- refusals ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_poles_are_told_from_narrow_hills(seed):
    rng = default_rng(seed)
    c, width = rng.uniform(0.3, 2.8), 10 ** rng.uniform(-7, -2)
    for sign in (-1, 1):
        smooth = feature(("Gauss", "Lorentz")[seed % 2], sign * 10 ** rng.uniform(0, 8), c, width)
        assert well("V", lambda v, smooth=smooth: np.cos(v) + smooth(v), 0.0, np.pi).natural_hi
        power = rng.choice([1, 2, 4])
        with pytest.raises(ValueError, match="V must be finite on one interval, got a pole at"):
            well("V", lambda v, power=power, sign=sign: sign / (v - c) ** power, 0.0, np.pi)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: affine_body("r/2 + 30*exp(-((alpha - c)/w)**2)", c=1.3, w=0.002),
            "needs .* more than .* V has narrow features",
        ),
        (lambda: affine_body("r/2 + 1/(r - c)**2", c=2.0), "pole at 1.41421"),
        (lambda: affine_body("r/2 + c/(rho - 2) + D1*D2/9", c=1.0), "pole at 2"),
        (lambda: affine_body("-k/rho + 0.1*D1*D2/(1 + r)", k=1.0), "needs .* more than .* for waves in rho = "),
    ],
)
def test_refusals_name_their_reason(call, words):
    with pytest.raises(ValueError, match=words) as told:
        spectrum(call(), m=0, l=0, count=1)
    assert "fewer" not in str(told.value)


def test_units_of_any_size():
    """The same body in other units of length: nothing is cut off at some number of them."""
    for size in (1e-6, 1e7):
        body = affine_body("r/2 + g*(D1*D2)**2", g=0.3 / size**2)
        found = spectrum(body, m=0, l=0, count=2, hbar=size**2, tolerance=1e-6)
        one = spectrum(affine_body("r/2 + g*(D1*D2)**2", g=0.3), m=0, l=0, count=2, tolerance=1e-6)
        np.testing.assert_allclose(found.E / size**2, one.E, rtol=2e-6)


def test_large_quantum_numbers_are_refused_by_name():
    with pytest.raises(ValueError, match="smaller m, l or count"):
        spectrum(Body(NeoHookean(1.0, 2.0)), m=10**6, l=0, count=1)
    with pytest.raises(ValueError, match="70711 symmetry classes or more"):
        coherent_packet(
            Body(NeoHookean(1.0, 2.0)), np.array([1.0, 0.0, 0.2, 0.0, 0.1, 0.3, 0.2, 0.1]), width=1e3, count=20
        )


@pytest.mark.parametrize("seed", range(3))
def test_narrow_wells_in_vartheta_of_a_body(seed):
    width = 10 ** default_rng(seed).uniform(-6, -4)
    V = univariate(lambda v: -5000 * np.exp(-(((v - 1.1) / width) ** 2)))
    found = spectrum(Body(SeparableRVartheta(Spring(1.0), V)), m=0, l=0, count=2)
    shift = -5000 * width * np.sqrt(np.pi) * np.sin(1.1) / 2  # of e_vartheta, to first order
    assert found.E[0] == pytest.approx(1 + np.sqrt(1 + 2 * shift), rel=0.05 * abs(shift) ** 0.5 + 1e-6)
