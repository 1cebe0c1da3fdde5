"""`fastaff spectrum`: what it prints and writes is what the library gives, and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fastaff
from fastaff import files
from fastaff.cli import main as cli
from fastaff.cli.commands.level_tables import digits

pytest.importorskip("cyclopts")
pytest.importorskip("matplotlib")

HYPERELASTIC = ["spectrum", "--model", "hyperelastic"]
# mu = C = hbar = 1: Frobenius series matched inside and Galerkin in 40-digit arithmetic, agreed to 30 digits.
GROUND = {(0, 0): 4.8544432943949895967, (2, 0): 6.6836795515645311692, (1, -1): 5.0}


def rows(text):
    """The rows of a printed table as dicts of its columns, without continuations."""
    head, *lines = text.splitlines()
    names = head.split("  ")
    names = [name.strip() for name in names if name.strip()]
    return [
        dict(zip(names, line.split(maxsplit=len(names) - 1)))
        for line in lines
        if line[:4].strip() and line.split()[0][0].isdigit()
    ]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([*HYPERELASTIC, "--m", "1.5", "--l", "0"], "--m must be a whole number"),
        ([*HYPERELASTIC, "--m", "3:1", "--l", "0"], "--m must be a whole number, or LOW:HIGH"),
        ([*HYPERELASTIC, "--m", "1", "--l", "0"], "m + l must be even"),
        ([*HYPERELASTIC, "--m", "1:1", "--l", "0"], "m + l must be even"),
        ([*HYPERELASTIC, "--m", "1"], "give both --m and --l"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--hbar", "0"], "hbar must be positive"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--hbar", "-1"], "hbar must be positive"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--levels", "0"], "levels must be at least 1"),
        ([*HYPERELASTIC, "--levels", "0"], "levels must be at least 1"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--chart", "r-theta"], "Did you mean r-vartheta?"),
        (
            [*HYPERELASTIC, "--m", "0", "--l", "0", "--chart", "alpha-beta"],
            "chart must separate Hyperelastic in two coordinates",
        ),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--tolerance", "-1"], "tolerance must be positive"),
        ([*HYPERELASTIC, "--tolerance", "0"], "tolerance must be positive"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--max-energy", "9"], "--max-energy belongs to the whole body"),
        ([*HYPERELASTIC, "--max-energy", "nan"], "must be finite"),
        ([*HYPERELASTIC, "--scan", "C=1:2:3"], "--scan needs --m and --l"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--scan", "K=1:2:3"], "--scan must be one of C, mu"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--scan", "C=2:1:3"], "NAME=LOW:HIGH:N"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--states", "1,99"], "--states must be one to 4 numbers from 0 to 19"),
        ([*HYPERELASTIC, "--m", "0", "--l", "0", "--density-chart", "elliptic"], "--density-chart must be one of"),
        ([*HYPERELASTIC, "--states", "0"], "belong to one class"),
        (
            ["spectrum", "--model", "neo-hookean", "--m", "0", "--l", "0", "--chart", "r-vartheta"],
            "--model must be separable, got a Body of NeoHookean",
        ),
        (["spectrum", "--model", "heavy-top", "--A", "-3", "--m", "0", "--l", "0"], "the energy has no lower bound"),
        (["spectrum", "--model", "heavy-top", "--A", "-3"], "the energy has no lower bound"),
        (["spectrum", "--model", "harmonic", "--C", "-1"], "must have k > 0 for a discrete spectrum"),
        (["spectrum", "--model", "henon-heiles", "--m", "0", "--l", "0"], "a vibration takes --levels"),
        (["spectrum", "--model", "double-pendulum"], "must be a system H = T(p) + V(q), got"),
        ([*HYPERELASTIC, "--levls", "3"], "Did you mean --levels?"),
    ],
)
def test_wrong_input_is_one_clear_line(arguments, said, refused):
    refused(arguments, said)


def test_help(capsys):
    assert cli.main(["spectrum", "--help"]) == 0
    text = capsys.readouterr().out
    options = "model formula m l levels max-energy hbar chart double-cover scan out"
    for option in options.split():
        assert f"--{option} " in text


@pytest.mark.parametrize(("m", "l"), GROUND)
def test_one_class(m, l, capsys, tmp_path):
    run = [*HYPERELASTIC, "--C", "1", "--m", str(m), "--l", str(l), "--levels", "6", "--chart", "r-vartheta"]
    assert cli.main([*run, "--out", str(tmp_path / "s"), "--no-figure"]) == 0
    captured = capsys.readouterr()
    truth = fastaff.quantum.spectrum(fastaff.Body(fastaff.Hyperelastic()), m=m, l=l, count=6)
    arrays, metadata = files.contents(tmp_path / "s.npz")
    assert arrays["E"].tobytes() == truth.E.tobytes()
    assert arrays["error"].tobytes() == truth.error.tobytes()
    assert arrays["n"].tolist() == truth.n.tolist()
    assert (arrays["m"] == m).all()
    assert metadata["names"] == ["r", "vartheta"]
    assert metadata["model"]["potential"] == {"class": "Hyperelastic", "C": 1.0}
    assert metadata["hbar"] == 1.0
    assert "Friedrichs" in metadata["method"]
    printed = rows(captured.out)
    assert len(printed) == 6
    assert float(printed[0]["E"]) == pytest.approx(GROUND[m, l], abs=1e-12)
    for row, E, error, label in zip(printed, truth.E, truth.error, truth.n.T):
        assert error < 1e-12
        assert abs(float(row["E"]) - E) <= 5e-13  # the digits that the error leaves
        assert [int(row["n_r"]), int(row["n_vartheta"])] == label.tolist()
        assert (row["converged"], row["degeneracy"]) == ("yes", "1")
        assert row["(m, l)"] == f"({m},{l})"
    assert captured.out.splitlines()[-1] == str(tmp_path / "s.npz")
    others = {(0, 0): None, (2, 0): "(0,2) (0,-2) (-2,0)", (1, -1): "(-1,1)"}[m, l]
    assert others is None or f"the same levels in the classes {others}" in captured.err


def test_whole_harmonic_body(capsys, tmp_path):
    assert (
        cli.main(["spectrum", "--model", "harmonic", "--levels", "6", "--hbar", "0.5", "--out", str(tmp_path / "s")])
        == 0
    )
    captured = capsys.readouterr()
    arrays, metadata = files.contents(tmp_path / "s.npz")
    wanted = [math.comb(N + 3, 3) for N in range(6)]
    assert np.diff(arrays["first"]).tolist() == wanted
    printed = [row for row in rows(captured.out) if "." in row["E"]]
    assert [int(row["degeneracy"]) for row in printed] == wanted
    np.testing.assert_allclose([float(row["E"]) for row in printed], 0.5 * np.arange(2, 8), atol=1e-12)
    assert "more sets of quantum numbers, all in the file" in captured.out
    assert f"{sum(wanted)} levels, 6 different energies" in captured.err
    assert "none is missing below E = 3.5" in captured.err
    assert metadata["interrupted"] is False
    assert (tmp_path / "s.png").stat().st_size > 10_000
    assert b"Harmonic" in (tmp_path / "s.png").read_bytes()


def test_below_on_the_covering(capsys, tmp_path):
    run = [
        "spectrum",
        "--model",
        "anharmonic",
        "--max-energy",
        "6",
        "--double-cover",
        "--out",
        str(tmp_path / "s"),
        "--no-figure",
    ]
    assert cli.main(run) == 0
    exact = fastaff.quantum.exact_levels(
        fastaff.Body(fastaff.Anharmonic()), max_energy=6.0, single_valued=False
    ).multiplets()
    arrays = files.contents(tmp_path / "s.npz").arrays
    np.testing.assert_allclose(arrays["E"], exact.levels.E, rtol=1e-13)
    assert [int(row["degeneracy"]) for row in rows(capsys.readouterr().out)] == exact.degeneracy.tolist()


@pytest.mark.parametrize(("m", "l"), [("-2:2", "0"), ("1", "-3:1"), ("-1:1", "-1:1")])
def test_ranges_of_classes(m, l, capsys, tmp_path):
    assert cli.main([*HYPERELASTIC, "--m", m, "--l", l, "--levels", "3", "--out", str(tmp_path / "s")]) == 0
    arrays = files.contents(tmp_path / "s.npz").arrays
    classes = {("-2:2", "0"): [(-2, 0), (0, 0), (2, 0)], ("1", "-3:1"): [(1, -3), (1, -1), (1, 1)]}.get(
        (m, l), [(-1, -1), (-1, 1), (0, 0), (1, -1), (1, 1)]
    )
    assert sorted(set(zip(arrays["m"].tolist(), arrays["l"].tolist()))) == classes
    table = fastaff.quantum.spectrum_table(
        fastaff.Body(fastaff.Hyperelastic()), m=[c[0] for c in classes], l=[c[1] for c in classes], count=3
    )
    np.testing.assert_allclose(arrays["E"], np.sort(np.concatenate([row.E for row in table])), rtol=1e-13)
    assert f"among these {len(classes)} classes" in capsys.readouterr().err
    assert (tmp_path / "s.png").exists()


def test_scan(capsys, tmp_path):
    run = [
        *HYPERELASTIC,
        "--m",
        "1",
        "--l",
        "-1",
        "--levels",
        "4",
        "--scan",
        "C=0.5:1.5:3",
        "--out",
        str(tmp_path / "s"),
    ]
    assert cli.main(run) == 0
    arrays, metadata = files.contents(tmp_path / "s.npz")
    assert metadata["name"] == "C"
    np.testing.assert_allclose(arrays["values"], [0.5, 1.0, 1.5])
    assert arrays["E"].shape == (3, 1, 4)
    np.testing.assert_allclose(arrays["E"][1, 0, :2], [5.0, 7.0], rtol=1e-14)  # the elementary state
    printed = capsys.readouterr().out.splitlines()
    np.testing.assert_allclose(np.array(printed[3].split(), float), [1.0, *arrays["E"][1, 0]], rtol=1e-7)
    assert (tmp_path / "s.png").exists()
    assert cli.main([*run[:-4], "--scan", "mu=1:2:2", "--no-figure", "--out", str(tmp_path / "mu")]) == 0
    E = files.contents(tmp_path / "mu.npz").arrays["E"]
    heavy = fastaff.quantum.spectrum(fastaff.Body(fastaff.Hyperelastic(), 2.0), m=1, l=-1, count=4).E
    np.testing.assert_allclose(E[1, 0], heavy, rtol=1e-13)


def test_states_are_drawn(tmp_path):
    run = [*HYPERELASTIC, "--m", "0", "--l", "0", "--levels", "4", "--states", "0,3", "--density-chart", "two-polar"]
    assert cli.main([*run, "--out", str(tmp_path / "s")]) == 0
    assert (tmp_path / "s.png").stat().st_size > 10_000
    assert cli.main([*run, "--out", str(tmp_path / "s"), "--no-figure"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s-2.npz", "s.npz", "s.png"]


def test_a_body_that_does_not_separate(capsys, tmp_path):
    run = ["spectrum", "--m", "0", "--l", "0", "--levels", "3", "--tolerance", "1e-4", "--out", str(tmp_path / "s")]
    assert cli.main([*run, "--states", "2"]) == 0
    printed = rows(capsys.readouterr().out)
    truth = fastaff.quantum.spectrum(fastaff.Body(fastaff.NeoHookean()), m=0, l=0, count=3)
    assert [row["number"] for row in printed] == ["0", "1", "2"]
    for row, E in zip(printed, truth.E):
        assert abs(float(row["E"]) - E) < 10 * float(row["error"])
    assert files.contents(tmp_path / "s.npz").metadata["names"] == ["level"]


def test_ctrl_c_keeps_what_is_complete(capsys, tmp_path, monkeypatch):
    from fastaff.quantum.spectra import all_levels as listing

    count = []

    def stopping(*args, **choices):
        count.append(1)
        if len(count) == 3:
            raise KeyboardInterrupt
        return tables(*args, **choices)

    tables = listing.tables_below
    monkeypatch.setattr(listing, "tables_below", stopping)
    assert cli.main(["spectrum", "--model", "harmonic", "--max-energy", "9.5", "--out", str(tmp_path / "s")]) == 130
    arrays, metadata = files.contents(tmp_path / "s.npz")
    end = metadata["complete_below"]
    assert (
        np.diff(arrays["first"]).tolist()
        == fastaff.quantum.exact_levels(fastaff.Body(fastaff.Harmonic()), max_energy=end)
        .multiplets()
        .degeneracy.tolist()
    )
    assert metadata["interrupted"] is True
    assert f"stopped by Ctrl-C: kept {arrays['E'].size} levels, complete below E = {end:.6g}" in capsys.readouterr().err
    assert not (tmp_path / "s.png").exists()


def test_ctrl_c_among_classes(capsys, tmp_path, monkeypatch):
    def stopping(body, m, **choices):
        if m > 0:
            raise KeyboardInterrupt
        return spectrum(body, m=m, **choices)

    spectrum = fastaff.quantum.spectrum
    monkeypatch.setattr(fastaff.quantum, "spectrum", stopping)
    run = [*HYPERELASTIC, "--l", "0", "--levels", "3", "--out", str(tmp_path / "s")]
    assert cli.main([*run, "--m", "0:4"]) == 130
    assert files.contents(tmp_path / "s.npz").arrays["m"].tolist() == [0, 0, 0]
    assert cli.main([*run, "--m", "2"]) == 130
    assert "before any level was finished; nothing is kept" in capsys.readouterr().err


def test_digits_stand_for_errors():
    assert digits(4.85444329439498, 1.9e-14) == "4.8544432943950"
    assert digits(12.3456789, 3e-5) == "12.3457"
    assert digits(12.3456789, 5.0) == "12.35"


def test_levels_of_a_vibration(tmp_path, capsys):
    run = ["spectrum", "--hamiltonian", "k*x**2/2", "--coordinates", "x", "--parameter", "k=4", "--hbar", "0.5"]
    assert cli.main([*run, "--levels", "3", "--out", str(tmp_path / "s")]) == 0
    assert "level" in capsys.readouterr().out
    found = fastaff.load(tmp_path / "s.npz")
    np.testing.assert_allclose(found.E, [0.5, 1.5, 2.5], rtol=1e-9)
    assert (tmp_path / "s.png").stat().st_size > 5000
    assert cli.main(["plot", str(tmp_path / "s.npz"), "--out", str(tmp_path / "again.png")]) == 0
    assert cli.main([*run, "--m", "0", "--l", "0"]) == 2
    assert "takes --levels, --hbar and --tolerance" in capsys.readouterr().err
