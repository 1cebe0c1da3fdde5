"""Commands that are stopped at any moment of their life: while Python loads what they need, while they compute, while
the interpreter ends; by one signal or by several in a row.

Moments are counted in modules that are looked for, not in seconds.
"""

import random
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from thorough import TIMES

import fastaff as fa
from fastaff import files

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="signals of POSIX")

SCRIPT = """
import os, signal, sys

number, delay, *sent = (float(word) for word in sys.argv.pop(1).split(","))
seen = -1  # nothing is counted until the command line is entered

def send(*_):
    for one in sent:
        os.kill(os.getpid(), int(one))

def watch(event, given):
    global seen
    if event == "import" and (seen >= 0 or given[0] == "fastaff.cli.application"):
        seen += 1
        if seen == number:
            send() if delay == 0.0 else signal.setitimer(signal.ITIMER_REAL, delay)
    if event == "told":
        os.write(3, str(seen).encode())

signal.signal(signal.SIGALRM, send)
sys.addaudithook(watch)
from fastaff.cli.main import main
try:
    main()
finally:
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    sys.audit("told")
"""
"""The script that pip installs, with signals sent at the number of a module, or a delay after it."""

NAMED = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM", signal.SIGHUP: "SIGHUP"}
"""What a command says that it was stopped by."""

ENDS = ["poincare", "--energy", "nan"]
"""A command that loads all that a computation does and computes nothing."""


def stopped(words, cwd, number=-1, delay=0.0, sent=()):
    """Run a command; return its exit code, what it said and the number of modules it looked for."""
    with open(cwd / "count", "w+b") as count:
        moment = ",".join(map(str, (number, delay, *map(int, sent))))
        code = f"import os; os.dup2({count.fileno()}, 3)\n{SCRIPT}"
        done = subprocess.run(
            [sys.executable, "-c", code, moment, *words],
            pass_fds=[count.fileno()],
            cwd=cwd,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        count.seek(0)
        return done.returncode, done.stderr, int(count.read() or -1)


@pytest.mark.race
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=lambda sent: sent.name)
def test_a_signal_while_python_loads_the_package_is_one_line(sent, tmp_path):
    code, said, count = stopped(ENDS, tmp_path)
    assert code == 2, said
    assert count > 300
    source = random.Random(int(sent))
    for _ in range(3 * TIMES):
        number, delay = source.randrange(count), source.choice([0.0, source.uniform(1e-4, 0.02)])
        code, said, _ = stopped(ENDS, tmp_path, number, delay, [sent])
        if code == 2:  # it had ended, or did in the import in which the signal had to wait
            assert said.startswith("fastaff: error: Invalid value for --energy"), (number, delay)
        else:
            assert (code, len(said.splitlines())) == (130, 1), (number, delay, said)
            assert re.match(rf"fastaff: stopped by {NAMED[sent]}[ ;]", said), (number, delay, said)


COMPUTING = """
import os, signal, sys, threading
from fastaff.cli import main, progress, stops

def storm(*_):
    for _ in range(20):
        for one in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
            os.kill(os.getpid(), one)

def part(self, fraction):
    if fraction >= 0.5 and not part.sent:
        part.sent = True
        storm()

part.sent = False
progress.TerminalProgress.__call__ = part
exit = progress.TerminalProgress.__exit__
def leave(self, *problem):
    if problem[0] is not None:
        storm()  # while what the first has stopped is handed over
    exit(self, *problem)
progress.TerminalProgress.__exit__ = leave
say = stops.say
def told(text):
    say(text)
    if part.sent:
        storm()
progress.say = main.say = told
main.main()
"""
"""A command that is stopped in the middle, with more signals at each of the next things it does."""


@pytest.mark.race
def test_signals_in_a_row_are_one(tmp_path):
    run = ["poincare", "--model", "henon-heiles", "--energy", "0.1", "--grid", "60x60", "--crossings", "1500"]
    run += ["--no-diffusion", "--step", "0.05", "--out", "x"]
    command = [sys.executable, "-c", COMPUTING, *run]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 130, done.stderr
    assert "Traceback" not in done.stderr
    found = files.load(tmp_path / "x.npz")
    finished = np.count_nonzero(found.status == fa.Status.OK)
    assert 0 < finished < found.status.size
    assert f"stopped by SIGHUP: kept {finished} finished of " in done.stderr  # the first one
    assert [path.name for path in tmp_path.iterdir()] == ["x.npz"]


ENDING = """
import threading, time
from fastaff.cli import main, stops

def late():
    while stops.Stops.code is None:
        time.sleep(0.01)
    time.sleep(0.5)  # the interpreter waits by then; Python takes no signal that comes just before it does
    print("ended", flush=True)
    threading.Event().wait()  # for which the interpreter waits, too

threading.Thread(target=late).start()
main.main()
"""
"""A command whose interpreter would never end, and is stopped when all is done."""


@pytest.mark.race
@pytest.mark.parametrize(("words", "code"), [(["--version"], 0), (ENDS, 2)])
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM], ids=lambda sent: sent.name)
def test_a_signal_when_all_is_done_changes_nothing(sent, words, code):
    command = [sys.executable, "-c", ENDING, *words]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.stdout.readline() not in ("ended\n", ""):
        pass
    process.send_signal(sent)  # one: of two the kernel may wake another thread, to which Python does not listen
    _, said = process.communicate(timeout=600)
    assert process.returncode == code, said
    assert "Traceback" not in said
    assert "stopped" not in said


GROUP = """
import multiprocessing.util, os, signal, sys, time

def begin():
    from fastaff.cli.main import main

    spawn, seen = multiprocessing.util.spawnv_passfds, []
    number, delay, sent = (float(word) for word in sys.argv.pop(1).split(","))

    def spawned(*given):
        child = spawn(*given)
        seen.append(child)
        if len(seen) == number:
            if delay == 0.0:  # while the process is being started
                os.killpg(0, int(sent))
                time.sleep(0.05)
            else:
                signal.setitimer(signal.ITIMER_REAL, delay)
        return child

    multiprocessing.util.spawnv_passfds = spawned
    signal.signal(signal.SIGALRM, lambda *_: os.killpg(0, int(sent)))
    try:
        main()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)

if __name__ == "__main__":
    begin()
"""


@pytest.mark.race
@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=lambda sent: sent.name)
def test_workers_are_stopped_by_their_parent_alone(sent, tmp_path):
    """A terminal sends to all of them, at any moment of their beginning."""
    (tmp_path / "group.py").write_text(GROUP)
    (tmp_path / "a.toml").write_text(
        'chunk = 20\n[model]\nmodel = "henon-heiles"\n[energy_surface]\nenergy = 0.1\n'
        '[initial_conditions]\ngrid = "30x30"\n[frequency_map]\ntime = 500\n'
    )
    source = random.Random(int(sent))
    for delay in (0.0, 0.0, *(source.uniform(1e-3, 3.0) for _ in range(2 * TIMES))):
        moment = f"{source.choice([2, 3])},{delay},{int(sent)}"  # the first is of multiprocessing
        done = subprocess.run(
            [sys.executable, "group.py", moment, "run", "a.toml", "--workers", "2", "--quiet", "--overwrite"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=300,
            start_new_session=True,
            check=False,
        )
        assert done.returncode in (0, 130), (moment, done.stderr)
        assert "Traceback" not in done.stderr, moment
        assert done.returncode == 0 or "points are still to be computed" in done.stderr, moment


def test_the_command_line_is_a_module_too(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "fastaff", "--version"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, f"{fa.__version__}\n")
