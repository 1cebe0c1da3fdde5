"""Chunks of stores that were exchanged are noticed; links and pipes in foreign stores are refused; links to stores."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import random
import shutil
import stat
import sys
from dataclasses import replace

import numpy as np
import pytest
from job_cases import JOBS, SMALL_GRID, bits
from thorough import TIMES

import fastaff as fa
from fastaff.cli.main import main
from fastaff.jobs import JobResults
from fastaff.jobs.guard import ITEMS, SEALED, SEALS
from fastaff.jobs.running import begin
from fastaff.jobs.store import ATTRIBUTES, Store
from fastaff.jobs.wording import OptionError


def pieces_of(store):
    """Chunks of each array that is cut into chunks: the path of the array, and its files by chunk."""
    found = {}
    for described in sorted(store.glob("*/*/zarr.json")):
        names = json.loads(described.read_text()).get("dimension_names") or [""]
        if names[-1] in (*ITEMS, "chunk"):
            files = [path for path in described.parent.rglob("*") if path.is_file() and path.name != "zarr.json"]
            found[described.parent.relative_to(store).as_posix()] = {int(path.name): path for path in files}
    return found


def exchange(one, other):
    content = one.read_bytes(), other.read_bytes()
    one.write_bytes(content[1])
    other.write_bytes(content[0])


def noticed(store, whole):
    """Whether reading says that a store is damaged; else it has the numbers of the whole one."""
    try:
        Store(store).verify()
        found = bits(JobResults.stored(store))
        place = JobResults.stored(store).place
    except OptionError:
        return True
    assert found == bits(whole)
    assert np.array_equal(place, whole.place)
    return False


# --- exchanged chunks -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4 * TIMES))
def test_exchanged_chunks_are_noticed(seed, store, made):
    """Of one array, of several, of whole chunks with their seals: said, or the numbers are the same."""
    rng, whole, said = random.Random(f"exchanged {seed}"), JobResults.stored(made), 0
    arrays = pieces_of(store)
    numbers = sorted(arrays["launch/finished"])
    assert len(numbers) == 4
    for _ in range(6):
        one, other = rng.sample(numbers[:-1], 2)
        chosen = rng.choice([rng.sample(sorted(arrays), k) for k in (1, 2, 5)] + [sorted(arrays)])
        for name in chosen:
            exchange(arrays[name][one], arrays[name][other])
        different = any(arrays[name][one].read_bytes() != arrays[name][other].read_bytes() for name in chosen)
        found = noticed(store, whole)
        assert found == different
        said += found
        for name in chosen:
            exchange(arrays[name][one], arrays[name][other])
    assert not noticed(store, whole)
    assert said > 2


@pytest.mark.parametrize("name", ["launch/z0", "launch/finished", "integrate/z", "poincare/status", f"launch/{SEALS}"])
def test_one_array_at_a_time(name, store, made):
    """Two chunks exchanged, one put in the place of another, one of another array: each array by itself."""
    files, whole = pieces_of(store)[name], JobResults.stored(made)
    kept = {number: path.read_bytes() for number, path in files.items()}
    for one, other in itertools.permutations(sorted(files)[:3], 2):
        if kept[one] == kept[other]:
            continue
        files[one].write_bytes(kept[other])
        with pytest.raises(OptionError, match=rf"of chunk {one} is not what was written there|is damaged"):
            JobResults.stored(store)["integrate"], Store(store).verify()
        files[one].write_bytes(kept[one])
    assert not noticed(store, whole)


def test_parts_of_a_store_are_compared_too(store):
    """A slice of points reads the chunks that it needs, and says of these alone."""
    files = pieces_of(store)["integrate/z"]
    exchange(files[0], files[1])
    with pytest.raises(OptionError, match=r"integrate/z of chunk 1 is not what was written there"):
        JobResults.stored(store)["integrate", 5:6]
    JobResults.stored(store)["integrate", 8:15]
    with pytest.raises(OptionError, match="is not what was written"):
        JobResults.stored(store).to_netcdf(store.parent / "x.nc")


def test_going_on_compares_what_is_there(store, made):
    """A resume that has something to do looks at all that was done."""
    whole = JobResults.stored(made)
    Store(store, writing=True).forget(3)
    files = pieces_of(store)["poincare/points"]
    exchange(files[0], files[2])
    for act in (fa.resume, lambda path: fa.run(SMALL_GRID, path), lambda path: fa.rerun(path, status="OK", step=0.05)):
        with pytest.raises(OptionError, match=r"poincare/points of chunk \d is not what was written there"):
            act(store)
    exchange(files[0], files[2])
    Store(store, writing=True).tell(reruns=[])
    assert bits(fa.resume(store)) == bits(whole)


def test_starts_of_ones_own_are_compared_before_they_are_computed(tmp_path):
    job = replace(JOBS["own starts"], chunk=7)
    whole = fa.run(job, tmp_path / "whole")
    begin(job, tmp_path / "s")
    files = pieces_of(tmp_path / "s")["launch/z0"]
    exchange(files[0], files[1])
    with pytest.raises(ValueError, match=r"launch/z0 of chunk \d is not what was written there"):
        fa.resume(tmp_path / "s")
    exchange(files[0], files[1])
    assert bits(fa.resume(tmp_path / "s")) == bits(whole)


def test_a_rerun_has_seals_of_its_own(store):
    """Chunks of before a rerun do not fit after it."""
    old = shutil.copytree(store, store.parent / "old")
    after = fa.rerun(store, status="OK", step=0.05)
    assert not noticed(store, after)
    before, now = pieces_of(old), pieces_of(store)
    changed = 0
    for name in ("integrate/z", "integrate/attempt", f"launch/{SEALS}"):
        kept = now[name][1].read_bytes()
        now[name][1].write_bytes(before[name][1].read_bytes())
        assert noticed(store, after) == (kept != before[name][1].read_bytes())
        changed += kept != before[name][1].read_bytes()
        now[name][1].write_bytes(kept)
    assert changed == 3


@pytest.mark.parametrize("how", ["seals removed", "names removed", "other names", "no text"])
def test_seals_cannot_be_taken_away(how, store):
    data = json.loads((store / "zarr.json").read_text())
    facts = json.loads(data["attributes"][ATTRIBUTES])
    if how == "seals removed":
        shutil.rmtree(store / "launch" / SEALS)
    elif how == "names removed":
        del facts[SEALED]
    else:
        facts[SEALED] = [1, 2] if how == "no text" else facts[SEALED][1:]
    data["attributes"][ATTRIBUTES] = json.dumps(facts)
    (store / "zarr.json").write_text(json.dumps(data))
    with pytest.raises(OptionError, match="damaged"):
        JobResults.stored(store)["integrate"]


# --- links and pipes within a store -----------------------------------------------------------------------------------


def folders(store):
    """Every folder of a store down to the chunks."""
    return sorted(path.relative_to(store).as_posix() for path in store.rglob("*") if path.is_dir())


def test_no_folder_of_a_store_is_a_link(store, made, tmp_path):
    """Two folders of each depth, of starts and of results: nothing is written where they lead."""
    victim, known = tmp_path / "victim", {}
    for name in folders(made):
        known.setdefault((name.startswith("launch"), name.count("/")), []).append(name)
    for name in sorted({names[end] for names in known.values() for end in (0, -1)}):
        shutil.rmtree(store)
        shutil.copytree(made, store)
        with contextlib.suppress(FileNotFoundError):
            shutil.rmtree(victim)
        Store(store, writing=True).forget(1)
        shutil.move(store / name, victim)
        (store / name).symlink_to(victim)
        before = {path: path.read_bytes() for path in victim.rglob("*") if path.is_file()}
        for act in (
            fa.resume,
            lambda path: JobResults.stored(path)["integrate"],
            lambda path: fa.run(SMALL_GRID, path),
        ):
            with pytest.raises(ValueError, match="has a link"):
                act(store)
        assert {path: path.read_bytes() for path in victim.rglob("*") if path.is_file()} == before, name


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_no_file_of_a_store_is_a_pipe(store):
    """Each kind of file in turn: refused by name, and nobody waits."""
    files = sorted(path for path in store.rglob("*") if path.is_file())
    rng = random.Random("pipes")
    chosen = [path for path in files if path.name in ("zarr.json", "chunks.jsonl")]
    chosen += rng.sample([path for path in files if path not in chosen], 12)
    for path in chosen:
        content = path.read_bytes()
        path.unlink()
        os.mkfifo(path)
        with pytest.raises(ValueError, match=str(store)):
            bits(JobResults.stored(store)), Store(store).verify(), JobResults.stored(store).table()
        path.unlink()
        path.write_bytes(content)


# --- links to a store -------------------------------------------------------------------------------------------------


def test_a_store_is_made_where_a_link_leads(tmp_path, made):
    """Also one that leads to nothing yet; the link stays, and what is overwritten is what it leads to."""
    (tmp_path / "large").mkdir()
    link = tmp_path / "s.zarr"
    link.symlink_to(tmp_path / "large" / "there")
    whole = JobResults.stored(made)
    assert bits(fa.run(SMALL_GRID, link)) == bits(whole)
    other = replace(SMALL_GRID, options=fa.jobs.RunOptions(step=0.05))
    fa.run(other, link, overwrite=True)
    assert link.is_symlink()
    assert (tmp_path / "large" / "there").is_dir()
    assert bits(fa.run(SMALL_GRID, link, overwrite=True)) == bits(whole)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["large", "s.zarr"]
    assert [path.name for path in (tmp_path / "large").iterdir()] == ["there"]


@pytest.mark.parametrize("where", ["nowhere/there", "itself"])
def test_a_link_that_leads_nowhere(where, tmp_path, refused, here):
    link = here / "s.zarr"
    link.symlink_to("s.zarr" if where == "itself" else here / where)
    (here / "job.toml").write_text(SMALL_GRID.text())
    with pytest.raises(ValueError, match="is a link"):
        fa.run(SMALL_GRID, link)
    refused(["run", "job.toml", "--store", "s.zarr", "--quiet"], "is a link")
    assert link.is_symlink()


def test_a_store_that_is_replaced_keeps_its_permissions(tmp_path):
    fa.run(SMALL_GRID, tmp_path / "s")
    (tmp_path / "s").chmod(0o700)
    fa.run(replace(SMALL_GRID, options=fa.jobs.RunOptions(step=0.05)), tmp_path / "s", overwrite=True)
    assert stat.S_IMODE((tmp_path / "s").stat().st_mode) == 0o700


# --- what is said -----------------------------------------------------------------------------------------------------


def test_an_interrupted_rerun_is_not_complete(store, capsys):
    """Also where no chunk of it has begun."""
    entry = {"status": [0], "options": {"step": 0.05}, "analyses": ["integrate"], "date": ""}
    assert JobResults.stored(store).complete
    Store(store, writing=True).tell(reruns=[entry])
    results = JobResults.stored(store)
    left = results.counts()["integrate"]["OK"]
    assert not results.complete
    assert f"{left} orbits still to be run again" in results.table()
    assert main(["status", str(store)]) == 0
    assert f"go on with: fastaff resume {store}" in capsys.readouterr().out
    done = fa.resume(store)
    assert done.complete
    assert "still" not in done.table()


def test_what_is_missing_is_named(made, monkeypatch):
    # xarray looks once in a process for what is installed, and would not find dask again.
    JobResults.stored(made).to_xarray({}).close()
    for name, extra, act in (
        ("dask", "dask", lambda results: results.to_xarray({})),
        ("h5netcdf", "io", lambda results: results.to_netcdf("x.nc")),
        ("xarray", "io", lambda results: results.to_xarray()),
    ):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(ModuleNotFoundError, match=rf"needs {name}: pip install 'fastaff\[{extra}\]'"):
            act(JobResults.stored(made))
        monkeypatch.undo()
