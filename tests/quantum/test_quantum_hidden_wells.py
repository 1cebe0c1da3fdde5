"""Levels of vibrations whose wells are far from the origin, narrow, many, stiff or aslant, against finite elements."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import diags
from test_quantum_narrow import lagrange

import fastaff as fa
from fastaff.quantum import NoGroundState, quasiclassical_levels, spectrum
from fastaff.quantum.solvers.hidden_wells import Boxes
from fastaff.quantum.solvers.lattice import LatticeProblem
from fastaff.sections.accessible_box import minima, potential_of

FUNCTIONS = {"exp": np.exp, "cosh": np.cosh}


def on_a_line(text, ends, count):
    """Levels of p^2/2 + V(u) by equal finite elements: slivers between nearly equal edges would spoil their digits."""
    edges = np.linspace(*ends, 241)  # elements no wider than the narrowest feature
    values, slopes, x, w = lagrange(edges, 8)
    V = eval(text, {"u": x, **FUNCTIONS})
    K = slopes.T @ diags(w / 2) @ slopes + values.T @ diags(w * V) @ values
    M = values.T @ diags(w) @ values
    return eigh(K.toarray(), M.toarray(), eigvals_only=True, subset_by_index=(0, count - 1))


def pits(rng):
    """An oscillator with one or two narrow wells away from its middle."""
    k, text = float(rng.uniform(0.5, 2)), ""
    for side in (-1, 1)[: rng.integers(1, 3)]:
        place, width = float(side * rng.uniform(3, 15)), float(10 ** rng.uniform(-0.6, 0.1))
        depth = float(k * place**2 / 2 * rng.uniform(0.7, 1.3) + rng.uniform(2, 8) / width**2)
        text += f" - {depth!r}*exp(-((u - ({place!r}))/{width!r})**2)"
    return f"{k / 2!r}*u**2{text}", (-25.0, 25.0)


def morse(rng):
    D, a, c = (float(x) for x in rng.uniform([8, 0.3, -30], [20, 0.6, 30]))
    return f"{D!r}*(1 - exp(-{a!r}*(u - ({c!r}))))**2", (c - 6, c + 40)


def quartic(rng):
    h, b, c = (float(x) for x in rng.uniform([0.3, 0.5, -20], [2, 2.5, 20]))
    return f"{h!r}*((u - ({c!r}))**2 - {b * b!r})**2", (c - b - 6, c + b + 6)


def covered(found, truth, slack=1e-9):
    """Levels within their errors, OK only where these are small."""
    assert (np.abs(found.E - truth) <= found.error + slack * np.abs(truth)).all(), (found.E, truth, found.error)
    small = found.error <= found.call.arguments["tolerance"] * np.maximum(np.abs(truth), 1.0) * 10
    assert (small | ~found.converged).all()


@pytest.mark.parametrize("seed", [*range(3), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 60))])
@pytest.mark.parametrize("shape", [pits, morse, quartic])
def test_wells_on_a_line(shape, seed):
    rng = np.random.default_rng([seed, 47])
    text, ends = shape(rng)
    count = int(rng.integers(1, 4))
    try:
        found = spectrum(fa.hamiltonian(text.replace("u", "x"), coordinates="x"), count=count, tolerance=1e-8)
    except ValueError:  # two wells that no uniform grid holds
        if shape is not pits:
            raise
        return
    covered(found, on_a_line(text, ends, count))


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 20))])
def test_wells_of_two_coordinates_aslant(seed):
    """V(u) + W(v) with u, v turned against the coordinates: sums of the levels of lines."""
    rng = np.random.default_rng([seed, 48])
    angle, sums, texts = rng.uniform(0, np.pi), np.zeros(1), []
    c, s = float(np.cos(angle)), float(np.sin(angle))
    for shape, side in zip(
        rng.choice([pits, quartic], 2), (f"({c!r}*x + {s!r}*y)", f"({c!r}*y - {s!r}*x)"), strict=True
    ):
        text, ends = shape(rng)
        sums = np.sort(np.add.outer(sums, on_a_line(text, ends, 3)).ravel())
        texts.append(text.replace("u", side))
    try:
        found = spectrum(fa.hamiltonian(" + ".join(texts), coordinates="x y"), count=2, tolerance=1e-6)
    except ValueError:
        return
    covered(found, sums[:2])


def in_a_box(V, place, size, points=41):
    """Lowest level of a well in the plane on equal steps around a place: those of a sinc DVR."""
    step = 2 * size / points
    k = np.arange(points)
    apart = k[:, None] - k
    T = np.where(apart == 0, np.pi**2 / 6, (-1.0) ** apart / np.where(apart == 0, 1, apart) ** 2.0) / step**2
    x, y = (c + (k - (points - 1) / 2) * step for c in place)
    unit = np.eye(points)
    H = np.kron(T, unit) + np.kron(unit, T) + np.diag(V(x[:, None], y).ravel())
    return eigh(H, eigvals_only=True, subset_by_index=(0, 0))[0]


@pytest.mark.parametrize("seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 40))])
def test_a_pit_in_the_plane(seed):
    """Samples around the origin do not see it: the oscillator's levels 1, 2, 2 were given instead."""
    rng = np.random.default_rng([seed, 49])
    a, b = (float(x) for x in rng.normal(size=2) * 10 ** rng.uniform(0.5, 1.3))
    w = float(10 ** rng.uniform(-0.5, 0.2))
    h = float((a * a + b * b) / 2 * rng.uniform(1, 1.6) + rng.uniform(6, 14) / w**2)
    text = f"(x**2 + y**2)/2 - {h!r}*exp(-((x - ({a!r}))**2 + (y - ({b!r}))**2)/{w!r}**2)"

    def V(x, y):
        return (x**2 + y**2) / 2 - h * np.exp(-((x - a) ** 2 + (y - b) ** 2) / w**2)

    found = spectrum(fa.hamiltonian(text, coordinates="x y"), count=1, tolerance=1e-8)
    truth = in_a_box(V, (a, b), min(2.5 * w, 7 * (w / np.sqrt(2 * h)) ** 0.5))
    assert truth < 0
    covered(found, truth, 2e-6)


def test_the_pit_that_was_missed():
    text = "(x**2 + y**2)/2 - h*exp(-((x - 9)**2 + (y - 9)**2)/w**2)"
    found = spectrum(fa.hamiltonian(text, coordinates="x y", h=151.0, w=0.8), count=1)
    assert abs(found.E[0] + 49.2406) <= found.error[0] + 1e-4
    assert found.error[0] < 0.1


def test_a_well_on_a_plain():
    """V is 0 to the last digit at all points from which descents begin."""
    found = spectrum(fa.hamiltonian("-500*exp(-(x - 9)**2/0.1)", coordinates="x"), count=2)
    truth = on_a_line("-500*exp(-(u - 9)**2/0.1)", (-11.0, 29.0), 2)
    covered(found, truth)


@pytest.mark.parametrize("aslant", [False, True])
def test_a_stiff_mode_beside_a_soft_one(aslant):
    x, y = ("(x + y)/sqrt(2)", "(x - y)/sqrt(2)") if aslant else ("x", "y")
    text = f"({{0}}**2*({x})**2 + ({y})**2/{{0}}**2)/2"
    found = spectrum(fa.hamiltonian(text.format(6.0), coordinates="x y"), count=2, tolerance=1e-3)
    covered(found, 3 + 1 / 12 + np.arange(2) / 6)
    assert found.error.max() < 0.1
    with pytest.raises(ValueError, match="count = 2 needs"):
        spectrum(fa.hamiltonian(text.format(300.0), coordinates="x y"), count=2)


@pytest.mark.parametrize(
    ("text", "names", "words"),
    [
        ("-1/sqrt(x**2 + y**2)", "x y", "V has a pole at .* it binds levels"),
        ("-1/sqrt(x**2 + y**2 + z**2)", "x y z", "V has a pole at .* it binds levels"),
        ("-1/(x**2 + y**2)**1.5", "x y", "V has a pole at .* there may be no lowest level"),
        ("-0.05*exp(-x**2)", "x", "waves of so weakly bound levels are too wide"),
        ("x**2*y**2/2", "x y", "valleys without end.* levels may exist"),
    ],
)
def test_levels_that_a_grid_does_not_hold_are_not_denied(text, names, words):
    with pytest.raises(NoGroundState, match=words) as told:
        spectrum(fa.hamiltonian(text, coordinates=names), count=1)
    assert "holds a level" not in str(told.value)


def test_too_many_points_of_a_line_are_refused():
    with pytest.raises(ValueError, match="count = 5000 needs 8193 points of one coordinate, more than 4096"):
        spectrum(fa.hamiltonian("x**2/2", coordinates="x"), count=5000)


@pytest.mark.parametrize(
    "text", ["x**4 - 3*x*y + y**2/(1 + x**2)", "exp(-(x - 2)**2 - y**2)*x + cosh(y)", "x**3*y - sin(x*y)/(2 + y**2)"]
)
def test_bounds_enclose_the_potential(text):
    rng = np.random.default_rng(9)
    model = fa.hamiltonian(text, coordinates="x y")
    V = potential_of(model)
    boxes = Boxes(
        model, LatticeProblem(V, np.zeros((2, 1)), np.zeros(1), np.zeros(2), np.eye(2)), np.full((2, 1), np.inf)
    )
    low = rng.normal(size=(2, 200)) * 2
    high = low + 10 ** rng.uniform(-3, 0.5, (2, 200))
    floor, ceiling, flat = boxes.bounds(low, high)
    inside = V(low[:, None] + (high - low)[:, None] * rng.random((2, 300, 200)))
    slack = 1e-12 * (1 + np.abs(inside).max(axis=0))
    assert (inside.min(axis=0) >= floor - slack).all()
    assert (inside.max(axis=0) <= ceiling + slack).all()
    wells = minima(V, 2)[0] if text.startswith("x**4") else np.zeros((2, 0))
    held = ((wells[:, :, None] > low[:, None]) & (wells[:, :, None] < high[:, None])).all(axis=0).any(axis=0)
    assert flat[held].all()


@pytest.mark.slow
def test_three_uncoupled_quartics_have_quasiclassical_levels():
    """They were NaN: the series of three angles has more terms than a fit takes. The actions are quadratures."""
    from scipy.optimize import brentq

    t, weights = np.polynomial.legendre.leggauss(200)

    def action(E, k, g):
        square = (np.sqrt(k * k / 4 + 4 * g * E) - k / 2) / (2 * g)  # a^2 of the turning points q = +-a
        # E - k q^2/2 - g q^4 = (a^2 - q^2)(k/2 + g (a^2 + q^2)), which no rounding makes negative at the ends.
        rest = k / 2 + g * square * (1 + np.sin(t * np.pi / 2) ** 2)
        return np.pi * square * (np.sqrt(2 * rest) * np.cos(t * np.pi / 2) ** 2) @ weights

    n, k = (2, 1, 3), (3.0, 2.0, 1.0)
    truth = sum(
        brentq(lambda E, k=k, n=n: action(E, k, 0.1) - 2 * np.pi * (n + 0.5), 1e-9, 1e3, xtol=1e-13)
        for n, k in zip(n, k, strict=True)
    )
    model = fa.hamiltonian("(x**2 + 2*y**2 + 3*z**2)/2 + 0.1*(x**4 + y**4 + z**4)", coordinates="x y z")
    found = quasiclassical_levels(model, n=n)
    assert abs(found.E[0] - truth) <= found.error[0] < 1e-3
