"""What all results can do, each class on a small result: length, items, joining, names, one line, a table, files."""

import dataclasses
import json
import pickle
import subprocess
import sys
from functools import cache
from typing import NamedTuple

import battery
import numpy as np
import pytest
from comparison import same
from own_models import OneSpring

import fastaff as fa
from fastaff import Status, files
from fastaff.chaos.chaotic_fraction import FoundCases
from fastaff.core import numbers
from fastaff.results.result import Result
from fastaff.sections.section_edge import edge

HH, BODY, X = battery.HH, battery.BODY, battery.X
SURFACE = {"energy": 0.1, "section": X}
GRID = {**SURFACE, "axes": ([-0.2, 0.0, 0.1], [-0.1, 0.1])}
CLOSED = np.array([[0.0, 0.0, 0.3, 0.31], [0.0, 0.01, 0.3, 0.3]]).T
FIXED = {"step": 0.1, "energy_tolerance": 1e9, "threads": 1}
RATIOS = np.array([[0.31, 0.25, 0.2], [0.21, 0.125, 0.3]])

MAKERS = {
    "Orbits": lambda: fa.integrate(HH, battery.Z4, time=2.0, samples=2, **FIXED),
    "TangentMap": lambda: fa.tangent_map(HH, battery.Z4, time=2.0, **FIXED),
    "EnergyGrid": lambda: fa.energy_grid(HH, **GRID),
    "EnergySample": lambda: fa.energy_sample(HH, **SURFACE, orbits=4),
    "SectionMap": lambda: fa.poincare_map(HH, made("EnergyGrid").z0, section=X, crossings=3, max_time=60.0, **FIXED),
    "Rotation": lambda: fa.rotation_number(np.stack([battery.POINTS, 2 * battery.POINTS], axis=-1)),
    "Islands": lambda: fa.islands(np.stack([battery.POINTS, 2 * battery.POINTS], axis=-1), max_islands=4),
    "FrequencyMap": lambda: fa.frequency_map(HH, battery.Z4, time=20.0, **FIXED),
    "OrbitFamilies": lambda: fa.frequencies.orbit_families(made("FrequencyMap"), threads=1),
    "Resonances": lambda: fa.resonances(RATIOS, max_order=4, names=("x", "y"), threads=1),
    "FrequencyLines": lambda: fa.naff(np.stack([battery.RING, 2 * battery.RING]), 0.1, lines=2, threads=1),
    "Tunes": lambda: fa.tunes(battery.TURNED),
    "AngleLines": lambda: fa.orbit_frequencies(battery.SLOW, 0.1, lines=2).lines,
    "TuneSums": lambda: accumulated().state,
    "ChaosMap": lambda: fa.chaos_map(HH, battery.Z4, time=10.0, history=2, **FIXED),
    "Basins": lambda: fa.basins(battery.LOGISTIC._replace(r=3.2), [[0.3, 0.4, 0.6, 1.2]], time=100, threads=1),
    "FoundCases": lambda: FoundCases.of(fa.chaotic_fraction(battery.own_case, ([0.8, 0.9, 1.0],), time=2.0, **FIXED)),
    "BifurcationDiagram": lambda: fa.chaos.bifurcation_diagram(
        battery.LOGISTIC, "r", [3.2, 3.5, 3.9], x0=0.3, transient=100, iterates=16
    ),
    "PeriodicOrbits": lambda: fa.periodic_orbits(HH, CLOSED, **SURFACE, max_time=20.0, step=0.1, threads=1),
    "Branch": lambda: fa.continuation(
        HH, CLOSED[:, 0], **SURFACE, max_steps=2, max_time=20.0, ds=1e-3, step=0.1, threads=1
    ),
    "ActionAngles": lambda: fa.action_angles(fa.Body(fa.Hyperelastic()), battery.Z8, threads=1),
    "EnergyOfActions": lambda: fa.energy_of_actions(battery.HARMONIC, np.array([[0.5, 1.0]] * 4), threads=1),
}
"""One for each class that is made of items."""


def accumulated():
    running = fa.TuneAccumulator()
    running.push(battery.TURNED)
    return running


WHOLE = {
    "Edge": lambda: edge(BODY, fa.AlphaEquals(1.4), energy=6.0, p_eta=0.3, p_gamma=0.2),
    "ChaoticFraction": lambda: fa.chaotic_fraction(battery.own_case, ([1.0],), time=2.0, **FIXED),
    "DiffusionHistogram": lambda: fa.frequencies.diffusion_histogram([-9.0, -3.0, np.nan]),
    "ResonanceLine": lambda: fa.frequencies.ResonanceLine(
        (1, -1), 2, (np.eye(2), np.eye(3)[:, :2]), np.eye(2, 3, dtype=bool)
    ),
    "SeriesExponent": lambda: fa.chaos.series_exponent(battery.SERIES),
    "Bifurcation": lambda: fa.periodic.Bifurcation(fa.periodic.Event.FOLD, 0.5, 0.1, CLOSED[:, 0], 6.0, 1e-9),
    "TorusFit": lambda: fa.fit_torus(HH, battery.Z4[:, 0], time=60.0, step=0.1),
}
"""One for each class that is one whole."""

items = pytest.mark.parametrize("name", MAKERS)
every = pytest.mark.parametrize("name", [*MAKERS, *WHOLE])


@cache
def made(name):
    return {**MAKERS, **WHOLE}[name]()


def below(cls):
    return [cls, *(entry for child in cls.__subclasses__() for entry in below(child))]


def part_of(result, index):
    """The arrays over items of a result at an index, taken one by one as the class declares them."""
    found = {}
    count = len(result)
    for name in [field.name for field in dataclasses.fields(result)]:
        value = getattr(result, name)
        if isinstance(value, np.ndarray) and count in value.shape and name not in ("times", "inaccessible"):
            axis = 0 if isinstance(result, fa.frequencies.FrequencyLines) else -1
            assert value.shape[axis] == count, name
            found[name] = np.take(value, np.arange(count)[index], axis=axis)
    return found


PARTS = tuple(f"fastaff.{part}." for part in ("runs", "frequencies", "sections", "chaos", "periodic", "tori"))
"""Parts with analyses of orbits."""


def test_every_class_is_here():
    """A class that is missing from the tables above is tested by nothing."""
    own = {cls.__name__ for cls in below(Result)[1:] if cls.__module__.startswith(PARTS)}
    assert own == {*MAKERS, *WHOLE}
    for name in own:
        assert type(made(name)).__name__ == name


def test_every_class_is_found_by_a_process_that_has_imported_nothing_else():
    code = "from fastaff import files; print(*files._results())"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=600).stdout
    own = {cls.__name__ for cls in below(Result)[1:] if cls.__module__.startswith((*PARTS, "fastaff.quantum"))}
    assert own
    assert own <= set(found.split())


@items
def test_length_and_items(name):
    result = made(name)
    count = len(result)
    assert count > 1
    assert result
    assert [len(part) for part in result] == [1] * count
    mask = np.arange(count) % 2 == 0
    for index in (mask, np.flatnonzero(mask), np.flatnonzero(mask).tolist(), slice(None, None, 2)):
        for part in (result.take(index), result[index]):
            assert type(part) is type(result)
            assert len(part) == mask.sum()
            expected = part_of(result, index)
            assert expected
            for field, array in expected.items():
                np.testing.assert_array_equal(getattr(part, field), array, err_msg=field)
            assert not hasattr(part, "call")
    for index in (-1, count - 1):
        for field, array in part_of(result, [count - 1]).items():
            np.testing.assert_array_equal(getattr(result[index], field), array)
    assert len(result[[]]) == len(result[~np.ones(count, bool)]) == 0


@items
def test_slices_copy_nothing(name):
    result = made(name)
    part = result[1:]
    shared = [
        np.shares_memory(getattr(part, field), getattr(result, field)) for field in part_of(result, slice(1, None))
    ]
    assert shared
    assert all(shared)


@items
@pytest.mark.parametrize("wrong", [99, [0, 99], "z?", [True], 1.5, [[0]], (0, 0), None, np.zeros(50, bool)])
def test_wrong_items_are_refused(name, wrong):
    beyond = wrong in (99, [0, 99]) if isinstance(wrong, (int, list)) else False
    error = IndexError if beyond else (ValueError, TypeError, KeyError)
    with pytest.raises(error, match=r"items: the \w+ index 99 is out of range" if beyond else r"items must be|has no"):
        made(name)[wrong]


@items
def test_parts_join_to_the_whole(name):
    result = made(name)
    joined = type(result).concat([result[:1], result[1:]])
    same(joined, result if not np.isscalar(getattr(result, "step", None)) else joined)
    same(Result.concat(list(result)), joined)
    assert not hasattr(joined, "call")
    with pytest.raises(TypeError, match="parts must all be"):
        type(result).concat([result, made("Edge")])
    with pytest.raises(ValueError, match="at least one"):
        type(result).concat([])


@items
def test_replaced_items(name):
    result = made(name)
    back = result[::-1]
    count = len(result)
    same(result.replaced(np.arange(count), back), result.replaced(slice(None), back))
    for field, array in part_of(result, slice(None, None, -1)).items():
        np.testing.assert_array_equal(getattr(result.replaced(slice(None), back), field), array)
        np.testing.assert_array_equal(getattr(result.replaced([0], result[-1]), field)[..., 0], array[..., 0]) if (
            name != "FrequencyLines"
        ) else None


def test_results_of_other_settings_do_not_join():
    cut = made("SectionMap")
    options = {"crossings": 3, "max_time": 60.0, "scheme": cut.scheme}
    other = fa.poincare_map(HH, made("EnergyGrid").z0, section=fa.Hyperplane((1, 0, 0, 0), 0.1), **options)
    with pytest.raises(ValueError, match="parts must have the same section"):
        fa.sections.SectionMap.concat([cut, other])
    with pytest.raises(ValueError, match="parts must all have time_error"):
        fa.sections.SectionMap.concat([cut, dataclasses.replace(other, section=cut.section)])


def test_another_number_of_crossings_is_filled():
    options = {"section": X, "max_time": 60.0, **FIXED}
    few = fa.poincare_map(HH, made("EnergyGrid").z0, crossings=2, **options)
    joined = fa.sections.SectionMap.concat([few, made("SectionMap")])
    assert joined.points.shape == (4, 3, 2 * len(few))
    assert np.isnan(joined.points[:, 2, : len(few)]).all()
    np.testing.assert_array_equal(joined.times[:2, : len(few)], few.times)
    np.testing.assert_array_equal(joined.times[:, len(few) :], made("SectionMap").times)


def test_each_part_brings_its_step():
    parts = [fa.integrate(HH, battery.Z4, time=2.0, step=step) for step in (0.1, 0.2)]
    joined = fa.runs.Orbits.concat(parts)
    orbits = len(parts[0])
    np.testing.assert_array_equal(joined.step, [0.1] * orbits + [0.2] * orbits)


def test_orbits_are_selected_by_what_they_are():
    z0 = np.concatenate([battery.Z4, [[0.0], [5.0], [0.1], [0.1]]], axis=1)  # the last one escapes
    run = fa.integrate(HH, z0, time=100.0, **FIXED)
    fine = run.select(status=Status.OK)
    assert len(fine) == len(run) - 1
    assert (fine.status == Status.OK).all()
    assert len(run.select(status=(Status.OK, run.status[-1]))) == len(run)
    assert len(run.select(status={Status.OK}, t=100.0)) == len(fine)
    fine.raise_if_failed()
    with pytest.raises(fa.OrbitError):
        run.raise_if_failed()
    with pytest.raises(ValueError, match="z must have one entry"):
        run.select(z=1.0)


@every
def test_one_line_and_a_table(name):
    result = made(name)
    assert repr(result).startswith(name)
    assert "\n" not in repr(result)
    assert len(repr(result)) <= 240
    text = result._repr_html_()
    shown = [field.name for field in dataclasses.fields(result) if not field.name.startswith("_")]
    assert text.count("<tr>") == 1 + len(shown) <= str(result).count("\n") + 1
    for field in shown:
        assert f"<td>{field}</td>" in text
    result.summary()


def test_tables_are_escaped():
    named = dataclasses.replace(made("EnergySample"), names=("<b>", "&"))
    assert "<b>" not in named._repr_html_()
    assert "&lt;b&gt;" in named._repr_html_()


@every
def test_fields_by_name(name):
    result = made(name)
    for field in dataclasses.fields(result):
        assert result[field.name] is getattr(result, field.name)
    with pytest.raises(KeyError, match=rf"{name} has no field '&'\. Names: \w"):
        result["&"]


@every
def test_a_result_is_no_array(name):
    """NumPy would take it apart, item by item."""
    with pytest.raises(TypeError, match="is no array"):
        np.asarray(made(name))


def test_rows_by_name():
    orbits, cut = made("Orbits"), made("SectionMap")
    for k, label in enumerate(("x", "y", "p_x", "p_y")):
        np.testing.assert_array_equal(orbits[label], orbits.z[k])
        np.testing.assert_array_equal(cut[label], cut.points[k])
        np.testing.assert_array_equal(made("PeriodicOrbits")[label], made("PeriodicOrbits").z[k])
        np.testing.assert_array_equal(made("PeriodicOrbits")[f"scale_{label}"], made("PeriodicOrbits").scale[k])
    nu, tori, chaos = made("FrequencyMap"), made("ActionAngles"), made("ChaosMap")
    np.testing.assert_array_equal(nu[f"nu_{nu.names[1]}"], nu.nu[1])
    np.testing.assert_array_equal(tori["J_phi"], tori.J[2])
    np.testing.assert_array_equal(tori["h_vartheta"], tori.constants[1])
    np.testing.assert_array_equal(chaos["megno"], chaos.megno)
    np.testing.assert_array_equal(chaos["thresholds_sali"], chaos.thresholds[1])
    np.testing.assert_array_equal(made("EnergySample")["p_y"], made("EnergySample").points[1])
    grid = made("EnergyGrid")
    np.testing.assert_array_equal(grid["p_y"], grid.z0[3])
    np.testing.assert_array_equal(grid["y"], grid.z0[1])
    np.testing.assert_array_equal(nu["omega"], nu.omega)


def test_coordinates_of_charts_by_name():
    body = fa.Body(fa.NeoHookean())
    surface = {"energy": 1.5, "section": fa.AlphaTurning(), "p_eta": 0.3, "p_gamma": 0.2}
    start = fa.energy_sample(body, orbits=4, **surface)
    run = fa.integrate(body, start.z0, time=3.0, **FIXED)
    rows = {"beta": 1, "p_beta": 5, "p_gamma": 7}
    for name, k in rows.items():
        np.testing.assert_array_equal(run[name], fa.charts.ALPHA_BETA.from_planes(run.z)[k])
    np.testing.assert_array_equal(run["vartheta"], fa.charts.R_VARTHETA.from_planes(run.z)[1])
    cut = fa.poincare_map(body, start.z0, section=fa.AlphaTurning(), crossings=6, max_time=10.0, step=0.02)
    assert 0 < np.isnan(cut.times).sum() < cut.times.size
    np.testing.assert_array_equal(cut["p_beta"], cut.coordinates(fa.charts.ALPHA_BETA)[5])
    assert cut["p_beta"].shape == cut.times.shape == (6, 4)
    np.testing.assert_allclose(cut["p_gamma"][np.isfinite(cut.times)], 0.2, rtol=1e-10)
    np.testing.assert_array_equal(cut["a1"], cut.points[0])


def test_several_axes_of_orbits():
    nu = RATIOS[:, :, None] * np.linspace(1.0, 1.1, 2)
    grid = fa.resonances(nu, max_order=4)
    assert grid.item_shape == (3, 2)
    assert len(grid) == 3
    assert grid[1:].basis.shape == (2, 2, 2, 2)
    part = grid[:, 0]
    np.testing.assert_array_equal(part.basis, grid.basis[..., :1])
    assert grid.take(grid.rank > 0).item_shape == (int((grid.rank > 0).sum()),)
    single = fa.resonances(RATIOS[:, 0])
    with pytest.raises(TypeError, match="no length"):
        len(single)
    with pytest.raises(TypeError, match="single orbit"):
        single[0]


@pytest.mark.parametrize("name", WHOLE)
def test_a_whole_has_no_items(name):
    with pytest.raises(TypeError, match="is one result"):
        len(made(name))
    with pytest.raises(TypeError, match="is one result"):
        made(name)[0]
    assert made(name)


def test_a_branch_is_cut_with_its_orbits():
    branch = made("Branch")
    np.testing.assert_array_equal(branch[1:].orbits.z, branch.orbits.z[:, 1:])
    assert branch[1:].status == branch.status


# --- files ---------------------------------------------------------------------------------------------------------


@every
def test_files_give_the_same_back(name, tmp_path):
    result = made(name)
    again = files.load(result.save(tmp_path / name))
    same(again, result)
    if hasattr(result, "call"):
        second = files.save(tmp_path / "second", again)
        assert files.contents(second).metadata["call"] == files.contents(tmp_path / f"{name}.npz").metadata["call"]
        assert (again.call.function, again.call.missing) == (result.call.function, result.call.missing)
    else:
        assert not hasattr(again, "call")


RETURNED = [name for name in battery.CALLS if "." not in name and name not in battery.OF_TEXTS]


@pytest.mark.parametrize("name", RETURNED)
def test_files_of_everything_that_functions_return(name, tmp_path):
    """Quantum results too; what is no result is refused."""
    result = battery.CALLS[name][0](**battery.base(name))
    if not callable(result) and name != "univariate":  # which takes the place of the function of that name
        through = pickle.loads(pickle.dumps(result))  # as pools of processes hand it over
        assert repr(through) == repr(result)
        if isinstance(result, (Result, tuple, np.ndarray)):
            same(through, result)
        assert hasattr(through, "call") == hasattr(result, "call")
    try:
        path = files.save(tmp_path / name, result)
    except TypeError as problem:
        assert "must be a result of fastaff" in str(problem)  # noqa: PT017
        assert not isinstance(result, Result)
        return
    try:
        again = files.load(path)
    except ValueError as problem:
        assert "can't hold" in str(problem) or "not the package's" in str(problem)  # noqa: PT017
        assert not isinstance(result, Result)
        return
    same(again, result)


def test_a_single_torus_keeps_its_numbers(tmp_path):
    single = fa.energy_of_actions(battery.HARMONIC, np.full(4, 0.5))
    same(files.load(single.save(tmp_path / "single")), single)


def test_the_sign_of_zero_stays(tmp_path):
    result = dataclasses.replace(made("Edge"), coordinate=np.array([0.0, 1.0]), momentum=np.array([-0.0, 1.0]))
    same(files.load(result.save(tmp_path / "zero")), result)


class Through(NamedTuple):
    """A section of the user's own."""

    offset: float
    direction: int = 1

    def value(self, x, y, p_x, p_y):
        """Return the section function."""
        return x - self.offset


def test_what_a_file_cannot_hold_is_to_be_given(tmp_path):
    mine = Through(0.0)
    cut = dataclasses.replace(made("SectionMap"), section=mine)
    path = cut.save(tmp_path / "own")
    with pytest.raises(ValueError, match=r"can't hold section: give section, as in load\(path, section=...\)"):
        files.load(path)
    assert files.load(path, section=mine).section is mine
    same(files.load(path, section=mine), cut)
    fit = dataclasses.replace(made("TorusFit"), model=OneSpring(2.0))
    path = fit.save(tmp_path / "fit")
    with pytest.raises(ValueError, match="give model"):
        files.load(path)
    same(files.load(path, model=fit.model), fit)


def test_metadata_and_arrays_can_be_read_as_they_are(tmp_path):
    cut = made("SectionMap")
    arrays, metadata = files.contents(cut.save(tmp_path / "cut", z0=made("EnergyGrid").z0, seed=3))
    np.testing.assert_array_equal(arrays["z0"], made("EnergyGrid").z0)
    np.testing.assert_array_equal(arrays["points"], cut.points)
    assert (metadata["seed"], metadata["result"], metadata["fastaff"]) == (3, "SectionMap", fa.__version__)


FORGED = {
    "unknown class": lambda m: m["content"].update(result="Popen"),
    "class of Python": lambda m: m["content"].update(result="object"),
    "base class": lambda m: m["content"].update(result="Result"),
    "no fields": lambda m: m["content"].update(fields={}),
    "another field": lambda m: m["content"]["fields"].update(__class__={"value": 1}),
    "no such array": lambda m: m["content"]["fields"]["points"].update(array="nowhere"),
    "text": lambda m: m.update(content="SectionMap"),
    "number": lambda m: m.update(content=3),
    "nothing": lambda m: m.pop("content"),
    "unknown enumeration": lambda m: m["content"]["fields"].update(status={"enum": "Path", "name": "x"}),
    "unknown value": lambda m: m["content"]["fields"].update(section={"value": {"class": "eval", "x": "1"}}),
    "unknown scheme": lambda m: m["content"]["fields"].update(scheme={"value": {"scheme": "__import__('os')"}}),
    "code": lambda m: m["content"]["fields"].update(
        section={"value": {"class": "A", "formula": ["__import__('os')", None, ["a"], ["x", "y"], "unit"], "a": 1.0}}
    ),
    "deep": lambda m: m["content"]["fields"].update(section="deep"),
    "call": lambda m: m.update(call={"function": 1}),
}

DEEP = '{"tuple": [' * 2000 + "]}" * 2000


@pytest.mark.parametrize("how", FORGED)
def test_forged_files_are_refused(how, tmp_path):
    """They name no other classes, and nothing in them is run."""
    arrays, metadata = files.contents(made("SectionMap").save(tmp_path / "cut"))
    FORGED[how](metadata)
    text = json.dumps(metadata).replace('"section": "deep"', f'"section": {DEEP}')
    np.savez(tmp_path / "forged.npz", **arrays, metadata=np.array(text))
    with pytest.raises(ValueError, match=r"forged.npz must (hold a result of this version|be a file written by)"):
        files.load(tmp_path / "forged.npz")


def test_another_format_is_not_read(tmp_path):
    path = made("SectionMap").save(tmp_path / "cut")
    arrays, metadata = files.contents(path)
    for version in (2, "2", None, [1]):
        np.savez(path, **arrays, metadata=np.array(json.dumps({**metadata, "format": version})))
        for read in (files.load, files.contents, files.recipe):
            with pytest.raises(ValueError, match=r"cut.npz must be .* it has the format .*, this version .* reads 1"):
                read(path)
    metadata.pop("format")  # as files of 0.1.0
    np.savez(path, **arrays, metadata=np.array(json.dumps(metadata)))
    same(files.load(path), made("SectionMap"))


def test_files_that_are_larger_inside_are_not_read(tmp_path, monkeypatch):
    """By compression, before memory is taken for them."""
    path = made("SectionMap").save(tmp_path / "cut")
    arrays, metadata = files.contents(path)
    text = np.array(json.dumps(metadata))
    np.savez_compressed(path, **arrays, more=np.zeros(2**22), metadata=text)
    assert path.stat().st_size < 2**20
    files.load(path)
    with monkeypatch.context() as patch:
        patch.setattr(numbers, "free_memory", lambda: 2**24)
        with pytest.raises(ValueError, match=r"cut.npz must be .* asks for 32.* MiB of memory .*, 16 MiB are free"):
            files.load(path)


def test_what_is_no_result_is_not_saved(tmp_path):
    for wrong in (HH, np.zeros(3), fa.sections.SectionMap, None):
        with pytest.raises(TypeError, match="must be a result of fastaff"):
            files.save(tmp_path / "wrong", wrong)
    assert list(tmp_path.iterdir()) == []


def test_a_dataclass_of_ones_own_is_kept_but_not_made_again(tmp_path):
    @dataclasses.dataclass
    class Mine:
        x: np.ndarray

    path = files.save(tmp_path / "mine", Mine(np.arange(2.0)))
    np.testing.assert_array_equal(files.contents(path).arrays["x"], [0.0, 1.0])
    with pytest.raises(ValueError, match="the class Mine, which is not the package's"):
        files.load(path)


# --- labels --------------------------------------------------------------------------------------------------------


@every
def test_arrays_have_named_axes(name):
    result = made(name)
    found = result.to_dict()
    sizes = {}
    assert found["data_vars"]
    for field, entry in found["data_vars"].items():
        assert len(entry["dims"]) == entry["data"].ndim, field
        assert len(set(entry["dims"])) == len(entry["dims"]), field
        for dim, size in zip(entry["dims"], entry["data"].shape, strict=True):
            assert sizes.setdefault(dim, size) == size, (field, dim)
    for dim, entry in found["coords"].items():
        assert sizes[dim] == len(entry["data"])
    assert found["attrs"]["result"] == name
    assert found["attrs"]["fastaff"] == fa.__version__
    assert all(isinstance(value, (int, float, str)) for value in found["attrs"].values())


def test_labels_units_and_provenance():
    found = made("FrequencyMap").to_dict()
    assert found["data_vars"]["nu"]["dims"] == ("angle", "orbit")
    assert found["data_vars"]["nu"]["attrs"] == {"units": "cycles/time"}
    assert found["coords"]["angle"]["data"] == list(made("FrequencyMap").names)
    assert found["attrs"]["call"].startswith("frequency_map(model=")
    assert found["attrs"]["scheme"] == "KAHAN_LI8"
    assert made("SectionMap").to_dict()["data_vars"]["points"]["dims"] == ("coordinate", "crossing", "orbit")


def test_without_xarray_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r"pip install 'fastaff\[io\]'"):
        made("Orbits").to_xarray()


@every
def test_xarray(name):
    pytest.importorskip("xarray")
    data = made(name).to_xarray()
    for field, entry in made(name).to_dict()["data_vars"].items():
        assert data[field].dims == entry["dims"]
        np.testing.assert_array_equal(data[field].values, entry["data"])


# --- figures -------------------------------------------------------------------------------------------------------


@every
def test_figures(name):
    figure = pytest.importorskip("matplotlib.figure")
    others = (fa.energy_sample(HH, **SURFACE, orbits=len(made(name))),) if name == "ChaosMap" else ()
    ax = figure.Figure().subplots()
    drawn = made(name).plot(*others, ax=ax)
    assert drawn.points is not None
    assert ax.get_xlabel()
    ax.figure.canvas.draw()


def test_a_figure_says_what_it_needs():
    with pytest.raises(TypeError, match="the figure of a ChaosMap needs starts, the EnergyGrid"):
        made("ChaosMap").plot()


# --- interruption --------------------------------------------------------------------------------------------------


def stop(_):
    raise KeyboardInterrupt


def interrupted(function, *given, **named):
    with pytest.raises(fa.Interrupted) as caught:
        function(*given, **named)
    return caught.value.partial


def raising(monkeypatch, module, name, calls):
    """Make the function `name` of a module raise KeyboardInterrupt after so many calls; return their number so far."""
    own, count = getattr(sys.modules[module], name), [0]

    def counted(*given, **named):
        count[0] += 1
        if count[0] > calls:
            raise KeyboardInterrupt
        return own(*given, **named)

    monkeypatch.setattr(sys.modules[module], name, counted)
    return count


@pytest.mark.parametrize("calls", [0, 1])
def test_a_torus_fit_is_undecided(monkeypatch, calls):
    raising(monkeypatch, "fastaff.tori.orbit_samples", "_path", calls)
    partial = interrupted(fa.fit_torus, HH, battery.Z4[:, 0], time=60.0, step=0.1)
    assert isinstance(partial, fa.tori.TorusFit)
    assert partial.classification is fa.Classification.UNDECIDED
    assert partial.evidence["status"] == Status.INTERRUPTED
    assert "stopped before its end" in partial.summary()


def test_a_torus_fit_says_how_far_it_is():
    fractions = []
    found = fa.fit_torus(HH, battery.Z4[:, 0], time=60.0, step=0.1, callback=fractions.append)
    assert (np.diff(fractions) >= 0).all()
    assert (len(fractions) > 4, fractions[-1]) == (True, 1.0)
    same(found, fa.fit_torus(HH, battery.Z4[:, 0], time=60.0, step=0.1))


@pytest.mark.parametrize("bases", [0, 2])
def test_a_spectrum_keeps_the_levels_of_the_last_basis(monkeypatch, bases):
    """Of a body that does not separate: what is kept has an error estimate, and lies within it of the end."""
    body, module = fa.Body(fa.NeoHookean()), "fastaff.quantum.solvers.nonseparable"
    fractions = []
    whole = fa.quantum.spectrum(body, m=0, l=0, count=4, tolerance=1e-13, callback=fractions.append)
    assert fractions[-1] == 1.0
    assert len(fractions) > 3
    assert np.all(np.diff(fractions) >= 0)
    count = raising(monkeypatch, module, "by_channels", bases)
    partial = interrupted(fa.quantum.spectrum, body, m=0, l=0, count=4, tolerance=1e-13)
    assert count[0] == bases + 1
    if not bases:
        assert partial is None
        return
    assert isinstance(partial, fa.quantum.LevelTable)
    assert len(partial) == 4
    assert partial.call.function == "spectrum"
    assert np.isfinite(partial.error).all()
    assert (np.abs(partial.E - whole.E) <= partial.error + whole.error).all()


@pytest.mark.parametrize("calls", [0, 1, 8])
def test_a_search_keeps_the_orbits_found(monkeypatch, calls):
    raising(monkeypatch, "fastaff.periodic.periodic_orbits", "section_returns", calls)
    partial = interrupted(
        fa.find_periodic_orbits,
        HH,
        made("EnergyGrid").z0,
        **SURFACE,
        max_crossings=2,
        max_guesses=4,
        step=0.1,
        max_time=100.0,
    )
    assert isinstance(partial, fa.periodic.PeriodicOrbits)
    assert (partial.status == Status.OK).all()
    assert partial.call.function == "find_periodic_orbits"
    assert len(partial) == 0 or calls > 1


def test_a_search_that_is_stopped_at_its_map_has_found_none(monkeypatch):
    raising(monkeypatch, "fastaff.sections.crossing_run", "follow_crossings", 0)
    partial = interrupted(fa.find_periodic_orbits, HH, made("EnergyGrid").z0, **SURFACE, max_crossings=1, step=0.1)
    assert isinstance(partial, fa.periodic.PeriodicOrbits)
    assert len(partial) == 0


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.9])
def test_a_branch_ends_where_it_was_stopped(monkeypatch, share):
    module = "fastaff.periodic.return_map"
    run = {**SURFACE, "max_time": 20.0, "ds": 1e-3, "step": 0.1, "threads": 1}
    calls = raising(monkeypatch, module, "follow_crossings", np.inf)
    whole = fa.continuation(HH, CLOSED[:, 0], max_steps=4, **run)
    monkeypatch.undo()
    raising(monkeypatch, module, "follow_crossings", share * calls[0])
    partial = interrupted(fa.continuation, HH, CLOSED[:, 0], max_steps=4, **run)
    assert isinstance(partial, fa.periodic.Branch)
    assert partial.status == Status.INTERRUPTED
    count = len(partial)
    assert count < len(whole) if share < 0.5 else 0 < count <= len(whole)
    np.testing.assert_array_equal(partial.parameter, whole.parameter[:count])
    np.testing.assert_array_equal(partial.orbits.z, whole.orbits.z[:, :count])
