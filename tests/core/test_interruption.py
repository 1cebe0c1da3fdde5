"""Signals that come where what they raise would break more than the call: they wait until that is done.

Each is sent by the main thread to itself, so that it comes at a known place whatever other threads there are.
"""

import gc
import os
import signal
import subprocess
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from llvmlite.binding import ffi
from numba.core import event as events
from numba.core.compiler_lock import global_compiler_lock

from fastaff.core.interruption import defer_signals, imported, reraise_interrupt
from fastaff.engine import jit
from fastaff.jobs.guard import Hierarchy, Numbers

pytestmark = pytest.mark.skipif(not hasattr(signal, "raise_signal") or os.name != "posix", reason="signals of POSIX")


class Late(Exception):
    """What a handler raises."""


@pytest.fixture
def raising():
    """Handlers that raise, of three signals."""

    def handler(number, frame):
        raise Late(number)

    numbers = [signal.SIGINT, signal.SIGTERM, signal.SIGALRM]
    before = [signal.signal(number, handler) for number in numbers]
    yield handler
    for number, taken in zip(numbers, before, strict=True):
        signal.signal(number, taken)


def handlers():
    return {number: signal.getsignal(number) for number in signal.valid_signals()}


def test_a_signal_waits_for_the_end_of_the_block(raising):
    before, seen = handlers(), []

    @defer_signals()
    def block():
        signal.raise_signal(signal.SIGTERM)
        seen.append("done")

    with pytest.raises(Late):
        block()
    assert seen == ["done"]
    assert handlers() == before


def test_what_the_block_raises_is_passed_on(raising):
    before = handlers()

    @defer_signals()
    def block(number):
        signal.raise_signal(number)
        raise KeyError

    with pytest.raises(KeyError):
        block(0)
    with pytest.raises(Late) as raised:
        block(signal.SIGINT)
    assert isinstance(raised.value.__context__, KeyError)
    assert handlers() == before


def test_each_signal_has_its_handler_whatever_others_raise(raising):
    before, seen = handlers(), []
    signal.signal(signal.SIGTERM, lambda number, frame: seen.append((number, frame is None)))

    @defer_signals()
    def block():
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):
            signal.raise_signal(number)

    with pytest.raises(Late):
        block()
    assert seen == [(signal.SIGTERM, False)]
    signal.signal(signal.SIGTERM, raising)
    assert handlers() == before


def test_a_block_takes_signals_when_it_suits(raising):
    before, seen = handlers(), []

    def block():
        with defer_signals() as take:
            take()
            signal.raise_signal(signal.SIGTERM)
            thread = threading.Thread(target=take)
            thread.start()
            thread.join()
            seen.append("waits")
            take()
            seen.append("never")

    with pytest.raises(Late):
        block()
    assert seen == ["waits"]
    assert handlers() == before


def test_blocks_within_blocks_and_ignored_signals(raising):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    before, seen = handlers(), []
    with defer_signals():
        signal.raise_signal(signal.SIGINT)

    @defer_signals()
    def block():
        with defer_signals():
            signal.raise_signal(signal.SIGALRM)
        seen.append("outer")

    with pytest.raises(Late):
        block()
    assert seen == ["outer"]
    assert handlers() == before


def test_other_threads_change_no_handlers(raising):
    found, before = [], handlers()

    def work():
        with defer_signals():
            found.append(handlers())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [before]


def test_handlers_are_back_whatever_comes_while_they_are_put_back(raising, monkeypatch):
    before, put = handlers(), signal.signal

    def put_back(number, handler):
        put(number, handler)
        if handler is raising:
            signal.raise_signal(number)

    monkeypatch.setattr("fastaff.core.interruption.signal.signal", put_back)
    with pytest.raises(Late), defer_signals():
        pass
    assert handlers() == before


def locked():
    """What Ctrl-C becomes in a lock that is not held any more."""
    try:
        raise KeyboardInterrupt
    finally:
        threading.Lock().release()


def test_ctrl_c_of_which_others_make_another_exception():
    with pytest.raises(RuntimeError):
        locked()
    with pytest.raises(KeyboardInterrupt) as stopped:
        reraise_interrupt()(locked)()
    assert stopped.value.__suppress_context__
    with pytest.raises(RuntimeError, match="other"):
        reraise_interrupt()(other)()


def test_ctrl_c_that_was_dealt_with_is_none():
    """Who runs it again, where Ctrl-C was caught, is told of what goes wrong now."""
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt:
        with pytest.raises(RuntimeError, match="other"):
            reraise_interrupt()(other)()
        with pytest.raises(KeyboardInterrupt):
            reraise_interrupt()(locked)()


def test_a_module_is_loaded_whole(raising, tmp_path, monkeypatch):
    (tmp_path / "halves.py").write_text("import signal\nsignal.raise_signal(15)\nboth = 'halves'\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(Late):
        imported("halves")
    assert sys.modules.pop("halves").both == "halves"


def other():
    try:
        raise ValueError
    except ValueError:
        raise RuntimeError("other")  # noqa: B904


def test_ctrl_c_in_the_locks_of_a_store_is_no_damage(tmp_path):
    class Locked:
        def with_config(self, _):
            return self

        metadata = SimpleNamespace(dimension_names=("orbit",), encode_chunk_key=lambda _: "none")
        shape = chunks = (1,)
        ndim = 1
        dtype = np.dtype(float)

        def __getitem__(self, _):
            locked()

        def __setitem__(self, *_):
            locked()

    numbers = Numbers(tmp_path, "a", Locked())
    with pytest.raises(KeyboardInterrupt):
        numbers[...]
    with pytest.raises(KeyboardInterrupt):
        numbers[...] = 1.0
    with pytest.raises(KeyboardInterrupt):
        Hierarchy(tmp_path, Locked())["a"]


def compiled_anew():
    """A function that no other call has compiled."""
    return jit.BlockFunction(lambda x: np.sin(x) + x, "float64(float64)", cache=False)


@pytest.mark.skipif(jit.JIT_DISABLED, reason="no compiler")
@pytest.mark.parametrize("name", ["translate_bytecode", "nopython_type_inference", "native_lowering"])
def test_a_signal_in_the_compiler_waits_for_its_next_pass(name, raising):
    class Sends(events.Listener):
        seen = ()

        def on_start(self, event):
            self.seen = (*self.seen, event.data["name"])

        def on_end(self, event):
            if event.data["name"].startswith(name) and "sent" not in self.seen:
                signal.raise_signal(signal.SIGTERM)
                self.seen = (*self.seen, "sent")

    before, listens = handlers(), Sends()
    with events.install_listener("numba:run_pass", listens), pytest.raises(Late):
        compiled_anew()
    assert listens.seen[-2] == "sent"  # behind it one pass, in which it was taken
    assert gc.isenabled()
    assert handlers() == before
    free = []

    def others():
        for lock in (ffi.lib._lock._lock, global_compiler_lock._lock):
            free.append(lock.acquire(timeout=60.0))
            lock.release()

    thread = threading.Thread(target=others)
    thread.start()
    thread.join()
    assert free == [True, True]
    assert compiled_anew().__wrapper_address__() != 0


LOADER = """
import os, signal, sys

number, seen, figure = int(sys.argv[1]), 0, "figure" in sys.argv

def watch(event, given):
    global seen
    if event == "import":
        seen += 1
        if seen == number:
            signal.raise_signal(signal.SIGINT)

import fastaff as fa

def use():
    if figure:
        return len(points.plot()) > 0
    fa.quantum
    return fa.integrate is not fa.quantum.spectrum

if figure:
    import numpy as np

    points = fa.frequencies.naff.FrequencyLines(*np.ones((3, 1, 2)), np.zeros(1))
    fa.plot
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    sys.addaudithook(watch)
    use()
    print("not interrupted", seen)
except KeyboardInterrupt:
    print("interrupted", use())
"""
"""The first use of a name or figure, with Ctrl-C at the n-th module that is looked for."""


@pytest.mark.parametrize("what", ["name", "figure"])
def test_ctrl_c_while_modules_are_loaded(what):
    """Without `defer_signals` later uses fail for good: partially initialized modules, or some that load but once."""

    def run(number):
        command = [sys.executable, "-c", LOADER, str(number), what]
        environment = {**os.environ, "MPLBACKEND": "agg"}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout.split()

    count = int(run(-1)[-1])
    assert count > 100
    for number in (count // 3, count // 2, 3 * count // 4):
        assert run(number) == ["interrupted", "True"]
