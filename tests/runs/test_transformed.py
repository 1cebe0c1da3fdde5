"""Time-transformed splittings against closed forms, a naive twin, DOP853 and the structure they claim."""

from typing import NamedTuple

import numpy as np
import pytest

from fastaff import (
    AUTO,
    BLANES_MOAN6,
    DOP853,
    KAHAN_LI8,
    LEAPFROG,
    SOFRONIOU_SPALETTA10,
    YOSHIDA4,
    AlphaTurning,
    Body,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    NeoHookean,
    Status,
    TimeTransformed,
    energy_grid,
    frequency_map,
    hamiltonian,
    integrate,
    poincare_map,
    tangent_map,
)
from fastaff.runs import flow
from fastaff.runs.schemes import Algebraic, Exponential, Logistic
from fastaff.runs.schemes.time_transformed import lifted, lowered

RATES = [Exponential(0.7, 0.3), Logistic(0.5, 0.4), Algebraic(0.5, 0.2, 1.5)]
NEO = Body(NeoHookean(G=1.0, K=2.0), 1.0)


def naive_step(model, rate, splitting, h, state):
    """One step of (q..., t, p..., e), written out as the formulas stand."""
    n = model.degrees_of_freedom
    q, t, p, e = state[:n].copy(), state[n], state[n + 1 : 2 * n + 1].copy(), state[2 * n + 1]
    for s, d in enumerate(splitting.drift):
        g = rate.at(e - model.kinetic_energy(*p))
        q, t = q + d * h * g * np.array(model.velocity(*p)), t + d * h * g
        if s < len(splitting.kick):
            p = p + splitting.kick[s] * h * rate.at(model.potential_energy(*q)) * np.array(model.force(*q))
    return np.concatenate([q, [t], p, [e]])


def energy(model, z):
    n = len(z) // 2
    return model.kinetic_energy(*z[n:]) + model.potential_energy(*z[:n])


def started(model, z):
    return lifted(np.reshape(z, (-1, 1)), np.array([energy(model, z)]))[:, 0]


START = {HenonHeiles(): np.array([0.1, -0.2, 0.3, 0.1]), NEO: np.array([1.5, 0.1, 0.2, 0.3, 0.3, 0.2, -0.4, 0.1])}


@pytest.mark.parametrize("rate", RATES, ids=lambda r: type(r).__name__)
@pytest.mark.parametrize("splitting", [LEAPFROG, KAHAN_LI8], ids=lambda s: s.name)
@pytest.mark.parametrize("model", START, ids=lambda m: type(m).__name__)
def test_a_step_is_symplectic_in_extended_phase_space(model, splitting, rate):
    """J^T Omega J = Omega; J by complex steps, exact to rounding."""
    z = started(model, START[model]).astype(complex)
    n = z.size // 2
    J = np.empty((2 * n, 2 * n))
    for j in range(2 * n):
        moved = z.copy()
        moved[j] += 1e-30j
        J[:, j] = naive_step(model, rate, splitting, 0.1, moved).imag / 1e-30
    # the energy e is conjugate to t with the sign of -E: dq ^ dp - dt ^ de
    signs = np.ones(n)
    signs[-1] = -1.0
    omega = np.zeros((2 * n, 2 * n))
    omega[:n, n:], omega[n:, :n] = np.diag(signs), -np.diag(signs)
    assert np.abs(J.T @ omega @ J - omega).max() < 2e-14 * np.abs(J).max() ** 2
    assert np.abs(J - np.eye(2 * n)).max() > 0.01


@pytest.mark.parametrize("rate", RATES, ids=lambda r: type(r).__name__)
def test_a_step_back_undoes_a_step(rate):
    for model, z in START.items():
        there = naive_step(model, rate, KAHAN_LI8, 0.1, started(model, z))
        back = naive_step(model, rate, KAHAN_LI8, -0.1, there)
        assert np.abs(there - started(model, z)).max() > 1e-3
        assert np.abs(back - started(model, z)).max() < 1e-14


@pytest.mark.parametrize("rate", RATES, ids=lambda r: type(r).__name__)
def test_compiled_steps_are_the_naive_ones(rate):
    """A run to a time takes whole steps and a fraction of one: walk the naive twin to the same time by bisection of the
    last step.
    """
    for model, z in START.items():
        h, end = 0.1, 1.3
        found = integrate(model, z, time=end, step=h, scheme=TimeTransformed(KAHAN_LI8, rate))
        state = started(model, z)
        n = z.size // 2
        while True:
            ahead = naive_step(model, rate, KAHAN_LI8, h, state)
            if ahead[n] >= end:
                break
            state = ahead
        low, high = 0.0, h
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if naive_step(model, rate, KAHAN_LI8, middle, state)[n] < end else (low, middle)
        expected = lowered(naive_step(model, rate, KAHAN_LI8, high, state)[:, None])
        assert found.status[0] == Status.OK
        assert found.t[0] == end
        assert np.abs(found.z - expected).max() < 1e-13


@pytest.mark.parametrize(
    ("splitting", "steps"),
    [(LEAPFROG, 0.02), (YOSHIDA4, 0.04), (KAHAN_LI8, 1.0), (SOFRONIOU_SPALETTA10, 1.2)],
    ids=lambda x: getattr(x, "name", ""),
)
def test_orbit_and_time_have_the_order_of_the_splitting(splitting, steps):
    """Errors at a given time, which the location of that time must not spoil."""
    model, z = HenonHeiles(), np.array([[0.1, 0.0], [-0.2, 0.1], [0.3, 0.2], [0.1, 0.35]])
    truth = integrate(model, z, time=4.0, samples=3, scheme=DOP853, rtol=1e-14, atol=1e-15)
    errors = []
    for h in (steps, steps / 2):
        scheme = TimeTransformed(splitting, Logistic(0.1, 0.05))
        found = integrate(model, z, time=4.0, samples=3, step=h, scheme=scheme, energy_tolerance=1.0)
        found.raise_if_failed()
        errors.append(np.sqrt(np.mean((found.samples - truth.samples) ** 2)))
    assert errors[1] > 1e-14
    order = np.log2(errors[0] / errors[1])
    assert (
        splitting.order - 0.5 < order < splitting.order + (0.5 if splitting.order <= 8 else 2.5)
    )  # 10: higher terms are still seen


def test_bounces_off_an_algebraic_wall_keep_the_closed_form():
    """x^2 = E + sqrt(E^2 - 2c) cos(2t + phase), turning at x = 0.014; from the outer turning point."""
    c, E = 1e-4, np.array([0.5, 1.0])
    x0 = np.sqrt(E + np.sqrt(E * E - 2 * c))
    z0 = np.stack([x0, np.zeros(2)])
    barrier = hamiltonian("c/x**2 + x**2/2", coordinates="x", c=c)
    found = integrate(barrier, z0, time=6 * np.pi, samples=48, scheme=TimeTransformed())
    found.raise_if_failed()
    finer = integrate(barrier, z0, time=6 * np.pi, samples=48, scheme=found.scheme, step=found.step / 2)
    square = E + np.sqrt(E * E - 2 * c) * np.cos(2 * found.times)[:, None]
    assert square.min() < 4e-4
    errors = [np.abs(orbits.samples[:, 0] ** 2 - square).max() for orbits in (found, finer)]
    assert errors[0] < 1e-6
    assert errors[1] < errors[0] / 8 + 1e-10  # the second: rounding at x = 0.01, 6 times
    assert found.energy_error.max() < 1e-10


def test_energy_error_does_not_grow_at_a_logarithmic_wall():
    model = hamiltonian("x - log(x)", coordinates="x")
    x = np.exp(-np.linspace(2.0, 5.0, 7))
    z0 = np.stack([x, np.zeros(7)])
    found = integrate(
        model, z0, time=1000.0, samples=1000, step=0.3, scheme=TimeTransformed(KAHAN_LI8, Exponential(1.0, 0.0))
    )
    found.raise_if_failed()
    start = energy(model, z0)
    error = np.abs(energy(model, np.moveaxis(found.samples, 1, 0)) - start) / start
    assert error[:500].max() > 1e-10  # far more than rounding, so that it could grow
    assert error[500:].max() < 1.5 * error[:500].max()
    assert error.max() < 1e-4


def steep(orbits=40):
    grid = energy_grid(
        NEO,
        energy=8.0,
        p_eta=0.3,
        p_gamma=0.2,
        section=AlphaTurning(+1),
        axes=(np.linspace(0.06, 2.8, 22)[1:-1], np.linspace(-3.9, 3.9, 22)[1:-1]),
    )
    return np.ascontiguousarray(grid.z0[:, :: max(1, grid.z0.shape[1] // orbits)])


def test_steep_body_agrees_with_adaptive_steps():
    """Energy 8 before the wall at det phi = 0; sensitivity to the start amplifies 1e-13 by about 1e3 in this time."""
    z0 = steep()
    truth = integrate(NEO, z0, time=1.0, samples=4, scheme=DOP853, rtol=1e-14, atol=1e-14)
    found = integrate(NEO, z0, time=1.0, samples=4, scheme=TimeTransformed())
    found.raise_if_failed()
    assert np.abs(found.samples - truth.samples).max() < 1e-8
    assert np.array_equal(found.samples[-1], found.z)
    assert np.all(found.t == 1.0)
    assert found.energy_error.max() < 1e-9


@pytest.mark.parametrize("scheme", [TimeTransformed(), AUTO], ids=["TimeTransformed", "AUTO"])
def test_ctrl_c_in_any_trial_ends_the_call(scheme, monkeypatch):
    """An interrupted trial must not choose the rate or the scheme."""
    z0, own, count = steep()[:, :6], flow.launch, [0, 0]

    def launch(*arguments):
        count[0] += 1
        if count[0] == count[1]:
            raise KeyboardInterrupt
        own(*arguments)

    monkeypatch.setattr(flow, "launch", launch)
    integrate(NEO, z0, time=1.0, scheme=scheme)
    for at in np.unique(np.geomspace(1, count[0], 12).astype(int)):
        count[:] = 0, at
        with pytest.raises(KeyboardInterrupt):
            integrate(NEO, z0, time=1.0, scheme=scheme)


@pytest.mark.slow
def test_steep_body_keeps_its_energy_for_long():
    z0 = steep(100)
    found = integrate(NEO, z0, time=1000.0, samples=50, scheme=TimeTransformed())
    found.raise_if_failed()
    assert found.energy_error.max() <= 1e-9


def test_many_samples_inside_a_step():
    model, z = HenonHeiles(), START[HenonHeiles()]
    scheme = TimeTransformed(SOFRONIOU_SPALETTA10, Logistic(0.2, 0.1))
    found = integrate(model, z, time=1.0, samples=200, step=0.1, scheme=scheme)
    truth = integrate(model, z, time=1.0, samples=200, scheme=DOP853, rtol=1e-14, atol=1e-15)
    assert np.abs(found.samples - truth.samples).max() < 1e-12
    few = integrate(model, z, time=1.0, samples=2, step=0.1, scheme=scheme)
    assert np.abs(few.samples - found.samples[99::100]).max() < 1e-14


def test_crossings_are_those_of_other_schemes_up_to_max_time():
    section = Hyperplane(normal=(1.0, 0.0, 0.0, 0.0))
    z = np.array([[0.0, 0.0, 0.01], [0.1, 0.2, -0.3], [0.4, 0.3, 0.2], [0.0, 0.1, 0.0]])
    maps = [
        poincare_map(
            HenonHeiles(), z, section=section, crossings=100, max_time=60.0, scheme=scheme, rtol=1e-13, atol=1e-14
        )
        for scheme in (TimeTransformed(KAHAN_LI8, Logistic(0.1, 0.05)), DOP853)
    ]
    found, truth = maps
    assert found.section is section
    assert found.points.shape == truth.points.shape == (4, 100, 3)
    assert np.array_equal(found.counts, truth.counts)
    assert found.counts.min() > 5
    assert np.all(found.status == Status.TOO_FEW_CROSSINGS)
    assert np.nanmax(np.abs(found.points - truth.points)) < 1e-9
    assert np.nanmax(np.abs(found.times - truth.times)) < 1e-9
    assert np.nanmax(found.times) <= 60.0
    assert found.section_error.max() < 1e-14
    few = poincare_map(
        HenonHeiles(), z, section=section, crossings=4, max_time=60.0, step=found.step, scheme=found.scheme
    )
    assert np.all(few.status == Status.OK)
    assert np.array_equal(few.points, found.points[:, :4])


def test_an_orbit_that_escapes_ends_there():
    scheme = TimeTransformed(KAHAN_LI8, Logistic(0.1, 0.05))
    found = integrate(HenonHeiles(), [0.0, 1.5, 0.0, 1.0], time=30.0, samples=7, step=0.1, scheme=scheme)
    assert found.status[0] in (Status.ESCAPED, Status.NONFINITE, Status.STEP_TOO_SMALL)
    assert found.t[0] < 30.0
    assert np.isnan(found.samples[-1, :, 0]).all()


def test_the_trial_takes_a_rate_and_says_it():
    found = integrate(
        Body(Hyperelastic(), 1.0),
        np.array([1.2, 0.1, 0.2, 0.3, 0.3, 0.2, -0.4, 0.1]),
        time=3.0,
        scheme=TimeTransformed(),
    )
    assert isinstance(found.scheme, TimeTransformed)
    assert found.scheme.rate is not None
    assert found.step > 0
    assert found.scheme.splitting is KAHAN_LI8
    assert found.scheme.order == 8
    assert found.scheme.stages == 17
    assert "Preto" in found.scheme.source
    assert "Kahan" in found.scheme.source
    assert "KAHAN" in found.scheme.name
    assert found.energy_error.max() < 1e-10


class Branch(NamedTuple):
    """A rate that takes no arrays."""

    limit: float = 1.0

    def at(self, V):
        return 1.0 if self.limit > V else 0.5


@pytest.mark.parametrize("time", [1e-9, 1e-3])
def test_times_far_below_a_step(time):
    """The end is the start moved by a Taylor polynomial."""
    z0 = START[HenonHeiles()]
    found = integrate(
        HenonHeiles(), z0, time=time, scheme=TimeTransformed(rate=Logistic(0.5, 0.4)), step=0.5, samples=3
    )
    found.raise_if_failed()
    model, z = HenonHeiles(), z0.reshape(4, -1)
    q, p, f = z[:2], z[2:], np.array(model.force(*z[:2]))
    moved = np.concatenate(
        [q + time * p + time**2 / 2 * f, p + time * f + time**2 / 2 * np.array(model.tangent_force(*q, *p))]
    )
    assert np.abs(found.z - moved).max() < 1e-15 + time**3


@pytest.mark.parametrize(
    ("problem", "wrong"),
    [
        (
            TypeError,
            lambda: integrate(HenonHeiles(), START[HenonHeiles()], time=1.0, scheme=TimeTransformed(rate=Branch())),
        ),
        (TypeError, lambda: TimeTransformed(DOP853)),
        (TypeError, lambda: TimeTransformed("KAHAN_LI8")),
        (ValueError, lambda: TimeTransformed(BLANES_MOAN6)),
        (TypeError, lambda: TimeTransformed(rate=1.0)),
        (TypeError, lambda: TimeTransformed(rate=Hyperplane((1.0, 0.0)))),
        (ValueError, lambda: TimeTransformed(rate=Exponential(0.0))),
        (ValueError, lambda: TimeTransformed(rate=Logistic(-1.0, 2.0))),
        (ValueError, lambda: TimeTransformed(rate=Algebraic(1.0, 0.0, -1.0))),
        (ValueError, lambda: TimeTransformed(rate=Exponential(1.0, np.nan))),
        (
            ValueError,
            lambda: integrate(HenonHeiles(), START[HenonHeiles()], time=1.0, step=0.0, scheme=TimeTransformed()),
        ),
        (ValueError, lambda: integrate(HenonHeiles(), START[HenonHeiles()], time=-1.0, scheme=TimeTransformed())),
        (ValueError, lambda: integrate(HenonHeiles(), np.zeros(3), time=1.0, scheme=TimeTransformed())),
        (
            ValueError,
            lambda: integrate(
                HenonHeiles(), START[HenonHeiles()], time=1.0, scheme=TimeTransformed(rate=Exponential(1e-3, 9.0))
            ),
        ),
        (TypeError, lambda: frequency_map(NEO, START[NEO], time=10.0, scheme=TimeTransformed())),
        (TypeError, lambda: tangent_map(NEO, START[NEO], time=10.0, scheme=TimeTransformed())),
    ],
)
def test_wrong_input_raises(problem, wrong):
    with pytest.raises(problem, match=r"splitting|rate|step|time|z0|scheme"):
        wrong()
