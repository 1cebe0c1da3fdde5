"""Files that are whole or not there; names that no two runs share."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from thorough import TIMES

import fastaff as fa
from fastaff.core import placing
from fastaff.core.placing import free_stem, write_atomically
from fastaff.exchange.jpl import read_periodic
from fastaff.exchange.three_bodies import read_three_bodies


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def half(path):
    path.write_text("ha")
    raise OSError(28, "No space left on device")


def test_a_file_that_cannot_be_written_leaves_the_old_one(tmp_path):
    (tmp_path / "a.png").write_text("good")
    for force in (True, False):
        with pytest.raises(OSError, match="No space left"):
            write_atomically(tmp_path / "a", ".png", half, overwrite=force)
    assert names(tmp_path) == ["a.png"]
    assert (tmp_path / "a.png").read_text() == "good"
    with pytest.raises(FileNotFoundError, match=r"the folder .*nowhere does not exist"):
        write_atomically(tmp_path / "nowhere" / "a", ".png", half)


@pytest.mark.parametrize("links", [True, False])
def test_each_name_is_taken_once(tmp_path, monkeypatch, links):
    def none(*_):
        raise OSError(95, "Operation not supported")

    if not links:  # a file system without them
        monkeypatch.setattr(os, "link", none)
    texts = [str(k) * 10_000 for k in range(40)]
    with ThreadPoolExecutor(8) as pool:
        paths = list(
            pool.map(lambda text: write_atomically(tmp_path / "a", ".txt", lambda path: path.write_text(text)), texts)
        )
    assert len(set(paths)) == len(texts)
    assert [path.read_text() for path in paths] == texts
    assert len(names(tmp_path)) == len(texts)


def test_numbers_are_free_of_what_stands_beside_and_of_broken_links(tmp_path):
    (tmp_path / "a.png").touch()
    (tmp_path / "a-2.npz").symlink_to(tmp_path / "nowhere")
    (tmp_path / "a-3.npz").mkdir()
    assert free_stem(tmp_path / "a", (".npz", ".png")) == tmp_path / "a-4"
    assert (
        write_atomically(tmp_path / "a", ".npz", lambda path: path.write_text("x"), beside=[".png"]).name == "a-4.npz"
    )
    assert write_atomically(tmp_path / "a", ".npz", lambda path: path.write_text("x")).name == "a.npz"


def test_permissions_are_those_of_new_files(tmp_path):
    (tmp_path / "usual").touch()
    path = write_atomically(tmp_path / "a", ".txt", lambda path: path.write_text("x"))
    assert path.stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_a_file_that_cannot_be_moved_to_its_name_leaves_none(tmp_path, monkeypatch):
    """On a file system without links, whose names are taken by empty files."""

    def fail(*_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(os, "link", fail)
    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="Input/output error"):
        write_atomically(tmp_path / "a", ".txt", lambda path: path.write_text("x"))
    assert names(tmp_path) == []


# --- permissions ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444, 0o664, 0o700])
def test_a_file_that_is_replaced_keeps_its_permissions(mode, tmp_path):
    for ending, write in ((".npz", fa.save), (".csv", fa.save)):
        path = tmp_path / f"a{ending}"
        path.write_text("private")
        path.chmod(mode)
        assert write(path, fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=0.5), overwrite=True) == path
        assert path.stat().st_mode & 0o777 == mode
        assert path.stat().st_size > 100


def test_a_private_file_behind_a_link_is_replaced_by_a_private_one(tmp_path):
    (tmp_path / "there").write_text("x")
    (tmp_path / "there").chmod(0o600)
    (tmp_path / "a.txt").symlink_to(tmp_path / "there")
    path = write_atomically(tmp_path / "a", ".txt", lambda path: path.write_text("new"), overwrite=True)
    assert not path.is_symlink()
    assert path.stat().st_mode & 0o777 == 0o600
    assert (tmp_path / "there").read_text() == "x"


def test_a_draft_is_its_users_own(tmp_path):
    """What is not finished is not for others, whatever the umask is: the marker is."""
    with placing.draft(tmp_path, ".txt") as path:
        assert (path.parent / placing.MARKER).stat().st_mode & 0o777 == 0o600
        assert path.parent.stat().st_mode & 0o777 == 0o700


# --- drafts of killed processes, and the user's own files -----------------------------------------------------------

LONG_AGO = time.time() - 5 * placing.LEFT
WORDS = ["cache", "run.zarr", "config.toml", "notes", "data", "old", "tmp", "draft", "0123456789ab", "left.npz", "lock"]
DIGITS = "0123456789abcdef"
TEXT = f"{placing.SAID}{os.uname().nodename if hasattr(os, 'uname') else ''}\n"

needs_locks = pytest.mark.skipif(placing.locks is None, reason="no locks of files here")


def name_of_a_user(rng):
    """A name that a user could have: of words, of digits, of both; nearly or exactly that of a draft."""
    digits = "".join(rng.choices(DIGITS, k=rng.choice([1, 5, 8, 11, 12, 12, 12, 13, 16])))
    body = rng.choice([rng.choice(WORDS), digits, digits.upper(), f"{digits}.{rng.choice(WORDS)}"])
    return f"{rng.choice(['.fastaff-', '.fastaff-', '.fastaff', 'fastaff-', '.fastaff_'])}{body}" + rng.choice(
        ["", "", ".draft", ".draft", ".npz", ".tmp", ".partial", ".draft.txt"]
    )


def put(path, rng, elsewhere):
    """Make something of any kind at a path; it may look like a draft, but has not its marker."""
    kind = rng.choice(["file", "folder", "marked", "machine", "empty", "linked", "to folder", "to file", "to nothing"])
    if kind == "file":
        path.write_text("precious")
    elif kind.startswith("to "):
        path.symlink_to(elsewhere / {"to folder": "folder", "to file": "folder/file"}.get(kind, "nothing"))
    else:
        path.mkdir()
        (path / "data.txt").write_text("precious")
        said = {"marked": "mine\n", "machine": f"{placing.SAID}another-machine\n", "empty": ""}.get(kind)
        if said is not None:
            (path / placing.MARKER).write_text(said)
        if kind == "linked":
            (elsewhere / "marker").write_text(TEXT)
            (path / placing.MARKER).symlink_to(elsewhere / "marker")
    age(path)


def age(path):
    inside = [] if path.is_symlink() or not path.is_dir() else [*path.rglob("*")]
    for entry in (*inside, path):
        os.utime(entry, (LONG_AGO, LONG_AGO), follow_symlinks=False)


def everything(folder):
    """Every path with its kind and content."""
    return {
        path: os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


@pytest.mark.parametrize("seed", range(4 * TIMES))
def test_whatever_a_user_has_stays(seed, tmp_path):
    """Names like those of drafts, of files, folders and links of any kind, untouched for days."""
    rng = random.Random(f"users {seed}")
    folder, elsewhere = tmp_path / "results", tmp_path / "elsewhere"
    folder.mkdir()
    (elsewhere / "folder").mkdir(parents=True)
    (elsewhere / "folder" / "file").write_text("precious")
    for name in {name_of_a_user(rng) for _ in range(60)}:
        put(folder / name, rng, elsewhere)
    age(elsewhere)
    before = everything(tmp_path)
    assert len(before) > 50
    made = {write_atomically(folder / "a", ".npz", lambda path: path.write_text("x"))}
    with placing.draft(folder, of_files=True):
        pass
    after = everything(tmp_path)
    assert {path: kept for path, kept in after.items() if path not in made} == before


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("whose", ["folder", "marker"])
def test_drafts_of_other_users_stay(whose, tmp_path):
    left = tmp_path / ".fastaff-0123456789ab.draft"
    left.mkdir()
    (left / placing.MARKER).write_text(TEXT)
    os.chown(left if whose == "folder" else left / placing.MARKER, 54321, -1)
    age(left)
    before = everything(tmp_path)
    placing.sweep_drafts(tmp_path)
    assert everything(tmp_path) == before


KILLED = """
import os, sys, signal
from pathlib import Path
from fastaff.core import placing
with placing.draft(Path(sys.argv[1]), ".npz") as one, placing.draft(Path(sys.argv[1]), of_files=True) as other:
    one.write_text("half")
    (other / "chunk").write_text("half")
    print(one.parent.name, other.parent.name, flush=True)
    sys.stdin.read(1)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.race
@needs_locks
def test_what_killed_processes_left_goes_and_what_lives_stays(tmp_path, monkeypatch):
    """Drafts in use stay whatever the clock says: those of another process, of another thread, and this one's."""
    (tmp_path / "mine.npz").write_text("x")
    with subprocess.Popen(
        [sys.executable, "-c", KILLED, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        drafts = process.stdout.readline().split()
        for name in drafts:
            age(tmp_path / name)
        monkeypatch.setattr(placing.clock, "time", lambda: LONG_AGO + 50 * placing.LEFT)
        with placing.draft(tmp_path, ".png") as held, ThreadPoolExecutor(1) as pool:
            age(held.parent)
            pool.submit(lambda: write_atomically(tmp_path / "a", ".npz", lambda path: path.write_text("x"))).result()
            assert set(names(tmp_path)) == {*drafts, held.parent.name, "a.npz", "mine.npz"}
        process.communicate("x")
    monkeypatch.undo()
    for name in drafts:
        os.utime(tmp_path / name)
    assert set(names(tmp_path)) == {*drafts, "a.npz", "mine.npz"}
    placing.sweep_drafts(tmp_path)  # young
    assert set(names(tmp_path)) == {*drafts, "a.npz", "mine.npz"}
    for name in drafts:
        age(tmp_path / name)
    write_atomically(tmp_path / "a", ".npz", lambda path: path.write_text("x"))
    assert set(names(tmp_path)) == {"a.npz", "a-2.npz", "mine.npz"}


@needs_locks
def test_where_locks_fail_nothing_is_removed(tmp_path, monkeypatch):
    def none(*_):
        raise OSError(95, "Operation not supported")

    left = tmp_path / ".fastaff-0123456789ab.draft"
    left.mkdir()
    (left / placing.MARKER).write_text(TEXT)
    age(left)
    monkeypatch.setattr(placing.locks, "flock", none)
    assert write_atomically(tmp_path / "a", ".npz", lambda path: path.write_text("x")).name == "a.npz"
    assert names(tmp_path) == [left.name, "a.npz"]
    monkeypatch.undo()
    placing.sweep_drafts(tmp_path)
    assert names(tmp_path) == ["a.npz"]


# --- what is no file ------------------------------------------------------------------------------------------------

READS = {
    "job": fa.Job.read,
    "load": fa.load,
    "recipe": fa.files.recipe,
    "contents": fa.files.contents,
    "starts": lambda path: fa.Job(
        model=fa.HenonHeiles(),
        initial_conditions=fa.jobs.InitialConditions(file=str(path)),
        integrate=fa.jobs.IntegrateOptions(time=1.0),
    ).plan(),
    "three bodies": read_three_bodies,
    "jpl": read_periodic,
    "map": fa.iterated_map,
}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
@pytest.mark.parametrize("kind", ["pipe", "device", "link to a pipe"])
@pytest.mark.parametrize("read", READS)
def test_pipes_are_refused_at_once(read, kind, tmp_path):
    """Nobody writes into them: to open one would wait without an end."""
    path = tmp_path / "pipe.npz"
    os.mkfifo(path)
    if kind != "pipe":
        path = tmp_path / "link.npz"
        path.symlink_to("/dev/zero" if kind == "device" else tmp_path / "pipe.npz")
    with pytest.raises(ValueError, match=r"must be a file.* got the pipe or device"):
        READS[read](path)


def test_texts_may_begin_with_a_byte_order_mark(tmp_path):
    """As those of some editors do."""
    job = fa.Job(
        model=fa.jobs.Model(model="henon-heiles"),
        energy_surface=fa.jobs.EnergySurface(energy=0.1),
        integrate=fa.jobs.IntegrateOptions(time=1.0),
    )
    for encoding in ("utf-8", "utf-8-sig"):
        (tmp_path / "job.toml").write_text(job.text(), encoding=encoding)
        assert fa.Job.read(tmp_path / "job.toml") == job
