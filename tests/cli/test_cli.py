"""The command line and the files it writes."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import fastaff
from fastaff import files
from fastaff.cli import application, options
from fastaff.cli import demonstration as demo
from fastaff.cli import main as cli
from fastaff.core.interruption import imported
from fastaff.jobs import scans

pytest.importorskip("cyclopts")
pytest.importorskip("matplotlib")

SURFACE = ["--energy", "1.5", "--p-eta", "0.3", "--p-gamma", "0.2"]


@dataclasses.dataclass
class Result:
    """The smallest thing that can be saved."""

    status: np.ndarray
    points: np.ndarray
    section: object
    scheme: object
    step: float


def small() -> Result:
    return Result(
        np.array([0, 0, 5]), np.arange(6.0).reshape(3, 2), fastaff.AlphaEquals(1.5), fastaff.KAHAN_LI8, np.inf
    )


# Files


def test_round_trip_keeps_arrays_bitwise_and_all_parameters(tmp_path):
    body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=3.0), 2.0)
    result = small()
    result.points[0, 0] = np.nan
    path = files.save(tmp_path / "a.npz", result, model=body, seed=7, threads=2, z0=np.eye(2), wall_time=0.5)
    arrays, metadata = files.contents(path)
    assert path.name == "a.npz"
    assert arrays["points"].tobytes() == result.points.tobytes()
    assert arrays["z0"].tobytes() == np.eye(2).tobytes()
    assert metadata["model"] == {"class": "Body", "potential": {"class": "NeoHookean", "G": 1.0, "K": 3.0}, "mu": 2.0}
    assert metadata["section"] == {"class": "AlphaEquals", "constant": 1.5, "direction": 1}
    assert metadata["scheme"]["name"] == "KAHAN_LI8"
    assert metadata["step"] == "inf"
    assert metadata["seed"] == 7
    assert metadata["status_counts"] == {"OK": 2, "TOO_FEW_CROSSINGS": 1}
    assert metadata["fastaff"] == fastaff.__version__
    for name in ("numpy", "numba", "python", "platform", "cpu", "cores", "date", "command"):
        assert metadata[name]


def test_save_never_overwrites_unless_told(tmp_path):
    first = files.save(tmp_path / "a", small(), seed=1)
    second = files.save(tmp_path / "a", small(), seed=2)
    assert [first.name, second.name] == ["a.npz", "a-2.npz"]
    assert files.contents(first).metadata["seed"] == 1
    assert files.save(tmp_path / "a", small(), seed=3, overwrite=True) == first
    assert files.contents(first).metadata["seed"] == 3
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a-2.npz", "a.npz"]


def test_a_failed_save_leaves_nothing_behind(tmp_path):
    bad = small()
    bad.points = np.array([object()])
    with pytest.raises(TypeError, match="points must hold numbers"):
        files.save(tmp_path / "a", bad)
    with pytest.raises(TypeError, match="result must be"):
        files.save(tmp_path / "a", [1, 2])
    assert list(tmp_path.iterdir()) == []


def test_load_refuses_other_files(tmp_path):
    np.savez(tmp_path / "plain.npz", a=np.zeros(2))
    (tmp_path / "text.npz").write_text("hello")
    np.savez(tmp_path / "pickled.npz", metadata=np.array([{"a": 1}], dtype=object))
    for name in ("plain", "text", "pickled"):
        with pytest.raises(ValueError, match="must be a file written by fastaff"):
            files.contents(tmp_path / f"{name}.npz")
    with pytest.raises(FileNotFoundError):
        files.contents(tmp_path / "absent.npz")


# Wrong input: one line, exit code 2


KEPLER = (
    "(u**2 + v**2)/2 - 1/sqrt(x**2 + y**2) - 0.006*(u**2 + v**2)**2/8"
    " - 0.01*(3.1*(u**2 + v**2) + (x*u + y*v)**2/10/(x**2 + y**2))/2/sqrt(x**2 + y**2) + 0.005/(x**2 + y**2)"
)
"""To the next order in 1/c^2: its -p^4 lets fast orbits go anywhere."""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["poincare"], "--energy is required"),
        (["poincare", "--energy", "-1"], "--energy must be at least the minimum 0 of this body"),
        (["poincare", "--energy", "abc"], "--energy"),
        (["poincare", *SURFACE, "--model", "neohokean"], "Did you mean neo-hookean?"),
        (["poincare", "--model", "henon", "--energy", "1"], "Did you mean henon-heiles or henon-map?"),
        (["poincare", "--hamiltonian", "-cos(x)", "--energy", "0"], "equals sign: --hamiltonian='-cos(x)'"),
        (["poincare", "--map", "--orbits", "3"], "--map takes a value  ("),
        (
            ["poincare", "--hamiltonian=-cos(x) - cos(y)", "--energy", "-1"],
            "Pass --q-range and --p-range, such as -1.5708:1.5708 and -1.41421:1.41421.",
        ),
        (
            [
                "poincare",
                f"--hamiltonian={KEPLER}",
                "--momenta",
                "u v",
                "--energy=-0.62",
                "--orbits",
                "6",
                "--section",
                "y=0",
            ],
            "does not bound the motion: give --q-range and --p-range",
        ),
        (["poincare", *SURFACE, "--C", "2"], "--C is not a parameter of neo-hookean"),
        (["poincare", *SURFACE, "--scheme", "KAHANLI"], "Did you mean KAHAN_LI8?"),
        (["poincare", *SURFACE, "--section", "alpha-turnig"], "Did you mean alpha-turning?"),
        (["poincare", *SURFACE, "--section", "alpha=wide"], "--section alpha=c: c must be a number such as 1.5, 1/6"),
        (["poincare", *SURFACE, "--section", "x=0"], "--section must be one of alpha-turning"),
        (["poincare", *SURFACE, "--direction", "2"], "--direction must be"),
        (["poincare", *SURFACE, "--grid", "100000x100000"], "--grid asks for 1.164 TiB of memory"),
        (["poincare", *SURFACE, "--orbits", "100000000000"], "--orbits asks for 93.13 GiB of memory"),
        (["poincare", *SURFACE, "--grid", "0x3"], "--grid must be"),
        (["poincare", *SURFACE, "--grid", "3x3", "--orbits", "4"], "not both"),
        (["poincare", *SURFACE, "--q-range", "2:1"], "LOW:HIGH"),
        (["poincare", *SURFACE, "--crossings", "0"], "crossings must be at least 1"),
        (["poincare", *SURFACE, "--out", "/nowhere/at/all"], "does not exist"),
        (["poincare", *SURFACE, "--sction", "x"], "--section"),
        (["poincar"], "Did you mean"),
        (
            ["poincare", *SURFACE, "--formula", "D1**2", "--model", "harmonic"],
            "give one of --model, --formula, --hamiltonian, --map and --ode",
        ),
        (["poincare", *SURFACE, "--formula", "C*D1*D2", "--C", "2"], "a formula takes --parameter C=2"),
        (["poincare", *SURFACE, "--orbits", "2.7"], "--orbits: it must be a whole number, got '2.7'"),
        (["poincare", *SURFACE, "--parameter", "C=2"], "--parameter belongs to --formula, --hamiltonian, --map"),
        (["poincare", *SURFACE, "--formula", "C*D1*D2", "--parameter", "C"], "NAME=VALUE"),
        (
            ["poincare", *SURFACE, "--formula", "C*D1*D2", "--parameter", "C=1", "--parameter", "C=2"],
            "--parameter C is given twice",
        ),
        (["poincare", *SURFACE, "--formula", "D1*D2", "--parameter", "mu=2"], "mu is an option of its own, --mu"),
        (
            ["poincare", *SURFACE, "--formula", "D1*D2", "--coordinates", "x y"],
            "--coordinates belongs to --hamiltonian",
        ),
        (["poincare", *SURFACE, "--hamiltonian", "x*y", "--mu", "2"], "--mu belongs to bodies"),
        (["chaos-map"], "--energy is required"),
        (["chaos-map", *SURFACE, "--indicators", "megno,salli"], "Did you mean sali?"),
        (["chaos-map", *SURFACE, "--indicators", "megno,megno"], "indicators must differ"),
        (
            ["chaos-map", *SURFACE, "--indicators", "zero_one_test", "--early-stop"],
            "--early-stop must be False with ",
        ),
        (["chaos-map", *SURFACE, "--time", "0"], "time must be positive"),
        (["chaos-map", *SURFACE, "--time", "10", "--returns", "10"], "--time or --returns, not both"),
        (["chaos-map", *SURFACE, "--scan", "enrgy=1:2:3"], "Did you mean energy?"),
        (["chaos-map", *SURFACE, "--scan", "C=1:2:3"], "must be one of energy, p_eta, p_gamma, p_phi, p_psi, G, K, mu"),
        (["chaos-map", *SURFACE, "--scan", "energy=2:1:3"], "NAME=LOW:HIGH:N"),
        (["chaos-map", *SURFACE, "--scan", "energy=1:2"], "NAME=LOW:HIGH:N"),
        (["chaos-map", *SURFACE, "--scan", "K=1:2:2", "--scan", "K=1:2:2"], "two different parameters"),
        (
            ["chaos-map", *SURFACE, "--scan", "K=1:2:2", "--scan", "G=1:2:2", "--scan", "mu=1:2:2"],
            "one or two parameters",
        ),
        (["chaos-map", *SURFACE, "--scan", "p_phi=0:1:2", "--scan", "p_eta=0:1:2"], "not one of each"),
        (["chaos-map", *SURFACE, "--scan", "K=1:2:2", "--grid", "4x4"], "--scan requires --orbits"),
        (["chaos-map", "--scan", "energy=-2:-1:2"], "no case of the scan has orbits"),
        (
            ["chaos-map", "--model", "henon-heiles", "--energy", "0.1", "--scan", "p_eta=0:1:2"],
            "must be one of energy, lam",
        ),
        (["frequency-map", *SURFACE, "--time", "-4"], "time must be positive"),
        (["frequency-map", *SURFACE, "--method", "naff"], "--method"),
    ],
)
def test_wrong_input_is_one_clear_line(arguments, said, refused):
    refused(arguments, said)


def test_missing_extras_are_named(monkeypatch, capsys):
    monkeypatch.setattr(application, "cyclopts", None)
    assert cli.main(["demo"]) == 2
    assert 'pip install "fastaff[demo]"' in capsys.readouterr().err


BARE = """
import importlib.abc, sys

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"cyclopts", "rich", "matplotlib", "sympy", "zarr", "xarray"}:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
from fastaff.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


def test_the_explorer_needs_no_extra(here):
    """As after a plain `pip install`; other commands name the extra that they need."""

    def run(*words):
        return subprocess.run([sys.executable, "-c", BARE, *words], capture_output=True, text=True, timeout=600)

    done = run("explore")
    assert (done.returncode, done.stdout, done.stderr) == (0, "fastaff-explorer.html\n", "")
    assert (here / "fastaff-explorer.html").read_text().startswith("<!doctype html>")
    for words in (["explore", "--energy", "1/8"], ["poincare"], []):
        done = run(*words)
        assert done.returncode == 2
        assert done.stdout == ""
        assert 'pip install "fastaff[demo]"' in done.stderr
        assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("zarr", "a store needs zarr: pip install 'fastaff[io]'"),
        ("sympy", "this command needs sympy: pip install 'fastaff[symbolic]'"),
    ],
)
def test_a_missing_extra_is_one_line(name, said, monkeypatch, capsys):
    """The extras of an installation with figures, whether the package names the extra or the import failed bare."""

    def run() -> None:
        with monkeypatch.context() as without:
            without.setitem(sys.modules, name, None)
            imported(name, what="a store") if name == "zarr" else __import__(name)

    monkeypatch.setitem(application.COMMANDS, "status", run)
    assert cli.main(["status"]) == 2
    assert capsys.readouterr().err == f"fastaff: error: {said}\n"


def test_a_job_without_zarr_is_refused_in_one_line(here, monkeypatch, refused):
    model = 'model = "henon-heiles"'
    sizes = "energy = 0.1\n[initial_conditions]\norbits = 2\nseed = 0\n[frequency_map]\ntime = 50"
    (here / "job.toml").write_text(f"[model]\n{model}\n[energy_surface]\n{sizes}\n")
    monkeypatch.setitem(sys.modules, "zarr", None)
    refused(["run", "job.toml"], "fastaff: error: a store needs zarr: pip install 'fastaff[io]'")


@pytest.mark.parametrize(
    "command", [[], ["poincare"], ["frequency-map"], ["chaos-map"], ["spectrum"], ["demo"], ["warmup"], ["doctor"]]
)
def test_help(command, capsys):
    assert cli.main([*command, "--help"]) == 0
    assert "Usage: fastaff" in capsys.readouterr().out


def test_help_describes_every_option(capsys):
    cli.main(["poincare", "--help"])
    text = capsys.readouterr().out
    options = "model energy p-eta section grid q-range crossings max-time out lam"
    for option in options.split():
        assert f"--{option}" in text
    assert "--no-no-" not in text


# Computing


def test_poincare_command(tmp_path, capsys):
    assert cli.main(["poincare", *SURFACE, "--grid", "4x4", "--crossings", "8", "--out", str(tmp_path / "s")]) == 0
    captured = capsys.readouterr()
    arrays, metadata = files.contents(tmp_path / "s.npz")
    orbits = arrays["status"].size
    assert arrays["points"].shape == (8, 8, orbits)
    assert arrays["diffusion"].shape == (orbits,)
    assert arrays["z0"].shape == (8, orbits)
    assert metadata["model"]["potential"]["class"] == "NeoHookean"
    assert metadata["energy"] == 1.5
    assert metadata["p_gamma"] == 0.2
    assert metadata["crossings"] == 8
    assert metadata["max_time"] > 0
    assert (arrays["step"] > 0).all()
    assert metadata["interrupted"] is False
    assert metadata["wall_time"] > 0
    assert "crossings/s" in captured.err
    assert (tmp_path / "s.png").stat().st_size > 10_000
    assert b"NeoHookean" in (tmp_path / "s.png").read_bytes()


def test_frequency_map_command(tmp_path):
    run = [
        "frequency-map",
        "--model",
        "hyperelastic",
        "--energy",
        "3.5",
        *SURFACE[2:],
        "--grid",
        "5x5",
        "--time",
        "150",
    ]
    assert cli.main([*run, "--out", str(tmp_path / "f")]) == 0
    arrays, metadata = files.contents(tmp_path / "f.npz")
    assert metadata["names"] == ["r", "vartheta", "phi", "psi"]
    assert files.recipe(tmp_path / "f.npz").run().nu.tobytes() == arrays["nu"].tobytes()
    # The paper's nu_r = sqrt(C/mu)/pi; about 50 periods fit in the time, enough for 8 digits.
    np.testing.assert_allclose(arrays["nu"][0], 1 / np.pi, rtol=1e-8)
    assert (tmp_path / "f.png").exists()


def test_chaos_map_command(tmp_path, capsys):
    run = ["chaos-map", *SURFACE, "--grid", "5x4", "--time", "400", "--indicators", "megno,gali-3"]
    assert cli.main([*run, "--out", str(tmp_path / "c")]) == 0
    said = capsys.readouterr().err
    arrays, metadata = files.contents(tmp_path / "c.npz")
    orbits = arrays["status"].size
    assert metadata["names"] == ["megno", "gali_3"]
    assert arrays["values"].shape == (2, orbits)
    assert arrays["cell_index"].size == orbits == 20 - arrays["inaccessible"].sum()
    assert metadata["time"] == 400
    assert metadata["interrupted"] is False
    assert f"fastaff: {orbits} orbits: " in said
    assert f"; {fastaff.load(tmp_path / 'c.npz').shares.fraction_text()}; " in said
    assert (arrays["interval"][0] < metadata["fraction"]) & (metadata["fraction"] < arrays["interval"][1])
    assert arrays["bounds"].shape == (2,)
    assert (
        f"{int(((arrays['classification'] == fastaff.Classification.CHAOTIC) & (arrays['status'] == 0)).sum())} chaotic"
        in said
    )
    direct = fastaff.chaos_map(
        fastaff.Body(fastaff.NeoHookean()),
        arrays["z0"],
        time=400.0,
        step=arrays["step"],
        scheme=fastaff.schemes.BLANES_CASAS_ESCORIHUELA8,
        indicators=(fastaff.MEGNO(), fastaff.GALI(3)),
    )
    assert direct.values.tobytes() == arrays["values"].tobytes()
    assert b"NeoHookean" in (tmp_path / "c.png").read_bytes()


def test_chaos_map_of_random_orbits_over_periods(tmp_path):
    run = "chaos-map --model henon-heiles --energy 0.12 --orbits 20 --returns 30 --early-stop"
    assert cli.main([*run.split(), "--indicators", "megno", "--out", str(tmp_path / "c")]) == 0
    arrays, metadata = files.contents(tmp_path / "c.npz")
    assert arrays["start_points"].shape == (2, 20)
    np.testing.assert_allclose(arrays["start_points"], arrays["z0"][[1, 3]])
    assert metadata["returns"] == 30
    # The frequencies of the well are 1: a return to x = 0 takes somewhat more than 2 pi.
    assert 30 * 2 * np.pi < metadata["time"] < 30 * 8.0


def test_scans(tmp_path, capsys):
    common = ["chaos-map", *SURFACE[2:], "--orbits", "6", "--time", "500", "--early-stop"]
    assert cli.main([*common, "--scan", "energy=0.1:1.5:3", "--out", str(tmp_path / "one")]) == 0
    said = capsys.readouterr().err
    assert "1 case without accessible points" in said
    assert fastaff.load(tmp_path / "one.npz").shares.fraction_text() in said
    arrays, metadata = files.contents(tmp_path / "one.npz")
    assert metadata["names"] == ["energy"]
    np.testing.assert_allclose(arrays["axes_0"], [0.1, 0.8, 1.5])
    assert arrays["orbits"].tolist() == [0, 6, 6]
    assert np.isnan(arrays["fraction"]).tolist() == [True, False, False]
    assert (tmp_path / "one.png").exists()
    both = ["--energy", "1.5", "--scan", "p_phi=0:0.8:2", "--scan", "K=1:4:3", "--returns", "12"]
    assert cli.main([*common[:-3], "--early-stop", *both, "--out", str(tmp_path / "two")]) == 0
    arrays, metadata = files.contents(tmp_path / "two.npz")
    assert metadata["names"] == ["p_phi", "K"]
    assert arrays["fraction"].shape == (2, 3)
    assert np.ptp(arrays["time"]) > 0, "returns take another time in every case"
    assert (tmp_path / "two.png").exists()


def test_scanned_parameters_reach_body_and_surface():
    body, surface = fastaff.Body(fastaff.NeoHookean()), options.EnergySurface(energy=1.5, p_eta=0.3, p_gamma=0.2)
    one, at = scans.case(body, surface, {"K": 5.0, "p_phi": 1.0})
    assert one == fastaff.Body(fastaff.NeoHookean(K=5.0))
    assert at.p_gamma + at.p_eta == pytest.approx(1.0)
    assert at.p_gamma - at.p_eta == pytest.approx(-0.1), "the vorticity stays"
    one, at = scans.case(body, surface, {"mu": 2.0, "energy": 2.5})
    assert (one.mu, at.energy, at.p_eta, at.p_gamma) == (2.0, 2.5, 0.3, 0.2)
    one, at = scans.case(fastaff.HenonHeiles(), options.EnergySurface(energy=0.1), {"lam": 0.5, "energy": 0.2})
    assert (one.lam, at.energy) == (0.5, 0.2)


def test_bodies_of_a_formula(tmp_path, capsys):
    pytest.importorskip("sympy")
    text = "G/2*(D1**2 + D2**2 - 2) - G*log(D1*D2) + K/2*(D1*D2 - 1)**2"
    own = ["--formula", text, "--parameter", "G=1", "--parameter", "K=2"]
    for name, model in (("named", []), ("own", own)):
        run = ["poincare", *SURFACE, *model, "--grid", "3x3", "--crossings", "3", "--step", "0.02", "--no-diffusion"]
        assert cli.main([*run, "--out", str(tmp_path / name)]) == 0
    named, own_points = (files.contents(tmp_path / f"{name}.npz").arrays["points"] for name in ("named", "own"))
    np.testing.assert_allclose(own_points, named, rtol=1e-9, atol=1e-9)
    assert files.contents(tmp_path / "own.npz").metadata["formula"] == text
    general = ["--formula", "x**2 + 2*y**2 + z**2 + u**2"]
    assert cli.main(["chaos-map", *SURFACE, *general]) == 2
    assert "Use --axes NAME=LOW:HIGH:N" in capsys.readouterr().err
    assert (
        cli.main(
            [
                "chaos-map",
                *SURFACE,
                *own,
                "--scan",
                "K=1:2:2",
                "--orbits",
                "4",
                "--time",
                "20",
                "--out",
                str(tmp_path / "k"),
            ]
        )
        == 0
    )


def test_systems_of_a_formula(tmp_path, capsys):
    pytest.importorskip("sympy")
    own = ["--hamiltonian", "(u**2+v**2)/2 + lam*(u**2*v - v**3/3)", "--coordinates", "u v", "--parameter", "lam=1"]
    run = ["--energy", "0.1", "--orbits", "5", "--out", str(tmp_path / "s"), "--step", "0.02"]
    assert cli.main(["poincare", *own, *run, "--crossings", "4", "--no-diffusion"]) == 0
    named = fastaff.poincare_map(
        fastaff.HenonHeiles(),
        files.contents(tmp_path / "s.npz").arrays["z0"],
        section=fastaff.Hyperplane((1, 0, 0, 0)),
        crossings=4,
        max_time=200.0,
        step=0.02,
    )
    np.testing.assert_allclose(files.contents(tmp_path / "s.npz").arrays["points"], named.points, rtol=1e-8, atol=1e-8)
    recipe = files.recipe(tmp_path / "s.npz")  # the formula's text, z0 and every option are in the file
    assert recipe.arguments["model"].formula == own[1]
    assert recipe.run().points.tobytes() == files.contents(tmp_path / "s.npz").arrays["points"].tobytes()
    assert cli.main(["chaos-map", *own, *run, "--time", "20", "--section", "v=0"]) == 0
    capsys.readouterr()
    assert cli.main(["poincare", *own, *run, "--section", "x=0"]) == 2
    assert "--section must be one of u=c, v=c" in capsys.readouterr().err
    three = ["chaos-map", "--hamiltonian", "x**2+y**2+z**2", "--coordinates", "x y z"]
    assert cli.main([*three, *run]) == 0
    assert cli.main([*three, "--energy", "0.1", "--grid", "2x2"]) == 2
    assert "--axes NAME=LOW:HIGH:N" in capsys.readouterr().err


@pytest.mark.parametrize("section", ["beta-turning", "alpha=1.4", "beta=0.5", "area=1"])
def test_every_section(section, tmp_path):
    run = ["poincare", *SURFACE, "--section", section, "--orbits", "4", "--crossings", "3", "--no-diffusion"]
    assert cli.main([*run, "--out", str(tmp_path / "s")]) == 0
    assert files.contents(tmp_path / "s.npz").arrays["counts"].max() == 3


CHILD = """
import os, sys
from fastaff.cli import main, progress
number, part = int(sys.argv.pop(1)), float(sys.argv.pop(1))
draw = progress.TerminalProgress.__call__
def watched(self, fraction):
    global number
    draw(self, fraction)
    if fraction >= part and number:
        sent, number = number, 0
        os.kill(os.getpid(), sent)
progress.TerminalProgress.__call__ = watched
main.main()
"""


@pytest.mark.race
@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be sent to one process")
@pytest.mark.parametrize(
    ("number", "part", "run"),
    [
        (
            signal.SIGINT,
            "0.05",
            ["poincare", "--grid", "90x90", "--crossings", "1500", "--no-diffusion", "--step", "0.05"],
        ),
        (signal.SIGTERM, "0.25", ["chaos-map", "--grid", "90x90", "--time", "500", "--indicators", "megno"]),
    ],
    ids=["poincare", "chaos-map"],
)
def test_ctrl_c_keeps_finished_orbits(number, part, run, tmp_path):
    run = [*run, *SURFACE, "--out", "long"]
    command, said = [sys.executable, "-c", CHILD, str(int(number)), part, *run], tmp_path / "said"
    with said.open("w") as err:
        code = subprocess.run(command, cwd=tmp_path, stderr=err, timeout=600, check=False).returncode  # a hang
    said = said.read_text()
    assert code == 130, said
    assert "Traceback" not in said
    arrays, metadata = files.contents(tmp_path / "long.npz")
    finished = int((arrays["status"] == 0).sum())
    assert f"kept {finished} finished of" in said
    assert 0 < finished < arrays["z0"].shape[1] == arrays["status"].size
    assert metadata["interrupted"] is True
    values = (arrays["points"] if "points" in arrays else arrays["values"]).T
    assert np.isfinite(values[arrays["status"] == 0]).all()
    assert not (tmp_path / "long.png").exists()
    assert not list(tmp_path.glob(".*")), "no temporary file is left"


def test_a_map_of_one_variable_has_no_section(tmp_path, capsys):
    words = ["poincare", "--map", "x1 = r*x*(1 - x)", "--parameter", "r=3.7", "--out", str(tmp_path / "s")]
    assert cli.main(words) == 2
    said = capsys.readouterr().err
    assert "--map must have two variables or more for a section, got one. Try fastaff explore" in " ".join(said.split())
    assert not list(tmp_path.iterdir())


def test_demo(tmp_path, capsys, monkeypatch):
    from matplotlib.text import Text

    figures = []
    draw = demo.draw
    monkeypatch.setattr(demo, "QUICK", demo.Size(orbits=6, crossings=6, cells=(6, 5), time=60.0))
    monkeypatch.setattr(demo, "draw", lambda *portraits: figures.append(draw(*portraits)) or figures[-1])
    assert cli.main(["demo", "--quick", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    (figure,) = figures
    sizes = [text.get_fontsize() for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    assert min(sizes) / 72 * 390 / figure.get_figwidth() > 7.5  # pixels on a telephone
    assert "crossings/s" in out
    names = sorted(p.name for p in tmp_path.iterdir())
    assert len(names) == 5
    assert "fastaff-demo.png" in names
    for path in tmp_path.glob("*.npz"):
        metadata = files.contents(path).metadata
        assert metadata["seed"] == demo.SEED
        assert metadata["p_eta"] == demo.P_ETA
        json.dumps(metadata, allow_nan=False)


@pytest.mark.parametrize("columns", ["99999999", "9" * 5000, "0", "-3", "abc"])
def test_help_has_a_bounded_width_in_any_number_of_columns(columns):
    """99999999 wrote 100 MB and did not end."""
    environment = {**os.environ, "COLUMNS": columns}
    found = subprocess.run(
        [sys.executable, "-m", "fastaff", "status", "--help"], capture_output=True, env=environment, check=True
    )
    assert 0 < max(map(len, found.stdout.decode().splitlines())) <= 1000
    assert len(found.stdout) < 10**6


def test_help_in_ascii():
    """It ended with an error of encoding."""
    environment = {**os.environ, "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii", "COLUMNS": "80"}
    found = subprocess.run(
        [sys.executable, "-m", "fastaff", "--help"], capture_output=True, env=environment, check=True
    )
    assert b"Usage: fastaff COMMAND" in found.stdout
    assert not found.stderr
    assert found.stdout.isascii()
