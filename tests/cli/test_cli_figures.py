"""Figures of the command line: their formats, colours of the user's choice, captions, animations."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fastaff as fa
from fastaff import files
from fastaff.cli import main as cli
from fastaff.cli.commands import captions, figures
from fastaff.cli.commands.plot import _of_file, _of_store
from fastaff.cli.options import FigureOptions
from fastaff.jobs import Job
from fastaff.jobs.wording import OptionError
from fastaff.systems.models.mechanics import system_of

pytest.importorskip("cyclopts")
pytest.importorskip("matplotlib")

SURFACE = ["--energy", "1.5", "--p-eta", "0.3", "--p-gamma", "0.2"]
SECTION = ["poincare", *SURFACE, "--grid", "4x4", "--crossings", "6"]
MAP = ["chaos-map", *SURFACE, "--orbits", "10", "--time", "20"]


def test_out_with_the_ending_of_a_figure(here, capsys):
    for ending in ("pdf", "svg", "npz"):
        assert cli.main([*SECTION, "--no-diffusion", "--out", f"{ending}.{ending}"]) == 0
        figure = {"npz": "png"}.get(ending, ending)
        assert capsys.readouterr().out.split() == [f"{ending}.npz", f"{ending}.{figure}"]
    assert (here / "pdf.pdf").read_bytes().startswith(b"%PDF")
    assert b"<svg" in (here / "svg.svg").read_bytes()
    assert cli.main([*SECTION, "--no-diffusion", "--out", "pdf.pdf"]) == 0
    assert sorted(path.name for path in here.glob("pdf*")) == ["pdf-2.npz", "pdf-2.pdf", "pdf.npz", "pdf.pdf"]


def test_a_section_by_an_indicator_that_the_command_does_not_compute(here):
    assert cli.main([*SECTION, "--colour", "SALI", "--vmin", "-12", "--out", "s"]) == 0
    arrays, facts = files.contents("s.npz")
    assert facts["colour"] == "sali"
    assert arrays["colour_values"].shape == arrays["z0"].shape[1:]
    assert "[chaos_map]" in facts["job"]
    drawn, _ = _of_file(here / "s.npz", FigureOptions(vmin=-12.0))
    points = next(c for c in drawn["poincare"].axes[0].collections if c.get_array() is not None)
    assert set(points.get_array()) <= set(arrays["colour_values"])
    assert (points.norm.vmin, points.norm.vcenter) == (-12.0, pytest.approx(facts["colour_threshold"]))
    # The command again finds the same numbers as a chaos map of its own.
    assert cli.main(["chaos-map", *SURFACE, "--grid", "4x4", "--indicators", "sali", "--no-figure", "--out", "c"]) == 0
    np.testing.assert_array_equal(files.load("c.npz")["sali"], arrays["colour_values"])


def test_columns_of_the_result_and_what_is_none(here, capsys):
    assert cli.main([*MAP, "--colour", "energy_error", "--out", "e"]) == 0
    found = files.load("e.npz")
    drawn, _ = _of_file(here / "e.npz", FigureOptions(colour="energy_error"))
    (points,) = (c for c in drawn["chaos_map"].axes[0].collections if c.get_array() is not None)
    assert sorted(points.get_array()) == sorted(found.energy_error)
    capsys.readouterr()
    assert cli.main(["plot", "e.npz", "--colour", "nothing"]) == 2
    assert "colour must be one of classification, suggested_time," in capsys.readouterr().err
    assert cli.main(["plot", "e.npz", "--vmin", "2", "--vmax", "1"]) == 2
    assert "--vmin must be below --vmax" in capsys.readouterr().err
    assert cli.main([*MAP, "--scan", "energy=1:1.5:2", "--colour", "sali"]) == 2
    assert "belong to maps, not to --scan" in capsys.readouterr().err


def test_a_job_computes_what_a_colour_needs():
    from fastaff.jobs import Job
    from fastaff.jobs.analyses import ChaosOptions, PoincareOptions
    from fastaff.jobs.system import EnergySurface

    job = Job(energy_surface=EnergySurface(energy=1.0), poincare=PoincareOptions())
    assert figures.with_colour(job, "megno").chaos_map == ChaosOptions(indicators="megno")
    assert figures.with_colour(job, "beta/alpha").frequency_map is not None
    assert figures.with_colour(job, "counts") == job
    both = Job(energy_surface=EnergySurface(energy=1.0), chaos_map=ChaosOptions(indicators="megno"))
    assert figures.with_colour(both, "gali-2").chaos_map.indicators == "megno,gali_2"
    assert figures.with_colour(both, "megno") == both
    with pytest.raises(OptionError, match="--colour must be one of"):
        figures.colours(FigureOptions(colour="x"), {})


def test_scans_of_a_store_have_a_caption(tmp_path, monkeypatch):
    pytest.importorskip("zarr")
    monkeypatch.chdir(tmp_path)
    scan = [*MAP, "--scan", "energy=1:1.5:2"]
    assert cli.main([*scan, "--write-job", "s.toml"]) == cli.main(["run", "s.toml", "--quiet"]) == 0
    drawn, _ = _of_store(tmp_path / "s.zarr", FigureOptions())
    assert "chaotic fraction" in drawn["scan"].get_supxlabel()
    assert "neo-Hookean body" in drawn["scan"].get_suptitle()
    assert cli.main(["plot", "s.zarr", "--out", "s.pdf"]) == 0
    assert (tmp_path / "s.pdf").read_bytes().startswith(b"%PDF")


def test_figures_of_a_stopped_job_say_what_is_not_computed(tmp_path, monkeypatch):
    """White cells of its chaos map are not all beyond the energy."""
    zarr = pytest.importorskip("zarr")
    monkeypatch.chdir(tmp_path)
    grid = ["chaos-map", *SURFACE, "--grid", "4x4", "--time", "20"]
    assert cli.main([*grid, "--write-job", "j.toml"]) == cli.main(["run", "j.toml", "--quiet"]) == 0
    whole = _of_store(tmp_path / "j.zarr", FigureOptions())[0]["chaos_map"].get_supxlabel()
    assert "not computed" not in whole
    count = np.sum(zarr.open(tmp_path / "j.zarr", mode="r")["launch/finished"][:] == 1)

    def stop(progress, chunk):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fa.run(replace(Job.read(tmp_path / "j.toml"), chunk=8), tmp_path / "half.zarr", on_chunk=stop)
    done = np.sum(zarr.open(tmp_path / "half.zarr", mode="r")["launch/finished"][:] == 1)
    assert 0 < done < count
    part = " ".join(_of_store(tmp_path / "half.zarr", FigureOptions())[0]["chaos_map"].get_supxlabel().split())
    assert f"{done} orbits, " in part
    assert " not computed yet; " in part
    assert "white: inaccessible or not computed yet" in part


def test_captions_say_what_is_open_of_a_chaotic_fraction(here):
    """Of a map, and of a scan over two parameters, which shows neither intervals nor undecided orbits."""
    assert cli.main([*MAP, "--out", "m", "--no-figure"]) == 0
    drawn, _ = _of_file(here / "m.npz", FigureOptions())
    plane = ["--scan", "energy=1:1.5:2", "--scan", "K=1:2:2"]
    assert cli.main([*MAP, *plane, "--out", "s", "--no-figure"]) == 0
    scan, _ = _of_file(here / "s.npz", FigureOptions())
    for name, figure in (("m", drawn["chaos_map"]), ("s", scan["scan"])):
        assert files.load(f"{name}.npz").shares.bounds_text() in " ".join(figure.get_supxlabel().split("\n"))


def test_captions_are_mathematics():
    import fastaff as fa

    body = fa.Body(fa.NeoHookean(G=1.0, K=2e-7), mu=3.0)
    assert captions.titled(body) == r"neo-Hookean body ($G = 1$, $K = 2\times10^{-7}$, $\mu = 3$)"
    own = fa.hamiltonian("(x**2+y**2)/2 + k*x**2*y", coordinates="x y", k=1.5)
    assert captions.titled(own) == r"$V = \frac{x^{2}+y^{2}}{2}$ $+k\,x^{2}\,y$ ($k = 1.5$)"
    assert captions.in_words(fa.Hyperplane((0, 1, 0, 0), 0.5), system_of(own)) == "$y = 0.5$, crossed with $p_{y} > 0$"
    assert captions.in_words(fa.BetaTurning(-1), system_of(body)) == (
        r"$p_{\beta} = 0$, crossed with $\dot{p_{\beta}} < 0$"
    )
    status = np.array([0, 0, 3, 5])
    assert captions.outcomes(status) == "4 orbits, 1 escaped, 1 few crossings"


def test_animate(here, capsys):
    run = ["animate", *SURFACE, "--start", "0.9,0.1", "--start", "0.5,0", "--time", "2", "--frames", "3"]
    assert cli.main([*run, "--out", "a.gif"]) == 0
    assert capsys.readouterr().out.split() == ["a.gif"]
    from PIL import Image

    with Image.open("a.gif") as image:
        assert image.n_frames == 3
    for wrong, message in (
        (["--start", "1"], "--start must be two numbers U,P"),
        (["--start", "0.5,nan"], "--start must be two numbers U,P"),
        (["--out", "a.avi"], "--out must end with .gif or .mp4"),
        (["--out", "no/a.gif"], "does not exist"),
        (["--start", "0.5,0"] * 3, "--start is taken up to 4 times, got 5"),
        (["--start", "9,9"], "reach"),
    ):
        assert cli.main([*run, *wrong]) == 2
        assert message in capsys.readouterr().err
    assert [path.name for path in here.iterdir()] == ["a.gif"]


def test_data_and_figure_have_one_number_whoever_else_writes(here, monkeypatch):
    work = [*SECTION, "--no-diffusion", "--out", "s"]
    draw = figures.section_figure

    def late(*given):  # while this run draws, another one ends
        if not (here / "s-2.npz").exists():
            assert cli.main(work) == 0
        return draw(*given)

    monkeypatch.setitem(figures.DRAWN, "poincare", late)
    monkeypatch.setattr("fastaff.cli.commands.orbits.section_figure", late, raising=False)
    assert cli.main(work) == 0
    assert cli.main([*work, "--no-figure"]) == 0
    assert cli.main(work) == 0
    found = sorted(path.name for path in here.iterdir())
    assert found == ["s-2.npz", "s-2.png", "s-3.npz", "s-4.npz", "s-4.png", "s.npz", "s.png"]


def test_a_full_disk_leaves_the_old_figure(tmp_path, capsys, monkeypatch):
    from matplotlib.figure import Figure

    def full(_, path, **given):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.chdir(tmp_path)
    assert cli.main([*SECTION, "--no-diffusion", "--out", "s"]) == 0
    old = (tmp_path / "s.png").read_bytes()
    monkeypatch.setattr(Figure, "savefig", full)
    for command in ([*SECTION, "--no-diffusion", "--out", "s", "--overwrite"], ["plot", "s.npz", "--overwrite"]):
        assert cli.main(command) == 2
        assert "No space left" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s.npz", "s.png"]
    assert (tmp_path / "s.png").read_bytes() == old


def test_out_may_be_a_folder_and_is_no_other_kind_of_picture(here, capsys):
    (here / "there").mkdir()
    assert cli.main([*SECTION, "--no-diffusion", "--out", "there"]) == 0
    found = sorted(path.name for path in (here / "there").iterdir())
    assert found == ["fastaff-poincare.npz", "fastaff-poincare.png"]
    assert cli.main(["plot", "there/fastaff-poincare.npz", "--out", "there"]) == 0
    assert (here / "there" / "fastaff-poincare-2.png").stat().st_size > 0
    capsys.readouterr()
    assert cli.main([*SECTION, "--out", "a.jpg"]) == 2
    assert "--out a.jpg: figures are .png, .pdf, .svg" in capsys.readouterr().err


def test_a_plane_of_ratios_is_never_empty_for_want_of_regular_orbits():
    starts = np.array([[0.0, 0.01], [-0.15, -0.2], [0.45, 0.44], [0.01, 0.0]])
    found = fa.frequency_map(fa.HenonHeiles(), starts, time=300.0)
    assert not found.regular.any()
    drawn = figures._ratios(SimpleNamespace(max_order=5), found, None, None)
    assert len(drawn.points.get_offsets()) == 2
    assert drawn.missing == 0
