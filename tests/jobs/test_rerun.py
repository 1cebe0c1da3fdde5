"""Orbits of a store that failed are run again another way, whatever stops it."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.jobs import EnergySurface, FrequencyOptions, InitialConditions, Job, PoincareOptions, RunOptions, Store
from fastaff.results.result import columns

JOB = Job(
    model=fa.HenonHeiles(),
    energy_surface=EnergySurface(energy=0.16),
    initial_conditions=InitialConditions(grid="12x12"),
    options=RunOptions(step=0.7, scheme="LEAPFROG"),  # much too long: energies drift
    poincare=PoincareOptions(crossings=4, max_time=60.0),
    frequency_map=FrequencyOptions(time=40.0),
    chunk=16,
)


def arrays(results):
    return {f"{name} {entry.name}": entry.value for name in results for entry in columns(results[name])}


def assert_same(one, other):
    one, other = arrays(one), arrays(other)
    assert one.keys() == other.keys()
    for name, value in one.items():
        assert np.array_equal(value, other[name], equal_nan=value.dtype.kind == "f"), name


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    path = tmp_path_factory.mktemp("rerun") / "whole.zarr"
    return fa.run(JOB, path), path


def copied(path, to):
    import shutil

    return shutil.copytree(path, to / "copy.zarr")


def test_failed_orbits_get_the_numbers_of_the_other_scheme(begun, tmp_path):
    before, path = begun
    path = copied(path, tmp_path)
    drifted = before["poincare"].status == fa.Status.ENERGY_DRIFT
    assert drifted.sum() > 0
    after = fa.rerun(path, status="energy_drift", scheme="DOP853", analyses="poincare")
    z0 = Store(path).root["launch/z0"][:][:, after.place][:, drifted]
    section = fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
    asked = {"section": section, "crossings": 4, "max_time": 60.0, "scheme": fa.DOP853, "step": 0.7}
    alone = fa.poincare_map(fa.HenonHeiles(), z0, **asked)
    found = after["poincare"].take(drifted)
    assert np.array_equal(found.points, alone.points, equal_nan=True)
    assert np.array_equal(found.status, alone.status)
    assert np.array_equal(after.attempts("poincare"), drifted)
    assert not after.attempts("frequency_map").any()
    kept = after["poincare"].take(~drifted)
    assert np.array_equal(kept.points, before["poincare"].take(~drifted).points, equal_nan=True)
    assert "DOP853" in after.table()
    assert_same(fa.resume(path), after)


@pytest.mark.parametrize("fatal", [0, 1, 3, 7, 12])
def test_a_rerun_that_is_stopped_goes_on(begun, tmp_path, monkeypatch, fatal):
    path = copied(begun[1], tmp_path)
    whole = fa.rerun(copied(begun[1], tmp_path / "other"), status="ENERGY_DRIFT", scheme="DOP853")
    put, left = Store._put, [fatal]

    def failing(*given):
        left[0] -= 1
        if left[0] < 0:
            raise OSError("no space left on device")
        return put(*given)

    monkeypatch.setattr(Store, "_put", failing)
    with pytest.raises(OSError, match="no space"):
        fa.rerun(path, status="ENERGY_DRIFT", scheme="DOP853")
    monkeypatch.undo()
    assert_same(fa.resume(path), whole)


def test_orbits_to_come_are_run_again_too(begun, tmp_path):
    path = tmp_path / "part.zarr"

    def stop(progress, chunk):
        if progress.orbits > 60:
            raise KeyboardInterrupt

    with pytest.raises(fa.Interrupted) as stopped:
        fa.run(JOB, path, on_chunk=stop)
    assert not stopped.value.partial.complete
    after = fa.rerun(path, status=[fa.Status.ENERGY_DRIFT], scheme="DOP853")
    assert after.complete
    assert_same(after, fa.rerun(copied(begun[1], tmp_path), status=[4], scheme="DOP853"))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"status": "ENERGY_DRIFTS", "scheme": "DOP853"}, "ENERGY_DRIFT"),
        ({"status": 99, "scheme": "DOP853"}, "status"),
        ({"status": [], "scheme": "DOP853"}, "status"),
        ({"status": "ENERGY_DRIFT"}, "scheme, step or accuracy"),
        ({"status": "ENERGY_DRIFT", "scheme": "DOPE"}, "DOPE"),
        ({"status": "ENERGY_DRIFT", "step": -1.0}, "step"),
        ({"status": "ENERGY_DRIFT", "scheme": "DOP853", "analyses": "chaos_map"}, "analyses"),
    ],
)
def test_what_does_not_fit_changes_nothing(begun, given, said):
    before = (begun[1] / "zarr.json").read_bytes()
    with pytest.raises(ValueError, match=said):
        fa.rerun(begun[1], **given)
    assert (begun[1] / "zarr.json").read_bytes() == before


def test_progress_is_one_line(tmp_path, capsys):
    fa.run(JOB, tmp_path / "s.zarr", on_chunk=lambda progress, chunk: print(progress))
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 9
    assert lines[-1].startswith("144 of 144 points (100%); ")
    assert "ENERGY_DRIFT" in lines[-1]
    assert "; 0 s left; poincare: " in lines[-1]
