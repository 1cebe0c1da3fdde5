"""Curves of orbits: smooth between samples, closed for periodic orbits, one for each of several bodies; families."""

import dataclasses

import numpy as np
import pytest
from matplotlib.figure import Figure

import fastaff as fa
from fastaff import plot
from fastaff.frequencies.resonances import equation
from fastaff.plot.curves import hermite

HH = fa.HenonHeiles()
KEPLER = fa.hamiltonian("-1/sqrt(x**2 + y**2)")
EIGHT = [0.97000436, -0.24308753, -0.97000436, 0.24308753, 0.0, 0.0]
EIGHT += [0.466203685, 0.43236573, 0.466203685, 0.43236573, -0.93240737, -0.86473146]
"""Figure eight of three bodies, Chenciner & Montgomery 2000 (digits of C. Simo)."""


@pytest.fixture
def ax():
    return Figure().subplots()


@pytest.fixture(scope="module")
def three_bodies():
    pairs = [(1, 2), (1, 3), (2, 3)]
    text = " ".join(f"- 1/sqrt((x{i} - x{j})**2 + (y{i} - y{j})**2)" for i, j in pairs)
    return fa.hamiltonian(text, coordinates="x1 y1 x2 y2 x3 y3")


def test_cubics_are_drawn_exactly():
    rng = np.random.default_rng(1)
    times = np.sort(rng.uniform(0.0, 1.0, 9))
    c = rng.normal(size=(4, 3, 1, 5))
    t = times[:, None]
    states = c[0] + c[1] * t + 0.1 * c[2] * t**2 + 0.1 * c[3] * t**3
    rates = c[1] + 0.2 * c[2] * t + 0.3 * c[3] * t**2
    fine, moments = hermite(states, rates, times, 5)
    t = moments[:, None]
    expected = c[0] + c[1] * t + 0.1 * c[2] * t**2 + 0.1 * c[3] * t**3
    np.testing.assert_allclose(fine, expected, atol=1e-13)
    np.testing.assert_array_equal(moments[::5], times)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_ellipse_of_few_samples_is_drawn_as_an_ellipse(ax, seed):
    """Kepler: r = p/(1 + e cos(angle)); 30 samples a turn, whose chords miss it by up to a hundredth."""
    rng = np.random.default_rng(seed)
    e = rng.uniform(0.1, 0.5)
    turned = rng.uniform(0, 2 * np.pi)
    c, s = np.cos(turned), np.sin(turned)
    z0 = [c * (1 - e), s * (1 - e), *(np.sqrt((1 + e) / (1 - e)) * np.array([-s, c]))]
    run = fa.integrate(KEPLER, z0, time=10 * 2 * np.pi + 1.0, samples=310)
    curve = plot.plot_orbits(run, ax=ax).points[0].get_xydata()
    assert len(curve) == 8 * 309 + 1

    def off(points):
        x, y = points.T
        return np.abs(np.hypot(x, y) * (1 + e * np.cos(np.arctan2(y, x) - turned)) / (1 - e**2) - 1).max()

    places = run.samples.reshape(310, 4)[:, :2]
    middles = 0.5 * (places[1:] + places[:-1])
    assert off(curve) < 1e-3 < 5e-3 < off(middles)
    assert ax.get_aspect() == 1.0


def test_samples_that_are_too_few_are_joined_by_chords(ax):
    """0.7 of a turn between samples does not tell the way."""
    run = fa.integrate(KEPLER, [1.0, 0.0, 0.0, 1.0], time=0.7 * 2 * np.pi * 12, samples=12)
    x, y = plot.plot_orbits(run, ax=ax).points[0].get_data()
    for k in range(11):
        piece = slice(8 * k, 8 * k + 9)
        ends = np.linspace(0, 1, 9)
        np.testing.assert_allclose(x[piece], x[8 * k] + ends * (x[8 * k + 8] - x[8 * k]), atol=1e-12)
        np.testing.assert_allclose(y[piece], y[8 * k] + ends * (y[8 * k + 8] - y[8 * k]), atol=1e-12)


def test_a_click_on_a_smooth_curve_names_the_nearest_sample(ax):
    run = fa.integrate(HH, np.array([[0.0, 0.1, 0.3, 0.1]]).T, time=10.0, samples=21)
    (curve,) = plot.plot_orbits(run, ax=ax).points
    where = curve.get_xydata()[8 * 5 + 3]
    pixel = ax.transData.transform(where)
    event = type("Click", (), {"inaxes": ax, "x": pixel[0], "y": pixel[1], "xdata": where[0], "ydata": where[1]})()
    found = curve.get_picker()(curve, event)[1]["picked"]
    assert (found.orbit, found.crossing) == (0, 5)


def test_periodic_orbits_are_closed_curves(ax):
    z = np.array([[0.0, 0.0, 0.3, 0.31], [0.0, 0.3, 0.4, 0.0]]).T
    found = fa.periodic_orbits(HH, z, section="x=0", energy=0.1, max_time=20.0)
    drawn = found.plot(ax=ax)
    assert drawn.missing == 0
    swing, loop = (curve.get_xydata() for curve in drawn.points)
    np.testing.assert_allclose(loop[0], loop[-1], atol=1e-9)
    x, y = loop.T
    V = 0.5 * (x**2 + y**2) + x**2 * y - y**3 / 3
    assert V.max() < 0.1 + 1e-6
    # The other goes to and fro between two points at rest, which are on the boundary V = E, and is drawn once.
    x, y = swing[[0, -1]].T
    np.testing.assert_allclose(0.5 * (x**2 + y**2) + x**2 * y - y**3 / 3, 0.1, rtol=1e-3)
    assert len(swing) < 0.6 * len(loop)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts[0].startswith(f"0: hyperbolic, $T = {found.period[0]:.4g}$")
    assert texts[1].startswith(f"1: elliptic, $T = {found.period[1]:.4g}$")
    assert ax.get_aspect() == 1.0
    own = plot.plot_closed_orbits(found, ax=Figure().subplots(), x="y", y="p_y", numbers=[1])
    assert own.missing == 1
    with pytest.raises(ValueError, match="x and y must be among x, y"):
        plot.plot_closed_orbits(found, ax=ax, x="alpha")


def test_points_of_maps_stay_marks(ax):
    found = fa.periodic_orbits(fa.models.StandardMap(0.9), [3.0, 0.1])
    assert found.plot(ax=ax).points[0].get_marker() == "o"
    with pytest.raises(ValueError, match="orbits must be those of a flow"):
        plot.plot_closed_orbits(found, ax=ax)


def test_axes_of_marks_are_never_below_rounding(ax):
    """The elliptic orbit crosses x = 0 at p_y = 0 but for rounding."""
    found = fa.periodic_orbits(HH, [0.0, 0.3, 0.4, 0.0], section="x=0", energy=0.1, max_time=20.0)
    plot.plot_periodic(found, ax=ax)
    low, high = ax.get_ylim()
    assert ax.get_ylabel() == "$p_{y}$"
    assert high - low > 0.01


def test_each_of_several_bodies_has_its_curve(ax, three_bodies):
    """All three follow the eight: each third of the period the next is where the last was."""
    period = 6.32591398
    run = fa.integrate(three_bodies, EIGHT, time=period, samples=60)
    curves = [curve.get_xydata() for curve in plot.plot_orbits(run, ax=ax).points]
    assert len(curves) == 3
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["body 1", "body 2", "body 3"]
    for k, curve in enumerate(curves):
        np.testing.assert_array_equal(curve[::8], run.samples.reshape(60, 12)[:, 2 * k : 2 * k + 2])
        later = np.array([other[-1] for other in curves])
        assert np.abs(curve[20 * 8 - 8] - later).max(axis=1).min() < 1e-4
    assert len(plot.plot_orbits(run, ax=ax, x="x2", y="y2").points) == 1


def test_several_bodies_are_animated(three_bodies):
    film = plot.animate(three_bodies, EIGHT, time=2.0, frames=3)
    film.draw(2)
    end = fa.integrate(three_bodies, EIGHT, time=2.0, accuracy=1e-8).z.ravel()
    (axes,) = film.figure.axes
    marks = [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(np.ravel(marks), end[:6], atol=1e-5)
    with pytest.raises(ValueError, match="or bodies x1, y1, x2, y2"):
        plot.animate(fa.hamiltonian("(x**2 + y**2 + z**2)/2", coordinates="x y z"), np.ones(6), time=1.0, frames=2)


# --- families and ratios ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def oscillators():
    """Frequencies of uncoupled oscillators: a box, an orbit along x, and one that escapes."""
    model = fa.hamiltonian("(x**2 + w**2*y**2)/2", w=np.sqrt(2))
    z0 = np.array([[0.3, 0.2, 0.0, 0.1], [0.3, 0.0, 0.1, 0.0], [0.1, 0.2, 0.1, 0.0]]).T
    found = fa.frequency_map(model, z0, time=400.0)
    status = found.status.copy()
    status[2] = fa.Status.ESCAPED
    object.__setattr__(found, "status", status)
    return found


def test_ratios_are_drawn_against_energy_with_the_orbits_that_are_not(ax, oscillators):
    drawn = plot.plot_frequency_map(oscillators, ax=ax, x="energy")
    at = drawn.points.get_offsets()
    energy = 0.5 * (0.3**2 + 2 * 0.2**2 + 0.1**2)
    np.testing.assert_allclose(at[np.isclose(at[:, 0], energy)], [[energy, np.sqrt(2)]], rtol=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("energy $E$", r"$\nu_{y}/\nu_{x}$")
    assert any("2 of 3 orbits not drawn: 1 without a value, 1 escaped" in text.get_text() for text in ax.texts)
    with pytest.raises(ValueError, match="lines must be empty"):
        plot.plot_frequency_map(oscillators, ax=ax, x="radius", lines=(1, -1, 0))


def test_families_have_marks_of_their_own_and_counts(ax, oscillators):
    families = fa.frequencies.orbit_families(oscillators)
    drawn = plot.plot_families(families, ax=ax, x="radius")
    assert drawn.missing == 2
    assert ax.get_title(loc="right") == "2 of 3 orbits not drawn: 1 axial, 1 escaped"
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["1 box"]
    np.testing.assert_allclose(drawn.points[0].get_offsets(), [[np.hypot(0.3, 0.2), np.sqrt(2)]], rtol=1e-9)
    assert families.plot(ax=Figure().subplots(), y="x/y").missing == 2
    with pytest.raises(ValueError, match="x and y must be among energy, angular_momentum, radius"):
        plot.plot_families(families, ax=ax, x="q")


@pytest.mark.parametrize("energy", [0.0, -1e-17, 3.0])
def test_families_of_one_energy_are_drawn_against_the_angular_momentum(ax, oscillators, energy):
    """Rounding of E about 0 is no axis."""
    families = fa.frequencies.orbit_families(oscillators)
    given = dataclasses.replace(families, energy=energy * (1 + 1e-15 * np.arange(3)) + 1e-17 * np.arange(3))
    object.__setattr__(given, "angular_momentum", np.array([0.1, 0.2, 0.3]))
    plot.plot_families(given, ax=ax)
    assert ax.get_xlabel().startswith("angular momentum")


# --- resonances and diffusion -----------------------------------------------------------------------------------------


def test_resonances_of_tunes_have_one_notation_and_diffusion_one_threshold():
    """In the table, on the lines and on the axes; a torus, and an orbit whose tune drifts."""
    n = np.arange(512)
    turns = np.array([[0.28 * n, 0.28 * n + 2e-5 * n**2], [0.36 * n, 0.36 * n]])
    circles = 0.3 * np.exp(-2j * np.pi * turns)
    found = fa.tunes(np.concatenate([circles.real, circles.imag]), coordinates="x y p_x p_y")
    ax = Figure(layout="constrained").subplots()
    drawn = found.plot(ax=ax, lines=[(2, -4, 1)], limits=((0.2, 0.4), (0.3, 0.5)))
    assert [text.get_text() for text in drawn.labels] == ["$2Q_{x}-4Q_{y}=-1$"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$Q_{x}$", "$Q_{y}$")
    for k in ((2, -4, 1), (-2, 4, -1)):
        assert equation(k, ("x", "y", "turn")) == "2 Q_x - 4 Q_y = -1"
    assert drawn.colorbar.ax.get_ylabel() == r"diffusion  $\log_{10}|\Delta\nu|$"
    threshold = plot.colouring(found).threshold
    assert threshold == pytest.approx(np.log10(0.6 / found.window[0]))
    assert list(found.diffusion > threshold) == [False, True]
