"""Commands that are killed while they write: nothing that was written is lost, nothing half written is taken for whole.

Each run is a fork of this process, whose kernels are compiled, with a hook that counts what it does to files in its
folder and sends itself a signal at one of these moments or shortly after.
"""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
import sys
import traceback
import warnings
from typing import NamedTuple

import pytest
from comparison import same
from job_cases import bits
from thorough import TIMES

import fastaff as fa
from fastaff import files
from fastaff.cli.main import main

pytestmark = [pytest.mark.race, pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks here")]

MANY = 2 * TIMES if TIMES > 1 else 1
"""Moments of each command and signal."""

SURFACE = ["--energy", "1.5", "--p-eta", "0.3", "--p-gamma", "0.2"]
SMALL = [*SURFACE, "--grid", "3x3"]
HENON = ["--model", "henon-heiles", "--energy", "0.1"]
JOB = ["poincare", *HENON, "--grid", "6x6", "--crossings", "4", "--max-time", "60", "--step", "0.05", "--no-diffusion"]

COMMANDS = {
    "poincare": ["poincare", *SMALL, "--crossings", "4", "--out", "OUT/x"],
    "poincare, replacing": ["poincare", *SMALL, "--crossings", "4", "--out", "OUT/old", "--overwrite"],
    "frequency-map": ["frequency-map", *SMALL, "--returns", "20", "--out", "OUT/x"],
    "chaos-map": ["chaos-map", *HENON, "--grid", "3x3", "--time", "60", "--out", "OUT/x", "--colour", "diffusion"],
    "spectrum": ["spectrum", "--model", "harmonic", "--m", "0", "--l", "0", "--levels", "4", "--out", "OUT/x"],
    "animate": ["animate", *SURFACE, "--time", "2", "--frames", "2", "--out", "OUT/x.gif"],
    "explore": ["explore", *SURFACE, "--out", "OUT/x.html"],
    "a job's file": [*JOB, "--write-job", "OUT/new.toml"],
    "run": ["run", "OUT/job.toml", "--quiet"],
    "run, replacing": ["run", "OUT/other.toml", "--store", "OUT/whole.zarr", "--overwrite", "--quiet"],
    "resume": ["resume", "OUT/half.zarr", "--quiet"],
    "rerun": ["rerun", "OUT/whole.zarr", "--status", "OK", "--step", "0.04", "--quiet"],
    "plot": ["plot", "OUT/old.npz", "--out", "OUT/x.png"],
}
WRITING = {"os.rename", "os.link", "os.remove", "os.mkdir", "os.rmdir", "os.chmod", "os.truncate", "os.utime"}


class Moment(NamedTuple):
    """When a run is sent what: at the number of a change of files (0: at once), seconds later."""

    number: int
    delay: float
    sent: signal.Signals


class Ended(NamedTuple):
    """How a run ended: exit code, or minus the signal; what it said; how many changes of files it counted."""

    code: int
    said: str
    count: int


def hook(folder, count, moment):
    """Count changes of files in a folder, and send this process a signal at one of them."""
    inside = os.fsencode(folder)

    def watch(event, given):
        if event == "open":
            path, _, flags = given
            if not (isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)):
                return
        elif event in WRITING:
            path = given[0]
        else:
            return
        if not isinstance(path, (str, bytes, os.PathLike)) or not os.fsencode(path).startswith(inside):
            return
        os.write(count, b"+")
        watch.seen += 1
        if moment is not None and watch.seen == moment.number:
            if moment.delay:
                signal.setitimer(signal.ITIMER_REAL, moment.delay)
            else:
                os.kill(os.getpid(), moment.sent)

    watch.seen = 0
    if moment is not None:
        signal.signal(signal.SIGALRM, lambda *_: os.kill(os.getpid(), moment.sent))
        if not moment.number:
            signal.setitimer(signal.ITIMER_REAL, moment.delay)
    sys.addaudithook(watch)


def run(words, folder, moment=None):
    """Run a command in a fork of this process."""
    line = [word.replace("OUT", str(folder)) for word in words]
    said, count = folder.parent / "said", folder.parent / "count"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads of the kernels, which survive a fork
        child = os.fork()
    if child == 0:
        code = 99
        try:
            out = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(out, 1)
            os.dup2(out, 2)
            sys.stdout, sys.stderr = os.fdopen(1, "w", closefd=False), os.fdopen(2, "w", closefd=False)
            for number in (signal.SIGINT, signal.SIGTERM):  # what comes before the command begins, or when it has ended
                signal.signal(number, lambda *_: None)
            hook(folder, os.open(count, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), moment)
            code = main(line)
        except SystemExit as left:
            code = left.code
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    _, status = os.waitpid(child, 0)
    return Ended(os.waitstatus_to_exitcode(status), said.read_text(), len(count.read_bytes()))


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A folder of results, jobs and stores, and what each command makes of it undisturbed."""
    home = tmp_path_factory.mktemp("kills")
    folder = home / "prepared"
    folder.mkdir()
    for words in (COMMANDS["poincare"], COMMANDS["frequency-map"], [*JOB, "--write-job", f"{folder}/job.toml"]):
        name = "old" if "--out" in words else "job"
        assert main([word.replace("OUT/x", f"{folder}/{name}") for word in words]) == 0
    job = fa.jobs.Job.read(folder / "job.toml")
    text = re.sub(r"(?m)\A", "chunk = 5\n", job.text())
    (folder / "job.toml").write_text(text)
    (folder / "other.toml").write_text(text.replace("step = 0.05", "step = 0.1"))
    fa.run(fa.jobs.Job.read(folder / "job.toml"), folder / "whole.zarr")

    def stop(progress, chunk):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fa.run(fa.jobs.Job.read(folder / "job.toml"), folder / "half.zarr", on_chunk=stop)
    made = {}

    def get(name):
        if name not in made:
            there = copied(folder, home / "made" / name.replace(" ", "-"))
            for _ in range(2):  # compiled by the first
                shutil.rmtree(there)
                copied(folder, there)
                ended = run(COMMANDS[name], there)
                assert ended.code == 0, ended.said
            made[name] = there, ended.count
        return folder, *made[name]

    return get


def copied(folder, to):
    """Copy a folder."""
    shutil.copytree(folder, to)
    return to


def content(path):
    """Return what a whole file or store holds; whatever is not whole is refused by what reads it."""
    if path.suffix == ".npz":
        return files.load(path)
    if path.suffix in (".png", ".gif"):
        from PIL import Image

        with Image.open(path) as image:
            image.load()
            return image.size
    if path.suffix == ".zarr":
        return bits(fa.jobs.JobResults.stored(path))
    text = path.read_text()
    assert path.suffix != ".html" or text.rstrip().endswith("</html>")
    return text if path.suffix == ".toml" else len(text)


def visible(folder):
    """Return names in a folder but those of drafts."""
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT], ids=lambda sent: sent.name)
@pytest.mark.parametrize("name", COMMANDS)
def test_whatever_moment_a_command_is_killed_at(name, sent, prepared, tmp_path):
    folder, made, count = prepared(name)
    assert count > 0
    source = random.Random(f"{name} {sent}")
    for number in range(MANY):
        moment = Moment(source.randint(1, count), source.choice([0.0, source.uniform(1e-4, 0.05)]), sent)
        there = copied(folder, tmp_path / str(number) / "x")
        ended = run(COMMANDS[name], there, moment)
        about = f"{moment}: {ended}"
        assert ended.code in ((0, -9) if sent == signal.SIGKILL else (0, 130)), about
        assert "Traceback" not in ended.said, about
        assert "Exception" not in ended.said, about
        assert visible(folder) <= visible(there) <= visible(made), about
        if sent != signal.SIGKILL:  # one, where it came while that was removed
            assert len([path.name for path in there.iterdir() if path.name.startswith(".fastaff")]) <= 1, about
        for one in visible(there):
            if one.endswith(".zarr"):
                continue
            found = content(there / one)
            wholes = [content(home / one) for home in (folder, made) if (home / one).exists()]
            assert any(alike(found, whole) for whole in wholes), f"{one} {about}"
        finished(name, there, made, about)


LONGER = {
    "poincare": ["poincare", *SURFACE, "--grid", "30x30", "--crossings", "40", "--out", "OUT/x", "--no-figure"],
    "frequency-map": ["frequency-map", *SURFACE, "--grid", "20x20", "--out", "OUT/x"],
    "chaos-map": ["chaos-map", *HENON, "--grid", "20x20", "--out", "OUT/x", "--colour", "diffusion"],
    "spectrum": ["spectrum", "--model", "harmonic", "--levels", "60", "--out", "OUT/x"],
    "animate": ["animate", *SURFACE, "--frames", "20", "--out", "OUT/x.gif"],
    "resume": ["resume", "OUT/half.zarr", "--quiet"],
    "rerun": ["rerun", "OUT/whole.zarr", "--status", "OK", "--step", "0.001", "--quiet"],
    "status": ["status", "OUT/half.zarr"],
    "doctor": ["doctor"],
    "help": ["poincare", "--help"],
}
"""Commands that take a while."""


@pytest.mark.parametrize("name", LONGER)
def test_ctrl_c_at_any_moment(name, prepared, tmp_path):
    """What it leaves is whole: results of the orbits that were finished, or nothing."""
    folder, _, _ = prepared("plot")
    source = random.Random(f"moments {name}")
    for number in range(TIMES):
        there = copied(folder, tmp_path / str(number) / "x")
        ended = run(LONGER[name], there, Moment(0, source.uniform(1e-3, 3.0), signal.SIGINT))
        assert ended.code in (0, 130), ended
        assert "Traceback" not in ended.said, ended
        assert ended.code == 0 or "topped by Ctrl-C" in ended.said or "stopped: " in ended.said, ended
        for one in visible(there) - {"half.zarr", "whole.zarr"}:
            content(there / one)
        for store in ("half.zarr", "whole.zarr"):
            content(there / store)


def alike(one, other):
    """Tell whether two results are the same."""
    try:
        same(one, other)
    except AssertionError:
        return False
    return True


STORES = {"run": "job.zarr", "run, replacing": "whole.zarr", "resume": "half.zarr", "rerun": "whole.zarr"}


def finished(name, there, made, about):
    """Assert that a job that is run again comes to what it would have come to."""
    if name not in STORES:
        return
    store = there / STORES[name]
    before = fa.jobs.JobResults.stored(store) if store.exists() else None
    assert before is not None or name == "run", about
    again = COMMANDS[name] if before is None or name == "run, replacing" else ["resume", str(store), "--quiet"]
    ended = run(again, there)
    assert ended.code == 0, (about, ended.said)
    if name == "rerun" and not alike(content(store), content(made / STORES[name])):
        ended = run(COMMANDS[name], there)  # it was killed before the store knew of it
        assert ended.code == 0, (about, ended.said)
    got, wanted = content(store), content(made / STORES[name])
    assert alike(got, wanted), about


def test_results_that_are_computed_are_written_whatever_comes(prepared, tmp_path):
    """A signal that comes while results are written waits for that."""
    for name in ("poincare", "chaos-map"):
        folder, made, count = prepared(name)
        for number in range(1, count + 1):
            there = copied(folder, tmp_path / name / str(number) / "x")
            ended = run(COMMANDS[name], there, Moment(number, 0.0, signal.SIGTERM))
            if "orbits/s" in ended.said or "largest error" in ended.said:
                same(files.load(there / "x.npz"), files.load(made / "x.npz"))
            assert ended.code == 130 or (ended.code == 0 and (there / "x.png").exists()), ended
