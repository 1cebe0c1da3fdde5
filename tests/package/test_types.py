"""The types of the public layer: what a type checker knows in a user's script."""

import inspect
import re
import subprocess
import sys
from enum import Enum
from pathlib import Path

import pytest

import fastaff as fa

ROOT = Path(__file__).parents[2]

OPEN = {
    "Body": "potential",  # a value, whose parameters are read as body.potential.C
    "Job": "model initial_conditions",  # a table or a value
    "load": "given return",  # whatever was saved
    "save": "parameters",
    "PeriodicOrbits": "section",  # what the caller gave
    "SectionMap": "section",
    "TorusFit": "model",
    "diffusion_histogram": "diffusion status",
    "ratio_web": "resonances",
    "level_diagram": "make",
}
"""Parameters of public functions and fields of results whose type is not known before they run: it may only shrink."""

SCRIPT = """
from typing import assert_type

import numpy as np

import fastaff as fa

body = fa.Body(fa.NeoHookean(G=1.0, K=2.0), mu=1.0)
section = fa.AlphaTurning(+1)
axes = (np.linspace(0.05, 1.3, 12), np.linspace(-1.5, 1.5, 13))
grid = fa.energy_grid(body, energy=1.5, p_eta=0.3, section=section, axes=axes)
assert_type(grid, fa.sections.EnergyGrid)
cut = fa.poincare_map(body, grid, section="alpha-turning", crossings=200, accuracy=1e-8, scheme="KAHAN_LI8")
assert_type(cut, fa.sections.SectionMap)
assert_type(cut[:3], fa.sections.SectionMap)
assert_type(cut.take([1, 2]).success, bool)
freq = fa.frequency_map(body, grid.z0, time=500.0)
assert_type(freq, fa.frequencies.FrequencyMap)
assert_type(fa.chaos_map(body, grid.z0, time=500.0, indicators=(fa.MEGNO(), "sali")), fa.chaos.ChaosMap)
assert_type(fa.chaos_map(body, grid.z0, time=500.0, indicators="megno").summary(), str)
assert_type(fa.resonances(freq), fa.frequencies.Resonances)

mine = fa.affine_body("C/2*(D1**2 + D2**2) + C/(D1*D2)", C=1.0)
chain = fa.hamiltonian("(x**2 + (y - x)**2)/2 + k/4*(y - x)**4", k=0.5)
kicked = fa.iterated_map("p1 = p + K*sin(x); x1 = x + p1", periodic={"x": "2*pi"}, K=0.9)
lorenz = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
none = fa.models.Zero()
stackel = fa.models.StackelBody(fa.SeparableAlphaBeta(fa.models.Spring(1.0), none), none, none)
systems: list[fa.models.contracts.Dynamics] = [mine, chain, kicked, lorenz, body, stackel, fa.HenonHeiles()]
systems += [fa.models.StandardMap(0.5), fa.models.OneTurnMap(), fa.models.DoublePendulum()]
systems += [fa.reduced_body(body, p_eta=0.1, p_gamma=0.2)]
for system in systems:
    assert_type(fa.integrate(system, [0.1, 0.2], time=3), fa.runs.Orbits)
stiffer = chain._replace(k=2 * chain.k)
fa.continuation(stiffer, [0.1, 0.2, 0.0, 0.0], energy=0.2, scheme=fa.VERNER9)
sample = fa.energy_sample(fa.HenonHeiles(), orbits=10, energy=0.1, axes={"y": (0.0, 0.1)}, rng=np.random.default_rng(1))
tunes = fa.tunes(fa.integrate(kicked, sample, time=64, samples=64).samples)
assert_type(tunes, fa.frequencies.Tunes)
levels = fa.quantum.spectrum(body, m=2, l=0, count=4)
cut.save("cut.npz")
fa.save("cut.csv", cut)
"""

WRONG = {
    "import fastaff as fa\nfa.integrat": 'has no attribute "integrat"',
    "import fastaff as fa\nfa.integrate(fa.HenonHeiles(), [0.0], time='long')": 'expected "float"',
    "import fastaff as fa\nfa.integrate(fa.NeoHookean(), [0.0], time=1.0)": '"NeoHookean"',
    "import fastaff as fa\nfa.integrate(fa.HenonHeiles(), [0.0], time=1.0).zz": 'no attribute "zz"',
    "import fastaff as fa\nfa.frequency_map(fa.HenonHeiles(), [0.0], tme=1.0)": "tme",
}
"""Mistakes, and a word of what the type checker says."""


PARTS = (fa.runs, fa.frequencies, fa.sections, fa.chaos, fa.periodic, fa.tori)


def _signatures():
    public = {name: getattr(home, name) for home in (fa, *PARTS, fa.quantum) for name in home.__all__}
    for name, value in public.items():
        if inspect.isfunction(value) or (inspect.isclass(value) and not issubclass(value, (int, Enum, BaseException))):
            yield name, inspect.signature(value)


def test_no_signature_says_any():
    said = {}
    for name, signature in _signatures():
        entries = {entry.name: entry.annotation for entry in signature.parameters.values()}
        entries["return"] = signature.return_annotation
        texts = {key: getattr(given, "__forward_arg__", given) for key, given in entries.items()}
        words = [key for key, text in texts.items() if isinstance(text, str) and re.search(r"\bAny\b", text)]
        untyped = [key for key, text in texts.items() if text is inspect.Parameter.empty and key != "return"]
        if words or untyped:
            said[name] = " ".join([*words, *untyped])
    assert said == OPEN


def _checked(tmp_path, text):
    script = tmp_path / f"script_{hash(text) % 10**9}.py"  # a name of its own: mypy keeps what a name held
    script.write_text(text)
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--config-file=", str(script)]
    return subprocess.run(command, cwd=tmp_path, env={"MYPYPATH": str(ROOT)}, capture_output=True, text=True)


@pytest.mark.slow
def test_a_script_passes_mypy_strict(tmp_path):
    pytest.importorskip("mypy")
    done = _checked(tmp_path, SCRIPT)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_mypy_sees_mistakes(tmp_path):
    pytest.importorskip("mypy")
    for text, word in WRONG.items():
        done = _checked(tmp_path, text)
        assert done.returncode == 1, (text, done.stdout, done.stderr)
        assert word in done.stdout, (text, done.stdout)
