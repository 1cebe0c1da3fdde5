"""What a refusal names: the call that does what was meant."""

import numpy as np
import pytest
from scipy.special import ellipk

import fastaff as fa

SPRING = "p_r**2/(2*m) + p_a**2/(2*m*r**2) + k/2*(r - 1)**2 - m*r*cos(a)"
RING = "k = p + s*x**2; x1 = cos(2*pi*q)*x + sin(2*pi*q)*k; p1 = -sin(2*pi*q)*x + cos(2*pi*q)*k"
PLANE = fa.hamiltonian("(x**2 + y**2)/2 + x**2*y")
SPACE = fa.hamiltonian("(x**2 + y**2 + z**2)/2 + x**2*y", coordinates="x y z")


def test_names_of_terms_may_be_parameters():
    assert fa.affine_body("friction*(D1**2 + D2**2)", friction=2.0).potential.friction == 2.0


def test_one_orbit_of_a_sample_is_fitted():
    starts = fa.energy_sample(PLANE, energy=0.02, section="y=0", orbits=3, seed=1)
    fit = fa.fit_torus(PLANE, starts[:1], time=100.0)
    np.testing.assert_array_equal(fit.nu, fa.fit_torus(PLANE, starts.z0[:, 0], time=100.0).nu)


def test_the_explorer_takes_the_first_section_that_the_energy_reaches(tmp_path):
    """r = 0 is no place of a pendulum on a spring; a = 0 is."""
    spring = fa.hamiltonian(SPRING, coordinates="r a", momenta="p_r p_a", periodic={"a": "2*pi"}, m=1.0, k=4.0)
    start = fa.explorer.explore.setup_of(spring, energy=-0.5)[0]["start"]
    assert (start["section"], start["constant"]) == ("a=c", 0.0)
    assert fa.explorer.explore.setup_of(PLANE, energy=0.1)[0]["start"]["section"] == "x=c"
    with pytest.raises(ValueError, match="section r=0 has no points of finite energy"):
        fa.explore(spring, energy=-5.0, out=tmp_path / "x.html")


def test_rotation_numbers_on_a_section_of_an_angle():
    """Of an oscillator beside a pendulum: w T/(2 pi) of its turns, T = 4 K(k) of the pendulum's period."""
    rng = np.random.default_rng(8)
    w, highest = rng.uniform(0.3, 0.45), rng.uniform(0.3, 1.5)
    body = fa.hamiltonian("-cos(x) + w**2*y**2/2", coordinates="x y", periodic={"x": "2*pi"}, w=w)
    start = [0.0, 0.3, 2 * np.sin(highest / 2), 0.1]
    cut = fa.poincare_map(body, start, section="x=0", crossings=200, max_time=2000.0)
    assert type(cut.section).__name__ == "AngleEquals"
    turning = fa.rotation_number(cut)
    share = w * 4 * ellipk(np.sin(highest / 2) ** 2) / (2 * np.pi)
    assert abs(np.abs(turning.rotation[0]) - np.abs(share - np.rint(share))) <= turning.error[0] + 1e-9
    assert fa.islands(cut).summary() == "1 orbit: 1 regular"


def test_a_map_without_a_domain_is_never_left():
    """Numbers whose sum is beyond the largest one are finite still: the next iterate is not."""
    grows = fa.iterated_map("x1 = 2*x; p1 = p/2; y1 = 2*y; q1 = q/2", coordinates="x y", momenta="p q")
    z0 = np.array([[2.0, 3.0], [2.0, 3.0], [0.0, 0.0], [0.0, 0.0]])
    ends = fa.integrate(grows, z0 * 2.0**1015, time=20)
    assert (ends.status == fa.Status.NONFINITE).all()
    np.testing.assert_array_equal(ends.t, [8, 8])  # 2^1024 is the first power that is none
    mixed = fa.integrate(grows, [2.0**1015, 2.0**1015, 2.0**1023, 2.0**1023], time=5)
    assert mixed.status[0] == fa.Status.OK
    within = fa.iterated_map("x1 = 2*x; p1 = p/2", domain="1 - x**2")
    assert fa.integrate(within, [0.3, 0.0], time=20).status[0] == fa.Status.LOST


def test_a_map_is_drawn_over_the_grid_of_its_orbits(ax):
    ring = fa.iterated_map(RING, s=1.0, q=0.2103)
    grid = fa.energy_grid(ring, axes={"x": np.linspace(0.05, 0.3, 4), "p": np.linspace(0.05, 0.3, 3)})
    found = fa.frequency_map(ring, grid, time=300)
    drawn, same = found.plot(grid, ax=ax), fa.plot.plot_diffusion_grid(grid, found, ax=ax)
    np.testing.assert_array_equal(drawn.points.get_array(), same.points.get_array())
    with pytest.raises(TypeError, match=r"grid must be an EnergyGrid, .* got FrequencyMap"):
        fa.plot.plot_diffusion_grid(found, grid, ax=ax)
    with pytest.raises(TypeError, match=r"colouring\(result, 'nu_x'\)"):
        fa.plot.plot_diffusion_grid(grid, "nu_x", ax=ax)


def test_one_axis_of_a_frequency_figure_is_enough(ax):
    starts = [[0.1, 0.12], [0.05, 0.1], [0.0, 0.1], [0.1, 0.1]]
    found = fa.frequency_map(PLANE, starts, time=200.0)
    for given, labels in (
        ({"x": "y"}, (r"$\nu_{y}$", r"$\nu_{x}$")),
        ({"y": "x"}, (r"$\nu_{y}$", r"$\nu_{x}$")),
        ({"y": "y/x"}, (r"$\nu_{x}$", r"$\nu_{y}/\nu_{x}$")),
    ):
        found.plot(ax=ax, **given)
        assert tuple(label.partition("  (")[0] for label in (ax.get_xlabel(), ax.get_ylabel())) == labels
