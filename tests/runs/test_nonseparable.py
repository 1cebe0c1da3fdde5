"""H(q, p) that is not T(p) + V(q), from a line of text: orbits, errors, sections, frequencies, chaos against truths."""

import inspect
import math

import numpy as np
import pytest
import shared_systems
from scipy.integrate import solve_ivp

import fastaff as fa
import fastaff.runs.integrate as integrate_module
from fastaff.core.status import Status
from fastaff.runs.schemes import GAUSS8, GAUSS16, VERNER9
from fastaff.systems.models.mechanics import system_of
from fastaff.systems.models.sections import AngleEquals

DOUBLE = (
    "(p1**2*m2*b**2 + p2**2*(m1 + m2)*a**2 - 2*m2*a*b*p1*p2*cos(q1 - q2))/(2*m2*a**2*b**2*(m1 + m2*sin(q1 - q2)**2))"
    " - (m1 + m2)*g*a*cos(q1) - m2*g*b*cos(q2)"
)
UNIT = {"m1": 1.0, "m2": 1.0, "a": 1.0, "b": 1.0, "g": 1.0}
RNG = np.random.default_rng(32)


def pendulum(**parameters):
    turn = {"q1": "2*pi", "q2": "2*pi"}
    return fa.hamiltonian(DOUBLE, coordinates="q1 q2", momenta="p1 p2", periodic=turn, **{**UNIT, **parameters})


def drawn():
    """Masses, lengths and gravity, and the slowest rate of small oscillations, about."""
    parameters = {name: float(10 ** RNG.uniform(-0.5, 0.5)) for name in UNIT}
    return parameters, math.sqrt(parameters["g"] / (parameters["a"] + parameters["b"]))


def lagrangian(t, y, m1, m2, a, b, g):
    """Angles and angular velocities, by the equations of Lagrange: they share nothing with H."""
    q1, q2, v1, v2 = y
    s, c = np.sin(q1 - q2), np.cos(q1 - q2)
    mass = np.array([[(m1 + m2) * a * a, m2 * a * b * c], [m2 * a * b * c, m2 * b * b]])
    force = [
        -m2 * a * b * s * v2 * v2 - (m1 + m2) * g * a * np.sin(q1),
        m2 * a * b * s * v1 * v1 - m2 * g * b * np.sin(q2),
    ]
    return [v1, v2, *np.linalg.solve(mass, force)]


def momenta(y, m1, m2, a, b, g):
    c = np.cos(y[0] - y[1])
    return np.array(
        [*y[:2], (m1 + m2) * a * a * y[2] + m2 * a * b * c * y[3], m2 * b * b * y[3] + m2 * a * b * c * y[2]]
    )


@pytest.mark.parametrize("accuracy", [1e-6, 1e-9, 1e-12])
def test_orbits_are_those_of_the_equations_of_lagrange_within_their_errors(accuracy):
    late = []
    for _ in range(3):
        parameters, rate = drawn()
        starts = RNG.uniform(-1.2, 1.2, (4, 6)) * np.array([1, 1, rate, rate])[:, None]
        z0 = np.array([momenta(y, **parameters) for y in starts.T]).T
        found = fa.integrate(pendulum(**parameters), z0, time=10 / rate, accuracy=accuracy)
        assert (found.status == Status.OK).all()
        for k, y in enumerate(starts.T):
            end = solve_ivp(
                lagrangian, (0, 10 / rate), y, args=(*parameters.values(),), method="DOP853", rtol=3e-14, atol=1e-15
            )
            truth = momenta(end.y[:, -1], **parameters)
            allowed = found.error[:, k] + 3e-12 * np.abs(truth).max()
            late.append(np.abs(found.z[:, k] - truth) / allowed)
    assert np.mean(np.array(late) <= 1) >= 0.99
    assert np.max(late) <= 10


def velocities(z, m1, m2, a, b, g):
    q1, q2, p1, p2 = z
    A, B, C = (m1 + m2) * a * a, m2 * a * b * np.cos(q1 - q2), m2 * b * b
    return np.array([q1, q2, (C * p1 - B * p2) / (A * C - B * B), (A * p2 - B * p1) / (A * C - B * B)])


def fastest_rate(m1, m2, a, b, g):
    """Rate of the faster of the small oscillations, about."""
    return math.sqrt(g * (1 / a + 1 / b) * (1 + m2 / m1))


def in_80_bits(y, time, steps, m1, m2, a, b, g):
    """Angles and angular velocities by the equations of Lagrange: extrapolated symmetric steps of order 16."""

    def rates(y):
        q1, q2, v1, v2 = y
        s, c = np.sin(q1 - q2), np.cos(q1 - q2)
        one = -m2 * b * s * v2 * v2 - (m1 + m2) * g * np.sin(q1)  # (m1 + m2) a v1' + m2 b c v2'
        two = a * s * v1 * v1 - g * np.sin(q2)  # a c v1' + b v2'
        w = (one - m2 * c * two) / (a * (m1 + m2 * s * s))
        return np.array([v1, v2, w, (two - a * c * w) / b])

    y, counts, h = y.astype(np.longdouble), range(2, 18, 2), np.longdouble(time) / steps
    for _ in range(steps):
        table = []
        for n in counts:
            x, z = y, y + h / n * rates(y)
            for _ in range(1, n):
                x, z = z, x + 2 * h / n * rates(z)
            table.append(z)
        for k in range(1, len(counts)):
            ends = [(np.longdouble(counts[i]) / counts[i - k]) ** 2 - 1 for i in range(k, len(counts))]
            table = [fine + (fine - coarse) / r for fine, coarse, r in zip(table[1:], table, ends)]
        (y,) = table
    return y


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="needs 80-bit floats")
@pytest.mark.parametrize(("size", "turns", "each"), [(0.2, 20, 3), (0.9, 5, 12), (1.8, 2, 24)])
def test_orbits_are_those_of_80_bit_arithmetic_to_1e_12(size, turns, each):
    """Of random masses, lengths and gravity, both pendulums in motion; the widest as long as they amplify little."""
    for _ in range(2):
        parameters, rate = drawn()
        time = turns / rate
        starts = size * RNG.uniform(-1, 1, (4, 8)) * np.array([1, 1, rate, rate])[:, None]
        z0 = momenta(starts, **parameters)
        exact = {name: np.longdouble(value) for name, value in parameters.items()}
        y0, fastest = velocities(z0.astype(np.longdouble), **exact), fastest_rate(**parameters)
        coarse, fine = (
            momenta(in_80_bits(y0, time, n * math.ceil(fastest * time), **exact), **exact) for n in (each, each + 1)
        )
        assert (np.abs(fine - coarse) < 1e-13 * np.abs(fine).max(axis=1)[:, None]).all()
        truth, model = fine, fa.models.DoublePendulum(*parameters.values())
        found = fa.integrate(model, z0, time=time, accuracy=1e-13)
        off = np.abs(found.z - truth)
        assert (off <= 1e-12 * np.repeat([1.0, np.abs(truth[2:]).max()], 2)[:, None]).all()


def test_the_named_model_is_the_text():
    """Energy, rates and their changes at random points, and an orbit."""
    for _ in range(5):
        parameters, rate = drawn()
        named, text = fa.models.DoublePendulum(*parameters.values()), pendulum(**parameters)
        z, w = RNG.uniform(-3, 3, (2, 4))
        np.testing.assert_allclose(named.energy(*z), text.energy(*z), rtol=1e-12, atol=1e-12)
        for one, other in (
            (named.rates(*z), text.rates(*z)),
            (named.tangent_rates(*z, *w), text.tangent_rates(*z, *w)),
        ):
            np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-11 * np.abs(other).max())
    found = [fa.integrate(model, z, time=3 / rate, accuracy=1e-11) for model in (named, text)]
    assert (np.abs(found[0].z - found[1].z) <= found[0].error + found[1].error).all()
    assert named.periods() == text.periods()


@pytest.mark.parametrize(("scheme", "step"), [(GAUSS8, 0.2), (GAUSS16, 0.5)], ids=["GAUSS8", "GAUSS16"])
def test_the_order_is_that_of_the_scheme(scheme, step):
    z0, H = [0.5, 0.2, 0.1, -0.2], pendulum()
    fine = fa.integrate(H, z0, time=8.0, scheme=GAUSS16, step=0.1).z
    error = [np.abs(fa.integrate(H, z0, time=8.0, scheme=scheme, step=h).z - fine).max() for h in (step, step / 1.5)]
    assert abs(math.log(error[0] / error[1]) / math.log(1.5) - scheme.order) < 1.5


def test_small_oscillations_have_the_frequencies_of_the_linear_theory():
    found = fa.frequency_map(pendulum(), [[1e-4], [-2e-4], [0.0], [1e-4]], time=600.0)
    omega = np.sort(2 * np.pi * found.nu[:, 0])
    np.testing.assert_allclose(omega, [math.sqrt(2 - math.sqrt(2)), math.sqrt(2 + math.sqrt(2))], rtol=1e-7)
    parameters, _ = drawn()
    m1, m2, a, b, g = parameters.values()
    mass, stiff = [[(m1 + m2) * a * a, m2 * a * b], [m2 * a * b, m2 * b * b]], np.diag([(m1 + m2) * g * a, m2 * g * b])
    truth = np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiff))))
    found = fa.frequency_map(pendulum(**parameters), [[1e-4], [-2e-4], [0.0], [0.0]], time=600 / truth[0])
    np.testing.assert_allclose(np.sort(2 * np.pi * found.nu[:, 0]), truth, rtol=1e-6)


def test_a_rotating_pendulum_has_its_mean_turn_for_a_frequency():
    z0 = [0.1, 0.0, 20.0, 12.0]
    found = fa.frequency_map(pendulum(), z0, time=400.0)
    angles = fa.integrate(pendulum(), z0, time=400.0, samples=800).samples[:, 0, 0]
    x = (np.arange(800) + 0.5) / 800
    weight = np.exp(-1 / (x * (1 - x)))
    turn = (np.diff(angles, prepend=0.1) * weight).sum() / weight.sum() / 0.5
    assert np.abs(2 * np.pi * found.nu[:, 0] - turn).min() < 1e-5 * turn
    assert not np.any(np.isnan(found.error))


@pytest.mark.parametrize("scheme", [GAUSS8, GAUSS16], ids=lambda s: s.name)
def test_energy_stays_and_time_goes_back(scheme):
    z0, H = [[0.9, 2.0], [0.4, -1.0], [0.3, 0.5], [0.2, 0.1]], pendulum()
    step = {"GAUSS8": 0.1, "GAUSS16": 0.25}[scheme.name]
    errors = [fa.integrate(H, z0, time=t, scheme=scheme, step=step).energy_error for t in (25.0, 5000.0)]
    assert errors[1][0] < 3e-9 if scheme is GAUSS8 else errors[1][0] < 1e-13
    there = fa.integrate(H, z0, time=10.0, scheme=scheme, step=step).z
    back = fa.integrate(H, there * np.array([1, 1, -1, -1])[:, None], time=10.0, scheme=scheme, step=step).z
    np.testing.assert_allclose(back * np.array([1, 1, -1, -1])[:, None], z0, rtol=0, atol=2e-13)


@pytest.mark.slow
def test_energy_error_is_bounded_over_a_million_steps():
    z0, H = [0.9, 0.4, 0.3, 0.2], pendulum()
    found = fa.integrate(H, z0, time=2.5e5, scheme=GAUSS16, step=0.25, samples=1000)
    drift = np.array([H.energy(*z) for z in found.samples[..., 0]]) - H.energy(*z0)
    assert np.abs(drift).max() < 1e-12


def test_the_tangent_map_is_symplectic_and_the_derivative():
    parameters, rate = drawn()
    H, z0 = pendulum(**parameters), np.array([0.5, -0.3, 0.1 * rate, 0.2 * rate])
    found = fa.tangent_map(H, z0, time=3 / rate).matrix[..., 0]
    J = np.kron([[0, 1], [-1, 0]], np.eye(2))
    assert np.abs(found.T @ J @ found - J).max() < 1e-13 * np.abs(found).max() ** 2
    shifts = 1e-5 * np.eye(4)
    ends = [fa.integrate(H, (z0 + s * shifts).T, time=3 / rate, scheme=GAUSS16, step=0.05 / rate).z for s in (1, -1)]
    np.testing.assert_allclose(found, (ends[0] - ends[1]) / 2e-5, rtol=0, atol=1e-7 * np.abs(found).max())


def test_a_separable_hamiltonian_written_with_momenta_has_the_bits_of_today():
    V, z0 = "(x**2 + 2*y**2)/2 + x**2*y - e*y**3/3", RNG.uniform(-0.3, 0.3, (4, 5))
    for T, masses in (("(px**2 + py**2)/2", None), ("px**2/(2*m) + py**2/6", [2.5, 3.0])):
        more = {} if masses is None else {"m": 2.5}
        new = fa.hamiltonian(f"{T} + {V}", coordinates="x y", momenta="px py", e=0.7, **more)
        old = fa.hamiltonian(V, coordinates="x y", masses=masses, e=0.7)
        assert system_of(new).separable
        for run in (fa.integrate, fa.frequency_map):
            one, other = (run(model, z0, time=80.0) for model in (new, old))
            np.testing.assert_array_equal(
                one.z if run is fa.integrate else one.nu, other.z if run is fa.integrate else other.nu
            )
    drive = {"coordinates": "x", "drive_period": "2*pi/w", "w": 1.3}
    new, old = fa.hamiltonian("p**2/2 - cos(x - w*t)", momenta="p", **drive), fa.hamiltonian("-cos(x - w*t)", **drive)
    np.testing.assert_array_equal(*(fa.integrate(model, [0.3, 0.1], time=30.0).z for model in (new, old)))
    skew = fa.hamiltonian("px**2/2 + py**2/2 + k*px*py + x**2 + y**4/4", coordinates="x y", momenta="px py", k=0.4)
    assert system_of(skew).separable
    assert skew.kinetic_energy(1.0, 2.0) == 0.5 + 2.0 + 0.8


def test_a_rotating_frame_written_out_is_the_exact_turn():
    """The same system as `rotation` makes; a part that is no turn is left to collocation."""
    V, z0 = "(x**2 + 1.7*y**2)/2 + x**2*y", RNG.uniform(-0.2, 0.2, (4, 5))
    names, w = {"coordinates": "x y", "momenta": "px py"}, RNG.uniform(0.2, 0.4)
    old = fa.hamiltonian(V, coordinates="x y", rotation=w)
    new = fa.hamiltonian(f"(px**2 + py**2)/2 + {V} - w*(x*py - y*px)", **names, w=w)
    assert system_of(new).terms == {"frame"}
    assert system_of(new).row_names == ("x", "y", "px", "py")
    assert new.angular_velocity() == old.angular_velocity()
    squared = fa.hamiltonian(f"((px + w*y)**2 + (py - w*x)**2)/2 - w**2*(x**2 + y**2)/2 + {V}", **names, w=w)
    bent = fa.hamiltonian(f"(px**2 + py**2)/2 + {V} - w*(x*py - y*px) + 1e-9*x*px**2", **names, w=w)
    assert system_of(squared).terms == {"frame"}
    assert system_of(bent).terms == {"nonseparable"}
    runs = [fa.integrate(model, z0, time=60.0, accuracy=1e-11) for model in (old, new, squared, bent)]
    np.testing.assert_array_equal(runs[0].z, runs[1].z)
    assert (np.abs(runs[2].z - runs[0].z) <= runs[2].error + runs[0].error).all()
    assert (np.abs(runs[3].z - runs[0].z) <= runs[3].error + runs[0].error + 1e-6).all()
    for text in (
        f"(px**2 + py**2)/2 + {V} - w*x*py",
        f"(px**2 + 2*py**2)/2 + {V} - w*(x*py - y*px)",
        f"(px**2 + py**2)/2 + {V} - w*x*(x*py - y*px)",
    ):
        assert system_of(fa.hamiltonian(text, **names, w=w)).nonseparable


def test_a_uniform_field_written_out_is_the_exact_turn():
    m, b = 10 ** RNG.uniform(-0.3, 0.3, 2)
    names, z0 = {"coordinates": "x y z", "momenta": "px py pz"}, RNG.uniform(-0.3, 0.3, (6, 4))
    text = f"((px + b*y/2)**2 + (py - b*x/2)**2)/(2*m) + pz**2/2 + {shared_systems.CHARGE}"
    new = fa.hamiltonian(text, **names, m=m, b=b, k=1.1, a=1.0)
    assert system_of(new).terms == {"frame"}
    old = shared_systems.charge(1.1, 1.0, b, (m, m, 1))
    runs = [fa.integrate(model, z0, time=30.0, accuracy=1e-11) for model in (old, new)]
    assert (np.abs(runs[1].z - runs[0].z) <= runs[1].error + runs[0].error).all()
    np.testing.assert_allclose(runs[1].energy_error, 0.0, atol=1e-10)


def test_a_driven_one_has_the_orbits_of_its_equations():
    H = fa.hamiltonian(
        "p**2*(1 + x**2)/2 + x**2/2 - e*x*p*cos(w*t)", coordinates="x", momenta="p", drive_period="2*pi/w", e=0.3, w=1.7
    )
    assert system_of(H).terms == {"drive", "nonseparable"}

    def rates(t, z):
        x, p = z
        c = 0.3 * np.cos(1.7 * t)
        return [p * (1 + x * x) - c * x, -p * p * x - x + c * p]

    z0 = RNG.uniform(-0.5, 0.5, (2, 4))
    found = fa.integrate(H, z0, time=30.0, accuracy=1e-10)
    for k in range(4):
        end = solve_ivp(rates, (0, 30), z0[:, k], method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
        assert (np.abs(found.z[[0, 2], k] - end) <= found.error[[0, 2], k] + 1e-11).all()
    assert (found.energy_error < 1e-9).all()
    cut = fa.poincare_map(H, z0, section="t=0", crossings=5, accuracy=1e-10)
    step = fa.integrate(H, z0, time=5 * 2 * np.pi / 1.7, accuracy=1e-11)
    np.testing.assert_allclose(cut.points[[0, 2], -1], step.z[[0, 2]], rtol=0, atol=1e-8)


@pytest.mark.parametrize("direction", [1, -1, 0])
def test_sections_at_an_angle_are_meant_up_to_whole_turns(direction):
    """Against the crossings of q1 = 2 pi k that SciPy's events find, of librating and of turning orbits."""
    H = pendulum()
    z0 = np.array([[0.5, 0.2, 0.1, -0.2], [0.5, 1.0, 9.0, 1.0], [0.5, 1.0, -9.0, 1.0], [2.5, -2.0, 1.0, 3.0]]).T
    cut = fa.poincare_map(
        H,
        z0,
        section=AngleEquals((1.0, 0.0, 0.0, 0.0), direction=direction),
        crossings=60,
        max_time=15.0,
        accuracy=1e-9,
    )

    def event(t, z):
        return np.sin(z[0] / 2)

    for k in range(4):
        path = solve_ivp(
            lambda t, z: H.rates(*z), (0, 15), z0[:, k], method="DOP853", rtol=1e-12, atol=1e-13, events=event
        )
        rising = np.array([H.rates(*z)[0] for z in path.y_events[0]])
        times = path.t_events[0][(rising * direction > 0) | (direction == 0)]
        assert cut.counts[k] == len(times)
        np.testing.assert_allclose(cut.times[: len(times), k], times, rtol=0, atol=1e-7)
        points = cut.points[:, : len(times), k]
        assert np.abs(points[0]).max(initial=0.0) < 1e-12
        assert np.abs(points[1]).max(initial=0.0) <= np.pi
    text = fa.poincare_map(H, z0, section="q1=0", crossings=60, max_time=15.0, accuracy=1e-9)
    if direction == 1:
        np.testing.assert_array_equal(text.points, cut.points)


def test_chaos_is_told_from_order():
    """Small swings are regular; a double pendulum from the top is chaotic. The exponents come in pairs."""
    z0 = np.array([[0.05, 0.02, 0.0, 0.0], [0.1, -0.1, 0.05, 0.0], [2.6, 2.9, 0.0, 0.0], [2.2, -1.5, 0.0, 0.0]]).T
    found = fa.chaos_map(pendulum(), z0, time=1000.0)
    assert found.regular.tolist() == [True, True, False, False]
    spectrum = fa.chaos_map(pendulum(), z0[:, 2], time=300.0, indicators=fa.LyapunovSpectrum())
    exponents = spectrum.spectrum[:, 0]
    np.testing.assert_allclose(exponents + exponents[::-1], 0.0, atol=1e-9)
    assert exponents[0] > 0.1


def test_a_periodic_orbit_closes():
    """The slow normal mode, continued to a finite amplitude."""
    H = pendulum()
    guess = [[0.0], [0.0], [0.1 * (2 + math.sqrt(2))], [0.1 * (1 + math.sqrt(2))]]
    found = fa.periodic_orbits(H, guess, section="q1=0", crossings=1)
    assert found.status[0] == Status.OK
    z, time = found.z[:, 0], float(found.period[0])
    assert abs(time - 2 * math.pi / math.sqrt(2 - math.sqrt(2))) < 0.1
    end = fa.integrate(H, z, time=time, accuracy=1e-11).z[:, 0]
    np.testing.assert_allclose(end, z, rtol=0, atol=1e-9)


def test_what_does_not_go_with_it_is_refused():
    H = pendulum()
    text, names = "p**2*x**2 + x**4", {"coordinates": "x", "momenta": "p"}
    for call, error, match in (
        (lambda: fa.hamiltonian(text, **names, friction=0.1), ValueError, "friction .* no part of H"),
        (lambda: fa.hamiltonian(text, **names, masses=[1.0]), ValueError, "masses does not go with momenta"),
        (lambda: fa.hamiltonian(text, **names, rotation=1.0), ValueError, "rotation does not go with momenta"),
        (lambda: fa.hamiltonian(text, coordinates="x", momenta="x"), ValueError, "'x' is taken"),
        (lambda: fa.hamiltonian(text, coordinates="x y", momenta="p p"), ValueError, "'p' is taken"),
        (lambda: fa.hamiltonian(text, coordinates="x y", momenta="p"), ValueError, "momenta must be 2 names"),
        (lambda: fa.hamiltonian(text, coordinates="x"), ValueError, "'p'"),
        (lambda: fa.hamiltonian(text, **names, periodic={"x": 1.0}), ValueError, r"periodic\['x'\] must be a period"),
        (lambda: fa.hamiltonian(text, **names, periodic={"p": 1.0}), ValueError, "periodic must be of x"),
        (lambda: fa.hamiltonian("p**2*x**2 + t", **names, drive_period=1.0), ValueError, "drive_period"),
        (
            lambda: fa.integrate(H, [0.1] * 4, time=1.0, scheme="KAHAN_LI8"),
            ValueError,
            "KAHAN_LI8 requires .* H.q, p.. Use GAUSS16",
        ),
        (lambda: fa.integrate(H, [0.1] * 4, time=1.0, scheme=fa.AUTO), ValueError, "H.q, p.. Use GAUSS16"),
        (
            lambda: fa.integrate(H, [0.1] * 4, time=1.0, scheme=fa.TimeTransformed()),
            ValueError,
            "H.q, p.. Use GAUSS16",
        ),
        (lambda: fa.energy_grid(H, energy=1.0, axes={"q2": [0.1], "p2": [0.1]}), ValueError, "solve must name"),
        (lambda: fa.energy_sample(H, orbits=5, energy=-4.0), ValueError, "at least the minimum -3 "),
        (lambda: fa.action_angles(H, [[0.1]] * 4), (TypeError, ValueError), "H"),
        (lambda: fa.explore(H), ValueError, "energy must be given"),
    ):
        with pytest.raises(error, match=match):
            call()


def test_an_angle_that_goes_round_has_its_mean_rate_for_a_frequency():
    """A spherical pendulum: the rate of its azimuth is in no line."""
    rng = np.random.default_rng(3)
    for _ in range(2):
        model, z, truth = shared_systems.spherical(rng, 16)
        found = fa.frequency_map(model, z, time=400.0)
        off = np.abs(found.nu - truth) / found.error
        assert np.mean(off <= 1) >= 0.98
        assert off.max() < 10
        assert np.median(found.error[1]) < 1e-10
        assert np.mean(found.classification == fa.Classification.REGULAR) > 0.9
        assert (found.basis[:, :, found.classification == fa.Classification.REGULAR] == np.eye(2)[:, :, None]).all()


def test_the_rate_of_an_angle_does_not_know_its_company_nor_where_it_begins():
    model, z, _ = shared_systems.spherical(np.random.default_rng(5), 6)
    whole = fa.frequency_map(model, z, time=200.0, threads=2)
    one = fa.frequency_map(model, z[:, 2:3], time=200.0, threads=1)
    assert one.nu[1, 0] == whole.nu[1, 2]
    assert one.error[1, 0] == whole.error[1, 2]
    moved = fa.frequency_map(model, z + np.array([[0.0], [123.4], [0.0], [0.0]]), time=200.0)
    assert (np.abs(moved.nu - whole.nu) <= whole.error).all()


def test_a_rotor_coupled_to_nothing_turns_as_it_does():
    rng = np.random.default_rng(6)
    text = "a**2/(2*J) + p**2/2 + x**2/2 + k*x**4/4"
    J, k, period = rng.uniform(0.5, 2.0), rng.uniform(0.3, 1.0), rng.uniform(0.5, 5.0)
    model = fa.hamiltonian(text, coordinates="x f", momenta="p a", periodic={"f": "period0"}, J=J, k=k, period0=period)
    z = rng.uniform(0.5, 2.0, (4, 12)) * rng.choice([-1, 1], (4, 12))
    found = fa.frequency_map(model, z, time=300.0)
    assert (np.abs(found.nu[1] - z[3] / J / period) <= found.error[1]).all()
    assert found.error[1].max() < 1e-11
    assert np.mean(found.classification == fa.Classification.REGULAR) > 0.9
    alone = fa.hamiltonian("a**2/2", coordinates="f", momenta="a", periodic={"f": "2*pi"})
    turning = fa.frequency_map(alone, [[0.0, 1.0], [1.7, -2.3]], time=300.0)
    np.testing.assert_allclose(turning.omega[0], [1.7, -2.3], rtol=1e-11)
    assert (turning.classification == fa.Classification.REGULAR).all()


def test_a_rate_that_is_a_multiple_of_another_frequency_decides_nothing():
    """In a plane, an oscillator and its polar angle: the radius swings twice a turn, in every orbit."""
    text = "(pr**2 + (pf/r)**2)/2 + r**2/2"
    model = fa.hamiltonian(text, coordinates="r f", momenta="pr pf", periodic={"f": "2*pi"})
    rng = np.random.default_rng(7)
    z = np.array([rng.uniform(0.7, 1.5, 6), rng.uniform(-3, 3, 6), rng.uniform(-0.5, 0.5, 6), rng.uniform(0.3, 1, 6)])
    found = fa.frequency_map(model, z, time=400.0)
    assert (found.classification != fa.Classification.REGULAR).all()
    np.testing.assert_allclose(found.omega, [[2.0] * 6, [1.0] * 6], atol=1e-9)


def test_an_orbit_of_which_no_look_is_finite_has_a_status_and_not_an_exception():
    text = "pt**2/2 + (s*pf)**2/(2*sin(th)**2) + g*cos(th)"
    numbers = {"g": 1.267732437050385, "s": 2.8662519800800252}
    model = fa.hamiltonian(text, coordinates="th f", momenta="pt pf", periodic={"f": "2*pi*s"}, **numbers)
    run = fa.integrate(model, [2.67863293, -5.34165221, -0.0102855, 0.09021383], time=60.0, accuracy=1e-9)
    assert run.status[0] == fa.Status.OK
    assert run.energy_error[0] < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("gauge", [0.0, 0.3], ids=["T(p) + V(q)", "H(q, p)"])
def test_a_chain_of_sixteen_degrees_of_freedom_moves_by_its_normal_modes(gauge):
    """A harmonic chain, whose momenta are shifted by a gradient: p - gauge q^2."""
    n, rng = 16, np.random.default_rng(16)
    q, p = [f"q{i}" for i in range(n)], [f"p{i}" for i in range(n)]
    spring = " + ".join(f"({a} - {b})**2/2" for a, b in zip(["0", *q], [*q, "0"], strict=True))
    kinetic = " + ".join(f"({w} - g*{x}**2)**2/2" if gauge else f"{w}**2/2" for w, x in zip(p, q, strict=True))
    chain = fa.hamiltonian(f"{kinetic} + {spring}", coordinates=q, momenta=p, **({"g": gauge} if gauge else {}))
    assert system_of(chain).nonseparable == bool(gauge)
    x, v = rng.uniform(-0.5, 0.5, (2, n, 3))
    found = fa.integrate(chain, np.concatenate([x, v + gauge * x * x]), time=25.0, accuracy=1e-11)
    k = np.arange(1, n + 1)
    modes = np.sqrt(2 / (n + 1)) * np.sin(np.outer(k, k) * np.pi / (n + 1))
    w = 2 * np.sin(k * np.pi / (2 * n + 2))[:, None]
    a, b = modes @ x, modes @ v
    there = modes @ (a * np.cos(25 * w) + b / w * np.sin(25 * w))
    moved = modes @ (b * np.cos(25 * w) - a * w * np.sin(25 * w))
    truth = np.concatenate([there, moved + gauge * there**2])
    assert (np.abs(found.z - truth) <= found.error + 1e-12).mean() > 0.97
    np.testing.assert_allclose(found.z, truth, rtol=0, atol=1e-9)
    spectrum = fa.chaos_map(chain, found.z[:, :1], time=20.0, indicators=fa.LyapunovSpectrum()).spectrum[:, 0]
    assert spectrum.size == 2 * n
    np.testing.assert_allclose(spectrum + spectrum[::-1], 0.0, atol=1e-9)


def test_rounding_that_chaos_makes_larger_shortens_no_step():
    """Rotations of a moon on an eccentric orbit: over the span of a trial rounding grows beyond the accuracy."""
    text = "p**2/2 - e2/4*(cos(2*q - 2*t) + 3.5*ec*cos(2*q - 3*t) - ec/2*cos(2*q - t)) + d*p**3*cos(q)"
    moon = fa.hamiltonian(
        text, coordinates="q", momenta="p", drive_period="2*pi", periodic={"q": "2*pi"}, e2=0.2, ec=0.1, d=0.01
    )
    z0 = np.array([[1.11516043, 0.97066886], [-2.31418801, 0.86736902], [1.5549124, 1.34351452]]).T
    found = fa.integrate(moon, z0, time=100.0, accuracy=1e-12)
    assert (found.status == Status.OK).all()
    assert (100.0 / found.step < 2e4).all()
    truth = fa.integrate(moon, z0, time=100.0, scheme=VERNER9, rtol=1e-14, atol=1e-15).z
    assert (np.abs(found.z - truth) <= 2 * found.error).all()


DRAWN = {  # text, coordinates, momenta, angles and periods, sizes of starts around a point, time
    "gyre": (  # a chaotic stream function of two vortices whose border swings
        "a/5*sin(pi*(2*c*sin(t)*x**2 + (1 - 4*c*sin(t))*x))*sin(b*pi*y)",
        "y",
        "x",
        {"drive_period": "2*pi"},
        ([0.5, 1.0], [0.45, 0.95]),
        40.0,
    ),
    "prey": ("exp(q) - a*q + exp(p) - b*p + c*q*p", "q", "p", {}, ([0, 0], [1.2, 1.2]), 50.0),
    "charge": (
        "sqrt(a + (p1 + b*(q2 + c*q2**3))**2 + p2**2) + q1**2/2 + q2**2/2",
        "q1 q2",
        "p1 p2",
        {},
        ([0] * 4, [0.5] * 4),
        70.0,
    ),
    "moon": (
        "-(2 + 3*(1 - G**2))*(3*(b/G)**2/4 - 1)/8 - 15*a/8*(1 - G**2)*(1 - (b/G)**2/4)*cos(2*g) + c*G**2",
        "g",
        "G",
        {"periodic": {"g": "2*pi"}, "domain": "G"},
        ([0, 0.8], [3, 0.15]),
        20.0,
    ),
    "driven": (
        "p**2*(1 + a*cos(w*t)*sin(q)/4)/2 + b*q**4/4 - q**2/2 + c*q*p",
        "q",
        "p",
        {"drive_period": "2*pi/w", "w": 1.7},
        ([1, 0], [0.5, 0.3]),
        30.0,
    ),
    "vortices": (
        "-log((q1 - q2)**2 + (p1 - p2)**2)*a/4 - log((q1 - q3)**2 + (p1 - p3)**2)*b/4"
        " - log((q2 - q3)**2 + (p2 - p3)**2)*c/4",
        "q1 q2 q3",
        "p1 p2 p3",
        {},
        ([1, -0.5, -0.5, 0, 0.87, -0.87], [0.3] * 6),
        30.0,
    ),
}


@pytest.mark.parametrize("name", DRAWN)
def test_errors_of_short_runs_cover_the_truth(name):
    """Of orbits that VERNER9 runs, beside GAUSS16 with steps that are a quarter of those for 1e-12."""
    text, coordinates, conjugate, options, (middle, size), time = DRAWN[name]
    a, b, c = (float(x) for x in RNG.uniform(0.5, 1.0, 3) * [1, 1, 0.2])
    H = fa.hamiltonian(text, coordinates=coordinates, momenta=conjugate, a=a, b=b, c=c, **options)
    z0 = np.array(middle)[:, None] + np.array(size)[:, None] * RNG.uniform(-1, 1, (len(middle), 60))
    fine = fa.integrate(H, z0, time=time, accuracy=1e-12, scheme=GAUSS16)
    sharp = (fine.status == Status.OK) & (fine.accurate_until > 0)
    truth = fa.integrate(H, z0[:, sharp], time=time, step=fine.step[sharp] / 4, scheme=GAUSS16).z
    late, quick = [], 0
    for accuracy in (1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11):
        found = fa.integrate(H, z0[:, sharp], time=time, accuracy=accuracy)
        by = np.isinf(found.step) & (found.status == Status.OK)
        quick += by.sum()
        far = np.abs(found.z) * 1e-14
        late.extend((np.abs(found.z - truth) / (found.error + fine.error[:, sharp] + far)).max(axis=0)[by])
        # Orbits that no run reaches keep the better of their results.
        assert (found.accurate_until[by] == time).mean() > 0.9 or not by.any()
        assert (found.energy_error[by] < 100 * accuracy).all()
    assert quick > 100
    assert np.mean(np.array(late) <= 1) >= 0.98
    assert np.max(late) <= 10


def test_short_runs_are_few(monkeypatch):
    """A further pair of runs is for few orbits; errors near rounding need no symplectic scheme over a short time."""
    own, made = integrate_module._Accurate._toleranced, []

    def counted(self, orbits, *how):
        made.append(orbits.size)
        return own(self, orbits, *how)

    monkeypatch.setattr(integrate_module._Accurate, "_toleranced", counted)
    z0 = 0.3 * np.random.default_rng(5).uniform(-1, 1, (4, 64)) * [[1], [1], [0.5], [0.5]]
    for time, accuracy in ((300.0, 1e-6), (300.0, 1e-9), (30.0, 1e-12)):
        made.clear()
        found = fa.integrate(pendulum(), z0, time=time, accuracy=accuracy)
        truth = fa.integrate(pendulum(), z0, time=time, scheme=VERNER9, rtol=3e-15, atol=1e-15).z
        assert sum(made) <= 3.5 * 64
        assert np.isinf(found.step).mean() > 0.9
        assert (np.abs(found.z - truth) <= found.error).all()
        assert (found.error <= accuracy).all()


ELLIPTIC = "(pu**2 + pv**2)/(2*c**2*(cosh(u)**2 - cos(v)**2))"
CHARTS = {  # H, V in the plane, the map to the plane, its derivative and inverse
    "two centres": (
        f"{ELLIPTIC} - ((a + b)*cosh(u) + (a - b)*cos(v))/(c*(cosh(u)**2 - cos(v)**2))",
        "-a/sqrt((x - c)**2 + y**2) - b/sqrt((x + c)**2 + y**2)",
        (lambda w, c: c * np.cosh(w), lambda w, c: c * np.sinh(w), lambda x, c: np.arccosh(x / c)),
    ),
    "Stark's atom": (
        "((pu**2 + pv**2)/2 - 2*a)/(u**2 + v**2) + b*(u**2 - v**2)/8 + c*(u**2 + v**2)**2/8",
        "-a/sqrt(x**2 + y**2) + b*x/4 + c*(x**2 + y**2)/2",
        (lambda w, c: w * w / 2, lambda w, c: w, lambda x, c: np.sqrt(2 * x)),
    ),
}


@pytest.mark.parametrize("chart", CHARTS)
def test_errors_of_short_runs_cover_the_truth_by_foci(chart):
    """Where H has a factor that is infinite at points of the chart, steps that pass these close make all the errors:
    beside the same orbits in Cartesian coordinates.
    """
    time, count = 8.0, 80
    text, V, (onto, slope, back) = CHARTS[chart]
    numbers = {name: float(RNG.uniform(0.4, 1.2)) for name in "abc"}
    c = numbers["c"]
    chartered = fa.hamiltonian(text, coordinates="u v", momenta="pu pv", **numbers)
    plane = fa.hamiltonian(V, **numbers)
    z0 = np.array([*RNG.uniform(0.5, 1.3, (2, count)), *RNG.normal(0, 0.6, (2, count))])
    w, p = z0[0] + 1j * z0[1], z0[2] + 1j * z0[3]
    x, v = onto(w, c), p / np.conj(slope(w, c))  # p_u - i p_v = (p_x - i p_y) times the slope
    ends = []
    for tolerance in (1e-12, 1e-13):
        start = np.array([x.real, x.imag, v.real, v.imag])
        end = fa.integrate(plane, start, time=time, scheme=VERNER9, rtol=tolerance, atol=tolerance)
        w = back(end.z[0] + 1j * end.z[1], c)
        p = (end.z[2] + 1j * end.z[3]) * np.conj(slope(w, c))
        ends.append(np.array([w.real, w.imag, p.real, p.imag]))
    apart = np.abs(ends[1] - ends[0]).max(axis=0)
    late = []
    for accuracy in (1e-4, 1e-5, 1e-6, 1e-7):
        found = fa.integrate(chartered, z0, time=time, accuracy=accuracy)
        ratio = []
        for sign in (1, -1):  # the chart covers the plane twice, and again after each turn of v
            turn = 2 * np.pi * np.rint((found.z[1] - sign * ends[1][1]) / (2 * np.pi)) * (chart != "Stark's atom")
            off = found.z - sign * ends[1] - turn * np.array([[0], [1], [0], [0]])
            ratio.append((np.abs(off) / (found.error + 10 * apart)).max(axis=0))
        late.extend(
            np.min(ratio, axis=0)[(found.status == Status.OK) & (found.accurate_until == time) & (apart < 1e-8)]
        )
    assert len(late) > 150
    assert np.mean(np.array(late) <= 1) >= 0.98
    assert np.max(late) <= 10


def test_two_runs_that_agree_by_chance_are_not_believed():
    """A chaotic orbit of a driven double gyre that misses the accuracy: its error was 28 times too small."""
    text = "A*sin(pi*(e*sin(w*t)*x**2 + (1 - 2*e*sin(w*t))*x))*sin(pi*y)"
    given = {"drive_period": "2*pi/w", "A": 0.1, "e": 0.25, "w": 2 * np.pi / 10}
    H, random = fa.hamiltonian(text, coordinates="y", momenta="x", **given), np.random.default_rng(0)
    z0 = np.array([random.uniform(0, 1, 300), random.uniform(0, 2, 300)])[:, 180:186]
    fine = fa.integrate(H, z0, time=60.0, accuracy=1e-12)
    for accuracy in (1e-7, 1e-9, 1e-11):
        found = fa.integrate(H, z0, time=60.0, accuracy=accuracy)
        late = np.abs(found.z - fine.z)[[0, 2]] / (found.error + fine.error)[[0, 2]]
        assert late.max() <= 10


def amplified(name, random, count):
    """Return a driven system, starts of it, most of them chaotic, and a time."""
    if name == "gyre":
        text, names = "A*sin(pi*(e*sin(w*t)*x**2 + (1 - 2*e*sin(w*t))*x))*sin(pi*y)", ("y", "x")
        numbers = {
            "A": random.uniform(0.05, 0.3),
            "e": random.uniform(0.05, 0.45),
            "w": 2 * np.pi / random.uniform(4, 15),
        }
        z0, time = np.array([random.uniform(0.02, y, count) for y in (0.98, 1.98)]), random.uniform(20, 100)
    else:
        text, names = "p**2/2 - (1 + a*cos(w*t))*cos(q)", ("q", "p")
        numbers = {"a": random.uniform(0.3, 1), "w": random.uniform(1, 2.5)}
        z0, time = np.array([random.uniform(-y, y, count) for y in (3, 1.5)]), random.uniform(30, 80)
    model = fa.hamiltonian(text, coordinates=names[0], momenta=names[1], drive_period="2*pi/w", **numbers)
    return model, z0, float(time)


@pytest.mark.parametrize(("name", "scheme"), [("gyre", "GAUSS8"), ("pendulum", None)])
def test_errors_that_orbits_amplify_are_not_too_small_by_chance(name, scheme):
    """Of a scheme by name, and of splittings by default: 99 % within, none ten times beyond; some were 38 times."""
    late = []
    for seed in (0, 1):
        random = np.random.default_rng([seed, 5] if name == "pendulum" else seed)
        H, z0, time = amplified(name, random, 100)
        ends = [fa.integrate(H, z0, time=time, scheme=VERNER9, rtol=r, atol=r).z for r in (1e-13, 1e-14)]
        for accuracy in (1e-5, 1e-7, 1e-9):
            found = fa.integrate(H, z0, time=time, accuracy=accuracy, scheme=scheme)
            allowed = found.error + 10 * np.abs(ends[1] - ends[0])
            late.append((np.abs(found.z - ends[1]) / allowed)[[0, 2]].max(axis=0))
    assert np.mean(np.array(late) <= 1) >= 0.99
    assert np.max(late) < 10


@pytest.mark.parametrize("turning", [False, True])
def test_a_factor_before_h_expands_no_potential(turning):
    """Of T + V by its text, at rest or turning: far from the origin an expanded V is a difference of large numbers."""
    turn = " - w*(X*P2 - Y*P1)" if turning else ""
    text = f"h*((P1**2 + P2**2)/2 + (X**2 + (Y - b)**2)/2 + (Y - b)**4/4 + X**2*(Y - b)**2/2{turn})"
    given = {"coordinates": "X Y", "momenta": "P1 P2", "h": 3.0} | ({"w": 0.3} if turning else {})
    far = float(RNG.uniform(1e3, 1e4))
    model = fa.hamiltonian(text, b=far, **given)
    z0 = np.array([*RNG.uniform(-0.8, 0.8, (4, 12))])
    away = np.array([[0.0], [far], [0.0], [0.0]])
    places = (z0 + away)[:2]
    truth = -3.0 * np.array([(x := places[0]) * (1 + (y := places[1] - far) ** 2), y + y**3 + x * x * y])
    np.testing.assert_allclose(np.array(model.force(*places)), truth, rtol=1e-13, atol=1e-14)
    if not turning:
        near, found = (
            fa.integrate(fa.hamiltonian(text, b=b, **given), z, time=10.0, accuracy=1e-9)
            for b, z in ((0.0, z0 + away - away), (far, z0 + away))
        )
        assert (np.abs(found.z - away - near.z) <= found.error + near.error).all()


def test_long_runs_next_to_a_centre_are_left_to_tolerances():
    """Equal steps took minutes for one orbit of a set, or their iteration failed; positions are those of a plane."""
    polar = "a**2/2 + b**2/(2*x**2) + x**2/2 + x**4/4"
    H = fa.hamiltonian(polar, coordinates="x y", momenta="a b", periodic={"y": "2*pi"})
    spins = 10 ** RNG.uniform(-3.5, -1.5, 6)
    z0 = np.array([RNG.uniform(0.7, 1.2, 6), np.zeros(6), RNG.uniform(-0.4, 0.4, 6), spins])
    flat = np.array([z0[0], 0 * spins, z0[2], spins / z0[0]])
    plane = fa.integrate(shared_systems.plane(1, 1, e=1, f=1, g=1), flat, time=400.0, accuracy=1e-12)
    x, y, p, q = plane.z
    r = np.hypot(x, y)
    truth, margin = np.array([r, np.arctan2(y, x), (x * p + y * q) / r]), plane.error.max(axis=0) / r**2
    found = fa.integrate(H, z0, time=400.0, accuracy=1e-5)
    assert (found.status == Status.OK).all()
    assert np.isinf(found.step).any()
    off = np.abs(found.z[:3] - truth)
    off[1] = np.abs(np.mod(found.z[1] - truth[1] + np.pi, 2 * np.pi) - np.pi)
    assert (off <= found.error[:3] + 10 * margin).all()
    assert np.median(found.error.max(axis=0)) <= 1e-5


def test_each_orbit_of_a_default_run_has_its_scheme_whatever_its_company():
    """Falls from the top are chaotic, others short runs; one orbit goes round and round."""
    H, z0 = pendulum(), RNG.uniform(-1, 1, (4, 40)) * 10 ** RNG.uniform(-2, 0.5, 40)
    z0[:, 7] = [3.1, 3.1, 8.0, -9.0]
    whole = fa.integrate(H, z0, time=20.0, accuracy=1e-11, samples=3)
    by = np.isinf(whole.step)
    assert 0 < by.sum() < 40
    assert whole.scheme is GAUSS8
    for some in ([7], [3, 7, 20], np.arange(39, -1, -1)):
        part = fa.integrate(H, z0[:, some], time=20.0, accuracy=1e-11, samples=3, threads=1)
        for field in ("z", "error", "samples", "sample_error", "status", "step", "t", "accurate_until"):
            np.testing.assert_array_equal(getattr(part, field), getattr(whole, field)[..., some], err_msg=field)
    assert fa.integrate(H, z0[:, :2], time=5.0).scheme is VERNER9
    assert fa.integrate(H, [0.1, 0.1, 0.0, 0.1], time=1600.0, accuracy=1e-7).scheme is GAUSS8
    assert fa.integrate(H, z0[:, :2], time=5.0, accuracy=1e-9, scheme=GAUSS8).scheme is GAUSS8


def test_where_a_formula_lives_does_not_depend_on_units_and_origins():
    """A pole that has one sign near the origin alone is no wall; narrow ranges of many rows are found."""
    for _ in range(3):
        s, o = 10 ** float(RNG.uniform(2, 4)), float(RNG.uniform(-3, 3))
        sphere = "p1**2/2 + p2**2/(2*sin(q1/s - o)**2)"
        H = fa.hamiltonian(sphere, coordinates="q1 q2", momenta="p1 p2", s=s, o=o)
        assert all(H.margin((angle + o) * s, 0.0, 1.0, 1.0) > 0 for angle in (-1.5, 1.5))
    hops = " + ".join(f"sqrt(j{i}*(1 - j{i}))*sqrt(j{i + 1}*(1 - j{i + 1}))*cos(f{i} - f{i + 1})" for i in range(5))
    sites = [f"f{i}" for i in range(6)], [f"j{i}" for i in range(6)]
    H = fa.hamiltonian(hops, coordinates=sites[0], momenta=sites[1])
    assert H.margin(*[0.0] * 6, *[0.5] * 6) > 0
    assert H.margin(*[0.0] * 6, *[1.5] * 6) < 0
    with pytest.raises(ValueError, match="text must have finite real values, got none"):
        fa.hamiltonian("sqrt(-1 - j**2)*cos(f)", coordinates="f", momenta="j")


def test_sines_of_sums_of_angles_come_from_those_of_the_angles():
    a, b, c, d = RNG.uniform(0.5, 2.0, 4)
    H = f"p1**2*({2 + a} + cos(q1 - q2)) + {b}*p2**2*(3 + sin(q1 + q2)) + cos(q1 - q2 + q3) + {c}*p3**2 + cos(q3)"
    model = fa.hamiltonian(f"{H} + {d}*sin(q1)*cos(q2)", coordinates="q1 q2 q3", momenta="p1 p2 p3")
    z, dz = RNG.uniform(-3, 3, (6, 50)), RNG.uniform(-1, 1, (6, 50))

    def energy(q1, q2, q3, p1, p2, p3):
        value = p1**2 * (2 + a + np.cos(q1 - q2)) + b * p2**2 * (3 + np.sin(q1 + q2)) + np.cos(q1 - q2 + q3)
        return value + c * p3**2 + np.cos(q3) + d * np.sin(q1) * np.cos(q2)

    def derivative(row):
        moved = z.astype(complex)
        moved[row] += 1e-100j
        return energy(*moved).imag / 1e-100

    exact = [*(derivative(3 + i) for i in range(3)), *(-derivative(i) for i in range(3))]
    np.testing.assert_allclose(np.array(model.rates(*z)), exact, rtol=1e-12, atol=1e-13)
    h = 1e-5
    above, below = (np.array(model.rates(*(z + sign * h * dz))) for sign in (1, -1))
    np.testing.assert_allclose(np.array(model.tangent_rates(*z, *dz)), (above - below) / (2 * h), rtol=1e-6, atol=1e-6)
    text = inspect.getsource(type(model).rates)
    assert text.count("np.sin(") == text.count("np.cos(") == 3


def test_steps_whose_double_fails_have_an_error_still():
    """With twice the first step the iteration of GAUSS16 does not converge: the shorter steps are compared."""
    z0 = np.array([[-0.29], [0.173], [0.13], [0.029]])
    run = fa.integrate(fa.models.DoublePendulum(), z0, time=300.0, scheme=GAUSS16, accuracy=1e-6)
    truth = fa.integrate(fa.models.DoublePendulum(), z0, time=300.0, accuracy=1e-12)
    assert run.accurate_until[0] == 300.0
    assert (np.abs(run.z - truth.z) <= run.error + truth.error).all()


def test_a_tighter_accuracy_gives_no_worse_orbit():
    """A top that passes close to the axis of its chart, which equal steps miss: tighter ones gave worse."""
    top, z = fa.models.AsymmetricTop(1.0, 2.0, 3.5, 0.5, 0.3, 0.8), [1.1, 0.3, 0.4, 0.2, 0.7, 0.5]
    truth = fa.integrate(top, z, time=100.0, scheme=fa.VERNER9, rtol=1e-14, atol=1e-14).z
    runs = [fa.integrate(top, z, time=100.0, accuracy=accuracy) for accuracy in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)]
    stated, true = (np.array(e).max(axis=(1, 2)) for e in ([r.error for r in runs], [abs(r.z - truth) for r in runs]))
    assert np.all(true <= stated)
    assert np.all(stated[1:] <= 10 * np.minimum.accumulate(stated)[:-1])
    assert true[-2:].max() <= 1e-6
    assert runs[1].accurate_until == 100.0  # which the finest tolerance reaches
    assert fa.integrate(top, z, time=200.0, accuracy=1e-8).error.max() < 0.1  # 1022 radians; by equal steps it is lost
