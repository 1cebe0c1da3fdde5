"""Lifted grids: energy, angular momenta and section exact; directions; forbidden cells; errors."""

import numpy as np
import pytest
from naive import constants, label

from fastaff import (
    AlphaEquals,
    AlphaTurning,
    Anharmonic,
    AreaEquals,
    BetaEquals,
    BetaTurning,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    Linear,
    NeoHookean,
    energy_grid,
    poincare_map,
)

ALPHAS = np.linspace(1.0, 2.0, 9), np.linspace(-0.8, 0.8, 7)
BETAS = np.linspace(0.1, 0.6, 9), np.linspace(-0.8, 0.8, 7)
SECTIONS = [
    (AlphaTurning(1), BETAS), (AlphaTurning(-1), BETAS), (AlphaTurning(0), BETAS), (BetaTurning(1), ALPHAS), (BetaTurning(-1), ALPHAS),
    (AlphaEquals(1.4, 1), BETAS), (AlphaEquals(1.4, -1), BETAS), (BetaEquals(0.3, 1), ALPHAS), (BetaEquals(0.3, 0), ALPHAS),
    (AreaEquals(1.0, 1), BETAS), (AreaEquals(1.1, -1), BETAS),
]  # fmt: skip
every_section = pytest.mark.parametrize(("section", "axes"), SECTIONS, ids=[str(s) for s, _ in SECTIONS])
BODIES = [
    (Body(Harmonic(1.3), 0.7), 3.0), (Body(Anharmonic(0.9), 1.4), 3.2), (Body(Hyperelastic(1.1), 0.8), 3.2),
    (Body(HeavyTop(1.0, 0.5), 1.1), 2.8), (Body(NeoHookean(1.0, 2.0)), 1.5),
]  # fmt: skip
every_body = pytest.mark.parametrize(("body", "energy"), BODIES, ids=lambda v: label(v) if isinstance(v, Body) else "")


def rate(body, section, z):
    """Derivative of the section function along the motion, by a complex step."""
    flow = np.array([*body.velocity(*z[4:]), *body.force(*z[:4])])
    return section.value(*(z + 1e-30j * flow)).imag / 1e-30


@every_section
@every_body
def test_every_point_has_what_was_asked_for(body, energy, section, axes):
    grid = energy_grid(body, energy=energy, section=section, axes=axes, p_eta=0.3, p_gamma=-0.1)
    E, p_eta, p_gamma = constants(body, grid.z0)
    assert grid.z0.shape == (8, grid.cell.size)
    assert grid.cell.size >= 5
    np.testing.assert_allclose(E, energy, rtol=0, atol=2e-13 * (1 + energy))
    np.testing.assert_allclose(p_eta, 0.3, rtol=0, atol=1e-15)
    np.testing.assert_allclose(p_gamma, -0.1, rtol=0, atol=1e-15)
    np.testing.assert_allclose(section(grid.z0), 0.0, rtol=0, atol=1e-15)
    assert (body.margin(*grid.z0[:4]) > 0).all()


@every_section
@every_body
def test_the_motion_crosses_in_the_direction_of_the_section(body, energy, section, axes):
    """Turning points: a minimum of the radius for +1, a maximum for -1."""
    grid = energy_grid(body, energy=energy, section=section, axes=axes, p_eta=0.3, p_gamma=-0.1)
    rates = rate(body, section, grid.z0)
    if section.direction:
        assert (rates * section.direction > -1e-12).all()
    assert np.abs(rates).max() > 0.1


@every_section
def test_points_sit_on_their_cells(section, axes):
    body, energy = BODIES[2]
    grid = energy_grid(body, energy=energy, section=section, axes=axes, p_eta=0.3, p_gamma=-0.1)
    u, v = np.meshgrid(*axes, indexing="ij")
    plane = 0 if grid.names[0] == "alpha" else 2
    radius = np.hypot(grid.z0[plane], grid.z0[plane + 1])
    momentum = (grid.z0[plane] * grid.z0[4 + plane] + grid.z0[plane + 1] * grid.z0[5 + plane]) / radius
    np.testing.assert_allclose(radius, u.ravel()[grid.cell], rtol=1e-14)
    np.testing.assert_allclose(momentum, v.ravel()[grid.cell], rtol=0, atol=1e-14)
    assert grid.names == (("alpha", "p_alpha") if plane == 0 else ("beta", "p_beta"))
    np.testing.assert_array_equal(np.flatnonzero(~grid.forbidden.ravel()), grid.cell)
    assert grid.forbidden.shape == (9, 7)
    assert grid.energy == energy


@every_body
def test_the_allowed_cells_are_those_that_the_energy_reaches(body, energy):
    """AlphaEquals: the rest of the kinetic energy for p_alpha must not be negative."""
    grid = energy_grid(body, energy=energy, section=AlphaEquals(1.4), axes=BETAS, p_eta=0.3, p_gamma=-0.1)
    beta, p_beta = np.meshgrid(*BETAS, indexing="ij")
    V = body.potential_energy(1.4, 0.0, beta, 0.0)
    rest = energy - V - (p_beta**2 + (0.3 / 1.4) ** 2 + (0.1 / beta) ** 2) / (2 * body.mu)
    np.testing.assert_array_equal(grid.forbidden, ~(rest >= 0))


@pytest.mark.parametrize("direction", [1, -1])
def test_turning_points_are_the_inner_and_the_outer_one(direction):
    """Harmonic: (a + b alpha^2)^2 by hand. alpha^2 solves C alpha^4/2 - e alpha^2 + p_eta^2/2 mu = 0."""
    body, e0, p_eta = Body(Harmonic(1.3), 0.7), 3.0, 0.4
    grid = energy_grid(body, energy=e0, section=AlphaTurning(direction), axes=BETAS, p_eta=p_eta)
    beta, p_beta = (x.ravel()[grid.cell] for x in np.meshgrid(*BETAS, indexing="ij"))
    e = e0 - 1.3 * beta**2 / 2 - p_beta**2 / 1.4
    root = np.sqrt(e**2 - 1.3 * p_eta**2 / 0.7)
    outer = (e + root) / 1.3
    A = outer if direction < 0 else p_eta**2 / (1.3 * 0.7) / outer
    np.testing.assert_allclose(np.hypot(*grid.z0[:2]), np.sqrt(A), rtol=1e-12)
    assert not grid.forbidden.any()


def test_forbidden_cells_are_masked_when_values_are_spread():
    body, energy = BODIES[2]
    wide = np.linspace(0.05, 1.5, 12), np.linspace(-3, 3, 11)
    grid = energy_grid(body, energy=energy, section=AlphaTurning(-1), axes=wide)
    assert 0 < grid.forbidden.mean() < 1
    spread = grid.spread(np.arange(grid.cell.size))
    assert spread.shape == (12, 11)
    np.testing.assert_array_equal(spread.mask, grid.forbidden)
    np.testing.assert_array_equal(spread.compressed(), np.arange(grid.cell.size))


def test_without_angular_momenta_the_radius_may_be_zero():
    body = Body(Hyperelastic())
    grid = energy_grid(body, energy=2.5, section=AlphaEquals(1.5), axes=([0.0, 0.1], [0.0, 0.2]))
    assert grid.cell.size == 4
    np.testing.assert_array_equal(grid.z0[[1, 3, 5, 7]], 0.0)
    assert constants(body, grid.z0)[0] == pytest.approx(2.5)


@pytest.mark.parametrize(("normal", "offset"), [((1.0, 0, 0, 0), 0.0), ((0, 2.0, 0, 0), 0.2), ((-1.0, 0, 0, 0), 0.1)])
@pytest.mark.parametrize("direction", [1, -1])
def test_henon_heiles(normal, offset, direction):
    model, section = HenonHeiles(), Linear(normal, offset, direction)
    axes = np.linspace(-0.4, 0.5, 10), np.linspace(-0.4, 0.4, 9)
    grid = energy_grid(model, energy=0.12, section=section, axes=axes)
    i = int(np.flatnonzero(normal)[0])
    np.testing.assert_allclose(model.kinetic_energy(*grid.z0[2:]) + model.potential_energy(*grid.z0[:2]), 0.12, rtol=1e-13)
    np.testing.assert_allclose(grid.z0[i], offset / normal[i], rtol=1e-15)
    u, v = np.meshgrid(*axes, indexing="ij")
    np.testing.assert_array_equal(grid.z0[[1 - i, 3 - i]], [u.ravel()[grid.cell], v.ravel()[grid.cell]])
    assert (np.sign(grid.z0[2 + i]) * np.sign(normal[i]) == direction).all()
    assert grid.names == (("y", "p_y"), ("x", "p_x"))[i]


@pytest.mark.parametrize(("section", "axes"), [SECTIONS[1], SECTIONS[5], SECTIONS[9]], ids=["turning", "alpha", "area"])
def test_a_map_from_a_grid_stays_on_its_section(section, axes):
    """The grid is where the map lives: same energy, same section, first return not at once."""
    body, energy = BODIES[2]
    grid = energy_grid(body, energy=energy, section=section, axes=axes, p_eta=0.3, p_gamma=-0.1)
    cut = poincare_map(body, grid.z0, section=section, crossings=3, max_time=60.0, step=0.05)
    kept = cut.counts > 0
    assert kept.mean() > 0.9
    E, p_eta, p_gamma = constants(body, cut.points[kept, 0].T)
    np.testing.assert_allclose(E, energy, rtol=1e-6)
    np.testing.assert_allclose([p_eta, p_gamma], [[0.3], [-0.1]] * np.ones(kept.sum()), rtol=1e-11)
    assert np.nanmin(cut.times) > 1e-6


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"energy": 0.5}, ValueError, r"energy 0.5 reaches no cell .* below the minimum"),
        ({"section": AlphaEquals(30.0)}, ValueError, r"reaches no cell of the grid beta in \[0.1, 0.6\].*AlphaEquals\(constant=30.0"),
        ({"section": AlphaEquals(0.05)}, ValueError, "reaches no cell"),
        ({"section": Linear((0.0,) * 7 + (1.0,))}, TypeError, "Linear with one non-zero entry"),
        ({"section": "alpha"}, TypeError, "section must be a section such as"),
        ({"axes": (BETAS[0],)}, TypeError, "axes must be two arrays"),
        ({"axes": 3.0}, TypeError, "axes must be two arrays"),
        ({"axes": ([], BETAS[1])}, ValueError, "axes must be two non-empty"),
        ({"axes": ([np.nan], BETAS[1])}, ValueError, "finite"),
        ({"axes": (np.ones((2, 2)), BETAS[1])}, ValueError, "one-dimensional"),
        ({"energy": np.inf}, ValueError, "energy must be finite"),
        ({"energy": "2"}, TypeError, "energy must be a real number, got '2'"),
        ({"p_eta": None}, TypeError, "p_eta must be a real number"),
        ({"p_gamma": np.nan}, ValueError, "p_gamma must be finite"),
    ],
    ids=lambda v: next(iter(v)) if isinstance(v, dict) else "",
)
def test_wrong_input(change, error, message):
    options = {"energy": 3.2, "section": AlphaTurning(-1), "axes": BETAS} | change
    with pytest.raises(error, match=message):
        energy_grid(BODIES[2][0], **options)


def test_angular_momenta_belong_to_bodies():
    with pytest.raises(ValueError, match="p_eta and p_gamma belong to a Body"):
        energy_grid(HenonHeiles(), energy=0.1, section=Linear((1, 0, 0, 0)), axes=([0.1], [0.1]), p_eta=0.1)
    with pytest.raises((TypeError, ValueError), match="section"):
        energy_grid(HenonHeiles(), energy=0.1, section=AlphaTurning(), axes=([0.1], [0.1]))
