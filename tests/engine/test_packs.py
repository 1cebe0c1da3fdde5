"""Packs of machine code: the bits of what is compiled here, and no code of another version, processor or name.

A copy of the package gets packs of a few kernels, as a wheel has them; fresh processes with empty caches use them.
"""

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fastaff
from fastaff.engine import cache as files
from fastaff.engine import code_folder as _code_folder
from fastaff.engine import jit as _jit
from fastaff.engine import packs
from fastaff.engine.packs import LEVELS, InstructionLevel
from fastaff.results.machine import get_host_cpu_features

PACKAGE = Path(fastaff.__file__).parent
KNOWN = {name[1:] for name in get_host_cpu_features().split(",") if name.startswith("+")}
HERE = [level for level in LEVELS.values() if set(level.instructions) <= KNOWN]

compiles = pytest.mark.skipif(_jit.JIT_DISABLED, reason="no compiler, no code")
runs_a_level = pytest.mark.skipif(
    platform.machine().lower() not in ("x86_64", "amd64") or not HERE, reason="this processor has no level"
)

FEW = """
import json, numpy as np
from fastaff.engine.cache import CodeCache
from fastaff.engine.kernels import birkhoff, stepping
block = np.zeros(4000)
stepping.load_lane(np.ones((2, 1)), 0, block, 0)
shown = [block, [birkhoff.weight(x) for x in np.linspace(-0.9, 0.9, 7)]]
"""
INTEGRATE = """
from fastaff import HenonHeiles, integrate
z0 = np.outer([0.1, 0.2, 0.3, 0.1], np.linspace(0.5, 1.0, 5))
run = integrate(HenonHeiles(), z0, time=10.0, samples=3, step=0.1)
shown += [run.z, run.samples, run.energy_error]
"""
MORE = """
from fastaff import AlphaTurning, Body, NeoHookean, chaos_map, frequency_map, poincare_map
body, start = Body(NeoHookean()), np.array([1.5, 0, 0.3, 0, 0, 0.2, 0.1, 0.3])
for z0 in (start, np.outer(start, np.linspace(0.98, 1.02, 11))):
    cut = poincare_map(body, z0, section=AlphaTurning(), crossings=10, max_time=100.0)
    found = frequency_map(body, z0, time=100.0)
    chaos = chaos_map(body, z0, time=100.0)
    shown += [cut.points, cut.times, cut.energy_error, found.nu, found.error, chaos.values]
"""
SHOW = """
bits = [np.asarray(numbers, float).tobytes().hex() for numbers in shown]
print(json.dumps([bits, CodeCache.misses, CodeCache.prebuilt]))
"""


def run(code, cache, package=PACKAGE, **env):
    """Run a fresh process; return its bits, how often it compiled, how often it used a pack, and its warnings."""
    environment = os.environ | {"FASTAFF_CACHE_DIR": str(cache), "PYTHONPATH": str(package.parent)} | env
    for name in {"NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"} - env.keys():
        environment.pop(name, None)
    command = [sys.executable, "-P", "-W", "always", "-c", code + SHOW]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return *json.loads(done.stdout), done.stderr


def compiled_for(level, code, folder):
    """Compile code for a level in a process of its own; return the folder of machine code."""
    run(code, folder, NUMBA_CPU_NAME=level.name, NUMBA_CPU_FEATURES=level.features)
    (found,) = filter(Path.is_dir, folder.iterdir())
    return found


def copied(folder):
    """A copy of the package, as it is installed from a wheel without packs."""
    shutil.copytree(PACKAGE, folder / "fastaff", ignore=shutil.ignore_patterns("__pycache__", "prebuilt"))
    return folder / "fastaff"


def prebuilt(package):
    """The folder of packs of a copy."""
    return package / packs.FOLDER.relative_to(PACKAGE)


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """Machine code of few kernels for the highest level of this machine, and what it says when compiled here."""
    folder = tmp_path_factory.mktemp("few")
    bits, misses, taken, said = run(FEW, folder / "native")
    assert misses >= 2
    assert (taken, said) == (0, "")
    return compiled_for(HERE[0], FEW, folder / "level"), bits, misses


def packed(few, tmp_path, code=None):
    """A copy of the package with a pack of that code, or of the few kernels."""
    package = copied(tmp_path)
    path = packs.build(code or few[0], HERE[0], _code_folder.pack_key(), prebuilt(package))
    return package, path


def levels(*marks):
    """Parametrise a test by the levels of this processor, those below the highest with these marks."""
    rows = [pytest.param(level, id=level.name, marks=marks if level != HERE[0] else ()) for level in HERE]
    return pytest.mark.parametrize("level", rows)


@compiles
@runs_a_level
@levels(pytest.mark.slow)
def test_a_pack_has_the_bits_of_code_compiled_here(level, tmp_path):
    """Of every level that this processor has; with an empty cache nothing is compiled and nothing is written there."""
    package = copied(tmp_path)
    packs.build(
        compiled_for(level, FEW + INTEGRATE, tmp_path / "level"), level, _code_folder.pack_key(), prebuilt(package)
    )
    expected, *_ = run(FEW + INTEGRATE, _code_folder.cache_root())
    bits, misses, taken, said = run(FEW + INTEGRATE, tmp_path / "empty", package)
    assert bits == expected
    assert misses == 0
    assert taken >= 5
    assert said == ""
    assert not list((tmp_path / "empty").rglob(f"*{files.SUFFIX}"))


@pytest.mark.slow
@compiles
@runs_a_level
@levels()
def test_sections_frequencies_and_indicators_have_the_same_bits_too(level, tmp_path):
    package, code = copied(tmp_path), FEW + MORE
    packs.build(compiled_for(level, code, tmp_path / "level"), level, _code_folder.pack_key(), prebuilt(package))
    expected, *_ = run(code, _code_folder.cache_root())
    bits, misses, taken, said = run(code, tmp_path / "empty", package)
    assert bits == expected
    assert (misses, said) == (0, "")
    assert taken >= 30


@compiles
@runs_a_level
def test_a_pack_of_other_sources_is_not_used(few, tmp_path):
    """A comment is no edit; a line in a kernel's source is one for that kernel, in the compiler for all."""
    package, _ = packed(few, tmp_path)
    assert run(FEW, tmp_path / "one", package)[1:] == (0, few[2], "")
    edits = ("kernels/birkhoff", "# edited", 0), ("kernels/birkhoff", "EDITED = 1", 1), ("texts", "EDITED = 1", few[2])
    for number, (name, line, compiled) in enumerate(edits):
        path = package / f"engine/{name}.py"
        path.write_text(f"{path.read_text()}\n{line}\n")
        assert run(FEW, tmp_path / f"{number}", package) == (few[1], compiled, few[2] - compiled, "")


ELSEWHERE = {
    "another Numba": "import numba; numba.__version__ = '0.0.1'",
    "another Python": "import sysconfig; sysconfig.get_config_vars()['EXT_SUFFIX'] = '.cpython-30-x86_64-linux-gnu.so'",
    "another processor": "from fastaff.engine import code_folder; "
    "code_folder.get_host_cpu_features = lambda: '+sse4.2,-avx2,-fma'",
}


@compiles
@runs_a_level
@pytest.mark.parametrize("where", ELSEWHERE)
def test_elsewhere_kernels_are_compiled(few, tmp_path, where):
    """With the same bits and without a word; `pip` refuses the wheel of another Python, unless it is unpacked."""
    package, _ = packed(few, tmp_path)
    assert run(ELSEWHERE[where] + FEW, tmp_path / "cache", package) == (few[1], few[2], 0, "")


@compiles
@runs_a_level
def test_ones_own_code_comes_before_a_pack_and_what_a_pack_lacks_is_compiled(few, tmp_path):
    code = tmp_path / "code"
    shutil.copytree(few[0], code)
    sorted(code.glob(f"*{files.SUFFIX}"))[0].unlink()
    package, path = packed(few, tmp_path, code)
    assert run(FEW, tmp_path / "cache", package) == (few[1], 1, few[2] - 1, "")
    assert run(FEW, tmp_path / "cache", package) == (few[1], 0, few[2] - 1, "")
    path.unlink()
    run(FEW, tmp_path / "cache", package)
    packs.build(few[0], HERE[0], _code_folder.pack_key(), prebuilt(package))
    assert run(FEW, tmp_path / "cache", package) == (few[1], 0, 0, "")


@compiles
@runs_a_level
def test_a_damaged_pack_costs_one_warning_and_code_under_another_name_is_not_run(few, tmp_path):
    package, path = packed(few, tmp_path)
    whole = bytearray(path.read_bytes())
    whole[len(whole) // 2] ^= 1
    path.write_bytes(whole)
    bits, misses, taken, said = run(FEW, tmp_path / "damaged", package)
    assert (bits, misses, taken) == (few[1], few[2], 0)
    assert said.count("RuntimeWarning") == 1
    path.unlink()
    code = tmp_path / "code"
    code.mkdir()
    names = sorted(file.name for file in few[0].glob(f"*{files.SUFFIX}"))
    for name, other in zip(names, names[1:] + names[:1], strict=True):
        files.write(code / name, files.read(few[0] / other))
    packs.build(code, HERE[0], _code_folder.pack_key(), prebuilt(package))
    assert run(FEW, tmp_path / "exchanged", package) == (few[1], few[2], 0, "")


# --- packs as files ----------------------------------------------------------------------------------------------


@pytest.fixture
def code(tmp_path):
    """A folder with two files, of no code."""
    (tmp_path / "code").mkdir()
    for name in ("one", "two"):
        assert files.write(tmp_path / "code" / f"{name}{files.SUFFIX}", name.encode() * 50)
    return tmp_path / "code"


V4, V3 = LEVELS["x86-64-v4"], LEVELS["x86-64-v3"]


def test_the_highest_level_that_a_processor_has_is_taken(code, tmp_path):
    folder = tmp_path / "packs"
    for level in (V3, V4):
        packs.build(code, level, "key", folder)
    assert set(V3.instructions) < set(V4.instructions)
    found = packs.best(folder, "key", V4.instructions)
    assert found.level == V4
    assert found.code(f"one{files.SUFFIX}") == b"one" * 50
    assert found.code(f"three{files.SUFFIX}") is None
    assert packs.best(folder, "key", (*V3.instructions, "avx512f")).level == V3
    assert packs.best(folder, "other", V4.instructions) is None
    assert packs.best(tmp_path / "nowhere", "key", V4.instructions) is None
    for missing in V3.instructions:
        assert packs.best(folder, "key", set(V4.instructions) - {missing}) is None


def test_no_damaged_and_no_renamed_pack_is_taken(code, tmp_path, unwarned):
    """Any flipped bit of each byte's, any missing end; that of another key or of another level."""
    path, rng = packs.build(code, V3, "key", tmp_path / "packs"), np.random.default_rng(3)
    whole = path.read_bytes()
    versions = [whole[:end] for end in range(len(whole))] + [whole + b"\0"]
    for at in range(len(whole)):
        version = bytearray(whole)
        version[at] ^= 1 << rng.integers(8)
        versions.append(bytes(version))

    def found():
        for version in versions:
            path.write_bytes(version)
            yield packs.best(path.parent, "key", V4.instructions)
        for other in (path.with_name("x86-64-v3-new.pack"), path.with_name("x86-64-v4-key.pack")):
            other.write_bytes(whole)
        yield packs.best(path.parent, "new", V4.instructions)
        path.write_bytes(whole)
        yield packs.best(path.parent, "key", V4.instructions)

    with pytest.warns(RuntimeWarning, match="damaged files"):
        *others, last = found()
    assert others == [None] * (len(versions) + 1)
    assert last.level == V3


@pytest.mark.parametrize("wrong", ["empty", "damaged"])
def test_a_pack_is_made_of_undamaged_code_alone(code, tmp_path, unwarned, wrong):
    if wrong == "empty":
        code = tmp_path / "nothing"
        code.mkdir()
        with pytest.raises(ValueError, match="must be a folder of undamaged machine code"):
            packs.build(code, V3, "key", tmp_path)
        return
    (code / f"one{files.SUFFIX}").write_bytes(b"something else")
    with (
        pytest.warns(RuntimeWarning, match="damaged files"),
        pytest.raises(ValueError, match="must be a folder of undamaged machine code"),
    ):
        packs.build(code, V3, "key", tmp_path)


@pytest.mark.parametrize("name", ["CPU_NAME", "CPU_FEATURES"])
def test_who_names_a_processor_gets_code_for_it(monkeypatch, name):
    """Whatever packs there are."""
    monkeypatch.setattr(_code_folder, "best", lambda *_: packs.Pack(V3, {}))
    monkeypatch.setattr(_jit.config, "CPU_NAME", None)
    monkeypatch.setattr(_jit.config, "CPU_FEATURES", None)
    assert _code_folder.prebuilt.__wrapped__() == packs.Pack(V3, {})
    monkeypatch.setattr(_jit.config, name, "generic")
    assert _code_folder.prebuilt.__wrapped__() is None


@pytest.mark.parametrize("level", LEVELS.values(), ids=LEVELS)
def test_levels_name_instruction_sets_as_numba_takes_them(level):
    """With fused multiply-add, which is asked for by name."""
    assert isinstance(level, InstructionLevel)
    assert level.features.split(",") == [f"+{name}" for name in level.instructions]
    assert "+fma" in level.features.split(",")
