"""What long calls say: that they compile and for how long, the share done, and the time left."""

import importlib
import inspect
import logging
import os
import re
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import fastaff as fa
from fastaff.cli.progress import compiled
from fastaff.core.numbers import Passes
from fastaff.results import progress
from fastaff.results.calls import records_call
from fastaff.results.progress import says_progress
from fastaff.runs.flow import early


@dataclass(frozen=True)
class Answer:
    told: bool


@records_call
def inner(x=0.0, *, callback=None) -> Answer:
    return Answer(callback is not None)


@records_call
def outer(x=0.0, *, callback=None) -> Answer:
    assert not inner(x).told  # part of what is watched
    return Answer(callback is not None)


@pytest.fixture
def shown(monkeypatch):
    monkeypatch.setattr(progress._Shown, "wanted", None)
    fa.show_progress(True)


@pytest.fixture
def clock(monkeypatch):
    now = SimpleNamespace(time=100.0)
    monkeypatch.setattr(progress.clock, "perf_counter", lambda: now.time)
    return now


def test_who_is_watched(shown):
    """The outermost call of the main thread, unless it is given a callback; its recipe is the same."""
    assert inner().told
    assert outer().told
    assert inner(callback=None).told
    reports = []
    assert inner(callback=reports.append).told
    assert not reports
    fa.show_progress(False)
    assert not inner().told
    assert inner(2.0).call == inner(2.0, callback=reports.append).call
    fa.show_progress(True)
    assert inner(2.0).call.arguments == {"x": 2.0}
    found = []
    thread = threading.Thread(target=lambda: found.append(inner().told))
    thread.start()
    thread.join()
    assert found == [False]


def test_jobs_say_how_much_is_done(shown):
    """Of a job, and of its parts nothing; what is told by itself says nothing."""

    @says_progress
    def run(job, *, callback=None, on_chunk=None):
        assert not inner().told
        return callback

    assert run("job") is not None
    assert run("job", callback=None) is None
    told = print
    assert run("job", callback=told) is told
    assert run("job", on_chunk=told) is None
    for function in (fa.hamiltonian, fa.affine_body, fa.iterated_map, fa.ode):
        assert function.__wrapped__  # it is watched: derivatives of new texts take seconds
    assert fa.run.__name__ == "run"
    assert fa.run.__wrapped__.__doc__ == fa.run.__doc__


@pytest.mark.parametrize("wrong", [None, 1, "no", np.array(True)])
def test_progress_takes_a_bool(wrong):
    with pytest.raises(TypeError, match="shown must be True or False, got"):
        fa.show_progress(wrong)


def test_where_nobody_looks(monkeypatch):
    """Pipes get no shares unless they are asked for; nobody is told where that is asked for."""
    monkeypatch.setattr(progress._Shown, "wanted", None)
    monkeypatch.delenv("FASTAFF_PROGRESS")
    monkeypatch.setattr(progress.sys, "stderr", SimpleNamespace(isatty=lambda: False))
    assert not inner().told
    assert isinstance(progress._line("inner", True), progress._LoggedLines)
    assert progress._line("inner", False) is None
    monkeypatch.setenv("FASTAFF_PROGRESS", "1")
    assert inner().told
    monkeypatch.setattr(progress.sys, "stderr", SimpleNamespace(isatty=lambda: True))
    monkeypatch.delenv("FASTAFF_PROGRESS")
    assert type(progress._line("inner", False)) is progress._Line
    monkeypatch.setenv("FASTAFF_PROGRESS", "0")
    assert progress._line("inner", True) is None
    monkeypatch.setattr(progress._Shown, "wanted", True)  # the process says it later
    assert type(progress._line("inner", True)) is progress._Line


def test_a_call_with_an_executor_starts_no_thread_in_a_pipe(monkeypatch):
    """Its processes fork meanwhile."""
    monkeypatch.setattr(progress._Shown, "wanted", None)
    monkeypatch.delenv("FASTAFF_PROGRESS")
    running = says_progress(lambda executor=None: threading.active_count() - before)
    before = threading.active_count()
    assert running() == 1
    assert running(executor="pool") == 0


def test_a_branch_says_where_it_is(monkeypatch, shown):
    """The share of its steps or of the way to its bound, whichever is more, and its energy; within another, nothing."""
    told = []
    monkeypatch.setattr(progress._Line, "report", lambda line, fraction: told.append((line.what, fraction)))
    said = {"section": "x=0", "energy": 0.1, "max_time": 20.0, "step": 0.1}
    start = [0.0, 0.0, 0.3, 0.31]
    with progress.watched("continuation"):
        line = progress._Shown.line
        branch = fa.continuation(fa.HenonHeiles(), start, max_steps=4, bounds=(0.0, 0.101), **said)
        assert line.said == f", at {branch.parameter[-2]:.6g}"
        line.marks = [(0.0, 0.0), (progress.computed(), 0.5)]
        assert f"continuation:  50%, at {branch.parameter[-2]:.6g}, about " in line.text(30.0)
    assert branch.parameter[-1] == 0.101
    done = [fraction for _, fraction in told]
    steps, way = np.arange(len(done)) / 4, (branch.parameter[: len(done)] - 0.1) / 0.001
    np.testing.assert_allclose(done, np.maximum(steps, way), rtol=0, atol=1e-12)
    assert {what for what, _ in told} == {"continuation"}
    told.clear()
    with progress.watched("find_periodic_orbits"):
        starts = np.array([start, [0.0, 0.1, 0.3, 0.3]]).T
        fa.find_periodic_orbits(fa.HenonHeiles(), starts, section="x=0", max_crossings=2, scan_crossings=8, step=0.1)
        assert progress._Shown.line.said == ", 2 of 2 crossings"
    assert told == [("find_periodic_orbits", 0.0), ("find_periodic_orbits", 0.5)]
    told.clear()
    with progress.watched("tunes"):
        fa.continuation(fa.HenonHeiles(), start, max_steps=1, **said)
    assert not told
    assert progress._Shown.line is None


def test_share_and_time_left(clock, monkeypatch):
    monkeypatch.setattr(progress.Compiling, "seconds", 0.0)
    line = progress._Line("poincare_map")
    assert line.text(1.4) == ""
    assert line.text(3.0) == "poincare_map: 3 s"
    line.report(0.1)
    assert line.text(3.0) == "poincare_map: 3 s"
    clock.time += 20.0
    line.report(0.35)  # a quarter in 20 s: the other 65 % take 52 s
    assert line.text(23.0) == "poincare_map:  35%, about 52 s left"
    with progress.Compiling.under_way():
        clock.time += 1000.0
    line.report(0.35)  # what was compiled between is no pace
    assert line.text(1023.0) == "poincare_map:  35%, about 52 s left"
    clock.time += 19.0
    assert ", about " in line.text(1042.0)
    clock.time += 2.0  # nothing was told for longer than all before took
    assert line.text(1044.0) == "poincare_map:  35%, 1044 s"


@pytest.mark.parametrize("seed", range(4))
def test_the_time_left_is_that_of_the_pace_of_late(clock, seed):
    """Of passes of random paces, each known to within a third by then; and of as many reports as a day has."""
    rng = np.random.default_rng(seed)
    times, shares = np.zeros(1), np.zeros(1)
    for end, seconds in zip((0.3, 0.6, 1.0), rng.uniform(100.0, 20_000.0, 3), strict=True):
        times = np.append(times, times[-1] + np.linspace(0.0, seconds, 400)[1:])
        shares = np.append(shares, np.linspace(shares[-1], end, 400)[1:])
        line = progress._Line("integrate")
        for clock.time, share in zip(times, shares, strict=True):
            line.report(share)
        assert len(line.marks) <= progress.MARKS + 1
        assert line.marks[-1] == (progress.computed(), shares[-1])
        late = times > times[-1] * 2 / 3
        pace = np.diff(shares[late]) / np.diff(times[late])
        left = progress.time_left(line.marks, progress.computed())
        assert (1 - end) / pace.max() * 0.97 <= left <= (1 - end) / pace.min() * 1.03
    assert progress.time_left([(0.0, 0.0)], 5.0) is None


@pytest.mark.parametrize("seed", range(5))
def test_passes_are_one_count(seed):
    """Of random works, some of which were not expected: each gets its share of what is left, and none falls."""
    rng, told = np.random.default_rng(seed), []
    works = rng.uniform(0.1, 5.0, 6)
    with Passes(told.append) as passes:
        for k, work in enumerate(works):
            begun = passes.end
            callback = passes.take(work, works[k + 1 :].sum())
            assert np.isclose(passes.end - begun, work / works.sum())  # all was expected: shares of the whole
            for fraction in (0.0, 0.5, 0.2, 1.0, 0.1):  # it may begin anew
                callback(fraction)
            assert told[-1] == passes.end
    assert told == sorted(told)
    assert told[-1] == 1.0
    with Passes(told.append) as passes:
        passes.take(1.0)(0.5)
        passes.take(1.0, 1.0)(1.0)  # more than was expected
        assert told[-1] == 1.0
    with pytest.raises(KeyboardInterrupt), Passes(told.append):
        raise KeyboardInterrupt
    assert Passes(None).take(1.0) is None


def test_orbits_of_one_portion_are_told_while_they_are_read():
    """And are the same orbits as where nobody is told."""
    body, told = fa.HenonHeiles(), []
    z0 = fa.energy_sample(body, energy=0.08, orbits=600, seed=1).z0
    found = fa.frequency_map(body, z0, time=100.0, threads=1, callback=told.append)
    assert max(np.diff([0.0, *told])) < 0.4
    assert told[-1] == 1.0
    silent = fa.frequency_map(body, z0, time=100.0, threads=2)
    for name in ("nu", "error", "classification", "diffusion"):
        np.testing.assert_array_equal(found[name], silent[name])


def test_orbits_that_end_early_are_done_then():
    """As a section's, far from max_time: by those that have ended, before these by what is expected."""
    ensemble, told = SimpleNamespace(count=np.zeros(4, int)), []
    flow = SimpleNamespace(adaptive=False, steps=lambda time: 10 * time)
    callback = early(told.append, flow, ensemble, 100.0, 0.2)
    callback(0.1)
    assert told[-1] == 0.5
    ensemble.count[1] = 100  # of 1000 steps
    callback(0.05)
    assert told[-1] == 0.5
    ensemble.count[:2] = 100, 300
    callback(0.15)
    assert told[-1] == pytest.approx(0.75)
    callback(0.3)
    assert told[-1] == 1.0
    assert early(None, flow, ensemble, 1.0) is None
    assert early(print, SimpleNamespace(adaptive=True), ensemble, 1.0) is print


@pytest.fixture
def kernel(monkeypatch, clock):
    """A compiler that takes the given time for a kernel."""
    for name in ("kernels", "depth", "seconds"):
        monkeypatch.setattr(progress.Compiling, name, 0)

    def compiled(seconds):
        with progress.Compiling.under_way(), progress.Compiling.under_way():  # of what it calls: the same time
            progress.Compiling.kernels += 1
            clock.time += seconds

    return compiled


@pytest.mark.parametrize("seed", range(3))
def test_time_of_compilation_is_counted_once(kernel, clock, seed):
    """From the beginning of a call, with that of a kernel under way, without that between kernels."""
    random = np.random.default_rng(seed)
    kernel(random.uniform(1.0, 9.0))  # of a call before
    call = progress.Compilation()
    seconds = random.uniform(0.1, 5.0, 4)
    assert not call.begins
    for taken in seconds:
        kernel(taken)
        clock.time += 100.0
    assert call.begins
    assert call.spent() == pytest.approx(seconds.sum())
    with progress.Compiling.under_way():
        clock.time += 7.0
        assert call.spent() == pytest.approx(seconds.sum() + 7.0)


def test_a_line_of_compilation(kernel):
    line = progress._Line("chaos_map")
    assert line.text(0.6) == ""
    kernel(7.0)
    assert line.text(0.4) == ""
    assert line.text(7.0) == "chaos_map: compiling once, 7 s"
    line.report(0.0)
    assert line.text(9.0) == "chaos_map: 9 s"  # it computes
    with progress.Compiling.under_way():
        assert line.text(9.0) == "chaos_map: compiling once, 7 s"


def looks(line, clock, seconds):
    """Let a line look once a second."""
    for _ in range(seconds):
        clock.time += 1.0
        line.look(clock.time - line.begun)


def test_a_compilation_of_seconds_is_logged_in_a_pipe(kernel, clock, caplog):
    """Once, and how long it took as soon as nothing more is compiled, not at the end of an hour of computing."""
    line = progress._LoggedLines("poincare_map", shares=False)
    kernel(progress.NOTICED - 1.0)
    looks(line, clock, 20)
    assert not caplog.records
    kernel(7.0)
    looks(line, clock, 2)
    said = [f"fastaff: poincare_map: {progress.COMPILING}"]
    assert caplog.messages == said
    assert caplog.records[0].name == "fastaff"
    assert caplog.records[0].levelno == logging.WARNING
    kernel(29.0)  # after a moment between two kernels
    with progress.Compiling.under_way():
        looks(line, clock, 2 * progress.SETTLED)
        assert caplog.messages == said
    looks(line, clock, progress.SETTLED)
    said.append(f"fastaff: poincare_map: compiled 3 kernels in {progress.NOTICED + 35 + 2 * progress.SETTLED:.0f} s")
    assert caplog.messages == said
    looks(line, clock, 3600)
    line.start()
    line.end()
    assert caplog.messages == said


def test_how_long_a_compilation_took_is_logged_at_the_end_of_a_call(kernel, clock, caplog):
    line = progress._LoggedLines("integrate", shares=False)
    kernel(12.0)
    looks(line, clock, 1)
    line.start()
    line.end()
    assert caplog.messages[1:] == ["fastaff: integrate: compiled 1 kernel in 12 s"]


def test_shares_in_a_pipe_are_whole_lines_and_few(clock, capsys):
    line = progress._LoggedLines("chaos_map", shares=True)
    line.report(0.0)
    for second in range(1, 101):
        line.report(second / 200)
        looks(line, clock, 1)
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 100 // int(progress.APART)
    assert all(re.fullmatch(r"fastaff: chaos_map: +\d+%, about \d+ (s|min) left", text) for text in told)


@pytest.mark.slow
def test_a_script_in_a_pipe_says_that_it_compiles_and_for_how_long(tmp_path):
    """With an empty cache, in its first process only."""
    code = (
        "import fastaff as fa; from fastaff.results import progress; progress.NOTICED = 0.0;"
        "print(fa.integrate(fa.HenonHeiles(), [0.1, 0.2, 0.3, 0.1], time=1.0, step=0.1).success)"
    )
    environment = {**os.environ, "FASTAFF_CACHE_DIR": str(tmp_path)}
    del environment["FASTAFF_PROGRESS"]
    for cold in (True, False):
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        assert done.stdout == "True\n"
        said = rf"fastaff: integrate: {progress.COMPILING}\nfastaff: integrate: compiled \d+ kernels in \d+ s\n"
        assert re.fullmatch(said if cold else "", done.stderr)


@pytest.mark.race
def test_a_command_says_that_it_compiles_and_for_how_long(capsys, monkeypatch):
    """In pipes, too; nothing where nothing is compiled."""
    monkeypatch.setattr(progress.Compiling, "kernels", 0)
    monkeypatch.setattr(progress._Shown, "wanted", None)
    monkeypatch.delenv("FASTAFF_PROGRESS")

    def compiles():
        with progress.Compiling.under_way():
            progress.Compiling.kernels += 2
            time.sleep(0.8)

    compiled(lambda: time.sleep(0.8))
    assert capsys.readouterr().err == ""
    compiled(compiles)
    assert capsys.readouterr().err == f"fastaff: {progress.COMPILING}\nfastaff: compiled 2 kernels in 1 s\n"
    compiled(compiles, announce=False)
    monkeypatch.setenv("FASTAFF_PROGRESS", "0")
    compiled(compiles)
    assert capsys.readouterr().err == ""


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


QUIET = {
    "fastaff": {"reduced_body", "show_progress", "univariate"},
    "fastaff.frequencies": {"diffusion_histogram"},
    "fastaff.periodic": {"periodic_guesses"},
    "fastaff.quantum": {
        *("count_deviation", "fit_spacings", "level_list", "mean_spacing_ratio", "number_variance", "polynomial_count"),
        *("shear_factor", "spacing_ratios", "spectrum_table", "unfold", "unitary_wave", "wavefunction"),
    },
    "fastaff.plot": {
        *("animate", "clipped", "colour_map", "colouring", "count_points", "diffusion_scale", "frequency", "on_line"),
        *("picked", "resonances_between", "styled", "symbol"),
    },
}
"""Public functions that take no long time, or whose time is that of another one of these rooms."""


def says(function):
    """Whether a call of a function is watched."""
    while function is not None and "watched" not in function.__code__.co_names:
        function = getattr(function, "__wrapped__", None)
    return function is not None


@pytest.mark.parametrize("room", QUIET)
def test_no_long_call_is_silent(room):
    found = importlib.import_module(room)
    functions = {name: entry for name in found.__all__ if inspect.isfunction(entry := getattr(found, name))}
    assert {name for name, function in functions.items() if not says(function)} == QUIET[room]


def test_a_fit_of_a_torus_tells_its_passes():
    """No share stands still for long, of tori and of orbits that are none; and the fit is the same."""
    for z, least in (([0.0, 0.1, 0.3, 0.2], 12), ([0.0, -0.1, 0.45, 0.2], 20)):
        told = []
        found = fa.fit_torus(fa.HenonHeiles(), z, time=300.0, callback=told.append)
        assert told == sorted(told)
        assert told[-1] == 1.0
        fitting = [0.5, *(share for share in told if 0.5 < share < 0.75), 0.75]
        assert len(fitting) > least / 2
        assert np.diff(fitting).max() < 0.13
        if found.classification != fa.Classification.REGULAR:
            assert any(0.75 < share < 1.0 for share in told)
        same = fa.fit_torus(fa.HenonHeiles(), z, time=300.0)
        np.testing.assert_array_equal(found.nu, same.nu)
