"""`fastaff doctor`, completion, and help in any width."""

import json
import os
import re
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest

from fastaff.cli import main as cli
from fastaff.cli.commands import doctor
from fastaff.core.compilations import Compiling
from fastaff.results import machine
from fastaff.results.machine import Dependency

CODE = "import sys; from fastaff.cli.main import main; sys.exit(main(sys.argv[1:]))"


def run(*arguments, **environment):
    return subprocess.run(
        [sys.executable, "-c", CODE, *arguments],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, **environment},
    )


@pytest.fixture(scope="module")
def checked():
    """The check once, at a tenth of its size."""
    before = doctor.ORBITS
    doctor.ORBITS = 200
    yield doctor.examined()
    doctor.ORBITS = before


def test_what_is_found(checked, capsys, monkeypatch):
    facts, wrong = checked
    assert wrong == []
    assert facts["versions"]["numba"] == version("numba")
    assert facts["extras"] | {"numba": None, "matplotlib": "plot", "zarr": "io"} == facts["extras"]
    assert facts["check"]["error"] < 1e-11
    assert facts["check"]["orbit_steps_per_second"] > 0
    assert facts["cache"]["writable"]
    assert facts["threads"] >= 1
    assert facts["stamp"].startswith(f"fastaff {facts['fastaff']}, Python ")
    assert "\n" not in facts["stamp"]
    monkeypatch.setattr(doctor, "examined", lambda: checked)
    assert cli.main(["doctor"]) == 0
    said = capsys.readouterr().out
    for row in ("numba", "matplotlib", "cores", "memory", "cache", "kernels", "self-check    passed", "stamp"):
        assert re.search(rf"^{row}", said, re.M)
    assert cli.main(["doctor", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {**facts, "wrong": []}


def test_what_is_wrong(checked, monkeypatch, capsys, tmp_path):
    check = {**checked[0]["check"], "error": np.nan}
    cache = {
        "folder": "f",
        "bytes": 0,
        "used": False,
        "writable": False,
        "problem": "fastaff cannot write its compile cache",
    }
    old = [Dependency("numpy", "1.26.4", "2.0", None), Dependency("scipy", None, "1.15", None)]
    old += [Dependency("zarr", None, "3", "io"), Dependency("h5py", "3.11", "3.11", "io")]
    monkeypatch.setattr(doctor, "_check", lambda: check)
    monkeypatch.setattr(doctor, "_cache", lambda: cache)
    monkeypatch.setattr(machine, "dependencies", lambda: old)
    monkeypatch.setattr(machine, "free_memory", lambda: 2**20)
    assert cli.main(["doctor"]) == 1
    said = capsys.readouterr()
    for sentence in (
        "numpy 1.26.4 is too old: pip install 'numpy>=2.0'",
        "scipy is missing: pip install fastaff",
        "fastaff cannot write its compile cache",
        "only 1 MiB of memory are free",
        "the check failed: harmonic orbits return to nan",
    ):
        assert f"fastaff: {sentence}" in said.err
    assert 'missing, optional: pip install "fastaff[io]"' in said.out
    assert said.err.count("\n") == 5


@pytest.mark.parametrize("compiles", [0, 4])
def test_a_check_that_compiled_says_so(compiles, checked, monkeypatch, capsys):
    """Whether the cache held other kernels does not matter."""
    monkeypatch.setattr(doctor, "ORBITS", 200)

    def computed(run):
        run()
        monkeypatch.setattr(Compiling, "kernels", Compiling.kernels + compiles)

    monkeypatch.setattr(doctor, "compiled", computed)
    check = doctor._check()
    assert check["was_cached"] == (compiles == 0)
    said = dict(doctor._rows({**checked[0], "check": check}))["self-check"]
    assert ("(compiling)" in said) == (compiles == 4)
    assert ("(nothing to compile)" in said) == (compiles == 0)


def test_where_kernels_come_from(monkeypatch):
    """From a pack where one was used, not where there only is one."""
    from fastaff.engine import code_folder, packs
    from fastaff.engine.cache import CodeCache

    monkeypatch.setattr(doctor, "ORBITS", 200)
    monkeypatch.setattr(code_folder, "prebuilt", lambda: packs.Pack(packs.LEVELS["x86-64-v3"], {}))
    monkeypatch.setattr(CodeCache, "prebuilt", 0)
    assert doctor._check()["kernels"] == "compiled here"
    monkeypatch.setattr(CodeCache, "prebuilt", 1)
    assert doctor._check()["kernels"] == "prebuilt x86-64-v3"


def test_a_wheel_of_other_versions_is_named(monkeypatch, tmp_path):
    """Where its machine code does not fit, the versions are said for which it does."""
    from fastaff.engine import code_folder, packs
    from fastaff.engine.cache import CodeCache

    monkeypatch.setattr(doctor, "ORBITS", 200)
    monkeypatch.setattr(packs, "FOLDER", tmp_path)
    monkeypatch.setattr(code_folder, "prebuilt", lambda: None)
    monkeypatch.setattr(CodeCache, "prebuilt", 0)
    assert doctor._check()["kernels"] == "compiled here"
    (tmp_path / "built.json").write_text('{"Python": "3.11.7", "numba": "0.68.1"}')
    assert doctor._check()["kernels"] == (
        "compiled here; the wheel has machine code for Python 3.11.7, numba 0.68.1 and processors of x86-64-v3 or "
        "x86-64-v4"
    )


def test_a_cache_that_cannot_be_used(monkeypatch):
    from fastaff.engine import code_folder

    monkeypatch.setenv("FASTAFF_CACHE_DIR", "/proc/nowhere")
    try:
        found = doctor._cache()
    finally:
        monkeypatch.undo()
        code_folder.cache_directory.cache_clear()
    assert not found["writable"]
    assert not found["used"]
    assert "cannot write its compile cache" in found["problem"]


def test_versions_are_compared_as_numbers():
    assert Dependency("n", "2.10", "2.9", None).wrong is None
    assert "too old" in Dependency("n", "2.9", "2.10", "io").wrong


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion(shell, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("HOME", str(tmp_path))
    target = tmp_path / f"fastaff.{shell}"
    assert cli.main(["--install-completion", "--shell", shell, "--output", str(target)]) == 0
    text = target.read_text()
    for word in ("poincare", "chaos-map", "energy", "p-gamma"):
        assert word in text


def test_completion_in_bash(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    script = tmp_path / "fastaff.bash"
    assert cli.main(["--install-completion", "--shell", "bash", "--output", str(script)]) == 0
    text = f"source {script}; COMP_WORDS=(fastaff poincare --en); COMP_CWORD=2; _fastaff; echo ${{COMPREPLY[@]}}"
    done = subprocess.run(["bash", "-c", text], capture_output=True, text=True, timeout=600)
    assert done.stdout.split() == ["--energy"]


@pytest.mark.parametrize("columns", ["0", "x"])
def test_help_in_no_columns(columns):
    done = run("poincare", "--help", COLUMNS=columns)
    assert done.returncode == 0
    assert "--energy" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 40


def test_wrong_words_load_nothing_heavy():
    """What is wrong with the words of a command is said before anything is drawn, solved or opened."""
    code = (
        "import sys; from fastaff.cli.main import main; code = main(['poincare', '--enrgy', '1']);"
        "print(code, *sys.modules.keys() & {'matplotlib', 'zarr', 'xarray', 'sympy', 'distributed', 'pandas'})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600)
    assert done.stdout.split() == ["2"]
    assert "Did you mean --energy?" in done.stderr
