"""A store is data: it opens without this package, one that is damaged or forged is refused by its name, and runs
nothing.
"""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from job_cases import CELLS, JOBS, MOTION, bits
from job_cases import SMALL_GRID as JOB

import fastaff as fa
from fastaff.jobs import InitialConditions, JobResults, PoincareOptions, RunOptions
from fastaff.jobs.store import ATTRIBUTES, FORMAT, Store
from fastaff.jobs.wording import OptionError


def edit(path, change):
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


def tell(store, change):
    """Change what the root tells of the job."""

    def changed(data):
        facts = json.loads(data["attributes"][ATTRIBUTES])
        facts = change(facts) or facts
        data["attributes"][ATTRIBUTES] = facts if isinstance(facts, str) else json.dumps(facts)

    edit(store / "zarr.json", changed)


def everything(store):
    """Whatever a reader does with a store."""
    results = JobResults.stored(store)
    found = bits(results)
    results.table()
    results.to_xarray().load()
    return found


def refused(store, match=".", more=True):
    """Reading, going on and running again end in a ValueError that names the store."""
    said = []
    for act in (everything, fa.resume, lambda path: fa.run(JOB, path))[: 3 if more else 1]:
        with pytest.raises(ValueError, match=match) as caught:
            act(store)
        said.append(str(caught.value))
        assert str(store) in said[-1]
        assert len(said[-1]) < 1000
    return said


# --- for others ---------------------------------------------------------------------------------------------------


def test_a_store_opens_without_fastaff(made, tmp_path):
    code = f"""
import sys, warnings
warnings.simplefilter("error")
import numpy as np, xarray
tree = xarray.open_datatree({str(made)!r}, engine="zarr").load()
assert "fastaff" not in sys.modules
assert set(tree.children) == {{"launch", "poincare", "integrate"}}
assert tree["integrate/z"].dims[-1] == "orbit" and tree["integrate/z"].sizes["orbit"] == 15
assert "OK" in tree["integrate/status"].attrs["flag_meanings"]
assert "[model]" in tree.attrs["job"]
assert list(tree["launch/coordinate"].values) == ["x", "y", "p_x", "p_y"] or len(tree["launch/coordinate"]) == 4
np.save({str(tmp_path / "z.npy")!r}, tree["integrate/z"].values)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    there = Store(made).finished() == 1
    assert np.load(tmp_path / "z.npy")[..., there].tobytes() == JobResults.stored(made)["integrate"].z.tobytes()


def test_netcdf_has_the_same_numbers(made, tmp_path):
    import xarray

    results = JobResults.stored(made)
    results.to_netcdf(tmp_path / "s.nc")
    with xarray.open_datatree(tmp_path / "s.nc", engine="h5netcdf") as tree, results.to_xarray() as own:
        count = 0
        for node in own.subtree:
            for name, values in node.variables.items():
                other = tree[f"{node.path}/{name}"].values
                assert (
                    other.astype(values.dtype).tobytes() == values.values.tobytes() or values.dtype.kind not in "biufc"
                )
                assert other.tolist() == values.values.tolist() or values.dtype.kind in "fc"
                count += 1
        assert count > 20


def test_results_are_saved_and_loaded(made, tmp_path):
    results = JobResults.stored(made)
    loaded = {name: fa.load(results[name].save(tmp_path / name)) for name in results}
    assert bits(loaded) == bits(results)


def test_names_of_stores(tmp_path, made):
    whole = bits(JobResults.stored(made))
    for name in ("Poincaré späß ☃.zarr", "deep/er a b'c\"d", "x" * 100):
        assert bits(fa.run(JOB, tmp_path / name)) == whole
    assert bits(fa.run(JOB, str(tmp_path / "as text"))) == whole


def test_what_is_no_store(tmp_path):
    with pytest.raises(FileNotFoundError, match="nothing does not exist"):
        fa.resume(tmp_path / "nothing")
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_bytes(b"\x00\xff")
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "zarr.json").write_bytes(b"\xff\xfe{")
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "zarr.json").write_text("[" * 10**5)
    for name in ("empty", "file", "bad", "deep"):
        with pytest.raises(ValueError, match="must be a store of a fastaff job"):
            fa.resume(tmp_path / name)
        with pytest.raises(FileExistsError):
            fa.run(JOB, tmp_path / name)
        with pytest.raises(FileExistsError, match="is no store"):
            fa.run(JOB, tmp_path / name, overwrite=True)


# --- forged -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", [0, 1, FORMAT + 1, 99, -1, None, "2", [2], {}])
def test_other_formats(version, store):
    tell(store, lambda facts: facts.update(format=version))
    refused(store, f"has the format .*; this version of fastaff reads {FORMAT}")


@pytest.mark.parametrize("root", ["null", "[]", "1", '"x"', "{", "[" * 10**5, "NaN", "\x00"])
def test_roots_that_tell_nothing(root, store):
    tell(store, lambda facts: root)
    refused(store, more=False)
    with pytest.raises(ValueError, match=r"must be a store|has the format"):
        fa.resume(store)


VALUES = [None, -1, 0, 10**15, 2**70, 1.5, True, "x", "../..", [], [1], {}, {"a": {"b": 1}}, float("nan")]
SOME = [value if k % 4 == 0 else pytest.param(value, marks=pytest.mark.slow) for k, value in enumerate(VALUES)]


@pytest.mark.parametrize("value", SOME, ids=repr)
@pytest.mark.parametrize(
    "name", ["job", "orbits", "chunk", "contents", "settled", "source", "reruns", "own_initial_conditions"]
)
def test_wrong_facts(name, value, store, made):
    tell(store, lambda facts: facts.update({name: value}))
    if name in ("source", "own_initial_conditions", "reruns"):  # those that only a run needs
        for act in (everything, fa.resume):
            with contextlib.suppress(OptionError):
                act(store)
    else:
        refused(store)


@pytest.mark.parametrize("value", SOME, ids=repr)
@pytest.mark.parametrize("name", ["contents", "settled"])
def test_wrong_facts_of_an_analysis(name, value, store):
    tell(store, lambda facts: facts[name].update(integrate=value))
    shutil.rmtree(store / "launch" / "finished" / "c")
    if name == "contents" and value != {}:
        refused(store, more=False)
    with pytest.raises((ValueError, TypeError), match=r"damaged|settings|settled|argument"):
        fa.resume(store)


@pytest.mark.parametrize("missing", ["job", "orbits", "chunk", "contents", "settled", "source", "reruns"])
def test_facts_that_are_missing(missing, store):
    tell(store, lambda facts: facts.pop(missing) and None)
    refused(store, missing)


CODE = [
    {"name": "numcodecs.pickle", "configuration": {}},
    {"name": "pickle"},
    {"name": "numcodecs.json2", "configuration": {"id": "json2"}},
    {"name": "sharding_indexed", "configuration": {"chunk_shape": [1], "codecs": [{"name": "numcodecs.pickle"}]}},
    "numcodecs.pickle",
    {"name": ["pickle"]},
    {},
    7,
]


@pytest.mark.parametrize(
    "array", ["integrate/z", *(pytest.param(n, marks=pytest.mark.slow) for n in ("launch/finished", "integrate/times"))]
)
@pytest.mark.parametrize("codec", CODE, ids=str)
def test_codecs_that_run_code(codec, array, store):
    edit(store / array / "zarr.json", lambda data: data["codecs"].insert(0, codec))
    refused(store)


@pytest.mark.parametrize("codec", CODE[:4], ids=str)
def test_codecs_in_what_xarray_reads(codec, store):
    def change(data):
        data["consolidated_metadata"]["metadata"]["integrate/z"]["codecs"] = [codec]

    edit(store / "zarr.json", change)
    refused(store, more=False)


@pytest.mark.parametrize(
    "kind", ["object", "|O", "numpy.datetime64", "r64", {"name": "struct", "configuration": {}}, None, 3, "os.system"]
)
def test_kinds_of_numbers(kind, store):
    edit(store / "integrate" / "z" / "zarr.json", lambda data: data.update(data_type=kind))
    refused(store)


@pytest.mark.parametrize(
    "change",
    [
        {"shape": [3, 4, 10**15]},
        {"shape": [10**9, 10**9, 15]},
        {"shape": [-1, 4, 15]},
        {"shape": []},
        {"shape": None},
        {"shape": ["x"]},
        {"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [10**6, 10**6, 4]}}},
        {"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [0]}}},
        {"chunk_grid": {"name": "other"}},
        {"chunk_grid": None},
        {"node_type": "group"},
        {"zarr_format": 2},
        {"chunk_key_encoding": {"name": "v2", "configuration": {"separator": "../"}}},
        {"fill_value": "x"},
        {"dimension_names": [1]},
    ],
    ids=str,
)
@pytest.mark.parametrize(
    "array", ["launch/z0", *(pytest.param(n, marks=pytest.mark.slow) for n in ("launch/finished", "integrate/z"))]
)
def test_shapes_and_grids(array, change, store):
    edit(store / array / "zarr.json", lambda data: data.update(change))
    refused(store)


def test_a_store_of_too_many_orbits_takes_no_memory(store):
    many = 10**15
    for file in [*store.glob("*/*/zarr.json")]:
        edit(
            file,
            lambda data: (
                data["shape"] and data["shape"].__setitem__(-1, many)
                if data["shape"] and data["shape"][-1] == 15
                else None
            ),
        )
    tell(store, lambda facts: facts.update(orbits=many))
    refused(store, "of memory")


def test_names_of_classes_and_functions(store):
    for forged in (
        {"result": "os.system", "fields": {}},
        {"result": "Popen", "fields": {"args": "touch /tmp/x"}},
        {"result": "Orbits", "fields": {"z": {"value": {"class": "Path", "module": "pathlib"}}}},
        {"result": "Orbits"},
        {"enum": "os", "name": "system"},
        {"tuple": []},
    ):
        tell(store, lambda facts, forged=forged: facts["contents"].update(integrate=forged))
        refused(store, more=False)


def test_a_job_that_asks_for_code(store):
    for text in (
        "[model]\nhamiltonian = \"__import__('os').system('touch pwned')\"\n[integrate]\ntime = 1.0",
        '[model]\nvalue = "os.system"\n[integrate]\ntime = 1.0',
        "import os",
    ):
        tell(store, lambda facts, text=text: facts.update(job=text))
        with pytest.raises(ValueError, match=r".") as caught:
            fa.resume(store)
        assert "\n" not in str(caught.value)
    assert not os.path.exists("pwned")


@pytest.mark.parametrize("name", ["integrate", "integrate/z", "integrate/z/c", "launch"])
def test_links(name, store, tmp_path):
    """Writing through one would change what is not the store's."""
    (store / name).rename(tmp_path / "elsewhere")
    (store / name).symlink_to(tmp_path / "elsewhere")
    refused(store, "link")


def test_a_link_in_place_of_the_log(store, tmp_path):
    (tmp_path / "profile").write_text("mine")
    (store / "chunks.jsonl").unlink()
    (store / "chunks.jsonl").symlink_to(tmp_path / "profile")
    refused(store, "link")
    assert (tmp_path / "profile").read_text() == "mine"


@pytest.mark.parametrize(
    "line", ["", "{", "null", "[1]", '{"number": "x"}', '{"number": 10}', "\x00", "[" * 10**5, '"' * 10, "1" * 10**5]
)
def test_a_log_of_garbage(line, store, made):
    with open(store / "chunks.jsonl", "a") as file:
        file.write(f'{line}\n{{"number": 0, "orb')
    assert everything(store) == bits(JobResults.stored(made))
    fa.resume(store)


def test_a_log_that_is_no_text(store, made):
    (store / "chunks.jsonl").write_bytes(b"\xff\xfe\x00" * 100)
    assert everything(store) == bits(JobResults.stored(made))


# --- damaged ------------------------------------------------------------------------------------------------------


def data_files(store):
    """Chunks of results, by orbits."""
    for array in sorted(store.glob("*/*/zarr.json")):
        if "orbit" in json.loads(array.read_text())["dimension_names"] and array.parts[-2] != "z0":
            yield from sorted(file for file in array.parent.glob("c/**/*") if file.is_file())


@pytest.mark.slow
def test_chunks_that_were_cut_off(store, made):
    for file in data_files(store):
        whole = file.read_bytes()
        for size in (0, 5, len(whole) - 1):
            file.write_bytes(whole[:size])
            refused(store, "damaged", more=False)
        file.write_bytes(whole + b"\x00")
        refused(store, "damaged", more=False)
        file.write_bytes(whole)
    assert everything(store) == bits(JobResults.stored(made))


def test_chunks_that_were_lost(store):
    """Those of finished chunks; a chunk whose `finished` is lost is computed again."""
    arrays = {}
    for file in data_files(store):
        if "launch" not in file.relative_to(store).parts and "attempt" not in file.parts:
            arrays.setdefault(file.relative_to(store).parts[:2], []).append(file)
    for number, files in enumerate(arrays.values()):  # first, second, ... chunk of the first, second, ... array
        file = files[number % len(files)]
        whole = file.read_bytes()
        file.unlink()
        refused(store, "is not there", more=False)
        file.write_bytes(whole)


@pytest.mark.parametrize("array", ["integrate/z", "launch/finished", "integrate/status", "poincare/counts"])
def test_every_flipped_bit(array, store, made):
    """Ends in an error, or changes no number."""
    file = next(iter(sorted((store / array / "c").rglob("0"), key=lambda f: -len(f.parts))))
    whole, opened = bytearray(file.read_bytes()), Store(store)
    truth, kept = opened.root[array][...].tobytes(), 0
    step = max(1, len(whole) * 8 // 400)
    for bit in [*range(min(200, len(whole) * 8)), *range(200, len(whole) * 8, step)]:
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        file.write_bytes(changed)
        try:
            found = opened.root[array][...].tobytes()
        except OptionError as problem:
            found = str(problem).startswith(f"{store} is damaged") or problem
        assert found is True or found == truth
        kept += found is not True
    assert kept < 20


def test_chunks_of_another_size(store):
    """A chunk of `finished` in place of that of status; and a small file of a thousand times the numbers."""
    from numcodecs.zstd import Zstd

    for file in (store / "integrate" / "status" / "c").iterdir():
        whole = file.read_bytes()
        for other in (
            (store / "launch" / "finished" / "c" / file.name).read_bytes(),
            Zstd(checksum=True).encode(bytes(2**20)),
        ):
            file.write_bytes(other)
            refused(store, "damaged in integrate/status", more=False)
        file.write_bytes(whole)


def test_parts_of_a_store_that_are_missing(store, made, tmp_path):
    for name in ("launch", "integrate", "poincare", "launch/z0", "launch/finished", "integrate/status", "integrate/z",
                 "integrate/zarr.json", "integrate/z/zarr.json", "launch/z0/zarr.json", "integrate/times"):  # fmt: skip
        copy = shutil.copytree(made, tmp_path / name.replace("/", "_"))
        target = copy / name
        shutil.rmtree(target) if target.is_dir() else target.unlink()
        refused(copy, more=False)


def test_own_starts_have_their_store(tmp_path):
    job = replace(JOBS["own starts"], integrate=MOTION, chunk=5)
    fa.run(job, tmp_path / "s")
    store = Store(tmp_path / "s")
    assert store.root["launch/z0"][:].tobytes() == np.ascontiguousarray(job.initial_conditions).tobytes()


# --- in parts -----------------------------------------------------------------------------------------------------


def test_parts_of_a_store_take_the_memory_of_a_part(tmp_path):
    """By slices of points, by xarray and by its dask: the same numbers as of the whole, at every bound."""
    own = {
        "initial_conditions": InitialConditions(orbits=600, seed=3),
        "poincare": PoincareOptions(crossings=300, max_time=4000.0),
        "chunk": 40,
    }
    job = replace(
        CELLS,
        energy_surface=replace(CELLS.energy_surface, energy=0.1),
        options=RunOptions(step=0.1),
        integrate=None,
        **own,
    )
    results = fa.run(job, tmp_path / "long.zarr")
    whole, small = peak(lambda: results["poincare"])
    assert whole.points.nbytes > 2 * 2**20

    def same(found, kept):
        for name in ("points", "times", "counts", "status"):
            np.testing.assert_array_equal(getattr(found, name), getattr(whole, name)[..., kept])

    place, kept = results.place, np.arange(len(whole))
    for first, last in ((0, 40), (37, 161), (-20, None), (590, 10**9), (30, 30), (80, 20)):
        found, most = peak(lambda bounds=(first, last): results["poincare", slice(*bounds)])
        there = slice(first, last).indices(600)[:2]
        same(found, kept[(place >= there[0]) & (place < there[1])])
        assert most < 0.4 * small
    sums = [results["poincare", k : k + 100].counts.sum() for k in range(0, 600, 100)]
    assert sum(sums) == whole.counts.sum()

    def mean(chunks):
        with results.to_xarray(chunks) as tree:
            if chunks is None:
                return tree["poincare/points"][..., :40].values, None
            return tree["poincare/points"][..., :40].values, tree["poincare/points"].chunksizes["orbit"]

    for chunks in (None, {}):
        (found, sizes), most = peak(lambda chunks=chunks: mean(chunks))
        np.testing.assert_array_equal(found, whole.points[..., :40])
        assert most < 0.6 * small
        assert sizes in (None, (40,) * 15)
    for wrong in (3, "x", (0, 3), slice(0, 10, 2)):
        with pytest.raises(TypeError, match="points must be one slice without a step"):
            results["poincare", wrong]
    with pytest.raises(KeyError, match="the job has poincare"):
        results["frequency_map", :3]


def peak(call):
    """What a call returns, and the most memory in bytes that it had at once; what it imports first is not counted."""
    call()
    tracemalloc.start()
    try:
        return call(), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_parts_of_results_in_memory():
    results = fa.run(JOB)
    whole, place = results["integrate"], results.place
    for points in (slice(0, 7), slice(3, None), slice(-5, -1), slice(9, 2)):
        there = points.indices(place.max() + 1)[:2]
        found = results["integrate", points]
        np.testing.assert_array_equal(found.z, whole.z[:, (place >= there[0]) & (place < there[1])])
