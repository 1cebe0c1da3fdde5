"""`fastaff demo`: the demonstration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...results.progress import COMPILING, asked, silent
from ..options import Output
from ..progress import TerminalProgress, is_cold
from ..stops import Stops, on_stop, say


def demo(
    *, out: Path = Path("fastaff-demo"), quick: bool = False, threads: int | None = None, overwrite: bool = False
) -> int:
    """Compute and draw the demonstration: a neo-Hookean body with islands and chaos, and an integrable one beside it.

    About 15 s on two cores, and about 30 s of compilation the first time.

    Parameters
    ----------
    out
        Folder for the figure and the data, made if missing. [fastaff-demo]
    quick
        A small version in seconds.
    threads
        Threads. [all cores]
    overwrite
        Replace earlier files instead of numbering the new ones.
    """
    Output().check()
    from .. import demonstration

    bars: list[TerminalProgress] = []

    def meter(title: str) -> Any:
        for bar in bars:
            bar.__exit__()
        bars[:] = [TerminalProgress(title).__enter__()]
        return bars[0]

    def leave(*_: Any) -> None:
        for bar in bars:
            bar.__exit__()
        Stops.leave("before the end, when the demo writes its files")

    if is_cold() and asked() is not False:
        say(COMPILING)
    try:
        with on_stop(leave), silent():
            demonstration.run(out, quick, threads=threads, meter=meter, overwrite=overwrite)
    finally:
        for bar in bars:
            bar.__exit__()
    return 0
