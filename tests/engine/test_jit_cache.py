"""The compile cache is used, and never stale: each test runs fresh processes with a cache folder of its own.

Numba stamps a cached function with the content of its own file only; an edit anywhere else would return old numbers
without a word. The folders start as copies of this process's cache, so the engine itself is not compiled again.
"""

import errno
import itertools
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from naive import states

import fastaff
from fastaff import (
    DOP853,
    KAHAN_LI8,
    RK4,
    SOFRONIOU_SPALETTA10,
    HenonHeiles,
    Hyperplane,
    frequency_map,
    integrate,
    poincare_map,
)
from fastaff.engine import cache as files
from fastaff.engine import code_folder as _code_folder
from fastaff.engine import jit as _jit
from fastaff.engine import source
from fastaff.engine.room import INDEX
from fastaff.engine.texts import TEXTS
from fastaff.runs import flow as engine

pytestmark = pytest.mark.skipif(_jit.JIT_DISABLED, reason="no compiler, no cache")
OTHER = 54321
"""Number of another user, who need not exist."""

TESTS, PACKAGE = Path(__file__).parents[1], Path(fastaff.__file__).parent


@pytest.fixture(scope="module")
def seed():
    """Folder of this process's cache, with the engine in it: what follows is compiled here at most once."""
    model, z0 = HenonHeiles(), states(HenonHeiles(), 2)
    integrate(model, z0, time=1.0, step=0.1)
    integrate(model, z0, time=1.0, scheme=DOP853)
    poincare_map(model, z0, section=Hyperplane((1, 0, 0, 0)), crossings=1, max_time=10.0, step=0.1)
    frequency_map(model, z0, time=20.0, step=0.1)
    if _jit.cache_directory() is None:
        pytest.skip("no cache folder can be written here")
    return _jit.cache_directory()


@pytest.fixture
def cache(seed, tmp_path):
    """A copy of the cache for one test."""
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    shutil.copytree(seed, folder / seed.name, ignore=shutil.ignore_patterns(".probe*", "*.tmp*"))
    if (index := seed.with_name(INDEX)).is_file():
        shutil.copy(index, folder)
    return folder


def python(code, cache, *, path=(), stdin=False, **env):
    """Run a fresh process; return its standard output and error."""
    places = os.pathsep.join(map(str, (*path, TESTS, PACKAGE.parent)))
    environment = (
        os.environ | {"FASTAFF_CACHE_DIR": str(cache), "PYTHONPATH": places, "PYTHONDONTWRITEBYTECODE": "1"} | env
    )
    command = [
        sys.executable,
        "-P",
        "-W",
        "always",
        *(["-"] if stdin else ["-c", code]),
    ]  # -P: not from the current folder
    done = subprocess.run(
        command, input=code if stdin else None, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


def contents(cache):
    """Every file with its time of change."""
    return {p: p.stat().st_mtime_ns for p in cache.rglob("*") if p.is_file()}


BUILTIN = """
import fastaff
from fastaff import *
z = integrate(HenonHeiles(LAM), [0.1, 0.2, 0.3, 0.1], time=1.0, step=0.1, scheme=LEAPFROG, energy_tolerance=1.0).z
print([float(x).hex() for x in z[:, 0]])
"""


def test_a_second_process_compiles_nothing_for_other_parameters_either(cache):
    first, _ = python(BUILTIN.replace("LAM", "0.9"), cache)
    before = contents(cache)
    twice = BUILTIN.replace("LAM", "0.9") + BUILTIN.replace("LAM", "0.4")
    second, other = python(twice, cache)[0].splitlines()
    assert contents(cache) == before
    assert second == first.strip()
    assert other != second


def test_constants_are_a_reason_to_compile_only_where_asked_for(monkeypatch):
    monkeypatch.setattr(_jit, "cache_directory", lambda: None)

    @_jit.jit
    def plain(factor, x):
        return factor * x

    @_jit.jit(constants=True)
    def special(factor, x):
        return factor * x

    @_jit.jit
    def all_of_them(x):
        return plain(2, x), plain(3, x), plain(factor=x, x=4), special(2, x), special(3, x), special(x, 4)

    assert all_of_them(5) == (10, 15, 20, 10, 15, 20)
    assert len(plain.part.signatures) == 1
    assert len(special.part.signatures) == 3


@pytest.mark.parametrize(
    ("scheme", "orbits", "blocks"),
    [
        (KAHAN_LI8, 3, {"splitting", "check", "inside", "potential"}),
        (SOFRONIOU_SPALETTA10, 3, {"precise_splitting", "check", "inside", "potential"}),
        (KAHAN_LI8, 1, {"march", "check", "inside", "potential"}),
        (RK4, 3, {"derivative", "check", "inside", "potential"}),
        (DOP853, 3, {"derivative", "check", "potential"}),
    ],
    ids=["splitting", "precise splitting", "one orbit", "tableau", "adaptive"],
)
def test_a_scheme_compiles_only_what_it_steps_by(monkeypatch, scheme, orbits, blocks):
    used, make = set(), engine.model_block

    def watched(kind, *rest):
        used.add(kind)
        return make(kind, *rest)

    monkeypatch.setattr(engine, "model_block", watched)
    z = states(HenonHeiles(), orbits, seed=1)
    assert np.isfinite(integrate(HenonHeiles(), z, time=1.0, step=0.1, scheme=scheme).z).all()
    assert used == blocks


# --- a user's model ----------------------------------------------------------------------------------------------

MODEL = """
from typing import NamedTuple
HEADER

class Spring(NamedTuple):
    k: float = 1.0
    degrees_of_freedom = 1
    coordinates = ("x",)

    def velocity(self, p):
        return p,

    def force(self, xDEFAULT):
        return -STIFFNESS*x,

    def kinetic_energy(self, p):
        return p*p/2

    def potential_energy(self, xDEFAULT):
        return STIFFNESS*x*x/2

    def margin(self, x):
        return 1.0 + 0.0*x
"""
USE = """
import warnings
warnings.simplefilter("ignore")
from springs import Spring
from fastaff import integrate
run = integrate(Spring(1.0), [1.0, 0.0], time=1.0, step=0.05)
print(float(run.z[0, 0]), float(run.energy_error[0]))
"""


def write(folder, header="", stiffness="4.0*self.k", default=""):
    folder.mkdir(exist_ok=True)
    text = MODEL.replace("HEADER", header).replace("STIFFNESS", stiffness).replace("DEFAULT", default)
    (folder / "springs.py").write_text(text)


def position(cache, folder):
    """x(1) of the spring in a fresh process; the energy, computed uncompiled, must agree with the motion."""
    x, error = map(float, python(USE, cache, path=[folder])[0].split())
    assert error < 1e-9
    return x


def cos(x):
    """cos to the accuracy of the run."""
    import math

    return pytest.approx(math.cos(x), abs=1e-9)


def test_an_edited_model_gives_new_numbers(cache, tmp_path):
    folder = tmp_path / "user"
    write(folder)
    assert position(cache, folder) == cos(2)
    write(folder, stiffness="9.0*self.k")
    assert position(cache, folder) == cos(3)
    before = contents(cache)
    write(folder)
    assert position(cache, folder) == cos(2)
    assert contents(cache) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("header", "stiffness", "default", "other"),
    [
        ("RATE = CONSTANT", "RATE*self.k", "", ""),
        ("from constants import RATE", "RATE*self.k", "", "RATE = CONSTANT"),
        ("import constants", "constants.RATE*self.k", "", "RATE = CONSTANT"),
        ("from constants import RATES", "RATES[1]*self.k", "", "RATES = (0.0, CONSTANT)"),
        (
            "from constants import rate",
            "rate(self.k)",
            "",
            "from numba import njit\n@njit\ndef rate(k):\n    return CONSTANT*k",
        ),
        (
            "from constants import rate",
            "rate(self.k)",
            "",
            "from numba import njit\nR = CONSTANT\n@njit\ndef rate(k):\n    return R*k",
        ),
        (
            "from constants import rate",
            "rate(self.k)",
            "",
            "from numba import njit\ndef make(r):\n    @njit\n    def rate(k):\n        return r*k\n    return "
            "rate\nrate = make(CONSTANT)",
        ),
        ("from constants import RATE", "rate*self.k", ", rate=RATE", "RATE = CONSTANT"),
    ],
)
def test_a_changed_constant_gives_new_numbers(cache, tmp_path, header, stiffness, default, other):
    """Whatever way the number takes into the method, in whatever file it is."""
    folder = tmp_path / "user"
    for rate, frequency in (("4.0", 2), ("9.0", 3)):
        write(folder, header.replace("CONSTANT", rate), stiffness, default)
        (folder / "constants.py").write_text(other.replace("CONSTANT", rate) + "\n")
        assert position(cache, folder) == cos(frequency)


@pytest.mark.slow
@pytest.mark.parametrize("stdin", [False, True], ids=["-c", "stdin"])
def test_a_model_typed_at_a_prompt_is_compiled_and_not_cached(cache, stdin):
    python(BUILTIN.replace("LAM", "0.9"), cache)
    before = contents(cache)
    for stiffness, frequency in (("4.0*self.k", 2), ("9.0*self.k", 3)):
        model = MODEL.replace("HEADER", "").replace("STIFFNESS", stiffness).replace("DEFAULT", "")
        out, _ = python(model + USE.replace("from springs import Spring", ""), cache, stdin=stdin)
        assert float(out.split()[0]) == cos(frequency)
    assert set(contents(cache)) == set(before)


def test_a_model_redefined_in_one_session(cache):
    """As in a notebook: the class of the same name has new numbers at once."""
    code = ["import warnings; warnings.simplefilter('ignore')", "from fastaff import integrate"]
    for stiffness in ("4.0*self.k", "9.0*self.k"):
        code.append(MODEL.replace("HEADER", "").replace("STIFFNESS", stiffness).replace("DEFAULT", ""))
        code.append("print(float(integrate(Spring(), [1.0, 0.0], time=1.0, step=0.05).z[0, 0]))")
    out, _ = python("\n".join(code), cache)
    assert [float(x) for x in out.split()] == [cos(2), cos(3)]


OBSERVERS = """
from typing import NamedTuple
from fastaff.engine.kernels.readings import stretch
from fastaff.engine.jit import LANES
HEADER

class Scale(NamedTuple):
    factor: float

def own(growth, i, factor):
    return FACTOR*factor*stretch(growth, 0, i)

def highest(value, lanes, orbit, fresh, t, z, memory, out, done):
    for i in range(lanes):
        memory[i] = max(memory[i], FACTOR*value.factor*abs(z[i]))
    return 0
"""
OBSERVE = """
import warnings, numpy as np
warnings.simplefilter("ignore")
import watchers
import fastaff
from fastaff import *
from fastaff.runs.observers import Observer
from fastaff.runs.options import Options, plan
model, z0 = HenonHeiles(), np.array([[0.1, 0.2], [0.2, 0.1], [0.3, 0.1], [0.1, 0.3]])
mine = fastaff.chaos.TangentIndicator("mine", watchers.own, threshold=5.0, parameters=(SCALE,))
found = chaos_map(model, z0, time=20.0, step=0.1, indicators=(LyapunovSpectrum(), mine))
flow, z, *_ = plan(model, z0, Options(step=0.1))
_, memory, _ = flow.observed(z, Observer(watchers.highest, 1, watchers.Scale(SCALE)), time=20.0)
reached = np.abs(integrate(model, z0, time=20.0, step=0.1, samples=200).samples[:, 0]).max(axis=0)
print(*(found.mine/(found.largest*20.0)), *(memory[0]/reached))
"""


@pytest.mark.parametrize(
    ("header", "factor", "other"),
    [
        pytest.param("", "NUMBER", "", marks=pytest.mark.slow),
        ("from constants import rate", "rate(1.0)", "def rate(x):\n    return NUMBER*x"),
    ],
    ids=["edited", "edited elsewhere"],
)
def test_indicators_and_observers_of_ones_own_are_compiled_once_for_each_content(
    cache, tmp_path, header, factor, other
):
    """From outside the package, in fresh processes: never a stale kernel, and nothing compiled for another value."""
    folder = tmp_path / "user"
    folder.mkdir()

    def factors(number, scale):
        (folder / "watchers.py").write_text(
            OBSERVERS.replace("HEADER", header).replace("FACTOR", factor.replace("NUMBER", number))
        )
        (folder / "constants.py").write_text(
            other.replace("NUMBER", number).replace("def", "import numba\n@numba.njit\ndef")
        )
        return [float(x) for x in python(OBSERVE.replace("SCALE", scale), cache, path=[folder])[0].split()]

    assert factors("3.0", "0.5") == pytest.approx([1.5] * 4, rel=1e-12)
    assert factors("5.0", "0.5") == pytest.approx([2.5] * 4, rel=1e-12)
    before = contents(cache)
    assert factors("3.0", "4.0") == pytest.approx([12.0] * 4, rel=1e-12)
    assert contents(cache) == before


def test_the_source_is_what_is_compiled(seed):
    """Every kind of block: Python text, and that of a block in the cache where one was compiled."""
    model = HenonHeiles()
    for kind in TEXTS:
        value, n = (Hyperplane((1, 0, 0, 0)), 2) if kind == "value" else (model, None)
        text = source(value, kind, n)
        assert text.startswith(f"# {kind} of {type(value).__name__}\ndef {kind}(params, ")
        compile(text, "block", "exec")
    kept = {path.read_text().partition("\n")[2] for path in seed.glob("blocks/*.py")}  # below the checksum
    assert {source(model, "splitting"), source(model, "check"), source(Hyperplane((1, 0, 0, 0)), "value", 2)} <= kept
    assert source(HenonHeiles(0.3), "splitting") == source(model, "splitting")
    assert "tangent_force" in source(model, "splitting", vectors=1)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((HenonHeiles(), "step"), ValueError, "kind must be one of 'splitting', .*got 'step'"),
        ((3.0, "splitting"), TypeError, "value must be a model or section"),
        ((Hyperplane((1, 0, 0, 0)), "value"), TypeError, "degrees_of_freedom must be given for Hyperplane"),
    ],
)
def test_a_source_that_is_none_is_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        source(*arguments)


VARIETY = """
import warnings
warnings.simplefilter("ignore")
import numpy as np
from variety import *
from naive import energy, march, scheme_crossings
import fastaff
from fastaff import *

def check(model, z0, section=None):
    z0 = np.array(z0)
    run = integrate(model, z0, time=2.0, step=0.1, energy_tolerance=1.0)
    twin = march(model, KAHAN_LI8, z0, 0.1, 20)[-1]
    assert np.abs(run.z[:, 0] - twin).max() < 1e-12, (model, run.z[:, 0], twin)
    if section is not None:
        cut = poincare_map(model, z0, section=section, crossings=3, max_time=30.0, step=0.1, energy_tolerance=1.0)
        times, points = scheme_crossings(model, KAHAN_LI8, z0, section, 0.1, 20.0)
        assert cut.counts[0] == 3 and np.abs(cut.times[:, 0] - times[:3]).max() < 1e-11, (cut.times, times)
    print("fine")

check(Bare(), [0.5, 0.1], Through(0.2, 0))
check(Weighted((1.0, 2.5)), [0.5, -0.2, 0.1, 0.3], Through(0.1, 1))
check(Weighted((3.0, 0.5)), [0.5, -0.2, 0.1, 0.3])
check(Body(Quartic(1.0, (0.3, 0.2))), [1.4, 0.1, 0.2, 0.0, 0.1, 0.2, 0.1, 0.3], AlphaTurning(1))
check(Body(Quartic(1.0, (0.3, 0.2)), 2.0), [1.4, 0.1, 0.2, 0.0, 0.1, 0.2, 0.1, 0.3], SpinSpeed(0))
"""
VARIETY_FILE = '''
from typing import NamedTuple
import numpy as np

class Bare(NamedTuple):
    """No fields."""
    degrees_of_freedom = 1
    coordinates = ("x",)
    def velocity(self, p): return p,
    def force(self, x): return -x - np.sin(x),
    def kinetic_energy(self, p): return p*p/2
    def potential_energy(self, x): return x*x/2 - np.cos(x)
    def margin(self, x): return 1.0 + 0.0*x

class Weighted(NamedTuple):
    """A tuple of numbers."""
    weights: tuple
    degrees_of_freedom = 2
    coordinates = ("x", "y")
    def velocity(self, p, r): return p, r
    def force(self, x, y): return -self.weights[0]*x, -self.weights[1]*y
    def kinetic_energy(self, p, r): return (p*p + r*r)/2
    def potential_energy(self, x, y): return (self.weights[0]*x*x + self.weights[1]*y*y)/2
    def margin(self, x, y): return 1.0 + 0.0*x

class Quartic(NamedTuple):
    """A potential of one's own for Body: V = C (A + B)/2 + c1 A^2 + c2 A B, with a helper method."""
    C: float
    c: tuple
    def value(self, A, B): return self.C*(A + B)/2 + self.c[0]*A*A + self.c[1]*A*B
    def along(self, A, B): return 2*self.c[0]*A + self.c[1]*B
    def slopes(self, A, B): return self.C/2 + self.along(A, B), self.C/2 + self.c[1]*A
    def margin(self, A, B): return 1.0 + 0.0*A

class Through(NamedTuple):
    """A section of one's own, for any number of coordinates."""
    place: float
    direction: int
    def value(self, *z): return z[0] - self.place

class SpinSpeed(NamedTuple):
    direction: int
    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2): return b1 - 0.5*b2
'''


@pytest.mark.slow
def test_models_potentials_and_sections_of_ones_own(cache, tmp_path):
    """No fields, tuple fields, a potential with a helper method, sections: against the twins, compiled and from the
    cache.
    """
    folder = tmp_path / "user"
    folder.mkdir()
    (folder / "variety.py").write_text(VARIETY_FILE)
    assert python(VARIETY, cache, path=[folder])[0].split() == ["fine"] * 5
    before = contents(cache)
    assert python(VARIETY, cache, path=[folder])[0].split() == ["fine"] * 5
    assert contents(cache) == before


# --- the folder --------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_an_unwritable_folder_costs_one_warning_and_no_numbers(cache, tmp_path):
    """A path below a file can be made by nobody, not even by root."""
    (tmp_path / "file").write_text("")
    expected, _ = python(BUILTIN.replace("LAM", "0.9"), cache)
    out, err = python(BUILTIN.replace("LAM", "0.9"), tmp_path / "file" / "below", NUMBA_OPT="1")
    assert out == expected
    assert err.count("RuntimeWarning") == 1
    assert "fastaff cannot write its compile cache" in err
    assert "Set FASTAFF_CACHE_DIR" in err


@pytest.fixture
def private(monkeypatch, tmp_path):
    """The cache folder of this process for a root, found anew."""
    if not hasattr(os, "getuid"):
        pytest.skip("folders have no owners and modes here")

    def directory(root):
        monkeypatch.setenv("FASTAFF_CACHE_DIR", str(root))
        return _jit.cache_directory.__wrapped__()

    return directory


def test_the_folder_is_made_for_its_owner_alone(private, tmp_path):
    """Whatever the umask is; parts of the folder too."""
    before = os.umask(0)
    try:
        folder = private(tmp_path / "new" / "cache")
    finally:
        os.umask(before)
    made = [folder.parent, folder, *folder.iterdir()]
    assert len(made) == 4
    assert {path.stat().st_mode & 0o777 for path in made} == {0o700}


@pytest.mark.parametrize("mode", [0o775, 0o707, 0o722, 0o777])
@pytest.mark.parametrize("part", ["root", "hash", "blocks", "formulas"])
def test_a_folder_that_others_can_write_is_refused(private, tmp_path, mode, part):
    folder = private(tmp_path / "cache")
    open_to_all = {"root": folder.parent, "hash": folder}.get(part, folder / part)
    open_to_all.chmod(mode)
    with pytest.warns(
        RuntimeWarning, match=r"can be written by others \(mode \d+\); kernels are compiled.*chmod -R go-w"
    ) as caught:
        assert private(tmp_path / "cache") is None
    assert len(caught) == 1
    assert str(open_to_all) in str(caught[0].message)
    open_to_all.chmod(mode & ~0o022)
    assert private(tmp_path / "cache") == folder


def test_a_folder_of_another_user_is_refused(private, tmp_path, monkeypatch):
    folder = private(tmp_path / "cache")
    if os.geteuid() == 0:
        os.chown(folder, OTHER, -1)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: folder.stat().st_uid + 1)
    with pytest.warns(RuntimeWarning, match=r"belongs to another user \(uid \d+\).*FASTAFF_CACHE_DIR"):
        assert private(tmp_path / "cache") is None


def test_a_sticky_folder_for_all_will_do_for_the_folders_in_it(private, tmp_path):
    (tmp_path / "common").mkdir()
    (tmp_path / "common").chmod(0o1777)
    folder = private(tmp_path / "common")
    assert folder.parent == tmp_path / "common"
    folder.chmod(0o777)
    with pytest.warns(RuntimeWarning, match="can be written by others"):
        assert private(tmp_path / "common") is None


def test_a_refused_folder_costs_one_warning_and_no_code_is_run_from_it(cache, tmp_path):
    """A planted formula raises when executed: a process whose folder others can write must not see it."""
    code = "from fastaff import hamiltonian; print(hamiltonian('k*x**2/2', coordinates='x', k=2.0).force(3.0))"
    expected, _ = python(code, cache)
    planted = list(cache.rglob("formulas/*.py"))
    for path in planted:
        assert files.write(path, b"raise SystemExit('planted')\n")
    planted[0].parent.parent.chmod(0o777)
    out, err = python(code, cache)
    assert out == expected
    assert err.count("RuntimeWarning") == 1


# --- files that are damaged or cannot be written -------------------------------------------------------------------


def damaged(whole):
    """Versions of a file: a bit flipped, an end missing, more or something else in it."""
    for at, bit in itertools.product(range(len(whole)), range(8)):
        version = bytearray(whole)
        version[at] ^= 1 << bit
        yield bytes(version)
    yield from (whole[:end] for end in range(len(whole)))
    yield from [whole + b"\0", b"\n" + whole, b"\n", whole[::-1]]


def test_no_flipped_bit_and_no_missing_end_is_read(tmp_path, unwarned):
    path, content = tmp_path / "some.code", np.random.default_rng(1).bytes(40)
    assert files.read(path) is None
    assert files.write(path, content)
    assert files.read(path) == content
    whole = path.read_bytes()

    def read():
        found = []
        for version in damaged(whole):
            path.write_bytes(version)
            found.append(files.read(path))
        other = path.with_name("other.code")
        other.write_bytes(whole)  # what another name held
        return [*found, files.read(other)]

    with pytest.warns(RuntimeWarning, match=r"damaged files, .*some.code for one: .* is compiled again") as said:
        assert read() == [None] * (9 * len(whole) + 5)
    assert len(said) == 1
    assert files.write(path, content)
    assert files.read(path) == content


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES])
@pytest.mark.parametrize("broken", ["open", "replace"])
def test_a_file_that_cannot_be_written_costs_one_warning(tmp_path, unwarned, monkeypatch, broken, code):
    def fail(*arguments):
        raise OSError(code, os.strerror(code))

    assert files.write(tmp_path / "before", b"kept")
    monkeypatch.setattr(files.os, broken, fail)
    with pytest.warns(RuntimeWarning, match="cannot write its compile cache .*anew.*FASTAFF_CACHE_DIR") as said:
        assert [files.write(tmp_path / name, b"new") for name in ("before", "after")] == [False, False]
    assert len(said) == 1
    monkeypatch.undo()
    assert [entry.name for entry in tmp_path.iterdir()] == ["before"]
    assert files.read(tmp_path / "before") == b"kept"


def flipped(path, rng):
    content = bytearray(path.read_bytes())
    content[rng.integers(len(content))] ^= 1 << rng.integers(8)
    path.write_bytes(content)


FULL = """
import resource, signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
"""


@pytest.mark.slow
def test_a_damaged_cache_gives_no_other_numbers_and_is_mended(cache):
    """A bit flipped in each of 40 files; a file of each kind cut off."""
    rng = np.random.default_rng(2)
    code = BUILTIN.replace("LAM", "0.9") + "print(hamiltonian('k*x**2/2', coordinates='x', k=2.0).force(3.0))\n"
    expected, said = python(code, cache)
    assert said == ""
    before = contents(cache)
    paths = sorted(path for path in before if path.suffix == ".code")
    for _ in range(-(-40 // len(paths))):
        for path in paths:
            flipped(path, rng)
        for path in cache.rglob("formulas/*.py"):
            flipped(path, rng)
        out, said = python(code, cache)
        assert out == expected
        assert said.count("RuntimeWarning") == 1
    for path in paths:
        os.truncate(path, path.stat().st_size // 2)
    assert python(code, cache)[0] == expected
    assert python(code, cache) == (expected, "")
    assert set(contents(cache)) == set(before)


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="no limit of the size of files")
def test_a_full_disk_costs_one_warning_and_what_is_there_is_read(cache, tmp_path):
    code = BUILTIN.replace("LAM", "0.9")
    expected, _ = python(code, cache)
    before = contents(cache)
    assert python(FULL + code, cache) == (expected, "")
    empty = tmp_path / "empty"
    out, said = python(FULL + code, empty)
    assert out == expected
    assert said.count("RuntimeWarning") == 1
    assert "cannot write its compile cache" in said
    assert contents(empty) == {}
    assert contents(cache) == before


def test_the_folder_is_the_users(tmp_path, monkeypatch):
    monkeypatch.setenv("FASTAFF_CACHE_DIR", str(tmp_path / "x"))
    assert _code_folder.cache_root() == tmp_path / "x"
    if sys.platform.startswith("linux"):
        monkeypatch.setenv("FASTAFF_CACHE_DIR", "")
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        assert _code_folder.cache_root() == tmp_path / "fastaff"


KERNEL = """
import numpy as np
from fastaff.engine import cache as files
from fastaff.engine import jit as _jit
from fastaff.engine.kernels import birkhoff, stepping
block = np.zeros(4000)
stepping.load_lane(np.ones((2, 1)), 0, block, 0)
print(_jit.cache_directory().name, birkhoff.weight(0.5), np.flatnonzero(block)[1])
"""


def test_an_edited_package_gives_new_numbers(tmp_path):
    """A constant of the kernel's own file, and one that it reads from another file (which Numba does not watch)."""
    shutil.copytree(PACKAGE, tmp_path / "fastaff", ignore=shutil.ignore_patterns("__pycache__"))
    cache, runs = tmp_path / "cache", []

    def run():
        folder, weight, lanes = python(KERNEL, cache, path=[tmp_path])[0].split()
        runs.append((folder, float(weight), int(lanes)))

    def edit(name, pattern, text):
        path = tmp_path / "fastaff" / name
        edited = re.sub(pattern, text, path.read_text(), flags=re.MULTILINE)
        assert edited != path.read_text()
        path.write_text(edited)

    run()
    edit("engine/kernels/birkhoff.py", r"^SHARPNESS = 30.0", "SHARPNESS = 15.0")
    run()
    edit("engine/jit.py", r"^LANES = \d+", "LANES = 48")
    run()
    assert runs[0][0] == runs[1][0] != runs[2][0]  # only the last edit is one of the compiler
    assert [lanes for _, _, lanes in runs] == [_jit.LANES, _jit.LANES, 48]
    weights = [weight for _, weight, _ in runs]
    assert weights[1] == pytest.approx(weights[0] ** 0.5, rel=1e-12)
    assert weights[2] == weights[1]


# --- without a compiler ------------------------------------------------------------------------------------------

UNCOMPILED = """
import numpy as np
from naive import states
from numba.core.runtime import _nrt_python, rtsys
import fastaff
from fastaff import *
body = Body(Hyperelastic(1.1), 0.8)
z0 = states(body, 5)
small = dict(step=0.2, energy_tolerance=1.0)
results = []
for scheme in (LEAPFROG, SOFRONIOU_SPALETTA10, RK4):
    run = integrate(body, z0, time=2.0, samples=2, scheme=scheme, **small)
    results += [run.z, run.samples, run.energy_error, run.status]
run = integrate(body, z0[:, 0], time=2.0, **small)
results += [run.z]
run = integrate(HenonHeiles(), z0[:4]*0.1, time=2.0, scheme=DOP853, samples=3)
results += [run.z, run.samples, run.status]
cut = poincare_map(body, z0, section=BetaEquals(0.3, 0), crossings=3, max_time=6.0, **small)
results += [cut.points, cut.times, cut.counts, cut.status]
f = frequency_map(body, z0[:, :2], time=20.0, **small)
results += [f.nu, f.error]
np.savez(PLACE, *results)
"""


@pytest.mark.slow
def test_without_the_compiler_the_numbers_are_the_same(cache, tmp_path):
    """NUMBA_DISABLE_JIT=1: to 1e-13, for NumPy's own sqrt and log may round otherwise."""
    import numpy as np

    for name, env in (("compiled", {}), ("plain", {"NUMBA_DISABLE_JIT": "1"})):
        python(UNCOMPILED.replace("PLACE", repr(str(tmp_path / f"{name}.npz"))), cache, **env)
    one, other = (np.load(tmp_path / f"{name}.npz") for name in ("compiled", "plain"))
    assert len(one.files) == len(other.files) >= 20
    for name in one.files[:-1]:
        np.testing.assert_allclose(other[name], one[name], rtol=1e-13, atol=1e-13, err_msg=name)
    np.testing.assert_allclose(other[one.files[-1]], one[one.files[-1]], rtol=1e-6)  # errors are small differences
