"""Sections of measured series: against true crossings of random oscillators and of integrated orbits."""

import numpy as np
import pytest
from scipy.optimize import brentq

import fastaff as fa
from fastaff.sections import map_samples

LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)


class Signals:
    """Two coordinates, sums of two lines, and their rates; samples at random times."""

    def __init__(self, rng, per_period, noise=0.0):
        self.w = rng.uniform(0.5, 2.0, (2, 2, 1))
        self.phase = rng.uniform(0, 2 * np.pi, (2, 2, 1))
        self.size = rng.uniform(0.1, 1.0, (2, 2, 1))
        mean = 2 * np.pi / self.w.max() / per_period
        self.t = np.cumsum(mean * rng.uniform(0.5, 1.5, 400))
        self.z = self.at(self.t)
        self.z = self.z + noise * rng.normal(size=self.z.shape)

    def at(self, t):
        angle = self.w * np.atleast_1d(t) + self.phase
        return np.concatenate(
            [(self.size * np.cos(angle)).sum(axis=1), -(self.w * self.size * np.sin(angle)).sum(axis=1)]
        )

    def crossings(self, offset, row=0):
        fine = np.linspace(self.t[0], self.t[-1], 200_000)
        g = self.at(fine)[row] - offset
        at = np.flatnonzero(g[1:] * g[:-1] < 0)
        return np.array([brentq(lambda t: self.at(t)[row, 0] - offset, fine[k], fine[k + 1], xtol=1e-15) for k in at])


def compared(made, cut, true):
    """Ratios of true errors to their estimates, of decided crossings: of times, and of points."""
    sound = np.isfinite(cut.time_error[:, 0])
    nearest = true[np.abs(true[:, None] - cut.times[:, 0]).argmin(axis=0)]
    late = np.abs(cut.times[:, 0] - nearest) / cut.time_error[:, 0]
    apart = np.abs(cut.points[..., 0] - made.at(nearest)) / cut.point_error[..., 0]
    return late[sound], apart[:, sound].ravel()


# --- crossings --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("noisy", [False, True])
def test_errors_cover_the_true_ones_at_any_sampling_rate(noisy):
    rng = np.random.default_rng(7 + noisy)
    late, apart, good, wrong = [], [], 0, 0
    for _ in range(150):
        made = Signals(rng, rng.uniform(4, 40), 10.0 ** rng.uniform(-9, -2) if noisy else 0.0)
        offset = rng.uniform(-0.8, 0.8)
        cut = map_samples(made.z, times=made.t, coordinates="x y u v", section=f"x={offset}", direction=0)
        true = made.crossings(offset)
        if cut.status[0] == fa.Status.OK:
            good += 1
            wrong += cut.counts[0] != len(true)
        if len(true) and cut.counts[0]:
            found = compared(made, cut, true)
            late.append(found[0])
            apart.append(found[1])
    assert good > 60
    assert wrong == 0
    for ratio in (np.concatenate(late), np.concatenate(apart)):
        assert ratio.size > 2000
        assert (ratio <= 1).mean() >= 0.99
        assert ratio.max() <= 10


def test_points_near_a_tangency_are_undecided():
    """The section is moved through a maximum of the signal: the number of crossings changes by two, and never wrongly
    with status OK.
    """
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(60):
        made = Signals(rng, rng.uniform(6, 20))
        fine = np.linspace(made.t[0], made.t[-1], 50_000)
        x = made.at(fine)[0]
        tops = x[1:-1][(x[1:-1] > x[:-2]) & (x[1:-1] > x[2:])]
        offset = rng.choice(tops) + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-12, -1)
        cut = map_samples(made.z, times=made.t, coordinates="x y u v", section=f"x={offset}", direction=0)
        if cut.status[0] == fa.Status.OK:
            assert cut.counts[0] == len(made.crossings(offset))
        else:
            assert cut.status[0] == fa.Status.NOT_CONVERGED
        seen.add(int(cut.status[0]))
    assert len(seen) == 2


def test_coarse_samples_are_undecided():
    rng = np.random.default_rng(9)
    for _ in range(40):
        made = Signals(rng, rng.uniform(2.0, 3.0))
        cut = map_samples(made.z, times=made.t, coordinates="x y u v", section="x=0.05", direction=0)
        true = made.crossings(0.05)
        assert cut.status[0] == fa.Status.NOT_CONVERGED or cut.counts[0] == len(true)


def test_noise_beyond_the_change_between_samples_is_undecided():
    rng = np.random.default_rng(1)
    made = Signals(rng, 400, 0.05)
    cut = map_samples(made.z, times=made.t, coordinates="x y u v", section="x=0")
    assert cut.status[0] == fa.Status.NOT_CONVERGED


def test_lorenz_against_its_integrated_section():
    """Samples at unequal times of `integrate`, crossings of `poincare_map`; both directions, an oblique plane."""
    rng = np.random.default_rng(5)
    z0 = fa.integrate(LORENZ, rng.normal(size=(3, 6)) + np.array([[0], [0], [20]]), time=20.0).z
    times = np.unique(np.append(rng.uniform(0, 8.0, 1500), [0.0, 8.0]))
    orbits = fa.integrate(LORENZ, z0, time=8.0, samples=times)
    for section in ("z=27", "z=27-", fa.Hyperplane((1.0, -0.4, 0.2), 3.0)):
        cut = map_samples(orbits, section=section)
        true = fa.poincare_map(LORENZ, z0, section=section, crossings=60, max_time=8.0)
        assert cut.names == ("x", "y", "z")
        sound = cut.status == fa.Status.OK
        assert sound.sum() >= 4
        np.testing.assert_array_equal(cut.counts[sound], true.counts[sound])
        for k in np.flatnonzero(sound):
            n = cut.counts[k]
            late = np.abs(cut.times[:n, k] - true.times[:n, k])
            assert (late <= cut.time_error[:n, k] + 1e-8).all()
            assert np.median(late) < 1e-5


def test_nonlinear_sections_and_the_start():
    """A section of a body's alpha and beta; a start on the section is no crossing."""
    body = fa.Body(fa.NeoHookean())
    z0 = fa.energy_sample(body, energy=1.6, section="alpha=1.5", orbits=4, seed=2, p_eta=0.1, p_gamma=0.2).z0
    times = np.cumsum(np.random.default_rng(2).uniform(0.02, 0.06, 900))
    times = np.append(0.0, times)
    orbits = fa.integrate(body, z0, time=times[-1], samples=times)
    cut = map_samples(orbits, section=fa.AlphaEquals(1.5))
    true = fa.poincare_map(body, z0, section=fa.AlphaEquals(1.5), crossings=200, max_time=times[-1])
    sound = cut.status == fa.Status.OK
    assert sound.any()
    for k in np.flatnonzero(sound):
        n = cut.counts[k]
        assert n == true.counts[k]
        assert (np.abs(cut.times[:n, k] - true.times[:n, k]) <= cut.time_error[:n, k] + 1e-9).all()


# --- the result -------------------------------------------------------------------------------------------------------


def test_containers_ends_and_files(tmp_path):
    t = 0.2 * np.arange(200)
    x, p = np.sin(t + np.array([[0.1], [0.7]])), np.cos(t + np.array([[0.1], [0.7]]))
    cut = map_samples(np.stack([x, p]), 0.2, coordinates="x p", section="x=0")
    for other in (
        map_samples({"p": p, "x": x}, times=t, coordinates="x p", section="x=0"),
        map_samples(np.stack([x, p]), times=t, coordinates=("x", "p"), section=fa.Hyperplane((1.0, 0.0))),
    ):
        np.testing.assert_array_equal(other.times, cut.times)
        np.testing.assert_array_equal(other.points, cut.points)
    alone = map_samples(np.stack([x[1], p[1]]), 0.2, coordinates="x p", section="x=0")
    np.testing.assert_array_equal(alone.times[:, 0], cut.times[: len(alone.times), 1])
    assert cut.scheme is None
    assert cut.step == pytest.approx(0.2)
    again = fa.load(fa.save(tmp_path / "cut", cut))
    np.testing.assert_array_equal(again.point_error, cut.point_error)
    assert again.scheme is None
    assert fa.plot.plot_section(cut).points is not None
    x[1, 90:] = np.nan
    ended = map_samples(np.stack([x, p]), 0.2, coordinates="x p", section="x=0")
    assert ended.status.tolist() == [fa.Status.OK, fa.Status.NONFINITE]
    np.testing.assert_array_equal(ended.times[: ended.counts[1], 1], cut.times[: ended.counts[1], 1])
    assert "NONFINITE (a coordinate became infinite or NaN; check the samples)" in ended.summary()


def test_samples_that_do_not_resolve_the_crossings_are_named():
    t = np.arange(200.0)
    cut = map_samples(np.array([np.sin(2.9 * t), np.cos(2.9 * t)]), 1.0, coordinates="x p", section="x=0")
    assert cut.status.tolist() == [fa.Status.NOT_CONVERGED]
    assert "NOT_CONVERGED (samples too few or too far apart to find the crossings; take more samples)" in cut.summary()
    assert "guess" not in cut.summary()


T = 0.1 * np.arange(40)
RING = np.stack([np.sin(T), np.cos(T)])


@pytest.mark.parametrize(
    ("given", "kind", "message"),
    [
        ({"samples": RING.T}, ValueError, r"samples must have at least 16 samples, got shape \(40, 2\). Try samples.T"),
        ({"samples": RING[0]}, ValueError, "samples must have shape"),
        ({"samples": "file"}, TypeError, "samples must be arrays or a result"),
        ({"samples": fa.HenonHeiles()}, TypeError, "samples must be arrays or a result"),
        ({"dt": None}, TypeError, "times is required"),
        ({"dt": 0.0}, ValueError, "dt must be positive"),
        ({"times": T}, ValueError, "dt must not be given beside times"),
        ({"dt": None, "times": T[::-1]}, ValueError, "times must increase, got 3.8 after 3.9"),
        ({"dt": None, "times": T[1:]}, ValueError, r"times must have shape \(40,\)"),
        ({"dt": None, "times": np.where(T > 1, np.nan, T)}, ValueError, "times must be finite, got nan"),
        ({"coordinates": "x"}, ValueError, "coordinates must be 2 names"),
        ({"coordinates": "x x"}, TypeError, "coordinates must be different names"),
        ({"section": "x"}, ValueError, "section must be a name and a number, such as q1=0"),
        ({"section": "z=1"}, ValueError, "section must be one of"),
        ({"section": fa.Hyperplane((1.0, 0.0, 0.0))}, ValueError, "section must depend on the 2 rows"),
        ({"section": 3}, TypeError, "section must be a section or text"),
        ({"direction": 2}, ValueError, "direction must be"),
    ],
)
def test_wrong_input(given, kind, message):
    with pytest.raises(kind, match=message):
        map_samples(**{"samples": RING, "dt": 0.1, "section": "q1=0", **given})
