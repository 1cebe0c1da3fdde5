"""The command line where something fails: folders that cannot be written, pipes that nobody reads, any words."""

import errno
import importlib
import os
import random
import subprocess
import sys

import pytest
from thorough import TIMES

from fastaff import files
from fastaff.cli.application import COMMANDS
from fastaff.cli.main import main

SMALL = ["--energy", "1.5", "--p-eta", "0.3", "--p-gamma", "0.2", "--grid", "3x3", "--crossings", "3", "--no-figure"]
BROKEN = {"no room": errno.ENOSPC, "read-only": errno.EROFS, "quota": errno.EDQUOT}


def failing(code):
    def fail(*_, **__):
        raise OSError(code, os.strerror(code))

    return fail


@pytest.mark.parametrize("code", BROKEN.values(), ids=BROKEN)
def test_a_folder_that_cannot_be_written_is_found_before_the_run(code, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("tempfile.TemporaryFile", failing(code))
    assert main(["poincare", *SMALL, "--out", str(tmp_path / "x")]) == 2
    said = capsys.readouterr()
    assert f"--out {tmp_path / 'x'}: the folder {tmp_path} cannot be written: {os.strerror(code)}" in said.err
    assert "orbits/s" not in said.err
    assert not list(tmp_path.iterdir())


def test_results_that_cannot_be_written_in_the_end_go_elsewhere(tmp_path, monkeypatch, capsys):
    (tmp_path / "asked").mkdir()
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    own = files.save_among

    def full(path, *given, **named):
        if path.parent.name == "asked":
            failing(errno.ENOSPC)()
        return own(path, *given, **named)

    monkeypatch.setattr(files, "save_among", full)
    assert main(["poincare", *SMALL, "--out", str(tmp_path / "asked" / "x")]) == 0
    said = capsys.readouterr()
    kept = tmp_path / "here" / "x.npz"
    assert f"x.npz cannot be written: No space left on device; the results are in {kept}" in said.err
    assert str(kept) in said.out
    assert len(files.load(kept)) > 0
    monkeypatch.setattr(files, "save_among", failing(errno.ENOSPC))
    assert main(["poincare", *SMALL, "--out", str(tmp_path / "asked" / "x")]) == 2
    assert "No space left on device" in capsys.readouterr().err


def test_results_survive_the_folder_they_were_to_go_to(tmp_path, monkeypatch, capsys):
    """Removed while they were computed, with the current one."""
    (tmp_path / "here").mkdir()
    (tmp_path / "home").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    own = files.save_among

    def gone(path, *given, **named):
        if (tmp_path / "here").exists():
            (tmp_path / "here").rmdir()
            failing(errno.ENOENT)()
        return own(path, *given, **named)

    monkeypatch.setattr(files, "save_among", gone)
    assert main(["poincare", *SMALL, "--out", "x"]) == 0
    kept = tmp_path / "home" / "x.npz"
    assert f"the results are in {kept}" in capsys.readouterr().err
    assert len(files.load(kept)) > 0


def test_memory_that_is_spent_is_one_line(monkeypatch, capsys):
    def spent(*_):
        raise MemoryError

    monkeypatch.setattr("fastaff.cli.application.answer", spent)
    assert main(["poincare", *SMALL]) == 2
    assert capsys.readouterr().err.startswith("fastaff: error: there is not enough memory")


def test_a_name_that_is_too_long_is_found_before_the_run(tmp_path, capsys):
    for name in ("x" * 250, "é" * 125, "x" * 300):
        assert main(["poincare", *SMALL, "--out", str(tmp_path / name)]) == 2
        said = capsys.readouterr().err
        assert "too long" in said
        assert "orbits/s" not in said
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="a shell of POSIX")
@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_are_no_error(closed, tmp_path):
    """What is opened next has their numbers: nothing that is said must be written into it."""
    code = "from fastaff.cli.main import main; main()"
    command = [sys.executable, "-c", code, "poincare", *SMALL, "--out", str(tmp_path / "x")]
    done = subprocess.run(["sh", "-c", f'exec "$@" {closed}', "sh", *command], capture_output=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert len(files.load(tmp_path / "x.npz")) > 0


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no such device")
@pytest.mark.parametrize("command", [["--version"], ["poincare", *SMALL, "--out", "x"]])
def test_a_full_disk_behind_the_standard_output_is_one_line(command, tmp_path):
    code = "from fastaff.cli.main import main; main()"
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", code, *command],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=600,
            check=False,
        )
    assert done.returncode == 2
    assert "No space left" in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == (["x.npz"] if "--out" in command else [])


@pytest.mark.parametrize(
    "command", [["--help"], ["doctor"], ["spectrum", "--model", "harmonic", "--levels", "4", "--no-figure"]]
)
def test_a_reader_that_leaves_is_no_error(command, tmp_path):
    code = f"import sys; from fastaff.cli.main import main; sys.argv = ['fastaff', *{command!r}]; main()"
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run(
            [sys.executable, "-c", code], stdout=writing, stderr=subprocess.PIPE, text=True, cwd=tmp_path, timeout=600
        )
    finally:
        os.close(writing)
    said = done.stderr
    assert done.returncode == (1 if "--help" in command else 141)  # rich, which prints help, ends with 1
    assert "roken" not in said
    assert "Traceback" not in said


# --- any words ----------------------------------------------------------------------------------------------------

_FLAGS = """
energy p-eta p-gamma section direction model formula hamiltonian coordinates parameter domain mu G K C lam grid orbits
rotation magnetic vector-potential
seed q-range p-range file scheme step accuracy threads crossings max-time time returns indicators early-stop scan method
max-order levels m l states hbar tolerance out overwrite no-figure write-job colour vmin vmax chunk quiet log memory
workers dask status json plot help version point samples diffusion no-diffusion
"""
_VALUES = """
0 1 -1 2 0.5 1.5 1/6 pi/2 1e300 -1e300 1e-300 1e9 nan inf -inf 2.7 3x3 0x0 -1x2 100000x100000 x=0 alpha-turning
alpha=nan beta=1/0 1:2 2:1 : 0:1:3 energy=1:2:3 K=0:1:0 neo-hookean henon-heiles harmonic MEGNO sali,megno naff
KAHAN_LI8 leapfrog +1 x*y D1*D2 x**2+y**2 ((( )) __import__ os.system x;y C=1 C=nan a=b=c é 🙂 '' " -- --x -e
/nonexistent/a ../../x . / nothing.npz nothing.toml json all OK escaped 99999999999999999999 0x10 1_000 true None
"""
FLAGS, VALUES = _FLAGS.split(), _VALUES.split()


def words(random):
    """A command line: mostly flags of some command with values that may suit others."""
    line = (
        [random.choice([*COMMANDS, "poincare", "chaos-map", "frequency-map", "spectrum"])]
        if random.random() < 0.97
        else []
    )
    for _ in range(random.randrange(1, 7)):
        flag = random.choice(FLAGS)
        if line[:1] == ["poincare"] and random.random() < 0.3:
            flag = random.choice(["energy", "grid", "section", "out"])
        line.append(f"--{flag}" if random.random() < 0.95 else random.choice(VALUES))
        if random.random() < 0.85:
            line.append(random.choice(VALUES))
    return line


BEGINNINGS = {
    "cli.commands.maps": ("compiled",),
    "cli.commands.animate": ("compiled",),
    "cli.commands.warmup": ("compiled",),
    "cli.commands.spectrum": ("_whole", "_scanned", "_some"),
    "cli.commands.demo": ("is_cold",),
    "cli.commands.doctor": ("_check",),
    "jobs.running": ("begin",),
}
"""Where commands begin to compute."""


class Ran(Exception):
    """What stands for a run that would begin."""


@pytest.fixture
def idle(monkeypatch):
    """No command computes: a line that is right ends where its work would begin."""

    def begin(*_, **__):
        raise Ran

    for module, names in BEGINNINGS.items():
        for name in names:
            monkeypatch.setattr(importlib.import_module(f"fastaff.{module}"), name, begin)


def no_traceback(seed, count, here, monkeypatch, capsys):
    monkeypatch.setenv("HOME", str(here))
    source, ran, codes = random.Random(seed), 0, {}
    for _ in range(count):
        line = words(source)
        try:
            code = main(line)
        except Ran:
            ran += 1
            continue
        codes[code] = codes.get(code, 0) + 1
        said = capsys.readouterr()
        assert code in (0, 1, 2), line
        assert "Traceback" not in said.err + said.out, line
        if code == 2:
            assert said.err.startswith("fastaff: ") or "fastaff: error" in said.err, (line, said.err)
            assert len(said.err.splitlines()) <= 4, (line, said.err)
    assert codes[2] > count // 2
    return ran, codes


def test_no_line_of_words_leads_to_a_traceback(idle, tmp_path, monkeypatch, capsys):
    no_traceback(1, 100, tmp_path, monkeypatch, capsys)


@pytest.mark.slow
def test_no_line_of_many_leads_to_a_traceback(idle, tmp_path, monkeypatch, capsys):
    no_traceback(2, 1000 * TIMES, tmp_path, monkeypatch, capsys)
