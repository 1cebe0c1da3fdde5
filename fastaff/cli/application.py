"""The list of commands, and the handling of errors.

Parsing and help are by cyclopts, progress by rich; matplotlib is imported when a figure is drawn. Each command is
a module of `fastaff.cli.commands`.
"""

from __future__ import annotations

import inspect
import itertools
import os
import shlex
import sys
from typing import Any

from ..core.interruption import EXTRAS, extra_of
from ..jobs.job import OPTIONS
from ..jobs.wording import as_flag, respelled, spelled
from .commands.animate import animate
from .commands.cache import cache
from .commands.demo import demo
from .commands.doctor import doctor
from .commands.explore import explore
from .commands.jobs import rerun, resume, run, status
from .commands.orbits import chaos_map, frequencies, poincare
from .commands.plot import plot
from .commands.spectrum import energy_levels
from .commands.warmup import warmup
from .options import HELP, Parameter, converted, cyclopts
from .stops import EXIT_WRONG_INPUT, Stops, say

NARROWEST = 40
"""Least columns of text on a terminal that help and progress bars take."""

WIDEST = 1000
"""Most columns of text on a terminal that help and progress bars take."""

COMMANDS: dict[str, Any] = {
    "demo": demo,
    "poincare": poincare,
    "frequency-map": frequencies,
    "chaos-map": chaos_map,
    "spectrum": energy_levels,
    "run": run,
    "resume": resume,
    "rerun": rerun,
    "status": status,
    "plot": plot,
    "animate": animate,
    "warmup": warmup,
    "cache": cache,
    "doctor": doctor,
    "explore": explore,
}
NO_EXTRAS = (
    'fastaff: commands but "fastaff explore" need cyclopts and rich, figures need matplotlib: pip install '
    '"fastaff[demo]"'
)


def _columns(width: str) -> str:
    """Return a number of columns in which help and progress bars come to an end: neither none nor millions."""
    if not width.isdecimal():
        return str(NARROWEST)
    digits = width.lstrip("0")
    return str(WIDEST if len(digits) > len(str(WIDEST)) else min(max(int(digits or "0"), NARROWEST), WIDEST))


def answer(arguments: list[str]) -> int:
    """Run a command line and return its exit code; an error is one line."""
    if cyclopts is None:
        return _answer_without_extras(arguments)
    if width := os.environ.get("COLUMNS", ""):
        os.environ["COLUMNS"] = _columns(width)
    try:
        with spelled(as_flag):
            return int(app()(arguments, exit_on_error=False, print_error=False, result_action="return_value") or 0)
    except cyclopts.UnusedCliTokensError as problem:
        word = (problem.unused_tokens or ("",))[0]
        _refuse(f"{word!r} belongs to no option: each takes one value after its name, as in --energy 1.5", arguments)
    except cyclopts.MissingArgumentError as problem:
        _refuse(_missing(problem, arguments), arguments)
    except cyclopts.CycloptsError as problem:
        _refuse(problem, arguments)
    except ModuleNotFoundError as problem:
        missing = (problem.name or "").partition(".")[0]
        if missing in ("matplotlib", "cyclopts", "rich"):
            print(NO_EXTRAS, file=sys.stderr)
        elif missing in EXTRAS:
            install = extra_of(missing)
            _fail(_one_line(problem if install in str(problem) else f"this command needs {missing}: {install}"))
        else:
            raise
    except BrokenPipeError:
        raise
    except (ValueError, TypeError, OSError, ImportError) as problem:
        own = inspect.signature(COMMANDS[arguments[0]]).parameters if arguments[0] in COMMANDS else ()
        with spelled(as_flag):
            _fail(_one_line(respelled(str(problem), OPTIONS.union(own))))
    return EXIT_WRONG_INPUT


def _answer_without_extras(arguments: list[str]) -> int:
    """Write the explorer, which needs no further package; for other commands name the packages."""
    if arguments[:1] == ["explore"] and set(arguments[1:]) <= {"--open"}:
        return explore(open_page="--open" in arguments)
    print(NO_EXTRAS, file=sys.stderr)
    return EXIT_WRONG_INPUT


def _missing(problem: Any, arguments: list[str]) -> str:
    """Say that an option has no value; where a word behind its name begins like another option, how to write it."""
    option = problem.keyword or problem.argument.name
    behind = next((b for a, b in itertools.pairwise(arguments) if a == option and b.startswith("-")), None)
    if option not in arguments:
        return f"{option} is required"
    said = f"{option} takes a value"
    if behind is not None and not behind.startswith("--"):
        said += f"; one that begins with - is written behind an equals sign: {option}={shlex.quote(behind)}"
    return said


def _refuse(problem: Any, arguments: list[str]) -> None:
    """Report an error in the words of a command, and the command that lists those it takes."""
    command = [word for word in arguments[:1] if word in COMMANDS]
    _fail(f"{_one_line(problem)}  ({' '.join(['fastaff', *command, '--help'])})")


def _fail(problem: str) -> None:
    """Print the error in one line, as the last one: a signal that comes now prints nothing more."""
    Stops.ended = True
    say(f"error: {problem}")


def _one_line(problem: Any) -> str:
    return " ".join(str(problem).split())


def app() -> Any:
    """Return the commands as cyclopts takes them."""
    from .. import __version__

    whole = cyclopts.App(
        name="fastaff",
        version=__version__,
        help_format="markdown",
        suppress_keyboard_interrupt=False,
        help=HELP,
        default_parameter=Parameter(negative="", show_default=False, converter=converted),
    )
    for name, command in COMMANDS.items():
        whole.command(command, name=name)
    whole.register_install_completion_command(help="Install completion of commands and options in this shell.")
    return whole
