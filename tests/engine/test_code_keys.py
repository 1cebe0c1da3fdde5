"""What compiled code is keyed by: all that it reads, wherever that is written, and whoever has changed it.

Most cases ask for the key of a helper module that is written, read and edited here; some run fresh processes. The rule
of all: where what is computed changes, the key changes, or there is none and nothing is kept.
"""

from __future__ import annotations

import ast
import gc
import importlib
import inspect
import itertools
import os
import pickle
import random
import re
import stat
import sys
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from test_jit_cache import OTHER, cache, contents, python, seed  # noqa: F401  # fixtures
from thorough import TIMES

import fastaff as fa
from fastaff.engine import cache as files
from fastaff.engine import code_folder, jit, room, sources, values
from fastaff.engine import fingerprint as keys
from fastaff.engine.jit import SIGNATURES
from fastaff.engine.kernels import birkhoff, stepping
from fastaff.engine.values import parameters
from fastaff.frequencies.kernels import loop_lines
from fastaff.systems.formulas import library
from fastaff.tori.kernels import wells

pytestmark = pytest.mark.skipif(jit.JIT_DISABLED, reason="no compiler, no cache")

# --- values that methods read from other files ----------------------------------------------------------------------

MODEL = """
from typing import NamedTuple
import numpy as np
import helper
from helper import *

class Spring(NamedTuple):
    k: float = 1.0
    degrees_of_freedom = 1
    coordinates = ("x",)
    def velocity(self, p): return p,
    def force(self, x): return -(EXPRESSION)*self.k*x,
    def kinetic_energy(self, p): return p*p/2
    def potential_energy(self, x): return (EXPRESSION)*self.k*x*x/2
    def margin(self, x): return 1.0 + 0.0*x
"""

READ = {
    "member of an IntEnum": ("from enum import IntEnum\nclass Kind(IntEnum):\n    A = NUMBER\n    B = 77", "Kind.A"),
    "value of an Enum": ("from enum import Enum\nclass Kind(Enum):\n    B = 0\n    A = NUMBER.5", "Kind.A.value"),
    "a second name": ("from enum import IntEnum\nclass Kind(IntEnum):\n    A = NUMBER\n    B = A", "Kind.B"),
    "a flag": ("from enum import IntFlag\nclass Kind(IntFlag):\n    A = NUMBER\n    B = 1024", "Kind.A"),
    "a member by itself": ("from enum import IntEnum\nclass Kind(IntEnum):\n    A = NUMBER\nA = Kind.A", "A"),
    "another class of the name": ("import enum\nKind = enum.IntEnum('Kind', {'A': NUMBER})", "Kind.A"),
    "values": ("from typing import NamedTuple\nclass P(NamedTuple):\n    a: float\nVALUE = P(NUMBER.0)", "VALUE.a"),
    "default of values": ("from typing import NamedTuple\nclass P(NamedTuple):\n    a: float = NUMBER.0", "P().a"),
    "method of values": (
        "from typing import NamedTuple\nclass P(NamedTuple):\n    a: float\n    def times(self, b): return NUMBER*b",
        "P(1.0).times(self.k)",
    ),
    "values in values": (
        "from typing import NamedTuple\nclass P(NamedTuple):\n    a: tuple\nVALUE = P((1.0, (2.0, NUMBER.0)))",
        "VALUE.a[1][1]",
    ),
    "number": ("RATE = NUMBER", "RATE"),
    "number of NumPy": ("import numpy as np\nRATE = np.float32(NUMBER)", "RATE"),
    "tuple": ("RATES = (1.0, (NUMBER.0, 2.0))", "RATES[1][0]"),
    "array": ("import numpy as np\nRATES = np.array([1.0, NUMBER.0])", "RATES[1]"),
    "array in the middle": ("import numpy as np\nRATES = np.arange(9000.0)\nRATES[4500] = NUMBER", "RATES[4500]"),
    "module": ("RATE = NUMBER", "helper.RATE"),
    "function": ("from numba import njit\n@njit\ndef rate(k): return NUMBER*k", "rate(self.k)"),
    "function's number": ("from numba import njit\nR = NUMBER\n@njit\ndef rate(k): return R*k", "rate(self.k)"),
    "function's default": ("from numba import njit\n@njit\ndef rate(k, r=NUMBER): return r*k", "rate(self.k)"),
    "function's keyword": ("from numba import njit\n@njit\ndef rate(k, *, r=NUMBER): return r*k", "rate(self.k)"),
    "function's class": (
        "from numba import njit\nfrom enum import IntEnum\nclass Kind(IntEnum):\n    A = NUMBER\n"
        "@njit\ndef rate(k): return Kind.A*k",
        "rate(self.k)",
    ),
    "closure": (
        "from numba import njit\ndef make(r):\n    @njit\n    def rate(k): return r*k\n    return rate\n"
        "rate = make(NUMBER)",
        "rate(self.k)",
    ),
    "closure of a class": (
        "from numba import njit\nfrom enum import IntEnum\ndef make():\n    class Kind(IntEnum):\n        A = NUMBER\n"
        "    @njit\n    def rate(k): return Kind.A*k\n    return rate\nrate = make()",
        "rate(self.k)",
    ),
    "options of the compiler": (
        "from numba import njit\n@njit(error_model=['python', 'numpy'][NUMBER % 2])\ndef rate(k): return 1.0/k",
        "rate(self.k)",
    ),
    "class with a number": ("class Box:\n    RATE = NUMBER", "Box.RATE"),
    "object": ("class Box:\n    def __init__(self, r): self.r = r\nBOX = Box(NUMBER)", "BOX.r"),
    "list": ("RATES = [NUMBER]", "RATES[0]"),
    "dictionary": ("RATES = {'a': NUMBER}", "RATES['a']"),
}
"""What a helper has, and how a method reads it."""


@pytest.fixture
def key(tmp_path, monkeypatch):
    """What returns the key of the model of a helper's text, read anew."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def get(helper, expression):
        (tmp_path / "helper.py").write_text(helper + "\n")
        (tmp_path / "own_model.py").write_text(MODEL.replace("EXPRESSION", expression))
        for name in ("helper", "own_model"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        importlib.invalidate_caches()
        return keys.fingerprint((importlib.import_module("own_model").Spring,))

    yield get
    for name in ("helper", "own_model"):
        sys.modules.pop(name, None)


KEPT = {"class with a number", "object", "list", "dictionary", "module"}
"""Those whose content is unknown: nothing of them is kept on disk."""


@pytest.mark.parametrize("way", READ)
def test_another_value_is_another_key(way, key):
    """Whatever way a number takes into a method, in whatever file it is; the same text has the same key."""
    rng = random.Random(f"values {way}")
    helper, expression = READ[way]
    for _ in range(TIMES):
        first = rng.randint(1, 500)
        other = first + rng.choice([1, 3, 5])
        one, again, changed = (key(helper.replace("NUMBER", str(n)), expression) for n in (first, first, other))
        assert one == again
        assert (one is None) == (way in KEPT)
        assert one is None or one != changed


def test_the_order_of_sets_is_no_part_of_a_key(tmp_path):
    """The order of texts in a set differs between processes."""
    code = (
        "from fastaff.engine.fingerprint import Content\n"
        "def chosen(x): return x in {'one', 'two', 'three', 'four', 'five'}\n"
        "content = Content()\nassert content.takes(chosen, False)\nprint(content.digest())"
    )
    found = {python(code, tmp_path, PYTHONHASHSEED=str(number))[0] for number in range(3)}
    assert len(found) == 1


ENUM = """
from enum import IntEnum
class Kind(IntEnum):
    A = NUMBER
"""
FLOW = """
from typing import NamedTuple
from fastaff.systems.models.contracts import Kind as Equations
from helper import Kind

class Wave(NamedTuple):
    c: float = 1.0
    kind = Equations.FLOW
    degrees_of_freedom = 1
    coordinates = ("x", "v")
    def rates(self, x, v): return v, -Kind.A*self.c*x
    def margin(self, x, v): return 1.0 + 0.0*x
"""
USE_FLOW = """
import fastaff as fa
from own_flow import Wave
run = fa.integrate(Wave(), [1.0, 0.0], time=1.0)
print(float(run.z[0, -1]), int(run.status[0]))
"""


def test_an_edited_enumeration_gives_new_numbers(cache, tmp_path):  # noqa: F811
    folder = tmp_path / "user"
    folder.mkdir()
    (folder / "own_flow.py").write_text(FLOW)
    for number, frequency in ((1, 1.0), (4, 2.0)):
        (folder / "helper.py").write_text(ENUM.replace("NUMBER", str(number)))
        x, status = map(float, python(USE_FLOW, cache, path=[folder])[0].split())
        assert x == pytest.approx(np.cos(frequency), abs=1e-9)
        assert status == 0
    before = contents(cache)
    python(USE_FLOW, cache, path=[folder])
    assert contents(cache) == before


# --- classes and kernels of the package that somebody has changed ----------------------------------------------------


def own_classes():
    """The package's classes of values with methods that kernels may call."""
    modules = (fa.models, fa.models.functions, fa.models.sections, fa.models.angles)
    found = {entry for module in modules for entry in vars(module).values() if isinstance(entry, type)}
    found = {cls for cls in found if issubclass(cls, tuple) and hasattr(cls, "_fields") and values.methods_of(cls)}
    return sorted(found, key=lambda cls: cls.__qualname__)


@pytest.mark.parametrize("cls", own_classes(), ids=lambda cls: cls.__name__)
def test_a_changed_method_of_the_package_is_not_kept(cls):
    """Of any class, any method: by a function of the user, or by that of another class, which has another key."""
    before = keys.fingerprint((cls,))
    assert before is not None
    state = values.state_of(cls)
    for name, method in values.methods_of(cls):
        with mock.patch.object(cls, name, lambda self, *rows: rows):
            assert keys.fingerprint((cls,)) is None
            assert values.state_of(cls) != state
        with mock.patch.object(cls, name, keys.is_ours.__get__):
            assert values.state_of(cls) != state
        others = [entry for _, entry in values.methods_of(fa.HenonHeiles) if entry.__code__ != method.__code__]
        with mock.patch.object(cls, name, others[0]):
            assert keys.fingerprint((cls,)) not in (before, None)
        twin = type(method)(method.__code__.replace(co_consts=(1, 2.5)), method.__globals__, name)
        with mock.patch.object(cls, name, twin):
            assert keys.fingerprint((cls,)) != before
        assert (keys.fingerprint((cls,)), values.state_of(cls)) == (before, state)


def test_a_changed_number_or_function_of_a_kernel_is_another_key(monkeypatch):
    before = keys.function_key(birkhoff.weight.py_func)
    assert before is not None
    with mock.patch.object(birkhoff, "SHARPNESS", 15.0):
        assert keys.function_key(birkhoff.weight.py_func) not in (before, None)
    with mock.patch.object(birkhoff, "math", np):
        assert keys.function_key(birkhoff.weight.py_func) != before
    assert keys.function_key(birkhoff.weight.py_func) == before


PATCHED = """
import warnings
warnings.simplefilter("ignore")
from unittest import mock
import fastaff as fa
Map = fa.models.StandardMap

def show():
    run = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1.0, scheme=fa.LEAPFROG)
    print(*run.z[:, 0], *fa.integrate(Map(0.9), [0.5, 0.3], time=3).z[:, 0])

stiff = {"force": lambda self, x, y: (-4*x, -9*y), "potential_energy": lambda self, x, y: (4*x*x + 9*y*y)/2,
    "tangent_force": lambda self, x, y, dx, dy: (-4*dx, -9*dy)}
if PATCH:
    with mock.patch.multiple(fa.HenonHeiles, **stiff), mock.patch.object(Map, "iterate", lambda self, x, p: (x + p, p)):
        show()
show()
"""


def test_a_class_changed_in_one_process_is_whole_in_all_others(cache):  # noqa: F811
    """By a process that changes two classes of the package before they are compiled: the cache has none of them."""
    for path in cache.rglob("*.code"):
        if path.name.partition("-")[0] in SIGNATURES:
            path.unlink()

    def shown(patch):
        lines = python(PATCHED.replace("PATCH", patch), cache)[0].splitlines()
        return [[float(x) for x in line.split()] for line in lines]

    (patched, undone), (whole,) = shown("True"), shown("False")
    assert patched[0] == pytest.approx(0.1 * np.cos(2.0), abs=1e-6)
    assert patched[4:] == pytest.approx([1.4, 0.3], abs=1e-12)
    assert undone == whole
    assert whole[0] == pytest.approx(0.04898516, abs=1e-6)
    x, p = 0.5, 0.3
    for _ in range(3):
        p = p + 0.9 * np.sin(x)
        x = x + p
    assert whole[4:] == pytest.approx([(x + np.pi) % (2 * np.pi) - np.pi, p], abs=1e-12)


def replaced_and_undone():
    """Of a value that was used before, of a new one, and of a part of a value; each change compiles once."""
    rng, z0 = np.random.default_rng(47), np.array([0.1, 0.0, 0.0, 0.2])
    model = fa.HenonHeiles()

    def position(value):
        with np.errstate(all="ignore"):
            return float(fa.integrate(value, z0, time=1.0, step=0.02, energy_tolerance=1.0).z[0, 0])

    truth = position(model)
    for w in rng.uniform(1.0, 3.0, 2):
        changed = {
            "force": lambda self, x, y, w=w: (-w * w * x, -y),
            "potential_energy": lambda self, x, y, w=w: (w * w * x * x + y * y) / 2,
            "tangent_force": lambda self, x, y, dx, dy, w=w: (-w * w * dx, -dy),
        }
        with mock.patch.multiple(fa.HenonHeiles, **changed):
            for value in (model, fa.HenonHeiles()):
                assert position(value) == pytest.approx(0.1 * np.cos(w), abs=1e-8)
            # So many others that what is known of the first is forgotten in some places and not in others.
            others = [fa.HenonHeiles(2.0 + k) for k in range(70)]
            assert len({parameters(value).tobytes() for value in others}) == 70
        assert position(model) == position(fa.HenonHeiles()) == truth


def test_a_method_replaced_in_one_process_is_used_at_once_and_undone(cache):  # noqa: F811
    """In a process that has met no other models."""
    code = "import test_code_keys; test_code_keys.replaced_and_undone(); print('fine')"
    assert python(code, cache, path=[Path(__file__).parent])[0].split()[-1] == "fine"


def test_a_section_that_is_changed(monkeypatch):
    section = fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
    model, z0 = fa.models.HenonHeiles(0.0), [0.1, 0.0, 0.3, 0.2]

    def times():
        return fa.poincare_map(model, z0, section=section, crossings=1, max_time=20.0, step=0.02).times[0, 0]

    before = times()
    with mock.patch.object(fa.Hyperplane, "value", lambda self, x, y, p_x, p_y: x - 0.2):
        assert abs(times() - before) > 0.1
    assert times() == before


# --- files of others --------------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The cache folder of this process under an empty root, found anew."""
    monkeypatch.setenv("FASTAFF_CACHE_DIR", str(tmp_path / "root"))
    return jit.cache_directory.__wrapped__()


needs_owners = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="files have no owners here")


@needs_owners
@pytest.mark.parametrize("mode", [0o1777, 0o1775, 0o1703, 0o3777])
@pytest.mark.parametrize("part", [".", "blocks", "formulas"])
def test_sticky_folders_of_code_are_refused(part, mode, folder, tmp_path):
    """Only a folder that holds the folders of code may be one."""
    (folder / part).chmod(mode)
    with pytest.warns(RuntimeWarning, match="can be written by others"):
        assert jit.cache_directory.__wrapped__() is None
    (folder / part).chmod(0o700)
    folder.parent.chmod(mode)
    assert jit.cache_directory.__wrapped__() == folder


@needs_owners
@pytest.mark.parametrize("how", ["mode", "owner"])
def test_a_file_that_others_could_write_is_not_read(how, folder, unwarned, monkeypatch):
    path = folder / "some.code"
    for mode in (0o620, 0o602, 0o666, 0o777):
        assert files.write(path, b"planted")
        assert files.read(path) == b"planted"
        if how == "mode":
            path.chmod(mode)
        elif os.geteuid() == 0:
            os.chown(path, OTHER, -1)
        else:
            monkeypatch.setattr(files.os, "geteuid", lambda: path.stat().st_uid + 1)
        monkeypatch.setattr(files, "_SAID", set())
        with pytest.warns(RuntimeWarning, match=r"files that others could write, .*some.code"):
            assert files.read(path) is None
        path.unlink()
        monkeypatch.undo()


PLANTED = """
import hashlib, os, pickle, sys
from pathlib import Path
class Planted:
    def __reduce__(self):
        return os.system, (f"echo planted >> {sys.argv[1]}",)
for path in Path(sys.argv[2]).rglob("*.code"):
    content = pickle.dumps(Planted())
    head = b"# " + hashlib.sha256(path.name.encode() + b"\\0" + content).hexdigest().encode()
    path.write_bytes(head + b"\\n" + content)
    os.chown(path, int(sys.argv[3]), -1)
"""


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
def test_planted_code_is_not_run(cache, tmp_path):  # noqa: F811
    """Files with right checksums, of another user."""
    code = "import fastaff as fa\nprint(fa.integrate(fa.HenonHeiles(), [0.1, 0.2, 0.3, 0.1], time=1.0, step=0.1).z)"
    expected, _ = python(code, cache)
    python(
        PLANTED.replace("sys.argv[1]", repr(str(tmp_path / "PWNED")))
        .replace("sys.argv[2]", repr(str(cache)))
        .replace("sys.argv[3]", str(OTHER)),
        cache,
    )
    out, said = python(code, cache)
    assert out == expected
    assert said.count("RuntimeWarning") == 1
    assert "others could write" in said
    assert not (tmp_path / "PWNED").exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_what_is_no_file_is_not_waited_for(folder):
    os.mkfifo(folder / "pipe.code")
    (folder / "folder.code").mkdir()
    (folder / "link.code").symlink_to("/dev/zero")
    assert [files.read(folder / f"{name}.code") for name in ("pipe", "folder", "link", "nothing")] == [None] * 4


def test_a_relative_folder_stays_where_it_was_first(tmp_path, monkeypatch):
    (tmp_path / "one").mkdir()
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "one")
    monkeypatch.setenv("FASTAFF_CACHE_DIR", f"{tmp_path.name}-relative")
    before = code_folder.cache_root()
    assert before == tmp_path / "one" / f"{tmp_path.name}-relative"
    monkeypatch.chdir(tmp_path / "other")
    assert code_folder.cache_root() == before
    monkeypatch.delenv("FASTAFF_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert code_folder.cache_root().is_absolute()
    assert "relative" not in code_folder.cache_root().parts


# --- sources of the package ------------------------------------------------------------------------------------------


@pytest.fixture
def texts(monkeypatch):
    """The sources of machine code, which a test may edit: what is known of them is forgotten then."""

    class Texts(dict):
        def __setitem__(self, module, text):
            super().__setitem__(module, text)
            forget()

    edited = Texts(sources._texts())
    monkeypatch.setattr(sources, "_texts", lambda: edited)
    monkeypatch.setattr(sources._Index, "keep", lambda: None)
    yield edited
    forget()


def forget():
    """Forget what is known of sources."""
    sources._source.cache_clear()
    sources._key.cache_clear()


def kernel_keys():
    """The keys of kernels of several parts."""
    kernels = stepping.load_lane, birkhoff.weight, loop_lines.read_line, wells.turning_points
    return [keys.function_key(kernel.py_func) for kernel in kernels]


def test_comments_docstrings_and_formatting_are_no_part_of_a_source():
    """Of any source that machine code is made of."""
    for module in random.Random("comments").sample(sources.compiled(), 20 * TIMES):
        text = sources._texts()[module].decode()
        known = sources.parsed(text.encode())
        rewritten = ast.unparse(ast.parse(text))
        for other in (f"# one\n{text}\n\n# more\n", f"'''one'''\n{text}\n'''more'''\n", rewritten):
            assert sources.parsed(other.encode()) == known, module
        assert sources.parsed(f"{text}\nx = 'more'\n".encode()).meaning != known.meaning


@pytest.mark.parametrize(
    ("module", "line", "changed"),
    [
        ("core.descent", "# a comment", [0, 0, 0, 0]),
        ("engine.jit", "# a comment", [0, 0, 0, 0]),
        ("engine.kernels.stepping", "'''A text.'''", [0, 0, 0, 0]),
        ("core.descent", "x = 1", [0, 0, 0, 0]),
        ("systems.formulas.hints", "x = 1", [0, 0, 0, 0]),
        ("engine.kernels.birkhoff", "x = 1", [0, 1, 0, 0]),
        ("engine.kernels.stepping", "x = 1", [1, 1, 0, 0]),
        ("frequencies.kernels.loops", "x = 1", [0, 0, 1, 0]),
        ("tori.kernels.coordinates", "x = 1", [0, 0, 0, 1]),
        ("core.placing", "x = 1", [1, 1, 1, 1]),  # the cache imports it
    ],
)
def test_a_key_has_the_sources_that_its_kernel_imports(texts, module, line, changed):
    """An edit of a line in one changes the keys of those kernels alone; when it is undone, they are the same again."""
    before = kernel_keys()
    assert None not in before
    text = texts[f"fastaff.{module}"]
    texts[f"fastaff.{module}"] = text + f"\n{line}\n".encode()
    assert [one != other for one, other in zip(before, kernel_keys(), strict=True)] == [*map(bool, changed)]
    texts[f"fastaff.{module}"] = text
    assert kernel_keys() == before


def test_an_edit_of_the_compiler_is_another_folder(texts):
    """Also of a module that no kernel imports."""
    hashes = code_folder.compiler_hash.__wrapped__, code_folder.pack_key.__wrapped__
    before = [get() for get in hashes]
    for line, same in (("# a comment", True), ("x = 1", False)):
        texts["fastaff.engine.texts"] += f"\n{line}\n".encode()
        assert [one == get() for one, get in zip(before, hashes, strict=True)] == [same, same]


def test_the_values_that_sources_read_are_of_sources_that_they_import():
    """By the values of modules in this process: functions, classes and modules, but for modules within a package."""
    for module in sources.compiled():
        covered = sources.imported((module,))
        for value in vars(importlib.import_module(module)).values():
            home = value.__name__ if inspect.ismodule(value) else getattr(value, "__module__", None)
            if isinstance(home, str) and home in sources.compiled() and home.rpartition(".")[0] != module:
                assert home in covered, (module, value)


IMPORTS = """
import fastaff.core.names, math
def f():
    if f:
        from .jit import LANES
    from . import blocks, source
class C:
    from ..core import status as s, numbers
from fastaff.systems.models import *
"""


def test_imports_are_found_wherever_they_stand():
    found = sources._targets("fastaff.engine.new", sources.parsed(IMPORTS.encode()).imports)
    names = "core.names", "engine.jit", "engine.blocks", "engine", "core.status", "core.numbers", "systems.models"
    assert sorted(found) == sorted(f"fastaff.{name}" for name in names)
    found = sources._targets("fastaff.engine", sources.parsed(b"from .blocks import source").imports)
    assert found == ["fastaff.engine.blocks"]


def test_only_the_compiler_tells_numba_of_types():
    """What other modules told it would be in no key of a kernel that does not import them."""
    words = re.compile(rb"\b(overload|register_model|infer_getattr|lower_builtin|register_pass)\b")
    found = [module for module, text in sources._texts().items() if words.search(text)]
    assert found
    assert set(found) <= set(sources.compiler())


def test_a_source_that_is_missing_has_no_key():
    assert sources.key(("fastaff.engine.nowhere",)) is None
    assert sources.key(()) is None


def test_a_package_without_sources_has_no_cache(monkeypatch):
    monkeypatch.setattr(sources, "compiler", list)
    assert jit.cache_directory.__wrapped__() is None


@pytest.fixture
def index(tmp_path, monkeypatch):
    """The file of what is known of sources, in a folder of its own; nothing is known yet."""
    monkeypatch.setenv("FASTAFF_CACHE_DIR", str(tmp_path / "root"))
    known = {}
    monkeypatch.setattr(sources._Index, "known", lambda: known)
    monkeypatch.setattr(sources._Index, "more", False)
    forget()
    return tmp_path / "root" / room.INDEX


def test_what_is_known_of_sources_is_kept(index):
    """By a hash of their bytes; what the file told before stays."""
    expected = sources.key(("fastaff.engine.jit",))
    told = sources._told(index, own=True)
    assert told == sources._Index.known()
    assert len(told) == len(sources.imported(("fastaff.engine.jit",)))
    sources._Index.known().clear()
    forget()
    sources.key(("fastaff.core.descent",))
    assert set(told) < set(sources._told(index, own=True))
    sources._Index.known().update(told)
    forget()
    with mock.patch.object(sources, "parsed", side_effect=AssertionError):
        assert sources.key(("fastaff.engine.jit",)) == expected
    room.clear(index.parent)
    assert not index.exists()


@needs_owners
def test_what_others_tell_of_sources_is_not_believed(index, recwarn):
    sources.key(("fastaff.engine.jit",))
    index.chmod(0o666)
    assert sources._told(index, own=True) == {}
    assert sources._told(index.with_name("nowhere"), own=True) == {}
    assert not recwarn.list


# --- room -------------------------------------------------------------------------------------------------------------


def entry(root, rng, used):
    """Write an entry of a cache at a random place, last used at that time; return its path."""
    folder = root / "".join(rng.choices("0123456789abcdef", k=20))
    digits = "".join(rng.choices("0123456789abcdef", k=24))
    inner, name = rng.choice(
        [
            ("", f"kernel_{rng.randint(1, 9)}-{digits}.code"),
            ("blocks", f"check_{digits[:20]}.py"),
            ("formulas", f"{digits}.py"),
        ]
    )
    path = folder / inner / name
    path.parent.mkdir(parents=True, exist_ok=True)
    assert files.write(path, rng.randbytes(rng.randint(100, 900)))
    os.utime(path, (used, used - 10.0))
    return path


OWN = ["notes.txt", "data.code", "formulas/mine.py", "0123456789abcdef0123.py", "kernel-0123.code", "sub/blocks/a.py"]


@pytest.mark.parametrize("seed_", range(2 * TIMES))
def test_what_was_used_longest_ago_goes_first(seed_, tmp_path):
    """And nothing of the user's, even within a folder of entries under the name of one."""
    rng = random.Random(f"room {seed_}")
    root = tmp_path / "cache"
    made = [entry(root, rng, 1e9 + 1000.0 * k) for k in rng.sample(range(100), 40)]
    mine = [root / name for name in OWN] + [made[0].parents[0] / "mine.code"]
    mine += [
        made[1].parent
        / made[1].name.replace(made[1].suffix, f"{'' if rng.random() < 0.5 else '-old'}{made[1].suffix}x")
    ]
    mine.append(root / ("a" * 20) / ("kernel-" + "b" * 24 + ".code"))  # by its name an entry, by its first line none
    for path in mine:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("precious")
        os.utime(path, (1.0, 1.0))
    found = {one.path: one for one in room.entries(root)}
    assert set(made) <= set(found) <= {*made, mine[-1]}
    sizes = {path: path.stat().st_size for path in made}
    most = sum(sizes.values()) * rng.uniform(0.3, 0.9)
    gone = room.bound(root, most)
    left = [path for path in made if path.exists()]
    assert sum(sizes[path] for path in left) <= most
    assert sum(sizes[path] for path in left) > 0.5 * room.KEPT * most
    newest_gone = max(found[one.path].used for one in gone)
    assert newest_gone < min(path.stat().st_atime for path in left)
    assert room.bound(root, most) == []
    room.clear(root)
    assert not any(path.exists() for path in made)
    assert {path.read_text() for path in mine} == {"precious"}
    assert sorted(path for path in root.rglob("*") if path.is_file()) == sorted(mine)


def test_reading_is_use_and_writing_keeps_the_bound(folder, monkeypatch):
    """The hour of a use is kept beside the time of change; what a process writes counts."""
    path = folder / f"kernel-{'0' * 24}.code"
    assert files.write(path, bytes(1000))
    os.utime(path, (1e9, 1e9))
    assert files.read(path) == bytes(1000)
    assert (path.stat().st_mtime, path.stat().st_atime > 1.5e9) == (1e9, True)
    monkeypatch.setattr(room, "MOST", 20_000)
    monkeypatch.setattr(room._Written, "since", None)
    for k in range(100):
        assert files.write(folder / f"kernel-{k:024x}.code", bytes(1000))
        assert sum(one.size for one in room.entries(folder.parent)) < 23_000
    assert (folder / f"kernel-{99:024x}.code").exists()


def test_the_command_says_what_there_is_and_clears_it(folder, capsys):
    from fastaff.cli.main import main

    rng = random.Random("command")
    made = [entry(folder.parent, rng, 1e9) for _ in range(5)]
    (folder.parent / "notes.txt").write_text("precious")
    size = sum(path.stat().st_size for path in made)
    assert main(["cache"]) == 0
    assert f"{folder.parent}: 5 files, {size / 2**20:.1f} MiB of 5 versions" in capsys.readouterr().out
    assert main(["cache", "--clear"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("removed 5 files")
    assert "0 files" in said[1]
    assert [path.name for path in folder.parent.iterdir()] == ["notes.txt"]


def test_classes_of_formulas_are_let_go(monkeypatch):
    """All that are in use can be found; of others the last ones are kept, with their modules."""
    known = library.Classes(most=3)
    made = itertools.count()

    def get(key):
        return known.get(key, lambda: (next(made), type(f"Formula{key}", (tuple,), {}))[1])

    held = get("held")
    for key in range(20):
        get(f"{key}")
    gc.collect()
    assert next(made) == 21
    assert get("held") is held
    assert get("19").__name__ == "Formula19"
    assert next(made) == 22
    get("0")
    assert next(made) == 24
    assert known.named("held", "Formulaheld") is held
    with pytest.raises(AttributeError, match="in use"):
        known.named("held", "Other")


def test_a_formula_is_found_by_its_module_while_it_is_in_use():
    model = fa.hamiltonian("x**2/2 + 0.0314*x**4", coordinates="x")
    cls = type(model)
    home = sys.modules[cls.__module__]
    assert getattr(home, cls.__name__) is cls
    assert pickle.loads(pickle.dumps(model)) == model
    if jit.cache_directory() is not None:
        assert stat.S_ISREG(os.stat(home.__file__).st_mode)
