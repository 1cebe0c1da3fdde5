"""Scans of parameters as jobs: each case a chunk, the whole a ChaoticFraction."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.jobs import ChaosOptions, EnergySurface, InitialConditions, Job, PoincareOptions, Scan

JOB = Job(
    model=fa.HenonHeiles(),
    energy_surface=EnergySurface(energy=0.1),
    initial_conditions=InitialConditions(orbits=24, seed=5),
    chaos_map=ChaosOptions(time=60.0),
    scan=Scan(axes=["energy=0.05:0.16:3", "lam=0.6:0.9:2"]),
)


def same(one, other):
    for name in ("orbits", "chaotic", "regular", "undecided", "medians", "thresholds", "time", "statuses", "done"):
        a, b = getattr(one, name), getattr(other, name)
        assert a.shape == b.shape
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name


@pytest.fixture(scope="module")
def whole():
    return fa.run(JOB)["chaotic_fraction"]


def test_a_scan_is_that_of_its_cases(whole):
    """Each case as `chaos_map` has it, from points of its own seed."""
    section, case = fa.Hyperplane((1.0, 0.0, 0.0, 0.0)), 3
    energy, lam = np.linspace(0.05, 0.16, 3)[1], np.linspace(0.6, 0.9, 2)[1]
    seed = np.random.SeedSequence(5, spawn_key=(case,))
    z0 = fa.energy_sample(fa.HenonHeiles(lam), energy=energy, section=section, orbits=24, seed=seed).z0
    found = fa.chaos_map(fa.HenonHeiles(lam), z0, time=60.0)
    assert whole.fraction.shape == (3, 2)
    assert whole.chaotic[1, 1] == np.count_nonzero(found.chaotic)
    assert np.array_equal(whole.medians[:, 1, 1], np.median(found.values, axis=1))


@pytest.mark.parametrize("chunk", [None, 4])
def test_a_scan_that_is_stopped_goes_on(whole, tmp_path, chunk):
    path = tmp_path / "scan.zarr"

    def stop(progress, chunk):
        raise KeyboardInterrupt

    from dataclasses import replace

    with pytest.raises(fa.Interrupted) as stopped:
        fa.run(replace(JOB, chunk=chunk), path, on_chunk=stop)
    part = stopped.value.partial["chaotic_fraction"]
    assert part.done.sum() == (chunk or 1)
    assert np.array_equal(part.medians[:, part.done], whole.medians[:, part.done])
    found = fa.resume(path)
    same(found["chaotic_fraction"], whole)
    assert found.counts() == {"chaotic_fraction": {"OK": int(whole.statuses[0].sum())}}
    with pytest.raises(ValueError, match="cases of a scan have their fallback scheme"):
        fa.rerun(path, status="OK", scheme="DOP853")


def test_text():
    assert Job.parsed(JOB.text()) == JOB


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"scan": Scan(axes=["enrgy=1:2:3"])}, "energy"),
        ({"scan": Scan(axes=[])}, "one or two"),
        ({"scan": Scan(axes=["energy=1:2:3"] * 2)}, "twice"),
        ({"scan": Scan(axes=["energy=1:2:1000000000"])}, "LOW:HIGH:N"),
        (
            {"scan": Scan(axes=["energy=0.05:0.1:3"]), "initial_conditions": InitialConditions(grid="3x3")},
            "random starts",
        ),
        ({"scan": Scan(axes=["energy=0.05:0.1:3"]), "poincare": PoincareOptions()}, "alone"),
    ],
)
def test_wrong_scans(wrong, said):
    given = {
        "model": fa.HenonHeiles(),
        "energy_surface": EnergySurface(energy=0.1),
        "chaos_map": ChaosOptions(time=1.0),
        **wrong,
    }
    with pytest.raises(ValueError, match=said):
        fa.run(Job(**given))
