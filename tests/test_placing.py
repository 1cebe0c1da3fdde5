"""Files that are whole or not there; names that no two runs share."""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from fastaff.base import placing
from fastaff.base.placing import free_stem, placed


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def half(path):
    path.write_text("ha")
    raise OSError(28, "No space left on device")


def test_a_file_that_cannot_be_written_leaves_the_old_one(tmp_path):
    (tmp_path / "a.png").write_text("good")
    for force in (True, False):
        with pytest.raises(OSError, match="No space left"):
            placed(tmp_path / "a", ".png", half, force=force)
    assert names(tmp_path) == ["a.png"]
    assert (tmp_path / "a.png").read_text() == "good"
    with pytest.raises(FileNotFoundError, match=r"the folder .*nowhere does not exist"):
        placed(tmp_path / "nowhere" / "a", ".png", half)


@pytest.mark.parametrize("links", [True, False])
def test_each_name_is_taken_once(tmp_path, monkeypatch, links):
    def none(*_):
        raise OSError(95, "Operation not supported")

    if not links:  # a file system without them
        monkeypatch.setattr(os, "link", none)
    texts = [str(k) * 10_000 for k in range(40)]
    with ThreadPoolExecutor(8) as pool:
        paths = list(pool.map(lambda text: placed(tmp_path / "a", ".txt", lambda path: path.write_text(text)), texts))
    assert len(set(paths)) == len(texts)
    assert [path.read_text() for path in paths] == texts
    assert len(names(tmp_path)) == len(texts)


def test_numbers_are_free_of_what_stands_beside_and_of_broken_links(tmp_path):
    (tmp_path / "a.png").touch()
    (tmp_path / "a-2.npz").symlink_to(tmp_path / "nowhere")
    (tmp_path / "a-3.npz").mkdir()
    assert free_stem(tmp_path / "a", (".npz", ".png")) == tmp_path / "a-4"
    assert placed(tmp_path / "a", ".npz", lambda path: path.write_text("x"), beside=[".png"]).name == "a-4.npz"
    assert placed(tmp_path / "a", ".npz", lambda path: path.write_text("x")).name == "a.npz"


def test_permissions_are_those_of_new_files(tmp_path):
    (tmp_path / "usual").touch()
    path = placed(tmp_path / "a", ".txt", lambda path: path.write_text("x"))
    assert path.stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_a_file_that_cannot_be_moved_to_its_name_leaves_none(tmp_path, monkeypatch):
    """On a file system without links, whose names are taken by empty files."""

    def fail(*_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(os, "link", fail)
    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="Input/output error"):
        placed(tmp_path / "a", ".txt", lambda path: path.write_text("x"))
    assert names(tmp_path) == []


def test_what_killed_processes_left_goes(tmp_path):
    """Not what is young, what has another name and what a link leads to."""
    long_ago = time.time() - 2 * placing.LEFT
    elsewhere, folder = tmp_path / "elsewhere", tmp_path / "results"
    elsewhere.mkdir()
    folder.mkdir()
    (elsewhere / "good").touch()
    for name in (".fastaff-left.npz", ".fastaff-young.npz", ".mine.npz"):
        (folder / name).write_text("x")
    (folder / ".fastaff-store").mkdir()
    (folder / ".fastaff-store" / "chunk").touch()
    (folder / ".fastaff-link").symlink_to(elsewhere)
    for path in folder.iterdir():
        if "young" not in path.name:
            os.utime(path, (long_ago, long_ago), follow_symlinks=False)
    with placing.draft(folder, ".png") as held, placing.draft(folder, of_files=True) as folder_held:
        placed(folder / "a", ".npz", lambda path: path.write_text("x"))
        assert set(names(folder)) == {".fastaff-young.npz", ".mine.npz", "a.npz", held.name, folder_held.name}
    assert set(names(folder)) == {".fastaff-young.npz", ".mine.npz", "a.npz"}
    assert names(elsewhere) == ["good"]
