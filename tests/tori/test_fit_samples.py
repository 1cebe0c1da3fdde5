"""fit_samples: the torus of an orbit from its samples alone, against that of its equations and against known series."""

import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff import Classification
from fastaff.tori import fit_samples

HH = fa.HenonHeiles()


def test_a_torus_with_known_series():
    """Two rotations with amplitudes and a combination line, in units of their own; actions in closed form."""
    nu, t = np.array([0.1317, 0.0873]), 0.4 * np.arange(3000)
    phase = np.array([0.2, 0.7])
    theta = nu[:, None] * t + phase[:, None]
    a = np.array([1.3, 0.7])
    q, p = a[:, None] * np.cos(2 * np.pi * theta), -a[:, None] * np.sin(2 * np.pi * theta)
    shear = 0.2 * q[0] ** 2
    found = fit_samples(np.array([q[0], q[1], p[0] + shear, p[1]]), 0.4, coordinates="x y px py")
    assert found.classification is Classification.REGULAR
    order = [int(np.argmin(np.abs(found.nu - value))) for value in nu]
    np.testing.assert_allclose(found.nu[order], nu, rtol=1e-12)
    assert (np.abs(found.nu[order] - nu) <= found.nu_error[order]).all()
    np.testing.assert_allclose(found.J[order], np.pi * a**2, rtol=1e-9)
    np.testing.assert_allclose(found.theta0[order], phase, atol=1e-9)
    assert found.prediction_error < 1e-9
    assert np.isnan(found.residual)
    assert found.model is None
    assert found.truncated(1).order == 1


def test_the_torus_that_the_equations_have():
    body = shared_systems.plane(1, 2.3, c=0.1)
    z0 = np.array([0.3, 0.2, 0.0, 0.1])
    own = fa.fit_torus(body, z0, time=400.0)
    orbits = fa.integrate(body, z0, time=600.0, samples=4000, accuracy=1e-11)
    found = fit_samples(orbits)
    assert found.classification is own.classification is Classification.REGULAR
    order = [int(np.argmin(np.abs(found.nu - value))) for value in own.nu]
    assert (np.abs(found.nu[order] - own.nu) <= found.nu_error[order] + own.nu_error).all()
    np.testing.assert_allclose(found.J[order], own.J, rtol=1e-8)


def test_chaos_and_what_is_refused():
    chaotic = fa.integrate(HH, [0.0, -0.15, 0.5, 0.1], time=2000.0, samples=8000)
    found = fit_samples(chaotic)
    assert found.classification in (Classification.IRREGULAR, Classification.UNDECIDED)
    assert (found.nu_error == np.inf).all()
    wave = np.array([np.cos(0.3 * np.arange(500)), -np.sin(0.3 * np.arange(500))])
    with pytest.raises(ValueError, match=r"samples must be of one orbit, \(2n, samples\), got 2 orbits"):
        fit_samples(np.stack([wave, wave], axis=1), 1.0)
    with pytest.raises(ValueError, match="dt must be given"):
        fit_samples(wave)
    with pytest.raises(ValueError, match="samples must be of an orbit that moves"):
        fit_samples(0 * wave, 1.0)
    for gone in (np.nan, 0.0):
        wave[:, 400:] = gone
        with pytest.raises(ValueError, match=r"samples must be finite and move to the last one, got .* sample 400 on"):
            fit_samples(wave, 1.0)
    with pytest.raises(ValueError, match="at least 384 samples"):
        fit_samples(wave[:, :300], 1.0)
