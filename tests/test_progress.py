"""What long calls say on terminals: the share done, the time left, and how long this machine compiles."""

import threading
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import fastaff as fa
from fastaff.base import progress
from fastaff.base.recipe import recorded
from fastaff.jobs.watching import says_progress


@dataclass(frozen=True)
class Answer:
    told: bool


@recorded
def inner(x=0.0, *, report=None) -> Answer:
    return Answer(report is not None)


@recorded
def outer(x=0.0, *, report=None) -> Answer:
    assert not inner(x).told  # part of what is watched
    return Answer(report is not None)


@pytest.fixture
def shown(monkeypatch):
    monkeypatch.setattr(progress._Shown, "wanted", None)
    fa.progress(True)


@pytest.fixture
def clock(monkeypatch):
    now = SimpleNamespace(time=100.0)
    monkeypatch.setattr(progress.clock, "perf_counter", lambda: now.time)
    return now


def test_who_is_watched(shown):
    """The outermost call of the main thread, unless it is given a report; its recipe is the same."""
    assert inner().told
    assert outer().told
    assert inner(report=None).told
    reports = []
    assert inner(report=reports.append).told
    assert not reports
    fa.progress(False)
    assert not inner().told
    assert inner(2.0).call == inner(2.0, report=reports.append).call
    fa.progress(True)
    assert inner(2.0).call.arguments == {"x": 2.0}
    found = []
    thread = threading.Thread(target=lambda: found.append(inner().told))
    thread.start()
    thread.join()
    assert found == [False]


def test_jobs_say_how_much_is_done(shown):
    """Of a job, and of its parts nothing; what is told by itself says nothing."""

    @says_progress
    def run(job, *, report=None, watch=None):
        assert not inner().told
        return report

    assert run("job") is not None
    assert run("job", report=None) is None
    told = print
    assert run("job", report=told) is told
    assert run("job", watch=told) is None
    assert fa.run.__name__ == "run"
    assert fa.run.__wrapped__.__doc__ == fa.run.__doc__


@pytest.mark.parametrize("wrong", [None, 1, "no", np.array(True)])
def test_progress_takes_a_bool(wrong):
    with pytest.raises(TypeError, match="shown must be True or False, got"):
        fa.progress(wrong)


def test_where_nobody_looks(monkeypatch):
    monkeypatch.setattr(progress._Shown, "wanted", None)
    assert not inner().told  # pytest takes stderr
    monkeypatch.setattr(progress.sys, "stderr", SimpleNamespace(isatty=lambda: True))
    assert progress._looked_at()
    monkeypatch.setenv("FASTAFF_PROGRESS", "0")
    assert not progress._looked_at()


def test_share_and_time_left(clock):
    line = progress._Line("poincare_map")
    assert line.text(1.9) == ""
    assert line.text(3.0) == "poincare_map: 3 s"
    line.report(0.1)
    clock.time += 20.0
    line.report(0.35)  # a quarter in 20 s: the other 65 % take 52 s
    assert line.text(23.0) == "poincare_map:  35%, about 52 s left"
    line.report(0.0)  # another pass
    clock.time += 60.0
    line.report(0.01)
    assert line.text(83.0) == "poincare_map:   1%, about 1.6 h left"


def test_seconds_of_compilation_are_those_of_this_machine(tmp_path, monkeypatch, clock):
    sources = ["a"]
    monkeypatch.setattr(progress.Compiling, "root", lambda: tmp_path)
    monkeypatch.setattr(progress.Compiling, "sources", lambda: sources[0])
    monkeypatch.setattr(progress.Compiling, "kernels", 0)
    assert progress.compile_seconds("chaos_map") == progress.SECONDS["chaos_map"]
    line = progress._Line("chaos_map")
    progress.Compiling.kernels += 1
    with progress.Compiling.under_way():
        clock.time += 5.0
        with progress.Compiling.under_way():  # of what it calls: the same time
            clock.time += 2.0
        assert line.text(7.0) == "chaos_map: compiling once, 7 s of about 13 s"
    line.start()
    line.end()
    assert progress.compile_seconds("chaos_map") == progress.MORE  # once more: a new model
    progress.keep_seconds("chaos_map", 3.0)
    assert progress.compile_seconds("chaos_map") == 3.0
    sources[0] = "b"  # a new version
    assert progress.compile_seconds("chaos_map") == 7.0
    sources[0] = ""  # a pack
    assert progress.compile_seconds("chaos_map") == 3.0
    (tmp_path / "seconds.json").write_text('{"chaos_map": "x"}')
    assert progress.compile_seconds("chaos_map") == progress.MORE


def test_a_line_is_taken_away(capsys):
    line = progress._Line("integrate")
    line.write("integrate: 5 s")
    line.write("integrate")
    line.start()
    line.end()
    assert capsys.readouterr().err == "\rintegrate: 5 s\rintegrate     \r         \r\r"


def test_in_a_notebook_a_line_replaces_the_one_before(monkeypatch, clock):
    """And ends as nothing: a stream's lines would all stay in the saved file."""
    pytest.importorskip("IPython")
    shown, outputs = [], {}

    def display(output, *, raw, display_id):
        assert raw
        assert display_id is True
        shown.append(output["text/plain"])
        outputs["line"] = output
        return SimpleNamespace(
            update=lambda output, raw: (shown.append(output["text/plain"]), outputs.update(line=output))
        )

    monkeypatch.setattr("IPython.display.display", display)
    monkeypatch.setattr(progress, "in_notebook", lambda: True)
    line = progress._Line("frequency_map")
    for text in ("frequency_map: 3 s", "frequency_map: 4 s"):
        line.write(text)
    line.start()
    line.end()
    assert shown == ["frequency_map: 3 s", "frequency_map: 4 s", ""]
    assert outputs == {"line": {"text/plain": ""}}
    silent = progress._Line("frequency_map")
    silent.start()
    silent.end()
    assert len(shown) == 3  # a short call puts nothing there


@pytest.mark.slow
def test_a_kernel_shows_progress_and_a_saved_notebook_has_none_of_it(monkeypatch):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.delenv("FASTAFF_PROGRESS", raising=False)
    begin = (
        "import time\nimport fastaff as fa\nfrom fastaff.base import progress\nprogress.SILENCE = 0.1\n"
        "def work():\n    with progress.watched('work') as report:\n        for i in range(10):\n"
        "            time.sleep(0.1)\n            report and report(i / 10)\n    print('done')"
    )
    cells = [nbformat.v4.new_code_cell(text) for text in (begin, "work()", "fa.progress(False)\nwork()")]
    told = []

    class Client(nbclient.NotebookClient):
        def process_message(self, message, cell, index):
            if message["msg_type"].endswith("display_data"):
                told.append((index, message["content"]["data"]["text/plain"]))
            return super().process_message(message, cell, index)

    book = nbformat.v4.new_notebook(cells=cells)
    Client(book, timeout=60, kernel_name="python3").execute()
    assert {index for index, _ in told} == {1}
    assert any("%, about " in text for _, text in told)
    assert told[-1] == (1, "")
    data, stream = cells[1].outputs
    assert data.data == {"text/plain": ""}
    assert stream.text == cells[2].outputs[0].text == "done\n"
