"""Husimi functions: closed forms of oscillators, plain quadrature in R^4, the norm over phase space, classical tori."""

import math

import numpy as np
import pytest

import fastaff
from fastaff import AlphaTurning, Anharmonic, Body, Harmonic, Hyperelastic, energy_grid
from fastaff.quantum import husimi, spectrum, wavefunction
from fastaff.quantum.chaos import husimi as module


def plane_share(body, hbar, n, M, q, p):
    """|<z|n, M>|^2 of one plane of the oscillator: two Poisson laws of the classical actions (H/omega +- L)/2."""
    omega = np.sqrt(body.potential.C / body.mu)
    energy = (np.sum(p**2, axis=0) / (2 * body.mu) + body.potential.C * np.sum(q**2, axis=0) / 2) / (hbar * omega)
    momentum = (q[0] * p[1] - q[1] * p[0]) / hbar
    plus, minus = (energy + momentum) / 2, (energy - momentum) / 2
    quanta = (n + M, n) if M >= 0 else (n, n - M)
    return (
        np.exp(-energy)
        * plus ** quanta[0]
        * minus ** quanta[1]
        / (math.factorial(quanta[0]) * math.factorial(quanta[1]))
    )


@pytest.mark.parametrize(("m", "l", "n"), [(0, 0, (0, 0)), (2, 0, (1, 2)), (-3, 1, (4, 0)), (1, -5, (2, 3))])
def test_oscillator_in_closed_form(m, l, n):
    body, hbar = Body(Harmonic(1.4), 1.3), 0.35
    width = (hbar / (2 * np.sqrt(1.4 * 1.3))) ** 0.5
    Q = husimi(wavefunction(body, m=m, l=l, n=n, hbar=hbar), width=width)
    z = np.random.default_rng(1).normal(size=(8, 5, 4))
    truth = plane_share(body, hbar, n[0], (m - l) // 2, z[0:2], z[4:6]) * plane_share(
        body, hbar, n[1], (m + l) // 2, z[2:4], z[6:8]
    )
    np.testing.assert_allclose(Q(z), truth, rtol=1e-9, atol=1e-13)
    assert Q(z[:, 0, 0]) == pytest.approx(truth[0, 0], rel=1e-9)
    assert Q.norm == pytest.approx(1, abs=1e-12)


def by_quadrature(state, z, width, order=24):
    """|<z|Psi>|^2 by Gauss-Hermite quadrature of Psi times the coherent state in the four planes' coordinates."""
    x, w = np.polynomial.hermite.hermgauss(order)
    sigma = math.sqrt(2) * np.repeat(width, 2)
    points = np.array(np.meshgrid(*(z[i] + math.sqrt(2) * sigma[i] * x for i in range(4)), indexing="ij")).reshape(
        4, -1
    )
    weights = np.einsum("i,j,k,l->ijkl", w, w, w, w).ravel()
    wave = np.exp(-1j / state.hbar * (z[4:, None] * points).sum(axis=0))
    front = np.prod(np.sqrt(2) * sigma / (np.pi * sigma**2) ** 0.25)
    return abs(front * np.sum(weights * wave * state.planes(points))) ** 2


def test_against_quadrature_in_four_dimensions():
    state = wavefunction(Body(Anharmonic(1.4), 1.3), m=3, l=-1, n=(2, 1), hbar=0.8)
    Q = husimi(state, width=(0.5, 0.63))
    for z in np.random.default_rng(2).normal(size=(2, 8)) * 0.7 + np.array([1.2, 0, 0.4, 0.3, 0, 0.5, 0, 0]):
        assert Q(z) == pytest.approx(by_quadrature(state, z, (0.5, 0.63)), rel=2e-3)


def test_solved_states_against_quadrature():
    """A state found numerically, small at the wall det phi = 0 (Psi has a kink there, which the quadrature feels)."""
    state = spectrum(Body(Hyperelastic(6.0)), m=2, l=0, count=3, hbar=0.6).state(2)
    Q = husimi(state, width=0.28, tolerance=1e-5)
    z = np.array([2.0, 0.1, 0.5, 0.2, 0.1, 0.4, -0.3, 0.6])
    assert Q(z) == pytest.approx(by_quadrature(state, z, (0.28, 0.28)), rel=2e-2)
    turned = z * np.array(
        [1, -1, 1, -1, -1, 1, -1, 1]
    )  # both reflected and reversed in time: eta, gamma, p_alpha, p_beta -> -
    assert Q(turned) == pytest.approx(Q(z), rel=1e-12)


@pytest.mark.parametrize("width", [0.4, (0.35, 0.5)])
def test_width_is_that_of_coherent_packets(width):
    """|<z|Psi>|^2 is the weight of Psi in the coherent state at z, of the same width."""
    body, z = Body(Harmonic(1.1), 0.9), np.array([1.2, 0.1, 0.4, 0.3, 0.1, 0.3, 0.2, 0.1])
    packet = fastaff.quantum.coherent_packet(body, z, width=width, count=40, hbar=0.5, missing=1e-3)
    for k in np.argsort(-packet.weights)[:5]:
        assert husimi(packet.states[k], width=width, tolerance=1e-8)(z) == pytest.approx(packet.weights[k], rel=1e-3)


def test_norm_over_phase_space():
    """Of a product state Q is a product too: the integral over one plane at a fixed point of the other, times the other
    way round.
    """
    hbar, width = 0.5, (0.42, 0.57)
    Q = husimi(wavefunction(Body(Harmonic(1.4), 1.3), m=2, l=0, n=(1, 2), hbar=hbar), width=width)
    t, w = np.polynomial.laguerre.laggauss(24)
    angle = 2 * np.pi * np.arange(24) / 24
    plus, minus, phase = np.meshgrid(np.sqrt(t), np.sqrt(t), np.exp(1j * angle), indexing="ij")
    weights = np.repeat(np.outer(w * np.exp(t), w * np.exp(t))[:, :, None], 24, axis=2) / 24  # d^2z+ d^2z-/pi^2
    z_plus, z_minus = plus * phase, minus + 0j
    first, second = (z_plus + z_minus) / np.sqrt(2), 1j * (z_plus - z_minus) / np.sqrt(2)

    def plane(side):
        rows = [2 * side * first.real, 2 * side * second.real]
        return [*rows, hbar / side * first.imag, hbar / side * second.imag]

    fixed = np.array([0.9, 0.1, 0.7, -0.3, 0.2, 0.5, -0.1, 0.4])
    total = 1.0
    for rows, side in (((0, 1, 4, 5), width[0]), ((2, 3, 6, 7), width[1])):
        z = np.broadcast_to(fixed[:, None, None, None], (8, *first.shape)).copy()
        z[list(rows)] = plane(side)
        total *= np.sum(weights * Q(z))
    assert total / Q(fixed) == pytest.approx(Q.norm, abs=1e-9)
    assert Q.norm == pytest.approx(1, abs=1e-6)


@pytest.mark.slow
def test_states_lie_on_their_tori():
    """Same actions I = hbar (n + 1/2) and angular momenta at hbar and hbar/3: the section curve gets narrower as
    sqrt(hbar).
    """
    body, spread = Body(Anharmonic(1.0)), []
    for k in (1, 3):
        hbar, n = 0.1 / k, ((11 * k - 1) // 2, (9 * k - 1) // 2)
        state = wavefunction(body, m=6 * k, l=-2 * k, n=n, hbar=hbar)  # p_eta = 0.4, p_gamma = 0.2
        E = state.energy
        grid = energy_grid(
            body,
            energy=E,
            section=AlphaTurning(1),
            axes=(np.linspace(0.02, 2.5, 120), np.linspace(-2.2, 2.2, 121)),
            p_eta=0.4,
            p_gamma=0.2,
        )
        values = husimi(state)(grid.z0)
        beta, p_beta = grid.z0[2], grid.z0[6]
        H_beta = p_beta**2 / 2 + 0.2**2 / (2 * beta**2) + beta**2 / 2
        mean = np.sum(values * H_beta) / np.sum(values)
        spread.append(np.sqrt(np.sum(values * (H_beta - state.constants["E_beta"]) ** 2) / np.sum(values)))
        assert abs(mean - state.constants["E_beta"]) < 0.8 * hbar
        assert np.sum(grid.to_grid(values)[:, ::-1] - grid.to_grid(values)) == pytest.approx(
            0, abs=1e-9
        )  # p_beta -> -p_beta
    assert spread[1] / spread[0] == pytest.approx(3**-0.5, abs=0.06)


def test_what_has_no_husimi_function(monkeypatch):
    body = Body(Harmonic())
    with pytest.raises(ValueError, match="even"):
        husimi(wavefunction(body, m=1, l=0, n=(0, 0), single_valued=False))
    state = wavefunction(body, m=0, l=0, n=(0, 0))
    with pytest.raises(ValueError, match="shape"):
        husimi(state)(np.zeros((4, 3)))
    monkeypatch.setattr(module, "LARGEST", 40)
    with pytest.raises(
        ValueError, match=r"must fit in 40 radial quanta of width = \(0.02, 0.02\), got 0.\d+ of its norm outside"
    ):
        husimi(state, width=0.02)


def test_figures_of_husimi_functions_and_spacings():
    from matplotlib.figure import Figure

    from fastaff.plot.quantum_chaos import plot_husimi, plot_spacings

    body = Body(Anharmonic(1.0))
    state = wavefunction(body, m=3, l=-1, n=(2, 3), hbar=0.2)
    surface = {"energy": state.energy, "section": AlphaTurning(1), "p_eta": 0.4, "p_gamma": 0.2}
    grid = energy_grid(body, axes=(np.linspace(0.1, 2, 20), np.linspace(-2, 2, 21)), **surface)
    starts = fastaff.energy_sample(body, orbits=20, **surface).z0.reshape(8, 5, 4)
    fine = np.zeros(4)
    crossings = fastaff.sections.SectionMap(
        starts, np.ones((5, 4)), fine + 5, fine, fine, fine, AlphaTurning(1), fastaff.KAHAN_LI8, 0.1, ()
    )
    left, right = Figure().subplots(1, 2)
    drawn = plot_husimi(grid, husimi(state)(grid.z0), ax=left, section_map=crossings, colorbar=True)
    assert drawn.lines[0].get_offsets().shape == (20, 2)
    assert left.get_xlabel() == r"$\beta$"
    with pytest.raises(ValueError, match="values"):
        plot_husimi(grid, [1.0], ax=left)
    drawn = plot_spacings([0.5, 1.0, 1.2, 9.0], {"Poisson": fastaff.quantum.BerryRobnik(0.0)}, ax=right, bins=7)
    assert drawn.missing == 1
    assert sum(bar.get_height() * bar.get_width() for bar in drawn.points) == pytest.approx(3 / 4)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"width": -1.0}, "width must be one or two positive"),
        ({"width": (1.0,) * 3}, "width must be one or two positive"),
        ({"tolerance": 2.0}, "tolerance must be below 1"),
    ],
)
def test_bad_options_are_named(options, words):
    with pytest.raises(ValueError, match=words):
        husimi(wavefunction(Body(Harmonic()), m=0, l=0, n=(0, 0)), **options)
