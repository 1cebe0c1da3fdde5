"""Build a wheel with packs: machine code of the package's own kernels, compiled for levels of x86-64.

Works on a copy of the tree, which stays without packs. They serve the versions of Python and Numba that run this. The
name of the wheel has tags of that Python and of the platform of its Numba, so pip refuses it elsewhere.
Run: python .ci/wheel.py FOLDER
"""

import json
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).parents[1]
FILES = ("pyproject.toml", "README.md", "LICENSE", "MANIFEST.in")

SETUP = """
from setuptools import Distribution, setup


class WithMachineCode(Distribution):
    def has_ext_modules(self):
        return True


setup(distclass=WithMachineCode, options={{"bdist_wheel": {{"plat_name": {platform!r}}}}})
"""
"""The `setup.py` of a wheel with packs: setuptools then names the version of Python and the platform."""


def numba_platform() -> str:
    """Return the platform tag of the installed Numba, which runs the machine code; of several the first."""
    lines = (metadata.distribution("numba").read_text("WHEEL") or "").splitlines()
    tags = sorted(line.rpartition("-")[2] for line in lines if line.startswith("Tag: "))
    return tags[0] if tags and tags[0] != "any" else sysconfig.get_platform()


def main(target: Path) -> None:
    """Build the wheel in a folder."""
    with tempfile.TemporaryDirectory() as place:
        tree = Path(place) / "tree"
        ignored = shutil.ignore_patterns("__pycache__", "prebuilt")
        shutil.copytree(ROOT / "fastaff", tree / "fastaff", ignore=ignored)
        for name in FILES:
            shutil.copy(ROOT / name, tree)
        if platform.machine().lower() in ("x86_64", "amd64"):
            _packs(tree, Path(place))
        (wheel,) = wheels(tree, Path(place) / "wheel")
        if wrong := misnomer(wheel):
            raise SystemExit(wrong)
        target.mkdir(parents=True, exist_ok=True)
        shutil.copy(wheel, target)
    print(f'pip install "{target / wheel.name}[demo]"')


def wheels(tree: Path, folder: Path) -> list[Path]:
    """Build the wheel of a tree in a new folder; with packs its tags are those of this Python and its Numba."""
    if any(tree.glob("fastaff/engine/prebuilt/*.pack")):
        (tree / "setup.py").write_text(SETUP.format(platform=numba_platform()))
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--wheel-dir", str(folder), str(tree)], check=True)
    return list(folder.glob("*.whl"))


def misnomer(wheel: Path) -> str:
    """Return what is wrong with the name of a wheel; "" for one that is right. With packs it has the tags of this
    Python and of the platform of its Numba, without packs those of any Python 3.
    """
    with zipfile.ZipFile(wheel) as packed:
        code = any(name.endswith(".pack") for name in packed.namelist())
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    abi = f"{python}{sys.abiflags}"
    right = f"{python}-{abi}-{re.sub('[-.]', '_', numba_platform())}" if code else "py3-none-any"
    named = "-".join(wheel.stem.split("-")[-3:])
    return "" if named == right else f"{wheel.name} must have the tags {right}, as it has {'' if code else 'no '}packs"


def _packs(tree: Path, place: Path) -> None:
    """Compile for all levels at once, in processes of their own; put the packs into the tree, with what is known of
    the sources.
    """
    sys.path.insert(0, str(tree))
    from fastaff.engine.cache import SUFFIX
    from fastaff.engine.code_folder import pack_key, prebuilt
    from fastaff.engine.packs import FOLDER, LEVELS, build
    from fastaff.engine.room import INDEX

    def start(name: str, **told: str) -> subprocess.Popen:
        environment = {**os.environ, "PYTHONPATH": str(tree), "FASTAFF_CACHE_DIR": str(place / name), **told}
        return subprocess.Popen([sys.executable, __file__, "--calls"], env=environment)

    def end(processes: list[subprocess.Popen]) -> None:
        codes = [process.wait() for process in processes]
        if any(codes):
            raise SystemExit("the calls whose code is packed have failed")

    levels = LEVELS.values()
    end([start(one.name, NUMBA_CPU_NAME=one.name, NUMBA_CPU_FEATURES=one.features) for one in levels])
    for level in levels:
        (code,) = filter(Path.is_dir, (place / level.name).iterdir())
        pack = build(code, level, pack_key(), FOLDER)
        print(f"{pack.name}: {pack.stat().st_size / 2**20:.1f} MiB")
    shutil.copy(place / next(iter(LEVELS)) / INDEX, FOLDER)
    built = {"Python": platform.python_version(), **{name: metadata.version(name) for name in ("numba", "llvmlite")}}
    (FOLDER / "built.json").write_text(json.dumps(built))
    end([start("again")])
    if prebuilt() is not None and list((place / "again").rglob(f"*{SUFFIX}")):
        raise SystemExit("the same calls compile something that the pack lacks")


def calls() -> None:
    """Make the calls whose code is packed."""
    import numpy as np

    import fastaff as fa
    from fastaff.cli.commands.warmup import warmup
    from fastaff.systems.models import StandardMap

    warmup()
    potentials = fa.Harmonic(), fa.Anharmonic(), fa.Hyperelastic(), fa.NeoHookean(), fa.HeavyTop()
    deformed, plane = [1.5, 0, 0.3, 0, 0, 0.2, 0.1, 0.3], [0.0, 0.1, 0.4, 0.14]
    systems = [(fa.Body(potential), deformed, fa.AlphaTurning()) for potential in potentials]
    for model, start, section in [*systems, (fa.HenonHeiles(), plane, fa.Hyperplane((1, 0, 0, 0)))]:
        for z0 in (np.array(start), np.outer(start, np.linspace(1.0, 1.01, 20))):
            loose = {"accuracy": 1e-4, "energy_tolerance": 1.0}
            fa.integrate(model, z0, time=2.0, samples=2, **loose)
            fa.poincare_map(model, z0, section=section, crossings=2, max_time=20.0, **loose)
            fa.frequency_map(model, z0, time=20.0, **loose)
            fa.chaos_map(model, z0, time=20.0)
    for section in (fa.BetaTurning(), fa.AlphaEquals(1.5), fa.BetaEquals(0.3), fa.AreaEquals(1.0)):
        fa.poincare_map(fa.Body(fa.NeoHookean()), deformed, section=section, crossings=2, max_time=20.0, step=0.05)
    angles = 2 * np.pi * np.outer([0.1234, 0.2345, 0.3456], np.arange(1024))
    fa.naff(np.exp(1j * angles), 1.0, lines=2)
    fa.naff(np.cos(angles), 1.0, lines=2)
    for planes in (1, 2, 3):
        turns = np.concatenate([np.cos(angles[:planes]), -np.sin(angles[:planes])])
        fa.tunes(turns)
    fa.frequency_map(StandardMap(0.5), [[0.1, 0.2], [0.3, 0.4]], time=256)


if __name__ == "__main__":
    if sys.argv[1:] == ["--calls"]:
        calls()
    else:
        main(Path(sys.argv[1]).resolve())
