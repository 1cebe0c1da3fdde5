"""The entry point of the command line. It runs before the modules of the commands are loaded, for that takes a second
in which Ctrl-C may come.
"""

from __future__ import annotations

import os
import sys

from .. import __version__
from .stops import EXIT_BROKEN_PIPE, EXIT_INTERRUPTED, EXIT_WRONG_INPUT, Stops, on_stop, say


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 2 for wrong input, 130 after Ctrl-C, SIGTERM or SIGHUP, 141
    where nobody reads its output. Without arguments it takes those of the process, which ends with that code.
    """
    own = arguments is None
    if own:
        _opened()
    Stops.begin(own)
    with on_stop(Stops.handle, for_good=own):
        code = _ran(sys.argv[1:] if arguments is None else arguments)
    if own:
        sys.exit(code)
    return code


def _ran(arguments: list[str]) -> int:
    """Return the exit code; after an exception no signal raises another."""
    try:
        if arguments == ["--version"]:  # scripts ask for this: nothing is loaded for it
            Stops.loading = False
            print(__version__)
            code = 0
        else:
            from .application import answer

            Stops.loading = False
            code = answer(arguments)
        sys.stdout.flush()
        Stops.ended = True
    except KeyboardInterrupt:
        Stops.ended = True
        say(f"{Stops.said()}; nothing is kept but what is named above")
        code = EXIT_INTERRUPTED
    except SystemExit as left:
        Stops.ended = True
        code = int(left.code or 0)
    except BrokenPipeError:  # the reader, as head or less, has seen enough
        Stops.ended = True
        _unread()
        code = EXIT_BROKEN_PIPE
    except OSError as problem:
        Stops.ended = True
        _unread()
        failed = "the package cannot be loaded" if Stops.loading else "what this command prints cannot be written"
        say(f"error: {failed}: {' '.join(str(problem.strerror or problem).split())}")
        code = EXIT_WRONG_INPUT
    except MemoryError:
        Stops.ended = True
        say("error: there is not enough memory; a job (--write-job) takes it unit by unit (--memory)")
        code = EXIT_WRONG_INPUT
    Stops.code = code
    return code


def _opened() -> None:
    """Put the null device in the place of closed streams (`2>&-`): the next opened file would take their number, and
    the output that others write to them.
    """
    while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(handle, True)
    os.close(handle)
    for name, number, mode in (("stdin", 0, "r"), ("stdout", 1, "w"), ("stderr", 2, "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115
        elif mode == "w" and getattr(getattr(sys, name), "errors", "") == "strict":
            getattr(sys, name).reconfigure(errors="replace")  # frames of help and Greek letters, in ASCII


def _unread() -> None:
    """Send the output that is flushed at the end to the null device."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
