"""A file is enough to run again: model, formula, z0 and every option come back, and the same bits with them; nothing is
executed.
"""

import contextlib
import json
import random

import numpy as np
import pytest
from own_models import OneSpring
from thorough import TIMES

import fastaff as fa
from fastaff import files
from fastaff.results.calls import Call, encoded, is_recorded
from fastaff.systems.models.angles import AlphaBeta

RNG = np.random.default_rng(20261)
A, B, C, D = RNG.uniform(0.5, 2.0, 4).tolist()
OWN = fa.hamiltonian(
    "a*x**2/2 + b*y**2/2 + c*x**2*y", coordinates="x, y", masses=(D, A), domain="9 - x**2 - y**2", a=A, b=B, c=0.2 * C
)
BODY = fa.affine_body("k*(D1**2 + D2**2)/2 + g/(D1*D2)", mu=C, k=A, g=B)
Z4 = 0.1 * RNG.standard_normal((4, 3))
Z8 = np.concatenate([[[1.4, 1.2], [0.1, 0.2], [0.3, 0.1], [0.0, 0.1]], 0.3 * RNG.standard_normal((4, 2))])
MINE = fa.schemes.compose(fa.LEAPFROG, ["0.3"], name="mine", order=2, source="somebody 2000")
CALLS = {
    "integrate": lambda: fa.integrate(OWN, Z4, time=3.0, samples=2),
    "list": lambda: fa.integrate(OWN, [float(x) for x in Z4[:, 0]], time=3, step=0.05, scheme=MINE),
    "pair": lambda: fa.integrate(fa.affine_body("x**2 + z**2 + 2*y**2 + 2*u**2", mu=(A, B)), Z8, time=1.0, step=0.05),
    "transformed": lambda: fa.integrate(
        OWN, Z4, time=2.0, step=0.1, scheme=fa.TimeTransformed(rate=fa.schemes.Logistic(A, B))
    ),
    "poincare_map": lambda: fa.poincare_map(
        BODY, Z8, section=fa.AlphaTurning(-1), crossings=3, max_time=50.0, scheme=fa.DOP853
    ),
    "frequency_map": lambda: fa.frequency_map(
        fa.Body(fa.Hyperelastic(A), B), Z8, time=20.0, signals=AlphaBeta(), step=0.02
    ),
    "chaos_map": lambda: fa.chaos_map(OWN, Z4, time=5.0, indicators=(fa.MEGNO(4.0), fa.SALI()), step=0.1),
    "action_angles": lambda: fa.action_angles(fa.Body(fa.Harmonic(A), B), Z8, chart=fa.charts.ALPHA_BETA),
    "sample": lambda: fa.energy_sample(
        fa.Body(fa.NeoHookean(A)), energy=9.0, section=fa.AlphaTurning(), orbits=5, seed=[3, 1], p_eta=0.1
    ),
    "levels": lambda: fa.quantum.exact_levels(fa.Body(fa.Anharmonic(A)), max_energy=12.0),
}


def same(one, other):
    """Assert that every field of two results has the same bits."""
    for name in one.__dataclass_fields__:
        a, b = getattr(one, name), getattr(other, name)
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype, name
            assert a.tobytes() == b.tobytes(), name
        elif not callable(a) and name != "separated":
            assert repr(a) == repr(b), name


@pytest.mark.parametrize("name", CALLS)
def test_a_file_is_enough_to_run_again(name, tmp_path):
    result = CALLS[name]()
    path = files.save(tmp_path / name, result)
    recipe = files.recipe(path)
    same(result, recipe.run())
    assert (recipe.function, set(result.call.missing)) == (result.call.function, set())


def test_the_text_of_a_formula_is_in_the_file(tmp_path):
    """Readable without the package, with its domain, masses and parameters; beside whatever name the caller gives the
    model.
    """
    path = files.save(tmp_path / "own", fa.integrate(OWN, Z4, time=1.0, step=0.1), model=OWN)
    metadata = files.contents(path).metadata
    for model in (metadata["model"], metadata["call"]["arguments"]["model"]):
        assert model["formula"] == [OWN.formula, OWN.domain, ["a", "b", "c"], ["x", "y"], "masses", *[None] * 4, [], []]
        assert (model["a"], model["m_1"], model["m_2"]) == (A, D, A)
    assert metadata["call"]["arguments"]["rtol"] == 1e-12  # what was left at its default is stated too


def test_other_options_can_be_given(tmp_path):
    path = files.save(tmp_path / "run", fa.integrate(OWN, Z4, time=2.0, step=0.1))
    longer = files.recipe(path).run(time=4.0)
    same(longer, fa.integrate(OWN, Z4, time=4.0, step=0.1))


def test_the_call_keeps_what_was_given_then(tmp_path):
    z0 = Z4.copy()
    result = fa.integrate(OWN, z0, time=2.0, step=0.1)
    z0 += 1.0
    same(result, files.recipe(files.save(tmp_path / "run", result)).run())


def test_arrays_are_written_once(tmp_path):
    result = fa.integrate(OWN, Z4, time=2.0, step=0.1)
    arrays, metadata = files.contents(files.save(tmp_path / "run", result, z0=Z4))
    assert metadata["call"]["arguments"]["z0"] == {"array": "z0"}
    assert "call_z0" not in arrays


def test_models_of_ones_own_are_to_be_given(tmp_path):
    """By their value: the file names the class, and imports nothing."""
    result = fa.integrate(OneSpring(2.0), np.ones((2, 2)), time=1.0, step=0.1)
    path = files.save(tmp_path / "mine", result)
    with pytest.raises(
        ValueError, match=r"model must be of a class of fastaff, got own_models.OneSpring\. Pass model="
    ):
        files.recipe(path)
    same(result, files.recipe(path, model=OneSpring(2.0)).run())


class HenonHeiles(OneSpring):
    """A name that the package has."""

    __slots__ = ()


def test_functions_are_to_be_given(tmp_path):
    def make(K):
        body = fa.Body(fa.NeoHookean(K=K))
        return body, fa.energy_sample(body, energy=1.5, section=fa.AlphaTurning(), orbits=3, p_eta=0.3, p_gamma=0.2).z0

    scan = fa.chaotic_fraction(make, [[1.0, 2.0]], time=10.0, step=0.05)
    path = files.save(tmp_path / "scan", scan)
    with pytest.raises(ValueError, match=r"give model, as in recipe\(path, model=...\)"):
        files.recipe(path)
    same(scan, files.recipe(path, model=make).run())


def test_what_was_put_together_by_hand_has_no_call(tmp_path):
    grid = fa.sections.EnergyGrid(
        Z4, np.zeros((1, 1), np.int64), np.zeros((1, 1), bool), (np.zeros(2), np.zeros(2)), ("a", "b"), 1.0
    )
    with pytest.raises(ValueError, match="must have the call of its result"):
        files.recipe(files.save(tmp_path / "grid", grid))


def test_a_forged_file_executes_nothing(tmp_path):
    """Names of classes outside of the list, and formulas that are no mathematics."""
    path = files.save(tmp_path / "run", fa.integrate(OWN, Z4, time=2.0, step=0.1))
    arrays, metadata = files.contents(path)
    body = metadata["call"]["arguments"]["model"]
    code = ["__import__('os')", None, ["a"], ["x", "y"], "unit"]
    own = encoded(HenonHeiles(2.0))
    assert own == {"class": "HenonHeiles", "module": __name__, "k": 2.0}
    for forged in (own, {"class": "Path", "x": 1}, {"class": "eval"}, {**body, "formula": code}):
        metadata["call"]["arguments"]["model"] = forged
        np.savez(tmp_path / "forged.npz", **arrays, metadata=np.array(json.dumps(metadata)))
        with pytest.raises(ValueError, match=r"must be of a class of fastaff|text"):
            files.recipe(tmp_path / "forged.npz")


def test_data_of_arguments():
    assert encoded((1, 2.5, None, True, "x", np.float64(2), np.int32(3))) == [1, 2.5, None, True, "x", 2.0, 3]
    assert encoded(-np.inf) == {"float": "-inf"}
    assert encoded(fa.charts.TWO_POLAR) == {"chart": "two-polar"}
    assert encoded(fa.KAHAN_LI8) == {"scheme": "KAHAN_LI8"}
    with pytest.raises(TypeError):
        encoded(print)
    assert fa.integrate(OWN, Z4, time=1.0, step=0.1, callback=lambda done: None).call.missing == ()
    assert isinstance(fa.integrate(OWN, Z4, time=1.0, step=0.1).call, Call)


def public_functions():
    """Every public name that a recipe looks up, with whether results have it as their call."""
    homes = (fa, fa.runs, fa.frequencies, fa.sections, fa.chaos, fa.periodic, fa.tori, fa.quantum)
    return {name: is_recorded(getattr(home, name)) for home in homes[::-1] for name in home.__all__}


def test_recipes_call_analyses_alone(tmp_path, monkeypatch):
    """Whatever function a forged file names: none that is no analysis is called, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    arrays, metadata = files.contents(files.save("run", fa.integrate(fa.HenonHeiles(), Z4[:, 0], time=1.0, step=0.1)))
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "x.npz").write_text("precious")
    names = public_functions()
    assert {"integrate", "poincare_map", "frequency_map", "chaos_map", "spectrum"} <= {n for n in names if names[n]}
    others = [name for name in names if not names[name]]
    assert {"save", "load", "run", "resume", "rerun", "explore", "hamiltonian", "doctor"} & set(names) <= set(others)
    before = sorted(tmp_path.rglob("*"))
    for name in (*others, "is_recorded", "__import__", "os.system", "files", "Recipe", "", "recipe"):
        arguments = {"path": "elsewhere/x", "result": {"scheme": "KAHAN_LI8"}, "out": "elsewhere/x", "overwrite": True}
        metadata["call"] = {"function": name, "arguments": arguments, "missing": []}
        np.savez(tmp_path / "run.npz", **arrays, metadata=np.array(json.dumps(metadata)))
        with pytest.raises(ValueError, match="is no analysis of fastaff"):
            files.recipe(tmp_path / "run.npz")
        with pytest.raises(ValueError, match="is no analysis of fastaff"):
            files.Recipe(name, arguments).run()
    assert sorted(tmp_path.rglob("*")) == before
    assert (tmp_path / "elsewhere" / "x.npz").read_text() == "precious"


@pytest.mark.parametrize("seed", range(2 * TIMES))
def test_damaged_calls_are_refused_by_name(seed, tmp_path):
    """Parts of a call exchanged for others at random: a ValueError that names the file, or a recipe."""
    rng = random.Random(f"calls {seed}")
    arrays, metadata = files.contents(files.save(tmp_path / "run", fa.integrate(fa.HenonHeiles(), Z4, time=1.0)))
    whole = json.dumps(metadata["call"])
    odd = [None, 1, -2.5, "x", [], [1, "a"], {}, {"array": "z"}, {"array": "none"}, {"class": 3}, {"a": 1, "b": 2}]
    odd += [{"float": "x"}, {"scheme": "none"}, {"chart": []}, {"class": "Body", "x": 1}, {"array": {"array": []}}]
    for _ in range(60):
        call = json.loads(whole)
        at, key = call, rng.choice(list(call))
        while isinstance(at[key], dict) and at[key] and rng.random() < 0.8:
            at, key = at[key], rng.choice(list(at[key]))
        at[key] = rng.choice(odd)
        metadata["call"] = call
        np.savez(tmp_path / "forged.npz", **arrays, metadata=np.array(json.dumps(metadata)))
        with contextlib.suppress(ValueError):
            files.recipe(tmp_path / "forged.npz")
