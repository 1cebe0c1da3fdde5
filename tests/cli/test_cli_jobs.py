"""Jobs on the command line: written by commands, run, stopped, resumed, drawn again."""

from __future__ import annotations

import dataclasses
import json
import shlex
import signal
import subprocess
import sys

import numpy as np
import pytest

from fastaff import files
from fastaff.cli import main as cli
from fastaff.cli import options
from fastaff.jobs import Job, JobResults, Store
from fastaff.jobs.analyses import ChaosOptions, FrequencyOptions, PoincareOptions

pytest.importorskip("cyclopts")
pytest.importorskip("matplotlib")
pytest.importorskip("zarr")

SURFACE = ["--energy", "1.5", "--p-eta", "0.3", "--p-gamma", "0.2"]
TABLES = "[energy_surface]\nenergy = 1.5\np_eta = 0.3\np_gamma = 0.2\n"
COMMANDS = {
    "poincare": (["poincare", *SURFACE, "--grid", "4x4", "--crossings", "8"], "poincare"),
    "frequency-map": (["frequency-map", *SURFACE, "--grid", "5x4", "--time", "100"], "frequency_map"),
    "chaos-map": (["chaos-map", *SURFACE, "--orbits", "12", "--seed", "4", "--returns", "20"], "chaos_map"),
}


def same(one, other):
    """Tell whether two results have the same bits in all arrays."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in (field.name for field in dataclasses.fields(one))]
    return all(a.tobytes() == b.tobytes() for a, b in pairs if isinstance(a, np.ndarray))


def pixels(path):
    """Bytes of a picture without its metadata."""
    from matplotlib.image import imread

    return imread(path).tobytes()


@pytest.mark.parametrize("name", COMMANDS)
def test_a_written_job_gives_the_numbers_of_the_command(name, here, capsys):
    flags, analysis = COMMANDS[name]
    assert cli.main([*flags, "--write-job", "a.toml"]) == 0
    assert [path.name for path in here.iterdir()] == ["a.toml"], "nothing is computed"
    assert cli.main([*flags, "--write-job", "a.toml"]) == 2
    assert "exists; --overwrite replaces it" in capsys.readouterr().err
    assert cli.main([*flags, "--out", "direct"]) == 0
    assert cli.main(["run", "a.toml"]) == 0
    said = capsys.readouterr().out
    results = JobResults.stored("a.zarr")
    assert results.complete
    assert results.table() in said
    assert files.contents("direct.npz").metadata["job"] == (here / "a.toml").read_text()
    assert same(files.load("direct.npz"), results[analysis])
    if name == "poincare":
        found = results["frequency_map"]
        diffusion = np.where(found.status == 0, found.diffusion, np.nan)
        assert files.contents("direct.npz").arrays["diffusion"].tobytes() == diffusion.tobytes()
    assert cli.main(["run", "a.toml"]) == cli.main(["resume", "a.zarr", "--quiet"]) == 0, "there is nothing left to do"
    capsys.readouterr()
    assert cli.main(["status", "a.zarr"]) == 0
    assert capsys.readouterr().out.strip() == results.table()

    # The same picture from the command, from its file and, but for what else is in it, from the store.
    assert cli.main(["plot", "direct.npz"]) == 0
    assert capsys.readouterr().out == "direct-2.png\n"
    assert pixels("direct-2.png") == pixels("direct.png")
    assert cli.main(["plot", "a.zarr", "--out", "b.png"]) == 0
    drawn = "b-poincare.png" if name == "poincare" else "b.png"
    assert drawn in capsys.readouterr().out.split()
    assert pixels(drawn) == pixels("direct.png")


def test_figures_of_other_formats_and_of_scans(here, capsys):
    scan = ["chaos-map", *SURFACE[2:], "--orbits", "4", "--time", "20", "--scan", "energy=1:1.5:2"]
    assert cli.main([*scan, "--out", "s"]) == 0
    for ending in ("png", "pdf", "svg"):
        assert cli.main(["plot", "s.npz", "--out", f"again.{ending}"]) == 0
        assert (here / f"again.{ending}").stat().st_size > 5_000
    assert pixels("again.png") == pixels("s.png")
    assert cli.main(["plot", "s.npz", "--overwrite"]) == 0
    assert not (here / "s-2.png").exists()
    assert cli.main([*scan, "--write-job", "s.toml"]) == cli.main(["run", "s.toml", "--quiet"]) == 0
    found, direct = JobResults.stored("s.zarr")["chaotic_fraction"], files.load("s.npz")
    assert same(found, direct)


def test_failed_orbits_are_run_again(here, capsys):
    long = ["frequency-map", "--model", "henon-heiles", "--energy", "0.12", "--step", "0.7", "--scheme", "LEAPFROG"]
    assert cli.main([*long, "--grid", "6x6", "--time", "40", "--write-job", "a.toml"]) == 0
    assert cli.main(["run", "a.toml"]) == 0
    assert "ENERGY_DRIFT" in capsys.readouterr().out
    assert cli.main(["rerun", "a.zarr", "--status", "energy-drift", "--scheme", "DOP853"]) == 0
    said = capsys.readouterr().out
    assert "run again with scheme DOP853" in said
    assert "ENERGY_DRIFT" not in said
    assert cli.main(["rerun", "a.zarr", "--status", "energy-dirft", "--scheme", "DOP853"]) == 2
    assert "ENERGY_DRIFT?" in capsys.readouterr().err
    assert cli.main(["rerun", "a.zarr", "--status", "OK"]) == 2
    assert "scheme, step or accuracy" in capsys.readouterr().err


@pytest.mark.parametrize(
    "asked",
    [
        ["--levels", "4"],
        ["--levels", "3", "--m", "0:2", "--l", "0"],
        ["--levels", "3", "--m", "-1:1", "--l", "-1:1"],
        ["--levels", "3", "--m", "0", "--l", "0", "--states", "0,2"],
        ["--levels", "3", "--m", "0", "--l", "0", "--scan", "C=0.5:2:3"],
    ],
)
def test_figures_of_spectra(asked, here):
    assert cli.main(["spectrum", "--model", "hyperelastic", *asked, "--out", "levels"]) == 0
    assert cli.main(["plot", "levels.npz", "--out", "again.png"]) == 0
    assert pixels("again.png") == pixels("levels.png")


def test_starts_of_a_file(here, capsys):
    assert cli.main([*COMMANDS["frequency-map"][0], "--out", "grid", "--no-figure"]) == 0
    np.save("z0.npy", files.contents("grid.npz").arrays["z0"][:, :3])
    own = ["frequency-map", "--file", "z0.npy", "--time", "100"]
    assert cli.main([*own, "--out", "own"]) == cli.main([*own, "--write-job", "own.toml"]) == 0
    assert cli.main(["run", "own.toml"]) == cli.main(["plot", "own.zarr"]) == cli.main(["plot", "own.npz"]) == 0
    assert files.load("own.npz").nu.tobytes() == JobResults.stored("own.zarr")["frequency_map"].nu.tobytes()
    capsys.readouterr()
    assert cli.main(["chaos-map", "--file", "z0.npy", "--time", "20", "--out", "c"]) == 0
    assert "no figure" in capsys.readouterr().err


def test_lines_of_json(here, capsys):
    (here / "a.toml").write_text(f'chunk = 4\n{TABLES}[initial_conditions]\ngrid = "4x4"\n[chaos_map]\ntime = 20\n')
    assert cli.main(["run", "a.toml", "--log", "json", "--memory", "200MB", "--threads", "1"]) == 0
    *lines, last = map(json.loads, capsys.readouterr().out.splitlines())
    assert [line["chunk"]["number"] for line in lines] == [0, 1, 2, 3]
    assert [line["so_far"]["orbits"] for line in lines] == [4, 8, 12, 16]
    assert last["complete"] is True
    assert last["statuses"] == lines[-1]["so_far"]["statuses"]
    assert cli.main(["run", "a.toml", "--store", "b.zarr", "--quiet"]) == 0
    captured = capsys.readouterr()
    assert captured.out == captured.err == ""
    assert (here / "b.zarr/chaos_map/values").is_dir()


STOPPED = """
import os, signal, sys
from fastaff.cli import main
from fastaff.jobs import watching
add = watching.Watched.add
def added(self, found):
    add(self, found)
    if self.done == 2:
        os.kill(os.getpid(), int(sys.argv[1]))
watching.Watched.add = added
sys.exit(main.main(sys.argv[2:]))
"""


@pytest.mark.race
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_job_is_resumed_by_the_command_that_is_printed(number, here, capsys):
    (here / "a b.toml").write_text(
        f'chunk = 40\n{TABLES}[initial_conditions]\ngrid = "20x20"\n[frequency_map]\ntime = 200\n'
    )
    process = subprocess.run(
        [sys.executable, "-c", STOPPED, str(int(number)), "run", "a b.toml", "--threads", "1"],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert process.returncode == 130, process.stderr
    assert "Traceback" not in process.stderr
    assert not JobResults.stored("a b.zarr").complete
    assert "points are still to be computed" in process.stderr
    program, *words = shlex.split(process.stdout.splitlines()[-1])
    assert [program, *words] == ["fastaff", "resume", "a b.zarr", "--threads", "1"]
    assert cli.main(["status", "a b.zarr"]) == 0
    assert "go on with: fastaff resume 'a b.zarr'" in capsys.readouterr().out
    assert cli.main(["plot", "a b.zarr"]) == 0, "what is finished can be drawn"
    assert cli.main(words) == 0
    assert cli.main(["run", "a b.toml", "--store", "whole.zarr", "--quiet"]) == 0
    assert contents(here / "a b.zarr") == contents(here / "whole.zarr")


def contents(store):
    """Bytes of all arrays of a store by path."""
    chunks = [path for path in store.rglob("*") if path.is_file() and path.parent != store]
    return {str(path.relative_to(store)): path.read_bytes() for path in chunks}


@pytest.mark.race
@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_workers_leave_with_their_parent(here):
    (here / "a.toml").write_text(
        f'chunk = 20\n{TABLES}[initial_conditions]\ngrid = "20x20"\n[frequency_map]\ntime = 500\n'
    )
    for number in (signal.SIGINT, signal.SIGKILL):
        command = [sys.executable, "-c", STOPPED, str(int(number)), "run", "a.toml", "--workers", "2"]
        # Pipes end with the last worker: one that stayed would take all of this time.
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        assert done.returncode == (130 if number == signal.SIGINT else -signal.SIGKILL), done.stderr
        assert not JobResults.stored("a.zarr").complete
        if number == signal.SIGINT:  # a worker that has just finished a chunk may tell that its parent is gone
            assert "Traceback" not in done.stderr
    assert cli.main(["resume", "a.zarr", "--workers", "2", "--quiet"]) == 0
    assert JobResults.stored("a.zarr").complete


@pytest.mark.slow
def test_workers_of_dask(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text(f'chunk = 4\n{TABLES}[initial_conditions]\ngrid = "4x4"\n[chaos_map]\ntime = 20\n')
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        run = ["run", "a.toml", "--quiet", "--dask", cluster.scheduler_address]
        assert cli.main(run) == 0
    assert cli.main(["run", "a.toml", "--store", "b.zarr", "--quiet"]) == 0
    assert contents(tmp_path / "a.zarr") == contents(tmp_path / "b.zarr")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[surface\n", "a.toml is no TOML"),
        ("[energy_surfase]\nenergy = 1\n", "[energy_surfase] is no table of a job. Did you mean energy_surface?"),
        (TABLES, "a job must have an analysis, one of poincare"),
        (TABLES + "[poincare]\ncrosings = 3\n", "[poincare] has no key crosings. Did you mean crossings?"),
        (TABLES + "[poincare]\ncrossings = 0\n", "[poincare] crossings must be at least 1"),
        (TABLES + "[poincare]\ncrossings = 'many'\n", "[poincare] crossings must be a whole number, got 'many'"),
        ("[poincare]\n", "[energy_surface] energy is required"),
        ("[energy_surface]\nenergy = nan\n[poincare]\n", "energy must be finite"),
        (TABLES + "[model]\nmodel = 'neohokean'\n[poincare]\n", "[model] model must be one of"),
        (TABLES + "[chaos_map]\nindicators = ['megno', 'salli']\n", "Did you mean sali?"),
        (TABLES + "[chaos_map]\n[options]\naccuracy = 1e-8\n", "[options] accuracy does not belong to chaos maps"),
        (TABLES + "[chaos_map]\ntime = 1\nreturns = 1\n", "give time or returns, not both"),
        (TABLES + "[frequency_map]\n[options]\nscheme = 'KAHAN'\n", "[options] scheme must be one of"),
        (TABLES + "[frequency_map]\n[options]\nthreads = 0\n", "[options] threads must be at least 1"),
        (TABLES + "[frequency_map]\n[initial_conditions]\ngrid = [4, 0]\n", "[initial_conditions] grid must be N1xN2"),
        (TABLES + "[frequency_map]\n[initial_conditions]\nfile = 'none.npy'\n", "none.npy does not exist"),
        (TABLES + "[integrate]\n", "[integrate] needs 'time'"),
        (TABLES + "[action_angles]\n", "[model] model must be separable, got a Body of NeoHookean"),
        (TABLES + "[model]\nformula = '__import__(1)'\n[poincare]\n", "a.toml: "),
    ],
)
def test_wrong_jobs_are_one_line(text, said, here, refused):
    (here / "a.toml").write_text(text)
    told = refused(["run", "a.toml"], said)
    assert told.startswith("fastaff: error: a.toml")
    assert "--" not in told, "a file has keys, no flags"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "absent.toml"], "absent.toml"),
        (["run", "."], "irectory"),
        (["run", "job.toml", "--memory", "2XB"], "--memory must be a number of bytes"),
        (["run", "job.toml", "--workers", "0"], "--workers must be at least 1"),
        (["run", "job.toml", "--workers", "2", "--dask", "tcp://a"], "--workers or --dask, not both"),
        (["run", "job.toml", "--log", "xml"], "--log must be one of json"),
        (["run", "job.toml", "--log", "json", "--quiet"], "--quiet or --log, not both"),
        (["run", "job.toml", "--store", "no/where.zarr"], "does not exist"),
        (["run", "job.toml", "--store", "job.toml"], "job.toml exists"),
        (["resume", "absent.zarr"], "absent.zarr does not exist"),
        (["status", "."], "must be a store of a fastaff job"),
        (["plot", "absent.npz"], "absent.npz"),
        (["plot", "job.toml"], "must be a file written by fastaff"),
        (["plot", "job.toml", "--out", "a.gif"], "--out must end with .png, .pdf, .svg"),
        (["poincare", *SURFACE, "--write-job", "no/where.toml"], "no/where.toml"),
        (["poincare", *SURFACE, "--crossings", "0", "--write-job", "a.toml"], "crossings must be at least 1"),
        (["poincare", "--energy", "nan"], "Invalid value for --energy: it must be finite"),
        (["poincare", *SURFACE, "--file", "job.toml"], "--file job.toml must be an .npy file"),
    ],
)
def test_wrong_options_are_one_line(arguments, said, here, refused):
    (here / "job.toml").write_text(TABLES + "[chaos_map]\ntime = 1\n")
    refused(arguments, said)


def test_another_job_in_a_store_is_refused_by_the_field(here, capsys):
    text = TABLES + '[initial_conditions]\ngrid = "3x3"\n[chaos_map]\ntime = '
    (here / "a.toml").write_text(f"{text}10\n")
    assert cli.main(["run", "a.toml", "--quiet"]) == 0
    (here / "a.toml").write_text(f"{text}20\n")
    assert cli.main(["run", "a.toml", "--quiet"]) == 2
    assert "[chaos_map] time was 10.0, is 20.0" in capsys.readouterr().err
    assert cli.main(["run", "a.toml", "--quiet", "--overwrite"]) == 0
    assert JobResults.stored("a.zarr")["chaos_map"].time == 20.0


def test_a_store_of_another_processor(here, capsys):
    """It is read, and goes on where that is asked for; its log moves no cursor."""
    (here / "a.toml").write_text(TABLES + "[initial_conditions]\norbits = 6\n[poincare]\ncrossings = 3\n")
    assert cli.main(["run", "a.toml", "--quiet"]) == 0
    store = Store("a.zarr", writing=True)
    store.tell(processor="core2 sse2")
    store.forget(0)
    with open("a.zarr/chunks.jsonl", "a") as log:
        log.write(json.dumps({"number": "\x1b[31m", "orbits": 1, "seconds": 1e9, "statuses": {}, "energy_error": 0.0}))
    capsys.readouterr()
    assert cli.main(["status", "a.zarr"]) == 0
    said = capsys.readouterr().out
    assert "\x1b" not in said
    assert "go on with: fastaff resume a.zarr" in said
    for command in (["resume", "a.zarr"], ["run", "a.toml"]):
        assert cli.main(command) == 2
        assert "another type of processor (only there 'core2'" in capsys.readouterr().err
    assert cli.main(["resume", "a.zarr", "--allow-other-cpu", "--workers", "1"]) == 0
    assert "processors of several kinds" in capsys.readouterr().out


def test_sizes_in_bytes():
    cases = {"500MB": 5e8, "2GiB": 2**31, "1000": 1e3, "1e9": 1e9, "3 kB": 3e3, "4KiB": 4096, "1.5TB": 1.5e12, "7B": 7}
    assert {text: options.size_of(text) for text in cases} == cases
    for wrong in ("", "MB", "-1GB", "1XB", "0", "inf", "nan", "2GiBs"):
        with pytest.raises(ValueError, match="--memory must be a number of bytes"):
            options.size_of(wrong)


def test_flags_and_keys_are_the_same_fields(capsys):
    for command, kind in (
        ("poincare", PoincareOptions),
        ("frequency-map", FrequencyOptions),
        ("chaos-map", ChaosOptions),
    ):
        cli.main([command, "--help"])
        text = capsys.readouterr().out
        for name in (field.name for field in dataclasses.fields(kind)):
            assert f"--{name.replace('_', '-')}" in text
    assert Job.parsed(f"{TABLES}[poincare]\nmax_time = 3\n").poincare == PoincareOptions(max_time=3)
