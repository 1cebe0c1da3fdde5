"""Short forms of arguments give the bits and the recipe of the full ones; wrong ones say what there is."""

import inspect
import json
import math
import re

import battery
import numpy as np
import pytest
import shared_systems
from comparison import same
from hypothesis import given
from hypothesis import strategies as st

import fastaff as fa
from fastaff.chaos.indicators import INDICATORS, indicators_of
from fastaff.core.names import named, spelled
from fastaff.jobs.system import MODELS
from fastaff.results.calls import encoded
from fastaff.runs.schemes.catalogue import SCHEMES
from fastaff.systems.formulas.number import number
from fastaff.systems.formulas.section_text import section_forms, section_in_words, section_named
from fastaff.systems.models.mechanics import system_of
from fastaff.systems.models.sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Hyperplane

HH, BODY = battery.HH, battery.BODY

# --- numbers --------------------------------------------------------------------------------------------------------


@given(st.integers(-(10**6), 10**6), st.integers(1, 10**6), st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_those_of_floats(a, b, x):
    assert number("n", f"{a}/{b}") == a / b
    assert number("n", repr(x)) == x
    assert number("n", f" {b}*pi/7 ") == b * math.pi / 7


@pytest.mark.parametrize(
    ("text", "value"),
    [("pi/2", math.pi / 2), ("1e-3", 1e-3), ("-1/6", -1 / 6), ("sqrt(2)/2", math.sqrt(2) / 2), ("2**-3", 0.125)],
)
def test_formulas_of_numbers(text, value):
    assert number("n", text) == value


@pytest.mark.parametrize(
    "text",
    [
        *["", "x", "1/0", "nan", "inf", "1e999", "sqrt(-1)", "(-8)**(1/3)"],
        *["1,5", "1.5.2", "3 4", "1;2", "[1]", "\x00"],
        *["__import__('os')", "exit()", "1 if 1 else 2", "9**9**9", "(" * 300 + "1" + ")" * 300, "\ud800"],
    ],
)
def test_what_is_no_number(text):
    with pytest.raises(ValueError, match=r"^n must be"):
        number("n", text)


def test_degrees():
    with pytest.raises(ValueError, match=r"angles are in radians: 45\*pi/180"):
        number("p", "45deg")


# --- names ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("names", [SCHEMES, INDICATORS, MODELS], ids=["schemes", "indicators", "models"])
def test_names_in_any_spelling(names):
    for name in names:
        plain = name.replace("_", "").replace("-", "")
        for text in (name, name.upper(), name.title(), name.replace("_", " "), name.replace("_", "-"), plain):
            assert named("it", text, names) == spelled(text, names) == name
    for wrong in ("", "x" * 500, "\n", next(iter(names)) + "q"):
        assert spelled(wrong, names) == wrong
        with pytest.raises(ValueError, match=r"^it must be one of ") as caught:
            named("it", wrong, names)
        assert len(str(caught.value)) < 600
    assert f"Did you mean {next(iter(names))}?" in str(caught.value)


def test_names_that_differ_in_capitals_alone():
    assert [named("c", text, ("x", "X")) for text in "xX"] == ["x", "X"]


# --- sections -------------------------------------------------------------------------------------------------------

SECTIONS = [
    (BODY, "alpha-turning", AlphaTurning()),
    (BODY, "Alpha Turning", AlphaTurning()),
    (BODY, "p_beta = 0", BetaTurning()),
    (BODY, "beta_turning", BetaTurning()),
    (BODY, "alpha=1/4", AlphaEquals(0.25)),
    (BODY, "beta=0.2", BetaEquals(0.2)),
    (BODY, "Area = 2", AreaEquals(2.0)),
    (HH, "x=0", Hyperplane((1.0, 0.0, 0.0, 0.0))),
    (HH, "y=-1e-3", Hyperplane((0.0, 1.0, 0.0, 0.0), -1e-3)),
    (fa.reduced_body(BODY, p_eta=0.3, p_gamma=0.2), "beta=0.5", Hyperplane((0.0, 1.0, 0.0, 0.0), 0.5)),
    (fa.reduced_body(BODY, p_eta=0.3, p_gamma=0.2), "p_alpha=0", Hyperplane((0.0, 0.0, 1.0, 0.0))),
    (fa.reduced_body(BODY, p_eta=0.3, p_gamma=0.2), "beta-turning", Hyperplane((0.0, 0.0, 0.0, 1.0))),
    (HH, "p_x = 1/4", Hyperplane((0.0, 0.0, 1.0, 0.0), 0.25)),
    (fa.models.DoublePendulum(), "p2=0", Hyperplane((0.0, 0.0, 0.0, 1.0))),
]


@pytest.mark.parametrize(("model", "text", "section"), SECTIONS)
def test_sections_of_texts(model, text, section):
    found = section_named(text, system_of(model))
    assert type(found) is type(section)
    assert found == section
    assert section_named(text, system_of(model), -1) == section._replace(direction=-1)
    again = section_in_words(section, system_of(model))
    assert section_named(again, system_of(model)) == section


def test_sections_that_no_text_describes():
    assert section_in_words(Hyperplane((1.0, 1.0, 0.0, 0.0)), system_of(HH)).startswith("Hyperplane(")
    one = Hyperplane((0.0,) * 4 + (1.0,) + (0.0,) * 3)
    assert section_in_words(one, system_of(BODY)).startswith("Hyperplane(")
    assert section_in_words(battery.own_case, system_of(HH)) == repr(battery.own_case)


@pytest.mark.parametrize(
    ("model", "text", "said"),
    [
        (BODY, "x=0", "section must be one of alpha-turning, beta-turning, alpha=c, beta=c, area=c, got 'x=0'"),
        (HH, "alpha-turning", "section must be one of x=c, y=c, got 'alpha-turning'"),
        (HH, "px=0", "section must be one of x=c, y=c, got 'px=0'. Did you mean p_x=c?"),
        (HH, "p_x=", "section p_x=c needs a number for c, such as p_x=0.2, got 'p_x='"),
        (HH, "p_z=0", "section must be one of x=c, y=c, got 'p_z=0'. Use fa.Hyperplane(normal, offset)"),
        (HH, "x", "section must be one of x=c, y=c, got 'x'. Did you mean x=c?"),
        (HH, "x=", "section x=c needs a number for c, such as x=0.2, got 'x='"),
        (HH, "x=y", "section x=c: c must be a number such as 1.5, 1/6, pi/2 or 1e-3, got 'y'"),
        (BODY, "alfa-turning", "Did you mean alpha-turning?"),
    ],
)
def test_texts_of_no_section(model, text, said):
    z0 = battery.Z4 if model is HH else battery.Z8
    with pytest.raises(ValueError, match=re.escape(said)):
        fa.poincare_map(model, z0, section=text, crossings=1, max_time=1.0)
    assert all(form.endswith("=c") or "turning" in form for form in section_forms(system_of(model)))


# --- functions ------------------------------------------------------------------------------------------------------

FORMS = {
    "section": [("x=0", battery.X), ("x = 0/3", battery.X)],
    "scheme": [("kahan li8", fa.KAHAN_LI8), ("KAHAN_LI8", fa.KAHAN_LI8)],
    "fallback": [("dop853", fa.DOP853)],
    "indicators": [
        (fa.SALI(), (fa.SALI(),)),
        ("sali", (fa.SALI(),)),
        ("GALI-2, megno", (fa.GALI(2), fa.MEGNO())),
        (["sali", fa.MEGNO(threshold=6.0)], (fa.SALI(), fa.MEGNO(threshold=6.0))),
    ],
    "names": [("lam", ("lam",))],
    "z0": [(battery.result("grid"), battery.result("grid").z0)],
    "axes": [(np.array([1.0]), (np.array([1.0]),)), ([1.0], ([1.0],))],
}
OTHERS = [
    *(("axes", name) for name in ("energy_grid", "energy_sample", "resonance_web")),  # always two
    *(("z0", name) for name in ("continuation", "fit_torus", "action_angles")),  # of one orbit, of a body
    *[("names", "resonances"), ("scheme", "rerun")],
    *[("z0", "basins"), ("scheme", "basins")],  # of what is dissipative, in the battery a map
]
TAKEN = [
    (name, argument)
    for name in battery.CALLS
    if name in fa.__all__ and inspect.isfunction(getattr(fa, name))
    for argument in FORMS
    if argument in inspect.signature(getattr(fa, name)).parameters and (argument, name) not in OTHERS
]


def test_all_functions_with_such_an_argument_are_tried():
    assert len(TAKEN) >= 20
    assert {name for name, _ in TAKEN} >= {"poincare_map", "energy_grid", "chaos_map", "continuation", "fit_torus"}


@pytest.mark.parametrize(("name", "argument"), TAKEN)
def test_short_forms_are_the_full_ones(name, argument):
    base = battery.base(name)
    for short, full in FORMS[argument]:
        body = {"model": HH} if "model" in base and argument == "z0" else {}
        one, other = (battery.CALLS[name][0](**{**base, **body, argument: value}) for value in (short, full))
        same(one, other)
        assert repr(one.call) == repr(other.call)


def test_starts_by_position():
    grid = battery.result("grid")
    one, other = (fa.integrate(HH, z0, time=1.0) for z0 in (grid, grid.z0))
    same(one, other)
    assert repr(one.call) == repr(other.call)
    same(fa.Job(model=HH, initial_conditions=grid, integrate=battery.MOTION).initial_conditions, grid.z0)
    same(
        fa.Job(model=HH, initial_conditions=grid.z0[:, 0], integrate=battery.MOTION).initial_conditions, grid.z0[:, :1]
    )


def test_indicators_that_are_none():
    assert indicators_of(3) == 3
    with pytest.raises(ValueError, match=r"indicators must be one of megno, .*got 'salli'\. Did you mean sali\?"):
        fa.chaos_map(HH, battery.Z4, time=1.0, indicators="megno,salli")
    with pytest.raises(TypeError, match=r"got <class '.*SALI'>\. Use SALI\(\)"):
        fa.chaos_map(HH, battery.Z4, time=1.0, indicators=fa.SALI)


# --- jobs -----------------------------------------------------------------------------------------------------------


def test_jobs_of_plain_values():
    short = fa.Job(
        model="Neo Hookean",
        energy_surface={"energy": "3/2", "p_eta": "0.3", "section": "beta=1/5", "direction": -1},
        initial_conditions={"grid": (3, 4), "q_range": [0.1, 1]},
        options={"scheme": "kahan-li8"},
        chaos_map={"time": "10*pi", "indicators": ("SALI", "gali 3")},
        frequency_map={"time": 20},
    )
    jobs = fa.jobs
    full = fa.Job(
        model=jobs.Model(model="neo-hookean"),
        energy_surface=jobs.EnergySurface(energy=1.5, p_eta=0.3, section="beta=0.2", direction="-1"),
        initial_conditions=jobs.InitialConditions(grid="3x4", q_range="0.1:1"),
        options=jobs.RunOptions(scheme="KAHAN_LI8"),
        chaos_map=jobs.ChaosOptions(time=10 * math.pi, indicators="sali,gali_3"),
        frequency_map=jobs.FrequencyOptions(time=20.0),
    )
    assert short == full
    assert short.text() == full.text()
    assert fa.Job.parsed(full.text()) == full


def test_numbers_as_texts_of_a_job_file():
    job = fa.Job.parsed(
        '[energy_surface]\nenergy = "1/6"\n[initial_conditions]\nq_range = "0:pi/4"\n[integrate]\ntime = "2*pi"\n'
    )
    assert (job.energy_surface.energy, job.integrate.time) == (1 / 6, 2 * math.pi)
    assert job.initial_conditions.ranges()[0] == (0.0, math.pi / 4)
    with pytest.raises(ValueError, match=r"job: \[energy_surface\] energy must be a number such as 1.5, 1/6"):
        fa.Job.parsed('[energy_surface]\nenergy = "exit()"\n[integrate]\ntime = 1\n')


# --- what helps in one reading ---------------------------------------------------------------------------------------

SURFACE = {"p_eta": 0.3, "p_gamma": 0.2}


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: fa.integrate(fa.Body(fa.NeoHookean), battery.Z8, time=1.0),
            "model.potential must be a NamedTuple such as",
        ),
        (
            lambda: fa.integrate(fa.NeoHookean, battery.Z8, time=1.0),
            "model must be a model such as Body(Hyperelastic()) or",
        ),
        (
            lambda: fa.integrate(fa.NeoHookean(), battery.Z8, time=1.0),
            "model NeoHookean(G=1.0, K=2.0) is a potential. Use",
        ),
        (
            lambda: fa.integrate(fa.HenonHeiles, battery.Z4, time=1.0),
            "model must be a model such as Body(Hyperelastic()) or",
        ),
        (lambda: fa.Body(HH), "potential must be a potential of A and B (value, slopes,"),
        (
            lambda: fa.Body(potential=fa.affine_body("gent", G=1.0, Jm=30.0, K=2.0), mu=2.0),
            "potential must be a potential of A and B (value, slopes,",
        ),
        (
            lambda: fa.integrate("neo-hookean", battery.Z8, time=1.0),
            "model must be a model such as Body(Hyperelastic()) or",
        ),
        (
            lambda: fa.integrate(BODY, battery.Z8.T, time=1.0),
            "z0 must have shape (8,) or (8, orbits) for Body, rows a1, a2,",
        ),
        (
            lambda: fa.integrate(BODY, np.ones((8, 2, 3)), time=1.0),
            "z0 must have shape (8,) or (8, orbits) for Body, rows a1, a2,",
        ),
        (lambda: fa.constants_of_motion(BODY, battery.result("grid")), "give its .z0"),
        (lambda: fa.integrate(HH, battery.Z4, t=1.0), "integrate() got an unexpected keyword argument 't'. Did you"),
        (lambda: fa.integrate(HH, battery.Z4, time=1.0, dt=0.1), "Did you mean step?"),
        (lambda: fa.integrate(HH, battery.Z4, time=1.0, dtype="f4"), "numbers are doubles; accuracy="),
        (lambda: fa.chaos_map(HH, battery.Z4, time=1.0, chunks=4), "fastaff.run(fastaff.Job(...), store) goes by"),
        (lambda: fa.frequency_map(HH, battery.Z4, time=1.0, n_jobs=4), "threads= share a call"),
        (lambda: fa.integrate(HH, battery.Z4, time=1.0, progress=True), "fastaff.show_progress(False)"),
        (lambda: fa.integrate(HH, battery.Z4, 1.0), "integrate() takes 2 positional arguments but 3 were given; by"),
        (lambda: fa.integrate(HH, battery.Z4), "integrate() missing 1 required keyword-only argument: 'time'."),
        (lambda: fa.energy_grid(HH, E=0.1), "Did you mean energy?"),
        (
            lambda: battery.cut_by(lambda: AlphaTurning),
            "section must be a text such as 'alpha-turning' or a section such as",
        ),
        (lambda: battery.cut_by(AlphaTurning, HH, battery.Z4), "such as x=c, y=c"),
        (lambda: fa.poincare, "Did you mean poincare_map?"),
        (lambda: fa.NeoHook, "Did you mean NeoHookean?"),
    ],
)
def test_what_to_write_instead(call, said):
    with pytest.raises((TypeError, ValueError, AttributeError)) as caught:
        call()
    assert said in str(caught.value)


# --- the section of a launch set ------------------------------------------------------------------------------------

AXES = (np.linspace(-0.3, 0.4, 4), np.linspace(-0.2, 0.3, 3))
CHAIN = shared_systems.springs(np.array([[2, -1, 0], [-1, 2, -1], [0, -1, 2]]))
LAUNCHES = {
    "sample": lambda: fa.energy_sample(HH, energy=0.1, orbits=7, section="x=0.05", seed=4),
    "grid": lambda: fa.energy_grid(HH, energy=0.1, axes=AXES, section=Hyperplane((0.0, 1.0, 0.0, 0.0), 0.02, -1)),
    "rows": lambda: fa.energy_grid(HH, energy=0.1, axes={"y": AXES[0], "p_y": AXES[1]}, section="x=0"),
    "volume": lambda: fa.energy_sample(CHAIN, energy=0.2, orbits=5, section="y=0.01"),
    "body": lambda: fa.energy_sample(BODY, energy=3.0, orbits=5, section="beta-turning"),
}


@pytest.mark.parametrize("launch", LAUNCHES)
def test_a_launch_set_knows_its_section(launch, tmp_path):
    """The same map, recipe too, as by naming it again, also after a file; a section that is named is taken."""
    starts = LAUNCHES[launch]()
    model = {"volume": CHAIN, "body": BODY}.get(launch, HH)
    said = {"crossings": 3, "max_time": 60.0, "step": 0.05}
    own = starts.call.arguments["section"]
    named = fa.poincare_map(model, starts.z0, section=starts.section, **said)
    assert encoded(starts.section) == own
    assert named.counts.all()
    for set_ in (starts, fa.load(starts.save(tmp_path / "starts")), starts[:]):
        found = fa.poincare_map(model, set_, **said)
        assert found.section == starts.section
        assert found.call.arguments["section"] == own
        np.testing.assert_array_equal(found.points, named.points)
        np.testing.assert_array_equal(found.times, named.times)
    other = starts.section._replace(direction=-starts.section.direction)
    assert fa.poincare_map(model, starts, section=other, **said).section == other
    with pytest.raises(TypeError, match="section must be"):
        fa.poincare_map(model, starts.z0, **said)


def test_other_verbs_take_the_section_of_a_launch_set():
    grid = fa.energy_grid(HH, energy=0.1, axes=([0.25, 0.3], [0.0]), section="x=0")
    for verb, said in ((fa.periodic_orbits, {}), (fa.find_periodic_orbits, {"max_crossings": 1})):
        found, named = verb(HH, grid, **said), verb(HH, grid.z0, section="x=0", **said)
        np.testing.assert_array_equal(found.z, named.z)
        assert found.section == grid.section
    with pytest.raises(TypeError, match="section must be"):
        fa.poincare_map(HH, fa.energy_sample(HH, energy=0.1, orbits=2), crossings=2, max_time=20.0)
    kicked = fa.models.StandardMap(0.9)
    starts = fa.energy_sample(kicked, axes={"x": (0.0, 6.0), "p": (0.0, 1.0)}, orbits=3)
    assert fa.poincare_map(kicked, starts, crossings=2).section is starts.section is None


def test_files_from_before_launch_sets_knew_it(tmp_path):
    """Are read; one that lacks a field without a default is not."""
    grid = LAUNCHES["grid"]()
    arrays, metadata = fa.files.contents(grid.save(tmp_path / "grid"))
    for name, known in (("section", True), ("energy", False)):
        content = metadata["content"] | {
            "fields": {k: v for k, v in metadata["content"]["fields"].items() if k != name}
        }
        np.savez(tmp_path / "old.npz", **arrays, metadata=np.array(json.dumps(metadata | {"content": content})))
        if known:
            assert fa.load(tmp_path / "old.npz").section is None
        else:
            with pytest.raises(ValueError, match="missing 1 required positional argument: 'energy'"):
                fa.load(tmp_path / "old.npz")
