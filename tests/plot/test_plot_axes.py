"""Default axes of figures show what varies: no coordinate that a section fixes, no variable against itself."""

from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import fastaff as fa
from fastaff import plot
from fastaff.plot.style import contrast

matplotlib.use("Agg")

ROESSLER = fa.ode("x'=-y-z; y'=x+a*y; z'=b+z*(x-c)", a=0.2, b=0.2, c=5.7)
PENDULUM = fa.ode("x'=v; v'=-sin(x)-g*v+f*cos(phi); phi'=w", periodic={"x": "2*pi", "phi": "2*pi"}, g=0.1, f=0.2, w=0.8)


def _axes():
    return Figure().subplots()


def _labels(drawn_on):
    return drawn_on.get_xlabel(), drawn_on.get_ylabel()


@pytest.mark.parametrize(
    ("model", "z0", "section", "labels"),
    [
        (ROESSLER, [1.0, 1.0, 0.0], "y=0+", ("$x$", "$z$")),
        (ROESSLER, [1.0, 1.0, 0.0], "x=0+", ("$y$", "$z$")),
        (PENDULUM, [0.1, 0.2, 0.0], "phi=pi/3", ("$x$", "$v$")),
    ],
)
def test_sections_of_odes_show_free_coordinates(model, z0, section, labels):
    cut = fa.poincare_map(model, z0, section=section, crossings=8, max_time=100.0)
    ax = _axes()
    drawn = plot.plot_section(cut, ax=ax)
    assert _labels(ax) == labels
    dots = drawn.points.get_offsets()
    for column, name in zip(dots.T, labels, strict=True):
        np.testing.assert_array_equal(np.sort(column), np.sort(cut[name.strip("$")][:, 0]))
    assert (np.ptp(dots, axis=0) > 1e-3).all()


@pytest.mark.parametrize(
    ("coordinates", "section", "labels"),
    [("x y z", "y=0+", ("$x$", "$z$")), ("x y px py", "x=0", ("$y$", "$py$")), ("x y u v", "u=0", ("$x$", "$y$"))],
)
def test_sections_of_samples_know_momenta_by_their_names(coordinates, section, labels):
    t = 0.05 * np.arange(400)
    rows = len(coordinates.split())
    samples = np.array([(1 + 0.1 * k) * np.sin((1 + 0.13 * k) * t + k) for k in range(rows)])
    cut = fa.sections.map_samples(samples, 0.05, section=section, coordinates=coordinates)
    ax = _axes()
    plot.plot_section(cut, ax=ax)
    assert _labels(ax) == tuple(f"${plot.symbol(name.strip('$'))}$" for name in labels)


def test_sections_of_hamiltonian_systems_show_a_pair():
    cut = fa.poincare_map(fa.HenonHeiles(), [0.0, 0.1, 0.3, 0.1], section="x=0", crossings=3, max_time=100.0)
    ax = _axes()
    plot.plot_section(cut, ax=ax)
    assert _labels(ax) == ("$y$", "$p_{y}$")


LOGISTIC = fa.iterated_map("x1 = r*x*(1 - x)", r=3.9)


def test_orbits_of_a_map_of_one_variable_are_drawn_against_the_iterate():
    orbits = fa.integrate(LOGISTIC, [0.3], time=20, samples=20)
    ax = _axes()
    (curve,) = plot.plot_orbits(orbits, ax=ax).points
    assert _labels(ax) == ("iterate $n$", "$x$")
    x = [0.3]
    for _ in range(20):
        x.append(3.9 * x[-1] * (1 - x[-1]))
    np.testing.assert_allclose(curve.get_xydata(), np.column_stack([range(1, 21), x[1:]]), atol=1e-9)


def test_sections_of_a_map_of_one_variable_are_its_returns():
    cut = fa.poincare_map(LOGISTIC, [[0.3, 0.6]], crossings=30)
    ax = _axes()
    drawn = plot.plot_section(cut, ax=ax)
    assert _labels(ax) == ("${x}_{n}$", "${x}_{n+1}$")
    x, image = drawn.points.get_offsets().T
    assert x.size == 2 * 29
    np.testing.assert_allclose(image, 3.9 * x * (1 - x), atol=1e-12)
    ax.figure.draw_without_rendering()


def test_cycles_of_a_map_of_one_variable_have_their_multipliers():
    """The multiplier of a cycle is the product of f'(x) = 3.9 (1 - 2 x) over its points."""
    cycles = fa.find_periodic_orbits(LOGISTIC, np.linspace(0.05, 0.95, 20)[None], max_crossings=2)
    ax = _axes()
    drawn = plot.plot_periodic(cycles, ax=ax)
    assert _labels(ax) == ("${x}_{n}$", "${x}_{n+1}$")
    marks = np.concatenate([mark.get_xydata() for mark in drawn.points])
    marks = marks[np.isfinite(marks).all(axis=1)]
    assert len(marks) == cycles.crossings.sum()
    np.testing.assert_allclose(marks[:, 1], 3.9 * marks[:, 0] * (1 - marks[:, 0]), atol=1e-9)
    own = [np.prod(3.9 * (1 - 2 * cycles.points[0, :count, k])) for k, count in enumerate(cycles.crossings)]
    written = [text.get_text() for text in drawn.labels]
    said = [float(text.partition("=")[2].rstrip("$")) for text in written]
    assert said == pytest.approx(own, rel=5e-3)
    assert len(drawn.lines) == 1 + cycles.crossings.size
    ax.figure.draw_without_rendering()


def test_cycles_of_a_dissipative_map_have_their_multipliers():
    henon = fa.iterated_map("x1 = 1 - a*x**2 + y; y1 = b*x", a=1.4, b=0.3)
    cycles = fa.find_periodic_orbits(henon, [[0.6, -1.1], [0.2, -0.3]], max_crossings=1)
    own = np.abs(cycles.multipliers).max(axis=0)
    said = [
        float(text.get_text().partition("=")[2].rstrip("$")) for text in plot.plot_periodic(cycles, ax=_axes()).labels
    ]
    assert np.abs(said) == pytest.approx(own, rel=5e-3)
    assert len(said) == cycles.crossings.size > 0


def test_branches_of_a_map_of_one_variable_show_the_variable():
    """The fixed point is 1 - 1/r, which doubles its period at r = 3."""
    branch = fa.continuation(lambda r: LOGISTIC._replace(r=r), [0.6], parameter=2.5, bounds=(2.5, 3.4), ds_max=1.0)
    ax = _axes()
    drawn = plot.plot_backbone(branch, ax=ax)
    assert ax.get_ylabel() == "$x$"
    for curve in drawn.points:
        r, x = curve.get_xydata()[np.isfinite(curve.get_ydata())].T
        assert r.size > 2
        np.testing.assert_allclose(x, 1 - 1 / r, atol=2e-3)
    (mark,) = drawn.lines
    assert mark.get_xydata()[0] == pytest.approx([3.0, 2 / 3], abs=1e-6)
    ax = _axes()
    plot.plot_backbone(branch, ax=ax, y="frequency")
    assert ax.get_ylabel().startswith("frequency")


def _families(resonances, family, sense):
    """Families of orbits in space, made by hand."""
    orbits = len(resonances)
    values = np.linspace(0.1, 1.0, orbits)
    return fa.frequencies.OrbitFamilies(
        names=("x", "y", "z"),
        family=np.array(family),
        sense=np.array(sense),
        resonance=np.array(resonances).T,
        nu=np.array([values, 1.1 * values + 0.1, 1.3 * values + 0.2]),
        turns=np.ones(orbits),
        energy=np.full(orbits, -0.3),
        angular_momentum=values,
        radius=values,
        status=np.zeros(orbits, np.int64),
    )


def test_tubes_about_different_axes_look_different():
    family = fa.frequencies.OrbitFamily
    loops = [(1, -1, 0), (1, -1, 0), (0, 1, -1), (0, 1, -1), (1, 0, -1), (1, 0, -1)]
    found = _families([*loops, (2, 0, -1)], [family.LOOP] * 6 + [family.RESONANT], [1, -1, 1, -1, 1, -1, 0])
    ax = _axes()
    marks = plot.plot_families(found, ax=ax).points
    looks = {(mark.get_paths()[0].vertices.tobytes(), mark.get_facecolor().tobytes()) for mark in marks}
    assert len(looks) == len(marks) == 7
    told = [text.get_text() for text in ax.get_legend().get_texts()]
    assert {"1 z tube +", "1 z tube -", "1 x tube +", "1 x tube -", "1 y tube +", "1 y tube -"} < set(told)
    assert told[-1] == r"1 at $2\nu_{x}-\nu_{z}=0$"
    assert ax.get_xlabel() == "angular momentum $L_z$ of the initial condition"


def test_attractors_of_a_driven_ode_are_drawn_at_the_phase_of_the_grid():
    """x' = -x + cos(phi) comes to (cos(phi) + w sin(phi))/(1 + w^2), and y' = -2 y + sin(phi) likewise."""
    w, phase = 0.8, 0.7
    model = fa.ode("x'=-x+cos(phi); y'=-2*y+sin(phi); phi'=w", periodic={"phi": "2*pi"}, w=w)
    axes = {"x": np.linspace(-1.0, 1.0, 5), "y": np.linspace(-1.0, 1.0, 5)}
    found = fa.basins(model, fa.energy_grid(model, axes=axes, fixed={"phi": phase}), time=40 * np.pi / w)
    ax = _axes()
    (mark,) = plot.plot_basins(found, ax=ax).lines
    x = (np.cos(phase) + w * np.sin(phase)) / (1 + w**2)
    y = (2 * np.sin(phase) - w * np.cos(phase)) / (4 + w**2)
    np.testing.assert_allclose(mark.get_xydata(), [[x, y]], atol=1e-5)
    assert ax.get_legend().get_texts()[-1].get_text() == r"attractors at $\varphi=0.7$"


def test_samples_far_apart_at_unequal_times_are_dots():
    """Samples of a Kepler ellipse, semi-axes 1 and 0.8, at random times, and close to each other."""
    kepler = fa.hamiltonian("-1/sqrt(x**2+y**2)")
    z0 = [0.4, 0.0, 0.0, 2.0]
    for samples, style in (
        (np.sort(np.random.default_rng(3).uniform(0, 50, 200)), "None"),
        (np.arange(1, 400) ** 1.01 / 20, "-"),
    ):
        orbits = fa.integrate(kepler, z0, time=50.0, samples=samples)
        ax = _axes()
        (curve,) = plot.plot_orbits(orbits, ax=ax).points
        assert curve.get_linestyle() == style
        assert ax.get_aspect() == 1.0
        x, y = curve.get_xydata().T
        np.testing.assert_allclose(((x + 0.6) / 1.0) ** 2 + (y / 0.8) ** 2, 1.0, atol=2e-3)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_aperture_of_a_grid_without_corners_is_that_of_the_whole(seed):
    """Cells beyond a circle have no orbit: these are lost."""
    rng = np.random.default_rng(seed)
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-1.5, 1.5, 41), np.linspace(0.0, 1.5, 21)))
    lost = np.hypot(x - rng.uniform(-0.1, 0.1), y) > rng.uniform(0.6, 0.8)
    inside = x**2 + y**2 < 1.5**2 + 1e-9
    drawn = []
    for kept in (np.ones_like(inside), inside):
        result = SimpleNamespace(t=np.where(lost, 5.0, 99.0)[kept], status=1 * lost[kept], scheme=None)
        drawn.append(plot.plot_aperture(result, np.array([x, y])[:, kept], ax=_axes()))
    whole, part = drawn
    assert inside.sum() < 0.9 * inside.size
    assert part.labels[0].get_text() == whole.labels[0].get_text()
    for one, other in zip(whole.lines, part.lines, strict=True):
        np.testing.assert_array_equal(one.get_xydata(), other.get_xydata())


def test_the_note_of_an_aperture_is_outside_of_the_frame():
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-4, 4, 21), np.linspace(-4, 4, 21)))
    lost = np.hypot(x, y) > 1
    result = SimpleNamespace(t=np.where(lost, 10.0, 1000.0), status=1 * lost, scheme=None)
    ax = _axes()
    plot.plot_aperture(result, np.array([x, y]), ax=ax)
    (note,) = ax.texts
    ax.figure.draw_without_rendering()
    assert note.get_window_extent().y0 > ax.bbox.y1
    assert note.get_window_extent().y1 < ax._left_title.get_window_extent().y0


def test_axes_of_tunes_are_in_cycles_per_turn():
    ring = fa.iterated_map(
        "x1 = c*x + s*p; p1 = -s*x + c*p; y1 = C*y + S*q; q1 = -S*y + C*q",
        coordinates="x y",
        momenta="p q",
        c=np.cos(1.7),
        s=np.sin(1.7),
        C=np.cos(2.3),
        S=np.sin(2.3),
    )
    found = fa.frequency_map(ring, [[0.1], [0.2], [0.0], [0.1]], time=400)
    ax = _axes()
    plot.plot_frequency_map(found, ax=ax)
    assert _labels(ax) == ("$Q_{x}$  (cycles per turn)", "$Q_{y}$  (cycles per turn)")


@pytest.mark.parametrize("ground", ["white", "black"])
def test_named_closed_orbits_have_colours_of_their_own(ground):
    """Eight times one orbit: its curves differ by colour alone."""
    z0 = np.tile([[0.0], [0.3], [0.4], [0.0]], 8)
    orbits = fa.periodic_orbits(fa.HenonHeiles(), z0, section="x=0", energy=0.1, max_time=20.0)
    ax = _axes()
    ax.set_facecolor(ground)
    curves = plot.plot_closed_orbits(orbits, ax=ax).points
    colours = {matplotlib.colors.to_rgb(curve.get_color()) for curve in curves}
    assert len(colours) == len(curves) == 8
    assert min(contrast(colour, ground) for colour in colours) > 2.5
