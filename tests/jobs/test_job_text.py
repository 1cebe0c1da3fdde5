"""Ten thousand wrong jobs, as values and as TOML: each is refused in one line that says where and why; a right one
comes back as it was written.
"""

import datetime
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fastaff as fa
from fastaff.cli.main import main
from fastaff.jobs import (
    ChaosOptions,
    EnergySurface,
    FrequencyOptions,
    InitialConditions,
    IntegrateOptions,
    Job,
    Model,
    PoincareOptions,
    RunOptions,
)
from fastaff.jobs.job import TABLES, _hints
from fastaff.jobs.store import Store

GOOD = [
    """[energy_surface]
energy = 1.5
p_eta = 0.3
[initial_conditions]
grid = "4x4"
[frequency_map]
time = 10.0
""",
    """chunk = 7
[model]
model = "henon-heiles"
lam = 0.9
[energy_surface]
energy = 0.1
section = "x=0.01"
direction = -1
[initial_conditions]
orbits = 20
seed = 3
[options]
step = 0.1
scheme = "KAHAN_LI8"
threads = 2
[poincare]
crossings = 3
max_time = 100.0
[chaos_map]
time = 5.0
indicators = ["megno", "sali"]
early_stop = true
""",
    """[model]
hamiltonian = "a*x**2 + b*y**2"
parameter = {a = 1.0, b = 2}
coordinates = "x y"
domain = "9 - x"
[energy_surface]
energy = 1
[initial_conditions]
grid = [3, 4]
q_range = [-0.1, 0.2]
p_range = "-0.1:0.1"
[options]
accuracy = 1e-9
[integrate]
time = 1.0
samples = 3
[action_angles]
""",
]
WORDS = [
    *("", "x", "energy", "ENERGY", "energi", "a.b", "ü", "☃", "a\nb", "\x00", "--energy", "None", "nan", "1e400"),
    *("../..", "$(x)", "%s", "{0}", "'", '"', "[", "x" * 3000, "\u202e", "\x7f", "😀"),
]
NUMBERS = [
    *(0, -1, 1, 2**53, 2**63, 2**64, 10**18, 10**40, -(10**18), 0.0, -0.0, 1e-320, 1e308, -1e308, float("nan")),
    *(float("inf"), -float("inf"), 0.5, 1e-18),
]
OTHERS = [
    *(True, False, [], [[]], [1, "a"], [1.0, 2.0], ["a"], {}, {"a": {}}, {"a": 1}, datetime.date(2020, 1, 1)),
    *(datetime.datetime(2020, 1, 1), [[[1]]], {"a": [{"b": 1}]}),
]


class Loud:
    """What cannot be shown."""

    def __repr__(self):
        raise ZeroDivisionError


WILD = [
    None,
    1j,
    b"x",
    object(),
    int,
    len,
    np.array([1.0]),
    np.array(1.0),
    np.float32(1),
    np.datetime64("2020"),
    {1, 2},
    range(3),
    (i for i in ()),
    (1.0, 2.0),
    np.ma.masked,
    np.nan,
    10**400,
    "\ud800",
    Ellipsis,
    lambda: 1,
    Loud(),
]


def toml(value):
    """Any plain value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        signs = "".join(f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c for c in value.replace("\\", "\\\\"))
        return '"' + signs.replace('"', '\\"') + '"'
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(key)} = {toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, datetime.date):
        return value.isoformat()
    return repr(value)


def outcome(text, plan=False):
    """What becomes of a text: a job, or the sentence that refuses it."""
    try:
        job = Job.parsed(text, "job.toml")
    except (ValueError, TypeError) as problem:
        said = str(problem)
        assert said.startswith("job.toml"), said
        assert "\n" not in said
        assert said.isprintable()
        assert len(said) < 1000
        return said
    assert Job.parsed(job.text()) == job
    assert Job.parsed(job.text()).text() == job.text()
    return job


def made(**given):
    """A job of Python's values, or the sentence that refuses it."""
    try:
        return Job(**given), None
    except (ValueError, TypeError) as problem:
        return None, str(problem)


def mutated(rng, text):
    """The text with some of its signs, lines or words changed."""
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(text) + 1)
        kind = rng.randrange(8)
        if kind == 0:
            text = text[:at] + rng.choice(WORDS) + text[at:]
        elif kind == 1:
            text = text[:at] + text[at + rng.randint(1, 9) :]
        elif kind == 2:
            lines = text.split("\n")
            rng.shuffle(lines)
            text = "\n".join(lines)
        elif kind == 3:
            text = text[:at] + chr(rng.choice([*range(32, 127), 0, 7, 10, 13, 0xFEFF, 0x2028, 0x10FFFF])) + text[at:]
        elif kind == 4:
            lines = text.split("\n")
            lines.insert(rng.randrange(len(lines)), rng.choice(lines))
            text = "\n".join(lines)
        elif kind == 5:
            lines = text.split("\n")
            del lines[rng.randrange(len(lines))]
            text = "\n".join(lines)
        elif kind == 6:
            text = text[:at]
        else:
            lines = text.split("\n")
            k = rng.randrange(len(lines))
            value = rng.choice([*WORDS, *NUMBERS, *OTHERS])
            lines[k] = lines[k].partition("=")[0] + "= " + toml(value)
            text = "\n".join(lines)
    return text


def several(seed, count):
    rng = random.Random(seed)
    kinds = [0, 0]
    for _ in range(count):
        text = mutated(rng, rng.choice(GOOD))
        kinds[isinstance(outcome(text), Job)] += 1
    return kinds


def test_changed_texts():
    wrong, right = several(1, 2500)
    assert wrong > 5 * right > 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 6))
def test_more_changed_texts(seed):
    several(seed, 5000)


@given(st.text(max_size=300))
def test_any_text(text):
    assert isinstance(outcome(text), str)


@given(st.binary(max_size=300))
def test_any_bytes(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "job.toml"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"job\.toml") as caught:
        Job.read(path)
    assert "\n" not in str(caught.value)


FIELDS = [(table, key) for table, kind in TABLES.items() for key in _hints(kind) if table != "scan"]


@pytest.mark.parametrize(("table", "key"), FIELDS)
def test_each_field_takes_what_it_takes(table, key):
    """Every value of another kind is refused by table and key, in a text and in Python."""
    taken = 0
    for value in [*WORDS, *NUMBERS, *OTHERS]:
        needed = "[integrate]\ntime = 1.0\n" if table != "integrate" else "time = 1.0\n" * (key != "time")
        head = f"[{table}]\n{needed}" if table == "integrate" else f"{needed}[{table}]\n"
        text = f"{head}{key} = {toml(value)}\n"
        found = outcome(text)
        taken += isinstance(found, Job)
        assert isinstance(found, Job) or (f"[{table}]" in found and key in found) or "no TOML" in found, found
    assert taken < 50


@pytest.mark.parametrize(("table", "key"), FIELDS)
def test_each_field_in_python(table, key):
    for value in WILD:
        given = {"time": 1.0} if table == "integrate" else {}
        job, said = made(**{"integrate": IntegrateOptions(time=1.0), table: TABLES[table](**{**given, key: value})})
        assert said is None or (f"{table}.{key}" in said and "\n" not in said)
        assert job is None or Job.parsed(job.text()) == job


@pytest.mark.parametrize("name", [*TABLES, "chunk"])
def test_each_table_in_python(name):
    for value in [*WILD, *WORDS, *NUMBERS, *OTHERS]:
        _, said = made(**{"frequency_map": FrequencyOptions(), name: value})
        assert said is None or name in said or "must have an analysis" in said or name == "model"
        assert said is None or len(said) < 600


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[energy_surface]\nenergi = 1.0", "Did you mean energy"),
        ("[energy_surfac]\nenergy = 1.0", "Did you mean energy_surface"),
        ("energy_surface = 1", "must be a table"),
        ("[[energy_surface]]\nenergy = 1", "must be a table"),
        ("[integrate]", "needs 'time'"),
        ("[energy_surface]\nenergy = 1", "must have an analysis"),
        ("", "must have an analysis"),
        ("chunk = 0\n[action_angles]", "chunk must be at least 1"),
        ("chunk = 1e3\n[action_angles]", "chunk must be a whole number"),
        (f"chunk = 1{'0' * 30}\n[action_angles]", "chunk must be at most"),
        ("[energy_surface]\nenergy = nan", "energy must be finite"),
        (f"[energy_surface]\nenergy = 1{'0' * 400}", "energy must be finite"),
        (f"[energy_surface]\nenergy = {'9' * 6000}", "job.toml"),
        ("a = " + "[" * 5000 + "]" * 5000, "within one another"),
        ("[energy_surface]\nenergy = " + "[" * 900 + "]" * 900, "job.toml"),
        (f"[model]\nparameter.{'.'.join('a' * 3000)} = 1", "job.toml"),
        ("[integrate]\ntime = 1\n[integrate]\ntime = 2", "no TOML"),
        ("[integrate]\ntime = 1\n[options]\nscheme = 3", "scheme"),
        ("\x00", "no TOML"),
    ],
)
def test_what_is_said(text, said):
    found = outcome(text)
    assert isinstance(found, str) or said == "scheme"
    assert said in str(found)


# --- plans --------------------------------------------------------------------------------------------------------

HH = Model(model="henon-heiles")
LOW = EnergySurface(energy=0.1)
BOX = {"q_range": "-0.1:0.1", "p_range": "-0.1:0.1"}
WRONG = {
    "grid of a million rows": (InitialConditions(grid="1000000x1000000", **BOX), {}, "--grid asks for|grid asks for"),
    "grid of one row": (InitialConditions(grid="1x1000000000000", **BOX), {}, "grid asks for"),
    "grid of one column": (InitialConditions(grid="1000000000000x1", **BOX), {}, "grid asks for"),
    "grid beyond numbers": (InitialConditions(grid=f"{10**30}x2", **BOX), {}, "grid asks for"),
    "orbits": (InitialConditions(orbits=10**15), {}, "orbits asks for"),
    "orbits beyond numbers": (InitialConditions(orbits=10**30), {}, "orbits asks for"),
    "crossings": (
        InitialConditions(grid="2x2", **BOX),
        {"poincare": PoincareOptions(crossings=10**12)},
        "crossings asks for|max_time",
    ),
    "samples": (
        InitialConditions(grid="2x2", **BOX),
        {"integrate": IntegrateOptions(time=1.0, samples=10**12)},
        "samples asks for",
    ),
    "time": (
        InitialConditions(grid="2x2", **BOX),
        {"integrate": IntegrateOptions(time=1e300)},
        "no run comes to its end",
    ),
    "negative time": (InitialConditions(grid="2x2", **BOX), {"integrate": IntegrateOptions(time=-1.0)}, "time must be"),
    "no time": (
        InitialConditions(grid="2x2", **BOX),
        {"frequency_map": FrequencyOptions(time=0.0)},
        "time must be positive",
    ),
    "indicators": (
        InitialConditions(grid="2x2", **BOX),
        {"chaos_map": ChaosOptions(indicators="megno,")},
        "indicators must be one of",
    ),
    "both times": (
        InitialConditions(grid="2x2", **BOX),
        {"chaos_map": ChaosOptions(time=1.0, returns=2.0)},
        "not both",
    ),
    "accuracy": (
        InitialConditions(grid="2x2", **BOX),
        {"chaos_map": ChaosOptions(time=1.0), "options": RunOptions(accuracy=1e-9)},
        "accuracy",
    ),
    "step": (InitialConditions(grid="2x2", **BOX), {"options": RunOptions(step=0.0)}, "step must be positive"),
    "threads": (InitialConditions(grid="2x2", **BOX), {"options": RunOptions(threads=0)}, "threads must be"),
    "scheme": (InitialConditions(grid="2x2", **BOX), {"options": RunOptions(scheme="EULER")}, "scheme"),
    "seed": (InitialConditions(orbits=5, seed=-1), {}, "seed must be at least 0"),
    "no orbits": (InitialConditions(orbits=0), {}, "orbits must be at least 1"),
    "grid and orbits": (InitialConditions(orbits=5, grid="2x2"), {}, "not both"),
    "grid of text": (InitialConditions(grid="axb"), {}, "grid must be"),
    "range": (InitialConditions(grid="2x2", q_range="1:0"), {}, "q_range must be LOW:HIGH"),
    "range of nan": (InitialConditions(grid="2x2", q_range="nan:1"), {}, "q_range must be LOW:HIGH"),
    "range beyond the energy": (
        InitialConditions(grid="2x2", q_range="0.6:0.7", p_range="5:6"),
        {},
        "energy reaches no point",
    ),
    "energy": (InitialConditions(), {"energy_surface": EnergySurface()}, "energy is required"),
    "energy below": (
        InitialConditions(),
        {"energy_surface": EnergySurface(energy=-1.0)},
        "at least the local minimum 0",
    ),
    "energy that is huge": (InitialConditions(), {"energy_surface": EnergySurface(energy=1e300)}, "q_range"),
    "momentum": (InitialConditions(), {"energy_surface": EnergySurface(energy=0.1, p_eta=1.0)}, "p_eta"),
    "section": (
        InitialConditions(),
        {"energy_surface": EnergySurface(energy=0.1, section="z=1")},
        "section must be one of",
    ),
    "section of nan": (
        InitialConditions(),
        {"energy_surface": EnergySurface(energy=0.1, section="x=nan")},
        "finite|nan",
    ),
    "section of a body": (
        InitialConditions(),
        {"energy_surface": EnergySurface(energy=0.1, section="alpha=1")},
        "section must be one of x=c, y=c",
    ),
    "direction": (
        InitialConditions(),
        {"energy_surface": EnergySurface(energy=0.1, direction="++1")},
        "direction must be",
    ),
    "direction 2": (
        InitialConditions(),
        {"energy_surface": EnergySurface(energy=0.1, direction="2")},
        "direction must be",
    ),
    "model": (InitialConditions(), {"model": Model(model="henon")}, "Did you mean henon-"),
    "parameter of a model": (InitialConditions(), {"model": Model(model="harmonic", K=1.0)}, "not a parameter"),
    "parameter twice": (InitialConditions(), {"model": Model(hamiltonian="a*x", parameter=["a=1", "a=2"])}, "twice"),
    "parameter of nan": (InitialConditions(), {"model": Model(hamiltonian="a*x", parameter=["a=nan"])}, "finite|nan"),
    "code": (InitialConditions(), {"model": Model(hamiltonian="__import__('os').system('x')")}, "."),
    "power tower": (InitialConditions(), {"model": Model(hamiltonian="9**9**9**9**9*x")}, "."),
    "long formula": (InitialConditions(), {"model": Model(hamiltonian="(" * 3000 + "x" + ")" * 3000)}, "."),
    "masses": (InitialConditions(), {"model": Model(hamiltonian="x", parameter=["masses=1"])}, "masses"),
    "file and grid": (InitialConditions(file="a.npy", grid="2x2"), {}, "not both"),
    "file with a null": (InitialConditions(file="a\x00b"), {}, "file"),
    "mu": (InitialConditions(), {"model": Model(mu=-1.0)}, "mu"),
    "actions of a system that has none": (
        InitialConditions(grid="2x2", **BOX),
        {"action_angles": fa.jobs.ActionAngleOptions()},
        ".",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_jobs_that_do_not_fit(name, tmp_path):
    """By a sentence, before anything is computed or kept."""
    starts, given, said = WRONG[name]
    analysis = (
        {}
        if set(given) & {"poincare", "chaos_map", "frequency_map", "integrate", "action_angles"}
        else {"integrate": IntegrateOptions(time=0.1)}
    )
    job = Job(**{"model": HH, "energy_surface": LOW, "initial_conditions": starts, **analysis, **given})
    for store in (tmp_path / "s", None):
        with pytest.raises((ValueError, TypeError), match=said) as caught:
            fa.run(job, store)
        assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_units_that_are_more_than_all(tmp_path):
    job = Job(
        model=HH,
        energy_surface=LOW,
        initial_conditions=InitialConditions(grid="2x2", **BOX),
        integrate=IntegrateOptions(time=0.1),
        chunk=2**53,
    )
    assert fa.run(job, tmp_path / "s").complete
    for memory in (1.0, 0.0, -1.0, np.nan, "x", True):
        with pytest.raises((ValueError, TypeError), match=r"memory|chunk must be at most"):
            fa.run(job, tmp_path / "t", memory=memory)


@pytest.mark.parametrize(("text", "number"), [("16KiB", 16 * 1024), ("20 kB", 20e3), ("30000", 30000)])
def test_memory_may_have_a_unit(tmp_path, text, number):
    job = Job(
        model=HH,
        energy_surface=LOW,
        initial_conditions=InitialConditions(grid="9x9", **BOX),
        integrate=IntegrateOptions(time=0.1),
    )
    sizes = []
    for name, memory in (("text", text), ("number", number)):
        fa.run(job, tmp_path / name, memory=memory)
        sizes.append(Store(tmp_path / name).chunk)
    assert sizes[0] == sizes[1] < 50


@pytest.mark.parametrize(
    "array",
    [
        np.zeros(3),
        np.zeros((2, 3)),
        np.zeros((4, 0)),
        np.zeros((4, 2), object),
        np.array([["a"]]),
        np.zeros((4, 3, 2)),
        np.full((4, 2), 1j),
    ],
)
def test_starts_that_are_none(array, tmp_path):
    with pytest.raises((ValueError, TypeError), match="initial_conditions must be"):
        Job(model=HH, initial_conditions=array, integrate=IntegrateOptions(time=0.1)).plan()
    np.save(tmp_path / "z.npy", array, allow_pickle=True)
    with pytest.raises((ValueError, TypeError), match=r"initial_conditions must be|file .* must"):
        Job(
            model=HH,
            initial_conditions=InitialConditions(file=str(tmp_path / "z.npy")),
            integrate=IntegrateOptions(time=0.1),
        ).plan()


@pytest.mark.parametrize("content", [b"", b"\x93NUMPY", b"PK\x03\x04", b"not numbers", b"\x80\x04\x95"])
def test_files_that_hold_no_starts(content, tmp_path):
    (tmp_path / "z.npy").write_bytes(content)
    job = Job(
        model=HH,
        initial_conditions=InitialConditions(file=str(tmp_path / "z.npy")),
        integrate=IntegrateOptions(time=0.1),
    )
    with pytest.raises(ValueError, match=r"file .*z\.npy must be"):
        job.plan()
    with pytest.raises(OSError, match="nowhere"):
        Job(
            model=HH, initial_conditions=InitialConditions(file="nowhere.npy"), integrate=IntegrateOptions(time=0.1)
        ).plan()


# --- right ones ---------------------------------------------------------------------------------------------------


def test_files(tmp_path):
    with pytest.raises(OSError, match=r"nothing\.toml"):
        Job.read(tmp_path / "nothing.toml")
    with pytest.raises(OSError, match=r"."):
        Job.read(tmp_path)
    for text in GOOD:
        (tmp_path / "job.toml").write_text(text)
        job = Job.read(tmp_path / "job.toml")
        assert job == Job.parsed(job.text())
        (tmp_path / "job.toml").write_text("\n" + job.text().replace("\n", "\r\n"))
        assert Job.read(tmp_path / "job.toml") == job


REALS = st.floats(allow_nan=False, allow_infinity=False)
TEXTS = st.text(st.characters(exclude_categories=("Cs",)), max_size=12)


def some(kind):
    kinds = {float: REALS, int: st.integers(-(2**70), 2**70), bool: st.booleans(), str: TEXTS}
    fields = {}
    for name, hint in _hints(kind).items():
        text = str(hint)
        one = next((entry for key, entry in kinds.items() if key.__name__ in text), None)
        fields[name] = st.lists(TEXTS, max_size=3) if "list" in text else one
        if "None" in text:
            fields[name] |= st.none()
    return st.builds(kind, **fields)


@given(
    st.fixed_dictionaries({name: some(kind) for name, kind in TABLES.items() if name != "scan"}),
    st.none() | st.integers(1, 2**53),
)
def test_text_and_back(tables, chunk):
    job = Job(**tables, chunk=chunk)
    again = Job.parsed(job.text())
    assert again == job
    assert again.text() == job.text()
    assert repr(again) == repr(job)


def test_text_keeps_the_sign_of_zero():
    job = Job(energy_surface=EnergySurface(p_gamma=-0.0), integrate=IntegrateOptions(time=1.0))
    assert repr(Job.parsed(job.text())) == repr(job)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64, np.int8, int])
def test_numbers_of_numpy(kind):
    job = Job(
        energy_surface=EnergySurface(energy=kind(2)),
        integrate=IntegrateOptions(time=kind(3), samples=int(kind(1))),
        chunk=np.int64(5),
    )
    assert Job.parsed(job.text()) == job
    assert "np." not in job.text()


def test_each_front_end_names_an_option_its_own_way(here, capsys):
    """Python by its argument, the shell by its flag, a file by its key."""
    with pytest.raises(ValueError, match=r"^energy is required: the energy"):
        Job(model=HH, poincare=fa.jobs.PoincareOptions()).plan()
    with pytest.raises(ValueError, match=r"^give time or returns, not both"):
        Job(model=HH, energy_surface=LOW, chaos_map=fa.jobs.ChaosOptions(time=1.0, returns=2.0)).chaos_map.check(
            fa.jobs.RunOptions()
        )
    assert main(["poincare", "--model", "henon-heiles"]) == 2
    assert "error: --energy is required: the energy" in capsys.readouterr().err
    (here / "a.toml").write_text("[poincare]\n")
    assert main(["run", "a.toml"]) == 2
    assert "error: a.toml: [energy_surface] energy is required" in capsys.readouterr().err
