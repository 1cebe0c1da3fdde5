"""One table of levels for every solver: parts of it, multiplets, what is complete, files and wave functions."""

import copy
import math
import pickle

import numpy as np
import pytest

from fastaff import Anharmonic, Body, Hyperelastic, NeoHookean, SeparableAlphaBeta, Status, files, univariate
from fastaff.quantum import LevelTable, all_levels, exact_levels, quasiclassical_levels, spectrum, wavefunction
from fastaff.systems.models import Oscillator

ANHARMONIC = Body(Anharmonic(1.1), 0.8)
TABLES = {
    "exact": lambda: exact_levels(ANHARMONIC, max_energy=9.0),
    "EBK": lambda: quasiclassical_levels(ANHARMONIC, max_energy=9.0),
    "class": lambda: spectrum(ANHARMONIC, m=1, l=1, count=7),
    "whole": lambda: all_levels(ANHARMONIC, max_energy=9.0),
    "not separated": lambda: spectrum(Body(NeoHookean()), m=0, l=0, count=4, tolerance=1e-4),
}
every_table = pytest.mark.parametrize("make", TABLES.values(), ids=TABLES)
ARRAYS = ("E", "error", "status", "n", "m", "l", "constants")


@every_table
def test_every_solver_gives_the_same_table(make):
    found = make()
    assert isinstance(found, LevelTable)
    for name in ARRAYS:
        assert getattr(found, name).shape[-1] == len(found) > 3
    assert len(found.n) == len(found.names)
    assert len(found.constants) == len(found.constant_names)
    assert (found.status == Status.OK).all()
    assert found.converged.all()
    assert np.all(found.error > 0)
    assert len(repr(found).splitlines()) == 1


@every_table
def test_parts_of_a_table(make):
    found = make()
    for items in ([2, 0], slice(1, None, 2), np.median(found.E) < found.E, np.zeros(0), -1):
        part = found[items]
        index = np.zeros(0, int) if isinstance(items, np.ndarray) and items.size == 0 else np.arange(len(found))[items]
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(part, name), getattr(found, name)[..., np.atleast_1d(index)])
        assert part.complete_below == -math.inf
    assert [one.E[0] for one in found] == found.E.tolist()
    assert found["E"] is found.E
    np.testing.assert_array_equal(found[f"n_{found.names[0]}"], found.n[0])
    for wrong in ("nothing", 1.5, [0.5], True):
        with pytest.raises((TypeError, ValueError, KeyError)):
            found[wrong]
    with pytest.raises(IndexError, match=f"the level index {len(found)} is out of range"):
        found[len(found)]


def test_exact_quasiclassical_and_computed_levels_are_the_same():
    tables = [TABLES[name]().ascending() for name in ("exact", "EBK", "whole")]
    for table in tables[1:]:
        np.testing.assert_allclose(table.E, tables[0].E, rtol=1e-12)
        assert table.multiplets().degeneracy.tolist() == tables[0].multiplets().degeneracy.tolist()
        assert {*zip(*table.n, table.m, table.l)} == {*zip(*tables[0].n, tables[0].m, tables[0].l)}


def test_what_is_complete():
    found = TABLES["exact"]()
    assert found.complete_below == 9.0
    lower = found.below(6.0)
    assert lower.complete_below == 6.0
    assert len(lower) == np.count_nonzero(found.E < 6.0)
    assert found.below(20.0).complete_below == 9.0
    assert found.upto(3).complete_below == found.E[3]
    shuffled = found[np.random.default_rng(1).permutation(len(found))]
    assert shuffled.upto(5).E.tolist() == found.E[:5].tolist()


@pytest.mark.parametrize("chart", ["alpha-beta", "r-vartheta"])
def test_wave_functions_follow_their_levels(chart):
    found = spectrum(ANHARMONIC, m=2, l=0, count=9, chart=chart)
    backwards = found[::-1]
    for k in range(9):
        state, exact = backwards.state(8 - k), exact_levels(ANHARMONIC, n=found.n[:, k], m=2, l=0, chart=chart)
        assert state.energy == found.E[k] == pytest.approx(exact.E[0], rel=1e-12)
        assert [*state.constants.values()] == pytest.approx(exact.constants[:, 0].tolist(), rel=1e-12)
        closed = wavefunction(ANHARMONIC, m=2, l=0, n=tuple(found.n[:, k].tolist()), chart=state.chart)
        assert abs(state.overlap(closed)) == pytest.approx(1, abs=1e-10)


@pytest.mark.parametrize("name", ["exact", "EBK", "whole"])
def test_tables_without_wave_functions_say_so(name):
    with pytest.raises(ValueError, match="no wave functions"):
        TABLES[name]().state(0)


@every_table
def test_tables_are_plain_data(make, tmp_path):
    """They go through pickle with their wave functions, and into files."""
    found = make()
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(other, name), getattr(found, name))
        if found.waves is not None:
            x, y = np.array([1.2, 1.4]), np.array([0.3, 0.6])
            np.testing.assert_array_equal(other.state(2).density(x, y), found.state(2).density(x, y))
    path = files.save(tmp_path / "levels", found)
    arrays, metadata = files.contents(path)
    kept = files.load(path, waves=found.waves)
    assert isinstance(kept, LevelTable)
    for name in ARRAYS:
        np.testing.assert_array_equal(arrays[name], getattr(found, name))
        np.testing.assert_array_equal(getattr(kept, name), getattr(found, name))
    assert (kept.method, kept.names, kept.complete_below) == (found.method, found.names, found.complete_below)
    assert metadata["method"] == found.method
    assert metadata["names"] == [*found.names]
    assert (tmp_path / "levels.npz").stat().st_size < 200_000


def test_levels_without_a_torus_have_a_status_and_no_energy():
    """V_alpha has a bottom and an end: no torus has 40 quanta in alpha."""
    well = SeparableAlphaBeta(univariate(lambda x: -1 / (1 + x * x) ** 2), Oscillator(1.0))
    found = quasiclassical_levels(Body(well), n=[[0, 40], [0, 0]], m=0, l=0, hbar=0.05)
    assert found.status[0] == Status.OK
    assert found.status[1] in (Status.UNBOUND, Status.NOT_CONVERGED)
    assert np.isnan(found.E[1])
    assert len(found.ascending()) == np.count_nonzero(np.isfinite(found.E)) == found.multiplets().degeneracy.sum()


def test_a_basis_that_is_too_small_is_not_converged():
    found = spectrum(Body(Hyperelastic()), m=0, l=0, count=3, tolerance=1e-300)
    assert (found.status == Status.NOT_CONVERGED).all()
    assert "3 not converged at tolerance=1e-300" in repr(found)
