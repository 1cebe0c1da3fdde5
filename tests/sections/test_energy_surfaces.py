"""Energy surfaces of any H(q, p): grids, random points in the invariant measure and edges, against truths."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.stats import ks_2samp

import fastaff as fa
from fastaff.sections.energy_shell import EnergyShell
from fastaff.sections.invariant_measure import LineMeasure, measure_of
from fastaff.sections.section_points import lift_sheets
from fastaff.systems.models.contracts import Kind
from fastaff.systems.models.mechanics import system_of

RNG = np.random.default_rng(320)
DOUBLE = fa.models.DoublePendulum


class WithMomenta(NamedTuple):
    """Henon-Heiles with masses in a turning frame, told as an H(q, p) of its own."""

    m: float = 1.0
    w: float = 0.0
    lam: float = 1.0

    degrees_of_freedom = 2
    kind = Kind.NONSEPARABLE
    coordinates = ("x", "y")

    def energy(self, x, y, p, s):
        T = (p * p + s * s) / (2 * self.m) - self.w * (x * s - y * p)
        return T + (x * x + y * y) / 2 + self.lam * (x * x * y - y * y * y / 3)

    def rates(self, x, y, p, s):
        fx, fy = -x - 2 * self.lam * x * y, -y - self.lam * (x * x - y * y)
        return p / self.m + self.w * y, s / self.m - self.w * x, fx + self.w * s, fy - self.w * p

    def tangent_rates(self, x, y, p, s, dx, dy, dp, ds):
        fx = -dx - 2 * self.lam * (x * dy + y * dx)
        fy = -dy - 2 * self.lam * (x * dx - y * dy)
        return dp / self.m + self.w * dy, ds / self.m - self.w * dx, fx + self.w * ds, fy - self.w * dp

    def margin(self, x, y, p, s):
        return 1.0 + 0.0 * (x + y + p + s)


V = "(x**2 + y**2)/2 + lam*(x**2*y - y**3/3)"


def close(sample, other):
    np.testing.assert_allclose(sample, other, rtol=0, atol=3e-8)


def drawn_pair(frame):
    """The same system told as H(q, p) and as T + V, perhaps in a turning frame."""
    m, lam = 10 ** RNG.uniform(-0.5, 0.5), RNG.uniform(0.5, 1.0)
    w = RNG.uniform(0.1, 0.3) / math.sqrt(m) if frame else 0.0
    turning = {"rotation": w} if frame else {}
    old = fa.hamiltonian(V, masses=[m, m], lam=lam, **turning)
    return WithMomenta(m, w, lam), old, RNG.uniform(0.05, 0.1) / lam**2


@pytest.mark.parametrize("frame", [False, True], ids=["rest", "turning"])
def test_a_separable_h_told_with_momenta_has_todays_launch_sets(frame):
    new, old, energy = drawn_pair(frame)
    assert system_of(new).of_degree_two
    assert system_of(new).ellipsoidal
    cells = (np.linspace(-0.3, 0.3, 7), np.linspace(-0.4, 0.4, 8))
    for direction in (1, -1, 0):
        section = fa.Hyperplane((0, 2.0, 0, 0), 0.1, direction)
        one, other = (fa.energy_grid(model, energy=energy, section=section, axes=cells) for model in (new, old))
        np.testing.assert_array_equal(one.inaccessible, other.inaccessible)
        np.testing.assert_allclose(one.z0, other.z0, rtol=0, atol=1e-14)
    axes = {"x": cells[0], "y": [0.1], "p_x": cells[1]}
    for sign in (1, -1):
        one, other = (fa.energy_grid(m, energy=energy, axes=axes, solve="p_y", sign=sign) for m in (new, old))
        np.testing.assert_allclose(one.z0, other.z0, rtol=0, atol=1e-14)
    one, other = (fa.energy_grid(m, energy=energy, axes={"p_x": [0.1], "p_y": [0.0]}, solve="x") for m in (new, old))
    np.testing.assert_allclose(one.z0, other.z0, rtol=0, atol=1e-14)
    one, other = (fa.energy_grid(m, energy=energy, axes={"phi": np.arange(6.0)}, at_rest=True) for m in (new, old))
    np.testing.assert_allclose(one.z0, other.z0, rtol=0, atol=1e-13)
    for how in ({}, {"section": "y=0.1"}, {"section": "x=0", "axes": {"y": (-0.3, 0.2)}}):
        one, other = (fa.energy_sample(model, energy=energy, orbits=300, seed=5, **how) for model in (new, old))
        close(one.z0, other.z0)
    one, other = (fa.plot.edge(model, "y=0.1", energy=energy) for model in (new, old))
    for edge in (one, other):
        top, bottom = edge.centre + edge.momentum, edge.centre - edge.momentum
        for p in (top, bottom):  # nothing is left for the momentum across
            best = new.m * new.w * edge.coordinate
            left = new.energy(edge.coordinate, 0.1 + 0 * p, p, best) - energy
            assert np.abs(left).max() < 1e-12
    close(np.ravel(one.axes), np.ravel(other.axes))


def test_moments_of_the_microcanonical_measure_are_quadratures():
    """A double pendulum of drawn masses: density 1/det L of the angles, cov p = (E - floor) M over each place."""
    m1, m2, a, b, g = 10 ** RNG.uniform(-0.4, 0.4, 5)
    model, least = DOUBLE(m1, m2, a, b, g), -(m1 + m2) * g * a - m2 * g * b
    for energy in (least + 0.9 * g * min(m1 * a, m2 * b), RNG.uniform(0.1, 0.5) * g * (a + b)):
        z = fa.energy_sample(model, energy=energy, orbits=8000, seed=3).z0
        np.testing.assert_allclose(model.energy(*z), energy, rtol=0, atol=1e-12 * (abs(energy) + abs(least)))
        assert np.abs(z[:2]).max() <= math.pi
        x = (np.arange(600) + 0.5) / 600 * 2 * math.pi - math.pi
        X, Y = np.meshgrid(x, x, indexing="ij")
        c = np.cos(X - Y)
        mass = np.array([[(m1 + m2) * a * a + 0 * c, m2 * a * b * c], [m2 * a * b * c, m2 * b * b + 0 * c]])
        det = mass[0, 0] * mass[1, 1] - mass[0, 1] ** 2
        room = energy + (m1 + m2) * g * a * np.cos(X) + m2 * g * b * np.cos(Y)
        weight = np.where(room > 0, np.sqrt(det), 0.0)
        weight /= weight.sum()
        tests = [
            (np.cos(z[0]), np.cos(X), 0),
            (np.cos(z[0] - z[1]), c, 0),
            (np.sin(z[0]) * np.sin(z[1]), np.sin(X) * np.sin(Y), 0),
            (z[2] ** 2, room * mass[0, 0], 1),
            (z[3] ** 2, room * mass[1, 1], 1),
            (z[2] * z[3], room * mass[0, 1], 1),
            (z[0], 0 * X, 0),
            (z[2], 0 * X, 1),
        ]
        for values, expected, _ in tests:
            mean = (weight * expected).sum()
            assert abs(values.mean() - mean) < 5 * values.std() / math.sqrt(values.size) + 2e-3 * np.abs(values).max()


def curved(**more):
    """An H that is no quadratic of its momenta, with two branches of momenta."""
    text = "sqrt(1 + px**2 + py**2) + (x**2 + 2*y**2)/2 + k*x*y*px + c*px**4 - d*px**2*cos(y)"
    values = {"k": RNG.uniform(-0.5, 0.5), "c": RNG.uniform(0.3, 0.6), "d": RNG.uniform(1.2, 1.6), **more}
    return fa.hamiltonian(text, coordinates="x y", momenta="px py", **values)


def test_every_root_of_a_quartic_momentum_is_found():
    model = curved()
    assert not system_of(model).of_degree_two
    cells = np.linspace(-0.6, 0.6, 9), np.linspace(-0.5, 0.5, 8)
    energy = 1.1
    for direction in (1, -1):
        u, v = (axis.ravel() for axis in np.meshgrid(*cells))
        section = fa.Hyperplane((1.0, 0, 0, 0), 0.2, direction)
        z, found, names = lift_sheets(EnergyShell(system_of(model), energy, section), u, v)
        assert names == ("y", "py")
        grid = np.linspace(-4, 4, 160001)
        for j in range(u.size):
            H = model.energy(0.2, u[j], grid, v[j]) - energy
            rising = np.flatnonzero((H[:-1] * direction < 0) & (H[1:] * direction >= 0))
            truth = np.sort(grid[rising])
            mine = np.sort(z[found[:, j], 2, j])
            assert mine.size == truth.size
            np.testing.assert_allclose(mine, truth, rtol=0, atol=1e-4)
        z = np.moveaxis(z, 1, 0)[:, found]
        np.testing.assert_allclose(model.energy(*z), energy, rtol=0, atol=4e-15)
        assert (model.rates(*z)[0] * direction > 0).all()
    one = fa.energy_grid(model, energy=energy, section="x=0.2", axes=cells)
    assert (model.rates(*one.z0)[0] > 0).all()


def shell(model, energy, z, width=0.02):
    """Random points of a thin shell around an energy, in the box of the points z: a measure by counting."""
    low, high = z.min(axis=1, keepdims=True), z.max(axis=1, keepdims=True)
    wide = 0.05 * (high - low)
    x = RNG.uniform(low - wide, high + wide, (len(z), 400000))
    return x[:, np.abs(model.energy(*x) - energy) < width]


def test_points_of_a_surface_of_any_kind_are_those_of_a_thin_shell():
    model = curved()
    for energy in (1.6,):
        z = fa.energy_sample(model, energy=energy, orbits=700, seed=2).z0
        np.testing.assert_allclose(model.energy(*z), energy, rtol=0, atol=1e-13)
        thin = shell(model, energy, z)
        assert thin.shape[1] > 3000
        for of in (
            lambda z: z[0],
            lambda z: z[1],
            lambda z: z[2],
            lambda z: z[3],
            lambda z: z[0] * z[2],
            lambda z: z[2] ** 2,
        ):
            assert ks_2samp(of(z), of(thin)).pvalue > 1e-5


def test_both_ways_to_draw_a_surface_agree():
    """Ellipsoids of momenta, and lines across the surface: three degrees of freedom, whole and on a section."""
    text = "(px**2*(1 + y**2) + py**2 + pz**2*(2 + cos(x)))/2 + a*x*py + (x**2 + y**2 + z**2)/2 + b*x*y*z"
    model = fa.hamiltonian(text, coordinates="x y z", momenta="px py pz", a=0.3, b=0.2)
    assert system_of(model).ellipsoidal
    for section in (None, fa.Hyperplane((0, 1.0, 0, 0, 0, 0), 0.1, -1)):
        shell = EnergyShell(system_of(model), 0.5, section)
        one = measure_of(shell, None).draw(500, 1)[0]
        other = LineMeasure.of(shell, {}).draw(300, 2)[0]
        for z in (one, other):
            np.testing.assert_allclose(model.energy(*z), 0.5, rtol=0, atol=1e-13)
            assert section is None or (model.rates(*z)[1] < 0).all()
        for of in (*(lambda z, k=k: z[k] for k in (0, 2, 3, 4, 5)), lambda z: z[0] * z[4], lambda z: z[3] ** 2 * z[2]):
            assert ks_2samp(of(one), of(other)).pvalue > 1e-5
    z = fa.energy_sample(model, energy=0.5, section="y=0.1", orbits=50).z0
    assert (model.rates(*z)[1] > 0).all()


def test_the_measure_does_not_know_coordinates():
    """x = sinh(X) and a gauge: the points of the image are the image of the points."""
    text = "((px/cosh(x))**2 + (py - g*x**2)**2)/2 + (sinh(x)**2 + y**2)/2 + lam*(sinh(x)**2*y - y**3/3)"
    new = fa.hamiltonian(text, coordinates="x y", momenta="px py", g=RNG.uniform(0.2, 0.8), lam=1.0)
    z = fa.energy_sample(new, energy=0.12, orbits=5000, seed=4).z0
    back = np.array([np.sinh(z[0]), z[1], z[2] / np.cosh(z[0]), z[3] - new.g * z[0] ** 2])
    old = fa.energy_sample(fa.hamiltonian(V, lam=1.0), energy=0.12, orbits=5000, seed=5).z0
    for of in (*(lambda z, k=k: z[k] for k in range(4)), lambda z: z[0] * z[3] - z[1] * z[2], lambda z: z[0] * z[2]):
        assert ks_2samp(of(back), of(old)).pvalue > 1e-5


@pytest.mark.parametrize("kind", ["ellipses", "any"])
def test_a_return_keeps_the_measure_of_a_section(kind):
    """Points of a section, and where they return to: the same distribution; the edge has room for both."""
    model, section, energy = {
        "ellipses": (DOUBLE(), "q1=0", -1.0),
        "any": (curved(c=0.5, d=0.4, k=0.3), "x=0", 1.5),
    }[kind]
    starts = fa.energy_sample(
        model, energy=energy, section=section, orbits={"ellipses": 1500, "any": 300}[kind], seed=1
    )
    names = ("q2", "p2") if kind == "ellipses" else ("y", "py")
    assert starts.names == names
    cut = fa.poincare_map(model, starts.z0, section=section, crossings=2, max_time=100.0, step=0.1)
    there = cut.points[[1, 3], 1]
    assert np.isfinite(there).all()
    for of in (lambda z: z[0], lambda z: z[1], lambda z: z[0] * z[1], lambda z: z[0] ** 2 + z[1]):
        assert ks_2samp(of(starts.points), of(there)).pvalue > 1e-5
    edge = fa.plot.edge(model, section, energy=energy)
    high = np.interp(there[0], edge.coordinate, edge.centre + edge.momentum)
    low = np.interp(there[0], edge.coordinate, edge.centre - edge.momentum)
    assert ((there[1] <= high + 2e-3) & (there[1] >= low - 2e-3)).all()
    cells = np.quantile(starts.points[0], [0.25, 0.5, 0.75])
    area = np.concatenate([[0.0], np.cumsum(np.diff(edge.coordinate) * (edge.momentum[1:] + edge.momentum[:-1]))])
    shares = np.interp(cells, edge.coordinate, area / area[-1])
    assert kind == "any" or np.abs(shares - [0.25, 0.5, 0.75]).max() < 5 * 0.5 / math.sqrt(1500)


def test_masses_without_bound_and_of_both_signs():
    """An oscillator in polar coordinates, whose inertia is singular at 0; an H whose momenta have no ellipsoid."""
    model = fa.hamiltonian(
        "(pr**2 + pf**2/r**2)/2 + r**2/2", coordinates="r f", momenta="pr pf", periodic={"f": "2*pi"}, domain="r"
    )
    z = fa.energy_sample(model, energy=0.5, orbits=8000).z0
    assert z[0].min() > 0
    # delta(H - E) over pr and pf gives 2 pi r: a disc of radius 1
    assert ks_2samp(z[0] ** 2, np.linspace(0, 1, 8000)).pvalue > 1e-5
    assert ks_2samp(z[1], np.linspace(-math.pi, math.pi, 8000)).pvalue > 1e-5
    saddle = fa.hamiltonian("(px**2*(1 + y**2) - py**2)/2 + x**2 - y**2", coordinates="x y", momenta="px py")
    assert system_of(saddle).of_degree_two
    assert not system_of(saddle).ellipsoidal
    with pytest.raises(ValueError, match="does not bound the motion: give ranges of the rows"):
        fa.energy_sample(saddle, energy=0.5, orbits=10)
    ranges = {"x": (-1, 1), "y": (-1, 1), "px": (-1, 1), "py": (-1, 1)}
    z = fa.energy_sample(saddle, energy=0.5, orbits=800, axes=ranges).z0
    thin = shell(saddle, 0.5, z, 0.01)
    thin = thin[:, (np.abs(thin) < 1).all(axis=0)]
    for k in range(4):
        assert ks_2samp(z[k], thin[k]).pvalue > 1e-5
    grid = fa.energy_grid(saddle, energy=0.5, section="y=0", axes=(np.linspace(-1, 1, 5), np.linspace(-1.5, 1.5, 6)))
    np.testing.assert_allclose(saddle.energy(*grid.z0), 0.5, atol=1e-15)
    assert (saddle.rates(*grid.z0)[1] > 0).all()
    assert (grid.z0[3] < 0).all()  # its mass is negative
    rows = {"y": (-1, 1), "py": (-1, 1)}
    with pytest.raises(ValueError, match="or solve='px' with ranges of the others"):
        fa.energy_sample(saddle, energy=0.5, orbits=10, section="x=0", axes=rows)
    z = fa.energy_sample(saddle, energy=0.5, orbits=10, section="x=0", axes=rows, solve="px").z0
    np.testing.assert_allclose(saddle.energy(*z), 0.5, rtol=1e-12)


@pytest.mark.parametrize("kind", ["ellipses", "ellipses of a section", "any"])
def test_the_first_points_do_not_depend_on_how_many(kind):
    model, energy = (curved(c=0.5, d=0.4, k=0.3), 1.4) if kind == "any" else (DOUBLE(), 1.0)
    how = {"section": "q1=0"} if "section" in kind else {}
    one, other = (fa.energy_sample(model, energy=energy, orbits=n, seed=9, **how).z0 for n in (3, 9))
    np.testing.assert_array_equal(one, other[:, :3])


def test_what_energies_cannot_reach_is_said():
    double = DOUBLE()
    harper = fa.hamiltonian(
        "-cos(p) - cos(x) + s**2/2 + y**2/2", coordinates="x y", momenta="p s", periodic={"x": "2*pi"}
    )
    quartic = fa.hamiltonian("(p**4 + s**2)*(1 + x**2) + y**2", coordinates="x y", momenta="p s")
    axes = (np.linspace(-1, 1, 3), np.linspace(-1, 1, 4))
    for call, match in (
        (
            lambda: fa.energy_grid(double, energy=-4.0, section="q1=0", axes=axes),
            "axes must reach points of energy -4 on q1=0",
        ),
        (lambda: fa.energy_sample(double, energy=-4.0, section="q1=0", orbits=5), "the least energy there is -3"),
        (lambda: fa.plot.edge(double, "q1=0", energy=-4.0), "the least energy there is -3"),
        (lambda: fa.energy_sample(double, energy=-4.0, orbits=5), "at least the minimum -3 "),
        (lambda: fa.energy_sample(double, energy=1.0, orbits=5, axes={"q9": (0, 1)}), "q9"),
        (lambda: fa.energy_sample(harper, energy=-1.0, section="x=0", orbits=5), "without end"),
        (lambda: fa.energy_grid(harper, energy=-1.0, section="x=0", axes=axes), "met without end along p"),
        (
            lambda: fa.energy_grid(quartic, energy=1.0, axes={"phi": [1.0]}, at_rest=True),
            "second degree in the momenta",
        ),
    ):
        with pytest.raises(ValueError, match=match):
            call()
    with pytest.raises(TypeError, match="section must be a Hyperplane normal to one coordinate"):
        fa.energy_grid(double, energy=1.0, section=fa.Hyperplane((0.0, 0.0, 1.0, 0.0)), axes=axes)
    driven = fa.hamiltonian(
        "p**2*(1 + x**2)/2 + x**2/2 + x*p*cos(t)", coordinates="x", momenta="p", drive_period="2*pi"
    )
    with pytest.raises((TypeError, ValueError), match="must be a system without a drive, got a driven"):
        fa.energy_sample(driven, energy=1.0, orbits=5)


def test_the_well_of_a_charge_far_from_the_origin_ends_in_any_units():
    """Far out H(q, 0) is nothing but the vector potential's square, beside which V is lost."""
    mass, size, rate, far = (10.0 ** RNG.uniform(-e, e) for e in (20, 6, 6, 2))
    a = size * far
    text = "((px + B*x*y)**2 + py**2)/(2*m) + m*w**2/2*((x - a)**2 + 1.7*y**2)"
    field = RNG.uniform(0.3, 1.0) * mass * rate / size
    model = fa.hamiltonian(text, coordinates="x y", momenta="px py", B=field, m=mass, w=rate, a=a)
    energy = 0.5 * mass * (rate * size) ** 2
    found = fa.energy_sample(model, energy=energy, orbits=40, seed=1).z0
    np.testing.assert_allclose(model.energy(*found), energy, rtol=1e-9)
    assert (((found[0] - a) ** 2 + 1.7 * found[1] ** 2) / size**2 <= 1 + 1e-9).all()
