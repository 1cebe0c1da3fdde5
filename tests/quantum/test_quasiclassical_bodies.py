"""Quasiclassical levels of bodies by fitted tori: quadratures of bodies that separate, exact levels as hbar falls."""

import numpy as np
import pytest

import fastaff as fa
from fastaff import Status
from fastaff.quantum import quasiclassical_levels, spectrum
from fastaff.quantum.exact import body_tori

RNG = np.random.default_rng(52)


def neo_hookean(rng):
    """A body of random stiffness and inertia."""
    return fa.Body(fa.NeoHookean(G=rng.uniform(0.5, 3), K=rng.uniform(0.5, 3)), rng.uniform(0.5, 2))


@pytest.mark.parametrize(
    ("n", "m", "l"),
    [
        ((0, 0), 4, -2),
        pytest.param((0, 1), 2, 2, marks=pytest.mark.slow),
        ((0, 0), 3, -3),
        pytest.param((2, 1), -4, 2, marks=pytest.mark.slow),
        pytest.param((1, 0), 0, 0, marks=pytest.mark.slow),
    ],
    ids=["both turn", "alpha on a line", "beta through its centre", "excited", "two lines"],
)
def test_tori_of_a_body_that_separates_have_the_levels_of_its_quadratures(n, m, l):
    """EQ2.2h: the mode of vartheta is the faster one."""
    body, hbar = fa.Body(fa.Hyperelastic(RNG.uniform(0.8, 1.6)), RNG.uniform(0.6, 1.5)), RNG.uniform(0.03, 0.06)
    truth = quasiclassical_levels(body, n=n, m=m, l=l, hbar=hbar)
    found = body_tori.BodyLevels(body, hbar, "normal", None).numbered(n[::-1], m, l, None, True)
    assert found.converged.all()
    assert abs(found.E[0] - truth.E[0]) <= found.error[0] + 1e-14 * truth.E[0]
    assert found.error[0] < 1e-5 * truth.spacing.min()
    np.testing.assert_allclose(found.spacing[::-1], truth.spacing, rtol=1e-4)


@pytest.mark.slow
def test_a_reduced_body_has_the_levels_of_the_body():
    """m = 6, l = -2 at hbar = 0.05 are p_eta = 0.2 and p_gamma = 0.1; the guess is a point near the torus."""
    body = fa.Body(fa.NeoHookean())
    reduced = fa.reduced_body(body, p_eta=0.2, p_gamma=0.1)
    whole = quasiclassical_levels(body, n=(0, 0), m=6, l=-2, hbar=0.05)
    part = quasiclassical_levels(reduced, n=(0, 0), hbar=0.05)
    point = reduced.to_planes(np.array([1.44, 0.27, 0.15, 0.35]))
    near = quasiclassical_levels(body, n=(0, 0), m=6, l=-2, hbar=0.05, guess=point)
    assert (whole.names, whole.m[0], whole.l[0]) == (("mode 1", "mode 2"), 6, -2)
    for other in (part, near):
        assert other.converged.all()
        assert abs(other.E[0] - whole.E[0]) <= other.error[0] + whole.error[0]


def test_a_level_of_a_reduced_body_is_near_its_exact_one():
    """No torus was found here, in the series of the radii: m = 6, l = -2 of the body."""
    body = fa.Body(fa.NeoHookean())
    found = quasiclassical_levels(fa.reduced_body(body, p_eta=0.1, p_gamma=0.05), n=(0, 0), hbar=0.025)
    (exact,) = spectrum(body, m=6, l=-2, count=1, hbar=0.025).E
    assert found.converged.all()
    assert 0 < exact - found.E[0] < 0.01 * found.spacing.min()


@pytest.mark.slow
@pytest.mark.parametrize("number", range(4))
def test_the_difference_from_exact_levels_falls_as_hbar_squared(number):
    """hbar (m, l) are kept, so that the tori approach the same equilibrium."""
    rng = np.random.default_rng(number)
    body = neo_hookean(rng)
    m, l, hbar = *[(2, 0), (1, 1), (3, 1), (2, -4)][number], rng.uniform(0.02, 0.04)
    away = []
    for finer in (1, 2):
        found = quasiclassical_levels(body, n=(0, 0), m=finer * m, l=finer * l, hbar=hbar / finer)
        exact = spectrum(body, m=finer * m, l=finer * l, count=1, hbar=hbar / finer)
        assert found.converged.all()
        away.append(exact.E[0] - found.E[0])
    np.testing.assert_allclose(away[0] / away[1], 4.0, rtol=0.2)


def test_lines_that_pass_the_centre_of_a_plane_have_twice_the_quantum():
    """V of the harmonic body at p_gamma = 0: beta is a line, whose cycle is two of the radius."""
    modes = body_tori.upright(
        body_tori.modes_of(fa.reduced_body(fa.Body(fa.Harmonic(1.3)), p_eta=0.4, p_gamma=0.0), "local")
    )
    assert body_tori.centred(modes).tolist() == [False, True]
    assert body_tori.cycles(modes).tolist() == [1.0, 2.0]
    assert (modes.equilibrium[:2] >= 0).all()
    np.testing.assert_allclose(modes.omega * body_tori.cycles(modes), 2 * np.sqrt(1.3), rtol=1e-6)


@pytest.mark.slow
def test_levels_below_an_energy_are_those_of_the_spectrum():
    """Every exact level of the class has one EBK level beside it, nearer than hbar^2 of the spacing allows others."""
    body = fa.Body(fa.NeoHookean())
    exact = spectrum(body, m=6, l=-2, count=6, hbar=0.05).E
    found = quasiclassical_levels(body, max_energy=float(exact[4:6].mean()), m=6, l=-2, hbar=0.05)
    assert found.converged.all()
    np.testing.assert_allclose(found.E, exact[:5], atol=0.05 * np.diff(exact).min())
    one = quasiclassical_levels(body, n=found.n[:, 2], m=6, l=-2, hbar=0.05)
    assert abs(one.E[0] - found.E[2]) <= one.error[0] + found.error[2]


@pytest.mark.slow
def test_classes_below_an_energy_are_those_of_quadratures():
    """All classes are met, with both signs. A harmonic body has no tori of two angles, and no level is claimed."""
    body, hbar = fa.Body(fa.Harmonic(1.3)), 0.3
    top = 0.3 * np.sqrt(1.3) * 3.5
    truth = quasiclassical_levels(body, max_energy=top, hbar=hbar)
    found = body_tori.BodyLevels(body, hbar, "local", None).below(top, None, None, True)

    def rows(table):
        return sorted(zip(table.m.tolist(), table.l.tolist(), table.n.T.tolist(), strict=True))

    assert len(rows(truth)) == 5
    assert rows(found) == rows(truth)
    assert np.isnan(found.E).all()
    assert not found.converged.any()


@pytest.mark.slow
def test_other_maslov_indices_move_the_actions():
    """Indices (2, 6) of n = (0, 0) are those (2, 2) of n = (0, 1), and (0, 0) of n = (0, 0) is the equilibrium."""
    body = fa.Body(fa.NeoHookean())
    moved = quasiclassical_levels(body, n=(0, 0), m=6, l=-2, hbar=0.05, maslov=(2, 6))
    truth = quasiclassical_levels(body, n=(0, 1), m=6, l=-2, hbar=0.05)
    assert moved.converged.all()
    assert abs(moved.E[0] - truth.E[0]) <= moved.error[0] + truth.error[0]


def test_levels_without_a_torus_are_not_converged(monkeypatch):
    fit = fa.fit_torus(fa.HenonHeiles(), [0.1, 0.1, 0.0, 0.0], time=20.0)  # of other angles than those of a body
    monkeypatch.setattr("fastaff.quantum.exact.mode_tori.fit_torus", lambda *given, **named: fit)
    found = quasiclassical_levels(fa.Body(fa.NeoHookean()), n=(0, 0), m=[2, 0], l=[0, 2], hbar=0.01)
    assert found.status.tolist() == [Status.NOT_CONVERGED] * 2
    assert np.isnan(found.E).all()
    assert "no torus of these modes" in found.summary()


def test_wrong_calls_say_the_right_one():
    body = fa.Body(fa.NeoHookean())
    inside = [1.5, 0.0, 0.3, 0.0, 0.0, 0.3, 0.2, 0.1]
    for wrong, message in (
        ({"n": (0, 0)}, "give n, m and l, or max_energy with or without m and l, got n = "),
        ({"max_energy": 1.0, "m": 2}, "give n, m and l, or max_energy with or without m and l, got n = "),
        ({"max_energy": 1.0, "n": (0, 0), "m": 1, "l": 1}, "give n, m and l, or max_energy with or without m and l"),
        ({"max_energy": 1.0, "guess": inside}, "guess must be given without max_energy"),
        ({"max_energy": np.nan}, "max_energy must be finite"),
        ({"n": (0, -1), "m": 0, "l": 0}, "n must"),
        ({"n": (0, 0), "m": 1, "l": 0}, r"m \+ l must be even"),
        ({"n": (0, 0), "m": 0, "l": 0, "maslov": (2, 2, 2)}, "maslov must be two indices"),
        ({"n": (0, 0), "m": 0, "l": 0, "guess": np.array([inside, inside]).T}, "guess must be one phase point or 1"),
        ({"n": (0, 0), "m": 0, "l": 0, "guess": [1.0, *[0.0] * 7]}, "guess must have alpha and beta above 0"),
        ({"n": (0, 0), "m": 0, "l": 0, "guess": inside, "modes": "local"}, "guess must be given without modes"),
        ({"n": (0, 0), "m": 0, "l": 0, "hbar": 0.0}, "hbar must be positive"),
    ):
        with pytest.raises(ValueError, match=message):
            quasiclassical_levels(body, **wrong)
