"""Driven systems V(q, t): against Floquet's theory, Mathieu's characteristic values and independent integrations."""

import dataclasses
import pickle

import numpy as np
import pytest
from mpmath import mp
from own_models import Driven, NoPhase, Stopped
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b
from shared_systems import duffing

import fastaff as fa
from fastaff.jobs.analyses import FrequencyOptions, PoincareOptions
from fastaff.jobs.job import Job
from fastaff.jobs.launch import InitialConditions
from fastaff.jobs.system import EnergySurface, Model, described
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8 as BCE8
from fastaff.systems.models.mechanics import system_of
from fastaff.systems.models.sections import Stroboscopic

SPLITTINGS = [fa.LEAPFROG, fa.YOSHIDA4, fa.BLANES_MOAN6, fa.KAHAN_LI8]


def mathieu(delta, eps):
    """x'' + (delta - 2 eps cos 2t) x = 0."""
    return fa.hamiltonian(
        "x**2/2*(delta - 2*eps*cos(2*t))", coordinates="x", drive_period="pi", delta=float(delta), eps=float(eps)
    )


def pendulum(a=0.05, w=1.5):
    return fa.hamiltonian("-cos(x) - a*cos(x - w*t)", coordinates="x", drive_period="2*pi/w", a=a, w=w)


def two_waves():
    return fa.hamiltonian(
        "k/2*x**2 + y**2/2 + c*x**2*y + a*x*sin(w*t) - b*y**2*cos(2*w*t)",
        coordinates="x y",
        masses=(1.3, 0.8),
        drive_period="2*pi/w",
        k=1.7,
        c=0.1,
        a=0.05,
        b=0.1,
        w=0.83,
    )


def monodromy(model, **options):
    """The map over a period of the coordinate and its momentum."""
    found = fa.poincare_map(model, np.eye(2), section="t=0", crossings=1, **options)
    return found.points[[0, 2], 0]


def truth(force, z0, time):
    """Taylor series of 15 digits and more, by mpmath."""
    with mp.workdps(18):
        solution = mp.odefun(lambda t, y: [y[1], force(t, y[0])], 0, [mp.mpf(float(v)) for v in z0])
        return np.array([float(v) for v in solution(mp.mpf(float(time)))])


def test_mathieu_stability_borders():
    rng = np.random.default_rng(5)
    for order in (1, 2, 3):
        eps = rng.uniform(0.3, 1.5)
        for characteristic in (mathieu_a, mathieu_b):
            border = characteristic(order, eps)
            sign = 2 * (-1) ** order

            def above(delta, eps=eps, sign=sign):
                matrix = monodromy(mathieu(delta, eps), step=np.pi / 64)
                return (matrix[0, 0] + matrix[1, 1] - sign) * np.sign(sign)

            # The trace passes +-2 with a finite slope at the border of a zone.
            assert abs(brentq(above, border - 0.02, border + 0.02, xtol=1e-14) - border) < 1e-11, (order, eps)


def test_mathieu_exponents_agree_with_its_borders_and_with_mpmath():
    rng = np.random.default_rng(6)
    for _ in range(3):
        delta, eps = rng.uniform(1.2, 3.0), rng.uniform(0.05, 0.2)
        force = lambda t, x: -(mp.mpf(delta) - 2 * mp.mpf(eps) * mp.cos(2 * t)) * x  # noqa: E731, B023
        exact = np.array([truth(force, z, np.pi) for z in np.eye(2)]).T
        matrix = monodromy(mathieu(delta, eps), accuracy=1e-12, scheme=BCE8)
        assert np.abs(matrix - exact).max() < 1e-11
        assert abs(np.linalg.det(matrix) - 1) < 5e-12
        nu = np.arccos((exact[0, 0] + exact[1, 1]) / 2) / (2 * np.pi)  # cycles per period
        found = fa.frequency_map(mathieu(delta, eps), [0.3, 0.1], time=3000.0)
        cycles = found.nu[0, 0] * np.pi
        apart = min(abs((cycles - s * nu + 0.5) % 1 - 0.5) for s in (1, -1))
        assert apart < 1e-11
        assert apart <= found.error[0, 0] * np.pi + 1e-15
        assert found.nu[1, 0] == 1 / np.pi
        assert found.names == ("x", "t")


@pytest.mark.parametrize(
    ("model", "force", "scheme"),
    [
        (pendulum(), lambda t, x: -mp.sin(x) - mp.mpf(0.05) * mp.sin(x - mp.mpf(1.5) * t), BCE8),
        (duffing(), lambda t, x: x - x**3 + mp.mpf(0.3) * mp.cos(mp.mpf(1.2) * t), None),  # RKN12, slow to compile
    ],
    ids=["pendulum", "duffing"],
)
def test_orbits_against_taylor_series(model, force, scheme):
    z = np.array([[0.9, -0.4, 1.3], [0.1, 0.7, 0.2]])
    found = fa.integrate(model, z, time=6.0, accuracy=1e-13, scheme=scheme)
    exact = np.array([truth(force, start, 6.0) for start in z.T]).T
    apart = np.abs(found.z[[0, 2]] - exact)
    assert apart.max() < 2e-13
    assert (apart <= found.error[[0, 2]]).all()
    assert found.names == ("x", "t", "p_x", "p_t")
    assert (found.energy_error < 1e-12).all()


@pytest.mark.parametrize("scheme", SPLITTINGS, ids=lambda s: s.name)
def test_orders_hold(scheme):
    z0 = [0.4, -0.3, 0.1, 0.5]
    exact = fa.integrate(two_waves(), z0, time=10.0, scheme=fa.VERNER9, rtol=1e-14, atol=1e-15).z[[0, 1, 3, 4], 0]
    first = {2: 40, 4: 40, 6: 12, 8: 20}[scheme.order]
    error = [
        np.abs(fa.integrate(two_waves(), z0, time=10.0, step=10 / n, scheme=scheme).z[[0, 1, 3, 4], 0] - exact).max()
        for n in (first, 2 * first, 4 * first)
    ]
    assert max(np.log2(error[0] / error[1]), np.log2(error[1] / error[2])) > scheme.order - 0.6, error


def test_errors_cover_an_independent_integration():
    rng = np.random.default_rng(8)
    a, w = 0.2, 1.1
    model, z = duffing(a, w), rng.normal(0, 0.8, (2, 40))
    found = fa.integrate(model, z, time=30.0)
    exact = np.array(
        [
            solve_ivp(
                lambda t, y: [y[1], y[0] - y[0] ** 3 + a * np.cos(w * t)],
                (0, 30),
                s,
                "DOP853",
                rtol=2.3e-14,
                atol=1e-15,
            ).y[:, -1]
            for s in z.T
        ]
    ).T
    ratio = np.abs(found.z[[0, 2]] - exact) / (found.error[[0, 2]] + 2e-12)
    assert (ratio <= 1).mean() >= 0.97
    assert ratio.max() < 10
    assert (found.status == fa.Status.OK).all()


@pytest.mark.parametrize("periods", [10**4, pytest.param(10**6, marks=pytest.mark.slow)])
@pytest.mark.parametrize("scheme", [fa.BLANES_MOAN6, fa.SOFRONIOU_SPALETTA10], ids=lambda s: s.name)
def test_the_phase_loses_no_digits_in_many_periods(periods, scheme):
    found = fa.integrate(mathieu(1.3, 0.2), [0.3, 0.1, 0.1, 0.0], time=periods * np.pi, step=np.pi / 24, scheme=scheme)
    # Some rounding errors of the whole time, at which cos(2t) would be evaluated.
    assert abs(found.z[1, 0] - 0.1) < 8e-16 * periods * np.pi


def test_stroboscopic_section_is_at_exact_multiples_of_the_period():
    model = pendulum()
    z = np.array([[0.3, 1.0, -0.4], [0.5, 0.1, 1.2]])
    found = fa.poincare_map(model, z, section="t=0", crossings=50)
    assert found.section == Stroboscopic(0.0)
    assert np.array_equal(found.times, np.outer(np.arange(1, 51), np.full(3, model.period)))
    assert (found.counts == 50).all()
    assert found.section_error.max() < 50 * 1e-15 * model.period
    assert (found["t"] == 0).all()
    samples = fa.integrate(model, z, time=50 * model.period, samples=50)
    apart = np.abs(samples.samples.transpose(1, 0, 2) - found.points)[[0, 2]]
    assert (apart <= found.point_error[[0, 2]] + samples.sample_error.transpose(1, 0, 2)[[0, 2]]).all()


def test_stroboscopic_section_at_any_phase_from_any_phase():
    model, rng = duffing(), np.random.default_rng(2)
    z = np.array([rng.normal(size=6), rng.uniform(0, model.period, 6), rng.normal(size=6) * 0.3, rng.normal(size=6)])
    z[1, 0] = 1.7
    found = fa.poincare_map(model, z, section=Stroboscopic(1.7), crossings=3)
    lead = (1.7 - z[1]) % model.period
    lead[0] = model.period  # a start on the section is no crossing
    assert np.allclose(found.times[0], lead, rtol=1e-14)
    assert np.allclose(np.diff(found.times, axis=0), model.period, rtol=1e-14)
    assert np.abs(found["t"] - 1.7).max() < 1e-13
    for k in range(6):
        exact = fa.integrate(model, z[:, k], time=float(found.times[2, k]), accuracy=2e-11)
        assert (np.abs(exact.z[[0, 2, 3], 0] - found.points[[0, 2, 3], 2, k]) < 1e-9).all()
    for k in (0, 3):
        alone = fa.poincare_map(model, z[:, [k]], section=Stroboscopic(1.7), crossings=3)
        assert np.array_equal(alone.points[..., 0], found.points[..., k])
    step, scheme = np.linspace(0.048, 0.13, 6)[::-1], fa.SOFRONIOU_SPALETTA10
    given = fa.poincare_map(model, z, section=Stroboscopic(1.7), crossings=3, step=step, scheme=scheme)
    for k in range(6):
        cut = {"section": Stroboscopic(1.7), "crossings": 3, "step": step[[k]], "scheme": scheme}
        alone = fa.poincare_map(model, z[:, [k]], **cut)
        assert np.array_equal(alone.points[..., 0], given.points[..., k])
    adaptive = fa.poincare_map(model, z, section="t=1.7", crossings=3, scheme=fa.DOP853)
    assert np.nanmax(np.abs(adaptive.points - found.points)[[0, 2]]) < 1e-9


def test_a_phase_is_a_part_of_the_period():
    """The section at a phase is the section at phase 0, integrated for the time of the phase."""
    model = pendulum(a=0.2)
    z = np.array([[0.1, -0.4, 2.0], [1.0, 0.3, 0.1]])
    strobes = [fa.poincare_map(model, z, section=f"t={phase}", crossings=4) for phase in ("0", "0.3*period")]
    assert np.allclose(strobes[1].times - strobes[0].times + model.period, 0.3 * model.period, rtol=0, atol=1e-12)
    for k in range(3):
        later = fa.integrate(model, strobes[0].points[[0, 2], k], time=0.3 * model.period, accuracy=1e-12)
        error = np.abs(later.z[[0, 2]] - strobes[1].points[[0, 2], k + 1]).max()
        assert error < 1e-8
    with pytest.raises(ValueError, match="got 'periods/4': unknown name 'periods'"):
        fa.poincare_map(model, z, section="t=periods/4", crossings=4)


def test_other_sections_are_found_by_roots():
    found = fa.poincare_map(pendulum(), [0.0, 0.8], section="x=0", crossings=10, max_time=200.0)
    assert np.abs(found["x"]).max() < 1e-14
    assert (np.diff(found.times[:, 0]) > 0).all()
    assert (found["p_x"] > 0).all()


def test_nothing_depends_on_units():
    length, duration, mass = 1e-5, 3e4, 7e2
    action = mass * length**2 / duration
    energy = action / duration
    own = duffing(0.25, 1.1)
    scaled = duffing(
        a=0.25 * energy / length,
        w=1.1 / duration,
        k=-mass / duration**2,
        c=mass / duration**2 / length**2,
        mass=mass,
    )
    rng = np.random.default_rng(4)
    z = rng.normal(0, 0.7, (2, 16))
    units = np.array([length, duration, action / length, energy])[:, None]
    one = fa.integrate(own, z, time=20.0)
    other = fa.integrate(scaled, z * units[[0, 2]], time=20.0 * duration)
    # Rounding may decide between neighbours on the ladder, or whether an error is a little too large.
    ratio = other.step / duration / one.step
    assert np.isclose(ratio, 1.0, rtol=1e-6).sum() >= 15
    assert (np.abs(np.log2(ratio)) < 0.6).all()
    assert (np.abs(other.z / units - one.z) <= 2 * (one.error + other.error / units)).all()
    rough, coarse = (
        fa.integrate(model, states, time=20.0 * past, accuracy=1e-8).step / past
        for model, states, past in ((own, z, 1.0), (scaled, z * units[[0, 2]], duration))
    )
    assert (np.abs(np.log2(coarse / rough)) < 0.3).all()
    z = np.array([np.linspace(0.8, 4.5, 12), np.zeros(12)])
    first = fa.chaos_map(own, z, time=300.0, indicators="megno,spectrum")
    second = fa.chaos_map(scaled, z * units[[0, 2]], time=300.0 * duration, indicators="megno,spectrum")
    assert np.array_equal(first.classification, second.classification)
    regular = first.regular
    assert regular.sum() >= 2
    assert np.allclose(first.megno[regular], second.megno[regular], rtol=1e-3)
    per_period = [entry.spectrum_per_period[:, regular] for entry in (first, second)]
    assert np.allclose(*per_period, rtol=0.02)
    assert np.allclose(per_period[0], first.spectrum[:, regular] * own.period, rtol=1e-14)


def test_exponents_of_an_unstable_mathieu_zone_and_escape():
    model = mathieu(1.0, 0.3)
    matrix = monodromy(model)
    exact = np.arccosh(abs(np.trace(matrix)) / 2) / np.pi
    early, found = (
        fa.chaos_map(model, [0.1, 0.1], time=turns * np.pi, indicators="spectrum,lyapunov") for turns in (20, 28)
    )
    # Beyond a constant, which the first turns and the metric leave, the growth is that of Floquet's theory.
    growth = [entry.spectrum_per_period[0, 0] * turns for entry, turns in ((early, 20), (found, 28))]
    assert abs((growth[1] - growth[0]) / 8 - exact * np.pi) < 1e-3
    assert np.allclose(found.spectrum.sum(axis=0), 0)
    assert np.allclose(found.spectrum_per_period, found.spectrum * np.pi)
    gone = fa.chaos_map(model, [0.1, 0.1], time=3000.0)
    assert gone.status[0] == fa.Status.ESCAPED
    few = fa.poincare_map(model, [[0.1, 0.0], [0.1, 0.0]], section="t=0", crossings=400)
    assert few.status[0] == fa.Status.ESCAPED
    assert 10 < few.counts[0] < 400
    assert few.status[1] == fa.Status.OK
    assert (few.points[[0, 2], :, 1] == 0).all()


def test_classifications():
    stable = fa.chaos_map(mathieu(1.3, 0.2), np.random.default_rng(1).normal(size=(2, 20)), time=1000.0)
    assert (stable.classification == 0).all()
    rows = np.array([*np.linspace(0.1, 1.6, 16), 1.95, 2.0, 2.05])
    found = fa.chaos_map(pendulum(), np.array([0 * rows, rows]), time=2000.0, indicators="megno,sali,gali_2,spectrum")
    assert found.regular[:16].all()
    assert found.chaotic[16:].all()
    # Every indicator that decides says the same.
    decided = found.classifications != 2
    assert (found.classifications == found.classification)[decided & (found.classification != 2)].all()
    assert found.spectrum.shape == (2, 19)


def test_long_chaos_has_no_vector_that_overflows():
    found = fa.chaos_map(duffing(0.1, 1.2), [1.15, 0.05], time=12000.0)
    assert found.status[0] == fa.Status.OK
    assert found.chaotic[0]
    assert found.sali[0] < -700  # two vectors that have grown beyond the largest number


def test_tangent_map_is_symplectic_and_knows_the_time():
    model, z0 = two_waves(), np.array([0.4, -0.3, 0.7, 0.1, 0.5, 0.2])
    found = fa.tangent_map(model, z0, time=5.0)
    M, n = found.matrix[..., 0], 3
    omega = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    assert np.abs(M.T @ omega @ M - omega).max() < 1e-12
    assert np.array_equal(M[2], np.eye(6)[2])  # no vector changes its time
    step = 1e-5
    shifts = np.eye(6) * step
    ends = [fa.integrate(model, z0[:, None] + s * shifts, time=5.0, step=0.02).z for s in (1, -1)]
    numeric = (ends[0] - ends[1]) / (2 * step)
    assert np.abs(numeric - M).max() < 1e-7


def test_resonances_with_the_drive():
    model = pendulum(0.02, 1.5)
    # In the island of the wave, whose orbits turn with it.
    found = fa.frequency_map(model, np.array([[0.0], [1.5 + 0.05]]), time=4000.0)
    assert found.names == ("x", "t")
    assert fa.resonances(found).names == ("x", "t")
    assert found.nu[1, 0] == 1 / model.period


def test_periodic_orbits_of_the_stroboscopic_map():
    model, a, w = duffing(), 0.3, 1.2
    found = fa.periodic_orbits(model, [[0.1, -0.2, 2.0], [0.0, 0.0, 0.0]], section="t=0")
    assert (found.status == fa.Status.OK).all()
    assert np.allclose(found.period, model.period, rtol=1e-15)
    assert np.abs(found.z[1]).max() < 1e-15
    for k in range(3):
        own = found.z[[0, 2], k]
        end = solve_ivp(
            lambda t, y: [y[1], y[0] - y[0] ** 3 + a * np.cos(w * t)],
            (0, model.period),
            own,
            "DOP853",
            rtol=2.3e-14,
            atol=1e-15,
        ).y[:, -1]
        assert np.abs(end - own).max() < 1e-12
        step = 1e-5
        ends = [
            fa.poincare_map(
                model, own[:, None] + s * step * np.eye(2), section="t=0", crossings=1, accuracy=1e-13, scheme=BCE8
            )
            for s in (1, -1)
        ]
        matrix = (ends[0].points - ends[1].points)[[0, 2], 0] / (2 * step)
        assert abs((2 - np.trace(matrix)) / 4 - found.residue[k]) < 1e-5 * max(1, abs(found.residue[k]))


def test_all_periodic_orbits_of_a_bounded_map_have_the_index_of_the_plane():
    model = duffing()
    grid = np.array(np.meshgrid(np.linspace(-2, 2.2, 7), np.linspace(-1.5, 1.5, 7))).reshape(2, -1)
    found = fa.find_periodic_orbits(model, grid, section="t=0", max_crossings=2)
    first = found.crossings == 1
    # Infinity is a centre: fixed points with R > 0 are one more than those with R < 0.
    assert (found.residue[first] > 0).sum() - (found.residue[first] < 0).sum() == 1
    assert (found.minimal_crossings == found.crossings).all()
    # x -> -x half a period later is a symmetry: orbits that are not their own image come in pairs.
    again = fa.periodic_orbits(model, found.z[:, ~first], section="t=0", crossings=2)
    assert np.allclose(again.z[[0, 2]], found.z[[0, 2]][:, ~first], atol=1e-9)


def test_doubling_of_a_fixed_point_at_rest_is_where_mathieus_equation_has_it():
    w = 1.7

    def make(a):
        return fa.hamiltonian("-(1 + a*cos(w*t))*cos(x)", coordinates="x", drive_period="2*pi/w", a=a, w=w)

    branch = fa.continuation(make, [0.0, 0.0], section="t=0", parameter=0.55, bounds=(0.5, 0.62), ds_max=0.5)
    exact = brentq(lambda a: mathieu_a(1, 2 * a / w**2) - 4 / w**2, 0.5, 0.7, xtol=1e-15)
    assert [event.event.name for event in branch.bifurcations] == ["PERIOD_DOUBLING"]
    assert abs(branch.bifurcations[0].parameter - exact) < 1e-8
    assert abs(branch.bifurcations[0].parameter - exact) < 10 * branch.bifurcations[0].error + 1e-11
    assert np.abs(branch.orbits.z[[0, 2]]).max() < 1e-12


def test_a_family_in_the_frequency_of_its_drive():
    def make(w):
        return duffing(0.1, w)

    branch = fa.continuation(make, [1.0, 0.0], section="t=0", parameter=1.9, bounds=(1.8, 2.0), max_steps=8)
    assert np.allclose(branch.orbits.period, 2 * np.pi / branch.parameter, rtol=1e-12)
    alone = fa.periodic_orbits(make(float(branch.parameter[-1])), branch.orbits.z[:, -1], section="t=0")
    assert np.allclose(alone.z[[0, 2], 0], branch.orbits.z[[0, 2], -1], atol=1e-11)


def test_given_tangent_vectors_are_those_of_coordinates_and_momenta():
    model, z0 = duffing(), np.array([[0.1, 1.6], [0.2, 0.0]])
    given = fa.chaos_map(model, z0, time=200.0, indicators="spectrum", deviation_vectors=np.eye(2))
    other = fa.chaos_map(model, z0, time=200.0, indicators="spectrum")
    assert given.spectrum.shape == (2, 2)
    assert np.allclose(given.spectrum.sum(axis=0), 0, atol=1e-12)
    assert np.allclose(given.spectrum[0], other.spectrum[0], atol=0.06)
    with pytest.raises(ValueError, match="deviation_vectors must have shape"):
        fa.chaos_map(model, z0, time=200.0, deviation_vectors=np.eye(4))


def test_a_job_from_options(tmp_path):
    """As the commands have it: --hamiltonian, --drive-period, --file with rows x and p_x."""
    z0 = np.array([np.zeros(5), np.linspace(0.2, 1.4, 5)])
    np.save(tmp_path / "z0.npy", z0)
    options = Model(
        hamiltonian="-cos(x) - a*cos(x - w*t)", coordinates="x", drive_period="2*pi/w", parameter=["a=0.05", "w=1.5"]
    )
    assert options.build() == pendulum()
    assert described(system_of(pendulum())).build() == pendulum()
    number = fa.hamiltonian("x**2/2*(1 + a*cos(t))", coordinates="x", drive_period=2 * np.pi, a=0.1)
    assert described(system_of(number)).build() == number
    job = Job(
        model=options,
        energy_surface=EnergySurface(section="t=0"),
        initial_conditions=InitialConditions(file=str(tmp_path / "z0.npy")),
        poincare=PoincareOptions(crossings=20),
        frequency_map=FrequencyOptions(returns=100.0),
    )
    done = fa.run(job)
    section = fa.poincare_map(pendulum(), z0, section="t=0", crossings=20)
    assert np.array_equal(done["poincare"].points, section.points)
    assert done["frequency_map"].time == pytest.approx(100 * pendulum().period)
    with pytest.raises(ValueError, match="period belongs to hamiltonian"):
        Model(formula="alpha**2", drive_period="2*pi").build()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: fa.hamiltonian("x**2*cos(t)", coordinates="x"),
            "text: unknown name 't' at column 10. Use drive_period, such as",
        ),
        (lambda: fa.affine_body("alpha**2*cos(t)"), "text: unknown name 't' at column 14. For friction or a drive"),
        (
            lambda: fa.hamiltonian("x**2*cos(t)", coordinates="x", drive_period=6.0),
            "drive_period must be a period of the potential, got 6.0: a value of V changes from",
        ),
        (
            lambda: fa.hamiltonian("x**2*cos(w*t)", coordinates="x", drive_period="pi/w", w=1.3),
            "drive_period must be a period of the potential, got ",
        ),
        (
            lambda: fa.hamiltonian("x**2", coordinates="x", drive_period=6.0),
            "drive_period must be left out for a formula without the time t,",
        ),
        (
            lambda: fa.hamiltonian("x**2*t", coordinates="x", drive_period=1.0),
            "drive_period must be a period of the potential, got 1.0: a value of V changes from",
        ),
        (lambda: fa.hamiltonian("x**2*cos(t)", coordinates="x", drive_period=-1.0), "drive_period must be positive"),
        (
            lambda: fa.hamiltonian("x**2*cos(w*t)", coordinates="x", drive_period="-2*pi/w", w=1.0),
            "drive_period must be positive",
        ),
        (lambda: fa.hamiltonian("x**2*cos(t)", coordinates="x", drive_period="2*pi/v"), "unknown name 'v'"),
        (
            lambda: fa.hamiltonian("x**2*cos(t)", coordinates="x t", drive_period=1.0),
            "coordinates must not contain t, the time of a driven system",
        ),
        (lambda: fa.hamiltonian("x*cos(t)", coordinates="x", drive_period="2*pi", t=1.0), "taken"),
        (lambda: fa.poincare_map(duffing(), [0, 1], section="t=0", crossings=3, max_time=9.0), "max_time"),
        (
            lambda: fa.poincare_map(duffing(), [0, 1], section="x=0", crossings=3),
            "max_time is required for the section x=0. The typical period is",
        ),
        (
            lambda: fa.poincare_map(fa.HenonHeiles(), [0, 0.1, 0.3, 0], section=Stroboscopic(), crossings=3),
            "section must be x=c, y=c for a system without a drive, got",
        ),
        (
            lambda: fa.poincare_map(duffing(), [0, 1], section=fa.Hyperplane((0, 1, 0, 0)), crossings=3, max_time=1.0),
            "section must be one of constant time, such as 't=0', or not",
        ),
        (lambda: fa.poincare_map(duffing(), [0, 1], section="y=0", crossings=3), "section"),
        (lambda: fa.chaos_map(duffing(), [0, 1], time=9.0, indicators="reversibility_error"), "driven"),
        (lambda: fa.chaos_map(duffing(), [0, 1], time=9.0, indicators="ofli"), "driven"),
        (lambda: fa.chaos_map(duffing(), [0, 1], time=9.0, indicators="gali_3"), "GALI.count"),
        (lambda: fa.integrate(duffing(), [0, 1, 2], time=9.0), "z0 must have shape"),
        (
            lambda: fa.integrate(duffing(), [0, 1], time=9.0, scheme=fa.TimeTransformed()),
            "scheme TimeTransformed(KAHAN_LI8) is not supported for driven",
        ),
        (
            lambda: fa.periodic_orbits(duffing(), [0, 1], section="x=0"),
            "section must be a stroboscopic one for a driven system, such as",
        ),
        (
            lambda: fa.periodic_orbits(duffing(), [0, 1], section="t=0", energy=1.0),
            "energy is not supported for driven systems, which do not",
        ),
        (
            lambda: fa.periodic_orbits(duffing(), [0, 1], section="t=0", max_time=1.0),
            "max_time is not supported for driven systems, got 1.0.",
        ),
        (
            lambda: fa.continuation(duffing(), [0, 1], section="t=0"),
            "parameter must be a number for a driven system, which has no",
        ),
        (
            lambda: fa.hamiltonian("x*cos(t)", coordinates="x y", drive_period="2*pi", rotation=1.0),
            "drive_period must be given without rotation: a driven system",
        ),
        (lambda: fa.explore(duffing(), energy=1.0), "energy is not supported for driven systems: the page plots the"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises((ValueError, TypeError), match=None) as caught:
        call()
    assert message in str(caught.value), str(caught.value)


def test_a_parameter_or_coordinate_may_be_named_t():
    assert not system_of(fa.hamiltonian("x**2/2*t", coordinates="x", t=2.0)).terms
    assert not system_of(fa.hamiltonian("x**2/2 + t**4", coordinates="x t")).terms


def test_a_model_is_a_value():
    model = fa.hamiltonian("x**2/2*(1 + a*cos(t))", coordinates="x", drive_period=2 * np.pi, a=0.1)
    assert model.period == 2 * np.pi
    assert pickle.loads(pickle.dumps(model)) == model
    assert pickle.loads(pickle.dumps(duffing())) == duffing()
    assert duffing(w=2.0).period == np.pi
    assert "drive_period='2*pi/w'" in repr(duffing())
    found = fa.poincare_map(model, [0.1, 0.2], section="t=0", crossings=2)
    assert dataclasses.replace(found).names == ("x", "t", "p_x", "p_t")


def test_a_model_of_ones_own_must_have_its_time():
    own = fa.integrate(Driven(0.05), [0.1, 0.2], time=20.0)
    written = fa.integrate(pendulum(0.05, 1.0), [0.1, 0.2], time=20.0)
    assert (np.abs(own.z - written.z) <= own.error + written.error).all()
    for wrong, message in ((Stopped(0.3), "velocity is 1"), (NoPhase(0.3), "phase")):
        with pytest.raises((ValueError, TypeError), match=message):
            fa.integrate(wrong, [0.1, 0.2], time=2.0)
