"""What a release says of itself is the same everywhere, and names of wheels say where their machine code runs."""

import importlib.util
import sys
import zipfile
from pathlib import Path

import pytest

import fastaff as fa

ROOT = Path(__file__).parents[2]


def script(name):
    """A script of `.ci` as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / f".ci/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def release():
    """The script of `make release`."""
    return script("release")


@pytest.fixture
def wheel():
    """The script of `make wheel`."""
    return script("wheel")


def test_version_and_date_agree(release):
    said = release.facts()
    assert release.disagreements(said) == []
    assert {version for version, _ in said.values()} == {fa.__version__}
    assert release.tag().startswith(f"fastaff {fa.__version__} ")


def test_disagreements_are_named(release):
    said = release.facts()
    for name, value in (("CITATION.cff", ("0.0.1", "2026-01-01")), ("CHANGELOG.md", (fa.__version__, "2001-01-01"))):
        assert any(name in line for line in release.disagreements({**said, name: value}))
    assert release.disagreements({**said, "CITATION.cff": (fa.__version__, "soon")})


def test_the_platform_of_a_wheel_is_that_of_the_installed_numba(wheel):
    tags = pytest.importorskip("packaging.tags")
    assert wheel.numba_platform() in {tag.platform for tag in tags.sys_tags()} - {"any"}


def made(folder, tags, files):
    """A wheel of that name with files of no content."""
    path = folder / f"fastaff-{fa.__version__}-{tags}.whl"
    with zipfile.ZipFile(path, "w") as packed:
        for name in files:
            packed.writestr(name, "")
    return path


PLAIN = ["fastaff/__init__.py", "fastaff/engine/packs.py"]
PACKED = [*PLAIN, "fastaff/engine/prebuilt/x86-64-v3-0123.pack"]


def test_a_wheel_with_machine_code_is_for_one_python_and_platform(wheel, tmp_path):
    """pip would install one for any Python where none of its code runs."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    right = f"{python}-{python}{sys.abiflags}-{wheel.numba_platform()}"
    assert wheel.misnomer(made(tmp_path, right, PACKED)) == ""
    for tags in ("py3-none-any", "cp39-cp39-win_amd64", f"{python}-none-any", f"py3-none-{wheel.numba_platform()}"):
        assert f"must have the tags {right}, as it has packs" in wheel.misnomer(made(tmp_path, tags, PACKED))
    assert wheel.misnomer(made(tmp_path, "py3-none-any", PLAIN)) == ""
    assert "py3-none-any, as it has no packs" in wheel.misnomer(made(tmp_path, right, PLAIN))


def test_pip_takes_a_wheel_with_machine_code_for_this_python_alone(wheel):
    """By the tags that pip asks: of this Python those of the wheel are among them, of others none."""
    tags = pytest.importorskip("packaging.tags")
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    named = tags.parse_tag(f"{python}-{python}{sys.abiflags}-{wheel.numba_platform()}")
    assert named & set(tags.sys_tags())
    for minor in {10, 11, 12, 13, 14} - {sys.version_info.minor}:
        others = tags.cpython_tags((3, minor), platforms=[*tags.platform_tags()])
        assert not named & {*others, *tags.compatible_tags((3, minor))}
