"""Where a store is and who writes it: processors of other kinds, stores that are moved, what all orbits share, logs of
others.
"""

import contextlib
import json
import random
import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
import zarr
from job_cases import SMALL_GRID as JOB
from job_cases import bits

import fastaff as fa
from fastaff.jobs import JobResults, chunks
from fastaff.jobs.guard import ITEMS
from fastaff.jobs.store import Store, _whole
from fastaff.jobs.wording import OptionError
from fastaff.results import machine

RNG = random.Random(16)


# --- processors ---------------------------------------------------------------------------------------------------


def test_a_processor_is_what_machine_code_is_made_for(monkeypatch):
    name, *features = machine.processor().split()
    assert features == sorted(features)
    assert name in (machine.machine()["llvm_cpu"], machine.config.CPU_NAME)
    monkeypatch.setattr(machine.config, "CPU_NAME", "core2")
    monkeypatch.setattr(machine.config, "CPU_FEATURES", "+sse2,-avx,+mmx")
    assert machine.processor() == "core2 mmx sse2"


def others():
    """Processors of other kinds: another name, a feature more, less, other ones."""
    name, *features = machine.processor().split()
    yield " ".join(["core2", *features])
    yield " ".join([name, *features, "zzz"])
    if features:
        yield " ".join([name, *RNG.sample(features, len(features) - 1)])
    yield "core2 sse2"


@pytest.mark.parametrize("other", [*others()], ids=range(len([*others()])))
@pytest.mark.parametrize("act", [fa.resume, lambda path: fa.run(JOB, path), lambda path: chunks.compute_chunk(path, 1)])
def test_a_store_does_not_go_on_on_another_processor(act, other, store):
    opened = Store(store, writing=True)
    opened.forget(1)
    opened.tell(processor=other)
    with pytest.raises(ValueError, match="another type of processor") as caught:
        act(store)
    said = str(caught.value)
    for one, two in ((other, machine.processor()), (machine.processor(), other)):
        features = " ".join(sorted({*one.split()} - {*two.split()})) or "nothing"
        assert features[:18] in said
    assert "--allow-other-cpu" in said
    assert (Store(store).state(1) == -1).all()


def test_it_goes_on_where_that_is_asked_for(store, made):
    opened = Store(store, writing=True)
    opened.forget(2)
    opened.tell(processor="core2 sse2")
    with pytest.raises(ValueError, match="another type of processor"):
        fa.rerun(store, status="OK", scheme="DOP853")
    assert Store(store).facts["reruns"] == []
    JobResults.stored(store)["integrate"]  # it can be read
    done = fa.resume(store, allow_other_cpu=True)
    assert bits(done) == bits(JobResults.stored(made))
    assert "processors of several kinds" in done.table()
    assert "processors" not in JobResults.stored(made).table()
    Store(store, writing=True).forget(2)
    with ThreadPoolExecutor(1) as pool:  # asked for once, for all that compute chunks
        assert fa.resume(store, executor=pool).complete


def test_a_complete_store_needs_no_processor(store):
    Store(store, writing=True).tell(processor="core2")
    assert fa.resume(store).complete
    assert fa.run(JOB, store).complete
    assert not Store(fa.run(JOB, store, overwrite=True).path).facts["processor"].startswith("core2")


# --- what all orbits share ----------------------------------------------------------------------------------------


def shared(store):
    """Arrays that have no entry for each orbit, with their files."""
    for described in sorted(store.glob("*/*/zarr.json")):
        names = json.loads(described.read_text()).get("dimension_names") or [""]
        if names[-1] not in (*ITEMS, "chunk"):  # seals have a piece for each chunk
            files = [file for file in described.parent.rglob("*") if file.is_file() and file.name != "zarr.json"]
            yield described.parent.relative_to(store).as_posix(), files


def test_what_is_shared_is_one_file_each(store):
    found = dict(shared(store))
    assert {"launch/coordinate", "integrate/times"} <= found.keys()
    assert all(len(files) == 1 for files in found.values())


@pytest.mark.parametrize("array", ["launch/coordinate", "integrate/times", "others"])
def test_flipped_bits_of_what_is_shared(array, store):
    chosen = dict(shared(store))
    names = [array] if array in chosen else sorted(chosen.keys() - {"launch/coordinate", "integrate/times"})
    for name in names:
        (file,) = chosen[name]
        whole, opened = file.read_bytes(), Store(store)
        truth, kept = opened.root[name][...].tolist(), 0
        for bit in RNG.sample(range(8 * len(whole)), min(8 * len(whole), 160)):
            changed = bytearray(whole)
            changed[bit // 8] ^= 1 << bit % 8
            file.write_bytes(changed)
            with contextlib.suppress(OptionError):
                assert opened.root[name][...].tolist() == truth
                kept += 1
        assert kept < 20
        for damaged in (b"", whole[:-1], whole + b"\0", None):
            file.unlink() if damaged is None else file.write_bytes(damaged)
            with pytest.raises(OptionError, match=f"^{store} is damaged"):
                opened.root[name][...]
        file.write_bytes(whole)


@pytest.mark.parametrize(
    "value", [np.zeros(3), np.zeros((2, 3)), np.array(0.0), np.array(1j), np.zeros(0), np.zeros(2, bool)]
)
def test_shared_zeros_are_written(value, store):
    """An array of nothing but zeros is a file too: what is not there was lost."""
    _whole(zarr.open_group(str(store))["integrate"], "own", value, [f"own_{k}" for k in range(value.ndim)])
    array = Store(store).root["integrate/own"]
    assert array[...].tolist() == value.tolist()
    assert dict(shared(store))["integrate/own"] == [array.file(0)] * (value.size > 0)


# --- logs ---------------------------------------------------------------------------------------------------------

FIELDS = {"number": 1, "orbits": 4, "seconds": 0.5, "statuses": {"integrate": {"OK": 4}}, "energy_error": 1e-9}
WRONG = [
    "\x1b[31mred\x1b[0m",
    "4",
    None,
    True,
    [1],
    {"OK": "\x1b[2J"},
    {"\x1b[2J": {"OK": 1}},
    {"integrate": {"\x1b": 1}},
    {"integrate": {"OK": 1.5}},
    {"integrate": {"OK": True}},
    {"integrate": [1]},
    -1,
    -0.5,
    10**400,
    float("nan"),
]


def test_lines_of_wrong_types_are_skipped(store, made):
    truth = JobResults.stored(made)
    with open(store / "chunks.jsonl", "a") as file:
        for name in FIELDS:
            for value in WRONG:
                file.write(json.dumps({**FIELDS, "number": 2, name: value}) + "\n")
        file.write(json.dumps({**FIELDS, "more": 1}) + "\n")
    found = JobResults.stored(store)
    assert found.chunks == truth.chunks
    assert found.table() == truth.table()
    with open(store / "chunks.jsonl", "a") as file:
        file.write(json.dumps({**FIELDS, "seconds": 99.0, "energy_error": float("inf")}) + "\n")
    assert "slowest chunk 1: 4 orbits in 99.0 s" in JobResults.stored(store).table()


def test_nothing_in_a_store_moves_the_cursor(store):
    forged = {"status": [1], "options": {"scheme": "\x1b]0;title\x07\x1b[2J\nline"}, "analyses": []}
    Store(store, writing=True).tell(reruns=[forged])
    table = JobResults.stored(store).table()
    assert "run again with" in table
    assert all(line.isprintable() for line in table.splitlines())


# --- places -------------------------------------------------------------------------------------------------------


def moved(path, to):
    path.rename(to)


def removed(path, to):
    shutil.copytree(path, to)
    shutil.rmtree(path)


def replaced(path, to):
    path.rename(to)
    shutil.copytree(to, path)


@pytest.mark.parametrize(("happens", "workers"), [(moved, 0), (moved, 3), (removed, 0), (replaced, 0)])
def test_a_store_that_is_moved_while_it_is_written(happens, workers, made, tmp_path):
    """It ends there and says so; nothing is left at the old place, and both go on to the same bits."""
    path, to, done = tmp_path / "s", tmp_path / "elsewhere", []

    def move(progress, chunk):
        done.append(chunk)
        if len(done) == 2:
            happens(path, to)

    with ThreadPoolExecutor(max(workers, 1)) as pool, pytest.raises(FileNotFoundError) as caught:
        fa.run(replace(JOB, chunk=1), path, on_chunk=move, executor=pool if workers else None)
    assert str(path) in str(caught.value)
    if happens is not replaced:
        assert not path.exists()
    else:
        assert bits(fa.resume(path)) == bits(JobResults.stored(made))
    assert bits(fa.resume(to)) == bits(JobResults.stored(made))
    assert bits(fa.run(JOB if not path.exists() else replace(JOB, chunk=1), path)) == bits(JobResults.stored(made))


HOW = [{"on_chunk": 5}, {"threads": "x"}, {"threads": 0}, {"allow_other_cpu": "yes"}, {"callback": 1}]


@pytest.mark.parametrize("wrong", [*HOW, {"on_chunk": "x"}, {"overwrite": 1}, {"memory": "x"}, {"memory": -1.0}])
@pytest.mark.parametrize("stored", [True, False])
def test_what_is_wrong_is_said_before_anything_is_computed(wrong, stored, tmp_path):
    (name,) = wrong
    with pytest.raises((TypeError, ValueError), match=name):
        fa.run(JOB, tmp_path / "s" if stored else None, **wrong)
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize("wrong", HOW)
@pytest.mark.parametrize("again", [fa.resume, lambda path, **more: fa.rerun(path, status="OK", step=0.2, **more)])
def test_and_before_anything_is_changed(wrong, again, store):
    before = np.frombuffer((store / "zarr.json").read_bytes(), np.uint8)
    Store(store, writing=True).forget(0)
    (name,) = wrong
    with pytest.raises((TypeError, ValueError), match=name):
        again(store, **wrong)
    assert (Store(store).state(0) == -1).all()
    assert np.array_equal(before, np.frombuffer((store / "zarr.json").read_bytes(), np.uint8))
